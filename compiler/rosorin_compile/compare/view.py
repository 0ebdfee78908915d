"""Views: what artifacts say, brought into one form, so that the same thing has the same name in each of them.

A view is made of the facts of one artifact (``Format.facts``). Rotations stay together, because one number of three
means little; so do shapes, because their numbers in an artifact mean nothing, and the cells of a height map.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import isfinite
from typing import NamedTuple

from rosorin_compile.formats import FORMATS, Artifact, Fact, Facts, Value
from rosorin_compile.formats.facts import AXES, Solid
from rosorin_compile.formats.format import ANGLES
from rosorin_compile.model import Robot, Transform
from rosorin_compile.model.geometry import rotation_of_rpy
from rosorin_compile.source.memo import remembered

from .solids_old import solid_of
from .tolerance import Turn

# Patterns are made where something may fit: most quantities are told apart by a word.
_SHAPE = r"(collision|visual) (\d+) (.+)"
_PURPOSES = ("collision ", "visual ")
_CELL = r"cell (\d+) (\d+)"
# A frame with several rows in the list of frames: the row is part of its name.
_ROW = r"(.+?) ((?:below|when) .+)"


class View(NamedTuple):
    """What one artifact says: plain facts, rotations by frame, solids by link and purpose, heights by frame and cell.

    ``names`` are all frames and links that it speaks of.
    """

    plain: Facts
    turns: Mapping[str, Turn]
    shapes: Mapping[tuple[str, str], tuple[Solid, ...]]
    heights: Mapping[str, Mapping[tuple[int, int], float]]
    names: frozenset[str]

    def parent(self, frame: str) -> str:
        """Return the frame that a frame sits in; empty if the view does not know it."""
        return self.text("frame", frame, "parent")

    def parents(self) -> dict[str, str]:
        """Return the frames that frames sit in, by name."""
        parents = (pair for pair in self.plain.items() if pair[0][2] == "parent" and pair[0][0] == "frame")
        return {fact[1]: str(value[0]) for fact, value in parents}

    def text(self, kind: str, name: str, quantity: str) -> str:
        """Return the value of a fact as text; empty if there is none."""
        found = self.plain.get(Fact(kind, name, quantity))
        return str(found.value) if found else ""


def view_of(facts: Facts, names: Mapping[str, str]) -> View:
    """Return the view of an artifact; ``names`` are names of links in it that the robot calls otherwise.

    Raises ValueError if a name is no text, or a value neither text nor a finite number: the artifact is damaged.
    """
    plain: Facts = {}
    turns: dict[str, dict[str, Value]] = {}
    shapes: dict[tuple[str, str, int], dict[str, Value]] = {}
    heights: dict[str, dict[tuple[int, int], float]] = {}
    for written, value in facts.items():
        _check(written, value)
        kind, name, quantity = fact = written
        part = _part(kind, quantity)
        if names or (part is not None and part[0] == _ROWS):
            fact, value = _named(written, value, names)
            kind, name, quantity = fact
            part = _part(kind, quantity)
        if part is None:
            plain[fact] = value
        elif part[0] == _TURN:
            turns.setdefault(name, {})[quantity] = value
        elif part[0] == _SOLID:
            shapes.setdefault((name, part[1], part[2]), {})[part[3]] = value
        elif part[0] == _HEIGHT and isinstance(value.value, float):
            heights.setdefault(name, {})[part[2], int(part[3])] = value.value
        elif part[0] != _COUNT:
            plain[fact] = value
    found: dict[tuple[str, str], list[Solid]] = {}
    for name, purpose, number in sorted(shapes):
        found.setdefault((name, purpose), []).append(solid_of(shapes[name, purpose, number]))
    solids = {key: tuple(several) for key, several in found.items()}
    return View(plain, {name: _turn(angles) for name, angles in turns.items()}, solids, heights, _names(plain, solids))


# What is not plain: an angle, a property of a shape, how many shapes there are, a cell, a frame of several rows.
_TURN, _SOLID, _COUNT, _HEIGHT, _ROWS = range(5)


# The same quantities are said of each frame and link.
@remembered
def _part(kind: str, quantity: str) -> tuple[int, str, int, str] | None:
    """Return what a quantity is a part of, and which; None if it is plain."""
    if kind == "frame":
        if quantity in ANGLES:
            return (_TURN, "", 0, "")
        return (_ROWS, "", 0, "") if _row(quantity) else None
    if kind == "link":
        if quantity in ("collision shapes", "visual shapes"):
            return (_COUNT, "", 0, "")
        shape = re.fullmatch(_SHAPE, quantity) if quantity.startswith(_PURPOSES) else None
        if shape:
            return (_SOLID, shape[1], int(shape[2]), shape[3])
        return (_SOLID, "collision", 1, quantity) if quantity.startswith("box ") else None
    cell = re.fullmatch(_CELL, quantity) if kind == "height map" else None
    return (_HEIGHT, "", int(cell[1]), cell[2]) if cell else None


def _row(quantity: str) -> re.Match[str] | None:
    return re.fullmatch(_ROW, quantity) if " below " in quantity or " when " in quantity else None


def _check(fact: Fact, value: Value) -> None:
    said = value.value
    sound = isfinite(said) if isinstance(said, float) else isinstance(said, str)
    kind, name, quantity = fact
    if not (sound and isinstance(kind, str) and isinstance(name, str) and isinstance(quantity, str)):
        raise ValueError(f"{' '.join(map(str, fact))} is {said!r}")


def _named(fact: Fact, value: Value, names: Mapping[str, str]) -> tuple[Fact, Value]:
    """Return a fact under the names that the robot uses; a frame of several rows gets the row as part of its name."""
    kind, name, quantity = fact
    if kind in ("frame", "link", "height map"):
        name = names.get(name, name)
    if quantity in ("parent", "child") and isinstance(value.value, str):
        value = value._replace(value=names.get(value.value, value.value))
    row = _row(quantity) if kind == "frame" else None
    if row:
        name, quantity = f"{name} {row[2]}", row[1]
    return Fact(kind, name, quantity), value


def turn_of(found: Mapping[str, Value]) -> Turn | None:
    """Return the rotation that is among what is said of a frame; None if none is."""
    return _turn(found) if ANGLES[0] in found else None


def _turn(found: Mapping[str, Value]) -> Turn:
    values = [found.get(angle, Value(0.0)) for angle in ANGLES]
    roll, pitch, yaw = (float(value.value) for value in values)
    a, b, c = (value.tolerance for value in values)
    return Turn((roll, pitch, yaw), (a, b, c))


def _names(plain: Facts, solids: Mapping[tuple[str, str], tuple[Solid, ...]]) -> frozenset[str]:
    links = {fact.name for fact in plain if fact.kind in ("frame", "link")} | {link for link, _ in solids}
    parents = {str(value.value) for fact, value in plain.items() if fact.kind == "frame" and fact.quantity == "parent"}
    return frozenset(links | parents)


def called(robot: Robot, artifact: Artifact) -> Mapping[str, str]:
    """Return the robot's names of links by the names that an artifact has for them."""
    names = FORMATS[artifact.backend].proving.names
    output = next((output for output in robot.outputs if output.name == artifact.output), None)
    return {} if names is None or output is None else names(output)


def joints_called(robot: Robot, artifact: Artifact) -> Mapping[str, str]:
    """Return the robot's names of joints by the names that an artifact has for them."""
    names = FORMATS[artifact.backend].proving.joint_names
    return {} if names is None else names(robot)


def named_as(facts: Facts, joints: Mapping[str, str]) -> Facts:
    """Return facts with the robot's names of joints, by the names that the artifact has for them."""
    if not joints:
        return facts
    found: Facts = {}
    for fact, value in facts.items():
        if fact.kind == "joint":
            fact = fact._replace(name=joints.get(fact.name, fact.name))
            if fact.quantity == "mimic joint":
                value = value._replace(value=joints.get(str(value.value), value.value))
        found[fact] = value
    return found


def transform_of(view: View, frame: str) -> Transform:
    """Return where a frame sits in its parent, as a view has it."""
    values = [view.plain.get(Fact("frame", frame, f"origin {axis}"), Value(0.0)).value for axis in AXES]
    x, y, z = map(float, values)
    turn = view.turns.get(frame)
    return Transform(rotation_of_rpy(turn.rpy) if turn else Transform().rows, (x, y, z))

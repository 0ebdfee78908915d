"""Changes: differences between leaves in words, each with the artifacts that show it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.model import Joint, Pose, Robot
from rosorin_compile.model.joint import MOVING_TYPES, SEVERAL_COORDINATES

from .precision import NOISE, POSE_NOISE, ROOT_THREE, TURNS, Precision, exact, joined
from .sentences import (
    NEW,
    REMOVED,
    About,
    Row,
    Sentence,
    axis_change,
    cells_change,
    centre_change,
    colour_change,
    existence,
    inertia_change,
    mimic_text,
    near_angles,
    placed,
    set_change,
    value_change,
)
from .walk import Address, Difference, Leaves, known_inertia, same_turn

MOVING = (*MOVING_TYPES, *SEVERAL_COORDINATES)
# The order of the lines about one thing.
_QUANTITIES = (
    *("", "parent", "publisher", "topic", "type", "child", "origin", "axis", "limit lower", "limit upper", "limit"),
    *("damping", "friction"),
    *("armature", "mimic", "kp", "kv", "ctrl", "heights", "cell", "base", "mass", "centre", "inertia", "collision"),
    *("visual", "site", "contact"),
)
_KINDS = {"frame": 0, "joint": 0, "link": 0, "height map": 0, "servo": 1, "pose": 2}
# Units of numbers by the last word of their quantity: of a joint that turns, of one that slides.
_POSITION = ("rad", "m")
_UNITS = {
    "damping": ("N*m*s/rad", "N*s/m"),
    "friction": ("N*m", "N"),
    "armature": ("kg*m^2", "kg"),
    "stiffness": ("N*m/rad", "N/m"),
    "kp": ("N*m/rad", "N/m"),
    "kv": ("N*m*s/rad", "N*s/m"),
    "effort": ("N*m", "N"),
    "velocity": ("rad/s", "m/s"),
    "k position": ("1/s", "1/s"),
    "k velocity": ("N*m*s/rad", "N*s/m"),
    **dict.fromkeys(("lower", "upper", "offset", "rising", "falling", "spring reference"), _POSITION),
    **dict.fromkeys(("reference position", "soft lower limit", "soft upper limit"), _POSITION),
}


class Change(NamedTuple):
    """One difference: what it is about, in words and as a row of a table, and the artifacts that show it.

    ``quantity`` is empty where the thing itself is new or gone. ``therefore`` are links whose shapes and masses differ
    for no other reason. ``differences`` are the leaves that it tells of.
    """

    kind: str
    name: str
    quantity: str
    text: str
    remark: str
    row: Row
    artifacts: tuple[str, ...] = ()
    therefore: tuple[str, ...] = ()
    differences: tuple[Difference, ...] = ()

    def words(self) -> str:
        """Return the change in words, with what is remarked."""
        remarks = [self.remark] if self.remark else []
        if self.therefore:
            remarks.append(f"and therefore the shapes of {', '.join(self.therefore)}")
        return str(Sentence(self.text, "; ".join(remarks), self.row))

    def line(self) -> str:
        """Return the change as one line of plain text."""
        return f"{self.words()}: {', '.join(self.artifacts)}"


def unit_of(joint: Joint | None, quantity: str) -> str:
    """Return the unit of a number of a joint, by its quantity ("limit lower", "kp"); empty for a bare number."""
    words = quantity.split(" ")
    found = next((_UNITS[end] for at in range(len(words)) if (end := " ".join(words[at:])) in _UNITS), ("", ""))
    return found[joint is not None and joint.type == "prismatic"]


def about(address: Address) -> About:
    """Return what a sentence about a leaf begins with."""
    kind, name, quantity = address
    if kind == "frame" and quantity in ("publisher", "topic"):
        return About(name, "published by" if quantity == "publisher" else quantity, ": ")
    if kind in ("frame", "joint", "link") or kind == name:
        return About(name, quantity)
    if kind == "pose":
        return About(f"pose {name}", quantity, ": ")
    if kind == "height map":
        return About(name, f"height map {quantity}")
    return About(f"{kind} {name}", quantity)


class Describer:
    """Describes differences of leaves, under the names of a robot.

    ``sides`` are the leaves of both values; ``precisions`` are how well their numbers are known.
    """

    def __init__(
        self,
        robot: Robot,
        sides: tuple[Leaves, Leaves],
        precisions: tuple[Precision, Precision] = (exact, exact),
        tolerance: float = NOISE,
    ) -> None:
        self.robot = robot
        self.sides = sides
        self.precisions = precisions
        self.tolerance = tolerance

    def describe(self, differences: Sequence[Difference]) -> Iterator[tuple[Difference, Sentence]]:
        """Yield a sentence for each difference but those of shapes; some tell of several leaves."""
        quantities = {one.address for one in differences}
        for one in differences:
            kind, name, quantity = one.address
            leader = Address(kind, name, "mimic joint")
            if quantity in ("mimic multiplier", "mimic offset") and leader in quantities:
                continue
            if quantity in ("centre of mass", "inertia") and None in (one.old, one.new):
                continue  # the mass says it
            yield one, self.sentence(one)

    def sentence(self, one: Difference) -> Sentence:
        """Return a difference in words."""
        kind, name, quantity = one.address
        old, new = one.old, one.new
        if not quantity and not isinstance(old, frozenset) and not isinstance(new, frozenset):
            return self._existence(one)
        if isinstance(old, frozenset) or isinstance(new, frozenset):
            return set_change(" ".join(filter(None, (kind, quantity))), old or (), new or ())
        if quantity == "mimic joint":
            texts = [self._mimic(name, side) for side in (0, 1)]
            row = Row(name, "mimics", *texts)
            return Sentence(f"{name} mimics {texts[0]} -> {texts[1]}", "", row)
        if old is not None and new is not None:
            if isinstance(old, Pose) and isinstance(new, Pose) and kind == "frame":
                return self._placed(name, old, new)
            if quantity == "axis":
                return axis_change(name, old, new)
            if quantity == "centre of mass":
                return centre_change(name, old, new, self._known("xyz", old, new) + self.tolerance)
            if quantity == "inertia":
                return inertia_change(name, old, new, known_inertia(old, new, self.precisions, self.tolerance))
            if quantity == "heights":
                return cells_change(name, old, new)
        if quantity == "rgba":
            return colour_change(About(f"{kind} {name}", ""), old, new)._replace(
                text=f"{kind} {name} colour {value_change(About('', ''), old, new).text.strip()}"
            )
        return value_change(about(one.address), old, new, self._unit(one.address, old if new is None else new))

    def _known(self, key: str, old: Sequence[float], new: Sequence[float]) -> float:
        return joined(self.precisions[0](key, *old), self.precisions[1](key, *new))

    def _unit(self, address: Address, value: Any) -> str:
        kind, name, quantity = address
        if isinstance(value, (str, bool, tuple, frozenset, Pose)):
            return ""
        if kind == "joint":
            return unit_of(self.robot.joint.get(name), quantity)
        if kind == "pose":
            joint = self.robot.joint.get(quantity)
            return "" if joint is None else _POSITION[joint.type == "prismatic"]
        if quantity in ("rad per pulse", "radius"):
            return "rad" if quantity == "rad per pulse" else "m"
        return "kg" if quantity == "mass" else "m" if kind == "height map" else ""

    def _mimic(self, joint: str, side: int) -> str:
        entry = self.sides[side].get(("joint", joint), {})
        numbers = (entry.get(f"mimic {part}", usual) for part, usual in (("multiplier", 1.0), ("offset", 0.0)))
        return mimic_text(entry.get("mimic joint") or "", *numbers) if entry.get("mimic joint") else "nothing"

    def _placed(self, frame: str, old: Pose, new: Pose) -> Sentence:
        least = (
            self.tolerance + ROOT_THREE * self._known("xyz", old.xyz, new.xyz),
            self.tolerance + TURNS * self._known("rpy", old.rpy, new.rpy),
        )
        distance = math.dist(old.xyz, new.xyz)
        turned = not same_turn(old.rpy, new.rpy, self.precisions, self.tolerance)
        angle = old.transform().angle_to(new.transform()) if turned else 0.0
        poses = Pose(old.xyz, near_angles(old.rpy, new.rpy)), new
        parents = [str(side.get(("frame", frame), {}).get("parent", "")) for side in self.sides]
        moved = any(abs(a - b) > least[0] for a, b in zip(old.xyz, new.xyz, strict=True))
        small = (max(NOISE, least[0] / ROOT_THREE), max(NOISE, least[1] / TURNS))
        return placed(
            frame, (parents[0], parents[1]), poses, (distance if moved or not turned else 0.0, angle), least=small
        )

    def _existence(self, one: Difference) -> Sentence:
        kind, name, _ = one.address
        word = NEW if one.old is None else REMOVED
        if kind in ("frame", "link"):
            return attached(self.robot, name, word, [self.sides[word == NEW]])
        if kind == "height map":
            return existence(word, f"{kind} of", name)
        return existence(word, kind, "" if kind == name else name)


def attached(robot: Robot, name: str, word: str, sides: Sequence[Leaves]) -> Sentence:
    """Return that a link or a frame is new or removed, and how several artifacts say that it is attached to what."""
    frames = [side.get(("frame", name), {}) for side in sides]
    links = [side.get(("link", name), {}) for side in sides]
    joints = [(side, joint_of(side, name)) for side in sides]
    kinds = [(side.get(("joint", joint), {}).get("type", ""), joint) for side, joint in joints if joint]
    kind, joint = next(((kind, joint) for kind, joint in kinds if kind in MOVING), ("", ""))
    parent = next(filter(None, (frame.get("parent") for frame in frames)), "")
    publishers = (
        of.get("publisher", "") for of in frames if "topic" in of or of.get("publisher", "").startswith("nobody")
    )
    publisher = next(filter(None, publishers), "")
    if word == NEW and name in robot.joint_to:
        published = robot.joint_to[name].publisher
        publisher = published.name if published.publishes else "nobody"
    how = [f"{kind} on {parent}".strip() if parent else "the root", joint]
    how += [f"published by {publisher.split(':')[0]}"] if publisher else []
    solid = any(key in link for link in links for key in ("mass", "collision", "visual"))
    return existence(word, "link" if solid else "frame", name, how)


def joint_of(leaves: Leaves, child: str) -> str:
    """Return the name of the joint that places a frame; empty if none is named."""
    return next((name for (kind, name), of in leaves.items() if kind == "joint" and of.get("child") == child), "")


def order_of(robot: Robot) -> Mapping[str, int]:
    """Return the place of each link in the tree, from the root on."""
    return {link.name: index for index, link in enumerate(robot.walk())}


def sort_key(robot: Robot, place: Mapping[str, int], change: Change) -> tuple[object, ...]:
    """Return the key to sort changes by: the link from the root on, then what it is about."""
    link = robot.joint[change.name].child if change.kind == "joint" and change.name in robot.joint else change.name
    word = change.quantity if change.quantity in _QUANTITIES else change.quantity.split(" ")[0]
    quantity = _QUANTITIES.index(word) if word in _QUANTITIES else len(_QUANTITIES)
    where = place.get(link.split(" ")[0], len(place))
    return (_KINDS.get(change.kind, 3), where, link, quantity, change.quantity, change.text, change.artifacts)


__all__ = ["POSE_NOISE", "Change", "Describer", "about", "joint_of", "order_of", "sort_key", "unit_of"]

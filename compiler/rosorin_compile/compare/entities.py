"""Frames, joints, links and poses that are new or gone: one line each instead of one for each of their numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.formats import Fact, Value
from rosorin_compile.formats.format import About
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Robot
from rosorin_compile.model.joint import MOVING_TYPES, SEVERAL_COORDINATES, UNPUBLISHED

from .tolerance import Turn
from .view import View
from .wording import NEW, REMOVED, Hung, Row, Sentence, existence, renamed, value_change

# What stands for a joint of a fixed frame in an artifact that lists moving joints alone.
_FIXED = Value("fixed")
_MOVING = (*MOVING_TYPES, *SEVERAL_COORDINATES)
_INERTIAL = ("mass", "centre of mass", "inertia")


class Pair(NamedTuple):
    """One artifact: its output and backend, what the committed text says and what the compiled text says.

    ``renamed`` are the new names by those of before, by the kind of thing ("link", "joint"): ``old`` has the new ones.
    """

    output: str
    backend: str
    old: View
    new: View
    renamed: Mapping[str, Mapping[str, str]] = {}


class Numbers(NamedTuple):
    """What an artifact says of one thing: its values by part ("x", "y"; "" for a single number), and its rotation."""

    parts: Mapping[str, Value]
    turn: Turn | None = None


class Entry(NamedTuple):
    """One thing in one artifact, before and after; ``parts`` are empty on the side that does not have it."""

    pair: Pair
    old: Numbers
    new: Numbers


class Change(NamedTuple):
    """One difference of meaning: what it is about, in words and as a row of a table, and the outputs that show it.

    ``quantity`` is empty where the thing itself is new or gone. ``therefore`` are links whose shapes differ for no
    other reason.
    """

    kind: str
    name: str
    quantity: str
    text: str
    remark: str
    row: Row
    artifacts: tuple[str, ...]
    therefore: tuple[str, ...] = ()

    def words(self) -> str:
        """Return the change in words, with what is remarked."""
        remarks = [self.remark] if self.remark else []
        if self.therefore:
            remarks.append(f"and therefore the shapes of {', '.join(self.therefore)}")
        return str(Sentence(self.text, "; ".join(remarks), self.row))

    def line(self) -> str:
        """Return the change as one line of plain text."""
        return f"{self.words()}: {', '.join(self.artifacts)}"


class Entities:
    """Finds what is new, gone or renamed, and which facts are said by that already."""

    def __init__(self, robot: Robot, pairs: Sequence[Pair]) -> None:
        self.robot = robot
        self.pairs = pairs
        self.hidden: set[tuple[str, str, str]] = set()
        self.types: dict[Fact, list[Entry]] = {}
        self._found: dict[tuple[str, str, str], list[str]] = {}
        for pair in pairs:
            for kind, names in pair.renamed.items():
                for old, new in names.items():
                    self._found.setdefault((kind, new, f"renamed {old}"), []).append(pair.output)
            self._frames(pair)
            self._joints(pair)
            self._others(pair)

    def hides(self, pair: Pair, fact: Fact) -> bool:
        """Say whether a fact of an artifact needs no line of its own."""
        kind, name, quantity = fact
        if (pair.output, kind, name) in self.hidden:
            return True
        if kind == "link":
            if quantity.startswith(_INERTIAL) and (pair.output, "inertial", name) in self.hidden:
                return True
            other = quantity.removeprefix("contact with ").removeprefix("pairs with ")
            return (pair.output, "frame", name) in self.hidden or (pair.output, "link", other) in self.hidden
        return kind == "pose" and (pair.output, "joint", quantity) in self.hidden

    def changes(self) -> list[Change]:
        """Return a line for each thing that is new, gone or renamed."""
        return [self._change(*key, tuple(outputs)) for key, outputs in self._found.items()]

    def _note(self, pair: Pair, kind: str, name: str, what: str) -> None:
        self._found.setdefault((kind, name, what), []).append(pair.output)
        self.hidden.add((pair.output, kind, name))
        if kind == "frame":
            self.hidden.add((pair.output, "link", name))

    def _frames(self, pair: Pair) -> None:
        old, new = _named(pair.old, "frame", "parent"), _named(pair.new, "frame", "parent")
        for what, names in ((NEW, new - old), (REMOVED, old - new)):
            for name in sorted(names):
                self._note(pair, "frame", name, what)
        for what, links in ((NEW, pair.new.names - pair.old.names), (REMOVED, pair.old.names - pair.new.names)):
            for link in sorted(links - old - new):
                self._note(pair, "link", link, what)

    def _joints(self, pair: Pair) -> None:
        """Note joints that came or went; one whose child came or went with it is said by its frame."""
        old, new = joints_by_child(pair.old), joints_by_child(pair.new)
        for child in sorted(old.keys() | new.keys()):
            before, after = old.get(child, ""), new.get(child, "")
            if (pair.output, "frame", child) in self.hidden:
                self._hide(pair, before, after)
            else:
                self._type(pair, before or after, bool(before), bool(after))

    def _hide(self, pair: Pair, *joints: str) -> None:
        self.hidden |= {(pair.output, "joint", joint) for joint in joints if joint}

    def _type(self, pair: Pair, joint: str, before: bool, after: bool) -> None:
        """Note a joint that moves and did not, or the other way round: its limits and the like came or went with it."""
        fact = Fact("joint", joint, "type")
        old = pair.old.plain.get(fact, _FIXED) if before else _FIXED
        new = pair.new.plain.get(fact, _FIXED) if after else _FIXED
        if (old.value in _MOVING) != (new.value in _MOVING):
            self.types.setdefault(fact, []).append(Entry(pair, Numbers({"": old}), Numbers({"": new})))
            self._hide(pair, joint)

    def _others(self, pair: Pair) -> None:
        old, new = _named(pair.old, "link", "mass"), _named(pair.new, "link", "mass")
        for what, names in ((NEW, new - old), (REMOVED, old - new)):
            for name in sorted(names):
                if (pair.output, "link", name) not in self.hidden:
                    self._note(pair, "inertial", name, what)
        for kind in ("pose", "height map", "material", *_compared()):
            old, new = _named(pair.old, kind), _named(pair.new, kind)
            for what, names in ((NEW, new - old), (REMOVED, old - new)):
                for name in sorted(names):
                    self._note(pair, kind, name, what)

    def _change(self, kind: str, name: str, what: str, outputs: tuple[str, ...]) -> Change:
        if what.startswith("renamed "):
            sentence = renamed(kind, what.removeprefix("renamed "), name)
        elif kind in ("frame", "link"):
            sentence = self._existence(name, what)
        elif kind == "inertial":
            masses = [view.plain.get(Fact("link", name, "mass")) for view in self._views(what)]
            mass = next(filter(None, masses), None)
            values = (None, mass) if what == NEW else (mass, None)
            sentence = value_change(About(name, "mass"), *values)
        else:
            text = f"{what}: {kind} of {name}" if kind == "height map" else f"{what}: {kind} {name}"
            sentence = Sentence(text, "", Row(name, kind, by=what))
        return Change(kind, name, "", *sentence, outputs)

    def _views(self, what: str) -> list[View]:
        """Return the views that know something that came or went."""
        return [pair.new if what == NEW else pair.old for pair in self.pairs]

    def _existence(self, name: str, word: str) -> Sentence:
        """Return what is known of a frame or link that came or went: how it hangs, its joint if it moves, publisher."""
        views = self._views(word)
        parent = next(filter(None, (view.parent(name) for view in views)), "")
        joints = [(view, joints_by_child(view).get(name, "")) for view in views]
        kinds = [(view.text("joint", joint, "type"), joint) for view, joint in joints if joint]
        kind, joint = next(((kind, joint) for kind, joint in kinds if kind in _MOVING), ("", ""))
        publisher = next(filter(None, (view.text("frame", name, "publisher") for view in views)), "")
        if not publisher and word == NEW and name in self.robot.joint_to:
            known = self.robot.joint_to[name].publisher
            publisher = "nobody" if known.kind == UNPUBLISHED else known.name
        solid = any(name == link for view in views for link, _ in view.shapes)
        solid = solid or any(Fact("link", name, "mass") in view.plain for view in views)
        hung = Hung(parent, kind, joint, publisher.split(":")[0])
        return existence(word, "link" if solid else "frame", name, hung)


def joints_by_child(view: View) -> dict[str, str]:
    """Return the joints that an artifact names, by the frame that they place."""
    return {
        str(value.value): fact.name
        for fact, value in view.plain.items()
        if fact.kind == "joint" and fact.quantity == "child"
    }


def _compared() -> list[str]:
    """Return what entries are called that are compared value by value; a new one is one line."""
    return [node.compared for node in sections().values() if node.compared]


def _named(view: View, kind: str, quantity: str = "") -> set[str]:
    names = {fact.name for fact in view.plain if fact.kind == kind and quantity in ("", fact.quantity)}
    return names | set(view.heights) if kind == "height map" else names

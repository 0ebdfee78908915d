"""What the rules look at, and how they say where a problem is."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rosorin_compile.language.accepting import names_at
from rosorin_compile.language.expand.provenance import mistake_place
from rosorin_compile.language.expand.scope import Scope
from rosorin_compile.language.misnamed import name_meant
from rosorin_compile.language.schema import TEMPLATE
from rosorin_compile.language.symbols import Reference, SymbolTable
from rosorin_compile.model import Joint, Output, Robot
from rosorin_compile.model.cached import of_robot
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Related, Span, or_else
from rosorin_compile.source.tree import Map, Path, at, exists, follow

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from rosorin_compile.formats import Format

    from .magnitudes import Remarkable


@dataclass(frozen=True)
class Case:
    """A robot, the tree that it was lowered from, and the paths in it of joints, links and turns, by kind and name.

    ``remarkable`` are the values that the rules about single values ask for (see ``magnitudes.collect``),
    ``formats`` those that outputs may name, ``scope`` what the names in expressions stood for (None: nobody knows).
    ``wanted`` are the names of the only outputs that are made; without them all are.
    """

    robot: Robot
    tree: Map
    places: Mapping[tuple[str, str], Path]
    remarkable: Remarkable
    formats: Mapping[str, Format] = field(default_factory=dict)
    scope: Scope | None = None
    wanted: Collection[str] = ()

    def feeding(self, publisher: str) -> list[Output]:
        """Return the outputs that publishers of a kind read, by their format."""
        return feeding(self.robot, publisher, self.formats)

    @cached_property
    def symbols(self) -> SymbolTable:
        """The names that the description defines and refers to."""
        return SymbolTable(self.tree)

    def mentions(self, *kinds: str) -> Iterator[Reference]:
        """Yield what names something of some kinds, but for what a section has for itself (``own_names``)."""
        own = {"moveit": self.robot.moveit.own_names} if self.robot.moveit else {}
        for one in self.symbols.references(kinds):
            if one.name not in own.get(str(one.path[0]), {}).get(one.kind, ()):
                yield one

    def joint(self, joint: Joint, *rest: str | int) -> Path:
        """Return the path of a joint, or of what is in it; that of a sensor for the joint that mounts it."""
        path = self.places.get(("joint", joint.name)) or ("joints", joint.name)
        return (*path, *rest) if rest else path

    def link(self, name: str, *rest: str | int) -> Path:
        """Return the path of a link, or of what is in it."""
        path = self.places.get(("link", name)) or ("links", name)
        return (*path, *rest) if rest else path

    def end(self, joint: Joint, which: str) -> Path:
        """Return the path of the name of the link at the "parent" or the "child" end of a joint."""
        path = self.joint(joint)
        if path[0] != "sensors":
            return (*path, which)
        if path[-1] == "optical":
            return (*path[:-1], "frame") if which == "parent" else (*path, "frame")
        return (*path, "parent" if which == "parent" else "frame")

    def edge(self, index: int, key: str) -> Path:
        """Return the path of a value of an edge: its ``parent``, ``child``, ``publisher`` or ``when``.

        For the turn of a joint's publisher that is the entry that says who it is, or when.
        """
        turn = self.places.get(("edge", str(index)))
        if turn is None:
            return ("edges", index, key)
        return (*turn, "when") if key == "when" and exists(self.tree, (*turn, "when")) else (*turn, "by")

    def publisher(self, joint: Joint) -> Path:
        """Return the path of the publisher of a joint, or of the joint where it is not said."""
        path = self.joint(joint)
        key_path = (*path, "publisher")
        entry = at(self.tree, path)
        if isinstance(entry, Map) and "publisher" in entry:
            return key_path
        if path[-1] == "optical" and exists(self.tree, (*path[:-1], "publisher")) and not exists(self.tree, key_path):
            return (*path[:-1], "publisher")
        return path

    def problem(
        self,
        rule: str,
        message: str,
        path: Path,
        help: str = "",
        *,
        related: Iterable[Related] = (),
        severity: str = ERROR,
        key: bool = False,
        within: bool = False,
    ) -> Diagnostic:
        """Return a diagnostic at a path: at its value, at its key with ``key``, or at the entry that lacks it.

        A value that was written in ``let``, or given to a part, is shown there; related says where it is used.
        ``within`` is for what is wrong within a mapping: at its key, or where it was written.
        """
        place, uses = mistake_place(self.scope, self.tree, path, rule, key, within)
        names = names_at(self.tree, path)
        return Diagnostic(rule, severity, message, place.span, (*related, *uses, *place.stack()), help, names)

    def related(self, message: str, path: Path, key: bool = False) -> Related:
        """Return a second place."""
        return Related(message, self._place(path, key))

    def also(
        self, first: Path, others: Iterable[tuple[Path, str, bool]], key: bool = False
    ) -> tuple[list[Related], list[tuple[Path, str]]]:
        """Return where else is used what is wrong at a path, and what of that was written at the same place.

        Each of ``others`` is a path, what is there, and whether it is a key. A part says the same at one place for all
        its uses: that is told of each, and each is told once.
        """
        place, related, same = self._place(first, key), dict[Span, Related](), []
        for path, what, is_key in others:
            span = self._place(path, is_key)
            if span == place:
                same.append((path, what))
            else:
                related.setdefault(span, Related(f"also used here: {what}", span))
        return list(related.values()), same

    def _place(self, path: Path, key: bool = False) -> Span:
        return mistake_place(self.scope, self.tree, path, "", key)[0].span

    def suggest(self, path: Path, word: str, known: Iterable[str], otherwise: str, more: Sequence[str] = ()) -> str:
        """Return 'did you mean "x"?' for an unknown name at a path, else what to do and the known names.

        In a part its own names go first, as it calls them, and ``more``.
        """
        guess = name_meant(self.tree, path, word, known, more)
        return or_else(guess, otherwise)

    def stands_in(self, *paths: Path) -> str:
        """Return " (a stand-in)" if one of the values at some paths only holds a place, else nothing."""
        return " (a stand-in)" if any(_stands_in(self.tree, path) for path in paths) else ""


def feeding(robot: Robot, publisher: str, formats: Mapping[str, Format]) -> list[Output]:
    """Return the outputs that publishers of a kind read, by their format."""
    known = [output for output in robot.outputs if output.backend in formats]
    read = [output for output in known if publisher in formats[output.backend].feeds]
    return [output for output in read if not formats[output.backend].is_withheld(output)]


def fed(robot: Robot, publisher: str, formats: Mapping[str, Format]) -> list[Output]:
    """Return the outputs that publishers of a kind read, also by the names of their files, those by format first.

    A template of the user's own may make what robot_state_publisher reads.
    """
    outputs = feeding(robot, publisher, formats)
    others = [one for one in robot.outputs if one.backend == TEMPLATE or one.backend not in formats]
    if not others:
        return outputs
    readable = [one for one in formats.values() if one.load is not None and publisher in one.feeds]
    endings = tuple(ending for one in readable for ending in one.endings)
    return [*outputs, *(one for one in others if one.file.endswith(endings))]


def first_fed(robot: Robot, publisher: str, formats: Mapping[str, Format]) -> Output | None:
    """Return the first output of ``fed``; where one is read by its format, without asking all formats."""
    return next(iter(feeding(robot, publisher, formats) or fed(robot, publisher, formats)), None)


def _stands_in(tree: Map, path: Path) -> bool:
    """Say whether the nearest source around a value says that it is a stand-in."""
    node: Any = tree
    found = False
    for step in (None, *path[: follow(tree, path)]):
        node = node if step is None else node[step]
        source = node.get("source") if isinstance(node, Map) else None
        found = source.get("status") == "stand_in" if isinstance(source, Map) else found
    return found


def number(value: float) -> str:
    """Return a number as a person would write it, for a message: up to six digits."""
    return f"{float(value):.6g}"


class ByValue:
    """The links or joints of a robot, grouped by their values: parts that are used many times are examined once."""

    def __init__(self, items: Sequence[Any], values_of: Callable[[Any], Hashable]) -> None:
        self.items = items
        self.values = [values_of(item) for item in items]
        self.first: dict[Hashable, Any] = {}
        for values, item in zip(self.values, items, strict=True):
            self.first.setdefault(values, item)

    def problems(self, examine: Callable[[Any], Iterable[Diagnostic]]) -> Iterator[Diagnostic]:
        """Yield what ``examine`` yields for each item; if that is nothing for one, it is nothing for its equals."""
        wrong = {values for values, first in self.first.items() if any(True for _ in examine(first))}
        for values, item in zip(self.values, self.items, strict=True) if wrong else ():
            if values in wrong:
                yield from examine(item)


@of_robot
def links_by_value(robot: Robot) -> ByValue:
    """Return the links grouped by their inertials and shapes, which lowering makes once for all uses of a part."""
    return ByValue(robot.links, lambda link: (id(link.inertial), id(link.visual), id(link.collision)))


@of_robot
def joints_by_value(robot: Robot) -> ByValue:
    """Return the joints grouped by type, axis, limits and dynamics; not by origin."""
    parts = ("limit", "mimic", "dynamics", "actuator", "calibration", "safety")
    return ByValue(robot.joints, lambda joint: (joint.type, joint.axis, *(id(getattr(joint, part)) for part in parts)))

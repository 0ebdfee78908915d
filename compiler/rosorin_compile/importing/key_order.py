"""Order: which file a section is written into, and where sections and keys stand there, as the schema says.

Sections and keys stand in the order of ``properties``. ``x-first`` names the keys that come first where the others stay
as in the source, which are words of another program; ``x-file`` is the file of a section in a description of several.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from graphlib import TopologicalSorter
from itertools import pairwise
from typing import Any, TypeVar

from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.tree import Path

PARTS, USE, LET = "parts", "use", "let"  # sections that the plain tree has no more
# The files beside the first one, in their order; one that is none of these stands behind them.
_ABOUT = {
    PARTS: "The parts: what the robot has several times, written once; robot.yaml uses them.",
    "links": "The links: masses, what they look like, what they collide with.",
    "joints": "The joints: how the links hang together.",
    "simulation": "What only a simulation has: how the robot stands, what drives it, what it measures and touches.",
    "sensors": "The sensors: what each measures, and what Gazebo has of it.",
    "control": "The hardware of ros2_control.",
    "extensions": "What the language has no word for, as it stood in the source.",
    "moveit": "What MoveIt has to know beside the URDF: groups of joints, end effectors, pairs that it need not check.",
}
_BEHIND = {LET: PARTS, "joints": USE}  # they hang on links, as joints do
_WITH_EACH = "source"  # stands at the top of each file
_LAST = 1_000  # the place of what the schema says nothing of

V = TypeVar("V")


def sorted_sections(document: Mapping[str, V]) -> dict[str, V]:
    """Return the sections of a file in their order."""
    order = [one for key in fragment_at(())["properties"] for one in (key, _BEHIND.get(key, key))]
    return _sorted(document, order)


def in_files(document: Mapping[str, V]) -> dict[str, dict[str, V]]:
    """Return the sections that have a file of their own, by the name of that file without its ending."""
    files: dict[str, dict[str, V]] = {name: {} for name in _ABOUT}
    for section, value in document.items():
        if file := PARTS if section == PARTS else fragment_at((section,)).get("x-file"):
            files.setdefault(file, {})[section] = value
    shared = {key: value for key, value in document.items() if key == _WITH_EACH}
    return {name: {**shared, **part} for name, part in files.items() if part}


def about(file: str, sections: Iterable[str]) -> str:
    """Return what the first line of a file says of it."""
    said: str = _ABOUT.get(file) or next(
        (fragment_at((one,)).get("description", one) for one in sections if one != _WITH_EACH), file
    )
    return said


def sorted_keys(entry: Mapping[str, V], path: Path) -> dict[str, V]:
    """Return an entry that stands at a path of a description with its keys in their order."""
    return in_order(entry) if path[0] == LET else _sorted(entry, _order(fragment_at(path)))


def in_order(entry: Mapping[str, V]) -> dict[str, V]:
    """Return what is some piece of a link or a joint with its keys in their order."""
    return _sorted(entry, _words())


def is_default(path: Path, value: Any) -> bool:
    """Say whether a value is what the language takes when nothing is said."""
    default = fragment_at(path).get("default")
    return default is not None and not isinstance(value, bool) and bool(value == default)


def default_of_key(key: str) -> Any:
    """Return what a key of a link or a joint, or of what they hold, is when nothing is said; None for no such key."""
    return _defaults().get(key)


@cache
def _defaults() -> Mapping[str, Any]:
    entries = (said.get("properties", {}) for said in _pieces())
    return {key: fragment["default"] for entry in entries for key, fragment in entry.items() if "default" in fragment}


def _sorted(values: Mapping[str, V], order: Iterable[str]) -> dict[str, V]:
    rank = {key: place for place, key in enumerate(order)}
    return dict(sorted(values.items(), key=lambda item: rank.get(item[0], _LAST)))


def _order(said: Mapping[str, Any]) -> Sequence[str]:
    order: Sequence[str] = said.get("x-first", tuple(said.get("properties", ())))
    return order


@cache
def _words() -> tuple[str, ...]:
    """Return the keys of links and joints, and of what they hold; what stands before another does so everywhere."""
    before: dict[str, list[str]] = {}
    for said in _pieces():
        for first, second in pairwise(_order(said)):
            before.setdefault(second, []).append(first)
    return tuple(TopologicalSorter(before).static_order())


def _pieces() -> Iterator[Mapping[str, Any]]:
    for section in ("links", "joints"):
        yield from _fragments((section, "*"))


def _fragments(path: Path) -> Iterator[Mapping[str, Any]]:
    """Yield what the schema says of a value, and of all that stands in it but under names."""
    said = fragment_at(path)
    yield said
    for step in (*said.get("properties", ()), *([0] if "items" in said else [])):
        yield from _fragments((*path, step))

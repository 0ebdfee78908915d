"""Formats: what a robot is written as and read from. Each is known by its record (``record.Format``), and only by it.

``FORMATS`` has them by name: those of this folder, found by their modules, then those of other packages. A module is
imported when somebody asks for its format.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, cast

from ..model import ROBOT_STATE_PUBLISHER
from .record import Artifact, Fact, Facts, Format, Opened, Value

if TYPE_CHECKING:
    from ..diagnostic import Diagnostic
    from .plugged import Plugged

__all__ = [
    "FORMATS",
    "Artifact",
    "Fact",
    "Facts",
    "Format",
    "Formats",
    "Opened",
    "Value",
    "endings",
    "feeds",
    "names_meshes",
    "plugged_diagnostics",
    "published",
]


class Formats(Mapping[str, Format]):
    """The formats by name, in the order of lists."""

    def __getitem__(self, name: str) -> Format:
        if name in _homes():
            return _built_in(name)
        return _of_others()[name]

    def __contains__(self, name: object) -> bool:
        return name in _homes() or name in _of_others()

    def __iter__(self) -> Iterator[str]:
        every = [*map(_built_in, _homes()), *_of_others().values()]
        return (one.name for one in sorted(every, key=lambda one: (one.rank, one.name)))

    def __len__(self) -> int:
        return len(_homes()) + len(_of_others())


FORMATS = Formats()

_HOMES = {
    "urdf": "..importing.urdf",
    "xacro": "..importing.xacro",
    "mjcf": "..importing.mjcf",
    "static_tf": ".static_tf",
    "static_tf_json": ".static_tf_json",
    "robot_model": ".robot_model",
    "frames": ".frames",
    "frames_picture": ".frames_picture",
    "template": ".template",
}


def _homes() -> Mapping[str, str]:
    return _HOMES


@cache
def _built_in(name: str) -> Format:
    return cast(Format, import_module(_homes()[name], __name__).FORMAT)


def _of_others() -> Mapping[str, Format]:
    """Return the formats of other packages."""
    return _plugged().formats


def _plugged() -> Plugged:
    from .plugged import plugged

    return plugged(frozenset(_homes()))


def plugged_diagnostics() -> tuple[Diagnostic, ...]:
    """Return what is wrong with the formats of other packages."""
    return _plugged().diagnostics


def endings(*, include: bool = False) -> tuple[str, ...]:
    """Return how the names of files end that hold a robot; with ``include`` of those that a description may include."""
    readable = [one for one in FORMATS.values() if one.read is not None and (one.include or not include)]
    return tuple(dict.fromkeys(ending for one in readable for ending in one.endings))


def published() -> Format:
    """Return the format that robot_state_publisher reads."""
    return next(one for one in FORMATS.values() if one.write and one.read and ROBOT_STATE_PUBLISHER in one.feeds)


def feeds(name: str, publisher: str) -> bool:
    """Say whether publishers of a kind read a format."""
    return publisher in FORMATS[name].feeds


def names_meshes(artifact: Artifact) -> bool:
    """Say whether an artifact names meshes as URDF does; one of a template by the name of its file."""
    if FORMATS[artifact.backend].meshes:
        return True
    return any(one.meshes and artifact.file.endswith(one.endings) for one in FORMATS.values())

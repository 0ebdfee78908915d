"""Formats: what a robot is written to and read from.

``FORMATS`` has their records (``format.Format``) by name: those of the tool, then those of plug-ins.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.rules.case import feeding
from rosorin_compile.source.plugins import are_installed

from .format import Artifact, Format, Opened

if TYPE_CHECKING:
    from rosorin_compile.model import Output, Robot
    from rosorin_compile.source.diagnostics import Diagnostic

    from .plugged import Plugged

__all__ = [
    "FORMATS",
    "Artifact",
    "Format",
    "Formats",
    "Opened",
    "plugged_diagnostics",
]

# The module of each format; its record is ``FORMAT`` there. It is imported when the format is first used.
_MODULES = {
    "urdf": "rosorin_compile.formats.urdf",
    "frames": "rosorin_compile.formats.frames",
    "robot_model": "rosorin_compile.formats.robot_model",
    "static_tf": "rosorin_compile.formats.static_tf",
    "static_tf_json": "rosorin_compile.formats.static_tf_json",
    "template": "rosorin_compile.formats.template",
    "xacro": "rosorin_compile.importing.xacro",
    "mjcf": "rosorin_compile.mujoco.mjcf",
    "scene": "rosorin_compile.mujoco.scene",
    "controllers": "rosorin_compile.ros.controllers",
    "nav2": "rosorin_compile.ros.nav2",
    "robot_localization": "rosorin_compile.ros.robot_localization",
    "srdf": "rosorin_compile.ros.srdf",
    "sdf": "rosorin_compile.sdf",
    "frames_picture": "rosorin_compile.viewer.frames_picture",
    "page": "rosorin_compile.viewer.page",
}


class Formats(Mapping[str, Format]):
    """The formats by name, in the order of lists."""

    def __getitem__(self, name: str) -> Format:
        return _built_in(name) or _of_others()[name]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and (_built_in(name) is not None or name in _of_others())

    def __iter__(self) -> Iterator[str]:
        return iter(_names())

    def __len__(self) -> int:
        return len(_names())

    def is_own(self, name: str) -> bool:
        """Say whether a format is one of the tool, and not of a plug-in."""
        return _built_in(name) is not None

    def feeding(self, robot: Robot, publisher: str) -> list[Output]:
        """Return the outputs of a robot that publishers of a kind read, by their format."""
        return feeding(robot, publisher, self)

    def feeds(self, artifact: Artifact, publisher: str) -> bool:
        """Return True if publishers of a kind read an artifact, by its format."""
        return publisher in self[artifact.backend].ros.feeds and not artifact.withheld

    def names_meshes(self, artifact: Artifact) -> bool:
        """Return True if an artifact names meshes as URDF does; for a template the name of its file decides."""
        if self[artifact.backend].writing.meshes:
            return True
        return any(one.writing.meshes and artifact.file.endswith(one.endings) for one in self.values())

    def endings(self, *, include: bool = False) -> tuple[str, ...]:
        """Return how names of files end that hold a robot; with ``include`` of those that a description may include."""
        readable = [one for one in self.values() if one.load is not None and (one.reading.include or not include)]
        return tuple(dict.fromkeys(ending for one in readable for ending in one.endings))

    def published(self) -> Format:
        """Return the format that robot_state_publisher reads."""
        return next(one for one in self.values() if one.write and one.load and ROBOT_STATE_PUBLISHER in one.ros.feeds)


FORMATS = Formats()


@cache
def _names() -> tuple[str, ...]:
    groups = (filter(None, map(_built_in, _MODULES)), _of_others().values())
    return tuple(one.name for group in groups for one in sorted(group, key=lambda one: (one.rank, one.name)))


@cache
def _built_in(name: str) -> Format | None:
    """Return the tool's own format of that name; None if there is none."""
    if name not in _MODULES:
        return None
    format: Format = import_module(_MODULES[name]).FORMAT
    return format


def _of_others() -> Mapping[str, Format]:
    """Return the formats of other packages."""
    others = _plugged()
    return others.formats if others else {}


def _plugged() -> Plugged | None:
    """Return what plug-ins add; None where there is none, as on most machines."""
    if not are_installed("formats"):
        return None
    from .plugged import plugged

    return plugged(frozenset(_MODULES), _known_files)


@cache
def _known_files() -> frozenset[str]:
    """Return by what files are known that hold a robot in a format of the tool: endings, and <root> elements."""
    readable = [one for one in filter(None, map(_built_in, _MODULES)) if one.load is not None]
    return frozenset(mark for one in readable for mark in (*one.endings, *(f"<{root}>" for root in one.roots)))


def plugged_diagnostics() -> tuple[Diagnostic, ...]:
    """Return what is wrong with the formats of other packages."""
    others = _plugged()
    return others.diagnostics if others else ()

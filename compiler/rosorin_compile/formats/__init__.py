"""Formats: what a robot is written as and read from. Each is known by its record (``format.Format``), and only by it.

``FORMATS`` has them by name: those of this folder, found by their modules, those of the packages beside the core, which
``SHIPPED`` names, then those of plug-ins. A module is imported when somebody asks for its format.

To be read in this order: ``format`` (what a record has to say), one that is written (``static_tf_json``, or ``urdf``
with ``templating``), ``facts`` (how artifacts are read back to be compared), one that is read (``urdf``, with
``reading``, ``imported`` and ``checked``, which all readers share), ``plugged`` (formats of other packages).
``drawing`` is what ``frames_picture`` and the command ``frames`` draw with, ``parameters`` what is known of the nodes
of ROS 2, for those formats that are parameter files and for ``check parameters``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.rules.case import feeding
from rosorin_compile.source import files
from rosorin_compile.source.plugins import are_installed

from .format import Artifact, Fact, Facts, Format, Opened, Value

if TYPE_CHECKING:
    from rosorin_compile.model import Output, Robot
    from rosorin_compile.source.diagnostics import Diagnostic

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
    "plugged_diagnostics",
]

# The modules of the formats outside this folder, by which their names end.
SHIPPED = (
    "rosorin_compile.importing.xacro",
    "rosorin_compile.mujoco.mjcf",
    "rosorin_compile.mujoco.scene",
    "rosorin_compile.ros.controllers",
    "rosorin_compile.ros.nav2",
    "rosorin_compile.ros.robot_localization",
    "rosorin_compile.ros.srdf",
    "rosorin_compile.sdf",
    "rosorin_compile.viewer.frames_picture",
    "rosorin_compile.viewer.page",
)


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

    def endings(self, *, include: bool = False) -> tuple[str, ...]:
        """Return how names of files end that hold a robot; with ``include`` of those that a description may include."""
        readable = [one for one in self.values() if one.read is not None and (one.reading.include or not include)]
        return tuple(dict.fromkeys(ending for one in readable for ending in one.endings))

    def published(self) -> Format:
        """Return the format that robot_state_publisher reads."""
        return next(one for one in self.values() if one.write and one.read and ROBOT_STATE_PUBLISHER in one.ros.feeds)


FORMATS = Formats()


@cache
def _names() -> tuple[str, ...]:
    groups = (filter(None, map(_built_in, _homes())), _of_others().values())
    return tuple(one.name for group in groups for one in sorted(group, key=lambda one: (one.rank, one.name)))


@cache
def _homes() -> Mapping[str, str]:
    """Return the module of each of our own formats, by name: those of this folder, then those of the packages."""
    here = {name: f"{__name__}.{name}" for name, path in _modules().items() if _exports(path)}
    return here | {module.rpartition(".")[2]: module for module in SHIPPED}


def _modules() -> Mapping[str, Path]:
    """Return the modules of this folder by name."""
    paths = {path.name.removesuffix(".py"): path for path in files.list_folder(__path__[0])}
    return {name: path for name, path in paths.items() if name.isidentifier()}


def _exports(module: Path) -> bool:
    """Say whether a module exports a record, by its source: what only helps to read and write stays unimported."""
    try:
        return b"\nFORMAT = " in files.read_bytes(module if module.suffix else module / "__init__.py")
    except OSError:  # a folder that is no module
        return False


@cache
def _built_in(name: str) -> Format | None:
    """Return the tool's own format of that name; None if there is none."""
    if name not in _homes():
        return None
    format: Format = import_module(_homes()[name]).FORMAT
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

    return plugged(frozenset(_homes()), _known_files)


@cache
def _known_files() -> frozenset[str]:
    """Return by what files are known that hold a robot in a format of the tool: endings, and <root> elements."""
    readable = [one for one in filter(None, map(_built_in, _homes())) if one.read is not None]
    return frozenset(mark for one in readable for mark in (*one.endings, *(f"<{root}>" for root in one.roots)))


def plugged_diagnostics() -> tuple[Diagnostic, ...]:
    """Return what is wrong with the formats of other packages."""
    others = _plugged()
    return others.diagnostics if others else ()

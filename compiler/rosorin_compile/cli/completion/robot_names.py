"""What the robots of a line have, for a shell: read quietly, in little time, and without running what others wrote.

A xacro is not expanded. What of a description is broken, or takes too long, has the names that are read from its text.
"""

from __future__ import annotations

import re
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields
from functools import cache
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.files import read_bytes, read_text
from rosorin_compile.source.project import ENDINGS, Description, all_here, here

from ..robots import is_foreign

if TYPE_CHECKING:
    from rosorin_compile.language.annotations import Node
    from rosorin_compile.language.arguments import Argument
    from rosorin_compile.model import Robot
    from rosorin_compile.source.tree import Map

PATIENCE = 1.5  # seconds that a person waits at a tab; then the text has to do
_LEAST = 0.001  # seconds; a timer of none never ends
ARGUMENTS = "arguments"
_spent: list[float] = []  # of it, seconds
_MAX_ROBOTS = 8  # whose names are shown together where none is named

_SECTION = re.compile(r"([a-z_]+):")
_ENTRY = re.compile(r" {1,8}[\"']?([A-Za-z_][\w./-]*)[\"']?:(.*)")
USE, THINGS = "use", "things"
_XACRO_ARG = re.compile(r"<xacro:arg\s[^>]*?name=[\"']([^\"']+)[\"']")
# What is asked for beside the entries of a section: the kinds of names that these are where a text alone can be read.
_IN_TEXT = {
    "frames": ("link",),
    THINGS: ("link", "joint", "sensor", USE),
    "nodes": ("publisher",),
}
# What stands in a text: the names of each kind, and those of the entries of each section.
_Text = tuple[dict[str, list[str]], dict[str, list[str]]]


class Subject(NamedTuple):
    """The robots that a line asks about (what cannot be one is passed over), the arguments, and folders of packages."""

    robots: tuple[str, ...]
    arguments: Mapping[str, str]
    packages: Mapping[str, Path]


class _TooLong(BaseException):
    """What was asked for takes longer than a person waits."""


def robots() -> list[str]:
    """Return the names of the robots of this project."""
    return [path.parent.name for path in all_here()]


def robot_endings() -> tuple[str, ...]:
    """Return how the names of files end that may be a robot."""
    from rosorin_compile.formats import FORMATS

    return (*ENDINGS, *FORMATS.endings())


def names(asked: Subject, of: str) -> dict[str, str]:
    """Return the names of one kind that the robots have, and what each is; of several robots whose it is."""
    paths = _paths(asked)
    found: dict[str, str] = {}
    for path in paths:
        for name, help in _names(path, asked, of).items():
            found.setdefault(name, help if len(paths) == 1 else ", ".join(filter(None, [_called(path), help])))
    return found


def values(asked: Subject, argument: str) -> list[str]:
    """Return the values that an argument may have, or its default."""
    for path in _paths(asked):
        for one in _arguments(path):
            if one.name == argument:
                choices = one.allowed or (("true", "false") if one.type == "boolean" else ())
                return [_unquoted(text) for text in choices or ((one.default,) if one.default else ())]
    return []


def _paths(asked: Subject) -> list[Path]:
    """Return the first files of the robots that are asked for, else of that one here, else of all here."""
    found = []
    for name in asked.robots:
        with suppress(Exception):
            found.append(Description.find([name])[0].path)
    if not found:
        with suppress(Exception):
            found = [one.path for one in here()]
    return found[:_MAX_ROBOTS]


def _called(path: Path) -> str:
    return path.parent.name or path.stem


def _unquoted(text: str) -> str:
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'" else text


def _names(path: Path, asked: Subject, of: str) -> dict[str, str]:
    """Return the names of one kind, or of the entries of one section, in one robot."""
    with suppress(Exception):
        if of == ARGUMENTS:
            return {one.name: one.help or _default(one) for one in _arguments(path)}
        understood = _understood(path, tuple(asked.arguments.items()), tuple(asked.packages.items()))
        if understood is not None:
            uses = dict.fromkeys(_text(path)[1].get(USE, ()), "use of a part") if of == THINGS else {}
            return {**uses, **_in_robot(*understood, of)}
    return _in_text(path, of)


def _default(argument: Argument) -> str:
    return "required" if argument.required else f"default: {argument.default}"


def _arguments(path: Path) -> list[Argument]:
    """Return the arguments that a description or a xacro declares."""
    from rosorin_compile.language.arguments import Argument, declared
    from rosorin_compile.source.diagnostics import Source, Span

    if is_foreign(path):
        text = read_text(path, errors="replace")
        span = Span(Source(str(path), ""), 1, 1, 1)
        return [
            Argument(name, "any", (), False, "", "argument of the xacro", span) for name in _XACRO_ARG.findall(text)
        ]
    with suppress(_TooLong), _patience():
        return declared(path, {})[0]
    return []


@cache
def _understood(
    path: Path, arguments: tuple[tuple[str, str], ...], packages: tuple[tuple[str, Path], ...]
) -> tuple[Robot, Map] | None:
    """Return the robot and tree of a description, or of a file that can be read without running anything; else None."""
    from rosorin_compile.source.diagnostics import has_errors

    with suppress(Exception, _TooLong), _patience():  # it may end before it has begun
        if is_foreign(path):
            return _foreign(path, dict(packages))
        from rosorin_compile.language.expand import expand
        from rosorin_compile.language.lower import lower
        from rosorin_compile.output.pipeline import Readers

        class Harmless(Readers):
            """Reads the robots that are included, but for those that run what they say."""

            def read(self, path: Path, *more: Any) -> Any:
                if _runs(path):
                    raise ValueError
                return super().read(path, *more)

        for readers in (Harmless(), None):
            with suppress(Exception):
                expanded = expand(path, dict(arguments), readers, lambda _: None, dict(packages))
                if expanded.tree is not None and not has_errors(expanded.diagnostics):
                    robot = lower(expanded.tree).robot
                    if robot is not None:
                        return robot, expanded.tree
    return None


def _foreign(path: Path, packages: Mapping[str, Path]) -> tuple[Robot, Map] | None:
    from ..foreign import understand_foreign

    if _runs(path):
        return None
    expanded, lowered, *_ = understand_foreign(path, {}, packages, lambda _: None)
    if expanded.tree is None or lowered is None or lowered.robot is None:
        return None
    return lowered.robot, expanded.tree


def _runs(path: Path) -> bool:
    """Say whether reading a file runs what it says, as a xacro does."""
    from rosorin_compile.formats import FORMATS

    return any(one.reading.takes_arguments and path.suffix.lower() in one.endings for one in FORMATS.values())


@contextmanager
def _patience() -> Iterator[None]:
    """End what is done meanwhile in silence, once the patience of this run is at its end."""

    def end(_number: int, _frame: FrameType | None) -> None:
        raise _TooLong

    if not hasattr(signal, "SIGALRM"):  # Windows: nothing could end it
        raise _TooLong
    before = signal.signal(signal.SIGALRM, end)
    begun = time.monotonic()
    try:
        signal.setitimer(signal.ITIMER_REAL, max(PATIENCE - sum(_spent), _LEAST))
        yield
    except _TooLong:
        pass
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        _spent.append(time.monotonic() - begun)


def _frames(robot: Robot) -> dict[str, str]:
    from rosorin_compile.model.kinematics.graph import Graph

    sensors = {sensor.frame: f"{sensor.name}, {sensor.type}" for sensor in robot.sensors}
    return {name: sensors.get(name, _above(robot, name)) for name in Graph(robot).frames}


def _above(robot: Robot, name: str) -> str:
    joint = robot.joint_to.get(name)
    return f"on {joint.parent}" if joint is not None else ""


def _joints(robot: Robot) -> dict[str, str]:
    return {joint.name: _said(robot, joint) for joint in robot.joints}


def _things(robot: Robot) -> dict[str, str]:
    return {**_frames(robot), **_joints(robot), **{sensor.name: sensor.type for sensor in robot.sensors}}


def _modes(robot: Robot) -> dict[str, str]:
    return {text: help for mode in robot.modes for text, help in ((mode, "is on"), (f"{mode}=off", "is off"))}


def _nodes(robot: Robot) -> dict[str, str]:
    senders = [*(joint.publisher for joint in robot.joints), *(edge.publisher for edge in robot.edges)]
    return {one.name: one.about for one in senders if one.name}


_OF_ROBOT: dict[str, Callable[[Robot], dict[str, str]]] = {
    "frames": _frames,
    THINGS: _things,
    "modes": _modes,
    "nodes": _nodes,
}


def _in_robot(robot: Robot, tree: Map, of: str) -> dict[str, str]:
    """Return the names of one kind, or of the entries of a section: those of the model, which knows more, if any.

    SECTION.joint are the joints that a section names.
    """
    if of in _OF_ROBOT:
        from rosorin_compile.language.mentions import explained

        more = (str(path[1]) for path in explained(tree)) if of == THINGS else ()
        return _OF_ROBOT[of](robot) | dict.fromkeys(more, "")
    section, _, kind = of.partition(".")
    if kind:
        from rosorin_compile.language.mentions import mentions

        named, joints = sorted(mentions(tree, (kind,), section), key=lambda one: str(one.path[1])), _joints(robot)
        return {one.name: joints.get(one.name, "") for one in named}
    if of not in {field.name for field in fields(robot)}:
        return dict.fromkeys(tree.get(of) or (), "")
    return {one.name: _said(robot, one) for one in getattr(robot, of)}


def _said(robot: Robot, entry: Any) -> str:
    """Return what an entry is, in few words."""
    from rosorin_compile.model import Joint, Link, Output, Sensor

    if isinstance(entry, Link):
        return _above(robot, entry.name)
    if isinstance(entry, Joint):
        return f"{entry.type}, {entry.parent} -> {entry.child}"
    if isinstance(entry, Sensor):
        return entry.type
    return entry.file if isinstance(entry, Output) else ""


def _in_text(path: Path, of: str) -> dict[str, str]:
    """Return the names that stand in the YAML files beside a description, whatever else is in them."""
    if is_foreign(path):
        return {}
    kinds, sections = _text(path)
    asked = _IN_TEXT.get(of) or of.split(".")[1:]
    found = [name for kind in asked for name in kinds.get(kind, ())] if asked else sections.get(of, ())
    return dict.fromkeys(found, "")


@cache
def _text(path: Path) -> _Text:
    """Return the names that the lines of files have: of a file that is no YAML just now, too."""
    from rosorin_compile.language.annotations import sections

    files = [path] if path.name.count(".") and path.parent == Path() else sorted(path.parent.glob("*.y*ml"))
    kinds: dict[str, list[str]] = {}
    entries: dict[str, list[str]] = {}
    said = sections()
    words = {section: _giving(node) for section, node in said.items()}
    for file in files[:50]:
        with suppress(OSError):
            section, depth = "", 0
            for line in read_bytes(file, 1_000_000).decode("utf-8", "replace").splitlines():
                top, entry = _SECTION.match(line), _ENTRY.match(line)
                if top:
                    section, depth = top[1], 0
                indent = len(line) - len(line.lstrip())
                if entry and (not depth or indent <= depth):
                    depth = indent
                    entries.setdefault(section, []).append(entry[1])
                    keys = said[section].keys if section in said else None
                    kinds.setdefault(keys.gives if keys else section, []).append(entry[1])
                for word, kind in words.get(section, {}).items():
                    kinds.setdefault(kind, []).extend(re.findall(rf"\b{word}: *[\"']?([A-Za-z_]\w*)", line))
    return kinds, entries


def _giving(node: Node) -> dict[str, str]:
    """Return the words of a section whose texts give names, each with the kind of them."""
    found: dict[str, str] = {}
    for word, below in node.properties.items():
        if below is not None:
            found |= ({word: below.gives} if below.gives and not below.scope else {}) | _giving(below)
    for below in (node.others, node.items):
        found |= _giving(below) if below is not None else {}
    return found

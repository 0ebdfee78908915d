"""Names for shell completion: robots, frames, joints, poses, arguments and formats.

Nothing that a description names is run: a xacro file offers only the names of its arguments.
"""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from .registry import names

if TYPE_CHECKING:
    from rosorin_compile.language.arguments import Argument
    from rosorin_compile.model import Robot

SECONDS = 1.5  # how long a person waits for a description to be read
_MAX_ROBOTS = 8
_XACRO_ARGUMENT = re.compile(r"<xacro:arg\s[^>]*?name=[\"']([^\"']+)[\"']")

Offers = Iterable[str]
Complete = Callable[[click.Context, click.Parameter, str], "list[CompletionItem]"]


def of(*kinds: str) -> Complete:
    """Return a completion with the names of these kinds; "joint=" offers joints, each with an equals sign."""

    def offered(ctx: click.Context, _: click.Parameter, incomplete: str) -> list[CompletionItem]:
        found: dict[str, str] = {}
        for kind in kinds:
            suffix = "=" if kind.endswith("=") else ":=" if kind == "argument" else ""
            with suppress(Exception):
                for name, help in _names(kind.removesuffix("="), ctx).items():
                    found.setdefault(name + suffix, help)
        items = [
            CompletionItem(name, help=" ".join(help.split()) or None)
            for name, help in found.items()
            if name.startswith(incomplete) and name.isprintable()
        ]
        return items or (files(ctx, _, incomplete) if {"robot", "file"} & set(kinds) else [])

    return offered


def files(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Let the shell complete files."""
    return [CompletionItem(incomplete, type="file")]


def commands(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the names of commands."""
    return [CompletionItem(name) for name in names("commands") if name.startswith(incomplete)]


def _names(kind: str, ctx: click.Context) -> dict[str, str]:
    """Return the names of one kind, each with a short help."""
    if kind in _PLAIN:
        return _PLAIN[kind]()
    paths = _paths(ctx)
    found: dict[str, str] = {}
    for path in paths:
        if kind == "argument":
            of_robot = {one.name: one.help for one in _arguments(path)}
        else:
            robot = _robot(path, ctx)
            of_robot = {} if robot is None else _OF_ROBOT[kind](robot)
        for name, help in of_robot.items():
            found.setdefault(name, help if len(paths) == 1 else f"{path.parent.name} {help}")
    return found


def _paths(ctx: click.Context) -> list[Path]:
    """Return the files of the robots that the line names, else of the robots here."""
    from rosorin_compile.source.project import Description, here

    found = []
    for word in ctx.params.get("words") or ():
        with suppress(Exception):
            found.append(Description.find([word])[0].path)
    return (found or [one.path for one in here()])[:_MAX_ROBOTS]


def _arguments(path: Path) -> list[Argument]:
    from rosorin_compile.language.arguments import Argument, declared
    from rosorin_compile.source.diagnostics import Source, Span

    from .robots import is_foreign

    if is_foreign(path):
        span = Span(Source(str(path), ""), 1, 1, 1)
        names = _XACRO_ARGUMENT.findall(path.read_text("utf-8", "replace"))
        return [Argument(name, "any", (), False, "", "argument of the xacro", span) for name in names]
    with _time_limit():
        return declared(path, {})[0]


def _robot(path: Path, ctx: click.Context) -> Robot | None:
    """Return a robot that is read without running anything, or None."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.output.pipeline import understand

    from .foreign import understand_foreign
    from .robots import is_foreign

    arguments = dict(text.split("=", 1) for text in ctx.params.get("arg") or () if "=" in text)
    with _time_limit():
        if not is_foreign(path):
            found = understand(path, arguments, _refuse_xacro, {})
        elif any(one.reading.takes_arguments and path.suffix.lower() in one.endings for one in FORMATS.values()):
            return None
        else:
            found = understand_foreign(path, {}, {}, _refuse_xacro)
        return found.lowered.robot if found.lowered is not None else None


def _refuse_xacro(_: object) -> None:
    """Stop before a xacro file runs."""
    raise ValueError("a xacro file could run code")


@contextmanager
def _time_limit() -> Iterator[None]:
    """Raise TimeoutError in the block after a while; there is no limit without signals, as on Windows."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise TimeoutError

    if not hasattr(signal, "SIGALRM"):
        yield
        return
    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _frames(robot: Robot) -> dict[str, str]:
    from rosorin_compile.model.kinematics.graph import Graph

    sensors = {sensor.frame: f"{sensor.name}, {sensor.type}" for sensor in robot.sensors}
    return {name: sensors.get(name, "") for name in Graph(robot).frames}


def _joints(robot: Robot) -> dict[str, str]:
    return {joint.name: f"{joint.type}, {joint.parent} -> {joint.child}" for joint in robot.joints}


_OF_ROBOT: dict[str, Callable[[Robot], dict[str, str]]] = {
    "frame": _frames,
    "joint": _joints,
    "link": lambda robot: {link.name: "" for link in robot.links},
    "thing": lambda robot: {**_frames(robot), **_joints(robot), **{one.name: one.type for one in robot.sensors}},
    "pose": lambda robot: {pose.name: "" for pose in robot.poses},
    "mode": lambda robot: {f"{mode}{state}": "" for mode in robot.modes for state in ("", "=off")},
    "output": lambda robot: {output.name: output.file for output in robot.outputs},
}


def _robots() -> dict[str, str]:
    from rosorin_compile.source.project import all_here

    return {path.parent.name: "robot of this project" for path in all_here()}


def _formats() -> dict[str, str]:
    from rosorin_compile.formats import FORMATS

    return {one.name: one.about for one in FORMATS.values() if one.write is not None}


def _rules() -> dict[str, str]:
    from .rule import every

    return dict.fromkeys(sorted(every()), "")


def _schemas() -> dict[str, str]:
    from rosorin_compile.formats.schemas import schema_names

    return dict(schema_names())


_PLAIN: dict[str, Callable[[], dict[str, str]]] = {
    "robot": _robots,
    "check": lambda: names("checks"),
    "format": _formats,
    "rule": _rules,
    "schema": _schemas,
    "file": dict,
}

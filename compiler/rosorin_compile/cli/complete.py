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
    from rosorin_compile.model import Robot
    from rosorin_compile.source.project import Description

SECONDS = 3.0  # how long a person waits for a description to be read
_MAX_ROBOTS = 8
_XACRO_ARGUMENT = re.compile(r"<xacro:arg\s[^>]*?name=[\"']([^\"']+)[\"']")

Offers = Iterable[str]
Complete = Callable[[click.Context, click.Parameter, str], "list[CompletionItem]"]


def of(*kinds: str) -> Complete:
    """Return a completion with the names of these kinds; "joint=" offers joints, each with an equals sign."""

    def offered(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
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
        return items or (files(ctx, param, incomplete) if {"robot", "file"} & set(kinds) else [])

    return offered


def files(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Let the shell complete files."""
    return [CompletionItem(incomplete, type="file")]


def _names(kind: str, ctx: click.Context) -> dict[str, str]:
    """Return the names of one kind, each with a short help."""
    if kind not in ("argument", *_OF_ROBOT):
        return _fixed_names(kind)
    robots = _descriptions(ctx)
    found: dict[str, str] = {}
    for one in robots:
        for name, help in (_arguments(one.path) if kind == "argument" else _OF_ROBOT[kind](_robot(one, ctx))).items():
            found.setdefault(name, help if len(robots) == 1 else f"{one.name} {help}")
    return found


def _fixed_names(kind: str) -> dict[str, str]:
    """Return the names of a kind that does not depend on a robot."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.formats.schemas import schema_names
    from rosorin_compile.source.project import all_here
    from rosorin_compile.source.rule_registry import every_rule

    if kind == "robot":
        return {path.parent.name: "robot of this project" for path in all_here()}
    if kind == "format":
        return {one.name: one.about for one in FORMATS.values() if one.write is not None}
    if kind == "rule":
        return dict.fromkeys(sorted(every_rule()), "")
    return schema_names() if kind == "schema" else names(kind) if kind in ("commands", "checks") else {}


def _descriptions(ctx: click.Context) -> list[Description]:
    """Return the robots that the line names, else the robots here."""
    from rosorin_compile.source.project import Description, here

    found = []
    for word in ctx.params.get("words") or ():
        with suppress(Exception):
            found.append(Description.find([word])[0])
    return (found or here())[:_MAX_ROBOTS]


def _arguments(path: Path) -> dict[str, str]:
    from rosorin_compile.language.arguments import declared
    from rosorin_compile.request import is_foreign

    if is_foreign(path):
        return dict.fromkeys(_XACRO_ARGUMENT.findall(path.read_text("utf-8", "replace")), "argument of the xacro")
    with _time_limit():
        return {one.name: one.help for one in declared(path, {})[0]}


def _robot(description: Description, ctx: click.Context) -> Robot:
    """Return a robot that is read without running anything. Raises ValueError for another one."""
    from rosorin_compile.request import Request

    arguments = dict(text.split("=", 1) for text in ctx.params.get("arg") or () if "=" in text)
    with _time_limit():
        case = Request(description, arguments, warn=_refuse_xacro).understand().case
    if case is None:
        raise ValueError("the description has errors")
    return case.robot


def _refuse_xacro(_: object) -> None:
    """Stop before a xacro file runs."""
    raise ValueError("a xacro file can run code")


@contextmanager
def _time_limit() -> Iterator[None]:
    """Raise TimeoutError in the block after a while; there is no limit without signals, as on Windows."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise TimeoutError

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
    "thing": lambda robot: {**_frames(robot), **_joints(robot), **{one.name: one.type for one in robot.sensors}},
    "pose": lambda robot: {pose.name: "" for pose in robot.poses},
    "mode": lambda robot: {f"{mode}{state}": "" for mode in robot.modes for state in ("", "=off")},
    "output": lambda robot: {output.name: output.file for output in robot.outputs},
}

"""Static transforms of hand-written launch files, held against the description.

Launch files in Python, XML and YAML are read and never run.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from rosorin_compile.model import (
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    Joint,
    Pose,
    Publisher,
    Robot,
    Transform,
)
from rosorin_compile.output.ros_packages import is_launch_file
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Source, Span
from rosorin_compile.source.files import read_bytes
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, fixed

from ..launch_reader import LaunchError, nodes_of
from .options import STAMP
from .starting import STATICS

PUBLISHER = "static_transform_publisher"
_MOST = 500  # static transforms in one file
_MAX_LAUNCH = 1_000_000  # bytes
# Less than these is the rounding of somebody who typed the number: 0.01 mm, 0.006 deg.
METRES, RADIANS = 1e-5, 1e-4
_XYZ = ("--x", "--y", "--z")
_RPY = ("--roll", "--pitch", "--yaw")
_QUATERNION = ("--qx", "--qy", "--qz", "--qw")
_FRAMES = ("--frame-id", "--child-frame-id")
_OLD_EULER = (*_XYZ, "--yaw", "--pitch", "--roll", *_FRAMES)
_OLD_QUATERNION = (*_XYZ, *_QUATERNION, *_FRAMES)


@dataclass(frozen=True)
class Call:
    """A static_transform_publisher of a launch file: its line, and its arguments, None if they are not plain."""

    line: int
    arguments: tuple[str, ...] | None


@dataclass(frozen=True)
class Understood:
    """What one static_transform_publisher is told: its frames, and the texts of its numbers by flag."""

    parent: str
    child: str
    texts: dict[str, str]
    transform: Transform


def calls(name: str, text: str) -> list[Call]:
    """Return the static transforms that a launch file starts, in its order. Raises LaunchError."""
    nodes = nodes_of(Source(name, text)) if PUBLISHER in text else ()
    ours = islice((node for node in nodes if node.executable == PUBLISHER), _MOST)
    return [Call(node.span.line, _plain(node.arguments)) for node in ours]


def _plain(arguments: tuple[str | None, ...] | None) -> tuple[str, ...] | None:
    words = [word for word in arguments or () if word is not None]
    return None if arguments is None or len(words) < len(arguments) else tuple(words)


def understood(arguments: Sequence[str]) -> Understood | None:
    """Return what arguments say, read as static_transform_publisher does; None if it would refuse them.

    The old form without flags has yaw before pitch and roll (``ros2/geometry2@{humble,jazzy}``).
    """
    if arguments and not arguments[0].startswith("--") and len(arguments) in (8, 9):
        texts = dict(zip(_OLD_EULER if len(arguments) == 8 else _OLD_QUATERNION, arguments, strict=True))
    elif len(arguments) % 2:
        return None
    else:
        texts = dict(zip(arguments[::2], arguments[1::2], strict=True))
    if not texts.keys() <= {*_XYZ, *_RPY, *_QUATERNION, *_FRAMES} or not all(texts.get(flag) for flag in _FRAMES):
        return None
    if texts.keys() & {*_RPY} and texts.keys() & {*_QUATERNION}:
        return None
    try:
        numbers = {flag: float(text) for flag, text in texts.items() if flag not in _FRAMES}
    except ValueError:
        return None
    if not all(map(math.isfinite, numbers.values())):
        return None
    x, y, z, roll, pitch, yaw, qx, qy, qz = (numbers.get(flag, 0.0) for flag in (*_XYZ, *_RPY, *_QUATERNION[:3]))
    transform = Pose((x, y, z), (roll, pitch, yaw)).transform()
    if numbers.keys() & {*_QUATERNION}:
        try:
            transform = Transform.of_quaternion((x, y, z), (numbers.get("--qw", 1.0), qx, qy, qz))
        except ValueError:  # all are zero
            return None
    parent, child = (texts[flag].lstrip("/") for flag in _FRAMES)
    return Understood(parent, child, texts, transform)


def check(robot: Robot, source: Source, call: Call) -> Iterator[Diagnostic]:
    """Yield what is wrong with one static transform of a launch file."""
    word = re.match(r"\s*(<?[\w.]*)", source.line(call.line))
    start, end = word.span(1) if word else (0, 1)
    span = Span(source, call.line, start + 1, max(1, end - start))
    if call.arguments is None:
        message = "the arguments of this static_transform_publisher are known only when the launch file runs"
        yield report("deployed-launch-unread", message, span, severity=NOTE)
        return
    static = understood(call.arguments)
    if static is None:
        yield report("deployed-launch-refused", "static_transform_publisher refuses these arguments", span)
        return
    joint, edge = robot.joint_to.get(static.child), f"{static.parent} -> {static.child}"
    owners = [one.publisher for one in robot.edges if one.child == static.child]
    if joint is not None:
        owners = [one.publisher for one in robot.turns.get(joint.name, ())] or [joint.publisher]
    if not owners:
        yield report("deployed-launch-unknown", f"{edge} is no frame of the description", span)
    elif joint is not None and any(owner.kind == STATIC_TRANSFORM_PUBLISHER for owner in owners):
        if parts := list(_differences(joint, static)):
            yield report("deployed-launch-differs", f"{edge} is not as described: {', '.join(parts)}", span)
    else:
        names = " or ".join(dict.fromkeys(map(_name, owners)))
        message = f"{edge} is published here, but the description gives it to {names}"
        yield report("deployed-launch-owner", message, span)


def _name(owner: Publisher) -> str:
    if not owner.publishes:
        return "nobody"
    return f"{owner.name}, from the URDF" if owner.kind == ROBOT_STATE_PUBLISHER else owner.name


def _differences(joint: Joint, static: Understood) -> Iterator[str]:
    described = joint.origin.transform()
    if static.parent != joint.parent:
        yield f"parent {static.parent} -> {joint.parent}"
    for flag, here, there in zip(_XYZ, static.transform.xyz, described.xyz, strict=True):
        if abs(here - there) > METRES:
            yield f"{flag} {static.texts.get(flag, '0')} -> {fixed(there, METRE_DIGITS)}"
    off = static.transform.angle_to(described)
    degrees = f"rotation {math.degrees(off):.3g} deg off"
    if off > RADIANS and static.texts.keys() & {*_QUATERNION}:
        w, x, y, z = described.quaternion()
        values = zip(_QUATERNION, (x, y, z, w), strict=True)
        yield f"{degrees}, described: {' '.join(f'{flag} {fixed(value, 9)}' for flag, value in values)}"
    elif off > RADIANS:
        for flag, there in zip(_RPY, joint.origin.rpy, strict=True):
            if abs(float(static.texts.get(flag, "0")) - there) > RADIANS:
                yield f"{flag} {static.texts.get(flag, '0')} -> {fixed(there, RADIAN_DIGITS)}"
        yield degrees


def check_launch_files(robot: Robot, folder: Path, files: Sequence[str], ours: Sequence[str]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the static transforms of launch files; ``ours`` are artifacts, compared already."""
    published: dict[str, str] = {}
    complete, any_publisher = True, bool(ours)
    for name in files:
        if name in ours or not is_launch_file(name) or (folder / name).stat().st_size > _MAX_LAUNCH:
            continue
        data = read_bytes(folder / name)
        if name.endswith(f"/{STATICS}") and STAMP.encode() in data[:1000]:
            continue  # it has the numbers from the description itself
        source = Source(str(folder / name), data.decode("utf-8", "replace"))
        try:
            found = calls(name, source.text)
        except LaunchError as problem:
            yield report("deployed-launch-unread", f"{source.path}: {problem}", severity=WARNING)
            complete = False
            continue
        any_publisher = any_publisher or PUBLISHER in source.text
        for call in found:
            static = None if call.arguments is None else understood(call.arguments)
            published |= {static.child: name} if static else {}
            complete = complete and static is not None
            yield from check(robot, source, call)
    joints = robot.published_by(STATIC_TRANSFORM_PUBLISHER)
    children = [joint.child for joint in joints if joint.child in published]
    if ours and children:
        own = ", ".join(dict.fromkeys(published[child] for child in children))
        message = f"{own} and {', '.join(ours)} both publish {', '.join(children)}"
        yield report("deployed-static-twice", message)
    for joint in joints if not ours and complete and any_publisher else ():
        if joint.child not in published:
            message = f"no launch file in {folder} publishes {joint.parent} -> {joint.child} ({joint.publisher.name})"
            yield report("deployed-static-missing", message)

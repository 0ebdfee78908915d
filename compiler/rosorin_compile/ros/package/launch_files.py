"""Static transforms of hand-written launch files, held against the description.

Launch files in Python, XML and YAML are read and never run; the few expressions of Python that say a number are
evaluated.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

from rosorin_compile.model import (
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    Joint,
    Pose,
    Publisher,
    Robot,
    Transform,
)
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Source, Span
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, fixed

from ..launch_reader import nodes_of

# Less than these is the rounding of somebody who typed the number: 0.01 mm, 0.006 deg.
METRES, RADIANS = 1e-5, 1e-4
_XYZ = ("--x", "--y", "--z")
_RPY = ("--roll", "--pitch", "--yaw")
_QUATERNION = ("--qx", "--qy", "--qz", "--qw")
_FRAMES = ("--frame-id", "--child-frame-id")
_OLD_EULER = (*_XYZ, "--yaw", "--pitch", "--roll", *_FRAMES)
_OLD_QUATERNION = (*_XYZ, *_QUATERNION, *_FRAMES)


@dataclass(frozen=True)
class Understood:
    """What one static_transform_publisher is told: its frames, and the texts of its numbers by flag."""

    parent: str
    child: str
    texts: dict[str, str]
    transform: Transform


def understood(arguments: Sequence[str]) -> Understood | None:
    """Return what arguments say, read as static_transform_publisher does; None if it would refuse them.

    The old form without flags has yaw before pitch and roll (``ros2/geometry2@{humble,jazzy}``).
    """
    if arguments and not arguments[0].startswith("--") and len(arguments) in (8, 9):
        names = _OLD_EULER if len(arguments) == 8 else _OLD_QUATERNION
        texts = dict(zip(names, arguments, strict=True))
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
        transform = _transform(numbers)
    except ValueError:
        return None
    parent, child = (texts[flag].lstrip("/") for flag in _FRAMES)
    return Understood(parent, child, texts, transform)


def _transform(numbers: dict[str, float]) -> Transform:
    if not all(map(math.isfinite, numbers.values())):
        raise ValueError
    x, y, z = (numbers.get(flag, 0.0) for flag in _XYZ)
    if numbers.keys() & {*_QUATERNION}:
        qx, qy, qz = (numbers.get(flag, 0.0) for flag in _QUATERNION[:3])
        return Transform.of_quaternion((x, y, z), (numbers.get("--qw", 1.0), qx, qy, qz))
    roll, pitch, yaw = (numbers.get(flag, 0.0) for flag in _RPY)
    return Pose((x, y, z), (roll, pitch, yaw)).transform()


def check(robot: Robot, source: Source, call: Call) -> Iterator[Diagnostic]:
    """Yield what is wrong with one static transform of a launch file."""
    word = re.match(r"\s*(<?[\w.]*)", source.line(call.line))
    start, end = word.span(1) if word else (0, 1)
    span = Span(source, call.line, start + 1, max(1, end - start))
    if call.arguments is None:
        message = "the arguments of this static_transform_publisher are known only when the launch file runs"
        yield Diagnostic("deployed-launch-unread", NOTE, message, span, (), "compare them with frames.md yourself")
        return
    static = understood(call.arguments)
    if static is None:
        help = "--x --y --z, --roll --pitch --yaw or --qx --qy --qz --qw, --frame-id, --child-frame-id, "
        message = "static_transform_publisher refuses these arguments"
        yield Diagnostic("deployed-launch-refused", ERROR, message, span, (), f"{help}each with a value")
        return
    joint, edge = robot.joint_to.get(static.child), f"{static.parent} -> {static.child}"
    owners = [one.publisher for one in robot.edges if one.child == static.child]
    names = [owner.name for owner in owners]
    if joint is not None:
        owners = [one.publisher for one in robot.turns.get(joint.name, ())] or [joint.publisher]
        names = [_name(owner) for owner in owners]
    if joint is None and not owners:
        help = "a sensor or an edge of the description makes it known to all artifacts"
        message = f"{edge} is no frame of the description"
        yield Diagnostic("deployed-launch-unknown", WARNING, message, span, (), help)
    elif joint is not None and any(owner.kind == STATIC_TRANSFORM_PUBLISHER for owner in owners):
        if parts := list(_differences(joint, static)):
            message = f"{edge} is not as described: {', '.join(parts)}"
            help = "write these values into the launch file, or read them from static_tf.json"
            yield Diagnostic("deployed-launch-differs", ERROR, message, span, (), help)
    else:
        message = f"{edge} is published here, but the description gives it to {' or '.join(dict.fromkeys(names))}"
        yield Diagnostic("deployed-launch-owner", ERROR, message, span, (), "publish it once")


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


PUBLISHER = "static_transform_publisher"
_MOST = 500  # static transforms in one file


@dataclass(frozen=True)
class Call:
    """A static_transform_publisher of a launch file: its line, and its arguments, None if they are not plain."""

    line: int
    arguments: tuple[str, ...] | None


def calls(name: str, text: str) -> list[Call]:
    """Return the static transforms that a launch file starts, in its order. Raises LaunchError."""
    nodes = nodes_of(Source(name, text)) if PUBLISHER in text else ()
    ours = islice((node for node in nodes if node.executable == PUBLISHER), _MOST)
    return [Call(node.span.line, _plain(node.arguments)) for node in ours]


def _plain(arguments: tuple[str | None, ...] | None) -> tuple[str, ...] | None:
    words = [word for word in arguments or () if word is not None]
    return None if arguments is None or len(words) < len(arguments) else tuple(words)

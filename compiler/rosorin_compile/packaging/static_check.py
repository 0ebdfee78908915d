"""Static transforms of hand-written launch files, held against the description."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..diagnostic import ERROR, NOTE, WARNING, Diagnostic, Source, Span
from ..formatting import METRE_DIGITS, RADIAN_DIGITS, fixed
from ..model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, UNPUBLISHED, Joint, Publisher, Robot
from ..model.geometry import Pose, Transform, transform_of_quaternion
from ..registry import PACKAGES, Rule
from .static_calls import Call

RULES = (
    Rule(
        "deployed-launch-differs",
        "A launch file gives a static transform other values, or another parent.",
        "Write the described values into it.",
        PACKAGES,
    ),
    Rule(
        "deployed-launch-owner",
        "A launch file publishes a frame that belongs to another node.",
        "Publish it once.",
        PACKAGES,
    ),
    Rule(
        "deployed-launch-refused",
        "static_transform_publisher would refuse its arguments.",
        "Correct them.",
        PACKAGES,
    ),
    Rule(
        "deployed-launch-unknown",
        "A warning: a launch file publishes a frame that is not described.",
        "Describe it.",
        PACKAGES,
    ),
)

# Less than these is the rounding of somebody who typed the number: 0.01 mm, 0.006 deg.
METRES, RADIANS = 1e-5, 1e-4
_XYZ = ("--x", "--y", "--z")
_RPY = ("--roll", "--pitch", "--yaw")
_QUATERNION = ("--qx", "--qy", "--qz", "--qw")
_FRAMES = ("--frame-id", "--child-frame-id")
_OLD_EULER = (*_XYZ, "--yaw", "--pitch", "--roll", *_FRAMES)
_OLD_QUATERNION = (*_XYZ, *_QUATERNION, *_FRAMES)


class Understood(NamedTuple):
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
        return transform_of_quaternion((x, y, z), (numbers.get("--qw", 1.0), qx, qy, qz))
    roll, pitch, yaw = (numbers.get(flag, 0.0) for flag in _RPY)
    return Pose((x, y, z), (roll, pitch, yaw)).transform()


def check(robot: Robot, source: Source, call: Call) -> Iterator[Diagnostic]:
    """Yield what is to say about one static transform of a launch file."""
    span = _beginning(source, call.line)
    if call.arguments is None:
        message = "the arguments of this static_transform_publisher are known only when the launch file runs"
        yield Diagnostic("deployed-launch-unread", NOTE, message, span, (), "compare them with frames.md yourself")
        return
    static = understood(call.arguments)
    if static is None:
        message = "static_transform_publisher refuses these arguments"
        help = (
            "--x --y --z, --roll --pitch --yaw or --qx --qy --qz --qw, --frame-id, --child-frame-id, each with a value"
        )
        yield Diagnostic("deployed-launch-refused", ERROR, message, span, (), help)
        return
    joint = robot.joint_to.get(static.child)
    if joint is None:
        yield from _not_a_link(robot, static, span)
    elif any(owner.kind == STATIC_TRANSFORM_PUBLISHER for owner in _owners(robot, joint)):
        yield from _compared(joint, static, span)
    else:
        yield _owned(_owners(robot, joint), static, span)


def _owners(robot: Robot, joint: Joint) -> tuple[Publisher, ...]:
    """Return who publishes a joint: one, or those who take turns by mode."""
    return tuple(edge.publisher for edge in robot.turns.get(joint.name, ())) or (joint.publisher,)


def _beginning(source: Source, line: int) -> Span:
    """Return the first word of a line as a place."""
    text = source.line(line)
    word = re.match(r"\s*(<?[\w.]*)", text)
    start, end = word.span(1) if word else (0, 1)
    return Span(source, line, start + 1, max(1, end - start))


def _not_a_link(robot: Robot, static: Understood, span: Span) -> Iterator[Diagnostic]:
    edges = [edge for edge in robot.edges if edge.child == static.child]
    if edges:
        names = " or ".join(dict.fromkeys(edge.publisher.name for edge in edges))
        message = f"{static.parent} -> {static.child} is published here, but the description gives it to {names}"
        yield Diagnostic("deployed-launch-owner", ERROR, message, span, (), "publish it once")
    else:
        message = f"{static.parent} -> {static.child} is no frame of the description"
        help = "a sensor or an edge of the description makes it known to all artifacts"
        yield Diagnostic("deployed-launch-unknown", WARNING, message, span, (), help)


def _owned(owners: Sequence[Publisher], static: Understood, span: Span) -> Diagnostic:
    who = " or ".join(dict.fromkeys(_named(owner) for owner in owners))
    message = f"{static.parent} -> {static.child} is published here, but the description gives it to {who}"
    return Diagnostic("deployed-launch-owner", ERROR, message, span, (), "publish it once")


def _named(owner: Publisher) -> str:
    urdf = f"{owner.name}, from the URDF"
    return {ROBOT_STATE_PUBLISHER: urdf, UNPUBLISHED: "nobody"}.get(owner.kind, owner.name)


def _compared(joint: Joint, static: Understood, span: Span) -> Iterator[Diagnostic]:
    """Yield one diagnostic for all that differs between a launch file and a joint."""
    parts = [f"parent {static.parent} -> {joint.parent}"] if static.parent != joint.parent else []
    meant = joint.origin.transform()
    for flag, here, there in zip(_XYZ, static.transform.xyz, meant.xyz, strict=True):
        if abs(here - there) > METRES:
            parts.append(f"{flag} {static.texts.get(flag, '0')} -> {fixed(there, METRE_DIGITS)}")
    off = static.transform.angle_to(meant)
    if off > RADIANS:
        parts += _angles(static, joint, off)
    if parts:
        message = f"{static.parent} -> {static.child} is not as described: {', '.join(parts)}"
        help = "write these values into the launch file, or read them from static_tf.json"
        yield Diagnostic("deployed-launch-differs", ERROR, message, span, (), help)


def _angles(static: Understood, joint: Joint, off: float) -> list[str]:
    degrees = f"{math.degrees(off):.3g} deg off"
    if static.texts.keys() & {*_QUATERNION}:
        w, x, y, z = joint.origin.transform().quaternion()
        values = zip(_QUATERNION, (x, y, z, w), strict=True)
        return [f"rotation {degrees}, described: " + " ".join(f"{flag} {fixed(v, 9)}" for flag, v in values)]
    pairs = [
        f"{flag} {static.texts.get(flag, '0')} -> {fixed(there, RADIAN_DIGITS)}"
        for flag, there in zip(_RPY, joint.origin.rpy, strict=True)
        if abs(float(static.texts.get(flag, "0")) - there) > RADIANS
    ]
    return [*pairs, f"rotation {degrees}"]

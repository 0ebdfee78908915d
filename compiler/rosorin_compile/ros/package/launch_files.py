"""Static transforms of handwritten launch files, compared with the description.

Launch files in Python, XML and YAML are read and never run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
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
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Source
from rosorin_compile.source.files import read_bytes
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, fixed

from ..launch_reader import LaunchError, LaunchNode, nodes_of
from .launch import STATICS
from .options import STAMP

PUBLISHER = "static_transform_publisher"
_MAX_LAUNCH = 1_000_000  # bytes
# Smaller differences are rounding errors of numbers typed by hand: 0.01 mm, 0.006 deg.
METRES, RADIANS = 1e-5, 1e-4
_XYZ = ("--x", "--y", "--z")
_RPY = ("--roll", "--pitch", "--yaw")
_QUATERNION = ("--qx", "--qy", "--qz", "--qw")
_FRAMES = ("--frame-id", "--child-frame-id")
# The flags of the old form, by its number of arguments. Yaw comes before pitch and roll.
_WITHOUT_FLAGS = {8: (*_XYZ, "--yaw", "--pitch", "--roll", *_FRAMES), 9: (*_XYZ, *_QUATERNION, *_FRAMES)}


@dataclass(frozen=True)
class StaticTransform:
    """A transform of a launch file, with the texts of its arguments by flag."""

    parent: str
    child: str
    texts: dict[str, str]
    transform: Transform


def static_nodes(source: Source) -> list[LaunchNode]:
    """Return the static_transform_publishers that a launch file starts. Raises LaunchError."""
    nodes = nodes_of(source) if PUBLISHER in source.text else ()
    return [node for node in nodes if node.executable == PUBLISHER]


def parse_arguments(words: Sequence[str]) -> StaticTransform | None:
    """Return the transform of the arguments of static_transform_publisher, or None if it refuses them.

    It reads them as ``ros2/geometry2@{humble,jazzy}`` does.
    """
    if len(words) in _WITHOUT_FLAGS and not words[0].startswith("--"):
        texts = dict(zip(_WITHOUT_FLAGS[len(words)], words, strict=True))
    else:
        texts = dict(zip(words[::2], words[1::2], strict=False))
        if len(words) % 2 or not texts.keys() <= {*_XYZ, *_RPY, *_QUATERNION, *_FRAMES}:
            return None
    if not all(texts.get(flag) for flag in _FRAMES) or (texts.keys() & {*_RPY} and texts.keys() & {*_QUATERNION}):
        return None
    try:
        numbers = {flag: float(text) for flag, text in texts.items() if flag not in _FRAMES}
        x, y, z, roll, pitch, yaw, qx, qy, qz = (numbers.get(flag, 0.0) for flag in (*_XYZ, *_RPY, *_QUATERNION[:3]))
        transform = Pose((x, y, z), (roll, pitch, yaw)).transform()
        if numbers.keys() & {*_QUATERNION}:
            transform = Transform.of_quaternion((x, y, z), (numbers.get("--qw", 1.0), qx, qy, qz))
    except ValueError:  # a text is no number, or the quaternion is zero
        return None
    if not all(map(math.isfinite, numbers.values())):
        return None
    parent, child = (texts[flag].lstrip("/") for flag in _FRAMES)
    return StaticTransform(parent, child, texts, transform)


def static_transform(node: LaunchNode) -> StaticTransform | None:
    """Return the transform of a static_transform_publisher, or None if it is unknown or refused."""
    words = [word for word in node.arguments or () if word is not None]
    return parse_arguments(words) if node.arguments is not None and len(words) == len(node.arguments) else None


def check_node(robot: Robot, node: LaunchNode) -> Iterator[Diagnostic]:
    """Yield what is wrong with a static_transform_publisher of a launch file."""
    if node.arguments is None or None in node.arguments:
        message = "the arguments of this static_transform_publisher are known only when the launch file runs"
        yield report("deployed-launch-unread", message, node.span, severity=NOTE)
        return
    static = static_transform(node)
    if static is None:
        yield report("deployed-launch-refused", "static_transform_publisher refuses these arguments", node.span)
        return
    joint, edge = robot.joint_to.get(static.child), f"{static.parent} -> {static.child}"
    owners = [one.publisher for one in robot.edges if one.child == static.child]
    if joint is not None:
        owners = [one.publisher for one in robot.turns.get(joint.name, ())] or [joint.publisher]
    if not owners:
        yield report("deployed-launch-unknown", f"{edge} is no frame of the description", node.span)
    elif joint is not None and any(owner.kind == STATIC_TRANSFORM_PUBLISHER for owner in owners):
        if parts := list(_differences(joint, static)):
            yield report("deployed-launch-differs", f"{edge} is not as described: {', '.join(parts)}", node.span)
    else:
        names = dict.fromkeys(map(_owner, owners))
        message = f"{edge} is published here, but the description gives it to {' or '.join(names)}"
        yield report("deployed-launch-owner", message, node.span)


def _owner(publisher: Publisher) -> str:
    if not publisher.publishes:
        return "nobody"
    return f"{publisher.name}, from the URDF" if publisher.kind == ROBOT_STATE_PUBLISHER else publisher.name


def _differences(joint: Joint, static: StaticTransform) -> Iterator[str]:
    described = joint.origin.transform()
    if static.parent != joint.parent:
        yield f"parent {static.parent} -> {joint.parent}"
    for flag, here, there in zip(_XYZ, static.transform.xyz, described.xyz, strict=True):
        if abs(here - there) > METRES:
            yield f"{flag} {static.texts.get(flag, '0')} -> {fixed(there, METRE_DIGITS)}"
    off = static.transform.angle_to(described)
    if off <= RADIANS:
        return
    degrees = f"rotation {math.degrees(off):.3g} deg off"
    if static.texts.keys() & {*_QUATERNION}:
        w, x, y, z = described.quaternion()
        values = zip(_QUATERNION, (x, y, z, w), strict=True)
        yield f"{degrees}, described: {' '.join(f'{flag} {fixed(value, 9)}' for flag, value in values)}"
        return
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
            continue  # it takes the numbers from the description at launch
        source = Source(str(folder / name), data.decode("utf-8", "replace"))
        try:
            nodes = static_nodes(source)
        except LaunchError as problem:
            yield report("deployed-launch-unread", f"{source.path}: {problem}", severity=WARNING)
            complete = False
            continue
        any_publisher = any_publisher or PUBLISHER in source.text
        for node in nodes:
            static = static_transform(node)
            published |= {static.child: name} if static else {}
            complete = complete and static is not None
            yield from check_node(robot, node)
    joints = robot.published_by(STATIC_TRANSFORM_PUBLISHER)
    children = [joint.child for joint in joints if joint.child in published]
    if ours and children:
        own = ", ".join(dict.fromkeys(published[child] for child in children))
        yield report("deployed-static-twice", f"{own} and {', '.join(ours)} both publish {', '.join(children)}")
    for joint in joints if not ours and complete and any_publisher else ():
        if joint.child not in published:
            message = f"no launch file in {folder} publishes {joint.parent} -> {joint.child} ({joint.publisher.name})"
            yield report("deployed-static-missing", message)

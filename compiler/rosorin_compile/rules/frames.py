"""Frames by the conventions of ROS: REP 103 for image frames, REP 105 for the frames of the world."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from rosorin_compile.model import Pose, Transform
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import FRAMES, rule
from rosorin_compile.source.tree import Path

from .case import Case
from .kinematics import WORLD_FRAMES
from .magnitudes import FULL_TURN

# REP 103, "Suffix Frames": z forward, x right, y down, seen from a body frame with x forward, y left, z up.
OPTICAL = Pose(rpy=(-math.pi / 2, 0.0, -math.pi / 2)).transform()
SUFFIXES = ("_optical", "_optical_frame", "_optical_link")
TOLERANCE = 1e-3  # rad
CALIBRATION = 0.2  # rad; the image frames of one device differ by what the maker calibrated, never by much


@rule("owns-world-frame", help="Begin the robot at `base_link`.", topic=FRAMES, accept="link", imported="always")
def world_frames(case: Case) -> Iterator[Diagnostic]:
    """The description owns `map`, `odom` or `earth`, which localisation places (REP 105); `edges` may name them."""
    robot = case.robot
    for frame in WORLD_FRAMES:
        ends = [
            case.end(joint, end)
            for joint in robot.joints
            for end in ("parent", "child")
            if getattr(joint, end) == frame
        ]
        at = case.link(frame) if frame in robot.link else next(iter(ends), None)
        if at is not None:
            message = f'the description owns the frame "{frame}", which localisation places (REP 105)'
            help = f'begin the robot at "base_link" and name the publisher of "{frame}" under edges'
            key = frame in robot.link and at[0] == "links"
            problem = case.problem("owns-world-frame", message, at, help, key=key)
            # Without a link of that name there is nothing that could be accepted.
            yield problem if frame in robot.link else replace(problem, of=())


@rule("optical-frame", help="Write `rpy: [-90 deg, 0, -90 deg]`.", topic=FRAMES, accept="link", imported="always")
def optical_frames(case: Case) -> Iterator[Diagnostic]:
    """An image frame is not turned as REP 103 says: z out of the lens, x right, y down."""
    robot = case.robot
    declared = {sensor.optical_frame for sensor in robot.sensors if sensor.optical_frame}
    steps = [(one.parent, one.child, one.origin, case.joint(one)) for one in robot.joints]
    steps += [
        (edge.parent, edge.child, edge.pose, ("edges", index))
        for index, edge in enumerate(robot.edges)
        if edge.pose is not None and not edge.joint
    ]
    for parent, child, pose, path in steps:
        is_image = child in declared or child.endswith(SUFFIXES)
        if not is_image or any(abs(angle) > FULL_TURN for angle in pose.rpy):  # degrees have a rule of their own
            continue
        at = case.value(path, "rpy")
        is_pair = parent in declared or parent.endswith(SUFFIXES)
        off = pose.transform().angle_to(Transform() if is_pair else OPTICAL)
        turned = "[" + ", ".join(f"{math.degrees(angle):.4g}" for angle in pose.rpy) + "] deg"
        message = f'image frame "{child}" is turned by rpy {turned} against '
        if is_pair and off > CALIBRATION:
            message += f'the image frame "{parent}"'
            help = "the axes of two image frames agree (REP 103); leave rpy out, or let its parent be a body frame"
            yield case.problem("optical-frame", message, at, help, key=at == path)
        elif not is_pair and off > TOLERANCE:
            message += f'"{parent}"; REP 103 requires [-90, 0, -90] deg (z out of the lens, x right, y down)'
            help = "write rpy: [-90 deg, 0, -90 deg]; a camera that is tilted has a body frame for that, x forward"
            yield case.problem("optical-frame", message, at, help, key=at == path)


@rule("optical-mount", help="Leave `rpy` out: the frame of a camera has x forward, y left, z up.", topic=FRAMES)
def optical_mounts(case: Case) -> Iterator[Diagnostic]:
    """A warning: a camera with an optical frame is itself mounted with the rotation of an optical frame."""
    for sensor in case.robot.sensors:
        mount = case.robot.joint_to.get(sensor.frame)
        if not sensor.optical_frame or sensor.optical_frame == sensor.frame or mount is None:
            continue
        if mount.origin.transform().angle_to(OPTICAL) <= TOLERANCE:
            place: Path = case.value(case.joint(mount), "rpy")
            message = f'the frame "{sensor.frame}" of {sensor.type} "{sensor.name}" is mounted with the rotation of an'
            message += f' optical frame, and its optical frame "{sensor.optical_frame}" is turned again'
            yield case.problem("optical-mount", message, place, key=place[-1] != "rpy")

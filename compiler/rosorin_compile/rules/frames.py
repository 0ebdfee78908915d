"""Frames by the conventions of ROS: REP 103 for image frames, REP 105 for the frames of the world."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from rosorin_compile.model import Pose, Transform
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import FRAMES, rule
from rosorin_compile.source.tree import Path, exists

from .case import Case
from .kinematics import WORLD_FRAMES
from .magnitudes import FULL_TURN

# REP 103, "Suffix Frames": z forward, x right, y down, seen from a body frame with x forward, y left, z up.
OPTICAL = Pose(rpy=(-math.pi / 2, 0.0, -math.pi / 2)).transform()
SUFFIXES = ("_optical", "_optical_frame", "_optical_link")
TOLERANCE = 1e-3  # rad

# Two imagers of one device: their image frames differ by what the maker calibrated, never by much.
CALIBRATION = 0.2  # rad


@rule(
    "owns-world-frame",
    "The description owns `map`, `odom` or `earth`, which localisation places (REP 105).",
    "Begin the robot at `base_link`, and name the publisher under `edges`.",
    FRAMES,
    accept="link",
    imported="always",
)
def world_frames(case: Case) -> Iterator[Diagnostic]:
    """Links, joints and sensors that would own map, odom or earth; ``edges`` may."""
    robot = case.robot
    for frame in WORLD_FRAMES:
        if frame not in robot.link and frame not in robot.joints_from and frame not in robot.joint_to:
            continue
        at: Path | None = case.link(frame) if frame in robot.link else None
        key = at is not None and at[0] == "links"
        for joint in robot.joints:
            for which in ("parent", "child"):
                if at is None and getattr(joint, which) == frame:
                    at = case.end(joint, which)
        if at is not None:
            message = f'the description owns the frame "{frame}", which localisation places (REP 105)'
            help = f'begin the robot at "base_link" and say who publishes "{frame}" under edges'
            problem = case.problem("owns-world-frame", message, at, help, key=key)
            # Without a link of that name there is nothing that could be accepted.
            yield problem if frame in robot.link else replace(problem, of=())


@rule(
    "optical-frame",
    "An image frame is not turned as REP 103 says: z out of the lens, x right, y down.",
    "`rpy: [-90 deg, 0, -90 deg]`; tilt the frame of the camera instead.",
    FRAMES,
    accept="link",
    imported="always",
)
def optical_frames(case: Case) -> Iterator[Diagnostic]:
    """Image frames that are not turned against the frame that they sit on as REP 103 says."""
    robot = case.robot
    declared = {sensor.optical_frame for sensor in robot.sensors if sensor.optical_frame}
    for joint in robot.joints:
        if joint.child in declared or joint.child.endswith(SUFFIXES):
            yield from _turned(case, joint.parent, joint.child, joint.origin, case.joint(joint), declared)
    for index, edge in enumerate(robot.edges):
        if edge.pose is not None and not edge.joint and edge.child.endswith(SUFFIXES):
            yield from _turned(case, edge.parent, edge.child, edge.pose, ("edges", index), declared)


def _turned(case: Case, parent: str, child: str, pose: Pose, path: Path, declared: set[str]) -> Iterator[Diagnostic]:
    """Yield a problem if an image frame is turned wrongly; angles that look like degrees have a rule of their own."""
    if any(abs(angle) > FULL_TURN for angle in pose.rpy):
        return
    turn = pose.transform()
    at = (*path, "rpy") if exists(case.tree, (*path, "rpy")) else path
    turned = "[" + ", ".join(f"{math.degrees(angle):.4g}" for angle in pose.rpy) + "] deg"
    if parent in declared or parent.endswith(SUFFIXES):
        off = turn.angle_to(Transform())
        if off > CALIBRATION:
            message = f'image frame "{child}" sits on the image frame "{parent}" and is turned by rpy {turned}'
            help = "the axes of two image frames agree (REP 103); leave rpy out, or let it sit on a body frame"
            yield case.problem("optical-frame", message, at, help, key=at == path)
        return
    off = turn.angle_to(OPTICAL)
    if off > TOLERANCE:
        message = (
            f'image frame "{child}" is turned by rpy {turned} against "{parent}"; REP 103 asks for [-90, 0, -90] deg'
            f" (z out of the lens, x right, y down): off by {math.degrees(off):.3g} deg"
        )
        help = "write rpy: [-90 deg, 0, -90 deg]; a camera that is tilted has a body frame for that, x forward"
        yield case.problem("optical-frame", message, at, help, key=at == path)


@rule(
    "optical-mount",
    "A warning: a camera with an optical frame is itself mounted with the rotation of an optical frame.",
    "Leave `rpy` of the camera out: its frame has x forward, and the optical frame turns by itself.",
    FRAMES,
)
def optical_mounts(case: Case) -> Iterator[Diagnostic]:
    """Cameras that are turned to the optical axes twice: by their mount and by their optical frame."""
    robot = case.robot
    for sensor in robot.sensors:
        mount = robot.joint_to.get(sensor.frame)
        if not sensor.optical_frame or sensor.optical_frame == sensor.frame or mount is None:
            continue
        if mount.origin.transform().angle_to(OPTICAL) > TOLERANCE:
            continue
        path = case.joint(mount)
        place = (*path, "rpy") if exists(case.tree, (*path, "rpy")) else path
        message = (
            f'the frame "{sensor.frame}" of {sensor.type} "{sensor.name}" is mounted with the rotation of an optical'
            f' frame, and its optical frame "{sensor.optical_frame}" is turned again'
        )
        help = "leave rpy out: the frame of a camera has x forward, y left, z up; the optical frame does the rest"
        yield case.problem("optical-mount", message, place, help, severity=WARNING, key=place == path)

"""Simulate the robot for a second from zero and from each pose: it should stay in one piece, and where it is.

The root is held in the world, actuators hold the pose, gravity pulls. Meshes take no part: overlaps of their hulls are
reported by ``overlaps``. A robot that cannot be simulated is reported by the rules of its format.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Joint, Link, Mesh, Robot
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic
from rosorin_compile.source.rule_registry import Heading, Rule

from ..simulate.world import FIXED, Refused, SimulationDiverged, World, describe_joint, mjcf_text, quiet, single_joints
from .overlaps import State

RULES = (
    Rule(
        "explodes-at-rest",
        "Left alone for a second in MuJoCo, the positions of the robot become infinite. A warning where a joint gets "
        "faster than any joint is, or is driven out of its limits.",
        "Look for parts that start inside each other, masses and inertias that are far too small, gains that are far "
        "too large.",
        Heading.PHYSICS,
    ),
    Rule(
        "sinks-at-rest",
        "A warning: left alone for a second in MuJoCo, an actuator does not hold its joint against gravity.",
        "Check the mass that it carries, `kp` of the actuator, and the effort of the joint.",
        Heading.PHYSICS,
    ),
)

SECONDS = 1.0
FASTEST = 300.0  # rad/s or m/s: a light link that hangs without damping gets to 100 rad/s by gravity
SUNK, SUNK_SLIDE = math.radians(10), 0.02  # m
BEYOND = 0.1  # rad or m out of the limits: bounds are soft
_HELP = "look for parts that start inside each other, for masses and inertias far too small, for gains far too large"


class _Second(NamedTuple):
    """The end of a second: positions (rad or m) and the loads (N or N*m) at its begin, and the fastest joint."""

    positions: dict[str, float]
    load: dict[str, float]
    fastest: tuple[float, float, str]  # rad/s or m/s, after how many seconds, which joint


def check_rest(case: Case, states: Sequence[State], tick: Callable[[], None]) -> list[Diagnostic]:
    """Simulate a second from each state and return what is wrong then; calls ``tick`` after each state."""
    found: dict[tuple[str, str], Diagnostic] = {}
    with quiet() as mujoco:
        try:
            robot = _without_meshes(case.robot)
            world = World(mujoco, robot, mjcf_text(robot, None, Templates(), FIXED), FIXED, Path())
        except Refused:
            world = None  # check reports why
        for state in states:
            if world is not None:
                for one in _check_state(case, state, world):
                    found.setdefault((one.rule, "".join(one.of)), one)
            tick()
    return list(found.values())


def _without_meshes(robot: Robot) -> Robot:
    def primitives(link: Link) -> Link:
        solid = tuple(shape for shape in link.collision if not isinstance(shape.geometry, Mesh))
        return replace(link, collision=solid, visual=())

    return replace(robot, links=tuple(map(primitives, robot.links)))


def _check_state(case: Case, state: State, world: World) -> Iterator[Diagnostic]:
    try:
        second = _simulate(world, state)
    except SimulationDiverged as problem:
        message = f"left alone {state}, after {problem.time:.6g} s: {problem}"
        message += describe_joint(case.robot, problem.joint)
        yield replace(case.problem("explodes-at-rest", message, ("robot",), _HELP, severity=ERROR), of=())
        return
    speed, time, name = second.fastest
    if speed > FASTEST:
        joint = case.robot.joint[name]
        message = (
            f'left alone {state}, joint "{name}" gets to {speed:.0f} {joint.unit}/s within {time:.2g} s in MuJoCo'
            f"{describe_joint(case.robot, name)}"
        )
        yield case.problem("explodes-at-rest", message, case.joint(joint), _HELP, severity=WARNING, key=True)
        return
    for joint in case.robot.joints:
        if joint.moves and joint.mimic is None:
            yield from _check_joint(case, state, joint, second)


def _simulate(world: World, state: State) -> _Second:
    """Return the end of a second from a state. Raises SimulationDiverged."""
    joints = single_joints(world.robot)
    world.reset(state.positions)
    load = {joint.name: float(world.data.joint(joint.name).qfrc_bias[0]) for joint in joints}
    speeds = [world.data.joint(joint.name).qvel for joint in joints]
    fastest = (0.0, 0.0, "")
    for time in world.run(SECONDS):
        for joint, speed in zip(joints, speeds, strict=True):
            fastest = max(fastest, (abs(float(speed[0])), time, joint.name))
    return _Second({joint.name: world.position(joint.name) for joint in joints}, load, fastest)


def _check_joint(case: Case, state: State, joint: Joint, second: _Second) -> Iterator[Diagnostic]:
    """Yield a warning about a joint that left its limits, or that its actuator does not hold."""
    begun, now = state.positions.get(joint.name, 0.0), second.positions[joint.name]
    limit, slides, actuator = joint.limit, joint.type == "prismatic", joint.actuator
    moved = f"from {round(begun, 3):.6g} to {round(now, 3):.6g} {joint.unit} within a second in MuJoCo"
    if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
        low, high = limit.lower - BEYOND, limit.upper + BEYOND
        if low <= begun <= high and not low <= now <= high:
            message = f'left alone {state}, joint "{joint.name}" is driven out of its limits, {moved}'
            help, path = "look for parts that start inside each other", case.joint(joint, "limit")
            yield case.problem("explodes-at-rest", message, path, help, severity=WARNING, key=True)
            return
    load = second.load[joint.name]  # a part that is pushed out of another one does not move against its load
    sinks = abs(now - begun) > (SUNK_SLIDE if slides else SUNK) and (now - begun) * load <= 0
    if actuator is None or not actuator.holds_position or not sinks:
        return
    force = "N" if slides else "N*m"
    effort = f" and an effort of {limit.effort:.6g} {force}" if limit and limit.effort else ""
    message = (
        f'left alone {state}, joint "{joint.name}" sinks {moved}: it carries {abs(load):.3g} {force}, held by kp'
        f" {actuator.kp or 0.0:.6g}{effort}"
    )
    help = "check the mass that it carries, kp of its actuator, and its effort"
    yield case.problem("sinks-at-rest", message, case.joint(joint, "actuator"), help, severity=WARNING, key=True)

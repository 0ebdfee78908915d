"""The robot left to itself for a second, from zero and from each pose: it should stay in one piece, and where it is.

The root is held in the world, actuators hold the pose, gravity pulls. Meshes take no part: their hulls are told where
they overlap. What the format for simulation refuses is told by its rules, and not simulated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Joint, Robot
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic
from rosorin_compile.source.rule_registry import Heading, Rule

from ..simulate.moved import first_to_go, moved
from ..simulate.world import FIXED, Refused, joint_of, moving, quiet, set_joints, simulated, without_meshes
from .overlaps import ZERO, State

RULES = (
    Rule(
        "explodes-at-rest",
        "Left to itself for a second in MuJoCo, the robot leaves the numbers. A warning where a joint gets faster than "
        "any joint is, or is driven out of its limits.",
        "Look for parts that start inside each other, masses and inertias that are far too small, gains that are far "
        "too large.",
        Heading.PHYSICS,
    ),
    Rule(
        "sinks-at-rest",
        "A warning: left to itself for a second in MuJoCo, an actuator does not hold its joint against gravity.",
        "Check the mass that it carries, `kp` of the actuator, and the effort of the joint.",
        Heading.PHYSICS,
    ),
)

SECONDS = 1.0
FASTEST = 300.0  # rad/s or m/s: a light link that hangs without damping gets to 100 rad/s by gravity
SUNK = math.radians(10)
SUNK_SLIDE = 0.02  # m
BEYOND = 0.1  # rad or m out of the limits: bounds are soft


class _Ended(NamedTuple):
    """How a second ended: when it left the numbers, the fastest joint, and where the joints are (rad or m).

    ``first`` is the joint that left the numbers, as MuJoCo says it.
    """

    broken: float | None
    fastest: tuple[float, float, str]
    positions: dict[str, float]
    load: dict[str, float]
    first: str = ""


def diagnose_rest(case: Case, states: Sequence[State], tick: Callable[[], None]) -> list[Diagnostic]:
    """Let the robot move for a second from each state, and return what is wrong then.

    What MuJoCo itself prints, or would write into MUJOCO_LOG.TXT, is dropped.
    """
    found: dict[tuple[str, str], Diagnostic] = {}
    with quiet() as mujoco:
        model = _model(mujoco, case.robot)
        for state in states:
            if model is not None:
                for one in _judged(case, state, _simulated(mujoco, case.robot, model, state)):
                    found.setdefault((one.rule, "".join(one.of)), one)
            tick()
    return list(found.values())


def _model(mujoco: Any, robot: Robot) -> Any:
    """Return the robot in MuJoCo without its meshes; None if it cannot be simulated."""
    try:
        return mujoco.MjModel.from_xml_string(simulated(without_meshes(robot), None, Templates(), FIXED))
    except (Refused, ValueError):
        return None  # check tells why


def _simulated(mujoco: Any, robot: Robot, model: Any, state: State) -> _Ended:
    """Return what becomes of the robot in a second."""
    import numpy as np

    data = mujoco.MjData(model)
    if state.name != ZERO:
        key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, state.name)
        mujoco.mj_resetDataKeyframe(model, data, key)
    set_joints(robot, data, state.positions)
    mujoco.mj_forward(model, data)
    joints = moving(robot)
    load = {joint.name: float(data.joint(joint.name).qfrc_bias[0]) for joint in joints}
    speeds = [data.joint(joint.name).qvel for joint in joints]
    fastest = (0.0, 0.0, "")
    broken = None
    while data.time < SECONDS and broken is None:
        before = data.time
        mujoco.mj_step(model, data)
        for joint, speed in zip(joints, speeds, strict=True):
            fastest = max(fastest, (abs(float(speed[0])), data.time, joint.name))
        if data.time <= before or not np.isfinite(data.qpos).all():  # MuJoCo begins anew where numbers end
            broken = before
    positions = {joint.name: float(data.joint(joint.name).qpos[0]) for joint in joints}
    return _Ended(broken, fastest, positions, load, _first(mujoco, model, data) if broken is not None else "")


def _first(mujoco: Any, model: Any, data: Any) -> str:
    """Return the joint that MuJoCo warned of; empty if it warned of none."""
    warned = (
        joint_of(model, mujoco.mjtWarning(index).name, int(data.warning.lastinfo[index]))
        for index in range(len(data.warning.number))
        if data.warning.number[index]
    )
    return next(filter(None, warned), "")


def _judged(case: Case, state: State, ended: _Ended) -> Iterator[Diagnostic]:
    where = f'in pose "{state.name}"' if state.name != ZERO else "at zero"
    help = "look for parts that start inside each other, for masses and inertias far too small, for gains far too large"
    if ended.broken is not None:
        message = f"left to itself {where}, the robot leaves the numbers after {ended.broken:.6g} s in MuJoCo"
        message += first_to_go(case.robot, ended.first)
        yield replace(case.problem("explodes-at-rest", message, ("robot",), help, severity=ERROR), of=())
        return
    speed, time, name = ended.fastest
    if speed > FASTEST:
        joint = case.robot.joint[name]
        message = (
            f'left to itself {where}, joint "{name}", {moved(case.robot, name)}, gets to {speed:.0f} {_unit(joint)}/s'
            f" within {time:.2g} s in MuJoCo"
        )
        yield case.problem("explodes-at-rest", message, case.joint(joint), help, severity=WARNING, key=True)
        return
    for joint in case.robot.joints:
        if joint.moves and joint.mimic is None:
            yield from _placed(case, state, where, joint, ended)


def _placed(case: Case, state: State, where: str, joint: Joint, ended: _Ended) -> Iterator[Diagnostic]:
    """Yield a warning about a joint that is not where it was left."""
    begun, now = state.positions.get(joint.name, 0.0), ended.positions[joint.name]
    limit, unit = joint.limit, _unit(joint)
    moved = f"from {round(begun, 3):.6g} to {round(now, 3):.6g} {unit} within a second in MuJoCo"
    if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
        started_inside = limit.lower - BEYOND <= begun <= limit.upper + BEYOND
        if started_inside and not limit.lower - BEYOND <= now <= limit.upper + BEYOND:
            message = f'left to itself {where}, joint "{joint.name}" is driven out of its limits, {moved}'
            path = case.joint(joint, "limit")
            help = "look for parts that start inside each other, and at the masses that it carries"
            yield case.problem("explodes-at-rest", message, path, help, severity=WARNING, key=True)
            return
    if (
        joint.actuator is None
        or not joint.actuator.holds_position
        or abs(now - begun) <= (SUNK_SLIDE if joint.type == "prismatic" else SUNK)
    ):
        return
    load = ended.load[joint.name]  # what holds it: it sinks the other way
    if (now - begun) * load > 0:
        return  # pushed by a part that it started in, which is told
    force = "N" if joint.type == "prismatic" else "N*m"
    effort = f" and an effort of {limit.effort:.6g} {force}" if limit and limit.effort else ""
    message = (
        f'left to itself {where}, joint "{joint.name}" sinks {moved}: it carries'
        f" {abs(load):.3g} {force}, held by kp {joint.actuator.kp or 0.0:.6g}{effort}"
    )
    help = "check the mass that it carries, kp of its actuator, and its effort"
    yield case.problem("sinks-at-rest", message, case.joint(joint, "actuator"), help, severity=WARNING, key=True)


def _unit(joint: Joint) -> str:
    return "m" if joint.type == "prismatic" else "rad"

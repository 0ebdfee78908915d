"""Rules about joint positions: limits, servo ranges, and mimic joints."""

import math
import re
from collections.abc import Iterator
from typing import Any

from rosorin_compile.language.annotations import Node
from rosorin_compile.language.schema import sections
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Joint, Robot
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, POSES, rule
from rosorin_compile.source.tree import Map, Path
from rosorin_compile.source.wording import quote

from .case import Case, number
from .joints import circles

# rad or m: tolerance, because positions that are computed from pulses may exceed rounded limits.
ROUNDING = 1e-6
# Mimic joints approximate a linkage, so they may exceed their limits by this fraction of the range.
SLACK = 0.05
SHOWN = 8
# rad per pulse: servos typically have a hundredth of this; only geared servos have more.
COARSE = 0.1
# The ranges of a servo and its joint may differ by an unspecified gear ratio, but not by this factor.
OTHER_RANGE = 20.0
SEVERAL_TURNS = 4 * math.pi
_INITIAL = r"<initial_position>\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*<"


@rule("beyond-joint-limit", "A warning: a value exceeds joint limits.", "Correct the value.", JOINTS, "joint", "always")
@rule("pose-beyond-limit", "A warning: a pose is beyond a joint limit.", "Correct the pose or the limit.", POSES)
@rule("mimic-beyond-limit", "A warning: a follower exceeds its limits.", "Correct `mimic`.", JOINTS, "joint", "always")
def within_limits(case: Case) -> Iterator[Diagnostic]:
    """Report positions, velocities and efforts beyond joint limits: values that the schema marks with ``x-within``."""
    for section, node in sections().items():
        for id, path, name, value in _bounded(node, case.tree.get(section), (section,), ""):
            joint = case.robot.joint.get(name)
            if joint is not None and joint.moves and (id != "pose-beyond-limit" or joint.mimic is None):
                yield from _compare(case, id, joint, path, value)
    # Joints that a pose does not name are at zero. A pose of a planning group covers only the joints of the group.
    moveit = case.robot.moveit
    states = {pose for group in (moveit.groups if moveit else ()) for pose in (group.states or {}).values()}
    placed = {name for pose in case.robot.poses for name in pose.positions}
    for joint in case.robot.joints:
        for pose in case.robot.poses if joint.mimic is None and joint.moves and joint.name in placed else ():
            if joint.name not in pose.positions and pose.name not in states:
                yield from _compare(case, "pose-beyond-limit", joint, ("poses", pose.name), 0.0)
        safety, ends = joint.safety, range_of(joint)
        if joint.type == "continuous" and safety and (safety.soft_lower_limit or safety.soft_upper_limit):
            message = f'joint "{joint.name}" is continuous, so its soft limits have no effect'
            path = case.joint(joint, "safety_controller")
            yield case.problem("beyond-joint-limit", message, path, "remove the soft limits", within=True)
        for index, text in enumerate(joint.urdf_elements):
            for value in (value for value in map(float, re.findall(_INITIAL, text)) if not _has(ends, value)):
                message = f'the initial position of joint "{joint.name}" is {number(value)}, outside its limits'
                yield case.problem("beyond-joint-limit", message, case.joint(joint, "urdf_elements", index))


def _bounded(node: Node, value: Any, path: Path, joint: str) -> Iterator[tuple[str, Path, str, Any]]:
    if node.within and isinstance(value, (int, float, Map)):
        yield node.within, path, joint, value
    names = node.keys is not None and "joint" in (node.keys.gives, node.keys.names)
    for key, inner in value.items() if isinstance(value, dict) else ():
        below = node.value_of(key)
        if below is not None and (below.within or isinstance(inner, dict)):
            yield from _bounded(below, inner, (*path, key), key if names else joint)


def _compare(case: Case, id: str, joint: Joint, path: Path, value: Any) -> Iterator[Diagnostic]:
    soft = joint.safety.soft_lower_limit if joint.safety and path[-1] == "soft_upper_limit" else None
    if soft is not None and soft >= value:
        message = f'the soft limits of joint "{joint.name}" allow no motion'
        yield case.problem(id, message, path[:-1], "widen or remove the soft limits", within=True)
    interface = str(path[-2]) if path[-2] in ("velocity", "effort") else "position"
    lower, upper = joint.limits_of(interface)
    if id in ("pose-beyond-limit", "mimic-beyond-limit") and joint.limit and joint.type != "continuous":
        lower, upper = joint.limit.lower, joint.limit.upper  # include stand-in limits
    low, high = -math.inf if lower is None else lower, math.inf if upper is None else upper
    if low > high or (lower is None and upper is None) or (id == "control-limit" and path[-3] != "command"):
        return
    what, slack, limit = f'"{path[-1]}" sets', ROUNDING, case.joint(joint, "limit")
    related, first, last = [], value, value
    if id == "mimic-beyond-limit":
        leader = case.robot.joint.get(joint.mimic.joint) if joint.mimic else None
        ends = range_of(leader) if leader is not None and leader.mimic is None and range_of(joint) else None
        if joint.mimic is None or leader is None or ends is None:
            return
        first, last = sorted(joint.mimic.multiplier * end + joint.mimic.offset for end in ends)
        slack, what = SLACK * (high - low), f'mimicking "{leader.name}" moves'
        related.append(("the limits of the leader", case.joint(leader, "limit")))
        path = (*path, "offset" if abs(joint.mimic.offset) > max(abs(low), abs(high)) + slack else "multiplier")
    elif id == "pose-beyond-limit":
        first = last = case.robot.positions(str(path[1])).get(joint.name, 0.0)
        what = f'pose "{path[1]}" sets'
    if first < low - slack or last > high + slack:
        shown = number(first) if first == last else f"positions from {number(first)} to {number(last)}"
        message = f'{what} joint "{joint.name}" to {shown}, outside its limits of {number(low)} to {number(high)}'
        message += f" {joint.unit}" if interface == "position" else ""
        related.append(("the limit", case.value(limit, "lower" if first < low - slack else "upper")))
        message += case.stand_in(limit)
        yield case.problem(id, message, path, related=related, severity=WARNING, key=len(path) == 2)


def range_of(joint: Joint) -> tuple[float, float] | None:
    """Return the (lower, upper) limit of a joint (rad or m), or None if a limit is missing or lower >= upper."""
    limit = joint.limit
    if joint.type not in ("revolute", "prismatic") or limit is None or limit.lower is None or limit.upper is None:
        return None
    return (limit.lower, limit.upper) if limit.lower < limit.upper else None


def _has(ends: tuple[float, float] | None, value: float) -> bool:
    return ends is None or ends[0] - ROUNDING <= value <= ends[1] + ROUNDING


@rule("zero-beyond-limit", help="Add a pose in which every joint is within its limits.", topic=POSES)
def zeros(case: Case) -> Iterator[Diagnostic]:
    """A note: a joint that no pose sets starts simulations at zero, which is outside its limits."""
    placed = {name for pose in case.robot.poses for name in pose.positions}
    joints = [joint for joint in case.robot.joints if joint.mimic is None and joint.name not in placed]
    away = [joint for joint in joints if not _has(range_of(joint), 0.0)]
    if away:
        names = quote([joint.name for joint in away], SHOWN)
        message = f"simulations start with all joints at zero, which is outside the limits of {names}"
        lower, _ = range_of(away[0]) or (0.0, 0.0)
        path = case.joint(away[0], "limit", "lower" if lower > 0 else "upper")
        yield case.problem("zero-beyond-limit", message, path)


@rule("joint-has-no-position", "A servo or pose names a planar or floating joint.", "Remove it from this entry.", POSES)
@rule("joint-is-fixed", "A servo turns or a pose moves a joint that is fixed.", "Name a joint that moves.", POSES)
def placed_joints(case: Case) -> Iterator[Diagnostic]:
    """Report poses that set fixed joints, mimic joints, joints with several coordinates, or a fixed base."""
    outputs = [one for one in case.robot.outputs if one.backend in case.formats]
    has_base = any("base" in case.formats[one.backend].options for one in outputs)
    is_free = any(one.options.get("base") == "free" for one in outputs)
    for pose in case.robot.poses:
        for name in pose.positions:
            joint = case.robot.joint.get(name)
            path: Path = ("poses", pose.name, "pulses" if name in pose.pulses else "positions", name)
            if joint is not None and not joint.moves and name not in pose.pulses:
                yield _motionless(case, joint, path, f'pose "{pose.name}" sets', key=True)
            elif joint is not None and joint.moves and joint.mimic is not None:
                message = f'pose "{pose.name}" sets joint "{name}", but that joint mimics "{joint.mimic.joint}"'
                yield case.problem("ignored-key", message, path, f'set joint "{joint.mimic.joint}" instead', key=True)
        # With MoveIt, ``base`` sets the virtual joint, so it is valid.
        if pose.base is not None and has_base and not is_free and case.robot.moveit is None:
            message = f'pose "{pose.name}" sets the pose of the base, but the base is fixed in every output'
            path, help = ("poses", pose.name, "base"), 'write "base: free" in the output'
            yield case.problem("ignored-key", message, path, help, severity=NOTE, key=True)


def _motionless(case: Case, joint: Joint, path: Path, what: str, key: bool = False) -> Diagnostic:
    id = "joint-is-fixed" if joint.is_fixed else "joint-has-no-position"
    return case.problem(id, f'{what} joint "{joint.name}", which is {joint.type}', path, key=key)


@rule("two-servos", "A joint is in two servo groups.", "Remove the joint from one of them.", POSES)
def groups(case: Case) -> Iterator[Diagnostic]:
    """Report servos of joints that are fixed or have several coordinates, and joints in two servo groups."""
    taken: dict[str, Path] = {}
    order = list(case.section("servos"))
    for group in sorted(case.robot.servos, key=lambda group: order.index(group.name)):
        for index, name in enumerate(group.joints):
            path: Path = ("servos", group.name, "joints", index)
            joint = case.robot.joint.get(name)
            if joint is not None and not joint.moves:
                yield _motionless(case, joint, path, f'servo group "{group.name}" lists')
            if name in taken and joint is not None:
                related = [("also listed here", taken[name])]
                yield case.problem("two-servos", f'joint "{name}" is in two servo groups', path, related=related)
            taken.setdefault(name, path)


@rule("servo-range", help="Write the angle of one pulse in radians, such as `${240*deg / 1000}`.", topic=POSES)
def scales(case: Case) -> Iterator[Diagnostic]:
    """A warning: one pulse would turn a servo by many degrees, or the pulse range differs widely from joint limits."""
    for group in case.robot.servos:
        joints = [case.robot.joint[name] for name in group.joints if name in case.robot.joint]
        path: Path = ("servos", group.name, "rad_per_pulse")
        step, reach = abs(group.rad_per_pulse), abs(group.rad_per_pulse) * (group.pulse_range[1] - group.pulse_range[0])
        message = f'the pulse range of servo group "{group.name}" covers {number(reach)} rad or m{case.stand_in(path)}'
        spans = [(joint, ends[1] - ends[0]) for joint in joints if (ends := range_of(joint))]
        wrong = next((one for one in spans if not 1 / OTHER_RANGE <= reach / one[1] <= OTHER_RANGE), None)
        if step >= COARSE and reach >= SEVERAL_TURNS and any(joint.type != "prismatic" for joint in joints):
            yield case.problem("servo-range", f"{message}, which looks like degrees", path)
        elif wrong:
            limit = case.joint(wrong[0], "limit")
            message += f', but the limits of joint "{wrong[0].name}" cover {number(wrong[1])}{case.stand_in(limit)}'
            yield case.problem("servo-range", message, path, related=[("the limits", limit)])


@rule("mimic-unknown", "A joint follows a joint that does not exist.", "Name its leader.", JOINTS)
@rule("mimic-fixed", "A joint without a position follows or leads.", "Mimic a moving joint.", JOINTS, "joint", "always")
@rule("mimic-cycle", "Joints follow each other in a circle.", "Remove `mimic` from one of these joints.", JOINTS)
def leaders(case: Case) -> Iterator[Diagnostic]:
    """Report mimic joints that form a loop, or whose leader is missing, fixed, or a joint with several coordinates."""
    robot = case.robot
    for joint in (joint for joint in robot.joints if joint.mimic):
        path, name = case.joint(joint, "mimic", "joint"), joint.mimic.joint if joint.mimic else ""
        leader, message = robot.joint.get(name), f'joint "{joint.name}" mimics "{name}"'
        if not joint.moves:
            message = f"{message}, but is itself {joint.type}"
            yield case.problem("mimic-fixed", message, path[:-1], 'remove "mimic", or correct the joint type', key=True)
        elif leader is None:
            moving = [other.name for other in robot.joints if other.moves and other is not joint]
            help = case.suggest(path, name, moving, "name a joint that moves")
            yield case.problem("mimic-unknown", f"{message}, but there is no such joint", path, help)
        elif not leader.moves:
            message += f", which is {leader.type} and cannot be mimicked"
            yield case.problem("mimic-fixed", message, path, related=[("the leader", case.joint(leader))])
    for names in circles(_leaders(robot)):
        first, *others = [case.joint(robot.joint[name], "mimic", "joint") for name in names]
        related = [(f'"mimic" of joint "{name}" is here', path) for name, path in zip(names[1:], others, strict=True)]
        message, fix = f"joints mimic each other in a loop: {' -> '.join([*names, names[0]])}", ""
        if not others:
            message, fix = f'joint "{names[0]}" mimics itself', 'name another joint in "mimic", or remove it'
        yield case.problem("mimic-cycle", message, first, fix, related=related)


def _leaders(robot: Robot) -> dict[str, str]:
    return {joint.name: joint.mimic.joint for joint in robot.joints if joint.mimic}


@rule("mimic-not-published", "A joint follows one that is not in the URDF.", "Give both the same publisher.", JOINTS)
@rule("mimic-chain", "A warning: a joint follows a follower.", "Follow the first leader.", JOINTS, "joint", "always")
def order(case: Case) -> Iterator[Diagnostic]:
    """Report mimic joints that robot_state_publisher cannot resolve.

    robot_state_publisher visits mimic joints once, sorted by name, so a leader that is itself a mimic joint must come
    first (ros/robot_state_publisher@humble:src/robot_state_publisher.cpp). Leaders must also be in the URDF.
    """
    in_circle = {name for names in circles(_leaders(case.robot)) for name in names}
    for joint in case.robot.published_by(ROBOT_STATE_PUBLISHER):
        mimic = joint.mimic
        leader = case.robot.joint.get(mimic.joint) if mimic else None
        if leader is None or mimic is None or leader is joint or not (joint.moves and leader.moves):
            continue
        path, message = case.joint(joint, "mimic", "joint"), f'joint "{joint.name}" mimics "{leader.name}"'
        if leader.publisher.kind != ROBOT_STATE_PUBLISHER:
            related = [("the publisher of the leader", case.publisher(leader))]
            yield case.problem("mimic-not-published", f"{message}, which is not in the URDF", path, related=related)
        elif leader.mimic and joint.name.encode() < leader.name.encode() and leader.name not in in_circle:
            first, offset = leader.mimic, mimic.multiplier * leader.mimic.offset + mimic.offset
            direct = f"joint: {first.joint}, multiplier: {number(mimic.multiplier * first.multiplier)}"
            help = f"mimic the first leader directly: {{{direct}{f', offset: {number(offset)}' if offset else ''}}}"
            message += ", itself a mimic joint that comes later by name: robot_state_publisher would not move it"
            yield case.problem("mimic-chain", message, path, help)

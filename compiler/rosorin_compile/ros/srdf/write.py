"""The SRDF of a robot, as text; it speaks of the links and joints of one URDF, and of no others.

Rules of the readers: ``ros-planning/srdfdom`` and ``moveit/moveit2@{humble,jazzy}:moveit_core/robot_model``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from markupsafe import Markup

from rosorin_compile.formats.templating import Templates, attributes, comment
from rosorin_compile.model import DisabledCollision, Output, Pose, Robot
from rosorin_compile.model.robot import JointPose
from rosorin_compile.ros.moveit import FIXED, PLANAR, Ball, Group
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, counted, error, first_of
from rosorin_compile.source.numbers import NumberFormat, number_format, vector
from rosorin_compile.source.rule_registry import Heading, Rule

from .matrix import RENEW, ordered, stale_pairs, stale_text
from .planning import Planning, planning_of

RULES = (
    Rule(
        "srdf-without-urdf",
        "An SRDF belongs to a URDF, and the robot has none among its outputs, or none of that name.",
        "Add `urdf` to `outputs`; `urdf` of `moveit` names one of several.",
        Heading.FORMATS,
    ),
    Rule(
        "srdf-cannot-say",
        "A note: a pair of links that are not to collide is not in the URDF, so that the SRDF leaves it out.",
        "Nothing, if that is meant. `frames: all` of a URDF has every link.",
        Heading.FORMATS,
    ),
)

NOTHING = Ball((0.0, 0.0, 0.0), 0.0)  # what a link has that touches nothing


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the SRDF of a robot. Option: ``number_format`` (short, exact or six)."""
    planning = planning_of(robot)
    if planning is None:
        message = f"{output.file} belongs to a URDF, and the robot has none among its outputs"
        return "", [error("srdf-without-urdf", message, None, "add urdf: {file: NAME.urdf} to outputs")]
    number = number_format(output.options)
    virtual = planning.virtual
    values: dict[str, Any] = {"robot": robot, "urdf": planning.urdf.file, "comment": comment, "attributes": attributes}
    values["groups"] = [_group(group) for group in planning.said.groups]
    values["states"] = [
        (attributes(name=state, group=group.name), _placed(planning, group, pose, number))
        for group in planning.said.groups
        for state, pose in planning.states(group).items()
    ]
    values["end_effectors"] = [
        attributes(
            name=one.name,
            parent_link=one.parent,
            group=one.group,
            **({"parent_group": one.parent_group} if one.parent_group else {}),
        )
        for one in planning.said.end_effectors
    ]
    values["virtual_joints"] = ()
    if virtual is not None:
        names = {"parent_frame": virtual.parent, "child_link": planning.root}
        values["virtual_joints"] = [attributes(name=virtual.name, type=virtual.type, **names)]
    values["properties"] = [
        attributes(joint_name=joint, property_name=name, value=value)
        for joint, said in planning.joint_properties().items()
        for name, value in said.items()
    ]
    values["spheres"] = [
        (attributes(link=link), [_ball(ball, number) for ball in balls or (NOTHING,)])
        for link, balls in planning.said.spheres.items()
    ]
    values["unchecked"] = [attributes(link=link) for link in planning.said.unchecked_links]
    pairs = sorted(map(ordered, planning.said.checked))
    values["checked"] = [attributes(link1=one, link2=other) for one, other in pairs]
    values["passive_joints"] = [attributes(name=name) for name in planning.said.passive_joints]
    values["computed"] = _computed(planning)
    values["disabled"] = [_disabled(one) for one in planning.disabled()]
    return templates.own("ros/robot.srdf.jinja", values), [*_of_meshes(planning), *_left_out(planning)]


def _group(group: Group) -> tuple[Markup, Markup | None, list[tuple[str, Markup]]]:
    """Return a group: its name, its chain, and what else it has, each by the name of its element."""
    chain = None
    if group.chain is not None:
        chain = attributes(base_link=group.chain[0], tip_link=group.chain[1])
    lists = (("joint", group.joints), ("link", group.links), ("group", group.groups))
    return attributes(name=group.name), chain, [(tag, attributes(name=name)) for tag, names in lists for name in names]


def _placed(planning: Planning, group: Group, pose: JointPose, number: NumberFormat) -> list[Markup]:
    """Return where a state puts the joints of a group, and the base if its virtual joint is in the group."""
    virtual, placed = planning.virtual, []
    for joint in planning.joints_in(group):
        if joint in pose.positions:
            placed.append(attributes(name=joint, value=number(pose.positions[joint])))
        elif virtual is not None and joint == virtual.name and pose.base is not None and virtual.type != FIXED:
            numbers = base_position(virtual.type, pose.base)
            value = " ".join(vector(some, number) for some in _apart(virtual.type, numbers))
            placed.append(attributes(name=joint, value=value))
    return placed


def base_position(kind: str, base: Pose) -> tuple[float, ...]:
    """Return the numbers of a virtual joint, as MoveIt counts them: x y theta, or x y z and a quaternion x y z w."""
    if kind == PLANAR:
        return (*base.xyz[:2], base.rpy[2])
    w, x, y, z = base.transform().quaternion()
    return (*base.xyz, x, y, z, w)


def _apart(kind: str, numbers: Sequence[float]) -> tuple[Sequence[float], Sequence[float]]:
    """Return the lengths and the rotation of a virtual joint."""
    lengths = 2 if kind == PLANAR else 3
    return numbers[:lengths], numbers[lengths:]


def _ball(ball: Ball, number: NumberFormat) -> Markup:
    return attributes(center=vector(ball.xyz, number), radius=number(ball.radius))


def _computed(planning: Planning) -> str:
    """Return how the pairs that need no check were found, in words; empty if nobody computed them."""
    matrix, search = planning.said.matrix, planning.said.search
    if matrix is None:
        return ""
    return (
        f"Computed by rosorin-compile collisions: {counted(matrix.states, 'random state')}, seed {search.seed}. Lengths"
        " are the smallest distances of the states that were tried."
    )


def _disabled(one: DisabledCollision) -> tuple[Markup, str]:
    """Return a pair as attributes, and a remark: how near they came."""
    remark = ""
    if one.nearest is not None:
        far = f"{abs(one.nearest) * 1000:.1f} mm"
        remark = f"{far} deep" if one.nearest < 0 else far
    elif one.beyond is not None:
        remark = f"more than {one.beyond * 1000:.4g} mm"
    return attributes(link1=one.links[0], link2=one.links[1], reason=one.reason), remark


def _of_meshes(planning: Planning) -> Iterator[Diagnostic]:
    """Yield a warning about pairs whose mesh files changed; the rule about all else is in ``checks``."""
    pairs, meshes = stale_pairs(planning)
    if meshes and pairs:
        message = f"{first_of(meshes, 3)} changed since the collision matrix was computed: {stale_text(pairs)}"
        yield Diagnostic("collisions-stale", WARNING, message, help=RENEW)


def _left_out(planning: Planning) -> Iterator[Diagnostic]:
    """Yield a note on pairs that are not to collide, of links that the URDF does not have, and not just simulations."""
    simulated = {joint.child for joint in planning.robot.joints if joint.publisher.simulated}
    said = (pair for pair in planning.robot.disabled_contacts if simulated.isdisjoint(pair))
    pairs = [pair for pair in said if not planning.links.issuperset(pair)]
    if pairs:
        names = first_of([" and ".join(pair) for pair in pairs], 3)
        message = f"not in the SRDF, because {planning.urdf.file} has not both links: disabled contacts of {names}"
        yield Diagnostic("srdf-cannot-say", NOTE, message)

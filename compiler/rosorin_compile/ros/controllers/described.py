"""Controllers of a description, checked for one output: types, parameters, and what disagrees with the robot."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any

from rosorin_compile.formats.format import described_by
from rosorin_compile.model import Edge, Output, Robot
from rosorin_compile.ros.sections.control.hardware import POSITION, VELOCITY
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, first_of, quoted
from rosorin_compile.source.tree import Path, Seq, at, exists

from ..parameters.checking import Finding, against_kind, unwritable
from ..parameters.files import asked
from ..parameters.tables import MANAGER, manager
from .checking import against_robot, claims, frames_of, missing
from .derived import owned
from .filled import Filled, filled, managed
from .types import full, of_type

_BLOCKS = "control"  # the option of a URDF that asks for hardware blocks
_BROADCASTER = "joint_state_broadcaster/JointStateBroadcaster"
_ENDS = (("odom_frame_id", "odom"), ("base_frame_id", "base_link"))


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find what is wrong with the controllers of a description in the distribution that an output is for.

    What is wrong in every distribution is reported for the first output alone.
    """
    distribution = asked(output)
    is_first = output.name == next(one for one in case.robot.outputs if one.backend == output.backend).name
    if not case.robot.controllers:
        message = f'output "{output.name}" is for controllers, and the description has none'
        help = "name them: controllers: {NAME: {type: diff_drive}}"
        yield case.problem("controllers-none", message, ("outputs", output.name), help, severity=WARNING, key=True)
    values = managed(output, distribution)
    for found in against_kind(f"the {MANAGER}", manager(distribution), values):
        yield _placed(case, found, ("outputs", output.name), ("manager",))
    if is_first:
        yield from _joint_states(case)
    yield from _apart(case, output)
    drive = case.robot.drive
    if not case.robot.is_tree or not all(name in case.robot.joint for name in _of_drive(case.robot)):
        return  # which has rules of its own
    if drive is not None and drive.frame and drive.frame not in case.robot.link:
        return  # and so has that
    every = filled(case.robot, distribution)
    for one in every:
        findings = list(_findings(case, one, distribution))
        for found in findings:
            yield _placed(case, found, ("controllers", one.controller.name), ("params",))
        wrong = {found.key for found in findings}
        if one.kind is not None and one.kind.odometry and not wrong & {key for key, _ in _ENDS}:
            yield from _odometry(case, one)
    if is_first:
        yield from _claimed(case, every)


def _claimed(case: Case, every: Iterable[Filled]) -> Iterator[Diagnostic]:
    """Yield the commands that two active controllers claim, once for each controller."""
    owners: dict[tuple[str, str], str] = {}
    for one in every:
        name, taken = one.controller.name, []
        for joint, word, key in () if one.controller.inactive else claims(one.type, one.values):
            owner = owners.setdefault((joint, word), name)
            if owner != name and joint in case.robot.joint:
                taken.append((owner, joint, word, key))
        if not taken:
            continue
        owner, _, word, key = taken[0]
        joints = quoted(dict.fromkeys(joint for of, joint, what, _ in taken if (of, what) == (owner, word)), most=4)
        message = f'controllers "{owner}" and "{name}" both claim the {word} of {joints}: the second one does not start'
        help = f"start one of them later: {name}: {{inactive: true}}; or give them other joints"
        path = _path(case, ("controllers", name, "params"), key)
        path = path if exists(case.tree, path) and path[-1] != "params" else ("controllers", name)
        related = [case.related("the first claim", ("controllers", owner), key=True)]
        yield case.problem("controller-interface", message, path, help, related=related, key=True)


def _joint_states(case: Case) -> Iterator[Diagnostic]:
    """Yield that no controller publishes the states of the hardware, or that moving joints have none."""
    robot, types = case.robot, [full(one.type) for one in case.robot.controllers]
    states = [(block, joint) for block in robot.control for joint in block.joints if joint.state]
    if not types or not states:
        return
    if any(one == _BROADCASTER or one.endswith("/JointStateBroadcaster") for one in types):
        yield from _motionless(case)
        return
    block, joint = states[0]
    message = f'no controller publishes the states that hardware block "{block.name}" has, such as that of '
    help = "controllers: {joint_state_broadcaster: {type: joint_state_broadcaster}}"
    place = ("controllers",)
    yield case.problem("controllers-joint-states", f'{message}"{joint.name}"', place, help, severity=WARNING, key=True)


def _motionless(case: Case) -> Iterator[Diagnostic]:
    for joint in case.robot.unmeasured_joints:
        message = f'no node publishes the position of joint "{joint.name}", which no hardware block has: '
        message += f'"{joint.child}" has no transform, and MoveIt waits for a complete state'
        help = (
            f"in control: joints: {{{joint.name}: {{state: [position]}}}}; or let a node publish the joint: publisher"
        )
        yield case.problem("controllers-joint-states", message, case.joint(joint), help, severity=WARNING, key=True)


def _apart(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield that all hardware blocks are written for another distribution."""
    blocks = {one.name: str(option) for one in case.robot.outputs if (option := one.options.get(_BLOCKS))}
    if not case.robot.control or not blocks or described_by(asked(output)) in map(described_by, blocks.values()):
        return
    name, option = next(iter(blocks.items()))
    message = (
        f'output "{output.name}" is for {asked(output).capitalize()}, and the hardware blocks of output "{name}" are'
    )
    help = f'distribution: {option} here, or control: {asked(output)} in output "{name}"'
    path: Path = ("outputs", output.name, "distribution")
    place = path if exists(case.tree, path) else path[:2]
    message += f" for {option.capitalize()}"
    yield case.problem("controllers-distribution", message, place, help, severity=WARNING, within=True)


def _of_drive(robot: Robot) -> Iterator[str]:
    drive = robot.drive
    if drive is not None:
        yield from (name for names in drive.joints.values() for name in names)


def _findings(case: Case, one: Filled, distribution: str) -> Iterator[Finding]:
    controller = one.controller
    name = f'controller "{controller.name}"'
    wrong = of_type(controller.name, controller.type, distribution)
    if wrong is not None:
        yield wrong
    said = {key: one.values[key] for key in controller.params}
    told = list(against_kind(name, one.kind, {**_lists(one.values), **said}) if one.kind else unwritable(name, said))
    yield from told
    fine = {key: value for key, value in one.values.items() if key not in {finding.key for finding in told}}
    named = list(against_robot(name, one.type, fine, one.known, case.robot, WARNING))
    joints = (joint.name for block in case.robot.control for joint in block.joints)
    if wrong is None and not any(found.unknown for found in named) and all(map(case.robot.joint.get, joints)):
        help = partial(_to_give, case.robot, one)
        yield from missing(name, one.kind, one.values, help)  # else what is missing may follow from the wrong name
    yield from frames_of(name, said, case.robot)
    yield from named


# What parameters of a kind look like; those that name joints take them from the robot.
_SAMPLES = {
    "command_interfaces": f"[{POSITION}]",
    "command_interface": POSITION,
    "state_interfaces": f"[{POSITION}, {VELOCITY}]",
    "reference_and_state_interfaces": f"[{POSITION}, {VELOCITY}]",
}
_JOINTS = "joints"
_SHOWN = 4


def _to_give(robot: Robot, one: Filled, needed: list[str]) -> str:
    if one.known.why_not:
        return f"{one.known.why_not}; give it in params"
    blocks = [block.name for block in robot.control if any(joint.command for joint in block.joints)]
    if blocks and not one.controller.hardware and _JOINTS in needed:
        named = blocks[0] if len(blocks) == 1 else f"NAME, one of {first_of(blocks, _SHOWN)}"
        return f"say whose joints it moves: hardware: {named}"
    driven = set(_of_drive(robot))
    free = [j.name for j in robot.joints if not (j.is_fixed or j.mimic or j.name in driven)]
    joints = f"[{', '.join(free[:_SHOWN])}{', ...' if len(free) > _SHOWN or not free else ''}]"
    samples = {_JOINTS: joints, "dof_names": joints, "joint": free[0] if free else "NAME", **_SAMPLES}
    return f"write params: {{{', '.join(f'{key}: {samples.get(key, key.upper())}' for key in needed)}}}"


def _odometry(case: Case, one: Filled) -> Iterator[Diagnostic]:
    controller, entry = one.controller, ("controllers", one.controller.name)
    given = {key: (*entry, "params", key) for key in ("enable_odom_tf", "odom_frame_id", "base_frame_id")}
    given = {key: path for key, path in given.items() if key in controller.params}
    mine = owned(case.robot, controller)
    parent, child = (one.values.get(key, default) for key, default in _ENDS)
    path = next(iter(given.values()), entry)
    if not one.values.get("enable_odom_tf"):
        if mine and "enable_odom_tf" in given:
            message = f'controller "{controller.name}" owns {_edge(mine[0])}, and enable_odom_tf is false'
            yield _of_edge(case, "parameters-no-owner", message, path, mine[0], "remove enable_odom_tf")
        elif not any(edge.child == child for edge in case.robot.edges):
            message = f'no edge says that controller "{controller.name}" publishes where {child} is: it does not'
            help = f"edges: [{{parent: {parent}, child: {child}, publisher: {controller.name}}}]"
            yield case.problem("controllers-odometry", message, entry, help, severity=NOTE, key=True)
        return
    said = f'controller "{controller.name}" publishes {parent} -> {child}'
    if not mine:
        into = next((edge for edge in case.robot.edges if edge.child == child), None)
        if into is not None:
            message = f"{said}, and by the description {_edge(into)} is of {into.publisher.name}"
            yield _of_edge(case, "parameters-two-owners", message, path, into, "remove enable_odom_tf")
        else:
            help = "remove enable_odom_tf, or add the edge"
            yield case.problem("parameters-other-edge", f"{said}, an edge that there is not", path, help)
    elif not any((edge.parent, edge.child) == (parent, child) for edge in mine):
        message = f"{said}, and by the description it is {_edge(mine[0])}"
        yield _of_edge(case, "parameters-other-edge", message, path, mine[0], "leave the frames to the description")


def _edge(edge: Edge) -> str:
    return f"{edge.parent} -> {edge.child}"


def _of_edge(case: Case, rule: str, message: str, path: Path, edge: Edge, help: str) -> Diagnostic:
    place = case.edge(case.robot.edges.index(edge), "child")
    return case.problem(rule, message, path, help, related=[case.related("the edge", place)])


def _lists(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if isinstance(value, list)}


def _placed(case: Case, found: Finding, entry: Path, within: Path) -> Diagnostic:
    path = (
        (*entry, found.key) if found.key in (at(case.tree, entry) or {}) else _path(case, (*entry, *within), found.key)
    )
    key = found.at_key or not found.key or path == (*entry, *within)
    path = entry if not found.key else path
    value = at(case.tree, path)
    path = (*path, value.index(found.unknown)) if isinstance(value, Seq) and found.unknown in value else path
    help = found.help
    if found.known:
        from rosorin_compile.language.suggestions import suggest_name

        help = suggest_name(case.tree, path, found.unknown, found.known)
    return case.problem(found.rule, found.message, path, help, severity=found.severity, key=key)


def _path(case: Case, path: Path, key: str) -> Path:
    here = at(case.tree, path)
    if not isinstance(here, Mapping):
        return path
    for name in sorted(here, key=len, reverse=True):
        if key == name:
            return (*path, name)
        if key.startswith(f"{name}."):
            return _path(case, (*path, name), key[len(name) + 1 :])
    return path

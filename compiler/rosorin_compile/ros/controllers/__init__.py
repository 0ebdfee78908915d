"""controllers.yaml: the parameters of ros2_control's controller_manager and of its controllers.

``filled`` makes the text of what a description says and of what the robot knows (``derived``). ``checking`` holds
parameters against the robot; here they are those of a description.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial

from rosorin_compile.formats.format import Unsupported, described_by
from rosorin_compile.model import Edge, Output, Robot
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, first_of, quoted
from rosorin_compile.source.tree import Path, Seq, at, exists

from ..parameters import parameter_file
from ..parameters.checking import Finding, against_kind, unwritable
from ..parameters.files import asked
from ..parameters.tables import MANAGER, kinds
from ..ports import facts, full_type
from .checking import against_robot, claims, frames_of, missing, of_type
from .derived import owned
from .filled import Filled, filled, is_whole, managed, view, write

_BLOCKS = "control"  # the option of a URDF that asks for hardware blocks
_ENDS = (("odom_frame_id", "odom"), ("base_frame_id", "base_link"))


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find what is wrong with the controllers of a description in the distribution that an output is for.

    What is wrong in every distribution is reported for the first output alone.
    """
    distribution, entry = asked(output), ("outputs", output.name)
    is_first = output.name == next(one for one in case.robot.outputs if one.backend == output.backend).name
    if not case.robot.controllers:
        message = f'output "{output.name}" is for controllers, and the description has none'
        help = "name them: controllers: {NAME: {type: diff_drive}}"
        yield case.problem("controllers-none", message, entry, help, severity=WARNING, key=True)
    for found in against_kind(f"the {MANAGER}", kinds(distribution)[MANAGER], managed(output, distribution)):
        yield _placed(case, found, entry, "manager")
    if is_first:
        yield from _joint_states(case)
    yield from _apart(case, output)
    if not case.robot.is_tree or not is_whole(case.robot):
        return  # which has rules of its own
    every = filled(case.robot, distribution)
    for one in every:
        findings = list(_findings(case, one, distribution))
        for found in findings:
            yield _placed(case, found, ("controllers", one.controller.name), "params")
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
    rule, types = "controllers-joint-states", [full_type(one.type) for one in case.robot.controllers]
    states = [(block, joint) for block in case.robot.control for joint in block.joints if joint.state]
    if not types or not states:
        return
    if not any(one.endswith("/JointStateBroadcaster") for one in types):
        block, joint = states[0]
        message = f'no controller publishes the states that hardware block "{block.name}" has, such as that of '
        help = "controllers: {joint_state_broadcaster: {type: joint_state_broadcaster}}"
        path: Path = ("controllers",)
        yield case.problem(rule, f'{message}"{joint.name}"', path, help, severity=WARNING, key=True)
        return
    for still in case.robot.unmeasured_joints:
        message = f'no node publishes the position of joint "{still.name}", which no hardware block has: '
        message += f'"{still.child}" has no transform, and MoveIt waits for a complete state'
        help = f"in control: joints: {{{still.name}: {{state: [position]}}}}; or let a node publish the joint: "
        yield case.problem(rule, message, case.joint(still), f"{help}publisher", severity=WARNING, key=True)


def _apart(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield that all hardware blocks are written for another distribution."""
    blocks = {one.name: str(option) for one in case.robot.outputs if (option := one.options.get(_BLOCKS))}
    if not case.robot.control or not blocks or described_by(asked(output)) in map(described_by, blocks.values()):
        return
    name, option = next(iter(blocks.items()))
    message = f'output "{output.name}" is for {asked(output).capitalize()}, and the hardware blocks of output "{name}" '
    message += f"are for {option.capitalize()}"
    help = f'distribution: {option} here, or control: {asked(output)} in output "{name}"'
    path: Path = ("outputs", output.name, "distribution")
    place = path if exists(case.tree, path) else path[:2]
    yield case.problem("controllers-distribution", message, place, help, within=True)


def _findings(case: Case, one: Filled, distribution: str) -> Iterator[Finding]:
    controller, name = one.controller, f'controller "{one.controller.name}"'
    wrong = of_type(controller.name, controller.type, distribution)
    if wrong is not None:
        yield wrong
    given = {key: one.values[key] for key in controller.params}
    lists = {key: value for key, value in one.values.items() if isinstance(value, list)}
    found = list(against_kind(name, one.kind, {**lists, **given}) if one.kind else unwritable(name, given))
    yield from found
    right = {key: value for key, value in one.values.items() if key not in {finding.key for finding in found}}
    named = list(against_robot(name, one.type, right, one.known, case.robot, WARNING))
    joints = (joint.name for block in case.robot.control for joint in block.joints)
    if wrong is None and not any(found.unknown for found in named) and all(map(case.robot.joint.get, joints)):
        help = partial(_help_about_missing, case.robot, one)
        yield from missing(name, one.kind, one.values, help)  # else what is missing may follow from the wrong name
    yield from frames_of(name, given, case.robot)
    yield from named


def _help_about_missing(robot: Robot, one: Filled, needed: list[str]) -> str:
    if one.known.why_not:
        return f"{one.known.why_not}; give it in params"
    blocks = [block.name for block in robot.control if any(joint.command for joint in block.joints)]
    if blocks and not one.controller.hardware and "joints" in needed:
        named = blocks[0] if len(blocks) == 1 else f"NAME, one of {first_of(blocks, 4)}"
        return f"say whose joints it moves: hardware: {named}"
    examples = facts("ros2_controllers")["examples"]
    return f"write params: {{{', '.join(f'{key}: {examples.get(key, key.upper())}' for key in needed)}}}"


def _odometry(case: Case, one: Filled) -> Iterator[Diagnostic]:
    """Yield where a controller does not publish the edge that the description says it does, or another one."""
    controller, entry, edges = one.controller, ("controllers", one.controller.name), case.robot.edges
    given = [key for key in ("enable_odom_tf", "odom_frame_id", "base_frame_id") if key in controller.params]
    mine = owned(case.robot, controller)
    parent, child = (one.values.get(key, default) for key, default in _ENDS)
    into = next((edge for edge in edges if edge.child == child), None)
    publishes = one.values.get("enable_odom_tf")
    name, edge = f'controller "{controller.name}"', None
    if not publishes and mine and "enable_odom_tf" in given:
        rule, edge = "parameters-no-owner", mine[0]
        message, help = f"{name} owns {_edge(edge)}, and enable_odom_tf is false", "remove enable_odom_tf"
    elif not publishes and not mine and into is None:
        message = f"no edge says that {name} publishes where {child} is: it does not"
        help = f"edges: [{{parent: {parent}, child: {child}, publisher: {controller.name}}}]"
        yield case.problem("controllers-odometry", message, entry, help, key=True)
        return
    elif not publishes or any((other.parent, other.child) == (parent, child) for other in mine):
        return
    elif mine:
        rule, edge, help = "parameters-other-edge", mine[0], "leave the frames to the description"
        message = f"{name} publishes {parent} -> {child}, and by the description it is {_edge(edge)}"
    elif into is not None:
        rule, edge, help = "parameters-two-owners", into, "remove enable_odom_tf"
        message = f"{name} publishes {parent} -> {child}, and by the description {_edge(into)} is of "
        message += into.publisher.name
    else:
        rule, help = "parameters-other-edge", "remove enable_odom_tf, or add the edge"
        message = f"{name} publishes {parent} -> {child}, an edge that the description does not have"
    related = [] if edge is None else [("the edge", case.edge(edges.index(edge), "child"))]
    yield case.problem(rule, message, (*entry, "params", given[0]) if given else entry, help, related=related)


def _edge(edge: Edge) -> str:
    return f"{edge.parent} -> {edge.child}"


def _placed(case: Case, found: Finding, entry: Path, within: str) -> Diagnostic:
    path = _path(case, (*entry, within), found.key)
    if found.key in (at(case.tree, entry) or {}):
        path = (*entry, found.key)
    key = found.at_key or not found.key or path == (*entry, within)
    path = path if found.key else entry
    value, help = at(case.tree, path), found.help
    path = (*path, value.index(found.unknown)) if isinstance(value, Seq) and found.unknown in value else path
    if found.known:
        help = case.suggest(path, found.unknown, found.known)
    return case.problem(found.rule, found.message, path, help, severity=found.severity, key=key)


def _path(case: Case, path: Path, key: str) -> Path:
    here = at(case.tree, path)
    for name in sorted(here, key=len, reverse=True) if isinstance(here, Mapping) else ():
        if key == name:
            return (*path, name)
        if key.startswith(f"{name}."):
            return _path(case, (*path, name), key[len(name) + 1 :])
    return path


_UNSUPPORTED = {"controllers.*.inactive": Unsupported("the launch file of a package starts it so", quiet=True)}

FORMAT = parameter_file(
    "controllers",
    word="controllers.yaml",
    about="the parameters of ros2_control's controllers",
    rank=61,
    covers=("robot", "controllers", "drive"),
    unsupported=_UNSUPPORTED,
    file="controllers.yaml",
    check=check,
    write=write,
    view=view,
)

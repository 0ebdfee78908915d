"""Validate the section ``moveit`` against the URDF that MoveIt loads, because MoveIt itself only logs mistakes."""

from collections.abc import Collection, Iterator

from rosorin_compile.model import Output
from rosorin_compile.ros.sections.moveit import EndEffector, Group
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Suggestion, count_of, first_of, quote
from rosorin_compile.source.tree import Path, value_at

from ..sections.moveit import state_path
from .planning import URDF, PlanningModel, planning_model, stale_text

_TOP = "moveit"


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Validate the section ``moveit``. If several outputs are SRDFs, problems are only reported for the first."""
    robot = case.robot
    first = next(one for one in robot.outputs if one.backend == output.backend)
    if output != first or not robot.links or not robot.is_tree:
        return
    planning = planning_model(robot)
    if planning is None and robot.moveit is not None and (name := robot.moveit.urdf):
        message = f'there is no URDF output "{name}", which the SRDF needs'
        urdfs = [one.name for one in robot.outputs if one.backend == URDF]
        fix = Suggestion(name, urdfs, "use an output that is a URDF")
        yield case.problem("moveit-urdf", message, (_TOP, "urdf"), fix)
        return
    if planning is None:
        message = f"{output.file} needs a URDF, but the robot has no output of this format"
        help = 'add "urdf: {file: NAME.urdf}" to "outputs"'
        yield case.problem("moveit-urdf", message, ("outputs", output.name), help, key=True)
        return
    for kind, name, path in _named(case):
        in_urdf: Collection[str] = planning.links if kind == "link" else planning.joints
        if name in _all(case, kind) and name not in in_urdf:
            what = f'{kind} "{name}" is not in {planning.urdf.file}, the URDF of the SRDF'
            help_ = f'use another {kind}, or a URDF that has it: "moveit: {{urdf: OUTPUT}}"'
            yield case.problem("moveit-not-in-urdf", what, path, help_)
    yield from _groups(case, planning)
    if all(name in robot.joint for group in planning.said.groups for name in _own_joints(planning, group)):
        yield from _states(case, planning)
        for one in planning.said.end_effectors:
            yield from _end_effector(case, planning, one)
    yield from _virtual_joint(case, planning)
    for index, name in enumerate(planning.said.passive_joints):
        if (joint := planning.joints.get(name)) is not None and (joint.is_fixed or joint.mimic is not None):
            why = "is fixed" if joint.mimic is None else f'follows "{joint.mimic.joint}": it is not commanded anyway'
            message, path = f'joint "{name}" is listed as passive, but {why}', (_TOP, "passive_joints", index)
            yield case.problem("moveit-passive-joint", message, path)
    yield from _matrix(case, planning, output)


def _named(case: Case) -> Iterator[tuple[str, str, Path]]:
    for kind in ("link", "joint"):
        yield from ((kind, one.name, one.path) for one in case.mentions(kind) if one.path[0] == _TOP)


def _all(case: Case, kind: str) -> Collection[str]:
    return case.robot.link if kind == "link" else case.robot.joint


def _own_joints(planning: PlanningModel, group: Group) -> list[str]:
    return [name for name in group.joints if planning.virtual is None or name != planning.virtual.name]


def _groups(case: Case, planning: PlanningModel) -> Iterator[Diagnostic]:
    for group in planning.said.groups:
        path: Path = (_TOP, "groups", group.name)
        circle, links = _circle(planning, group), (*(group.chain or ()), *group.links)
        base, tip = group.chain or ("", "")
        way = case.robot.chain(base) if base in case.robot.link else []
        parents = [joint.parent for joint in way]
        # If a name is unknown, which another rule reports, the joints of the group cannot be determined.
        is_sound = planning.links.issuperset(links) and planning.groups.keys() >= {*group.groups}
        is_sound = is_sound and planning.joints.keys() >= {*_own_joints(planning, group)}
        if circle:
            if group.name == next(name for name in planning.groups if name in circle):  # report each cycle once
                message = f"planning groups contain each other: {' -> '.join([*circle, group.name])}"
                message = message if circle[1:] else f'planning group "{group.name}" contains itself'
                help = f'remove "{(circle[1:] or circle)[0]}" from "groups"'
                yield case.problem("moveit-group", message, (*path, "groups"), help)
        elif group.chain is not None and base == tip:
            message = f'the chain of planning group "{group.name}" begins and ends at link "{base}"'
            yield case.problem("moveit-group", message, (*path, "chain"), 'use the link that it moves as "tip"')
        elif tip in parents and any(not joint.is_fixed for joint in way[parents.index(tip) :]):
            message = f'the chain of planning group "{group.name}" goes from "{base}" up to "{tip}", to which it is '
            message += "attached"
            help = f'swap base and tip: "chain: {{base: {tip}, tip: {base}}}"'
            yield case.problem("moveit-chain-swapped", message, (*path, "chain"), help, within=True)
        elif is_sound and not planning.joints_in(group):
            message = f'planning group "{group.name}" has no joint, so MoveIt ignores it'
            yield case.problem("moveit-group", message, path, 'add "chain", "joints", "links" or "groups"', key=True)


def _circle(planning: PlanningModel, group: Group) -> list[str]:
    """Return the names of groups that form a cycle with ``group``, or [] if there is no cycle."""
    ways = [[group.name]]
    for way in ways:  # breadth-first search: the list grows in the loop
        inner = planning.groups[way[-1]].groups
        if group.name in inner:
            return way
        visited = {name for each in ways for name in each}
        ways += [[*way, name] for name in dict.fromkeys(inner) if name in planning.groups and name not in visited]
    return []


def _states(case: Case, planning: PlanningModel) -> Iterator[Diagnostic]:
    """Report states that set no joint of their group, and poses that set most joints of a group but not all."""
    poses = {pose.name: pose for pose in case.robot.poses}
    used = {pose.name for group in planning.said.groups for pose in planning.states(group).values()}
    for group in planning.said.groups:
        active = planning.active(group)
        for state, name in (group.states or {}).items():
            if name in poses and active and not poses[name].positions.keys() & {*active}:
                message = f'pose "{name}" sets no joint of planning group "{group.name}"'
                help = f"add a joint of the group to the pose: {first_of(active, 5)}"
                yield case.problem("moveit-state", message, state_path(case, group, state), help)
        for pose in poses.values() if group.states is None else ():
            missing = [joint for joint in active if joint not in pose.positions]
            if pose.name not in used and missing and 2 * len(missing) < len(active):
                used.add(pose.name)
                message = f'pose "{pose.name}" is not a state of planning group "{group.name}": the pose does not set '
                help = f"add {'it' if len(missing) == 1 else 'them'} to the pose, or use the pose as it is: states: "
                message, help = message + quote(missing, 3), f"{help}[{pose.name}]"
                yield case.problem("moveit-state", message, ("poses", pose.name), help, severity=NOTE, key=True)


def _end_effector(case: Case, planning: PlanningModel, one: EndEffector) -> Iterator[Diagnostic]:
    rule, path = "moveit-end-effector", (_TOP, "end_effectors", one.name)
    if not {one.group, one.parent_group or one.group} <= set(planning.groups) or one.parent not in planning.links:
        return
    if one.parent in planning.links_in(planning.groups[one.group]):
        message = f'link "{one.parent}" carries end effector "{one.name}", but is also in its group "{one.group}"'
        help = "use the link that the group is attached to"
        yield case.problem(rule, message, (*path, "parent"), help, severity=WARNING)
    elif one.parent_group == one.group:
        message = f'the parent group of end effector "{one.name}" is its own group'
        yield case.problem(rule, message, (*path, "parent_group"), "use the group that moves the end effector")
    elif one.parent_group and one.parent not in planning.links_in(planning.groups[one.parent_group]):
        of_group = ((kind, name) for kind, name, at in _named(case) if at[1:3] == ("groups", one.parent_group))
        if all(name in _all(case, kind) for kind, name in of_group):  # another rule reports unknown names
            message = f'planning group "{one.parent_group}" does not have link "{one.parent}", which carries '
            help = "let the chain of that group end at this link"
            yield case.problem(rule, f'{message}end effector "{one.name}"', (*path, "parent_group"), help)


def _virtual_joint(case: Case, planning: PlanningModel) -> Iterator[Diagnostic]:
    virtual, path = planning.virtual, (_TOP, "virtual_joint")
    if virtual is not None and virtual.name in case.robot.joint:
        message = f'the virtual joint has the same name as a joint of the robot: "{virtual.name}"'
        help = 'write another name: "virtual_joint: {name: NAME}"'
        yield case.problem("moveit-virtual-joint", message, (*path, "name"), help)
    if virtual is not None and virtual.parent in planning.links:
        message = f'the virtual joint attaches the root "{planning.root}" to "{virtual.parent}", which is a link of '
        help = "use a frame of the world, such as odom"
        yield case.problem("moveit-virtual-joint", f"{message}the URDF", (*path, "parent"), help, severity=WARNING)


def _matrix(case: Case, planning: PlanningModel, output: Output) -> Iterator[Diagnostic]:
    if (matrix := planning.said.matrix) is None:
        if len(planning.solids) > 1:
            links, path = count_of(len(planning.solids), "link"), ("outputs", output.name)
            message = f"without a collision matrix, MoveIt checks all pairs of {links}, including adjacent ones"
            yield case.problem("collisions-missing", message, path, key=True)
    elif matrix.of != planning.digest:
        pairs, _ = planning.stale_pairs()
        what = stale_text(pairs) if pairs else "links were added or removed"
        message = f"shapes, joints, limits or numbers changed since the collision matrix was computed: {what}"
        yield case.problem("collisions-stale", message, (_TOP, "collision_matrix", "of"))
    else:  # a link is unknown only if the matrix was edited by hand; removing a link makes a matrix stale
        within: Path = (_TOP, "collision_matrix", "pairs")
        for index, pair in enumerate(value_at(case.tree, within) or ()):
            for side, name in enumerate(pair["links"]):
                if name not in case.robot.link:
                    help_ = Suggestion(name, case.robot.link, "rosorin-compile collisions computes the matrix again")
                    message = f'there is no link "{name}" (one of two links of the collision matrix)'
                    yield case.problem("unknown-link", message, (*within, index, "links", side), help_)

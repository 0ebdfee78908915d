"""The tree of links and joints: every name exists, one root, one parent each, no cycle."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import count

from rosorin_compile.language.lower.lowering import owner_of_frame
from rosorin_compile.language.symbols import MOUNT, Reference
from rosorin_compile.model import Joint, Robot
from rosorin_compile.source.diagnostics import Diagnostic, nearest
from rosorin_compile.source.rule_registry import JOINTS, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import listed, quoted

from .case import Case

# REP 105: frames of the world, which localisation places and no description owns.
WORLD_FRAMES = ("earth", "map", "odom")
MAX_NAMED = 20


def pieces(pairs: Iterable[tuple[str, str]]) -> list[set[str]]:
    """Return the sets of names that pairs connect, in the order in which the pairs name them."""
    piece_of: dict[str, set[str]] = {}
    for parent, child in pairs:
        first, second = piece_of.setdefault(parent, {parent}), piece_of.setdefault(child, {child})
        if first is not second:
            if len(first) < len(second):  # else a long chain from its end would take quadratic time
                first, second = second, first
            first |= second
            piece_of.update(dict.fromkeys(second, first))
    return list({id(piece): piece for piece in piece_of.values()}.values())


@rule("no-links", "The robot has no link at all.", "Add `links: {base_link: {}}`.", JOINTS)
@rule("unknown-link", "There is no link or frame of a name.", "Correct the name, or add the link.", JOINTS)
@rule("unknown-joint", "There is no joint of a name.", "Correct the name, or add the joint.", JOINTS)
def known_names(case: Case) -> Iterator[Diagnostic]:
    """Names of links and joints that nothing defines; the leaders of mimics have a rule of their own."""
    robot = case.robot
    if not robot.links:
        yield case.problem("no-links", f'the robot "{robot.name}" has no links', ("robot",))
    for kind, option, real in (("link", "rename", robot.link), ("joint", "joints", robot.joint)):
        known = {*real, *(WORLD_FRAMES if kind == "link" else ())}
        by_name: dict[str, list[Reference]] = {}
        for use in _mentions(case, kind, option):
            if use.name not in known:
                by_name.setdefault(use.name, []).append(use)
        for name, uses in by_name.items():
            otherwise, own = f'add "{name}" to {kind}s, or name an existing one', (MOUNT,) if kind == "link" else ()
            help = _namesake(robot, kind, name) or case.suggest(uses[0].path, name, real, otherwise, own)
            yield from case.unknown(f"unknown-{kind}", f'there is no {kind} "{name}"', uses, help)


def _mentions(case: Case, kind: str, option: str) -> Iterator[Reference]:
    """Yield the references to links or joints in the description, and in the options of its outputs."""
    named = [one for one in case.mentions(kind) if one.among == ""]
    yield from sorted(named, key=lambda one: one.path[0] == "moveit")  # planning comes after the robot
    for output in case.robot.outputs:
        for index, name in enumerate(output.options.get(option, ())):
            is_link = kind == "link"
            what = f'renamed in output "{output.name}"' if is_link else f'requested by output "{output.name}"'
            yield Reference(kind, name, ("outputs", output.name, option, name if is_link else index), is_link, what, "")


def _namesake(robot: Robot, kind: str, name: str) -> str:
    """Return the suggestion for the name of an entry that has a link or joint of its own."""
    if kind == "joint":
        joint = robot.joint_to.get(name)
        return f'"{name}" is a link; its joint is "{joint.name}"' if joint else ""
    frame = next((sensor.frame for sensor in robot.sensors if sensor.name == name), "")
    if frame:
        return f'"{name}" is a sensor; its frame is "{frame}"'
    return f'"{name}" is a joint; its child is "{robot.joint[name].child}"' if name in robot.joint else ""


@rule("two-parents", help="Correct one `child`, or remove a joint.", topic=JOINTS)
def one_parent(case: Case) -> Iterator[Diagnostic]:
    """A link is the child of two joints."""
    for child, joints in _children(case.robot).items() if not case.robot.is_tree else ():
        if len(joints) < 2 or child not in {*case.robot.link, *WORLD_FRAMES}:  # an unknown link is reported by itself
            continue
        *first, last = joints
        left, path, ends = _orphans(case), case.end(last, "child"), [case.end(joint, "child") for joint in joints]
        message = f'link "{child}" is the child of {len(joints)} joints, {quoted(one.name for one in joints)}'
        help = f"correct one child: no joint reaches {quoted(left)}" if left else ""
        if any(end[0] == "sensors" for end in ends):
            message = f'frame "{child}" is defined {"twice" if len(ends) == 2 else f"{len(ends)} times"}: by '
            message += listed(map(owner_of_frame, ends))
            is_pair = len(ends) == 2 and ends[0][0] != "sensors"
            help = _own_frame(case, path) if is_pair else "give each a frame of its own"
        related = [(f'attached here by joint "{joint.name}"', case.end(joint, "child")) for joint in first]
        yield case.problem("two-parents", message, path, help, related=related)


def _orphans(case: Case) -> list[str]:
    """Return the links that have no parent because one link has two: one that carries nothing, or two roots.

    Where more is wrong than one child, each is reported by itself.
    """
    robot = case.robot
    doubles = [joints for joints in _children(robot).values() if len(joints) > 1]
    roots = [name for name in robot.link if name not in robot.joint_to and name not in WORLD_FRAMES]
    if len(doubles) != 1 or len(doubles[0]) != 2 or len(roots) != 2:
        return []
    if any(case.joint(joint)[0] == "sensors" for joint in doubles[0]):
        return []
    return [name for name in roots if name not in robot.joints_from] or roots


def _children(robot: Robot) -> dict[str, list[Joint]]:
    """Return the joints that a link is the child of, by link name, in the order of the description."""
    above: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        above.setdefault(joint.child, []).append(joint)
    return above


@rule("joint-cycle", help="Let one of these joints begin at another link.", topic=JOINTS)
def no_cycle(case: Case) -> Iterator[Diagnostic]:
    """Joints lead back to where they began; if a link of the circle has two parents, that is the cause."""
    above = {child: joints[0] for child, joints in _children(case.robot).items() if len(joints) == 1}
    order = {name: index for index, name in enumerate(case.robot.joint)}
    done: set[str] = set()
    for start in above if not case.robot.is_tree else ():
        walked: list[Joint] = []
        here = start
        while here in above and here not in done:
            done.add(here)
            walked.append(above[here])
            here = above[here].parent
        begin = next((index for index, joint in enumerate(walked) if joint.child == here), None)
        if begin is None:
            continue
        circle = walked[begin:][::-1]
        last = max(circle, key=lambda joint: order[joint.name])
        chain = " -> ".join([circle[0].parent, *(joint.child for joint in circle)])
        message = f"joints form a circle: {chain}"
        message = f'joint "{last.name}" attaches link "{last.child}" to itself' if len(circle) == 1 else message
        others = [joint for joint in circle if joint is not last]
        path, help, frame = case.end(last, "parent"), "", case.end(last, "child")
        if frame[0] == "sensors":
            path, help = frame, _own_frame(case, frame)
            message = f'{owner_of_frame(frame)} makes the frame "{last.child}", and is on that link itself: {chain}'
        related = [(f'"{joint.name}" is part of it', case.end(joint, "child")) for joint in others]
        yield case.problem("joint-cycle", message, path, help, related=related)


def _own_frame(case: Case, path: Path) -> str:
    """Return the fix for a sensor that makes a frame, at a path, of an existing link."""
    sensor, key = str(path[1]), "optical" if "optical" in path else "link"
    taken = {*case.robot.link, *case.robot.joint}
    free = next(name for index in count(1) if (name := f"{sensor}_{key}{index if index > 1 else ''}") not in taken)
    if key == "optical":
        return f"an optical frame is made here: give it a name of its own, optical: {{frame: {free}}}"
    return f"a frame is made here: write frame: {free}, or leave parent out if the sensor is in that link itself"


@rule("several-roots", "More than one link is no joint's child.", "Attach all but one.", JOINTS)
@rule("unreached-link", "No joint names this link.", "Attach it with a joint, or remove it.", JOINTS)
def one_root(case: Case) -> Iterator[Diagnostic]:
    """More than one root, and links that no joint names. An unknown child is the cause of the root that it leaves."""
    robot = case.robot
    roots = [name for name in robot.link if name not in robot.joint_to and name not in WORLD_FRAMES]
    for joint in robot.joints if not robot.is_tree else ():
        if joint.child not in robot.link and joint.child not in WORLD_FRAMES:
            suggestion = nearest(joint.child, roots)
            if suggestion is None:
                return
            roots.remove(suggestion)
    left = _orphans(case) if not robot.is_tree else roots
    roots = [name for name in roots if name not in left]
    carrying = [name for name in roots if name in robot.joints_from]
    alone = [name for name in roots if name not in robot.joints_from]
    if not carrying:
        carrying, alone = alone, []
    if len(carrying) > 1:
        main = max(carrying, key=lambda name: (len(robot.below(name)), name.startswith("base")))
        others = [name for name in carrying if name != main]
        message = f"the robot has {len(carrying)} roots, {quoted([main, *others], MAX_NAMED)}: one link is the root"
        related = [case.related("also a root", case.link(name), key=True) for name in (main, *others[1:MAX_NAMED])]
        help = f'add a joint with "child: {others[0]}"'
        yield case.problem("several-roots", message, case.link(others[0]), help, related=related, key=True)
    frames = {sensor.frame for sensor in robot.sensors} - set(case.section("links"))
    for name in alone:
        help, related_frame = f'add a joint with "child: {name}", or remove the link', []
        suggestion = nearest(name, frames)
        if suggestion:
            related_frame = [("a frame without a link of its own", case.value(case.link(suggestion), "frame"))]
            help = f'did you mean "{suggestion}"? else {help}'
        message = f'no joint reaches link "{name}"'
        yield case.problem("unreached-link", message, case.link(name), help, related=related_frame, key=True)

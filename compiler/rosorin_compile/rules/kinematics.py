"""The tree of links and joints: every name is known, one root, one parent each, no cycle."""

from __future__ import annotations

from collections.abc import Iterator
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


@rule("no-links", "The robot has no link at all.", "Add `links: {base_link: {}}`.", JOINTS)
@rule("unknown-link", "A name is that of no link or frame.", "Correct the name, or add the link.", JOINTS)
def known_links(case: Case) -> Iterator[Diagnostic]:
    """Names of links that no entry of links or sensors defines; a robot without any link."""
    if not case.robot.links:
        help = "add links: {base_link: {}}"
        yield case.problem("no-links", f'the robot "{case.robot.name}" has no links', ("robot",), help)
    yield from _unknown(case, "link", {*case.robot.link, *WORLD_FRAMES})


@rule("unknown-joint", "A name is that of no joint.", "Correct the name, or add the joint.", JOINTS)
def known_joints(case: Case) -> Iterator[Diagnostic]:
    """Names of joints that no entry of joints or sensors defines; the leaders of mimics have a rule of their own."""
    yield from _unknown(case, "joint", set(case.robot.joint))


def _mentions(case: Case, kind: str) -> Iterator[Reference]:
    """Yield what names links or joints in the description, and in the options of its outputs."""
    named = [one for one in case.mentions(kind) if one.among == ""]
    yield from sorted(named, key=lambda one: one.path[0] == "moveit")  # what planners are told comes after the robot
    option = {"link": "rename", "joint": "joints"}[kind]
    for output in case.robot.outputs:
        for index, name in enumerate(output.options.get(option, ())):
            path: Path = ("outputs", output.name, option)
            if kind == "link":
                yield Reference(kind, name, (*path, name), True, f'renamed in output "{output.name}"', "")
            else:
                yield Reference(kind, name, (*path, index), False, f'asked for by output "{output.name}"', "")


def _unknown(case: Case, kind: str, known: set[str]) -> Iterator[Diagnostic]:
    """Yield one problem for each unknown name, however often it is used."""
    by_name: dict[str, list[Reference]] = {}
    for one in _mentions(case, kind):
        if one.name not in known:
            by_name.setdefault(one.name, []).append(one)
    real = case.robot.link if kind == "link" else case.robot.joint
    for name, (first, *others) in by_name.items():
        otherwise = f'add "{name}" to {kind}s, or name one that is there'
        own = (MOUNT,) if kind == "link" else ()
        help = _namesake(case, kind, name) or case.suggest(first.path, name, real, otherwise, own)
        also, same = case.also(first.path, ((one.path, one.what, one.key) for one in others), first.key)
        for path, what, related in ((first.path, first.what, also), *((*one, []) for one in same)):
            message = f'there is no {kind} "{name}", {what}'
            yield case.problem(f"unknown-{kind}", message, path, help, related=related, key=first.key)


def _namesake(case: Case, kind: str, name: str) -> str:
    """Return the way out for a name that is that of something else, which brings what is meant."""
    robot = case.robot
    if kind == "joint":
        joint = robot.joint_to.get(name)
        return f'"{name}" is a link; its joint is "{joint.name}"' if joint else ""
    frame = next((sensor.frame for sensor in robot.sensors if sensor.name == name), "")
    if frame:
        return f'"{name}" is a sensor; its frame is "{frame}"'
    return f'"{name}" is a joint; its child is "{robot.joint[name].child}"' if name in robot.joint else ""


@rule("two-parents", "A link is the child of two joints.", "Correct one `child`, or remove a joint.", JOINTS)
def one_parent(case: Case) -> Iterator[Diagnostic]:
    """Links that are the child of more than one joint."""
    if case.robot.is_tree:
        return
    for child, joints in children(case.robot).items():
        if len(joints) < 2 or child not in {*case.robot.link, *WORLD_FRAMES}:  # what is not there is told by itself
            continue
        names = quoted(joint.name for joint in joints)
        count = "two" if len(joints) == 2 else str(len(joints))
        message = f'link "{child}" is the child of {count} joints, {names}: a link has one parent'
        *first, last = joints
        left = _left_out(case)
        path, help = case.end(last, "child"), "correct one child, or remove a joint"
        if len(left) == 1:
            help = f'correct one child: no joint reaches link "{left[0]}"'
        elif left:
            help = f"swap parent and child of one, or remove it: {quoted(left)} have no parent"
        ends = [case.end(joint, "child") for joint in joints]
        if any(end[0] == "sensors" for end in ends):
            message = f'frame "{child}" is defined {"twice" if len(ends) == 2 else f"{count} times"}: by '
            message += listed(map(owner_of_frame, ends))
            alone = len(ends) == 2 and ends[0][0] != "sensors"
            help = _own_frame(case, path) if alone else "give each a frame of its own"
        related = [case.related(f'attached here by joint "{joint.name}"', case.end(joint, "child")) for joint in first]
        yield case.problem("two-parents", message, path, help, related=related)


def _left_out(case: Case) -> list[str]:
    """Return the links that have no parent because one link has two: one that carries nothing, or two roots.

    Where more is wrong than one child, each is told by itself.
    """
    robot = case.robot
    twice = [joints for joints in children(robot).values() if len(joints) > 1]
    roots = [name for name in robot.link if name not in robot.joint_to and name not in WORLD_FRAMES]
    if len(twice) != 1 or len(twice[0]) != 2 or len(roots) != 2:
        return []
    if any(case.joint(joint)[0] == "sensors" for joint in twice[0]):
        return []
    return [name for name in roots if name not in robot.joints_from] or roots


@rule("joint-cycle", "Joints lead back to where they began.", "Let one of them begin at another link.", JOINTS)
def no_cycle(case: Case) -> Iterator[Diagnostic]:
    """Joints that lead back to where they began. Where a link of the circle has two parents, that is the cause."""
    if case.robot.is_tree:
        return
    order = {name: index for index, name in enumerate(case.robot.joint)}
    for circle in cycles(case.robot):
        chain = " -> ".join([circle[0].parent, *(joint.child for joint in circle)])
        last = max(circle, key=lambda joint: order[joint.name])
        if len(circle) == 1:
            message = f'joint "{last.name}" attaches link "{last.child}" to itself'
        else:
            message = f"joints go round in a circle: {chain}"
        others = [joint for joint in circle if joint is not last]
        related = [case.related(f'"{joint.name}" is part of it', case.end(joint, "child")) for joint in others]
        path, help = case.end(last, "parent"), "let one of these joints begin at another link"
        frame = case.end(last, "child")
        if frame[0] == "sensors":
            path, help = frame, _own_frame(case, frame)
            message = f'{owner_of_frame(frame)} makes the frame "{last.child}", and sits on that link itself: {chain}'
        yield case.problem("joint-cycle", message, path, help, related=related)


def _own_frame(case: Case, path: Path) -> str:
    """Return the way out for a sensor that makes a frame, at a path, of a link that is there."""
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
    if robot.is_tree:
        return
    roots = [name for name in robot.link if name not in robot.joint_to and name not in WORLD_FRAMES]
    for joint in robot.joints:
        if joint.child in robot.link or joint.child in WORLD_FRAMES:
            continue
        meant = nearest(joint.child, roots)
        if meant is None:
            return
        roots.remove(meant)
    left = _left_out(case)
    roots = [name for name in roots if name not in left]
    parents = {joint.parent for joint in robot.joints}
    carrying = [name for name in roots if name in parents]
    alone = [name for name in roots if name not in parents]
    if not carrying:
        carrying, alone = (alone, []) if len(alone) > 1 else ([], [])
    if len(carrying) > 1:
        yield _several_roots(case, carrying)
    frames = {sensor.frame for sensor in robot.sensors} - set(case.tree.get("links") or ())
    for name in alone:
        help = f'add a joint with "child: {name}", or remove the link'
        meant, related = nearest(name, frames), []
        if meant:
            help = f'did you mean "{meant}"? else {help}'
            path = case.link(meant)
            path = (*path, "frame") if path[-1] != "frame" else path
            related = [case.related("a frame without a link of its own", path)]
        message = f'no joint reaches link "{name}"'
        yield case.problem("unreached-link", message, case.link(name), help, related=related, key=True)


MAX_NAMED = 20


def _several_roots(case: Case, roots: list[str]) -> Diagnostic:
    main = max(roots, key=lambda name: (len(case.robot.below(name)), name.startswith("base")))
    others = [name for name in roots if name != main]
    count = {2: "two", 3: "three"}.get(len(roots), str(len(roots)))
    named = [main, *others[: MAX_NAMED - 1]]
    more = "" if len(named) == len(roots) else " among them"
    message = f"the robot has {count} roots,{more} {quoted(named)}: one link is the root, joints reach the others"
    related = [case.related("a root too", case.link(name), key=True) for name in named if name != others[0]]
    help = f'add a joint with "child: {others[0]}"'
    return case.problem("several-roots", message, case.link(others[0]), help, related=related, key=True)


def children(robot: Robot) -> dict[str, list[Joint]]:
    """Return the joints that a link is the child of, by link name, in the order of the description."""
    above: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        above.setdefault(joint.child, []).append(joint)
    return above


def cycles(robot: Robot) -> list[list[Joint]]:
    """Return each circle of joints, parents before children; links with several parents are left out."""
    above = {child: joints[0] for child, joints in children(robot).items() if len(joints) == 1}
    done: set[str] = set()
    circles = []
    for start in above:
        walked: list[Joint] = []
        here = start
        while here in above and here not in done:
            done.add(here)
            walked.append(above[here])
            here = above[here].parent
        ends = [index for index, joint in enumerate(walked) if joint.child == here]
        if ends:
            circles.append(walked[ends[0] :][::-1])
    return circles

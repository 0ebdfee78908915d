"""The tree that the running robot publishes: joints and edges together hang in one piece."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Edge
from rosorin_compile.model.joint import SEVERAL_COORDINATES, UNPUBLISHED
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, nearest, swaps
from rosorin_compile.source.rule_registry import FRAMES, Check, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import listed, quoted

from . import conditions
from .case import Case
from .kinematics import WORLD_FRAMES


class Step(NamedTuple):
    """A transform that somebody publishes, and the place of its parent in the description."""

    parent: str
    child: str
    path: Path
    edge: Edge | None


def steps(case: Case) -> list[Step]:
    """Return all transforms that are published in some combination of modes."""
    return [*_of_joints(case), *_of_edges(case)]


def _of_joints(case: Case) -> list[Step]:
    joints = [joint for joint in case.robot.joints if joint.publisher.kind != UNPUBLISHED]
    return [Step(joint.parent, joint.child, case.end(joint, "parent"), None) for joint in joints]


def _of_edges(case: Case) -> list[Step]:
    edges = [(index, edge) for index, edge in enumerate(case.robot.edges)]
    made = [(i, edge) for i, edge in edges if not (edge.joint and edge.publisher.kind == UNPUBLISHED)]
    return [Step(edge.parent, edge.child, case.edge(index, "parent"), edge) for index, edge in made]


def legal_steps(case: Case) -> list[Step]:
    """Return the transforms that are published in some combination of modes and whose conditions mean something."""
    return [*_of_joints(case), *legal_edges(case)]


def legal_edges(case: Case) -> list[Step]:
    """Return those of ``legal_steps`` that are no joints: they alone depend on modes."""
    return [step for step in _of_edges(case) if step.edge is None or conditions.is_legal(case, step.edge)]


def silences(case: Case) -> list[Step]:
    """Return the transforms that nobody is to publish in some combination of modes, as their joints say."""
    silent = [(index, edge) for index, edge in enumerate(case.robot.edges) if edge.publisher.kind == UNPUBLISHED]
    legal = [(index, edge) for index, edge in silent if edge.joint and conditions.is_legal(case, edge)]
    return [Step(edge.parent, edge.child, case.edge(index, "parent"), edge) for index, edge in legal]


@Check
def known_frames(case: Case) -> Iterator[Diagnostic]:
    """Edges that hang neither on a link nor over one: one of their names is not what was meant."""
    robot = case.robot
    misspelt = list(_misspelt(case))
    yield from misspelt
    pairs = [(joint.parent, joint.child) for joint in robot.joints] + [(e.parent, e.child) for e in robot.edges]
    for piece in pieces(pairs) if robot.edges and not misspelt else ():
        inside = [(index, edge) for index, edge in enumerate(robot.edges) if edge.parent in piece]
        if not inside or not piece.isdisjoint(robot.link):
            continue
        known = {*robot.link, *(name for pair in pairs for name in pair)} - piece
        ends: list[tuple[str, Path]] = []
        for index, edge in inside:
            ends += [(edge.parent, case.edge(index, "parent")), (edge.child, case.edge(index, "child"))]
        near = [end for end in ends if end[0] not in WORLD_FRAMES and nearest(end[0], known)]
        name, path = (near or ends)[0]
        edges = listed(dict.fromkeys(f"{edge.parent} -> {edge.child}" for _, edge in inside))
        message = f'there is no frame "{name}" to hang {edges} on'
        yield case.problem("unknown-link", message, path, case.suggest(path, name, known, "name a link of the robot"))


def _misspelt(case: Case) -> Iterator[Diagnostic]:
    """Yield the ends of edges that are the name of a frame of the world with two letters swapped.

    A frame that hangs on the robot, or on what leads to it, may have any name.
    """
    led_to = {edge.child for edge in case.robot.edges}
    named = {name for edge in case.robot.edges for name in (edge.parent, edge.child)}
    for index, edge in enumerate(case.robot.edges):
        for key, name in (("parent", edge.parent), ("child", edge.child)):
            meant = next((one for one in swaps(name) if one in WORLD_FRAMES), None)
            if meant is None or name in case.robot.link or (key == "parent" and name in led_to):
                continue
            if key == "parent" or (edge.parent in WORLD_FRAMES and meant in named):
                help = f'did you mean "{meant}"?'
                yield case.problem("unknown-link", f'there is no frame "{name}"', case.edge(index, key), help)


@rule(
    "edge-cycle",
    "Joints and edges lead back to where they began.",
    "Correct the parent or the child of an edge.",
    FRAMES,
)
def no_cycle(case: Case) -> Iterator[Diagnostic]:
    """Edges that lead, with the joints between, back to where they began, in some combination of modes."""
    if not is_tree(case) or not case.robot.edges:
        return
    published = legal_steps(case)
    if not _circle(published):
        return
    circle = _circle_at_once(case, published)
    closing = next((step for step in reversed(circle) if step.edge), None)
    if closing is not None:
        chain = " -> ".join([circle[0].parent, *(step.child for step in circle)])
        related = [case.related(f"{s.parent} -> {s.child}", s.path) for s in circle if s.edge and s is not closing]
        help = "frames are a tree: correct the parent or the child of an edge"
        message = f"transforms go round in a circle: {chain}"
        yield case.problem("edge-cycle", message, closing.path, help, related=related)


def _circle_at_once(case: Case, published: list[Step]) -> list[Step]:
    """Return the first circle whose transforms are published at one time; empty if they never are."""
    core = _core(published)
    modes = conditions.modes_in(case.robot, [step.edge.when for step in core if step.edge])
    if len(modes) > conditions.MAX_MODES:
        return _circle(core)
    for combination in conditions.combinations(modes):
        circle = _circle(active_in(core, combination))
        if circle:
            return circle
    return []


def _core(published: list[Step]) -> list[Step]:
    """Return the transforms that may be part of a circle: something leads to each of them, and on from it."""
    while True:
        parents, children = {step.parent for step in published}, {step.child for step in published}
        left = [step for step in published if step.parent in children and step.child in parents]
        if len(left) == len(published):
            return left
        published = left


def active_in(published: Iterable[Step], combination: conditions.Combination) -> list[Step]:
    """Return the transforms that are published in a combination of modes."""
    return [step for step in published if step.edge is None or conditions.holds(step.edge.when, combination)]


def _circle(published: list[Step]) -> list[Step]:
    """Return the first circle in the transforms, parents before children; empty if there is none."""
    leaving: dict[str, list[str]] = {}
    count: dict[str, int] = {}
    for step in published:
        leaving.setdefault(step.parent, []).append(step.child)
        count[step.child] = count.get(step.child, 0) + 1
    ready = [name for name in leaving if name not in count]
    while ready:
        for child in leaving.get(ready.pop(), ()):
            count[child] -= 1
            if count[child] == 0:
                ready.append(child)
    # What no top leads to is a circle or hangs on one: upwards, every way ends in a circle.
    above: dict[str, Step] = {}
    for step in published:
        if count.get(step.parent) and count[step.child]:
            above.setdefault(step.child, step)
    walked: dict[str, Step] = {}
    here = next(iter(above), "")
    while here in above and here not in walked:
        walked[here] = above[here]
        here = above[here].parent
    return list(walked.values())[list(walked).index(here) :][::-1] if walked else []


@rule(
    "split-urdf",
    "The URDF would have two roots, because another node publishes a joint between them.",
    "Let one publisher have both joints.",
    FRAMES,
)
def one_urdf(case: Case) -> Iterator[Diagnostic]:
    """Joints in the URDF that hang on a link which is not in it: readers find two roots."""
    if is_tree(case) and case.feeding(ROBOT_STATE_PUBLISHER):
        main, *others = _urdf_roots(case) or [""]
        for root in others:
            ours = case.robot.in_urdf()
            first = next(joint for joint in case.robot.joints_from[root] if joint in ours)
            above = case.robot.joint_to.get(root, first)
            has = "it has" if first.type in SEVERAL_COORDINATES else "robot_state_publisher publishes"
            message = (
                f'the URDF would have two roots, "{main}" and "{root}": {has} joint'
                f' "{first.name}" on "{root}", but not joint "{above.name}", which carries it'
            )
            related = [case.related(f'joint "{first.name}"', case.joint(first), key=True)]
            help = "let one publisher have both joints"
            yield case.problem("split-urdf", message, case.publisher(above), help, related=related, key=above is first)


def _urdf_roots(case: Case) -> list[str]:
    """Return the roots of the joints in the URDF, that of the most links first."""
    joints = case.robot.in_urdf()
    reached = {joint.child for joint in joints}
    roots = list(dict.fromkeys(joint.parent for joint in joints if joint.parent not in reached))
    return sorted(roots, key=lambda root: -len(case.robot.below(root))) if len(roots) > 1 else roots


@rule(
    "split-tf",
    "A warning: frames are published, but a joint above them is on no topic, always or in some mode.",
    "Publish it, or nothing that hangs on it.",
    FRAMES,
)
def one_tree(case: Case) -> Iterator[Diagnostic]:
    """Frames that are published, but cut off from the rest by a joint that is on no topic or a parent nobody knows."""
    if not is_tree(case) or not case.robot.published_by(UNPUBLISHED):
        return
    published = steps(case)
    links = set(case.robot.link)
    parts = [piece for piece in pieces((step.parent, step.child) for step in published) if piece & links]
    main = max(parts, key=lambda piece: len(piece & links), default=set())
    reached = {step.child for step in published}
    urdf_roots = _urdf_roots(case)
    for piece in parts:
        if piece == main:
            continue
        tops = [step for step in published if step.parent in piece and step.parent not in reached]
        if not tops:  # a circle, which has a message of its own
            continue
        first = tops[0]
        names = [name for name in case.robot.link if name in piece]
        if first.parent not in links:
            message = f'there is no link "{first.parent}": {quoted(names)} would be cut off from the rest of the robot'
            known = {*links, *reached}
            help = case.suggest(first.path, first.parent, known, "name a frame")
            yield case.problem("unknown-link", message, first.path, help)
        elif first.parent not in urdf_roots[1:] and first.parent in case.robot.joint_to:
            above = case.robot.joint_to[first.parent]
            message = (
                f"{quoted(names)} would be cut off from the rest of the running robot:"
                f' nobody publishes joint "{above.name}", which carries "{first.parent}"'
            )
            help = "publish it, or nothing that hangs on it"
            yield case.problem("split-tf", message, case.publisher(above), help, severity=WARNING)


@Check
def one_tree_in_modes(case: Case) -> Iterator[Diagnostic]:
    """Links that are cut off in some combination of modes alone, because a frame changes its parent there."""
    edges, silent = legal_edges(case), silences(case)
    modes = conditions.modes_in(case.robot, [step.edge.when for step in (*edges, *silent) if step.edge])
    if not is_tree(case) or not modes:
        return
    published = legal_steps(case)
    if len(modes) > conditions.MAX_MODES:
        yield from _too_many_for_a_tree(case, published, len(modes))
        return
    links = set(case.robot.link)
    claimed = {step.child for step in published}
    for combination in conditions.combinations(modes):
        active = active_in(published, combination)
        reached = {step.child for step in active}
        # A frame that somebody publishes in another mode is a gap, which is said, unless nobody is to do it here.
        gaps = claimed - {step.child for step in active_in(silent, combination)}
        parts = _with_links(active, links)
        for whole in _with_links(published, links):
            inside = sorted((piece for piece in parts if piece <= whole), key=lambda piece: -len(piece & links))
            for piece in inside[1:]:
                tops = piece - reached
                if tops and not tops & gaps:  # without a top it is a circle
                    yield _cut_off(case, published, piece, tops, combination)
                    return


def _too_many_for_a_tree(case: Case, published: list[Step], count: int) -> Iterator[Diagnostic]:
    """Yield a warning that nobody can say whether the tree stays in one piece, if no single frame is the reason."""
    whens: dict[str, list[str]] = {}
    for step in published:
        whens.setdefault(step.child, []).append(step.edge.when if step.edge else "")
    if all(len(conditions.modes_in(case.robot, some)) <= conditions.MAX_MODES for some in whens.values()):
        last = next(step for step in reversed(published) if step.edge and step.edge.when)
        message = f"the transforms depend on {count} modes together: too many to check that no frame is cut off in one"
        help = f"use at most {conditions.MAX_MODES} modes"
        yield case.problem("too-many-modes", message, last.path, help, severity=WARNING)


def _with_links(published: Iterable[Step], links: set[str]) -> list[set[str]]:
    return [piece for piece in pieces((step.parent, step.child) for step in published) if piece & links]


def _cut_off(
    case: Case, published: list[Step], piece: set[str], tops: set[str], combination: conditions.Combination
) -> Diagnostic:
    """Return what is said of links that no transform joins to the others in a combination of modes."""
    names = [name for name in case.robot.link if name in piece]
    gone = [s for s in published if s.edge and (s.parent in piece) != (s.child in piece)]
    lost = next(step for step in gone if not conditions.holds(step.edge.when if step.edge else "", combination))
    message = (
        f"{quoted(names)} would be cut off from the rest of the running robot{conditions.in_words(combination)}:"
        f" {lost.parent} -> {lost.child} is not published then"
    )
    stamps = [(sensor.name, frame) for sensor in case.robot.sensors for frame in sensor.stamps if frame in piece]
    related = [
        case.related(f'sensor "{name}" stamps its messages with "{frame}"', ("sensors", name), key=True)
        for name, frame in stamps
    ]
    help = f'say who publishes "{sorted(tops)[0]}", or keep that transform in every mode'
    return case.problem("split-tf", message, lost.path, help, related=related, severity=WARNING)


def is_tree(case: Case) -> bool:
    """Say whether the joints and links are one tree; if not, that is the cause of what else is wrong."""
    return case.robot.is_tree


def pieces(pairs: Iterable[tuple[str, str]]) -> list[set[str]]:
    """Return the sets of names that pairs connect, in the order in which the pairs name them."""
    piece_of: dict[str, set[str]] = {}
    for one, other in pairs:
        first, second = piece_of.setdefault(one, {one}), piece_of.setdefault(other, {other})
        if first is not second:
            if len(first) < len(second):  # else a long chain that is told from its end would take the square of time
                first, second = second, first
            first |= second
            for name in second:
                piece_of[name] = first
    return list({id(piece): piece for piece in piece_of.values()}.values())

"""Rules about publishers: in every mode, one node publishes each transform, and all transforms form one tree."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from itertools import product
from typing import NamedTuple

from rosorin_compile.language.arguments import is_listed
from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Publisher, Robot
from rosorin_compile.model.joint import UNPUBLISHED
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Suggestion, UnknownName, nearest
from rosorin_compile.source.rule_registry import FRAMES, JOINTS, Check, rule
from rosorin_compile.source.tree import Path, Seq, Text, exists, value_at
from rosorin_compile.source.wording import count_of, first_of, phrase, quote, suggest, swaps

from .case import Case, first_fed
from .joints import WORLD_FRAMES, circles, pieces

MAX_MODES = 10
_NAME = re.compile(r"[^\W\d]\w*")
Combination = Mapping[str, bool]


@rule("unknown-mode", "`when` names a mode that is not in `modes`.", "Correct it, or add the mode.", FRAMES)
@rule("bad-condition", "`when` is invalid or never true.", "Combine modes, as in `slam and not replay`.", FRAMES)
@rule("too-many-modes", "Conditions depend on too many modes.", "Use at most 10 modes for one frame.", FRAMES)
def legal(case: Case) -> Iterator[Diagnostic]:
    """Report entries of ``edges`` with an invalid condition ``when`` or without a publisher."""
    names = [publisher.name for publisher in case.robot.publishers]
    choice = f"NAME, where NAME is one of {', '.join(names)}" if len(names) > 1 else "".join(names)
    for index, edge in enumerate(case.robot.edges):
        if problem := _condition(case, index, edge):
            yield problem
        if edge.publisher.kind == UNPUBLISHED and not edge.joint:
            message = f'no node publishes the transform "{edge.parent}" -> "{edge.child}"'
            help = f'add "publisher: {choice}"' if names else 'add a node to "publishers" and "publisher: NAME" here'
            yield case.problem("unpublished-edge", message, ("edges", index, "child"), help)


def _condition(case: Case, index: int, edge: Edge) -> Diagnostic | None:
    names, path, when = modes_in(case.robot, [edge.when]), case.edge(index, "when"), edge.when
    subject = f'the condition "{when}" of {edge.parent} -> {edge.child}'
    if len(names) > MAX_MODES:
        return case.problem("too-many-modes", f"{subject} depends on {len(names)} modes, too many to check", path)
    try:
        results = [not when or evaluate(when, combination.__getitem__) for combination in combinations(names)]
    except ExpressionError as problem:
        unknown = "" if problem.unknown.endswith("()") else problem.unknown
        found = case.problem("bad-condition", f"{subject} is not valid: {problem.message}", path)
        if unknown:
            help = Suggestion(unknown, case.robot.modes, f'add "{unknown}" to "modes"')
            found = case.problem("unknown-mode", f'there is no mode "{unknown}"', path, help)
        if found.span is None or found.span.length < len(when):
            return found
        # The column counts from the first character of the expression, so add leading spaces and the quote.
        start = len(when) - len(when.lstrip()) + problem.column + isinstance(value_at(case.tree, path), Text)
        return replace(found, span=found.span._replace(column=found.span.column + start, length=len(unknown) or 1))
    is_boolean, fix = {*map(type, results)} == {bool}, 'correct the condition, or remove this entry of "edges"'
    if any(results) and is_boolean:
        return None
    why = "is never true" if is_boolean else "is not a combination of modes"
    return case.problem("bad-condition", f"{subject} {why}", path, fix)


def holds(when: str, combination: Combination) -> bool:
    """Return True if a valid condition on modes is true in a combination of modes."""
    return not when or bool(evaluate(when, combination.__getitem__))


def modes_in(robot: Robot, whens: Iterable[str]) -> list[str]:
    """Return the modes that occur in these conditions, in the order of the description."""
    named = {name for when in whens for name in _NAME.findall(when)}
    return [mode for mode in robot.modes if mode in named]


def combinations(modes: list[str]) -> Iterator[Combination]:
    """Yield every combination of these modes, as a mapping from each mode to True (on) or False (off)."""
    for states in product((False, True), repeat=len(modes)):
        yield dict(zip(modes, states, strict=True))


def in_words(combination: Combination) -> str:
    """Format a combination as the end of a sentence, such as ' when "slam" is off', or "" without modes."""
    states = [f'"{mode}" is {"on" if on else "off"}' for mode, on in combination.items()]
    return f" when {' and '.join(states)}" if states else ""


def check_modes(robot: Robot, modes: Mapping[str, bool]) -> Mapping[str, bool]:
    """Return ``modes`` unchanged. Raises UnknownName if the robot does not have one of them."""
    for name in modes:
        if name not in robot.modes:
            raise UnknownName("mode", name, robot.modes, robot.name, "it has none")
    return modes


class Step(NamedTuple):
    """A transform parent -> child with its publisher, from a joint or from ``Robot.edges``.

    ``joint`` is "" for an entry of the section ``edges``. ``edge`` is the index in ``Robot.edges``, or None. ``when``
    is the condition on modes ("" for always), ``path`` the path of the parent's name in the description.
    """

    parent: str
    child: str
    publisher: Publisher
    joint: str
    when: str
    edge: int | None
    path: Path

    @property
    def is_silent(self) -> bool:
        """Whether this is the transform of a joint that no node publishes while the condition ``when`` holds."""
        return self.publisher.kind == UNPUBLISHED and self.joint != ""

    @property
    def owner(self) -> str:
        """A phrase for messages that names the publisher, such as 'robot_state_publisher (joint "elbow")'."""
        static = f'static_transform_publisher "{self.publisher.name}"'
        name = static if self.publisher.kind == STATIC_TRANSFORM_PUBLISHER else self.publisher.name or '"none"'
        return f'{name} (joint "{self.joint}")' if self.joint else name


def all_steps(case: Case, legal: bool = True) -> list[Step]:
    """Return the transforms of joints and of ``Robot.edges``; with ``legal``, omit those with invalid conditions."""
    joints = case.robot.joints
    steps = [Step(one.parent, one.child, one.publisher, one.name, "", None, case.end(one, "parent")) for one in joints]
    for index, one in enumerate(case.robot.edges):
        if not legal or _condition(case, index, one) is None:
            place = case.edge(index, "parent")
            steps.append(Step(one.parent, one.child, one.publisher, one.joint, one.when, index, place))
    return steps


def steps_in_modes(case: Case) -> tuple[list[Step], list[Step]]:
    """Return (published transforms, transforms of joints that no node publishes in some modes)."""
    steps = all_steps(case)
    silent = [step for step in steps if step.is_silent and step.edge is not None]
    return [step for step in steps if not step.is_silent], silent


def active_in(published: Iterable[Step], combination: Combination) -> list[Step]:
    """Return the transforms whose condition is true in a combination of modes."""
    return [step for step in published if holds(step.when, combination)]


def _claims(case: Case) -> dict[str, list[Step]]:
    """Map each child frame in ``Robot.edges`` to the transforms with this child, transforms of joints first."""
    led_to = {edge.child for edge in case.robot.edges}
    steps = [step for step in all_steps(case) if step.child in led_to] if led_to else []
    by_child: dict[str, list[Step]] = {}
    for step in sorted(steps, key=lambda step: (step.edge is not None, not step.joint)):
        claims = by_child.setdefault(step.child, [])
        is_published = step.publisher.kind != UNPUBLISHED
        if (is_published and not claims) if step.edge is None else (is_published or step.joint):
            claims.append(step)
    return by_child


def _place(case: Case, step: Step) -> Path:
    if step.edge is not None:
        return case.edge(step.edge, "child")
    joint = case.robot.joint[step.joint]
    return _turn_of_urdf(case, joint) or case.end(joint, "child")


def _turn_of_urdf(case: Case, joint: Joint) -> Path:
    """Return the path of robot_state_publisher in a joint's list of publishers, or () if it is not listed."""
    path = case.publisher(joint)
    turns = value_at(case.tree, path) if path[-1] == "publisher" else None
    owners = [turn["by"] for turn in turns] if isinstance(turns, Seq) else []
    return (*path, owners.index(ROBOT_STATE_PUBLISHER), "by") if ROBOT_STATE_PUBLISHER in owners else ()


@rule("two-publishers", "A frame has two publishers.", "Keep one publisher of the frame in every mode.", FRAMES)
@rule("unpublished-edge", "No node publishes an edge; a warning in some modes.", "Add a publisher.", FRAMES)
def one_publisher(case: Case) -> Iterator[Diagnostic]:
    """Report frames with two publishers, or without a publisher, in some combination of modes."""
    legal = {step.edge for step in all_steps(case) if step.joint or step.publisher.kind != UNPUBLISHED}
    bare = {edge.child for index, edge in enumerate(case.robot.edges) if index not in legal}
    for child, claims in _claims(case).items():
        modes = modes_in(case.robot, [claim.when for claim in claims])
        if len(modes) > MAX_MODES:
            message = f'the publishers of "{child}" depend on {len(modes)} modes together, which is too many to check'
            yield case.problem("too-many-modes", message, _place(case, claims[-1]), severity=WARNING)
            continue
        gap: Combination | None = None
        for combination in combinations(modes):
            active = active_in(claims, combination)
            owners = [claim for claim in active if not claim.is_silent]
            # If a joint declares a mode without a publisher (``none``), no edge may publish its transform in this mode.
            silent = [one for one in active if one.is_silent and any(one.joint == owner.joint for owner in owners)]
            if len(owners) > 1 or silent:
                *others, last = active = owners if len(owners) > 1 else [*silent, *owners]
                names, parents = ({getattr(claim, end): None for claim in active} for end in ("owner", "parent"))
                both = "publish" if len(owners) > 1 else "are both set to publish"
                what, often = ("publishes", " twice") if len(names) == 1 else (both, "")
                below = f" (from {quote(parents)})" if len(parents) > 1 else ""
                message = f'{phrase(names)} {what} the transform to "{child}"{often}{below}{in_words(combination)}'
                related = [(f"also set as publisher here: {claim.owner}", _place(case, claim)) for claim in others]
                help = 'remove one publisher, or give each a "when" so that only one is active in every mode'
                if any(claim.publisher.kind == ROBOT_STATE_PUBLISHER for claim in active):
                    help = "robot_state_publisher publishes in every mode; choose the publisher with an argument"
                yield case.problem("two-publishers", message, _place(case, last), help, related=related)
                break
            gap = combination if not active and gap is None else gap
        else:
            if gap is not None and child not in bare:
                message = f'no node publishes the transform "{claims[0].parent}" -> "{child}"{in_words(gap)}'
                path = case.edge(claims[0].edge or 0, "when")
                yield case.problem("unpublished-edge", message, path, severity=WARNING)


@Check
def urdf_always(case: Case) -> Iterator[Diagnostic]:
    """Report conditions on robot_state_publisher, which publishes its URDF in every mode (rule bad-condition)."""
    claims = _claims(case) if case.robot.edges else {}
    for joint in case.robot.published_by(ROBOT_STATE_PUBLISHER):
        place = _turn_of_urdf(case, joint)
        when = value_at(case.tree, (*place[:-1], "when")) if place else None
        # Another rule reports frames with two publishers.
        if place and when and len(claims.get(joint.child, ())) < 2:
            message = f'robot_state_publisher publishes joint "{joint.name}" in every mode, not only when "{when}"'
            help = "remove the condition, or make the publisher an argument: 'publisher: \"${publisher}\"'"
            yield case.problem("bad-condition", message, (*place[:-1], "when"), help)


def _static_publishers(case: Case) -> list[tuple[Joint, Publisher, Path]]:
    joints = case.robot.published_by(STATIC_TRANSFORM_PUBLISHER)
    found = [(joint, joint.publisher, case.publisher(joint)) for joint in joints]
    for index, edge in enumerate(case.robot.edges):
        if edge.joint and edge.publisher.kind == STATIC_TRANSFORM_PUBLISHER:
            found.append((case.robot.joint[edge.joint], edge.publisher, case.edge(index, "publisher")))
    return found


@Check
def unpublished_joints(case: Case) -> Iterator[Diagnostic]:
    """Report joints whose publisher is not started by an output, or has no output to read (rule unpublished-edge).

    Nothing is reported if an output has an unknown format, because it may be the missing output.
    """
    robot, outputs = case.robot, case.section("outputs").values()
    if any(one.backend not in case.formats for one in robot.outputs) or not any(map(is_listed, outputs)):
        return
    launched = bool(case.outputs_read_by(STATIC_TRANSFORM_PUBLISHER))
    has_urdf = first_fed(robot, ROBOT_STATE_PUBLISHER, case.formats) is not None
    kinds = {STATIC_TRANSFORM_PUBLISHER: ([joint for joint, _, _ in _static_publishers(case)], launched)}
    kinds[ROBOT_STATE_PUBLISHER] = ([*robot.published_by(ROBOT_STATE_PUBLISHER)], has_urdf)
    for kind, (joints, is_there) in kinds.items():
        is_explicit = any(exists(case.tree, case.joint(joint, "publisher")) for joint in joints)
        if not is_there and (is_explicit or (launched and joints)):
            which = f"{count_of(len(joints), 'joint')} ({first_of([joint.name for joint in joints], 3)})"
            format = next(one for one in case.formats.values() if one.write is not None and kind in one.feeds)
            message = f"{kind} has to publish {which}, but no output has the format {format.name}"
            help = f'add "{format.name}: {{file: {format.file.format(robot.name)}}}" to "outputs"'
            yield case.problem("unpublished-edge", message, ("outputs",), help, key=True)


@rule("planar-taken-as-fixed", help="Write `type: floating` and `publisher: NAME` or `{none: REASON}`.", topic=JOINTS)
def planar(case: Case) -> Iterator[Diagnostic]:
    """A warning: a planar joint is in the URDF, but robot_state_publisher treats it as fixed.

    kdl_parser treats unknown types as fixed, and robot_state_publisher publishes these (not floating joints) as static.
    """
    has_urdf = bool(case.outputs_read_by(ROBOT_STATE_PUBLISHER))
    for joint in case.robot.joints:
        if joint.type == "planar" and (joint.publisher.kind == ROBOT_STATE_PUBLISHER or has_urdf):
            message = f'joint "{joint.name}" is planar, but robot_state_publisher publishes it as a fixed joint'
            yield case.problem("planar-taken-as-fixed", message, case.publisher(joint))


@rule("static-tf-moves", "A moving joint has a static publisher.", "Let robot_state_publisher publish it.", FRAMES)
@rule("bad-node-name", "ROS 2 refuses the name of a node.", "Use letters, digits and underscores.", FRAMES)
@rule("duplicate-node", "Two nodes have one name.", "Give each static_transform_publisher its own node name.", FRAMES)
def static_publishers(case: Case) -> Iterator[Diagnostic]:
    """Report moving joints with a static_transform_publisher, and node names that are invalid or repeated."""
    taken: dict[str, Path] = {ROBOT_STATE_PUBLISHER: ()}
    for key, entry in case.section("publishers").items():
        taken.setdefault((entry or {}).get("node", key), ("publishers", key))
    for joint, publisher, path in _static_publishers(case):
        if not joint.is_fixed:
            message = f'joint "{joint.name}" is {joint.type}, but a static_transform_publisher is for fixed joints'
            yield case.problem("static-tf-moves", message, path)
        name, place = publisher.name, (*path, STATIC_TRANSFORM_PUBLISHER)
        if not (name.isascii() and name.isidentifier()):
            yield case.problem("bad-node-name", f'"{name}" is not a valid name of a ROS 2 node', place)
        if (first := taken.setdefault(name, place)) is not place:
            related = [("first used here", first)] if first else []
            yield case.problem("duplicate-node", f'two ROS nodes have the name "{name}"', place, related=related)


def _pieces_with(steps: Iterable[Step], links: Collection[str]) -> list[set[str]]:
    return [piece for piece in pieces((one.parent, one.child) for one in steps) if not piece.isdisjoint(links)]


@Check
def known_frames(case: Case) -> Iterator[Diagnostic]:
    """Report frames in ``edges`` that have no connection to a link because a name is misspelt (rule unknown-link)."""
    robot, misspelt = case.robot, list(_misspelt_world(case))
    yield from misspelt
    pairs = [(joint.parent, joint.child) for joint in robot.joints] + [(e.parent, e.child) for e in robot.edges]
    for piece in pieces(pairs) if robot.edges and not misspelt else ():
        inside = [(index, edge) for index, edge in enumerate(robot.edges) if edge.parent in piece]
        if not inside or not piece.isdisjoint(robot.link):
            continue
        known = {*robot.link, *(name for pair in pairs for name in pair)} - piece
        ends = [(getattr(edge, key), case.edge(index, key)) for index, edge in inside for key in ("parent", "child")]
        near = [end for end in ends if end[0] not in WORLD_FRAMES and nearest(end[0], known)]
        name, path = (near or ends)[0]
        message, help = f'there is no frame "{name}"', case.suggest(path, name, known, "use a link of the robot")
        yield case.problem("unknown-link", f"{message}: no edge connects it to a link of the robot", path, help)


def _misspelt_world(case: Case) -> Iterator[Diagnostic]:
    children, parents = ({getattr(edge, end) for edge in case.robot.edges} for end in ("child", "parent"))
    for index, edge in enumerate(case.robot.edges):
        for key, name in (("parent", edge.parent), ("child", edge.child)):
            meant = next((word for word in swaps(name) if word in WORLD_FRAMES), None)
            # A frame is not a misspelt world frame if it is a link or has a parent.
            is_free = name in case.robot.link or (key == "parent" and name in children)
            is_named = key == "parent" or (edge.parent in WORLD_FRAMES and meant in children | parents)
            if meant and not is_free and is_named:
                path = case.edge(index, key)
                yield case.problem("unknown-link", f'there is no frame "{name}"', path, suggest(meant))


@rule("edge-cycle", help="Correct `parent` or `child` of one of these, so that frames form a tree.", topic=FRAMES)
def no_cycle(case: Case) -> Iterator[Diagnostic]:
    """Transforms of joints and `edges` form a cycle in some combination of modes."""
    steps, count = steps_in_modes(case)[0] if case.robot.is_tree and case.robot.edges else [], 0
    graph: TopologicalSorter[str] = TopologicalSorter()  # Python 3.10 cannot call TopologicalSorter[str]
    for step in steps:
        graph.add(step.child, step.parent)
    with suppress(CycleError):
        graph.prepare()
        return  # all transforms together have no cycle
    while len(steps) != count:  # drop transforms from a root or to a leaf, which are not in a cycle
        parents, children, count = {step.parent for step in steps}, {step.child for step in steps}, len(steps)
        steps = [step for step in steps if step.parent in children and step.child in parents]
    modes = modes_in(case.robot, [step.when for step in steps])
    for combination in combinations(modes) if len(modes) <= MAX_MODES else ():
        above = {step.child: step for step in reversed(active_in(steps, combination))}
        for names in circles({child: step.parent for child, step in above.items()}):
            circle = [above[name] for name in reversed(names)]
            edges = [step for step in circle if step.edge is not None]
            chain = " -> ".join([circle[0].parent, *(step.child for step in circle)])
            related = [(f"{step.parent} -> {step.child}", step.path) for step in edges[:-1]]
            yield case.problem("edge-cycle", f"transforms form a loop: {chain}", edges[-1].path, related=related)
            return


@rule("split-urdf", help="Let robot_state_publisher publish this joint, or none of the joints below it.", topic=FRAMES)
def one_urdf(case: Case) -> Iterator[Diagnostic]:
    """The URDF would have two roots, because a node other than robot_state_publisher publishes a joint between them."""
    if not case.robot.is_tree or not case.outputs_read_by(ROBOT_STATE_PUBLISHER):
        return
    main, *others = _urdf_roots(case) or [""]
    for root in others:
        above = case.robot.joint_to[root]
        message = f'the URDF would have two roots, "{main}" and "{root}": joint "{above.name}" is not in it'
        yield case.problem("split-urdf", message, case.publisher(above))


def _urdf_roots(case: Case) -> list[str]:
    joints = case.robot.in_urdf()
    reached = {joint.child for joint in joints}
    roots = list(dict.fromkeys(joint.parent for joint in joints if joint.parent not in reached))
    return sorted(roots, key=lambda root: -len(case.robot.subtree(root))) if len(roots) > 1 else roots


@rule("split-tf", help="Add a publisher to this transform, or write `none: REASON` for joints below it.", topic=FRAMES)
def one_tree(case: Case) -> Iterator[Diagnostic]:
    """A warning: frames are cut off from the tree, because no node publishes a joint above them."""
    if not case.robot.is_tree or not case.robot.published_by(UNPUBLISHED):
        return
    # Include edges with an invalid condition, which another rule reports.
    published = [step for step in all_steps(case, legal=False) if not step.is_silent]
    links, reached = set(case.robot.link), {step.child for step in published}
    parts = _pieces_with(published, links)
    main = max(parts, key=lambda piece: len(piece & links), default=set())
    for piece in (piece for piece in parts if piece != main):
        first = next((step for step in published if step.parent in piece and step.parent not in reached), None)
        if first is None:  # all transforms are in a cycle, which another rule reports
            continue
        if first.parent not in links:
            help = case.suggest(first.path, first.parent, {*links, *reached}, "name a frame")
            yield case.problem("unknown-link", f'there is no frame "{first.parent}"', first.path, help)
        elif first.parent not in _urdf_roots(case)[1:] and first.parent in case.robot.joint_to:
            above = case.robot.joint_to[first.parent]
            why = f': no node publishes the transform to "{first.parent}" (joint "{above.name}")'
            yield _cut_off(case, piece, why, case.publisher(above))


@Check
def one_tree_in_modes(case: Case) -> Iterator[Diagnostic]:
    """Report links that are cut off from the tree in some modes, because a frame changes its parent (rule split-tf)."""
    published, silent = steps_in_modes(case)
    modes = modes_in(case.robot, [step.when for step in (*published, *silent)])
    if not case.robot.is_tree or not modes:
        return
    if len(modes) > MAX_MODES:
        whens: dict[str, list[str]] = {}
        for step in published:
            whens.setdefault(step.child, []).append(step.when)
        if all(len(modes_in(case.robot, some)) <= MAX_MODES for some in whens.values()):  # else another rule reports it
            last = next(step for step in reversed(published) if step.when)
            message = f"the transforms depend on {len(modes)} modes together, which is too many to check"
            yield case.problem("too-many-modes", message, last.path, "use at most 10 modes", severity=WARNING)
        return
    links, claimed = set(case.robot.link), {step.child for step in published}
    for combination in combinations(modes):
        active = active_in(published, combination)
        reached = {step.child for step in active}
        # Frames without a publisher in this combination, although their joints do not declare that (``none``).
        gaps = claimed - {step.child for step in active_in(silent, combination)}
        parts = _pieces_with(active, links)
        for whole in _pieces_with(published, links):
            inside = sorted((piece for piece in parts if piece <= whole), key=lambda piece: -len(piece & links))
            for piece in inside[1:]:
                tops = piece - reached
                if tops and not tops & gaps:  # without a root, the piece is a cycle
                    across = (step for step in published if (step.parent in piece) != (step.child in piece))
                    lost = next(step for step in across if step not in active)
                    yield _cut_off(case, piece, in_words(combination), lost.path)
                    return


def _cut_off(case: Case, piece: set[str], why: str, path: Path) -> Diagnostic:
    names = quote(name for name in case.robot.link if name in piece)
    return case.problem("split-tf", f"{names} would not be connected to the transform tree{why}", path)


@rule("unknown-frame-id", help="Correct the name under `stamps`, or name the publisher of the frame.", topic=FRAMES)
def unknown_frame_ids(case: Case) -> Iterator[Diagnostic]:
    """The frame_id of messages does not exist; a warning if no transform leads to the frame in some mode."""
    robot, stamps = case.robot, list[tuple[str, str, Path]]()  # (frame, publisher of the messages, path)
    for sensor in case.robot.sensors:
        place: Path = ("sensors", sensor.name)
        declared = exists(case.tree, (*place, "stamps"))
        for index, frame in enumerate(sensor.stamps):
            own = (*place, "frame") if index == 0 else (*place, "optical", "frame")
            stamps.append((frame, f'sensor "{sensor.name}"', (*place, "stamps", index) if declared else own))
    for name, entry in case.section("publishers").items():
        for index, frame in enumerate((entry or {}).get("stamps", ())):
            stamps.append((frame, f'publisher "{name}"', ("publishers", name, "stamps", index)))
    frames = {*robot.link, *(name for edge in robot.edges for name in (edge.parent, edge.child))}
    published, silent = steps_in_modes(case) if stamps else ([], [])
    modes = modes_in(robot, [step.when for step in (*published, *silent)])
    is_checked = robot.is_tree and len(modes) <= MAX_MODES and len(frames) > 1
    reported: set[str] = set()
    for frame, owner, path in stamps:
        if frame not in frames:
            message = f'there is no frame "{frame}", which is the frame_id of messages of {owner}'
            help = case.suggest(path, frame, frames, "use a frame of the robot")
            yield case.problem("unknown-frame-id", message, path, help)
        elif is_checked and frame not in reported:
            steps = [step for step in published if frame in (step.parent, step.child)]
            absent = [one for one in combinations(modes) if not active_in(steps, one)]
            if any(step.child == frame for step in steps):
                # Only count modes that the joint declares as unpublished (``none``); another rule reports the others.
                turns = [step for step in silent if step.child == frame]
                absent = [one for one in absent if active_in(turns, one)]
            if absent:
                reported.add(frame)
                missing = {} if len(absent) == 2 ** len(modes) else absent[0]  # empty if missing in all modes
                message = f'messages of {owner} have the frame_id "{frame}", but no transform leads to that frame'
                message += in_words(missing)
                way = f"add a publisher of a transform to this frame{' for that mode' if missing else ''}"
                yield case.problem("unknown-frame-id", message, path, way, severity=WARNING)

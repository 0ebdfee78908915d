"""The tree that the running robot publishes: in every mode, joints and edges are one tree that has all frames."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.model.joint import UNPUBLISHED
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, nearest
from rosorin_compile.source.rule_registry import FRAMES, Check, rule
from rosorin_compile.source.tree import Path, exists
from rosorin_compile.source.wording import quote, suggest, swaps

from .case import Case
from .joints import WORLD_FRAMES, pieces
from .publishers import MAX_MODES, Step, active_in, all_steps, combinations, in_words, modes_in, steps_in_modes


def _pieces_with(steps: Iterable[Step], links: Collection[str]) -> list[set[str]]:
    found = pieces((step.parent, step.child) for step in steps)
    return [piece for piece in found if not piece.isdisjoint(links)]


@Check
def known_frames(case: Case) -> Iterator[Diagnostic]:
    """Edges that connect to no link: one of their names is misspelt (unknown-link)."""
    robot = case.robot
    misspelt = list(_misspelt_world(case))
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
        message, help = f'there is no frame "{name}"', case.suggest(path, name, known, "name a link of the robot")
        yield case.problem("unknown-link", f"{message}: nothing leads from its edges to a link", path, help)


def _misspelt_world(case: Case) -> Iterator[Diagnostic]:
    """Yield the ends of edges that are the name of a frame of the world with two letters swapped."""
    edges = case.robot.edges
    children = {edge.child for edge in edges}
    for index, edge in enumerate(edges):
        for key, name in (("parent", edge.parent), ("child", edge.child)):
            meant = next((word for word in swaps(name) if word in WORLD_FRAMES), None)
            # A frame that is attached to the robot, or leads to it, may have any name.
            is_free = name in case.robot.link or (key == "parent" and name in children)
            is_named = meant in children or any(meant == edge.parent for edge in edges)
            if meant and not is_free and (key == "parent" or (edge.parent in WORLD_FRAMES and is_named)):
                message, help = f'there is no frame "{name}"', suggest(meant)
                yield case.problem("unknown-link", message, case.edge(index, key), help)


@rule("edge-cycle", help="Correct the parent or the child of an edge: frames are a tree.", topic=FRAMES)
def no_cycle(case: Case) -> Iterator[Diagnostic]:
    """Edges lead, with the joints between, back to where they began, in some combination of modes."""
    core = _on_circles(steps_in_modes(case)[0]) if case.robot.is_tree and case.robot.edges else []
    modes = modes_in(case.robot, [step.when for step in core])
    for combination in combinations(modes) if len(modes) <= MAX_MODES else ():
        above = {step.child: step for step in reversed(_on_circles(active_in(core, combination)))}
        here, walked = next(reversed(above), ""), dict[str, Step]()
        while here in above and here not in walked:  # every way up ends in a circle
            walked[here] = above[here]
            here = above[here].parent
        circle = list(walked.values())[list(walked).index(here) :][::-1] if walked else []
        edges = [step for step in circle if step.edge is not None]
        if edges:
            chain = " -> ".join([circle[0].parent, *(step.child for step in circle)])
            related = [(f"{step.parent} -> {step.child}", step.path) for step in edges[:-1]]
            yield case.problem("edge-cycle", f"transforms form a circle: {chain}", edges[-1].path, related=related)
            return


def _on_circles(steps: list[Step]) -> list[Step]:
    """Return the transforms of circles, and those that lead from one to another."""
    for start, end in (("parent", "child"), ("child", "parent")):  # first leave out roots, then leaves
        after: dict[str, list[str]] = {}
        for step in steps:
            after.setdefault(getattr(step, start), []).append(getattr(step, end))
        count = Counter(getattr(step, end) for step in steps)
        ready = [name for name in after if not count[name]]
        for name in ready:
            for other in after.get(name, ()):
                count[other] -= 1
                ready += [] if count[other] else [other]
        steps = [step for step in steps if count[getattr(step, start)]]
    return steps


@rule("split-urdf", help="Let one publisher have both joints.", topic=FRAMES)
def one_urdf(case: Case) -> Iterator[Diagnostic]:
    """The URDF would have two roots, because another node publishes a joint between them."""
    if not case.robot.is_tree or not case.feeding(ROBOT_STATE_PUBLISHER):
        return
    main, *others = _urdf_roots(case) or [""]
    for root in others:
        ours = case.robot.in_urdf()
        first = next(joint for joint in case.robot.joints_from[root] if joint in ours)
        above = case.robot.joint_to.get(root, first)
        message = f'the URDF would have two roots, "{main}" and "{root}": it has joint "{first.name}",'
        message += f' but not joint "{above.name}", which carries that'
        yield case.problem("split-urdf", message, case.publisher(above), key=above is first)


def _urdf_roots(case: Case) -> list[str]:
    """Return the roots of the joints in the URDF, that of the most links first."""
    joints = case.robot.in_urdf()
    reached = {joint.child for joint in joints}
    roots = list(dict.fromkeys(joint.parent for joint in joints if joint.parent not in reached))
    return sorted(roots, key=lambda root: -len(case.robot.subtree(root))) if len(roots) > 1 else roots


@rule("split-tf", help="Publish the joint, or nothing below it.", topic=FRAMES)
def one_tree(case: Case) -> Iterator[Diagnostic]:
    """A warning: frames are published, but a joint above them is on no topic, always or in some mode."""
    if not case.robot.is_tree or not case.robot.published_by(UNPUBLISHED):
        return
    # Edges with an invalid condition count: the condition is reported, and not what follows from it.
    published = [step for step in all_steps(case, legal=False) if not step.is_silent]
    links, reached = set(case.robot.link), {step.child for step in published}
    parts = _pieces_with(published, links)
    main = max(parts, key=lambda piece: len(piece & links), default=set())
    for piece in (piece for piece in parts if piece != main):
        first = next((step for step in published if step.parent in piece and step.parent not in reached), None)
        names = quote(name for name in case.robot.link if name in piece)
        if first is None:  # a circle, which has a rule of its own
            continue
        if first.parent not in links:
            message = f'there is no link "{first.parent}": {names} would be cut off from the rest of the robot'
            help = case.suggest(first.path, first.parent, {*links, *reached}, "name a frame")
            yield case.problem("unknown-link", message, first.path, help)
        elif first.parent not in _urdf_roots(case)[1:] and first.parent in case.robot.joint_to:
            above = case.robot.joint_to[first.parent]
            message = f"{names} would be cut off from the rest of the running robot: no node publishes joint"
            message += f' "{above.name}", which carries "{first.parent}"'
            yield case.problem("split-tf", message, case.publisher(above))


@Check
def one_tree_in_modes(case: Case) -> Iterator[Diagnostic]:
    """Links that are cut off in some combination of modes alone, because a frame changes its parent (split-tf)."""
    published, silent = steps_in_modes(case)
    modes = modes_in(case.robot, [step.when for step in (*published, *silent)])
    if not case.robot.is_tree or not modes:
        return
    if len(modes) > MAX_MODES:
        whens: dict[str, list[str]] = {}
        for step in published:
            whens.setdefault(step.child, []).append(step.when)
        if all(len(modes_in(case.robot, some)) <= MAX_MODES for some in whens.values()):
            last = next(step for step in reversed(published) if step.when)
            message = f"the transforms depend on {len(modes)} modes together: too many to check"
            yield case.problem("too-many-modes", message, last.path, "use at most 10 modes", severity=WARNING)
        return
    links, claimed = set(case.robot.link), {step.child for step in published}
    for combination in combinations(modes):
        active = active_in(published, combination)
        reached = {step.child for step in active}
        # A frame that is published in another mode is a gap, which is reported, unless nobody is to do it here.
        gaps = claimed - {step.child for step in active_in(silent, combination)}
        parts = _pieces_with(active, links)
        for whole in _pieces_with(published, links):
            inside = sorted((piece for piece in parts if piece <= whole), key=lambda piece: -len(piece & links))
            for piece in inside[1:]:
                tops = piece - reached
                if tops and not tops & gaps:  # without a top it is a circle
                    across = [step for step in published if (step.parent in piece) != (step.child in piece)]
                    lost = next(step for step in across if step not in active)
                    names = quote(name for name in case.robot.link if name in piece)
                    message = f"{names} would be cut off from the rest of the running robot{in_words(combination)}"
                    yield case.problem("split-tf", message, lost.path)
                    return


def _stamps(case: Case) -> Iterator[tuple[str, str, Path]]:
    """Yield the frames that messages are stamped with, by whom, and where."""
    for sensor in case.robot.sensors:
        path: Path = ("sensors", sensor.name)
        declared = exists(case.tree, (*path, "stamps"))
        for index, frame in enumerate(sensor.stamps):
            own = (*path, "frame") if index == 0 else (*path, "optical", "frame")
            yield frame, f'sensor "{sensor.name}"', (*path, "stamps", index) if declared else own
    for name, entry in case.section("publishers").items():
        for index, frame in enumerate((entry or {}).get("stamps", ())):
            yield frame, f'publisher "{name}"', ("publishers", name, "stamps", index)


@rule("unknown-frame-id", help="Correct the name under `stamps`, or name the publisher of the frame.", topic=FRAMES)
def unknown_frame_ids(case: Case) -> Iterator[Diagnostic]:
    """Messages are stamped with a frame that does not exist. As a warning: tf2 does not know it in some mode."""
    robot, stamps = case.robot, list(_stamps(case))
    frames = {*robot.link, *(name for edge in robot.edges for name in (edge.parent, edge.child))}
    published, silent = steps_in_modes(case) if stamps else ([], [])
    modes = modes_in(robot, [step.when for step in (*published, *silent)])
    is_checked = robot.is_tree and len(modes) <= MAX_MODES and len(frames) > 1
    reported: set[str] = set()
    for frame, owner, path in stamps:
        if frame not in frames:
            message = f'there is no frame "{frame}", which {owner} stamps its messages with'
            help = case.suggest(path, frame, frames, "name a frame of the robot")
            yield case.problem("unknown-frame-id", message, path, help)
        elif is_checked and frame not in reported:
            steps = [step for step in published if frame in (step.parent, step.child)]
            absent = [one for one in combinations(modes) if not active_in(steps, one)]
            turns = [step for step in silent if step.child == frame]
            if any(step.child == frame for step in steps):
                # A gap in a mode is reported by its own rule, unless the description leaves it open.
                absent = [one for one in absent if active_in(turns, one)]
            if absent:
                reported.add(frame)
                missing = {} if len(absent) == 2 ** len(modes) else absent[0]  # {} is always
                message = f'tf2 does not know the frame "{frame}"{in_words(missing)}, which {owner} stamps its messages'
                yield case.problem("unknown-frame-id", f"{message} with", path, severity=WARNING)

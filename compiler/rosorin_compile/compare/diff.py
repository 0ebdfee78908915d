"""Diff: two robots compared by meaning, whatever they were written in, for a person who asks what differs.

B is put under the names of A first (``pairing``); then frames, joints, masses, shapes and the rest are compared, each
seen from the nearest thing that both have. What a format cannot say is told as not compared, never as a difference.
"""

from __future__ import annotations

from dataclasses import replace

from rosorin_compile.model.looks import shows_collision

from .difference import DEFAULT_TOLERANCE, FRAME, JOINT, KINDS, YAML, Difference, Item, Side
from .frames import compare_frames, furthest
from .masses import compare_masses
from .not_compared import not_carried, uncompared
from .pairing import Pairing, compare_names, pair
from .renaming import renamed
from .rest import compare_rest
from .shapes import compare_shapes


def compare_robots(a: Side, b: Side, tolerance: float = DEFAULT_TOLERANCE, prefix: str | None = None) -> Difference:
    """Return how two robots differ by meaning.

    ``tolerance`` is no difference (m, rad, parts of other numbers), besides what the digits of a source leave open.
    ``prefix`` is what the names of B begin with, None: find out, empty: nothing.
    """
    if all(side.format is YAML and side.robot.as_said().is_tree for side in (a, b)):
        # Each difference is told where it is said, not in what a section adds to.
        a, b = (side._replace(robot=side.robot.as_said()) for side in (a, b))
    pairing = side_by_side(a, b, tolerance, prefix)
    missing, lacking = not_carried(pairing, a, b)
    silent = uncompared(a, b)
    frames = compare_frames(pairing)
    items = [*frames.items, *compare_rest(pairing, (a, b), frames.coordinates, silent.topics)]
    notes = [*_prefix_note(pairing, a, b), *frames.notes]
    not_compared = [*lacking, *silent.lines]
    if "mass" not in silent.topics:
        found, said = compare_masses(pairing, frames.clusters)
        items += found
        notes += said
    for purpose in ("collision", "visual"):
        if purpose not in silent.topics:
            shapes = compare_shapes(pairing, (a, b), frames.clusters, purpose)
            items += shapes.items
            notes += shapes.notes
            not_compared += shapes.not_compared
    items += compare_names(pairing, missing, "fixed joint name" not in silent.topics)
    if a.robot.name != b.robot.name and a.format.writing.names_robot and b.format.writing.names_robot:
        notes.append(f"the robot is called {a.robot.name} in A, {b.robot.name} in B")
    moved = [item for item in items if item.kind in (FRAME, JOINT)]
    if moved:
        notes += furthest(pairing, frames.coordinates, moved)
    return Difference(a, b, _arranged(pairing, items), tuple(notes), tuple(not_compared), tolerance)


def side_by_side(a: Side, b: Side, tolerance: float, prefix: str | None) -> Pairing:
    """Return two robots under common names, as they are compared; they keep the order of their links and joints."""
    return pair(*_known_names(_described(a, b), _described(b, a)), tolerance, prefix)


def _described(side: Side, other: Side) -> Side:
    """Return a robot without the visuals that an output made of collision shapes, where the other one has none."""
    shown = [link for link in side.robot.links if link.name in other.robot.link and shows_collision(link)]
    made = {link.name for link in shown if not other.robot.link[link.name].visual}
    links = tuple(replace(link, visual=()) if link.name in made else link for link in side.robot.links)
    return side._replace(robot=replace(side.robot, links=links)) if made else side


def _known_names(a: Side, b: Side) -> tuple[Side, Side]:
    """Return the sides under common names where a description says how an artifact calls its links."""
    for side, other in ((a, b), (b, a)):
        output = other.format.output(side.robot)
        if other.format.proving.names is not None and output is not None:
            names = other.format.proving.names(output)
            free = {new: old for new, old in names.items() if old not in other.robot.link}
            changed = other._replace(robot=renamed(other.robot, free, {}))
            return (a, changed) if other is b else (changed, b)
    return _carrying(a, b), _carrying(b, a)


def _carrying(side: Side, other: Side) -> Side:
    """Return a description with the masses where the other file has them: with what carries links that it leaves out.

    What is fixed to each other is compared as a whole in any case; this is for what a joint moves.
    """
    robot, leaves_out = side.robot, other.format.writing.leaves_out
    carried = {name for name in robot.link if name in other.robot.link}
    if side.format is not YAML or leaves_out is None or not carried or len(carried) == len(robot.links):
        return side
    gone = [name for name, (carrier, _) in robot.carriers(carried).items() if robot.moves_between(name, carrier)]
    if not gone or not all(leaves_out(robot, name) for name in gone):
        return side
    try:
        masses = robot.inertials_at(robot.link.keys() - set(gone))
    except ValueError:
        return side
    links = tuple(replace(link, inertial=masses.get(link.name)) for link in robot.links)
    return side._replace(robot=replace(robot, links=links))


def _prefix_note(pairing: Pairing, a: Side, b: Side) -> list[str]:
    if not pairing.prefixed:
        return []
    whole = (b if pairing.prefixed == "B" else a).robot
    cut = sum(name.startswith(pairing.prefix) for name in whole.link)
    some = "" if cut == len(whole.links) else f"{cut} of {len(whole.links)} of "
    return [f'{some}the names of {pairing.prefixed} begin with "{pairing.prefix}"']


def _arranged(pairing: Pairing, items: list[Item]) -> tuple[Item, ...]:
    """Return the differences, the most important kind first, each kind in the order of the tree."""
    order = {name: index for index, name in enumerate([*pairing.a.order, *pairing.b.order])}
    for bodies in (pairing.b, pairing.a):
        order |= {joint.name: order[joint.child] for joint in bodies.robot.joints if joint.name not in bodies.order}
    order |= pairing.a.order
    last = len(order)
    return tuple(sorted(items, key=lambda item: (KINDS.index(item.kind), order.get(item.name, last))))

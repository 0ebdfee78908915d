"""Compare two robots by meaning, whatever they were written in, for a person who asks what differs.

B is put under the names of A first (``pairing``); then frames, masses, shapes and the rest are compared, each seen from
the nearest thing that both have. What a format cannot contain is reported as not compared, never as a difference.
"""

from __future__ import annotations

from dataclasses import replace

from rosorin_compile.formats.urdf.write import carriers, inertials_at
from rosorin_compile.model import Robot
from rosorin_compile.model.colours import shows_collision

from .difference import DEFAULT_TOLERANCE, KINDS, YAML, Difference, Item, Report, Side
from .frame_poses import compare_frames
from .masses import compare_masses
from .names import renamed_robot
from .pairing import Pairing, compare_names, pair
from .sections import compare_sections
from .sentences import several
from .shapes import compare_shapes


def compare_robots(a: Side, b: Side, tolerance: float = DEFAULT_TOLERANCE, prefix: str | None = None) -> Difference:
    """Return how two robots differ by meaning.

    ``tolerance`` is no difference (m, rad, parts of other numbers), besides what the digits of a source leave open.
    ``prefix`` is what the names of B begin with, None: find out, empty: nothing.
    """
    if all(side.format is YAML and side.robot.as_said().is_tree for side in (a, b)):
        # Each difference is reported where it is written, not in what a section adds to.
        a, b = (side._replace(robot=side.robot.as_said()) for side in (a, b))
    pairing = pair_sides(a, b, tolerance, prefix)
    missing, not_compared = not_carried(pairing, a, b)
    report = Report([], _prefix_note(pairing, a, b), not_compared)
    frames = compare_frames(pairing, report)
    topics = compare_sections(pairing, (a, b), frames.flipped, report)
    if "mass" not in topics:
        compare_masses(pairing, frames.origins, report)
    for purpose in [one for one in ("collision", "visual") if one not in topics]:
        compare_shapes(pairing, (a, b), frames.origins, purpose, report)
    report.items.extend(compare_names(pairing, missing, "fixed joint name" not in topics))
    if a.robot.name != b.robot.name and a.format.names_robot and b.format.names_robot:
        report.notes.append(f"the robot is called {a.robot.name} in A, {b.robot.name} in B")
    items = _arranged(pairing, report.items)
    return Difference(a, b, items, tuple(report.notes), tuple(report.not_compared), tolerance)


def pair_sides(a: Side, b: Side, tolerance: float, prefix: str | None) -> Pairing:
    """Return two robots under common names, as they are compared; they keep the order of their links and joints."""
    a, b = _without_made_visuals(a, b), _without_made_visuals(b, a)
    for side, other in ((a, b), (b, a)):
        output = other.format.output(side.robot)
        if other.format.names is not None and output is not None:  # a description says how an artifact calls its links
            names = other.format.names(output)
            free = {new: old for new, old in names.items() if old not in other.robot.link}
            changed = other._replace(robot=renamed_robot(other.robot, free, {}))
            pairing = pair(*((a, changed) if other is b else (changed, b)), tolerance, prefix)
            steps = pairing.steps
            found = (steps[0], [(free, {}), *steps[1]]) if other is b else ([(free, {}), *steps[0]], steps[1])
            return pairing._replace(steps=found)
    return pair(_carrying(a, b), _carrying(b, a), tolerance, prefix)


def _without_made_visuals(side: Side, other: Side) -> Side:
    """Return a robot without the visuals that an output made of collision shapes, where the other one has none."""
    links = tuple(
        replace(link, visual=())
        if link.name in other.robot.link and not other.robot.link[link.name].visual and shows_collision(link)
        else link
        for link in side.robot.links
    )
    return side if links == side.robot.links else side._replace(robot=replace(side.robot, links=links))


def _carrying(side: Side, other: Side) -> Side:
    """Return a description with the masses where the other file has them: with what carries links that it leaves out.

    What is fixed together is compared as a whole in any case; this is for what a joint moves.
    """
    robot, leaves_out = side.robot, other.format.leaves_out
    carried = {name for name in robot.link if name in other.robot.link}
    if side.format is not YAML or leaves_out is None or not carried or len(carried) == len(robot.links):
        return side
    found = carriers(robot, frozenset(carried)).items()
    gone = [name for name, (carrier, _) in found if robot.moves_between(name, carrier)]
    if not gone or not all(leaves_out(robot, name) for name in gone):
        return side
    try:
        masses = inertials_at(robot, robot.link.keys() - set(gone))
    except ValueError:
        return side
    links = tuple(replace(link, inertial=masses.get(link.name)) for link in robot.links)
    return side._replace(robot=replace(robot, links=links))


def not_carried(pairing: Pairing, a: Side, b: Side) -> tuple[frozenset[str], list[str]]:
    """Return the links of one robot that the other one's file leaves out by its nature, and sentences on them."""
    names: set[str] = set()
    lines: list[str] = []
    for robot, other, side, its in ((pairing.a.robot, pairing.b.robot, a, b), (pairing.b.robot, pairing.a.robot, b, a)):
        output = _output_without(robot, side, its)
        absent = [link.name for link in robot.walk() if link.name not in other.link]
        left = [name for name in absent if output or _is_left_out(robot, name, side, its)]
        names.update(left)
        if left:
            why = (its if side.format is YAML or its.format is not YAML else side).format.why
            why = f"its output {output} has no such links" if output else why
            lines.append(f"{several(left)} of {side.label}: {why}")
    return frozenset(names), lines


def _output_without(robot: Robot, side: Side, other: Side) -> str:
    """Return the output of a description that has the very links of the other file, and not all; empty if none."""
    links = other.format.links
    if side.format is not YAML or links is None or len(other.robot.links) == len(robot.links):
        return ""
    outputs = [one for one in robot.outputs if one.backend == other.format.name and other.format.is_withheld(one)]
    return next((one.name for one in outputs if set(links(robot, one)) == set(other.robot.link)), "")


def _is_left_out(robot: Robot, link: str, side: Side, other: Side) -> bool:
    """Return True if the file of the other robot lacks a link of this one by the nature of a format."""
    if other.format is YAML:
        return side.format.adds is not None and side.format.adds(robot, link, other.robot)
    return other.format.leaves_out is not None and other.format.leaves_out(robot, link)


def _prefix_note(pairing: Pairing, a: Side, b: Side) -> list[str]:
    if not pairing.prefixed:
        return []
    robot = (b if pairing.prefixed == "B" else a).robot
    cut = sum(name.startswith(pairing.prefix) for name in robot.link)
    some = "" if cut == len(robot.links) else f"{cut} of {len(robot.links)} of "
    return [f'{some}the names of {pairing.prefixed} begin with "{pairing.prefix}"']


def _arranged(pairing: Pairing, items: list[Item]) -> tuple[Item, ...]:
    order = {name: index for index, name in enumerate([*pairing.a.order, *pairing.b.order])}
    for bodies in (pairing.b, pairing.a):
        order |= {joint.name: order[joint.child] for joint in bodies.robot.joints if joint.name not in bodies.order}
    order |= pairing.a.order
    last = len(order)
    return tuple(sorted(items, key=lambda item: (KINDS.index(item.kind), order.get(item.name, last))))

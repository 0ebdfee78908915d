"""Compare two robots by meaning, whatever format they were written in, and report the differences.

B gets the names of A first (``bodies``). Then frames, masses, shapes and sections are compared, relative to the nearest
link that both have. Values that a format does not support are reported as not compared, not as differences.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from rosorin_compile.formats.urdf.write import carriers, inertials_at
from rosorin_compile.model import Inertial
from rosorin_compile.model.colours import shows_collision
from rosorin_compile.model.link import together

from .bodies import Bodies, Pairing, compare_names, pair
from .describe import Describer
from .difference import DEFAULT_TOLERANCE, KINDS, MASS, YAML, Difference, Item, Report, Side
from .frame_poses import compare_frames
from .names import renamed_robot
from .precision import Precision
from .sections import compare_sections
from .sentences import row, several
from .shapes import compare_shapes
from .walk import Difference as Leaf
from .walk import compare_leaves, inertial_leaves


def compare_robots(a: Side, b: Side, tolerance: float = DEFAULT_TOLERANCE, prefix: str | None = None) -> Difference:
    """Compare two robots by meaning and return the differences.

    Differences up to ``tolerance`` (m, rad, relative for other numbers) plus printed rounding are ignored.
    ``prefix`` is the prefix of all names in B; None detects it, and an empty text means no prefix.
    """
    if all(side.format is YAML and side.robot.as_said().is_tree for side in (a, b)):
        # Compare without the additions of sections, so that a difference in a section is reported there only.
        a, b = (side._replace(robot=side.robot.as_said()) for side in (a, b))
    pairing = pair_sides(a, b, tolerance, prefix)
    missing, not_compared = not_carried(pairing, a, b)
    report = Report([], [], not_compared)
    if pairing.prefixed:
        names = (b if pairing.prefixed == "B" else a).robot.link
        cut = sum(name.startswith(pairing.prefix) for name in names)
        some = "" if cut == len(names) else f"{cut} of {len(names)} of "
        report.notes.append(f'{some}the names of {pairing.prefixed} begin with "{pairing.prefix}"')
    origins, flipped = compare_frames(pairing, report)
    topics = compare_sections(pairing, (a, b), flipped, report)
    if "mass" not in topics:
        _compare_masses(pairing, origins, report)
    for purpose in [purpose for purpose in ("collision", "visual") if purpose not in topics]:
        compare_shapes(pairing, (a, b), origins, purpose, report)
    report.items.extend(compare_names(pairing, missing, "fixed joint name" not in topics))
    if a.robot.name != b.robot.name and a.format.names_robot and b.format.names_robot:
        report.notes.append(f"the robot is called {a.robot.name} in A, {b.robot.name} in B")
    order = {name: index for index, name in enumerate({**pairing.a.top, **pairing.b.top})}
    for joint in (*pairing.a.robot.joints, *pairing.b.robot.joints):
        order.setdefault(joint.name, order[joint.child])
    items = sorted(report.items, key=lambda item: (KINDS.index(item.kind), order.get(item.name, len(order))))
    return Difference(a, b, tuple(items), tuple(report.notes), tuple(report.not_compared), tolerance)


def pair_sides(a: Side, b: Side, tolerance: float, prefix: str | None) -> Pairing:
    """Match two robots under common names; they keep the order of their links and joints."""
    a, b = _without_made_visuals(a, b), _without_made_visuals(b, a)
    for at, side, other in ((1, a, b), (0, b, a)):
        output = other.format.output(side.robot)
        if other.format.names is not None and output is not None:  # an output can rename the links of its artifact
            names = other.format.names(output)
            free = {new: old for new, old in names.items() if old not in other.robot.link}
            other = other._replace(robot=renamed_robot(other.robot, free, {}))
            pairing = pair(a, other, tolerance, prefix) if at else pair(other, b, tolerance, prefix)
            pairing.steps[at].insert(0, (free, {}))
            return pairing
    return pair(_carrying(a, b), _carrying(b, a), tolerance, prefix)


def _without_made_visuals(side: Side, other: Side) -> Side:
    """Remove visuals that were made from collision shapes, for links without visuals in the other robot."""
    bare = {link.name for link in other.robot.links if not link.visual}
    made = {link.name for link in side.robot.links if link.name in bare and shows_collision(link)}
    links = tuple(replace(link, visual=()) if link.name in made else link for link in side.robot.links)
    return side._replace(robot=replace(side.robot, links=links)) if made else side


def _carrying(side: Side, other: Side) -> Side:
    """Add the masses of links that the other file leaves out to the links of a description that carry them.

    This is for links below moving joints; links that are fixed to each other are compared as one body anyway.
    """
    robot, leaves_out = side.robot, other.format.leaves_out
    carried = frozenset(robot.link.keys() & other.robot.link.keys())
    if side.format is not YAML or leaves_out is None or not carried or len(carried) == len(robot.links):
        return side
    gone = {name for name, (carrier, _) in carriers(robot, carried).items() if robot.moves_between(name, carrier)}
    if gone and all(leaves_out(robot, name) for name in gone):
        with suppress(ValueError):
            masses = inertials_at(robot, robot.link.keys() - gone)
            links = tuple(replace(link, inertial=masses.get(link.name)) for link in robot.links)
            return side._replace(robot=replace(robot, links=links))
    return side


def not_carried(pairing: Pairing, a: Side, b: Side) -> tuple[frozenset[str], list[str]]:
    """Return the links of one robot that the format of the other leaves out by design, and notes about them."""
    names: set[str] = set()
    lines: list[str] = []
    for robot, other, side, its in ((pairing.a.robot, pairing.b.robot, a, b), (pairing.b.robot, pairing.a.robot, b, a)):
        format, left = its.format, [link.name for link in robot.walk() if link.name not in other.link]
        name = ""
        if side.format is YAML and format.links is not None and len(its.robot.links) != len(robot.links):
            # An output of the description may have exactly the links of the other file.
            outputs = [one for one in robot.outputs if one.backend == format.name and format.is_withheld(one)]
            name = next((one.name for one in outputs if set(format.links(robot, one)) == set(its.robot.link)), "")
        if not name and format is YAML:
            left = [link for link in left if side.format.adds is not None and side.format.adds(robot, link, its.robot)]
        elif not name:
            left = [link for link in left if format.leaves_out is not None and format.leaves_out(robot, link)]
        names.update(left)
        if left:
            why = (its if side.format is YAML or its.format is not YAML else side).format.why
            why = f"its output {name} has no such links" if name else why
            lines.append(f"{several(left)} of {side.label}: {why}")
    return frozenset(names), lines


def _compare_masses(pairing: Pairing, origins: Mapping[str, str], report: Report) -> None:
    """Report differences in the masses of links, or of bodies in the frames ``origins`` if links share a mass."""
    precisions = pairing.a.precision, pairing.b.precision

    def differences(name: str, *sides: tuple[Inertial | None, Precision]) -> Sequence[Leaf]:
        old, new = ({("link", name): inertial_leaves(inertial)} for inertial, _ in sides)
        return compare_leaves(old, new, (sides[0][1], sides[1][1]), pairing.tolerance)

    robots, found = (pairing.a.robot, pairing.b.robot), dict[str, Sequence[Leaf]]()
    for name in pairing.shared:
        inertials = [(robot.link[name].inertial, known) for robot, known in zip(robots, precisions, strict=True)]
        found[name] = differences(name, *inertials)
    for top, goal in pairing.bodies.items():
        members = pairing.a.members[top], pairing.b.members[goal]
        differing = {name for name in members[0] if found.get(name)}
        for robot, names, others in zip(robots, members, members[::-1], strict=True):
            differing |= {name for name in names if name not in others and robot.link[name].inertial is not None}
        if len(differing) > 1 or differing - found.keys():
            wholes = (_whole(side, names, origins[top]) for side, names in zip(pairing[:2], members, strict=True))
            if not differences(top, *wholes):
                links = several(sorted(differing, key=lambda name: (name not in found, name)))
                text = f"the mass of the body of {top} is shared out otherwise ({links}); as a whole it is the same"
                report.notes.append(text)
                found |= dict.fromkeys(differing, ())
    describer = Describer(pairing.a.robot, ({}, {}), precisions, pairing.tolerance)
    units = {"mass": "kg", "inertia": "kg*m^2", "centre of mass": "m"}
    for name in pairing.shared:
        for ((_, _, quantity), old, new), text in describer.describe(found[name]):
            before, after = (old, new) if quantity == "mass" else (row(old), row(new))
            distance = math.dist(old, new) if quantity == "centre of mass" else None
            report.items.append(Item(MASS, name, quantity, text, before, after, units[quantity], distance))


def _whole(bodies: Bodies, names: Sequence[str], frame: str) -> tuple[Inertial | None, Precision]:
    """Return the total inertial of links of a body in one of its frames, and its precision."""
    links = [(inertial, name) for name in names if (inertial := bodies.robot.link[name].inertial) is not None]
    parts = [(inertial, bodies.relative(frame, name)) for inertial, name in links]
    if not any(inertial.mass for inertial, _ in parts):
        return None, bodies.precision
    whole = together([(inertial, place.transform) for inertial, place in parts])
    centres = [place.transform.apply(inertial.pose.xyz) for inertial, place in parts]
    reach = max(math.dist(centre, whole.pose.xyz) for centre in centres)
    length = max(place.length + bodies.precision("xyz", *one.pose.xyz) for one, place in parts)
    masses = math.fsum(bodies.precision("mass", one.mass) for one, _ in parts)
    xyz, ixx = reach * masses / abs(whole.mass or 1.0), masses * reach**2 + 4 * abs(whole.mass) * reach * length
    spread = {"xyz": length + xyz, "ixx": ixx}
    return whole, lambda key, *values: len(parts) * bodies.precision(key, *values) + spread.get(key, 0.0)

"""Others: publishers, transforms of other nodes, named poses, sensors and elements for URDF.

Then mass, centre of mass and inertia: of links, and of whole bodies where links share them out otherwise.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import reduce
from typing import NamedTuple

from ..formats import FORMATS, Fact, Value
from ..frontend.annotations import sections
from ..model import Edge, Inertial, Publisher, Robot, Transform, Vector
from ..model.geometry import minus, norm
from ..model.joint import UNPUBLISHED
from ..model.robot import JointPose
from ..model.sections import own_sections
from .bodies import Bodies
from .difference import MASS, OTHER, Item, Side
from .elements import Context, Key, context_of, said, spelt
from .joints import changed, differ, unit_of
from .pairing import Pairing
from .plainly import either
from .rest import compare_drives, compare_rest, compare_sensors
from .simulation import compare_simulation
from .tolerance import HERE, ROOT_THREE, TURNS, Placed, joined
from .values import text_of
from .wording import centre_change, inertia_change, number_change, row, several, value_change

_MOST = 50

Compare = Callable[[Pairing, tuple[Side, Side]], Iterator[Item]]

# What compares each topic beside links and joints, in the order in which it is told; "rest" is what has none.
_COMPARED: Mapping[str, Compare] = {
    "publisher": lambda pairing, _: _publishers(pairing),
    "edge": lambda pairing, _: _edges(pairing),
    "pose": lambda pairing, _: _poses(pairing),
    "simulation": lambda pairing, _: compare_simulation(pairing.a.robot, pairing.b.robot),
    "sensor": lambda pairing, _: compare_sensors(pairing.a.robot, pairing.b.robot),
    "drive": lambda pairing, _: compare_drives(pairing),
    "rest": compare_rest,
    "urdf_elements": lambda pairing, _: _elements(pairing),
}


def compare_others(pairing: Pairing, sides: tuple[Side, Side], unsaid: frozenset[str]) -> Iterator[Item]:
    """Yield what differs beside links and joints; ``unsaid`` is what is not compared."""
    for topic, compare in _compared().items():
        if topic not in unsaid:
            yield from compare(pairing, sides)


def _compared() -> Mapping[str, Compare]:
    """Return what compares each topic, as it is told: a section behind the topic that its module names in AFTER."""
    known = list(_COMPARED.items())
    for section in own_sections().values():
        if section.compares:
            after = section.module(section.compares).AFTER
            place = [topic for topic, _ in known].index(after) + 1
            known.insert(place, (sections()[section.name].topic, section.function(section.compares)))
    return dict(known)


def _text(publisher: Publisher) -> str:
    if publisher.simulated:
        return "simulations"
    return "nobody" if publisher.kind == UNPUBLISHED else publisher.name


def _published(name: str, old: Publisher, new: Publisher) -> Item:
    names = _text(old), _text(new)
    text = value_change(Fact("frame", name, "publisher").about, Value(names[0]), Value(names[1])).text
    return Item(OTHER, name, "publisher", text, *names)


def _publishers(pairing: Pairing) -> Iterator[Item]:
    for name in pairing.shared:
        mine, theirs = pairing.a.robot.joint_to.get(name), pairing.b.robot.joint_to.get(name)
        if mine is None or theirs is None:
            continue
        old, new = mine.publisher, theirs.publisher
        if (old.kind, old.name, old.simulated) != (new.kind, new.name, new.simulated):
            yield _published(name, old, new)


def _edges(pairing: Pairing) -> Iterator[Item]:
    old, new = _by_name(pairing.a.robot.edges), _by_name(pairing.b.robot.edges)
    yield from either("transform", old, new)
    for name in old:
        if name not in new:
            continue
        one, other = old[name], new[name]
        if _text(one.publisher) != _text(other.publisher):
            yield _published(name, one.publisher, other.publisher)
        if (one.pose, one.moving) != (other.pose, other.moving):
            said = _place(one, other), _place(other, one)
            yield Item(OTHER, name, "origin", f"{name}: {said[0]} -> {said[1]}", *said)


def _by_name(edges: tuple[Edge, ...]) -> dict[str, Edge]:
    return {f"{e.parent} -> {e.child}{f' when {e.when}' if e.when else ''}": e for e in edges}


def _place(edge: Edge, other: Edge) -> str:
    """Return where an edge is in words, with the digits that tell it from another one."""
    motion = "moving" if edge.moving else "static"
    return f"{motion} {text_of(edge.pose, other.pose)}" if edge.pose else f"{motion}, numbers not known"


def _poses(pairing: Pairing) -> Iterator[Item]:
    a, b = pairing.a.robot, pairing.b.robot
    old: dict[str, JointPose] = {pose.name: pose for pose in a.poses}
    new: dict[str, JointPose] = {pose.name: pose for pose in b.poses}
    yield from either("pose", old, new)
    for name in old:
        if name not in new:
            continue
        for joint in a.joints_down():
            # A follower is where its leader puts it.
            if not joint.moves or joint.mimic is not None or joint.name not in b.joint:
                continue
            values = old[name].positions.get(joint.name, 0.0), new[name].positions.get(joint.name, 0.0)
            if differ(pairing.a, pairing.b, joint.name, values, pairing.tolerance, 1.0):
                unit = unit_of(joint, joint.name)
                text = str(number_change(Fact("pose", name, joint.name).about, *values, unit))
                yield Item(OTHER, name, f"pose {joint.name}", text, *values, unit)


def _elements(pairing: Pairing) -> Iterator[Item]:
    a, b = pairing.a.robot, pairing.b.robot
    context = context_of(a, a.asks_for_humble or b.asks_for_humble)
    places = [("the robot", a.urdf_elements, b.urdf_elements)]
    places += [(n, a.link[n].urdf_elements, b.link[n].urdf_elements) for n in a.link if n in b.link]
    places += [(n, a.joint[n].urdf_elements, b.joint[n].urdf_elements) for n in a.joint if n in b.joint]
    for name, mine, theirs in places:
        whole = name == "the robot"
        if mine == theirs and not whole:
            continue
        old, new = said(mine, context), said(theirs, context)
        lost, found = old - new, new - old
        if whole:
            lost, found = lost - _brought(b, context), found - _brought(a, context)
            lost, found = lost | (_always(a, b, context) - new), found | (_always(b, a, context) - old)
        gone, fresh = sorted(map(spelt, lost.elements())), sorted(map(spelt, found.elements()))
        if not gone and not fresh:
            continue
        parts = [
            f"{len(texts)} {word} ({_short(texts[0])})" for texts, word in ((fresh, "new"), (gone, "removed")) if texts
        ]
        text = f"URDF elements of {name}: {', '.join(parts)}"
        yield Item(OTHER, name, "urdf_elements", text, "; ".join(gone) or None, "; ".join(fresh) or None)


def _brought(robot: Robot, context: Context) -> Counter[Key]:
    """Return the elements that outputs of a robot make of what its description says in words."""
    return said([text for texts in _by_output(robot) for text in texts], context)


def _always(robot: Robot, other: Robot, context: Context) -> Counter[Key]:
    """Return the elements that every output of a description brings, where the other robot is a file and has none."""
    made = [] if other.outputs else [said(texts, context) for texts in _by_output(robot)]
    return reduce(lambda one, two: one & two, made) if made else Counter()


def _by_output(robot: Robot) -> list[Sequence[str]]:
    known = [(FORMATS[output.backend], output) for output in robot.outputs if output.backend in FORMATS]
    return [one.brings(robot, output) for one, output in known if one.brings]


def _short(text: str) -> str:
    return f"{text[:_MOST]}..." if len(text) > _MOST else text


Tensor = tuple[Vector, Vector, Vector]
_NONE: Tensor = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
_NAMES = (("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2))
# A body below this (kg) has no mass to speak of.
_NOTHING = 1e-12


class Weight(NamedTuple):
    """A mass (kg), its centre (m), its inertia about that (kg*m^2) along the axes of a frame, and how well known."""

    mass: float
    centre: Vector
    inertia: Tensor
    mass_tolerance: float = 0.0
    centre_tolerance: float = 0.0
    inertia_tolerance: float = 0.0


def compare_masses(pairing: Pairing, clusters: Mapping[str, list[list[str]]]) -> tuple[list[Item], list[str]]:
    """Return what differs in the masses of the links that both robots have, and of bodies as a whole, and notes.

    ``clusters`` are those of the frames of each body of A that B has too.
    """
    items: list[Item] = []
    notes: list[str] = []
    for top, goal in pairing.bodies.items():
        links = [name for name in pairing.a.members[top] if name in pairing.b.robot.link]
        found = {name: list(_link(pairing, name)) for name in links}
        mine, theirs = pairing.a.members[top], pairing.b.members[goal]
        # What hangs on a link that only one robot has, or that is elsewhere, may be another link's there.
        loose = _heavy(pairing.a, [n for n in mine if n not in theirs])
        loose += _heavy(pairing.b, [n for n in theirs if n not in mine])
        changed_links = [name for name in links if found[name]]
        if (loose or len(changed_links) > 1) and clusters.get(top) and _same_body(pairing, top, clusters[top][0][0]):
            if changed_links or loose:
                names = several(sorted({*changed_links, *loose}, key=lambda n: (n not in links, n)))
                notes.append(
                    f"the mass of the body of {top} is shared out otherwise ({names}); as a whole it is the same"
                )
            continue
        for name in links:
            items += found[name]
    done = {name for top in pairing.bodies for name in pairing.a.members[top]}
    for name in pairing.shared:
        if name not in done:
            items += _link(pairing, name)
    return items, notes


def _heavy(bodies: Bodies, names: Sequence[str]) -> list[str]:
    return [name for name in names if bodies.robot.link[name].inertial is not None]


def _link(pairing: Pairing, name: str) -> Iterator[Item]:
    """Yield what differs in the mass of one link, seen in its own frame."""
    old, new = (_known(bodies.robot.link[name].inertial) for bodies in (pairing.a, pairing.b))
    if old is None or new is None:
        if old is not new:
            values = (old.mass if old else None, new.mass if new else None)
            yield changed(MASS, name, "mass", values, "kg")
        return
    yield from _weights(pairing, name, _weight(pairing.a, old, HERE), _weight(pairing.b, new, HERE))


def _known(inertial: Inertial | None) -> Inertial | None:
    """Return an inertial that says something: one of zeros says what none says."""
    i = inertial
    return i if i is not None and any((i.mass, i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz)) else None


def _weights(pairing: Pairing, name: str, one: Weight, other: Weight) -> Iterator[Item]:
    tolerance = pairing.tolerance
    if abs(other.mass - one.mass) > joined(one.mass_tolerance, other.mass_tolerance) + tolerance * max(
        one.mass, other.mass
    ):
        yield changed(MASS, name, "mass", (one.mass, other.mass), "kg")
    step = norm(minus(other.centre, one.centre))
    least = joined(one.centre_tolerance, other.centre_tolerance) + tolerance
    if step > least:
        text = centre_change(name, one.centre, other.centre, least).text
        yield Item(MASS, name, "centre of mass", text, row(one.centre), row(other.centre), "m", step)
    largest = max(abs(v) for tensor in (one.inertia, other.inertia) for line in tensor for v in line)
    allowed = joined(one.inertia_tolerance, other.inertia_tolerance) + tolerance * largest
    old, new = ([tensor[i][j] for _, i, j in _NAMES] for tensor in (one.inertia, other.inertia))
    changed_entries = [abs(b - a) > allowed for a, b in zip(old, new, strict=True)]
    if any(changed_entries):
        text = str(inertia_change(name, old, new, changed_entries))
        yield Item(MASS, name, "inertia", text, row(old), row(new), "kg*m^2")


def _weight(bodies: Bodies, inertial: Inertial, place: Placed) -> Weight:
    """Return the inertial of a link along the axes of the frame that the link is placed in."""
    printing = bodies.printing
    transform = place.transform.then(inertial.pose.transform())
    moments = (inertial.ixx, inertial.iyy, inertial.izz)
    products = (inertial.ixy, inertial.ixz, inertial.iyz)
    keys = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), (*moments, *products), strict=True)
    turn = place.angle + TURNS * printing.tolerance("rpy", *inertial.pose.rpy)
    known = 3 * max(printing.tolerance(key, value) for key, value in keys) + 4 * turn * max(
        map(abs, (*moments, *products))
    )
    length = place.length + place.angle * norm(inertial.pose.xyz)
    length += ROOT_THREE * printing.tolerance("xyz", *inertial.pose.xyz)
    xx, yy, zz = moments
    xy, xz, yz = products
    tensor = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    mass_tolerance = printing.tolerance("mass", inertial.mass)
    return Weight(inertial.mass, transform.xyz, _turned(tensor, transform), mass_tolerance, length, known)


def _turned(tensor: Tensor, transform: Transform) -> Tensor:
    """Return R I R^T."""
    rows = transform.rows

    def entry(i: int, j: int) -> float:
        return math.fsum(rows[i][k] * tensor[k][m] * rows[j][m] for k in range(3) for m in range(3))

    a, b, c, d, e, f = entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)
    return ((a, d, e), (d, b, f), (e, f, c))


def _same_body(pairing: Pairing, top: str, frame: str) -> bool:
    """Say whether a body as a whole has the same mass in both robots, seen from one of its frames."""
    one = _whole(pairing.a, pairing.a.members[top], frame)
    other = _whole(pairing.b, pairing.b.members[pairing.bodies[top]], frame)
    return not list(_weights(pairing, top, one, other))


def _whole(bodies: Bodies, names: Sequence[str], frame: str) -> Weight:
    """Return the mass of several links of a body as one, along the axes of one of its frames."""
    parts = []
    for name in names:
        inertial = bodies.robot.link[name].inertial
        if inertial is not None:
            parts.append(_weight(bodies, inertial, bodies.relative(frame, name, {})))
    mass = math.fsum(part.mass for part in parts)
    if abs(mass) < _NOTHING:
        return Weight(0.0, (0.0, 0.0, 0.0), _NONE)
    x, y, z = (math.fsum(part.mass * part.centre[i] for part in parts) / mass for i in range(3))
    tensor = [[math.fsum(part.inertia[i][j] for part in parts) for j in range(3)] for i in range(3)]
    reach = 0.0
    for part in parts:
        d = minus(part.centre, (x, y, z))
        reach = max(reach, norm(d))
        for i in range(3):
            for j in range(3):
                tensor[i][j] += part.mass * ((norm(d) ** 2 if i == j else 0.0) - d[i] * d[j])
    length = max(part.centre_tolerance for part in parts)
    spread = math.fsum(part.mass_tolerance for part in parts) * reach**2 + 4 * mass * reach * length
    first, second, third = ((line[0], line[1], line[2]) for line in tensor)
    return Weight(
        mass,
        (x, y, z),
        (first, second, third),
        math.fsum(part.mass_tolerance for part in parts),
        length + reach * math.fsum(part.mass_tolerance for part in parts) / abs(mass),
        math.fsum(part.inertia_tolerance for part in parts) + spread,
    )

"""Mass, centre of mass and inertia: of links, and of whole bodies where links share them out otherwise."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import Inertial, Transform, Vector
from rosorin_compile.model.geometry import minus, norm

from .bodies import Bodies
from .difference import MASS, Item
from .joints import changed
from .pairing import Pairing
from .precision import HERE, ROOT_THREE, TURNS, Placed, joined
from .sentences import centre_change, inertia_change, row, several

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
        text = str(inertia_change(name, old, new, allowed))
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

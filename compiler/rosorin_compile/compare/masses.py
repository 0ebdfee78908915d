"""Compare the masses of links, and of bodies as a whole where links share them out otherwise."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from rosorin_compile.model import Inertial
from rosorin_compile.model.mass import together

from .bodies import Bodies
from .describe import Describer
from .difference import MASS, Item, Report
from .pairing import Pairing
from .precision import Precision
from .sentences import row, several
from .walk import Difference, compare_leaves, inertial_leaves


def compare_masses(pairing: Pairing, origins: Mapping[str, str], report: Report) -> None:
    """Report what differs in the masses of the links that both robots have.

    ``origins`` are the frames in which bodies of A are compared as a whole.
    """
    robots = pairing.a.robot, pairing.b.robot
    found = {name: _link(pairing, name) for name in pairing.shared}
    for top, goal in pairing.bodies.items():
        sides = pairing.a.members[top], pairing.b.members[goal]
        differing = {name for name in sides[0] if found.get(name)}
        for robot, names, others in zip(robots, sides, sides[::-1], strict=True):
            differing |= {name for name in names if name not in others and robot.link[name].inertial is not None}
        if len(differing) > 1 or differing - found.keys():
            wholes = [
                _whole(side, names, origins[top]) for side, names in zip((pairing.a, pairing.b), sides, strict=True)
            ]
            if not _differences(top, wholes, pairing.tolerance):
                links = several(sorted(differing, key=lambda name: (name not in found, name)))
                text = f"the mass of the body of {top} is shared out otherwise ({links}); as a whole it is the same"
                report.notes.append(text)
                found |= dict.fromkeys(differing, ())
    for name in pairing.shared:
        report.items.extend(_items(pairing, name, found[name]))


def _link(pairing: Pairing, name: str) -> Sequence[Difference]:
    sides = [(side.robot.link[name].inertial, side.precision) for side in (pairing.a, pairing.b)]
    return _differences(name, sides, pairing.tolerance)


def _differences(
    name: str, sides: Sequence[tuple[Inertial | None, Precision]], tolerance: float
) -> Sequence[Difference]:
    old, new = ({("link", name): inertial_leaves(inertial)} for inertial, _ in sides)
    return compare_leaves(old, new, (sides[0][1], sides[1][1]), tolerance)


def _items(pairing: Pairing, name: str, differences: Sequence[Difference]) -> Iterator[Item]:
    precisions = pairing.a.precision, pairing.b.precision
    describer = Describer(pairing.a.robot, ({}, {}), precisions, pairing.tolerance)
    for one, text in describer.describe(differences):
        quantity, old, new = one.address.quantity, one.old, one.new
        if quantity == "mass":
            yield Item(MASS, name, quantity, text, old, new, "kg")
        elif quantity == "inertia":
            yield Item(MASS, name, quantity, text, row(old), row(new), "kg*m^2")
        else:
            yield Item(MASS, name, quantity, text, row(old), row(new), "m", math.dist(old, new))


def _whole(bodies: Bodies, names: Sequence[str], frame: str) -> tuple[Inertial | None, Precision]:
    """Return the inertial of the links of a body in one of its frames, and how well it is known."""
    links = [(inertial, name) for name in names if (inertial := bodies.robot.link[name].inertial) is not None]
    parts = [(inertial, bodies.relative(frame, name)) for inertial, name in links]
    if not parts or not any(inertial.mass for inertial, _ in parts):
        return None, bodies.precision
    whole = together([(inertial, place.transform) for inertial, place in parts])
    centres = [place.transform.apply(inertial.pose.xyz) for inertial, place in parts]
    reach = max(math.dist(centre, whole.pose.xyz) for centre in centres)
    length = max(place.length + bodies.precision("xyz", *one.pose.xyz) for one, place in parts)
    masses = math.fsum(bodies.precision("mass", one.mass) for one, _ in parts)
    spread = {
        "xyz": length + reach * masses / abs(whole.mass or 1.0),
        "ixx": masses * reach**2 + 4 * abs(whole.mass) * reach * length,
    }

    def precision(key: str, *values: float) -> float:
        return len(parts) * bodies.precision(key, *values) + spread.get(key, 0.0)

    return whole, precision

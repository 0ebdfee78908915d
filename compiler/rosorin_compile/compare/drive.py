"""What differs in what drives two robots."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model.drive import ROLES, Drive

from .difference import OTHER, Item
from .joints import changed, differ
from .pairing import Pairing
from .wording import number


def compare_drive(pairing: Pairing) -> Iterator[Item]:
    """Yield what differs; of two kinds of bases nothing else is compared."""
    a, b = (side.robot.drive for side in (pairing.a, pairing.b))
    if a is None or b is None or a.kind != b.kind:
        before, after = a.kind if a else None, b.kind if b else None
        if before != after:
            text = f"drive {before or 'none'} -> {after or 'none'}"
            yield Item(OTHER, "drive", "kind", text, before, after)
        return
    pairs = [("frame", a.frame or pairing.a.robot.root, b.frame or pairing.b.robot.root)]
    for role in ROLES[a.kind]:
        pairs.append((role, ", ".join(a.joints.get(role, ())), ", ".join(b.joints.get(role, ()))))
    for quantity, before, after in pairs:
        if before != after:
            text = f"drive {quantity.replace('_', ' ')} {before or 'none'} -> {after or 'none'}"
            yield Item(OTHER, "drive", quantity, text, before, after)
    yield from _radii(pairing, a, b)


def _radii(pairing: Pairing, a: Drive, b: Drive) -> Iterator[Item]:
    """Yield what differs in the radius of the wheels, where one of them says it."""
    if a.radius is not None and b.radius is not None:
        if differ(pairing.a, pairing.b, "radius", (a.radius, b.radius), pairing.tolerance):
            yield changed(OTHER, "drive", "radius", (a.radius, b.radius), "m")
    elif a.radius != b.radius:
        said = ["from its shapes" if one is None else f"{number(one)} m" for one in (a.radius, b.radius)]
        yield Item(OTHER, "drive", "radius", f"drive radius {said[0]} -> {said[1]}", said[0], said[1])

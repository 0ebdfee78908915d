"""Joints: type, axis, limits, mimic, dynamics and what else is said of a joint that both robots have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..compare.words import amount
from ..model import Joint
from ..model.geometry import angle_between, dot, minus, norm, unit
from .bodies import Bodies
from .coordinates import Coordinate
from .pairing import Pairing
from .printing import joined
from .values import JOINT, LIMIT, Item
from .wording import changed, number, row

# The parts of a joint that are numbers: attribute of the model, and its fields.
_PARTS: Mapping[str, tuple[str, ...]] = {
    "dynamics": ("damping", "friction", "armature"),
    "actuator": ("kp", "kv"),
    "calibration": ("rising", "falling", "reference_position"),
    "safety": ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"),
}
# What is zero where it is not said.
_ZERO = {"damping", "friction", "armature", "kv"}
_UNITS = {
    "damping": ("N*m*s/rad", "N*s/m"),
    "friction": ("N*m", "N"),
    "armature": ("kg*m^2", "kg"),
    "kp": ("N*m/rad", "N/m"),
    "kv": ("N*m*s/rad", "N*s/m"),
    "effort": ("N*m", "N"),
    "velocity": ("rad/s", "m/s"),
    "k_position": ("1/s", "1/s"),
    "k_velocity": ("N*m*s/rad", "N*s/m"),
}


def unit_of(joint: Joint, quantity: str) -> str:
    """Return the unit of a number of a joint."""
    return _UNITS.get(quantity, ("rad", "m"))[joint.type == "prismatic"]


def axis_item(pairing: Pairing, joint: Joint, twin: Joint, frame: str) -> Item | None:
    """Return how the axis of a joint changed, seen from a frame that it moves; None if it did not.

    Such a frame sees the axis in the same place at every position.
    """
    if not joint.moves or not twin.moves or not norm(joint.axis) or not norm(twin.axis):
        return None
    seen = []
    for bodies, one in ((pairing.a, joint), (pairing.b, twin)):
        place = bodies.relative(frame, one.child, {})
        room = place.angle + 2 * bodies.printing.room("axis", *one.axis) / norm(one.axis)
        seen.append((place.transform.rotate(unit(one.axis)), place.transform.xyz, room, place.length))
    (old, here, first, near), (new, there, second, far) = seen
    turned = angle_between(old, new)
    remark = f"{joint.name} axis {row(joint.axis)} -> {row(twin.axis)}"
    if turned > pairing.tolerance + joined(first, second):
        return Item(JOINT, joint.name, "axis", f"{remark} (turned {amount(turned, 'rad')})", row(old), row(new))
    way = minus(there, here)
    along = dot(way, old)
    across = minus(way, (old[0] * along, old[1] * along, old[2] * along))
    if joint.type != "prismatic" and norm(across) > pairing.tolerance + joined(near, far):
        text = f"{joint.name} axis moved {amount(norm(across), 'm')} in {frame}"
        return Item(JOINT, joint.name, "axis", text, row(here), row(there))
    return None


def compare_joints(pairing: Pairing, coordinates: Mapping[str, Coordinate], unsaid: frozenset[str]) -> Iterator[Item]:
    """Yield what differs in the values of the joints that both robots have; ``unsaid`` is what is not compared."""
    for joint in pairing.a.robot.joints_down():
        twin = pairing.b.robot.joint.get(joint.name)
        if twin is None:
            continue
        if joint.type != twin.type:
            text = f"{joint.name}: {joint.type} -> {twin.type}"
            yield Item(JOINT, joint.name, "type", text, joint.type, twin.type)
        if joint.is_fixed or twin.is_fixed:
            continue
        yield from _limits(pairing, joint, twin, coordinates.get(joint.name), unsaid)
        if "mimic" not in unsaid:
            yield from _mimic(pairing, joint, twin)
        for part, fields in _PARTS.items():
            for quantity in fields:
                if part not in unsaid and quantity not in unsaid:
                    values = _field(joint, part, quantity), _field(twin, part, quantity)
                    yield from _number(pairing, joint, JOINT, quantity, values)


def _field(joint: Joint, part: str, quantity: str) -> float | None:
    """Return a number of a part of a joint; without the part, or without it in the part, what that means."""
    found: float | None = getattr(getattr(joint, part), quantity, None)
    return 0.0 if found is None and quantity in _ZERO else found


def _limits(
    pairing: Pairing, joint: Joint, twin: Joint, coordinate: Coordinate | None, unsaid: frozenset[str]
) -> Iterator[Item]:
    free = "continuous" in (joint.type, twin.type)
    for quantity in ("lower", "upper", "effort", "velocity"):
        follows = quantity in ("lower", "upper") and coordinate is not None and coordinate.same_limits
        if quantity in unsaid or follows or (free and quantity in ("lower", "upper")):
            continue
        values = getattr(joint.limit, quantity, None), getattr(twin.limit, quantity, None)
        yield from _number(pairing, joint, LIMIT, quantity, values)


def _number(
    pairing: Pairing, joint: Joint, kind: str, quantity: str, values: tuple[float | None, float | None]
) -> Iterator[Item]:
    # An angle or a length near zero is known no better than one that is not.
    scale = 0.0 if quantity in _UNITS else 1.0
    if differ(pairing.a, pairing.b, quantity, values, pairing.tolerance, scale):
        name = f"limit {quantity}" if kind == LIMIT else quantity
        yield changed(kind, joint.name, name, values, unit_of(joint, quantity))


def differ(
    a: Bodies, b: Bodies, key: str, values: tuple[float | None, float | None], tolerance: float, scale: float = 0.0
) -> bool:
    """Say whether two numbers that were written under a key differ by more than their digits and the tolerance.

    The tolerance is one part of the larger number, or of ``scale``.
    """
    old, new = values
    if old is None or new is None:
        return old is not new
    room = joined(a.printing.room(key, old), b.printing.room(key, new))
    return abs(new - old) > room + tolerance * max(abs(old), abs(new), scale)


def _mimic(pairing: Pairing, joint: Joint, twin: Joint) -> Iterator[Item]:
    old, new = joint.mimic, twin.mimic
    if old is None or new is None or old.joint != new.joint:
        if old is not new:
            words = [f"{m.joint} * {number(m.multiplier)} + {number(m.offset)}" if m else "nothing" for m in (old, new)]
            yield Item(JOINT, joint.name, "mimic", f"{joint.name} mimics {words[0]} -> {words[1]}", words[0], words[1])
        return
    for quantity in ("multiplier", "offset"):
        values = getattr(old, quantity), getattr(new, quantity)
        if differ(pairing.a, pairing.b, quantity, values, pairing.tolerance, float(quantity == "offset")):
            unit = unit_of(joint, quantity) if quantity == "offset" else ""
            yield changed(JOINT, joint.name, f"mimic {quantity}", values, unit)

"""What differs in the servos of two robots."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model import Robot
from rosorin_compile.model.servos import ServoGroup

from .difference import OTHER, YAML, Item, Side
from .joints import changed, differ
from .pairing import Pairing
from .plainly import either
from .wording import renamed


def compare_servos(pairing: Pairing, sides: tuple[Side, Side]) -> Iterator[Item]:
    """Yield what differs; groups, their names and their ranges between two descriptions alone."""
    ranges = all(side.format is YAML for side in sides)
    old, new = _by_joint(pairing.a.robot), _by_joint(pairing.b.robot)
    if ranges:
        yield from either("servo of", old, new)
    seen = set()
    for joint in old:
        if joint not in new or (old[joint].name, new[joint].name) in seen:
            continue
        one, other = old[joint], new[joint]
        seen.add((one.name, other.name))
        name = f"servo of {joint}"
        if one.name != other.name and ranges:
            yield Item(OTHER, name, "name", renamed("servo group", one.name, other.name).text, one.name, other.name)
        values = _radians(one), _radians(other)
        if differ(pairing.a, pairing.b, "rad_per_pulse", values, pairing.tolerance):
            yield changed(OTHER, name, "rad_per_pulse", values, "rad")
        numbers = [("zero_pulse", one.zero_pulse, other.zero_pulse)]
        if ranges:
            numbers += [("lowest pulse", one.pulse_range[0], other.pulse_range[0])]
            numbers += [("highest pulse", one.pulse_range[1], other.pulse_range[1])]
        for quantity, before, after in numbers:
            if before != after:
                yield changed(OTHER, name, quantity, (before, after), "")


def _by_joint(robot: Robot) -> dict[str, ServoGroup]:
    return {joint: group for group in robot.servos for joint in group.joints}


def _radians(group: ServoGroup) -> float:
    """Return the angle of one pulse, negative where the angle falls as the pulse rises."""
    return -group.rad_per_pulse if group.flipped else group.rad_per_pulse

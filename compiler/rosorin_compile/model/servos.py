"""Servo groups: convert servo pulses to joint positions and back.

position = (pulse - zero_pulse) * rad_per_pulse, negated if the group is flipped. The driver reads the same numbers from
its model (``pulse_to_rad`` of robot_model.json). Positions are in radians, or in metres for a prismatic joint. A
position between two pulses is rounded to the nearer pulse; half-way, it is rounded towards the zero pulse.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral

from rosorin_compile.source.diagnostics import UnknownName

from .joint import Limit
from .link import NO_SOURCE, Source
from .robot import Robot

ROUNDING = 1e-6  # pulses: tolerance, so that a limit computed from a pulse includes that pulse


class NoPulse(ValueError):
    """Raised if a pulse is out of range, or if no pulse results in a position."""


@dataclass(frozen=True)
class ServoGroup:
    """Servos with the same conversion: (pulse - zero_pulse) * rad_per_pulse, negated if ``flipped``."""

    name: str
    joints: tuple[str, ...]
    rad_per_pulse: float
    zero_pulse: int
    flipped: bool
    pulse_range: tuple[int, int]
    source: Source = NO_SOURCE

    def radians(self, pulse: int) -> float:
        return (self.zero_pulse - pulse if self.flipped else pulse - self.zero_pulse) * self.rad_per_pulse

    def exact_pulse(self, position: float) -> float:
        """Return the unrounded pulse for a position (rad or m)."""
        return position / self.rad_per_pulse * (-1 if self.flipped else 1) + self.zero_pulse


def servo_of(robot: Robot, joint: str) -> ServoGroup:
    """Return the servo group of a joint. Raises UnknownName if the joint is unknown or has no servo."""
    for group in robot.servos:
        if joint in group.joints:
            return group
    joints = [name for group in robot.servos for name in group.joints]
    if joint in robot.joint:
        raise UnknownName("servo for joint", joint, none=f"joints with a servo: {', '.join(joints) or 'none'}")
    raise UnknownName("joint", joint, joints or robot.joint)


def to_radians(robot: Robot, pulses: Mapping[str, int]) -> dict[str, float]:
    """Convert pulses by joint name to positions (rad or m) by joint name. Raises UnknownName or NoPulse."""
    return {joint: position_of(servo_of(robot, joint), pulse, joint) for joint, pulse in pulses.items()}


def position_of(group: ServoGroup, pulse: int, joint: str = "") -> float:
    """Return the position (rad or m) of a pulse. Raises NoPulse, naming ``joint``, if the pulse is out of range."""
    low, high = group.pulse_range
    if not isinstance(pulse, Integral) or not low <= pulse <= high:
        raise NoPulse(f"there is no pulse {pulse}{_of(joint)}: pulses are whole numbers from {low} to {high}")
    return group.radians(int(pulse))


def nearest(group: ServoGroup, position: float, joint: str = "") -> tuple[int, float, float]:
    """Return the pulse nearest to a position (rad or m), the position of the pulse, and by how much it is larger.

    Raises NoPulse, naming ``joint``, if the position is out of range.
    """
    (low, high), (first, last), exact = group.pulse_range, travel(group), group.exact_pulse(position)
    if not low - 0.5 <= exact <= high + 0.5:
        span = f"the pulses {low} to {high} give {first:.6g} to {last:.6g}"
        raise NoPulse(f"no pulse gives the position {position:.6g}{_of(joint)}: {span}")
    candidates = {min(max(whole, low), high) for whole in (math.floor(exact), math.ceil(exact))}
    pulse = min(candidates, key=lambda one: (abs(group.radians(one) - position), abs(one - group.zero_pulse)))
    return pulse, group.radians(pulse), group.radians(pulse) - position


def travel(group: ServoGroup) -> tuple[float, float]:
    """Return the (smallest, largest) position (rad or m) within the pulse range."""
    least, most = sorted(map(group.radians, group.pulse_range))
    return least, most


def pulses_within(group: ServoGroup, limit: Limit | None) -> tuple[int, int] | None:
    """Return the (smallest, largest) pulse within the limits of a joint, or None if no pulse is within the limits."""
    low, high = group.pulse_range
    for bound, is_upper in ((limit.lower, False), (limit.upper, True)) if limit is not None else ():
        if bound is None or not math.isfinite(exact := group.exact_pulse(bound)):
            continue
        # The upper limit bounds the largest pulse if positions increase with pulses, else the smallest pulse.
        if is_upper is (group.flipped == (group.rad_per_pulse < 0)):
            high = min(high, math.floor(exact + ROUNDING))
        else:
            low = max(low, math.ceil(exact - ROUNDING))
    return (low, high) if low <= high else None


def _of(joint: str) -> str:
    return f' of joint "{joint}"' if joint else ""

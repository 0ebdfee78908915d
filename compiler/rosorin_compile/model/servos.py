"""Groups of servos, and how their pulses are joint positions."""

from __future__ import annotations

from dataclasses import dataclass

from .link import NO_SOURCE, Source


@dataclass(frozen=True)
class ServoGroup:
    """Servos whose pulses map to joint angles: radians = sign * (pulse - zero_pulse) * rad_per_pulse."""

    name: str
    joints: tuple[str, ...]
    rad_per_pulse: float
    zero_pulse: int
    flipped: bool
    pulse_range: tuple[int, int]
    source: Source = NO_SOURCE

    def radians(self, pulse: int) -> float:
        """Return the joint angle of a pulse; a flipped servo turns against its pulses."""
        difference = self.zero_pulse - pulse if self.flipped else pulse - self.zero_pulse
        return difference * self.rad_per_pulse

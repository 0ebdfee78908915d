"""Limits of joints. Readers of URDF ask for more than MJCF says, and nothing is made up in silence.

A revolute or prismatic joint of a URDF has to have lower, upper, effort and velocity, or no reader takes the file. MJCF
has no limit of speed, and may leave range and force free. What is missing is therefore a declared stand-in, which every
run names, and which is large enough not to be felt in a simulation. To leave it out (``accept: limit-incomplete``)
would be more honest still, but the URDF of such a robot could not be read by anybody.
"""

from __future__ import annotations

from ...tree import Map
from ...wording import listed
from .actuators import Drive
from .numbers import tidy, tidy_position
from .planting import put, put_number, source
from .reading import SLIDE, Reading

STAND_IN_EFFORT = 1000.0  # N*m or N
STAND_IN_VELOCITY = 10.0  # rad/s or m/s
STAND_IN_TRAVEL = 1000.0  # m


def add_limit(reading: Reading, index: int, entry: Map, drive: Drive) -> None:
    """Set the limit of a hinge or slide; a continuous joint has one only if its force is known."""
    joint = reading.facts["joints"][index]
    element = reading.places.of("joints", index)
    limit = Map(element.span)
    missing = []
    if joint["limited"]:
        zero = reading.facts["zero"][joint["address"]]
        cut = tidy if joint["type"] == SLIDE else tidy_position
        for at, key in enumerate(("lower", "upper")):
            put_number(limit, key, cut(joint["range"][at] - zero), element, "range", at)
    elif joint["type"] == SLIDE:
        missing += ["lower", "upper"]
        put_number(limit, "lower", -STAND_IN_TRAVEL, element)
        put_number(limit, "upper", STAND_IN_TRAVEL, element)
    effort = _effort(reading, index, drive)
    if effort is None and not limit:
        return
    missing += ["effort"] if effort is None else []
    put_number(limit, "effort", STAND_IN_EFFORT if effort is None else effort, element, "actuatorfrcrange", 1)
    put_number(limit, "velocity", STAND_IN_VELOCITY, element)
    missing.append("velocity")
    note = f"{listed(missing)} {'is a stand-in' if len(missing) == 1 else 'are stand-ins'}: the MJCF does not limit "
    source(limit, "stand_in", note + ("it" if len(missing) == 1 else "them"))
    put(entry, "limit", limit)


def _effort(reading: Reading, index: int, drive: Drive) -> float | None:
    """Return the largest torque (N*m) or force (N) of a joint: its own limit, else what its actuators can bring."""
    joint = reading.facts["joints"][index]
    if not joint["forced"]:
        return None if drive.effort is None else tidy(drive.effort)
    low, high = joint["force"]
    if low != -high:
        element = reading.places.of("joints", index)
        said = element.attributes.get("actuatorfrcrange")
        message = f"the force of {low:g} to {high:g}, which has one size both ways in a description,"
        reading.lost(message, said.span if said else element.span, "the larger of the two is carried")
    return tidy(max(abs(low), abs(high)))


def tell_of_zeros(reading: Reading) -> None:
    """Say where zero of a joint is another position than in the file."""
    for index, name in reading.joint_of.items():
        joint = reading.facts["joints"][index]
        zero = reading.facts["zero"][joint["address"]]
        if zero:
            element = reading.places.of("joints", index)
            said = element.attributes.get("ref")
            message = f'joint "{name}" stands at {tidy(zero):g} in the MJCF (ref) where it is at 0 here'
            reading.changed(f"{message}: limits and poses are counted from there", said.span if said else element.span)

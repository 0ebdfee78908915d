"""What simulate answers as JSON: the type of its result, of which the schema is made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict

from rosorin_compile.model import Twist


class GivenLimit(TypedDict):
    """A limit, beyond which something fails."""

    value: float
    unit: str


class Stopped(TypedDict):
    """How a trial ended before its time."""

    why: str
    time: Annotated[float, "s"]


class TouchingLinks(TypedDict):
    """Two links that touch."""

    links: Annotated[list[str], "their names"]
    depth: Annotated[float, "how far they are in each other, in metres"]


class FirstTouch(TouchingLinks):
    """The first two links that touch on the way."""

    position: Annotated[float, "where the joint is, in radians or metres"]


class HeldPose(TypedDict):
    """A pose that was held."""

    pose: str
    errors: Annotated[dict[str, float], "the mean error of each joint at the end, in radians or metres"]
    swings: Annotated[dict[str, float], "how far each joint still moves"]
    drift: Annotated[float, "how far the base moved over the floor, in metres"]
    turned: Annotated[float, "how far it turned, in radians"]
    leans: Annotated[float, "how far it leans over, in radians"]
    ripple: Annotated[float, "how much its height changes at the end, in metres"]
    touches: list[TouchingLinks]
    stands_on: Annotated[list[str], "the links that touch the floor"]
    broken: Stopped | None


class DrivenCommand(TypedDict):
    """A command that was driven."""

    command: str
    asked: Twist
    measured: Twist
    off: Annotated[float | None, "how far the measured velocity is from the command, as a share of it"]
    cross: Annotated[float | None, "the largest part of the velocity that nobody asked for, in m/s or rad/s"]
    ripple: Annotated[float, "how much the height changes, in metres"]
    scale: Annotated[float, "what the limits of the wheels left of the command"]
    broken: Stopped | None


class RangeEnd(TypedDict):
    """An end of the range of a joint."""

    asked: Annotated[float, "the position that was asked for, in radians or metres"]
    error: Annotated[float, "how far it is from there"]
    touches: list[TouchingLinks]
    first_touch: Annotated[FirstTouch | None, "what touched first on the way"]


class SweptJoint(TypedDict):
    """A joint that was led through its range, first to the lower end."""

    joint: str
    ends: list[RangeEnd]
    broken: Stopped | None


class KeptEnergy(TypedDict):
    """The energy without damping, friction, actuators and contacts."""

    change: Annotated[float, "the change, as a share of the largest kinetic energy"]
    kinetic: Annotated[float, "the largest kinetic energy, in joules"]
    broken: Stopped | None


class Timing(TypedDict):
    """How fast it was."""

    steps_per_cpu_second: float
    times_real_time: float


class _SimulatedMore(TypedDict, total=False):
    energy: KeptEnergy
    timing: Annotated[Timing, "without `--no-timing`"]


class Simulated(_SimulatedMore):
    """How a robot behaves in MuJoCo."""

    robot: str
    mujoco: Annotated[str, "the version of MuJoCo"]
    base: str
    timestep: Annotated[float, "s"]
    limits: dict[str, GivenLimit]
    poses: list[HeldPose]
    drive: list[DrivenCommand]
    own_servos: Annotated[list[str], "wheels without an actuator on their speed, which were turned all the same"]
    ranges: list[SweptJoint]


ANSWERS: dict[str, Any] = {"simulate": Simulated}

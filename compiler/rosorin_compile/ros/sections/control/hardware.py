"""Control: the hardware of ros2_control, as ``<ros2_control>`` of a URDF has it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from rosorin_compile.model.link import NO_SOURCE, Source

from ...ports import facts

SYSTEM, ACTUATOR, SENSOR = "system", "actuator", "sensor"

POSITION, VELOCITY, EFFORT, ACCELERATION = "position", "velocity", "effort", "acceleration"
# hardware_interface/types/hardware_interface_type_values.hpp of ros-controls/ros2_control@jazzy.
JOINT_WORDS = (POSITION, VELOCITY, ACCELERATION, EFFORT)

Words = Mapping[str, str | float | bool]


def sensor_words(kind: str) -> tuple[str, ...]:
    """Return the state interfaces of a type of sensors; empty for an unknown one."""
    return tuple(facts("ros2_ports")["sensor_interfaces"].get(kind, ()))


@dataclass(frozen=True)
class Interface:
    """An interface of a joint, a sensor or gpio; ``min``, ``max``, ``initial`` are None if they are not set."""

    name: str
    min: float | None = None
    max: float | None = None
    initial: float | None = None
    data_type: str = ""
    size: int | None = None
    params: Words = field(default_factory=dict)


@dataclass(frozen=True)
class Component:
    """A joint, a sensor or gpio of a block: its commands and states.

    ``limits``: True writes the limits of the joint with its commands, False none; "urdf" leaves them to the URDF.
    ``mimic``: whether it follows its leader; None means as the joint does.
    """

    name: str
    command: tuple[Interface, ...] = ()
    state: tuple[Interface, ...] = ()
    params: Words = field(default_factory=dict)
    limits: bool | str = True
    mimic: bool | None = None

    @property
    def commands(self) -> tuple[str, ...]:
        """The names of its commands."""
        return tuple(one.name for one in self.command)

    @property
    def states(self) -> tuple[str, ...]:
        """The names of its states."""
        return tuple(one.name for one in self.state)


@dataclass(frozen=True)
class End:
    """A joint or an actuator of a transmission; ``reduction`` and ``offset`` (rad or m) None where not given."""

    name: str
    role: str = ""
    reduction: float | None = None
    offset: float | None = None


@dataclass(frozen=True)
class Transmission:
    """How actuators move joints."""

    name: str
    plugin: str
    joints: tuple[End, ...] = ()
    actuators: tuple[End, ...] = ()


@dataclass(frozen=True)
class Block:
    """A hardware block: ``pose`` is the name of the one that its joints start in, ``rate`` (Hz) how often it is read.

    ``group``, ``rate``, ``is_async`` and ``thread_priority`` are words that Humble does not know.
    """

    name: str
    type: str
    plugin: str
    params: Words = field(default_factory=dict)
    joints: tuple[Component, ...] = ()
    sensors: tuple[Component, ...] = ()
    gpio: tuple[Component, ...] = ()
    transmissions: tuple[Transmission, ...] = ()
    pose: str = ""
    group: str = ""
    rate: int | None = None
    is_async: bool | None = None
    thread_priority: int | None = None
    source: Source = NO_SOURCE

    def components(self) -> Iterator[tuple[str, Component]]:
        """Yield the joints, sensors and gpio, each with its section."""
        for section, found in (("joints", self.joints), ("sensors", self.sensors), ("gpio", self.gpio)):
            yield from ((section, one) for one in found)

"""Hardware blocks in a URDF: ``<ros2_control>``, as the parser of ros2_control takes it, Humble's or Jazzy's.

Rules and words of both: ``ros-controls/ros2_control@{humble,jazzy}:hardware_interface/src/component_parser.cpp``,
``resource_manager.cpp`` and ``mock_components/generic_system.cpp``. ``control_rules`` has what is checked before.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

from markupsafe import escape

from rosorin_compile.formats.format import HUMBLE, described_by
from rosorin_compile.formats.templating import attributes
from rosorin_compile.model import Joint, Output, Robot
from rosorin_compile.ros.sections.control.hardware import POSITION, Block, Component, End, Interface, Words
from rosorin_compile.source.numbers import NumberFormat

OPTION = "control"


def asked(output: Output) -> str:
    """Return the distribution that an output has hardware blocks for, humble or jazzy; empty for none."""
    said = output.options.get(OPTION)
    return described_by(str(said)) if said else ""


def blocks(robot: Robot, output: Output, number: NumberFormat) -> list[str]:
    """Return the hardware blocks of an output as elements of a URDF."""
    distribution = asked(output)
    if not distribution:
        return []
    writer = _Writer(robot, distribution == HUMBLE, number)
    return ["\n".join(_lines(writer.block(block), "  ")) for block in robot.control]


def follows(joint: Joint | None, component: Component) -> bool:
    """Say whether a joint of a block follows its leader in the hardware."""
    return joint is not None and joint.mimic is not None and component.mimic is not False


class _Tag(NamedTuple):
    """An element: its name, its attributes, and its text or the elements in it."""

    name: str
    values: Mapping[str, str]
    content: str | tuple[_Tag, ...] = ()


def _lines(tag: _Tag, indent: str) -> Iterator[str]:
    start = f"{indent}<{tag.name}{attributes(**tag.values)}"
    if isinstance(tag.content, str):
        yield f"{start}>{escape(tag.content)}</{tag.name}>"
    elif not tag.content:
        yield f"{start}/>"
    else:
        yield f"{start}>"
        for inner in tag.content:
            yield from _lines(inner, indent + "  ")
        yield f"{indent}</{tag.name}>"


class _Writer:
    """Makes elements of blocks, for Humble or for what came after."""

    def __init__(self, robot: Robot, humble: bool, number: NumberFormat) -> None:
        self.robot = robot
        self.humble = humble
        self.number = number

    def block(self, block: Block) -> _Tag:
        values = {"name": block.name, "type": block.type}
        group: tuple[_Tag, ...] = ()
        if not self.humble:
            more = {"rw_rate": block.rate, "is_async": block.is_async, "thread_priority": block.thread_priority}
            values |= {key: self._word(value) for key, value in more.items() if value is not None}
            group = (_Tag("group", {}, block.group),) if block.group else ()
        hardware = _Tag("hardware", {}, (_Tag("plugin", {}, block.plugin), *group, *self._params(block.params)))
        joints = (self._joint(block, one) for one in block.joints)
        sensors = (_Tag("sensor", {"name": one.name}, self._inner(one)) for one in block.sensors)
        gpio = (_Tag("gpio", {"name": one.name}, self._inner(one)) for one in block.gpio)
        return _Tag("ros2_control", values, (hardware, *joints, *sensors, *gpio, *self._transmissions(block)))

    def _joint(self, block: Block, one: Component) -> _Tag:
        joint = self.robot.joint[one.name]
        values, first = {"name": one.name}, []
        if not self.humble:
            if joint.mimic is not None:
                values["mimic"] = self._word(follows(joint, one))
            if not one.limits:
                first.append(_Tag("limits", {"enable": "false"}))
        elif follows(joint, one) and joint.mimic is not None:
            first = self._params({"mimic": joint.mimic.joint, "multiplier": joint.mimic.multiplier})
        command = tuple(self._limited(joint, interface, one.limits is True) for interface in one.command)
        state = tuple(self._started(block, joint, interface) for interface in one.state)
        made = Component(one.name, command, state, one.params)
        return _Tag("joint", values, (*first, *self._inner(made)))

    @staticmethod
    def _limited(joint: Joint, interface: Interface, limits: bool) -> Interface:
        low, high = joint.limits_of(interface.name) if limits else (None, None)
        low, high = (own if own is not None else of for own, of in ((interface.low, low), (interface.high, high)))
        return replace(interface, low=low, high=high)

    def _started(self, block: Block, joint: Joint, interface: Interface) -> Interface:
        if interface.name != POSITION or interface.initial is not None or not block.pose:
            return interface
        return replace(interface, initial=self.robot.position(joint, self.robot.positions(block.pose)))

    def _inner(self, one: Component) -> tuple[_Tag, ...]:
        command = (self._interface("command_interface", interface) for interface in one.command)
        state = (self._interface("state_interface", interface) for interface in one.state)
        return (*command, *state, *self._params(one.params))

    def _interface(self, tag: str, interface: Interface) -> _Tag:
        values = {"name": interface.name}
        if interface.data_type:
            values["data_type"] = interface.data_type
        if interface.size is not None:
            values["size"] = str(interface.size)
        numbers = {"min": interface.low, "max": interface.high, "initial_value": interface.initial}
        given = {key: value for key, value in numbers.items() if value is not None}
        return _Tag(tag, values, tuple(self._params({**given, **interface.params})))

    def _transmissions(self, block: Block) -> Iterator[_Tag]:
        for one in block.transmissions:
            ends = (("actuator", end) for end in one.actuators), (("joint", end) for end in one.joints)
            inner = (self._end(tag, end) for group in ends for tag, end in group)
            yield _Tag("transmission", {"name": one.name}, (_Tag("plugin", {}, one.plugin), *inner))

    def _end(self, tag: str, end: End) -> _Tag:
        values = {"name": end.name, **({"role": end.role} if end.role else {})}
        numbers = {"mechanical_reduction": end.reduction, "offset": end.offset}
        given = ((key, value) for key, value in numbers.items() if value is not None)
        return _Tag(tag, values, tuple(_Tag(key, {}, self.number(value)) for key, value in given))

    def _params(self, params: Words) -> list[_Tag]:
        return [_Tag("param", {"name": name}, self._word(value)) for name, value in params.items()]

    def _word(self, value: object) -> str:
        if isinstance(value, bool):
            return "true" if value else "false"
        return self.number(value) if isinstance(value, float) else str(value)

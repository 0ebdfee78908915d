"""Hardware blocks in a URDF: ``<ros2_control>``, as the parser of ros2_control takes it, Humble's or Jazzy's.

Rules and words of both: ``ros-controls/ros2_control@{humble,jazzy}:hardware_interface/src/component_parser.cpp``,
``resource_manager.cpp`` and ``mock_components/generic_system.cpp``. ``control_rules`` has what is checked before.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from markupsafe import escape

from rosorin_compile.formats.format import HUMBLE, described_by
from rosorin_compile.formats.templating import attributes
from rosorin_compile.model import Joint, Output, Robot
from rosorin_compile.ros.sections.control.hardware import POSITION, Block, Component, End, Words
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
    return ["\n".join(f"  {line}" for line in writer.block(block)) for block in robot.control]


def follows(joint: Joint | None, component: Component) -> bool:
    """Say whether a joint of a block follows its leader in the hardware."""
    return joint is not None and joint.mimic is not None and component.mimic is not False


Lines = list[str]


def _tag(name: str, values: Mapping[str, str], content: str | Lines = "") -> Lines:
    """Return the lines of an element with attributes and a text, or the lines of the elements in it."""
    start = f"<{name}{attributes(**values)}"
    if isinstance(content, str):
        return [f"{start}>{escape(content)}</{name}>" if content else f"{start}/>"]
    return [f"{start}>", *(f"  {line}" for line in content), f"</{name}>"] if content else [f"{start}/>"]


class _Writer:
    """Makes elements of blocks, for Humble or for what came after."""

    def __init__(self, robot: Robot, humble: bool, number: NumberFormat) -> None:
        self.robot = robot
        self.humble = humble
        self.number = number

    def block(self, block: Block) -> Lines:
        values = {"name": block.name, "type": block.type}
        hardware = _tag("plugin", {}, block.plugin)
        if not self.humble:
            more = {"rw_rate": block.rate, "is_async": block.is_async, "thread_priority": block.thread_priority}
            values |= {key: self._word(value) for key, value in more.items() if value is not None}
            hardware += _tag("group", {}, block.group) if block.group else []
        inside = _tag("hardware", {}, hardware + self._params(block.params))
        for one in block.joints:
            inside += self._joint(block, one)
        for tag, components in (("sensor", block.sensors), ("gpio", block.gpio)):
            for one in components:
                inside += _tag(tag, {"name": one.name}, self._inner(one))
        for transmission in block.transmissions:
            inner = _tag("plugin", {}, transmission.plugin)
            for tag, ends in (("actuator", transmission.actuators), ("joint", transmission.joints)):
                for end in ends:
                    inner += self._end(tag, end)
            inside += _tag("transmission", {"name": transmission.name}, inner)
        return _tag("ros2_control", values, inside)

    def _joint(self, block: Block, one: Component) -> Lines:
        joint, values, first = self.robot.joint[one.name], {"name": one.name}, Lines()
        if not self.humble:
            values |= {"mimic": self._word(follows(joint, one))} if joint.mimic is not None else {}
            first += [] if one.limits else _tag("limits", {"enable": "false"})
        elif follows(joint, one) and joint.mimic is not None:
            first += self._params({"mimic": joint.mimic.joint, "multiplier": joint.mimic.multiplier})
        command, state = [], []
        for interface in one.command:  # with the limits of the joint, where it has none of its own
            low, high = joint.limits_of(interface.name) if one.limits is True else (None, None)
            low = interface.min if interface.min is not None else low
            high = interface.max if interface.max is not None else high
            command.append(replace(interface, min=low, max=high))
        for interface in one.state:  # at the value that the pose of the block has for the joint
            starts = interface.name == POSITION and interface.initial is None and block.pose
            initial = self.robot.position(joint, self.robot.positions(block.pose)) if starts else interface.initial
            state.append(replace(interface, initial=initial))
        made = Component(one.name, tuple(command), tuple(state), one.params)
        return _tag("joint", values, first + self._inner(made))

    def _inner(self, one: Component) -> Lines:
        lines = Lines()
        for tag, interfaces in (("command_interface", one.command), ("state_interface", one.state)):
            for interface in interfaces:
                values = {"name": interface.name}
                values |= {"data_type": interface.data_type} if interface.data_type else {}
                values |= {"size": str(interface.size)} if interface.size is not None else {}
                numbers = {"min": interface.min, "max": interface.max, "initial_value": interface.initial}
                given = {key: value for key, value in numbers.items() if value is not None}
                lines += _tag(tag, values, self._params({**given, **interface.params}))
        return lines + self._params(one.params)

    def _end(self, tag: str, end: End) -> Lines:
        values = {"name": end.name, **({"role": end.role} if end.role else {})}
        numbers = {"mechanical_reduction": end.reduction, "offset": end.offset}
        lines = [
            line for key, value in numbers.items() if value is not None for line in _tag(key, {}, self.number(value))
        ]
        return _tag(tag, values, lines)

    def _params(self, params: Words) -> Lines:
        return [line for name, value in params.items() for line in _tag("param", {"name": name}, self._word(value))]

    def _word(self, value: object) -> str:
        if isinstance(value, bool):
            return "true" if value else "false"
        return self.number(value) if isinstance(value, float) else str(value)

"""Hardware blocks in a URDF: ``<ros2_control>``, as the parser of ros2_control takes it, Humble's or Jazzy's.

Rules and words of both: ``ros-controls/ros2_control@{humble,jazzy}:hardware_interface/src/component_parser.cpp``,
``resource_manager.cpp`` and ``mock_components/generic_system.cpp``. ``control_rules`` has what is checked before.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rosorin_compile.formats.format import HUMBLE, described_by
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Joint, Output, Robot
from rosorin_compile.source.numbers import NumberFormat

from .hardware import POSITION, Block, Component

OPTION = "control"


def hardware_distro(output: Output) -> str:
    """Return the distribution that an output has hardware blocks for, humble or jazzy; empty for none."""
    said = output.options.get(OPTION)
    return described_by(str(said)) if said else ""


def blocks(robot: Robot, output: Output, number: NumberFormat) -> list[str]:
    """Return the hardware blocks of an output as elements of a URDF."""
    distribution = hardware_distro(output)
    if not distribution:
        return []

    def word(value: object) -> str:
        if isinstance(value, bool):
            return "true" if value else "false"
        return number(value) if isinstance(value, float) else str(value)

    values = {"word": word, "given": _given, "humble": distribution == HUMBLE}
    return [
        Templates.own("ros/ros2_control.xml.jinja", values | _values(robot, block, distribution == HUMBLE)).rstrip("\n")
        for block in robot.control
    ]


def _given(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}


def _values(robot: Robot, block: Block, humble: bool) -> dict[str, Any]:
    """Return the values of the template: the block, its joints with their limits and positions, and their mimic."""
    attributes = {"rw_rate": block.rate, "is_async": block.is_async, "thread_priority": block.thread_priority}
    mimics = {}
    for one in block.joints:
        joint = robot.joint[one.name]
        written: dict[str, dict[str, Any]] = {"attributes": {}, "params": {}}
        if not humble and joint.mimic is not None:
            written["attributes"] = {"mimic": follows(joint, one)}
        elif humble and joint.mimic is not None and follows(joint, one):
            written["params"] = {"mimic": joint.mimic.joint, "multiplier": joint.mimic.multiplier}
        mimics[one.name] = written
    joints = [_joint(robot, block, one) for one in block.joints]
    return {"block": block, "joints": joints, "mimics": mimics, "attributes": {} if humble else _given(attributes)}


def _joint(robot: Robot, block: Block, one: Component) -> Component:
    """Return a joint with the limits of its commands and with the positions of the pose of its block."""
    joint, command, state = robot.joint[one.name], [], []
    for interface in one.command:
        low, high = joint.limits_of(interface.name) if one.limits is True else (None, None)
        low = interface.min if interface.min is not None else low
        high = interface.max if interface.max is not None else high
        command.append(replace(interface, min=low, max=high))
    for interface in one.state:
        starts = interface.name == POSITION and interface.initial is None and block.pose
        initial = robot.position(joint, robot.positions(block.pose)) if starts else interface.initial
        state.append(replace(interface, initial=initial))
    return replace(one, command=tuple(command), state=tuple(state))


def follows(joint: Joint | None, component: Component) -> bool:
    """Return True if a joint of a block follows its leader in the hardware."""
    return joint is not None and joint.mimic is not None and component.mimic is not False

"""The section ``control``: hardware blocks of ros2_control."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from rosorin_compile.language.lower import Problem, entries_of, record_of
from rosorin_compile.model.sections import Section
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic, first_of
from rosorin_compile.source.rule_registry import Heading, rule
from rosorin_compile.source.tree import Path

from .hardware import SYSTEM, Block, Component, Interface, blocks, check_control, sensor_words


def control_of(tree: Mapping[str, Any], _: Problem) -> tuple[Block, ...]:
    """Parse the section ``control``; a sensor without interfaces gets the interfaces of its type."""
    types = {name: entry.get("type", "") for name, entry in (tree.get("sensors") or {}).items()}

    def complete(sensor: Component, entry: Mapping[str, Any] | None) -> Component:
        words = sensor_words(types.get(sensor.name, ""))
        return sensor if "state" in (entry or {}) else replace(sensor, state=tuple(map(Interface, words)))

    made = []
    for name, entry in entries_of(tree, "control"):
        block = record_of(Block, entry, name=name, type=entry.get("type", SYSTEM), is_async=entry.get("async"))
        sensors = tuple(complete(sensor, entry["sensors"][sensor.name]) for sensor in block.sensors)
        made.append(replace(block, sensors=sensors))
    return tuple(made)


@rule("control-unused", "A note: no output has the hardware blocks.", "`control: jazzy` in the URDF.", Heading.CONTROL)
def control_unused(case: Case) -> Iterator[Diagnostic]:
    """Report hardware blocks that no output requests with its option ``control``."""
    blocks = case.robot.control
    if blocks and not any(output.options.get("control") for output in case.robot.outputs):
        message = f"no output contains the hardware blocks ({first_of([one.name for one in blocks], 3)})"
        yield case.problem("control-unused", message, ("control",), 'add "control: jazzy" to a URDF output', key=True)


@rule("control-pose", "A hardware block starts in a pose that does not exist.", "Name one of `poses`.", Heading.CONTROL)
@rule(
    "control-transmission",
    "A transmission moves a joint that its block does not have, or has no joint or no actuator.",
    "Name a joint of the same block.",
    Heading.CONTROL,
)
def control_names(case: Case) -> Iterator[Diagnostic]:
    """Report unknown poses and unknown joints of transmissions in hardware blocks."""
    poses = [pose.name for pose in case.robot.poses]
    for block in case.robot.control:
        called, own = f'hardware block "{block.name}"', [one.name for one in block.joints]
        if block.pose and block.pose not in poses:
            path: Path = ("control", block.name, "pose")
            message = f'{called} starts in pose "{block.pose}", which does not exist'
            help = case.suggest(path, block.pose, poses, none="the description has no poses")
            yield case.problem("control-pose", message, path, help)
        for one in block.transmissions:
            path = ("control", block.name, "transmissions", one.name)
            for key in [key for key in ("joints", "actuators") if not getattr(one, key)]:
                message = f'transmission "{one.name}" of {called} has no {key}'
                yield case.problem("control-transmission", message, (*path, key), "add at least one", key=True)
            for end in [end for end in one.joints if end.name not in own]:
                message = f'transmission "{one.name}" moves joint "{end.name}", which {called} does not have'
                help = case.suggest(path, end.name, own, "use a joint of the same block")
                yield case.problem("control-transmission", message, (*path, "joints", end.name), help, key=True)


SECTION: Section[tuple[Block, ...]] = Section(
    "control", lower=control_of, checks=(control_unused, control_names), urdf=blocks, check_urdf=check_control
)

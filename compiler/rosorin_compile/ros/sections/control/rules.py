"""Hardware blocks that go nowhere, and the poses and joints that they name, whether an output has them or not."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.language.misnamed import name_meant
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Heading, first_of
from rosorin_compile.source.rule_registry import rule
from rosorin_compile.source.tree import Path

from . import CONTROL

AFTER = "outputs"


@rule(
    "control-unused",
    "A note: no output asks for the hardware blocks of the description.",
    "`outputs: {urdf: {file: ..., control: jazzy}}`.",
    Heading.CONTROL,
)
def unused(case: Case) -> Iterator[Diagnostic]:
    """Find hardware blocks that go nowhere: an output asks for them by an option that is called as the section."""
    blocks = case.robot.sections[CONTROL]
    if blocks and not any(output.options.get(CONTROL.name) for output in case.robot.outputs):
        message = f"no output asks for the hardware blocks ({first_of([one.name for one in blocks], 3)})"
        help = "in a URDF: control: humble, or jazzy"
        yield case.problem("control-unused", message, ("control",), help, severity=NOTE, key=True)


@rule(
    "control-pose",
    "A hardware block starts in a pose that the robot does not have.",
    "Name one of `poses`.",
    Heading.CONTROL,
)
@rule(
    "control-transmission",
    "A transmission moves a joint that its block does not have, or has no joint or no actuator.",
    "Name a joint of the same block.",
    Heading.CONTROL,
)
def names(case: Case) -> Iterator[Diagnostic]:
    """Find poses, and joints of transmissions, that a hardware block names and that are not there."""
    poses = [pose.name for pose in case.robot.poses]
    for block in case.robot.sections[CONTROL]:
        called, own = f'hardware block "{block.name}"', [one.name for one in block.joints]
        if block.pose and block.pose not in poses:
            path: Path = ("control", block.name, "pose")
            message = f'{called} starts in pose "{block.pose}", which there is not'
            help = name_meant(case.tree, path, block.pose, poses) or "the description has no poses"
            yield case.problem("control-pose", message, path, help)
        for one in block.transmissions:
            path = ("control", block.name, "transmissions", one.name)
            for key, ends in (("joints", one.joints), ("actuators", one.actuators)):
                if not ends:
                    message = f'transmission "{one.name}" of {called} has no {key}'
                    yield case.problem("control-transmission", message, (*path, key), "it has one at least", key=True)
            for end in one.joints:
                if end.name not in own:
                    message = f'transmission "{one.name}" moves joint "{end.name}", which {called} does not have'
                    help = case.suggest(path, end.name, own, "name a joint of the same block")
                    yield case.problem("control-transmission", message, (*path, "joints", end.name), help, key=True)

"""Names in the sections for hardware and controllers, whether an output has them or not.

Names of links and joints there are told beside those of all other sections (``kinematics``).
"""

from __future__ import annotations

from collections.abc import Iterator

from ..diagnostics import Diagnostic
from ..diagnostics.registry import CONTROL, Check, rule
from ..frontend.misnamed import name_meant
from ..frontend.tree import Path
from .case import Case

AFTER = "outputs"


@rule(
    "control-pose",
    "A hardware block starts in a pose that the robot does not have.",
    "Name one of `poses`.",
    CONTROL,
)
@rule(
    "control-transmission",
    "A transmission moves a joint that its block does not have, or has no joint or no actuator.",
    "Name a joint of the same block.",
    CONTROL,
)
def hardware(case: Case) -> Iterator[Diagnostic]:
    """Find poses, and joints of transmissions, that a hardware block names and that are not there."""
    poses = [pose.name for pose in case.robot.poses]
    for block in case.robot.control:
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


@Check
def controllers(case: Case) -> Iterator[Diagnostic]:
    """Find hardware blocks and sensors that a controller names and that are not there (controller-name)."""
    blocks, sensors = [block.name for block in case.robot.control], [sensor.name for sensor in case.robot.sensors]
    for one in case.robot.controllers:
        for key, name, word, names in (
            ("hardware", one.hardware, "hardware block", blocks),
            ("sensor", one.sensor, "sensor", sensors),
        ):
            if name and name not in names:
                path: Path = ("controllers", one.name, key)
                message = f'the controller "{one.name}" names the {word} "{name}", which there is not'
                help = name_meant(case.tree, path, name, names) if names else f"the robot has no {word}"
                yield case.problem("controller-name", message, path, help)

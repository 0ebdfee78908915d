"""Names in the section for controllers, whether an output has them or not.

Names of links and joints there are told beside those of all other sections (``kinematics``).
"""

from __future__ import annotations

from collections.abc import Iterator

from ..diagnostics import Diagnostic
from ..diagnostics.registry import Check
from ..frontend.misnamed import name_meant
from ..frontend.tree import Path
from ..sections.control import CONTROL
from .case import Case

AFTER = "outputs"


@Check
def controllers(case: Case) -> Iterator[Diagnostic]:
    """Find hardware blocks and sensors that a controller names and that are not there (controller-name)."""
    blocks, sensors = (
        [block.name for block in case.robot.sections[CONTROL]],
        [sensor.name for sensor in case.robot.sensors],
    )
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

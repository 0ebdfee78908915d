"""Names that controllers say, whether an output has them or not.

Names of links and joints there are told beside those of all other sections (``kinematics``).
"""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.language.annotations import named_as
from rosorin_compile.language.misnamed import name_meant
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import Check
from rosorin_compile.source.tree import Path

from . import CONTROLLERS

AFTER = "outputs"


@Check
def names(case: Case) -> Iterator[Diagnostic]:
    """Find hardware blocks and sensors that a controller names and that are not there (controller-name)."""
    blocks = [name for section in named_as("hardware block") for name in case.tree.get(section) or ()]
    sensors = [sensor.name for sensor in case.robot.sensors]
    for one in case.robot.sections[CONTROLLERS]:
        for key, name, word, known in (
            ("hardware", one.hardware, "hardware block", blocks),
            ("sensor", one.sensor, "sensor", sensors),
        ):
            if name and name not in known:
                path: Path = ("controllers", one.name, key)
                message = f'the controller "{one.name}" names the {word} "{name}", which there is not'
                help = name_meant(case.tree, path, name, known) if known else f"the robot has no {word}"
                yield case.problem("controller-name", message, path, help)

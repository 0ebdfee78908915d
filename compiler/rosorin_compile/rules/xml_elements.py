"""Elements of XML that a description carries for the URDF: each text is elements, whole and well formed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..diagnostics import Diagnostic
from ..diagnostics.registry import NUMBERS, rule
from ..frontend.tree import Path
from ..xml.elements import damage
from .case import Case

AFTER = "materials"


@rule(
    "bad-xml",
    "A text of `urdf_elements` is not whole elements of XML.",
    "Correct it as the message says.",
    NUMBERS,
)
def well_formed(case: Case) -> Iterator[Diagnostic]:
    """Texts that would make the URDF unreadable, or would end the element that they stand in."""
    for path, texts in _texts(case):
        for index, text in enumerate(texts):
            wrong = damage(text)
            if wrong:
                help = "write whole elements, such as <gazebo>...</gazebo>"
                message = f"this is no element of XML: {wrong}"
                yield case.problem("bad-xml", message, (*path, "urdf_elements", index), help)


def _texts(case: Case) -> Iterator[tuple[Path, Sequence[str]]]:
    """Yield the texts of each entry that has any, with its path."""
    robot = case.robot
    yield (), robot.urdf_elements
    for link in robot.links:
        yield case.link(link.name), link.urdf_elements
        for purpose in ("visual", "collision"):
            for index, shape in enumerate(getattr(link, purpose)):
                yield case.link(link.name, purpose, index), shape.urdf_elements
    for joint in robot.joints:
        yield case.joint(joint), joint.urdf_elements

"""The section ``servos``: groups of servos and their calibration."""

from ...model.sections import OwnSection
from .value import ServoGroup

SERVOS: OwnSection[tuple[ServoGroup, ...]] = OwnSection.in_folder(
    __name__,
    __path__[0],
    (),
    after="urdf_elements",
    lowers="lowering:servos_of",
    compares="comparison:compare",
    rules="rules",
)

"""The section ``servos``: groups of servos and their calibration."""

from rosorin_compile.model.sections import OwnSection
from rosorin_compile.model.servos import ServoGroup

SERVOS: OwnSection[tuple[ServoGroup, ...]] = OwnSection.in_folder(
    __name__,
    __path__[0],
    (),
    after="urdf_elements",
    lowers="lowering:servos_of",
    compares="comparison:compare",
    rules="rules",
)

"""The section ``drive``: what kind of base a robot has, and which joints are its wheels.

``value`` is what is said, ``driving`` the kinematics that follows: what the wheels turn at for a velocity of the base.
"""

from rosorin_compile.model.drive import Drive
from rosorin_compile.model.sections import OwnSection

DRIVE: OwnSection[Drive | None] = OwnSection.in_folder(
    __name__,
    __path__[0],
    None,
    after="poses",
    lowers="lowering:drive_of",
    compares="comparison:compare",
    rules="rules",
)

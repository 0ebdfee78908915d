"""The section ``moveit``: what MoveIt has to know of a robot beside its URDF."""

from rosorin_compile.model.moveit import Moveit
from rosorin_compile.model.sections import OwnSection

MOVEIT: OwnSection[Moveit | None] = OwnSection.in_folder(
    __name__,
    __path__[0],
    None,
    after="controllers",
    lowers="lowering:moveit_of",
    compares="comparison:compare",
    rules="rules",
)

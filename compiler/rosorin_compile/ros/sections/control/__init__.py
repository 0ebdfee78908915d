"""The section ``control``: the hardware of ros2_control."""

from rosorin_compile.model.control import Block
from rosorin_compile.model.sections import OwnSection

CONTROL: OwnSection[tuple[Block, ...]] = OwnSection.in_folder(
    __name__,
    __path__[0],
    (),
    after="drive",
    lowers="lowering:control_of",
    rules="rules",
    in_urdf="urdf:blocks",
    checks_urdf="urdf_rules:check_control",
)

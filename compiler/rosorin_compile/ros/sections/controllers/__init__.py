"""The section ``controllers``: the controllers of ros2_control, which drive its hardware."""

from rosorin_compile.model.controllers import Controller
from rosorin_compile.model.sections import OwnSection

CONTROLLERS: OwnSection[tuple[Controller, ...]] = OwnSection.in_folder(
    __name__, __path__[0], (), after="control", lowers="lowering:controllers_of", rules="rules"
)

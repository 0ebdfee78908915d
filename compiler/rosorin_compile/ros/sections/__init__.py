"""The sections of a description for ROS 2: ``control`` (hardware), ``controllers`` and ``moveit`` (planning)."""

from . import control, controllers, moveit

SECTIONS = (control.SECTION, controllers.SECTION, moveit.SECTION)

"""The sections of the language that nodes of ROS 2 read: hardware, controllers, planning; a folder for each."""

from . import control, controllers, moveit

SECTIONS = (control.SECTION, controllers.SECTION, moveit.SECTION)

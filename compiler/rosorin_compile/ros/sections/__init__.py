"""Sections of a description that configure ROS 2: ``control`` (hardware), ``controllers``, ``moveit`` (planning)."""

from . import control, controllers, moveit

SECTIONS = (control.SECTION, controllers.SECTION, moveit.SECTION)

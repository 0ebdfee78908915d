"""Convert the Gazebo and ros2_control elements of a URDF or SDF to sections of a description."""

from .convert import Converted, report_elements, with_sections

__all__ = ["Converted", "report_elements", "with_sections"]

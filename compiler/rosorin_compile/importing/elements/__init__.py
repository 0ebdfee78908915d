"""Convert the Gazebo and ros2_control elements of a URDF or SDF to sections of a description.

``hardware`` and ``sensors`` convert one element, and ``convert`` compares what an entry becomes with the
element that it came from.
"""

from .convert import Converted, report_elements, with_sections

__all__ = ["Converted", "report_elements", "with_sections"]

"""Convert the Gazebo and ros2_control elements of a URDF to sections of a description, where both mean the same.

``taking`` finds the elements, ``blocks``, ``sensors`` and ``drives`` convert one, and ``proving`` compares what an
entry becomes with the element that it came from.
"""

from __future__ import annotations

from .proving import Worded, report_words, with_sections

__all__ = ["Worded", "report_words", "with_sections"]

"""What a format is made of that is written, read and held against the model."""

from __future__ import annotations

from ..formats.checked import accept
from ..formats.described import as_tree
from ..formats.distributions import DISTRIBUTIONS, HUMBLE, JAZZY, described_by, title
from ..formats.expectation import Block, Deviations, Expectation
from ..formats.facts import COLLISION, VISUAL, FactSheet, Six, along_link
from ..formats.facts import number_of as fact_number
from ..formats.facts import numbers_of as fact_numbers
from ..formats.format import BOXES_OF_HEIGHT_MAPS, FORMS_OF_BOXES, NUMBER_FORMAT, Asked, Joined, Placed, Refusal
from ..formats.gazebo_sensors import DISTRIBUTIONS as GAZEBO_DISTRIBUTIONS
from ..formats.gazebo_sensors import distribution, sensor_lines
from ..formats.imported import BEFORE, BESIDE, END, INSIDE, LeftOut, cannot_carry
from ..formats.launching import (
    STATES,
    Condition,
    condition,
    free_names,
    if_condition,
    imported,
    in_frontends,
    in_python,
    mode_arguments,
    substitutions,
)
from ..formats.mesh_vertices import clouds_of, why_unread
from ..formats.static_tf import describe
from ..formats.templating import attribute, attributes, comment
from ..formats.urdf.masses import joints_of, links_of
from ..formats.urdf.reading import NAME, Reading, correction, kept, named
from ..formats.urdf.robot import comments_of
from ..formats.urdf.values import ANGLES, LENGTHS, PLAIN, number_of, numbers

__all__ = [
    "ANGLES",
    "BEFORE",
    "BESIDE",
    "BOXES_OF_HEIGHT_MAPS",
    "COLLISION",
    "DISTRIBUTIONS",
    "END",
    "FORMS_OF_BOXES",
    "GAZEBO_DISTRIBUTIONS",
    "HUMBLE",
    "INSIDE",
    "JAZZY",
    "LENGTHS",
    "NAME",
    "NUMBER_FORMAT",
    "PLAIN",
    "STATES",
    "VISUAL",
    "Asked",
    "Block",
    "Condition",
    "Deviations",
    "Expectation",
    "FactSheet",
    "Joined",
    "LeftOut",
    "Placed",
    "Reading",
    "Refusal",
    "Six",
    "accept",
    "along_link",
    "as_tree",
    "attribute",
    "attributes",
    "cannot_carry",
    "clouds_of",
    "comment",
    "comments_of",
    "condition",
    "correction",
    "describe",
    "described_by",
    "distribution",
    "fact_number",
    "fact_numbers",
    "free_names",
    "if_condition",
    "imported",
    "in_frontends",
    "in_python",
    "joints_of",
    "kept",
    "links_of",
    "mode_arguments",
    "named",
    "number_of",
    "numbers",
    "sensor_lines",
    "substitutions",
    "title",
    "why_unread",
]

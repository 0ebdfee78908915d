"""The section ``moveit``: what MoveIt has to know of a robot beside its URDF."""

from ...model.sections import Section, schema_in
from .value import Moveit

MOVEIT = Section.single(
    "moveit",
    Moveit,
    schema_in(__path__[0]),
    after="controllers",
    lowers="lowering:moveit_of",
    compares="comparison:compare",
    rules="rules",
    package=__name__,
)

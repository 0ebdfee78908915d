"""What a section of the language is made of that stands in a package beside the core."""

from __future__ import annotations

from ..diagnostics.registry import Check as SeparateCheck
from ..frontend.annotations import named_as
from ..frontend.lower.entries import Problem, actuator_of, entries_of, values_of
from ..frontend.lower.plainly import plain, pose_of_entry, record_of, vector_of
from ..frontend.lower.simulation import others, reworded
from ..meaning.difference import OTHER, YAML, Item, Side
from ..meaning.pairing import Pairing
from ..meaning.simulation import words_of
from ..meaning.values import Said, changed_entry
from ..model.sections import OwnSection
from ..rules.case import number
from ..rules.simulated_names import BALL, several

__all__ = [
    "BALL",
    "OTHER",
    "YAML",
    "Item",
    "OwnSection",
    "Pairing",
    "Problem",
    "Said",
    "SeparateCheck",
    "Side",
    "actuator_of",
    "changed_entry",
    "entries_of",
    "named_as",
    "number",
    "others",
    "plain",
    "pose_of_entry",
    "record_of",
    "reworded",
    "several",
    "values_of",
    "vector_of",
    "words_of",
]

"""Numbers in print, conditions, names and files, as backends need them."""

from __future__ import annotations

from ..diagnostics import and_here, swaps
from ..diagnostics.bounded import json_of
from ..diagnostics.console import paint
from ..diagnostics.wording import plural
from ..frontend.lower import lower
from ..frontend.misnamed import name_meant
from ..frontend.packages import OF_GAZEBO
from ..frontend.schema import resolve, schema
from ..frontend.tree import at, exists
from ..numbers import NumberFormat, number_format, numbers, six, vector
from ..output import write_set
from ..output.one_file import replace_text
from ..project import DESCRIPTIONS, data_folder
from ..rules.conditions import MAX_MODES, holds, modes_in
from ..rules.remarkable import FULL_TURN
from ..rules.tf_tree import is_tree
from ..rules.values import FAR
from ..startup.cache import sha256
from ..startup.remembering import remembered
from ..units import ANGLE, LENGTH, describe, parse_unit

__all__ = [
    "ANGLE",
    "DESCRIPTIONS",
    "FAR",
    "FULL_TURN",
    "LENGTH",
    "MAX_MODES",
    "OF_GAZEBO",
    "NumberFormat",
    "and_here",
    "at",
    "data_folder",
    "describe",
    "exists",
    "holds",
    "is_tree",
    "json_of",
    "lower",
    "modes_in",
    "name_meant",
    "number_format",
    "numbers",
    "paint",
    "parse_unit",
    "plural",
    "remembered",
    "replace_text",
    "resolve",
    "schema",
    "sha256",
    "six",
    "swaps",
    "vector",
    "write_set",
]

"""Text of view_frames: the dot file that it writes, and the YAML that it gets from the listener."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable
from typing import Any

from ...bounded import python_of, yaml_of
from ..recording.recording import FrameRow

_EDGE = re.compile(r'"([^"]+)" -> "([^"]+)"\s*\[label="([^"]*)"')
_FIELD = re.compile(r"\s*([\w ]+): *([^\\]*)")
_NUMBER = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?")
_RECORDED = re.compile(r'"Recorded at time: ([\d.]+)"')
_LITERAL = re.compile(r"frame_yaml=((?:'(?:[^'\\]|\\.)*')|(?:\"(?:[^\"\\]|\\.)*\"))")

Name = Callable[[str], str]


def dot_rows(text: str, name: Name) -> list[FrameRow] | None:
    """Return the frames of a dot file; None if it is not whole."""
    recorded = _RECORDED.search(text)
    at = _number(recorded[1]) if recorded else math.nan
    rows = []
    for edge in _EDGE.finditer(text):
        matches = map(_FIELD.match, edge[3].split("\\n"))
        fields = {match[1]: match[2] for match in matches if match}
        newest = _leading(fields.get("Most recent transform", ""))
        age = at - newest if math.isfinite(at - newest) and newest > 0 else None
        rate, length = _leading(fields.get("Average rate", "")), _leading(fields.get("Buffer length", ""))
        row = FrameRow(name(edge[1]), name(edge[2]), rate, length, age)
        rows += [] if math.isnan(rate) else [row]
    return rows or None


def _leading(text: str) -> float:
    """Return the number that a text begins with; a unit may follow."""
    match = _NUMBER.match(text)
    return _number(match[0]) if match else math.nan


def yaml_rows(text: str, name: Name) -> list[FrameRow] | None:
    """Return the frames of the YAML of a listener; None if it cannot be read."""
    try:
        loaded = yaml_of(text)
    except ValueError:
        return None
    if not isinstance(loaded, dict):
        return None
    rows = []
    for child, entry in loaded.items():
        if not isinstance(entry, dict) or "parent" not in entry:
            return None
        delay = entry.get("transform_delay")
        age = _number(delay) if delay is not None else None
        rate, length = _number(entry.get("rate")), _number(entry.get("buffer_length"))
        rows.append(FrameRow(name(str(entry["parent"])), name(str(child)), rate, length, age))
    return rows or None


def literal_rows(text: str, name: Name) -> list[FrameRow] | None:
    """Return the frames of the line that view_frames logs, where the YAML stands as a text of Python."""
    literal = _LITERAL.search(text)
    if not literal:
        return None
    try:
        value = ast.literal_eval(python_of(literal[1], expression=True))
    except (ValueError, SyntaxError):
        return None
    return yaml_rows(str(value), name)


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan

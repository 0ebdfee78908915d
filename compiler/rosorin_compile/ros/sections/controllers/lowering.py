"""Controllers of ros2_control: their section of a description as a value of the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosorin_compile.language.lower.entries import Problem, entries_of
from rosorin_compile.language.lower.plainly import record_of
from rosorin_compile.model.controllers import Controller, flat


def controllers_of(tree: Mapping[str, Any], _: Problem) -> tuple[Controller, ...]:
    """Return the controllers of a description."""
    return tuple(
        record_of(
            Controller,
            entry,
            name=name,
            params={key: _plain(value) for key, value in flat(entry.get("params") or {}).items()},
        )
        for name, entry in entries_of(tree, "controllers")
    )


def _plain(value: Any) -> Any:
    """Return a value without its place: quantities as numbers in SI units."""
    if isinstance(value, list):
        return tuple(_plain(item) for item in value)
    if isinstance(value, float):
        return float(value)
    return str(value) if isinstance(value, str) else value

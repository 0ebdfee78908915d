"""Controllers of ros2_control: their section of a description as a value of the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...model.control import Controller
from .entries import entries_of
from .plainly import record_of


def lower_controllers(tree: Mapping[str, Any]) -> tuple[Controller, ...]:
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


def flat(params: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Return nested parameters by their full keys.

    >>> flat({"a": {"b": 1, "c.d": 2}})
    {'a.b': 1, 'a.c.d': 2}
    """
    found: dict[str, Any] = {}
    for key, value in params.items():
        if isinstance(value, Mapping):
            found |= flat(value, f"{above}{key}.")
        else:
            found[f"{above}{key}"] = value
    return found


def _plain(value: Any) -> Any:
    """Return a value without its place: quantities as numbers in SI units."""
    if isinstance(value, list):
        return tuple(_plain(item) for item in value)
    if isinstance(value, float):
        return float(value)
    return str(value) if isinstance(value, str) else value

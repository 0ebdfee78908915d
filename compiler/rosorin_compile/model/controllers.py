"""Controllers: what each of ros2_control is, and its parameters by their full keys."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .link import NO_SOURCE, Source


@dataclass(frozen=True)
class Controller:
    """A controller: ``type`` as the description has it, ``params`` by their full keys (``a.b.c``).

    ``hardware`` is the block whose joints it moves, ``sensor`` the one that it speaks for; empty if not said.
    ``inactive``: it is configured when the robot starts, and somebody switches to it later.
    """

    name: str
    type: str
    params: Mapping[str, Any] = field(default_factory=dict)
    hardware: str = ""
    sensor: str = ""
    inactive: bool = False
    source: Source = NO_SOURCE


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

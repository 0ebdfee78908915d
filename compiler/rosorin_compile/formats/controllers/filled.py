"""The controllers of a description with all their parameters: what it says goes before what the robot knows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ...frontend.lower.control import flat
from ...model import Output, Robot
from ...model.control import Controller
from ..parameters.tables import Kind, controller, manager
from ..parameters.values import converted
from .known import Known, known
from .types import full

UPDATE_RATE = 100  # Hz
# Steering controllers of Jazzy call wheels by what they do, and keep the words of Humble for where they stand.
_LATER, _EARLIER = "traction_joints_names", ("front_wheel", "rear_wheel", "wheel_track")


class Filled(NamedTuple):
    """A controller with its type in full, all its parameters as they are written, and what the robot knows of them."""

    controller: Controller
    type: str
    values: Mapping[str, Any]
    known: Known
    kind: Kind | None


def filled(robot: Robot, distribution: str) -> list[Filled]:
    """Return the controllers of a robot with all that is known of their parameters, for humble or jazzy."""
    made = []
    for one in robot.controllers:
        kind = full(one.type)
        found, knows = controller(kind, distribution), known(robot, one, kind)
        values = {key: value for key, value in knows.values.items() if found is not None and key in found}
        if found is not None and _LATER in found:
            values = {key: value for key, value in values.items() if not key.startswith(_EARLIER)}
        values |= one.params
        made.append(Filled(one, kind, {key: _typed(found, key, value) for key, value in values.items()}, knows, found))
    return made


def managed(output: Output, distribution: str) -> dict[str, Any]:
    """Return the parameters of the controller_manager itself."""
    values = {
        "update_rate": output.options.get("update_rate", UPDATE_RATE),
        **flat(output.options.get("manager") or {}),
    }
    return {key: _typed(manager(distribution), key, value) for key, value in values.items()}


def _typed(found: Kind | None, key: str, value: Any) -> Any:
    entry = found.key(key) if found is not None else None
    if entry is not None:
        return converted(value, entry.type)
    return list(value) if isinstance(value, tuple) else value

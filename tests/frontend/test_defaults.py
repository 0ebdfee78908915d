"""What the schema says is the default of a key is what the compiler takes for one that is left out."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.language.expand.description import expand
from rosorin_compile.language.lower import lower
from rosorin_compile.language.schema import fragment_at
from rosorin_compile.model import Robot

# A robot that says none of them, with everything that has one.
_SHAPE = {"mesh": {"file": "package://some/box.stl"}}
ROBOT: dict[str, Any] = {
    "robot": "cart",
    "links": {
        "base": {
            "inertial": {"mass": 1, "inertia": {"ixx": 1, "iyy": 1, "izz": 1}},
            "visual": [_SHAPE],
            "collision": [_SHAPE],
            **{
                marks: {"one": {"rpy": [0, 0, 1]}, "other": {"xyz": [0, 0, 1]}}
                for marks in ("sites", "cameras", "lights")
            },
        },
        "arm": {},
        "tool": {},
    },
    "joints": {
        "lead": {"type": "continuous", "parent": "base", "child": "arm", "axis": [0, 0, 1]},
        "follow": {
            "type": "continuous",
            "parent": "arm",
            "child": "tool",
            "axis": [0, 0, 1],
            "mimic": {"joint": "lead"},
            "dynamics": {"stiffness": 1},
        },
    },
}


def defaults(value: Any = ROBOT, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the paths of the keys with a default that the robot could say, and does not."""
    if isinstance(value, list):
        for index, item in enumerate(value):
            yield from defaults(item, (*path, index))
    if isinstance(value, dict):
        for key in fragment_at(path).get("properties", ()):
            if key not in value and "default" in fragment_at((*path, key)):
                yield (*path, key)
        for key, item in value.items():
            yield from defaults(item, (*path, key))


def robot_of(folder: Path, description: dict[str, Any]) -> Robot:
    """Return the robot of a description."""
    (folder / "robot.yaml").write_text(json.dumps(description), "utf-8")
    made = expand(folder / "robot.yaml", {}, None)
    assert made.tree is not None
    robot = lower(made.tree).robot
    assert robot is not None
    return robot


@pytest.mark.parametrize("path", list(defaults()), ids=lambda path: ".".join(map(str, path)))
def test_a_default_that_is_said_changes_nothing(path: tuple[Any, ...], tmp_path: Path) -> None:
    said = copy.deepcopy(ROBOT)
    node: Any = said
    for step in path[:-1]:
        node = node[step]
    node[path[-1]] = fragment_at(path)["default"]
    assert robot_of(tmp_path, said) == robot_of(tmp_path, ROBOT)

"""Stand-ins for launch and launch_ros as Humble and Jazzy have them, and the command line of the static publisher.

They offer what a generated launch file may use, and nothing else, so that any other use fails.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from rosorin_compile.model import Pose


@dataclass
class Node:
    package: str
    executable: str
    name: str
    parameters: list[dict[str, Any]] = field(default_factory=list)
    arguments: list[str] = field(default_factory=list)


@dataclass
class ParameterValue:
    value: Any
    value_type: type

    def __init__(self, value: Any, *, value_type: type) -> None:
        self.value, self.value_type = value, value_type


@dataclass
class LaunchDescription:
    entities: list[Any]


class DeclareLaunchArgument:
    def __init__(self, name: str, *, default_value: str, description: str) -> None:
        assert isinstance(default_value, str)
        self.name, self.default_value, self.description = name, default_value, description


class LaunchConfiguration:
    def __init__(self, name: str) -> None:
        self.name = name

    def perform(self, context: dict[str, str]) -> str:
        return context[self.name]


class OpaqueFunction:
    def __init__(self, *, function: Any) -> None:
        self.function = function


OFFERED = {
    "launch": {"LaunchDescription": LaunchDescription},
    "launch.actions": {"DeclareLaunchArgument": DeclareLaunchArgument, "OpaqueFunction": OpaqueFunction},
    "launch.substitutions": {"LaunchConfiguration": LaunchConfiguration},
    "launch_ros": {},
    "launch_ros.actions": {"Node": Node},
    "launch_ros.parameter_descriptions": {"ParameterValue": ParameterValue},
}


def run(text: str, path: Path, **arguments: str) -> list[Node]:
    """Run a launch file as ``ros2 launch`` would and return the nodes that it starts."""
    modules = {}
    for name, offered in OFFERED.items():
        modules[name] = ModuleType(name)
        vars(modules[name]).update(offered)
    with pytest.MonkeyPatch.context() as patch:
        for name, module in modules.items():
            patch.setitem(sys.modules, name, module)
        scope = {"__file__": str(path), "__name__": "launch_file"}
        exec(compile(text, str(path), "exec"), scope)  # noqa: S102 - it is our own text
        entities = scope["generate_launch_description"]().entities  # type: ignore[operator]
        context = {e.name: e.default_value for e in entities if isinstance(e, DeclareLaunchArgument)} | arguments
        nodes = []
        for entity in entities:
            nodes += entity.function(context) if isinstance(entity, OpaqueFunction) else [entity]
        return [node for node in nodes if isinstance(node, Node)]


def command_line(arguments: list[str]) -> tuple[str, str, Pose]:
    """Read arguments as static_transform_publisher does: each flag takes the next word, whatever it is."""
    numbers = dict.fromkeys(("--x", "--y", "--z", "--roll", "--pitch", "--yaw"), 0.0)
    frames = {"--frame-id": "", "--child-frame-id": ""}
    words = iter(arguments)
    for flag in words:
        if flag in numbers:
            numbers[flag] = float(next(words))
        elif flag in frames:
            frames[flag] = next(words)
        else:
            pytest.fail(f"Extra unparsed arguments: {flag}")
    parent, child = frames.values()
    assert parent, "--frame-id is mandatory"
    assert child, "--child-frame-id is mandatory"
    assert parent != child, "the node throws if the two are equal"
    x, y, z, roll, pitch, yaw = numbers.values()
    return parent, child, Pose((x, y, z), (roll, pitch, yaw))

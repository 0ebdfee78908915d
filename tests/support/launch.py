"""Reads launch files in their three forms as launch does on Humble and Jazzy; what it does not know fails.

Python is run with stand-ins. XML and YAML are read by the rules of ``launch.frontend``: attributes that a node does not
know are refused, values are texts, "$(name argument)" is a substitution, a backslash takes the meaning of the next
character, and ``args`` is split as a shell does after that.
"""

from __future__ import annotations

import re
import shlex
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
import yaml

from rosorin_compile.model import Pose

NODE = {"pkg", "exec", "name", "namespace", "args", "ros_args", "output", "if", "unless"}
PARAM = {"name", "value", "from", "type"}
ARG = {"name", "default", "description"}
CALL = re.compile(r"(?<!\\)\$\(([a-z-]+)((?:[^()'\"]|'(?:[^'()]|\([^()]*\))*')*)\)")


@dataclass
class Started:
    """A node that is started: package, executable, name, arguments, parameters."""

    package: str
    executable: str
    name: str
    arguments: list[str] = field(default_factory=list)
    parameters: dict[str, Any] = field(default_factory=dict)


@dataclass
class Launch:
    """What a launch file does: its arguments with their defaults and descriptions, and the nodes that it starts."""

    arguments: dict[str, tuple[str, str]]
    nodes: list[Started]


def read(path: Path, shares: Mapping[str, Path], **given: str) -> Launch:
    """Return what a launch file does with ``given`` arguments; ``shares`` are the share folders of packages."""
    text = path.read_text("utf-8")
    if path.name.endswith(".py"):
        return _python(text, path, shares, given)
    return (_xml if path.name.endswith(".xml") else _yaml)(text, shares, given)


def _xml(text: str, shares: Mapping[str, Path], given: Mapping[str, str]) -> Launch:
    root = ET.fromstring(text)
    assert root.tag == "launch"
    assert not root.attrib
    entities = []
    for element in root:
        assert element.tag in ("arg", "node")
        assert not (element.text or "").strip()
        attributes: dict[str, Any] = dict(element.attrib)
        params = [dict(child.attrib) for child in element]
        assert all(child.tag == "param" for child in element)
        entities.append((element.tag, attributes | ({"param": params} if params else {})))
    return _launched(entities, shares, given)


def _yaml(text: str, shares: Mapping[str, Path], given: Mapping[str, str]) -> Launch:
    tree = yaml.safe_load(text)
    assert list(tree) == ["launch"]
    assert all(len(entity) == 1 for entity in tree["launch"])
    return _launched([next(iter(entity.items())) for entity in tree["launch"]], shares, given)


def _launched(
    entities: list[tuple[str, dict[str, Any]]], shares: Mapping[str, Path], given: Mapping[str, str]
) -> Launch:
    launch = Launch({}, [])
    values: dict[str, str] = {}
    for tag, attributes in entities:
        params = attributes.pop("param", [])
        assert all(isinstance(value, str) for value in attributes.values()), f"not all texts: {attributes}"
        assert attributes.keys() <= {"arg": ARG, "node": NODE}[tag], "Unexpected attribute(s)"
        if tag == "arg":
            launch.arguments[attributes["name"]] = (attributes["default"], attributes["description"])
            values[attributes["name"]] = given.get(attributes["name"], attributes["default"])
            continue

        def said(text: str) -> str:
            return "".join(performed(text, shares, values))

        if "if" in attributes and not _true(said(attributes["if"])):
            continue
        node = Started(*(said(attributes[key]) for key in ("pkg", "exec", "name")))
        node.arguments = split(performed(attributes.get("args", ""), shares, values))
        for param in params:
            assert param.keys() <= PARAM
            assert all(isinstance(value, str) for value in param.values())
            text = said(param["value"])
            node.parameters[param["name"]] = text if param.get("type") == "str" else yaml.safe_load(text)
        launch.nodes.append(node)
    return launch


class Performed(str):
    """The result of a substitution: no shell splits it."""


def performed(text: str, shares: Mapping[str, Path], values: Mapping[str, str]) -> list[str]:
    """Return a text as pieces, its substitutions performed."""
    pieces: list[str] = []
    at = 0
    for match in CALL.finditer(text):
        pieces.append(_plain(text[at : match.start()]))
        argument = match[2].strip()
        if match[1] == "var":
            pieces.append(Performed(values[argument]))
        elif match[1] == "find-pkg-share":
            pieces.append(Performed(shares[argument]))
        elif match[1] == "eval":
            assert argument[0] == argument[-1] == "'"
            expression = "".join(performed(argument[1:-1], shares, values))
            pieces.append(Performed(eval(expression, {"__builtins__": {}})))  # noqa: S307 - it is our own text
        elif match[1] == "command":
            assert argument[0] == argument[-1] == "'"
            words = shlex.split("".join(performed(argument[1:-1], shares, values)))
            assert words[0] == "cat"
            assert len(words) == 2
            pieces.append(Performed(Path(words[1]).read_bytes().decode()))
        else:
            pytest.fail(f"Unknown substitution: {match[1]}")
        at = match.end()
    return [*pieces, _plain(text[at:])]


def _plain(text: str) -> str:
    assert not re.search(r"(?<!\\)\$", text), f"the grammar of substitutions has no bare $: {text}"
    return re.sub(r"\\(.)", r"\1", text)


def split(pieces: list[str]) -> list[str]:
    """Return a command line as its words: text is split as a shell does, results of substitutions stay whole."""
    words: list[str] = []
    is_open = False
    for piece in pieces:
        if not piece:
            continue
        if isinstance(piece, Performed):
            found, starts, ends = [str(piece)], False, False
        else:
            found, starts, ends = shlex.split(piece), piece[0].isspace(), piece[-1].isspace()
        if found and is_open and not starts:
            words[-1] += found.pop(0)
        words += found
        is_open = not ends
    return words


def _true(text: str) -> bool:
    assert text.lower() in ("true", "1", "false", "0"), f"no truth value: {text}"
    return text.lower() in ("true", "1")


def _python(text: str, path: Path, shares: Mapping[str, Path], given: Mapping[str, str]) -> Launch:
    """Run a launch file with stand-ins that know what it may use and nothing else."""
    launch = Launch({}, [])
    values: dict[str, str] = {}

    def resolved(value: Any) -> Any:
        return value() if callable(value) else value

    def node(
        package: str, executable: str, name: str, arguments: Any = (), parameters: Any = (), condition: Any = None
    ) -> Callable[[], None]:
        assert all(isinstance(argument, str) for argument in arguments)

        def start() -> None:
            if condition is None or _true(condition()):
                merged = {key: resolved(value) for one in parameters for key, value in one.items()}
                launch.nodes.append(Started(package, executable, name, list(arguments), merged))

        return start

    def argument(name: str, *, default_value: str, description: str) -> Callable[[], None]:
        assert isinstance(default_value, str)

        def declare() -> None:
            launch.arguments[name] = (default_value, description)
            values[name] = given.get(name, default_value)

        return declare

    def typed(value: Any, *, value_type: type) -> Callable[[], Any]:
        def convert() -> Any:
            found = resolved(value)
            return yaml.safe_load(found) if value_type is bool else found

        assert value_type in (bool, str)
        return convert

    offered = {
        "ament_index_python": {},
        "ament_index_python.packages": {"get_package_share_directory": lambda name: str(shares[name])},
        "launch": {"LaunchDescription": lambda entities: entities},
        "launch.actions": {"DeclareLaunchArgument": argument},
        "launch.conditions": {"IfCondition": lambda predicate: predicate},
        "launch.substitutions": {
            "LaunchConfiguration": lambda name: lambda: values[name],
            "PythonExpression": lambda pieces: lambda: str(eval("".join(map(resolved, pieces)), {"__builtins__": {}})),  # noqa: S307
        },
        "launch_ros": {},
        "launch_ros.actions": {"Node": node},
        "launch_ros.parameter_descriptions": {"ParameterValue": typed},
    }
    with pytest.MonkeyPatch.context() as patch:
        for module, names in offered.items():
            made = ModuleType(module)
            vars(made).update(names)
            patch.setitem(sys.modules, module, made)
        scope = SimpleNamespace(__file__=str(path), __name__="launch_file")
        exec(compile(text, str(path), "exec"), vars(scope))  # noqa: S102 - it is our own text
        for entity in scope.generate_launch_description():
            entity()
    return launch


# Stand-ins for launch and launch_ros as Humble and Jazzy have them, and the command line of the static publisher.
# They offer what a generated launch file may use, and nothing else, so that any other use fails.


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

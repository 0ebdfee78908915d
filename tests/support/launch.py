"""Reads launch files in their three forms as launch does on Humble and Jazzy; what it does not know fails.

Python is run with stand-ins that offer what a generated launch file may use, and nothing else. XML and YAML are read by
the rules of ``launch.frontend``: attributes that an action does not know are refused, values are texts, "$(name
argument)" is a substitution, a backslash takes the meaning of the next character, and ``args`` is split as a shell does
after that. Substitutions are performed: ``Command`` runs its program, and fails on whatever that writes to stderr.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest
import yaml

from rosorin_compile.model import Pose


@dataclass
class Started:
    """A node that is started: package, executable, name, namespace, arguments, parameters, remaps, parameter files."""

    package: str
    executable: str
    name: str
    arguments: list[str] = field(default_factory=list)
    parameters: dict[str, Any] = field(default_factory=dict)
    namespace: str = ""
    remaps: list[tuple[str, str]] = field(default_factory=list)
    files: list[str] = field(default_factory=list)


class Declared(NamedTuple):
    """An argument of a launch file; ``default`` is None where there is none."""

    default: str | None
    description: str
    choices: tuple[str, ...] = ()


@dataclass
class Launch:
    """What a launch file does: the arguments that it declares, and the nodes that it starts."""

    arguments: dict[str, Declared]
    nodes: list[Started]


class Failed(Exception):
    """Launch would stop here; the message says why."""


class Context:
    """The values of launch arguments, the share folders of packages, and what was started."""

    def __init__(self, shares: Mapping[str, Path], given: Mapping[str, str]) -> None:
        self.shares, self.values, self.launch = shares, dict(given), Launch({}, [])

    def restore(self, values: Mapping[str, str]) -> None:
        self.values = dict(values)


def read(path: Path, shares: Mapping[str, Path], **given: str) -> Launch:
    """Return what a launch file does with ``given`` arguments; ``shares`` are the share folders of packages."""
    context = Context(shares, given)
    _visit(_entities(path.read_text("utf-8"), path, context), context)
    return context.launch


def run(text: str, path: Path, **arguments: str) -> list[Started]:
    """Run a launch file in Python as ``ros2 launch`` would and return the nodes that it starts."""
    context = Context({}, arguments)
    _visit(_entities(text, path, context), context)
    return context.launch.nodes


def _entities(text: str, path: Path, context: Context) -> list[Any]:
    if path.name.endswith(".py"):
        return _python(text, path, context)
    return (_xml if path.name.endswith(".xml") else _yaml)(text)


def _visit(entities: Iterable[Any], context: Context) -> None:
    for entity in entities:
        condition = getattr(entity, "condition", None)
        if condition is None or condition.holds(context):
            _visit(entity.execute(context) or (), context)


# Substitutions


class Substitution:
    """What has a value only when launch runs."""

    def __init__(self, *values: Any, default: str | None = None) -> None:
        self.values, self.default = values, default

    def perform(self, context: Context) -> str:
        raise NotImplementedError


class LaunchConfiguration(Substitution):
    def perform(self, context: Context) -> str:
        value = context.values.get(self.values[0], self.default)
        if value is None:
            raise Failed(f"launch configuration '{self.values[0]}' does not exist")
        return value


class FindPackageShare(Substitution):
    def perform(self, context: Context) -> str:
        return str(context.shares[performed(self.values[0], context)])


class NotSubstitution(Substitution):
    def perform(self, context: Context) -> str:
        return str(not _boolean(self.values[0], context)).lower()


class AndSubstitution(Substitution):
    together: Callable[[list[bool]], bool] = staticmethod(all)

    def perform(self, context: Context) -> str:
        left, right = self.values  # both are always read: what is no truth value fails
        return str(self.together([_boolean(left, context), _boolean(right, context)])).lower()


class OrSubstitution(AndSubstitution):
    together = staticmethod(any)


class Command(Substitution):
    def perform(self, context: Context) -> str:
        words = shlex.split(performed(self.values[0], context))
        environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
        made = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
        if made.returncode != 0 or made.stderr:
            raise Failed(f"executed command failed. Command: {shlex.join(words)}\n{made.stderr}")
        return made.stdout


def performed(value: Any, context: Context) -> str:
    """Return a text, a substitution, or a list of them, as the text that it is."""
    if isinstance(value, str):
        return value
    if isinstance(value, Substitution):
        return value.perform(context)
    assert isinstance(value, list | tuple), f"no substitution: {value!r}"
    return "".join(performed(piece, context) for piece in value)


def _boolean(value: Any, context: Context) -> bool:
    text = performed(value, context)
    found = yaml.safe_load(text)
    if not isinstance(found, bool):
        raise Failed(f"cannot convert value '{text}' to bool")
    return found


@dataclass
class IfCondition:
    predicate: Any

    def holds(self, context: Context) -> bool:
        text = performed(self.predicate, context).strip().lower()
        if text not in ("true", "1", "false", "0"):
            raise Failed(f"'{text}' is no condition")
        return text in ("true", "1")


# Actions


class DeclareLaunchArgument:
    def __init__(
        self, name: str, *, default_value: Any = None, description: str = "", choices: Sequence[str] | None = None
    ) -> None:
        assert isinstance(name, str)
        assert description
        assert choices is None or len(choices) > 0
        if choices is not None and isinstance(default_value, str):
            assert default_value in choices, f"{default_value} is not in {choices}"
        self.name, self.default, self.description, self.choices = name, default_value, description, choices

    def execute(self, context: Context) -> None:
        default = None if self.default is None else performed(self.default, context)
        declared = Declared(default, self.description, tuple(self.choices or ()))
        context.launch.arguments.setdefault(self.name, declared)
        if self.name not in context.values:
            if default is None:
                raise Failed(f"Required launch argument '{self.name}' was not provided")
            context.values[self.name] = default
        value = context.values[self.name]
        if self.choices is not None and value not in self.choices:
            raise Failed(f"Argument '{self.name}' provided value '{value}' is not valid")


@dataclass
class SetLaunchConfiguration:
    name: str
    value: Any

    def execute(self, context: Context) -> None:
        context.values[self.name] = performed(self.value, context)


@dataclass
class GroupAction:
    """Actions whose launch configurations are set for them alone, as a scoped group's are (the default)."""

    actions: Sequence[Any]

    def execute(self, context: Context) -> list[Any]:
        before = dict(context.values)
        return [*self.actions, OpaqueFunction(function=lambda context: context.restore(before))]


class OpaqueFunction:
    def __init__(self, *, function: Callable[[Context], Any]) -> None:
        self.execute = function


class PythonLaunchDescriptionSource(NamedTuple):
    path: Any


class IncludeLaunchDescription:
    def __init__(self, source: Any, *, launch_arguments: Iterable[tuple[str, Any]] = ()) -> None:
        self.source, self.given = source, list(launch_arguments)

    def execute(self, context: Context) -> list[Any]:
        path = Path(performed(self.source.path, context))
        values = {name: performed(value, context) for name, value in self.given}
        entities = _entities(path.read_text("utf-8"), path, context)
        for entity in entities:
            # On Humble an argument without a default has to be given by the include itself.
            if isinstance(entity, DeclareLaunchArgument) and entity.default is None and entity.name not in values:
                raise Failed(f"Included launch description missing required argument '{entity.name}'")
        return [*(SetLaunchConfiguration(name, value) for name, value in values.items()), *entities]


@dataclass
class ParameterValue:
    value: Any
    value_type: type

    def read(self, context: Context) -> Any:
        assert self.value_type in (bool, str)
        text = performed(self.value, context)
        return text if self.value_type is str else _boolean(text, context)


@dataclass(kw_only=True)
class Node:
    package: Any
    executable: Any
    name: Any = ""
    namespace: Any = ""
    arguments: Any = ()
    parameters: Any = ()
    remappings: Sequence[tuple[Any, Any]] = ()
    output: str = "log"
    condition: IfCondition | None = None

    def execute(self, context: Context) -> None:
        assert all(isinstance(argument, str | list | Substitution) for argument in self.arguments)
        assert self.output in ("log", "screen", "both")
        words = (self.package, self.executable, self.name, self.namespace)
        package, executable, name, namespace = (performed(word, context) for word in words)
        arguments = [performed(argument, context) for argument in self.arguments]
        merged = {key: value for one in self.parameters if isinstance(one, dict) for key, value in one.items()}
        values = {key: _parameter(value, context) for key, value in merged.items()}
        files = [performed(one, context) for one in self.parameters if not isinstance(one, dict)]
        assert all(Path(file).is_file() for file in files), f"no such file: {files}"
        remaps = [(performed(old, context), performed(new, context)) for old, new in self.remappings]
        started = Started(package, executable, name, arguments, values, namespace, remaps, files)
        context.launch.nodes.append(started)


def _parameter(value: Any, context: Context) -> Any:
    """Return a parameter as the node gets it: what is no ParameterValue is read as YAML."""
    if isinstance(value, bool | int | float | dict):
        return value
    if isinstance(value, tuple):  # of plain values, not of substitutions
        return list(value)
    return value.read(context) if isinstance(value, ParameterValue) else yaml.safe_load(performed(value, context))


TEXTS = ("robot_description", "robot_description_semantic")


class MoveItConfigsBuilder:
    """Reads files of a package as ``moveit_configs_utils`` does: each must exist, and have the contents of its kind."""

    def __init__(self, robot_name: str, *, package_name: str, context: Context) -> None:
        self.share, self.read = context.shares[package_name], dict[str, Any](name=robot_name)

    def __getattr__(self, name: str) -> Callable[..., MoveItConfigsBuilder]:
        keys = {"joint_limits": "robot_description_planning"}
        assert name in (*TEXTS, "robot_description_kinematics", "joint_limits", "trajectory_execution")

        def load(*, file_path: str) -> MoveItConfigsBuilder:
            text = (self.share / file_path).read_text("utf-8")
            loaded = yaml.safe_load(text) if name not in TEXTS else ET.fromstring(text) is not None and text
            assert isinstance(loaded, str if name in TEXTS else dict)
            self.read |= loaded if name == "trajectory_execution" else {keys.get(name, name): loaded}
            return self

        return load

    def planning_pipelines(self, *, pipelines: list[str]) -> MoveItConfigsBuilder:
        self.read["planning_pipelines"] = tuple(pipelines)
        return self

    def to_moveit_configs(self) -> MoveItConfigsBuilder:
        return self

    def to_dict(self) -> dict[str, Any]:
        return {key: value for key, value in self.read.items() if key != "name"}


def _python(text: str, path: Path, context: Context) -> list[Any]:
    actions = (DeclareLaunchArgument, GroupAction, IncludeLaunchDescription, OpaqueFunction, SetLaunchConfiguration)
    substitutions = (AndSubstitution, Command, LaunchConfiguration, NotSubstitution, OrSubstitution)
    offered: dict[str, dict[str, Any]] = {
        "ament_index_python": {},
        "ament_index_python.packages": {"get_package_share_directory": lambda name: str(context.shares[name])},
        "launch": {"LaunchDescription": list},
        "launch.actions": {one.__name__: one for one in actions},
        "launch.conditions": {"IfCondition": IfCondition},
        "launch.launch_description_sources": {"PythonLaunchDescriptionSource": PythonLaunchDescriptionSource},
        "launch.substitutions": {one.__name__: one for one in substitutions},
        "launch_ros": {},
        "launch_ros.actions": {"Node": Node},
        "launch_ros.parameter_descriptions": {"ParameterValue": ParameterValue},
        "moveit_configs_utils": {"MoveItConfigsBuilder": partial(MoveItConfigsBuilder, context=context)},
    }
    with pytest.MonkeyPatch.context() as patch:
        for module, names in offered.items():
            made = ModuleType(module)
            vars(made).update(names)
            patch.setitem(sys.modules, module, made)
        scope: dict[str, Any] = {"__file__": str(path), "__name__": "launch_file"}
        exec(compile(text, str(path), "exec"), scope)  # noqa: S102 - it is our own text
        entities: list[Any] = scope["generate_launch_description"]()
    return entities


# XML and YAML

KNOWN = {
    "arg": {"name", "default", "description", "choice"},
    "node": {"pkg", "exec", "name", "namespace", "args", "ros_args", "output", "if", "unless", "param"},
    "include": {"file", "arg"},
    "param": {"name", "value", "from", "type"},
    "choice": {"value"},
    "arg of include": {"name", "value"},
}
CHILDREN = {"arg": "choice", "node": "param", "include": "arg"}


def _xml(text: str) -> list[Any]:
    root = ET.fromstring(text)
    assert root.tag == "launch"
    assert not root.attrib
    actions = []
    for element in root:
        assert not (element.text or "").strip()
        attributes: dict[str, Any] = dict(element.attrib)
        children = [dict(child.attrib) for child in element]
        assert all(child.tag == CHILDREN[element.tag] for child in element)
        attributes |= {CHILDREN[element.tag]: children} if children else {}
        actions.append(_action(element.tag, attributes))
    return actions


def _yaml(text: str) -> list[Any]:
    tree = yaml.safe_load(text)
    assert list(tree) == ["launch"]
    assert all(len(entity) == 1 for entity in tree["launch"])
    return [_action(*next(iter(entity.items()))) for entity in tree["launch"]]


def _action(tag: str, given: Mapping[str, Any]) -> Any:
    assert given.keys() <= KNOWN[tag], f"Unexpected attribute(s): {given}"
    attributes = dict(given)
    children = attributes.pop(CHILDREN[tag], [])
    kind = "arg of include" if tag == "include" else CHILDREN[tag]
    for child in children:
        assert child.keys() <= KNOWN[kind], f"Unexpected attribute(s): {child}"
    for one in (attributes, *children):
        assert all(isinstance(value, str) for value in one.values()), f"not all texts: {one}"
    return {"arg": _argument, "node": _node, "include": _include}[tag](attributes, children)


def _argument(attributes: Mapping[str, str], children: Sequence[Mapping[str, str]]) -> DeclareLaunchArgument:
    default: Any = parsed(attributes["default"]) if "default" in attributes else None
    if default is not None and all(isinstance(piece, Text) for piece in default):
        default = "".join(default)
    choices = [_escaped(child["value"]) for child in children] or None
    name, description = (_escaped(attributes[key]) for key in ("name", "description"))
    return DeclareLaunchArgument(name, default_value=default, description=description, choices=choices)


def _include(attributes: Mapping[str, str], children: Sequence[Mapping[str, str]]) -> IncludeLaunchDescription:
    given = [(child["name"], parsed(child["value"])) for child in children]
    return IncludeLaunchDescription(PythonLaunchDescriptionSource(parsed(attributes["file"])), launch_arguments=given)


def _node(attributes: Mapping[str, str], children: Sequence[Mapping[str, str]]) -> Node:
    parameters = {}
    for child in children:
        value: Any = parsed(child["value"])
        assert child.get("type", "str") == "str"
        parameters[child["name"]] = ParameterValue(value, value_type=str) if "type" in child else value
    return Node(
        package=parsed(attributes["pkg"]),
        executable=parsed(attributes["exec"]),
        **{key: parsed(attributes.get(key, "")) for key in ("name", "namespace")},
        arguments=split(parsed(attributes.get("args", ""))),
        parameters=[parameters],
        condition=IfCondition(parsed(attributes["if"])) if "if" in attributes else None,
    )


class Text(str):
    """Text of a launch file, its escapes read."""


def _escaped(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text)


def parsed(text: str) -> list[Any]:
    """Return a text of a frontend as pieces: texts and substitutions (``launch/frontend/grammar.lark``)."""
    pieces, end = _template(text, 0, "")
    assert end == len(text)
    return pieces


def _template(text: str, at: int, closing: str) -> tuple[list[Any], int]:
    pieces: list[Any] = []
    letters = ""
    while at < len(text) and not (closing and text[at] == closing):
        if text.startswith("$(", at):
            pieces += [Text(_escaped(letters))] if letters else []
            letters = ""
            substitution, at = _substitution(text, at)
            pieces.append(substitution)
            continue
        assert text[at] != "$", f"the grammar of substitutions has no bare $: {text}"
        step = 2 if text[at] == "\\" else 1
        letters += text[at : at + step]
        at += step
    return [*pieces, *([Text(_escaped(letters))] if letters else [])], at


def _substitution(text: str, at: int) -> tuple[Substitution, int]:
    """Return a substitution of Humble; what Jazzy alone has is none."""
    name = re.compile(r"\$\(([a-z][a-z_-]*)").match(text, at)
    assert name, f"no substitution: {text[at:]}"
    at = name.end()
    values: list[list[Any]] = []
    while text[at] == " ":
        value, at = _value(text, at + 1)
        assert value, f"one space is between arguments: {text}"
        values.append(value)
    assert text[at] == ")", f"the substitution ends nowhere: {text[at:]}"
    kinds: dict[str, Callable[..., Substitution]] = {
        "and": AndSubstitution,
        "or": OrSubstitution,
        "not": NotSubstitution,
        "command": Command,
        "find-pkg-share": FindPackageShare,
        "var": lambda name: LaunchConfiguration("".join(name)),
    }
    if name[1] not in kinds:
        pytest.fail(f"Unknown substitution: {name[1]}")
    return kinds[name[1]](*values), at + 1


def _value(text: str, at: int) -> tuple[list[Any], int]:
    if text[at] in "'\"":
        pieces, end = _template(text, at + 1, text[at])
        return pieces, end + 1
    pieces = []
    while text[at] not in " )":
        if text.startswith("$(", at):
            piece, at = _substitution(text, at)
        else:
            match = re.compile(r"""([^ '\\"$()]|\\.)+""").match(text, at)
            assert match, f"a letter that has to be quoted: {text[at:]}"
            piece, at = Text(_escaped(match[0])), match.end()
        pieces.append(piece)
    return pieces, at


def split(pieces: list[Any]) -> list[Any]:
    """Return a command line as its words: text is split as a shell does, results of substitutions stay whole."""
    words: list[list[Any]] = []
    is_open = False
    for piece in pieces:
        if isinstance(piece, Text):
            found, starts, ends = [[word] for word in shlex.split(piece)], piece[0].isspace(), piece[-1].isspace()
        else:
            found, starts, ends = [[piece]], False, False
        if found and is_open and not starts:
            words[-1] += found.pop(0)
        words += found
        is_open = not ends
    return words


# The command line of the static publisher


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

"""static_tf: a ROS 2 launch file for the publishers of all frames; static_tf_json: their arguments as JSON.

Each static transform has a ``static_transform_publisher`` with named flags (``ros2/geometry2@{humble,jazzy}:
tf2_ros/src/static_transform_broadcaster_program.cpp``); its Euler angles are fixed-axis, as in URDF. All other
frames are published by robot_state_publisher from the URDF. In launch files, ``and`` and ``or`` take two arguments and
``not`` one: ``ros2/launch@{humble,jazzy}: launch/launch/substitutions/boolean_substitution.py``.
"""

import ast
import json
import posixpath
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Output, Pose, Robot
from rosorin_compile.model.joint import Publisher
from rosorin_compile.model.link import Source
from rosorin_compile.model.robot import JointPose
from rosorin_compile.rules.case import Case, first_fed
from rosorin_compile.rules.publishers import combinations, holds, modes_in
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, error
from rosorin_compile.source.load import json_of, python_of
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, decimal, to_fixed
from rosorin_compile.source.xml.elements import number_of

from . import format
from .format import NODES, PLACES, Format, describe
from .templating import Templates

# Values of a mode that all launch substitutions accept. IfCondition rejects "on", and AndSubstitution rejects "1".
STATES = ("true", "false", "True", "False")

MODE, NOT, AND, OR, _IF = "mode", "not", "and", "or", "if"
_WIDTH = 99  # columns, as ament_flake8 requires
_PYTHON = {NOT: "NotSubstitution", AND: "AndSubstitution", OR: "OrSubstitution", _IF: "IfCondition"}

# (MODE, name), (NOT, a), (AND, a, b), (OR, a, b), ALWAYS or NEVER, where a and b are conditions
Condition = tuple[Any, ...]
ALWAYS, NEVER = ("true",), ("false",)

_XYZ, _RPY = ("--x", "--y", "--z"), ("--roll", "--pitch", "--yaw")
_FRAMES = _PARENT, _CHILD = "--frame-id", "--child-frame-id"
_URDF_FILE, FRAME_PREFIX = "urdf_file", "frame_prefix"
# Arguments that every generated launch file has, with their help.
ARGUMENTS = {
    "namespace": "the namespace of the nodes, such as left; empty: none",
    FRAME_PREFIX: "what stands before the name of each frame, such as left/; empty: nothing",
}
_EXECUTABLE = f"executable='{STATIC_TRANSFORM_PUBLISHER}',"
_NODE = re.compile(rf"{_EXECUTABLE}\s+name=(.*),\s+namespace=.*\s+arguments=\[\n((?:.*\n)*?)\s+\],")
# Largest rounding errors (m, rad) of printed numbers, except with ``number_format: exact``.
ROUNDING = (0.5 * 10.0**-METRE_DIGITS, 0.5 * 10.0**-RADIAN_DIGITS)


class StaticTransform(NamedTuple):
    """A static_transform_publisher: the name of its node, its frames, and its command line arguments."""

    name: str
    parent: str
    child: str
    arguments: tuple[str, ...]
    source: Source
    when: str = ""  # condition for starting the node, such as "not slam", or "" for always

    @property
    def edge(self) -> Edge:
        """The transform that the node publishes, with the rounded numbers of its arguments."""
        return replace(read_arguments(self.name, list(self.arguments)), when=self.when)

    def words(self) -> Iterator[tuple[str, str, bool]]:
        """Yield each flag with its value, and True if the value is the name of a frame."""
        for flag, value in zip(self.arguments[::2], self.arguments[1::2], strict=True):
            yield flag, value, flag in _FRAMES

    def in_python(self) -> Iterator[tuple[str, str]]:
        """Yield each flag with its value as a Python expression, which adds the frame prefix to frame names."""
        for flag, value, is_frame in self.words():
            yield flag, f"[{FRAME_PREFIX}, {value!r}]" if is_frame else repr(value)


@dataclass(frozen=True)
class FrameTable:
    """The transforms in an artifact, and the joint positions of its named poses."""

    frames: tuple[Edge, ...]
    poses: tuple[JointPose, ...] = ()


StaticTransforms = tuple[list[StaticTransform], list[StaticTransform], list[Diagnostic]]


def static_transforms(robot: Robot, outputs: Iterable[Output] = ()) -> StaticTransforms:
    """Return the static_transform_publisher nodes that always run, the nodes for some modes, and diagnostics."""
    is_exact = any(output.options.get("number_format") == "exact" for output in outputs)
    always, in_modes, diagnostics = list[StaticTransform](), list[StaticTransform](), list[Diagnostic]()
    edges: list[tuple[Joint, Joint | Edge, str]] = []
    for joint in robot.published_by(STATIC_TRANSFORM_PUBLISHER):
        edges += [(joint, joint, "")] if joint.type == "fixed" else []
        if joint.type != "fixed":
            message = f"joint {joint.name} is {joint.type}, but static_transform_publisher only says what never moves"
            diagnostics.append(error("static-tf-moves", message, None, "let robot_state_publisher publish it"))
    turns = (edge for edge in robot.edges if edge.joint and edge.publisher.kind == STATIC_TRANSFORM_PUBLISHER)
    edges += ((robot.joint[edge.joint], edge, edge.when) for edge in turns)
    for joint, published, when in edges:
        arguments: list[str] = []
        for flag, value in zip((*_XYZ, *_RPY), (*joint.origin.xyz, *joint.origin.rpy), strict=True):
            digits = METRE_DIGITS if flag in _XYZ else RADIAN_DIGITS
            arguments += [flag, decimal(value) if is_exact else to_fixed(value, digits)]
        arguments += [_PARENT, joint.parent, _CHILD, joint.child]
        name, ends = published.publisher.name, (published.parent, published.child)
        one = StaticTransform(name, *ends, tuple(arguments), published.source, when)
        (in_modes if modes_in(robot, [when]) else always).append(one)
    return always, in_modes, diagnostics


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return a launch file that publishes static transforms, and runs robot_state_publisher if a URDF is generated."""
    from . import FORMATS

    always, in_modes, diagnostics = static_transforms(robot, [output])
    urdf, statics = first_fed(robot, ROBOT_STATE_PUBLISHER, FORMATS), [*always, *in_modes]
    moved = robot.published_by(ROBOT_STATE_PUBLISHER)
    if urdf is None and moved:
        message = f"robot_state_publisher is to publish {len(moved)} joints, but no output is the URDF that it reads"
        help = "add an output with the backend urdf"
        diagnostics.append(Diagnostic("static-tf-no-urdf", WARNING, message, help=help))
    modes = free_names(modes_in(robot, [one.when for one in in_modes]), (_URDF_FILE, *ARGUMENTS), "mode_")
    conditions = {one.when: condition(robot, one.when) for one in in_modes}
    declared: list[tuple[str, str, str, tuple[str, ...]]] = []  # (name, default as Python code, help, choices)
    if urdf is not None:
        place = posixpath.relpath(urdf.file, posixpath.dirname(output.file) or ".")
        help = "URDF file that robot_state_publisher publishes"
        declared.append((_URDF_FILE, f"str(Path(__file__).parent / {place!r})", help, ()))
    if urdf is not None or statics:
        declared += [(name, "''", help, ()) for name, help in ARGUMENTS.items()]
    declared += [(name, "'false'", f"the robot is run in the mode {mode}", STATES) for mode, name in modes.items()]
    wrap = textwrap.TextWrapper(84, expand_tabs=False, replace_whitespace=False, break_long_words=False)
    wrap.break_on_hyphens = False
    values: dict[str, Any] = {"robot": robot, "urdf": urdf, "statics": statics, "declared": declared, "modes": modes}
    values |= {"literal": repr, "pairs": StaticTransform.in_python}
    values["source"] = lambda source: wrap.wrap(describe(source))
    values["conditions"] = {when: if_condition(one, modes, 12) for when, one in conditions.items()}
    values["imports"] = import_substitutions(conditions.values(), "LaunchConfiguration")
    values["publisher"] = moved[0].publisher.name if moved else ROBOT_STATE_PUBLISHER
    return templates.own("core/static_tf.launch.py.jinja", values), diagnostics


def view(robot: Robot, output: Output) -> FrameTable:
    """Return the transforms that an artifact must contain; conditions are only in static_tf_json."""
    always, in_modes, _ = static_transforms(robot, [output])
    has_conditions = output.backend == LIST.name
    return FrameTable(tuple(replace(one.edge, when=one.when if has_conditions else "") for one in (*always, *in_modes)))


def read(text: str) -> FrameTable:
    """Parse the transforms of a launch file, without running it. Raises ValueError if it is damaged."""
    default = re.search(rf"'{FRAME_PREFIX}',\s+default_value=(.*),", text)
    is_declared = default is not None and f"{FRAME_PREFIX} = LaunchConfiguration('{FRAME_PREFIX}')" in text
    nodes, edges = _NODE.findall(text), list[Edge]()
    try:
        python_of(text)
        if len(nodes) != text.count(_EXECUTABLE) or (nodes and not is_declared):
            raise ValueError("a node has no name, no arguments, or a part that is neither text nor a launch argument")
        for name, body in nodes:
            body = body.replace(f"[{FRAME_PREFIX},", f"[{default[1] if default else ''},")
            words = ast.literal_eval(f"[{body}]")
            words = ["".join(word) if isinstance(word, list) else word for word in words]
            edges.append(read_arguments(ast.literal_eval(name), words))
    except (TypeError, SyntaxError) as problem:
        raise ValueError(f"not Python with plain values: {problem}") from None
    return FrameTable(tuple(edges))


def read_arguments(name: object, arguments: object) -> Edge:
    """Parse the arguments of a static_transform_publisher. Raises ValueError if flags are missing or unknown."""
    if not isinstance(name, str) or not isinstance(arguments, list) or not all(isinstance(a, str) for a in arguments):
        raise ValueError("a static_transform_publisher has a name that is not text or arguments that are not texts")
    given = dict(zip(arguments[::2], arguments[1::2], strict=False))
    if given.keys() != {*_XYZ, *_RPY, _PARENT, _CHILD} or len(arguments) != 2 * len(given):
        raise ValueError(f"{name} has the arguments {' '.join(arguments)}")
    x, y, z, roll, pitch, yaw = (number_of(given[flag]) for flag in (*_XYZ, *_RPY))
    publisher = Publisher(STATIC_TRANSFORM_PUBLISHER, name)
    return Edge(given[_PARENT], given[_CHILD], publisher, moving=False, pose=Pose((x, y, z), (roll, pitch, yaw)))


def check_numbers(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield an error for a ``number_format`` other than "exact", which this format does not support."""
    if output.options.get("number_format", "exact") != "exact":
        message = f'the format "{output.backend}" does not support "number_format: {output.options["number_format"]}"'
        help = 'write "exact", or remove the key (default: 7 decimals for metres, 8 for radians)'
        yield case.problem("number-format", message, ("outputs", output.name, "number_format"), help)


_DIGITS = "exact: full precision; default: 7 decimals for metres, 8 for radians."
FORMAT = Format(
    name="static_tf",
    word="launch file of static transforms",
    article="a",
    about="the launch file of the static transforms",
    rank=40,
    covers=("robot", *PLACES, *NODES),
    options={"number_format": {**format.NUMBER_FORMAT, "description": _DIGITS}},
    check=check_numbers,
    file="static_tf.launch.py",
    endings=(".py",),
    write=write,
    view=view,
    read=read,
    rounding=ROUNDING,
    located=True,
    syntax=lambda text: ast.dump(python_of(text)),
    feeds=(STATIC_TRANSFORM_PUBLISHER,),
    folder="launch",
    deploys=True,
)


def write_list(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the static transforms of a robot as JSON, and diagnostics. Option: ``number_format``."""
    always, in_modes, diagnostics = static_transforms(robot, [output])
    nodes: list[dict[str, Any]] = []
    for one in [*always, *in_modes]:
        node: dict[str, Any] = {"name": one.name, "parent": one.parent, "child": one.child}
        node |= {"stand_in": describe(one.source)} if one.source.status == "stand_in" else {}
        node |= {"when": one.when} if one.when else {}
        nodes.append({**node, "arguments": list(one.arguments)})
    return json.dumps({"robot": robot.name, "static_transform_publisher": nodes}, indent=2) + "\n", diagnostics


def read_list(text: str) -> FrameTable:
    """Parse the transforms of a static_tf_json file. Raises ValueError if it is damaged."""
    edges = []
    try:
        for node in json_of(text)["static_transform_publisher"]:
            edge = replace(read_arguments(node["name"], node["arguments"]), when=str(node.get("when", "")))
            if (node["parent"], node["child"]) != (edge.parent, edge.child):
                ends = f"from {node['parent']} to {node['child']}"
                raise ValueError(f"{node['name']} goes {ends}, its arguments from {edge.parent} to {edge.child}")
            edges.append(edge)
    except (KeyError, TypeError, AttributeError) as problem:
        raise ValueError(f"not a list of static transforms: {problem!r}") from None
    return FrameTable(tuple(edges))


def robot_of(path: Path) -> str:
    """Return the name of the robot in a static_tf_json file, or "" for any other file. Raises OSError."""
    try:
        content = json_of(files.read_bytes(path, 1_000_000))
    except ValueError:
        return ""
    robot = content.get("robot") if isinstance(content, dict) and "static_transform_publisher" in content else None
    return robot if isinstance(robot, str) else ""


# static_tf_json: the arguments of the nodes, for existing launch files (``schemas/static_tf.schema.json``).
LIST = replace(
    FORMAT,
    name="static_tf_json",
    word="list of static transforms",
    about="the arguments of the static transforms, for launch files of your own",
    rank=50,
    file="static_tf.json",
    endings=(".json",),
    write=write_list,
    read=read_list,
    located=False,
    syntax=json_of,
    schema="static_tf",
    folder="config",
    robot_of=robot_of,
)


def free_names(names: Iterable[str], taken: Iterable[str], before: str) -> dict[str, str]:
    """Map each name to an unused launch argument: the same name, or with the prefix ``before`` if it is ``taken``."""
    names, taken = list(names), set(taken)
    free = {name: name for name in names if name not in taken}
    for name in names:
        argument = name
        while name not in free and argument in {*taken, *free.values()}:
            argument = f"{before}{argument}"
        free.setdefault(name, argument)
    return {name: free[name] for name in names}


def condition(robot: Robot, when: str) -> Condition:
    """Convert a condition such as "slam and not rviz" to nested binary operators (Shannon expansion)."""
    modes = modes_in(robot, [when])
    table = {tuple(states.values()): holds(when, states) for states in combinations(modes)}

    def decide(states: tuple[bool, ...]) -> Condition:
        if len(states) == len(modes):
            return ALWAYS if table[states] else NEVER
        mode: Condition = (MODE, modes[len(states)])
        off, on, inverse = decide((*states, False)), decide((*states, True)), (NOT, mode)
        if off == on:
            return off
        if {off, on} == {ALWAYS, NEVER}:
            return mode if on == ALWAYS else inverse
        if on in (ALWAYS, NEVER):
            return (OR, mode, off) if on == ALWAYS else (AND, inverse, off)
        if off in (ALWAYS, NEVER):
            return (OR, inverse, on) if off == ALWAYS else (AND, mode, on)
        return (OR, (AND, mode, on), (AND, inverse, off))

    return decide(())


def in_frontends(condition: Condition, arguments: Mapping[str, str]) -> str:
    """Format a condition for XML and YAML launch files, such as "$(and $(var slam) $(not $(var rviz)))"."""
    word, *operands = condition
    if word == MODE:
        return f"$(var {arguments[operands[0]]})"
    words = " ".join(in_frontends(operand, arguments) for operand in operands)
    return f"$({word} {words})" if operands else str(word)


def in_python(condition: Condition, arguments: Mapping[str, str], indent: int, before: int = 0) -> str:
    """Format a condition as a Python expression that starts at column ``indent + before``, wrapped if too long."""
    word, *operands = condition
    if word == MODE or not operands:
        return f"LaunchConfiguration({arguments[operands[0]]!r})" if operands else repr(word)
    line = f"{_PYTHON[word]}({', '.join(in_python(operand, arguments, 0) for operand in operands)})"
    if "\n" not in line and indent + before + len(line) < _WIDTH:
        return line
    comma = "" if word == _IF else ","
    lines = [f"{' ' * (indent + 4)}{in_python(operand, arguments, indent + 4)}{comma}" for operand in operands]
    return "\n".join([f"{_PYTHON[word]}(", *lines, f"{' ' * indent})"])


def if_condition(condition: Condition, arguments: Mapping[str, str], indent: int) -> str:
    """Format the argument ``condition`` of a node as Python code; ``indent`` is its indentation."""
    return in_python((_IF, condition), arguments, indent, len("condition="))


def import_substitutions(conditions: Iterable[Condition], *more: str) -> str:
    """Return a Python import statement for the substitutions that conditions use, and for ``more``."""
    names, waiting = set(more), list(conditions)
    while waiting:
        word, *operands = waiting.pop()
        names |= {_PYTHON[word]} if word in _PYTHON else set()
        waiting += operands if word in _PYTHON else []
    line = f"from launch.substitutions import {', '.join(sorted(names))}"
    if len(line) <= _WIDTH:
        return line
    return "\n".join(["from launch.substitutions import (", *(f"    {name}," for name in sorted(names)), ")"])

"""static_tf: a ROS 2 launch file that starts the publishers of the frames, and static_tf_json: their arguments.

Each static edge is one ``static_transform_publisher`` with named flags (``ros2/geometry2@{humble,jazzy}:
tf2_ros/src/static_transform_broadcaster_program.cpp``); its Euler angles are fixed-axis, as those of URDF. The rest of
the frames is published by robot_state_publisher from the URDF.
"""

from __future__ import annotations

import json
import posixpath
import re
import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Output, Pose, Robot
from rosorin_compile.model.joint import Publisher
from rosorin_compile.model.link import Source
from rosorin_compile.rules.case import first_fed
from rosorin_compile.rules.publishers import modes_in
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, error
from rosorin_compile.source.load import json_of, python_of
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, decimal, fixed
from rosorin_compile.source.rule_registry import FORMATS, OUTPUTS, Rule
from rosorin_compile.source.wording import masked
from rosorin_compile.source.xml.elements import number_of

from . import format
from .format import Format
from .launch_conditions import STATES, condition, if_condition, import_substitutions, mode_arguments
from .unsupported import NODES, PLACES

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case

    from .templating import Templates

_SIX = "`number_format: six` for arguments of static_transform_publisher."
_NO_URDF = "A warning: robot_state_publisher is to publish joints, but no output is the URDF that it reads."
RULES = (
    Rule("number-format", _SIX, "`exact`, or leave it out.", OUTPUTS),
    Rule("static-tf-no-urdf", _NO_URDF, "Add an output with the backend `urdf`.", FORMATS),
)

_XYZ, _RPY = ("--x", "--y", "--z"), ("--roll", "--pitch", "--yaw")
_FRAMES = _PARENT, _CHILD = "--frame-id", "--child-frame-id"
_URDF_FILE, FRAME_PREFIX = "urdf_file", "frame_prefix"
# The arguments that every launch file of this program has, with their help.
ARGUMENTS = {
    "namespace": "the namespace of the nodes, such as left; empty: none",
    FRAME_PREFIX: "what stands before the name of each frame, such as left/; empty: nothing",
}
_EXECUTABLE = f"executable='{STATIC_TRANSFORM_PUBLISHER}',"
_NODE = re.compile(rf"{_EXECUTABLE}\s+name=(.*),\s+namespace=.*\s+arguments=\[\n((?:.*\n)*?)\s+\],")
# Numbers are printed with these decimals, or all digits with number_format exact.
ROUNDING = (0.5 * 10.0**-METRE_DIGITS, 0.5 * 10.0**-RADIAN_DIGITS)


class StaticTransform(NamedTuple):
    """One static_transform_publisher: the name of its node, its frames, and its command line arguments."""

    name: str
    parent: str
    child: str
    arguments: tuple[str, ...]
    source: Source
    when: str = ""  # the condition over modes under which it is started, empty for always

    @property
    def edge(self) -> Edge:
        """The transform with the digits that are printed."""
        return replace(read_arguments(self.name, list(self.arguments)), when=self.when)

    def words(self) -> Iterator[tuple[str, str, bool]]:
        """Yield the arguments in pairs: the flag, the value, and whether that is the name of a frame."""
        for flag, value in zip(self.arguments[::2], self.arguments[1::2], strict=True):
            yield flag, value, flag in _FRAMES

    def in_python(self) -> Iterator[tuple[str, str]]:
        """Yield the arguments in pairs: the flag, and the value as Python; frames have the prefix."""
        for flag, value, is_frame in self.words():
            yield flag, f"[{FRAME_PREFIX}, {value!r}]" if is_frame else repr(value)


@dataclass(frozen=True)
class Transforms:
    """The contents of a file of static transforms."""

    frames: tuple[Edge, ...]


class StaticTransforms(NamedTuple):
    """The transforms of static_transform_publisher nodes: those that always hold, and those of some modes."""

    always: list[StaticTransform]
    in_modes: list[StaticTransform]
    diagnostics: list[Diagnostic]  # about joints that none of these nodes can publish


def static_transforms(robot: Robot, outputs: Iterable[Output] = ()) -> StaticTransforms:
    """Return the edges that static_transform_publisher nodes publish: joints in their order, then edges in turns."""
    is_exact, found = any(one.options.get("number_format") == "exact" for one in outputs), StaticTransforms([], [], [])
    edges: list[tuple[Joint, Joint | Edge, str]] = []
    for joint in robot.published_by(STATIC_TRANSFORM_PUBLISHER):
        if joint.type == "fixed":
            edges.append((joint, joint, ""))
            continue
        message = f"joint {joint.name} is {joint.type}, but a static_transform_publisher can only say what never moves"
        found.diagnostics.append(error("static-tf-moves", message, None, "let robot_state_publisher publish it"))
    turns = (edge for edge in robot.edges if edge.joint and edge.publisher.kind == STATIC_TRANSFORM_PUBLISHER)
    edges += ((robot.joint[edge.joint], edge, edge.when) for edge in turns)
    for joint, published, when in edges:
        arguments: list[str] = []
        axes = (_XYZ, joint.origin.xyz, METRE_DIGITS), (_RPY, joint.origin.rpy, RADIAN_DIGITS)
        for flags, values, digits in axes:
            for flag, value in zip(flags, values, strict=True):
                arguments += [flag, decimal(value) if is_exact else fixed(value, digits)]
        arguments += [_PARENT, joint.parent, _CHILD, joint.child]
        ends = published.parent, published.child
        one = StaticTransform(published.publisher.name, *ends, tuple(arguments), published.source, when)
        (found.in_modes if modes_in(robot, [when]) else found.always).append(one)
    return found


def describe(source: Source) -> str:
    """Return where a value comes from as one line of printable text; empty if the description does not say."""
    head = ", ".join(part for part in (source.status.replace("_", "-"), source.measured) if part)
    text = ": ".join(part for part in (head, source.note) if part)
    return masked(" ".join(text.split()))


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the launch file of a robot, with robot_state_publisher if an output is a URDF."""
    from . import FORMATS

    always, in_modes, diagnostics = static_transforms(robot, [output])
    urdf, statics = first_fed(robot, ROBOT_STATE_PUBLISHER, FORMATS), [*always, *in_modes]
    moved = robot.published_by(ROBOT_STATE_PUBLISHER)
    if urdf is None and moved:
        message = f"robot_state_publisher is to publish {len(moved)} joints, but no output is the URDF that it reads"
        help = "add an output with the backend urdf"
        diagnostics.append(Diagnostic("static-tf-no-urdf", WARNING, message, help=help))
    modes = mode_arguments(robot, [one.when for one in in_modes], (_URDF_FILE, *ARGUMENTS))
    conditions = {one.when: condition(robot, one.when) for one in in_modes}
    declared: list[tuple[str, str, str, tuple[str, ...]]] = []  # name, default as Python, help, choices
    if urdf is not None:
        place = posixpath.relpath(urdf.file, posixpath.dirname(output.file) or ".")
        help = "URDF file that robot_state_publisher publishes"
        declared.append((_URDF_FILE, f"str(Path(__file__).parent / {place!r})", help, ()))
    if urdf is not None or statics:
        declared += [(name, "''", help, ()) for name, help in ARGUMENTS.items()]
    declared += [(name, "'false'", f"the robot is run in the mode {mode}", STATES) for mode, name in modes.items()]
    wrap = textwrap.TextWrapper(84, expand_tabs=False, replace_whitespace=False, break_long_words=False)
    wrap.break_on_hyphens = False
    values: dict[str, Any] = {
        "robot": robot,
        "urdf": urdf,
        "statics": statics,
        "declared": declared,
        "modes": modes,
        "conditions": {when: if_condition(one, modes, 12) for when, one in conditions.items()},
        "imports": import_substitutions(conditions.values(), "LaunchConfiguration"),
        "publisher": moved[0].publisher.name if moved else ROBOT_STATE_PUBLISHER,
        "literal": repr,
        "source": lambda source: wrap.wrap(describe(source)),
        "pairs": StaticTransform.in_python,
    }
    return templates.own("core/static_tf.launch.py.jinja", values), diagnostics


def view(robot: Robot, output: Output) -> Transforms:
    """Return what a file of static transforms must contain; conditions are not read back from Python."""
    always, in_modes, _ = static_transforms(robot, [output])
    has_conditions = output.backend == LIST.name
    return Transforms(tuple(replace(one.edge, when=one.when if has_conditions else "") for one in (*always, *in_modes)))


def read(text: str) -> Transforms:
    """Return the transforms of a launch file, which is parsed, never run. Raises ValueError for a damaged one."""
    import ast

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
    return Transforms(tuple(edges))


def read_arguments(name: object, arguments: object) -> Edge:
    """Return the transform of one static_transform_publisher. Raises ValueError for other than our arguments."""
    if not isinstance(name, str) or not isinstance(arguments, list) or not all(isinstance(a, str) for a in arguments):
        raise ValueError("a static_transform_publisher has a name that is no text or arguments that are no texts")
    if len(arguments) % 2:
        raise ValueError(f"the arguments of {name} are not flags with one text each")
    given = dict(zip(arguments[::2], arguments[1::2], strict=True))
    if given.keys() != {*_XYZ, *_RPY, _PARENT, _CHILD}:
        raise ValueError(f"the flags of {name} are {', '.join(given)}")
    x, y, z, roll, pitch, yaw = (number_of(given[flag]) for flag in (*_XYZ, *_RPY))
    publisher = Publisher(STATIC_TRANSFORM_PUBLISHER, name)
    return Edge(given[_PARENT], given[_CHILD], publisher, moving=False, pose=Pose((x, y, z), (roll, pitch, yaw)))


def check_numbers(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield an error if arguments of a program would be printed as six digits, which may have an exponent."""
    if output.options.get("number_format", "exact") != "exact":
        message = f'the backend "{output.backend}" does not print numbers as {output.options["number_format"]}'
        help = "write exact, or leave it out: 7 decimals of metres, 8 of radians"
        yield case.problem("number-format", message, ("outputs", output.name, "number_format"), help)


def _syntax(text: str) -> str:
    import ast

    return ast.dump(python_of(text))


_DIGITS = "exact: to the last digit; left out: 7 decimals of metres and 8 of radians."
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
    syntax=_syntax,
    feeds=(STATIC_TRANSFORM_PUBLISHER,),
    folder="launch",
    deploys=True,
)


def write_list(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the static edges of a robot as JSON, in the order of the description. Option: ``number_format``."""
    always, in_modes, diagnostics = static_transforms(robot, [output])
    nodes: list[dict[str, Any]] = []
    for one in [*always, *in_modes]:
        node: dict[str, Any] = {"name": one.name, "parent": one.parent, "child": one.child}
        node |= {"stand_in": describe(one.source)} if one.source.status == "stand_in" else {}
        node |= {"when": one.when} if one.when else {}
        nodes.append({**node, "arguments": list(one.arguments)})
    return json.dumps({"robot": robot.name, "static_transform_publisher": nodes}, indent=2) + "\n", diagnostics


def read_list(text: str) -> Transforms:
    """Return the transforms of a list. Raises ValueError if the text is not such a file."""
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
    return Transforms(tuple(edges))


def robot_of(path: Path) -> str:
    """Return the robot that a list was generated for; empty if it is no such file. Raises OSError."""
    try:
        content = json_of(files.read_bytes(path, 1_000_000))
    except ValueError:
        return ""
    robot = content.get("robot") if isinstance(content, dict) and "static_transform_publisher" in content else None
    return robot if isinstance(robot, str) else ""


# The arguments of the nodes as data, for launch files that exist already: ``schemas/static_tf.schema.json``.
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

"""static_tf: a ROS 2 launch file that starts the publishers of the frames, for Humble and Jazzy.

Each static edge is one ``static_transform_publisher`` with named flags (``ros2/geometry2@{humble,jazzy}:
tf2_ros/src/static_transform_broadcaster_program.cpp``); its Euler angles are fixed-axis, as those of URDF. The rest of
the frames is published by robot_state_publisher from the URDF.
"""

from __future__ import annotations

import posixpath
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Output, Pose, Robot
from rosorin_compile.model.joint import Publisher
from rosorin_compile.model.link import Source
from rosorin_compile.rules.case import first_fed
from rosorin_compile.rules.publishers import modes_in
from rosorin_compile.source.bounded import python_of
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, error
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, NumberFormat, decimal, fixed
from rosorin_compile.source.rule_registry import FORMATS, OUTPUTS, Rule
from rosorin_compile.source.wording import masked
from rosorin_compile.source.xml.elements import number_of

from . import format
from .format import Format
from .unsupported import NODES, PLACES

if TYPE_CHECKING:
    import ast

    from rosorin_compile.rules.case import Case

    from .templating import Templates

RULES = (
    Rule(
        "number-format",
        "`number_format: six` for arguments of static_transform_publisher.",
        "`exact`, or leave it out.",
        OUTPUTS,
    ),
    Rule(
        "static-tf-no-urdf",
        "A warning: robot_state_publisher is to publish joints, but no output is the URDF that it reads.",
        "Add an output with the backend `urdf`.",
        FORMATS,
    ),
)

_XYZ = ("--x", "--y", "--z")
_RPY = ("--roll", "--pitch", "--yaw")
_URDF_FILE = "urdf_file"  # a launch argument of ours
FRAME_PREFIX = "frame_prefix"
# The arguments that every launch file of ours has, with their help.
ARGUMENTS = {
    "namespace": "the namespace of the nodes, such as left; empty: none",
    FRAME_PREFIX: "what stands before the name of each frame, such as left/; empty: nothing",
}
_FRAMES = _PARENT, _CHILD = "--frame-id", "--child-frame-id"


class Numbers(NamedTuple):
    """How arguments are printed: metres and radians, both without an exponent."""

    metres: NumberFormat
    radians: NumberFormat


# As people write them into launch files; and to the last digit, for number_format exact.
ROUNDED = Numbers(partial(fixed, digits=METRE_DIGITS), partial(fixed, digits=RADIAN_DIGITS))
EXACT = Numbers(decimal, decimal)
ROUNDING = (0.5 * 10.0**-METRE_DIGITS, 0.5 * 10.0**-RADIAN_DIGITS)


class StaticTransform(NamedTuple):
    """One static_transform_publisher: the name of its node, its frames, and its command line arguments.

    ``when`` is the condition over modes under which it is started, empty for always.
    """

    name: str
    parent: str
    child: str
    arguments: tuple[str, ...]
    source: Source
    when: str = ""

    @staticmethod
    def published(robot: Robot, outputs: Iterable[Output] = ()) -> StaticTransforms:
        """Return what static_transform_publisher nodes publish: always, and in some modes.

        Numbers are printed to the last digit if one of the outputs asks for it.
        """
        return static_transforms(robot, outputs)

    @staticmethod
    def number(value: float, angle: bool = False, digits: int | None = None) -> str:
        """Return a length (m) or an angle (rad) with as many decimals as in launch files, or with other ``digits``."""
        return fixed(value, digits or (RADIAN_DIGITS if angle else METRE_DIGITS))

    @staticmethod
    def launch_arguments() -> Mapping[str, str]:
        """Return the arguments that every launch file of ours has, with their help."""
        return ARGUMENTS

    def words(self) -> Iterator[tuple[str, str, bool]]:
        """Yield the arguments in pairs: the flag, the value, and whether that is the name of a frame."""
        for flag, value in zip(self.arguments[::2], self.arguments[1::2], strict=True):
            yield flag, value, flag in _FRAMES

    def in_python(self) -> Iterator[tuple[str, str]]:
        """Yield the arguments in pairs: the flag, and the value as Python; frames have the prefix."""
        for flag, value, is_frame in self.words():
            yield flag, f"[{FRAME_PREFIX}, {value!r}]" if is_frame else repr(value)

    def described(self) -> str:
        """Return where its numbers come from as one line of printable text; empty if nobody says."""
        return describe(self.source)


@dataclass(frozen=True)
class Transforms:
    """What a file of static transforms contains."""

    frames: tuple[Edge, ...]


class StaticTransforms(NamedTuple):
    """What static_transform_publisher nodes publish: always, joints in their order, then turns; in some modes alone.

    ``diagnostics`` say which joints none of them can publish.
    """

    always: list[StaticTransform]
    in_modes: list[StaticTransform]
    diagnostics: list[Diagnostic]


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the launch file of a robot. Option: ``number_format`` (exact; left out: 7 and 8 decimals).

    robot_state_publisher is started if an output is a URDF. Its file is looked for where it stands from the launch file
    in the outputs folder; the launch argument ``urdf_file`` names another. Modes on which a static publisher depends
    are launch arguments, and so are ``namespace`` and ``frame_prefix``, which let two robots run side by side.
    """
    transforms, in_modes, diagnostics = static_transforms(robot, [output])
    urdf = _urdf_file(robot)
    moved = robot.published_by(ROBOT_STATE_PUBLISHER)
    if urdf is None and moved:
        message = f"robot_state_publisher is to publish {len(moved)} joints, but no output is the URDF that it reads"
        diagnostics.append(
            Diagnostic("static-tf-no-urdf", WARNING, message, help="add an output with the backend urdf")
        )
    values: dict[str, Any] = {"robot": robot, "statics": [*transforms, *in_modes], "literal": repr, "source": _source}
    values |= {"pairs": StaticTransform.in_python, **_of_modes(robot, in_modes)}
    values["urdf"] = urdf and posixpath.relpath(urdf, posixpath.dirname(output.file) or ".")
    values["declared"] = list(_declared(values))
    values["publisher"] = moved[0].publisher.name if moved else ROBOT_STATE_PUBLISHER
    return templates.own("core/static_tf.launch.py.jinja", values), diagnostics


def _declared(values: Mapping[str, Any]) -> Iterator[tuple[str, str, str, Sequence[str]]]:
    """Yield the arguments of the launch file: name, default as Python, help, choices."""
    urdf = values["urdf"]
    if urdf:
        default = f"str(Path(__file__).parent / {urdf!r})"
        yield _URDF_FILE, default, "URDF file that robot_state_publisher publishes", ()
    for name, help in ARGUMENTS.items() if urdf or values["statics"] else ():
        yield name, "''", help, ()
    for mode, name in values["modes"].items():
        yield name, "'false'", f"the robot is run in the mode {mode}", values["states"]


def _source(source: Source) -> list[str]:
    """Return the lines of a comment that says where numbers are from; none where nobody says."""
    told = describe(source)
    if not told:
        return []
    wrap = textwrap.TextWrapper(84, expand_tabs=False, replace_whitespace=False, break_long_words=False)
    wrap.break_on_hyphens = False
    return [wrapped for line in told.splitlines() for wrapped in wrap.wrap(line) or [""]]


def _of_modes(robot: Robot, in_modes: Sequence[StaticTransform]) -> dict[str, Any]:
    """Return what a launch file says of modes: their arguments, and the condition of each node as Python."""
    configuration = "LaunchConfiguration"
    if not in_modes:
        return {"modes": {}, "conditions": {}, "imports": f"from launch.substitutions import {configuration}"}
    from . import launching

    modes = launching.mode_arguments(robot, in_modes, (_URDF_FILE, *ARGUMENTS))
    read = {one.when: launching.condition(robot, one.when) for one in in_modes}
    return {
        "modes": modes,
        "states": list(launching.STATES),
        "conditions": {when: launching.if_condition(one, modes, 12) for when, one in read.items()},
        "imports": launching.imported("launch.substitutions", launching.substitutions(read.values(), configuration)),
    }


def _urdf_file(robot: Robot) -> str | None:
    """Return the first file among the outputs that robot_state_publisher reads."""
    from . import FORMATS

    output = first_fed(robot, ROBOT_STATE_PUBLISHER, FORMATS)
    return output.file if output is not None else None


def static_transforms(robot: Robot, outputs: Iterable[Output] = ()) -> StaticTransforms:
    """Return the edges that static_transform_publisher nodes publish.

    Numbers are printed to the last digit if one of the outputs asks for it.
    """
    is_exact = any(output.options.get("number_format") == "exact" for output in outputs)
    numbers = EXACT if is_exact else ROUNDED
    transforms, diagnostics = [], []
    for joint in robot.published_by(STATIC_TRANSFORM_PUBLISHER):
        if joint.type == "fixed":
            name, arguments = joint.publisher.name, _arguments(joint, numbers)
            transforms.append(StaticTransform(name, joint.parent, joint.child, arguments, joint.source))
            continue
        message = f"joint {joint.name} is {joint.type}, but a static_transform_publisher can only say what never moves"
        diagnostics.append(error("static-tf-moves", message, None, "let robot_state_publisher publish it"))
    in_modes: list[StaticTransform] = []
    for turn in _turns(robot, numbers):
        (in_modes if modes_in(robot, [turn.when]) else transforms).append(turn)
    return StaticTransforms(transforms, in_modes, diagnostics)


def _turns(robot: Robot, numbers: Numbers) -> Iterator[StaticTransform]:
    for edge in robot.edges:
        if edge.joint and edge.publisher.kind == STATIC_TRANSFORM_PUBLISHER:
            arguments = _arguments(robot.joint[edge.joint], numbers)
            yield StaticTransform(edge.publisher.name, edge.parent, edge.child, arguments, edge.source, edge.when)


def describe(source: Source) -> str:
    """Return where a value comes from as one line of printable text; empty if the description does not say."""
    head = ", ".join(part for part in (source.status.replace("_", "-"), source.measured) if part)
    text = ": ".join(part for part in (head, source.note) if part)
    return masked(" ".join(text.split()))


def _arguments(joint: Joint, numbers: Numbers) -> tuple[str, ...]:
    arguments: list[str] = []
    for flags, values, number in ((_XYZ, joint.origin.xyz, numbers.metres), (_RPY, joint.origin.rpy, numbers.radians)):
        for flag, value in zip(flags, values, strict=True):
            arguments += [flag, number(value)]
    return (*arguments, _PARENT, joint.parent, _CHILD, joint.child)


def view(robot: Robot, output: Output) -> Transforms:
    """Return what a launch file of static transforms is meant to contain."""
    return transforms_of(robot, output, with_conditions=False)


def transforms_of(robot: Robot, output: Output, with_conditions: bool) -> Transforms:
    """Return the transforms that static_transform_publisher nodes publish, with the digits that an output prints."""
    always, in_modes, _ = static_transforms(robot, [output])
    edges = [read_arguments(one.name, list(one.arguments)) for one in (*always, *in_modes)]
    if with_conditions:
        edges = [replace(edge, when=one.when) for edge, one in zip(edges, (*always, *in_modes), strict=True)]
    return Transforms(tuple(edges))


def read(text: str) -> Transforms:
    """Return the transforms of the static_transform_publisher nodes of a launch file; it is parsed, never run.

    Raises ValueError if it is not such a file.
    """
    import ast

    try:
        nodes = list(ast.walk(python_of(text)))
    except SyntaxError as problem:
        raise ValueError(f"not a Python file: {problem}") from None
    calls = [node for node in nodes if isinstance(node, ast.Call)]
    defaults = _defaults(nodes, calls)
    edges = []
    for call in calls:
        given = {keyword.arg: keyword.value for keyword in call.keywords}
        executable = given.get("executable")
        if not (isinstance(executable, ast.Constant) and executable.value == STATIC_TRANSFORM_PUBLISHER):
            continue
        if not {"name", "arguments"} <= given.keys():
            raise ValueError("a static_transform_publisher has no name or no arguments")
        try:
            name, arguments = (_value(given[key], defaults) for key in ("name", "arguments"))
        except TypeError as problem:
            raise ValueError(f"not plain values: {problem}") from None
        edges.append(read_arguments(name, arguments))
    return Transforms(tuple(edges))


def _defaults(nodes: Sequence[ast.AST], calls: Sequence[ast.Call]) -> dict[str, str]:
    """Return the default values of launch arguments by the names that a launch file gives to them."""
    import ast

    defaults: dict[str, str] = {}
    for call in calls:
        if isinstance(call.func, ast.Name) and call.func.id == "DeclareLaunchArgument" and call.args:
            name = call.args[0]
            value = next((word.value for word in call.keywords if word.arg == "default_value"), None)
            if isinstance(name, ast.Constant) and isinstance(value, ast.Constant):
                defaults[str(name.value)] = str(value.value)
    found: dict[str, str] = {}
    for node in nodes:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call) and isinstance(node.targets[0], ast.Name):
            argument = node.value.args[0] if node.value.args else None
            if ast.unparse(node.value.func) == "LaunchConfiguration" and isinstance(argument, ast.Constant):
                found |= {node.targets[0].id: defaults[argument.value]} if argument.value in defaults else {}
    return found


def _value(node: ast.expr, defaults: Mapping[str, str]) -> Any:
    """Return a plain value; a list within a list is one text, of pieces that are texts or names in ``defaults``.

    Raises ValueError, TypeError.
    """
    import ast

    if not isinstance(node, ast.List):
        return ast.literal_eval(node)
    values: list[Any] = []
    for item in node.elts:
        if isinstance(item, ast.List):
            pieces = [defaults.get(one.id) if isinstance(one, ast.Name) else _value(one, defaults) for one in item.elts]
            if any(piece is None for piece in pieces):
                raise ValueError("a part of an argument is neither text nor a launch argument with a default")
            values.append("".join(map(str, pieces)))
        else:
            values.append(_value(item, defaults))
    return values


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
    """Yield that arguments of a program are not printed as six digits: that could print an exponent."""
    if output.options.get("number_format", "exact") != "exact":
        message = f'the backend "{output.backend}" does not print numbers as {output.options["number_format"]}'
        help = "write exact, or leave it out: 7 decimals of metres, 8 of radians"
        yield case.problem("number-format", message, ("outputs", output.name, "number_format"), help)


def frames(robot: Robot) -> list[str]:
    """Return the frames of the transforms that static_transform_publisher nodes publish."""
    turns = [edge for edge in robot.edges if edge.joint and edge.publisher.kind == STATIC_TRANSFORM_PUBLISHER]
    return [*(joint.child for joint in robot.published_by(STATIC_TRANSFORM_PUBLISHER)), *(edge.child for edge in turns)]


def _syntax(text: str) -> str:
    import ast

    return ast.dump(python_of(text))


NUMBER_FORMAT = {
    **format.NUMBER_FORMAT,
    "description": "exact: to the last digit; left out: 7 decimals of metres and 8 of radians.",
}
FORMAT = Format(
    name="static_tf",
    word="launch file of static transforms",
    article="a",
    about="the launch file of the static transforms",
    rank=40,
    covers=("robot", *PLACES, *NODES),
    options={"number_format": NUMBER_FORMAT},
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
    packaged=False,
    adapted="get_package_share_directory",
)

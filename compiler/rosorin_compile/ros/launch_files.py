"""Parse users' launch files without running them, and check their static transforms against the description."""

import ast
import math
import operator
import re
import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Joint, Pose, Robot, Transform
from rosorin_compile.output.atomic_files import is_generated
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Source, Span
from rosorin_compile.source.files import read_bytes
from rosorin_compile.source.load import LoadError, parse_yaml, python_of
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, to_fixed
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import MarkupError, parse

from .package.package_files import is_launch_file

Names = Mapping[str, Any]
_CHANGES = ("append", "clear", "extend", "insert", "pop", "remove", "reverse", "sort", "update")
_OPERATORS: Mapping[Any, Any] = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Div: operator.truediv}
_CONVERSIONS: Mapping[str, Callable[[Any], Any]] = {"math.radians": math.radians, "float": float, "str": str}
# Matches an escaped character, a launch argument, or another substitution, whose value is only known at launch.
_SUBSTITUTION = re.compile(r"\\(.)|\$\((?:var|arg) ([^\s()$]+)\)|\$\([^()]*\)?")
_UNKNOWN = "\0"

_MAX_LAUNCH = 1_000_000  # bytes
# Tolerances for the rounding of hand-written numbers: 0.01 mm, 0.006 deg.
METRES, RADIANS = 1e-5, 1e-4
_XYZ = ("--x", "--y", "--z")
_RPY = ("--roll", "--pitch", "--yaw")
_QUATERNION = ("--qx", "--qy", "--qz", "--qw")
_FRAMES = ("--frame-id", "--child-frame-id")
# Flags in the order of positional arguments, by number of arguments: 8 with Euler angles, 9 with a quaternion.
_WITHOUT_FLAGS = {8: (*_XYZ, "--yaw", "--pitch", "--roll", *_FRAMES), 9: (*_XYZ, *_QUATERNION, *_FRAMES)}


class LaunchError(Exception):
    """A launch file cannot be parsed."""


class _Unknown(Exception):
    """The value of an expression is only known at launch."""


class Remap(NamedTuple):
    """A remap of a topic from ``name`` to ``to``; ``node`` is the name of the node, or "" for a remap of all nodes."""

    name: str
    to: str
    span: Span | None = None
    node: str = ""


class LaunchNode(NamedTuple):
    """A node in a launch file, or the remaps of all nodes if ``name`` is ""; values only known at launch are None."""

    name: str
    executable: str
    arguments: tuple[str | None, ...] | None
    remaps: tuple[Remap, ...] | None
    span: Span


def nodes_of(source: Source) -> Iterator[LaunchNode]:
    """Yield the nodes in a launch file; its extension selects Python, YAML or XML. Raises LaunchError."""
    read = {".py": _python, ".yaml": _yaml, ".yml": _yaml}.get(Path(source.path).suffix, _xml)
    try:
        yield from read(source)
    except RecursionError:
        raise LaunchError("nested too deep") from None


def _xml(source: Source) -> Iterator[LaunchNode]:
    try:
        elements = list(parse(source).root.iter())
    except MarkupError as problem:
        raise LaunchError(f"not XML: {problem.diagnostic.message}") from None
    passed = {id(inner) for one in elements if one.tag == "include" for inner in one.iter()}  # elements in <include>
    declared = [one for one in elements if one.tag in ("arg", "let") and id(one) not in passed]
    variables = {one.get("name"): one.get("default", one.get("value")) for one in declared}
    for one in elements:
        if one.tag == "set_remap":
            yield LaunchNode("", "", (), (Remap(one.get("from"), one.get("to"), one.span),), one.span)
        elif one.tag == "node":
            remaps = (Remap(each.get("from"), each.get("to"), each.span) for each in one.iter() if each.tag == "remap")
            program, arguments = one.get("exec") or one.get("type"), _words(one.get("args"), variables)
            yield LaunchNode(one.get("name") or program, program, arguments, tuple(remaps), one.span)


def _yaml(source: Source) -> Iterator[LaunchNode]:
    try:
        maps = list(_maps(parse_yaml(source)))
    except LoadError as problem:
        raise LaunchError(f"not YAML: {problem.diagnostic.message}") from None
    named = [one[key] for one in maps for key in ("arg", "let") if isinstance(one.get(key), dict)]
    variables = {str(one.get("name")): str(one.get("default", one.get("value", ""))) for one in named}
    for one in maps:
        node = one.get("node")
        if isinstance(node, dict):
            pairs = [each for each in _list(node.get("remap")) if isinstance(each, Map)]
            found = [Remap(str(each.get("from", "")), str(each.get("to", "")), each.locate(()).span) for each in pairs]
            program, arguments = str(node.get("exec", "")), _words(str(node.get("args", "")), variables)
            yield LaunchNode(str(node.get("name") or program), program, arguments, tuple(found), one.key_spans["node"])


def _maps(tree: Any) -> Iterator[Any]:
    if isinstance(tree, dict):
        yield tree
    for child in tree.values() if isinstance(tree, dict) else _list(tree):
        yield from _maps(child)


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _words(arguments: str, variables: Mapping[str, str]) -> tuple[str | None, ...] | None:
    """Split the attribute ``args`` of a node into words; a word that is only known at launch is None."""

    def put(match: re.Match[str]) -> str:
        return match[1] or (shlex.quote(variables[match[2]]) if match[2] in variables else _UNKNOWN)

    try:
        words = shlex.split(_SUBSTITUTION.sub(put, arguments))
    except ValueError:
        return None
    return tuple(None if _UNKNOWN in word else word for word in words)


def _python(source: Source) -> Iterator[LaunchNode]:
    try:
        tree = python_of(source.text)
    except (SyntaxError, ValueError, MemoryError, RecursionError) as problem:
        raise LaunchError(f"not a Python file: {problem}") from None
    names, calls = _constants(tree), list(_calls_in(tree))
    for call, function in calls:
        words = {word.arg: word.value for word in call.keywords if word.arg}
        callee = ast.unparse(call.func)
        if not callee.endswith(("Node", "SetRemap")) and not words.keys() & {"executable", "node_executable"}:
            continue
        if function is None:
            yield _python_node(words, names, Span(source, call.lineno, call.col_offset + 1))
            continue
        # A node in a helper function is started once for each call to the function.
        uses: list[Any] = [use for use, _ in calls if ast.unparse(use.func) == function.name]
        for use in uses or [None]:
            scope, place = _constants(function, _bind(function, use, names)), use or call
            yield _python_node(words, scope, Span(source, place.lineno, place.col_offset + 1))


def _calls_in(tree: ast.AST, function: ast.FunctionDef | None = None) -> Iterator[tuple[ast.Call, Any]]:
    """Yield (call, enclosing function or None) for each call in a Python program."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Call):
            yield node, function
        yield from _calls_in(node, node if isinstance(node, ast.FunctionDef) else function)


def _python_node(words: Mapping[str, ast.expr], names: Names, span: Span) -> LaunchNode:
    known = {key: _known(word, names) for key, word in words.items()}
    program = str(known.get("executable") or known.get("node_executable") or "")
    arguments: list[str | None] = []
    is_known = True
    for key in ("arguments", "ros_arguments"):
        node, found = words.get(key), known.get(key, [])
        if found is None and isinstance(node, ast.List | ast.Tuple):
            found = [_known(item, names) for item in node.elts]
        is_known = is_known and isinstance(found, list)
        for one in _list(found):  # launch concatenates the items of a nested list
            word = "".join(one) if isinstance(one, list) and all(isinstance(each, str) for each in one) else one
            arguments.append(word if isinstance(word, str) else None)
    is_for_all = "src" in known and "dst" in known
    pairs = [[known["src"], known["dst"]]] if is_for_all else known.get("remappings", [])
    is_plain = isinstance(pairs, list) and all(isinstance(one, list) and len(one) == 2 for one in pairs)
    is_plain = is_plain and all(isinstance(name, str) for pair in pairs for name in pair)
    remaps = tuple(Remap(old, new, span) for old, new in pairs) if is_plain else None
    name = "" if is_for_all else str(known.get("name") or program)
    return LaunchNode(name, program, tuple(arguments) if is_known else None, remaps, span)


def _bind(function: ast.FunctionDef, call: ast.Call | None, names: Names) -> dict[str, Any]:
    """Return the variables that a function sees during a call: its arguments, and ``names`` of the module."""
    positional = [one.arg for one in function.args.args]
    parameters = {one.arg for one in ast.walk(function.args) if isinstance(one, ast.arg)}
    inside = {name: held for name, held in names.items() if name not in parameters}
    if call is None or any(isinstance(one, ast.Starred) for one in call.args) or any(not k.arg for k in call.keywords):
        return inside  # arguments with * or ** are only known at launch
    given = dict(zip(positional[::-1], function.args.defaults[::-1], strict=False))
    given |= dict(zip(positional, call.args, strict=False))
    given |= {keyword.arg: keyword.value for keyword in call.keywords if keyword.arg}
    held = {name: _known(expression, names) for name, expression in given.items()}
    return inside | {name: value for name, value in held.items() if value is not None}


def _constants(tree: ast.AST, names: Names = MappingProxyType({})) -> dict[str, Any]:
    """Return ``names`` and all variables that are assigned exactly once, to a known value."""
    changes = Counter[str]()
    assigned: list[tuple[str, ast.expr]] = []
    for node in ast.walk(tree):
        match node:
            case (
                ast.Name(id=name, ctx=ast.Store() | ast.Del())
                | ast.Subscript(value=ast.Name(id=name), ctx=ast.Store() | ast.Del())
            ):
                changes[name] += 1
            case ast.Call(func=ast.Attribute(value=ast.Name(id=name), attr=method)) if method in _CHANGES:
                changes[name] += 1
            case ast.Assign(targets=[ast.Name(id=name)], value=expression):
                assigned.append((name, expression))
    values = {name: held for name, held in names.items() if not changes[name]}
    for name, expression in assigned:
        value = _known(expression, values) if changes[name] == 1 else None
        if value is not None:
            values[name] = value
    return values


def _known(node: ast.expr, names: Names) -> Any:
    try:
        value = _value(node, names)
    except (_Unknown, ArithmeticError, LookupError, TypeError, ValueError):
        return None
    return None if isinstance(value, str | list) and len(value) > 10_000 else value


def _value(node: ast.expr, names: Names) -> Any:
    """Evaluate an expression of literals, ``names``, pi and a few functions. Raises _Unknown for other terms."""
    match node:
        case ast.Constant(value=constant):
            return constant
        case ast.List(elts=items) | ast.Tuple(elts=items):
            return [_value(item, names) for item in items]
        case ast.Name(id=name):
            return names[name]
        case ast.Attribute(value=ast.Name(id="math" | "np" | "numpy"), attr="pi"):
            return math.pi
        case ast.JoinedStr(values=parts):
            return "".join(str(_value(part, names)) for part in parts)
        case ast.FormattedValue(value=inner, conversion=-1, format_spec=None):
            return _value(inner, names)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_value(operand, names)
        case ast.BinOp(op=op) if type(op) in _OPERATORS:
            return _OPERATORS[type(op)](_value(node.left, names), _value(node.right, names))
        case ast.Subscript(value=of, slice=key):
            return _value(of, names)[_value(key, names)]
        case ast.Call(func=ast.Attribute(value=of, attr="split"), args=[] | [_], keywords=[]):
            return str.split(_value(of, names), *(_value(one, names) for one in node.args))
        case ast.Call(func=function, args=[argument], keywords=[]) if ast.unparse(function) in _CONVERSIONS:
            return _CONVERSIONS[ast.unparse(function)](_value(argument, names))
    raise _Unknown


class StaticTransform(NamedTuple):
    """A static transform in a launch file; ``texts`` maps flags such as "--x" to the arguments as written."""

    parent: str
    child: str
    texts: dict[str, str]
    transform: Transform


def static_nodes(source: Source) -> list[LaunchNode]:
    """Return the static_transform_publisher nodes in a launch file. Raises LaunchError."""
    nodes = nodes_of(source) if STATIC_TRANSFORM_PUBLISHER in source.text else ()
    return [node for node in nodes if node.executable == STATIC_TRANSFORM_PUBLISHER]


def parse_arguments(arguments: Sequence[str | None] | None) -> StaticTransform | None:
    """Parse the arguments of static_transform_publisher; return None if they are invalid or only known at launch."""
    words = [word for word in arguments or () if word is not None]
    if arguments is None or len(words) < len(arguments):
        return None
    texts, is_refused = dict(zip(words[::2], words[1::2], strict=False)), len(words) % 2
    if len(words) in _WITHOUT_FLAGS and not words[0].startswith("--"):
        texts, is_refused = dict(zip(_WITHOUT_FLAGS[len(words)], words, strict=True)), 0
    if is_refused or not texts.keys() <= {*_XYZ, *_RPY, *_QUATERNION, *_FRAMES}:
        return None
    if not all(texts.get(flag) for flag in _FRAMES) or (texts.keys() & {*_RPY} and texts.keys() & {*_QUATERNION}):
        return None
    try:
        numbers = {flag: float(text) for flag, text in texts.items() if flag not in _FRAMES}
        x, y, z, roll, pitch, yaw, qx, qy, qz = (numbers.get(flag, 0.0) for flag in (*_XYZ, *_RPY, *_QUATERNION[:3]))
        transform = Pose((x, y, z), (roll, pitch, yaw)).transform()
        if numbers.keys() & {*_QUATERNION}:
            transform = Transform.of_quaternion((x, y, z), (numbers.get("--qw", 1.0), qx, qy, qz))
    except ValueError:  # not a number, or a zero quaternion
        return None
    if not all(map(math.isfinite, numbers.values())):
        return None
    parent, child = (texts[flag].lstrip("/") for flag in _FRAMES)
    return StaticTransform(parent, child, texts, transform)


def check_node(robot: Robot, node: LaunchNode) -> Iterator[Diagnostic]:
    """Report differences between a static_transform_publisher in a launch file and the robot."""
    if node.arguments is None or None in node.arguments:
        message = "the arguments of this static_transform_publisher are known only when the launch file runs"
        yield report("deployed-launch-unread", message, node.span, severity=NOTE)
        return
    if (static := parse_arguments(node.arguments)) is None:
        yield report("deployed-launch-refused", "static_transform_publisher refuses these arguments", node.span)
        return
    joint, edge = robot.joint_to.get(static.child), f"{static.parent} -> {static.child}"
    owners = [one.publisher for one in robot.edges if one.child == static.child]
    if joint is not None:
        owners = [one.publisher for one in robot.mode_dependent_edges.get(joint.name, ())] or [joint.publisher]
    if not owners:
        yield report("deployed-launch-unknown", f"{edge} is not a frame of the description", node.span)
    elif joint is not None and any(owner.kind == STATIC_TRANSFORM_PUBLISHER for owner in owners):
        if parts := list(_differences(joint, static)):
            yield report("deployed-launch-differs", f"{edge} is not as described: {', '.join(parts)}", node.span)
    else:
        source = {ROBOT_STATE_PUBLISHER: ", from the URDF"}
        names = [f"{one.name}{source.get(one.kind, '')}" if one.publishes else "nobody" for one in owners]
        message = f"{edge} is published here, but the description gives it to {' or '.join(dict.fromkeys(names))}"
        yield report("deployed-launch-owner", message, node.span)


def _differences(joint: Joint, static: StaticTransform) -> Iterator[str]:
    described = joint.origin.transform()
    if static.parent != joint.parent:
        yield f"parent {static.parent} -> {joint.parent}"
    for flag, here, there in zip(_XYZ, static.transform.xyz, described.xyz, strict=True):
        if abs(here - there) > METRES:
            yield f"{flag} {static.texts.get(flag, '0')} -> {to_fixed(there, METRE_DIGITS)}"
    if (off := static.transform.angle_to(described)) <= RADIANS:
        return
    degrees = f"rotation {math.degrees(off):.3g} deg off"
    if static.texts.keys() & {*_QUATERNION}:
        w, x, y, z = described.quaternion()
        values = zip(_QUATERNION, (x, y, z, w), strict=True)
        yield f"{degrees}, described: {' '.join(f'{flag} {to_fixed(value, 9)}' for flag, value in values)}"
        return
    for flag, there in zip(_RPY, joint.origin.rpy, strict=True):
        if abs(float(static.texts.get(flag, "0")) - there) > RADIANS:
            yield f"{flag} {static.texts.get(flag, '0')} -> {to_fixed(there, RADIAN_DIGITS)}"
    yield degrees


def check_launch_files(robot: Robot, folder: Path, files: Sequence[str], ours: Sequence[str]) -> Iterator[Diagnostic]:
    """Check the static transforms in the launch files of a folder; ``ours`` are generated files, which are skipped."""
    published: dict[str, str] = {}
    complete, any_publisher = True, bool(ours)
    for name in files:
        if name in ours or not is_launch_file(name) or (folder / name).stat().st_size > _MAX_LAUNCH:
            continue
        data = read_bytes(folder / name)
        if name.endswith("/static_frames.launch.py") and is_generated(data):
            continue  # this file compiles the description at launch, so its transforms cannot differ
        source = Source(str(folder / name), data.decode("utf-8", "replace"))
        try:
            nodes = static_nodes(source)
        except LaunchError as problem:
            yield report("deployed-launch-unread", f"{source.path}: {problem}", severity=WARNING)
            complete = False
            continue
        any_publisher = any_publisher or STATIC_TRANSFORM_PUBLISHER in source.text
        for node in nodes:
            static = parse_arguments(node.arguments)
            published |= {static.child: name} if static else {}
            complete = complete and static is not None
            yield from check_node(robot, node)
    joints = robot.published_by(STATIC_TRANSFORM_PUBLISHER)
    children = [joint.child for joint in joints if joint.child in published]
    if ours and children:
        own = ", ".join(dict.fromkeys(published[child] for child in children))
        yield report("deployed-static-twice", f"{own} and {', '.join(ours)} both publish {', '.join(children)}")
    absent = [joint for joint in joints if joint.child not in published]
    for joint in absent if not ours and complete and any_publisher else ():
        message = f"no launch file in {folder} publishes {joint.parent} -> {joint.child} ({joint.publisher.name})"
        yield report("deployed-static-missing", message)

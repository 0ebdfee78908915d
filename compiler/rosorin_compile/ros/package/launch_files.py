"""Static transforms of hand-written launch files, held against the description.

Launch files in Python, XML and YAML are read and never run; the few expressions of Python that say a number are
evaluated.
"""

from __future__ import annotations

import ast
import math
import re
import shlex
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

from rosorin_compile.model import (
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    Joint,
    Pose,
    Publisher,
    Robot,
    Transform,
)
from rosorin_compile.ros.python_values import Unknown, constants, value
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Source, Span
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, fixed
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import parse

RULES = (
    Rule(
        "deployed-launch-differs",
        "A launch file gives a static transform other values, or another parent.",
        "Write the described values into it.",
        Heading.PACKAGES,
    ),
    Rule(
        "deployed-launch-owner",
        "A launch file publishes a frame that belongs to another node.",
        "Publish it once.",
        Heading.PACKAGES,
    ),
    Rule(
        "deployed-launch-refused",
        "static_transform_publisher would refuse its arguments.",
        "Correct them.",
        Heading.PACKAGES,
    ),
    Rule(
        "deployed-launch-unknown",
        "A warning: a launch file publishes a frame that is not described.",
        "Describe it.",
        Heading.PACKAGES,
    ),
)


# Less than these is the rounding of somebody who typed the number: 0.01 mm, 0.006 deg.
METRES, RADIANS = 1e-5, 1e-4
_XYZ = ("--x", "--y", "--z")
_RPY = ("--roll", "--pitch", "--yaw")
_QUATERNION = ("--qx", "--qy", "--qz", "--qw")
_FRAMES = ("--frame-id", "--child-frame-id")
_OLD_EULER = (*_XYZ, "--yaw", "--pitch", "--roll", *_FRAMES)
_OLD_QUATERNION = (*_XYZ, *_QUATERNION, *_FRAMES)


class Understood(NamedTuple):
    """What one static_transform_publisher is told: its frames, and the texts of its numbers by flag."""

    parent: str
    child: str
    texts: dict[str, str]
    transform: Transform


def understood(arguments: Sequence[str]) -> Understood | None:
    """Return what arguments say, read as static_transform_publisher does; None if it would refuse them.

    The old form without flags has yaw before pitch and roll (``ros2/geometry2@{humble,jazzy}``).
    """
    if arguments and not arguments[0].startswith("--") and len(arguments) in (8, 9):
        names = _OLD_EULER if len(arguments) == 8 else _OLD_QUATERNION
        texts = dict(zip(names, arguments, strict=True))
    elif len(arguments) % 2:
        return None
    else:
        texts = dict(zip(arguments[::2], arguments[1::2], strict=True))
    if not texts.keys() <= {*_XYZ, *_RPY, *_QUATERNION, *_FRAMES} or not all(texts.get(flag) for flag in _FRAMES):
        return None
    if texts.keys() & {*_RPY} and texts.keys() & {*_QUATERNION}:
        return None
    try:
        numbers = {flag: float(text) for flag, text in texts.items() if flag not in _FRAMES}
        transform = _transform(numbers)
    except ValueError:
        return None
    parent, child = (texts[flag].lstrip("/") for flag in _FRAMES)
    return Understood(parent, child, texts, transform)


def _transform(numbers: dict[str, float]) -> Transform:
    if not all(map(math.isfinite, numbers.values())):
        raise ValueError
    x, y, z = (numbers.get(flag, 0.0) for flag in _XYZ)
    if numbers.keys() & {*_QUATERNION}:
        qx, qy, qz = (numbers.get(flag, 0.0) for flag in _QUATERNION[:3])
        return Transform.of_quaternion((x, y, z), (numbers.get("--qw", 1.0), qx, qy, qz))
    roll, pitch, yaw = (numbers.get(flag, 0.0) for flag in _RPY)
    return Pose((x, y, z), (roll, pitch, yaw)).transform()


def check(robot: Robot, source: Source, call: Call) -> Iterator[Diagnostic]:
    """Yield what is to say about one static transform of a launch file."""
    span = _beginning(source, call.line)
    if call.arguments is None:
        message = "the arguments of this static_transform_publisher are known only when the launch file runs"
        yield Diagnostic("deployed-launch-unread", NOTE, message, span, (), "compare them with frames.md yourself")
        return
    static = understood(call.arguments)
    if static is None:
        message = "static_transform_publisher refuses these arguments"
        help = (
            "--x --y --z, --roll --pitch --yaw or --qx --qy --qz --qw, --frame-id, --child-frame-id, each with a value"
        )
        yield Diagnostic("deployed-launch-refused", ERROR, message, span, (), help)
        return
    joint = robot.joint_to.get(static.child)
    if joint is None:
        yield from _not_a_link(robot, static, span)
    elif any(owner.kind == STATIC_TRANSFORM_PUBLISHER for owner in _owners(robot, joint)):
        yield from _compared(joint, static, span)
    else:
        yield _owned(_owners(robot, joint), static, span)


def _owners(robot: Robot, joint: Joint) -> tuple[Publisher, ...]:
    return tuple(edge.publisher for edge in robot.turns.get(joint.name, ())) or (joint.publisher,)


def _beginning(source: Source, line: int) -> Span:
    text = source.line(line)
    word = re.match(r"\s*(<?[\w.]*)", text)
    start, end = word.span(1) if word else (0, 1)
    return Span(source, line, start + 1, max(1, end - start))


def _not_a_link(robot: Robot, static: Understood, span: Span) -> Iterator[Diagnostic]:
    edges = [edge for edge in robot.edges if edge.child == static.child]
    if edges:
        names = " or ".join(dict.fromkeys(edge.publisher.name for edge in edges))
        message = f"{static.parent} -> {static.child} is published here, but the description gives it to {names}"
        yield Diagnostic("deployed-launch-owner", ERROR, message, span, (), "publish it once")
    else:
        message = f"{static.parent} -> {static.child} is no frame of the description"
        help = "a sensor or an edge of the description makes it known to all artifacts"
        yield Diagnostic("deployed-launch-unknown", WARNING, message, span, (), help)


def _owned(owners: Sequence[Publisher], static: Understood, span: Span) -> Diagnostic:
    who = " or ".join(dict.fromkeys(_named(owner) for owner in owners))
    message = f"{static.parent} -> {static.child} is published here, but the description gives it to {who}"
    return Diagnostic("deployed-launch-owner", ERROR, message, span, (), "publish it once")


def _named(owner: Publisher) -> str:
    if not owner.publishes:
        return "nobody"
    return f"{owner.name}, from the URDF" if owner.kind == ROBOT_STATE_PUBLISHER else owner.name


def _compared(joint: Joint, static: Understood, span: Span) -> Iterator[Diagnostic]:
    parts = [f"parent {static.parent} -> {joint.parent}"] if static.parent != joint.parent else []
    meant = joint.origin.transform()
    for flag, here, there in zip(_XYZ, static.transform.xyz, meant.xyz, strict=True):
        if abs(here - there) > METRES:
            parts.append(f"{flag} {static.texts.get(flag, '0')} -> {fixed(there, METRE_DIGITS)}")
    off = static.transform.angle_to(meant)
    if off > RADIANS:
        parts += _angles(static, joint, off)
    if parts:
        message = f"{static.parent} -> {static.child} is not as described: {', '.join(parts)}"
        help = "write these values into the launch file, or read them from static_tf.json"
        yield Diagnostic("deployed-launch-differs", ERROR, message, span, (), help)


def _angles(static: Understood, joint: Joint, off: float) -> list[str]:
    degrees = f"{math.degrees(off):.3g} deg off"
    if static.texts.keys() & {*_QUATERNION}:
        w, x, y, z = joint.origin.transform().quaternion()
        values = zip(_QUATERNION, (x, y, z, w), strict=True)
        described = " ".join(f"{flag} {fixed(value, 9)}" for flag, value in values)
        return [f"rotation {degrees}, described: {described}"]
    pairs = [
        f"{flag} {static.texts.get(flag, '0')} -> {fixed(there, RADIAN_DIGITS)}"
        for flag, there in zip(_RPY, joint.origin.rpy, strict=True)
        if abs(float(static.texts.get(flag, "0")) - there) > RADIANS
    ]
    return [*pairs, f"rotation {degrees}"]


PUBLISHER = "static_transform_publisher"
_VARIABLE = re.compile(r"\$\((?:var|arg) ([^\s()$]+)\)")
_MOST = 500  # static transforms in one file


class Call(NamedTuple):
    """A static_transform_publisher of a launch file: its line, and its arguments, None if they are not plain."""

    line: int
    arguments: tuple[str, ...] | None


class Unreadable(Exception):
    """A launch file that cannot be parsed; the message says why."""


def calls(name: str, text: str) -> list[Call]:
    """Return the static transforms that a launch file starts, in its order. Raises Unreadable."""
    if PUBLISHER not in text:
        return []
    reader = _python if name.endswith(".py") else _yaml if name.endswith((".yaml", ".yml")) else _xml
    try:
        return list(islice(reader(name, text), _MOST))
    except RecursionError:
        raise Unreadable("nested too deep") from None


def _python(_: str, text: str) -> Iterator[Call]:
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, MemoryError, RecursionError) as problem:
        raise Unreadable(f"not a Python file: {problem}") from None
    names = constants(tree)
    for node, function in _nodes(tree):
        given = {keyword.arg: keyword.value for keyword in node.keywords if keyword.arg}
        if not _starts_publisher(given, names):
            continue
        arguments = given.get("arguments", ast.List([], ast.Load()))
        plain = _arguments(arguments, names if function is None else _inside(function, names))
        if plain is not None or function is None:
            yield Call(node.lineno, plain)
            continue
        called = list(_calls_of(function.name, tree))
        for call in called:
            yield Call(call.lineno, _arguments(arguments, constants(function, _bound(function, call, names))))
        if not called:
            yield Call(node.lineno, None)


def _nodes(tree: ast.Module) -> Iterator[tuple[ast.Call, ast.FunctionDef | None]]:
    waiting: deque[tuple[ast.AST, ast.FunctionDef | None]] = deque([(tree, None)])
    while waiting:
        node, function = waiting.popleft()
        if isinstance(node, ast.Call):
            yield node, function
        inner = node if isinstance(node, ast.FunctionDef) else function
        waiting += [(child, inner) for child in ast.iter_child_nodes(node)]


def _starts_publisher(given: Mapping[str, ast.expr], names: Mapping[str, Any]) -> bool:
    executable = given.get("executable") or given.get("node_executable")
    try:
        return executable is not None and value(executable, names) == PUBLISHER
    except Unknown:
        return False


def _arguments(node: ast.expr, names: Mapping[str, Any]) -> tuple[str, ...] | None:
    try:
        arguments = value(node, names)
    except Unknown:
        return None
    if not isinstance(arguments, list):
        return None
    # Launch takes an argument that is a list of pieces for one text.
    words = [
        "".join(one) if isinstance(one, list) and all(isinstance(p, str) for p in one) else one for one in arguments
    ]
    return tuple(words) if all(isinstance(word, str) for word in words) else None


def _calls_of(function: str, tree: ast.Module) -> Iterator[ast.Call]:
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name))
    yield from sorted((call for call in calls if ast.unparse(call.func) == function), key=lambda call: call.lineno)


def _parameters(function: ast.FunctionDef) -> set[str]:
    every = function.args
    more = [one for one in (every.vararg, every.kwarg) if one is not None]
    return {argument.arg for argument in (*every.posonlyargs, *every.args, *every.kwonlyargs, *more)}


def _inside(function: ast.FunctionDef, names: Mapping[str, Any]) -> dict[str, Any]:
    taken = _parameters(function)
    return constants(function, {name: known for name, known in names.items() if name not in taken})


def _bound(function: ast.FunctionDef, call: ast.Call, names: Mapping[str, Any]) -> dict[str, Any]:
    parameters = [argument.arg for argument in (*function.args.posonlyargs, *function.args.args)]
    expressions: dict[str, ast.expr] = {}
    defaults = function.args.defaults
    expressions.update(zip(parameters[len(parameters) - len(defaults) :], defaults, strict=True))
    only = zip(function.args.kwonlyargs, function.args.kw_defaults, strict=True)
    expressions.update({argument.arg: default for argument, default in only if default is not None})
    expressions.update(zip(parameters, call.args, strict=False))
    expressions.update({keyword.arg: keyword.value for keyword in call.keywords if keyword.arg})
    bound = {name: known for name, known in names.items() if name not in _parameters(function)}
    if any(isinstance(argument, ast.Starred) for argument in call.args) or any(not word.arg for word in call.keywords):
        return bound  # which parameter gets what is known only when it runs
    for name, expression in expressions.items():
        try:
            bound[name] = value(expression, names)
        except Unknown:
            continue
    return bound


def _xml(name: str, text: str) -> Iterator[Call]:
    from rosorin_compile.source.xml.markup import MarkupError

    try:
        root = parse(Source(name, text)).root
    except MarkupError as problem:
        raise Unreadable(f"not XML: {problem.diagnostic.message}") from None
    elements = list(root.iter())
    passed = {id(inner) for e in elements if e.tag == "include" for inner in e.iter()}  # to another file
    declared = [e for e in elements if e.tag in ("arg", "let") and id(e) not in passed]
    variables = {e.get("name"): e.get("default", e.get("value")) for e in declared}
    for element in elements:
        if element.tag == "node" and PUBLISHER in (element.get("exec"), element.get("type")):
            yield Call(element.span.line, split(element.get("args"), variables))


def _yaml(name: str, text: str) -> Iterator[Call]:
    from rosorin_compile.source.load import LoadError, parse_yaml

    try:
        tree = parse_yaml(Source(name, text))
    except LoadError as problem:
        raise Unreadable(f"not YAML: {problem.diagnostic.message}") from None
    maps = list(_maps(tree))
    named = [m[k] for m in maps for k in ("arg", "let") if isinstance(m.get(k), dict)]
    variables = {str(m.get("name")): str(m.get("default", m.get("value", ""))) for m in named}
    for entry in maps:
        node = entry.get("node")
        if isinstance(node, dict) and node.get("exec") == PUBLISHER:
            line = entry.key_spans["node"].line
            yield Call(line, split(str(node.get("args", "")), variables))


def _maps(tree: Any) -> Iterator[Any]:
    if isinstance(tree, dict):
        yield tree
    for child in tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ():
        yield from _maps(child)


def split(args: str, variables: Mapping[str, str]) -> tuple[str, ...] | None:
    """Return ``args`` of XML and YAML as a list, with the defaults of launch arguments; None if it is not plain."""
    words: list[str] = []
    pieces = _VARIABLE.split(args)
    text = "".join(
        shlex.quote(variables.get(piece, "$(")) if index % 2 else re.sub(r"\\(.)", r"\1", piece)
        for index, piece in enumerate(pieces)
    )
    if re.search(r"(?<!\\)\$\(", "".join(pieces[::2])) or any(piece not in variables for piece in pieces[1::2]):
        return None
    try:
        words = shlex.split(text)
    except ValueError:
        return None
    return tuple(words)

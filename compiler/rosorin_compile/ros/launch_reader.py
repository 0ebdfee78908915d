"""Launch files of people: the nodes that they start, read and never run.

Of Python, plain values are evaluated; what only a run would know is unknown here.
"""

from __future__ import annotations

import ast
import math
import operator
import re
import shlex
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml, python_of
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import MarkupError, parse

Names = Mapping[str, Any]
_MOST_VALUES = 10_000  # characters or items; a launch file has no need of more
_LARGEST = 10**30
_ARGUMENT = "launch argument "
_CHANGES = ("append", "clear", "extend", "insert", "pop", "remove", "reverse", "sort", "update")
_BINARY: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_NUMBERS: Mapping[str, Callable[[Any], Any]] = {"math.radians": math.radians, "radians": math.radians, "float": float}
# An escaped letter, a variable, or a substitution whose value is unknown.
_SUBSTITUTION = re.compile(r"\\(.)|\$\((?:var|arg) ([^\s()$]+)\)|\$\([^()]*\)?")
_UNKNOWN = "\0"


class LaunchError(Exception):
    """A launch file that cannot be parsed; the message says why."""


class Unknown(Exception):
    """The value is known only when the program runs."""


@dataclass(frozen=True)
class Remap:
    """A remap of a launch file: the two names as they are written, and its place."""

    name: str
    to: str
    span: Span


@dataclass(frozen=True)
class LaunchNode:
    """A node that a launch file starts; without a name, a remap of all nodes.

    What only a run of the launch file knows is None: all arguments or one of them, or the remaps.
    """

    name: str
    executable: str
    arguments: tuple[str | None, ...] | None
    remaps: tuple[Remap, ...] | None
    span: Span


def nodes_of(source: Source) -> Iterator[LaunchNode]:
    """Yield the nodes of a launch file in Python, YAML or XML, by the ending of its name. Raises LaunchError."""
    try:
        if source.path.endswith(".py"):
            yield from _python(source)
        else:
            yield from _yaml(source) if source.path.endswith((".yaml", ".yml")) else _xml(source)
    except RecursionError:
        raise LaunchError("nested too deep") from None


def _xml(source: Source) -> Iterator[LaunchNode]:
    try:
        elements = list(parse(source).root.iter())
    except MarkupError as problem:
        raise LaunchError(f"not XML: {problem.diagnostic.message}") from None
    passed = {id(inner) for one in elements if one.tag == "include" for inner in one.iter()}  # to another file
    declared = [one for one in elements if one.tag in ("arg", "let") and id(one) not in passed]
    variables = {one.get("name"): one.get("default", one.get("value")) for one in declared}
    for one in elements:
        if one.tag == "set_remap":
            yield LaunchNode("", "", (), (Remap(one.get("from"), one.get("to"), one.span),), one.span)
        elif one.tag == "node":
            remaps = (Remap(each.get("from"), each.get("to"), each.span) for each in one.iter() if each.tag == "remap")
            program = one.get("exec") or one.get("type")
            arguments = _words(one.get("args"), variables)
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
            remaps = node.get("remap")
            pairs = [each for each in remaps if isinstance(each, Map)] if isinstance(remaps, list) else []
            found = [Remap(str(each.get("from", "")), str(each.get("to", "")), each.locate(()).span) for each in pairs]
            program, arguments = str(node.get("exec", "")), _words(str(node.get("args", "")), variables)
            yield LaunchNode(str(node.get("name") or program), program, arguments, tuple(found), one.key_spans["node"])


def _maps(tree: Any) -> Iterator[Any]:
    if isinstance(tree, dict):
        yield tree
    for child in tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ():
        yield from _maps(child)


def _words(arguments: str, variables: Mapping[str, str]) -> tuple[str | None, ...] | None:
    """Return arguments of XML or YAML as words, with the defaults of launch arguments."""

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
    names, calls = constants(tree), list(_calls_in(tree))
    for call, function in calls:
        words = {word.arg: word.value for word in call.keywords if word.arg}
        named = ast.unparse(call.func).rpartition(".")[2]
        if not named.endswith(("Node", "SetRemap")) and not words.keys() & {"executable", "node_executable"}:
            continue
        scopes = [(call, names)]
        if function is not None:  # a helper: its parameters have the values of each call
            uses = [use for use, _ in calls if isinstance(use.func, ast.Name) and use.func.id == function.name]
            scopes = [(use, constants(function, _bound(function, use, names))) for use in uses]
            scopes = scopes or [(call, constants(function, _bound(function, None, names)))]
        for place, scope in sorted(scopes, key=lambda one: one[0].lineno):
            yield _python_node(words, scope, Span(source, place.lineno, place.col_offset + 1))


def _python_node(words: Mapping[str, ast.expr], names: Names, span: Span) -> LaunchNode:
    def text(key: str) -> str:
        found = known(words[key], names) if key in words else None
        return "" if found is None else str(found)

    program = text("executable") or text("node_executable")
    given = [_argument_words(words[key], names) for key in ("arguments", "ros_arguments") if key in words]
    arguments = None if None in given else tuple(word for each in given if each is not None for word in each)
    if "src" in words and "dst" in words:
        pair = [known(words["src"], names), known(words["dst"], names)]
        return LaunchNode("", program, arguments, _pairs([pair], span), span)
    pairs = known(words["remappings"], names) if "remappings" in words else []
    return LaunchNode(text("name") or program, program, arguments, _pairs(pairs, span), span)


def _pairs(pairs: Any, span: Span) -> tuple[Remap, ...] | None:
    rows: list[Any] = pairs if isinstance(pairs, list) else [None]
    if not all(isinstance(row, list) and len(row) == 2 and all(isinstance(one, str) for one in row) for row in rows):
        return None
    return tuple(Remap(old, new, span) for old, new in rows)


def _argument_words(node: ast.expr, names: Names) -> tuple[str | None, ...] | None:
    """Return a list of arguments as words; launch joins an argument that is a list of pieces."""
    found: Any = known(node, names)
    if found is None and isinstance(node, ast.List | ast.Tuple):
        found = [known(item, names) for item in node.elts]
    words: list[str | None] = []
    for word in found if isinstance(found, list) else ():
        if isinstance(word, list) and all(isinstance(piece, str) for piece in word):
            word = "".join(word)
        words.append(word if isinstance(word, str) else None)
    return tuple(words) if isinstance(found, list) else None


def _calls_in(tree: ast.AST) -> Iterator[tuple[ast.Call, ast.FunctionDef | None]]:
    """Yield every call of a program with the function around it."""
    waiting: deque[tuple[ast.AST, ast.FunctionDef | None]] = deque([(tree, None)])
    while waiting:
        node, function = waiting.popleft()
        if isinstance(node, ast.Call):
            yield node, function
        inner = node if isinstance(node, ast.FunctionDef) else function
        waiting += [(child, inner) for child in ast.iter_child_nodes(node)]


def _bound(function: ast.FunctionDef, use: ast.Call | None, names: Names) -> dict[str, Any]:
    """Return ``names`` inside a function, whose parameters have the plain values of a call, or no value."""
    every = function.args
    positional = [argument.arg for argument in (*every.posonlyargs, *every.args)]
    keywords = [argument.arg for argument in every.kwonlyargs]
    rest = [argument.arg for argument in (every.vararg, every.kwarg) if argument is not None]
    bound = {name: held for name, held in names.items() if name not in (*positional, *keywords, *rest)}
    if use is None or any(isinstance(one, ast.Starred) for one in use.args) or any(not one.arg for one in use.keywords):
        return bound  # which parameter gets what is known only when it runs
    given: dict[str, ast.expr | None] = dict(zip(positional[::-1], every.defaults[::-1], strict=False))
    given |= dict(zip(keywords, every.kw_defaults, strict=True))
    given |= dict(zip(positional, use.args, strict=False))
    given |= {keyword.arg: keyword.value for keyword in use.keywords if keyword.arg}
    for name, expression in given.items():
        with suppress(Unknown):
            bound |= {name: value(expression, names)} if expression is not None else {}
    return bound


def known(node: ast.expr, names: Names) -> Any:
    """Return the value of an expression, or None if it is known only when the program runs."""
    try:
        return value(node, names)
    except Unknown:
        return None


def value(node: ast.expr, names: Names) -> Any:
    """Return the value of an expression of plain values, ``names``, ``math.pi``, joins of paths and a few calls.

    Raises Unknown for anything else.
    """
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.List | ast.Tuple):
        return [value(item, names) for item in node.elts]
    if isinstance(node, ast.Name) and node.id in names:
        return names[node.id]
    if isinstance(node, ast.Attribute) and ast.unparse(node) in ("math.pi", "np.pi", "numpy.pi"):
        return math.pi
    try:
        result = _combined(node, names)
    except (ArithmeticError, LookupError, TypeError, ValueError) as problem:
        raise Unknown from problem
    too_long = isinstance(result, str | list) and len(result) > _MOST_VALUES
    if too_long or (isinstance(result, int) and abs(result) > _LARGEST):
        raise Unknown
    return result


def _combined(node: ast.expr, names: Names) -> Any:
    if isinstance(node, ast.JoinedStr):
        parts = [part.value if isinstance(part, ast.FormattedValue) else part for part in node.values]
        if any(
            isinstance(part, ast.FormattedValue) and (part.format_spec or part.conversion != -1) for part in node.values
        ):
            raise Unknown
        return "".join(str(value(part, names)) for part in parts)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -value(node.operand, names)
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        left, right = value(node.left, names), value(node.right, names)
        if isinstance(node.op, ast.Mult) and not all(isinstance(side, int | float) for side in (left, right)):
            raise Unknown
        return _BINARY[type(node.op)](left, right)
    if isinstance(node, ast.Subscript):
        return value(node.value, names)[value(node.slice, names)]
    if isinstance(node, ast.Dict) and None not in node.keys:
        return {value(key, names): value(of, names) for key, of in zip(node.keys, node.values, strict=True) if key}
    if not isinstance(node, ast.Call) or (node.keywords and ast.unparse(node.func) != "LaunchConfiguration"):
        raise Unknown
    function, arguments = ast.unparse(node.func), [value(argument, names) for argument in node.args]
    if function == "LaunchConfiguration" and arguments:
        return names[_ARGUMENT + arguments[0]]
    if isinstance(node.func, ast.Attribute) and node.func.attr == "split" and len(arguments) < 2:
        text = value(node.func.value, names)
        if isinstance(text, str):
            return text.split(*arguments)
    if function in ("str", *_NUMBERS) and len(arguments) == 1 and isinstance(arguments[0], str | int | float):
        return _NUMBERS.get(function, str)(arguments[0])
    if function in ("os.path.join", "path.join", "join") and all(isinstance(one, str) for one in arguments):
        return "/".join(argument.rstrip("/") for argument in arguments)
    if function in ("glob", "glob.glob") and len(arguments) == 1:
        return arguments
    raise Unknown


def constants(tree: ast.AST, names: Names = MappingProxyType({})) -> dict[str, Any]:
    """Return ``names``, and those that a program or function assigns once, and to a plain value.

    What it assigns more often, or changes in place, has no known value. A launch argument has its default.
    """
    nodes = list(ast.walk(tree))
    times = Counter(node.id for node in nodes if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load))
    declared, defaults = Counter[str](), dict[str, Any]()
    assigned: list[tuple[ast.expr, ast.expr]] = []
    for node in nodes:
        if isinstance(node, ast.Assign):
            assigned += [(target, node.value) for target in node.targets]
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            assigned.append((node.target, node.value))
        changed: ast.expr | None = None  # in place, by name.append(...) or name[0] = ...
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _CHANGES:
            changed = node.func.value
        elif isinstance(node, ast.Subscript) and not isinstance(node.ctx, ast.Load):
            changed = node.value
        times.update([changed.id] if isinstance(changed, ast.Name) else [])
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "DeclareLaunchArgument" and node.args:
            given = next((word.value for word in node.keywords if word.arg == "default_value"), None)
            with suppress(Unknown):
                name = f"{_ARGUMENT}{value(node.args[0], names)}"
                declared[name] += 1
                defaults |= {} if given is None else {name: value(given, names)}
    values = {name: known for name, known in names.items() if not times[name]}
    values |= {name: text for name, text in defaults.items() if declared[name] == 1 and isinstance(text, str)}
    for target, expression in assigned:
        if isinstance(target, ast.Name) and times[target.id] == 1:
            with suppress(Unknown):
                values[target.id] = value(expression, values)
    return values

"""Launch files of people: the nodes that they start, read and never run.

Of Python, plain values are evaluated; what only a run would know is unknown here.
"""

from __future__ import annotations

import ast
import math
import operator
import re
import shlex
from collections import Counter
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
_VARIABLE = re.compile(r"\$\((?:var|arg) ([^\s()$]+)\)")


class LaunchError(Exception):
    """A launch file that cannot be parsed; the message says why."""


class Unknown(Exception):
    """The value is known only when the program runs."""


@dataclass(frozen=True)
class Entry:
    """A node of a launch file in XML or YAML, or a remap of all nodes, which has no name.

    ``remaps`` are names from and to, each pair with its place.
    """

    name: str
    executables: tuple[str, ...]
    arguments: str
    remaps: tuple[tuple[str, str, Span], ...]
    line: int = 1


def entries_of(source: Source, is_yaml: bool) -> tuple[list[Entry], dict[str, str]]:
    """Return the nodes of a launch file in XML or YAML, and the values of its variables. Raises LaunchError."""
    return _yaml(source) if is_yaml else _xml(source)


def _xml(source: Source) -> tuple[list[Entry], dict[str, str]]:
    try:
        elements = list(parse(source).root.iter())
    except MarkupError as problem:
        raise LaunchError(f"not XML: {problem.diagnostic.message}") from None
    passed = {id(inner) for one in elements if one.tag == "include" for inner in one.iter()}  # to another file
    declared = [one for one in elements if one.tag in ("arg", "let") and id(one) not in passed]
    found = []
    for one in elements:
        if one.tag == "set_remap":
            found.append(Entry("", (), "", ((one.get("from"), one.get("to"), one.span),), one.span.line))
        elif one.tag == "node":
            rows = tuple((each.get("from"), each.get("to"), each.span) for each in one.iter() if each.tag == "remap")
            programs = (one.get("exec"), one.get("type"))
            found.append(Entry(one.get("name") or programs[0], programs, one.get("args"), rows, one.span.line))
    return found, {one.get("name"): one.get("default", one.get("value")) for one in declared}


def _yaml(source: Source) -> tuple[list[Entry], dict[str, str]]:
    try:
        maps = list(_maps(parse_yaml(source)))
    except LoadError as problem:
        raise LaunchError(f"not YAML: {problem.diagnostic.message}") from None
    named = [one[key] for one in maps for key in ("arg", "let") if isinstance(one.get(key), dict)]
    found = []
    for one in maps:
        node = one.get("node")
        if isinstance(node, dict):
            remaps = node.get("remap")
            pairs = [each for each in remaps if isinstance(each, Map)] if isinstance(remaps, list) else []
            rows = tuple((str(each.get("from", "")), str(each.get("to", "")), each.locate(()).span) for each in pairs)
            program, line = str(node.get("exec", "")), one.key_spans["node"].line
            arguments, name = str(node.get("args", "")), str(node.get("name") or program)
            found.append(Entry(name, (program,), arguments, rows, line))
    return found, {str(one.get("name")): str(one.get("default", one.get("value", ""))) for one in named}


def _maps(tree: Any) -> Iterator[Any]:
    if isinstance(tree, dict):
        yield tree
    for child in tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ():
        yield from _maps(child)


def split(arguments: str, variables: Mapping[str, str]) -> tuple[str, ...] | None:
    """Return arguments of XML or YAML as words, with the defaults of launch arguments; None if they are not plain."""
    pieces = _VARIABLE.split(arguments)
    plain, names = pieces[::2], pieces[1::2]
    if re.search(r"(?<!\\)\$\(", "".join(plain)) or any(name not in variables for name in names):
        return None
    texts = [re.sub(r"\\(.)", r"\1", piece) for piece in plain]
    values = [shlex.quote(variables[name]) for name in names]
    try:
        return tuple(shlex.split("".join(text + value for text, value in zip(texts, [*values, ""], strict=True))))
    except ValueError:
        return None


def python_tree(text: str) -> ast.AST:
    """Return the syntax tree of a launch file in Python. Raises LaunchError."""
    try:
        return python_of(text)
    except (SyntaxError, ValueError, MemoryError, RecursionError) as problem:
        raise LaunchError(f"not a Python file: {problem}") from None


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

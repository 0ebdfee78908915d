"""Static transforms in launch files that people wrote: read from Python, XML and YAML, and never run."""

from __future__ import annotations

import ast
import re
import shlex
from collections import deque
from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any, NamedTuple

from ..diagnostic import Source
from .evaluating import Unknown, constants, value

PUBLISHER = "static_transform_publisher"
_ENDINGS = (".launch.py", "_launch.py", ".launch.xml", ".launch.yaml", ".launch.yml", ".launch")
_VARIABLE = re.compile(r"\$\((?:var|arg) ([^\s()$]+)\)")
_MOST = 500  # static transforms in one file


class Call(NamedTuple):
    """A static_transform_publisher of a launch file: its line, and its arguments, None if they are not plain."""

    line: int
    arguments: tuple[str, ...] | None


class Unreadable(Exception):
    """A launch file that cannot be parsed; the message says why."""


def is_launch_file(name: str) -> bool:
    """Say whether a file is a launch file, by its name."""
    return name.endswith(_ENDINGS) or ("launch/" in name and name.endswith(".py"))


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
    """Yield every call of a program with the function around it."""
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
    if not isinstance(arguments, list) or not all(isinstance(argument, str) for argument in arguments):
        return None
    return tuple(arguments)


def _calls_of(function: str, tree: ast.Module) -> Iterator[ast.Call]:
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name))
    yield from sorted((call for call in calls if ast.unparse(call.func) == function), key=lambda call: call.lineno)


def _parameters(function: ast.FunctionDef) -> set[str]:
    every = function.args
    more = [one for one in (every.vararg, every.kwarg) if one is not None]
    return {argument.arg for argument in (*every.posonlyargs, *every.args, *every.kwonlyargs, *more)}


def _inside(function: ast.FunctionDef, names: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``names`` as a function has them whoever calls it: without its parameters, with its own constants."""
    taken = _parameters(function)
    return constants(function, {name: known for name, known in names.items() if name not in taken})


def _bound(function: ast.FunctionDef, call: ast.Call, names: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``names`` as they are inside a function: its parameters have the plain values of a call, or no value."""
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
    from ..importing.markup import MarkupError, parse

    try:
        root = parse(Source(name, text)).root
    except MarkupError as problem:
        raise Unreadable(f"not XML: {problem.diagnostic.message}") from None
    elements = list(root.iter())
    variables = {e.get("name"): e.get("default", e.get("value")) for e in elements if e.tag in ("arg", "let")}
    for element in elements:
        if element.tag == "node" and PUBLISHER in (element.get("exec"), element.get("type")):
            yield Call(element.span.line, split(element.get("args"), variables))


def _yaml(name: str, text: str) -> Iterator[Call]:
    from ..load import LoadError, parse_yaml

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
    """Yield every mapping of a tree."""
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

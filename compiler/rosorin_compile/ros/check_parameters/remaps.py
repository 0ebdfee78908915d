"""Remaps: which topic a node really publishes on, by the command line and by launch files.

A launch file is read and never run. Of one in Python, what is no plain value is told, for nobody knows it here.
"""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.ros.python_values import Unknown, constants, value
from rosorin_compile.source.bounded import python_of
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Source, Span, error
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import parse

RULES = (
    Rule(
        "parameters-launch",
        "A launch file cannot be read; a warning where it says remaps that are known only when it runs.",
        "Say them by `--remap NODE:FROM:=TO`.",
        Heading.PARAMETERS,
    ),
)

TF = "tf"
# Nodes that run others in their process: what they are told holds for all of them.
_HOSTS = ("controller_manager", "ros2_control_node")
_FLAGS = ("-r", "--remap")


class Remap(NamedTuple):
    """One rule: names as they are written. ``node`` is the name of the node that it is for; empty for all."""

    node: str
    name: str
    to: str


def of_word(word: str) -> Remap | None:
    """Return what a text such as NODE:FROM:=TO says; None if it is no remap."""
    left, mark, to = word.partition(":=")
    node, colon, name = left.rpartition(":")
    if not mark or not name or not to or (colon and not node):
        return None
    return Remap(node.strip("/").rsplit("/", 1)[-1], name, to)


def full_name(name: str, namespace: str, node: str) -> str:
    """Return the full name of a topic, as a node in a namespace has it."""
    inside = namespace.rstrip("/")
    if name.startswith("~/"):
        return f"{inside}/{node}/{name[2:]}"
    return name if name.startswith("/") else f"{inside}/{name}"


def topic(name: str, namespace: str, node: str, remaps: Iterable[Remap]) -> str:
    """Return the topic that a node publishes on under ``name``: the first rule that fits is followed."""
    full = full_name(name, namespace, node)
    for remap in remaps:
        if remap.node in ("", node) and full_name(remap.name, namespace, node) == full:
            return full_name(remap.to, namespace, node)
    return full


def is_tf(topic: str, namespace: str) -> bool:
    """Say whether a topic is the one that tf2 listens to: /tf, or that of the namespace."""
    return topic in (f"/{TF}", full_name(TF, namespace, ""))


def of_launch(path: Path) -> tuple[list[Remap], list[Diagnostic]]:
    """Return the remaps that a launch file says, and what is to say of it."""
    from rosorin_compile.source.load import LoadError, read_utf8

    try:
        source = read_utf8(path, str(path))
    except LoadError as problem:
        return [], [problem.diagnostic]
    reader = _python if path.suffix == ".py" else _yaml if path.suffix in (".yaml", ".yml") else _xml
    try:
        return reader(source)
    except _Unreadable as problem:
        return [], [error("parameters-launch", f"{path} is no launch file: {problem}", None, "name a launch file")]


class _Unreadable(Exception):
    """A file that cannot be parsed; the message says why."""


def _python(source: Source) -> tuple[list[Remap], list[Diagnostic]]:

    try:
        tree = python_of(source.text)
    except (SyntaxError, ValueError) as problem:
        raise _Unreadable(f"not a Python file: {problem}") from None
    names = constants(tree)
    found: list[Remap] = []
    told: list[Diagnostic] = []
    for call in ast.walk(tree):
        if isinstance(call, ast.Call) and ast.unparse(call.func).rsplit(".", 1)[-1].endswith(("Node", "SetRemap")):
            try:
                found += _of_call(call, names)
            except Unknown:
                span = Span(source, call.lineno, call.col_offset + 1)
                message = "which remaps this node has is known only when the launch file runs"
                help = "say them: --remap NODE:FROM:=TO"
                told.append(Diagnostic("parameters-launch", WARNING, message, span, help=help))
    return found, told


def _of_call(call: ast.Call, names: Mapping[str, Any]) -> Iterator[Remap]:
    given = {word.arg: word.value for word in call.keywords if word.arg}
    node = ""
    for key in ("name", "executable"):
        if key in given and not node:
            node = _text(given[key], names)
    node = "" if node in _HOSTS else node
    if "src" in given and "dst" in given:
        yield Remap("", str(value(given["src"], names)), str(value(given["dst"], names)))
    pairs = value(given["remappings"], names) if "remappings" in given else []
    for pair in pairs:
        if not (isinstance(pair, list) and len(pair) == 2 and all(isinstance(one, str) for one in pair)):
            raise Unknown
        yield Remap(node, *pair)
    for key in ("arguments", "ros_arguments"):
        yield from _of_arguments(_words(given.get(key), names), node)


def _text(node: ast.expr, names: Mapping[str, Any]) -> str:
    try:
        return str(value(node, names))
    except Unknown:
        return ""


def _words(node: ast.expr | None, names: Mapping[str, Any]) -> list[str]:
    return [_text(item, names) for item in node.elts] if isinstance(node, (ast.List, ast.Tuple)) else []


def _of_arguments(words: list[str], node: str) -> Iterator[Remap]:
    for flag, word in pairwise(words):
        if flag in _FLAGS and (remap := of_word(word)) is not None:
            yield remap if remap.node else remap._replace(node=node)
        elif flag == "--controller-ros-args":
            spawned = next((one for one in words if not one.startswith("-")), "")
            yield from _of_arguments(word.split(), spawned)


def _xml(source: Source) -> tuple[list[Remap], list[Diagnostic]]:
    from rosorin_compile.source.xml.markup import MarkupError

    try:
        root = parse(source).root
    except MarkupError as problem:
        raise _Unreadable(problem.diagnostic.message) from None
    found: list[Remap] = []
    told: list[Diagnostic] = []
    for element in root.iter():
        if element.tag == "set_remap":
            found.append(Remap("", element.get("from"), element.get("to")))
        if element.tag != "node":
            continue
        rows = [(one.get("from"), one.get("to"), one.span) for one in element.iter() if one.tag == "remap"]
        _take(element.get("name") or element.get("exec"), rows, element.get("args"), found, told)
    return found, told


def _yaml(source: Source) -> tuple[list[Remap], list[Diagnostic]]:
    from rosorin_compile.source.load import LoadError, parse_yaml
    from rosorin_compile.source.tree import Map

    try:
        tree = parse_yaml(source)
    except LoadError as problem:
        raise _Unreadable(problem.diagnostic.message) from None
    found: list[Remap] = []
    told: list[Diagnostic] = []
    for entry in _maps(tree):
        node = entry.get("node")
        if not isinstance(node, dict):
            continue
        remaps = node.get("remap")
        pairs = [one for one in remaps if isinstance(one, Map)] if isinstance(remaps, list) else []
        rows = [(str(one.get("from", "")), str(one.get("to", "")), one.locate(()).span) for one in pairs]
        _take(str(node.get("name") or node.get("exec", "")), rows, str(node.get("args", "")), found, told)
    return found, told


def _take(
    name: str, rows: Iterable[tuple[str, str, Span]], args: str, found: list[Remap], told: list[Diagnostic]
) -> None:
    node = "" if name in _HOSTS else name
    for source, to, span in rows:
        if re.search(r"\$\(", source + to):
            message = "which topic is remapped is known only when the launch file runs"
            help = "say it: --remap NODE:FROM:=TO"
            told.append(Diagnostic("parameters-launch", WARNING, message, span, help=help))
        else:
            found.append(Remap(node, source, to))
    try:
        words = shlex.split(args or "")
    except ValueError:
        words = []
    found += _of_arguments(words, node)


def _maps(tree: Any) -> Iterator[Any]:
    if isinstance(tree, dict):
        yield tree
    for child in tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ():
        yield from _maps(child)

"""Remaps: which topic a node really publishes on, by the command line and by launch files.

A launch file is read and never run. Of one in Python, what is no plain value is told, for nobody knows it here.
"""

from __future__ import annotations

import ast
import shlex
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Source, Span, error
from rosorin_compile.source.rule_registry import Heading, Rule

from ..launch_reader import LaunchError, Unknown, constants, entries_of, python_tree, value

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
    try:
        if path.suffix == ".py":
            return _python(source)
        return _frontend(source, path.suffix in (".yaml", ".yml"))
    except LaunchError as problem:
        return [], [error("parameters-launch", f"{path} is no launch file: {problem}", None, "name a launch file")]


def _python(source: Source) -> tuple[list[Remap], list[Diagnostic]]:
    tree = python_tree(source.text)
    names = constants(tree)
    found: list[Remap] = []
    told: list[Diagnostic] = []
    for call in ast.walk(tree):
        if isinstance(call, ast.Call) and ast.unparse(call.func).rsplit(".", 1)[-1].endswith(("Node", "SetRemap")):
            try:
                found += _of_call(call, names)
            except Unknown:
                span = Span(source, call.lineno, call.col_offset + 1)
                told.append(_unknown("which remaps this node has is", span))
    return found, told


def _unknown(what: str, span: Span) -> Diagnostic:
    help = "say it: --remap NODE:FROM:=TO" if what.startswith("which topic") else "say them: --remap NODE:FROM:=TO"
    message = f"{what} known only when the launch file runs"
    return Diagnostic("parameters-launch", WARNING, message, span, help=help)


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
        words = given.get(key)
        items = words.elts if isinstance(words, (ast.List, ast.Tuple)) else ()
        yield from _of_arguments([_text(item, names) for item in items], node)


def _text(node: ast.expr, names: Mapping[str, Any]) -> str:
    try:
        return str(value(node, names))
    except Unknown:
        return ""


def _of_arguments(words: list[str], node: str) -> Iterator[Remap]:
    for flag, word in pairwise(words):
        if flag in _FLAGS and (remap := of_word(word)) is not None:
            yield remap if remap.node else remap._replace(node=node)
        elif flag == "--controller-ros-args":
            spawned = next((one for one in words if not one.startswith("-")), "")
            yield from _of_arguments(word.split(), spawned)


def _frontend(source: Source, is_yaml: bool) -> tuple[list[Remap], list[Diagnostic]]:
    found: list[Remap] = []
    told: list[Diagnostic] = []
    for one in entries_of(source, is_yaml)[0]:
        node = "" if one.name in _HOSTS else one.name
        for old, new, span in one.remaps:
            if "$(" in old + new:
                told.append(_unknown("which topic is remapped is", span))
            else:
                found.append(Remap(node, old, new))
        with suppress(ValueError):
            found += _of_arguments(shlex.split(one.arguments or ""), node)
    return found, told

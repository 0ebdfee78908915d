"""Names for shell completion: robots, frames, joints, poses, arguments and formats.

Nothing that a description names is run: a xacro file offers only the names of its arguments.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, NoReturn

import click
from click.shell_completion import CompletionItem

from .table import names

if TYPE_CHECKING:
    from rosorin_compile.source.project import Description

_MAX_ROBOTS = 8
_XACRO_ARGUMENT = re.compile(r"<xacro:arg\s[^>]*?name=[\"']([^\"']+)[\"']")
# The kinds that depend on a robot, each with the kinds of symbols.
_OF_ROBOT: dict[str, tuple[str, ...]] = {kind: (kind,) for kind in ("argument", "joint", "pose", "mode", "output")}
_OF_ROBOT |= {"frame": ("link",), "thing": ("link", "joint", "sensor")}

Complete = Callable[[click.Context, click.Parameter, str], "list[CompletionItem]"]


def complete(*kinds: str) -> Complete:
    """Return a completion with the names of these kinds; "joint=" offers joints, each with an equals sign."""

    def offered(ctx: click.Context, _: click.Parameter, incomplete: str) -> list[CompletionItem]:
        found: dict[str, str] = {}
        for kind in reversed(kinds):
            suffix = "=" if kind.endswith("=") else ":=" if kind == "argument" else ""
            with suppress(Exception):
                found |= {name + suffix: help for name, help in _names(kind.rstrip("="), ctx).items()}
        shown = ((name, help) for name, help in found.items() if name.startswith(incomplete) and name.isprintable())
        items = [CompletionItem(name, help=help or None) for name, help in shown]
        return items or ([CompletionItem(incomplete, type="file")] if {"robot", "file"} & set(kinds) else [])

    return offered


def _names(kind: str, ctx: click.Context) -> dict[str, str]:
    """Return the names of a kind, with their help if there is any."""
    from rosorin_compile.formats import FORMATS, schema_names
    from rosorin_compile.source.project import Description, all_here, here
    from rosorin_compile.source.rule_registry import find

    if kind in _OF_ROBOT:
        robots: list[Description] = []
        for word in ctx.params.get("words") or ():
            with suppress(Exception):
                robots.append(Description.find([word])[0])
        robots = (robots or here())[:_MAX_ROBOTS]
        return {name: robot.name for robot in reversed(robots) for name in _names_of_robot(kind, robot, ctx)}
    if kind == "robot":
        return {path.parent.name: "robot of this project" for path in all_here()}
    if kind == "format":
        return {format.name: format.about for format in FORMATS.values() if format.write is not None}
    if kind == "rule":
        return dict.fromkeys(sorted(find()), "")
    return schema_names() if kind == "schema" else names(kind) if kind in ("commands", "checks") else {}


def _names_of_robot(kind: str, description: Description, ctx: click.Context) -> Iterable[str]:
    """Return the names of one kind of a robot, which is read without running anything."""
    from rosorin_compile.language.arguments import declared_arguments
    from rosorin_compile.language.symbols import SymbolTable
    from rosorin_compile.request import Request, is_foreign

    def stop(*_: object) -> NoReturn:
        raise PermissionError

    path = description.path
    if kind == "argument" and is_foreign(path):
        return _XACRO_ARGUMENT.findall(path.read_text("utf-8", "replace"))
    arguments = ctx.params.get("arg") or {}
    if kind == "argument":
        return [argument.name for argument in declared_arguments(path, {})[0]]
    tree = Request(description, arguments, warn=stop).understand().expanded.tree  # a xacro file can run code
    symbols = SymbolTable(tree).definitions(implied=True) if tree is not None else ()
    found = dict.fromkeys(symbol.name for symbol in symbols if symbol.kind in _OF_ROBOT[kind])
    return [f"{name}{state}" for name in found for state in ("", "=off")] if kind == "mode" else found

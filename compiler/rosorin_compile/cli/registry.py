"""The registry of commands and checks: their modules are imported when a name is called.

Plug-ins add more by entry points, whose names are those of their commands; nothing of a plug-in is imported that is
not called.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rosorin_compile.source.diagnostics import nearest
from rosorin_compile.source.plugins import PluginFailed, broken, clash, installed, load
from rosorin_compile.source.project import ROOT_FILE, Description, NoDescription, all_here

from .command import Check, Command
from .table import BUILT_IN, CHECK, GROUPS, Entry, entry, names

if TYPE_CHECKING:
    from rosorin_compile.source.diagnostics import Diagnostic


def command(name: str) -> click.Command | None:
    """Return the command of a name; built-in commands come first. Raises PluginFailed."""
    return _find(name, "commands")


def check(name: str) -> click.Command | None:
    """Return the check of a name; one of a plug-in may also be called DISTRIBUTION:NAME. Raises PluginFailed."""
    distribution, _, inner = name.rpartition(":")
    if distribution and distribution == _distribution("checks", inner):
        return _of_plugin(inner, "checks")
    return _find(name, "checks")


def _find(name: str, group: str) -> click.Command | None:
    listed = entry(name, group)
    if listed is None:
        return _of_plugin(name, group)
    _warn(clash(one, name) for one in installed() if (one.group, one.name) == (group, name))
    found: click.Command = import_module(f"rosorin_compile.cli.{listed.module}").run
    return found


def _of_plugin(name: str, group: str) -> click.Command | None:
    if not _distribution(group, name):
        return None
    commands, wrong = _load(group, (), name)
    if wrong and not commands:
        raise PluginFailed(wrong[0])
    _warn(wrong)
    return next(iter(commands), None)


def _distribution(group: str, name: str) -> str:
    """Return the distribution that brings a plug-in of a name, or an empty string. Nothing is imported."""
    return next((one.distribution for one in installed() if (one.group, one.name) == (group, name)), "")


def _load(group: str, taken: Iterable[str], called: str | None = None) -> tuple[list[Command], list[Diagnostic]]:
    """Load the commands of plug-ins, of one name or all; return them, and diagnostics about invalid ones."""
    kind = Check if group == "checks" else Command
    found, diagnostics = load(group, kind, lambda one: (one.name or "", *one.also), set(taken).__contains__, called)
    good, wrong = [], list(diagnostics)
    for plugin, one in found:
        if one.name != plugin.name:
            wrong.append(broken(plugin, f'is called "{one.name}", and its entry point "{plugin.name}"'))
        else:
            one.plugin = plugin
            good.append(one)
    return good, wrong


def _warn(diagnostics: Iterable[Diagnostic]) -> None:
    """Report what is wrong with plug-ins that this run does not need."""
    from rosorin_compile.cli.console import Console
    from rosorin_compile.source.diagnostics import WARNING

    Console("text").show([replace(one, severity=WARNING) for one in diagnostics])


def commands(group: str = "commands") -> dict[str, Entry]:
    """Return all commands or checks by name, as the help lists them: group by group, each in its order."""
    found = [*BUILT_IN[group]]
    if any(one.group == group for one in installed()):
        more, wrong = _load(group, [name for one in found for name in (one.name, *one.also)])
        _warn(wrong)
        found += [Entry(one.name or "", "", one.group, one.help or "", one.order, one.also, one.hidden) for one in more]
    groups = list(dict.fromkeys([*GROUPS, *(one.group for one in found)]))
    return {one.name: one for one in sorted(found, key=lambda one: (groups.index(one.group), one.order))}


def resolve_check(command: click.Command, words: list[str]) -> tuple[str, click.Command, list[str]]:
    """Return the check that the words after ``check`` name, or ``check`` itself, with the words that are left.

    The name of a built-in check comes before a robot of that name, which is reached by its path. A robot of the project
    comes before a check of a plug-in, which is reached as DISTRIBUTION:NAME.
    """
    values = {name for one in command.params if isinstance(one, click.Option) and not one.is_flag for name in one.opts}
    places = _words(words, values)
    if not places:
        return CHECK, command, words
    name = words[places[0]]
    built_in, distribution = entry(name, "checks") is not None, _distribution("checks", name)
    if not built_in and distribution and name in {path.parent.name for path in all_here()}:
        way = f"rosorin-compile {CHECK} {distribution}:{name}"
        _report(f'"{name}" is a robot here; the check of that name of {distribution}: {way}')
        return CHECK, command, words
    found = check(name)
    if found is None:
        _report_mistake(name, [words[place] for place in places[1:]])
        return CHECK, command, words
    robot = _robot(name) if built_in else None
    if robot is not None:
        path = robot.path.parent if robot.path.name == ROOT_FILE else robot.path
        shown = f"./{path}" if path == Path(name) else str(path)
        _report(f'"{name}" is a check; the robot of that name: rosorin-compile {CHECK} {shown}')
    return f"{CHECK} {name}", found, words[: places[0]] + words[places[0] + 1 :]


def _words(words: Sequence[str], with_value: set[str]) -> list[int]:
    """Return the indices of the words before ``--`` that are no option and no value of one."""
    end = words.index("--") if "--" in words else len(words)
    before = ["", *words]
    return [at for at in range(end) if not words[at].startswith("-") and before[at] not in with_value]


def _report_mistake(name: str, later: Sequence[str]) -> None:
    """Report a check that is named after the robot, or a misspelt one."""
    named = next((one for one in later if entry(one, "checks") and not _robot(one) and not Path(one).exists()), None)
    close = nearest(name, names("checks"))
    if named:
        _report(f'"{named}" is a check; write it before the robot: {CHECK} {named} ROBOT')
    elif close not in (None, name) and _robot(name) is None:
        _report(f'"{name}" is no check; did you mean "{close}"?')


def _robot(name: str) -> Description | None:
    try:
        return Description.find([name])[0]
    except NoDescription:
        return None


def _report(message: str) -> None:
    sys.stderr.write(f"rosorin-compile: {message}\n")

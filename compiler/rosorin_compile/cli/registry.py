"""The built-in commands and checks, and those of plug-ins: their modules are imported when a name is called.

The names of the entry points of plug-ins are those of their commands, so that nothing of a plug-in is imported that is
not called.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rosorin_compile.source.diagnostics import WARNING, nearest
from rosorin_compile.source.plugins import PluginFailed, broken_plugin, clash, installed_plugins, load
from rosorin_compile.source.project import ROOT_FILE, Description, NoDescription, all_here
from rosorin_compile.source.wording import suggest

from .command import Command
from .table import ALIASES, BUILT_IN, CHECK, CHECKS, COMMANDS, MODULES, Entry, names

if TYPE_CHECKING:
    from rosorin_compile.source.diagnostics import Diagnostic


def commands(group: str = "commands") -> dict[str, Entry]:
    """Return all commands or checks by name, as the help lists them: group by group."""
    found = {**BUILT_IN[group]}
    if any(one.group == group for one in installed_plugins()):
        more, wrong = _load(group, [*found, *ALIASES])
        _warn(wrong)
        found |= {one.name or "": Entry(one.name or "", one.group, one.help or "", one.hidden) for one in more}
    groups = list(dict.fromkeys([*COMMANDS, *(one.group for one in found.values())]))
    return dict(sorted(found.items(), key=lambda item: groups.index(item[1].group)))


def command(name: str, group: str = "commands") -> click.Command | None:
    """Return the command or check of a name, or None; built-in ones come first. Raises PluginFailed.

    A check of a plug-in may also be called DISTRIBUTION:NAME.
    """
    distribution, _, inner = name.rpartition(":")
    own = ALIASES.get(name, name)
    if own in BUILT_IN[group]:
        _warn(clash(one, name) for one in installed_plugins() if (one.group, one.name) == (group, name))
        module = import_module(f".{MODULES.get(own, own)}", __package__)
        return next(one for one in vars(module).values() if isinstance(one, click.Command) and one.name == own)
    brings = _distribution(group, inner)
    if not brings or distribution not in ("", brings):
        return None
    found, wrong = _load(group, (), inner)
    if wrong and not found:
        raise PluginFailed(wrong[0])
    _warn(wrong)
    return next(iter(found), None)


def _distribution(group: str, name: str) -> str:
    """Return the distribution that brings a plug-in of a name, or an empty string. Nothing is imported."""
    return next((one.distribution for one in installed_plugins() if (one.group, one.name) == (group, name)), "")


def _load(group: str, taken: Iterable[str], called: str | None = None) -> tuple[list[Command], list[Diagnostic]]:
    """Load the commands of plug-ins, of one name or all; return them, and diagnostics about invalid ones."""
    found, diagnostics = load(group, Command, lambda one: (one.name or "",), set(taken).__contains__, called)
    good, wrong = [], list(diagnostics)
    for plugin, one in found:
        if one.name != plugin.name:
            wrong.append(broken_plugin(plugin, f'is called "{one.name}", and its entry point "{plugin.name}"'))
        else:
            one.plugin = plugin
            good.append(one)
    return good, wrong


def _warn(diagnostics: Iterable[Diagnostic]) -> None:
    """Report what is wrong with plug-ins that this run does not need."""
    from .console import Console

    Console().show([replace(one, severity=WARNING) for one in diagnostics])


def resolve_check(check: click.Command, words: list[str]) -> tuple[str, click.Command, list[str]]:
    """Return the check that the words after ``check`` name, or ``check`` itself, with the words that are left.

    The name of a built-in check comes before a robot of that name, which is reached by its path. A robot of the project
    comes before a check of a plug-in, which is reached as DISTRIBUTION:NAME.
    """
    options = [one for one in check.params if isinstance(one, click.Option)]
    takes_value = {name for one in options if not one.is_flag for name in one.opts}
    end = words.index("--") if "--" in words else len(words)
    places = [at for at in range(end) if not words[at].startswith("-") and not (at and words[at - 1] in takes_value)]
    if not places:
        return CHECK, check, words
    name = words[places[0]]
    distribution, robot = _distribution("checks", name), _robot(name)
    if name not in CHECKS and distribution and name in {path.parent.name for path in all_here()}:
        other = f"rosorin-compile {CHECK} {distribution}:{name}"
        _report(f'"{name}" is a robot here; the check of that name of {distribution}: {other}')
        return CHECK, check, words
    found = command(name, "checks")
    if found is not None:
        if robot is not None and name in CHECKS:
            path = robot.path.parent if robot.path.name == ROOT_FILE else robot.path
            shown = f"./{path}" if path == Path(name) else str(path)
            _report(f'"{name}" is a check; the robot of that name: rosorin-compile {CHECK} {shown}')
        return f"{CHECK} {name}", found, words[: places[0]] + words[places[0] + 1 :]
    close = nearest(name, names("checks"))
    if close not in (None, name) and robot is None:
        _report(f'"{name}" is no check; {suggest(close)}')
    return CHECK, check, words


def _robot(name: str) -> Description | None:
    with suppress(NoDescription):
        return Description.find([name])[0]
    return None


def _report(message: str) -> None:
    sys.stderr.write(f"rosorin-compile: {message}\n")

"""The registry of commands and checks: their modules are imported when a name is called.

Plug-ins add more by entry points, whose names are those of their commands; nothing of a plug-in is imported that is
not called.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING

from rosorin_compile.source.plugins import PluginFailed, broken, clash, installed, load

from .table import GROUPS, OWN, Entry, entry, is_own

if TYPE_CHECKING:
    import click

    from rosorin_compile.source.diagnostics import Diagnostic

    from .command import Command


def command(name: str) -> click.Command | None:
    """Return the command of a name or an alternative name; built-in commands come first. Raises PluginFailed."""
    return _find(name, "commands", name)


def check(name: str) -> click.Command | None:
    """Return the check of a name; one of a plug-in may also be called DISTRIBUTION:NAME. Raises PluginFailed."""
    distribution, _, inner = name.rpartition(":")
    return _find(inner if distribution and distribution == whose("checks", inner) else name, "checks", name)


def _find(name: str, group: str, typed: str) -> click.Command | None:
    if typed == name and is_own(name, group):
        warn_of_plugins(clash(one, name) for one in installed() if (one.group, one.name) == (group, name))
        found: click.Command = import_module(f"rosorin_compile.cli.{entry(name, group).module}").run
        return found
    if not whose(group, name):
        return None
    commands, wrong = _of_plugins(group, (), name)
    if wrong and not commands:
        raise PluginFailed(wrong[0])
    warn_of_plugins(wrong)
    return next(iter(commands), None)


def whose(group: str, name: str) -> str:
    """Return the distribution that brings a plug-in of a name, or an empty string. Nothing is imported."""
    return next((one.distribution for one in installed() if (one.group, one.name) == (group, name)), "")


def _of_plugins(group: str, taken: Iterable[str], called: str | None = None) -> tuple[list[Command], list[Diagnostic]]:
    """Return the commands of plug-ins, of one name or all, and diagnostics about invalid ones."""
    from .command import Check, Command

    kind = Check if group == "checks" else Command
    found, said = load(group, kind, lambda one: (one.name or "", *one.also), set(taken).__contains__, called)
    good, wrong = [], list(said)
    for plugin, one in found:
        if one.name != plugin.name:
            wrong.append(broken(plugin, f'is called "{one.name}", and its entry point "{plugin.name}"'))
        else:
            one.plugin = plugin
            good.append(one)
    return good, wrong


def warn_of_plugins(diagnostics: Iterable[Diagnostic]) -> None:
    """Report what is wrong with plug-ins that this run does not need."""
    from rosorin_compile.source.console import Console
    from rosorin_compile.source.diagnostics import WARNING

    Console("text").show([replace(one, severity=WARNING) for one in diagnostics])


def commands(of_plugins: bool = True) -> dict[str, Entry]:
    """Return all commands by name, as the help lists them: group by group, each in its order."""
    found = _all("commands", of_plugins)
    groups = list(dict.fromkeys([*GROUPS, *(one.group for one in found)]))
    found.sort(key=lambda one: (groups.index(one.group), one.order))
    return {one.name: one for one in found}


def checks(of_plugins: bool = True) -> dict[str, Entry]:
    """Return all checks by name, as the help of ``check`` lists them."""
    return {one.name: one for one in _all("checks", of_plugins)}


def _all(group: str, of_plugins: bool) -> list[Entry]:
    found = [*OWN[group]]
    if of_plugins and any(one.group == group for one in installed()):
        more, wrong = _of_plugins(group, [name for one in found for name in one.names])
        warn_of_plugins(wrong)
        found += [Entry(one.name or "", "", one.group, one.help or "", one.order, one.also, one.hidden) for one in more]
    return found


def names(group: str) -> dict[str, str]:
    """Return the names of all "commands" or "checks" with their help; plug-ins are named, but not imported."""
    own = {one.name: one.help for one in OWN[group] if not one.hidden}
    return {**{one.name: f"of {one.distribution} {one.version}" for one in installed() if one.group == group}, **own}

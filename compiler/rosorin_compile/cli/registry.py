"""The records that there are, found by their names: those of the program's own packages, and those of plug-ins.

Own packages say theirs in the modules of ``SHIPPED``: ``COMMANDS``, ``CHECKS``, and in ``SERVICES`` what they do for
others: for commands of the core, and for each other. Those of others are entry points; the name of one is that of its
record, so nothing of a plug-in is imported that is not called.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rosorin_compile.source.plugins import Plugin, PluginFailed, broken, clash, failed, importing, installed, load

from .record import Check, Command
from .usage import WrongUsage

if TYPE_CHECKING:
    import argparse
    from types import ModuleType

    from rosorin_compile.source.diagnostics import Diagnostic

    from .parser import Parser

# By what people want to do; the help lists the groups in this order, and those of plug-ins behind them.
GROUPS = ("describe and compile", "import and compare", "inspect", "build systems", "deploy and verify", "set up")

Kind = TypeVar("Kind", bound="Command | Check")


class Registered(Generic[Kind]):
    """A record, the folder of modules from which it names its functions, and the plug-in that it is of."""

    def __init__(self, record: Kind, home: str, plugin: Plugin | None = None) -> None:
        self.record = record
        self.home = home
        self.plugin = plugin

    @property
    def is_check(self) -> bool:
        """Whether it is a check, which ``check`` does, and no command."""
        return isinstance(self.record, Check)

    def function(self, name: str) -> Callable[..., Any]:
        """Return a function that the record names, imported at this moment."""
        return _function(name, self.home)

    def add_options(self, parser: Parser) -> None:
        """Add what it takes to a parser. Raises PluginFailed."""
        if self.plugin is None:
            self.function(self.record.options)(parser)
            return
        with self.guarded(SystemExit), importing(self.plugin):
            self.function(self.record.options)(parser)
            self.function(self.record.run)

    def run(self, options: argparse.Namespace) -> int:
        """Do it, and return the exit code. Raises WrongUsage, PluginFailed."""
        with self.guarded(SystemExit):
            code: int = self.function(self.record.run)(options)
        if self.plugin is not None and type(code) is not int:
            raise PluginFailed(broken(self.plugin, f"gives no exit code, but {str(code)[:60]!r}"))
        return code

    @contextmanager
    def guarded(self, *more: type[BaseException]) -> Iterator[None]:
        """Let whatever a plug-in raises in the block, that nobody expects, be a word about it. Raises PluginFailed."""
        try:
            yield
        except (WrongUsage, PluginFailed, BrokenPipeError):
            raise
        except BaseException as problem:
            if self.plugin is None or not isinstance(problem, (Exception, *more)):
                raise
            raise PluginFailed(failed(self.plugin, problem)) from None


def _function(name: str, home: str) -> Callable[..., Any]:
    module, _, function = name.partition(":")
    found: Callable[..., Any] = getattr(import_module(f".{module}", home) if home else import_module(module), function)
    return found


def _modules() -> Iterator[ModuleType]:
    return iter([import_module("rosorin_compile.cli.records")])


def _own(group: str) -> Iterator[tuple[Any, str]]:
    """Yield the records of our own packages, each with the folder of its module."""
    for module in _modules():
        yield from ((record, module.__package__ or "") for record in getattr(module, group, ()))


def _own_commands() -> Iterator[Registered[Command]]:
    return (Registered(record, home) for record, home in _own("COMMANDS"))


def own_checks() -> dict[str, Registered[Check]]:
    """Return the checks of our own packages by name."""
    return {record.name: Registered(record, home) for record, home in _own("CHECKS")}


def command(name: str) -> Registered[Command] | None:
    """Return the command of a name, or of one of its other names; ours before one of a plug-in."""
    found = next((one for one in _own_commands() if name in _names(one.record)), None)
    return _first(found, "commands", Command, name)


def check(name: str) -> Registered[Check] | None:
    """Return the check of a name; ours before one of a plug-in, which may also be called DISTRIBUTION:NAME."""
    distribution, _, inner = name.rpartition(":")
    if distribution and distribution == whose("checks", inner):
        return _first(None, "checks", Check, inner)
    return _first(own_checks().get(name), "checks", Check, name)


def whose(group: str, name: str) -> str:
    """Return the distribution that brings a plug-in of a name; empty if none does. Nothing is imported."""
    return next((one.distribution for one in installed() if (one.group, one.name) == (group, name)), "")


def _first(own: Registered[Kind] | None, group: str, kind: type[Kind], name: str) -> Registered[Kind] | None:
    """Return what is our own, or else of a plug-in, and say what is wrong with that or with others of the name."""
    if own is not None:
        warn_of_plugins(clash(one, name) for one in installed() if (one.group, one.name) == (group, name))
        return own
    found, wrong = _of_plugins(group, kind, (), name)
    if wrong and not found:
        raise PluginFailed(wrong[0])
    warn_of_plugins(wrong)
    return next(iter(found), None)


def _of_plugins(
    group: str, kind: type[Kind], taken: Iterable[str], called: str | None = None
) -> tuple[list[Registered[Kind]], list[Diagnostic]]:
    """Return the records of plug-ins, of one name or all, and what is wrong with others."""
    found, said = load(group, kind, _names, set(taken).__contains__, called)
    good, wrong = [], list(said)
    for plugin, record in found:
        if record.name != plugin.name:
            wrong.append(broken(plugin, f'is called "{record.name}", and its entry point "{plugin.name}"'))
            continue
        module = sys.modules[plugin.value.partition(":")[0].strip()]
        good.append(Registered(record, module.__package__ or "", plugin))
    return good, wrong


def _names(record: Command | Check) -> tuple[str, ...]:
    return (record.name, *getattr(record, "also", ()))


def warn_of_plugins(diagnostics: Iterable[Diagnostic]) -> None:
    """Say what is wrong with plug-ins that nothing depends on."""
    from rosorin_compile.source.console import Console
    from rosorin_compile.source.diagnostics import WARNING

    Console("text").show([replace(one, severity=WARNING) for one in diagnostics])


def commands(of_plugins: bool = True) -> dict[str, Command]:
    """Return all commands by name, as the help lists them: group by group, each in its order."""
    found = [one.record for one in _own_commands()]
    found += _more("commands", Command, found) if of_plugins else []
    groups = list(dict.fromkeys([*GROUPS, *(one.group for one in found)]))
    found.sort(key=lambda one: (groups.index(one.group), one.order))
    return {one.name: one for one in found}


def checks(of_plugins: bool = True) -> dict[str, Check]:
    """Return all checks by name, as the help of ``check`` lists them."""
    found = [one.record for one in own_checks().values()]
    found += _more("checks", Check, found) if of_plugins else []
    return {one.name: one for one in found}


def _more(group: str, kind: type[Kind], own: Iterable[Kind]) -> list[Kind]:
    """Return the records of plug-ins, and say what is wrong with others."""
    found, wrong = _of_plugins(group, kind, [name for record in own for name in _names(record)])
    warn_of_plugins(wrong)
    return [one.record for one in found]


def names(group: str) -> dict[str, str]:
    """Return the names of all "commands" or "checks" with their helps; of a plug-in, which is not imported, whose."""
    own = commands(of_plugins=False) if group == "commands" else checks(of_plugins=False)
    of_plugins = {one.name: f"of {one.distribution} {one.version}" for one in installed() if one.group == group}
    return {**of_plugins, **{name: record.help for name, record in own.items()}}


def service(name: str) -> Callable[..., Any]:
    """Return what a package of ours does for others, who ask by name and know no package. Raises LookupError."""
    for module in _modules():
        if name in getattr(module, "SERVICES", {}):
            return _function(module.SERVICES[name], "")
    raise LookupError(name)

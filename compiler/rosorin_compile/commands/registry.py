"""The commands that there are, found by their names: those of the program's own packages (``SHIPPED``)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, NamedTuple

from ..shipped import SHIPPED
from .record import Command

# By what people want to do; the help lists the groups in this order.
GROUPS = ("describe and compile", "bring in", "ask", "build with it", "run on the robot", "set up")

_TOP = __package__.rpartition(".")[0]


class Registered(NamedTuple):
    """A record, and the folder of modules from which it names its functions."""

    record: Command
    home: str

    def function(self, name: str) -> Callable[..., Any]:
        """Return a function that the record names, imported at this moment."""
        module, _, function = name.partition(":")
        found: Callable[..., Any] = getattr(import_module(f".{module}", self.home), function)
        return found


def _own() -> Iterator[Registered]:
    for name in SHIPPED:
        module = import_module(f"{_TOP}.{name}")
        yield from (Registered(record, module.__package__ or "") for record in module.COMMANDS)


def command(name: str) -> Registered | None:
    """Return the command of a name, or of one of its other names."""
    return next((one for one in _own() if name == one.record.name or name in one.record.also), None)


def commands() -> dict[str, Command]:
    """Return all commands by name, as the help lists them: group by group, each in its order."""
    found = [one.record for one in _own()]
    found.sort(key=lambda one: (GROUPS.index(one.group), one.order))
    return {one.name: one for one in found}

"""Load plug-ins: entry points that other Python distributions declare. They cannot replace built-in features."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable
from contextlib import redirect_stdout, suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO, TypeVar

from .diagnostics import ERROR, NOTE, WARNING, Diagnostic, DiagnosticError, Related, Span, error

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    T = TypeVar("T")


PREFIX = "rosorin_compile."


class Plugin(NamedTuple):
    """An entry point of a distribution; ``group`` is "rules" for the entry point group "rosorin_compile.rules"."""

    distribution: str
    version: str
    group: str
    name: str
    value: str

    def __str__(self) -> str:
        return f"the plug-in {self.distribution} {self.version} ({PREFIX}{self.group}: {self.name} = {self.value})"


class PluginFailed(DiagnosticError):
    """Raised if a plug-in raised an exception, and the command cannot continue without its result."""


def load(
    group: str,
    kind: type[T],
    names: Callable[[T], Iterable[str]],
    built_in: Callable[[str], bool],
    called: str | None = None,
) -> tuple[tuple[tuple[Plugin, T], ...], tuple[Diagnostic, ...]]:
    """Import the plug-ins of a group.

    Args:
        kind: The type of the object that each entry point must refer to.
        names: A function that returns the names that such an object defines.
        built_in: A function that returns True for a built-in name, which a plug-in may not define.
        called: Import only the entry points with this name. Default: all.

    Returns:
        The (plug-in, object) pairs, and an error for each plug-in that cannot be used.
    """
    loaded: list[tuple[Plugin, T]] = []
    diagnostics: list[Diagnostic] = []
    owners: dict[str, Plugin] = {}
    for plugin, entry_point in _entry_points():
        if plugin.group != group or called not in (None, plugin.name):
            continue
        try:
            with divert_stdout():
                made = entry_point.load()
            if not isinstance(made, kind):
                raise TypeError(f"it is of type {type(made).__name__}, not a {kind.__name__} of rosorin_compile")
            own = list(names(made))
        except (Exception, SystemExit) as problem:
            diagnostics.append(failed_plugin(plugin, problem, "cannot be loaded"))
            continue
        if (taken := next((name for name in own if name in owners or built_in(name)), None)) is not None:
            diagnostics.append(clash(plugin, taken, owners.get(taken)))
        else:
            owners.update(dict.fromkeys(own, plugin))
            loaded.append((plugin, made))
    return tuple(loaded), tuple(diagnostics)


def broken_plugin(plugin: Plugin, what: str, rule: str = "plugin-broken") -> Diagnostic:
    """Create an error about a plug-in; ``what`` continues the message after the name of the plug-in."""
    return error(rule, f"{plugin} {what}", None, f"upgrade it, or pip uninstall {plugin.distribution}")


def failed_plugin(plugin: Plugin, problem: BaseException, what: str = "fails") -> Diagnostic:
    """Create the error for a plug-in that raised ``problem``; ``what`` is the verb, such as "cannot be loaded"."""
    reason = type(problem).__name__
    with suppress(Exception):  # str() may run code of the plug-in, which may also fail
        reason = f"{reason}: {problem}".rstrip(": ")
    return broken_plugin(plugin, f"{what}: {reason}")


def clash(plugin: Plugin, name: str, other: Plugin | None = None) -> Diagnostic:
    """Create the error for a plug-in that defines a built-in name, or a name that the plug-in ``other`` defines."""
    whose = f"which {other} brings, too" if other else "which is built in"
    return broken_plugin(plugin, f'brings "{name}", {whose}', "plugin-clash")


def divert_stdout() -> redirect_stdout[TextIO]:
    """Return a context manager that redirects stdout, which is for artifacts, to stderr while a plug-in runs."""
    return redirect_stdout(sys.stderr)


def diagnostic_of(value: object) -> Diagnostic:
    """Validate an object that a plug-in yielded as a diagnostic. Raises TypeError, ValueError or AttributeError."""
    if not isinstance(value, Diagnostic):
        raise TypeError(f"a Diagnostic is expected, not {str(value)[:60]!r}")
    if value.severity not in (ERROR, WARNING, NOTE):
        raise ValueError(f"the severity of {value.rule} is error, warning or note, not {str(value.severity)[:60]!r}")
    texts, related = (value.rule, value.message, value.help), value.related
    if not (all(isinstance(text, str) for text in texts) and all(isinstance(one, Related) for one in related)):
        raise TypeError(f"rule, message and help of a Diagnostic are texts, and related are Related: {texts}"[:200])
    spans = filter(None, [value.span, *(one.span for one in related)])
    if not all(isinstance(span, Span) and span.line > 0 and span.column > 0 for span in spans):
        raise TypeError("the place of a Diagnostic is a Span, with a line and a column")
    return replace(value, numbers=tuple(dict(value.numbers).items()), of=tuple(map(str, value.of)))


def installed_plugins() -> tuple[Plugin, ...]:
    """Return all installed plug-ins, sorted by distribution, group and name, without importing them."""
    return tuple(plugin for plugin, _ in _entry_points())


def _entry_points() -> tuple[tuple[Plugin, EntryPoint], ...]:
    return () if os.environ.get("ROSORIN_COMPILE_PLUGINS") == "off" else _on_path(tuple(sys.path))


@lru_cache(maxsize=8)
def _on_path(path: tuple[str, ...]) -> tuple[tuple[Plugin, EntryPoint], ...]:
    found: dict[str, list[tuple[Plugin, EntryPoint]]] = {}
    for file in (file for entry in dict.fromkeys(path) for file in sorted(Path(entry).glob("*-info/entry_points.txt"))):
        with suppress(Exception):  # skip distributions with broken metadata
            if f"[{PREFIX}".encode() not in file.read_bytes():
                continue
            from importlib.metadata import Distribution  # slow: import only if there is a plug-in

            distribution = Distribution.at(file.parent)
            name, _, version = file.parent.stem.partition("-")
            with suppress(Exception):
                name, version = distribution.metadata["Name"] or name, distribution.metadata["Version"] or version
            points = [point for point in distribution.entry_points if point.group.startswith(PREFIX)]
            plugins = [(Plugin(name, version, p.group[len(PREFIX) :], p.name, p.value), p) for p in points]
            found.setdefault(name.lower().replace("_", "-").replace(".", "-"), plugins)
    return tuple(sorted((pair for pairs in found.values() for pair in pairs), key=lambda pair: pair[0]))

"""Load plug-ins: entry points of other distributions. An unusable plug-in is an error; none replaces a built-in."""

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
    """One entry point of a distribution, such as ``wheels = toy.rules:wheels`` in the group "rules"."""

    distribution: str
    version: str
    group: str
    name: str
    value: str

    def __str__(self) -> str:
        return f"the plug-in {self.distribution} {self.version} ({PREFIX}{self.group}: {self.name} = {self.value})"


class PluginFailed(DiagnosticError):
    """A plug-in raised an exception, and the run cannot continue without the result of the plug-in."""


def load(
    group: str,
    kind: type[T],
    names: Callable[[T], Iterable[str]],
    built_in: Callable[[str], bool],
    called: str | None = None,
) -> tuple[tuple[tuple[Plugin, T], ...], tuple[Diagnostic, ...]]:
    """Load the plug-ins of a group; return the objects of type ``kind``, and an error for each unusable plug-in.

    ``names`` returns the names that an object defines; ``built_in`` returns True for a name that is taken. With
    ``called``, only the entry points of that name are imported.
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
    """Return the error for a plug-in that does not work as it should."""
    return error(rule, f"{plugin} {what}", None, f"upgrade it, or pip uninstall {plugin.distribution}")


def failed_plugin(plugin: Plugin, problem: BaseException, what: str = "fails") -> Diagnostic:
    """Return the error for a plug-in that raised an exception."""
    reason = type(problem).__name__
    with suppress(Exception):  # str() of the exception runs code of the plug-in, which may also fail
        reason = f"{reason}: {problem}".rstrip(": ")
    return broken_plugin(plugin, f"{what}: {reason}")


def clash(plugin: Plugin, name: str, other: Plugin | None = None) -> Diagnostic:
    """Return the error for a plug-in with a name that is built in, or that another plug-in uses."""
    whose = f"which {other} brings, too" if other else "which is built in"
    return broken_plugin(plugin, f'brings "{name}", {whose}', "plugin-clash")


def divert_stdout() -> redirect_stdout[TextIO]:
    """Redirect what a plug-in prints to standard error: standard output is for artifacts."""
    return redirect_stdout(sys.stderr)


def diagnostic_of(value: object) -> Diagnostic:
    """Validate and return a diagnostic of a plug-in. Raises TypeError, ValueError or AttributeError if invalid."""
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
    """Return all installed plug-ins, loaded or not, sorted by distribution, group and name."""
    return tuple(plugin for plugin, _ in _entry_points())


def _entry_points() -> tuple[tuple[Plugin, EntryPoint], ...]:
    return () if os.environ.get("ROSORIN_COMPILE_PLUGINS") == "off" else _on_path(tuple(sys.path))


@lru_cache(maxsize=8)
def _on_path(path: tuple[str, ...]) -> tuple[tuple[Plugin, EntryPoint], ...]:
    """Return the entry points of all distributions on a path; if one is installed twice, of its first copy."""
    found: dict[str, list[tuple[Plugin, EntryPoint]]] = {}
    for file in (file for entry in dict.fromkeys(path) for file in sorted(Path(entry).glob("*-info/entry_points.txt"))):
        with suppress(Exception):  # skip distributions with broken metadata
            if f"[{PREFIX}".encode() not in file.read_bytes():
                continue
            from importlib.metadata import Distribution  # slow: import only if there is a plug-in

            distribution = Distribution.at(file.parent)
            name, _, version = file.parent.stem.partition("-")
            with suppress(Exception):  # METADATA is missing or damaged
                name, version = distribution.metadata["Name"] or name, distribution.metadata["Version"] or version
            points = [point for point in distribution.entry_points if point.group.startswith(PREFIX)]
            plugins = [(Plugin(name, version, p.group[len(PREFIX) :], p.name, p.value), p) for p in points]
            found.setdefault(name.lower().replace("_", "-").replace(".", "-"), plugins)
    return tuple(sorted((pair for pairs in found.values() for pair in pairs), key=lambda pair: pair[0]))

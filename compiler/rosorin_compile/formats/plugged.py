"""Formats of other packages: entry points of ``rosorin_compile.formats``, held so that none of them stops the tool."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from ..plugins import Plugin, PluginFailed, failed, load
from .format import Format
from .templating import TemplateProblem

if TYPE_CHECKING:
    from ..diagnostics import Diagnostic

# What else of a record is called; what goes wrong there stops the command that asks, with a word on whose fault it is.
_CALLED = ("recognises", "frames", "solids", "cannot_say", "names", "leaves_out", "adds", "beside", "robot_of", "asked")


class Plugged(NamedTuple):
    """The formats that plug-ins add, by name, and what is wrong with plug-ins of this kind."""

    formats: dict[str, Format]
    diagnostics: tuple[Diagnostic, ...]


@cache
def plugged(built_in: Collection[str]) -> Plugged:
    """Return the formats of plug-ins; ``built_in`` are the names that they may not have."""
    loaded, diagnostics = load("formats", Format, _names, built_in.__contains__)
    return Plugged({format.name: _guarded(plugin, format) for plugin, format in loaded}, diagnostics)


def _names(format: Format) -> list[str]:
    """Return the name of a plug-in's format. Raises ValueError if no output can have it."""
    if not (format.name.isidentifier() and format.name == format.name.lower()):
        raise ValueError(f'"{format.name}" cannot be the name of a format: small letters, digits and _')
    if format.write is None and format.read is None:
        raise ValueError(f"{format.name} is neither written nor read")
    return [format.name]


def _guarded(plugin: Plugin, format: Format) -> Format:
    """Return a format whose functions raise nothing that their callers do not expect."""
    whole: dict[str, Any] = {name: _stopping(plugin, getattr(format, name)) for name in _CALLED}
    whole |= {name: _to_value_error(plugin, getattr(format, name)) for name in ("facts", "syntax")}
    whole |= {name: _yielding(plugin, getattr(format, name)) for name in ("check", "disagreements")}
    return replace(format, write=_written(plugin, format.write), read=_read(plugin, format.read), **whole)


def _written(plugin: Plugin, write: Callable[..., Any] | None) -> Callable[..., Any] | None:
    def guarded(*given: Any) -> tuple[str, list[Diagnostic]]:
        try:
            text, diagnostics = write(*given)  # type: ignore[misc]
            return str(text), list(diagnostics)
        except TemplateProblem:
            raise
        except (Exception, SystemExit) as problem:
            return "", [failed(plugin, problem)]

    return write and guarded


def _read(plugin: Plugin, read: Callable[..., Any] | None) -> Callable[..., Any] | None:
    def guarded(opened: Any) -> Any:
        from .imported import Imported

        try:
            return read(opened)  # type: ignore[misc]
        except (Exception, SystemExit) as problem:
            return Imported(None, [failed(plugin, problem)], files=(opened.path,))

    return read and guarded


def _stopping(plugin: Plugin, function: Callable[..., Any] | None) -> Callable[..., Any] | None:
    def guarded(*given: Any) -> Any:
        try:
            return function(*given)  # type: ignore[misc]
        except (Exception, SystemExit) as problem:
            raise PluginFailed(failed(plugin, problem)) from None

    return function and guarded


def _to_value_error(plugin: Plugin, function: Callable[..., Any] | None) -> Callable[..., Any] | None:
    def guarded(text: str) -> Any:
        try:
            return function(text)  # type: ignore[misc]
        except ValueError:
            raise
        except (Exception, SystemExit) as problem:
            raise ValueError(failed(plugin, problem).message) from None

    return function and guarded


def _yielding(plugin: Plugin, function: Callable[..., Any] | None) -> Callable[..., Any] | None:
    def guarded(*given: Any) -> Iterator[Any]:
        try:
            yield from function(*given)  # type: ignore[misc]
        except (Exception, SystemExit) as problem:
            raise PluginFailed(failed(plugin, problem)) from None

    return function and guarded

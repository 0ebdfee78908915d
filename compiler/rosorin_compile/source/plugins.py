"""Plug-ins: what other installed packages add to the tool, by the entry points of their distributions.

Each kind of thing has a group: ``rosorin_compile.formats``, ``.rules``, ``.functions``, ``.commands``, ``.checks``.
What a distribution offers stands in a small file beside its metadata. Most machines have no plug-in, so those files are
looked through before ``importlib.metadata`` is imported.

A plug-in that cannot be used is a diagnostic that names its distribution; it never stops the tool otherwise, and never
takes the place of what is built in. What it prints goes to standard error, under its name: standard output is for
artifacts. ``ROSORIN_COMPILE_PLUGINS=off`` leaves all of them out.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TextIO, TypeVar, cast

from .diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Span, error
from .rule_registry import PLUGINS, Rule

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    T = TypeVar("T")

RULES = (
    Rule(
        "plugin-broken",
        "An installed plug-in cannot be used: it cannot be imported, is not what its entry point says, or fails.",
        "Upgrade the package that the message names, or uninstall it.",
        PLUGINS,
    ),
    Rule(
        "plugin-clash",
        "An installed plug-in has the name of something that is built in, or that another plug-in has.",
        "Uninstall the package that the message names; its author has to choose another name.",
        PLUGINS,
    ),
    Rule(
        "plugin-slow",
        "A note: the import of an installed plug-in takes longer than 2 s, which each run that needs it waits for.",
        "Its author can import what takes long where it is used. `ROSORIN_COMPILE_PLUGINS=off` leaves out all of them.",
        PLUGINS,
    ),
)

PREFIX = "rosorin_compile."
SWITCH = "ROSORIN_COMPILE_PLUGINS"  # off: there are none
SLOW = 2.0  # seconds that the import of a plug-in may take without a word
_METADATA = (".dist-info", ".egg-info")


class Plugin(NamedTuple):
    """One entry point of an installed distribution, such as ``wheels = toy.rules:wheels`` in the group "rules"."""

    distribution: str
    version: str
    group: str
    name: str
    value: str

    def __str__(self) -> str:
        """Return who it is, in words for messages."""
        return f"the plug-in {self.distribution} {self.version} ({PREFIX}{self.group}: {self.name} = {self.value})"


def load(
    group: str,
    kind: type[T],
    names: Callable[[T], Iterable[str]],
    built_in: Callable[[str], bool],
    called: str | None = None,
) -> tuple[tuple[tuple[Plugin, T], ...], tuple[Diagnostic, ...]]:
    """Return what plug-ins add to a group ("rules"), each with who it is from, and what is wrong with the others.

    ``kind`` is what an entry point has to lead to, ``names`` are those under which one is known, and ``built_in`` says
    whether a name is taken; of entry points that are ``called`` otherwise none is imported. Never raises for what a
    plug-in does. Without plug-ins it imports nothing.
    """
    loaded: list[tuple[Plugin, T]] = []
    diagnostics: list[Diagnostic] = []
    owners: dict[str, Plugin] = {}
    for plugin, entry_point in _entry_points():
        if plugin.group != group or called not in (None, plugin.name):
            continue
        try:
            with importing(plugin):
                made = entry_point.load()
            if not isinstance(made, kind):
                raise TypeError(f"it is of type {type(made).__name__}, not a {kind.__name__} of rosorin_compile")
            own = list(names(made))
        except (Exception, SystemExit) as problem:
            diagnostics.append(broken(plugin, f"cannot be loaded: {_reason(problem)}"))
            continue
        taken = next((name for name in own if name in owners or built_in(name)), None)
        if taken is not None:
            diagnostics.append(clash(plugin, taken, owners.get(taken)))
            continue
        owners.update(dict.fromkeys(own, plugin))
        loaded.append((plugin, made))
    return tuple(loaded), tuple(diagnostics)


class PluginFailed(Exception):
    """A plug-in raised something where nobody can go on without it; carries the diagnostic."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


def broken(plugin: Plugin, what: str) -> Diagnostic:
    """Return an error: a plug-in does not do what it is for."""
    return error("plugin-broken", f"{plugin} {what}", None, _way_out(plugin))


def failed(plugin: Plugin, problem: BaseException) -> Diagnostic:
    """Return an error: a plug-in raised something while it was at work."""
    return broken(plugin, f"fails: {_reason(problem)}")


def _reason(problem: BaseException) -> str:
    try:
        return f"{type(problem).__name__}: {problem}".rstrip(": ")
    except Exception:  # its text is made by the plug-in, too
        return type(problem).__name__


def aside(plugin: Plugin) -> redirect_stdout[TextIO]:
    """Let what a plug-in prints go to standard error, under its name, while it is at work: it may forget a print()."""
    return redirect_stdout(cast("TextIO", _Named(plugin)))


_named: set[Plugin] = set()  # those that were said to print


class _Named:
    """Standard error, which says first, and once, whose words follow."""

    def __init__(self, plugin: Plugin) -> None:
        self.plugin = plugin

    def __getattr__(self, name: str) -> Any:
        return getattr(sys.stderr, name)

    def write(self, text: str) -> int:
        """Write a text."""
        if self.plugin not in _named:
            _named.add(self.plugin)
            sys.stderr.write(f"{self.plugin} prints what follows; standard output is for artifacts\n")
        return sys.stderr.write(text)


@contextmanager
def importing(plugin: Plugin) -> Iterator[None]:
    """Import a plug-in in the block: what it prints goes to standard error, and it is said if it takes long."""
    began = time.monotonic()
    with aside(plugin):
        yield
    took = time.monotonic() - began
    if took > SLOW:
        note = Diagnostic("plugin-slow", NOTE, f"{plugin} takes {took:.1f} s to be imported")
        sys.stderr.write(note.as_text())


def diagnostic_of(value: object) -> Diagnostic:
    """Return what a plug-in has to say. Raises TypeError if it is no Diagnostic, or says something else in a field."""
    if not isinstance(value, Diagnostic):
        raise TypeError(f"what there is to say is a Diagnostic, not {str(value)[:60]!r}")
    if value.severity not in (ERROR, WARNING, NOTE):
        raise ValueError(f"the severity of {value.rule} is error, warning or note, not {str(value.severity)[:60]!r}")
    for field in ("rule", "message", "help"):
        if not isinstance(getattr(value, field), str):
            raise TypeError(f"{field} of a Diagnostic is a text, not {str(getattr(value, field))[:60]!r}")
    places = [value.span, *(one.span for one in _all_of(value, "related", Related))]
    _all_of(value, "of", str)
    if not all(place is None or _is_place(place) for place in places):
        raise TypeError("the place of a Diagnostic is a Span, with a line and a column")
    if not all(isinstance(one, tuple) and len(one) == 2 for one in _all_of(value, "numbers", tuple)):
        raise TypeError("numbers of a Diagnostic are pairs of a name and a value")
    return value


def _all_of(value: Diagnostic, field: str, kind: type[T]) -> tuple[T, ...]:
    many = getattr(value, field)
    if not isinstance(many, tuple) or not all(isinstance(one, kind) for one in many):
        raise TypeError(f"{field} of a Diagnostic is a tuple of {kind.__name__}, not {str(many)[:60]!r}")
    return many


def _is_place(span: object) -> bool:
    return isinstance(span, Span) and all(type(number) is int and number > 0 for number in span[1:4])


def clash(plugin: Plugin, name: str, other: Plugin | None = None) -> Diagnostic:
    """Return an error: a plug-in has the name of what is built in, or of what an other one brings."""
    whose = f"which {other} brings, too" if other else "which is built in"
    return error("plugin-clash", f'{plugin} brings "{name}", {whose}', None, _way_out(plugin))


def _way_out(plugin: Plugin) -> str:
    return f"upgrade it, or pip uninstall {plugin.distribution}"


def installed() -> tuple[Plugin, ...]:
    """Return the plug-ins that are installed, loaded or not, by distribution, group and name."""
    return tuple(plugin for plugin, _ in _entry_points())


def are_installed(group: str) -> bool:
    """Say whether a distribution has an entry point of a group ("formats")."""
    return any(plugin.group == group for plugin in installed())


def _entry_points() -> tuple[tuple[Plugin, EntryPoint], ...]:
    if os.environ.get(SWITCH, "") == "off":
        return ()
    folders = _metadata_folders(tuple(sys.path))
    return _read(folders) if folders else ()


@lru_cache(maxsize=8)
def _read(folders: tuple[str, ...]) -> tuple[tuple[Plugin, EntryPoint], ...]:
    """Return the entry points that the metadata in these folders have for the tool; of a distribution the first."""
    from importlib.metadata import Distribution

    seen: set[str] = set()
    found: list[tuple[Plugin, EntryPoint]] = []
    for folder in folders:
        name, version, points = _distribution(folder, Distribution.at(Path(folder)))
        key = name.lower().replace("_", "-").replace(".", "-")
        if key not in seen:
            seen.add(key)
            ours = [point for point in points if point.group.startswith(PREFIX)]
            found += [(Plugin(name, version, p.group.removeprefix(PREFIX), p.name, p.value), p) for p in ours]
    return tuple(sorted(found, key=lambda pair: pair[0]))


def _distribution(folder: str, distribution: Any) -> tuple[str, str, list[EntryPoint]]:
    """Return the name, the version and the entry points of a distribution, whatever its metadata are like."""
    name, _, version = Path(folder).stem.partition("-")
    with suppress(Exception):
        name, version = distribution.metadata["Name"] or name, distribution.metadata["Version"] or version
    with suppress(Exception):
        return name, version or "?", list(distribution.entry_points)
    return name, version or "?", []


def _metadata_folders(path: tuple[str, ...]) -> tuple[str, ...]:
    """Return the folders of metadata, along a module search path, that name an entry point of the tool."""
    found: list[str] = []
    for entry in dict.fromkeys(path):
        with suppress(OSError):
            found += _metadata_in(entry, Path(entry).stat().st_ctime_ns)
    return tuple(found)


@lru_cache(maxsize=256)
def _metadata_in(entry: str, _changed: int) -> tuple[str, ...]:
    """Return the same for one folder, as long as nothing comes into it or goes. Raises OSError."""
    inside = sorted(path for path in Path(entry).iterdir() if path.suffix in _METADATA)
    return tuple(str(path) for path in inside if _names_us(path))


def _names_us(metadata: Path) -> bool:
    """Say whether what stands in a folder of packages are metadata with an entry point of the tool."""
    try:
        return b"[" + PREFIX.encode() in (metadata / "entry_points.txt").read_bytes()
    except OSError:
        return False

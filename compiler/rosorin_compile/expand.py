"""Expand: includes, arguments, named values and expressions resolved; the result is one plain tree.

All files of a description share one namespace of named values. Sections of the same name are joined: the entries of the
included files come first, in the order of the includes, then those of the including file.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from .diagnostic import Diagnostic, Related, Span, did_you_mean, error
from .load import LoadError, load_mapping, plain_scalar
from .scope import Failed, Scope
from .tree import Instance, Map, Place, Seq, locate

MAX_FILES = 500

_JOINED = ("links", "joints", "sensors", "publishers", "servos", "poses", "modes", "outputs", "args")
_LISTED = ("edges", "disabled_contacts")
_SOURCED = ("links", "joints", "sensors", "servos", "poses")
_PRIVATE = ("include", "let", "source", "rosorin_compile")


class Expanded(NamedTuple):
    """The plain tree (None if it could not be made), what is wrong, and the files that were read."""

    tree: Map | None
    diagnostics: list[Diagnostic]
    files: tuple[Path, ...]


def expand(path: Path, arguments: Mapping[str, str]) -> Expanded:
    """Return the tree of the description whose first file is ``path``.

    ``arguments`` are texts by name, as given on the command line.
    """
    reader = _Reader(path)
    root = reader.read(path, _shown(path), None, None, ())
    if root is None:
        return Expanded(None, reader.diagnostics, tuple(reader.files))
    scope = Scope({})
    scope.values = _arguments(root, arguments, scope)
    for name, value, place in reader.lets:
        scope.define(name, value, place)
    tree: Map | None
    try:
        tree = scope.resolve(root, Place(root.span, None))
    except Failed:
        tree = None
    for name in list(scope.pending):
        _try(scope, name)
    return Expanded(tree, reader.diagnostics + scope.diagnostics, tuple(reader.files))


def _try(scope: Scope, name: str) -> None:
    """Evaluate a named value that nothing uses, so that a mistake in it is found all the same."""
    with suppress(Failed, KeyError):
        scope.lookup(name)


class _Reader:
    """Reads a file and what it includes into one tree."""

    def __init__(self, root: Path) -> None:
        self.folder = root.parent.resolve()
        self.files: list[Path] = []
        self.lets: list[tuple[str, Any, Place]] = []
        self.diagnostics: list[Diagnostic] = []

    def read(
        self, path: Path, shown: str, asked: Span | None, via: Instance | None, within: tuple[Path, ...]
    ) -> Map | None:
        """Return the file joined with its includes; None if it cannot be read."""
        self.files.append(path)
        try:
            file = load_mapping(path, shown, asked, via)
        except LoadError as problem:
            found = problem.diagnostic
            stack = tuple(via.stack()) if via else ()
            # Where the file cannot be read, the diagnostic points at the include itself: that needs no note.
            led_here = stack[1:] if found.span == asked else stack
            self.diagnostics.append(found._replace(related=found.related + led_here))
            return None
        made = Map(file.span, via)
        for item, span in self._includes(file):
            included = self._include(item, path, Place(span, via), (*within, path.resolve()))
            if included is not None:
                self._join(made, included)
        self._collect_lets(file)
        self._join(made, self._own(file, root=via is None))
        return made

    def _includes(self, file: Map) -> list[tuple[Any, Span]]:
        names = file.get("include")
        if names is None:
            return []
        if not isinstance(names, Seq):
            self._error("wrong-type", "include is a list of file names", locate(file, ("include",)), "write [arm.yaml]")
            return []
        return list(zip(names, names.value_spans, strict=True))

    def _include(self, name: Any, path: Path, place: Place, stack: tuple[Path, ...]) -> Map | None:
        """Return an included file; it must stand inside the description's folder and not include itself."""
        if not isinstance(name, str) or not name:
            self._error("wrong-type", "include names files: text", place, "write the name of a YAML file")
            return None
        target = Path(os.path.join(path.parent, name))
        real = target.resolve()
        if not real.is_relative_to(self.folder):
            self._error("include-outside", f"{name} is outside the folder of the description", place, "move it inside")
            return None
        if real in stack:
            self._error("include-cycle", f"{name} includes itself, directly or through others", place, "remove one")
            return None
        if len(self.files) >= MAX_FILES:
            self._error("include-too-many", f"more than {MAX_FILES} files are included", place, "")
            return None
        return self.read(target, _shown(target), place.span, Instance("included here", place.span, place.via), stack)

    def _collect_lets(self, file: Map) -> None:
        lets = file.get("let")
        if isinstance(lets, Map):
            for name, value in lets.items():
                self.lets.append((name, value, locate(file, ("let", name), key=True)))
        elif lets is not None:
            self._error("wrong-type", "let maps names to values", locate(file, ("let",)), "write name: value")

    def _own(self, file: Map, root: bool) -> Map:
        """Return the file without what was dealt with already, its source given to each entry that has none."""
        made = Map(file.span, file.via)
        for key, value in file.items():
            if key in _PRIVATE and not (root and key in ("source", "rosorin_compile")):
                continue
            if key == "robot" and not root:
                place = locate(file, (key,), key=True)
                self._error("included-robot", "an included file does not name the robot", place, "remove it")
                continue
            if key in _SOURCED and isinstance(value, Map) and "source" in file:
                value = _with_source(value, file)
            made.put(key, value, file.key_spans[key], file.value_spans[key])
        return made

    def _join(self, made: Map, more: Map) -> None:
        """Add the sections of one file to those of the others."""
        for key, value in more.items():
            if key not in made or made[key] is None:
                copy = _copy(value) if key in _JOINED or key in _LISTED else value
                made.put(key, copy, more.key_spans[key], more.value_spans[key])
            elif key in _JOINED and isinstance(value, Map) and isinstance(made[key], Map):
                self._join_section(key, made[key], value)
            elif key in _LISTED and isinstance(value, Seq) and isinstance(made[key], Seq):
                for item, span in zip(value, value.value_spans, strict=True):
                    made[key].put(item, span)
            elif value is not None:
                related = [Related("first defined here", made.key_spans[key])]
                place = locate(more, (key,), key=True)
                if key in _JOINED or key in _LISTED:
                    wanted = "a mapping" if key in _JOINED else "a list"
                    self._error("wrong-type", f"{key} is {wanted} in every file", place, "write it so in both", related)
                else:
                    self._error("duplicate-key", f'"{key}" is said twice', place, "remove one", related)

    def _join_section(self, section: str, made: Map, more: Map) -> None:
        for name, entry in more.items():
            if name in made:
                related = [Related("first defined here", made.key_spans[name])]
                message = f'{section.rstrip("s")} "{name}" is defined twice'
                self._error("duplicate-name", message, locate(more, (name,), key=True), "rename or remove one", related)
                continue
            made.put(name, entry, more.key_spans[name], more.value_spans[name])

    def _error(self, rule: str, message: str, place: Place, help: str, related: list[Related] | None = None) -> None:
        self.diagnostics.append(error(rule, message, place.span, help, [*(related or []), *place.stack()]))


def _copy(value: Any) -> Any:
    """Return a section of a file that more may be joined to; the file's own tree stays as it is."""
    if isinstance(value, Map):
        made = Map(value.span, value.via)
        for key, item in value.items():
            made.put(key, item, value.key_spans[key], value.value_spans[key])
        return made
    if isinstance(value, Seq):
        listed = Seq(value.span, value.via)
        for item, span in zip(value, value.value_spans, strict=True):
            listed.put(item, span)
        return listed
    return value


def _with_source(section: Map, file: Map) -> Map:
    """Return a section in which every entry has a source: its own, or that of its file."""
    made = Map(section.span, section.via)
    for name, entry in section.items():
        if isinstance(entry, Map) and "source" not in entry:
            entry = _copy(entry)
            entry.put("source", file["source"], file.key_spans["source"], file.value_spans["source"])
        made.put(name, entry, section.key_spans[name], section.value_spans[name])
    return made


def _arguments(root: Map, given: Mapping[str, str], scope: Scope) -> dict[str, Any]:
    """Return the values of the arguments: those given, else their defaults. What is wrong is reported to the scope."""
    declared = root.get("args")
    declared = declared if isinstance(declared, Map) else Map(root.span)
    values: dict[str, Any] = {}
    for name in given:
        if name not in declared:
            message = f'the description has no argument "{name}"'
            scope.diagnostics.append(error("unknown-argument", message, None, did_you_mean(name, declared)))
    for name, spec in declared.items():
        spec = spec if isinstance(spec, Map) else {}
        place = locate(declared, (name,), key=True)
        if name not in given and "default" not in spec:
            message = f'the argument "{name}" has no default'
            scope.report("missing-argument", message, place, f"give it: -a {name}=VALUE")
            scope.broken.add(name)
            continue
        value = plain_scalar(given[name]) if name in given else spec["default"]
        allowed = spec.get("one_of")
        if isinstance(allowed, Seq) and value not in allowed:
            help = f"allowed: {', '.join(map(str, allowed))}"
            scope.report("bad-argument", f'"{value}" is not a value of the argument "{name}"', place, help)
        values[name] = value
    return values


def _shown(path: Path) -> str:
    """Return a path as a person would name it: relative to here if it is below."""
    here = os.path.relpath(path)
    return str(path) if here.startswith("..") else here

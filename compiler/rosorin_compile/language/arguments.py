"""Arguments: what a description declares under ``args``, and the values that files of arguments set."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic, Span, error, has_errors
from rosorin_compile.source.files import shown
from rosorin_compile.source.load import LoadError, load_mapping
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map, Seq

from .expand.description import expand
from .expand.files import Reader
from .written import Written

Choice = tuple[str, tuple[str, ...]]  # an argument and its values, that of the default first
Combination = tuple[str, ...]  # one value for each argument

# Rules for the values of arguments, as opposed to the rest of the description.
_OF_ARGUMENTS = ("unknown-argument", "bad-argument")


class Argument(NamedTuple):
    """A declared argument; texts are as written, "" if they are not.

    ``value`` is what it is set to, "" for its default; ``set_at`` is the place of that, None for the command line.
    """

    name: str
    type: str
    allowed: tuple[str, ...]
    required: bool
    default: str
    help: str
    span: Span
    value: str = ""
    set_at: Span | None = None


def declared(
    path: Path, arguments: Mapping[str, Any], packages: Mapping[str, Path] | None = None
) -> tuple[list[Argument], list[Diagnostic]]:
    """Return the arguments of the description whose first file is ``path``, and problems with their values.

    They are also listed for a description with other mistakes, as long as its files can be read.
    """
    reader = Reader(path, None, packages)
    root = reader.whole()
    if root is None or has_errors(reader.diagnostics):
        return [], reader.diagnostics
    entries = root["args"] if isinstance(root.get("args"), Map) else Map(root.span)
    expanded = expand(path, arguments, None, packages=packages)
    written = Written()
    found = []
    for name in entries:
        argument = _argument(name, entries, written)
        if name in arguments:
            place = arguments.value_spans.get(name) if isinstance(arguments, Map) else None
            text = str(arguments[name]) if place is None else written.text(place)
            argument = argument._replace(value=text, set_at=place)
        elif name in reader.given:
            place = reader.given[name][1].span
            argument = argument._replace(value=written.text(place), set_at=place)
        found.append(argument)
    return found, arrange(d for d in expanded.diagnostics if d.rule in _OF_ARGUMENTS)


def _argument(name: str, entries: Map, written: Written) -> Argument:
    entry, span = entries[name], entries.key_spans[name]
    if not isinstance(entry, Map):  # NAME: DEFAULT
        default = "" if entry is None else written.text(entries.value_spans[name])
        return Argument(name, "any", (), entry is None, default, "", span)
    default = written.text(entry.value_spans["default"]) if "default" in entry else ""
    choice = entry.get("one_of")
    spans = choice.value_spans if isinstance(choice, Seq) else [entry.value_spans["one_of"]] if choice else []
    help = " ".join(str(entry.get("help") or "").split())
    kind, allowed = str(entry.get("type") or "any"), tuple(map(written.text, spans))
    return Argument(name, kind, allowed, "default" not in entry, default, help, span)


def choices(arguments: Sequence[Argument], values: Mapping[str, Any]) -> list[Choice]:
    """Return the arguments with a list of values, those of one_of or true and false, that ``values`` does not set."""
    found = []
    for argument in arguments:
        allowed = argument.allowed or (("true", "false") if argument.type == "boolean" else ())
        if allowed and argument.name not in values and argument.set_at is None:
            first = [value for value in allowed if value == argument.default]
            found.append((argument.name, tuple(dict.fromkeys([*first, *allowed]))))
    return found


def combinations(varied: Sequence[Choice]) -> Iterator[Combination]:
    """Yield all combinations: the defaults, those in which one argument differs from them, then all others."""
    defaults = tuple(values[0] for _, values in varied)
    near = [defaults]
    for index, (_, values) in enumerate(varied):
        near += [(*defaults[:index], value, *defaults[index + 1 :]) for value in values[1:]]
    yield from near
    known = set(near)
    yield from (row for row in product(*(values for _, values in varied)) if row not in known)


def read(paths: Iterable[Path], texts: Mapping[str, str]) -> Map:
    """Return the arguments of at least one YAML file; later files override earlier ones, ``texts`` override files.

    Only those of the files have a place. Raises LoadError.
    """
    first, *others = (load_mapping(path, shown(path)) for path in paths)
    merged = Map(first.span)
    for values in (first, *others):
        for name in values.calculated():
            message = f'the argument "{name}" is an expression; a file of arguments holds values'
            raise LoadError(error("bad-argument", message, values.value_spans[name], "write its result"))
        for name, value in values.items():
            merged.put(name, value, values.key_spans[name], values.value_spans[name])
    for name, text in texts.items():
        merged[name] = text
        merged.key_spans.pop(name, None)
        merged.value_spans.pop(name, None)
    return merged

"""Arguments: what a description declares under ``args``, and what files of arguments set."""

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

from .expand import expand
from .expand.files import Reader
from .written import Written

Choice = tuple[str, tuple[str, ...]]  # an argument and its values, that of the default first
Combination = tuple[str, ...]  # one value for each argument

# What is wrong with the values that are given, as opposed to the rest of the description.
_OF_ARGUMENTS = ("unknown-argument", "bad-argument")


class Argument(NamedTuple):
    """A declared argument: texts as they are written, empty where nothing is.

    ``value`` is what it is set to, "" if to nothing but its default; ``set_at`` where, None for the command line.
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

    @staticmethod
    def declared(
        path: Path, arguments: Mapping[str, Any], packages: Mapping[str, Path] | None = None
    ) -> tuple[list[Argument], list[Diagnostic]]:
        """Return the arguments of the description whose first file is ``path``, and what is wrong.

        Of a description that has other faults they are listed all the same, as long as its files can be read.
        """
        return declared(path, arguments, packages)

    @classmethod
    def choices(cls, arguments: Sequence[Argument], given: Mapping[str, Any]) -> list[Choice]:
        """Return the arguments with a list of values, those of one_of or true and false, that a run leaves open."""
        found = []
        for argument in arguments:
            values = argument.allowed or (("true", "false") if argument.type == "boolean" else ())
            if values and argument.name not in given and argument.set_at is None:
                first = [value for value in values if value == argument.default]
                found.append((argument.name, tuple(dict.fromkeys([*first, *values]))))
        return found

    @classmethod
    def combinations(cls, arguments: Sequence[Argument]) -> Iterator[dict[str, str]]:
        """Yield all combinations of the choices, values by name: see ``combinations``."""
        varied = cls.choices(arguments, {})
        for row in combinations(varied):
            yield dict(zip((name for name, _ in varied), row, strict=True))


def combinations(varied: Sequence[Choice]) -> Iterator[Combination]:
    """Yield all combinations: the defaults, those in which one argument differs from them, then all others."""
    defaults = tuple(values[0] for _, values in varied)
    near = [defaults]
    for index, (_, values) in enumerate(varied):
        near += [(*defaults[:index], value, *defaults[index + 1 :]) for value in values[1:]]
    yield from near
    seen = set(near)
    yield from (one for one in product(*(values for _, values in varied)) if one not in seen)


def read(files: Iterable[Path], texts: Mapping[str, str]) -> Map:
    """Return the arguments that YAML files map to values, the later file before the earlier, ``texts`` before both.

    Only those of the files have a place. Raises LoadError.
    """
    made: Map | None = None
    for path in files:
        given = load_mapping(path, shown(path))
        for name in given.calculated():
            message = f'the argument "{name}" is an expression; a file of arguments holds values'
            raise LoadError(error("bad-argument", message, given.value_spans[name], "write its result"))
        if made is None:
            made = Map(given.span)
        for name, value in given.items():
            made.put(name, value, given.key_spans[name], given.value_spans[name])
    if made is None:
        raise ValueError("there is no file to read")
    for name, text in texts.items():
        made[name] = text
        made.key_spans.pop(name, None)
        made.value_spans.pop(name, None)
    return made


def declared(
    path: Path, arguments: Mapping[str, Any], packages: Mapping[str, Path] | None = None
) -> tuple[list[Argument], list[Diagnostic]]:
    """Return the arguments of the description whose first file is ``path``, and what is wrong.

    Of a description that has other faults the arguments are listed all the same, as long as its files can be read.
    """
    reader = Reader(path, None, packages)
    root = reader.whole()
    if root is None or has_errors(reader.diagnostics):
        return [], reader.diagnostics
    entries = root.get("args")
    if not isinstance(entries, Map):
        entries = Map(root.span)
    expanded = expand(path, arguments, None, packages=packages)
    written = Written()
    made = [_with_value(_argument(name, entries, written), arguments, reader, written) for name in entries]
    return made, arrange(d for d in expanded.diagnostics if d.rule in _OF_ARGUMENTS)


def _argument(name: str, entries: Map, written: Written) -> Argument:
    """Return one declared argument; what is no mapping is its default."""
    entry, span = entries[name], entries.key_spans[name]
    if entry is None:
        return Argument(name, "any", (), True, "", "", span)
    if not isinstance(entry, Map):
        return Argument(name, "any", (), False, written.text(entries.value_spans[name]), "", span)
    default = written.text(entry.value_spans["default"]) if "default" in entry else ""
    choice = entry.get("one_of")
    allowed: list[str] = []
    if isinstance(choice, Seq):
        allowed = [written.text(place) for place in choice.value_spans]
    elif choice is not None:
        allowed = [written.text(entry.value_spans["one_of"])]
    help = " ".join(str(entry.get("help") or "").split())
    return Argument(name, str(entry.get("type") or "any"), tuple(allowed), "default" not in entry, default, help, span)


def _with_value(argument: Argument, arguments: Mapping[str, Any], reader: Reader, written: Written) -> Argument:
    """Return an argument with what it is set to, by this run or by an include."""
    name = argument.name
    if name in arguments:
        spans = arguments.value_spans if isinstance(arguments, Map) else {}
        place = spans.get(name)
        return argument._replace(value=str(arguments[name]) if place is None else written.text(place), set_at=place)
    if name in reader.given:
        place = reader.given[name][1].span
        return argument._replace(value=written.text(place), set_at=place)
    return argument

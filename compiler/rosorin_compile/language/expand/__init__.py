"""Expand: includes, arguments, named values, expressions, parts, loops and conditions; the result is one plain tree.

Scopes are lexical: a description (all its files together), each part, each round of a loop. Sections of the same name
are joined: robots of others come before all else; then the entries of the included files, in the order of the
includes; then those of the including file; then those that parts make, in the order of ``use``.

To be read in this order: ``files`` (what is included), ``parameters`` (what may be given), ``scope`` (names and their
values), ``parts`` with ``forms`` and ``placing``, ``sensor_types``, ``included_robots`` with ``prefixing``. ``ledger``
is what one expansion shares.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import (
    Diagnostic,
    MadeSpan,
    Related,
    Span,
    Suggestion,
    error,
    has_errors,
    swaps,
)
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.messages import offer, placed, told_once
from rosorin_compile.source.project import Resolved, data_folder
from rosorin_compile.source.tree import Map, Place, Seq

from ..annotations import ENTRIES
from ..schema import keys_of_xml, merged, of_parts, schema
from ..validate import validate
from ..values import ValueTable, check_names
from .files import Kept, Reader, package_finder, table_loader
from .forms import check_controls
from .included_robots import Robots
from .ledger import Failed, Ledger
from .parameters import declare
from .parts import Parts, copy
from .scope import Scope
from .sensor_types import apply_types

if TYPE_CHECKING:
    from .included_robots import ForeignReader, Tell

_FORMS = {"parts": "write NAME: {links: ..., joints: ...}", "use": "write NAME: {part: ...}"}
_FORMS |= {"sensor_types": "write NAME: {params: ..., mjcf: ...}"}
MAX_SHOWN = 40  # letters of an argument
_TAKEN_APART = tuple(_FORMS)
_NOT_EVALUATED = ("args", *_TAKEN_APART, "modes")


def _with_controls() -> list[str]:
    """Return the sections whose entries may have a loop or a condition."""
    return [section for section in merged(ENTRIES) if section not in _NOT_EVALUATED]


class Expanded(NamedTuple):
    """The plain tree (None if it could not be made), what is wrong, and the files that were read.

    ``scope`` has the arguments and the named values of the description, None if its first file could not be read.
    ``resolved`` says where the names of packages led.
    ``unused`` is what is declared in vain: worth saying once nothing is wrong. ``values`` has the uses of named values.
    """

    tree: Map | None
    diagnostics: list[Diagnostic]
    files: tuple[Path, ...]
    scope: Scope | None = None
    resolved: tuple[Resolved, ...] = ()
    unused: tuple[Diagnostic, ...] = ()
    values: ValueTable | None = None


def expand(
    path: Path,
    arguments: Mapping[str, Any],
    robots: ForeignReader | None,
    tell: Tell | None = None,
    packages: Mapping[str, Path] | None = None,
    kept: dict[Path, Kept] | None = None,
) -> Expanded:
    """Return the tree of the description whose first file is ``path``.

    ``arguments`` are values by name; texts, as given on the command line, are read like scalars of YAML. Those of a
    ``Map`` that have a place were read from a file. ``tell`` takes what has to be said before anything is run
    (``xacro-runs-code``), at that moment; without it, that is among the diagnostics. ``robots`` reads robots of others
    that are included; without it they are left out, and nothing is run. ``packages`` are folders of ROS packages by
    name, asked before those that an include names. ``kept`` has what was read before, by the first file,
    and gets what is read now.
    """
    reader = Reader(path, robots, packages)
    reader, root = (reader, reader.whole()) if kept is None else kept.setdefault(path, Kept()).read(reader)
    if root is None:
        return Expanded(None, reader.diagnostics, tuple(reader.files))
    ledger = Ledger()
    scope = Scope(ledger)
    scope.values["load()"], scope.values["find()"] = table_loader(reader), package_finder(reader)
    for name, value, place, value_place in reader.lets:
        scope.define(name, value, place, value_place)
    _declare_arguments(root, arguments, reader, scope)
    included: list[Map | None] = []
    if robots and reader.robots:
        foreign = Robots(reader, robots, scope, tell, packages or {})
        included += foreign.fragments()
    tree = _evaluate(root, scope, reader, included)
    if tree is not None and included:
        foreign.settle(tree)
    for name in list(scope.pending):
        with suppress(Failed, KeyError):  # a mistake in a value that nothing uses is found all the same
            scope.lookup(name)
    check_names(root, scope)
    led = tuple(dict.fromkeys(reader.resolved))
    values = ValueTable(root, reader, scope)
    idle = values.unused() if tree is not None else []
    told = ledger.diagnostics if tree is not None else _without_misnamed(root, ledger.diagnostics)
    if reader.unread:  # what a file would have defined is not missed
        told = [one for one in told if not _is_missing(one)]
    told = [*told, *_of_sources(reader)]
    return Expanded(tree, reader.diagnostics + _once(told), tuple(reader.files), scope, led, tuple(idle), values)


def _of_sources(reader: Reader) -> Iterator[Diagnostic]:
    """Yield what is wrong with the sources of included files, which no entry may take over."""
    for source, key, span in reader.described:
        if isinstance(source, Map) and all(_is_plain(value) for value in source.values()):
            top = Map(span)
            top.put("robot", "any", span, span)
            top.put("source", source, key, span)
            yield from validate(top, {})


def _is_plain(value: Any) -> bool:
    """Say whether a value has no expression; texts by name may be one."""
    if isinstance(value, Map):
        return all(map(_is_plain, value.values()))
    return isinstance(value, str) and "$" not in value


def _once(diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Return what is wrong, with every name that there is not told once, where it was written."""
    if not has_errors(diagnostics):
        return diagnostics

    offers = [offer(one) for one in diagnostics]
    return told_once(placed(one, of) if of else one for one, of in zip(diagnostics, offers, strict=True))


def _without_misnamed(root: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Return what is wrong; of a section with another name than it should have that, not all that is missing by it."""
    known = {*schema("description")["properties"], *_TAKEN_APART}
    sections = Map(root.span)
    for key, value in root.items():
        if key not in known:
            sections.put(key, value, root.key_spans[key], root.value_spans[key])
    misnamed = [one for one in validate(sections, {}) if one.rule == "unknown-key"] if sections else []
    misnamed += _misnamed_loops(root)
    return [*misnamed, *(one for one in diagnostics if not (misnamed and _is_missing(one)))]


def _misnamed_loops(root: Map) -> Iterator[Diagnostic]:
    """Yield the keys that are ``for`` with two letters swapped, so that nothing gives its names a value."""
    waiting: list[Any] = [root]
    while waiting:
        node = waiting.pop()
        for key, value in node.items() if isinstance(node, Map) else enumerate(node):
            if isinstance(value, (Map, Seq)):
                waiting.append(value)
            if isinstance(value, Map) and isinstance(key, str) and "for" in swaps(key):
                message, help = f'an entry has no key "{key}"', 'did you mean "for"?'
                place = Place(node.key_spans[key], node.via)
                yield error("unknown-key", message, place.span, help, place.stack())


def _is_missing(diagnostic: Diagnostic) -> bool:
    """Say whether a name is told that nothing stands behind."""
    missing = diagnostic.message.startswith("there is no value named ")
    return missing or diagnostic.rule in ("unknown-part", "unknown-sensor-type", "unknown-argument")


def _evaluate(root: Map, scope: Scope, reader: Reader, robots: list[Map | None]) -> Map | None:
    """Return the tree with every section evaluated, joined to ``robots``; None after anything was wrong."""
    tree = Map(root.span)
    failed = None in robots
    for key, value in root.items():
        if key in _TAKEN_APART:
            continue
        if key in _with_controls() and not check_controls("", root, (key,), scope):
            failed = True
            continue
        place = Place(root.value_spans[key], None)
        try:
            made = value if key in _NOT_EVALUATED else scope.resolve(value, place, key in keys_of_xml())
        except Failed:
            failed = True
            continue
        tree.put(key, copy(made) if key in of_parts() else made, root.key_spans[key], root.value_spans[key])
    for key, help in _FORMS.items():
        if not isinstance(root.get(key) or {}, dict):
            what = "types" if key == "sensor_types" else "parts"
            scope.report("wrong-type", f"{key} maps names to {what}", Place(root.value_spans[key], None), help)
            failed = True
    tree = _joined(robots, tree, reader)
    parts = Parts(scope.ledger, root.get("parts"), scope, reader.library)
    uses = root.get("use")
    if isinstance(uses, Map) and not check_controls("", root, ("use",), scope):
        failed = True
    elif isinstance(uses, Map):
        failed |= not parts.use(tree, uses, scope)
    parts.check_unused()
    if failed:
        return None
    apply_types(tree, root.get("sensor_types"), scope, data_folder("parts_library") / "sensors.yaml")
    return tree


def _joined(robots: list[Map | None], own: Map, reader: Reader) -> Map:
    """Return the sections of foreign robots with those of the description behind them."""
    if not any(robots):
        return own
    tree = Map(own.span)
    for sections in [*robots, own]:
        reader.join(tree, sections or Map(own.span))
    return tree


def _declare_arguments(root: Map, arguments: Mapping[str, Any], reader: Reader, scope: Scope) -> None:
    """Bind the arguments: those given on the command line, else those an include gives, else their defaults."""
    declared = root.get("args")
    declared = declared if isinstance(declared, Map) else Map(root.span)
    given: dict[str, Any] = {}
    places: dict[str, Place] = {}
    for name, (value, place) in reader.given.items():
        with suppress(Failed):
            given[name], places[name] = scope.resolve(value, place), place
    names, values = (arguments.key_spans, arguments.value_spans) if isinstance(arguments, Map) else ({}, {})
    for name, value in arguments.items():
        if name not in declared:
            message, help = f'the description has no argument "{name}"', Suggestion(name, declared, none="it has none")
            scope.ledger.diagnostics.append(error("unknown-argument", message, names.get(name), help))
            continue
        if value == "" and type(value) is str and _type(declared[name]) != "text":
            continue  # a launch file cannot leave an argument out: name:= is not given, as xacro has it
        places[name] = Place(values.get(name) or _said_outside(name, value, declared.key_spans[name]), None)
        given[name] = _given(value, declared[name], places[name])
    declare(scope, declared, given, places, "the description", "-a {}=VALUE")


def _said_outside(name: str, value: Any, declared: Span) -> Span:
    """Return the place of an argument that no file gives, the command line or Python: where it is declared."""
    made = MadeSpan(*declared)
    made.via = (Related(f"given to this run: {name}={str(value)[:MAX_SHOWN]}", None),)
    return made


def _type(declaration: Any) -> Any:
    return declaration.get("type") if isinstance(declaration, Map) else None


def _given(value: Any, declaration: Any, place: Place) -> Any:
    """Return the value of an argument as the tree has it; what a list or a table of Python holds is at the same place.

    A text is read as in YAML, but where a text is wanted "007" is one, and 0 and 1 are booleans where those are.
    """
    if type(value) is str:
        if _type(declaration) == "boolean" and value in ("0", "1"):
            return value == "1"
        return value if _type(declaration) == "text" else plain_scalar(value)
    if type(value) is list:
        items = Seq(place.span)
        for item in value:
            items.put(_given(item, None, place), place.span)
        return items
    if type(value) is dict:
        table = Map(place.span)
        for key, item in value.items():
            table.put(key, _given(item, None, place), place.span, place.span)
        return table
    return value

"""Parts: reusable pieces of a description with typed parameters, instantiated by ``use``.

A part is named ``NAME`` (in ``parts`` of the description), ``FILE/NAME`` (in the library that ships with the tool) or
``PACKAGE:FILE/NAME`` (in a YAML file of an installed Python package).
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Hashable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import (
    WARNING,
    Diagnostic,
    Related,
    Source,
    Span,
    Suggestion,
    nearest,
)
from rosorin_compile.source.load import LoadError, load_mapping, load_own
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Instance, Map, Place, Seq
from rosorin_compile.source.units import Quantity

from ..expression.functions import kind_of
from ..expression.syntax import EFFORT
from ..schema import holds_many, is_one_entry, keys_of, keys_of_xml, of_parts
from ..symbols import MOUNT, Names, SymbolTable
from ..validate import validate
from .forms import check_content, check_file, check_part, check_sections, check_use
from .ledger import Failed, Ledger
from .mirroring import AXES
from .parameters import declare
from .placing import placed
from .scope import Scope
from .tracing import given_by

RULES = (
    Rule(
        "unknown-part",
        "There is no part of this name, or no file of parts.",
        "Correct the name; [the library](parts-library.md).",
        ARGUMENTS,
    ),
    Rule(
        "part-cycle",
        "Parts stand in parts without end, or deeper than any robot.",
        "A part that uses itself ends with an `if`.",
        ARGUMENTS,
    ),
)

MAX_NESTED = 40
INSTANCE = 20  # values that a part counts for, however little it holds


class Definition(NamedTuple):
    """A part as it was written, and the scope of the file that it stands in."""

    name: str
    body: Map
    scope: Scope


class _Made(NamedTuple):
    """What a part came to with some values: its sections, not placed yet, and how many values and steps that took.

    ``names`` are those that it defines; ``given`` is what it was made with.
    """

    fragment: Map
    names: Names
    scope: Scope
    nodes: int
    work: int
    given: Any


class Parts:
    """Finds parts and instantiates them."""

    def __init__(self, ledger: Ledger, own: Map | None, scope: Scope, library: Callable[[str], Path | None]) -> None:
        self.ledger = ledger
        self.own = own if isinstance(own, Map) else None
        self.scope = scope
        self.library = library
        self.files: dict[Path, tuple[Map, Scope] | None] = {}
        self.sound: dict[int, bool] = {}
        # What parts without parts, loops and elements of XML came to, by the part and what it was given.
        self.made: dict[Hashable, _Made] = {}
        self.alone: dict[int, tuple[str, ...] | None] = {}
        self.found: dict[str, Definition] = {}
        ledger.find = self.body

    def instantiate(self, name: str, entry: Any, scope: Scope, where: Place, depth: int = 0) -> Map:
        """Return the fragment of a description that a ``use`` entry makes. Raises Failed after reporting."""
        if not isinstance(entry, Map):
            scope.report("wrong-type", f'use "{name}" is a mapping that names a part', where, "write part: NAME")
            raise Failed
        self.ledger.parts += 1
        check_use(name, entry, scope)
        definition = self._find(entry, scope, where)
        scope.count(INSTANCE, where.span, where.via)
        if depth > MAX_NESTED:
            message = f'parts stand in parts, more than {MAX_NESTED} deep, at part "{definition.name}"'
            scope.report("part-cycle", message, where, "a part that uses itself ends with an if")
            self.ledger.nodes, self.ledger.full = sys.maxsize, True  # told once, not for each of its branches
            raise Failed
        message = f'part "{definition.name}" used here as "{name}"'
        prefix = scope.prefix + prefix_of(name, entry)
        via = Instance(message, where.span, scope.via or where.via, True, prefix)
        key = self._key(definition, name, prefix, entry)
        made = self.made.get(key) if key is not None else None
        if made is not None:
            self.ledger.scopes[id(via)] = partial(self._again, made, definition, via, name, prefix, entry)
            scope.count(made.nodes, where.span, where.via)
            EFFORT.total += made.work
            return self._placed(name, made.fragment.by(via), made.names, entry, scope, where)
        inner = _scope(self.ledger, definition, via, prefix, entry)
        made = self._evaluated(definition, name, inner, entry, depth)
        if key is not None:
            self.made[key] = made._replace(fragment=_of_nobody(made.fragment, definition.body))
        return self._placed(name, made.fragment, made.names, entry, scope, where)

    def _evaluated(self, definition: Definition, name: str, inner: Scope, entry: Map, depth: int) -> _Made:
        """Return what a part comes to. Raises Failed after reporting."""
        nodes, work = self.ledger.nodes, self.ledger.work
        self._bind(inner, name, entry, definition)
        content = entry.get("content")
        fragment = self._fragment(definition, inner, depth, isinstance(content, Map))
        if isinstance(content, Map):
            join(fragment, content, of_parts(), inner)
        evaluate_rest(inner)
        given = entry.get("with")
        return _Made(
            fragment, SymbolTable(fragment).names(), inner, self.ledger.nodes - nodes, self.ledger.work - work, given
        )

    def _key(self, definition: Definition, name: str, prefix: str, entry: Map) -> Hashable:
        """Return all that the sections of a part depend on; None where they have to be evaluated anew each time."""
        body = definition.body
        if id(body) not in self.alone:
            self.alone[id(body)] = _read_by(body)
        read = self.alone[id(body)]
        if read is None or entry.get("content") is not None:
            return None
        own = {"name": name, "prefix": prefix}
        given = entry.get("with")
        values = given.items() if isinstance(given, Map) else ()
        return (
            id(body),
            entry.get("mirror") is not None,
            *[own[word] for word in read],
            *[(key, type(value), _exactly(value)) for key, value in values],
        )

    def _again(self, made: _Made, definition: Definition, via: Instance, name: str, prefix: str, entry: Map) -> Scope:
        """Return the scope of a part that came to the same before."""
        inner = _scope(self.ledger, definition, via, prefix, entry)
        place = Place(entry.span, entry.via)
        own = {"name": name, "prefix": prefix}
        given = entry.get("with")
        said = (definition.body.get("params") or (), definition.body.get("let") or ())
        bound = [word for word in ("name", "mirrored", "prefix") if not any(word in names for names in said)]
        bound = [word for word in bound if word in made.scope.values]
        inner.values = made.scope.values | {word: own[word] for word in bound if word in own}
        inner.places = made.scope.places | dict.fromkeys(bound, place)
        if isinstance(given, Map):
            inner.values |= given
            inner.places |= {key: Place(given.value_spans[key], given.via) for key in given}
        inner.said, inner.declared = made.scope.said, made.scope.declared
        return inner

    def body(self, name: str) -> Map | None:
        """Return a part as it is written; None if there is none, of which nothing is said."""
        told = len(self.ledger.diagnostics)
        with suppress(Failed):
            place = Place((self.own or Map(Span(Source("", ""), 1, 1))).span, None)
            return (self.found.get(name) or self._looked_up(name, self.scope, place)).body
        del self.ledger.diagnostics[told:]
        return None

    def check_unused(self) -> None:
        """Look at the parts of the description that nothing uses, as far as that can be done without arguments."""
        left = len(self.ledger.left_out)
        for name, body in (self.own or {}).items():
            if id(body) in self.sound or not check_part(name, self.own or Map(body.span), self.scope):
                continue
            probe = Scope(self.ledger, self.scope)
            params = body.get("params")
            own = ("name", "mirrored", *(() if "prefix" in (body.get("let") or ()) else ("prefix",)))
            for parameter in (*own, *(params or ())):  # broken names have no value, and nothing is said of that
                probe.places[parameter] = Place(body.span, body.via)
                probe.broken.add(parameter)
            probe.define_all(body.get("let"))
            for key in (*of_parts(), "use"):
                if body.get(key) is not None:
                    with suppress(Failed):
                        probe.resolve(body[key], Place(body.value_spans[key], body.via), key in keys_of_xml())
            with suppress(Failed):
                evaluate_rest(probe)
        del self.ledger.left_out[left:]  # of what is not used at all

    def _bind(self, inner: Scope, name: str, entry: Map, definition: Definition) -> None:
        """Bind the parameters and the named values of a part."""
        given = entry.get("with")
        given = Map(entry.span, entry.via) if given is None else given
        known = definition.body.get("params") or ()
        places = {key: Place((given.value_spans if key in known else given.key_spans)[key], given.via) for key in given}
        before = len(self.ledger.diagnostics)
        inner.bind("name", name, Place(entry.span, entry.via))
        inner.bind("mirrored", entry.get("mirror") is not None, Place(entry.span, entry.via))
        named = (definition.body.get("params") or (), definition.body.get("let") or ())
        if not any("prefix" in names for names in named) and definition.scope.place_of("prefix") is None:
            inner.bind("prefix", inner.prefix, Place(entry.span, entry.via))
        owner, asked = f'part "{definition.name}"', inner.via.span if inner.via else entry.span
        way = "with: {{{}: VALUE}}"
        inner.define_all(definition.body.get("let"))
        declare(inner, definition.body.get("params"), given, places, owner, way, Place(asked, entry.via))
        if len(self.ledger.diagnostics) > before:
            raise Failed

    def _fragment(self, definition: Definition, inner: Scope, depth: int, grows: bool) -> Map:
        """Return the sections of a part, evaluated, with the parts that it uses itself; ``grows`` if more is joined."""
        body = definition.body
        grows = grows or body.get("use") is not None
        made = Map(body.span, inner.via)
        failed = False
        for section in of_parts():
            if body.get(section) is not None:
                try:
                    place = Place(body.value_spans[section], inner.via)
                    value = inner.resolve(body[section], place, section in keys_of_xml())
                    # Without expressions it is the very section that stands in the part, and that must not grow.
                    value = copy(value) if grows else value
                    made.put(section, value, body.key_spans[section], body.value_spans[section])
                except Failed:
                    failed = True
        if not failed:
            check_sections(f'part "{definition.name}"', made, inner)
        if isinstance(body.get("use"), Map):
            failed |= not self.use(made, body["use"], inner, depth + 1)
        if failed:
            raise Failed
        return made

    def use(self, tree: Map, entries: Map, scope: Scope, depth: int = 0) -> bool:
        """Join what each ``use`` entry makes to a tree; say whether all went well."""
        fine = True
        via = scope.via or entries.via
        for key, item in entries.items():
            place_of_key = Place(entries.key_spans[key], via)
            try:
                check_content(key, item, scope)
                for inner, entry in scope.entries(item, key, is_use=True):
                    name = inner.name(key, place_of_key.span, place_of_key.via) if "$" in key else key
                    resolved = inner.resolve(entry, Place(entries.value_spans[key], via))
                    fragment = self.instantiate(name, resolved, inner, place_of_key, depth)
                    size = sum(map(len, filter(None, fragment.values())))  # parts in parts multiply
                    scope.count(size, place_of_key.span, place_of_key.via)
                    join(tree, fragment, of_parts(), scope)
            except Failed:
                fine = False
        return fine

    def _placed(self, name: str, fragment: Map, names: Names, entry: Map, scope: Scope, where: Place) -> Map:
        """Return a fragment with its prefix, on its mount, each of its entries with a source."""
        parent, mirror = entry.get("parent"), entry.get("mirror")
        if mirror is not None and (not isinstance(mirror, str) or mirror not in AXES):
            place = Place(entry.value_spans["mirror"], entry.via)
            told = f'"{mirror}"' if isinstance(mirror, str) else kind_of(mirror)
            help = "one of x, y, z: the axis that is reversed"
            scope.report("wrong-value", f"mirror cannot be {told}", place, help)
            raise Failed
        mounted = names.mounted
        if parent is None and mounted:
            help = "the part is attached to a frame: write parent: FRAME"
            scope.report("missing-key", f'use "{name}" needs the key "parent"', where, help)
            raise Failed
        ignored = [key for key in ("parent", "xyz", "rpy") if entry.get(key) is not None] if not mounted else []
        if ignored:
            place = Place(entry.key_spans[ignored[0]], scope.via or entry.via)
            help = "in the part, write parent: mount where it is attached; or remove the key"
            message = f'use "{name}" has "{ignored[0]}", but nothing of the part is attached to "{MOUNT}"'
            stack = scope.via.stack() if scope.via else ()
            self.ledger.diagnostics.append(Diagnostic("ignored-key", WARNING, message, place.span, tuple(stack), help))
        made = placed(fragment, prefix_of(name, entry), parent, entry.get("xyz"), entry.get("rpy"), mirror, names=names)
        return with_source(made, entry) if "source" in entry else made

    def _find(self, entry: Map, scope: Scope, where: Place) -> Definition:
        name = entry.get("part")
        if not isinstance(name, str):
            scope.report("missing-key", 'a use needs the key "part"', where, "name a part of parts: or of the library")
            raise Failed
        if name not in self.found:
            self.found[name] = self._looked_up(name, scope, Place(entry.value_spans["part"], scope.via or entry.via))
        return self.found[name]

    def _looked_up(self, name: str, scope: Scope, place: Place) -> Definition:
        if "/" not in name:
            return self._definition(name, name, self.own, self.scope, scope, place)
        file, _, short = name.rpartition("/")
        path = self.library(file)
        loaded = self._load(path, file, place.span) if path is not None else None
        if loaded is None:
            help = self._near(short) or "see docs/parts-library.md"
            scope.report("unknown-part", f'there is no file "{file}" of parts', place, help)
            raise Failed
        return self._definition(name, short, loaded[0].get("parts"), loaded[1], scope, place)

    def _definition(self, name: str, short: str, parts: Any, home: Scope, scope: Scope, place: Place) -> Definition:
        known = parts if isinstance(parts, Map) else Map(place.span)
        if short not in known:
            folder = name.removesuffix(short)
            places = {f"{folder}{part}": span for part, span in known.key_spans.items()}
            library = self._near(short) or "define it under parts"
            help = Suggestion(name, [*places], none=library, instead="" if known else library, places=places)
            scope.report("unknown-part", f'there is no part "{name}"', place, help)
            raise Failed
        body = known[short]
        if id(body) not in self.sound:
            self.sound[id(body)] = check_part(short, known, home)
        if not self.sound[id(body)]:
            raise Failed
        return Definition(name, body, home)

    def _near(self, short: str) -> str:
        """Return the way out for a part that is not where it was looked for: parts of the library called like it."""
        names: dict[str, list[str]] = {}
        for path in sorted(data_folder("parts_library").glob("*.yaml")):
            with suppress(LoadError):
                for part in load_mapping(path, path.name).get("parts") or ():
                    names.setdefault(part, []).append(f'"{path.stem}/{part}"')
        close = nearest(short, names)
        return f"did you mean {' or '.join(names[close])}?" if close else ""

    def _load(self, path: Path, file: str, asked: Span) -> tuple[Map, Scope] | None:
        """Return a file of parts, shown as ``PACKAGE/FILE.yaml``, and its scope; read once."""
        if path not in self.files:
            self.files[path] = None
            try:
                package, _, name = file.rpartition(":")
                said = f"{package or 'parts'}/{name}.yaml"
                tree = load_mapping(path, said, asked) if package else load_own(path, said)
            except LoadError as problem:
                self.ledger.diagnostics.append(problem.diagnostic)
                raise Failed from None
            home = Scope(self.ledger)
            check_file(tree.span.source.path, tree, home)
            home.define_all(tree.get("let"))
            self.files[path] = (tree, home)
        return self.files[path]


def _scope(ledger: Ledger, definition: Definition, via: Instance, prefix: str, entry: Map) -> Scope:
    """Return the scope of a part that a ``use`` entry makes, without any names yet."""
    inner = Scope(ledger, definition.scope, via)
    inner.prefix = prefix
    if entry.get("parent") is not None:
        inner.mount = Place(entry.value_spans["parent"], entry.via)
    return inner


# What a part knows of its use: an expression that speaks of it comes to something else each time.
_OF_USE = re.compile(r"\b(name|prefix)\b")
_SHARED = frozenset(("help", "params", "let", "links", "joints"))


def _read_by(body: Map) -> tuple[str, ...] | None:
    """Return which of its name and its prefix a part speaks of; None for one that is evaluated anew each time.

    That is one with parts or loops within, or with anything beside links and joints: who made what in it has to be
    known there.
    """
    if not body.keys() <= _SHARED:
        return None
    read: set[str] = set()
    waiting: list[Any] = [body]
    ends = {"for", "if", *keys_of_xml()}
    while waiting:
        value = waiting.pop()
        if isinstance(value, str):
            read.update(_OF_USE.findall(value) if "$" in value else ())
        elif isinstance(value, Map):
            if not value.keys().isdisjoint(ends) or any("$" in key for key in value):
                return None
            waiting += value.values()
        elif isinstance(value, Seq):
            waiting += value
    return tuple(sorted(read))


def _exactly(value: Any) -> Hashable:
    """Return what tells a value from all others that may be printed or calculate otherwise."""
    if isinstance(value, Quantity):
        return (repr(float(value)), value.dimension, value.text)
    if isinstance(value, (Map, Seq)):
        return id(value)
    return repr(value)


def _of_nobody(fragment: Map, body: Map) -> Map:
    """Return the sections of a part with entries that no use has made yet."""
    made = Map(fragment.span, body.via)
    for section, entries in fragment.items():
        if isinstance(entries, Map):
            entries = copy(entries)
            for name, entry in entries.items():
                if isinstance(entry, Map):
                    entries[name] = copy(entry)
                    entries[name].via = body.via
        made.put(section, entries, fragment.key_spans[section], fragment.value_spans[section])
    return made


def prefix_of(name: str, entry: Map) -> str:
    """Return what a use puts before the names of its part: what it says, or its own name."""
    prefix = entry.get("prefix", f"{name}_")
    return "" if prefix is None else str(prefix)


def evaluate_rest(scope: Scope) -> None:
    """Evaluate the named values of a scope that nothing has needed, for their mistakes. Raises Failed after those."""
    failed = False
    for name in list(scope.pending):
        try:
            scope.lookup(name)
        except Failed:
            failed = True
    if failed:
        raise Failed


def join(tree: Map, more: Map, sections: tuple[str, ...], scope: Scope) -> None:
    """Add the sections of one fragment to those of a tree; a name that is taken is reported. Raises Failed."""
    failed = False
    for section in filter(more.__contains__, sections):
        value = more[section]
        if value is None:
            continue
        if tree.get(section) is None:
            joined = copy(value)
            if isinstance(joined, (Map, Seq)) and not is_one_entry(section):
                joined.via = tree.via  # it holds the entries of others too: each entry knows what made it
            tree.put(section, joined, more.key_spans[section], more.value_spans[section])
            continue
        have = tree[section]
        if is_one_entry(section):
            failed |= not _join_one(section, tree, more, scope)
        elif isinstance(have, Seq) and isinstance(value, Seq):
            for item, span in zip(value, value.value_spans, strict=True):
                have.put(item, span)
        elif isinstance(have, Map) and isinstance(value, Map):
            failed |= not _join_entries(section, have, value, scope)
    if failed:
        raise Failed


def _join_entries(section: str, have: Map, value: Map, scope: Scope) -> bool:
    """Add entries by name; a name that is taken is reported. Say whether none was."""
    if have.keys().isdisjoint(value):
        have.update(value)
        have.key_spans.update(value.key_spans)
        have.value_spans.update(value.value_spans)
        return True
    taken = have.keys() & value.keys()
    for name, entry in value.items():
        if name in taken:
            _taken(section, name, have, value, scope)
        else:
            have.put(name, entry, value.key_spans[name], value.value_spans[name])
    return not taken


def _join_one(section: str, tree: Map, more: Map, scope: Scope) -> bool:
    """Add one entry that is there already, as far as it holds entries by name; say whether all went well.

    Where it cannot be joined, its shape is told first: a key that nobody knows holds nothing that can be said twice.
    """
    have, value = tree[section], more[section]
    many = holds_many(section) and isinstance(have, Map) and isinstance(value, Map)
    is_known = many and value.keys() <= keys_of(section)
    twice = join_within(have, value) if is_known else []
    if is_known and not twice:
        have.via = tree.via  # it holds the entries of others too: each entry knows what made it
        return True
    wrong = [*_misshapen(section, tree), *_misshapen(section, more)]
    scope.ledger.diagnostics += wrong
    if not many:
        _said_twice(section, tree, more, scope)
    for key, name, mine, other in twice if not wrong else ():
        _taken(key, name, mine, other, scope)
    return False


def _misshapen(section: str, tree: Map) -> list[Diagnostic]:
    """Return what is wrong with the shape of one section."""
    alone = Map(tree.span, tree.via)
    alone.put("robot", "robot", tree.span, tree.span)
    alone.put(section, tree[section], tree.key_spans[section], tree.value_spans[section])
    return validate(alone, {})


def join_within(have: Map, more: Map) -> list[tuple[str, str, Map, Map]]:
    """Add to one entry what another one says: names to tables, items to lists.

    Return what both say: the key, the name, and the two tables.
    """
    twice = []
    for key, value in more.items():
        mine = have.get(key)
        if mine is None:
            have.put(key, copy(value), more.key_spans[key], more.value_spans[key])
        elif isinstance(mine, Seq) and isinstance(value, Seq):
            have[key] = joined = copy(mine)
            for item, span in zip(value, value.value_spans, strict=True):
                joined.put(item, span)
        elif all(
            isinstance(one, Map) and all(isinstance(item, (Map, Seq)) for item in one.values()) for one in (mine, value)
        ):
            have[key] = joined = copy(mine)
            for name, entry in value.items():
                if name not in joined:
                    joined.put(name, entry, value.key_spans[name], value.value_spans[name])
                elif not _is_same(name, joined, value):
                    twice.append((key, name, joined, value))
        elif not _is_same(key, have, more):
            twice.append((key, key, have, more))
    return twice


def _is_same(key: str, have: Map, more: Map) -> bool:
    """Say whether two uses of a part say the same at a key, about something that is not of the part."""
    return bool(have[key] == more[key]) and have.value_spans[key] == more.value_spans[key]


def _taken(section: str, name: str, have: Map, more: Map, scope: Scope) -> None:
    place = Place(more.key_spans[name], getattr(more[name], "via", None) or more.via)
    related = [Related("first defined here", have.key_spans[name])]
    message, help = f'{section.rstrip("s")} "{name}" is defined twice', "rename one, or give the part another prefix"
    if more.get(section) is not None:  # what cannot be joined, and has no name
        message, help = f'"{name}" is said twice', "remove one"
    scope.report_traced("duplicate-name", message, place, help, related, given_by(scope.ledger.root, place))


def _said_twice(section: str, have: Map, more: Map, scope: Scope) -> None:
    place = Place(more.key_spans[section], getattr(more[section], "via", None) or more.via)
    first = Place(have.key_spans[section], getattr(have[section], "via", None))
    related = [Related("first defined here", first.span), *first.stack()]
    scope.report("duplicate-key", f'"{section}" is said twice', place, f"a robot has one {section}", related)


def copy(value: Any) -> Any:
    """Return a section that more may be joined to; the tree that it came from stays as it is."""
    if isinstance(value, Map):
        return value.copied()
    if isinstance(value, Seq):
        listed = Seq(value.span, value.via)
        for item, span in zip(value, value.value_spans, strict=True):
            listed.put(item, span)
        return listed
    return value


def with_source(tree: Map, owner: Map) -> Map:
    """Return sections in which every entry has a source: its own, or that of ``owner``."""
    made = Map(tree.span, tree.via)
    for section, entries in tree.items():
        value = entries
        if isinstance(entries, Map) and not holds_many(section):
            value = _with_own_source(entries, owner) if is_one_entry(section) else sourced(entries, owner)
        made.put(section, value, tree.key_spans[section], tree.value_spans[section])
    return made


def sourced(section: Map, owner: Map) -> Map:
    """Return a section in which every entry has a source: its own, or that of ``owner``, a file or a use."""
    made = Map(section.span, section.via)
    for name, entry in section.items():
        sourced_entry = _with_own_source(entry, owner) if isinstance(entry, Map) else entry
        made.put(name, sourced_entry, section.key_spans[name], section.value_spans[name])
    return made


def _with_own_source(entry: Map, owner: Map) -> Map:
    """Return an entry with a source: its own, or that of ``owner``."""
    if "source" in entry:
        return entry
    made: Map = copy(entry)
    made.put("source", owner["source"], owner.key_spans["source"], owner.value_spans["source"])
    return made

"""The symbol table of expressions: arguments, named values, parts and sensor types, and what refers to them.

It covers what is written in the files, whatever the arguments of this run: a branch that is not taken uses its names.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Set
from itertools import chain, islice
from typing import Any

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Span
from rosorin_compile.source.project import ENDINGS
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.wording import difference, in_words, look, unseen

from .expand.files import Reader
from .expand.scope import Scope
from .expression import all_names, pieces

RULES = (
    Rule("unused", "A warning: nothing names an argument, value, part, publisher or mode.", "Remove it.", ARGUMENTS),
)

_WORD = re.compile(r"[^\W\d]\w*")
_NO_NAMES: frozenset[str] = frozenset()
# Names that parts and sensor types always have.
_BUILT_IN = {"parts": ("name", "mirrored"), "sensor_types": ("name", "frame", "parent")}
# Keys below which nothing refers to parts, types or publishers; large robots have many of them.
_BODIES = ("visual", "collision", "inertial", "limit", "dynamics", "source", "xyz", "rpy", "axis", "mjcf", "help")
_MAX_FILES = 500
_Unused = tuple[str, Place, str]
_Use = tuple[str, Place]  # a name in an expression, and the place of the expression


def check_names(root: Map, scope: Scope) -> None:
    """Report invisible letters in the names of parts, types and values; warn of names that look alike."""
    groups = {"part": root.get("parts"), "use": root.get("use"), "sensor type": root.get("sensor_types")}
    named = [(kind, _places(owner)) for kind, owner in groups.items()]
    for owner in (root.get("parts"), root.get("sensor_types")):
        for body in owner.values() if isinstance(owner, Map) else ():
            if isinstance(body, Map):
                named += [("parameter", _places(body.get("params"))), ("value", _places(body.get("let")))]
    arguments = _places(root.get("args"))
    values = {name: place for name, place in scope.places.items() if name not in arguments}
    for kind, places in (*named, ("argument", arguments), ("value", values)):
        ignore_case = kind in ("part", "sensor type")  # in a formula r and R are two names
        first: dict[str, str] = {}
        for name, place in places.items():
            letter = unseen(name)
            if letter:
                message = f'{kind} "{name}" has an invisible letter: {in_words(letter)}'
                scope.report("invisible-letter", message, place, "type the name again, without this letter")
                continue
            similar = first.setdefault(look(name, ignore_case), name)
            if similar != name:
                message = f'{kind} "{name}" differs from {kind} "{similar}" in {difference(name, similar)} alone'
                related = (Related("the other one", places[similar].span), *place.stack())
                help = "give one of them another name"
                warning = Diagnostic("names-look-alike", WARNING, message, place.span, related, help)
                scope.expansion.diagnostics.append(warning)


class ValueTable:
    """The arguments and named values of a description, and the expressions that use them."""

    def __init__(self, root: Map, reader: Reader, scope: Scope) -> None:
        self.root, self.reader = root, reader
        self.is_constant = scope.expansion.is_constant

    def uses(self, name: str) -> list[Place]:
        """Return the places of the expressions that use an argument or a named value of the description."""
        return list(dict.fromkeys(place for used, place in self._outer_uses() if used == name))

    def unused(self) -> list[Diagnostic]:
        """Return a warning for each name that is declared and never used."""
        shared: dict[str, bool] = {}
        warnings = []
        for message, place, help in (*self._unused_values(), *self._unused_parts(), *self._unused_publishers()):
            file = place.span.source.path
            if file not in shared:
                shared[file] = file != self.root.span.source.path and _is_shared(place.span, self.reader)
            if not shared[file]:
                warnings.append(Diagnostic("unused", WARNING, message, place.span, place.stack(), help))
        return warnings

    def _outer_uses(self) -> Iterator[_Use]:
        for section, built_in in _BUILT_IN.items():
            for _, body in _entries(self.root, section):
                yield from self._uses(body, None, {*built_in, *_places(body.get("params")), *_places(body.get("let"))})
        for key, value in self.root.items():
            if key not in (*_BUILT_IN, "modes"):
                yield from self._uses(value, Place(self.root.value_spans[key], self.root.via))
        for _, value, _, place in self.reader.lets:
            yield from self._uses(value, place)
        for value in (*self.reader.offered, *(robot.item for robot in self.reader.robots)):
            yield from self._uses(value, None)

    def _uses(self, value: Any, place: Place | None, bound: Set[str] = _NO_NAMES) -> Iterator[_Use]:
        if self.is_constant(value):
            return
        if isinstance(value, str):
            at = place or Place(Span(self.root.span.source, 1, 1), None)
            names = {name for piece in pieces(value) if piece.is_expression for name in all_names(piece.text)}
            yield from ((name, at) for name in names - bound)
        elif isinstance(value, Seq):
            for item, span in zip(value, value.value_spans, strict=True):
                yield from self._uses(item, Place(span, value.via), bound)
        else:
            inner = bound | _loop_names(value)
            for key, item in value.items():
                at = Place(value.value_spans[key], value.via)
                if key == "for" and isinstance(item, Map):
                    yield from self._uses(item, at, bound)
                elif key != "help":
                    yield from self._uses(key, Place(value.key_spans[key], value.via), inner | _loop_names(item))
                    yield from self._uses(item, at, inner)

    def _unused_values(self) -> Iterator[_Unused]:
        for section, what in (("parts", "part"), ("sensor_types", "sensor type")):
            for name, body in _entries(self.root, section):
                names = {name for name, _ in self._uses(body, None)}
                for key, kind, whose in (("params", "parameter", "the"), ("let", "value", "its")):
                    for inner, place in _places(body.get(key)).items():
                        if inner.partition("(")[0] not in names:
                            message = f'{what} "{name}" never uses its {kind} "{inner}"'
                            yield message, place, f"write ${{{inner}}} where {whose} value belongs, or remove it"
        used = {name for name, _ in self._outer_uses()}
        arguments = _places(self.root.get("args"))
        lets = {name: place for name, _, place, _ in self.reader.lets}
        for name, place in {**lets, **arguments}.items():
            if name.partition("(")[0] not in used:
                what = f'the argument "{name}"' if name in arguments else f'the value "{name}" of let'
                yield f"nothing uses {what}", place, f"write ${{{name}}} where it belongs, or remove it"

    def _unused_parts(self) -> Iterator[_Unused]:
        sections = [*self.root.items(), *(("let", value) for _, value, _, _ in self.reader.lets)]
        for section, key, what, help in (
            ("parts", "part", "nothing uses the part", "write use: {{NAME: {{part: {}}}}}, or remove it"),
            ("sensor_types", "type", "no sensor is of the type", "write type: {} in a sensor, or remove it"),
        ):
            named = _texts_at([value for owner, value in sections if owner not in ("parts", "links", "joints")], (key,))
            for part, body in _entries(self.root, "parts"):
                named |= _texts_at(body, (key,)) - ({part} if section == "parts" else set())
            if not any("$" in name for name in named):
                for name, place in _places(self.root.get(section)).items():
                    if name not in named:
                        yield f'{what} "{name}"', place, help.format(name)

    def _unused_publishers(self) -> Iterator[_Unused]:
        root, reader = self.root, self.reader
        publishers, modes = _places(root.get("publishers")), _places(root.get("modes"))
        for name, entry in _entries(root, "publishers"):
            if entry.get("stamps"):
                publishers.pop(name)
        if any("template" in entry for _, entry in _entries(root, "outputs")):  # which may print all of them
            return
        values = [value for key, value in root.items() if key not in ("publishers", "modes")]
        values += [*(value for _, value, _, _ in reader.lets), *(robot.item for robot in reader.robots)]
        owners = _texts_at(values, ("publisher", "by"))
        for name, place in publishers.items() if not any("$" in owner for owner in owners) else ():
            if name not in owners and "$" not in name:
                message = f'publisher "{name}" publishes no joint and no edge, and stamps nothing'
                yield message, place, f"write publisher: {name} where it does, or remove it"
        conditions = _texts_at(values, ("when",)) | _texts_at(root.get("outputs"))
        named = {word for condition in conditions for word in _WORD.findall(condition)}
        for name, place in modes.items() if not any("$" in condition for condition in conditions) else ():
            if name not in named:
                help = f"write when: {name} where it matters, or remove it"
                yield f'no condition names the mode "{name}"', place, help


def _loop_names(entry: Any) -> frozenset[str]:
    """Return the names that the loop of an entry defines; its key may use them too."""
    loops = entry.get("for") if isinstance(entry, Map) else None
    if not isinstance(loops, Map):
        return _NO_NAMES
    return frozenset(name.strip() for names in loops for name in names.split(","))


def _texts_at(value: Any, keys: tuple[str, ...] = ()) -> set[str]:
    found: set[str] = set()
    waiting = [("", value)]
    while waiting:
        key, item = waiting.pop()
        if isinstance(item, str):
            found |= {item} if not keys or key in keys or "load(" in item else set()
        elif isinstance(item, list):
            waiting += [("", one) for one in item]
        elif isinstance(item, Map):
            waiting += [(inner, one) for inner, one in item.items() if inner not in _BODIES]
    return found


def _entries(root: Map, section: str) -> Iterable[tuple[str, Map]]:
    owner = root.get(section)
    return [item for item in owner.items() if isinstance(item[1], Map)] if isinstance(owner, Map) else []


def _places(owner: Any) -> dict[str, Place]:
    return {key: Place(owner.key_spans[key], owner.via) for key in owner} if isinstance(owner, Map) else {}


def _is_shared(span: Span, reader: Reader) -> bool:
    own, file = {files.resolve(path) for path in reader.files}, files.resolve(span.source.path)
    siblings = chain(file.parent.glob("*"), file.parent.parent.glob("*/*"))
    nearby = [path for path in islice(siblings, _MAX_FILES) if path.suffix in ENDINGS]
    try:
        texts = (files.read_text(path, errors="replace") for path in nearby if files.resolve(path) not in own)
        return any(file.name in text for text in texts)
    except OSError:
        return False

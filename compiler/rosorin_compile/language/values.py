"""The symbol table of expressions: arguments, named values, parts and types of sensors, and what refers to them.

It covers what is written in the files, not what the arguments of this run happen to need: a branch that is not taken
uses what it names. Warnings about unused names leave out files that another description may include.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Span
from rosorin_compile.source.project import DESCRIPTIONS, ENDINGS
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.wording import difference, in_words, look, unseen

from .expand.files import Reader
from .expand.scope import Scope
from .expression import names_in, pieces

RULES = (
    Rule(
        "unused",
        "A warning: an argument, a value of `let`, a part, a type of sensors, a publisher or a mode is declared, and "
        "nothing names it.",
        "Use it or remove it. What stands in a file that another description includes too is not told.",
        ARGUMENTS,
    ),
)

_WORD = re.compile(r"[^\W\d]\w*")
_NO_NAMES: frozenset[str] = frozenset()
# Names that parts and types of sensors always have.
_BUILT_IN = {"parts": frozenset(("name", "mirrored")), "sensor_types": frozenset(("name", "frame", "parent"))}
# Of these nothing is published, and large robots have many.
_BODIES = ("visual", "collision", "inertial", "limit", "dynamics", "source", "xyz", "rpy", "axis", "mjcf", "help")
MAX_FILES = 500
MAX_BYTES = 1_000_000


def check_names(root: Map, scope: Scope) -> None:
    """Report letters that nobody sees in the names of parts, types and values; warn of names that look alike."""
    groups = {"part": root.get("parts"), "use": root.get("use"), "sensor type": root.get("sensor_types")}
    named = [(kind, owner) for kind, owner in groups.items() if isinstance(owner, Map)]
    bodies = [body for kind, owner in named if kind != "use" for body in owner.values() if isinstance(body, Map)]
    for kind, key in (("parameter", "params"), ("value", "let")):
        named += [(kind, body[key]) for body in bodies if isinstance(body.get(key), Map)]
    for kind, owner in named:
        _check_letters(kind, _places(owner), scope)
    arguments = _places(root.get("args"))
    _check_letters("argument", arguments, scope)
    _check_letters("value", {name: place for name, place in scope.places.items() if name not in arguments}, scope)


def _check_letters(kind: str, places: dict[str, Place], scope: Scope) -> None:
    text = "".join(places)
    by_case = kind in ("part", "sensor type")  # in a formula r and R are two things
    if text.isascii() and text.isprintable() and not by_case:
        return
    first: dict[str, str] = {}
    for name, place in places.items():
        letter = unseen(name)
        if letter:
            message = f'{kind} "{name}" has a letter that nobody sees: {in_words(letter)}'
            scope.report("invisible-letter", message, place, "type the name anew, without it")
            continue
        twin = first.setdefault(look(name, by_case), name)
        if twin != name:
            message = f'{kind} "{name}" differs from {kind} "{twin}" in {difference(name, twin)} alone'
            related = (Related("the other one", places[twin].span), *place.stack())
            help = "give one of them another name"
            alike = Diagnostic("names-look-alike", WARNING, message, place.span, related, help)
            scope.expansion.diagnostics.append(alike)


_Unused = tuple[str, Place, str]


def _names_in_text(text: str) -> set[str]:
    """Return the names in the expressions of a text."""
    return {name for piece in pieces(text) if piece.is_expression for name in names_in(piece.text)}


def _looped(entry: Any) -> frozenset[str]:
    """Return the names that the loop of an entry gives a value; the key of the entry knows them too."""
    loops = entry.get("for") if isinstance(entry, Map) else None
    if not isinstance(loops, Map):
        return _NO_NAMES
    return frozenset(name.strip() for names in loops for name in names.split(","))


def _words(text: str) -> set[str]:
    """Return the words of the expressions in a text: more than their names, but no name is missing."""
    words = {word for piece in pieces(text) if piece.is_expression for word in _WORD.findall(piece.text)}
    if not text.isascii():
        from unicodedata import normalize

        words = {normalize("NFKC", word) for word in words}  # as Python reads names
    return words


class Use(NamedTuple):
    """A word in an expression, the text of that, and its place."""

    word: str
    text: str
    place: Place


class ValueTable:
    """The arguments and named values of a description, and the expressions that use them."""

    def __init__(self, root: Map, reader: Reader, scope: Scope) -> None:
        self.root, self.reader = root, reader
        self.is_constant = scope.expansion.is_constant

    def uses(self, name: str) -> list[Place]:
        """Return the places of the expressions that use an argument or a named value of the description."""
        found = [use.place for use in self._outer_uses() if use.word == name and name in _names_in_text(use.text)]
        return list(dict.fromkeys(found))

    def _outer_uses(self) -> Iterator[Use]:
        """Yield the words of all expressions that may be names of the description: those of parts are left out."""
        for section in _BUILT_IN:
            for _, body in _entries(self.root, section):
                if isinstance(body, Map):
                    own = set().union(*(_places(body.get(key)) for key in ("params", "let"))) - _BUILT_IN[section]
                    yield from (one for one in self._uses(body, None) if one.word not in own | _BUILT_IN[section])
        for key, value in self.root.items():
            if key not in (*_BUILT_IN, "modes"):
                yield from self._uses(value, Place(self.root.value_spans[key], self.root.via))
        for _, value, _, place in self.reader.lets:
            yield from self._uses(value, place)
        for value in (*self.reader.offered, *(robot.item for robot in self.reader.robots)):
            yield from self._uses(value, None)

    def _uses(self, value: Any, place: Place | None, bound: frozenset[str] = _NO_NAMES) -> Iterator[Use]:
        """Yield the words of all expressions in a piece of the tree that no loop around them gives a value."""
        if self.is_constant(value):
            return
        if isinstance(value, str):
            at = place or Place(Span(self.root.span.source, 1, 1), None)
            yield from (Use(word, value, at) for word in _words(value) if word not in bound)
        elif isinstance(value, Seq):
            for item, span in zip(value, value.value_spans, strict=True):
                yield from self._uses(item, Place(span, value.via), bound)
        else:
            inner = bound | _looped(value)
            for key, item in value.items():
                at = Place(value.value_spans[key], value.via)
                if key == "for" and isinstance(item, Map):
                    yield from self._uses(item, at, bound)
                elif key != "help":
                    yield from self._uses(key, Place(value.key_spans[key], value.via), inner | _looped(item))
                    yield from self._uses(item, at, inner)

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

    def _unused_values(self) -> Iterator[_Unused]:
        """Yield the arguments and named values that no expression uses, those of parts and types of sensors too."""
        for section, what in (("parts", "part"), ("sensor_types", "sensor type")):
            for name, body in _entries(self.root, section):
                inside = {use.word for use in self._uses(body, None)} if isinstance(body, Map) else set()
                for key, kind in (("params", "parameter"), ("let", "value")) if isinstance(body, Map) else ():
                    for inner, place in _places(body.get(key)).items():
                        if inner.partition("(")[0] not in inside:
                            message = f'{what} "{name}" never uses its {kind} "{inner}"'
                            whose = "its" if key == "let" else "the"
                            yield message, place, f"write ${{{inner}}} where {whose} value belongs, or remove it"
        used = {use.word for use in self._outer_uses()}
        arguments = _places(self.root.get("args"))
        for name, place in arguments.items():
            if name not in used:
                yield f'nothing uses the argument "{name}"', place, f"write ${{{name}}} where it belongs, or remove it"
        for name, _, place, _ in self.reader.lets:
            if name.partition("(")[0] not in used and name not in arguments:
                message = f'nothing uses the value "{name}" of let'
                yield message, place, f"write ${{{name}}} where it belongs, or remove it"

    def _unused_parts(self) -> Iterator[_Unused]:
        """Yield the parts that no ``use`` names, and the types that no sensor is of."""
        root, reader = self.root, self.reader
        for section, key, what, help in (
            ("parts", "part", "nothing uses the part", "write use: {{NAME: {{part: {}}}}}, or remove it"),
            ("sensor_types", "type", "no sensor is of the type", "write type: {} in a sensor, or remove it"),
        ):
            places = _places(root.get(section))
            if not places:
                continue
            named: set[str] = set()
            for owner, value in (*root.items(), *(("let", value) for _, value, _, _ in reader.lets)):
                if owner not in ("parts", "links", "joints"):
                    named |= _values_at(value, (key,))
            for part, body in _entries(root, "parts"):
                named |= _values_at(body, (key,)) - ({part} if section == "parts" else set())
            if not any("$" in name for name in named):
                for name, place in places.items():
                    if name not in named:
                        yield f'{what} "{name}"', place, help.format(name)

    def _unused_publishers(self) -> Iterator[_Unused]:
        """Yield the publishers that publish and stamp nothing, and the modes that no condition names."""
        root, reader = self.root, self.reader
        publishers, modes = _places(root.get("publishers")), _places(root.get("modes"))
        for name, entry in _entries(root, "publishers"):
            if "$" in name or (isinstance(entry, Map) and entry.get("stamps")):
                publishers.pop(name)
        own = any(isinstance(entry, Map) and "template" in entry for _, entry in _entries(root, "outputs"))
        if own or not (publishers or modes):  # a template of one's own may tell of all of them
            return
        wholes = [value for key, value in root.items() if key not in ("publishers", "modes")]
        wholes += [*(value for _, value, _, _ in reader.lets), *(robot.item for robot in reader.robots)]
        owners = _values_at(wholes, ("publisher", "by"))
        if not any("$" in owner for owner in owners):
            for name, place in publishers.items():
                if name not in owners:
                    message = f'publisher "{name}" publishes no joint and no edge, and stamps nothing'
                    yield message, place, f"write publisher: {name} where it does{_odometry(root, name)}, or remove it"
        conditions = _values_at(wholes, ("when",)) | set(_texts(root.get("outputs")))
        if not any("$" in condition for condition in conditions):
            named = {word for condition in conditions for word in _WORD.findall(condition)}
            for name, place in modes.items():
                if name not in named:
                    yield (
                        f'no condition names the mode "{name}"',
                        place,
                        f"write when: {name} where it matters, or remove it",
                    )


def _odometry(root: Map, publisher: str) -> str:
    """Return the edge of the odometry as an example, of a base that drives and has none; the child if it is known."""
    edges = [entry for entry in root.get("edges") or () if isinstance(entry, Map)]
    if not root.get("drive") or any(entry.get("parent") in ("odom", "map") for entry in edges):
        return ""
    children = {entry.get("child") for _, entry in _entries(root, "joints") if isinstance(entry, Map)}
    base = next((name for name, _ in _entries(root, "links") if name not in children), "base_link")
    return f", such as edges: [{{parent: odom, child: {base}, publisher: {publisher}}}]"


def _values_at(value: Any, keys: tuple[str, ...]) -> set[str]:
    """Return the texts that stand at keys anywhere in a piece of the tree; a whole that is computed is one of them."""
    found: set[str] = set()
    waiting = [value]
    while waiting:
        item = waiting.pop()
        if isinstance(item, Map):
            for key, inner in item.items():
                if isinstance(inner, (Map, Seq)):
                    if key not in _BODIES:
                        waiting.append(inner)
                elif isinstance(inner, str) and (key in keys or "load(" in inner):
                    found.add(inner)
        elif isinstance(item, list):
            waiting += [inner for inner in item if isinstance(inner, (Map, Seq))]
    return found


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, (Map, Seq)):
        for item in value.values() if isinstance(value, Map) else value:
            yield from _texts(item)


def _entries(root: Map, section: str) -> Iterable[tuple[str, Any]]:
    owner = root.get(section)
    return owner.items() if isinstance(owner, Map) else ()


def _places(owner: Any) -> dict[str, Place]:
    """Return where the keys of a mapping stand; nothing if it is none."""
    return {key: Place(owner.key_spans[key], owner.via) for key in owner} if isinstance(owner, Map) else {}


def _is_shared(span: Span, reader: Reader) -> bool:
    """Say whether a description that is not compiled here may include the file of a place."""
    name = Path(span.source.path).name
    own = {files.resolve(path) for path in reader.files}
    folders = {reader.folder, files.resolve(span.source.path).parent}
    if reader.folder.parent.name == DESCRIPTIONS:
        folders.add(reader.folder.parent)
    seen = 0
    for folder in folders:
        for path in _below(folder):
            seen += 1
            if seen > MAX_FILES:
                return True
            if path.suffix in ENDINGS and files.resolve(path) not in own and _names(path, name):
                return True
    return False


def _below(folder: Path) -> Iterator[Path]:
    """Yield what is in a folder and in those below it, as far as it is asked for; links are not followed."""
    try:
        inside = files.list_folder(folder)
    except OSError:
        return
    for path in inside:
        yield path
        if path.is_dir() and not path.is_symlink():
            yield from _below(path)


def _names(path: Path, name: str) -> bool:
    """Say whether a file is small enough to be a description, and has a name in its text."""
    try:
        return path.stat().st_size <= MAX_BYTES and name in files.read_text(path, errors="replace")
    except OSError:
        return False

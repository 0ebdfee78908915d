"""Declared: names that a description gives to what the plain tree no longer has, and what it declares and never uses.

What counts is what stands in the files, not what these values of the arguments happen to need: a branch that is not
taken uses what it names. A part of the library, or of a file that another description includes too, may be there for
others.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Span
from rosorin_compile.source.project import DESCRIPTIONS, ENDINGS
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.wording import difference, in_words, look, unseen

from ..expression import pieces
from .files import Reader
from .scope import Scope

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
_NONE: frozenset[str] = frozenset()
_OF_PARTS = frozenset(("name", "mirrored"))
_OF_TYPES = frozenset(("name", "frame", "parent"))
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
            scope.ledger.diagnostics.append(alike)


def unused(root: Map, reader: Reader, scope: Scope) -> list[Diagnostic]:
    """Return a warning for each name that is declared and never used."""
    idle = [*_unused_values(root, reader, scope), *_unused_parts(root, reader), *_unused_publishers(root, reader)]
    shared: dict[str, bool] = {}
    warnings = []
    for message, place, help in idle:
        file = place.span.source.path
        if file not in shared:
            shared[file] = file != root.span.source.path and _is_shared(place.span, reader)
        if not shared[file]:
            warnings.append(Diagnostic("unused", WARNING, message, place.span, place.stack(), help))
    return warnings


_Unused = tuple[str, Place, str]


def _unused_values(root: Map, reader: Reader, scope: Scope) -> Iterator[_Unused]:
    """Yield the arguments and named values that no expression names, those of parts and types of sensors too."""
    words = _Words(scope)
    used: set[str] = set()
    for section, own, what in (("parts", _OF_PARTS, "part"), ("sensor_types", _OF_TYPES, "sensor type")):
        for name, body in _entries(root, section):
            if not isinstance(body, Map):
                continue
            inside = words.of(body)
            declared: dict[str, Place] = {}
            for key in ("params", "let"):
                owner = body.get(key)
                places = _places(owner)
                declared |= places
                help = f"write ${{NAME}} where {'its' if key == 'let' else 'the'} value belongs, or remove it"
                kind = "parameter" if key == "params" else "value"
                for inner, place in places.items():
                    if inner.partition("(")[0] not in inside:
                        message = f'{what} "{name}" never uses its {kind} "{inner}"'
                        yield message, place, help.replace("NAME", inner)
            used |= inside - declared.keys() - own
    whole = [value for key, value in root.items() if key not in ("parts", "sensor_types", "modes")]
    for value in (
        *whole,
        *(value for _, value, _, _ in reader.lets),
        *reader.offered,
        *(r.item for r in reader.robots),
    ):
        used |= words.of(value)
    arguments = _places(root.get("args"))
    for name, place in arguments.items():
        if name not in used:
            yield f'nothing uses the argument "{name}"', place, f"write ${{{name}}} where it belongs, or remove it"
    for name, _, place, _ in reader.lets:
        called = name.partition("(")[0]
        if called not in used and name not in arguments:
            yield f'nothing uses the value "{name}" of let', place, f"write ${{{name}}} where it belongs, or remove it"


class _Words:
    """Finds the words of expressions that no loop around them gives a value."""

    def __init__(self, scope: Scope) -> None:
        self.is_constant = scope.ledger.is_constant

    def of(self, value: Any, bound: frozenset[str] = _NONE) -> set[str]:
        """Return the words of all expressions in a piece of the tree."""
        if self.is_constant(value):
            return set()
        if isinstance(value, str):
            return {word for word in _words_of(value) if word not in bound}
        if isinstance(value, Seq):
            return set().union(*(self.of(item, bound) for item in value))
        found: set[str] = set()
        inner = bound | _looped(value)
        for key, item in value.items():
            if key == "for" and isinstance(item, Map):
                found |= self.of(item, bound)
            elif key != "help":
                found |= self.of(key, inner | _looped(item)) | self.of(item, inner)
        return found


def _looped(entry: Any) -> frozenset[str]:
    """Return the names that the loop of an entry gives a value; the key of the entry knows them too."""
    loops = entry.get("for") if isinstance(entry, Map) else None
    return frozenset(name.strip() for names in loops for name in names.split(",")) if isinstance(loops, Map) else _NONE


def _words_of(text: str) -> set[str]:
    """Return the words of the expressions in a text: more than their names, but no name is missing."""
    words = {word for piece in pieces(text) if piece.is_expression for word in _WORD.findall(piece.text)}
    if not text.isascii():
        from unicodedata import normalize

        words = {normalize("NFKC", word) for word in words}  # as Python reads names
    return words


def _unused_parts(root: Map, reader: Reader) -> Iterator[_Unused]:
    """Yield the parts that no ``use`` names, and the types that no sensor is of."""
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


def _odometry(root: Map, publisher: str) -> str:
    """Return the edge of the odometry as an example, of a base that drives and has none; the child if it is known."""
    edges = [entry for entry in root.get("edges") or () if isinstance(entry, Map)]
    if not root.get("drive") or any(entry.get("parent") in ("odom", "map") for entry in edges):
        return ""
    children = {entry.get("child") for _, entry in _entries(root, "joints") if isinstance(entry, Map)}
    base = next((name for name, _ in _entries(root, "links") if name not in children), "base_link")
    return f", such as edges: [{{parent: odom, child: {base}, publisher: {publisher}}}]"


def _unused_publishers(root: Map, reader: Reader) -> Iterator[_Unused]:
    """Yield the publishers that publish and stamp nothing, and the modes that no condition names."""
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

"""Find where a value of the expanded tree was written, and explain the names in its expression."""

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import islice
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Instance, Map, Path, Place, Seq, has, maker
from rosorin_compile.source.units import Quantity

from .expand.provenance import scope_of
from .expand.scope import EvaluationFailed, Scope
from .expression import ExpressionError, evaluate, pieces
from .expression.functions import FUNCTIONS
from .symbols import MOUNT

MAX_LEVELS = 6
MAX_NAMES = 40
_POSE = ("xyz", "rpy")
_OF_USE = ("name", "frame")  # names that are defined in every part or sensor type
MAX_TEXT = 80
# A name with keys, such as rows[0].mass; quoted text is skipped.
_NAME = r"""'[^']*'|"[^"]*"|(?<![\w.])([^\W\d]\w*)((?:\.[^\W\d]\w*|\[[^][]*\])*)"""
_STEP = r"\.([^\W\d]\w*)|\[([^][]*)\]"

_Places = dict[tuple[int, int], "Piece"]


class Piece(NamedTuple):
    """A value in a YAML file: its path, the value, the span of the value, and the span of its key (None in a list)."""

    path: Path
    value: Any
    span: Span
    key: Span | None


class SourceEntries:
    """Look up YAML values by their position in the source; each file is parsed once."""

    def __init__(self) -> None:
        self._files: dict[str, tuple[_Places, _Places]] = {}

    def value(self, span: Span) -> Piece | None:
        """Return the innermost value that begins at a position, or None if no value begins there."""
        return self._read(span.source)[0].get((span.line, span.column))

    def entry(self, span: Span) -> Piece | None:
        """Return the value whose key begins at a position, or None if no key begins there."""
        return self._read(span.source)[1].get((span.line, span.column))

    def text(self, span: Span) -> str:
        """Return the source text of the value or entry that begins at a position, shortened to one line."""
        if _is_markup(span.source):
            text = span.source.line(span.line)[span.column - 1 :][: span.length]
        else:
            piece = self.entry(span) or self.value(span)
            text = "" if piece is None else _text(piece.value, piece.span)
        return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 3]}..."

    def _read(self, source: Source) -> tuple[_Places, _Places]:
        if source.path not in self._files:
            values, keys = self._files.setdefault(source.path, ({}, {}))
            waiting: list[tuple[Path, Any]] = []
            with suppress(LoadError):  # not every file is a description, for example a file that ``load`` reads
                waiting = [((), None if _is_markup(source) else parse_yaml(source))]
            while waiting:
                path, value = waiting.pop()
                items = value.items() if isinstance(value, Map) else enumerate(value) if isinstance(value, Seq) else ()
                for key, item in items:
                    span, named = value.value_spans[key], value.key_spans[str(key)] if isinstance(value, Map) else None
                    piece = values[span.line, span.column] = Piece((*path, key), item, span, named)
                    if named is not None:
                        keys[named.line, named.column] = piece
                    waiting.append((piece.path, item))
        return self._files[source.path]


def _is_markup(source: Source) -> bool:
    return source.text[:200].lstrip("\ufeff \t\r\n").startswith("<")


def _text(value: Any, span: Span) -> str:
    line = span.source.line(span.line)[span.column - 1 :]
    if isinstance(value, Map):
        keys = list(islice(value, MAX_TEXT))
        if line.startswith("{"):
            keys = [f"{key}: {_text(value[key], value.value_spans[key])}" for key in keys]
        return f"{{{', '.join(keys)}}}"
    if isinstance(value, Seq):
        if not line.startswith("["):
            return f"[{len(value)} items]"
        return f"[{', '.join(_text(*item) for item in islice(zip(value, value.value_spans, strict=True), MAX_TEXT))}]"
    is_folded = isinstance(value, str) and span.length < len(value)
    return "" if value is None else " ".join(value.split()) if is_folded else line[: span.length]


class Where(NamedTuple):
    """A position in a file (line and column count from 1), and the source text at that position."""

    file: str
    line: int
    column: int
    text: str


class NameOrigin(NamedTuple):
    """A name in an expression: its value (SI units), how it is defined, and the names that its definition uses."""

    name: str
    value: str
    given_by: str
    where: Where | None
    names: "tuple[NameOrigin, ...]" = ()


class Step(NamedTuple):
    """An include, part, sensor type or loop iteration that added a value to the tree."""

    message: str
    where: Where


class Origin(NamedTuple):
    """The position where a value was written, with the names in its expression.

    ``expressions`` are the expressions that inserted the value, outermost first. ``stack`` has the includes, parts and
    loops that led to the value, innermost first. If a pose was calculated from a pose in a part and poses of ``use``
    entries, ``parts`` has the origins of these poses.
    """

    where: Where
    names: tuple[NameOrigin, ...] = ()
    expressions: tuple[Where, ...] = ()
    stack: tuple[Step, ...] = ()
    parts: "tuple[Origin, ...]" = ()


class Origins:
    """Find where values of the expanded tree were written; ``arguments`` are values from the command line."""

    def __init__(self, tree: Map, root: Scope, arguments: Mapping[str, Any]) -> None:
        self.tree, self.root, self.arguments = tree, root, arguments
        self.written = SourceEntries()

    def origin_of(self, path: Path) -> Origin | None:
        """Return where the value at a path was written, or None if the value is a default."""
        node: Any = self.tree
        spans: list[Span] = []
        for step in path:
            if not has(node, step):
                return None
            spans.append(node.value_spans[step])
            node = node[step]
        span, place = spans[-1], self.tree.locate(path)
        piece = self.written.value(span)
        if isinstance(piece and piece.value, (Map, Seq)) and not isinstance(node, (Map, Seq)):
            return self._combined_pose(span, place)
        outer = [(one, self.written.value(one)) for one in spans[:-1] if one != span]
        is_text = [(one, at.value) for one, at in outer if at is not None and isinstance(at.value, str)]
        expressions = [self.where(one) for one, text in is_text if "${" in text]
        names = self._meanings_of(piece, maker(self.tree, path), place.via)
        return Origin(self.where(span), names, tuple(expressions), self._stack(place))

    def where(self, span: Span) -> Where:
        """Convert a span to a position with its source text."""
        return Where(span.source.path, span.line, span.column, self.written.text(span))

    def place_of(self, path: Path) -> tuple[Where, tuple[Step, ...]]:
        """Return the position of the entry at a path, and the includes, parts and loops that led to it."""
        return self.where(self.tree.locate(path, key=True).span), self._stack(self.tree.locate(path))

    def _stack(self, place: Place) -> tuple[Step, ...]:
        steps = []
        for message, span in ((related.message, related.span) for related in place.stack() if related.span):
            use = self._use(span) or Map(span)
            keys = [key for key in ("parent", *_POSE, "mirror") if key in use]
            mount = [f", {key}: {self.written.text(use.value_spans[key])}" for key in keys]
            steps.append(Step(message + "".join(mount), self.where(span)))
        return tuple(steps)

    def _use(self, span: Span) -> Map | None:
        piece = self.written.entry(span)
        is_use = piece is not None and piece.path[-2:-1] == ("use",) and isinstance(piece.value, Map)
        return piece.value if is_use and piece is not None else None

    def _combined_pose(self, span: Span, place: Place) -> Origin:
        parts, via = list(self._poses(self.written.value(span), place.via)), place.via
        parent: str | None = MOUNT
        while via is not None and parent == MOUNT:
            use = self._use(via.span)
            if use is not None:
                parts += self._poses(self.written.entry(via.span), via.parent)
                parent = use.get("parent")
            via = via.parent
        where = Where(span.source.path, span.line, span.column, "")
        return Origin(where, stack=self._stack(place), parts=tuple(parts))

    def _poses(self, entry: Piece | None, via: Instance | None) -> Iterator[Origin]:
        spans = entry.value.value_spans if entry is not None and isinstance(entry.value, Map) else {}
        for key in (key for key in _POSE if key in spans):
            where, piece = self.where(spans[key]), self.written.value(spans[key])
            yield Origin(where._replace(text=f"{key}: {where.text}"), self._meanings_of(piece, via, via))

    def _meanings_of(
        self, piece: Piece | None, holder: Instance | None, via: Instance | None
    ) -> tuple[NameOrigin, ...]:
        if piece is None:
            return ()
        scope = scope_of(self.root, holder)
        if scope is self.root:  # a file with parts has its own scope for named values
            *_, home = scope_of(self.root, via).ancestors()
            is_there = any(place.span.source.path == piece.span.source.path for place in home.places.values())
            scope = home if is_there else scope
        return tuple(self._names(piece.value, scope, 0))

    def _names(self, value: Any, scope: Scope, level: int) -> Iterator[NameOrigin]:
        for name, keys in list(dict.fromkeys(_names_used(value)))[:MAX_NAMES]:
            if (owner := scope.owner(name)) is not None:
                yield self.explain_name(name, keys, owner, scope, level)

    def explain_name(self, name: str, keys: str, owner: Scope, scope: Scope, level: int = 0) -> NameOrigin:
        """Explain a name and the keys after it in an expression; ``owner`` is the scope that defines the name."""
        entry, at = _entry(name, keys, scope)
        place, value = at or owner.places[name], _shown(entry)
        piece = self.written.entry(place.span) or self.written.value(place.span)
        path = piece.path if piece is not None else ()
        if name in _OF_USE and owner.via is not None and not {"params", "let", "for", "with"} & set(path):
            return NameOrigin(name + keys, value, f"{name} of what uses it", self.where(owner.via.span))
        if path[:1] == ("args",) and len(path) == 2 and name in self.arguments:
            return NameOrigin(name + keys, value, "argument, set on the command line", None)
        defined_by, inside = self._definition(name, path, owner)
        names = tuple(self._names(piece.value, inside, level + 1)) if piece is not None and level < MAX_LEVELS else ()
        return NameOrigin(name + keys, value, defined_by, self.where(place.span), names)

    def _definition(self, name: str, path: Path, owner: Scope) -> tuple[str, Scope]:
        if name in owner.looped:
            return "loop", owner.parent or self.root
        if path[:1] == ("args",):
            return "argument, its default", owner
        if path[:1] == ("include",) and "for" not in path:
            return "argument, set by the include", owner
        if len(path) == 1 and name in self.arguments:
            return "argument, set by the file", owner
        if "with" in path:
            return "given where it is used", scope_of(self.root, owner.via.parent if owner.via else None)
        if "params" in path:
            return "default of the part", owner
        return "named value" if "let" in path else "table", owner


def _names_used(value: Any) -> Iterator[tuple[str, str]]:
    """Yield (name, keys after it) for each name in the expressions of a value, such as ("body", ".length")."""
    if isinstance(value, (Map, Seq)):
        for item in value.values() if isinstance(value, Map) else value:
            yield from _names_used(item)
    for piece in pieces(value) if isinstance(value, str) else ():
        if piece.is_expression:
            yield from _chains(piece.text)


def _chains(text: str) -> Iterator[tuple[str, str]]:
    for name, keys in re.findall(_NAME, text):
        if name:  # not a quoted string
            yield name, keys
            yield from (chain for _, index in re.findall(_STEP, keys) for chain in _chains(index))


def _entry(name: str, keys: str, scope: Scope) -> tuple[Any, Place | None]:
    """Return the value of a name with keys, such as "wheel" with ".sizes[0]", and the place of the value."""
    place: Place | None = None
    with suppress(EvaluationFailed, KeyError, ExpressionError):
        value = scope.lookup(name)
        for key, index in re.findall(_STEP, keys):
            step = key or evaluate(index, scope.lookup)
            if not has(value, step):
                return None, None
            place, value = Place(value.value_spans[step], value.via), value[step]
        return value, place
    return None, None


def _shown(value: Any) -> str:
    if isinstance(value, Quantity):
        return f"{exact(value)} {value.unit}".rstrip()
    if isinstance(value, (dict, list)):
        return f"a {'table' if isinstance(value, dict) else 'list'} of {len(value)}"
    return "" if value is None else exact(value) if isinstance(value, float) else str(FUNCTIONS["str"](value))[:60]

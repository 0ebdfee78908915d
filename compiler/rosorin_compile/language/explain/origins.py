"""Origins: where a value of the plain tree was written, and what the names in its expression stand for.

``Origins`` finds the place of a value; ``Meanings`` goes on to the places that gave the names their values.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Instance, Map, Path, Place, Seq, locate, maker
from rosorin_compile.source.units import NUMBER, Quantity, describe

from ..expand.expansion import Failed
from ..expand.scope import Scope
from ..expression import ExpressionError, evaluate, parsed, pieces
from ..symbols import MOUNT
from ..written import Piece, Written
from .explanation import Meaning, Origin, Step, Where

_POSE = ("xyz", "rpy")


class Origins:
    """Answers for one tree; ``scope`` is that of the description, ``given`` its arguments from the command line."""

    def __init__(self, tree: Map, scope: Scope, given: dict[str, Any]) -> None:
        self.tree = tree
        self.written = Written()
        self.meanings = Meanings(scope, self.written, given)

    def of(self, path: Path) -> Origin | None:
        """Return where in the files the value at a path of the tree was written; None for a default."""
        nodes = list(_nodes(self.tree, path))
        if len(nodes) != len(path):
            return None
        holder, span = nodes[-1]
        place = locate(self.tree, path)
        stack = self.stack(place)
        piece = self.written.value(span)
        if isinstance(piece and piece.value, (Map, Seq)) and not isinstance(holder[path[-1]], (Map, Seq)):
            return self._put_together(span, place, stack)
        expressions = [self.where(s) for _, s in nodes[:-1] if s != span and is_expression(self.written.value(s))]
        made = maker(self.tree, path)
        return Origin(self.where(span), self.meanings.of(piece, made, place.via), tuple(expressions), stack)

    def where(self, span: Span) -> Where:
        """Return a place with what is written there."""
        return Where(span.source.path, span.line, span.column, self.written.text(span))

    def at(self, path: Path) -> tuple[Where, tuple[Step, ...]]:
        """Return where the entry at a path begins, and what it came through."""
        place = locate(self.tree, path, key=True)
        return self.where(place.span), self.stack(locate(self.tree, path))

    def stack(self, place: Place) -> tuple[Step, ...]:
        """Return the includes, parts and loops that lead to a place, innermost first."""
        return tuple(
            Step(found.message + self._attached(found.span), self.where(found.span))
            for found in place.stack()
            if found.span
        )

    def _attached(self, span: Span) -> str:
        """Return how the ``use`` at a place attaches its part, for one that does more than take it over."""
        use = self._use(span)
        said = [key for key in ("parent", *_POSE, "mirror") if use is not None and key in use]
        if use is None or not said:
            return ""
        return "".join(f", {key}: {self.written.text(use.value_spans[key])}" for key in said)

    def _use(self, span: Span) -> Map | None:
        """Return the entry of a ``use`` whose key stands at a place."""
        piece = self.written.entry(span)
        if piece is None or len(piece.path) < 2 or piece.path[-2] != "use" or not isinstance(piece.value, Map):
            return None
        return piece.value

    def _put_together(self, span: Span, place: Place, stack: tuple[Step, ...]) -> Origin:
        """Return the origin of a pose that was calculated: that of the entry in its part, then those of its mounts."""
        parts = list(self._pose(self.written.value(span), place.via, place.via))
        via: Instance | None = place.via
        while via is not None:
            use = self._use(via.span)
            if use is not None:
                piece = self.written.entry(via.span)
                parts += self._pose(piece, via.parent, via.parent)
                if use.get("parent") != MOUNT:
                    break
            via = via.parent
        where = Where(span.source.path, span.line, span.column, "")
        return Origin(where, stack=stack, parts=tuple(parts))

    def _pose(self, entry: Piece | None, holder: Instance | None, via: Instance | None) -> Iterator[Origin]:
        """Yield the origins of the xyz and rpy that an entry of a file has."""
        if entry is None or not isinstance(entry.value, Map):
            return
        for key in _POSE:
            if key in entry.value:
                where = self.where(entry.value.value_spans[key])
                inner = self.written.value(entry.value.value_spans[key])
                yield Origin(where._replace(text=f"{key}: {where.text}"), self.meanings.of(inner, holder, via))


def _nodes(tree: Map, path: Path) -> Iterator[tuple[Any, Span]]:
    """Yield for each step of a path what holds the value and where the value was written, as far as it goes."""
    node: Any = tree
    for step in path:
        if isinstance(node, Map) and step in node:
            span = node.value_spans[str(step)]
        elif isinstance(node, Seq) and isinstance(step, int) and step < len(node):
            span = node.value_spans[step]
        else:
            return
        yield node, span
        node = node[step]


MAX_LEVELS = 6
MAX_NAMES = 40
_OF_USE = ("name", "frame")  # what every part and type of sensor knows of its use


def is_expression(piece: Piece | None) -> bool:
    """Say whether a value is written as text with an expression in it."""
    return piece is not None and isinstance(piece.value, str) and "${" in piece.value


class Meanings:
    """Looks names up in the scopes of one expansion."""

    def __init__(self, root: Scope, written: Written, given: dict[str, Any]) -> None:
        self.root = root
        self.scopes: dict[int, Scope] = root.expansion.scopes
        self.written = written
        self.given = given

    def of(self, piece: Piece | None, holder: Instance | None, via: Instance | None) -> tuple[Meaning, ...]:
        """Return what the names in a value of a file stand for.

        ``holder`` tells how what holds the value came to be, ``via`` how the value itself came here.
        """
        if piece is None:
            return ()
        scope = self._scope(holder, via, piece.span)
        return tuple(self._names(piece.value, scope, 0))

    def named(self, name: str) -> Meaning | None:
        """Return what an argument or a named value of the description stands for; None if there is none."""
        place = self.root.places.get(name)
        return None if place is None else self._meaning(name, place, self.root, self.root, 0)

    def _scope(self, holder: Instance | None, via: Instance | None, span: Span) -> Scope:
        """Return the scope in which a value was evaluated."""
        found = self._registered(holder)
        if found is not None:
            return found
        home = self._registered(via)
        while home is not None and home.parent is not None:
            home = home.parent
        # A named value of a file of parts is evaluated among those of that file.
        if home is not None and any(place.span.source.path == span.source.path for place in home.places.values()):
            return home
        return self.root

    def _registered(self, via: Instance | None) -> Scope | None:
        while via is not None and id(via) not in self.scopes:
            via = via.parent
        return None if via is None else self.scopes[id(via)]

    def _names(self, value: Any, scope: Scope, level: int) -> Iterator[Meaning]:
        """Yield what the names in a text, or in the texts of a list or mapping, stand for; each once."""
        seen: set[str] = set()
        for text in _texts(value):
            for name, place, owner in self._used(text, scope):
                if name not in seen and len(seen) < MAX_NAMES:
                    seen.add(name)
                    yield self._meaning(name, place, owner, scope, level)

    def _used(self, text: str, scope: Scope) -> Iterator[tuple[str, Place, Scope]]:
        """Yield the names in a text, as far into a table as they lead, with place and scope of what gave the value."""
        for node, name in names_used(text):
            owner = _owner(name, scope)
            if owner is not None:
                entry = self._entry(node, scope)
                yield (ast.unparse(node), entry, owner) if entry else (name, owner.places[name], owner)

    def _entry(self, node: ast.expr, scope: Scope) -> Place | None:
        """Return where the entry of a table that ``table.key`` or ``table[key]`` reaches was written."""
        if not isinstance(node, (ast.Attribute, ast.Subscript)):
            return None
        table = _value(node.value, scope)
        key = node.attr if isinstance(node, ast.Attribute) else _value(node.slice, scope)
        if isinstance(table, Map) and key in table:
            return Place(table.value_spans[key], table.via)
        if isinstance(table, Seq) and isinstance(key, int) and -len(table) <= key < len(table):
            return Place(table.value_spans[key], table.via)
        return None

    def _meaning(self, name: str, place: Place, owner: Scope, scope: Scope, level: int) -> Meaning:
        span = place.span
        piece = self.written.entry(span) or self.written.value(span)
        path = piece.path if piece is not None else ()
        value = _shown(_value(ast.parse(name, mode="eval").body, scope))
        if name in _OF_USE and owner.via is not None and not {"params", "let", "for", "with"} & set(path):
            return Meaning(name, value, f"{name} of what uses it", self._where(owner.via.span))
        if path[:1] == ("args",) and len(path) == 2 and name in self.given:
            return Meaning(name, value, "argument, set on the command line", None)
        given_by, inside = self._given_by(name, path, owner)
        known = piece is not None and level < MAX_LEVELS
        names = tuple(self._names(piece.value, inside, level + 1)) if known and piece is not None else ()
        return Meaning(name, value, given_by, self._where(span), names)

    def _where(self, span: Span) -> Where:
        return Where(span.source.path, span.line, span.column, self.written.text(span))

    def _given_by(self, name: str, path: tuple[str | int, ...], owner: Scope) -> tuple[str, Scope]:
        """Return what gave a name its value, in words, and the scope of the expression that did."""
        if name in owner.looped:
            return "loop", owner.parent or self.root
        if path[:1] == ("args",):
            return "argument, its default", owner
        if path[:1] == ("include",) and "for" not in path:
            return "argument, set by the include", owner
        if len(path) == 1 and name in self.given:
            return "argument, set by the file", owner
        if "with" in path:
            return "given where it is used", self._outside(owner)
        if "params" in path:
            return "default of the part", owner
        return "named value" if "let" in path else "table", owner

    def _outside(self, owner: Scope) -> Scope:
        """Return the scope in which a part was used."""
        return self._registered(owner.via.parent if owner.via else None) or self.root


def _owner(name: str, scope: Scope | None) -> Scope | None:
    while scope is not None and name not in scope.places:
        scope = scope.parent
    return scope


def _texts(value: Any) -> Iterator[str]:
    """Yield the texts with an expression in a value of a file."""
    if isinstance(value, str) and "${" in value:
        yield value
    elif isinstance(value, Map):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, Seq):
        for item in value:
            yield from _texts(item)


def names_used(text: str) -> Iterator[tuple[ast.expr, str]]:
    """Yield the names in the expressions of a text, each with the keys that follow it: body, body.length, rows[0].

    The second value is the name alone. Names that a list comprehension gives are left out.
    """
    for piece in pieces(text):
        if piece.is_expression:
            with suppress(ExpressionError, SyntaxError, ValueError):
                tree = parsed(piece.text).body
                loops = [node.target for node in ast.walk(tree) if isinstance(node, ast.comprehension)]
                own = {node.id for target in loops for node in ast.walk(target) if isinstance(node, ast.Name)}
                yield from ((node, name) for node, name in _chains(tree) if name not in own)


def _chains(node: ast.AST) -> Iterator[tuple[ast.expr, str]]:
    base: ast.AST = node
    inner: list[ast.AST] = []
    while isinstance(base, (ast.Attribute, ast.Subscript)):
        inner += [base.slice] if isinstance(base, ast.Subscript) else []
        base = base.value
    if isinstance(base, ast.Name) and isinstance(node, ast.expr):
        yield node, base.id
    else:
        inner = list(node.args) if isinstance(node, ast.Call) else list(ast.iter_child_nodes(node))
    for child in inner:
        yield from _chains(child)


def _value(node: ast.expr, scope: Scope) -> Any:
    """Return the value of a piece of an expression that had one; None if it cannot be had."""
    try:
        return evaluate(ast.unparse(node), scope.lookup)
    except (ExpressionError, Failed, KeyError, ValueError):
        return None


def _shown(value: Any) -> str:
    """Return a value in a few letters, a quantity with its SI unit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Quantity):
        words = describe(value.dimension)  # "a length (m)", or "a quantity in kg*m"
        unit = words[words.rindex("(") + 1 : -1] if words.endswith(")") else words.rpartition(" in ")[2]
        return f"{exact(value)} {unit}" if value.dimension != NUMBER else exact(value)
    if isinstance(value, float):
        return exact(value)
    if isinstance(value, dict):
        return f"a table of {len(value)}"
    if isinstance(value, list):
        numbers = all(isinstance(item, (int, float)) and not isinstance(item, bool) for item in value)
        return f"[{', '.join(map(exact, value))}]" if numbers and len(value) < 7 else f"a list of {len(value)}"
    return "" if value is None else str(value)[:60]

"""Origins: where a value of the plain tree was written, and what the names in its expression stand for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..diagnostic import Span
from ..expand.placing import MOUNT
from ..expand.scope import Scope
from ..tree import Instance, Map, Path, Place, Seq, locate
from ..written import Piece, Written
from .meanings import Meanings, is_expression
from .values import Origin, Step, Where

_POSE = ("xyz", "rpy")


class Origins:
    """Answers for one tree; ``scope`` is that of the description, ``given`` its arguments from the command line."""

    def __init__(self, tree: Map, scope: Scope, given: dict[str, Any]) -> None:
        self.tree = tree
        self.written = Written()
        self.meanings = Meanings(scope, self.written, given)

    def of(self, path: Path) -> Origin | None:
        """Return where the value at a path of the tree was written; None if it was not."""
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
        return Origin(self.where(span), self.meanings.of(piece, holder.via, place.via), tuple(expressions), stack)

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

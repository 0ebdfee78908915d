"""Provenance: find where the value that caused an error was written.

If a part has ``mass: ${m}``, the number was written under ``with`` or ``let``. So an error in an argument, or in a
value calculated from it, is reported at the argument. If the error is about the kind of value (unit or type),
and the argument has the declared kind, it is reported in the part. This module runs only if there are errors.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from types import NoneType
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, Span, error
from rosorin_compile.source.tree import Instance, Map, Path, Place, Seq, exists, has, maker, value_at, written_place

from ..expression import names_in, pieces
from ..symbols import MOUNT

if TYPE_CHECKING:
    from .scope import Scope

# An expression that is only a name, or an entry of a table or list: ${m}, ${wheel.mass}, ${sizes[0]}.
_LONE_NAME = r"([^\W\d]\w*)((?:\.[^\W\d]\w*|\[\d+\])*)\Z"
_STEP = r"\.([^\W\d]\w*)|\[(\d+)\]"
_MOUNT = f"={MOUNT}"  # pseudo name of the frame that a part is attached to
_OF_USE = ("name", "mirrored", "prefix")  # names that are defined in every part, but not by an argument
MAX_STEPS = 20  # maximum length of a chain of names such as a: ${b}, b: ${c}
MAX_DEPTH = 100  # maximum depth of nested expressions

USED = "used here"
# Rules about the type or unit of a value, not its magnitude.
OF_KINDS = ("wrong-unit", "wrong-type")
# Rules about names. If the name is a key with an expression, an argument may cause the error.
_OF_NAMES = ("bad-name", "unknown-link", "unknown-joint", "unknown-name", "unknown-frame-id", "unknown-servo")


class Origin(NamedTuple):
    """The position of the argument or named value that determines a value, which also depends on ``others``."""

    span: Span
    others: tuple[Span, ...] = ()

    def related_places(self, used: Span) -> tuple[Related, ...]:
        """Return related positions for a message: where the value is used, and the other arguments."""
        return (Related(USED, used), *(Related("the value also depends on this", span) for span in self.others))


def argument_of(scope: Scope, names: Iterable[str], of_kinds: bool = False) -> Origin | None:
    """Return the positions of the arguments on which ``names`` depend in a scope, or None if they depend on none.

    With ``of_kinds``, ignore arguments that have the declared type and unit: they cannot cause a type or unit error.
    """
    with suppress(RecursionError):  # a very long chain of names: the error is reported where it occurs
        return _first(_Search(scope.expansion.root, of_kinds).arguments(scope, names))
    return None


def argument_at(scope: Scope, span: Span, of_kinds: bool = False) -> Origin | None:
    """Return the arguments on which the expression at ``span`` depends, or None (see ``argument_of``)."""
    return argument_of(scope, _names_at(span), of_kinds)


def argument_behind(root: Scope, place: Place) -> Origin | None:
    """Return the arguments on which the value or key at a place depends, or None (see ``argument_of``)."""
    return argument_at(scope_of(root, place.via), place.span)


def mistake_place(
    root: Scope | None, tree: Map, path: Path, rule: str, key: bool = False, within: bool = False
) -> tuple[Place, tuple[Related, ...]]:
    """Return the place where an error in the value at ``path`` should be reported, and related positions.

    If an argument causes the error, this is the place of the argument; to find it, pass ``root``, the scope of the
    description. ``key`` and ``within`` are as in ``written_place``.
    """
    place, use = written_place(tree, path, key, within)
    origin = None
    if root is not None and key and rule in _OF_NAMES:
        origin = argument_behind(root, place)
    elif root is not None and not key and not within and not isinstance(value_at(tree, path), (Map, Seq, NoneType)):
        scope = scope_of(root, maker(tree, path) if len(path) > 1 else place.via)
        origin = _Search(root, rule in OF_KINDS).origin(scope, place.span)
    if origin is None:
        return place, (Related(USED, use),) if use else ()
    return Place(origin.span, place.via), origin.related_places(use or place.span)


def problem_at(
    root: Scope | None,
    tree: Map,
    path: Sequence[str | int],
    rule: str,
    message: str,
    help: Help = "",
    related: Iterable[Related] = (),
    key: bool = False,
) -> Diagnostic:
    """Return an error for the value (with ``key``, for the key) at a path, or for the nearest ancestor that exists."""
    path = tuple(path)
    if exists(tree, path) and (rule in _OF_NAMES or not key):
        place, uses = mistake_place(root, tree, path, rule, key)
    else:
        place, uses = tree.locate(path, key=key), ()
    return error(rule, message, place.span, help, (*related, *uses, *place.stack()))


def scope_of(root: Scope, via: Instance | None) -> Scope:
    """Return the scope of the innermost part or loop that created a value (``via``), or ``root`` if there is none."""
    scopes: dict[int, Scope] = root.expansion.scopes
    while via is not None and id(via) not in scopes:
        via = via.parent
    return root if via is None else scopes[id(via)]


class _Definition(NamedTuple):
    """The definition of a name; ``keeps_kind`` is True if the value has the declared type and unit."""

    span: Span
    scope: Scope
    value: Any
    argument: bool
    keeps_kind: bool


class _Search:
    def __init__(self, root: Scope, of_kinds: bool) -> None:
        self.root, self.of_kinds, self.visited = root, of_kinds, set[Span]()

    def origin(self, scope: Scope, span: Span) -> Origin | None:
        place, inside = self.follow_names(scope, span, MAX_STEPS)
        outside = _first(self.arguments(inside, _names_at(place)))
        return outside or (None if place == span else Origin(place))

    def follow_names(self, scope: Scope, span: Span, steps: int) -> tuple[Span, Scope]:
        text = _text_at(span)
        found = pieces(text) if steps else ()
        match = re.match(_LONE_NAME, found[0].text.strip()) if len(found) == 1 and found[0].is_whole else None
        name, keys = (match[1], match[2]) if match else (_MOUNT if steps and text == MOUNT else "", "")
        definition = self.definition(scope, name, keys) if name else None
        # Do not follow names into a part of the library or of a package, because users cannot edit its defaults.
        if definition is None or self.is_foreign(definition.scope) or (self.of_kinds and definition.keeps_kind):
            return span, scope
        return self.follow_names(definition.scope, definition.span, steps - 1)

    def arguments(self, scope: Scope, names: Iterable[str], depth: int = 0) -> Iterator[tuple[Span, Any]]:
        for name in names if depth < MAX_DEPTH else ():
            found = self.definition(scope, name)
            if found is None or (self.of_kinds and found.argument and found.keeps_kind) or found.span in self.visited:
                continue
            self.visited.add(found.span)
            outer = list(self.arguments(found.scope, _names_at(found.span), depth + 1))
            if not outer and found.argument and not self.is_foreign(found.scope):
                outer = [(self.follow_names(found.scope, found.span, MAX_STEPS)[0], found.value)]
            yield from outer

    def definition(self, scope: Scope, name: str, keys: str = "") -> _Definition | None:
        if name == _MOUNT:
            users = ((user.mount, user) for user in scope.ancestors() if user.mount is not None)
            return next((_Definition(mount.span, self.outside(user), None, True, False) for mount, user in users), None)
        owner = scope.owner(name)
        local = owner.local.get(name) if owner else None
        if owner is None or (name in _OF_USE and name not in owner.declared and local is None):
            return None
        place = local or owner.places[name]
        value: Any = owner.values.get(name)
        argument = local is None and name in owner.declared
        keeps_kind = owner.declared[name].accepts(value) if argument else not is_like_a_number(value)
        for key, index in re.findall(_STEP, keys):
            step: Any = key or int(index)
            if not has(value, step):
                return None
            place = Place(value.value_spans[step], value.via)
            value = value[step]
        return _Definition(place.span, owner if local else self.outside(owner), value, argument, keeps_kind)

    def outside(self, scope: Scope) -> Scope:
        return scope_of(self.root, scope.via.parent) if scope.via else self.root

    def is_foreign(self, scope: Scope) -> bool:
        return self.root not in scope.ancestors()


def _first(arguments: Iterable[tuple[Span, Any]]) -> Origin | None:
    values = dict(arguments)
    spans = sorted(values, key=lambda span: isinstance(values[span], (int, float)) and values[span] > 0)
    return Origin(spans[0], tuple(spans[1:])) if spans else None


def is_like_a_number(value: Any) -> bool:
    """Return True for a string that begins like a number, such as "15 rda/s"."""
    return isinstance(value, str) and bool(re.match(r"[-+~]?\.?\d", value))


def _text_at(span: Span) -> str:
    return span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length].strip("\"'")


def _names_at(span: Span) -> list[str]:
    text = _text_at(span)
    if text == MOUNT:
        return [_MOUNT]
    found = pieces(text) if not text.startswith(("{", "[")) else ()
    return [name for piece in found if piece.is_expression and not piece.unclosed for name in names_in(piece.text)]

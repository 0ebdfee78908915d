"""Tracing: from a value in the evaluated tree back to what a person wrote.

``mass: ${m}`` in a part stands where the part does, and nobody looks there: who wrote the number wrote it behind
``with``, or under ``let``. A mistake in what a part was given, or in what it makes of that, is told where it was given;
only where an argument is of the kind that its parameter asks for, a mistake of kinds is the part's own. Nothing is kept
for this while a description is expanded; it is looked up once there is something to say.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from types import NoneType
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, Span, error
from rosorin_compile.source.tree import Instance, Map, Path, Place, Seq, at, exists, has, locate, maker, written

from ..expression import names_in, pieces
from ..symbols import MOUNT

if TYPE_CHECKING:
    from .scope import Scope

# A name alone, or an entry of a table or a list: ${m}, ${wheel.mass}, ${sizes[0]}.
_ONE = re.compile(r"([^\W\d]\w*)((?:\.[^\W\d]\w*|\[\d+\])*)\Z")
_STEP = re.compile(r"\.([^\W\d]\w*)|\[(\d+)\]")
_MOUNT = f"={MOUNT}"  # the frame that a part is attached to, among names
_OF_USE = ("name", "mirrored", "prefix")  # what each part knows of its use: nobody gave it
MAX_STEPS = 20  # of names that stand alone
MAX_DEPTH = 100  # of expressions in one another

USED = "used here"
# Rules that speak of the kind of a value, whatever the value.
OF_KINDS = ("wrong-unit", "wrong-type")
# Rules that speak of a name: where it is a key, too, somebody may have given it.
_OF_NAMES = ("bad-name", "unknown-link", "unknown-joint", "unknown-name", "unknown-frame-id", "unknown-servo")


class Traced(NamedTuple):
    """Where a value was written: its place, and those of the other values that it was worked out of."""

    span: Span
    others: tuple[Span, ...] = ()

    def related(self, used: Span) -> tuple[Related, ...]:
        """Return the second places: that of the value that was looked at, and the others."""
        return (Related(USED, used), *(Related("it depends on this, too", span) for span in self.others))


def traced(root: Scope, span: Span, via: Instance | None, of_kinds: bool = False) -> Traced | None:
    """Return where the value at a place was written; None if it was written there.

    ``via`` tells how what holds the value came to be. With ``of_kinds`` the mistake is one of kinds.
    """
    return _Trace(root, of_kinds).traced(_scope(root, via), span)


def given(scope: Scope, names: Iterable[str], of_kinds: bool = False) -> Traced | None:
    """Return the arguments that an expression of some names depends on, seen from a scope; None if there are none.

    None, too, at the end of a chain of names so long that Python's stack has no room left: the mistake is told at its
    own place then. An error here would be one of each name up the chain, and every one would evaluate the rest anew.
    """
    try:
        return _one_of(_Trace(scope.ledger.root, of_kinds).arguments(scope, names))
    except RecursionError:
        return None


def given_at(scope: Scope, span: Span, of_kinds: bool = False) -> Traced | None:
    """Return the arguments that the value at a place depends on, seen from a scope; None if there are none."""
    return given(scope, _names_at(span), of_kinds)


def given_by(root: Scope, place: Place) -> Traced | None:
    """Return the arguments that the value or the key at a place depends on; None if there are none."""
    return given_at(_scope(root, place.via), place.span)


def mistake_place(
    root: Scope | None, tree: Map, path: Path, rule: str, key: bool = False, within: bool = False
) -> tuple[Place, tuple[Related, ...]]:
    """Return the place at which a mistake at a path is told, and the second places: where the value is used.

    ``root`` is the scope of the description, None if nobody knows it; ``key`` and ``within`` as ``written`` has them.
    """
    place, use = written(tree, path, key, within)
    related = [Related(USED, use)] if use else []
    if root is not None and key and rule in _OF_NAMES:
        trace = given_by(root, place)
    elif root is None or key or within or isinstance(at(tree, path), (Map, Seq, NoneType)):
        trace = None
    else:
        via = maker(tree, path) if len(path) > 1 else place.via
        trace = traced(root, place.span, via, rule in OF_KINDS)
    if trace is None:
        return place, tuple(related)
    return Place(trace.span, place.via), trace.related(use or place.span)


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
    """Return an error at a path of the tree, or of its longest prefix that exists; ``root`` as in ``told``.

    With ``key`` it is told at the last key.
    """
    path = tuple(path)
    if exists(tree, path) and (rule in _OF_NAMES or not key):
        place, uses = mistake_place(root, tree, path, rule, key)
    else:
        place, uses = locate(tree, path, key=key), ()
    return error(rule, message, place.span, help, (*related, *uses, *place.stack()))


class _Further(NamedTuple):
    """Where the value of a name was written, and the scope that its own expression was evaluated in.

    ``argument`` says whether it was given from outside, and ``stays`` whether a mistake of kinds is none of it, but of
    what uses it: the value is of the kind that was asked for, or nobody asked for any.
    """

    span: Span
    inside: Scope
    value: Any
    argument: bool
    stays: bool


class _Trace:
    """Follows values of one expansion, for one mistake."""

    def __init__(self, root: Scope, of_kinds: bool) -> None:
        self.root = root
        self.of_kinds = of_kinds
        self.seen: set[Span] = set()

    def traced(self, scope: Scope, span: Span) -> Traced | None:
        """Return where the value at a place was written that a scope evaluated; None if it was written there."""
        found, inside = self.written(scope, span, MAX_STEPS)
        outside = _one_of(self.arguments(inside, _names_at(found)))
        return outside or (None if found == span else Traced(found))

    def written(self, scope: Scope, span: Span, steps: int) -> tuple[Span, Scope]:
        """Follow names that stand alone, to the last place that a person may have written a value at."""
        name, keys = _alone(span) if steps else ("", "")
        further = self.behind(scope, name, keys) if name else None
        # A default of a part of another file is no value of the description.
        if further is None or self.is_foreign(further.inside) or (self.of_kinds and further.stays):
            return span, scope
        return self.written(further.inside, further.span, steps - 1)

    def arguments(self, scope: Scope, names: Iterable[str], depth: int = 0) -> Iterator[tuple[Span, Any]]:
        """Yield the places of the arguments that some names depend on, and their values, the outermost ones."""
        for name in names if depth < MAX_DEPTH else ():
            further = self.behind(scope, name)
            if further is None or (self.of_kinds and further.argument and further.stays) or further.span in self.seen:
                continue
            self.seen.add(further.span)
            deeper = list(self.arguments(further.inside, _names_at(further.span), depth + 1))
            if not deeper and further.argument and not self.is_foreign(further.inside):
                deeper = [(self.written(further.inside, further.span, MAX_STEPS)[0], further.value)]
            yield from deeper

    def behind(self, scope: Scope, name: str, keys: str = "") -> _Further | None:
        """Return where the value of a name comes from; None for what nobody wrote."""
        owner: Scope | None = scope
        while owner is not None and name not in owner.places and (name != _MOUNT or owner.mount is None):
            owner = owner.parent
        if owner is not None and owner.mount is not None and name == _MOUNT:
            return _Further(owner.mount.span, self.around(owner), None, True, False)
        if owner is None or (name in _OF_USE and name not in owner.declared and name not in owner.said):
            return None
        said = owner.said.get(name)
        place = said or owner.places[name]
        value: Any = owner.values.get(name)
        argument = said is None and name in owner.declared
        stays = owner.declared[name].fits(value) if argument else not is_like_a_number(value)
        for key, index in _STEP.findall(keys):
            step: Any = key or int(index)
            if not has(value, step):
                return None
            place = Place(value.value_spans[step], value.via)
            value = value[step]
        return _Further(place.span, owner if said else self.around(owner), value, argument, stays)

    def around(self, scope: Scope) -> Scope:
        """Return the scope in which the arguments of a part were evaluated, or what a loop runs over."""
        return _scope(self.root, scope.via.parent) if scope.via else self.root

    def is_foreign(self, scope: Scope) -> bool:
        """Say whether a scope belongs to a file of parts, of the library or of another package."""
        while scope.parent is not None:
            scope = scope.parent
        return scope is not self.root


def _scope(root: Scope, via: Instance | None) -> Scope:
    """Return the scope in which a value was evaluated that came by ``via``."""
    scopes: dict[int, Scope] = root.ledger.scopes
    while via is not None and id(via) not in scopes:
        via = via.parent
    return root if via is None else scopes[id(via)]


def _one_of(arguments: Iterable[tuple[Span, Any]]) -> Traced | None:
    """Return one of several arguments, with the others: the first that is not above zero, else the first."""
    found = dict(arguments)
    spans = sorted(found, key=lambda span: isinstance(found[span], (int, float)) and found[span] > 0)
    return Traced(spans[0], tuple(spans[1:])) if spans else None


def is_like_a_number(value: Any) -> bool:
    """Say whether a value is a text that begins like a number: 15 rda/s."""
    return isinstance(value, str) and bool(re.match(r"[-+~]?\.?\d", value))


def text_at(span: Span) -> str:
    """Return the scalar that is written at a place; what runs over several lines is cut."""
    return span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length].strip("\"'")


def _alone(span: Span) -> tuple[str, str]:
    """Return the name that is all that is written at a place, and the keys behind it; else nothing."""
    text = text_at(span)
    found = pieces(text)
    match = _ONE.match(found[0].text.strip()) if len(found) == 1 and found[0].is_whole else None
    return (match[1], match[2]) if match else (_MOUNT if text == MOUNT else "", "")


def _names_at(span: Span) -> list[str]:
    """Return the names in the expressions of the scalar that is written at a place."""
    text = text_at(span)
    if text == MOUNT:
        return [_MOUNT]
    found = pieces(text) if not text.startswith(("{", "[")) else ()
    return [name for piece in found if piece.is_expression and not piece.unclosed for name in names_in(piece.text)]

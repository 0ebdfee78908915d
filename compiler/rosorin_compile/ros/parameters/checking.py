"""The parameters of one node held against what is known of its kind: keys, types, what validators refuse.

The same is asked of what a description says and of a file that people have: ``Finding`` names the key, who asks knows
where that was written.
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Iterator, Mapping
from types import NoneType
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import (
    ERROR,
    WARNING,
    Diagnostic,
    Help,
    Related,
    Span,
    Suggestion,
    diagnostic,
    phrase,
)
from rosorin_compile.source.wording import suggest

from .tables import Key, Kind, as_type, as_yaml, fits, is_of_all_nodes, type_in_words, why_refused

REMOVE = "remove it"
_SIMILAR = 0.9


class Finding(NamedTuple):
    """Something wrong with a parameter; ``key`` is empty for the node as a whole, ``at_key``: the name of it.

    ``unknown`` is a name that does not exist, ``known`` are those that do.
    """

    rule: str
    message: str
    key: str = ""
    help: Help = ""
    severity: str = ERROR
    at_key: bool = False
    unknown: str = ""
    known: Collection[str] = ()

    def place(self, span: Span | None, related: Iterable[Related] = ()) -> Diagnostic:
        """Return it with its place."""
        return diagnostic(self.rule, self.severity, self.message, span, self.help, related)


def against_kind(name: str, kind: Kind, values: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield what is wrong with the parameters of a node of a kind; ``name`` says which one it is.

    ``values`` are those that were said, by full key.
    """
    for key, value in values.items():
        known = kind.key(key)
        if known is None:
            yield from _unknown(name, kind, key, values)
        elif not kind.has(known):
            others = phrase(map(str.capitalize, known.only))
            message = f'{name} of {kind.distribution.capitalize()} has no key "{key}"; it is one of {others}'
            help = _near(kind, key, values) or REMOVE
            yield Finding("parameters-unknown-key", message, key, help, at_key=True)
        else:
            yield from _value(name, key, value, known)
            yield from _unlisted(name, kind, key, values)


def unwritable(name: str, values: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield values that no parameter of any node can be, for one of which nothing is known."""
    for key, value in values.items():
        kinds = {type(one) for one in value} if isinstance(value, (list, tuple)) else {type(value)}
        if len(kinds) > 1 or kinds & {list, tuple, NoneType}:
            message = f'"{key}" of {name} is {as_yaml(value)}: no parameter can be that'
            yield Finding("parameters-wrong-type", message, key, "write a value, or a list of values of one type")


def _unknown(name: str, kind: Kind, key: str, values: Mapping[str, Any]) -> Iterator[Finding]:
    if is_of_all_nodes(key):
        return
    near = _near(kind, key, values)
    if kind.complete:
        message = f'{name} has no key "{key}": it is accepted in silence, and does nothing'
        yield Finding("parameters-unknown-key", message, key, near, at_key=True)
    elif near:
        message = f'"{key}" of {name} is nearly a key that it has'
        yield Finding("parameters-unknown-key", message, key, near, WARNING, at_key=True)


def _near(kind: Kind, key: str, values: Mapping[str, Any]) -> Help:
    names = kind.like(key)
    if not kind.complete:
        close = difflib.get_close_matches(key, names - values.keys(), n=1, cutoff=_SIMILAR)
        return suggest(close[0]) if close else ""
    return Suggestion(key, names, instead=REMOVE)


def _unlisted(name: str, kind: Kind, key: str, values: Mapping[str, Any]) -> Iterator[Finding]:
    many, one = kind.list_of_key(key)
    given = values.get(many)
    if isinstance(given, (list, tuple)) and one not in given:
        message = f'"{key}" of {name} is about "{one}", which is not in its {many}: it has no effect'
        yield Finding("parameters-unknown-key", message, key, Suggestion(one, set(map(str, given))), at_key=True)


def _value(name: str, key: str, value: Any, known: Key) -> Iterator[Finding]:
    if not fits(value, known.type):
        message = f'"{key}" of {name} is {as_yaml(value)}, and has to be {type_in_words(known.type)}'
        yield Finding("parameters-wrong-type", f"{message}: the node does not start", key, as_type(value, known.type))
    elif isinstance(value, str) and value in known.renamed:
        message = f'"{key}" of {name} is "{value}", which was renamed: the node does not start'
        yield Finding("parameters-wrong-value", message, key, f"write {known.renamed[value]}")
    elif known.forced and value not in ("", known.forced):
        message = f'"{key}" of {name} is always "{known.forced}": this value has no effect'
        yield Finding("parameters-wrong-value", message, key, "remove it", WARNING)
    elif (why := why_refused(known.valid, value)) is not None:
        message, help = f'"{key}" of {name} {why[0]}', why[1] or "correct it"
        yield Finding("parameters-wrong-value", message, key, help)

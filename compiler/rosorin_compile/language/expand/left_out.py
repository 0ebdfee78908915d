"""Left out: what an ``if`` or a loop without rounds has left out is told as that, once, where its names are missed.

Nothing is evaluated for this: what is left out may be wrong in itself. The names that it would have brought are known
as they are written, with anything in place of an expression.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Related, Span
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.wording import and_more

from ..expression import pieces
from ..symbols import SymbolTable
from .ledger import Failed, LeftOut
from .parts import prefix_of
from .scope import Scope

_QUOTED = re.compile(r'"([^"]+)"')
_ANY = ".+"  # what an expression may give
MAX_NESTED = 5  # parts in parts
MAX_ROUNDS = 100
MAX_SHOWN = 6


class _Gone:
    """One thing that is left out, the form of the names that it would have brought, and what all of them begin with."""

    def __init__(self, left: LeftOut, as_written: bool) -> None:
        self.left = left
        scope, item = left.scope, left.item
        self.name = left.key if as_written else _evaluated(left.key, left)
        own = _form(self.name)
        self.begin, forms = scope.prefix, [own] if own else []
        if left.is_use:
            prefix = prefix_of(self.name, item)
            prefix = prefix if as_written else _evaluated(prefix, left)
            self.begin += prefix if "$" not in prefix else ""
            forms = [_form(prefix) + form for form in _of_part(scope.ledger.find, item.get("part"), MAX_NESTED)]
        else:
            forms += [_form(text) for text in _frames(item)]
        form = "|".join(dict.fromkeys(filter(_says_something, forms)))
        # Within its own part it is called without the prefix.
        self.form = re.compile(f"(?:{re.escape(scope.prefix)})?(?:{form or '(?!)'})")

    def would_bring(self, name: str, there: Collection[str]) -> bool:
        """Say whether a name is missing because of this: it would have it, or nothing else begins so."""
        if self.form.fullmatch(name):
            return True
        begin = self.begin if self.left.is_use else ""
        return bool(begin) and name.startswith(begin) and not any(one.startswith(begin) for one in there)

    def span(self) -> Span:
        """Return the place of the condition, or of the loop."""
        spans: dict[str, Span] = self.left.item.value_spans
        return spans["for" if self.left.is_empty else "if"]

    def message(self) -> str:
        """Return what is left out, where, and why."""
        span, why = self.span(), "its loop has no rounds"
        if not self.left.is_empty:
            why = f"{_condition(self.left.item['if'])} is false"
        what = f'"{self.name}"' if self.name else "an item of a list"
        return f"{what} is left out at {span.source.path}:{span.line} ({why})"


def told_by_cause(scope: Scope, tree: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics; those that miss names of what is left out are one, which says so."""
    there = _names(tree)
    said = (name for one in diagnostics if one.severity != NOTE for name in _QUOTED.findall(one.message))
    if all(name in there for name in said):
        return diagnostics
    gone = _different(_looked_at(scope.ledger.left_out))
    causes: dict[tuple[int, str], list[Diagnostic]] = {}
    known: dict[str, _Gone | None] = {}
    others = []
    for one in diagnostics:
        cause = None if one.severity == NOTE else _cause(one, gone, there, known)
        if cause is None:
            others.append(one)
        else:
            causes.setdefault((gone.index(cause), one.severity), []).append(one)
    return [*others, *(_together(gone[number], arrange(group)) for (number, _), group in causes.items())]


def _looked_at(every: Iterable[LeftOut]) -> Iterator[_Gone]:
    """Yield what is left out; of very many rounds of a loop the first ones, and the others as they are written."""
    rounds: Counter[int] = Counter()
    for left in every:
        rounds[id(left.item)] += 1
        if rounds[id(left.item)] <= MAX_ROUNDS + 1:
            yield _Gone(left, left.is_empty or rounds[id(left.item)] > MAX_ROUNDS)


def _different(every: Iterable[_Gone]) -> list[_Gone]:
    """Return what is left out, each once: the rounds of a loop may leave out the same."""
    kept: dict[object, _Gone] = {}
    for one in every:
        kept.setdefault((id(one.left.item), one.form.pattern, one.begin), one)
    return list(kept.values())


def _cause(one: Diagnostic, gone: list[_Gone], there: Collection[str], known: dict[str, _Gone | None]) -> _Gone | None:
    """Return what is left out that would have brought a name in a message; ``known`` are answers by name."""
    for name in _QUOTED.findall(one.message):
        if name not in there:
            if name not in known:
                known[name] = next((left for left in gone if left.would_bring(name, there)), None)
            if known[name] is not None:
                return known[name]
    return None


def _together(cause: _Gone, group: list[Diagnostic]) -> Diagnostic:
    """Return the first diagnostic of what misses one thing, with the others."""
    first, *others = group
    condition = cause.left.item.get("if")
    help = "leave out on the same condition what names it"
    if not cause.left.is_empty and isinstance(condition, str):
        help = f'leave out on the same condition what names it, if: "{condition}"'
    related = [Related(f"also missed: {one.message}", one.span) for one in others[:MAX_SHOWN]]
    related += [Related(f"also missed:{and_more(len(others) - MAX_SHOWN)}", None)] if len(others) > MAX_SHOWN else []
    here = Related("left out here", cause.span())
    return replace(
        first, message=f"{first.message}: {cause.message()}", help=help, related=(here, *related, *first.related)
    )


def _condition(value: Any) -> str:
    """Return a condition as a person calls it."""
    if isinstance(value, bool):
        return "its if"
    whole = list(pieces(str(value)))
    return whole[0].text.strip() if len(whole) == 1 else str(value)


def _evaluated(text: str, left: LeftOut) -> str:
    """Return a text with its expressions evaluated; as it is where they cannot be, of which nothing is said."""
    if "$" not in text:
        return text
    told = left.scope.ledger.diagnostics
    before = len(told)
    with suppress(Failed):
        name: str = left.scope.name(text, left.item.span, left.scope.via)
        return name
    del told[before:]
    return text


def _form(text: str) -> str:
    """Return the form of a name: anything may stand for an expression. "" where nothing else is in it."""
    if "$" not in text:
        return re.escape(text)
    parts = list(pieces(text))
    return "".join(_ANY if one.is_expression else re.escape(one.text) for one in parts)


def _says_something(form: str) -> bool:
    """Say whether a form has a letter of its own: else it would be that of all names."""
    return any(letter.isalnum() for letter in form)


def _of_part(find: Any, name: Any, depth: int) -> Iterator[str]:
    """Yield the forms of the names of a part, without its prefix, those of the parts within too."""
    body = find(name) if isinstance(name, str) and find is not None else None
    if body is None or not depth:
        yield _ANY
        return
    sections = Map(body.span)
    for key, value in body.items():
        if isinstance(value, (Map, Seq)):
            sections.put(key, value, body.key_spans[key], body.value_spans[key])
    yield from map(_form, _names(sections))
    inner = body.get("use")
    for use, entry in inner.items() if isinstance(inner, Map) else ():
        if isinstance(entry, Map):
            begin = _form(prefix_of(use, entry))
            yield from (begin + form for form in _of_part(find, entry.get("part"), depth - 1))


def _names(sections: Map) -> set[str]:
    """Return all names that sections give, also those of entries with a loop or a condition."""
    given = SymbolTable(sections).names().of
    names = {name for kind, some in given.items() if kind != "robot" for name in some}
    for value in sections.values():
        names.update(value if isinstance(value, Map) else ())
        names.update(text for item in value for text in _frames(item)) if isinstance(value, Seq) else None
    return names


def _frames(item: Any) -> list[str]:
    """Return the frames that an entry brings: that of a sensor, that into which an edge leads."""
    if not isinstance(item, Map):
        return []
    optical = item.get("optical")
    inner = _frames(optical) if isinstance(optical, Map) else []
    child = [item["child"]] if "publisher" in item and "type" not in item and "child" in item else []
    found = [*(item[key] for key in ("frame", "joint") if key in item), *child, *inner]
    return [one for one in found if isinstance(one, str)]

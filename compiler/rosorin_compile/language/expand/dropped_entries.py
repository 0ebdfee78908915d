"""Dropped entries: names that an ``if`` or a loop without rounds has removed are reported as that, once.

Dropped entries are not evaluated: they may contain errors. The names that they would define are those as written, with
anything in place of an expression.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Related, Span
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.wording import and_more

from ..expression import pieces
from ..symbols import SymbolTable
from .expansion import Disabled, Failed
from .parts import prefix_of
from .scope import Scope

_QUOTED = re.compile(r'"([^"]+)"')
_ANY = ".+"  # what an expression may give
MAX_NESTED = 5  # parts in parts
MAX_ROUNDS = 100
MAX_SHOWN = 6


class _Dropped:
    """A dropped entry, a pattern of the names that it would define, and what all of these begin with."""

    def __init__(self, entry: Disabled, as_written: bool) -> None:
        self.entry = entry
        scope, item = entry.scope, entry.item
        self.name = entry.key if as_written else _evaluated(entry.key, entry)
        self.begin = ""
        if entry.is_use:
            prefix = prefix_of(self.name, item)
            prefix = prefix if as_written else _evaluated(prefix, entry)
            self.begin = scope.prefix + (prefix if "$" not in prefix else "")
            names = _names_of_part(scope.expansion.find_part, item.get("part"), MAX_NESTED)
            patterns = [_pattern(prefix) + name for name in names]
        else:
            patterns = list(map(_pattern, [self.name, *_frames(item)]))
        # A pattern without letters of its own would match all names.
        own = "|".join(one for one in dict.fromkeys(patterns) if any(map(str.isalnum, one)))
        # In its own part, a name has no prefix.
        self.pattern = re.compile(f"(?:{re.escape(scope.prefix)})?(?:{own or '(?!)'})")

    def would_define(self, name: str, existing: Collection[str]) -> bool:
        """Return True if a name is missing because of this: it would have it, or nothing else begins like this."""
        if self.pattern.fullmatch(name):
            return True
        begin = self.begin
        return bool(begin) and name.startswith(begin) and not any(one.startswith(begin) for one in existing)

    def span(self) -> Span:
        """Return the place of the condition, or of the loop."""
        spans: dict[str, Span] = self.entry.item.value_spans
        return spans["for" if self.entry.is_empty else "if"]

    def explained(self, group: list[Diagnostic]) -> Diagnostic:
        """Return the first of the diagnostics that this causes, with the others."""
        first, *others = group
        span, condition, why = self.span(), self.entry.item.get("if"), "its loop has no rounds"
        help = "leave out on the same condition what names it"
        if not self.entry.is_empty:
            only = list(pieces(str(condition)))
            text = "its if" if isinstance(condition, bool) else only[0].text.strip() if len(only) == 1 else condition
            why = f"{text} is false"
            help += f', if: "{condition}"' if isinstance(condition, str) else ""
        what = f'"{self.name}"' if self.name else "an item of a list"
        message = f"{first.message}: {what} is left out at {span.source.path}:{span.line} ({why})"
        related = [Related("left out here", span)]
        related += [Related(f"also missed: {one.message}", one.span) for one in others[:MAX_SHOWN]]
        more = len(others) - MAX_SHOWN
        related += [Related(f"also missed:{and_more(more)}", None)] if more > 0 else []
        return replace(first, message=message, help=help, related=(*related, *first.related))


def explain_missing_names(scope: Scope, tree: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics; those about names of one dropped entry are one, which names the entry."""
    existing = _names(tree)
    missing = {name for one in diagnostics if one.severity != NOTE for name in _QUOTED.findall(one.message)} - existing
    if not missing:
        return diagnostics
    rounds: Counter[int] = Counter()
    dropped: dict[object, _Dropped] = {}  # each once: several rounds of a loop may drop the same
    for entry in scope.expansion.disabled:
        rounds[id(entry.item)] += 1
        if rounds[id(entry.item)] <= MAX_ROUNDS + 1:
            one = _Dropped(entry, entry.is_empty or rounds[id(entry.item)] > MAX_ROUNDS)
            dropped.setdefault((id(entry.item), one.pattern.pattern, one.begin), one)
    causes: dict[str, _Dropped | None] = {}
    groups: dict[tuple[_Dropped, str], list[Diagnostic]] = {}
    others = []
    for diagnostic in diagnostics:
        cause = None
        for name in _QUOTED.findall(diagnostic.message) if diagnostic.severity != NOTE else ():
            if name in missing and name not in causes:
                causes[name] = next((one for one in dropped.values() if one.would_define(name, existing)), None)
            cause = cause or causes.get(name)
        if cause is None:
            others.append(diagnostic)
        else:
            groups.setdefault((cause, diagnostic.severity), []).append(diagnostic)
    return [*others, *(cause.explained(arrange(group)) for (cause, _), group in groups.items())]


def _evaluated(text: str, entry: Disabled) -> str:
    """Return a text with its expressions evaluated; as written, without any report, if they have errors."""
    if "$" not in text:
        return text
    reported = len(entry.scope.expansion.diagnostics)
    with suppress(Failed):
        name: str = entry.scope.name(text, entry.item.span, entry.scope.via)
        return name
    del entry.scope.expansion.diagnostics[reported:]
    return text


def _pattern(text: str) -> str:
    """Return the pattern of a name: anything may be in place of an expression."""
    if "$" not in text:
        return re.escape(text)
    return "".join(_ANY if piece.is_expression else re.escape(piece.text) for piece in pieces(text))


def _names_of_part(find: Any, name: Any, depth: int) -> Iterator[str]:
    """Yield patterns of the names of a part, without its prefix, also those of the parts in it."""
    body = find(name) if isinstance(name, str) and find is not None else None
    if body is None or not depth:
        yield _ANY
        return
    sections = Map(body.span)
    for key, value in body.items():
        if isinstance(value, (Map, Seq)):
            sections.put(key, value, body.key_spans[key], body.value_spans[key])
    yield from map(_pattern, _names(sections))
    inner = body.get("use")
    for use, entry in inner.items() if isinstance(inner, Map) else ():
        if isinstance(entry, Map):
            begin = _pattern(prefix_of(use, entry))
            yield from (begin + name for name in _names_of_part(find, entry.get("part"), depth - 1))


def _names(sections: Map) -> set[str]:
    """Return all names that sections define, also those of entries with a loop or a condition."""
    defined = SymbolTable(sections).names().of
    names = {name for kind, some in defined.items() if kind != "robot" for name in some}
    for value in sections.values():
        names.update(value if isinstance(value, Map) else ())
        names.update(text for item in value for text in _frames(item)) if isinstance(value, Seq) else None
    return names


def _frames(item: Any) -> list[str]:
    """Return the frames that an entry defines: that of a sensor, the child of an edge."""
    if not isinstance(item, Map):
        return []
    child = [item["child"]] if "publisher" in item and "type" not in item and "child" in item else []
    found = [*(item[key] for key in ("frame", "joint") if key in item), *child, *_frames(item.get("optical"))]
    return [one for one in found if isinstance(one, str)]

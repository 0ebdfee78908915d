"""Dropped entries: names that an ``if`` or a loop without rounds has removed are reported as that, once.

Errors in a dropped entry are not reported.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection
from contextlib import suppress
from dataclasses import replace
from typing import Any

from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Related
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.wording import and_more

from ..expression import pieces
from ..symbols import SymbolTable
from .expansion import Disabled, Failed
from .parts import prefix_of
from .scope import Scope

_QUOTED = re.compile(r'"([^"]+)"')
_WILD = "\ue000"  # stands for any text
MAX_ROUNDS = 100
MAX_SHOWN = 6


class _Dropped:
    """A dropped entry, a pattern of the names that it would define, and what all of these begin with.

    It is evaluated as if it were not dropped; the names of a loop without rounds are ``wild``.
    """

    def __init__(self, entry: Disabled, wild: bool) -> None:
        item, expansion, name = entry.item, entry.scope.expansion, entry.key
        scope, place = Scope(expansion, entry.scope), Place(item.span, entry.scope.via)
        for names in item["for"] if wild and isinstance(item.get("for"), Map) else ():
            for loop_name in names.split(","):
                scope.bind(loop_name.strip(), _WILD, place)
        defined, begin, reported = set[str](), "", len(expansion.diagnostics)
        with expansion.unlimited(), suppress(Failed):
            name = scope.name(name, *place) if "$" in name else name
            if entry.is_use:
                begin = scope.prefix + scope.name(prefix_of(name, item), *place)
            body = scope.resolve(expansion.body(item), place)
            if entry.is_use and expansion.instantiate is not None:
                defined = _names(expansion.instantiate(name, body, scope, place))
            else:
                defined = {name, *_frames(body)}
        del expansion.diagnostics[reported:]
        self.entry, self.name = entry, entry.key if wild else name
        self.begin = begin if _WILD not in begin else ""
        own = "|".join(re.escape(one).replace(_WILD, ".+") for one in sorted(defined) if one.strip(_WILD))
        # In its own part, a name has no prefix.
        self.pattern = re.compile(f"(?:{re.escape(scope.prefix)})?(?:{own or '(?!)'})")

    def would_define(self, name: str, existing: Collection[str]) -> bool:
        """Return True if a name is missing because of this: it would have it, or nothing else begins like this."""
        if self.pattern.fullmatch(name):
            return True
        begin = self.begin
        return bool(begin) and name.startswith(begin) and not any(one.startswith(begin) for one in existing)

    def explained(self, group: list[Diagnostic]) -> Diagnostic:
        """Return the first of the diagnostics that this causes, with the others."""
        first, *others = group
        item, is_empty = self.entry.item, self.entry.is_empty
        span, condition, why = item.value_spans["for" if is_empty else "if"], item.get("if"), "its loop has no rounds"
        help = "leave out on the same condition what names it"
        if not is_empty:
            only = list(pieces(str(condition)))
            text = "its if" if isinstance(condition, bool) else only[0].text.strip() if len(only) == 1 else condition
            why = f"{text} is false"
            help += f', if: "{condition}"' if isinstance(condition, str) else ""
        what = f'"{self.name}"' if self.name else "an item of a list"
        message = f"{first.message}: {what} is left out at {span.source.path}:{span.line} ({why})"
        related = [Related("left out here", span)]
        related += [Related(f"also missed: {one.message}", one.span) for one in others[:MAX_SHOWN]]
        if len(others) > MAX_SHOWN:
            related.append(Related(f"also missed:{and_more(len(others) - MAX_SHOWN)}", None))
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
    groups: dict[tuple[_Dropped, str], list[Diagnostic]] = {}
    others = []
    causes = {name: [one for one in dropped.values() if one.would_define(name, existing)] for name in missing}
    for diagnostic in diagnostics:
        names = _QUOTED.findall(diagnostic.message) if diagnostic.severity != NOTE else ()
        cause = next((causes[name][0] for name in names if causes.get(name)), None)
        if cause is None:
            others.append(diagnostic)
        else:
            groups.setdefault((cause, diagnostic.severity), []).append(diagnostic)
    return [*others, *(cause.explained(arrange(group)) for (cause, _), group in groups.items())]


def _names(sections: Map) -> set[str]:
    defined = SymbolTable(sections).names().of
    names = {name for kind, some in defined.items() if kind != "robot" for name in some}
    for value in sections.values():
        names.update(value if isinstance(value, Map) else ())
        names.update(text for item in value for text in _frames(item)) if isinstance(value, Seq) else None
    return names


def _frames(item: Any) -> list[str]:
    if not isinstance(item, Map):
        return []
    child = [item["child"]] if "publisher" in item and "type" not in item and "child" in item else []
    found = [*(item[key] for key in ("frame", "joint") if key in item), *child, *_frames(item.get("optical"))]
    return [one for one in found if isinstance(one, str)]

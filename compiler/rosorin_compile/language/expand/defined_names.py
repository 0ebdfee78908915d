"""Names that the files define for expansion: unused ones, letters that look alike, and names that an ``if`` removes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from itertools import chain, islice
from pathlib import Path
from typing import Any

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Related, Span
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.project import ENDINGS
from rosorin_compile.source.tree import Map, value_at
from rosorin_compile.source.wording import and_more, difference, hidden_letter, in_words, look

from ..expression import pieces
from ..symbols import WORD, Symbol, SymbolTable
from .scope import Disabled, Failed, Scope

_MAX_FILES = 500
_CHECKED = ("argument", "value", "part", "sensor type", "publisher", "mode")
_EXPRESSIONS = ("argument", "value", "parameter")


def check_letters(symbols: SymbolTable, scope: Scope) -> None:
    """Report invisible letters in names that expansion resolves; warn of names that look alike."""
    first: dict[tuple[str, ...], Symbol] = {}
    for one in symbols.definitions():
        if one.place is None:
            continue
        ignore_case = one.kind in ("part", "sensor type")  # in a formula r and R are two names
        if letter := hidden_letter(one.name):
            message = f'{one.kind} "{one.name}" has an invisible letter: {in_words(letter)}'
            scope.report("invisible-letter", message, one.place, "type the name again, without this letter")
            continue
        similar = first.setdefault((one.kind, one.owner, look(one.name, ignore_case)), one)
        if similar.name != one.name and similar.place:
            other = f'{one.kind} "{similar.name}" only in {difference(one.name, similar.name)}'
            related = (Related("the other one", similar.place.span), *one.place.stack())
            message, help = f'{one.kind} "{one.name}" differs from {other}', "give one of them another name"
            warning = Diagnostic("names-look-alike", WARNING, message, one.place.span, related, help)
            scope.expansion.diagnostics.append(warning)


def unused_names(symbols: SymbolTable, read: Iterable[Path]) -> list[Diagnostic]:
    """Return a warning for each name that is defined and never used; ``read`` are the files of the description."""
    tree, uses = symbols.tree, list(symbols.references(_CHECKED))
    used = {(one.kind, one.name, one.owner) for one in uses if (one.kind, *one.path[:2]) != ("part", "parts", one.name)}
    hidden = {one.kind for one in uses if "$" in one.name}
    outputs = tree.get("outputs")
    if isinstance(outputs, Map):  # a template may print all of them, and options name modes
        templates = any(isinstance(entry, Map) and "template" in entry for entry in outputs.values())
        hidden |= {"publisher", "mode"} if templates else set()
        used |= {("mode", word, "") for word in WORD.findall(str(outputs))}
    shared: dict[str, bool] = {}
    warnings = []
    for one in symbols.definitions():
        kind = "value" if one.kind in _EXPRESSIONS else one.kind
        if kind not in _CHECKED or kind in hidden or "$" in one.name or (kind, one.name, one.owner) in used:
            continue
        place, entry = one.place or tree.locate(one.path, key=True), value_at(tree, one.path)
        if one.kind == "publisher" and (isinstance(entry, str) or (entry or {}).get("stamps")):
            continue
        what = f'{one.kind} "{one.name}"'
        message = f"{one.owner} never uses its {what}" if one.owner else f"nothing uses the {what}"
        file = place.span.source.path
        if file not in shared:
            shared[file] = file != tree.span.source.path and _is_shared(place.span, read)
        if not shared[file]:
            warnings.append(Diagnostic("unused", WARNING, message, place.span, place.stack(), "use it, or remove it"))
    return warnings


def _is_shared(span: Span, read: Iterable[Path]) -> bool:
    """Return True if another file near the file of a place names it."""
    own, file = {files.resolve(path) for path in read}, files.resolve(span.source.path)
    siblings = chain(file.parent.glob("*"), file.parent.parent.glob("*/*"))
    nearby = [path for path in islice(siblings, _MAX_FILES) if path.suffix in ENDINGS]
    try:
        texts = (files.read_text(path, errors="replace") for path in nearby if files.resolve(path) not in own)
        return any(file.name in text for text in texts)
    except OSError:
        return False


_QUOTED = re.compile(r'"([^"]+)"')
MAX_ROUNDS = 100
MAX_SHOWN = 6


def explain_missing_names(scope: Scope, tree: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Merge the diagnostics about missing names that one dropped entry defines into one that names the entry."""
    symbols = SymbolTable(tree)
    existing = {name for kind, some in symbols.of.items() if kind != "robot" for name in some}
    existing.update(one.name for one in symbols.definitions(implied=True) if one.kind != "robot")
    missing = {name for one in diagnostics if one.severity != NOTE for name in _QUOTED.findall(one.message)} - existing
    if not missing:
        return diagnostics
    rounds: Counter[int] = Counter()
    dropped: dict[tuple[int, str], Disabled] = {}  # each once: several rounds may drop the same
    for entry in scope.expansion.disabled:
        rounds[id(entry.item)] += 1
        if rounds[id(entry.item)] <= MAX_ROUNDS:
            dropped.setdefault((id(entry.item), _pattern(entry)), entry)
    causes: dict[str, tuple[int, str]] = {}
    for name in missing:
        for key, entry in dropped.items():
            begin = re.match(key[1], name) if entry.is_use else re.fullmatch(key[1], name)
            # A name belongs to a dropped use if no other name has the same prefix.
            if begin is not None and not (entry.is_use and any(one.startswith(begin[0]) for one in existing)):
                causes.setdefault(name, key)
    groups: dict[tuple[tuple[int, str] | None, str], list[Diagnostic]] = {}
    for diagnostic in diagnostics:
        names = _QUOTED.findall(diagnostic.message) if diagnostic.severity != NOTE else ()
        cause = next((causes[name] for name in names if name in causes), None)
        groups.setdefault((cause, diagnostic.severity), []).append(diagnostic)
    explained = [_explained(dropped[cause], arrange(group)) for (cause, _), group in groups.items() if cause]
    return [*(one for (cause, _), group in groups.items() if not cause for one in group), *explained]


def _pattern(entry: Disabled) -> str:
    """Return a pattern that matches the names of a dropped entry, or the prefix of its part.

    Names are evaluated as if the entry were not dropped; in a loop without rounds, an expression matches any text.
    """
    scope, expansion, key, item = entry.scope, entry.scope.expansion, entry.key, entry.item
    texts, patterns = [text for text in (key, *_frames(item)) if text], []
    if entry.is_use:
        prefix = item.get("prefix", f"{key}_")
        texts = [prefix] if isinstance(prefix, str) and prefix else []
    for text in texts:
        if entry.is_empty:
            patterns.append("".join(".+?" if one.is_expression else re.escape(one.text) for one in pieces(text)))
            continue
        reported = len(expansion.diagnostics)
        with expansion.without_limits(), suppress(Failed):
            patterns.append(re.escape(scope.name(text, item.span, scope.via)))
        del expansion.diagnostics[reported:]
    # In its own part, a name has no prefix.
    return f"(?:{re.escape(scope.prefix)})?(?:{'|'.join(patterns) or '(?!)'})"


def _explained(entry: Disabled, group: list[Diagnostic]) -> Diagnostic:
    """Return the first diagnostic that a dropped entry causes, with the others as related places."""
    (first, *others), item, key = group, entry.item, entry.key
    span, why = item.value_spans["for" if entry.is_empty else "if"], "its loop has no rounds"
    if not entry.is_empty:
        why = f"its condition is false: {item['if']}" if isinstance(item["if"], str) else "its condition is false"
        with suppress(Failed):
            key = entry.scope.name(key, item.span, entry.scope.via) if "$" in key else key
    what = f'"{key}"' if key else "an item of a list"
    message = f"{first.message}: {what} is left out at {span.source.path}:{span.line} ({why})"
    related = [Related("left out here", span)]
    related += [Related(f"also missed: {one.message}", one.span) for one in others[:MAX_SHOWN]]
    if len(others) > MAX_SHOWN:
        related.append(Related(f"also missed:{and_more(len(others) - MAX_SHOWN)}", None))
    help = "leave out on the same condition what names it"
    return replace(first, message=message, help=help, related=(*related, *first.related))


def _frames(item: Any) -> list[str]:
    if not isinstance(item, Map):
        return []
    child = [item["child"]] if "publisher" in item and "type" not in item and "child" in item else []
    found = [*(item[key] for key in ("frame", "joint") if key in item), *child, *_frames(item.get("optical"))]
    return [one for one in found if isinstance(one, str)]

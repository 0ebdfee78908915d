"""Rules about names that the files define for expansion: unused ones, and letters that cannot be distinguished."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain, islice
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Span
from rosorin_compile.source.project import ENDINGS
from rosorin_compile.source.tree import Map, value_at
from rosorin_compile.source.wording import difference, hidden_letter, in_words, look

from .expand.scope import Scope
from .symbols import WORD, Symbol, SymbolTable

_MAX_FILES = 500
# What the message says of an unused name of a kind, and where to use it.
_UNUSED = {
    "argument": ('nothing uses the argument "{}"', "write ${{{}}} where it belongs"),
    "value": ('nothing uses the value "{}" of let', "write ${{{}}} where it belongs"),
    "part": ('nothing uses the part "{}"', "write use: {{NAME: {{part: {}}}}}"),
    "sensor type": ('no sensor is of the type "{}"', "write type: {} in a sensor"),
    "publisher": (
        'publisher "{}" publishes no joint and no edge, and stamps nothing',
        "write publisher: {} in a joint or an edge",
    ),
    "mode": ('no condition names the mode "{}"', "write when: {} where it matters"),
}
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
            other = f'{one.kind} "{similar.name}" in {difference(one.name, similar.name)} alone'
            related = (Related("the other one", similar.place.span), *one.place.stack())
            message, help = f'{one.kind} "{one.name}" differs from {other}', "give one of them another name"
            warning = Diagnostic("names-look-alike", WARNING, message, one.place.span, related, help)
            scope.expansion.diagnostics.append(warning)


def unused_names(symbols: SymbolTable, read: Iterable[Path]) -> list[Diagnostic]:
    """Return a warning for each name that is defined and never used; ``read`` are the files of the description."""
    tree, uses = symbols.tree, list(symbols.references(tuple(_UNUSED)))
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
        if kind not in _UNUSED or kind in hidden or "$" in one.name or (kind, one.name, one.owner) in used:
            continue
        place, entry = one.place or tree.locate(one.path, key=True), value_at(tree, one.path)
        if one.kind == "publisher" and (isinstance(entry, str) or (entry or {}).get("stamps")):
            continue
        what, way = _UNUSED.get(one.kind, _UNUSED["value"])
        message = f'{one.owner} never uses its {one.kind} "{one.name}"' if one.owner else what.format(one.name)
        file = place.span.source.path
        if file not in shared:
            shared[file] = file != tree.span.source.path and _is_shared(place.span, read)
        if not shared[file]:
            help = f"{way.format(one.name)}, or remove it"
            warnings.append(Diagnostic("unused", WARNING, message, place.span, place.stack(), help))
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

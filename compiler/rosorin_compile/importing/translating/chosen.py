"""Chosen: what a macro chooses among many by what each call says of itself (``<xacro:if value="${prefix == 'fl'}">``).

Such a chain is a table of the calls: each use says its own value, and the part takes it as a parameter.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .expressions import usable
from .pieces import Entry, Item, Macro, Use, When, Whens
from .scopes import (
    CONDITION,
    FILE,
    FREE,
    LISTS,
    NUMBERS,
    PARAMETER,
    Bound,
    Scope,
    Value,
    Variable,
    is_argument,
    is_plain,
    literal,
    names_of,
)
from .setting import decided
from .texts import EXPRESSION, source_tree, tokens

MOST_CHOICES = 2  # what has more is not read as a choice any more
MOST_DEPTH = 20
_OURS = ("name", "prefix")
_ZEROS = ("xyz", "rpy")

Definitions = Sequence[tuple[Value, Whens]]


def said_by_uses(macros: Sequence[Macro]) -> bool:
    """Make parameters of properties and entries that are chosen so: one value a use; say whether there are any."""
    before = sum(len(macro.variables) for macro in macros)
    for macro in macros:
        if macro.body is None or not macro.uses:
            continue
        for local in list(macro.body.locals):
            found = _values(macro, local.definitions) if local.name not in _OURS else None
            if found is not None:
                macro.body.locals.remove(local)
                local.where = PARAMETER
                _hand(macro, local, local.name if local.name not in macro.variables else local.ours, found)
        for named in (*macro.body.links, *macro.body.joints):
            _settle(macro, named.entry)
    return sum(len(macro.variables) for macro in macros) > before


def _hand(macro: Macro, variable: Variable, name: str, values: Sequence[Value]) -> None:
    """Let each use of a macro give a parameter."""
    macro.variables[name] = variable
    for use, value in zip(macro.uses, values, strict=True):
        use.given[name] = value


def _settle(macro: Macro, entry: Entry) -> None:
    """Make parameters of the keys of an entry that are chosen."""
    for key in entry.names():
        items = [item for item in entry.items if item.key == key]
        for item in items:
            inner = [one.value for one in item.value] if isinstance(item.value, list) else [item.value]
            for one in inner:
                if isinstance(one, Entry):
                    _settle(macro, one)
        plain = all(isinstance(item.value, Value) and item.value.sink in (*NUMBERS, *LISTS, FILE) for item in items)
        rest = Value("0 0 0", macro.scope, FREE) if key in _ZEROS else None
        found = _values(macro, [(item.value, item.when) for item in items], rest) if plain else None
        if found is not None:
            first = items[0].value
            name = _parameter(macro, key, first.sink, found)
            at = entry.items.index(items[0])
            entry.items[at] = Item(key, Value(f"${{{name}}}", macro.scope, first.sink, first.span))
            entry.items = [item for item in entry.items if item not in items[1:]]


def _parameter(macro: Macro, key: str, sink: str, values: Sequence[Value]) -> str:
    """Make a parameter of a macro that is called as a key; return its name."""
    known = {*macro.scope.names, *(one.ours for one in macro.scope.names.values() if isinstance(one, Variable))}
    name = usable(key, lambda one: one in known)
    made = Variable(name, PARAMETER, span=macro.place)
    made.evidence.add(sink)
    made.values += values
    macro.scope.names[name] = made
    _hand(macro, made, name, values)
    return name


def _values(macro: Macro, definitions: Definitions, otherwise: Value | None = None) -> list[Value] | None:
    """Return what is chosen for each use; None if that is not decided there, or chosen among few."""
    if sum(bool(when) for _, when in definitions) <= MOST_CHOICES:
        return None
    found = [_value_for(use, definitions, otherwise) for use in macro.uses]
    return None if None in found else [value for value in found if value is not None]


def _value_for(use: Use, definitions: Definitions, otherwise: Value | None) -> Value | None:
    """Return what is chosen for a use, as the caller says it."""
    macro, scope = use.macro, Scope(use.scope, use.macro.name)
    for parameter in macro.parameters:
        given = use.given.get(parameter.name)
        if given is not None:
            scope.names[parameter.name] = Bound(given.text, given.scope)
        elif parameter.default is not None:
            scope.names[parameter.name] = Bound(parameter.default, macro.file.body.scope)
    chosen = otherwise
    for value, when in definitions:
        if not all(_means_the_same(one, macro, scope) for one in (value, *(on.value for on in when))):
            return None
        holds = [decided(When(Value(on.value.text, scope, CONDITION), on.holds)) for on in when]
        if None in holds and False not in holds:
            return None
        chosen = value if all(holds) else chosen
    return None if chosen is None else Value(chosen.text, scope, FREE, chosen.span)


def _means_the_same(value: Value, macro: Macro, scope: Scope, depth: int = 0) -> bool:
    """Say whether the names in a text of a macro mean in a scope of a use what they mean there; binds properties."""
    for name in _names_in(value.text):
        meant = value.scope.find(name)
        if meant is None or (name in scope.names and meant is macro.variables.get(name)):
            continue
        text = _text_of(meant) if isinstance(meant, Variable) and macro.body and meant in macro.body.locals else ""
        if text and isinstance(meant, Variable):
            scope.names[name] = Bound(text, scope)
            within = Value(text, meant.definitions[0][0].scope, FREE)
            if depth > MOST_DEPTH or not _means_the_same(within, macro, scope, depth + 1):
                return False
        elif scope.find(name) is not meant and meant not in macro.implicit.values():
            return False
    return True


def _text_of(local: Variable) -> str:
    """Return a property of a macro as one text of xacro: its only value, or one of two by a condition; else nothing."""
    (first, when), *others = local.definitions
    if not others:
        return "" if when else first.text
    (second, on), *more = others
    opposite = len(when) == len(on) == 1 and when[0].value.text == on[0].value.text and when[0].holds != on[0].holds
    if more or len(on) != 1 or not (opposite or not when):
        return ""
    yes, no = (second, first) if on[0].holds else (first, second)
    parts = [_as_expression(one.text) for one in (yes, on[0].value, no)]
    return f"${{({parts[0]}) if ({parts[1]}) else ({parts[2]})}}" if all(parts) else ""


def _as_expression(text: str) -> str:
    """Return a text of xacro as one expression; empty for one that is put together."""
    pieces = tokens(text)
    if len(pieces) == 1 and pieces[0].kind == EXPRESSION:
        return pieces[0].text
    if is_argument(text):
        return text
    value = literal(text) if is_plain(text) else None
    return repr(value) if isinstance(value, (str, int, float)) else ""


def _names_in(text: str) -> Iterator[str]:
    for piece in tokens(text):
        if piece.kind == EXPRESSION:
            try:
                yield from names_of(source_tree(piece.text))
            except ValueError:
                continue

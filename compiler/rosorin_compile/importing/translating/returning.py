"""Returning: macros that make nothing but properties of whoever calls them, as named values with parameters.

``<xacro:property ... scope="parent"/>`` is how a macro of xacro gives a result. Several of them are a table; the caller
reads its entries under the names that it knows.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rosorin_compile.source.xml.markup import Element

from .pieces import Body, Call, Entry, Macro, Whens
from .program import with_comments
from .scopes import FREE, RETURNED, Bound, Returned, Scope, Unsaid, Value, note
from .setting import MacroScope, decided
from .texts import Unsupported

if TYPE_CHECKING:
    from .walking import Walker

LEVEL = "let"
MAX_DEPTH = 20
_ALL = "__all"  # no name of xacro
_VERB = re.compile(r"(read|get|load|set|define)_(?=\w)")


def returns(walker: Walker, macro: Macro, scope: Scope, when: Whens) -> bool:
    """Walk over a macro that only sets properties of its caller; say whether it is a named value for a caller."""
    if walker.lifting is not None or macro.name in walker.inlined or not _as_value(walker, macro):
        return False
    target = scope.begun()
    if target.parent is not None:
        return True
    return not _open(when) and macro.entry is not None and not {*macro.entry.names()} & target.names.keys()


def _as_value(walker: Walker, macro: Macro) -> bool:
    if macro.level:
        return macro.level == LEVEL
    if any(one.block for one in macro.parameters) or not _sets(walker, macro.element):
        return False
    walker.begin(macro, LEVEL)
    macro.entry = Entry()
    try:
        _take(walker, macro.element, macro.scope, (), macro.entry)
    except Unsupported:
        macro.level, macro.entry = "", None
        macro.variables.clear()
        macro.implicit.clear()
        return False
    walker.seen.append(macro)
    return True


def _sets(walker: Walker, element: Element, depth: int = 0) -> bool:
    """Say whether all that a macro holds are properties, some of them those of whoever calls it."""
    found = False
    for child in element.children:
        if child.tag in ("xacro:if", "xacro:unless"):
            if child.children and not _sets(walker, child, depth):
                return False
            found = True
        elif child.tag == "xacro:property":
            plain = "value" in child.attributes and not child.get("remove") and "$" not in child.get("name")
            if not plain or child.get("scope") == "global":
                return False
            found = found or child.get("scope") == "parent"
        elif not child.tag.startswith("xacro:") or child.children or depth > MAX_DEPTH:
            return False
        else:
            called = walker.program.macro(child.tag.removeprefix("xacro:"), child)
            if called is None or not _sets(walker, called.element, depth + 1):
                return False
    return found


def _take(walker: Walker, element: Element, scope: Scope, when: Whens, entry: Entry) -> None:
    """Take the properties that a macro sets: those of its caller become entries, the others are its own."""
    for child, _ in with_comments(element):
        here = scope.latest()
        if child.tag in ("xacro:if", "xacro:unless"):
            on = walker.condition(child, here)
            if decided(on) is not False:
                _take(walker, child, scope, (*when, on), entry)
        elif child.tag == "xacro:property":
            name, value = child.get("name"), Value(child.get("value"), here, FREE, child.span)
            note(value)
            if child.get("scope") == "parent":
                entry.put(name, Value(value.text, here, RETURNED, child.span), _open(when))
            unsaid = Unsaid(f'the property "{name}" is set on a condition') if _open(when) else None
            scope.set_from_here(name, unsaid or Bound(value.text, here))
        else:
            macro = walker.macro_of(child)
            if not returns(walker, macro, scope, when):
                raise Unsupported(f'the macro "{macro.name}" makes more than properties', child.span)
            set_by(walker, macro, child, scope, when, None)


def set_by(walker: Walker, macro: Macro, element: Element, scope: Scope, when: Whens, body: Body | None) -> None:
    """Let a caller of a macro read what it sets; in a ``body`` what is several is a named value of it."""
    here, target = scope.latest(), scope.begun()
    given = walker.given(macro, element, here)
    call = Call(macro, given, {}, here, element)
    walker.hand_over(macro, given)
    keys = macro.entry.names() if macro.entry else []
    table = None
    if body is not None and len(keys) > 1:
        whole, table = Scope(here), Scope(here)
        whole.names[_ALL] = Returned(call, "")
        value = Value(f"${{{_ALL}}}", whole, FREE, element.span)
        name = _VERB.sub("", macro.name) if _VERB.match(macro.name) else f"{macro.name}_values"
        table.names[_ALL] = walker.new_local(name, value, body, target, (), Scope())
    for key in keys:
        found = Returned(call, key) if table is None else Bound(f"${{{_ALL}['{key}']}}", table)
        if table is not None:
            note(Value(f"${{{_ALL}['{key}']}}", table, FREE))
        if left := _open(when):
            inner = Scope(here)
            inner.names[key] = found
            walker.chosen_value(key, Value(f"${{{key}}}", inner, FREE, element.span), scope, target, left)
        elif target.parent is None:
            target.names[key] = found
        else:
            target.set_from_here(key, found)


def body_around(scope: Scope) -> Body | None:
    """Return the body of the part that a scope is in."""
    here: Scope | None = scope
    while here is not None and not isinstance(here, MacroScope):
        here = here.parent
    return here.macro.body if here is not None else None


def _open(when: Whens) -> Whens:
    return tuple(on for on in when if decided(on) is None)


__all__ = ["body_around", "returns", "set_by"]

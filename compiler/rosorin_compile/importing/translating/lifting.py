"""Lifting: one element of a macro that cannot be said in a part, written at the top of the file that calls the macro.

The part keeps all else. The element is written as if its macros were written out where they are called, so that it
follows arguments and conditions; one that cannot be said there either is taken as xacro has expanded it (see
``flattened``).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from rosorin_compile.source.xml.markup import Element

from .flattened import Place, place_of
from .pieces import Macro
from .texts import EXPRESSION, EXTENSION, TEXT, Token, Unsupported, tokens

if TYPE_CHECKING:
    from .program import Program

_FRAME = ("link", "joint")  # what others in a part speak of
_MAKES_NOTHING = frozenset(f"xacro:{one}" for one in ("if", "unless", "include", "property", "arg", "macro"))
_AROUND = ("xacro:macro", "xacro:if", "xacro:unless")


def macro_around(element: Element) -> Element | None:
    """Return the macro that an element stands in, under conditions or not; None where it stands elsewhere."""
    here = element.parent
    while here is not None and here.tag in ("xacro:if", "xacro:unless"):
        here = here.parent
    return here if here is not None and here.tag == "xacro:macro" else None


def own_place(problem: Unsupported) -> Place | None:
    """Return the place of the one element of a macro that a problem is about; None where it is about another thing."""
    element = problem.element
    return place_of(element.span) if element is not None and macro_around(element) is not None else None


def can_lift(macro: Macro, element: Element, lifted: Collection[Place]) -> bool:
    """Say whether an element can be lifted out of a part, and leaves anything there."""
    if macro_around(element) is not macro.element:  # that of a macro that is written out in this one
        return True
    if element.tag in _FRAME:
        return False
    others = (one for one in macro.element.iter() if one is not element and _makes_something(one))
    return any(place_of(one.span) not in lifted for one in others)


def _makes_something(element: Element) -> bool:
    """Say whether an element of a macro makes something of a robot."""
    return element.tag not in _MAKES_NOTHING and element.parent is not None and element.parent.tag in _AROUND


def elements_at(program: Program, places: Collection[Place]) -> list[Element]:
    """Return the elements at some places."""
    if not places:
        return []
    roots = [file.document.root for file in program.files.values()]
    return [element for root in roots for element in root.iter() if place_of(element.span) in places]


def leading_to(program: Program, elements: Collection[Element]) -> set[Macro]:
    """Return the macros that hold some elements, or call such macros."""
    wanted = {id(element) for element in elements}
    inner = {macro: list(macro.element.iter()) for macro in program.macros.values()}
    found = {macro for macro, within in inner.items() if any(id(one) in wanted for one in within)}
    called = {macro: {pattern for one in within for pattern in called_by(one)} for macro, within in inner.items()}
    before = -1
    while before != len(found):
        before = len(found)
        names = {macro.element.get("name").removeprefix("xacro:") for macro in found}
        found |= {
            macro for macro, patterns in called.items() if any(fnmatchcase(n, p) for p in patterns for n in names)
        }
    return found


def called_by(element: Element) -> Iterator[str]:
    """Yield the name of the macro that an element calls; as a pattern where an expression has a say in it."""
    if element.tag == "xacro:call":
        yield pattern_of(element.get("macro"))
    elif element.tag.startswith("xacro:") and element.tag not in _MAKES_NOTHING:
        yield element.tag.removeprefix("xacro:").rpartition(".")[2]


def is_handed(program: Program, macro: Macro, name: str, seen: tuple[Macro, ...] = ()) -> bool:
    """Say whether whoever calls a macro has a value of a name, or is called by such macros alone."""
    called = macro.element.get("name").removeprefix("xacro:")
    sites = [
        element
        for file in program.files.values()
        for element in file.document.root.iter()
        if any(fnmatchcase(called, pattern) for pattern in called_by(element))
    ]
    return bool(sites) and all(_has(program, site, name, (*seen, macro)) for site in sites)


def _has(program: Program, site: Element, name: str, seen: tuple[Macro, ...]) -> bool:
    here: Element | None = site
    while here is not None and here.tag != "xacro:macro":
        here = here.parent
    if here is None:
        return program.scope.lookup(name) is not None
    holder = program.by_element.get(id(here))
    if holder is None or holder in seen:
        return False
    own = any(one.name == name and not one.block for one in holder.parameters)
    return own or is_handed(program, holder, name, seen)


def pattern_of(text: str) -> str:
    """Return a text as a pattern, with ``*`` for each piece that is evaluated.

    >>> pattern_of("${side}_arm")
    '*_arm'
    """
    return "".join("*" if piece.kind in (EXPRESSION, EXTENSION) else piece.text for piece in tokens(text))


def equal_to(text: str, name: str) -> str:
    """Return the condition that a text with expressions in it is a name; all pieces of it are texts.

    >>> equal_to("${side}_arm", "left_arm"), equal_to("${side}_${kind}", "left_arm")
    ("${(side) == 'left'}", "${str(side) + '_' + str(kind) == 'left_arm'}")
    """
    pieces = tokens(text)
    opened = [_spelt(piece) for piece in pieces if piece.kind != TEXT]
    if len(opened) == 1:
        before, _, after = pattern_of(text).partition("*")
        return f"${{({opened[0]}) == {name.removeprefix(before).removesuffix(after)!r}}}"
    parts = [repr(piece.text) if piece.kind == TEXT else f"str({_spelt(piece)})" for piece in pieces]
    return f"${{{' + '.join(parts)} == {name!r}}}"


def _spelt(piece: Token) -> str:
    return piece.text if piece.kind == EXPRESSION else f"'$({piece.text})'"


__all__ = [
    "called_by",
    "can_lift",
    "elements_at",
    "equal_to",
    "is_handed",
    "leading_to",
    "macro_around",
    "own_place",
    "pattern_of",
]

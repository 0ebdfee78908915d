"""Fixing: the arguments of a xacro that its description cannot keep, because they reach what is written flat.

What is flat is as the values at hand make it. An argument that has a say in it, and of which not every value is
compared, is no argument any more: it has the value that it was given, or its default.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from fnmatch import fnmatchcase
from typing import NamedTuple

from rosorin_compile.source.xml.markup import Element, Remark

from .flattened import Place
from .lifting import called_by, elements_at, macro_around
from .pieces import Macro
from .program import Program
from .scopes import ARGUMENT, FLAG, sole_name
from .texts import tokens

MOST_SWITCHES, MOST_CALLS = 12, 40
_WORD = re.compile(r"[A-Za-z_]\w*")


def value_of(program: Program, name: str) -> str | None:
    """Return the text that an argument is: what it was given, or its default; None if it has neither."""
    given = program.given.get(name)
    variable = program.arguments[name]
    return given if given is not None else variable.values[0].text if variable.values else None


def switches_of(program: Program) -> dict[str, str]:
    """Return the arguments that choose between things, with their texts: what is true or false, or compared."""
    made: dict[str, str] = {}
    for name, variable in program.arguments.items():
        text = value_of(program, name)
        chooses = variable.kind() == FLAG or any(one.startswith("=") for one in variable.head().evidence)
        if text is not None and (chooses or text.lower() in ("true", "false")):
            made[name] = text
    return made


def reached(program: Program, flat: Collection[Place]) -> dict[str, str]:
    """Return the arguments that may have a say in elements that are flat, with their texts; rather one too many."""
    elements = elements_at(program, flat)
    calls = _Calls(program) if elements else None
    waiting: list[_Said] = [_Said(_text_of(element), None) for element in elements if macro_around(element) is None]
    for element in elements:
        macro = _macro_of(program, element)
        if macro is not None and calls is not None:
            waiting += [_Said(_text_of(element), macro), *calls.around(element, macro, set())]
    seen: set[tuple[str, Macro | None]] = set()
    found: dict[str, str] = {}
    while waiting:
        said, within = waiting.pop()
        for name in sorted(set(_WORD.findall(said)) - {name for name, macro in seen if macro is within}):
            seen.add((name, within))
            waiting += calls.behind(name, within) if calls is not None else ()
            variable = program.arguments.get(name)
            text = value_of(program, name) if variable is not None else None
            if variable is not None and variable.where == ARGUMENT and text is not None:
                found[name] = text
                waiting.append(_Said(text, None))
    return {name: found[name] for name in program.arguments if name in found}


class _Said(NamedTuple):
    """A text, and the macro that its names are looked up in."""

    text: str
    macro: Macro | None


class _Calls:
    """The calls of all macros, and what names in macros stand for by them."""

    def __init__(self, program: Program) -> None:
        self.program = program
        elements = (one for file in program.files.values() for one in file.document.root.iter())
        self.found = [(pattern, one) for one in elements for pattern in called_by(one)]

    def of(self, macro: Macro) -> list[Element]:
        """Return the elements that call a macro."""
        name = macro.element.get("name").removeprefix("xacro:")
        return [element for pattern, element in self.found if fnmatchcase(name, pattern)]

    def behind(self, name: str, within: Macro | None) -> list[_Said]:
        """Return the texts that a name may stand for: a macro, a property, what calls give for a parameter."""
        macro = self.program.macros.get(name)
        made = [_Said(_text_of(macro.element), None if within is None else macro)] if macro is not None else []
        made += [_Said(one.value.text, None) for one in self.program.properties.get(name, ())]
        if within is None:
            return made
        set_in = [one for one in within.element.iter() if one.tag == "xacro:property" and one.get("name") == name]
        made += [_Said(one.get("value", one.get("default")), within) for one in set_in]
        for parameter in within.parameters:
            if parameter.name == name:
                made.append(_Said(parameter.default or parameter.of_caller or "", None))
                made += [_Said(call.get(name), _macro_of(self.program, call)) for call in self.of(within)]
        return made

    def around(self, element: Element, macro: Macro | None, seen: set[int]) -> list[_Said]:
        """Return the conditions on which an element of a macro is there: around it, and around what calls that."""
        made: list[_Said] = []
        here = element.parent
        while here is not None and here.tag != "xacro:macro":
            made += [_Said(here.get("value"), macro)] if here.tag in ("xacro:if", "xacro:unless") else []
            here = here.parent
        for call in self.of(macro) if macro is not None and id(macro) not in seen else ():
            made += self.around(call, _macro_of(self.program, call), {*seen, id(macro)} if macro is not None else seen)
        return made


def _macro_of(program: Program, element: Element) -> Macro | None:
    """Return the macro that an element stands in, at whatever depth."""
    here = element.parent
    while here is not None and here.tag != "xacro:macro":
        here = here.parent
    return program.by_element.get(id(here)) if here is not None else None


def pins(program: Program) -> dict[tuple[str, str], str]:
    """Return the parameters that all calls give one argument that is none any more, by macro and name; and its text."""
    calls: dict[str, list[_Call]] = {}
    for macro in (None, *program.macros.values()):
        for element in _outside(program) if macro is None else macro.element.iter():
            if element.tag.startswith("xacro:"):
                calls.setdefault(element.tag.removeprefix("xacro:"), []).append(_Call(element, macro))
    made: dict[tuple[str, str], str] = {}
    for macro in program.macros.values() if program.fixed else ():
        for parameter in macro.parameters:
            text = _pinned(program, calls, macro, parameter.name, 0)
            if text is not None:
                made[macro.name, parameter.name] = text
    return made


class _Call(NamedTuple):
    element: Element
    within: Macro | None


def _outside(program: Program) -> Iterator[Element]:
    """Yield the elements that stand in no macro."""
    waiting = [file.document.root for file in program.files.values()]
    while waiting:
        element = waiting.pop()
        if element.tag != "xacro:macro":
            yield element
            waiting += element.children


def _pinned(program: Program, calls: Mapping[str, list[_Call]], macro: Macro, name: str, depth: int) -> str | None:
    texts = {_fixed_text(program, calls, call, call.element.get(name), depth) for call in calls.get(macro.name, ())}
    return texts.pop() if len(texts) == 1 else None


def _fixed_text(
    program: Program, calls: Mapping[str, list[_Call]], call: _Call, text: str | None, depth: int
) -> str | None:
    """Return the text of the argument that a text stands for, if that is none any more."""
    name = sole_name(tokens(text)) if text and depth < MOST_CALLS else None
    if name is None:
        return None
    if name.startswith("arg "):
        return program.fixed.get(name.removeprefix("arg "))
    if call.within is not None and any(one.name == name for one in call.within.parameters):
        return _pinned(program, calls, call.within, name, depth + 1)
    known = program.properties.get(name, [])
    alone = len(known) == 1 and not known[0].when
    return _fixed_text(program, calls, call, known[0].value.text, depth + 1) if alone else None


def undecided(found: Mapping[str, str], choices: Mapping[str, Collection[str]]) -> dict[str, str]:
    """Return the arguments of which the proof compares one value alone."""
    return {name: text for name, text in found.items() if len(choices.get(name, ())) < 2}


def _text_of(element: Element) -> str:
    """Return all that an element says: tags, attributes and texts."""
    said: list[str] = []
    for one in element.iter():
        said += [one.tag.removeprefix("xacro:"), *(attribute.value for attribute in one.attributes.values())]
        said += [item.text for item in one.content if isinstance(item, Remark) and not item.is_comment]
    return " ".join(said)

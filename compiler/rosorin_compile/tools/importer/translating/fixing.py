"""Fixing: the arguments of a xacro that its description cannot keep, because they reach what is written flat.

What is flat is as the values at hand make it. An argument that has a say in it, and of which not every value is
compared, is no argument any more: it has the value that it was given, or its default.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

from ....xml.markup import Element, Remark
from .flattened import Place, place_of
from .pieces import Macro
from .program import Program
from .scopes import ARGUMENT, FLAG, Bound, Value, Variable, sole_name
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
    texts = [_text_of(element) for file in program.files.values() for element in _at(file.document.root, flat)]
    seen: set[str] = set()
    found: dict[str, str] = {}
    while texts:
        for name in set(_WORD.findall(texts.pop())) - seen:
            seen.add(name)
            macro = program.macros.get(name)
            if macro is not None:
                texts.append(_text_of(macro.element))
            texts += [one.value.text for one in program.properties.get(name, ())]
            variable = program.arguments.get(name)
            text = value_of(program, name) if variable is not None else None
            if variable is not None and variable.where == ARGUMENT and text is not None:
                found[name] = text
                texts.append(text)
    return found


def pins(macros: Collection[Macro]) -> dict[tuple[str, str], str]:
    """Return the parameters that all calls give one argument that is none any more, by macro and name; and its text."""
    made: dict[tuple[str, str], str] = {}
    for macro in macros:
        for name, variable in macro.variables.items():
            text = _pinned(variable, 0)
            if text is not None:
                made[macro.name, name] = text
    return made


def _pinned(variable: Variable, depth: int) -> str | None:
    texts = {_fixed_text(value, depth) for value in variable.calls}
    return texts.pop() if len(texts) == 1 else None


def _fixed_text(value: Value, depth: int) -> str | None:
    name = sole_name(tokens(value.text))
    found = value.scope.find(name) if name else None
    if isinstance(found, Bound) and name is not None and name.startswith("arg "):
        return found.text
    if isinstance(found, Bound):
        return _fixed_text(Value(found.text, found.scope, ""), depth + 1) if depth < MOST_CALLS else None
    return _pinned(found, depth + 1) if isinstance(found, Variable) and depth < MOST_CALLS else None


def undecided(found: Mapping[str, str], choices: Mapping[str, Collection[str]]) -> dict[str, str]:
    """Return the arguments of which the proof compares one value alone."""
    return {name: text for name, text in found.items() if len(choices.get(name, ())) < 2}


def _at(root: Element, places: Collection[Place]) -> list[Element]:
    return [element for element in root.iter() if place_of(element.span) in places]


def _text_of(element: Element) -> str:
    """Return all that an element says: tags, attributes and texts."""
    said: list[str] = []
    for one in element.iter():
        said += [one.tag.removeprefix("xacro:"), *(attribute.value for attribute in one.attributes.values())]
        said += [item.text for item in one.content if isinstance(item, Remark) and item.kind != "comment"]
    return " ".join(said)

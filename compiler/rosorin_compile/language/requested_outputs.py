"""Add outputs that a command requests and the description does not list, by the name of their format."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import count
from typing import TYPE_CHECKING

from rosorin_compile.source.diagnostics import Diagnostic, did_you_mean, error
from rosorin_compile.source.rule_registry import OUTPUTS, Rule
from rosorin_compile.source.tree import Instance, Map
from rosorin_compile.source.wording import first_of

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

RULES = (
    Rule("unknown-output", "There is no such output.", "`rosorin-compile print --list` lists the outputs.", OUTPUTS),
)

UNKNOWN = RULES[0].id
_MOST_NAMED = 20
_ASKED = "taken with the defaults of its format; an entry under outputs can say more"


def with_wanted(tree: Map, wanted: Sequence[str], formats: Mapping[str, Format]) -> tuple[Map, list[Diagnostic]]:
    """Return a tree with an entry for each requested output, and the errors about their names."""
    outputs = tree.get("outputs")
    if not wanted or not (outputs is None or isinstance(outputs, Map)):  # the schema reports other types
        return tree, []
    listed = outputs if outputs is not None else Map(tree.span, tree.via)
    new = [name for name in dict.fromkeys(wanted) if name not in listed]
    written = [name for name, format in formats.items() if format.write is not None] if new else []
    unknown = [name for name in new if name not in written]
    robot, span = str(tree.get("robot", "robot")), tree.key_spans.get("robot", tree.span)
    if unknown or not new:
        has = f"its outputs: {first_of(list(listed), _MOST_NAMED)}" if listed else "it lists no outputs"
        if others := [one for one in written if one not in listed]:
            has += f"; with their defaults: {first_of(others, _MOST_NAMED)}"
        errors = []
        for name in unknown:
            guess = did_you_mean(name, [*listed, *written])
            message = f'{robot} has no output "{name}", and there is no format of that name'
            errors.append(error(UNKNOWN, message, None, f"{guess} ({has})" if guess.startswith("did") else has))
        return tree, errors
    section = listed.copied()
    for name in new:
        entry = Map(span, Instance(_ASKED, span, tree.via))
        entry.put("file", _file(formats[name], robot, section), span, span)
        section.put(name, entry, span, span)
    made = tree.copied()
    place = (tree.key_spans["outputs"], tree.value_spans["outputs"]) if "outputs" in tree else (span, span)
    made.put("outputs", section, *place)
    return made, []


def is_listed(entry: object) -> bool:
    """Return True if an entry of outputs is in the description, and was not added for a request."""
    return not (isinstance(entry, Map) and entry.via is not None and entry.via.message == _ASKED)


def _file(format: Format, robot: str, listed: Map) -> str:
    usual = (format.file or f"{{}}.{format.name}").format(re.sub(r"[^\w.-]", "_", robot))
    taken = {str(entry.get("file")).casefold() for entry in listed.values() if isinstance(entry, Map)}
    names = (usual if number == 1 else f"{number}_{usual}" for number in count(1))
    return next(name for name in names if name.casefold() not in taken)

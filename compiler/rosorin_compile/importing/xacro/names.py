"""Find the short names of parts: the prefix of a macro, its mount, and the origin that is the pose of its uses.

If the names of all links and joints of a macro begin with ``${prefix}``, and those of all parts in it do, the part has
short names and its uses state the prefix. If ``${parent}`` is the parent of joints and nothing else, it is the mount.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from rosorin_compile.source.yaml_text import Scalar

from .texts import TEXT
from .tree import (
    NAME,
    Body,
    Call,
    Entry,
    Given,
    Handed,
    Listed,
    Macro,
    Piece,
    Ref,
    Text,
    Variable,
    Whens,
    Xml,
    references,
)

_TELLING = ("prefix", "name", "suffix", "side", "position", "location", "id")
_WORD = re.compile(r"_?[A-Za-z][\w -]{0,30}|_?\d{1,3}")

Role = tuple[Call, str] | str


def name_parts(macros: Sequence[Macro], explicit: set[str]) -> None:
    """Set the prefix, the mount and the origin of each macro that is a part, unless its names stay as they are."""
    explicit = set(explicit)
    for macro in macros:
        macro.prefix = None if macro.name in explicit else _own_prefix(macro)
    for _ in macros:
        for macro in macros:
            is_free = macro.prefix is None and macro.name not in explicit
            macro.relative = _relative(macro) if is_free else None
    unnamed = {macro for macro in macros if macro.body and not macro.body.links and not macro.body.joints}
    while left := {macro for macro in unnamed if any(use.macro not in unnamed for use in macro.body.uses)}:  # type: ignore
        unnamed -= left
    changed = True
    while changed:
        changed = False
        for macro in macros:
            if macro.body is None:
                continue
            if macro.prefix is None and macro.name not in explicit and not macro.body.links and not macro.body.joints:
                macro.prefix = _inner_prefix(macro, unnamed)
                changed = changed or macro.prefix is not None
            if macro.prefix is not None and not all(_composed(use, macro, unnamed) for use in macro.body.uses):
                macro.prefix = None
                explicit.add(macro.name)
                changed = True
    for _ in macros:  # a mount may be handed on to parts in parts
        for macro in macros:
            macro.mount = _mount(macro)
    for macro in macros:
        macro.origin = _origin(macro)


def lead(text: Text) -> tuple[Variable, str] | None:
    """Return the variable that a name begins with, and the plain text behind it."""
    if not text.pieces or not isinstance(text.pieces[0].value, Ref):
        return None
    rest = text.pieces[1].value if len(text.pieces) > 1 and text.pieces[1].kind == TEXT else ""
    return text.pieces[0].value.variable, rest


def without_prefix(pieces: list[Piece], prefix: tuple[Variable, str]) -> list[Piece] | None:
    """Return a text without the prefix of the part that it is in; None if it does not begin with it."""
    if not pieces or not isinstance(pieces[0].value, Ref) or pieces[0].value.variable is not prefix[0]:
        return None
    rest = pieces[1:]
    if not prefix[1]:
        return rest
    if not rest or rest[0].kind != TEXT or not rest[0].value.startswith(prefix[1]):
        return None
    text = rest[0].value.removeprefix(prefix[1])
    return [Piece(TEXT, text), *rest[1:]] if text else rest[1:]


def may_be_own(macro: Macro, short: list[Piece]) -> bool:
    """Return True if a short name may be that of a link or a joint which a part makes, itself or by parts in it."""
    body, prefix = macro.body, macro.prefix
    if body is None or prefix is None or any(_makes_names(use.macro, 0) for use in body.uses):
        return True
    own = (without_prefix(named.name.pieces, prefix) for named in (*body.links, *body.joints))
    return _spelt(short) in [_spelt(one or []) for one in own]


def _spelt(pieces: list[Piece]) -> list[Any]:
    return [piece.value.variable if isinstance(piece.value, Ref) else piece.value for piece in pieces]


def _makes_names(macro: Macro, depth: int) -> bool:
    body = macro.body
    if body is None or depth > len("part in part"):
        return body is not None
    return bool(body.links or body.joints) or any(_makes_names(use.macro, depth + 1) for use in body.uses)


def _own_prefix(macro: Macro) -> tuple[Variable, str] | None:
    named = [*macro.body.links, *macro.body.joints] if macro.body is not None else []
    leads = [lead(one.name) for one in named]
    found = [one for one in leads if one is not None]
    if not found or len(found) < len(leads) or len({one[0] for one in found}) > 1:
        return None
    rest = [one.name.pieces[1:] for one in named]
    if found[0][0] not in macro.variables.values() or not all(rest):
        return None
    parted = all(text.startswith("_") for _, text in found)
    parted = parted and all(len(pieces) > 1 or pieces[0].value != "_" for pieces in rest)
    return found[0][0], "_" if parted else ""


def _relative(macro: Macro) -> Variable | None:
    """Return the parameter that all names of a macro begin with, which is used in nothing but names."""
    body = macro.body
    leads = [lead(one.name) for one in (*body.links, *body.joints)] if body is not None else []
    variables = {one[0] if one is not None else None for one in leads}
    variable = variables.pop() if len(variables) == 1 else None
    if body is None or variable is None or variable not in macro.variables.values():
        return None
    for text, role in texts_of(body):
        if variable not in references(text) or (text.sink == NAME and (lead(text) or (None,))[0] is variable):
            continue
        if isinstance(role, str) or role[0].macro.relative is None:
            return None
        if role[0].macro.variables.get(role[1]) is not role[0].macro.relative:
            return None
    return variable


def _inner_prefix(macro: Macro, unnamed: set[Macro]) -> tuple[Variable, str] | None:
    """Return the prefix of a macro that only calls others."""
    for use in macro.body.uses if macro.body else ():
        if use.macro in unnamed:
            continue
        found = lead(given_for(use, use.macro.prefix[0])) if use.macro.prefix is not None else None
        return (found[0], "") if found is not None and found[0] in macro.variables.values() else None
    return None


def _composed(use: Call, macro: Macro, unnamed: set[Macro]) -> bool:
    """Return True if a part in a part puts the prefix of that part before its own."""
    if use.macro in unnamed:
        return True
    if macro.prefix is not None and use.macro.prefix is None and use.macro.relative is not None:
        return bool(without_prefix(given_for(use, use.macro.relative).pieces, macro.prefix))
    if use.macro.prefix is None or macro.prefix is None:
        return False
    return without_prefix(prefix_of(use), macro.prefix) is not None


def given_for(use: Call, variable: Variable) -> Text:
    """Return what a use gives for a variable of its part, or the default of that."""
    name = next((name for name, one in _parameters(use.macro) if one is variable), "")
    return use.given.get(name) or use.macro.defaults.get(name) or Text([])


def _parameters(macro: Macro) -> list[tuple[str, Variable]]:
    return [*macro.variables.items(), *macro.implicit.items()]


def prefix_of(use: Call) -> list[Piece]:
    """Return what precedes the names of a part with short names."""
    if use.macro.prefix is None:
        return []
    variable, more = use.macro.prefix
    pieces = list(given_for(use, variable).pieces)
    if len(pieces) == 1 and pieces[0].kind == TEXT and re.fullmatch(r"'[^']*'", pieces[0].value):
        pieces = [Piece(TEXT, pieces[0].value[1:-1])]
    if more and pieces and pieces[-1].kind == TEXT:
        return [*pieces[:-1], Piece(TEXT, pieces[-1].value + more)]
    return [*pieces, Piece(TEXT, more)] if more else pieces


def texts_of(body: Body) -> Iterator[tuple[Text, Role]]:
    """Yield the texts of a body, each with its role: a name, the parent of a joint, what a use gives, or nothing."""
    for named in (*body.links, *body.joints, *body.materials):
        yield named.name, "name"
        yield from _of_value(named.entry, named.when)
    for use in body.uses:
        yield from _of_value(None, use.when)
        for name, text in use.given.items():
            yield text, (use, name)
        for entry in use.blocks.values():
            yield from _of_value(entry, ())
    for listed in body.elements:
        yield from _of_value(listed.value, listed.when)
    for variable in body.locals:
        for text in variable.values:
            yield text, ""


def _of_value(value: Any, when: Whens, key: str = "") -> Iterator[tuple[Text, Role]]:
    for on in when:
        yield on.test, ""
    if isinstance(value, Text):
        yield value, "parent" if key == "parent" else ""
    elif isinstance(value, Entry):
        for item in value.items:
            yield from _of_value(item.value, item.when, item.key)
    elif isinstance(value, Listed):
        yield from _of_value(value.value, value.when)
    elif isinstance(value, list):
        for one in value:
            yield from _of_value(one, (), key)
    elif isinstance(value, Xml):
        for _, text in value.attributes:
            yield text, ""
        yield from _of_value(value.content, value.when)
    elif isinstance(value, (Call, Given)):
        call = value if isinstance(value, Call) else value.call
        yield from _of_value([*call.given.values(), *call.blocks.values()], ())


def _mount(macro: Macro) -> Variable | None:
    """Return the parameter that is the parent of joints, and nothing else."""
    body = macro.body
    if body is None or any(_ends_with_mount(named.name) for named in (*body.links, *body.joints)):
        return None
    every: Counter[Variable] = Counter()
    as_mount: Counter[Variable] = Counter()
    for text, role in texts_of(body):
        every.update(references(text))
        variable = text.variable()
        handed_on = not isinstance(role, str) and role[0].macro.mount is not None
        if variable is not None and (
            role == "parent" or (handed_on and dict(_parameters(role[0].macro)).get(role[1]) is role[0].macro.mount)  # type: ignore
        ):
            as_mount[variable] += 1
    found = [one for one in macro.variables.values() if as_mount[one] and as_mount[one] == every[one]]
    return found[0] if len(found) == 1 and found[0] is not (macro.prefix or (None,))[0] else None


def _ends_with_mount(name: Text) -> bool:
    return bool(name.pieces) and name.pieces[-1].kind == TEXT and name.pieces[-1].value.lstrip("_") == "mount"


def _origin(macro: Macro) -> str:
    """Return the block that is the origin of all joints on the mount, and of nothing else."""
    body = macro.body
    if body is None or macro.mount is None:
        return ""
    inserted: Counter[str] = Counter()
    on_mount: Counter[str] = Counter()
    free = 0
    for joint in body.joints:
        handed = [item.value.name for item in joint.entry.items if isinstance(item.value, Handed)]
        inserted.update(handed)
        parents = [item.value for item in joint.entry.items if item.key == "parent"]
        if any(isinstance(parent, Text) and parent.variable() is macro.mount for parent in parents):
            on_mount.update(handed)
            free += not handed
    for use in body.uses:
        for name in (one for entry in use.blocks.values() for one in _blocks_in(entry)):
            inserted[name] += 1
            if use.macro.origin and use.macro.mount and given_for(use, use.macro.mount).variable() is macro.mount:
                on_mount[name] += 1
    for link in body.links:
        inserted.update(_blocks_in(link.entry))
    names = [name for name in inserted if on_mount[name] == inserted[name]]
    return names[0] if len(names) == 1 and not free and macro.block_levels.get(names[0]) == "joint" else ""


def _blocks_in(value: Any) -> Iterator[str]:
    if isinstance(value, Handed):
        yield value.name
    elif isinstance(value, Entry):
        for item in value.items:
            yield from _blocks_in(item.value)
    elif isinstance(value, Listed):
        yield from _blocks_in(value.value)
    elif isinstance(value, list):
        for one in value:
            yield from _blocks_in(one)
    elif isinstance(value, Given):
        yield from _blocks_in(list(value.call.blocks.values()))


def words_apart(uses: Sequence[Call]) -> list[str]:
    """Return a word for each use of one macro that tells it from the others, or nothing.

    First what it makes is called (``front_right`` of ``front_right_wheel``), then what it is given.
    """
    macro = uses[0].macro
    made = [*macro.body.links, *macro.body.joints] if macro.body else []
    rows = [[_named_by(named.name, use) for use in uses] for named in made]
    names = [name for name in macro.variables if any(name in use.given for use in uses)]
    given = {name: [plain_given(use, macro.variables[name]) for use in uses] for name in names}
    telling = [name for word in _TELLING for name in names if word in name]
    rows += [given[name] for name in telling]
    others = [name for name in names if name not in telling]
    pairs = itertools.combinations([*dict.fromkeys(telling), *others], 2)
    more = [*([given[name]] for name in others), *([given[one], given[other]] for one, other in pairs)]
    rows += [["_".join((macro.ours, *row)) if all(row) else "" for row in zip(*each, strict=True)] for each in more]
    return next((row for row in rows if len(set(row)) == len(row) and all(row)), [])


def plain_given(use: Call, variable: Variable) -> str:
    """Return what a use gives for a parameter where that is a word."""
    text = "".join(piece.value if piece.kind == TEXT else "$" for piece in given_for(use, variable).pieces).strip("'")
    return text if _WORD.fullmatch(text) else ""


def _named_by(name: Text, use: Call) -> str:
    """Return a name that a use makes, up to the last piece that it gives."""
    found: list[str] = []
    end = 0
    for piece in name.pieces:
        if piece.kind == TEXT:
            found.append(piece.value)
            continue
        variable = piece.value.variable if isinstance(piece.value, Ref) else None
        if variable not in use.macro.variables.values() or not (text := plain_given(use, variable)):  # type: ignore
            return ""
        found.append(text)
        end = len(found)
    return "".join(found[:end])


def as_key(text: str) -> str:
    """Return a text as the key of an entry, or nothing if YAML would read that as a number."""
    made = re.sub(r"[^\w-]+", "_", text).strip("_")
    return made if made and isinstance(Scalar(made).value, str) else ""

"""Naming: which macros are parts with short names, and which are attached to a mount.

All links and joints of a macro begin with ``${prefix}``, and all parts in it with the same and more: then the part has
short names, and its uses say the prefix. ``${parent}`` is the parent of joints and nothing else: then it is the mount,
and a block that is the origin of those joints is the pose of the use.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections import Counter
from collections.abc import Iterator, Sequence

from .pieces import Body, Call, Entry, Given, Handed, Listed, Macro, Named, Use, Whens, Xml
from .scopes import Bound, Returned, Scope, Value, Variable, is_argument, is_plain, names_of, package_in, sole_name
from .texts import EXPRESSION, EXTENSION, TEXT, Token, source_tree, tokens

Scoped = tuple[Token, Scope]
MAX_DEPTH = 30


def expanded(text: str, scope: Scope, depth: int = 0) -> list[Scoped]:
    """Return the pieces of a text, those of macros that are written out in their place."""
    made: list[Scoped] = []
    for piece in tokens(text):
        if piece.kind == EXTENSION and piece.text.startswith("find ") and "${" in piece.text:
            piece = Token(EXTENSION, f"find {package_in(piece.text, scope)}")
        name = sole_name([piece])
        found = scope.find(name) if name else None
        if isinstance(found, Bound) and depth < 30:
            inner = found.text
            if is_plain(inner) and len(inner) > 1 and inner[0] == "'" == inner[-1]:
                inner = inner[1:-1]
            elif inner in ("true", "false"):  # it is read before it is printed
                inner = inner.capitalize()
            read = is_argument(inner)
            made += [(Token(EXPRESSION, inner), found.scope)] if read else expanded(inner, found.scope, depth + 1)
        else:
            made.append((piece, scope))
    joined: list[Scoped] = []
    for piece, where in made:
        if joined and piece.kind == TEXT == joined[-1][0].kind:
            joined[-1] = (Token(TEXT, joined[-1][0].text + piece.text), where)
        else:
            joined.append((piece, where))
    return joined


def sole_variable(value: Value) -> Variable | None:
    """Return the variable that a value is, and nothing else."""
    pieces = expanded(value.text, value.scope)
    if len(pieces) != 1:
        return None
    name = sole_name([pieces[0][0]])
    found = pieces[0][1].find(name) if name else None
    return found if isinstance(found, Variable) else None


def variables_in(value: Value) -> Iterator[Variable]:
    """Yield the variables that a value uses, each time."""
    for piece, scope in expanded(value.text, value.scope):
        if piece.kind == TEXT:
            continue
        if piece.kind == EXTENSION:
            words = piece.text.split()
            found = scope.find(f"arg {words[1]}") if words[:1] == ["arg"] and len(words) > 1 else None
            if isinstance(found, Variable):
                yield found
            continue
        try:
            tree = source_tree(piece.text)
        except ValueError:
            continue
        yield from _of_tree(tree, scope)


def _of_tree(tree: ast.AST, scope: Scope) -> Iterator[Variable]:
    for name in names_of(tree):
        found = scope.find(name) if name != "__text" else None
        if isinstance(found, Variable):
            yield found
        elif isinstance(found, Bound):
            yield from variables_in(Value(found.text, found.scope, ""))
        elif isinstance(found, Returned):
            for given in found.call.given.values():
                yield from variables_in(given)


def values_of(body: Body) -> Iterator[tuple[Value, str]]:
    """Yield the values of a body, each with what it is: a parent of a joint, what a use gives, or anything."""
    for named in (*body.links, *body.joints, *body.materials):
        yield named.name, "name"
        yield from _whens(named.when)
        for value, key in _of_entry(named.entry):
            yield value, "parent" if key == "parent" else ""
    for use in body.uses:
        yield from _whens(use.when)
        for name, value in use.given.items():
            yield value, f"given {id(use)} {name}"
        for entry in use.blocks.values():
            yield from _of_entry(entry)
    for one in body.elements:
        yield from _whens(one.when)
        yield from _of_xml(one.value)
    for variable in body.locals:
        for value in variable.values:
            if value.scope is body.scope:
                yield value, ""


def _whens(when: Whens) -> Iterator[tuple[Value, str]]:
    for condition in when:
        yield condition.value, ""


def _of_entry(entry: Entry) -> Iterator[tuple[Value, str]]:
    for item in entry.items:
        yield from _whens(item.when)
        yield from _of_any(item.value, item.key)


def _of_any(value: object, key: str) -> Iterator[tuple[Value, str]]:
    if isinstance(value, Value):
        yield value, key
    elif isinstance(value, Entry):
        yield from _of_entry(value)
    elif isinstance(value, Listed):
        yield from _whens(value.when)
        yield from _of_any(value.value, "")
    elif isinstance(value, list):
        for one in value:
            yield from _of_any(one, key)
    elif isinstance(value, Xml):
        yield from _of_xml(value)
    elif isinstance(value, Given):
        for given in value.call.given.values():
            yield given, ""
        for entry in value.call.blocks.values():
            yield from _of_entry(entry)


def _of_xml(node: Xml) -> Iterator[tuple[Value, str]]:
    yield from _whens(node.when)
    for _, value in node.attributes:
        yield value, ""
    for item in node.content:
        if isinstance(item, Value):
            yield item, ""
        elif isinstance(item, Xml):
            yield from _of_xml(item)
        elif isinstance(item, Call):
            for given in item.given.values():
                yield given, ""


def lead(value: Value) -> tuple[Variable, str] | None:
    """Return the variable that a name begins with, and the plain text behind it."""
    pieces = expanded(value.text, value.scope)
    if not pieces or pieces[0][0].kind != EXPRESSION:
        return None
    name = sole_name([pieces[0][0]])
    found = pieces[0][1].find(name) if name else None
    if not isinstance(found, Variable):
        return None
    return found, pieces[1][0].text if len(pieces) > 1 and pieces[1][0].kind == TEXT else ""


def name_parts(macros: Sequence[Macro], explicit: frozenset[str]) -> None:
    """Find the prefix of each macro that is a part, and its mount."""
    for macro in macros:
        macro.prefix = None if macro.name in explicit else _own_prefix(macro)
    nameless = _nameless(macros)
    for _ in macros:
        for macro in macros:
            macro.relative = _relative(macro) if macro.prefix is None and macro.name not in explicit else None
    changed = True
    while changed:
        changed = False
        for macro in macros:
            if macro.body is None:
                continue
            if macro.prefix is None and macro.name not in explicit and not macro.body.links and not macro.body.joints:
                macro.prefix = _inner_prefix(macro, nameless)
                changed = changed or macro.prefix is not None
            if macro.prefix is not None and not all(_composed(use, macro, nameless) for use in macro.body.uses):
                macro.prefix = None
                explicit = explicit | {macro.name}
                changed = True
    for _ in macros:  # a mount may be handed on to parts in parts
        for macro in macros:
            macro.mount = _mount(macro)
    for macro in macros:
        macro.origin = _origin(macro)


def _nameless(macros: Sequence[Macro]) -> set[Macro]:
    """Return the macros that make no link and no joint."""
    made = {macro for macro in macros if macro.body and not macro.body.links and not macro.body.joints}
    changed = True
    while changed:
        left = {macro for macro in made if macro.body and all(use.macro in made for use in macro.body.uses)}
        changed, made = left != made, left
    return made


def _own_prefix(macro: Macro) -> tuple[Variable, str] | None:
    body = macro.body
    if body is None or not (body.links or body.joints):
        return None
    leads = [lead(named.name) for named in (*body.links, *body.joints)]
    if any(one is None for one in leads):
        return None
    found = [one for one in leads if one is not None]
    variable = found[0][0]
    if variable not in macro.variables.values() or any(one[0] is not variable for one in found):
        return None
    texts = [text for _, text in found]
    own = [expanded(named.name.text, named.name.scope)[1:] for named in (*body.links, *body.joints)]
    if not all(own):
        return None
    together = all(text.startswith("_") for text in texts) and all(
        len(pieces) > 1 or pieces[0][0].text != "_" for pieces in own
    )
    return variable, "_" if together else ""


def _relative(macro: Macro) -> Variable | None:
    """Return the parameter that all names of a macro begin with, which is in nothing but names."""
    body = macro.body
    if body is None or not (body.links or body.joints):
        return None
    leads = [lead(named.name) for named in (*body.links, *body.joints)]
    variables = {one[0] for one in leads if one is not None}
    if len(variables) != 1 or None in leads:
        return None
    (variable,) = variables
    if variable not in macro.variables.values():
        return None
    for value, role in values_of(body):
        if variable not in list(variables_in(value)):
            continue
        if value.sink == "name" and (lead(value) or (None,))[0] is variable:
            continue
        if not _is_relative(role, body):
            return None
    return variable


def _is_relative(role: str, body: Body) -> bool:
    words = role.split()
    if words[:1] != ["given"]:
        return False
    use = next((use for use in body.uses if str(id(use)) == words[1]), None)
    return (
        use is not None and use.macro.relative is not None and use.macro.variables.get(words[2]) is use.macro.relative
    )


def lead_of(use: Use) -> str:
    """Return a word for a use: what is given for the beginning of its names, as far as that is plain."""
    macro = use.macro
    variable = macro.relative or next(
        (found[0] for named in (macro.body.links if macro.body else ()) if (found := lead(named.name))), None
    )
    if variable is None or variable not in macro.variables.values():
        return ""
    value = _given(use, variable)
    pieces = expanded(value.text, value.scope)
    return "".join(piece.text for piece, _ in pieces if piece.kind == TEXT).strip("'_")


_TELLING = ("prefix", "name", "suffix", "side", "position", "location", "id")
_WORD = re.compile(r"_?[A-Za-z][\w -]{0,30}|_?\d{1,3}")


def words_apart(uses: Sequence[Use]) -> list[str]:
    """Return words that tell uses of one macro apart, as a person would: nothing where no text does.

    First what they make is called, as far as what they give has a say in it (``front_right`` of ``front_right_wheel``);
    then what they give under a name that is used for that, then what else they give, alone or two of them, behind what
    they are uses of.
    """
    macro = uses[0].macro
    made = [*macro.body.links, *macro.body.joints] if macro.body else []
    found = [[_said_in(named.name, use) for use in uses] for named in made]
    names = [name for name in macro.variables if any(name in use.given for use in uses)]
    given = {name: [_plain_of(use, macro.variables[name]) for use in uses] for name in names}
    telling = [name for word in _TELLING for name in names if word in name]
    found += [given[name] for name in telling]
    others = [name for name in names if name not in telling]
    pairs = itertools.combinations([*dict.fromkeys(telling), *others], 2)
    rows = [*([given[name]] for name in others), *([given[one], given[other]] for one, other in pairs)]
    found += [["_".join((macro.ours, *said)) if all(said) else "" for said in zip(*row, strict=True)] for row in rows]
    return next((words for words in found if len(set(words)) == len(words) and all(words)), [])


def _plain_of(use: Use, variable: Variable) -> str:
    """Return what a use gives for a parameter where that is a word; empty where it is none."""
    text = "".join(
        piece.text if piece.kind == TEXT else "$" for piece, _ in expanded(_given(use, variable).text, use.scope)
    )
    text = text.strip("'")
    return text if _WORD.fullmatch(text) else ""


def _said_in(name: Value, use: Use) -> str:
    """Return a name that a use makes, up to the last thing that it gives; empty where it gives nothing of it."""
    words: list[str] = []
    end = 0
    for piece, scope in expanded(name.text, name.scope):
        if piece.kind == TEXT:
            words.append(piece.text)
            continue
        own = sole_name([piece])
        found = scope.find(own) if own else None
        if not isinstance(found, Variable) or found not in use.macro.variables.values():
            return ""
        text = _plain_of(use, found)
        if not text:
            return ""
        words.append(text)
        end = len(words)
    return "".join(words[:end])


def _inner_prefix(macro: Macro, nameless: set[Macro]) -> tuple[Variable, str] | None:
    """Return the prefix of a macro that only calls others."""
    body = macro.body
    uses = [use for use in body.uses if use.macro not in nameless] if body else []
    for use in uses:
        if use.macro.prefix is None:
            return None
        found = lead(_given(use, use.macro.prefix[0]))
        if found is None or found[0] not in macro.variables.values():
            return None
        return found[0], ""
    return None


def _given(use: Use, variable: Variable) -> Value:
    for name, one in use.macro.variables.items():
        if one is variable:
            if name in use.given:
                return use.given[name]
            default = next((p.default for p in use.macro.parameters if p.name == name), None)
            return Value(default or "", use.scope.top(), "")
    return Value("", use.scope.top(), "")


def prefix_pieces(use: Use) -> list[Scoped]:
    """Return what stands before the names of a part with short names."""
    if use.macro.prefix is None:
        return []
    value = _given(use, use.macro.prefix[0])
    text = value.text
    if is_plain(text) and len(text) > 1 and text[0] == "'" == text[-1]:
        text = text[1:-1]
    pieces = expanded(text, value.scope)
    if use.macro.prefix[1]:
        pieces = [*pieces, (Token(TEXT, use.macro.prefix[1]), value.scope)]
    if len(pieces) > 1 and pieces[-1][0].kind == TEXT == pieces[-2][0].kind:
        pieces[-2:] = [(Token(TEXT, pieces[-2][0].text + pieces[-1][0].text), pieces[-1][1])]
    return pieces


def without_prefix(pieces: list[Scoped], prefix: tuple[Variable, str]) -> list[Scoped] | None:
    """Return a text without the prefix of the part that it stands in; None if it does not begin so."""
    if not pieces:
        return None
    name = sole_name([pieces[0][0]])
    found = pieces[0][1].find(name) if name else None
    if found is not prefix[0]:
        return None
    rest = pieces[1:]
    if not prefix[1]:
        return rest
    if not rest or rest[0][0].kind != TEXT or not rest[0][0].text.startswith(prefix[1]):
        return None
    text = rest[0][0].text.removeprefix(prefix[1])
    return [(Token(TEXT, text), rest[0][1]), *rest[1:]] if text else rest[1:]


def may_be_own(macro: Macro, short: list[Scoped]) -> bool:
    """Say whether a short name may be that of a link or joint which a part makes, itself or by parts in it."""
    body, prefix = macro.body, macro.prefix
    if body is None or prefix is None or any(_makes_names(use.macro, 0) for use in body.uses):
        return True
    named = (without_prefix(expanded(one.name.text, one.name.scope), prefix) for one in (*body.links, *body.joints))
    return [piece for piece, _ in short] in [[piece for piece, _ in one or ()] for one in named]


def _makes_names(macro: Macro, depth: int) -> bool:
    body = macro.body
    if body is None or depth > MAX_DEPTH:
        return body is not None
    return bool(body.links or body.joints) or any(_makes_names(use.macro, depth + 1) for use in body.uses)


def _composed(use: Use, macro: Macro, nameless: set[Macro]) -> bool:
    """Say whether a part in a part has the prefix of that part before its own."""
    if use.macro in nameless:
        return True
    if macro.prefix is not None and use.macro.prefix is None and use.macro.relative is not None:
        value = _given(use, use.macro.relative)
        return bool(without_prefix(expanded(value.text, value.scope), macro.prefix))
    if use.macro.prefix is None or macro.prefix is None:
        return False
    return without_prefix(prefix_pieces(use), macro.prefix) is not None


def _mount(macro: Macro) -> Variable | None:
    """Return the parameter that is nothing but the parent of joints."""
    body = macro.body
    if body is None or any(_is_called(named, "mount") for named in (*body.links, *body.joints)):
        return None
    every: Counter[Variable] = Counter()
    as_mount: Counter[Variable] = Counter()
    for value, role in values_of(body):
        every.update(variables_in(value))
        sole = sole_variable(value)
        if sole is not None and (role == "parent" or _is_mount(role, body)):
            as_mount[sole] += 1
    candidates = [one for one in macro.variables.values() if as_mount[one] and as_mount[one] == every[one]]
    return candidates[0] if len(candidates) == 1 and candidates[0] is not (macro.prefix or (None,))[0] else None


def _is_called(named: Named, name: str) -> bool:
    pieces = expanded(named.name.text, named.name.scope)
    return bool(pieces) and pieces[-1][0].kind == TEXT and pieces[-1][0].text.lstrip("_") == name


def _is_mount(role: str, body: Body) -> bool:
    """Say whether a role is that of what a use gives for the mount of its part."""
    words = role.split()
    if words[:1] != ["given"]:
        return False
    use = next((use for use in body.uses if str(id(use)) == words[1]), None)
    return use is not None and use.macro.mount is not None and use.macro.variables.get(words[2]) is use.macro.mount


def _origin(macro: Macro) -> str:
    """Return the block that is the origin of all joints on the mount, and of nothing else."""
    body = macro.body
    if body is None or macro.mount is None:
        return ""
    inserted: Counter[str] = Counter()
    on_mount: Counter[str] = Counter()
    free = 0
    for joint in body.joints:
        handed = [item.value.parameter.name for item in joint.entry.items if isinstance(item.value, Handed)]
        inserted.update(handed)
        parents = [item.value for item in joint.entry.items if item.key == "parent"]
        if any(isinstance(parent, Value) and sole_variable(parent) is macro.mount for parent in parents):
            on_mount.update(handed)
            free += not handed
    for use in body.uses:
        for entry in use.blocks.values():
            handed = [item.value.parameter.name for item in entry.items if isinstance(item.value, Handed)]
            inserted.update(handed)
            given = next((use.given.get(n) for n, v in use.macro.variables.items() if v is use.macro.mount), None)
            if use.macro.origin and given is not None and sole_variable(given) is macro.mount:
                on_mount.update(handed)
    for named in body.links:
        for item in _handed_in(named.entry):
            inserted[item] += 1
    names = [name for name in inserted if on_mount[name] == inserted[name]]
    return names[0] if len(names) == 1 and not free and macro.block_levels.get(names[0]) == "joint" else ""


def _handed_in(entry: Entry) -> Iterator[str]:
    for item in entry.items:
        values = item.value if isinstance(item.value, list) else [item.value]
        for value in values:
            inner = value.value if isinstance(value, Listed) else value
            if isinstance(inner, Handed):
                yield inner.parameter.name
            elif isinstance(inner, Entry):
                yield from _handed_in(inner)
            elif isinstance(inner, Given):
                for entry in inner.call.blocks.values():
                    yield from _handed_in(entry)

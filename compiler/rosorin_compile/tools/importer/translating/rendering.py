"""Rendering: pieces of a description as the documents of its files, once it is known of which kind each value is.

What nothing uses is left out: rendering is repeated until what is used does not grow any more.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from xml.sax.saxutils import escape

from ....frontend.load import plain_scalar
from ....numbers import exact
from ....xml.markup import Element, Remark
from ..description import _RANK
from ..layout import Expression, Verbatim, cleaned, in_degrees
from .data import Data
from .expressions import Rendering, all_of, folded, negated, usable, written
from .flattened import Flat, Place, place_of
from .naming import Scoped, expanded, lead_of, prefix_pieces, sole_variable, variables_in, without_prefix
from .pieces import Body, Call, Entry, File, Given, Handed, Item, Listed, Macro, Named, Use, Whens, Xml
from .program import Program
from .scopes import (
    ANY,
    ARGUMENT,
    CONDITION,
    FILE,
    FLAG,
    LIST,
    LISTS,
    LOADED,
    LOCAL,
    NAME,
    NUMBER,
    NUMBERS,
    TABLE,
    WORDS,
    XML,
    Scope,
    Value,
    Variable,
    is_plain,
    literal,
    sole_name,
)
from .texts import EXTENSION, TEXT, Token, Unsupported, tokens, words
from .walking import AtTop, InMacro, InProperty

IF = Verbatim("if")
_SHORT = 90
_SOURCE = ("source", "note")


class Documents:
    """The documents of a translation: by file name, with the comments above their entries."""

    def __init__(self) -> None:
        self.files: dict[str, dict[str, Any]] = {}
        self.comments: dict[str, dict[tuple[Any, ...], list[str]]] = {}
        self.elements: dict[tuple[str, str, str], Place] = {}

    def section(self, file: str, key: str) -> dict[str, Any]:
        made: dict[str, Any] = self.files.setdefault(file, {}).setdefault(key, {})
        return made

    def remark(self, file: str, path: tuple[Any, ...], comments: tuple[str, ...]) -> None:
        lines = [line for comment in comments for line in cleaned(comment)]
        if lines:
            self.comments.setdefault(file, {})[path] = lines


class Renderer:
    """Renders one walk."""

    def __init__(self, program: Program, macros: list[Macro], choices: dict[str, list[str]], data: Data) -> None:
        self.program = program
        self.data = data
        self.macros = macros
        self.choices = choices
        self.used: set[Variable] = set()
        self.documents = Documents()
        self.macro: Macro | None = None
        self.shares: dict[str, str] = {}
        self.looks: dict[str, Any] = {}
        self.extra: dict[str, Any] = {}
        self.keys: set[str] = set()
        self.reserved: dict[Macro | None, set[str]] = {}
        self.files_loaded: dict[str, str] = {}

    def render(self) -> Documents:
        """Return the documents."""
        self.reserve()
        before = -1
        while before != len(self.used):
            before = len(self.used)
            self.documents = Documents()
            self.looks, self.shares, self.keys = {}, {}, set()
            for body in (*(file.body for file in self.program.files.values()), *(one.body for one in self.macros)):
                self.macro = body.macro if body else None
                for named in body.materials if body else ():
                    self.material(named, body.file.name)
            for file in self.program.files.values():
                self.file(file)
            for macro in self.macros:
                try:
                    if macro.body is not None:
                        self.part(macro)
                    elif macro.entry is not None or macro.text is not None:
                        self.called(macro)
                except Unsupported as problem:
                    raise InMacro(macro, problem) from None
            self.named_values()
            self.arguments()
            if self.shares:
                self.documents.section(self.program.root.name, "let").update(self.shares)
        return self.documents

    def reserve(self) -> None:
        """Find the parts whose uses are called as what they are given for ``name``; these names are theirs."""
        bodies = [one.body for one in self.macros if one.body is not None]
        groups: list[tuple[Macro | None, list[Use]]] = [(body.macro, body.uses) for body in bodies]
        groups.append((None, [use for file in self.program.files.values() for use in file.body.uses]))
        spoilt: set[Macro] = set()
        for owner, uses in groups:
            self.macro = owner
            seen: dict[str, Macro] = {}
            for use in uses:
                if use.macro.prefix is not None or "name" not in use.macro.variables:
                    continue
                value = use.given.get("name")
                key = str(self.text(Value(value.text, value.scope, NAME, value.span))) if value is not None else ""
                if not key or key in seen or not isinstance(plain_scalar(key), str) or "/" in key:
                    spoilt.add(use.macro)
                    spoilt.update([seen[key]] if key in seen else [])
                seen[key] = use.macro
        for macro in self.macros:
            kind = macro.variables["name"].kind() if "name" in macro.variables else ""
            wanted = macro.body is not None and macro.prefix is None and kind in (WORDS, ANY)
            macro.by_key = wanted and macro not in spoilt and bool(macro.uses)
        for owner, uses in groups:
            self.macro = owner
            values = [use.given["name"] for use in uses if use.macro.by_key]
            self.reserved[owner] = {str(self.text(Value(one.text, one.scope, NAME, one.span))) for one in values}
        self.macro = None

    # Expressions.

    def expressions(self) -> Rendering:
        made = Rendering(self.used.add, self.own_name)
        made.share = self.share
        made.loaded = self.data.name
        return made

    def own_name(self, variable: Variable) -> ast.expr | None:
        """Return what stands for the parameter that is the prefix of the part."""
        prefix = self.macro.prefix if self.macro else None
        if prefix is not None and variable is prefix[0] and not prefix[1]:
            made = ast.Name("prefix", ast.Load())
            made.kind = WORDS  # type: ignore[attr-defined]
            return made
        return None

    def share(self, package: str) -> ast.expr:
        """Return the folder of a package on this machine, by a name."""
        folder = self.program.packages.find(package)
        if folder is None:
            raise Unsupported(f'the package "{package}" is not found')
        name = f"{re.sub(r'[^A-Za-z0-9_]', '_', package)}_share"
        self.shares[name] = str(folder)
        made = ast.Name(name, ast.Load())
        made.kind = WORDS  # type: ignore[attr-defined]
        return made

    def condition(self, when: Whens) -> ast.expr | None:
        """Return the conditions of an entry as one; None where it is always there."""
        nodes = []
        for value, holds in when:
            node = self.expressions().condition(value)
            value_of = folded(node)
            node = ast.Constant(bool(value_of)) if value_of is not None else node
            nodes.append(node if holds else negated(node))
        return all_of(nodes)

    # Values.

    def value(self, value: Value) -> Any:
        """Return a value as ``layout`` takes it."""
        if value.sink in LISTS:
            return self.list_of(value)
        if value.sink in NUMBERS:
            return self.number(expanded(value.text, value.scope), value)
        return self.text(value)

    def number(self, pieces: list[Scoped], value: Value) -> Any:
        sink = value.sink[:-1] if value.sink in LISTS else value.sink
        if all(piece.kind == TEXT for piece, _ in pieces):
            return number_text("".join(piece.text for piece, _ in pieces), sink, value)
        node = self.node_of(pieces, value)
        if sink == "angle":
            constant = folded(node)
            degrees = in_degrees(constant, "deg") if isinstance(constant, (int, float)) else ""
            if degrees:
                return Verbatim(degrees)
        if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
            return number_text(str(node.value), sink, value)
        return Expression(f"${{{written(node)}}}")

    def node_of(self, pieces: list[Scoped], value: Value) -> ast.expr:
        """Return pieces as one expression."""
        try:
            if len(pieces) == 1:
                piece, scope = pieces[0]
                if piece.kind == TEXT:
                    return self.expressions().tree(piece.text, scope)
                return self.expressions().piece(piece, scope, 0)
            return self.expressions().tree(value.text, value.scope)
        except Unsupported as problem:
            problem.span = problem.span or value.span
            raise

    def list_of(self, value: Value) -> Any:
        """Return several numbers."""
        count = int(value.sink[-1])
        parts = _words(expanded(value.text, value.scope))
        if len(parts) == count:
            return [self.number(part, value) for part in parts]
        if len(parts) != 1 or (len(parts[0]) == 1 and parts[0][0][0].kind == TEXT):
            raise Unsupported(f'"{value.text}" is {len(parts)} numbers, not {count}', value.span)
        node = self.node_of(parts[0], value)
        if getattr(node, "kind", "") == WORDS or _is_words(node):
            text = written(node)
            return Expression(f"${{[float(word) for word in split({text})]}}")
        if isinstance(node, ast.List):
            return [self.item(item, value) for item in node.elts]
        return Expression(f"${{{written(node)}}}")

    def item(self, node: ast.expr, value: Value) -> Any:
        constant = folded(node)
        if isinstance(constant, (int, float)) and not isinstance(constant, bool):
            return number_text(str(constant), value.sink[:-1], value)
        return Expression(f"${{{written(node)}}}")

    def text(self, value: Value) -> Any:
        """Return a text with the expressions in it."""
        pieces = expanded(value.text, value.scope)
        prefix = self.macro.prefix if self.macro else None
        if value.sink == NAME and prefix is not None:
            pieces = without_prefix(pieces, prefix) or pieces
        if value.sink == NAME and self.macro and self.macro.mount is not None:
            if sole_variable(value) is self.macro.mount:
                return "mount"
        if value.sink == FILE:
            pieces = self.address(pieces)
        return self.joined(pieces, value)

    def address(self, pieces: list[Scoped]) -> list[Scoped]:
        """Return the name of a file: of a package by its address, whichever way it is written."""
        if pieces and pieces[0][0].kind == TEXT and pieces[0][0].text == "file://":
            pieces = pieces[1:]
        if pieces and pieces[0][0].kind == EXTENSION and pieces[0][0].text.split()[:1] == ["find"]:
            package = pieces[0][0].text.split()[1]
            text, scope = f"package://{package}", pieces[0][1]
            rest = pieces[1:]
            if rest and rest[0][0].kind == TEXT:
                return [(Token(TEXT, text + rest[0][0].text), scope), *rest[1:]]
            return [(Token(TEXT, text), scope), *rest]
        return pieces

    def joined(self, pieces: list[Scoped], value: Value, spelt: Any = lambda text: text) -> Any:
        """Return pieces as one text."""
        made, plain = "", True
        for piece, scope in pieces:
            if piece.kind == TEXT:
                made += spelt(piece.text).replace("${", "$${")
                continue
            node = self.node_of([(piece, scope)], value)
            constant = folded(node)
            if isinstance(constant, str) or (isinstance(constant, int) and not isinstance(constant, bool)):
                made += spelt(str(constant)).replace("${", "$${")
                continue
            plain = False
            made += f"${{{written(node)}}}"
        return made.replace("$${", "${") if plain else Expression(made)

    # Entries.

    def entry(self, entry: Entry, path: tuple[Any, ...] = (), file: str = "") -> Any:
        """Return an entry as ``layout`` takes it; an expression where it is what a named value gives."""
        items = self.items(entry)
        whole = _sole_call(items)
        if whole is not None:
            return Expression(f"${{{self.call(whole)}}}")
        groups: dict[str, list[tuple[Any, ast.expr | None]]] = {}
        for item in items:
            for key, value, when in self.pairs(item, path, file):
                if not (isinstance(when, ast.Constant) and not when.value):
                    groups.setdefault(key, []).append((value, when))
        made: dict[Any, Any] = {}
        for key in sorted(groups, key=lambda one: _RANK.get(one, len(_RANK))):
            self.settle(made, key, groups[key])
        return made

    def items(self, entry: Entry) -> list[Item]:
        """Return the items of an entry; the pose of a block that is the pose of the use is left out."""
        origin = self.macro.origin if self.macro else ""
        return [
            item for item in entry.items if not (item.key == "&" and origin and item.value.parameter.name == origin)
        ]

    def pairs(self, item: Item, path: tuple[Any, ...], file: str) -> list[tuple[str, Any, ast.expr | None]]:
        """Return the keys and values that an item makes, each with its condition."""
        when = self.condition(item.when)
        if isinstance(when, ast.Constant) and not when.value:
            return []
        if isinstance(item.value, Given):
            return [(item.key, self.given(item.value), when)]
        if item.key == "&":
            return self.handed(item.value, when)
        if isinstance(item.value, list):
            found = self.listed(item.value, (*path, item.key), file)
            return [(item.key, found, when)] if found else []
        if isinstance(item.value, Entry):
            return [(item.key, self.entry(item.value, (*path, item.key), file), when)]
        return [(item.key, self.value(item.value) if isinstance(item.value, Value) else item.value, when)]

    def handed(self, handed: Handed, when: ast.expr | None) -> list[tuple[str, Any, ast.expr | None]]:
        """Return what is inserted of a block that is handed to a part as a table."""
        macro = self.macro
        name = handed.parameter.name
        keys = macro.block_keys.get(name, []) if macro else []
        ours = self.block_name(name)
        return [(key, Expression(f"${{get({ours}, '{key}')}}"), when) for key in keys]

    def block_name(self, name: str) -> str:
        return usable(name, lambda _: False)

    def settle(self, made: dict[Any, Any], key: str, found: list[tuple[Any, ast.expr | None]]) -> None:
        """Put a key; one that stands several times under conditions is put as often, each time spelt otherwise."""
        if len(found) == 2 and found[0][1] is not None and found[1][1] is not None:
            if written(found[0][1]) == written(negated(found[1][1])):
                one, other = _node(found[0][0]), _node(found[1][0])
                if one is not None and other is not None:
                    made[key] = Expression(f"${{{written(ast.IfExp(found[0][1], one, other))}}}")
                    return
        if len(found) == 2 and found[0][1] is None and found[1][1] is not None and not isinstance(found[0][0], dict):
            found = found[1:] + found[:1]
        if key in ("xyz", "rpy") and len(found) == 1 and found[0][1] is None and found[0][0] == ["0", "0", "0"]:
            if self.macro is None or self.macro.entry is None:
                return
        for number, (value, when) in enumerate(found):
            spelt: Any = key if not number else Expression(key + "${''}" * number)
            made[spelt] = conditional(value, when)

    def listed(self, items: list[Listed], path: tuple[Any, ...], file: str) -> list[Any]:
        """Return the items of a list."""
        made: list[Any] = []
        for item in items:
            when = self.condition(item.when)
            if isinstance(when, ast.Constant) and not when.value:
                continue
            if isinstance(item.value, Xml):
                value = self.element(item.value)
            elif isinstance(item.value, Given):
                value = self.given(item.value)
            else:
                value = self.entry(item.value, (*path, len(made)), file)
                if isinstance(value, dict):
                    self.settle_look(value, when)
            if file and item.comments:
                self.documents.remark(file, (*path, len(made)), item.comments)
            made.append(conditional(value, when))
        return made

    def settle_look(self, visual: dict[Any, Any], when: ast.expr | None) -> None:
        """Take the name from a material that looks otherwise than the first of that name."""
        name, rgba = visual.get("material"), visual.get("rgba")
        if not isinstance(name, str) or isinstance(name, Expression) or not isinstance(rgba, list):
            return
        if any(isinstance(number, Expression) for number in rgba) or "texture" in visual:
            return
        known = self.looks.setdefault(name, rgba)
        if [float(one) for one in known] != [float(one) for one in rgba]:  # as the reader of URDF settles it
            del visual["material"]

    # Calls of named values.

    def given(self, given: Given) -> Any:
        """Return what a call of a named value gives under a key."""
        entry = given.call.macro.entry
        text = self.call(given.call)
        text = text if entry is not None and len(entry.known()) == 1 else f"{text}.{given.key}"
        return Expression(f"${{{text}{f'[{given.at}]' if given.at >= 0 else ''}}}")

    def call(self, call: Call) -> str:
        """Return the call of a named value as an expression."""
        given = []
        for name, variable in self.parameters(call.macro):
            value = call.given.get(name) or self.default(call.macro, name, call.scope)
            given.append(written(self.argument(value, variable)))
        return f"{call.macro.ours}({', '.join(given)})"

    def parameters(self, macro: Macro) -> list[tuple[str, Variable]]:
        """Return the parameters that a macro uses."""
        return [(n, v) for n, v in (*macro.variables.items(), *macro.implicit.items()) if v in self.used]

    def default(self, macro: Macro, name: str, scope: Scope) -> Value:
        for parameter in macro.parameters:
            if parameter.name == name and parameter.default is not None:
                return Value(parameter.default, self.program.scope, "free", macro.place)
        return Value(f"${{{name}}}", scope, "free", macro.place)

    def argument(self, value: Value, variable: Variable) -> ast.expr:
        """Return a value as it is handed over in an expression."""
        return self.expressions().value(value)

    def called(self, macro: Macro) -> None:
        """Write a macro that is a named value with parameters."""
        before, self.macro = self.macro, macro
        keys = macro.entry.known() if macro.entry else []
        path = ("let", macro.ours)
        value: Any = self.entry(macro.entry or Entry(), path) if macro.text is None else self.text_of(macro)
        if len(keys) == 1 and isinstance(value, dict):
            value = value.get(keys[0], next(iter(value.values()), {}))
        names = ", ".join(variable.ours for _, variable in self.parameters(macro))
        key = f"{macro.ours}({names})"
        self.documents.section(macro.file.name, "let")[key] = value
        self.documents.remark(macro.file.name, ("let", key), macro.comments)
        self.macro = before

    def text_of(self, macro: Macro) -> Any:
        """Return the text that a macro makes among elements that are kept."""
        lines: list[str] = []
        for item in self.merged(macro.text or []):
            lines += self.lines_of(item, "")
        text = "\n".join(lines)
        if self.extra:
            raise Unsupported("a condition in elements that are kept", macro.place)
        return Expression(text) if "${" in text else text

    # Bodies.

    def file(self, file: File) -> None:
        """Write what stands at the top of a file."""
        self.macro = None
        self.body(file.body, file.name, ())
        lets = self.locals(file.body)
        if lets:
            self.documents.section(file.name, "let").update(lets)

    def part(self, macro: Macro) -> None:
        """Write a macro that is a part."""
        self.macro = macro
        file = macro.file.name
        parts = self.documents.section(file, "parts")
        made: dict[str, Any] = {}
        parts[macro.ours] = made
        self.body(macro.body, file, ("parts", macro.ours), made)  # type: ignore[arg-type]
        params = self.params(macro)
        lets = self.locals(macro.body)  # type: ignore[arg-type]
        if macro.body is not None and self.extra:
            lets |= self.extra
        head = {**({"params": params} if params else {}), **({"let": lets} if lets else {})}
        rest = dict(made)
        made.clear()
        made.update({**head, **rest})
        self.documents.remark(file, ("parts", macro.ours), macro.comments)
        self.extra = {}
        self.macro = None

    def body(self, body: Body, file: str, path: tuple[Any, ...], into: dict[str, Any] | None = None) -> None:
        self.extra = {}
        target = into if into is not None else self.documents.files.setdefault(file, {})
        for section, entries in (("links", body.links), ("joints", body.joints)):
            for named in entries:
                with self.at_top(named.element, into):
                    self.named(named, target.setdefault(section, {}), file, (*path, section))
        for use in body.uses:
            with self.at_top(use.element, into):
                self.use(use, target.setdefault("use", {}), file, (*path, "use"))
        for flat in body.flat:
            self.flat(flat, target, file)
        self.elements(body, target, file, path)
        for section in ("links", "joints", "use", "urdf_elements"):
            if section in target and not target[section]:
                del target[section]
        if into is None and self.extra:
            self.documents.section(file, "let").update(self.extra)
            self.extra = {}

    @contextmanager
    def at_top(self, element: Element, into: Any) -> Iterator[None]:
        """Tell what cannot be said of an element at the top of a file."""
        try:
            yield
        except Unsupported as problem:
            if into is not None:
                raise
            raise AtTop(element, problem) from None

    def flat(self, flat: Flat, target: dict[str, Any], file: str) -> None:
        """Write an entry as xacro has expanded it."""
        when = self.condition(flat.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        if flat.section == "urdf_elements":
            target.setdefault(flat.section, []).append(conditional(flat.value, when))
            return
        section = target.setdefault(flat.section, {})
        if flat.name not in section:
            section[flat.name] = conditional(flat.value, when)
            self.documents.remark(file, (flat.section, flat.name), flat.comments)

    def named(self, named: Named, section: dict[Any, Any], file: str, path: tuple[Any, ...]) -> None:
        when = self.condition(named.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        key = self.text(named.name)
        while key in section:
            key = Expression(f"{key}${{''}}")
        value = self.entry(named.entry, (*path, key), file)
        section[key] = conditional(value, when)
        self.documents.elements[file, str(path[-1]), str(key)] = place_of(named.element.span)
        self.documents.remark(file, (*path, key), named.comments)

    def guard(self, name: str, known: list[str], when: Whens, made: list[Any]) -> None:
        """Refuse the values of an argument that would include files which are not here."""
        variable = self.program.arguments.get(name)
        condition = self.condition(when)
        if variable is None or (isinstance(condition, ast.Constant) and not condition.value):
            return
        if known and is_choice(variable):  # only these values are allowed
            return
        self.used.add(variable)
        others = [] if not known else [ast.Compare(ast.Name(variable.ours), [ast.NotIn()], [_list_of(known)])]
        node = all_of([*([condition] if condition is not None else []), *others])
        text = f"there is no file for this {name} here: translate it, and add it to include"
        made.append(conditional(Expression(f"${{error({text!r})}}"), node))

    def elements(self, body: Body, target: dict[str, Any], file: str, path: tuple[Any, ...]) -> None:
        made = target.setdefault("urdf_elements", [])
        for name, known, when, element in body.guards:
            with self.at_top(element, None if body.macro is None else target):
                self.guard(name, known, when, made)
        for item in body.elements:
            when = self.condition(item.when)
            if isinstance(when, ast.Constant) and not when.value:
                continue
            self.documents.remark(file, (*path, "urdf_elements", len(made)), item.comments)
            made.append(conditional(self.element(item.value), when))

    def material(self, named: Named, file: str) -> None:
        name, entry = self.text(named.name), self.entry(named.entry)
        when = self.condition(named.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        section = self.documents.section(file, "materials")
        if isinstance(name, Expression) and self.macro is not None:
            raise Unsupported("a material of a macro", named.element.span)
        if any(name in other.get("materials", ()) for other in self.documents.files.values()):
            return
        if self.macro is not None and (when is not None or any(map(_has_expression, entry.values()))):
            raise Unsupported("a material of a macro", named.element.span)
        section[name] = conditional(entry, when)
        if "rgba" in entry and isinstance(entry["rgba"], list) and not _has_expression(entry["rgba"]):
            self.looks[name] = entry["rgba"]
        self.documents.remark(file, ("materials", name), named.comments)

    # Uses.

    def use(self, use: Use, section: dict[Any, Any], file: str, path: tuple[Any, ...]) -> None:
        """Write a call of a macro that is a part."""
        when = self.condition(use.when)
        if isinstance(when, ast.Constant) and not when.value:
            return
        macro, made = use.macro, {}
        key, prefix = self.key(use)
        made["part"] = macro.ours
        made["prefix"] = prefix
        if macro.mount is not None:
            name = next(name for name, variable in macro.variables.items() if variable is macro.mount)
            value = use.given.get(name) or self.default(macro, name, use.scope)
            made["parent"] = self.text(Value(value.text, value.scope, NAME, value.span))
            made |= self.pose(use)
        given = self.with_of(use)
        if given:
            made["with"] = given
        key = self.free_key(key, section, path, use)
        if prefix is None or prefix == f"{key}_":
            del made["prefix"]
            if prefix is None and key != self.key(use)[0]:
                made["prefix"] = f"{self.key(use)[0]}_"
        section[key] = conditional(made, when)
        self.documents.elements[file, "use", str(key)] = place_of(use.element.span)
        self.documents.remark(file, (*path, key), use.comments)

    def key(self, use: Use) -> tuple[Any, Any]:
        """Return the name of a use, and its prefix; None where that is its name and ``_``."""
        macro = use.macro
        if macro.prefix is None:
            value = use.given.get("name")
            if value is not None:
                key = self.text(Value(value.text, value.scope, NAME, value.span))
                if macro.by_key:
                    return key, ""
                if key and not isinstance(key, Expression):
                    return _as_key(str(key)) or macro.ours, ""
            found = lead_of(use)
            return _as_key(found) or macro.ours, ""
        pieces = prefix_pieces(use)
        if self.macro is not None and self.macro.prefix is not None:
            pieces = without_prefix(pieces, self.macro.prefix) or []
        text = self.joined(pieces, Value("", use.scope, NAME, use.element.span))
        if isinstance(text, Expression):
            tail = pieces[-1][0].text.strip("_") if pieces[-1][0].kind == TEXT else ""
            return _as_key(tail) or macro.ours, text
        if text.endswith("_") and len(text) > 1 and plain_scalar(text[:-1]) == text[:-1]:
            return text[:-1], None
        return _as_key(text.strip("_")) or macro.ours, text

    def free_key(self, key: Any, section: dict[Any, Any], path: tuple[Any, ...], use: Use) -> Any:
        """Return a name that no other use has; those of all files share one set of names."""
        name, number = key, 1
        taken = section if path[0] == "parts" else self.keys
        if use.macro.by_key:
            self.keys.add(key)
            return key
        while name in taken or name in self.reserved.get(self.macro, ()):
            number += 1
            name = f"{key}_{number}"
        if path[0] != "parts":
            self.keys.add(name)
        return name

    def pose(self, use: Use) -> dict[str, Any]:
        """Return the pose of a use: that of the block that is the origin of what hangs on its mount."""
        macro = use.macro
        if not macro.origin or macro.origin not in use.blocks:
            return {}
        made = self.entry(use.blocks[macro.origin])
        if not isinstance(made, dict):
            raise Unsupported("a pose that a macro makes", use.element.span)
        return made

    def with_of(self, use: Use) -> dict[str, Any]:
        """Return what a use gives to its part."""
        macro, made = use.macro, {}
        for name, variable in self.parameters(macro):
            if variable is macro.mount or (macro.prefix and variable is macro.prefix[0] and not macro.prefix[1]):
                continue
            if macro.by_key and name == "name":
                continue
            value = use.given.get(name)
            if value is None and name in macro.variables and self.shadows(macro, name):
                value = self.default(macro, name, use.scope)
            if value is None and name not in macro.variables:
                value = Value(f"${{{name}}}", use.scope, "free", use.element.span)
            if value is not None:
                if variable is macro.relative and self.macro is not None and self.macro.prefix is not None:
                    found = self.text(Value(value.text, value.scope, NAME, value.span))
                else:
                    found = self.of_variable(value, variable)
                if not self.is_default(macro, name, found, variable):
                    made[variable.ours] = found
        for name, entry in use.blocks.items():
            if name != macro.origin:
                made[self.block_name(name)] = self.entry(entry)
        return made

    def said_default(self, macro: Macro, name: str) -> str | None:
        return next((one.default for one in macro.parameters if one.name == name), None)

    def shadows(self, macro: Macro, name: str) -> bool:
        """Say whether the default of a parameter is made of a value that is called as the parameter is."""
        default = self.said_default(macro, name)
        if default is None or is_plain(default):
            return False
        found = variables_in(Value(default, self.program.scope, "free"))
        return any(one.ours == macro.variables[name].ours for one in found)

    def is_default(self, macro: Macro, name: str, found: Any, variable: Variable) -> bool:
        """Say whether a use would say what the part takes by default."""
        default = self.said_default(macro, name)
        if default is None or self.shadows(macro, name):
            return False
        return bool(found == self.of_variable(Value(default, self.program.scope, "free"), variable))

    def of_variable(self, value: Value, variable: Variable, kind: str = "") -> Any:
        """Return a value of a variable as ``layout`` takes it."""
        kind = kind or variable.kind()
        evidence = variable.head().evidence
        if kind == LIST and "angle3" in evidence and not evidence & {"length3", "number3", "number4", "indexed"}:
            value = Value(value.text, value.scope, "angle", value.span)
        elif kind == NUMBER and declared_type(variable) == "angle":
            value = Value(value.text, value.scope, "angle", value.span)
        if LOADED in variable.head().evidence and kind in (WORDS, ANY):
            pieces = self.address(expanded(value.text, value.scope))
            if pieces and pieces[0][0].kind == TEXT:
                begins = self.data.name(pieces[0][0].text, len(pieces) > 1)
                pieces = [(Token(TEXT, begins), pieces[0][1]), *pieces[1:]]
            return self.joined(pieces, value)
        return self.of_kind(value, kind)

    def of_kind(self, value: Value, kind: str) -> Any:
        """Return a value of a kind as ``layout`` takes it."""
        pieces = expanded(value.text, value.scope)
        if all(piece.kind == TEXT for piece, _ in pieces):
            return _literal_of(
                "".join(piece.text for piece, _ in pieces), kind, value, unquoted=not is_plain(value.text)
            )
        parts = _words(pieces)
        if kind == LIST and len(parts) > 1:
            sink = "angle" if value.sink == "angle" else "number"
            return [self.number(part, Value(value.text, value.scope, sink, value.span)) for part in parts]
        if kind in (WORDS, ANY) and len(pieces) > 1:
            return self.joined(pieces, value)
        node = self.node_of(pieces, value)
        table = self.table(node, value)
        if table is not None:
            return table
        if kind == LIST and getattr(node, "kind", "") == WORDS:
            return Expression(f"${{[float(word) for word in split({written(node)})]}}")
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            return node.value
        return Expression(f"${{{written(node)}}}")

    def table(self, node: ast.expr, value: Value) -> Any:
        return None

    # Parameters, named values, arguments.

    def params(self, macro: Macro) -> dict[str, Any]:
        made: dict[str, Any] = {}
        for name, variable in self.parameters(macro):
            if variable is macro.mount or (macro.prefix and variable is macro.prefix[0] and not macro.prefix[1]):
                continue
            if macro.by_key and name == "name":
                continue
            declared: dict[str, Any] = {}
            kind = declared_type(variable)
            if kind:
                declared["type"] = kind
            default = None if self.shadows(macro, name) else self.said_default(macro, name)
            if default is not None:
                declared["default"] = self.of_variable(
                    Value(default, self.program.scope, "free", macro.place), variable
                )
            made[variable.ours] = declared
        for parameter in macro.parameters:
            if parameter.block and parameter.name != macro.origin and parameter.name in macro.block_levels:
                made[self.block_name(parameter.name)] = {"type": "table"}
        return made

    def locals(self, body: Body) -> dict[str, Any]:
        """Return the properties of a macro that it uses."""
        made: dict[str, Any] = {}
        for variable in body.locals:
            if variable in self.used:
                made[variable.ours] = self.defined(variable.definitions, variable)  # type: ignore[attr-defined]
        return made

    def defined(self, definitions: list[tuple[Value, Whens]], variable: Variable) -> Any:
        """Return the value of a property; one that depends on conditions is a choice."""
        if len(definitions) == 1 and not definitions[0][1]:
            value = definitions[0][0]
            return self.mapping_of(value) or self.of_variable(value, variable)
        chosen: ast.expr | None = None
        for value, when in definitions:
            condition = self.condition(when)
            if isinstance(condition, ast.Constant) and not condition.value:
                continue
            node = self.expressions().value(value)
            if condition is None:
                chosen = node
            elif chosen is None:
                chosen = ast.IfExp(condition, node, ast.Constant(None))
            else:
                chosen = _choice(condition, node, chosen)
        if chosen is None:
            return None
        return Expression(f"${{{written(chosen)}}}")

    def mapping_of(self, value: Value) -> Any:
        """Return a table that Python makes (``dict(a=1)``, ``{'a': 1}``) as a mapping; None if it is none."""
        pieces = tokens(value.text)
        if len(pieces) != 1 or pieces[0].kind != "expression":
            return None
        from .expressions import source_tree

        try:
            tree = source_tree(pieces[0].text)
        except ValueError:
            return None
        return self.mapping(tree, value)

    def mapping(self, tree: ast.expr, value: Value) -> Any:
        pairs: list[tuple[Any, ast.expr]] = []
        if isinstance(tree, ast.Dict) and all(isinstance(key, ast.Constant) for key in tree.keys):
            pairs = [(key.value, item) for key, item in zip(tree.keys, tree.values, strict=True)]  # type: ignore
        elif isinstance(tree, ast.Call) and ast.unparse(tree.func) in ("xacro.dotify", "dotify") and tree.args:
            return self.mapping(tree.args[0], value)
        elif (
            isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == "dict" and not tree.args
        ):
            pairs = [(keyword.arg, keyword.value) for keyword in tree.keywords if keyword.arg]
        else:
            return None
        made: dict[str, Any] = {}
        for key, item in pairs:
            inner = self.mapping(item, value)
            if inner is None:
                node = self.expressions().node(item, value.scope, 0)
                inner = _final(node)
            made[str(key)] = inner
        return made

    def named_values(self) -> None:
        """Write the properties that anything uses."""
        self.macro = None
        for name, definitions in self.program.properties.items():
            variable = self.program.scope.names[name]
            if not isinstance(variable, Variable) or variable.where == ARGUMENT or variable not in self.used:
                continue
            file = self.program.property_files[name].name
            found = [(one.value, one.when) for one in definitions]
            try:
                value = self.defined(found, variable)
            except Unsupported as problem:
                raise InProperty(name, problem.reason) from None
            self.documents.section(file, "let")[variable.ours] = value
            self.documents.remark(file, ("let", variable.ours), self.program.property_comments.get(name, ()))

    def arguments(self) -> None:
        """Write the arguments that anything uses."""
        for name, variable in self.program.arguments.items():
            if variable not in self.used:
                continue
            kind = variable.kind()
            declared: dict[str, Any] = {"type": argument_type(variable)}
            given = self.program.given.get(name)
            text = given if given is not None else variable.values[0].text if _own(variable) else None
            if text is not None:
                kind = WORDS if kind in (LIST, TABLE, ANY) else kind
                declared["default"] = self.of_variable(Value(text, self.program.scope, "free"), variable, kind)
            if declared["type"] == "text" and is_choice(variable) and len(self.choices.get(name, ())) > 1:
                declared["one_of"] = list(self.choices[name])
            self.documents.section(self.program.argument_files[name].name, "args")[variable.ours] = declared

    # Elements that are kept as text.

    def element(self, node: Xml) -> Any:
        """Return elements that are kept, as text."""
        lines = self.lines(node, "")
        text = "\n".join(lines)
        text = f"{text}\n" if len(lines) > 1 else text
        return Expression(text) if "${" in text else text

    def lines(self, node: Xml, pad: str) -> list[str]:
        """Return the lines of an element."""
        start = f"<{node.tag}" + "".join(f' {name}="{self.attribute(value)}"' for name, value in node.attributes)
        content: list[str] = []
        plain = True
        for item in self.merged(node.content):
            content += self.lines_of(item, f"{pad}  ")
            plain = plain and isinstance(item, Value)
        if not content:
            return [f"{pad}{start}/>"]
        if plain:
            whole = f"{pad}{start}>{' '.join(line.strip() for line in content)}</{node.tag}>"
            if "\n" not in whole:
                return [whole]
        if len(content) == 1 and len(content[0]) < _SHORT // 2:
            return [f"{pad}{start}>{content[0].strip()}</{node.tag}>"]
        return [f"{pad}{start}>", *content, f"{pad}</{node.tag}>"]

    def lines_of(self, item: Any, pad: str) -> list[str]:
        """Return the lines of what stands in an element."""
        if isinstance(item, Value):
            return [f"{pad}{self.joined(expanded(item.text.strip(), item.scope), item, escape)}"]
        if isinstance(item, Remark):
            return [f"{pad}<!--{item.text.replace('${', '$${')}-->"]
        if isinstance(item, str):
            return [f"{pad}{item}"]
        if isinstance(item, Call):
            return [f"{pad}${{{self.call(item)}}}"]
        return self.lines(item, pad)

    def attribute(self, value: Value) -> str:
        pieces = expanded(value.text, value.scope)
        return str(self.joined(pieces, value, lambda text: escape(text, {'"': "&quot;"})))

    def merged(self, content: list[Any]) -> list[Any]:
        """Return what an element holds, each group under a condition as an expression that gives its text."""
        made: list[Any] = []
        previous: tuple[str, ast.expr] | None = None
        for item in content:
            if not (isinstance(item, Xml) and not item.tag):
                if not (isinstance(item, Value) and not item.text.strip()):
                    made.append(item)
                    previous = None
                continue
            when = self.condition(item.when)
            if isinstance(when, ast.Constant) and not when.value:
                continue
            if when is None:
                made += self.merged(item.content)
                continue
            text = self.group(item)
            if not text:
                continue
            if previous is not None and written(previous[1]) == written(negated(when)):
                made[-1] = f"${{{previous[0]} if {written(previous[1])} else {text}}}"
                previous = None
            else:
                made.append(f"${{{text} if {written(when)} else ''}}")
                previous = (text, when)
        return made

    def group(self, group: Xml) -> str:
        """Return the text of a group as an expression: itself where it is short, else the name of a value."""
        lines: list[str] = []
        for item in self.merged(group.content):
            lines += [] if isinstance(item, Remark) else self.lines_of(item, "")
        lines = [line for line in lines if line.strip()]
        text = "\n".join(lines)
        if not text.strip():
            return ""
        if "${" not in text and len(lines) == 1 and len(text) <= _SHORT:
            return repr(text)
        first = re.search(r"<([A-Za-z_][\w]*)", text)
        wanted = f"{first[1] if first else 'text'}_block"
        for name, known in self.extra.items():
            if known == (Expression(text) if "${" in text else text):
                return name
        name = usable(wanted, lambda one: one in self.extra or one in self.taken())
        self.extra[name] = Expression(text) if "${" in text else text
        return name

    def taken(self) -> set[str]:
        names = {v.ours for v in self.program.scope.names.values() if isinstance(v, Variable)}
        for file in self.documents.files.values():
            names |= {key.partition("(")[0] for key in file.get("let", ())}
        return names


def _list_of(texts: list[str]) -> ast.expr:
    return ast.List([ast.Constant(text) for text in texts], ast.Load())


def _sole_call(items: list[Item]) -> Call | None:
    """Return the call that gives all that an entry has, under several keys; None if there is none such."""
    calls: set[Any] = set()
    for item in items:
        inner = [one for one in item.value] if isinstance(item.value, list) else [item]
        if any(one.when or not isinstance(one.value, Given) for one in inner) or item.when:
            return None
        calls.update(one.value.call for one in inner)
    if len(calls) != 1:
        return None
    (call,) = calls
    keys = [item.key for item in items]
    whole = call.macro.entry is not None and keys == call.macro.entry.known() and len(keys) > 1
    return call if whole else None


def conditional(value: Any, when: ast.expr | None) -> Any:
    """Return a value with its condition."""
    if when is None:
        return value
    condition = Expression(f"${{{written(when)}}}")
    if isinstance(value, dict):
        return {IF: condition, **value}
    return {IF: condition, "value": value}


def number_text(text: str, sink: str, value: Value) -> Any:
    """Return a plain number as it is written. Raises Unsupported for what is none."""
    found = literal(text.strip())
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        raise Unsupported(f'"{text}" is no number', value.span)
    if found == 0:
        return Verbatim("0")
    if sink == "angle":
        degrees = in_degrees(float(found), "deg")
        if degrees:
            return Verbatim(degrees)
        if abs(found) > 6.2832:
            return Verbatim(f"{_digits(text.strip(), found)} rad")
    if sink == "length" and abs(found) > 20:
        return Verbatim(f"{_digits(text.strip(), found)} m")
    return Verbatim(_digits(text.strip(), found))


def _digits(text: str, value: float) -> str:
    text = text.removeprefix("+")
    read = plain_scalar(text)
    fine = isinstance(read, (int, float)) and not isinstance(read, bool) and type(read) in (int, float)
    return text if fine and float(read) == float(value) else exact(value)


def _literal_of(text: str, kind: str, value: Value, unquoted: bool = False) -> Any:
    """Return a plain text as a value of a kind."""
    found = text if unquoted and kind == WORDS else literal(text)
    if kind == FLAG and (isinstance(found, bool) or found in (0, 1)):
        return bool(found)
    if kind == LIST:
        numbers = str(found).split() if isinstance(found, str) else text.split()
        if len(numbers) > 1:
            return [number_text(word, "angle" if value.sink == "angle" else "number", value) for word in numbers]
    if kind == WORDS:
        return (
            text
            if isinstance(found, (int, float, list)) and not isinstance(found, bool)
            else str(text if isinstance(found, bool) else found)
        )
    if isinstance(found, bool):
        return found
    if isinstance(found, (int, float)):
        return number_text(text.strip(), "angle" if value.sink == "angle" else "number", value)
    if isinstance(found, list):
        return text
    return found


def _words(pieces: list[Scoped]) -> list[list[Scoped]]:
    """Return the words of a text, each as its pieces with their scopes."""
    made: list[list[Scoped]] = []
    fresh = True
    for piece, scope in pieces:
        if piece.kind != TEXT:
            if fresh:
                made.append([])
            made[-1].append((piece, scope))
            fresh = False
            continue
        for part in re.split(r"(\s+)", piece.text):
            if not part:
                continue
            if part.isspace():
                fresh = True
                continue
            if fresh:
                made.append([])
            made[-1].append((Token(TEXT, part), scope))
            fresh = False
    return made


def _node(value: Any) -> ast.expr | None:
    """Return a value of a document as an expression; None for a mapping."""
    if isinstance(value, Expression):
        match = re.fullmatch(r"\$\{((?:[^{}'\"]|'[^']*'|\"[^\"]*\")*)\}", value)
        if match is None:
            return None
        return ast.Name(f"({match[1]})", ast.Load())
    if isinstance(value, Verbatim):
        return ast.Name(str(value), ast.Load())
    if isinstance(value, str):
        return ast.Constant(value)
    if isinstance(value, list):
        items = [_node(item) for item in value]
        return None if None in items else ast.List([item for item in items if item is not None], ast.Load())
    return None


def _final(node: ast.expr) -> Any:
    """Return an expression as a value of a document."""
    constant = folded(node)
    if isinstance(constant, bool) or (isinstance(constant, str) and isinstance(node, ast.Constant)):
        return constant
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return Verbatim(exact(node.value))
    if isinstance(node, ast.UnaryOp) and isinstance(node.operand, ast.Constant) and isinstance(constant, (int, float)):
        return Verbatim(exact(constant))
    if isinstance(node, ast.List):
        return [_final(item) for item in node.elts]
    return Expression(f"${{{written(node)}}}")


def _choice(condition: ast.expr, node: ast.expr, other: ast.expr) -> ast.expr:
    """Return a choice; of one whose other is chosen by the opposite of the condition that is just the other."""
    if isinstance(other, ast.IfExp) and isinstance(other.orelse, ast.Constant) and other.orelse.value is None:
        if written(other.test) == written(negated(condition)):
            return ast.IfExp(other.test, other.body, node)
        if isinstance(node, ast.Constant) and node.value is None:
            return other
    return ast.IfExp(condition, node, other)


def _has_expression(value: Any) -> bool:
    if isinstance(value, list):
        return any(map(_has_expression, value))
    return isinstance(value, Expression)


def _is_words(node: ast.expr) -> bool:
    from .expressions import _is_text

    return _is_text(node)


def _as_key(text: str) -> str:
    made = re.sub(r"[^\w-]+", "_", text).strip("_")
    return made if made and isinstance(plain_scalar(made), str) else ""


def _own(variable: Variable) -> bool:
    return bool(variable.values)


def declared_type(variable: Variable) -> str:
    """Return the type of a parameter; empty where anything may come."""
    kind = variable.kind()
    evidence = variable.head().evidence
    if kind == NUMBER:
        dimensions = [one for one in ("length", "angle", "mass") if one in evidence]
        return dimensions[0] if len(dimensions) == 1 and "number" not in evidence else "number"
    if kind == LIST:
        return "list"
    return {FLAG: "boolean", WORDS: "text", TABLE: "table"}.get(kind, "")


def is_choice(variable: Variable) -> bool:
    """Say whether an argument is nothing but compared with texts, so that these are all that it may be."""
    evidence = variable.head().evidence
    compared = {one for one in evidence if one.startswith("=")}
    return "=" not in compared and bool(compared) and not evidence & {NAME, FILE, XML, *NUMBERS, *LISTS, "reckoned"}


def argument_type(variable: Variable) -> str:
    """Return the type of an argument."""
    kind = variable.kind()
    if kind == NUMBER:
        return declared_type(variable)
    return "boolean" if kind == FLAG else "text"


__all__ = ["CONDITION", "LOCAL", "XML", "Documents", "Renderer", "sole_name", "words"]

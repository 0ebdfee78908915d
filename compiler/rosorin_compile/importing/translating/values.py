"""Values: values and entries of a xacro as ``layout`` takes them, once it is known of which kind each is."""

from __future__ import annotations

import ast
import re
from typing import Any

from rosorin_compile.source.numbers import exact
from rosorin_compile.source.yaml_text import Scalar

from ..key_order import default_of_key, in_order
from ..layout import Expression, Verbatim, cleaned, in_degrees
from .blocks import Leaf, inserted, leaves, owner, value_at
from .choices import Alternative, conditional, merged, node_of
from .data import Data
from .expressions import Rendering, all_of, bare, folded, negated, printed, usable, written
from .flattened import Place
from .naming import Scoped, expanded, may_be_own, sole_variable, without_prefix
from .pieces import Call, Entry, Given, Handed, Item, Listed, Macro, Whens, Xml
from .problems import InMacro
from .program import Program
from .scopes import (
    ANY,
    FILE,
    FLAG,
    LIST,
    LISTS,
    LOADED,
    NAME,
    NUMBER,
    NUMBERS,
    RETURNED,
    TABLE,
    WORDS,
    Returned,
    Scope,
    Value,
    Variable,
    is_plain,
    literal,
    sole_name,
)
from .texts import EXPRESSION, EXTENSION, TEXT, Token, Unsupported, scoped_words, source_tree

OWN = "own prefix"
ARGUMENTS = "$(arg)"  # among the macros whose masses and lengths are numbers: the arguments
_DEGREES = {"angle": "deg", "speed": "deg/s"}


class Documents:
    """The documents of a translation: by file name, with the comments above their entries."""

    def __init__(self) -> None:
        self.files: dict[str, dict[str, Any]] = {}
        self.comments: dict[str, dict[tuple[Any, ...], list[str]]] = {}
        self.elements: dict[tuple[str, str, str], Place] = {}
        self.name: Any = ""
        self.plain: dict[tuple[Any, ...], str] = {}  # elements of files and parts without expressions, by place
        self.evaluated: dict[tuple[Any, ...], str] = {}  # those with expressions
        self.said: dict[str, list[str]] = {}  # what became words, by section
        self.asked: dict[str, list[ast.expr | None]] = {}  # on which conditions outputs are asked for something

    def section(self, file: str, key: str) -> dict[str, Any]:
        made: dict[str, Any] = self.files.setdefault(file, {}).setdefault(key, {})
        return made

    def remark(self, file: str, path: tuple[Any, ...], comments: tuple[str, ...]) -> None:
        lines = [line for comment in comments for line in cleaned(comment)]
        if lines:
            self.comments.setdefault(file, {})[path] = lines


class Values:
    """Renders values, entries and calls of named values, in the part ``macro`` or at the top of a file."""

    def element(self, node: Xml) -> Any:
        """Return elements that are kept, as text; those that render files know how (see ``kept``)."""
        raise NotImplementedError

    def __init__(self, program: Program, macros: list[Macro], choices: dict[str, list[str]], data: Data) -> None:
        self.program = program
        self.data = data
        # A part knows its own prefix by this name unless the description has a value that is called so.
        variables = [one for one in program.scope.names.values() if isinstance(one, Variable)]
        self.knows_prefix = all(one.ours != "prefix" for one in variables)
        self.macros = macros
        self.choices = choices
        self.used: set[Variable] = set()
        self.documents = Documents()
        self.macro: Macro | None = None
        self.shares: dict[str, Expression] = {}
        self.vectors_are_texts = False  # of tables: "0 0 1" in YAML
        self.turns = False  # some angles are more than a full turn
        self.plain: frozenset[str] = frozenset()  # macros whose masses and lengths are numbers
        self.lacking = False  # what a named value gives may be nothing
        self.spelt: frozenset[str] = frozenset()  # elements whose text is True or False, by their names or tags
        self.meshes = ""  # put before relative names of meshes
        self.looks: dict[str, Any] = {}
        self.extra: dict[str, Any] = {}
        self.keys: set[str] = set()
        self.told_apart: dict[int, str] = {}  # uses that would be called alike, by what tells them apart
        self.alternatives: dict[tuple[int, str], list[Alternative]] = {}
        self.reserved: dict[Macro | None, set[str]] = {}
        self.files_loaded: dict[str, str] = {}

    def expressions(self) -> Rendering:
        made = Rendering(self.used.add, self.own_name)
        made.share = self.share
        made.loaded = self.data.name
        made.returned = self.returned
        return made

    def returned(self, found: Returned) -> ast.expr:
        """Return what a macro sets for its caller: an entry of what it gives as a named value."""
        text = self.given(Given(found.call, found.key)) if found.key else f"${{{self.call(found.call)}}}"
        return ast.parse(text[2:-1], mode="eval").body

    def own_name(self, variable: Variable) -> ast.expr | None:
        """Return what stands for the parameter that is the prefix of the part."""
        prefix = self.macro.prefix if self.macro else None
        if prefix is not None and self.knows_prefix and variable is prefix[0] and not prefix[1]:
            made = ast.Name("prefix", ast.Load())
            made.kind = WORDS  # type: ignore[attr-defined]
            return made
        return None

    def share(self, package: str) -> ast.expr:
        """Return the folder of a package; one that the description will not find has a name, with its place here."""
        folder = self.program.packages.find(package)
        if folder is None:
            raise Unsupported(f'the package "{package}" is not found')
        made: Any = ast.Call(ast.Name("find", ast.Load()), [ast.Constant(package)], [])
        if not self.data.finds(package):
            made.args.append(ast.Constant(str(folder)))
            name = f"{re.sub(r'[^A-Za-z0-9_]', '_', package)}_share"
            self.shares[name] = Expression(f"${{{written(made)}}}")
            made = ast.Name(name, ast.Load())
        made.kind = WORDS
        return made  # type: ignore[no-any-return]

    def condition(self, when: Whens) -> ast.expr | None:
        """Return the conditions of an entry as one; None where it is always there."""
        nodes = []
        for value, holds in when:
            node = self.expressions().condition(value)
            value_of = folded(node)
            node = ast.Constant(bool(value_of)) if value_of is not None else node
            nodes.append(node if holds else negated(node))
        return all_of(nodes)

    def value(self, value: Value) -> Any:
        """Return a value as ``layout`` takes it."""
        if value.sink in LISTS:
            return self.list_of(value)
        if value.sink == RETURNED:
            return final(self.expressions().value(value))
        if value.sink in NUMBERS:
            return self.number(expanded(value.text, value.scope), value)
        return self.text(value)

    def number(self, pieces: list[Scoped], value: Value) -> Any:
        sink = value.sink[:-1] if value.sink in LISTS else value.sink
        if all(piece.kind == TEXT for piece, _ in pieces):
            return number_text("".join(piece.text for piece, _ in pieces), sink, value)
        node = self.node_of(pieces, value) if len(pieces) == 1 else self.glued(pieces, value)
        if sink in _DEGREES:
            constant = folded(node)
            degrees = in_degrees(constant, _DEGREES[sink]) if isinstance(constant, (int, float)) else ""
            if degrees:
                return Verbatim(degrees)
        if sink != "angle":
            node = bare(node)
        elif self.turns:
            node = ast.BinOp(node, ast.Mult(), ast.Name("rad", ast.Load()))
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

    def glued(self, pieces: list[Scoped], value: Value) -> ast.expr:
        """Return a number that is put together from several pieces, as ``-${width / 2}`` is."""
        try:
            number = self.expressions().number(pieces, 0)
            if number is not None:
                return number
            text = self.expressions().put_together(pieces, 0)
        except Unsupported as problem:
            problem.span = problem.span or value.span
            raise
        return ast.Call(ast.Name("float", ast.Load()), [text], [])

    def list_of(self, value: Value) -> Any:
        """Return several numbers."""
        count = int(value.sink[-1])
        parts = scoped_words(expanded(value.text, value.scope))
        if len(parts) == count:
            return [self.number(part, value) for part in parts]
        if len(parts) != 1 or (len(parts[0]) == 1 and parts[0][0][0].kind == TEXT):
            raise Unsupported(f'"{value.text}" is {len(parts)} numbers, not {count}', value.span)
        node = self.node_of(parts[0], value)
        if getattr(node, "kind", "") == WORDS or _is_words(node):
            return Expression(f"${{numbers({written(node)})}}")
        if isinstance(node, ast.List):
            return [self.item(item, value) for item in node.elts]
        if self.vectors_are_texts and not getattr(node, "is_list", False):
            return Expression(f"${{numbers({written(node)})}}")
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
        if value.sink == NAME and prefix is not None and self.macro is not None:
            short = without_prefix(pieces, prefix)
            pieces = short if short and may_be_own(self.macro, short) else pieces
        mount = self.macro.mount if self.macro and value.sink == NAME else None
        if mount is not None and sole_variable(value) is mount:
            return "mount"
        if value.sink == FILE:
            pieces = self.address(pieces)
        return self.joined(pieces, value)

    def address(self, pieces: list[Scoped]) -> list[Scoped]:
        """Return the name of a file: of a package by its address, whichever way it is written."""
        if pieces and pieces[0][0].kind == TEXT and pieces[0][0].text == "file://":
            pieces = pieces[1:]
        first = pieces[0][0].text if pieces and pieces[0][0].kind == TEXT else "/"
        if self.meshes and "://" not in first and not first.startswith("/"):
            return [(Token(TEXT, f"{self.meshes.rstrip('/')}/{first}"), pieces[0][1]), *pieces[1:]]
        if pieces and pieces[0][0].kind == EXTENSION and pieces[0][0].text.split()[:1] == ["find"]:
            package = pieces[0][0].text.split()[1]
            text, scope = f"package://{package}", pieces[0][1]
            rest = pieces[1:]
            if rest and rest[0][0].kind == TEXT:
                return [(Token(TEXT, text + rest[0][0].text), scope), *rest[1:]]
            return [(Token(TEXT, text), scope), *rest]
        return pieces

    def with_own_prefix(self, pieces: list[Scoped]) -> list[Scoped]:
        """Return a text in which what stands before all names of the part is called so."""
        prefix = self.macro.prefix if self.macro else None
        if (
            prefix is None
            or not self.knows_prefix
            or not prefix[1]
            or (prefix[0] in self.used and prefix[0].ours == "prefix")
        ):
            return pieces
        made: list[Scoped] = []
        for piece, scope in pieces:
            before = made[-1] if made else None
            name = sole_name([before[0]]) if before is not None and before[0].kind == EXPRESSION else None
            of_part = name is not None and before is not None and before[1].find(name) is prefix[0]
            if of_part and piece.kind == TEXT and piece.text.startswith(prefix[1]):
                made[-1] = (Token(OWN, ""), scope)
                made.append((Token(TEXT, piece.text.removeprefix(prefix[1])), scope))
            else:
                made.append((piece, scope))
        return made

    def joined(self, pieces: list[Scoped], value: Value, spelt: Any = lambda text: text) -> Any:
        """Return pieces as one text."""
        made, plain = "", True
        for piece, scope in self.with_own_prefix(pieces):
            if piece.kind == TEXT:
                made += spelt(piece.text).replace("${", "$${")
                continue
            if piece.kind == OWN:
                made, plain = f"{made}${{prefix}}", False
                continue
            node = self.node_of([(piece, scope)], value)
            if piece.kind == EXPRESSION:
                node = printed(node)
            if isinstance(node, ast.List) or getattr(node, "kind", "") == LIST:
                node = ast.Call(ast.Name("join", ast.Load()), [ast.Constant(" "), node], [])
            constant = folded(node)
            if isinstance(constant, str) or (isinstance(constant, int) and not isinstance(constant, bool)):
                made += spelt(str(constant)).replace("${", "$${")
                continue
            plain = False
            made += f"${{{written(node)}}}"
        return made.replace("$${", "${") if plain else Expression(made)

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
        for key in in_order(groups):
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
            return [(item.key, self.given(item.value), self.given_at_all(item.value, when))]
        if item.key == "&":
            return self.handed(item.value, when)
        whole = _whole_list(item)
        if whole is not None:
            return [(item.key, self.given(whole), when)]
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
        known = leaves(macro, name, self.program.scope) if macro else None
        if known is not None:
            return [(key, value, when) for key, value in _by_key(known).items()]
        keys = macro.block_keys.get(name, []) if macro else []
        ours = self.block_name(name)
        return [(key, Expression(f"${{get({ours}, '{key}')}}"), when) for key in keys]

    def block_name(self, name: str) -> str:
        return usable(name, lambda _: False)

    def settle(self, made: dict[Any, Any], key: str, found: list[tuple[Any, ast.expr | None]]) -> None:
        """Put a key; one that stands several times under conditions is put as often, each time spelt otherwise."""
        chosen = merged(key, found) if len(found) > 1 else None
        if chosen is not None:
            made[key] = chosen
            return
        if len(found) == 2 and found[0][1] is None and found[1][1] is not None and not isinstance(found[0][0], dict):
            found = found[1:] + found[:1]
        is_named = self.macro is not None and self.macro.entry is not None
        if key in ("xyz", "rpy") and found == [(["0", "0", "0"], None)] and not is_named:
            return
        if is_named and len(found) > 1:
            raise Unsupported(f"several {key} on conditions that do not part them")
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
                    self.settle_look(value)
            if file and item.comments:
                self.documents.remark(file, (*path, len(made)), item.comments)
            made.append(conditional(value, when))
        return made

    def settle_look(self, visual: dict[Any, Any]) -> None:
        """Take the name from a material that looks otherwise than the first of that name."""
        name, rgba = visual.get("material"), visual.get("rgba")
        if not isinstance(name, str) or isinstance(name, Expression) or not isinstance(rgba, list):
            return
        if any(isinstance(number, Expression) for number in rgba) or "texture" in visual:
            return
        known = self.looks.setdefault(name, rgba)
        if [float(one) for one in known] != [float(one) for one in rgba]:  # as the reader of URDF settles it
            del visual["material"]

    def given(self, given: Given) -> Any:
        """Return what a call of a named value gives under a key."""
        entry = given.call.macro.entry
        text = self.call(given.call)
        if entry is not None and entry.may_lack(given.key):
            text = f"get({text}, '{given.key}')"
        else:
            text = text if entry is not None and len(entry.names()) == 1 else f"{text}.{given.key}"
        return Expression(f"${{{text}{f'[{given.at}]' if given.at >= 0 else ''}}}")

    def given_at_all(self, given: Given, when: ast.expr | None) -> ast.expr | None:
        """Return the condition on which what a call of a named value gives is there."""
        entry = given.call.macro.entry
        if not self.lacking or given.at >= 0 or entry is None or not entry.may_lack(given.key):
            return when
        found = ast.parse(self.given(given)[2:-1], mode="eval").body
        return all_of([*([when] if when is not None else []), ast.Compare(found, [ast.NotEq()], [ast.Constant(None)])])

    def call(self, call: Call) -> str:
        """Return the call of a named value as an expression."""
        given = []
        for name, variable in self.parameters(call.macro):
            value = call.given.get(name) or self.default(call.macro, name, call.scope)
            node = self.expressions().value(value)
            if variable.kind() == WORDS and isinstance(node, ast.List) and is_plain(value.text):
                node = ast.Constant(value.text)  # several numbers, but taken for a text
            elif variable.kind() == LIST and isinstance(node, ast.Constant) and isinstance(node.value, str):
                node = self.expressions().tree(node.value, value.scope)
            given.append(written(node))
        for name in inserted(call.macro):
            known = self.leaves_of(call.macro, name)
            given += [written(self.handed_over(call, call.blocks[name], leaf)) for leaf in known]
        return f"{call.macro.ours}({', '.join(given)})"

    def leaves_of(self, macro: Macro, block: str) -> list[Leaf]:
        """Return the parameters that stand for a block of a named value."""
        found = leaves(macro, block, self.program.scope)
        if found is None:
            raise InMacro(macro, Unsupported(f'what is handed over as "{block}" has no word as a value', macro.place))
        return found

    def handed_over(self, call: Call, entry: Entry, leaf: Leaf) -> ast.expr:
        """Return what a call of a named value gives for a parameter that is of a block."""
        node = node_of(self.leaf(entry, leaf))
        if node is None:
            reason = f'what is handed over as "{leaf.name}" has no word as a value'
            raise InMacro(call.macro, Unsupported(reason, call.element.span))
        return node

    def leaf(self, entry: Entry, leaf: Leaf) -> Any:
        """Return what a block says for a parameter."""
        found = value_at(entry, leaf.path)
        if isinstance(found, Handed):
            outer = owner(found.scope)
            known = leaves(outer, found.parameter.name, self.program.scope) if outer else None
            name = next((one.name for one in known or () if one.path == leaf.path), "")
            return Expression(f"${{{name}}}") if name else default_of(leaf)
        if isinstance(found, Entry):
            return self.entry(found)
        if isinstance(found, Given):
            return self.given(found)
        if isinstance(found, list):
            return self.listed(found, (), "")
        return self.value(found) if found is not None else default_of(leaf)

    def parameters(self, macro: Macro) -> list[tuple[str, Variable]]:
        """Return the parameters that a macro uses."""
        return [(n, v) for n, v in (*macro.variables.items(), *macro.implicit.items()) if v in self.used]

    def default(self, macro: Macro, name: str, scope: Scope) -> Value:
        for parameter in macro.parameters:
            if parameter.name == name and parameter.default is not None:
                return Value(parameter.default, self.program.scope, "free", macro.place)
        return Value(f"${{{name}}}", scope, "free", macro.place)

    def of_variable(self, value: Value, variable: Variable, kind: str = "") -> Any:
        """Return a value of a variable as ``layout`` takes it."""
        kind = kind or variable.kind()
        table = self.mapping_of(value) if kind in (TABLE, ANY) else None
        if table is not None:
            return table
        evidence = variable.head().evidence
        if (kind == LIST and "angle3" in evidence and not evidence & {"length3", "number3", "number4", "indexed"}) or (
            kind == NUMBER and declared_type(variable) == "angle"
        ):
            value = Value(value.text, value.scope, "angle", value.span)
        if LOADED in variable.head().evidence and kind in (WORDS, ANY):
            pieces = self.address(expanded(value.text, value.scope))
            if pieces and pieces[0][0].kind == TEXT:
                begins = self.data.name(pieces[0][0].text, len(pieces) > 1)
                pieces = [(Token(TEXT, begins), pieces[0][1]), *pieces[1:]]
            return self.joined(pieces, value)
        if FILE in evidence and kind in (WORDS, ANY):
            pieces = expanded(value.text, value.scope)
            if len(pieces) > 1:
                return self.joined(self.address(pieces), value)
        return self.of_kind(value, kind)

    def of_kind(self, value: Value, kind: str) -> Any:
        """Return a value of a kind as ``layout`` takes it."""
        pieces = expanded(value.text, value.scope)
        if all(piece.kind == TEXT for piece, _ in pieces):
            return _literal_of(
                "".join(piece.text for piece, _ in pieces), kind, value, unquoted=not is_plain(value.text)
            )
        parts = scoped_words(pieces)
        if kind == LIST and len(parts) > 1:
            sink = "angle" if value.sink == "angle" else "number"
            return [self.number(part, Value(value.text, value.scope, sink, value.span)) for part in parts]
        if kind in (WORDS, ANY) and len(pieces) > 1:
            return self.joined(pieces, value)
        node = self.glued(pieces, value) if kind == NUMBER and len(pieces) > 1 else self.node_of(pieces, value)
        if kind == LIST and getattr(node, "kind", "") == WORDS:
            return Expression(f"${{numbers({written(node)})}}")
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            return node.value
        if kind == NUMBER and isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
            return number_text(str(node.value), "angle" if value.sink == "angle" else "number", value)
        if kind == NUMBER and value.sink != "angle":
            node = bare(node)
        return Expression(f"${{{written(node)}}}")

    def mapping_of(self, value: Value) -> Any:
        """Return a table that Python makes (``dict(a=1)``, ``{'a': 1}``) as a mapping; None if it is none."""
        pieces = expanded(value.text, value.scope)
        if len(pieces) != 1 or pieces[0][0].kind != EXPRESSION:
            return None
        (piece, scope), *_ = pieces
        try:
            tree = source_tree(piece.text)
        except ValueError:
            return None
        return self.mapping(tree, Value(piece.text, scope, value.sink, value.span))

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
                inner = final(node)
            made[str(key)] = inner
        return made


def _by_key(known: list[Leaf]) -> dict[str, Any]:
    """Return the names of parameters where they stand in an entry."""
    made: dict[str, Any] = {}
    for leaf in known:
        inner = made
        for key in leaf.path[:-1]:
            inner = inner.setdefault(key, {})
        inner[leaf.path[-1]] = Expression(f"${{{leaf.name}}}")
    return made


def default_of(leaf: Leaf) -> Any:
    """Return what a block is taken to say that says nothing."""
    return [Verbatim(exact(number)) for number in default_of_key(leaf.path[-1])]


def _sole_call(items: list[Item]) -> Call | None:
    """Return the call that gives all that an entry has, under several keys; None if there is none such."""
    calls: set[Any] = set()
    for item in items:
        inner: list[Any] = list(item.value) if isinstance(item.value, list) else [item]
        if any(one.when or not isinstance(one.value, Given) for one in inner) or item.when:
            return None
        calls.update(one.value.call for one in inner)
    if len(calls) != 1:
        return None
    (call,) = calls
    keys = [item.key for item in items]
    whole = call.macro.entry is not None and keys == call.macro.entry.names() and len(keys) > 1
    return call if whole else None


def _whole_list(item: Item) -> Given | None:
    """Return the call that gives a list, all of it and nothing else; None if there is none such."""
    if not isinstance(item.value, list) or not isinstance(item.value[0].value, Given):
        return None
    first = item.value[0].value
    entry = first.call.macro.entry
    made = next((one.value for one in entry.items if one.key == item.key), ()) if entry else ()
    wanted = [Given(first.call, item.key, index) for index in range(len(made))]
    found = [one.value for one in item.value if not one.when]
    return Given(first.call, item.key) if found == wanted and len(found) == len(item.value) else None


def number_text(text: str, sink: str, value: Value) -> Any:
    """Return a plain number as it is written. Raises Unsupported for what is none."""
    found = literal(text.strip())
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        raise Unsupported(f'"{text}" is no number', value.span)
    if found == 0:
        return Verbatim("0")
    if sink in _DEGREES:
        degrees = in_degrees(float(found), _DEGREES[sink])
        if degrees:
            return Verbatim(degrees)
        if sink == "angle" and abs(found) > 6.2832:
            return Verbatim(f"{_digits(text.strip(), found)} rad")
    if sink == "length" and abs(found) > 20:
        return Verbatim(f"{_digits(text.strip(), found)} m")
    return Verbatim(_digits(text.strip(), found))


def _digits(text: str, value: float) -> str:
    text = text.removeprefix("+")
    read = Scalar(text).value
    fine = isinstance(read, (int, float)) and not isinstance(read, bool) and type(read) in (int, float)
    return text if fine and float(read) == float(value) else exact(value)


def _literal_of(text: str, kind: str, value: Value, unquoted: bool = False) -> Any:
    """Return a plain text as a value of a kind."""
    found = text if unquoted and kind == WORDS else literal(text)
    if kind == FLAG and (isinstance(found, bool) or found in (0, 1)):
        return bool(found)
    if kind == FLAG and found in ("true", "True", "false", "False"):  # quoted; a condition reads it
        return found in ("true", "True")
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


def final(node: ast.expr) -> Any:
    """Return an expression as a value of a document."""
    constant = folded(node)
    if isinstance(constant, bool) or (isinstance(constant, str) and isinstance(node, ast.Constant)):
        return constant
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return Verbatim(exact(node.value))
    if isinstance(node, ast.UnaryOp) and isinstance(node.operand, ast.Constant) and isinstance(constant, (int, float)):
        return Verbatim(exact(constant))
    if isinstance(node, ast.List):
        return [final(item) for item in node.elts]
    return Expression(f"${{{written(node)}}}")


def has_expression(value: Any) -> bool:
    """Say whether anything in a list of values is evaluated."""
    if isinstance(value, list):
        return any(map(has_expression, value))
    return isinstance(value, Expression)


def _is_words(node: ast.expr) -> bool:
    from .expressions import _is_text

    return _is_text(node)


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

"""Run xacro with symbols for its arguments and for the parameters of its macros.

The xacro library executes the file, so that scopes, lazy evaluation, includes and namespaces are exactly those of
xacro. Three things are different. The value of an expression is a ``Symbol``: a formula, with an example of its value.
A condition that depends on an argument stays in the document, with the elements of its branch. The call of a macro that
becomes a part stays in the document, and the body of the macro is evaluated once, with symbols for its parameters.
What the plan gives up is expanded as xacro does it. This module runs in the child process.
"""

from __future__ import annotations

import ast
import math
import os
from importlib import import_module
from typing import Any

from . import child
from .answer import answer_of
from .child import Expansion, causes
from .conditions import ChosenFiles, Conditions
from .macro_calls import COMMENTS, MARK, Calls, place_key
from .symbols import (
    TOKEN,
    UNKNOWN,
    Evaluator,
    Failed,
    Restart,
    Symbol,
    as_printed,
    example_of,
    is_known,
    join,
    names_in,
    node_of,
    parts_of,
)

MAX_RUNS = 60
_CONSTANTS = ("pi", "e", "tau", "inf", "nan")


def main() -> None:
    """Answer one request with the program of a file."""
    child.main(lambda request: Program(request).program())


class Program(Expansion):
    """A run of a file with symbols. ``plan``: macros to expand (by place), values of arguments, implicit parameters."""

    def __init__(self, request: dict[str, Any]) -> None:
        super().__init__(request)
        self.inlined: dict[str, str] = dict(request["inlined"])  # places of macros, with the reason
        self.fixed: dict[str, list[str]] = dict(request["fixed"])
        self.implicit: dict[str, set[str]] = {key: set(names) for key, names in request["implicit"].items()}
        self.shapes: dict[str, dict[tuple[str, str], str]] = {}  # of the blocks of macros
        self.plain: set[str] = set(request["plain"])  # places of properties that are no named values

    def program(self) -> dict[str, Any]:
        """Return the program of the file, or the error."""
        xacro = self.xacro = import_module("xacro")
        self.prepare(xacro)
        self.patch(xacro)
        document: Any = None
        for _ in range(MAX_RUNS):
            self.reset()
            try:
                document = self.expanded(xacro, {})
                break
            except Restart:
                continue
            except Exception as problem:
                chain = list(causes(problem))
                if any(isinstance(one, Restart) for one in chain):
                    continue
                failed = next((one for one in chain if isinstance(one, Failed)), None)
                if failed is None or not self.blame(failed.node, str(failed)):
                    return {"error": str(failed or problem) or repr(problem), "line": 0}
        if document is None:
            return {"error": "too much of it cannot be translated"}
        return answer_of(self, document)

    def reset(self) -> None:
        self.tokens: list[Symbol] = []
        self.arguments: dict[str, dict[str, Any]] = {}
        self.variables: dict[str, dict[str, Any]] = {}
        self.defined: dict[str, tuple[str, Any]] = {}
        self.bound: dict[tuple[int, str], tuple[Any, Any]] = {}
        self.tables: list[Any] = []  # of ``bound``, so that their ids stay
        self.candidates: dict[str, list[Any]] = {}
        self.macro_calls, self.conditions, self.chosen = Calls(self), Conditions(self), ChosenFiles(self)
        self.xacro.all_includes[:] = []
        for name, text in self.given.items():
            if name not in self.fixed:
                self.declare(name, text, None, given=True)

    def blame(self, node: ast.AST, reason: str) -> bool:
        """Give up what a formula depends on: the macros whose parameters it has, else its arguments."""
        found = False
        variables = [self.variables[name] for name in names_in(node) if name in self.variables]
        for one in variables:
            key = one["owner"].rpartition(" ")[0]
            if key and key not in self.inlined:
                self.inlined[key] = reason
                found = True
        for one in variables if not found else ():
            if one["kind"] == "argument" and one["name"] not in self.fixed:
                self.fixed[one["name"]] = [str(one["value"]), reason]
                found = True
            elif one["kind"] == "let" and "node" in one:
                found = self.blame(one["node"], reason) or found
        return found

    # Values.

    def variable(self, kind: str, name: str, value: Any, known: bool, **more: Any) -> Symbol:
        key = f"v{len(self.variables)}_"
        self.variables[key] = {"id": key, "kind": kind, "name": name, "value": value, "owner": "", **more}
        return Symbol(ast.Name(key, ast.Load()), value, known, self)

    def joined(self, text: str) -> Any:
        """Return a text with tokens as a symbol."""
        parts = TOKEN.split(text)
        if len(parts) == 1:
            return text
        pieces: list[Any] = [self.tokens[int(part)] if index % 2 else part for index, part in enumerate(parts)]
        pieces = [piece for piece in pieces if piece != ""]
        if len(pieces) == 1:
            return pieces[0]
        examples = [example_of(piece) for piece in pieces]
        value = UNKNOWN if any(one is UNKNOWN for one in examples) else "".join(map(str, examples))
        return Symbol(join(map(as_printed, pieces)), value, all(map(is_known, pieces)), self)

    def literal(self, value: Any) -> Any:
        """Return the value of a text, as xacro takes it for that of a property."""
        own = self.own_literal
        if not isinstance(value, Symbol):
            return own(value)
        made = own(value.value) if isinstance(value.value, str) else value.value
        if isinstance(made, str) and made != value.value:  # without the quotes around it
            first, *others = parts_of(value.node)
            if not others:
                return value
            *inner, last = others
            parts = [ast.Constant(first.value[1:]), *inner, ast.Constant(last.value[:-1])]
            return Symbol(join(parts), made, value.known, self)
        if made is value.value or isinstance(made, str):
            return value
        kind = "__flag" if isinstance(made, bool) else "__number"
        return Symbol(ast.Call(ast.Name(kind), [value.node], []), made, value.known, self)

    def note_comparison(self, items: list[Any]) -> None:
        """Record the values that an argument is compared with: they are used to verify the translation."""
        texts = [
            one for item in map(example_of, items) for one in (item if isinstance(item, (list, tuple)) else [item])
        ]
        for item in items:
            for name in names_in(item.node) if isinstance(item, Symbol) and not item.known else ():
                self.candidates.setdefault(name, []).extend(
                    one for one in texts if isinstance(one, (str, int, float)) and not isinstance(one, bool)
                )

    # Arguments.

    def declare(self, name: str, text: Any, node: Any, given: bool = False, environment: bool = False) -> None:
        if name in self.arguments:
            self.arguments[name]["place"] = self.arguments[name]["place"] or getattr(node, MARK, None)
            return
        example = example_of(text)
        place, comments = getattr(node, MARK, None), getattr(node, COMMENTS, [])
        symbol = self.variable("argument", name, str(example), False, default=node_of(text), place=place)
        made = self.variables[symbol.node.id]  # type: ignore[attr-defined]
        made |= {"comments": comments, "environment": environment, "given": given}
        self.arguments[name] = made

    def argument(self, name: str) -> Any:
        if name in self.fixed:
            self.fixed[name] = self.fixed[name][:2]
            return self.fixed[name][0]
        if name not in self.arguments:
            raise import_module("xacro.substitution_args").ArgException(name)
        made = self.arguments[name]
        return Symbol(ast.Name(made["id"], ast.Load()), made["value"], False, self)

    def extension(self, text: str, symbols: Any) -> Any:
        """Return the value of $(...)."""
        kind, _, rest = text.strip().partition(" ")
        rest = rest.strip()
        named = self.joined(rest)
        if kind != "eval" and not is_known(named):
            raise Failed(f"$({kind}) cannot be translated", named.node)
        rest = str(example_of(named)) if kind != "eval" else rest
        if kind == "arg":
            return self.argument(rest)
        if kind == "eval":
            return Evaluator(self, symbols, arguments=True).eval(ast.parse(rest.strip(), mode="eval").body)
        if kind == "find":
            return Symbol(ast.Call(ast.Name("find"), [ast.Constant(rest)], []), self.share(rest), True, self)
        if kind in ("env", "optenv"):
            name, _, default = rest.partition(" ")
            if kind == "env" and name not in os.environ:
                return self.own_extension(f"$({text})")
            if name not in self.fixed:
                self.declare(name, os.environ.get(name, default.strip()), None, environment=True)
            return self.argument(name)
        return self.own_extension(f"$({kind} {rest})".replace(" )", ")"))

    def eval_text(self, text: str, symbols: Any, inner: bool = False) -> Any:
        """Return the value of a text, as xacro does."""
        xacro, results = self.xacro, []
        lexer = xacro.QuickLexer(xacro.LEXER)
        lexer.lex(text)
        while lexer.peek():
            kind, found = lexer.peek()[0], lexer.next()[1]
            if kind == lexer.EXPR:
                expression = self.eval_text(found[2:-1], symbols, inner=True)
                try:
                    tree = ast.parse(expression.strip(), mode="eval").body
                    results.append(Evaluator(self, symbols).eval(tree))
                except (Restart, Failed):
                    raise
                except Exception as problem:
                    suffix = f"{os.linesep}when evaluating expression '{found[2:-1]}'"
                    raise xacro.XacroException(exc=problem, suffix=suffix) from problem
            elif kind == lexer.EXTENSION:
                results.append(self.extension(self.eval_text(found[2:-1], symbols, inner=True), symbols))
            else:
                results.append(found[1:] if kind == lexer.DOLLAR_DOLLAR_BRACE else found)
        if inner:
            return "".join(map(str, results))
        if len(results) == 1:
            return self.joined(results[0]) if isinstance(results[0], str) else results[0]
        return self.joined("".join(map(str, results)))

    # Properties.

    def read(self, table: Any, name: str, own: bool = False) -> Any:
        """Return the value of a name: a global name of xacro, a property or a parameter."""
        xacro, holder = self.xacro, table
        while isinstance(holder, xacro.Table) and not dict.__contains__(holder, name):
            holder = holder.parent
        if not isinstance(holder, xacro.Table) or (isinstance(holder, xacro.NameSpace) and holder.parent == {}):
            if name not in holder:
                raise NameError(f"name '{name}' is not defined")
            value = holder[name]
            if name in _CONSTANTS:
                return Symbol(ast.Name(name, ast.Load()), value, True, self)
            return value
        value = self.named(holder, name)
        for macro in reversed(self.macro_calls.building) if not own else ():
            if holder.depth >= macro.depth:
                break
            names = names_in(value.node) & self.variables.keys() if isinstance(value, Symbol) else ()
            owners = {self.variables[one]["owner"] for one in names}
            if owners - {"", macro.id}:
                self.implicit.setdefault(place_key(macro.definition), set()).add(name)
                raise Restart
            macro.reads.setdefault(name, self.identity(value))
        return value

    def identity(self, value: Any) -> str:
        try:
            return ast.dump(node_of(value))
        except Failed:
            return str(id(value))

    def named(self, table: Any, name: str) -> Any:
        """Return the value of a property as a reference to it."""
        value = table[name]
        if "rosorin_plain" in vars(table) or isinstance(value, self.xacro.Table):
            return value
        known = self.bound.get((id(table), name))
        if known is not None and known[0] is value:
            return known[1]
        if isinstance(value, Symbol) and isinstance(parts_of(value.node)[0], ast.Name) and not is_let(value, self):
            return value
        try:
            node = node_of(value)
        except Failed:
            return value
        owner = vars(table).get("rosorin_owner", "")
        place, comments, raw = vars(table).get("rosorin_places", {}).get(name, (None, [], ""))
        if isinstance(value, float) and value == math.pi:
            return Symbol(ast.Name("pi", ast.Load()), value, True, self)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if place is not None and str(place[:2]) in self.plain:
            return example_of(value) if is_known(value) else value
        made = self.variable(
            "let", name, example_of(value), is_known(value), node=node, place=place, comments=comments,
            raw=raw if is_number and self.own_literal(raw) == value else "",
        )  # fmt: skip
        self.variables[made.node.id]["owner"] = owner  # type: ignore[attr-defined]
        self.tables.append(table)
        self.bound[id(table), name] = (value, made)
        return made

    # Elements.

    def patch(self, xacro: Any) -> None:
        """Let xacro evaluate with symbols."""
        self.own_literal, self.own_extension = xacro.Table._eval_literal, xacro.eval_extension
        self.own_include, own_boolean = xacro.process_include, xacro.get_boolean_value
        xacro.Table._eval_literal = staticmethod(self.literal)
        xacro.eval_text, xacro.eval_all = self.eval_text, self.eval_all
        xacro.handle_macro_call = lambda *words: self.macro_calls.call(*words)
        xacro.remove_previous_comments = self.take_comments
        xacro.get_boolean_value = lambda value, condition: own_boolean(example_of(value), condition)

    def take_comments(self, node: Any) -> None:
        """Remove the comments before an element of xacro and remember them with it."""
        found: list[str] = []
        before = node.previousSibling
        while before is not None:
            if before.nodeType == before.TEXT_NODE and before.data.isspace() and before.data.count("\n") <= 1:
                before = before.previousSibling
            elif before.nodeType == before.COMMENT_NODE:
                found.insert(0, before.data)
                before, gone = before.previousSibling, before
                gone.parentNode.removeChild(gone)
            else:
                break
        after = node.nextSibling
        if after is not None and after.nodeType == after.TEXT_NODE and "\n" not in after.data and after.data.isspace():
            after = after.nextSibling
        if (
            after is not None and after.nodeType == after.COMMENT_NODE and "\n" not in after.data
        ):  # behind it on its line
            found.append(after.data)
            after.parentNode.removeChild(after)
        setattr(node, COMMENTS, [*getattr(node, COMMENTS, []), *found])

    def eval_all(self, node: Any, macros: Any, symbols: Any) -> None:
        """Evaluate an element and what it contains."""
        for name, value in list(node.attributes.items()):
            if name.startswith("xacro:") or name == "xmlns:xacro":
                node.removeAttribute(name)
            else:
                node.setAttribute(name, str(self.eval_text(value, symbols)))
        child = node.firstChild
        while child is not None:
            if child.nodeType == child.ELEMENT_NODE and child.tagName.startswith("xacro:"):
                self.take_comments(child)
            following = child.nextSibling
            if child.nodeType == child.ELEMENT_NODE:
                if child.tagName == "xacro:element":
                    name = self.eval_text(child.getAttribute("xacro:name"), symbols)
                    if not is_known(name):
                        raise Failed("the name of an element depends on it", name.node)
                    child.removeAttribute("xacro:name")
                    child.nodeName = child.tagName = str(example_of(name))
                    continue
                self.element(child, macros, symbols)
            elif child.nodeType == child.TEXT_NODE and child.data.strip():
                child.data = str(self.eval_text(child.data, symbols))
            child = following

    def element(self, node: Any, macros: Any, symbols: Any) -> None:
        xacro, tag = self.xacro, node.tagName
        if tag in ("xacro:if", "xacro:unless"):
            self.conditions.element(node, macros, symbols)
        elif tag == "xacro:include":
            self.include(node, macros, symbols)
        elif tag == "xacro:property":
            self.property(node, symbols)
        elif tag == "xacro:macro":
            place = getattr(node, MARK, None)
            name = node.getAttribute("name")
            xacro.grab_macro(node, macros)
            self.defined.setdefault(str(place), (name, place))
        elif tag == "xacro:arg":
            self.take_comments(node)
            name = node.getAttribute("name")
            if name not in self.fixed and (name not in self.arguments or self.arguments[name]["place"] is None):
                self.declare(name, self.eval_text(node.getAttribute("default"), symbols), node)
            elif name in self.arguments and not self.arguments[name]["comments"]:
                self.arguments[name]["comments"] = getattr(node, COMMENTS, [])
            xacro.replace_node(node, by=None)
        elif tag == "xacro:insert_block":
            self.insert(node, macros, symbols)
        elif tag == "xacro:attribute":
            name, value = (self.eval_text(node.getAttribute(one), symbols) for one in ("name", "value"))
            if not is_known(name):
                raise Failed("the name of an attribute depends on it", name.node)
            node.parentNode.setAttribute(str(example_of(name)), str(value))
            xacro.replace_node(node, by=None)
        elif not self.macro_calls.call(node, macros, symbols):
            self.eval_all(node, macros, symbols)

    def property(self, node: Any, symbols: Any) -> None:
        scope = node.getAttribute("scope")
        building = self.macro_calls.building
        if building and (scope == "global" or (scope == "parent" and symbols is building[-1].table)):
            macro = building[0 if scope == "global" else -1]
            self.macro_calls.inline(place_key(macro.definition), "it sets a property of its caller")
        name = str(example_of(self.eval_text(node.getAttribute("name"), symbols)))
        self.take_comments(node)
        place = (getattr(node, MARK, None), getattr(node, COMMENTS, []), node.getAttribute("value"))
        vars(symbols).setdefault("rosorin_places", {})[name] = place
        self.bound.pop((id(symbols), name), None)
        self.xacro.grab_property(node, symbols)

    def insert(self, node: Any, macros: Any, symbols: Any) -> None:
        """Insert a block."""
        name = node.getAttribute("name")
        key = f"**{name}" if f"**{name}" in symbols else f"*{name}"
        if key not in symbols:
            raise self.xacro.XacroException(f'Undefined block "{name}"')
        block, holder = symbols[key].cloneNode(deep=True), symbols
        while not dict.__contains__(holder, key):
            holder = holder.parent
        for macro in self.macro_calls.building:
            if self.macro_calls.building[0].depth <= holder.depth < macro.depth:
                self.macro_calls.inline(place_key(macro.definition), "it inserts a block of its caller")
        self.eval_all(block, macros, symbols)
        self.xacro.replace_node(node, by=block, content_only=key.startswith("**"))

    def include(self, node: Any, macros: Any, symbols: Any) -> None:
        """Include a file; one that an argument chooses is included on the condition that it does."""
        name = self.eval_text(node.getAttribute("filename"), symbols)
        if not is_known(name):
            chosen = self.chosen.matching(name.node, "include")
            self.chosen.alternatives(node, "filename", chosen, macros, symbols)
            return
        node.setAttribute("filename", str(example_of(name)).replace("${", "$${"))
        self.own_include(node, macros, symbols, self.eval_all)


def is_let(value: Symbol, program: Program) -> bool:
    """Return True if a value is a property or a text, which may have a name."""
    is_text = isinstance(value.node, ast.Call) and getattr(value.node.func, "id", "") == "__join"
    return is_text or (
        isinstance(value.node, ast.Name) and program.variables.get(value.node.id, {}).get("kind") == "let"
    )

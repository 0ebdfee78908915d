"""Execute a xacro symbolically, with symbols for arguments and macro parameters.

The xacro library executes the file, so that scopes, lazy evaluation, includes and namespaces are exactly as in xacro.
Three things are different. The value of an expression is a ``Symbol``: an expression of the description language with
an example value. An element with a condition on an argument stays in the document. A call to a macro that becomes a
part also stays in the document, and the macro body is evaluated once, with symbols for its parameters. Macros and
arguments that cannot be translated are expanded as in xacro. This module runs in the child process.
"""

import ast
import math
import os
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from ..description import is_number
from . import child, ir
from .child import MARK, Expansion, causes
from .evaluate import Conditions, Evaluator, NamedFiles
from .macro_calls import Calls

MAX_RUNS = 60


def main() -> None:
    """Read a request from stdin, and write the translated description to stdout."""
    child.main(lambda request: Program(request).answer_with_description())


class Program(Expansion):
    """The symbolic execution of a xacro file."""

    def __init__(self, request: dict[str, Any]) -> None:
        super().__init__(request)
        self.request = request
        self.inlined: dict[str, str] = dict(request["inlined"])  # source position of a macro -> why it is expanded
        self.fixed: dict[str, list[str]] = dict(request["fixed"])  # argument replaced by its value -> [value, reason]
        # Results of earlier runs: "macro parameter" or " argument" -> type, macro -> properties that become parameters.
        self.kinds: dict[str, str] = {}
        self.implicit: dict[str, set[str]] = {}

    def answer_with_description(self) -> dict[str, Any]:
        """Translate the file; return the JSON answer with the documents of the description, or an error."""
        from .write_yaml import Writer

        self.xacro: Any = import_module("xacro")
        self.prepare(self.xacro)
        self.patch(self.xacro)
        for _ in range(MAX_RUNS):
            self.reset()
            try:
                document: Any = self.expand(self.xacro, {})
                answer = Writer(self).answer(document)
                if not self.retype(is_complete=True):
                    return answer
            except Exception as problem:
                chain = list(causes(problem))
                if self.retype() or any(isinstance(one, ir.Restart) for one in chain):
                    continue
                failed = next((one for one in chain if isinstance(one, ir.Untranslatable)), None)
                reason = str(failed or problem) or repr(problem)
                if failed is None or not self.blame(failed.nodes, reason):
                    return {"error": reason}
        return {"error": "too much of it cannot be translated"}

    def retype(self, is_complete: bool = False) -> bool:
        """Correct the types of arguments by their uses in a run; return True if any type changed."""
        kinds: dict[str, str] = {}
        for one in [one for one in self.arguments.values() if one.type in ("number", "boolean")]:
            is_test = is_complete and one.used and not one.counted and one.value in ("0", "1")
            if one.as_written or (is_test and one.type == "number"):
                kinds[f" {one.name}"] = "text" if one.as_written else "boolean"
        self.kinds |= kinds
        return bool(kinds)

    def reset(self) -> None:
        ir.Symbol.tokens.clear()
        self.variables: list[ir.Variable] = []
        self.arguments: dict[str, ir.Variable] = {}
        self.constants: dict[str, Any] = {}  # replaced argument -> value
        self.refused: dict[ir.Variable, str] = {}  # variable -> xacro error for another value of the variable
        self.names: set[str] = set()
        self.defined: dict[str, tuple[str, Any]] = {}
        self.macro_calls, self.conditions, self.named = Calls(self), Conditions(self), NamedFiles(self)
        self.xacro.all_includes[:] = []
        for name, text in self.given.items():
            if name not in self.fixed:
                self.declare(name, text, None)

    def blame(self, nodes: Iterable[ast.AST], reason: str) -> bool:
        """Exclude the macros, or else the arguments, of the variables in ``nodes`` from the next run; False if none."""
        variables: dict[ir.Variable, None] = {}
        waiting = list(ir.variables_in(nodes))
        while waiting:
            one = waiting.pop(0)
            if one not in variables:
                variables[one] = None
                waiting += ir.variables_in([one.symbol.node]) if one.kind == "let" and one.symbol is not None else ()
        macros = [one.owner for one in variables if one.owner and one.owner not in self.inlined]
        values = [one for one in variables if one.kind == "argument" and one.name not in self.fixed]
        self.inlined |= dict.fromkeys(macros, reason)
        if not macros:
            self.fixed |= {one.name: [str(one.value), reason] for one in values}
        return bool(macros or values)

    def variable(
        self, kind: str, name: str, value: Any, declared_type: str, macro: ir.Macro | None = None
    ) -> ir.Variable:
        """Create a variable of the kind "argument", "parameter" or "let", with a name that is unique in its scope."""
        own, owner = (set(), "") if macro is None else (macro.names, macro.key)
        taken = {"argument": set(), "parameter": own, "let": own | self.names}[kind]
        made = ir.Variable(kind, name, ir.usable(name, taken, kind == "argument"), value, declared_type, owner=owner)
        own.add(made.ours)
        if kind != "parameter":
            self.names.add(made.ours)
        self.variables.append(made)
        return made

    def literal(self, value: Any) -> Any:
        """Convert a property value to a number or boolean, or remove quotes around the string, as xacro does."""
        if not isinstance(value, ir.Symbol):
            return self.own_literal(value)
        made = self.own_literal(value.value) if isinstance(value.value, str) else value.value
        if made is value.value or (isinstance(made, str) and made == value.value):
            return value
        if isinstance(made, str):  # remove the quotes
            first, *inner, last = value.pieces or ["", "", ""]
            return ir.join_pieces([first[1:], *inner, last[:-1]]) if value.pieces else value
        if isinstance(made, bool) or value.type == "boolean":
            return ir.Symbol(value.as_flag(), bool(made), "boolean", value.known)
        return ir.Symbol(value.as_number(), made, "number", value.known)

    def note_comparison(self, items: list[ir.Symbol]) -> None:
        """Record values to which arguments are compared; the translation is verified for each recorded value."""
        texts = [text for one in items for text in (one.value if isinstance(one.value, (list, tuple)) else [one.value])]
        texts = [one for one in texts if isinstance(one, (str, int, float)) and not isinstance(one, bool)]
        for variable in filter(None, (one.variable for one in items)):
            variable.candidates += texts

    def declare(self, name: str, default: Any, node: Any, environment: bool = False) -> None:
        """Declare a xacro argument, or an environment variable that becomes an argument of the description."""
        if name not in self.arguments:
            text = str(ir.example_of(default))
            kind = ir.type_of(ir.literal(text))
            kind = self.kinds.get(f" {name}", kind if kind in ("number", "boolean") else "text")
            made = self.variable("argument", name, text, kind)
            made.symbol, made.environment = ir.symbol_of(default), environment
            self.arguments[name] = made
        made = self.arguments[name]
        made.place = made.place or getattr(node, MARK, None)
        made.comments = made.comments or getattr(node, ir.COMMENTS, [])

    def argument(self, name: str) -> Any:
        """Return the symbolic value of a xacro argument, or the constant if the argument was replaced by its value."""
        if name in self.fixed:
            return self.constants.get(name, self.fixed[name][0])
        if name not in self.arguments:
            raise import_module("xacro.substitution_args").ArgException(name)
        made = self.arguments[name]
        return ir.Symbol(made.node, made.value, made.type, False)

    def extension(self, text: str, symbols: Any) -> Any:
        """Evaluate a substitution such as ``$(find PACKAGE)``."""
        kind, _, rest = text.strip().partition(" ")
        if kind == "eval":
            return Evaluator(self, symbols, arguments=True).eval(ast.parse(rest.strip(), mode="eval").body)
        named = ir.with_tokens(rest.strip())
        is_known, rest = ir.is_known(named), str(ir.example_of(named))
        if not is_known and (kind != "find" or named.value is ir.UNKNOWN):
            raise ir.Untranslatable(f"$({kind}) cannot be translated", named.node)
        if kind == "arg":
            return self.argument(rest)
        if kind == "find":
            node = ast.Constant(rest) if is_known else named.node
            return ir.Symbol(ir.call("find", node), self.share(rest), "text", is_known)
        name, _, default = rest.partition(" ")
        if kind == "optenv" or (kind == "env" and name in os.environ):
            if name not in self.fixed:
                self.declare(name, os.environ.get(name, default.strip()), None, environment=True)
            return self.argument(name)
        return self.own_extension(f"$({kind} {rest})".replace(" )", ")"))

    def eval_text(self, text: str, symbols: Any, inner: bool = False) -> Any:
        """Evaluate the expressions and substitutions in a string; if ``inner``, return a string with ``TOKEN``s."""
        results: list[Any] = []
        lexer = self.xacro.QuickLexer(self.xacro.LEXER)
        lexer.lex(text)
        while lexer.peek():
            kind, found = lexer.peek()[0], lexer.next()[1]
            if kind == lexer.EXPR:
                expression = self.eval_text(found[2:-1], symbols, inner=True)
                results.append(Evaluator(self, symbols).eval(ast.parse(expression.strip(), mode="eval").body))
            elif kind == lexer.EXTENSION:
                results.append(self.extension(self.eval_text(found[2:-1], symbols, inner=True), symbols))
            else:
                results.append(found[1:] if kind == lexer.DOLLAR_DOLLAR_BRACE else found)
        if len(results) == 1 and not inner and not isinstance(results[0], str):
            return results[0]
        joined = "".join(map(str, results))
        return joined if inner else ir.with_tokens(joined)

    def read(self, table: Any, name: str, own: bool = False) -> Any:
        """Look up a name in a scope: a global name of xacro, a property or a parameter."""
        xacro, holder = self.xacro, table
        while isinstance(holder, xacro.Table) and not dict.__contains__(holder, name):
            holder = holder.parent
        if not isinstance(holder, xacro.Table) or (isinstance(holder, xacro.NameSpace) and holder.parent == {}):
            if name not in holder:
                raise NameError(f"name '{name}' is not defined")
            value = holder[name]
            if name in ("pi", "e", "tau"):
                return ir.Symbol(ast.Name(name, ast.Load()), value, "number", True)
            return ir.symbol_of(value) if isinstance(value, (int, float)) else value
        value = self.reference(holder, name)
        for macro in reversed(self.macro_calls.building) if not own else ():
            if holder.depth >= macro.depth:
                break
            owners = {one.owner for one in ir.variables_in([value.node])} if isinstance(value, ir.Symbol) else set()
            if owners - {"", macro.key}:
                self.implicit.setdefault(macro.key, set()).add(name)
                raise ir.Restart
        return value

    def reference(self, table: Any, name: str) -> Any:
        """Return the value of a property, if possible as a reference to a new ``let`` variable."""
        value = table[name]
        macro: ir.Macro | None = vars(table).get("rosorin_macro")
        if isinstance(value, self.xacro.Table) or "rosorin_plain" in vars(table):
            return value
        bound: dict[str, tuple[Any, str, ir.Symbol]] = vars(table).setdefault("rosorin_bound", {})
        before = bound.get(name)
        if before is not None and before[0] is value:
            return before[2]
        try:
            symbol = ir.symbol_of(value)
        except ir.Untranslatable:
            return value
        first = next(iter(ir.pieces_of(symbol)), None)
        is_variable = symbol.variable is not None and symbol.variable.kind != "let"
        is_inner = macro is not None and macro.level != "robot"  # a ``let`` function cannot define variables
        if is_variable or is_inner or (isinstance(first, ir.Symbol) and first.package):
            return symbol
        if isinstance(value, float) and value == math.pi:
            return ir.Symbol(ast.Name("pi", ast.Load()), value, "number", True)
        text = ir.as_text(symbol.node)
        if before is not None and before[1] == text:  # the same value was set again
            read = before[2]
        else:
            made = self.variable("let", name, symbol.value, symbol.declared_type, macro)
            made.symbol = symbol
            made.place, made.comments, raw = vars(table).get("rosorin_places", {}).get(name, (None, [], ""))
            made.digits = raw if is_number(value) and self.own_literal(raw) == value else ""
            read = ir.Symbol(made.node, symbol.value, made.type, symbol.known)
        bound[name] = (value, text, read)
        return read

    def patch(self, xacro: Any) -> None:
        """Replace evaluation functions in the xacro library with symbolic evaluation."""
        self.own_literal, self.own_extension = xacro.Table._eval_literal, xacro.eval_extension
        self.own_include, own_boolean = xacro.process_include, xacro.get_boolean_value
        xacro.Table._eval_literal = staticmethod(self.literal)
        xacro.eval_text, xacro.eval_all = self.eval_text, self.eval_all
        xacro.handle_macro_call = lambda *words: self.macro_calls.call(*words)
        xacro.remove_previous_comments = self.take_comments
        xacro.get_boolean_value = lambda value, condition: own_boolean(ir.example_of(value), condition)

    def take_comments(self, node: Any) -> None:
        """Move the comments before an element from the document to an attribute of the element."""
        found: list[str] = []
        before, after = node.previousSibling, node.nextSibling
        while before is not None and (_is_blank(before, 1) or before.nodeType == before.COMMENT_NODE):
            before, taken = before.previousSibling, before
            if taken.nodeType == taken.COMMENT_NODE:
                found.insert(0, taken.data)
                taken.parentNode.removeChild(taken)
        if after is not None and _is_blank(after, 0):
            after = after.nextSibling
        if after is not None and after.nodeType == after.COMMENT_NODE and "\n" not in after.data:  # on the same line
            found.append(after.data)
            after.parentNode.removeChild(after)
        setattr(node, ir.COMMENTS, [*getattr(node, ir.COMMENTS, []), *found])

    def eval_all(self, node: Any, macros: Any, symbols: Any) -> None:
        """Evaluate an XML element and its content."""
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
                    child.nodeName = child.tagName = self.known_name(child, "xacro:name", symbols)
                    child.removeAttribute("xacro:name")
                    continue
                self.element(child, macros, symbols)
            elif child.nodeType == child.TEXT_NODE and child.data.strip():
                child.data = str(self.eval_text(child.data, symbols))
            child = following

    def known_name(self, node: Any, attribute: str, symbols: Any) -> str:
        """Evaluate an attribute that contains a name. Raises Untranslatable if the name depends on an argument."""
        name = self.eval_text(node.getAttribute(attribute), symbols)
        if not ir.is_known(name):
            kind = "a macro" if attribute == "macro" else "an element or attribute"
            raise ir.Untranslatable(f"the name of {kind} depends on it", name.node)
        return str(ir.example_of(name))

    def element(self, node: Any, macros: Any, symbols: Any) -> None:
        """Evaluate any element, including xacro elements such as <xacro:include> and macro calls."""
        xacro, tag = self.xacro, node.tagName
        if tag in ("xacro:if", "xacro:unless"):
            self.conditions.element(node, macros, symbols)
        elif tag == "xacro:include":
            self.include(node, macros, symbols)
        elif tag == "xacro:property":
            self.property(node, symbols)
        elif tag == "xacro:macro":
            place = getattr(node, MARK, None)
            self.defined.setdefault(str(place), (node.getAttribute("name"), place))
            xacro.grab_macro(node, macros)
        elif tag == "xacro:arg":
            self.take_comments(node)
            name, default = node.getAttribute("name"), self.eval_text(node.getAttribute("default"), symbols)
            if name not in self.fixed:
                self.declare(name, default, node)
            elif ir.example_of(default) == self.fixed[name][0] and ir.is_known(default):
                self.constants.setdefault(name, default)  # the expression of the default, such as ``find()``
            xacro.replace_node(node, by=None)
        elif tag == "xacro:insert_block":
            self.insert(node, macros, symbols)
        elif tag == "xacro:attribute":
            name, value = self.known_name(node, "name", symbols), self.eval_text(node.getAttribute("value"), symbols)
            node.parentNode.setAttribute(name, str(value))
            xacro.replace_node(node, by=None)
        elif not self.macro_calls.call(node, macros, symbols):
            self.eval_all(node, macros, symbols)

    def property(self, node: Any, symbols: Any) -> None:
        scope, building = node.getAttribute("scope"), self.macro_calls.building
        if building and (scope == "global" or (scope == "parent" and symbols is building[-1].table)):
            self.macro_calls.inline(building[0 if scope == "global" else -1].key, "it sets a property of its caller")
        name = str(ir.example_of(self.eval_text(node.getAttribute("name"), symbols)))
        self.take_comments(node)
        place = (getattr(node, MARK, None), getattr(node, ir.COMMENTS, []), node.getAttribute("value"))
        vars(symbols).setdefault("rosorin_places", {})[name] = place
        self.xacro.grab_property(node, symbols)

    def insert(self, node: Any, macros: Any, symbols: Any) -> None:
        name = node.getAttribute("name")
        key = f"**{name}" if f"**{name}" in symbols else f"*{name}"
        if key not in symbols:
            raise self.xacro.XacroException(f'Undefined block "{name}"')
        block, holder = symbols[key].cloneNode(deep=True), symbols
        while not dict.__contains__(holder, key):
            holder = holder.parent
        for macro in self.macro_calls.building:
            if self.macro_calls.building[0].depth <= holder.depth < macro.depth:
                self.macro_calls.inline(macro.key, "it inserts a block of its caller")
        self.eval_all(block, macros, symbols)
        self.xacro.replace_node(node, by=block, content_only=key.startswith("**"))

    def include(self, node: Any, macros: Any, symbols: Any) -> None:
        name = self.eval_text(node.getAttribute("filename"), symbols)
        if not ir.is_known(name):
            raise ir.Untranslatable("the file to include is named by it", name.node)
        node.setAttribute("filename", str(ir.example_of(name)).replace("${", "$${"))
        self.own_include(node, macros, symbols, self.eval_all)


def _is_blank(node: Any, lines: int) -> bool:
    return bool(node.nodeType == node.TEXT_NODE and node.data.isspace() and node.data.count("\n") <= lines)

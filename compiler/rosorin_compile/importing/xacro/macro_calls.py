"""Handle macro calls during the symbolic execution of a xacro.

If a macro can become a part or a ``let`` function, its calls stay in the document, and its body is evaluated once, with
symbols for the parameters. Other macros are expanded as in xacro. This module runs in the child process.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .child import MARK
from .ir import COMMENTS, UNKNOWN, Macro, Restart, Symbol, Untranslatable, nodes_of, symbol_of, with_tokens

if TYPE_CHECKING:
    from .program import Program

MAX_DEPTH = 40
_TRANSPARENT = ("xacro-if", "xacro:if", "xacro:unless")
# Elements in which a macro can become a ``let`` function; macros in other elements become XML text.
_SHAPES = ("link/visual", "link/collision")
_ENTRIES = ("link", "joint", "link/inertial", *_SHAPES, *(f"{one}/geometry" for one in _SHAPES))

Names = dict[str, dict[str, str]]  # parameters that replace an <origin> block: block -> attribute -> name


@dataclass(eq=False)
class Invocation:
    """A macro call and its arguments; ``macros`` and ``symbols`` are the scopes in which the macro was defined."""

    definition: Any
    node: Any
    macros: Any
    symbols: Any
    values: dict[str, Any] = field(default_factory=dict)
    defaulted: set[str] = field(default_factory=set)
    blocks: dict[str, Any] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """The source position of the macro definition, as a string."""
        return str(getattr(self.definition.body, MARK, None))


class Calls:
    """Handles the macro calls of a xacro, and collects the translated macros."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.macros: dict[str, Macro] = {}  # "key level" -> translated macro
        self.building: list[Macro] = []  # stack of macros whose bodies are being evaluated
        self.paths: list[str] = [""]  # for each macro in ``building``, the path of the element that contains the call
        self.called: dict[str, bool] = {}  # macro key -> True if any call created an element

    def call(self, node: Any, macros: Any, symbols: Any) -> bool:
        """Handle an XML element if it is a macro call; return False for any other element."""
        program, xacro = self.program, self.program.xacro
        if not node.tagName.startswith("xacro:"):
            return False
        if node.tagName == "xacro:call":
            node.tagName = node.nodeName = f"xacro:{program.known_name(node, 'macro', symbols)}"
            node.removeAttribute("macro")
        name = node.tagName.removeprefix("xacro:")
        try:
            own_macros, own_symbols, macro = xacro.resolve_macro(name, macros, symbols)
        except KeyError:
            raise xacro.XacroException(f"unknown macro name: {node.tagName}") from None
        invocation = Invocation(copy(macro), node, own_macros, own_symbols)  # the macro may be redefined
        self.called.setdefault(invocation.key, False)
        path = self._path(node)
        xacro.macrostack.append(invocation.definition)
        if len(xacro.macrostack) > MAX_DEPTH * (1 if program.conditions.assumed else 5):
            raise RecursionError("macros call each other without end")
        self._take_values(invocation, macros, symbols)
        if path is not None and invocation.key not in program.inlined:
            self._keep(invocation, path)
        else:
            self._expand(invocation, "xml" if path is None else path)
        xacro.macrostack.pop()
        return True

    def _path(self, node: Any) -> str | None:
        """Return the path of the element that contains a call, such as link/visual, or None in another macro call."""
        names: list[str] = []
        node = node.parentNode
        while node.parentNode is not None and node.tagName != "xacro:macro":
            if node.tagName not in _TRANSPARENT:
                names.append(node.tagName)
            node = node.parentNode
        if any(name.startswith("xacro:") for name in names):
            return None
        if node.nodeType == node.ELEMENT_NODE:
            names += [self.paths[-1]] if self.paths[-1] else []
        else:
            names.pop()  # omit <robot>
        return "/".join(reversed(names))

    def _take_values(self, call: Invocation, macros: Any, symbols: Any) -> None:
        program, xacro, macro, node = self.program, self.program.xacro, call.definition, call.node
        parameters = list(macro.params)
        for name, text in node.attributes.items():
            if name not in parameters:
                raise xacro.XacroException(f'Invalid parameter "{name}"', macro=macro)
            parameters.remove(name)
            call.values[name] = program.literal(program.eval_text(text, symbols))
            node.setAttribute(name, "")
        program.eval_all(node, macros, symbols)
        block = xacro.first_child_element(node)
        for name in [one for one in parameters if one.startswith("*")]:
            if not block:
                raise xacro.XacroException("Not enough blocks", macro=macro)
            if block.tagName == "xacro-if":
                raise Untranslatable("a block depends on a condition", with_tokens(block.getAttribute("test")).node)
            parameters.remove(name)
            call.blocks[name] = block
            block = xacro.next_sibling_element(block)
        if block is not None:
            raise xacro.XacroException(f'Unused block "{block.tagName}"', macro=macro)
        for name in parameters:
            forward, default = macro.defaultmap.get(name, (None, None))
            if forward is not None and forward in symbols:
                value = program.read(symbols, forward)
            elif default is not None:
                value = program.eval_text(default, symbols)
                call.defaulted.add(name)
            else:
                raise xacro.XacroException(f"Undefined parameters [{name}]", macro=macro)
            call.values[name] = program.literal(value)

    def _take_blocks(self, call: Invocation) -> Names:
        """Replace the <origin> blocks of a call with parameters; return {block: {attribute: parameter name}}."""
        names: Names = {}
        for block, element in call.blocks.items():
            if element.tagName != "origin" or element.childNodes or block.startswith("**"):
                self.inline(call.key, "it has a block that is not an origin")
            names[block] = {}
            for attribute in ("xyz", "rpy"):
                is_taken = attribute in call.values or attribute in call.definition.params
                name = names[block][attribute] = f"{block[1:]}_{attribute}" if is_taken else attribute
                text = element.getAttribute(attribute) or "0 0 0"
                call.values[name] = self.program.literal(with_tokens(text))
                if text == "0 0 0":
                    call.defaulted.add(name)
        return names

    def inline(self, key: str, reason: str) -> None:
        """Expand all calls to a macro in the next run of the translation; ``reason`` is reported. Raises Restart."""
        self.program.inlined[key] = reason
        raise Restart

    def _keep(self, call: Invocation, path: str) -> None:
        """Replace a call with a placeholder element; evaluate the macro body if this is the first call."""
        program, key, node = self.program, call.key, call.node
        if any(one.key == key for one in self.building):
            self.inline(key, "it calls itself")
        blocks = self._take_blocks(call)
        implicit = program.implicit.get(key, set())
        for name in sorted(implicit - call.values.keys()):
            call.values[name] = program.read(call.symbols, name) if name in call.symbols else None
        values = {name: symbol_of(value) for name, value in call.values.items()}
        level = path.rpartition("/")[2] if path in _ENTRIES else "xml" if path else "robot"
        macro = self.macros.get(f"{key} {level}")
        if macro is None:
            body = call.definition.body
            name, place = body.getAttribute("name").removeprefix("xacro:"), getattr(body, MARK, None)
            macro = Macro(name, key, level, place, getattr(body, COMMENTS, []))
            self.macros[f"{key} {level}"] = macro
            self._build(macro, call, path, values, blocks)
        program.take_comments(node)
        for name, value in values.items():
            if name not in macro.parameters:
                self.inline(key, f'its calls have different parameters: "{name}"')
            if value.value is not UNKNOWN and macro.parameters[name].type not in (value.declared_type, ""):
                program.kinds[f"{key} {name}"] = ""
                raise Restart
        made = node.ownerDocument.createElement("xacro-call")
        made.rosorin_call = (macro, {name: (value, name in call.defaulted) for name, value in values.items()})
        setattr(made, MARK, getattr(node, MARK, None))
        setattr(made, COMMENTS, getattr(node, COMMENTS, []))
        program.xacro.replace_node(node, by=made)

    def _build(self, macro: Macro, call: Invocation, path: str, values: dict[str, Symbol], blocks: Names) -> None:
        program = self.program
        table = program.xacro.Table(call.symbols)
        table.rosorin_macro = macro
        for name, value in values.items():
            kind = program.kinds.get(f"{macro.key} {name}", value.declared_type)
            made = macro.parameters[name] = program.variable("parameter", name, value.value, kind, macro)
            dict.__setitem__(table, name, Symbol(made.node, value.value, made.type, False))
        for block, names in blocks.items():
            inner = call.blocks[block].cloneNode(deep=True)
            for attribute, name in names.items():
                inner.setAttribute(attribute, str(dict.__getitem__(table, name)))
            dict.__setitem__(table, block, inner)
        macro.depth, macro.table = table.depth, table
        outer, program.conditions.assumed = program.conditions.assumed, {}
        self.building.append(macro)
        body = self._evaluated(call, table, path)
        self.building.pop()
        program.conditions.assumed = outer
        macro.body = nodes_of(body)
        self.called[macro.key] = True

    def _evaluated(self, call: Invocation, table: Any, path: str) -> Any:
        """Return an evaluated copy of a macro body; its new parent <xacro:macro> ends the search in ``_path``."""
        body = call.definition.body.cloneNode(deep=True)
        for name in ("name", "params"):
            if body.hasAttribute(name):
                body.removeAttribute(name)
        holder = body.ownerDocument.createElement("xacro:macro")
        holder.appendChild(body)
        body.tagName = body.nodeName = "xacro:macro"
        self.paths.append(path)
        self.program.eval_all(body, self.program.xacro.Table(call.macros), table)
        self.paths.pop()
        return body

    def _expand(self, call: Invocation, path: str) -> None:
        xacro, node = self.program.xacro, call.node
        table = xacro.Table(call.symbols)
        table.rosorin_plain = True
        for name, value in (call.values | call.blocks).items():
            dict.__setitem__(table, name, value)
        parent = node.parentNode
        self.program.take_comments(node)
        body = self._evaluated(call, table, path)
        first = xacro.first_child_element(body)
        self.called[call.key] = self.called[call.key] or first is not None
        if first is not None and getattr(node, COMMENTS, []):
            setattr(first, COMMENTS, [*getattr(node, COMMENTS), *getattr(first, COMMENTS, [])])
        xacro.import_xml_namespaces(parent, body.attributes)
        xacro.replace_node(node, by=body, content_only=True)

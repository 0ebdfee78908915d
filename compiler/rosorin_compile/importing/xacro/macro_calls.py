"""Calls of macros while xacro runs with symbols.

The call of a macro that becomes a part or a named value stays in the document, and the body of the macro is evaluated
once, with symbols for its parameters. Other calls are expanded as xacro does it. This module runs in the child process.
"""

from __future__ import annotations

import ast
from copy import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .symbols import TOKEN, UNKNOWN, Failed, Restart, example_of, is_known

if TYPE_CHECKING:
    from .symbolic import Program

MAX_DEPTH = 40
MARK, COMMENTS = "rosorin_place", "rosorin_comments"
_TRANSPARENT = ("xacro-if", "xacro:if", "xacro:unless", "xacro-group")
_ORIGIN = {"xyz": "0 0 0", "rpy": "0 0 0"}
# Elements that become entries of a description, by the elements that they are in.
_ENTRIES: dict[str, tuple[str, ...]] = {
    "link": ("robot",),
    "joint": ("robot",),
    "inertial": ("link",),
    "visual": ("link",),
    "collision": ("link",),
    "geometry": ("visual", "collision"),
}

Shape = dict[tuple[str, str], str]  # of blocks: the name of a parameter, by element and attribute


@dataclass(eq=False)
class Macro:
    """A macro that stays: the ids of the variables of its parameters, and its body as it was evaluated.

    ``reads`` are the properties of its caller that it reads; ``has_materials``: it makes materials of the robot.
    """

    definition: Any
    level: str
    parameters: dict[str, str] = field(default_factory=dict)
    reads: dict[str, str] = field(default_factory=dict)
    has_materials: bool = False
    depth: int = 0
    table: Any = None
    body: Any = None

    @property
    def id(self) -> str:
        return f"{place_key(self.definition)} {self.level}"

    @property
    def name(self) -> str:
        name: str = self.definition.body.getAttribute("name")
        return name.removeprefix("xacro:")


@dataclass(eq=False)
class Invocation:
    """A call: the macro, the element, what it gives, and the tables of macros and properties of the definition."""

    definition: Any
    node: Any
    macros: Any
    symbols: Any
    values: dict[str, Any] = field(default_factory=dict)
    defaulted: set[str] = field(default_factory=set)
    blocks: dict[str, Any] = field(default_factory=dict)

    @property
    def key(self) -> str:
        return place_key(self.definition)


class Calls:
    """The calls of macros of one run.

    ``macros`` are those that stay, ``building`` those whose body is evaluated, ``levels`` the elements that those are
    called in. ``called`` has the names of macros by their place, ``made`` whether they made any element.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.depth = 0
        self.macros: dict[str, Macro] = {}
        self.building: list[Macro] = []
        self.levels: list[str] = ["robot"]
        self.called: dict[str, str] = {}
        self.made: dict[str, bool] = {}

    def call(self, node: Any, macros: Any, symbols: Any) -> bool:
        """Handle the call of a macro; return False if the element is none."""
        program, xacro = self.program, self.program.xacro
        if not node.tagName.startswith("xacro:"):
            return False
        if node.tagName == "xacro:call":
            name = program.eval_text(node.getAttribute("macro"), symbols)
            if not is_known(name):
                chosen = program.chosen.matching_macros(name.node, macros)
                program.chosen.alternatives(node, "macro", chosen, macros, symbols)
                return True
            node.removeAttribute("macro")
            node.tagName = node.nodeName = f"xacro:{example_of(name)}"
        name = node.tagName.removeprefix("xacro:")
        try:
            own_macros, own_symbols, macro = xacro.resolve_macro(name, macros, symbols)
        except KeyError:
            raise xacro.XacroException(f"unknown macro name: {node.tagName}") from None
        if "rosorin_other" in vars(macro):
            self._call_either(node, macro, macros, symbols)
            return True
        invocation = Invocation(copy(macro), node, own_macros, own_symbols)  # the name may be defined again
        self.called.setdefault(invocation.key, name)
        level = self._level(node)
        self.depth += 1
        if self.depth > MAX_DEPTH * (1 if program.conditions.assumed else 5):
            raise RecursionError("macros call each other without end")
        xacro.macrostack.append(invocation.definition)
        self._take_values(invocation, macros, symbols)
        if level and invocation.key not in program.inlined:
            self._keep(invocation, level)
        else:
            self._expand(invocation)
        xacro.macrostack.pop()
        self.depth -= 1
        return True

    def _call_either(self, node: Any, macro: Any, macros: Any, symbols: Any) -> None:
        """Call a macro that is defined in two ways, on a condition: each on its condition."""
        test, holds, other = macro.rosorin_other
        for one, side in ((macro, holds), (other, not holds)):
            made = node.ownerDocument.createElement("xacro:if")
            made.appendChild(node.cloneNode(deep=True))
            node.parentNode.insertBefore(made, node)
            chosen = copy(one)
            if vars(one).get("rosorin_other", (test,))[0] is test:
                vars(chosen).pop("rosorin_other", None)
            table = self.program.xacro.Table(macros)
            dict.__setitem__(table, node.tagName.removeprefix("xacro:"), chosen)
            self.program.conditions.branch(made, test, side, table, symbols)
        node.parentNode.removeChild(node)

    # Where a call is.

    def _level(self, node: Any) -> str:
        """Return where a call is: the element that it is in, of those that become entries; else ``xml``."""
        parent = _above(node)
        if parent is None or parent.tagName == "xacro:macro":
            return self.levels[-1]
        if _is_root(parent):
            return "robot"
        tag: str = parent.tagName
        return "" if tag.startswith("xacro") else tag if self._is_entry(parent) else "xml"

    def _is_entry(self, node: Any) -> bool:
        """Return True if an element is a link or a joint, or belongs to one."""
        within, above = _ENTRIES.get(node.tagName, ()), _above(node)
        if above is None or above.tagName == "xacro:macro":
            return (self.levels[-1] if above is not None else "robot") in within
        if "robot" in within:
            return _is_root(above)
        return above.tagName in within and self._is_entry(above)

    # What a call gives.

    def _take_values(self, call: Invocation, macros: Any, symbols: Any) -> None:
        """Evaluate the parameters and the blocks of a call."""
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
                token = TOKEN.search(block.getAttribute("test"))
                test = program.tokens[int(token[1])].node if token else ast.Constant(0)
                raise Failed("a block depends on a condition", test)
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
                what = f"Undefined property to forward: {forward}" if forward else f"Undefined parameters [{name}]"
                raise xacro.XacroException(what, macro=macro)
            call.values[name] = program.literal(value)

    def _take_blocks(self, call: Invocation) -> Shape:
        """Make the attributes in the blocks of a call parameters; return their names by element and attribute."""
        program, key = self.program, call.key
        found: dict[tuple[str, str], Any] = {}
        for name, block in call.blocks.items():
            for number, element in enumerate(_within(block)):
                if element.tagName.startswith("xacro") or any(
                    one.nodeType == one.TEXT_NODE and one.data.strip() for one in element.childNodes
                ):
                    self.inline(key, "a block has text, a macro or a condition in it")
                path = f"{name}/{number}{element.tagName}"
                found[path, ""] = None
                attributes = {**(_ORIGIN if element.tagName == "origin" else {}), **dict(element.attributes.items())}
                found |= {(path, attribute): text for attribute, text in attributes.items()}
        shape = program.shapes.setdefault(key, {})
        if shape and [path for path, attribute in found if not attribute] != [p for p, a in shape if not a]:
            self.inline(key, "its calls have different elements in a block")
        for path, attribute in [one for one in found if one not in shape]:
            tag = path.partition("/")[2].lstrip("0123456789")
            name = tag if attribute in ("value", "name", "link") else attribute
            if name in {*shape.values(), *call.definition.params}:
                name = f"{path.split('/')[0][1:]}_{name}"
            shape[path, attribute] = name if attribute else ""
            if key in {one.rpartition(" ")[0] for one in self.macros}:  # its body is evaluated without this parameter
                raise Restart
        for (path, attribute), name in shape.items():
            if attribute:
                text = found.get((path, attribute))
                call.values[name] = None if text is None else program.literal(program.joined(text))
                if text is None or (path.endswith("origin") and text == _ORIGIN.get(attribute)):
                    call.defaulted.add(name)
        return shape

    # What becomes of a call.

    def inline(self, key: str, reason: str) -> None:
        """Run again, with a macro expanded where it is called."""
        self.program.inlined[key] = reason
        raise Restart

    def _keep(self, call: Invocation, level: str) -> None:
        """Replace a call by an element that describes it; evaluate the body of the macro at its first call."""
        program, key, node = self.program, call.key, call.node
        if any(place_key(one.definition) == key for one in self.building):
            self.inline(key, "it calls itself")
        implicit = program.implicit.get(key, set())
        for name in sorted(implicit - call.values.keys()):
            value = self._read(call.symbols, name)
            if value is not UNKNOWN:
                call.values[name] = value
        macro = self.macros.get(f"{key} {level}")
        given = dict(call.values)
        shape = self._take_blocks(call)
        if macro is None:
            macro = Macro(call.definition, level)
            self.macros[macro.id] = macro
            self._build(macro, call, shape)
        for name, before in macro.reads.items():
            if name not in implicit and program.identity(self._read(call.symbols, name)) != before:
                program.implicit.setdefault(key, set()).add(name)
                raise Restart
        program.take_comments(node)
        for name, value in call.values.items():
            if name not in macro.parameters:
                self.inline(key, f'its calls have different parameters: "{name}"')
            if not is_known(value) and str(value.value).endswith((".yaml", ".yml")):
                program.chosen.note_files(value)
        made = node.ownerDocument.createElement("xacro-call")
        made.setAttribute("macro", macro.id)
        made.rosorin_call = call
        copy_marks(node, made)
        if macro.has_materials:
            self._hoist(call, given)
        program.xacro.replace_node(node, by=made)

    def _read(self, symbols: Any, name: str) -> Any:
        try:
            return self.program.read(symbols, name)
        except (NameError, KeyError):
            return UNKNOWN

    def _build(self, macro: Macro, call: Invocation, shape: Shape) -> None:
        """Evaluate the body of a macro with symbols for its parameters."""
        program = self.program
        table = program.xacro.Table(call.symbols)
        table.rosorin_owner = macro.id
        for name, value in call.values.items():
            made = program.variable("parameter", name, example_of(value), False, owner=macro.id)
            macro.parameters[name] = made.node.id  # type: ignore[attr-defined]
            dict.__setitem__(table, name, made)
        for name, block in call.blocks.items():
            inner = block.cloneNode(deep=True)
            for number, element in enumerate(_within(inner)):
                for (path, attribute), parameter in shape.items():
                    if attribute and path == f"{name}/{number}{element.tagName}":
                        element.setAttribute(attribute, str(dict.__getitem__(table, parameter)))
            dict.__setitem__(table, name, inner)
        macro.depth, macro.table = table.depth, table
        outer, program.conditions.assumed = program.conditions.assumed, {}
        self.building.append(macro)
        macro.body = self._evaluated(call, table, macro.level)
        self.building.pop()
        program.conditions.assumed = outer
        macro.has_materials = macro.level == "robot" and _only_materials(macro.body, False)
        self.made[call.key] = True

    def _evaluated(self, call: Invocation, table: Any, level: str) -> Any:
        """Return the body of a macro, evaluated in a macro of its own, so that calls in it know where they are."""
        body = call.definition.body.cloneNode(deep=True)
        for name in ("name", "params"):
            if body.hasAttribute(name):
                body.removeAttribute(name)
        holder = body.ownerDocument.createElement("xacro:macro")
        holder.appendChild(body)
        body.tagName = body.nodeName = "xacro:macro"
        self.levels.append(level)
        self.program.eval_all(body, self.program.xacro.Table(call.macros), table)
        self.levels.pop()
        return body

    def _expand(self, call: Invocation) -> None:
        """Expand a call in its place, as xacro does."""
        xacro, node = self.program.xacro, call.node
        table = xacro.Table(call.symbols)
        table.rosorin_plain = True
        for name, value in (call.values | call.blocks).items():
            dict.__setitem__(table, name, value)
        parent = node.parentNode
        self.program.take_comments(node)
        body = self._evaluated(call, table, self._level(node) or "xml")
        first = next((child for child in body.childNodes if child.nodeType == child.ELEMENT_NODE), None)
        self.made[call.key] = self.made.get(call.key, False) or first is not None
        if first is not None and getattr(node, COMMENTS, []):
            setattr(first, COMMENTS, [*getattr(node, COMMENTS), *getattr(first, COMMENTS, [])])
        xacro.import_xml_namespaces(parent, body.attributes)
        xacro.replace_node(node, by=body, content_only=True)

    def _hoist(self, call: Invocation, values: dict[str, Any]) -> None:
        """Put the materials that a call makes before it: a robot shares them."""
        node = call.node
        group, inner = (node.ownerDocument.createElement(tag) for tag in ("xacro-group", node.tagName))
        node.parentNode.insertBefore(group, node)
        group.appendChild(inner)
        blocks = {name: block.cloneNode(deep=True) for name, block in call.blocks.items()}
        self._expand(Invocation(call.definition, inner, call.macros, call.symbols, values, set(), blocks))
        _only_materials(group, True)
        self.program.xacro.replace_node(group, by=group, content_only=True)


def _above(node: Any) -> Any:
    """Return the element that an element is in, but for conditions and groups, or None."""
    node = node.parentNode
    while node is not None and node.nodeType == node.ELEMENT_NODE and node.tagName in _TRANSPARENT:
        node = node.parentNode
    return node if node is not None and node.nodeType == node.ELEMENT_NODE else None


def _is_root(node: Any) -> bool:
    return node.parentNode is None or bool(node.parentNode.nodeType == node.DOCUMENT_NODE)


def _within(block: Any) -> list[Any]:
    """Return a block and the elements in it."""
    inner = [child for child in block.childNodes if child.nodeType == child.ELEMENT_NODE]
    return [block, *(one for child in inner for one in _within(child))]


def _only_materials(node: Any, keep: bool) -> bool:
    """Remove all but materials, or (unless ``keep``) the materials; return True if there are any."""
    found = False
    for inner in list(node.childNodes):
        is_group = inner.nodeType == inner.ELEMENT_NODE and inner.tagName in _TRANSPARENT
        is_material = inner.nodeType == inner.ELEMENT_NODE and inner.tagName == "material"
        found = (_only_materials(inner, keep) if is_group else is_material) or found
        if not is_group and is_material != keep:
            node.removeChild(inner)
    return found


def copy_marks(node: Any, made: Any) -> None:
    """Give an element the place and the comments of another."""
    setattr(made, MARK, getattr(node, MARK, None))
    setattr(made, COMMENTS, getattr(node, COMMENTS, []))


def place_key(macro: Any) -> str:
    """Return the key of a macro: the place of its definition."""
    return str(getattr(macro.body, MARK, None))

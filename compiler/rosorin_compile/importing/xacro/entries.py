"""Convert links and joints of a xacro to entries of a description, and macros in links and joints to ``let`` functions.

Elements in ``<xacro:if>`` and ``<xacro:unless>`` are alternatives. They are merged key by key: equal values are written
once, and different values become ``${A if CONDITION else B}``. This module runs in the child process.
"""

import ast
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any
from xml.sax.saxutils import escape

from rosorin_compile.formats.urdf.read import NUMBERS as ATTRIBUTES
from rosorin_compile.formats.urdf.read import SHAPES
from rosorin_compile.formats.xml_reader import ANGLES, LENGTHS

from ..description import Expression, Verbatim, in_order
from .ir import Call, Comment, Element, If, Macro, Untranslatable, Words, all_of, as_text, fold, negate, plain_node
from .values import Values

_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}
_JOINT_PARTS = ("limit", "mimic", "dynamics", "calibration", "safety_controller")
_LISTS = ("visual", "collision", "urdf_elements")
_ZEROS = {"origin": ("xyz", "rpy"), "inertia": ("ixy", "ixz", "iyz")}

Item = tuple[str, Any, ast.expr | None]  # (key of an entry, value, condition or None for always)
_WIDTH = 90
IF = Verbatim("if")
_NUMBER = re.compile(r"-?[\d.]+(e[-+]?\d+)?( [a-z/]+)?")
_EXPRESSION = re.compile(r"(\$\{(?:[^{}'\"]|'[^']*'|\"[^\"]*\")*\})")

Condition = ast.expr | None
Alternative = tuple[Any, Condition]


class Entries:
    """Converts XML elements to entries of a description; ``inner`` has the comments inside the current element."""

    def __init__(self, values: Values, write_macro: Callable[[Macro], dict[str, Any]]) -> None:
        self.values = values
        self.write_macro = write_macro
        self.inner: list[str] = []
        self._kind: Any = ""  # type of the current joint, such as "revolute"
        self._position = ""  # unit of the position of the current joint

    def link(self, node: Element) -> Any:
        """Convert a <link> to an entry of ``links``."""
        self.inner = []
        return self._sole_call(node) or self.finish(self.fragment(node.body, "link"))

    def joint(self, node: Element) -> dict[str, Any]:
        """Convert a <joint> to an entry of ``joints``."""
        self.inner = []
        self._kind = kind = self.values.text(node.attributes.get("type", []))
        turns, slides = kind in ("revolute", "continuous"), kind in ("prismatic", "planar")
        self._position = ANGLES if turns else LENGTHS if slides else ""
        made = self.finish([("type", kind, None), *self.fragment(node.body, "joint")])
        for key in _WITHOUT_EFFECT.get(str(kind), ()):
            made.pop(key, None)
        if made.get("dynamics") == {}:
            del made["dynamics"]
        return made

    def condition(self, node: If) -> ast.expr:
        """Return the condition under which the content of an <xacro:if> or <xacro:unless> exists."""
        made = node.test.as_flag() if node.holds else negate(node.test.as_flag())
        if fold(made) is None:
            self.values.expression_text(made)
        return made

    def fragment(self, nodes: list[Any], level: str) -> list[Item]:
        """Convert the content of an element such as <link> (``level`` is its tag) to (key, value, condition) tuples."""
        items: list[Item] = []
        for node in nodes:
            if isinstance(node, Comment):
                self.inner.append(node.text)
            elif isinstance(node, If):
                condition = self.condition(node)
                for key, value, when in self.fragment(node.body, level) if fold(condition) is not False else ():
                    items.append((key, value, all_of(condition, when)))
            elif isinstance(node, Call):
                items += self._call_items(node)
            elif isinstance(node, Element):
                items += self._piece(node, level)
        return items

    def _piece(self, node: Element, level: str) -> Iterator[Item]:
        tag, values = node.tag, self.values
        if level == "link" and tag == "inertial":
            yield tag, self.finish(self.fragment(node.body, tag)), None
        elif level == "link" and tag in ("visual", "collision"):
            name = node.attributes.get("name")
            items: list[Item] = [("name", values.text(name), None)] if name else []
            call = self._sole_call(node) if not items else None
            yield tag, [call or self.finish([*items, *self.fragment(node.body, tag)])], None
        elif tag == "origin" and level in ("inertial", "visual", "collision", "joint"):
            if "quat_xyzw" in node.attributes:
                raise Untranslatable("quat_xyzw has no word")
            yield from ((key, value, None) for key, value in self._numbers(node).items())
        elif level == "inertial" and tag == "mass":
            yield tag, self._numbers(node).get("value", Verbatim("0")), None
        elif level == "inertial" and tag == "inertia":
            yield tag, self._numbers(node), None
        elif level in ("visual", "collision") and tag == "geometry":
            yield from self.fragment(node.body, "geometry")
        elif level == "visual" and tag == "material":
            if name := node.attributes.get("name"):
                yield tag, values.text(name), None
            yield from self.fragment(node.body, "material")
        elif level == "material" and tag == "color":
            yield "rgba", self._numbers(node)["rgba"], None
        elif level == "material" and tag == "texture":
            if node.attributes.get("filename"):
                yield tag, values.file(node.attributes["filename"]), None
        elif level == "geometry" and tag in SHAPES:
            file = node.attributes.get("filename")
            made = {} if file is None else {"file": values.file(file)}
            yield tag, {**made, **self._numbers(node)}, None
        elif level == "joint" and tag in ("parent", "child"):
            yield tag, values.text(node.attributes.get("link", [])), None
        elif level == "joint" and tag == "axis":
            yield tag, self._numbers(node)["xyz"], None
        elif level == "joint" and tag in _JOINT_PARTS:
            made = {"joint": values.text(node.attributes["joint"])} if tag == "mimic" else {}
            if tag == "limit" and self._kind in ("revolute", "prismatic"):
                made = {"lower": Verbatim("0"), "upper": Verbatim("0")}
            yield tag, {**made, **self._numbers(node)}, None
        elif level in ("link", "joint", "visual", "collision"):
            yield "urdf_elements", [self.xml(node)], None
        else:
            raise Untranslatable(f"<{tag}> in <{level}> has no word")

    def finish(self, items: list[Item]) -> dict[str, Any]:
        """Build an entry from (key, value, condition) tuples. Raises Untranslatable if values cannot be merged."""
        made: dict[str, Any] = {}
        for key in dict.fromkeys(one[0] for one in items):
            found = [(value, when) for name, value, when in items if name == key]
            first, only = found[0]
            if key in _LISTS and isinstance(first, list):
                made[key] = [conditional(item, when) for value, when in found for item in value]
                continue
            value = conditional(first, only)
            if len(found) > 1 or (only is not None and not isinstance(first, dict)):
                value = merge(key, found)
            if value is None:
                raise Untranslatable(f"{key} has several values on different conditions")
            made[key] = value
        return in_order(made)

    def _numbers(self, node: Element) -> dict[str, Any]:
        """Return the numeric attributes of an element, except for zeros and mesh scales that are the default."""
        made: dict[str, Any] = {}
        for name, (count, attribute_unit) in ATTRIBUTES[node.tag].items():
            pieces = node.attributes.get(name)
            if pieces is None:
                continue
            unit = self._position if attribute_unit == "q" else attribute_unit
            value = self.values.list_of(pieces, count, unit) if count > 1 else self.values.number(pieces, unit)
            plain = value if isinstance(value, list) else [value]
            is_zero = all(isinstance(one, Verbatim) and one == "0" for one in plain)
            is_scale = node.tag == "mesh" and all(one == "1" for one in plain)
            if not is_scale and not (is_zero and name in _ZEROS.get(node.tag, ())):
                made[name] = value
        return made

    def call_text(self, call: Call) -> str:
        """Format a macro call as an expression that calls the ``let`` function of the macro."""
        if call.macro.level != "xml":
            self.write_macro(call.macro)
        parameters = call.macro.parameters.items()
        arguments = [self.values.argument(call.given[name][0], variable) for name, variable in parameters]
        return self.values.expression_text(ast.Call(ast.Name(call.macro.ours, ast.Load()), arguments, []))

    def named_value(self, macro: Macro) -> tuple[Any, dict[str, Any]]:
        """Convert a macro that is called in a link, joint or other element to the value of a ``let`` function.

        Returns (value, entry that the macro creates); the entry is {} for XML. Raises Untranslatable if impossible.
        """
        self.inner = []
        if macro.level == "xml":
            text = "\n".join(self._lines(macro.body, ""))
            return Expression(text) if "${" in text else text, {}
        entry = self.finish(self.fragment(macro.body, macro.level))
        inner = [item for key, value in entry.items() for item in (value if key in _LISTS else [value])]
        if len(inner) > len(entry) or any(isinstance(one, dict) and IF in one for one in inner):
            raise Untranslatable("it has several elements of a kind, or one on a condition")
        return inner[0] if len(entry) == 1 else entry, entry

    def _call_items(self, call: Call) -> list[Item]:
        entry, text = self.write_macro(call.macro), self.call_text(call)
        items: list[Item] = []
        for key in entry:
            is_list = key in _LISTS
            inner = "" if len(entry) == 1 else f".{key}[0]" if is_list else f".{key}"
            made = Expression(f"${{{text}{inner}}}")
            items.append((key, [made] if is_list else made, None))
        return items

    def _sole_call(self, node: Element) -> Any:
        """Return an expression if the element only contains a call to a macro that sets several keys, else None."""
        body = [one for one in node.body if not isinstance(one, Comment)]
        if len(body) == 1 and isinstance(body[0], Element) and body[0].tag == "geometry":
            body = [one for one in body[0].body if not isinstance(one, Comment)]
        if len(body) != 1 or not isinstance(body[0], Call) or len(self.write_macro(body[0].macro)) < 2:
            return None
        return Expression(f"${{{self.call_text(body[0])}}}")

    def xml(self, node: Element) -> Any:
        """Format an element as XML text for the description; return an Expression if the text depends on variables."""
        lines = self._lines([node], "")
        whole = "".join(line.strip() for line in lines)
        if len(lines) == 3 and len(whole) <= _WIDTH and "<!--" not in whole:
            lines = [whole]
        text = lines[0] if len(lines) == 1 else "\n".join([*lines, ""])
        return Expression(text) if "${" in text else text

    def _lines(self, nodes: list[Any], pad: str) -> list[str]:
        lines: list[str] = []
        for at, node in enumerate(nodes):
            text = ""
            if isinstance(node, Words):
                text = str(self.values.text(node.pieces, escape))
            elif isinstance(node, Comment) and "--" not in node.text and "${" not in node.text:
                text = f"<!--{node.text}-->"
            elif isinstance(node, If) and not (at and _is_opposite(nodes[at - 1], node)):
                lines += self._choice(node, nodes[at + 1 : at + 2], pad)
            elif isinstance(node, Call):
                text = f"${{{self.call_text(node)}}}"
            elif isinstance(node, Element):
                lines += self._element(node, pad)
            lines += [pad + line.strip() for line in text.splitlines() if line.strip()]
        return lines

    def _choice(self, node: If, following: list[Any], pad: str) -> list[str]:
        """Format a conditional element as XML lines; ``following`` may start with the else branch."""
        condition = self.condition(node)
        decided = fold(condition)
        other = following[0].body if following and _is_opposite(node, following[0]) else []
        if isinstance(decided, bool):
            return self._lines(node.body if decided else other, pad)
        sides: list[ast.expr] = []
        for body in (node.body, other):
            text = " ".join(self._lines([one for one in body if not isinstance(one, Comment)], ""))
            made = node_of(Expression(text) if "${" in text else text) if text else ast.Constant("")
            if made is None:
                raise Untranslatable("a condition in a kept element has expressions of its own", node.test.node)
            sides.append(made)
        if all(isinstance(one, ast.Constant) and one.value == "" for one in sides):
            return []
        return [f"{pad}${{{as_text(ast.IfExp(condition, *sides))}}}"]

    def _element(self, node: Element, pad: str) -> list[str]:
        head = node.tag
        for name, pieces in node.attributes.items():
            if name.startswith("xmlns"):
                continue
            is_file = name == "filename" and node.tag in ("mesh", "texture")
            value = str(self.values.file(pieces) if is_file else self.values.text(pieces))
            if any(letter in value for letter in '&<"'):
                value = str(self.values.text(pieces, lambda one: escape(one, {'"': "&quot;"})))
            head += f' {name}="{value}"'
        inner = self._lines(node.body, f"{pad}  ")
        if not inner:
            return [f"{pad}<{head}/>"]
        only = len(node.body) == 1 and isinstance(node.body[0], Words)
        if len(inner) == 1 and (only or len(pad) + len(head) + len(inner[0].strip()) + len(node.tag) + 5 <= _WIDTH):
            return [f"{pad}<{head}>{inner[0].strip()}</{node.tag}>"]
        return [f"{pad}<{head}>", *inner, f"{pad}</{node.tag}>"]


def _is_opposite(one: Any, other: Any) -> bool:
    if not isinstance(one, If) or not isinstance(other, If):
        return False
    return as_text(one.test.node) == as_text(other.test.node) and one.holds != other.holds


def conditional(value: Any, when: Condition) -> Any:
    """Add the condition ``when`` to a value as the key ``if``; None means unconditional."""
    if when is None:
        return value
    condition = Expression(f"${{{as_text(when)}}}")
    return {IF: condition, **value} if isinstance(value, dict) else {IF: condition, "value": value}


def merge(key: str, found: list[Alternative], sure: Sequence[Condition] = ()) -> Any:
    """Merge (value, condition) pairs into one value, or return None if that is impossible.

    ``sure`` are conditions of which at least one always holds. Uncovered cases get a default or the key ``if``.
    """
    found = sorted(found, key=lambda one: one[1] is None)
    values, whens = [value for value, _ in found], [when for _, when in found]
    if whens.count(None) > 1:
        return None
    known = {as_text(when): when for when in whens if when is not None}
    is_covered = None in whens or any(as_text(negate(when)) in known for when in known.values())
    is_covered |= bool(sure) and all(one is not None and as_text(one) in known for one in sure)
    any_of = next(iter(known.values())) if len(known) == 1 else ast.BoolOp(ast.Or(), list(known.values()))
    if all(value == values[0] for value in values):
        return conditional(values[0], None if is_covered else any_of)
    if all(isinstance(value, dict) for value in values):
        made: Any = _tables(found)
        return None if made is None else conditional(made, None if is_covered else any_of)
    if all(isinstance(value, list) and any(isinstance(item, dict) for item in value) for value in values):
        if any(isinstance(item, dict) and IF in item for value in values for item in value):
            return None
        otherwise = all_of(*(negate(when) for when in known.values()))
        return [conditional(item, when or otherwise) for value, when in found for item in value]
    pairs = [(node_of(value), when) for value, when in found]
    if not is_covered:
        pairs.append((plain_node([0, 0, 0] if key in _ZEROS["origin"] else None), None))
    last = pairs.pop()[0]
    for node, when in reversed(pairs):
        if node is None or last is None or when is None:
            return None
        last = node if as_text(node) == as_text(last) else ast.IfExp(when, node, last)
    return None if last is None else Expression(f"${{{as_text(last)}}}")


def _tables(found: list[Alternative]) -> dict[Any, Any] | None:
    if any(IF in value for value, _ in found):
        return None
    sure = [when for _, when in found]
    made: dict[Any, Any] = {}
    for key in in_order(dict.fromkeys(key for value, _ in found for key in value)):
        made[key] = merge(str(key), [(value[key], when) for value, when in found if key in value], sure)
        if made[key] is None:
            return None
    return made


def node_of(value: Any) -> ast.expr | None:
    """Convert a value of a description to an expression tree; return None if that is impossible, as for a mapping."""
    if isinstance(value, list):
        items = [node for item in value if (node := node_of(item)) is not None]
        return ast.List(items, ast.Load()) if len(items) == len(value) else None
    if isinstance(value, Verbatim):
        return _parsed(str(value))
    if not isinstance(value, Expression):
        return plain_node(value) if isinstance(value, (str, bool)) else None
    made: ast.expr | None = None
    pieces = [piece for piece in _EXPRESSION.split(value) if piece]
    if any("${" in piece and not piece.startswith("${") for piece in pieces):
        return None
    for piece in pieces:
        node = _parsed(piece[2:-1]) if piece.startswith("${") else ast.Constant(piece)
        if piece.startswith("${") and len(pieces) > 1:
            node = ast.Call(ast.Name("str", ast.Load()), [node], [])
        made = node if made is None else ast.BinOp(made, ast.Add(), node)
    return made


def _parsed(text: str) -> ast.expr:
    try:
        return ast.parse(text.strip(), mode="eval").body
    except SyntaxError:  # not Python syntax: a number with a unit
        return ast.Name(text if _NUMBER.fullmatch(text) else f"({text})")

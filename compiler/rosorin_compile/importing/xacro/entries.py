"""Write links, joints and what they contain as entries of a description, and macros within them as named values.

Elements that the language has no word for are kept as text, with expressions in it.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any
from xml.sax.saxutils import escape

from rosorin_compile.formats.urdf.read import NUMBERS as ATTRIBUTES
from rosorin_compile.formats.urdf.read import SHAPES
from rosorin_compile.formats.urdf.reading import ANGLES, LENGTHS

from ..description import in_order
from ..layout import Expression, Verbatim
from .choices import conditional, merged, node_of
from .documents import Documents, within
from .formulas import all_of, folded, negated, written
from .ir import Call, Comment, Element, If, Macro, Pieces, Program, Unsupported, Words
from .values import Values

_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}
_JOINT_PARTS = ("limit", "mimic", "dynamics", "calibration", "safety_controller")
_WIDTH = 90
_LISTS = ("visual", "collision", "urdf_elements")

Item = tuple[str, Any, ast.expr | None]  # a key of an entry, its value, and its condition


class _Items(list[Any]):
    """The items of a list that a named value has; ``expression`` is the list as one expression."""

    expression = ""


class Entries:
    """Writes entries of a program. ``inner`` are the comments in the entry, ``shapes`` those of its shapes by key."""

    def __init__(self, program: Program, values: Values, documents: Documents) -> None:
        self.program, self.values, self.documents = program, values, documents
        self.xml = XmlText(values, self.call_node)
        self.inner: list[str] = []
        self.shapes: dict[str, list[list[str]]] = {}
        self._kind: Any = ""  # the type of the joint that is written
        self._position = ""  # the unit of its position
        self._results: dict[Macro, tuple[dict[str, Any], Any]] = {}

    def link(self, node: Element) -> Any:
        """Return an entry of ``links``."""
        self.inner, self.shapes = [], {}
        return self._sole_call(node) or self.finished(self.fragment(node.body, "link"))

    def joint(self, node: Element) -> dict[str, Any]:
        """Return an entry of ``joints``."""
        self.inner, self.shapes = [], {}
        self._kind = kind = self.values.text(node.attributes.get("type", []))
        turns, slides = kind in ("revolute", "continuous"), kind in ("prismatic", "planar")
        self._position = ANGLES if turns else LENGTHS if slides else ""
        made = self.finished([("type", kind, None), *self.fragment(node.body, "joint")])
        for key in _WITHOUT_EFFECT.get(str(kind), ()):
            made.pop(key, None)
        limit = made.get("limit")
        if isinstance(kind, Expression) and isinstance(limit, dict) and kind.startswith("${") and kind.count("${") == 1:
            zero = Expression(f"${{0 if {kind[2:-1]} in ['revolute', 'prismatic'] else none}}")
            made["limit"] = {**{key: zero for key in ("lower", "upper") if key not in limit}, **limit}
        if made.get("dynamics") == {}:
            del made["dynamics"]
        return made

    def condition(self, node: If) -> ast.expr:
        """Return the condition of nodes as an expression."""
        made = self.values.formulas.flag(node.test)
        return made if node.holds else negated(made)

    def fragment(self, nodes: list[Any], level: str) -> list[Item]:
        """Return the keys that the content of an element has, with their conditions."""
        items: list[Item] = []
        comments: list[str] = []
        for node in nodes:
            if isinstance(node, Comment):
                comments.append(node.text)
                continue
            if isinstance(node, If):
                condition = self.condition(node)
                for key, value, when in self.fragment(node.body, level) if folded(condition) is not False else ():
                    items.append((key, value, all_of([one for one in (condition, when) if one is not None])))
            elif isinstance(node, Call):
                items += self._call_items(node)
            elif isinstance(node, Element):
                items += self._piece(node, level)
                if level == "link" and node.tag in ("visual", "collision"):
                    self.shapes.setdefault(node.tag, []).append(comments)
                    comments = []
            self.inner += comments
            comments = []
        self.inner += comments
        return items

    def _piece(self, node: Element, level: str) -> Iterator[Item]:
        """Yield the keys of one element in a link, a joint, or what those contain."""
        tag, values = node.tag, self.values
        if level == "link" and tag == "inertial":
            yield tag, self.finished(self.fragment(node.body, tag)), None
        elif level == "link" and tag in ("visual", "collision"):
            name = node.attributes.get("name")
            items: list[Item] = [("name", values.text(name), None)] if name else []
            call = self._sole_call(node) if not items else None
            yield tag, [call or self.finished([*items, *self.fragment(node.body, tag)])], None
        elif tag == "origin" and level in ("inertial", "visual", "collision", "joint"):
            if "quat_xyzw" in node.attributes:
                raise Unsupported("quat_xyzw has no word")
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
                yield tag, values.text(node.attributes["filename"], file=True), None
        elif level == "geometry" and tag in SHAPES:
            file = node.attributes.get("filename")
            made = {} if file is None else {"file": values.text(file, file=True)}
            yield tag, {**made, **self._numbers(node)}, None
        elif level == "joint" and tag in ("parent", "child"):
            yield tag, values.text(node.attributes.get("link", []), name=True), None
        elif level == "joint" and tag == "axis":
            yield tag, self._numbers(node)["xyz"], None
        elif level == "joint" and tag in _JOINT_PARTS:
            made = {"joint": values.text(node.attributes["joint"], name=True)} if tag == "mimic" else {}
            if tag == "limit" and self._kind in ("revolute", "prismatic"):
                made = {"lower": Verbatim("0"), "upper": Verbatim("0")}
            yield tag, {**made, **self._numbers(node)}, None
        elif level in ("link", "joint", "visual", "collision"):
            yield "urdf_elements", [self.xml.text(node)], None
        else:
            raise Unsupported(f"<{tag}> in <{level}> has no word")

    def finished(self, items: list[Item]) -> dict[str, Any]:
        """Return an entry of its keys; those that several conditions have are one value that chooses."""
        made: dict[str, Any] = {}
        for key in dict.fromkeys(one[0] for one in items):
            found = [(value, when) for name, value, when in items if name == key]
            first, only = found[0]
            if isinstance(first, list) and key in _LISTS:
                if len(found) == 1 and isinstance(first, _Items) and first.expression and only is None:
                    made[key] = Expression(first.expression)
                    continue
                made[key] = [conditional(item, when) for value, when in found for item in value]
                chosen = merged(key, found) if len(found) == 2 and all(when for _, when in found) else None
                made[key] = chosen if isinstance(chosen, list) else made[key]
                continue
            if len(found) == 1 and only is not None and isinstance(first, Expression) and _is_conditional(first):
                made[key] = Expression(f"${{{first[2:-1]} if {written(only)} else none}}")
                continue
            value = conditional(first, only)
            if len(found) > 1 or (only is not None and not isinstance(first, dict)):
                value = merged(key, found)
            if value is None:
                raise Unsupported(f"{key} has several values on different conditions")
            made[key] = value
        return in_order(made)

    def _numbers(self, node: Element) -> dict[str, Any]:
        """Return the numbers of an element by attribute, without those that are defaults anyway."""
        macro = self.values.macro
        pose = self.values.names.pose.get(macro, {}) if macro is not None and node.tag == "origin" else {}
        made: dict[str, Any] = {}
        for name, (count, attribute_unit) in ATTRIBUTES[node.tag].items():
            pieces = node.attributes.get(name)
            if pieces is None or (name in pose and len(pieces) == 1 and _id(pieces) == pose[name].id):
                continue
            unit = self._position if attribute_unit == "q" else attribute_unit
            value = self.values.list_of(pieces, count, unit) if count > 1 else self.values.number(pieces, unit)
            plain = value if isinstance(value, list) else [value]
            is_zero = all(isinstance(one, Verbatim) and one == "0" for one in plain)
            if is_zero and name in ("xyz", "rpy", "ixy", "ixz", "iyz") and node.tag in ("origin", "inertia"):
                continue
            if node.tag == "mesh" and all(one == "1" for one in plain):
                continue
            made[name] = value
        return made

    # Named values.

    def call_node(self, call: Call) -> ast.expr:
        """Return the call of a named value as an expression."""
        arguments = [
            self.values.argument(call.given[name][0], variable) for name, variable in call.macro.parameters.items()
        ]
        return ast.Call(ast.Name(call.macro.ours, ast.Load()), arguments, [])

    def named_value(self, macro: Macro) -> None:
        """Write a macro within links or joints, or in kept elements, under ``let``."""
        if macro in self._results:
            return
        if macro.level == "xml":
            text = "\n".join(self.xml.lines(macro.body, ""))
            value: Any = Expression(text) if "${" in text else text
            self._results[macro] = ({}, True)
            self.inner = []
        else:
            self.shapes, self.inner = {}, []
            entry = self.finished(self.fragment(macro.body, macro.level))
            shapes = [
                one for key in ("visual", "collision") for one in entry.get(key, ()) if isinstance(entry[key], list)
            ]
            if any(map(_is_conditional, shapes)):
                raise Unsupported("it has a shape on a condition")
            only: Any = next(iter(entry.values()), {})
            is_single = len(entry) == 1 and not _is_conditional(only)
            if is_single and isinstance(only, list) and only and isinstance(only[0], dict):
                is_single, only = len(only) == 1, only[0]
            self._results[macro] = (entry, is_single)
            value = only if is_single else entry
        file = self.program.file_of(macro.place).name
        key = f"{macro.ours}({', '.join(one.ours for one in macro.parameters.values())})"
        self.documents.section(file, "let")[key] = value
        self.documents.remark(file, ("let", key), [*macro.comments, *self.inner])

    def _result(self, macro: Macro) -> tuple[dict[str, Any], Any]:
        if macro not in self._results:
            inner, shapes = self.inner, self.shapes
            with within(self.values, macro):
                self.named_value(macro)
            self.inner, self.shapes = inner, shapes
        return self._results[macro]

    def _call_items(self, call: Call) -> list[Item]:
        """Return the keys that the call of a named value has."""
        entry, is_single = self._result(call.macro)
        text = written(self.call_node(call))
        items: list[Item] = []
        for key, value in entry.items():
            if isinstance(value, list) and key in _LISTS:
                inner = _Items(
                    Expression(f"${{{text}}}" if is_single else f"${{{text}.{key}[{at}]}}") for at in range(len(value))
                )
                inner.expression = "" if is_single else f"${{{text}.{key}}}"
                items.append((key, inner, None))
            elif _is_conditional(value):
                items.append((key, Expression(f"${{get({text}, {key!r})}}"), None))
            else:
                items.append((key, Expression(f"${{{text}}}" if is_single else f"${{{text}.{key}}}"), None))
        return items

    def _sole_call(self, node: Element) -> Any:
        """Return the call of a named value that an element consists of, or None."""
        body = [one for one in node.body if not isinstance(one, Comment)]
        if len(body) == 1 and isinstance(body[0], Element) and body[0].tag == "geometry":
            body = [one for one in body[0].body if not isinstance(one, Comment)]
        if len(body) != 1 or not isinstance(body[0], Call) or body[0].macro.level == "xml":
            return None
        is_single = self._result(body[0].macro)[1]
        return None if is_single else Expression(f"${{{written(self.call_node(body[0]))}}}")


def _id(pieces: Pieces) -> str:
    return getattr(pieces[0], "id", "") if pieces else ""


def _is_conditional(value: Any) -> bool:
    return (isinstance(value, dict) and "if" in value) or (isinstance(value, Expression) and value.startswith("${get("))


class XmlText:
    """Writes elements as text; ``call_node`` returns the call of a macro as an expression."""

    def __init__(self, values: Values, call_node: Callable[[Call], ast.expr]) -> None:
        self.values, self.call_node = values, call_node

    def text(self, node: Element) -> Any:
        """Return an element as a text, or an Expression."""
        self.values.is_xml = True
        lines = self.lines([node], "")
        self.values.is_xml = False
        whole = "".join(line.strip() for line in lines)
        if len(lines) == 3 and len(whole) <= _WIDTH and "<!--" not in whole:
            lines = [whole]
        text = lines[0] if len(lines) == 1 else "\n".join([*lines, ""])
        return Expression(text) if "${" in text else text

    def lines(self, nodes: list[Any], pad: str) -> list[str]:
        """Return the lines of nodes. Raises Unsupported."""
        lines: list[str] = []
        for at, node in enumerate(nodes):
            if isinstance(node, Words):
                text = str(self.values.joined(node.pieces, escape))
                lines += [pad + line.strip() for line in text.splitlines() if line.strip()]
            elif isinstance(node, Comment):
                if "--" not in node.text and "${" not in node.text:
                    lines += [f"{pad}{line.strip()}" for line in f"<!--{node.text}-->".splitlines()]
            elif isinstance(node, If):
                if not at or not _is_opposite(nodes[at - 1], node):
                    lines += self._choice(node, nodes[at + 1 : at + 2], pad)
            elif isinstance(node, Call):
                lines.append(f"{pad}${{{written(self.call_node(node))}}}")
            else:
                lines += self._element(node, pad)
        return lines

    def _choice(self, node: If, following: list[Any], pad: str) -> list[str]:
        """Return what depends on a condition; ``following`` may have what is there otherwise."""
        condition = self.values.formulas.flag(node.test)
        condition = condition if node.holds else negated(condition)
        decided = folded(condition)
        other = following[0].body if following and _is_opposite(node, following[0]) else []
        if isinstance(decided, bool):
            return self.lines(node.body if decided else other, pad)
        sides: list[ast.expr] = []
        for body in (node.body, other):
            text = " ".join(self.lines([one for one in body if not isinstance(one, Comment)], ""))
            made = node_of(Expression(text) if "${" in text else text) if text else ast.Constant("")
            if made is None:
                raise Unsupported("a condition in a kept element has expressions of its own")
            sides.append(made)
        if all(isinstance(one, ast.Constant) and one.value == "" for one in sides):
            return []
        return [f"{pad}${{{written(ast.IfExp(condition, *sides))}}}"]

    def _element(self, node: Element, pad: str) -> list[str]:
        head = node.tag
        for name, pieces in node.attributes.items():
            if name.startswith("xmlns"):
                continue
            is_name = name in ("reference", "link", "joint") or node.tag in ("link", "joint")
            value = str(self.values.text(pieces, name=is_name))
            if any(letter in value for letter in '&<"'):
                value = str(self.values.joined(pieces, lambda one: escape(one, {'"': "&quot;"})))
            head += f' {name}="{value}"'
        inner = self.lines(node.body, f"{pad}  ")
        if not inner:
            return [f"{pad}<{head}/>"]
        only = len(node.body) == 1 and isinstance(node.body[0], Words)
        if len(inner) == 1 and (only or len(pad) + len(head) + len(inner[0].strip()) + len(node.tag) + 5 <= _WIDTH):
            return [f"{pad}<{head}>{inner[0].strip()}</{node.tag}>"]
        return [f"{pad}<{head}>", *inner, f"{pad}</{node.tag}>"]


def _is_opposite(one: Any, other: Any) -> bool:
    if not isinstance(one, If) or not isinstance(other, If):
        return False
    return ast.dump(one.test) == ast.dump(other.test) and one.holds != other.holds

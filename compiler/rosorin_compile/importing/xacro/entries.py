"""Write links, joints and what they contain as entries of a description, and macros within them as named values.

This module runs in the child process.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any

from rosorin_compile.formats.urdf.read import NUMBERS as ATTRIBUTES
from rosorin_compile.formats.urdf.read import SHAPES
from rosorin_compile.formats.urdf.reading import ANGLES, LENGTHS

from ..description import in_order
from ..layout import Expression, Verbatim
from .choices import IF, conditional, merged
from .ir import Call, Comment, Element, If, Macro
from .symbols import Failed, Symbol, all_of, folded, negated
from .values import Values
from .xml_text import XmlText

_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}
_JOINT_PARTS = ("limit", "mimic", "dynamics", "calibration", "safety_controller")
_LISTS = ("visual", "collision", "urdf_elements")
_ZEROS = {"origin": ("xyz", "rpy"), "inertia": ("ixy", "ixz", "iyz")}

Item = tuple[str, Any, ast.expr | None]  # a key of an entry, its value, and its condition


class Entries:
    """Writes entries. ``inner`` are the comments in the current entry, ``shapes`` those of its shapes by key."""

    def __init__(self, values: Values, write_macro: Callable[[Macro], dict[str, Any]]) -> None:
        self.values = values
        self.write_macro = write_macro
        self.xml = XmlText(values, self.condition, self.call_text)
        self.inner: list[str] = []
        self.shapes: dict[str, list[list[str]]] = {}
        self._kind: Any = ""  # the type of the joint that is written
        self._position = ""  # the unit of its position

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
        made = node.test.as_flag() if node.holds else negated(node.test.as_flag())
        if folded(made) is None:
            self.values.spelt(made)
        return made

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
                    items.append((key, value, all_of(condition, when)))
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
                raise Failed("quat_xyzw has no word")
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
            raise Failed(f"<{tag}> in <{level}> has no word")

    def finished(self, items: list[Item]) -> dict[str, Any]:
        """Return an entry of its keys; those that several conditions have are one value that chooses."""
        made: dict[str, Any] = {}
        for key in dict.fromkeys(one[0] for one in items):
            found = [(value, when) for name, value, when in items if name == key]
            first, only = found[0]
            if key in _LISTS and isinstance(first, list):
                made[key] = [conditional(item, when) for value, when in found for item in value]
                continue
            value = conditional(first, only)
            if len(found) > 1 or (only is not None and not isinstance(first, dict)):
                value = merged(key, found)
            if value is None:
                raise Failed(f"{key} has several values on different conditions")
            made[key] = value
        return in_order(made)

    def _numbers(self, node: Element) -> dict[str, Any]:
        """Return the numbers of an element by attribute, without those that are defaults anyway."""
        macro = self.values.macro
        pose = self.values.names.pose.get(macro, {}) if macro is not None and node.tag == "origin" else {}
        made: dict[str, Any] = {}
        for name, (count, attribute_unit) in ATTRIBUTES[node.tag].items():
            pieces = node.attributes.get(name)
            if pieces is None or (name in pose and isinstance(pieces[0], Symbol) and pieces[0].variable is pose[name]):
                continue
            unit = self._position if attribute_unit == "q" else attribute_unit
            value = self.values.list_of(pieces, count, unit) if count > 1 else self.values.number(pieces, unit)
            plain = value if isinstance(value, list) else [value]
            is_zero = all(isinstance(one, Verbatim) and one == "0" for one in plain)
            if (is_zero and name in _ZEROS.get(node.tag, ())) or (
                node.tag == "mesh" and all(one == "1" for one in plain)
            ):
                continue
            made[name] = value
        return made

    # Named values.

    def call_text(self, call: Call) -> str:
        """Return the call of a named value as text of the language."""
        if call.macro.level != "xml":
            self.write_macro(call.macro)
        arguments = [
            self.values.argument(call.given[name][0], variable) for name, variable in call.macro.parameters.items()
        ]
        return self.values.spelt(ast.Call(ast.Name(call.macro.ours, ast.Load()), arguments, []))

    def named_value(self, macro: Macro) -> tuple[Any, dict[str, Any]]:
        """Return a macro within links or joints, or in kept elements, as a value, and its keys. Raises Failed."""
        self.inner, self.shapes = [], {}
        if macro.level == "xml":
            text = "\n".join(self.xml.lines(macro.body, ""))
            return Expression(text) if "${" in text else text, {}
        entry = self.finished(self.fragment(macro.body, macro.level))
        inner = [item for key, value in entry.items() for item in (value if key in _LISTS else [value])]
        if len(inner) > len(entry) or any(isinstance(one, dict) and IF in one for one in inner):
            raise Failed("it has several elements of a kind, or one on a condition")
        return inner[0] if len(entry) == 1 else entry, entry

    def _call_items(self, call: Call) -> list[Item]:
        """Return the keys that the call of a named value has."""
        entry, text = self.write_macro(call.macro), self.call_text(call)
        items: list[Item] = []
        for key in entry:
            is_list = key in _LISTS
            inner = "" if len(entry) == 1 else f".{key}[0]" if is_list else f".{key}"
            made = Expression(f"${{{text}{inner}}}")
            items.append((key, [made] if is_list else made, None))
        return items

    def _sole_call(self, node: Element) -> Any:
        """Return the call of a named value with all keys of an element, or None if it does not consist of one."""
        body = [one for one in node.body if not isinstance(one, Comment)]
        if len(body) == 1 and isinstance(body[0], Element) and body[0].tag == "geometry":
            body = [one for one in body[0].body if not isinstance(one, Comment)]
        if len(body) != 1 or not isinstance(body[0], Call) or len(self.write_macro(body[0].macro)) < 2:
            return None
        return Expression(f"${{{self.call_text(body[0])}}}")

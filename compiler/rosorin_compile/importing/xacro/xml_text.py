"""Write elements that the language has no word for as text, with expressions in it.

This module runs in the child process.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any
from xml.sax.saxutils import escape

from ..layout import Expression
from .choices import node_of
from .ir import Call, Comment, Element, If, Words
from .symbols import Failed, folded, written
from .values import Values

_WIDTH = 90


class XmlText:
    """Writes elements as text; ``call_text`` returns the call of a macro as an expression."""

    def __init__(self, values: Values, condition: Callable[[If], ast.expr], call_text: Callable[[Call], str]) -> None:
        self.values, self.condition, self.call_text = values, condition, call_text

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
        """Return the lines of nodes. Raises Failed."""
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
                lines.append(f"{pad}${{{self.call_text(node)}}}")
            else:
                lines += self._element(node, pad)
        return lines

    def _choice(self, node: If, following: list[Any], pad: str) -> list[str]:
        """Return what depends on a condition; ``following`` may have what is there otherwise."""
        condition = self.condition(node)
        decided = folded(condition)
        other = following[0].body if following and _is_opposite(node, following[0]) else []
        if isinstance(decided, bool):
            return self.lines(node.body if decided else other, pad)
        sides: list[ast.expr] = []
        for body in (node.body, other):
            text = " ".join(self.lines([one for one in body if not isinstance(one, Comment)], ""))
            made = node_of(Expression(text) if "${" in text else text) if text else ast.Constant("")
            if made is None:
                raise Failed("a condition in a kept element has expressions of its own", node.test.node)
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
            is_file = name == "filename" and node.tag in ("mesh", "texture")
            value = str(self.values.text(pieces, name=is_name, file=is_file))
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
    return written(one.test.node) == written(other.test.node) and one.holds != other.holds

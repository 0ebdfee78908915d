"""Kept: elements of XML that are kept as text, their conditions as expressions in it."""

from __future__ import annotations

import ast
import re
from typing import Any
from xml.sax.saxutils import escape

from rosorin_compile.language.expression.functions import expression_names
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.xml.markup import Document, Element, MarkupError, Remark

from ..layout import Expression
from .choices import node_of
from .expressions import negated, usable, written
from .naming import expanded, without_prefix
from .pieces import Call, Xml
from .scopes import XML, Scope, Value, Variable
from .texts import EXPRESSION, Unsupported
from .values import Values

_SHORT = 90


class Elements(Values):
    """Renders elements that are kept."""

    named_texts = True  # what stands under a condition may be a named value

    def element(self, node: Xml) -> Any:
        """Return elements that are kept, as text."""
        lines = self.lines(node, "")
        text = "\n".join(lines)
        text = f"{text}\n" if len(lines) > 1 else text
        return Expression(text) if "${" in text else text

    def laid_out(self, text: str) -> str:
        """Return a plain text of an element as all elements are laid out; as it is where it might be evaluated."""
        if "$" in text or "<?" in text:
            return text
        try:
            return str(self.element(_piece(Document.parse(Source("", text)).root)))
        except MarkupError:
            return text

    def lines(self, node: Xml, pad: str) -> list[str]:
        """Return the lines of an element."""
        start = f"<{node.tag}" + "".join(
            f' {name}="{self.attribute(value, node.tag, name)}"' for name, value in node.attributes
        )
        content: list[str] = []
        plain = True
        named = next((value.text for name, value in node.attributes if name == "name"), node.tag)
        for item in self.merged(node.content):
            is_flag = named in self.spelt and isinstance(item, Value)
            content += [f"{pad}  {self.flag_of(item)}"] if is_flag else self.lines_of(item, f"{pad}  ")
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

    def flag_of(self, value: Value) -> str:
        """Return a text that is true or false, of which the kind is not known here, as Python prints it."""
        pieces = expanded(value.text.strip(), value.scope)
        if len(pieces) != 1 or pieces[0][0].kind != EXPRESSION:
            return str(self.joined(pieces, value, escape))
        node = ast.IfExp(self.node_of(pieces, value), ast.Constant("True"), ast.Constant("False"))
        return f"${{{written(node)}}}"

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

    def attribute(self, value: Value, tag: str, name: str) -> str:
        """Return the value of an attribute; what names a link or a joint of the part has its short name."""
        pieces = expanded(value.text, value.scope)
        prefix = self.macro.prefix if self.macro else None
        if prefix is not None and (tag, name) in (("gazebo", "reference"), ("joint", "name")):
            pieces = without_prefix(pieces, prefix) or pieces
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
        if len(lines) == 1 and text.startswith("${") and text.endswith("}") and text.count("${") == 1:
            return text[2:-1]  # evaluated where the condition holds alone: a list may be shorter elsewhere
        if not self.named_texts:
            node = node_of(Expression(" ".join(line.strip() for line in lines)))
            if node is None:
                raise Unsupported("a condition in elements that are kept")
            return written(node)
        for name, known in self.extra.items():
            if known == (Expression(text) if "${" in text else text):
                return name
        taken = self.taken()
        name = usable(name_of(text), lambda one: one in self.extra or one in taken)
        self.extra[name] = Expression(text) if "${" in text else text
        return name

    def taken(self) -> set[str]:
        """Return the names that a text cannot have: those of other values, and those that the language has."""
        macro = self.macro
        own = [*macro.variables.values(), *macro.implicit.values()] if macro else []
        own += macro.body.locals if macro and macro.body else []
        names = {one.ours for one in (*self.program.scope.names.values(), *own) if isinstance(one, Variable)}
        names |= {one.ours for one in self.macros} | set().union(*expression_names())
        for file in self.documents.files.values():
            names |= {key.partition("(")[0] for key in file.get("let", ())}
        return names | {"prefix", "mount", "name", "parent"}


def _piece(element: Element) -> Xml:
    made = Xml(element.tag)
    made.attributes = [(name, Value(one.value, Scope(), XML)) for name, one in element.attributes.items()]
    for item in element.content:
        if isinstance(item, Element):
            made.content.append(_piece(item))
        else:
            made.content.append(item if item.is_comment else Value(item.text, Scope(), XML))
    return made


_TAG = re.compile(r"<([A-Za-z_]\w*)((?:[^<>\"']|\"[^\"]*\"|'[^']*')*?)(/?)>|</[^>]*>")
_NAME = re.compile(r"\bname\s*=\s*[\"']([^\"']*)")


def name_of(text: str) -> str:
    """Return what some elements are called: after the package of their plug-in, their name, or what they are.

    >>> name_of("<plugin>mock_components/GenericSystem</plugin><param name='a'>1</param>")
    'mock_components'
    >>> name_of('<gpio name="${prefix}tool_io"/>'), name_of('<joint name="a"><b/></joint><joint name="c"/>')
    ('tool_io', 'joints')
    """
    plugin = re.match(r"\s*<plugin>\s*([^<]*)", text)
    if plugin and (found := _words(plugin[1].partition("/")[0])):
        return found
    tops: list[tuple[str, str]] = []
    depth = 0
    for tag in _TAG.finditer(text):
        if not tag[1]:
            depth -= 1
            continue
        if not depth:
            said = _NAME.search(tag[2])
            tops.append((tag[1], _words(said[1]) if said else ""))
        depth += not tag[3]
    if not tops:
        return "text"
    first, name = tops[0]
    if len(tops) == 1:
        return name or first
    return f"{first}s" if all(tag == first for tag, _ in tops) else f"{name or first}_and_more"


def _words(text: str) -> str:
    """Return the words of a name as one, without what is evaluated."""
    return re.sub(r"\W+", "_", re.sub(r"\$\{[^}]*\}", "", text), flags=re.ASCII).strip("_")

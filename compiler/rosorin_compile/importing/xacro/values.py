"""Write the formulas and texts of a xacro as values of a description: numbers, lists, texts, names and files."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from typing import Any

from rosorin_compile.formats.urdf.reading import ANGLES, LENGTHS
from rosorin_compile.source.numbers import exact

from ..layout import Expression, Verbatim, in_degrees
from .formulas import Formulas, as_angle, folded, in_words, literal, written
from .ir import ANY, FLAG, LET, LIST, NUMBER, PARAMETER, TEXT, Macro, Pieces, Program, Unsupported, Variable, flattened
from .part_names import PartNames

_NUMBER = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?")
_FULL_TURN, _LONG = 6.2832, 20


class Values:
    """Writes the values of a program.

    ``macro`` is the one that is written, and ``is_xml`` is set in elements that are kept. ``printed`` are variables
    that texts contain, and ``file_names`` parameters that are names of files. ``meshes`` is put before relative names
    of meshes, and ``address`` returns the name of a file that is loaded.
    """

    def __init__(
        self, program: Program, names: PartNames, formulas: Formulas, meshes: str | None, address: Callable[[str], str]
    ) -> None:
        self.program, self.names, self.formulas, self.meshes, self.address = program, names, formulas, meshes, address
        self.macro: Macro | None = None
        self.is_xml = False
        self.printed: set[Variable] = set()
        self.file_names: set[Variable] = set()
        self._is_passing = False  # what is written is given to a part, and not printed

    def number(self, pieces: Pieces, unit: str = "") -> Any:
        """Return a number. Raises Unsupported if a text is none."""
        if all(isinstance(piece, str) for piece in pieces):
            return number("".join(pieces).strip(), unit)
        return _in_unit(self.formulas.of_number(joined(pieces)), unit)

    def list_of(self, pieces: Pieces, count: int, unit: str = "") -> Any:
        """Return a list of numbers. Raises Unsupported if there are more or fewer."""
        words = in_words(pieces)
        if len(words) == count:
            return [self.number(word, unit) for word in words]
        if len(words) != 1 or (isinstance(words[0][0], str) and len(words[0]) == 1):
            raise Unsupported(f"{len(words)} numbers, not {count}")
        node = self.formulas.as_list(words[0][0] if len(words[0]) == 1 else joined(words[0]))
        return [_value(item, unit) for item in node.elts] if isinstance(node, ast.List) else _expression(node)

    def text(self, pieces: Pieces, name: bool = False, file: bool = False) -> Any:
        """Return a text with the expressions in it; a name without the prefix of the part."""
        macro = self.macro
        prefix = self.names.prefix.get(macro) if macro is not None else None
        short = self.names.short(pieces, prefix) if prefix is not None else None
        if macro is not None and prefix is not None and short is not None:
            if name and short and self.names.is_own(macro, short, self.is_xml):
                pieces = short
            elif prefix[1] and self.names.knows_prefix(macro):
                pieces = [ast.Name("prefix", ast.Load()), *short]
        return self.joined(self.file_name(pieces) if file else pieces)

    def file_name(self, pieces: Pieces) -> Pieces:
        """Return the name of a file: of a package by its address."""
        first = pieces[0] if pieces else ""
        if first == "file://":
            return self.file_name(pieces[1:])
        named = self.program.variables.get(getattr(first, "id", ""))
        if named is not None and named.kind == PARAMETER and len(pieces) == 1:
            self.file_names.add(named)
        for _ in self.program.variables:  # properties that begin with the folder of a package
            variable = self.program.variables.get(getattr(pieces[0], "id", "")) if pieces else None
            if variable is None or variable.kind != LET or variable.node is None:
                break
            inner = flattened([variable.node])
            if not inner or not (_is_find(inner[0]) or isinstance(inner[0], ast.Name)):
                break
            pieces = [*inner, *pieces[1:]]
        if pieces and _is_find(pieces[0]):
            return flattened([f"package://{pieces[0].args[0].value}", *pieces[1:]])
        if self.meshes and isinstance(first, str) and "://" not in first and not first.startswith("/"):
            return flattened([f"{self.meshes.rstrip('/')}/{first}", *pieces[1:]])
        return pieces

    def joined(self, pieces: Pieces, spelt: Callable[[str], str] = lambda text: text) -> Any:
        """Return pieces as one text."""
        made, plain = "", True
        for piece in flattened(pieces):
            if isinstance(piece, str):
                made += spelt(piece).replace("${", "$${")
                continue
            if not self._is_passing and isinstance(piece, ast.Name):
                self.printed |= set(self.program.variables_in(piece))
            node = self.formulas.printed(piece)
            if self.formulas.type(piece) == LIST and not isinstance(node, ast.Constant):
                node = self.formulas.as_text(piece)
            value = folded(node)
            if isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool)):
                made += spelt(str(value)).replace("${", "$${")
                continue
            made, plain = f"{made}${{{written(node)}}}", False
        return made.replace("$${", "${") if plain else Expression(made)

    def value(self, node: ast.expr, kind: str, unit: str = "") -> Any:
        """Return a formula as a value of a type."""
        plain = literal(node.value) if isinstance(node, ast.Constant) else None
        if isinstance(node, ast.Constant) and node.value is None:
            return None
        if isinstance(node, ast.Dict):
            keys = [str(one.value) if isinstance(one, ast.Constant) else "" for one in node.keys]
            return {key: self.value(one, self.formulas.type(one)) for key, one in zip(keys, node.values, strict=True)}
        if isinstance(node, ast.List) and any(isinstance(one, (ast.Dict, ast.List)) for one in node.elts):
            return [self.value(one, self.formulas.type(one)) for one in node.elts]
        if kind == LIST:
            return self._list(node, unit)
        if kind == FLAG:
            made = self.formulas.flag(node)
            decided = folded(made)
            return decided if isinstance(decided, bool) else _expression(made)
        if kind == NUMBER and isinstance(node, ast.Constant):
            return number(str(node.value), "")
        if kind == TEXT:
            pieces = flattened([node])
            if len(pieces) > 1 and _is_find(pieces[0]) and str(pieces[-1]).endswith((".yaml", ".yml")):
                first, *rest = flattened([f"package://{pieces[0].args[0].value}", *pieces[1:]])
                pieces = [self.address(first), *rest]
            self._is_passing = len(pieces) == 1
            text = self.text(pieces)
            self._is_passing = False
            return text
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            return str(node.value)
        if isinstance(plain, bool):
            return plain
        if kind == ANY and isinstance(node, ast.Call) and getattr(node.func, "id", "") == "__join":
            return self.joined([node])
        return _value(self.formulas.node(node), "")

    def _list(self, node: ast.expr, unit: str) -> Any:
        if isinstance(node, ast.Constant) and len(words := str(node.value).split()) > 1:
            return [number(word, unit) for word in words]
        made = self.formulas.as_list(node) if not isinstance(node, ast.List) else self.formulas.node(node)
        return [_in_unit(item, unit) for item in made.elts] if isinstance(made, ast.List) else _expression(made)

    def argument(self, node: ast.expr, variable: Variable) -> ast.expr:
        """Return a formula as an argument of a named value."""
        if variable in self.file_names:
            node = joined(self.file_name(flattened([node])))
        if variable.type == LIST:
            made = self.formulas.as_list(node)
        elif variable.type == FLAG:
            made = self.formulas.flag(node)
        elif variable.type == NUMBER and isinstance(node, ast.Constant):
            made = self.formulas.constant(literal(node.value))
        else:
            made = self.formulas.node(node)
        if variable.name.endswith("rpy") and isinstance(made, ast.List):
            return ast.List([_with_degrees(one) for one in made.elts], ast.Load())
        return made


def number(text: str, unit: str) -> Verbatim:
    """Return a number as it is written. Raises Unsupported if the text is none."""
    value = literal(text)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value or abs(value) == float("inf"):
        raise Unsupported(f'"{text[:40]}" is no number')
    if value == 0:
        return Verbatim("0")
    if unit == ANGLES and (degrees := in_degrees(float(value), "deg")):
        return Verbatim(degrees)
    made = text if _NUMBER.fullmatch(text) else exact(value)
    if unit == ANGLES and abs(value) > _FULL_TURN:
        made += " rad"
    elif unit == LENGTHS and abs(value) > _LONG:
        made += " m"
    return Verbatim(made)


def joined(pieces: Pieces) -> ast.expr:
    """Return a text as one formula."""
    parts = [ast.Constant(one) if isinstance(one, str) else one for one in pieces]
    return ast.Call(ast.Name("__join"), parts, [])


def _in_unit(node: ast.expr, unit: str) -> Any:
    if unit == ANGLES:
        value = folded(node)
        if value == 0:
            return Verbatim("0")
        degrees = in_degrees(float(value), "deg") if isinstance(value, (int, float)) else ""
        if degrees:
            return Verbatim(degrees)
        node = as_angle(node)
    return _value(node, unit)


def _value(node: ast.expr, unit: str) -> Any:
    """Return an expression of the language as a value."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    is_negative = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub)
    if isinstance(node, ast.Constant) or (is_negative and isinstance(node.operand, ast.Constant)):  # type: ignore[attr-defined]
        value = folded(node)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return number(written(node).replace(" ", ""), unit)
    if isinstance(node, ast.Name) and node.id in ("true", "false", "none"):
        return {"true": True, "false": False, "none": None}[node.id]
    return _expression(node)


def _expression(node: ast.expr) -> Expression:
    return Expression(f"${{{written(node)}}}")


def _with_degrees(node: ast.expr) -> ast.expr:
    value = folded(node)
    text = in_degrees(float(value), "deg") if isinstance(value, (int, float)) and value else ""
    return ast.Name(f"({text})" if text.startswith("-") else text) if text else node


def _is_find(node: Any) -> bool:
    return isinstance(node, ast.Call) and getattr(node.func, "id", "") == "find"

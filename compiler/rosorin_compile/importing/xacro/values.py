"""Convert pieces (strings and symbols to concatenate) of a xacro to values of a description, such as numbers."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.xml_reader import ANGLES, LENGTHS
from rosorin_compile.source.numbers import exact

from ..description import Expression, Verbatim, in_degrees
from . import ir
from .child import portable

if TYPE_CHECKING:
    from .program import Program

_NUMBER = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?")
_ANGULAR = ("acos", "asin", "atan", "atan2", "radians")
_FULL_TURN, _LONG = 6.2832, 20


class Values:
    """Converts pieces and symbols to values of a description; ``meshes`` is a prefix for relative mesh file names."""

    def __init__(self, program: Program, meshes: str | None) -> None:
        self.program, self.meshes = program, meshes

    def expression_text(self, node: ast.expr) -> str:
        """Format an expression, and mark the variables and packages in it as used."""
        for one in ast.walk(node):
            package = ir.Symbol(one, "", "", True).package if isinstance(one, ast.expr) else ""
            if package and not self.program.named.finds(package):
                self.program.named.unfound[package] = None
            if hasattr(one, "variable"):
                one.variable.used = True
                one.variable.counted |= not hasattr(one, "is_test")
                one.variable.as_written |= getattr(one, "is_text", False)
        return ir.as_text(node)

    def expression(self, node: ast.expr) -> Expression:
        """Wrap an expression in ``${...}``."""
        return Expression(f"${{{self.expression_text(node)}}}")

    def number(self, pieces: ir.Pieces, unit: str = "") -> Any:
        """Convert pieces (strings and symbols) to a number in ``unit``. Raises Untranslatable if impossible."""
        symbol = ir.symbol_of(ir.join_pieces(pieces))
        return self._plain(symbol.as_number(), unit) if symbol.constant is None else number(symbol.constant, unit)

    def list_of(self, pieces: ir.Pieces, count: int, unit: str = "") -> Any:
        """Convert pieces (strings, symbols) to ``count`` numbers in ``unit``. Raises Untranslatable if impossible."""
        words = ir.words_of(pieces)
        if len(words) == count:
            return [self.number(word, unit) for word in words]
        if len(words) != 1 or (isinstance(words[0][0], str) and len(words[0]) == 1):
            raise ir.Untranslatable(f"{len(words)} numbers, not {count}")
        return self._list(ir.symbol_of(ir.join_pieces(words[0])), unit)

    def file(self, pieces: ir.Pieces) -> Any:
        """Convert pieces (strings and symbols) to the file name of a mesh or texture."""
        return self.text(self._file_name(pieces))

    def _file_name(self, pieces: ir.Pieces) -> ir.Pieces:
        first = pieces[0] if pieces else ""
        if first == "file://":
            return self._file_name(pieces[1:])
        if isinstance(first, ir.Symbol):
            node: Any = first.node
            if not isinstance(node, ast.Call) or getattr(node.func, "id", "") != "find":
                return pieces
            package = ir.Symbol(node.args[0], ir.UNKNOWN, "text", first.known)
            return ir.pieces_of(ir.join_pieces(["package://", package, *pieces[1:]]))
        program = self.program
        first = portable(f"{first}x", program.packages, [*map(str, program.xacro.all_includes), program.file])[:-1]
        if self.meshes and "://" not in first and not first.startswith("/"):
            first = f"{self.meshes.rstrip('/')}/{first}"
        return [first, *pieces[1:]]

    def text(self, pieces: ir.Pieces, escape: Callable[[str], str] = lambda text: text) -> Any:
        """Convert pieces (strings and symbols) to a string, or to an Expression if any piece is not constant."""
        made, is_plain = "", True
        for piece in pieces:
            if isinstance(piece, str):
                made += escape(piece).replace("${", "$${")
                continue
            is_raw = isinstance(piece.value, str) or piece.type in ("number", "", "table")
            node = piece.node if is_raw and piece.type != "list" else piece.as_text()
            value = ir.fold(node)
            if isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool)):
                made += escape(str(value)).replace("${", "$${")
                continue
            if piece.variable is not None:
                piece.variable.printed = True
                piece.variable.as_written |= isinstance(piece.value, str)
            made, is_plain = f"{made}${{{self.expression_text(node)}}}", False
        return made.replace("$${", "${") if is_plain else Expression(made)

    def value(self, symbol: ir.Symbol, variable: ir.Variable, unit: str = "") -> Any:
        """Convert a symbol to a value of the description that has the type of ``variable``."""
        node = symbol.node
        if isinstance(node, ast.Name) and node.id == "none":
            return None
        if variable.type == "list":
            return self._list(symbol, unit)
        if variable.type == "boolean":
            decided = ir.fold(symbol.as_flag())
            return decided if isinstance(decided, bool) else self.expression(symbol.as_flag())
        if variable.type == "number":
            return self.number([symbol])
        if variable.names_mesh:
            return self.file(ir.pieces_of(symbol))
        if symbol.pieces or symbol.constant is not None or symbol.package or variable.type == "text":
            pieces = ir.pieces_of(symbol)
            if variable.names_file:
                pieces = self.program.named.name_of(pieces)
            is_passed = len(pieces) == 1 and isinstance(pieces[0], ir.Symbol)
            return self.expression(pieces[0].node) if is_passed else self.text(pieces)
        return self._plain(node)

    def argument(self, symbol: ir.Symbol, variable: ir.Variable) -> ast.expr:
        """Convert a symbol to an argument for a ``let`` function, by the type of its parameter ``variable``."""
        if variable.names_mesh:
            return ir.joined_node(self._file_name(ir.pieces_of(symbol)))
        if variable.type == "list":
            return symbol.as_list()
        if variable.type == "boolean":
            return symbol.as_flag()
        return symbol.as_number() if variable.type == "number" else symbol.node

    def _list(self, symbol: ir.Symbol, unit: str) -> Any:
        words, made = (symbol.constant or "").split(), symbol.as_list()
        if len(words) > 1:
            return [number(word, unit) for word in words]
        return self._plain(made, unit) if isinstance(made, ast.List) else self.expression(made)

    def _plain(self, node: ast.expr, unit: str = "") -> Any:
        """Convert an expression to a literal value in ``unit`` if it is constant, else to an Expression."""
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            return node.value
        if isinstance(node, ast.Dict):
            return {str(getattr(key, "value", "")): self._plain(value) for key, value in zip(node.keys, node.values)}  # noqa: B905
        if isinstance(node, ast.List):
            return [self._plain(item, unit) for item in node.elts]
        if isinstance(node, ast.Name) and node.id in ("true", "false", "none"):
            return {"true": True, "false": False, "none": None}[node.id]
        value = ir.fold(node)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            is_negative = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub)
            is_literal = isinstance(node.operand if is_negative else node, ast.Constant)  # type: ignore[attr-defined]
            degrees = in_degrees(float(value), "deg") if unit == ANGLES and value else ""
            if is_literal or value == 0 or degrees:
                return number(ir.as_text(node).replace(" ", ""), unit) if is_literal else Verbatim(degrees or "0")
        inner = node.args[0] if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "float" else None
        if unit == ANGLES and isinstance(inner, ast.Call) and getattr(inner.func, "id", "") in _ANGULAR:
            node = inner  # omit ``float()``, because the result is an angle
        return self.expression(node)


def number(text: str, unit: str) -> Verbatim:
    """Format a number with a unit, angles in degrees if that is exact. Raises Untranslatable for other text."""
    text, value = text.strip(), ir.number_in(text)
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

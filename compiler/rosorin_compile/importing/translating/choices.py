"""Choices: several values of one thing, each on a condition, as one value that chooses.

``<xacro:if>`` and ``<xacro:unless>`` around elements of one kind make alternatives. They are merged key by key, so that
what they share is said once, and what differs is ``${A if CONDITION else B}``.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Iterator
from copy import deepcopy
from pathlib import PurePosixPath
from typing import Any, TypeGuard

from ..key_order import in_order
from ..layout import Expression, Verbatim
from .expressions import all_of, negated, written

IF = Verbatim("if")
MAX_ATOMS = 8
_ZEROS = ("xyz", "rpy")
_NUMBER = re.compile(r"-?[\d.]+(e[-+]?\d+)?( [a-z/]+)?")

Condition = ast.expr | None
Alternative = tuple[Any, Condition]


def conditional(value: Any, when: Condition) -> Any:
    """Return a value with its condition."""
    if when is None:
        return value
    condition = Expression(f"${{{written(when)}}}")
    if isinstance(value, dict):
        return {IF: condition, **value}
    return {IF: condition, "value": value}


def merged(key: str, found: list[Alternative], sure: list[Condition] | None = None) -> Any:
    """Return alternatives as one value; None where they cannot be one.

    ``sure`` are conditions of which one holds anyway; without them nothing is known.
    """
    found = [one for one in found if one[1] is not None] + [one for one in found if one[1] is None]
    if sum(1 for _, when in found if when is None) > 1:
        return None
    whens = [when for _, when in found]
    covered = covers(whens, sure or [None])
    if all(value == found[0][0] for value, _ in found):
        return conditional(found[0][0], None if covered else any_of(whens))
    values = [value for value, _ in found]
    if all(isinstance(value, dict) for value in values):
        made: Any = _tables(found)
    elif all(isinstance(value, list) and any(isinstance(item, dict) for item in value) for value in values):
        made = _lists(found)
    else:
        return _chain(key, found, covered)
    return None if made is None else conditional(made, None if covered else any_of(whens))


def _tables(found: list[Alternative]) -> dict[Any, Any] | None:
    """Return mappings as one, key by key."""
    if any(IF in value for value, _ in found):
        return None
    keys = dict.fromkeys(key for value, _ in found for key in value)
    sure = [when for _, when in found]
    made: dict[Any, Any] = {}
    for key in in_order(keys):
        having = [(value[key], when) for value, when in found if key in value]
        made[key] = merged(str(key), having, sure)
        if made[key] is None:
            return None
    return made


def _lists(found: list[Alternative]) -> list[Any] | None:
    """Return lists of mappings as one: item by item where they are as long, else one after the other."""
    if len({len(value) for value, _ in found}) == 1:
        sure = [when for _, when in found]
        items = [merged("", [(value[at], when) for value, when in found], sure) for at in range(len(found[0][0]))]
        if None not in items:
            return items
    if any(isinstance(item, dict) and IF in item for value, _ in found for item in value):
        return None
    whens = [when for _, when in found]
    otherwise = None if None not in whens else all_of([negated(when) for when in whens if when is not None])
    return [conditional(item, when or otherwise) for value, when in found for item in value]


def _chain(key: str, found: list[Alternative], covered: bool) -> Any:
    """Return values as a choice of one of them."""
    texts = [value for value, _ in found]
    before, after = _shared(texts) if covered else ("", "")
    nodes = [node_of(_inner(value, before, after)) for value in texts]
    if None in nodes:
        return None
    pairs = [(node, when) for node, (_, when) in zip(nodes, found, strict=True) if node is not None]
    if not covered:
        zeros = ast.List([ast.Constant(0)] * 3, ast.Load())
        pairs.append((zeros if key in _ZEROS else ast.Constant(None), None))
    short = _by_single_conditions(pairs)
    if short is not None:
        items = [_said(item) for item in short]
        return items if len(items) > 1 else Expression(f"{before}{items[0]}{after}")
    last = pairs.pop()[0]
    for node, when in reversed(pairs):
        if when is None:
            return None
        last = node if written(node) == written(last) else ast.IfExp(when, node, last)
    return Expression(f"{before}${{{written(last)}}}{after}")


def _said(node: ast.expr) -> Any:
    text = written(node)
    return Verbatim(text) if _NUMBER.fullmatch(text) else Expression(f"${{{text}}}")


def _by_single_conditions(pairs: list[tuple[ast.expr, Condition]]) -> list[ast.expr] | None:
    """Return a choice that hangs on one condition, or a list each of whose items does; None for another."""
    rows = _rows([when for _, when in pairs])
    nodes = [node for node, _ in pairs]
    whole = _by_one(nodes, rows)
    lists = [node.elts for node in nodes if isinstance(node, ast.List) and len(node.elts) > 1]
    if len(lists) < len(nodes) or len({len(one) for one in lists}) > 1:
        return [whole] if whole is not None else None
    items = [_by_one([one[at] for one in lists], rows) for at in range(len(lists[0]))]
    differ = sum(1 for item in items if isinstance(item, ast.IfExp))
    if None in items or (whole is not None and differ > 1):
        return [whole] if whole is not None else None
    return [item for item in items if item is not None]


def _by_one(nodes: list[ast.expr], rows: list[tuple[dict[str, bool], int]]) -> ast.expr | None:
    """Return a choice of values by one condition; None if it takes several."""
    texts = [written(node) for node in nodes]
    used = list(dict.fromkeys(index for _, index in rows))
    if len({texts[index] for index in used}) == 1:
        return nodes[used[0]]
    for atom in rows[0][0] if rows else ():
        sides = {holds: {texts[index] for known, index in rows if known[atom] == holds} for holds in (True, False)}
        if len(sides[True]) == 1 == len(sides[False]):
            by_text = dict(zip(texts, nodes, strict=True))
            yes, no = (by_text[sides[holds].pop()] for holds in (True, False))
            return ast.IfExp(_parsed(atom), yes, no)
    return None


def _shared(texts: list[Any]) -> tuple[str, str]:
    """Return the folder and the ending that names of files share."""
    if any(not isinstance(text, str) or isinstance(text, (Expression, Verbatim)) or "${" in text for text in texts):
        return "", ""
    parts = zip(*(text.split("/")[:-1] for text in texts), strict=False)
    folder = "".join(f"{same[0]}/" for same in itertools.takewhile(lambda one: len(set(one)) == 1, parts))
    endings = {PurePosixPath(text).suffix for text in texts}
    if not folder or folder.endswith("//"):  # a scheme, and no package yet
        return "", ""
    return folder, endings.pop() if len(endings) == 1 else ""


def _inner(value: Any, before: str, after: str) -> Any:
    return value.removeprefix(before).removesuffix(after) if before else value


def node_of(value: Any) -> ast.expr | None:
    """Return a value of a document as an expression; None for a mapping."""
    if isinstance(value, Expression):
        return _of_text(value)
    if isinstance(value, Verbatim):
        return ast.Name(str(value), ast.Load())
    if isinstance(value, (str, bool)):
        return ast.Constant(value)
    if isinstance(value, list):
        items = [node_of(item) for item in value]
        return None if None in items else ast.List([item for item in items if item is not None], ast.Load())
    return None


def _of_text(value: str) -> ast.expr | None:
    """Return a text with expressions in it as one expression."""
    made: ast.expr | None = None
    pieces = re.split(r"(\$\{(?:[^{}'\"]|'[^']*'|\"[^\"]*\")*\})", value)
    pieces = [piece for piece in pieces if piece]
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
    except SyntaxError:  # it has units
        return ast.Name(f"({text})", ast.Load())


def any_of(whens: list[Condition]) -> Condition:
    """Return the condition that one of several holds; None if that is always so."""
    nodes = [when for when in whens if when is not None]
    if len(nodes) < len(whens):
        return None
    return nodes[0] if len(nodes) == 1 else ast.BoolOp(ast.Or(), nodes)


def covers(whens: list[Condition], sure: list[Condition]) -> bool:
    """Say whether one of some conditions holds whenever one of ``sure`` does, as far as one can see."""
    if None in whens:
        return True
    rows = _rows([*whens, *sure])
    return bool(rows) and not any(index >= len(whens) for _, index in rows)


def _rows(whens: list[Condition]) -> list[tuple[dict[str, bool], int]]:
    """Return what may be true together, each with the first of some conditions that then holds; nothing if too much.

    What holds none of them is left out.
    """
    compared = {written(one.left) for when in whens if when is not None for one in ast.walk(when) if _is_equal(one)}
    whens = [when if when is None else _Spread(compared).visit(deepcopy(when)) for when in whens]
    atoms = list(dict.fromkeys(atom for when in whens if when is not None for atom in _atoms(when)))
    if len(atoms) > MAX_ATOMS:
        return []
    found: list[tuple[dict[str, bool], int]] = []
    for row in itertools.product((True, False), repeat=len(atoms)):
        known = dict(zip(atoms, row, strict=True))
        index = next((at for at, when in enumerate(whens) if _holds(when, known)), -1)
        if index >= 0 and _may_be(known):
            found.append((known, index))
    return found


def _is_equal(node: ast.AST) -> TypeGuard[ast.Compare]:
    return isinstance(node, ast.Compare) and isinstance(node.ops[0], (ast.Eq, ast.NotEq))


class _Spread(ast.NodeTransformer):
    """Says of a name that is compared with texts anyway that it is one of several in these words."""

    def __init__(self, compared: set[str]) -> None:
        self.compared = compared

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        within, several = isinstance(node.ops[0], (ast.In, ast.NotIn)), node.comparators[0]
        if not within or not isinstance(several, ast.List) or written(node.left) not in self.compared:
            return node
        any_one = ast.BoolOp(ast.Or(), [ast.Compare(node.left, [ast.Eq()], [item]) for item in several.elts])
        return any_one if isinstance(node.ops[0], ast.In) else ast.UnaryOp(ast.Not(), any_one)


def _atoms(node: ast.expr) -> Iterator[str]:
    """Yield the conditions that a condition is made of."""
    if isinstance(node, ast.BoolOp):
        for item in node.values:
            yield from _atoms(item)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield from _atoms(node.operand)
    elif not isinstance(node, ast.Constant):
        yield _atom(node)[0]


def _atom(node: ast.expr) -> tuple[str, bool]:
    """Return a condition as text, and whether it is meant as it stands; ``!=`` and ``not in`` are not."""
    positive = negated(node)
    turned = isinstance(node, ast.Compare) and isinstance(node.ops[0], (ast.NotEq, ast.NotIn))
    return (written(positive), False) if turned and isinstance(positive, ast.Compare) else (written(node), True)


def _holds(node: Condition, known: dict[str, bool]) -> bool:
    if node is None:
        return True
    if isinstance(node, ast.Constant):
        return bool(node.value)
    if isinstance(node, ast.BoolOp):
        return (all if isinstance(node.op, ast.And) else any)(_holds(item, known) for item in node.values)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return not _holds(node.operand, known)
    text, meant = _atom(node)
    return known[text] == meant


def _may_be(known: dict[str, bool]) -> bool:
    """Say whether conditions may hold together: one name is not equal to two texts."""
    sides = [text.partition(" == ") for text, holds in known.items() if holds and " == " in text]
    plain = [left for left, _, right in sides if re.fullmatch(r"'[^']*'|-?[\d.]+", right)]
    return len(plain) == len(set(plain))


__all__ = ["IF", "any_of", "conditional", "covers", "merged", "node_of"]

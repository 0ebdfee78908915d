"""Mutants: one small fault in one line of a module, drawn by a seed in proportion to the lines of each module."""

from __future__ import annotations

import ast
import random
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

# Where mutants are planted: proofs, rules, placing, lowering and comparison, below compiler.
CORE = (
    *(
        "meaning/*.py",
        "meaning/*/*.py",
        "rules/*.py",
        "frontend/lower/*.py",
        "frontend/annotations.py",
        "frontend/mentions.py",
    ),
    *(f"frontend/expand/{name}.py" for name in ("mirroring", "naming", "placing", "prefixing")),
    *("formats/facts.py", "formats/expectation.py", "formats/*/facts.py", "formats/*/grammar.py"),
    *("formats/robot_model/__init__.py", "formats/static_tf*.py", "commands/diff.py", "commands/sides.py"),
)
OF_SECTIONS = tuple(f"sections/*/{name}.py" for name in ("lowering", "comparison", "rules", "rules/*"))
WHERE = (
    *(f"rosorin_compile/{pattern}" for pattern in (*CORE, *OF_SECTIONS)),
    *(
        f"rosorin_compile_mujoco/{pattern}"
        for pattern in ("mjcf/facts.py", "mjcf/proof.py", "mjcf/compared*.py", *OF_SECTIONS)
    ),
    *(
        f"rosorin_compile_ros/{pattern}"
        for pattern in ("srdf/__init__.py", "*/facts.py", "parameters/files.py", *OF_SECTIONS)
    ),
    *("rosorin_compile_ros/sections/control/urdf_rules.py", "rosorin_compile_sdf/sdf/facts.py"),
    *("rosorin_compile_sdf/sdf/grammar.py", "rosorin_compile_sdf/sdf/proof.py"),
)
_COMPARISONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "is": "is not", "is not": "is"}
_COMPARISONS |= {"in": "not in", "not in": "in"}
_WORDS: Mapping[type[ast.AST], str] = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Is: "is",
    ast.IsNot: "is not",
    ast.In: "in",
    ast.NotIn: "not in",
}
_SIGNS: Mapping[type[ast.AST], str] = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}


class Mutant(NamedTuple):
    """A fault: the module (as seen from ``compiler``), the line, what kind it is, and the text of the module with it.

    ``around`` is the function around, and the line as it is.
    """

    module: str
    line: int
    kind: str
    before: str
    after: str
    text: str
    around: str

    @property
    def name(self) -> str:
        """The mutant in words that stay when lines move: with its function and its line, for many a 0 becomes 1."""
        return f"{self.module}: {self.kind}: {self.before} -> {self.after} in {self.around}"


def modules(compiler: Path) -> list[Path]:
    """Return the modules in which mutants are planted."""
    return sorted({path for pattern in WHERE for path in compiler.glob(pattern)})


def drawn(compiler: Path, count: int, seed: int, lines: Mapping[str, set[int]]) -> list[Mutant]:
    """Return mutants of lines that a test runs (``lines`` by module), as many of a module as it has such lines."""
    chance = random.Random(seed)  # noqa: S311
    every = {path.relative_to(compiler).as_posix(): path for path in modules(compiler)}
    total = sum(len(lines.get(name, ())) for name in every)
    made: list[Mutant] = []
    for name, path in every.items():
        own = [one for one in mutants(path.read_text("utf-8"), name) if one.line in lines.get(name, ())]
        chance.shuffle(own)
        wanted = count * len(lines.get(name, ())) / max(1, total)
        made += own[: int(wanted) + (chance.random() < wanted % 1)]
    chance.shuffle(made)
    return made


def found(compiler: Path, names: Collection[str]) -> tuple[list[Mutant], list[str]]:
    """Return the mutants of some names, and the names that no mutant has any more.

    A line that stands in another module now, in a function of the same name, is the same line.
    """
    made: dict[tuple[Path, int], Mutant] = {}
    left = Counter(names)
    for of in (lambda name: name, lambda name: name.partition(": ")[2]):
        wanted: dict[str, list[str]] = {}
        for name in left.elements():
            wanted.setdefault(of(name), []).append(name)
        for path in modules(compiler) if wanted else ():
            for at, one in enumerate(mutants(path.read_text("utf-8"), path.relative_to(compiler).as_posix())):
                if wanted.get(of(one.name)) and (path, at) not in made:
                    left[wanted[of(one.name)].pop()] -= 1
                    made[path, at] = one
    return [*made.values()], sorted(left.elements())


def mutants(text: str, module: str) -> Iterator[Mutant]:
    """Yield every mutant of a module."""
    tree, source = ast.parse(text), _Text(text)
    functions = [
        node for node in ast.walk(tree) if isinstance(node, (ast.FunctionDef, ast.ClassDef))
    ]  # outer ones first
    for node in ast.walk(_without_hints(tree)):
        for kind, inner, after in _faults(node, source):
            before = source.of(inner)
            if before and after != before:
                within = [one.name for one in functions if one.lineno <= inner.lineno <= (one.end_lineno or 0)]
                around = f"{' '.join(within[-1:])}: {source.line(inner)}"
                words = _short(before), _short(after)
                yield Mutant(module, inner.lineno, kind, *words, source.replaced(inner, after), around)


class _Text:
    """The text of a module, in which nodes have places."""

    def __init__(self, text: str) -> None:
        self.whole = text.encode()
        self.lines = self.whole.splitlines(keepends=True)
        self.starts = [0, *accumulate(map(len, self.lines))]

    def _place(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        end = self.starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)
        return self.starts[node.lineno - 1] + node.col_offset, end

    def of(self, node: ast.expr | ast.stmt) -> str:
        """Return the text of a node."""
        return self.whole[slice(*self._place(node))].decode()

    def whole_of(self, node: ast.expr) -> str:
        """Return the text of an expression in parentheses."""
        return f"({self.of(node)})"

    def line(self, node: ast.expr | ast.stmt) -> str:
        """Return the line in which a node begins."""
        return self.lines[node.lineno - 1].decode().strip()

    def replaced(self, node: ast.expr | ast.stmt, after: str) -> str:
        """Return the text in which a node stands otherwise; its other lines stay where they are."""
        begin, end = self._place(node)
        return (self.whole[:begin] + after.encode() + self.whole[end:]).decode()


def _without_hints(tree: ast.Module) -> ast.Module:
    """Return a tree without annotations, docstrings and imports: a fault there is none."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            node.returns = None
            for argument in (*node.args.args, *node.args.kwonlyargs, *node.args.posonlyargs):
                argument.annotation = None
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [one for one in body if not isinstance(one, (ast.Import, ast.ImportFrom, ast.AnnAssign))]  # type: ignore[attr-defined]
            node.body = [one for one in node.body if not _is_text(one) and not _is_for_types(one)]  # type: ignore[attr-defined]
    return tree


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_for_types(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def _faults(node: ast.AST, text: _Text) -> Iterator[tuple[str, ast.expr | ast.stmt, str]]:
    """Yield the kind of a fault, the node that is replaced, and by what."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        word = _COMPARISONS[_WORDS[type(node.ops[0])]]
        yield "comparison", node, f"{text.whole_of(node.left)} {word} {text.whole_of(node.comparators[0])}"
    elif isinstance(node, ast.BoolOp):
        other = " or " if isinstance(node.op, ast.And) else " and "
        yield "boolean", node, f"({other.join(f'({text.of(one)})' for one in node.values)})"
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.Not, ast.USub)):
        yield ("boolean" if isinstance(node.op, ast.Not) else "sign"), node, f"({text.of(node.operand)})"
    elif isinstance(node, ast.BinOp) and type(node.op) in _SIGNS and not _is_of_texts(node):
        yield "sign", node, f"({text.whole_of(node.left)} {_SIGNS[type(node.op)]} {text.whole_of(node.right)})"
    elif isinstance(node, ast.Constant) and isinstance(node.value, (bool, int, float)):
        other_value = (not node.value) if isinstance(node.value, bool) else node.value + 1
        yield "number", node, repr(other_value)
    elif isinstance(node, ast.Return) and node.value is not None and not _is_none(node.value):
        yield "return", node, "return None"
    elif isinstance(node, (ast.Expr, ast.AugAssign, ast.Raise, ast.Continue, ast.Delete)):
        yield "dropped", node, "pass"


def _is_of_texts(node: ast.BinOp) -> bool:
    """Say whether an addition is one of texts or lists, as far as it can be seen."""
    return any(
        isinstance(one, (ast.JoinedStr, ast.List, ast.Tuple)) or _is_word(one) for one in (node.left, node.right)
    )


def _is_word(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _short(text: str) -> str:
    return " ".join(text.split())[:80]

"""Scopes: what the names of a xacro mean, and of which kind each value is, found from how it is used.

A ``Variable`` is an argument, a property or a parameter of a macro; ``Value`` a text of the source with the scope that
its names are looked up in, and the ``sink`` that says where it goes to. What flows from one variable into another is of
one kind.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from rosorin_compile.source.diagnostics import Span

from .texts import EXPRESSION, EXTENSION, TEXT, Token, signed, source_tree, tokens

ARGUMENT, GLOBAL, PARAMETER, LOCAL = "argument", "global", "parameter", "local"
# Kinds of variables.
NUMBER, FLAG, WORDS, LIST, TABLE, ANY = "number", "boolean", "text", "list", "table", "any"
# Sinks: of numbers by dimension, of lists of numbers, of texts.
NUMBERS = ("length", "angle", "mass", "number", "speed")
LISTS = ("length3", "angle3", "number3", "number4")
CONDITION, NAME, FILE, XML, FREE = "condition", "name", "file", "xml", "free"
LOADED = "loaded"
RETURNED = "returned"  # of what a macro sets for its caller

_LITERAL = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?\Z")
_OF_TEXTS = ("upper", "lower", "strip", "replace", "startswith", "endswith")
_FLAGS = {"true": True, "True": True, "false": False, "False": False}


@dataclass(eq=False)
class Value:
    """A text of the source, to be rendered once the kinds of all variables are known."""

    text: str
    scope: Scope
    sink: str
    span: Span | None = None
    idle: bool = False  # a default that no call takes


@dataclass(eq=False)
class Variable:
    """A named value of the source. ``values`` are what it is given, by definitions, calls and defaults."""

    name: str
    where: str
    ours: str = ""
    values: list[Value] = field(default_factory=list)
    evidence: set[str] = field(default_factory=set)
    used: bool = False
    span: Span | None = None
    definitions: list[tuple[Value, Any]] = field(default_factory=list)
    comments: tuple[str, ...] = ()
    unsaid: str = ""  # why its value cannot be said
    _group: Variable | None = None

    def __post_init__(self) -> None:
        self.ours = self.ours or self.name

    def head(self) -> Variable:
        """Return the variable that stands for all that one value flows through."""
        here = self
        while here._group is not None:
            here = here._group
        return here

    def join(self, other: Variable) -> None:
        """Take two variables for one kind."""
        one, two = self.head(), other.head()
        if one is not two:
            two._group = one
            one.evidence |= two.evidence
            one.values += two.values

    def kind(self) -> str:
        """Return what the variable holds."""
        head = self.head()
        values = [value for value in head.values if not value.idle] or head.values
        literals = [literal(value.text) for value in values if is_plain(value.text)]
        evidence = head.evidence
        if "=" in evidence and "" in literals and not any(isinstance(one, (int, float)) for one in literals):
            return WORDS  # several numbers, or none of them
        if any(sink in evidence for sink in LISTS) or (
            any(isinstance(one, list) for one in literals)
            and all(isinstance(one, list) or _is_quoted_list(one) for one in literals)
            and not evidence & {XML, NAME, FILE, "compared"}
        ):
            return LIST
        if TABLE in evidence:
            return TABLE
        numbers = [isinstance(one, (int, float)) and not isinstance(one, bool) for one in literals]
        counted = evidence & {*NUMBERS, "reckoned"} and literals and not any(isinstance(one, bool) for one in literals)
        if CONDITION in evidence and not counted and all(isinstance(one, bool) or one in (0, 1) for one in literals):
            return FLAG if literals or not evidence & set(NUMBERS) else NUMBER
        if literals and all(isinstance(one, bool) for one in literals):
            return FLAG
        if literals and all(numbers):
            return NUMBER
        if literals:
            return WORDS
        if evidence & {*NUMBERS, "reckoned", "equated"}:
            return NUMBER
        if values and all(_is_reckoned(one.text) for one in values):
            return NUMBER
        return WORDS if evidence & {XML, NAME, FILE, "compared"} else ANY

    def is_read(self) -> bool:
        """Say whether the variable is what stands in a table: a text or a number, whatever it is used as."""
        return any(_is_read(value.text, value.scope) for value in self.head().values)


@dataclass(eq=False)
class Bound:
    """A parameter of a macro that is written out where it is called: its value, in the scope of the call.

    Also a property that is set within an element; ``when`` are the conditions on which it alone is.
    """

    text: str
    scope: Scope
    when: tuple[Any, ...] = ()


@dataclass(eq=False)
class Returned:
    """A property that a macro sets for its caller: what the macro gives as a named value under a key; all if empty."""

    call: Any
    key: str


@dataclass(eq=False)
class Unsaid:
    """A property whose value cannot be said here, and why."""

    reason: str


class Scope:
    """Names of a file's top, of a macro, or of a macro that is written out; within ``parent``."""

    def __init__(self, parent: Scope | None = None, owner: str = "") -> None:
        self.parent = parent
        self.owner = owner
        self.names: dict[str, Variable | Bound | Returned | Unsaid] = {}
        self.blocks: dict[str, Any] = {}
        self.package_of: Any = parent.package_of if parent else None
        self.later: Later | None = None

    def latest(self) -> Scope:
        """Return the scope as it is by now: with what was set within elements so far."""
        scope: Scope = self
        while scope.later is not None:
            scope = scope.later
        return scope

    def begun(self) -> Scope:
        """Return the scope as it was before anything was set within elements."""
        return self

    def set_later(self, name: str) -> bool:
        """Say whether a name was set within an element."""
        later = self.later
        while later is not None and name not in later.names:
            later = later.later
        return later is not None

    def set_from_here(self, name: str, value: Variable | Bound | Returned | Unsaid) -> None:
        """Set a name for what comes after this; what was read before keeps what it was then."""
        now = self.latest()
        now.later = Later(now)
        now.later.names[name] = value

    def find(self, name: str) -> Variable | Bound | Returned | Unsaid | None:
        """Return what a name means here; one that nothing around knows is asked of the macro that this is in."""
        found = self.lookup(name)
        scope: Scope | None = self
        while found is None and scope is not None:
            found, scope = scope.handed_down(name), scope.parent
        return found

    def lookup(self, name: str) -> Variable | Bound | Returned | Unsaid | None:
        """Return what a name means here as far as this and what is around define it."""
        scope: Scope | None = self
        while scope is not None:
            found = scope.own(name)
            if found is not None:
                return found
            scope = scope.parent
        return None

    def handed_down(self, name: str) -> Variable | None:  # noqa: ARG002
        """Return what stands for a name of whoever calls; None outside of macros."""
        return None

    def own(self, name: str) -> Variable | Bound | Returned | Unsaid | None:
        """Return what a name means in this scope alone."""
        return self.names.get(name)

    def block(self, name: str) -> Any:
        """Return the block of a name: a parameter of a macro, or a property that holds elements."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.blocks:
                return scope.blocks[name]
            scope = scope.parent
        return None

    def top(self) -> Scope:
        """Return the scope of the whole robot."""
        scope = self
        while scope.parent is not None:
            scope = scope.parent
        return scope


class Space(Scope):
    """The names of files that are included with ``ns``: what they define is called ``SPACE.NAME`` elsewhere."""

    def __init__(self, parent: Scope, space: str) -> None:
        super().__init__(parent)
        self.space = space

    def own(self, name: str) -> Variable | Bound | Returned | Unsaid | None:
        return self.names.get(name) or (self.parent.own(f"{self.space}.{name}") if self.parent else None)


class Later(Scope):
    """A scope after a property was set within an element of it."""

    def __init__(self, before: Scope) -> None:
        super().__init__(before, before.owner)

    def begun(self) -> Scope:
        return self.parent.begun() if self.parent is not None else self


def is_plain(text: str) -> bool:
    """Say whether nothing in a text is evaluated."""
    return "$" not in text or all(piece.kind == TEXT for piece in tokens(text))


def literal(text: str) -> Any:
    """Return what a plain text is to xacro: a number, true or false, a text; a list where it is several numbers."""
    text = "".join(piece.text for piece in tokens(text)) if "$" in text else text
    if len(text) >= 2 and text[0] == "'" == text[-1]:
        return text[1:-1]
    if "_" in text:
        return text
    stripped = text.strip()
    if stripped in _FLAGS:
        return _FLAGS[stripped] if stripped == text else text
    if _LITERAL.match(stripped):
        return int(stripped) if re.fullmatch(r"[-+]?[0-9]+", stripped) else float(stripped)
    parts = stripped.split()
    if len(parts) > 1 and all(_LITERAL.match(part) for part in parts):
        return [float(part) for part in parts]
    return text


@lru_cache(4096)
def _is_reckoned(text: str) -> bool:
    """Say whether a text is the result of arithmetic, and of nothing that may be a text."""
    pieces = tokens(text)
    try:
        return len(pieces) == 1 and pieces[0].kind == EXPRESSION and _of_numbers(source_tree(pieces[0].text))
    except ValueError:
        return False


def _is_read(text: str, scope: Scope) -> bool:
    """Say whether a text is an entry of a table, or what a macro gives, by whichever name."""
    name = sole_name(tokens(text))
    found = scope.lookup(name) if name else None
    if isinstance(found, Bound):
        return _is_read(found.text, found.scope)
    return isinstance(found, Returned) or _is_entry(text)


@lru_cache(4096)
def _is_entry(text: str) -> bool:
    """Say whether a text is an entry of a table."""
    pieces = tokens(text)
    try:
        whole = source_tree(pieces[0].text) if len(pieces) == 1 and pieces[0].kind == EXPRESSION else None
    except ValueError:
        return False
    return isinstance(whole, (ast.Subscript, ast.Attribute))


def _of_numbers(node: ast.AST) -> bool:
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, (ast.USub, ast.UAdd))
    if not isinstance(node, ast.BinOp):
        return isinstance(node, ast.Constant) and type(node.value) in (int, float)
    sides = (node.left, node.right)
    if isinstance(node.op, (ast.Add, ast.Mult)):  # texts and lists can be added, and taken several times
        others = [one for one in sides if not isinstance(one, (ast.Name, ast.Attribute, ast.Subscript))]
        return all(map(_of_numbers, others)) and (bool(others) or isinstance(node.op, ast.Mult))
    return not isinstance(node.op, ast.Mod) or not isinstance(node.left, ast.Constant)


def _is_quoted_list(value: Any) -> bool:
    """Say whether a text that stood in quotes is several numbers."""
    return isinstance(value, str) and isinstance(literal(value), list)


def sole_name(pieces: list[Token]) -> str | None:
    """Return the name that a text is, and nothing else: of ``${name}``; of ``$(arg name)`` with ``arg `` before it."""
    if len(pieces) != 1:
        return None
    (kind, text), *_ = pieces
    if kind == EXPRESSION and is_argument(text):  # that of a parameter, in its place
        return sole_name(tokens(text))
    if kind == EXPRESSION and text.strip().isidentifier():
        return text.strip()
    if kind == EXTENSION and text.split()[:1] == ["arg"] and len(text.split()) == 2:
        return f"arg {text.split()[1]}"
    return None


def package_in(text: str, scope: Scope) -> str:
    """Return the package that a ``find`` names, with properties that have one plain text in their place."""
    made = ""
    for piece in tokens(text.strip().partition(" ")[2].strip()):
        name = sole_name([piece])
        found = scope.lookup(name) if name else None
        if isinstance(found, Bound) and is_plain(found.text):
            made += found.text
        elif isinstance(found, Variable) and found.where == GLOBAL and len(found.values) == 1:
            made += found.values[0].text
        else:
            made += piece.text if piece.kind == TEXT else f"${{{piece.text}}}"
    return made


def is_argument(text: str) -> bool:
    """Say whether a text is an argument and nothing else."""
    return re.fullmatch(r"\$\(arg\s+\w+\s*\)", text) is not None


def note(value: Value) -> None:
    """Take down what a use says of the variables in it."""
    from .texts import words

    pieces = tokens(value.text)
    sink = value.sink
    if sink in LISTS:
        parts = words(pieces)
        if len(parts) == 1:
            _note_pieces(parts[0], value.scope, sink)
        for part in parts if len(parts) > 1 else ():
            _note_pieces(part, value.scope, sink[:-1])
        return
    _note_pieces(pieces, value.scope, sink)


def _note_pieces(pieces: list[Token], scope: Scope, sink: str) -> None:
    name = sole_name(pieces)
    if name is not None:
        _evidence(name, scope, sink)
        return
    whole = len(pieces) == 1
    inside = sink if sink in (NAME, FILE) else XML
    if sink in NUMBERS and signed(pieces):
        inside = "reckoned"
    for kind, text in pieces:
        if kind == EXTENSION:
            words = text.split()
            if words[:1] == ["arg"] and len(words) == 2:
                _evidence(f"arg {words[1]}", scope, sink if whole else inside)
            elif words[:1] == ["eval"]:
                _note_expression(text.partition("eval")[2], scope, sink if whole else inside)
        elif kind == EXPRESSION:
            _note_expression(text, scope, sink if whole else inside)


def _evidence(name: str, scope: Scope, sink: str, depth: int = 0) -> None:
    found = scope.find(name)
    if isinstance(found, Bound) and depth < 20:
        note(Value(found.text, found.scope, sink))
    elif isinstance(found, Variable):
        found.head().evidence.add(sink)


def _note_expression(text: str, scope: Scope, sink: str) -> None:
    try:
        tree = source_tree(text)
    except ValueError:
        return
    _note_node(tree, scope, sink)


def _note_node(node: ast.AST, scope: Scope, sink: str) -> None:
    node = _unworded(node)
    if isinstance(node, ast.Name):
        _evidence(_spelt(node.id), scope, sink)
    elif isinstance(node, ast.IfExp):
        _note_node(node.test, scope, CONDITION)
        _note_node(node.body, scope, sink)
        _note_node(node.orelse, scope, sink)
    elif isinstance(node, ast.BoolOp):
        for item in node.values:
            _note_node(item, scope, CONDITION if sink in (CONDITION, FREE, XML) else sink)
    elif isinstance(node, ast.UnaryOp):
        _note_node(node.operand, scope, CONDITION if isinstance(node.op, ast.Not) else "reckoned")
    elif isinstance(node, ast.Compare):
        _note_comparison(node, scope)
    elif isinstance(node, ast.BinOp):
        how = "compared" if _adds_texts(node) else "reckoned"
        _note_node(node.left, scope, how)
        _note_node(node.right, scope, how)
    elif isinstance(node, (ast.Subscript, ast.Attribute)):
        _note_node(node.value, scope, TABLE if not _by_number(node) else "indexed")
        if isinstance(node, ast.Subscript):
            _note_node(node.slice, scope, FREE)
    elif isinstance(node, ast.Call):
        _note_call(node, scope)
    else:
        for child in ast.iter_child_nodes(node):
            _note_node(child, scope, FREE)


def _note_call(node: ast.Call, scope: Scope) -> None:
    method = getattr(node.func, "attr", "")
    if method in _OF_TEXTS:
        _note_node(node.func.value, scope, "compared")  # type: ignore[attr-defined]
        for item in node.args:
            _note_node(item, scope, "compared")
    elif method == "split":  # of a text, or of several numbers
        _note_node(node.func.value, scope, FREE)  # type: ignore[attr-defined]
    else:
        loads = ast.unparse(node.func) in ("xacro.load_yaml", "load_yaml")
        for child in ast.iter_child_nodes(node):
            _note_node(child, scope, LOADED if loads else FREE)


def _adds_texts(node: ast.expr) -> bool:
    """Say whether a sum has a text among what it adds."""
    if isinstance(node, ast.BinOp):
        return isinstance(node.op, (ast.Add, ast.Mod)) and (_adds_texts(node.left) or _adds_texts(node.right))
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _by_number(node: ast.AST) -> bool:
    index = getattr(node, "slice", None)
    return isinstance(node, ast.Subscript) and not (isinstance(index, ast.Constant) and isinstance(index.value, str))


def _note_comparison(node: ast.Compare, scope: Scope) -> None:
    items = [_unworded(item) for item in (node.left, *node.comparators)]
    values = [item.value for item in items if isinstance(item, ast.Constant)]
    sink = FREE
    if any(isinstance(value, str) for value in values):
        flags = all(value in _FLAGS for value in values if isinstance(value, str))
        sink = CONDITION if flags else "compared"
    elif values and not any(isinstance(value, bool) for value in values):
        sink = "equated" if all(value in (0, 1) for value in values) else "reckoned"
    for item in items:
        if isinstance(item, ast.Name):
            found = scope.find(_spelt(item.id))
            if isinstance(found, Variable):
                found.head().evidence.add(sink)
                for value in values:
                    if isinstance(value, str):
                        found.head().evidence.add(f"={value}")
        else:
            _note_node(item, scope, FREE)


def _unworded(node: Any) -> Any:
    """Return the name of an argument that stands in quotes."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "__text":
        return node.args[0]
    return node


def _spelt(name: str) -> str:
    """Return a name of an expression as a scope has it; those of arguments were marked."""
    return f"arg {name.removeprefix('__arg_')}" if name.startswith("__arg_") else name


def names_of(node: ast.AST) -> Iterator[str]:
    """Yield the names of an expression, as scopes have them."""
    for one in ast.walk(node):
        if isinstance(one, ast.Name):
            yield _spelt(one.id)

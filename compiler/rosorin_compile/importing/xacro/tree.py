"""The intermediate representation of a xacro: macros, calls, properties, conditions, blocks and texts.

Every text is resolved: its names are references to variables (``Ref``), or the expressions that they stand for.
"""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.xml.markup import Document, Element

from .texts import EXPRESSION, TEXT, Parameter, tokens

ARGUMENT, GLOBAL, PARAMETER, LOCAL = "argument", "global", "parameter", "local"
# Kinds of variables.
NUMBER, FLAG, WORDS, LIST, TABLE, ANY = "number", "boolean", "text", "list", "table", "any"
# What a text is used for: a number by its dimension, a list of numbers, a text.
NUMBERS = ("length", "angle", "mass", "number", "speed")
LISTS = ("length3", "angle3", "number3", "number4")
CONDITION, NAME, FILE, XML, FREE, LOADED = "condition", "name", "file", "xml", "free", "loaded"
RAW, FOLDER = "raw", "folder"  # pieces: the text of an argument as it is given, the folder of a package

_LITERAL = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?\Z")
_FLAGS = {"true": True, "True": True, "false": False, "False": False}
_TEXT_METHODS = ("upper", "lower", "strip", "replace", "startswith", "endswith")


Place = tuple[str, int, int]


def place_of(span: Span) -> Place:
    """Return the file, line and column of a span."""
    return os.path.abspath(span.source.path), span.line, span.column


class Ref(ast.Name):
    """A name in an expression that refers to a variable."""

    variable: Variable


def ref(variable: Variable) -> Ref:
    """Return a reference to a variable; those to different variables differ in ``ast.dump``."""
    made = Ref(f"{variable.name} {id(variable)}", ast.Load())
    made.variable = variable
    return made


class Joined(ast.expr):
    """A text of several pieces within an expression."""

    _fields = ("values",)
    pieces: list[Piece]


class Piece(NamedTuple):
    """A piece of a text: TEXT, EXPRESSION (an expression), RAW (an argument), FOLDER (the name of a package)."""

    kind: str
    value: Any


@dataclass(eq=False)
class Text:
    """A resolved text and what it is used for. ``idle``: a default that no call takes."""

    pieces: list[Piece]
    sink: str = FREE
    span: Span | None = None
    idle: bool = False

    @property
    def plain(self) -> str | None:
        """The text, or None if something in it is evaluated."""
        if all(piece.kind == TEXT for piece in self.pieces):
            return "".join(piece.value for piece in self.pieces)
        return None

    def variable(self) -> Variable | None:
        """Return the variable that the text is, and nothing else."""
        if len(self.pieces) == 1 and isinstance(self.pieces[0].value, Ref):
            return self.pieces[0].value.variable
        return None

    def node(self) -> ast.expr:
        """Return the text as xacro evaluates it in an expression."""
        plain = self.plain
        if plain is not None:
            made: Any = constant(literal(plain))
            if isinstance(made, ast.List):
                made.text = plain  # type: ignore[attr-defined]
            return made  # type: ignore[no-any-return]
        if len(self.pieces) == 1 and self.pieces[0].kind in (EXPRESSION, RAW):
            return self.pieces[0].value  # type: ignore[no-any-return]
        made = Joined()
        made.pieces = self.pieces
        made.values = [p.value if isinstance(p.value, ast.expr) else ast.Constant(p.value) for p in self.pieces]
        return made  # type: ignore[no-any-return]

    def for_use(self, sink: str) -> Text:
        """Return the text for another use; quotes mark a text for xacro, and are not part of it."""
        plain = self.plain
        if plain is not None and len(plain) > 1 and plain[0] == "'" == plain[-1]:
            return Text([Piece(TEXT, plain[1:-1])], sink, self.span)
        return Text(self.pieces, sink, self.span)


def merged_pieces(pieces: list[Piece]) -> list[Piece]:
    """Return pieces with adjacent plain ones as one."""
    made: list[Piece] = []
    for piece in pieces:
        if made and piece.kind == TEXT == made[-1].kind:
            made[-1] = Piece(TEXT, made[-1].value + piece.value)
        else:
            made.append(piece)
    return made


def constant(value: Any) -> ast.expr:
    """Return a value as a node; a list of numbers as a list."""
    if isinstance(value, list):
        return ast.List([constant(int(item) if float(item).is_integer() else item) for item in value], ast.Load())
    return ast.Constant(value)


def literal(text: str) -> Any:
    """Return what a plain text is to xacro: a number, true or false, a text; a list where it is several numbers."""
    if len(text) >= 2 and text[0] == "'" == text[-1]:
        return text[1:-1]
    stripped = text.strip()
    if "_" in text or stripped in _FLAGS:
        return _FLAGS.get(text, text)
    if _LITERAL.match(stripped):
        return int(stripped) if re.fullmatch(r"[-+]?[0-9]+", stripped) else float(stripped)
    parts = stripped.split()
    if len(parts) > 1 and all(_LITERAL.match(part) for part in parts):
        return [float(part) for part in parts]
    return text


def is_plain(text: str) -> bool:
    """Return True if nothing in a text of xacro is evaluated."""
    return "$" not in text or all(token.kind == TEXT for token in tokens(text))


def words(pieces: list[Piece]) -> list[list[Piece]]:
    """Return the words of a text, each as its pieces: separated by the white space of plain pieces."""
    made: list[list[Piece]] = []
    fresh = True
    for piece in pieces:
        for part in re.split(r"(\s+)", piece.value) if piece.kind == TEXT else [None]:
            if part == "":
                continue
            if part is not None and part.isspace():
                fresh = True
                continue
            if fresh:
                made.append([])
            made[-1].append(piece if part is None else Piece(TEXT, part))
            fresh = False
    return made


def signed(pieces: list[Piece]) -> tuple[str, Piece, str] | None:
    """Return the sign, the evaluated piece and the exponent of a number such as ``-${x}e-3``; None for other texts."""
    found = [index for index, piece in enumerate(pieces) if piece.kind != TEXT]
    if len(found) != 1 or len(pieces) == 1:
        return None
    (at,) = found
    sign = "".join(piece.value for piece in pieces[:at]).lstrip()
    exponent = "".join(piece.value for piece in pieces[at + 1 :]).rstrip()
    fits = sign in ("", "+", "-") and re.fullmatch(r"([eE][-+]?[0-9]+)?", exponent) and (sign or exponent)
    return (sign, pieces[at], exponent) if fits else None


def references(text: Text) -> Iterator[Variable]:
    """Yield the variables that a text uses, each time."""
    for piece in text.pieces:
        if isinstance(piece.value, ast.expr):
            yield from references_in(piece.value)


def references_in(node: ast.AST) -> Iterator[Variable]:
    """Yield the variables that a node refers to, each time."""
    for one in ast.walk(node):
        if isinstance(one, Ref):
            yield one.variable


@dataclass(eq=False)
class Variable:
    """A named value: an argument, a property, or a parameter of a macro.

    ``values`` are what it is given: its value, its default, what calls give. ``pending`` is the text of a property
    with its scope until it is first read: xacro evaluates it then.
    """

    name: str
    where: str
    ours: str = ""
    values: list[Text] = field(default_factory=list)
    evidence: set[str] = field(default_factory=set)
    span: Span | None = None
    comments: tuple[str, ...] = ()
    pending: tuple[str, Scope] | None = None
    raw: str = ""
    file: File | None = None
    is_read: bool = False
    _group: Variable | None = None

    def __post_init__(self) -> None:
        self.ours = self.ours or self.name

    def head(self) -> Variable:
        """Return the variable that represents all variables that one value flows through."""
        here = self
        while here._group is not None:
            here = here._group
        return here

    def join(self, other: Variable) -> None:
        """Make two variables of one kind."""
        mine, theirs = self.head(), other.head()
        if mine is not theirs:
            theirs._group = mine
            mine.evidence |= theirs.evidence
            mine.values += theirs.values

    def kind(self) -> str:
        """Return what the variable holds, from its values and its uses."""
        head = self.head()
        values = [value for value in head.values if not value.idle] or head.values
        leaves = [leaf for value in values for leaf in _leaves(value)]
        literals = [literal(leaf.plain) for leaf in leaves if leaf.plain is not None]
        evidence = head.evidence
        used_as_text = evidence & {XML, NAME, FILE, "compared"}
        has_numbers = any(isinstance(one, (int, float)) and not isinstance(one, bool) for one in literals)
        if "=" in evidence and "" in literals and not has_numbers:
            return WORDS  # several numbers, or none of them
        if any(sink in evidence for sink in LISTS) or (
            not used_as_text
            and any(isinstance(one, list) for one in literals)
            and all(
                isinstance(one, list) or (isinstance(one, str) and isinstance(literal(one), list)) for one in literals
            )
        ):
            return LIST
        if TABLE in evidence:
            return TABLE
        flags = [isinstance(one, bool) for one in literals]
        counted = evidence & {*NUMBERS, "reckoned"} and literals and not any(flags)
        if CONDITION in evidence and not counted and all(isinstance(one, bool) or one in (0, 1) for one in literals):
            return FLAG if literals or not evidence & set(NUMBERS) else NUMBER
        if literals and all(flags):
            return FLAG
        if literals:
            numeric = all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in literals)
            return NUMBER if numeric else WORDS
        if evidence & {*NUMBERS, "reckoned", "equated"}:
            return NUMBER
        if leaves and all(_is_arithmetic(leaf) for leaf in leaves):
            return NUMBER
        return WORDS if used_as_text else ANY

    def is_entry(self) -> bool:
        """Return True if the variable holds an entry of a table, which may be a text or a number."""
        leaves = (leaf for value in self.head().values for leaf in _leaves(value))
        nodes = [leaf.pieces[0].value for leaf in leaves if len(leaf.pieces) == 1]
        return any(isinstance(node, (ast.Subscript, ast.Attribute)) for node in nodes)


def _leaves(text: Text) -> Iterator[Text]:
    """Yield the values that a text may have: those that a condition chooses from."""
    node = text.pieces[0].value if len(text.pieces) == 1 else None
    if isinstance(node, ast.IfExp):
        for side in (node.body, node.orelse):
            yield from _leaves(Text([Piece(EXPRESSION, side)]))
    elif isinstance(node, ast.Constant) and node.value is not None:
        yield Text([Piece(TEXT, str(node.value))])
    elif isinstance(node, ast.List) and all(isinstance(item, ast.Constant) for item in node.elts):
        yield Text([Piece(TEXT, " ".join(str(item.value) for item in node.elts))])  # type: ignore[attr-defined]
    elif not (isinstance(node, ast.Constant) and node.value is None):
        yield text


def _is_arithmetic(text: Text) -> bool:
    return len(text.pieces) == 1 and text.pieces[0].kind == EXPRESSION and _of_numbers(text.pieces[0].value)


def _of_numbers(node: ast.AST) -> bool:
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, (ast.USub, ast.UAdd))
    if isinstance(node, ast.Name) and node.id in ("pi", "e", "tau"):
        return True
    if not isinstance(node, ast.BinOp):
        return isinstance(node, ast.Constant) and type(node.value) in (int, float)
    sides = (node.left, node.right)
    if isinstance(node.op, (ast.Add, ast.Mult)):  # texts and lists can be added, and multiplied
        others = [side for side in sides if not isinstance(side, (ast.Name, ast.Attribute, ast.Subscript))]
        return all(map(_of_numbers, others)) and (bool(others) or isinstance(node.op, ast.Mult))
    return not isinstance(node.op, ast.Mod) or not isinstance(node.left, ast.Constant)


# Evidence: what uses of a variable say of its kind.


def note(text: Text) -> None:
    """Record what the use of a text says of the kinds of its variables."""
    if text.sink not in LISTS:
        _note_pieces(text.pieces, text.sink)
        return
    parts = words(text.pieces)
    if len(parts) == 1:
        _note_pieces(parts[0], text.sink)
    for part in parts if len(parts) > 1 else ():
        _note_pieces(part, text.sink[:-1])


def _note_pieces(pieces: list[Piece], sink: str) -> None:
    if len(pieces) > 1:
        inside = sink if sink in (NAME, FILE) else XML
        sink = "reckoned" if sink in NUMBERS and signed(pieces) else inside
    for piece in pieces:
        if isinstance(piece.value, ast.expr):
            _note_node(piece.value, sink)


def _note_node(node: ast.AST, sink: str) -> None:
    node = unquoted(node)
    if isinstance(node, Ref):
        node.variable.head().evidence.add(sink)
    elif isinstance(node, Joined):
        _note_pieces(node.pieces, sink)
    elif isinstance(node, ast.IfExp):
        _note_node(node.test, CONDITION)
        _note_node(node.body, sink)
        _note_node(node.orelse, sink)
    elif isinstance(node, ast.BoolOp):
        for item in node.values:
            _note_node(item, CONDITION if sink in (CONDITION, FREE, XML) else sink)
    elif isinstance(node, ast.UnaryOp):
        _note_node(node.operand, CONDITION if isinstance(node.op, ast.Not) else "reckoned")
    elif isinstance(node, ast.Compare):
        _note_comparison(node)
    elif isinstance(node, ast.BinOp):
        for side in (node.left, node.right):
            _note_node(side, "compared" if _adds_texts(node) else "reckoned")
    elif isinstance(node, (ast.Subscript, ast.Attribute)):
        index = getattr(node, "slice", None)
        by_number = index is not None and not (isinstance(index, ast.Constant) and isinstance(index.value, str))
        _note_node(node.value, "indexed" if by_number else TABLE)
        if index is not None:
            _note_node(index, FREE)
    elif isinstance(node, ast.Call):
        _note_call(node)
    else:
        for child in ast.iter_child_nodes(node):
            _note_node(child, FREE)


def _note_call(node: ast.Call) -> None:
    function = node.func
    called = getattr(function, "id", "") or getattr(function, "attr", "")
    if isinstance(function, ast.Attribute) and called not in ("load_yaml", "dotify"):
        sink = "compared" if called in _TEXT_METHODS else FREE
        _note_node(function.value, FREE if called == "split" else sink)
        sinks = [sink] * len(node.args)
    else:
        sinks = [LOADED if called == "load_yaml" else CONDITION if called == "__flag" else FREE] * len(node.args)
    for item, sink in zip(node.args, sinks, strict=True):
        _note_node(item, sink)
    for keyword in node.keywords:
        _note_node(keyword.value, FREE)


def _adds_texts(node: ast.expr) -> bool:
    if isinstance(node, ast.BinOp):
        return isinstance(node.op, (ast.Add, ast.Mod)) and (_adds_texts(node.left) or _adds_texts(node.right))
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _note_comparison(node: ast.Compare) -> None:
    items = [unquoted(item) for item in (node.left, *node.comparators)]
    constants = [one for item in items for one in (item.elts if isinstance(item, (ast.List, ast.Tuple)) else [item])]
    values = [one.value for one in constants if isinstance(one, ast.Constant)]
    sink = FREE
    if any(isinstance(value, str) for value in values):
        only_flags = all(value in _FLAGS for value in values if isinstance(value, str))
        sink = CONDITION if only_flags else "compared"
    elif values and not any(isinstance(value, bool) for value in values):
        sink = "equated" if all(value in (0, 1) for value in values) else "reckoned"
    for item in items:
        if isinstance(item, Ref):
            evidence = item.variable.head().evidence
            evidence.add(sink)
            evidence.update(f"={value}" for value in values if isinstance(value, (str, int)))
        else:
            _note_node(item, FREE)


def unquoted(node: Any) -> Any:
    """Return the reference to an argument in quotes."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "__text":
        return node.args[0]
    return node


class Scope:
    """Names of a file, a macro, or a macro that is expanded inline. ``space`` holds the names of its namespace."""

    def __init__(self, parent: Scope | None = None, macro: Macro | None = None, body: Body | None = None) -> None:
        self.parent = parent
        self.macro = macro  # the macro that is a part or a value, whose names these are
        self.body = body if body is not None else None
        self.names: dict[str, Variable | Bound] = {}
        self.blocks: dict[str, Any] = {}
        self.macros: dict[str, list[tuple[Macro, Whens]]] = {}
        self.spaces: dict[str, Scope] = {}
        self.space: Scope = parent.space if parent is not None else self

    def around(self) -> Iterator[Scope]:
        """Yield the scope and those around it, then its namespace."""
        here: Scope | None = self
        while here is not None:
            yield here
            here = here.parent
        here = self.space
        while here is not None:
            yield here
            here = here.parent

    def find(self, name: str) -> Variable | Bound | None:
        """Return what a name is bound to."""
        return next((scope.names[name] for scope in self.around() if name in scope.names), None)

    def owner(self) -> Macro | None:
        """Return the macro that the scope belongs to, if that is a part or a value."""
        return next((scope.macro for scope in self.around() if scope.macro is not None), None)


@dataclass(eq=False)
class Bound:
    """A name that stands for a text: of a scope, until it is read."""

    raw: str
    scope: Scope | None = None
    text: Text | None = None
    reading: bool = False


class When(NamedTuple):
    """A condition; ``holds`` is False for ``xacro:unless``."""

    test: Text
    holds: bool


Whens = tuple[When, ...]


class Item(NamedTuple):
    """A key of an entry with its value: a Text, an Entry, a list of Listed, a Given, or Handed under the key "&"."""

    key: str
    value: Any
    when: Whens = ()


class Listed(NamedTuple):
    """An item of a list; ``element`` is the element at the level of links that it is or belongs to."""

    value: Any
    when: Whens = ()
    comments: tuple[str, ...] = ()
    element: Element | None = None


class Entry:
    """A mapping to be written; a key may occur several times, on different conditions."""

    def __init__(self) -> None:
        self.items: list[Item] = []

    def put(self, key: str, value: Any, when: Whens = ()) -> None:
        self.items.append(Item(key, value, when))

    def add(self, key: str, value: Any, when: Whens = (), comments: tuple[str, ...] = ()) -> None:
        """Add an item to the list of a key."""
        for item in self.items:
            if item.key == key and isinstance(item.value, list):
                item.value.append(Listed(value, when, comments))
                return
        self.items.append(Item(key, [Listed(value, when, comments)]))

    def keys(self) -> list[str]:
        return list(dict.fromkeys(item.key for item in self.items))

    def may_lack(self, key: str) -> bool:
        """Return True if a key depends on conditions, other than on one that holds and that does not."""
        whens = [item.when for item in self.items if item.key == key]
        if len(whens) == 2 and all(len(when) == 1 for when in whens):
            (one,), (other,) = whens
            same = dumped(one.test) == dumped(other.test)
            return not same or one.holds == other.holds
        return any(whens)


def dumped(text: Text) -> str:
    """Return a text in a form that is equal for equal texts."""
    return "".join(ast.dump(p.value) if isinstance(p.value, ast.expr) else f"{p.kind}{p.value}" for p in text.pieces)


@dataclass(eq=False)
class File:
    """A file of the source; ``name`` is its file in the description."""

    path: str
    document: Document
    name: str
    body: Body = field(init=False)


@dataclass(eq=False)
class Macro:
    """A macro: its source, its parameters, and what it makes.

    ``level`` is where it is called: ``robot`` (it becomes a part), ``xml`` (a named text) or an element such as
    ``link`` (a named value). ``reads`` are the names from outside that it reads, ``implicit`` names of its callers.
    """

    name: str
    element: Element
    file: File
    parameters: list[Parameter]
    space: Scope
    comments: tuple[str, ...] = ()
    ours: str = ""
    level: str = ""
    scope: Scope = field(default_factory=Scope)
    variables: dict[str, Variable] = field(default_factory=dict)
    implicit: dict[str, Variable] = field(default_factory=dict)
    reads: dict[str, Variable | Bound] = field(default_factory=dict)
    defaults: dict[str, Text] = field(default_factory=dict)
    block_levels: dict[str, str] = field(default_factory=dict)  # where each block is inserted
    blocks_given: dict[str, list[Entry]] = field(default_factory=dict)
    body: Body | None = None
    entry: Entry | None = None
    text: list[Any] | None = None
    uses: list[Use] = field(default_factory=list)
    called: bool = False
    prefix: tuple[Variable, str] | None = None
    mount: Variable | None = None
    origin: str = ""
    relative: Variable | None = None
    sets: dict[str, Variable | Bound | None] = field(default_factory=dict)  # of its caller
    makes_materials: bool = False
    pinned: set[str] = field(default_factory=set)  # parameters with one value
    by_key: bool = False


@dataclass(eq=False)
class Named:
    """A link, a joint or a material."""

    name: Text
    entry: Entry
    when: Whens
    comments: tuple[str, ...]
    element: Element


@dataclass(eq=False)
class Call:
    """A call of a macro: of a part (with conditions and comments), or of a named value."""

    macro: Macro
    given: dict[str, Text]
    blocks: dict[str, Entry]
    element: Element
    when: Whens = ()
    comments: tuple[str, ...] = ()


Use = Call


class Given(NamedTuple):
    """What a call of a named value gives under one key, or one item of a list there."""

    call: Call
    key: str
    at: int = -1


class Handed(NamedTuple):
    """A block that a macro is handed over, where it is inserted."""

    macro: Macro
    name: str


@dataclass(eq=False)
class Xml:
    """An element that is kept as text. Without a tag, a group on a condition."""

    tag: str
    attributes: list[tuple[str, Text]] = field(default_factory=list)
    content: list[Any] = field(default_factory=list)
    when: Whens = ()


@dataclass(eq=False)
class Body:
    """What a file holds apart from its macros, or what a macro holds."""

    file: File
    macro: Macro | None = None
    links: list[Named] = field(default_factory=list)
    joints: list[Named] = field(default_factory=list)
    uses: list[Call] = field(default_factory=list)
    elements: list[Listed] = field(default_factory=list)
    materials: list[Named] = field(default_factory=list)
    locals: list[Variable] = field(default_factory=list)
    flat: list[Any] = field(default_factory=list)
    guards: list[tuple[Variable, list[str], Whens]] = field(default_factory=list)

    def is_empty(self) -> bool:
        return not (self.links or self.joints or self.uses or self.elements or self.materials)

"""Resolve the texts of a xacro: their names become references to variables, or what they stand for.

Properties are evaluated when they are first read, as xacro does.
"""

from __future__ import annotations

import ast
import glob
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from keyword import iskeyword
from pathlib import Path
from typing import Any

from rosorin_compile.language.expression.functions import functions
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.xml.markup import Element

from .texts import EXPRESSION, EXTENSION, TEXT, Unsupported, source_tree, tokens
from .tree import (
    ARGUMENT,
    FOLDER,
    FREE,
    GLOBAL,
    LOCAL,
    PARAMETER,
    RAW,
    Bound,
    File,
    Joined,
    Piece,
    Place,
    Ref,
    Scope,
    Text,
    Variable,
    merged_pieces,
    note,
    place_of,
    ref,
    signed,
)

_MODULES = ("math", "python")
_BUILTIN = ("pi", "e", "tau", "inf", "nan", "True", "False", "None", "xacro", "__text", *_MODULES)
_READING = ("", Scope())  # in the place of the text of a property that is being read
MAX_CHOICES = 20


@dataclass
class Plan:
    """What a translation gives up: macros expanded inline, elements as xacro expands them, arguments with one value."""

    inlined: set[str] = field(default_factory=set)
    flat: set[Place] = field(default_factory=set)
    fixed: dict[str, str] = field(default_factory=dict)
    unwritable: dict[Place, str] = field(default_factory=dict)  # properties that cannot be written, and why
    explicit: set[str] = field(default_factory=set)  # macros whose names keep their prefix
    handed: dict[str, set[str]] = field(default_factory=dict)  # properties that macros take as parameters
    plain: set[str] = field(default_factory=set)  # macros, or "", whose lengths and masses are numbers
    printed: set[str] = field(default_factory=set)  # elements whose text is True or False
    texts: bool = False  # vectors in tables may be texts
    turns: bool = False  # angles may be more than a turn
    lacking: bool = False  # what a named value gives may be missing


class Names:
    """The names of a xacro and what they stand for: its arguments, and the variables of the environment that it reads.

    ``files`` are the paths of the files that were read, ``fixed`` arguments that have one value.
    """

    def __init__(self, plan: Plan, given: Mapping[str, str], packages: Packages, files: Mapping[str, File]) -> None:
        self.plan = plan
        self.given = given
        self.packages = packages
        self.files = files
        self.scope = Scope()
        self.arguments: dict[str, Variable] = {}
        self.environment: dict[str, str] = {}
        self.fixed: dict[str, str] = {}
        self.loaded: list[tuple[Path, str]] = []  # the files that an argument chooses from, by their folders
        self.argument_flows: list[tuple[Variable, Variable]] = []

    def declare(self, name: str, text: str | None, span: Span, file: File, given: bool = False) -> Variable | None:
        key = f"arg {name}"
        if name in self.plan.fixed:
            self.fixed[name] = self.plan.fixed[name]
            self.scope.names[key] = Bound(self.plan.fixed[name], self.scope)
            return None
        variable = self.arguments.get(name)
        if variable is None:
            variable = Variable(name, ARGUMENT, usable(name), span=span, file=None if given else file)
            self.arguments[name] = self.scope.names[key] = variable
        if text is not None and given:
            variable.values.append(plain_text(text))
        elif text is not None and not variable.raw:
            variable.raw = text
            variable.values.insert(0, self.resolve(text, self.scope, FREE, span))
            self.flows(variable.values[0], variable)
        if not given and variable.file is None:
            variable.file = file
        return variable

    def text_of(self, name: str) -> str | None:
        """Return the text of an argument: what it is given, or its default."""
        if name in self.given:
            return self.given[name]
        variable = self.arguments[name]
        return variable.values[0].plain if variable.values else None

    def environment_argument(self, kind: str, rest: str, span: Span | None) -> Piece:
        """Return the argument that stands for a variable of the environment."""
        name, _, default = rest.partition(" ")
        text = os.environ.get(name, default.strip())
        if self.environment.setdefault(name, text) != text:
            raise Unsupported(f"$({kind} {name}) has several defaults", span)
        if name in self.plan.fixed:
            self.fixed[name] = self.plan.fixed[name]
            return Piece(TEXT, self.plan.fixed[name])
        if name not in self.arguments:
            made = Variable(name, ARGUMENT, usable(name), [plain_text(text)], raw=text, span=span, file=None)
            self.arguments[name] = made
        return Piece(RAW, ref(self.arguments[name]))

    def value(self, element: Element, name: str, scope: Scope, sink: str) -> Text:
        """Return the resolved value of an attribute. Raises Unsupported if it is missing."""
        if name not in element.attributes:
            raise Unsupported(f"<{element.tag}> lacks the attribute {name}", element.span)
        made = self.resolve(element.get(name), scope, sink, element.attributes[name].span)
        note(made)
        return made

    def resolve(self, raw: str, scope: Scope, sink: str, span: Span | None = None) -> Text:
        """Return a text with its names resolved. Raises Unsupported."""
        try:
            pieces = [piece for token in tokens(raw) for piece in self._pieces(token, scope, span)]
        except Unsupported as problem:
            problem.span = problem.span or span
            raise
        except RecursionError:
            raise Unsupported("names lead to names without end", span) from None
        return Text(merged_pieces(pieces), sink, span)

    def _pieces(self, token: Any, scope: Scope, span: Span | None) -> list[Piece]:
        if token.kind == TEXT:
            return [Piece(TEXT, token.text)]
        if token.kind == EXPRESSION:
            name = token.text.strip()
            found = scope.find(name) if name.isidentifier() else None
            if isinstance(found, Bound):
                return _printed(self.bound(found, name))
            return [Piece(EXPRESSION, self.expression(token.text, scope))]
        kind, _, rest = token.text.strip().partition(" ")
        rest = rest.strip()
        if kind == "arg":
            found = scope.find(f"arg {rest}")
            if isinstance(found, Bound):
                return self.bound(found, rest).pieces
            return [Piece(RAW, self.reference(f"arg {rest}", scope))]
        if kind == "eval":
            return [Piece(EXPRESSION, self.expression(rest, scope))]
        if kind == "find":
            package = self.resolve(rest, scope, FREE)
            if package.plain is not None:
                return [Piece(FOLDER, package.plain.strip())]
            return [Piece(EXPRESSION, ast.Call(ast.Name("find", ast.Load()), [package.node()], []))]
        if kind in ("env", "optenv"):
            return [self.environment_argument(kind, rest, span)]
        raise Unsupported(f"$({token.text}) cannot be translated")

    def expression(self, text: str, scope: Scope) -> ast.expr:
        """Return an expression with its names resolved."""
        try:
            return _Visitor(self, scope).visit(source_tree(text))  # type: ignore[no-any-return]
        except ValueError as problem:
            raise Unsupported(f"${{{text}}}: {problem}") from None

    def reference(self, name: str, scope: Scope) -> ast.expr:
        """Return what a name refers to: a variable, or the expression that it is bound to."""
        found = scope.find(name)
        owner = scope.owner()
        is_handed = owner is not None and name in self.plan.handed.get(owner.name, ())
        if is_handed and isinstance(found, Variable) and found.where == GLOBAL:
            found = None
        if found is None and owner is not None and name.isidentifier() and name not in _BUILTIN:
            found = owner.scope.names[name] = owner.implicit[name] = Variable(name, PARAMETER)
        if isinstance(found, Bound):
            return self.bound(found, name).node()
        if isinstance(found, Variable):
            if found.span is not None and place_of(found.span) in self.plan.unwritable:
                raise Unsupported(self.plan.unwritable[place_of(found.span)], found.span)
            if owner is not None and not name.startswith("arg ") and found.where == GLOBAL:
                owner.reads.setdefault(name, found)
            self.read(found)
            found.is_read = True
            return ref(found)
        if name in ("pi", "e", "tau", "inf", "nan", "True", "False", "None"):
            return ast.Name(name, ast.Load())
        what = "argument" if name.startswith("arg ") else "name"
        raise Unsupported(f'the {what} "{name.removeprefix("arg ")}" is not defined where it is used')

    def bound(self, found: Bound, name: str) -> Text:
        """Return the text that a name is bound to; it is resolved when it is first read."""
        if found.text is None:
            if found.reading:
                raise Unsupported(f'the value of "{name}" depends on itself')
            found.reading = True
            try:
                found.text = self.resolve(found.raw, found.scope or self.scope, FREE)
            finally:
                found.reading = False
        return found.text

    def read(self, variable: Variable) -> None:
        """Resolve the value of a property that is read for the first time."""
        if variable.pending is None:
            return
        if variable.pending is _READING:
            raise Unsupported(f'the value of "{variable.name}" depends on itself', variable.span)
        pending = variable.pending
        variable.pending = _READING
        try:
            text = self.resolve(*pending, FREE, variable.span)
        except Unsupported:
            variable.pending = pending
            raise
        variable.pending = None
        variable.values.append(text)
        self.flows(text, variable)

    def flows(self, text: Text, variable: Variable) -> None:
        """Record that a text becomes the value of a variable: what is the same value is of one kind."""
        note(text)
        for found in sources_of(text):
            if found is variable:
                continue
            if ARGUMENT in (found.where, variable.where):
                self.argument_flows.append((found, variable))
            else:
                variable.join(found)

    def note_files(self, name: ast.expr) -> None:
        """Record the values of an argument for which there are files with the name of one that is loaded."""
        pieces = list(_parts_of_text(name))
        variables = list({one for one in pieces if isinstance(one, Variable)})
        if len(variables) != 1 or variables[0].where != ARGUMENT or len(pieces) < 2:
            return
        variable = variables[0]
        form = "".join(re.escape(one) if isinstance(one, str) else "([^/]*)" for one in pieces)
        pattern = "".join(glob.escape(one) if isinstance(one, str) else "*" for one in pieces)
        package, _, rest = form.removeprefix("package://").partition("/")
        folders = [str(Path(path).parent) for path in self.files]
        if form.startswith("package://"):
            folders, form = [str(self.packages.find(package) or "/no-package")], rest
            pattern = pattern.removeprefix("package://").partition("/")[2]
        for folder in folders:
            for one in matching_files(f"{glob.escape(folder)}/{pattern}")[:MAX_CHOICES]:
                match = re.fullmatch(f"{re.escape(folder)}/{form}", one)
                if match is not None and len(set(match.groups())) == 1 and match[1]:
                    variable.head().evidence.update(("compared", f"={match[1]}"))
                    self.loaded.append((Path(folder), os.path.relpath(one, folder)))


class _Visitor(ast.NodeTransformer):
    """Replaces the names of an expression by references to variables."""

    def __init__(self, names: Names, scope: Scope) -> None:
        self.names = names
        self.scope = scope
        self.loops: set[str] = set()

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if node.id in self.loops:
            return node
        if node.id.startswith("__arg_"):
            return self.names.reference(f"arg {node.id.removeprefix('__arg_')}", self.scope)
        return self.names.reference(node.id, self.scope)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        owner = node.value.id if isinstance(node.value, ast.Name) else ""
        if owner and owner not in self.loops and self.scope.find(owner) is None:
            if owner in _MODULES:
                return self.names.reference(node.attr, Scope())
            space = next((one.spaces[owner] for one in self.scope.around() if owner in one.spaces), None)
            if space is not None:
                return self.names.reference(node.attr, space)
        node.value = self.visit(node.value)
        return node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        function = node.func
        owner = function.value if isinstance(function, ast.Attribute) else None
        if isinstance(owner, ast.Name) and owner.id == "xacro":
            first = node.args[0] if node.args else None
            if function.attr == "arg" and isinstance(first, ast.Constant):  # type: ignore[attr-defined]
                return self.names.reference(f"arg {first.value!s}", self.scope)
        elif owner is not None and not (isinstance(owner, ast.Name) and owner.id in _MODULES):
            function.value = self.visit(owner)  # type: ignore[attr-defined]
        node.args = [self.visit(one) for one in node.args]
        if getattr(function, "id", getattr(function, "attr", "")) == "load_yaml" and node.args:
            self.names.note_files(node.args[0])
        for keyword in node.keywords:
            keyword.value = self.visit(keyword.value)
        return node

    def visit_ListComp(self, node: Any) -> ast.AST:
        outer = self.loops
        self.loops = set(outer)
        for generator in node.generators:
            generator.iter = self.visit(generator.iter)
            self.loops |= {one.id for one in ast.walk(generator.target) if isinstance(one, ast.Name)}
            generator.ifs = [self.visit(one) for one in generator.ifs]
        node.elt = self.visit(node.elt)
        self.loops = outer
        return node  # type: ignore[no-any-return]

    visit_GeneratorExp = visit_ListComp  # noqa: N815 - the name that ast asks for

    def visit_Lambda(self, node: ast.Lambda) -> ast.AST:
        raise Unsupported(f"{ast.unparse(node)[:60]} cannot be translated")


class Substitution(ast.NodeTransformer):
    """Replaces parameters by what a call gives, and properties of the macro by their values."""

    def __init__(self, given: Mapping[Variable, ast.expr]) -> None:
        self.given = given

    def visit_Ref(self, node: Ref) -> ast.AST:
        if node.variable in self.given:
            return self.given[node.variable]
        if node.variable.where == LOCAL:
            return self.visit(copied(node.variable.values[0].node()))  # type: ignore[no-any-return]
        if node.variable.where == PARAMETER:
            raise Unsupported("it depends on what it is given")
        return node


def copied(node: Any) -> Any:
    """Return a copy of a resolved node that refers to the same variables."""
    if isinstance(node, Ref):
        return ref(node.variable)
    if isinstance(node, Joined):
        raise Unsupported("a text that is put together")
    if isinstance(node, list):
        return [copied(item) for item in node]
    if not isinstance(node, ast.AST):
        return node
    return type(node)(**{name: copied(getattr(node, name, None)) for name in node._fields})


def _printed(text: Text) -> list[Piece]:
    """Return the pieces of a bound text as ``${name}`` prints them."""
    plain = text.plain
    if plain is not None:
        if len(plain) > 1 and plain[0] == "'" == plain[-1]:
            return [Piece(TEXT, plain[1:-1])]
        return [Piece(TEXT, plain.capitalize() if plain in ("true", "false") else plain)]
    if len(text.pieces) == 1 and text.pieces[0].kind == RAW:
        return [Piece(EXPRESSION, text.pieces[0].value)]
    return text.pieces


def plain_text(text: str) -> Text:
    """Return a text in which nothing is evaluated."""
    return Text([Piece(TEXT, text)])


def names_in(raw: str) -> set[str]:
    """Return the names in a text that are none of Python's or of xacro's."""
    found: set[str] = set()
    for token in tokens(raw):
        if token.kind not in (EXPRESSION, EXTENSION):
            continue
        try:
            tree = source_tree(token.text if token.kind == EXPRESSION else f"$({token.text})")
        except ValueError:
            continue
        for one in ast.walk(tree):
            name = getattr(one, "id", "")
            if name.startswith("__arg_"):
                found.add(f"arg {name.removeprefix('__arg_')}")
            elif name and name not in _BUILTIN and name not in functions() and name not in ("load_yaml", "dict"):
                found.add(name)
    return found


def sources_of(text: Text) -> list[Variable]:
    """Return the variables that a text may be as it is, also by a choice or with a sign."""
    parts = signed_piece(text.pieces)
    waiting, found = [parts] if parts is not None else [], []
    while waiting:
        node = waiting.pop()
        if isinstance(node, Ref):
            found.append(node.variable)
        elif isinstance(node, ast.IfExp):
            waiting += [node.body, node.orelse]
    return found


def signed_piece(pieces: list[Piece]) -> Any:
    """Return what a text is, apart from a sign; None for several pieces."""
    parts = signed(pieces)
    return parts[1].value if parts is not None else pieces[0].value if len(pieces) == 1 else None


def _parts_of_text(node: ast.expr) -> Iterator[str | Variable]:
    """Yield the plain texts and the variables that a text is put together from; an empty text for others."""
    called = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
    if isinstance(node, Ref):
        yield node.variable
    elif isinstance(node, ast.Constant):
        yield str(node.value)
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        yield from (*_parts_of_text(node.left), *_parts_of_text(node.right))
    elif called in ("__text", "str"):
        yield from _parts_of_text(node.args[0])  # type: ignore[attr-defined]
    elif isinstance(node, Joined):
        for piece in node.pieces:
            if piece.kind in (TEXT, FOLDER):
                yield piece.value if piece.kind == TEXT else f"package://{piece.value}"
            else:
                yield from _parts_of_text(piece.value)


def matching_files(pattern: str) -> list[str]:
    """Return the files that match a pattern, in the order of their names; all that is listed is recorded."""
    *folders, last = pattern.split("/")
    found = [""]
    for part in folders:
        found = [f"{one}{name}/" for one in found for name in _listed(one, part, True)]
    return sorted(f"{one}{name}" for one in found for name in _listed(one, last, False))


def _listed(folder: str, part: str, only_folders: bool) -> list[str]:
    if not glob.has_magic(part):
        plain = re.sub(r"\[(.)\]", r"\1", part)
        return [plain] if only_folders or os.path.lexists(f"{folder}{plain}") else []
    try:
        inside = sorted(Path(folder or ".").iterdir())
    except OSError:
        return []
    fits = (one for one in inside if fnmatchcase(one.name, part) and (part[0] == "." or one.name[0] != "."))
    return [one.name for one in fits if not only_folders or files.is_folder(one)]


def usable(name: str, taken: Sequence[str] | set[str] = ()) -> str:
    """Return a name that expressions can have: no word of Python or of the language, and not taken."""
    made = re.sub(r"\W", "_", name, flags=re.ASCII) or "value"
    made = f"_{made}" if made[0].isdigit() else made
    if iskeyword(made) or made in ("true", "false", "none", "for"):
        made = f"{made}_"
    number, first = 1, made
    while made in taken:
        number += 1
        made = f"{first}_{number}"
    return made

"""Build the intermediate representation of a xacro: one pass over its files, in the order in which xacro runs them.

The pass runs the xacro with symbols for its arguments and for the parameters of macros. A macro is read once, as a part
(among links and joints), a named value (in a link or a joint) or a named text (in elements that are kept); one that is
in ``Plan.inlined`` is expanded where it is called. A condition that the arguments decide is recorded; properties that
are set on it are a choice from there on.
"""

from __future__ import annotations

import ast
import glob
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import COMMENT, Element, MarkupError, Remark, parse, read_source

from .elements import joint_entry, read_entry, read_found, set_dimensions
from .expressions import folded_text
from .resolve import MAX_CHOICES, Names, Plan, Substitution, copied, matching_files, names_in, usable
from .source import comments_within, flat_entries, with_comments
from .texts import EXPRESSION, TEXT, Unsupported, parameters
from .tree import (
    ARGUMENT,
    CONDITION,
    FILE,
    FREE,
    GLOBAL,
    LOADED,
    LOCAL,
    NAME,
    PARAMETER,
    RAW,
    XML,
    Body,
    Bound,
    Call,
    Entry,
    File,
    Handed,
    Listed,
    Macro,
    Named,
    Piece,
    Place,
    Ref,
    Scope,
    Text,
    Variable,
    When,
    Whens,
    Xml,
    note,
    place_of,
    ref,
    references,
    references_in,
)

MAX_DEPTH = 50
_FLAG = ast.Name("__flag", ast.Load())
_WORD = re.compile(r"[A-Za-z_]\w*")
_REFERENCE = re.compile(r"\$\(arg (\w+)\)|\$\{(\w+)\}")
_CALLED = re.compile(r"<xacro:([\w.]+)")


class GiveUp(Exception):
    """A macro, an element or a property that cannot be translated; an argument that has to keep its value."""

    def __init__(self, subject: Macro | Element | Variable, problem: Unsupported) -> None:
        super().__init__(problem.reason)
        self.subject = subject
        self.problem = problem


class Changes(Exception):
    """Properties that a macro reads, and that are others where it is called again: it takes them as parameters."""

    def __init__(self, macro: Macro, names: set[str]) -> None:
        super().__init__(macro.name)
        self.macro = macro
        self.names = names


class Found(NamedTuple):
    """What ``flow`` finds: an element, the call of a named value or text, a block, or text and comments."""

    item: Any
    scope: Scope
    when: Whens
    comments: tuple[str, ...]
    body: Body


class Program:
    """A xacro with all that it includes, as files with bodies, macros and arguments."""

    def __init__(
        self, path: Path, packages: Mapping[str, Path], given: Mapping[str, str], plan: Plan, trees: Sequence[Map] = ()
    ) -> None:
        self.files: dict[str, File] = {}
        self.packages = Packages(packages, os.environ, path)
        self.plan = plan
        self.names = Names(plan, given, self.packages, self.files)
        self.scope = self.names.scope
        self.macros: dict[int, Macro] = {}
        self.kept: list[Macro] = []  # macros that are parts or values, in the order of their calls
        self.reached: dict[Place, set[Variable]] = {}  # what may decide elements that are flat
        self.lost: dict[str, Unsupported] = {}  # macros that could be no value, and why
        self._journal: list[tuple[Scope, str, Variable | Bound | None]] = []
        self._taken: set[tuple[int, str]] = set()
        self._defaults: dict[tuple[int, str], Text] = {}
        self._open: list[Macro] = []
        self.globals: list[Variable] = []
        self._depth = 0
        self._only_materials = False
        self._including: list[str] = []
        self.root = self._file(path)
        body = self.scope.body = self.root.body
        for name, text in given.items():
            if name not in plan.fixed:
                self.names.declare(name, text, self.root.document.root.span, self.root, given=True)
        for found in self.flow(self.root.document.root, self.scope, (), "robot", body):
            self.take(found)
        for place in sorted(plan.flat):
            body.flat += flat_entries(trees, place)
        self.settle()

    # Files and arguments.

    def _file(self, path: Path) -> File:
        """Return a file, read. Raises MarkupError, OSError."""
        key = os.path.abspath(path)
        if key not in self.files:
            document = parse(read_source(path))
            self.files[key] = File(key, document, self._free_name(path) if self.files else "robot.yaml")
            self.files[key].body = Body(self.files[key])
        return self.files[key]

    def _free_name(self, path: Path) -> str:
        """Return the name of a file in the description: that of the xacro, in its folder next to the first."""
        first, here = Path(next(iter(self.files))), Path(os.path.abspath(path))
        stem = re.sub(r"[^\w.-]+", "_", re.sub(r"(\.urdf)?\.xacro$|\.urdf$|\.xml$", "", here.name)).strip(".")
        folder = ""
        if here.is_relative_to(first.parent) and here.parent != first.parent:
            folder = f"{here.parent.relative_to(first.parent).as_posix()}/"
        stem = "robot_parts" if f"{folder}{stem}" == "robot" else stem or "part"
        taken, name, number = {file.name for file in self.files.values()}, f"{folder}{stem}.yaml", 1
        while name in taken:
            number += 1
            name = f"{folder}{stem}_{number}.yaml"
        return name

    # Conditions.

    def condition(self, element: Element, scope: Scope) -> When | bool:
        """Return the condition of an element, or whether it holds if that depends on nothing."""
        holds = element.tag == "xacro:if"
        test = self.names.resolve(element.get("value"), scope, CONDITION, element.span)
        decided = folded_text(test)
        if decided is not None:
            return decided == holds
        note(test)
        return When(test, holds)

    def bind(self, scope: Scope, name: str, value: Variable | Bound) -> None:
        """Bind a name; what was bound before is restored by ``_merge`` where that was on a condition."""
        self._journal.append((scope, name, scope.find(name)))
        scope.names[name] = value

    def _merge(self, mark: int, on: When) -> None:
        """Make the names that were bound on a condition choices between their values."""
        before: dict[tuple[int, str], tuple[Scope, str, Variable | Bound | None]] = {}
        for scope, name, old in self._journal[mark:]:
            before.setdefault((id(scope), name), (scope, name, old))
        for scope, name, old in before.values():
            new = scope.names.get(name)
            if old is None or new is None or old is new:  # what is not set otherwise cannot be read then
                continue
            scope.names[name] = self._choice(name, on, new, old, scope)

    def _choice(
        self, name: str, on: When, new: Variable | Bound, old: Variable | Bound, scope: Scope
    ) -> Variable | Bound:
        test: ast.expr = ast.Call(_FLAG, [on.test.node()], [])
        nodes = [self._inlined(binding, name, ast.dump(test)) for binding in (new, old)]
        then, other = nodes if on.holds else nodes[::-1]
        for side in (then, other):  # <xacro:if> and <xacro:unless> of one condition
            if isinstance(side, ast.IfExp) and ast.dump(side.test) == ast.dump(test):
                then, other = (side.body if side is then else then), (side.orelse if side is other else other)
        if ast.dump(then) == ast.dump(other):
            return new
        text = Text([Piece(EXPRESSION, ast.IfExp(test, then, other))])
        note(Text([Piece(EXPRESSION, test)], CONDITION))
        for node in (then, other):
            for variable in references_in(node):
                self.names.read(variable)
        if scope.body is None:
            return Bound("", text=text)
        made = self._variable(name, scope, _file_of(new, old) or scope.body.file, getattr(new, "span", None))
        made.comments = next((one.comments for one in (old, new) if isinstance(one, Variable)), ())
        made.values.append(text)
        self.names.flows(text, made)
        return made

    def _inlined(self, binding: Variable | Bound, name: str, test: str) -> ast.expr:
        """Return a binding as a node: as its value if nothing else reads it, or if that is a constant."""
        if isinstance(binding, Bound):
            return self.names.bound(binding, name).node()
        self.names.read(binding)
        node = binding.values[0].node() if binding.where in (GLOBAL, LOCAL) and binding.values else None
        is_choice = isinstance(node, ast.IfExp) and ast.dump(node.test) == test
        is_constant = isinstance(node, ast.Constant) or (isinstance(node, ast.List) and hasattr(node, "text"))
        fits = is_choice or is_constant or not binding.is_read
        return node if node is not None and fits else ref(binding)

    # The order of xacro.

    def flow(
        self, element: Element, scope: Scope, when: Whens, level: str, body: Body, above: tuple[str, ...] = ()
    ) -> Iterator[Found]:
        """Yield what an element holds at a level, with the elements of xacro in it executed."""
        if level == "xml":
            for item in element.content:
                if isinstance(item, Element):
                    yield from self.step(item, scope, when, level, body, ())
                else:
                    yield Found(item, scope, when, (), body)
            return
        for child, comments in with_comments(element):
            yield from self.step(child, scope, when, level, body, (*above, *comments))
            above = ()

    def step(
        self, child: Element, scope: Scope, when: Whens, level: str, body: Body, comments: tuple[str, ...]
    ) -> Iterator[Found]:
        """Execute one element."""
        tag = child.tag
        if not tag.startswith("xacro:"):
            yield Found(child, scope, when, comments, body)
        elif level == "robot" and place_of(child.span) in self.plan.flat:
            self._reach(child, scope, when)
        elif tag in ("xacro:if", "xacro:unless"):
            on = self.condition(child, scope)
            if on is True:
                yield from self.flow(child, scope, when, level, body, comments)
            elif isinstance(on, When):
                mark = len(self._journal)
                yield from self.flow(child, scope, (*when, on), level, body, comments if level == "robot" else ())
                self._merge(mark, on)
        elif tag == "xacro:property":
            self._property(child, scope, body, comments)
        elif tag == "xacro:macro":
            self._define(child, scope, when, body, comments)
        elif tag == "xacro:arg":
            text = child.get("default") if "default" in child.attributes else None
            variable = self.names.declare(child.get("name"), text, child.span, body.file)
            if variable is not None and comments:
                variable.comments = variable.comments or comments
        elif tag == "xacro:insert_block":
            yield from self._insert(child, scope, when, level, body)
        else:
            yield from self._element_of_xacro(child, scope, when, level, body, comments)

    def _element_of_xacro(
        self, child: Element, scope: Scope, when: Whens, level: str, body: Body, comments: tuple[str, ...]
    ) -> Iterator[Found]:
        """Execute an include or a call."""
        try:
            if child.tag == "xacro:include":
                if level != "robot":
                    raise Unsupported(f"a file is included in <{level}>", child.span)
                yield from self._include(child, scope, when, body)
                return
            for macro, on in self._targets(child, scope):
                mark = len(self._journal)
                yield from self._call(macro, child, scope, (*when, *on), level, body, comments)
                for one in on:
                    self._merge(mark, one)
        except Unsupported as problem:
            if level == "robot":
                raise GiveUp(child, problem) from None
            raise

    # Includes.

    def _include(self, element: Element, scope: Scope, when: Whens, body: Body) -> Iterator[Found]:
        text = self.names.resolve(element.get("filename"), scope, FILE, element.span)
        base = Path(element.document.source.path).parent
        open_pieces = [piece for piece in text.pieces if piece.kind in (RAW, EXPRESSION)]
        if not open_pieces:
            path = self._path("".join(self._folder(piece) for piece in text.pieces), base)
            for file in matching_files(str(path)) if re.search(r"[*?[]", str(path)) else [str(path)]:
                yield from self._run(Path(file), element, scope, when, body)
            return
        problem = Unsupported(f'what is included is named by it: "{element.get("filename")}"', element.span)
        pattern, form = "", ""
        names: dict[str, Variable] = {}
        for piece in text.pieces:
            if piece not in open_pieces:
                plain = self._folder(piece)
                pattern, form = pattern + glob.escape(plain), form + re.escape(plain)
                continue
            variable = piece.value.variable if isinstance(piece.value, Ref) else None
            if variable is None or variable.where != ARGUMENT:
                for argument in references_in(piece.value):
                    if argument.where == ARGUMENT:
                        raise GiveUp(argument, problem)
                raise Unsupported(f'the file "{element.get("filename")}" is chosen by an expression', element.span)
            form += f"(?P=v{id(variable)})" if variable.name in names else f"(?P<v{id(variable)}>[^/]*)"
            pattern, names[variable.name] = pattern + "*", variable
        base_text = "" if pattern.startswith("/") else f"{os.path.abspath(base)}/"
        fitting = matching_files(glob.escape(base_text) + pattern) if re.search(r"\w", pattern) else []
        if not re.search(r"\w", pattern) or (len(names) > 1 and not 0 < len(fitting) <= MAX_CHOICES):
            raise GiveUp(next(iter(names.values())), problem)
        known: dict[str, list[str]] = {name: [] for name in names}
        for path_text in fitting[:MAX_CHOICES]:
            match = re.fullmatch(re.escape(base_text) + form, path_text)
            if match is None or not all(match.groupdict().values()) or not files.is_file(path_text):
                continue
            on: Whens = ()
            for name, variable in names.items():
                said = match[f"v{id(variable)}"]
                known[name] += [said] if said not in known[name] else []
                quoted = ast.Call(ast.Name("__text", ast.Load()), [ref(variable)], [])
                test = ast.Compare(quoted, [ast.Eq()], [ast.Constant(said)])
                on = (*on, When(Text([Piece(EXPRESSION, test)], CONDITION, element.span), True))
                note(on[-1].test)
            mark = len(self._journal)
            yield from self._run(Path(path_text), element, scope, (*when, *on), body)
            for condition in on:
                self._merge(mark, condition)
        body.guards += [(variable, known[name], when) for name, variable in names.items()]

    def _folder(self, piece: Piece) -> str:
        return piece.value if piece.kind == TEXT else str(self.packages.find(piece.value) or "/no-package")

    def _path(self, name: str, base: Path) -> Path:
        if "://" in name:
            return self.packages.resolve(name, Path()) or Path("/no-package")
        return Path(os.path.normpath(base / name))

    def _run(self, path: Path, element: Element, scope: Scope, when: Whens, body: Body) -> Iterator[Found]:
        """Execute an included file; one that cannot be read is passed over, as xacro has come without it."""
        key = os.path.abspath(path)
        if key in self._including or len(self._including) > MAX_DEPTH:
            raise Unsupported(f"{path.name} includes itself", element.span)
        try:
            file = self._file(path)
        except (MarkupError, OSError):
            return
        inner = scope
        if element.get("ns"):
            inner = Scope(scope)
            inner.space, inner.body = inner, scope.body
            scope.space.spaces[element.get("ns")] = inner
        self._including.append(key)
        yield from self.flow(file.document.root, inner, when, "robot", file.body if body.macro is None else body)
        self._including.pop()

    # Properties.

    def _property(self, element: Element, scope: Scope, body: Body, comments: tuple[str, ...]) -> None:
        name = self.names.resolve(element.get("name"), scope, FREE, element.span).plain
        if name is None or element.get("remove") in ("true", "True", "1"):
            raise Unsupported(
                f'the property "{element.get("name")}" is named by an expression, or removed', element.span
            )
        target = scope
        if element.get("scope") == "global":
            target = self.scope
        elif element.get("scope") == "parent" and scope.parent is not None:
            target = scope.parent
        if target is not scope and scope.macro is not None:
            if scope.body is None or element.get("scope") == "global":
                raise Unsupported("it sets properties of whoever calls it", element.span)
            scope.macro.sets[name] = None  # it reads it, too
            target = scope
        is_default = "default" in element.attributes
        if not is_default and "value" not in element.attributes:
            target.blocks[name] = (element, scope)
            return
        if is_default and scope.find(name) is not None:
            return
        raw = element.get("default" if is_default else "value")
        old = target.names.get(name)
        if isinstance(old, Variable) and old.raw == raw and old.where in (GLOBAL, LOCAL) and not names_in(raw):
            return
        alias = self._argument_of(raw, scope)
        eager = element.get("lazy_eval") == "false" or (name in names_in(raw) and scope.find(name) is not None)
        text = self.names.resolve(raw, scope, FREE, element.span) if eager else None
        if alias is not None:
            self.bind(target, name, alias)
        elif target.body is None:
            self.bind(target, name, Bound(raw, scope, text))
        else:
            made = self._variable(name, target, body.file, element.span)
            made.raw, made.comments = raw, comments
            if text is not None:
                made.values.append(text)
                self.names.flows(text, made)
            else:
                made.pending = (raw, scope)
            self.bind(target, name, made)

    def _argument_of(self, raw: str, scope: Scope) -> Variable | None:
        """Return the argument that a text is, and nothing else."""
        if not raw.startswith("$"):
            return None
        try:
            found = self.names.resolve(raw, scope, FREE).variable()
        except Unsupported:
            return None
        return found if found is not None and found.where == ARGUMENT else None

    def _variable(self, name: str, scope: Scope, file: File, span: Span | None) -> Variable:
        """Return a new property of a file or a part."""
        body = scope.body
        space = next((key for key, one in self.scope.spaces.items() if one is scope.space), "")
        made = Variable(name, LOCAL, usable(f"{space}_{name}".lstrip("_") if space else name), span=span, file=file)
        if body is None or body.macro is None:
            made.where = GLOBAL
            self.globals.append(made)
        else:
            body.locals.append(made)
        return made

    def settle(self) -> None:
        """Finish the evidence of kinds: arguments have that of what they are handed to."""
        order = list(self.files)
        self.kept.sort(key=lambda macro: (order.index(macro.file.path), macro.element.start))
        for (key, name), text in self._defaults.items():
            text.idle = (key, name) not in self._taken
        everything = [*self.names.arguments.values(), *self.globals]
        while folders := {
            one for variable in everything if LOADED in variable.head().evidence for one in _folders(variable)
        }:
            for variable in folders:
                variable.head().evidence.add(LOADED)
        changed = True
        while changed:
            changed = False
            for argument, variable in self.names.argument_flows:
                more = variable.head().evidence - argument.head().evidence
                argument.head().evidence |= more
                changed = changed or bool(more)
        loaded = [one for one in everything if LOADED in one.head().evidence]
        loaded += [one for macro in self.kept for one in macro.variables.values() if LOADED in one.head().evidence]
        for text in [text for variable in loaded for text in variable.head().values if text.plain is None]:
            self.names.note_files(text.node())
        for argument, variable in self.names.argument_flows:  # what it is given is of the kind of the argument
            values = [one for one in variable.head().values if not one.idle]
            if variable.where != ARGUMENT and not any(one.plain is not None for one in values):
                variable.head().values += [one for one in argument.values if one.plain is not None]

    # Macros.

    def _define(self, element: Element, scope: Scope, when: Whens, body: Body, comments: tuple[str, ...]) -> None:
        name = element.get("name").removeprefix("xacro:")
        macro = self.macros.get(id(element))
        if macro is None:
            space = next((key for key, one in self.scope.spaces.items() if one is scope.space), "")
            called = f"{space}.{name}".strip(".")
            taken = {one.name: one for one in self.macros.values()}
            number, unique = 1, called
            while unique in taken and taken[unique].element.verbatim != element.verbatim:
                number += 1
                unique = f"{called}_{number}"
            file = next((one for one in self.files.values() if one.document is element.document), body.file)
            made = Macro(unique, element, file, parameters(element.get("params")), scope.space, comments)
            macro = self.macros[id(element)] = taken.get(unique, made)
        table = scope.space.macros
        known = [one for one in table.get(name, []) if one[0] is not macro and not set(when) <= set(one[1])]
        table[name] = [*known, (macro, when)]

    def macros_named(self, name: str, scope: Scope) -> list[tuple[Macro, Whens]]:
        """Return the macros that a name may stand for, each with its conditions."""
        *spaces, last = name.split(".")
        for here in scope.around():
            if here.space is not here and here.parent is not None:
                continue
            for space in spaces:
                here = here.spaces.get(space, Scope())
            if last in here.macros:
                return here.macros[last]
        return []

    def _targets(self, element: Element, scope: Scope) -> Iterator[tuple[Macro, Whens]]:
        """Yield the macros that a call may mean, each with the conditions on which it does."""
        name = element.tag.removeprefix("xacro:")
        if name in ("element", "attribute"):
            raise Unsupported(f"xacro:{name} makes what an expression names", element.span)
        if name == "call":
            text = self.names.resolve(element.get("macro"), scope, FREE, element.span)
            if text.plain is None:
                yield from self._by_expression(text, element)
                return
            name = text.plain
        known = self.macros_named(name, scope)
        if not known:
            raise Unsupported(f'there is no macro "{name}"', element.span)
        if len(known) == 1:
            yield known[0][0], ()
            return
        for index, (macro, when) in enumerate(known):
            later = [one for _, one in known[index + 1 :]]
            if not when and any(len(one) != 1 for one in later):
                raise Unsupported("a macro is defined again on several conditions", element.span)
            yield macro, (*when, *(When(one[0].test, not one[0].holds) for one in later if not when))

    def _by_expression(self, text: Text, element: Element) -> Iterator[tuple[Macro, Whens]]:
        pattern = "".join(piece.value if piece.kind == TEXT else "*" for piece in text.pieces)
        given, found = element.attributes.keys() - {"macro"}, False
        for macro in list(dict.fromkeys(self.macros.values())):
            required = {
                one.name for one in macro.parameters if not one.block and one.default is None and not one.forward
            }
            fits = required <= given <= {one.name for one in macro.parameters}
            if not fits or not fnmatchcase(macro.name, pattern):
                continue
            test = Text([Piece(EXPRESSION, _equals(text, macro.name))], CONDITION, element.span)
            holds = folded_text(test)
            if holds is False:
                continue
            found = True
            note(test)
            yield macro, () if holds else (When(test, True),)
            if holds:
                return
        if not found:
            raise Unsupported(f'the macro "{element.get("macro")}" is called by an expression', element.span)

    def _call(
        self,
        macro: Macro,
        element: Element,
        scope: Scope,
        when: Whens,
        level: str,
        body: Body,
        comments: tuple[str, ...],
    ) -> Iterator[Found]:
        """Execute a call: of a part, of a value, or of a macro that is expanded inline."""
        macro.called = True
        is_inline = macro.name in self.plan.inlined or self.only_sets(macro) or self._only_materials
        if not is_inline:
            if level == "robot" and self._as_part(macro) and self._reads_the_same(macro, scope):
                body.uses.append(self._handed(macro, element, scope, when, comments))
                macro.uses.append(body.uses[-1])
                if macro.makes_materials and body.macro is not None:
                    body.macro.makes_materials = True
                elif macro.makes_materials:
                    self._only_materials = True
                    yield from self._expand(macro, element, scope, when, level, body)
                    self._only_materials = False
                self._tell(body.uses[-1], scope)
                return
            if level != "robot" and self._as_value(macro, level) and self._reads_the_same(macro, scope):
                yield Found(self._handed(macro, element, scope), scope, when, comments, body)
                return
        yield from self._expand(macro, element, scope, when, level, body)

    def only_sets(self, macro: Macro, depth: int = 0) -> bool:
        """Return True if a macro does nothing but set properties: it is executed where it is called."""

        def sets(element: Element) -> bool:
            for child in element.children:
                name = child.tag.removeprefix("xacro:")
                if child.tag in ("xacro:if", "xacro:unless"):
                    if not sets(child):
                        return False
                elif child.tag != "xacro:property":
                    found = self.macros_named(name, macro.space) if name != child.tag and depth < MAX_DEPTH else []
                    if not found or not all(self.only_sets(one, depth + 1) for one, _ in found):
                        return False
            return bool(element.children)

        return sets(macro.element)

    def _expand(
        self, macro: Macro, element: Element, scope: Scope, when: Whens, level: str, body: Body
    ) -> Iterator[Found]:
        """Execute a macro where it is called."""
        if self._depth > MAX_DEPTH:
            raise Unsupported(f'the macro "{macro.name}" calls itself', element.span)
        inner = Scope(scope if macro.space is scope.space else macro.space)
        inner.space = macro.space
        for name, text in self._given(macro, element, scope, inline=True).items():
            inner.names[name] = Bound("", text=text)
        for name, block in self._blocks(macro, element, scope).items():
            inner.blocks[name] = block
        self._depth += 1
        yield from self.flow(macro.element, inner, when, level, body)
        self._depth -= 1

    def _reads_the_same(self, macro: Macro, scope: Scope) -> bool:
        """Return True if the names that a macro reads from outside stand for the same here. Raises Changes."""
        changed = {name for name, value in macro.reads.items() if scope.find(name) is not value}
        if changed - self.plan.handed.get(macro.name, set()):
            raise Changes(macro, changed)
        return not changed

    def _begin(self, macro: Macro, level: str) -> None:
        macro.level = level
        macro.scope = Scope(macro.space, macro)
        for parameter in macro.parameters:
            if parameter.block:
                macro.scope.blocks[parameter.name] = Handed(macro, parameter.name)
                continue
            pinned = self._pinned(macro.element, parameter.name)
            if pinned is not None:
                macro.scope.names[parameter.name] = Bound(pinned, self.scope)
                macro.pinned.add(parameter.name)
                continue
            ours = usable(parameter.name)
            if ours in self.names.arguments and f"$(arg {ours})" in macro.element.verbatim:
                ours = f"{ours}_2"  # it reads the argument of that name, too
            made = Variable(parameter.name, PARAMETER, ours, span=macro.element.span)
            if parameter.default is not None and all(macro.space.find(one) for one in names_in(parameter.default)):
                default = self.names.resolve(parameter.default, macro.space, FREE, macro.element.span)
                macro.defaults[parameter.name] = self._defaults[id(macro), parameter.name] = default
                made.values.append(default)
                self.names.flows(default, made)
            macro.variables[parameter.name] = macro.scope.names[parameter.name] = made

    def _pinned(self, macro: Element, name: str, depth: int = 0) -> str | None:
        """Return the value of a parameter for which all calls give the same argument, which is fixed."""
        tag = f"xacro:{macro.get('name').removeprefix('xacro:')}"
        found: set[str | None] = set()
        for file in self.files.values() if self.plan.fixed and depth < MAX_CHOICES else ():
            for call in (one for one in file.document.root.iter() if one.tag == tag):
                match = _REFERENCE.fullmatch(call.get(name))
                around = _macro_around(call)
                if match is None or (match[2] and around is None):
                    return None
                found.add(self.plan.fixed.get(match[1]) if match[1] else self._pinned(around, match[2], depth + 1))  # type: ignore
        return found.pop() if len(found) == 1 else None

    def _as_part(self, macro: Macro) -> bool:
        """Read a macro as a part. Raises GiveUp."""
        if macro.level:
            if macro.body is not None and macro in self._open:
                raise GiveUp(macro, Unsupported("it calls itself", macro.element.span))
            return macro.body is not None
        self._begin(macro, "robot")
        macro.body = macro.scope.body = Body(macro.file, macro)
        self.kept.append(macro)
        self._open.append(macro)
        try:
            for found in self.flow(macro.element, macro.scope, (), "robot", macro.body):
                self.take(found)
        except GiveUp as stop:
            if isinstance(stop.subject, Element) and stop.subject.tag.startswith("xacro:"):
                raise GiveUp(macro, stop.problem) from None
            raise
        except Unsupported as problem:
            raise GiveUp(macro, problem) from None
        self._open.pop()
        for name in macro.sets:
            macro.sets[name] = macro.scope.names.get(name)
        return True

    def _tell(self, call: Call, scope: Scope) -> None:
        """Bind the properties that a part sets for its caller."""
        given: dict[Variable, ast.expr] = {}
        for name, variable in (*call.macro.variables.items(), *call.macro.implicit.items()):
            text = call.given.get(name) or call.macro.defaults.get(name)
            if text is not None:
                given[variable] = text.node()
        for name, binding in call.macro.sets.items():
            try:
                node = self._reference_of(binding, name)
                text = Text([Piece(EXPRESSION, Substitution(given).visit(copied(node)))])
            except Unsupported:
                continue
            if scope.body is None:
                self.bind(scope, name, Bound("", text=text))
                continue
            made = self._variable(name, scope, scope.body.file, call.element.span)
            made.values.append(text)
            self.names.flows(text, made)
            self.bind(scope, name, made)

    def _reference_of(self, binding: Variable | Bound | None, name: str) -> ast.expr:
        if isinstance(binding, Variable):
            self.names.read(binding)
            return ref(binding)
        if binding is None:
            raise Unsupported(f'"{name}" is not set')
        return self.names.bound(binding, name).node()

    def _as_value(self, macro: Macro, level: str) -> bool:
        """Read a macro as a named value of a level, or a named text; return False if it can be none."""
        if macro.level:
            return macro.level == level and (macro.entry is not None or macro.text is not None)
        self._begin(macro, level)
        kept = len(self.kept)
        self._open.append(macro)
        try:
            if level == "xml":
                content = self.xml_content(self.flow(macro.element, macro.scope, (), "xml", Body(macro.file)))
                is_value = not macro.block_levels and any(
                    isinstance(one, (Xml, Call)) and not getattr(one, "when", ()) for one in content
                )
                if is_value and all(not isinstance(one, Xml) or one.tag for one in content):
                    macro.text = content
            else:
                entry = read_entry(self, macro.element, macro.scope, level, Body(macro.file))
                if level == "joint":
                    set_dimensions(entry, "", False)
                if entry.items and not any(item.key == "&" for item in entry.items):
                    macro.entry = entry
        except Unsupported as problem:
            self.lost[macro.name] = problem
        self._open.pop()
        if macro.entry is None and macro.text is None:
            del self.kept[kept:]
            return False
        self.kept.append(macro)
        return True

    def _handed(
        self, macro: Macro, element: Element, scope: Scope, when: Whens = (), comments: tuple[str, ...] = ()
    ) -> Call:
        """Return a call of a part or a value, with what it gives."""
        given = self._given(macro, element, scope)
        given = {name: text for name, text in given.items() if name not in macro.pinned}
        for name, text in given.items():
            variable = macro.variables[name] if name in macro.variables else macro.implicit[name]
            variable.head().values.append(text)
            self.names.flows(text, variable)
        made = Call(macro, given, {}, element, when, comments)
        for name, block in self._blocks(macro, element, scope).items():
            made.blocks[name] = self._block_entry(macro, name, block)
        return made

    def _given(self, macro: Macro, element: Element, scope: Scope, inline: bool = False) -> dict[str, Text]:
        """Return what a call gives for the parameters of a macro; what it leaves to their defaults is not there."""
        made: dict[str, Text] = {}
        known = {parameter.name for parameter in macro.parameters}
        for name, attribute in element.attributes.items():
            if (name == "macro" and element.tag == "xacro:call") or name.startswith("xmlns"):
                continue
            if name not in known:
                raise Unsupported(f'the macro "{macro.name}" has no parameter {name}', attribute.span)
            made[name] = self.names.resolve(attribute.value, scope, FREE, attribute.span)
        for parameter in macro.parameters:
            name, default = parameter.name, parameter.default
            if parameter.block or name in made:
                continue
            if parameter.forward and (
                scope.find(name) is not None or default is None or self._is_of_callers(name, scope)
            ):
                made[name] = Text([Piece(EXPRESSION, self.names.reference(name, scope))], FREE, element.span)
            elif name in macro.defaults and not inline:
                self._taken.add((id(macro), name))
            elif default is not None:
                made[name] = self.names.resolve(default, scope, FREE, element.span)
            else:
                raise Unsupported(f'the macro "{macro.name}" needs the parameter {name}', element.span)
        for name in macro.implicit if not inline else ():
            made[name] = Text([Piece(EXPRESSION, self.names.reference(name, scope))], FREE, element.span)
        return made

    def _is_of_callers(self, name: str, scope: Scope) -> bool:
        """Return True if all macros that call the macro of a scope have a parameter of a name."""
        owner = scope.owner()
        if owner is None or owner.body is None:
            return False
        tag = f"xacro:{owner.element.get('name').removeprefix('xacro:')}"
        every = (one for file in self.files.values() for one in file.document.root.iter() if one.tag == tag)
        around = [_macro_around(one) for one in every]
        return bool(around) and all(
            one is not None and name in {parameter.name for parameter in parameters(one.get("params"))}
            for one in around
        )

    def _blocks(self, macro: Macro, element: Element, scope: Scope) -> dict[str, Any]:
        """Return the blocks that a call gives: an element with its scope (and True for it alone), or Handed."""
        required = [parameter for parameter in macro.parameters if parameter.block]
        given: list[Any] = []
        for child in element.children:
            if child.tag == "xacro:insert_block":
                found = self._block(child, scope)
                if isinstance(found, Handed) or len(found) == 3:
                    given.append(found)
                else:
                    given += [(one, found[1], True) for one in found[0].children]
            elif child.tag.startswith("xacro:"):
                raise Unsupported(f'a block of the call of "{macro.name}" is made by <{child.tag}>', child.span)
            else:
                given.append((child, scope, True))
        if len(given) != len(required):
            raise Unsupported(f'the macro "{macro.name}" takes {len(required)} blocks', element.span)
        pairs = zip(required, given, strict=True)
        return {
            one.name: block[:2] if one.block == "**" and not isinstance(block, Handed) else block
            for one, block in pairs
        }

    def _block(self, element: Element, scope: Scope) -> Any:
        name = element.get("name")
        found = next((here.blocks[name] for here in scope.around() if name in here.blocks), None)
        if found is None:
            raise Unsupported(f'there is no block "{name}"', element.span)
        return found

    def _insert(self, element: Element, scope: Scope, when: Whens, level: str, body: Body) -> Iterator[Found]:
        found = self._block(element, scope)
        if isinstance(found, Handed):
            if level in ("robot", "xml"):
                raise Unsupported(f'the block "{found.name}" is inserted here', element.span)
            yield Found(found, scope, when, (), body)
            return
        block, inner, *single = found
        for child in [block] if single else block.children:
            yield from self.step(child, inner, when, level, body, ())

    def _block_entry(self, macro: Macro, name: str, block: Any) -> Entry:
        """Return what a block holds, read at the level at which the macro inserts it."""
        level = macro.block_levels.get(name)
        entry = Entry()
        if level is None:
            return entry
        body = Body(macro.file)
        if isinstance(block, Handed):
            read_found(self, Found(block, Scope(), (), (), body), level, entry)
        elif len(block) == 3:
            read_found(self, Found(block[0], block[1], (), (), body), level, entry)
        else:
            entry = read_entry(self, block[0], block[1], level, body)
        if level == "joint":
            set_dimensions(entry, "", True)
        macro.blocks_given.setdefault(name, []).append(entry)
        return entry

    # Elements among links and joints.

    def take(self, found: Found) -> None:
        """Add an element to its body. Raises GiveUp."""
        element, body = found.item, found.body
        if not isinstance(element, Element) or (self._only_materials and element.tag != "material"):
            return
        if element.tag == "material" and body.macro is not None:
            body.macro.makes_materials = True  # they are those of the whole robot
            return
        if place_of(element.span) in self.plan.flat:
            self._reach(element, found.scope, found.when)
            return
        try:
            if element.tag not in ("link", "joint", "material"):
                xml = self.xml(element, found.scope, body)
                body.elements.append(Listed(xml, found.when, found.comments, element))
                return
            name = self.names.value(element, "name", found.scope, NAME)
            comments = found.comments if element.tag == "material" else (*found.comments, *comments_within(element))
            if element.tag == "joint":
                entry = joint_entry(self, element, found.scope, body)
            else:
                entry = read_entry(self, element, found.scope, element.tag, body)
            made = Named(name, entry, found.when, comments, element)
        except Unsupported as problem:
            raise GiveUp(element, problem) from None
        {"link": body.links, "joint": body.joints, "material": body.materials}[element.tag].append(made)

    def xml(self, element: Element, scope: Scope, body: Body) -> Xml:
        """Return an element that is kept as text."""
        made = Xml(element.tag)
        for name in element.attributes:
            if not name.startswith(("xacro:", "xmlns:xacro")):
                made.attributes.append((name, self.names.value(element, name, scope, XML)))
        made.content = self.xml_content(self.flow(element, scope, (), "xml", body))
        return made

    def xml_content(self, found: Iterator[Found]) -> list[Any]:
        """Return the content of an element that is kept; what is on a condition is a group."""
        content: list[Any] = []
        for item, scope, when, _, body in found:
            into = content
            for on in when:
                last = into[-1] if into else None
                if not (isinstance(last, Xml) and not last.tag and last.when[0] is on):
                    into.append(Xml("", when=(on,)))
                into = into[-1].content
            if isinstance(item, Element):
                into.append(self.xml(item, scope, body))
            elif isinstance(item, Remark) and item.kind != COMMENT:
                into.append(self.names.resolve(item.text, scope, XML))
                note(into[-1])
            else:
                into.append(item)
        return content

    # What is not translated.

    def _reach(self, element: Element, scope: Scope, when: Whens) -> None:
        """Record the variables that may decide an element which stays as xacro expands it."""
        found = self.reached.setdefault(place_of(element.span), set())
        for on in when:
            found.update(references(on.test))
        waiting: list[str] = [element.verbatim]
        visited: set[str] = set()
        while waiting:
            verbatim = waiting.pop()
            for name in set(_CALLED.findall(verbatim)) - visited:
                for one, _ in self.macros_named(name, scope):
                    one.called = True
                    waiting.append(one.element.verbatim)
            for name in set(_WORD.findall(verbatim)) - visited:
                visited.add(name)
                for key in (name, f"arg {name}"):
                    value = scope.find(key)
                    if isinstance(value, Variable):
                        found.add(value)
                    elif value is not None:
                        found.update(references(value.text) if value.text else ())
                        waiting.append(value.raw)

    def reaching(self, place: Place) -> list[str]:
        """Return the arguments that may decide an element which stays as xacro expands it."""
        waiting, found = list(self.reached.get(place, ())), set()
        while waiting:
            variable = waiting.pop()
            if variable in found:
                continue
            found.add(variable)
            if variable.pending is not None:
                waiting += [
                    self.names.arguments[one] for one in _WORD.findall(variable.raw) if one in self.names.arguments
                ]
            waiting += [one for text in variable.values for one in references(text)]
            for macro in self.kept:
                if variable in macro.variables.values():
                    waiting += [one for use in macro.uses for on in use.when for one in references(on.test)]
        return [name for name, variable in self.names.arguments.items() if variable in found]


def _file_of(*bindings: Variable | Bound) -> File | None:
    return next((one.file for one in bindings if isinstance(one, Variable) and one.file is not None), None)


def _equals(text: Text, name: str) -> ast.expr:
    """Return the condition that a text with one evaluated piece equals a name."""
    open_pieces = [piece for piece in text.pieces if piece.kind != TEXT]
    before = text.pieces[0].value if text.pieces[0].kind == TEXT else ""
    after = text.pieces[-1].value if text.pieces[-1].kind == TEXT else ""
    node, said = text.node(), name
    if len(open_pieces) == 1:
        node, said = open_pieces[0].value, name.removeprefix(before).removesuffix(after)
    return ast.Compare(node, [ast.Eq()], [ast.Constant(said)])


def _folders(loaded: Variable) -> Iterator[Variable]:
    """Yield what the names of loaded files begin with."""
    for value in loaded.head().values:
        first = value.pieces[0].value if len(value.pieces) > 1 else None
        if isinstance(first, Ref) and LOADED not in first.variable.head().evidence:
            yield first.variable


def _macro_around(element: Element) -> Element | None:
    here = element.parent
    while here is not None and here.tag != "xacro:macro":
        here = here.parent
    return here

"""Setting: the properties of macros: where they hold, and what the names mean from there on.

A property holds in its macro, that of another macro or of all; one that is set within a link or a joint from there on.
One that is set on a condition is a named value with a choice.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from rosorin_compile.language.expression.functions import expression_names
from rosorin_compile.source.xml.markup import Element

from .naming import variables_in
from .pieces import Body, Macro, When, Whens
from .program import Program
from .scopes import (
    ARGUMENT,
    CONDITION,
    FREE,
    LOADED,
    LOCAL,
    PARAMETER,
    Bound,
    Returned,
    Scope,
    Unsaid,
    Value,
    Variable,
    is_plain,
    names_of,
    note,
    sole_name,
)
from .texts import EXPRESSION, Unsupported, signed, source_tree, tokens

if TYPE_CHECKING:
    from .expressions import Rendering


class MacroScope(Scope):
    """The names of a macro: a name that is nowhere else is one of whoever calls it, and becomes a parameter."""

    def __init__(self, parent: Scope, macro: Macro) -> None:
        super().__init__(parent, macro.name)
        self.macro = macro

    def handed_down(self, name: str) -> Variable | None:
        if not _may_be_handed_down(name):
            return None
        made = Variable(name, PARAMETER)
        self.macro.implicit[name] = made
        self.names[name] = made
        return made


def _may_be_handed_down(name: str) -> bool:
    from .expressions import _CONSTANTS, _MODULES

    reserved = (*_CONSTANTS, *_MODULES, "pi", "e", "tau", "inf", "nan", "xacro", "__text")
    return name.isidentifier() and name not in reserved


class Setting:
    """What a walk knows of properties, and of what flows from one named value into another."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.fixed: set[Variable] = set()
        self.flows: list[tuple[Variable, Variable]] = []

    def without_value(self, element: Element, scope: Scope) -> None:
        """Take a property that has a default, or is a block."""
        name = element.get("name")
        if "default" not in element.attributes:
            scope.blocks[name] = (element, scope)
        elif scope.lookup(name) is None:
            scope.names[name] = Bound(element.get("default"), scope)

    def local(self, element: Element, body: Body, scope: Scope, when: Whens) -> None:
        """Take a property of a macro."""
        name = element.get("name")
        if "$" in name or element.get("remove"):
            raise Unsupported(f'the property "{name}" is named by an expression, or removed', element.span)
        if "value" not in element.attributes:
            self.without_value(element, scope)
            return
        text = element.get("value")
        target = self.target(element, scope)
        if target is not scope.begun() and isinstance(scope.begun(), MacroScope):
            self.set_above(name, Value(text, scope, FREE, element.span), body, when)
            target = scope.begun()  # it reads it itself
        if target.set_later(name):
            self.inner_property(element, scope, when)
            return
        known = target.names.get(name)
        value = Value(text, scope, FREE, element.span)
        open_ends = tuple(on for on in when if decided(on) is None)
        if isinstance(known, Variable) and known.where == LOCAL:
            self.local_again(name, known, value, body, target, when)
            return
        if isinstance(known, Variable) and not (
            isinstance(target, MacroScope) and known in target.macro.implicit.values() and not known.values
        ):
            if open_ends:
                self.anew(name, value, body, target, open_ends, target)
            elif isinstance(target, MacroScope) and known in target.macro.variables.values():
                self.new_local(name, value, body, target, (), target)
            else:
                target.set_from_here(name, Bound(text, scope))
            return
        if isinstance(known, Bound):
            if open_ends:
                self.chosen_property(element, scope, target, open_ends)
            else:
                target.set_from_here(name, Bound(text, scope))
            return
        if not isinstance(target, MacroScope) and target.parent is not None and not when and "(" not in text:
            target.names[name] = Bound(text, scope)
            return
        self.new_local(name, value, body, target, when)

    def set_above(self, name: str, value: Value, body: Body, when: Whens) -> None:
        """Note that a macro sets a property of its caller. Raises Unsupported if its own properties decide it."""
        macro = body.macro
        texts = [value.text, *(on.value.text for on in when)]
        names = {one for text in texts for one in foreign(text)}
        if macro is None or not all(one in macro.variables or self.program.scope.lookup(one) for one in names):
            raise Unsupported("it sets properties of whoever calls it", value.span)
        macro.sets.append((name, value, when))

    def set_by_part(self, macro: Macro, given: Mapping[str, Value], scope: Scope, when: Whens) -> None:
        """Let a caller of a part read what that sets for it."""
        inner, target = Scope(scope), scope.begun()
        for parameter in macro.parameters:
            said = given.get(parameter.name)
            if said is not None:
                inner.names[parameter.name] = Bound(said.text, said.scope)
            elif parameter.default is not None:
                inner.names[parameter.name] = Bound(parameter.default, macro.file.body.scope)
        for name, value, on in macro.sets:
            if value is None:
                target.set_from_here(name, Unsaid(f'"{name}" is set by what "{macro.name}" calls'))
            else:
                whens = [When(Value(one.value.text, inner, CONDITION), one.holds) for one in on]
                holds = [(one, decided(one)) for one in (*when, *whens)]
                left = tuple(one for one, held in holds if held is None)
                if any(held is False for _, held in holds):
                    continue
                if left:
                    self.chosen_value(name, Value(value.text, inner, FREE, value.span), scope, target, left)
                else:
                    target.set_from_here(name, Bound(value.text, inner))
            if isinstance(target, MacroScope):  # it may be one of all
                target.macro.sets.append((name, None, ()))

    def local_again(self, name: str, known: Variable, value: Value, body: Body, target: Scope, when: Whens) -> None:
        """Take a property of a macro that it has set before."""
        if known in self.fixed and not when:
            self.new_local(name, value, body, target, when, target)
        elif _reads(known, value, when):
            self.anew(name, value, body, target, when, target)
        else:
            known.values.append(value)
            known.definitions.append((value, when))
            self.hand(value, known)

    def changing(self, element: Element, scope: Scope, when: Whens) -> None:
        """Take a property at the top of a file that is set to another value later on: it holds until then."""
        name, here = element.get("name"), scope.begun()
        if "default" in element.attributes:
            if scope.latest().lookup(name) is None:
                here.set_from_here(name, Bound(element.get("default"), scope))
        elif left := tuple(on for on in when if decided(on) is None):
            self.chosen_property(element, scope, here, left)
        else:
            here.set_from_here(name, Bound(element.get("value"), scope))

    def anew(self, name: str, value: Value, body: Body, holder: Scope, when: Whens, later: Scope) -> None:
        """Take a property that is set on a condition from what it was before."""
        before = Value(f"${{{name}}}", value.scope, FREE, value.span)
        made = self.new_local(name, value, body, holder, when, later)
        made.definitions.insert(0, (before, ()))
        self.hand(before, made)

    def target(self, element: Element, scope: Scope) -> Scope:
        """Return the scope that a property is set in."""
        where, here = element.get("scope"), scope.begun()
        if where == "global":
            return scope.top()
        if where == "parent":
            return here.parent.begun() if here.parent is not None else here
        return here

    def new_local(
        self, name: str, value: Value, body: Body, target: Scope, when: Whens, later: Scope | None = None
    ) -> Variable:
        from .expressions import usable

        taken = {"name", "prefix"} | {one.ours for one in body.locals} | {one.ours for one in _variables(target)}
        if body.macro is None:
            taken |= {one.ours for one in _variables(self.program.scope)}
            taken |= {one.ours for file in self.program.files.values() for one in file.body.locals}  # all share them
        made = Variable(name, LOCAL, usable(name, lambda one: one in taken), span=value.span)
        made.values.append(value)
        made.definitions = [(value, when)]
        if later is not None:
            later.set_from_here(name, made)
        else:
            target.names[name] = made
        body.locals.append(made)
        if not when:
            self.fixed.add(made)
        self.hand(value, made)
        return made

    def inner_property(self, element: Element, scope: Scope, when: Whens) -> None:
        """Take a property that is set within an element; it holds from there on, outside of the element too."""
        name = element.get("name")
        if "$" in name or "value" not in element.attributes or element.get("remove"):
            raise Unsupported(f'the property "{name}" stands inside of an element', element.span)
        target, here = self.target(element, scope), scope.begun()
        if isinstance(here, MacroScope):
            target = here  # what a part sets for its caller within an element, it reads itself
        open_ends = [(one, decided(one)) for one in when]
        if any(holds is False for _, holds in open_ends):
            return
        left = tuple(one for one, holds in open_ends if holds is None)
        if left:
            self.chosen_property(element, scope, target, left)
        else:
            target.set_from_here(name, Bound(element.get("value"), scope))
        found = target.latest().lookup(name)
        if target is not here and isinstance(found, (Variable, Bound, Returned)):  # it is read here, too
            here.set_from_here(name, found)

    def chosen_property(self, element: Element, scope: Scope, target: Scope, when: Whens) -> None:
        """Take a property within an element that is set on a condition: a named value of the part."""
        value = Value(element.get("value"), scope, FREE, element.span)
        self.chosen_value(element.get("name"), value, scope, target, when)

    def chosen_value(self, name: str, value: Value, scope: Scope, target: Scope, when: Whens) -> None:
        """Take what a name is from here on where a condition holds."""
        known = target.latest().lookup(name)
        own = (
            isinstance(known, Variable) and known.where == LOCAL and known not in self.fixed and target.set_later(name)
        )
        if isinstance(known, Variable) and own and not _reads(known, value, when):
            known.values.append(value)
            known.definitions.append((value, when))
            self.hand(value, known)
            return
        holder = next((one for one in _around(scope) if isinstance(one, MacroScope)), None)
        if known is None or (holder is not None and known in holder.macro.implicit.values()):
            # whoever reads it elsewhere has no value of it
            target.set_from_here(name, Bound(value.text, value.scope, when))
            return
        body = holder.macro.body if holder is not None else self.program.root.body
        if body is None:
            raise Unsupported(f'the property "{name}" is set on a condition', value.span)
        if own:
            self.anew(name, value, body, holder or target, when, target)
            return
        made = self.new_local(name, value, body, holder or target, when, target)
        if isinstance(known, Returned):
            inner = Scope(scope)
            inner.names[name] = known
            known = Bound(f"${{{name}}}", inner)
        if isinstance(known, Bound):
            made.definitions.insert(0, (Value(known.text, known.scope, FREE, value.span), known.when))
            made.values.insert(0, made.definitions[0][0])

    def hand(self, value: Value, variable: Variable) -> None:
        """Take down that a value becomes that of a variable."""
        note(value)
        for source in _sources(value):
            found = value.scope.find(source)
            while isinstance(found, Bound):
                name = sole_name(tokens(found.text))
                found = found.scope.find(name) if name else None
            if isinstance(found, Variable) and found is not variable:
                if "argument" in (found.where, variable.where):
                    self.flows.append((found, variable))
                else:
                    variable.join(found)

    def spread(self) -> None:
        """Let arguments know how what they are handed to is used."""
        named = [one for one in self.program.scope.names.values() if isinstance(one, Variable)]
        while folders := {found for one in named if LOADED in one.head().evidence for found in _folders(one)}:
            for folder in folders:
                folder.head().evidence.add(LOADED)
        changed = True
        while changed:
            changed = False
            for argument, variable in self.flows:
                more = variable.head().evidence - argument.head().evidence
                argument.head().evidence |= more
                changed = changed or bool(more)
        for argument, variable in self.flows:  # what is given nothing else is of the kind of the argument
            said = [one for one in variable.head().values if not one.idle]
            if variable.where != ARGUMENT and not any(is_plain(one.text) for one in said):
                variable.head().values += [one for one in argument.values if is_plain(one.text)]


def _folders(loaded: Variable) -> Iterator[Variable]:
    """Yield what the names of files that are loaded begin with, and of which that is not known yet."""
    for value in loaded.head().values:
        pieces = tokens(value.text)
        name = sole_name(pieces[:1]) if len(pieces) > 1 else None
        found = value.scope.lookup(name) if name else None
        if isinstance(found, Variable) and LOADED not in found.head().evidence:
            yield found


def _reads(variable: Variable, value: Value, when: Whens) -> bool:
    """Say whether a value on a condition, or the condition, is made of what a variable is by then."""
    return bool(when) and any(variable in variables_in(one) for one in (value, *(on.value for on in when)))


def constant(value: Value) -> Any:
    """Return what a value is wherever it is asked; None if that depends on an argument or a parameter."""
    from .expressions import folded

    try:
        return folded(_rendering().value(value))
    except Unsupported:
        return None


def decided(when: When) -> bool | None:
    """Return whether a condition holds wherever it is asked; None if that depends on an argument or a parameter."""
    from .expressions import folded

    try:
        holds = folded(_rendering().condition(when.value))
    except Unsupported:
        return None
    return None if holds is None else bool(holds) == when.holds


def _rendering() -> Rendering:
    """Return what renders expressions with the properties of macros that have one value."""
    from .expressions import Rendering

    def of_local(variable: Variable) -> ast.expr | None:
        plain = variable.where == LOCAL and [one for one, on in variable.definitions if not on]
        return made.value(plain[0]) if plain and len(variable.definitions) == 1 else None

    made = Rendering(lambda _: None, of_local)
    return made


def foreign(text: str) -> Iterator[str]:
    """Yield the names in a text that are none of Python's or of xacro's."""
    for piece in tokens(text):
        try:
            tree = source_tree(piece.text) if piece.kind == EXPRESSION else None
        except ValueError:
            tree = None
        for name in names_of(tree) if tree is not None else ():
            if _may_be_handed_down(name) and name not in expression_names().functions:
                yield name


def _around(scope: Scope) -> Iterator[Scope]:
    """Yield a scope and those around it."""
    here: Scope | None = scope
    while here is not None:
        yield here
        here = here.parent


def _variables(scope: Scope) -> Iterator[Variable]:
    """Yield the variables that a scope and those around it know."""
    for here in _around(scope):
        yield from (one for one in here.names.values() if isinstance(one, Variable))


def _sources(value: Value) -> list[str]:
    """Return the names that a value may be as it is: of a name, of a choice between names."""
    pieces = tokens(value.text)
    name = sole_name(pieces)
    if name:
        return [name]
    parts = signed(pieces)
    if parts is not None:  # it is a number where that is one
        return [one] if (one := sole_name([parts[1]])) else []
    if len(pieces) == 1 and pieces[0].kind == "expression":
        try:
            tree = source_tree(pieces[0].text)
        except ValueError:
            return []
        if isinstance(tree, ast.IfExp):
            return [one.id for one in (tree.body, tree.orelse) if isinstance(one, ast.Name)]
    return []

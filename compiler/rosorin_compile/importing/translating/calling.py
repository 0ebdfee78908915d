"""Calling: which macros a call of a xacro may mean, what it gives them, and macros that are written out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fnmatch import fnmatchcase

from rosorin_compile.source.xml.markup import Element

from .lifting import equal_to, is_handed, pattern_of
from .pieces import Macro, When, Whens
from .program import Program
from .scopes import CONDITION, FREE, PARAMETER, Bound, Returned, Scope, Unsaid, Value, Variable, note
from .setting import MacroScope, Setting, decided, foreign
from .texts import Parameter, Unsupported

MAX_DEPTH = 60


class Calling(Setting):
    """What a walk knows of macros and of their calls, by now.

    ``pins`` are parameters that have one value, by macro and name.
    """

    def __init__(self, program: Program, pins: Mapping[tuple[str, str], str] | None) -> None:
        super().__init__(program)
        self.pins = pins or {}
        self.depth = 0
        self.defaults: list[tuple[Macro, str, Value]] = []
        self.taken: set[tuple[Macro, str]] = set()  # the parameters whose defaults are taken
        self.resolved: dict[int, str] = {}  # what is called by an expression, while it is taken for one macro
        self.current: dict[str, list[tuple[Macro, Whens]]] = {}

    # Which macros.

    def define(self, macro: Macro, name: str, when: Whens) -> None:
        """Take down that a name is that of a macro from here on; under a condition it may be."""
        name = f"{macro.file.space}.{name}".strip(".")
        known = [one for one in self.current.get(name, []) if one[0] is not macro and not set(when) <= set(one[1])]
        self.current[name] = [*known, (macro, when)]

    def macros_named(self, name: str, element: Element) -> list[tuple[Macro, Whens]]:
        """Return the macros that a name may mean by now where an element stands."""
        return self.current.get(self.spelt(name, element), [])

    def spelt(self, name: str, element: Element) -> str:
        """Return the name of a macro as it is known, of the space that an element stands in or of all."""
        own = f"{self.program.spaces.get(id(element.document), '')}.{name}".strip(".")
        return own if own in self.current else name

    def candidates(self, element: Element) -> list[tuple[Macro, Whens]]:
        """Return the macros that a call may mean, each with the condition on which it does; nothing if it is clear."""
        known = self.macros_named(element.tag.removeprefix("xacro:"), element)
        if len(known) < 2:
            return []
        made: list[tuple[Macro, Whens]] = []
        for index, (macro, when) in enumerate(known):
            others = [later for _, later in known[index + 1 :]]
            if not when and any(len(one) != 1 for one in others):
                raise Unsupported("a macro is defined anew on several conditions", element.span)
            negated = tuple(When(one[0].value, not one[0].holds) for one in others) if not when else ()
            made.append((macro, (*when, *negated)))
        return made

    def each_candidate(self, element: Element) -> Iterator[Whens]:
        """Take a call for each macro of one name in turn, and yield on which condition it is."""
        name = self.spelt(element.tag.removeprefix("xacro:"), element)
        before = self.current[name]
        for one, on in self.candidates(element):
            self.current[name] = [(one, ())]
            for condition in on:
                note(condition.value)
            yield on
        self.current[name] = before

    def macro_of(self, element: Element) -> Macro:
        """Return the macro that an element calls. Raises Unsupported."""
        name = element.tag.removeprefix("xacro:")
        if name == "call":
            target = self.resolved.get(id(element), element.get("macro"))
            if "$" in target:
                raise Unsupported(f'the macro "{target}" is called by an expression', element.span)
            name = target
        if name in ("element", "attribute"):
            raise Unsupported(f"xacro:{name} makes what an expression names", element.span)
        known = self.macros_named(name, element)
        macro = known[-1][0] if known else self.program.macro(name, element)
        if macro is None:
            raise no_macro(name, element)
        macro.called = True
        return macro

    def is_open(self, element: Element) -> bool:
        """Say whether a call may mean several macros, or an expression says which, and it is not taken for one."""
        if element.tag == "xacro:call" and "$" in element.get("macro"):
            return id(element) not in self.resolved
        return (
            element.tag.startswith("xacro:") and len(self.macros_named(element.tag.removeprefix("xacro:"), element)) > 1
        )

    def targets(self, element: Element, scope: Scope) -> Iterator[Whens]:
        """Take a call for each macro in turn that may be meant, and yield on which condition it is."""
        if element.tag != "xacro:call" or "$" not in element.get("macro"):
            yield from self.each_candidate(element)
            return
        called, found = element.get("macro"), False
        pattern, given = pattern_of(called), element.attributes.keys() - {"macro"}
        for macro in list(self.program.macros.values()):
            needed = {one.name for one in macro.parameters if not one.block and one.default is None and not one.forward}
            if not (fnmatchcase(macro.name, pattern) and needed <= given <= {one.name for one in macro.parameters}):
                continue
            on = When(Value(equal_to(called, macro.name), scope, CONDITION, element.span), True)
            holds = decided(on)
            if holds is False:
                continue
            found = True
            note(on.value)
            self.resolved[id(element)] = macro.name
            try:
                yield () if holds else (on,)
            finally:
                self.resolved.pop(id(element), None)
            if holds:
                return
        if not found:
            raise Unsupported(f'the macro "{called}" is called by an expression', element.span)

    # What they are given.

    def given(self, macro: Macro, element: Element, scope: Scope) -> dict[str, Value]:
        """Return what a call gives to the parameters of a macro, by name; defaults where it gives nothing."""
        made: dict[str, Value] = {}
        for name, attribute in element.attributes.items():
            if (name == "macro" and element.tag == "xacro:call") or name.startswith("xmlns"):
                continue
            made[name] = Value(attribute.value, scope, FREE, attribute.span)
        for parameter in macro.parameters:
            if parameter.block or parameter.name in made:
                continue
            if parameter.forward:
                found = scope.find(parameter.name)
                by_itself = parameter.default is None and parameter.of_caller is None
                if found is not None and (by_itself or not self.is_new(found, scope) or self.is_handed(found, scope)):
                    made[parameter.name] = Value(f"${{{parameter.name}}}", scope, FREE, element.span)
                    continue
            self.taken.add((macro, parameter.name))
            if parameter.of_caller is not None:
                made[parameter.name] = Value(parameter.of_caller, scope, FREE, element.span)
            elif parameter.default is None:
                raise Unsupported(f'the macro "{macro.name}" lacks its parameter {parameter.name}', element.span)
        return made

    def is_new(self, found: Variable | Bound | Returned | Unsaid, scope: Scope) -> bool:
        """Say whether a name is one that nobody has defined so far."""
        here: Scope | None = scope
        while here is not None:
            if isinstance(here, MacroScope) and found in here.macro.implicit.values():
                return not found.values if isinstance(found, Variable) else False
            here = here.parent
        return False

    def is_handed(self, found: Variable | Bound | Returned | Unsaid, scope: Scope) -> bool:
        """Say whether a name that a macro does not define is one of whoever calls it, always."""
        here: Scope | None = scope
        while here is not None and not isinstance(here, MacroScope):
            here = here.parent
        return here is not None and isinstance(found, Variable) and is_handed(self.program, here.macro, found.name)

    def blocks(self, macro: Macro, element: Element, scope: Scope) -> dict[str, tuple[Element, Scope]]:
        """Return the blocks that a call gives, by parameter."""
        wanted = [parameter for parameter in macro.parameters if parameter.block]
        children: list[tuple[Element, Scope]] = []
        for child in element.children:
            if child.tag == "xacro:insert_block":
                try:
                    children += self.inserted(child, scope)
                except Unsupported:
                    children.append((child, scope))
            elif child.tag.startswith("xacro:"):
                raise Unsupported(f'a block of the call of "{macro.name}" is made by <{child.tag}>', child.span)
            else:
                children.append((child, scope))
        if len(children) != len(wanted):
            raise Unsupported(f'the macro "{macro.name}" takes {len(wanted)} blocks', element.span)
        return {parameter.name: child for parameter, child in zip(wanted, children, strict=True)}

    def inserted(self, element: Element, scope: Scope) -> list[tuple[Element, Scope]]:
        """Return the elements that a block inserts, each with its scope."""
        found = scope.block(element.get("name"))
        if isinstance(found, Parameter) or not isinstance(found, tuple):
            raise Unsupported(f'the block "{element.get("name")}" is inserted here', element.span)
        block, inner, *single = found
        if single:  # a parameter of one element
            return [(block, inner)]
        return [(child, inner) for child in block.children]

    def hand_over(self, macro: Macro, given: dict[str, Value]) -> None:
        """Take down that what a call gives is a value of the macro's parameters."""
        for name, value in given.items():
            variable = macro.variables.get(name)
            if variable is None and (macro.name, name) in self.pins:
                continue
            if variable is None:
                raise Unsupported(f'the macro "{macro.name}" has no parameter {name}', value.span)
            variable.head().values.append(value)
            self.hand(value, variable)

    # Their bodies.

    def begin(self, macro: Macro, level: str) -> None:
        """Begin to walk over a macro that is to be said once: make its scope and its variables.

        ``level`` is where it is called: ``part`` among links and joints, ``xml``, or an element such as ``link``.
        """
        macro.level = level
        macro.scope = MacroScope(macro.file.body.scope, macro)
        macro.parameters = [self.settled(parameter) for parameter in macro.parameters]
        for parameter in macro.parameters:
            if parameter.block:
                macro.scope.blocks[parameter.name] = parameter
                continue
            if (macro.name, parameter.name) in self.pins:
                text = self.pins[macro.name, parameter.name]
                macro.scope.names[parameter.name] = Bound(text, self.program.scope)
                continue
            ours = parameter.name
            if ours in self.program.arguments and f"$(arg {ours})" in macro.element.verbatim:
                ours = f"{ours}_2"  # it reads the argument of that name, too
            made = Variable(parameter.name, PARAMETER, ours, span=macro.place)
            if parameter.default is not None:
                value = Value(parameter.default, macro.file.body.scope, FREE, macro.place)
                made.values.append(value)
                self.hand(value, made)
                self.defaults.append((macro, parameter.name, value))
            macro.variables[parameter.name] = made
            macro.scope.names[parameter.name] = made

    def settled(self, parameter: Parameter) -> Parameter:
        """Return a parameter; a default that speaks of names which are not known everywhere is the caller's."""
        default = parameter.default
        if default is None or all(self.program.scope.find(name) is not None for name in foreign(default)):
            return parameter
        return parameter._replace(default=None, of_caller=default)

    def write_out(self, macro: Macro, element: Element, scope: Scope, then: Callable[[Scope], None]) -> None:
        """Walk over a macro where it is called."""
        itself = Unsupported(f'the macro "{macro.name}" calls itself', element.span)
        self.depth += 1
        if self.depth > MAX_DEPTH:
            self.depth = 0
            raise itself
        inner = Scope(scope, macro.name)
        given = self.given(macro, element, scope)
        for parameter in macro.parameters:
            if not parameter.block:
                value = given.get(parameter.name)
                text = value.text if value is not None else parameter.default or ""
                inner.names[parameter.name] = Bound(text, value.scope if value is not None else scope)
        for name, (block, where) in self.blocks(macro, element, scope).items():
            single = next(one.block for one in macro.parameters if one.name == name) == "*"
            inner.blocks[name] = (block, where, True) if single else (block, where)
        try:
            then(inner)
        except RecursionError:  # of Python, before the depth is reached
            self.depth = 0
            raise itself from None
        self.depth -= 1


def no_macro(name: str, element: Element) -> Unsupported:
    """Return what is to be said of an element that calls a macro which is nowhere."""
    return Unsupported(f'there is no macro "{name}"', element.span)


__all__ = ["Calling", "no_macro"]

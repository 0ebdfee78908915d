"""Walking: what the files and macros of a xacro make, as pieces of a description.

What a macro makes decides what it becomes: links, joints and elements of a robot make it a part; what stands inside of
a link or a joint a named value with parameters. ``inlined`` are macros that are written out where they are called.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element

from .among import Among
from .calling import Calling
from .contexts import Comments, Context
from .entries import one_of_level, reads, units_of
from .flattened import Place, flat_entries, place_of
from .lifting import elements_at, leading_to, macro_around
from .pieces import Call, Entry, Macro, When
from .problems import AtTop
from .program import Program
from .returning import returns, set_by
from .scopes import CONDITION, Scope, Value, Variable, note
from .setting import decided
from .texts import Unsupported


class Walker(Calling):
    """One walk over a program, with some macros written out."""

    def __init__(
        self,
        program: Program,
        inlined: frozenset[str],
        flat: frozenset[Place] = frozenset(),
        trees: Sequence[Map] = (),
        pins: Mapping[tuple[str, str], str] | None = None,
        lifted: frozenset[Place] = frozenset(),
    ) -> None:
        super().__init__(program, pins)
        self.lifted = {id(one): one for one in elements_at(program, lifted)}
        self.inner_flat = {id(one): place_of(one.span) for one in elements_at(program, flat) if macro_around(one)}
        self.lifting: set[Macro] | None = None  # the macros that lead to what is lifted, while that is taken
        self.inlined = inlined
        self.flat = flat
        self.trees = trees
        self.at: Element | None = None  # what stands at the top of a file and is walked over
        self.seen: list[Macro] = []

    def walk(self) -> None:
        """Walk over everything."""
        self.note_properties(self.program.properties)
        for variable in self.program.arguments.values():
            for value in variable.values:
                self.hand(value, variable)
        for condition in self.program.conditions:
            note(condition)
        file = self.program.root
        Among(self, (), file.body, top=True).each(file.document.root, file.body.scope)
        if self.lifted:
            self.lift()
        for macro, name, default in self.defaults:
            default.idle = (macro, name) not in self.taken
        for place in self.inner_flat.values():
            file.body.flat += flat_entries(self.trees, place, (), ())
        self.spread()

    def lift(self) -> None:
        """Take what is lifted out of macros, as if these were written out where they are called."""
        self.program.scope.later = None
        self.lifting, self.current = leading_to(self.program, self.lifted.values()), {}
        file = self.program.root
        try:
            Among(self, (), file.body, top=True).each(file.document.root, file.body.scope)
        except AtTop as found:
            found.problem.element = found.problem.element or next(iter(self.lifted.values()))
            raise
        finally:
            self.lifting = None

    def passes_over(self, child: Element) -> bool:
        """Say whether an element is not taken now: it is lifted, or flat; or only what is lifted is taken."""
        if id(child) in self.inner_flat:
            return True
        if self.lifting is None:
            return id(child) in self.lifted
        if child.tag in ("xacro:if", "xacro:unless", "xacro:include", "xacro:macro", "xacro:property", "xacro:arg"):
            return False
        if not child.tag.startswith("xacro:"):
            return id(child) not in self.lifted
        name = child.get("macro") if child.tag == "xacro:call" else child.tag.removeprefix("xacro:")
        return "$" not in name and (found := self.program.macro(name, child)) is not None and found not in self.lifting

    def note_properties(self, names: Iterable[str]) -> None:
        """Take down how properties at the top of files are used."""
        for name in names:
            variable = self.program.scope.names.get(name)
            for definition in self.program.properties[name] if isinstance(variable, Variable) else ():
                for on in definition.when:
                    note(on.value)
                self.hand(definition.value, variable)  # type: ignore[arg-type]

    # What an element is.

    def take(self, child: Element, scope: Scope, comments: Comments, context: Context) -> None:
        """Take one element: what it is to xacro is said here, what that makes where it stands by its context."""
        tag = child.tag
        if tag in ("xacro:if", "xacro:unless"):
            on = self.condition(child, scope)
            if decided(on) is not False:
                context.under((on,)).each(child, scope, comments)
        elif tag == "xacro:include":
            context.include(child, scope)
        elif tag == "xacro:property":
            context.property(child, scope, comments)
        elif tag == "xacro:macro":
            macro = self.program.by_element.get(id(child))
            if macro is None:  # a link or a joint outside of macros: only there it is no part and no named value
                raise Unsupported("a macro is defined within it", child.span)
            self.define(macro, child.get("name").removeprefix("xacro:"), context.when)
        elif tag == "xacro:arg":
            context.argument(child)
        elif tag == "xacro:insert_block":
            context.block(child, scope, comments)
        elif self.is_open(child):
            for chosen in self.targets(child, scope):
                self.take(child, scope, comments, context.under(chosen))
        elif tag.startswith("xacro:"):
            self.call(child, scope, comments, context)
        else:
            context.element(child, scope, comments)

    def call(self, element: Element, scope: Scope, comments: Comments, context: Context) -> None:
        """Take a call of a macro, of which it is known which one is meant."""
        macro = self.macro_of(element)
        if returns(self, macro, scope, context.when):
            set_by(self, macro, element, scope, context.when, context.body(scope))
        elif macro.name in self.inlined or not context.call(macro, element, scope, comments):
            context.write_out(macro, element, scope)

    def condition(self, element: Element, scope: Scope) -> When:
        value = Value(element.get("value"), scope, CONDITION, element.span)
        note(value)
        return When(value, element.tag == "xacro:if")

    def value(self, element: Element, name: str, scope: Scope, sink: str) -> Value:
        """Return the value of an attribute. Raises Unsupported if it is missing."""
        if name not in element.attributes:
            raise Unsupported(f"<{element.tag}> lacks the attribute {name}", element.span)
        made = Value(element.get(name), scope, sink, element.attributes[name].span)
        note(made)
        return made

    # Macros that are named values.

    def as_value(self, macro: Macro, level: str) -> bool:
        """Walk over a macro that makes what stands in a link, a joint and so on; say whether it can be a value."""
        if macro.level:
            return macro.level == level and macro.entry is not None
        self.begin(macro, level)
        try:
            entry = reads(self, macro.element, macro.scope, level)
            for item in entry.items if level == "joint" else ():
                units_of(item.value, "")
        except Unsupported:
            return False
        if not entry.items or any(item.key == "&" for item in entry.items):
            return False
        macro.entry = entry
        self.seen.append(macro)
        return True

    def value_call(self, macro: Macro, element: Element, scope: Scope) -> Call:
        given = self.given(macro, element, scope)
        made = Call(macro, given, {}, scope, element)
        for name, (block, inner) in self.blocks(macro, element, scope).items():
            if name in macro.block_levels:
                made.blocks[name] = self.block_entry(macro, name, block, inner)
        self.hand_over(macro, given)
        return made

    def block_entry(self, macro: Macro, name: str, block: Element, scope: Scope) -> Entry:
        """Return what a block says that a call hands over."""
        level = macro.block_levels.get(name)
        if level is None:  # nothing inserts it, or what does is never there
            return Entry()
        whole = next(one.block for one in macro.parameters if one.name == name) == "**"
        made = (reads if whole else one_of_level)(self, block, scope, level)
        macro.blocks_given.setdefault(name, []).append(made)
        for item in made.items if level == "joint" else ():
            units_of(item.value, "")
        known = macro.block_keys.setdefault(name, [])
        known += [key for key in made.names() if key not in known]
        return made

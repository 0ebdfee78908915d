"""Walking: what the files and macros of a xacro make, as pieces of a description.

What a macro makes decides what it becomes: links, joints and elements of a robot make it a part; what stands inside of
a link or a joint a named value with parameters. ``inlined`` are macros that are written out where they are called.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.extending import Element, Map, Remark

from .calling import Calling
from .entries import joint_entry, link_entry, material_entry, one_of_level, reads, units_of
from .fixing import value_of
from .flattened import Place, flat_entries, place_of
from .lifting import elements_at, leading_to, macro_around
from .naming import expanded, variables_in
from .pieces import Body, Call, Entry, Handed, Listed, Macro, Named, Use, When, Whens, Xml
from .problems import AtTop, InMacro
from .program import Fixed, Program, comments_within, with_comments
from .returning import body_around, returns, set_by
from .scopes import (
    ARGUMENT,
    CONDITION,
    FREE,
    NAME,
    XML,
    Scope,
    Value,
    Variable,
    is_argument,
    note,
)
from .setting import constant, decided
from .texts import EXPRESSION, Parameter, Token, Unsupported, tokens


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
        self.robot(file.document.root, file.body, file.body.scope, (), top=True)
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
            self.robot(file.document.root, file.body, file.body.scope, (), top=True)
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

    # What stands in a robot, or in a macro that is a part.

    def robot(
        self,
        element: Element,
        body: Body,
        scope: Scope,
        when: Whens,
        top: bool = False,
        above: tuple[str, ...] = (),
    ) -> None:
        """Take what an element holds: links, joints, calls, and what the language has no word for.

        ``above`` are the comments above the element, where they speak of the first that it holds.
        """
        for child, comments in with_comments(element):
            self.one(child, body, scope.latest(), when, (*above, *comments), top)
            above = ()

    def one(self, child: Element, body: Body, scope: Scope, when: Whens, comments: tuple[str, ...], top: bool) -> None:
        """Take one element; what cannot be said of one at the top of a file is told as ``AtTop``."""
        if self.passes_over(child):
            return
        if not top or child.tag in ("xacro:if", "xacro:unless", "xacro:include"):
            try:
                self.any(child, body, scope, when, comments, top)
            except Unsupported as problem:
                if problem.element is None and not child.tag.startswith("xacro:"):
                    problem.element = child
                raise
            return
        if place_of(child.span) in self.flat:
            body.flat += flat_entries(self.trees, place_of(child.span), when, comments)
            for condition in when:
                note(condition.value)
            return
        self.at = child
        try:
            self.any(child, body, scope, when, comments, top)
        except Unsupported as problem:
            raise AtTop(child, problem) from None
        finally:
            self.at = None

    def any(self, child: Element, body: Body, scope: Scope, when: Whens, comments: tuple[str, ...], top: bool) -> None:
        """Take one element."""
        tag = child.tag
        if tag in ("xacro:if", "xacro:unless"):
            on = self.condition(child, scope)
            if decided(on) is not False:
                self.robot(child, body, scope, (*when, on), top, comments)
        elif tag == "xacro:include":
            self.include(child, body, scope, when, top)
        elif tag == "xacro:property":
            self.property(child, body, scope, when, comments, top)
        elif tag == "xacro:macro":
            self.define(self.program.by_element[id(child)], child.get("name").removeprefix("xacro:"), when)
        elif tag == "xacro:arg":
            pass
        elif tag == "xacro:insert_block":
            self.block(child, body, scope, when)
        elif tag in ("link", "joint"):
            self.named(child, body, scope, when, comments)
        elif tag == "material":
            name = self.value(child, "name", scope, NAME)
            body.materials.append(
                Named(name, material_entry(self, child, scope), when, comments, child, self.at or child)
            )
        elif tag.startswith("xacro:"):
            self.call(child, body, scope, when, comments)
        else:
            body.elements.append(Listed(self.xml(child, scope), when, comments, self.at or child))

    def property(
        self, child: Element, body: Body, scope: Scope, when: Whens, comments: tuple[str, ...], top: bool
    ) -> None:
        """Take a property: at the top one that changes, elsewhere one of a macro."""
        if top:
            if child.get("name") in self.program.changing:
                self.changing(child, scope, when)
            return
        before = len(body.locals)
        self.local(child, body, scope, when)
        for variable in body.locals[before:]:
            variable.comments = comments

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

    def include(self, element: Element, body: Body, scope: Scope, when: Whens, top: bool) -> None:
        if id(element) in self.program.unclear:
            self.note_properties(self.files_named(element, body, scope))
        files = self.program.tops.get(id(element))
        for guard in self.program.guards.get(id(element), ()) if self.lifting is None else ():
            for condition in when:
                note(condition.value)
            body.guards.append((*guard, when, element))
        for file, more in files or ():
            for condition in more:
                note(condition.value)
            if top:
                self.robot(file.document.root, file.body, file.body.scope, (*when, *more), top=True)
            else:
                self.robot(file.document.root, body, scope, (*when, *more), top=True)

    def files_named(self, element: Element, body: Body, scope: Scope) -> list[str]:
        """Take down the files that a macro includes; return the properties that are new.

        Raises Fixed where an argument has a say in the name, but not as a piece of it.
        """
        value = Value(element.get("filename"), scope, FREE, element.span)
        text = constant(value)
        if isinstance(text, str):
            return self.program.add(text, element)
        pieces = [_plain(piece) for piece, _ in expanded(value.text, scope)]
        if all(piece.kind != EXPRESSION for piece in pieces):
            return self.program.add_chosen(pieces, element, self.program.file_of(element) or body.file)
        for variable in variables_in(value):
            name = variable.name if variable.where == ARGUMENT else ""
            said = value_of(self.program, name) if name else None
            if said is not None:
                raise Fixed(name, said, element)
        raise self.program.unclear[id(element)]

    def block(self, element: Element, body: Body, scope: Scope, when: Whens) -> None:
        """Take a block that is inserted among links and joints."""
        for child, inner in self.inserted(element, scope):
            self.one(child, body, inner, when, (), False)

    def named(self, child: Element, body: Body, scope: Scope, when: Whens, comments: tuple[str, ...]) -> None:
        name = self.value(child, "name", scope, NAME)
        read = link_entry if child.tag == "link" else joint_entry
        comments = (*comments, *comments_within(child))
        made = Named(name, read(self, child, scope), when, comments, child, self.at or child)
        (body.links if child.tag == "link" else body.joints).append(made)

    # Calls.

    def call(self, element: Element, body: Body, scope: Scope, when: Whens, comments: tuple[str, ...]) -> None:
        """Take a call of a macro among links and joints."""
        if self.is_open(element):
            for on in self.targets(element, scope):
                self.call(element, body, scope, (*when, *on), comments)
            return
        macro = self.macro_of(element)
        if returns(self, macro, scope, when):
            set_by(self, macro, element, scope, when, body)
            return
        if self.lifting is not None or macro.name in self.inlined or not self.as_part(macro):
            self.write_out(macro, element, scope, lambda inner: self.robot(macro.element, body, inner, when))
            return
        use = Use(macro, self.given(macro, element, scope), {}, scope, when, comments, element, self.at or element)
        for name, (block, inner) in self.blocks(macro, element, scope).items():
            use.blocks[name] = self.block_entry(macro, name, block, inner)
        self.hand_over(macro, use.given)
        macro.uses.append(use)
        body.uses.append(use)
        self.set_by_part(macro, use.given, scope, when)

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
        known += [key for key in made.known() if key not in known]
        return made

    def as_part(self, macro: Macro) -> bool:
        """Walk over a macro that is to be a part; say whether it can be one."""
        if macro.level == "part":
            return True
        if macro.level:
            raise Unsupported(f'the macro "{macro.name}" is called in a link and outside of links', macro.place)
        self.begin(macro, "part")
        body = Body(macro.file, macro, macro.scope)
        macro.body = body
        self.seen.append(macro)
        try:
            self.robot(macro.element, body, macro.scope, ())
        except Unsupported as problem:
            raise InMacro(macro, problem) from None
        return True

    # What stands inside of a link, a joint, and so on.

    def content(
        self, element: Element, scope: Scope, level: str, when: Whens = ()
    ) -> Iterator[tuple[Element | Call | Handed, Scope, Whens, tuple[str, ...]]]:
        """Yield what an element holds, with the conditions on it; calls of macros that are named values as they are."""
        for child, comments in with_comments(element):
            yield from self.inner(child, scope.latest(), level, when, comments)

    def inner(
        self, child: Element, scope: Scope, level: str, when: Whens, comments: tuple[str, ...] = ()
    ) -> Iterator[tuple[Element | Call | Handed, Scope, Whens, tuple[str, ...]]]:
        tag = child.tag
        if tag in ("xacro:if", "xacro:unless"):
            on = self.condition(child, scope)
            if decided(on) is not False:
                yield from self.content(child, scope, level, (*when, on))
        elif tag == "xacro:insert_block":
            handed = scope.block(child.get("name"))
            if isinstance(handed, Parameter):
                yield Handed(handed, scope), scope, when, comments
                return
            for block, inner in self.inserted(child, scope):
                yield from self.inner(block, inner, level, when)
        elif tag == "xacro:property":
            self.inner_property(child, scope, when)
        elif tag == "xacro:macro":
            self.define(self.program.by_element[id(child)], child.get("name").removeprefix("xacro:"), when)
        elif self.is_open(child):
            for chosen in self.targets(child, scope):
                yield from self.inner(child, scope, level, (*when, *chosen), comments)
        elif tag.startswith("xacro:"):
            yield from self.inner_call(child, scope, level, when, comments)
        else:
            yield child, scope, when, comments

    def inner_call(
        self, child: Element, scope: Scope, level: str, when: Whens, comments: tuple[str, ...]
    ) -> Iterator[tuple[Element | Call | Handed, Scope, Whens, tuple[str, ...]]]:
        """Yield what a macro that is called within an element gives."""
        macro = self.macro_of(child)
        if returns(self, macro, scope, when):
            set_by(self, macro, child, scope, when, body_around(scope))
            return
        if macro.name not in self.inlined and level != "xml" and self.as_value(macro, level):
            yield self.value_call(macro, child, scope), scope, when, comments
            return
        found: list[Any] = []
        self.write_out(
            macro, child, scope, lambda inside: found.extend(self.content(macro.element, inside, level, when))
        )
        yield from found

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
            return self.not_a_value(macro)
        if not entry.items or any(item.key == "&" for item in entry.items):
            return self.not_a_value(macro)
        macro.entry = entry
        self.seen.append(macro)
        return True

    def as_text(self, macro: Macro) -> bool:
        """Walk over a macro that is called among elements that are kept; say whether it can be a value."""
        if macro.level:
            return macro.level == "xml" and macro.text is not None
        self.begin(macro, "xml")
        if any(parameter.block for parameter in macro.parameters):
            return False
        try:
            found: list[Any] = []
            for item in macro.element.content:
                found += self.xml_item(item, macro.scope, ())
        except Unsupported:
            return False
        if not any(isinstance(one, (Xml, Call)) for one in found) or any(
            isinstance(one, Xml) and not one.tag for one in found
        ):
            return False
        macro.text = found
        self.seen.append(macro)
        return True

    def not_a_value(self, macro: Macro) -> bool:
        macro.entry = None
        return False

    def value_call(self, macro: Macro, element: Element, scope: Scope) -> Call:
        given = self.given(macro, element, scope)
        made = Call(macro, given, {}, scope, element)
        for name, (block, inner) in self.blocks(macro, element, scope).items():
            if name in macro.block_levels:
                made.blocks[name] = self.block_entry(macro, name, block, inner)
        self.hand_over(macro, given)
        return made

    # What is kept as text.

    def xml(self, element: Element, scope: Scope) -> Xml:
        """Return an element that is kept as text."""
        made = Xml(element.tag, element=element)
        for name, attribute in element.attributes.items():
            if not name.startswith(("xacro:", "xmlns:xacro")):
                value = Value(attribute.value, scope, XML, attribute.span)
                note(value)
                made.attributes.append((name, value))
        for item in element.content:
            made.content += self.xml_item(item, scope.latest(), ())
        return made

    def xml_item(self, item: Element | Remark, scope: Scope, when: Whens) -> list[Any]:
        if isinstance(item, Remark):
            if item.is_comment:
                return [item]
            value = Value(item.text, scope, XML)
            note(value)
            return [value]
        if item.tag in ("xacro:if", "xacro:unless"):
            group = Xml("", when=(self.condition(item, scope),))
            if decided(group.when[0]) is False:
                return []
            for inner in item.content:
                group.content += self.xml_item(inner, scope.latest(), when)
            return [group]
        if item.tag == "xacro:insert_block":
            return [self.xml(child, inner) for child, inner in self.inserted(item, scope)]
        if item.tag == "xacro:property":
            self.inner_property(item, scope, when)
            return []
        if item.tag == "xacro:macro":
            self.define(self.program.by_element[id(item)], item.get("name").removeprefix("xacro:"), when)
            return []
        if self.is_open(item):
            groups = [Xml("", when=on, content=self.xml_item(item, scope, when)) for on in self.targets(item, scope)]
            return [one for group in groups for one in ([group] if group.when else group.content)]
        if item.tag.startswith("xacro:"):
            return self.xml_call(item, scope, when)
        return [self.xml(item, scope)]

    def xml_call(self, item: Element, scope: Scope, when: Whens) -> list[Any]:
        """Return what a macro that is called within XML gives."""
        macro = self.macro_of(item)
        if returns(self, macro, scope, when):
            set_by(self, macro, item, scope, when, body_around(scope))
            return []
        if macro.name not in self.inlined and self.as_text(macro):
            return [self.value_call(macro, item, scope)]
        found: list[Any] = []

        def take(inside: Scope) -> None:
            for one in macro.element.content:
                found.extend(self.xml_item(one, inside.latest(), when))

        self.write_out(macro, item, scope, take)
        return found


def _plain(piece: Token) -> Token:
    """Return a piece of a text; an argument that is read as an expression as what it is."""
    whole = tokens(piece.text) if piece.kind == EXPRESSION and is_argument(piece.text) else []
    return whole[0] if len(whole) == 1 else piece

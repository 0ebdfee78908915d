"""Among links and joints: what the top of a file or a macro makes of a robot.

A macro that makes links, joints and elements of a robot is a part.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from rosorin_compile.source.xml.markup import Element

from .contexts import Comments, Context
from .entries import joint_entry, link_entry, material_entry
from .fixing import value_of
from .flattened import flat_entries, place_of
from .keeping import xml_of
from .naming import expanded, variables_in
from .pieces import Body, Listed, Macro, Named, Use
from .problems import AtTop, InMacro
from .program import Fixed, comments_within, with_comments
from .scopes import ARGUMENT, FREE, NAME, Scope, Value, is_argument, note
from .setting import constant
from .texts import EXPRESSION, Token, Unsupported, tokens

if TYPE_CHECKING:
    from .walking import Walker


@dataclass(frozen=True, eq=False)
class Among(Context):
    """Among the links and joints of a body; ``top``: at the top of a file."""

    of: Body
    top: bool = False

    def inner(self) -> Among:
        """Return the place of what a block or a macro puts here."""
        return replace(self, top=False)

    def each(self, element: Element, scope: Scope, above: Comments = ()) -> None:
        """Take what an element holds; what is said above it is said of the first of these."""
        for child, comments in with_comments(element):
            self.one(child, scope.latest(), (*above, *comments))
            above = ()

    def one(self, child: Element, scope: Scope, comments: Comments) -> None:
        """Take one element; what cannot be said of one at the top of a file is told as ``AtTop``."""
        walker = self.walker
        if walker.passes_over(child):
            return
        if not self.top or child.tag in ("xacro:if", "xacro:unless", "xacro:include"):
            try:
                walker.take(child, scope, comments, self)
            except Unsupported as problem:
                if problem.element is None and not child.tag.startswith("xacro:"):
                    problem.element = child
                raise
            return
        if place_of(child.span) in walker.flat:
            self.of.flat += flat_entries(walker.trees, place_of(child.span), self.when, comments)
            for condition in self.when:
                note(condition.value)
            return
        walker.at = child
        try:
            walker.take(child, scope, comments, self)
        except Unsupported as problem:
            raise AtTop(child, problem) from None
        finally:
            walker.at = None

    def element(self, child: Element, scope: Scope, comments: Comments) -> None:
        """Take a link, a joint, a material, or what the language has no word for."""
        walker, at = self.walker, self.walker.at or child
        if child.tag in ("link", "joint"):
            self.named(child, scope, comments)
        elif child.tag == "material":
            name = walker.value(child, "name", scope, NAME)
            made = material_entry(walker, child, scope)
            self.of.materials.append(Named(name, made, self.when, comments, child, at))
        else:
            self.of.elements.append(Listed(xml_of(walker, child, scope), self.when, comments, at))

    def named(self, child: Element, scope: Scope, comments: Comments) -> None:
        name = self.walker.value(child, "name", scope, NAME)
        read = link_entry if child.tag == "link" else joint_entry
        comments = (*comments, *comments_within(child))
        made = Named(name, read(self.walker, child, scope), self.when, comments, child, self.walker.at or child)
        (self.of.links if child.tag == "link" else self.of.joints).append(made)

    def property(self, child: Element, scope: Scope, comments: Comments) -> None:
        """Take a property: at the top one that changes, elsewhere one of a macro."""
        if self.top:
            if child.get("name") in self.walker.program.changing:
                self.walker.changing(child, scope, self.when)
            return
        before = len(self.of.locals)
        self.walker.local(child, self.of, scope, self.when)
        for variable in self.of.locals[before:]:
            variable.comments = comments

    def argument(self, child: Element) -> None:
        """Pass over an argument: the program has taken it."""

    def include(self, child: Element, scope: Scope) -> None:
        walker, program = self.walker, self.walker.program
        if id(child) in program.unclear:
            walker.note_properties(self.files_named(child, scope))
        files = program.tops.get(id(child))
        for guard in program.guards.get(id(child), ()) if walker.lifting is None else ():
            for condition in self.when:
                note(condition.value)
            self.of.guards.append((*guard, self.when, child))
        for file, more in files or ():
            for condition in more:
                note(condition.value)
            body, inner = (file.body, file.body.scope) if self.top else (self.of, scope)
            Among(walker, (*self.when, *more), body, top=True).each(file.document.root, inner)

    def files_named(self, element: Element, scope: Scope) -> list[str]:
        """Take down the files that a macro includes; return the properties that are new.

        Raises Fixed where an argument has a say in the name, but not as a piece of it.
        """
        program = self.walker.program
        value = Value(element.get("filename"), scope, FREE, element.span)
        text = constant(value)
        if isinstance(text, str):
            return program.add(text, element)
        pieces = [_plain(piece) for piece, _ in expanded(value.text, scope)]
        if all(piece.kind != EXPRESSION for piece in pieces):
            return program.add_chosen(pieces, element, program.file_of(element) or self.of.file)
        for variable in variables_in(value):
            name = variable.name if variable.where == ARGUMENT else ""
            said = value_of(program, name) if name else None
            if said is not None:
                raise Fixed(name, said, element)
        raise program.unclear[id(element)]

    def block(self, child: Element, scope: Scope, comments: Comments) -> None:  # noqa: ARG002
        for inserted, where in self.walker.inserted(child, scope):
            self.inner().one(inserted, where, ())

    def write_out(self, macro: Macro, child: Element, scope: Scope) -> None:
        self.walker.write_out(macro, child, scope, partial(self.inner().each, macro.element))

    def call(self, macro: Macro, child: Element, scope: Scope, comments: Comments) -> bool:
        """Take the use of a part; what is lifted is taken out of all parts."""
        walker = self.walker
        if walker.lifting is not None:
            return False
        _as_part(walker, macro)
        use = Use(macro, walker.given(macro, child, scope), {}, scope, self.when, comments, child, walker.at or child)
        for name, (block, inner) in walker.blocks(macro, child, scope).items():
            use.blocks[name] = walker.block_entry(macro, name, block, inner)
        walker.hand_over(macro, use.given)
        macro.uses.append(use)
        self.of.uses.append(use)
        walker.set_by_part(macro, use.given, scope, self.when)
        return True

    def body(self, scope: Scope) -> Body:  # noqa: ARG002
        return self.of


def _as_part(walker: Walker, macro: Macro) -> None:
    """Walk over a macro that is to be a part, once. Raises Unsupported, InMacro if it can be none."""
    if macro.level == "part":
        return
    if macro.level:
        raise Unsupported(f'the macro "{macro.name}" is called in a link and outside of links', macro.place)
    walker.begin(macro, "part")
    macro.body = Body(macro.file, macro, macro.scope)
    walker.seen.append(macro)
    try:
        Among(walker, (), macro.body).each(macro.element, macro.scope)
    except Unsupported as problem:
        raise InMacro(macro, problem) from None


def _plain(piece: Token) -> Token:
    """Return a piece of a text; an argument that is read as an expression as what it is."""
    whole = tokens(piece.text) if piece.kind == EXPRESSION and is_argument(piece.text) else []
    return whole[0] if len(whole) == 1 else piece


__all__ = ["Among"]

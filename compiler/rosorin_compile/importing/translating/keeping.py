"""Keeping: what stands in XML that is kept as text."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.xml.markup import Element, Remark

from .contexts import Comments, Context
from .pieces import Call, Macro, Whens, Xml
from .scopes import XML, Scope, Value, note
from .texts import Unsupported

if TYPE_CHECKING:
    from .walking import Walker


@dataclass(frozen=True, eq=False)
class Keeping(Context):
    """In an element that is kept; ``content`` is what stands there. Its conditions are those of the groups in it."""

    content: list[Any]

    def under(self, on: Whens) -> Keeping:
        if not on:
            return self
        group = Xml("", when=on)
        self.content.append(group)
        return replace(self, content=group.content)

    def each(self, element: Element, scope: Scope, above: Comments = ()) -> None:  # noqa: ARG002
        """Take what an element holds: texts and comments, too."""
        for item in element.content:
            if isinstance(item, Element):
                self.walker.take(item, scope.latest(), (), self)
            else:
                self.remark(item, scope.latest())

    def remark(self, item: Remark, scope: Scope) -> None:
        """Take a text or a comment."""
        if item.is_comment:
            self.content.append(item)
            return
        value = Value(item.text, scope, XML)
        note(value)
        self.content.append(value)

    def element(self, child: Element, scope: Scope, comments: Comments) -> None:  # noqa: ARG002
        made = Xml(child.tag, element=child)
        for name, attribute in child.attributes.items():
            if not name.startswith(("xacro:", "xmlns:xacro")):
                value = Value(attribute.value, scope, XML, attribute.span)
                note(value)
                made.attributes.append((name, value))
        replace(self, content=made.content).each(child, scope)
        self.content.append(made)

    def block(self, child: Element, scope: Scope, comments: Comments) -> None:
        for inserted, where in self.walker.inserted(child, scope):
            self.element(inserted, where, comments)

    def call(self, macro: Macro, child: Element, scope: Scope, comments: Comments) -> bool:  # noqa: ARG002
        """Take the call of a macro that is a named value of XML."""
        if not _as_text(self.walker, macro):
            return False
        self.content.append(self.walker.value_call(macro, child, scope))
        return True


def xml_of(walker: Walker, element: Element, scope: Scope) -> Xml:
    """Return an element that is kept as text."""
    content: list[Xml] = []
    Keeping(walker, (), content).element(element, scope, ())
    return content[0]


def _as_text(walker: Walker, macro: Macro) -> bool:
    """Walk over a macro that is called among elements that are kept; say whether it can be a value."""
    if macro.level:
        return macro.level == "xml" and macro.text is not None
    walker.begin(macro, "xml")
    if any(parameter.block for parameter in macro.parameters):
        return False
    here = Keeping(walker, (), [])
    try:
        for item in macro.element.content:
            if isinstance(item, Element):
                walker.take(item, macro.scope, (), here)
            else:
                here.remark(item, macro.scope)
    except Unsupported:
        return False
    if not any(isinstance(one, (Xml, Call)) for one in here.content) or any(
        isinstance(one, Xml) and not one.tag for one in here.content
    ):
        return False
    macro.text = here.content
    walker.seen.append(macro)
    return True


__all__ = ["Keeping", "xml_of"]

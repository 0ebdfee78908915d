"""Inside: what stands in a link, in a joint, or in an element of one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from rosorin_compile.source.xml.markup import Element

from .contexts import Comments, Context
from .pieces import Call, Handed, Macro, Whens
from .program import with_comments
from .scopes import Scope
from .texts import Parameter

# An element, the call of a macro that is a named value, or a block; its scope, and the conditions and comments on it.
Found = tuple[Element | Call | Handed, Scope, Whens, Comments]


@dataclass(frozen=True, eq=False)
class Inside(Context):
    """In an element of a level, such as ``link`` or ``geometry``; ``found`` is told what stands there, in its order."""

    level: str
    found: Callable[[Found], None]

    def each(self, element: Element, scope: Scope, above: Comments = ()) -> None:  # noqa: ARG002
        """Take what an element holds; comments above a condition are those of the whole link or joint."""
        for child, comments in with_comments(element):
            self.walker.take(child, scope.latest(), comments, self)

    def element(self, child: Element, scope: Scope, comments: Comments) -> None:
        self.found((child, scope, self.when, comments))

    def block(self, child: Element, scope: Scope, comments: Comments) -> None:
        handed = scope.block(child.get("name"))
        if isinstance(handed, Parameter):
            self.found((Handed(handed, scope), scope, self.when, comments))
            return
        for inserted, where in self.walker.inserted(child, scope):
            self.walker.take(inserted, where, (), self)

    def call(self, macro: Macro, child: Element, scope: Scope, comments: Comments) -> bool:
        """Take the call of a macro that is a named value of this level."""
        if not self.walker.as_value(macro, self.level):
            return False
        self.found((self.walker.value_call(macro, child, scope), scope, self.when, comments))
        return True

    def write_out(self, macro: Macro, child: Element, scope: Scope) -> None:
        """Take what a macro holds, once all of it is known: with what it sets, too."""
        made: list[Found] = []
        self.walker.write_out(macro, child, scope, partial(replace(self, found=made.append).each, macro.element))
        for one in made:
            self.found(one)


__all__ = ["Found", "Inside"]

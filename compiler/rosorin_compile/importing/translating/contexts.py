"""Contexts: the places where elements of a xacro stand, and what is made of each there.

What an element is to xacro, ``Walker.take`` says, wherever it stands. There are three places: among links and joints
(``among``), within one of them (``inside``), and in XML that is kept as text (``keeping``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from rosorin_compile.source.xml.markup import Element

from .calling import no_macro
from .pieces import Body, Macro, Whens
from .returning import body_around
from .scopes import Scope

if TYPE_CHECKING:
    from .walking import Walker

Comments = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Context:
    """A place, under the conditions of ``when``."""

    walker: Walker
    when: Whens

    def under(self, on: Whens) -> Context:
        """Return the same place under more conditions."""
        return replace(self, when=(*self.when, *on))

    def each(self, element: Element, scope: Scope, above: Comments = ()) -> None:
        """Take what an element holds, one after the other; ``above`` are the comments above the element."""
        raise NotImplementedError

    def element(self, child: Element, scope: Scope, comments: Comments) -> None:
        """Take an element that is none of xacro's."""
        raise NotImplementedError

    def property(self, child: Element, scope: Scope, comments: Comments) -> None:  # noqa: ARG002
        """Take a property that is set here."""
        self.walker.inner_property(child, scope, self.when)

    def include(self, child: Element, scope: Scope) -> None:  # noqa: ARG002
        """Take what is included. Raises Unsupported where nothing is."""
        raise no_macro("include", child)

    def argument(self, child: Element) -> None:
        """Take the declaration of an argument. Raises Unsupported where none is declared."""
        raise no_macro("arg", child)

    def block(self, child: Element, scope: Scope, comments: Comments) -> None:
        """Take a block that is inserted."""
        raise NotImplementedError

    def call(self, macro: Macro, child: Element, scope: Scope, comments: Comments) -> bool:
        """Take the call of a macro that is said once, as a part or a named value; say whether it can be."""
        raise NotImplementedError

    def write_out(self, macro: Macro, child: Element, scope: Scope) -> None:
        """Take what a macro holds that is called here."""
        self.walker.write_out(macro, child, scope, partial(self.each, macro.element))

    def body(self, scope: Scope) -> Body | None:
        """Return the body that named values of a scope stand in here."""
        return body_around(scope)

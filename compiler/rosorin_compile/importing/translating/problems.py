"""Problems: what stops an attempt to translate, with what it stands in: the next attempt does without that."""

from __future__ import annotations

from rosorin_compile.source.xml.markup import Element

from .pieces import Macro
from .texts import Unsupported


class AtTop(Exception):
    """Something at the top of a file that is not translated."""

    def __init__(self, element: Element, problem: Unsupported) -> None:
        super().__init__(problem.reason)
        self.element = element
        self.problem = problem


class InProperty(Exception):
    """A property at the top of a file whose value cannot be said."""

    def __init__(self, name: str, reason: str) -> None:
        super().__init__(reason)
        self.name = name
        self.reason = reason


class InMacro(Exception):
    """Something in a macro that is not translated."""

    def __init__(self, macro: Macro, problem: Unsupported) -> None:
        super().__init__(problem.reason)
        self.macro = macro
        self.problem = problem

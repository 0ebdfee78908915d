"""Regular expressions that are compiled when they are first used; most of a module's are not in most runs.

Compiling all of them was a tenth of a short run. Those of PyYAML were another part: the one for letters that YAML does
not allow takes as long as all of ours, and libyaml, which reads our files, has no use for it. A type checker sees the
library's.
"""

from __future__ import annotations

import re
from _thread import get_ident
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

_compile = re.compile
if TYPE_CHECKING:
    from collections.abc import Iterator
    from re import compile  # noqa: A004 - the name that the library has for it


class _Pattern:
    """A pattern that is compiled when something is asked of it."""

    def __init__(self, pattern: str, flags: int = 0) -> None:
        self._said = (pattern, flags)

    def __getattr__(self, name: str) -> Any:
        made = _compile(*self._said)
        vars(self).update({one: getattr(made, one) for one in dir(made) if not one.startswith("_")})
        return getattr(made, name)


if not TYPE_CHECKING:
    compile = _Pattern  # noqa: A001


@contextmanager
def compiled_later() -> Iterator[None]:
    """Let what this thread imports meanwhile have its patterns compiled when they are first used; no other thread."""
    before, here = re.compile, get_ident()

    def later(pattern: str, flags: int = 0) -> Any:
        return compile(pattern, flags) if get_ident() == here else before(pattern, flags)

    re.compile = later  # type: ignore[assignment]
    try:
        yield
    finally:
        re.compile = before


__all__ = ["compile", "compiled_later"]

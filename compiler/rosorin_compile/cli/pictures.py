"""The page that shows what changed in robots, for ``check`` and ``diff``; the package that shows robots draws it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from .registry import service

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping, Sequence

    from rosorin_compile.compare.committed import Comparison
    from rosorin_compile.compare.difference import Difference
    from rosorin_compile.output.pipeline import Compiled
    from rosorin_compile.source.console import Console
    from rosorin_compile.source.project import Description

    from .given import Given

PICTURES = "pictures of changes"


class Pictures(Protocol):
    """The robots of one page, as they come."""

    def take(
        self,
        given: Given,
        description: Description,
        compiled: Compiled,
        comparison: Comparison,
        committed: Mapping[str, bytes],
        meshes: Sequence[tuple[str, str]],
    ) -> None:
        """Take what changed in one robot since its artifacts were committed; ``meshes`` are those that differ."""

    def take_sides(
        self,
        given: Sequence[tuple[Given, Description]],
        found: Difference,
        prefix: str | None,
    ) -> None:
        """Take what is different in two robots; ``prefix`` is what the names of the second one begin with."""

    def clear(self) -> None:
        """Forget the robots that were taken."""

    def write(self, console: Console) -> None:
        """Write the page. Raises WrongUsage if it cannot be written."""


def pictures(options: argparse.Namespace) -> Pictures:
    """Return the page that the options of ``page_options`` ask for."""
    page: Pictures = service(PICTURES)(options)
    return page

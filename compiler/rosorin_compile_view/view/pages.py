"""The page of a robot for other packages, which show something of their own beside it: a service."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from rosorin_compile.diagnostics import Console
from rosorin_compile.extending import Description, Given

from ..page import MAX_MEGABYTES, Embedding, html, left_out
from .showing import Shown, look, on_disk


class Page:
    """A page that stands alone: the ``data`` of its robot, and the files that it was made of.

    ``left`` says which meshes it has no room for; empty if it has all, or is to have none.
    """

    def __init__(self, shown: Shown, embedding: Embedding | None) -> None:
        self.data = on_disk(shown, embedding)
        self.files: list[Path] = [*shown.files, *shown.meshes.values()]
        self.left = left_out(embedding.left) if embedding is not None and embedding.left else ""

    def html(self, **beside: Any) -> str:
        """Return its text; ``beside`` is what the viewer shows beside the robot, by its words for that."""
        return html({"robot": self.data, **beside})


def page_of(given: Given, description: Description, options: argparse.Namespace) -> Page | None:
    """Return the page of a robot in any format, with as many meshes as options allow; None for one with errors.

    Raises LoadError for a file of arguments that is no good.
    """
    shown = look(given, description, Console("json")).shown
    if shown is None:
        return None
    limit = MAX_MEGABYTES if options.max_megabytes is None else options.max_megabytes
    return Page(shown, None if options.no_meshes else Embedding(int(limit * 1_000_000)))

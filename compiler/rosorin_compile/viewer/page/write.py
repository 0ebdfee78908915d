"""Write the page of a robot to one HTML file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from rosorin_compile.output import OutputError, write_file
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, RequestError
from rosorin_compile.viewer.showing import look, on_disk

from . import MAX_MEGABYTES, Embedding, html, left_out


@dataclass(frozen=True)
class Page:
    """A page of a robot that was written, with its size in ``bytes``. Without ``written`` there are errors.

    ``left_out`` names the meshes and images that it does not show, and why.
    """

    robot: str
    file: Path
    bytes: int = 0
    left_out: str = field(default="", repr=False)
    written: bool = field(default=False, repr=False)
    diagnostics: tuple[Diagnostic, ...] = ()


def write_page(request: Request, file: Path, meshes: bool = True, max_megabytes: float | None = None) -> Page:
    """Write the page of a robot to a file. Raises RequestError."""
    limit = MAX_MEGABYTES if max_megabytes is None else max_megabytes
    if not limit >= 0:
        raise RequestError("--max-megabytes wants a number from 0 on")
    name, looked = request.description.name, look(request)
    if looked.shown is None:
        errors = tuple(one for one in looked.diagnostics if one.severity == ERROR)
        return Page(name, file, diagnostics=errors)
    embedding = Embedding(int(limit * 1_000_000))
    text = html({"robot": on_disk(looked.shown, embedding if meshes else None)}).encode()
    try:
        write_file(file, text, looked.files)
    except OutputError as problem:
        return Page(name, file, diagnostics=(problem.diagnostic,))
    return Page(name, file, len(text), left_out(embedding.left) if embedding.left else "", True)

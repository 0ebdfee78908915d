"""Convert a robot to the data of an HTML page (model, meshes, sources of all numbers), and write the page to a file."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.mesh_files import MESH, TEXTURE, Places, named_files
from rosorin_compile.language.explain import explain, lines
from rosorin_compile.output.atomic_files import OutputError, write_file
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, RequestError, Span, UnknownName, printable
from rosorin_compile.source.progress import Progress

from .page import html, left_out
from .page.data import robot_data
from .page.images import Data, EmbeddedFiles, companions, tables

if TYPE_CHECKING:
    from rosorin_compile.formats.compilation import LoadedRobot
    from rosorin_compile.model import Robot
    from rosorin_compile.rules.case import Case

_EXPLAINED = 300  # if a robot has more links, the page does not show the sources of numbers


@dataclass(frozen=True)
class RobotView:
    """A robot for an HTML page: its JSON data, mesh and image files by name, and the files of its description."""

    case: Case
    data: Data
    meshes: Mapping[str, Path]
    files: tuple[Path, ...]
    understood: LoadedRobot
    arguments: Mapping[str, Any]

    @property
    def robot(self) -> Robot:
        """The model of the robot."""
        return self.case.robot

    def explain(self, frame: str) -> list[str]:
        """Return the lines that ``explain`` prints for a frame, or [] if the robot has no description."""
        expanded, lowered = self.understood.expanded, self.understood.lowered
        if expanded.scope is None or lowered is None:
            return []
        with suppress(UnknownName):
            return [line for answer in explain(expanded, lowered, self.arguments, [frame]) for line in lines(answer)]
        return []


def load(request: Request) -> tuple[RobotView | None, list[Diagnostic], tuple[Path, ...]]:
    """Read a robot in any format; return (view or None after errors, diagnostics, files that were read)."""
    understood, description = request.understand(), request.description
    case, own_files, diagnostics = understood.case, understood.expanded.files, understood.diagnostics
    if case is None:
        return None, diagnostics, own_files
    places = Places(description.path, description.outputs, request.packages, os.environ)
    found = {**places.meshes(case.tree, kind=TEXTURE), **places.meshes(case.tree)}
    data = robot_data(case.robot)
    for link in data["links"]:
        if (path := case.places.get(("link", link["name"]))) is not None:
            link["where"] = _place(case.tree.locate(path, key=True).span)
    for one in (one for one in diagnostics if one.severity == WARNING):
        text = printable(f"{one.message} [{one.rule}]" + (f"\n{one.help}" if one.help else ""), keep="\n")
        data.setdefault("warnings", []).append({"text": text, **({"where": _place(one.span)} if one.span else {})})
    arguments = {} if request.is_foreign else request.values()
    read = [*found.values(), *(side.file for file in found.values() for side in companions(file)[0])]
    missing = (one for one in named_files(case.tree) if one.kind == MESH and one.name not in found)
    awaited = (Path(at.source.path).parent / one.name for one in missing if "://" not in one.name for at in one.spans)
    return RobotView(case, data, found, own_files, understood, arguments), diagnostics, (*own_files, *read, *awaited)


def _place(span: Span) -> Data:
    file = span.source.path
    return {"file": file, "line": span.line, "column": span.column, "path": os.path.abspath(file)}


def on_disk(shown: RobotView, embedding: EmbeddedFiles | None) -> Data:
    """Return JSON data for an HTML file: without absolute paths and, unless ``embedding`` is None, with meshes."""
    data = dict(shown.data)
    if embedding is not None:
        data.update(tables(shown.robot, shown.meshes, embedding))
    table: dict[str, int] = {}  # line numbers, because most lines occur for several links
    links = list(data["links"])
    for number, link in enumerate(links if len(links) <= _EXPLAINED else ()):
        Progress.step("explaining", number, len(links))
        indices = [table.setdefault(line, len(table)) for line in shown.explain(link["name"])]
        links[number] = {**link, **({"said": indices} if indices else {})}
    return nameless({**data, "links": links, **({"lines": list(table)} if table else {})}, shown.files)


def nameless(data: Data, named: Iterable[Path] = ()) -> Data:
    """Replace absolute paths in JSON data with relative paths or file names; ``named`` are further paths to replace."""
    places = [entry["where"]["file"] for entry in (*data["links"], *data.get("warnings", ())) if "where" in entry]
    here, names = Path.cwd(), dict[str, str]()
    for path in map(Path, dict.fromkeys([*places, *map(str, named)])):
        if path.is_absolute():
            names[str(path)] = str(path.relative_to(here)) if path.is_relative_to(here) else path.name
    for file in (*data.get("meshes", ()), *data.get("textures", ())):
        if file.startswith(("/", "file:")) and file not in names:
            short = file.rpartition("/")[2]
            names[file] = short if short not in names.values() else f"{len(names)}/{short}"
    paths = sorted(names, key=len, reverse=True)

    def renamed(value: Any) -> Any:
        if isinstance(value, str):
            for path in paths:
                value = value.replace(path, names[path])
            return value
        if isinstance(value, dict):
            kept = ((key, entry) for key, entry in value.items() if key != "path" or "line" not in value)
            return {renamed(key): entry if key == "data" else renamed(entry) for key, entry in kept}
        return [renamed(entry) for entry in value] if isinstance(value, list) else value

    found: Data = renamed(data)
    return found


@dataclass(frozen=True)
class Page:
    """The result of ``view``: the HTML file and its size in ``bytes``; ``written`` is False after errors.

    ``left_out`` describes the meshes and images that the page does not show, with the reason.
    """

    robot: str
    file: Path
    bytes: int = 0
    left_out: str = field(default="", repr=False)
    written: bool = field(default=False, repr=False)
    diagnostics: tuple[Diagnostic, ...] = ()


def view(
    robot: FilePath | Request,
    output: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    meshes: bool = True,
    max_megabytes: float | None = None,
    trust: bool = False,
) -> Page:
    """Write a self-contained HTML page that shows a robot in a browser, without network access.

    Args:
        meshes: Embed the meshes.
        max_megabytes: The maximum total size of embedded meshes in MB, by default 40.

    Example:
        >>> import rosorin_compile, tempfile
        >>> page = rosorin_compile.view("rosorin", tempfile.mkdtemp() + "/rosorin.html")
        >>> page.robot, page.bytes > 100_000
        ('rosorin', True)
    """
    if max_megabytes is not None and not max_megabytes >= 0:
        raise RequestError("--max-megabytes wants a number from 0 on")
    request, file = Request.from_arguments(robot, arguments, packages, trust=trust), Path(output)
    name, (shown, diagnostics, inputs) = request.description.name, load(request)
    if shown is None:
        return Page(name, file, diagnostics=tuple(one for one in diagnostics if one.severity == ERROR))
    embedding = EmbeddedFiles(max_megabytes)
    text = html({"robot": on_disk(shown, embedding if meshes else None)}).encode()
    try:
        write_file(file, text, inputs)
    except OutputError as problem:
        return Page(name, file, diagnostics=(problem.diagnostic,))
    return Page(name, file, len(text), left_out(embedding.left) if embedding.left else "", True)

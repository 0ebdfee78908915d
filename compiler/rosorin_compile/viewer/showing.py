"""A robot as the data of its page: the model, where each frame is said, and its meshes."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.formats.mesh_files import TEXTURE, Places
from rosorin_compile.language.explain import NotThere, explain
from rosorin_compile.language.explain_text import lines
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, printable
from rosorin_compile.source.progress import Progress

from .page import MESHES, Embedding
from .page.data import Data, mesh_names, robot_data, texture_names
from .page.images import Side, companion_files, image_type

if TYPE_CHECKING:
    from rosorin_compile.model import Robot
    from rosorin_compile.request import Request
    from rosorin_compile.rules.case import Case

_BYTES = "application/octet-stream"
_NO_IMAGE = "not found, or no image that browsers read"
_TABLES = ("meshes", "textures")
_PURPOSES = ("visual", "collision")
_EXPLAINED = 300  # links; of more than that a page on disk does not say where each number comes from


class Shown(NamedTuple):
    """A robot to look at: its data for the page, its mesh and image files by name, and the files that say it.

    ``case`` has the places of all that it says, for checks. ``explained`` returns where the numbers of a frame come
    from, as ``explain`` says it; nothing of a foreign robot.
    """

    case: Case
    data: Data
    meshes: Mapping[str, Path]
    images: Mapping[str, Path]
    files: tuple[Path, ...]
    explained: Callable[[str], list[str]]

    @property
    def robot(self) -> Robot:
        """The model."""
        return self.case.robot


class Looked(NamedTuple):
    """What became of the files: a robot to show, unless it has errors; what there is to say; and what was read."""

    shown: Shown | None
    diagnostics: list[Diagnostic]
    files: tuple[Path, ...]


def look(request: Request) -> Looked:
    """Read a robot, in any format, for its page."""
    understood, description = request.understand(), request.description
    case, said_in, diagnostics = understood.case, understood.expanded.files, understood.diagnostics
    if case is None:
        return Looked(None, diagnostics, said_in)
    places = Places(description.path, description.outputs, request.packages, os.environ)
    meshes, images = places.meshes(case.tree), places.meshes(case.tree, kind=TEXTURE)
    data = robot_data(case.robot)
    for link in data["links"]:
        where = _where(case, link["name"])
        if where is not None:
            link["where"] = where
    warnings = [_warning(one) for one in diagnostics if one.severity == WARNING]
    if warnings:
        data["warnings"] = warnings
    arguments = {} if request.is_foreign else request.values()

    def explained(frame: str) -> list[str]:
        if understood.expanded.scope is None or understood.lowered is None:
            return []
        with suppress(NotThere):
            answers = explain(understood.expanded, understood.lowered, arguments, [frame])
            return [line for answer in answers for line in lines(answer)]
        return []

    beside_meshes = (side.file for name, file in meshes.items() for side in _sides(name, file))
    found = (*meshes.values(), *images.values(), *beside_meshes, *places.awaited(case.tree, meshes))
    return Looked(Shown(case, data, meshes, images, said_in, explained), diagnostics, (*said_in, *found))


def _sides(name: str, mesh: Path) -> list[Side]:
    """Return the files beside a mesh that belong to it; only an OBJ and a DAE name any."""
    if mesh.suffix.lower() not in (".obj", ".dae"):
        return []
    try:
        return companion_files(mesh, files.read_bytes(mesh), name)[0]
    except OSError:
        return []


def _where(case: Case, link: str) -> Data | None:
    """Return where a frame is said: file, line and column, and the path for an editor."""
    path = case.places.get(("link", link))
    return None if path is None else _placed(case.tree.locate(path, key=True).span)


def _warning(told: Diagnostic) -> Data:
    """Return a warning as the page has it: what it says, and where."""
    text = f"{told.message} [{told.rule}]" + (f"\n{told.help}" if told.help else "")
    return {"text": printable(text, keep="\n"), **({"where": _placed(told.span)} if told.span else {})}


def _placed(span: Span) -> Data:
    """Return a place in a description as the page has it, with the whole path for an editor."""
    return {
        "file": span.source.path,
        "line": span.line,
        "column": span.column,
        "path": os.path.abspath(span.source.path),
    }


def served(shown: Shown, numbers: dict[Path, str]) -> tuple[Data, dict[str, tuple[Path, str]]]:
    """Return meshes and textures of a page, each at a number that is asked for; and files with their types by number.

    ``numbers`` has those of files that were shown before; new ones are added. What follows "?" tells one version of a
    file from the next, so that a page reads again only what has changed.
    """
    files: dict[str, tuple[Path, str]] = {}

    def at(file: Path, kind: str) -> str:
        number = numbers.setdefault(file, str(len(numbers)))
        files[number] = file, kind
        return f"mesh/{number}?{_version(file)}"

    meshes: Data = {}
    for name in mesh_names(shown.robot):
        kind, file = MESHES.get(PurePosixPath(name).suffix.lower()), shown.meshes.get(name)
        if kind is None or file is None:
            meshes[name] = {"missing": "not found" if file is None else "no browser reads it"}
            continue
        sides = {side.name: {"type": side.type, "url": at(side.file, side.type)} for side in _sides(name, file)}
        meshes[name] = {"format": kind, "url": at(file, _BYTES), **({"files": sides} if sides else {})}
    textures: Data = {}
    for name in texture_names(shown.robot):
        image = shown.images.get(name)
        kind = image_type(image) if image is not None else ""
        textures[name] = {"type": kind, "url": at(image, kind)} if image and kind else {"missing": _NO_IMAGE}
    return {"meshes": meshes, **({"textures": textures} if textures else {})}, files


def _version(file: Path) -> str:
    try:
        status = file.stat()
        return "".join(
            f"{number:x}" for number in (status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
        )
    except OSError:
        return "0"


def on_disk(shown: Shown, embedding: Embedding | None) -> Data:
    """Return the data of a page that stands alone, without an absolute path; ``embedding`` takes its meshes, if any."""
    data = dict(shown.data)
    if embedding is not None:
        embedding.take(data, shown.robot, {**shown.images, **shown.meshes})
    named = [*shown.files, *map(Path, (*shown.meshes, *shown.images))]
    files = {str(path): _said(path) for path in named if path.is_absolute()}
    if "warnings" in data:
        told = ({**one, "text": _without(one["text"], files)} for one in data["warnings"])
        data["warnings"] = [{**one, **_sent(one)} for one in told]
    links = []
    for number, link in enumerate(data["links"]):
        Progress.step("explaining", number, len(data["links"]))
        said = shown.explained(link["name"]) if len(data["links"]) <= _EXPLAINED else []
        said = [_without(line, files) for line in said]
        links.append({**link, **_sent(link), **({"said": said} if said else {})})
    return nameless({**data, "links": links})


def _sent(entry: Data) -> Data:
    """Return the place of an entry without what is of this machine."""
    if "where" not in entry:
        return {}
    place = {key: value for key, value in entry["where"].items() if key != "path"}
    return {"where": {**place, "file": _said(Path(place["file"]))}}


def _said(path: Path) -> str:
    """Return how a page that is sent names a file: from here, or by its name alone."""
    if not path.is_absolute():
        return str(path)
    here = Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else path.name


def _without(line: str, files: Mapping[str, str]) -> str:
    for path, name in files.items():
        line = line.replace(path, name)
    return line


def nameless(data: Data) -> Data:
    """Return data in which meshes and images that are named by absolute paths have their names alone."""
    new: dict[str, str] = {}
    for key in _TABLES:
        for name in data.get(key, {}):
            if name.startswith(("/", "file:")):
                short = name.rpartition("/")[2]
                new[name] = short if short not in new.values() else f"{len(new)}/{short}"
    if not new:
        return data
    links = [
        {**link, **{key: [_renamed(one, new) for one in link[key]] for key in _PURPOSES}} for link in data["links"]
    ]
    tables = {key: {new.get(name, name): one for name, one in data[key].items()} for key in _TABLES if key in data}
    return {**data, **tables, "links": links}


def _renamed(shape: Data, new: Mapping[str, str]) -> Data:
    return {**shape, **{key: new.get(shape[key], shape[key]) for key in ("mesh", "texture") if key in shape}}

"""Images of a page: those that materials name, and what stands beside a mesh file: its materials and their images.

A mesh is foreign, and so are the names in it. What it names is shown only if it is what it says to be, an image that a
browser reads, by its first bytes, or the materials of an OBJ, and if it is in the project or the package of the mesh: a
page is sent to others, and the author of a mesh does not choose what else of this machine is in it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from urllib.parse import unquote

from rosorin_compile.source import files
from rosorin_compile.source.project import DESCRIPTIONS

_MAGIC = {
    "image/png": re.compile(rb"\x89PNG\r\n\x1a\n"),
    "image/jpeg": re.compile(rb"\xff\xd8\xff"),
    "image/webp": re.compile(rb"RIFF....WEBP", re.DOTALL),
    "image/gif": re.compile(rb"GIF8[79]a"),
    "image/bmp": re.compile(rb"BM"),
}
_MATERIALS = "text/plain"
_LARGEST = 1_000_000  # bytes of materials
_HEAD = 16
_NO_IMAGE = "not found, or no image that browsers read"
_OUTSIDE = "a mesh names it outside of the project"
_LIBRARY = re.compile(rb"^[ \t]*mtllib[ \t]+([^\r\n]+)", re.MULTILINE)
_MAP = re.compile(r"^[ \t]*map_Kd[ \t]+(.+?)[ \t]*$", re.MULTILINE | re.IGNORECASE)
_OPTION = re.compile(r"-[a-z]+(?:[ \t]+(?:[-+.0-9e]+|on|off))*[ \t]+", re.IGNORECASE)
_IMAGES = re.compile(rb"<library_images\b.*?</library_images>", re.DOTALL)
_IMAGE = re.compile(rb"<init_from>\s*(?:<ref>)?\s*([^<]+?)\s*<")


class Side(NamedTuple):
    """A file beside a mesh: its name there, where it is, and its type."""

    name: str
    file: Path
    type: str


def image_type(file: Path) -> str:
    """Return the type of an image that a browser reads; empty if a file is none."""
    try:
        begins = files.read_bytes(file, _HEAD)
    except OSError:
        return ""
    return next((kind for kind, magic in _MAGIC.items() if magic.match(begins)), "")


def companion_files(mesh: Path, content: bytes, name: str = "") -> tuple[list[Side], dict[str, str]]:
    """Return the files that belong to a mesh, and the images that it names in vain, with the reason.

    ``name`` is that of the mesh in the description; without one, what belongs to it is in its own folder.
    """
    kind, homes = mesh.suffix.lower(), _homes(mesh, name)
    if kind == ".dae":
        library = _IMAGES.search(content)
        found = _IMAGE.findall(library[0]) if library else []
        return _images(mesh, [unquote(name.decode("utf-8", "replace")) for name in found], homes)
    if kind != ".obj":
        return [], {}
    sides: list[Side] = []
    names: list[str] = []
    for side, text in _libraries(mesh, content):
        if _is_in(side.file, homes):
            sides.append(side)
            names += [_OPTION.sub("", name) for name in _MAP.findall(text)]
    images, vain = _images(mesh, names, homes)
    return [*sides, *images], vain


def _homes(mesh: Path, name: str) -> list[Path]:
    """Return the folders that files of a mesh may be in: its project, or the package that it is in.

    Without either the folder from which the description names it. Where the mesh is a link, also those of the file.
    """
    scheme, mark, rest = name.partition("://")
    parts = [part for part in PurePosixPath(rest if mark else scheme).parts if part not in ("/", "..")]
    parts = parts[1:] if mark and scheme != "file" else parts
    found = []
    for file in dict.fromkeys((files.resolve(mesh.parent) / mesh.name, files.resolve(mesh))):
        named_so = parts and name[:1] != "/" and scheme != "file" and list(file.parts[-len(parts) :]) == parts
        home = file.parents[len(parts) - 1] if named_so else file.parent
        above = (home, *home.parents)
        project = next((one.parent for one in above if one.name == DESCRIPTIONS), None)
        package = next((one for one in above if files.is_file(one / "package.xml")), None)
        found.append(project or package or home)
    return found


def _is_in(file: Path, homes: list[Path]) -> bool:
    """Say whether a file is in one of some folders, links followed."""
    try:
        led = files.resolve(file)
    except (OSError, RuntimeError, ValueError):
        return False
    return any(led.is_relative_to(home) for home in homes)


def _libraries(mesh: Path, content: bytes) -> Iterator[tuple[Side, str]]:
    """Yield the files of materials of an OBJ that stand beside it, with their texts."""
    named = [name.decode("utf-8", "replace").strip() for name in _LIBRARY.findall(content)]
    for name in dict.fromkeys(named):
        file = _at(mesh, name)
        try:
            if (
                file is None
                or file.suffix.lower() != ".mtl"
                or not files.is_file(file)
                or file.stat().st_size > _LARGEST
            ):
                continue
            yield Side(name, file, _MATERIALS), files.read_bytes(file).decode("utf-8", "replace")
        except (OSError, ValueError):
            continue


def _images(mesh: Path, names: list[str], homes: list[Path]) -> tuple[list[Side], dict[str, str]]:
    sides: list[Side] = []
    vain: dict[str, str] = {}
    for name in dict.fromkeys(names):
        file = _at(mesh, name)
        kind = image_type(file) if file is not None else ""
        if file is not None and kind and _is_in(file, homes):
            sides.append(Side(name, file, kind))
        else:
            vain[PurePosixPath(name.replace("\\", "/")).name] = _OUTSIDE if kind else _NO_IMAGE
    return sides, vain


def _at(mesh: Path, name: str) -> Path | None:
    """Return where a name in a mesh leads to; None for one that is not relative."""
    if not name or name.startswith("/") or "://" in name or "\0" in name:
        return None
    return mesh.parent / name.replace("\\", "/")

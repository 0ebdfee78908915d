"""Add meshes and images to an HTML page, with the files that a mesh refers to (materials and their images).

A mesh may be untrusted, and a page is shared with others, so a mesh must not be able to add arbitrary files of this
machine to the page. A file that a mesh refers to must be in the project or ROS package of the mesh, and must be the
material file of an OBJ, or an image that browsers support, according to its first bytes.
"""

import re
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple
from urllib.parse import unquote

from rosorin_compile.model import Mesh, Robot
from rosorin_compile.source import files
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import DESCRIPTIONS

Data = dict[str, Any]

# Mesh formats that the page can load, by file extension.
MESHES: Mapping[str, str] = {".stl": "stl", ".obj": "obj", ".dae": "dae", ".glb": "glb"}
_BYTES, _MATERIALS = "application/octet-stream", "text/plain"
_MAGIC = {
    "image/png": re.compile(rb"\x89PNG\r\n\x1a\n"),
    "image/jpeg": re.compile(rb"\xff\xd8\xff"),
    "image/webp": re.compile(rb"RIFF....WEBP", re.DOTALL),
    "image/gif": re.compile(rb"GIF8[79]a"),
    "image/bmp": re.compile(rb"BM"),
}
_HEAD = 16  # number of bytes that identify the type of an image
_LARGEST = 1_000_000  # maximum size of a material file in bytes
MAX_MEGABYTES = 40  # default maximum size of all meshes and images of a page
_LIBRARY = re.compile(rb"^[ \t]*mtllib[ \t]+([^\r\n]+)", re.MULTILINE)
_MAP = re.compile(r"^[ \t]*map_Kd[ \t]+(.+?)[ \t]*$", re.MULTILINE | re.IGNORECASE)
_OPTION = re.compile(r"-[a-z]+(?:[ \t]+(?:[-+.0-9e]+|on|off))*[ \t]+", re.IGNORECASE)
_IMAGES = re.compile(rb"<library_images\b.*?</library_images>", re.DOTALL)
_IMAGE = re.compile(rb"<init_from>\s*(?:<ref>)?\s*([^<]+?)\s*<")


class ReferencedFile(NamedTuple):
    """A file that a mesh refers to: its name in the mesh, its path, and its MIME type."""

    name: str
    file: Path
    type: str


class EmbeddedFiles:
    """Embeds meshes and images in an HTML page, up to a total size; ``left`` maps omitted files to reasons.

    A file that several robots on a page use is embedded and counted once for each robot.
    """

    def __init__(self, megabytes: float | None) -> None:
        self.limit = int((MAX_MEGABYTES if megabytes is None else megabytes) * 1_000_000)
        self.size = 0
        self.left: dict[str, str] = {}

    def put(self, name: str, file: Path, kind: str) -> Data:  # noqa: ARG002
        """Return JSON data with the base64 content of a file, or with a reason if it is too large or unreadable."""
        try:
            content = files.read_bytes(file)
        except OSError as problem:
            return self.put_missing(name, problem.strerror or "it cannot be read")
        if self.size + len(content) > self.limit:
            return self.put_missing(name, f"more than {self.limit / 1e6:g} MB of meshes")
        self.size += len(content)
        return {"data": b64encode(content).decode("ascii")}

    def put_missing(self, name: str, why: str) -> Data:
        """Return JSON data for a missing file, and record the reason."""
        self.left[name] = why
        return {"missing": why}


class ServedFiles:
    """Serves meshes and images at numbered URLs.

    ``numbers`` maps files to numbers; it keeps earlier files, so that an older page can still load its files. The query
    string of a URL is the version of the file, so that a page only reloads changed files.
    """

    def __init__(self, numbers: dict[Path, str]) -> None:
        self.numbers = numbers
        self.files: dict[str, tuple[Path, str]] = {}

    def put(self, name: str, file: Path, kind: str) -> Data:  # noqa: ARG002
        """Return JSON data with the URL of a file, and serve the file at that URL."""
        number = self.numbers.setdefault(file, str(len(self.numbers)))
        self.files[number] = file, kind
        return {"url": f"mesh/{number}?{''.join(f'{part:x}' for part in files.version(file) or (0,))}"}

    def put_missing(self, name: str, why: str) -> Data:  # noqa: ARG002
        """Return JSON data for a missing file."""
        return {"missing": why}


def tables(robot: Robot, found: Mapping[str, Path], store: EmbeddedFiles | ServedFiles) -> Data:
    """Return JSON data of the meshes and textures of a robot; ``found`` maps names in the description to files."""
    meshes, textures = mesh_table([*mesh_names(robot)], found, store), Data()
    for name in texture_names(robot):
        image = found.get(name)
        if image is not None and (kind := image_type(image)):
            entry = store.put(name, image, kind)
            textures[name] = entry if "missing" in entry else {"type": kind, **entry}
        else:
            textures[name] = store.put_missing(name, "no browser reads it" if image else "not found")
    return {"meshes": meshes, **({"textures": textures} if textures else {})}


def mesh_table(names: Sequence[str], found: Mapping[str, Path], store: EmbeddedFiles | ServedFiles) -> Data:
    """Return JSON data of meshes; ``found`` maps names in the description to files."""
    meshes = Data()
    for number, name in enumerate(names):
        Progress.step("reading meshes", number, len(names))
        kind, file = MESHES.get(PurePosixPath(name).suffix.lower()), found.get(name)
        if kind is None or file is None:
            meshes[name] = store.put_missing(name, "not found" if file is None else "no browser reads it")
            continue
        meshes[name] = entry = store.put(name, file, _BYTES)
        if "missing" in entry:
            continue
        sides, vain = companions(file)
        for image, why in vain.items():
            store.put_missing(image, why)
        own = {side.name: {"type": side.type, **store.put(*side)} for side in sides}
        own = {side: placed for side, placed in own.items() if "missing" not in placed}
        meshes[name] = {"format": kind, **entry, **({"files": own} if own else {})}
    return meshes


def texture_names(robot: Robot) -> Iterator[str]:
    """Yield the file names of the textures of visuals, without duplicates, in the order of the description."""
    visuals = (shape for link in robot.links for shape in link.visual)
    yield from dict.fromkeys(name for shape in visuals if (name := robot.texture(shape)))


def mesh_names(robot: Robot) -> Iterator[str]:
    """Yield the file names of the meshes of a robot, without duplicates, in the order of the description."""
    shapes = (shape for link in robot.links for shape in (*link.visual, *link.collision))
    yield from dict.fromkeys(shape.geometry.file for shape in shapes if isinstance(shape.geometry, Mesh))


def image_type(file: Path) -> str:
    """Return the MIME type of an image that browsers support, or "" for any other file."""
    with suppress(OSError):
        head = files.read_bytes(file, _HEAD)
        return next((kind for kind, magic in _MAGIC.items() if magic.match(head)), "")
    return ""


def companions(mesh: Path) -> tuple[list[ReferencedFile], dict[str, str]]:
    """Return the files that a mesh refers to, and a mapping from the names of unusable images to reasons."""
    try:
        content = files.read_bytes(mesh) if mesh.suffix.lower() in (".dae", ".obj") else b""
    except OSError:
        return [], {}
    homes, sides, vain, names = _homes(mesh), list[ReferencedFile](), dict[str, str](), list[str]()
    if mesh.suffix.lower() == ".dae":
        library = _IMAGES.search(content)
        names = [unquote(found.decode("utf-8", "replace")) for found in _IMAGE.findall(library[0] if library else b"")]
        content = b""
    for named in dict.fromkeys(found.decode("utf-8", "replace").strip() for found in _LIBRARY.findall(content)):
        file = _relative(mesh, named)
        with suppress(OSError):
            if file and file.suffix.lower() == ".mtl" and _is_in(file, homes) and file.stat().st_size <= _LARGEST:
                text = files.read_bytes(file).decode("utf-8", "replace")
                sides.append(ReferencedFile(named, file, _MATERIALS))
                names += [_OPTION.sub("", image) for image in _MAP.findall(text)]
    for named in dict.fromkeys(names):
        file = _relative(mesh, named)
        kind = image_type(file) if file is not None else ""
        if file is not None and kind and _is_in(file, homes):
            sides.append(ReferencedFile(named, file, kind))
        else:
            why = "a mesh names it outside of the project" if kind else "not found, or no image that browsers read"
            vain[PurePosixPath(named.replace("\\", "/")).name] = why
    return sides, vain


def _homes(mesh: Path) -> list[Path]:
    """Return the folders that may contain files of a mesh: one for the mesh and, if it is a symlink, for its target.

    Each is the project, else the ROS package, else the parent of a folder ``meshes``, else the folder of the mesh.
    """
    found = []
    for file in dict.fromkeys((files.resolve(mesh.parent) / mesh.name, files.resolve(mesh))):
        project = next((folder.parent for folder in file.parents if folder.name == DESCRIPTIONS), None)
        package = next((folder for folder in file.parents if files.is_file(folder / "package.xml")), None)
        above = next((folder.parent for folder in file.parents if folder.name == "meshes"), file.parent)
        found.append(project or package or above)
    return found


def _is_in(file: Path, homes: list[Path]) -> bool:
    with suppress(OSError, RuntimeError, ValueError):
        return any(files.resolve(file).is_relative_to(home) for home in homes)
    return False


def _relative(mesh: Path, name: str) -> Path | None:
    if not name or name.startswith("/") or "://" in name or "\0" in name:
        return None
    return mesh.parent / name.replace("\\", "/")

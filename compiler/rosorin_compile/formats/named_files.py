"""Named files: the meshes, textures and other files that a description names, and where it says that they are."""

from __future__ import annotations

import json
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote

from rosorin_compile.language.expand.included_robots import OF_MJCF
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.files import is_file, read_bytes
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.mujoco import files_in

MESH, TEXTURE, OF_ELEMENT, OF_MESH = "mesh", "texture", "file", "file of a mesh"


_GLB_HEADER = 20
_MAPS = re.compile(rb"^[ \t]*(?:map_\w+|bump|disp|decal|refl|norm)[ \t]+(?:.*[ \t])?(\S+)[ \t]*\r?$", re.I | re.M)
_LIBRARIES = re.compile(rb"^[ \t]*mtllib[ \t]+(.*\S)[ \t]*\r?$", re.M)
_IMAGES = re.compile(rb"<image\b[^>]*>\s*<init_from>\s*(?:<ref>)?\s*([^<>]+?)\s*<")
_PLY_TEXTURE = re.compile(rb"^comment TextureFile[ \t]+(.*\S)[ \t]*\r?$", re.M)
_BUFFERS = ("buffers", "images")


def references(mesh: Path) -> list[str]:
    """Return the files that a mesh file names, and those that they name, relative to its folder.

    These are the .mtl of an OBJ and its textures, the images of COLLADA and PLY, and the buffers and images of glTF.
    """
    try:
        data, ending = read_bytes(mesh), mesh.suffix.lower()
    except OSError:
        return []
    found: list[str] = []
    if ending == ".obj":
        for line in _LIBRARIES.findall(data):
            name = line.decode("utf-8", "replace")
            found += [name] if is_file(mesh.parent / name) else name.split()
        found += [
            posixpath.join(posixpath.dirname(name), inner) for name in found for inner in references(mesh.parent / name)
        ]
    elif ending in (".mtl", ".dae", ".ply"):
        pattern = {".mtl": _MAPS, ".dae": _IMAGES, ".ply": _PLY_TEXTURE}[ending]
        found += [name.decode("utf-8", "replace").replace("\\", "/") for name in pattern.findall(data)]
    elif ending in (".gltf", ".glb"):
        length = int.from_bytes(data[12:16], "little")
        try:
            document = json.loads(data[_GLB_HEADER : _GLB_HEADER + length] if ending == ".glb" else data)
            found += [str(one["uri"]) for key in _BUFFERS for one in document.get(key, ()) if "uri" in one]
        except (ValueError, AttributeError, TypeError):  # a damaged mesh is reported where it is read
            return []
    names = (unquote(name.removeprefix("file://")) if ending in (".dae", ".gltf", ".glb") else name for name in found)
    return list(dict.fromkeys(name for name in names if name and is_relative(name) and not name.startswith("data:")))


def urdf_file_name(name: str) -> str:
    """Return the name that a URDF has for a mesh or texture file: a file of a Gazebo model (model://) is copied."""
    scheme, mark, rest = name.partition("://")
    return f"meshes/{rest.lstrip('/')}" if mark and scheme == "model" and ".." not in rest.split("/") else name


class Named(NamedTuple):
    """A mesh as a description names it, and the places where it does.

    ``kind`` says whether it is one, a texture, or whatever file an element of MJCF has that is kept as it is.
    """

    name: str
    spans: list[Span]
    kind: str = MESH


def is_relative(name: str) -> bool:
    """Say whether the name of a file is relative, and no address."""
    return not (name.startswith("/") or "://" in name)


def named_textures(tree: Map) -> list[Named]:
    """Return the textures of a description, each name once."""
    found: dict[str, list[Span]] = {}
    for node in _maps(tree):
        if isinstance(node.get("texture"), str) and node["texture"]:
            found.setdefault(node["texture"], []).append(node.value_spans["texture"])
    return [Named(name, list(dict.fromkeys(spans)), TEXTURE) for name, spans in found.items()]


def named_in_elements(tree: Map) -> list[Named]:
    """Return the files that elements of MJCF name which are kept as they are, each name once."""
    found: dict[str, list[Span]] = {}
    for node in (tree, *(link for link in (tree.get("links") or {}).values() if isinstance(link, Map))):
        texts = node.get(OF_MJCF)
        for text, span in zip(texts, texts.value_spans, strict=True) if isinstance(texts, Seq) else ():
            for name in files_in(text) if isinstance(text, str) else ():
                found.setdefault(name, []).append(span)
    return [Named(name, list(dict.fromkeys(spans)), OF_ELEMENT) for name, spans in found.items()]


def named_meshes(tree: Map) -> Iterator[Named]:
    """Yield the meshes of a description, each name once."""
    found: dict[str, list[Span]] = {}
    for node in _maps(tree):
        mesh = node.get("mesh")
        if isinstance(mesh, Map) and isinstance(mesh.get("file"), str):
            found.setdefault(mesh["file"], []).append(mesh.value_spans["file"])
    return (Named(name, list(dict.fromkeys(spans))) for name, spans in found.items())


def _maps(tree: Map) -> Iterator[Map]:
    """Yield the entries of a description, but for its outputs and what is for MuJoCo alone, in their order."""
    waiting: list[Any] = [value for key, value in tree.items() if key != "outputs"][::-1]
    while waiting:
        node = waiting.pop()
        if isinstance(node, Map):
            yield node
            waiting += [value for key, value in node.items() if key != "mjcf"][::-1]
        elif isinstance(node, Seq):
            waiting += list(node)[::-1]


class Written(NamedTuple):
    """Where the files of a folder of a description say that their meshes are: folders, and those of packages."""

    folders: list[Path]
    packages: dict[str, Path]


def written(tree: Map) -> dict[Path, Written]:
    """Return what the sources of files say about where meshes are, by the folders in which these files stand."""
    found: dict[Path, Written] = {}
    for entry in (tree, *(tree.get("links") or {}).values()):
        source = entry.get("source") if isinstance(entry, Map) else None
        if isinstance(source, Map) and ("folder" in source or "packages" in source):
            by = Path(source.span.source.path).parent
            here = found.setdefault(by, Written([], {}))
            folder = by / str(source.get("folder") or ".")
            if "folder" in source and folder not in here.folders:
                here.folders.append(folder)
            for name, place in (source.get("packages") or {}).items():
                here.packages.setdefault(name, by / str(place))
    return found

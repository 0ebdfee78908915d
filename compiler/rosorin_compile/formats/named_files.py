"""Named files: the meshes and textures that a description names, and where its files say that they are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..diagnostics import Span
from ..frontend.tree import Map, Seq
from ..startup.records import NamedTuple

MESH, TEXTURE = "mesh", "texture"


class Named(NamedTuple):
    """A mesh as a description names it, and the places where it does; ``kind`` says whether it is one or a texture."""

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

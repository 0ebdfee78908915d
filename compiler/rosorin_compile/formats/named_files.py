"""Named files: the meshes, textures and other files that a description names, and where it says that they are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.language.expand.forms import OF_MJCF
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.mujoco import files_in

MESH, TEXTURE, OF_ELEMENT = "mesh", "texture", "file"


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

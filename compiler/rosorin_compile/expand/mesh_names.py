"""Names of meshes and textures in a robot of others: relative ones are relative to its file, not to the artifacts."""

from __future__ import annotations

import re
from typing import Any

from ..tree import Map, Seq

# An address, an absolute path, or one with the letter of a drive.
_ABSOLUTE = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|/|\\\\")
_ARTIFACTS = "outputs"  # they are files too, of another kind


def relative_files(tree: Map) -> list[str]:
    """Return the relative names of mesh and texture files in the tree of a robot, each once, in their order."""
    sections = [value for key, value in tree.items() if key != _ARTIFACTS]
    return list(dict.fromkeys(node[key] for section in sections for node, key in _places(section)))


def moved(tree: Map, folder: str) -> Map:
    """Return the tree of a robot in which ``folder`` stands before the relative names of mesh and texture files."""
    before = f"{folder.rstrip('/')}/"
    made = Map(tree.span, tree.via)
    for key, value in tree.items():
        value = value if key == _ARTIFACTS else _copied(value, before)
        made.put(key, value, tree.key_spans[key], tree.value_spans[key])
    return made


def _copied(node: Any, before: str) -> Any:
    if isinstance(node, Map):
        made = Map(node.span, node.via)
        for key, value in node.items():
            value = before + value if _is_relative(node, key) else _copied(value, before)
            made.put(key, value, node.key_spans[key], node.value_spans[key])
        return made
    if isinstance(node, Seq):
        listed = Seq(node.span, node.via)
        for item, span in zip(node, node.value_spans, strict=True):
            listed.put(_copied(item, before), span)
        return listed
    return node


def _places(node: Any) -> list[tuple[Map, str]]:
    """Return the maps and keys whose values are relative names of files."""
    if isinstance(node, Map):
        own = [(node, key) for key in node if _is_relative(node, key)]
        return own + [place for value in node.values() for place in _places(value)]
    return [place for item in node for place in _places(item)] if isinstance(node, Seq) else []


def _is_relative(node: Map, key: str) -> bool:
    """Say whether a value is the relative name of a file: ``file`` of a mesh, or a ``texture``."""
    value = node[key]
    return key in ("file", "texture") and isinstance(value, str) and not _ABSOLUTE.match(value)

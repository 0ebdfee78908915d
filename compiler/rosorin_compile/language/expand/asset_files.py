"""Names of mesh and texture files in the tree of a robot."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.mujoco import with_files

from .placing import map_items

# An address, an absolute path, or one with the letter of a drive.
_ABSOLUTE = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|/|\\\\")
OF_MJCF = "mjcf_elements"  # a list of elements of XML


def map_files(tree: Map, rename: Callable[[str], str]) -> Map:
    """Return the tree of a robot in which each name of a mesh or texture file is what ``rename`` makes of it."""
    made = tree.copied()
    for key, value in tree.items():
        if key != "outputs":  # those are files too, of another kind
            made[key] = _mapped(value, rename, key)
    return made


def relative_files(tree: Map) -> list[str]:
    """Return the relative names of mesh and texture files in the tree of a robot, each once."""
    names: dict[str, str] = {}
    map_files(tree, lambda name: names.setdefault(name, name))
    return [name for name in names if not _ABSOLUTE.match(name)]


def move_files(tree: Map, folder: str) -> Map:
    """Return the tree of a robot with ``folder`` before the relative names of mesh and texture files."""
    before = f"{folder.rstrip('/')}/"
    return map_files(tree, lambda name: name if _ABSOLUTE.match(name) else before + name)


def _mapped(node: Any, rename: Callable[[str], str], key: str) -> Any:
    if isinstance(node, Map):
        made = node.copied()
        for name, value in node.items():
            # In a section mjcf, they are names of textures.
            is_file = key != "mjcf" and name in ("file", "texture") and isinstance(value, str)
            made[name] = rename(value) if is_file else _mapped(value, rename, name)
        return made
    if isinstance(node, Seq):
        return map_items(node, lambda item: _mapped(item, rename, key))
    return with_files(node, rename) if key == OF_MJCF and isinstance(node, str) else node

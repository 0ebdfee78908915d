"""Naming: file names from the name of a robot, and the values of a description that get a name of their own.

A value is named only where that is plainly meant: the folder that the meshes of a package stand in, and a scale that
all meshes have.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from ...expression.functions import functions
from ...load import plain_scalar
from ...quantity import UNITS
from ...tree import Map, Seq

MAX_NAME = 60
_FEW = 3  # fewer references to a folder are written out
_LONG = 20  # shorter folders are written out
_WORTH = 50  # so many letters less, at least, where a name stands for a folder
_SHAPES = ("visual", "collision")


class Named(NamedTuple):
    """What is named: mesh folders by name (without the slash at their end), and the scale of all meshes, if any."""

    folders: dict[str, str]
    scale: Seq | None

    def file(self, name: str) -> str | None:
        """Return a mesh file as an expression with the name of its folder, None if that has none."""
        for key, folder in self.folders.items():
            rest = name.removeprefix(f"{folder}/")
            if rest != name and "${" not in rest:
                return f"${{{key}}}/{rest}"
        return None


def safe(name: str) -> str:
    """Return the name of a robot as that of a file or folder: ASCII letters, digits, "_", "-" and ".".

    >>> safe("My Robot (v2)"), safe("../x"), safe("机器人")
    ('My_Robot_v2', 'x', 'robot')
    """
    made = re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:MAX_NAME].strip("._-")
    if not made or not isinstance(plain_scalar(made), str):
        made = f"robot_{made}".strip("_")
    return made


def named(tree: Map) -> Named:
    """Return the values of a robot that are worth a name."""
    meshes = list(_meshes(tree))
    groups: dict[str, list[str]] = {}
    for mesh in meshes:
        file = mesh.get("file")
        if isinstance(file, str):
            groups.setdefault(_package(file), []).append(file)
    folders = {key: folder for key, files in groups.items() if (folder := _common_folder(files))}
    names: dict[str, str] = {}
    for key, folder in folders.items():
        wanted = "meshes" if len(folders) == 1 else f"{_identifier(key)}_meshes"
        names[_free(wanted, names)] = folder
    return Named(names, _common_scale(meshes))


def _meshes(tree: Map) -> Iterator[Map]:
    """Yield every mesh of a robot."""
    for link in (tree.get("links") or {}).values():
        for purpose in _SHAPES if isinstance(link, Map) else ():
            for shape in link.get(purpose) or ():
                if isinstance(shape, Map) and isinstance(shape.get("mesh"), Map):
                    yield shape["mesh"]


def _package(file: str) -> str:
    """Return the package of a mesh reference, empty for a path or another address."""
    scheme, mark, rest = file.partition("://")
    return rest.partition("/")[0] if mark and scheme in ("package", "model") else ""


def _common_folder(files: list[str]) -> str:
    """Return the longest folder that all files stand in; empty if that is none, or too short or rare for a name."""
    if len(files) < _FEW or len(set(files)) < 2:
        return ""
    first, last = min(files), max(files)
    length = next((i for i, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), min(len(first), len(last)))
    folder = first[:length].rpartition("/")[0]
    saved = (len(folder) - len("${meshes}")) * len(files)
    worth = len(folder) >= _LONG and saved >= _WORTH and not folder.endswith((":", ":/"))
    return folder if worth and "${" not in folder else ""


def _common_scale(meshes: list[Map]) -> Seq | None:
    """Return the scale that all meshes have, None if they have different ones, none, or are few."""
    scales = [mesh.get("scale") for mesh in meshes]
    first: Any = scales[0] if len(scales) >= _FEW else None
    same = isinstance(first, Seq) and all(scale == first for scale in scales) and list(first) != [1, 1, 1]
    return first if same else None


def _identifier(text: str) -> str:
    """Return a name for expressions that is like a text."""
    made = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower()
    return made if made and not made[0].isdigit() else f"other_{made}".strip("_")


def _free(wanted: str, taken: dict[str, str]) -> str:
    """Return a name that no other value, unit or function has."""
    name, count = wanted, 1
    while name in taken or name in UNITS or name in functions():
        count += 1
        name = f"{wanted}_{count}"
    return name

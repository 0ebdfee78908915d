"""Addresses: the files that an expanded document names, without the folders of the machine that expanded it.

In the child process. ``$(find arm)/meshes/a.stl`` becomes ``package://arm/meshes/a.stl``, whichever way it was written;
``$(dirname)/a.stl`` outside of any package becomes a name relative to the xacro.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from ..packages import Packages, package_name
from .tracing import elements

_NAMING = ("mesh", "texture")


def name_packages(document: Any, packages: Packages, files: Sequence[str]) -> None:
    """Give the meshes and textures of a document names that hold on any machine; ``files`` made it, the first last."""
    for node in elements(document):
        if node.tagName in _NAMING and node.hasAttribute("filename"):
            name = node.getAttribute("filename")
            node.setAttribute("filename", _anywhere(name, packages, files))


def _anywhere(name: str, packages: Packages, files: Sequence[str]) -> str:
    path = unquote(name.removeprefix("file://")) if name.startswith("file://") else name
    if not Path(path).is_absolute():
        return name
    path = os.path.normpath(path)
    for package, folder in packages.found():
        if path.startswith(f"{folder}{os.sep}"):
            return f"package://{package}/{Path(path).relative_to(folder).as_posix()}"
    folders = [Path(os.path.abspath(file)).parent for file in files]
    if not any(folder in Path(path).parents for folder in [*folders, folders[-1].parent]):
        return name
    for above in Path(path).parents:
        own = package_name(above)
        if own:
            return f"package://{own}/{Path(path).relative_to(above).as_posix()}"
    return Path(os.path.relpath(path, folders[-1])).as_posix()

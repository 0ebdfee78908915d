"""Meshes and textures of a package: the files that a URDF or an SDF names, and their names in the package.

``package://`` names of other packages stay, and those packages become dependencies. A path finds nothing once the URDF
is a parameter of robot_state_publisher, so the file is copied into the package and named by ``package://``.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple
from xml.sax.saxutils import unescape

from rosorin_compile.formats.mesh_files import references, urdf_file_name
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, first_of
from rosorin_compile.source.files import is_file

from .options import is_legal

_FILE = re.compile(r"""(<(?:mesh|texture)\b[^<>]*?\bfilename=["'])([^"'<>]*)(?=["'])""")
_OF_SDF = re.compile(r"(<(?:mesh>\s*<uri|albedo_map|normal_map|metalness_map|roughness_map)>\s*)([^<>]*?)(?=\s*</)")
_PACKAGE = re.compile(r"package://([^/]+)/(.+)")
_ENTITIES = {"&quot;": '"', "&apos;": "'", "&#34;": '"', "&#39;": "'"}
MESHES = "meshes"


class Meshes(NamedTuple):
    """A URDF in a package: its text, the files to copy by their names in the package, the packages it needs."""

    text: str
    files: dict[str, Path]
    packages: tuple[str, ...]
    diagnostics: list[Diagnostic]


def named(text: str, is_sdf: bool = False) -> list[str]:
    """Return the names of the mesh and texture files of a URDF or an SDF, each once, in their order."""
    pattern = _OF_SDF if is_sdf else _FILE
    return list(dict.fromkeys(unescape(match[2], _ENTITIES) for match in pattern.finditer(text)))


def place_meshes(
    text: str,
    package: str,
    folders: Sequence[Path],
    target: Path,
    known: Mapping[str, Path] = MappingProxyType({}),
    reported: Container[str] = (),
    place: str = "",
) -> Meshes:
    """Return a URDF with its meshes in a package, or an SDF at a ``place``, which names them relative to itself.

    Files are ``known`` by name, or searched for in ``folders`` and in ``target``, the folder of the package. Missing
    files are ``reported`` already, or get a warning.
    """
    addresses: dict[str, str] = {}
    files: dict[str, Path] = {}
    packages: set[str] = set()
    missing: dict[tuple[str, str], list[str]] = {}  # names by what is wrong and the fix
    where = "neither in the package nor beside the description" if folders else "not in the package"
    is_sdf = place.endswith(".sdf")
    for name in named(text, is_sdf):
        is_copied = is_sdf and name in known
        match = None if is_copied else _PACKAGE.fullmatch(name)
        if match and match[1] != package:
            packages |= {match[1]} if is_legal(match[1]) else set()
            continue
        if not match and not is_copied and ("://" in name or name.startswith("/")):
            help = f"copy the file into a package and write package://{package}/{MESHES}/... in the description"
            missing.setdefault(("found on machines that have this very file", help), []).append(name)
            continue
        inside = match[2] if match else _inside(urdf_file_name(name))
        if not match:
            relative = posixpath.relpath(inside, posixpath.dirname(place))
            addresses[name] = relative if is_sdf else f"package://{package}/{inside}"
        leads_out = ".." in inside.split("/")
        searched = match[2] if match else name
        source = known.get(name) or next((one / searched for one in folders if is_file(one / searched)), None)
        if source is not None and not leads_out:
            files[inside] = source
        elif name not in reported and (leads_out or not is_file(target / inside)):
            help = f"put the file into {posixpath.dirname(inside) or '.'}/ of the package"
            missing.setdefault((where, help), []).append(name)
    for inside, source in list(files.items()):
        for name, file in companions(inside, source).items():
            if name.startswith(f"{MESHES}/"):
                files[name] = file
            else:
                help = f"put the file below the folder of the mesh: a package installs {MESHES}/"
                missing.setdefault((f"named by {inside} and not in the package", help), []).append(name)

    def renamed(match: re.Match[str]) -> str:
        name = addresses.get(unescape(match[2], _ENTITIES))
        return match[0] if name is None else f"{match[1]}{escape(name)}"

    text = (_OF_SDF if is_sdf else _FILE).sub(renamed, text)
    diagnostics = [mesh_warning(names, what, help) for (what, help), names in missing.items()]
    return Meshes(text, files, tuple(sorted(packages)), diagnostics)


def _inside(name: str) -> str:
    parts = [part for part in name.split("/") if part not in ("", ".", "..")]
    return "/".join([MESHES, *(parts[1:] if parts[0] == MESHES and len(parts) > 1 else parts)])


def companions(place: str, mesh: Path) -> dict[str, Path]:
    """Return the existing files that a mesh file at a place names, by their places."""
    found = {name: mesh.parent / name for name in references(mesh) if is_file(mesh.parent / name)}
    return {posixpath.normpath(posixpath.join(posixpath.dirname(place), name)): file for name, file in found.items()}


def missing_files(place: str, names: Sequence[str], places: Container[str], folder: Path) -> Iterator[Diagnostic]:
    """Yield a warning about files that an artifact needs next to it; ``places`` are those of other artifacts."""
    inside = posixpath.dirname(place)
    needed = [name for name in names if posixpath.normpath(posixpath.join(inside, name)) not in places]
    missing = [name for name in needed if not is_file(folder / inside / name)]
    if missing:
        what = f"named by {place}, but not in the package"
        yield mesh_warning(missing, what, f"put the file into {inside}/ of the package")


def mesh_warning(names: Sequence[str], what: str, help: str) -> Diagnostic:
    """Return one warning about all files with the same problem; ``help`` is about one file."""
    if len(names) == 1:
        return Diagnostic("package-mesh", WARNING, f"{names[0]} is {what}", None, (), help)
    message = f"{len(names)} files are {what}: {first_of(names, 3)}".replace("this very file", "these very files")
    return Diagnostic("package-mesh", WARNING, message, None, (), help.replace("the file", "the files"))

"""Meshes: which files a URDF names, and what a package does about them.

``package://`` names of other packages stay, and those packages become dependencies. A path finds nothing once the URDF
is a parameter of robot_state_publisher, so the file is copied into the package and named by ``package://``. What cannot
be found is said, and stays as it was written.
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
    """A URDF as a package has it: its text, the files to copy by their name in the package, the packages it needs."""

    text: str
    files: dict[str, Path]
    packages: tuple[str, ...]
    diagnostics: list[Diagnostic]


def named(text: str, is_sdf: bool = False) -> list[str]:
    """Return the names of the mesh and texture files of a URDF or an SDF, each once, in their order."""
    pattern = _OF_SDF if is_sdf else _FILE
    return list(dict.fromkeys(unescape(match[2], _ENTITIES) for match in pattern.finditer(text)))


def settle(
    urdf: str,
    package: str,
    folders: Sequence[Path],
    target: Path,
    known: Mapping[str, Path] = MappingProxyType({}),
    told_before: Container[str] = (),
    place: str = "",
) -> Meshes:
    """Return a URDF, or an SDF at a ``place``, with its meshes in a package: the SDF names them relative to itself.

    The files of meshes are ``known`` by name, and what was not found was ``told_before``; textures, and meshes that
    nobody looked for, are looked for in ``folders``, one after the other. ``target`` is the folder of the package,
    which may hold meshes already.
    """
    addresses: dict[str, str] = {}
    files: dict[str, Path] = {}
    packages: set[str] = set()
    missing: dict[tuple[str, str], list[str]] = {}  # names by what is to say of them, and the fix
    is_sdf = place.endswith(".sdf")
    for name in named(urdf, is_sdf):
        match = _PACKAGE.fullmatch(name)
        if is_sdf and name in known:
            match, files[_inside(urdf_file_name(name))] = None, known[name]
            addresses[name] = posixpath.relpath(_inside(urdf_file_name(name)), posixpath.dirname(place))
        elif match and match[1] != package:
            packages |= {match[1]} if is_legal(match[1]) else set()
        elif match:
            if not _own(match[2], known.get(name), folders, target, files) and name not in told_before:
                missing.setdefault((_nowhere(folders), "put the file there"), []).append(name)
        elif "://" in name or name.startswith("/"):
            help = f"copy the file into a package and write package://{package}/{MESHES}/... in the description"
            missing.setdefault(("found on machines that have this very file", help), []).append(name)
        else:
            inside = _inside(name)
            source = known.get(name) or _existing(name, folders)
            if source is not None:
                files[inside] = source
            elif not is_file(target / inside) and name not in told_before:
                help = f"put the file into {MESHES}/ of the package"
                missing.setdefault((_nowhere(folders), help), []).append(name)
            relative = posixpath.relpath(inside, posixpath.dirname(place)) if is_sdf else ""
            addresses[name] = relative or f"package://{package}/{inside}"
    for inside, source in list(files.items()):
        for name, file in companions(inside, source).items():
            if name.startswith(f"{MESHES}/"):
                files[name] = file
            else:
                help = f"put it below the folder of the mesh: a package installs {MESHES}/"
                missing.setdefault((f"named by {inside} and not in the package", help), []).append(name)
    text = (_OF_SDF if is_sdf else _FILE).sub(lambda match: _renamed(match, addresses), urdf)
    diagnostics = [one_warning(names, what, help) for (what, help), names in missing.items()]
    return Meshes(text, files, tuple(sorted(packages)), diagnostics)


def companions(place: str, mesh: Path) -> dict[str, Path]:
    """Return the files that a mesh file at a place names and that are there, by their places."""
    found = {name: mesh.parent / name for name in references(mesh) if is_file(mesh.parent / name)}
    return {posixpath.normpath(posixpath.join(posixpath.dirname(place), name)): file for name, file in found.items()}


def _own(inside: str, known: Path | None, folders: Sequence[Path], target: Path, files: dict[str, Path]) -> bool:
    source = None if ".." in inside.split("/") else known or _existing(inside, folders)
    if source is not None:
        files[inside] = source
        return True
    return ".." not in inside.split("/") and is_file(target / inside)


def _nowhere(folders: Sequence[Path]) -> str:
    return "neither in the package nor beside the description" if folders else "not in the package"


def _inside(name: str) -> str:
    parts = [part for part in name.split("/") if part not in ("", ".", "..")]
    return "/".join([MESHES, *(parts[1:] if parts[0] == MESHES and len(parts) > 1 else parts)])


def _existing(name: str, folders: Sequence[Path]) -> Path | None:
    return next((folder / name for folder in folders if is_file(folder / name)), None)


def _renamed(match: re.Match[str], addresses: dict[str, str]) -> str:
    name = addresses.get(unescape(match[2], _ENTITIES))
    return match[0] if name is None else f"{match[1]}{escape(name)}"


def not_placed(place: str, names: Sequence[str], places: Container[str]) -> list[str]:
    """Return the files that an artifact at a place names beside it and that are no other artifact."""
    return [name for name in names if posixpath.normpath(posixpath.join(posixpath.dirname(place), name)) not in places]


def named_files(place: str, names: Sequence[str], folder: Path) -> Iterator[Diagnostic]:
    """Yield what an artifact at a place in a folder names beside it, and what is not there."""
    inside = place.rpartition("/")[0]
    missing = [name for name in names if not is_file(folder / inside / name)]
    if missing:
        what = f"named by {place}, but not in the package"
        yield one_warning(missing, what, f"put the file into {inside}/ of the package")


def one_warning(names: Sequence[str], what: str, help: str) -> Diagnostic:
    """Return one warning for files of which the same is to say; ``help`` is about one file."""
    if len(names) == 1:
        return Diagnostic("package-mesh", WARNING, f"{names[0]} is {what}", None, (), help)
    many = help.replace("the file", "the files")
    message = f"{len(names)} files are {what}: {first_of(names, 3)}".replace("this very file", "these very files")
    return Diagnostic("package-mesh", WARNING, message, None, (), many)

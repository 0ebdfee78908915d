"""Rename the meshes of an imported robot, and report what was imported in a few lines.

The ``source`` of a description has the ``folder`` in which relative names are looked for, and the ``packages`` that are
found from the source, but not from the description. A relative name that leads out of the folder of the source becomes
one from a folder above it, so that artifacts have their files beside them wherever they are.
"""

from __future__ import annotations

import os
import posixpath
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import Imported
from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.language.expand.included_robots import map_files, move_files, relative_files
from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, counted, first_of
from rosorin_compile.source.files import is_file, resolve
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map, Seq

from .layout import within_part

_RULE = "import-mesh-path"
_TAG = re.compile(r"<([^\s/>!?]+)")
_FEW = 3


class Renamed(NamedTuple):
    """The tree of a robot with the mesh names of its description, and diagnostics about them.

    ``meshes`` is the prefix of all relative names, or None.
    """

    tree: Map
    diagnostics: list[Diagnostic]
    meshes: str | None = None


def renamed(
    tree: Map, source: Path, folder: Path, meshes: str | None, packages: Mapping[str, Path], keeps: bool = False
) -> Renamed:
    """Rename meshes and textures so that the description finds the same files as the source.

    Args:
        tree: The tree of the robot.
        source: The file that it was read from.
        folder: The folder of the description.
        meshes: The prefix of relative names from ``--meshes``.
        packages: The folders of packages from the command line.
        keeps: Macros make the names, so they stay. If they are outside of the folder of the source, their prefix is the
            path from the artifacts to the source.

    """
    place = tree.value_spans.get("robot", tree.span)
    searched = Places(source, source.parent, packages, os.environ).named(tree, relative=meshes is None)
    files, messages, here = searched.by_name, list(searched.diagnostics), Path(os.path.abspath(folder))
    base, relative = Path(os.path.abspath(source.parent)), relative_files(tree)
    stay = keeps or meshes is not None or not (files or _has_one(base, relative))  # missing files keep their names
    top, names = (base, dict(zip(relative, relative, strict=True))) if stay else _names(base, relative, files)
    known = {name: _seen(at, here) for name, at in _packages({names.get(n, n): at for n, at in files.items()}, here)}
    if meshes is not None:
        if not relative:
            message = f"{source.name} names no mesh or texture by a relative path: --meshes changes nothing"
            messages.append(Diagnostic(_RULE, WARNING, message, place, (), "leave --meshes out"))
        known |= _package_of(meshes, relative, base, here)
        return Renamed(_with_places(move_files(tree, meshes), "", known), messages, meshes)
    outside = [name for name in relative if keeps and posixpath.normpath(name).startswith("../")]
    bare = [name for name in files if name not in names and not _is_of_package(name)]
    if bare:
        messages.append(_elsewhere("are named by paths of this machine, where artifacts look for them", bare, place))
    if outside:
        artifacts = _artifacts(folder)
        how = f"are out of the folder of {source.name}: artifacts name them as seen from {artifacts.as_posix()}"
        messages.append(_elsewhere(how, outside, place))
        meshes = _seen(base, artifacts)
        return Renamed(_with_places(move_files(tree, meshes), "", known), messages, meshes)
    tree = map_files(tree, lambda name: names.get(name, name))
    has_folder = any(not _is_of_package(name) for name in names.values())
    return Renamed(_with_places(tree, _seen(top, here) if has_folder else "", known), messages)


def _artifacts(folder: Path) -> Path:
    """Return the default folder of the artifacts of a description (see ``project``)."""
    base = folder.parent.parent if Path(os.path.abspath(folder)).parent.name == Description.FOLDER else Path()
    return base / Description.OUTPUTS / folder.name


def _is_of_package(name: str) -> bool:
    return name.startswith(("package://", "model://"))


def _names(base: Path, relative: Sequence[str], files: Mapping[str, Path]) -> tuple[Path, dict[str, str]]:
    """Return the common folder of the files of a source, and their new names relative to it, by their names.

    ``base`` is the folder of the source. A path of this machine that leads into another ROS package becomes an address
    in that package.
    """
    own = _package_above(base / "any")
    places = {name: Path(os.path.normpath(base / name)) for name in relative}
    names: dict[str, str] = {}
    for name, file in files.items():
        if not name.startswith(("/", "file://")):
            continue
        path = Path(os.path.abspath(file))
        package = _package_above(path)
        if package is None or package == own:
            places[name] = path
        else:
            names[name] = f"package://{Packages.name_of(package)}/{path.relative_to(package).as_posix()}"
    top = Path(os.path.commonpath([base, *places.values()]))
    return top, {**names, **{name: _seen(path, top) for name, path in places.items()}}


def _package_above(path: Path) -> Path | None:
    return next((folder for folder in path.parents if Packages.name_of(folder)), None)


def _packages(files: Mapping[str, Path], here: Path) -> Iterator[tuple[str, Path]]:
    """Yield the packages of files with their folders, except those that are found from ``here``."""
    near, visited = Packages({}, os.environ, here / Description.ROOT_FILE), set()
    for name, file in files.items():
        package, _, path = name.partition("://")[2].lstrip("/").partition("/")
        if _is_of_package(name) and package not in visited:
            visited.add(package)
            folder = Path(os.path.abspath(file)).parents[len(Path(path).parts) - 1]
            known = near.find(package)
            if known is None or resolve(known) != resolve(folder):
                yield package, folder


def _package_of(meshes: str, relative: Sequence[str], base: Path, here: Path) -> dict[str, str]:
    """Return the package of the prefix of relative names with its folder, if it is not found with these files.

    ``meshes`` leads to the folder of the source, ``base``, as far as their last folders have the same names.
    """
    package, _, path = meshes.partition("://")[2].strip("/").partition("/")
    parts = Path(path).parts
    above = len(base.parts) - len(parts)
    found = Packages({}, os.environ, here / Description.ROOT_FILE).find(package) if _is_of_package(meshes) else base
    if base.parts[above:] != parts or (found is not None and _has_one(found / path, relative)):
        return {}
    return {package: _seen(Path(*base.parts[:above]), here)} if _has_one(base, relative) else {}


def _has_one(folder: Path, relative: Sequence[str]) -> bool:
    return any(is_file(folder / name) for name in relative)


def seen_from(imported: Imported, folder: Path) -> Imported:
    """Return a robot whose source has absolute paths of its meshes, relative to ``folder`` before."""
    source = imported.tree.get("source") if imported.tree is not None else None
    if imported.tree is None or not (isinstance(source, Map) and {"folder", "packages"} & source.keys()):
        return imported
    here = Path(os.path.abspath(folder))
    known = {name: os.path.normpath(here / at) for name, at in (source.get("packages") or {}).items()}
    own = os.path.normpath(here / source["folder"]) if "folder" in source else ""
    return imported._replace(tree=_with_places(imported.tree, own, known))


def _with_places(tree: Map, folder: str, packages: Mapping[str, str]) -> Map:
    """Return the tree of a robot whose source says where its meshes are."""
    if not (folder or packages):
        return tree
    made, span = tree.copied(), tree.span
    source, named = tree["source"].copied(), Map(span)
    for package, at in packages.items():
        named.put(package, at, span, span)
    for key, value in (("folder", folder), ("packages", named)):
        if value:
            source.put(key, value, span, span)
    made["source"] = source
    return made


def _seen(path: Path, folder: Path) -> str:
    """Return a path relative to a folder, as a description has it."""
    return Path(os.path.relpath(path, folder)).as_posix()


def _elsewhere(how: str, names: Sequence[str], span: Span) -> Diagnostic:
    """Return the warning about files that artifacts find in one place only."""
    help = "name them as package://NAME/FILE; or import with --meshes FOLDER, as seen from the artifacts"
    return Diagnostic(_RULE, WARNING, f"files {how}: {first_of(names, 1)}", span, (), help)


def sizes(tree: Map) -> str:
    """Return how many links and joints a robot has."""
    links, joints = len(tree.get("links") or ()), len(tree.get("joints") or ())
    return f"{counted(links, 'link')}, {counted(joints, 'joint')}"


def repeated(tree: Map, reordered: bool) -> list[str]:
    """Return the lines about parts, and about the order of joints, which readers of joint positions depend on."""
    bodies = [tree, *(tree.get("parts") or {}).values()]
    uses = Counter(use["part"] for body in bodies for use in (body.get("use") or {}).values())
    if not uses:
        return []
    lines = ["parts: " + ", ".join(f"{part} ({counted(count, 'use')})" for part, count in uses.items())]
    return [*lines, "the joints come in another order than in the source; --no-parts keeps it"] if reordered else lines


def kept(tree: Map) -> list[str]:
    """Return the line about elements that are kept unchanged, if there are any."""
    tags = Counter(_tag(text) for text in _elements(tree))
    if not tags:
        return []
    return ["kept as they are: " + ", ".join(f"{tag} ({count})" if count > 1 else tag for tag, count in tags.items())]


def accepted(tree: Map) -> list[str]:
    """Return the lines about rules that the robot breaks, and that the description accepts."""
    found: dict[str, list[str]] = {}
    for entry in tree.get("accept") or ():
        found.setdefault(entry["rule"], []).extend(map(str, entry.get("of") or ()))
    return [
        f"accepted: {rule} ({first_of(names, _FEW)})" if names else f"accepted: {rule}" for rule, names in found.items()
    ]


def _elements(node: Any, path: tuple[str | int, ...] = ()) -> Iterator[str]:
    """Yield every element that is kept, in the order of the tree."""
    if isinstance(node, Map):
        for key, value in node.items():
            yield from _elements(value, (*path, key))
    elif isinstance(node, Seq) and "x-names-in" in fragment_at((*within_part(path), 0)):
        yield from node
    elif isinstance(node, Seq):
        for index, item in enumerate(node):
            yield from _elements(item, (*path, index))


def _tag(text: str) -> str:
    found = _TAG.search(text)
    return found[1] if found else "text"

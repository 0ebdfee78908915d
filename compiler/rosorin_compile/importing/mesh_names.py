"""Rename the meshes of an imported robot so that its description refers to the same files as the source.

In the section ``source`` of a description, ``folder`` is the base of relative mesh file names, and ``packages`` has the
folders of ROS packages that cannot be found from the description. If a relative name leads out of the source folder,
all names become relative to a common parent folder, so that artifacts can be moved together with the meshes.
"""

import os
import posixpath
from collections.abc import Mapping, Sequence
from pathlib import Path

from rosorin_compile.formats.imported_robot import ImportedRobot, as_tree
from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.language.expand.included_robots import map_files, move_files, relative_files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, first_of
from rosorin_compile.source.files import is_file, resolve
from rosorin_compile.source.packages import Packages, package_of
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map

_RULE = "import-mesh-path"


def rename_files(
    tree: Map, source: Path, folder: Path, meshes: str | None, packages: Mapping[str, Path], keeps: bool = False
) -> tuple[Map, list[Diagnostic], str | None]:
    """Rename meshes and textures so that the description refers to the same files as the source.

    Returns (description, diagnostics, prefix added to relative names, or None). The description is in ``folder``;
    ``meshes`` is the prefix from ``--meshes``. With ``keeps``, names do not change, because macros generate them; if a
    file is outside the source folder, the prefix is the path from the artifacts to the source.
    """
    place = tree.value_spans.get("robot", tree.span)
    searched = Places(source, source.parent, packages, os.environ).search(tree, relative=meshes is None)
    files, messages, here = searched.by_name, list(searched.diagnostics), Path(os.path.abspath(folder))
    base, relative = Path(os.path.abspath(source.parent)), relative_files(tree)
    has_files = any(is_file(base / name) for name in relative)
    if meshes is not None:
        if not relative:
            message = f"{source.name} names no mesh or texture by a relative path: --meshes changes nothing"
            messages.append(Diagnostic(_RULE, WARNING, message, place, (), "leave --meshes out"))
        known = _packages(files, here)
        package, _, path = meshes.partition("://")[2].strip("/").partition("/")
        depth = len(base.parts) - len(Path(path).parts)
        if _is_of_package(meshes) and has_files and base.parts[depth:] == Path(path).parts:
            found = Packages({}, os.environ, here / Description.ROOT_FILE).find(package)
            if found is None or not any(is_file(found / path / name) for name in relative):
                known[package] = _seen(Path(*base.parts[:depth]), here)
        return _with_places(move_files(tree, meshes), "", known), messages, meshes
    top, names = base, {name: name for name in relative}
    if not keeps and (files or has_files):  # do not rename files if none exists
        top, names = _names(base, relative, files)
    known = _packages({names.get(name, name): file for name, file in files.items()}, here)
    bare = [name for name in files if name not in names and not _is_of_package(name)]
    if bare:
        messages.append(_elsewhere("are named by paths of this machine, where artifacts look for them", bare, place))
    outside = [name for name in relative if keeps and posixpath.normpath(name).startswith("../")]
    if outside:
        in_project = here.parent.name == Description.FOLDER
        artifacts = (folder.parent.parent if in_project else Path()) / Description.OUTPUTS / folder.name
        how = f"are out of the folder of {source.name}: artifacts name them as seen from {artifacts.as_posix()}"
        messages.append(_elsewhere(how, outside, place))
        meshes = _seen(base, artifacts)
        return _with_places(move_files(tree, meshes), "", known), messages, meshes
    tree = map_files(tree, lambda name: names.get(name, name))
    has_folder = any(not _is_of_package(name) for name in names.values())
    return _with_places(tree, _seen(top, here) if has_folder else "", known), messages, None


def _is_of_package(name: str) -> bool:
    return name.startswith(("package://", "model://"))


def _names(base: Path, relative: Sequence[str], files: Mapping[str, Path]) -> tuple[Path, dict[str, str]]:
    """Return (common parent folder of all mesh files, {old file name: new file name relative to that folder})."""
    own = package_of(base)
    places = {name: Path(os.path.normpath(base / name)) for name in relative}
    names: dict[str, str] = {}
    for name, file in files.items():
        if name.startswith(("/", "file://")):
            package = package_of(file.parent)
            if package is None or package == own:
                places[name] = Path(os.path.abspath(file))
            else:
                names[name] = f"package://{package[1]}/{resolve(file).relative_to(package[0]).as_posix()}"
    top = Path(os.path.commonpath([base, *places.values()]))
    return top, {**names, **{name: _seen(path, top) for name, path in places.items()}}


def _packages(files: Mapping[str, Path], here: Path) -> dict[str, str]:
    """Return the folder of each ROS package in ``files`` that cannot be found from ``here``, by package name."""
    near, found = Packages({}, os.environ, here / Description.ROOT_FILE), dict[str, str]()
    for name, file in files.items():
        package, _, path = name.partition("://")[2].lstrip("/").partition("/")
        if _is_of_package(name) and package not in found:
            folder = Path(os.path.abspath(file)).parents[len(Path(path).parts) - 1]
            there = near.find(package)
            if there is None or resolve(there) != resolve(folder):
                found[package] = _seen(folder, here)
    return found


def seen_from(imported: ImportedRobot, folder: Path) -> ImportedRobot:
    """Make the paths in the section ``source`` of a robot absolute; relative paths start at ``folder``."""
    source = imported.tree.get("source") if imported.tree is not None else None
    if imported.tree is None or not (isinstance(source, Map) and {"folder", "packages"} & source.keys()):
        return imported
    here = Path(os.path.abspath(folder))
    known = {name: os.path.normpath(here / path) for name, path in (source.get("packages") or {}).items()}
    own = os.path.normpath(here / source["folder"]) if "folder" in source else ""
    return imported._replace(tree=_with_places(imported.tree, own, known))


def _with_places(tree: Map, folder: str, packages: Mapping[str, str]) -> Map:
    places = {key: value for key, value in (("folder", folder), ("packages", dict(packages))) if value}
    made = tree.copy()
    made["source"] = as_tree({**(tree.get("source") or {}), **places}, tree.span)
    return made if places else tree


def _seen(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path, folder)).as_posix()


def _elsewhere(how: str, names: Sequence[str], span: Span) -> Diagnostic:
    help = "name them as package://NAME/FILE; or import with --meshes FOLDER, as seen from the artifacts"
    return Diagnostic(_RULE, WARNING, f"files {how}: {first_of(names, 1)}", span, (), help)

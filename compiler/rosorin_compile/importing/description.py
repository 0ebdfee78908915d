"""Write the plain tree of a robot as the files of a description: its sections and keys in the order of the schema.

Folders that many meshes share get a name under ``let``. ``x-first`` of the schema names the keys that come first where
the others stay as in the source; ``x-file`` is the file of a section in a description of several.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from graphlib import TopologicalSorter
from itertools import pairwise
from keyword import iskeyword
from pathlib import Path as FilePath
from typing import Any, TypeVar

from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.language.expression.functions import reserved_names
from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map, Path, Seq

from .layout import Expression, Verbatim, angle_of, escaped, layout, number, placed, within_part

PARTS, USE, LET = "parts", "use", "let"  # sections that the plain tree has no more
# The files besides the first one, in their order; others follow.
_ABOUT = {
    PARTS: "The parts: what the robot has several times, written once; robot.yaml uses them.",
    "links": "The links: masses, what they look like, what they collide with.",
    "joints": "The joints: how the links hang together.",
    "simulation": "What only a simulation has: how the robot stands, what drives it, what it measures and touches.",
    "sensors": "The sensors: what each measures, and what Gazebo has of it.",
    "control": "The hardware of ros2_control.",
    "extensions": "What the language has no word for, as it stood in the source.",
    "moveit": "What MoveIt has to know beside the URDF: groups of joints, end effectors, pairs that it need not check.",
}
_BEHIND = {LET: PARTS, "joints": USE}  # they hang on links, as joints do
_WITH_EACH = "source"  # at the top of each file
_LAST = 1_000  # the place of what the schema says nothing of

V = TypeVar("V")
MAX_LINES = 150  # a longer description is split into files


def tree_of(imported: Imported) -> Map:
    """Return the tree of a source. Raises ValueError for a broken one, which has none."""
    if imported.tree is None:
        raise ValueError("a broken source has no tree")
    return imported.tree


def write(imported: Imported, wanted: Outputs, schema: str = "", split: bool | None = None) -> dict[str, str]:
    """Return the files of a description, text by name; the first is ``robot.yaml``.

    The tree has to be there. ``schema`` is where editors find the schema, from the folder of the files. ``split`` says
    whether it is several files; without it a long one is. The result is the same for the same tree, whatever the
    machine.
    """
    document = _Document(tree_of(imported), imported.packages).made(wanted)
    head = [f"yaml-language-server: $schema={schema}"] if schema else []
    few = sum(len(value) for value in document.values() if isinstance(value, dict)) <= MAX_LINES
    if split is False or (split is None and few):
        whole = _file(Description.ROOT_FILE, document, imported, wanted, head)
        if split is False or whole.count("\n") <= MAX_LINES:
            return {Description.ROOT_FILE: whole}
    parts = in_files(document)
    for section in {section for part in parts.values() for section in part} - {"source"}:
        del document[section]
    document["include"] = [f"{name}.yaml" for name in parts]
    files = {Description.ROOT_FILE: _file(Description.ROOT_FILE, sorted_sections(document), imported, wanted, head)}
    for name, part in parts.items():
        file = f"{name}.yaml"
        files[file] = _file(file, part, imported, wanted, [*head, about(name, part)])
    return files


def lines_of(tree: Map) -> int:
    """Return how many lines some sections of a description take."""
    made = _Document(tree)
    return layout({key: made.value(value, (key,), None) for key, value in tree.items()}).count("\n")


def _file(name: str, document: dict[str, Any], imported: Imported, wanted: Outputs, head: list[str]) -> str:
    """Return the text of one file."""
    root = name == Description.ROOT_FILE
    said = placed(imported.comments, document, head, root)
    if root and wanted.lines:
        inside = {**said.inside, ("outputs",): wanted.lines}
        said = said._replace(inside=inside)
    return layout(document, said)


class _Document:
    """Turns a tree into the values of a document."""

    def __init__(self, tree: Map, packages: Mapping[str, FilePath] = {}) -> None:
        self.tree, self.packages = tree, packages
        self.folders = mesh_folders(tree)

    def made(self, wanted: Outputs) -> dict[str, Any]:
        """Return the document of the whole description."""
        body = {key: self.value(value, (key,), span) for key, value, span in _items(self.tree) if value}
        lets: dict[str, Any] = {**self.folders, **body.pop("let", {})}
        document: dict[str, Any] = {"rosorin_compile": Verbatim("1"), **body}
        if lets:
            document["let"] = lets
        document["outputs"] = {name: _written(entry) for name, entry in wanted.entries.items()}
        return sorted_sections(document)

    def value(self, value: Any, path: Path, span: Span | None) -> Any:
        """Return one value as ``layout`` takes it."""
        if isinstance(value, Map):
            return self.mapping(value, path)
        if isinstance(value, Seq):
            return [self.value(v, (*path, i), s) for i, (v, s) in enumerate(zip(value, value.value_spans, strict=True))]
        if isinstance(value, str):
            if path[-2:] == ("mesh", "file"):
                return _below_folder(value, self.folders)
            return value if isinstance(value, Verbatim) else _in_packages(value, self.packages)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return number(value, span, angle_of(self.tree, path))
        return value

    def mapping(self, value: Map, path: Path) -> dict[str, Any]:
        """Return a mapping without what is said by default, in the order in which a person would say it."""
        made: dict[str, Any] = {}
        own = within_part(path)
        for key, item, span in _items(value):
            here = (*path, key)
            if not is_default((*own, key), item):
                found = self.value(item, here, span)
                if found or key != "dynamics":
                    made[key] = found
        return sorted_keys(made, own) if len(own) > 1 else made


def _in_packages(text: str, packages: Mapping[str, FilePath]) -> str:
    """Return a text in which files are named by their package, not by their folder on this machine."""
    if not any(f"{folder}{os.sep}" in text for folder in packages.values()):
        return text if isinstance(text, Expression) else str(text)
    made = text if isinstance(text, Expression) else escaped(text)
    for name, folder in packages.items():
        made = made.replace(f"{folder}{os.sep}", f"${{find('{name}', 'package://{name}')}}/")
    return Expression(made)


def _written(value: Any) -> Any:
    """Return an entry of the outputs as ``layout`` takes it."""
    if isinstance(value, Mapping):
        return {key: _written(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_written(item) for item in value]
    return number(value, None) if isinstance(value, (int, float)) and not isinstance(value, bool) else value


def _items(value: Map) -> Iterator[tuple[str, Any, Span | None]]:
    for key, item in value.items():
        yield key, item, value.value_spans.get(key)


_MIN_FILES = 3  # in a folder that gets a name
_MIN_LENGTH = 20  # of the path of such a folder
_MIN_SAVED = 50  # characters that a name has to save


def mesh_folders(tree: Map) -> dict[str, str]:
    """Return the folders of meshes that are worth a name under ``let``, by that name, without a slash at the end."""
    bodies = [tree, *(part for part in (tree.get("parts") or {}).values() if isinstance(part, Map))]
    links = [link for body in bodies for link in (body.get("links") or {}).values() if isinstance(link, Map)]
    shapes = [shape for link in links for key in ("visual", "collision") for shape in link.get(key) or ()]
    meshes = [shape["mesh"] for shape in shapes if isinstance(shape, Map) and isinstance(shape.get("mesh"), Map)]
    packages: dict[str, list[str]] = {}
    for file in (mesh.get("file") for mesh in meshes):
        if isinstance(file, str):
            scheme, mark, rest = file.partition("://")
            is_package = mark and scheme in ("package", "model")
            packages.setdefault(rest.partition("/")[0] if is_package else "", []).append(file)
    folders = {package: folder for package, files in packages.items() if (folder := _common_folder(files))}
    named: dict[str, str] = {}
    for package, folder in folders.items():
        name = "meshes" if len(folders) == 1 else f"{identifier(package or 'other')}_meshes"
        named[free_name(name, named)] = folder
    return named


def _common_folder(files: list[str]) -> str:
    """Return the longest folder of all files, or "" if a name for it would not be worth it."""
    if len(files) < _MIN_FILES or len(set(files)) < 2:
        return ""
    first, last = min(files), max(files)
    length = next((i for i, pair in enumerate(zip(first, last, strict=False)) if len(set(pair)) > 1), len(first))
    folder = first[:length].rpartition("/")[0]
    saved = (len(folder) - len("${meshes}")) * len(files)
    is_worth = len(folder) >= _MIN_LENGTH and saved >= _MIN_SAVED and not folder.endswith((":", ":/"))
    return folder if is_worth and not ("${" in folder or "$(" in folder) else ""


def _below_folder(file: str, folders: Mapping[str, str]) -> str:
    """Return a mesh file with the name of its folder, if that has one."""
    for name, folder in folders.items():
        rest = file.removeprefix(f"{folder}/")
        if rest != file and (isinstance(file, Expression) or not ("${" in rest or "$(" in rest)):
            return Expression(f"${{{name}}}/{rest}")
    return file if isinstance(file, Expression) else str(file)


def identifier(text: str) -> str:
    """Return a name for expressions that resembles a text."""
    name = re.sub(r"[\W_]+", "_", text, flags=re.ASCII).strip("_").lower()
    return name if name and not name[0].isdigit() else f"n_{name}".strip("_")


def free_name(wanted: str, taken: Iterable[str]) -> str:
    """Return a name that is not taken and has no meaning in expressions, with a number if necessary."""
    reserved = {*reserved_names(), *taken}
    name, number = wanted, 1
    while name in reserved or iskeyword(name):
        number += 1
        name = f"{wanted}_{number}"
    return name


def sorted_sections(document: Mapping[str, V]) -> dict[str, V]:
    """Return the sections of a file in their order."""
    order = [one for key in fragment_at(())["properties"] for one in (key, _BEHIND.get(key, key))]
    return _sorted(document, order)


def in_files(document: Mapping[str, V]) -> dict[str, dict[str, V]]:
    """Return the sections that have a file of their own, by the name of that file without its ending."""
    files: dict[str, dict[str, V]] = {name: {} for name in _ABOUT}
    for section, value in document.items():
        if file := PARTS if section == PARTS else fragment_at((section,)).get("x-file"):
            files.setdefault(file, {})[section] = value
    shared = {key: value for key, value in document.items() if key == _WITH_EACH}
    return {name: {**shared, **part} for name, part in files.items() if part}


def about(file: str, sections: Iterable[str]) -> str:
    """Return what the first line of a file says of it."""
    said: str = _ABOUT.get(file) or next(
        (fragment_at((one,)).get("description", one) for one in sections if one != _WITH_EACH), file
    )
    return said


def sorted_keys(entry: Mapping[str, V], path: Path) -> dict[str, V]:
    """Return an entry at a path of a description with its keys in their order."""
    return in_order(entry) if path[0] == LET else _sorted(entry, _order(fragment_at(path)))


def in_order(entry: Mapping[str, V]) -> dict[str, V]:
    """Return what is some piece of a link or a joint with its keys in their order."""
    return _sorted(entry, _words())


def is_default(path: Path, value: Any) -> bool:
    """Return True if a value is the default of the language."""
    default = fragment_at(path).get("default")
    return default is not None and not isinstance(value, bool) and bool(value == default)


def _sorted(values: Mapping[str, V], order: Iterable[str]) -> dict[str, V]:
    rank = {key: place for place, key in enumerate(order)}
    return dict(sorted(values.items(), key=lambda item: rank.get(item[0], _LAST)))


def _order(said: Mapping[str, Any]) -> Sequence[str]:
    order: Sequence[str] = said.get("x-first", tuple(said.get("properties", ())))
    return order


@cache
def _words() -> tuple[str, ...]:
    """Return the keys of links and joints, and of what they contain, in one order for all."""
    before: dict[str, list[str]] = {}
    for said in _pieces():
        for first, second in pairwise(_order(said)):
            before.setdefault(second, []).append(first)
    return tuple(TopologicalSorter(before).static_order())


def _pieces() -> Iterator[Mapping[str, Any]]:
    for section in ("links", "joints"):
        yield from _fragments((section, "*"))


def _fragments(path: Path) -> Iterator[Mapping[str, Any]]:
    """Yield the fragments of the schema for a value, and for all that it contains except under names."""
    said = fragment_at(path)
    yield said
    for step in (*said.get("properties", ()), *([0] if "items" in said else [])):
        yield from _fragments((*path, step))

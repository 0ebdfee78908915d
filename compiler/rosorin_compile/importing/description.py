"""Description: the plain tree of a robot as the files of a description, as a person would have written them.

``write`` says which file holds what, and ``named`` which values get a name
because they repeat.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.language.expression.functions import expression_names
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map, Path, Seq

from .key_order import about, in_files, is_default, sorted_keys, sorted_sections
from .layout import Expression, Verbatim, angle_of, layout, number, placed, within_part

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
    document = _Document(tree_of(imported)).made(wanted)
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

    def __init__(self, tree: Map) -> None:
        self.tree = tree
        self.named: Named = named(tree)

    def made(self, wanted: Outputs) -> dict[str, Any]:
        """Return the document of the whole description."""
        body = {key: self.value(value, (key,), span) for key, value, span in _items(self.tree) if value}
        lets: dict[str, Any] = {**self.named.folders, **body.pop("let", {})}
        if self.named.scale is not None:
            lets["mesh_scale"] = self.value(self.named.scale, ("let", "mesh_scale"), None)
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
            if path[-2:] == ("mesh", "scale") and self.named.scale is not None:
                return Expression("${mesh_scale}")
            return [self.value(v, (*path, i), s) for i, (v, s) in enumerate(zip(value, value.value_spans, strict=True))]
        if isinstance(value, str):
            file = self.named.file(value) if path[-2:] == ("mesh", "file") else None
            return Expression(file) if file else value if isinstance(value, (Expression, Verbatim)) else str(value)
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
            if rest != name and (isinstance(name, Expression) or not _needs_escape(rest)):
                return f"${{{key}}}/{rest}"
        return None


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
    sections = [tree, *(part for part in (tree.get("parts") or {}).values() if isinstance(part, Map))]
    for link in (link for section in sections for link in (section.get("links") or {}).values()):
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
    return folder if worth and not _needs_escape(folder) else ""


def _needs_escape(text: str) -> bool:
    return "${" in text or "$(" in text


def _common_scale(meshes: list[Map]) -> Seq | None:
    """Return the scale that all meshes have, None if they have different ones, none, or are few."""
    scales = [mesh.get("scale") for mesh in meshes]
    first: Any = scales[0] if len(scales) >= _FEW else None
    same = isinstance(first, Seq) and all(scale == first for scale in scales) and list(first) != [1, 1, 1]
    same = same and not any(isinstance(number, str) for number in first)  # a part has its own
    return first if same else None


def _identifier(text: str) -> str:
    """Return a name for expressions that is like a text."""
    made = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower()
    return made if made and not made[0].isdigit() else f"other_{made}".strip("_")


def _free(wanted: str, taken: dict[str, str]) -> str:
    """Return a name that no other value, unit or function has."""
    name, count, known = wanted, 1, expression_names()
    while name in taken or name in known.units or name in known.functions:
        count += 1
        name = f"{wanted}_{count}"
    return name

"""Write the plain tree of a robot as the files of a description: its sections and keys in the order of the schema.

``x-first`` of the schema names the keys that come first where the others stay as in the source; ``x-file`` is the file
of a section in a description of several.
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

from rosorin_compile.formats.imported_robot import Imported, Outputs
from rosorin_compile.language.expression.functions import reserved_names
from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map, Path, Seq

from .layout import Expression, Verbatim, angle_of, escape, layout, number, place_comments, within_part

# The files besides the first one, in their order, with what their first lines say; others follow.
_ABOUT = {
    "parts": "The parts: what the robot has several times, written once; robot.yaml uses them.",
    "links": "The links: masses, what they look like, what they collide with.",
    "joints": "The joints: how the links hang together.",
    "simulation": "What only a simulation has: how the robot stands, what drives it, what it measures and touches.",
    "sensors": "The sensors: what each measures, and what Gazebo has of it.",
    "control": "The hardware of ros2_control.",
    "extensions": "What the language has no word for, as it stood in the source.",
    "moveit": "What MoveIt has to know beside the URDF: groups of joints, end effectors, pairs that it need not check.",
}
_BEHIND = {"let": "parts", "joints": "use"}  # they hang on links, as joints do
_LAST = 1_000  # the place of keys that the schema does not have

V = TypeVar("V")
MAX_LINES = 150  # a longer description is split into files


def tree_of(imported: Imported) -> Map:
    """Return the tree of a source. Raises ValueError for a broken one, which has none."""
    return imported.whole


def write(imported: Imported, wanted: Outputs, schema: str = "", split: bool | None = None) -> dict[str, str]:
    """Return the files of a description, text by name; the first is ``robot.yaml``.

    The tree has to be there. ``schema`` is where editors find the schema, from the folder of the files. ``split`` says
    whether it is several files; without it a long one is. The result is the same for the same tree, whatever the
    machine.
    """
    document, root = _Document(imported.whole, imported.packages).build(wanted), Description.ROOT_FILE
    head = [f"yaml-language-server: $schema={schema}"] if schema else []

    def text(file: str, document: dict[str, Any], head: Sequence[str]) -> str:
        remarks = place_comments(imported.comments, document, head, file == root)
        if file == root and wanted.lines:
            remarks = remarks._replace(inside={**remarks.inside, ("outputs",): wanted.lines})
        return layout(document, remarks)

    is_short = sum(len(value) for value in document.values() if isinstance(value, dict)) <= MAX_LINES
    if split is False or (split is None and is_short):
        whole = text(root, document, head)
        if split is False or whole.count("\n") <= MAX_LINES:
            return {root: whole}
    parts: dict[str, dict[str, Any]] = {name: {} for name in _ABOUT}
    for section in list(document):
        if file := "parts" if section == "parts" else fragment_at((section,)).get("x-file"):
            parts.setdefault(file, {})[section] = document.pop(section)
    parts = {name: part for name, part in parts.items() if part}
    document["include"] = [f"{name}.yaml" for name in parts]
    files = {root: text(root, sorted_sections(document), head)}
    source = {"source": document["source"]} if "source" in document else {}
    for name, part in parts.items():
        about = _ABOUT.get(name) or fragment_at((next(iter(part)),)).get("description", name)
        files[f"{name}.yaml"] = text(f"{name}.yaml", {**source, **part}, [*head, about])
    return files


def lines_of(tree: Map) -> int:
    """Return how many lines some sections of a description take."""
    made = _Document(tree)
    return layout({key: made.value(value, (key,), None) for key, value in tree.items()}).count("\n")


class _Document:
    """Turns a tree into the values of a document."""

    def __init__(self, tree: Map, packages: Mapping[str, FilePath] = {}) -> None:
        self.tree, self.packages = tree, packages

    def build(self, wanted: Outputs) -> dict[str, Any]:
        """Return the document of the whole description."""
        items = ((key, value) for key, value in self.tree.items() if value)
        body = {key: self.value(value, (key,), self.tree.value_spans.get(key)) for key, value in items}
        document: dict[str, Any] = {"rosorin_compile": Verbatim("1"), **body}
        document["outputs"] = {name: _written(entry) for name, entry in wanted.entries.items()}
        return sorted_sections(document)

    def value(self, value: Any, path: Path, span: Span | None) -> Any:
        """Return one value as ``layout`` takes it."""
        if isinstance(value, Map):
            return self.mapping(value, path)
        if isinstance(value, Seq):
            return [self.value(v, (*path, i), s) for i, (v, s) in enumerate(zip(value, value.value_spans, strict=True))]
        if isinstance(value, str):
            return value if isinstance(value, Verbatim) else _in_packages(value, self.packages)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return number(value, span, angle_of(self.tree, path))
        return value

    def mapping(self, value: Map, path: Path) -> dict[str, Any]:
        """Return a mapping without defaults, with its keys in their order."""
        made: dict[str, Any] = {}
        own = within_part(path)
        for key, item in value.items():
            if not is_default((*own, key), item):
                found = self.value(item, (*path, key), value.value_spans.get(key))
                if found or key != "dynamics":
                    made[key] = found
        if len(own) == 1:
            return made
        return in_order(made) if own[0] == "let" else _sorted(made, _order(fragment_at(own)))


def _in_packages(text: str, packages: Mapping[str, FilePath]) -> str:
    """Return a text in which files are named by their package, not by their folder on this machine."""
    if not any(f"{folder}{os.sep}" in text for folder in packages.values()):
        return text if isinstance(text, Expression) else str(text)
    made = text if isinstance(text, Expression) else escape(text)
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
    return _sorted(document, [one for key in fragment_at(())["properties"] for one in (key, _BEHIND.get(key, key))])


def in_order(entry: Mapping[str, V]) -> dict[str, V]:
    """Return an entry of a link or a joint, or of what they contain, with its keys in their order."""
    return _sorted(entry, _words())


def is_default(path: Path, value: Any) -> bool:
    """Return True if a value is the default of the language."""
    default = fragment_at(path).get("default")
    return default is not None and not isinstance(value, bool) and bool(value == default)


def _sorted(values: Mapping[str, V], order: Iterable[str]) -> dict[str, V]:
    rank = {key: place for place, key in enumerate(order)}
    return dict(sorted(values.items(), key=lambda item: rank.get(item[0], _LAST)))


def _order(fragment: Mapping[str, Any]) -> Sequence[str]:
    order: Sequence[str] = fragment.get("x-first", tuple(fragment.get("properties", ())))
    return order


@cache
def _words() -> tuple[str, ...]:
    """Return the keys of links and joints, and of what they contain, in one order for all."""
    before: dict[str, list[str]] = {}
    for fragment in (*_fragments(("links", "*")), *_fragments(("joints", "*"))):
        for first, second in pairwise(_order(fragment)):
            before.setdefault(second, []).append(first)
    return tuple(TopologicalSorter(before).static_order())


def _fragments(path: Path) -> Iterator[Mapping[str, Any]]:
    """Yield the fragments of the schema for a value, and for all that it contains except under names."""
    fragment = fragment_at(path)
    yield fragment
    for step in (*fragment.get("properties", ()), *([0] if "items" in fragment else [])):
        yield from _fragments((*path, step))

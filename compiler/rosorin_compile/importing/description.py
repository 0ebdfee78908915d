"""Write the plain tree of a robot as the files of a description: its sections and keys in the order of the schema.

In the schema, ``x-first`` names the keys that come first (the others keep the order of the source), and ``x-file`` is
the file that a section is written to if the description is split into several files.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from graphlib import TopologicalSorter
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any, TypeVar

from rosorin_compile.formats.imported_robot import Imported, Outputs
from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map, Path

from .layout import Expression, Verbatim, angle_of, escape, layout, number, place_comments, within_part

# The files of a long description besides the first one, in their order; others follow.
_FILES = ("parts", "links", "joints", "simulation", "sensors", "control", "extensions", "moveit")
_BEHIND = {"let": "parts", "joints": "use"}  # they hang on links, as joints do
_LAST = 1_000  # the sort position of keys that are not in the schema
MAX_LINES = 150  # a longer description is split into files

V = TypeVar("V")


def tree_of(imported: Imported) -> Map:
    """Return the tree of a source. Raises ValueError if the source is broken and has no tree."""
    return imported.whole


def write(imported: Imported, wanted: Outputs, schema: str = "", split: bool | None = None) -> dict[str, str]:
    """Return the files of a description, text by name; the first is ``robot.yaml``.

    The robot must have a tree. ``schema`` is the path of the schema for editors, relative to the folder of the files.
    ``split`` determines whether several files are written; by default, a long description is split. The result for a
    tree is the same on every machine.
    """
    made, root = _Document(imported.whole, imported.packages), Description.ROOT_FILE
    body = {key: made.value(value, (key,)) for key, value in imported.whole.items() if value}
    body["outputs"] = {name: _written(entry) for name, entry in wanted.entries.items()}
    document: dict[str, Any] = sorted_sections({"rosorin_compile": Verbatim("1"), **body})

    def text(file: str, content: dict[str, Any]) -> str:
        remarks = place_comments(imported.comments, content, file == root)
        head = [f"yaml-language-server: $schema={schema}"] if schema else []
        remarks[()] = [*head, *remarks.get((), ())]
        if file == root and wanted.lines:
            remarks[("outputs",)] = [*remarks.get(("outputs",), ()), *wanted.lines]
        return layout(content, remarks)

    single = text(root, document)
    if split is False or (split is None and single.count("\n") <= MAX_LINES):
        return {root: single}
    parts: dict[str, dict[str, Any]] = {name: {} for name in _FILES}
    for section in list(document):
        if file := "parts" if section == "parts" else fragment_at((section,)).get("x-file"):
            parts.setdefault(file, {})[section] = document.pop(section)
    parts = {f"{name}.yaml": part for name, part in parts.items() if part}
    document["include"] = list(parts)
    source = {"source": document["source"]} if "source" in document else {}
    return {
        root: text(root, sorted_sections(document)),
        **{file: text(file, {**source, **part}) for file, part in parts.items()},
    }


def lines_of(tree: Mapping[str, Any]) -> int:
    """Return how many lines some sections of a description take."""
    made = _Document(tree)
    return layout({key: made.value(value, (key,)) for key, value in tree.items()}).count("\n")


class _Document:
    """Turns a tree into the values of a document."""

    def __init__(self, tree: Mapping[str, Any], packages: Mapping[str, FilePath] = {}) -> None:
        self.tree, self.packages = tree, packages

    def value(self, value: Any, path: Path, _: object = None) -> Any:
        """Return a value as ``layout`` expects it, without defaults and with keys in the order of the schema."""
        if isinstance(value, (list, tuple)):
            return [self.value(item, (*path, index)) for index, item in enumerate(value)]
        if isinstance(value, str):
            return value if isinstance(value, Verbatim) else _in_packages(value, self.packages)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return number(value, angle_of(self.tree, path))
        if not isinstance(value, Mapping):
            return value
        own = within_part(path)
        made = {
            key: shown
            for key, item in value.items()
            if not is_default((*own, key), item) and ((shown := self.value(item, (*path, key))) or key != "dynamics")
        }
        return made if len(own) == 1 else _sorted(made, _order(fragment_at(own)))


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
    return number(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else value


def sorted_sections(document: Mapping[str, V]) -> dict[str, V]:
    """Return the sections of a file in the order of the schema."""
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
    """Return the keys of links and joints, and of the elements in them, in one common order."""
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

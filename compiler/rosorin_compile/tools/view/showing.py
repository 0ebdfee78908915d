"""A robot as the data of its page: the model, where each frame is said, and its meshes."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, NamedTuple

from ...diagnostics import Diagnostic, has_errors
from ...diagnostics.console import Console
from ...formats.mesh_files import Places, files_of, named_meshes
from ...formats.page import MESHES
from ...formats.page.data import mesh_names, robot_data
from ...formats.page.seen import Data
from ...frontend.tree import Map, locate
from ...output.watch import mark
from ...project import Description
from ..given import Given
from ..robots import is_foreign
from ..understanding import read

if TYPE_CHECKING:
    from ...model import Robot
    from ...pipeline import Understood
    from ...rules.case import Case

_EXPLAINED = 300  # links; of more than that a page on disk does not say where each number comes from


class Shown(NamedTuple):
    """A robot to look at: the model, its data for the page, its mesh files by name, and what explains it."""

    robot: Robot
    data: Data
    meshes: Mapping[str, Path]
    understood: Understood
    arguments: Mapping[str, Any]

    def explained(self, frame: str) -> list[str]:
        """Return where the numbers of a frame come from, as ``explain`` says it; empty for a foreign robot."""
        from ..explain.answer import NotThere, explain
        from ..explain.text import lines

        expanded, lowered = self.understood.expanded, self.understood.lowered
        if expanded.scope is None or lowered is None:
            return []
        try:
            found = explain(expanded, lowered, self.arguments, [frame])
        except NotThere:
            return []
        return [line for one in found for line in lines(one)]

    def case(self) -> Case:
        """Return the robot with the places of all that it says, for checks."""
        from ...rules.case import Case
        from ...rules.remarkable import collect

        tree, lowered = self.understood.expanded.tree, self.understood.lowered
        assert tree is not None  # noqa: S101 - it was shown
        assert lowered is not None  # noqa: S101
        return Case(self.robot, tree, lowered.places, collect(tree))


class Looked(NamedTuple):
    """What became of the files: a robot to show, unless it has errors; what there is to say; and what was read."""

    shown: Shown | None
    diagnostics: list[Diagnostic]
    files: tuple[Path, ...]


def look(given: Given, description: Description, console: Console) -> Looked:
    """Read a robot, in any format, for its page. Raises LoadError for a file of arguments that is no good."""
    understood = read(given, description, console)
    expanded, lowered, diagnostics, _ = understood
    if lowered is None or lowered.robot is None or expanded.tree is None or has_errors(diagnostics):
        return Looked(None, diagnostics, expanded.files)
    places = Places(description.path, description.outputs, given.packages, os.environ)
    meshes = files_of(expanded.tree, (), places)
    data = robot_data(lowered.robot)
    foreign = is_foreign(description.path)
    for link in data["links"]:
        where = _where(understood, link["name"])
        if where is not None:
            link["where"] = where
    shown = Shown(lowered.robot, data, meshes, understood, {} if foreign else given.values())
    return Looked(shown, diagnostics, (*expanded.files, *meshes.values(), *_awaited(expanded.tree, meshes)))


def _awaited(tree: Map, meshes: Mapping[str, Path]) -> Iterator[Path]:
    """Yield where meshes would be that are not there: they may come."""
    for name, spans in named_meshes(tree):
        if name not in meshes and "://" not in name:
            yield from (Path(span.source.path).parent / name for span in spans)


def _where(understood: Understood, link: str) -> Data | None:
    """Return where a frame is said: file, line and column, and the path for an editor."""
    tree, lowered = understood.expanded.tree, understood.lowered
    if tree is None or lowered is None:
        return None
    path = lowered.places.get(("link", link))
    span = locate(tree, path, key=True).span if path is not None else None
    if span is None:
        return None
    return {
        "file": span.source.path,
        "line": span.line,
        "column": span.column,
        "path": os.path.abspath(span.source.path),
    }


def served(shown: Shown, numbers: dict[Path, str]) -> tuple[Data, dict[str, Path]]:
    """Return the meshes of a page by name, each at a number that is asked for; and the files by number.

    ``numbers`` has those of files that were shown before; new ones are added. What follows "?" tells one version of a
    file from the next, so that a page reads again only what has changed.
    """
    table: Data = {}
    files: dict[str, Path] = {}
    for name in mesh_names(shown.robot):
        kind, file = MESHES.get(PurePosixPath(name).suffix.lower()), shown.meshes.get(name)
        if kind is None or file is None:
            table[name] = {"missing": "not found" if file is None else "no browser reads it"}
            continue
        number = numbers.setdefault(file, str(len(numbers)))
        table[name] = {"format": kind, "url": f"mesh/{number}?{_version(file)}"}
        files[number] = file
    return table, files


def _version(file: Path) -> str:
    seen = mark(file)
    return "".join(f"{number:x}" for number in seen) if seen else "0"


def on_disk(shown: Shown, limit: int, with_meshes: bool) -> tuple[Data, dict[str, str]]:
    """Return the data of a page that stands alone, and why meshes are left out of it; ``limit`` in bytes."""
    from ...formats.page import embedded

    data = dict(shown.data)
    left: dict[str, str] = {}
    if with_meshes:
        data["meshes"], left = embedded(shown.robot, shown.meshes, limit)
    links = []
    for link in data["links"]:
        place = {key: value for key, value in link.get("where", {}).items() if key != "path"}  # of this machine
        said = shown.explained(link["name"]) if len(data["links"]) <= _EXPLAINED else []
        links.append({**link, **({"where": place} if place else {}), **({"said": said} if said else {})})
    return {**data, "links": links}, left

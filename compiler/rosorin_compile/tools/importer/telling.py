"""Telling: what became of a source, in a few lines for the person who imports it.

``renamed`` makes the names of meshes and textures, which are relative to the source, such that readers find them.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ...diagnostics import WARNING, Diagnostic, Span
from ...diagnostics.registry import READING, Rule
from ...diagnostics.wording import counted, first_of
from ...frontend.expand.prefixing import moved, relative_files
from ...frontend.tree import Map, Seq
from ...project import DESCRIPTIONS, OUTPUTS, is_file
from ...startup.records import NamedTuple

RULES = (
    Rule(
        "import-mesh-path",
        "A warning: meshes or textures are named as seen from the source; the artifacts stand elsewhere. Or "
        "`--meshes` for a robot without such names.",
        "`--meshes FOLDER`, as seen from the artifacts, or `--meshes package://NAME`.",
        READING,
    ),
)


_TAG = re.compile(r"<([^\s/>!?]+)")
_FEW = 3


def sizes(tree: Map) -> str:
    """Return how many links and joints a robot has."""
    links, joints = len(tree.get("links") or ()), len(tree.get("joints") or ())
    return f"{counted(links, 'link')}, {counted(joints, 'joint')}"


def repeated(tree: Map, reordered: bool) -> list[str]:
    """Return the lines about the parts that were made of what a robot has several times; none without any.

    Who reads a vector of joint positions by the order of the file has to know that it is another one.
    """
    bodies = [tree, *(tree.get("parts") or {}).values()]
    uses = Counter(use["part"] for body in bodies for use in (body.get("use") or {}).values())
    if not uses:
        return []
    lines = ["parts: " + ", ".join(f"{part} ({counted(count, 'use')})" for part, count in uses.items())]
    return [*lines, "the joints come in another order than in the source; --no-parts keeps it"] if reordered else lines


def kept(tree: Map) -> list[str]:
    """Return the line about elements that stand in the description as they stood in the source; none without any."""
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


def _elements(node: Any) -> Iterator[str]:
    """Yield every element that is kept, in the order of the tree."""
    if isinstance(node, Map):
        for key, value in node.items():
            if key in ("urdf_elements", "mjcf_elements") and isinstance(value, Seq):
                yield from value
            else:
                yield from _elements(value)
    elif isinstance(node, Seq):
        for item in node:
            yield from _elements(item)


def _tag(text: str) -> str:
    found = _TAG.search(text)
    return found[1] if found else "text"


_RULE = "import-mesh-path"


class Renamed(NamedTuple):
    """The tree of a robot with the names that its description gets, and what there is to say about them."""

    tree: Map
    diagnostics: list[Diagnostic]


def renamed(tree: Map, source: Path, folder: Path, meshes: str | None) -> Renamed:
    """Return a robot whose relative names of files have ``meshes`` before them; without it, warn of them, once.

    ``source`` is the file that the robot was read from, ``folder`` where its description is going to stand. Nothing is
    lost where the names stay as they are: that is no ``import-cannot-carry``.
    """
    files = relative_files(tree)
    span = tree.value_spans.get("robot", tree.span)
    if meshes is not None:
        message = f"{source.name} names no mesh or texture by a relative path: --meshes changes nothing"
        ignored = [] if files else [Diagnostic(_RULE, WARNING, message, span, (), "leave --meshes out")]
        return Renamed(moved(tree, meshes), ignored)
    if not files:
        return Renamed(tree, [])
    return Renamed(_away_from_meshes(tree, source, folder), [_warning(files, source, folder, span)])


def _away_from_meshes(tree: Map, source: Path, folder: Path) -> Map:
    """Return the tree with a word on the meshes that are not where its artifacts are going to look for them."""
    from ...formats.mesh_files import named_meshes

    near = (folder, _artifacts(folder))
    names = [one.name for one in named_meshes(tree) if "://" not in one.name and not one.name.startswith("/")]
    if all(any(is_file(place / name) for place in near) for name in names):
        return tree
    made, entry, span = Map(tree.span, tree.via), Map(tree.span), tree.span
    for key, value in tree.items():
        made.put(key, value, tree.key_spans[key], tree.value_spans[key])
    entries = Seq(span)
    for one in tree.get("accept") or ():
        entries.put(one, span)
    entry.put("rule", "mesh-not-found", span, span)
    entry.put("reason", f"its meshes are beside {source.name}", span, span)
    entries.put(entry, span)
    made.put("accept", entries, span, span)
    return made


def _warning(files: list[str], source: Path, folder: Path, span: Span) -> Diagnostic:
    message = (
        f"files of meshes or textures are named as seen from {source.name}, but readers look from the artifacts: "
        f"{first_of(files, 1)}"
    )
    help = "import again with --meshes FOLDER, as seen from the artifacts, or --meshes package://NAME"
    artifacts = _artifacts(folder)
    if os.path.exists(source.parent / files[0]):  # noqa: PTH110 - a name that is too long for a file is no error here
        where = Path(os.path.relpath(source.parent, artifacts)).as_posix()
        help = f"import again with --meshes {where}, which is right for {artifacts.as_posix()}, or package://NAME"
    return Diagnostic(_RULE, WARNING, message, span, (), help)


def _artifacts(folder: Path) -> Path:
    """Return where the artifacts of a description stand unless somebody says so (see ``project``)."""
    own = Path(os.path.abspath(folder))
    base = folder.parent.parent if own.parent.name == DESCRIPTIONS else Path()
    return base / OUTPUTS / own.name

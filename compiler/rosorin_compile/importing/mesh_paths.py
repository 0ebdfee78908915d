"""Mesh paths: relative names of meshes and textures are relative to the source, but readers look from the artifacts."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

from ..diagnostic import WARNING, Diagnostic, Span
from ..expand.mesh_names import moved, relative_files
from ..project import DESCRIPTIONS, OUTPUTS
from ..registry import READING, Rule
from ..tree import Map
from ..wording import first_of

RULES = (
    Rule(
        "import-mesh-path",
        "A warning: meshes or textures are named as seen from the source; the artifacts stand elsewhere. Or "
        "`--meshes` for a robot without such names.",
        "`--meshes FOLDER`, as seen from the artifacts, or `--meshes package://NAME`.",
        READING,
    ),
)

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
    return Renamed(tree, [_warning(files, source, folder, span)] if files else [])


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
    """Return where the artifacts of a description stand unless somebody says so (see project.py)."""
    own = Path(os.path.abspath(folder))
    base = folder.parent.parent if own.parent.name == DESCRIPTIONS else Path()
    return base / OUTPUTS / own.name

"""Mesh files: each mesh that a description names is looked for, and what is not found is told with its place.

A mesh is looked for where the artifact that opens it will (``Format.opens``), and where its description can mean it:

- a relative name: beside the file of the description that names it, beside its first file, as seen from that artifact;
- ``package://NAME/...``: in the folder that ``packages`` finds for NAME (see there), from the file that names it on;
- a path or ``file://``: there.

The artifact names a file below its own folder, and that name follows from the description alone: relative names are
as they were written, those of packages are ``meshes/NAME/...``. What was found elsewhere is brought there by who writes
the artifacts. So a folder of artifacts is complete: where it is kept with its meshes, it is the same on a machine that
has none of the packages. What is found nowhere is left out of artifacts that could not be opened without it, and told.
"""

from __future__ import annotations

import os
import posixpath
import stat
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple
from urllib.parse import unquote

from ..diagnostics import ERROR, NOTE, WARNING, Diagnostic, Span, and_here
from ..diagnostics.registry import FORMATS, Rule
from ..diagnostics.wording import first_of
from ..frontend.tree import Map, Seq
from ..model import Output
from ..project import shown
from . import FORMATS as RECORDS
from .packages import Packages

RULES = (
    Rule(
        "mesh-not-found",
        "A mesh is not found. An error where a relative name leads nowhere and the MJCF needs it, a warning where it "
        "is left out of the MJCF, a note where the URDF alone names it: its readers may find it on their machine.",
        "Correct the name, put the file there, or say where the package is: `--package NAME=FOLDER`.",
        FORMATS,
    ),
    Rule(
        "mesh-not-a-file",
        "A mesh is a folder, a pipe or a device.",
        "Name a regular file.",
        FORMATS,
    ),
)

_PUT = "put the file beside the description, or correct the name"
_SHOWN = 3  # files named of many
_HERE, _NOT_THERE, _ODD = range(3)


class Named(NamedTuple):
    """A mesh as a description names it, and the places where it does."""

    name: str
    spans: list[Span]


class Found(NamedTuple):
    """A mesh that was found: as the description names it, its file, and by which names artifacts open it.

    Those are seen from the folder of the artifacts; ``places`` are those that stand in it.
    """

    named: Named
    file: Path
    places: tuple[str, ...]


class Searched(NamedTuple):
    """What became of the meshes of a robot.

    ``missing`` are the names of those that no artifact can open, ``searched`` says that packages were looked for where
    the environment says: what is found may be another file the next time. ``files`` are those that belong to the set of
    artifacts, bytes by name.
    """

    found: tuple[Found, ...]
    missing: frozenset[str]
    diagnostics: list[Diagnostic]
    searched: bool = False
    files: Mapping[str, bytes] = MappingProxyType({})


class Places(NamedTuple):
    """Where to look: the first file of the description, the folder of its artifacts, folders of packages by name."""

    description: Path
    outputs: Path
    packages: Mapping[str, Path]
    environment: Mapping[str, str]


def search(tree: Map, outputs: Sequence[Output], places: Places) -> Searched:
    """Look for all meshes that a description names, for the artifacts that are made of it."""
    opening = [output for output in outputs if RECORDS[output.backend].opens is not None]
    naming = [output for output in outputs if RECORDS[output.backend].meshes]
    named = list(named_meshes(tree))
    if not named or not (opening or naming):
        return Searched((), frozenset(), [])
    return _Search(places, opening, naming).run(named)


def named_meshes(tree: Map) -> Iterator[Named]:
    """Yield the meshes of a description, each name once."""
    found: dict[str, list[Span]] = {}
    waiting: list[Any] = [value for key, value in tree.items() if key != "outputs"][::-1]
    while waiting:
        node = waiting.pop()
        if isinstance(node, Map):
            mesh = node.get("mesh")
            if isinstance(mesh, Map) and isinstance(mesh.get("file"), str):
                found.setdefault(mesh["file"], []).append(mesh.value_spans["file"])
            waiting += list(node.values())[::-1]
        elif isinstance(node, Seq):
            waiting += list(node)[::-1]
    return (Named(name, list(dict.fromkeys(spans))) for name, spans in found.items())


class _Search:
    """Looks for meshes, and gathers what there is to say by its cause."""

    def __init__(self, places: Places, opening: Sequence[Output], naming: Sequence[Output]) -> None:
        self.places, self.opening, self.naming = places, opening, naming
        self.finders: dict[Path, Packages] = {}
        self.found: list[Found] = []
        self.missing: list[str] = []
        self.diagnostics: list[Diagnostic] = []
        self.absent: dict[tuple[str, str, str], list[Named]] = {}  # by the message, the way out and the severity
        self.searched = False

    def run(self, named: Sequence[Named]) -> Searched:
        for one in named:
            self._look(one)
        for (what, help, severity), many in self.absent.items():
            self.diagnostics.append(told("mesh-not-found", what, help, severity, many))
        return Searched(tuple(self.found), frozenset(self.missing), self.diagnostics, self.searched)

    def _look(self, one: Named) -> None:
        wanted = {
            posixpath.normpath(posixpath.join(_folder(o), name)) for o in self.opening if (name := _opened(o, one))
        }
        file = self._file(one, wanted)
        if file is None or (self.opening and not wanted):
            self.missing.append(one.name)
        if file is not None and wanted:
            inside = tuple(name for name in sorted(wanted) if not (name.startswith(("/", "../")) or name == ".."))
            self.found.append(Found(one, file, inside))

    def _file(self, one: Named, wanted: Collection[str]) -> Path | None:
        """Return the file of a mesh; None if there is none, and then that is told."""
        scheme, mark, rest = one.name.partition("://")
        if mark and scheme in ("package", "model"):
            candidates = [*self._in_packages(one, rest), *(self.places.outputs / name for name in sorted(wanted))]
        elif mark and scheme != "file":
            if self.opening:
                self._absent(one, f"no file{self._left()}", "name a file, or package://NAME/FILE", WARNING)
            return None
        elif mark or one.name.startswith("/"):
            candidates = [Path(unquote(rest) if mark else one.name)]
        else:
            # What was brought beside the artifacts may be older than what it was brought from. What they name outside
            # of their folder is never brought: there they have to find it themselves.
            outside = posixpath.normpath(one.name).startswith("../") and bool(self.opening)
            candidates = [] if outside else [folder / one.name for folder in self._beside(one)]
            candidates += [self.places.outputs / _folder(o) / one.name for o in (*self.opening, *self.naming)]
            candidates += [self.places.outputs / name for name in sorted(wanted)]
        odd = None
        for candidate in candidates:
            # The folder of the artifacts may not be there yet: ".." leads out of it all the same.
            path = Path(os.path.normpath(candidate))
            kind = _kind(path)
            if kind == _HERE:
                return path
            odd = odd or (path if kind == _ODD else None)
        self._missing(one, scheme if mark else "", rest, odd)
        return None

    def _beside(self, one: Named) -> list[Path]:
        folders = [Path(span.source.path).parent for span in one.spans]
        return list(dict.fromkeys([*folders, self.places.description.parent]))

    def _in_packages(self, one: Named, rest: str) -> Iterator[Path]:
        name, _, path = rest.partition("/")
        self.searched = self.searched or name not in self.places.packages
        if not path or ".." in path.split("/"):
            return
        for folder in self._beside(one):
            package = self._finder(folder).find(name)
            if package is not None:
                yield package / path

    def _finder(self, folder: Path) -> Packages:
        if folder not in self.finders:
            self.finders[folder] = Packages(self.places.packages, self.places.environment, folder / "robot.yaml")
        return self.finders[folder]

    def _missing(self, one: Named, scheme: str, rest: str, odd: Path | None) -> None:
        """Say that a mesh is not found, or is no file."""
        severity = WARNING if self.opening else NOTE
        if odd is not None:
            message, help = f"mesh {one.name} is no regular file: {shown(odd)}", "name a file"
            self.diagnostics.append(Diagnostic("mesh-not-a-file", ERROR, message, one.spans[0], (), help))
        elif scheme in ("package", "model"):
            name = rest.partition("/")[0]
            if any(self._finder(folder).find(name) is not None for folder in self._beside(one)):
                self._absent(one, f"not in the package {name}{self._left()}", "correct the name", WARNING)
            else:
                help = f"--package {name}=FOLDER says where it is; readers of the URDF look for it themselves"
                self._absent(one, f"not found: there is no package {name} here{self._left()}", help, severity)
        elif scheme or one.name.startswith("/"):
            self._absent(one, f"not on this machine{self._left()}", "correct the name", severity)
        else:
            outside = posixpath.normpath(one.name).startswith("../")
            what = "not there, neither as seen from the artifacts nor beside the description"
            what = "not there, as seen from the artifacts" if outside and self.opening else what
            help = "put the file there, or correct the name" if outside else _PUT
            help += ", or take mjcf out of outputs" if self.opening else ""
            self._absent(one, what, help, ERROR if self.opening else WARNING)

    def _left(self) -> str:
        """Return which artifacts go without a mesh, as the end of a sentence."""
        files = first_of([output.file for output in self.opening], 2)
        return f", and left out of {files}" if files else ""

    def _absent(self, one: Named, what: str, help: str, severity: str) -> None:
        self.absent.setdefault((what, help, severity), []).append(one)


def told(rule: str, what: str, help: str, severity: str, many: Sequence[Named]) -> Diagnostic:
    """Return what there is to say of meshes for one reason, with the places of all of them."""
    names, spans = [one.name for one in many], [span for one in many for span in one.spans]
    which = f"mesh {names[0]} is" if len(names) == 1 else f"{len(names)} meshes ({first_of(names, _SHOWN)}) are"
    return Diagnostic(rule, severity, f"{which} {what}", spans[0], and_here(spans[1:]), help)


def _folder(output: Output) -> str:
    """Return the folder of an artifact below that of all."""
    return posixpath.dirname(output.file)


def _opened(output: Output, one: Named) -> str:
    opens = RECORDS[output.backend].opens
    return opens(one.name) if opens is not None else ""


def _kind(path: Path) -> int:
    """Return whether a path leads to a regular file, to nothing, or to what is no file."""
    try:
        mode = os.stat(path).st_mode  # noqa: PTH116 - no Path of a name that no file can have
    except (OSError, ValueError):
        return _NOT_THERE
    return _HERE if stat.S_ISREG(mode) else _ODD

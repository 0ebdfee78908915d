"""Mesh files: each mesh that a description names is looked for, and what is not found is told with its place.

So is each texture that an artifact opens, or that is embedded. A file is looked for where the artifact that opens it
will (``Format.opens``), and where its description can mean it:

- a relative name: beside the file of the description that names it, beside its first file, in the ``folder`` that the
  ``source`` of that file says, in those around a robot that is included, as seen from that artifact;
- ``package://NAME/...``: in the folder that the ``source`` of the file that names it says for NAME, and in that which
  ``packages`` finds (see there), from that file on;
- a path or ``file://``: there.

So is what an element of ``mjcf_elements`` names: a skin, a height field, a texture. The MJCF has that name as it is,
and MuJoCo does not load it without the file.

The artifact names a file below its own folder, and that name follows from the description alone: relative names are
as they were written, those of packages are ``meshes/NAME/...``. What was found elsewhere is brought there by who writes
the artifacts; a URDF or an SDF has relative names beside it, too. So a folder of artifacts is complete: where it is
kept with its meshes, it is the same on a machine that has none of the packages. What is found nowhere is left out of
artifacts that could not be opened without it, and told.
"""

from __future__ import annotations

import os
import posixpath
from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple
from urllib.parse import unquote

from rosorin_compile.language.suppressions import EVERYTHING
from rosorin_compile.model import Output, Robot
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Span
from rosorin_compile.source.files import shown
from rosorin_compile.source.messages import and_here
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import ENDINGS, MESH_FILE, ROS_PACKAGE, Resolved, resolved
from rosorin_compile.source.rule_registry import FORMATS, Rule
from rosorin_compile.source.tree import Map
from rosorin_compile.source.wording import first_of

from . import FORMATS as RECORDS
from .named_files import (
    MESH,
    OF_ELEMENT,
    OF_MESH,
    TEXTURE,
    Named,
    Written,
    is_relative,
    named_in_elements,
    named_meshes,
    named_textures,
    references,
    urdf_file_name,
    written,
)

RULES = (
    Rule(
        "mesh-not-found",
        "A mesh or a texture is not found. An error where the relative name of a mesh leads nowhere and the MJCF needs "
        "it, a warning where it is left out of the MJCF, as that of an imported robot, or where `import` looks, a "
        "note where the URDF alone names it: its readers may find it on their machine.",
        "Correct the name, put the file there, or say where the package is: `--package NAME=FOLDER`.",
        FORMATS,
        accept="robot",
        imported="always",
        asked="meshes",
    ),
    Rule(
        "element-file-not-found",
        "A file that an element of `mjcf_elements` names is not found, and MuJoCo would not load the MJCF.",
        "Put the file there, or correct the name.",
        FORMATS,
        asked="meshes",
    ),
    Rule(
        "mesh-not-a-file",
        "A mesh or a texture is a folder, a pipe or a device.",
        "Name a regular file.",
        FORMATS,
        asked="meshes",
    ),
    Rule(
        "mesh-ambiguous",
        "Two files of a description would be one file beside its artifacts, and they are not the same. A warning where "
        "the URDF alone names them.",
        "Give one of them another name.",
        FORMATS,
        asked="meshes",
    ),
)

_SEVERAL = {MESH: "meshes", TEXTURE: "textures", OF_ELEMENT: "files", OF_MESH: "files of meshes"}

# The errors about meshes that a description may accept, such as one that was imported away from its meshes.
ACCEPTABLE = {rule.id: rule for rule in RULES if rule.accept}

_PUT = "put the file beside the description, or correct the name"
_SHOWN = 3  # files named of many
_MOST_ABOVE = 4  # folders above that of an included robot that its meshes are named from
_HERE, _NOT_THERE, _ODD = range(3)


class Found(NamedTuple):
    """A mesh that was found: as the description names it, its file, and by which names artifacts open it.

    Those are seen from the folder of the artifacts; ``places`` are those that stand in it, ``beside`` those by which
    the others name it, which is read as it is.
    """

    named: Named
    file: Path
    places: tuple[str, ...]
    beside: tuple[str, ...] = ()


class Searched(NamedTuple):
    """What became of the meshes of a robot.

    ``missing`` are the names of those that no artifact can open, ``by_name`` has the file of each that was found,
    whoever opens it. ``inputs`` are the files whose contents say what becomes of the artifacts, ``resolved`` where
    names led, also those that led nowhere: the next time another file may be there. ``files`` are those that belong to
    the set of artifacts, bytes by name.
    """

    found: tuple[Found, ...]
    missing: frozenset[str]
    diagnostics: list[Diagnostic]
    by_name: Mapping[str, Path] = MappingProxyType({})
    inputs: tuple[Path, ...] = ()
    resolved: tuple[Resolved, ...] = ()
    files: Mapping[str, bytes] = MappingProxyType({})
    acceptable: Mapping[str, Rule] = ACCEPTABLE

    def told_to(self, robot: Robot) -> Robot:
        """Return a robot that knows what became of its meshes."""
        opened = {one.named.name: one.places[0] for one in self.found if one.places and one.places[0] in self.files}
        contents = {name: (self.files[place], Path(place).suffix.lower()) for name, place in opened.items()}
        return replace(robot, missing_meshes=self.missing, mesh_files=self.by_name, mesh_contents=contents)


class Places(NamedTuple):
    """Where to look: the first file of the description, the folder of its artifacts, folders of packages by name."""

    description: Path
    outputs: Path
    packages: Mapping[str, Path]
    environment: Mapping[str, str]

    def meshes(self, tree: Map, outputs: Sequence[Output] = ()) -> Mapping[str, Path]:
        """Return the files of all meshes that are found, by their names in a description; also if no artifact has any.

        ``outputs`` are those of the robot.
        """
        opening = [output for output in outputs if RECORDS[output.backend].opens is not None]
        naming = [output for output in outputs if RECORDS[output.backend].meshes]
        return _Search(self, opening, naming, written(tree)).run(list(named_meshes(tree))).by_name

    def named(self, tree: Map, relative: bool = True) -> Searched:
        """Return what becomes of the meshes and textures of a robot of others, as they are named in its file.

        Without ``relative`` names that are relative to that file are left aside.
        """
        named = [one for one in (*named_meshes(tree), *named_textures(tree)) if relative or not is_relative(one.name)]
        searched = _Search(self, [], []).run(named)
        told = [d if d.severity == ERROR else replace(d, severity=WARNING) for d in searched.diagnostics]
        return searched._replace(diagnostics=told)

    def textures(self, tree: Map) -> Mapping[str, Path]:
        """Return the files of all images that are found, by their names in a description."""
        return _Search(self, [], [], written(tree)).run(named_textures(tree)).by_name

    def awaited(self, tree: Map, found: Container[str]) -> Iterator[Path]:
        """Yield where meshes would be that were not ``found``: they may come."""
        for one in named_meshes(tree):
            if one.name not in found and "://" not in one.name:
                yield from (Path(span.source.path).parent / one.name for span in one.spans)


def search(tree: Map, outputs: Sequence[Output], places: Places) -> Searched:
    """Look for all meshes that a description names, and textures, for the artifacts that are made of it."""
    opening = [output for output in outputs if RECORDS[output.backend].opens is not None]
    measuring = [output for output in outputs if RECORDS[output.backend].measures]
    naming = [*(output for output in outputs if RECORDS[output.backend].meshes), *measuring]
    embedding = any(RECORDS[output.backend].embeds for output in outputs)
    named = list(named_meshes(tree))
    textures = named_textures(tree)
    # A URDF alone asks for none.
    near = bool(opening) and any(RECORDS[output.backend].meshes for output in naming)
    named += [
        one
        for one in textures
        if (near and is_relative(urdf_file_name(one.name))) or any(opened_by(output, one.name) for output in opening)
    ]
    named += named_in_elements(tree) if opening else []
    images = places.textures(tree) if embedding else {}
    if not (named or images) or not (opening or naming or embedding):
        return Searched((), frozenset(), [])
    found = _Search(places, opening, naming, written(tree)).run(named)
    if measuring:
        found = found._replace(inputs=tuple(dict.fromkeys((*found.inputs, *found.by_name.values()))))
    if not embedding:
        return found
    by_name = {**images, **found.by_name}
    return found._replace(by_name=by_name, inputs=(*found.inputs, *by_name.values()))


class _Search:
    """Looks for meshes, and gathers what there is to say by its cause."""

    def __init__(
        self,
        places: Places,
        opening: Sequence[Output],
        naming: Sequence[Output],
        written: Mapping[Path, Written] = MappingProxyType({}),
    ) -> None:
        self.places, self.opening, self.naming, self.written = places, opening, naming, written
        self.finders: dict[Path, Packages] = {}
        self.found: list[Found] = []
        self.by_name: dict[str, Path] = {}
        self.taken: dict[str, tuple[Named, Path]] = {}  # the meshes by their names beside the artifacts
        self.inputs: dict[Path, None] = {}
        self.resolved: dict[Resolved, None] = {}
        self.missing: list[str] = []
        self.diagnostics: list[Diagnostic] = []
        # By the message, the way out, the severity and the kind.
        self.absent: dict[tuple[str, str, str, str], list[Named]] = {}

    def run(self, named: Sequence[Named]) -> Searched:
        for one in named:
            self._look(one)
        for (what, help, severity, kind), many in self.absent.items():
            rule = "element-file-not-found" if kind == OF_ELEMENT else "mesh-not-found"
            self.diagnostics.append(files_diagnostic(rule, what, help, severity, many))
        missing, led = frozenset(self.missing), tuple(self.resolved)
        return Searched(tuple(self.found), missing, self.diagnostics, self.by_name, tuple(self.inputs), led)

    def _look(self, one: Named) -> None:
        wanted = {name for output in self.opening if (name := opened_by(output, one.name, one.kind))}
        file = self._file(one, wanted)
        if file is None or (self.opening and not wanted):
            self.missing.append(one.name)
        if file is None:
            return
        self.by_name[one.name] = file
        self._meant(one, file)
        name = urdf_file_name(one.name)
        named = self._beside_artifacts(name) if is_relative(name) and one.kind != OF_ELEMENT else set()
        if wanted or named:
            inside, near = ([name for name in sorted(names) if _is_inside(name)] for names in (wanted, named))
            self.found.append(Found(one, file, tuple(inside), tuple(near)))
            self.inputs[file] = None
            for place in dict.fromkeys((*inside, *near)):
                self._alone(place, one, file)
            if one.kind == MESH:
                self._follow(one, file, [*inside, *near])

    def _follow(self, one: Named, mesh: Path, places: Sequence[str]) -> None:
        """Add the files that a mesh file names: they are copied with it, unless it is converted."""
        copies = [place for place in dict.fromkeys(places) if Path(place).suffix.lower() == mesh.suffix.lower()]
        for name in references(mesh) if copies else ():
            file = mesh.parent / name
            self.inputs[file] = None
            inner = Named(name, one.spans, OF_MESH)
            if not self._is_here(file):
                what = f"not there, and {posixpath.basename(one.name)} names it"
                self._absent(inner, what, "put the file beside the mesh, or export the mesh again", WARNING)
                continue
            near = [posixpath.normpath(posixpath.join(posixpath.dirname(place), name)) for place in copies]
            self.found.append(Found(inner, file, (), tuple(filter(_is_inside, near))))
            for place in filter(_is_inside, near):
                self._alone(place, inner, file)

    def _beside_artifacts(self, name: str) -> set[str]:
        """Return by which relative names artifacts name a mesh that they do not open, seen from the folder of all."""
        naming = [output for output in self.naming if RECORDS[output.backend].meshes]
        return {posixpath.normpath(posixpath.join(_folder(output), name)) for output in naming}

    def _meant(self, one: Named, file: Path) -> None:
        """Tell it where a name means another file in one file of the description than in the others."""
        folders = dict.fromkeys(Path(span.source.path).parent for span in one.spans)
        if len(folders) == 1 or one.name.startswith("/") or self._is_outside(one):
            return
        scheme, mark, rest = one.name.partition("://")
        if mark and scheme not in ("package", "model"):
            return
        for folder in folders:
            within = [folder, self.places.description.parent]
            own = self._in_packages(within, rest) if mark else (place / one.name for place in within)
            other = next((path for path in map(_plain, own) if self._is_here(path)), file)
            if self._differ(file, other):
                span = next(span for span in one.spans if Path(span.source.path).parent == folder)
                made = ", ".join(output.file for output in self.opening or self.naming)
                what = f"{one.kind} {one.name} would be two files beside {made}" if self.opening else ""
                what = what or f"{one.kind} {one.name} is two files, and one name in {made}"
                self._ambiguous(f"{what}: {shown(other)} here, {shown(file)} elsewhere", span, one)
                return

    def _alone(self, place: str, one: Named, file: Path) -> None:
        """Tell it where two names of a description are one file beside the artifacts."""
        first, other = self.taken.setdefault(place, (one, file))
        beside = self.places.outputs / place
        if _plain(beside) not in (_plain(file), _plain(other)) and self._differ(other, file):
            what = f"{_SEVERAL[one.kind]} {first.name} and {one.name} would both be {place} beside the artifacts"
            self._ambiguous(f"{what}, and differ", one.spans[0], first)

    def _differ(self, one: Path, other: Path) -> bool:
        """Say whether two files are not the same, by their bytes; from now on both count."""
        if one == other:
            return False
        self.inputs.update({one: None, other: None})
        try:
            return not (
                files.same_file(one, other)
                or (one.stat().st_size == other.stat().st_size and files.read_bytes(one) == files.read_bytes(other))
            )
        except OSError:
            return True

    def _ambiguous(self, message: str, span: Span, first: Named) -> None:
        severity, help = ERROR if self.opening else WARNING, "give one of the two files another name"
        related = (Related("and here", first.spans[0]),)
        self.diagnostics.append(Diagnostic("mesh-ambiguous", severity, message, span, related, help))

    def _file(self, one: Named, wanted: Collection[str]) -> Path | None:
        """Return the file of a mesh; None if there is none, and then that is told."""
        scheme, mark, rest = one.name.partition("://")
        candidates: Iterator[Path]
        if mark and scheme in ("package", "model"):
            rest = rest.lstrip("/")  # some write package:///NAME/FILE, and their readers take it
            beside = (self.places.outputs / name for name in sorted(wanted))
            candidates = chain(self._in_packages(self._beside(one), rest), beside)
        elif mark and scheme != "file":
            if self.opening:
                self._absent(one, f"no file{self._left()}", "name a file, or package://NAME/FILE", WARNING)
            return None
        elif mark or one.name.startswith("/"):
            candidates = iter([Path(unquote(rest) if mark else one.name)])
        else:
            # What was brought beside the artifacts may be older than what it was brought from. What they name outside
            # of their folder is never brought: there they have to find it themselves.
            folders = [] if self._is_outside(one) else [*self._beside(one), *self._folders(one), *_around(one)]
            near = [folder / one.name for folder in folders]
            near += [self.places.outputs / _folder(o) / one.name for o in (*self.opening, *self.naming)]
            candidates = iter([*near, *(self.places.outputs / name for name in sorted(wanted))])
        odd = None
        for path in map(_plain, candidates):
            if self._is_here(path):
                return path
            odd = odd or (path if _kind(path) == _ODD else None)
        self._missing(one, scheme if mark else "", rest, odd)
        return None

    def _is_outside(self, one: Named) -> bool:
        return posixpath.normpath(one.name).startswith("../") and bool(self.opening)

    def _is_here(self, path: Path) -> bool:
        """Say whether there is a file. The next run has to find the same, or else to look anew."""
        is_here = _kind(path) == _HERE
        self.resolved[resolved(MESH_FILE, os.path.abspath(path), "", path if is_here else None)] = None
        return is_here

    def _beside(self, one: Named) -> list[Path]:
        folders = [Path(span.source.path).parent for span in one.spans]
        return list(dict.fromkeys([*folders, self.places.description.parent]))

    def _written(self, folder: Path) -> Written:
        """Return what is written about meshes in a folder of the description, or else in that of its first file."""
        none = Written([], {})
        return self.written.get(folder) or self.written.get(self.places.description.parent) or none

    def _folders(self, one: Named) -> list[Path]:
        """Return the folders that the files which name a mesh say for relative names."""
        return [place for folder in self._beside(one) for place in self._written(folder).folders]

    def _in_packages(self, folders: Sequence[Path], rest: str) -> Iterator[Path]:
        name, _, path = rest.partition("/")
        if not path or ".." in path.split("/"):
            return
        for folder in folders:
            said = self._written(folder).packages.get(name)
            if said is not None and name not in self.places.packages:
                yield said / path
            package = self._package(folder, name)
            if package is not None:
                yield package / path

    def _package(self, folder: Path, name: str) -> Path | None:
        """Return the folder of a package as seen from a folder of the description."""
        by = folder / "robot.yaml"
        if folder not in self.finders:
            self.finders[folder] = Packages(self.places.packages, self.places.environment, by)
        found = self.finders[folder].find(name)
        if name not in self.places.packages:
            self.resolved[resolved(ROS_PACKAGE, name, by, found)] = None
        return found

    def _is_known(self, folder: Path, name: str) -> bool:
        """Say whether there is a package as seen from a folder of the description."""
        said = self._written(folder).packages.get(name)
        return self._package(folder, name) is not None or (said is not None and files.is_folder(said))

    def _missing(self, one: Named, scheme: str, rest: str, odd: Path | None) -> None:
        """Say that a mesh is not found, or is no file."""
        severity = WARNING if self.opening or scheme == "model" else NOTE  # readers of a URDF know packages alone
        if odd is not None:
            message, help = f"{one.kind} {one.name} is no regular file: {shown(odd)}", "name a file"
            self.diagnostics.append(Diagnostic("mesh-not-a-file", ERROR, message, one.spans[0], (), help))
        elif one.kind == OF_ELEMENT:
            self._absent(one, "not there: MuJoCo does not load the MJCF without it", _PUT, ERROR)
        elif scheme in ("package", "model"):
            name = rest.partition("/")[0]
            if not name:
                self._absent(one, f"in no package{self._left()}", f"write {scheme}://NAME/FILE", severity)
            elif any(self._is_known(folder, name) for folder in self._beside(one)):
                help = f"correct the name, or say where the package is: --package {name}=FOLDER"
                self._absent(one, f"not in the package {name}{self._left()}", help, WARNING)
            else:
                folder = self._likely(one, rest.partition("/")[2])
                help = f"--package {name}={folder} says where it is; readers of the URDF look for it themselves"
                self._absent(one, f"not found: there is no package {name} here{self._left()}", help, severity)
        elif scheme or one.name.startswith("/"):
            self._absent(one, f"not on this machine{self._left()}", "correct the name", severity)
        else:
            outside = posixpath.normpath(one.name).startswith("../")
            what = "not there, neither as seen from the artifacts nor beside the description"
            what = "not there, as seen from the artifacts" if outside and self.opening else what
            if not (self.opening or self.naming):
                what, outside = f"not there, as seen from {self.places.description.name}", True
            help = "put the file there, or correct the name" if outside else _PUT
            # Without a texture it is the robot all the same; without a mesh that import found nowhere, that was told.
            if one.kind == TEXTURE or self._folders(one):
                self._absent(one, what + self._left(), help, WARNING)
                return
            help += ", or take mjcf out of outputs" if self.opening else ""
            self._absent(one, what, help, ERROR if self.opening else WARNING)

    def _likely(self, one: Named, path: str) -> str:
        """Return a folder around a robot of others that has a file of a package; FOLDER if there is none."""
        above = () if self.opening or self.naming else (self.places.description.absolute().parent, *_around(one))
        return next((shown(folder) for folder in above if path and _kind(folder / path) == _HERE), "FOLDER")

    def _left(self) -> str:
        """Return which artifacts go without a mesh, as the end of a sentence."""
        files = first_of([output.file for output in self.opening], 2)
        return f", and left out of {files}" if files else ""

    def _absent(self, one: Named, what: str, help: str, severity: str) -> None:
        self.absent.setdefault((what, help, severity, one.kind), []).append(one)


def files_diagnostic(rule: str, what: str, help: str, severity: str, many: Sequence[Named]) -> Diagnostic:
    """Return what there is to say of files of one kind for one reason, with the places of all of them."""
    names, spans, kind = [one.name for one in many], [span for one in many for span in one.spans], many[0].kind
    which = f"{len(names)} {_SEVERAL[kind]} ({first_of(names, _SHOWN)}) are"
    which = f"{kind} {names[0]} is" if len(names) == 1 else which
    return Diagnostic(rule, severity, f"{which} {what}", spans[0], and_here(spans[1:]), help, (EVERYTHING,))


def _around(one: Named) -> Iterator[Path]:
    """Yield the folders above the file that names a mesh, of an imported robot: a path with ".." may begin in one."""
    for span in one.spans:
        path = Path(os.path.abspath(span.source.path))
        if path.suffix not in ENDINGS:
            yield from list(path.parent.parents)[:_MOST_ABOVE]


def _is_inside(name: str) -> bool:
    """Say whether a name leads into the folder of the artifacts."""
    return not (name.startswith(("/", "../")) or name == "..")


def _plain(path: Path) -> Path:
    """Return a path without dots: ".." leads out of the folder of the artifacts also if that is not there yet."""
    return Path(os.path.normpath(path))


def _folder(output: Output) -> str:
    """Return the folder of an artifact below that of all."""
    return posixpath.dirname(output.file)


def opened_by(output: Output, name: str, kind: str = MESH) -> str:
    """Return by which name an artifact opens a mesh, seen from the folder of all; empty if it does not.

    ``name`` is that of the mesh in the description; what an element names has it in the artifact, too.
    """
    opens = RECORDS[output.backend].opens
    opened = "" if opens is None else name if kind == OF_ELEMENT else opens(name)
    return posixpath.normpath(posixpath.join(_folder(output), opened)) if opened else ""


def _kind(path: Path) -> int:
    """Return whether a path leads to a regular file, to nothing, or to what is no file."""
    return _HERE if files.is_file(path) else _ODD if files.exists(path) else _NOT_THERE

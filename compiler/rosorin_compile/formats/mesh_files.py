"""Find the meshes, textures and other files that a description refers to.

File names in an artifact depend only on the description: relative paths are unchanged, and files from ROS packages are
copied to ``meshes/NAME/...``. An artifact does not refer to missing files.
"""

import json
import os
import posixpath
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple
from urllib.parse import unquote

from rosorin_compile.language.element_names import files_in
from rosorin_compile.language.suppressions import EVERYTHING
from rosorin_compile.model import Output, Robot
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Span, has_errors
from rosorin_compile.source.files import label
from rosorin_compile.source.messages import and_here
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import ENDINGS, ROS_PACKAGE, PackageFolder
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.wording import first_of

from . import FORMATS as RECORDS

MESH, TEXTURE, OF_ELEMENT, OF_MESH = "mesh", "texture", "file", "file of a mesh"
_PLURALS = {MESH: "meshes", TEXTURE: "textures", OF_ELEMENT: "files", OF_MESH: "files of meshes"}
_PACKAGES = ("package", "model")  # URI schemes for packages
_TEXT_REFERENCES = {
    ".mtl": rb"^[ \t]*(?:map_\w+|bump|disp|decal|refl|norm)[ \t]+(?:.*[ \t])?(\S+)[ \t]*\r?$",
    ".dae": rb"<image\b[^>]*>\s*<init_from>\s*(?:<ref>)?\s*([^<>]+?)\s*<",
    ".ply": rb"^comment TextureFile[ \t]+(.*\S)[ \t]*\r?$",
    ".obj": rb"^[ \t]*mtllib[ \t]+(.*\S)[ \t]*\r?$",
}


class NamedFile(NamedTuple):
    """The name of a file that a description refers to."""

    name: str
    spans: list[Span]  # positions of the name
    kind: str = MESH  # MESH, TEXTURE, OF_ELEMENT (in raw XML) or OF_MESH
    collides: bool = False  # a collision mesh

    @property
    def address(self) -> tuple[str, str]:
        """The URI scheme ("" for a path) and the rest. An extra slash after package:// is accepted."""
        scheme, mark, rest = self.name.partition("://")
        return (scheme, rest.lstrip("/") if scheme in _PACKAGES else rest) if mark else ("", self.name)

    @property
    def folders(self) -> list[Path]:
        return list(dict.fromkeys(Path(span.source.path).parent for span in self.spans))


class FoundFile(NamedTuple):
    """A file that was found, with its paths in artifacts, relative to the output folder."""

    named: NamedFile
    file: Path
    places: tuple[str, ...]  # paths in artifacts that open the file, such as an MJCF
    beside: tuple[str, ...] = ()  # paths in artifacts that only refer to the file, such as a URDF


class SearchResult(NamedTuple):
    """The result of a search for meshes and other files."""

    found: tuple[FoundFile, ...] = ()
    missing: frozenset[str] = frozenset()  # names of files that were not found or cannot be opened
    diagnostics: Sequence[Diagnostic] = ()
    by_name: Mapping[str, Path] = MappingProxyType({})  # {name: path} of the files that were found
    resolved: tuple[PackageFolder, ...] = ()  # the packages that were looked up, with their folders
    files: Mapping[str, bytes] = MappingProxyType({})  # {path in the output folder: contents} to write

    def add_to(self, robot: Robot) -> Robot:
        if not self.missing and not self.by_name:
            return robot  # with the results that are cached in it
        opened = {one.named.name: one.places[0] for one in self.found if one.places and one.places[0] in self.files}
        contents = {name: (self.files[place], Path(place).suffix.lower()) for name, place in opened.items()}
        return replace(robot, missing_meshes=self.missing, mesh_files=self.by_name, mesh_contents=contents)


class Places(NamedTuple):
    """The places in which to search for files."""

    description: Path  # main file of the description
    outputs: Path  # folder of the artifacts
    packages: Mapping[str, Path]  # folders of ROS packages by name
    environment: Mapping[str, str]

    def meshes(self, tree: Map, outputs: Sequence[Output] = (), kind: str = MESH) -> Mapping[str, Path]:
        """Find all meshes (or textures, by ``kind``) of a description, and map their names to paths."""
        return _Search(self, outputs, tree).run([one for one in named_files(tree) if one.kind == kind]).by_name

    def search(self, tree: Map, relative: bool = True) -> SearchResult:
        """Search for the meshes and textures of an imported file; ``relative`` includes relative paths."""
        found = _Search(self, (), None).run([one for one in named_files(tree) if relative or not is_relative(one.name)])
        diagnostics = [d if d.severity == ERROR else replace(d, severity=WARNING) for d in found.diagnostics]
        return found._replace(diagnostics=diagnostics)


def search(tree: Map, outputs: Sequence[Output], places: Places) -> SearchResult:
    """Search for the files that a description refers to and that these outputs need."""
    formats = [RECORDS[output.backend] for output in outputs]
    opening = [output for output in outputs if RECORDS[output.backend].opens is not None]
    naming, embeds = any(one.measures or one.meshes for one in formats), any(one.embeds for one in formats)
    if not (opening or naming or embeds):
        return SearchResult()
    every = named_files(tree)
    named, textures = ([one for one in every if one.kind == kind] for kind in (MESH, TEXTURE))
    for texture in textures if opening else ():  # formats that do not open textures do not need them
        is_named = naming and is_relative(urdf_file_name(texture.name))
        named += [texture] if is_named or any(opened_by(output, texture.name) for output in opening) else []
    elements: dict[str, dict[Span, None]] = {}  # files in verbatim MJCF elements
    links = [link for link in (tree.get("links") or {}).values() if isinstance(link, Map)]
    for texts in (tree.get("mjcf"), *(link.get("mjcf_elements") for link in links)) if opening else ():
        for text, span in zip(texts, texts.value_spans, strict=True) if isinstance(texts, Seq) else ():
            for name in files_in(text) if isinstance(text, str) else ():
                elements.setdefault(name, {})[span] = None
    named += [NamedFile(name, list(spans), OF_ELEMENT) for name, spans in elements.items()]
    searched, textures = _Search(places, outputs, tree).run(named), textures if embeds else []
    return searched._replace(by_name={**_Search(places, (), tree).run(textures).by_name, **searched.by_name})


def read_files(searched: SearchResult, outputs: Sequence[Output], folder: Path) -> SearchResult:
    """Return the search result with the contents of all files that must be copied to the output folder."""
    if has_errors(searched.diagnostics):
        return searched
    contents, diagnostics, unreadable = dict[str, bytes](), [*searched.diagnostics], list[NamedFile]()
    for one in searched.found:
        try:
            contents |= dict.fromkeys(one.beside, files.read_bytes(one.file)) if one.beside else {}
        except OSError:
            unreadable.append(one.named)
    if unreadable:
        remark = ("mesh-not-read", "not copied", "check the permissions", WARNING)
        diagnostics.append(files_diagnostic(*remark, unreadable))
    searched = searched._replace(files=contents, diagnostics=diagnostics)
    for copy in dict.fromkeys(RECORDS[output.backend].copies for output in outputs) if searched.found else ():
        searched = copy(searched, folder) if copy is not None else searched
    return searched


def named_files(tree: Map) -> list[NamedFile]:
    """Return the meshes and textures that a description refers to, without duplicates, meshes first."""
    found: dict[tuple[str, str], dict[Span, None]] = {}
    colliding: set[str] = set()

    def visit(node: Map | Seq, collides: bool = False) -> None:
        if isinstance(node, Map):
            mesh, texture = node.get("mesh"), node.get("texture")
            if isinstance(mesh, Map) and isinstance(file := mesh.get("file"), str):
                found.setdefault((MESH, file), {})[mesh.value_spans["file"]] = None
                colliding.update([file] if collides else ())
            if isinstance(texture, str) and texture:
                found.setdefault((TEXTURE, texture), {})[node.value_spans["texture"]] = None
        for name, value in node.items() if isinstance(node, Map) else enumerate(node):
            if isinstance(value, (Map, Seq)) and name != "mjcf":  # skip raw MJCF values
                visit(value, collides or name == "collision")

    for key, value in tree.items():
        if isinstance(value, (Map, Seq)) and key != "outputs":
            visit(value)
    every = (NamedFile(name, list(spans), kind, name in colliding) for (kind, name), spans in found.items())
    return sorted(every, key=lambda one: one.kind == TEXTURE)


def references(mesh: Path) -> list[str]:
    """Return the files that a mesh file refers to, directly or indirectly, relative to its folder."""
    ending = mesh.suffix.lower()
    try:
        data = files.read_bytes(mesh)
        if ending in (".gltf", ".glb"):
            document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")] if ending == ".glb" else data)
            names = [str(one["uri"]) for key in ("buffers", "images") for one in document.get(key, ()) if "uri" in one]
        else:
            found = re.findall(_TEXT_REFERENCES.get(ending, rb"(?!)"), data, re.IGNORECASE | re.MULTILINE)
            names = [line.decode("utf-8", "replace").replace("\\", "/") for line in found]
    except (OSError, ValueError, AttributeError, TypeError):  # a damaged mesh is reported when it is read
        return []
    if ending == ".obj":
        names = [name for line in names for name in ([line] if files.is_file(mesh.parent / line) else line.split())]
        for library in list(names):
            names += [posixpath.join(posixpath.dirname(library), name) for name in references(mesh.parent / library)]
    elif ending in (".dae", ".gltf", ".glb"):
        names = [unquote(name.removeprefix("file://")) for name in names]
    return list(dict.fromkeys(name for name in names if name and is_relative(name) and not name.startswith("data:")))


def urdf_file_name(name: str) -> str:
    """Return the name of a mesh or texture file in a URDF; files of model:// URIs are copied to ``meshes``."""
    scheme, mark, rest = name.partition("://")
    return f"meshes/{rest.lstrip('/')}" if mark and scheme == "model" and ".." not in rest.split("/") else name


def is_relative(name: str) -> bool:
    """Return True if the name of a file is a relative path."""
    return not (name.startswith("/") or "://" in name)


def opened_by(output: Output, name: str, kind: str = MESH) -> str:
    """Return the path, relative to the output folder, at which readers of an artifact open a file, or ""."""
    opens = RECORDS[output.backend].opens
    opened = "" if opens is None else name if kind == OF_ELEMENT else opens(name)
    return _relative_to(output.file, opened) if opened else ""


def files_diagnostic(rule: str, what: str, help: str, severity: str, many: Sequence[NamedFile]) -> Diagnostic:
    """Return a single diagnostic about several files of the same kind."""
    names, spans, kind = [one.name for one in many], [span for one in many for span in one.spans], many[0].kind
    subject = f"{len(names)} {_PLURALS[kind]} ({first_of(names, 3)}) are" if len(names) > 1 else f"{kind} {names[0]} is"
    return Diagnostic(rule, severity, f"{subject} {what}", spans[0], and_here(spans[1:]), help, (EVERYTHING,))


class _Search:
    def __init__(self, places: Places, outputs: Sequence[Output], tree: Map | None) -> None:
        self.places, self.main = places, places.description.parent
        self.sources: dict[Path, tuple[list[Path], dict[str, Path]]] = {}  # by folder of the YAML file
        for entry in (tree, *(tree.get("links") or {}).values()) if tree is not None else ():
            source = entry.get("source") if isinstance(entry, Map) else None
            if isinstance(source, Map) and ("folder" in source or "packages" in source):
                by = Path(source.span.source.path).parent
                folders, packages = self.sources.setdefault(by, ([], {}))
                folders += [by / str(source["folder"])] if "folder" in source else []
                for name, place in (source.get("packages") or {}).items():
                    packages.setdefault(name, by / str(place))
        self.main_source = self.sources.get(self.main, ([], {}))
        self.opening = [output for output in outputs if RECORDS[output.backend].opens is not None]
        self.naming = [output for output in outputs if RECORDS[output.backend].meshes]
        self.has_outputs = bool(self.opening or self.naming) or any(RECORDS[one.backend].measures for one in outputs)
        self.left_out = f", and left out of {first_of([one.file for one in self.opening], 2)}" if self.opening else ""
        self.finders: dict[Path, Packages] = {}
        self.found: list[FoundFile] = []
        self.taken: dict[str, tuple[NamedFile, Path]] = {}  # by path in the output folder
        self.resolved: dict[PackageFolder, None] = {}
        self.diagnostics: list[Diagnostic] = []
        self.absent: dict[tuple[str, str, str, str], list[NamedFile]] = {}  # {(reason, help, severity, kind): files}

    def run(self, named: Sequence[NamedFile]) -> SearchResult:
        missing, by_name = set[str](), dict[str, Path]()
        for one in named:
            opened = sorted({name for output in self.opening if (name := opened_by(output, one.name, one.kind))})
            file = self._file(one, [self.places.outputs / name for name in opened])
            if file is None or (self.opening and not opened):
                missing.add(one.name)
            if file is not None:
                by_name[one.name] = file
                self._check_other_folders(one, file)
                self._add(one, file, opened)
        for (what, help, severity, kind), many in self.absent.items():
            rule = "element-file-not-found" if kind == OF_ELEMENT else "mesh-not-found"
            self.diagnostics.append(files_diagnostic(rule, what, help, severity, many))
        return SearchResult(tuple(self.found), frozenset(missing), self.diagnostics, by_name, tuple(self.resolved))

    def _file(self, one: NamedFile, copies: Sequence[Path]) -> Path | None:
        scheme, rest = one.address
        folders = [*one.folders, self.main]
        candidates: Iterable[Path]
        if scheme in _PACKAGES:
            candidates = chain(self._in_packages(folders, rest), copies)
        elif scheme == "file" or one.name.startswith("/"):
            candidates = [Path(unquote(rest) if scheme else one.name)]
        elif scheme:
            if self.opening:
                self._absent(one, f"no file{self.left_out}", "name a file, or package://NAME/FILE", WARNING)
            return None
        else:
            # A copy in the output folder may be outdated, so the source has priority. Files outside of that folder
            # are not copied, so they must exist at the path that the artifacts contain.
            sources = [place for folder in folders for place in self.sources.get(folder, self.main_source)[0]]
            near = () if self._leads_out(one) else (*folders, *sources, *_folders_above(one))
            artifacts = [_relative_to(output.file, one.name) for output in (*self.opening, *self.naming)]
            made = map(self.places.outputs.joinpath, artifacts)
            candidates = [*(folder / one.name for folder in near), *made, *copies]
        irregular = None
        for path in map(_plain, candidates):
            if files.is_file(path):
                return path
            irregular = irregular or (path if files.exists(path) else None)
        if irregular is None:
            self._report_missing(one, scheme, rest)
        else:
            message = f"{one.kind} {one.name} is not a regular file: {label(irregular)}"
            self.diagnostics.append(Diagnostic("mesh-not-a-file", ERROR, message, one.spans[0], (), "name a file"))
        return None

    def _report_missing(self, one: NamedFile, scheme: str, rest: str) -> None:
        severity = WARNING if self.opening or scheme == "model" else NOTE  # readers of a URDF find packages themselves
        help, folders = "put the file next to the description, or correct the name", [*one.folders, self.main]
        if one.kind == OF_ELEMENT:
            what, severity = "not there: MuJoCo does not load the MJCF without it", ERROR
        elif scheme in _PACKAGES:
            name, _, path = rest.partition("/")
            packages = (place for folder in folders for place in self._package(folder, name))
            exists = bool(name) and any(files.is_folder(place) for place in packages)
            what = f"not found: there is no package {name} here" if name else "in no package"
            what, severity = (f"not in the package {name}", WARNING) if exists else (what, severity)
            above = () if self.has_outputs or exists else (self.main.absolute(), *_folders_above(one))
            likely = next((label(folder) for folder in above if path and files.is_file(folder / path)), "FOLDER")
            help = f"--package {name or 'NAME'}={likely} says where it is; readers of the URDF look for it themselves"
            what += self.left_out
        elif scheme or one.name.startswith("/"):
            what, help = f"not on this machine{self.left_out}", "correct the name"
        else:
            what, severity = f"not there, as seen from {self.places.description.name}", WARNING
            if self.has_outputs:
                what = "not there, neither as seen from the artifacts nor next to the description"
            # This is not an error: textures are optional, and the import already reported missing meshes.
            if one.kind == TEXTURE or any(self.sources.get(folder, self.main_source)[0] for folder in folders):
                what += self.left_out
            elif self.opening:
                help, severity = f"{help}, or take mjcf out of outputs", ERROR
        self._absent(one, what, help, severity)

    def _absent(self, one: NamedFile, what: str, help: str, severity: str) -> None:
        self.absent.setdefault((what, help, severity, one.kind), []).append(one)

    def _add(self, one: NamedFile, file: Path, opened: Sequence[str]) -> None:
        name = urdf_file_name(one.name)
        is_named = is_relative(name) and one.kind != OF_ELEMENT
        named = sorted({_relative_to(output.file, name) for output in self.naming}) if is_named else []
        if opened or named:
            self._take(one, file, opened, named)
        places = filter(_is_inside, dict.fromkeys((*opened, *named)))
        copies = [place for place in places if Path(place).suffix.lower() == file.suffix.lower()]
        for inner_name in references(file) if one.kind == MESH and copies else ():
            inner, inner_file = NamedFile(inner_name, one.spans, OF_MESH), file.parent / inner_name
            if files.is_file(inner_file):
                self._take(inner, inner_file, (), [_relative_to(place, inner_name) for place in copies])
            else:
                what = f"not there, and {posixpath.basename(one.name)} names it"
                is_imported = any(folders for folders, _ in self.sources.values())  # the source lacks the file too
                severity = NOTE if is_imported else WARNING
                self._absent(inner, what, "put the file next to the mesh, or export the mesh again", severity)

    def _take(self, one: NamedFile, file: Path, opened: Sequence[str], named: Sequence[str]) -> None:
        found = FoundFile(one, file, tuple(filter(_is_inside, opened)), tuple(filter(_is_inside, named)))
        self.found.append(found)
        for place in dict.fromkeys((*found.places, *found.beside)):
            first, other = self.taken.setdefault(place, (one, file))
            if _plain(self.places.outputs / place) not in (_plain(file), _plain(other)) and _differ(other, file):
                what = f"{_PLURALS[one.kind]} {first.name} and {one.name} would both be {place} next to the artifacts"
                self._ambiguous(f"{what}, and differ", one.spans[0], first)

    def _check_other_folders(self, one: NamedFile, file: Path) -> None:
        """Report a file name that refers to different files, depending on the folder of the YAML file."""
        scheme, rest = one.address
        is_fixed = one.name.startswith("/") or (scheme and scheme not in _PACKAGES) or self._leads_out(one)
        for folder in () if len(one.folders) == 1 or is_fixed else one.folders:
            within = [folder, self.main]
            seen = self._in_packages(within, rest) if scheme else (place / one.name for place in within)
            other = next(filter(files.is_file, map(_plain, seen)), file)
            if _differ(file, other):
                span = next(span for span in one.spans if Path(span.source.path).parent == folder)
                made = ", ".join(output.file for output in self.opening or self.naming)
                what = f"would be two files next to {made}" if self.opening else f"is two files, and one name in {made}"
                message = f"{one.kind} {one.name} {what}: {label(other)} here, {label(file)} elsewhere"
                self._ambiguous(message, span, one)
                return

    def _ambiguous(self, message: str, span: Span, first: NamedFile) -> None:
        related, help = [Related("and here", first.spans[0])], "give one of the two files another name"
        severity = ERROR if self.opening else WARNING
        self.diagnostics.append(Diagnostic("mesh-ambiguous", severity, message, span, tuple(related), help))

    def _leads_out(self, one: NamedFile) -> bool:
        return bool(self.opening) and posixpath.normpath(one.name).startswith("../")

    def _package(self, folder: Path, name: str) -> Iterator[Path]:
        at_source = self.sources.get(folder, self.main_source)[1].get(name)
        if at_source is not None and name not in self.places.packages:
            yield at_source
        if folder not in self.finders:
            self.finders[folder] = Packages(self.places.packages, self.places.environment, folder / "robot.yaml")
        found = self.finders[folder].find(name)
        if found is not None and name not in self.places.packages:
            self.resolved[PackageFolder(ROS_PACKAGE, name, Path(os.path.abspath(found)))] = None
        yield from () if found is None else (found,)

    def _in_packages(self, folders: Sequence[Path], rest: str) -> Iterator[Path]:
        name, _, path = rest.partition("/")
        if path and ".." not in path.split("/"):
            yield from (package / path for folder in folders for package in self._package(folder, name))


def _folders_above(one: NamedFile) -> Iterator[Path]:
    """Yield folders above an imported file, because paths in the file may be relative to one of these."""
    for span in one.spans:
        path = Path(os.path.abspath(span.source.path))
        if path.suffix not in ENDINGS:
            yield from list(path.parent.parents)[:4]


def _relative_to(place: str, name: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(place), name))


def _is_inside(name: str) -> bool:
    return not (name.startswith(("/", "../")) or name == "..")


def _plain(path: Path) -> Path:
    return Path(os.path.normpath(path))


def _differ(path: Path, other: Path) -> bool:
    try:
        if path == other or files.resolve(path) == files.resolve(other):
            return False
        return path.stat().st_size != other.stat().st_size or files.read_bytes(path) != files.read_bytes(other)
    except OSError:
        return True

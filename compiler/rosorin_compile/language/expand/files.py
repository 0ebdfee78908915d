"""Files: a description read with all that it includes, its sections joined, nothing evaluated yet.

``table_loader`` gives expressions their ``load``: YAML files of plain values to look things up in; ``package_finder``
their ``find``: the folder of a ROS package.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from copy import copy as copy_of
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic, Related, Source, Span, error
from rosorin_compile.source.files import Version, is_file, record, recording, resolve, shown
from rosorin_compile.source.load import LoadError, load_mapping, parse_yaml, read_utf8
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import (
    ENDINGS,
    PYTHON_PACKAGE,
    ROS_PACKAGE,
    Description,
    Resolved,
    data_folder,
    python_folder,
    resolved,
)
from rosorin_compile.source.rule_registry import FILES, Rule
from rosorin_compile.source.tree import Include, Instance, Map, Place, Seq, locate

from ..annotations import ENTRIES, ITEMS, WITHIN
from ..expression.functions import ExpressionError
from ..schema import holds_many, keys_of, merged, sections
from ..suggestions import word_meant
from .nearby import ADDRESS, address, corrected, outside, outside_of, package_missing
from .parts import copy, join_within, sourced

if TYPE_CHECKING:
    from .included_robots import ForeignReader

RULES = (
    Rule(
        "include-outside",
        "An included file is outside the project: the folder that has `descriptions`, or that of a lone description.",
        "Move it inside, or name the ROS package that it is in: `package://NAME/FILE`.",
        FILES,
    ),
    Rule("include-cycle", "A file includes itself, directly or through others.", "Remove one `include`.", FILES),
    Rule("include-too-many", "More files are included than any description has.", "Join some.", FILES),
    Rule("included-robot", "An included file has the key `robot`.", "Only the first file names the robot.", FILES),
)


MAX_FILES = 500

# Sections that are joined and are none of a whole description.
_OF_PARTS = ("parts", "sensor_types", "use")
_PRIVATE = ("include", "let", "source", "rosorin_compile")
_OF_FILE = ("args", "file", "package", "packages")  # what the include of a description may say
# What the include of a robot in another format may say, too.
_OF_ROBOT = (
    "prefix",
    "parent",
    "xyz",
    "rpy",
    "joint",
    "publisher",
    "meshes",
    "lenient",
    "trust",
    "source",
    "for",
    "if",
)


def _joined() -> tuple[str, ...]:
    """Return the sections whose entries several files may have."""
    return (*merged(ENTRIES, WITHIN), *_OF_PARTS)


def _has_source(section: str) -> bool:
    """Say whether entries of a section have the source of their file."""
    node = sections().get(section)
    return section == "use" or (node is not None and node.sourced)


class Asked(NamedTuple):
    """An include of a foreign robot: what it says, where, and the file in which it stands."""

    item: Map
    place: Place
    by: Path


def foreign(item: Any, place: Place, by: Path, endings: Callable[[], tuple[str, ...]]) -> Asked | None:
    """Return an entry of ``include`` that is about a foreign robot, whose file has one of ``endings``; else None."""
    name = item.get("file") if isinstance(item, Map) else item
    is_ours = isinstance(name, str) and name.endswith(ENDINGS)
    is_foreign = isinstance(name, str) and not is_ours and name.lower().endswith(endings())
    if isinstance(item, Map):
        return Asked(item, place, by) if is_foreign or ("package" in item and not is_ours) else None
    if not is_foreign:
        return None
    made = Map(place.span, place.via)
    made.put("file", item, place.span, place.span)
    return Asked(made, place, by)


class Kept:
    """What was read of one description, to be taken again while its files are what they were, to the letter.

    For whoever compiles it again and again in one go: where the names of packages lead is not asked once more.
    """

    def __init__(self) -> None:
        self.reader: Reader | None = None
        self.root: Map | None = None
        self.looked_for: dict[Path, Version] = {}  # as ``recording`` has them

    def read(self, reader: Reader) -> tuple[Reader, Map | None]:
        """Return the joined files of a description, and who has read them: ``reader`` or one before, both anew."""
        before = self.reader
        if before is not None and before.same_as(reader) and before.is_current():
            for file, version in self.looked_for.items():
                record(file, version)
            return before.renewed(), self.root
        with recording() as self.looked_for:
            root = reader.whole()
        self.reader, self.root = (reader, root) if not reader.diagnostics else (None, None)
        return (reader.renewed() if self.reader else reader), root


class Reader:
    """Reads a file and what it includes; collects named values, foreign robots, files and what is wrong."""

    def __init__(self, root: Path, robots: ForeignReader | None, packages: Mapping[str, Path] | None = None) -> None:
        # Without a reader whatever is no YAML is another one's robot.
        self.foreign_endings = robots.endings if robots else lambda: ("",)
        self.folder = resolve(root.parent)
        self.projects = Description.at(root).projects
        self.project = self.projects[0]
        self.root = root
        self.packages = dict(packages or {})
        self.found: set[str] = set()
        self.shares: dict[Path, str] = {}
        self.files: list[Path] = []
        self.includes: dict[str, Include] = {}
        self.sources: list[tuple[Path, Source]] = []
        self.tables: dict[str, tuple[Path, Source, Any]] = {}
        self.resolved: list[Resolved] = []
        self.lets: list[tuple[str, Any, Place, Place]] = []
        self.given: dict[str, tuple[Any, Place]] = {}
        self.offered: list[Any] = []
        self.diagnostics: list[Diagnostic] = []
        self.robots: list[Asked] = []
        self.unread = False
        self.described: list[tuple[Any, Span, Span]] = []

    def whole(self) -> Map | None:
        """Return the description, joined; None if its first file cannot be read."""
        return self.read(self.root, shown(self.root), None, None, ())

    def same_as(self, other: Reader) -> bool:
        """Say whether another reader is to read the same."""
        return (self.root, self.packages) == (other.root, other.packages)

    def is_current(self) -> bool:
        """Say whether the files that were read hold what they held."""
        try:
            return all(read_utf8(path, source.path).text == source.text for path, source in self.sources)
        except LoadError:
            return False

    def renewed(self) -> Reader:
        """Return a reader that has read the same, for another expansion; what both have loaded they share."""
        made = copy_of(self)
        made.files, made.resolved, made.diagnostics = list(self.files), list(self.resolved), list(self.diagnostics)
        made.found, made.shares = set(self.found), dict(self.shares)
        return made

    def read(
        self, path: Path, name: str, asked: Span | None, via: Instance | None, within: tuple[Path, ...]
    ) -> Map | None:
        """Return a file joined with its includes; None if it cannot be read."""
        self.files.append(path)
        Progress.step("reading files", len(self.files))
        try:
            file = load_mapping(path, name, asked, via)
        except LoadError as problem:
            diagnostic = problem.diagnostic
            stack = tuple(via.stack()) if via else ()
            # Where the file cannot be read, the diagnostic points at the include itself: that needs no note.
            led_here = stack[1:] if diagnostic.span == asked else stack
            self.diagnostics.append(replace(diagnostic, related=diagnostic.related + led_here))
            self.unread = True
            return None
        self.sources.append((path, file.span.source))
        made = Map(file.span, via)
        includes = self._includes(file)
        here = (*within, resolve(path)) if includes else within
        for item, span in includes:
            robot = foreign(item, Place(span, via), path, self.foreign_endings)
            if robot is not None:
                self.robots.append(robot)
                continue
            included = self._include(item, path, Place(span, via), here)
            if included is not None:
                self.join(made, included)
        self._collect_lets(file)
        self.join(made, self._own(file, root=via is None))
        return made

    def library(self, name: str) -> Path | None:
        """Return a file of parts by name: of the library, or ``PACKAGE:FILE`` of an installed package."""
        package, colon, file = name.rpartition(":")
        folder = python_folder(package) if colon else data_folder("parts_library")
        if colon:
            self.resolved.append(resolved(PYTHON_PACKAGE, package, "", folder))
        if folder is None or not file or os.sep in file or file.startswith("."):
            return None
        path = folder / f"{file}.yaml"
        if not is_file(path):
            return None
        if colon and path not in self.files:
            self.files.append(path)
        return path

    def _includes(self, file: Map) -> list[tuple[Any, Span]]:
        names = file.get("include")
        if names is None:
            return []
        if not isinstance(names, Seq):
            help = f"write [{names}]" if isinstance(names, str) else 'write "- " before each file name'
            self._error("wrong-type", "include is a list of file names", locate(file, ("include",)), help)
            return []
        return list(zip(names, names.value_spans, strict=True))

    def _include(self, item: Any, path: Path, place: Place, within: tuple[Path, ...]) -> Map | None:
        """Return an included file; it must stand inside the project or a ROS package, and not include itself."""
        name = item.get("file") if isinstance(item, Map) else item
        if not isinstance(name, str) or not name:
            self._error("wrong-type", "include names files: text", place, "write the name of a YAML file")
            return None
        if isinstance(item, Map):
            self._collect_given(item)
        target = self._target(item, name, path, place)
        if target is None:
            return None
        if resolve(target) in within:
            self._error("include-cycle", f"{name} includes itself, directly or through others", place, "remove one")
            return None
        if len(self.files) >= MAX_FILES:
            self._error("include-too-many", f"more than {MAX_FILES} files are included", place, "include fewer files")
            return None
        before = len(self.diagnostics)
        via = Include("included here", place.span, place.via)
        via.included = self.includes
        self.includes.setdefault(shown(target), via)
        made = self.read(target, shown(target), place.span, via, within)
        if made is None:
            self.diagnostics[before:] = [corrected(one, name, target) for one in self.diagnostics[before:]]
        return made

    def _target(self, item: Any, name: str, by: Path, place: Place) -> Path | None:
        """Return the file that an include means: relative to the file it stands in, or in a ROS package; else None."""
        package, file = address(name)
        own = item.get("package") if isinstance(item, Map) else None
        if own is not None and package is None and isinstance(own, str):
            package, file = own, name
        elif own is not None:
            message = "package of an include is text" if package is None else f"{name} names its package already"
            self._error("wrong-type", message, Place(item.value_spans["package"], item.via), "write one package")
            return None
        if package is not None:
            target, message, help = self.in_package(package, file, by, self._packages(item, by))
            if target is None:
                self._error("include-outside" if package in self.found else "package-missing", message, place, help)
            return target
        target = by.parent / name
        if self.inside(target):
            return target
        home = next((f'the folder of the package "{self.shares[folder]}"' for folder in self._homes(by)), "")
        message = f"{name} is outside {home}" if home else outside(name, by, self.project)
        help = f"move it inside, or name the ROS package that it is in: {ADDRESS}NAME/FILE"
        self._error("include-outside", message, place, help)
        return None

    def in_package(
        self, package: str, file: str, by: Path, packages: Mapping[str, Path]
    ) -> tuple[Path | None, str, str]:
        """Return a file of a ROS package that the file ``by`` names; without one, what is wrong, and the way out."""
        folder = self.package(package, packages, by)
        if folder is None:
            return None, *package_missing(package)
        inner = Path(os.path.normpath(file))
        if inner.is_absolute() or inner.parts[:1] in ((), (os.pardir,)):
            message = f'{file} is outside the folder of the package "{package}"' if file else "a package is no file"
            return None, message, f"name a file in the package: {ADDRESS}{package}/FILE"
        self.shares[Path(os.path.abspath(folder))] = package
        return Path(shown(folder / inner)), "", ""

    def package(self, name: str, packages: Mapping[str, Path], by: Path) -> Path | None:
        """Return the folder of a ROS package that the file ``by`` names; None if it is not found."""
        folder = Packages(packages, os.environ, by).find(name)
        self.found |= {name} if folder else set()
        if name not in packages:
            self.resolved.append(resolved(ROS_PACKAGE, name, by, folder))
        return folder

    def _packages(self, item: Any, by: Path) -> dict[str, Path]:
        """Return the folders of packages that are named: by an include, and before those by the caller."""
        named = item.get("packages") if isinstance(item, Map) else None
        if named is None:
            return self.packages
        if not isinstance(named, Map) or not all(isinstance(folder, str) for folder in named.values()):
            place = Place(item.value_spans["packages"], item.via)
            message = "packages of an include map names to folders"
            self._error("wrong-type", message, place, "write packages: {NAME: FOLDER}")
            return self.packages
        return {**{name: by.parent / folder for name, folder in named.items()}, **self.packages}

    def _homes(self, path: Path) -> list[Path]:
        """Return the folders of packages that a file is in by its name, the innermost first."""
        absolute = Path(os.path.abspath(path))
        return sorted(filter(absolute.is_relative_to, self.shares), key=lambda folder: -len(folder.parts))

    def inside(self, target: Path) -> bool:
        """Say whether a file is inside the project of the description, links followed, or in a package it names."""
        try:
            return any(map(resolve(target).is_relative_to, self.projects)) or bool(self._homes(target))
        except (OSError, RuntimeError, ValueError):
            return False

    def _collect_given(self, item: Map) -> None:
        """Take down the arguments that an include gives; a description that includes this one has the last word."""
        for key in item:
            if key not in _OF_FILE:
                place = Place(item.key_spans[key], item.via)
                known = f"known: {', '.join(_OF_FILE)}"
                help = (
                    f"{known}; {key} is for a robot that is included as a URDF, xacro, SDF or MJCF"
                    if key in _OF_ROBOT
                    else known
                )
                self._error("unknown-key", f'an include has no key "{key}"', place, help)
        values = item.get("args")
        if values is not None and not isinstance(values, Map):
            place = Place(item.value_spans["args"], item.via)
            self._error("wrong-type", "args of an include map names to values", place, "write args: {NAME: VALUE}")
        elif values is not None:
            self.offered.append(values)
            for name, value in values.items():
                self.given.setdefault(name, (value, Place(values.value_spans[name], values.via)))

    def _collect_lets(self, file: Map) -> None:
        lets = file.get("let")
        if isinstance(lets, Map):
            for name, value in lets.items():
                value_place = locate(file, ("let", name))
                self.lets.append((name, value, locate(file, ("let", name), key=True), value_place))
        elif lets is not None:
            self._error("wrong-type", "let maps names to values", locate(file, ("let",)), "write name: value")

    def _own(self, file: Map, root: bool) -> Map:
        """Return the file without what was dealt with already, its source given to each entry that has none."""
        made = Map(file.span, file.via)
        if not root and "source" in file:
            self.described.append((file["source"], file.key_spans["source"], file.value_spans["source"]))
        for key, value in file.items():
            if key in _PRIVATE and not (root and key in ("source", "rosorin_compile")):
                continue
            if key == "help" and not root and isinstance(value, str):  # a file of parts says what it is for
                continue
            if key == "robot" and not root:
                place = locate(file, (key,), key=True)
                whole = "include the files that it is made of, or the URDF that is compiled of it"
                help = whole if self._homes(Path(place.span.source.path)) else "remove it"
                self._error("included-robot", "an included file does not name the robot", place, help)
                continue
            if _has_source(key) and isinstance(value, Map) and "source" in file:
                value = sourced(value, file)
            made.put(key, value, file.key_spans[key], file.value_spans[key])
        return made

    def join(self, made: Map, more: Map) -> None:
        """Add the sections of one file to those of the others."""
        for key, value in more.items():
            if key not in made or made[key] is None:
                joined = copy(value) if key in _joined() or key in merged(ITEMS) else value
                made.put(key, joined, more.key_spans[key], more.value_spans[key])
            elif key in _joined() and isinstance(value, Map) and isinstance(made[key], Map):
                if holds_many(key):
                    for inner, name, mine, other in join_within(made[key], value):
                        if inner in keys_of(key):
                            self._defined_twice(inner, name, mine, other)
                        else:
                            self._unknown_key(key, inner, value)
                    continue
                self._join_section(key, made[key], value)
            elif key in merged(ITEMS) and isinstance(value, Seq) and isinstance(made[key], Seq):
                for item, span in zip(value, value.value_spans, strict=True):
                    made[key].put(item, span)
            elif value is not None:
                self._cannot_join(key, made, more)

    def _cannot_join(self, key: str, made: Map, more: Map) -> None:
        """Report a section of which two files say different kinds, or a single value said twice."""
        related = [Related("first defined here", made.key_spans[key])]
        place = locate(more, (key,), key=True)
        if key in _joined() or key in merged(ITEMS):
            wanted, kind = ("a mapping", Map) if key in _joined() else ("a list", Seq)
            if isinstance(made[key], kind):  # else that is told, where it stands
                self._error("wrong-type", f"{key} is {wanted} in every file", place, "write it so in both", related)
        else:
            self._error("duplicate-key", f'"{key}" is said twice', place, "remove one", related)

    def _unknown_key(self, section: str, key: str, entry: Map) -> None:
        """Report a key of one entry that two files say something under, and that nobody knows."""
        place = locate(entry, (key,), key=True)
        self._error("unknown-key", f'{section} has no key "{key}"', place, word_meant(key, keys_of(section)))

    def _join_section(self, section: str, made: Map, more: Map) -> None:
        for name, entry in more.items():
            if name in made:
                self._defined_twice(section, name, made, more)
                continue
            made.put(name, entry, more.key_spans[name], more.value_spans[name])

    def _defined_twice(self, section: str, name: str, made: Map, more: Map) -> None:
        """Report a name that two files give."""
        related = [Related("first defined here", made.key_spans[name])]
        message = f'{section.rstrip("s")} "{name}" is defined twice'
        self._error("duplicate-name", message, locate(more, (name,), key=True), "rename or remove one", related)

    def _error(self, rule: str, message: str, place: Place, help: str, related: Sequence[Related] = ()) -> None:
        self.diagnostics.append(error(rule, message, place.span, help, [*related, *place.stack()]))


def table_loader(reader: Reader) -> Callable[[Any], Any]:
    """Return the function ``load`` of a description: a YAML file of its project or a package, read once."""
    loaded: dict[str, Any] = {}
    known = reader.tables

    def load(name: Any) -> Any:
        if not isinstance(name, str):
            raise ExpressionError("load takes the name of a YAML file")
        if name not in loaded:
            path = _table(reader, name)
            reader.files.append(path)
            try:
                source = read_utf8(path, shown(path))
                if name not in known or known[name][:2] != (path, source):
                    known[name] = path, source, parse_yaml(source)
                loaded[name] = known[name][2]
            except LoadError as problem:
                diagnostic = problem.diagnostic
                span = diagnostic.span
                where = f" ({span.source.path}:{span.line}:{span.column})" if span else ""
                raise ExpressionError(f"{diagnostic.message}{where}", help=diagnostic.help) from None
        return loaded[name]

    return load


def package_finder(reader: Reader) -> Callable[..., Any]:
    """Return the function ``find`` of a description: the folder of a ROS package, found as for ``include``."""
    found: dict[str, Path | None] = {}

    def find(name: Any, *other: Any) -> Any:
        if not isinstance(name, str) or len(other) > 1:
            raise ExpressionError("find takes the name of a ROS package, and what else is taken where there is none")
        if name not in found:
            found[name] = reader.package(name, reader.packages, reader.root)
        folder = found[name]
        if folder is None and not other:
            help = f"say where it is, --package {name}=FOLDER, or source its workspace"
            raise ExpressionError(package_missing(name)[0], help=help)
        return other[0] if folder is None else str(folder)

    return find


def _table(reader: Reader, name: str) -> Path:
    """Return the file that ``load`` is to read. Raises ExpressionError."""
    package, file = address(name)
    if package is not None:
        path, message, help = reader.in_package(package, file, reader.root, reader.packages)
        if path is None:
            raise ExpressionError(message, help=help)
        return path
    path = reader.folder / name
    if not reader.inside(path):
        raise ExpressionError(f"{name} is {outside_of(reader.project)}")
    return path

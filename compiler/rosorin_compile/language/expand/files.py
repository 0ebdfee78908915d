"""Read a description with all files that it includes, and join their sections, without evaluating expressions."""

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.source import project
from rosorin_compile.source.diagnostics import Diagnostic, Span, error
from rosorin_compile.source.files import exists, is_file, label, resolve
from rosorin_compile.source.load import LoadError, load_mapping, parse_yaml, read_utf8
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description, PackageFolder
from rosorin_compile.source.tree import Include, Instance, Map, Place, Seq
from rosorin_compile.source.wording import suggest

from ..expression.functions import ExpressionError
from ..schema import sections
from .declarations import check_entry
from .placing import join, with_sources
from .scope import Expansion, Scope, key_place, value_place

if TYPE_CHECKING:
    from rosorin_compile.formats.compilation import RobotReader


Cache = dict[Any, Any] | None  # parsed files, reused by later calls

ADDRESS = "package://"
MAX_FILES = 10_000  # safety limit: nested includes can grow exponentially
MAX_NESTED = 200

INCLUDE_KINDS: dict[str, type] = {"args": Map, "file": str, "package": str, "packages": Map}


class Reader:
    """Read a main file and its includes; collect named values, included robots, file names and diagnostics."""

    def __init__(
        self, root: Path, robots: "RobotReader | None", packages: Mapping[str, Path] | None = None, cache: Cache = None
    ) -> None:
        # Without a reader of robots, treat all files that are not YAML as robots.
        self.robot_endings = robots.endings if robots else lambda: ("",)
        self.root, self.folder, self.projects = root, resolve(root.parent), Description.from_path(root).projects
        self.packages, self.cache = dict(packages or {}), {} if cache is None else cache
        self.files: list[Path] = []
        self.resolved: list[PackageFolder] = []
        self.scope = Scope(Expansion())  # the names that the description defines
        self.diagnostics = self.scope.expansion.diagnostics
        self.lets: list[Map] = []  # the "let" section of each file
        self.given: dict[str, tuple[Any, Place]] = {}  # arguments that includes set, as (value, place) by name
        self.offered: list[Map] = []  # the "args" of each include, not evaluated
        self.robots: list[tuple[Map, Place, Path]] = []  # (entry of an included robot, its place, the including file)
        self.unread = False  # True if a file could not be read
        self.sourced: list[Map] = []  # included files with the key "source"
        self._package_folders: dict[Path, str] = {}
        self._includes: dict[str, Include] = {}

    def read(self, path: Path, via: Instance | None = None, within: tuple[Path, ...] = ()) -> Map | None:
        """Read a file and the files that it includes, and join their sections; return None if it cannot be read.

        ``via`` is the include that led to this file (None for the main file), ``within`` are the including files.
        """
        name, include = label(path), via.span if via else None
        self.files.append(path)
        Progress.step("reading files", len(self.files))
        try:
            file = self._cached((path, via), path, name, include, lambda: load_mapping(path, name, include, via))
        except LoadError as problem:
            diagnostic = problem.diagnostic
            stack = tuple(via.stack()) if via else ()
            # An unreadable file is reported at its include: do not list that include as a related position as well.
            stack = stack[1:] if diagnostic.span == include else stack
            self.diagnostics.append(replace(diagnostic, related=diagnostic.related + stack))
            self.unread = True
            return None
        made, items = Map(file.span, via), file.get("include")
        if items is not None and not isinstance(items, Seq):
            help = f"write [{items}]" if isinstance(items, str) else 'write "- " before each file name'
            self.scope.report("wrong-type", '"include" must be a list of files', value_place(file, "include"), help)
        elif items:
            here = (*within, resolve(path))
            for item, span in zip(items, items.value_spans, strict=True):
                entry, place = item, Place(span, via)
                if not isinstance(item, Map):  # the short form of an include: only the file name
                    entry = Map(span, via)
                    entry.put("file", item, span, span)
                name = entry.get("file") if isinstance(entry.get("file"), str) else ""
                is_yaml = name.endswith(project.ENDINGS)  # asked first, because ``robot_endings`` loads all formats
                if not is_yaml and ("package" in entry or name.lower().endswith(self.robot_endings())):
                    self.robots.append((entry, place, path))
                elif (included := self._include(entry, path, place, here)) is not None:
                    join(made, included, self.scope)
        lets = file.get("let")
        if isinstance(lets, Map):
            self.lets.append(lets)
        elif lets is not None:
            self.scope.report("wrong-type", '"let" must be a mapping', value_place(file, "let"), 'write "NAME: VALUE"')
        join(made, self._own_sections(file, is_root=via is None), self.scope)
        return made

    def _cached(self, key: Any, path: Path, name: str, include: Span | None, read: Callable[[], Any]) -> Any:
        source, tree = self.cache.get(key, (None, None))
        if source is None or read_utf8(path, name, include) != source:
            tree = read()
            self.cache[key] = getattr(getattr(tree, "span", None), "source", None), tree
        return tree

    def _include(self, item: Map, by: Path, place: Place, within: tuple[Path, ...]) -> Map | None:
        check_include(item, self.scope, INCLUDE_KINDS)
        name, package, values = item.get("file"), item.get("package"), item.get("args")
        if isinstance(values, Map):
            self.offered.append(values)
            for key, value in values.items():  # arguments of an outer include take precedence
                self.given.setdefault(key, (value, value_place(values, key)))
        if not isinstance(name, str) or not isinstance(package or "", str):
            return None
        try:
            target = self.target(name, package, by, self.packages_of(item, by))
        except LoadError as problem:
            found = problem.diagnostic
            where = value_place(item, "package") if found.rule == "wrong-type" else place
            self.scope.report(found.rule, found.message, where, found.help)
            return None
        if resolve(target) in within:
            message = f"{name} includes itself, directly or through others"
            self.scope.report("include-cycle", message, place, 'remove this entry of "include"')
            return None
        if len(self.files) >= MAX_FILES or len(within) > MAX_NESTED:
            message = f"more than {MAX_FILES:,} files are included, or more than {MAX_NESTED} within each other"
            self.scope.report("include-too-many", message, place, "include fewer files")
            return None
        before = len(self.diagnostics)
        via = Include("included here", place.span, place.via)
        via.included = self._includes
        self._includes.setdefault(label(target), via)
        if (made := self.read(target, via, within)) is None:
            self.diagnostics[before:] = [with_nearest_file(one, name, target) for one in self.diagnostics[before:]]
        return made

    def target(self, name: str, package: str | None, by: Path, packages: Mapping[str, Path]) -> Path:
        """Return the path of the file ``name`` that ``by`` includes. Raises LoadError if it cannot be included."""
        file = name
        if package and name.startswith(ADDRESS):
            raise LoadError(error("wrong-type", f"{name} already names a package", None, 'remove the key "package"'))
        if name.startswith(ADDRESS):
            package, _, file = name.removeprefix(ADDRESS).partition("/")
        if package is None:
            target = by.parent / name
            if self.is_inside(target):
                return target
            outer = self._package_of(by)
            where = f'the folder of the package "{outer}"' if outer else "the project of the description"
            help = f'move it inside, or write "{ADDRESS}NAME/FILE" if it is in a ROS package'
            raise LoadError(error("include-outside", f"{name} is outside {where}", None, help))
        if (folder := self.package(package, packages, by)) is None:
            help = f'source its workspace, or use "--package {package}=FOLDER", or "packages" in the entry'
            raise LoadError(error("package-missing", f'the ROS package "{package}" is not found', None, help))
        inner = Path(os.path.normpath(file))
        if inner.is_absolute() or inner.parts[:1] in ((), (os.pardir,)):
            message = f'{file} is outside the folder of the package "{package}"' if file else "the file name is missing"
            help = f'name a file in the package: "{ADDRESS}{package}/FILE"'
            raise LoadError(error("include-outside", message, None, help))
        self._package_folders[Path(os.path.abspath(folder))] = package
        return Path(label(folder / inner))

    def packages_of(self, item: Map, by: Path) -> dict[str, Path]:
        """Map package names to folders: the key ``packages`` of an include, overridden by folders from the caller."""
        named = item.get("packages")
        folders = named.items() if isinstance(named, Map) else ()
        return {**{name: by.parent / str(folder) for name, folder in folders}, **self.packages}

    def package(self, name: str, packages: Mapping[str, Path], by: Path) -> Path | None:
        """Return the folder of a ROS package that the file ``by`` refers to, or None if it is not found."""
        folder = Packages(packages, os.environ, by).find(name)
        if name not in packages and folder is not None:
            self.resolved.append(PackageFolder(project.ROS_PACKAGE, name, Path(os.path.abspath(folder))))
        return folder

    def is_inside(self, target: Path) -> bool:
        """Return True if a file, with symlinks resolved, is in the project or in a package of the description."""
        with suppress(OSError, RuntimeError, ValueError):
            return any(map(resolve(target).is_relative_to, self.projects)) or bool(self._package_of(target))
        return False

    def _package_of(self, path: Path) -> str:
        folders = [folder for folder in self._package_folders if Path(os.path.abspath(path)).is_relative_to(folder)]
        return self._package_folders[max(folders, key=lambda folder: len(folder.parts))] if folders else ""

    def _own_sections(self, file: Map, is_root: bool) -> Map:
        made = Map(file.span, file.via)
        self.sourced += [file] if not is_root and "source" in file else []
        for key, value in file.items():
            is_help = key == "help" and isinstance(value, str)  # a file with parts may have a help text: ignore it
            if key in ("include", "let") or (not is_root and (is_help or key in ("source", "rosorin_compile"))):
                continue
            if key == "robot" and not is_root:
                help = "include the files that it includes, or the URDF that is compiled from it"
                help = help if self._package_of(Path(file.span.source.path)) else "remove it"
                message = 'an included file must not have the key "robot"'
                self.scope.report("included-robot", message, key_place(file, key), help)
                continue
            has_source = key == "use" or (key in sections() and sections()[key].sourced)
            is_sourced = has_source and isinstance(value, Map) and "source" in file
            value = with_sources(value, file) if is_sourced else value
            made.put(key, value, file.key_spans[key], file.value_spans[key])
        return made

    def parts_file(self, name: str) -> Path | None:
        """Return the path of the parts file "FILE" (in the library) or "PACKAGE:FILE", or None if it does not exist."""
        package, colon, file = name.rpartition(":")
        folder = project.python_folder(package) if colon else project.data_folder("parts_library")
        if colon and folder is not None:
            self.resolved.append(PackageFolder(project.PYTHON_PACKAGE, package, Path(os.path.abspath(folder))))
        if folder is None or not file or os.sep in file or file.startswith(".") or not is_file(folder / f"{file}.yaml"):
            return None
        path = folder / f"{file}.yaml"
        self.files += [path] if colon and path not in self.files else []
        return path

    def load_function(self) -> Callable[[Any], Any]:
        """Return the function ``load`` for expressions, which reads a YAML file of the project or a package."""

        @cache
        def load(name: Any) -> Any:
            if not isinstance(name, str):
                raise ExpressionError("load takes the name of a YAML file")
            try:
                path = self.target(name, None, self.root, self.packages)
                path = path if name.startswith(ADDRESS) else self.folder / name
                self.files.append(path)
                read = partial(parse_yaml, read_utf8(path, label(path)))
                return self._cached(path, path, label(path), None, read)
            except LoadError as problem:
                found, span = problem.diagnostic, problem.diagnostic.span
                where = f" ({span.source.path}:{span.line}:{span.column})" if span else ""
                raise ExpressionError(f"{found.message}{where}", help=found.suggest or found.help) from None

        return load

    def find_function(self) -> Callable[..., Any]:
        """Return the function ``find`` for expressions, which returns the folder of a ROS package."""
        package = cache(partial(self.package, packages=self.packages, by=self.root))

        def find(name: Any, *default: Any) -> Any:
            if not isinstance(name, str) or len(default) > 1:
                raise ExpressionError("find takes the name of a ROS package, and a value to use if it is not found")
            folder = package(name)
            if folder is None and not default:
                help = f'source its workspace, or write "--package {name}=FOLDER"'
                raise ExpressionError(f'the ROS package "{name}" is not found', help=help)
            return default[0] if folder is None else str(folder)

        return find


def check_include(entry: Map, scope: Scope, kinds: Mapping[str, type], keys: Sequence[str] = ()) -> bool:
    """Report invalid keys and values of an ``include`` entry; return True if there are none.

    ``kinds`` maps keys to their types; ``keys`` are additional valid keys, whose values are not checked.
    """
    good = check_entry('the entry of "include"', entry, scope, (*kinds, *keys), kinds)
    packages = entry.get("packages")
    if isinstance(packages, Map):
        good &= check_entry('"packages"', packages, scope, None, dict.fromkeys(packages, str))
    if not entry.get("file"):
        message, help = 'the entry of "include" needs the key "file"', 'write "include: [FILE.yaml]"'
        scope.report("wrong-type", message, Place(entry.span, scope.via or entry.via), help)
        good = False
    return good


def with_nearest_file(diagnostic: Diagnostic, name: str, target: Path) -> Diagnostic:
    """If ``diagnostic`` reports that ``target`` is missing, suggest the most similar file name in its folder."""
    is_missing = diagnostic.rule == "file-unreadable" and not exists(target)
    close = Description.nearest_file(target) if is_missing else None
    return replace(diagnostic, help=suggest(f"{name[: name.rfind('/') + 1]}{close.name}")) if close else diagnostic

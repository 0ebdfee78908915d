"""Files: a description read with all that it includes, its sections joined, nothing evaluated yet.

``table_loader`` gives expressions their ``load``: YAML files of plain values to look things up in.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...diagnostics import Diagnostic, Related, Span, error
from ...diagnostics.progress import step
from ...diagnostics.registry import FILES, Rule
from ...project import ENDINGS, PYTHON_PACKAGE, Resolved, data_folder, projects_of, python_folder, resolved, shown
from ..expression.functions import ExpressionError
from ..load import LoadError, load_mapping, parse_yaml, read_text
from ..tree import Instance, Map, Place, Seq, locate
from .nearby import corrected, outside, outside_of
from .parts import copy, sourced

if TYPE_CHECKING:
    from .included_robots import ForeignReader

RULES = (
    Rule(
        "include-outside",
        "An included file is outside the project: the folder that has `descriptions`, or that of a lone description.",
        "Move it inside; a robot may also be in a ROS `package`.",
        FILES,
    ),
    Rule("include-cycle", "A file includes itself, directly or through others.", "Remove one `include`.", FILES),
    Rule("include-too-many", "More files are included than any description has.", "Join some.", FILES),
    Rule("included-robot", "An included file has the key `robot`.", "Only the first file names the robot.", FILES),
)


MAX_FILES = 500

_JOINED = (
    "links",
    "materials",
    "joints",
    "sensors",
    "publishers",
    "servos",
    "poses",
    "modes",
    "outputs",
    "args",
    "parts",
    "sensor_types",
    "use",
)
_LISTED = ("edges", "disabled_contacts", "urdf_elements", "accept")
_SOURCED = ("links", "joints", "sensors", "servos", "poses", "use")
_PRIVATE = ("include", "let", "source", "rosorin_compile")


class Asked(NamedTuple):
    """An include of a foreign robot: what it says, where, and the file in which it stands."""

    item: Map
    place: Place
    by: Path


def foreign(item: Any, place: Place, by: Path, endings: Callable[[], tuple[str, ...]]) -> Asked | None:
    """Return an entry of ``include`` that is about a foreign robot, whose file has one of ``endings``; else None."""
    name = item.get("file") if isinstance(item, Map) else item
    is_foreign = isinstance(name, str) and not name.endswith(ENDINGS) and name.lower().endswith(endings())
    if isinstance(item, Map):
        return Asked(item, place, by) if is_foreign or "package" in item else None
    if not is_foreign:
        return None
    made = Map(place.span, place.via)
    made.put("file", item, place.span, place.span)
    return Asked(made, place, by)


class Reader:
    """Reads a file and what it includes; collects named values, foreign robots, files and what is wrong."""

    def __init__(self, root: Path, robots: ForeignReader | None) -> None:
        # Without a reader whatever is no YAML is another one's robot.
        self.foreign_endings = robots.endings if robots else lambda: ("",)
        self.folder = root.parent.resolve()
        self.projects = projects_of(root)
        self.project = self.projects[0]
        self.files: list[Path] = []
        self.resolved: list[Resolved] = []
        self.lets: list[tuple[str, Any, Place, Place]] = []
        self.given: dict[str, tuple[Any, Place]] = {}
        self.offered: list[Any] = []
        self.diagnostics: list[Diagnostic] = []
        self.robots: list[Asked] = []

    def read(
        self, path: Path, name: str, asked: Span | None, via: Instance | None, within: tuple[Path, ...]
    ) -> Map | None:
        """Return a file joined with its includes; None if it cannot be read."""
        self.files.append(path)
        step("reading files", len(self.files))
        try:
            file = load_mapping(path, name, asked, via)
        except LoadError as problem:
            diagnostic = problem.diagnostic
            stack = tuple(via.stack()) if via else ()
            # Where the file cannot be read, the diagnostic points at the include itself: that needs no note.
            led_here = stack[1:] if diagnostic.span == asked else stack
            self.diagnostics.append(diagnostic._replace(related=diagnostic.related + led_here))
            return None
        made = Map(file.span, via)
        for item, span in self._includes(file):
            robot = foreign(item, Place(span, via), path, self.foreign_endings)
            if robot is not None:
                self.robots.append(robot)
                continue
            included = self._include(item, path, Place(span, via), (*within, path.resolve()))
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
        try:
            if not path.is_file():
                return None
        except (OSError, ValueError):  # a name that no file can have
            return None
        if colon and path not in self.files:
            self.files.append(path)
        return path

    def _includes(self, file: Map) -> list[tuple[Any, Span]]:
        names = file.get("include")
        if names is None:
            return []
        if not isinstance(names, Seq):
            self._error("wrong-type", "include is a list of file names", locate(file, ("include",)), "write [arm.yaml]")
            return []
        return list(zip(names, names.value_spans, strict=True))

    def _include(self, item: Any, path: Path, place: Place, within: tuple[Path, ...]) -> Map | None:
        """Return an included file; it must stand inside the project and not include itself."""
        name = item.get("file") if isinstance(item, Map) else item
        if isinstance(item, Map):
            self._collect_given(item)
        if not isinstance(name, str) or not name:
            self._error("wrong-type", "include names files: text", place, "write the name of a YAML file")
            return None
        target = path.parent / name
        if not self.inside(target):
            self._error("include-outside", outside(name, path, self.project), place, "move it inside")
            return None
        real = target.resolve()
        if real in within:
            self._error("include-cycle", f"{name} includes itself, directly or through others", place, "remove one")
            return None
        if len(self.files) >= MAX_FILES:
            self._error("include-too-many", f"more than {MAX_FILES} files are included", place, "include fewer files")
            return None
        before = len(self.diagnostics)
        made = self.read(target, shown(target), place.span, Instance("included here", place.span, place.via), within)
        if made is None:
            self.diagnostics[before:] = [corrected(one, name, target) for one in self.diagnostics[before:]]
        return made

    def inside(self, target: Path) -> bool:
        """Say whether a file is inside the project of the description, links followed."""
        try:
            real = target.resolve()
            return any(real.is_relative_to(project) for project in self.projects)
        except (OSError, RuntimeError, ValueError):
            return False

    def _collect_given(self, item: Map) -> None:
        """Take down the arguments that an include gives; a description that includes this one has the last word."""
        values = item.get("args")
        for key in item:
            if key not in ("file", "args"):
                place = Place(item.key_spans[key], item.via)
                self._error("unknown-key", f'an include has no key "{key}"', place, "known: args, file")
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
        for key, value in file.items():
            if key in _PRIVATE and not (root and key in ("source", "rosorin_compile")):
                continue
            if key == "robot" and not root:
                place = locate(file, (key,), key=True)
                self._error("included-robot", "an included file does not name the robot", place, "remove it")
                continue
            if key in _SOURCED and isinstance(value, Map) and "source" in file:
                value = sourced(value, file)
            made.put(key, value, file.key_spans[key], file.value_spans[key])
        return made

    def join(self, made: Map, more: Map) -> None:
        """Add the sections of one file to those of the others."""
        for key, value in more.items():
            if key not in made or made[key] is None:
                joined = copy(value) if key in _JOINED or key in _LISTED else value
                made.put(key, joined, more.key_spans[key], more.value_spans[key])
            elif key in _JOINED and isinstance(value, Map) and isinstance(made[key], Map):
                self._join_section(key, made[key], value)
            elif key in _LISTED and isinstance(value, Seq) and isinstance(made[key], Seq):
                for item, span in zip(value, value.value_spans, strict=True):
                    made[key].put(item, span)
            elif value is not None:
                self._cannot_join(key, made, more)

    def _cannot_join(self, key: str, made: Map, more: Map) -> None:
        """Report a section of which two files say different kinds, or a single value said twice."""
        related = [Related("first defined here", made.key_spans[key])]
        place = locate(more, (key,), key=True)
        if key in _JOINED or key in _LISTED:
            wanted = "a mapping" if key in _JOINED else "a list"
            self._error("wrong-type", f"{key} is {wanted} in every file", place, "write it so in both", related)
        else:
            self._error("duplicate-key", f'"{key}" is said twice', place, "remove one", related)

    def _join_section(self, section: str, made: Map, more: Map) -> None:
        for name, entry in more.items():
            if name in made:
                related = [Related("first defined here", made.key_spans[name])]
                message = f'{section.rstrip("s")} "{name}" is defined twice'
                self._error("duplicate-name", message, locate(more, (name,), key=True), "rename or remove one", related)
                continue
            made.put(name, entry, more.key_spans[name], more.value_spans[name])

    def _error(self, rule: str, message: str, place: Place, help: str, related: Sequence[Related] = ()) -> None:
        self.diagnostics.append(error(rule, message, place.span, help, [*related, *place.stack()]))


def table_loader(reader: Reader) -> Callable[[Any], Any]:
    """Return the function ``load`` of a description: the value of a YAML file inside its project, read once."""
    loaded: dict[str, Any] = {}

    def load(name: Any) -> Any:
        if not isinstance(name, str):
            raise ExpressionError("load takes the name of a YAML file")
        if name not in loaded:
            path = reader.folder / name
            if not reader.inside(path):
                raise ExpressionError(f"{name} is {outside_of(reader.project)}")
            reader.files.append(path)
            try:
                loaded[name] = parse_yaml(read_text(path, shown(path)))
            except LoadError as problem:
                diagnostic = problem.diagnostic
                span = diagnostic.span
                where = f" ({span.source.path}:{span.line}:{span.column})" if span else ""
                raise ExpressionError(f"{diagnostic.message}{where}", help=diagnostic.help) from None
        return loaded[name]

    return load

"""``Format``: the definition of a file format, in this program or in a plug-in (``docs/extend.md``).

An artifact contains the values of all YAML keys in ``covers``, except keys in ``unsupported`` and keys for another
format (``mjcf``, ``gazebo``). A key such as "joints.limit" includes all keys below; "*" matches any name.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Link, Output
from rosorin_compile.model.link import Source as Provenance
from rosorin_compile.model.link import limited_fields
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Source, Span, error
from rosorin_compile.source.messages import and_here
from rosorin_compile.source.rule_registry import Rule
from rosorin_compile.source.tree import Map
from rosorin_compile.source.wording import count_of, mask_controls, phrase
from rosorin_compile.source.xml.elements import canonical, tree_of
from rosorin_compile.source.xml.markup import Document, MarkupError, read_source

if TYPE_CHECKING:
    from rosorin_compile.model import Robot
    from rosorin_compile.rules.case import Case

    from .imported_robot import ImportedRobot, Proof, ReadOptions
    from .mesh_files import SearchResult
    from .templating import Templates


@dataclass(frozen=True)
class Artifact:
    """A generated file: its path in the output folder, its text, its format and the name of its output."""

    file: str
    text: str = field(repr=False)
    backend: str  # name of the format
    output: str  # name of the output
    withheld: bool = False  # nodes such as robot_state_publisher must not read it


class Refusal(NamedTuple):
    """The result of loading an artifact in an engine, such as MuJoCo; ``reason`` is the error or ""."""

    reason: str = ""
    outdated: bool = False  # the engine is too old for the artifact
    missing: str = ""  # name of the engine if the engine is not installed, or ""


_NUMBERS = "short: error below 1e-12 of the largest component; exact: lossless; six: %.6g or %.6f; default: short."
NUMBER_FORMAT: Mapping[str, Any] = {"enum": ["short", "exact", "six"], "description": _NUMBERS}
# Ways to split a height map into boxes, for formats without height maps.
FORMS_OF_BOXES = ["rows", "merged", "grounded"]
BOXES_OF_HEIGHT_MAPS = (
    "rows: a box for each run of equal heights in a row; merged: boxes of equal height along x and y; grounded: like"
    " rows, but down to z = 0 regardless of bottom"
)
_HEIGHT_MAPS = f"How to split a height map into boxes; {BOXES_OF_HEIGHT_MAPS}; default: rows."
HEIGHT_MAPS: Mapping[str, Any] = {"enum": FORMS_OF_BOXES, "description": _HEIGHT_MAPS}
_VISUALS = "from_collision: links without visuals show their collision shapes, with a colour per link."
VISUALS: Mapping[str, Any] = {"enum": ["from_collision"], "description": _VISUALS}

# Supported ROS 2 distributions. Distributions after Jazzy are treated like Jazzy.
HUMBLE, JAZZY = "humble", "jazzy"
DISTRIBUTIONS = [HUMBLE, JAZZY, "kilted", "lyrical", "rolling"]

# A description as plain YAML values: mappings, lists, strings, and numbers in SI units or quantities ("40 mm").
Description = Mapping[str, "Any"]
Reasons = Mapping[str, "Unsupported | None"]
Where = int | Span  # a line number or a source position
Writer = Callable[["Robot", "Output", "Templates"], tuple[str, "list[Diagnostic]"]]


class SourceValue(NamedTuple):
    """A value of a description with its source position."""

    value: Any
    span: Span


@dataclass(frozen=True)
class ImportFile:
    """A file to import, as passed to ``Format.load``.

    Lines and columns start at 1. ``text`` and ``source`` raise MarkupError, which a reader does not need to catch.
    """

    path: Path
    options: ReadOptions
    document: Document | None = None  # None if the file is not XML
    asked: Span | None = None  # position of the reference to the file, such as an entry of ``include``

    @property
    def text(self) -> str:
        return self.source.text

    @cached_property
    def source(self) -> Source:
        return self.document.source if self.document else read_source(self.path, self.asked)

    @property
    def xml(self) -> Document:
        """The parsed XML document. Raises ValueError if the file is not XML."""
        if self.document is None:
            raise ValueError(f"{self.path} is not XML")
        return self.document

    def with_span(self, value: Any, where: Where, column: int = 1, length: int = 1) -> SourceValue:
        """Attach a source position to a value, so that diagnostics can refer to it."""
        return SourceValue(value, self._span(where, column, length))

    def problem(self, message: str, where: Where = 1, column: int = 1, length: int = 1, help: str = "") -> MarkupError:
        """Return an exception that a reader raises if the file is invalid."""
        return MarkupError(error("file-syntax", message, self._span(where, column, length), help))

    def left_out(self, what: str, where: Where, column: int = 1, length: int = 1, help: str = "") -> Diagnostic:
        """Return a warning that ``what`` is not imported, because a description cannot express it."""
        return cannot_carry(what, self._span(where, column, length), help)

    def _span(self, where: Where, column: int, length: int) -> Span:
        return where if isinstance(where, Span) else Span(self.source, where, column, length)


def cannot_carry(what: str, span: Span, help: str = "", many: bool = False, others: Sequence[Span] = ()) -> Diagnostic:
    """Return a warning that a description cannot express ``what``; ``many`` is True if ``what`` is a plural."""
    message = f"{what} {'are' if many else 'is'} not carried over"
    return Diagnostic("import-cannot-carry", WARNING, message, span, and_here(others), help)


def describe(source: Provenance) -> str:
    """Format a ``source`` entry (status, measurement and note) as one line, or return "" if it is empty."""
    head = ", ".join(part for part in (source.status.replace("_", "-"), source.measured) if part)
    return mask_controls(" ".join(": ".join(part for part in (head, source.note) if part).split()))


def xml_syntax(text: str) -> object:
    """Parse XML to a canonical form for ``Format.syntax``. Raises ValueError if it is not well-formed."""
    return canonical(tree_of(text))


class OutputEntry(NamedTuple):
    """An entry of ``outputs`` for an imported robot, and a remark for the user if an option is unusual."""

    entry: Mapping[str, Any]
    remark: str = ""


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)  # generated methods would slow down every start
class Format:
    """A file format that is written, read, or both. Most fields are optional.

    ``write`` raises TemplateProblem; ``read`` raises ValueError for a damaged text. To find differences, the result of
    ``view`` is compared with the result of ``read``. Without these functions, artifacts are compared only as text.
    """

    name: str  # key under ``outputs``
    word: str  # name in sentences, such as "URDF"; ``article`` is "a" or "an"
    article: str = ""
    files: str = ""  # entry in lists of formats; default: ``word`` and the root elements
    about: str = "another artifact"  # purpose, for lists of formats
    rank: int = 1000  # position in lists of formats, in ascending order
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # JSON Schema of each option
    check: Callable[[Case, Output], Iterator[Diagnostic]] | None = None  # yields errors in ``options``
    rules: tuple[Rule, ...] = ()  # additional rules of a plug-in, for its diagnostics
    file: str = ""  # default file name; {} is replaced by the name of the robot
    endings: tuple[str, ...] = ()  # file name extensions
    roots: tuple[str, ...] = ()  # tags of the root element, for XML
    recognises: Callable[[Document, Path], bool] | None = None  # True for XML in this format; overrides ``roots``

    write: Writer | None = None
    view: Callable[[Robot, Output], Any] | None = None  # values that an artifact must contain
    read: Callable[[str], Any] | None = None  # parses an artifact; same type as ``view``
    rounding: tuple[float, float] = (0.0, 0.0)  # largest rounding errors of numbers in ``view`` (m, rad)
    partial: bool = False  # compare only values in ``view``, although ``read`` returns more
    covers: tuple[str, ...] = ()  # YAML keys that artifacts contain; () for all
    # {covered key: reason why an output does not contain it, or None if it does}, or a function that returns this.
    unsupported: Reasons | Callable[[Output], Reasons] = field(default_factory=dict)
    # Functions and flags for reading files in this format with ``import``, ``include`` and ``diff``.
    load: Callable[[ImportFile], ImportedRobot | Description | tuple[Description, Sequence[Diagnostic]]] | None = None
    include: bool = True  # whether a description can include such a file
    takes_arguments: bool = False
    becomes: str = ""  # name of the format after preprocessing, such as "urdf" for xacro
    # Reads a companion file, such as an SRDF. Returns the sections to add to a description, and diagnostics.
    join: Callable[[ImportFile, Map], tuple[Mapping[str, Any], Sequence[Diagnostic]]] | None = None
    is_other: Callable[[Document], bool] | None = None  # True for such a companion file
    # Returns the entry of ``outputs`` for an imported robot; takes its YAML tree, format version and file name.
    asked: Callable[[Map, str, str], OutputEntry | None] | None = None
    optional: bool = False  # omit the output with a remark if a robot cannot be written in this format
    engine_reads: bool = False  # the engine parses imported files itself and tolerates some malformed XML
    # Loads an artifact and its imported source in the engine, and compares them; takes the text and the mesh files.
    prove: Callable[[ImportedRobot, str, Mapping[str, str]], Proof] | None = None
    # Functions and flags for comparing two robots or the texts of two artifacts.
    links: Callable[[Robot, Output], Collection[str]] | None = None  # links that an output contains
    leaves_out: Callable[[Robot, str], bool] | None = None  # True if no artifact contains the link
    why: str = ""  # reason for ``leaves_out``
    adds: Callable[[Robot, str, Robot], bool] | None = None  # True if the writer of a file added the link
    brings: Callable[[Robot, Output], Sequence[str]] | None = None  # URDF elements that an output generates
    names_robot: bool = True  # whether its files contain the name of the robot
    names: Callable[[Output], Mapping[str, str]] | None = None  # {name in an artifact: link}
    syntax: Callable[[str], object] | None = None  # syntax tree of a text; raises ValueError, SyntaxError
    schema: str = ""  # name of its JSON Schema in ``schemas/``
    data: Callable[[str], Any] | None = None  # converts a text that is not JSON for ``schema``; raises ValueError
    differ: Callable[[str, str], str] | None = None  # describes the difference of two texts with equal values
    shown: bool = True  # readable for people, so that ``check`` prints a diff
    refusal: Callable[[str, Path], Refusal] | None = None  # loads an artifact (text, folder) in an engine
    # Files on which an artifact depends.
    located: bool = False  # artifacts contain paths of other artifacts, so ``package`` does not copy them
    meshes: bool = False  # artifacts refer to meshes in the same way as a URDF
    opens: Callable[[str], str] | None = None  # path of a mesh relative to the artifact, or "" if unsupported
    copies: Callable[[SearchResult, Path], SearchResult] | None = None  # adds the mesh files to copy
    embeds: bool = False  # artifacts contain the mesh data
    measures: bool = False  # artifacts depend on the sizes of meshes
    beside: Callable[[str], Sequence[str]] | None = None  # names of files that must be in the same folder
    # ROS.
    feeds: tuple[str, ...] = ()  # ROS nodes that read artifacts, such as robot_state_publisher
    withheld: Callable[[Output], bool] | None = None  # True if these nodes must not read an output
    folder: str = ""  # folder in a ROS package; default: by file extension
    deploys: bool = False  # ``deploy`` copies an artifact even if the target package has no earlier copy
    robot_of: Callable[[Path], str] | None = None  # reads the robot's name if there is no header comment

    @property
    def is_xml(self) -> bool:
        return bool(self.roots or self.recognises)

    @property
    def article_name(self) -> str:
        """The name with its article, such as "a URDF"."""
        return f"{self.article} {self.word}".strip()

    @property
    def list_name(self) -> str:
        """How the format appears in a list of formats: the name and the root elements, such as URDF (<robot>)."""
        return self.files or f"{self.word}{''.join(f' (<{root}>)' for root in self.roots)}"

    def compile(self, robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
        """Return the generated text of an output, and diagnostics. Raises ValueError for a format without ``write``."""
        if self.write is None:
            raise ValueError(f"{self.word} is not written")
        return self.write(robot, output, templates)

    def is_withheld(self, output: Output) -> bool:
        return self.withheld is not None and self.withheld(output)

    def output(self, robot: Robot) -> Output | None:
        return next((output for output in robot.outputs if output.backend == self.name), None)


# Keys for specific formats; other formats do not report these keys as unsupported.
ADDRESSED = {"mjcf": ("mjcf",), "mjcf_elements": ("mjcf",), "gazebo": ("sdf", "urdf"), "urdf_elements": ("urdf",)}
# Keys that control how a description is read and checked. ``REMARKS`` are keys that document values.
_TECHNICAL = ("args", "let", "include", "accept", "outputs", "rosorin_compile", "modes", "links.inertial.of.name")
REMARKS = frozenset({"source", "stand_ins", "method", "reason", "about", "stamps"})

# Keys for the poses of frames. ``NODES`` and ``UNPUBLISHED`` are keys for the nodes that publish frames.
PLACES = (
    *("joints.parent", "joints.child", "joints.xyz", "joints.rpy", "sensors.parent", "sensors.frame"),
    *("sensors.xyz", "sensors.rpy", "sensors.optical.frame", "sensors.optical.xyz", "sensors.optical.rpy"),
)
_PUBLISHER = ("joints.publisher", "sensors.publisher", "sensors.optical.publisher")
_TURNS = (".static_transform_publisher", ".by.static_transform_publisher", ".when")
NODES = tuple(f"{publisher}{turn}" for publisher in _PUBLISHER for turn in _TURNS)
UNPUBLISHED = tuple(f"{publisher}.none" for publisher in _PUBLISHER)

# Keys that every format for a complete robot covers.
MODEL_KEYS = ("robot", "links", "joints", "materials", "sensors", "root", "actuators", "disabled_contacts")

_GEOMETRY = (
    *("box", "cylinder", "capsule", "sphere", "ellipsoid", "mesh.file", "mesh.scale", "height_map.origin"),
    *("height_map.cell", "height_map.heights", "height_map.bottom", "xyz", "rpy"),
)
SHAPES = tuple(f"links.{purpose}.{key}" for purpose in ("collision", "visual") for key in _GEOMETRY)


class Unsupported(NamedTuple):
    """The reason why artifacts of a format do not contain a YAML key."""

    reason: str
    quiet: bool = False  # do not report it to the user
    one_way: bool = False  # written but not read back, so ``diff`` does not compare it


def _quiet(reason: str, *keys: str) -> dict[str, Unsupported]:
    return {key: Unsupported(reason, quiet=True) for key in keys}


_CONTACTS = ("condim", "priority", "solmix", "solref", "solimp", "margin", "gap")
# Keys for MuJoCo without an equivalent in other formats.
OF_MUJOCO: Mapping[str, Unsupported] = {
    **_quiet("how MuJoCo couples joints", *(f"joints.*.mimic.{key}" for key in ("name", *_CONTACTS))),
    **_quiet("how MuJoCo computes contacts", *(f"links.*.collision.*.contact.{key}" for key in _CONTACTS)),
    **_quiet("marks that sensors and actuators of MuJoCo name", "links.*.sites"),
    **_quiet("what MuJoCo takes a mesh for", "links.*.collision.*.mesh.inertia", "links.*.visual.*.mesh.inertia"),
    **_quiet("how the base moves in the world of a simulation", "root"),
    "joints.*.dynamics.armature": Unsupported("no inertia of rotors"),
    "links.*.cameras": Unsupported("cameras that are not sensors"),
    "links.*.lights": Unsupported("no lights"),
    **{f"links.*.collision.*.contact.friction.{item}": Unsupported("only sliding friction") for item in (1, 2)},
    **{f"links.*.collision.*.contact.{key}": Unsupported("no bits of contacts") for key in ("contype", "conaffinity")},
}
# Keys for nodes that publish frames. Sensors are written as links, and read back as links.
OF_PUBLISHERS: Mapping[str, Unsupported] = {
    **_quiet("for launch files", "joints.*.publisher", "sensors.*.publisher", "sensors.*.optical.publisher"),
    "sensors": Unsupported("sensors are read as links", one_way=True),
}


def is_within(key: str, prefixes: Iterable[str]) -> bool:
    """Return True if a key is equal to or below a key in ``prefixes``, in which "*" matches any name."""
    return any(f"{key}.".startswith(f"{prefix.replace('.*', '')}.") for prefix in prefixes)


def reason(format: Format, output: Output, key: str, one_way: bool = False) -> Unsupported | None:
    """Return the reason why an output does not contain a key, or None if it must contain the key.

    With ``one_way``, a reason is also returned for keys that are written but cannot be read back.
    """
    steps = key.split(".")
    if is_within(key, _TECHNICAL) or not REMARKS.isdisjoint(steps):
        return Unsupported("it is about the description", quiet=True)
    for step in steps:
        if format.name not in ADDRESSED.get(step, (format.name,)):
            return Unsupported(f"{step} is for {phrase(ADDRESSED[step])}", quiet=True)
    table = _table(format, output).items()
    found = [why for prefix, why in table if is_within(key, [prefix]) and (one_way or not (why and why.one_way))]
    if None not in found and format.covers and not is_within(key, format.covers):
        return Unsupported(f"a {format.word} has {phrase(format.covers)}", quiet=True)
    return None if None in found or not found else found[0]


def lacks(format: Format, key: str) -> bool:
    """Return True if robots that are read from files in a format (with default options) never have a key."""
    return reason(format, Output(format.name, format.name, ""), key, one_way=True) is not None


def _table(format: Format, output: Output) -> Mapping[str, Unsupported | None]:
    found = dict(format.unsupported(output) if callable(format.unsupported) else format.unsupported)
    for name, formats in limited_fields(Link).items():
        if format.name in formats:
            found[f"links.*.{name}"] = None
        elif "links" in format.covers:
            found[f"links.*.{name}"] = Unsupported(f"only in {phrase(formats)}")
    return found


def notes(tree: Map, outputs: Iterable[Output], formats: Mapping[str, Format]) -> Iterator[Diagnostic]:
    """Yield a note for each format, or for one output of it, that does not support some keys of the description."""
    outputs = list(outputs)
    for name in dict.fromkeys(output.backend for output in outputs):
        some = [(output, _lost(formats[name], output)) for output in outputs if output.backend == name]
        in_all = [key for key in some[0][1] if all(key in keys for _, keys in some)]
        own = [(output.file, output, [key for key in keys if key not in in_all]) for output, keys in some]
        for subject, output, keys in [(formats[name].word, some[0][0], in_all), *own]:
            counts = {key: _count(tree, key) for key in keys}
            found = [f"{key.replace('.*', '')} ({count_of(count, 'place')})" for key, count in counts.items() if count]
            if found:
                span = tree.locate(("outputs", output.name), key=True).span
                yield Diagnostic("not-in-format", NOTE, f"{subject} cannot express {phrase(found)}", span)


def _lost(format: Format, output: Output) -> list[str]:
    return [key for key, why in _table(format, output).items() if why and not (why.quiet or why.one_way)]


def _count(tree: Map, key: str) -> int:
    """Count the values at a key such as "links.*.sites"; "*" matches any entry, and "1" the second item of a list."""
    found: list[Any] = [tree]
    for step in key.split("."):
        lists, maps = [one for one in found if isinstance(one, list)], [one for one in found if isinstance(one, dict)]
        if step == "*":
            found = [item for one in lists for item in one] + [item for one in maps for item in one.values()]
            continue
        found = [one[step] for one in maps if step in one]
        found += [one[int(step)] for one in lists if step.isdecimal() and int(step) < len(one)]
    return sum(item not in (None, [], {}) and item is not False for item in found)

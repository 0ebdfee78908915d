"""The record of a format: a module that exports ``FORMAT``, or an entry point of another package (``docs/extend.md``).

A format carries the keys of the language that it ``covers``, without those that are ``unsupported`` and those that name
another format (``mjcf``, ``gazebo``). A key includes all keys below it; "*" is any name of an entry.
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

    from .imported_robot import Imported, Proof, ReadOptions
    from .mesh_files import Searched
    from .templating import Templates


@dataclass(frozen=True)
class Artifact:
    """One emitted file: its name in the output folder, its text, its format and the name of its output."""

    file: str
    text: str = field(repr=False)
    backend: str
    output: str
    withheld: bool = False  # publishers must not read the file, although they read its format


class Refusal(NamedTuple):
    """Why an engine does not load an artifact; empty if it does."""

    reason: str = ""
    outdated: bool = False  # the engine is too old for the artifact
    missing: str = ""  # the name of an engine that is not installed


_NUMBERS = "short (default): within 1e-12 of the largest in a vector; exact: reads back the same; six: %.6g or %.6f."
NUMBER_FORMAT: Mapping[str, Any] = {"enum": ["short", "exact", "six"], "description": _NUMBERS}
# The forms of boxes that height maps are cut into, for an option of formats that have no height maps.
FORMS_OF_BOXES = ["rows", "merged", "grounded"]
BOXES_OF_HEIGHT_MAPS = (
    "rows, one for each run of equal heights in a row; merged, equal heights along x and y; grounded, rows down to"
    " z = 0 whatever bottom says"
)
_HEIGHT_MAPS = f"The boxes of height maps; default: rows. {BOXES_OF_HEIGHT_MAPS}."
HEIGHT_MAPS: Mapping[str, Any] = {"enum": FORMS_OF_BOXES, "description": _HEIGHT_MAPS}
_VISUALS = "from_collision: a link without a visual is seen as its collision shapes, a colour a link."
VISUALS: Mapping[str, Any] = {"enum": ["from_collision"], "description": _VISUALS}

# Distributions of ROS 2: those that artifacts can be written for. Those after Jazzy are taken to be as it is.
HUMBLE, JAZZY = "humble", "jazzy"
DISTRIBUTIONS = [HUMBLE, JAZZY, "kilted", "lyrical", "rolling"]

# A description as plain values: what YAML would have, in SI units or as quantities ("40 mm").
Description = Mapping[str, "Any"]
Reasons = Mapping[str, "Unsupported | None"]
Where = int | Span  # a line, or the place of an element
Writer = Callable[["Robot", "Output", "Templates"], tuple[str, "list[Diagnostic]"]]


class Placed(NamedTuple):
    """A value of a description with its position in a file."""

    value: Any
    span: Span


@dataclass(frozen=True)
class Opened:
    """A file to be read: its path, the options, its elements if it is XML, and the position that names it.

    Lines and columns count from 1. ``text`` and ``source`` raise MarkupError, which the caller of a reader expects.
    """

    path: Path
    options: ReadOptions
    document: Document | None = None
    asked: Span | None = None

    @property
    def text(self) -> str:
        return self.source.text

    @cached_property
    def source(self) -> Source:
        return self.document.source if self.document else read_source(self.path, self.asked)

    @property
    def xml(self) -> Document:
        """The elements of an XML file. Raises ValueError for another one."""
        if self.document is None:
            raise ValueError(f"{self.path} is not XML")
        return self.document

    def at(self, value: Any, where: Where, column: int = 1, length: int = 1) -> Placed:
        """Return a value of a description with its position, for diagnostics."""
        return Placed(value, self._span(where, column, length))

    def problem(self, message: str, where: Where = 1, column: int = 1, length: int = 1, help: str = "") -> MarkupError:
        """Return the exception that a reader raises for a file that its format does not allow."""
        return MarkupError(error("file-syntax", message, self._span(where, column, length), help))

    def left_out(self, what: str, where: Where, column: int = 1, length: int = 1, help: str = "") -> Diagnostic:
        """Return the warning about content that a description cannot express."""
        return cannot_carry(what, self._span(where, column, length), help)

    def _span(self, where: Where, column: int, length: int) -> Span:
        return where if isinstance(where, Span) else Span(self.source, where, column, length)


def described_by(distribution: str) -> str:
    """Return the distribution whose facts are used for a distribution of ROS 2."""
    return HUMBLE if distribution == HUMBLE else JAZZY


def cannot_carry(what: str, span: Span, help: str = "", many: bool = False, others: Sequence[Span] = ()) -> Diagnostic:
    """Return the warning about content that the tree does not carry; ``many`` if ``what`` is a plural."""
    message = f"{what} {'are' if many else 'is'} not carried over"
    return Diagnostic("import-cannot-carry", WARNING, message, span, and_here(others), help)


def describe(source: Provenance) -> str:
    """Return where a value comes from as one line of printable text; empty if the description does not say."""
    head = ", ".join(part for part in (source.status.replace("_", "-"), source.measured) if part)
    text = ": ".join(part for part in (head, source.note) if part)
    return mask_controls(" ".join(text.split()))


def xml_syntax(text: str) -> object:
    """Return the elements of an XML text, for ``syntax``. Raises ValueError."""
    return canonical(tree_of(text))


class Asked(NamedTuple):
    """The entry of ``outputs`` in the description of an imported robot, and a remark on what is unusual in it."""

    entry: Mapping[str, Any]
    remark: str = ""


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)  # such methods would be compiled at every start
class Format:
    """A format that is written, read, or both. Most fields are optional.

    ``write`` raises TemplateProblem; ``read`` raises ValueError for a damaged text. ``view`` is compared with ``read``
    of a text before it is written, and of the committed text; without them, artifacts are compared as text.
    """

    name: str  # its name under ``outputs``
    word: str  # its name in sentences, such as "URDF", with its ``article``
    article: str = ""
    files: str = ""  # its files in a list of formats; default: the word and the root element
    about: str = "another artifact"  # its purpose
    rank: int = 1000  # its place in lists
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # the JSON Schema of each key of its output
    check: Callable[[Case, Output], Iterator[Diagnostic]] | None = None  # errors in an output that no schema finds
    rules: tuple[Rule, ...] = ()  # the rules of its diagnostics; only of a format of another package
    file: str = ""  # the usual name of a file; {} is the name of the robot
    endings: tuple[str, ...] = ()
    roots: tuple[str, ...] = ()  # the names of its root element, of XML
    recognises: Callable[[Document, Path], bool] | None = None  # whether an XML file is of the format; before ``roots``

    write: Writer | None = None
    view: Callable[[Robot, Output], Any] | None = None  # what an artifact must contain: a reduced Robot or a dataclass
    read: Callable[[str], Any] | None = None  # what the text of an artifact contains, as ``view``
    rounding: tuple[float, float] = (0.0, 0.0)  # by how much (m, rad) ``view`` rounds numbers
    partial: bool = False  # ``view`` leaves out some of what ``read`` finds: only its own leaves are compared
    covers: tuple[str, ...] = ()  # the keys of the language that it is about; () for all
    # The covered keys that an output does not carry, with the reason (None: it does); may depend on its options.
    unsupported: Reasons | Callable[[Output], Reasons] = field(default_factory=dict)
    # Foreign files, for ``import``, ``include`` and ``diff``.
    load: Callable[[Opened], Imported | Description | tuple[Description, Sequence[Diagnostic]]] | None = None
    include: bool = True  # a description may include such a file
    takes_arguments: bool = False
    becomes: str = ""  # the format that it is once it is read (xacro: urdf)
    # The sections that a companion file adds to the tree of a robot, and diagnostics.
    join: Callable[[Opened, Map], tuple[Mapping[str, Any], Sequence[Diagnostic]]] | None = None
    is_other: Callable[[Document], bool] | None = None  # whether a file is only such a companion of a robot
    # The output in the description of an imported robot, from its tree, its version and a name for files.
    asked: Callable[[Map, str, str], Asked | None] | None = None
    optional: bool = False  # that output is left out, with a remark, where the robot cannot be written so
    engine_reads: bool = False  # its engine reads the sources: what this ignores in XML is not an error
    # Compares an artifact in its engine with the source that it was imported from: its text, and its mesh files.
    prove: Callable[[Imported, str, Mapping[str, str]], Proof] | None = None
    # Comparing two robots or two texts.
    links: Callable[[Robot, Output], Collection[str]] | None = None  # the links that an output has
    leaves_out: Callable[[Robot, str], bool] | None = None  # whether it has no such link by nature
    why: str = ""  # the reason
    adds: Callable[[Robot, str, Robot], bool] | None = None  # whether a link of a file stands for something else
    brings: Callable[[Robot, Output], Sequence[str]] | None = None  # the XML elements made of words of the description
    names_robot: bool = True  # its files have the name of the robot
    names: Callable[[Output], Mapping[str, str]] | None = None  # names of links by those in an artifact
    syntax: Callable[[str], object] | None = None  # a text without layout and comments. Raises ValueError, SyntaxError
    schema: str = ""  # the JSON Schema of its texts, a name in ``schemas/``
    data: Callable[[str], Any] | None = None  # the value for the schema, of a text that is not JSON. Raises ValueError
    differ: Callable[[str, str], str] | None = None  # the difference between two texts with equal leaves, in words
    shown: bool = True  # its text is for people: ``check`` prints how two of them differ
    refusal: Callable[[str, Path], Refusal] | None = None  # why its engine does not load a text that is in a folder
    # Files that an artifact needs.
    located: bool = False  # its text depends on the folders of other artifacts: ``package`` does not copy it
    meshes: bool = False  # it names meshes as URDF does
    opens: Callable[[str], str] | None = None  # the file of a mesh as seen from the artifact; empty: not opened
    copies: Callable[[Searched, Path], Searched] | None = None  # adds the contents of these files
    embeds: bool = False  # it contains the meshes themselves
    measures: bool = False  # its text depends on the sizes of meshes
    beside: Callable[[str], Sequence[str]] | None = None  # the names of files that it needs in its folder
    # ROS.
    feeds: tuple[str, ...] = ()  # the kinds of publishers that read it
    withheld: Callable[[Output], bool] | None = None  # whether they must not read an output
    folder: str = ""  # its folder in a package; empty: chosen by its file extension
    deploys: bool = False  # ``deploy`` copies it there even if there is no copy yet
    robot_of: Callable[[Path], str] | None = None  # the robot that a file was generated for, if no comment names it

    @property
    def is_xml(self) -> bool:
        return bool(self.roots or self.recognises)

    @property
    def named(self) -> str:
        """The word with its article, as in "robot.urdf is a URDF"."""
        return f"{self.article} {self.word}".strip()

    @property
    def listed(self) -> str:
        """The name of its files in a list of formats."""
        return self.files or f"{self.word}{''.join(f' (<{root}>)' for root in self.roots)}"

    def compile(self, robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
        """Return the artifact of an output, and diagnostics. Raises ValueError for a format that is only read."""
        if self.write is None:
            raise ValueError(f"{self.word} is not written")
        return self.write(robot, output, templates)

    def is_withheld(self, output: Output) -> bool:
        return self.withheld is not None and self.withheld(output)

    def output(self, robot: Robot) -> Output | None:
        return next((output for output in robot.outputs if output.backend == self.name), None)


# Keys that name the formats that they are for: a reader of another one does not expect them.
ADDRESSED = {"mjcf": ("mjcf",), "mjcf_elements": ("mjcf",), "gazebo": ("sdf", "urdf"), "urdf_elements": ("urdf",)}
# Keys that control how the description is read and checked, and keys that state the source of an entry's values.
_TECHNICAL = ("args", "let", "include", "accept", "outputs", "rosorin_compile", "modes", "links.inertial.of.name")
REMARKS = frozenset({"source", "stand_ins", "method", "reason", "about", "stamps"})

# The keys that give a frame its place, and those that name the node that publishes it.
PLACES = (
    *("joints.parent", "joints.child", "joints.xyz", "joints.rpy", "sensors.parent", "sensors.frame"),
    *("sensors.xyz", "sensors.rpy", "sensors.optical.frame", "sensors.optical.xyz", "sensors.optical.rpy"),
)
_PUBLISHER = ("joints.publisher", "sensors.publisher", "sensors.optical.publisher")
_TURNS = (".static_transform_publisher", ".by.static_transform_publisher", ".when")
NODES = tuple(f"{publisher}{turn}" for publisher in _PUBLISHER for turn in _TURNS)
UNPUBLISHED = tuple(f"{publisher}.none" for publisher in _PUBLISHER)

# The keys that each format of a whole robot covers.
MODEL_KEYS = ("robot", "links", "joints", "materials", "sensors", "root", "actuators", "disabled_contacts")

_GEOMETRY = (
    *("box", "cylinder", "capsule", "sphere", "ellipsoid", "mesh.file", "mesh.scale", "height_map.origin"),
    *("height_map.cell", "height_map.heights", "height_map.bottom", "xyz", "rpy"),
)
SHAPES = tuple(f"links.{purpose}.{key}" for purpose in ("collision", "visual") for key in _GEOMETRY)


class Unsupported(NamedTuple):
    """Why a format does not carry a key."""

    reason: str
    quiet: bool = False  # a note would help nobody, because something else carries it
    one_way: bool = False  # artifacts carry it, but not the robot that is read from one: ``diff`` does not compare it


def _quiet(reason: str, *keys: str) -> dict[str, Unsupported]:
    return {key: Unsupported(reason, quiet=True) for key in keys}


_CONTACTS = ("condim", "priority", "solmix", "solref", "solimp", "margin", "gap")
# How MuJoCo sees and simulates a robot, in words that formats for other programs do not have.
OF_MUJOCO: Mapping[str, Unsupported] = {
    **_quiet("how MuJoCo couples joints", *(f"joints.*.mimic.{key}" for key in ("name", *_CONTACTS))),
    **_quiet("how MuJoCo computes contacts", *(f"links.*.collision.*.contact.{key}" for key in _CONTACTS)),
    **_quiet("marks that sensors and actuators of MuJoCo name", "links.*.sites"),
    **_quiet("what MuJoCo takes a mesh for", "links.*.collision.*.mesh.inertia", "links.*.visual.*.mesh.inertia"),
    **_quiet("how the base moves in the world of a simulation", "root"),
    "joints.*.dynamics.armature": Unsupported("no inertia of rotors"),
    "links.*.cameras": Unsupported("cameras that are not sensors"),
    "links.*.lights": Unsupported("no lights"),
    "links.*.collision.*.contact.friction.1": Unsupported("only sliding friction"),
    **{f"links.*.collision.*.contact.{key}": Unsupported("no bits of contacts") for key in ("contype", "conaffinity")},
}
# Who publishes a frame; the name of a sensor's joint matters to publishers alone. What frames sensors have is read.
OF_PUBLISHERS: Mapping[str, Unsupported] = {
    **_quiet("for launch files", "joints.*.publisher", "sensors.*.publisher", "sensors.*.optical.publisher"),
    "sensors": Unsupported("sensors are read as links", one_way=True),
}


def is_within(key: str, prefixes: Iterable[str]) -> bool:
    """Return True if a key is one of some keys, or below one of them; "*" in these is any name."""
    return any(f"{key}.".startswith(f"{prefix.replace('.*', '')}.") for prefix in prefixes)


def reason(format: Format, output: Output, key: str, one_way: bool = False) -> Unsupported | None:
    """Return why an output, or (``one_way``) the robot read from it, has no value at a key; None if it must have it."""
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
    """Return True if the robots that are read from artifacts of a format, by default options, have nothing at a key."""
    return reason(format, Output(format.name, format.name, ""), key, one_way=True) is not None


def _table(format: Format, output: Output) -> Mapping[str, Unsupported | None]:
    """Return what an output does not carry, and None for keys of links that this format and few others carry."""
    found = dict(format.unsupported(output) if callable(format.unsupported) else format.unsupported)
    for name, formats in limited_fields(Link).items():
        if format.name in formats:
            found[f"links.*.{name}"] = None
        elif "links" in format.covers:
            found[f"links.*.{name}"] = Unsupported(f"only in {phrase(formats)}")
    return found


def notes(tree: Map, outputs: Iterable[Output], formats: Mapping[str, Format]) -> Iterator[Diagnostic]:
    """Yield a note for each format of which no output carries keys that a description sets."""
    outputs = list(outputs)
    for name in dict.fromkeys(output.backend for output in outputs):
        some = [output for output in outputs if output.backend == name]
        first, *others = [_table(formats[name], output) for output in some]
        lost = [key for key, why in first.items() if why and not (why.quiet or why.one_way)]
        counts = {key: len([*_places(tree, key)]) for key in lost if all(table.get(key) for table in others)}
        found = [f"{key.replace('.*', '')} ({count_of(count, 'place')})" for key, count in counts.items() if count]
        if found:
            span = tree.locate(("outputs", some[0].name), key=True).span
            yield Diagnostic("not-in-format", NOTE, f"{formats[name].word} cannot express {phrase(found)}", span)


def _places(value: Any, pattern: str) -> Iterator[Any]:
    """Yield the values that are set at a key; "*" is each entry of a mapping or a list, 1 the second."""
    step, _, rest = pattern.partition(".")
    if isinstance(value, list):
        inner = value if step == "*" else value[int(step) : int(step) + 1] if step.isdecimal() else []
    elif isinstance(value, Mapping):
        inner = list(value.values()) if step == "*" else [value[step]] if step in value else []
    else:
        return
    for item in inner:
        yield from _places(item, rest) if rest else [item] if item not in (None, [], {}, False) else []

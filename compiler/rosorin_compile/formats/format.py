"""The record of a format: everything that any other part of the program asks about it.

A format is a module of this folder (or a folder) that exports ``FORMAT``; its name is that of the module. A format of
another package comes by an entry point (``docs/extend.md``). Nothing else in the program names a format.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Source, Span, error
from rosorin_compile.source.messages import and_here
from rosorin_compile.source.numbers import amount, six_digits

if TYPE_CHECKING:
    from rosorin_compile.compare.proof import Proof
    from rosorin_compile.model import Edge, Inertial, Output, Robot, Shape
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.rule_registry import Rule
    from rosorin_compile.source.tree import Map
    from rosorin_compile.source.xml.markup import Document, MarkupError

    from .expectation import Expectation
    from .facts import Deviations
    from .imported import Imported, LeftOut, ReadOptions
    from .templating import Templates
    from .unsupported import Unsupported


ANGLES = ("roll", "pitch", "yaw")
# How sentences about facts begin: kinds that are not named, and quantities that are limits.
_BARE = ("frame", "joint", "link")
_LIMITS = ("lower", "upper", "effort", "velocity")


@dataclass(frozen=True)
class Artifact:
    """One emitted file: its name in the output folder, its text, its format and the name of its output.

    If ``withheld`` is true, publishers must not read the file, although they read its format.
    """

    file: str
    text: str
    backend: str
    output: str
    withheld: bool = False

    def __repr__(self) -> str:
        """Return all but the text, which may be long."""
        return f"<Artifact {self.file}: {self.backend}, {len(self.text):,} characters>"


class Refusal(NamedTuple):
    """Why an engine does not load an artifact; empty if it does.

    ``outdated``: the engine is too old for it, which says nothing about the artifact. ``missing``: the name of an
    engine that is not installed, so that nothing was loaded.
    """

    reason: str = ""
    outdated: bool = False
    missing: str = ""


class About(NamedTuple):
    """What a sentence is about: a thing and a quantity of it, and what stands between them."""

    name: str
    quantity: str
    between: str = " "

    def __str__(self) -> str:
        """Return both as they stand in a sentence."""
        return f"{self.name}{self.between}{self.quantity}"


class Fact(NamedTuple):
    """What a fact is about: ``kind`` joint, link, frame or pose; its name; the quantity, such as "origin z"."""

    kind: str
    name: str
    quantity: str

    @classmethod
    def angles(cls, frame: str) -> tuple[Fact, ...]:
        """Return the facts that say how a frame is turned, in the order in which a pose has them."""
        return tuple(cls("frame", frame, angle) for angle in ANGLES)

    @property
    def is_angle(self) -> bool:
        """Whether its quantity is one of those that say how a frame is turned."""
        return self.quantity in ANGLES

    @property
    def about(self) -> About:
        """What a sentence about it begins with."""
        kind, name, quantity = self
        if kind == "frame" and quantity in ("publisher", "topic"):
            return About(name, "published by" if quantity == "publisher" else quantity, ": ")
        if kind == "joint" and quantity in _LIMITS:
            return About(name, f"limit {quantity}")
        if kind == "pose":
            return About(f"pose {name}", quantity, ": ")
        if kind == "height map":
            return About(name, f"height map {quantity}")
        if kind == "link" and quantity.startswith("inertia "):
            quantity = quantity.replace(" ", " i")
        if kind in _BARE or (kind, name) == ("servo", "pulse_to_rad") or kind == name:
            return About(name, quantity)
        return About(f"{kind} {name}", quantity)


class Value(NamedTuple):
    """The value of a fact: a number in SI units and how well it is known, or a text."""

    value: float | str
    unit: str = ""
    tolerance: float = 0.0

    def shown(self) -> str:
        """Return it in print: a number with six digits, and its unit; a text as it is."""
        if isinstance(self.value, str):
            return self.value
        return f"{six_digits(self.value)} {self.unit}".rstrip()

    def amount(self) -> str:
        """Return a length, angle or mass that is not negative in the unit that suits its size."""
        return amount(float(self.value), self.unit)


Facts = dict[Fact, Value]


def row_name(edge: Edge) -> str:
    """Return what the facts of an artifact call a frame in the row of a publisher that takes turns."""
    return f"{edge.child} when {' '.join(edge.when.split())}" if edge.when else edge.child


# The key of outputs that several formats have.
NUMBER_FORMAT: Mapping[str, Any] = {
    "enum": ["short", "exact", "six"],
    "description": "short (default): the shortest decimal within 1e-12 of the number, or of the largest of its vector;"
    " exact: the shortest that reads back the same; six: whichever of %.6g and %.6f keeps more.",
}

# The forms of boxes that height maps are cut into, for an option of formats without a word for them.
FORMS_OF_BOXES = ["rows", "merged", "grounded"]
BOXES_OF_HEIGHT_MAPS = (
    "rows, one for each run of equal heights in a row; merged, equal heights along x and y; grounded, rows down to"
    " z = 0 whatever bottom says"
)

# A description as plain values: what YAML would have, in SI units or as quantities ("40 mm").
Description = Mapping[str, "Any"]
Writer = Callable[["Robot", "Output", "Templates"], tuple[str, "list[Diagnostic]"]]


class Placed(NamedTuple):
    """A value of a description, and where in the file it was written."""

    value: Any
    span: Span


@dataclass(frozen=True)
class Opened:
    """A file to be read: its path, what was said beside it, its elements if it is XML, and the place that names it.

    Places are a line and a column, which count from 1, or the ``span`` of an element.
    """

    path: Path
    options: ReadOptions
    document: Document | None = None
    asked: Span | None = None

    @property
    def text(self) -> str:
        """The text of the file. Raises MarkupError if it has none, which the caller of a reader expects."""
        return self.source.text

    @cached_property
    def source(self) -> Source:
        """The file as diagnostics name it. Raises MarkupError as ``text``."""
        from rosorin_compile.source.xml.files import read_source

        return self.document.source if self.document else read_source(self.path, self.asked)

    def at(self, value: Any, where: int | Span, column: int = 1, length: int = 1) -> Placed:
        """Return a value of a description with its place, for what there may be to say about it."""
        return Placed(value, self._span(where, column, length))

    def problem(
        self, message: str, where: int | Span = 1, column: int = 1, length: int = 1, help: str = ""
    ) -> MarkupError:
        """Return what a reader raises where the file is not written as its format wants."""
        from rosorin_compile.source.xml.markup import MarkupError

        return MarkupError(error("file-syntax", message, self._span(where, column, length), help))

    def left_out(self, what: str, where: int | Span, column: int = 1, length: int = 1, help: str = "") -> Diagnostic:
        """Return the warning about something that a description has no word for."""
        return cannot_carry(what, self._span(where, column, length), help)

    def _span(self, where: int | Span, column: int, length: int) -> Span:
        return where if isinstance(where, Span) else Span(self.source, where, column, length)

    @property
    def xml(self) -> Document:
        """The elements of a file that is XML. Raises ValueError for another one."""
        if self.document is None:
            raise ValueError(f"{self.path} is no XML")
        return self.document


def cannot_carry(what: str, span: Span, help: str = "", many: bool = False, others: Sequence[Span] = ()) -> Diagnostic:
    """Return the warning about something that the tree does not carry; ``many`` if ``what`` is a plural.

    ``others`` are the further places where it stands: one warning, the first of them and their number.
    """
    message = f"{what} {'are' if many else 'is'} not carried over"
    return Diagnostic("import-cannot-carry", WARNING, message, span, and_here(others), help)


class Joined(NamedTuple):
    """What a file says beside the robot that it belongs to: sections of a description, and what there is to say."""

    sections: Mapping[str, Any]
    diagnostics: Sequence[Diagnostic] = ()
    left_out: tuple[LeftOut, ...] = ()


class Asked(NamedTuple):
    """The entry of ``outputs`` that the description of an imported robot has, and a remark on what is unusual in it."""

    entry: Mapping[str, Any]
    remark: str = ""


# Records are compared with nothing, and printed for nobody: such methods would be compiled at every start.
@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Importing:
    """How files of a format are read, beside ``read``: for ``import``, ``include`` and ``diff``.

    ``include`` says that a description may include such a file, ``takes_arguments`` that it is told arguments,
    ``becomes`` the format that it is once it is read (xacro: urdf).

    ``join``: a file and the tree of a robot to the sections that it adds to that (``import --srdf FILE``); ``joins``
    are the fields of the model that it says all of. ``is_other`` says of a file that looks like a robot that it is no
    more than such a companion of one.

    When a robot is imported: ``asked`` makes the output that its description has, from its tree, the version that its
    source says and a name for files; None if it is to have none. ``optional`` says that the output is left out, with a
    remark, where the robot cannot be written so.
    """

    include: bool = True
    takes_arguments: bool = False
    becomes: str = ""
    join: Callable[[Opened, Map], Joined] | None = None
    joins: tuple[str, ...] = ()
    is_other: Callable[[Document], bool] | None = None
    asked: Callable[[Map, str, str], Asked | None] | None = None
    optional: bool = False


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Writing:
    """What an artifact has of a robot, beside its text: for ``diff``, for packages, and for whoever looks for files.

    When two robots are compared: ``links`` (those that an output has), ``lacks`` (topics that it has no word for, see
    ``meaning.not_compared``), ``says`` (sections that it has a word for), ``leaves_out`` and ``why`` (links that it
    lacks by nature), ``adds`` (links of its files that stand for something else in a description), ``brings`` (the
    elements of XML that it makes of what a description says in words), ``names_robot`` (its files say what the robot is
    called).

    Other files: ``located`` (its text depends on where other artifacts stand), ``meshes`` (it names meshes as URDF
    does), ``opens`` (the file of a mesh as seen from the artifact, by its name in the description; empty where it is
    not opened), ``embeds`` (it holds the meshes themselves), ``measures`` (its text depends on how large meshes are),
    ``beside`` (the names of files that it wants beside it).
    """

    links: Callable[[Robot, Output], Collection[str]] | None = None
    lacks: frozenset[str] = frozenset()
    says: tuple[str, ...] = ()
    leaves_out: Callable[[Robot, str], bool] | None = None
    why: str = ""
    adds: Callable[[Robot, str, Robot], bool] | None = None
    brings: Callable[[Robot, Output], Sequence[str]] | None = None
    names_robot: bool = True
    located: bool = False
    meshes: bool = False
    opens: Callable[[str], str] | None = None
    embeds: bool = False
    measures: bool = False
    beside: Callable[[str], Sequence[str]] | None = None


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Proving:
    """How an artifact is held against the robot, and against another artifact.

    - ``against``: ``facts`` for the proof that all artifacts agree alone, and faster: what is not as it is known to be.
    - ``syntax``: a text to what is left of it without layout and comments. Raises ValueError, SyntaxError.
    - ``schema``: the JSON Schema that its texts fit, a name in ``schemas/``; ``data`` reads what it is of from a text
      that is not JSON itself. Raises ValueError.
    - ``differ``: what differs between two texts whose facts are the same, in words; empty if nobody can say.
    - ``shown``: its text is for people, so that ``check`` prints how two of them differ; a picture is told by name.
    - ``refusal``: why the engine that reads such files does not load a text that stands in a folder. For ``check``. One
      of another package may return the reason alone, as text.
    - ``prove``: how its engine tells an artifact from the source that it was imported from, by the artifact's text and
      the files of its meshes (by the names there). For ``import`` of a source of the same format.

    What an artifact says of a robot:

    - ``frames``: the frames that it has to carry, as ``facts`` names them.
    - ``solids``: the collision shapes that a link has in it, None where they cannot be compared; the last argument are
      the frames that the artifact speaks of. ``all_solids``: links for which it has no shape are meant to have none.
    - ``engine_reads``: its engine reads the sources, so that what this passes over in XML is taken as it is.
    - ``inertials``: what its links weigh where that is not what the robot's do, because they carry others. Raises
      ValueError where that is no number.
    - ``cannot_say``: facts that it has no word for, though ``facts`` reads them.
    - ``disagreements``: what else it says wrongly, in words.
    - ``names``: what it calls links otherwise than the robot does: the name of the link by the name in the artifact.
      ``joint_names``: the same of joints.
    - ``complete``: it carries every frame, with the shapes of each.
    """

    against: Callable[[str, Expectation], Deviations] | None = None
    syntax: Callable[[str], object] | None = None
    schema: str = ""
    data: Callable[[str], Any] | None = None
    differ: Callable[[str, str], str] | None = None
    shown: bool = True
    refusal: Callable[[str, Path], Refusal] | None = None
    prove: Callable[[Imported, str, Mapping[str, str]], Proof] | None = None
    frames: Callable[[Robot], Collection[str]] | None = None
    solids: Callable[[Robot, str, Output, frozenset[str]], Sequence[Shape] | None] | None = None
    all_solids: bool = False
    engine_reads: bool = False
    inertials: Callable[[Robot, Output], Mapping[str, Inertial]] | None = None
    cannot_say: Callable[[Robot, Fact], bool] | None = None
    disagreements: Callable[[Robot, Output, str], Iterator[str]] | None = None
    names: Callable[[Output], Mapping[str, str]] | None = None
    joint_names: Callable[[Robot], Mapping[str, str]] | None = None
    complete: bool = False


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class InRos:
    """What becomes of an artifact in ROS.

    ``feeds`` (kinds of publishers that read it), ``withheld`` (an output that they are not to read), ``folder`` (where
    ``package`` puts it; empty: by the ending of its name), ``deploys`` (``deploy`` puts it there too, where no copy is
    yet), ``packaged`` (a package carries it, and has none of its own), ``robot_of`` (the robot that a file was
    generated for, by its path, where no comment says so), ``adapted`` (a head of a text that has been changed for a
    package).
    """

    feeds: tuple[str, ...] = ()
    withheld: Callable[[Output], bool] | None = None
    folder: str = ""
    deploys: bool = False
    packaged: bool = True
    robot_of: Callable[[Path], str] | None = None
    adapted: str = ""


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Format:
    """A format that is written, read, or both.

    What a description says of it:

    - ``name``: its name under ``outputs:``.
    - ``options``: the JSON Schema of each key of its entry there, beside ``file`` and ``backend``.
    - ``check``: yields what is wrong with an entry that no schema sees.
    - ``rules``: those that its diagnostics name; only of a format of another package.

    What people and lists call it: ``word`` ("URDF") with its ``article`` ("a"), ``files`` (its files, in a list of what
    is read; by default the word and the root element), ``about`` (what a person has it for), ``rank`` (its place in
    lists; those of other packages come last), ``file`` (the usual name of a file; {} is the name of the robot).

    How its files are known: ``endings``, and of XML ``roots`` (names of the root element) or ``recognises``, which is
    asked first.

    What it does:

    - ``write``: Robot, Output, Templates to text, and diagnostics about what the format cannot say.
    - ``covers``: the keys of the language that it is about, such as ``joints.axis``, with all below them; () for all.
    - ``unsupported``: of these keys those that an output has no word for, with the reason (see ``unsupported``).
    - ``read``: a file to a description, for ``import``, ``include`` and ``diff``: plain values or a tree (see
      ``imported.converted``).
    - ``facts``: the text of an artifact to facts, for ``check`` and for the proof that all artifacts agree. Raises
      ValueError for a damaged text. Without it artifacts are compared as text.

    And what else there is to know, in groups: ``reading``, ``writing``, ``proving``, ``ros``.
    """

    name: str
    word: str
    article: str = ""
    files: str = ""
    about: str = "another artifact"
    rank: int = 1000
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    check: Callable[[Case, Output], Iterator[Diagnostic]] | None = None
    rules: tuple[Rule, ...] = ()
    file: str = ""
    endings: tuple[str, ...] = ()
    roots: tuple[str, ...] = ()
    recognises: Callable[[Document, Path], bool] | None = None
    write: Writer | None = None
    covers: tuple[str, ...] = ()
    unsupported: Mapping[str, Unsupported] | Callable[[Output], Mapping[str, Unsupported]] = field(default_factory=dict)
    read: Callable[[Opened], Imported | Description | tuple[Description, Sequence[Diagnostic]]] | None = None
    facts: Callable[[str], Facts] | None = None
    reading: Importing = Importing()
    writing: Writing = Writing()
    proving: Proving = Proving()
    ros: InRos = InRos()

    @property
    def is_xml(self) -> bool:
        """Whether its files are known by what stands in them rather than by their names."""
        return bool(self.roots or self.recognises)

    @property
    def named(self) -> str:
        """The word with its article, as in "robot.urdf is a URDF"."""
        return f"{self.article} {self.word}".strip()

    @property
    def listed(self) -> str:
        """What its files are called in a list of formats."""
        return self.files or f"{self.word}{''.join(f' (<{root}>)' for root in self.roots)}"

    def written(self, robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
        """Return the artifact that an output asks for. Raises ValueError for a format that is only read."""
        if self.write is None:
            raise ValueError(f"{self.word} is not written")
        return self.write(robot, output, templates)

    def is_withheld(self, output: Output) -> bool:
        """Say whether publishers that read the format are not to read an output."""
        return self.ros.withheld is not None and self.ros.withheld(output)

    def output(self, robot: Robot) -> Output | None:
        """Return the first output of a robot in this format."""
        return next((output for output in robot.outputs if output.backend == self.name), None)


GROUPS = {"reading": Importing, "writing": Writing, "proving": Proving, "ros": InRos}

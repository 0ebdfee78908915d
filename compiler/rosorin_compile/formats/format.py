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

if TYPE_CHECKING:
    from rosorin_compile.compare.proof import Proof
    from rosorin_compile.model import Output, Robot
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.rule_registry import Rule
    from rosorin_compile.source.tree import Map
    from rosorin_compile.source.xml.markup import Document, MarkupError

    from .imported import Imported, LeftOut, ReadOptions
    from .templating import Templates
    from .unsupported import Unsupported


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
    """How texts of a format are compared beside ``view`` and ``read``, and judged.

    - ``syntax``: a text to what is left of it without layout and comments. Raises ValueError, SyntaxError.
    - ``schema``: the JSON Schema that its texts fit, a name in ``schemas/``; ``data`` reads what it is about from a
      text that is not JSON itself. Raises ValueError.
    - ``differ``: what differs between two texts that no leaf tells apart, in words; empty if nobody can say.
    - ``shown``: its text is for people, so that ``check`` prints how two of them differ; a picture is told by name.
    - ``names``: the names of links in the robot by those that an artifact has for them.
    - ``refusal``: why the engine that reads such files does not load a text that is in a folder. For ``check``. One of
      another package may return the reason alone, as text.
    - ``engine_reads``: its engine reads the sources, so that what this passes over in XML is taken as it is.
    - ``prove``: how its engine tells an artifact from the source that it was imported from, by the artifact's text and
      the files of its meshes (by the names there). For ``import`` of a source of the same format.
    """

    syntax: Callable[[str], object] | None = None
    schema: str = ""
    data: Callable[[str], Any] | None = None
    differ: Callable[[str, str], str] | None = None
    shown: bool = True
    names: Callable[[Output], Mapping[str, str]] | None = None
    refusal: Callable[[str, Path], Refusal] | None = None
    engine_reads: bool = False
    prove: Callable[[Imported, str, Mapping[str, str]], Proof] | None = None


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

    - ``view``: Robot and Output to what the artifact is meant to contain: a reduced ``Robot`` (SDF, URDF, MJCF), or a
      small frozen dataclass of the format, built from the dataclasses of the model.
    - ``write``: Robot, Output, Templates to text, and diagnostics about what the format cannot say.
    - ``read``: the text of an artifact back to such a value, the inverse of ``write``. Raises ValueError for a damaged
      text. Before anything is written, ``view`` is compared with ``read`` of the text (``compare.walk``), and the
      golden check compares it with ``read`` of the committed text. Without it artifacts are compared as text.
    - ``rounding``: by how much (m, rad) ``view`` rounds numbers.
    - ``partial``: ``view`` leaves out some of what ``read`` finds: only its own leaves are compared before writing, and
      the golden check compares two texts that are read.
    - ``covers``: the keys of the language that it is about, such as ``joints.axis``, with all below them; () for all.
    - ``unsupported``: of these keys those that an output has no word for, with the reason (see ``unsupported``).
    - ``load``: a foreign file to a description, for ``import``, ``include`` and ``diff``: plain values or a tree (see
      ``imported.converted``).
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
    view: Callable[[Robot, Output], Any] | None = None
    read: Callable[[str], Any] | None = None
    rounding: tuple[float, float] = (0.0, 0.0)
    partial: bool = False
    load: Callable[[Opened], Imported | Description | tuple[Description, Sequence[Diagnostic]]] | None = None
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

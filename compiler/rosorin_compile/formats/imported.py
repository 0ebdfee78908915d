"""Imported: what comes of reading a foreign robot.

``Imported`` has a plain tree as ``expand`` gives it, and all there is to say about it. ``ReadOptions`` is what
``import``, ``include`` and ``diff`` can say about how it is read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ..diagnostics import WARNING, Diagnostic, Span, and_here
from ..diagnostics.registry import READING, Rule
from ..frontend.load import plain_scalar
from ..frontend.tree import Map
from ..frontend.tree import Path as TreePath

RULES = (
    Rule(
        "import-cannot-carry",
        "A warning: something has no place in a description and is not carried over.",
        "`--strict` makes it an error.",
        READING,
    ),
)


MAX_NAME = 60
BEFORE, BESIDE, INSIDE, END = "before", "beside", "inside", "end"


class Comment(NamedTuple):
    """A comment of the source: its text as written, its place, and the path in the tree that it belongs to.

    ``where`` is BEFORE the entry (a line or lines of its own), BESIDE it (behind it on its last line), INSIDE it (after
    the last thing that it holds), or, with an empty path, at the END of the file. What stands before the root element
    is BEFORE ("robot",). The path may lead to something that the tree says by default: take its longest prefix then.
    """

    text: str
    span: Span
    path: TreePath
    where: str = BEFORE


class LeftOut(NamedTuple):
    """Something of the source that the tree does not carry, in words, and its place."""

    what: str
    span: Span


class Proof(NamedTuple):
    """How the artifact that a source becomes differs from it to the engine that reads both, in texts by feature.

    ``wrong`` is what nobody said, ``known`` what the import listed as left out or changed; ``said`` is the sentence
    about what holds. ``unknown`` is why the engine did not answer; empty if it did. ``counts`` is how many objects the
    source has, by kind.
    """

    wrong: Mapping[str, Sequence[str]] = {}
    known: Mapping[str, Sequence[str]] = {}
    said: str = ""
    unknown: str = ""
    counts: Mapping[str, int] = {}


class Outputs(NamedTuple):
    """The artifacts that a description asks for: entries of its section, and by format what is not usual in it.

    ``left_out`` are the formats that it does not ask for, each with the reason.
    """

    entries: dict[str, Mapping[str, Any]]
    remarks: dict[str, str]
    left_out: dict[str, str]

    @property
    def lines(self) -> list[str]:
        """The remarks as comments of the section."""
        return [*self.remarks.values(), *(f"no {name}: {reason}" for name, reason in self.left_out.items())]


class Imported(NamedTuple):
    """The tree (None if the source is broken), what there is to say, and what a writer may want to know.

    ``files`` are the files that were read, the source first. ``left_out`` is what a warning ``import-cannot-carry``
    was given for. ``version`` is that of the format, as written (``version`` of a URDF), empty if it is not said.
    ``format`` is the name of the format that was read; of a xacro that of what it expands to. ``takes_arguments`` says
    that the file was told arguments; ``unexpanded``, that a file with elements of xacro was read as the URDF that it is
    called, without xacro. ``names`` are the names that
    objects of the source got, by kind and index, for the proof in its engine.
    """

    tree: Map | None
    diagnostics: list[Diagnostic]
    comments: Sequence[Comment] = ()
    files: tuple[Path, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    version: str = ""
    format: str = ""
    takes_arguments: bool = False
    unexpanded: bool = False
    names: Mapping[str, Mapping[int, str]] = {}

    @property
    def file_name(self) -> str:
        """The name of the robot as that of a file or folder; "" for a broken source."""
        return file_name(self.tree["robot"]) if self.tree is not None else ""

    def outputs(self, why: str = "") -> Outputs:
        """Return what the description of the robot asks for; ``why`` it is to go without optional formats.

        Raises ValueError for a broken source.
        """
        from . import FORMATS

        if self.tree is None:
            raise ValueError("a broken source has no tree")
        made = Outputs({}, {}, {})
        for format in FORMATS.values():
            if format.asked is None:
                continue
            asked = format.asked(self.tree, self.version, self.file_name)
            if asked is None:
                continue
            if format.optional and why:
                made.left_out[format.name] = why
                continue
            made.entries[format.name] = asked.entry
            if asked.remark:
                made.remarks[format.name] = asked.remark
        return made


def file_name(name: str) -> str:
    """Return the name of a robot as that of a file or folder: ASCII letters, digits, "_", "-" and ".".

    >>> file_name("My Robot (v2)"), file_name("../x"), file_name("机器人")
    ('My_Robot_v2', 'x', 'robot')
    """
    made = re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:MAX_NAME].strip("._-")
    if not made or not isinstance(plain_scalar(made), str):
        made = f"robot_{made}".strip("_")
    return made


def cannot_carry(what: str, span: Span, help: str = "", many: bool = False, others: Sequence[Span] = ()) -> Diagnostic:
    """Return the warning about something that the tree does not carry; ``many`` if ``what`` is a plural.

    ``others`` are the further places where it stands: one warning, the first of them and their number.
    """
    message = f"{what} {'are' if many else 'is'} not carried over"
    return Diagnostic("import-cannot-carry", WARNING, message, span, and_here(others), help)


@dataclass(frozen=True)
class ReadOptions:
    """What is said beside the file itself.

    ``arguments`` are those of a xacro file, texts by name. ``packages`` are folders of ROS packages by name, asked
    before any other place. ``lenient`` takes what breaks the specification where a robot comes out all the same.
    ``environment`` are the environment variables; None means those of this process.
    ``tell`` takes what has to be said before anything is run (``xacro-runs-code``), at that moment; what it was told is
    not among the diagnostics. Without it, that is the first of them.
    ``trust`` says that whoever wrote the file is trusted with what it runs: what is told then is TRUSTED, for nobody
    to read.
    ``checked`` asks for the meaning to be held against the rules. The round trip, which reads what the compiler has
    just written, does without: those of its source are settled.
    """

    arguments: Mapping[str, str] = field(default_factory=dict)
    packages: Mapping[str, Path] = field(default_factory=dict)
    lenient: bool = False
    environment: Mapping[str, str] | None = None
    tell: Callable[[Diagnostic], None] | None = None
    checked: bool = True
    trust: bool = False

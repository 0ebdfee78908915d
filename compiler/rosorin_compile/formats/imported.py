"""Imported: what comes of reading a foreign robot.

``Imported`` has a plain tree as ``expand`` gives it, and all there is to say about it. ``ReadOptions`` is what
``import``, ``include`` and ``diff`` can say about how it is read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic, Span
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.plugins import diagnostic_of
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.xml.files import printable_name

from .described import as_tree
from .format import Opened

if TYPE_CHECKING:
    from rosorin_compile.language.lower import Lowered
    from rosorin_compile.model import Robot

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


@dataclass(frozen=True)
class Comment:
    """A comment of the source: its text as written, its place, and the path in the tree that it belongs to.

    ``where`` is BEFORE the entry (a line or lines of its own), BESIDE it (behind it on its last line), INSIDE it (after
    the last thing that it holds), or, with an empty path, at the END of the file. What stands before the root element
    is BEFORE ("robot",). The path may lead to something that the tree says by default: take its longest prefix then.
    """

    text: str
    span: Span
    path: TreePath
    where: str = BEFORE

    BEFORE: ClassVar[str] = BEFORE
    BESIDE: ClassVar[str] = BESIDE
    INSIDE: ClassVar[str] = INSIDE
    END: ClassVar[str] = END


class LeftOut(NamedTuple):
    """Something of the source that the tree does not carry, in words, and its place."""

    what: str
    span: Span


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
    objects of the source got, by kind and index, for the proof in its engine. ``checked`` is False for a tree that
    still has to be validated.
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
    checked: bool = True

    @property
    def file_name(self) -> str:
        """The name of the robot as that of a file or folder; "" for a broken source."""
        return file_name(self.tree["robot"]) if self.tree is not None else ""

    @property
    def whole(self) -> Map:
        """The tree. Raises ValueError for a broken source, which has none."""
        if self.tree is None:
            raise ValueError("a broken source has no tree")
        return self.tree

    def lowered(self) -> Lowered:
        """Return the model that the tree says, and what is wrong with it."""
        from rosorin_compile.language.lower import lower

        return lower(self.whole)

    @property
    def robot(self) -> Robot | None:
        """The model that the tree says; None of a broken source, or where it says none."""
        return None if self.tree is None else self.lowered().robot

    def typed(self) -> Imported:
        """Return it with what the types of its sensors bring; what is wrong with those is all that it says then."""
        from rosorin_compile.language.expand.expansion import Expansion
        from rosorin_compile.language.expand.scope import Scope
        from rosorin_compile.language.expand.sensor_types import apply_types
        from rosorin_compile.source.project import data_folder

        made, expansion = self.whole.copied(), Expansion()
        if isinstance(made.get("sensors"), Map):
            made["sensors"] = made["sensors"].copied()
            apply_types(made, None, Scope(expansion), data_folder("parts_library") / "sensors.yaml")
        return self._replace(tree=made, diagnostics=expansion.diagnostics)

    def with_sections(self, sections: Mapping[str, Any]) -> Imported:
        """Return it with more sections, whose values are plain or trees; those that are empty go."""
        tree = self.whole
        made = tree.copied()
        for key, value in sections.items():
            if value:
                plain = value if isinstance(value, (Map, Seq)) else as_tree(value, tree.span, [key])
                made.put(key, plain, tree.span, tree.span)
            else:
                made.pop(key, None)
        return self._replace(tree=made)

    def relative_files(self) -> list[str]:
        """Return the relative names of mesh and texture files, each once, in their order."""
        from rosorin_compile.language.expand.included_robots import relative_files

        return relative_files(self.whole)

    def with_files_named(self, name: Callable[[str], str]) -> Imported:
        """Return it with each name of a mesh or texture file as ``name`` makes it."""
        from rosorin_compile.language.expand.included_robots import map_files

        return self._replace(tree=map_files(self.whole, name))

    def with_files_below(self, folder: str) -> Imported:
        """Return it with ``folder`` before the relative names of mesh and texture files."""
        from rosorin_compile.language.expand.included_robots import move_files

        return self._replace(tree=move_files(self.whole, folder))


def file_name(name: str) -> str:
    """Return the name of a robot as that of a file or folder: ASCII letters, digits, "_", "-" and ".".

    >>> file_name("My Robot (v2)"), file_name("../x"), file_name("机器人")
    ('My_Robot_v2', 'x', 'robot')
    """
    made = re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:MAX_NAME].strip("._-")
    if not made or not isinstance(plain_scalar(made), str):
        made = f"robot_{made}".strip("_")
    return made


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


def converted(made: object, opened: Opened) -> Imported:
    """Convert what a reader returns: Imported, a description, or one with diagnostics. Raises TypeError for the rest.

    Of a description, ``checked`` of the result is False.
    """
    if isinstance(made, Imported):
        if not (made.tree is None or isinstance(made.tree, Map)):
            raise TypeError(f"the tree of what is imported is a Map, not {type(made.tree).__name__}")
        return made._replace(diagnostics=[diagnostic_of(one) for one in made.diagnostics])
    description, said = made if isinstance(made, tuple) and len(made) == 2 else (made, ())
    diagnostics = list(said)
    for one in diagnostics:
        diagnostic_of(one)
    tree = as_tree(description, opened.source.start(), [])
    if not isinstance(tree, Map):
        raise TypeError(f"a reader gives a description, not {type(description).__name__}")
    name = printable_name(opened.path)
    for key, value in (("robot", opened.path.stem), ("source", {"status": "imported", "note": f"from {name}"})):
        if key not in tree:
            tree.put(key, as_tree(value, tree.span, [key]), tree.span, tree.span)
    left = [one for one in diagnostics if one.rule == "import-cannot-carry"]
    what = tuple(LeftOut(one.message.removesuffix(" is not carried over"), one.span or tree.span) for one in left)
    return Imported(tree, diagnostics, files=(opened.path,), left_out=what, checked=False)

"""A robot that was read from a file in another format, as a plain tree, and the options of reading it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.language.annotations import Steps
from rosorin_compile.language.lower import lower
from rosorin_compile.language.schema import subject, unit_at
from rosorin_compile.source.diagnostics import Diagnostic, Span
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.plugins import diagnostic_of
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.wording import mask_controls
from rosorin_compile.source.xml.markup import COMMENT, Document, Element, Remark
from rosorin_compile.source.yaml_mistakes import MAX_DEPTH

from .format import Opened, Placed

if TYPE_CHECKING:
    from rosorin_compile.model import Robot

_MAX_NAME = 60
BEFORE, BESIDE, INSIDE, END = "before", "beside", "inside", "end"
_LARGEST = 10**18  # from here on, YAML's whole numbers are floats (see ``load``)


@dataclass(frozen=True)
class Comment:
    """A comment of the source: its text as written, and its place."""

    text: str
    span: Span
    path: TreePath  # of its entry, or the longest prefix of it in the tree; of one before the root ("robot",)
    where: str = BEFORE  # BEFORE, BESIDE (on its last line) or INSIDE the entry, or at the END of the file


class Outputs(NamedTuple):
    """The entries of ``outputs`` of a description by format, and remarks on unusual ones."""

    entries: dict[str, Mapping[str, Any]]
    remarks: dict[str, str]
    left_out: dict[str, str]  # formats that the description does not request, each with the reason

    @property
    def lines(self) -> list[str]:
        return [*self.remarks.values(), *(f"no {name}: {reason}" for name, reason in self.left_out.items())]


class Imported(NamedTuple):
    """The tree of a robot (None if the source is broken), all diagnostics, and facts for those who write it."""

    tree: Map | None
    diagnostics: list[Diagnostic]
    comments: Sequence[Comment] = ()
    files: tuple[Path, ...] = ()  # that were read, the source first
    version: str = ""  # of the format, such as that of a URDF
    format: str = ""  # its name; of a xacro that of its expansion
    takes_arguments: bool = False  # arguments were passed to the file
    unexpanded: bool = False  # a file with xacro elements was read as the URDF that its name promises
    names: Mapping[str, Mapping[int, str]] = {}  # that objects of the source got, by kind and index, for the proof
    checked: bool = True  # the tree was validated
    mount: str = ""  # the link of another robot that joints of a called macro refer to
    packages: Mapping[str, Path] = {}  # the folders of packages that kept elements may name
    passed: frozenset[str] = frozenset()  # the keys of an include whose values the call of a macro got

    @property
    def file_name(self) -> str:
        return file_name(self.tree["robot"]) if self.tree is not None else ""

    @property
    def left_out(self) -> list[str]:
        lost = [one.message for one in self.diagnostics if one.rule == "import-cannot-carry"]
        return [message.replace(" is not carried over", "") for message in dict.fromkeys(lost)]

    @property
    def whole(self) -> Map:
        if self.tree is None:
            raise ValueError("a broken source has no tree")
        return self.tree

    @property
    def robot(self) -> Robot | None:
        return None if self.tree is None else lower(self.tree).robot


def file_name(name: str) -> str:
    """Return the name of a robot as that of a file or folder: ASCII letters, digits, "_", "-" and "."."""
    made = re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:_MAX_NAME].strip("._-")
    return made if made and isinstance(plain_scalar(made), str) else f"robot_{made}".strip("_")


@dataclass(frozen=True)
class ReadOptions:
    """Options of reading a file."""

    arguments: Mapping[str, str] = field(default_factory=dict)  # of a xacro file
    packages: Mapping[str, Path] = field(default_factory=dict)  # folders of ROS packages by name, with precedence
    lenient: bool = False  # accept a file that violates its specification if a robot can be read
    environment: Mapping[str, str] | None = None  # the environment variables; default: those of this process
    tell: Callable[[Diagnostic], None] | None = None
    checked: bool = True  # check the rules; not needed for artifacts that were just written
    trust: bool = False  # the author of the file is trusted with running code
    call: Map | None = None  # an evaluated include that calls a macro of a xacro: with ``macro``, ``with``, ``parent``


def convert_result(made: object, opened: Opened) -> Imported:
    """Convert the result of a reader: Imported, a description, or one with diagnostics. Raises TypeError for others."""
    if isinstance(made, Imported):
        if not (made.tree is None or isinstance(made.tree, Map)):
            raise TypeError(f"the tree of what is imported is a Map, not {type(made.tree).__name__}")
        return made._replace(diagnostics=[diagnostic_of(one) for one in made.diagnostics])
    description, diagnostics = made if isinstance(made, tuple) and len(made) == 2 else (made, ())
    tree = as_tree(description, opened.source.span())
    if not isinstance(tree, Map):
        raise TypeError(f"a reader gives a description, not {type(description).__name__}")
    source = {"status": "imported", "note": f"from {mask_controls(opened.path.name)}"}
    for key, value in (("robot", opened.path.stem), ("source", as_tree(source, tree.span, ["source"]))):
        tree.setdefault_at(key, value, tree.span)
    return Imported(tree, [diagnostic_of(one) for one in diagnostics], files=(opened.path,), checked=False)


def as_tree(value: Any, span: Span, path: Steps | None = None) -> Any:
    """Return plain values as a tree; what has no place of its own has that of its container. Raises TypeError."""
    path = path or []
    if value is None or isinstance(value, (bool, float)):
        return value
    if isinstance(value, Placed):
        return as_tree(value.value, value.span, path)
    if len(path) > MAX_DEPTH:
        raise TypeError(f"{subject(path[:3])} is nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, str):  # text in the place of a number may have a unit, as in YAML
        quantity = Quantity.parse(value) if unit_at(path) is not None else None
        return str(value) if quantity is None else quantity
    if isinstance(value, Mapping):
        tree = Map(span)
        for key, item in value.items():
            if not isinstance(key, str):
                raise TypeError(f"{subject(path)} has a key that is not text: {key!r}")
            place = item.span if isinstance(item, Placed) else span
            tree.put(str(key), as_tree(item, span, [*path, key]), place, place)
        return tree
    if isinstance(value, (list, tuple)):
        items = Seq(span)
        for index, item in enumerate(value):
            default = value.value_spans[index] if isinstance(value, Seq) else span
            items.put(as_tree(item, span, [*path, index]), item.span if isinstance(item, Placed) else default)
        return items
    if isinstance(value, Real):
        return int(value) if isinstance(value, Integral) and abs(int(value)) < _LARGEST else float(value)
    raise TypeError(f"{subject(path)} is of the type {type(value).__name__}, which no description holds")


class Proof(NamedTuple):
    """The differences between a source and its conversion, as texts by feature."""

    wrong: Mapping[str, Sequence[str]] = {}  # was not reported before
    known: Mapping[str, Sequence[str]] = {}  # was reported before
    said: str = ""  # a sentence about the result from the engine
    unknown: str = ""  # why the engine did not answer

    @property
    def texts(self) -> list[str]:
        return [text for texts in self.wrong.values() for text in texts]


def comments_of(document: Document, paths: Mapping[int, TreePath]) -> list[Comment]:
    """Return the comments of a document, in their order; ``paths`` leads from an element (by ``id``) to its entry."""
    text = document.source.text
    found: list[tuple[Remark, TreePath, str]] = [(one, ("robot",), BEFORE) for one in document.before]
    waiting = [document.root]
    while waiting:
        element = waiting.pop()
        path, content, above = paths.get(id(element), ()), element.content, None
        waiting += [one for one in element.children if "urdf_elements" not in paths.get(id(one), ("urdf_elements",))]
        for index, item in enumerate(content):
            if isinstance(item, Element):
                above = item
                continue
            below = next((later for later in content[index:] if isinstance(later, Element)), None)
            following = content[index + 1].start if index + 1 < len(content) else element.end
            same_line = "\n" not in text[(above.end if above else element.opened) : item.start]
            of, where = path, INSIDE
            if above is None and below is not None and element.tag in ("visual", "collision"):
                where = BEFORE  # about the shape, not about its origin
            elif same_line and (above is not None or "\n" in text[item.end : following]):
                of, where = paths.get(id(above), path), BESIDE  # the element itself, if there is none above
            elif below is not None:
                of, where = paths.get(id(below), path), BEFORE
            found.append((item, of, where))
    found += [(one, (), END) for one in document.after]
    comments = []
    for remark, path, where in sorted(found, key=lambda one: one[0].start):
        span = document.span(remark.start, remark.end - remark.start)
        comments += [Comment(remark.text, span, path, where)] if remark.kind == COMMENT else []
    words = ("====", "This document was autogenerated by xacro from", "EDITING THIS FILE BY", "====")
    for start in range(len(comments) - len(words) + 1):
        if all(word in one.text for word, one in zip(words, comments[start:], strict=False)):
            return [*comments[:start], *comments[start + len(words) :]]
    return comments

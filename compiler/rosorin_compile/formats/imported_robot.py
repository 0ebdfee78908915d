"""``ImportedRobot``, a robot that was read from a file in another format, and ``ReadOptions``."""

import re
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.language.annotations import Steps
from rosorin_compile.language.lower import lower
from rosorin_compile.language.schema import subject, unit_at
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import Diagnostic, Span
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.plugins import diagnostic_of
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.wording import mask_controls
from rosorin_compile.source.xml.markup import COMMENT, Document, Element, Remark
from rosorin_compile.source.yaml_mistakes import MAX_DEPTH

from .format import ImportFile, SourceValue

_MAX_NAME = 60
BEFORE, BESIDE, INSIDE, END = "before", "beside", "inside", "end"
_LARGEST = 10**18  # larger integers become floats


class Comment(NamedTuple):
    """A comment in an imported XML file, and its place in the description."""

    text: str
    span: Span
    path: TreePath  # YAML path of the commented entry; ("robot",) before the root element
    where: str = BEFORE  # BEFORE the entry, BESIDE its last line, INSIDE it, or at the END of the file


class Outputs(NamedTuple):
    """The entries of ``outputs`` for an imported robot."""

    entries: dict[str, Mapping[str, Any]]  # {format: entry}
    remarks: dict[str, str]  # {format: remark about an unusual entry}
    left_out: dict[str, str]  # {format: reason why it has no output}

    @property
    def lines(self) -> list[str]:
        return [*self.remarks.values(), *(f"no {name}: {reason}" for name, reason in self.left_out.items())]


class ImportedRobot(NamedTuple):
    """The result of an import; ``tree`` is the YAML tree of the robot, or None after errors."""

    tree: Map | None
    diagnostics: list[Diagnostic]
    comments: Sequence[Comment] = ()
    files: tuple[Path, ...] = ()  # all files that were read, starting with the source
    version: str = ""  # version of the format that the file declares
    format: str = ""  # name of the format; "urdf" for xacro
    takes_arguments: bool = False  # the file can have arguments, as in xacro
    unexpanded: bool = False  # a .urdf file has xacro elements, which were not expanded
    names: Mapping[str, Mapping[int, str]] = {}  # names of objects in the file by kind and index
    checked: bool = True  # the tree was validated
    mount: str = ""  # link of the including robot to which the joints of a xacro macro attach
    packages: Mapping[str, Path] = {}  # folders of the ROS packages that raw XML elements refer to
    passed: frozenset[str] = frozenset()  # keys of an include that were passed to a xacro macro

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
    """Convert the name of a robot to a file name with only ASCII letters, digits, "_", "-" and "."."""
    made = re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:_MAX_NAME].strip("._-")
    return made if made and isinstance(plain_scalar(made), str) else f"robot_{made}".strip("_")


class ReadOptions(NamedTuple):
    """Options for importing a file."""

    arguments: Mapping[str, str] = {}  # arguments for a xacro file
    packages: Mapping[str, Path] = {}  # folders of ROS packages to search first, by name
    lenient: bool = False  # accept a file that violates its specification if a robot can be read
    environment: Mapping[str, str] | None = None  # environment variables; default: those of this process
    tell: Callable[[Diagnostic], None] | None = None  # receives warnings before code is run
    checked: bool = True  # check the rules
    trust: bool = False  # allow the file to run code
    call: Map | None = None  # entry of ``include`` that calls a xacro macro ("macro", "with", "parent")
    spans: Mapping[str, Span] = {}  # source positions of arguments in a description


def convert_result(made: object, opened: ImportFile) -> ImportedRobot:
    """Convert the result of ``Format.load`` to an ImportedRobot. Raises TypeError if its type is invalid."""
    if isinstance(made, ImportedRobot):
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
    return ImportedRobot(tree, [diagnostic_of(one) for one in diagnostics], files=(opened.path,), checked=False)


def as_tree(value: Any, span: Span, path: Steps | None = None) -> Any:
    """Convert Python values to a YAML tree; ``span`` is the position of all values except ``SourceValue``."""
    while isinstance(value, SourceValue):
        value, span = value
    if value is None or isinstance(value, (bool, float)):
        return value
    path = path or []
    if len(path) > MAX_DEPTH:
        raise TypeError(f"{subject(path[:3])} is nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, str):  # a text instead of a number can have a unit, as in YAML
        quantity = Quantity.parse(value) if unit_at(path) is not None else None
        return str(value) if quantity is None else quantity
    if isinstance(value, (list, tuple)):
        items = Seq(span)
        places = value.value_spans if isinstance(value, Seq) else [span] * len(value)
        for index, (item, place) in enumerate(zip(value, places, strict=True)):
            inner, at = item if isinstance(item, SourceValue) else (item, span)
            made = inner if type(inner) is float else as_tree(inner, at, [*path, index])
            items.put(made, place if inner is item else at)
        return items
    if isinstance(value, (dict, Mapping)):  # dict first, because a test for an abstract class is slow
        tree = Map(span)
        for key, item in value.items():
            if not isinstance(key, str):
                raise TypeError(f"{subject(path)} has a key that is not text: {key!r}")
            inner, at = item if isinstance(item, SourceValue) else (item, span)
            tree.put(str(key), inner if type(inner) is float else as_tree(inner, at, [*path, key]), at, at)
        return tree
    if isinstance(value, Real):
        return int(value) if isinstance(value, Integral) and abs(int(value)) < _LARGEST else float(value)
    raise TypeError(f"{subject(path)} is of the type {type(value).__name__}, which no description holds")


class Proof(NamedTuple):
    """The differences between an imported file and its conversion, after loading both in an engine such as MuJoCo."""

    wrong: Mapping[str, Sequence[str]] = {}  # {field of the engine: unexpected differences}
    known: Mapping[str, Sequence[str]] = {}  # {field: differences that the import reported}
    said: str = ""  # summary of the comparison
    unknown: str = ""  # error message if the comparison failed

    @property
    def texts(self) -> list[str]:
        return [text for texts in self.wrong.values() for text in texts]


def comments_of(document: Document, paths: Mapping[int, TreePath]) -> list[Comment]:
    """Return the comments of an XML document; ``paths`` maps the ``id`` of an element to the YAML path of its entry."""
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
                where = BEFORE  # the comment is about the shape, not about its origin
            elif same_line and (above is not None or "\n" in text[item.end : following]):
                of, where = paths.get(id(above), path), BESIDE  # on the same line as a child or the start tag
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

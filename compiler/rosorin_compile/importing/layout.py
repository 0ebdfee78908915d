"""Write a document of plain values as YAML that reads as if a person had written it.

Small values are on one line, in brackets, larger ones in a block; what is too long for a line is wrapped. The result is
the same for the same document on every machine. A number has the digits of the source, if these read back as the same
double. Comments are written with their entries.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.formats.imported_robot import END, INSIDE, Comment
from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.diagnostics import MadeSpan, Span, printable
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Map, Path
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.yaml_text import Scalar

WIDTH = 120
# An implicit key has to end within 1,024 characters (https://yaml.org/spec/1.2.2/#example-single-pair-explicit-entry).
MAX_KEY = 1_000
_MAX_ALIGN = 60  # a list that is wrapped is aligned with its bracket; further right it is written as a block
_FIRST_ROW = "izz"  # an inertia that needs two lines has its moments on the first, its products on the second
_WORDS = ("for", "if")  # begin a loop or a condition; as the value of an expression they are names
_MAX_NAMED = 4  # named values of a part that may share a line
_SPACED = 2  # depth to which entries of several lines are set apart: sections and their entries
_NEVER_SHORT = ("links",)  # whose entries are easier to read in a block, however small
_OFTEN_SHORT = ("use", "params", "let")  # whose entries are rows of a table


class Verbatim(str):
    """A scalar that is written unchanged: a number, a quantity."""

    __slots__ = ()


class Expression(str):
    """A text with ``${...}`` that the expansion evaluates."""

    __slots__ = ()


class Remarks(NamedTuple):
    """Comments, as lines by the path of the entry that they belong to; every path is one of the document.

    ``before`` are written above the entry, ``inside`` at the end of its block. Those of the empty path are at the
    beginning and the end of the file.
    """

    before: Mapping[Path, Sequence[str]] = {}
    inside: Mapping[Path, Sequence[str]] = {}


_NONE = Remarks()


def escape(text: str) -> str:
    """Escape a text, in which ``${`` would begin an expression, and ``$(`` is refused outside of elements of XML.

    >>> escape("${HOME}/meshes"), escape("$(arg folder)/meshes")
    ('$${HOME}/meshes', "${'$'}(arg folder)/meshes")
    """
    made = text.replace("${", "$${")
    return made if "<" in made else made.replace("$(", "${'$'}(")


def layout(document: Mapping[str, Any], remarks: Remarks = _NONE) -> str:
    """Return a document as YAML, with a line end at its end.

    Values are mappings, lists, texts, ``Verbatim``, ``Expression``, booleans and None.
    """
    made = _Layout(remarks)
    lines = [*made.comment(remarks.before.get((), ()), ""), *made.mapping(document, 0, ())]
    end = made.comment(remarks.inside.get((), ()), "")
    return "".join(f"{line}\n" for line in [*lines, *([""] if end else []), *end])


def flow(value: Any) -> str | None:
    """Return a value on one line, or None for text of several lines and very long keys."""
    if isinstance(value, Mapping):
        pairs = [(_key(key, True), item) for key, item in value.items()]
        items = [(f"{key}: ", flow(item) if len(key) <= MAX_KEY else None) for key, item in pairs]
    elif isinstance(value, list):
        items = [("", flow(item)) for item in value]
    else:
        return None if isinstance(value, str) and "\n" in value else _scalar(value, True)
    opening, closing = "{}" if isinstance(value, Mapping) else "[]"
    inner = [f"{key}{item}" for key, item in items if item is not None]
    return f"{opening}{', '.join(inner)}{closing}" if len(inner) == len(items) else None


def _scalar(value: Any, in_flow: bool) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Verbatim):
        return str(value)
    if not isinstance(value, str):
        raise TypeError(f"a number is written as Verbatim, not as {type(value).__name__}")
    return Scalar(value if isinstance(value, Expression) else escape(value)).as_text(in_flow)


def _key(name: str, in_flow: bool) -> str:
    if isinstance(name, Verbatim):  # a loop or a condition of its entry
        return str(name)
    if name in _WORDS:
        return f"'${{\"{name}\"}}'"
    return Scalar(name if isinstance(name, Expression) else escape(name)).as_text(in_flow)


def within_part(path: Path) -> Path:
    """Return a path relative to the part that it leads into, such as ("links", "wheel")."""
    return path[2:] if path[:1] == ("parts",) and len(path) > 2 else path


class _Layout:
    """Makes the lines of one document."""

    def __init__(self, remarks: Remarks) -> None:
        self.remarks = remarks
        self.open = {path[:depth] for path, lines in remarks.before.items() if lines for depth in range(len(path))}
        self.open |= {path[:depth] for path in remarks.inside for depth in range(len(path) + 1)}

    def comment(self, lines: Iterable[str], pad: str) -> list[str]:
        """Return lines as comments, no wider than the page."""
        parts = (part for line in lines for part in _wrapped(line, WIDTH - len(pad) - 2))
        return [f"{pad}# {part}".rstrip() for part in parts]

    def with_comments(self, entry: list[str], pad: str, path: Path) -> tuple[list[str], list[str]]:
        """Return the comments above an entry, and the entry with those inside."""
        above = self.comment(self.remarks.before.get(path, ()), pad)
        return above, [*entry, *self.comment(self.remarks.inside.get(path, ()), f"{pad}  ")]

    def mapping(self, value: Mapping[str, Any], indent: int, path: Path) -> list[str]:
        """Return the lines of a mapping in block form."""
        lines: list[str] = []
        previous, pad = 0, " " * indent
        for key, item in value.items():
            here = (*path, key)
            name = _key(key, False)
            entry = self.value(f"{pad}{name if len(name) <= MAX_KEY else ''}:", item, indent, here)
            entry = entry if len(name) <= MAX_KEY else [f"{pad}? {name}", *entry]
            above, entry = self.with_comments(entry, pad, here)
            if lines and len(path) < _SPACED and (previous > 1 or len(entry) > 1):
                lines.append("")
            previous = len(entry)
            lines += [*above, *entry]
        return lines

    def value(self, head: str, item: Any, indent: int, path: Path) -> list[str]:
        """Return a value after ``head``, which ends with a colon or a dash: on its line, wrapped, or below it."""
        if not isinstance(item, (Mapping, list)):
            return _text(head, item, indent)
        if not item:
            return [f"{head} {flow(item)}"]
        closed = path not in self.open
        if closed and self.may_be_short(item, path):
            short = flow(item)
            if short is not None and len(head) + 1 + len(short) <= WIDTH:
                return [f"{head} {short}"]
        if closed and _is_flat(item) and (isinstance(item, list) or len(path) > 2) and flow(item) is not None:
            wrapped = _filled(f"{head} ", item)
            named = within_part(path) == ("let",)  # values that have names are read one by one
            if wrapped and not (named and (len(wrapped) > 1 or len(item) > _MAX_NAMED)):
                return wrapped
        if isinstance(item, Mapping):
            return [head, *self.mapping(item, indent + 2, path)]
        return [head, *self.sequence(item, indent + 2, path)]

    def may_be_short(self, item: Mapping[str, Any] | list[Any], path: Path) -> bool:
        """Return True if a value that fits on a line may be written there."""
        if isinstance(item, list):
            return not _has_mapping(item)
        path = within_part(path)
        if len(path) == 1:
            return path == ("source",)
        if len(path) == 2 and path[0] in _NEVER_SHORT:
            return False
        if len(path) == 2 and path[0] in _OFTEN_SHORT:
            return _depth(item) <= 2
        return _depth(item) <= (1 if len(path) == 2 and isinstance(path[1], str) else 2)

    def sequence(self, value: list[Any], indent: int, path: Path) -> list[str]:
        """Return the lines of a list in block form."""
        pad, lines = " " * indent, []
        for index, item in enumerate(value):
            here = (*path, index)
            above, made = self.with_comments(self.value(f"{pad}-", item, indent, here), pad, here)
            lines += above
            if made[0] == f"{pad}-":  # the first line below a dash is written on its line, after comments
                below = made[1:]
                count = next(number for number, line in enumerate(below) if not line.lstrip().startswith("#"))
                lines += [pad + line.lstrip() for line in below[:count]]
                made = [f"{pad}- {below[count].lstrip()}", *below[count + 1 :]]
            lines += made
        return lines


def _text(head: str, value: Any, indent: int) -> list[str]:
    """Return a scalar after ``head``: on its line, or text of several lines below it."""
    one = f"{head} {_scalar(value, False)}"
    if not isinstance(value, str) or isinstance(value, Verbatim):
        return [one]
    text = value if isinstance(value, Expression) else escape(value)
    pad = " " * (indent + 2)
    lines = text.removesuffix("\n").split("\n")
    is_block = "\n" in text and lines[0][:1] not in ("", " ", "\t") and lines[-1].strip()
    if is_block and all(Scalar(line.replace("\t", " ")).is_raw for line in lines):
        mark = "|" if text.endswith("\n") else "|-"
        return [f"{head} {mark}", *(f"{pad}{line}" if line else "" for line in lines)]
    if len(one) > WIDTH and Scalar(text).is_raw and "  " not in text and text == text.strip(" "):
        return [f"{head} >-", *(pad + line for line in _wrapped(text, WIDTH - len(pad)))]
    return [one]


def _wrapped(text: str, width: int) -> list[str]:
    """Return a line in pieces no longer than ``width`` where its spaces allow that, indentation kept."""
    if len(text) <= width:
        return [text]
    body = text.lstrip(" ")
    margin = text[: len(text) - len(body)]
    options: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    return textwrap.wrap(body, width, initial_indent=margin, subsequent_indent=margin, **options) or [text]


def _is_flat(value: Mapping[str, Any] | list[Any]) -> bool:
    """Return True if a value contains nothing but scalars, or in a mapping also lists of them."""
    items = value.values() if isinstance(value, Mapping) else value
    return not any(isinstance(item, (Mapping, list)) for item in items)


def _filled(head: str, value: Mapping[str, Any] | list[Any]) -> list[str]:
    """Return a list or mapping in brackets on several aligned lines, or nothing if that is not better."""
    opening, closing = "{}" if isinstance(value, Mapping) else "[]"
    if isinstance(value, Mapping):
        tokens = [f"{_key(key, True)}: {flow(item)}" for key, item in value.items()]
    else:
        tokens = [str(flow(item)) for item in value]
    margin = " " * (len(head) + 1)
    if len(margin) > _MAX_ALIGN or max(map(len, tokens)) > WIDTH - len(margin) - 1:
        return []
    last = list(value).index(_FIRST_ROW) if isinstance(value, Mapping) and _FIRST_ROW in value else -1
    rows: list[list[str]] = [[]]
    for number, token in enumerate(tokens):
        row = rows[-1]
        if row and (number == last + 1 > 0 or len(margin) + len(", ".join([*row, token])) + 1 > WIDTH):
            rows.append([])
        rows[-1].append(token)
    lines = [margin + ", ".join(row) for row in rows]
    lines[0] = f"{head}{opening}{lines[0].lstrip()}"
    return [f"{line}," for line in lines[:-1]] + [lines[-1] + closing]


def _depth(value: Any) -> int:
    """Return how many mappings are nested in a value."""
    if isinstance(value, Mapping):
        return 1 + max(map(_depth, value.values()), default=0)
    return max(map(_depth, value), default=0) if isinstance(value, list) else 0


def _has_mapping(value: list[Any]) -> bool:
    return any(isinstance(item, Mapping) or (isinstance(item, list) and _has_mapping(item)) for item in value)


ROTATING = ("revolute", "continuous")
_DECIMALS = (0, 1, 2)  # of degrees that a person would write
_MAX_DEGREES = 1e6
_DIGITS = 15  # of every decimal number that a double tells from all others

# Units of a value of a joint that rotates and of one that slides, with the unit in degrees of the first.
_OF_JOINT = {("rad", "m"): "deg", ("rad/s", "m/s"): "deg/s"}
_VERBATIM = "mjcf"  # keys of another program, whose numbers have no units
_OF_SENSOR: tuple[Path, ...] = (("with", "fov"), ("with", "vertical_fov"), ("with", "hfov"))


def number(value: float, span: Span | None, angle: str = "") -> Verbatim:
    """Return a number as it is written; ``angle`` is the unit in degrees that it may have (deg, deg/s).

    >>> number(-1.5707963267948966, None, "deg"), number(1.5708, None, "deg"), number(-0.0, None)
    ('-90 deg', '1.5708', '0')
    """
    if value == 0:
        return Verbatim("0")
    if isinstance(value, Quantity) and value.text and Quantity.parse(value.text) == value:
        return Verbatim(value.text)
    if not math.isfinite(value):
        return Verbatim(".nan" if value != value else ".inf" if value > 0 else "-.inf")
    return Verbatim((angle and in_degrees(value, angle)) or _digits(value, span) or exact(value))


def in_degrees(value: float, unit: str) -> str:
    """Return radians as degrees, empty unless a short number of degrees is exactly this double."""
    degrees = math.degrees(value)
    for decimals in _DECIMALS if abs(degrees) < _MAX_DEGREES else ():
        text = f"{exact(round(degrees, decimals))} {unit}"
        if Quantity.parse(text) == value:
            return text
    return ""


def _digits(value: float, span: Span | None) -> str:
    """Return the digits at a place of the source, empty unless they are this very number."""
    if span is None:
        return ""
    token = span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length]
    token = (span.text if isinstance(span, MadeSpan) else token).removeprefix("+")
    if not token or len(token) != len(token.strip()):
        return ""
    read = Scalar(token).value
    same = isinstance(read, (int, float)) and not isinstance(read, (bool, Quantity)) and float(read) == float(value)
    significant = "".join(filter(str.isdigit, token.lower().partition("e")[0])).lstrip("0")
    return token if same and (len(significant) <= _DIGITS or len(exact(value)) >= len(token)) else ""


def joint_unit(*path: str) -> str:
    """Return the unit in degrees of a value of a joint that turns, by its path there; empty if it is no angle."""
    return _of_joint(("joints", "*", *path))


def angle_of(tree: Map, path: Path) -> str:
    """Return the unit in degrees of the value at a path of a description, empty if it is no angle."""
    body = tree["parts"][path[1]] if path[0] == "parts" and len(path) > 2 else tree
    path = within_part(path)
    if path[-2:-1] == ("rpy",) or (path[:1] == ("sensors",) and path[2:] in _OF_SENSOR):
        return "deg"
    unit = _of_joint(path)
    if not unit:
        return ""
    names = fragment_at(path[:-1]).get("propertyNames", {}).get("x-names")
    name = path[1] if path[0] == "joints" else path[-1] if names == "joint" else None
    joint = (body.get("joints") or {}).get(name)
    return unit if isinstance(joint, Mapping) and joint.get("type") in ROTATING else ""


def _of_joint(path: Path) -> str:
    """Return the unit in degrees of a value of a joint that turns; empty if it is no angle of one."""
    units = () if _VERBATIM in path else fragment_at(path).get("x-unit", ())
    return _OF_JOINT.get(tuple(units), "")


_LINE_END = re.compile("\r\n|[\n\r\x85\u2028\u2029]")
_MARK = re.compile(r"\A#+(?: |\Z)")
_OF_ROBOT = ("robot", "source")


def place_comments(
    comments: Iterable[Comment], document: Mapping[str, Any], head: Sequence[str], root: bool
) -> Remarks:
    """Return the comments of one file. ``head`` are lines that begin it.

    A comment belongs to the file that has its section. What belongs to no section, or to the name of the robot, is in
    the ``root`` file: at its beginning, or at its end if it was there.
    """
    before: dict[Path, list[str]] = {(): list(head)}
    inside: dict[Path, list[str]] = {}
    for comment in comments:
        lines = clean_comment(comment.text)
        if not comment.path or comment.path[0] in _OF_ROBOT:
            if root:
                (inside if comment.where == END else before).setdefault((), []).extend(lines)
            continue
        path, value = _existing(document, comment.path)
        if not path:
            continue  # its section is in another file
        if comment.where == INSIDE and value and _is_block(value):
            inside.setdefault(path, []).extend(lines)
        elif (
            len(lines) == 1 or before.get(path, [])[-len(lines) :] != lines
        ):  # a file that is included twice has it twice
            before.setdefault(path, []).extend(lines)
    return Remarks(before, inside)


def clean_comment(text: str) -> list[str]:
    """Return the lines of a comment, moved left together, without empty lines around them.

    >>> clean_comment(" the arm "), clean_comment("# the arm")
    (['the arm'], ['# the arm'])
    """
    first, *others = (line.expandtabs(4).rstrip() for line in _LINE_END.split(text))
    # The first line follows the opening of the comment, so its indentation is not that of the others.
    body = textwrap.dedent("\n".join(others)).split("\n") if others else []
    found = _unmarked([printable(line) for line in [first.strip(), *body]])
    while found and not found[0]:
        found.pop(0)
    while found and not found[-1]:
        found.pop()
    return found


def _unmarked(lines: list[str]) -> list[str]:
    """Return the lines of a comment; those that begin with the mark of a comment, all of them, without it."""
    texts = [line for line in lines if line.strip()]
    if len(texts) < 2 or not all(line.startswith("#") for line in texts[1:]):
        return lines
    return [_MARK.sub("", line) for line in lines]


def _existing(document: Mapping[str, Any], path: Sequence[str | int]) -> tuple[Path, Any]:
    """Return the longest prefix of a path that leads to an entry that can have a comment, and its value."""
    node: Any = document
    found: list[str | int] = []
    for step in path:
        is_item = isinstance(node, list) and isinstance(step, int) and step < len(node) and _is_block(node)
        if not is_item and not (isinstance(node, Mapping) and step in node):
            break
        node = node[step]
        found.append(step)
    return tuple(found), node


def _is_block(value: Any) -> bool:
    """Return True for a mapping, and for a list that is written in several lines."""
    items = value if isinstance(value, list) else ()
    is_long = any(isinstance(item, (Mapping, list)) or (isinstance(item, str) and "\n" in item) for item in items)
    return isinstance(value, Mapping) or is_long

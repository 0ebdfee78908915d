"""Format an imported robot as YAML description files that are easy to read and edit.

The schema key ``x-first`` lists the keys that come first in an entry; the remaining keys keep the order of the source.
If a description is split, the schema key ``x-file`` is the file name of a section. Small values are written in flow
style on one line, larger values in block style. Numbers have the fewest digits that are parsed to the same double.
"""

import math
import os
import re
import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path as FilePath
from types import MappingProxyType
from typing import Any, TypeVar

from rosorin_compile.formats.imported_robot import Comment, ImportedRobot, Outputs
from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.diagnostics import printable
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Path
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.yaml_text import Scalar

# The files that robot.yaml includes if a description is split, in this order; files not listed come last.
_FILES = ("parts", "links", "joints", "simulation", "sensors", "control", "extensions", "moveit")
_BEHIND = {"let": "parts", "joints": "use"}  # section -> section that is written directly after it
_LAST = 1_000  # sort position of keys that are not in the schema: after all keys of the schema
MAX_LINES = 150  # longer descriptions are split into several files

V = TypeVar("V")


def write(imported: ImportedRobot, wanted: Outputs, schema: str = "", split: bool | None = None) -> dict[str, str]:
    """Format a description as one or more YAML files; return the text of each file by name, ``robot.yaml`` first.

    ``wanted`` is the section ``outputs`` of the description, and ``schema`` the relative path of the JSON schema for
    editors. By default (``split`` is None), only descriptions longer than ``MAX_LINES`` are split into several files.
    """
    tree, root = imported.whole, Description.ROOT_FILE
    body = {key: document_value(tree, value, (key,), imported.packages) for key, value in tree.items() if value}
    body["outputs"] = plain_value(wanted.entries)
    document: dict[str, Any] = sorted_sections({"rosorin_compile": Verbatim("1"), **body})

    def text(file: str, content: dict[str, Any]) -> str:
        remarks = place_comments(imported.comments, content, file == root)
        head = [f"yaml-language-server: $schema={schema}"] if schema else []
        remarks[()] = [*head, *remarks.get((), ())]
        if file == root and wanted.lines:
            remarks[("outputs",)] = [*remarks.get(("outputs",), ()), *wanted.lines]
        return layout(content, remarks)

    single = text(root, document)
    if split is False or (split is None and single.count("\n") <= MAX_LINES):
        return {root: single}
    parts: dict[str, dict[str, Any]] = {name: {} for name in _FILES}
    for section in list(document):
        if file := "parts" if section == "parts" else fragment_at((section,)).get("x-file"):
            parts.setdefault(file, {})[section] = document.pop(section)
    parts = {f"{name}.yaml": part for name, part in parts.items() if part}
    document["include"] = list(parts)
    source = {"source": document["source"]} if "source" in document else {}
    files = {root: sorted_sections(document), **{file: {**source, **part} for file, part in parts.items()}}
    return {file: text(file, content) for file, content in files.items()}


def lines_of(tree: Mapping[str, Any]) -> int:
    """Return the number of lines of the YAML text for ``tree``, which has sections of a description."""
    return layout({key: document_value(tree, value, (key,)) for key, value in tree.items()}).count("\n")


def document_value(
    tree: Mapping[str, Any], value: Any, path: Path, packages: Mapping[str, FilePath] = MappingProxyType({})
) -> Any:
    """Prepare a value of the description ``tree`` for writing as YAML: drop defaults, sort keys, format numbers.

    ``path`` is the path of the value. Absolute paths into the folders in ``packages`` become ``find`` expressions.
    """
    if isinstance(value, (list, tuple)):
        return [document_value(tree, item, (*path, index), packages) for index, item in enumerate(value)]
    if isinstance(value, str):
        return value if isinstance(value, Verbatim) else _in_packages(value, packages)
    if is_number(value):
        return number(value, angle_of(tree, path))
    if not isinstance(value, Mapping):
        return value
    own = within_part(path)
    items = {key: item for key, item in value.items() if not is_default((*own, key), item)}
    made = {key: document_value(tree, item, (*path, key), packages) for key, item in items.items()}
    made = {key: item for key, item in made.items() if item or key != "dynamics"}
    return made if len(own) == 1 else _sorted(made, _order(fragment_at(own)))


def _in_packages(text: str, packages: Mapping[str, FilePath]) -> str:
    """Replace absolute paths into ROS packages with paths that begin with ``${find('PACKAGE', ...)}``."""
    if not any(f"{folder}{os.sep}" in text for folder in packages.values()):
        return text if isinstance(text, Expression) else str(text)
    made = text if isinstance(text, Expression) else escape(text)
    for name, folder in packages.items():
        made = made.replace(f"{folder}{os.sep}", f"${{find('{name}', 'package://{name}')}}/")
    return Expression(made)


def plain_value(value: Any) -> Any:
    """Format the numbers in a nested value for writing as YAML; all keys and their order stay unchanged."""
    if isinstance(value, Mapping):
        return {key: plain_value(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_value(item) for item in value]
    return number(value) if is_number(value) else value


def sorted_sections(document: Mapping[str, V]) -> dict[str, V]:
    """Sort the top-level sections of a description file by the order in the schema."""
    return _sorted(document, [one for key in fragment_at(())["properties"] for one in (key, _BEHIND.get(key, key))])


def in_order(entry: Mapping[str, V]) -> dict[str, V]:
    """Sort the keys of a link, joint or nested element as in the schema; the keys determine the kind of the element."""
    return _sorted(entry, max(_orders(), key=lambda order: len(entry.keys() & set(order))))


def is_default(path: Path, value: Any) -> bool:
    """Return True if ``value`` is the schema default of the key at ``path``; always return False for booleans."""
    default = fragment_at(path).get("default")
    return default is not None and not isinstance(value, bool) and bool(value == default)


def _sorted(values: Mapping[str, V], order: Iterable[str]) -> dict[str, V]:
    rank = {key: place for place, key in enumerate(order)}
    return dict(sorted(values.items(), key=lambda item: rank.get(item[0], _LAST)))


def _order(fragment: Mapping[str, Any]) -> Sequence[str]:
    return tuple(fragment.get("x-first", fragment.get("properties", ())))


@cache
def _orders() -> list[Sequence[str]]:
    return list(dict.fromkeys(map(_order, (*_fragments(("links", "*")), *_fragments(("joints", "*"))))))


def _fragments(path: Path) -> Iterator[Mapping[str, Any]]:
    """Yield the schema of the value at ``path``, then recursively the schemas of its properties and list items."""
    fragment = fragment_at(path)
    yield fragment
    for step in (*fragment.get("properties", ()), *([0] if "items" in fragment else [])):
        yield from _fragments((*path, step))


WIDTH = 120
_WORDS = ("for", "if")  # links with these names are quoted, because unquoted keys mark loops and conditions
_SPACED = 2  # maximum depth (sections, entries) at which empty lines separate multi-line entries
_SHORT_DEPTH = 2  # maximum nesting of mappings that are written on one line

# Path of an entry -> comment lines above the entry; the empty path is the top of the file.
Remarks = dict[Path, Sequence[str]]


class Verbatim(str):
    """A YAML scalar that is written without quotes or escapes, such as ``5 mm``."""

    __slots__ = ()


class Expression(str):
    """A string with ``${...}`` expressions, which are evaluated when the description is compiled."""

    __slots__ = ()


def escape(text: str) -> str:
    """Escape ``${``, which would begin an expression, and ``$(``, which is an error outside XML elements.

    >>> escape("${HOME}/meshes"), escape("$(arg folder)/meshes")
    ('$${HOME}/meshes', "${'$'}(arg folder)/meshes")
    """
    made = text.replace("${", "$${")
    return made if "<" in made else made.replace("$(", "${'$'}(")


def layout(document: Mapping[str, Any], remarks: Mapping[Path, Sequence[str]] = MappingProxyType({})) -> str:
    """Format a document as YAML text; ``remarks`` maps the path of an entry to the comment lines above the entry.

    A document contains mappings, lists, strings, ``Verbatim``, ``Expression``, booleans and None; numbers are
    ``Verbatim``.
    """
    made = _Layout(remarks)
    return "".join(f"{line}\n" for line in [*made.comment((), ""), *made.block(document, 0, ())])


def flow(value: Any) -> str | None:
    """Format a value in YAML flow style on one line, or return None if it contains a multi-line string."""
    if isinstance(value, Mapping):
        items = [(f"{_key(key, True)}: ", flow(item)) for key, item in value.items()]
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
    return f"'${{\"{name}\"}}'" if name in _WORDS and not isinstance(name, Verbatim) else _scalar(name, in_flow)


def is_number(value: Any) -> bool:
    """Return True for an int or float, but False for a bool."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def free_name(name: str, taken: Collection[str]) -> str:
    """Return ``name``, or ``name`` with the first free number appended (``wheel_2``) if it is in ``taken``."""
    made, number = name, 1
    while made in taken:
        number += 1
        made = f"{name}_{number}"
    return made


def within_part(path: Path) -> Path:
    """Strip the part from a path: ``("parts", "leg", "links", "foot")`` becomes ``("links", "foot")``."""
    return path[2:] if path[:1] == ("parts",) and len(path) > 2 else path


class _Layout:
    """Formats a document as YAML lines; a comment is written above the entry with its path."""

    def __init__(self, remarks: Mapping[Path, Sequence[str]]) -> None:
        self.remarks = remarks
        self.open = {path[:depth] for path, lines in remarks.items() if lines for depth in range(len(path))}

    def comment(self, path: Path, pad: str) -> list[str]:
        return [f"{pad}# {line}".rstrip() for line in self.remarks.get(path, ())]

    def block(self, value: Mapping[str, Any] | list[Any], indent: int, path: Path) -> list[str]:
        lines: list[str] = []
        previous, pad, is_list = 0, " " * indent, isinstance(value, list)
        items: Iterable[tuple[Any, Any]] = enumerate(value) if isinstance(value, list) else value.items()
        for key, item in items:
            here = (*path, key)
            entry = self.value(f"{pad}-" if is_list else f"{pad}{_key(key, False)}:", item, indent, here)
            if entry[0] == f"{pad}-" and not entry[1].lstrip().startswith("#"):
                entry[:2] = [f"{pad}- {entry[1].lstrip()}"]
            if lines and not is_list and len(path) < _SPACED and (previous > 1 or len(entry) > 1):
                lines.append("")
            previous = len(entry)
            lines += [*self.comment(here, pad), *entry]
        return lines

    def value(self, head: str, item: Any, indent: int, path: Path) -> list[str]:
        """Format a value after ``head`` (a key or a dash): on the same line, wrapped, or as a block below."""
        if not isinstance(item, (Mapping, list)):
            return _text(head, item, indent)
        short = flow(item) if not item or path not in self.open else None
        if short and (not item or (self.may_be_short(item, path) and len(head) + 1 + len(short) <= WIDTH)):
            return [f"{head} {short}"]
        items = item.values() if isinstance(item, Mapping) else item
        is_flat = short is not None and not any(isinstance(one, (Mapping, list)) for one in items)
        if short and is_flat and (isinstance(item, list) or len(path) > _SPACED):
            keys = [f"{_key(key, True)}: " for key in item] if isinstance(item, Mapping) else [""] * len(item)
            pairs = zip(keys, items, strict=True)
            text = ", ".join(f"{key}{flow(one)}".replace(" ", "\0") for key, one in pairs)  # break only between items
            text, margin = f"{short[0]}{text}{short[-1]}", " " * (indent + 2)
            wrap = textwrap.TextWrapper(WIDTH, f"{head} ", margin, break_long_words=False, break_on_hyphens=False)
            return [line.replace("\0", " ") for line in wrap.wrap(text)]
        return [head, *self.block(item, indent + 2, path)]

    def may_be_short(self, item: Mapping[str, Any] | list[Any], path: Path) -> bool:
        path = within_part(path)
        if isinstance(item, list):
            return _depth(item) == 0
        is_long = (len(path) == 1 and path != ("source",)) or (len(path) == 2 and path[0] == "links")
        return not is_long and _depth(item) <= _SHORT_DEPTH


def _text(head: str, value: Any, indent: int) -> list[str]:
    """Format a scalar after ``head`` on the same line, or a multi-line string as a literal block below ``head``."""
    if isinstance(value, str) and not isinstance(value, Verbatim):
        text = value if isinstance(value, Expression) else escape(value)
        lines = text.removesuffix("\n").split("\n")
        is_block = "\n" in text and lines[0][:1] not in ("", " ", "\t") and lines[-1].strip()
        if is_block and all(Scalar(line.replace("\t", " ")).is_raw for line in lines):
            mark, pad = "|" if text.endswith("\n") else "|-", " " * (indent + 2)
            return [f"{head} {mark}", *(f"{pad}{line}" if line else "" for line in lines)]
    return [f"{head} {_scalar(value, False)}"]


def _depth(value: Any) -> int:
    if isinstance(value, Mapping):
        return 1 + max(map(_depth, value.values()), default=0)
    return max(map(_depth, value), default=0) if isinstance(value, list) else 0


ROTATING = ("revolute", "continuous")
_DECIMALS = (0, 1, 2)  # decimals to try for angles in degrees
_MAX_DEGREES = 1e6
# Schema units (rotating joint, sliding joint) -> unit in which values of rotating joints are written.
_OF_JOINT = {("rad", "m"): "deg", ("rad/s", "m/s"): "deg/s"}
_VERBATIM = "mjcf"  # values below this key are MuJoCo attributes, which have no units
_OF_SENSOR: tuple[Path, ...] = (("with", "fov"), ("with", "vertical_fov"), ("with", "hfov"))


def number(value: float, angle: str = "") -> Verbatim:
    """Format a number; with ``angle`` ("deg" or "deg/s"), convert radians to degrees if the result is exact.

    >>> number(-1.5707963267948966, "deg"), number(1.5708, "deg"), number(-0.0)
    ('-90 deg', '1.5708', '0')
    """
    if value == 0:
        return Verbatim("0")
    if isinstance(value, Quantity) and value.text and Quantity.parse(value.text) == value:
        return Verbatim(value.text)
    if not math.isfinite(value):
        return Verbatim(".nan" if value != value else ".inf" if value > 0 else "-.inf")
    return Verbatim((angle and in_degrees(value, angle)) or exact(value))


def in_degrees(value: float, unit: str) -> str:
    """Format an angle (rad) in degrees with at most two decimals, or return "" if that is not exact."""
    degrees = math.degrees(value)
    for decimals in _DECIMALS if abs(degrees) < _MAX_DEGREES else ():
        text = f"{exact(round(degrees, decimals))} {unit}"
        if Quantity.parse(text) == value:
            return text
    return ""


def angle_of(tree: Mapping[str, Any], path: Path) -> str:
    """Return the unit in which to write the value at ``path``: "deg", "deg/s", or "" if it is not an angle."""
    body = tree["parts"][path[1]] if path[0] == "parts" and len(path) > 2 else tree
    path = within_part(path)
    if path[-2:-1] == ("rpy",) or (path[:1] == ("sensors",) and path[2:] in _OF_SENSOR):
        return "deg"
    unit = _OF_JOINT.get(tuple(fragment_at(path).get("x-unit", ())), "")
    if not unit or _VERBATIM in path:
        return ""
    names = fragment_at(path[:-1]).get("propertyNames", {}).get("x-names")
    name = path[1] if path[0] == "joints" else path[-1] if names == "joint" else None
    joint = (body.get("joints") or {}).get(name)
    return unit if isinstance(joint, Mapping) and joint.get("type") in ROTATING else ""


def place_comments(comments: Iterable[Comment], document: Mapping[str, Any], root: bool) -> dict[Path, list[str]]:
    """Return the comment lines of a description file by path; each comment is written above the entry at its path.

    Comments on sections that are not in ``document`` are dropped. If ``root`` is True (the file is ``robot.yaml``),
    comments without a section and comments on the robot name are placed at the top of the file.
    """
    found: dict[Path, list[str]] = {}
    for comment in comments:
        path: Path = ()
        node: Any = document
        of_section = bool(comment.path) and comment.path[0] not in ("robot", "source")
        for step in comment.path if of_section else ():
            is_item = isinstance(node, list) and isinstance(step, int) and step < len(node)
            if not (is_item or (isinstance(node, Mapping) and step in node)) or isinstance(node[step], Verbatim):
                break
            node, path = node[step], (*path, step)
        if not (path if of_section else root):  # skip a comment on a section of another file
            continue
        lines, above = clean_comment(comment.text), found.setdefault(path, [])
        if len(lines) == 1 or above[-len(lines) :] != lines:  # skip the comments of a file that is included again
            above += lines
    return found


def clean_comment(text: str) -> list[str]:
    """Split an XML comment into lines without common indentation and without leading and trailing empty lines.

    >>> clean_comment(" the arm "), clean_comment("# the arm")
    (['the arm'], ['# the arm'])
    """
    first, *others = (line.expandtabs(4).rstrip() for line in re.split("\r\n|[\n\r\x85\u2028\u2029]", text))
    # Do not dedent the first line, which follows ``<!--``.
    found = [printable(line) for line in [first.strip(), *textwrap.dedent("\n".join(others)).split("\n")]]
    while found and not found[0]:
        found.pop(0)
    while found and not found[-1]:
        found.pop()
    return found

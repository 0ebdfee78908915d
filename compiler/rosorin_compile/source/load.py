"""Parse YAML to a tree with the position of every value; parse JSON and Python with a limit on the nesting depth.

Scalars follow the YAML 1.2 core schema (https://yaml.org/spec/1.2.2/#103-core-schema), not YAML 1.1:
``1e-3`` is a number, ``on`` and ``12:30`` are strings. As an extension, an unquoted number with a unit, such as
``12.5 mm``, is a quantity. A quoted scalar is always a string.
"""

import json
import math
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml
from yaml import MappingEndEvent, ScalarEvent, SequenceEndEvent

from . import files
from .diagnostics import Help, Related, Source, SourceError, Span, Suggestion, error
from .project import stdin_of
from .tree import Instance, Map, Seq, Text
from .units import Quantity
from .wording import in_words
from .yaml_mistakes import MAX_DEPTH, explain_mistake, quoted_tokens

if TYPE_CHECKING:
    import ast


MAX_BYTES, MAX_NODES = 20_000_000, 1_000_000
_INT = re.compile(r"[-+]?[0-9]+\Z")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?\Z")
_BASED = r"0x[0-9a-fA-F]{1,15}\Z|0o[0-7]{1,20}\Z"
_WORDS: dict[str, Any] = {"": None, "~": None, "null": None, "Null": None, "NULL": None}
_WORDS |= {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_WORDS |= {sign + word: float(sign + "inf") for sign in ("", "+", "-") for word in (".inf", ".Inf", ".INF")}
_WORDS |= {word: float("nan") for word in (".nan", ".NaN", ".NAN")}
# The unit tags of xacro's YAML loader, which many robot packages use (https://github.com/ros/xacro/wiki).
_UNIT_TAGS = {"!degrees": "deg", "!radians": "rad", "!meters": "m"}
_UNIT_TAGS |= {"!millimeters": "mm", "!foot": "ft", "!inches": "inch"}
_FUNCTIONS = ("pi", "e", "tau", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "radians", "degrees")
# Matches a calculation after a unit tag. Powers are not allowed, because they could take arbitrarily long.
_CALCULATION = rf"(?:[-+/(), \d.]|\*(?!\*)|(?<=\d)e(?=[-+\d])|\b(?:{'|'.join(_FUNCTIONS)})\b)+"

LoadError = SourceError


def read_input(path: Path, shown: str, asked: Span | None, most: int, help: str) -> bytes:
    """Read a file or standard input. Raises SourceError if it is unreadable or larger than ``most`` bytes.

    ``shown`` is the path in messages. ``asked`` is the position in another file that refers to this file, or None.
    """
    data = stdin_of(path)
    try:
        data = files.read_bytes(path, most + 1) if data is None else data
    except OSError as problem:
        reason = problem.strerror or str(problem)
        raise SourceError(error("file-unreadable", f"cannot read {shown}: {reason}", asked, help)) from None
    if len(data) > most:
        raise SourceError(error("file-too-large", f"{shown} is larger than {most:,} bytes", asked, help))
    return data


def read_utf8(path: Path, shown: str, asked: Span | None = None) -> Source:
    """Read a UTF-8 file; ``shown`` and ``asked`` are as in ``read_input``. Raises LoadError."""
    return decode(read_input(path, shown, asked, MAX_BYTES, "check the file name and the permissions"), shown)


def decode(data: bytes, shown: str, encoding: str = "utf-8", help: str = "save the file as UTF-8") -> Source:
    """Decode the contents of a file; ``shown`` is its path in messages. Raises LoadError at the first invalid byte."""
    try:
        return Source(shown, data.decode(encoding).removeprefix("\ufeff"))
    except UnicodeDecodeError as problem:
        start = len(data[: problem.start].decode(encoding, "replace"))
        span = Source(shown, data.decode(encoding, "replace")).span(start)
        message = f"{shown} is not {encoding.upper()} text: byte {data[problem.start]:#04x} at this place"
        raise LoadError(error("not-utf8", message, span, help)) from None


def load_mapping(path: Path, shown: str, asked: Span | None = None, via: Instance | None = None) -> Map:
    """Read a YAML file that must contain a mapping; ``via`` is the include that loads it, or None. Raises LoadError."""
    source = read_utf8(path, shown, asked)
    tree = parse_yaml(source, via)
    if isinstance(tree, Map):
        return tree
    kind = "empty" if tree is None else "a list" if isinstance(tree, Seq) else "not a mapping"
    message = f'{source.path} is {kind}; a description is a mapping such as "robot: my_robot"'
    is_piped = tree is None and stdin_of(path) is not None
    help = "the program before the pipe printed nothing" if is_piped else "start from docs/tutorial.md"
    if source.text.lstrip().startswith("<"):
        message, help = f"{source.path} is XML, not a description", "`rosorin-compile import` converts robots in XML"
    raise LoadError(error("not-a-mapping", message, source.span(), help))


load_own = cache(load_mapping)  # for files of this package: the tree is cached, so do not modify it


def parse_yaml(source: Source, via: Instance | None = None, max_nodes: int = MAX_NODES) -> Any:
    """Parse YAML to a ``Map``, ``Seq`` or scalar; ``via`` is the include that loads it, or None. Raises LoadError."""
    _check_text(source)
    try:
        return _Composer(source, via, max_nodes).document()
    except yaml.YAMLError as problem:
        raise LoadError(explain_mistake(source, problem)) from None


_BIDI = "[\u202a-\u202e\u2066-\u2069]"
_LINE_ENDS = "[\x85\u2028\u2029]"
_DIRECTIVE = r"(?:\s|#.*\n)*(%(?!YAML\s+1\.2\s)\S+.*)\n(?:.*\n)*?---"


def _check_text(source: Source) -> None:
    text = source.text
    if directive := re.match(_DIRECTIVE, text) if "%" in text[:1_000] else None:
        message = f"{directive[1].split('#')[0].strip()} has no effect: files are read as YAML 1.2"
        raise LoadError(error("yaml-directive", message, source.span(directive.start(1)), "remove the line"))
    if text.isascii():
        return
    if found := re.search(_BIDI, text):
        help = f'remove it, or write the text in double quotes with "\\u{ord(found[0]):04x}"'
        message = f"{in_words(found[0])} changes the order in which editors display this line"
        raise LoadError(error("bidi-control", message, source.span(found.start()), help))
    if not (line_ends := {found.start() for found in re.finditer(_LINE_ENDS, text)}):
        return
    for token in quoted_tokens(text):
        line_ends -= {*range(token.start_mark.index, token.end_mark.index)}
    if line_ends:
        message = f"{in_words(text[min(line_ends)]).removesuffix(', a control character')} ends the line in YAML"
        help = "remove the character, which most editors do not show as a line end"
        raise LoadError(error("yaml-line-end", message, source.span(min(line_ends)), help))


class _Composer:
    def __init__(self, source: Source, via: Instance | None, max_nodes: int) -> None:
        self.source, self.via = source, via
        self.anchors: dict[str, tuple[Any, int, Span]] = {}
        self.nodes, self.max_nodes = 0, max_nodes
        # libyaml counts columns in characters, as ``Span`` does, and raises ReaderError for control characters.
        self.events: Iterator[Any] = iter(getattr(yaml, "CLoader", yaml.Loader)(source.text).get_event, None)

    def document(self) -> Any:
        tree, documents = None, 0
        for event in self.events:
            documents += isinstance(event, yaml.DocumentStartEvent)
            if documents > 1:
                raise self.fail("yaml-documents", "the file has more than one YAML document", event, 'remove the "---"')
            if isinstance(event, yaml.NodeEvent):
                tree = self.value(event, 0, self.span(event))
        return tree

    def span(self, event: Any) -> Span:
        start, end = event.start_mark, event.end_mark
        length = end.column - start.column if end.line == start.line else 1
        return Span(self.source, start.line + 1, start.column + 1, max(1, length))

    def fail(self, rule: str, message: str, event: Any, help: Help) -> LoadError:
        return LoadError(error(rule, message, self.span(event), help))

    def value(self, event: Any, depth: int, span: Span) -> Any:
        is_alias, before = isinstance(event, yaml.AliasEvent), self.nodes
        alias = self.anchors.get(event.anchor) if is_alias else None
        self.nodes += 1 + (alias[1] if alias else 0)
        if self.nodes > self.max_nodes:
            message = f"the file has more than {self.max_nodes:,} values, including those of its aliases"
            raise self.fail("yaml-too-large", message, event, "split the file, or use a loop")
        if depth > MAX_DEPTH:
            raise self.fail("yaml-too-deep", f"nested deeper than {MAX_DEPTH} levels", event, "use fewer nested levels")
        if type(event) is ScalarEvent and event.tag is None and not event.anchor:  # fast path for the most common case
            return Text(event.value) if event.style else plain_scalar(event.value)
        if is_alias:
            if alias is not None:
                return alias[0]
            spans = {anchor: span for anchor, (_, _, span) in self.anchors.items()}
            help = Suggestion(event.anchor, spans, none="define it above, or put the text in quotes", places=spans)
            raise self.fail("yaml-alias", f'no anchor "&{event.anchor}" is defined before this alias', event, help)
        tag, is_scalar = event.tag, isinstance(event, yaml.ScalarEvent)
        if tag not in (None, "!", "tag:yaml.org,2002:str") and not (is_scalar and tag in _UNIT_TAGS):
            advice = "list the file under include" if "include" in tag else "write the value without the tag"
            raise self.fail("yaml-tag", f"the YAML tag {tag} is not supported here", event, advice)
        made: Any
        if is_scalar:
            made = plain_scalar(event.value) if not event.style and tag is None else Text(event.value)
            made = self.tagged(event) if tag in _UNIT_TAGS else made
        elif isinstance(event, yaml.MappingStartEvent):
            made = self.mapping(depth, span)
        else:
            made = Seq(span, self.via)
            while type(item := next(self.events)) is not SequenceEndEvent:
                made.put(self.value(item, depth + 1, at := self.span(item)), at)
        if event.anchor:
            self.anchors[event.anchor] = (made, self.nodes - before, span)
        return made

    def mapping(self, depth: int, span: Span) -> Map:
        made = Map(span, self.via)
        while type(key_event := next(self.events)) is not MappingEndEvent:
            if type(key_event) is not ScalarEvent:
                help = 'write an expression with quotes: "${...}"'
                raise self.fail("yaml-key", "a key must be plain text", key_event, help)
            key, key_span = str(key_event.value), self.span(key_event)
            if key == "<<" and not key_event.style:
                help = 'repeat the keys, or define the value in "let"'
                raise self.fail("yaml-merge", '"<<" is not part of YAML 1.2', key_event, help)
            if key in made:
                related = [Related("first defined here", made.key_spans[key])]
                message = f'the key "{key}" is defined twice in one mapping'
                raise LoadError(error("duplicate-key", message, key_span, "rename or remove one of them", related))
            value_span = self.span(value_event := next(self.events))
            made.put(key, self.value(value_event, depth + 1, value_span), key_span, value_span)
        return made

    def tagged(self, event: Any) -> float:
        """Convert a number with a unit tag of xacro, such as ``!degrees 90``, to SI units."""
        text, names = event.value.strip(), {name: getattr(math, name) for name in _FUNCTIONS}
        with suppress(Exception):
            if re.fullmatch(_CALCULATION, text):
                text = repr(float(eval(text, {"__builtins__": {}}, names)))  # noqa: S307 - only arithmetic can match
        if (quantity := Quantity.parse(f"{text} {_UNIT_TAGS[event.tag]}")) is None:
            help = "write a number after the tag, or remove the tag and write a unit"
            raise self.fail("yaml-tag", f'the tag {event.tag} needs a number, not "{event.value}"', event, help)
        return float(quantity)


def plain_scalar(text: str) -> Any:
    """Convert an unquoted scalar to None, bool, int, float, Quantity or str."""
    if text in _WORDS:
        return _WORDS[text]
    first = text[0]
    if first.isdigit() or first in "+-.":
        if _INT.match(text):
            return int(text) if len(text.lstrip("+-")) < 19 else float(text)
        if _FLOAT.match(text):
            return float(text)
        if text.startswith(("0x", "0o")) and re.match(_BASED, text):
            return int(text, 0)
        if (quantity := Quantity.parse(text)) is not None:
            return quantity
    return text


# Limit for JSON: on input that is nested 100,000 levels deep, parsers raise RecursionError or crash.
MAX_NESTING = 100
_JSON = re.compile(r'(?s)"[^"\\]*(?:\\.[^"\\]*)*"|[\[\]{}]')


def json_of(text: str | bytes, parse_constant: Callable[[str], Any] | None = None) -> Any:
    """Parse JSON, like ``json.loads``. Raises ValueError if it is invalid, or nested deeper than 100 levels."""
    if isinstance(text, bytes):
        text = text.decode(json.detect_encoding(text))
    depth = 0
    for match in _JSON.finditer(text) if text.count("[") + text.count("{") > MAX_NESTING else ():
        depth += (match[0] in "[{") - (match[0] in "]}")
        if depth > MAX_NESTING:
            raise json.JSONDecodeError(f"nested deeper than {MAX_NESTING} levels", text, match.start())
    return json.loads(text, parse_constant=parse_constant)


def python_of(text: str, expression: bool = False) -> "ast.Module | ast.Expression":
    """Parse Python statements, or an expression. Raises SyntaxError, or ValueError if the code is nested too deep."""
    import ast

    try:
        tree: ast.Module | ast.Expression = ast.parse(text, mode="eval") if expression else ast.parse(text)
    except (RecursionError, MemoryError):
        raise ValueError("nested too deep") from None
    nodes: list[ast.AST] = [tree]
    for _ in range(150):  # maximum depth of the syntax tree
        nodes = [child for node in nodes for child in ast.iter_child_nodes(node)]
    if nodes:
        raise ValueError("nested too deep")
    return tree


def yaml_of(text: str) -> Any:
    """Parse YAML that another program wrote. Raises ValueError if it is invalid or nested too deep."""
    try:
        return parse_yaml(Source("", text))
    except LoadError as problem:
        raise ValueError(str(problem)) from None

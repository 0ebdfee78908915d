"""Load: the only stage that knows YAML. Text in, a plain tree with spans out.

Scalars have the meaning of the YAML 1.2 core schema (https://yaml.org/spec/1.2.2/#103-core-schema), not that of 1.1:
``1e-3`` is a number, ``on`` and ``12:30`` are text. One form is added: a plain scalar that is a number and a known
unit, such as ``12.5 mm``, is a quantity. Quotes make text of anything.
"""

from __future__ import annotations

import ast
import math
import operator
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from yaml import MappingEndEvent, ScalarEvent, SequenceEndEvent

from . import files
from .diagnostics import Diagnostic, Related, Source, Span, error, nearest
from .project import stdin_of
from .rule_registry import FILES, Rule
from .tree import Instance, Map, Seq, Text
from .units import Quantity
from .wording import in_words

RULES = (
    Rule("file-unreadable", "A file does not exist or may not be read.", "Check the name and the permissions.", FILES),
    Rule(
        "file-too-large",
        "A file is larger than any description.",
        "Descriptions are text written by people; name the right file.",
        FILES,
    ),
    Rule("not-utf8", "A file is not UTF-8 text.", "Save it as UTF-8.", FILES),
    Rule("not-a-mapping", "A file is empty, or its top is a list or a text.", "Begin with `robot: NAME`.", FILES),
    Rule("yaml-syntax", "This is not YAML.", "Indent with spaces; put text that has a `:` in quotes.", FILES),
    Rule("yaml-documents", "A file has a second document.", "Remove the `---`.", FILES),
    Rule("yaml-key", "A key is a list or a mapping.", "Keys are plain text.", FILES),
    Rule("yaml-merge", "`<<` is not part of YAML 1.2.", "Repeat the keys, or name a value in `let`.", FILES),
    Rule(
        "yaml-tag",
        "A tag such as `!!int` has no meaning here; a tag of a unit (`!degrees`) does not stand before a number.",
        "Write the value without it.",
        FILES,
    ),
    Rule(
        "yaml-alias",
        "An alias has no anchor before it.",
        "Define the anchor above, or name a value in `let`.",
        FILES,
    ),
    Rule("yaml-too-deep", "Values are nested deeper than any description.", "Flatten the file.", FILES),
    Rule(
        "yaml-too-large",
        "A file has too many values, or its aliases multiply to too many.",
        "Use fewer aliases; make entries that are alike with a loop.",
        FILES,
    ),
    Rule(
        "yaml-directive",
        "A directive such as `%YAML 1.1` has no effect: files are read as YAML 1.2, where `010` is 10.",
        "Remove the line.",
        FILES,
    ),
    Rule(
        "yaml-line-end",
        "U+2028, U+2029 or U+0085 is outside of quotes. It ends a line for YAML, but not for most editors.",
        "Remove it, or write an escape in double quotes.",
        FILES,
    ),
    Rule(
        "bidi-control",
        "A control character changes the order in which editors show the letters of a line.",
        'Remove it, or write an escape in double quotes, such as `"\\u202e"`.',
        FILES,
    ),
    Rule(
        "duplicate-key",
        "A key stands twice in one mapping, also after a loop has made it; or in two files where it may stand once.",
        "Remove one; put the value of the loop into the name.",
        FILES,
    ),
)

_new = tuple.__new__
MAX_BYTES = 20_000_000
MAX_DEPTH = 60
MAX_NODES = 1_000_000

_INT = re.compile(r"[-+]?[0-9]+\Z")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?\Z")
_BASED = re.compile(r"0x[0-9a-fA-F]{1,15}\Z|0o[0-7]{1,20}\Z")
_WORDS: dict[str, Any] = {"": None, "~": None, "null": None, "Null": None, "NULL": None}
_WORDS |= dict.fromkeys(("true", "True", "TRUE"), True)
_WORDS |= dict.fromkeys(("false", "False", "FALSE"), False)
_WORDS |= {sign + word: float(sign + "inf") for sign in ("", "+", "-") for word in (".inf", ".Inf", ".INF")}
_WORDS |= {word: float("nan") for word in (".nan", ".NaN", ".NAN")}


# The unit tags of xacro's YAML, which published tables of robots use (https://github.com/ros/xacro/wiki).
_UNIT_TAGS = {
    "!degrees": "deg",
    "!radians": "rad",
    "!meters": "m",
    "!millimeters": "mm",
    "!foot": "ft",
    "!inches": "inch",
}


class LoadError(Exception):
    """A file that is not legal YAML, or not fit to be a description; carries the diagnostic."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic

    @classmethod
    def explained(cls, source: Source, problem: yaml.YAMLError) -> LoadError:
        """Return what is wrong with a text that a parser of YAML refuses, in the words of people."""
        from .yaml_mistakes import explained

        return cls(explained(source, problem))


def unreadable(problem: OSError) -> Diagnostic:
    """Return the error about a file or folder that cannot be looked at."""
    message = f"cannot read {files.shown(os.fsdecode(problem.filename))}: {problem.strerror}"
    return error("file-unreadable", message, None, "check the permissions")


def read_utf8(path: Path, shown: str, asked: Span | None = None) -> Source:
    """Read a UTF-8 file; ``asked`` is the place that names it.

    Raises LoadError when it cannot be read, is too large or is not UTF-8 text.
    """
    help = "descriptions are UTF-8 text files; check the name and the permissions"
    data = stdin_of(path)
    try:
        if data is None and files.is_special(path):  # a pipe or a device would be waited for
            raise LoadError(error("file-unreadable", f"{shown} is not a regular file", asked, help))
        if (path.stat().st_size if data is None and files.is_file(path) else len(data or b"")) > MAX_BYTES:
            raise LoadError(error("file-too-large", f"{shown} is larger than {MAX_BYTES:,} bytes", asked, help))
        data = files.read_bytes(path) if data is None else data
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        raise LoadError(error("file-unreadable", f"cannot read {shown}: {reason}", asked, help)) from None
    try:
        text = data.decode().removeprefix("\ufeff")
    except UnicodeDecodeError as problem:
        before = data[: problem.start].decode("utf-8", "replace")
        source = Source(shown, data.decode("utf-8", "replace"))
        span = Span(source, before.count("\n") + 1, len(before) - before.rfind("\n"))
        message = f"{shown} is not UTF-8 text: byte {data[problem.start]:#04x} at offset {problem.start}"
        raise LoadError(error("not-utf8", message, span, "save the file as UTF-8")) from None
    return Source(shown, text)


def parse_yaml(source: Source, via: Instance | None = None) -> Any:
    """Return the tree of a YAML source: Map, Seq or scalar. Raises LoadError with the place of what is wrong."""
    _check_text(source)
    try:
        return _Composer(source, via).document()
    except yaml.YAMLError as problem:
        raise _refused(source, problem) from None


_BIDI = re.compile("[\u202a-\u202e\u2066-\u2069]")
_LINE_ENDS = re.compile("[\x85\u2028\u2029]")
_DIRECTIVE = re.compile(r"(?:\s|#.*\n)*(%(?!YAML\s+1\.2\s)\S+.*)\n(?:.*\n)*?---")


def _check_text(source: Source) -> None:
    """Refuse text that a reviewer reads differently than the parser. Raises LoadError."""
    text = source.text
    if directive := _DIRECTIVE.match(text) if "%" in text[:1_000] else None:
        message = f"{directive[1].split('#')[0].strip()} has no effect: files are read as YAML 1.2"
        raise LoadError(error("yaml-directive", message, _span_at(source, directive.start(1)), "remove the line"))
    if text.isascii():
        return
    if found := _BIDI.search(text):
        help = f'remove it, or write the text in double quotes with "\\u{ord(found[0]):04x}"'
        message = f"{in_words(found[0])} changes the order in which editors show this line"
        raise LoadError(error("bidi-control", message, _span_at(source, found.start()), help))
    quoted: list[tuple[int, int]] = []
    for found in _LINE_ENDS.finditer(text):
        quoted = quoted or list(_quoted_texts(text)) or [(0, 0)]
        if not any(start <= found.start() < end for start, end in quoted):
            message = f"{in_words(found[0]).removesuffix(', a control character')} ends this line for YAML"
            help = "remove it: most editors show it within the line"
            raise LoadError(error("yaml-line-end", message, _span_at(source, found.start()), help))


def _quoted_texts(text: str) -> Iterator[tuple[int, int]]:
    scanner = getattr(yaml, "CLoader", yaml.Loader)(text)
    try:
        while (token := scanner.get_token()) is not None:
            if isinstance(token, yaml.ScalarToken) and token.style in ("'", '"'):
                yield token.start_mark.index, token.end_mark.index
    except yaml.YAMLError:  # the parser reports it
        return


def _span_at(source: Source, offset: int) -> Span:
    """Return the place of a character, with lines and columns as YAML counts them."""
    lines = re.split("\r\n|[\n\r\x85\u2028\u2029]", source.text[:offset])
    return Span(source, len(lines), len(lines[-1]) + 1)


def _refused(source: Source, problem: yaml.YAMLError) -> LoadError:
    from .bounded import is_too_deep

    mark = getattr(problem, "problem_mark", None)
    if is_too_deep(problem) and mark is not None:  # libyaml looks ahead: what stands before has the level too much
        try:
            _Composer(Source(source.path, source.text[: mark.index]), None).document()
        except LoadError as told:
            span = told.diagnostic.span
            return LoadError(replace(told.diagnostic, span=span and span._replace(source=source)))
        except yaml.YAMLError:
            pass
    return LoadError.explained(source, problem)


class Entry(NamedTuple):
    """One entry of a list (``key`` is None) or of a mapping."""

    key: str | None
    value: Any
    key_span: Span
    span: Span


def each_entry(source: Source) -> Iterator[Entry]:
    """Yield the entries of a YAML list or mapping one by one; none is held. Raises LoadError.

    A mapping may have a key twice: who asks looks after that.
    """
    try:
        yield from _Composer(source, None).entries()
    except yaml.YAMLError as problem:
        raise _refused(source, problem) from None


def load_mapping(path: Path, shown: str, asked: Span | None = None, via: Instance | None = None) -> Map:
    """Read a YAML file whose top is a mapping. Raises LoadError."""
    source = read_utf8(path, shown, asked)
    tree = parse_yaml(source, via)
    if isinstance(tree, Map):
        return tree
    if source.text.lstrip().startswith("<"):
        kind, help = _markup(source.text)
        raise LoadError(error("not-a-mapping", f"{source.path} is {kind}, not a description", source.start(), help))
    kind = "empty" if tree is None else "not a mapping"
    kind = "a list" if isinstance(tree, Seq) else kind
    message = f'{source.path} is {kind}; a description is a mapping such as "robot: my_robot"'
    empty = tree is None and stdin_of(path) is not None
    help = "did the program before the pipe say why?" if empty else "start from docs/tutorial.md"
    raise LoadError(error("not-a-mapping", message, source.start(), help))


@cache
def load_own(path: Path, shown: str) -> Map:
    """Read a file that ships with the tool, once a process; nobody may change the tree. Raises LoadError."""
    return load_mapping(path, shown)


def _markup(text: str) -> tuple[str, str]:
    """Return what an XML file is, and the way out for one that stands in the place of a description."""
    if "<sdf" in text[:2_000]:
        return "SDF", "convert it to URDF first, then `rosorin-compile import` makes a description of it"
    kind = "MJCF" if "<mujoco" in text[:2_000] else "xacro" if "xmlns:xacro" in text[:2_000] else "a URDF"
    kind = kind if "<robot" in text[:2_000] or kind == "MJCF" else "XML"
    return kind, "`rosorin-compile import` makes a description of it; `include` takes it as it is"


class _Composer:
    """Builds the tree from parser events, with its own stack, so that no nesting can exhaust the interpreter."""

    def __init__(self, source: Source, via: Instance | None) -> None:
        self.source = source
        self.via = via
        self.anchors: dict[str, tuple[Any, int, Span]] = {}
        self.nodes = 0
        # libyaml counts columns in code points of the text that it was given; NUL and the like raise ReaderError.
        loader = getattr(yaml, "CLoader", yaml.Loader)
        self.parser = loader(source.text)

    def document(self) -> Any:
        """Return the value of the one document of the source; None if it is empty."""
        events = iter(self.parser.get_event, None)
        tree: Any = None
        seen = 0
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                seen += 1
                if seen > 1:
                    raise self.fail("yaml-documents", "a description is one YAML document", event, 'remove the "---"')
            elif isinstance(event, (yaml.NodeEvent, yaml.AliasEvent)):
                tree = self.value(event, events, 0)
        return tree

    def entries(self) -> Iterator[Entry]:
        """Yield what the top of the document holds, each with as many values as a document may have."""
        events = iter(self.parser.get_event, None)
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent) and self.nodes:
                raise self.fail("yaml-documents", "this is one YAML document", event, 'remove the "---"')
            if isinstance(event, yaml.ScalarEvent) and event.value:
                raise self.fail("not-a-mapping", f"{self.source.path} is a text", event, "write a list or a mapping")
            if not isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
                continue
            named = isinstance(event, yaml.MappingStartEvent)
            for first in events:
                if isinstance(first, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
                    break
                key = self.key(first) if named else None
                event = next(events) if named else first
                self.nodes = 1
                yield Entry(key, self.value(event, events, 1), self.span(first), self.span(event))

    def span(self, event: Any) -> Span:
        start, end = event.start_mark, event.end_mark
        line, column = start.line, start.column
        length = end.column - column if end.line == line else 1
        # As Span(...) does, without a call of Python: of every key and value there is one.
        return _new(Span, (self.source, line + 1, column + 1, length if length > 1 else 1))

    def fail(self, rule: str, message: str, event: Any, help: str) -> LoadError:
        return LoadError(error(rule, message, self.span(event), help))

    def value(self, event: Any, events: Iterator[Any], depth: int) -> Any:
        """Return the value that begins with ``event``; reads on in ``events`` to its end."""
        self.nodes += 1
        if self.nodes > MAX_NODES:
            raise self.fail("yaml-too-large", f"more than {MAX_NODES:,} values", event, "split the file, or use a loop")
        if depth > MAX_DEPTH:
            raise self.fail("yaml-too-deep", f"nested deeper than {MAX_DEPTH} levels", event, "flatten the file")
        if type(event) is ScalarEvent and event.tag is None and not event.anchor:  # as nearly all are
            return Text(event.value) if event.style else plain_scalar(event.value)
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event)
        self.check_tag(event)
        before = self.nodes
        if isinstance(event, yaml.ScalarEvent):
            made = self.scalar(event)
        elif isinstance(event, yaml.MappingStartEvent):
            made = self.mapping(event, events, depth)
        else:
            made = self.sequence(event, events, depth)
        if event.anchor:
            self.anchors[event.anchor] = (made, self.nodes - before + 1, self.span(event))
        return made

    def check_tag(self, event: Any) -> None:
        """Refuse tags: they would choose the type of a value, which the schema does here."""
        if isinstance(event, yaml.ScalarEvent) and event.tag in _UNIT_TAGS:
            return
        if event.tag not in (None, "!", "tag:yaml.org,2002:str"):
            help = "list the file under include" if "include" in event.tag else "write the value without it"
            raise self.fail("yaml-tag", f"the tag {event.tag} has no meaning here", event, help)

    def alias(self, event: Any) -> Any:
        if event.anchor not in self.anchors:
            help = "define it above, name a value in let, or put the text in quotes"
            meant = nearest(event.anchor, self.anchors)
            near = [Related("the suggestion is defined here", self.anchors[meant][2])] if meant else []
            help = f'did you mean "*{meant}"? else {help}' if meant else help
            message = f'no anchor "&{event.anchor}" stands before this alias'
            raise LoadError(error("yaml-alias", message, self.span(event), help, near))
        value, size, _ = self.anchors[event.anchor]
        self.nodes += size
        if self.nodes > MAX_NODES:
            raise self.fail("yaml-too-large", f"aliases multiply to more than {MAX_NODES:,} values", event, "")
        return value

    def mapping(self, event: Any, events: Iterator[Any], depth: int) -> Map:
        made = Map(self.span(event), self.via)
        key_spans, value_spans = made.key_spans, made.value_spans
        for key_event in events:
            if type(key_event) is MappingEndEvent:
                return made
            key = self.key(key_event)
            key_span = self.span(key_event)
            if key in made:
                related = [Related("first defined here", key_spans[key])]
                message = f'the key "{key}" stands twice in one mapping'
                raise LoadError(error("duplicate-key", message, key_span, "rename or remove one", related))
            value_event = next(events)
            made[key] = self.value(value_event, events, depth + 1)
            key_spans[key] = key_span
            value_spans[key] = self.span(value_event)
        return made

    def key(self, event: Any) -> str:
        if type(event) is not ScalarEvent:
            raise self.fail("yaml-key", "a key must be plain text", event, "an expression is written ${...}, in quotes")
        if event.value == "<<" and not event.style:
            way_out = "repeat the keys, or name a value in let"
            raise self.fail("yaml-merge", '"<<" is not part of YAML 1.2', event, way_out)
        return str(event.value)

    def sequence(self, event: Any, events: Iterator[Any], depth: int) -> Seq:
        made = Seq(self.span(event), self.via)
        value_spans = made.value_spans
        for item in events:
            if type(item) is SequenceEndEvent:
                break
            made.append(self.value(item, events, depth + 1))
            value_spans.append(self.span(item))
        return made

    def scalar(self, event: Any) -> Any:
        if event.tag in _UNIT_TAGS:
            return self.tagged(event)
        if event.style or event.tag is not None:
            return Text(event.value)
        return plain_scalar(event.value)

    def tagged(self, event: Any) -> Any:
        """Return the number in SI of a scalar with one of xacro's tags: a factor, and no more.

        It has no dimension: tables that people publish say ``max_velocity: !degrees 180``.
        """
        unit = _UNIT_TAGS[event.tag]
        quantity = Quantity.parse(f"{event.value.strip()} {unit}") or Quantity.parse(f"{_result(event.value)} {unit}")
        if quantity is None:
            help = "write a number, or a quantity or an expression without the tag"
            raise self.fail("yaml-tag", f'{event.tag} stands before a number, not "{event.value}"', event, help)
        return float(quantity)


def _result(text: str) -> str:
    """Return the number that a calculation gives, such as ``pi / 2``, as xacro has it behind a tag; empty if none."""
    try:
        return repr(_calculated(ast.parse(text.strip(), mode="eval").body))
    except (SyntaxError, ValueError, TypeError, ArithmeticError, RecursionError, MemoryError):
        return ""


_OPERATIONS: Mapping[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
}


def _calculated(node: ast.expr) -> float:
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name) and node.id in ("pi", "e", "tau"):
        return float(getattr(math, node.id))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        value = _calculated(node.operand)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        return _OPERATIONS[type(node.op)](_calculated(node.left), _calculated(node.right))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
        return float(getattr(math, node.func.id)(*map(_calculated, node.args)))
    raise ValueError("not a calculation of numbers")


_FUNCTIONS = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "radians", "degrees")


def plain_scalar(text: str) -> Any:
    """Return the value of a scalar without quotes: None, bool, int, float, Quantity or str.

    >>> plain_scalar("1e-3"), plain_scalar("on"), plain_scalar("12.5 mm")
    (0.001, 'on', 0.0125)
    """
    if text in _WORDS:
        return _WORDS[text]
    first = text[0]
    if first.isdigit() or first in "+-.":
        if _INT.match(text):
            return int(text) if len(text) < 19 else float(text)
        if _FLOAT.match(text):
            return float(text)
        if text.startswith(("0x", "0o")) and _BASED.match(text):
            return int(text, 0)
        quantity = Quantity.parse(text)
        if quantity is not None:
            return quantity
    return text

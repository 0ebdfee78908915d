"""A parameter file of ROS 2, read as its nodes read it, with the place of every key and value.

The words are those of ``ros2/rcl:rcl_yaml_param_parser``, which are not those of YAML 1.2: yes and on are true, 010 is
eight, a list has values of one type, there are no aliases, and a key without a value is an error. Whatever a node
would refuse to start with is an error here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from ...diagnostics import Diagnostic, Related, Source, Span, error
from ...diagnostics.registry import PARAMETERS, Rule
from ...startup.records import NamedTuple, dataclass, field

RULES = (
    Rule(
        "parameters-syntax",
        "A parameter file is none, or one that ROS 2 refuses: no node starts with it.",
        "As the message says.",
        PARAMETERS,
    ),
    Rule(
        "parameters-twice",
        "A warning: a parameter stands twice for one node; the last one counts.",
        "Remove one.",
        PARAMETERS,
    ),
)

PARAMETERS_KEY = "ros__parameters"
MAX_DEPTH = 40
_HELP = "a parameter file is NODE: {ros__parameters: {KEY: VALUE}}"
_TRUE = {"y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
_FALSE = {"n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}
# What strtol and strtod take, and the words of YAML for what is not finite.
_INT = re.compile(r"[-+]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)\Z")
_DOUBLE = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?\Z")
_SPECIAL = re.compile(r"[-+]?(\.(inf|Inf|INF)|(?i:inf|infinity|nan))\Z|\.(nan|NaN|NAN)\Z")
_LONGEST = 300  # digits of a number: more are beyond a double, too
_MOST = 2**63 - 1


class Parameter(NamedTuple):
    """A value of a parameter file (bool, int, float, str, or a list of one of them), and its places."""

    value: Any
    key: Span
    span: Span

    @property
    def substituted(self) -> bool:
        """Whether a launch file puts something else here: ``$(find-pkg-share ...)``, and nobody knows its type."""
        values = self.value if isinstance(self.value, list) else [self.value]
        return any(isinstance(one, str) and "$(" in one for one in values)


@dataclass(frozen=True)
class Section:
    """What a file says for the nodes that a name matches: ``name`` begins with / and may have the wildcards * and **.

    ``parameters`` are by full name, with dots between the levels.
    """

    name: str
    span: Span
    parameters: dict[str, Parameter] = field(default_factory=dict)

    @property
    def of_any(self) -> bool:
        """Whether it names no node: its last word is a wildcard."""
        return self.name.rsplit("/", 1)[-1] in ("*", "**")

    def matches(self, node: str) -> bool:
        """Say whether it is for a node of a full name."""
        words = self.name.strip("/").split("/")
        pattern = "".join({"**": "(/[^/]+)*", "*": "/[^/]+"}.get(word, "/" + re.escape(word)) for word in words)
        return re.fullmatch(pattern, node) is not None


class NoParameters(Exception):
    """A file that is none of parameters; carries the diagnostic."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


def read(source: Source) -> tuple[list[Section], list[Diagnostic]]:
    """Return the sections of a parameter file in its order, and warnings. Raises NoParameters."""
    reader = _Reader(source)
    try:
        reader.document()
    except yaml.YAMLError as problem:
        from ...frontend.yaml_mistakes import explained

        told = explained(source, problem)
        raise NoParameters(told._replace(rule="parameters-syntax")) from None
    return list(reader.sections.values()), reader.told


def read_file(path: Path) -> tuple[list[Section], list[Diagnostic]]:
    """Read a parameter file. Raises NoParameters."""
    from ...frontend.load import LoadError, read_text

    try:
        source = read_text(path, str(path))
    except LoadError as problem:
        help = problem.diagnostic.help.replace("descriptions are", "parameter files are")
        raise NoParameters(problem.diagnostic._replace(help=help)) from None
    return read(source)


class _Reader:
    """Reads the events of a YAML parser; nothing that it holds is deeper than ``MAX_DEPTH``."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.sections: dict[str, Section] = {}
        self.told: list[Diagnostic] = []
        loader = getattr(yaml, "CLoader", yaml.Loader)
        self.events: Iterator[Any] = iter(loader(source.text).get_event, None)

    def document(self) -> None:
        """Read the one document of the file."""
        for event in self.events:
            if isinstance(event, yaml.MappingStartEvent):
                self.names("", event, None, 0)
            elif isinstance(event, (yaml.NodeEvent, yaml.AliasEvent)):
                raise self.fail("this is no parameter file: its top is no mapping", event)
        if not self.sections:
            from ...frontend.tree import first_line

            message = f"no node has parameters here: there is no {PARAMETERS_KEY}"
            raise NoParameters(error("parameters-syntax", message, first_line(self.source), _HELP))

    def names(self, above: str, start: Any, named: Span | None, depth: int) -> None:
        """Read a mapping of namespaces and nodes; ``named`` is the place of the last name."""
        if depth > MAX_DEPTH:
            raise self.fail(f"nested deeper than {MAX_DEPTH} levels", start, "flatten the file")
        for key in self.events:
            if isinstance(key, yaml.MappingEndEvent):
                return
            name = self.text(key)
            value = next(self.events)
            if name == PARAMETERS_KEY and not isinstance(value, yaml.MappingStartEvent):
                raise self.fail(f"{PARAMETERS_KEY} is a mapping of keys to values", value)
            if not isinstance(value, yaml.MappingStartEvent):
                what = f'"{name}" has a value, and no {PARAMETERS_KEY} stands above it'
                raise self.fail(what, key)
            if name == PARAMETERS_KEY:
                if named is None:
                    raise self.fail(f"{PARAMETERS_KEY} stands at the top: no node is named", key)
                self.parameters(self.sections.setdefault(above, Section(above, named)), "", depth + 1)
            else:
                self.names(f"{above}/{name.strip('/')}", value, self.span(key), depth + 1)

    def parameters(self, section: Section, above: str, depth: int) -> None:
        """Read a mapping of parameters, in levels."""
        for key in self.events:
            if isinstance(key, yaml.MappingEndEvent):
                return
            name = f"{above}{self.text(key)}"
            value = next(self.events)
            if depth > MAX_DEPTH:
                raise self.fail(f"nested deeper than {MAX_DEPTH} levels", key, "flatten the file")
            if isinstance(value, yaml.MappingStartEvent):
                self.parameters(section, f"{name}.", depth + 1)
                continue
            made = self.value(name, key, value)
            before = section.parameters.get(name)
            if before is not None:
                message = f'"{name}" stands twice for {section.name}; the last one counts'
                related = (Related("first set here", before.key),)
                self.told.append(Diagnostic("parameters-twice", "warning", message, made.key, related, "remove one"))
            section.parameters[name] = made

    def value(self, name: str, key: Any, event: Any) -> Parameter:
        """Return a value, or a list of values."""
        if isinstance(event, yaml.SequenceStartEvent):
            return self.array(name, key, event)
        return Parameter(self.scalar(event)[0], self.span(key), self.span(event))

    def array(self, name: str, key: Any, start: Any) -> Parameter:
        """Return a list; its values have one type, or no node starts."""
        values: list[Any] = []
        first = ""
        for event in self.events:
            if isinstance(event, yaml.SequenceEndEvent):
                break
            if not isinstance(event, (yaml.ScalarEvent, yaml.AliasEvent)):
                what = "a list" if isinstance(event, yaml.SequenceStartEvent) else "a mapping"
                raise self.fail(
                    f'"{name}" holds {what} in a list, which ROS 2 refuses',
                    event,
                    'write one text in quotes: "[[x, y], ...]"',
                )
            value, kind = self.scalar(event)
            if isinstance(value, str) and "$(" in value:  # a launch file puts something else here
                kind = first
            if first and kind != first:
                message = f'"{name}" mixes {first} and {kind}: ROS 2 refuses the whole file, and no node starts'
                way = "write every number with a point: 0.0"
                raise self.fail(message, event, way if {first, kind} == {"int", "double"} else "use one type")
            first = kind
            values.append(value)
        return Parameter(values, self.span(key), self.span(start))

    def scalar(self, event: Any) -> tuple[Any, str]:
        """Return a value and its type."""
        if isinstance(event, yaml.AliasEvent):
            raise self.fail("ROS 2 takes no aliases in a parameter file", event, "write the value here")
        text = event.value
        if event.style in ("'", '"'):
            return text, "string"
        if not text:
            raise self.fail("this key has no value: ROS 2 refuses the whole file", event, 'write "" for an empty text')
        if text in _TRUE or text in _FALSE:
            return text in _TRUE, "bool"
        if _INT.match(text):
            digits = text.lstrip("+-")
            base = 16 if digits[1:2] in ("x", "X") else 8 if digits.startswith("0") else 10
            if len(digits) > _LONGEST:  # rcl takes a number that is no double for text
                return text, "string"
            number = int(digits, base) * (-1 if text.startswith("-") else 1)
            return (number, "int") if abs(number) <= _MOST else (float(number), "double")
        if _DOUBLE.match(text):
            return float(text), "double"
        if _SPECIAL.match(text):
            return float(text.replace(".", "")), "double"
        return text, "string"

    def text(self, event: Any) -> str:
        """Return a key."""
        if not isinstance(event, yaml.ScalarEvent):
            raise self.fail("a key is plain text", event)
        return str(event.value)

    def span(self, event: Any) -> Span:
        start, end = event.start_mark, event.end_mark
        length = end.column - start.column if end.line == start.line else 1
        return Span(self.source, start.line + 1, start.column + 1, max(1, length))

    def fail(self, message: str, event: Any, help: str = _HELP) -> NoParameters:
        return NoParameters(error("parameters-syntax", message, self.span(event), help))

"""A parameter file of ROS 2, read as its nodes read it, with the place of every key and value.

The words are those of ``ros2/rcl:rcl_yaml_param_parser``, which are not those of YAML 1.2: yes and on are true, 010 is
eight, a list has values of one type, there are no aliases, and a key without a value is an error. Whatever a node
would refuse to start with is an error here.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from rosorin_compile.source.diagnostics import Diagnostic, Related, Source, Span, error
from rosorin_compile.source.rule_registry import Heading, declare

RULES = declare(
    Heading.PARAMETERS,
    {
        "parameters-syntax": "A parameter file is none, or one that ROS 2 refuses: no node starts with it. A warning "
        "where ROS 2 reads it otherwise than it looks. Fix: As the message says.",
        "parameters-twice": "A warning: a parameter is repeated for one node; the last one counts. Fix: Remove one.",
    },
)

PARAMETERS_KEY = "ros__parameters"
MAX_DEPTH = 40
_HELP = "a parameter file is NODE: {ros__parameters: {KEY: VALUE}}"
_TRUE = {"y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
_FALSE = {"n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}
# What strtol and strtod take, and the words of YAML for what is not finite.
_INT = re.compile(r"[-+]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)\Z")
_DOUBLE = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?\Z")
_ZERO = re.compile(r"[-+]?[0.]+([eE].*)?\Z")
_SPECIAL = re.compile(r"[-+]?(\.(inf|Inf|INF)|(?i:inf|infinity|nan))\Z|\.(nan|NaN|NAN)\Z")
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*|\*\*?")
# Where something else stands when the file is used: of a launch file, or of those that replace words (nav2_common).
_PUT_IN = re.compile(r"\$\(|<[A-Za-z_]\w*>")
_LONGEST = 300  # digits of a number: more are beyond a double, too
_MOST = 2**63 - 1
_TEXT = "tag:yaml.org,2002:str"


class Parameter(NamedTuple):
    """A value of a parameter file (bool, int, float, str, or a list of one of them), and its places."""

    value: Any
    key: Span
    span: Span

    @property
    def substituted(self) -> bool:
        """Whether something else is put here, ``$(find-pkg-share ...)`` or ``<prefix>``: nobody knows its type."""
        values = self.value if isinstance(self.value, list) else [self.value]
        return any(isinstance(one, str) and _PUT_IN.search(one) for one in values)


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
        from rosorin_compile.source.yaml_mistakes import explained

        raise NoParameters(replace(explained(source, problem), rule="parameters-syntax")) from None
    return list(reader.sections.values()), reader.told


def read_file(path: Path) -> tuple[list[Section], list[Diagnostic]]:
    """Read a parameter file. Raises NoParameters."""
    from rosorin_compile.source.load import LoadError, read_utf8

    try:
        source = read_utf8(path, str(path))
    except LoadError as problem:
        help = problem.diagnostic.help.replace("descriptions are", "parameter files are")
        raise NoParameters(replace(problem.diagnostic, help=help)) from None
    return read(source)


class _Reader:
    """Reads the events of a YAML parser; nothing that it holds is deeper than ``MAX_DEPTH``."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.sections: dict[str, Section] = {}
        self.told: list[Diagnostic] = []
        self.count = 0  # of parameters
        self.hollow = ""  # the last mapping, if it was empty
        loader = getattr(yaml, "CLoader", yaml.Loader)
        self.events: Iterator[Any] = iter(loader(source.text).get_event, None)

    def document(self) -> None:
        """Read the one document of the file."""
        empty = True  # as a file is that has comments alone: no node has parameters, and nothing is wrong
        for event in self.events:
            if isinstance(event, yaml.MappingStartEvent):
                empty = False
                self.names("", event, None, 0)
            elif isinstance(event, (yaml.NodeEvent, yaml.AliasEvent)):
                raise self.fail("this is no parameter file: its top is no mapping", event)
        if not self.sections and not empty:
            message = f"no node has parameters here: there is no {PARAMETERS_KEY}"
            self.told.append(Diagnostic("parameters-syntax", "warning", message, self.source.span(), help=_HELP))

    def names(self, above: str, start: Any, named: Span | None, depth: int) -> None:
        """Read a mapping of namespaces and nodes; ``named`` is the place of the last name."""
        if depth > MAX_DEPTH:
            raise self.fail(f"nested deeper than {MAX_DEPTH} levels", start, "flatten the file")
        of_node = False
        for key in self.events:
            if isinstance(key, yaml.MappingEndEvent):
                return
            name = self.text(key)
            if not name:
                raise self.fail("a node has no name: ROS 2 refuses the whole file", key, "name it")
            value = next(self.events)
            if name == PARAMETERS_KEY and not isinstance(value, yaml.MappingStartEvent):
                raise self.fail(f"{PARAMETERS_KEY} is a mapping of keys to values", value)
            if not isinstance(value, yaml.MappingStartEvent):
                what = f'"{name}" has a value, and no {PARAMETERS_KEY} stands above it'
                raise self.fail(what, key)
            if name == PARAMETERS_KEY:
                if named is None:
                    raise self.fail(f"{PARAMETERS_KEY} stands at the top: no node is named", key)
                if of_node:
                    what = f"{PARAMETERS_KEY} is repeated for one node, which ROS 2 refuses"
                    raise self.fail(what, key, "make it one")
                self.named(above, named)
                self.parameters(self.sections.setdefault(above, Section(above, named)), "", depth + 1)
                self.hollow, of_node = "", True
                continue
            before = self.count
            between = "" if above.endswith("/") or (name.startswith("/") and not above) else "/"
            self.names(f"{above}{between}{name}", value, self.span(key), depth + 1)
            if of_node and self.count > before:
                what = f'"{name}" stands behind the {PARAMETERS_KEY} of "{above.strip("/")}", which ROS 2 refuses'
                raise self.fail(what, key, f"write it as a node of its own: {above.strip('/')}/{name}")

    def named(self, full: str, named: Span) -> None:
        """Hold the name of a node against those that there may be (rmw_validate_node_name)."""
        words = full.removeprefix("/").split("/")
        wrong = [word for word in words if not _WORD.fullmatch(word) and not _PUT_IN.search(word)]
        if wrong:
            what = f'"{wrong[0] or full}" is no name of a node or a namespace: ROS 2 refuses the whole file'
            help = "letters, digits and _ alone, a digit not first"
            help = help if wrong[0] else "a / stands between two names, and at most once before all of them"
            raise NoParameters(error("parameters-syntax", what, named, help))

    def parameters(self, section: Section, above: str, depth: int, first: bool = True) -> None:
        """Read a mapping of parameters, in levels; ``first`` says that nothing of it was read before."""
        for key in self.events:
            if isinstance(key, yaml.MappingEndEvent):
                self.hollow = above if first else self.hollow
                return
            first = False
            name = f"{above}{self.parameter(key, above)}"
            value = next(self.events)
            if depth > MAX_DEPTH:
                raise self.fail(f"nested deeper than {MAX_DEPTH} levels", key, "flatten the file")
            if isinstance(value, yaml.MappingStartEvent):
                self.parameters(section, f"{name}.", depth + 1)
                continue
            if isinstance(value, yaml.SequenceStartEvent):
                self.array(section, name, key, value, depth)
            else:
                self.put(section, name, Parameter(self.scalar(value)[0], self.span(key), self.span(value)))

    def parameter(self, key: Any, above: str) -> str:
        """Return a key of parameters; behind an empty mapping ROS 2 loses count of its levels."""
        text = self.text(key)
        if not text:
            raise self.fail("a parameter has no name: ROS 2 refuses the whole file", key, "name it")
        if self.hollow:
            what, way_out = f'"{text}" stands behind "{self.hollow[:-1]}", which is empty', "leave the empty one out"
            if not above:
                raise self.fail(f"{what}: ROS 2 refuses the whole file", key, way_out)
            self.told.append(self.otherwise(what, key, way_out))
            self.hollow = ""
        return text

    def put(self, section: Section, name: str, made: Parameter) -> None:
        """Add a parameter to those of a section."""
        self.count += 1
        before = section.parameters.get(name)
        if before is not None:
            message = f'"{name}" is repeated for {section.name}; the last one counts'
            related = (Related("first set here", before.key),)
            self.told.append(Diagnostic("parameters-twice", "warning", message, made.key, related, "remove one"))
        if made.value == []:
            message = f'"{name}" is an empty list, and ROS 2 does not know of what: nodes in C++ do not start '
            message += '("No parameter value set")'
            help = "leave it out, if the node has a list by default"
            self.told.append(Diagnostic("parameters-syntax", "warning", message, made.span, help=help))
        section.parameters[name] = made

    def array(self, section: Section, name: str, key: Any, start: Any, depth: int) -> None:
        """Add a list; its values have one type, or no node starts.

        A mapping in it is one of parameters below its name, ``a: [{b: [1]}]`` is ``a.b``, as gpio_controllers has it.
        """
        values = self.values(name, next(self.events), yaml.SequenceEndEvent)
        last = values.pop() if values and isinstance(values[-1], yaml.MappingStartEvent) else None
        if last is None:
            self.put(section, name, Parameter(values, self.span(key), self.span(start)))
            return
        self.in_list(section, name, depth + 1)
        rest = next(self.events)
        if not isinstance(rest, yaml.SequenceEndEvent):
            self.told.append(self.otherwise(f'"{name}" has more behind a mapping in a list', rest))
            self.skip(rest)

    def in_list(self, section: Section, above: str, depth: int) -> None:
        """Read a mapping in a list; a plain value in it is the first of a list, up to the end of the mapping."""
        first = True
        for key in self.events:
            if isinstance(key, yaml.MappingEndEvent):
                self.hollow = f"{above}." if first else self.hollow
                return
            first = False
            name = f"{above}.{self.text(key)}"
            value = next(self.events)
            if depth > MAX_DEPTH:
                raise self.fail(f"nested deeper than {MAX_DEPTH} levels", key, "flatten the file")
            if isinstance(value, yaml.MappingStartEvent):
                self.in_list(section, name, depth + 1)
            elif isinstance(value, yaml.SequenceStartEvent):
                self.array(section, name, key, value, depth)
                self.parameters(section, f"{above}.", depth, first=False)  # the list is over, and so is what is odd
                return
            else:
                values = self.values(name, value, yaml.MappingEndEvent)
                if len(values) > 1:
                    self.told.append(self.otherwise(f'what stands behind "{name}" is no key, for it is in a list', key))
                if isinstance(values[-1], yaml.MappingStartEvent):
                    self.skip(values.pop())
                self.put(section, name, Parameter(values, self.span(key), self.span(value)))
                return

    def otherwise(self, what: str, event: Any, help: str = "write a mapping without the list") -> Diagnostic:
        """Return that ROS 2 reads something otherwise than it looks."""
        message = f"{what}: ROS 2 reads it otherwise than it looks"
        return Diagnostic("parameters-syntax", "warning", message, self.span(event), help=help)

    def skip(self, event: Any) -> None:
        """Pass over the rest of a list that begins with an event."""
        depth = 1
        while True:
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if not depth:
                return
            event = next(self.events)

    def values(self, name: str, event: Any, end: type) -> list[Any]:
        """Return the values of a list up to its end, or to a mapping in it, whose event is the last one then."""
        values: list[Any] = []
        first = ""
        while not isinstance(event, end):
            if isinstance(event, yaml.MappingStartEvent):
                return [*values, event]
            if not isinstance(event, (yaml.ScalarEvent, yaml.AliasEvent)):
                message, help = f'"{name}" holds a list in a list, which ROS 2 refuses', "write one text in quotes"
                raise self.fail(message, event, f'{help}: "[[x, y], ...]"')
            value, kind = self.scalar(event)
            if isinstance(value, str) and _PUT_IN.search(value):
                kind = first
            if first and kind != first:
                message = f'"{name}" mixes {first} and {kind}: ROS 2 refuses the whole file, and no node starts'
                way = "write every number with a point: 0.0"
                raise self.fail(message, event, way if {first, kind} == {"int", "double"} else "use one type")
            first = kind
            values.append(value)
            event = next(self.events)
        return values

    def scalar(self, event: Any) -> tuple[Any, str]:
        """Return a value and its type."""
        if isinstance(event, yaml.AliasEvent):
            raise self.fail("ROS 2 takes no aliases in a parameter file", event, "write the value here")
        text = event.value
        if event.style in ("'", '"') or event.tag == _TEXT:
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
            return (number, "int") if -_MOST - 1 <= number <= _MOST else (float(number), "double")
        if _DOUBLE.match(text):
            fits = sys.float_info.min <= abs(float(text)) <= sys.float_info.max or _ZERO.match(text)
            return (float(text), "double") if fits else (text, "string")  # beyond a double it is text for rcl
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

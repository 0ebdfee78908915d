"""Read ROS 2 parameter files as rcl does, with the position of every key and value, and write them.

The syntax is that of ``ros2/rcl:rcl_yaml_param_parser``, which differs from YAML 1.2: "yes" and "on" are true, 010 is
8, a list has values of one type, there are no aliases, and a key without a value is an error. Values are written with
the type of the parameter (1.0 for a double). Parameters that do not exist in a distribution are not written.
"""

import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import yaml

from rosorin_compile.formats.format import DISTRIBUTIONS, JAZZY, Format
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, DiagnosticError, Related, Source, Span, error

from .node_kinds import Kind, as_yaml, convert, kinds
from .ports import facts

PARAMETERS = "ros__parameters"
_HELP = "a parameter file is NODE: {ros__parameters: {KEY: VALUE}}"
_TRUE = {"y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
_FALSE = {"n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}
# Numbers that strtol and strtod accept, and .inf and .nan of YAML.
_INT = re.compile(r"[-+]?(0[xX][0-9a-fA-F]{1,250}|0[0-7]{0,300}|[1-9][0-9]{0,300})\Z")
_DOUBLE = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?\Z")
_ZERO = r"[-+]?[0.]+([eE].*)?\Z"
_SPECIAL = re.compile(r"[-+]?(\.(inf|Inf|INF)|(?i:inf|infinity|nan))\Z|\.(nan|NaN|NAN)\Z")
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*|\*\*?")
# Launch substitutions $(...), and keywords <...> that nav2_common replaces in parameter files.
_SUBSTITUTED = re.compile(r"\$\(|<[A-Za-z_]\w*>")
_MOST = 2**63 - 1
# Strings that need no quotes, unless they are in _WORDS: YAML reads these words as another type.
_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.-]*(::?[A-Za-z0-9_/.-]+)*")
_WORDS = frozenset(("y", "yes", "n", "no", "true", "false", "on", "off", "null", "nan", "inf", "infinity"))


class Parameter(NamedTuple):
    """A parameter value (bool, int, float, str or a list of these), and the positions of its key and value."""

    value: Any
    key: Span
    span: Span

    @property
    def has_substitution(self) -> bool:
        """Whether the value contains a substitution such as ``$(find-pkg-share ...)`` or ``<prefix>``."""
        values = self.value if isinstance(self.value, list) else [self.value]
        return any(isinstance(one, str) and _SUBSTITUTED.search(one) for one in values)


class Section(NamedTuple):
    """The parameters (by dotted name) of all nodes whose full name matches ``name``; "*" and "**" are wildcards."""

    name: str
    span: Span
    parameters: dict[str, Parameter]

    @property
    def of_any(self) -> bool:
        """Whether the section applies to nodes of any name, because the last part of ``name`` is a wildcard."""
        return self.name.rsplit("/", 1)[-1] in ("*", "**")

    def matches(self, node: str) -> bool:
        """Return True if the section applies to a node with this full name."""
        words = self.name.strip("/").split("/")
        pattern = "".join({"**": "(/[^/]+)*", "*": "/[^/]+"}.get(word, "/" + re.escape(word)) for word in words)
        return re.fullmatch(pattern, node) is not None


class NoParameters(DiagnosticError, ValueError):
    """The file is not a valid parameter file; the exception contains the diagnostic."""


def read_sections(source: Source) -> tuple[list[Section], list[Diagnostic]]:
    """Parse a parameter file; return its sections in the order of the file, and warnings. Raises NoParameters."""
    reader, loader = _Reader(source), getattr(yaml, "CLoader", yaml.Loader)
    try:
        reader.check_events(yaml.parse(source.text, loader))
        tops = [top for top in yaml.compose_all(source.text, loader) if top is not None]
    except yaml.YAMLError as problem:
        from rosorin_compile.source.yaml_mistakes import explain_mistake

        raise NoParameters(replace(explain_mistake(source, problem), rule="parameters-syntax")) from None
    for top in tops:
        if not isinstance(top, yaml.MappingNode):
            raise reader.fail("this is not a parameter file: its top is not a mapping", top)
        reader.names("", top, None)
    if not reader.sections and tops:
        reader.warn(f"no node has parameters here: there is no {PARAMETERS}", source.span(), _HELP)
    return list(reader.sections.values()), reader.diagnostics


class _Reader:
    def __init__(self, source: Source) -> None:
        self.source = source
        self.sections: dict[str, Section] = {}
        self.diagnostics: list[Diagnostic] = []
        self.texts: set[int] = set()  # offsets of values tagged with !!str

    def check_events(self, events: Iterable[Any]) -> None:
        depth = 0
        for event in events:
            if isinstance(event, yaml.AliasEvent):
                raise self.fail("ROS 2 takes no aliases in a parameter file", event, "write the value here")
            if isinstance(event, yaml.ScalarEvent) and event.tag == "tag:yaml.org,2002:str":
                self.texts.add(event.start_mark.index)  # type: ignore[union-attr]
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > 42:
                raise self.fail("nested deeper than 40 levels", event, "flatten the file")

    def names(self, above: str, mapping: Any, named: Span | None) -> bool:
        """Read the namespaces and nodes in the namespace ``above``; return True if they contain parameters."""
        is_node = has_parameters = False
        for key, value in mapping.value:
            if not (name := self.text(key)):
                raise self.fail("a node has no name: ROS 2 refuses the whole file", key, "name it")
            if not isinstance(value, yaml.MappingNode):
                if name == PARAMETERS:
                    raise self.fail(f"{PARAMETERS} is a mapping of keys to values", value)
                raise self.fail(f'"{name}" has a value, but is not below a {PARAMETERS}', key)
            if name != PARAMETERS:
                between = "" if above.endswith("/") or (name.startswith("/") and not above) else "/"
                if self.names(f"{above}{between}{name}", value, self.span(key)):
                    has_parameters = True
                    if is_node:
                        what = f'"{name}" follows the {PARAMETERS} of "{above.strip("/")}", which ROS 2 refuses'
                        raise self.fail(what, key, f"write it as a node of its own: {above.strip('/')}/{name}")
                continue
            if named is None:
                raise self.fail(f"{PARAMETERS} is at the top level: no node is named", key)
            if is_node:
                raise self.fail(f"{PARAMETERS} is repeated for one node, which ROS 2 refuses", key, "make it one")
            words = above.removeprefix("/").split("/")  # checked as in rmw_validate_node_name
            if wrong := [word for word in words if not _WORD.fullmatch(word) and not _SUBSTITUTED.search(word)]:
                what = f'"{wrong[0] or above}" is not a name of a node or a namespace: ROS 2 refuses the whole file'
                help = "letters, digits and _ alone, a digit not first"
                help = help if wrong[0] else "write / between two names, and at most one before the first"
                raise NoParameters(error("parameters-syntax", what, named, help))
            section = self.sections.setdefault(above, Section(above, named, {}))
            self.parameters(section, "", value)
            is_node, has_parameters = True, has_parameters or bool(section.parameters)
        return has_parameters

    def parameters(self, section: Section, above: str, mapping: Any) -> str:
        """Add parameters to a section; return the last key if its value is {} (rcl misreads keys after it), else ""."""
        empty = ""
        for key, value in mapping.value:
            if not (text := self.text(key)):
                raise self.fail("a parameter has no name: ROS 2 refuses the whole file", key, "name it")
            if empty:
                message = f'"{text}" follows "{empty}", which is empty: ROS 2 refuses or misreads the file'
                raise self.fail(message, key, "leave the empty one out")
            name, items = f"{above}{text}", list(value.value) if _is_list(value) else []
            has_map = any(isinstance(one, yaml.MappingNode) for one in items)
            if isinstance(value, yaml.MappingNode):
                empty = self.parameters(section, f"{name}.", value) if value.value else name
            elif has_map and len(items) == 1 and all(_is_list(inner) for _, inner in items[0].value):
                # rcl reads "a: [{b: [x]}]" as "a.b: [x]", which parameter files of gpio_controllers contain.
                self.parameters(section, f"{name}.", items[0])
            elif has_map:
                message = f'"{name}" has a mapping in a list: ROS 2 reads it otherwise than it looks'
                self.warn(message, self.span(key), "write a mapping without the list")
            else:
                self.put(section, name, key, value)
        return empty

    def put(self, section: Section, name: str, key: Any, value: Any) -> None:
        read = self.values(name, value) if _is_list(value) else self.scalar(value)[0]
        made = Parameter(read, self.span(key), self.span(value))
        if before := section.parameters.get(name):
            message, first = f'"{name}" is repeated for {section.name}; the last one counts', "first set here"
            self.diagnostics.append(report("parameters-twice", message, made.key, "", [Related(first, before.key)]))
        if made.value == []:
            message = f'"{name}" is an empty list of unknown type: nodes in C++ do not start ("No parameter value set")'
            self.warn(message, made.span, "leave it out, if the node has a list by default")
        section.parameters[name] = made

    def values(self, name: str, items: Any) -> list[Any]:
        values, first = list[Any](), ""
        for item in items.value:
            if _is_list(item):
                message, help = f'"{name}" holds a list in a list, which ROS 2 refuses', "write one text in quotes"
                raise self.fail(message, item, f'{help}: "[[x, y], ...]"')
            value, kind = self.scalar(item)
            kind = first if isinstance(value, str) and _SUBSTITUTED.search(value) else kind
            if first and kind != first:
                message = f'"{name}" mixes {first} and {kind}: ROS 2 refuses the whole file, and no node starts'
                help = "write every number with a point: 0.0"
                raise self.fail(message, item, help if {first, kind} == {"int", "double"} else "use one type")
            first = kind
            values.append(value)
        return values

    def scalar(self, node: Any) -> tuple[Any, str]:
        text = node.value
        if node.style in ("'", '"') or node.start_mark.index in self.texts:
            return text, "string"
        if not text:
            raise self.fail("this key has no value: ROS 2 refuses the whole file", node, 'write "" for an empty text')
        if text in _TRUE or text in _FALSE:
            return text in _TRUE, "bool"
        if _INT.match(text):
            digits = text.lstrip("+-")
            number = int(text, 16 if digits[1:2] in ("x", "X") else 8 if digits.startswith("0") else 10)
            return (number, "int") if -_MOST - 1 <= number <= _MOST else (float(number), "double")
        if _DOUBLE.match(text):
            fits = sys.float_info.min <= abs(float(text)) <= sys.float_info.max or re.match(_ZERO, text)
            return (float(text), "double") if fits else (text, "string")  # rcl reads numbers out of range as strings
        return (float(text.replace(".", "")), "double") if _SPECIAL.match(text) else (text, "string")

    def text(self, node: Any) -> str:
        if not isinstance(node, yaml.ScalarNode):
            raise self.fail("a key is plain text", node)
        return str(node.value)

    def span(self, node: Any) -> Span:
        start, end = node.start_mark, node.end_mark
        is_word = end.line == start.line and not isinstance(node, yaml.CollectionNode)
        return Span(self.source, start.line + 1, start.column + 1, max(1, end.column - start.column) if is_word else 1)

    def fail(self, message: str, node: Any, help: str = _HELP) -> NoParameters:
        return NoParameters(error("parameters-syntax", message, self.span(node), help))

    def warn(self, message: str, span: Span, help: str) -> None:
        self.diagnostics.append(Diagnostic("parameters-syntax", WARNING, message, span, help=help))


def _is_list(node: Any) -> bool:
    return isinstance(node, yaml.SequenceNode)


@dataclass(frozen=True)
class Parameters:
    """The contents of a parameter file; ``node`` maps full node names to parameters by dotted name."""

    node: Mapping[str, Mapping[str, Any]]


def nodes_of(text: str) -> dict[str, dict[str, Any]]:
    """Parse a generated parameter file; return {node: {parameter: value}}. Raises ValueError if the file is damaged."""
    sections, _ = read_sections(Source("", text))
    if not sections:
        raise ValueError(f"it is not a parameter file: it has no {PARAMETERS}")
    return {one.name.strip("/"): {key: value.value for key, value in one.parameters.items()} for one in sections}


class Node(NamedTuple):
    """A ROS node and its parameters by dotted name; ``kind`` is a ``Kind``, the name of a kind, or None if unknown."""

    name: str
    kind: Kind | str | None
    values: Mapping[str, Any]


def distro_of(output: Output) -> str:
    """Return the ROS 2 distribution of an output: its option ``distribution``, by default jazzy."""
    return str(output.options.get("distribution", JAZZY))


def text(robot: Robot, output: Output, templates: Templates, head: Sequence[str], nodes: Sequence[Node]) -> str:
    """Format nodes with their parameters as a parameter file; ``head`` are comment lines at the top."""
    tree: dict[str, Any] = {}
    for name, parameters in parameters_of(output, nodes).node.items():
        for key, value in parameters.items():
            *above, last = f"{name}/{PARAMETERS}".split("/") + key.split(".")
            place: Any = tree
            for word in above:
                place = place.setdefault(word, {}) if isinstance(place, dict) else None
            if place is not None:
                place[last] = value
    values = {"robot": robot, "distribution": distro_of(output).capitalize(), "head": head, "rows": list(_rows(tree))}
    return templates.own("ros/parameters.yaml.jinja", values)


def parameters_of(output: Output, nodes: Iterable[Node]) -> Parameters:
    """Return the contents of a parameter file. Empty lists are omitted, because rcl cannot infer their type."""
    found: dict[str, dict[str, Any]] = {}
    for node in nodes:
        kind = kinds(distro_of(output))[node.kind] if isinstance(node.kind, str) else node.kind
        for key, value in node.values.items():
            known = kind.key(key) if kind is not None else None
            if value not in ([], ()) and (kind is None or known is None or kind.writes(known)):
                found.setdefault(node.name.strip("/"), {})[key] = convert(value, known.type) if known else value
    return Parameters(found)


def _rows(tree: Mapping[str, Any], depth: int = 0) -> Iterator[str]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield f"{'  ' * depth}{_scalar(key)}:"
            yield from _rows(value, depth + 1)
        else:
            yield f"{'  ' * depth}{_scalar(key)}: {_scalar(value)}"


def _scalar(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_scalar, value))}]"
    if not isinstance(value, str):
        return as_yaml(value)
    return value if _PLAIN.fullmatch(value) and value.lower() not in _WORDS else json.dumps(value, ensure_ascii=False)


def parameter_file(name: str, **more: Any) -> Format:
    """Create the output format for a kind of parameter file; ``more`` are further fields of ``Format``."""
    about = "ROS 2 distribution of the nodes; default: jazzy."
    return Format(
        name=name,
        article="a",
        options={"distribution": {"enum": DISTRIBUTIONS, "description": about}, **facts("ros2_options")[name]},
        read=lambda text: Parameters(nodes_of(text)),
        names_robot=False,
        syntax=nodes_of,
        folder="config",
        deploys=True,
        **more,
    )

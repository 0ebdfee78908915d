"""Parameter files of ROS 2 nodes: which node a value is for, under which key, and where it was written.

``read`` reads one file, ``of_node`` says what of several files reaches a node. As rcl reads them
(``ros2/rcl@jazzy:rcl_yaml_param_parser/src/{parser,parse}.c``): a node stands under its name, below its namespaces or
with them in one word, and may be a pattern (``*`` is one name, ``/**`` any number of them); a key with dots is the same
as keys within keys; what comes later wins. Values are those of YAML 1.1 (``yes`` is true), and units do not exist.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..diagnostics import Diagnostic, Source, Span, error
from ..diagnostics.registry import READING, Rule
from ..frontend.load import parse_yaml, read_text
from ..frontend.tree import Map, Seq, Text, first_line
from ..units import Quantity

RULES = (
    Rule(
        "parameter-file",
        "A parameter file of ROS 2 nodes is not written as rcl reads it: values without a node, a list of lists or of "
        "several types.",
        "`NODE: {ros__parameters: {KEY: VALUE}}`.",
        READING,
    ),
)

PARAMETERS = "ros__parameters"

_TRUE = frozenset(["Y", "y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"])
_FALSE = frozenset(["N", "n", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"])


class Value(NamedTuple):
    """A value of a parameter (bool, int, float, str, a list of one of them, or None), its place, and that of its key.

    ``by`` is the node, or pattern, under which it stands. A list with items of several types is ``mixed``.
    """

    value: Any
    span: Span
    key: Span
    by: str
    mixed: bool = False

    @property
    def substituted(self) -> bool:
        """Whether a launch file puts something else here: ``$(find-pkg-share ...)``, and nobody knows its type."""
        return isinstance(self.value, str) and "$(" in self.value


class Node(NamedTuple):
    """What a file says of a node: its full name or a pattern of names, where, and its values by their keys.

    The keys are in full: ``kinematics.wheels_radius``.
    """

    name: str
    span: Span
    values: Mapping[str, Value]

    @property
    def is_pattern(self) -> bool:
        """Whether several nodes may be meant."""
        return "*" in self.name

    @property
    def base(self) -> str:
        """The name without namespaces."""
        return self.name.rpartition("/")[2]


class ParameterFile(NamedTuple):
    """The nodes of a file in its order, and what is wrong with it."""

    source: Source
    nodes: tuple[Node, ...]
    diagnostics: tuple[Diagnostic, ...]


def read(path: Path, shown: str | None = None) -> ParameterFile:
    """Return what a parameter file says. Raises LoadError for one that cannot be read or is no YAML."""
    source = read_text(path, shown or str(path))
    return read_source(source)


def read_source(source: Source) -> ParameterFile:
    """Return what the text of a parameter file says. Raises LoadError for one that is no YAML."""
    tree = parse_yaml(source)
    reader = _Reader()
    if isinstance(tree, Map):
        reader.nodes_of(tree, "", first_line(source))
    if not reader.seen:
        reader.diagnostics.clear()
        message = f"{source.path} has no parameters of a ROS 2 node: nothing stands under {PARAMETERS}"
        reader.tell(message, first_line(source))
    return ParameterFile(source, tuple(reader.nodes), tuple(reader.diagnostics))


def of_node(files: Iterable[ParameterFile], name: str) -> dict[str, Value]:
    """Return the values that reach a node, by key; ``name`` is its full name, such as /base/controller_manager."""
    return {
        key: value
        for file in files
        for node in file.nodes
        if matches(node.name, name)
        for key, value in node.values.items()
    }


def matches(pattern: str, name: str) -> bool:
    """Say whether the name of a node in a file is that of a node, or a pattern that it fits.

    >>> [matches("/**", "/a/b"), matches("/*/b", "/a/b"), matches("/*", "/a/b"), matches("/a/**", "/a")]
    [True, True, False, True]
    """
    words = (_ANY.get(word, "/" + re.escape(word)) for word in pattern.strip("/").split("/"))
    return re.fullmatch("".join(words), name) is not None


_ANY = {"*": r"/\w+", "**": r"(?:/\w+)*"}


class _Reader:
    """Reads one tree; collects the nodes and what is wrong."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.diagnostics: list[Diagnostic] = []
        self.seen = False

    def tell(self, message: str, span: Span, help: str = "write NODE: {ros__parameters: {KEY: VALUE}}") -> None:
        self.diagnostics.append(error("parameter-file", message, span, help))

    def nodes_of(self, tree: Map, above: str, span: Span) -> None:
        """Take the nodes below a namespace."""
        for key, value in tree.items():
            if key == PARAMETERS:
                self._node(tree, above, span)
                continue
            name = f"{above}/{key.strip('/')}"
            if isinstance(value, Map):
                self.nodes_of(value, name, tree.key_spans[key])
            elif value is not None:
                self.tell(f'"{key}" stands outside {PARAMETERS}: no node has it', tree.key_spans[key])

    def _node(self, tree: Map, name: str, span: Span) -> None:
        values = tree[PARAMETERS]
        self.seen = True
        if not name:
            self.tell(f"{PARAMETERS} stands without the name of a node", tree.key_spans[PARAMETERS])
        elif isinstance(values, Map):
            self.nodes.append(Node(name, span, dict(self._values(values, "", name))))
        elif values is not None:
            self.tell(f"{PARAMETERS} is a mapping of keys to values", tree.key_spans[PARAMETERS])

    def _values(self, tree: Map, above: str, by: str) -> Iterator[tuple[str, Value]]:
        for key, item in tree.items():
            name = f"{above}{key}"
            if isinstance(item, Map):
                yield from self._values(item, f"{name}.", by)
                continue
            span, place = tree.value_spans[key], tree.key_spans[key]
            if not isinstance(item, Seq):
                yield name, Value(plain(item), span, place, by)
                continue
            if any(isinstance(one, (Map, Seq)) for one in item):
                message = f'"{name}" is a list of lists or mappings: no parameter can be that'
                self.tell(message, span, "list plain values")
                continue
            items = [plain(one) for one in item]
            mixed = len({type(one) for one in items}) > 1
            yield name, Value(items, span, place, by, mixed)


def plain(value: Any) -> Any:
    """Return a scalar of our YAML as rcl takes it: without units, and with all the words for true and false.

    >>> plain("yes"), plain(Text("yes")), plain(1.5), plain("nan")
    (True, 'yes', 1.5, nan)
    """
    if isinstance(value, Quantity):
        return value.text or float(value)
    if isinstance(value, str) and not isinstance(value, Text):
        if value in _TRUE or value in _FALSE:
            return value in _TRUE
        if _NOT_FINITE.fullmatch(value):
            return float(value)
    return str(value) if isinstance(value, str) else value


# What the C library reads as a number and our YAML does not.
_NOT_FINITE = re.compile(r"[-+]?(?:nan|inf|infinity)", re.IGNORECASE)

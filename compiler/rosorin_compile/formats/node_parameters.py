"""Parameters of ROS 2 nodes as text and back: a parameter file, each key held against what its distribution knows.

``schemas/ros2_nodes.json`` has the keys of nodes with their types; a value is written as the type that its node takes
(1.0 for a double), for a node does not start with another one. A key that a distribution lacks is left out for it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from ..model import Output, Robot
from ..project import data_folder
from .distributions import DISTRIBUTIONS, JAZZY, known, title
from .format import Fact, Facts, Value
from .templating import BUILTIN, Templates

DISTRIBUTION: Mapping[str, Any] = {
    "enum": DISTRIBUTIONS,
    "description": "The distribution of ROS 2 whose nodes it is for; default jazzy.",
}
PARAMETERS = "ros__parameters"
_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.]*(::?[A-Za-z0-9_/.]+)*")
_WORDS = frozenset(("y", "yes", "n", "no", "true", "false", "on", "off", "null", "nan", "inf", "infinity"))


class Node(NamedTuple):
    """A node with its parameters, by full name with dots; ``kind`` is that of the table, / parts ``name``."""

    name: str
    kind: str
    values: Mapping[str, Any]


def asked(output: Output) -> str:
    """Return the distribution that an output is for, as it says it."""
    return str(output.options.get("distribution", JAZZY))


@cache
def _kinds() -> Mapping[str, Mapping[str, Any]]:
    kinds: Mapping[str, Mapping[str, Any]] = json.loads(
        (data_folder("schemas") / "ros2_nodes.json").read_text("utf-8")
    )["nodes"]
    return kinds


def usual_names(kind: str) -> Sequence[str]:
    """Return what nodes of a kind are usually called."""
    names: Sequence[str] = _kinds()[kind]["names"]
    return names


def package(kind: str) -> str:
    """Return the package of a kind of node."""
    return str(_kinds()[kind]["package"])


def _entry(kind: str, key: str) -> Mapping[str, Any]:
    """Return what is known of a key. Raises KeyError for one that no table has, which is never written."""
    keys: Mapping[str, Mapping[str, Any]] = _kinds()[kind]["keys"]
    return keys[key] if key in keys else keys[next(name for name in keys if re.fullmatch(_pattern(name), key))]


@cache
def _pattern(name: str) -> str:
    """Return what matches the keys that one with variables stands for, such as <layer> or the number <n>."""
    pieces = re.split(r"(<[a-z]+>)", name)
    return "".join(
        (r"\d+" if piece == "<n>" else r"[^.]+") if at % 2 else re.escape(piece) for at, piece in enumerate(pieces)
    )


def text(robot: Robot, output: Output, templates: Templates, head: Sequence[str], nodes: Sequence[Node]) -> str:
    """Return the parameter file of some nodes; ``head`` are lines of comment."""
    distribution = known(asked(output))
    tree: dict[str, Any] = {}
    for node in nodes:
        here = tree
        for word in [*node.name.strip("/").split("/"), PARAMETERS]:
            here = here.setdefault(word, {})
        for key, value in node.values.items():
            entry = _entry(node.kind, key)
            if distribution in entry.get("only", (distribution,)):
                *above, last = key.split(".")
                within = here
                for word in above:
                    within = within.setdefault(word, {})
                within[last] = float(value) if entry["type"] == "double" else value
    values = {"robot": robot, "distribution": title(asked(output)), "head": head, "rows": list(_rows(tree))}
    return templates.render(f"{BUILTIN}parameters.yaml.jinja", values)


def _rows(tree: Mapping[str, Any], depth: int = 0) -> Iterator[str]:
    """Yield the lines of parameters."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield f"{'  ' * depth}{_text(key)}:"
            yield from _rows(value, depth + 1)
        else:
            yield f"{'  ' * depth}{_text(key)}: {_scalar(value)}"


def _scalar(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_scalar, value))}]"
    return _text(value) if isinstance(value, str) else str(value).lower()


def _text(value: str) -> str:
    """Return a text so that YAML has no other idea of it."""
    if _PLAIN.fullmatch(value) and value.lower() not in _WORDS:
        return value
    return json.dumps(value, ensure_ascii=False)


def facts(written: str) -> Facts:
    """Return what a parameter file says, by node. Raises ValueError for a damaged text."""
    made: Facts = {}
    for name, values in nodes_of(written).items():
        for key, value in values.items():
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            made[Fact("node", name, key)] = Value(float(value) if number else _scalar(value))
    return made


def nodes_of(written: str) -> dict[str, dict[str, Any]]:
    """Return the parameters of a file by node and full name. Raises ValueError for a damaged text."""
    import yaml

    try:
        tree = yaml.safe_load(written)
    except yaml.YAMLError as problem:
        raise ValueError(f"it is not YAML: {problem}") from None
    if not isinstance(tree, dict):
        raise ValueError("it is no parameter file: its top is no mapping")
    found: dict[str, dict[str, Any]] = {}
    _find(tree, "", found, 0)
    if not found:
        raise ValueError(f"it is no parameter file: it has no {PARAMETERS}")
    return found


_DEEPEST = 40


def _find(tree: Mapping[Any, Any], above: str, found: dict[str, dict[str, Any]], depth: int) -> None:
    if depth > _DEEPEST:
        raise ValueError("it is nested too deeply")
    for key, value in tree.items():
        if not isinstance(value, dict):
            raise ValueError(f"it is no parameter file: {key} is neither a node nor a namespace")
        if key == PARAMETERS:
            found[above] = dict(_flat(value, "", 0))
        else:
            _find(value, f"{above}/{key}".strip("/"), found, depth + 1)


def _flat(tree: Mapping[Any, Any], above: str, depth: int) -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, dict) and depth < _DEEPEST:
            yield from _flat(value, f"{above}{key}.", depth + 1)
        else:
            yield f"{above}{key}", value


def syntax(written: str) -> object:
    """Return the values of a parameter file without layout and comments. Raises ValueError."""
    return nodes_of(written)

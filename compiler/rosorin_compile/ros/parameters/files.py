"""Parameter files as text and back.

A value is written as the type that its node takes (1.0 for a double), for a node does not start with another one. A key
that a distribution lacks is left out for it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

from rosorin_compile.formats.format import JAZZY
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot

from .tables import Kind, kinds
from .values import converted, written

PARAMETERS = "ros__parameters"
_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.-]*(::?[A-Za-z0-9_/.-]+)*")
_WORDS = frozenset(("y", "yes", "n", "no", "true", "false", "on", "off", "null", "nan", "inf", "infinity"))


@dataclass(frozen=True)
class Parameters:
    """What a parameter file contains: the parameters of each node by full name."""

    node: Mapping[str, Mapping[str, Any]]


class Node(NamedTuple):
    """A node with its parameters, by full name with dots; / parts ``name``.

    ``kind`` is what is known of it, or the name of that in the tables; None: nobody knows its types.
    """

    name: str
    kind: Kind | str | None
    values: Mapping[str, Any]


def asked(output: Output) -> str:
    """Return the distribution that an output is for, as it says it."""
    return str(output.options.get("distribution", JAZZY))


def text(robot: Robot, output: Output, templates: Templates, head: Sequence[str], nodes: Sequence[Node]) -> str:
    """Return the parameter file of some nodes; ``head`` are lines of comment."""
    rows = list(_rows(_tree(output, nodes)))
    values = {"robot": robot, "distribution": asked(output).capitalize(), "head": head, "rows": rows}
    return templates.own("ros/parameters.yaml.jinja", values)


def parameters_of(output: Output, nodes: Iterable[Node]) -> Parameters:
    """Return what the parameter file of some nodes is meant to contain."""
    found: dict[str, dict[str, Any]] = {}
    _find(_tree(output, nodes), "", found, 0)
    return Parameters(found)


def _tree(output: Output, nodes: Iterable[Node]) -> dict[str, Any]:
    """Return the values of some nodes as they are nested in the file.

    An empty list is left out, for rcl does not know of what it is one.
    """
    tree: dict[str, Any] = {}
    for node in nodes:
        kind = kinds(asked(output))[node.kind] if isinstance(node.kind, str) else node.kind
        for key, value in node.values.items():
            known = kind.key(key) if kind is not None else None
            if value not in ([], ()) and (kind is None or known is None or kind.has(known)):
                path = [*node.name.strip("/").split("/"), PARAMETERS, *key.split(".")]
                _put(tree, path, converted(value, known.type) if known is not None else value)
    return tree


def _put(tree: dict[str, Any], path: Sequence[str], value: Any) -> None:
    *above, last = path
    for word in above:
        tree = tree.setdefault(word, {})
        if not isinstance(tree, dict):
            return
    tree[last] = value


def _rows(tree: Mapping[str, Any], depth: int = 0) -> Iterator[str]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield f"{'  ' * depth}{_text(key)}:"
            yield from _rows(value, depth + 1)
        else:
            yield f"{'  ' * depth}{_text(key)}: {_scalar(value)}"


def _scalar(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_scalar, value))}]"
    return _text(value) if isinstance(value, str) else written(value)


def _text(value: str) -> str:
    if _PLAIN.fullmatch(value) and value.lower() not in _WORDS:
        return value
    return json.dumps(value, ensure_ascii=False)


def read(written: str) -> Parameters:
    """Return what a parameter file contains. Raises ValueError for a damaged text."""
    return Parameters(nodes_of(written))


def nodes_of(written: str) -> dict[str, dict[str, Any]]:
    """Return the parameters of a file by node and full name. Raises ValueError for a damaged text."""
    tree = value_of(written)
    if not isinstance(tree, dict):
        raise ValueError("it is no parameter file: its top is no mapping")
    found: dict[str, dict[str, Any]] = {}
    _find(tree, "", found, 0)
    if not found:
        raise ValueError(f"it is no parameter file: it has no {PARAMETERS}")
    return found


def value_of(written: str) -> Any:
    """Return the value of a text of YAML. Raises ValueError for a damaged one."""
    import yaml

    try:
        with suppress(yaml.YAMLError):  # libyaml says it in other words
            return yaml.load(written, getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # noqa: S506 - both are safe
        return yaml.safe_load(written)
    except yaml.YAMLError as problem:
        raise ValueError(f"it is not YAML: {problem}") from None
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


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

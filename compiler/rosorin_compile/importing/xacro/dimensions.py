"""Give arguments and parameters the dimension of the keys that they are used for, so that people may write ``20 mm``.

Numbers without a unit are in SI units in any case: the robot stays the same.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from typing import Any

from rosorin_compile.importing.layout import Expression

_OF_KEYS = {"xyz": "length", "size": "length", "radius": "length", "length": "length", "rpy": "angle", "mass": "mass"}
_OF_JOINTS = {"prismatic": "length", "revolute": "angle", "continuous": "angle"}

_DECLARING = ("params", "parts", "args")
_WORD = re.compile(r"[A-Za-z_]\w*")

Name = tuple[str, str]  # the part, empty for the robot, and an argument, a value or a parameter


def declare_dimensions(files: Mapping[str, Mapping[str, Any]]) -> None:
    """Set the type of each number among the arguments and parameters that is used for one dimension alone."""
    found: dict[Name, set[str]] = {}  # the dimensions of its uses; empty texts for others
    given: list[tuple[Name, Name]] = []  # what is made of the first goes into the second
    bodies: list[tuple[str, Mapping[str, Any]]] = [("", sections) for sections in files.values()]
    for sections in files.values():
        bodies += (sections.get("parts") or {}).items()
    for part, body in bodies:
        params = body.get("params") or {} if part else {}
        for dimension, target, value in _leaves({key: one for key, one in body.items() if key not in _DECLARING}):
            sums = _summands(value)
            for word in _WORD.findall(value) if isinstance(value, Expression) else ():
                name = (part if word in params else "", word)
                if target and word in sums:
                    given.append((name, target))
                else:
                    found.setdefault(name, set()).add(dimension if word in sums else "")
    changed = True
    while changed:
        changed = False
        for source, target in given:
            more = found.get(target, {""}) - found.setdefault(source, set())
            found[source] |= more
            changed = changed or bool(more)
    for part, body in bodies:
        for word, entry in (body.get("params" if part else "args") or {}).items():
            dimensions = found.get((part, word), {""})
            if (
                isinstance(entry, dict)
                and entry.get("type") == "number"
                and len(dimensions) == 1
                and "" not in dimensions
            ):
                entry["type"] = next(iter(dimensions))


def _leaves(value: Any, dimension: str = "", target: Name | None = None) -> Iterator[tuple[str, Name | None, Any]]:
    """Yield each value with its dimension, and the value or the parameter that it is given to."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            if key == "limit" and isinstance(inner, Mapping):
                kind = _OF_JOINTS.get(str(value.get("type")), "")
                for end, one in inner.items():
                    yield from _leaves(one, kind if end in ("lower", "upper") else "")
            elif key == "let" and isinstance(inner, Mapping):
                for word, one in inner.items():
                    yield from _leaves(one, "", ("", word))
            elif key == "with" and isinstance(inner, Mapping):
                part = str(value.get("part", "")).rpartition("/")[2]
                for word, one in inner.items():
                    yield from _leaves(one, "", (part, word))
            else:
                yield from _leaves(inner, _OF_KEYS.get(key, ""))
    elif isinstance(value, list):
        for inner in value:
            yield from _leaves(inner, dimension)
    else:
        yield dimension, target, value


def _summands(value: Any) -> set[str]:
    """Return the names in a formula that are added up, and so have the dimension of the result."""
    found: set[str] = set()
    if not isinstance(value, Expression) or not value.startswith("${"):
        return found
    try:
        waiting: list[ast.expr] = [ast.parse(value[2:-1].strip(), mode="eval").body]
    except SyntaxError:  # text around it, or an expression that is not Python
        return found
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Name):
            found.add(node.id)
        elif isinstance(node, ast.UnaryOp):
            waiting.append(node.operand)
        elif isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub)):
            waiting += [node.left, node.right]
        else:
            names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
            if names & found:
                return set()
    return found

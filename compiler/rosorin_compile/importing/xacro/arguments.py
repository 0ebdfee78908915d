"""The values of arguments with which a translation is verified, and the dimensions that numbers have.

A number that is used for one dimension alone has that dimension, so that people may write ``20 mm``.
"""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import Any

from rosorin_compile.importing.layout import Expression

from .documents import PROBE
from .formulas import literal
from .ir import FLAG, LET, NUMBER, TEXT, Program, Variable

_OF_KEYS = {"xyz": "length", "size": "length", "radius": "length", "length": "length", "rpy": "angle", "mass": "mass"}
_OF_JOINTS = {"prismatic": "length", "revolute": "angle", "continuous": "angle"}

_DECLARING = ("params", "parts", "args")
_WORD = re.compile(r"[A-Za-z_]\w*")

Name = tuple[str, str]  # the part, empty for the robot, and an argument, a value or a parameter


class ArgumentValues:
    """What the arguments of a program are compared with; ``printed`` are the variables that texts contain."""

    def __init__(self, program: Program, printed: set[Variable]) -> None:
        self.printed = printed
        self._receivers: dict[str, list[Variable]] = defaultdict(list)  # the variables that are given one as it is
        for macro in program.macros.values():
            for call in macro.calls:
                for name, (node, _) in call.given.items():
                    plain: Any = node
                    while isinstance(plain, ast.Call) and getattr(plain.func, "id", "") in ("__flag", "__number"):
                        plain = plain.args[0]
                    if isinstance(plain, ast.Name):
                        self._receivers[plain.id].append(macro.parameters[name])
        for variable in program.variables.values():
            if variable.kind == LET and variable.node is not None:
                for one in program.variables_in(variable.node):
                    self._receivers[one.id].append(variable)

    def compared(self, variable: Variable) -> list[Any]:
        """Return what an argument is compared with, itself or by the parameters and properties that it becomes."""
        found: list[Any] = []
        reached, waiting = {variable.id}, [variable]
        while waiting:
            one = waiting.pop()
            found += one.candidates
            if one in self.printed:
                self.printed.add(variable)
            others = [other for other in self._receivers[one.id] if other.id not in reached]
            reached |= {other.id for other in others}
            waiting += others
        return list(dict.fromkeys(found))

    def allowed(self, variable: Variable) -> list[str]:
        """Return the texts that an argument may be, or nothing if it may be any."""
        texts = [str(one) for one in self.compared(variable)]
        if variable.type != TEXT or not texts or variable in self.printed or "" in texts:
            return []
        allowed = list(dict.fromkeys([str(variable.values[0]), *sorted(texts)]))
        return allowed if len(allowed) > 1 else []

    def choices(self, variable: Variable) -> list[str]:
        """Return the values of an argument that are compiled; the first is its default."""
        default = str(variable.values[0])
        compared = [str(one) for one in self.compared(variable)]
        if variable.type == FLAG:
            others = ["false" if literal(default) is True else "true"]
        elif variable.type == NUMBER:
            others = [one for one in compared if isinstance(literal(one), (int, float))]
        else:
            others = sorted(compared)
            is_free = not self.allowed(variable) and not variable.names_file
            if is_free and (compared or variable in self.printed) and not re.search(r"[\s/]", default):
                others.append(PROBE)
        return list(dict.fromkeys([default, *others]))


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

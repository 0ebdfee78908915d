"""What the launch files that we write share: names of their arguments, conditions over modes, imports.

A condition is said with launch's own ``and``, ``or`` and ``not``, which take two arguments (one) on Humble and Jazzy
alike (``ros2/launch@{humble,jazzy}: launch/launch/substitutions/boolean_substitution.py``).
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rosorin_compile.language.expression import parsed
from rosorin_compile.model import Robot
from rosorin_compile.rules.publishers import combinations, holds, modes_in

if TYPE_CHECKING:
    from .static_tf import StaticTransform

# What a mode may be set to. A condition of launch reads 1 and no on; its and, or, not read on and no 1.
STATES = ("true", "false", "True", "False")

MODE, NOT, AND, OR, ALWAYS, NEVER = "mode", "not", "and", "or", "true", "false"
_WIDTH = 99  # columns, as ament_flake8 asks
_PYTHON = {NOT: "NotSubstitution", AND: "AndSubstitution", OR: "OrSubstitution"}

# (MODE, name), (NOT, it), (AND, one, other), (OR, one, other), (ALWAYS,), (NEVER,)
Condition = tuple[Any, ...]


def free_names(names: Iterable[str], taken: Iterable[str], before: str) -> dict[str, str]:
    """Return a launch argument for each name: itself, or one that begins with ``before`` where the name is taken.

    >>> free_names(["slam", "rviz", "mode_rviz"], ["rviz"], "mode_")
    {'slam': 'slam', 'rviz': 'mode_mode_rviz', 'mode_rviz': 'mode_rviz'}
    """
    names, used = list(names), set(taken)
    free = {name: name for name in names if name not in used}
    used |= free.keys()
    for name in names:
        if name not in free:
            other = f"{before}{name}"
            while other in used:
                other = f"{before}{other}"
            free[name] = other
            used.add(other)
    return {name: free[name] for name in names}


def mode_arguments(robot: Robot, in_modes: Iterable[StaticTransform], taken: Iterable[str]) -> dict[str, str]:
    """Return the launch arguments of the modes that static transforms depend on; ``taken`` are those that are none."""
    return free_names(modes_in(robot, [transform.when for transform in in_modes]), taken, "mode_")


def condition(robot: Robot, when: str) -> Condition:
    """Return a legal condition over modes; as it is written, where that is ``and``, ``or``, ``not`` and modes alone."""
    modes = modes_in(robot, [when])
    read = _read(parsed(when).body, modes)
    if read is not None:
        return read
    table = {tuple(states.values()): holds(when, states) for states in combinations(modes)}
    return _decided(modes, (), table)


def _read(node: ast.expr, modes: Sequence[str]) -> Condition | None:
    """Return an expression as a condition; None if it says more than launch can."""
    if isinstance(node, ast.Name):
        return (MODE, node.id) if node.id in modes else None
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        inner = _read(node.operand, modes)
        return None if inner is None else (NOT, inner)
    if isinstance(node, ast.BoolOp):
        parts = [_read(value, modes) for value in node.values]
        known = [part for part in parts if part is not None]
        return _joined(AND if isinstance(node.op, ast.And) else OR, known) if len(known) == len(parts) else None
    return None


def _joined(word: str, parts: Sequence[Condition]) -> Condition:
    """Return many conditions joined two by two, so that they nest as little as they can."""
    if len(parts) == 1:
        return parts[0]
    half = (len(parts) + 1) // 2
    return (word, _joined(word, parts[:half]), _joined(word, parts[half:]))


def _decided(modes: Sequence[str], known: tuple[bool, ...], table: Mapping[tuple[bool, ...], bool]) -> Condition:
    """Return a condition that decides one mode after the other (Shannon's expansion), without what decides nothing."""
    if len(known) == len(modes):
        return (ALWAYS,) if table[known] else (NEVER,)
    mode: Condition = (MODE, modes[len(known)])
    off, on = (_decided(modes, (*known, state), table) for state in (False, True))
    if off == on:
        return off
    if {off, on} == {(ALWAYS,), (NEVER,)}:
        return mode if on == (ALWAYS,) else (NOT, mode)
    if on in ((ALWAYS,), (NEVER,)):
        return (OR, mode, off) if on == (ALWAYS,) else (AND, (NOT, mode), off)
    if off in ((ALWAYS,), (NEVER,)):
        return (OR, (NOT, mode), on) if off == (ALWAYS,) else (AND, mode, on)
    return (OR, (AND, mode, on), (AND, (NOT, mode), off))


def in_frontends(condition: Condition, arguments: Mapping[str, str]) -> str:
    """Return a condition as XML and YAML launch files say it; ``arguments`` are launch arguments by mode.

    >>> in_frontends(("and", ("mode", "slam"), ("not", ("mode", "rviz"))), {"slam": "slam", "rviz": "mode_rviz"})
    '$(and $(var slam) $(not $(var mode_rviz)))'
    """
    word, *parts = condition
    if word == MODE:
        return f"$(var {arguments[parts[0]]})"
    return f"$({word} {' '.join(in_frontends(part, arguments) for part in parts)})" if parts else str(word)


def in_python(condition: Condition, arguments: Mapping[str, str], indent: int) -> str:
    """Return a condition as Python launch files say it, on more than one line where it has to be.

    ``indent`` is the column of its first line, which the text goes without.
    """
    word, *parts = condition
    if not parts:
        return repr(word)
    if word == MODE:
        return f"LaunchConfiguration({arguments[parts[0]]!r})"
    line = f"{_PYTHON[word]}({', '.join(in_python(part, arguments, 0) for part in parts)})"
    if "\n" not in line and indent + len(line) < _WIDTH:
        return line
    space = " " * (indent + 4)
    lines = [f"{space}{in_python(part, arguments, indent + 4)}," for part in parts]
    return "\n".join([f"{_PYTHON[word]}(", *lines, f"{' ' * indent})"])


def if_condition(condition: Condition, arguments: Mapping[str, str], indent: int) -> str:
    """Return the ``condition`` of a node; ``indent`` is the column of the word ``condition``, where it stands."""
    line = f"IfCondition({in_python(condition, arguments, 0)})"
    if "\n" not in line and indent + len(f"condition={line},") <= _WIDTH:
        return line
    space = " " * (indent + 4)
    return f"IfCondition(\n{space}{in_python(condition, arguments, indent + 4)}\n{' ' * indent})"


def substitutions(conditions: Iterable[Condition], *more: str) -> list[str]:
    """Return the names that conditions take from ``launch.substitutions``, and ``more``; sorted, each once."""
    return sorted({*more, *(_PYTHON[word] for one in conditions for word in _words(one) if word in _PYTHON)})


def _words(condition: Condition) -> Iterator[str]:
    word, *parts = condition
    yield word
    for part in parts if word in _PYTHON else ():
        yield from _words(part)


def imported(module: str, names: Sequence[str]) -> str:
    """Return an import of sorted names, on more than one line where it has to be."""
    line = f"from {module} import {', '.join(names)}"
    return line if len(line) <= _WIDTH else "\n".join([f"from {module} import (", *(f"    {n}," for n in names), ")"])

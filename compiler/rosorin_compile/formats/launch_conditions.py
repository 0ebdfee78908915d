"""Conditions over modes in the three forms of launch files, and names of launch arguments.

Launch's own ``and``, ``or`` and ``not`` take two arguments (one) on Humble and Jazzy alike
(``ros2/launch@{humble,jazzy}: launch/launch/substitutions/boolean_substitution.py``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.model import Robot
from rosorin_compile.rules.publishers import combinations, holds, modes_in

# What a mode may be set to. A condition of launch reads 1 and no on; its and, or, not read on and no 1.
STATES = ("true", "false", "True", "False")

MODE, NOT, AND, OR = "mode", "not", "and", "or"
_WIDTH = 99  # columns, as ament_flake8 asks
_PYTHON = {NOT: "NotSubstitution", AND: "AndSubstitution", OR: "OrSubstitution"}

# (MODE, name), (NOT, condition), (AND, condition, condition), (OR, condition, condition), ALWAYS, NEVER
Condition = tuple[Any, ...]
ALWAYS: Condition = ("true",)
NEVER: Condition = ("false",)


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
            argument = f"{before}{name}"
            while argument in used:
                argument = f"{before}{argument}"
            free[name] = argument
            used.add(argument)
    return {name: free[name] for name in names}


def mode_arguments(robot: Robot, conditions: Iterable[str], taken: Iterable[str]) -> dict[str, str]:
    """Return the launch arguments of the modes in conditions; ``taken`` are names of other launch arguments."""
    return free_names(modes_in(robot, list(conditions)), taken, "mode_")


def condition(robot: Robot, when: str) -> Condition:
    """Return a condition over modes."""
    modes = modes_in(robot, [when])
    return _from_table(modes, (), {tuple(states.values()): holds(when, states) for states in combinations(modes)})


def _from_table(modes: Sequence[str], states: tuple[bool, ...], table: Mapping[tuple[bool, ...], bool]) -> Condition:
    """Return a condition with a truth table, decided one mode after the other (Shannon's expansion)."""
    if len(states) == len(modes):
        return ALWAYS if table[states] else NEVER
    mode: Condition = (MODE, modes[len(states)])
    off, on = (_from_table(modes, (*states, state), table) for state in (False, True))
    if off == on:
        return off
    inverse = (NOT, mode)
    if {off, on} == {ALWAYS, NEVER}:
        return mode if on == ALWAYS else inverse
    if on in (ALWAYS, NEVER):
        return (OR, mode, off) if on == ALWAYS else (AND, inverse, off)
    if off in (ALWAYS, NEVER):
        return (OR, inverse, on) if off == ALWAYS else (AND, mode, on)
    return (OR, (AND, mode, on), (AND, inverse, off))


def in_frontends(condition: Condition, arguments: Mapping[str, str]) -> str:
    """Return a condition for XML and YAML launch files; ``arguments`` are launch arguments by mode.

    >>> in_frontends(("and", ("mode", "slam"), ("not", ("mode", "rviz"))), {"slam": "slam", "rviz": "mode_rviz"})
    '$(and $(var slam) $(not $(var mode_rviz)))'
    """
    word, *operands = condition
    if word == MODE:
        return f"$(var {arguments[operands[0]]})"
    words = " ".join(in_frontends(operand, arguments) for operand in operands)
    return f"$({word} {words})" if operands else str(word)


def in_python(condition: Condition, arguments: Mapping[str, str], indent: int) -> str:
    """Return a condition for Python launch files, on several lines if it is long.

    ``indent`` is the column of its first line, which is not part of the text.
    """
    word, *operands = condition
    if not operands:
        return repr(word)
    if word == MODE:
        return f"LaunchConfiguration({arguments[operands[0]]!r})"
    line = f"{_PYTHON[word]}({', '.join(in_python(operand, arguments, 0) for operand in operands)})"
    if "\n" not in line and indent + len(line) < _WIDTH:
        return line
    space = " " * (indent + 4)
    lines = [f"{space}{in_python(operand, arguments, indent + 4)}," for operand in operands]
    return "\n".join([f"{_PYTHON[word]}(", *lines, f"{' ' * indent})"])


def if_condition(condition: Condition, arguments: Mapping[str, str], indent: int) -> str:
    """Return the value of the ``condition`` of a node; ``indent`` is the column of the word ``condition``."""
    line = f"IfCondition({in_python(condition, arguments, 0)})"
    if "\n" not in line and indent + len(f"condition={line},") <= _WIDTH:
        return line
    space = " " * (indent + 4)
    return f"IfCondition(\n{space}{in_python(condition, arguments, indent + 4)}\n{' ' * indent})"


def import_substitutions(conditions: Iterable[Condition], *more: str) -> str:
    """Return the import of the names that conditions take from ``launch.substitutions``, and of ``more``."""
    names = sorted({*more, *(_PYTHON[word] for one in conditions for word in _words(one) if word in _PYTHON)})
    line = f"from launch.substitutions import {', '.join(names)}"
    if len(line) <= _WIDTH:
        return line
    return "\n".join(["from launch.substitutions import (", *(f"    {name}," for name in names), ")"])


def _words(condition: Condition) -> Iterator[str]:
    word, *operands = condition
    yield word
    for operand in operands if word in _PYTHON else ():
        yield from _words(operand)

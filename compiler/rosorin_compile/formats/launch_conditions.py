"""Conditions over modes in the three forms of launch files, and names of launch arguments.

Launch's own ``and``, ``or`` and ``not`` take two arguments (one) on Humble and Jazzy alike
(``ros2/launch@{humble,jazzy}: launch/launch/substitutions/boolean_substitution.py``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rosorin_compile.model import Robot
from rosorin_compile.rules.publishers import combinations, holds, modes_in

# What a mode may be set to. A condition of launch reads 1 and no on; its and, or, not read on and no 1.
STATES = ("true", "false", "True", "False")

MODE, NOT, AND, OR = "mode", "not", "and", "or"
_WIDTH = 99  # columns, as ament_flake8 requires
_IF = "if"
_PYTHON = {NOT: "NotSubstitution", AND: "AndSubstitution", OR: "OrSubstitution", _IF: "IfCondition"}

# (MODE, name), (NOT, condition), (AND, condition, condition), (OR, condition, condition), ALWAYS, NEVER
Condition = tuple[Any, ...]
ALWAYS: Condition = ("true",)
NEVER: Condition = ("false",)


def free_names(names: Iterable[str], taken: Iterable[str], before: str) -> dict[str, str]:
    """Return a launch argument for each name: itself, or one that begins with ``before`` where the name is taken."""
    names, taken = list(names), set(taken)
    free = {name: name for name in names if name not in taken}
    for name in names:
        argument = name
        while name not in free and argument in {*taken, *free.values()}:
            argument = f"{before}{argument}"
        free.setdefault(name, argument)
    return {name: free[name] for name in names}


def mode_arguments(robot: Robot, conditions: Iterable[str], taken: Iterable[str]) -> dict[str, str]:
    """Return the launch arguments of the modes in conditions; ``taken`` are names of other launch arguments."""
    return free_names(modes_in(robot, list(conditions)), taken, "mode_")


def condition(robot: Robot, when: str) -> Condition:
    """Return a condition over modes, decided one mode after the other (Shannon's expansion)."""
    modes = modes_in(robot, [when])
    table = {tuple(states.values()): holds(when, states) for states in combinations(modes)}

    def decide(states: tuple[bool, ...]) -> Condition:
        if len(states) == len(modes):
            return ALWAYS if table[states] else NEVER
        mode: Condition = (MODE, modes[len(states)])
        off, on, inverse = decide((*states, False)), decide((*states, True)), (NOT, mode)
        if off == on:
            return off
        if {off, on} == {ALWAYS, NEVER}:
            return mode if on == ALWAYS else inverse
        if on in (ALWAYS, NEVER):
            return (OR, mode, off) if on == ALWAYS else (AND, inverse, off)
        if off in (ALWAYS, NEVER):
            return (OR, inverse, on) if off == ALWAYS else (AND, mode, on)
        return (OR, (AND, mode, on), (AND, inverse, off))

    return decide(())


def in_frontends(condition: Condition, arguments: Mapping[str, str]) -> str:
    """Return a condition for XML and YAML launch files, such as "$(and $(var slam) $(not $(var rviz)))"."""
    word, *operands = condition
    if word == MODE:
        return f"$(var {arguments[operands[0]]})"
    words = " ".join(in_frontends(operand, arguments) for operand in operands)
    return f"$({word} {words})" if operands else str(word)


def in_python(condition: Condition, arguments: Mapping[str, str], indent: int, before: int = 0) -> str:
    """Return a condition for Python launch files, behind ``before`` columns of a line that is indented."""
    word, *operands = condition
    if word == MODE or not operands:
        return f"LaunchConfiguration({arguments[operands[0]]!r})" if operands else repr(word)
    line = f"{_PYTHON[word]}({', '.join(in_python(operand, arguments, 0) for operand in operands)})"
    if "\n" not in line and indent + before + len(line) < _WIDTH:
        return line
    comma = "" if word == _IF else ","
    lines = [f"{' ' * (indent + 4)}{in_python(operand, arguments, indent + 4)}{comma}" for operand in operands]
    return "\n".join([f"{_PYTHON[word]}(", *lines, f"{' ' * indent})"])


def if_condition(condition: Condition, arguments: Mapping[str, str], indent: int) -> str:
    """Return the value of the ``condition`` of a node; ``indent`` is the column of the word ``condition``."""
    return in_python((_IF, condition), arguments, indent, len("condition="))


def import_substitutions(conditions: Iterable[Condition], *more: str) -> str:
    """Return the import of the names that conditions take from ``launch.substitutions``, and of ``more``."""
    names, waiting = set(more), list(conditions)
    while waiting:
        word, *operands = waiting.pop()
        names |= {_PYTHON[word]} if word in _PYTHON else set()
        waiting += operands if word in _PYTHON else []
    line = f"from launch.substitutions import {', '.join(sorted(names))}"
    if len(line) <= _WIDTH:
        return line
    return "\n".join(["from launch.substitutions import (", *(f"    {name}," for name in sorted(names)), ")"])

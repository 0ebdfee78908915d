"""Conditions over modes: when an edge is published."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product

from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.model import Edge, Robot
from rosorin_compile.source.diagnostics import Diagnostic, UnknownName, did_you_mean
from rosorin_compile.source.rule_registry import FRAMES, rule
from rosorin_compile.source.tree import Text, at

from .case import Case

MAX_MODES = 10
_NAME = re.compile(r"[^\W\d]\w*")

Combination = Mapping[str, bool]


@rule("unknown-mode", "`when` names a mode that is not in `modes`.", "Correct it, or add the mode.", FRAMES)
@rule("bad-condition", "`when` is invalid or never true.", 'Combine modes: "slam and not replay".', FRAMES)
@rule("too-many-modes", "Conditions depend on too many modes.", "Use at most 10 modes for one frame.", FRAMES)
def legal(case: Case) -> Iterator[Diagnostic]:
    """Conditions that are invalid, name an unknown mode, or are never true."""
    for index, edge in enumerate(case.robot.edges):
        yield from _problems(case, index, edge)


def is_legal(case: Case, edge: Edge) -> bool:
    """Return True if the condition of an edge is valid."""
    return not any(_problems(case, 0, edge))


def _problems(case: Case, index: int, edge: Edge) -> Iterator[Diagnostic]:
    if not edge.when:
        return
    path, way = case.edge(index, "when"), f"{edge.parent} -> {edge.child}"
    names = modes_in(case.robot, [edge.when])
    if len(names) > MAX_MODES:
        message = f"the condition of {way} depends on {len(names)} modes: too many to check"
        yield case.problem("too-many-modes", message, path)
        return
    try:
        results = [evaluate(edge.when, combination.__getitem__) for combination in combinations(names)]
    except ExpressionError as problem:
        yield _invalid(case, index, edge, problem)
        return
    if not all(isinstance(result, bool) for result in results):
        message = f'the condition "{edge.when}" is not true or false'
        yield case.problem("bad-condition", message, path)
    elif not any(results):
        message = f'the condition "{edge.when}" is never true: {way} would not be published'
        yield case.problem("bad-condition", message, path, "correct the condition, or remove the edge")


def _invalid(case: Case, index: int, edge: Edge, problem: ExpressionError) -> Diagnostic:
    """Return the diagnostic of a condition that cannot be evaluated, at the column of the mistake."""
    name, column = problem.unknown, problem.column
    if name and not name.endswith("()"):
        help = did_you_mean(name, case.robot.modes, f'add "{name}" to modes')
        found = case.problem("unknown-mode", f'there is no mode "{name}"', case.edge(index, "when"), help)
    else:
        name, reason = " ", problem.message.removeprefix("not an expression: ")
        message = f'the condition "{edge.when}" cannot be read: {reason}'
        found = case.problem("bad-condition", message, case.edge(index, "when"))
    if found.span is None or found.span.length < len(edge.when):
        return found
    # The expression is read without the blanks around it; quotes are part of the value's place in the file.
    is_quoted = isinstance(at(case.tree, case.edge(index, "when")), Text)
    start = len(edge.when) - len(edge.when.lstrip()) + column + is_quoted
    return replace(found, span=found.span._replace(column=found.span.column + start, length=max(1, len(name))))


def holds(when: str, combination: Combination) -> bool:
    """Return True if a legal condition is true in a combination of modes."""
    return not when or bool(evaluate(when, combination.__getitem__))


def modes_in(robot: Robot, whens: Iterable[str]) -> list[str]:
    """Return the modes that conditions name, in the order of the description."""
    named = {name for when in whens for name in _NAME.findall(when)}
    return [mode for mode in robot.modes if mode in named]


def combinations(modes: list[str]) -> Iterator[Combination]:
    """Yield every way in which modes can be on and off."""
    for states in product((False, True), repeat=len(modes)):
        yield dict(zip(modes, states, strict=True))


def in_words(combination: Combination) -> str:
    """Return a combination as the end of a sentence: ' when "slam" is off'; empty without modes."""
    states = [f'"{mode}" is {"on" if on else "off"}' for mode, on in combination.items()]
    return f" when {' and '.join(states)}" if states else ""


def check_modes(robot: Robot, modes: Mapping[str, bool]) -> Mapping[str, bool]:
    """Return modes by name if the robot has all of them. Raises UnknownName."""
    for name in modes:
        if name not in robot.modes:
            known = did_you_mean(name, robot.modes) or "it has none"
            raise UnknownName(f'{robot.name} has no mode "{name}"; {known}')
    return modes

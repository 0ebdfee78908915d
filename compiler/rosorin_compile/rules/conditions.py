"""Conditions over modes: when an edge is published."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product

from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.model import Edge, Robot
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Help, Suggestion, UnknownName, did_you_mean
from rosorin_compile.source.rule_registry import FRAMES, rule
from rosorin_compile.source.tree import Path, Text, at

from .case import Case

MAX_MODES = 10

_NAME = re.compile(r"[^\W\d]\w*")

Combination = Mapping[str, bool]


@rule("unknown-mode", "`when` names a mode that is not in `modes`.", "Correct it, or add the mode.", FRAMES)
@rule(
    "bad-condition",
    "`when` cannot be read, is not true or false, or is never true.",
    "Write modes with `and`, `or`, `not`.",
    FRAMES,
)
@rule(
    "too-many-modes",
    "The conditions of one frame depend on too many modes to check them all.",
    "Use fewer for one frame.",
    FRAMES,
)
def legal(case: Case) -> Iterator[Diagnostic]:
    """Conditions that cannot be read, name an unknown mode, or are never true."""
    for index, edge in enumerate(case.robot.edges):
        wrong = problem(case, index, edge) if edge.when else None
        if wrong:
            yield wrong


def is_legal(case: Case, edge: Edge) -> bool:
    """Say whether the condition of an edge means something."""
    return not edge.when or problem(case, 0, edge) is None


def problem(case: Case, index: int, edge: Edge) -> Diagnostic | None:
    """Return what is wrong with the condition of an edge, the ``index``-th of the description."""
    path = case.edge(index, "when")
    names = modes_in(case.robot, [edge.when])
    if len(names) > MAX_MODES:
        message = f"the condition of {edge.parent} -> {edge.child} depends on {len(names)} modes: too many to check"
        return case.problem("too-many-modes", message, path, f"at most {MAX_MODES} modes in one condition")
    results = []
    for combination in combinations(names):
        try:
            results.append(_value(edge.when, combination))
        except ExpressionError as wrong:
            return _not_readable(case, path, edge, wrong)
    if not all(isinstance(result, bool) for result in results):
        message = f'the condition "{edge.when}" is not true or false'
        return case.problem("bad-condition", message, path, 'write modes with and, or, not: "slam and not replay"')
    if not any(results):
        message = f'the condition "{edge.when}" is never true: {edge.parent} -> {edge.child} would not be published'
        return case.problem("bad-condition", message, path, "correct the condition, or remove the edge")
    return None


def _not_readable(case: Case, path: Path, edge: Edge, wrong: ExpressionError) -> Diagnostic:
    modes = case.robot.modes
    name = wrong.unknown
    if name and not name.endswith("()"):
        help: Help = Suggestion(name, modes, f'add "{name}" to modes')
        rule, message = "unknown-mode", f'there is no mode "{name}"'
    else:
        reason = wrong.message.removeprefix("not an expression: ")
        rule, message = "bad-condition", f'the condition "{edge.when}" cannot be read: {reason}'
        help = 'write modes with and, or, not: "slam and not replay"'
    diagnostic = case.problem(rule, message, path, help)
    text = at(case.tree, path)
    if diagnostic.span is None or diagnostic.span.length < len(edge.when):
        return diagnostic
    # The expression is read without the blanks around it; quotes are part of the value's place in the file.
    start = len(edge.when) - len(edge.when.lstrip()) + wrong.column + (1 if isinstance(text, Text) else 0)
    length = len(name) if rule == "unknown-mode" else 1
    span = diagnostic.span
    return replace(diagnostic, span=span._replace(column=span.column + start, length=max(1, length)))


def _value(text: str, combination: Combination) -> object:
    def lookup(name: str) -> object:
        return combination[name]

    return evaluate(text, lookup)


def holds(when: str, combination: Combination) -> bool:
    """Say whether a legal condition is true in a combination of modes."""
    return not when or bool(_value(when, combination))


def modes_in(robot: Robot, whens: Iterable[str]) -> list[str]:
    """Return the modes that conditions name, sorted."""
    named = {name for when in whens for name in _NAME.findall(when)}
    return [mode for mode in robot.modes if mode in named]


def combinations(modes: list[str]) -> Iterator[Combination]:
    """Yield every way in which modes can be on and off."""
    for states in product((False, True), repeat=len(modes)):
        yield dict(zip(modes, states, strict=True))


def too_many(case: Case, child: str, path: Path, count: int) -> Diagnostic:
    """Return a warning that the publishers of a frame could not be compared."""
    message = f'the publishers of "{child}" depend on {count} modes together: too many to check for gaps and doubles'
    help = f"use at most {MAX_MODES} modes for one frame"
    return case.problem("too-many-modes", message, path, help, severity=WARNING)


def in_words(combination: Combination) -> str:
    """Return a combination as the end of a sentence: ' when "slam" is off'; empty if there is none to name."""
    states = [f'"{mode}" is {"on" if on else "off"}' for mode, on in combination.items()]
    return f" when {' and '.join(states)}" if states else ""


def check_modes(robot: Robot, modes: Mapping[str, bool]) -> Mapping[str, bool]:
    """Return modes by name if the robot has all of them. Raises UnknownName."""
    for name in modes:
        if name not in robot.modes:
            known = did_you_mean(name, robot.modes) or "it has none"
            raise UnknownName(f'{robot.name} has no mode "{name}"; {known}')
    return modes

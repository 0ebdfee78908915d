"""check --every-argument: compile a robot with every combination of the arguments that have a list of values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, product
from math import prod
from typing import TYPE_CHECKING, Any

from ..project import Description
from ..wording import counted
from .shared import FINE, PROBLEMS, Run

if TYPE_CHECKING:
    from ..arguments import Argument
    from ..diagnostic import Diagnostic
    from ..expand.vendor import Tell

MAX_COMBINATIONS = 256

Choice = tuple[str, tuple[str, ...]]  # an argument and its values, that of the default first
Combination = tuple[str, ...]  # one value for each argument


def check_every(run: Run, description: Description) -> int:
    """Compile one robot in memory with every combination; each problem is said once, with the arguments it comes by."""
    from ..arguments import declared
    from ..diagnostic import arrange, has_errors
    from ..load import LoadError
    from ..pipeline import compile_robot

    try:
        given = run.given.values()
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    arguments, wrong = declared(description.path, given)
    if has_errors(wrong):
        run.console.show(wrong)
        return PROBLEMS
    varied = choices(arguments, given)
    tried = list(islice(combinations(varied), MAX_COMBINATIONS))
    found: dict[Diagnostic, list[Combination]] = {}
    tell: Tell = run.console.ahead
    for combination in tried:
        texts = dict(zip((name for name, _ in varied), combination, strict=True))
        for diagnostic in compile_robot(description.path, {**given, **texts}, tell).diagnostics:
            if diagnostic.severity != "note":
                found.setdefault(diagnostic, []).append(combination)
        tell = _already_told
    said = [d._replace(message=d.message + _with(varied, tried, where)) for d, where in found.items()]
    run.console.show(arrange(said))
    failed = {one for diagnostic, where in found.items() if diagnostic.severity == "error" for one in where}
    run.console.say(f"{description.name}: {_summary(varied, len(tried), len(failed))}")
    return PROBLEMS if failed else FINE


def _already_told(_diagnostic: Diagnostic) -> None:
    """Take what has to be said before anything is run: the first combination said it."""


def choices(arguments: Sequence[Argument], given: Mapping[str, Any]) -> list[Choice]:
    """Return the arguments with a list of values, those of one_of or true and false, that a run leaves open."""
    found = []
    for argument in arguments:
        values = argument.allowed or (("true", "false") if argument.type == "boolean" else ())
        if values and argument.name not in given and argument.set_at is None:
            first = [value for value in values if value == argument.default]
            found.append((argument.name, tuple(dict.fromkeys([*first, *values]))))
    return found


def combinations(varied: Sequence[Choice]) -> Iterator[Combination]:
    """Yield all combinations: the defaults, those in which one argument differs from them, then all others."""
    defaults = tuple(values[0] for _, values in varied)
    near = [defaults]
    for index, (_, values) in enumerate(varied):
        near += [(*defaults[:index], value, *defaults[index + 1 :]) for value in values[1:]]
    yield from near
    seen = set(near)
    yield from (one for one in product(*(values for _, values in varied)) if one not in seen)


def _with(varied: Sequence[Choice], tried: Sequence[Combination], where: Sequence[Combination]) -> str:
    """Return the arguments that a problem comes by, as the end of a sentence; empty if it always comes."""
    if len(where) == len(tried):
        return ""
    seen = [[value for value in values if value in column] for (_, values), column in _columns(varied, where)]
    told = [
        f"{name}={' or '.join(values)}"
        for (name, every), values in zip(varied, seen, strict=True)
        if len(values) < len(every)
    ]
    if prod(map(len, seen)) == len(where) and told:
        return f" (with {', '.join(told)})"
    first = ", ".join(f"{name}={value}" for (name, _), value in zip(varied, where[0], strict=True))
    more = f", and in {counted(len(where) - 1, 'other combination')}" if len(where) > 1 else ""
    return f" (with {first}{more})"


def _columns(varied: Sequence[Choice], where: Sequence[Combination]) -> Iterator[tuple[Choice, set[str]]]:
    for index, choice in enumerate(varied):
        yield choice, {combination[index] for combination in where}


def _summary(varied: Sequence[Choice], tried: int, failed: int) -> str:
    """Return how many combinations were tried and how many of them have errors."""
    if not varied:
        return "no argument with a list of values is left open; compiled once, " + ("with errors" if failed else "fine")
    count = prod(len(values) for _, values in varied)
    names = ", ".join(name for name, _ in varied)
    result = f"{failed:,} with errors" if failed else "all fine"
    if tried < count:
        return f"{tried:,} of {count:,} combinations of {names} compiled, {result}; set some of them for the others"
    return f"{counted(count, 'combination')} of {names} compiled, {result}"

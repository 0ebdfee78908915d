"""rosorin-compile diff: compare two robots by meaning, whatever they were written in."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rosorin_compile.source.console import Console

from .answer import give_result
from .command import Options, command, option
from .given import named
from .options import Decorator, page_options, robot_options, words_argument
from .robots import one, take_stdin
from .run import Run, write_page
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.compare.difference import Difference, Side
    from rosorin_compile.output.diff_inputs import Read


_SIDES = ("A", "B")


class _Tolerance(click.ParamType):  # type: ignore[type-arg] # not generic before click 8.4
    """A finite number from zero upwards."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        try:
            number = float(value)
        except ValueError:
            number = -1.0
        if not (0 <= number < math.inf):
            self.fail(f'"{value}" is no number from zero upwards', param, ctx)
        return number


TOLERANCE = _Tolerance()


def _robots() -> Decorator[Any]:
    """Return the argument for two robots, with the endings of files that can be read."""
    from rosorin_compile.formats import FORMATS

    *others, last = FORMATS.endings()
    return words_argument(
        "A B",
        f"robots to compare: name, folder or file of a description, or a {', '.join(others)} or {last} file",
        required=True,
        offers=("robot",),
    )


@command("diff", exits="0 equal, 1 differences or errors")
@_robots()
@option("--a-arg", multiple=True, metavar="NAME=VALUE", help="set an argument of A only")
@option("--b-arg", multiple=True, metavar="NAME=VALUE", help="set an argument of B only")
@option("--prefix", metavar="TEXT", help="prefix of all names in B; default: detected")
@option(
    "--tolerance",
    type=TOLERANCE,
    metavar="NUMBER",
    help="largest difference to ignore, in metres, radians or relative to the number; default: 1e-9",
)
@option("--full", is_flag=True, help="print all differences")
@page_options("write a page that shows both robots and their differences")
@robot_options
def run(options: Options) -> int:
    """Compare two robots; say what differs."""
    from rosorin_compile.compare.diff import compare_robots
    from rosorin_compile.compare.difference import DEFAULT_TOLERANCE, as_json, lines
    from rosorin_compile.source.load import LoadError

    run = Run.of(options)
    given, words = run.given, run.words
    if len(words) != 2:
        raise WrongUsage(f"diff compares two robots, and was given {len(words)}: {', '.join(words) or 'none'}")
    take_stdin(words)
    try:
        arguments = given.values()
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    own = [{**arguments, **named(texts)} for texts in (options.a_arg, options.b_arg)]
    read = [_read(word, values, given.packages, given.trust) for word, values in zip(words, own, strict=True)]
    sides = _sides(read, words, run.console)
    if sides is None:
        return PROBLEMS
    _check_arguments(options, read, words, bool(arguments))
    tolerance = DEFAULT_TOLERANCE if options.tolerance is None else options.tolerance
    found = compare_robots(*sides, tolerance, options.prefix)
    each = options.full or options.format != "text"
    left = [line for word, side in zip(words, read, strict=True) for line in side.lines(word, each)]
    found = replace(found, not_compared=(*found.not_compared, *left))
    try:
        give_result(options, as_json(found), lambda: "\n".join(lines(found, options.full)))
        if options.html is not None:
            sys.stdout.flush()
    finally:  # also where nobody reads to the end
        if options.html is not None:
            _write_page(run, words, found)
    return FINE if found.same else PROBLEMS


def _write_page(run: Run, words: Sequence[str], found: Difference) -> None:
    """Write the page that shows B with A under it. Raises WrongUsage."""
    from rosorin_compile.viewer.changed import Pictures

    options = run.options
    page = Pictures(Path(options.html), not options.no_meshes, options.max_megabytes)
    requests = []
    for word, own in zip(words, (options.a_arg, options.b_arg), strict=True):
        request = replace(run.request(one(word, "rosorin-compile diff A B")), warn=None)
        requests.append(replace(request, arguments={**request.arguments, **named(own)}))
    page.take_sides(requests, found, options.prefix)
    write_page(page, Console(options.format))


def _read(word: str, arguments: dict[str, Any], packages: Mapping[str, Path], trust: bool) -> Read:
    from rosorin_compile.output.diff_inputs import read_side
    from rosorin_compile.source.project import NoDescription

    try:
        return read_side(word, arguments, packages, trust)
    except NoDescription as problem:
        raise WrongUsage(str(problem)) from None


def _check_arguments(options: Options, read: list[Read], words: list[str], both: bool) -> None:
    """Refuse an argument of a file that has none: only a description and a xacro have. Raises WrongUsage."""
    deaf = [one.deaf for one in read]
    for is_deaf, word, own, side in zip(deaf, words, (options.a_arg, options.b_arg), _SIDES, strict=True):
        if is_deaf and own:
            raise WrongUsage(
                f"--{side.lower()}-arg {own[0]}: {word} has no arguments; only a description and a xacro do"
            )
    if all(deaf) and both:
        raise WrongUsage("neither of the two has arguments; only a description and a xacro do")


def _sides(read: list[Read], words: list[str], console: Console) -> tuple[Side, Side] | None:
    """Return both sides; None, after saying what is wrong, if one of them cannot be read."""
    for word, side in zip(words, read, strict=True):
        console.show(side.diagnostics)
        if side.side is None:
            console.warn(f"{word}: cannot be compared")
    first, second = read[0].side, read[1].side
    return (first, second) if first is not None and second is not None else None

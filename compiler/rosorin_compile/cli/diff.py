"""rosorin-compile diff: compare two robots by meaning, in any supported formats."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.cli.console import Console
from rosorin_compile.language.arguments import NO_ARGUMENTS
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.load import LoadError

from .answer import FINE, PROBLEMS
from .command import Decorator, Options, command, flag, option, page_options, robot_options, texts, words_argument
from .run import Run, find_robot, named, take_stdin, write_page

if TYPE_CHECKING:
    from rosorin_compile.compare.difference import Difference, Item, Side

_HOW = "rosorin-compile diff A B"


def _robots() -> Decorator[Any]:
    """Return the argument for two robots, with the endings of files that can be read."""
    from rosorin_compile.formats import FORMATS

    *others, last = FORMATS.endings()
    help = f"robots to compare: name, folder or file of a description, or a {', '.join(others)} or {last} file"
    return words_argument("A B", help, required=True, offers=("robot",))


@command("diff", exits="0 equal, 1 differences or errors")
@_robots()
@texts("--a-arg", metavar="NAME=VALUE", help="set an argument of A only")
@texts("--b-arg", metavar="NAME=VALUE", help="set an argument of B only")
@option("--prefix", metavar="TEXT", help="prefix of all names in B; default: detected")
@option(
    "--tolerance",
    default="1e-9",
    metavar="NUMBER",
    help="largest difference to ignore, in metres, radians or relative to the number; default: 1e-9",
)
@flag("--full", help="print all differences")
@page_options("write a page that shows both robots and their differences")
@robot_options
def run(options: Options) -> int:
    """Compare two robots, and print the differences."""
    from rosorin_compile import api
    from rosorin_compile.compare.difference import lines

    run = Run.of(options)
    if len(run.words) != 2:
        raise RequestError(
            f"diff compares two robots, and was given {len(run.words)}: {', '.join(run.words) or 'none'}"
        )
    try:
        tolerance = float(options.tolerance)
    except ValueError:
        tolerance = math.nan
    if not 0 <= tolerance < math.inf:
        raise RequestError(f'--tolerance: "{options.tolerance}" is no number from zero upwards')
    take_stdin(run.words)
    own = [named(options.a_arg), named(options.b_arg)]
    descriptions = [find_robot(word, _HOW) for word in run.words]
    requests = [replace(run.request(one), warn=None) for one in descriptions]
    try:
        values = requests[0].values()
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    a, b = run.words
    found = api.diff(
        a,
        b,
        tolerance,
        options.prefix,
        arguments=values,
        a_arguments=own[0],
        b_arguments=own[1],
        packages=run.packages,
        brief=options.format == "text" and not options.full,
        trust=options.trust,
    )
    if refused := [one for one in found.diagnostics if one.help == NO_ARGUMENTS]:
        raise RequestError(refused[0].message)
    run.console.show(found.diagnostics)
    if found.a is None or found.b is None:
        run.console.warn(f"{' and '.join(run.words)}: cannot be compared")
        return PROBLEMS
    try:
        run.give(as_json(found), lambda: "\n".join(lines(found, options.full)))
        if options.html is not None:
            sys.stdout.flush()
    finally:  # also if nobody reads to the end
        if options.html is not None:
            pairs = zip(requests, own, strict=True)
            _write_page(options, [replace(one, arguments={**one.arguments, **more}) for one, more in pairs], found)
    return FINE if found.same else PROBLEMS


def _write_page(options: Options, requests: Sequence[Any], found: Difference) -> None:
    """Write the page that shows B with A under it. Raises RequestError."""
    from rosorin_compile.viewer.changed import Pictures

    page = Pictures(Path(options.html), not options.no_meshes, options.max_megabytes)
    page.take_sides(requests, found, options.prefix)
    write_page(page, Console(options.format))


def as_json(difference: Difference) -> dict[str, Any]:
    """Return a comparison as a value of JSON. Raises ValueError if there was nothing to compare."""
    return {
        **{letter: _side_json(side) for letter, side in zip("ab", difference.sides, strict=True)},
        "same": difference.same,
        "tolerance": difference.tolerance,
        "differences": [_item_json(item) for item in difference.items],
        "notes": list(difference.notes),
        "not_compared": list(difference.not_compared),
        "summary": difference.summary(),
    }


def _side_json(side: Side) -> dict[str, Any]:
    robot = side.robot
    counts = {"links": len(robot.links), "joints": len(robot.joints)}
    return {"source": side.label, "format": side.format.name, "robot": robot.name, **counts}


def _item_json(item: Item) -> dict[str, Any]:
    found: dict[str, Any] = {"kind": item.kind, "name": item.name, "quantity": item.quantity, "text": item.text}
    found |= {"a": item.before, "b": item.after, "unit": item.unit}
    more = {"distance": item.distance, "angle": item.angle, "when": item.when or None, "at": dict(item.at) or None}
    return found | {key: value for key, value in more.items() if value is not None}

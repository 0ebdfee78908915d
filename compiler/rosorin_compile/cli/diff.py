"""rosorin-compile diff: compare two robots by meaning, in any supported formats."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from rosorin_compile import api
from rosorin_compile.compare.difference import Difference, lines
from rosorin_compile.formats import FORMATS
from rosorin_compile.language.arguments import NO_ARGUMENTS
from rosorin_compile.source.diagnostics import RequestError

from .command import command, flag, option, page_options, repeatable, robot_options, words_argument
from .console import FINE, PROBLEMS
from .run import Run, take_stdin

_OPTIONAL = ("distance", "angle", "when", "at")


@command("diff", exits="0 equal, 1 differences or errors")
@words_argument(
    "A B",
    f"robots to compare: name, folder or file of a description, or a {', '.join(FORMATS.endings())} file",
    required=True,
    offers=("robot",),
)
@repeatable("--a-arg NAME=VALUE", help="set an argument of A only")
@repeatable("--b-arg NAME=VALUE", help="set an argument of B only")
@option("--prefix TEXT", help="prefix of all names in B; default: detected")
@option("--tolerance NUMBER", default=1e-9, help="largest difference to ignore, in m, rad or relative to the number")
@flag("--full", help="print all differences")
@page_options("write a page that shows both robots and their differences")
@robot_options
def run_diff(run: Run) -> int:
    """Compare two robots, and print the differences."""
    if len(run.words) != 2:
        raise RequestError(f"diff compares two robots, not {len(run.words)}: {', '.join(run.words) or 'none'}")
    if not 0 <= run.tolerance < float("inf"):
        raise RequestError(f'--tolerance: "{run.tolerance}" is not a number from zero upwards')
    take_stdin(run.words)
    requests = [replace(run.request(run.find_robot(word)), warn=None) for word in run.words]
    values = requests[0].values()
    settings = {"a_arguments": run.a_arg, "b_arguments": run.b_arg, "packages": run.packages}
    settings |= {"trust": run.trust, "brief": run.format == "text" and not run.full}
    first, second = run.words
    found = api.diff(first, second, run.tolerance, run.prefix, arguments=values, **settings)
    if refused := [one for one in found.diagnostics if one.help == NO_ARGUMENTS]:
        raise RequestError(refused[0].message)
    run.console.show(found.diagnostics)
    if found.a is None or found.b is None:
        run.console.warn(f"{' and '.join(run.words)}: cannot be compared")
        return PROBLEMS
    run.give(as_json(found), lambda: "\n".join(lines(found, run.full)))
    if run.html is not None:
        from rosorin_compile.viewer.changed import Pictures

        page = Pictures(Path(run.html), not run.no_meshes, run.max_megabytes)
        pairs = zip(requests, (run.a_arg, run.b_arg), strict=True)
        page.take_sides([replace(one, arguments={**one.arguments, **own}) for one, own in pairs], found, run.prefix)
        run.write_page(page)
    return FINE if found.same else PROBLEMS


def as_json(difference: Difference) -> dict[str, Any]:
    """Return a comparison as a value of JSON, as the schema robot_diff describes."""
    found: dict[str, Any] = {}
    for letter, side in zip("ab", difference.sides, strict=True):
        counts = {"links": len(side.robot.links), "joints": len(side.robot.joints)}
        found[letter] = {"source": side.label, "format": side.format.name, "robot": side.robot.name, **counts}
    found |= {name: getattr(difference, name) for name in ("same", "tolerance", "notes", "not_compared")}
    items = [{"a": item.before, "b": item.after, **vars(item)} for item in difference.items]
    for item in items:
        for name in ("before", "after", *(name for name in _OPTIONAL if not item[name] and item[name] != 0)):
            del item[name]
    return {**found, "differences": items, "summary": difference.summary()}

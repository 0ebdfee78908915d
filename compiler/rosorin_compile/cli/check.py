"""rosorin-compile check: compile each robot and compare with what is committed.

With --every-argument a robot is compiled with every combination of the arguments that have a list of values. What else
there is to check, ``check NAME``, comes from other packages by their records.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from functools import partial
from itertools import islice
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.language.arguments import Argument, Choice, Combination, combinations
from rosorin_compile.source.diagnostics import Diagnostic, arrange, error, has_errors
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import ON_STDIN, Description
from rosorin_compile.source.wording import counted
from rosorin_compile.viewer.changed import Pictures

from .command import Options, command, option
from .options import check_options, depfile_options, hook_option, notes_option, page_options
from .registry import checks
from .robots import check_depfile
from .run import Run, console_of, count, for_each, nothing_written, write_depfile, write_page
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.output.check_outputs import Committed
    from rosorin_compile.source.markdown import Block


def _checks() -> dict[str, list[tuple[str, str]]]:
    """Return the checks for the help."""
    return {"Checks (see check CHECK --help)": [(one.name, one.help) for one in checks().values()]}


@command("check", exits="0 no differences, 1 differences or errors", sections=_checks)
@check_options("[CHECK] [ROBOT ...]", offers=("checks", "robot", "argument"))
@hook_option()
@notes_option
@option(
    "--every-argument",
    is_flag=True,
    help="compile with all combinations of arguments that have a list of values; do not compare",
)
@option("--full", is_flag=True, help="print differences of texts in full")
@page_options("write a page that shows the robots, as committed and as compiled, and the changes")
@depfile_options("required with --depfile")
def run(options: Options) -> int:
    """Compile each robot and compare with what is committed."""
    _check_options(options)
    if options.every_argument:
        return for_each(options, check_every)
    if options.html is None:
        return for_each(options, check_one)
    page = Pictures(Path(options.html), not options.no_meshes, options.max_megabytes)
    each = partial(check_one, page=page)
    try:
        code = for_each(options, each)
    except BrokenPipeError:  # who reads the messages has enough of them; the page is for somebody else
        page.clear()
        with Path(os.devnull).open("w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
            for_each(options, each)
            write_page(page, console_of(options))
        raise
    write_page(page, console_of(options))
    return code


def _check_options(options: Options) -> None:
    """Raise WrongUsage for options that do not go together, and for a depfile that cannot be."""
    if options.every_argument and options.html is not None:
        raise WrongUsage("--html shows a comparison with what is committed; it does not go with this option")
    check_depfile(options)
    if options.depfile is None:
        return
    if options.every_argument:
        raise WrongUsage("--depfile is about what is committed: it does not go with --every-argument")
    if options.depfile_target is None:
        raise WrongUsage("a depfile needs a target: --depfile-target NAME")


def check_one(run: Run, description: Description, page: Pictures | None = None) -> int:
    """Compile one robot and compare it with its outputs folder; ``page`` shows the changes."""
    from rosorin_compile import api

    console, request = run.console, run.request(description)
    if description.path == ON_STDIN:
        compiled = run.compiled(description)
        if compiled is None:
            return PROBLEMS
        console.say(f"{description.name}: {count(compiled.artifacts)} compiled; there are no committed ones")
        return FINE
    checked = api.check(request)
    compiled, committed = checked.compiled, checked.committed
    console.tell_read(request.inputs(compiled))
    console.show(checked.diagnostics)
    if committed is None:
        nothing_written(console, description.name, compiled.diagnostics)
        return PROBLEMS
    if committed.comparison is None:
        return PROBLEMS
    if page is not None:
        page.take(request, compiled, committed.comparison, committed.committed, committed.meshes)
    if not committed.same:
        _differ(run, committed)
        _tell_no_folder(run, description)
        return PROBLEMS
    if has_errors(committed.diagnostics):
        return PROBLEMS
    found = count(compiled.artifacts, compiled.mesh_files)
    console.say(f"{description.name}: {found} as committed in {description.outputs}")
    if run.options.depfile is None:
        return FINE
    files = [description.outputs / name for name in committed.committed]
    watched = request.watched(compiled, [Path(run.options.depfile)])
    return write_depfile(run, run.options.depfile_target, [*watched, *files])


def _differ(run: Run, committed: Committed) -> None:
    """Say how committed files differ."""
    said = committed.lines(full=getattr(run.options, "full", False))
    told = error("outputs-differ", "\n".join(said), None, "rosorin-compile all writes them anew")

    def blocks() -> list[Block]:
        from rosorin_compile.compare.text_report import blocks

        comparison = committed.comparison
        return blocks(comparison.changes, comparison.texts, committed.meshes) if comparison is not None else []

    run.console.differ("not as committed", said, told, blocks)


def _tell_no_folder(run: Run, description: Description) -> None:
    """Say that the folder of -o, as a build file may name it, has nothing of a robot."""
    if run.options.output is not None and not description.outputs.is_dir():
        way = "rosorin-compile all with the same -o and arguments writes it"
        run.console.warn(f"{description.name}: there is no folder {description.outputs}; {way}")


MAX_COMBINATIONS = 256


def check_every(run: Run, description: Description) -> int:
    """Compile one robot in memory with every combination; each problem is said once, with the arguments it comes by."""
    from rosorin_compile.language.arguments import declared
    from rosorin_compile.source.load import LoadError

    request = run.request(description)
    try:
        given = request.values()
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    arguments, wrong = declared(description.path, given, request.packages)
    if has_errors(wrong):
        run.console.show(wrong)
        return PROBLEMS
    varied = Argument.choices(arguments, given)
    tried = list(islice(combinations(varied), MAX_COMBINATIONS))
    found: dict[Diagnostic, list[Combination]] = {}
    for number, combination in enumerate(tried, 1):
        Progress.about(f"{description.name}, {number:,} of {len(tried):,}:")
        texts = dict(zip((name for name, _ in varied), combination, strict=True))
        compiled = replace(request, arguments={**given, **texts}, argument_files=()).compile()
        for diagnostic in compiled.diagnostics:
            if diagnostic.severity != "note":
                found.setdefault(diagnostic, []).append(combination)
        request = replace(request, warn=_ignore)  # the first combination has printed the warnings
    said = [replace(d, message=d.message + _with(varied, tried, where)) for d, where in found.items()]
    run.console.show(arrange(said))
    failed = {one for diagnostic, where in found.items() if diagnostic.severity == "error" for one in where}
    run.console.say(f"{description.name}: {_summary(varied, len(tried), len(failed))}")
    return PROBLEMS if failed else FINE


def _ignore(_diagnostic: Diagnostic) -> None:
    """Do nothing."""


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

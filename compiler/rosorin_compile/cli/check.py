"""rosorin-compile check: compile each robot and compare with what is committed.

With --every-argument a robot is compiled with every combination of the arguments that have a list of values. What else
there is to check, ``check NAME``, comes from other packages by their records.
"""

from __future__ import annotations

import argparse
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
from rosorin_compile.source import files
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import ON_STDIN, Description
from rosorin_compile.source.rule_registry import WRITING, Rule
from rosorin_compile.source.wording import counted

from .compiling import count, folders_looked_in, read_by, search_meshes, tell_build, warn_before
from .pictures import pictures
from .registry import checks
from .robots import check_depfile
from .run import Run, console_of, for_each
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.language.expand.included_robots import Tell
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.markdown import Block

    from .comparing import Checked
    from .parser import Parser
    from .pictures import Pictures

RULES = (
    Rule(
        "outputs-differ",
        "The committed artifacts are not those of the description (in the forms for programs).",
        "`rosorin-compile all`, if that is what you meant.",
        WRITING,
    ),
    Rule(
        "engine-refuses",
        "The engine that an artifact is for does not load it, or cannot find or read a mesh. `check` asks MuJoCo, "
        "where it is installed; of one that is too old, it is a warning.",
        "As the message says; a mesh is looked for from the folder of the artifact.",
        WRITING,
    ),
)


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_check_options(hook=True)
    command.add_notes()
    command.listed, command.formatter_class = _listed, argparse.RawDescriptionHelpFormatter
    command.add_argument(
        "--every-argument",
        action="store_true",
        help="compile with all combinations of arguments that have a list of values; do not compare",
    )
    command.add_argument("--full", action="store_true", help="print differences of texts in full")
    command.add_page("write a page that shows the robots, as committed and as compiled, and the changes")
    command.add_depfile("required with --depfile")


def _listed() -> str:
    """Return the checks as the help lists them."""
    every = checks().values()
    width = max(len(one.name) for one in every)
    lines = "".join(f"\n  {one.name:<{width}}  {one.help}" for one in every)
    return f"\nother checks (run rosorin-compile check CHECK --help for their options):{lines}"


def run(options: argparse.Namespace) -> int:
    """Compile each robot and compare with what is committed."""
    _check_options(options)
    if options.every_argument:
        return for_each(options, check_every)
    if options.html is None:
        return for_each(options, check_one)
    page = pictures(options)
    each = partial(check_one, page=page)
    try:
        code = for_each(options, each)
    except BrokenPipeError:  # who reads the messages has enough of them; the page is for somebody else
        page.clear()
        with Path(os.devnull).open("w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
            for_each(options, each)
            page.write(console_of(options))
        raise
    page.write(console_of(options))
    return code


def _check_options(options: argparse.Namespace) -> None:
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
    """Compile one robot in memory and compare with its outputs folder; ``page`` takes what it shows of that."""
    if page is not None:  # they are taken of what is compiled
        return _compare(run, description, page)
    return _compare(run, description, None)


def _compare(run: Run, description: Description, page: Pictures | None) -> int:
    """Do the same, whether or not it was done before."""
    from rosorin_compile.source.diagnostics import has_errors

    from .comparing import compared

    compiled = run.compiled(description)
    if compiled is None or compiled.robot is None:
        return PROBLEMS
    if description.path == ON_STDIN:
        run.console.say(f"{description.name}: {count(compiled.artifacts)} compiled; there are no committed ones")
        return FINE
    held = compared(run.given, description, compiled)
    run.console.show(held.diagnostics)
    if held.comparison is None:
        return PROBLEMS
    if page is not None:
        page.take(run.given, description, compiled, held.comparison, held.committed, held.meshes)
    if not held.same:
        _differ(run, held)
        _tell_no_folder(run, description)
        return PROBLEMS
    if has_errors(held.diagnostics):
        return PROBLEMS
    found = count(compiled.artifacts, compiled.mesh_files)
    run.console.say(f"{description.name}: {found} as committed in {description.outputs}")
    files = [description.outputs / name for name in held.committed]
    if run.options.depfile is None:
        return FINE
    looked_in = folders_looked_in(compiled, [Path(run.options.depfile)])
    return tell_build(run, run.options.depfile_target, [*read_by(run.given, compiled), *files, *looked_in])


def _differ(run: Run, held: Checked) -> None:
    """Say how committed files differ."""
    from rosorin_compile.source.diagnostics import error

    said = held.lines(full=getattr(run.options, "full", False))
    told = error("outputs-differ", "\n".join(said), None, "rosorin-compile all writes them anew")

    def blocks() -> list[Block]:
        from rosorin_compile.compare.tables import blocks

        comparison = held.comparison
        return blocks(comparison.changes, comparison.texts, held.meshes) if comparison is not None else []

    run.console.differ("not as committed", said, told, blocks)


def _tell_no_folder(run: Run, description: Description) -> None:
    """Say that the folder of -o, as a build file may name it, has nothing of a robot."""
    if run.options.output is not None and not files.is_folder(description.outputs):
        way = "rosorin-compile all with the same -o and arguments writes it"
        run.console.warn(f"{description.name}: there is no folder {description.outputs}; {way}")


MAX_COMBINATIONS = 256


def check_every(run: Run, description: Description) -> int:
    """Compile one robot in memory with every combination; each problem is said once, with the arguments it comes by."""
    from rosorin_compile.language.arguments import declared
    from rosorin_compile.output.pipeline import compile_robot
    from rosorin_compile.source.diagnostics import arrange, has_errors
    from rosorin_compile.source.load import LoadError

    try:
        given = run.given.values()
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    arguments, wrong = declared(description.path, given, run.given.packages)
    if has_errors(wrong):
        run.console.show(wrong)
        return PROBLEMS
    varied = Argument.choices(arguments, given)
    tried = list(islice(combinations(varied), MAX_COMBINATIONS))
    found: dict[Diagnostic, list[Combination]] = {}
    tell: Tell = warn_before(run.given, run.console)
    search = partial(search_meshes, run.given, description)
    for number, combination in enumerate(tried, 1):
        Progress.about(f"{description.name}, {number:,} of {len(tried):,}:")
        texts = dict(zip((name for name, _ in varied), combination, strict=True))
        compiled = compile_robot(description.path, {**given, **texts}, tell, run.given.packages, search)
        for diagnostic in compiled.proven().diagnostics:
            if diagnostic.severity != "note":
                found.setdefault(diagnostic, []).append(combination)
        tell = _already_told
    said = [replace(d, message=d.message + _with(varied, tried, where)) for d, where in found.items()]
    run.console.show(arrange(said))
    failed = {one for diagnostic, where in found.items() if diagnostic.severity == "error" for one in where}
    run.console.say(f"{description.name}: {_summary(varied, len(tried), len(failed))}")
    return PROBLEMS if failed else FINE


def _already_told(_diagnostic: Diagnostic) -> None:
    """Take what has to be said before anything is run: the first combination said it."""


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

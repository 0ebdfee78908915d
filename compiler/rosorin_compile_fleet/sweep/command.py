"""rosorin-compile sweep: compile one description with the arguments of many variants, each into a folder of its own."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.diagnostics import NOTE, WARNING, Console, Diagnostic, Heading, Rule, counted, listed
from rosorin_compile.extending import (
    FINE,
    PROBLEMS,
    Argument,
    Description,
    Given,
    LoadError,
    OutputError,
    Run,
    WrongUsage,
    give_result,
    world,
)

from .engines import Engine, InProcess, Processes
from .folder import Index
from .making import Folder, Job, Maker, job, plain
from .remote import RemoteIndex, folder_of
from .report import Teller
from .running import Asked, Counts, Stopped, forgotten
from .running import run as run_all
from .variants import Variants

if TYPE_CHECKING:
    from rosorin_compile.extending import Parser


RULES = (
    Rule(
        "variant-forgotten",
        "A note: a variant that was made before is not in the list any more; its folder is kept.",
        "`rosorin-compile sweep --prune` removes it.",
        Heading.WRITING,
    ),
    Rule(
        "variant-outdated",
        "A warning: a file was changed while variants were made of it, or the artifacts of one were edited.",
        "As the message says.",
        Heading.WRITING,
    ),
)

_HOW = "rosorin-compile sweep ROBOT --over FILE -o FOLDER"
_NO_LOCKS = "this system has no locks (fcntl): nothing keeps another run from writing into the same folder"
_TOLD = 5  # names of variants in a message


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_robot()
    command.add_argument(
        "--over",
        required=True,
        type="path",
        metavar="LIST",
        completes="FILE",
        help="the variants: a CSV or YAML file with a row or entry each, or a folder with a file of arguments each",
    )
    command.add_argument(
        "-o",
        "--output",
        required=True,
        type="path",
        metavar="FOLDER",
        help="where each variant gets a folder, beside sweep.json",
    )
    command.add_argument(
        "-j", "--jobs", type=_jobs, metavar="NUMBER", help="how many are made at once; default: one a core"
    )
    command.add_argument(
        "--as",
        default="",
        dest="whole",
        metavar="ARGUMENT",
        help="with a folder: the argument that gets each file as a whole, or its path where it is a text",
    )
    command.add_argument(
        "--dask", type="path", metavar="ADDRESS", help="make them on a cluster of dask: tcp://HOST:8786"
    )
    command.add_argument(
        "--ninja",
        type="path",
        metavar="FILE",
        help="make nothing: write a build file for Ninja with a target a variant; paths in it are seen from its folder",
    )
    command.add_argument("--prune", action="store_true", help="remove variants that are not in the list any more")
    command.add_messages()
    command.add_given()


def _jobs(text: str) -> int:
    if not text.isdecimal() or not 0 < int(text) < 1_000:
        raise argparse.ArgumentTypeError("how many at once is a number from 1 on")
    return int(text)


class Sweep(NamedTuple):
    """What a sweep was asked for."""

    options: argparse.Namespace
    console: Console
    given: Given
    description: Description
    variants: Variants
    folder: Folder


def run(options: argparse.Namespace) -> int:
    """Make the variants of a list."""
    run, description = Run.alone(options, "a sweep is of one robot", _HOW, "name a file")
    given, console = run.given, run.console
    console.begin(description.name)
    try:
        shared = given.values()
        variants, wrong = _listed(options, shared, given, description)
        if wrong:
            raise _Refused(wrong)
        if options.ninja is not None:
            return _write_ninja(options, console, given, description, variants)
        sweep = Sweep(options, console, given, description, variants, folder_of(options.output))
        made = job(description, shared, given.packages, given.trust, sweep.folder.base)
        code = _made(sweep, made)
    except (LoadError, OutputError, Stopped) as problem:
        console.show([problem.diagnostic])
        code = PROBLEMS
    except _Refused as problem:
        console.show(problem.diagnostics)
        console.warn(f"{options.over}: {counted(len(problem.diagnostics), 'error')}, nothing written")
        code = PROBLEMS
    console.end(code != FINE)
    console.finish()
    return code


def _write_ninja(
    options: argparse.Namespace, console: Console, given: Given, description: Description, variants: Variants
) -> int:
    """Write the build file of the variants; return the exit code. Raises OutputError, LoadError."""
    from .ninja import Asked as AskedOfNinja
    from .ninja import write

    for option, given_too in (("--prune", options.prune), ("--dask", options.dask), ("-j", options.jobs)):
        if given_too:
            raise WrongUsage(f"--ninja makes nothing itself: it does not go with {option}")
    if "://" in options.output:
        raise WrongUsage("Ninja sees files of this machine alone: -o is a folder here")
    file = Path(options.ninja)
    count = write(AskedOfNinja(file, description, variants, given, Path(options.output), options.whole))
    console.say(f"{file}: {counted(count, 'variant')} for ninja")
    result = {"description": str(description.path), "folder": options.output, "ninja": str(file)}
    give_result(options, result, str)
    console.end(False)
    console.finish()
    return FINE


class _Refused(Exception):
    """The list is none; carries why."""

    def __init__(self, diagnostics: list[Diagnostic]) -> None:
        super().__init__()
        self.diagnostics = diagnostics


def _listed(
    options: argparse.Namespace, shared: Mapping[str, Any], given: Given, description: Description
) -> tuple[Variants, list[Diagnostic]]:
    """Return the list of variants, and what is wrong with it as a whole. Raises WrongUsage."""
    arguments, wrong = Argument.declared(description.path, shared, given.packages)
    types = {argument.name: argument.type for argument in arguments}
    path = Path(options.over)
    if options.whole and world.kind(path) != world.FOLDER:
        raise WrongUsage("--as goes with a folder of files, one a variant")
    wrong = [problem for problem in wrong if problem.severity == "error"]
    if options.whole and options.whole not in types and not wrong:
        from rosorin_compile.diagnostics import did_you_mean

        known = did_you_mean(options.whole, types) or "it has none"
        raise WrongUsage(f'{description.name} has no argument "{options.whole}"; {known}')
    by_path = types.get(options.whole) == "text"
    variants = Variants(path, list(types), options.whole, by_path, description.path.parent)
    return variants, wrong or variants.check()


def _made(sweep: Sweep, made: Job) -> int:
    """Make all variants; return the exit code. Raises OutputError, LoadError, Stopped."""
    counts, teller = Counts(len(sweep.variants)), Teller(sweep.console)
    maker = Maker(made, sweep.folder)
    world.needs("fcntl", _NO_LOCKS)
    try:
        with sweep.folder.opened(), _engine(sweep, made) as engine:
            index = sweep.folder.index()
            asked = Asked(sweep.variants, maker.made_before, engine, index.outdate)
            head: dict[str, object] = {"description": sweep.folder.named(sweep.description.path)}
            if made.shared:
                head["arguments"] = plain(made.shared)
            try:
                run_all(asked, index, counts, teller.take, head)
            except BaseException:
                index.leave()
                raise
            _forget(sweep, index)
            index.close()
            stored = sweep.folder.sweep_up()
    except OSError as problem:
        raise sweep.folder.explained(problem) from None
    except KeyboardInterrupt:
        done = f"{counts.done:,} of {counted(counts.total, 'variant')} done"
        sweep.console.warn(f"stopped: {done}; the same command goes on from there")
        raise
    _tell_changed(sweep, counts, Maker(made, sweep.folder))
    teller.finish(counts, stored)
    result = {"description": str(sweep.description.path), "folder": str(sweep.options.output), **counts.by_state}
    give_result(sweep.options, result, str)
    return PROBLEMS if counts.by_state["error"] else FINE


@contextmanager
def _engine(sweep: Sweep, made: Job) -> Iterator[Engine]:
    count = min(sweep.options.jobs or world.cores(), len(sweep.variants))
    if sweep.options.dask:
        from .cluster import Cluster, connect

        engine: Engine = Cluster(made, sweep.folder, connect(sweep.options.dask), len(sweep.variants))
    else:
        engine = InProcess(made, sweep.folder) if count < 2 else Processes(made, sweep.folder, count)
    try:
        yield engine
    finally:
        engine.close()


def _forget(sweep: Sweep, index: Index | RemoteIndex) -> None:
    """Say which variants are not in the list any more, or remove their artifacts."""
    first: list[str] = []
    count = 0
    for name in forgotten(sweep.folder, sweep.variants.names):
        count += 1
        if sweep.options.prune:
            if count == 1:
                index.outdate()
            sweep.folder.drop(name)
        elif len(first) < _TOLD:
            first.append(name)
    if not count:
        return
    if sweep.options.prune:
        sweep.console.say(f"{counted(count, 'variant')} removed that {'is' if count == 1 else 'are'} not in the list")
        return
    names = listed(sorted(first)) if count <= _TOLD else f"{', '.join(sorted(first))} and {count - _TOLD:,} more"
    verb = "is" if count == 1 else "are"
    message = f"{counted(count, 'variant')} of {sweep.folder.address} {verb} not in the list, and kept: {names}"
    sweep.console.show([Diagnostic("variant-forgotten", NOTE, message, help="sweep --prune removes them")])


def _tell_changed(sweep: Sweep, counts: Counts, maker: Maker) -> None:
    """Say that a file was changed while variants were made of it, and that artifacts were edited."""
    said = []
    if not all(maker.fresh(made_of) for made_of in counts.made_of):
        message = "a file of the description was changed during the sweep: some variants were made before, some after"
        said.append(Diagnostic("variant-outdated", WARNING, message, help="the same command makes those anew"))
    if counts.edited:
        whose = "variant was" if counts.edited == 1 else "variants were"
        message = f"the artifacts of {counts.edited:,} {whose} not as they were written; they are made anew"
        said.append(Diagnostic("variant-outdated", WARNING, message, help="what is edited belongs into another folder"))
    sweep.console.show(said)

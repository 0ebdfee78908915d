"""rosorin-compile check: compile each robot and compare with what is committed.

With --every-argument a robot is compiled with every combination of the arguments that have a list of values, with
--parameters or --controllers the parameter files of its nodes are held against it; with --fleet the robots of a sweep
are checked as one.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from functools import partial
from itertools import islice, product
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..diagnostics.console import Console
from ..diagnostics.progress import about
from ..diagnostics.registry import PACKAGES, WRITING, Rule
from ..diagnostics.wording import counted, listed
from ..project import ON_STDIN, Description, too_long
from ..world import FOLDER, kind, spoil
from .compiling import (
    compile_proven,
    count,
    mesh_files,
    nothing_written,
    proven,
    read_by,
    search_meshes,
    tell_build,
    telling,
)
from .given import MARK, given_arguments
from .options import (
    console_of,
    depfile_options,
    format_options,
    hook_option,
    output_options,
    page_options,
    place,
    robot_options,
)
from .robots import Run, check_depfile, check_summary, for_each, is_foreign, once, one
from .understanding import understood
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from ..diagnostics import Diagnostic
    from ..diagnostics.markdown import Block
    from ..frontend.arguments import Argument
    from ..frontend.expand.included_robots import Tell
    from ..tools.package.checking import Checked
    from ..tools.view.changed import Pictures
    from .comparing import Held

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
    Rule(
        "deployed-differs",
        "A copy is not the compiled one (in the forms for programs).",
        "`rosorin-compile deploy`",
        PACKAGES,
    ),
)


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    robot_options(command)
    hook_option(command)
    command.add_argument(
        "--deployed", metavar="FOLDER", help="compare with the copies in a package, an install space or any folder"
    )
    command.add_argument(
        "--every-argument",
        action="store_true",
        help="compile with every combination of the arguments that have a list of values; nothing is compared",
    )
    command.add_argument(
        "--physics",
        action="store_true",
        help="look for what cannot be, too: parts inside each other, joints that drive them there, meshes of another"
        " size; with MuJoCo",
    )
    _parameter_options(command)
    command.add_argument(
        "--fleet",
        type=place,
        metavar="FILE",
        help="check the robots of a sweep.json as one: which numbers differ, which are likely typos, what stands in",
    )
    command.add_argument("--full", action="store_true", help="show text differences in full; with --fleet all numbers")
    command.add_argument(
        "--summary",
        type=place,
        metavar="FILE",
        help="append what --format markdown prints to a file, whatever the form of the messages",
    )
    page_options(
        command, "write a page that shows the robots, what is committed under what is compiled, and what changed"
    )
    output_options(command)
    depfile_options(command, "none, it has to be named")
    format_options(command)


def _parameter_options(command: argparse.ArgumentParser) -> None:
    """Add the options about the parameter files of nodes; they stand last in the help."""
    from ..formats.distributions import DISTRIBUTIONS

    group = command.add_argument_group("parameter files of the nodes of one robot; nothing is compared then")
    add = group.add_argument
    many: dict[str, Any] = {"nargs": "+", "action": "extend", "default": [], "type": place, "metavar": "FILE"}
    add("--parameters", **many, help="hold them against the description: who publishes which edge, frames, keys, types")
    add("--controllers", **many, help="the same of the file of a controller_manager: it has to name controllers")
    add("--launch", **many, help="with these: launch files that say remaps")
    add("--remap", action="append", default=[], metavar="NODE:FROM:=TO", help="with these: a remap")
    add("--namespace", default="", metavar="NS", help="with these: the namespace that the nodes run in")
    add(
        "--distribution",
        choices=DISTRIBUTIONS,
        help="with these: that of ROS 2; default: that of the outputs, else any of them",
    )


def run(options: argparse.Namespace) -> int:
    """Compile each robot and compare with what is committed."""
    if options.summary is not None:
        check_summary(Path(options.summary))
    if options.fleet is not None:
        spoil("what a fleet reads is not noted yet")
        from ..tools.fleet.command import check_fleet

        return check_fleet(options)
    # arguments of the description may stand behind files
    for words in (options.parameters, options.controllers, options.launch):
        options.words += [word for word in words if MARK in word]
        words[:] = [word for word in words if MARK not in word]
    if options.parameters or options.controllers or options.deployed or options.physics:
        spoil("what these options read is not noted yet")
    if options.parameters or options.controllers:
        return _check_parameters(options)
    if options.launch or options.remap or options.namespace or options.distribution:
        raise WrongUsage("--launch, --remap, --namespace and --distribution go with --parameters or --controllers FILE")
    _check_depfile(options)
    if options.html is None:
        return _run(options, check_one)
    spoil("a page is written")
    if options.every_argument or options.deployed is not None:
        raise WrongUsage("--html shows a comparison with what is committed; it does not go with this option")
    from ..tools.view.changed import Pictures

    pictures = Pictures(options)
    try:
        code = _run(options, partial(check_one, pictures=pictures))
    except BrokenPipeError:  # who reads the messages has enough of them; the page is for somebody else
        pictures.taken.clear()
        with Path(os.devnull).open("w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
            _run(options, partial(check_one, pictures=pictures))
            pictures.write(console_of(options))
        raise
    pictures.write(console_of(options))
    return code


def _run(options: argparse.Namespace, each: Callable[[Run, Description], int]) -> int:
    """Do with each robot what the options ask for; ``each`` compares it with what is committed."""
    if options.physics and (options.every_argument or options.deployed is not None):
        raise WrongUsage("--physics does not go with --every-argument or --deployed")
    if options.every_argument:
        if options.deployed is not None:
            raise WrongUsage("--every-argument and --deployed do not go together")
        return for_each(options, check_every)
    if options.physics:
        return _check_with_physics(options, each)
    if options.deployed is None:
        return for_each(options, each)
    if kind(options.deployed) != FOLDER:
        raise WrongUsage(too_long(Path(options.deployed)) or f'there is no folder "{options.deployed}"')
    names = given_arguments(options, options.words)[1]
    if not names:
        one("", "rosorin-compile check ROBOT --deployed FOLDER")
    return for_each(options, _check_deployed)


def _check_depfile(options: argparse.Namespace) -> None:
    """Raise WrongUsage for a depfile that cannot be."""
    check_depfile(options)
    if options.depfile is None:
        return
    if options.physics or options.every_argument or options.deployed is not None:
        raise WrongUsage(
            "--depfile is about what is committed: it does not go with --deployed, --every-argument, --physics"
        )
    if options.depfile_target is None:
        raise WrongUsage("a depfile needs a target: --depfile-target NAME")


def check_one(run: Run, description: Description, pictures: Pictures | None = None) -> int:
    """Compile one robot in memory and compare with its outputs folder; ``pictures`` take what a page shows of that."""
    if pictures is not None:  # they are taken of what is compiled
        return _compare(run, description, pictures)
    return once(run, description, lambda: _compare(run, description, None))


def _compare(run: Run, description: Description, pictures: Pictures | None) -> int:
    """Do the same, whether or not it was done before."""
    from ..diagnostics import has_errors
    from .comparing import compared

    compiled = compile_proven(run.given, description, run.console)
    run.console.show(compiled.diagnostics)
    if compiled.robot is None or has_errors(compiled.diagnostics):
        return nothing_written(run.console, description.name, compiled.diagnostics)
    if description.path == ON_STDIN:
        run.console.say(f"{description.name}: {count(compiled.artifacts)} compiled; there are no committed ones")
        return FINE
    held = compared(run.given, description, compiled)
    run.console.show(held.diagnostics)
    if held.comparison is None:
        return PROBLEMS
    if pictures is not None:
        pictures.take(run.given, description, compiled, held.comparison, held.committed, held.meshes)
    if not held.same:
        _differ(run, held)
        _tell_no_folder(run, description)
        return PROBLEMS
    if has_errors(held.diagnostics):
        return PROBLEMS
    found = count(compiled.artifacts, mesh_files(compiled))
    run.console.say(f"{description.name}: {found} as committed in {description.outputs}")
    files = [description.outputs / name for name in held.committed]
    if run.options.depfile is None:
        return FINE
    return tell_build(run, run.options.depfile_target, [*read_by(run.given, compiled), *files])


def _differ(run: Run, held: Held) -> None:
    """Say how committed files differ."""
    from ..diagnostics import error

    said = held.lines(full=getattr(run.options, "full", False))
    told = error("outputs-differ", "\n".join(said), None, "rosorin-compile all writes them anew")

    def blocks() -> list[Block]:
        from ..meaning.tables import blocks

        comparison = held.comparison
        return blocks(comparison.changes, comparison.texts, held.meshes) if comparison is not None else []

    run.console.differ("not as committed", said, told, blocks)


def _tell_no_folder(run: Run, description: Description) -> None:
    """Say that the folder of --outputs, as a build file may name it, has nothing of a robot."""
    if getattr(run.options, "outputs", None) is not None and kind(description.outputs) != FOLDER:
        way = "rosorin-compile all with the same --outputs and arguments writes it"
        run.console.warn(f"{description.name}: there is no folder {description.outputs}; {way}")


def _check_with_physics(options: argparse.Namespace, each: Callable[[Run, Description], int]) -> int:
    """Compare each robot with its outputs, unless it is in a file of another format, and check its physics."""
    from ..tools.physics.checking import lacking

    missing = lacking()
    if missing:
        raise WrongUsage(f"check --physics needs what is not installed: pip install {missing}")

    def both(run: Run, description: Description) -> int:
        compared = FINE if is_foreign(description.path) else each(run, description)
        return max(compared, _check_physics(run, description))

    return for_each(options, both)


def _check_physics(run: Run, description: Description) -> int:
    """Check the physics of one robot. What its description says wrongly was told before, unless it is foreign."""
    from ..diagnostics import has_errors
    from ..tools.physics.checking import look

    console = run.console if is_foreign(description.path) else Console("json")
    known = understood(run.given, description, console)
    if known is None:
        return PROBLEMS
    looked = look(known.case, description, run.given.packages)
    run.console.show(looked.diagnostics)
    severities = Counter(diagnostic.severity for diagnostic in looked.diagnostics)
    found = listed(counted(severities[one], one) for one in ("error", "warning", "note") if severities[one])
    run.console.say(f"{description.name}: physics of {looked.at}: {found or 'nothing to say'}")
    return PROBLEMS if has_errors(looked.diagnostics) else FINE


def _check_parameters(options: argparse.Namespace) -> int:
    """Hold the parameter files of nodes against one robot."""
    from ..tools.parameters.checking import asked, look, summary

    others = (options.physics, options.every_argument, options.deployed, options.depfile, options.html, options.hook)
    if any(others):
        raise WrongUsage(
            "--parameters and --controllers go with none of --physics, --every-argument, --deployed, --depfile, --html,"
            " --hook"
        )
    wanted = asked(options)
    names = given_arguments(options, options.words)[1]
    if len(names) != 1:
        options.words += [one("", "rosorin-compile check ROBOT --parameters FILE").name] if not names else []
    if len(names) > 1:
        raise WrongUsage("parameter files are those of one robot: rosorin-compile check ROBOT --parameters FILE")

    def held(run: Run, description: Description) -> int:
        from ..diagnostics import has_errors

        known = understood(run.given, description, run.console)
        if known is None:
            return PROBLEMS
        looked = look(known.case, wanted)
        run.console.show(looked.diagnostics)
        run.console.say(f"{description.name}: {summary(looked)}")
        return PROBLEMS if has_errors(looked.diagnostics) else FINE

    return for_each(options, held)


def _check_deployed(run: Run, description: Description) -> int:
    """Compile one robot in memory and compare with the copies that are deployed in a folder."""
    from ..diagnostics import error, has_errors
    from ..frontend.load import LoadError
    from ..tools.package import naming
    from ..tools.package.carrying import described
    from ..tools.package.checking import check
    from ..tools.package.finding import files_below

    compiled = compile_proven(run.given, description, run.console)
    run.console.show(compiled.diagnostics)
    if compiled.robot is None or has_errors(compiled.diagnostics):
        return nothing_written(run.console, description.name, compiled.diagnostics)
    folder = Path(run.options.deployed)
    try:
        files = files_below(folder, skip_built=False)
        told = naming.read(folder, compiled.robot.name)
        checked = check(
            compiled.robot,
            compiled.artifacts,
            folder,
            files,
            told,
            run.options.full,
            lambda options: described(compiled, description, run.given, options)[0],
        )
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    except OSError as problem:
        message = f"cannot read {folder}: {problem.strerror or problem}"
        run.console.show([error("deploy-unreadable", message, None, "name another folder")])
        return PROBLEMS
    return _said(run, description, checked)


def _said(run: Run, description: Description, checked: Checked) -> int:
    """Say what became of a comparison with copies, and return the exit code."""
    from ..diagnostics import error, has_errors

    if checked.differing:
        help = "rosorin-compile deploy writes them anew"
        told = error("deployed-differs", "\n".join(checked.lines), None, help)
        run.console.differ("not as deployed", checked.lines, told, checked.blocks)
    run.console.show(checked.diagnostics)
    total = len(checked.same) + len(checked.differing)
    run.console.say(f"{description.name}: {len(checked.same)} of {total} copies in {run.options.deployed} as compiled")
    return PROBLEMS if checked.differing or has_errors(checked.diagnostics) else FINE


MAX_COMBINATIONS = 256

Choice = tuple[str, tuple[str, ...]]  # an argument and its values, that of the default first
Combination = tuple[str, ...]  # one value for each argument


def check_every(run: Run, description: Description) -> int:
    """Compile one robot in memory with every combination; each problem is said once, with the arguments it comes by."""
    from ..diagnostics import arrange, has_errors
    from ..frontend.arguments import declared
    from ..frontend.load import LoadError
    from ..pipeline import compile_robot

    try:
        given = run.given.values()
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    arguments, wrong = declared(description.path, given, run.given.packages)
    if has_errors(wrong):
        run.console.show(wrong)
        return PROBLEMS
    varied = choices(arguments, given)
    tried = list(islice(combinations(varied), MAX_COMBINATIONS))
    found: dict[Diagnostic, list[Combination]] = {}
    tell: Tell = telling(run.given, run.console)
    search = partial(search_meshes, run.given, description)
    for number, combination in enumerate(tried, 1):
        about(f"{description.name}, {number:,} of {len(tried):,}:")
        texts = dict(zip((name for name, _ in varied), combination, strict=True))
        compiled = compile_robot(description.path, {**given, **texts}, tell, run.given.packages, search)
        for diagnostic in proven(compiled).diagnostics:
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

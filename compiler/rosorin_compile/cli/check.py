"""rosorin-compile check and diff: compare robots with their committed artifacts, and with each other."""

import os
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any

from rosorin_compile import api
from rosorin_compile.compare.difference import Difference
from rosorin_compile.compare.difference import lines as difference_lines
from rosorin_compile.formats import FORMATS
from rosorin_compile.language.arguments import NO_ARGUMENTS, Choice, Combination, choices, combinations
from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic, RequestError, error, has_errors
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.wording import count_of
from rosorin_compile.viewer.changes_page import Pictures

from . import command as cli
from .console import FINE, PROBLEMS
from .main import commands
from .run import Run, count, for_each, take_stdin, write_depfile

MAX_COMBINATIONS = 256
_WRITTEN = ("html", "summary", "depfile")  # options whose value is a file to write
_SUBMODULE = "160000"  # the file mode of a submodule in the Git index


@cli.command(
    "check",
    exits="0 no differences, 1 differences or errors",
    sections=lambda: {"Checks (see check CHECK --help)": [(one.name, one.help) for one in commands("checks").values()]},
)
@cli.check_options("[CHECK] [ROBOT ...]", offers=("checks", "robot", "argument"))
@cli.hook_option
@cli.notes_option
@cli.flag("--every-argument", help="compile with all combinations of arguments with a list of values; do not compare")
@cli.flag("--staged", help="compare what Git has staged for the next commit, not the files on disk")
@cli.full_option
@cli.page_options("write a page that shows the robots, as committed and as compiled, and the changes")
@cli.depfile_options("required with --depfile")
def run_check(run: Run) -> int:
    """Compile each robot and compare it with its committed artifacts."""
    if not run.staged:
        return _check(run)
    if absolute := [word for word in run.words if Path(word).is_absolute()]:
        raise RequestError(f"--staged takes paths from this folder, not {absolute[0]}")
    here = Path.cwd()
    vars(run).update({name: str(here / file) for name, file in vars(run).items() if name in _WRITTEN and file})
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-staged-") as temporary:
        os.chdir(_check_out_index(here, Path(os.path.realpath(temporary))))  # so that paths in messages are relative
        try:
            return _check(run)
        finally:
            os.chdir(here)


def _check_out_index(here: Path, copy: Path) -> Path:
    """Copy the files in the Git index to ``copy``, and return the folder there that corresponds to ``here``.

    Submodules become symbolic links. In a hook, Git selects the index of the commit in progress. Raises RequestError.
    """

    def git(folder: Path, *arguments: str) -> str:
        words = ["git", "-C", str(folder), *arguments]
        try:
            done = subprocess.run(words, capture_output=True, check=False)  # noqa: S603 - runs the user's Git
        except FileNotFoundError:
            raise RequestError("--staged: Git is not installed") from None
        if done.returncode:
            reason = os.fsdecode(done.stderr).strip().partition("\n")[0]
            raise RequestError(f"--staged: {reason or 'Git failed'}")
        return os.fsdecode(done.stdout)

    top = Path(git(here, "rev-parse", "--show-toplevel").removesuffix("\n"))
    git(top, "checkout-index", "--all", "--force", "--quiet", f"--prefix={copy}{os.sep}")
    for entry in git(top, "ls-files", "--stage", "-z").split("\0")[:-1]:
        facts, _, name = entry.partition("\t")
        if facts.startswith(_SUBMODULE):
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            (copy / name).symlink_to(top / name, target_is_directory=True)
    folder = copy / Path(os.path.realpath(here)).relative_to(os.path.realpath(top))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _check(run: Run) -> int:
    if run.depfile is not None and run.depfile_target is None:
        raise RequestError("a depfile needs a target: --depfile-target NAME")
    if run.every_argument:
        return for_each(run, _check_every)
    page = Pictures(Path(run.html), not run.no_meshes, run.max_megabytes) if run.html else None
    code = for_each(run, partial(check_robot, page=page))
    if page is not None:
        run.write_page(page)
    return code


def check_robot(run: Run, description: Description, page: Pictures | None = None) -> int:
    """Compile a robot and compare it with its outputs folder; add the changes to the HTML page ``page``, if set."""
    console, name, request = run.console, description.name, run.request(description)
    on_stdin = description.path == Description.ON_STDIN
    checked = api.CheckResult(request.compile(), description.outputs) if on_stdin else api.check(request)
    compiled, committed, folder = checked.compiled, checked.committed, checked.folder
    inputs = request.inputs(compiled)
    console.print_read(inputs)
    console.show(compiled.diagnostics if on_stdin else checked.diagnostics)
    if compiled.robot is None or has_errors(compiled.diagnostics):
        run.nothing_written(description, compiled.diagnostics)
        return PROBLEMS
    if on_stdin:
        console.say(f"{name}: {count(compiled.artifacts)} compiled; there are no committed ones")
        return FINE
    if committed is None:
        return PROBLEMS
    if page is not None:
        page.take(request, compiled, committed)
    if committed.differing_files():
        lines = committed.lines(full=getattr(run, "full", False))
        found = error("outputs-differ", "\n".join(lines), None, "run rosorin-compile all to write them again")
        console.differ("not up to date", lines, found)
        if run.output is not None and not folder.is_dir():
            how = "rosorin-compile all with the same -o and arguments writes it"
            console.warn(f"{name}: there is no folder {folder}; {how}")
        return PROBLEMS
    if has_errors(checked.diagnostics):
        return PROBLEMS
    console.say(f"{name}: {count(compiled.artifacts, compiled.mesh_files)} up to date in {folder}")
    if run.depfile is not None:
        compared = [folder / file for file in committed.committed]
        write_depfile(run, run.depfile_target, compiled, [*inputs, *compared], ())
    return FINE


def _check_every(run: Run, description: Description) -> int:
    """Compile a robot with every combination of arguments; report each problem once, with its arguments."""
    request = run.request(description)
    declared = api.arguments(request)
    if has_errors(declared.diagnostics):
        run.console.show(declared.diagnostics)
        return PROBLEMS
    values = request.values()
    varied = choices(declared.arguments, values)
    tried = list(islice(combinations(varied), MAX_COMBINATIONS))
    found: dict[Diagnostic, list[Combination]] = {}
    for number, combination in enumerate(tried, 1):
        Progress.set_topic(f"{description.name}, {number:,} of {len(tried):,}:")
        texts = dict(zip((name for name, _ in varied), combination, strict=True))
        for diagnostic in replace(request, arguments={**values, **texts}, argument_files=()).compile().diagnostics:
            if diagnostic.severity != NOTE:
                found.setdefault(diagnostic, []).append(combination)
        request = replace(request, warn=lambda _: None)  # print warnings only for the first combination
    run.console.show(arrange(replace(d, message=d.message + _causes(varied, tried, at)) for d, at in found.items()))
    failed = {one for diagnostic, where in found.items() if diagnostic.severity == ERROR for one in where}
    total, names = prod(len(values) for _, values in varied), ", ".join(name for name, _ in varied)
    part = f"{len(tried):,} of {total:,} combinations" if total > len(tried) else count_of(total, "combination")
    what = f"{part} of {names} compiled, {f'{len(failed):,} with errors' if failed else 'all fine'}"
    once = f"compiled once, {'with' if failed else 'without'} errors: no argument has a list of values"
    run.console.say(f"{description.name}: {what if varied else once}")
    return PROBLEMS if failed else FINE


def _causes(varied: Sequence[Choice], tried: Sequence[Combination], where: Sequence[Combination]) -> str:
    """Return the arguments that cause a problem, such as " (with arm=true)", or "" if every combination has it."""
    if len(where) == len(tried):
        return ""
    used = [dict.fromkeys(column) for column in zip(*where, strict=True)]
    rows = zip(varied, used, strict=True)
    causes = [f"{name}={' or '.join(some)}" for (name, values), some in rows if len(some) < len(values)]
    if prod(map(len, used)) != len(where):
        causes = [f"{name}={value}" for (name, _), value in zip(varied, where[0], strict=True)]
        causes.append(f"and in {count_of(len(where) - 1, 'other combination')}")
    return f" (with {', '.join(causes)})"


_OPTIONAL = ("distance", "angle", "when", "at")


@cli.command("diff", exits="0 equal, 1 differences or errors")
@cli.words_argument(
    "A B",
    f"robots to compare: name, folder or file of a description, or a {', '.join(FORMATS.endings())} file",
    required=True,
    offers=("robot",),
)
@cli.repeatable("--a-arg NAME=VALUE", help="set an argument of A only")
@cli.repeatable("--b-arg NAME=VALUE", help="set an argument of B only")
@cli.option("--prefix TEXT", help="prefix of all names in B; default: detected")
@cli.option(
    "--tolerance NUMBER", default=1e-9, help="largest difference to ignore, in m, rad or relative to the number"
)
@cli.flag("--full", help="print all differences")
@cli.page_options("write a page that shows both robots and their differences")
@cli.robot_options
def run_diff(run: Run) -> int:
    """Compare two robots, and print the differences."""
    if len(run.words) != 2:
        raise RequestError(f"diff compares two robots, not {len(run.words)}: {', '.join(run.words) or 'none'}")
    if not 0 <= run.tolerance < float("inf"):
        raise RequestError(f'--tolerance: "{run.tolerance}" is not a number from zero upwards')
    take_stdin(run.words)
    requests = [replace(run.request(run.find_robot(word)), warn=None) for word in run.words]
    settings = {"a_arguments": run.a_arg, "b_arguments": run.b_arg, "packages": run.packages}
    settings |= {"trust": run.trust, "brief": run.format == "text" and not run.full}
    first, second = run.words
    found = api.diff(first, second, run.tolerance, run.prefix, arguments=requests[0].values(), **settings)
    if refused := [one for one in found.diagnostics if one.help == NO_ARGUMENTS]:
        raise RequestError(refused[0].message)
    run.console.show(found.diagnostics)
    if found.a is None or found.b is None:
        return PROBLEMS
    run.give(as_json(found), lambda: "\n".join(difference_lines(found, run.full)))
    if run.html is not None:
        page = Pictures(Path(run.html), not run.no_meshes, run.max_megabytes)
        pairs = zip(requests, (run.a_arg, run.b_arg), strict=True)
        page.take_sides([replace(one, arguments={**one.arguments, **own}) for one, own in pairs], found, run.prefix)
        run.write_page(page)
    return FINE if found.same else PROBLEMS


def as_json(difference: Difference) -> dict[str, Any]:
    """Convert a comparison to JSON data that conforms to the schema ``robot_diff``."""
    found: dict[str, Any] = {}
    for letter, side in zip("ab", difference.sides, strict=True):
        counts = {"links": len(side.robot.links), "joints": len(side.robot.joints)}
        found[letter] = {"source": side.label, "format": side.format.name, "robot": side.robot.name, **counts}
    found |= {name: getattr(difference, name) for name in ("same", "tolerance", "notes", "not_compared")}
    items = []
    for item in difference.items:
        fields = {"a": item.before, "b": item.after, **item._asdict()}
        left_out = ("before", "after", *(name for name in _OPTIONAL if fields[name] in (None, "", {})))
        items.append({name: value for name, value in fields.items() if name not in left_out})
    return {**found, "differences": items, "summary": difference.summary()}

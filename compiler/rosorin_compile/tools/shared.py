"""What commands share: exit codes, wrong usage, options that several have, and the robots that are asked for.

``for_each`` does something with each description that is asked for, ``one`` finds the only one. ``mode_states`` reads
modes as the command line has them: --mode slam, --mode "not slam", --mode slam=on, --mode slam=off.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Mapping, Sequence, Sized
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from ..diagnostics import TRUSTED
from ..diagnostics.console import MARKDOWN, Console
from ..diagnostics.registry import ASKING, WRITING, Rule
from ..diagnostics.wording import counted
from ..project import ENDINGS, Description, NoDescription, all_with, cache_refused, find, narrowed
from .parser import Options

if TYPE_CHECKING:
    from ..diagnostics import Diagnostic
    from ..formats.mesh_files import Searched
    from ..frontend.tree import Map
    from ..model import Edge, Output, Robot
    from ..pipeline import Compiled, Understood
    from ..rules.case import Case
    from .transforms.states import Beyond

RULES = (
    Rule(
        "position-beyond-limit",
        "A position that is asked for is beyond the limit of a joint; a warning, with `--strict` an error.",
        "Another position, or another limit.",
        ASKING,
    ),
    Rule(
        "cache-not-private",
        "A note: somebody else could change what is in the folder of the cache, so there is no cache.",
        "`chmod go-w` of the folder that is named, or another one in `ROSORIN_COMPILE_CACHE`.",
        WRITING,
    ),
)


FINE, PROBLEMS, USAGE = 0, 1, 2
FORMAT_NAMES = ("text", "json", "github", "sarif", MARKDOWN)
_ROBOT = "name in descriptions/, folder or file"
MARK = ":="  # between name and value of an argument, as xacro has it


class WrongUsage(Exception):
    """The command line cannot be followed; the message says why."""


class Given(NamedTuple):
    """The arguments of a run: texts by name from the command line, and the files that hold more of them.

    ``packages`` are folders of ROS packages by name, for robots in other formats; ``trust`` is that in what those run.
    """

    texts: dict[str, str]
    files: tuple[Path, ...]
    packages: Mapping[str, Path] = MappingProxyType({})
    trust: bool = False

    def values(self) -> dict[str, Any]:
        """Return all arguments by name; the command line wins over files. Raises LoadError."""
        if not self.files:
            return dict(self.texts)
        from ..frontend.arguments import read

        return read(self.files, self.texts)


class Run(NamedTuple):
    """One run of a command: its options, where it prints, and the arguments for the descriptions."""

    options: argparse.Namespace
    console: Console
    given: Given


def tell_of_cache() -> None:
    """Say that there is no cache, if somebody else could change what would be in it."""
    refused = cache_refused()
    if refused:
        from ..diagnostics import NOTE, Diagnostic

        message, help = refused
        Console("text").show([Diagnostic("cache-not-private", NOTE, message, help=help)])


def place(text: str) -> str:
    """Return the name of a file or folder, for argparse; an empty one is a variable of a shell that is not set."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty")
    return text


def robot_options(command: argparse.ArgumentParser) -> None:
    """Add what a command takes that goes through robots: their names, and arguments."""
    command.add_argument("words", nargs="*", metavar="ROBOT", help=f"{_ROBOT}; default: every robot")
    package_option(command)
    argument_options(command)


def one_robot(command: argparse.ArgumentParser) -> None:
    """Add the robot of a command that is about one."""
    command.add_argument("words", nargs="*", metavar="ROBOT", help=f"{_ROBOT}; needed where there are several")


def named_robot(command: argparse.ArgumentParser) -> None:
    """Add the option that names the robot, for commands whose words may be other names, too."""
    command.add_argument("-r", "--robot", default="", metavar="ROBOT", help=_ROBOT)


def argument_options(command: argparse.ArgumentParser) -> None:
    """Add the options that set arguments of a description; they stand last in the help."""
    group = command.add_argument_group("arguments of the description, or of a xacro")
    group.add_argument(
        "-a",
        "--arg",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="set one; NAME:=VALUE without -a does the same",
    )
    group.add_argument(
        "--args",
        action="append",
        default=[],
        metavar="FILE",
        dest="args_files",
        help="set those that a YAML file maps to values; -a goes before it",
    )


def package_option(command: argparse.ArgumentParser) -> None:
    """Add the options about robots in other formats: where ROS packages are, and whether a xacro is trusted."""
    command.add_argument(
        "--package",
        action="append",
        default=[],
        metavar="NAME=PATH",
        dest="packages",
        help="folder of a ROS package, for $(find NAME) and package://NAME; may be given again",
    )
    command.add_argument(
        "--trust", action="store_true", help="say nothing of what a xacro can run: you trust whoever wrote it"
    )


def packages_of(options: argparse.Namespace) -> dict[str, Path]:
    """Return the folders of packages that the command line names. Raises WrongUsage."""
    found: dict[str, Path] = {}
    for word in getattr(options, "packages", ()):
        name, equals, path = word.partition("=")
        if not equals or not name or not path:
            raise WrongUsage(f'"{word}" is not NAME=PATH')
        if not os.path.isdir(path):  # noqa: PTH112 - Path.is_dir raises for a name that no folder can have
            raise WrongUsage(f'there is no folder "{path}" for the package {name}')
        found[name] = Path(path)
    return found


def output_options(command: argparse.ArgumentParser) -> None:
    """Add the option that names the folder of the artifacts."""
    command.add_argument("--outputs", type=place, metavar="FOLDER", help="where the artifacts stand; default: outputs/")


def format_options(command: argparse.ArgumentParser) -> None:
    """Add the option that chooses how diagnostics are printed."""
    command.add_argument("--format", choices=FORMAT_NAMES, default="text", help="form of the messages; default: text")
    how_much = command.add_mutually_exclusive_group()
    how_much.add_argument(
        "-q", "--quiet", action="store_true", help="show errors only, and how many stand-ins there are"
    )
    how_much.add_argument("-v", "--verbose", action="store_true", help="say which files were read, too")


def hook_option(command: argparse.ArgumentParser, more: str = "") -> None:
    """Add the option for pre-commit."""
    command.add_argument(
        "--hook",
        action="store_true",
        help=f"for pre-commit: the words are files that changed, the robots all those of their projects{more}",
    )


def console_of(options: argparse.Namespace) -> Console:
    """Return where a command prints that has the options of ``format_options``."""
    return Console(options.format, options.quiet, options.verbose, getattr(options, "summary", None) is not None)


def depfile_options(command: argparse.ArgumentParser, target: str) -> None:
    """Add the options that tell a build tool which files were read; ``target`` says which target it is by default."""
    command.add_argument(
        "--depfile", type=place, metavar="FILE", help="write which files were read, as Make and Ninja take it"
    )
    command.add_argument(
        "--depfile-target", type=place, metavar="NAME", help=f"the target that the depfile names; default: {target}"
    )


def json_option(command: argparse.ArgumentParser) -> None:
    """Add the options that choose how a result is printed that is more than diagnostics."""
    command.add_argument("--format", choices=("text", "json"), default="text", help="form of the result; default: text")
    command.add_argument("--json", action="store_const", dest="format", const="json", help="short for --format json")


def given_arguments(options: argparse.Namespace, words: list[str]) -> tuple[Given, list[str]]:
    """Return the arguments that the command line sets, and the words that set none. Raises WrongUsage."""
    texts: dict[str, str] = {}
    for text in [*(word for word in words if MARK in word), *options.arg]:
        name, equals, value = text.partition("=")
        name = name.removesuffix(":")
        if not equals or not name:
            raise WrongUsage(f'"{text}" is not NAME=VALUE')
        texts[name] = value
    files = tuple(map(Path, options.args_files))
    for file in files:
        if not file.is_file():
            raise WrongUsage(f'there is no file "{file}" of arguments')
    given = Given(texts, files, packages_of(options), getattr(options, "trust", False))
    return given, [word for word in words if MARK not in word]


def descriptions(names: list[str], outputs: str | None = None) -> list[Description]:
    """Return the descriptions that are asked for. Raises WrongUsage."""
    try:
        return find(names, outputs)
    except NoDescription as problem:
        raise WrongUsage(str(problem)) from None


def for_each(options: argparse.Namespace, one: Callable[[Run, Description], int]) -> int:
    """Do something with each description that is asked for; return the worst exit code."""
    hook = getattr(options, "hook", False)
    given, found = _of_changed(options) if hook and options.words else _asked_for(options)
    summary = getattr(options, "summary", None)
    run = Run(options, console_of(options), given)
    code = FINE
    if not found:
        run.console.say("none of these files is in a project: no folder above them has descriptions/*/robot.yaml")
    for description in found:
        run.console.begin(description.name)
        result = one(run, description)
        run.console.end(result != FINE)
        code = max(code, result)
    run.console.finish()
    if summary is not None:
        _append(Path(summary), run.console.summary())
    return code


def _asked_for(options: argparse.Namespace) -> tuple[Given, list[Description]]:
    """Return the arguments that the command line sets, and the descriptions that it names. Raises WrongUsage."""
    given, names = given_arguments(options, options.words)
    return given, descriptions(names, getattr(options, "outputs", None))


def _of_changed(options: argparse.Namespace) -> tuple[Given, list[Description]]:
    """Return the same of a command line that names files that changed; there may be none. Raises WrongUsage."""
    # What is a file sets no argument, whatever its name.
    files = [word for word in options.words if os.path.lexists(word)]
    given, names = given_arguments(options, [word for word in options.words if word not in files])
    if names:
        raise WrongUsage(f'with --hook the words are files that changed, and there is no file "{names[0]}"')
    paths = [str(path) for path in all_with(files)]
    return given, descriptions(paths, getattr(options, "outputs", None)) if paths else []


def _append(file: Path, text: str) -> None:
    """Append a text to a file that other steps of a job may have begun. Raises WrongUsage."""
    try:
        with file.open("a", encoding="utf-8", errors="backslashreplace") as opened:
            opened.write(text)
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or problem
        raise WrongUsage(f'cannot write the summary "{file}": {reason}') from None


def compile_one(
    given: Given, description: Description, console: Console, meshes: bool = False, wanted: Sequence[str] = ()
) -> Compiled:
    """Return what becomes of one description; a file of arguments that is no good is a problem like others.

    What has to be said before anything is run is printed on the console. ``meshes`` says that mesh files are looked
    for; without that each is taken to be where the artifacts look. ``wanted`` are the only outputs that are made.
    """
    from ..frontend.load import LoadError
    from ..pipeline import Compiled, compile_robot

    try:
        arguments = given.values()
    except LoadError as problem:
        return Compiled(None, (), [problem.diagnostic], ())
    search = partial(search_meshes, given, description) if meshes else None
    compiled = compile_robot(description.path, arguments, telling(given, console), given.packages, search, wanted)
    console.tell_read(read_by(given, compiled))
    return compiled


def read_by(given: Given, compiled: Compiled) -> list[Path]:
    """Return the files that a run has read: what it was compiled of, and the files of arguments."""
    return list(dict.fromkeys([*compiled.inputs, *given.files]))


def telling(given: Given, console: Console) -> Callable[[Diagnostic], None]:
    """Return what takes a word of warning before something is run: it is counted alone where that is trusted."""
    if not given.trust:
        return console.ahead
    return lambda warning: console.ahead(warning._replace(numbers=TRUSTED))


def search_meshes(given: Given, description: Description, tree: Map, outputs: Sequence[Output]) -> Searched:
    """Look for the meshes of a robot, and read those that belong to its artifacts."""
    from ..formats.mesh_files import Places, search
    from .mesh_copies import brought

    places = Places(description.path, description.outputs, given.packages, os.environ)
    return brought(search(tree, outputs, places), description.outputs)


def mesh_files(compiled: Compiled) -> Mapping[str, bytes]:
    """Return the mesh files that belong to the artifacts, bytes by name."""
    return compiled.meshes.files if compiled.meshes else {}


def lacks_meshes(compiled: Compiled) -> bool:
    """Say whether a mesh that is there could not be read; what can be, depends on what is installed, too."""
    return compiled.meshes is not None and any(
        one.named.name in compiled.meshes.missing for one in compiled.meshes.found
    )


def compile_proven(given: Given, description: Description, console: Console, wanted: Sequence[str] = ()) -> Compiled:
    """Return what becomes of one description, its meshes found, without artifacts if they say another thing than it."""
    return proven(compile_one(given, description, console, meshes=True, wanted=wanted))


def proven(compiled: Compiled) -> Compiled:
    """Return what was compiled once it is read back: no command writes, copies or compares what has not been."""
    from ..meaning.agreement import agreement

    if compiled.robot is None or not compiled.artifacts:
        return compiled
    wrong = agreement(compiled.robot, compiled.artifacts)
    return compiled._replace(artifacts=(), diagnostics=[*compiled.diagnostics, *wrong]) if wrong else compiled


def nothing_written(console: Console, name: str, diagnostics: Sequence[Diagnostic]) -> int:
    """Say how many problems keep a robot from being compiled; a robot without outputs has none."""
    errors = sum(diagnostic.severity == "error" for diagnostic in diagnostics)
    if not errors:
        console.say(f"{name}: nothing to emit; say under outputs: what you want")
        return FINE
    console.warn(f"{name}: {counted(errors, 'error')}, nothing written")
    return PROBLEMS


def count(artifacts: Sized, meshes: Sized = ()) -> str:
    """Return the number of artifacts in words, and that of the mesh files with them."""
    more = f" and {counted(len(meshes), 'mesh file')}" if meshes else ""
    return counted(len(artifacts), "artifact") + more


class Known(NamedTuple):
    """A robot without errors, and where it was written."""

    robot: Robot
    case: Case


def one(name: str, how: str) -> Description:
    """Return the description of a name, or the only one here. Raises WrongUsage; ``how`` says how to name one."""
    found = narrowed(descriptions([name] if name else []))
    if len(found) > 1:
        robots = ", ".join(description.name for description in found)
        raise WrongUsage(f"there are several robots here: {robots}; name one: {how}")
    return found[0]


def compiled_one(options: argparse.Namespace, several: str, how: str) -> tuple[Console, Description, Compiled | None]:
    """Compile the one robot that a command asks for, and say what is wrong; None for one with errors or no artifacts.

    ``several`` says why it is one. Raises WrongUsage.
    """
    from ..diagnostics import has_errors

    given, names = given_arguments(options, options.words)
    if len(names) > 1:
        raise WrongUsage(f"{several}: {how}")
    description = one(names[0] if names else "", how)
    console = console_of(options)
    console.begin(description.name)
    compiled = compile_proven(given, description, console)
    console.show(compiled.diagnostics)
    if compiled.robot is not None and not has_errors(compiled.diagnostics):
        return console, description, compiled
    nothing_written(console, description.name, compiled.diagnostics)
    return console, description, None


def is_foreign(path: Path) -> bool:
    """Say whether a file is no description but a robot in another format, by its name."""
    if path.suffix.lower() in ("", *ENDINGS):
        return False
    from ..formats import endings

    return path.suffix.lower() in endings()


def read(given: Given, description: Description, console: Console) -> Understood:
    """Return what a description says, or a URDF, xacro, MJCF or driver's JSON in its place. Raises LoadError."""
    arguments = given.values()
    if is_foreign(description.path):
        from .foreign import understand_foreign

        return understand_foreign(description.path, texts(arguments), given.packages, console.ahead, given.trust)
    from ..pipeline import understand

    return understand(description.path, arguments, telling(given, console), given.packages)


def texts(arguments: Mapping[str, Any]) -> dict[str, str]:
    """Return arguments as xacro takes them."""
    return {name: str(value) for name, value in arguments.items()}


def understood(given: Given, description: Description, console: Console) -> Known | None:
    """Return the robot of a description; None, after saying what is wrong, of one with errors."""
    from ..diagnostics import has_errors
    from ..frontend.load import LoadError
    from ..rules.case import Case
    from ..rules.remarkable import collect

    try:
        expanded, lowered, diagnostics, _ = read(given, description, console)
    except LoadError as problem:
        console.show([problem.diagnostic])
        return None
    if lowered is None or lowered.robot is None or expanded.tree is None or has_errors(diagnostics):
        console.show([diagnostic for diagnostic in diagnostics if diagnostic.severity == "error"])
        console.warn(f"{description.name}: a description with errors has no frames and joints to ask about")
        return None
    return Known(lowered.robot, Case(lowered.robot, expanded.tree, lowered.places, collect(expanded.tree)))


def beyond_limit(known: Known, found: Beyond, severity: str) -> Diagnostic:
    """Return what is to say about a position beyond a limit, at the place of the limit."""
    from ..numbers import exact

    joint, side = found.joint, "below" if found.side == "lower" else "above"
    unit = "m" if joint.type == "prismatic" else "rad"
    message = (
        f'joint "{joint.name}" at {exact(found.position)} {unit} is {side} its {found.side} limit'
        f" of {exact(found.limit)} {unit}"
    )
    help = "the joint does not get there; with --strict this is an error"
    path = known.case.joint(joint, "limit", found.side)
    return known.case.problem("position-beyond-limit", message, path, help, severity=severity)


def edge_index(robot: Robot, edge: Edge) -> int:
    """Return the place of an edge in the list of the description."""
    return next(index for index, one in enumerate(robot.edges) if one is edge)


_STATES = {"on": True, "off": False}


def mode_option(command: Options, unnamed: str) -> None:
    """Add the option that says how modes are; ``unnamed`` says what those are that are not named."""
    command.add_argument(
        "--mode",
        action="append",
        default=[],
        metavar="NAME",
        dest="modes",
        help=f'a mode that is on, or off: slam, "not slam", slam=off; others: {unnamed}',
    )


def mode_states(robot: Robot, texts: Sequence[str]) -> dict[str, bool]:
    """Return the modes that the command line names, and whether they are on. Raises WrongUsage."""
    found: dict[str, bool] = {}
    for text in texts:
        name, equals, state = text.partition("=")
        words = name.split()
        negated = len(words) == 2 and words[0] == "not"
        name = words[-1] if negated else name.strip()
        if name not in robot.modes:
            from ..diagnostics import did_you_mean

            known = did_you_mean(name, robot.modes) or "it has none"
            raise WrongUsage(f'{robot.name} has no mode "{name}"; {known}')
        if (equals and state not in _STATES) or (equals and negated):
            raise WrongUsage(f'"{text}" is not a mode: write {name}, "not {name}", {name}=on or {name}=off')
        on = _STATES[state] if equals else not negated
        if found.setdefault(name, on) != on:
            raise WrongUsage(f'the mode "{name}" cannot be on and off')
    return found

"""Options that several commands have."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .. import world
from ..diagnostics.console import BARE, ENVELOPE, MARKDOWN, Console
from .answer import answer_of
from .older import older_option
from .usage import WrongUsage

if TYPE_CHECKING:
    from .parser import Options

FORMAT_NAMES = ("text", ENVELOPE, BARE, "github", "sarif", MARKDOWN)
_ROBOT = "name in descriptions/, folder or file"
PAGE_MEGABYTES = 40  # of the meshes of a page


def place(text: str) -> str:
    """Return the name of a file or folder, for argparse; an empty one is a variable of a shell that is not set."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty")
    return text


def seconds(text: str) -> int:
    """Return a time of a command line in whole seconds, for argparse."""
    if not (text.isascii() and text.isdigit() and len(text) < 9 and int(text) > 0):
        raise argparse.ArgumentTypeError(f'"{text[:20]}" is no number of whole seconds')
    return int(text)


def robot_options(command: argparse.ArgumentParser) -> None:
    """Add what a command takes that goes through robots: their names, and arguments."""
    command.add_argument("words", nargs="*", metavar="ROBOT", help=f"{_ROBOT}; default: every robot")
    package_option(command)
    argument_options(command)


def check_options(
    command: argparse.ArgumentParser,
    words: str = "ROBOT",
    help: str = f"{_ROBOT}; default: every robot",
    hook: bool = False,
) -> None:
    """Add what a check takes: its words, the folder of the artifacts, arguments, and how messages are printed.

    With ``hook`` the words may be files that changed, for pre-commit.
    """
    command.add_argument("words", nargs="*", metavar=words, help=help)
    package_option(command)
    argument_options(command)
    if hook:
        hook_option(command)
    output_options(command)
    format_options(command, summary=True)


def one_robot(command: argparse.ArgumentParser) -> None:
    """Add the robot of a command that is about one."""
    command.add_argument("words", nargs="*", metavar="ROBOT", help=f"{_ROBOT}; needed where there are several")


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
    command.add_argument(
        "--xacro-seconds",
        type=seconds,
        metavar="S",
        help="how long a xacro may calculate before it is ended; default: 60",
    )


def output_options(command: argparse.ArgumentParser) -> None:
    """Add the option that names the folder of the artifacts."""
    command.add_argument(
        "-o",
        "--output",
        type=place,
        metavar="FOLDER",
        help="where the artifacts stand: of one robot the folder itself, of several a folder for each in it; "
        "default: outputs/ROBOT",
    )
    older_option(command, ["--outputs"], "", dest="outputs", type=place, metavar="FOLDER")


def format_options(command: argparse.ArgumentParser, summary: bool = False) -> None:
    """Add the options that choose how diagnostics are printed; with ``summary`` also that they are kept in a file."""
    if summary:
        command.add_argument(
            "--summary",
            type=place,
            metavar="FILE",
            help="append what --format markdown prints to a file, whatever the form of the messages",
        )
    command.add_argument("--format", choices=FORMAT_NAMES, default="text", help="form of the messages; default: text")
    how_much = command.add_mutually_exclusive_group()
    how_much.add_argument(
        "-q", "--quiet", action="store_true", help="show errors only, and how many stand-ins there are"
    )
    how_much.add_argument("-v", "--verbose", action="store_true", help="say which files were read, too")


def quiet_option(command: argparse.ArgumentParser) -> None:
    """Add the option to hear of errors only, for commands whose result is more than diagnostics."""
    command.add_argument("-q", "--quiet", action="store_true", help="of the messages show errors only")


def hook_option(command: argparse.ArgumentParser, more: str = "") -> None:
    """Add the option for pre-commit."""
    command.add_argument(
        "--hook",
        action="store_true",
        help=f"for pre-commit: the words are files that changed, the robots all those of their projects{more}",
    )


def json_option(command: Options) -> None:
    """Add the options that choose how a result is printed that is more than diagnostics."""
    forms = ("text", ENVELOPE, BARE)
    command.add_argument("--format", choices=forms, default="text", help="form of the result; default: text")
    command.add_argument("--json", action=_Old, dest="old_json", nargs=0, default=False, help=argparse.SUPPRESS)


class _Old(argparse.Action):
    """The old spelling of a result alone; the command line says the new one."""

    def __call__(self, _: object, namespace: argparse.Namespace, *__: object) -> None:
        """Set it."""
        namespace.format, namespace.old_json = BARE, True


def page_options(command: argparse.ArgumentParser, what: str) -> None:
    """Add the options of a page that is written into a file; ``what`` says what it shows."""
    command.add_argument("--html", type=place, metavar="FILE", help=what)
    command.add_argument("--no-meshes", action="store_true", help="with --html: leave the meshes out")
    command.add_argument(
        "--max-megabytes",
        type=float,
        metavar="NUMBER",
        help=f"with --html: how much meshes may have together; default: {PAGE_MEGABYTES}",
    )


def depfile_options(command: argparse.ArgumentParser, target: str) -> None:
    """Add the options that tell a build tool which files were read; ``target`` says which target it is by default."""
    command.add_argument(
        "--depfile", type=place, metavar="FILE", help="write which files were read, as Make and Ninja take it"
    )
    command.add_argument(
        "--depfile-target", type=place, metavar="NAME", help=f"the target that the depfile names; default: {target}"
    )


def mode_option(command: Options, unnamed: str) -> None:
    """Add the option that says how modes are; ``unnamed`` says what those are that are not named."""
    command.add_argument(
        "--mode",
        action="append",
        default=[],
        metavar="MODE",
        dest="modes",
        help=f'a mode that is on, or off: slam, "not slam", slam=off; others: {unnamed}',
    )


def console_of(options: argparse.Namespace) -> Console:
    """Return where a command prints what it has to say, in the form that ``format_options`` or ``json_option`` choose.

    Beside a result alone it is text. Raises WrongUsage.
    """
    if hasattr(options, "old_json"):
        return answer_of(options).console(options.quiet, getattr(options, "verbose", False))
    summary = getattr(options, "summary", None)
    if summary is not None:
        check_summary(Path(summary))
    diagnostics = answer_of(options).diagnostics
    console = Console(options.format, options.quiet, options.verbose, summary is not None, diagnostics)
    if hasattr(options, "notes") and not options.notes:
        console.counts, console.listing = True, "--notes lists them"
    return console


_SUMMARY = "GITHUB_STEP_SUMMARY"  # the file to which steps of a job append, as GitHub names it


def check_summary(file: Path) -> None:
    """Raise WrongUsage for a file to which no summary goes: one that neither we nor a step of a job has begun."""
    from ..diagnostics.markdown import HEAD

    try:
        whose = world.variable(_SUMMARY)
        if world.kind(file) != world.FILE or (whose and world.is_same(file, whose)):
            return
        begins = world.head(file, len(HEAD.encode())).decode("utf-8", "replace")
    except (OSError, ValueError):
        return  # writing says why not
    if begins.strip() and begins != HEAD:
        raise WrongUsage(f'"{file}" is there, and is no summary: nothing is appended to it; name another file')


def append_summary(file: Path, text: str) -> None:
    """Append a text to a file that other steps of a job may have begun. Raises WrongUsage."""
    check_summary(file)
    world.spoil(f"{file} is written")
    try:
        with file.open("a", encoding="utf-8", errors="backslashreplace") as opened:
            opened.write(text)
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or problem
        raise WrongUsage(f'cannot write the summary "{file}": {reason}') from None

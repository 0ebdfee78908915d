"""The command line: the table of commands. Each is a module of its own, imported when it is called.

Exit codes: 0 fine, 1 problems found, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import errno
import io
import os
import sys
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from .commands.usage import PROBLEMS, USAGE, WrongUsage, tell_of_cache, tell_of_system, tell_which_tool
from .diagnostics.console import guarded, show_progress
from .diagnostics.progress import hide
from .world import spoil

if TYPE_CHECKING:
    from types import ModuleType

    from .commands.parser import Parser

# By what people want to do; the help lists them in this order.
GROUPS = {
    "describe and compile": {
        "init": "start a new robot",
        "all": "compile, and write every artifact",
        "print": "compile, and print one artifact on standard output, as xacro does",
        "check": "compile, and compare with the committed artifacts",
        "watch": "compile on every change, and say what moved",
        "sweep": "compile many variants of one robot, each into a folder of its own",
        "collisions": "compute which links MoveIt need not check against each other",
        "schema": "print a JSON Schema: of descriptions, for editors, or of a format for programs",
        "rule": "say what the id of a message means, and what to do",
    },
    "bring in": {
        "import": "make a description of a URDF, a xacro, an SDF or an MJCF",
        "extract": "take boxes and height maps out of meshes",
        "diff": "compare two robots by meaning, in any of the formats",
    },
    "ask": {
        "explain": "say where a frame sits, and which lines put it there",
        "tf": "say where one frame sits in another, as tf2_echo does",
        "frames": "show the tree of frames with who publishes them",
        "view": "show the robot in the browser, and follow its files",
        "picture": "draw the robot into a PNG or SVG, without a browser",
        "simulate": "say how the robot behaves in MuJoCo: resting, in its poses, driving",
        "pulses": "turn servo pulses into joint positions and back",
        "args": "list the arguments of a robot",
    },
    "build with it": {
        "cmake-dir": "print the folder of the CMake package, for find_package",
        "bazel-dir": "print the folder of the Bazel rule rosorin_robot",
    },
    "run on the robot": {
        "package": "write a ROS 2 package that is ready to build",
        "deploy": "write the artifacts into a ROS 2 package that you have",
        "verify": "hold a recording of the robot against its description",
    },
    "set up": {
        "completion": "print the script that completes a line in bash, zsh or fish",
    },
}
COMMANDS = {name: help for group in GROUPS.values() for name, help in group.items()}

# The words that a command takes; those of extract stand there.
WORDS = {
    "init": "NAME [TEMPLATE]",
    "all": "[ROBOT ...]",
    "print": "OUTPUT [ROBOT] [NAME:=VALUE ...]",
    "check": "[ROBOT ...]",
    "watch": "[ROBOT ...]",
    "sweep": "[ROBOT] --over LIST -o FOLDER",
    "collisions": "[ROBOT]",
    "schema": "[NAME]",
    "rule": "[ID ...]",
    "import": "SOURCE",
    "diff": "A B",
    "explain": "[ROBOT] NAME ...",
    "tf": "SOURCE TARGET [ROBOT]",
    "frames": "[ROBOT]",
    "view": "[ROBOT]",
    "picture": "[ROBOT] -o FILE",
    "simulate": "[ROBOT]",
    "pulses": "[ROBOT] [JOINT=VALUE ...]",
    "args": "[ROBOT ...]",
    "package": "[ROBOT] -o FOLDER",
    "deploy": "[ROBOT] --to FOLDER",
    "verify": "SOURCE [ROBOT]",
    "completion": "SHELL",
}

# What the exit codes 0 and 1 of a command mean; 2 is wrong usage everywhere.
_EXITS = {
    "init": "0 written, 1 the folder cannot be written",
    "all": "0 written or unchanged, 1 a robot has errors; with --dry-run also 1 something would change",
    "print": "0 printed, 1 the robot has errors",
    "check": "0 as committed, 1 differences or errors",
    "watch": "0 it was ended by Ctrl-C or SIGTERM",
    "sweep": "0 every variant made or unchanged, 1 a variant has errors, or nothing can be written",
    "collisions": "0 written or unchanged, 1 errors",
    "rule": "0 known, 1 a plug-in is broken",
    "import": "0 written, 1 the source has errors",
    "extract": "0 taken out, 1 it cannot be",
    "diff": "0 the same robot, 1 differences or errors",
    "explain": "0 answered, 1 the description has errors",
    "tf": "0 answered, 1 errors or no transform; with --strict also 1 beyond a limit",
    "frames": "0 shown or written, 1 the robot has errors",
    "pulses": "0 answered, 1 errors or no such pulse; with --strict also 1 beyond a limit",
    "args": "0 listed, 1 an argument that is given is wrong",
    "package": "0 written or unchanged, 1 errors",
    "deploy": "0 written or unchanged, 1 errors; with --dry-run also 1 something would change",
    "verify": "0 the robot that is described, 1 another one, or nothing that can be read",
    "view": "0 it was ended by Ctrl-C or SIGTERM, or the page is written; with --html also 1 errors",
    "picture": "0 drawn, 1 errors, or what draws is not installed",
    "simulate": "0 within the limits, 1 errors, or something beyond a limit",
    "cmake-dir": "0 printed",
    "bazel-dir": "0 printed",
    "schema": "0 printed",
    "completion": "0 printed",
}
_EXIT = "0 fine, 1 problems"

# Where the module of a command stands, where that is not its name in ``commands``.
MODULES = {
    "cmake-dir": "commands.cmake_dir",
    "bazel-dir": "commands.bazel_dir",
    "collisions": "tools.collisions.command",
    "sweep": "tools.sweep.command",
    "import": "tools.importer.command",
    "extract": "tools.extract.command",
    "explain": "commands.explain.command",
    "tf": "commands.transforms.tf",
    "pulses": "commands.transforms.pulses",
    "view": "tools.view.command",
    "picture": "tools.picture.command",
    "simulate": "tools.simulate.command",
    "package": "tools.package.command",
    "deploy": "tools.package.deploy_command",
    "verify": "tools.verify.command",
    "completion": "commands.completion.command",
}

# No command of the help: the scripts of ``completion`` ask so what may stand at the cursor.
ASKED_BY_SHELLS = "complete"

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)  # what writing to a stream can end in

_WHAT = "Say once, in YAML, what a robot looks like; every artifact that other programs read follows."
_MORE = """rosorin-compile COMMAND --help says more about one.
Exit codes: 0 fine, 1 problems or differences, 2 wrong usage."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as standard error: no letter may stop a run
    with guarded():
        return _run(words)


def _run(words: list[str]) -> int:
    """Run a command line; return the exit code."""
    if not words:
        sys.stderr.write(parser(words).format_help())
        return USAGE
    if words[0] == ASKED_BY_SHELLS:
        from .commands.completion.candidates import CommandLine, answer

        return answer(words[1:], CommandLine(COMMANDS, parser))
    try:
        tell_which_tool()
        options = parse(words)
        if getattr(options, "xacro_seconds", None):
            os.environ["ROSORIN_COMPILE_XACRO_SECONDS"] = str(options.xacro_seconds)  # for all processes of the run
        if _shown(options):
            show_progress()
        code: int = options.run(options)
        if not getattr(options, "quiet", False):
            tell_of_cache()
            tell_of_system()
        sys.stdout.flush()
    except WrongUsage as problem:
        sys.stderr.write(f"rosorin-compile: {problem}\n")
        return USAGE
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        _say_no_more()
        return PROBLEMS
    except Exception as problem:
        # Python 3.11 wraps what comes while a class is made.
        return 130 if isinstance(problem.__cause__, KeyboardInterrupt) else _stopped(problem)
    finally:
        hide()
    return code


def _shown(options: argparse.Namespace) -> bool:
    """Say whether a run is one for a person, who wants to see how far it is."""
    for_programs = getattr(options, "format", "text") != "text" or getattr(options, "json", False)
    return not (for_programs or getattr(options, "quiet", False))


def _say_no_more() -> None:
    """Let standard output lead nowhere, so that Python does not try it again at the end."""
    spoil("nobody reads what is said")
    with Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _stopped(problem: Exception) -> int:
    """Say that a plug-in stopped the run, a name that no file can have, or a full disk; whatever else goes on."""
    from .plugins import PluginFailed

    if isinstance(problem, OSError) and problem.errno in _FULL and problem.filename is None:
        _say_no_more()
        sys.stderr.write(f"rosorin-compile: cannot write to standard output: {problem.strerror}\n")
        return PROBLEMS
    if isinstance(problem, OSError) and problem.errno == errno.ENAMETOOLONG:
        sys.stderr.write(f"rosorin-compile: no file can have so long a name: {str(problem.filename)[:60]}...\n")
        return USAGE
    if not isinstance(problem, PluginFailed):
        raise problem
    from .diagnostics.report import text

    sys.stderr.write(text([problem.diagnostic]))
    return PROBLEMS


def parse(words: list[str]) -> argparse.Namespace:
    """Return the options of a command line; words may stand before, between and after its options."""
    words = words[1:] if words[:1] == ["--"] else words
    options: argparse.Namespace
    options, more = parser(words).parse_known_args(words)
    unknown = next((word for word in more if word.startswith("-") and word != "-"), "")
    if unknown:
        raise WrongUsage(f"{_called(words)} has no option {unknown}; {_near(unknown, options.known)}")
    if more and not hasattr(options, "words"):
        raise WrongUsage(f'{_called(words)} takes no "{more[0]}"; see rosorin-compile {_called(words)} --help')
    if more:
        options.words += more
    return options


def parser(words: Sequence[str]) -> Parser:
    """Return the parser of a command line; of the commands it has only the one that ``words`` call."""
    from .commands.parser import Parser, Version

    top = Parser(
        prog="rosorin-compile",
        usage="rosorin-compile [-h] [--version] COMMAND ...",
        description=f"{_WHAT}\n{listed()}",
        epilog=_MORE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action=Version, nargs=0, help="show the version, and the plug-ins with theirs")
    commands = top.add_subparsers(required=True, metavar="COMMAND", prog="rosorin-compile", help=argparse.SUPPRESS)
    called = _called(words)
    if called and called not in COMMANDS:
        top.error(f'there is no command "{called}"; {_near(called, COMMANDS)}')
    if called:
        help = COMMANDS[called]
        command = commands.add_parser(called, description=f"{help[0].upper()}{help[1:]}.")
        module = _module(called)
        module.options(command)
        if called in WORDS:
            command.usage = f"{top.prog} {called} [options] {WORDS[called]}"
        for one in (command, *command.within.values()):
            one.epilog = "\n\n".join(
                filter(None, [one.epilog, f"Exit codes: {_EXITS.get(called, _EXIT)}, 2 wrong usage."])
            )
        command.set_defaults(run=module.run, known=command.long_options())
    return top


def _module(command: str) -> ModuleType:
    return import_module(f".{MODULES.get(command, f'commands.{command}')}", __package__)


def _called(words: Sequence[str]) -> str:
    """Return the command that a command line calls: its first word that is no option."""
    return next((word for word in words if not word.startswith("-")), "")


def _near(word: str, known: Iterable[str]) -> str:
    from .diagnostics import did_you_mean

    return did_you_mean(word.partition("=")[0], known)


def listed() -> str:
    """Return the commands as the help shows them, in groups."""
    width = max(map(len, COMMANDS))
    return "".join(
        f"\n{title}:\n" + "".join(f"  {name:<{width}}  {help}\n" for name, help in group.items())
        for title, group in GROUPS.items()
    )

"""rosorin-compile check parameters: hold the parameter files of nodes against one robot."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.ros.check_parameters.checking import asked, look, summary
from rosorin_compile.ros.parameters import DISTRIBUTION
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.project import Description

from .robots import is_foreign
from .run import Run, for_each
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser


_HOW = "rosorin-compile check parameters ROBOT FILE ..."
_DESCRIPTION = re.compile(r"""^["']?robot["']?[ \t]*:[ \t]*[^\s#{]""", re.MULTILINE)
_MARK = ":="
_MOST = 1_000_000  # bytes of a file that are looked at


def options(command: Parser) -> None:
    """Add what this check takes."""
    command.add_check_options(
        "ROBOT FILE", "the robot, required if there are several, and parameter files of its nodes"
    )
    add = command.add_argument_group("parameter files").add_argument
    many: dict[str, Any] = {"nargs": "+", "action": "extend", "default": [], "type": "path", "metavar": "FILE"}
    command.set_defaults(parameters=[])
    add("--controllers", **many, help="parameter files of a controller_manager")
    add("--launch", **many, help="launch files to read remappings from")
    add("--remap", action="append", default=[], metavar="NODE:FROM:=TO", help="add a remapping")
    add("--namespace", default="", metavar="NS", help="namespace of the nodes")
    add(
        "--distribution",
        choices=DISTRIBUTION["enum"],
        help="ROS 2 distribution; default: that of the outputs, else any",
    )


def run(options: argparse.Namespace) -> int:
    """Hold the parameter files against the robot."""
    _take_words(options)
    wanted = asked(options)

    def checked(run: Run, description: Description) -> int:
        case = run.understood(description)
        if case is None:
            return PROBLEMS
        looked = look(case, wanted)
        run.console.show(looked.diagnostics)
        run.console.say(f"{description.name}: {summary(looked)}")
        return PROBLEMS if has_errors(looked.diagnostics) else FINE

    return for_each(options, checked, alone=_HOW)


def _take_words(options: argparse.Namespace) -> None:
    """Leave the robot and its arguments in the words; the others are parameter files. Raises WrongUsage."""
    for words in (options.controllers, options.launch):  # arguments may stand behind files
        options.words += [word for word in words if _MARK in word]
        words[:] = [word for word in words if _MARK not in word]
    names = Run.of(options).words
    arguments = [word for word in options.words if word not in names]
    robots = names[: bool(names) and _is_robot(names[0])]
    options.parameters = names[len(robots) :]
    if not options.parameters and not options.controllers:
        raise WrongUsage(f"there is no parameter file to hold against a robot: {_HOW}")
    options.words = [*robots, *arguments]


def _is_robot(word: str) -> bool:
    """Say whether a word names a robot, rather than a parameter file: there is no such file, or it describes one."""
    if not files.is_file(word) or is_foreign(Path(word)) or Path(word).name == Description.ROOT_FILE:
        return True
    return _DESCRIPTION.search(files.read_bytes(word, _MOST).decode("utf-8", "replace")) is not None

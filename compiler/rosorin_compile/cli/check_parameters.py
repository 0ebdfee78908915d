"""rosorin-compile check parameters: hold the parameter files of nodes against one robot."""

from __future__ import annotations

import re
from pathlib import Path

import click

from rosorin_compile.request import is_foreign
from rosorin_compile.ros.parameters import DISTRIBUTION
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.project import Description

from .command import Options, check, option
from .options import PATH, check_options
from .run import Run, for_each
from .usage import FINE, PROBLEMS, WrongUsage

_HOW = "rosorin-compile check parameters ROBOT FILE ..."
_DESCRIPTION = re.compile(r"""^["']?robot["']?[ \t]*:[ \t]*[^\s#{]""", re.MULTILINE)
_MARK = ":="
_MOST = 1_000_000  # bytes of a file that are looked at


_FILES = "Parameter files"


@check("parameters", exits="0 no errors, 1 errors")
@check_options("[ROBOT] FILE ...", "the robot, required if there are several, and parameter files of its nodes")
@option(
    "--controllers",
    multiple=True,
    many=True,
    type=PATH,
    metavar="FILE ...",
    help="parameter files of a controller_manager",
    section=_FILES,
)
@option(
    "--launch",
    multiple=True,
    many=True,
    type=PATH,
    metavar="FILE ...",
    help="launch files to read remappings from",
    section=_FILES,
)
@option("--remap", multiple=True, metavar="NODE:FROM:=TO", help="add a remapping", section=_FILES)
@option("--namespace", default="", metavar="NS", help="namespace of the nodes", section=_FILES)
@option(
    "--distribution",
    type=click.Choice(DISTRIBUTION["enum"]),
    help="ROS 2 distribution; default: that of the outputs, else any",
    section=_FILES,
)
def run(options: Options) -> int:
    """Hold the parameter files against the robot."""
    from rosorin_compile.api import check_parameters
    from rosorin_compile.ros.check_parameters.checking import summary

    _take_words(options)

    def checked(run: Run, description: Description) -> int:
        result = check_parameters(
            run.request(description),
            options.parameters,
            controllers=options.controllers,
            launch=options.launch,
            remaps=options.remap,
            namespace=options.namespace,
            distribution=options.distribution,
        )
        run.console.show(result.diagnostics)
        if not result.robot:
            run.no_robot(description)
            return PROBLEMS
        run.console.say(f"{description.name}: {summary(result)}")
        return PROBLEMS if has_errors(result.diagnostics) else FINE

    return for_each(options, checked, alone=_HOW)


def _take_words(options: Options) -> None:
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

"""rosorin-compile check parameters: check the parameter files of nodes against one robot."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from rosorin_compile.request import is_foreign
from rosorin_compile.ros.parameters import DISTRIBUTION
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.project import Description

from .answer import FINE, PROBLEMS
from .command import PATH, Options, check, check_options, choice, option, texts
from .run import MARK, Run, for_each

_HOW = "rosorin-compile check parameters ROBOT FILE ..."
_DESCRIPTION = re.compile(r"""^["']?robot["']?[ \t]*:[ \t]*[^\s#{]""", re.MULTILINE)
_MAX_BYTES = 1_000_000  # of a file that are searched
_FILES = "Parameter files"
_MANY: dict[str, Any] = {"type": PATH, "many": True, "metavar": "FILE ...", "section": _FILES}


@check("parameters", exits="0 no errors, 1 errors")
@check_options("[ROBOT] FILE ...", "the robot, required if there are several, and parameter files of its nodes")
@texts("--controllers", help="parameter files of a controller_manager", **_MANY)
@texts("--launch", help="launch files to read remappings from", **_MANY)
@texts("--remap", metavar="NODE:FROM:=TO", help="add a remapping", section=_FILES)
@option("--namespace", default="", metavar="NS", help="namespace of the nodes", section=_FILES)
@choice(
    "--distribution",
    DISTRIBUTION["enum"],
    help="ROS 2 distribution; default: that of the outputs, else any",
    section=_FILES,
)
def run(options: Options) -> int:
    """Check the parameter files against the robot."""
    from rosorin_compile import api
    from rosorin_compile.ros.check_parameters.checking import summary

    _take_words(options)

    def check_robot(run: Run, description: Description) -> int:
        result = api.check_parameters(
            run.request(description),
            options.parameters,
            **options.pick("controllers launch namespace distribution"),
            remaps=options.remap,
        )
        failed = run.show(result)
        if not result.robot:
            return run.no_robot(description)
        run.console.say(f"{description.name}: {summary(result)}")
        return PROBLEMS if failed else FINE

    return for_each(options, check_robot, alone=_HOW)


def _take_words(options: Options) -> None:
    """Leave the robot and its arguments in the words; the others are parameter files. Raises RequestError."""
    for words in (options.controllers, options.launch):  # arguments may follow files
        options.words += [word for word in words if MARK in word]
        words[:] = [word for word in words if MARK not in word]
    names = Run.of(options).words
    arguments = [word for word in options.words if word not in names]
    robots = names[: bool(names) and _is_robot(names[0])]
    options.parameters = names[len(robots) :]
    if not options.parameters and not options.controllers:
        raise RequestError(f"there is no parameter file to hold against a robot: {_HOW}")
    options.words = [*robots, *arguments]


def _is_robot(word: str) -> bool:
    """Return True if a word names a robot, rather than a parameter file."""
    if not files.is_file(word) or is_foreign(Path(word)) or Path(word).name == Description.ROOT_FILE:
        return True
    return _DESCRIPTION.search(files.read_bytes(word, _MAX_BYTES).decode("utf-8", "replace")) is not None

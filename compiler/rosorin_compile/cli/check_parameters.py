"""rosorin-compile check parameters: check the parameter files of nodes against one robot."""

import re
from pathlib import Path

from rosorin_compile.formats.format import DISTRIBUTIONS
from rosorin_compile.request import is_foreign
from rosorin_compile.ros.check_parameters.check import check_parameters, summary
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.project import Description

from .command import check, check_options, combine, option, repeatable
from .console import FINE, PROBLEMS
from .run import Run, for_each

_USAGE = "ROBOT FILE ..."
_DESCRIPTION = re.compile(r"""^["']?robot["']?[ \t]*:[ \t]*[^\s#{]""", re.MULTILINE)
_MAX_BYTES = 1_000_000  # of a file that are searched


@check("parameters", exits="0 no errors, 1 errors")
@check_options("[ROBOT] FILE ...", "the robot, required if there are several, and parameter files of its nodes")
@combine(
    repeatable("--controllers FILE", help="parameter file of a controller_manager; repeatable"),
    repeatable("--launch FILE", help="launch file to read remappings from; repeatable"),
    repeatable("--remap NODE:FROM:=TO", type=str, help="add a remapping"),
    option("--namespace NS", default="", help="namespace of the nodes"),
    option(f"--distribution {'|'.join(DISTRIBUTIONS)}", help="ROS 2 distribution; default: that of the outputs"),
    section="Parameter files",
)
def run_check_parameters(run: Run) -> int:
    """Check the parameter files against the robot."""
    names = run.words
    parameters = names[1:] if names and _is_robot(names[0]) else names
    if not parameters and not run.controllers:
        raise RequestError(
            f"there is no parameter file to hold against a robot: rosorin-compile check parameters {_USAGE}"
        )

    def check_robot(run: Run, description: Description) -> int:
        picked = run.pick("controllers launch namespace distribution")
        result = check_parameters(run.request(description), parameters, **picked, remaps=run.remap)
        failed = run.show(result)
        if not result.robot:
            return run.no_robot(description)
        run.console.say(f"{description.name}: {summary(result)}")
        return PROBLEMS if failed else FINE

    return for_each(run, check_robot, _USAGE, names[: len(names) - len(parameters)])


def _is_robot(word: str) -> bool:
    if not files.is_file(word) or is_foreign(Path(word)) or Path(word).name == Description.ROOT_FILE:
        return True
    return _DESCRIPTION.search(files.read_bytes(word, _MAX_BYTES).decode("utf-8", "replace")) is not None

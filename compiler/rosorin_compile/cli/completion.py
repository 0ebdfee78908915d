"""rosorin-compile completion: print the script that makes a shell complete commands, options, robots and frames."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

from .answer import give_result
from .command import Options, argument, command
from .usage import FINE, PROBLEMS, WrongUsage

SHELLS = ("bash", "zsh", "fish")


@command("completion", exits="0 printed, 1 the shell is too old")
@argument("shell", type=click.Choice(SHELLS), metavar="SHELL", help="bash, zsh or fish")
def run(options: Options) -> int:
    """Print the script of a shell."""
    from .main import COMPLETE, PROGRAM, program

    shell = get_completion_class(options.shell)
    if shell is None:
        raise WrongUsage(f"there is no completion for {options.shell}")
    try:
        script = shell(program(), {}, PROGRAM, COMPLETE).source()
    except RuntimeError as problem:
        options.answer.fail(str(problem), PROBLEMS)
        return PROBLEMS
    give_result(options, {"shell": options.shell, "script": script}, lambda: script)
    return FINE

"""rosorin-compile completion: print the script that makes a shell complete commands, options, robots and frames."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

from .answer import PROBLEMS, give_result
from .command import Options, argument, command

SHELLS = ("bash", "zsh", "fish")


@command("completion", exits="0 printed, 1 the shell is too old")
@argument("shell", type=click.Choice(SHELLS), metavar="SHELL", help="bash, zsh or fish")
def run(options: Options) -> int:
    """Print the script of a shell."""
    from .main import COMPLETE, PROGRAM, program

    shell = get_completion_class(options.shell)
    try:
        script = shell(program(), {}, PROGRAM, COMPLETE).source() if shell is not None else ""
    except RuntimeError as problem:
        options.answer.fail(str(problem), PROBLEMS)
        return PROBLEMS
    return give_result(options, {"shell": options.shell, "script": script}, lambda: script)

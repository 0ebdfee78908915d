"""rosorin-compile completion: print the script that makes a shell complete commands, options, robots and frames."""

import click
from click.shell_completion import get_completion_class

from .command import Options, argument, command
from .console import PROBLEMS


@command("completion", exits="0 printed, 1 the shell is too old")
@argument("shell", type=click.Choice(("bash", "zsh", "fish")), metavar="SHELL", help="bash, zsh or fish")
def run(options: Options) -> int:
    """Print the script of a shell."""
    from .main import COMPLETE, PROGRAM, program

    shell = get_completion_class(options.shell)
    assert shell is not None  # noqa: S101 - click has the three
    try:
        script = shell(program(), {}, PROGRAM, COMPLETE).source()
    except RuntimeError as problem:
        return options.console.fail(str(problem), PROBLEMS)
    return options.console.give({"shell": options.shell, "script": script}, lambda: script)

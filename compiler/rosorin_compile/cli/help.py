"""rosorin-compile help: show the help of a command."""

import click

from rosorin_compile.source.diagnostics import RequestError

from .command import Options, argument, command


@command("help", exits="0 shown")
@argument("names", nargs=-1, metavar="[COMMAND ...]", help="a command; default: all commands", offers=("commands",))
def run(options: Options) -> int:
    """Print the help of a command, or the list of commands."""
    from .main import PROGRAM, program

    found: click.Command | None = program()
    context = click.Context(program(), info_name=PROGRAM, help_option_names=["-h", "--help"])
    words = list(options.names)
    while words and isinstance(found, click.Group):
        name, found, words = found.resolve_command(context, words)
        if found is not None:
            context = click.Context(found, info_name=name, parent=context)
    if words:
        raise RequestError(f'{context.command_path} has no command "{words[0]}"')
    return options.console.give(context.get_help(), context.get_help)

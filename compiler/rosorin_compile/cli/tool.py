"""rosorin-compile completion, help, cmake-dir, bazel-dir: commands about the tool itself."""

import click
from click.shell_completion import get_completion_class

from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.project import data_folder

from .command import Options, argument, command
from .console import PROBLEMS


@command("completion", exits="0 printed, 1 the shell is too old")
@argument("shell", type=click.Choice(("bash", "zsh", "fish")), metavar="SHELL", help="bash, zsh or fish")
def completion(options: Options) -> int:
    """Print the script that makes a shell complete commands, options, robots and frames."""
    from .main import COMPLETE, PROGRAM, program

    shell = get_completion_class(options.shell)
    assert shell is not None  # noqa: S101 - click has the three
    try:
        script = shell(program(), {}, PROGRAM, COMPLETE).source()
    except RuntimeError as problem:
        return options.console.fail(str(problem), PROBLEMS)
    return options.console.give({"shell": options.shell, "script": script}, lambda: script)


@command("help", exits="0 shown")
@argument("names", nargs=-1, metavar="[COMMAND ...]", help="a command; default: all commands", offers=("commands",))
def show_help(options: Options) -> int:
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


_CMAKE = "Pass it to find_package(rosorin_compile) as rosorin_compile_DIR; see docs/builds.md."


@command("cmake-dir", exits="0 printed", epilog=_CMAKE)
def cmake_dir(options: Options) -> int:
    """Print the folder that has rosorin_compileConfig.cmake."""
    folder = str(data_folder("cmake"))
    return options.console.give(folder, lambda: folder)


@command("bazel-dir", exits="0 printed", epilog="rosorin_robot.bzl defines the rule; see docs/builds.md.")
def bazel_dir(options: Options) -> int:
    """Print the folder that has rosorin_robot.bzl."""
    folder = str(data_folder("bazel"))
    return options.console.give(folder, lambda: folder)

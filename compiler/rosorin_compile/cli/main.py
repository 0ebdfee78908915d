"""The command line: a click group that imports the module of a command when it is called.

Exit codes: 0 fine, 1 problems found, 2 wrong usage, 130 interrupted.
"""

from __future__ import annotations

import errno
import io
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, suppress
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem, shell_complete

from rosorin_compile.cli.console import guarded
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.progress import Progress

from . import registry, table
from .answer import FINE, PROBLEMS, USAGE, Answer, requested_format

PROGRAM = "rosorin-compile"
COMPLETE = "_ROSORIN_COMPILE_COMPLETE"  # the variable with which the scripts of shells call the program
INTERRUPTED = 130

# Words that people type for a command, and the command that they look for.
_INSTEAD = {
    "build": "all",
    "convert": "import",
    "create": "init",
    "generate": "all",
    "lint": "check",
    "new": "init",
    "show": "view",
    "validate": "check",
}
_REQUIRED = {"jinja2": "jinja2", "jsonschema": "jsonschema", "yaml": "pyyaml"}  # modules, and their packages
_STREAM_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)


class Program(click.Group):
    """The commands, in groups; a module of a command is imported when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands; nothing is imported."""
        return list(table.names("commands"))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of a name."""
        return registry.command(cmd_name)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the called command or check and its arguments. Raises click.UsageError with a suggestion."""
        name, *rest = args
        found = registry.command(name)
        if found is None:
            raise click.UsageError(f'there is no command "{name}"; {_suggestion(name)}')
        if name == table.CHECK and getattr(found, "plugin", None) is None:
            return registry.resolve_check(found, rest)
        return name, found, rest

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands in groups."""
        entries = [one for one in registry.commands().values() if not one.hidden]
        width = max(len(one.name) for one in entries)
        for group in dict.fromkeys(one.group for one in entries):
            with formatter.section(group):
                for one in entries:
                    if one.group == group:
                        formatter.write(f"{'':{formatter.current_indent}}{one.name:<{width}}  {one.help}\n")

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Return the commands that a shell offers; nothing is imported."""
        entries = table.names("commands").items()
        items = [CompletionItem(name, help=help) for name, help in entries if name.startswith(incomplete)]
        return items + click.Command.shell_complete(self, ctx, incomplete)


def _suggestion(word: str) -> str:
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.source.diagnostics import did_you_mean

    instead = _INSTEAD.get(word) or (f"print ROBOT {word}" if word in FORMATS else "")
    aliases = [name for one in table.COMMANDS for name in one.also]
    return f'say "{instead}"' if instead else did_you_mean(word, [*table.names("commands"), *aliases])


def _version(ctx: click.Context, _: click.Parameter, requested: bool) -> None:
    """Print the versions of the program and of its plug-ins."""
    from rosorin_compile.source.plugins import installed
    from rosorin_compile.source.version import __version__

    if not requested or ctx.resilient_parsing:
        return
    print(f"{PROGRAM} {__version__}")
    groups: dict[tuple[str, str], dict[str, None]] = {}
    for plugin in installed():
        groups.setdefault((plugin.distribution, plugin.version), {})[plugin.group] = None
    for (name, version), brings in groups.items():
        print(f"plug-in {name} {version} ({', '.join(brings)})")
    ctx.exit()


def program() -> Program:
    """Return the command line."""
    version = click.Option(
        ["--version"],
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=_version,
        help="Show the versions of the tool and its plug-ins, and exit.",
    )
    return Program(
        PROGRAM,
        params=[version],
        help="Compile one YAML description of a robot to URDF, MJCF, SDF, launch files and other artifacts.",
        epilog="Run rosorin-compile COMMAND --help for the options of a command.\n\n"
        "Exit codes: 0 fine, 1 problems or differences, 2 wrong usage.",
        context_settings={"help_option_names": ["-h", "--help"]},
        subcommand_metavar="COMMAND ...",
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command line, by default that of the process; return the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as standard error: no character stops a run
    with guarded():
        if COMPLETE in os.environ:  # a shell asks, and gets nothing else, whatever happens
            with suppress(Exception, SystemExit, KeyboardInterrupt), redirect_stderr(io.StringIO()):
                shell_complete(program(), {}, PROGRAM, COMPLETE, os.environ[COMPLETE])
            return FINE
        if not words:
            top = program()
            sys.stderr.write(top.get_help(click.Context(top, info_name=PROGRAM)) + "\n")
            return USAGE
        return _run(words)


def _run(words: list[str]) -> int:
    """Run a command line; return the exit code."""
    answer = Answer(form=requested_format(words))
    code = PROBLEMS
    try:
        with _errors_reported(answer):
            code = _invoke(words, answer)
        code = answer.code or code
        answer.end()
        sys.stdout.flush()
    except KeyboardInterrupt:
        return INTERRUPTED
    except OSError as problem:
        is_closed = isinstance(problem, BrokenPipeError)
        if not is_closed and (problem.filename is not None or problem.errno not in _STREAM_ERRORS):
            raise
        # Let standard output lead nowhere, so that Python does not try to write the rest at the end.
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())
        if not is_closed:
            sys.stderr.write(f"{PROGRAM}: cannot write to standard output: {problem.strerror}\n")
        return PROBLEMS
    finally:
        Progress.hide()
    return code


def _invoke(words: list[str], answer: Answer) -> int:
    """Parse a command line and run its command; return the exit code."""
    try:
        top = program()
        with top.make_context(PROGRAM, words, obj=answer) as context:
            code: Any = top.invoke(context)
            return code if isinstance(code, int) else FINE
    except click.exceptions.Exit as ended:
        answer.form = "text"  # the help or the version was printed
        return ended.exit_code


@contextmanager
def _errors_reported(answer: Answer) -> Iterator[None]:
    """Report errors of the block that end the run, in one sentence each; set the exit code."""
    try:
        yield
    except click.UsageError as problem:
        where = problem.ctx.command_path if problem.ctx is not None else PROGRAM
        answer.fail(_usage_message(problem, where), USAGE)
    except RequestError as problem:
        answer.fail(str(problem), USAGE)
    except PluginFailed as problem:
        answer.console().show([problem.diagnostic])
        answer.code = PROBLEMS
    except ModuleNotFoundError as problem:
        if problem.name not in _REQUIRED:
            raise
        package = _REQUIRED[problem.name]
        missing = f"the package {package} is not installed, and no robot is read without it"
        answer.fail(f"{missing}: pip install {package}", USAGE)
    except RecursionError:
        answer.fail("the input is nested too deeply: includes, parts or expressions refer to each other", PROBLEMS)
    except MemoryError:
        answer.fail("not enough memory", PROBLEMS)
    except OverflowError as problem:
        answer.fail(f"a number is too large: {problem}", PROBLEMS)
    except (BrokenPipeError, KeyboardInterrupt):
        raise
    except OSError as problem:
        if problem.filename is None and problem.errno in _STREAM_ERRORS:
            raise
        if problem.errno == errno.ENAMETOOLONG:
            answer.fail(f"no file can have so long a name: {str(problem.filename)[:60]}...", USAGE)
        elif _is_folder_gone():
            answer.fail("the current folder was removed; change to another one", USAGE)
        else:
            name = f"{problem.filename}: " if problem.filename is not None else ""
            answer.fail(f"{name}{problem.strerror or problem}", PROBLEMS)
    except Exception as problem:
        if isinstance(problem.__cause__, KeyboardInterrupt):  # Python 3.11 wraps what comes while a class is made
            raise KeyboardInterrupt from None
        raise


def _usage_message(problem: click.UsageError, where: str) -> str:
    """Return what is wrong with a command line, with a suggestion or the command that shows the help."""
    from rosorin_compile.source.diagnostics import did_you_mean

    called = where.removeprefix(PROGRAM).strip()
    if isinstance(problem, click.NoSuchOption) and problem.ctx is not None:
        options = [name for one in problem.ctx.command.params for name in one.opts if name.startswith("--")]
        return f"{called or PROGRAM} has no option {problem.option_name}; {did_you_mean(problem.option_name, options)}"
    message = problem.format_message().rstrip(".")
    return f"{called}: {message}; see {where} --help".removeprefix(": ") if "; " not in message else message


def _is_folder_gone() -> bool:
    try:
        return not Path.cwd()
    except OSError:
        return True

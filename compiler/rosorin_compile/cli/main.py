"""The command line: a click group that imports the module or plug-in of a command only when it is called."""

import errno
import io
import os
import re
import sys
from collections.abc import Iterable, Sequence
from contextlib import redirect_stderr, suppress
from dataclasses import replace
from importlib import import_module
from itertools import groupby
from pathlib import Path

import click
from click.shell_completion import CompletionItem, shell_complete

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, DiagnosticError, RequestError, UnknownName
from rosorin_compile.source.plugins import PluginFailed, broken_plugin, clash, failed_plugin, installed_plugins, load
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import NoDescription
from rosorin_compile.source.version import __version__

from .command import ALIASES, BUILT_IN, CHECK, COMMANDS, Command, Entry, names
from .console import FINE, PROBLEMS, USAGE, Console, guard

PROGRAM = "rosorin-compile"
COMPLETE = "_ROSORIN_COMPILE_COMPLETE"  # the environment variable that completion scripts set
INTERRUPTED = 130

_REQUIRED = {"jinja2": "jinja2", "jsonschema": "jsonschema", "yaml": "pyyaml"}  # {module: name for pip}
_STREAM_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)


def commands(group: str = "commands") -> dict[str, Entry]:
    """Return all "commands" or "checks" by name, in the order of the help."""
    found = {**BUILT_IN[group]}
    if any(plugin.group == group for plugin in installed_plugins()):
        more, wrong = _load_plugins(group, {*found, *ALIASES})
        _warn(wrong)
        found |= {str(one.name): Entry(str(one.name), one.group, one.short_help or "", one.hidden) for one in more}
    groups = list(dict.fromkeys([*COMMANDS, *(entry.group for entry in found.values())]))
    return dict(sorted(found.items(), key=lambda item: groups.index(item[1].group)))


def find_command(name: str, group: str = "commands") -> click.Command | None:
    """Find a command or check, or return None if the name is unknown. Built-in ones come first. Raises PluginFailed."""
    plugins = [plugin for plugin in installed_plugins() if (plugin.group, plugin.name) == (group, name)]
    entry = ALIASES.get(name, name)
    if entry in BUILT_IN[group]:
        _warn(clash(plugin, name) for plugin in plugins)
        module = import_module(f".{BUILT_IN[group][entry].module}", __package__)
        return next(one for one in vars(module).values() if isinstance(one, click.Command) and one.name == entry)
    if not plugins:
        return None
    found, wrong = _load_plugins(group, set(), name)
    if wrong and not found:
        raise PluginFailed(wrong[0])
    _warn(wrong)
    return next(iter(found), None)


def _load_plugins(group: str, taken: set[str], called: str | None = None) -> tuple[list[Command], list[Diagnostic]]:
    """Load the plug-in command ``called``, or all; return the commands, and errors about invalid plug-ins."""
    found, diagnostics = load(group, Command, lambda one: (one.name or "",), taken.__contains__, called)
    for plugin, one in found:
        one.plugin = plugin
    wrong = [(plugin, one.name) for plugin, one in found if one.name != plugin.name]
    broken = [broken_plugin(one, f'is called "{name}", and its entry point "{one.name}"') for one, name in wrong]
    return [one for plugin, one in found if one.name == plugin.name], [*diagnostics, *broken]


def _warn(diagnostics: Iterable[Diagnostic]) -> None:
    """Print errors about plug-ins as warnings, because this run does not need these plug-ins."""
    Console().show([replace(one, severity=WARNING) for one in diagnostics])


class Program(click.Group):
    """The click group of all commands. The module of a command is imported when the command is called."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the name of the called command or check, the command, and the remaining arguments."""
        name, *rest = args
        found = find_command(name)
        if found is None:
            raise UnknownName("command", name, [*names("commands"), *ALIASES])
        if name == CHECK and rest and (inner := find_command(rest[0], "checks")) is not None:
            return f"{CHECK} {rest[0]}", inner, rest[1:]
        return name, found, rest

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        entries = [entry for entry in commands().values() if not entry.hidden]
        width = max(len(entry.name) for entry in entries)
        for group, listed in groupby(entries, lambda entry: entry.group):
            with formatter.section(group):
                for entry in listed:
                    formatter.write(f"{'':{formatter.current_indent}}{entry.name:<{width}}  {entry.help}\n")

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        entries = names("commands").items()
        items = [CompletionItem(name, help=help) for name, help in entries if name.startswith(incomplete)]
        return items + click.Command.shell_complete(self, ctx, incomplete)


def _version(ctx: click.Context, _: click.Parameter, requested: bool) -> None:
    if not requested or ctx.resilient_parsing:
        return
    print(f"{PROGRAM} {__version__}")
    for (name, version), plugins in groupby(installed_plugins(), lambda plugin: plugin[:2]):
        print(f"plug-in {name} {version} ({', '.join(dict.fromkeys(plugin.group for plugin in plugins))})")
    ctx.exit()


def program() -> Program:
    """Create the click group ``rosorin-compile``."""
    help = "Show the versions of the tool and its plug-ins, and exit."
    version = click.Option(["--version"], is_flag=True, is_eager=True, expose_value=False, callback=_version, help=help)
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
    """Run a command line, by default the arguments of the process; return the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # escape characters that the encoding lacks, as stderr does
    with guard():
        if COMPLETE in os.environ:  # called by a completion script: print only completions, and no errors
            with suppress(Exception, SystemExit, KeyboardInterrupt), redirect_stderr(io.StringIO()):
                shell_complete(program(), {}, PROGRAM, COMPLETE, os.environ[COMPLETE])
            return FINE
        if not words:
            top = program()
            sys.stderr.write(top.get_help(click.Context(top, info_name=PROGRAM)) + "\n")
            return USAGE
        try:
            formats = re.findall(r"(?<=^--format[=\n])\w+$", "\n".join(words), re.MULTILINE)  # click can fail
            console = Console("json" if formats[-1:] == ["json"] else "text")
            code = _run(words, console)
            console.print_end()
            sys.stdout.flush()
            return code
        except (KeyboardInterrupt, click.Abort):
            return INTERRUPTED
        except OSError as problem:
            # Writing to standard output failed. This needs no message if the reader has exited, as in "| head".
            is_closed = isinstance(problem, BrokenPipeError)
            if not is_closed and (problem.filename is not None or problem.errno not in _STREAM_ERRORS):
                raise
            # Redirect standard output to the null device: Python flushes the buffer at exit, which would fail again.
            with Path(os.devnull).open("wb") as nowhere:
                os.dup2(nowhere.fileno(), sys.stdout.fileno())
            if not is_closed:
                sys.stderr.write(f"{PROGRAM}: cannot write to standard output: {problem.strerror}\n")
            return PROBLEMS
        finally:
            Progress.hide()


def _run(words: list[str], console: Console) -> int:
    """Run a command line, and report an error that ends the run in one sentence; return the exit code."""
    try:
        with program().make_context(PROGRAM, words, obj=console) as context:
            return int(context.command.invoke(context) or FINE)
    except click.exceptions.Exit as ended:
        console.form = "text"  # click has printed the help or the version: do not print JSON as well
        return ended.exit_code
    except click.UsageError as problem:
        return console.fail(_usage_message(problem), USAGE)
    except (NoDescription, RequestError) as problem:
        return console.fail(str(problem), USAGE)
    except DiagnosticError as problem:
        console.show([problem.diagnostic])
        return PROBLEMS
    except (BrokenPipeError, KeyboardInterrupt, click.Abort):
        raise
    except (Exception, SystemExit) as problem:
        if isinstance(problem.__cause__, KeyboardInterrupt):  # Python 3.11 wraps exceptions while a class is created
            raise KeyboardInterrupt from None
        if console.plugin is not None:
            console.show([failed_plugin(console.plugin, problem)])
            return PROBLEMS
        if isinstance(problem, ModuleNotFoundError) and (package := _REQUIRED.get(problem.name or "")):
            missing = f"the package {package} is not installed, and no robot is read without it"
            return console.fail(f"{missing}: pip install {package}", USAGE)
        return console.fail(_reason(problem), PROBLEMS)


def _reason(problem: BaseException) -> str:
    """Return the message for an exception that a user can cause, such as OSError. Raises any other exception."""
    from rosorin_compile.model.servos import NoPulse

    if isinstance(problem, NoPulse):
        return str(problem)
    if isinstance(problem, RecursionError):
        return "the input is nested too deeply: includes, parts or expressions refer to each other"
    if type(problem) is MemoryError:
        return "not enough memory"
    if type(problem) is OverflowError:
        return f"a number is too large: {problem}"
    if isinstance(problem, OSError) and (problem.filename is not None or problem.errno not in _STREAM_ERRORS):
        return f"{problem.filename}: {problem.strerror or problem}".removeprefix("None: ")
    raise problem


def _usage_message(problem: click.UsageError) -> str:
    """Return the message for an invalid command line, with a suggestion or the command that shows the help."""
    where = problem.ctx.command_path if problem.ctx is not None else PROGRAM
    called = where.removeprefix(PROGRAM).strip()
    if isinstance(problem, click.NoSuchOption) and problem.ctx is not None:
        options = [name for param in problem.ctx.command.params for name in param.opts if name.startswith("--")]
        return str(UnknownName("option", problem.option_name, options, called or PROGRAM))
    message = problem.format_message().rstrip(".")
    return f"{called}: {message}; see {where} --help".removeprefix(": ") if "; " not in message else message

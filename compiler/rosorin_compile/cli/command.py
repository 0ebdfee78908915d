"""Commands, checks and their options: click commands with grouped help and one way of running.

``command`` and ``check`` turn a function that takes parsed ``Options`` and returns an exit code into one of them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from types import SimpleNamespace
from typing import Any, TypeVar

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from rosorin_compile.cli.console import ENVELOPE, MARKDOWN, show_progress
from rosorin_compile.source.cache import cache_refused
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, RequestError, did_you_mean
from rosorin_compile.source.plugins import Plugin, PluginFailed, broken, failed
from rosorin_compile.source.rule_registry import WRITING, Rule
from rosorin_compile.source.system import missed

from . import complete
from .answer import FINE, PROBLEMS, Answer
from .table import entry

RULES = (
    Rule(
        "cache-not-private",
        "A note: another user could change the folder of the cache, so the cache is not used.",
        "`chmod go-w` of the folder that is named, or another one in `ROSORIN_COMPILE_CACHE`.",
        WRITING,
    ),
    Rule(
        "system-lacks",
        "A note: this system has no locks, or no limits of a process, as Windows has none; the run goes on without.",
        "Let nothing else write into the folder that is named; give it files of people whom you trust.",
        WRITING,
    ),
)

Sections = Callable[[], Mapping[str, Sequence[tuple[str, str]]]]
FORMAT_NAMES = ("text", ENVELOPE, "github", "sarif", MARKDOWN)
PAGE_MEGABYTES = 40  # of the meshes of a page
ROBOT_HELP = "name of a robot in descriptions/, or a folder or file"
ROBOTS_HELP = f"{ROBOT_HELP}; default: all robots"
POSITIONS = "Joint positions (default: zero)"
_ARGUMENTS = "Arguments of the description or the xacro file"


class Options(SimpleNamespace):
    """The parsed options of one run by name; repeatable options and ``words`` are lists."""

    def pick(self, names: str) -> dict[str, Any]:
        """Return the values of some options by name, as arguments of the API."""
        return {name: getattr(self, name) for name in names.split()}


Run = Callable[[Options], int]
Decorated = TypeVar("Decorated", bound=Callable[..., Any])
Decorator = Callable[[Decorated], Decorated]


class Option(click.Option):
    """An option with the ``section`` of the help that lists it, and names of options that it ``excludes``.

    ``many`` options take all words up to the next option.
    """

    def __init__(
        self, *words: Any, section: str = "", excludes: Sequence[str] = (), many: bool = False, **settings: Any
    ) -> None:
        self.section = section
        self.many = many
        self.excludes = tuple(excludes)
        super().__init__(*words, **settings)


class Argument(click.Argument):
    """An argument with a line of help."""

    def __init__(self, *words: Any, help: str = "", **settings: Any) -> None:
        super().__init__(*words, **settings)
        self.help = help

    def get_help_record(self, ctx: click.Context) -> tuple[str, str]:
        """Return the name and the help of this argument."""
        return self.metavar or self.human_readable_name, self.help or ""


class Command(click.Command):
    """A command: ``rosorin-compile NAME``.

    ``group`` is the heading of the help that lists it and ``order`` its place there; ``also`` are alternative names.
    ``exits`` describes the exit codes 0 and 1; a ``hidden`` command is not listed. ``more`` is added to the help, and
    ``sections`` returns lists to add to it. ``within`` is the command that this one belongs to.
    """

    def __init__(
        self,
        name: str,
        run: Run,
        params: Sequence[click.Parameter] = (),
        *,
        help: str,
        group: str = "plug-ins",
        exits: str = "0 fine, 1 errors",
        more: str = "",
        order: int = 100,
        also: Sequence[str] = (),
        hidden: bool = False,
        sections: Sections | None = None,
        within: str = "",
    ) -> None:
        if not re.fullmatch("[a-z][a-z0-9-]*", name):
            raise ValueError(f'"{name}" is not a valid name of a command')
        for field, text in (("help", help), ("group", group), ("exits", exits)):
            if not isinstance(text, str):
                raise TypeError(f"{field} of {name} is a str, not {str(text)[:60]!r}")
        super().__init__(name, params=[*params], help=help, hidden=hidden, short_help=help)
        self.run = run
        self.group = group
        self.exits = exits
        self.more = more
        self.order = order
        self.also = tuple(also)
        self.sections = sections
        self.called = f"{within} {name}".strip()
        self.plugin: Plugin | None = None

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Parse the arguments of this command. Raises PluginFailed."""
        if parent is not None and isinstance(parent.obj, Answer):
            parent.obj.command = self.called
        with self.guarded():
            return super().make_context(info_name, args, parent, **extra)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments, and reject options that exclude each other."""
        many = {name for one in self.params if getattr(one, "many", False) for name in one.opts}
        repeated: list[str] = []  # the arguments, with an option that takes many words repeated for each of them
        current = ""
        for arg in args:
            if arg.startswith("-") and arg != "-":
                current = arg if arg in many else ""
            elif current and repeated[-1] != current:
                repeated.append(current)
            repeated.append(arg)
        rest = super().parse_args(ctx, repeated)
        used = {
            one.name: one.opts[-1]
            for one in self.params
            if ctx.get_parameter_source(one.name or "") == ParameterSource.COMMANDLINE
        }
        for one in self.params if not ctx.resilient_parsing else ():
            other = next((used[name] for name in getattr(one, "excludes", ()) if name in used), None)
            if one.name in used and other is not None:
                raise click.UsageError(f"argument {one.opts[-1]}: not allowed with argument {other}", ctx)
        return rest

    def invoke(self, ctx: click.Context) -> int:
        """Run this command; return the exit code. Raises RequestError, PluginFailed."""
        answer = ctx.obj if isinstance(ctx.obj, Answer) else Answer()
        options = self.options(ctx)
        options.answer, answer.command, answer.form = answer, self.called, options.format
        seconds = getattr(options, "xacro_seconds", None)
        if seconds is not None:
            if seconds < 1:
                raise RequestError(f"--xacro-seconds takes 1 or more seconds, not {seconds}")
            os.environ["ROSORIN_COMPILE_XACRO_SECONDS"] = str(seconds)  # for all processes of the run
        if options.format in ("text", "github", "markdown") and not options.quiet:
            show_progress()
        with self.guarded():
            code = self.run(options)
        if self.plugin is not None and type(code) is not int:
            raise PluginFailed(broken(self.plugin, f"gives no exit code, but {str(code)[:60]!r}"))
        if not options.quiet:
            notes = [Diagnostic("system-lacks", NOTE, message) for message in missed()]
            if refused := cache_refused():
                notes.insert(0, Diagnostic("cache-not-private", NOTE, refused[0], help=refused[1]))
            if notes:
                answer.console().show(notes)
        fail_on = getattr(options, "fail_on", "error")
        if fail_on == "never" and code == PROBLEMS:
            return FINE
        if fail_on == "warning" and code == FINE and (answer.severities["error"] or answer.severities["warning"]):
            return PROBLEMS
        return code

    def options(self, ctx: click.Context) -> Options:
        """Return the parsed options of a context."""
        values = {name: list(value) if isinstance(value, tuple) else value for name, value in ctx.params.items()}
        return Options(**values, called=self.called, plugin=self.plugin)

    @contextmanager
    def guarded(self) -> Iterator[None]:
        """Turn whatever the code of a plug-in raises in the block into PluginFailed."""
        try:
            yield
        except (RequestError, PluginFailed, BrokenPipeError, click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except (Exception, SystemExit) as problem:
            if self.plugin is None:
                raise
            raise PluginFailed(failed(self.plugin, problem)) from None

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what this command does, and its other names."""
        text = self.help or ""
        also = [name for name in (self.name or "", *self.also) if name != ctx.info_name] if self.also else []
        paragraphs = [f"{text[:1].upper()}{text[1:]}.", self.more, f"Alias: {', '.join(also)}." if also else ""]
        formatter.write_paragraph()
        with formatter.indentation():
            formatter.write_text(" ".join(filter(None, paragraphs)))

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the arguments, and the options by section."""
        headed: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for one in self.get_params(ctx):
            record = one.get_help_record(ctx)
            if record is not None:
                head = "Arguments" if isinstance(one, Argument) else getattr(one, "section", "") or "Options"
                headed.setdefault(head, []).append(record)
        more = self.sections() if self.sections is not None else {}
        for head, rows in [*headed.items(), *more.items()]:
            if rows:
                with formatter.section(head):
                    formatter.write_dl(list(rows))

    def format_arguments(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write nothing: ``format_options`` writes the arguments, also with versions of click that have no help."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the exit codes."""
        formatter.write_paragraph()
        formatter.write_text(f"Exit codes: {self.exits}, 2 wrong usage.")


class Check(Command):
    """A check: ``rosorin-compile check NAME``. The parameters are those of ``Command``."""

    def __init__(self, name: str, run: Run, params: Sequence[click.Parameter] = (), **settings: Any) -> None:
        super().__init__(name, run, params, within="check", **settings)


class CommandGroup(click.Group):
    """A command that only has commands within it, such as ``extract``."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command within this one, and the arguments that are left for it."""
        if args[0] not in self.commands and not ctx.resilient_parsing:
            raise click.UsageError(f'{self.name} has no command "{args[0]}"; {did_you_mean(args[0], self.commands)}')
        return super().resolve_command(ctx, args)


def command(name: str, kind: type[Command] = Command, **settings: Any) -> Callable[[Run], Command]:
    """Return a decorator that makes a function that takes ``Options`` a command; built-in ones are in the registry."""
    listed = entry(name, "checks" if kind is Check else "commands") if "help" not in settings else None
    if listed is not None:
        settings |= {key: getattr(listed, key) for key in ("help", "group", "order", "also", "hidden")}

    def decorate(run: Run) -> Command:
        # click keeps the parameters of decorators in reverse order
        decorated = [*output_options(lambda: None).__click_params__, *getattr(run, "__click_params__", [])]
        return kind(name, run, decorated[::-1], **settings)

    return decorate


check = partial(command, kind=Check)


def option(*names: str, **settings: Any) -> Decorator[Any]:
    """Return a decorator that adds an ``Option``; it can be used several times, also with click 8.0."""
    return lambda function: click.option(*names, cls=Option, **settings)(function)


def argument(*names: str, **settings: Any) -> Decorator[Any]:
    """Return a decorator that adds an ``Argument``; it can be used several times, also with click 8.0."""
    return lambda function: click.argument(*names, cls=Argument, **settings)(function)


def combined(*decorators: Decorator[Any]) -> Decorator[Any]:
    """Return one decorator that adds the parameters of several, in their order."""

    def decorate(function: Decorated) -> Decorated:
        for decorator in reversed(decorators):
            function = decorator(function)
        return function

    return decorate


class _Path(click.ParamType):  # type: ignore[type-arg] # not generic before click 8.4
    """The name of a file or folder, which must not be empty."""

    name = "path"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name."""
        return value or self.fail("the name is empty", param, ctx)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Let the shell complete files."""
        return [CompletionItem(incomplete, type="dir" if "FOLDER" in str(param.metavar) else "file")]


PATH = _Path()


def path_option(*names: str, metavar: str, help: str, **settings: Any) -> Decorator[Any]:
    """Return an option that takes the name of a file or folder, which the shell completes."""
    return option(*names, type=PATH, metavar=metavar, help=help, **settings)


def flag(*names: str, help: str, **settings: Any) -> Decorator[Any]:
    """Return an option without a value."""
    return option(*names, is_flag=True, help=help, **settings)


def choice(name: str, values: Sequence[str], **settings: Any) -> Decorator[Any]:
    """Return an option that takes one of some values."""
    return option(name, type=click.Choice(values), **settings)


def texts(*names: str, metavar: str, help: str, offers: str = "", **settings: Any) -> Decorator[Any]:
    """Return a repeatable option; ``offers`` is the kind of names that a shell completes."""
    completion = {"shell_complete": complete.of(offers)} if offers else {}
    return option(*names, multiple=True, metavar=metavar, help=help, **completion, **settings)


def words_argument(
    metavar: str, help: str = "", required: bool = False, offers: complete.Offers = ()
) -> Decorator[Any]:
    """Return the arguments of a command as ``words``; ``offers`` are the kinds of names that a shell completes."""
    return argument(
        "words", nargs=-1, required=required, metavar=metavar, help=help, shell_complete=complete.of(*offers)
    )


output_options = combined(
    choice(
        "--format",
        FORMAT_NAMES,
        metavar="FORMAT",
        default="text",
        help=f"format of the output: {', '.join(FORMAT_NAMES[:-1])} or {FORMAT_NAMES[-1]}; default: text",
    ),
    flag("-q", "--quiet", help="print only errors and the result", excludes=("verbose",)),
    flag("-v", "--verbose", help="print all notes, and the files that were read"),
)
robot_options = combined(
    texts(
        "--package",
        "packages",
        metavar="NAME=PATH",
        help="folder of a ROS package, for $(find NAME) and package://NAME; repeatable",
    ),
    flag("--trust", help="do not warn about code that a xacro file can run"),
    option("--xacro-seconds", type=int, metavar="S", help="time limit for a xacro file in seconds; default: 60"),
    texts(
        "-a",
        "--arg",
        metavar="NAME=VALUE",
        help="set an argument; NAME:=VALUE without -a is the same",
        section=_ARGUMENTS,
        offers="argument=",
    ),
    texts(
        "--args",
        "args_files",
        metavar="FILE",
        help="read arguments from a YAML file; -a overrides them",
        section=_ARGUMENTS,
        offers="file",
    ),
)
robot_argument = words_argument("[ROBOT]", f"{ROBOT_HELP}; required if there are several", offers=("robot", "argument"))
output_folder_option = path_option(
    "-o",
    "--output",
    metavar="FOLDER",
    help="folder of the artifacts, with a subfolder for each of several robots; default: outputs/ROBOT",
)
summary_option = path_option("--summary", metavar="FILE", help="also append the messages to a file, as Markdown")
notes_option = flag("--notes", help="list notes and stand-ins instead of counting them")
full_option = flag("--full", help="print differences of texts in full")
dry_run_option = flag("-n", "--dry-run", help="write nothing; print what would change")
force_option = flag("--force", help="replace a file that this command did not write")
fail_on_option = choice(
    "--fail-on",
    ("error", "warning", "never"),
    metavar="SEVERITY",
    default="error",
    help="exit with 1 if a message has this severity or a higher one: error, warning or never; default: error",
)


def robots_argument(
    metavar: str = "[ROBOT ...]", help: str = ROBOTS_HELP, offers: complete.Offers = ("robot", "argument")
) -> Decorator[Any]:
    """Return the robots of a command that handles several, with the options that every robot takes."""
    return combined(words_argument(metavar, help, offers=offers), robot_options)


def check_options(
    metavar: str = "[ROBOT ...]", help: str = ROBOTS_HELP, offers: complete.Offers = ("robot", "argument")
) -> Decorator[Any]:
    """Return what every check takes: robots, the folder of the artifacts, a summary and the severity that fails."""
    return combined(robots_argument(metavar, help, offers), output_folder_option, summary_option, fail_on_option)


def hook_option(more: str = "") -> Decorator[Any]:
    """Return the option for pre-commit."""
    return flag(
        "--hook", help=f"for pre-commit: take changed files as arguments and use all robots of their projects{more}"
    )


def page_options(what: str) -> Decorator[Any]:
    """Return the options of an HTML page; ``what`` describes it."""
    return combined(
        path_option("--html", metavar="FILE", help=what),
        flag("--no-meshes", help="with --html: leave out the meshes"),
        option(
            "--max-megabytes",
            type=float,
            metavar="NUMBER",
            help=f"with --html: size limit for all meshes together, in MB; default: {PAGE_MEGABYTES}",
        ),
    )


def depfile_options(target: str) -> Decorator[Any]:
    """Return the options for depfiles; ``target`` describes the default target."""
    return combined(
        path_option("--depfile", metavar="FILE", help="write the files that were read as a Make and Ninja depfile"),
        path_option("--depfile-target", metavar="NAME", help=f"target in the depfile; {target}"),
    )


def mode_option(unnamed: str, section: str = "") -> Decorator[Any]:
    """Return the option that switches modes; ``unnamed`` describes the state of the other modes."""
    help = f'switch a mode on or off: slam, "not slam" or slam=off; other modes: {unnamed}'
    return texts("--mode", "modes", metavar="MODE", help=help, section=section, offers="mode")


def pose_option(help: str, section: str = "") -> Decorator[Any]:
    """Return the option that names a pose of the description."""
    return option("--pose", default="", metavar="POSE", help=help, section=section, shell_complete=complete.of("pose"))


def position_options(sweep: bool = False) -> Decorator[Any]:
    """Return the options that set the positions of joints; ``sweep`` adds one that takes several in turn."""
    joints = {"section": POSITIONS, "offers": "joint="}
    overridden = "--pose and --pulse" if sweep else "--pose"
    position = f"position, such as 30deg, 5cm or 1,2,30deg; overrides {overridden}"
    count = "use COUNT positions in turn; repeatable: all combinations"
    return combined(
        pose_option("named pose of the description", POSITIONS),
        texts("--pulse", "pulses", metavar="JOINT=PULSE", help="pulse sent to the servo; overrides --pose", **joints),
        texts("--joint", "joints", metavar="JOINT=VALUE", help=position, **joints),
        *([texts("--sweep", "sweeps", metavar="JOINT=FROM:TO:COUNT", help=count, **joints)] if sweep else []),
    )

"""Commands and checks: click commands with grouped help and one way of running.

``command`` and ``check`` turn a function that takes parsed ``Options`` and returns an exit code into one of them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.core import ParameterSource

from rosorin_compile.source.console import ENVELOPE, MARKDOWN, show_progress
from rosorin_compile.source.plugins import Plugin, PluginFailed, broken, failed

from .answer import Answer
from .table import entry
from .usage import FINE, PROBLEMS, WrongUsage, tell_of_cache, tell_of_system

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

Complete = Callable[[click.Context, click.Parameter, str], "list[CompletionItem] | list[str]"]
Sections = Callable[[], Mapping[str, Sequence[tuple[str, str]]]]
_NAME = re.compile(r"[a-z][a-z0-9-]*")
FORMAT_NAMES = ("text", ENVELOPE, "github", "sarif", MARKDOWN)
_FAIL_ON = {"error": ("error",), "warning": ("error", "warning")}


class Options(SimpleNamespace):
    """The parsed options of one run by name; repeatable options and ``words`` are lists."""


Run = Callable[[Options], int]
Decorated = TypeVar("Decorated", bound=Callable[..., Any])


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


def option(*names: str, **settings: Any) -> Callable[[Decorated], Decorated]:
    """Return a decorator that adds an ``Option``; it can be used several times, also with click 8.0."""
    return lambda function: click.option(*names, cls=Option, **settings)(function)


def argument(*names: str, **settings: Any) -> Callable[[Decorated], Decorated]:
    """Return a decorator that adds an ``Argument``; it can be used several times, also with click 8.0."""
    return lambda function: click.argument(*names, cls=Argument, **settings)(function)


def combined(*decorators: Callable[[Decorated], Decorated]) -> Callable[[Decorated], Decorated]:
    """Return one decorator that adds the parameters of several, in their order."""

    def decorate(function: Decorated) -> Decorated:
        for decorator in reversed(decorators):
            function = decorator(function)
        return function

    return decorate


output_options = combined(
    option(
        "--format",
        type=click.Choice(FORMAT_NAMES),
        metavar="FORMAT",
        default="text",
        help=f"format of the output: {', '.join(FORMAT_NAMES[:-1])} or {FORMAT_NAMES[-1]}; default: text",
    ),
    option("-q", "--quiet", is_flag=True, help="print only errors and the result", excludes=("verbose",)),
    option("-v", "--verbose", is_flag=True, help="print all notes, and the files that were read"),
)


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
        if not _NAME.fullmatch(name):
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
        rest = super().parse_args(ctx, self._split(args))
        if ctx.resilient_parsing:
            return rest
        given = {
            one.name: one
            for one in self.params
            if ctx.get_parameter_source(one.name or "") == ParameterSource.COMMANDLINE
        }
        for one in given.values():
            other = next((given[name] for name in getattr(one, "excludes", ()) if name in given), None)
            if other is not None:
                raise click.UsageError(f"argument {one.opts[-1]}: not allowed with argument {other.opts[-1]}", ctx)
        return rest

    def _split(self, args: Sequence[str]) -> list[str]:
        """Return arguments in which an option that takes many words is repeated for each of them."""
        many = {name for one in self.params if getattr(one, "many", False) for name in one.opts}
        split: list[str] = []
        current = ""
        for arg in args:
            if arg.startswith("-") and arg != "-":
                current = arg if arg in many else ""
            elif current and split[-1] != current:
                split.append(current)
            split.append(arg)
        return split

    def invoke(self, ctx: click.Context) -> int:
        """Run this command; return the exit code. Raises WrongUsage, PluginFailed."""
        answer = ctx.obj if isinstance(ctx.obj, Answer) else Answer()
        options = self.options(ctx)
        options.answer, answer.command = answer, self.called
        answer.form = options.format
        if getattr(options, "xacro_seconds", None):
            os.environ["ROSORIN_COMPILE_XACRO_SECONDS"] = str(options.xacro_seconds)  # for all processes of the run
        if options.format in ("text", "github", "markdown") and not options.quiet:
            show_progress()
        with self.guarded():
            code = self.run(options)
        if self.plugin is not None and type(code) is not int:
            raise PluginFailed(broken(self.plugin, f"gives no exit code, but {str(code)[:60]!r}"))
        if not options.quiet:
            console = answer.console()
            tell_of_cache(console)
            tell_of_system(console)
        return _by_severity(code, getattr(options, "fail_on", None), answer)

    def options(self, ctx: click.Context) -> Options:
        """Return the parsed options of a context."""
        values = {name: list(value) if isinstance(value, tuple) else value for name, value in ctx.params.items()}
        return Options(**values, called=self.called, plugin=self.plugin)

    @contextmanager
    def guarded(self) -> Iterator[None]:
        """Turn whatever the code of a plug-in raises in the block into PluginFailed."""
        if self.plugin is None:
            yield
            return
        try:
            yield
        except (WrongUsage, PluginFailed, BrokenPipeError, click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except (Exception, SystemExit) as problem:
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


class Ways(click.Group):
    """A command that only has commands within it, such as ``extract``."""

    def __init__(self, name: str, ways: Sequence[Command], **settings: Any) -> None:
        super().__init__(name, commands={one.name or "": one for one in ways}, **settings)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command within this one, and the arguments that are left for it."""
        from rosorin_compile.source.diagnostics import did_you_mean

        if args[0] not in self.commands and not ctx.resilient_parsing:
            raise click.UsageError(f'{self.name} has no command "{args[0]}"; {did_you_mean(args[0], self.commands)}')
        return super().resolve_command(ctx, args)


def command(name: str, kind: type[Command] = Command, **settings: Any) -> Callable[[Run], Command]:
    """Return a decorator that makes a function that takes ``Options`` a command; built-in ones are in the registry."""
    if "help" not in settings:
        group = "checks" if kind is Check else "commands"
        listed = entry(name, group)
        settings |= {"help": listed.help, "group": listed.group, "order": listed.order}
        settings |= {"also": listed.also, "hidden": listed.hidden}

    def decorate(run: Run) -> Command:
        return kind(name, run, [*parameters(run), *parameters(output_options(lambda: None))], **settings)

    return decorate


check = partial(command, kind=Check)


def parameters(decorated: Callable[..., Any]) -> list[click.Parameter]:
    """Return the parameters that decorators have added to a function, in the order in which they are written."""
    return list(reversed(getattr(decorated, "__click_params__", [])))


def _by_severity(code: int, fail_on: str | None, answer: Answer) -> int:
    """Return the exit code with the rule of --fail-on: 1 if a diagnostic of that severity or worse was reported."""
    if fail_on is None or fail_on == "error" or code not in (FINE, PROBLEMS):
        return code
    if fail_on == "never":
        return FINE
    return PROBLEMS if any(answer.severities[severity] for severity in _FAIL_ON[fail_on]) else code

"""Define and run commands, and provide shell completion that never runs code of a robot."""

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial, reduce
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import click
from click.shell_completion import CompletionItem

from rosorin_compile.source.cache import cache_refused
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, RequestError
from rosorin_compile.source.plugins import Plugin, PluginFailed, broken_plugin, installed_plugins
from rosorin_compile.source.system import take_missing

from .console import FINE, PROBLEMS, Console, show_progress

if TYPE_CHECKING:
    from rosorin_compile.source.project import Description

    from .run import Run


CHECK = "check"  # the command whose subcommands are checks
# {heading in the help: {command: (module that defines the command, line of help)}}
COMMANDS = {
    "describe and compile": {
        "init": ("import_robot", "create a new robot description"),
        "all": ("artifacts", "compile robots and write all artifacts; alias: compile"),
        "print": ("artifacts", "compile a robot and print one artifact to standard output"),
        "check": ("check", "compile robots and compare them with the committed artifacts"),
        "watch": ("watch", "compile on every change of a file and print the changes of the robot"),
        "sweep": ("watch", "compile many variants of one robot, each to a separate folder"),
        "collisions": ("simulate", "compute the pairs of links that MoveIt does not need to check"),
        "schema": ("tool", "print the JSON Schema of descriptions or of an output"),
        "rule": ("tool", "explain a rule: the cause of the message and the fix"),
    },
    "import and compare": {
        "import": ("import_robot", "convert a URDF, xacro, SDF or MJCF to a description"),
        "extract": ("extract", "compute boxes and height maps from meshes"),
        "diff": ("check", "compare two robots by meaning, in any supported formats"),
    },
    "inspect": {
        "explain": ("frames", "print the pose of a frame and the lines of YAML that define it"),
        "tf": ("frames", "print the transform between two frames, in the format of tf2_echo"),
        "frames": ("frames", "show the tree of frames with their publishers"),
        "graph": ("frames", "show the ROS 2 nodes of the robot and the topics between them"),
        "view": ("view", "show the robot in the browser and update it when files change"),
        "picture": ("view", "draw the robot to a PNG file, without a browser"),
        "simulate": ("simulate", "test the robot in MuJoCo: at rest, in its poses and driving"),
        "pulses": ("frames", "convert servo pulses to joint positions and back"),
        "args": ("frames", "list the arguments of a robot"),
    },
    "build systems": {
        "cmake-dir": ("tool", "print the folder of the CMake package"),
        "bazel-dir": ("tool", "print the folder of the Bazel rule"),
    },
    "deploy and verify": {
        "package": ("package", "write a ROS 2 package with the artifacts of a robot"),
        "deploy": ("package", "copy the artifacts to an existing ROS 2 package"),
        "verify": ("verify", "compare a recording of the robot with its description"),
    },
    "set up": {
        "completion": ("tool", "print the completion script for bash, zsh or fish"),
        "help": ("tool", "show the help of a command"),
    },
    CHECK: {
        "parameters": ("package", "check parameter files of ROS nodes: frames and publishers"),
        "deployed": ("package", "compare with copies in a package, an install space or another folder"),
        "physics": ("simulate", "find links that collide with each other at rest or while joints move, with MuJoCo"),
    },
}
ALIASES = {"compile": "all"}
_HIDDEN = ("pulses", "cmake-dir", "bazel-dir")


class Entry(NamedTuple):
    """A command or check in the list of the help."""

    name: str
    group: str
    help: str
    hidden: bool = False
    module: str = ""


BUILT_IN: dict[str, dict[str, Entry]] = {"commands": {}, "checks": {}}
for group, entries in COMMANDS.items():
    for name, (module, text) in entries.items():
        BUILT_IN["checks" if group == CHECK else "commands"][name] = Entry(name, group, text, name in _HIDDEN, module)


def names(group: str) -> dict[str, str]:
    """Map the names of all "commands" or "checks" to a line of help, without importing plug-ins."""
    plugins = {p.name: f"of {p.distribution} {p.version}" for p in installed_plugins() if p.group == group}
    return plugins | {entry.name: entry.help for entry in BUILT_IN[group].values() if not entry.hidden}


ROBOT_HELP = "name of a robot in descriptions/, or a folder or file"
ROBOTS_HELP = f"{ROBOT_HELP}; default: all robots"
Work = Callable[["Run"], int]
Decorator = Callable[[Any], Any]


class Option(click.Option):
    """An option that can exclude or require other options."""

    def __init__(self, *words: Any, excludes: str = "", needs: str = "", **settings: Any) -> None:
        self.excludes, self.needs = excludes.split(), needs
        super().__init__(*words, **settings)

    def handle_parse_result(
        self, ctx: click.Context, opts: Mapping[str, Any], args: list[str]
    ) -> tuple[Any, list[str]]:
        if self.name in opts and not ctx.resilient_parsing:
            words = {param.name: param.opts[-1] for param in ctx.command.params}
            for name in self.excludes:
                if name in opts:
                    raise click.UsageError(f"argument {self.opts[-1]}: not allowed with argument {words[name]}", ctx)
            if self.needs and self.needs not in opts:
                raise click.UsageError(f"{self.opts[-1]} goes with {words[self.needs]}", ctx)
        return super().handle_parse_result(ctx, opts, args)


class Argument(click.Argument):
    """An argument with a line of help, for which ``click.Argument`` has no parameter."""

    def __init__(self, *words: Any, help: str = "", **settings: Any) -> None:
        super().__init__(*words, **settings)
        self.help = help


class Command(click.Command):
    """A command: ``rosorin-compile NAME``, or ``rosorin-compile check NAME`` if ``within`` is "check".

    The help lists the command under the heading ``group``. ``exits`` describes the exit codes 0 and 1. ``sections``
    returns further lists for the help of the command, by heading.
    """

    def __init__(
        self,
        name: str,
        run: Work,
        params: Sequence[click.Parameter] = (),
        *,
        group: str = "plug-ins",
        help: str = "",
        exits: str = "0 fine, 1 errors",
        epilog: str = "",
        sections: Callable[[], Mapping[str, Sequence[tuple[str, str]]]] = dict,
        within: str = "",
        **settings: Any,
    ) -> None:
        settings |= {"help": f"{help[:1].upper()}{help[1:]}.", "short_help": help}
        epilog = f"{epilog}\n\nExit codes: {exits}, 2 wrong usage.".strip()
        super().__init__(name, params=[*params], epilog=epilog, **settings)
        self.run, self.group, self.sections = run, group, sections
        self.called = f"{within} {name}".strip()
        self.plugin: Plugin | None = None

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        if parent is not None and isinstance(parent.obj, Console):  # so that error messages name this command
            parent.obj.command, parent.obj.plugin = self.called, self.plugin
        return super().make_context(info_name, args, parent, **extra)

    def start(self, ctx: click.Context) -> "Run":
        """Create the ``Run`` of this command from the parsed options. Raises RequestError for invalid options."""
        from .run import Run  # slow to import: it imports the readers of robots

        values = {name: list(value) if isinstance(value, tuple) else value for name, value in ctx.params.items()}
        return Run(self.called, ctx.obj or Console(), **values)

    def invoke(self, ctx: click.Context) -> int:
        """Run this command; return the exit code. Raises RequestError, or PluginFailed for an invalid result."""
        console: Console = ctx.obj
        console.form, console.quiet, console.verbose = (ctx.params[name] for name in ("format", "quiet", "verbose"))
        run = self.start(ctx)
        console.counts_notes = not getattr(run, "notes", True) and not run.verbose
        console.keeps_sections = run.format == "markdown" or getattr(run, "summary", None) is not None
        if getattr(run, "xacro_seconds", None) is not None:  # an environment variable also applies in child processes
            os.environ["ROSORIN_COMPILE_XACRO_SECONDS"] = str(run.xacro_seconds)
        if run.format in ("text", "github", "markdown") and not run.quiet:
            show_progress()
        code = self.run(run)
        if self.plugin is not None and type(code) is not int:
            raise PluginFailed(broken_plugin(self.plugin, f"gives no exit code, but {str(code)[:60]!r}"))
        notes = [Diagnostic("system-lacks", NOTE, message) for message in take_missing()]
        if refused := cache_refused():
            notes.insert(0, Diagnostic("cache-not-private", NOTE, refused[0], help=refused[1]))
        if notes and not console.quiet:
            console.show(notes, listed=True)
        if getattr(run, "fail_on", "") == "never" and code == PROBLEMS:
            return FINE
        fails = getattr(run, "fail_on", "") == "warning" and any(console.severities[one] for one in (ERROR, WARNING))
        return max(code, PROBLEMS) if fails else code

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the sections of the help: arguments, options and additional lists."""
        params = self.get_params(ctx)
        positional = [one for one in params if isinstance(one, Argument)]
        arguments = [(one.metavar or one.human_readable_name, one.help or "") for one in positional]
        options = [row for one in params if isinstance(one, click.Option) and (row := one.get_help_record(ctx))]
        sections: dict[str, Sequence[tuple[str, str]]] = {"Arguments": arguments, "Options": options, **self.sections()}
        for head, rows in sections.items():
            if rows:
                with formatter.section(head):
                    formatter.write_dl(list(rows))

    def format_arguments(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Do nothing, because ``format_options`` writes the arguments."""


def command(name: str, within: str = "", **settings: Any) -> Callable[[Work], Command]:
    """Return a decorator that converts a function to a Command; for names in COMMANDS, ``help`` is optional."""
    if "help" not in settings:
        entry = BUILT_IN["checks" if within == CHECK else "commands"][name]
        settings |= {"group": entry.group, "help": entry.help, "hidden": entry.hidden}

    def decorate(run: Work) -> Command:
        # click stores the parameters of decorators in reverse order
        decorated = [*output_options(lambda: None).__click_params__, *getattr(run, "__click_params__", [])]
        return Command(name, run, decorated[::-1], within=within, **settings)

    return decorate


check = partial(command, within=CHECK)


class FileName(click.Path):  # type: ignore[type-arg,unused-ignore] # generic in some versions of click
    """The name of a file or folder, which must not be empty."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return super().convert(value or self.fail("the name is empty", param, ctx), param, ctx)


PATH = FileName()


def _pairs(_: click.Context, param: click.Parameter, values: Sequence[str]) -> dict[str, str]:
    from .run import pair

    return dict(pair(value, str(param.metavar)) for value in values)


def _modes(_: click.Context, __: click.Parameter, values: Sequence[str]) -> dict[str, bool]:
    """Parse modes, such as "slam", "not slam", "slam=on" or "slam=off", to {mode: is on}."""
    modes: dict[str, bool] = {}
    for value in values:
        match = re.fullmatch(r"\s*(not\s+)?([^\s=]+)\s*(?:=(on|off))?", value)
        if match is None or (match[1] and match[3]):
            name = (value.partition("=")[0].split()[-1:] or ["NAME"])[0]
            raise RequestError(f'"{value}" is not a mode: write {name}, "not {name}", {name}=on or {name}=off')
        is_on = match[3] == "on" if match[3] else not match[1]
        if modes.setdefault(match[2], is_on) != is_on:
            raise RequestError("a mode cannot be on and off")
    return modes


# {kind of names that a shell completes: kinds of symbols in the description}
_OF_ROBOT: dict[str, tuple[str, ...]] = {kind: (kind,) for kind in ("argument", "joint", "pose", "mode", "output")}
_OF_ROBOT |= {"frame": ("link",), "thing": ("link", "joint", "sensor")}


def complete(*kinds: str) -> Callable[[click.Context, click.Parameter, str], list[CompletionItem]]:
    """Return a function that completes names of these kinds; "joint=" stands for joint names followed by "="."""

    def visible_options(ctx: click.Context, _: click.Parameter, incomplete: str) -> list[CompletionItem]:
        found: dict[str, str] = {}
        for kind in reversed(kinds):
            suffix = "=" if kind.endswith("=") else ":=" if kind == "argument" else ""
            with suppress(Exception):
                found |= {name + suffix: help for name, help in _names(kind.rstrip("="), ctx).items()}
        shown = ((name, help) for name, help in found.items() if name.startswith(incomplete) and name.isprintable())
        items = [CompletionItem(name, help=help or None) for name, help in shown]
        return items or ([CompletionItem(incomplete, type="file")] if {"robot", "file"} & set(kinds) else [])

    return visible_options


def _names(kind: str, ctx: click.Context) -> dict[str, str]:
    """Map the names of a kind to the help that a shell shows for each completion."""
    from rosorin_compile.formats import FORMATS, schema_names
    from rosorin_compile.source.project import Description, all_here, nearest_descriptions
    from rosorin_compile.source.rule_registry import find

    if kind in _OF_ROBOT:
        robots: list[Description] = []
        for word in ctx.params.get("words") or ():
            with suppress(Exception):
                robots.append(Description.find([word])[0])
        shown = (robots or nearest_descriptions())[7::-1]
        return {name: robot.name for robot in shown for name in _names_of_robot(kind, robot, ctx)}
    if kind == "robot":
        return {path.parent.name: "robot of this project" for path in all_here()}
    if kind == "format":
        return {format.name: format.about for format in FORMATS.values() if format.write is not None}
    if kind == "rule":
        return dict.fromkeys(sorted(find()), "")
    return schema_names() if kind == "schema" else names(kind) if kind in BUILT_IN else {}


def _names_of_robot(kind: str, description: "Description", ctx: click.Context) -> Iterable[str]:
    from rosorin_compile.language.arguments import declared_arguments
    from rosorin_compile.language.symbols import SymbolTable
    from rosorin_compile.request import Request

    def stop(*_: object) -> NoReturn:
        raise PermissionError

    if kind == "argument":
        return [argument.name for argument in declared_arguments(description.path, {})[0]]
    request = Request(description, ctx.params.get("arg") or {}, warn=stop)  # stop before a xacro file runs code
    tree = request.understand().expanded.tree
    symbols = SymbolTable(tree).definitions(implied=True) if tree is not None else ()
    found = dict.fromkeys(symbol.name for symbol in symbols if symbol.kind in _OF_ROBOT[kind])
    return [f"{name}{state}" for name in found for state in ("", "=off")] if kind == "mode" else found


def option(*names: str, offers: str = "", **settings: Any) -> Decorator:
    """Return a decorator that adds an ``Option``. It can decorate several functions, which click 8.0 does not allow.

    A name may be followed by its metavar, as in ``--name NAME``. FILE and FOLDER are paths, ``a|b`` are choices, and
    NAME=VALUE is a pair. ``offers`` is the kind of names that a shell completes; ``settings`` are passed to click.
    """
    metavar = "".join(name.partition(" ")[2] for name in names)
    if "|" in metavar:
        settings["type"] = click.Choice(metavar.split("|"))
    elif metavar:
        settings["metavar"] = metavar
    if metavar.startswith(("FILE", "FOLDER")):
        settings.setdefault("type", PATH)
    elif "=" in metavar and "type" not in settings:
        settings["callback"] = _pairs
    if settings.get("default") and "default: " not in settings.get("help", ""):
        settings["help"] = f"{settings.get('help', '')}; default: {settings['default']}"
    if offers:
        settings["shell_complete"] = complete(offers)
    return lambda function: click.option(*(name.split(" ")[0] for name in names), cls=Option, **settings)(function)


flag = partial(option, is_flag=True)
repeatable = partial(option, multiple=True)


def argument(*names: str, offers: Sequence[str] = (), **settings: Any) -> Decorator:
    """Return a decorator that adds an ``Argument``; ``offers`` are the kinds of names that a shell completes."""
    if offers:
        settings["shell_complete"] = complete(*offers)
    return lambda function: click.argument(*names, cls=Argument, **settings)(function)


def words_argument(
    metavar: str, help: str = "", required: bool = False, offers: Sequence[str] = ("robot", "argument")
) -> Decorator:
    """Return a decorator that adds the argument ``words``, a list of all words that are not options."""
    return argument("words", nargs=-1, required=required, metavar=metavar, help=help, offers=offers)


def combine(*decorators: Decorator) -> Decorator:
    """Return one decorator that adds the parameters of several decorators in order."""
    return lambda function: reduce(lambda decorated, add: add(decorated), reversed(decorators), function)


output_options = combine(
    option("--format text|json|github|sarif|markdown", default="text", help="format of the output"),
    flag("-q", "--quiet", help="print only errors and the result", excludes="verbose"),
    flag("-v", "--verbose", help="print all notes, and the files that were read"),
)
_PACKAGE = "folder of a ROS package, for $(find NAME) and package://NAME; repeatable"
robot_options = combine(
    repeatable("--package NAME=PATH", "packages", help=_PACKAGE),
    flag("--trust", help="do not warn about code that a xacro file can run"),
    option("--xacro-seconds S", type=click.IntRange(1), help="time limit for a xacro file in seconds; default: 30"),
    repeatable("-a", "--arg NAME=VALUE", help="set an argument; also NAME:=VALUE without -a", offers="argument="),
    repeatable("--args FILE", "args_files", help="read arguments from a YAML file; -a overrides them"),
)
robot_argument = words_argument("[ROBOT]", f"{ROBOT_HELP}; required if there are several")
_FOLDER = "folder of the artifacts, with a subfolder for each of several robots; default: outputs/ROBOT"
output_folder_option = option("-o", "--output FOLDER", help=_FOLDER)
notes_option = flag("--notes", help="list notes and stand-ins instead of counting them")
full_option = flag("--full", help="print differences of texts in full")
force_option = flag("--force", help="replace a file that this command did not write")
strict_option = flag("--strict", help="treat positions beyond a limit as errors")
dry_run_option = flag("-n", "--dry-run", help="write nothing; print what would change")
_FAIL_ON = "exit with 1 for a message of this or a higher severity"
_HOOK = "for pre-commit: take changed files as arguments and use all robots of their projects"
hook_option = flag("--hook", help=_HOOK)
fail_on_option = option("--fail-on error|warning|never", default="error", help=_FAIL_ON)


def robots_argument(metavar: str = "[ROBOT ...]", help: str = ROBOTS_HELP, **settings: Any) -> Decorator:
    """Return a decorator that adds the robots of a command, and the options that apply to each robot."""
    return combine(words_argument(metavar, help, **settings), robot_options)


def check_options(metavar: str = "[ROBOT ...]", help: str = ROBOTS_HELP, **settings: Any) -> Decorator:
    """Return a decorator that adds the parameters of all checks: robots, output folder and report options."""
    summary_option = option("--summary FILE", help="also append the messages to a file, as Markdown")
    return combine(robots_argument(metavar, help, **settings), output_folder_option, summary_option, fail_on_option)


def page_options(what: str) -> Decorator:
    """Return a decorator that adds the options for an HTML page; ``what`` describes the page in the help."""
    limit = "with --html: size limit for all meshes together, in MB; default: 40"
    return combine(
        option("--html FILE", help=what, excludes="every_argument"),
        flag("--no-meshes", help="with --html: leave out the meshes", needs="html"),
        option("--max-megabytes NUMBER", type=float, help=limit, needs="html"),
    )


def depfile_options(target: str) -> Decorator:
    """Return a decorator that adds the options for depfiles; ``target`` describes the default target."""
    help = "write the files that were read as a Make and Ninja depfile"
    return combine(
        option("--depfile FILE", help=help, excludes="hook dry_run every_argument"),
        option("--depfile-target NAME", type=PATH, help=f"target in the depfile; {target}", needs="depfile"),
    )


def mode_option(unnamed: str) -> Decorator:
    """Return a decorator that adds ``--mode``; ``unnamed`` describes the state of all other modes in the help."""
    help = f'switch a mode on or off: slam, "not slam" or slam=off; other modes: {unnamed}'
    return repeatable("--mode MODE", "modes", callback=_modes, help=help, offers="mode")


def position_options(*more: Decorator, overrides: str = "--pose") -> Decorator:
    """Return a decorator that adds options for joint positions (default: zero), and the options ``more``."""
    position = f"position, such as 30deg, 5cm or 1,2,30deg; overrides {overrides}"
    return combine(
        option("--pose POSE", default="", help="named pose of the description", offers="pose"),
        repeatable("--pulse JOINT=PULSE", "pulses", help="pulse for the servo; overrides --pose", offers="joint="),
        repeatable("--joint JOINT=VALUE", "joints", help=position, offers="joint="),
        *more,
    )

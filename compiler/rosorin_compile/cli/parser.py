"""Commands that still describe their options by calls: ``options(parser)`` becomes a list of click parameters."""

from __future__ import annotations

import re
from types import ModuleType
from typing import TYPE_CHECKING, Any

import click

from . import complete
from . import options as shared
from .command import Check, Command, Option, Ways, argument, option, parameters
from .options import FORMAT_NAMES, PAGE_MEGABYTES, PATH

if TYPE_CHECKING:
    from .registry import Entry

__all__ = ["FORMAT_NAMES", "PAGE_MEGABYTES", "Parser", "made"]

_ROBOTS = shared.ROBOTS_HELP
_TEXTS = {
    "init": ("NAME [TEMPLATE]", "0 written, 1 the folder cannot be written"),
    "all": ("[ROBOT ...]", "0 written or unchanged, 1 a robot has errors or, with --dry-run, an artifact would change"),
    "print": ("[ROBOT] OUTPUT [NAME:=VALUE ...]", "0 printed, 1 the robot has errors"),
    "check": ("[CHECK] [ROBOT ...]", "0 no differences, 1 differences or errors"),
    "watch": ("[ROBOT ...]", "0 stopped with Ctrl-C or SIGTERM"),
    "schema": ("[NAME]", "0 printed"),
    "rule": ("[ID ...]", "0 printed, 1 a plug-in is broken"),
    "diff": ("A B", "0 equal, 1 differences or errors"),
    "explain": ("[ROBOT] NAME ...", "0 printed, 1 the description has errors"),
    "tf": ("[ROBOT] SOURCE TARGET", "0 printed, 1 errors, no transform or, with --strict, a position beyond a limit"),
    "pulses": (
        "[ROBOT] [JOINT=VALUE ...]",
        "0 printed, 1 errors, no such pulse or, with --strict, a position beyond a limit",
    ),
    "args": ("[ROBOT ...]", "0 listed, 1 an invalid argument"),
    "cmake-dir": ("", "0 printed"),
    "bazel-dir": ("", "0 printed"),
    "completion": ("SHELL", "0 printed"),
    "import": ("SOURCE", "0 written, 1 the source has errors"),
    "extract": ("", "0 written, 1 errors"),
    "package": ("[ROBOT] -o FOLDER", "0 written or unchanged, 1 errors"),
    "deploy": ("[ROBOT] -o FOLDER", "0 written or unchanged, 1 errors or, with --dry-run, a file would change"),
    "verify": ("[ROBOT] SOURCE", "0 it matches, 1 it does not match or cannot be read"),
    "frames": ("[ROBOT]", "0 shown or written, 1 the robot has errors"),
    "view": ("[ROBOT]", "0 stopped with Ctrl-C or SIGTERM, or page written, 1 errors (with --html)"),
    "picture": ("[ROBOT] -o FILE", "0 drawn, 1 errors or a missing extra"),
    "collisions": ("[ROBOT]", "0 written or unchanged, 1 errors"),
    "simulate": ("[ROBOT]", "0 within the limits, 1 errors or a result beyond a limit"),
    "sweep": (
        "[ROBOT] --over LIST -o FOLDER",
        "0 all variants written or unchanged, 1 a variant has errors or cannot be written",
    ),
    "parameters": ("[ROBOT] FILE ...", "0 no errors, 1 errors"),
    "deployed": ("[ROBOT] FOLDER", "0 no differences, 1 differences or errors"),
    "physics": ("[ROBOT ...]", "0 no errors, 1 errors"),
}


class Parser:
    """Collects the parameters of one command."""

    def __init__(self, name: str = "") -> None:
        self.name = name
        self.params: list[click.Parameter] = []
        self.defaults: dict[str, Any] = {}
        self.description = ""
        self.epilog = ""
        self.listed: Any = None
        self.formatter_class: Any = None
        self.usage = ""
        self.ways: dict[str, Parser] = {}
        self.help = ""
        self.words_of_usage = ""

    def add(self, *decorators: Any) -> None:
        """Add the parameters of decorators."""
        for decorator in decorators:
            self.params += parameters(decorator(lambda: None))

    def add_argument(self, *names: str, section: str = "", excludes: Any = (), **settings: Any) -> None:
        """Add an option or an argument, described as for argparse."""
        offers = _offers(settings.pop("completes", None) or settings.get("metavar"))
        if offers is not None:
            settings["shell_complete"] = offers
        kind, choices = settings.pop("type", None), settings.pop("choices", None)
        kind = PATH if kind == "path" else kind
        if choices is not None:
            kind = click.Choice([*choices])
            settings.setdefault("metavar", None if not names[0].startswith("-") else f"{{{','.join(choices)}}}")
        if kind is not None:
            settings["type"] = kind
        action, dest, count = settings.pop("action", None), settings.pop("dest", None), settings.pop("nargs", None)
        if not names[0].startswith("-"):
            settings.pop("default", None) if count != "?" else None
            if count in ("*", "+"):
                settings["nargs"] = -1
            settings["required"] = count not in ("*", "?")
            self.add(argument(*names, **settings))
            return
        if action == "store_true":
            settings["is_flag"] = True
        elif action == "append":
            settings["multiple"] = True
            settings.pop("default", None)
        elif action == "extend":
            settings.update(multiple=True, many=True)
            settings.pop("default", None)
        elif action is not None:
            settings["default"] = None
            names = tuple(f"{name}/--no-{name[2:]}" for name in names)
        if isinstance(count, int):
            settings["nargs"] = count
            settings["metavar"] = " ".join(settings["metavar"])
        self.add(option(*names, *([dest] if dest else []), section=section, excludes=excludes, **settings))

    def set_defaults(self, **settings: Any) -> None:
        """Add values to the parsed options."""
        self.defaults.update(settings)

    def add_argument_group(self, title: str) -> _Group:
        """Return a section of the help."""
        return _Group(self, title[:1].upper() + title[1:])

    def add_mutually_exclusive_group(self) -> _Group:
        """Return options that exclude each other."""
        return _Group(self, "", exclusive=True)

    def add_subparsers(self, **_: Any) -> Parser:
        """Return this parser, which takes commands within."""
        return self

    def add_parser(self, name: str, help: str = "", **_: Any) -> Parser:
        """Add a command within this one."""
        self.ways[name] = Parser(name)
        self.ways[name].help = help
        return self.ways[name]

    def add_robot(self) -> None:
        """Add the robot of a command that is about one."""
        self.add(shared.robot_argument)

    def add_robots(self, words: str = "[ROBOT ...]", help: str = _ROBOTS) -> None:
        """Add robots, and what every robot takes."""
        self.add(shared.robots_argument(words, help))

    def add_given(self) -> None:
        """Add what every robot takes."""
        self.add(shared.robot_options)

    def add_check_options(self, words: str = "[ROBOT ...]", help: str = _ROBOTS, hook: bool = False) -> None:
        """Add what a check takes."""
        self.add(shared.check_options(words, help))
        if hook:
            self.add_hook()

    def add_output(self) -> None:
        """Add the folder of the artifacts."""
        self.add(shared.output_folder_option)

    def add_messages(self, summary: bool = False) -> None:
        """Every command has these options."""
        if summary:
            self.add(shared.summary_option)

    def add_notes(self) -> None:
        """Add the option that lists notes."""
        self.add(shared.notes_option)

    def add_result(self) -> None:
        """Every command has these options."""

    def add_result_form(self, to: Any = None) -> None:
        """Every command has these options."""

    def add_quiet(self) -> None:
        """Every command has these options."""

    def add_hook(self, more: str = "") -> None:
        """Add the option for pre-commit."""
        self.add(shared.hook_option(more))

    def add_page(self, what: str) -> None:
        """Add the options of a page."""
        self.add(shared.page_options(what))

    def add_depfile(self, target: str) -> None:
        """Add the options for depfiles."""
        self.add(shared.depfile_options(target))

    def add_modes(self, unnamed: str, to: _Group | None = None) -> None:
        """Add the option that switches modes."""
        self.add(shared.mode_option(unnamed, to.section if to else ""))


def _offers(text: Any) -> Any:
    """Return the completion of a metavar."""
    words = [text] if isinstance(text, str) else text or ()
    kinds = [_KINDS[key] for word in words for key in re.findall("[A-Z]+", word) if key in _KINDS]
    return complete.of(*(f"{kind}=" if "=" in str(text) else kind for kind in kinds)) if kinds else None


_KINDS = {"ROBOT": "robot", "FRAME": "frame", "THING": "thing", "POSE": "pose", "JOINT": "joint", "SERVO": "joint"}
_KINDS |= {
    "ARTIFACT": "output",
    "ID": "rule",
    "SCHEMA": "schema",
    "CHECK": "checks",
    "SOURCE": "argument",
    "FILE": "file",
}


class _Group:
    def __init__(self, parser: Parser, section: str, exclusive: bool = False) -> None:
        self.parser, self.section, self.exclusive = parser, section, exclusive
        self.members: list[Option] = []

    def add_argument(self, *names: str, **settings: Any) -> None:
        """Add an option."""
        self.parser.add_argument(*names, section=self.section, **settings)
        (*_, added) = self.parser.params
        if self.exclusive and isinstance(added, Option):
            for member in self.members:
                added.excludes += (member.name or "",)
            self.members.append(added)


def made(entry: Entry, module: ModuleType, is_check: bool = False) -> click.Command:
    """Return the command of a module with ``options`` and ``run``."""
    parser = Parser(entry.name)
    parser.description = ""
    module.options(parser)
    words, exits = _TEXTS[entry.name]
    settings = {"group": entry.group, "exits": exits, "order": entry.order, "also": entry.also, "hidden": entry.hidden}

    def run(options: Any) -> int:
        for name, value in parser.defaults.items():
            setattr(options, name, value)
        code: int = module.run(options)
        return code

    def command(parser: Parser, help: str, kind: type[Command] = Command, **more: Any) -> Command:
        own = [one for one in parser.params if one.name not in ("quiet", "verbose", "format")]
        for one in own:
            if isinstance(one, click.Argument) and one.name == "words" and words:
                one.metavar = words.partition(" -")[0]
                if "[CHECK]" in words:
                    one._custom_shell_complete = complete.of("checks", "robot", "argument")
        own += parameters(shared.output_options(lambda: None))
        return kind(parser.name, run, own, help=help, **settings, **more)

    if parser.ways:
        ways = [command(way, way.help, within=entry.name) for way in parser.ways.values()]
        for way in ways:
            way.params.insert(0, _What(way.name or ""))
        return Ways(entry.name, ways, help=entry.help)
    if entry.name == "all":
        parser.add(shared.fail_on_option)
    extra: dict[str, Any] = {"more": parser.description.strip()} if parser.description else {}
    if entry.name == "check":
        from .registry import checks

        extra["sections"] = lambda: {
            "Checks (see check CHECK --help)": [(one.name, one.help) for one in checks().values()]
        }
    return command(parser, entry.help, Check if is_check else Command, **extra)


class _What(Option):
    def __init__(self, name: str) -> None:
        super().__init__(["--what"], hidden=True, default=name)

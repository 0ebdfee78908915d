"""A parser of options that can be asked which it has, and that takes values such as -12.5mm.

It adds the options that many commands have, each under one name: ``options(parser)`` of a command or check gets one.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

from rosorin_compile.source.console import ENVELOPE, MARKDOWN

from .usage import USAGE

if TYPE_CHECKING:

    class Group(Protocol):
        """What options are added to: a parser, or a group of one."""

        def add_argument(self, *names: str, **settings: Any) -> argparse.Action:
            """Add an option, as argparse does."""


FORMAT_NAMES = ("text", ENVELOPE, "github", "sarif", MARKDOWN)
PAGE_MEGABYTES = 40  # of the meshes of a page
_ROBOT = "name of a robot in descriptions/, or a folder or file"
_ROBOTS = f"{_ROBOT}; default: all robots"

# A number below zero, with a unit or more numbers after it; argparse knows that of plain numbers only.
_NEGATIVE = r"-\.?\d"


class Refused(SystemExit):
    """A command line that cannot be followed, which was said; ``message`` is why."""

    def __init__(self, message: str) -> None:
        super().__init__(USAGE)
        self.message = message


class Parser(argparse.ArgumentParser):
    """A parser that notes its options as they are added, and the commands within it by name.

    ``completes`` of an option says what a shell completes there, in the words of ``commands.completion.candidates``.
    ``listed`` gives what the help lists under the description; it is asked when the help is shown.
    ``type="path"`` of an option takes the name of a file or folder, which is not empty.
    """

    def __init__(self, *words: Any, listed: Callable[[], str] | None = None, **settings: Any) -> None:
        self.options: list[argparse.Action] = []
        self.within: dict[str, Parser] = {}
        self.listed = listed
        super().__init__(*words, **settings)
        self.register("type", "path", _path)

    def format_help(self) -> str:
        """Return the help, with what is listed in it under the description."""
        if self.listed is not None:
            self.description = "\n".join(filter(None, [self.description, self.listed()]))
            self.listed = None
        return super().format_help()

    def add_argument(self, *names: str, **settings: Any) -> argparse.Action:
        """Add an option or a word, and note it."""
        completes = settings.pop("completes", None)
        self.options.append(super().add_argument(*names, **settings))
        return _completed(self.options[-1], completes)

    def add_robot(self) -> None:
        """Add the robot of a command that is about one."""
        self.add_argument("words", nargs="*", metavar="ROBOT", help=f"{_ROBOT}; required if there are several")

    def add_robots(self, words: str = "ROBOT", help: str = _ROBOTS) -> None:
        """Add what a command takes that goes through robots: its words, which name them, and what they are given."""
        self.add_argument("words", nargs="*", metavar=words, help=help)
        self.add_given()

    def add_given(self) -> None:
        """Add what robots are given: folders of ROS packages, trust in a xacro, and arguments, last in the help."""
        self.add_argument(
            "--package",
            action="append",
            default=[],
            metavar="NAME=PATH",
            dest="packages",
            help="folder of a ROS package, for $(find NAME) and package://NAME; repeatable",
        )
        self.add_argument("--trust", action="store_true", help="do not warn about code that a xacro file can run")
        self.add_argument(
            "--xacro-seconds",
            type=_seconds,
            metavar="S",
            help="time limit for a xacro file in seconds; default: 60",
        )
        group = self.add_argument_group("arguments of the description or the xacro file")
        group.add_argument(
            "-a",
            "--arg",
            action="append",
            default=[],
            metavar="NAME=VALUE",
            help="set an argument; NAME:=VALUE without -a is the same",
        )
        group.add_argument(
            "--args",
            action="append",
            default=[],
            metavar="FILE",
            dest="args_files",
            help="read arguments from a YAML file; -a overrides them",
        )

    def add_check_options(self, words: str = "ROBOT", help: str = _ROBOTS, hook: bool = False) -> None:
        """Add what a check takes: its words, the folder of the artifacts, what robots are given, the form of messages.

        With ``hook`` the words may be files that changed, for pre-commit.
        """
        self.add_robots(words, help)
        if hook:
            self.add_hook()
        self.add_output()
        self.add_messages(summary=True)

    def add_output(self) -> None:
        """Add the option that names the folder of the artifacts."""
        self.add_argument(
            "-o",
            "--output",
            type="path",
            metavar="FOLDER",
            help="folder of the artifacts, with a subfolder for each of several robots; default: outputs/ROBOT",
        )

    def add_messages(self, summary: bool = False) -> None:
        """Add how messages are printed, where they are all there is; with ``summary`` also that a file keeps them."""
        if summary:
            self.add_argument(
                "--summary",
                type="path",
                metavar="FILE",
                help="also append the messages to a file, as Markdown",
            )
        self.add_argument(
            "--format", choices=FORMAT_NAMES, default="text", help="format of the messages; default: text"
        )
        how_much = self.add_mutually_exclusive_group()
        how_much.add_argument(
            "-q", "--quiet", action="store_true", help="print only errors and the number of stand-ins"
        )
        how_much.add_argument("-v", "--verbose", action="store_true", help="also list the files that were read")

    def add_notes(self) -> None:
        """Add the option to list the notes that a run counts for people."""
        self.add_argument("--notes", action="store_true", help="list notes and stand-ins instead of counting them")

    def add_result(self) -> None:
        """Add how a result is printed that is more than messages, and that of those only errors are."""
        self.add_result_form()
        self.add_quiet()

    def add_result_form(self, to: Group | None = None) -> None:
        """Add how a result is printed that is more than messages, to a group of options if one is given."""
        (to or self).add_argument(
            "--format", choices=("text", ENVELOPE), default="text", help="format of the result; default: text"
        )

    def add_quiet(self) -> None:
        """Add the option to hear of errors only."""
        self.add_argument("-q", "--quiet", action="store_true", help="do not print warnings and notes")

    def add_hook(self, more: str = "") -> None:
        """Add the option for pre-commit."""
        self.add_argument(
            "--hook",
            action="store_true",
            help=f"for pre-commit: take changed files as arguments and use all robots of their projects{more}",
        )

    def add_page(self, what: str) -> None:
        """Add the options of a page that is written into a file; ``what`` says what it shows."""
        self.add_argument("--html", type="path", metavar="FILE", help=what)
        self.add_argument("--no-meshes", action="store_true", help="with --html: leave out the meshes")
        self.add_argument(
            "--max-megabytes",
            type=float,
            metavar="NUMBER",
            help=f"with --html: size limit for all meshes together, in MB; default: {PAGE_MEGABYTES}",
        )

    def add_depfile(self, target: str) -> None:
        """Add the options for depfiles; ``target`` ends the help: the default target, or that it is required."""
        self.add_argument(
            "--depfile", type="path", metavar="FILE", help="write the files that were read as a Make and Ninja depfile"
        )
        self.add_argument(
            "--depfile-target",
            type="path",
            metavar="NAME",
            help=f"target in the depfile; {target}",
        )

    def add_modes(self, unnamed: str, to: Group | None = None) -> None:
        """Add how modes are, to a group of options if one is given; ``unnamed`` says how those are without a name."""
        (to or self).add_argument(
            "--mode",
            action="append",
            default=[],
            metavar="MODE",
            dest="modes",
            help=f'switch a mode on or off: slam, "not slam" or slam=off; other modes: {unnamed}',
        )

    def add_argument_group(self, *words: Any, **settings: Any) -> Any:
        """Return a new group; what is added to it is noted here."""
        return self._noted(super().add_argument_group(*words, **settings))

    def add_mutually_exclusive_group(self, **settings: Any) -> Any:
        """Return a new group of options that exclude each other; what is added to it is noted here."""
        return self._noted(super().add_mutually_exclusive_group(**settings))

    def add_subparsers(self, **settings: Any) -> Any:
        """Return what takes the commands within this one."""
        commands = super().add_subparsers(**settings)
        self.within = commands.choices
        return commands

    def error(self, message: str) -> NoReturn:
        """Say why a command line cannot be followed, and end."""
        self.print_usage(sys.stderr)
        sys.stderr.write(f"{self.prog}: error: {message}\n")
        raise Refused(message)

    def shown(self) -> list[argparse.Action]:
        """Return the options and words that the help shows."""
        return [option for option in self.options if option.help != argparse.SUPPRESS]

    def long_options(self) -> list[str]:
        """Return the names of all options that begin with --, those of the commands within as well, each once."""
        names = [name for option in self.options for name in option.option_strings if name.startswith("--")]
        names += [name for inner in self.within.values() for name in inner.long_options()]
        return list(dict.fromkeys(names))

    def parse_known_args(self, args: Iterable[str] | None = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse words as argparse does; a number below zero after an option is its value, whatever follows the digits.

        Those of a command within are its own to parse.
        """
        words = args if args is None or self.within else self._with_values(args)
        return super().parse_known_args(words, namespace)

    def _with_values(self, words: Iterable[str]) -> list[str]:
        """Return words with --option -1cm as one: --option=-1cm."""
        takes = [name for option in self.options if option.nargs is None for name in option.option_strings]
        made: list[str] = []
        for word in words:
            before = made[-1] if made else ""
            named = len(before) > 2 and any(name.startswith(before) for name in takes)
            if named and re.match(_NEGATIVE, word):
                made[-1] = f"{before}={word}"
            else:
                made.append(word)
        return made

    def _noted(self, group: Any) -> Any:
        add = group.add_argument

        def add_argument(*names: str, **settings: Any) -> Any:
            completes = settings.pop("completes", None)
            self.options.append(add(*names, **settings))
            return _completed(self.options[-1], completes)

        group.add_argument = add_argument
        return group


def _path(text: str) -> str:
    """Return the name of a file or folder; an empty one is a variable of a shell that is not set."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty")
    return text


def _seconds(text: str) -> int:
    """Return a time in whole seconds."""
    if not (text.isascii() and text.isdigit() and len(text) < 9 and int(text) > 0):
        raise argparse.ArgumentTypeError(f'"{text[:20]}" is no number of whole seconds')
    return int(text)


def _completed(action: argparse.Action, completes: object) -> argparse.Action:
    """Return an option that notes what its value is to a shell, where its name in the help does not say it."""
    if completes is not None:
        action.completes = completes  # type: ignore[attr-defined]
    return action


class Version(argparse.Action):
    """Prints the version, and the plug-ins with theirs."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print them and leave."""
        from rosorin_compile.source.plugins import installed
        from rosorin_compile.source.version import __version__

        print(f"rosorin-compile {__version__}")
        groups: dict[tuple[str, str], dict[str, None]] = {}
        for plugin in installed():
            groups.setdefault((plugin.distribution, plugin.version), {})[plugin.group] = None
        for (name, version), brings in groups.items():
            print(f"plug-in {name} {version} ({', '.join(brings)})")
        parser.exit()

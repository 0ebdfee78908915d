"""A parser of options that can be asked which it has, and that takes values such as -12.5mm."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

from .usage import USAGE

if TYPE_CHECKING:

    class Options(Protocol):
        """What options are added to: a parser, or a group of one."""

        def add_argument(self, *names: str, **settings: Any) -> argparse.Action:
            """Add an option, as argparse does."""


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
    """

    def __init__(self, *words: Any, listed: Callable[[], str] | None = None, **settings: Any) -> None:
        self.options: list[argparse.Action] = []
        self.within: dict[str, Parser] = {}
        self.listed = listed
        super().__init__(*words, **settings)

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
        """Return the options and words that the help shows: no older spellings."""
        return [option for option in self.options if option.help != argparse.SUPPRESS]

    def long_options(self) -> list[str]:
        """Return the names of all options that begin with --, those of the commands within as well, each once."""
        names = [
            name
            for option in self.options
            for name in option.option_strings
            if name.startswith("--") and not hasattr(option, "new")
        ]
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


def _completed(action: argparse.Action, completes: object) -> argparse.Action:
    """Return an option that notes what its value is to a shell, where its name in the help does not say it."""
    if completes is not None:
        action.completes = completes  # type: ignore[attr-defined]
    return action


class Version(argparse.Action):
    """Prints the version, and the plug-ins with theirs."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print them and leave."""
        from .. import __version__
        from ..plugins import installed

        print(f"rosorin-compile {__version__}")
        groups: dict[tuple[str, str], dict[str, None]] = {}
        for plugin in installed():
            groups.setdefault((plugin.distribution, plugin.version), {})[plugin.group] = None
        for (name, version), brings in groups.items():
            print(f"plug-in {name} {version} ({', '.join(brings)})")
        parser.exit()

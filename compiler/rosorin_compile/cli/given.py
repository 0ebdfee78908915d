"""Arguments of descriptions on the command line, files of arguments, and folders of ROS packages."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.request import Request
from rosorin_compile.source.files import is_file, is_folder
from rosorin_compile.source.project import no_file

from .usage import WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.source.console import Console
    from rosorin_compile.source.project import Description

    from .command import Options

MARK = ":="  # between name and value of an argument, as xacro has it


class Given(NamedTuple):
    """The arguments that a command passes to each of its robots: texts by name, and files with more arguments.

    ``packages`` maps names of ROS packages to folders. ``trust`` permits a xacro to run Python code without a warning.
    """

    texts: dict[str, str]
    files: tuple[Path, ...]
    packages: Mapping[str, Path] = MappingProxyType({})
    trust: bool = False

    def values(self) -> dict[str, Any]:
        """Return all arguments by name; the command line wins over files. Raises LoadError."""
        if not self.files:
            return dict(self.texts)
        from rosorin_compile.language.arguments import read

        return read(self.files, self.texts)

    def request(self, description: Description, console: Console | None = None) -> Request:
        """Return the request for a robot; warnings before code is executed are printed on the console."""
        warn = None if console is None else console.ahead
        return Request(description, self.texts, self.files, self.packages, self.trust, warn)

    def as_written(self) -> dict[str, str]:
        """Return all arguments by name, as a xacro takes them: as texts. Raises WrongUsage."""
        from rosorin_compile.language.expression.functions import FUNCTIONS
        from rosorin_compile.source.load import LoadError

        try:
            return {name: str(FUNCTIONS["str"](value)) for name, value in self.values().items()}
        except LoadError as problem:
            raise WrongUsage(problem.diagnostic.message) from None


def given_arguments(options: Options, words: list[str]) -> tuple[Given, list[str]]:
    """Return the arguments on the command line, and the words that are not arguments. Raises WrongUsage.

    A command without ``-a`` takes no arguments: all its words are others.
    """
    if not hasattr(options, "arg"):
        return Given({}, ()), words
    texts = named([*(word for word in words if MARK in word), *options.arg])
    files = tuple(map(Path, options.args_files))
    for file in files:
        if not is_file(file):
            raise WrongUsage(no_file(file, "arguments"))
    given = Given(texts, files, packages_of(options), getattr(options, "trust", False))
    return given, [word for word in words if MARK not in word]


def no_half_mark(words: Iterable[str]) -> None:
    """Refuse prefix=left_ and prefix:left_ where names are wanted, and they are none. Raises WrongUsage."""
    for word in words:
        name, mark, value = word.partition("=")
        if not mark:
            name, mark, value = word.partition(":")
        if mark and name.isidentifier() and not os.path.lexists(word):
            raise WrongUsage(f'"{word}" sets no argument: write {name}{MARK}{value}')


def named(texts: Iterable[str]) -> dict[str, str]:
    """Return values by name, of texts that are NAME=VALUE or NAME:=VALUE. Raises WrongUsage."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.removesuffix(":")
        if not equals or not name:
            raise WrongUsage(f'"{text}" is not NAME=VALUE')
        found[name] = value
    return found


def packages_of(options: Options) -> dict[str, Path]:
    """Return the folders of packages that the command line names. Raises WrongUsage."""
    found: dict[str, Path] = {}
    for word in getattr(options, "packages", ()):
        name, equals, path = word.partition("=")
        if not equals or not name or not path:
            raise WrongUsage(f'"{word}" is not NAME=PATH')
        if not is_folder(path):
            raise WrongUsage(f'there is no folder "{path}" for the package {name}')
        found[name] = Path(path)
    return found

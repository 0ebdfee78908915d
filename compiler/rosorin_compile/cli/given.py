"""What the command line gives a description: arguments, files of them, and folders of ROS packages."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.files import is_file, is_folder

from .usage import WrongUsage

if TYPE_CHECKING:
    import argparse

    from rosorin_compile.formats.mesh_files import Searched
    from rosorin_compile.model import Output
    from rosorin_compile.output.pipeline import Compiled, Understood
    from rosorin_compile.source.console import Console
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.project import Description
    from rosorin_compile.source.tree import Map

MARK = ":="  # between name and value of an argument, as xacro has it


class Given(NamedTuple):
    """The arguments of a run: texts by name from the command line, and the files that hold more of them.

    ``packages`` are folders of ROS packages by name, for robots in other formats; ``trust`` is that in what those run.
    """

    texts: dict[str, str]
    files: tuple[Path, ...]
    packages: Mapping[str, Path] = MappingProxyType({})
    trust: bool = False

    @classmethod
    def of(cls, arguments: object, packages: object = None) -> tuple[Given, list[Diagnostic]]:
        """Return what a program gives, values of Python by name and folders of packages, and what is wrong with it."""
        from rosorin_compile.language.asked import ask

        asked = ask("", arguments, packages)
        return cls(asked.arguments, (), asked.packages), asked.diagnostics

    @classmethod
    def asked(
        cls, path: object, arguments: object, packages: object, outputs: str | os.PathLike[str] | None = None
    ) -> tuple[Description | None, Given, list[Diagnostic]]:
        """Return the description that a program asks for, and what goes with it; None, and why, if there is none.

        ``outputs`` is the folder that has a folder a robot, as in ``Description.find``.
        """
        from rosorin_compile.language.asked import ask
        from rosorin_compile.source.diagnostics import error
        from rosorin_compile.source.project import Description, NoDescription

        asked = ask(path, arguments, packages)
        given = cls(asked.arguments, (), asked.packages)
        if asked.diagnostics:
            return None, given, asked.diagnostics
        try:
            return Description.find([asked.name], None if outputs is None else os.fsdecode(outputs))[0], given, []
        except NoDescription as problem:
            return None, given, [error("file-unreadable", str(problem), None)]

    def values(self) -> dict[str, Any]:
        """Return all arguments by name; the command line wins over files. Raises LoadError."""
        if not self.files:
            return dict(self.texts)
        from rosorin_compile.language.arguments import read

        return read(self.files, self.texts)

    def compile(
        self, description: Description, console: Console, meshes: bool = False, wanted: Sequence[str] = ()
    ) -> Compiled:
        """Return what becomes of a description with them; a file of arguments that is no good is a problem like others.

        What has to be said before anything is run is printed on the console. ``meshes`` says that mesh files are looked
        for; ``wanted`` are the only outputs that are made.
        """
        from .compiling import compile_one

        return compile_one(self, description, console, meshes, wanted)

    def compile_foreign(self, description: Description, console: Console) -> Compiled:
        """Return a robot in another format, and what publishers read of it, as ``compile`` does of a description."""
        from rosorin_compile.output.pipeline import Compiled
        from rosorin_compile.source.load import LoadError

        from .foreign import compile_foreign

        try:
            return compile_foreign(description.path, texts(self.values()), self.packages, console.ahead, self.trust)
        except LoadError as problem:
            return Compiled(None, (), [problem.diagnostic], ())

    def search_meshes(self, description: Description, tree: Map, outputs: Sequence[Output]) -> Searched:
        """Look for the meshes of a robot, and read those that belong to its artifacts."""
        from .compiling import search_meshes

        return search_meshes(self, description, tree, outputs)

    def understand(self, description: Description, console: Console) -> Understood:
        """Return what a description, or a robot in another format in its place, says with them. Raises LoadError.

        What has to be said before anything is run is printed on the console.
        """
        from .understanding import read

        return read(self, description, console)

    def as_written(self) -> dict[str, str]:
        """Return all arguments by name, as a xacro takes them: as texts. Raises WrongUsage."""
        from rosorin_compile.language.expression.functions import FUNCTIONS
        from rosorin_compile.source.load import LoadError

        try:
            return {name: str(FUNCTIONS["str"](value)) for name, value in self.values().items()}
        except LoadError as problem:
            raise WrongUsage(problem.diagnostic.message) from None


def given_arguments(options: argparse.Namespace, words: list[str]) -> tuple[Given, list[str]]:
    """Return what the command line gives, and the words that set no argument. Raises WrongUsage.

    A command without ``-a`` takes no arguments: all its words are others.
    """
    if not hasattr(options, "arg"):
        return Given({}, ()), words
    texts = named([*(word for word in words if MARK in word), *options.arg])
    files = tuple(map(Path, options.args_files))
    for file in files:
        if not is_file(file):
            raise WrongUsage.no_file(file, "arguments")
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


def packages_of(options: argparse.Namespace) -> dict[str, Path]:
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


def texts(arguments: Mapping[str, Any]) -> dict[str, str]:
    """Return arguments as xacro takes them."""
    return {name: str(value) for name, value in arguments.items()}

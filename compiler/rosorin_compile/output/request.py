"""A request: one robot with the arguments, packages and trust to compile it with.

Every feature that needs a robot takes a ``Request``. The command line and the Python API both build one.
"""

from __future__ import annotations

import codecs
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.files import shown
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.project import ENDINGS, Description, NoDescription, stdin_of

if TYPE_CHECKING:
    from rosorin_compile.formats.mesh_files import Searched
    from rosorin_compile.model import Output
    from rosorin_compile.output.pipeline import Compiled, Understood
    from rosorin_compile.source.tree import Map


@dataclass(frozen=True)
class Request:
    """One robot, with the arguments to compile it with.

    ``arguments`` are texts, as in ``-a NAME=TEXT``, or values of Python; they override those in ``argument_files``.
    ``packages`` maps names of ROS packages to folders. ``trust`` permits a xacro to run Python code without a warning.
    ``warn`` receives the warnings that have to be printed before code is executed; without it they are among the
    diagnostics.
    """

    description: Description
    arguments: Mapping[str, Any] = field(default_factory=dict)
    argument_files: tuple[Path, ...] = ()
    packages: Mapping[str, Path] = field(default_factory=dict)
    trust: bool = False
    warn: Callable[[Diagnostic], None] | None = field(default=None, compare=False, repr=False)

    @classmethod
    def of(
        cls,
        robot: str | os.PathLike[str] | Request,
        arguments: Mapping[str, Any] | None = None,
        packages: Mapping[str, str | os.PathLike[str]] | None = None,
        outputs: str | os.PathLike[str] | None = None,
        trust: bool = False,
    ) -> tuple[Request | None, list[Diagnostic]]:
        """Return the request for a robot that an argument of the API names, or None and the reasons.

        ``outputs`` is the folder that contains a folder of artifacts for each robot.
        """
        from rosorin_compile.language.asked import ask, unreadable

        if isinstance(robot, Request):
            return robot, []
        asked = ask(robot, arguments, packages)
        if asked.diagnostics:
            return None, asked.diagnostics
        try:
            description = Description.find([asked.name], None if outputs is None else os.fsdecode(outputs))[0]
        except (NoDescription, OSError) as problem:
            return None, [unreadable(problem)]
        return cls(description, asked.arguments, (), asked.packages, trust), []

    @property
    def is_foreign(self) -> bool:
        """Whether the robot is in another format than ours: URDF, xacro, SDF, MJCF or a driver's JSON."""
        return is_foreign(self.description.path)

    def values(self) -> dict[str, Any]:
        """Return all arguments by name. Raises LoadError for a file of arguments that is invalid."""
        if not self.argument_files:
            return dict(self.arguments)
        from rosorin_compile.language.arguments import read

        return read(self.argument_files, self.arguments)

    def texts(self) -> dict[str, str]:
        """Return all arguments as text, as xacro takes them. Raises LoadError."""
        from rosorin_compile.language.expression.functions import FUNCTIONS

        return {name: str(FUNCTIONS["str"](value)) for name, value in self.values().items()}

    def compile(
        self, outputs: Sequence[str] = (), *, meshes: bool = True, foreign: bool = False, lenient: bool = False
    ) -> Compiled:
        """Compile the robot and read its artifacts back; nothing is written.

        ``outputs`` are the names of the only outputs to generate. Without ``meshes``, mesh files are not searched and
        nothing is read back. With ``foreign``, a robot in another format is accepted: its outputs are those of the
        description that ``import`` would write, and ``lenient`` accepts one that violates its specification.
        """
        from rosorin_compile.output.pipeline import Compiled, compile_robot

        search = self.search_meshes if meshes else None
        try:
            if foreign and self.is_foreign:
                from .foreign import emit_foreign

                compiled = emit_foreign(self, search, outputs, lenient)
            else:
                path = self.description.path
                compiled = compile_robot(path, self.values(), self.tell, self.packages, search, outputs)
        except LoadError as problem:
            return Compiled(None, (), [problem.diagnostic], ())
        return compiled.proven() if meshes else compiled

    def compile_published(self) -> Compiled:
        """Compile the robot without searching mesh files; of one in another format, only what publishers read."""
        if not self.is_foreign:
            return self.compile(meshes=False)
        from rosorin_compile.output.pipeline import Compiled

        from .foreign import compile_foreign

        try:
            return compile_foreign(self)
        except LoadError as problem:
            return Compiled(None, (), [problem.diagnostic], ())

    def understand(self, foreign: bool = True) -> Understood:
        """Return the robot without artifacts, with the positions of all values in its files.

        With ``foreign``, a robot in another format is accepted.
        """
        from rosorin_compile.language.expand import Expanded
        from rosorin_compile.output.pipeline import Understood, understand

        try:
            if foreign and self.is_foreign:
                from .foreign import understand_foreign

                return understand_foreign(self)
            return understand(self.description.path, self.values(), self.tell, self.packages)
        except LoadError as problem:
            return Understood(Expanded(None, [], (self.description.path,)), None, [problem.diagnostic])

    def understand_outputs(self) -> Understood:
        """Return the robot with the outputs that ``print --list`` lists."""
        if not self.is_foreign:
            return self.understand()
        from rosorin_compile.language.expand import Expanded
        from rosorin_compile.output.pipeline import Understood

        from .foreign import listed_foreign

        try:
            return listed_foreign(self)
        except LoadError as problem:
            return Understood(Expanded(None, [], ()), None, [problem.diagnostic])

    def search_meshes(self, tree: Map, outputs: Sequence[Output]) -> Searched:
        """Search the meshes of a robot, and read those that belong to its artifacts."""
        from rosorin_compile.formats.mesh_files import Places, search
        from rosorin_compile.output.mesh_copies import brought

        folder = self.description.outputs
        places = Places(self.description.path, folder, self.packages, os.environ)
        return brought(search(tree, outputs, places), folder)

    def inputs(self, compiled: Compiled) -> list[Path]:
        """Return the files that a compilation has read, files of arguments included."""
        return [path for path in dict.fromkeys([*compiled.files_read, *self.argument_files]) if stdin_of(path) is None]

    def watched(self, compiled: Compiled, made: Sequence[Path]) -> list[Path]:
        """Return what a build tool has to watch: the inputs, and the folders in which files were not found.

        The folders are listed instead of the missing files, because a build tool would try to make those. Folders
        outside of the project, and folders of the files that this run has ``made``, change for other reasons.
        """
        projects = Description.at(compiled.inputs[0]).projects if compiled.missing else ()
        written = {path.absolute().parent for path in made}
        folders: dict[Path, None] = {}
        for path in compiled.missing:
            folder = next(parent for parent in path.absolute().parents if parent.is_dir())
            if folder not in written and any(map(folder.resolve().is_relative_to, projects)):
                folders[Path(shown(folder))] = None
        return [*self.inputs(compiled), *folders]

    @property
    def tell(self) -> Callable[[Diagnostic], None] | None:
        """The receiver of warnings before code is executed; it ignores them if the code is trusted."""
        return _ignore if self.trust else self.warn


def _ignore(_warning: Diagnostic) -> None:
    """Do nothing."""


def is_foreign(path: Path) -> bool:
    """Return True if a file is a robot in another format than ours, by its name; on standard input by its text."""
    given = stdin_of(path)
    if given is not None:
        return given[:1_000].removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"<")
    if path.suffix.lower() in ("", *ENDINGS):
        return False
    from rosorin_compile.formats import FORMATS

    return path.suffix.lower() in FORMATS.endings()

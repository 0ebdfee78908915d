"""A request to load or compile a robot: the robot, its arguments, and ROS packages."""

from __future__ import annotations

import codecs
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats import FORMATS, compilation
from rosorin_compile.formats.compilation import CompileResult, LoadedRobot, ReadResult, judge_foreign
from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.language.arguments import as_texts, of_api, takes_no_arguments
from rosorin_compile.language.arguments import read as read_argument_files
from rosorin_compile.language.expand.description import ExpandedDescription
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, error, has_errors
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.project import ENDINGS, Description, NoDescription, stdin_of

if TYPE_CHECKING:
    from rosorin_compile.formats.mesh_files import SearchResult
    from rosorin_compile.model import Output
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.tree import Map

FilePath = str | os.PathLike[str]
Values = Mapping[str, Any] | None  # values of arguments by name
Packages = Mapping[str, FilePath] | None  # folders of ROS packages by package name
Warn = Callable[[Diagnostic], None] | None  # called with a warning before Python code in a xacro is run
EXECUTED = "xacro-runs-code"  # rule id of the warning before a xacro file runs Python code


@dataclass(frozen=True)
class Request:
    """A robot, and the arguments with which it is compiled.

    ``arguments`` are strings, as in ``-a NAME=TEXT``, or Python values; they override those in ``argument_files``.
    ``packages`` maps names of ROS packages to folders. ``trust`` permits a xacro to run Python code without a warning.
    Otherwise, ``warn`` is called with a warning before code is run; if ``warn`` is None, the warning is among the
    diagnostics. If there are ``problems`` in the request, methods return these diagnostics and no robot.
    """

    description: Description
    arguments: Mapping[str, Any] = field(default_factory=dict)
    argument_files: tuple[Path, ...] = ()
    packages: Mapping[str, Path] = field(default_factory=dict)
    trust: bool = False
    warn: Warn = field(default=None, compare=False, repr=False)
    problems: tuple[Diagnostic, ...] = ()

    @classmethod
    def from_arguments(
        cls,
        robot: FilePath | Request,
        arguments: Values = None,
        packages: Packages = None,
        outputs: FilePath | None = None,
        trust: bool = False,
    ) -> Request:
        """Create a request from API arguments; ``outputs`` is the folder that contains one subfolder per robot."""
        if isinstance(robot, Request):
            return robot
        name, values, folders, problems = of_api(robot, arguments, packages)
        description = Description(Path(name).stem or str(robot), Path(name), Path())
        if not problems:
            try:
                description = Description.find([name], None if outputs is None else os.fsdecode(outputs))[0]
            except (NoDescription, OSError) as problem:
                if description.path.suffix.lower() in ("", *ENDINGS):  # otherwise, the reader reports the error
                    problems = [error("file-unreadable", str(problem), None)]
        return cls(description, values, (), folders, trust, problems=tuple(problems))

    @property
    def is_foreign(self) -> bool:
        return is_foreign(self.description.path)

    @property
    def tell(self) -> Warn:
        """The function to call with a warning before code is run: ``warn``, or a no-op if ``trust`` is True."""
        return (lambda _warning: None) if self.trust else self.warn

    def values(self) -> dict[str, Any]:
        """Return all arguments by name, including those in argument files. Raises LoadError for an invalid file."""
        return read_argument_files(self.argument_files, self.arguments) if self.argument_files else {**self.arguments}

    def read_options(self, lenient: bool = True) -> ReadOptions:
        """Return options for importing the robot. Raises LoadError for arguments that are not strings or numbers."""
        texts, wrong = as_texts(self.values())
        if wrong:
            raise LoadError(wrong[0])
        return ReadOptions(texts, self.packages, lenient, tell=self.tell, trust=self.trust)

    def compile(
        self, outputs: Sequence[str] = (), *, meshes: bool = True, foreign: bool = False, lenient: bool = False
    ) -> CompileResult:
        """Compile the robot, and verify the artifacts by reading them back. Nothing is written.

        ``outputs`` are the names of the outputs to generate, by default all. If ``meshes`` is False, mesh files are not
        searched, and nothing is verified. ``foreign`` accepts a robot in another format, and generates the outputs that
        ``import`` would write into its description. ``lenient`` accepts violations of the specification of that format.
        """
        if self.problems:
            return CompileResult(None, (), [*self.problems], ())
        path, search = self.description.path, self.search_meshes if meshes else None
        try:
            if foreign and self.is_foreign:
                robot = judge_foreign(path, self.read_options(lenient), outputs)
                compiled = compilation.emit(robot, path, search, outputs)
            else:
                compiled = compilation.compile_robot(path, self.values(), self.tell, self.packages, search, outputs)
        except LoadError as problem:
            return CompileResult(None, (), [problem.diagnostic], ())
        return prove(compiled) if meshes else compiled

    def understand(self, foreign: bool = True, outputs: bool = False, lenient: bool = True) -> LoadedRobot:
        """Load the robot without generating artifacts.

        ``foreign`` accepts a robot in another format; ``outputs`` gives it the outputs that ``import`` would write into
        its description. ``lenient`` accepts violations of the specification of that format.
        """
        path, problems = self.description.path, [*self.problems]
        try:
            if not problems and foreign and self.is_foreign:
                read = partial(judge_foreign, optional=True) if outputs else compilation.understand_foreign
                return read(path, self.read_options(lenient))
            if not problems:
                return compilation.understand(path, self.values(), self.tell, self.packages)
        except LoadError as problem:
            problems = [problem.diagnostic]
        return LoadedRobot(ExpandedDescription(None, [], (path,)), None, problems)

    def load_case(self) -> tuple[Case | None, tuple[Diagnostic, ...]]:
        """Load the robot: return (robot with source positions, warnings about executed code), or (None, errors)."""
        found = self.understand()
        if found.case is None:
            return None, tuple(one for one in found.diagnostics if one.severity == ERROR)
        return found.case, tuple(one for one in found.diagnostics if one.rule == EXECUTED and not self.trust)

    def read(self, lenient: bool = False) -> ReadResult:
        """Read the robot in any format; ``lenient`` accepts violations of the specification of the format."""
        found = self.understand(lenient=lenient)
        imported, diagnostics = found.imported, found.diagnostics
        if imported is None or imported.tree is None:
            return ReadResult(found.robot, diagnostics, found.expanded.files, found.expanded.tree)
        if self.arguments and not imported.takes_arguments:
            diagnostics = arrange([*diagnostics, takes_no_arguments(self.description.path)])
        robot = None if found.robot is None or has_errors(diagnostics) else replace(found.robot, outputs=())
        return ReadResult(robot, diagnostics, found.expanded.files, imported.tree)

    def search_meshes(self, tree: Map, outputs: Sequence[Output]) -> SearchResult:
        """Find the mesh files of the robot, and read the files that its artifacts refer to."""
        from rosorin_compile.formats.mesh_files import Places, read_files, search

        folder = self.description.outputs
        places = Places(self.description.path, folder, self.packages, os.environ)
        return read_files(search(tree, outputs, places), outputs, folder)

    def inputs(self, compiled: CompileResult) -> list[Path]:
        """Return all files that were read to compile the robot, including argument files."""
        return [path for path in dict.fromkeys([*compiled.files_read, *self.argument_files]) if stdin_of(path) is None]


def read_options(
    arguments: Values, packages: Packages, trust: bool, warn: Warn, lenient: bool = False
) -> tuple[ReadOptions, list[Diagnostic]]:
    """Return (options for reading a robot in another format, errors in the arguments and packages)."""
    _, values, folders, problems = of_api("", arguments, packages)
    texts, wrong = as_texts(values)
    return ReadOptions(texts, folders, lenient, tell=warn, trust=trust), [*problems, *wrong]


def prove(compiled: CompileResult) -> CompileResult:
    """Verify artifacts by reading them back. If an artifact contradicts the robot, return errors and no artifacts."""
    from rosorin_compile.compare.artifacts import agreement

    wrong = agreement(compiled.robot, compiled.artifacts) if compiled.robot is not None else []
    return replace(compiled, artifacts=(), diagnostics=[*compiled.diagnostics, *wrong]) if wrong else compiled


def is_foreign(path: Path) -> bool:
    """Return True if a file is not a description, judged by its extension or, for stdin, by its contents."""
    text = stdin_of(path)
    if text is not None:
        return text[:1_000].removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"<")
    suffix = path.suffix.lower()
    return suffix not in ("", *ENDINGS) and suffix in FORMATS.endings()

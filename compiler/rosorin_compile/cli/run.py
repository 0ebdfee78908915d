"""The input of a command: the arguments and packages of the command line, and the robots that it names."""

from __future__ import annotations

import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence, Sized
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from rosorin_compile.output.atomic_files import OutputError, write_file
from rosorin_compile.request import Request
from rosorin_compile.source import files, project
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, RequestError, has_errors
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.plugins import divert_stdout
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.wording import count_of, phrase

from .console import FINE, PROBLEMS, Console

if TYPE_CHECKING:
    from rosorin_compile.formats.compilation import CompileResult
    from rosorin_compile.rules.case import Case
    from rosorin_compile.viewer.changes_page import Pictures


_MARK = ":="  # separates name and value of an argument, as in xacro
_MAX_STDIN = 100_000_001  # bytes; more than the limit of every reader, so that readers report input that is too large
_DEPFILE = rb"\S[^\n]*:(?: \\\n  \S[^\n]*)*\n"
_stdin_read: list[Any] = []  # [sys.stdin] after a robot was read from it


class Run(SimpleNamespace):
    """One run of a command: its options by name, and methods that find and load the requested robots.

    Repeatable options are lists; repeatable options NAME=VALUE are dicts. ``words`` are the words of the command line
    except NAME:=VALUE, ``changed`` the files that follow --hook. ``request`` creates the request for a robot with the
    arguments and packages of the command line.
    """

    console: Console
    words: list[str]
    packages: Mapping[str, Path]

    def __init__(self, called: str, console: Console, **options: Any) -> None:
        super().__init__(**options)
        self.called, self.console = called, console
        words = options.get("words", [])
        self.changed = [word for word in words if options.get("hook") and os.path.lexists(word)]
        words = [word for word in words if word not in self.changed]
        self.words = [word for word in words if _MARK not in word]
        self.arguments = {**dict(pair(word, "NAME=VALUE") for word in words if _MARK in word), **options.get("arg", {})}
        self.argument_files = tuple(map(Path, options.get("args_files", ())))
        for file in self.argument_files:
            if not files.is_file(file):
                raise RequestError(project.no_file(file, "arguments"))
        self.packages = {name: Path(path) for name, path in options.get("packages", {}).items()}
        for name, path in self.packages.items():
            if not files.is_folder(path):
                raise RequestError(f'there is no folder "{path}" for the package {name}')

    def pick(self, names: str) -> dict[str, Any]:
        """Return options as keyword arguments for the API; ``names`` are separated by spaces."""
        return {name: getattr(self, name) for name in names.split()}

    def only_robot(self, stdin: bool = True) -> Description:
        """Return the robot of a command that takes only one; ``stdin`` allows standard input. Raises RequestError."""
        if not stdin:
            refuse_stdin(self.words)
        if len(self.words) > 1:
            raise RequestError(f"{self.called} takes one robot, not {len(self.words)}")
        found = self.find_robot(*self.words)
        self.console.begin(found.name)
        return found

    def find_robot(self, name: str = "", usage: str = "ROBOT") -> Description:
        """Find a robot by name, by default the only robot nearby. Raises RequestError, NoDescription."""
        take_stdin([name])
        found = Description.find([name]) if name else project.nearest_descriptions()
        if len(found) > 1:
            robots = ", ".join(description.name for description in found)
            how = f"rosorin-compile {self.called} {usage}"
            raise RequestError(f"there are several robots here: {robots}; name one: {how}")
        return found[0]

    def robot_before(self, count: int, usage: str) -> tuple[Description, list[str]]:
        """Return (robot, last ``count`` words of the command line); the robot is named before these words.

        The default is the only robot. Raises RequestError.
        """
        if not count <= len(self.words) <= count + 1:
            raise RequestError(f"write rosorin-compile {self.called} {usage}")
        return self.find_robot("".join(self.words[:-count]), usage), self.words[-count:]

    def request(self, description: Description) -> Request:
        """Create the request to compile a robot. Warnings are printed before code of the robot is executed."""
        warn = self.console.warn_ahead
        return Request(description, self.arguments, self.argument_files, self.packages, self.trust, warn)

    def read_options(self) -> dict[str, Any]:
        """Return keyword arguments for API functions that read other formats. Raises RequestError."""
        try:
            texts = self.request(Description("", Path(), Path())).read_options().arguments
        except LoadError as problem:
            raise RequestError(problem.diagnostic.message) from None
        return {"arguments": texts, "packages": self.packages, "trust": self.trust, "warn": self.console.warn_ahead}

    def understood(self, description: Description) -> Case | None:
        """Load a robot in any format, with the source positions of its values, or print errors and return None."""
        case, diagnostics = self.request(description).load_case()
        if case is None:
            self.console.show(diagnostics)
        return case

    def nothing_written(self, description: Description, diagnostics: Sequence[Diagnostic]) -> int:
        """Print that nothing was written because of errors, or because there are no outputs; return the exit code."""
        if errors := sum(diagnostic.severity == ERROR for diagnostic in diagnostics):
            self.console.warn(f"{description.name}: {count_of(errors, 'error')}, nothing written")
            return PROBLEMS
        self.console.say(f"{description.name}: nothing to write: the description lists no outputs")
        return FINE

    def show(self, result: Any) -> bool:
        """Print the files that were read for a result, and its diagnostics; return True if there are errors."""
        self.console.print_read(getattr(result, "inputs", ()))
        self.console.show(result.diagnostics)
        return has_errors(result.diagnostics)

    def give(self, result: object, text: Callable[[], str] = str, show: Callable[[str], object] = print) -> int:
        """Set the result for JSON; in the formats text and github, print ``text()``. Return the exit code ``FINE``."""
        self.console.result = result
        if self.console.form in ("text", "github") and (shown := text()):
            show(shown)
        return FINE

    def write_page(self, page: Pictures) -> None:
        """Write an HTML page that shows changes of robots. Raises RequestError."""
        try:
            done = page.write()
        except OutputError as problem:
            raise RequestError(f"cannot write the page: {problem.diagnostic.message}") from None
        if not done.robots:
            self.console.warn(f"{done.file}: no new page, because no robot compiles")
            return
        if done.left_out:
            self.console.warn(f"{done.file}: without {done.left_out}")
        self.console.say(f"{done.file}: a page with {count_of(done.robots, 'robot')}, {done.bytes / 1e6:.1f} MB")


def pair(text: str, form: str) -> tuple[str, str]:
    """Split text such as NAME=VALUE or NAME:=VALUE into name and value. Raises RequestError.

    ``form`` is the syntax in the error message. The value may be empty only if ``form`` is NAME=VALUE.
    """
    name, equals, value = text.partition("=")
    name = name.strip().removesuffix(":")
    if not equals or not name or not (value.strip() or form == "NAME=VALUE"):
        raise RequestError(f'"{text}" is not {form}')
    return name, value if form == "NAME=VALUE" else value.strip()


def for_each(
    run: Run, work: Callable[[Run, Description], int], usage: str = "", robots: Sequence[str] | None = None
) -> int:
    """Call ``work`` with each robot of the command line, or of ``robots``; return the highest exit code.

    Without names, all robots are used. If ``usage`` is set, there must be only one robot then. Raises RequestError.
    """
    if (summary := getattr(run, "summary", None)) is not None:
        from .report_formats import HEAD, markdown

        begins = files.read_bytes(summary, len(HEAD)).decode(errors="replace") if files.is_file(summary) else ""
        is_job_summary = files.resolve(summary) == files.resolve(os.environ.get("GITHUB_STEP_SUMMARY", ""))
        if begins.strip() not in ("", HEAD.strip()) and not is_job_summary:
            raise RequestError(f'"{summary}" exists and is not a summary: name another file')
    console, names = run.console, [*(run.words if robots is None else robots)]
    hook = getattr(run, "hook", False) and bool(run.changed or run.words)
    if hook and names:
        raise RequestError(f'with --hook the words are files that changed, and there is no file "{names[0]}"')
    if hook:
        names = [str(path) for path in project.descriptions_of(run.changed)]
    elif usage and not names:
        names = [str(run.find_robot("", usage).path)]
    found = [] if hook and not names else find_robots(run, names)
    if getattr(run, "depfile", None) is not None and len(found) > 1:
        several = ", ".join(description.name for description in found)
        raise RequestError(f"a depfile is about one robot, and there are several: {several}; name one")
    if not (run.words or run.changed or usage):
        warn_of_no_robots(console)
    if not found:
        console.say("none of these files is in a project: no folder above them has descriptions/*/robot.yaml")
    worst = FINE
    for description in found:
        console.begin(description.name)
        Progress.set_topic(f"{description.name}:" if len(found) > 1 else "")
        console.robots.append({"robot": description.name, "file": str(description.path), "fine": False})
        # In formats such as JSON, standard output is a single document: redirect output of plug-ins to standard error.
        with nullcontext() if console.plugin is None or console.for_people else divert_stdout():
            code = work(run, description)
        console.robots[-1]["fine"] = code == FINE
        console.end(code != FINE)
        worst = max(worst, code)
    run.give({"robots": console.robots})
    if summary is not None:
        try:
            with Path(summary).open("a", encoding="utf-8", errors="backslashreplace") as file:
                file.write(markdown(console.sections))
        except (OSError, ValueError) as problem:
            reason = getattr(problem, "strerror", None) or problem
            raise RequestError(f'cannot write the summary "{summary}": {reason}') from None
    return worst


def find_robots(run: Run, names: list[str]) -> list[Description]:
    """Find robots by name, by default all robots of the project. Raises RequestError, NoDescription.

    With -o FOLDER, artifacts of a single robot go to FOLDER; with several robots or --hook, each has a subfolder.
    """
    take_stdin(names)
    output = getattr(run, "output", None)
    found = Description.find(names, output)
    if output is not None and len(found) == 1 and not getattr(run, "hook", False):
        return [replace(found[0], outputs=Path(output))]
    return found


def take_stdin(names: Sequence[str]) -> None:
    """Read a robot from standard input if "-" is one of the names. Raises RequestError."""
    if Description.STDIN not in names:
        return
    if names.count(Description.STDIN) > 1:
        raise RequestError("standard input can be read only once, and - is given twice")
    if sys.stdin is None:
        raise RequestError("there is no standard input to read a robot from")
    if _stdin_read == [sys.stdin]:
        return
    if sys.stdin.isatty():
        print("reading a robot from this terminal; Ctrl-D ends it", file=sys.stderr, flush=True)
    project.give_stdin(sys.stdin.buffer.read(_MAX_STDIN))
    _stdin_read[:] = [sys.stdin]
    Progress.begin()  # the delay before progress is printed must not include the time in which the user types


def refuse_stdin(words: Sequence[str], help: str = "name a file") -> None:
    """Raise RequestError if "-", standard input, is one of the words; ``help`` suggests an alternative."""
    if Description.STDIN in words:
        raise RequestError(f"a robot on standard input has no name and no folder; {help}")


def warn_of_no_robots(console: Console) -> None:
    """Warn about folders of the project that look like descriptions but have no ``robot.yaml``."""
    if wrong := project.without_first_file(Description.project_folder()):
        console.show([Diagnostic("no-robot-file", WARNING, message, help=help) for message, help in wrong])


def count(artifacts: Sized, meshes: Collection[str] = ()) -> str:
    """Format the numbers of artifacts, mesh files and textures, as in "3 artifacts and 1 mesh file"."""
    return phrase([count_of(len(artifacts), "artifact"), *counted_files(meshes)])


def counted_files(names: Collection[str]) -> list[str]:
    """Format the numbers of mesh files and textures that are not zero, as in ["2 mesh files", "1 texture"]."""
    textures = sum(name.lower().endswith(".png") for name in names)
    return [count_of(n, word) for word, n in (("mesh file", len(names) - textures), ("texture", textures)) if n]


def severities(diagnostics: Sequence[Diagnostic]) -> str:
    """Format the number of diagnostics of each severity, as in "1 error and 2 warnings"."""
    counts = Counter(one.severity for one in diagnostics)
    return phrase(count_of(counts[one], one) for one in (ERROR, WARNING, NOTE) if counts[one]) or "nothing to say"


def write_depfile(
    run: Run,
    target: str,
    compiled: CompileResult,
    inputs: Sequence[Path],
    made: Sequence[Path],
    newer: Sequence[Path] = (),
) -> None:
    """Write the requested depfile, then set the time of the files ``newer`` to now. Raises OutputError.

    ``inputs`` are the files that the target depends on, ``made`` the artifacts. The depfile must be a different file.
    """

    def is_depfile(old: Path) -> bool:
        data = old.read_bytes()
        return not data.strip() or re.fullmatch(_DEPFILE, data) is not None

    path = Path(run.depfile)
    # A build tool would try to make a missing file, so list its folder instead. Do not list a folder outside of the
    # project or with files that this run writes, because the folder would also change for other reasons.
    projects = Description.from_path(compiled.inputs[0]).projects if compiled.missing else ()
    written = {file.absolute().parent for file in (*made, path)}
    sources = [*inputs]
    for missing in compiled.missing:
        folder = next(parent for parent in missing.absolute().parents if parent.is_dir())
        if folder not in written and any(map(folder.resolve().is_relative_to, projects)):
            sources.append(Path(files.label(folder)))
    names = [escape(name) for name in (target, *dict.fromkeys(map(str, sources)))]
    if os.path.realpath(path) in map(os.path.realpath, (*sources, *made)):
        raise OutputError("output-is-input", f"{path} is an input or an artifact in the depfile", "name another file")
    text = " \\\n  ".join([f"{names[0]}:", *names[1:]]) + "\n"
    write_file(path, os.fsencode(text), may_replace=is_depfile)
    for file in newer:
        os.utime(file)


def escape(name: str) -> str:
    r"""Escape a file name for a depfile, as GCC does. Raises OutputError for a line break.

    >>> print(escape("my robot/$x#1.yaml"))
    my\ robot/$$x\#1.yaml
    """
    if re.search(r"[\n\r\0]", name):
        help = "a depfile has no way to write it: give the file another name"
        raise OutputError("depfile-name", f"the name of {name} has a line break", help)
    name = re.sub(r"(\\*)([ \t])", r"\1\1\\\2", name)
    return re.sub("[#:]", r"\\\g<0>", name).replace("$", "$$")

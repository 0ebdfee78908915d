"""Print the diagnostics and the result of a run: immediately as text, or at the end as one document, such as JSON."""

import dataclasses
import errno
import math
import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from rosorin_compile.source.diagnostics import ERROR, NOTE, TRUSTED, WARNING, Diagnostic, Span
from rosorin_compile.source.diagnostics import text as report_text
from rosorin_compile.source.messages import add_suggestions, gather
from rosorin_compile.source.plugins import Plugin
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import and_more, count_of, printable

if TYPE_CHECKING:
    from .report_formats import Section

FINE, PROBLEMS, USAGE = 0, 1, 2  # exit codes
PROGRESS = "ROSORIN_COMPILE_PROGRESS"  # environment variable; "off" hides the progress

_STAND_IN = "stand-in"
_LISTED = ("not-in-format", "engine-missing", "drives-assumed")  # rules whose notes are always printed, not counted
_MAX_SHOWN = 200  # maximum number of diagnostics in text output; JSON and SARIF have all
_LAYOUT = "\n\t"
_COLOUR = "(\x1b\\[[0-9]{1,2}m)"  # the escape sequences for colours, the only ones that this tool prints


class _Guard:
    """A text stream that escapes control characters and bidirectional text controls."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        Progress.wipe()
        self.stream.write(printable(text, _LAYOUT))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)


@contextmanager
def guard() -> Iterator[None]:
    """Escape control characters in all output of the ``with`` block, except output of ``paint`` and ``give``."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # Python sets a stream to None if it is closed when the process starts
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - open until exit
    guards: tuple[Any, Any] = _Guard(sys.stdout), _Guard(sys.stderr)
    with redirect_stdout(guards[0]), redirect_stderr(guards[1]):
        yield


def _unguarded(stream: TextIO) -> TextIO:
    return stream.stream if isinstance(stream, _Guard) else stream


def show_progress() -> None:
    """Show progress on the last line of standard error if it is a terminal."""
    is_off = os.environ.get(PROGRESS) == "off" or os.environ.get("TERM") == "dumb" or "CI" in os.environ
    if not is_off and sys.stderr.isatty():
        Progress.show(_unguarded(sys.stderr))


def paint(text: str, stream: TextIO) -> None:
    """Write text with colours to a stream, and escape all control characters except those of colours."""
    pieces = re.split(_COLOUR, text)
    pieces[::2] = [printable(piece, _LAYOUT) for piece in pieces[::2]]
    Progress.wipe()
    _unguarded(stream).write("".join(pieces))


def give(text: str) -> None:
    """Print an artifact: unchanged, or with escaped control characters on a terminal. Raises OSError."""
    if getattr(sys.stdout, "name", "") == os.devnull:
        raise OSError(errno.EBADF, "it is closed")
    Progress.wipe()
    stream = sys.stdout if sys.stdout.isatty() else _unguarded(sys.stdout)
    raw = getattr(stream, "buffer", None)
    if isinstance(stream, _Guard) or raw is None:
        stream.write(text)
        return
    stream.flush()
    rest = memoryview(text.encode())
    while rest:  # with PYTHONUNBUFFERED, a call to ``write`` may write only some of the bytes
        rest = rest[raw.write(rest) or 0 :]


class Console:
    """Prints the output of a run in the format ``form``.

    ``quiet`` prints only errors, ``verbose`` also the names of files that were read. ``counts_notes`` prints the number
    of notes instead of the notes. ``keeps_sections`` collects a Markdown report. ``plugin`` defines the running
    ``command``, if set.
    """

    def __init__(self, form: str = "text", quiet: bool = False) -> None:
        self.form = form
        self.quiet = quiet
        self.verbose = self.counts_notes = self.keeps_sections = False
        self.command = ""
        self.plugin: Plugin | None = None
        self.sections: list[Section] = []
        self.diagnostics: list[Diagnostic] = []  # to print at the end in formats such as JSON
        self.severities: Counter[str] = Counter()
        self.unlisted: Counter[str] = Counter()  # {"stand-in" or "note": number of notes that were not printed}
        self.robots: list[dict[str, object]] = []  # the results of a command for several robots
        self.result: object = None

    @property
    def for_people(self) -> bool:
        return self.form == "text"

    @property
    def section(self) -> "Section":
        if not self.sections:
            self.begin("")
        return self.sections[-1]

    def begin(self, name: str) -> None:
        """Start the section of a robot in the Markdown report."""
        if self.keeps_sections:
            from .report_formats import Section

            self.sections.append(Section(name))

    def end(self, failed: bool) -> None:
        """End the section of a robot. If the robot failed without a message, refer to the log."""
        if self.keeps_sections and failed and not self.section.failed:
            self.section.wrong.append("failed: see the log of the run")

    def differ(self, what: str, lines: Sequence[str], diagnostic: Diagnostic) -> None:
        """Report differences: print ``lines``, or collect ``diagnostic`` for JSON. ``what`` is the Markdown summary."""
        self.severities[diagnostic.severity] += 1
        self.robots[-1]["differences"] = lines
        if self.for_people:
            print("\n".join(lines))
        else:
            self.diagnostics.append(diagnostic)
        if self.keeps_sections:
            self.section.wrong.append(what)
            self.section.differences += lines
            self.section.lines += [diagnostic.help] if diagnostic.help else []

    def show(self, diagnostics: Sequence[Diagnostic], listed: bool = False) -> None:
        """Print diagnostics, or collect them for formats such as JSON; ``listed`` prints notes instead of counting."""
        self.severities.update(one.severity for one in diagnostics)
        if self.quiet:
            diagnostics = [one for one in diagnostics if one.severity == ERROR or one.rule == _STAND_IN]
        if self.keeps_sections or not self.for_people:
            diagnostics = add_suggestions(diagnostics)
        if self.keeps_sections:
            self.section.diagnostics += diagnostics
        if not self.for_people:
            self.diagnostics += diagnostics
            return
        if self.quiet or (self.counts_notes and not listed):
            notes = [one for one in diagnostics if one.severity == NOTE and one.rule not in _LISTED]
            self.unlisted.update(_STAND_IN if one.rule == _STAND_IN else NOTE for one in notes)
            diagnostics = [one for one in diagnostics if one.severity != NOTE or one.rule in _LISTED]
        diagnostics = gather(diagnostics, [WARNING, NOTE])
        # The environment variables NO_COLOR and FORCE_COLOR override the test for a terminal.
        is_coloured = "NO_COLOR" not in os.environ and ("FORCE_COLOR" in os.environ or sys.stderr.isatty())
        text = report_text(add_suggestions(diagnostics[:_MAX_SHOWN]), is_coloured)
        if len(diagnostics) > _MAX_SHOWN:
            text += f"...{and_more(len(diagnostics) - _MAX_SHOWN)}; --format json lists them all\n"
        if diagnostics:
            paint(text, sys.stderr)

    def warn_ahead(self, diagnostic: Diagnostic) -> None:
        """Print a warning about code that will run, unless the code is trusted."""
        if diagnostic.numbers != TRUSTED:
            self.show([diagnostic])

    def say(self, line: str, needed: bool = False) -> None:
        """Print a line about the run; with --quiet, only if the line is ``needed``."""
        if self.quiet and not needed:
            return
        print(self._inert(line), file=sys.stdout if self.for_people else sys.stderr)
        if self.keeps_sections:
            self.section.lines.append(line.removeprefix(f"{self.section.name}: "))

    def warn(self, line: str) -> None:
        """Print a line to standard error, even with --quiet."""
        sys.stderr.write(f"{self._inert(line)}\n")

    def _inert(self, line: str) -> str:
        # Names from a robot could contain GitHub workflow commands.
        return line.replace("::", ": :").replace("##[", "## [") if self.form == "github" else line

    def print_read(self, files: Iterable[object]) -> None:
        """Print the names of files that were read, with --verbose."""
        if self.verbose and self.for_people:
            for file in dict.fromkeys(map(str, files)):
                self.warn(f"read {file}")

    def fail(self, message: str, code: int) -> int:
        """Report why the run ended, and return the exit code ``code``."""
        sys.stderr.write(f"rosorin-compile: {message}\n")
        self.diagnostics.append(Diagnostic("wrong-usage" if code == USAGE else "run-stopped", ERROR, message))
        return code

    def print_end(self) -> None:
        """Print the number of notes that were not listed, or the document in a format such as JSON."""
        if self.for_people and self.unlisted.total():
            stand_ins, notes = self.unlisted[_STAND_IN], self.unlisted[NOTE]
            counts = [f"{count_of(stand_ins, _STAND_IN)}: values that are not measured"] if stand_ins else []
            counts += [count_of(notes, NOTE)] if notes else []
            how = f"--notes lists {'it' if counts == ['1 note'] else 'them'}"
            self.warn(f"{', and '.join(counts)}; {how if self.counts_notes else 'without -q they are listed'}")
        if self.form == "json":
            import json

            sys.stdout.write(json.dumps(envelope(self), indent=2, allow_nan=False) + "\n")
        elif not self.for_people:
            from .report_formats import FORMATS, markdown

            shown = markdown(self.sections) if self.form == "markdown" else FORMATS[self.form](self.diagnostics)
            sys.stdout.write(shown)


def envelope(console: Console) -> dict[str, object]:
    """Return the result and the diagnostics of a run as JSON data that conforms to the schema ``envelope``."""
    from rosorin_compile.source.version import __version__

    diagnostics = [plain(one.as_object()) for one in console.diagnostics]
    result = plain(console.result)
    return {"version": __version__, "command": console.command, "diagnostics": diagnostics, "result": result}


def plain(value: object) -> object:
    """Convert a value to JSON data. A dataclass becomes an object with the fields that its ``repr`` shows.

    Diagnostics are omitted, because the envelope has them. Infinite numbers become null.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.repr}
        return {name: plain(inner) for name, inner in fields.items() if name != "diagnostics"}
    if isinstance(value, Span):
        return {"file": value.source.path, "line": value.line, "column": value.column}
    if hasattr(value, "_asdict"):  # a named tuple
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(inner) for inner in (sorted(value) if isinstance(value, (set, frozenset)) else value)]
    if isinstance(value, Path):
        return str(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value


def table(rows: Sequence[Sequence[str]], align: Callable[[str, int], str] = str.ljust) -> list[str]:
    """Format rows of cells as lines with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(align, row, widths)).rstrip() for row in rows]

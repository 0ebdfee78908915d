"""Print the output of a command: diagnostics at once for a person, or as one document at the end for a program.

While ``guarded`` is active, no text of a file, of a name or of another program controls the terminal; ``paint`` and
``give`` bypass it, for our own colours and for artifacts on their way into a file or a pipe.
"""

from __future__ import annotations

import errno
import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from rosorin_compile.source.diagnostics import ERROR, NOTE, TRUSTED, WARNING, Diagnostic
from rosorin_compile.source.diagnostics import text as report_text
from rosorin_compile.source.messages import gathered, worded
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import and_more, counted, printable

if TYPE_CHECKING:
    from .markdown import Block, Section

MAX_SHOWN = 200  # more than a person reads; a program gets all

PROGRESS = "ROSORIN_COMPILE_PROGRESS"  # the variable; off: no progress is shown
MARKDOWN = "markdown"
ENVELOPE = "json"  # a result with all diagnostics of the run

_STAND_IN = "stand-in"
_LISTED = ("not-in-format", "engine-missing", "drives-assumed")  # notes that are printed where others are counted
_LAYOUT = "\n\t"
_COLOUR = "(\x1b\\[[0-9]{1,2}m)"  # the only sequences that we write within a text


class _Guard:
    """A stream that makes control characters and bidi controls visible."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        """Write a text; lines and tabs stay."""
        Progress.wipe()
        self.stream.write(printable(text, _LAYOUT))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write texts."""
        for line in lines:
            self.write(line)


@contextmanager
def guarded() -> Iterator[None]:
    """Make control characters visible in whatever is printed in the block."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # the caller has closed it
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - as long as we run
    before = sys.stdout, sys.stderr
    guards: tuple[Any, Any] = _Guard(sys.stdout), _Guard(sys.stderr)
    sys.stdout, sys.stderr = guards
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def _unguarded(stream: TextIO) -> TextIO:
    return stream.stream if isinstance(stream, _Guard) else stream


def show_progress() -> None:
    """Show progress on the last line of standard error if it is the terminal of a person."""
    is_off = os.environ.get(PROGRESS) == "off" or os.environ.get("TERM") == "dumb" or "CI" in os.environ
    if not is_off and sys.stderr.isatty():
        Progress.show(_unguarded(sys.stderr))


def paint(text: str, stream: TextIO) -> None:
    """Print a text that contains our own colours."""
    pieces = re.split(_COLOUR, text)
    pieces[::2] = [printable(piece, _LAYOUT) for piece in pieces[::2]]
    Progress.wipe()
    _unguarded(stream).write("".join(pieces))


def give(text: str) -> None:
    """Print an artifact: to the byte, in UTF-8 whatever the locale is, except on a terminal. Raises OSError."""
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
    while rest:  # with PYTHONUNBUFFERED a write may end early
        rest = rest[raw.write(rest) or 0 :]


class Console:
    """Prints the output of a run, in one of the forms of ``report``.

    ``quiet``: only errors; ``verbose``: also which files were read; ``summary``: sections of Markdown are collected,
    whatever the form. ``collected`` and ``severities`` may be shared by several consoles.
    """

    give = staticmethod(give)

    def __init__(
        self,
        form: str,
        quiet: bool = False,
        verbose: bool = False,
        summary: bool = False,
        collected: list[Diagnostic] | None = None,
        severities: Counter[str] | None = None,
    ) -> None:
        self.form = form
        self.for_people = form == "text"  # otherwise standard output is one document for a program
        self.quiet = quiet
        self.verbose = verbose
        self.keeps = summary or form == MARKDOWN
        self.sections: list[Section] = []
        self.collected: list[Diagnostic] = [] if collected is None else collected
        self.severities: Counter[str] = Counter() if severities is None else severities
        self.unlisted: Counter[str] = Counter()  # the notes that were counted, and not printed; stand-ins apart
        self.counts = False  # whether notes are counted for people, and not listed
        self.listing = "without -q they are listed"
        self.differing: list[str] = []  # the differences of the current robot, in lines

    @property
    def section(self) -> Section:
        """The section of the current robot."""
        if not self.sections:
            self.begin("")
        return self.sections[-1]

    def begin(self, name: str) -> None:
        """Begin with the output of one robot."""
        self.differing = []
        if self.keeps:
            from .markdown import Section

            self.sections.append(Section(name))

    def end(self, failed: bool) -> None:
        """End with one robot; a failure without a message refers to the log."""
        if self.keeps and failed and not self.section.failed:
            self.section.wrong.append("failed: see the log of the run")

    def differ(self, what: str, lines: Sequence[str], told: Diagnostic, blocks: Callable[[], Sequence[Block]]) -> None:
        """Report a difference: as ``lines``, for a program as a diagnostic, in Markdown as ``what`` and ``blocks``."""
        self.differing += lines
        self.severities[told.severity] += 1
        if self.for_people:
            for line in lines:
                print(line)
        else:
            self.collected.append(told)
        if self.keeps:
            self.section.wrong.append(what)
            self.section.blocks += blocks()
            self.section.said += [told.help] if told.help else []

    def show(self, diagnostics: Sequence[Diagnostic], listed: bool = False) -> None:
        """Print diagnostics, or collect them; for people notes may only be counted, unless ``listed``."""
        self.severities.update(one.severity for one in diagnostics)
        if self.keeps or not self.for_people:
            diagnostics = worded(diagnostics)
        if self.quiet:
            stand_ins = [one for one in diagnostics if one.rule == _STAND_IN]
            diagnostics = [*(one for one in diagnostics if one.severity == ERROR), *stand_ins]
        if self.keeps:
            self.section.diagnostics += diagnostics
        if not self.for_people:
            self.collected += diagnostics
            return
        if self.quiet or (self.counts and not listed):
            notes = [one for one in diagnostics if one.severity == NOTE and one.rule not in _LISTED]
            self.unlisted.update(_STAND_IN if one.rule == _STAND_IN else NOTE for one in notes)
            diagnostics = [one for one in diagnostics if one.severity != NOTE or one.rule in _LISTED]
        if not diagnostics:
            return
        diagnostics = gathered(diagnostics, [WARNING, NOTE])
        text = report_text(worded(diagnostics[:MAX_SHOWN]), colour())
        if len(diagnostics) > MAX_SHOWN:
            text += f"...{and_more(len(diagnostics) - MAX_SHOWN)}; --format json lists them all\n"
        if colour():
            paint(text, sys.stderr)
        else:
            sys.stderr.write(printable(text, _LAYOUT))

    def ahead(self, diagnostic: Diagnostic) -> None:
        """Print a diagnostic before anything is run."""
        if diagnostic.numbers != TRUSTED:
            self.show([diagnostic])

    def say(self, line: str, needed: bool = False) -> None:
        """Print a line about the run as a whole; a quiet run prints it only if it is ``needed``."""
        if self.quiet and not needed:
            return
        print(self._inert(line), file=sys.stdout if self.for_people else sys.stderr)
        if self.keeps:
            self.section.said.append(line.removeprefix(f"{self.section.name}: "))

    def tell_read(self, files: Iterable[object]) -> None:
        """Print which files were read, if the run is verbose."""
        if self.verbose and self.for_people:
            for file in dict.fromkeys(map(str, files)):
                self.warn(f"read {file}")

    def warn(self, line: str) -> None:
        """Print a line to standard error, also in a quiet run."""
        sys.stderr.write(f"{self._inert(line)}\n")

    def _inert(self, line: str) -> str:
        """Return a line in which a job on GitHub finds no command, whatever a robot is called."""
        return line.replace("::", ": :").replace("##[", "## [") if self.form == "github" else line

    def summary(self) -> str:
        """Return the output as Markdown."""
        from .markdown import document

        return document(self.sections)

    def finish(self) -> None:
        """Print how many notes were not listed. Documents for programs are printed at the end of the run."""
        if self.for_people and self.unlisted.total():
            stand_ins, notes = self.unlisted[_STAND_IN], self.unlisted[NOTE]
            counts = [f"{counted(stand_ins, _STAND_IN)}: values that are not measured"] if stand_ins else []
            counts += [counted(notes, NOTE)] if notes else []
            listing = self.listing.replace("them", "it") if counts == ["1 note"] else self.listing
            self.warn(f"{', and '.join(counts)}; {listing}")


def print_document(form: str, consoles: Iterable[Console], collected: Sequence[Diagnostic]) -> None:
    """Print the diagnostics of a run in a form for programs."""
    if form == MARKDOWN:
        from .markdown import document

        sys.stdout.write(document([section for console in consoles for section in console.sections]))
        return
    from .report_formats import FORMATS

    sys.stdout.write(FORMATS[form](collected))


def colour() -> bool:
    """Return True if diagnostics are printed in colour: NO_COLOR and FORCE_COLOR come before a terminal."""
    if "NO_COLOR" in os.environ:
        return False
    return ("FORCE_COLOR" in os.environ) or sys.stderr.isatty()

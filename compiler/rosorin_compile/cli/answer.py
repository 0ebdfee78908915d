"""The answer of one run: a result and diagnostics, printed as text or as one JSON envelope at the end.

The envelope has the keys ``version``, ``command``, ``diagnostics`` and ``result``; its schema is ``envelope``.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.cli.console import ENVELOPE, Console
from rosorin_compile.source.diagnostics import ERROR, Diagnostic
from rosorin_compile.source.rule_registry import WRITING, Rule

RULES = (
    Rule(
        "wrong-usage",
        "The command line cannot be followed (in the forms for programs); the exit code is 2.",
        "As the message says; `rosorin-compile COMMAND --help` has what a command takes.",
        WRITING,
    ),
    Rule(
        "run-stopped",
        "The run ended before its result: a file or folder cannot be used, memory ran out, or the input is too large.",
        "As the message says.",
        WRITING,
    ),
)

FINE, PROBLEMS, USAGE = 0, 1, 2  # exit codes


class Answer:
    """The answer of one run: the command, the format, what was reported, and the result."""

    def __init__(self, command: str = "", form: str = "text") -> None:
        self.command = command
        self.form = form
        self.diagnostics: list[Diagnostic] = []
        self.severities: Counter[str] = Counter()
        self.consoles: list[Console] = []
        self.result: object = None
        self.robots: list[dict[str, object]] = []
        self.code = FINE

    def fail(self, message: str, code: int) -> None:
        """Report why the run ended."""
        sys.stderr.write(f"rosorin-compile: {message}\n")
        self.diagnostics.append(Diagnostic("wrong-usage" if code == USAGE else "run-stopped", ERROR, message))
        self.code = code

    def console(self, quiet: bool = False, verbose: bool = False, summary: bool = False) -> Console:
        """Return a console that collects diagnostics for this answer unless it prints them as text."""
        console = Console(self.form, quiet, verbose, summary, self.diagnostics, self.severities)
        self.consoles.append(console)
        return console

    def end(self) -> None:
        """Print the document of a program: the envelope, or the diagnostics in the requested format."""
        if self.form == ENVELOPE:
            import json

            sys.stdout.write(json.dumps(envelope(self), indent=2, allow_nan=False) + "\n")
        elif self.form != "text":
            from rosorin_compile.cli.console import print_document

            print_document(self.form, self.consoles, self.diagnostics)


def envelope(answer: Answer) -> dict[str, object]:
    """Return the JSON envelope of an answer, as plain data."""
    from rosorin_compile.source.version import __version__

    return {
        "version": __version__,
        "command": answer.command,
        "diagnostics": [plain(one.as_object()) for one in answer.diagnostics],
        "result": plain(answer.result),
    }


def requested_format(words: Sequence[str]) -> str:
    """Return the value of --format in a command line that is not parsed yet."""
    found = "text"
    for word, following in zip(words, [*words[1:], ""], strict=True):
        name, equals, value = word.partition("=")
        if name == "--format":
            found = value if equals else following
    return found if found == ENVELOPE else "text"


def answer_of(options: Any) -> Answer:
    """Return the answer of the run with these options."""
    if not hasattr(options, "answer"):
        options.answer = Answer(form=getattr(options, "format", "text"))
    answer: Answer = options.answer
    return answer


def give_result(options: Any, result: object, text: Callable[[], str], show: Callable[[str], object] = print) -> int:
    """Set the result of a command, and print it with ``show`` as ``text`` unless a program reads the output.

    Return the exit code ``FINE``.
    """
    answer = answer_of(options)
    answer.result = result
    if answer.form in ("text", "github") and (shown := text()):
        show(shown)
    return FINE


def plain(value: object) -> object:
    """Return a value as plain JSON data; a dataclass becomes an object of the fields in its ``repr``.

    Diagnostics are left out: the envelope has them. Infinite numbers are null.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.repr}
        return {name: plain(inner) for name, inner in fields.items() if name != "diagnostics"}
    if hasattr(value, "_asdict"):  # a named tuple
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(inner) for inner in (sorted(value) if isinstance(value, (set, frozenset)) else value)]
    if isinstance(value, Path):
        return str(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value


def table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows of cells as lines with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]

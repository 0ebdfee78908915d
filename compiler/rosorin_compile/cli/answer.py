"""What a command answers a program: one envelope around its result and all that there is to say.

A command gives its result as a value; the command line prints the envelope at the end of the run, also of one that went
wrong. Nothing else prints JSON. ``schemas`` has the form of each envelope.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from rosorin_compile.source.console import ENVELOPE, Console
from rosorin_compile.source.diagnostics import ERROR, Diagnostic
from rosorin_compile.source.project import data_folder

if TYPE_CHECKING:
    import argparse

    from rosorin_compile.source.project import Description

GENERAL = "answer"  # the schema of an answer that has none of its own
_OPTION = "--format"


class Answer:
    """The answer of one run: the command and the form that it is asked in, what was said, and the result if any."""

    def __init__(self, command: str = "", form: str = "text") -> None:
        self.command = command
        self.form = form
        self.diagnostics: list[Diagnostic] = []
        self.result: object = None
        self.robots: list[dict[str, object]] = []

    def refuse(self, message: str) -> None:
        """Add why a command line cannot be followed."""
        self.diagnostics.append(Diagnostic("wrong-usage", ERROR, message))

    def console(self, quiet: bool = False, verbose: bool = False) -> Console:
        """Return what takes messages beside the result: as text, unless they are to be in the envelope."""
        form = self.form if self.form == ENVELOPE else "text"
        return Console(form, quiet, verbose, collected=self.diagnostics)

    def end(self) -> None:
        """Print the envelope, if it is asked for."""
        if self.form == ENVELOPE:
            sys.stdout.write(document(envelope(self)))


def begun(words: Sequence[str]) -> Answer:
    """Return the answer of a command line that is not read yet: the form that it asks for."""
    form = ""
    for word, following in zip(words, [*words[1:], ""], strict=True):
        name, equals, value = word.partition("=")
        if len(name) > len("--f") and _OPTION.startswith(name):
            form = value if equals else following
    return Answer(form=form)


def answer_of(options: argparse.Namespace) -> Answer:
    """Return the answer that a run is to give."""
    if not hasattr(options, "answer"):
        options.answer = Answer(form=getattr(options, "format", "text"))
    answer: Answer = options.answer
    return answer


def give_result(
    options: argparse.Namespace, result: object, text: Callable[[], str], show: Callable[[str], object] = print
) -> None:
    """Give the result of a command: a person reads it as ``text``, which ``show`` prints, a program in the envelope."""
    answer = answer_of(options)
    answer.result = result
    if answer.form != ENVELOPE and (shown := text()):
        show(shown)


def begin_robot(options: argparse.Namespace, description: Description) -> None:
    """Begin the row of a robot, in the result of a command that goes through robots."""
    answer_of(options).robots.append({"robot": description.name, "file": str(description.path), "fine": False})


def tell_of_robot(options: argparse.Namespace, more: Mapping[str, object]) -> None:
    """Add to the row of the robot at hand; where a command goes through none there is no row."""
    answer = answer_of(options)
    if answer.robots:
        answer.robots[-1].update(more)


def envelope(answer: Answer) -> dict[str, object]:
    """Return an answer with what every answer says: the version, its schema, the diagnostics, the result or None."""
    from rosorin_compile.source.report import as_object
    from rosorin_compile.source.version import __version__

    return {
        "rosorin_compile": __version__,
        "schema": schema_of(answer.command),
        "diagnostics": [as_object(one) for one in answer.diagnostics],
        "result": answer.result,
    }


def schema_of(command: str) -> str:
    """Return the name of the schema of what a command answers, as ``rosorin-compile schema`` takes it."""
    name = name_of(command)
    own = name.isascii() and name.isidentifier()
    return name if own and os.path.lexists(data_folder("schemas") / f"{name}.schema.json") else GENERAL


def name_of(command: str) -> str:
    """Return the name that the schema of a command has, if there is one; that of all answers for no command."""
    return f"{GENERAL}_{command.replace('-', '_').replace(' ', '_')}" if command else GENERAL


def document(value: object, indent: int | None = 2) -> str:
    """Return a value as JSON; it has no word for a number that is none, which is null there."""
    import json

    try:
        return json.dumps(value, indent=indent, allow_nan=False) + "\n"
    except ValueError:
        return json.dumps(_finite(value), indent=indent) + "\n"


def _finite(value: object) -> object:
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

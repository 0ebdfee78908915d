"""rosorin-compile explain: say where a frame sits, and where each of its numbers was written."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.project import Description, NoDescription, all_here, here

from .answer import give_result
from .compiling import warn_before
from .given import Given
from .robots import take_stdin
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.language.explain.explanation import Answer, Explanation
    from rosorin_compile.source.console import Console

    from .parser import Parser


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_argument(
        "words",
        nargs="+",
        metavar="[ROBOT] NAME",
        completes="[ROBOT] THING ...",
        help="the robot, and names of frames, links, joints, sensors, parts or their values (z, mass)",
    )
    command.add_argument("--pose", default="", metavar="POSE", help="also print the frames in a named pose")
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Explain frames of one robot."""
    run = Run.of(options)
    take_stdin(run.words)
    description, names = _asked(run.words)
    found = _explained(run.given, description, names, options.pose, run.console)
    if found is None:
        return PROBLEMS
    from rosorin_compile.language.explain.explanation import as_json

    from .explain_text import lines

    answers = [as_json(explanation) for explanation in found]
    give_result(options, answers, lambda: "\n".join(line for explanation in found for line in lines(explanation)))
    return FINE


def _asked(words: list[str]) -> tuple[Description, list[str]]:
    """Return the robot and the names that are meant: of several words the first is the robot if it can be."""
    if len(words) > 1:
        try:
            return Description.find(words[:1])[0], words[1:]
        except NoDescription as problem:
            if not all_here():
                raise WrongUsage(str(problem)) from None
    try:
        found = here()
    except NoDescription as problem:
        raise WrongUsage(str(problem)) from None
    if len(found) > 1:
        robots = ", ".join(description.name for description in found)
        raise WrongUsage(f"there are several robots here: {robots}; write explain ROBOT {' '.join(words)}")
    return found[0], words


def _explained(
    given: Given, description: Description, names: list[str], pose: str, console: Console
) -> list[Explanation | Answer] | None:
    """Return the explanations of the names; None, after saying what is wrong, of a description with errors."""
    from rosorin_compile.language.explain.answer import NotThere, explain
    from rosorin_compile.output.pipeline import understand
    from rosorin_compile.source.diagnostics import has_errors
    from rosorin_compile.source.load import LoadError

    try:
        arguments: dict[str, Any] = given.values()
    except LoadError as problem:
        console.show([problem.diagnostic])
        return None
    expanded, lowered, diagnostics, _ = understand(
        description.path, arguments, warn_before(given, console), given.packages
    )
    if lowered is None or lowered.robot is None or has_errors(diagnostics):
        console.show([diagnostic for diagnostic in diagnostics if diagnostic.severity == "error"])
        console.warn(f"{description.name}: a description with errors has no meaning to explain")
        return None
    try:
        return explain(expanded, lowered, arguments, names, pose)
    except NotThere as problem:
        raise WrongUsage(f"{description.name}: {problem}") from None

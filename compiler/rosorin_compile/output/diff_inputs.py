"""Sides: one side of a comparison, from whatever it was named as: a description, or a file of another format."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.compare.difference import YAML, Side
from rosorin_compile.compare.tolerance import printing_of
from rosorin_compile.compare.wording import several
from rosorin_compile.formats import FORMATS
from rosorin_compile.language import asked
from rosorin_compile.model import Robot
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, error, has_errors
from rosorin_compile.source.project import STDIN, Description, NoDescription, first_file, stdin_of

from .request import is_foreign

# What a person is to know before a foreign file is opened.
EXECUTED = ("xacro-runs-code",)


class Read(NamedTuple):
    """One side (None if it could not be read), what there is to say, and what of the file is not part of it.

    ``deaf`` says that there is a robot that takes no arguments: neither a description nor, say, a xacro.
    """

    side: Side | None
    diagnostics: list[Diagnostic]
    left_out: tuple[str, ...] = ()
    deaf: bool = False

    def lines(self, label: str, each: bool) -> list[str]:
        """Return the lines on what of the file is not part of the robot: all of it, or the first ones."""
        left = list(dict.fromkeys(self.left_out))
        return [f"{label}: {what}" for what in (left if each or not left else [several(left)])]


def wrong_options(tolerance: object, prefix: object) -> list[Diagnostic]:
    """Return what is wrong with the options of a comparison."""
    diagnostics = []
    if isinstance(tolerance, bool) or not (isinstance(tolerance, (int, float)) and 0 <= tolerance < math.inf):
        message = f"the tolerance is a number from zero upwards, not {tolerance!s:.60}"
        diagnostics.append(error("bad-argument", message, None))
    if not (prefix is None or isinstance(prefix, str)):
        diagnostics.append(error("bad-argument", f"the prefix is text, not {prefix!s:.60}", None))
    return diagnostics


def side_of(robot: object, arguments: Sequence[Mapping[str, Any] | None], packages: object, trust: bool) -> Read:
    """Return one side of a comparison that a program asks for: a Robot, or the name of one on disk."""
    if isinstance(robot, Robot):
        return Read(Side(robot.name, YAML, robot), [])
    both, own = (asked.ask(robot, some, packages) for some in arguments)
    if both.diagnostics or own.diagnostics:
        return Read(None, list(dict.fromkeys([*both.diagnostics, *own.diagnostics])))
    values: Mapping[str, Any] = {**both.arguments, **own.arguments}
    file, _ = asked.file_of(own.name)
    if file is not None and not asked.is_description(file):
        values, wrong = asked.as_texts(values)
        if wrong:
            return Read(None, wrong)
    try:
        read = read_side(own.name, values, own.packages, trust)
    except (NoDescription, OSError) as problem:
        return Read(None, [asked.unreadable(problem)])
    if own.arguments and read.deaf:
        return read._replace(diagnostics=[*read.diagnostics, asked.deaf(Path(own.name))])
    return read


def read_side(word: str, arguments: Mapping[str, Any], packages: Mapping[str, Path], trust: bool = False) -> Read:
    """Return the robot that a word names: file of any format, folder or name of a description.

    ``arguments`` are those of a description or a xacro file; ``trust`` is that in what a xacro runs. Raises
    project.NoDescription if there is no such robot.
    """
    path = first_file(word) if word == STDIN else Path(word)
    if stdin_of(path) is not None:
        read = _foreign if is_foreign(path) else _description
        return read(path, str(path), arguments, packages, trust)
    if files.is_file(path) and path.suffix.lower() not in YAML.endings:
        return _foreign(path, word, arguments, packages, trust)
    if path.suffix.lower() in FORMATS.endings():
        raise NoDescription(f'there is no file "{word}"')
    return _description(Description.find([word])[0].path, word, arguments, packages, trust)


def _description(
    path: Path, word: str, arguments: Mapping[str, Any], packages: Mapping[str, Path], trust: bool
) -> Read:
    from rosorin_compile.output.pipeline import understand

    _, lowered, diagnostics, _ = understand(path, arguments, packages=packages)
    errors = [diagnostic for diagnostic in diagnostics if diagnostic.severity == ERROR]
    if errors or lowered is None or lowered.robot is None:
        return Read(None, errors)
    said = [diagnostic for diagnostic in diagnostics if diagnostic.rule in EXECUTED and not trust]
    return Read(Side(word, YAML, lowered.robot, folder=path.parent), said)


def _foreign(path: Path, word: str, arguments: Mapping[str, Any], packages: Mapping[str, Path], trust: bool) -> Read:
    from rosorin_compile.formats.imported import ReadOptions
    from rosorin_compile.formats.reading import read_robot
    from rosorin_compile.language.lower import lower

    texts = {name: str(value) for name, value in arguments.items()}
    imported = read_robot(path, ReadOptions(texts, packages, lenient=True, trust=trust))
    said = [d for d in imported.diagnostics if d.severity == ERROR or d.rule in EXECUTED]
    if imported.tree is None or has_errors(said):
        return Read(None, said)
    lowered = lower(imported.tree)
    if lowered.robot is None:
        return Read(None, [*said, *lowered.diagnostics])
    side = Side(word, FORMATS[imported.format], lowered.robot, printing_of(imported.tree), path.parent)
    return Read(side, said, tuple(left.what for left in imported.left_out), not imported.takes_arguments)

"""Typos: two letters side by side swapped at each word of a description, one at a time, and what is told of each.

A word is a key, a name, a value, a unit, a name within an expression, a type, an enumeration. Comments are none, and
neither is what people write for people (``FREE``).
"""

from __future__ import annotations

import re
import shutil
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import yaml

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic, Related
from support.paths import ROOT, ROSORIN

# Keys whose values are text for people: anywhere, and below what they stand in.
FREE = ("note", "help", "about", "method")
FREE_IN = (
    ("accept", "reason"),
    ("disabled_contacts", "reason"),
    ("publisher", "none"),
    ("publisher", "simulation"),
    ("let", "none"),
)

ROBOTS = {path.parent.name: path for path in (ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml")))}

_WORD = re.compile(r"[^\W\d_]+")  # of bl_wheel_2 bl and wheel


class Typo(NamedTuple):
    """Two letters swapped in a file: the ``line`` (from 1), the name that they stand in, before and after."""

    robot: str
    file: str
    line: int
    name: str
    made: str
    text: str

    def __str__(self) -> str:
        return f"{self.robot}/{self.file}:{self.line}: {self.name} -> {self.made}"


class Told(NamedTuple):
    """What is told of a ``typo``: the errors, else the warnings that are new, a line each.

    ``is_right``: the first error stands where the typo is, or one of the warnings. ``exception`` is the traceback of a
    crash.
    """

    typo: str
    said: tuple[str, ...]
    errors: int
    is_right: bool
    exception: str = ""


def typos(robot: str) -> Iterator[Typo]:
    """Yield every typo of a robot, in the order of its files."""
    for file in sorted(ROBOTS[robot].parent.glob("*.yaml")):
        text = file.read_text("utf-8")
        for start, end in words(text):
            # The whole name is told, so that a person sees what has become of it.
            before = re.search(r"[\w/.-]*$", text[:start])[0]
            after = re.match(r"[\w/.-]*", text[end:])[0]
            line = text.count("\n", 0, start) + 1
            for at in range(start, end - 1):
                if text[at] != text[at + 1]:
                    made = text[:at] + text[at + 1] + text[at] + text[at + 2 :]
                    names = (f"{before}{whole[start:end]}{after}" for whole in (text, made))
                    yield Typo(robot, file.name, line, *names, made)


def words(text: str) -> Iterator[tuple[int, int]]:
    """Yield where the words of a YAML text begin and end."""
    for start, end in _scalars(text):
        for word in _WORD.finditer(text, start, end):
            yield word.start(), word.end()


def _scalars(text: str) -> Iterator[tuple[int, int]]:
    """Yield where scalars, anchors and aliases stand; what is text for people is left out."""
    stack: list[tuple[bool, list[str]]] = []  # of each open collection: whether it is a mapping, and the key of a value
    for event in yaml.parse(text, yaml.SafeLoader):
        if isinstance(event, (yaml.SequenceEndEvent, yaml.MappingEndEvent)):
            stack.pop()
            _valued(stack)
        elif isinstance(event, (yaml.SequenceStartEvent, yaml.MappingStartEvent)):
            if event.anchor:
                yield event.start_mark.index, event.start_mark.index + 1 + len(event.anchor)
            stack.append((isinstance(event, yaml.MappingStartEvent), []))
        elif isinstance(event, (yaml.ScalarEvent, yaml.AliasEvent)):
            is_key = bool(stack) and stack[-1][0] and not stack[-1][1]
            if is_key or not _is_free([key for _, keys in stack for key in keys]):
                yield event.start_mark.index, event.end_mark.index
            if is_key:
                stack[-1][1].append(str(event.value))
            else:
                _valued(stack)


def _valued(stack: list[tuple[bool, list[str]]]) -> None:
    if stack:
        stack[-1][1].clear()


def _is_free(keys: list[str]) -> bool:
    last = keys[-1] if keys else ""
    return keys[:1] == ["modes"] or last in FREE or any(last == free and key in keys[:-1] for key, free in FREE_IN)


def tried(robot: str, folder: Path, numbers: Sequence[int]) -> list[Told]:
    """Return what is told of the typos of a robot that have some numbers, each made in a copy in an empty folder."""
    path = folder / "descriptions" / robot / "robot.yaml"
    shutil.copytree(ROBOTS[robot].parent, path.parent)
    usual = {one.message for one in compile_robot(path).diagnostics}
    chosen, every = set(numbers), enumerate(typos(robot))
    return [_told(typo, path, usual) for number, typo in every if number in chosen]


def _told(typo: Typo, path: Path, usual: set[str]) -> Told:
    """Return what is told of the robot at ``path`` with a typo; ``usual`` is what is told without."""
    file = path.parent / typo.file
    before = file.read_text("utf-8")
    file.write_text(typo.text, "utf-8")
    try:
        diagnostics = compile_robot(path).diagnostics
    except Exception:
        return Told(str(typo), (), 0, False, traceback.format_exc())
    finally:
        file.write_text(before, "utf-8")
    errors = [one for one in diagnostics if one.severity == ERROR]
    found = errors or [one for one in diagnostics if one.severity != NOTE and one.message not in usual]
    is_right = any(_is_right(typo, one) for one in (errors[:1] or found))
    return Told(str(typo), tuple(map(str, found)), len(errors), is_right)


def _is_right(typo: Typo, first: Diagnostic) -> bool:
    """Say whether a diagnostic stands in the line of a typo.

    A name that is defined with a typo leaves its uses behind, and nobody can know which of the two was meant: the use
    is right, too, if it offers the name as it is defined and a note leads to the line of the definition.
    """
    here = (typo.file, typo.line)
    offers = first.help.startswith("did you mean")
    return _place(first) == here or (offers and any(_place(note) == here for note in first.related))


def _place(said: Diagnostic | Related) -> tuple[str, int] | None:
    return (Path(said.span.source.path).name, said.span.line) if said.span else None

"""Swap two adjacent letters of a word in the robots of the repository: the typo is reported once, at its place.

A word is part of a key, a name, a value, a unit or an expression; comments and texts for people are left out. Typos
are drawn with a fixed seed: a few of each robot here, more of them in the tier ``fuzz``.
"""

import random
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic, Related
from support.paths import ROOT, ROSORIN

ROBOTS = [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))]
FEW, MANY = 6, 300  # of each robot
SILENT = 0.1  # the share of typos in names that nothing else refers to: file names, topics, names of outputs, ...
MISPLACED = 0.03  # the share that may be reported where the name is used, not where it is defined
REPEATED = 0.01  # the share that may cause more than one error


# Keys whose values are texts for people, anywhere or below another key.
FREE = ("note", "help", "about", "method")
FREE_BELOW = (("accept", "reason"), ("disabled_contacts", "reason"), ("let", "none"))
FREE_BELOW += (("publisher", "none"), ("publisher", "simulation"))


def typos(text: str) -> Iterator[str]:
    """Yield a YAML text with each of its typos."""
    for start, end in words(text):
        for at in range(start, end - 1):
            if text[at] != text[at + 1]:
                yield text[:at] + text[at + 1] + text[at] + text[at + 2 :]


def words(text: str) -> Iterator[tuple[int, int]]:
    """Yield where the words of a YAML text begin and end."""
    root = yaml.compose(text, yaml.SafeLoader)
    for node in _scalars(root, ()) if root is not None else ():
        for word in re.finditer(r"[^\W\d_]+", text[node.start_mark.index : node.end_mark.index]):
            yield node.start_mark.index + word.start(), node.start_mark.index + word.end()


def _scalars(node: yaml.Node, keys: tuple[str, ...]) -> Iterator[yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield key
            yield from _scalars(value, (*keys, str(key.value)))
    elif isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _scalars(item, keys)
    elif not _is_free(keys):
        yield node


def _is_free(keys: tuple[str, ...]) -> bool:
    last = keys[-1] if keys else ""
    return keys[:1] == ("modes",) or last in FREE or any(last == free and key in keys for key, free in FREE_BELOW)


def diagnosed(robot: Path, file: str, line: int, usual: set[str]) -> tuple[list[Diagnostic], bool]:
    """Return the errors of a robot, else its warnings that are not ``usual``, and whether one is right about a typo.

    The first error, or one of the warnings, is in the line of the typo. If a name is defined with a typo, the error may
    also be at its use, if it suggests the name as it is defined and a note leads to the definition.
    """
    diagnostics = compile_robot(robot).diagnostics
    errors = [one for one in diagnostics if one.severity == ERROR]
    found = errors or [one for one in diagnostics if one.severity != NOTE and one.message not in usual]

    def is_there(one: Diagnostic | Related) -> bool:
        return one.span is not None and (Path(one.span.source.path).name, one.span.line) == (file, line)

    return found, any(
        is_there(one) or (one.help.startswith("did you mean") and any(map(is_there, one.related)))
        for one in errors[:1] or found
    )


@pytest.mark.slow
@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.tier("fuzz"))], ids=["few", "many"])
@pytest.mark.parametrize("robot", ROBOTS, ids=lambda path: path.parent.name)
def test_a_typo_is_reported_once_at_its_place(robot: Path, count: int, tmp_path: Path) -> None:
    copy = shutil.copytree(robot.parent, tmp_path / "descriptions" / robot.parent.name)
    usual = {one.message for one in compile_robot(copy / "robot.yaml").diagnostics}
    files = {path: path.read_text("utf-8") for path in sorted(copy.glob("*.yaml"))}
    every = [(path, text) for path in files for text in typos(files[path])]
    silent = misplaced = repeated = 0
    for path, text in random.Random(7).sample(every, count):  # noqa: S311 - no secret
        path.write_text(text, "utf-8")
        pairs = zip(text.splitlines(), files[path].splitlines(), strict=True)
        line = next(number for number, (now, before) in enumerate(pairs, 1) if now != before)
        found, is_right = diagnosed(copy / "robot.yaml", path.name, line, usual)
        path.write_text(files[path], "utf-8")
        silent += not found
        misplaced += bool(found) and not is_right
        repeated += len([one for one in found if one.severity == "error"]) > 1
    assert silent <= max(2, SILENT * count)
    assert misplaced <= max(1, MISPLACED * count)
    assert repeated <= REPEATED * count

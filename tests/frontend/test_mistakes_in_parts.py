"""A misspelt word in a part is told once, at its place, however often the part is used and whether it is mirrored."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import understand
from rosorin_compile.source.diagnostics import ERROR, Diagnostic
from support.paths import data_text

pytestmark = pytest.mark.slow

# A word in <> is a key that only stands there; one in [[ ]] names something of the part, or the frame it sits on.
PART, ROBOT = data_text("robots/mistakes_part.yaml"), data_text("robots/mistakes_robot.yaml")
USES = {
    "once": "  left: {part: arm, parent: base_link}\n",
    "twice": "  left: {part: arm, parent: base_link}\n  right: {part: arm, parent: base_link, xyz: [1, 0, 0]}\n",
    "mirrored": "  left: {part: arm, parent: base_link, xyz: [0, 1, 0]}\n"
    "  right: {part: arm, parent: base_link, xyz: [0, -1, 0], mirror: y}\n",
}
WORD = re.compile(r"<(\w+)>(?=:)|\[\[(\w+)\]\]")


def written(change: int | None = None) -> tuple[str, list[tuple[int, int, str, bool]]]:
    """Return the part without the marks, and its words: line, column, the word, whether it is a key.

    The word of the number ``change`` has two letters swapped.
    """
    words: list[tuple[int, int, str, bool]] = []
    lines = []
    for number, line in enumerate(PART.splitlines(), start=1):
        made, position = "", 0
        for found in WORD.finditer(line):
            made += line[position : found.start()]
            word = found[1] or found[2]
            words.append((number, len(made) + 1, word, found[2] is None))
            made += swapped(word) if len(words) - 1 == change else word
            position = found.end()
        lines.append(made + line[position:])
    return "\n".join(lines) + "\n", words


def swapped(word: str) -> str:
    """Return a word with two letters swapped."""
    places = range(len(word) - 2, -1, -1)
    at = next(at for at in places if word[at] != word[at + 1])
    return word[:at] + word[at + 1] + word[at] + word[at + 2 :]


def errors(folder: Path, uses: str, change: int | None) -> list[Diagnostic]:
    text, _ = written(change)
    (folder / "arm.yaml").write_text(text)
    (folder / "robot.yaml").write_text(ROBOT % uses)
    diagnostics = understand(folder / "robot.yaml").diagnostics
    return [one for one in diagnostics if one.severity == ERROR or one.rule == "unknown-reference"]


def cases() -> Iterator[object]:
    for index, (line, _, word, _) in enumerate(written()[1]):
        for use in USES:
            yield pytest.param(index, use, id=f"{line}-{word}-{index}-{use}")


@pytest.mark.parametrize("use", USES)
def test_the_part_is_sound(tmp_path: Path, use: str) -> None:
    assert errors(tmp_path, USES[use], None) == []


@pytest.mark.parametrize(("index", "use"), list(cases()))
def test_a_misspelt_word_is_told_once(tmp_path: Path, index: int, use: str) -> None:
    line, column, word, is_key = written()[1][index]
    told = errors(tmp_path, USES[use], index)
    assert len(told) == 1, [str(one) for one in told]
    (one,) = told
    assert one.span is not None
    assert (Path(one.span.source.path).name, one.span.line, one.span.column) == ("arm.yaml", line, column), str(one)
    assert f'"{word}"' in one.help, one.help
    assert not is_key or one.rule == "unknown-key"
    if one.message.startswith(("part ", "argument ")):  # found before the part is made
        return
    if not re.search("<spheres>|<joint_properties>", PART.splitlines()[line - 1]):  # one table of the whole robot
        uses = {related for related in one.related if "used here as" in related.message}
        assert len(uses) == len(USES[use].splitlines())

"""What tests of ``compare`` share: the reference robot as it is committed, and copies that differ."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from robots import ROSORIN, compiled, copy_of_rosorin
from rosorin_compile.compare import Comparison, compare, lines
from rosorin_compile.pipeline import Compiled

BASE = compiled()
COMMITTED = {artifact.file: artifact.text.encode() for artifact in BASE.artifacts}


def meaning(comparison: Comparison) -> list[str]:
    """Return the lines that stand before the text differences."""
    said = lines(comparison)
    return said[: said.index("")] if "" in said else said


def against(made: Compiled, committed: Mapping[str, bytes]) -> Comparison:
    assert made.robot is not None
    return compare(made.robot, made.artifacts, committed)


def described(folder: Path, *edits: tuple[str, str, str]) -> Comparison:
    """Compile a copy in which the first text is the second one in the named files; the base is what is committed."""
    first = copy_of_rosorin(folder)
    for name, old, new in edits:
        path = first.parent / name
        text = path.read_text("utf-8")
        assert old in text, f"{old!r} is not in {name}"
        path.write_text(text.replace(old, new), "utf-8")
    return against(compiled(first), COMMITTED)


def edited(name: str, old: str, new: str, count: int = 1) -> Comparison:
    """Edit a committed file by hand; the compiled ones are as before."""
    text = COMMITTED[name].decode()
    assert old in text, f"{old!r} is not in {name}"
    return against(BASE, {**COMMITTED, name: text.replace(old, new, count).encode()})


def block(name: str, key: str) -> str:
    """Return the lines of a key and what is below it, two spaces deep."""
    text = (ROSORIN.parent / name).read_text("utf-8")
    found = re.search(rf"^  {key}:.*\n(?:   .*\n)*", text, re.MULTILINE)
    assert found, f"{key} is not in {name}"
    return found[0]

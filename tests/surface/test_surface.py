"""The public surface is as committed: what changes it changes these files, too, and a person reads the difference."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rosorin_compile.diagnostics.registry import every_rule
from surface import answers, commands, language, python_names

HERE = Path(__file__).parent


def rules() -> Iterator[str]:
    """Yield the id of each rule, with what may be accepted by it and what has to be asked for to hear it."""
    for _, rule in sorted(every_rule().items()):
        more = {"accept": rule.accept, "imported": rule.imported, "asked": rule.asked}
        yield " ".join([rule.id, *(f"{key}={value}" for key, value in more.items() if value)])


MADE: dict[str, Callable[[], Iterator[str]]] = {
    "python": python_names.lines,
    "commands": commands.lines,
    "answers": answers.lines,
    "rules": rules,
    "language": language.lines,
}


def text(name: str) -> str:
    """Return what a file of the surface holds today."""
    return "".join(f"{line}\n" for line in MADE[name]())


@pytest.mark.parametrize("name", MADE)
def test_the_surface_is_as_committed(name: str) -> None:
    committed = (HERE / f"{name}.txt").read_text("utf-8").splitlines()
    moved = [line for line in difflib.ndiff(committed, text(name).splitlines()) if line[0] in "-+"]
    assert moved == [], "python tests/renew.py surface, read the difference, and say it in CHANGELOG.md"


if __name__ == "__main__":
    for each in MADE:
        (HERE / f"{each}.txt").write_text(text(each), "utf-8")

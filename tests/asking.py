"""Asking the command line in tests: what a call prints, and one change in a file of a copy."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.cli import main

Shown = pytest.CaptureFixture[str]


def ask(capsys: Shown, *words: str, code: int = 0) -> str:
    """Return what a call prints; on standard error if it is not fine, and then nothing else."""
    assert main(list(words)) == code
    shown = capsys.readouterr()
    assert not (code and shown.out)
    return shown.out if code == 0 else shown.err


def edit(path: Path, old: str, new: str) -> None:
    """Replace a text that stands once in a file."""
    text = path.read_text("utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), "utf-8")

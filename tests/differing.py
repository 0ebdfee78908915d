"""Helpers of the tests of diff: the arm of data/diff, and what is said about it against a changed copy of itself."""

from __future__ import annotations

import io
import json
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from rosorin_compile.cli import main

DATA = Path(__file__).resolve().parent / "data" / "diff"
ARM = (DATA / "arm.yaml").read_text("utf-8")


def diff(*words: str | Path) -> tuple[int, str, str]:
    """Run diff; return the exit code and what it printed, on standard output and on standard error."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = main(["diff", *map(str, words)])
        except SystemExit as stop:
            code = int(stop.code or 0)
    return code, out.getvalue(), err.getvalue()


def compared(*words: str | Path) -> dict[str, Any]:
    """Return what diff says as JSON; the exit code goes with it."""
    code, out, err = diff(*words, "--json")
    assert out, err
    found: dict[str, Any] = json.loads(out)
    assert code == (0 if found["same"] else 1)
    assert found["same"] == (not found["differences"])
    return found


def told(*words: str | Path) -> list[str]:
    """Return the lines about differences."""
    return [item["text"] for item in compared(*words)["differences"]]


def changed(folder: Path, *changes: tuple[str, str], text: str = ARM) -> Path:
    """Write a copy of the arm in which each first text became the second one; return its file."""
    for old, new in changes:
        assert text.count(old) == 1, (old, text.count(old))
        text = text.replace(old, new)
    path = folder / "changed.yaml"
    path.write_text(text, "utf-8")
    return path

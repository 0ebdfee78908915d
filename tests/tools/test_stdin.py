"""A robot on standard input, called ``-``: read once, seen from the current folder, named <stdin> in what is said."""

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

import rosorin_compile
from support.commands import HANDY

PROJECT = {**HANDY, "arm.yaml": "robot: arm\nlinks: {base: {}}\noutputs: {urdf: {file: arm.urdf}}\n"}


def test_a_program_does_not_read_it(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In Python, "-" is a name like any other: nobody's standard input is taken away."""
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"robot: a\n")))
    monkeypatch.setattr("rosorin_compile.source.project._on_stdin", [])
    assert rosorin_compile.compile("-").robot is None
    assert sys.stdin.read() == "robot: a\n"
    (home / "-").mkdir()
    (home / "-" / "robot.yaml").write_text("robot: dash\nlinks: {base: {}}\n")
    compiled = rosorin_compile.compile("-")
    assert compiled.robot is not None
    assert compiled.robot.name == "dash"


def test_a_terminal_is_told_what_is_waited_for(home: Path) -> None:
    terminal, other_end = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "rosorin_compile", "args", "-"],
        cwd=home, stdin=other_end, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    os.close(other_end)
    assert process.stderr is not None
    assert process.stderr.readline() == "reading a robot from this terminal; Ctrl-D ends it\n"
    os.write(terminal, b"robot: a\n\x04")
    out, err = process.communicate(timeout=60)
    os.close(terminal)
    assert (process.returncode, out, err) == (0, "<stdin> has no arguments\n", "")

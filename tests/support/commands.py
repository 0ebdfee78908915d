"""Asking the command line: what a call prints, and a small project to ask about.

Its robot has parts in loops in parts, a table, a mirror and other nodes: what there is to explain.
"""

import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import click
import pytest

from rosorin_compile.cli.command import Command
from rosorin_compile.cli.main import COMPLETE, PROGRAM, main, program
from rosorin_compile.cli.run import Run
from support.paths import data_text

CALIBRATION = """\
arm:
  left: {length: 120 mm, offset: [1 mm, 2 mm]}
  right: {length: 121 mm, offset: [3 mm, 4 mm]}
"""
PARTS = data_text("robots/commands_parts.yaml")
ROBOT = data_text("robots/commands.yaml")


HANDY = {
    "descriptions/handy/robot.yaml": ROBOT,
    "descriptions/handy/parts.yaml": PARTS,
    "descriptions/handy/calibration.yaml": CALIBRATION,
}


Shown = pytest.CaptureFixture[str]


def of_a_person() -> dict[str, str]:
    """Return the environment of a process at the terminal of a person, who sees what takes long."""
    others = {name: value for name, value in os.environ.items() if name not in ("CI", "ROSORIN_COMPILE_PROGRESS")}
    return {**others, "TERM": "xterm"}


def ask(capsys: Shown, *words: str, code: int = 0) -> str:
    """Return what a call prints; on standard error if it is not fine, and then nothing else."""
    assert main(list(words)) == code
    shown = capsys.readouterr()
    assert not (code and shown.out)
    return shown.out if code == 0 else shown.err


def complete(capsys: Shown, line: str) -> set[str]:
    """Return what a shell offers at the end of a line, without files."""
    *before, current = line.split(" ")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(COMPLETE, "fish_complete")
        patch.setenv("COMP_WORDS", " ".join([PROGRAM, *before]))
        patch.setenv("COMP_CWORD", current)
        assert main([]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    offered = [one.partition(",") for one in shown.out.splitlines() if "," in one]
    return {text.partition("\t")[0] for kind, _, text in offered if kind == "plain"}


def parse(words: Sequence[str]) -> Run:
    """Return the run of a command line."""
    context, command, rest = click.Context(program()), program(), list(words)
    while isinstance(command, click.Group):
        name, found, rest = command.resolve_command(context, rest)
        assert found is not None
        command, context = found, click.Context(found, info_name=name)
    assert isinstance(command, Command)
    return command.start(command.make_context(command.name, rest))


def touch(path: Path) -> None:
    """Give a file the time of now, once that is later than all that was written: it moves in steps."""
    time.sleep(0.02)
    path.touch()


def edit(path: Path, old: str, new: str) -> None:
    """Replace a text that stands once in a file."""
    text = path.read_text("utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), "utf-8")


def write_files(folder: Path, files: Mapping[str, str]) -> None:
    """Write texts into a folder, by name."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")

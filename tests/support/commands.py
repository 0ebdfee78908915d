"""Asking the command line: what a call prints, and a small project to ask about.

Its robot has parts in loops in parts, a table, a mirror and other nodes: what there is to explain.
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import click
import pytest

from rosorin_compile.cli.command import Command, Options
from rosorin_compile.cli.main import COMPLETE, PROGRAM, main, program

CALIBRATION = """\
arm:
  left: {length: 120 mm, offset: [1 mm, 2 mm]}
  right: {length: 121 mm, offset: [3 mm, 4 mm]}
"""
PARTS = """\
parts:
  finger:
    params: {length: {type: length, default: "${2 * base_length}"}, extra: 0}
    let: {tip: "${length + extra}"}
    links: {finger: {inertial: {mass: 20 g, inertia: {ixx: 1e-6, iyy: 1e-6, izz: 1e-6}}}, tip: {}}
    joints:
      joint:
        type: revolute
        parent: mount
        child: finger
        xyz: [0, "${length / 2}", 5 mm]
        axis: [0, 0, 1]
        limit: ${finger_limit}
      tip_joint: {type: fixed, parent: finger, child: tip, xyz: ["${tip}", 0, 0]}
  hand:
    params: {length: {type: length}}
    links: {palm: {}}
    joints:
      wrist: {type: fixed, parent: mount, child: palm, xyz: ["${length}", 0, 0]}
    use:
      "f${i}":
        for: {i: "${range(2)}"}
        part: finger
        parent: palm
        xyz: [0, "${(i - 0.5) * 30 * mm}", 0]
        with: {extra: "${i * mm}"}
      thumb: {part: finger, parent: mount, xyz: [1 mm, 2 mm, 3 mm], mirror: y}
"""
ROBOT = """\
robot: handy
include: [parts.yaml]
args: {scale: {type: number, default: 1}}
let:
  base_length: 10 mm
  cal: ${load("calibration.yaml").arm}
  sides: {left: 1, right: -1}
  finger_limit: {lower: 0, upper: "${upper}", effort: 1, velocity: 1}
  upper: ${45*deg * 2}
links: {base_link: {}, shelf: {collision: [{box: {size: [1 m, "${scale}", 1]}}]}}
joints:
  shelf_joint: {type: fixed, parent: base_link, child: shelf, xyz: "${[0.1, cal.left.length, scale]}"}
use:
  "${side}":
    for: {side: "${sides}"}
    part: hand
    with: {length: "${cal[side].length * scale}"}
    parent: base_link
    xyz: [0.1, "${sides[side] * cal[side].offset[1]}", 0]
sensors:
  eye: {type: camera, parent: shelf, frame: eye_link, xyz: [0, 0, 1 cm]}
publishers: {ekf: {about: fuses}, slam: {}, amcl: {}, driver: {}}
modes: {mapping: }
edges:
  - {parent: odom, child: base_link, publisher: ekf}
  - {parent: map, child: odom, publisher: slam, when: mapping}
  - {parent: map, child: odom, publisher: amcl, when: not mapping}
  - {parent: eye_link, child: chip, publisher: driver, moving: false, xyz: [0, 1 mm, 0]}
  - {parent: chip, child: inner, publisher: driver, moving: false}
poses: {open: {positions: {left_f0_joint: 45 deg}}}
outputs: {urdf: {file: handy.urdf}}
"""


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


def parse(words: Sequence[str]) -> Options:
    """Return the options of a command line."""
    context, command, rest = click.Context(program()), program(), list(words)
    while isinstance(command, click.Group):
        name, found, rest = command.resolve_command(context, rest)
        assert found is not None
        command, context = found, click.Context(found, info_name=name)
    assert isinstance(command, Command)
    return command.options(command.make_context(command.name, rest))


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

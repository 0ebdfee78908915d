"""Processor time of ``rosorin-compile`` on the reference robot, as ratios to xacro.

User and system time of whole processes, in pairs. ``all`` writes and proves 16 artifacts after one number was changed;
xacro makes one URDF and checks nothing. ``rosorin_wheels.xacro`` has the wheels with their rollers (51 of 60 links),
``rosorin.xacro`` does without (11 links). The last row is the lower bound: a script that loads the same description and
formats the numbers of the same 16 files, and does nothing else. Goals hold without MuJoCo; where it is installed, it
loads the result, and the goals of ``all``, ``check`` and ``print`` are higher by 1.7. Run with the environment's
Python: ``python benchmarks/compile_rosorin.py [PAIRS]``.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from pairs import compare, row, used

HERE = Path(__file__).resolve().parent
BIN = Path(sys.executable).parent
PLAIN, WHEELS = "rosorin.xacro", "rosorin_wheels.xacro"
COMPILE, CHECK, PRINT = "all", "check", "print rosorin urdf"
CONVERT = "print outputs/rosorin/rosorin_sim.urdf mjcf"  # the URDF with a mass for each link, which MuJoCo needs
WITH_MUJOCO = 1.7  # more, where MuJoCo loads the result
ROWS = (  # a command, the xacro file that it is compared with, the goal
    (COMPILE, WHEELS, 2.5),
    (COMPILE, PLAIN, 4.0),
    (CHECK, WHEELS, 3.2),
    (PRINT, WHEELS, 2.5),
    (CONVERT, WHEELS, 2.4),
    ("--help", WHEELS, 0.6),
    ("--version", WHEELS, 0.6),
)


def main(pairs: int) -> None:
    """Print the table."""
    more = WITH_MUJOCO if find_spec("mujoco") else 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(HERE.parent / "descriptions" / "rosorin", folder / "descriptions" / "rosorin")
        os.chdir(folder)
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # what is installed is compiled
        print(f"{'command / xacro':<42} {'ours':>11} {'xacro':>11}   ratio, median of {pairs} pairs")
        for command, peer, goal in ROWS:
            ours = [str(BIN / "rosorin-compile"), *command.split()]
            if command in (CHECK, CONVERT):
                used([ours[0], COMPILE])
            prepare = partial(_change, folder) if command == COMPILE else None
            ratio = compare(lambda: used(ours, prepare).seconds, partial(_xacro, folder, peer), pairs)  # noqa: B023
            print(row(f"{command} / {peer}", ratio, goal + (0 if command.startswith("-") else more)))
        bound = [sys.executable, str(HERE / "lower_bound.py"), "descriptions/rosorin"]
        used([*bound, "outputs/rosorin"])  # makes templates and numbers of what we wrote
        ratio = compare(lambda: used(bound).seconds, partial(_xacro, folder, WHEELS), pairs)
        print(row(f"lower bound / {WHEELS}", ratio))


def _xacro(folder: Path, peer: str) -> float:
    return used([str(BIN / "xacro"), str(HERE / peer), "-o", str(folder / "theirs.urdf")]).seconds


def _change(folder: Path) -> None:
    """Move the lidar by a micrometre, there and back."""
    path = folder / "descriptions" / "rosorin" / "lidar_and_imu.yaml"
    text = path.read_text("utf-8")
    old, new = ("0.048156", "0.048157") if "0.048156" in text else ("0.048157", "0.048156")
    path.write_text(text.replace(old, new), "utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 15)

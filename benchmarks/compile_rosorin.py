"""How long ``rosorin-compile`` takes on the reference robot, against xacro.

Processor time of whole processes, user and system together, in pairs. ``all`` writes and proves all 16 artifacts,
``print ROBOT urdf`` proves one and prints it, as a launch file has it done; xacro makes one file and checks nothing.
``rosorin.xacro`` has the robot of ``rosorin.urdf`` (11 links), ``rosorin_wheels.xacro`` stands it on its wheels (51 of
60 links): ``all`` is held against the second, ``print`` against the first. Run with the environment's Python:
``python benchmarks/compile_rosorin.py [PAIRS]``.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from pairs import compare, row, used

HERE = Path(__file__).resolve().parent
BIN = Path(sys.executable).parent
CHANGED, UNCHANGED = 3.0, 0.3  # goals
PLAIN, WHEELS = "rosorin.xacro", "rosorin_wheels.xacro"


def main(pairs: int) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(HERE.parent / "descriptions" / "rosorin", folder / "descriptions" / "rosorin")
        os.chdir(folder)
        os.environ["ROSORIN_COMPILE_CACHE"] = str(folder / "cache")
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # what is installed is compiled
        print(f"{'rosorin-compile / xacro':<42} {'ours':>11} {'xacro':>11}   ratio, median of {pairs} pairs")
        for words, peer in ((["all"], WHEELS), (["print", "rosorin", "urdf"], PLAIN)):
            theirs = [str(BIN / "xacro"), str(HERE / peer), "-o", str(folder / "theirs.urdf")]
            for case, prepare, goal in (
                ("nothing cached", partial(_forget, folder), None),
                ("one number changed", partial(_change, folder), CHANGED),
                ("nothing changed", None, UNCHANGED),
            ):
                ours = partial(_seconds, [str(BIN / "rosorin-compile"), *words], prepare)
                ratio = compare(ours, partial(_seconds, theirs), pairs)
                print(row(f"{' '.join(words[:2])}, {case}", ratio, goal if words == ["all"] else None))


def _seconds(command: list[str], prepare: Callable[[], None] | None = None) -> float:
    return used(command, prepare).seconds


def _forget(folder: Path) -> None:
    """Remove the outputs and all that the tool may have cached."""
    shutil.rmtree(folder / "cache", ignore_errors=True)
    shutil.rmtree(folder / "outputs", ignore_errors=True)


def _change(folder: Path) -> None:
    """Move the lidar by a micrometre, there and back."""
    path = folder / "descriptions" / "rosorin" / "lidar_and_imu.yaml"
    text = path.read_text("utf-8")
    old, new = ("0.048156", "0.048157") if "0.048156" in text else ("0.048157", "0.048156")
    path.write_text(text.replace(old, new), "utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 15)

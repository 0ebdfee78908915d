"""How long ``rosorin-compile`` takes on the reference robot, against xacro.

Whole processes in pairs. ``all`` writes and proves all 16 artifacts, ``print urdf`` proves one and prints it, as a
launch file has it done; xacro makes one file and checks nothing. ``rosorin.xacro`` has the robot of ``rosorin.urdf``
(11 links), ``rosorin_wheels.xacro`` stands it on its wheels (51 of 60 links). ``all`` is held against the second alone,
and against a xacro for each XML file that xacro could make: three URDFs and an SRDF, of which one has the wheels. Run
with the environment's Python: ``python benchmarks/compile_rosorin.py [PAIRS]``.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from functools import partial
from pathlib import Path

from pairs import compare, row, wall_time

HERE = Path(__file__).resolve().parent
BIN = Path(sys.executable).parent
COLD, CHANGED, UNCHANGED, PRINT = 1.3, 1.0, 0.3, 1.0  # goals
PLAIN, WHEELS = "rosorin.xacro", "rosorin_wheels.xacro"
PEERS = {"one robot": [WHEELS], "4 files": [WHEELS, PLAIN, PLAIN, PLAIN]}


def main(pairs: int) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(HERE.parent / "descriptions" / "rosorin", folder / "descriptions" / "rosorin")
        os.chdir(folder)
        os.environ["ROSORIN_COMPILE_CACHE"] = str(folder / "cache")
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # what is installed is compiled
        ours = [str(BIN / "rosorin-compile"), "all"]
        printing = [str(BIN / "rosorin-compile"), "print", "urdf", "rosorin"]

        def xacro(files: list[str]) -> float:
            made = ["-o", str(folder / "theirs.urdf")]
            return sum(wall_time([str(BIN / "xacro"), str(HERE / file), *made]) for file in files)

        print(f"{'rosorin-compile / xacro':<42} {'ours':>11} {'xacro':>11}   ratio, median of {pairs} pairs")
        forget, change = partial(_forget, folder), partial(_change, folder)
        for case, prepare, goal in (
            ("nothing cached", forget, COLD),
            ("one number changed", change, CHANGED),
            ("nothing changed", None, UNCHANGED),
        ):
            run = partial(wall_time, ours, prepare)
            for peer, files in PEERS.items():
                print(row(f"all, {case}, / {peer}", compare(run, partial(xacro, files), pairs), goal))
        for case, prepare in (("nothing cached", forget), ("one number changed", change), ("nothing changed", None)):
            ratio = compare(partial(wall_time, printing, prepare), partial(xacro, [PLAIN]), pairs)
            print(row(f"print urdf, {case}", ratio, PRINT))


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

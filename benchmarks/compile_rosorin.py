"""How long ``rosorin-compile`` takes on the reference robot, against xacro on the same robot.

Whole processes in pairs. ``all`` writes and validates all artifacts, ``print urdf`` validates one and prints it, as a
launch file has it done; xacro expands ``rosorin.xacro`` to the same URDF and checks nothing. Run with the environment's
Python: ``python benchmarks/compile_rosorin.py [PAIRS]``.
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


def main(pairs: int) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(HERE.parent / "descriptions" / "rosorin", folder / "descriptions" / "rosorin")
        os.chdir(folder)
        os.environ["ROSORIN_COMPILE_CACHE"] = str(folder / "cache")
        ours = [str(BIN / "rosorin-compile"), "all"]
        printing = [str(BIN / "rosorin-compile"), "print", "urdf", "rosorin"]
        theirs = [str(BIN / "xacro"), str(HERE / "rosorin.xacro"), "-o", str(folder / "rosorin.urdf")]

        def xacro() -> float:
            return wall_time(theirs)

        def xacro_to_stdout() -> float:
            return wall_time(theirs[:2])

        print(f"{'rosorin-compile all / xacro':<42} {'ours':>11} {'xacro':>11}   ratio, median of {pairs} pairs")
        for case, prepare, goal in (
            ("nothing cached", partial(_forget, folder), 2.0),
            ("one number changed", partial(_change, folder), 2.0),
            ("nothing changed", None, 0.8),
        ):
            print(row(case, compare(partial(wall_time, ours, prepare), xacro, pairs), goal))
        for case, prepare in (("print urdf, nothing cached", partial(_forget, folder)), ("print urdf", None)):
            print(row(case, compare(partial(wall_time, printing, prepare), xacro_to_stdout, pairs), 2.0))


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

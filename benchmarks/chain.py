"""How the time grows with the robot: a chain of N parts, against xacro on the same chain.

Whole processes in pairs: wall time, and processor time on one core. A part is a link with inertia and a box, a revolute
joint, and seven or more expressions. ``rosorin-compile`` validates, writes and proves six artifacts; xacro writes the
URDF. It is measured twice: with the chain as a loop, as one would write it, and with N entries written out, as xacro
needs it.

Run with the environment's Python: ``python benchmarks/chain.py [PAIRS] [N ...]``.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

from pairs import Ratio, compare, row, used, wall_time

HERE = Path(__file__).resolve().parent
BIN = Path(sys.executable).parent
GOAL = 0.05


def main(pairs: int, sizes: list[int]) -> None:
    """Print a table with a row a size, and the time a link."""
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        os.environ["ROSORIN_COMPILE_CACHE"] = str(Path(name, "cache"))
        print(f"{'rosorin-compile all / xacro':<42} {'ours':>11} {'xacro':>11}   ratio, median of {pairs} pairs")
        for form in ("a loop", "written out"):
            per_link = {n: _measure(form, n, pairs).first / n for n in sizes}
            told = ", ".join(f"{seconds * 1e6:.0f} us at {n}" for n, seconds in per_link.items())
            print(f"    time a link: {told}")


def _measure(form: str, n: int, pairs: int) -> Ratio:
    write(n)
    ours = [str(BIN / "rosorin-compile"), "all", "loop.yaml", "-a", f"n={n}"]
    if form == "written out":
        ours = [str(BIN / "rosorin-compile"), "all", "written.yaml"]
    theirs = [str(BIN / "xacro"), "chain.xacro", "-o", "xacro.urdf"]
    warm_up = 1 if n < 1000 else 0
    ratio = compare(lambda: wall_time(ours, forget), lambda: wall_time(theirs), pairs, warm_up)
    print(row(f"{n} links, {form}", ratio, GOAL))
    work = compare(lambda: used(ours, forget).seconds, lambda: used(theirs).seconds, pairs, warm_up)
    print(row(f"{n} links, {form}, processor time", work, GOAL))
    return ratio


def write(n: int) -> None:
    """Write the chain in each form: as a loop, written out, and as xacro."""
    loop = (HERE / "segment.yaml").read_text("utf-8")
    Path("loop.yaml").write_text(loop, "utf-8")
    head, rest = loop.split("use:\n")
    outputs = rest[rest.index("outputs:") :]
    parents = ["base_link", *(f"s{i}_link" for i in range(n))]
    uses = [
        f"  s{i}:\n    part: segment\n    parent: {parents[i]}\n    xyz: [0, 0, {0 if i == 0 else '100 mm'}]\n"
        for i in range(n)
    ]
    Path("written.yaml").write_text(f"{head}use:\n{''.join(uses)}{outputs}", "utf-8")
    calls = [f'  <xacro:segment name="s{i}" parent="{parents[i]}" z="{0 if i == 0 else 0.1}"/>\n' for i in range(n)]
    macro = (HERE / "segment.xacro").read_text("utf-8").replace("</robot>", "".join(calls) + "</robot>")
    Path("chain.xacro").write_text(macro, "utf-8")


def forget() -> None:
    shutil.rmtree("outputs", ignore_errors=True)


if __name__ == "__main__":
    words = [int(word) for word in sys.argv[1:]]
    main(words[0] if words else 3, words[1:] or [100, 500, 1000, 5000])

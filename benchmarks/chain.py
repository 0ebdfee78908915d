"""How the time grows with the robot: a chain of N parts, against xacro on the same chain.

Processor time of whole processes, user and system together, in pairs. A part is a link with inertia and a box, a
revolute joint, and seven or more expressions. ``rosorin-compile`` validates, writes and proves six artifacts; xacro
writes the URDF. It is measured three times: with the chain as a loop, as one would write it; with N equal entries
written out, as xacro needs it; and with N entries that all differ in length and radius. Below each stands the time of a
part, without what a chain of one part takes, and how that of the largest chain compares with that of the smallest.

Run with the environment's Python: ``python benchmarks/chain.py [PAIRS] [N ...]``.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from pairs import compare, row, used

HERE = Path(__file__).resolve().parent
BIN = Path(sys.executable).parent
GOAL = 0.2
LINEAR = 0.15  # by so much the time of a part may differ between the smallest and the largest chain
LOOP, EQUAL, DIFFERENT = "a loop", "all equal", "all different"


def main(pairs: int, sizes: list[int]) -> None:
    """Print a table with a row a size, and the time a part."""
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        os.environ["ROSORIN_COMPILE_CACHE"] = str(Path(name, "cache"))
        print(f"{'rosorin-compile all / xacro':<42} {'ours':>11} {'xacro':>11}   ratio, median of {pairs} pairs")
        for form in (LOOP, EQUAL, DIFFERENT):
            write(1)
            alone = min(used(ours(form, 1), forget).seconds for _ in range(3))
            per_part = {n: (_measure(form, n, pairs) - alone) / n for n in sizes}
            told = ", ".join(f"{seconds * 1e6:.0f} us at {n}" for n, seconds in per_part.items())
            grown = per_part[max(sizes)] / per_part[min(sizes)]
            print(f"    time a part: {told}; {grown:.2f} times   goal {1 - LINEAR:g} to {1 + LINEAR:g}")


def _measure(form: str, n: int, pairs: int) -> float:
    write(n)
    theirs = [str(BIN / "xacro"), "different.xacro" if form == DIFFERENT else "equal.xacro", "-o", "xacro.urdf"]
    ratio = compare(
        lambda: used(ours(form, n), forget).seconds, lambda: used(theirs).seconds, pairs, 1 if n < 1000 else 0
    )
    print(row(f"{n} parts, {form}", ratio, GOAL))
    return ratio.first


def ours(form: str, n: int) -> list[str]:
    """Return the command that compiles a chain of n parts in one of its forms."""
    words = {LOOP: ["loop.yaml", "-a", f"n={n}"], EQUAL: ["equal.yaml"], DIFFERENT: ["different.yaml"]}
    return [str(BIN / "rosorin-compile"), "all", *words[form]]


def write(n: int) -> None:
    """Write the chain in each form: as a loop, written out with equal parts and with different ones; and as xacro."""
    loop = (HERE / "segment.yaml").read_text("utf-8")
    Path("loop.yaml").write_text(loop, "utf-8")
    head, rest = loop.split("use:\n")
    outputs = rest[rest.index("outputs:") :]
    macro = (HERE / "segment.xacro").read_text("utf-8")
    for form, parts in (("equal", [(0.1, 0.02)] * n), ("different", list(_sizes(n)))):
        uses, calls, parent, z = [], [], "base_link", 0.0
        for i, (length, radius) in enumerate(parts):
            same = form == "equal"
            given = "" if same else f"    with: {{length: {length}, radius: {radius}}}\n"
            uses.append(f"  s{i}:\n    part: segment\n    parent: {parent}\n    xyz: [0, 0, {z}]\n{given}")
            given = "" if same else f' length="{length}" radius="{radius}"'
            calls.append(f'  <xacro:segment name="s{i}" parent="{parent}" z="{z}"{given}/>\n')
            parent, z = f"s{i}_link", length
        Path(f"{form}.yaml").write_text(f"{head}use:\n{''.join(uses)}{outputs}", "utf-8")
        Path(f"{form}.xacro").write_text(macro.replace("</robot>", "".join(calls) + "</robot>"), "utf-8")


def _sizes(n: int) -> Iterator[tuple[float, float]]:
    """Yield the lengths and radii (m) of n parts; no two have the same of either."""
    for i in range(n):
        yield round(0.1 + i * 1e-5, 6), round(0.02 + i * 1e-6, 6)


def forget() -> None:
    shutil.rmtree("outputs", ignore_errors=True)


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    main(numbers[0] if numbers else 3, numbers[1:] or [1000, 5000, 10_000])

"""How much memory ``rosorin-compile all`` takes at most: on the reference robot, and on chains of N parts.

Of a chain that is held against the size of its artifacts, so that it means the same on every machine; the chain is in
each of the forms of ``chain.py``. Run with the environment's Python:
``python benchmarks/memory.py [N ...]``.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

from chain import BIN, DIFFERENT, EQUAL, HERE, LOOP, forget, ours, write
from pairs import used

MIB = 2**20
MOST = 40.0  # MiB, of the reference robot
TIMES = 10.0  # of the size of the artifacts, of a chain
ALL = [str(BIN / "rosorin-compile"), "all"]


def main(sizes: list[int]) -> None:
    """Print a row for the reference robot, and three for each size of a chain."""
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        os.environ["ROSORIN_COMPILE_CACHE"] = str(Path(name, "cache"))
        shutil.copytree(HERE.parent / "descriptions" / "rosorin", Path("descriptions", "rosorin"))
        used(ALL)  # templates are compiled for all later runs
        memory = used(ALL, forget).memory
        print(f"{'the reference robot':<28} {memory:7.1f} MiB   goal {MOST:g} MiB")
        for n in sizes:
            write(n)
            for form in (LOOP, EQUAL, DIFFERENT):
                memory = used(ours(form, n), forget).memory
                size = sum(file.stat().st_size for file in Path("outputs").rglob("*") if file.is_file()) / MIB
                row = (
                    f"{f'{n} parts, {form}':<28} {memory:7.1f} MiB   {memory / size:5.1f} x {size:.1f} MiB of artifacts"
                )
                print(f"{row}   goal {TIMES:g}")


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [5000, 20_000])

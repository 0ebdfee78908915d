"""Import of every SRDF in folders of packages, each beside the URDF of its package that knows most of its names.

A file is *kept* where nothing of it is left out, *listed* where the import said what, *refused* with a reason. What is
kept or listed is compiled, and pinocchio reads both SRDFs: the same pairs of links are to be left out, and the same
states.

Get the packages with pip (``pip download --no-deps``), unpack them, and run it on the folder that holds them. For
example: example-robot-data, hpp-environments, compas-fab, mani-skill, dexmate-urdf, pyroboplan, guided-tamp-benchmark.

Run with the environment's Python: ``python benchmarks/srdf_corpus.py FOLDER [--out FILE]``.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import re
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import coal
import pinocchio

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.robot_files import join, read_robot
from rosorin_compile.importing.description import write
from rosorin_compile.importing.round_trip import check_round_trip
from rosorin_compile.source.diagnostics import ERROR
from rosorin_compile.source.project import ROOT_FILE

NICE = 10
BALL = coal.Sphere(0.01)  # stands for the shape of each link: the names decide
MOST = 12  # URDFs of a package that are looked at
_NAMES = re.compile(r'(?:link[12]|base_link|tip_link|parent_link|child_link)="([^"]+)"|<(?:joint|link) name="([^"]+)"')


def main() -> None:
    """Print a line a file, and the counts."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, default=Path("srdf_corpus.jsonl"))
    options = parser.parse_args()
    os.nice(NICE)
    rows = [judged(file, options.folder) for file in sorted(options.folder.rglob("*.srdf"))]
    options.out.write_text("".join(f"{json.dumps(row)}\n" for row in rows), "utf-8")
    for row in rows:
        print(f"{row['end']}\t{row['file']}\t{row['why']}")
    print(dict(Counter(row["end"] for row in rows)), dict(Counter(row["pinocchio"] for row in rows)))


def judged(file: Path, folder: Path) -> dict[str, str]:
    """Return what became of a file: a row."""
    row = {"file": str(file.relative_to(folder)), "end": "no URDF", "why": "", "pinocchio": ""}
    urdf = robot_of(file, folder / file.relative_to(folder).parts[0])
    if urdf is None:
        return row
    read = read_robot(urdf, ReadOptions(lenient=True))
    before = len(read.diagnostics)
    made = join(read, "srdf", file, ReadOptions())
    said = made.diagnostics[before:]
    if made.tree is None:
        return row | {"end": "refused", "why": next(one.message for one in said if one.severity == ERROR)}
    trip = check_round_trip(made, file.parent)
    if trip.diagnostics:
        return row | {"end": "differs", "why": trip.diagnostics[0].message}
    left = [one.message for one in said if one.rule == "import-cannot-carry"]
    return row | {"end": "listed" if left else "kept", "why": "; ".join(left), "pinocchio": compared(urdf, file, made)}


def robot_of(file: Path, package: Path) -> Path | None:
    """Return the URDF of a package that has most of the names of an SRDF."""
    names = {one or other for one, other in _NAMES.findall(file.read_text("utf-8", "replace"))}

    def likeness(urdf: Path) -> tuple[bool, int, str]:
        return urdf.stem != file.stem, -len(Path(os.path.commonpath([urdf, file])).parts), str(urdf)

    near = sorted(package.rglob("*.urdf"), key=likeness)[:MOST]
    known = {urdf: urdf.read_text("utf-8", "replace") for urdf in near}
    return max(near, key=lambda urdf: sum(f'"{name}"' in known[urdf] for name in names), default=None)


def compared(urdf: Path, file: Path, made: Imported) -> str:
    """Return whether pinocchio takes the compiled SRDF as it takes the source."""
    with tempfile.TemporaryDirectory() as name:
        for text_name, text in write(made, made.outputs("not asked")).items():
            (Path(name) / text_name).write_text(text, "utf-8")
        compiled = compile_robot(Path(name) / ROOT_FILE)
        again = Path(name) / "again.srdf"
        texts = [one.text for one in compiled.artifacts if one.backend == "srdf"]
        if not texts:
            return "not compiled"
        again.write_text(texts[0], "utf-8")
        try:
            one, other = understood(urdf, file), understood(urdf, again)
        except (RuntimeError, ValueError) as problem:
            return f"not read: {str(problem).splitlines()[0][:60]}"
    return "same" if one == other else "pairs differ" if one[0] != other[0] else "states differ"


def understood(urdf: Path, srdf: Path) -> tuple[set[frozenset[str]], dict[str, Any]]:
    """Return the pairs of shapes that pinocchio would check, and the states of groups."""
    model = pinocchio.buildModelFromUrdf(str(urdf))
    shapes = pinocchio.GeometryModel()
    for link in model.frames:
        if link.type == pinocchio.FrameType.BODY:
            place = pinocchio.SE3.Identity()
            ball = pinocchio.GeometryObject(
                f"{link.name}_0", link.parentJoint, model.getFrameId(link.name), place, BALL
            )
            shapes.addGeometryObject(ball)
    shapes.addAllCollisionPairs()
    with contextlib.redirect_stdout(io.StringIO()):
        pinocchio.removeCollisionPairs(model, shapes, str(srdf))
        pinocchio.loadReferenceConfigurations(model, str(srdf))
    names = [one.name for one in shapes.geometryObjects]
    pairs = {frozenset((names[pair.first], names[pair.second])) for pair in shapes.collisionPairs}
    known = model.referenceConfigurations
    return pairs, {one.key(): one.data().tolist() for one in known}


if __name__ == "__main__":
    main()

"""Compiles robots, in a process that finds the sections of ``words``, and prints what became of each as JSON.

    python asking.py FOLDER

Each file of the folder is a robot; ``other`` in its name makes it one that ``robot.yaml`` is compared with.
"""

import json
import pickle
import sys
from pathlib import Path

import rosorin_compile
from rosorin_compile.model import Robot


def said(robot: Robot) -> object:
    """Return what a robot says in its sections, after a way through a pickle, as to a worker."""
    return pickle.loads(pickle.dumps(robot)).sections.said  # noqa: S301 - our own


def main(folder: Path) -> None:
    """Print what became of each robot of a folder."""
    found = {}
    for path in sorted(folder.glob("*.yaml")):
        compiled = rosorin_compile.compile(path)
        found[path.stem] = {
            "said": None if compiled.robot is None else said(compiled.robot),
            "told": [[one.rule, one.message, one.help, one.span and one.span.line] for one in compiled.diagnostics],
            "texts": {artifact.output: artifact.text for artifact in compiled.artifacts},
        }
        if "other" in path.stem:
            difference = rosorin_compile.diff(folder / "robot.yaml", path)
            found[path.stem]["differences"] = [item.text for item in difference.items]
    print(json.dumps({"robots": found, "schema": rosorin_compile.schema()}))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""The reference robot and copies of it, for tests."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path

from rosorin_compile.pipeline import Compiled, compile_robot
from rosorin_compile.report import text

ROOT = Path(__file__).resolve().parent.parent
ROSORIN = ROOT / "descriptions" / "rosorin" / "robot.yaml"
OUTPUTS = ROOT / "outputs" / "rosorin"
RECORDED = json.loads((ROOT / "tests" / "data" / "recorded_checks.json").read_text("utf-8"))


def copy_of_rosorin(folder: Path, changes: Mapping[str, tuple[str, str]] | None = None) -> Path:
    """Copy the reference description into ``folder``; in each named file replace the first text by the second.

    Returns the first file of the copy.
    """
    copy = folder / "descriptions" / "rosorin"
    shutil.copytree(ROSORIN.parent, copy, dirs_exist_ok=True)
    for name, (old, new) in (changes or {}).items():
        path = copy / name
        before = path.read_text("utf-8")
        assert before.count(old) == 1, f"{old!r} stands {before.count(old)} times in {name}"
        path.write_text(before.replace(old, new), "utf-8")
    return copy / "robot.yaml"


def compiled(path: Path = ROSORIN, arguments: Mapping[str, str] | None = None) -> Compiled:
    """Compile a description that has to be free of errors."""
    made = compile_robot(path, arguments or {})
    assert made.robot is not None, text(made.diagnostics)
    assert made.artifacts, text(made.diagnostics)
    return made


def texts(made: Compiled) -> dict[str, str]:
    """Return the artifacts of a compilation by file name."""
    return {artifact.file: artifact.text for artifact in made.artifacts}

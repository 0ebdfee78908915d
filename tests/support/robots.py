"""The reference robot and copies of it, for tests."""

import json
import shutil
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.language.lower import lower
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Robot
from rosorin_compile.rules.check import check
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Source, has_errors
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.load import parse_yaml
from rosorin_compile.source.messages import arrange
from support.paths import DATA, ROSORIN, data_text

RECORDED = json.loads((DATA / "recorded_checks.json").read_text("utf-8"))


# What programs that move the reference robot know of it: controllers, planning, navigation.
MOVING = ("control.yaml", "collisions.yaml")


def copy_of_rosorin(folder: Path, changes: Mapping[str, tuple[str, str]] | None = None, *, whole: bool = False) -> Path:
    """Copy the reference description into ``folder``; in each named file replace the first text by the second.

    Only a ``whole`` copy has the files of ``MOVING``, whose artifacts say most of what those of the others say again.
    Returns the first file of the copy.
    """
    copy = folder / "descriptions" / "rosorin"
    shutil.copytree(ROSORIN.parent, copy, dirs_exist_ok=True)
    if not whole:
        first = copy / "robot.yaml"
        text = first.read_text("utf-8")
        for name in MOVING:
            (copy / name).unlink()
            text = text.replace(f"  - {name}\n", "")
        first.write_text(text, "utf-8")
    for name, (old, new) in (changes or {}).items():
        path = copy / name
        before = path.read_text("utf-8")
        assert before.count(old) == 1, f"{old!r} stands {before.count(old)} times in {name}"
        path.write_text(before.replace(old, new), "utf-8")
    return copy / "robot.yaml"


def compiled(
    path: Path = ROSORIN, arguments: Mapping[str, str] | None = None, by: Callable[..., CompileResult] = compile_robot
) -> CompileResult:
    """Compile a description that has to be free of errors."""
    made = by(path, arguments or {})
    assert made.robot is not None, report(made.diagnostics)
    assert made.artifacts, report(made.diagnostics)
    return made


@cache
def of_this_project(path: Path) -> CompileResult:
    """Compile a description of this project, once in a process: for tests that ask only what comes out."""
    assert path.is_absolute()
    return compiled(path)


# Links that are alike, and joints that are; outputs are to be added.
CHAIN = data_text("robots/robots_chain.yaml")


def compiled_text(folder: Path, text: str) -> CompileResult:
    """Compile a description that is given as text, whether it has errors or not."""
    path = folder / "robot.yaml"
    path.write_text(text, "utf-8")
    return compile_robot(path)


def sound(made: CompileResult) -> tuple[Robot, dict[str, str], CompileResult]:
    """Return a robot without errors, its artifacts by backend, which agree with it, and all that came out."""
    assert not has_errors(made.diagnostics), report(made.diagnostics)
    assert made.robot is not None
    assert agreement(made.robot, made.artifacts) == []
    return made.robot, {artifact.backend: artifact.text for artifact in made.artifacts}, made


def texts(made: CompileResult) -> dict[str, str]:
    """Return the artifacts of a compilation by file name."""
    return {artifact.file: artifact.text for artifact in made.artifacts}


# What the rules say of a description that is made in Python.


def found(description: dict[str, Any]) -> list[Diagnostic]:
    """Return what the rules say of a description of the right shape."""
    tree = parse_yaml(Source("robot.yaml", yaml.safe_dump(description, sort_keys=False)))
    assert not has_errors(validate(tree, FORMATS)), arrange(validate(tree, FORMATS))
    lowered = lower(tree)
    assert lowered.robot is not None, lowered.diagnostics
    return check(lowered.robot, tree, lowered.places, FORMATS)


def rules(description: dict[str, Any]) -> list[str]:
    return sorted(d.rule for d in found(description) if d.severity != NOTE)


def robot(joints: dict[str, Any], **more: Any) -> dict[str, Any]:
    names = {joint[end] for joint in joints.values() for end in ("parent", "child")}
    return {"robot": "made", "links": {name: {} for name in sorted(names)}, "joints": joints, **more}

"""Helpers of the tests of diff: the arm of data/diff, and what is said about it against a changed copy of itself."""

import io
import json
from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rosorin_compile.cli.main import main
from rosorin_compile.compare.golden_check import Comparison, compare, lines
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compilation import CompileResult
from rosorin_compile.formats.format import lacks
from rosorin_compile.importing.round_trip import model_differences
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Ellipsoid, Robot, Shape
from rosorin_compile.model.joint import ROBOT_STATE_PUBLISHER, Dynamics, Publisher
from rosorin_compile.model.link import Link
from rosorin_compile.model.shape import plain
from support.paths import DATA
from support.robots import compiled, copy_of_rosorin

DIFF = DATA / "diff"
ARM = (DIFF / "arm.yaml").read_text("utf-8")


def diff(*words: str | Path) -> tuple[int, str, str]:
    """Run diff; return the exit code and what it printed, on standard output and on standard error."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main(["diff", *map(str, words)])
    return code, out.getvalue(), err.getvalue()


def compared(*words: str | Path) -> dict[str, Any]:
    """Return what diff says as JSON; the exit code goes with it."""
    code, out, err = diff(*words, "--format", "json")
    assert out, err
    found: dict[str, Any] = json.loads(out)["result"]
    assert code == (0 if found["same"] else 1)
    assert found["same"] == (not found["differences"])
    return found


def told(*words: str | Path) -> list[str]:
    """Return the lines about differences."""
    return [item["text"] for item in compared(*words)["differences"]]


def changed(folder: Path, *changes: tuple[str, str], text: str = ARM) -> Path:
    """Write a copy of the arm in which each first text became the second one; return its file."""
    for old, new in changes:
        assert text.count(old) == 1, (old, text.count(old))
        text = text.replace(old, new)
    path = folder / "changed.yaml"
    path.write_text(text, "utf-8")
    return path


# What tests of golden comparison share: the reference robot, and copies that differ.


with TemporaryDirectory() as _folder:
    BASE = compiled(copy_of_rosorin(Path(_folder)))
COMMITTED = {artifact.file: artifact.text.encode() for artifact in BASE.artifacts}


def meaning(comparison: Comparison) -> list[str]:
    """Return the lines before the text differences."""
    said = lines(comparison)
    return said[: said.index("")] if "" in said else said


def against(made: CompileResult, committed: Mapping[str, bytes]) -> Comparison:
    assert made.robot is not None
    return compare(made.robot, made.artifacts, committed)


def described(folder: Path, *edits: tuple[str, str, str]) -> Comparison:
    """Compile a copy in which the first text is the second one in the named files; the base is what is committed."""
    first = copy_of_rosorin(folder)
    for name, old, new in edits:
        path = first.parent / name
        text = path.read_text("utf-8")
        assert old in text, f"{old!r} is not in {name}"
        path.write_text(text.replace(old, new), "utf-8")
    return against(compiled(first), COMMITTED)


def edited(name: str, old: str, new: str, count: int = 1) -> Comparison:
    """Edit a committed file by hand; the compiled ones are as before."""
    text = COMMITTED[name].decode()
    assert old in text, f"{old!r} is not in {name}"
    return against(BASE, {**COMMITTED, name: text.replace(old, new, count).encode()})


def different(one: Robot, other: Robot, tolerance: float) -> list[str]:
    """Return in which values two robots differ, to a proof."""
    return model_differences(one, other, tolerance)


def as_in_urdf(one: Robot, other: Robot) -> tuple[Robot, Robot]:
    """Reduce two robots to the values that a URDF can express."""
    known = {field.name for field in fields(one)}
    skipped = [name for name in sections() if name in known and lacks(FORMATS.published_format(), name)]
    one = replace(one, sections=other.sections, **{name: getattr(other, name) for name in skipped})

    def shape(solid: Shape) -> Shape:
        geometry = plain(solid.geometry) if isinstance(solid.geometry, Ellipsoid) else solid.geometry
        return replace(solid, geometry=geometry, material="", contact=None, mjcf={})

    def reduced(robot: Robot) -> Robot:
        links, joints = [], []
        for link in robot.links:
            both = ([shape(s) for one in some for s in one.solids()] for some in (link.collision, link.visual))
            collision, visual = map(tuple, both)
            links.append(
                Link(link.name, link.inertial, visual=visual, collision=collision, urdf_elements=link.urdf_elements)
            )
        for joint in robot.joints:
            dynamics = joint.dynamics and Dynamics(joint.dynamics.damping, joint.dynamics.friction)
            kind = "floating" if joint.type == "ball" else joint.type
            publisher = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
            joints.append(replace(joint, type=kind, dynamics=dynamics, actuator=None, mjcf={}, publisher=publisher))
        materials = tuple(replace(material, mjcf={}) for material in robot.materials)
        return replace(robot, links=tuple(links), joints=tuple(joints), materials=materials, mjcf=())

    return reduced(one), reduced(other)

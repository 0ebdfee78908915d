"""Packages that tests write."""

from __future__ import annotations

from pathlib import Path

from robots import ROOT, ROSORIN
from rosorin_compile.cli import main
from rosorin_compile.model import (
    STATIC_TRANSFORM_PUBLISHER,
    Joint,
    Pose,
    Publisher,
    Robot,
)
from rosorin_compile.packaging.package import Options, make

EXAMPLES = sorted(path.parent for path in (ROOT / "examples").rglob("robot.yaml"))
FORMS = ("py", "xml", "yaml")


def written(folder: Path, *words: str) -> Path:
    """Write the package of rosorin into a folder with a space in its name, and return it."""
    target = folder / "a folder" / "package"
    assert main(["package", str(ROSORIN), "-o", str(target), *words]) == 0
    return target


def names_in(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def made(folder: Path, robot: Robot) -> Path:
    """Write the package of a robot that no description says, and return it."""
    from rosorin_compile.emit import Artifact

    artifact = Artifact("robot.urdf", '<robot name="r"><link name="base_link"/></robot>', "urdf", "urdf")
    for name, data in make(robot, [artifact], Options("made"), (), folder).files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder


def static(name: str, parent: str, child: str, pose: Pose, node: str) -> Joint:
    return Joint(name, "fixed", parent, child, pose, publisher=Publisher(STATIC_TRANSFORM_PUBLISHER, node))


def describe(folder: Path, text: str) -> Path:
    path = folder / "descriptions" / "meshed" / "robot.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(text, "utf-8")
    return path

"""A package that people have, and what is deployed into it."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Joint, Pose, Publisher, Robot
from rosorin_compile.ros.package.options import Options
from rosorin_compile.ros.package.package import make
from support.paths import ROOT, ROSORIN, data_text
from support.robots import compiled

TEXTS = {artifact.file: artifact.text for artifact in compiled().artifacts}
FILES = yaml.safe_load(data_text("package_of_users.yaml"))
LAUNCH = FILES["launch/base.launch.py"]


def package_of_people(folder: Path) -> Path:
    """Write a package like that of a robot which has run for a while: old URDF, current model, launch by hand."""
    folder = folder / "ws" / "src" / "rosorin_base"
    urdf = TEXTS["rosorin.urdf"].replace("7.5437e-05 0.16044", "7.5437e-05 0.17044")
    files = {**FILES, "config/robot_model.json": TEXTS["robot_model.json"], "urdf/rosorin.urdf": urdf}
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, "utf-8")
    return folder


def deploy(folder: Path, *words: str) -> int:
    return main(["deploy", str(ROSORIN), "-o", str(folder), *words])


def check(folder: Path, *words: str) -> int:
    return main(["check", "deployed", str(ROSORIN), str(folder), *words])


def contents(folder: Path) -> dict[str, str]:
    return {p.relative_to(folder).as_posix(): p.read_text("utf-8") for p in folder.rglob("*") if p.is_file()}


# Packages that tests write.


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
    from rosorin_compile.formats import Artifact

    artifact = Artifact("robot.urdf", '<robot name="r"><link name="base_link"/></robot>', "urdf", "urdf")
    for name, data in make(robot, [artifact], Options("made"), (), folder)[0].items():
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


def clean(*files: Path) -> None:
    """Check that files are what ament_flake8 and ament_pep257 ask of a ROS 2 package."""
    ruff = shutil.which("ruff") or shutil.which("ruff", path=str(Path(sys.executable).parent))
    if ruff is None:
        pytest.skip("ruff is not installed")
    house = ["--line-length=99", "--config=lint.flake8-quotes.inline-quotes='single'"]
    house += ["--config=lint.isort.force-sort-within-sections=true", "--config=lint.isort.known-third-party=['launch']"]
    rules = ["--select=E,F,W,I,D,B,UP,N,Q,PTH", "--ignore=D203,D213"]
    command = [ruff, "check", "--isolated", *house, *rules, *map(str, files)]
    checked = subprocess.run(command, capture_output=True, text=True, check=False)
    assert files
    assert checked.returncode == 0, checked.stdout

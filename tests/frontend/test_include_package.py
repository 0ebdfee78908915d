"""Parts of installed packages, of ROS and of Python (of those beside the robot: commands/include-package.md)."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import text
from support.commands import write_files
from support.paths import DATA


def link(file: str, to: str) -> None:
    Path(to).symlink_to(file)


@pytest.mark.parametrize("linked", [False, True], ids=["copied", "symlink-install"])
def test_installed_descriptions_find_installed_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, linked: bool
) -> None:
    """An install space has each package in a prefix of its own; with --symlink-install each file is a link."""
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    sources = shutil.copytree(DATA / "include_package" / "src", tmp_path / "src")
    folder = sources / "cart_description/descriptions/cart"
    robot = (folder / "robot.yaml").read_text("utf-8").replace("[package", "[own.yaml, package")
    own = "links: {top: {}}\njoints: {t: {type: fixed, parent: base, child: top}}"
    write_files(folder, {"robot.yaml": robot, "own.yaml": own})
    for source in sources.iterdir():
        share = tmp_path / "install" / source.name / "share" / source.name
        shutil.copytree(source, share, copy_function=link if linked else shutil.copy2)
    monkeypatch.setenv("AMENT_PREFIX_PATH", ":".join(str(prefix) for prefix in (tmp_path / "install").iterdir()))
    share = tmp_path / "install/cart_description/share/cart_description"
    made = compile_robot(share / "descriptions/cart/robot.yaml")
    assert made.robot is not None, text(made.diagnostics)
    assert not made.diagnostics, text(made.diagnostics)
    assert sorted(link.name for link in made.robot.links) == ["base", "left_wheel", "rear_caster", "top"]
    read = {path for path in made.inputs if path.name == "wheels.yaml"}
    assert {"install" in path.absolute().parts for path in read} == {True}

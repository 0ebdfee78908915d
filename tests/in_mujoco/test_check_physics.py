"""check physics: the comment of each case in tests/data/physics lists the diagnostics that it gets.

See support/cases.py; a robot without comment is sound and gets none.
"""

import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.mujoco import physics
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.project import Description
from support.cases import as_comment, check
from support.commands import Shown
from support.paths import DATA, ROOT
from support.robots import copy_of_rosorin

pytest.importorskip("mujoco", minversion="3.12")
pytest.importorskip("trimesh")
pytest.importorskip("scipy")

pytestmark = pytest.mark.slow  # MuJoCo

CASES = sorted((DATA / "physics").glob("*.yaml"))


def looked_at(path: Path) -> list[Diagnostic]:
    return list(physics.check_physics(Request(Description("bad", path, Path("outputs")))).diagnostics)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.stem)
def test_message(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(case.parent)
    found = as_comment(looked_at(Path(case.name)), case.name)
    check(case, found)
    assert found or "robot: good\n" in case.read_text("utf-8")


@pytest.mark.tier("engines")
def test_the_reference_robot_is_told_that_the_chassis_is_a_stand_in(rosorin: Path, capsys: Shown) -> None:
    copy_of_rosorin(rosorin, whole=True)
    shutil.copytree(ROOT / "outputs", rosorin / "outputs")
    assert main(["check", "physics"]) == 0
    shown = capsys.readouterr()
    assert (
        'poses.yaml:6:3: warning[parts-overlap]: link "link2" is 3.1 mm inside link "base_footprint" in pose "tuck":'
        " box in height map (a stand-in)\n"
    ) in shown.err
    assert "checking the physics" not in shown.err  # the bar: this is no terminal
    assert shown.out == ("rosorin: physics of 1 pose, zero and the ranges of 46 joints: 1 warning and 2 notes\n")


def project_of(home: Path, case: str) -> None:
    shutil.copytree(DATA / "physics", home / "descriptions/bad")
    (home / "descriptions/bad" / f"{case}.yaml").rename(home / "descriptions/bad/robot.yaml")


def test_a_warning_does_not_fail(home: Path, capsys: Shown) -> None:
    project_of(home, "inside-parent")
    assert main(["check", "physics"]) == 0
    assert capsys.readouterr().out == "bad: physics of zero and the ranges of 1 joint: 1 warning\n"


def test_only_this_check_knows_what_is_accepted_in_vain(home: Path, capsys: Shown) -> None:
    project_of(home, "accepted")
    for command in (["all"], ["check"]):
        assert main(command) == 0
        assert "accept-unused" not in capsys.readouterr().err
    assert main(["check", "physics"]) == 0
    shown = capsys.readouterr()
    assert shown.err.count("warning[accept-unused]") == 2
    assert shown.err.count("accept-unused") == 2
    assert shown.out.endswith("bad: physics of 1 pose, zero and the ranges of 2 joints: 2 warnings\n")


def test_it_finds_the_meshes_that_check_finds(home: Path, capsys: Shown) -> None:
    """Beside an artifact that stands in a folder of its own, and in a package around the file that names the mesh."""
    folder, (cube, package) = home / "descriptions/bad", (DATA / "physics/cube.obj", home / "descriptions/arm")
    for place in (package / "urdf", package / "meshes", folder, home / "outputs/bad/sim"):
        place.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>other_name</name></package>")
    mesh = "links: {{{0}: {{collision: [{{mesh: {{file: {1}}}}}]}}}}\n"
    (package / "urdf/arm.yaml").write_text(
        mesh.format("arm", "package://other_name/meshes/cube.obj")
        + "joints: {turn: {type: fixed, parent: base, child: arm, xyz: [1, 0, 0]}}\n"
    )
    (folder / "robot.yaml").write_text(
        f"robot: bad\ninclude: [../arm/urdf/arm.yaml]\n{mesh.format('base', 'cube.obj')}"
        "outputs: {urdf: {file: bad.urdf}, mjcf: {file: sim/bad.xml}}\n"
    )
    shutil.copy(cube, package / "meshes/cube.obj")
    shutil.copy(cube, home / "outputs/bad/sim/cube.obj")
    assert main(["all"]) == 0
    assert main(["check", "physics"]) == 0
    shown = capsys.readouterr()
    assert "mesh-" not in shown.err
    assert shown.out.endswith("bad: physics of zero and 2 meshes: nothing to say\n")


@pytest.mark.usefixtures("rosorin")
def test_what_is_not_installed_is_named_with_the_command(capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    absent = ("mujoco", "collada")
    monkeypatch.setattr(physics, "is_installed", lambda name: name not in absent)
    assert main(["check", "physics"]) == 2
    said = "rosorin-compile: check physics needs what is not installed: pip install 'mujoco>=3.12' pycollada\n"
    assert capsys.readouterr().err == said

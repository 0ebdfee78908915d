"""check deployed: copies that are not the compiled ones."""

import json
import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.output import MANIFEST
from support.packages import LAUNCH, TEXTS, check, deploy, package_of_people
from support.paths import ROSORIN

pytestmark = pytest.mark.slow


@pytest.fixture
def base(tmp_path: Path) -> Path:
    return package_of_people(tmp_path)


def test_check_tells_by_file_and_by_meaning(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = json.loads(TEXTS["robot_model.json"])
    model["joints"]["joint2"]["xyz"][2] += 0.002
    (base / "config/robot_model.json").write_text(json.dumps(model))
    assert check(base) == 1
    out = capsys.readouterr().out
    assert "config/robot_model.json: link2 moved 2.0 mm in link1: origin z 0.030345 -> 0.032345 m" not in out
    assert "config/robot_model.json: link2 moved 2.0 mm in link1: origin z 0.032345 -> 0.030345 m\n" in out
    assert "urdf/rosorin.urdf: link1 moved 10.0 mm in base_link: origin z 0.17044 -> 0.16044 m\n" in out
    assert out.endswith(f"rosorin: 0 of 2 copies in {base} as compiled\n")


def test_check_says_what_is_not_there(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (base / "urdf/rosorin.urdf").unlink()
    assert check(base) == 1
    said = capsys.readouterr().err
    assert f"error[deployed-missing]: there is no rosorin.urdf in {base}\n    rosorin-compile deploy\n" in said
    assert "note[deployed-missing]: there is no copy of " in said
    assert "static_tf.json" in said


def test_check_of_a_whole_project(base: Path) -> None:
    """What the guide does by hand: cmp of the model and of its copy in the package, and of the install space."""
    deploy(base)
    project = base.parent.parent
    share = project / "install/rosorin_base/share/rosorin_base"
    shutil.copytree(base / "config", share / "config")
    shutil.copytree(base / "urdf", share / "urdf")
    (project / "model").mkdir()
    (project / "model/robot_model.json").write_text(TEXTS["robot_model.json"], "utf-8")
    assert check(project) == 0
    (share / "urdf/rosorin.urdf").write_text(TEXTS["rosorin.urdf"].replace("0.16044", "0.16"), "utf-8")
    assert check(project) == 1
    assert check(share) == 1
    assert check(base) == 0


@pytest.mark.landing("fuzz", "not xml")
@pytest.mark.parametrize("damage", ["", "not xml", "<robot name='x'/>", "\0"])
def test_damaged_copies_are_said_and_mended(base: Path, damage: str, capsys: pytest.CaptureFixture[str]) -> None:
    (base / "urdf/rosorin.urdf").write_text(damage)
    assert check(base) == 1
    assert "urdf/rosorin.urdf: " in capsys.readouterr().out
    if damage:  # nobody knows who wrote that
        assert deploy(base) == 1
        assert (base / "urdf/rosorin.urdf").read_text() == damage
        (base / "urdf/rosorin.urdf").unlink()
    assert deploy(base) == 0
    assert (base / "urdf/rosorin.urdf").read_text("utf-8") == TEXTS["rosorin.urdf"]


def test_an_edited_launch_file_of_a_package_of_ours(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    package = tmp_path / "package"
    assert main(["package", str(ROSORIN), "-o", str(package)]) == 0
    assert check(package) == 0
    path = package / "launch/description.launch.xml"
    path.write_text(path.read_text("utf-8").replace('default="false"', 'default="true"'), "utf-8")
    capsys.readouterr()
    assert check(package) == 1
    said = "launch/description.launch.xml: not as rosorin-compile package writes it\n"
    assert said in capsys.readouterr().out


def test_a_frame_that_no_launch_file_publishes(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    launch = base / "launch/base.launch.py"
    launch.write_text(LAUNCH.replace("'base_link', 'imu_link'", "'base_link', 'imu'"), "utf-8")
    check(base)
    said = capsys.readouterr().err
    assert f"warning[deployed-static-missing]: no launch file in {base} publishes base_link -> imu_link" in said
    assert "warning[deployed-launch-unknown]: base_link -> imu is no frame of the description\n" in said


def test_one_robot_is_checked_at_a_time(
    base: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("one", "two"):
        path = tmp_path / "project" / "descriptions" / name / "robot.yaml"
        path.parent.mkdir(parents=True)
        path.write_text(f"robot: {name}\nlinks: {{a: {{}}}}\noutputs: {{urdf: {{file: {name}.urdf}}}}\n")
    monkeypatch.chdir(tmp_path / "project")
    assert main(["check", "deployed", str(base)]) == 2
    message = "there are several robots here: one, two; name one: rosorin-compile check deployed ROBOT FOLDER"
    assert message in capsys.readouterr().err
    assert main(["check", "deployed", "one", str(base)]) == 1
    assert main(["check", "deployed", "one", "nowhere"]) == 2


def test_files_of_two_runs_are_reported(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As after a kill: the manifest says which run each file is of."""
    deploy(base)
    assert check(base) == 0
    manifest = base / MANIFEST
    written = json.loads(manifest.read_text())
    urdf, other = "urdf/rosorin.urdf", next(name for name in written if name != "urdf/rosorin.urdf")
    manifest.write_text(json.dumps({**written, urdf: ["0", written[urdf]], other: [written[other], "1"]}))
    capsys.readouterr()
    assert check(base) == 1
    message = f"{base} has files of two runs, because the last one was ended while it wrote: {urdf}: new; {other}: old"
    assert f"error[deployed-mixed]: {message}\n" in capsys.readouterr().err
    manifest.write_text(json.dumps({**written, urdf: ["0", written[urdf]], other: ["1", written[other]]}))
    assert check(base) == 0, "all files are of one run"
    manifest.write_text(json.dumps({**written, urdf: ["0", written[urdf]], other: [written[other], "1"]}))
    assert deploy(base) == 0
    assert json.loads(manifest.read_text()) == written
    assert check(base) == 0

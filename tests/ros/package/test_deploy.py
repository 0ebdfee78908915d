"""Deploying into a package that people have: what goes where, and what is said about it."""

import json
import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.output import MANIFEST
from support.launch import run
from support.packages import LAUNCH, TEXTS, check, contents, deploy, package_of_people

pytestmark = pytest.mark.slow


@pytest.fixture
def base(tmp_path: Path) -> Path:
    return package_of_people(tmp_path)


def test_the_artifacts_go_where_they_belong(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = contents(base)
    assert deploy(base) == 0
    after = contents(base)
    changed = {name for name in after if after[name] != before.get(name)}
    own = {"urdf/rosorin.urdf", "config/static_tf.json", "launch/static_tf.launch.py", MANIFEST}
    moving = {"controllers.yaml", "ekf_frames.yaml", "nav2.yaml"}
    assert changed == {*own, *(f"config/{name}" for name in moving), "sdf/rosorin.sdf", "srdf/rosorin.srdf"}
    assert after["urdf/rosorin.urdf"] == TEXTS["rosorin.urdf"]
    assert after["config/static_tf.json"] == TEXTS["static_tf.json"]
    out = capsys.readouterr().out
    assert "urdf/rosorin.urdf: link1 moved 10.0 mm in base_link: origin z 0.17044 -> 0.16044 m\n" in out
    assert "config/static_tf.json: new\n" in out
    assert out.endswith(f"rosorin: 8 of 9 files in {base} written\n")
    assert deploy(base) == 0
    assert capsys.readouterr().out == "rosorin: all 9 files as compiled\n"
    assert contents(base) == after


def test_the_launch_file_finds_the_urdf_where_it_was_put(base: Path) -> None:
    deploy(base)
    path = base / "launch/static_tf.launch.py"
    publisher, *statics = run(path.read_text("utf-8"), path)
    assert publisher.parameters["robot_description"] == TEXTS["rosorin.urdf"]
    assert [node.name for node in statics] == ["tf_base_laser", "tf_base_imu"]


def test_a_dry_run_writes_nothing(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = contents(base)
    assert deploy(base, "--dry-run") == 1
    assert contents(base) == before
    assert f"rosorin: 8 of 9 files in {base} would be written\n" in capsys.readouterr().out
    assert deploy(base) == 0
    capsys.readouterr()
    assert deploy(base, "-n") == 0


def test_a_launch_file_by_hand_that_is_wrong(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    launch = base / "launch/base.launch.py"
    launch.write_text(LAUNCH.replace("'3.14159265'", "'0'").replace("'0.048046'", "'0.0408'"), "utf-8")
    assert deploy(base) == 1
    said = capsys.readouterr().err
    assert f"{launch}:19:9: error[deployed-launch-differs]: base_link -> laser is not as described: --yaw 0" in said
    assert "--yaw 0 -> 3.14159265, rotation 180 deg off\n" in said
    assert f"{launch}:21:9: error[deployed-launch-differs]: base_link -> imu_link is not as described: --z" in said
    assert "--z 0.0408 -> 0.048046\n" in said
    assert launch.read_text("utf-8") == LAUNCH.replace("'3.14159265'", "'0'").replace("'0.048046'", "'0.0408'")
    assert check(base) == 1


def test_two_publishers_are_told(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deploy(base)
    said = capsys.readouterr().err
    message = "launch/base.launch.py and launch/static_tf.launch.py both publish laser, imu_link"
    assert f"note[deployed-static-twice]: {message}\n    launch one of them\n" in said


def test_a_mapping_is_remembered(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert deploy(base, "--map", "urdf=description/", "--map", "mjcf=sim/model.xml", "--map", "static_tf=none") == 0
    after = contents(base)
    assert after["description/rosorin.urdf"] == TEXTS["rosorin.urdf"]
    assert after["sim/model.xml"] == TEXTS["rosorin.xml"]
    assert "launch/static_tf.launch.py" not in after
    assert after[".rosorin-compile-deploy.yaml"] == (
        "# Where rosorin-compile deploy puts artifacts in this folder (none: not here).\n"
        'robots:\n  "rosorin":\n    "mjcf": "sim/model.xml"\n    "static_tf": "none"\n'
        '    "urdf": "description/rosorin.urdf"\n'
    )
    (base / "description/rosorin.urdf").unlink()
    (base / "urdf/rosorin.urdf").unlink()
    capsys.readouterr()
    assert check(base) == 1
    assert f"error[deployed-missing]: there is no description/rosorin.urdf in {base}\n" in capsys.readouterr().err
    assert deploy(base) == 0
    assert contents(base) == {name: text for name, text in after.items() if name != "urdf/rosorin.urdf"}
    assert check(base) == 0


def test_a_damaged_mapping(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (base / ".rosorin-compile-deploy.yaml").write_text("robots: {rosorin: [urdf]}\n")
    before = contents(base)
    assert deploy(base) == 1
    assert "error[deploy-mapping]: " in capsys.readouterr().err
    (base / ".rosorin-compile-deploy.yaml").write_text("robots: {")
    assert deploy(base) == check(base) == 1
    assert contents(base) == {**before, ".rosorin-compile-deploy.yaml": "robots: {"}


@pytest.mark.parametrize("place", ["../x.urdf", "/x.urdf", "a/../../x.urdf"])
def test_a_mapping_never_leads_out(base: Path, place: str, capsys: pytest.CaptureFixture[str]) -> None:
    before = contents(base.parent)
    assert deploy(base, "--map", f"urdf={place}") == 1
    assert f'error[deploy-outside]: "{place}" does not stand in the folder\n' in capsys.readouterr().err
    assert contents(base.parent) == before


def test_a_folder_that_is_a_link_is_not_followed(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.move(base / "urdf", base.parent / "elsewhere")
    (base / "urdf").symlink_to(base.parent / "elsewhere")
    before = contents(base.parent)
    assert deploy(base) == 1
    assert "error[deploy-link]: " in capsys.readouterr().err
    assert contents(base.parent) == before


def test_several_copies_are_a_question(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(base / "urdf", base / "old")
    before = contents(base)
    assert deploy(base) == 1
    said = capsys.readouterr().err
    message = "the folder has several copies of rosorin.urdf: old/rosorin.urdf, urdf/rosorin.urdf"
    assert f"error[deploy-ambiguous]: {message}\n    say --map urdf=PLACE (none for nowhere)\n" in said
    assert contents(base) == before
    assert deploy(base, "--map", "urdf=urdf/rosorin.urdf") == 0


def test_two_outputs_for_one_place(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert deploy(base, "--map", "urdf=a", "--map", "mjcf=a") == 1
    assert "error[deploy-ambiguous]: the outputs " in capsys.readouterr().err


def test_a_renamed_copy_is_found_by_what_stands_in_it(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (base / "urdf/rosorin.urdf").rename(base / "urdf/my_arm.urdf")
    assert check(base) == 1
    assert (
        "urdf/my_arm.urdf: link1 moved 10.0 mm in base_link: origin z 0.17044 -> 0.16044 m\n" in capsys.readouterr().out
    )
    assert deploy(base) == 0
    assert (base / "urdf/my_arm.urdf").read_text("utf-8") == TEXTS["rosorin.urdf"]
    assert not (base / "urdf/rosorin.urdf").exists()
    path = base / "launch/static_tf.launch.py"
    assert run(path.read_text("utf-8"), path)[0].name == "robot_state_publisher"
    assert check(base) == 0


def test_for_programs(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert check(base, "--format", "json") == 1
    rules = [one["rule"] for one in json.loads(capsys.readouterr().out)["diagnostics"]]
    assert "deployed-differs" in rules
    assert deploy(base, "--format", "json") == 0
    rules = [one["rule"] for one in json.loads(capsys.readouterr().out)["diagnostics"]]
    assert {"deploy-changes", "deploy-not-installed"} <= set(rules)


def test_an_unknown_argument_writes_nothing(base: Path) -> None:
    before = contents(base)
    assert deploy(base, "nonsense:=1") == 1
    assert check(base, "nonsense:=1") == 1
    assert contents(base) == before


def test_meshes_of_a_deployed_urdf(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.yaml"
    mesh = "{base_link: {visual: [{mesh: {file: meshes/body.stl}}]}}"
    path.write_text(f"robot: meshed\nlinks: {mesh}\noutputs: {{urdf: {{file: meshed.urdf}}}}\n")
    package = tmp_path / "package"
    package.mkdir()
    (package / "package.xml").write_text("<package><name>mine</name></package>")
    assert main(["deploy", str(path), "-o", str(package)]) == 0
    assert "warning[package-mesh]: meshes/body.stl is not in the package\n" in capsys.readouterr().err
    assert 'filename="meshes/body.stl"' in (package / "urdf/meshed.urdf").read_text("utf-8")
    (package / "meshes").mkdir()
    (package / "meshes/body.stl").write_bytes(b"body")
    assert main(["deploy", str(path), "-o", str(package)]) == 0
    assert 'filename="package://mine/meshes/body.stl"' in (package / "urdf/meshed.urdf").read_text("utf-8")
    assert main(["check", "deployed", str(path), str(package)]) == 0

"""Deploying into a package of users, and checking the copies there."""

import json
import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.output.package_folder import MANIFEST
from rosorin_compile.ros.package.package_files import files_below, undeclared_packages, uninstalled_files
from support.launch import run
from support.packages import LAUNCH, TEXTS, check, contents, deploy, package_of_people
from support.paths import ROSORIN

MOVED = "link1 moved 10.0 mm in base_link: origin z 0.17044 -> 0.16044 m\n"


@pytest.fixture
def base(tmp_path: Path) -> Path:
    return package_of_people(tmp_path)


def test_places_that_an_older_version_stored_are_refused(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (base / ".rosorin-compile-deploy.yaml").write_text("robots: {}\n", "utf-8")
    assert deploy(base) == 2
    assert "is not read any more: pass its places with --map" in capsys.readouterr().err


@pytest.mark.slow
def test_the_artifacts_go_where_they_belong(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = contents(base)
    assert deploy(base, "--dry-run") == 1
    assert contents(base) == before
    assert f"rosorin: 8 of 9 files in {base} would be written\n" in capsys.readouterr().out
    assert deploy(base) == 0
    after = contents(base)
    changed = {name for name in after if after[name] != before.get(name)}
    own = {"urdf/rosorin.urdf", "config/static_tf.json", "launch/static_tf.launch.py", MANIFEST}
    moving = {"controllers.yaml", "ekf_frames.yaml", "nav2.yaml"}
    assert changed == {*own, *(f"config/{name}" for name in moving), "sdf/rosorin.sdf", "srdf/rosorin.srdf"}
    assert after["urdf/rosorin.urdf"] == TEXTS["rosorin.urdf"]
    shown = capsys.readouterr()
    assert f"urdf/rosorin.urdf: {MOVED}" in shown.out
    assert "config/static_tf.json: new\n" in shown.out
    assert shown.out.endswith(f"rosorin: 8 of 9 files in {base} written\n")
    message = "launch/base.launch.py and launch/static_tf.launch.py both publish laser, imu_link"
    assert f"note[deployed-static-twice]: {message}\n    launch one of them\n" in shown.err
    path = base / "launch/static_tf.launch.py"
    publisher, *statics = run(path.read_text("utf-8"), path)
    assert publisher.parameters["robot_description"] == TEXTS["rosorin.urdf"]
    assert [node.name for node in statics] == ["tf_base_laser", "tf_base_imu"]
    assert deploy(base) == deploy(base, "-n") == 0
    assert capsys.readouterr().out.startswith(f"rosorin: 0 of 9 files in {base} written\n")
    assert contents(base) == after


@pytest.mark.slow
def test_a_wrong_handwritten_launch_file(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    launch, wrong = base / "launch/base.launch.py", LAUNCH.replace("'3.14159265'", "'0'").replace("0.048046", "0.0408")
    launch.write_text(wrong, "utf-8")
    assert deploy(base) == 1
    said = capsys.readouterr().err
    assert f"{launch}:19:9: error[deployed-launch-differs]: base_link -> laser is not as described: --yaw 0" in said
    assert "--yaw 0 -> 3.14159265, rotation 180 deg off\n" in said
    assert f"{launch}:21:9: error[deployed-launch-differs]: base_link -> imu_link is not as described: --z" in said
    assert "--z 0.0408 -> 0.048046\n" in said
    assert launch.read_text("utf-8") == wrong
    assert check(base) == 1


@pytest.mark.slow
def test_outputs_go_where_the_option_says(base: Path) -> None:
    assert deploy(base, "--map", "urdf=description/", "--map", "mjcf=sim/model.xml", "--map", "static_tf=none") == 0
    after = contents(base)
    assert after["description/rosorin.urdf"] == TEXTS["rosorin.urdf"]
    assert after["sim/model.xml"] == TEXTS["rosorin.xml"]
    assert "launch/static_tf.launch.py" not in after


@pytest.mark.slow
def test_several_copies_or_one_place_for_two(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(base / "urdf", base / "old")
    before = contents(base)
    assert deploy(base) == 1
    message = "the folder has several copies of rosorin.urdf: old/rosorin.urdf, urdf/rosorin.urdf"
    help = "say --map urdf=PLACE (none for nowhere)"
    assert f"error[deploy-ambiguous]: {message}\n    {help}\n" in capsys.readouterr().err
    assert deploy(base, "--map", "urdf=a", "--map", "mjcf=a") == 1
    assert "error[deploy-ambiguous]: the outputs " in capsys.readouterr().err
    assert contents(base) == before
    assert deploy(base, "--map", "urdf=urdf/rosorin.urdf") == 0


@pytest.mark.slow
def test_a_renamed_copy_is_found_by_its_mark(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (base / "urdf/rosorin.urdf").rename(base / "urdf/my_arm.urdf")
    assert check(base) == 1
    assert f"urdf/my_arm.urdf: {MOVED}" in capsys.readouterr().out
    assert deploy(base) == 0
    assert (base / "urdf/my_arm.urdf").read_text("utf-8") == TEXTS["rosorin.urdf"]
    assert not (base / "urdf/rosorin.urdf").exists()
    path = base / "launch/static_tf.launch.py"
    assert run(path.read_text("utf-8"), path)[0].name == "robot_state_publisher"
    assert check(base) == 0


def test_meshes_of_a_deployed_urdf(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, package = tmp_path / "robot.yaml", tmp_path / "package"
    mesh = "{base_link: {visual: [{mesh: {file: meshes/body.stl}}]}}"
    path.write_text(f"robot: meshed\nlinks: {mesh}\noutputs: {{urdf: {{file: meshed.urdf}}}}\n")
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


@pytest.mark.slow
def test_check_compares_by_meaning(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = json.loads(TEXTS["robot_model.json"])
    model["joints"]["joint2"]["xyz"][2] += 0.002
    (base / "config/robot_model.json").write_text(json.dumps(model))
    launch = base / "launch/base.launch.py"
    launch.write_text(LAUNCH.replace("'base_link', 'imu_link'", "'base_link', 'imu'"), "utf-8")
    assert check(base) == 1
    shown = capsys.readouterr()
    assert "config/robot_model.json: link2 moved 2.0 mm in link1: origin z 0.032345 -> 0.030345 m\n" in shown.out
    assert f"urdf/rosorin.urdf: {MOVED}" in shown.out
    assert shown.out.endswith(f"rosorin: 0 of 2 copies in {base} as compiled\n")
    assert f"warning[deployed-static-missing]: no launch file in {base} publishes base_link -> imu_link" in shown.err
    assert "warning[deployed-launch-unknown]: base_link -> imu is not a frame of the description\n" in shown.err
    (base / "urdf/rosorin.urdf").unlink()
    assert check(base) == 1
    said = capsys.readouterr().err
    assert f"error[deployed-missing]: there is no rosorin.urdf in {base}\n" in said
    assert "note[deployed-missing]: there is no copy of " in said


@pytest.mark.slow
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
    assert check(project) == check(share) == 1
    assert check(base) == 0


@pytest.mark.slow
@pytest.mark.landing("fuzz", "not xml")
@pytest.mark.parametrize("damage", ["", "not xml", "<robot name='x'/>", "\0"])
def test_damaged_copies(base: Path, damage: str, capsys: pytest.CaptureFixture[str]) -> None:
    (base / "urdf/rosorin.urdf").write_text(damage)
    assert check(base) == 1
    assert "urdf/rosorin.urdf: " in capsys.readouterr().out
    if damage:  # it may be the file of a user
        assert deploy(base) == 1
        assert (base / "urdf/rosorin.urdf").read_text() == damage
        (base / "urdf/rosorin.urdf").unlink()
    assert deploy(base) == 0
    assert (base / "urdf/rosorin.urdf").read_text("utf-8") == TEXTS["rosorin.urdf"]


@pytest.mark.slow
def test_files_of_two_runs_are_reported(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As after a kill: the manifest says which run each file is of."""
    deploy(base)
    manifest = base / MANIFEST
    written = json.loads(manifest.read_text())
    urdf, other = "urdf/rosorin.urdf", next(name for name in written if name != "urdf/rosorin.urdf")
    manifest.write_text(json.dumps({**written, urdf: ["0", written[urdf]], other: [written[other], "1"]}))
    capsys.readouterr()
    assert check(base) == 1
    message = f"{base} has files of two runs, because the last one was ended while it wrote: {urdf}: new; {other}: old"
    assert f"error[deployed-mixed]: {message}\n" in capsys.readouterr().err
    assert deploy(base) == 0
    assert json.loads(manifest.read_text()) == written


def test_an_edited_launch_file_of_a_written_package(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    package = tmp_path / "package"
    assert main(["package", str(ROSORIN), "-o", str(package)]) == 0
    assert check(package) == 0
    path = package / "launch/description.launch.xml"
    path.write_text(path.read_text("utf-8").replace('default="false"', 'default="true"'), "utf-8")
    capsys.readouterr()
    assert check(package) == 1
    said = "launch/description.launch.xml: not as rosorin-compile package writes it\n"
    assert said in capsys.readouterr().out


# Finding copies: folders behind links, and files that are there for another robot.

OTHER = """\
rosorin_compile: 1
robot: {name}
links: {{base_link: {{}}, lamp: {{}}}}
joints:
  lamp_joint: {{type: fixed, parent: base_link, child: lamp, publisher: {{static_transform_publisher: tf_lamp}}}}
outputs:
  urdf: {{file: robot.urdf}}
  static_tf: {{file: static_tf.launch.py}}
  static_tf_json: {{file: static_tf.json}}
"""


@pytest.fixture
def deployed(tmp_path: Path) -> Path:
    folder = tmp_path / "base"
    folder.mkdir()
    assert deploy(folder) == 0
    return folder


@pytest.mark.parametrize("name", ["other", '"its a robot"', "ä/b"])
def test_another_robot_is_not_written_over(
    deployed: Path, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "other.yaml"
    path.write_text(OTHER.format(name=name), "utf-8")
    before = {file: text for file, text in contents(deployed).items() if file != MANIFEST}
    command = ["deploy", str(path), "-o", str(deployed)]
    assert main(command) == 1
    said = capsys.readouterr().err
    assert "error[deploy-other-robot]: launch/static_tf.launch.py is there for the robot rosorin, not for " in said
    assert "    say --map static_tf=PLACE (none for nowhere)\n" in said
    assert "error[deploy-other-robot]: config/static_tf.json is there for the robot rosorin, not for " in said
    assert contents(deployed).items() >= before.items()
    words = ["--map", "static_tf=launch/other.launch.py", "--map", "static_tf_json=config/other.json"]
    assert main([*command, *words]) == main([*command, *words]) == 0
    assert contents(deployed).items() >= before.items()
    assert check(deployed) == 0
    words[1] = "static_tf=launch/static_tf.launch.py"
    assert main([*command, *words]) == 0, "a place that is named"
    assert contents(deployed)["launch/static_tf.launch.py"] != before["launch/static_tf.launch.py"]


def test_check_follows_links(deployed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    there = deployed.parent / "elsewhere"
    (deployed / "urdf").rename(there)
    (deployed / "urdf").symlink_to(there)
    assert check(deployed) == 0
    (there / "rosorin.urdf").write_text(TEXTS["rosorin.urdf"].replace("0.16044", "0.17044"), "utf-8")
    capsys.readouterr()
    assert check(deployed) == 1
    assert f"urdf/rosorin.urdf: {MOVED}" in capsys.readouterr().out
    (there / "again").symlink_to(deployed)
    (deployed / "config/above").symlink_to(deployed.parent)
    assert len(files_below(deployed, skip_built=False)) == len({*files_below(deployed, skip_built=False)}) < 30


# Whether what is deployed reaches the robot: setup.py, CMakeLists.txt, package.xml, install spaces.


def test_what_setup_py_does_not_install(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deploy(base)
    said = capsys.readouterr().err
    assert "warning[deploy-not-installed]: setup.py of rosorin_base does not install urdf/rosorin.urdf\n" in said
    assert "    add: ('share/rosorin_base/urdf', ['urdf/rosorin.urdf']),\n" in said
    assert "does not install config/robot_model.json" not in said
    assert "does not install launch/static_tf.launch.py" not in said
    share = base.parent.parent / "install/rosorin_base/share/rosorin_base"
    shutil.copytree(base, share)
    deploy(share)
    assert "warning[deploy-install-space]: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "is_installed"),
    [
        ("install(DIRECTORY urdf launch DESTINATION share/${PROJECT_NAME})", True),
        ("install(FILES urdf/rosorin.urdf DESTINATION share/${PROJECT_NAME}/urdf)", True),
        ("install(FILES urdf/other.urdf DESTINATION share/${PROJECT_NAME}/urdf)", False),
        ("ament_auto_package(INSTALL_TO_SHARE\n  launch urdf)", True),
        ("ament_auto_package(INSTALL_TO_SHARE launch)", False),
        ("# install(DIRECTORY urdf DESTINATION share/${PROJECT_NAME})", False),
        ("foreach(f urdf)\n install(DIRECTORY ${f} DESTINATION share/${PROJECT_NAME})\nendforeach()", True),
        ("data_files=[('share/p/urdf', ['urdf/rosorin.urdf'])]", True),
        ("data_files=[('share/p/urdf', glob(os.path.join('urdf', '*.urdf')))]", True),
        ("name = 'rosorin'\ndata_files=[('share/p/urdf', [f'urdf/{name}.urdf'])]", True),
        ("data_files=[('share/p/urdf', glob('launch/*.urdf'))]", False),
        ("data_files=[('share/p/urdf', glob('*'))]", False),
        ("[str(p) for p in Path('urdf').rglob('*')]", True),
    ],
)
def test_what_a_package_installs(tmp_path: Path, text: str, is_installed: bool) -> None:
    is_cmake = "install(" in text or "ament_auto_package" in text
    (tmp_path / ("CMakeLists.txt" if is_cmake else "setup.py")).write_text(text)
    found = list(uninstalled_files(tmp_path, "p", ["urdf/rosorin.urdf"]))
    assert (found == []) is is_installed
    if found and is_cmake:
        assert found[0][1] == ("CMakeLists.txt", "install(DIRECTORY urdf DESTINATION share/${PROJECT_NAME})")


def test_dependencies_of_launch_files(tmp_path: Path) -> None:
    (tmp_path / "package.xml").write_text("<package><depend>tf2_ros</depend></package>")
    launches = ["Node(package='tf2_ros'", "Node(package='robot_state_publisher'"]
    assert undeclared_packages(tmp_path, launches) == ["robot_state_publisher"]

"""The ROS 2 package of a robot: its metadata, its meshes, its view, and what is said about it."""

import os
import struct
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.ros.package.copies import file_names, place_meshes
from rosorin_compile.ros.package.options import is_legal, package_name
from support.packages import EXAMPLES, describe, names_in, written
from support.paths import ROOT, ROSORIN, data_text
from support.robots import compiled

MESHED = data_text("robots/package_meshed.yaml")


def test_the_artifacts_in_it_are_the_compiled_ones(tmp_path: Path) -> None:
    package = written(tmp_path)
    folders = {".urdf": "urdf", ".xml": "mjcf", ".sdf": "sdf", ".srdf": "srdf", ".md": "doc", ".svg": "doc"}
    for artifact in compiled().artifacts:
        path = Path(artifact.file)
        if not path.name.endswith(".launch.py"):
            folder = folders.get(path.suffix, "config")
            assert (package / folder / path.name).read_text("utf-8") == artifact.text, path


@pytest.mark.parametrize("kind", ["ament_cmake", "ament_python"])
def test_package_xml_by_catkin_pkg(tmp_path: Path, kind: str) -> None:
    parse_package = pytest.importorskip("catkin_pkg.package").parse_package
    words = ["--maintainer", "Ada L. <ada@example.org>", "--license", "Apache-2.0", "--package-version", "1.2.3"]
    words += ["--url", "https://example.org/rosorin?a=1&b=2"]
    package = parse_package(str(written(tmp_path, "--build-type", kind, *words)))
    warnings: list[str] = []
    package.validate(warnings=warnings)
    assert not warnings
    assert (package.name, package.version, package.licenses) == ("rosorin_description", "1.2.3", ["Apache-2.0"])
    assert [(person.name, person.email) for person in package.maintainers] == [("Ada L.", "ada@example.org")]
    assert [(one.url, one.type) for one in package.urls] == [("https://example.org/rosorin?a=1&b=2", "website")]
    assert [one.file for one in package.licenses] == ["LICENSE"]
    assert package.get_build_type() == kind
    tests = {dependency.name for dependency in package.test_depends}
    assert tests == {"liburdfdom-tools", "python3-pytest"} | (
        {"ament_cmake_pytest"} if kind == "ament_cmake" else set()
    )
    needs = {dependency.name for dependency in package.exec_depends}
    assert needs >= {"robot_state_publisher", "tf2_ros", "launch_ros"}
    assert not needs & {"rviz2", "joint_state_publisher", "joint_state_publisher_gui"}


def test_the_view_shows_frames_that_exist(tmp_path: Path) -> None:
    package = written(tmp_path)
    view = yaml.safe_load((package / "rviz/rosorin.rviz").read_text("utf-8"))["Visualization Manager"]
    links = [element.get("name") for element in ET.parse(package / "urdf/rosorin.urdf").iter("link")]
    assert view["Global Options"]["Fixed Frame"] == links[0] == "base_link"
    shown = {display["Class"]: display for display in view["Displays"]}
    assert shown["rviz_default_plugins/RobotModel"]["Description Topic"]["Value"] == "robot_description"
    scan = shown["rviz_default_plugins/LaserScan"]
    assert (scan["Topic"]["Value"], scan["Enabled"], scan["Name"]) == ("/scan", True, "lidar")
    cloud = shown["rviz_default_plugins/PointCloud2"]
    assert (cloud["Topic"]["Value"], cloud["Enabled"]) == ("", False)


def test_ament_python_has_what_colcon_asks_for(tmp_path: Path) -> None:
    package = written(tmp_path, "--build-type", "ament_python", "--name", "my_robot")
    assert {"setup.py", "setup.cfg", "resource/my_robot"} < set(names_in(package))
    assert "CMakeLists.txt" not in names_in(package)
    command = [sys.executable, "setup.py", "--quiet", "install_data", "--install-dir", str(tmp_path / "there")]
    subprocess.run(command, cwd=package, check=True, capture_output=True)
    installed = names_in(tmp_path / "there" / "share")
    assert "ament_index/resource_index/packages/my_robot" in installed
    data = [n for n in names_in(package) if n.startswith(("config", "doc", "launch", "mjcf", "rviz", "urdf"))]
    assert {f"my_robot/{name}" for name in [*data, "package.xml"]} < set(installed)


def test_writing_again_changes_nothing_and_keeps_other_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    package = written(tmp_path)
    (package / "launch/mine.launch.py").write_text("# mine\n")
    times = {name: (package / name).stat().st_mtime_ns for name in names_in(package)}
    capsys.readouterr()
    written(tmp_path)
    assert capsys.readouterr().out.endswith("package, unchanged\n")
    assert times == {name: (package / name).stat().st_mtime_ns for name in names_in(package)}


@given(st.text(max_size=30))
def test_the_default_name_is_legal(name: str) -> None:
    assert is_legal(package_name(name))


@pytest.mark.parametrize("name", ["", "a", "Robot", "2wd", "my-robot", "a__b", "a_", "ä", "my robot", "_a"])
def test_names_that_are_refused(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert not is_legal(name)
    if name:
        robot = describe(tmp_path, "robot: r\nlinks: {base_link: {}}\noutputs: {urdf: {file: r.urdf}}\n")
        assert main(["package", str(robot), "-o", str(tmp_path / "p"), "--name", name]) == 2
        assert f'"{name}" is not a name for a ROS 2 package' in capsys.readouterr().err
        assert not (tmp_path / "p").exists()


def test_meshes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = describe(tmp_path, MESHED)
    (path.parent / "meshes").mkdir()
    (path.parent / "meshes/body.stl").write_bytes(b"\0\xff body")
    (path.parent / "meshes/own.stl").write_bytes(b"own")
    package = tmp_path / "package"
    assert main(["package", str(path), "-o", str(package)]) == 0
    said = capsys.readouterr().err
    assert (package / "meshes/body.stl").read_bytes() == b"\0\xff body"
    assert (package / "meshes/own.stl").read_bytes() == b"own"
    assert file_names((package / "urdf/meshed.urdf").read_text("utf-8")) == [
        "package://meshed_description/meshes/body.stl",
        "package://other_robot/meshes/wheel.stl",
        "package://meshed_description/meshes/own.stl",
        "package://meshed_description/meshes/missing.stl",
        "file:///opt/there.stl",
    ]
    assert "<exec_depend>other_robot</exec_depend>" in (package / "package.xml").read_text("utf-8")
    what = "is not there, neither as seen from the artifacts nor next to the description"
    assert f"robot.yaml:8:22: warning[mesh-not-found]: mesh missing.stl {what}\n" in said
    assert said.count("missing.stl is") == 1
    assert "warning[package-mesh]: file:///opt/there.stl is found on machines that have this very file\n" in said
    (package / "meshes/missing.stl").write_bytes(b"put there by hand")
    assert main(["package", str(path), "-o", str(package)]) == 0
    assert "package-mesh]: missing.stl" not in capsys.readouterr().err
    assert (package / "meshes/missing.stl").read_bytes() == b"put there by hand"


@pytest.mark.parametrize("name", ["../../secret.stl", "a/../../../secret.stl"])
def test_a_mesh_never_leads_out_of_the_package(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.stl").write_bytes(b"s")
    found = place_meshes(f'<mesh filename="{name}"/>', "made", [tmp_path / "a" / "b"], tmp_path / "package")
    assert all(".." not in place for place in found.files)
    assert ".." not in found.text
    own = place_meshes(
        f'<mesh filename="package://made/{name}"/>', "made", [tmp_path / "a" / "b"], tmp_path / "package"
    )
    assert not own.files
    assert [d.rule for d in own.diagnostics] == ["package-mesh"]


@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        (
            "{small: {backend: urdf, file: small/r.urdf, elements: []}, urdf: {file: full/r.urdf}}",
            "error[package-same-place]: the outputs small and urdf would both be urdf/r.urdf in the package\n",
        ),
        ("{frames: {file: f.md}}", "error[package-no-urdf]: no output is a URDF, which a package needs\n"),
    ],
)
def test_outputs_that_make_no_package(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], outputs: str, message: str
) -> None:
    path = describe(tmp_path, f"robot: two\nlinks: {{base_link: {{}}}}\noutputs: {outputs}\n")
    assert main(["package", str(path), "-o", str(tmp_path / "package")]) == 1
    assert message in capsys.readouterr().err
    assert not (tmp_path / "package").exists()


@pytest.mark.parametrize("spdx", ["Apache-2.0", "BSD-2-Clause", "BSD-3-Clause"])
def test_the_text_of_the_license_comes_along(tmp_path: Path, spdx: str) -> None:
    package = written(tmp_path, "--license", spdx, "--maintainer", "Ada & L. <ada@example.org>")
    text = (package / "LICENSE").read_text("utf-8")
    assert f'<license file="LICENSE">{spdx}</license>' in (package / "package.xml").read_text("utf-8")
    if spdx == "Apache-2.0":
        assert text == (ROOT / "LICENSE").read_text("utf-8")
        return
    assert "\nCopyright (c) Ada & L.\n" in text
    assert ("Neither the name" in text) is (spdx == "BSD-3-Clause")
    assert ("2. Redistributions in binary form" in text) is spdx.startswith("BSD")


def test_a_license_without_a_text_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    package = written(tmp_path, "--license", "GPL-3.0-only")
    message = "there is no LICENSE in the package: the tool does not carry the text of GPL-3.0-only"
    help = f"put the text of the license into {package}/LICENSE; it stays there"
    assert f"note[package-license]: {message}\n    {help}\n" in capsys.readouterr().err
    assert not (package / "LICENSE").exists()
    assert "<license>GPL" in (package / "package.xml").read_text("utf-8")
    (package / "LICENSE").write_text("GNU GENERAL PUBLIC LICENSE\n")
    written(tmp_path)
    assert "package-license" not in capsys.readouterr().err
    assert '<license file="LICENSE">GPL-3.0-only</license>' in (package / "package.xml").read_text("utf-8")
    assert (package / "LICENSE").read_text() == "GNU GENERAL PUBLIC LICENSE\n"


def test_changelog_and_license_belong_to_people_once_they_wrote_in_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    package = written(tmp_path, "--license", "MIT")
    heading = "Changelog for package rosorin_description"
    text = (package / "CHANGELOG.rst").read_text("utf-8")
    assert text.startswith(f"{'^' * len(heading)}\n{heading}\n{'^' * len(heading)}\n\nForthcoming\n-----------\n* ")
    # As we wrote them, they follow what is said.
    written(tmp_path, "--license", "BSD-2-Clause", "--name", "other")
    assert "Changelog for package other\n" in (package / "CHANGELOG.rst").read_text("utf-8")
    assert (package / "LICENSE").read_text("utf-8").startswith("BSD 2-Clause License")
    mine = {"CHANGELOG.rst": f"{text}* a wheel of mine\n", "LICENSE": "Copyright (c) 2026 me\n"}
    for name, words in mine.items():
        (package / name).write_text(words, "utf-8")
    capsys.readouterr()
    for words in ([], ["--license", "MIT", "--name", "third"]):
        written(tmp_path, *words)
        assert "kept" not in capsys.readouterr().err
        assert {name: (package / name).read_text("utf-8") for name in mine} == mine
    assert not list(package.rglob("*.kept*"))


@pytest.mark.parametrize("name", ["package.xml", "README.md", "urdf/rosorin.urdf"])
def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "package"
    (target / name).parent.mkdir(parents=True)
    (target / name).write_text("mine\n")
    assert main(["package", str(ROSORIN), "-o", str(target)]) == 1
    help = "name a new folder; rosorin-compile deploy puts the artifacts into a package that you have"
    message = f"error[package-exists]: {target} has a {name} that this tool did not make\n    {help}\n"
    assert message in capsys.readouterr().err
    assert names_in(target) == [name]
    assert (target / name).read_text() == "mine\n"


def test_what_was_said_once_holds_the_next_time(tmp_path: Path) -> None:
    words = ["--maintainer", "Ada & L. <ada@example.org>", "--license", "MIT", "--package-version", "1.2.3"]
    words += ["--url", "https://example.org/a?b=1&c=2"]
    words += ["--name", "mine", "--build-type", "ament_python"]
    package = written(tmp_path, *words)
    before = {name: (package / name).read_bytes() for name in names_in(package)}
    written(tmp_path)
    assert {name: (package / name).read_bytes() for name in names_in(package)} == before
    written(tmp_path, "--package-version", "1.3.0")
    text = (package / "package.xml").read_text("utf-8")
    assert "<version>1.3.0</version>" in text
    assert '<maintainer email="ada@example.org">Ada &amp; L.</maintainer>' in text
    assert '<url type="website">https://example.org/a?b=1&amp;c=2</url>' in text


@pytest.mark.slow
def test_same_bytes_in_another_process(tmp_path: Path) -> None:
    here = written(tmp_path)
    there = tmp_path / "there"
    environment = {**os.environ, "PYTHONHASHSEED": "7", "LC_ALL": "C", "TZ": "Asia/Tokyo"}
    command = [sys.executable, "-m", "rosorin_compile", "package", str(ROSORIN), "-o", str(there)]
    subprocess.run(command, env=environment, check=True, capture_output=True)
    assert {n: (there / n).read_bytes() for n in names_in(there)} == {
        n: (here / n).read_bytes() for n in names_in(here)
    }


@pytest.mark.parametrize("folder", EXAMPLES, ids=lambda folder: folder.name)
def test_the_fixed_frame_is_the_root_of_the_urdf(tmp_path: Path, folder: Path) -> None:
    assert main(["package", str(folder), "-o", str(tmp_path / "package")]) == 0
    (view,) = (tmp_path / "package/rviz").iterdir()
    frame = yaml.safe_load(view.read_text("utf-8"))["Visualization Manager"]["Global Options"]["Fixed Frame"]
    tree = ET.parse(next((tmp_path / "package/urdf").iterdir()))
    children = {element.get("link") for element in tree.iter("child")}
    assert [link.get("name") for link in tree.getroot().findall("link") if link.get("name") not in children] == [frame]


WITH_MJCF = data_text("robots/package_with_mjcf.yaml")
ARM = """\
links: {arm: {visual: [{mesh: {file: arm.stl}}]}}
joints: {arm_joint: {type: fixed, parent: base_link, child: arm}}
"""


def meshed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Describe a robot with meshes beside the description, beside an included file, and in another package."""
    path = describe(tmp_path, WITH_MJCF)
    faces = ((0, 0, 0, 1, 0, 0, 0, 1, 0), (0, 0, 0, 0, 1, 0, 0, 0, 1), (0, 0, 0, 0, 0, 1, 1, 0, 0))
    data = b"".join(struct.pack("<12fH", 0, 0, 0, *face, 0) for face in (*faces, (1, 0, 0, 0, 0, 1, 0, 1, 0)))
    (path.parent / "more").mkdir()
    (path.parent / "more/arm.yaml").write_text(ARM)
    for place in ("meshes/body.stl", "more/arm.stl", "../../other/meshes/wheel.stl"):
        (path.parent / place).parent.mkdir(parents=True, exist_ok=True)
        (path.parent / place).write_bytes(place.encode().ljust(80) + struct.pack("<I", 4) + data)
    monkeypatch.chdir(tmp_path)
    for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(variable, raising=False)
    return path


def test_the_mjcf_of_a_package_has_its_meshes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, package = meshed(tmp_path, monkeypatch), tmp_path / "package"
    more = ["--package", f"other_robot={tmp_path / 'other'}"]
    assert main(["package", str(path), "-o", str(package), *more]) == 0
    said = capsys.readouterr().err
    assert "package-mesh" not in said
    assert "mesh-not-found" not in said
    assert [name for name in names_in(package) if name.endswith(".stl")] == [
        "meshes/arm.stl",
        "meshes/body.stl",
        "mjcf/arm.stl",
        "mjcf/meshes/body.stl",
        "mjcf/meshes/other_robot/meshes/wheel.stl",
    ]
    assert (package / "meshes/arm.stl").read_bytes() == (path.parent / "more/arm.stl").read_bytes()
    assert main(["check", "deployed", str(path), str(package), *more]) == 0
    capsys.readouterr()
    model = pytest.importorskip("mujoco").MjModel.from_xml_path(str(package / "mjcf/meshed.xml"))
    assert model.nmesh == 3


def test_a_deployed_mjcf_without_its_meshes_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, there = meshed(tmp_path, monkeypatch), tmp_path / "there"
    there.mkdir()
    assert main(["deploy", str(path), "-o", str(there), "--map", "mjcf=mjcf/"]) == 0
    said = capsys.readouterr().err
    assert "warning[mesh-not-found]: mesh package://other_robot/meshes/wheel.stl is not found: " in said
    names = "meshes/body.stl, arm.stl"
    what = f"2 files are named by mjcf/meshed.xml, but not in the package: {names}"
    assert f"warning[package-mesh]: {what}\n    put the files into mjcf/ of the package\n" in said
    for name in ("mjcf/meshes/body.stl", "mjcf/arm.stl"):
        (there / name).parent.mkdir(exist_ok=True)
        (there / name).write_bytes(b"there")
    assert main(["deploy", str(path), "-o", str(there)]) == 0
    assert "package-mesh" not in capsys.readouterr().err
    assert main(["check", "deployed", str(path), str(there)]) == 0

"""Whether what is deployed gets to the robot: setup.py, CMakeLists.txt, package.xml, install spaces."""

import shutil
from pathlib import Path

import pytest

from rosorin_compile.output.ros_packages import missing, undeclared
from support.packages import deploy, package_of_people


@pytest.fixture
def base(tmp_path: Path) -> Path:
    return package_of_people(tmp_path)


def test_what_setup_py_forgets_is_told(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deploy(base)
    said = capsys.readouterr().err
    assert "warning[deploy-not-installed]: setup.py of rosorin_base does not install urdf/rosorin.urdf\n" in said
    assert "    add: ('share/rosorin_base/urdf', ['urdf/rosorin.urdf']),\n" in said
    assert "does not install config/robot_model.json" not in said
    assert "does not install launch/static_tf.launch.py" not in said
    text = (base / "setup.py").read_text("utf-8")
    added = "    ('share/rosorin_base/urdf', ['urdf/rosorin.urdf']),\n"
    for folder in ("config/*.json", "config/*.yaml", "sdf/*", "srdf/*"):
        added += f"    ('share/rosorin_base/{folder.partition('/')[0]}', glob('{folder}')),\n"
    (base / "setup.py").write_text(text.replace("])\n", f"{added}])\n"), "utf-8")
    deploy(base)
    assert "deploy-not-installed" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "is_installed"),
    [
        ("install(DIRECTORY urdf launch DESTINATION share/${PROJECT_NAME})", True),
        ("install(\n  DIRECTORY urdf/\n  DESTINATION share/${PROJECT_NAME}/urdf\n)", True),
        ("install(FILES urdf/rosorin.urdf DESTINATION share/${PROJECT_NAME}/urdf)", True),
        ("install(FILES urdf/other.urdf DESTINATION share/${PROJECT_NAME}/urdf)", False),
        ("install(DIRECTORY launch config DESTINATION share/${PROJECT_NAME})", False),
        ("ament_auto_package(INSTALL_TO_SHARE\n  launch urdf)", True),
        ("ament_auto_package(INSTALL_TO_SHARE launch)", False),
        ("# install(DIRECTORY urdf DESTINATION share/${PROJECT_NAME})", False),
        ("foreach(f urdf)\n install(DIRECTORY ${f} DESTINATION share/${PROJECT_NAME})\nendforeach()", True),
        ("", False),
    ],
)
def test_what_cmake_installs(tmp_path: Path, text: str, is_installed: bool) -> None:
    (tmp_path / "CMakeLists.txt").write_text(text)
    found = list(missing(tmp_path, "p", ["urdf/rosorin.urdf"]))
    assert found == [] if is_installed else len(found) == 1
    if found:
        assert found[0][1] == ("CMakeLists.txt", "install(DIRECTORY urdf DESTINATION share/${PROJECT_NAME})")


@pytest.mark.parametrize(
    ("text", "is_installed"),
    [
        ("data_files=[('share/p/urdf', ['urdf/rosorin.urdf'])]", True),
        ("data_files=[('share/p/urdf', glob('urdf/*'))]", True),
        ("data_files=[('share/p/urdf', glob(os.path.join('urdf', '*.urdf')))]", True),
        ("name = 'rosorin'\ndata_files=[('share/p/urdf', [f'urdf/{name}.urdf'])]", True),
        ("data_files=[('share/p/urdf', glob('launch/*.urdf'))]", False),
        ("data_files=[('share/p/urdf', glob(os.path.join('launch', '*.urdf')))]", False),
        ("data_files=[('share/p/urdf', glob('*'))]", False),
        ("[str(p) for p in Path('urdf').rglob('*')]", True),
    ],
)
def test_what_setup_py_installs(tmp_path: Path, text: str, is_installed: bool) -> None:
    (tmp_path / "setup.py").write_text(text)
    assert (list(missing(tmp_path, "p", ["urdf/rosorin.urdf"])) == []) is is_installed


def test_dependencies_of_launch_files(tmp_path: Path) -> None:
    (tmp_path / "package.xml").write_text("<package><depend>tf2_ros</depend></package>")
    assert undeclared(tmp_path, ["Node(package='tf2_ros'", "Node(package='robot_state_publisher'"]) == [
        "robot_state_publisher"
    ]


def test_an_install_space_beside_that_is_older(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    share = base.parent.parent / "install/rosorin_base/share/rosorin_base"
    shutil.copytree(base, share)
    assert deploy(base) == 0
    said = capsys.readouterr().err
    message = f"{share} is what runs, and it is not what was deployed: "
    told = said.partition(f"warning[deploy-not-built]: {message}")[2]
    assert {"launch/static_tf.launch.py (missing)", "urdf/rosorin.urdf (older)"} <= set(
        told.splitlines()[0].split(", ")
    )
    assert told.splitlines()[1].startswith("    colcon build --packages-select rosorin_base;")
    shutil.rmtree(share)
    shutil.copytree(base, share)
    deploy(base, "--install", str(base.parent.parent / "install"))
    assert "deploy-not-built" not in capsys.readouterr().err
    assert deploy(base, "--install", str(base.parent)) == 1
    assert "error[deploy-no-install]: there is no package rosorin_base in " in capsys.readouterr().err


def test_an_install_space_is_not_the_place_to_deploy_to(base: Path, capsys: pytest.CaptureFixture[str]) -> None:
    share = base.parent.parent / "install/rosorin_base/share/rosorin_base"
    shutil.copytree(base, share)
    deploy(share)
    assert "warning[deploy-install-space]: " in capsys.readouterr().err

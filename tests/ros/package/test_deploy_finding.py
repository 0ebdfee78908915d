"""Finding copies: folders behind links, and files that are there for another robot."""

from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.output import MANIFEST
from rosorin_compile.output.ros_packages import files_below
from support.paths import ROSORIN
from support.robots import compiled, texts

TEXTS = texts(compiled())
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
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "base"
    folder.mkdir()
    assert main(["deploy", str(ROSORIN), "-o", str(folder)]) == 0
    return folder


def contents(folder: Path) -> dict[str, str]:
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != MANIFEST]
    return {path.relative_to(folder).as_posix(): path.read_text("utf-8") for path in files}


@pytest.mark.parametrize("name", ["other", '"its a robot"', "two--hyphens", "ä/b"])
def test_another_robot_is_not_written_over(
    package: Path, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "other.yaml"
    path.write_text(OTHER.format(name=name), "utf-8")
    before = contents(package)
    capsys.readouterr()
    assert main(["deploy", str(path), "-o", str(package)]) == 1
    said = capsys.readouterr().err
    assert "error[deploy-other-robot]: launch/static_tf.launch.py is there for the robot rosorin, not for " in said
    assert "    say --map static_tf=PLACE (none for nowhere)\n" in said
    assert "error[deploy-other-robot]: config/static_tf.json is there for the robot rosorin, not for " in said
    assert contents(package) == before
    words = ["--map", "static_tf=launch/other.launch.py", "--map", "static_tf_json=config/other.json"]
    assert main(["deploy", str(path), "-o", str(package), *words]) == 0
    assert {file: text for file, text in contents(package).items() if file in before} == before
    assert main(["deploy", str(path), "-o", str(package)]) == 0, "its own files are no other robot's"
    assert main(["check", "deployed", str(ROSORIN), str(package)]) == 0


def test_a_place_that_is_told_is_written_over(package: Path, tmp_path: Path) -> None:
    path = tmp_path / "other.yaml"
    path.write_text(OTHER.format(name="other"), "utf-8")
    words = ["--map", "static_tf=launch/static_tf.launch.py", "--map", "static_tf_json=none"]
    assert main(["deploy", str(path), "-o", str(package), *words]) == 0
    assert "'other'" in (package / "launch/static_tf.launch.py").read_text("utf-8")


def test_check_looks_behind_links(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    there = package.parent / "elsewhere"
    (package / "urdf").rename(there)
    (package / "urdf").symlink_to(there)
    assert main(["check", "deployed", str(ROSORIN), str(package)]) == 0
    (there / "rosorin.urdf").write_text(TEXTS["rosorin.urdf"].replace("0.16044", "0.17044"), "utf-8")
    capsys.readouterr()
    assert main(["check", "deployed", str(ROSORIN), str(package)]) == 1
    assert (
        "urdf/rosorin.urdf: link1 moved 10.0 mm in base_link: origin z 0.17044 -> 0.16044 m\n"
        in capsys.readouterr().out
    )


def test_links_in_a_circle_end(package: Path) -> None:
    (package / "urdf/again").symlink_to(package)
    (package / "config/above").symlink_to(package.parent)
    (package / "config/beside").symlink_to(package / "urdf")
    found = [*contents(package), MANIFEST]
    assert files_below(package, skip_built=False) == sorted(found)
    assert main(["check", "deployed", str(ROSORIN), str(package)]) == 0

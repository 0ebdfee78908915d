"""import --into: a description beside the xacro of a package, a test of both, and the lines to change."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.colcon import NEEDS_CMAKE, NEEDS_COLCON, colcon
from support.paths import data_text

BIN = Path(sys.executable).parent

URDF = data_text("robots/import_into_urdf.urdf")
XACRO = data_text("robots/import_into_xacro.xacro")
MANIFEST = """\
<package format="3">
  <name>cart_description</name><version>0.1.0</version><description>d</description>
  <maintainer email="a@b.org">m</maintainer><license>MIT</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <export><build_type>BUILD</build_type></export>
</package>
"""
CMAKE = """\
cmake_minimum_required(VERSION 3.8)
project(cart_description NONE)
find_package(ament_cmake REQUIRED)
install(DIRECTORY urdf DESTINATION share/${PROJECT_NAME})
ament_package()
"""
SETUP = """\
from setuptools import setup
setup(name='cart_description', version='0.1.0', packages=[], data_files=[
    ('share/ament_index/resource_index/packages', ['resource/cart_description']),
    ('share/cart_description', ['package.xml']),
])
"""
TEST = "test/test_cart_description.py"
RECORD = "descriptions/cart/robot.yaml.imported"


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "src" / "cart_description"
    (folder / "urdf").mkdir(parents=True)
    (folder / "urdf" / "cart.urdf").write_text(URDF)
    (folder / "package.xml").write_text(MANIFEST.replace("BUILD", "ament_cmake"))
    (folder / "CMakeLists.txt").write_text(CMAKE)
    return folder


def run(*words: object) -> int:
    """Run the command; return its exit code."""
    return main(["import", *map(str, words)])


def into(package: Path, *words: object) -> int:
    return run(package / "urdf" / "cart.urdf", "--into", package, *words)


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def tried(package: Path, fails: bool = False) -> str:
    """Run the test that was written as people run it; return what it says."""
    words = [sys.executable, "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", str(package / "test")]
    own = {"PYTHONDONTWRITEBYTECODE": "1", "PYTEST_DEBUG_TEMPROOT": str(package.parent)}
    environment = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}", **own}
    done = subprocess.run(words, cwd=package, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode != 0) == fails, done.stdout + done.stderr
    return done.stdout


def test_a_package_gets_a_description_and_a_test_and_keeps_the_rest(
    package: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = files(package)
    assert into(package) == 0
    after = files(package)
    assert {name: after[name] for name in before} == before
    assert sorted(after.keys() - before.keys()) == ["descriptions/cart/robot.yaml", RECORD, TEST]
    told = capsys.readouterr().out
    assert "descriptions/cart: 2 links, 1 joint in robot.yaml\n" in told
    assert f"{TEST} compares both" in told
    assert "  install(DIRECTORY descriptions DESTINATION share/${PROJECT_NAME})\n  if(BUILD_TESTING)\n" in told
    assert f"    ament_add_pytest_test(test_cart_description {TEST})\n" in told
    assert "  <test_depend>ament_cmake_pytest</test_depend>\n" in told
    assert "instead of cart.urdf in launch files: rosorin-compile print descriptions/cart/robot.yaml urdf" in told


def test_the_test_that_is_written_passes(package: Path) -> None:
    assert into(package) == 0
    tried(package)


@pytest.mark.tier("builds")
@pytest.mark.slow
def test_the_test_holds_both_until_the_source_is_gone(package: Path) -> None:
    assert into(package) == 0
    urdf, description = package / "urdf" / "cart.urdf", package / "descriptions" / "cart" / "robot.yaml"
    urdf.write_text(URDF.replace("0 0 0.2", "0 0 0.3"))
    assert "laser moved 100 mm" in tried(package, fails=True).replace("100.0 mm", "100 mm")
    description.write_text(description.read_text().replace("[0, 0, 0.2]", "[0, 0, 0.3]"))
    tried(package)
    urdf.unlink()
    assert "is gone: remove this test, and what names it in CMakeLists.txt and package.xml" in " ".join(
        tried(package).split()
    )


def test_a_second_time_nothing_changes_and_lines_that_are_there_are_not_told(
    package: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert into(package) == 0
    lines = [
        "install(DIRECTORY descriptions DESTINATION share/${PROJECT_NAME})",
        "find_package(ament_cmake_pytest REQUIRED)",
    ]
    lines += [f"ament_add_pytest_test(test_cart_description {TEST})", "ament_package()"]
    (package / "CMakeLists.txt").write_text(CMAKE.replace("ament_package()", "\n".join(lines)))
    depends = "<test_depend>ament_cmake_pytest</test_depend><export>"
    (package / "package.xml").write_text((package / "package.xml").read_text().replace("<export>", depends))
    before = files(package)
    capsys.readouterr()
    assert into(package) == 0
    told = capsys.readouterr().out
    assert files(package) == before
    assert "unchanged\n" in told
    assert "add to" not in told


def test_changes_of_your_own_stay(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert into(package) == 0
    mine = package / "descriptions" / "cart" / "robot.yaml"
    mine.write_text(f"{mine.read_text()}# mine\n")
    (package / TEST).write_text("# mine, too\n")
    before = files(package)
    capsys.readouterr()
    assert into(package) == 0
    told = capsys.readouterr().out
    assert files(package) == before
    assert "cart.urdf is as it was when it was imported before" in told
    assert f"{TEST} was edited and may compare something else" in told
    assert "compares both" not in told


def refused(package: Path, capsys: pytest.CaptureFixture[str], *words: object) -> str:
    """Import what is refused; return what is said, in one line. Nothing may change."""
    before = files(package)
    capsys.readouterr()
    assert run(*words, "--into", package) == 2
    assert files(package) == before
    return wrong(capsys)


OTHER = URDF.replace("0 0 0.2", "0 0 0.4")  # a robot of the same name


@pytest.mark.landing("builds", "urdf/other/cart.urdf")
@pytest.mark.slow
@pytest.mark.parametrize("place", ["urdf/other.urdf", "urdf/other/cart.urdf"])
def test_a_second_robot_of_the_same_name_is_refused_until_it_has_a_name_of_its_own(
    package: Path, capsys: pytest.CaptureFixture[str], place: str
) -> None:
    assert into(package) == 0
    other = package / place
    other.parent.mkdir(exist_ok=True)
    other.write_text(OTHER)
    said = refused(package, capsys, other)
    assert "descriptions/cart is of another import: rosorin-compile import urdf/cart.urdf; " in said
    assert f"this one is: {place};" in said
    assert "another robot with --name" in said
    assert run(other, "--into", package, "--name", "high") == 0
    assert "[0, 0, 0.4]" in (package / "descriptions" / "high" / "robot.yaml").read_text()
    tried(package)
    assert run(other, "--into", package, "--name", "high") == 0
    assert "unchanged\n" in capsys.readouterr().out


@pytest.mark.tier("builds")
@pytest.mark.slow
def test_a_source_with_other_arguments_is_another_robot(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("xacro")
    xacro = package / "urdf" / "cart.urdf.xacro"
    xacro.write_text(XACRO)
    assert run(xacro, "height:=0.25", "--into", package, "--trust") == 0
    assert run(xacro, "height:=0.25", "--into", package, "--trust") == 0
    assert "unchanged\n" in capsys.readouterr().out
    said = refused(package, capsys, xacro, "height:=0.3", "--trust")
    assert "import urdf/cart.urdf.xacro height:=0.25; this one is: urdf/cart.urdf.xacro height:=0.3;" in said
    assert "height:=0.25; this one is: urdf/cart.urdf.xacro;" in refused(package, capsys, xacro, "--trust")


@pytest.mark.slow
def test_what_the_source_was_given_stands_in_the_test(package: Path) -> None:
    pytest.importorskip("xacro")
    (package / "urdf" / "cart.urdf").unlink()
    (package / "urdf" / "cart.urdf.xacro").write_text(XACRO)
    assert run(package / "urdf" / "cart.urdf.xacro", "height:=0.25", "--into", package, "--trust") == 0
    assert "OF_THE_SOURCE = {'height': '0.25'}\n" in (package / TEST).read_text()
    tried(package)


def test_a_package_of_python_is_told_its_own_lines(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (package / "CMakeLists.txt").unlink()
    (package / "setup.py").write_text(SETUP)
    (package / "package.xml").write_text(MANIFEST.replace("BUILD", "ament_python"))
    assert into(package) == 0
    told = capsys.readouterr().out
    assert "  ('share/cart_description/descriptions/cart', ['descriptions/cart/robot.yaml']),\n" in told
    assert "  extras_require={'test': ['pytest']},\n" in told
    assert "  <test_depend>python3-pytest</test_depend>\n" in told
    assert "ament_add" not in told
    assert "in setup.py and package.xml" in (package / TEST).read_text()


def wrong(capsys: pytest.CaptureFixture[str]) -> str:
    return " ".join(capsys.readouterr().err.split())


def test_what_is_no_package_is_refused(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    urdf = package / "urdf" / "cart.urdf"
    for words, message in (
        ((urdf, "--into", package / "urdf"), f"no package.xml with a name; did you mean {package}?"),
        ((urdf, "--into", package.parent), "rosorin-compile package ROBOT"),
        ((urdf, "--into", package / "nowhere"), "is no folder; --into names the folder of a ROS package"),
        ((urdf, "--into", package, "-o", "x"), "leave -o out"),
    ):
        assert run(*words) == 2
        assert message in wrong(capsys)
    other = package.parent / "other"
    other.mkdir()
    (other / "package.xml").write_text("<package><name>other</name></package>")
    assert run(urdf, "--into", other) == 2
    assert "its package.xml has no build type" in wrong(capsys)
    (other / "package.xml").write_text(MANIFEST.replace("cart_", "other_").replace("BUILD", "cmake"))
    assert run(urdf, "--into", other) == 2
    assert 'its build type is "cmake"; only those two are supported' in wrong(capsys)
    (other / "package.xml").write_text(MANIFEST.replace("cart_", "other_").replace("BUILD", "ament_cmake"))
    assert run(urdf, "--into", other) == 2
    assert f"it is in package cart_description: --into {package}" in wrong(capsys)
    assert not (other / "descriptions").exists()


def test_nothing_is_written_through_a_link(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    elsewhere = package.parent / "elsewhere"
    elsewhere.mkdir()
    (package / "test").symlink_to(elsewhere)
    assert into(package) == 1
    assert "is a symbolic link" in capsys.readouterr().err
    assert not (package / "descriptions").exists()
    assert not list(elsewhere.iterdir())


# With the programs that build and test packages.


def told_lines(told: str, file: Path) -> list[str]:
    rest = told.partition(f"add to {file}, if it is not there:\n")[2]
    taken = []
    for line in rest.split("\n"):
        if not line.startswith("  "):
            break
        taken.append(line[2:])
    assert taken
    return taken


KINDS = ["ament_python", pytest.param("ament_cmake", marks=NEEDS_CMAKE)]


@pytest.mark.tier("builds")
@pytest.mark.slow
@NEEDS_COLCON
@pytest.mark.parametrize("kind", KINDS)
def test_colcon_installs_the_description_and_runs_the_test(
    package: Path, tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    build = package / ("setup.py" if kind == "ament_python" else "CMakeLists.txt")
    (package / "package.xml").write_text(MANIFEST.replace("BUILD", kind))
    if kind == "ament_python":
        (package / "CMakeLists.txt").unlink()
        build.write_text(SETUP)
        (package / "resource").mkdir()
        (package / "resource" / "cart_description").write_text("")
    assert into(package) == 0
    told = capsys.readouterr().out
    lines = told_lines(told, build)
    if kind == "ament_python":
        row, extra = lines
        build.write_text(build.read_text().replace("])\n", f"{row}\n], {extra})\n"))
    else:
        build.write_text(build.read_text().replace("ament_package()", "\n".join([*lines, "ament_package()"])))
    manifest = package / "package.xml"
    needs = "\n".join(told_lines(told, manifest))
    manifest.write_text(manifest.read_text().replace("<export>", f"{needs}\n<export>"))
    assert "1 package finished" in colcon(tmp_path, "build")
    share = tmp_path / "install" / "cart_description" / "share" / "cart_description"
    assert (share / "descriptions" / "cart" / "robot.yaml").is_file()
    colcon(tmp_path, "test")
    assert "1 test, 0 errors, 0 failures, 0 skipped" in colcon(tmp_path, "test-result", "--all")
    (package / "urdf" / "cart.urdf").write_text(URDF.replace("0 0 0.2", "0 0 0.3"))
    colcon(tmp_path, "test")
    assert "1 test, 0 errors, 1 failure" in colcon(tmp_path, "test-result", "--all", fails=True)
    (package / "urdf" / "cart.urdf").unlink()
    (package / "urdf" / "keep").write_text("")
    colcon(tmp_path, "test")
    assert "1 test, 0 errors, 0 failures, 1 skipped" in colcon(tmp_path, "test-result", "--all")


@pytest.mark.slow
def test_a_newer_state_is_merged_into_the_package(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert into(package) == 0
    mine = package / "descriptions" / "cart" / "robot.yaml"
    mine.write_text(mine.read_text().replace("mass: 2,", "mass: 3,"))
    (package / "urdf" / "cart.urdf").write_text(OTHER)
    assert into(package) == 0
    said = capsys.readouterr().out
    assert "descriptions/cart: written: robot.yaml\nchanges of the newer cart.urdf: robot.yaml\n" in said
    assert "[0, 0, 0.4]" in mine.read_text()
    assert "mass: 3," in mine.read_text()
    (package / "urdf" / "cart.urdf").write_text(OTHER.replace('value="2"', 'value="4"'))
    assert into(package) == 1
    assert "error[import-conflict]" in capsys.readouterr().err
    assert "<<<<<<< edited here\n" in mine.read_text()
    for code, message in ((1, "error[yaml-syntax]"), (2, "no robot.yaml.imported there")):
        before = files(package)
        assert into(package) == code
        assert files(package) == before
        assert message in capsys.readouterr().err
        (package / RECORD).unlink(missing_ok=True)
    assert into(package, "--name", "other") == 0


def test_a_file_that_two_robots_include_is_written_once(package: Path) -> None:
    pytest.importorskip("xacro")
    head = '<robot name="NAME" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    macro = '<xacro:macro name="box" params="name size"><link name="${name}"><visual><geometry>'
    macro += '<box size="${size} 1 1"/></geometry></visual></link></xacro:macro>'
    (package / "urdf" / "box.xacro").write_text(f"{head}{macro}</robot>")
    call = '<xacro:include filename="box.xacro"/><xacro:box name="base" size="2"/>'
    for name in ("two", "four", "two"):
        source = package / "urdf" / f"{name}.urdf.xacro"
        source.write_text(f"{head.replace('NAME', name)}{call}</robot>")
        assert run(source, "--into", package, "--trust") == 0
    descriptions = package / "descriptions"
    assert [path.parent.name for path in descriptions.rglob("box.yaml")] == ["two"]
    assert "include: [../two/box.yaml]" in (descriptions / "four" / "robot.yaml").read_text()
    assert main(["all", str(descriptions / "four"), "-o", str(package.parent / "outputs")]) == 0

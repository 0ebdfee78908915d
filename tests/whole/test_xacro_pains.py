"""What people complain of in xacro (survey, 2026-11), each with a test that it is no complaint here.

1 no line numbers, 2 typos pass, 3 types, 4 speed, 5 eval, 6 number formatting, 7 bound to ROS, 8 versions drift,
9 those who read plain URDF ask for the expanded file.
"""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats.compiled import Compiled, compile_robot
from rosorin_compile.source.diagnostics import ERROR, Diagnostic
from rosorin_compile.source.diagnostics import text as report
from support.paths import data_text

HEAD = "rosorin_compile: 1\nrobot: r\noutputs: {urdf: {file: r.urdf, number_format: exact}}\n"

Make = Callable[..., Compiled]


@pytest.fixture
def make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Make:
    monkeypatch.chdir(tmp_path)

    def make_robot(robot: str, arguments: dict[str, str] | None = None, **files: str) -> Compiled:
        for name, text in files.items():
            path = Path(f"{name}.yaml")
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, "utf-8")
        Path("robot.yaml").write_text(HEAD + robot, "utf-8")
        return compile_robot(Path("robot.yaml"), arguments)

    return make_robot


def urdf(made: Compiled) -> str:
    assert made.artifacts, report(made.diagnostics)
    return made.artifacts[0].text


def errors(made: Compiled) -> list[Diagnostic]:
    return [found for found in made.diagnostics if found.severity == ERROR]


# 1. Every error has file, line and column, and the way there (ros/xacro#33, #61, #75, #236, #267, #344).


def test_error_has_its_place_and_the_way_there(make: Make) -> None:
    made = make(
        "include: [arm.yaml]\nlinks: {base: {}}\n",
        arm="include: [parts/joints.yaml]\nuse:\n  arm: {part: arm, parent: base}\n",
        **{
            "parts/joints": """
parts:
  segment:
    params: {length: {type: length}}
    links: {segment: {}}
    joints: {joint: {type: fixed, parent: mount, child: segment, xyz: [0, 0, "${2 * lenght}"]}}
  arm:
    use:
      "s${i}": {for: {i: "${range(2)}"}, part: segment, parent: mount, with: {length: 0.2}}
"""
        },
    )
    (found,) = errors(made)
    spans = [one.span for one in (found, *found.related)]
    assert found.rule == "expression"
    assert '"length"' in found.help
    assert [span and f"{span.source.path}:{span.line}:{span.column}" for span in spans] == [
        "parts/joints.yaml:6:85",
        "parts/joints.yaml:9:87",
        "parts/joints.yaml:9:7",
        "parts/joints.yaml:9:26",
        "arm.yaml:3:3",
        "robot.yaml:4:11",
    ]


# 2. Typos are errors.


# 3. Values have types, from the command line too (ros/xacro#22, #128, #176, #321).


# 4. Time grows with the robot, no faster (ros/xacro#57, #292); the benchmarks have the seconds.


@pytest.mark.slow
def test_work_grows_with_the_number_of_uses(make: Make) -> None:
    robot = data_text("robots/xacro_pains_peg.yaml")
    make(robot.replace("COUNT", "100"))  # the first run fills caches
    calls = {count: _calls(lambda count=count: make(robot.replace("COUNT", str(count)))) for count in (100, 200, 400)}
    first, second = calls[200] - calls[100], calls[400] - calls[200]
    assert second < 2.2 * first, f"twice the uses take {second / first:.2f} times the calls"
    assert first / 100 < 2_600, f"{first / 100:.0f} calls for a use"


def _calls(work: Callable[[], Compiled]) -> int:
    count = 0

    def watch(_frame: Any, event: str, _argument: Any) -> None:
        nonlocal count
        count += event == "call"

    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        made = work()
    finally:
        sys.setprofile(before)
    assert made.artifacts, report(made.diagnostics)
    return count


# 5. Expressions reach nothing but values, and end: test_xacro_escapes.py.


# 6. Numbers are printed in one form, however they were written (ros-controls/ros2_control_demos#1021).


@pytest.mark.parametrize(
    ("written", "exact", "six"),
    [
        ("${0.1 + 0.2}", "0.30000000000000004", "0.3"),
        ("1e-7", "1e-07", "1e-07"),
        ("0.0000001", "1e-07", "1e-07"),
        ("0.10", "0.1", "0.1"),
        ("1e-1", "0.1", "0.1"),
        ("10 cm", "0.1", "0.1"),
        ("100.0 mm", "0.1", "0.1"),
        ("${1/3}", "0.3333333333333333", "0.333333"),
        ("${-0.0}", "0", "0"),
        ("2.0", "2", "2"),
    ],
)
def test_number_is_printed_in_one_form(make: Make, written: str, exact: str, six: str) -> None:
    robot = "links: {a: {}, b: {}}\njoints: {j: {type: fixed, parent: a, child: b, xyz: ['0', 0, 0]}}\n"
    robot = robot.replace("'0'", f'"{written}"' if "$" in written else written)
    assert f'xyz="{exact} 0 0"' in urdf(make(robot))
    Path("robot.yaml").write_text((HEAD + robot).replace("exact", "six"), "utf-8")
    assert f'xyz="{six} 0 0"' in urdf(compile_robot(Path("robot.yaml")))


# 7. No ROS (ros/xacro#197, #328, #329, #340).


EXTRAS = {"collada", "mujoco", "numpy", "pydrake", "rosbags", "scipy", "trimesh", "xacro"}
EXTRAS |= {"dask", "distributed"}
EXTRAS |= {"backports", "compression", "lz4"}  # what rosbags decompresses with


@pytest.mark.slow
def test_a_compilation_imports_no_extra(make: Make, tmp_path: Path) -> None:
    make("links: {base: {}}\n")
    program = """
import sys
from rosorin_compile.cli.main import main
assert main(["all", "robot.yaml"]) == 0
print(*sorted({name.partition(".")[0] for name in sys.modules}))
"""
    ran = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert not set(ran.stdout.splitlines()[-1].split()) & EXTRAS


def test_robot_compiles_where_there_is_no_ros(make: Make, tmp_path: Path) -> None:
    made = urdf(make("links: {base: {}}\n"))
    program = """
import sys
class NoRos:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("rclpy", "ament_index_python", "launch", "launch_ros", "xacro", "rospkg"):
            raise ImportError(name)
sys.meta_path.insert(0, NoRos())
from pathlib import Path
from rosorin_compile.formats.compiled import compile_robot
print(compile_robot(Path("robot.yaml")).artifacts[0].text, end="")
"""
    environment = {"PYTHONPATH": ":".join(path for path in sys.path if path)}
    options = {"env": environment, "check": True, "capture_output": True, "text": True}
    ran = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, **options)
    assert ran.stdout == made


# 8. A description says the version of the language (ros/xacro#315, fmauch/universal_robot#19).


@pytest.mark.parametrize("version", ["2", "0", "1.1", "'1'", "latest"])
def test_other_version_is_refused(make: Make, version: str) -> None:
    made = make("links: {base: {}}\n")
    assert made.artifacts
    text = (HEAD + "links: {base: {}}\n").replace("rosorin_compile: 1", f"rosorin_compile: {version}")
    Path("robot.yaml").write_text(text, "utf-8")
    (found,) = errors(compile_robot(Path("robot.yaml")))
    assert (found.rule, found.span.line if found.span else 0) == ("wrong-value", 1)


# 9. Plain URDF comes out, the same every time (pollen-robotics/reachy2_core#104, gkjohnson/xacro-parser#75).

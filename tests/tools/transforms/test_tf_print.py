"""The answer is that of tf2 to the letter: C++ with the headers of tf2 composes and prints the same transforms.

The first program needs a compiler only: it prints numbers with the settings of the stream of tf2_echo. The second is
built on the linear algebra of tf2 itself (package libtf2-dev, or TF2_INCLUDE=folder): the buffer's way of keeping an
edge, its composition, and what tf2_echo prints. Both are written here, from what the code of tf2 does.
"""

import math
import os
import shutil
import struct
import subprocess
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.tf import _echo
from rosorin_compile.model import Joint, Link, Pose, Robot
from rosorin_compile.model.kinematics import Graph
from rosorin_compile.transforms import FrameTransform, lookup
from support.paths import DATA

pytestmark = pytest.mark.slow

COMPILER = shutil.which("g++")
TF2 = Path(os.environ.get("TF2_INCLUDE", "/usr/include"))
HAS_TF2 = (TF2 / "tf2" / "LinearMath" / "Matrix3x3.h").is_file()

STREAM = r"""
#include <cstdio>
#include <iomanip>
#include <iostream>
int main() {
  double value;
  std::cout.precision(3);
  std::cout.setf(std::ios::fixed, std::ios::floatfield);
  while (std::fread(&value, sizeof value, 1, stdin) == 1)
    std::cout << value << "|" << " " << std::setw(6) << std::setprecision(3) << value << std::endl;
}
"""

# Input, lines: the number of edges from SOURCE up, from TARGET up, whether each of the two has a parent; then an edge a
# line, from the bottom up: x y z roll pitch yaw, as hexadecimal floats.
TF2_ECHO = (DATA / "robots/tf2_echo.txt").read_text("utf-8")


def text(answer: FrameTransform) -> list[str]:
    return _echo(answer, 3, "humble")


def built(folder: Path, source: str, *flags: str) -> Path:
    (folder / "oracle.cpp").write_text(source, "utf-8")
    # Without -ffp-contract a compiler for another machine may fuse a product and a sum.
    command = [str(COMPILER), "-O1", "-w", "-ffp-contract=off", *flags, "oracle.cpp", "-o", "oracle"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=120)
    return folder / "oracle"


@pytest.fixture(scope="module")
def stream(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if COMPILER is None:
        pytest.skip("no g++ here")
    return built(tmp_path_factory.mktemp("stream"), STREAM)


@pytest.fixture(scope="module")
def tf2(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if COMPILER is None or not HAS_TF2:
        pytest.skip("no g++, or no headers of tf2 (libtf2-dev)")
    return built(tmp_path_factory.mktemp("tf2"), TF2_ECHO, f"-I{TF2}")


doubles = st.floats(allow_nan=False, width=64) | st.floats(-2, 2) | st.integers(-4000, 4000).map(lambda n: n / 2000)


@settings(max_examples=20, deadline=None)
@given(st.lists(doubles, min_size=20, max_size=200))
@example([0.0, -0.0, 0.0005, -0.0005, 0.0015, 0.0025, -0.00049999, 1e300, float("inf"), -1234.5678])
def test_numbers_are_printed_as_a_stream_of_cpp_prints_them(stream: Path, numbers: list[float]) -> None:
    said = subprocess.run([stream], input=struct.pack(f"{len(numbers)}d", *numbers), capture_output=True, check=True)
    assert said.stdout.decode().splitlines() == [f"{n:.3f}| {n:6.3f}" for n in numbers]


metres = st.sampled_from([0.0, 0.1, -0.1]) | st.floats(-2, 2)
angles = st.sampled_from([0.0, math.pi, -math.pi, math.pi / 2, -math.pi / 2, 3.14159265, 1.5707, -1.5708])
angles |= st.floats(-3.2, 3.2)
poses = st.builds(Pose, st.tuples(metres, metres, metres), st.tuples(angles, angles, angles))


def chain_of(robot: Robot, source: str, target: str) -> str:
    """The input for the program: a way between two frames of a robot whose joints are all fixed."""
    up, down = list(robot.chain(source)), list(robot.chain(target))
    while up and down and up[0] == down[0]:
        del up[0], down[0]
    parents = [frame in robot.joint_to for frame in (source, target)]
    lines = [f"{len(up)} {len(down)} {parents[0]:d} {parents[1]:d}"]
    for joint in (*reversed(up), *reversed(down)):
        lines.append(" ".join(float(value).hex() for value in (*joint.origin.xyz, *joint.origin.rpy)))
    return "\n".join(lines) + "\n"


@st.composite
def fixed_robots(draw: st.DrawFn) -> Robot:
    count = draw(st.integers(1, 6))
    joints = [Joint(f"j{i}", "fixed", f"l{draw(st.integers(0, i))}", f"l{i + 1}", draw(poses)) for i in range(count)]
    return Robot("made", tuple(Link(f"l{i}") for i in range(count + 1)), tuple(joints))


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_any_chain_is_answered_as_tf2_answers_it(tf2: Path, data: st.DataObject) -> None:
    robot = data.draw(fixed_robots())
    names = [link.name for link in robot.links]
    pairs = [(source, target) for source in names for target in names]
    asked = "".join(chain_of(robot, *pair) for pair in pairs)
    said = subprocess.run([tf2], input=asked, capture_output=True, check=True, text=True).stdout
    graph = Graph(robot)
    ours = [line for pair in pairs for line in text(lookup(graph, *pair, {}))]
    assert ours == said.splitlines()


@pytest.mark.parametrize("yaw", [0.0, 0.4, -3.0])
@pytest.mark.parametrize("pitch", [90.0, -90.0, 89.9999999, -89.99999])
def test_straight_up_and_down_the_angles_are_those_of_tf2(tf2: Path, pitch: float, yaw: float) -> None:
    """There an arc sine has half of the digits, and roll and yaw of tf2 may be off by degrees; ours are the same."""
    pose = Pose((0, 0, 0), (0.3, math.radians(pitch), yaw))
    robot = Robot("made", (Link("a"), Link("b")), (Joint("j", "fixed", "a", "b", pose),))
    said = subprocess.run([tf2], input=chain_of(robot, "a", "b"), capture_output=True, check=True, text=True)
    assert text(lookup(Graph(robot), "a", "b", {})) == said.stdout.splitlines()

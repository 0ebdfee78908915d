"""The answer is that of tf2: C++ with the headers of tf2 composes and prints the same transforms.

The program is built on the linear algebra of tf2 itself (package libtf2-dev, or TF2_INCLUDE=folder): the buffer's way
of keeping an edge, its composition, and what tf2_echo prints.
"""

import math
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.frames import tf2_echo_lines
from rosorin_compile.model import Joint, Link, Pose, Robot
from rosorin_compile.model.kinematics import Graph
from rosorin_compile.transforms import lookup
from support.paths import DATA
from support.robots import compiled

pytestmark = pytest.mark.slow

COMPILER = shutil.which("g++")
TF2 = Path(os.environ.get("TF2_INCLUDE", "/usr/include"))
HAS_TF2 = (TF2 / "tf2" / "LinearMath" / "Matrix3x3.h").is_file()


@pytest.fixture(scope="module")
def tf2(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if COMPILER is None or not HAS_TF2:
        pytest.skip("no g++, or no headers of tf2 (libtf2-dev)")
    folder = tmp_path_factory.mktemp("tf2")
    # Input, lines: the number of edges from SOURCE up, from TARGET up, whether each of the two has a parent; then an
    # edge a line, from the bottom up: x y z roll pitch yaw, as hexadecimal floats.
    (folder / "oracle.cpp").write_bytes((DATA / "robots/tf2_echo.txt").read_bytes())
    command = [COMPILER, "-O1", "-w", f"-I{TF2}", "oracle.cpp", "-o", "oracle"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=120)
    return folder / "oracle"


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


def same(tf2: Path, robot: Robot, source: str, target: str, *words: str) -> None:
    """Compare matrices: signs of zeros, and roll and yaw near straight up, depend on the last bit."""
    done = subprocess.run(
        [tf2, *words], input=chain_of(robot, source, target), capture_output=True, text=True, check=True
    )
    ours = tf2_echo_lines(lookup(Graph(robot), source, target, {}), 3, "humble")
    assert len(ours) == len(done.stdout.splitlines())
    for line, other in zip(ours[6:], done.stdout.splitlines()[6:], strict=True):
        assert [float(cell) for cell in line.split()] == pytest.approx(list(map(float, other.split())), abs=1.1e-3)


@pytest.mark.parametrize("words", [(), ("by_quaternion",)])
def test_any_chain_is_answered_as_tf2_answers_it(tf2: Path, words: tuple[str, ...]) -> None:
    @settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
    @given(fixed_robots(), st.data())
    def holds(robot: Robot, data: st.DataObject) -> None:
        names = [link.name for link in robot.links]
        same(tf2, robot, data.draw(st.sampled_from(names)), data.draw(st.sampled_from(names)), *words)

    holds()


def test_the_mounts_of_the_reference_robot_are_answered_as_tf2_answers_them(tf2: Path) -> None:
    robot = compiled().robot
    assert robot is not None
    for joint in robot.joints:
        if joint.type == "fixed" and joint.parent in ("base_link", "link5"):
            alone = Robot("made", (Link(joint.parent), Link(joint.child)), (joint,))
            same(tf2, alone, joint.parent, joint.child)
            same(tf2, alone, joint.child, joint.parent)

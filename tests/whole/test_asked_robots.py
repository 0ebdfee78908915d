"""Questions about robots in other formats (URDF, xacro, SDF, MJCF, JSON), and about planar and floating joints."""

import json
import math
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.model.geometry import Pose
from support import bags
from support.bags import judged
from support.commands import Shown, ask
from support.paths import ROOT
from support.robots import compiled, texts

pytestmark = pytest.mark.slow

XACRO = """<robot name="post" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="height" default="1"/>
  <link name="foot"/>
  <link name="head"/>
  <joint name="neck" type="fixed"><parent link="foot"/><child link="head"/><origin xyz="0 0 $(arg height)"/></joint>
</robot>
"""
IN_PACKAGE = """<robot name="tower" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="$(find posts)/post.xacro"/>
</robot>
"""
TABLE = """robot: table
publishers: {tracker: {about: a camera above the table}}
links: {top: {}, puck: {}, fly: {}}
joints:
  slide: {type: planar, parent: top, child: puck, xyz: [0, 0, 1 m], axis: [0, 0, 1], publisher: tracker}
  free: {type: floating, parent: top, child: fly, publisher: tracker}
outputs: {urdf: {file: table.urdf}}
"""


@pytest.fixture
def artifacts(tmp_path: Path) -> Path:
    for name, text in texts(compiled()).items():
        (tmp_path / name).write_text(text, "utf-8")
    return tmp_path


def test_packages_of_a_xacro(tmp_path: Path, capsys: Shown) -> None:
    (tmp_path / "made_elsewhere").mkdir()
    (tmp_path / "made_elsewhere" / "post.xacro").write_text(XACRO, "utf-8")
    robot = tmp_path / "tower.xacro"
    robot.write_text(IN_PACKAGE, "utf-8")
    words = ["tf", str(robot), "foot", "head", "height:=0.3"]
    assert "posts" in ask(capsys, *words, code=1)
    there = f"posts={tmp_path / 'made_elsewhere'}"
    assert json.loads(ask(capsys, *words, "--package", there, "--format", "json"))["result"]["translation"] == [
        0,
        0,
        0.3,
    ]
    assert "foot" in ask(capsys, "frames", str(robot), "--package", there)
    assert f'there is no folder "{tmp_path}/x"' in ask(capsys, *words, "--package", f"posts={tmp_path}/x", code=2)


@pytest.mark.parametrize("name", ["rosorin.urdf", "rosorin.xml", "robot_model.json"])
def test_tf_of_every_format(artifacts: Path, capsys: Shown, name: str) -> None:
    """Of each format the same answer as of the description that it was compiled from; MJCF in millionths."""
    words = ["base_link", "end_effector_link", "--joint", "joint2=30deg", "--joint", "joint3=-0.4"]
    words += ["--format", "json"]
    own = json.loads(ask(capsys, "tf", str(ROOT / "descriptions" / "rosorin"), *words))["result"]
    other = json.loads(ask(capsys, "tf", str(artifacts / name), *words))["result"]
    assert other["translation"] == pytest.approx(own["translation"], abs=1e-6)
    assert other["rpy"] == pytest.approx(own["rpy"], abs=1e-5)


def test_xacro_with_an_argument(tmp_path: Path, capsys: Shown) -> None:
    pytest.importorskip("xacro")
    file = tmp_path / "post.urdf.xacro"
    file.write_text(XACRO, "utf-8")
    assert main(["tf", str(file), "foot", "head", "height:=2.5"]) == 0
    shown = capsys.readouterr()
    assert "- Translation: [0.000, 0.000, 2.500]" in shown.out
    assert shown.err.count("xacro-runs-code") == 1


def test_verify_against_a_urdf(artifacts: Path, tmp_path: Path, capsys: Shown) -> None:
    """The URDF says nothing of what other nodes publish: their edges are no errors, and all others are compared."""
    bag = bags.bag(tmp_path / "bag")
    assert main(["verify", str(artifacts / "rosorin.urdf"), str(bag)]) == 0
    shown = capsys.readouterr()
    assert "link4 -> link5                        robot_state_publisher  /tf         120" in shown.out
    assert shown.out.rstrip().splitlines()[-1].startswith("rosorin: as described, 2 warnings (")
    assert "robot-description" not in shown.err
    other = bags.bag(tmp_path / "other", joint_offset={"joint1": 5.0})
    assert main(["verify", str(artifacts / "rosorin.urdf"), str(other)]) == 0
    assert "joint1 is beyond its limits" in capsys.readouterr().err
    assert not judged(bag).findings


@pytest.fixture
def table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "descriptions" / "table"
    folder.mkdir(parents=True)
    (folder / "robot.yaml").write_text(TABLE, "utf-8")
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("table")
def test_planar_and_floating_joints(capsys: Shown) -> None:
    found = json.loads(ask(capsys, "tf", "top", "puck", "--joint", "slide=10 cm, -0.2, 30deg", "--format", "json"))[
        "result"
    ]
    assert found["translation"] == pytest.approx([0.1, -0.2, 1.0])
    assert found["rpy_degrees"] == pytest.approx([0, 0, 30])
    assert found["positions"] == {"slide": [0.1, -0.2, math.radians(30)]}
    turned = Pose((1.0, 2.0, 3.0), (0.1, 0.2, 0.3)).transform()
    w, x, y, z = turned.quaternion()
    for text in ("1,2,3,0.1,0.2,0.3", f"1,2,3,{x},{y},{z},{w}", f"1,2,3,{-2 * x},{-2 * y},{-2 * z},{-2 * w}"):
        found = json.loads(ask(capsys, "tf", "top", "fly", "--joint", f"free={text}", "--format", "json"))["result"]
        assert found["translation"] == pytest.approx([1, 2, 3])
        assert found["rpy"] == pytest.approx([0.1, 0.2, 0.3])
    back = json.loads(ask(capsys, "tf", "puck", "top", "--joint", "slide=0.1,-0.2,30deg", "--format", "json"))["result"]
    inverse = Pose((0.1, -0.2, 1.0), (0.0, 0.0, math.radians(30))).transform().inverse()
    assert back["translation"] == pytest.approx(inverse.xyz)


@pytest.mark.usefixtures("table")
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("slide=1", 'joint "slide" is planar: write slide=x,y,angle'),
        ("free=1,2", 'joint "free" is floating: write free=x,y,z,roll,pitch,yaw or free=x,y,z,qx,qy,qz,qw'),
        ("slide=1,2,3cm", 'joint "slide" is planar: 3cm is a length (m), not an angle (rad)'),
        ("slide=1,30deg,0", 'joint "slide" is planar: 30deg is an angle (rad), not a length (m)'),
        ("slide=1,,0", 'the position of joint "slide" cannot be read: '),
        ("free=1,2,3,0,0,0,0", 'the quaternion of joint "free" is zero: 1,2,3,0,0,0,0'),
    ],
)
def test_coordinates_that_are_none(capsys: Shown, text: str, message: str) -> None:
    assert message in ask(capsys, "tf", "top", "puck", "--joint", text, code=2)


@pytest.mark.usefixtures("table")
def test_a_sweep_goes_over_one_number(capsys: Shown) -> None:
    said = ask(capsys, "tf", "top", "puck", "--sweep", "slide=0:1:3", code=2)
    assert 'joint "slide" is planar: its position is not one number' in said

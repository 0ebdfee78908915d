"""The stock nodes of Debian, started as the launch files of a package say, put every frame where the model has it."""

from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.model.geometry import Transform
from support import stock_nodes
from support.launch import read
from support.paths import ROSORIN
from support.robots import compiled

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not stock_nodes.installed(), reason=f"apt-get install {stock_nodes.PACKAGES}"),
]

STATE = {"joint1": 0.3, "joint2": -0.5, "joint3": 0.8, "joint4": 1.1, "joint5": -1.4}


@pytest.mark.landing("outside", "xml")
@pytest.mark.parametrize("form", ["py", "xml", "yaml"])
def test_every_frame_is_where_the_model_has_it(tmp_path: Path, form: str) -> None:
    package, home = tmp_path / "package", tmp_path / "home"
    home.mkdir()
    assert main(["package", str(ROSORIN), "-o", str(package), "--name", "made"]) == 0
    publisher, *statics = read(package / f"launch/description.launch.{form}", {"made": package}).nodes
    started = [
        stock_nodes.StaticTransform(node.name, dict(zip(node.arguments[::2], node.arguments[1::2], strict=True)))
        for node in statics
    ]
    said = stock_nodes.run(publisher.parameters["robot_description"], started, [STATE], home)
    robot = compiled().robot
    assert robot is not None
    (poses,) = said["states"]
    assert {"camera_link", "depth_camera_link", "laser", "imu_link"} < set(poses)
    for frame, (root, xyz, (qx, qy, qz, qw)) in poses.items():
        found = Transform.of_quaternion(tuple(xyz), (qw, qx, qy, qz))
        wanted = robot.transform(root, frame, STATE)
        assert found.xyz == pytest.approx(wanted.xyz, abs=1e-6)
        assert found.angle_to(wanted) < 1e-6

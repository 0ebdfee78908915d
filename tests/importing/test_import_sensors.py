"""Sensors of MuJoCo on one link: those of one type at one site are one entry, and no other sensor is lost."""

from pathlib import Path

import pytest
import yaml

from rosorin_compile import import_robot

TWO = """<mujoco model="two"><worldbody><body name="trunk"><freejoint/><geom size="0.1"/>
<site name="a" pos="0.1 0 0"/><site name="b" pos="-0.1 0 0"/></body></worldbody><sensor>
<gyro name="imu_a_gyro" site="a"/><accelerometer name="imu_a_acc" site="a"/>
<gyro name="imu_b_gyro" site="b"/><accelerometer name="imu" site="b"/>
</sensor></mujoco>
"""


def test_each_site_has_a_sensor_in_gazebo(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    source = tmp_path / "two.xml"
    source.write_text(TWO, "utf-8")
    made = import_robot(source, output=tmp_path / "made")
    assert made.written, made.diagnostics
    files = [yaml.safe_load(path.read_text("utf-8")) for path in (tmp_path / "made").glob("*.yaml")]
    (sensors,) = (file["sensors"] for file in files if "sensors" in file)
    assert {name: len(one["mjcf"]) for name, one in sensors.items()} == {"imu_a": 2, "imu_b_gyro": 1, "imu": 1}
    placed = {name: [item["xyz"] for item in one["gazebo"]] for name, one in sensors.items()}
    assert placed == {"imu_a": [[0.1, 0, 0]], "imu_b_gyro": [[-0.1, 0, 0]], "imu": []}

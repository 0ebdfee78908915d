"""verify on recordings of real runs of the stock nodes: what they publish on our artifacts is as described."""

import json
import os
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.recordings.results import Verification
from support import bags, stock_nodes
from support.bags import TYPES, Message, judged, rules
from support.robots import texts

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not stock_nodes.installed() and "CI" not in os.environ, reason=f"apt-get install {stock_nodes.PACKAGES}"
    ),
]
OTHERS = frozenset({"ekf", "slam_toolbox", "amcl", "deptrum"})
STATES = [{name: 0.1 * step * (number - 2) for number, name in enumerate(bags.ARM)} for step in range(6)]


@lru_cache
def recorded(folder: Path, urdf: str, yaw: str) -> Path:
    (folder / "home").mkdir(parents=True)
    entries = json.loads(texts(bags.made())["static_tf.json"])["static_transform_publisher"]
    static = []
    for entry in entries:
        options = dict(zip(entry["arguments"][::2], entry["arguments"][1::2], strict=True))
        if options["--child-frame-id"] == "laser":
            options["--yaw"] = yaw
        static.append(stock_nodes.StaticTransform(entry["name"], options))
    said = stock_nodes.run(urdf, static, STATES, folder / "home")
    return bags.write(folder / "bag", sorted(_messages(said, urdf), key=lambda message: message.received))


def _messages(said: dict[str, Any], urdf: str) -> Sequence[Message]:
    found = []
    for topic, _, parent, child, stamp, received, pose in said["messages"]:
        transform = bags.transform_message(stamp, parent, child, bags.Transform(xyz=tuple(pose[:3])))
        transform.transform.rotation = TYPES["geometry_msgs/msg/Quaternion"](*pose[3:])
        found.append(bags.tf(received, [transform], topic == "/tf_static"))
    for state, stamps in said["joint_states"]:
        for stamp in stamps:
            content = bags.joint_state(stamp, tuple(state), list(state.values()))
            found.append(Message(stamp + 1000, "/joint_states", "sensor_msgs/msg/JointState", content))
    first = min(message.received for message in found)
    text = TYPES["std_msgs/msg/String"](urdf)
    return [*found, Message(first, "/robot_description", "std_msgs/msg/String", text)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("runs")


def of(bag: Path) -> Verification:
    return judged(bag, without=OTHERS, stale=60.0)


def test_a_real_run_on_our_artifacts_has_no_finding(folder: Path) -> None:
    verdict = of(recorded(folder / "clean", bags.urdf(), "3.14159265"))
    assert verdict.findings == ()
    series = {edge.name: edge for edge in verdict.edges if edge.topic}
    assert len(series) == 12
    for joint in bags.ARM:
        values = series[bags.robot().joint[joint].parent + " -> " + bags.robot().joint[joint].child]
        assert values.by_state == values.compared >= len(STATES)
    assert all(found.compared for found in series.values())


def test_a_real_run_with_the_lidar_mounted_backwards_is_found(folder: Path) -> None:
    assert rules(of(recorded(folder / "backwards", bags.urdf(), "0"))) == ["mounted-backwards"]

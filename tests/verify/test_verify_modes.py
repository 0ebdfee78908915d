"""verify where modes decide what is published, on recordings of another robot, and where little can be compared."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.formats.compiled import Compiled, compile_robot, emit_published
from rosorin_compile.model import Pose, Transform
from rosorin_compile.recordings.expected import Options
from rosorin_compile.recordings.report import summary
from rosorin_compile.recordings.results import Verified
from rosorin_compile.recordings.verification import verify
from rosorin_compile.request import Request
from rosorin_compile.source.project import Description as RobotOnDisk
from support import bags
from support.bags import Message, edge, judged, ns, rules

pytestmark = pytest.mark.slow

TWO_MODES = """\
robot: two_modes
modes: {slam: a map is made}
links: {base_link: {}, laser: {}, tower: {}}
publishers: {ekf: {}, slam_toolbox: {}, fixer: {}, camera: {}}
joints:
  laser_joint: {type: fixed, parent: base_link, child: laser, xyz: [0.1, 0, 0]}
  tower_joint: {type: fixed, parent: base_link, child: tower, xyz: [0, 0, 0.2]}
edges:
  - {parent: odom, child: base_link, publisher: ekf}
  - {parent: map, child: odom, publisher: slam_toolbox, when: slam}
  - {parent: map, child: odom, publisher: fixer, when: not slam, moving: false, xyz: [1, 0, 0]}
  - {parent: laser, child: eye, publisher: camera, when: slam, moving: false, xyz: [0, 1, 0]}
  - {parent: tower, child: eye, publisher: camera, when: not slam, moving: false, xyz: [0, 2, 0]}
  - {parent: laser, child: nose, publisher: camera, when: slam, moving: false, xyz: [0, 0, 1]}
  - {parent: laser, child: nose, publisher: fixer, when: not slam, moving: false, xyz: [0, 0, 2]}
  - {parent: base_link, child: probe, publisher: camera, when: slam, moving: false, xyz: [0, 0, 3]}
outputs: {urdf: {file: two_modes.urdf}}
"""


def at(x: float, y: float, z: float) -> Transform:
    return Pose((x, y, z)).transform()


def still(parent: str, child: str, value: Transform) -> Message:
    return edge(ns(0.0), parent, child, value, still=True)


def moving(parent: str, child: str) -> list[Message]:
    return [edge(ns(seconds), parent, child, at(seconds, 0, 0)) for seconds in bags.every(20.0, 3.0)]


ALWAYS = [
    still("base_link", "laser", at(0.1, 0, 0)),
    still("base_link", "tower", at(0, 0, 0.2)),
    *moving("odom", "base_link"),
]
PARTS: dict[bool, dict[str, list[Message]]] = {
    True: {
        "odom": moving("map", "odom"),
        "eye": [still("laser", "eye", at(0, 1, 0))],
        "nose": [still("laser", "nose", at(0, 0, 1))],
        "probe": [still("base_link", "probe", at(0, 0, 3))],
    },
    False: {
        "odom": [still("map", "odom", at(1, 0, 0))],
        "eye": [still("tower", "eye", at(0, 2, 0))],
        "nose": [still("laser", "nose", at(0, 0, 2))],
        "probe": [],
    },
}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    path = tmp_path_factory.mktemp("robot") / "robot.yaml"
    path.write_text(TWO_MODES, "utf-8")
    return compile_robot(path)


def of(made: Compiled, folder: Path, said: list[Message], **options: object) -> Verified:
    assert made.robot is not None, made.diagnostics
    bag = bags.write(folder, sorted(said, key=lambda message: message.received))
    return verify(made.robot, made.artifacts, str(bag), Options(**options))  # type: ignore[arg-type]


@pytest.mark.parametrize("slam", [True, False])
def test_each_mode_is_compared_with_what_it_has(made: Compiled, tmp_path: Path, slam: bool) -> None:
    said = [*ALWAYS, *(message for part in PARTS[slam].values() for message in part)]
    verdict = of(made, tmp_path / "fits", said)
    assert verdict.findings == ()
    right = of(made, tmp_path / "right", said, modes={"slam": slam})
    assert right.findings == ()
    compared = {edge.child: edge.compared for edge in right.edges}
    assert compared == {"base_link": 0, "odom": int(not slam), "laser": 1, "tower": 1, "eye": 1, "nose": 1} | (
        {"probe": 1} if slam else {}
    )
    wrong = of(made, tmp_path / "wrong", said, modes={"slam": not slam})
    assert wrong.fails()
    assert {finding.rule for finding in wrong.findings} >= {
        "edge-not-static" if slam else "edge-not-moving",
        "edge-wrong-parent",
        "edge-wrong-value",
        "edge-not-described" if slam else "edge-missing",
    }


def test_what_is_described_in_another_mode_is_said_so(made: Compiled, tmp_path: Path) -> None:
    said = [*ALWAYS, *(message for part in PARTS[False].values() for message in part), *PARTS[True]["probe"]]
    verdict = of(made, tmp_path / "bag", said, modes={"slam": False})
    assert [finding.message for finding in verdict.findings] == [
        "base_link -> probe was published, but such an edge is described only when slam"
    ]


def test_edges_of_two_modes_are_of_none(made: Compiled, tmp_path: Path) -> None:
    parts = PARTS[True] | {"odom": PARTS[False]["odom"]}
    verdict = of(made, tmp_path / "bag", [*ALWAYS, *(message for part in parts.values() for message in part)])
    assert [finding.message for finding in verdict.findings] == [
        "map -> odom is as described when not slam, but the others are those when slam is on"
    ]
    assert verdict.fails()
    parts = PARTS[True] | {"nose": [still("laser", "nose", at(0, 0, 7))]}
    verdict = of(made, tmp_path / "none", [*ALWAYS, *(message for part in parts.values() for message in part)])
    assert rules(verdict) == ["edge-wrong-value"]


def one_link(folder: Path) -> Compiled:
    path = folder / "box.urdf"
    path.write_text('<robot name="box"><link name="box"/></robot>', "utf-8")
    return emit_published(Request(RobotOnDisk.at(path)).understand(), path)


@pytest.mark.parametrize("topics", [{"/tf", "/tf_static"}, {"/tf_static"}, {"/tf_static", "/joint_states", "/scan"}])
def test_a_recording_of_another_robot(tmp_path: Path, topics: set[str]) -> None:
    """Of a robot that has nothing in common nothing is concluded, not even that nothing is missing."""
    said = [message for message in bags.messages(bags.Scene(seconds=2.0)) if message.topic in topics]
    verdict = of(one_link(tmp_path), tmp_path / "bag", said)
    assert verdict.fails()
    if "/joint_states" not in topics:
        number = sum(bool(edge.topic) for edge in verdict.edges)
        assert [finding.message for finding in verdict.findings if finding.severity == "error"] == [
            f"none of the {number} edges of the recording is described: nothing could be compared"
        ]
        assert summary(verdict, "box", strict=False).startswith("box: could not be compared")


def test_joint_states_of_some_joints_alone(tmp_path: Path) -> None:
    """The driver names one joint at another time than robot_state_publisher moved it: no state is compared with it."""

    def partly(messages: list[Message]) -> list[Message]:
        for message in messages:
            if message.topic == "/joint_states":
                message.content.name = message.content.name[:4]
                message.content.position = message.content.position[:4]
        own = bags.joint_state(ns(0.777), ("joint5",), [0.1])
        return [*messages, Message(ns(0.778), "/joint_states", "sensor_msgs/msg/JointState", own)]

    verdict = judged(bags.bag(tmp_path / "bag", seconds=4.0, change=partly))
    assert [(finding.severity, finding.message) for finding in verdict.findings] == [
        (
            "note",
            "link4 -> link5 never had the stamp of a message of /joint_states that names its joint: compared only with "
            "what the joint can do",
        )
    ]

"""verify on frames with other names than the description's, on fleets, and where modes decide what is published."""

from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.model import Pose, Transform
from rosorin_compile.recordings.expected_edges import Options
from rosorin_compile.recordings.results import Verification, summary
from rosorin_compile.recordings.verification import emit_published, verify
from rosorin_compile.request import Request
from rosorin_compile.source.project import Description as RobotOnDisk
from support import bags
from support.bag_faults import prefixed
from support.bags import Message, edge, judged, ns, rules
from support.paths import data_text

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("prefix", ["robot1/", "robot1_", "/robot1/", "a/b/", "x"])
@pytest.mark.parametrize("headers", [True, False])
def test_all_frames_begin_with_a_prefix(tmp_path: Path, prefix: str, headers: bool) -> None:
    bag = bags.bag(tmp_path / "bag", "mcap", seconds=2.0, change=prefixed(prefix, headers=headers))
    own = prefix.removeprefix("/")
    for given in ("", "robot2/", "robot1"):
        verdict = judged(bag, prefix=given)
        assert rules(verdict) == ["frames-prefixed"]
        assert verdict.findings[0].help == f"--prefix {own} compares what is behind it"
        assert summary(verdict, "rosorin", strict=False).startswith("rosorin: could not be compared: 1 error")
    if headers and prefix == own:
        assert judged(bag, prefix=own).findings == ()


def test_not_all_frames_begin_with_a_prefix(tmp_path: Path) -> None:
    shared = judged(bags.bag(tmp_path / "shared", seconds=2.0, change=prefixed("robot1/", but="map")))
    assert "frames-prefixed" not in rules(shared)
    assert "--prefix" not in " ".join(one.message + one.help for one in shared.findings)
    clean = bags.bag(tmp_path / "clean", seconds=2.0)
    assert rules(judged(clean)) == []
    verdict = judged(clean, prefix="robot1/")
    assert [one.message for one in verdict.findings] == [
        "no frame begins with robot1/: there are base_link, camera_link, camera_link0 and 13 more"
    ]


def fleet(unprefixed: str = "") -> list[Message]:
    """Two robots on one /tf: all frames have a prefix but the map, and topics of sensors a namespace."""
    said = []
    for robot in ("r1/", "r2/"):
        for message in prefixed(robot, "map")(bags.messages(bags.Scene(seconds=3.0))):
            head = getattr(message.content, "header", None)
            if unprefixed and head is not None and head.frame_id == robot + unprefixed:
                head.frame_id = unprefixed
            shared = message.topic in ("/tf", "/tf_static")
            said.append(message if shared else message._replace(topic=f"/{robot}{message.topic[1:]}"))
    return sorted(said, key=lambda message: message.received)


def test_one_robot_of_a_fleet(tmp_path: Path) -> None:
    bag = bags.write(tmp_path / "bag", fleet())
    for number in (1, 2):
        assert judged(bag, namespace=f"r{number}", prefix=f"r{number}/").findings == ()
    forgotten = bags.write(tmp_path / "forgotten", fleet(unprefixed="laser"))
    findings = judged(forgotten, namespace="r1", prefix="r1/").findings
    assert {(finding.rule, finding.subject) for finding in findings} == {
        ("frame-unknown", "/r1/scan"),
        ("frame-unknown", "/r2/scan"),
    }


def test_namespace_and_prefix(tmp_path: Path) -> None:
    said = prefixed("r1/", namespace="/r1")(bags.messages(bags.Scene(seconds=3.0)))
    bag = bags.write(tmp_path / "bag", said)
    verdict = judged(bag)
    assert rules(verdict) == ["recording-foreign"]
    assert verdict.findings[0].help == "--namespace /r1 reads /r1/tf"
    assert judged(bag, namespace="r1", prefix="r1/").findings == ()


def test_what_a_node_is_declared_to_stamp_is_its_own(tmp_path: Path) -> None:
    """A description that says what a merger of scans stamps, and a sensor that stamps nothing."""
    text = """\
robot: two_eyes
links: {base_link: {}}
sensors:
  front: {type: lidar_2d, parent: base_link, frame: front_laser, xyz: [0.1, 0, 0]}
  rear: {type: lidar_2d, parent: base_link, frame: rear_laser, xyz: [-0.1, 0, 0], REAR}
PUBLISHERS
outputs: {urdf: {file: two_eyes.urdf}}
"""

    def findings(name: str, frames: list[str], rear: str = "rpy: [0, 0, 0]", publishers: str = "") -> list[Any]:
        path = tmp_path / name / "robot.yaml"
        path.parent.mkdir()
        path.write_text(text.replace("REAR", rear).replace("PUBLISHERS", publishers), "utf-8")
        made = compile_robot(path)
        assert made.robot is not None
        said = [edge(ns(0), j.parent, j.child, j.transform(), still=True) for j in made.robot.joints]
        for number, frame in enumerate(frames):
            kind = "sensor_msgs/msg/LaserScan"
            said.append(Message(ns(1.0), f"/scan{number}", kind, bags.scan(bags.header(ns(0.99), frame))))
        bag = bags.write(tmp_path / name / "bag", said)
        return [(one.rule, one.subject) for one in verify(made.robot, made.artifacts, str(bag), Options()).findings]

    assert findings("right", ["front_laser", "rear_laser"]) == []
    assert findings("one", ["front_laser", "front_laser"]) == []
    assert findings("wrong", ["front_laser", "base_link"]) == [("frame-not-as-declared", "/scan1")]
    assert findings("both", ["base_link", "base_link"]) == [("frame-not-as-declared", "/scan0")]
    assert findings("none", ["front_laser", "base_link"], rear="stamps: []") == []
    assert findings("said", ["base_link"], publishers="publishers: {merger: {stamps: [base_link]}}") == []


TWO_MODES = data_text("robots/verify_names_two_modes.yaml")


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
def made(tmp_path_factory: pytest.TempPathFactory) -> CompileResult:
    path = tmp_path_factory.mktemp("robot") / "robot.yaml"
    path.write_text(TWO_MODES, "utf-8")
    return compile_robot(path)


def of(made: CompileResult, folder: Path, said: list[Message], **options: object) -> Verification:
    assert made.robot is not None, made.diagnostics
    bag = bags.write(folder, sorted(said, key=lambda message: message.received))
    return verify(made.robot, made.artifacts, str(bag), Options(**options))  # type: ignore[arg-type]


@pytest.mark.parametrize("slam", [True, False])
def test_each_mode_is_compared_with_what_it_has(made: CompileResult, tmp_path: Path, slam: bool) -> None:
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


def test_what_is_described_in_another_mode_is_said_so(made: CompileResult, tmp_path: Path) -> None:
    said = [*ALWAYS, *(message for part in PARTS[False].values() for message in part), *PARTS[True]["probe"]]
    verdict = of(made, tmp_path / "bag", said, modes={"slam": False})
    assert [finding.message for finding in verdict.findings] == [
        "base_link -> probe was published, but such an edge is described only when slam"
    ]


def test_edges_of_two_modes_are_of_none(made: CompileResult, tmp_path: Path) -> None:
    parts = PARTS[True] | {"odom": PARTS[False]["odom"]}
    verdict = of(made, tmp_path / "bag", [*ALWAYS, *(message for part in parts.values() for message in part)])
    assert [finding.message for finding in verdict.findings] == [
        "map -> odom is as described when not slam, but the others are those when slam is on"
    ]
    assert verdict.fails()
    parts = PARTS[True] | {"nose": [still("laser", "nose", at(0, 0, 7))]}
    verdict = of(made, tmp_path / "none", [*ALWAYS, *(message for part in parts.values() for message in part)])
    assert rules(verdict) == ["edge-wrong-value"]


def one_link(folder: Path) -> CompileResult:
    path = folder / "box.urdf"
    path.write_text('<robot name="box"><link name="box"/></robot>', "utf-8")
    return emit_published(Request(RobotOnDisk.from_path(path)).understand(), path)


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
    assert [(finding.severity, finding.rule) for finding in verdict.findings] == [("note", "not-compared")]
    assert verdict.findings[0].message.startswith("link4 -> link5 never had the stamp of a message of /joint_states")

"""verify on frames with other names than the description's: slashes, prefixes, frames under themselves, wrong ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.model import Transform
from rosorin_compile.recordings.expected import Options
from rosorin_compile.recordings.report import summary
from rosorin_compile.recordings.verification import verify
from support import bags
from support.bag_faults import more, without
from support.bags import Message, edge, judged, ns, rules

pytestmark = pytest.mark.slow

Change = Callable[[list[Message]], list[Message]]


def stamped(topic: str, frame: str, each: int = 1) -> Change:
    """The messages of a topic, or each so manyth of them, have another frame."""

    def change(messages: list[Message]) -> list[Message]:
        for message in [message for message in messages if message.topic == topic][::each]:
            message.content.header.frame_id = frame
        return messages

    return change


def both(one: Change, other: Change) -> Change:
    return lambda messages: other(one(messages))


def prefixed(prefix: str, but: str = "", headers: bool = True) -> Change:
    """All frames have a prefix, but for one; those of other messages may lack it."""

    def change(messages: list[Message]) -> list[Message]:
        for message in messages:
            heads = [transform.header for transform in getattr(message.content, "transforms", ())]
            for transform in getattr(message.content, "transforms", ()):
                transform.child_frame_id = prefix + transform.child_frame_id
            head = getattr(message.content, "header", None)
            heads += [head] if headers and head is not None and head.frame_id else []
            for one in heads:
                one.frame_id = one.frame_id if one.frame_id == but else prefix + one.frame_id
        return messages

    return change


def merged(messages: list[Message]) -> list[Message]:
    """Somebody makes scans in the body out of those of the lidar."""
    scans = [message for message in messages if message.topic == "/scan"]
    contents = [bags.scan(bags.header(message.received, "base_link")) for message in scans]
    return messages + [m._replace(topic="/merged", content=made) for m, made in zip(scans, contents, strict=True)]


HERE = Transform()
NAMES: dict[str, tuple[Change, list[str]]] = {
    "a slash": (stamped("/scan", "/laser"), ["error[frame-with-slash] /scan"]),
    "a slash in some": (stamped("/scan", "/laser", each=2), ["error[frame-with-slash] /scan"]),
    "a slash, and no such frame": (stamped("/scan", "/lasr"), ["error[frame-unknown] /scan"]),
    "the frame of the body": (stamped("/scan", "base_link"), ["error[frame-not-as-declared] /scan"]),
    "two frames in each other's place": (
        both(stamped("/scan", "imu_link"), stamped("/imu/data", "laser")),
        ["error[frame-not-as-declared] /scan", "error[frame-not-as-declared] /imu/data"],
    ),
    "a frame that others publish": (
        both(stamped("/scan", "lidar_frame"), more(edge(ns(0.01), "base_link", "lidar_frame", HERE, still=True))),
        ["warning[edge-not-described] base_link -> lidar_frame", "warning[frame-not-as-declared] /scan"],
    ),
    "another eye of the camera": (stamped("/camera/depth/image", "rgb_camera_link"), []),
    "a scan that is made of others": (merged, []),
    "a frame under itself": (
        more(*[edge(ns(at), "laser", "laser", HERE) for at in range(1, 6)]),
        ["error[edge-dropped] laser -> laser"],
    ),
    "a frame under itself, with a slash": (
        more(edge(ns(1.0), "laser", "/laser", HERE, still=True)),
        ["error[edge-dropped] laser -> laser"],
    ),
    "a frame under itself alone": (
        both(without("/tf_static", "laser"), more(edge(ns(1.0), "laser", "laser", HERE, still=True))),
        ["error[edge-dropped] laser -> laser", "error[edge-missing] base_link -> laser"],
    ),
    "names that are empty": (
        more(edge(ns(1.0), "", "laser", HERE), edge(ns(1.1), "laser", "/", HERE), edge(ns(1.2), "", "", HERE)),
        ["error[edge-dropped]  -> laser", "error[edge-dropped] laser -> ", "error[edge-dropped]  -> "],
    ),
    "a slash before all transforms": (prefixed("/", headers=False), []),
}


@pytest.mark.parametrize("name", NAMES)
def test_names_that_are_not_those_of_the_description(tmp_path: Path, name: str) -> None:
    change, expected = NAMES[name]
    verdict = judged(bags.bag(tmp_path / "bag", "mcap", change=change))
    assert [f"{one.severity}[{one.rule}] {one.subject}" for one in verdict.findings] == expected


@pytest.mark.parametrize("prefix", ["robot1/", "robot1_", "/robot1/", "a/b/", "x"])
@pytest.mark.parametrize("headers", [True, False])
def test_all_frames_begin_with_a_prefix(tmp_path: Path, prefix: str, headers: bool) -> None:
    bag = bags.bag(tmp_path / "bag", "mcap", seconds=2.0, change=prefixed(prefix, headers=headers))
    own = prefix.removeprefix("/")
    for given in ("", "robot2/", "robot1"):
        verdict = judged(bag, prefix=given)
        assert rules(verdict) == ["frames-prefixed"]
        assert verdict.findings[0].message.startswith(f"all frames begin with {own}, ")
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


def test_a_prefix_in_text() -> None:
    text = "transforms:\n" + "".join(
        f"- header: {{stamp: {{sec: 1, nanosec: 0}}, frame_id: r1/{parent}}}\n  child_frame_id: r1/{child}\n"
        "  transform: {translation: {x: 0, y: 0, z: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}}\n"
        for parent, child in (("odom", "base_link"), ("map", "odom"))
    )
    assert [one.message for one in judged("-", text).findings] == [
        "all frames begin with r1/, those of the description do not"
    ]
    slashed = "header: {stamp: {sec: 1, nanosec: 0}, frame_id: /laser}\nranges: []\n"
    assert "frame-with-slash" in rules(judged("-", slashed))


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

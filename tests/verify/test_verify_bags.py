"""verify on recordings in all storages, in parts, of other robots, and on what is no recording."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rosorin_compile.model import Pose
from rosorin_compile.recordings.results import summary
from support import bags
from support.bag_faults import stopping
from support.bags import STORE, TYPES, Message, Scene, judged, ns, part, rules

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_single_file_and_a_folder_without_metadata(clean: dict[str, Path], tmp_path: Path, storage: str) -> None:
    copy = shutil.copytree(clean[storage], tmp_path / "copy")
    (copy / "metadata.yaml").unlink()
    verdicts = [judged(source) for source in (clean[storage], part(clean[storage]), copy)]
    assert [verdict.findings for verdict in verdicts] == [()] * 3
    assert len({verdict.messages for verdict in verdicts}) == 1


@pytest.mark.parametrize(("storage", "mode"), [("sqlite3", "MESSAGE"), ("sqlite3", "FILE"), ("mcap", "STORAGE")])
def test_compressed_recordings(tmp_path: Path, storage: str, mode: str) -> None:
    said = bags.messages(Scene(seconds=3.0))
    verdict = judged(bags.write(tmp_path / "bag", said, storage, mode))
    assert verdict.findings == ()
    assert verdict.messages == len(said)


def test_files_without_metadata_follow_each_other_in_time(tmp_path: Path) -> None:
    """Twelve files: the tenth sorts before the second by name."""
    said = bags.messages(Scene(seconds=6.0))
    first, folder = said[0].received, tmp_path / "bag"
    folder.mkdir()
    for number in range(12):
        inside = [message for message in said if (message.received - first) * 12 // (6 * bags.SECOND + 1) == number]
        shutil.copy(part(bags.write(tmp_path / str(number), inside, "mcap")), folder / f"bag_{number}.mcap")
    whole = judged(folder)
    assert (whole.findings, whole.messages) == ((), len(said))
    latched = ("/tf_static", "/robot_description")
    kept = [one for one in said if one.received >= first + 3 * bags.SECOND or one.topic in latched]
    assert judged(folder, since=3.0).messages == len(kept)


def test_empty_and_foreign_recordings(tmp_path: Path) -> None:
    assert rules(judged(bags.write(tmp_path / "empty", []))) == ["recording-empty"]
    kind = "std_msgs/msg/String"
    for topic, message in {
        "/chatter": "the recording has no transforms: it has /chatter",
        "/tf": "/tf is of type std_msgs/msg/String, not tf2_msgs/msg/TFMessage",
    }.items():
        said = Message(ns(1.0), topic, kind, TYPES[kind]("hello"))
        verdict = judged(bags.write(tmp_path / topic[1:], [said]))
        assert [finding.message for finding in verdict.findings] == [message]


@pytest.mark.parametrize("topics", [{"/scan"}, {"/scan", "/imu/data"}, {"/robot_description"}, {"/joint_states"}])
def test_nothing_is_concluded_of_no_edge_at_all(tmp_path: Path, topics: set[str]) -> None:
    said = [message for message in bags.messages(bags.Scene()) if message.topic in topics]
    for number, message in enumerate(said):  # as a simulation stamps them
        if hasattr(message.content, "header"):
            message.content.header.stamp = bags.time(ns(0.1 * number) - ns(0.0))
    verdict = judged(bags.write(tmp_path / "bag", said))
    assert verdict.fails()
    assert "as described" not in summary(verdict, "rosorin", strict=False)


def test_a_frame_that_is_no_place_is_not_looked_for(tmp_path: Path) -> None:
    head, zero = bags.header(ns(1.0), "joy"), TYPES["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    joy = TYPES["sensor_msgs/msg/Joy"](head, np.zeros(2, np.float32), np.zeros(2, np.int32))
    wrench = TYPES["geometry_msgs/msg/WrenchStamped"](head, TYPES["geometry_msgs/msg/Wrench"](zero, zero))
    said = [
        Message(ns(1.0), "/joy", "sensor_msgs/msg/Joy", joy),
        Message(ns(1.0), "/wrench", "geometry_msgs/msg/WrenchStamped", wrench),
    ]
    verdict = judged(bags.bag(tmp_path / "bag", seconds=2.0, change=lambda messages: [*messages, *said]))
    assert [finding.subject for finding in verdict.findings] == ["/wrench"]


def test_messages_of_a_type_of_ones_own_have_headers_too(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    texts = {"own_msgs/msg/Blob": "# a remark\nuint8 KIND=3\nstd_msgs/Header header\nuint8 size\n"}
    texts |= {"own_msgs/msg/Late": "uint8 size\nstd_msgs/Header header\n"}
    for name, text in texts.items():
        store.register(get_types_from_msg(text, name))
    with bags.Writer(tmp_path / "bag", version=9) as writer:
        for name in texts:
            connection = writer.add_connection(f"/{name[-4:].lower()}", name, typestore=store)
            values = {"header": bags.header(ns(1.0), "blub"), "size": 1, "KIND": 3}
            fields = {key: values[key] for key, _ in store.fielddefs[name][1]}
            fields |= {"KIND": 3} if name.endswith("Blob") else {}
            writer.write(connection, ns(1.0), store.serialize_cdr(store.types[name](**fields), name))
        places = {}
        for message in bags.messages(Scene(seconds=2.0)):
            if message.topic not in places:
                places[message.topic] = writer.add_connection(message.topic, message.kind, typestore=STORE)
            writer.write(places[message.topic], message.received, STORE.serialize_cdr(message.content, message.kind))
    verdict = judged(tmp_path / "bag")
    assert [(finding.rule, finding.severity, finding.subject) for finding in verdict.findings] == [
        ("frame-unknown", "warning", "/blob")
    ]


def test_parts_of_a_recording(tmp_path: Path) -> None:
    bag = bags.bag(tmp_path / "bag", seconds=20.0, slam=stopping)
    assert rules(judged(bag)) == ["edge-stale"]
    for times in ({"until": 4.0}, {"since": 16.0}, {"since": 1.0, "until": 5.0}):
        verdict = judged(bag, **times)
        assert verdict.findings == (), times
        assert len(verdict.data.parents) == 15
    assert rules(judged(bag, stale=11.0)) == []


def test_modes_and_nodes_that_did_not_run(tmp_path: Path) -> None:
    bag = bags.bag(tmp_path / "bag", seconds=3.0, slam=lambda _: False)
    for slam, owner in ((True, "slam_toolbox"), (False, "amcl")):
        (finding,) = judged(bag, modes={"slam": slam}).findings
        assert (finding.rule, finding.subject) == ("edge-missing", "map -> odom")
        assert owner in finding.message
        assert judged(bag, modes={"slam": slam}, without=frozenset({owner})).findings == ()


def test_without_joint_states_edges_are_held_against_their_joints(tmp_path: Path) -> None:
    """A turn about another axis than that of the joint is wrong whatever the joint states were."""

    def change(messages: list[Message]) -> list[Message]:
        return [message for message in messages if message.topic != "/joint_states"]

    def tilted(messages: list[Message]) -> list[Message]:
        wrong = Pose((0.00025563, 0.00074282, 0.08513), (0.1, 0.2, 0.3)).transform()
        for message in change(messages):
            for transform in message.content.transforms if message.topic == "/tf" else ():
                if transform.child_frame_id == "link3":
                    transform.transform = bags.transform_message(0, "", "", wrong).transform
        return change(messages)

    verdict = judged(bags.bag(tmp_path / "clean", seconds=3.0, change=change))
    assert (rules(verdict), verdict.fails()) == (["not-compared"], False)
    assert rules(judged(bags.bag(tmp_path / "tilted", seconds=3.0, change=tilted))) == [
        "edge-wrong-value",
        "not-compared",
    ]

"""verify on recordings that are broken, foreign or in parts: clear errors, and nothing lost."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rosorin_compile.cli.main import main
from rosorin_compile.model import Pose
from rosorin_compile.recordings.bags import Unreadable
from rosorin_compile.recordings.results import summary, table
from support import bags
from support.bags import STORE, TYPES, Message, Scene, judged, ns, part, rules
from support.paths import ROOT

pytestmark = pytest.mark.slow

ROBOT = str(ROOT / "descriptions" / "rosorin")


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_single_file_and_a_folder_without_metadata(clean: dict[str, Path], tmp_path: Path, storage: str) -> None:
    whole = judged(clean[storage])
    assert whole.findings == ()
    alone = judged(part(clean[storage]))
    copy = shutil.copytree(clean[storage], tmp_path / "copy")
    (copy / "metadata.yaml").unlink()
    for other in (alone, judged(copy)):
        assert other.findings == ()
        assert other.data.messages == whole.data.messages


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_recording_in_several_files(tmp_path: Path, storage: str) -> None:
    said = bags.messages(Scene(seconds=6.0))
    together = tmp_path / "together"
    together.mkdir()
    for number, (begin, end) in enumerate(((-10.0, 2.0), (2.0, 4.0), (4.0, 10.0))):
        inside = [message for message in said if ns(begin) <= message.received < ns(end)]
        file = part(bags.write(tmp_path / str(number), inside, storage))
        shutil.copy(file, together / f"part_{number}{file.suffix}")
    verdict, whole = judged(together), judged(bags.write(tmp_path / "whole", said, storage))
    assert verdict.findings == whole.findings == ()
    assert verdict.messages == len(said)
    assert table(verdict) == table(whole)


@pytest.mark.parametrize(("storage", "mode"), [("sqlite3", "MESSAGE"), ("sqlite3", "FILE"), ("mcap", "STORAGE")])
def test_compressed_recordings(tmp_path: Path, storage: str, mode: str) -> None:
    said = bags.messages(Scene(seconds=3.0))
    verdict = judged(bags.write(tmp_path / "bag", said, storage, mode))
    assert verdict.findings == ()
    assert verdict.messages == len(said)


def test_what_is_no_recording(clean: dict[str, Path], tmp_path: Path) -> None:
    empty, foreign, binary = tmp_path / "empty.mcap", tmp_path / "text.db3", tmp_path / "binary"
    empty.write_bytes(b"")
    foreign.write_bytes(b"no database")
    binary.write_bytes(bytes(range(256)))
    misnamed = shutil.copy(part(clean["mcap"]), tmp_path / "misnamed.db3")
    (tmp_path / "folder").mkdir()
    (tmp_path / "several").mkdir()
    shutil.copytree(clean["mcap"], tmp_path / "several" / "one")
    for name, message in {
        "nowhere": "there is no {}/nowhere",
        "empty.mcap": "{}/empty.mcap cannot be read: ",
        "text.db3": "{}/text.db3 cannot be read: ",
        "misnamed.db3": "{}/misnamed.db3 cannot be read: ",
        "binary": "{}/binary is neither a rosbag2 recording nor a text",
        "folder": "{}/folder is no recording: it has no metadata.yaml, no .mcap and no .db3",
        "several": "{}/several holds several recordings: one",
    }.items():
        with pytest.raises(Unreadable) as problem:
            judged(tmp_path / name)
        assert str(problem.value).startswith(message.format(tmp_path))
        assert problem.value.help or name == "nowhere"
    assert Path(misnamed).exists()


def test_the_command_says_what_cannot_be_read(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["verify", ROBOT, str(tmp_path)]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"error[recording-unreadable]: {tmp_path} is no recording: it has no metadata.yaml")
    assert main(["verify", ROBOT, str(tmp_path), ROBOT]) == 2
    assert main(["verify", ROBOT, str(tmp_path), "--mode", "slam=maybe"]) == 2
    assert main(["verify", ROBOT, str(tmp_path), "--mode", "slm=on"]) == 2
    assert 'rosorin has no mode "slm"; did you mean "slam"?' in capsys.readouterr().err
    assert main(["verify", ROBOT, str(tmp_path), "--without", "ekff"]) == 2
    assert main(["verify", ROBOT, str(tmp_path), "--pose", "tucked"]) == 2
    assert main(["verify", ROBOT, str(tmp_path), "--since", "5", "--until", "4"]) == 2
    assert main(["verify", ROBOT, str(tmp_path), "--stale", "nan"]) == 2


def string(topic: str = "/chatter") -> Message:
    return Message(ns(1.0), topic, "std_msgs/msg/String", TYPES["std_msgs/msg/String"]("hello"))


def test_empty_and_foreign_recordings(tmp_path: Path) -> None:
    assert rules(judged(bags.write(tmp_path / "empty", []))) == ["recording-empty"]
    foreign = judged(bags.write(tmp_path / "foreign", [string()]))
    assert [finding.message for finding in foreign.findings] == ["the recording has no transforms: it has /chatter"]
    wrong = judged(bags.write(tmp_path / "wrong", [string("/tf")]))
    assert [finding.message for finding in wrong.findings] == [
        "/tf is of type std_msgs/msg/String, not tf2_msgs/msg/TFMessage"
    ]


def test_a_frame_that_is_no_place_is_not_looked_for(tmp_path: Path) -> None:
    head = bags.header(ns(1.0), "joy")
    joy = TYPES["sensor_msgs/msg/Joy"](head, np.zeros(2, np.float32), np.zeros(2, np.int32))
    wrench = TYPES["geometry_msgs/msg/WrenchStamped"](
        head, TYPES["geometry_msgs/msg/Wrench"](*[TYPES["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)] * 2)
    )
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
    said = bags.messages(Scene(seconds=2.0))
    with bags.Writer(tmp_path / "bag", version=9) as writer:
        for name in texts:
            connection = writer.add_connection(f"/{name[-4:].lower()}", name, typestore=store)
            values = {"header": bags.header(ns(1.0), "blub"), "size": 1} | (
                {"KIND": 3} if name.endswith("Blob") else {}
            )
            fields = {key: values[key] for key, _ in store.fielddefs[name][1]}
            writer.write(connection, ns(1.0), store.serialize_cdr(store.types[name](**fields), name))
        places = {}
        for message in said:
            if message.topic not in places:
                places[message.topic] = writer.add_connection(message.topic, message.kind, typestore=STORE)
            writer.write(places[message.topic], message.received, STORE.serialize_cdr(message.content, message.kind))
    verdict = judged(tmp_path / "bag")
    assert [(finding.rule, finding.severity, finding.subject) for finding in verdict.findings] == [
        ("frame-unknown", "warning", "/blob")
    ]


def test_parts_of_a_recording(tmp_path: Path) -> None:
    bag = bags.bag(tmp_path / "bag", seconds=20.0, slam=lambda seconds: not 5.0 < seconds < 15.3)
    assert rules(judged(bag)) == ["edge-stale"]
    for times in ({"until": 4.0}, {"since": 16.0}, {"since": 1.0, "until": 5.0}):
        verdict = judged(bag, **times)
        assert verdict.findings == (), times
        assert len(verdict.data.into) == 15
    assert rules(judged(bag, stale=11.0)) == []


def test_modes_and_nodes_that_did_not_run(tmp_path: Path) -> None:
    bag = bags.bag(tmp_path / "bag", seconds=3.0, slam=lambda _: False)
    for modes, owner in (({"slam": True}, "slam_toolbox"), ({"slam": False}, "amcl")):
        message = judged(bag, modes=modes).findings[0].message
        state = "on" if modes["slam"] else "off"
        assert message == f"no node published map -> odom; {owner} should (when slam is {state})"
        assert judged(bag, modes=modes, without=frozenset({owner})).findings == ()


def test_without_joint_states_edges_are_held_against_their_joints(tmp_path: Path) -> None:
    """A turn about another axis than that of the joint is wrong whatever the joint states were."""

    def change(messages: list[Message]) -> list[Message]:
        return [message for message in messages if message.topic != "/joint_states"]

    verdict = judged(bags.bag(tmp_path / "clean", seconds=3.0, change=change))
    assert rules(verdict) == ["not-compared"]
    assert not verdict.fails()

    def tilted(messages: list[Message]) -> list[Message]:
        for message in change(messages):
            for transform in message.content.transforms if message.topic == "/tf" else ():
                if transform.child_frame_id == "link3":
                    wrong = Pose((0.00025563, 0.00074282, 0.08513), (0.1, 0.2, 0.3)).transform()
                    transform.transform = bags.transform_message(0, "", "", wrong).transform
        return change(messages)

    assert rules(judged(bags.bag(tmp_path / "tilted", seconds=3.0, change=tilted))) == [
        "edge-wrong-value",
        "not-compared",
    ]


@pytest.mark.parametrize("topics", [{"/scan"}, {"/scan", "/imu/data"}, {"/robot_description"}, {"/joint_states"}])
def test_nothing_is_concluded_of_no_edge_at_all(tmp_path: Path, topics: set[str]) -> None:
    said = [message for message in bags.messages(Scene()) if message.topic in topics]
    for number, message in enumerate(said):  # as a simulation stamps them
        if hasattr(message.content, "header"):
            message.content.header.stamp = bags.time(ns(0.1 * number) - ns(0.0))
    verdict = judged(bags.write(tmp_path / "bag", said))
    assert verdict.fails()
    assert "as described" not in summary(verdict, "rosorin", strict=False)

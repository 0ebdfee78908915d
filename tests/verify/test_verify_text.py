"""verify on text: what people paste from tf2_echo, view_frames and ros2 topic echo."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.model import Pose, Transform
from rosorin_compile.recordings.expected import Options
from rosorin_compile.recordings.results import Verified, summary
from rosorin_compile.recordings.verification import verify
from support import bags
from support.bags import rules
from support.paths import DATA, data_text
from support.robots import RECORDED, copy_of_rosorin

RECORDINGS = DATA / "recordings"
TUCK = bags.robot().poses[0].positions


def judged(text: str, **options: Any) -> Verified:
    return bags.judged("-", text, **options)


def echo(transform: Transform, decimals: int = 3, only: str = "qrdm") -> str:
    """Return a transform as tf2_echo prints it (tf2_ros/src/tf2_echo.cpp); ``only`` are the forms of the rotation."""

    def row(values: Any) -> str:
        return ", ".join(f"{value:.{decimals}f}" for value in values)

    w, x, y, z = transform.quaternion()
    rpy = transform.rpy()
    lines = ["At time 1790580004.20000000", f"- Translation: [{row(transform.xyz)}]"]
    lines += [f"- Rotation: in Quaternion [{row((x, y, z, w))}]"] if "q" in only else []
    lines += [f"- Rotation: in RPY (radian) [{row(rpy)}]"] if "r" in only else []
    lines += [f"- Rotation: in RPY (degree) [{row(map(math.degrees, rpy))}]"] if "d" in only else []
    if "m" in only:
        matrix = [(*turn, at) for turn, at in zip(transform.rows, transform.xyz, strict=True)]
        lines += ["- Matrix:"]
        lines += ["".join(f" {value:6.{decimals}f}" for value in values) for values in (*matrix, (0, 0, 0, 1))]
    return "\n".join(lines) + "\n"


def test_the_values_that_the_guide_recorded_are_as_described() -> None:
    text = (RECORDINGS / "guide.txt").read_text("utf-8")
    verdict = judged(text, pose=TUCK)
    assert verdict.findings == ()
    assert len(verdict.data.answers) == len(RECORDED["tf"]) == 5
    for answer, recorded in zip(verdict.data.answers, RECORDED["tf"], strict=True):
        assert (answer.source, answer.target) == (recorded["from"], recorded["to"])
        assert answer.readings[0].xyz == pytest.approx(recorded["translation"], abs=1e-12)


def test_without_the_yaw_of_the_laser_they_are_not(tmp_path: Path) -> None:
    text = (RECORDINGS / "guide.txt").read_text("utf-8")
    path = copy_of_rosorin(tmp_path, {"lidar_and_imu.yaml": ("rpy: [0, 0, 180 deg]", "rpy: [0, 0, 0]")})
    made = compile_robot(path)
    assert made.robot is not None
    verdict = verify(made.robot, made.artifacts, "-", Options(pose=TUCK), standard_input=text.encode)
    assert [finding.message for finding in verdict.findings] == [
        "base_link -> laser is turned by 180 deg about z against the description"
    ]
    other = judged(text.replace("180.000", "0.000"), pose=TUCK)
    assert rules(other) == ["mounted-backwards"]


@pytest.mark.parametrize(
    ("line", "shown"),
    [
        ("- Translation: [0.148, 0.000, 0.107]", "printed:   0.148 0 0.107 m (line 2)"),
        ("- Rotation: in RPY (degree) [0.000, -0.000, 90.000]", "printed:   0 0 90 deg (line 2)"),
    ],
)
def test_only_what_was_printed_is_shown_as_printed(line: str, shown: str) -> None:
    (finding,) = judged(f"ros2 run tf2_ros tf2_echo base_link laser\n{line}\n").findings
    assert finding.evidence[1] == shown


def test_a_pasted_session_is_read_part_by_part() -> None:
    verdict = judged((RECORDINGS / "session.txt").read_text("utf-8"))
    assert verdict.findings == ()
    recording = verdict.data
    assert [(answer.source, answer.target, len(answer.readings)) for answer in recording.answers] == [
        ("base_link", "camera_link", 4),
        ("base_link", "camera_link", 4),
    ]
    assert recording.joints.reported["joint5"].highest == 0.0041887902047863905
    assert [series.compared for series in recording.series.values()] == [1]
    assert [(use.topic, use.frame) for use in recording.uses] == [("/scan", "laser")]


@pytest.mark.parametrize("change", ["0.219", "[0.023, 0.001, 0.289]", "0.998", "0.017  1.000", "1.9058995431778076"])
def test_any_number_of_it_that_is_another_is_found(change: str) -> None:
    text = (RECORDINGS / "session.txt").read_text("utf-8")
    assert change in text
    numbers = {"0.219": "0.229", "0.998": "0.988", "1.9058995431778076": "1.9158995431778076"}
    numbers |= {"[0.023, 0.001, 0.289]": "[0.025, 0.001, 0.289]", "0.017  1.000": "0.037  1.000"}
    assert "edge-wrong-value" in rules(judged(text.replace(change, numbers[change])))


ANGLE = st.floats(-2.0, 2.0)
QUARTER = st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi])


@settings(max_examples=60, deadline=None)
@given(st.tuples(ANGLE, ANGLE, ANGLE, ANGLE, ANGLE), st.sampled_from(["qrdm", "d", "r", "q", "m"]), st.data())
def test_what_tf2_echo_prints_of_any_pose_is_as_described(
    arm: tuple[float, ...], only: str, data: st.DataObject
) -> None:
    positions = dict(zip(bags.ARM, arm, strict=True))
    source, target = data.draw(st.permutations(["base_link", "link3", "camera_link", "depth_camera_link", "laser"]))[:2]
    text = f"$ tf2_echo {source} {target}\n{echo(bags.robot().transform(source, target, positions), only=only)}"
    assert judged(text, pose=positions).findings == ()


@settings(max_examples=60, deadline=None)
@given(st.tuples(QUARTER, QUARTER, QUARTER), st.sampled_from(["d", "r", "q", "m"]))
def test_a_turn_about_any_axes_is_found_in_every_form(rpy: tuple[float, float, float], only: str) -> None:
    """Where pitch is 90 degrees there are many RPY for one rotation: none of them is taken for another rotation."""
    right = bags.robot().joint_to["laser"].transform()
    turn = Pose((0.0, 0.0, 0.0), rpy).transform()
    verdict = judged(f"tf2_echo base_link laser\n{echo(right.then(turn), only=only)}")
    same = max(
        abs(a - b)
        for mine, its in zip(turn.rows, Transform().rows, strict=True)
        for a, b in zip(mine, its, strict=True)
    )
    assert bool(verdict.findings) == (same > 1e-6)


@pytest.mark.parametrize("file", ["frames.gv", "frames.yaml.txt", "log"])
def test_view_frames(file: str) -> None:
    text = (RECORDINGS / ("frames.yaml.txt" if file == "log" else file)).read_text("utf-8")
    if file == "log":
        text = f"[INFO] [1790580099.1] [view_frames]: Result:tf2_msgs.srv.FrameGraph_Response(frame_yaml={text!r})\n"
    verdict = judged(text)
    assert verdict.findings == ()
    assert len(verdict.data.rows) == 15


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('"base_link" -> "laser"', '"base_link" -> "lasr"', ["edge-missing", "edge-not-described"]),
        ('"base_link" -> "laser"', '"link1" -> "laser"', ["edge-wrong-parent"]),
        ("Recorded at time: 1790580099.9", "Recorded at time: 1790580109.9", ["edge-stale"] * 7),
        (
            '"laser"[label=" Broadcaster: default_authority\\nAverage rate: 10000.0',
            '"laser"[label=" Broadcaster: default_authority\\nAverage rate: 10.0',
            ["edge-not-static"],
        ),
    ],
)
def test_faults_in_view_frames(old: str, new: str, expected: list[str]) -> None:
    said = (RECORDINGS / "frames.gv").read_text("utf-8")
    assert old in said
    assert rules(judged(said.replace(old, new))) == expected


XYZ = "- Translation: [0.048, 0.000, 0.107]\n"
REFUSED = 'Waiting for transform base_link ->  laser: Invalid frame ID "laser" passed to canTransform argument'


@pytest.mark.parametrize(
    ("text", "options", "rule", "subject"),
    [
        ("", {}, "text-not-understood", "the recording"),
        ("$ tf2_echo base_link laser\nAt time 0.0\nnonsense\n", {}, "text-not-understood", "line 2"),
        ("hello\nworld\n", {}, "text-not-understood", "the recording"),
        (XYZ, {}, "text-frames", "line 1"),
        (XYZ, {"frames": ("base_link", "lasr")}, "frame-unknown", "base_link -> lasr"),
        (f"tf2_echo base_link link3\n{XYZ}", {}, "not-compared", "base_link -> link3"),
        (f"tf2_echo map laser\n{XYZ}", {}, "not-compared", "map -> laser"),
        (f"{REFUSED}\n", {}, "edge-missing", "base_link -> laser"),
        ('digraph G { "No tf data received" }\n', {}, "recording-foreign", "line 1"),
        ("digraph G {\n", {}, "text-not-understood", "line 1"),
        (
            "ros2 topic echo /tf\ntransforms:\n- header:\n    stamp:\n      sec: 1\n",
            {},
            "text-not-understood",
            "line 2",
        ),
        ("header:\n  stamp: {sec: 1, nanosec: 2}\n  frame_id: laser_link\n", {}, "frame-unknown", "the message"),
    ],
)
def test_text_that_says_too_little(text: str, options: dict[str, Any], rule: str, subject: str) -> None:
    verdict = judged(text, **options)
    assert [(finding.rule, finding.subject) for finding in verdict.findings] == [(rule, subject)]
    assert verdict.fails()
    is_about_robot = rule in ("edge-missing", "frame-unknown")
    assert is_about_robot or summary(verdict, "rosorin", strict=False).startswith("rosorin: could not be compared")


def test_a_joint_that_is_no_number_stands_nowhere() -> None:
    text = (RECORDINGS / "session.txt").read_text("utf-8").replace("- 1.9058995431778076", "- .inf")
    assert [finding.message for finding in judged(text).findings] == [
        "joint3 is no number in 1 of 1 (100 %) messages of /joint_states",
        "base_link -> camera_link cannot be compared: where joint3 stood is not known",
    ]


EVERYTHING = "\n".join(
    (RECORDINGS / name).read_text("utf-8") for name in ("session.txt", "frames.gv", "frames.yaml.txt", "guide.txt")
)


@settings(max_examples=80, deadline=None)
@given(st.data())
def test_damaged_text_is_judged_without_a_traceback(data: st.DataObject) -> None:
    """Lines are lost, doubled or cut, numbers become words: whatever is left is compared, or it is said why not."""
    lines = EVERYTHING.splitlines()
    for _ in range(data.draw(st.integers(1, 12))):
        at = data.draw(st.integers(0, len(lines) - 1))
        cut = data.draw(st.integers(0, len(lines[at])))
        put = data.draw(
            st.sampled_from(["", "nan", "-", ":", "[", "{", "1e999", "\t", "&a", "*a", "'", "\x85", "---\n"])
        )
        lines[at] = data.draw(st.sampled_from([lines[at][:cut], lines[at][:cut] + put + lines[at][cut + 1 :], put]))
        if data.draw(st.booleans()):
            del lines[at]
    verdict = judged("\n".join(lines))
    assert all(finding.message and finding.rule for finding in verdict.findings)


SESSION = data_text("robots/verify_pasted.txt")
BACKWARDS = (
    SESSION.replace("1.000, 0.000]", "0.000, 1.000]")
    .replace("3.142", "0.000")
    .replace("180.000", "0.000")
    .replace("-1.000", " 1.000")
)


def before(front: str) -> Callable[[str], str]:
    """Put a text before each line; {} is its number."""
    return lambda text: "\n".join(front.format(f"{at:02d}") + line for at, line in enumerate(text.splitlines()))


def folded(text: str) -> str:
    return "\n".join(line[at : at + 80] for line in text.splitlines() for at in range(0, max(1, len(line)), 80))


WAYS: dict[str, Callable[[str], str]] = {
    "as it is": str,
    "Windows": lambda text: text.replace("\n", "\r\n"),
    "colours": lambda text: (
        text.replace("[INFO]", "\x1b[0m\x1b[32m[INFO]\x1b[0m")
        .replace("robot@ubuntu", "\x1b]0;robot@ubuntu: ~\x07\x1b[01;32mrobot@ubuntu\x1b[00m")
        .replace("- Trans", "\x1b[K- \x1b[1mTrans")
    ),
    "a log with times": before("[12:00:{}.123] "),
    "a log with dates": before("2026-11-20T12:00:{}.123Z "),
    "ts": before("Nov 20 12:00:{} "),
    "seconds": before("[1712345678.1234{}] "),
    "tmux": before("│"),
    "a quotation": before("> "),
    "indented": before("    "),
    "80 columns": folded,
    "Jazzy": lambda text: text.replace("Quaternion [", "Quaternion (xyzw) [").replace("0.0\n", "1712.000000001\n", 1),
    "with a slash": lambda text: text.replace("base_link laser", "/base_link /laser"),
    "with options": lambda text: text.replace("base_link laser", "base_link laser 1.0 --ros-args -p a:=true"),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_session_is_read_however_it_was_pasted(way: str) -> None:
    right = judged(WAYS[way](SESSION))
    assert right.findings == ()
    assert [len(answer.readings) for answer in right.data.answers] == [4]
    assert rules(judged(WAYS[way](BACKWARDS))) == ["mounted-backwards"]


def test_the_topic_may_stand_behind_its_options() -> None:
    message = """transforms:
- header: {stamp: {sec: 1, nanosec: 5}, frame_id: base_link}
  child_frame_id: laser
  transform:
    translation: {x: 0.048156, y: 7.6e-05, z: 0.106748}
    rotation: {x: 0.0, y: 0.0, z: 1.0, w: 6.123233995736766e-17}
---
average rate: 10.002
"""
    for words in ("--once /tf_static", "/tf_static --once", "--qos-durability transient_local --once /tf_static"):
        assert rules(judged(f"$ ros2 topic echo {words}\n{message}")) == []
    assert rules(judged(f"$ ros2 topic echo /tf\n{message}")) == ["edge-not-static"]

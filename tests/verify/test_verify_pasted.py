"""Sessions of tf2_echo as they come out of terminals, logs and mails."""

from collections.abc import Callable

import pytest

from support.bags import judged, rules
from support.paths import data_text

SESSION = data_text("robots/verify_pasted.txt")
BACKWARDS = (
    SESSION.replace("1.000, 0.000]", "0.000, 1.000]")
    .replace("3.142", "0.000")
    .replace("180.000", "0.000")
    .replace("-1.000", " 1.000")
)


def before(front: str) -> Callable[[str], str]:
    """Return what puts a text before each line; {} is its number."""
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
    "with options": lambda text: text.replace(
        "base_link laser", "base_link laser 1.0 --ros-args -p use_sim_time:=true"
    ),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_session_is_read_however_it_was_pasted(way: str) -> None:
    right, wrong = judged("-", WAYS[way](SESSION)), judged("-", WAYS[way](BACKWARDS))
    assert rules(right) == []
    assert [len(answer.readings) for answer in right.data.answers] == [4]
    assert rules(wrong) == ["mounted-backwards"]


def test_an_answer_without_numbers_is_not_as_described() -> None:
    text = "$ ros2 run tf2_ros tf2_echo base_link laser\nAt time 0.0\nnonsense\n"
    verdict = judged("-", text)
    (found,) = verdict.findings
    assert (found.rule, found.severity) == ("text-not-understood", "error")
    assert found.message == "line 2 begins an answer of tf2_echo, but it cannot be read"
    assert verdict.data.answers == []


def test_the_topic_may_stand_behind_its_options() -> None:
    message = """transforms:
- header: {stamp: {sec: 1, nanosec: 5}, frame_id: base_link}
  child_frame_id: laser
  transform:
    translation: {x: 0.048156, y: 7.6e-05, z: 0.106748}
    rotation: {x: 0.0, y: 0.0, z: 1.0, w: 6.123233995736766e-17}
---
average rate: 10.002
\tmin: 0.098s max: 0.102s std dev: 0.00099s window: 12
"""
    for words in ("--once /tf_static", "/tf_static --once", "--qos-durability transient_local --once /tf_static"):
        assert rules(judged("-", f"$ ros2 topic echo {words}\n{message}")) == []
    assert rules(judged("-", f"$ ros2 topic echo /tf\n{message}")) == ["edge-not-static"]

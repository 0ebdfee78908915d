"""verify on text that people paste, in every form and way; what it prints: commands/verify-text.md."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.model import Pose, Transform
from rosorin_compile.recordings.results import Verification
from support import bags
from support.bags import rules
from support.paths import DATA, data_text

RECORDINGS = DATA / "recordings"


def judged(text: str, **options: Any) -> Verification:
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

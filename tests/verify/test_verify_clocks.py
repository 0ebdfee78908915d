"""verify on recordings whose stamps are of several clocks: told as clocks, once; what is on purpose is not told."""

import copy
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.recordings.results import Verified, table
from support import bags
from support.bags import SECOND, START, TYPES, Message, judged, ns, stamped, time
from support.paths import DATA

pytestmark = pytest.mark.slow

Change = Callable[[list[Message]], list[Message]]
Stamp = Callable[[int], int]
CLOCK = "rosgraph_msgs/msg/Clock"


def of(message: Message, name: str) -> bool:
    child = message.content.transforms[0].child_frame_id if message.topic == "/tf" else ""
    return name in (message.topic, child)


def node(names: set[str], new: Stamp, since: float = -99.0, until: float = 99.0) -> Change:
    def change(messages: list[Message]) -> list[Message]:
        return [
            stamped(message, new)
            if any(of(message, name) for name in names) and ns(since) < message.received <= ns(until)
            else message
            for message in messages
        ]

    return change


def by(seconds: float) -> Stamp:
    return lambda at: at + round(seconds * SECOND)


def simulated(at: int) -> int:
    return at - START


def clock(messages: list[Message]) -> list[Message]:
    """A simulation with its clock; the recorder runs on the wall clock."""
    made = [stamped(message, simulated) for message in messages]
    return made + [
        Message(START + at, "/clock", CLOCK, TYPES[CLOCK](time(at))) for at in range(0, 12 * SECOND, SECOND // 50)
    ]


def all_but_the_imu(change: Change) -> Change:
    def changed(messages: list[Message]) -> list[Message]:
        kept = copy.deepcopy([message for message in messages if message.topic == "/imu/data"])
        return change([message for message in messages if message.topic != "/imu/data"]) + kept

    return changed


def clock_of_others(messages: list[Message]) -> list[Message]:
    """Somebody plays /clock; nobody of the robot listens to it."""
    return messages + [message for message in clock([]) if message.topic == "/clock"]


def received(new: Stamp) -> Change:
    return lambda messages: [message._replace(received=new(message.received)) for message in messages]


def without_battery(messages: list[Message]) -> list[Message]:
    made = [
        message if message.received > ns(6.0) else stamped(message, by(50 - START / SECOND)) for message in messages
    ]
    return received(lambda at: at if at > ns(6.0) else at - START + 50 * SECOND)(made)


def drifting(messages: list[Message]) -> list[Message]:
    return [
        stamped(message, by(0.08 * (message.received - START) / SECOND)) if of(message, "base_link") else message
        for message in messages
    ]


def busy_network(messages: list[Message]) -> list[Message]:
    chance, made, last = random.Random(3), [], 0  # noqa: S311
    for message in messages:
        if message.topic == "/camera/depth/image":
            late = 0.7 if ns(4.0) < message.received < ns(6.0) else chance.uniform(0.0, 0.08)
            last = max(last + 1, message.received + round(late * SECOND))
            message = message._replace(received=last)
        made.append(message)
    return made


ARM = {"link1", "/joint_states"}
# What happens to the stamps, and what is told, in all.
CLOCKS: dict[str, tuple[Change, list[str]]] = {
    "AMCL dates a second ahead": (node({"odom"}, by(1.0)), []),
    "slam_toolbox dates half a second ahead": (node({"odom"}, by(0.5)), []),
    "localisation, too far ahead": (
        node({"odom"}, by(1.502)),
        ["warning[stamp-ahead] map -> odom (slam_toolbox or amcl)"],
    ),
    "a computer, a minute ahead": (node({"base_link"}, by(60.0)), ["warning[stamp-ahead] odom -> base_link (ekf)"]),
    "a computer, an hour ahead": (
        node({"base_link"}, by(3600.0)),
        ["error[stamp-other-clock] odom -> base_link (ekf)"],
    ),
    "a computer, an hour behind": (
        node({"base_link"}, by(-3600.0)),
        ["error[stamp-other-clock] odom -> base_link (ekf)"],
    ),
    "the arm and its computer ahead": (node(ARM, by(30.0)), ["warning[stamp-ahead] /joint_states"]),
    "a scanner ahead": (node({"/scan"}, by(3.01)), ["warning[stamp-ahead] /scan"]),
    "two computers ahead": (
        lambda messages: node({"/scan"}, by(3.01))(node({"base_link"}, by(20.0))(messages)),
        ["warning[stamp-ahead] odom -> base_link (ekf)", "warning[stamp-ahead] /scan"],
    ),
    "the clock of the recorder is behind": (
        lambda messages: [stamped(message, by(30.0)) for message in messages],
        ["warning[stamp-ahead] /joint_states"],
    ),
    "a clock that is set forward": (
        node({"base_link"}, by(0.6), since=6.0),
        ["warning[stamp-clock-set] odom -> base_link (ekf)"],
    ),
    "a clock that drifts": (drifting, ["warning[stamp-clock-set] odom -> base_link (ekf)"]),
    "a clock that hears the time late": (
        node({"base_link"}, by(50 - START / SECOND), until=6.0),
        ["warning[stamp-clock-set] odom -> base_link (ekf)"],
    ),
    "the clock of the recorder is set": (
        received(lambda at: at + 30 * SECOND if at > ns(6.0) else at),
        ["warning[recording-silent] the recording", "warning[stamp-clock-set] odom -> base_link (ekf)"],
    ),
    "a computer without a battery": (without_battery, ["warning[recording-silent] the recording"]),
    "a recorder without a battery": (
        received(lambda at: at - START + 50 * SECOND),
        ["warning[recording-other-clock] the recording"],
    ),
    "one node with the time of a simulation": (
        node({"base_link", "/scan"}, simulated),
        ["error[stamp-other-clock] odom -> base_link (ekf)"],
    ),
    "all nodes but one": (
        all_but_the_imu(lambda messages: [stamped(message, simulated) for message in messages]),
        ["error[stamp-other-clock] odom -> base_link (ekf)"],
    ),
    "a simulation, and a driver without use_sim_time": (
        all_but_the_imu(clock),
        ["error[stamp-other-clock] /imu/data", "note[recording-other-clock] the recording"],
    ),
    "a clock that nobody listens to": (clock_of_others, []),
    "a network that is busy": (busy_network, []),
    "no stamps at all": (
        lambda messages: [stamped(message, lambda _: 0) for message in messages],
        ["error[stamp-zero] odom -> base_link (ekf)", "note[not-compared] /joint_states"],
    ),
    "one stamp that is none": (
        node({"base_link"}, lambda _: 0, since=5.0, until=5.01),
        ["error[stamp-zero] odom -> base_link (ekf)"],
    ),
}


def of_clock(folder: Path, change: Change, **options: Any) -> Verified:
    return judged(bags.bag(folder / "bag", "mcap", change=change), **options)


@pytest.mark.parametrize("name", CLOCKS)
def test_the_fault_of_a_clock_is_one_finding(tmp_path: Path, name: str) -> None:
    change, expected = CLOCKS[name]
    verdict = of_clock(tmp_path, change)
    assert [f"{one.severity}[{one.rule}] {one.subject}" for one in verdict.findings] == expected


def test_the_table_says_how_far_ahead_an_edge_is_dated(tmp_path: Path) -> None:
    def ages(number: int, change: Change) -> dict[str, str]:
        rows = table(of_clock(tmp_path / str(number), change))
        at = rows[0].index("age, oldest"), rows[0].index("value")
        return {row.split("  ")[0]: row[at[0] : at[1]].strip() for row in rows[1:16]}

    def two(messages: list[Message]) -> list[Message]:
        return node({"odom"}, by(1.0))(node({"base_link"}, by(3600.0))(node({"link1"}, lambda _: 0)(messages)))

    assert ages(0, lambda messages: messages)["map -> odom"] == "2.0 ms, 52 ms"
    found = ages(1, two)
    assert found["map -> odom"] == "998 ms ahead, 0.0 ms"
    assert found["odom -> base_link"] == "3600.0 s ahead: another clock"
    assert found["base_link -> link1"] == "no stamp"


def test_what_is_late_because_of_its_clock_is_said_so(tmp_path: Path) -> None:
    stale = of_clock(tmp_path, node({"base_link"}, by(-3.0))).findings
    assert [finding.rule for finding in stale] == ["edge-stale"]
    help = "even its freshest stamp was 3.0 s old when it came: look at the clock of ekf, or what delays it"
    assert stale[0].help == f"{help} (--stale: 1.0 s)"


@pytest.mark.parametrize(
    ("now", "rule", "message"),
    [
        ("12.5", "stamp-other-clock", "stamped by another clock, 56.7 years ahead"),
        ("3590580099.9", "stamp-other-clock", "stamped by another clock, 57.0 years behind"),
        ("1790580090.0", "stamp-ahead", "dated 9.9 s ahead of the time when they were recorded"),
    ],
)
def test_clocks_of_what_view_frames_saw(now: str, rule: str, message: str) -> None:
    text = (DATA / "recordings" / "frames.gv").read_text("utf-8")
    assert "Recorded at time: 1790580099.9" in text
    verdict = judged("-", text.replace("Recorded at time: 1790580099.9", f"Recorded at time: {now}"))
    names = "base_link -> link1, link1 -> link2, link2 -> link3 and 4 more are"
    assert [(finding.rule, finding.message) for finding in verdict.findings] == [(rule, f"{names} {message}")]
    assert any("ahead" in row for row in table(verdict)) == ("behind" not in message)

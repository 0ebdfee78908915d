"""verify decodes as rosbags does, and its numbers depend neither on batches nor on the length."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.model import Transform
from rosorin_compile_verify import bags as reading
from rosorin_compile_verify import cdr
from rosorin_compile_verify.judge import Verdict
from support import bags
from support.bags import STORE, TYPES, judged

TF = "tf2_msgs/msg/TFMessage"


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return a short clean recording in both storages."""
    folder = tmp_path_factory.mktemp("clean")
    return {storage: bags.bag(folder / storage, storage, seconds=3.0) for storage in ("sqlite3", "mcap")}


NAMES = st.text("abc_/é1", min_size=1, max_size=9)
NUMBERS = st.floats(-1e3, 1e3)
STAMPS = st.integers(-(2**31) * bags.SECOND, 2**31 * bags.SECOND - 1)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.lists(st.tuples(STAMPS, NAMES, NAMES, NUMBERS), max_size=4), max_size=12), st.booleans())
def test_transforms_are_decoded_as_rosbags_decodes_them(messages: list[list[Any]], big: bool) -> None:
    raws = []
    for transforms in messages:
        made = [bags.transform_message(s, p, c, Transform(xyz=(x, -x, 1.0))) for s, p, c, x in transforms]
        raws.append(bytes(STORE.serialize_cdr(TYPES[TF](made), TF, little_endian=not big)))
    found: dict[tuple[int, int], tuple[Any, ...]] = {}
    broken: list[str] = []
    for group in cdr.Reader(cdr.transforms).groups(raws, broken) if raws else ():
        for at, item in enumerate(group.layout.items):
            stamps, numbers = group.stamps(item.stamp), group.doubles(item.numbers, 7)
            for row, place in enumerate(group.places):
                found[int(place), at] = (int(stamps[row]), item.parent, item.child, *map(float, numbers[row]))
    wanted = {}
    for place, raw in enumerate(raws):
        for at, t in enumerate(STORE.deserialize_cdr(raw, TF).transforms):
            v, q = t.transform.translation, t.transform.rotation
            stamp = t.header.stamp.sec * bags.SECOND + t.header.stamp.nanosec
            wanted[place, at] = (stamp, t.header.frame_id, t.child_frame_id, v.x, v.y, v.z, q.x, q.y, q.z, q.w)
    assert found == wanted
    assert broken == []


@settings(max_examples=40, deadline=None)
@given(st.lists(NAMES, max_size=6), st.lists(st.tuples(STAMPS, st.lists(NUMBERS, max_size=6)), min_size=1, max_size=8))
def test_joint_states_are_decoded_as_rosbags_decodes_them(names: list[str], states: list[Any]) -> None:
    kind = "sensor_msgs/msg/JointState"
    raws = [bytes(STORE.serialize_cdr(bags.joint_state(stamp, tuple(names), values), kind)) for stamp, values in states]
    found = {}
    for group in cdr.Reader(cdr.joint_state).groups(raws, []):
        item = group.layout.items[0]
        assert item.names == tuple(names)
        stamps, positions = group.stamps(item.stamp), group.doubles(item.numbers, item.size)
        for row, place in enumerate(group.places):
            found[int(place)] = (int(stamps[row]), list(map(float, positions[row])))
    assert found == dict(enumerate(states))


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=120))
def test_any_bytes_are_a_message_or_a_reason(raw: bytes) -> None:
    for of in (cdr.transforms, cdr.joint_state):
        broken: list[str] = []
        groups = list(cdr.Reader(of).groups([raw], broken))
        assert len(groups) + len(broken) == 1


@pytest.mark.parametrize("size", [7, 100])
def test_the_numbers_do_not_depend_on_the_batches(
    clean: dict[str, Path], monkeypatch: pytest.MonkeyPatch, size: int
) -> None:
    whole = facts(judged(clean["mcap"]))
    monkeypatch.setattr(reading, "BATCH", size)
    assert facts(judged(clean["mcap"])) == whole


def facts(verdict: Verdict) -> dict[str, Any]:
    """Return what is kept of a recording, in whole numbers."""
    found: dict[str, Any] = {"findings": verdict.findings}
    for series in verdict.recording.series.values():
        pace, values = series.pace, series.values
        found[series.name] = (pace.count, pace.first, pace.last, pace.newest, round(pace.gap.seconds * 1e9))
        found[f"{series.name} ages"] = (round(pace.mean_age * 1e9), round(pace.oldest.seconds * 1e9), pace.twice)
        found[f"{series.name} bins"] = pace.bins.counts.tolist()
        found[f"{series.name} values"] = (values.compared, values.by_state, values.wrong, series.leaps.returns)
    for log in verdict.recording.sensors.values():
        for use in log.frames.values():
            asked = [(look.target, look.asked, look.failed) for look in use.lookups.values()]
            found[f"{log.topic} {use.frame}"] = (use.pace.count, use.early, asked)
    return found


@pytest.mark.slow
def test_what_is_kept_does_not_grow_with_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Counted, not measured: the arrays that are kept after four times the length are not larger."""
    monkeypatch.setattr(reading, "BATCH", 500)
    monkeypatch.setattr("rosorin_compile_verify.joints.REMEMBERED", 100)
    short = judged(bags.bag(tmp_path / "short", seconds=15.0)).recording
    long = judged(bags.bag(tmp_path / "long", seconds=60.0)).recording
    assert long.messages > 3.9 * short.messages
    assert size_of(long) <= 1.1 * size_of(short)


def size_of(value: Any, known: set[int] | None = None) -> int:
    """Return the bytes of all arrays, and the number of entries, that hang on a value."""
    known = set() if known is None else known
    if id(value) in known or isinstance(value, type):
        return 0
    known.add(id(value))
    if isinstance(value, np.ndarray):
        return int(value.nbytes)
    if isinstance(value, dict):
        return len(value) + sum(size_of(each, known) for each in [*value.keys(), *value.values()])
    if isinstance(value, (list, tuple, set, frozenset)):
        return len(value) + sum(size_of(each, known) for each in value)
    return sum(size_of(each, known) for each in vars(value).values()) if hasattr(value, "__dict__") else 0

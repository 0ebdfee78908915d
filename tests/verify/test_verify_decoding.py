"""The numbers of verify depend neither on batches nor on the length of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rosorin_compile.recordings import bags as reading
from rosorin_compile.recordings.judge import Verdict
from support import bags
from support.bags import judged


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
    monkeypatch.setattr("rosorin_compile.recordings.joints.REMEMBERED", 100)
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

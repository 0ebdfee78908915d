"""Sensors: the frames that stamped messages name, and whether tf2 could have placed them when they came."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..arrays import SECOND, Times
from .pace import Pace
from .series import Series

MAX_FRAMES = 32


class Headers(NamedTuple):
    """The headers of the messages of one topic and frame in one batch: received and stamp, ns (n,)."""

    received: Times
    stamp: Times


@dataclass
class Lookups:
    """Transforms asked for at the exact stamps of messages, when they came: how many, how many failed, and by how much.

    The lag (s) is how far the newest sample of the slowest edge was behind the stamp; ``slowest`` counts, edge by
    edge, how often it was the one.
    """

    target: str
    asked: int = 0
    failed: int = 0
    lag_sum: float = 0.0
    lag_most: float = 0.0
    slowest: dict[str, int] = field(default_factory=dict)

    @property
    def mean_lag(self) -> float:
        """The mean lag (s) of those that failed."""
        return self.lag_sum / self.failed if self.failed else 0.0


@dataclass
class FrameUse:
    """One frame that the messages of a topic name."""

    frame: str
    pace: Pace = field(default_factory=Pace)
    early: int = 0  # messages that came before the frame was in the tree
    last_early: int = 0
    ready: int | None = None  # when it was in the tree
    waited_for: str = ""  # the edge that came last
    lookups: dict[str, Lookups] = field(default_factory=dict)


class SensorLog:
    """The stamped messages of one topic."""

    def __init__(self, topic: str, kind: str) -> None:
        self.topic, self.kind = topic, kind
        self.frames: dict[str, FrameUse] = {}

    def add(self, frame: str, headers: Headers, start: int) -> FrameUse | None:
        """Take the headers of one batch that name one frame."""
        if frame not in self.frames and len(self.frames) >= MAX_FRAMES:
            return None
        use = self.frames.setdefault(frame, FrameUse(frame))
        use.pace.add(headers.received, headers.stamp, start)
        return use


def ready_at(chain: Sequence[Series], start: int) -> tuple[int, str]:
    """Return from when on (ns) all edges of a chain were there, and the edge that came last.

    An edge on /tf_static was there since it was stamped: a recorder that joins later gets it late. One on /tf that
    comes within the first second of a recording was there before.
    """
    ready, last = start, ""
    for series in chain:
        came = series.pace.first
        if series.still and series.pace.first_stamp > 0:
            came = min(came, series.pace.first_stamp)
        elif not series.still and came - start <= SECOND:
            came = start
        if came > ready:
            ready, last = came, series.name
    return ready, last


def look_up(use: FrameUse, headers: Headers, chain: Sequence[Series], target: str) -> None:
    """Ask for the transform to ``target`` at each stamp, with what had been received by then.

    tf2 answers at a stamp if every moving edge of the chain has a sample on both sides of it
    (tf2/src/time_cache.cpp, ExtrapolationException).
    """
    moving = [series for series in reversed(chain) if not series.still]
    lookups = use.lookups.setdefault(target, Lookups(target))
    begin = max([series.pace.first_stamp for series in moving] + [use.ready or 0])
    fit = (headers.stamp >= begin) & (headers.received >= begin)
    received, stamp = headers.received[fit], headers.stamp[fit]
    lookups.asked += len(stamp)
    if not moving or not len(stamp):
        return
    lags = np.stack([stamp - newest_at(series, received) for series in moving])
    worst = lags.argmax(axis=0)
    lag = lags[worst, np.arange(len(stamp))]
    failed = lag > 0
    lookups.failed += int(np.count_nonzero(failed))
    if not failed.any():
        return
    late = lag[failed] / SECOND
    lookups.lag_sum += float(late.sum())
    lookups.lag_most = max(lookups.lag_most, float(late.max()))
    for at, count in zip(*np.unique(worst[failed], return_counts=True), strict=True):
        name = moving[int(at)].name
        lookups.slowest[name] = lookups.slowest.get(name, 0) + int(count)


def newest_at(series: Series, received: Times) -> Times:
    """Return the newest stamp (n,) that an edge had at times of this batch (n,), a very small one where it had none."""
    before = np.iinfo(np.int64).min // 2 if series.known_before is None else series.known_before
    at = np.searchsorted(series.known[0], received, side="right") - 1
    if not series.known.shape[1]:
        return np.full(len(received), before)
    return np.where(at >= 0, series.known[1, np.maximum(at, 0)], before)

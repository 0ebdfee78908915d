"""Clock: the times of arrival in the clock of the stamps, where the recorder had another one.

A simulated robot stamps with the time of its simulation, and a bag that is played with that of its first recording. A
recorder that runs on the wall clock then writes times of arrival from which no age follows.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...diagnostic import NOTE, WARNING
from ...registry import RECORDINGS, Rule
from ..arrays import SECOND, Times
from ..findings import problem
from ..recording.recording import Recording
from .topics import CLOCK, HEADER, JOINTS, TF, Topic

RULES = (
    Rule(
        "recording-other-clock",
        "A warning, or a note with `/clock`: all stamps are of another clock than that of the recorder, as in a "
        "simulation or in a bag that was played. Ages are told by the clock of the stamps.",
        "`ros2 bag record --use-sim-time`; or set the clocks of the computers.",
        RECORDINGS,
    ),
)

# Stamps and times of arrival that are all farther apart than this are of two clocks.
APART = 60 * SECOND
_STAMPS = {0: struct.Struct(">iI"), 1: struct.Struct("<iI")}
# Where the first stamp of a message stands; of /tf behind the number of its transforms.
_PLACES = {TF: 8, JOINTS: 4, HEADER: 4, CLOCK: 4}


class Clock:
    """Tells whether a recording has two clocks, and puts times of arrival into that of the stamps."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.other: bool | None = None  # whether there are two; None as long as no stamp was seen
        self._last: tuple[int, int] | None = None  # received, and the time of the stamps then

    def put(self, waiting: Mapping[int, Any], topics: Mapping[int, Topic]) -> None:
        """Put the times of arrival of a batch into the clock of its stamps, if that is another one."""
        if self.other is False:
            return
        stamps = _stamps(waiting, topics)
        if self.other is None and stamps:
            self._decide(stamps)
        if not self.other:
            return
        received, now = self._now(stamps, topics)
        for times, _, _ in waiting.values():
            times[:] = np.interp(times, received, now).astype(np.int64).tolist() if len(received) else times

    def _decide(self, stamps: Mapping[int, tuple[Times, Times]]) -> None:
        """Decide by the first stamps: each topic has to be far off, for one alone is a fault of its node."""
        apart = {key: float(np.median(received - stamp)) for key, (received, stamp) in stamps.items()}
        self.other = all(abs(far) > APART for far in apart.values())
        if not self.other:
            return
        self.recording.start, self.recording.end = None, 0
        simulated = "/clock" in self.recording.topics
        far = f"{min(map(abs, apart.values())) / SECOND:,.0f} s"
        message = (
            f"the stamps are of another clock than the recorder's, {far} apart: ages are told by that of the stamps"
        )
        help = "a simulation or a bag that is played does that; computers whose clocks differ do, too"
        if simulated:
            help = "a simulation does that; ros2 bag record --use-sim-time records in its time"
        severity = NOTE if simulated else WARNING
        self.recording.troubles.append(
            problem("recording-other-clock", "the recording", message, help, severity=severity)
        )

    def _now(self, stamps: Mapping[int, tuple[Times, Times]], topics: Mapping[int, Topic]) -> tuple[Times, Times]:
        """Return times of arrival, ascending, and what the clock of the stamps was then (ns).

        That is what /clock said; without it, the newest stamp of a message that is no transform: localisation stamps
        transforms with times to come.
        """
        kinds = {topics[key].kind for key in stamps}
        chosen = {CLOCK} if CLOCK in kinds else ({JOINTS, HEADER} & kinds or kinds)
        parts = [pair for key, pair in stamps.items() if topics[key].kind in chosen]
        if self._last is not None:
            parts.append((np.array([self._last[0]]), np.array([self._last[1]])))
        if not parts:
            return np.empty(0, np.int64), np.empty(0, np.int64)
        received, now = (np.concatenate(values) for values in zip(*parts, strict=True))
        order = np.argsort(received, kind="stable")
        received, now = received[order], now[order]
        if CLOCK not in chosen:
            if float(np.median(now)) < now[0] - SECOND:  # it began anew
                received, now = received[1:], now[1:]
            newest = np.maximum.accumulate(now)
            grown = np.concatenate(([True], newest[1:] > newest[:-1]))
            received, now = received[grown], newest[grown]
        self._last = (int(received[-1]), int(now[-1]))
        return received, now


def _stamps(waiting: Mapping[int, Any], topics: Mapping[int, Topic]) -> dict[int, tuple[Times, Times]]:
    """Return the times of arrival and the first stamps (ns) of the messages of each topic; those of zero are none."""
    stamps = {}
    for key, (times, raws, _) in waiting.items():
        place = _PLACES.get(topics[key].kind)
        if place is None:
            continue
        pairs = []
        for received, raw in zip(times, raws, strict=True):
            layout = _STAMPS.get(raw[1] if len(raw) >= place + 8 else 9)
            if layout is not None:
                whole, rest = layout.unpack_from(raw, place)
                pairs += [(received, whole * SECOND + rest)] if whole or rest else []
        if pairs:
            both = np.array(pairs, np.int64).T
            stamps[key] = (both[0], both[1])
    return stamps

"""Text of ros2 topic echo: messages as YAML. They carry stamps, but not when they were received."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...bounded import yaml_of
from ..arrays import SECOND, Samples
from ..recording.recording import MAX_DESCRIPTIONS, Batch, Recording

MAX_TRANSFORMS = 10_000


class TopicText:
    """The messages of a text. They are taken together at its end, so that the order of topics does not matter."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.batch = Batch()
        self.positions: dict[str, float] = {}
        self.number = 0

    def take(self, topic: str, text: str) -> str:
        """Take one message of a topic (empty if it is not known); return why it cannot be read, or nothing."""
        try:
            message = yaml_of(text)
        except ValueError as wrong:
            return str(wrong)
        if not isinstance(message, dict):
            return "it is no message"
        try:
            return self._message(topic, message)
        except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
            return "a value is missing or of another kind"

    def _message(self, topic: str, message: dict[str, Any]) -> str:
        self.recording.messages += 1
        if "transforms" in message:
            for entry in message["transforms"][:MAX_TRANSFORMS]:
                self._transform(topic, entry)
        elif "name" in message and "position" in message:
            self._joint_state(message)
        elif isinstance(message.get("data"), str) and "<robot" in message["data"]:
            self._robot(message["data"])
        elif isinstance(message.get("header"), dict):
            stamp = _stamp(message["header"])
            frame = self.recording.frame(str(message["header"].get("frame_id", "")))
            key = (topic or "the message", "", frame)
            self.batch.headers.setdefault(key, []).append((stamp, stamp))
        return ""

    def _transform(self, topic: str, entry: dict[str, Any]) -> None:
        stamp = _stamp(entry["header"])
        parent = self.recording.frame(str(entry["header"]["frame_id"]))
        child = self.recording.frame(str(entry["child_frame_id"]))
        moved, turned = entry["transform"]["translation"], entry["transform"]["rotation"]
        xyz = [float(moved[axis]) for axis in "xyz"]
        quaternion = [float(turned[axis]) for axis in "xyzw"]
        expected = self.recording.expected(parent, child)
        still = topic.endswith("tf_static") if topic else expected is not None and not expected.moving
        times = np.array([stamp], np.int64)
        samples = Samples(times, times, np.array([xyz]), np.array([quaternion]))
        self.batch.add_edge((still, parent, child), np.array([self.number]), samples)
        self.number += 1
        self.recording.span(stamp, stamp)

    def _joint_state(self, message: dict[str, Any]) -> None:
        names = tuple(str(name) for name in message["name"])
        values = np.array([[float(value) for value in message["position"]]], np.float64).reshape(1, -1)
        stamp = _stamp(message["header"]) if isinstance(message.get("header"), dict) else 0
        times = np.array([stamp], np.int64)
        self.recording.joints.pace.add(times, times, min(stamp, self.recording.start or stamp))
        self.recording.joints.add(names, times, times, values)
        pairs = zip(names, map(float, values[0]), strict=False)
        self.positions |= {name: value for name, value in pairs if np.isfinite(value)}

    def _robot(self, text: str) -> None:
        data = text.encode()
        if not text.endswith("...") and data not in self.recording.descriptions:
            self.recording.descriptions = [*self.recording.descriptions, data][:MAX_DESCRIPTIONS]

    def finish(self) -> None:
        """Hand on what was taken."""
        self.recording.topics |= {key[0]: key[1] for key in self.batch.headers}
        self.recording.take(self.batch)


def _stamp(header: dict[str, Any]) -> int:
    """Return the stamp of a header in ns."""
    stamp = header["stamp"]
    value = int(stamp["sec"]) * SECOND + int(stamp["nanosec"])
    if not -(2**62) < value < 2**62:
        raise ValueError("a time beyond all clocks")
    return value

"""Pasted: what people copy from a terminal. It may hold several things, one after the other.

The forms are those of ROS 2 Humble and Jazzy: tf2_ros/src/tf2_echo.cpp, tf2_tools/view_frames.py, and
BufferCore::allFramesAsYAML in tf2/src/buffer_core.cpp; ``ros2 topic echo`` prints YAML documents.

``read_text`` first takes away what terminals put around a text (``plain_lines``), then reads each block in its form:
answers of tf2_echo, trees of view_frames, documents of ``ros2 topic echo``.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rosorin_compile.model import Pose, Transform, Vector
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.rule_registry import Heading, Rule

from .arrays import SECOND
from .expected import EXACT, SIX_ANGLE
from .findings import problem
from .recording import Asked, Batch, FrameRow, Reading, Recording, Refused, Rows

RULES = (
    Rule(
        "text-not-understood",
        "A text, or a part of it, is nothing that is known.",
        "Paste it whole, with the command line above it.",
        Heading.RECORDINGS,
    ),
    Rule(
        "text-frames",
        "tf2_echo printed a transform, but the text does not say of which frames.",
        "`--frames SOURCE TARGET`",
        Heading.RECORDINGS,
    ),
)


_ASKS = re.compile(r"\btf2_echo\s+([^\s|&;>-]\S*)\s+([^\s|&;>-]\S*)")
_TOPIC = re.compile(r"\bros2\s+topic\s+echo\b(.*)")
_WAITING = re.compile(r"Waiting for transform (\S+) ->\s+(\S+?): (.*)")
_FAILED = re.compile(r"(?:Exception thrown:|Could not transform .*?: )(.*)")
_DOCUMENT = re.compile(r"(transforms|header|name|data):(\s|$)")
_FRAME = re.compile(r"[^\s#:]+: *$")
_PARENT = re.compile(r"\s+parent: ")


def read_text(text: str, recording: Recording) -> None:
    """Take down what a text says; what it is about but does not say is a trouble of the recording."""
    _TextReader(text, recording).read()


class _TextReader:
    def __init__(self, text: str, recording: Recording) -> None:
        self.lines = plain_lines(text)
        self.recording = recording
        self.questions: list[tuple[str, str]] = []
        self.blocks: list[Block] = []
        self.topic = ""
        self.topics = TopicText(recording)
        self.understood = False

    def read(self) -> None:
        """Read all lines."""
        at = 0
        while at < len(self.lines):
            at = self._step(at)
        self._pair()
        self.topics.finish()
        if not self.understood and not self.recording.troubles:
            message = "nothing in this text is known: no tf2_echo, no view_frames, no ros2 topic echo"
            help = "paste the output with the command line above it, or name a rosbag2 folder"
            self.recording.troubles.append(problem("text-not-understood", "the recording", message, help))

    def _step(self, at: int) -> int:
        """Read what begins at a line, and return the line behind it."""
        line = self.lines[at]
        if self._command(line) or self._refused(line, at):
            return at + 1
        if HEAD.match(line):
            block, behind = block_at(self.lines, at)
            self.blocks.append(block)
            self.understood = True
            return behind
        if line.lstrip().startswith("digraph"):
            return self._rows(at, self._until(at, lambda text: text.rstrip().endswith("}") and "->" not in text))
        if "frame_yaml=" in line:
            return self._rows(at, at + 1)
        if _FRAME.match(line) and at + 1 < len(self.lines) and _PARENT.match(self.lines[at + 1]):
            behind = at + 1
            while behind < len(self.lines) and (self.lines[behind][:1].isspace() or _FRAME.match(self.lines[behind])):
                behind += 1
            return self._rows(at, behind)
        if _DOCUMENT.match(line):
            return self._document(at)
        return at + 1

    def _until(self, at: int, ends: Callable[[str], bool]) -> int:
        while at < len(self.lines):
            at += 1
            if ends(self.lines[at - 1]):
                return at
        return at

    def _command(self, line: str) -> bool:
        """Take a command line: what it asks for is what the lines below it answer."""
        question, topic = _ASKS.search(line), _TOPIC.search(line)
        if question:
            if self.blocks:
                self._pair()
            self.questions.append((self._name(question[1]), self._name(question[2])))
        if topic:
            words = [word for word in topic[1].split() if not word.startswith("-")]
            words.sort(key=lambda word: not word.startswith("/"))  # others may be values of options
            self.topic = words[0] if words else ""
        return bool(question or topic)

    def _name(self, frame: str) -> str:
        return self.recording.tree_frame(frame.strip("'\""))

    def _refused(self, line: str, at: int) -> bool:
        waiting, failed = _WAITING.search(line), _FAILED.search(line)
        if not waiting and not (failed and self.questions):
            return False
        self.understood = True
        if waiting:
            source, target, why = self._name(waiting[1]), self._name(waiting[2]), waiting[3]
            if not self.questions:
                self.questions.append((source, target))
        else:
            (source, target), why = self.questions[-1], failed[1] if failed else ""
        self.recording.refused.append(Refused(source, target, " ".join(why.split()), at + 1))
        return True

    def _pair(self) -> None:
        """Bring answers together with the questions above them."""
        questions, blocks = self.questions, self.blocks
        self.questions, self.blocks = [], []
        if not blocks:
            return
        frames = self.recording.description.options.frames
        if not questions and frames is None:
            message = f"line {blocks[0].line} is where one frame is in another, but the text does not say which"
            help = "--frames SOURCE TARGET, or paste the command line above it: ros2 run tf2_ros tf2_echo SOURCE TARGET"
            self.recording.troubles.append(problem("text-frames", f"line {blocks[0].line}", message, help))
            return
        asked = questions or [frames or ("", "")]
        one_each = len(asked) == len(blocks)
        for number, block in enumerate(blocks):
            source, target = asked[number] if one_each else asked[-1]
            readings: tuple[Reading, ...] = block.readings()
            if not readings:
                message = f"line {block.line} begins an answer of tf2_echo, but it cannot be read"
                help = "paste the lines as they are printed, from At time to the matrix"
                self.recording.troubles.append(problem("text-not-understood", f"line {block.line}", message, help))
                continue
            self.recording.asked.append(Asked(source, target, readings, block.line, self._positions()))

    def _positions(self) -> Mapping[str, float]:
        """Return where the joints stood, as far as it is known: in the pose that was named, or as the text says."""
        pose = self.recording.description.options.pose
        if pose is None:
            return self.topics.positions
        still = {joint.name: 0.0 for joint in self.recording.description.robot.joints if joint.moves}
        return {**still, **pose}

    def _rows(self, at: int, behind: int) -> int:
        """Take the frames of view_frames between two lines."""
        text = "\n".join(self.lines[at:behind])
        reader = dot_rows if "digraph" in text else literal_rows if "frame_yaml=" in text else yaml_rows
        if "No tf data received" in text:
            message = "view_frames heard no transform at all"
            help = "look whether anything runs, and with the ROS_DOMAIN_ID of the robot"
            self.recording.troubles.append(problem("recording-foreign", f"line {at + 1}", message, help))
            return behind
        rows = reader(text, self.recording.tree_frame)
        if rows is None:
            message = f"line {at + 1} begins what view_frames prints, but it is not whole"
            self.recording.troubles.append(problem("text-not-understood", f"line {at + 1}", message, "paste all of it"))
            return behind
        known = {row.child for row in self.recording.rows}
        self.recording.rows += [row for row in rows if row.child not in known]
        self.recording.whole = self.recording.whole or bool(rows)
        self.understood = True
        return behind

    def _document(self, at: int) -> int:
        """Take one document of ros2 topic echo; it ends at "---", at a line that is no YAML of it, or at the end."""
        behind = at
        while behind < len(self.lines):
            line = self.lines[behind]
            if line.startswith("---") or not line.strip():
                break
            if behind > at and (_ASKS.search(line) or _TOPIC.search(line) or HEAD.match(line)):
                break
            behind += 1
        wrong = self.topics.take(self.topic, "\n".join(self.lines[at:behind]))
        if wrong:
            message = f"line {at + 1} begins a message, but it cannot be read: {wrong}"
            help = "paste whole messages, from --- to ---"
            self.recording.troubles.append(problem("text-not-understood", f"line {at + 1}", message, help))
        self.understood = True
        return behind


# Colours and other controls, and titles of windows, of a terminal (ECMA-48, 5.4 and 8.3.89).
_CONTROL = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)|[@-Z\\^_=>()][0-9A-B]?)")
_TIME = r"\d{1,2}:\d\d:\d\d(?:[.,]\d+)?Z?"
# What stands before every line: a time (script, ts, logs), a border of tmux, a quotation.
_FRONT = (
    re.compile(rf"\[?(?:\d{{4}}-\d\d-\d\d[T ]|[A-Z][a-z]{{2}} +\d{{1,2}} )?{_TIME}\]? ?"),
    re.compile(r"\[?\d{6,}\.\d+\]? "),
    re.compile(r"[│|] ?"),
    re.compile(r"> ?"),
)
_NEARLY_ALL = 0.9


def plain_lines(text: str) -> list[str]:
    r"""Return the lines of a pasted text, without colours and without what stands before nearly every one of them.

    >>> plain_lines("\x1b[32m> At time 0.0\x1b[0m\r\n> - Matrix:")
    ['At time 0.0', '- Matrix:']
    """
    lines = [_CONTROL.sub("", line) for line in text.splitlines()]
    written = [line for line in lines if line.strip()]
    for front in _FRONT:
        if written and sum(bool(front.match(line)) for line in written) >= _NEARLY_ALL * len(written):
            return [front.sub("", line, count=1) if front.match(line) else line for line in lines]
    return lines


_NUMBER = r"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|nan|inf)"
_LINE = re.compile(
    r"^\s*(?:- )?(Translation:|Rotation: in Quaternion|(?:Rotation: )?in RPY \((?:rad|deg)\w*\))"
    r"\s*(?:\(xyzw\)\s*)?\[([^\]]*)\]?"
)
HEAD = re.compile(r"^\s*(?:At time [\d.]+\s*$|- Translation: \[|- Rotation: in |\s+in RPY \(|- Matrix:)")
_AT_TIME = re.compile(r"^\s*At time ")
_MATRIX = re.compile(r"^\s*- Matrix:")
_NUMBERS = re.compile(_NUMBER)


@dataclass
class Block:
    """One answer: the line where it begins (from 1), and its numbers as they were printed, by form."""

    line: int
    forms: dict[str, list[str]] = field(default_factory=dict)

    def readings(self) -> tuple[Reading, ...]:
        """Return the forms of the answer that are whole."""
        xyz, metres = None, math.inf
        if len(self.forms.get("xyz", ())) == 3:
            xyz, metres = _vector(self.forms["xyz"]), _half(self.forms["xyz"]) + EXACT
        made = []
        for form in ("matrix", "quaternion", "degree", "radian"):
            reading = self._turn(form, xyz, metres)
            if reading is not None:
                made.append(reading)
        if not made and xyz is not None:
            made.append(Reading(xyz, None, metres, math.inf))
        return tuple(made)

    def _turn(self, form: str, xyz: Vector | None, metres: float) -> Reading | None:
        """Return an answer with the rotation of one form.

        Half a digit of each of three angles, of four parts of a quaternion (each counts twice) or of a matrix adds up.
        Whatever solution was printed as RPY, its rotation is the same.
        """
        texts = self.forms.get(form, [])
        half = _half(texts)
        if form == "matrix" and len(texts) == 16:
            values = [float(text) for text in texts]
            rows: Rows = (_three(values[0:3]), _three(values[4:7]), _three(values[8:11]))
            if not all(math.isfinite(value) for value in values):
                return None
            at = _three([values[3], values[7], values[11]])
            return Reading(at, _orthonormal(rows), half + EXACT, 6 * half + SIX_ANGLE)
        if form == "quaternion" and len(texts) == 4:
            x, y, z, w = (float(text) for text in texts)
            try:
                turned = Transform.of_quaternion((0.0, 0.0, 0.0), (w, x, y, z))
            except ValueError:
                return None
            return Reading(xyz, turned.rows, metres, 4.2 * half + SIX_ANGLE)
        if form in ("degree", "radian") and len(texts) == 3:
            factor = math.radians(1) if form == "degree" else 1.0
            roll, pitch, yaw = (float(text) * factor for text in texts)
            if not all(map(math.isfinite, (roll, pitch, yaw))):
                return None
            return Reading(xyz, Pose(rpy=(roll, pitch, yaw)).transform().rows, metres, 3 * half * factor + SIX_ANGLE)
        return None


def block_at(lines: Sequence[str], at: int) -> tuple[Block, int]:
    """Return the answer that begins at a line, and the line behind it."""
    block = Block(at + 1)
    begin = at
    while at < len(lines):
        line = lines[at]
        match = _LINE.match(line)
        if _AT_TIME.match(line) and at > begin:
            break
        if match:
            form = _form(match[1])
            if form in block.forms:
                break
            block.forms[form] = _NUMBERS.findall(match[2])
        elif _MATRIX.match(line):
            if "matrix" in block.forms:
                break
            block.forms["matrix"] = [text for row in lines[at + 1 : at + 5] for text in _NUMBERS.findall(row)]
            return block, min(at + 5, len(lines))
        elif not _AT_TIME.match(line):
            break
        at += 1
    return block, max(at, begin + 1)


def _form(words: str) -> str:
    if words.startswith("Translation"):
        return "xyz"
    if "Quaternion" in words:
        return "quaternion"
    return "degree" if "deg" in words else "radian"


def _half(texts: Sequence[str]) -> float:
    """Return half of the last digit that is printed of some numbers."""
    digits = [len(text.partition(".")[2]) for text in texts if "e" not in text.lower() and "n" not in text.lower()]
    return 0.5 * 10.0 ** -max(digits, default=3)


def _vector(texts: Sequence[str]) -> Vector | None:
    values = [float(text) for text in texts]
    return _three(values) if all(map(math.isfinite, values)) else None


def _three(values: Sequence[float]) -> Vector:
    x, y, z = values
    return (x, y, z)


def _orthonormal(rows: Rows) -> Rows:
    w, x, y, z = Transform(rows).quaternion()
    return Transform.of_quaternion((0.0, 0.0, 0.0), (w, x, y, z)).rows


_EDGE = re.compile(r'"([^"]+)" -> "([^"]+)"\s*\[label="([^"]*)"')
_FIELD = re.compile(r"\s*([\w ]+): *([^\\]*)")
_TREE_NUMBER = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?")
_RECORDED = re.compile(r'"Recorded at time: ([\d.]+)"')
_LITERAL = re.compile(r"frame_yaml=((?:'(?:[^'\\]|\\.)*')|(?:\"(?:[^\"\\]|\\.)*\"))")

Name = Callable[[str], str]


def dot_rows(text: str, name: Name) -> list[FrameRow] | None:
    """Return the frames of a dot file; None if it is not whole."""
    recorded = _RECORDED.search(text)
    at = _number(recorded[1]) if recorded else math.nan
    rows = []
    for edge in _EDGE.finditer(text):
        matches = map(_FIELD.match, edge[3].split("\\n"))
        fields = {match[1]: match[2] for match in matches if match}
        newest = _leading(fields.get("Most recent transform", ""))
        age = at - newest if math.isfinite(at - newest) and newest > 0 else None
        rate, length = _leading(fields.get("Average rate", "")), _leading(fields.get("Buffer length", ""))
        row = FrameRow(name(edge[1]), name(edge[2]), rate, length, age)
        rows += [] if math.isnan(rate) else [row]
    return rows or None


def _leading(text: str) -> float:
    match = _TREE_NUMBER.match(text)
    return _number(match[0]) if match else math.nan


def yaml_rows(text: str, name: Name) -> list[FrameRow] | None:
    """Return the frames of the YAML of a listener; None if it cannot be read."""
    try:
        loaded = Source("", text).yaml()
    except ValueError:
        return None
    if not isinstance(loaded, dict):
        return None
    rows = []
    for child, entry in loaded.items():
        if not isinstance(entry, dict) or "parent" not in entry:
            return None
        delay = entry.get("transform_delay")
        age = _number(delay) if delay is not None else None
        rate, length = _number(entry.get("rate")), _number(entry.get("buffer_length"))
        rows.append(FrameRow(name(str(entry["parent"])), name(str(child)), rate, length, age))
    return rows or None


def literal_rows(text: str, name: Name) -> list[FrameRow] | None:
    """Return the frames of the line that view_frames logs, where the YAML stands as a text of Python."""
    literal = _LITERAL.search(text)
    if not literal:
        return None
    try:
        value = ast.literal_eval(Source("", literal[1]).python(expression=True))
    except (ValueError, SyntaxError):
        return None
    return yaml_rows(str(value), name)


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


MAX_TRANSFORMS = 10_000


class TopicText:
    """The messages of a text. They are taken together at its end, so that the order of topics does not matter."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.batch = Batch()
        self.positions: dict[str, float] = {}

    def take(self, topic: str, text: str) -> str:
        """Take one message of a topic (empty if it is not known); return why it cannot be read, or nothing."""
        try:
            message = Source("", text).yaml()
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
            name = str(message["header"].get("frame_id", ""))
            frame = self.recording.frame(name)
            topic = topic or "the message"
            self.batch.received.append(stamp)
            self.batch.add_header(topic, "", frame, stamp)
            if name.startswith("/"):
                self.batch.add_slash(topic, frame)
        return ""

    def _transform(self, topic: str, entry: dict[str, Any]) -> None:
        stamp = _stamp(entry["header"])
        parent = self.recording.tree_frame(str(entry["header"]["frame_id"]))
        child = self.recording.tree_frame(str(entry["child_frame_id"]))
        moved, turned = entry["transform"]["translation"], entry["transform"]["rotation"]
        xyz = [float(moved[axis]) for axis in "xyz"]
        quaternion = [float(turned[axis]) for axis in "xyzw"]
        expected = self.recording.expected(parent, child)
        still = topic.endswith("tf_static") if topic else expected is not None and not expected.moving
        self.batch.received.append(stamp)
        self.batch.add_transform((still, parent, child), stamp, (*xyz, *quaternion))
        self.recording.span(stamp, stamp)

    def _joint_state(self, message: dict[str, Any]) -> None:
        names = tuple(str(name) for name in message["name"])
        values = [float(value) for value in message["position"]]
        stamp = _stamp(message["header"]) if isinstance(message.get("header"), dict) else 0
        self.batch.received.append(stamp)
        self.batch.add_state(names, values, stamp)
        self.positions |= {name: value for name, value in zip(names, values, strict=False) if math.isfinite(value)}

    def _robot(self, text: str) -> None:
        if not text.endswith("..."):
            self.recording.add_description(text.encode())

    def finish(self) -> None:
        """Hand on what was taken."""
        self.recording.topics |= {key[0]: key[1] for key in self.batch.headers}
        self.recording.take(self.batch, np.array(self.batch.received, np.int64))


def _stamp(header: dict[str, Any]) -> int:
    stamp = header["stamp"]
    value = int(stamp["sec"]) * SECOND + int(stamp["nanosec"])
    if not -(2**62) < value < 2**62:
        raise ValueError("a time beyond all clocks")
    return value

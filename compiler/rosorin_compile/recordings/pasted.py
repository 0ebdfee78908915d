"""Read text copied from a terminal: answers of tf2_echo, trees of view_frames and messages of ``ros2 topic echo``.

The forms are those of ROS 2 Humble and Jazzy: tf2_ros/src/tf2_echo.cpp, tf2_tools/view_frames.py, and
BufferCore::allFramesAsYAML in tf2/src/buffer_core.cpp; ``ros2 topic echo`` prints YAML documents.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from rosorin_compile.model import Pose, Transform, Vector
from rosorin_compile.source.diagnostics import Source

from .expected import EXACT, SIX_ANGLE
from .findings import problem
from .recording import Answer, EdgeKey, FrameRow, Reading, Recording, Rows
from .timing import SECOND

# Colours and other controls of a terminal, and window titles (ECMA-48, 5.4 and 8.3.89).
_CONTROL = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)|[@-Z\\^_=>()][0-9A-B]?)")
_TIME = r"\d{1,2}:\d\d:\d\d(?:[.,]\d+)?Z?"
# Prefixes of lines: a time (script, ts, logs), a border of tmux, a quotation.
_PREFIXES = (
    re.compile(rf"\[?(?:\d{{4}}-\d\d-\d\d[T ]|[A-Z][a-z]{{2}} +\d{{1,2}} )?{_TIME}\]? ?"),
    re.compile(r"\[?\d{6,}\.\d+\]? "),
    re.compile(r"[│|] ?"),
    re.compile(r"> ?"),
)
_NEARLY_ALL = 0.9

_QUESTION = re.compile(r"\btf2_echo\s+([^\s|&;>-]\S*)\s+([^\s|&;>-]\S*)")
_TOPIC = re.compile(r"\bros2\s+topic\s+echo\b(.*)")
_WAITING = re.compile(r"Waiting for transform (\S+) ->\s+(\S+?): (.*)")
_FAILED = re.compile(r"(?:Exception thrown:|Could not transform .*?: )(.*)")
_DOCUMENT = re.compile(r"(transforms|header|name|data):(\s|$)")
_FRAME, _PARENT = re.compile(r"[^\s#:]+: *$"), re.compile(r"\s+parent: ")

_ANSWER = re.compile(r"^\s*(?:At time [\d.]+\s*$|- Translation: \[|- Rotation: in |\s+in RPY \(|- Matrix:)")
_AT_TIME, _MATRIX = re.compile(r"^\s*At time "), re.compile(r"^\s*- Matrix:")
_FORM = re.compile(
    r"^\s*(?:- )?(Translation:|Rotation: in Quaternion|(?:Rotation: )?in RPY \((?:rad|deg)\w*\))"
    r"\s*(?:\(xyzw\)\s*)?\[([^\]]*)\]?"
)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|nan|inf)")

_DOT_EDGE = re.compile(r'"([^"]+)" -> "([^"]+)"\s*\[label="([^"]*)"')
_DOT_FIELD = re.compile(r"(?:^|\\n)\s*([\w ]+): *([-+]?[\d.]+(?:[eE][-+]?\d+)?)")
_DOT_TIME = re.compile(r'"Recorded at time: ([\d.]+)"')
_LITERAL = re.compile(r"frame_yaml=((?:'(?:[^'\\]|\\.)*')|(?:\"(?:[^\"\\]|\\.)*\"))")


def plain_lines(text: str) -> list[str]:
    r"""Return the lines of a text without colours and without a prefix that nearly all of them have.

    >>> plain_lines("\x1b[32m> At time 0.0\x1b[0m\r\n> - Matrix:")
    ['At time 0.0', '- Matrix:']
    """
    lines = [_CONTROL.sub("", line) for line in text.splitlines()]
    written = [line for line in lines if line.strip()]
    for prefix in _PREFIXES:
        if written and sum(bool(prefix.match(line)) for line in written) >= _NEARLY_ALL * len(written):
            return [prefix.sub("", line, count=1) if prefix.match(line) else line for line in lines]
    return lines


def read_text(text: str, recording: Recording) -> None:
    """Read a text into a recording; parts that cannot be read are troubles of the recording."""
    _TextReader(text, recording).read()


class _Block(NamedTuple):
    """One answer of tf2_echo: the line where it begins (from 1), and its printed numbers by form."""

    line: int
    forms: dict[str, list[str]]


class _TextReader:
    def __init__(self, text: str, recording: Recording) -> None:
        self.lines = plain_lines(text)
        self.recording = recording
        self.questions: list[tuple[str, str]] = []
        self.blocks: list[_Block] = []
        self.topic = ""
        self.positions: dict[str, float] = {}
        self.understood = False

    def read(self) -> None:
        at = 0
        while at < len(self.lines):
            at = self._read_at(at)
        self._pair()
        self.recording.topics |= {topic: type for topic, type, _ in self.recording.headers}
        self.recording.finish()
        if not self.understood and not self.recording.troubles:
            message = "nothing in this text is known: no tf2_echo, no view_frames, no ros2 topic echo"
            help = "paste the output with the command line above it, or name a rosbag2 folder"
            self._trouble("text-not-understood", None, message, help)

    def _trouble(self, rule: str, line: int | None, message: str, help: str) -> None:
        subject = "the recording" if line is None else f"line {line}"
        self.recording.troubles.append(problem(rule, subject, message, help))

    def _read_at(self, at: int) -> int:
        """Read what begins at a line, and return the line after it."""
        line, lines = self.lines[at], self.lines
        if self._command(line) or self._refusal(line, at):
            return at + 1
        if _ANSWER.match(line):
            self.understood = True
            return self._answer(at)
        if line.lstrip().startswith("digraph"):
            end = at + 1
            while end < len(lines) and (not lines[end - 1].rstrip().endswith("}") or "->" in lines[end - 1]):
                end += 1
            return self._tree(at, end, _dot_rows)
        if "frame_yaml=" in line:
            return self._tree(at, at + 1, _literal_rows)
        if _FRAME.match(line) and at + 1 < len(lines) and _PARENT.match(lines[at + 1]):
            end = at + 1
            while end < len(lines) and (lines[end][:1].isspace() or _FRAME.match(lines[end])):
                end += 1
            return self._tree(at, end, _yaml_rows)
        return self._document(at) if _DOCUMENT.match(line) else at + 1

    def _command(self, line: str) -> bool:
        """Read a command line: the lines below it answer it."""
        question, topic = _QUESTION.search(line), _TOPIC.search(line)
        if question:
            if self.blocks:
                self._pair()
            self.questions.append((self._frame(question[1]), self._frame(question[2])))
        if topic:
            words = [word for word in topic[1].split() if not word.startswith("-")]
            words.sort(key=lambda word: not word.startswith("/"))  # others may be values of options
            self.topic = words[0] if words else ""
        return bool(question or topic)

    def _frame(self, frame: str) -> str:
        return self.recording.tree_frame(frame.strip("'\""))

    def _refusal(self, line: str, at: int) -> bool:
        """Read a line in which tf2_echo says that it has no answer."""
        if waiting := _WAITING.search(line):
            question, why = (self._frame(waiting[1]), self._frame(waiting[2])), waiting[3]
            self.questions = self.questions or [question]
        elif self.questions and (failed := _FAILED.search(line)):
            question, why = self.questions[-1], failed[1]
        else:
            return False
        self.understood = True
        self.recording.refused.append(Answer(*question, at + 1, why=" ".join(why.split())))
        return True

    def _answer(self, at: int) -> int:
        forms: dict[str, list[str]] = {}
        lines, begin = self.lines, at
        while at < len(lines):
            line = lines[at]
            if match := _FORM.match(line):
                words = match[1]
                form = "quaternion" if "Quaternion" in words else "degree" if "deg" in words else "radian"
                form = "xyz" if words.startswith("Translation") else form
                if form in forms:
                    break
                forms[form] = _NUMBER.findall(match[2])
            elif _MATRIX.match(line):
                if "matrix" not in forms:
                    forms["matrix"] = [text for row in lines[at + 1 : at + 5] for text in _NUMBER.findall(row)]
                    at = min(at + 5, len(lines))
                break
            elif not _AT_TIME.match(line) or at > begin:
                break
            at += 1
        self.blocks.append(_Block(begin + 1, forms))
        return max(at, begin + 1)

    def _pair(self) -> None:
        """Assign answers to the questions above them."""
        questions, blocks = self.questions, self.blocks
        self.questions, self.blocks = [], []
        options = self.recording.description.options
        asked = questions or ([options.frames] if options.frames else [])
        if blocks and not asked:
            message = f"line {blocks[0].line} is where one frame is in another, but the text does not say which"
            help = "--frames SOURCE TARGET, or paste the command line above it: ros2 run tf2_ros tf2_echo SOURCE TARGET"
            self._trouble("text-frames", blocks[0].line, message, help)
            return
        positions = self.positions
        if options.pose is not None:
            moving = [joint.name for joint in self.recording.description.robot.joints if joint.moves]
            positions = {**dict.fromkeys(moving, 0.0), **options.pose}
        for number, block in enumerate(blocks):
            source, target = asked[number] if len(asked) == len(blocks) else asked[-1]
            if readings := tuple(_readings(block.forms)):
                self.recording.answers.append(Answer(source, target, block.line, readings, positions=positions))
            else:
                message = f"line {block.line} begins an answer of tf2_echo, but it cannot be read"
                help = "paste the lines as they are printed, from At time to the matrix"
                self._trouble("text-not-understood", block.line, message, help)

    def _tree(self, at: int, end: int, rows_of: Callable[[str], list[tuple[str, str, float, float, float]]]) -> int:
        """Read the frames of view_frames between two lines: parent, child, rate, length of the buffer, age."""
        text, recording = "\n".join(self.lines[at:end]), self.recording
        if "No tf data received" in text:
            help = "look whether anything runs, and with the ROS_DOMAIN_ID of the robot"
            self._trouble("recording-foreign", at + 1, "view_frames heard no transform at all", help)
            return end
        try:
            rows = rows_of(text)
        except (ValueError, SyntaxError, TypeError, KeyError, AttributeError):
            rows = []
        if not rows:
            message = f"line {at + 1} begins what view_frames prints, but it is not whole"
            self._trouble("text-not-understood", at + 1, message, "paste all of it")
            return end
        known = {row.child for row in recording.rows}
        for parent, child, rate, length, age in rows:
            # tf2 prints a rate of 10000 for the single sample of a static transform.
            static, known_age = rate >= 9999.0 and length == 0.0, None if math.isnan(age) else age
            row = FrameRow(recording.tree_frame(parent), recording.tree_frame(child), static, rate, known_age)
            recording.rows += [row] if row.child not in known else []
        self.understood = recording.complete = True
        return end

    def _document(self, at: int) -> int:
        """Read one message of ros2 topic echo; it ends at "---", an empty line, another command or answer."""
        end = at + 1
        while end < len(self.lines):
            line = self.lines[end]
            if line.startswith("---") or not line.strip():
                break
            if _QUESTION.search(line) or _TOPIC.search(line) or _ANSWER.match(line):
                break
            end += 1
        self.understood = True
        try:
            message = Source("", "\n".join(self.lines[at:end])).yaml()
            reason = "" if isinstance(message, dict) else "it is no message"
        except ValueError as cause:
            reason = str(cause)
        if not reason:
            try:
                self._message(message)
            except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
                reason = "a value is missing or of another kind"
        if reason:
            message = f"line {at + 1} begins a message, but it cannot be read: {reason}"
            self._trouble("text-not-understood", at + 1, message, "paste whole messages, from --- to ---")
        return end

    def _message(self, message: dict[str, Any]) -> None:
        recording = self.recording
        recording.messages += 1
        if "transforms" in message:
            for entry in message["transforms"]:
                self._transform(entry)
        elif "name" in message and "position" in message:
            names = [str(name) for name in message["name"]]
            values = [float(value) for value in message["position"]]
            stamp = _stamp(message["header"]) if isinstance(message.get("header"), dict) else 0
            recording.add_state(stamp, stamp, names, values)
            self.positions |= {name: at for name, at in zip(names, values, strict=False) if math.isfinite(at)}
        elif isinstance(message.get("data"), str) and "<robot" in message["data"]:
            if not message["data"].endswith("..."):
                recording.add_description(message["data"].encode())
        elif isinstance(message.get("header"), dict):
            stamp, frame = _stamp(message["header"]), str(message["header"].get("frame_id", ""))
            recording.add_header(stamp, stamp, self.topic or "the message", "", frame)

    def _transform(self, entry: dict[str, Any]) -> None:
        recording, stamp = self.recording, _stamp(entry["header"])
        parent = recording.tree_frame(str(entry["header"]["frame_id"]))
        child = recording.tree_frame(str(entry["child_frame_id"]))
        moved, turned = entry["transform"]["translation"], entry["transform"]["rotation"]
        values = [*(float(moved[axis]) for axis in "xyz"), *(float(turned[axis]) for axis in "xyzw")]
        edge = recording.expected(parent, child)
        static = self.topic.endswith("tf_static") if self.topic else edge is not None and not edge.moving
        recording.edges.setdefault(EdgeKey(static, parent, child), Rows()).add(stamp, stamp, values)
        recording.start = stamp if recording.start is None else min(recording.start, stamp)
        recording.end = max(recording.end, stamp)


def _stamp(header: dict[str, Any]) -> int:
    stamp = int(header["stamp"]["sec"]) * SECOND + int(header["stamp"]["nanosec"])
    if not -(2**62) < stamp < 2**62:
        raise ValueError("a time beyond all clocks")
    return stamp


def _readings(forms: dict[str, list[str]]) -> Iterator[Reading]:
    """Yield the complete forms of an answer. Rounding errors of the numbers of a rotation add up.

    All solutions that are printed as roll, pitch, yaw are the same rotation.
    """
    xyz, metres = None, math.inf
    if len(forms.get("xyz", ())) == 3 and np.isfinite(values := [float(text) for text in forms["xyz"]]).all():
        xyz, metres = _vector(values), _half_digit(forms["xyz"]) + EXACT
    complete = False
    for form, count, errors in (("matrix", 16, 6.0), ("quaternion", 4, 4.2), ("degree", 3, 3.0), ("radian", 3, 3.0)):
        texts = forms.get(form, [])
        values = [float(text) for text in texts]
        if len(values) != count or not np.isfinite(values).all():
            continue
        half = _half_digit(texts) * (math.radians(1) if form == "degree" else 1.0)
        at, far = xyz, metres
        if form == "matrix":
            at, far = _vector(values[3:12:4]), half + EXACT
            w, x, y, z = Transform((_vector(values[0:3]), _vector(values[4:7]), _vector(values[8:11]))).quaternion()
        elif form == "quaternion":
            x, y, z, w = values
        else:
            rpy = _vector([math.radians(value) if form == "degree" else value for value in values])
            w, x, y, z = Pose(rpy=rpy).transform().quaternion()
        try:
            turn = Transform.of_quaternion((0.0, 0.0, 0.0), (w, x, y, z))
        except ValueError:  # its length is zero
            continue
        complete = True
        yield Reading(at, turn, far, errors * half + SIX_ANGLE)
    if not complete and xyz is not None:
        yield Reading(xyz, None, metres, math.inf)


def _vector(values: Sequence[float]) -> Vector:
    x, y, z = values
    return (x, y, z)


def _half_digit(texts: Sequence[str]) -> float:
    """Return half of the last printed digit of some numbers."""
    digits = [len(text.partition(".")[2]) for text in texts if "e" not in text.lower()]
    return 0.5 * 10.0 ** -max(digits, default=3)


def _dot_rows(text: str) -> list[tuple[str, str, float, float, float]]:
    """Return the frames of a dot file of view_frames."""
    recorded = _DOT_TIME.search(text)
    now = float(recorded[1]) if recorded else math.nan
    rows = []
    for parent, child, label in _DOT_EDGE.findall(text):
        fields = {name: float(value) for name, value in _DOT_FIELD.findall(label)}
        newest = fields.get("Most recent transform", 0.0)
        rate, length = fields.get("Average rate"), fields.get("Buffer length", math.nan)
        rows += [] if rate is None else [(parent, child, rate, length, now - newest if newest > 0 else math.nan)]
    return rows


def _yaml_rows(text: str) -> list[tuple[str, str, float, float, float]]:
    """Return the frames of the YAML of a listener."""
    rows = []
    for child, entry in Source("", text).yaml().items():
        values = [float(entry.get(key, math.nan)) for key in ("rate", "buffer_length", "transform_delay")]
        rows.append((str(entry["parent"]), str(child), values[0], values[1], values[2]))
    return rows


def _literal_rows(text: str) -> list[tuple[str, str, float, float, float]]:
    """Return the frames of the line that view_frames logs, in which the YAML is a Python string."""
    literal = _LITERAL.search(text)
    return _yaml_rows(str(ast.literal_eval(Source("", literal[1]).python(expression=True)))) if literal else []

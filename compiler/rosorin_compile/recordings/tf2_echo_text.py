"""Parse text copied from a terminal: the output of tf2_echo, view_frames and ``ros2 topic echo``.

The output formats are those of ROS 2 Humble and Jazzy: tf2_ros/src/tf2_echo.cpp, tf2_tools/view_frames.py, and
BufferCore::allFramesAsYAML in tf2/src/buffer_core.cpp; ``ros2 topic echo`` prints YAML documents.
"""

import ast
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.model import Pose, Transform, Vector
from rosorin_compile.source.load import python_of, yaml_of

from .expected_edges import EXACT, SIX_ANGLE
from .recording import Answer, FrameRow, PrintedTransform, Recording, Rows
from .results import problem
from .series import SECOND, EdgeKey

# Terminal escape sequences for colours, cursor movement and window titles (ECMA-48, 5.4 and 8.3.89).
_CONTROL = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)|[@-Z\\^_=>()][0-9A-B]?)")
_TIME = r"\d{1,2}:\d\d:\d\d(?:[.,]\d+)?Z?"
# What can precede copied lines: a time (from script, ts or logs), a tmux pane border, or the ">" of a quotation.
_PREFIX = re.compile(
    rf"\[?(?:\d{{4}}-\d\d-\d\d[T ]|[A-Z][a-z]{{2}} +\d{{1,2}} )?{_TIME}\]? ?|\[?\d{{6,}}\.\d+\]? |[│|] ?|> ?"
)

_QUESTION = r".*\btf2_echo[ \t]+(?P<source>[^\s|&;>-]\S*)[ \t]+(?P<target>[^\s|&;>-]\S*).*"
_AT_TIME, _MATRIX = r"[ \t]*At time [\d.]+[ \t]*(?:\n|\Z)", r"[ \t]*- Matrix:.*(?:\n.*){0,4}"
_FORM = r"[ \t]*(?:- )?(?:Translation:|Rotation: in Quaternion|(?:Rotation: )?in RPY \((?:rad|deg)\w*\)).*\[.*(?:\n|\Z)"
_ANSWER = rf"{_AT_TIME}(?:{_FORM})*(?:{_MATRIX})?|(?:{_FORM})+(?:{_MATRIX})?|{_MATRIX}"
_END = r"---|[ \t]*$|.*\btf2_echo[ \t]+\S+[ \t]+\S|.*\bros2\s+topic\s+echo\b|[ \t]*At time [\d.]+[ \t]*$"
_ITEMS = {
    "question": _QUESTION,
    "topic": r".*\bros2\s+topic\s+echo\b(?P<words>.*)",
    "refusal": r".*Waiting for transform (?P<from>\S+) ->\s+(?P<to>\S+?): (?P<why>.*)",
    "failure": r".*(?:Exception thrown:|Could not transform .*?: )(?P<reason>.*)",
    "answer": _ANSWER,
    "dot": r"[ \t]*digraph(?:(?:.*\n)*?(?!.*->).*\}[ \t]*$|.*)",
    "literal": r".*frame_yaml=(?P<literal_text>'(?:[^'\\\n]|\\.)*'|\"(?:[^\"\\\n]|\\.)*\")?.*",
    "yaml": r"[^\s#:]+: *\n[ \t]+parent: .*(?:\n(?:[ \t].*|[^\s#:]+: *$))*",
    "document": rf"(?:transforms|header|name|data):(?:[ \t].*|$)(?:\n(?!{_END}).+)*",
}
_ITEM = re.compile("|".join(f"^(?P<{name}>{pattern})" for name, pattern in _ITEMS.items()), re.MULTILINE)
_FORM_LINE = re.compile(r"(Translation:|Quaternion|\(rad|\(deg|Matrix:)[^\[\n]*\[?([^\]]*)")
_FORMS = {"Translation:": "xyz", "Quaternion": "quaternion", "(rad": "radian", "(deg": "degree", "Matrix:": "matrix"}

_DOT_EDGE = re.compile(r'"([^"]+)" -> "([^"]+)"\s*\[label="([^"]*)"')
_DOT_FIELD = re.compile(r"(?:^|\\n)\s*([\w ]+): *([-+]?[\d.]+(?:[eE][-+]?\d+)?)")


def plain_lines(text: str) -> list[str]:
    r"""Split text copied from a terminal into lines, and remove colours and any prefix that nearly all lines have.

    >>> plain_lines("\x1b[32m> At time 0.0\x1b[0m\r\n> - Matrix:")
    ['At time 0.0', '- Matrix:']
    """
    lines = [_CONTROL.sub("", line) for line in text.splitlines()]
    written = [line for line in lines if line.strip()]
    if 0 < 0.9 * len(written) <= sum(bool(_PREFIX.match(line)) for line in written):
        return [line[match.end() :] if (match := _PREFIX.match(line)) else line for line in lines]
    return lines


def read_text(text: str, recording: Recording) -> None:
    """Add the messages in a text to a recording; add diagnostics for other parts to ``recording.troubles``."""
    _TextReader(recording).read("\n".join(plain_lines(text)))


class _TextReader:
    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.questions: list[tuple[str, str]] = []
        self.blocks: list[tuple[int, dict[str, list[str]]]] = []  # (line number, printed numbers by kind, such as xyz)
        self.topic = ""
        self.positions: dict[str, float] = {}
        self.understood = False

    def read(self, text: str) -> None:
        line, before = 1, 0
        for item in _ITEM.finditer(text):
            line, before = line + text.count("\n", before, item.start()), item.start()
            kind = str(item.lastgroup)
            if kind == "topic":
                words = [word for word in item["words"].split() if not word.startswith("-")]
                words.sort(key=lambda word: not word.startswith("/"))  # other words may be option values
                self.topic = words[0] if words else ""
            elif kind == "question":  # a command line; the next lines are its output
                if self.blocks:
                    self._pair()
                self.questions.append((self._frame(item["source"]), self._frame(item["target"])))
            elif kind == "refusal" or (kind == "failure" and self.questions):  # tf2_echo printed an error
                named = (self._frame(item["from"]), self._frame(item["to"])) if item["from"] else self.questions[-1]
                self.questions, self.understood = self.questions or [named], True
                why = " ".join((item["why"] or item["reason"] or "").split())
                self.recording.refused.append(Answer(*named, line, why=why))
            elif kind == "answer":
                self.understood, block = True, dict[str, list[str]]()
                self.blocks.append((line, block))
                for match in _FORM_LINE.finditer(item[0]):
                    if (form := _FORMS[match[1]]) in block:  # a kind that occurs again starts the next transform
                        block = {}
                        self.blocks.append((line + item[0].count("\n", 0, match.start()), block))
                    block[form] = re.findall(r"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|nan|inf)", match[2])
            elif kind == "document":
                self.understood = True
                try:
                    self._message(yaml_of(item[0]))
                except (TypeError, ValueError, KeyError, AttributeError, OverflowError) as cause:
                    reason = str(cause) if isinstance(cause, ValueError) else "a value is missing or of another kind"
                    message = f"line {line} begins a message, but it cannot be read: {reason}"
                    self._trouble("text-not-understood", line, message, "paste whole messages, from --- to ---")
            elif kind != "failure":
                self._tree(item, kind, line)
        self._pair()
        self.recording.topics |= {topic: kind for topic, kind, _ in self.recording.headers}
        self.recording.finish()
        if not self.understood and not self.recording.troubles:
            message = "nothing in this text is known: no tf2_echo, no view_frames, no ros2 topic echo"
            self._trouble("text-not-understood", 0, message)

    def _trouble(self, rule: str, line: int, message: str, help: str = "") -> None:
        self.recording.troubles.append(problem(rule, f"line {line}" if line else "the recording", message, help))

    def _frame(self, frame: str) -> str:
        return self.recording.tree_frame(frame.strip("'\""))

    def _pair(self) -> None:
        """Assign each output of tf2_echo to the frames in the command line above the output."""
        questions, blocks = self.questions, self.blocks
        self.questions, self.blocks = [], []
        options = self.recording.description.options
        asked = questions or ([options.frames] if options.frames else [])
        if blocks and not asked:
            message = f"line {blocks[0][0]} is where one frame is in another, but the text does not say which"
            self._trouble("text-frames", blocks[0][0], message)
            return
        positions = self.positions
        if options.pose is not None:
            moving = [joint.name for joint in self.recording.description.robot.joints if joint.moves]
            positions = {**dict.fromkeys(moving, 0.0), **options.pose}
        for number, (line, forms) in enumerate(blocks):
            source, target = asked[number] if len(asked) == len(blocks) else asked[-1]
            if readings := tuple(_readings(forms)):
                self.recording.answers.append(Answer(source, target, line, readings, positions=positions))
            else:
                message = f"line {line} begins an answer of tf2_echo, but it cannot be read"
                self._trouble("text-not-understood", line, message)

    def _tree(self, item: re.Match[str], kind: str, line: int) -> None:
        recording, text = self.recording, item[0]
        if "No tf data received" in text:
            help = "look whether anything runs, and with the ROS_DOMAIN_ID of the robot"
            self._trouble("recording-foreign", line, "view_frames heard no transform at all", help)
            return
        rows: list[FrameRow] = []
        try:
            if kind == "literal":  # view_frames logs the YAML as a Python string
                text = str(ast.literal_eval(python_of(item["literal_text"] or "''", expression=True)))
            rows = list(_rows(kind, text))
        except (ValueError, SyntaxError, TypeError, KeyError, AttributeError):
            pass
        if not rows:
            message = f"line {line} begins what view_frames prints, but it is not whole"
            self._trouble("text-not-understood", line, message)
            return
        self.understood = recording.complete = True
        known = {row.child for row in recording.rows}
        named = [row._replace(parent=self._frame(row.parent), child=self._frame(row.child)) for row in rows]
        recording.rows += [row for row in named if row.child not in known]

    def _message(self, message: dict[str, Any]) -> None:
        recording, header = self.recording, message.get("header")
        recording.messages += 1
        if "transforms" in message:
            for entry in message["transforms"]:
                self._transform(entry)
        elif "name" in message and "position" in message:
            names, values = [str(name) for name in message["name"]], [float(value) for value in message["position"]]
            stamp = _stamp(header) if isinstance(header, dict) else 0
            recording.add_state(stamp, stamp, names, values)
            self.positions |= {name: at for name, at in zip(names, values, strict=False) if math.isfinite(at)}
        elif isinstance(message.get("data"), str) and "<robot" in message["data"]:
            if not message["data"].endswith("..."):
                recording.descriptions[message["data"].encode()] = None
        elif isinstance(header, dict):
            stamp, frame = _stamp(header), str(header.get("frame_id", ""))
            recording.add_header(stamp, stamp, self.topic or "the message", "", frame)

    def _transform(self, entry: dict[str, Any]) -> None:
        recording, stamp = self.recording, _stamp(entry["header"])
        parent, child = self._frame(str(entry["header"]["frame_id"])), self._frame(str(entry["child_frame_id"]))
        moved, turned = entry["transform"]["translation"], entry["transform"]["rotation"]
        values = [*(float(moved[axis]) for axis in "xyz"), *(float(turned[axis]) for axis in "xyzw")]
        edge = recording.description.edge_like(parent, child)
        static = self.topic.endswith("tf_static") if self.topic else edge is not None and not edge.moving
        recording.edges.setdefault(EdgeKey(static, parent, child), Rows()).add(stamp, stamp, values)
        recording.start = min(recording.start or stamp, stamp)
        recording.end = max(recording.end, stamp)


def _stamp(header: Mapping[str, Any]) -> int:
    stamp = int(header["stamp"]["sec"]) * SECOND + int(header["stamp"]["nanosec"])
    if not -(2**62) < stamp < 2**62:
        raise ValueError("a time beyond all clocks")
    return stamp


def _readings(forms: dict[str, list[str]]) -> Iterator[PrintedTransform]:
    """Yield a transform for each complete representation (matrix, quaternion, RPY) in an output of tf2_echo.

    The tolerances are computed from the number of printed digits.
    """
    counts = {"xyz": 3, "matrix": 16, "quaternion": 4, "degree": 3, "radian": 3}
    printed = {}  # by representation: (numbers, rounding error of a number)
    for form, texts in forms.items():
        digits = [len(text.partition(".")[2]) for text in texts if "e" not in text.lower()]
        printed[form] = (list(map(float, texts)), 0.5 * 10.0 ** -max(digits, default=3))
    whole = {f: one for f, one in printed.items() if len(one[0]) == counts[f] and all(map(math.isfinite, one[0]))}
    xyz, metres, complete = None, math.inf, False
    if "xyz" in whole:
        xyz, metres = _vector(whole["xyz"][0]), whole["xyz"][1] + EXACT
    for form, errors in (("matrix", 6.0), ("quaternion", 4.2), ("degree", 3.0), ("radian", 3.0)):
        if form not in whole:
            continue
        (values, half), at, far = whole[form], xyz, metres
        if form == "matrix":
            at, far = _vector(values[3:12:4]), half + EXACT
            w, x, y, z = Transform((_vector(values[0:3]), _vector(values[4:7]), _vector(values[8:11]))).quaternion()
        elif form == "quaternion":
            x, y, z, w = values
        else:
            unit = math.radians(1) if form == "degree" else 1.0
            w, x, y, z = Pose(rpy=_vector([value * unit for value in values])).transform().quaternion()
            half *= unit
        try:
            turn = Transform.of_quaternion((0.0, 0.0, 0.0), (w, x, y, z))
        except ValueError:  # a quaternion of zeros
            continue
        complete = True
        yield PrintedTransform(at, turn, far, errors * half + SIX_ANGLE)
    if not complete and xyz is not None:
        yield PrintedTransform(xyz, None, metres, math.inf)


def _vector(values: Sequence[float]) -> Vector:
    x, y, z = values
    return (x, y, z)


def _rows(kind: str, text: str) -> Iterator[FrameRow]:
    """Yield the frames in the output of view_frames, which is a dot file or the YAML of a tf2 buffer."""
    frames: list[tuple[str, str, float, float, float]] = []  # parent, child, rate (Hz), buffer length (s), age (s)
    if kind == "dot":
        recorded = re.search(r'"Recorded at time: ([\d.]+)"', text)
        for parent, child, label in _DOT_EDGE.findall(text):
            fields = {name: float(value) for name, value in _DOT_FIELD.findall(label)}
            newest = fields.get("Most recent transform", 0.0)
            age = float(recorded[1]) - newest if recorded and newest > 0 else math.nan
            if "Average rate" in fields:
                frames.append((parent, child, fields["Average rate"], fields.get("Buffer length", math.nan), age))
    else:
        for child, entry in yaml_of(text).items():
            rate, length, age = (float(entry.get(key, "nan")) for key in ("rate", "buffer_length", "transform_delay"))
            frames.append((str(entry["parent"]), str(child), rate, length, age))
    for parent, child, rate, length, age in frames:
        static = rate >= 9999.0 and length == 0.0  # tf2 prints 10000 for the single sample of a static transform
        yield FrameRow(parent, child, static, rate, None if math.isnan(age) else age)

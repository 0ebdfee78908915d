"""Text: what people paste from a terminal. It may hold several things, one after the other.

The forms are those of ROS 2 Humble and Jazzy: tf2_ros/src/tf2_echo.cpp, tf2_tools/view_frames.py, and
BufferCore::allFramesAsYAML in tf2/src/buffer_core.cpp; ``ros2 topic echo`` prints YAML documents.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from ...registry import RECORDINGS, Rule
from ..findings import problem
from ..recording.recording import Asked, Reading, Recording, Refused
from .echo import HEAD, Block, block_at
from .frames import dot_rows, literal_rows, yaml_rows
from .plain_lines import plain_lines
from .topics import TopicText

RULES = (
    Rule(
        "text-not-understood",
        "A text, or a part of it, is nothing that is known.",
        "Paste it whole, with the command line above it.",
        RECORDINGS,
    ),
    Rule(
        "text-frames",
        "tf2_echo printed a transform, but the text does not say of which frames.",
        "`--frames SOURCE TARGET`",
        RECORDINGS,
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
    """Goes through the lines of a text once."""

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
        return self.recording.frame(frame.strip("'\""))

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
        return {**still, **pose.positions}

    def _rows(self, at: int, behind: int) -> int:
        """Take the frames of view_frames between two lines."""
        text = "\n".join(self.lines[at:behind])
        reader = dot_rows if "digraph" in text else literal_rows if "frame_yaml=" in text else yaml_rows
        if "No tf data received" in text:
            message = "view_frames heard no transform at all"
            help = "look whether anything runs, and with the ROS_DOMAIN_ID of the robot"
            self.recording.troubles.append(problem("recording-foreign", f"line {at + 1}", message, help))
            return behind
        rows = reader(text, self.recording.frame)
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

"""frames: every transform of the robot in one table that people read, in Markdown and just as well as plain text."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.language.expression import ExpressionError
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Output, Pose, Publisher, Robot
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.model.robot import JointPose
from rosorin_compile.rules.publishers import MAX_MODES, combinations, holds, modes_in
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.numbers import NumberFormat, fixed, number_format, vector
from rosorin_compile.source.wording import first_of, listed
from rosorin_compile.source.xml.elements import number_of, numbers_of

from .format import NUMBER_FORMAT, Asked, Format
from .static_tf import describe
from .unsupported import PLACES

if TYPE_CHECKING:
    from .templating import Templates

_FRAME_HEADERS = (
    "parent",
    "child",
    "published by",
    "motion",
    "topic",
    "x y z (m)",
    "roll pitch yaw (rad)",
    "roll pitch yaw (deg)",
    "when",
)
_POSE_HEADERS = ("pose", "joint", "position", "in degrees", "pulse")
# Minimum widths, whatever the rows contain: a new frame adds a line and changes no other one.
_FRAME_WIDTHS = (18, 18, 22, 6, 10, 35, 35, 29, 8)
_POSE_WIDTHS = (12, 18, 26, 10, 6)
# Size of a cache: a frame is the parent of the next one.
_MANY = 1_000

# Characters with a meaning in Markdown; an underscore only at the start or end of a word.
_MARKS = re.compile(r"[\\`*\[\]<>|~&#!]|(?<!\w)_|_(?!\w)")
_CAPITAL = re.compile(r"(?<=[a-z])(?=[A-Z])")


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the list of all frames of a robot. Option: ``number_format`` (short, exact or six)."""
    number = number_format(output.options)
    frames = _frames(robot)
    named = [(f"{sensor.name} ({sensor.type})", sensor.stamps) for sensor in robot.sensors]
    named += [(node.name, node.stamps) for node in robot.publishers]
    simulated: dict[str, list[str]] = {}
    for name, why in robot.simulated_frames.items():
        simulated.setdefault(why, []).append(name)
    reasons = [f"{first_of(names, 3)} ({' '.join(why.split())})" for why, names in simulated.items()]
    poses = []
    for pose in robot.poses:
        for name, position in pose.positions.items():
            slides = name in robot.joint and robot.joint[name].type == "prismatic"
            degrees = "" if slides else fixed(math.degrees(position), 4)
            place = f"{number(position)} {'m' if slides else 'rad'}"
            poses.append([_escape(pose.name), _escape(name), place, degrees, str(pose.pulses.get(name, ""))])
    publishers = dict.fromkeys(frame.publisher for frame in frames)
    values: dict[str, Any] = {
        "robot": robot,
        "frames": _table(_FRAME_HEADERS, _FRAME_WIDTHS, [_frame_row(frame, number) for frame in frames]),
        "nodes": [node for node in publishers if node.kind != UNPUBLISHED and (node.package or node.about)],
        "simulated": _wrapped(_escape(f"Only simulations have {listed(reasons)}.")) if reasons else "",
        "stand_ins": _stand_ins(robot),
        "proof": _wrapped(_escape(publishing(robot).in_words())),
        "stamps": [(name, ", ".join(stamps)) for name, stamps in named if stamps],
        "poses": _table(_POSE_HEADERS, _POSE_WIDTHS, poses),
        "modes": _escape(", ".join(robot.modes)),
        "source": describe,
        "escape": _escape,
    }
    return templates.own("core/frames.md.jinja", values), []


def _frames(robot: Robot) -> list[Edge]:
    """Return the joints in the order of the description, then the transforms of other nodes."""
    frames: list[Edge] = []
    for joint in robot.joints_down():
        if joint.child in robot.simulated_frames:
            continue
        turns = robot.turns.get(joint.name, ())
        if joint.publisher.kind != UNPUBLISHED or not turns:
            publisher = robot.publisher_of(joint)
            frames.append(Edge(joint.parent, joint.child, publisher, joint.moves_on_tf, pose=joint.origin))
        frames += turns
    return frames + [edge for edge in robot.edges if not edge.joint]


def _frame_row(frame: Edge, number: NumberFormat) -> list[str]:
    who, topic, when = _publishing(frame)
    unknown = "not known" if frame.publisher.kind == UNPUBLISHED else f"known to {_escape(who)} alone"
    numbers = [unknown, "", ""]
    if frame.pose:
        degrees = tuple(map(math.degrees, frame.pose.rpy))
        columns = ((frame.pose.xyz, number, 11), (frame.pose.rpy, number, 11), (degrees, partial(fixed, digits=4), 9))
        numbers = [
            " ".join(text.ljust(width) for text in vector(values, form).split()).rstrip()
            for values, form, width in columns
        ]
    cells = [_escape(frame.parent), _escape(frame.child), _escape(who), "moving" if frame.moving else "static"]
    return [*cells, topic, *numbers, _escape(" ".join(when.split()))]


def _publishing(frame: Edge) -> tuple[str, str, str]:
    """Return who publishes a frame, on which topic, and when."""
    publisher = frame.publisher
    if publisher.kind == UNPUBLISHED:
        return f"nobody: {publisher.about}" if publisher.about else "nobody", "none", frame.when or "never"
    moving = frame.moving and publisher.kind != STATIC_TRANSFORM_PUBLISHER
    return publisher.name, "/tf" if moving else "/tf_static", frame.when or "always"


def _stand_ins(robot: Robot) -> list[tuple[str, str]]:
    """Return the reasons of stand-ins, each with the things that it is about."""
    by_reason: dict[str, list[str]] = {}
    kinds: dict[str, Sequence[Any]] = {"robot": [robot], "link": robot.links, "joint": robot.joints}
    kinds |= {"sensor": robot.sensors, "servos": robot.servos, "pose": robot.poses, "transform": robot.edges}
    for kind, things in kinds.items():
        for thing in things:
            if thing.source.status == "stand_in":
                name = f"{thing.parent} to {thing.child}" if isinstance(thing, Edge) else thing.name
                by_reason.setdefault(thing.source.note or "no reason given", []).append(f"{kind} {name}")
    for link in robot.links:
        for shape in (*link.collision, *link.visual):
            if shape.stand_in:
                kind = _CAPITAL.sub(" ", type(shape.geometry).__name__).lower()
                by_reason.setdefault(shape.stand_in, []).append(
                    f"the {kind} {shape.name}".strip() + f" of link {link.name}"
                )
    return [(reason, ", ".join(dict.fromkeys(names))) for reason, names in by_reason.items()]


@lru_cache(maxsize=_MANY)
def _escape(text: str) -> str:
    """Return a text on one line that Markdown shows as it is, in a cell of a table too; blanks in names count."""
    return _MARKS.sub(r"\\\g<0>", " ".join(map(str.strip, text.splitlines())))


def _wrapped(text: str) -> str:
    return "\n".join(textwrap.wrap(text, 120, break_long_words=False, break_on_hyphens=False))


def _table(headers: Sequence[str], widths: Sequence[int], rows: list[list[str]]) -> str:
    """Return a table whose columns have at least the given widths; empty without rows."""
    lines = (headers, ["-" * width for width in widths], *rows) if rows else ()
    return "\n".join("| " + " | ".join(map(str.ljust, cells, widths)) + " |" for cells in lines)


@dataclass(frozen=True)
class FrameTable:
    """What the tables contain: transforms, and where poses put joints."""

    frames: tuple[Edge, ...]
    poses: tuple[JointPose, ...]


def view(robot: Robot, output: Output) -> FrameTable:  # noqa: ARG001
    """Return what the tables of a robot are meant to contain."""
    edges = []
    for frame in _frames(robot):
        who, topic, when = _publishing(frame)
        who = " ".join(map(str.strip, who.splitlines()))
        edges.append(_edge(frame.parent, frame.child, who, topic, when, frame.pose))
    return FrameTable(tuple(edges), tuple(JointPose(one.name, one.positions) for one in robot.poses if one.positions))


def _edge(parent: str, child: str, who: str, topic: str, when: str, pose: Pose | None) -> Edge:
    kind = UNPUBLISHED if topic == "none" else NODE
    publisher = Publisher(kind, who, about=who.removeprefix("nobody").removeprefix(": "))
    condition = "" if when in ("always", "never") else " ".join(when.split())
    return Edge(parent, child, publisher, topic == "/tf", condition, pose)


def read(text: str) -> FrameTable:
    """Return what the tables contain. Raises ValueError if a robot of several frames has no table."""
    rows = list(_parse(text, _FRAME_HEADERS))
    if not rows and not re.search(r"(?m)^The robot has one frame, .*\.$", text):
        raise ValueError("there is no table of frames")
    edges = []
    for row in rows:
        pose = None
        if row["roll pitch yaw (rad)"]:
            (x, y, z), (roll, pitch, yaw) = (numbers_of(row[key], 3) for key in ("x y z (m)", "roll pitch yaw (rad)"))
            pose = Pose((x, y, z), (roll, pitch, yaw))
        edges.append(_edge(row["parent"], row["child"], row["published by"], row["topic"], row["when"], pose))
    poses: dict[str, dict[str, float]] = {}
    for row in _parse(text, _POSE_HEADERS):
        number, _, unit = row["position"].partition(" ")
        if unit not in ("m", "rad"):
            raise ValueError(f'"{row["position"]}" is no position of a joint')
        poses.setdefault(row["pose"], {})[row["joint"]] = number_of(number)
    return FrameTable(tuple(edges), tuple(JointPose(name, positions) for name, positions in poses.items()))


def _parse(text: str, headers: Sequence[str]) -> Iterator[dict[str, str]]:
    """Yield the rows of the table with these headers. Raises ValueError for a row of another length."""
    inside = False
    for line in text.splitlines():
        parts = re.split(r"(?<!\\)\|", line) if "\\" in line else line.split("|")
        cells = [cell.strip() for cell in parts[1:-1]]
        if not inside:
            inside = tuple(cells) == tuple(headers)
        elif not cells:
            return
        elif cells[0].strip("-") or set("".join(cells)) != {"-"}:
            if "\\" in line:
                cells = [re.sub(r"\\(.)", r"\1", cell) for cell in cells]
            yield dict(zip(headers, cells, strict=True))


def _words(text: str) -> list[float | str]:
    """Return the words of a text, numbers as numbers; dashes that draw the lines of a table do not count."""
    words: list[float | str] = []
    for word in text.split():
        try:
            words += [] if set(word) == {"-"} else [word if "_" in word else float(word)]
        except ValueError:
            words.append(word)
    return words


FORMAT = Format(
    name="frames",
    word="table of frames",
    article="a",
    about="every frame, where it sits and who publishes it",
    rank=70,
    covers=(
        *PLACES,
        *("robot", "joints.type", "joints.publisher", "sensors.type", "sensors.publisher", "sensors.optical.publisher"),
        *("edges", "publishers", "poses.positions", "poses.pulses", "servos.flipped", "servos.rad_per_pulse"),
        "servos.zero_pulse",
    ),
    options={"number_format": NUMBER_FORMAT},
    file="frames.md",
    write=write,
    view=view,
    read=read,
    asked=lambda *source: Asked({"file": "frames.md"}),  # noqa: ARG005
    syntax=_words,
    folder="doc",
)


class Publishing(NamedTuple):
    """How many nodes publish each frame, counted in every combination of modes.

    ``published`` are the frames with exactly one in each, ``gaps`` those with none in some, ``never`` those with none
    in any; ``wrong`` have several, or an invalid condition. ``unchecked`` depend on too many modes.
    """

    modes: tuple[str, ...]
    published: tuple[str, ...]
    gaps: tuple[str, ...]
    never: tuple[str, ...]
    wrong: tuple[str, ...]
    unchecked: tuple[str, ...]

    def in_words(self) -> str:
        """Return the result as a paragraph; empty if a frame is wrong or none is published."""
        if not self.published + self.gaps or self.wrong:
            return ""
        checked = f"Checked in all {2 ** len(self.modes):,} combinations of {listed(self.modes)}"
        if len(self.modes) < 2:
            checked = f"Checked with {self.modes[0]} on and with it off" if self.modes else "Checked"
        what = f"each of {len(self.published)} frames has" if len(self.published) != 1 else "one frame has"
        text = f"{checked}: {what} one parent and exactly one publisher, and no way leads round in a circle."
        text += f" In some of them nobody publishes {listed(self.gaps)}." if self.gaps else ""
        text += f" Nobody ever publishes {listed(self.never)}." if self.never else ""
        text += f" Not checked, for too many modes decide: {listed(self.unchecked)}." if self.unchecked else ""
        return text


def publishing(robot: Robot) -> Publishing:
    """Count the publishers of each frame in every combination of modes."""
    whens: dict[str, list[str]] = {}
    for joint in (joint for joint in robot.joints if joint.child not in robot.simulated_frames):
        whens.setdefault(joint.child, []).extend([""] if joint.publisher.kind != UNPUBLISHED else [])
    for edge in robot.edges:
        whens.setdefault(edge.child, []).extend([edge.when] if edge.publisher.kind != UNPUBLISHED else [])
    kinds: dict[tuple[str, ...], str] = {}
    for conditions in set(map(tuple, whens.values())):
        modes = modes_in(robot, conditions)
        try:
            states = combinations(modes) if len(modes) <= MAX_MODES else ()
            counts = {sum(holds(when, state) for when in conditions) for state in states}
        except ExpressionError:
            counts = {2}
        kind = "gaps" if counts == {0, 1} else "published" if counts == {1} else "wrong"
        kinds[conditions] = ("unchecked" if not counts else kind) if conditions and counts != {0} else "never"
    found: dict[str, list[str]] = {}
    for child, some in whens.items():
        found.setdefault(kinds[tuple(some)], []).append(child)
    modes = modes_in(robot, {when for conditions in kinds for when in conditions})
    return Publishing(tuple(modes), *(tuple(found.get(kind, ())) for kind in Publishing._fields[1:]))

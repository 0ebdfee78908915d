"""frames: a table of all transforms of the robot, in Markdown that is also readable as plain text."""

import math
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

from rosorin_compile.language.expression import ExpressionError
from rosorin_compile.model import Edge, Output, Pose, Publisher, Robot
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.model.robot import JointPose
from rosorin_compile.rules.publishers import MAX_MODES, combinations, holds, modes_in
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.numbers import number_format, to_fixed, vector
from rosorin_compile.source.wording import first_of, phrase
from rosorin_compile.source.xml.elements import number_of, numbers_of

from .format import NUMBER_FORMAT, PLACES, Format, OutputEntry, describe
from .static_tf import FrameTable
from .templating import Templates

# Column headers and minimum widths. Wide columns keep the other lines unchanged if a frame is added.
_FRAME_COLUMNS = {"parent": 18, "child": 18, "published by": 22, "motion": 6, "topic": 10, "x y z (m)": 35}
_FRAME_COLUMNS |= {"roll pitch yaw (rad)": 35, "roll pitch yaw (deg)": 29, "when": 8}
_POSE_COLUMNS = {"pose": 12, "joint": 18, "position": 26, "in degrees": 10, "pulse": 6}
# Special characters of Markdown; an underscore is special only at the start or end of a word.
_MARKS = re.compile(r"[\\`*\[\]<>|~&#!]|(?<!\w)_|_(?!\w)")
_CAPITAL = re.compile(r"(?<=[a-z])(?=[A-Z])")


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the table of all frames of a robot in Markdown. Option: ``number_format`` (short, exact or six)."""
    number, frames = number_format(output.options), _frames(robot)
    stamps = [(f"{sensor.name} ({sensor.type})", sensor.stamps) for sensor in robot.sensors]
    stamps += [(node.name, node.stamps) for node in robot.publishers]
    simulated: dict[str, list[str]] = {}
    for name, why in robot.simulated_frames.items():
        simulated.setdefault(why, []).append(name)
    reasons = [f"{first_of(names, 3)} ({' '.join(why.split())})" for why, names in simulated.items()]
    rows, poses = list[list[str]](), list[list[str]]()
    for frame in frames:
        who, topic, when = _publishing(frame)
        unknown = "not known" if frame.publisher.kind == UNPUBLISHED else f"known to {_escape(who)} alone"
        cells = [_escape(frame.parent), _escape(frame.child), _escape(who), "moving" if frame.moving else "static"]
        cells += [topic] if frame.pose else [topic, unknown, "", ""]
        if frame.pose:
            degrees = vector(map(math.degrees, frame.pose.rpy), partial(to_fixed, digits=4))
            columns = ((vector(frame.pose.xyz, number), 11), (vector(frame.pose.rpy, number), 11), (degrees, 9))
            cells += [" ".join(text.ljust(width) for text in texts.split()).rstrip() for texts, width in columns]
        rows.append([*cells, _escape(" ".join(when.split()))])
    for pose in robot.poses:
        for name, position in pose.positions.items():
            slides = name in robot.joint and robot.joint[name].type == "prismatic"
            degrees = "" if slides else to_fixed(math.degrees(position), 4)
            place = f"{number(position)} {'m' if slides else 'rad'}"
            poses.append([_escape(pose.name), _escape(name), place, degrees, str(pose.pulses.get(name, ""))])
    publishers = dict.fromkeys(frame.publisher for frame in frames)
    named: dict[str, Any] = {"robot": robot, "source": describe, "escape": _escape, "stand_ins": _stand_ins(robot)}
    named |= {"frames": _table(_FRAME_COLUMNS, rows), "poses": _table(_POSE_COLUMNS, poses)}
    named["nodes"] = [node for node in publishers if node.kind != UNPUBLISHED and (node.package or node.about)]
    named["simulated"] = _wrapped(f"Only simulations have {phrase(reasons)}.") if reasons else ""
    named["proof"], named["modes"] = _wrapped(_proof(robot)), _escape(", ".join(robot.modes))
    named["stamps"] = [(name, ", ".join(frames)) for name, frames in stamps if frames]
    return templates.own("core/frames.md.jinja", named), []


def _frames(robot: Robot) -> list[Edge]:
    own, frames = {edge.child: edge for edge in robot.joint_edges()}, list[Edge]()
    for joint in robot.joints_down():
        frames += [own[joint.child]] if joint.child in own else []
        frames += robot.mode_dependent_edges.get(joint.name, ()) if joint.child not in robot.simulated_frames else ()
    return frames + [edge for edge in robot.edges if not edge.joint]


def _publishing(frame: Edge) -> tuple[str, str, str]:
    publisher = frame.publisher
    if publisher.publishes:
        return publisher.name, frame.topic, frame.when or "always"
    return f"nobody: {publisher.about}" if publisher.about else "nobody", frame.topic, frame.when or "never"


def _stand_ins(robot: Robot) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    kinds: dict[str, Sequence[Any]] = {"robot": [robot], "link": robot.links, "joint": robot.joints}
    kinds |= {"sensor": robot.sensors, "servos": robot.servos, "pose": robot.poses, "transform": robot.edges}
    for kind, things in kinds.items():
        for one in (one for one in things if one.source.status == "stand_in"):
            name = f"{one.parent} to {one.child}" if isinstance(one, Edge) else one.name
            found.append((one.source.note or "no reason given", f"{kind} {name}"))
    for link in robot.links:
        for shape in (shape for shape in (*link.collision, *link.visual) if shape.stand_in):
            kind = _CAPITAL.sub(" ", type(shape.geometry).__name__).lower()
            found.append((shape.stand_in, f"the {kind} {shape.name}".strip() + f" of link {link.name}"))
    reasons = dict.fromkeys(reason for reason, _ in found)
    return [(reason, ", ".join(dict.fromkeys(name for why, name in found if why == reason))) for reason in reasons]


@lru_cache(maxsize=1_000)  # cached, because frame names repeat as parents
def _escape(text: str) -> str:
    return _MARKS.sub(r"\\\g<0>", " ".join(map(str.strip, text.splitlines())))


def _wrapped(text: str) -> str:
    return "\n".join(textwrap.wrap(_escape(text), 120, break_long_words=False, break_on_hyphens=False))


def _table(columns: Mapping[str, int], rows: list[list[str]]) -> str:
    lines = (columns, ["-" * width for width in columns.values()], *rows) if rows else ()
    return "\n".join("| " + " | ".join(map(str.ljust, cells, columns.values())) + " |" for cells in lines)


def view(robot: Robot, output: Output) -> FrameTable:  # noqa: ARG001
    """Return the transforms and poses that the tables of a robot must contain."""
    edges = (_edge(frame.parent, frame.child, *_publishing(frame), frame.pose) for frame in _frames(robot))
    return FrameTable(tuple(edges), tuple(JointPose(one.name, one.positions) for one in robot.poses if one.positions))


def _edge(parent: str, child: str, who: str, topic: str, when: str, pose: Pose | None) -> Edge:
    who = " ".join(map(str.strip, who.splitlines()))
    about = who.removeprefix("nobody").removeprefix(": ")
    publisher = Publisher(UNPUBLISHED if topic == "none" else NODE, who, about=about)
    condition = "" if when in ("always", "never") else " ".join(when.split())
    return Edge(parent, child, publisher, topic == "/tf", condition, pose)


def read(text: str) -> FrameTable:
    """Parse the tables in an artifact. Raises ValueError if they are missing or damaged."""
    rows = list(_parse(text, _FRAME_COLUMNS))
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
    for row in _parse(text, _POSE_COLUMNS):
        number, _, unit = row["position"].partition(" ")
        if unit not in ("m", "rad"):
            raise ValueError(f'"{row["position"]}" is not a position of a joint')
        poses.setdefault(row["pose"], {})[row["joint"]] = number_of(number)
    return FrameTable(tuple(edges), tuple(JointPose(name, positions) for name, positions in poses.items()))


def _parse(text: str, headers: Iterable[str]) -> Iterator[dict[str, str]]:
    """Yield each row of the table with these headers as a dict. Raises ValueError if cells are missing."""
    inside = False
    for line in text.splitlines():
        parts = re.split(r"(?<!\\)\|", line) if "\\" in line else line.split("|")
        cells = [*map(str.strip, parts[1:-1])]
        if not inside:
            inside = tuple(cells) == tuple(headers)
        elif not cells:
            return
        elif cells[0].strip("-") or set("".join(cells)) != {"-"}:
            yield dict(zip(headers, (re.sub(r"\\(.)", r"\1", cell) for cell in cells), strict=True))


FORMAT = Format(
    name="frames",
    word="table of frames",
    article="a",
    about="every frame, where it sits and who publishes it",
    rank=70,
    covers=(
        *("robot", "joints.type", "joints.publisher", "sensors.type", "sensors.publisher", "sensors.optical.publisher"),
        *("edges", "publishers", "poses.positions", "poses.pulses", "servos.flipped", "servos.rad_per_pulse"),
        *("servos.zero_pulse", *PLACES),
    ),
    options={"number_format": NUMBER_FORMAT},
    file="frames.md",
    write=write,
    view=view,
    read=read,
    asked=lambda *source: OutputEntry({"file": "frames.md"}),  # noqa: ARG005
    syntax=lambda text: [word for word in text.split() if word.strip("-")],
    folder="doc",
)


def _proof(robot: Robot) -> str:
    """Return a sentence that states that each frame has one publisher, or "" if that is not true."""
    found = frames_by_publishing(robot)
    if not found["published"] + found["gaps"] or found["wrong"]:
        return ""
    modes = modes_in(robot, [edge.when for edge in robot.edges if edge.publisher.kind != UNPUBLISHED])
    checked = f"Checked in all {2 ** len(modes):,} combinations of {phrase(modes)}"
    if len(modes) < 2:
        checked = f"Checked with {modes[0]} on and with it off" if modes else "Checked"
    count = len(found["published"])
    what = f"each of {count} frames has" if count != 1 else "one frame has"
    text = f"{checked}: {what} one parent and exactly one publisher, and no way leads round in a circle."
    text += f" In some of them nobody publishes {phrase(found['gaps'])}." if found["gaps"] else ""
    text += f" Nobody ever publishes {phrase(found['never'])}." if found["never"] else ""
    text += f" Not checked, for too many modes decide: {phrase(found['unchecked'])}." if found["unchecked"] else ""
    return text


def frames_by_publishing(robot: Robot) -> dict[str, list[str]]:
    """Group the names of frames by the number of nodes that publish them in each combination of modes.

    The groups are ``published`` (always by exactly one node), ``gaps`` (by no node in some modes), ``never``, ``wrong``
    (by several nodes) and ``unchecked`` (too many modes).
    """
    whens: dict[str, list[str]] = {}
    frames = [(one.child, "", one.publisher) for one in robot.joints if one.child not in robot.simulated_frames]
    for child, when, publisher in [*frames, *((edge.child, edge.when, edge.publisher) for edge in robot.edges)]:
        whens.setdefault(child, []).extend([when] if publisher.kind != UNPUBLISHED else [])
    kinds: dict[tuple[str, ...], str] = {}
    for conditions in set(map(tuple, whens.values())):
        modes = modes_in(robot, conditions)
        states = combinations(modes) if len(modes) <= MAX_MODES else ()
        try:
            counts = {sum(holds(when, state) for when in conditions) for state in states}
        except ExpressionError:  # a robot constructed in Python can have an invalid condition
            counts = {2}
        kind = "gaps" if counts == {0, 1} else "published" if counts == {1} else "wrong" if counts else "unchecked"
        kinds[conditions] = kind if conditions and counts != {0} else "never"
    groups = ("published", "gaps", "never", "wrong", "unchecked")
    return {kind: [child for child, some in whens.items() if kinds[tuple(some)] == kind] for kind in groups}

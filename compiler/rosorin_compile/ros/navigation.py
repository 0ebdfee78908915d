"""Find the navigation frames of a description (map, odom and base, REP 105) and their publishers.

The section ``edges`` lists published transforms. A transform from a frame outside the robot to a link is the odometry
(odom -> base); the parent of its odom frame is the map frame. The kind of a node follows from its name or package.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from rosorin_compile.model import Output, Publisher, Robot
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.publishers import holds, modes_in
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Help, Suggestion, phrase, quote
from rosorin_compile.source.tree import Path, exists

from .node_kinds import kinds

AMCL, SLAM, FILTER = "amcl", "slam_toolbox", "ekf"


class Problem(NamedTuple):
    """A problem with an entry of ``outputs``; ``path`` is relative to the entry unless ``absolute`` is True."""

    rule: str
    message: str
    path: Path = ()
    help: Help = ""
    severity: str = ERROR
    absolute: bool = False
    key: bool = False


class PublishedTransform(NamedTuple):
    """A published transform parent -> child; ``path`` is the path of its entry in the section ``edges``."""

    parent: str
    child: str
    publisher: Publisher
    path: Path

    def __str__(self) -> str:
        return f"{self.parent} -> {self.child}"


class Frames(NamedTuple):
    """The map frame ("" if unknown), the odom frame, the link that odometry moves, and all published transforms."""

    map: str
    odom: str
    moved: str
    leads: tuple[PublishedTransform, ...]

    def transforms_of(self, publisher: Publisher) -> list[PublishedTransform]:
        """Return the transforms of a publisher, without duplicates."""
        mine = {(lead.parent, lead.child): lead for lead in self.leads if lead.publisher.name == publisher.name}
        return list(mine.values())


def frames_of(robot: Robot, output: Output) -> tuple[Frames | None, list[Problem]]:
    """Return (frames, []), or (None, problems) if the navigation frames are unknown or ambiguous.

    The options ``odom_frame`` and ``map_frame`` of the output select the frames of an ambiguous robot.
    """

    def wrong(message: str, help: Help, path: Path = ()) -> tuple[None, list[Problem]]:
        return None, [Problem("navigation-frames", message, path, help, key=not path)]

    nodes = [one for one in enumerate(robot.edges) if one[1].publisher.kind != UNPUBLISHED and not one[1].joint]
    leads = [PublishedTransform(edge.parent, edge.child, edge.publisher, ("edges", index)) for index, edge in nodes]
    ends = ((one.parent, one.child) for one in leads)
    if not (every := dict.fromkeys(pair for pair in ends if pair[1] in robot.link and pair[0] not in robot.link)):
        edge = f"{{parent: odom, child: {robot.root}, publisher: NAME}}"
        help = f'add "{edge}" to "edges"; NAME is an entry of "publishers"'
        return wrong(f"the transform odom -> {robot.root} has no publisher", help)
    odom_frame, map_frame = output.options.get("odom_frame"), output.options.get("map_frame")
    if not (pairs := [pair for pair in every if odom_frame in (None, pair[0])]):
        parents = Suggestion(str(odom_frame), {parent for parent, _ in every})
        return wrong(f'"{odom_frame}" is not an odometry frame of the robot', parents, ("odom_frame",))
    pairs = [pair for pair in pairs if pair[0] in {lead.child for lead in leads}] or pairs
    if len(pairs) > 1:
        message = f"the robot has more than one odometry: {phrase(f'{parent} -> {child}' for parent, child in pairs)}"
        return wrong(message, 'choose one with "odom_frame: NAME"')
    odom, moved = pairs[0]
    maps = list(dict.fromkeys(lead.parent for lead in leads if lead.child == odom))
    if map_frame is not None and map_frame not in maps:
        message = f'there is no transform from "{map_frame}" to "{odom}"'
        return wrong(message, Suggestion(map_frame, maps), ("map_frame",))
    if map_frame is None and len(maps) > 1:
        message = f'there are transforms to "{odom}" from {quote(maps)}'
        return wrong(message, 'choose the map frame with "map_frame: NAME"')
    return Frames(map_frame or next(iter(maps), ""), odom, moved, tuple(leads)), []


def kind_of(publisher: Publisher) -> str:
    """Return AMCL, SLAM or FILTER for a publisher of this kind, or "" for other nodes."""
    if publisher.kind != NODE or "navsat" in publisher.name:
        return ""
    known = [kinds("")[kind] for kind in (AMCL, SLAM, FILTER)]
    return next((one.name for one in known if publisher.package in one.packages or publisher.name in one.names), "")


def owners_of_odom(robot: Robot, frames: Frames) -> set[str]:
    """Return the kinds (AMCL, SLAM, FILTER or "") of nodes that publish map -> odom when all modes are off."""
    edges = [robot.edges[int(lead.path[-1])] for lead in frames.leads if lead.child == frames.odom]
    off = dict.fromkeys(modes_in(robot, [edge.when for edge in edges]), False)
    return {kind_of(edge.publisher) for edge in edges if edge.parent == frames.map and holds(edge.when, off)}


def owners_of_map(frames: Frames) -> set[str]:
    """Return the kinds (AMCL, SLAM, FILTER or "") of nodes that publish map -> odom in some mode."""
    return {kind_of(one.publisher) for one in frames.leads if (one.parent, one.child) == (frames.map, frames.odom)}


def stated_topic(robot: Robot, name: str) -> str:
    """Return the topic in the ``gazebo`` entry of a sensor, or "" if the topic is not set or equals the sensor name."""
    simulated = (one for sensor in robot.sensors if sensor.name == name for one in sensor.gazebo)
    topics = (element.value for one in simulated for element in one.elements if element.name == "topic")
    return next((str(one) for one in topics if one not in (name, None)), "")


def diagnose(case: Case, output: Output, find: Callable[[Robot, Output], tuple[Any, ...]]) -> Iterator[Diagnostic]:
    """Convert the problems of ``find(robot, output)`` to diagnostics; skip a robot that is not a tree.

    The problems are the last item of the tuple that ``find`` returns.
    """
    entry: Path = ("outputs", output.name)
    problems: list[Problem] = find(case.robot, output)[-1] if case.robot.is_tree else []
    for one in problems:
        path = one.path if one.absolute else (*entry, *one.path)
        key = one.key or not exists(case.tree, path)
        yield case.problem(one.rule, one.message, path, one.help, severity=one.severity, key=key)

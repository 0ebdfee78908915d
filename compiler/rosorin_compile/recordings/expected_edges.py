"""The transforms (edges) that a running robot should publish according to its description, and their tolerances."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Joint, Publisher, Robot, Transform
from rosorin_compile.model.joint import SEVERAL_COORDINATES
from rosorin_compile.rules.publishers import MAX_MODES, combinations, holds, modes_in

# Tolerance (m or rad) for transforms, because conversion to quaternions causes rounding errors.
EXACT = 1e-6
# Tolerance (rad) for angles printed with six decimals ("number_format: six"): the errors of three angles and an axis.
SIX_ANGLE = 4e-6


@dataclass(frozen=True)
class Options:
    """The options of a comparison; they are documented in ``rosorin_compile.verify``."""

    modes: Mapping[str, bool] = field(default_factory=dict)
    without: frozenset[str] = frozenset()
    pose: Mapping[str, float] | None = None
    frames: tuple[str, str] | None = None
    since: float | None = None
    until: float | None = None
    namespace: str = ""
    prefix: str = ""
    stale: float = 1.0


@dataclass(frozen=True)
class ExpectedEdge:
    """A transform parent -> child (an edge) that a ROS node should publish.

    ``transform`` is the expected value (for a moving joint, at position zero), or None if only the ROS node knows it.
    ``radians`` is the tolerance for recorded angles; ``when`` is the condition on modes under which it is published.
    """

    parent: str
    child: str
    publisher: Publisher
    moving: bool
    transform: Transform | None
    joint: Joint | None
    when: str = ""
    radians: float = EXACT
    place: tuple[str | int, ...] = ()

    @property
    def name(self) -> str:
        return f"{self.parent} -> {self.child}"

    @property
    def value(self) -> tuple[str, bool, Transform | None]:
        """The tuple (parent, moving, transform), for comparing the edges to a frame in different modes."""
        return self.parent, self.moving, self.transform

    @property
    def owner(self) -> str:
        """The name of the ROS node that should publish the edge."""
        is_static = self.publisher.kind == STATIC_TRANSFORM_PUBLISHER
        return f"{self.publisher.name} (static_transform_publisher)" if is_static else self.publisher.name

    @property
    def advice(self) -> str:
        """The sentence "NODE should publish PARENT -> CHILD", for the help text of findings."""
        return f"{self.owner} should publish {self.name}"


class Description:
    """The tf2 tree that a robot should publish according to its description and the options of the comparison."""

    def __init__(self, robot: Robot, options: Options) -> None:
        self.robot = robot
        self.options = options
        self.edges = list(_edges(robot))

    @cached_property
    def by_child(self) -> Mapping[str, Sequence[ExpectedEdge]]:
        """The edges that are published in at least one combination of modes, by child frame."""
        by_child: dict[str, list[ExpectedEdge]] = {}
        possible = list(self._combinations())
        for edge in (edge for edge in self.edges if any(holds(edge.when, modes) for modes in possible)):
            by_child.setdefault(edge.child, []).append(edge)
        return by_child

    @cached_property
    def frames(self) -> frozenset[str]:
        """The parents and children of all expected edges."""
        return frozenset(name for edge in self.edges for name in (edge.parent, edge.child))

    def edge_like(
        self, parent: str, child: str, static: bool | None = None, first: Transform | None = None
    ) -> ExpectedEdge | None:
        """Return the expected edge to ``child`` that is most similar to a recorded edge, or None if there is none.

        In different modes, ``child`` can have different edges. ``first`` is the first recorded transform.
        """

        def unlikeness(edge: ExpectedEdge) -> tuple[bool, bool, float]:
            far = 1.0
            if first is not None and edge.transform is not None and not edge.moving:
                metres, radians = math.dist(first.xyz, edge.transform.xyz), edge.transform.angle_to(first)
                far = 0.0 if metres <= EXACT and radians <= edge.radians else 2.0 + metres + radians
            return edge.parent != parent, edge.moving is static, far

        return min(self.by_child.get(child, ()), key=unlikeness, default=None)

    def top(self, frame: str) -> str:
        """Return the topmost ancestor of a frame that is connected to the frame by published joints."""
        while above := next((edge for edge in self.by_child.get(frame, ()) if edge.joint is not None), None):
            frame = above.parent
        return frame

    def owners(self, child: str) -> str:
        """Return the names of the ROS nodes that can publish the frame ``child``, joined by "or"."""
        edges = self.by_child.get(child, ())
        active = [edge for edge in edges if any(edge in way for _, way in self.ways())] if len(edges) > 1 else edges
        return " or ".join(dict.fromkeys(edge.owner for edge in active or edges))

    @cached_property
    def joint_names(self) -> frozenset[str]:
        """The joints that /joint_states should contain: those that robot_state_publisher needs, except mimic joints."""
        return frozenset(self.leader(joint) for joint in self.robot.published_by(ROBOT_STATE_PUBLISHER) if joint.moves)

    def leader(self, joint: Joint) -> str:
        """Return the name of the joint that a mimic joint follows, or of ``joint`` if it is not a mimic joint."""
        while joint.mimic is not None:
            joint = self.robot.joint[joint.mimic.joint]
        return joint.name

    def ways(self) -> Iterator[tuple[Mapping[str, bool], list[ExpectedEdge]]]:
        """Yield (modes, published edges) for each combination of modes that agrees with the options."""
        without = self.options.without
        running = [edge for edge in self.edges if without.isdisjoint((edge.publisher.name, edge.publisher.kind))]
        yield from ((modes, [edge for edge in running if holds(edge.when, modes)]) for modes in self._combinations())

    def _combinations(self) -> Iterator[Mapping[str, bool]]:
        modes = modes_in(self.robot, [edge.when for edge in self.edges])
        for states in combinations([mode for mode in modes if mode not in self.options.modes][:MAX_MODES]):
            yield {**dict.fromkeys(modes, False), **self.options.modes, **states}


def _edges(robot: Robot) -> Iterator[ExpectedEdge]:
    outputs = FORMATS.outputs_read_by(robot, ROBOT_STATE_PUBLISHER)
    six = any(output.options.get("number_format") == "six" for output in outputs)
    for joint in robot.joints_down():
        by_urdf = joint.publisher.kind == ROBOT_STATE_PUBLISHER
        if joint.publisher.publishes and not (by_urdf and joint.is_axleless):
            yield _joint_edge(joint, joint, "", by_urdf, SIX_ANGLE if six and by_urdf else EXACT)
    for index, edge in enumerate(robot.edges):
        if edge.publisher.publishes and edge.joint:
            yield _joint_edge(robot.joint[edge.joint], edge, edge.when, False, EXACT)
        elif edge.publisher.publishes:
            ends, value = (edge.parent, edge.child), edge.pose.transform() if edge.pose is not None else None
            yield ExpectedEdge(*ends, edge.publisher, edge.moving, value, None, edge.when, place=("edges", index))


def _joint_edge(joint: Joint, edge: Any, when: str, by_urdf: bool, radians: float) -> ExpectedEdge:
    free = joint.type in SEVERAL_COORDINATES and not by_urdf
    ends, value = (edge.parent, edge.child), None if free else joint.transform(0.0)
    return ExpectedEdge(*ends, edge.publisher, joint.moves or free, value, joint, when, radians, ("joint", joint.name))

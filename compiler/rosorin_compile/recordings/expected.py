"""Expected: the edges that a running robot should publish, out of its description, and how exactly they are known."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Joint, Publisher, Robot, Transform

MAX_MODES = 10
# Messages carry doubles; what is below a micrometre or microradian is the way through quaternions.
EXACT = 1e-6
# number_format six prints half a millionth of an angle away; a turn is made of three, and of an axis printed as well.
SIX_ANGLE = 4e-6


class Tolerance(NamedTuple):
    """How far a recorded value may be from the described one: metres and radians."""

    metres: float = EXACT
    radians: float = EXACT


DEFAULT = Tolerance()


@dataclass(frozen=True)
class Options:
    """What the person who verifies says about the recording.

    ``modes`` that are known, nodes that were not running (``without``), positions of the joints (rad or m) and the two
    frames of text that does not have them, seconds from the begin of the recording (``since``, ``until``), the
    namespace of the topics, the prefix of the frames, and the age in seconds from which a moving edge is stale.
    """

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
class Expected:
    """An edge that should be there; ``transform`` is the value of one that stands still, None where nobody but the
    publisher knows it. Of a moving joint ``joint`` says how it moves."""  # noqa: D205, D209

    parent: str
    child: str
    publisher: Publisher
    moving: bool
    transform: Transform | None
    joint: Joint | None
    when: str = ""
    tolerance: Tolerance = DEFAULT
    place: tuple[str | int, ...] = ()

    @property
    def name(self) -> str:
        """The edge in words."""
        return f"{self.parent} -> {self.child}"

    @property
    def owner(self) -> str:
        """The node that should publish it, in words."""
        if self.publisher.kind == STATIC_TRANSFORM_PUBLISHER:
            return f"{self.publisher.name} (static_transform_publisher)"
        return self.publisher.name


class Description:
    """What a robot's description says about its running tree."""

    def __init__(self, robot: Robot, options: Options) -> None:
        self.robot = robot
        self.options = options
        self.edges = list(_edges(robot))

    @cached_property
    def by_child(self) -> Mapping[str, tuple[Expected, ...]]:
        """The expected edges into each frame, in the modes that may have been; several where modes decide."""
        by_child: dict[str, list[Expected]] = {}
        combinations = list(self._combinations())
        for edge in self.edges:
            if not edge.when or any(_holds(edge.when, modes) for modes in combinations):
                by_child.setdefault(edge.child, []).append(edge)
        return {child: tuple(edges) for child, edges in by_child.items()}

    @cached_property
    def frames(self) -> frozenset[str]:
        """The frames that should be in the running tree."""
        return frozenset(name for edge in self.edges for name in (edge.parent, edge.child))

    def top(self, frame: str) -> str:
        """Return the topmost frame that published joints of the robot lead to from a frame."""
        while True:
            above = next((edge for edge in self.by_child.get(frame, ()) if edge.joint is not None), None)
            if above is None:
                return frame
            frame = above.parent

    def owners(self, child: str) -> str:
        """Return who should publish the edge into a frame; of several nodes that take turns all that may have been."""
        edges = self.by_child.get(child, ())
        active = [edge for edge in edges if any(edge in way for _, way in self.ways())] if len(edges) > 1 else edges
        return " or ".join(dict.fromkeys(edge.owner for edge in active or edges))

    @cached_property
    def joint_names(self) -> frozenset[str]:
        """The joints that /joint_states should name: those that robot_state_publisher moves by themselves."""
        published = self.robot.published_by(ROBOT_STATE_PUBLISHER)
        return frozenset(self.leader(joint)[0] for joint in published if joint.moves)

    def leader(self, joint: Joint) -> tuple[str, float, float]:
        """Return whose position a joint follows: position = factor * position of the leader + offset."""
        factor, offset = 1.0, 0.0
        while joint.mimic is not None:
            offset += factor * joint.mimic.offset
            factor *= joint.mimic.multiplier
            joint = self.robot.joint[joint.mimic.joint]
        return joint.name, factor, offset

    def ways(self) -> Iterator[tuple[Mapping[str, bool], list[Expected]]]:
        """Yield each combination of modes that may have been, and the edges that should be there in it."""
        for combination in self._combinations():
            yield combination, [edge for edge in self.edges if self._is_there(edge, combination)]

    def _combinations(self) -> Iterator[Mapping[str, bool]]:
        modes = [mode for mode in self.robot.modes if any(_names(edge.when, mode) for edge in self.edges)]
        free = [mode for mode in modes if mode not in self.options.modes][:MAX_MODES]
        for states in product((False, True), repeat=len(free)):
            yield {**dict.fromkeys(modes, False), **self.options.modes, **dict(zip(free, states, strict=True))}

    def _is_there(self, edge: Expected, combination: Mapping[str, bool]) -> bool:
        if {edge.publisher.name, edge.publisher.kind} & self.options.without:
            return False
        return not edge.when or _holds(edge.when, combination)


def _names(when: str, mode: str) -> bool:
    return mode in when.replace("(", " ").replace(")", " ").split()


def _holds(when: str, combination: Mapping[str, bool]) -> bool:
    def lookup(name: str) -> object:
        return combination[name]

    try:
        return bool(evaluate(when, lookup))
    except ExpressionError:  # the rules refuse such a condition before
        return False


def _edges(robot: Robot) -> Iterator[Expected]:
    read = FORMATS.feeding(robot, ROBOT_STATE_PUBLISHER)
    six = any(output.options.get("number_format") == "six" for output in read)
    urdf = Tolerance(EXACT, SIX_ANGLE) if six else Tolerance()
    for joint in robot.joints_down():
        kind = joint.publisher.kind
        if not joint.publisher.publishes or (kind == ROBOT_STATE_PUBLISHER and joint.is_axleless):
            continue
        free = joint.is_several and kind != ROBOT_STATE_PUBLISHER
        still = None if free else joint.transform(0.0)
        tolerance = urdf if kind == ROBOT_STATE_PUBLISHER else Tolerance()
        place: tuple[str | int, ...] = ("joint", joint.name)
        yield Expected(
            joint.parent, joint.child, joint.publisher, joint.moves or free, still, joint, "", tolerance, place
        )
    for index, edge in enumerate(robot.edges):
        if edge.joint and edge.publisher.publishes:
            joint = robot.joint[edge.joint]
            free = joint.is_several
            still = None if free else joint.transform(0.0)
            moving, place = joint.moves or free, ("joint", joint.name)
            yield Expected(edge.parent, edge.child, edge.publisher, moving, still, joint, edge.when, place=place)
        elif edge.publisher.publishes:
            value = edge.pose.transform() if edge.pose is not None else None
            place = ("edges", index)
            yield Expected(edge.parent, edge.child, edge.publisher, edge.moving, value, None, edge.when, place=place)

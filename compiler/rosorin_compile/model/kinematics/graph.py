"""The graph of frames: joints and the transforms of other nodes, and the way from one frame to another."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from ..geometry import Pose, Transform
from ..joint import UNPUBLISHED, Joint, Publisher
from .quaternions import Positions, at

if TYPE_CHECKING:
    from ..robot import Edge, Robot


class NoWay(Exception):
    """There is no known way between two frames; ``missing`` are the steps whose numbers only their publishers know.

    Without ``missing`` the two frames are in trees that do not meet.
    """

    def __init__(self, source: str, target: str, missing: tuple[Step, ...] = ()) -> None:
        super().__init__(f"no known transform from {source} to {target}")
        self.source = source
        self.target = target
        self.missing = missing


class Step(NamedTuple):
    """A transform from ``parent`` to ``child``: a joint of the robot, edges of other nodes, or both.

    Several edges are the same transform, published by one node or the other as the mode says.
    """

    parent: str
    child: str
    joint: Joint | None
    edges: tuple[Edge, ...] = ()

    @property
    def pose(self) -> Pose | None:
        """The pose of a transform that other nodes own; None if it is not known, or not one in all modes."""
        poses = {edge.pose for edge in self.edges}
        return next(iter(poses)) if len(poses) == 1 else None

    @property
    def has_numbers(self) -> bool:
        """Whether the description has the numbers."""
        return self.joint is not None or self.pose is not None

    @property
    def moves(self) -> bool:
        """Whether the transform changes while the robot runs."""
        return (self.joint.type != "fixed") if self.joint is not None else any(edge.moving for edge in self.edges)

    @property
    def publishers(self) -> tuple[tuple[Publisher, str], ...]:
        """Who publishes it, and when: empty if nobody does, and "" for always."""
        senders: list[tuple[Publisher, str]] = []
        if self.joint is not None:
            senders.append((self.joint.publisher, ""))
        senders += [(edge.publisher, edge.when) for edge in self.edges]
        return tuple(one for one in senders if one[0].kind != UNPUBLISHED)

    def transform(self, robot: Robot, positions: Positions) -> Transform:
        """Return the child in the parent at joint positions (radians or metres). Raises ValueError if not known."""
        if self.joint is not None:
            return self.joint.transform(at(robot, self.joint, positions))
        if self.pose is None:
            raise ValueError(f"the description does not know {self.parent} -> {self.child}")
        return self.pose.transform()


class Move(NamedTuple):
    """A step of a way; ``up`` goes from the child to the parent."""

    step: Step
    up: bool


class Graph:
    """All frames of a robot, those of other nodes included, and the ways between them."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        edges: dict[tuple[str, str], list[Edge]] = {}
        for edge in robot.edges:
            edges.setdefault((edge.parent, edge.child), []).append(edge)
        steps = [Step(j.parent, j.child, j, tuple(edges.pop((j.parent, j.child), ()))) for j in robot.joints]
        steps += [Step(parent, child, None, tuple(same)) for (parent, child), same in edges.items()]
        self.steps = tuple(steps)
        self.moves: dict[str, list[Move]] = {link.name: [] for link in robot.links}
        for step in steps:
            self.moves.setdefault(step.parent, []).append(Move(step, False))
            self.moves.setdefault(step.child, []).append(Move(step, True))

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames: links in the order of the description, then those of other nodes."""
        return tuple(self.moves)

    @cached_property
    def parents(self) -> Mapping[str, tuple[Step, ...]]:
        """The steps that somebody publishes into a frame, by frame: those that tf2 knows of."""
        by_child: dict[str, list[Step]] = {}
        for step in self.steps:
            if step.publishers:
                by_child.setdefault(step.child, []).append(step)
        return {frame: tuple(steps) for frame, steps in by_child.items()}

    def way(self, source: str, target: str) -> tuple[Move, ...]:
        """Return the moves from a frame to another, the shortest way whose numbers are known. Raises NoWay, KeyError.

        A frame has one parent on the running robot; the description may know two (a joint that nobody publishes, and
        the transform of a filter), so this is a search.
        """
        known = self._search(source, target, every=False)
        if known is not None:
            return known
        every = self._search(source, target, every=True)
        missing = tuple(move.step for move in every or () if not move.step.has_numbers)
        raise NoWay(source, target, missing)

    def tree(self, base: str) -> dict[str, Move]:
        """Return the last move to each frame that can be reached with known numbers, nearest first. Raises KeyError."""
        return self._reach(base, every=False, until=None)

    def _search(self, source: str, target: str, every: bool) -> tuple[Move, ...] | None:
        reached = self._reach(source, every, until=target)
        if target == source:
            return ()
        if target not in reached:
            if target not in self.moves:
                raise KeyError(target)
            return None
        moves: list[Move] = []
        while target != source:
            moves.append(reached[target])
            target = start_of(moves[-1])
        return tuple(reversed(moves))

    def _reach(self, base: str, every: bool, until: str | None) -> dict[str, Move]:
        """Return the move by which each frame is reached first, in the order of their distance from ``base``."""
        reached: dict[str, Move] = {}
        waiting = deque([base])
        while waiting:
            for move in self.moves[waiting.popleft()]:
                end = end_of(move)
                if end == base or end in reached or not (every or move.step.has_numbers):
                    continue
                reached[end] = move
                if end == until:
                    return reached
                waiting.append(end)
        return reached


def start_of(move: Move) -> str:
    """Return the frame that a move begins in."""
    return move.step.child if move.up else move.step.parent


def end_of(move: Move) -> str:
    """Return the frame that a move ends in."""
    return move.step.parent if move.up else move.step.child

"""The graph of frames, and forward kinematics for many joint states at once.

``Graph`` finds the way from one frame to another through joints and the transforms of other nodes. ``Kinematics``
composes transforms with numpy, which it imports when it is made. The transform that tf2 computes is in ``tf2``.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from .geometry import Pose, Transform, plane_axes, unit
from .joint import UNPUBLISHED, Joint, Publisher

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from .robot import Edge, Robot

    Array = NDArray[np.float64]
    Transforms = tuple[Array, Array]

# The position of a joint: one number (rad or m), or one number for each of its coordinates.
Position: TypeAlias = float | tuple[float, ...]
Positions: TypeAlias = Mapping[str, Position]


def position_of(robot: Robot, joint: Joint, positions: Positions) -> Position:
    """Return the position of a joint (rad or m), through its leader where it mimics one; 0 if it is not named."""
    position = positions.get(joint.name, 0.0)
    if isinstance(position, tuple) or joint.mimic is None:
        return position
    return robot.position(joint, {name: value for name, value in positions.items() if not isinstance(value, tuple)})


class NoWay(Exception):
    """Two frames have no known transform.

    ``missing`` are the steps whose numbers only their publishers know. It is empty if the frames are in separate trees.
    """

    def __init__(self, source: str, target: str, missing: tuple[Step, ...] = ()) -> None:
        super().__init__(f"no known transform from {source} to {target}")
        self.source = source
        self.target = target
        self.missing = missing


class Step(NamedTuple):
    """A transform from ``parent`` to ``child``: a joint of the robot, edges of other nodes, or both.

    Several edges are the same transform, published by different nodes depending on the mode.
    """

    parent: str
    child: str
    joint: Joint | None
    edges: tuple[Edge, ...] = ()

    @property
    def pose(self) -> Pose | None:
        """The pose of a transform of other nodes, or None if it is unknown or depends on the mode."""
        poses = {edge.pose for edge in self.edges}
        return next(iter(poses)) if len(poses) == 1 else None

    @property
    def has_numbers(self) -> bool:
        """Whether the description has the numbers."""
        return self.joint is not None or self.pose is not None

    @property
    def publishers(self) -> tuple[tuple[Publisher, str], ...]:
        """The publishers, each with its condition in modes ("" is always); empty if nobody publishes."""
        senders = [(self.joint.publisher, "")] if self.joint is not None else []
        senders += [(edge.publisher, edge.when) for edge in self.edges]
        return tuple(sender for sender in senders if sender[0].kind != UNPUBLISHED)

    def transform(self, robot: Robot, positions: Positions) -> Transform:
        """Return the child in the parent at joint positions (rad or m). Raises ValueError without numbers."""
        if self.joint is not None:
            return self.joint.transform(position_of(robot, self.joint, positions))
        if self.pose is None:
            raise ValueError(f"the description does not know {self.parent} -> {self.child}")
        return self.pose.transform()


class Move(NamedTuple):
    """A step in one direction; ``up`` goes from the child to the parent."""

    step: Step
    up: bool

    @property
    def start(self) -> str:
        """The frame that the move begins in."""
        return self.step.child if self.up else self.step.parent

    @property
    def end(self) -> str:
        """The frame that the move ends in."""
        return self.step.parent if self.up else self.step.child


class Graph:
    """All frames of a robot, including those of other nodes, and the ways between them."""

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
        """The published steps into each frame: those that tf2 receives."""
        by_child: dict[str, list[Step]] = {}
        for step in self.steps:
            if step.publishers:
                by_child.setdefault(step.child, []).append(step)
        return {frame: tuple(steps) for frame, steps in by_child.items()}

    def way(self, source: str, target: str) -> tuple[Move, ...]:
        """Return the moves from a frame to another, the shortest way whose numbers are known.

        A frame has one parent on the running robot, but the description may have two (a joint that nobody publishes,
        and the transform of a filter), so this is a search. Raises NoWay, and KeyError for an unknown frame.
        """
        if target not in self.moves:
            raise KeyError(target)
        known = self._path(self._reach(source, every=False), source, target)
        if known is None:
            path = self._path(self._reach(source, every=True), source, target) or ()
            raise NoWay(source, target, tuple(move.step for move in path if not move.step.has_numbers))
        return known

    def tree(self, base: str) -> dict[str, Move]:
        """Return the last move to each frame that can be reached with known numbers, nearest first. Raises KeyError."""
        return self._reach(base, every=False)

    def _path(self, reached: Mapping[str, Move], source: str, target: str) -> tuple[Move, ...] | None:
        moves: list[Move] = []
        while target != source:
            if target not in reached:
                return None
            moves.append(reached[target])
            target = moves[-1].start
        return tuple(reversed(moves))

    def _reach(self, base: str, every: bool) -> dict[str, Move]:
        reached: dict[str, Move] = {}
        waiting = deque([base])
        while waiting:
            for move in self.moves[waiting.popleft()]:
                if move.end != base and move.end not in reached and (every or move.step.has_numbers):
                    reached[move.end] = move
                    waiting.append(move.end)
        return reached


class Kinematics:
    """Forward kinematics of a robot for many joint states at once.

    ``positions`` maps joint names to arrays of n positions (radians or metres) or to single numbers. Joints that are
    not named are at zero, joints that mimic others follow them, and names that are not joints have no effect. A joint
    with several coordinates takes an array in the order of ``Joint.coordinates``: (n, 3) if it is planar, (n, 7) if it
    is floating, (n, 4) if it is a ball joint. Raises ImportError, with what to install, where numpy is missing.
    """

    def __init__(self, robot: Robot) -> None:
        try:
            import numpy
        except ImportError:
            from rosorin_compile.source.system import pip_install

            raise ImportError(f"kinematics of many states needs numpy: {pip_install('verify')}") from None
        self.np = numpy
        self.robot = robot
        self.graph = Graph(robot)

    def transforms(self, source: str, target: str, positions: Mapping[str, ArrayLike]) -> Transforms:
        """Return the pose of ``target`` in ``source``: rotations (n, 3, 3) and translations (n, 3) in metres.

        Raises KeyError for an unknown frame, NoWay if the description does not have a transform on the way, and
        ValueError for arrays of different lengths.
        """
        return self.all_frames(source, positions, (target,))[target]

    def all_frames(
        self, base: str, positions: Mapping[str, ArrayLike], frames: Iterable[str] | None = None
    ) -> dict[str, Transforms]:
        """Return the pose of each frame in ``base``, like ``transforms``; by default of all that can be reached."""
        np = self.np
        count, states = self._states(positions)
        if frames is None:
            moves = self.graph.tree(base)
            frames = (base, *moves)
        else:
            frames = tuple(frames)
            moves = {move.end: move for frame in frames for move in self.graph.way(base, frame)}
        poses = {base: np.eye(4)[None]}
        for frame, move in moves.items():
            poses[frame] = poses[move.start] @ self._step(move, states)
        full = {frame: np.broadcast_to(poses[frame], (count, 4, 4)) for frame in frames}
        return {frame: (pose[:, :3, :3], pose[:, :3, 3]) for frame, pose in full.items()}

    def _states(self, positions: Mapping[str, ArrayLike]) -> tuple[int, dict[str, Array]]:
        """Return the number of states, and the positions as arrays (1 or n, number of coordinates)."""
        states: dict[str, Array] = {}
        counts: dict[int, str] = {}
        for name, value in positions.items():
            if name not in self.robot.joint:
                continue
            values = self.np.asarray(value, dtype=float)
            size = len(self.robot.joint[name].coordinates)
            inner = (size,) if size > 1 else ()
            if values.shape[values.ndim - len(inner) :] != inner or values.ndim > 1 + len(inner):
                raise ValueError(f'the positions of joint "{name}" have the shape {values.shape}')
            states[name] = values.reshape(-1, max(size, 1))
            if values.ndim == 1 + len(inner):
                counts.setdefault(len(values), name)
        if len(counts) > 1:
            lengths = ", ".join(f"{count} of {name}" for count, name in counts.items())
            raise ValueError(f"different numbers of positions: {lengths}")
        return next(iter(counts), 1), states

    def _step(self, move: Move, states: Mapping[str, Array]) -> Any:
        """Return the end of a move in its start, (1 or n, 4, 4)."""
        np = self.np
        leader = joint = move.step.joint
        while leader is not None and leader.mimic is not None:
            leader = self.robot.joint[leader.mimic.joint]
        if joint is None or joint.is_fixed or leader is None or leader.name not in states:
            step = self._matrix(move.step.transform(self.robot, {}))
        else:
            state = self.robot.position(joint, states) if joint.mimic is not None else states[joint.name]  # type: ignore[arg-type]
            step = np.matmul(self._matrix(joint.origin.transform()), self._motion(joint, state))
        if not move.up:
            return step
        back = step.transpose(0, 2, 1).copy()
        back[:, 3, :3] = 0.0
        back[:, :3, 3] = -(back[:, :3, :3] @ step[:, :3, 3, None])[:, :, 0]
        return back

    def _matrix(self, transform: Transform) -> Any:
        matrix = self.np.eye(4)[None]
        matrix[0, :3, :3], matrix[0, :3, 3] = transform.rows, transform.xyz
        return matrix

    def _motion(self, joint: Joint, state: Any) -> Any:
        """Return the child in the frame of the joint, (n, 4, 4); the vectorized form of ``joint.motion``."""
        np = self.np
        pose = np.tile(np.eye(4), (len(state), 1, 1))
        if joint.is_axleless:
            pose[:, :3, 3] = state[:, :3] if joint.type == "floating" else 0.0
            i, j, k, w = (state[:, -4:] / np.linalg.norm(state[:, -4:], axis=1, keepdims=True)).T
            rows = (
                (1 - 2 * (j * j + k * k), 2 * (i * j - k * w), 2 * (i * k + j * w)),
                (2 * (i * j + k * w), 1 - 2 * (i * i + k * k), 2 * (j * k - i * w)),
                (2 * (i * k - j * w), 2 * (j * k + i * w), 1 - 2 * (i * i + j * j)),
            )
            pose[:, :3, :3] = np.moveaxis(np.array(rows), -1, 0)
            return pose
        x, y, z = axis = unit(joint.axis)
        if joint.type == "prismatic":
            pose[:, :3, 3] = state * axis
            return pose
        if joint.type == "planar":
            pose[:, :3, 3] = state[:, :2] @ np.array(plane_axes(joint.axis))
        angle = state[:, -1, None, None]
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        pose[:, :3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)  # Rodrigues' formula
        return pose

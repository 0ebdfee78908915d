"""The graph of a robot's frames, and forward kinematics for many joint states at once."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from .geometry import Pose, Transform, unit
from .joint import SEVERAL_COORDINATES, UNPUBLISHED, Joint, Publisher, motion

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from .robot import Edge, Robot

    Array = NDArray[np.float64]
    Transforms = tuple[Array, Array]

# A joint position (rad or m): a number, or a tuple with a number per coordinate for joints with several coordinates.
Position: TypeAlias = float | tuple[float, ...]
Positions: TypeAlias = Mapping[str, Position]


class NoWay(Exception):
    """Raised if two frames are not connected, or if the poses of the steps ``missing`` are unknown."""

    def __init__(self, source: str, target: str, missing: tuple[Step, ...] = ()) -> None:
        super().__init__(f"no known transform from {source} to {target}")
        self.source, self.target, self.missing = source, target, missing


class Step(NamedTuple):
    """A connection parent -> child in the graph of frames.

    ``joint`` is None if no joint connects the frames; ``edges`` are the entries of ``Robot.edges`` for these frames.
    """

    parent: str
    child: str
    joint: Joint | None
    edges: tuple[Edge, ...] = ()

    @property
    def pose(self) -> Pose | None:
        """The pose in ``edges``, or None if it is unknown or depends on the mode."""
        poses = {edge.pose for edge in self.edges}
        return next(iter(poses)) if len(poses) == 1 else None

    @property
    def has_numbers(self) -> bool:
        return self.joint is not None or self.pose is not None

    @property
    def publishers(self) -> tuple[tuple[Publisher, str], ...]:
        """The publishers with their conditions on modes ("" for always), or () if no node publishes the transform."""
        senders = [(self.joint.publisher, "")] if self.joint is not None else []
        senders += [(edge.publisher, edge.when) for edge in self.edges]
        return tuple(sender for sender in senders if sender[0].kind != UNPUBLISHED)

    def transform(self, robot: Robot, positions: Positions) -> Transform:
        """Return the pose of the child at joint positions (rad or m). Raises ValueError if the pose is unknown."""
        if self.joint is not None:
            return self.joint.transform(robot.position(self.joint, positions))
        if self.pose is None:
            raise ValueError(f"the description does not know {self.parent} -> {self.child}")
        return self.pose.transform()


class Move(NamedTuple):
    """A step of a path from frame ``start`` to frame ``end``; ``up`` is True if ``end`` is the parent."""

    step: Step
    start: str
    end: str
    up: bool = False


class Graph:
    """The graph of all frames of a robot: links, and frames that occur only in ``Robot.edges``."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        edges: dict[tuple[str, str], list[Edge]] = {}
        for edge in robot.edges:
            edges.setdefault((edge.parent, edge.child), []).append(edge)
        steps = [Step(j.parent, j.child, j, tuple(edges.pop((j.parent, j.child), ()))) for j in robot.joints]
        steps += [Step(parent, child, None, tuple(same)) for (parent, child), same in edges.items()]
        self.moves: dict[str, list[Move]] = {link.name: [] for link in robot.links}
        for step in steps:
            self.moves.setdefault(step.parent, []).append(Move(step, step.parent, step.child))
            self.moves.setdefault(step.child, []).append(Move(step, step.child, step.parent, up=True))

    @property
    def frames(self) -> tuple[str, ...]:
        return tuple(self.moves)

    def way(self, source: str, target: str) -> tuple[Move, ...]:
        """Return the shortest path from one frame to another on which all poses are known.

        A search is necessary, because a frame can have two parents: one by a joint without a publisher, one by a filter
        node. Raises NoWay if there is no such path, and KeyError for an unknown frame.
        """
        if target not in self.moves:
            raise KeyError(target)
        for every in (False, True):
            reached, moves = self.tree(source, every), list[Move]()
            frame = target
            while frame != source and frame in reached:
                moves.append(reached[frame])
                frame = moves[-1].start
            if frame == source and not every:
                return tuple(reversed(moves))
        missing = [move.step for move in reversed(moves) if not move.step.has_numbers]
        raise NoWay(source, target, tuple(missing) if frame == source else ())

    def tree(self, base: str, every: bool = False) -> dict[str, Move]:
        """Return the last move on the path from ``base`` to each frame; ``every`` allows steps with unknown poses."""
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

    ``positions`` maps joint names to arrays of n positions (rad or m) or to single numbers. Missing joints are at zero,
    mimic joints follow their leaders, and unknown names are ignored. Joints with several coordinates take arrays with a
    column per coordinate, such as (n, 3) for a planar joint. Raises ImportError if numpy is missing.
    """

    def __init__(self, robot: Robot) -> None:
        try:
            import numpy
        except ImportError:
            from rosorin_compile.source.system import pip_install

            raise ImportError(f"kinematics of many states needs numpy: {pip_install('verify')}") from None
        self.np, self.robot, self.graph = numpy, robot, Graph(robot)

    def transforms(self, source: str, target: str, positions: Mapping[str, ArrayLike]) -> Transforms:
        """Return the pose of ``target`` in ``source``: rotations (n, 3, 3) and translations (n, 3) in metres.

        Raises KeyError for an unknown frame, NoWay if a transform between the frames is unknown, and
        ValueError for arrays of different lengths.
        """
        return self.all_frames(source, positions, (target,))[target]

    def all_frames(
        self, base: str, positions: Mapping[str, ArrayLike], frames: Iterable[str] | None = None
    ) -> dict[str, Transforms]:
        """Return the pose in ``base`` of each of ``frames`` (default: all reachable frames); see ``transforms``."""
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
            step = self._step(move.step, states)
            poses[frame] = poses[move.start] @ (np.linalg.inv(step) if move.up else step)
        full = {frame: np.broadcast_to(poses[frame], (count, 4, 4)) for frame in frames}
        return {frame: (pose[:, :3, :3], pose[:, :3, 3]) for frame, pose in full.items()}

    def _states(self, positions: Mapping[str, ArrayLike]) -> tuple[int, dict[str, Array]]:
        """Return the number of states n, and arrays of shape (1 or n, number of coordinates) by joint name."""
        states: dict[str, Array] = {}
        counts: dict[int, str] = {}
        for name in [name for name in positions if name in self.robot.joint]:
            values = self.np.asarray(positions[name], dtype=float)
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

    def _step(self, step: Step, states: Mapping[str, Array]) -> Any:
        np, joint = self.np, step.joint
        leader = joint
        while leader is not None and leader.mimic is not None:
            leader = self.robot.joint[leader.mimic.joint]
        if joint is None or joint.is_fixed or leader is None or leader.name not in states:
            return self._matrices([step.transform(self.robot, {})])
        origin = self._matrices([joint.origin.transform()])
        if joint.type in SEVERAL_COORDINATES:
            return origin @ self._matrices([motion(joint.type, joint.axis, row) for row in states[joint.name].tolist()])
        state: Any = self.robot.position(joint, states)  # type: ignore[arg-type]
        x, y, z = axis = unit(joint.axis)
        pose = np.tile(np.eye(4), (len(state), 1, 1))
        if joint.type == "prismatic":
            pose[:, :3, 3] = state * axis
        else:
            angle, cross = state[:, :, None], np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            pose[:, :3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)  # Rodrigues' formula
        return origin @ pose

    def _matrices(self, transforms: Sequence[Transform]) -> Any:
        matrices = self.np.tile(self.np.eye(4), (len(transforms), 1, 1))
        matrices[:, :3, :3] = [transform.rows for transform in transforms]
        matrices[:, :3, 3] = [transform.xyz for transform in transforms]
        return matrices

"""Many joint states at once, with numpy.

Every joint is brought to move along or about z: its axis is turned there by a constant rotation, and back after it. All
constants between two moving joints are then one constant, multiplied out once. What remains for each state is one
rotation of two columns a joint, and one product with a constant. States are taken in slices that fit into the cache.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..geometry import Transform, Vector, norm
from ..joint import Joint
from ..motion import COORDINATES, plane_axes
from .graph import Graph, Move, end_of, start_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ..robot import Robot

    Array = NDArray[np.float64]
    Transforms = tuple[Array, Array]

SLICE = 4096
_TURNS = ("revolute", "continuous")


class Motion(NamedTuple):
    """What a joint does along a way: constant, motion along or about z (``sign`` -1: back), constant.

    A planar joint slides along x and y, too. Of a floating joint the motion is a whole pose.
    """

    joint: Joint
    sign: float
    before: Transform
    after: Transform


class Stage(NamedTuple):
    """A motion that starts from the frame ``start`` (a key of the states so far), after the constant ``before``."""

    start: int
    before: Transform
    motion: Motion


class Plan(NamedTuple):
    """How to reach frames: the stages in order, and for each frame the stage (-1: none) and the constant after it."""

    stages: tuple[Stage, ...]
    ends: Mapping[str, tuple[int, Transform]]


class Kinematics:
    """Forward kinematics of a robot for many joint states at once.

    ``positions`` maps joint names to arrays of n positions (radians or metres) or to single numbers; joints not named
    are at zero, joints that mimic others follow them, and names that are no joints have no effect. A joint of several
    coordinates takes an array (n, 3) if it is planar, (n, 7) if it is floating, (n, 4) if it is a ball, in the order of
    ``Joint.coordinates``.
    Raises ImportError, with what to install, where numpy is missing.
    """

    def __init__(self, robot: Robot) -> None:
        try:
            import numpy
        except ImportError:
            from rosorin_compile.source.installing import pip_install

            raise ImportError(f"kinematics of many states needs numpy: {pip_install('verify')}") from None
        self.np = numpy
        self.robot = robot
        self.graph = Graph(robot)
        self._plans: dict[tuple[str, tuple[str, ...] | None, frozenset[str]], Plan] = {}

    def transforms(self, source: str, target: str, positions: Mapping[str, ArrayLike]) -> Transforms:
        """Return where ``target`` sits in ``source``: rotations (n, 3, 3) and translations (n, 3), in metres.

        Both are views of one block of memory, not contiguous. Raises KeyError for an unknown frame, NoWay where the
        description does not know a transform in between, ValueError for arrays of different lengths.
        """
        return self.all_frames(source, positions, (target,))[target]

    def all_frames(
        self, base: str, positions: Mapping[str, ArrayLike], frames: Iterable[str] | None = None
    ) -> dict[str, Transforms]:
        """Return where frames sit in ``base``, as ``transforms`` does; by default all that can be reached from it."""
        count, given = self._given(positions)
        return self._run(self._plan(base, None if frames is None else tuple(frames), frozenset(given)), count, given)

    def _given(self, positions: Mapping[str, ArrayLike]) -> tuple[int, dict[str, Array]]:
        """Return the number of states, and the positions as arrays (n,) or (n, 7); raises ValueError."""
        given: dict[str, Array] = {}
        counts: dict[int, str] = {}
        for name, values in positions.items():
            if name not in self.robot.joint:
                continue
            given[name] = array = self.np.asarray(values, dtype=float)
            joint = self.robot.joint[name]
            inner = (len(joint.coordinates),) if is_spatial(joint) else ()
            if array.shape[array.ndim - len(inner) :] != inner or array.ndim > 1 + len(inner):
                raise ValueError(f'the positions of joint "{name}" have the shape {array.shape}')
            if array.ndim == 1 + len(inner):
                counts.setdefault(len(array), name)
        if len(counts) > 1:
            told = ", ".join(f"{count} of {name}" for count, name in counts.items())
            raise ValueError(f"different numbers of positions: {told}")
        return next(iter(counts), 1), given

    def _plan(self, base: str, frames: tuple[str, ...] | None, given: frozenset[str]) -> Plan:
        key = (base, frames, given)
        if key not in self._plans:
            if frames is None:
                plan = self._folded(base, self.graph.tree(base).values(), given)
            else:
                ways = [self.graph.way(base, frame) for frame in frames]
                plan = self._folded(base, dict.fromkeys(move for way in ways for move in way), given)
                plan = Plan(plan.stages, {frame: plan.ends[frame] for frame in frames})
            self._plans[key] = plan
        return self._plans[key]

    def _folded(self, base: str, moves: Iterable[Move], given: frozenset[str]) -> Plan:
        """Return the plan of moves, each from a frame that one before it reached; what is fixed is multiplied out."""
        stages: list[Stage] = []
        ends: dict[str, tuple[int, Transform]] = {base: (-1, Transform())}
        for move in moves:
            stage, constant = ends[start_of(move)]
            frame = end_of(move)
            joint = move.step.joint
            if joint is None or self._leader(joint) not in given:
                step = move.step.transform(self.robot, {})
                ends[frame] = (stage, constant.then(step.inverse() if move.up else step))
                continue
            motion = motion_of(joint, move.up)
            stages.append(Stage(stage, constant.then(motion.before), motion))
            ends[frame] = (len(stages) - 1, motion.after)
        return Plan(tuple(stages), ends)

    def _leader(self, joint: Joint) -> str:
        """Return the joint whose position a joint takes, itself if it follows nobody; "" of a fixed joint."""
        while joint.mimic is not None:
            joint = self.robot.joint[joint.mimic.joint]
        return joint.name if joint.moves or is_spatial(joint) else ""

    def _run(self, plan: Plan, count: int, given: Mapping[str, Array]) -> dict[str, Transforms]:
        """Return the frames of a plan, for all states."""
        np = self.np
        made: dict[str, Array] = {}
        for frame, (index, constant) in plan.ends.items():
            if index < 0:
                block = np.array([(*row, x) for row, x in zip(constant.rows, constant.xyz, strict=True)])
                made[frame] = np.broadcast_to(block[:, :, None], (3, 4, count))
            else:
                made[frame] = np.empty((3, 4, count))
        moving = [(made[frame], stage, _Factor(np, c)) for frame, (stage, c) in plan.ends.items() if stage >= 0]
        before = [_Factor(np, stage.before) for stage in plan.stages]
        states = [np.empty((3, 4, min(SLICE, count))) for _ in plan.stages]
        for part in _slices(count):
            here = [state[:, :, : part.stop - part.start] for state in states]
            for stage, factor, state in zip(plan.stages, before, here, strict=True):
                factor.apply(None if stage.start < 0 else here[stage.start], state)
                self._move(stage.motion, state, part, given)
            for out, index, factor in moving:
                factor.apply(here[index], out[:, :, part])
        return {frame: (block[:, :3].transpose(2, 0, 1), block[:, 3].T) for frame, block in made.items()}

    def _move(self, motion: Motion, state: Array, part: slice, given: Mapping[str, Array]) -> None:
        """Move states (3, 4, m) by one joint, in place."""
        np, joint = self.np, motion.joint
        if joint.is_axleless:
            _multiply(state, *_poses(np, _part(given[joint.name], part, 1), motion.sign))
        elif joint.type == "planar":
            x, y, angle = np.moveaxis(motion.sign * _part(given[joint.name], part, 1), -1, 0)
            if motion.sign < 0:
                _rotate(np, state, angle)
            state[:, 3] += state[:, 0] * x + state[:, 1] * y
            if motion.sign > 0:
                _rotate(np, state, angle)
        else:
            leader = self._leader(joint)
            q = motion.sign * self.robot.position(joint, {leader: _part(given[leader], part, 0)})  # type: ignore[dict-item]
            if joint.type == "prismatic":
                state[:, 3] += state[:, 2] * q
            else:
                _rotate(np, state, q)


def _part(positions: Array, part: slice, inner: int) -> Array:
    """Return the positions of some states; ``inner`` is the number of axes of a single one."""
    return positions[part] if positions.ndim > inner else positions


def _rotate(np: Any, state: Array, angle: Array | float) -> None:
    """Turn states (3, 4, m) about z by angles (m,), in place."""
    sine, cosine = np.sin(angle), np.cos(angle)
    x, y = state[:, 0], state[:, 1]
    rotated = x * cosine
    rotated += y * sine
    y *= cosine
    y -= x * sine
    x[...] = rotated


def _poses(np: Any, poses: Array, sign: float) -> tuple[Array, Array]:
    """Return the rotations (3, 3, m) and offsets (3, m) of poses (m, 7), or of their inverses where ``sign`` is -1.

    Orientations alone are (m, 4).
    """
    *xyz, i, j, k, w = np.atleast_2d(poses).T
    s = 2 / (i * i + j * j + k * k + w * w)
    rotation = np.array(
        [
            [1 - s * (j * j + k * k), s * (i * j - k * w), s * (i * k + j * w)],
            [s * (i * j + k * w), 1 - s * (i * i + k * k), s * (j * k - i * w)],
            [s * (i * k - j * w), s * (j * k + i * w), 1 - s * (i * i + j * j)],
        ]
    )
    offset = np.array(xyz or [0 * i] * 3)
    if sign < 0:
        rotation = rotation.transpose(1, 0, 2)
        offset = -np.einsum("ijm,jm->im", rotation, offset)
    return rotation, offset


def _multiply(state: Array, rotation: Array, offset: Array) -> None:
    """Multiply states (3, 4, m) by transforms from the right, in place."""
    state[:, 3] += (state[:, :3] * offset).sum(1)
    state[:, :3] = (state[:, :3, None] * rotation).sum(1)


class _Factor:
    """A constant transform that states are multiplied by, from the right."""

    def __init__(self, np: Any, transform: Transform) -> None:
        self.np = np
        self.columns = np.array([*zip(*transform.rows, strict=True), transform.xyz])

    def apply(self, states: Array | None, out: Array) -> None:
        """Write the product of states (3, 4, m), None for identities, with this constant into ``out``."""
        if states is None:
            out[...] = self.columns.T[:, :, None]
            return
        self.np.matmul(self.columns, states[:, :3], out=out)
        out[:, 3] += states[:, 3]


def _slices(count: int) -> Iterator[slice]:
    for start in range(0, count, SLICE):
        yield slice(start, min(start + SLICE, count))


def is_spatial(joint: Joint) -> bool:
    """Whether a joint moves, but not by one number: planar, floating and ball joints."""
    return len(COORDINATES[joint.type]) > 1


def motion_of(joint: Joint, up: bool) -> Motion:
    """Return what a joint does, from parent to child or, ``up``, back."""
    origin = joint.origin.transform()
    rotation = Transform() if joint.is_axleless else _onto(joint.axis)
    if up:
        return Motion(joint, -1.0, rotation, rotation.inverse().then(origin.inverse()))
    return Motion(joint, 1.0, origin.then(rotation), rotation.inverse())


def _onto(axis: Vector) -> Transform:
    """Return a rotation that turns z onto an axis, which need not be of unit length."""
    length = norm(axis)
    first, second = plane_axes(axis)
    rows = tuple(zip(first, second, (c / length for c in axis), strict=True))
    return Transform((rows[0], rows[1], rows[2]))

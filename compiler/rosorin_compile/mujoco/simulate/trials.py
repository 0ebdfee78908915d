"""Trials: the robot rests, holds its poses, drives, sweeps its joints, and swings without anything that brakes it.

Each trial begins anew and gives numbers; ``judging`` says what they mean. A trial that leaves the numbers has
``broken``, and what was seen until then. ``curves`` are for the page: name, unit, times (s) and values.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Drive, Joint, Robot, Twist
from rosorin_compile.source.progress import Progress

from .world import FREE, POSITION, Broken, Touch, World, moving

if TYPE_CHECKING:
    from .world import Floats

HOME = "home"
LAST = 0.25  # s at the end of a trial over which is averaged
RAMP = 0.5  # s until a drive is at its speed
FORWARD, SIDEWAYS, TURN = "forward", "sideways", "turn"
COMMANDS: Mapping[str, Twist] = {
    FORWARD: Twist(vx=0.3),
    SIDEWAYS: Twist(vy=0.3),
    TURN: Twist(wz=1.0),
}
CURVE = Twist(vx=0.3, wz=0.3)  # what a base that steers does in place of turning on the spot
DRIVING = 2.0  # s at speed, of which the second half counts
SWING = 0.5  # s
_PUSH = 0.5  # rad/s, or a tenth of it in m/s: the speed that joints swing from
_SWEEP_SPEED = 1.0  # rad/s or m/s at most, and half of the limit of the joint
_SWEEP_SHARE = 0.5
_LONGEST, _SHORTEST = 4.0, 0.25  # s from one end to the other
_AT_END = 0.4  # s


class Curve(NamedTuple):
    """What was seen over time: a name, the unit of the values, times (s) and values."""

    name: str
    unit: str
    times: list[float]
    values: list[float]


class Stop(NamedTuple):
    """How a trial ended before its time: why, when (s), and which joint left the numbers first, if that is known."""

    why: str
    time: float
    joint: str = ""


@dataclass
class PoseTrial:
    """A pose that was held.

    ``errors`` are the mean errors at the end (rad or m) by joint, ``swings`` how far each still moves. ``drift`` (m)
    and ``turned`` (rad) say how far the base moved over the floor, ``leans`` (rad) how far it leans over, ``ripple``
    (m) how much its height changes at the end. ``touches`` are the links that touch there, ``stands_on`` those that
    touch the floor, ``above`` the wheels that do not, by joint, and how high they are (m).
    """

    pose: str
    positions: Mapping[str, float]
    errors: dict[str, float] = field(default_factory=dict)
    swings: dict[str, float] = field(default_factory=dict)
    drift: float = 0.0
    turned: float = 0.0
    leans: float = 0.0
    ripple: float = 0.0
    touches: list[Touch] = field(default_factory=list)
    stands_on: list[str] = field(default_factory=list)
    above: dict[str, float] = field(default_factory=dict)
    broken: Stop | None = None
    curves: list[Curve] = field(default_factory=list, repr=False)

    @property
    def worst(self) -> tuple[str, float] | None:
        """The joint that is farthest from where it is told to be, and how far (rad or m)."""
        return max(self.errors.items(), key=lambda item: item[1], default=None)


@dataclass
class Driven:
    """A command that was driven: ``asked`` and ``measured`` (m/s, rad/s), and the ripple of the height (m).

    ``off`` is the largest error of a commanded part of the velocity, as a share of it; ``cross`` the largest part (m/s
    or rad/s) that was not commanded. ``scale`` is the share of the command that the limits of the wheels allow;
    ``touches`` are the links that touch at the end.
    """

    command: str
    asked: Twist
    measured: Twist = field(default_factory=Twist)
    off: float = 0.0
    cross: float = 0.0
    ripple: float = 0.0
    scale: float = 1.0
    touches: list[Touch] = field(default_factory=list)
    broken: Stop | None = None
    curves: list[Curve] = field(default_factory=list, repr=False)


class End(NamedTuple):
    """An end of a sweep: the requested position, the error there (rad or m), and the links that touch there.

    ``first_touch`` is the first contact on the way, ``touch_position`` the position of the joint then (rad or m).
    """

    asked: float
    error: float
    touches: list[Touch]
    first_touch: Touch | None = None
    touch_position: float = 0.0


@dataclass
class Swept:
    """A joint that was led through its range, first to the lower end."""

    joint: str
    ends: list[End] = field(default_factory=list)
    broken: Stop | None = None
    curves: list[Curve] = field(default_factory=list, repr=False)


@dataclass
class Swung:
    """The energy of the robot without damping, friction, actuators and contacts; without gravity where it is not held.

    ``change`` is the largest change as a share of the largest kinetic energy ``kinetic`` (J); ``lightest`` is the
    joint that moves the least inertia.
    """

    change: float = 0.0
    kinetic: float = 0.0
    lightest: str = ""
    broken: Stop | None = None
    curves: list[Curve] = field(default_factory=list, repr=False)


def poses_of(world: World) -> list[tuple[str, Mapping[str, float]]]:
    """Return the poses to hold: home first (that pose, or zero, as near as the limits let), then the others."""
    poses = {pose.name: pose.positions for pose in world.robot.poses}
    home = poses.pop(HOME, None)
    first = {joint.name: nearest(joint) for joint in moving(world.robot)} if home is None else home
    return [(HOME, first), *poses.items()]


def nearest(joint: Joint) -> float:
    """Return the position (rad or m) within the limits of a joint that is nearest to zero."""
    limit = joint.limit
    if limit is None or joint.type == "continuous" or limit.lower is None or limit.upper is None:
        return 0.0
    return min(max(0.0, limit.lower), limit.upper) if limit.lower <= limit.upper else 0.0


class _Seen:
    """What is seen of a trial, a sample every ``sample`` s."""

    def __init__(self, sample: float) -> None:
        self.sample = sample
        self.times: list[float] = []
        self.rows: dict[tuple[str, str], list[float]] = {}

    def add(self, time: float, **values: tuple[float, str]) -> None:
        self.put(time, {(name, unit): value for name, (value, unit) in values.items()})

    def put(self, time: float, values: Mapping[tuple[str, str], float]) -> None:
        self.times.append(time)
        for key, value in values.items():
            self.rows.setdefault(key, []).append(value)

    def curves(self) -> list[Curve]:
        return [Curve(name, unit, self.times, values) for (name, unit), values in self.rows.items()]

    def last(self, key: tuple[str, str], seconds: float) -> list[float]:
        return self.rows.get(key, [])[-max(1, round(seconds / self.sample)) :]


def hold(world: World, pose: str, positions: Mapping[str, float], seconds: float) -> PoseTrial:
    """Leave the robot to its actuators in a pose for some seconds (at least twice ``LAST``)."""
    made, seen = PoseTrial(pose, positions), _Seen(world.sample)
    world.reset(positions)
    targets = {joint.name: world.robot.position(joint, positions) for joint in _held(world)}
    start = _flat(world) if world.base == FREE else None
    before = world.place(world.robot.root)[0]
    try:
        for time in world.run(seconds):
            values = {(name, _unit(world, name)): world.position(name) - aim for name, aim in targets.items()}
            if start is not None:
                values["height", "m"] = float(world.place(world.robot.root)[1][2])
            seen.put(time, values)
    except Broken as problem:
        made.broken = Stop(str(problem), problem.time, problem.joint)
    made.curves = seen.curves()
    for name in targets:
        tail = seen.last((name, _unit(world, name)), LAST)
        if tail:
            made.errors[name] = abs(sum(tail) / len(tail))
            made.swings[name] = max(tail) - min(tail)
    if made.broken is None:
        made.touches, made.stands_on = world.touches(), world.stands_on()
        made.above = world.above_floor()
        if start is not None:
            x, y, yaw = _flat(world)
            made.drift, made.turned = math.hypot(x - start[0], y - start[1]), abs(_wrapped(yaw - start[2]))
            made.leans = _lean(before, world.place(world.robot.root)[0])
            height = seen.last(("height", "m"), LAST)
            made.ripple = max(height) - min(height)
    return made


def _held(world: World) -> list[Joint]:
    """Return the joints that an actuator holds, or that follow such a one."""
    names = {one.joint for one in world.holding()} - set(world.own)
    found = []
    for joint in moving(world.robot):
        leader = joint
        while leader.mimic is not None:
            leader = world.robot.joint[leader.mimic.joint]
        if leader.name in names or joint.name in names:
            found.append(joint)
    return found


def _unit(world: World, joint: str) -> str:
    return "m" if world.robot.joint[joint].type == "prismatic" else "rad"


def _flat(world: World) -> tuple[float, float, float]:
    """Return where the root is on the floor: x, y (m) and yaw (rad)."""
    rows, place = world.place(world.robot.root)
    return float(place[0]), float(place[1]), math.atan2(rows[1][0], rows[0][0])


def _lean(one: Floats, other: Floats) -> float:
    """Return the angle (rad) between what was up in a rotation (3, 3), and what is up in another one."""
    return math.acos(max(-1.0, min(1.0, float(one[2] @ other[2]))))


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)


def commands_of(robot: Robot) -> dict[str, Twist]:
    """Return the commands that the drive of a robot can follow."""
    driving = robot.driving
    if driving.slides:
        return dict(COMMANDS)
    if driving.steering:
        return {FORWARD: COMMANDS[FORWARD], "curve": CURVE}
    return {FORWARD: COMMANDS[FORWARD], TURN: COMMANDS[TURN]}


def drive(world: World, positions: Mapping[str, float], command: str, asked: Twist) -> Driven:
    """Drive a command from a pose: half a second to get to speed, a second to settle, and one that counts."""
    driving = world.robot.driving
    scale = _scale(world, asked)
    asked = Twist(*(scale * part for part in asked))
    made, seen = Driven(command, asked, scale=scale), _Seen(world.sample)
    angles = driving.angles(asked)
    world.reset({**positions, **angles})
    centre = (*driving.centre, 0.0)
    track = _Track(world, driving.frame, centre)
    speeds = driving.speeds(asked, angles)

    def tell(now: float) -> None:
        for name, speed in speeds.items():
            world.turn(name, speed * min(1.0, now / RAMP), world.sample)
        for name, angle in angles.items():
            world.hold(name, angle)

    try:
        for time in world.run(RAMP + DRIVING, tell):
            vx, vy, wz, height = track.step(time)
            seen.add(time, vx=(vx, "m/s"), vy=(vy, "m/s"), wz=(wz, "rad/s"), height=(height, "m"))
    except Broken as problem:
        made.broken = Stop(str(problem), problem.time, problem.joint)
    made.curves = seen.curves()
    if made.broken is None:
        made.measured, made.touches = track.mean(DRIVING / 2), world.touches()
        parts = list(zip(made.asked, made.measured, strict=True))
        made.off = max(abs(measured - asked) / abs(asked) for asked, measured in parts if asked)
        made.cross = max((abs(measured) for asked, measured in parts if not asked), default=0.0)
        heights = seen.last(("height", "m"), DRIVING / 2)
        made.ripple = max(heights) - min(heights)
    return made


class _Track:
    """Where a point of the base is, sample by sample, and its velocity in the axes of the base."""

    def __init__(self, world: World, frame: str, centre: tuple[float, float, float]) -> None:
        self.world, self.frame, self.centre = world, frame, centre
        self.states = [(0.0, *self._state())]

    def _state(self) -> tuple[float, float, float, float]:
        rows, place = self.world.place(self.frame)
        x, y, z = place + rows @ self.centre
        return float(x), float(y), math.atan2(rows[1][0], rows[0][0]), float(z)

    def step(self, time: float) -> tuple[float, float, float, float]:
        """Look again; return vx, vy (m/s) and wz (rad/s) since the last time, and the height (m)."""
        self.states.append((time, *self._state()))
        vx, vy, wz = self._velocity(self.states[-2], self.states[-1])
        return vx, vy, wz, self.states[-1][4]

    def mean(self, seconds: float) -> Twist:
        """Return the mean velocity of the last seconds."""
        count = max(1, round(seconds / self.world.sample))
        pairs = list(zip(self.states, self.states[1:], strict=False))[-count:]
        found = [self._velocity(*pair) for pair in pairs]
        vx, vy, wz = (sum(parts) / len(found) for parts in zip(*found, strict=True))
        return Twist(vx, vy, wz)

    def _velocity(self, one: Sequence[float], other: Sequence[float]) -> tuple[float, float, float]:
        seconds, turned = other[0] - one[0], _wrapped(other[3] - one[3])
        x, y, middle = other[1] - one[1], other[2] - one[2], one[3] + turned / 2
        cosine, sine = math.cos(middle), math.sin(middle)
        return (cosine * x + sine * y) / seconds, (cosine * y - sine * x) / seconds, turned / seconds


def _scale(world: World, asked: Twist) -> float:
    """Return how much of a command the wheels can be asked for (0 to 1)."""
    scale = 1.0
    for name, speed in world.robot.driving.speeds(asked).items():
        highest = world.highest_speed(name)
        limit = world.robot.joint[name].limit
        known = [one for one in (highest, limit.known("velocity") if limit else None) if one]
        if known and abs(speed) > min(known):
            scale = min(scale, 0.9 * min(known) / abs(speed))
    return scale


def swept_joints(world: World) -> list[tuple[Joint, tuple[float, float]]]:
    """Return the joints that an actuator can lead through a range, and the ends of it (rad or m)."""
    found = []
    drive: Drive | None = world.robot.drive
    wheels = drive.wheels if drive is not None else ()
    for joint in moving(world.robot):
        limit = joint.limit
        if joint.mimic is not None or joint.name in (*wheels, *world.own) or limit is None:
            continue
        if joint.type == "continuous" or limit.lower is None or limit.upper is None:
            continue
        if world.of(joint.name, POSITION) is None or not limit.lower < limit.upper:
            continue
        lower, upper = world.reach(joint.name) or (limit.lower, limit.upper)
        ends = (max(lower, limit.lower), min(upper, limit.upper))
        if ends[0] < ends[1]:
            found.append((joint, ends))
    return found


def sweep(world: World, positions: Mapping[str, float], joint: Joint, ends: tuple[float, float]) -> Swept:
    """Lead a joint from a pose to its lower end, and from there to its upper one."""
    made, seen = Swept(joint.name), _Seen(world.sample)
    world.reset(positions)
    unit, began = _unit(world, joint.name), _pairs(world.touches())
    here, clock = world.position(joint.name), 0.0
    try:
        for end in ends:
            seconds = _seconds(joint, abs(end - here))
            tail: list[float] = []
            first, begins, there = None, 0.0, began | _pairs(world.touches())
            for time in world.run(seconds + _AT_END, _leading(world, joint.name, here, end, seconds)):
                now = world.position(joint.name)
                aim = world.aims[joint.name]
                seen.put(clock + time, {(joint.name, unit): now, ("asked for", unit): aim})
                tail = [*tail, abs(now - end)][-max(1, round(LAST / world.sample / 2)) :]
                new = [one for one in world.touches() if one.links not in began]
                fresh = [one for one in new if one.links not in there]
                if fresh and first is None:
                    first, begins = fresh[0], now
            made.ends.append(End(end, sum(tail) / len(tail), new, first, begins))
            clock, here = clock + seconds + _AT_END, end
    except Broken as problem:
        made.broken = Stop(str(problem), problem.time, problem.joint)
    made.curves = seen.curves()
    return made


def _leading(world: World, joint: str, start: float, end: float, seconds: float) -> Callable[[float], None]:
    return lambda now: world.hold(joint, start + (end - start) * min(1.0, now / seconds))


def _pairs(touches: Sequence[Touch]) -> set[tuple[str, str]]:
    return {one.links for one in touches}


def _seconds(joint: Joint, way: float) -> float:
    """Return how long a joint is led over a way (rad or m)."""
    velocity = joint.limit.known("velocity") if joint.limit else None
    speed = min(_SWEEP_SPEED, _SWEEP_SHARE * velocity) if velocity else _SWEEP_SPEED
    if joint.type == "prismatic":
        speed = min(speed, 0.1)
    return min(_LONGEST, max(_SHORTEST, way / speed))


def swing(world: World, positions: Mapping[str, float]) -> Swung:
    """Let the robot swing freely from a pose, nothing braking it, and watch its energy (Runge-Kutta, its own step)."""
    mujoco = world.mujoco
    free = copy.copy(world)
    free.model = copy.copy(world.model)
    _unbrake(mujoco, free.model)
    if world.base == FREE:
        free.model.opt.gravity[:] = 0.0  # a fall would hide all else
    free.data = mujoco.MjData(free.model)
    free.reset(positions)
    for index, joint in enumerate(moving(world.robot)):
        speed = _PUSH * (0.1 if joint.type == "prismatic" else 1.0)
        free.data.joint(joint.name).qvel[0] = -speed if index % 2 else speed
    mujoco.mj_forward(free.model, free.data)
    inertias = {
        joint.name: float(free.model.dof_M0[free.model.joint(joint.name).dofadr[0]]) for joint in moving(world.robot)
    }
    made, seen = Swung(lightest=min(inertias, key=lambda name: inertias[name])), _Seen(world.sample)
    began = float(free.data.energy.sum())
    try:
        for time in free.run(SWING):
            potential, kinetic = map(float, free.data.energy)
            seen.add(time, energy=(potential + kinetic - began, "J"), kinetic=(kinetic, "J"))
            made.kinetic = max(made.kinetic, kinetic)
            made.change = max(made.change, abs(potential + kinetic - began))
    except Broken as problem:
        made.broken = Stop(str(problem), problem.time, problem.joint)
    made.change = made.change / made.kinetic if made.kinetic else 0.0
    made.curves = seen.curves()
    return made


def _unbrake(mujoco: Any, model: Any) -> None:
    """Take from a model all that gives or takes energy."""
    bits = mujoco.mjtDisableBit
    damper = "DAMPER" if hasattr(bits, "mjDSBL_DAMPER") else "PASSIVE"  # MuJoCo 3.3: springs with it, which keep energy
    for name in ("CONTACT", "EQUALITY", "LIMIT", "FRICTIONLOSS", "ACTUATION", damper):
        model.opt.disableflags |= int(getattr(bits, f"mjDSBL_{name}"))
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    model.opt.integrator = int(mujoco.mjtIntegrator.mjINT_RK4)
    model.opt.density = model.opt.viscosity = 0.0


@dataclass
class Trials:
    """All trials of a robot."""

    poses: list[PoseTrial] = field(default_factory=list)
    drives: list[Driven] = field(default_factory=list)
    sweeps: list[Swept] = field(default_factory=list)
    swung: Swung | None = None


def all_trials(world: World, seconds: float) -> Trials:
    """Run all trials; each pose is held for ``seconds``."""
    made = Trials()
    jobs = list(_jobs(world, seconds, made))
    for number, job in enumerate(jobs):
        Progress.step("simulating", number, len(jobs))
        job()
    return made


def _jobs(world: World, seconds: float, made: Trials) -> Iterator[Callable[[], None]]:
    poses = poses_of(world)
    home = poses[0][1]
    for name, positions in poses:
        yield lambda name=name, positions=positions: made.poses.append(  # type: ignore[misc]
            hold(world, name, positions, seconds)
        )
    if world.robot.drive is not None and world.base == FREE:
        for command, twist in commands_of(world.robot).items():
            yield lambda command=command, twist=twist: made.drives.append(  # type: ignore[misc]
                drive(world, home, command, twist)
            )
    for joint, ends in swept_joints(world):
        yield lambda joint=joint, ends=ends: made.sweeps.append(sweep(world, home, joint, ends))  # type: ignore[misc]
    if moving(world.robot):

        def swinging() -> None:
            made.swung = swing(world, home)

        yield swinging

"""Simulate scenarios in MuJoCo: hold each pose, drive, move each joint over its range, and swing without damping.

Each scenario resets the simulation and returns measurements, which ``simulation`` compares with limits. If the
simulation diverges, the result has only ``broken``, the time and the reason.
"""

import copy
import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.model import Joint, Robot, Twist
from rosorin_compile.model.drive import Drive
from rosorin_compile.source.progress import Progress

from .mjcf.bodies import HOME, body_name, home_of, leader_of, range_of

POSITION, VELOCITY, FORCE = "position", "velocity", "force"
FIXED, FREE = "fixed", "free"
_SAMPLE = 0.005  # s between two samples, rounded to a whole number of steps
_SPEED_UP = 0.002  # s: time constant of an added wheel servo, stiff so that it adds no error to the measurements
_OVER_DAMPING = 500  # smallest ratio of the gain of an added wheel servo to the damping of its joint
_STEER = 200.0  # rad/s: undamped natural frequency of an added steering servo
_FAR = 1e6  # m: larger than any distance to the floor
_LAST = 0.25  # s: measurements are averaged over this time at the end of a scenario
_RAMP, _DRIVING = 0.5, 2.0  # s of acceleration, s at constant speed (second half: measured)
_SWING = 0.5  # s: duration of the swing
_PUSH = 0.5  # rad/s, or a tenth of it in m/s: initial speed of a swinging joint
_SWEEP_SPEED, _SLIDE_SPEED = 1.0, 0.1  # maximum rad/s and m/s; at most half the velocity limit
_TURN, _CATCH_UP = 0.1, 0.05  # rad or m: half range of a joint without limits; s: time constant of velocity control
_SHORTEST, _LONGEST, _AT_END = 0.25, 4.0, 0.4  # s: bounds for the move to an end of the range, and time at that end


@dataclass(frozen=True)
class Actuator:
    """An actuator of the compiled model; ``joint`` is "" if it does not drive a joint.

    Its force is ``gain`` * control + ``offset`` + ``stiffness`` * x, where x is the position or velocity of a servo.
    ``stiffness`` is 0 for other actuators. ``targets`` are the lowest and highest target, or () if unlimited.
    """

    number: int
    joint: str
    kind: str
    gear: float
    gain: float
    offset: float
    stiffness: float
    targets: tuple[float, ...]

    def control(self, target: float) -> float:
        """Return the control value for a target length (rad or m) or speed (rad/s or m/s) of a servo."""
        return -(self.offset + self.stiffness * target) / self.gain


class World:
    """A simulation of a robot that is fixed to the world, or free on a floor. Lengths are in m, angles in rad.

    ``joints`` are the moving joints with one coordinate. ``targets`` are the target positions of joints with a position
    servo. ``own`` are the wheel and steering joints without an actuator, for which this class added a servo. If the
    simulation diverges, ``broken`` is the time and the reason.
    """

    def __init__(
        self, mujoco: Any, robot: Robot, text: str, base: str, folder: Path, meshes: Mapping[str, bytes] | None = None
    ) -> None:
        """Compile an MJCF with paths relative to ``folder``; ``meshes`` maps names to contents. Raises ValueError."""
        self.mujoco, self.robot, self.base = mujoco, robot, base
        self.joints = [joint for joint in robot.joints if joint.moves]
        self.steps, self.cpu, self.broken, self.targets = 0, 0.0, "", dict[str, float]()
        spec: Any = mujoco.MjSpec.from_string(text, assets=dict(meshes or {}))
        spec.modelfiledir = str(folder)
        for key in list(spec.keys):
            spec.delete(key)  # the scenarios use the poses of the description
        if base == FREE:
            floor = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05])
        self.model = spec.compile()
        self.own = self._add_servos(spec, robot.drive) if base == FREE and robot.drive is not None else ()
        self.model = spec.compile() if self.own else self.model
        self.floor = floor.id if base == FREE else -1
        self.data = mujoco.MjData(self.model)
        self.link_of: dict[int, str] = {self.model.body(body_name(robot, name)).id: name for name in robot.link}
        self.actuators = self._actuators()
        self.servos = {(one.joint, one.kind): one for one in reversed(self.actuators)}  # the first servo wins
        self.chunk = max(1, round(_SAMPLE / self.model.opt.timestep))
        self.sample = self.chunk * float(self.model.opt.timestep)

    def _actuators(self) -> list[Actuator]:
        model, mujoco, actuators = self.model, self.mujoco, []
        on_joint = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
        for number in range(model.nu):
            is_on_joint = model.actuator_trntype[number] in on_joint
            joint = model.joint(int(model.actuator_trnid[number][0])).name if is_on_joint else ""
            gain, gear = float(model.actuator_gainprm[number][0]), float(model.actuator_gear[number][0])
            is_servo = gain and model.actuator_biastype[number] == int(mujoco.mjtBias.mjBIAS_AFFINE)
            offset, position, velocity = model.actuator_biasprm[number][:3].tolist() if is_servo else (0.0, 0.0, 0.0)
            kind, stiffness = POSITION if position else VELOCITY if velocity else FORCE, position or velocity
            targets = ()
            if model.actuator_ctrllimited[number] and stiffness:
                ends = model.actuator_ctrlrange[number].tolist()
                targets = tuple(sorted(-(gain * end + offset) / (stiffness * gear) for end in ends))
            actuators.append(Actuator(number, joint, kind, gear, gain, offset, stiffness, targets))
        return actuators

    def _add_servos(self, spec: Any, drive: Drive) -> tuple[str, ...]:
        mujoco, added, existing = self.mujoco, [], {(one.joint, one.kind) for one in self._actuators()}
        mass_per_wheel = float(self.model.body_mass.sum()) / len(drive.wheels)
        radius = {wheel.joint: wheel.radius for wheel in self.robot.drive_kinematics.wheels}
        for name in (*drive.wheels, *drive.steering):
            steers, joint = name in drive.steering, self.model.joint(name)
            if (name, POSITION) in existing or ((name, VELOCITY) in existing and not steers):
                continue
            if steers:
                gain = float(self.model.dof_M0[joint.dofadr[0]]) * _STEER**2
            else:
                gain = max(mass_per_wheel * radius[name] ** 2 / _SPEED_UP, _OVER_DAMPING * float(joint.damping[0]))
            servo = spec.add_actuator(target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            servo.gaintype, servo.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
            servo.gainprm[0] = gain
            servo.biasprm[:3] = [0.0, -gain, -2 * gain / _STEER] if steers else [0.0, 0.0, -gain]
            added.append(name)
        return tuple(added)

    def reset(self, positions: Mapping[str, float]) -> None:
        """Reset the simulation to joint positions (rad or m) that servos then hold; put a free robot on the floor."""
        model, data, self.broken = self.model, self.data, ""
        self.mujoco.mj_resetData(model, data)
        for joint in self.joints:
            data.joint(joint.name).qpos[0] = self.robot.position(joint, positions)
        self.mujoco.mj_forward(model, data)
        if self.base == FREE:
            types, affinities, floor = model.geom_contype, model.geom_conaffinity, self.floor
            meets = (types & affinities[floor]) | (affinities & types[floor])
            geoms = [geom for geom in range(model.ngeom) if meets[geom] and model.geom_bodyid[geom]]
            heights = [self.mujoco.mj_geomDistance(model, data, floor, geom, _FAR, None) for geom in geoms]
            data.qpos[2] -= min(heights, default=0.0)
            self.mujoco.mj_forward(model, data)
        servos = [one for one in self.actuators if one.kind == POSITION]
        for servo in servos:
            data.ctrl[servo.number] = servo.control(float(data.actuator_length[servo.number]))
        self.targets = {one.joint: self.position(one.joint) for one in servos if one.joint in self.robot.joint}

    def hold(self, joint: str, position: float) -> None:
        """Set the target (rad or m) of the position servos of a joint."""
        for one in (one for one in self.actuators if (one.joint, one.kind) == (joint, POSITION)):
            self.data.ctrl[one.number] = one.control(position * one.gear)
            self.targets[joint] = position

    def turn(self, joint: str, speed: float, seconds: float) -> None:
        """Command the speed (rad/s) of a wheel; for a position servo, advance the target by ``seconds`` of motion."""
        if servo := self.servos.get((joint, VELOCITY)):
            self.data.ctrl[servo.number] = servo.control(speed * servo.gear)
        elif joint in self.targets:
            self.hold(joint, self.targets[joint] + speed * seconds)

    def run(self, seconds: float, before: Callable[[float], None] = lambda _: None) -> Iterator[float]:
        """Simulate, and yield the time (s) after each sample until ``broken``; ``before(time)`` can set controls."""
        import numpy as np

        data, start = self.data, self.data.time
        for _ in range(round(seconds / self.sample)):
            now, problem = data.time, ""
            before(now - start)
            began = time.process_time()
            self.mujoco.mj_step(self.model, data, self.chunk)
            self.cpu += time.process_time() - began
            self.steps += self.chunk
            for number in np.flatnonzero(data.warning.number).tolist()[:1]:
                index, kind = int(data.warning.lastinfo[number]), self.mujoco.mjtWarning(number).name
                problem = f"MuJoCo warns: {self.mujoco.mju_warningText(number, index).partition('. ')[0].rstrip('.')}"
                if kind in ("mjWARN_BADQPOS", "mjWARN_INERTIA", "mjWARN_BADQVEL", "mjWARN_BADQACC"):
                    addresses = self.model.jnt_qposadr if kind == "mjWARN_BADQPOS" else self.model.jnt_dofadr
                    problem += f', joint "{self.model.joint(int(np.flatnonzero(addresses <= index)[-1])).name}"'
            if not problem and (data.time <= now or not np.isfinite(data.qpos).all()):
                problem = "its positions become infinite"
            if problem:
                self.broken = f"after {round(now, 3):.6g} s: {problem}"
                return
            yield data.time - start

    def contacts(self) -> tuple[list[tuple[str, str]], list[str]]:
        """Return (sorted pairs of links that touch each other, links that touch the floor)."""
        pairs, on_floor = set[tuple[str, str]](), set[str]()
        for contact in self.data.contact:
            bodies = self.model.geom_bodyid[contact.geom].tolist()
            first, *others = sorted({self.link_of[body] for body in bodies if body in self.link_of}) or [""]
            pairs |= {(first, other) for other in others if contact.dist < 0}
            on_floor.update((first, *others) if 0 in bodies else ())
        return sorted(pairs), [name for name in self.robot.link if name in on_floor]

    def position(self, joint: str) -> float:
        return float(self.data.joint(joint).qpos[0])

    def place(self, link: str) -> tuple[Any, Any]:
        """Return the pose of a link in the world: a rotation matrix (3, 3) and a position (3,) in metres."""
        body = self.data.body(body_name(self.robot, link))
        return body.xmat.reshape(3, 3).copy(), body.xpos.copy()


@dataclass
class Result:
    """The result of a scenario. If the simulation diverged, ``broken`` is the time and the reason."""

    broken: str = field(default="", kw_only=True)


@dataclass
class PoseTrial(Result):
    """The result of holding a pose, measured at the end."""

    pose: str
    positions: Mapping[str, float]
    errors: dict[str, float] = field(default_factory=dict)  # mean error of each joint (rad or m)
    drift: float = 0.0  # horizontal displacement of the base (m)
    turned: float = 0.0  # yaw of the base relative to the start (rad)
    leans: float = 0.0  # tilt of the base relative to the start (rad)
    ripple: float = 0.0  # peak-to-peak height of the base (m)
    touches: list[tuple[str, str]] = field(default_factory=list)  # links that touch each other
    stands_on: list[str] = field(default_factory=list)  # links that touch the floor


@dataclass
class DriveTrial(Result):
    """The result of a velocity command. ``commanded`` is scaled down if it exceeds the limits of the wheels."""

    command: str
    commanded: Twist
    measured: Twist = field(default_factory=Twist)
    off: float = 0.0  # largest relative error of a commanded velocity component
    cross: float = 0.0  # largest velocity component that was not commanded (m/s or rad/s)
    ripple: float = 0.0  # peak-to-peak height of the drive (m)


class End(NamedTuple):
    """The result at one end of a joint range. Positions and errors are in rad or m."""

    target: float
    error: float
    touches: list[tuple[str, str]]
    first_touch: tuple[str, str] | None = None  # first pair of links that touched during the motion
    touch_position: float = 0.0  # joint position at that contact


@dataclass
class RangeTrial(Result):
    """The result of moving a joint to the lower and then to the upper end of its range."""

    joint: str
    ends: list[End] = field(default_factory=list)


@dataclass
class EnergyTrial(Result):
    """The energy error of a swinging robot without damping, friction, actuators and contacts."""

    change: float = 0.0  # largest change of the total energy, relative to the largest kinetic energy
    lightest: str = ""  # joint with the smallest inertia


def run_scenarios(world: World, seconds: float) -> dict[str, Any]:
    """Run all scenarios, with each pose held for ``seconds``; return the results by field of ``Simulation``."""
    robot, poses, commands = world.robot, poses_of(world.robot), list[tuple[str, Twist]]()
    if robot.drive is not None and world.base == FREE:
        commands = [("forward", Twist(vx=0.3)), ("sideways", Twist(vy=0.3)), ("turn", Twist(wz=1.0))]
        if robot.drive_kinematics.steering:
            commands[1:] = [("curve", Twist(vx=0.3, wz=0.3))]
        elif not robot.drive_kinematics.slides:
            del commands[1]
    home = poses[0][1]
    runs: list[tuple[str, Callable[[], Result]]] = [("poses", partial(hold, world, *pose, seconds)) for pose in poses]
    runs += [("drive", partial(drive, world, home, *command)) for command in commands]
    runs += [("ranges", partial(sweep, world, home, *joint)) for joint in swept_joints(world)]
    runs += [("energy", partial(swing, world, home))] if world.joints else []
    results: dict[str, Any] = {"poses": (), "drive": (), "ranges": (), "energy": ()}
    for number, (kind, run) in enumerate(runs):
        Progress.step("simulating", number, len(runs))
        results[kind] += (run(),)
    results["energy"] = next(iter(results["energy"]), None)
    return {**results, "own_servos": world.own, "undriven": undriven_joints(world)}


def poses_of(robot: Robot) -> list[tuple[str, Mapping[str, float]]]:
    """Return (name, joint positions in rad or m) of each pose to hold, starting with "home"."""
    others = [(pose.name, pose.positions) for pose in robot.poses if pose.name != HOME]
    return [(HOME, home_of(robot).positions), *others]


def hold(world: World, pose: str, positions: Mapping[str, float], seconds: float) -> PoseTrial:
    """Hold a pose with the actuators for a time (s), and measure the errors at the end."""
    import numpy as np

    root, robot = world.robot.root, world.robot
    world.reset(positions)
    actuated = set(world.targets) - set(world.own)
    held = [joint for joint in world.joints if actuated.intersection((joint.name, leader_of(robot, joint).name))]
    targets = [robot.position(joint, positions) for joint in held]
    turn_before, place_before = world.place(root)
    samples = [[*(world.position(j.name) for j in held), world.place(root)[1][2]] for _ in world.run(seconds)]
    result = PoseTrial(pose, positions, broken=world.broken)
    if world.broken:
        return result
    last = np.array(samples[-max(1, round(_LAST / world.sample)) :])
    errors = np.abs(last[:, :-1].mean(axis=0) - targets).tolist()
    result.errors = {joint.name: error for joint, error in zip(held, errors, strict=True)}
    result.touches, result.stands_on = world.contacts()
    if world.base == FREE:
        turn, place = world.place(root)
        result.drift = math.hypot(*(place - place_before)[:2])
        result.turned = abs(math.remainder(_yaw(turn) - _yaw(turn_before), math.tau))
        result.leans = math.acos(max(-1.0, min(1.0, float(turn_before[2] @ turn[2]))))
        result.ripple = float(np.ptp(last[:, -1]))
    return result


def _yaw(turn: Any) -> float:
    return math.atan2(turn[1][0], turn[0][0])


def drive(world: World, positions: Mapping[str, float], command: str, twist: Twist) -> DriveTrial:
    """Drive with a velocity command from a pose: accelerate for 0.5 s, settle for 1 s, then measure for 1 s."""
    import numpy as np

    driving, scale = world.robot.drive_kinematics, 1.0
    for name, speed in driving.speeds(twist).items():  # scale the command down to the wheel limits
        servo, limit = world.servos.get((name, VELOCITY)), world.robot.joint[name].limit
        ends = [*map(abs, servo.targets if servo else ()), limit.known_value("velocity") if limit else None]
        fastest = min(filter(None, ends), default=math.inf)
        scale = min(scale, 0.9 * fastest / abs(speed)) if abs(speed) > fastest else scale
    twist = Twist(*(scale * part for part in twist))
    angles = driving.angles(twist)
    speeds, centre = driving.speeds(twist, angles), (*driving.centre, 0.0)
    world.reset({**positions, **angles})

    def state(time: float) -> tuple[float, ...]:
        turn, place = world.place(driving.frame)
        return (time, *(place + turn @ centre), _yaw(turn))

    def command_wheels(now: float) -> None:
        for name, speed in speeds.items():
            world.turn(name, speed * min(1.0, now / _RAMP), world.sample)
        for name, angle in angles.items():
            world.hold(name, angle)

    states = [state(0.0), *map(state, world.run(_RAMP + _DRIVING, command_wheels))]
    result = DriveTrial(command, twist, broken=world.broken)
    if world.broken:
        return result
    last = np.array(states[-max(1, round(_DRIVING / 2 / world.sample)) - 1 :])
    seconds, x, y, _, turned = np.diff(last, axis=0).T
    turned = np.mod(turned + math.pi, math.tau) - math.pi
    cosine, sine = np.cos(last[:-1, 4] + turned / 2), np.sin(last[:-1, 4] + turned / 2)
    velocities = (cosine * x + sine * y, cosine * y - sine * x, turned)
    result.measured = Twist(*(float((part / seconds).mean()) for part in velocities))
    parts = list(zip(result.measured, twist, strict=True))
    result.off = max(abs(part - aim) / abs(aim) for part, aim in parts if aim)
    result.cross = max((abs(part) for part, aim in parts if not aim), default=0.0)
    result.ripple = float(np.ptp(last[1:, 3]))
    return result


def swept_joints(world: World) -> list[tuple[Joint, tuple[float, float]]]:
    """Return (joint, range to test in rad or m) for each joint with a servo, except wheels."""
    found, wheels = [], {*world.own, *(world.robot.drive.wheels if world.robot.drive is not None else ())}
    home = home_of(world.robot).positions
    for joint in (joint for joint in world.joints if joint.name not in wheels):
        servo, ends = world.servos.get((joint.name, POSITION)), range_of(joint)
        if servo and ends and joint.limit and joint.type != "continuous":
            low, high = max((ends[0], *servo.targets[:1])), min((ends[1], *servo.targets[1:]))
            found += [(joint, (low, high))] if low < high else []
        elif joint.mimic is None and (servo or (joint.name, VELOCITY) in world.servos):
            middle = world.robot.position(joint, home)
            found.append((joint, (middle - _TURN, middle + _TURN)))
    return found


def undriven_joints(world: World) -> tuple[str, ...]:
    """Return joints without an actuator, except casters and rollers; () if an actuator may move unknown joints."""
    drive, driven = world.robot.drive, {one.joint for one in world.actuators}
    driven |= {name for names in drive.joints.values() for name in names} | {*drive.steering} if drive else set()
    idle = [joint for joint in world.joints if joint.mimic is None and not (drive and joint.type == "continuous")]
    return () if "" in driven else tuple(joint.name for joint in idle if joint.name not in driven)


def sweep(world: World, positions: Mapping[str, float], joint: Joint, ends: tuple[float, float]) -> RangeTrial:
    """Move a joint from a pose to the lower end of its range, and from there to the upper end."""
    velocity = joint.limit.known_value("velocity") if joint.limit else None
    speed = min(_SLIDE_SPEED if joint.type == "prismatic" else _SWEEP_SPEED, velocity / 2 if velocity else math.inf)
    world.reset(positions)
    result, at_start, start = RangeTrial(joint.name), set(world.contacts()[0]), world.position(joint.name)
    for end in ends:
        seconds = min(_LONGEST, max(_SHORTEST, abs(end - start) / speed))

        def move(now: float, start: float = start, end: float = end, seconds: float = seconds) -> None:
            target = start + (end - start) * min(1.0, now / seconds)
            if (joint.name, POSITION) in world.servos:
                world.hold(joint.name, target)
            else:
                world.turn(joint.name, (target - world.position(joint.name)) / _CATCH_UP, world.sample)

        first: tuple[tuple[str, str] | None, float] = (None, 0.0)
        errors, before = list[float](), at_start | set(world.contacts()[0])
        for _ in world.run(seconds + _AT_END, move):
            now, touches = world.position(joint.name), world.contacts()[0]
            errors.append(abs(now - end))
            fresh = [pair for pair in touches if pair not in before]
            first = (fresh[0], now) if fresh and first[0] is None else first
        if world.broken:
            result.broken = world.broken
            break
        last, left = errors[-max(1, round(_LAST / world.sample / 2)) :], [p for p in touches if p not in at_start]
        result.ends.append(End(end, sum(last) / len(last), left, *first))
        start = end
    return result


def swing(world: World, positions: Mapping[str, float]) -> EnergyTrial:
    """Let the robot swing without energy input or loss, and measure the energy error of the simulation."""
    mujoco, free, joints = world.mujoco, copy.copy(world), world.joints
    free.model = model = copy.copy(world.model)
    for name in ("CONTACT", "EQUALITY", "LIMIT", "FRICTIONLOSS", "ACTUATION", "DAMPER"):
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"))
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    model.opt.integrator = int(mujoco.mjtIntegrator.mjINT_RK4)
    model.opt.density = model.opt.viscosity = 0.0
    if world.base == FREE:
        model.opt.gravity[:] = 0.0  # the energy of a fall would hide the error
    free.data = mujoco.MjData(model)
    free.reset(positions)
    for index, joint in enumerate(joints):
        speed = _PUSH * (0.1 if joint.type == "prismatic" else 1.0)
        free.data.joint(joint.name).qvel[0] = -speed if index % 2 else speed
    mujoco.mj_forward(model, free.data)
    inertia = {joint.name: float(model.dof_M0[model.joint(joint.name).dofadr[0]]) for joint in joints}
    result, at_start, most = EnergyTrial(lightest=min(inertia, key=inertia.__getitem__)), free.data.energy.sum(), 0.0
    for _ in free.run(_SWING):
        change = abs(float(free.data.energy.sum() - at_start))
        most, result.change = max(most, float(free.data.energy[1])), max(result.change, change)
    result.broken, result.change = free.broken, result.change / most if most else 0.0
    return result

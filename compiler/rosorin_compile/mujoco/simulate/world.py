"""The robot in MuJoCo: held or on a floor, with targets for its actuators, and every step checked."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from rosorin_compile.source.diagnostics import Diagnostic

from ..mjcf.bodies import body_name

POSITION, VELOCITY, FORCE = "position", "velocity", "force"
FIXED, FREE = "fixed", "free"
_SAMPLE = 0.005  # s between two samples, rounded to a whole number of steps
_SPEED_UP = 0.002  # s in which our servo brings the robot to speed: stiff, so that errors are those of the robot
_OVER_DAMPING = 500  # how much stiffer than the damping of its joint such a servo is at least
_STEER = 200.0  # rad/s: the frequency of our steering servo with the inertia at its joint, without damping
_FAR = 1e6  # m: beyond any distance to the floor


@dataclass(frozen=True)
class Actuator:
    """An actuator of the model and the joint that it drives (empty: something else).

    Its force is ``gain`` * control + bias (MuJoCo): it is a servo for the position or velocity that the bias depends on
    with ``stiffness``. ``targets`` are the lowest and the highest target for the joint, or None if any is possible.
    """

    number: int
    joint: str
    kind: str
    gear: float
    gain: float
    offset: float
    stiffness: float
    targets: tuple[float, float] | None

    def control(self, target: float) -> float:
        """Return the control that makes a length (rad or m) or speed the target of the servo."""
        return -(self.offset + self.stiffness * target) / self.gain


@contextmanager
def quiet() -> Iterator[Any]:
    """Import MuJoCo and drop its warnings meanwhile, which it would also write to a file in the working folder."""
    mujoco: Any = import_module("mujoco")
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield mujoco
    finally:
        mujoco.set_mju_user_warning(None)


def mjcf_text(robot: Robot, output: Output | None, templates: Templates, base: str) -> tuple[str, list[Diagnostic]]:
    """Return the MJCF of a robot with the options of an output, and the diagnostics of the format."""
    options = {**(output.options if output else {}), "base": base}
    return FORMATS["mjcf"].written(robot, Output("simulated", "mjcf", "simulated.xml", options), templates)


class World:
    """A robot in MuJoCo, fixed to the world or free on a floor. Lengths in m, angles in rad.

    ``joints`` are those that move and have a single coordinate, ``own`` those of the drive that got a servo here,
    because no actuator of the robot drives them, ``targets`` the positions of the joints that are held. ``broken`` is
    when and why the simulation diverged, or empty.
    """

    def __init__(
        self, mujoco: Any, robot: Robot, text: str, base: str, folder: Path, meshes: Mapping[str, bytes] | None = None
    ) -> None:
        """Compile the MJCF in ``text``; ``folder`` is that of its file, ``meshes`` the contents of files by name.

        Raises ValueError with the reason of MuJoCo.
        """
        self.mujoco, self.robot, self.base = mujoco, robot, base
        self.joints = [joint for joint in robot.joints if joint.moves]
        self.steps, self.cpu, self.broken, self.targets = 0, 0.0, "", dict[str, float]()
        spec: Any = mujoco.MjSpec.from_string(text, assets=dict(meshes or {}))
        spec.modelfiledir = str(folder)
        for key in list(spec.keys):
            spec.delete(key)  # states come from the poses of the description
        if base == FREE:
            floor = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05])
        self.model = spec.compile()
        self.own = self._add_servos(spec) if base == FREE and robot.drive is not None else ()
        self.model = spec.compile() if self.own else self.model
        self.floor = floor.id if base == FREE else -1
        self.data = mujoco.MjData(self.model)
        numbers = {mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, body_name(robot, n)): n for n in robot.link}
        self.link_of: dict[int, str] = {number: name for number, name in numbers.items() if number >= 0}
        self.actuators = self._actuators()
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
            targets = None
            if model.actuator_ctrllimited[number] and stiffness:
                ends = model.actuator_ctrlrange[number].tolist()
                low, high = sorted(-(gain * end + offset) / (stiffness * gear) for end in ends)
                targets = (low, high)
            actuators.append(Actuator(number, joint, kind, gear, gain, offset, stiffness, targets))
        return actuators

    def _add_servos(self, spec: Any) -> tuple[str, ...]:
        """Add a servo for each joint of the drive that has none; return the joints."""
        drive, mujoco, added = self.robot.drive, self.mujoco, []
        existing = {(one.joint, one.kind) for one in self._actuators()}
        mass_per_wheel = float(self.model.body_mass.sum()) / len(drive.wheels)
        radius = {wheel.joint: wheel.radius for wheel in self.robot.driving.wheels}
        for name in (*drive.wheels, *drive.steering):
            steers, joint = name in drive.steering, self.model.joint(name)
            if (name, POSITION) in existing or ((name, VELOCITY) in existing and not steers):
                continue
            if steers:
                gain = float(self.model.dof_M0[joint.dofadr[0]]) * _STEER**2
                bias = [0.0, -gain, -2 * gain / _STEER]
            else:
                gain = max(mass_per_wheel * radius[name] ** 2 / _SPEED_UP, _OVER_DAMPING * float(joint.damping[0]))
                bias = [0.0, 0.0, -gain]
            servo = spec.add_actuator(target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            servo.gaintype, servo.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
            servo.gainprm[0], servo.biasprm[:3] = gain, bias
            added.append(name)
        return tuple(added)

    def reset(self, positions: Mapping[str, float]) -> None:
        """Start again at joint positions, everything at rest and held there; on the floor if there is one."""
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

    def servo(self, joint: str, kind: str) -> Actuator | None:
        """Return the first actuator of a kind on a joint."""
        return next((one for one in self.actuators if (one.joint, one.kind) == (joint, kind)), None)

    def hold(self, joint: str, position: float) -> None:
        """Set the target of the position servos of a joint."""
        for one in self.actuators:
            if (one.joint, one.kind) == (joint, POSITION):
                self.data.ctrl[one.number] = one.control(position * one.gear)
                self.targets[joint] = position

    def turn(self, joint: str, speed: float, seconds: float) -> None:
        """Set the speed (rad/s) of a wheel for some seconds: a position servo is moved on."""
        servo = self.servo(joint, VELOCITY)
        if servo is not None:
            self.data.ctrl[servo.number] = servo.control(speed * servo.gear)
        elif joint in self.targets:
            self.hold(joint, self.targets[joint] + speed * seconds)

    def run(self, seconds: float, before: Callable[[float], None] = lambda _: None) -> Iterator[float]:
        """Simulate and yield the time (s) since the start after every ``sample``; ``before`` is called before each.

        It ends with a reason in ``broken`` if positions become infinite, or MuJoCo warns.
        """
        start = self.data.time
        for _ in range(round(seconds / self.sample)):
            now = self.data.time
            before(now - start)
            began = time.process_time()
            self.mujoco.mj_step(self.model, self.data, self.chunk)
            self.cpu += time.process_time() - began
            self.steps += self.chunk
            if problem := self._problem(now):
                self.broken = f"after {round(now, 3):.6g} s: {problem}"
                return
            yield self.data.time - start

    def _problem(self, before: float) -> str:
        """Return the warning of MuJoCo, or that it reset the state, since the time ``before``."""
        import numpy as np

        for number in np.flatnonzero(self.data.warning.number).tolist():
            index, kind = int(self.data.warning.lastinfo[number]), self.mujoco.mjtWarning(number).name
            text = self.mujoco.mju_warningText(number, index).partition(". ")[0].rstrip(".")
            if kind in ("mjWARN_BADQPOS", "mjWARN_INERTIA", "mjWARN_BADQVEL", "mjWARN_BADQACC"):
                addresses = self.model.jnt_qposadr if kind == "mjWARN_BADQPOS" else self.model.jnt_dofadr
                text += f', joint "{self.model.joint(int(np.flatnonzero(addresses <= index)[-1])).name}"'
            return f"MuJoCo warns: {text}"
        is_reset = self.data.time <= before or not np.isfinite(self.data.qpos).all()
        return "its positions become infinite" if is_reset else ""

    def contacts(self) -> tuple[list[tuple[str, str]], list[str]]:
        """Return the pairs of links that touch each other, sorted, and the links that touch the floor."""
        pairs, on_floor = set[tuple[str, str]](), set[str]()
        for contact in self.data.contact:
            bodies = self.model.geom_bodyid[contact.geom].tolist()
            links = sorted({self.link_of[body] for body in bodies if body in self.link_of})
            if len(links) > 1 and contact.dist < 0:
                pairs.add((links[0], links[1]))
            on_floor.update(links if 0 in bodies else ())
        return sorted(pairs), [name for name in self.robot.link if name in on_floor]

    def position(self, joint: str) -> float:
        """Return the position of a joint (rad or m)."""
        return float(self.data.joint(joint).qpos[0])

    def place(self, link: str) -> tuple[Any, Any]:
        """Return the pose of a link in the world: a rotation (3, 3), and a place (3,) in metres."""
        body = self.data.body(body_name(self.robot, link))
        return body.xmat.reshape(3, 3).copy(), body.xpos.copy()

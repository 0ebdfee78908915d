"""The robot in MuJoCo: compiled in memory, held or on a floor, its actuators told what to reach, every step watched."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Drive, Joint, Link, Mesh, Output, Robot
from rosorin_compile.source.diagnostics import Diagnostic, has_errors

from ..mjcf.bodies import body_name
from ..mjcf.engine import reason

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SAMPLE = 0.005  # s between two looks at the robot, about: a whole number of steps
POSITION, VELOCITY, FORCE = "position", "velocity", "force"
FIXED, FREE = "fixed", "free"
_SPEED_UP = 0.002  # s in which a servo of ours brings the robot to speed: stiff, so that what is off is the robot's
_OVER_DAMPING = 500  # how much stiffer than the damping of its joint such a servo is at least
_IN_THE_AIR = 5e-4  # m; a wheel that is pressed into the floor, or rolls on, is nearer
_STEER = 200.0  # rad/s: how fast a steering servo of ours would swing with the inertia at its joint, were it not damped


class Refused(Exception):
    """The robot has no model in MuJoCo; the message says why. ``diagnostics`` are what its format says of it."""

    def __init__(self, message: str, diagnostics: Sequence[Diagnostic] = ()) -> None:
        super().__init__(message)
        self.diagnostics = tuple(diagnostics)


class Broken(Exception):
    """The simulation diverged: the message says how, ``time`` (s) when, ``joint`` where first, if that is known."""

    def __init__(self, message: str, time: float, joint: str = "") -> None:
        super().__init__(message)
        self.time = time
        self.joint = joint


class Actuator(NamedTuple):
    """An actuator of the model: its number, the joint that it is on (empty: another thing), and what it is told."""

    number: int
    joint: str
    kind: str


class Touch(NamedTuple):
    """Two links that touch, by name, and how deep (m)."""

    links: tuple[str, str]
    depth: float


@contextmanager
def quiet() -> Iterator[Any]:
    """Give MuJoCo, whose warnings go nowhere meanwhile: not into a file in the working folder either."""
    mujoco: Any = import_module("mujoco")
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield mujoco
    finally:
        mujoco.set_mju_user_warning(None)


def simulated(robot: Robot, output: Output | None, templates: Templates, base: str) -> str:
    """Return the text of a robot in the format of MuJoCo, with the options of an output. Raises Refused."""
    format = next((one for one in FORMATS.values() if one.proving.refusal is not None and one.write is not None), None)
    if format is None:
        raise Refused("no format for MuJoCo is installed")
    options = {**(output.options if output else {}), "base": base}
    text, said = format.written(robot, Output("simulated", format.name, "simulated.xml", options), templates)
    if has_errors(said):
        raise Refused("it cannot be written for MuJoCo", said)
    return text


def without_meshes(robot: Robot) -> Robot:
    """Return a robot whose links have no meshes, and nothing that is seen alone."""

    def bare(link: Link) -> Link:
        solid = tuple(shape for shape in link.collision if not isinstance(shape.geometry, Mesh))
        return replace(link, collision=solid, visual=())

    return replace(robot, links=tuple(map(bare, robot.links)))


def set_joints(robot: Robot, data: Any, positions: Mapping[str, float]) -> None:
    """Put the joints of a robot where positions (rad or m) say, followers with them."""
    for joint in moving(robot):
        data.joint(joint.name).qpos[0] = robot.position(joint, positions)


def moving(robot: Robot) -> list[Joint]:
    """Return the joints that move and have a single coordinate: no planar, floating or fixed ones."""
    return [joint for joint in robot.joints if joint.moves]


def _delete(spec: Any, element: Any) -> None:
    if hasattr(spec, "delete"):
        spec.delete(element)
    else:  # MuJoCo 3.3.0
        element.delete()


class World:
    """A robot in MuJoCo. ``base``: it is held in the world (FIXED), or stands on a floor (FREE).

    ``own`` are the joints that got a servo of ours, for the robot has none that drives it. Raises Refused.
    """

    def __init__(
        self, mujoco: Any, robot: Robot, text: str, base: str, folder: Path, meshes: Mapping[str, bytes] | None = None
    ) -> None:
        self.mujoco, self.robot, self.base = mujoco, robot, base
        self.steps, self.cpu = 0, 0.0
        try:
            spec = mujoco.MjSpec.from_string(text, assets=dict(meshes or {}))
            spec.modelfiledir = str(folder)
            for key in list(spec.keys):
                _delete(spec, key)  # states come from the poses of the description
            if base == FREE:
                self._lay_floor(spec)
            self.model = spec.compile()
            self.own = self._drive(spec)
            if self.own:
                self.model = spec.compile()
        except ValueError as problem:
            raise Refused(reason(mujoco, problem)[0] or "MuJoCo does not say why") from None
        self.data = mujoco.MjData(self.model)
        self.link_of = self._links()
        self.actuators = self._actuators()
        self.chunk = max(1, round(SAMPLE / self.model.opt.timestep))
        self.sample = self.chunk * float(self.model.opt.timestep)
        self.aims: dict[str, float] = {}

    def _lay_floor(self, spec: Any) -> None:
        names = {geom.name for geom in spec.geoms}
        name = "floor"
        while name in names:
            name += "_"
        spec.worldbody.add_geom(name=name, type=self.mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05])

    def _links(self) -> dict[int, str]:
        """Return the links by the number of their body."""
        body = self.mujoco.mjtObj.mjOBJ_BODY
        found = {self.mujoco.mj_name2id(self.model, body, self._body_name(n)): n for n in self.robot.link}
        return {index: name for index, name in found.items() if index >= 0}

    def _body_name(self, link: str) -> str:
        """Return what the MJCF calls a link."""
        name: str = body_name(self.robot, link)
        return name

    def _actuators(self) -> list[Actuator]:
        """Return the actuators, each with what its gain and bias make of it (MuJoCo: gain * ctrl + bias)."""
        model, mujoco = self.model, self.mujoco
        joints = [int(kind) for kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)]
        affine = int(mujoco.mjtBias.mjBIAS_AFFINE)
        made = []
        for index in range(model.nu):
            on_joint = int(model.actuator_trntype[index]) in joints
            joint = model.joint(int(model.actuator_trnid[index][0])).name if on_joint else ""
            kind = FORCE
            if int(model.actuator_biastype[index]) == affine and model.actuator_gainprm[index][0]:
                of_position, of_velocity = model.actuator_biasprm[index][1:3]
                kind = POSITION if of_position else VELOCITY if of_velocity else FORCE
            made.append(Actuator(index, joint, kind))
        return made

    def _drive(self, spec: Any) -> tuple[str, ...]:
        """Give a servo to each joint of the drive that has none; return them."""
        drive: Drive | None = self.robot.drive
        made = []
        if drive is None or self.base != FREE:
            return ()
        known = self._actuators()
        mass = float(self.model.body_mass.sum())
        for name in (*drive.wheels, *drive.steering):
            steers = name in drive.steering
            if any(one.joint == name and one.kind in (POSITION, *(() if steers else (VELOCITY,))) for one in known):
                continue
            if steers:
                inertia = float(self.model.dof_M0[self.model.joint(name).dofadr[0]])
                gain = inertia * _STEER**2
                bias = [0.0, -gain, -2 * inertia * _STEER]
            else:
                gain = self._speed_gain(name, mass / len(drive.wheels))
                bias = [0.0, 0.0, -gain]
            self._add_servo(spec, name, gain, bias)
            made.append(name)
        return tuple(made)

    def _speed_gain(self, name: str, mass: float) -> float:
        """Return a gain (N*m*s/rad) that brings a wheel with a share of the robot's mass to speed in a moment."""
        radius = next(wheel.radius for wheel in self.robot.driving.wheels if wheel.joint == name)
        damping = float(self.model.joint(name).damping[0])
        return max(mass * radius**2 / _SPEED_UP, _OVER_DAMPING * damping)

    def _add_servo(self, spec: Any, name: str, gain: float, bias: list[float]) -> None:
        mujoco = self.mujoco
        servo = spec.add_actuator(
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        )
        servo.gainprm[0] = gain
        servo.biasprm[:3] = bias

    def reset(self, positions: Mapping[str, float]) -> None:
        """Begin anew at joint positions (rad or m), everything at rest; on the floor, where there is one."""
        self.mujoco.mj_resetData(self.model, self.data)
        set_joints(self.robot, self.data, positions)
        self.mujoco.mj_forward(self.model, self.data)
        if self.base == FREE:
            self.data.qpos[2] -= self._lowest()
            self.mujoco.mj_forward(self.model, self.data)
        for one in self.actuators:
            if one.kind == POSITION:
                self.aim(one, float(self.data.actuator_length[one.number]))
        self.aims = {one.joint: float(self.data.joint(one.joint).qpos[0]) for one in self.holding()}

    def holding(self) -> list[Actuator]:
        """Return the actuators that hold a joint of the robot where they are told."""
        return [one for one in self.actuators if one.kind == POSITION and one.joint in self.robot.joint]

    def of(self, joint: str, kind: str) -> Actuator | None:
        """Return the actuator of a kind on a joint."""
        return next((one for one in self.actuators if (one.joint, one.kind) == (joint, kind)), None)

    def aim(self, one: Actuator, value: float) -> None:
        """Tell an actuator the length (rad or m, times its gear) or the speed that it is to reach."""
        model = self.model
        of = {POSITION: 1, VELOCITY: 2}[one.kind]
        bias = model.actuator_biasprm[one.number]
        self.data.ctrl[one.number] = -(bias[0] + bias[of] * value) / model.actuator_gainprm[one.number][0]

    def hold(self, joint: str, position: float) -> None:
        """Tell the actuators of a joint a position (rad or m)."""
        for one in self.holding():
            if one.joint == joint:
                self.aim(one, position * float(self.model.actuator_gear[one.number][0]))
                self.aims[joint] = position

    def turn(self, joint: str, speed: float, seconds: float) -> None:
        """Tell the actuators of a wheel a speed (rad/s) for some seconds: one that holds is led on."""
        for one in self.actuators:
            if one.joint == joint and one.kind == VELOCITY:
                self.aim(one, speed * float(self.model.actuator_gear[one.number][0]))
                return
        if joint in self.aims:
            self.hold(joint, self.aims[joint] + speed * seconds)

    def highest_speed(self, joint: str) -> float | None:
        """Return the speed (rad/s) that the actuator of a wheel can be asked for; None is any."""
        one = self.of(joint, VELOCITY)
        if one is None or not self.model.actuator_ctrllimited[one.number]:
            return None
        gain, bias = self.model.actuator_gainprm[one.number][0], self.model.actuator_biasprm[one.number][2]
        gear = float(self.model.actuator_gear[one.number][0])
        return float(min(abs(self.model.actuator_ctrlrange[one.number])) * abs(gain / (bias * gear)))

    def reach(self, joint: str) -> tuple[float, float] | None:
        """Return the positions (rad or m) that the actuator of a joint can be asked for; None is any."""
        one = self.of(joint, POSITION)
        if one is None or not self.model.actuator_ctrllimited[one.number]:
            return None
        bias, gear = self.model.actuator_biasprm[one.number], float(self.model.actuator_gear[one.number][0])
        gain = self.model.actuator_gainprm[one.number][0]
        ends = [-(gain * end + bias[0]) / (bias[1] * gear) for end in self.model.actuator_ctrlrange[one.number]]
        return float(min(ends)), float(max(ends))

    def run(self, seconds: float, before: Callable[[float], None] | None = None) -> Iterator[float]:
        """Let time go on; yield it (s, from the start) after every ``sample``; ``before`` is told it before each.

        Raises Broken where the numbers end, or MuJoCo warns of that.
        """
        model, data, step = self.model, self.data, self.mujoco.mj_step
        start = data.time
        for _ in range(round(seconds / self.sample)):
            now = data.time
            if before is not None:
                before(now - start)
            began = time.process_time()
            step(model, data, self.chunk)
            self.cpu += time.process_time() - began
            self.steps += self.chunk
            self._watch(now)
            yield data.time - start

    def _watch(self, before: float) -> None:
        """Raise Broken where a step has left the numbers: MuJoCo begins anew there."""
        import numpy as np

        said = self.data.warning.number
        found = next((index for index in range(len(said)) if said[index]), None)
        if found is not None:
            name = self.mujoco.mjtWarning(found).name
            joint = joint_of(self.model, name, int(self.data.warning.lastinfo[found]))
            raise Broken(f"MuJoCo warns: {_WARNINGS.get(name, name)}", before, joint)
        if self.data.time <= before or not np.isfinite(self.data.qpos).all():
            raise Broken("the robot leaves the numbers", before)

    def position(self, joint: str) -> float:
        """Return the position of a joint (rad or m)."""
        return float(self.data.joint(joint).qpos[0])

    def touches(self) -> list[Touch]:
        """Return the links that touch each other, each pair once with the deepest place."""
        found: dict[tuple[str, str], float] = {}
        for contact in self.data.contact:
            pair = self._pair(contact)
            if pair is not None and contact.dist < 0:
                found[pair] = max(found.get(pair, 0.0), -float(contact.dist))
        return [Touch(pair, depth) for pair, depth in sorted(found.items())]

    def _pair(self, contact: Any) -> tuple[str, str] | None:
        bodies = [int(self.model.geom_bodyid[geom]) for geom in (contact.geom1, contact.geom2) if geom >= 0]
        names = sorted(self.link_of[body] for body in bodies if body in self.link_of)
        return (names[0], names[1]) if len(names) == 2 and names[0] != names[1] else None

    def stands_on(self) -> list[str]:
        """Return the links that touch the floor."""
        found = set()
        for contact in self.data.contact:
            bodies = [int(self.model.geom_bodyid[geom]) for geom in (contact.geom1, contact.geom2) if geom >= 0]
            if 0 in bodies:
                found |= {self.link_of[body] for body in bodies if body in self.link_of}
        return [name for name in self.robot.link if name in found]

    def place(self, link: str) -> tuple[Floats, Floats]:
        """Return where a link is in the world: a rotation (3, 3), and its place (3,) in metres."""
        body = self.data.body(self._body_name(link))
        return body.xmat.reshape(3, 3).copy(), body.xpos.copy()

    def above_floor(self) -> dict[str, float]:
        """Return the wheels of the drive that do not touch the floor, by joint, and how far they are above it (m)."""
        drive: Drive | None = self.robot.drive
        joints = drive.wheels if drive is not None and self.base == FREE else ()
        down = {name: set(self.robot.below(self.robot.joint[name].child)) for name in joints}
        high = {
            name: self._lowest({body for body, link in self.link_of.items() if link in of}) for name, of in down.items()
        }
        return {name: height for name, height in high.items() if height > _IN_THE_AIR}

    def _lowest(self, bodies: Collection[int] | None = None) -> float:
        """Return the height (m) of the lowest point of what can touch the floor: of some bodies, or of all."""
        import numpy as np

        model, data, kinds = self.model, self.data, self.mujoco.mjtGeom
        floor = next(index for index in range(model.ngeom) if int(model.geom_type[index]) == int(kinds.mjGEOM_PLANE))
        lowest = np.inf
        for index in range(model.ngeom):
            meets = (model.geom_contype[index] & model.geom_conaffinity[floor]) | (
                model.geom_conaffinity[index] & model.geom_contype[floor]
            )
            body = int(model.geom_bodyid[index])
            if not meets or body == 0 or (bodies is not None and body not in bodies):
                continue
            down, size = data.geom_xmat[index].reshape(3, 3)[2], model.geom_size[index]
            lowest = min(lowest, data.geom_xpos[index][2] - _reach(model, kinds, index, down, size))
        return 0.0 if np.isinf(lowest) else float(lowest)


def joint_of(model: Any, warning: str, number: int) -> str:
    """Return the joint that MuJoCo warns of, by the number of its position or of its degree of freedom; "" for none."""
    if warning not in _OF_A_JOINT or not 0 <= number < (model.nq if warning == "mjWARN_BADQPOS" else model.nv):
        return ""
    places = model.jnt_qposadr if warning == "mjWARN_BADQPOS" else model.jnt_dofadr
    found = max(index for index in range(model.njnt) if places[index] <= number)
    return str(model.joint(found).name)


_OF_A_JOINT = ("mjWARN_INERTIA", "mjWARN_BADQPOS", "mjWARN_BADQVEL", "mjWARN_BADQACC")

# MuJoCo's own names of what it warns of, in words.
_WARNINGS = {
    "mjWARN_INERTIA": "an inertia matrix is singular",
    "mjWARN_CONTACTFULL": "there are more contacts than it has room for",
    "mjWARN_CNSTRFULL": "there are more constraints than it has room for",
    "mjWARN_BADQPOS": "a position is NaN, infinite or huge",
    "mjWARN_BADQVEL": "a speed is NaN, infinite or huge",
    "mjWARN_BADQACC": "an acceleration is NaN, infinite or huge",
    "mjWARN_BADCTRL": "a control is NaN, infinite or huge",
}


def _reach(model: Any, kinds: Any, index: int, down: Any, size: Any) -> float:
    """Return how far a geom reaches down from its middle (m); ``down`` is the vertical in its frame."""
    import numpy as np

    kind = kinds(int(model.geom_type[index]))
    if kind == kinds.mjGEOM_SPHERE:
        return float(size[0])
    if kind == kinds.mjGEOM_CAPSULE:
        return float(size[0] + abs(down[2]) * size[1])
    if kind == kinds.mjGEOM_CYLINDER:
        return float(size[0] * np.hypot(down[0], down[1]) + abs(down[2]) * size[1])
    if kind == kinds.mjGEOM_ELLIPSOID:
        return float(np.linalg.norm(down * size))
    if kind == kinds.mjGEOM_MESH:
        mesh = model.geom_dataid[index]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        return float(-(model.mesh_vert[first : first + count] @ down).min())
    centre, half = model.geom_aabb[index][:3], model.geom_aabb[index][3:]
    return float(np.abs(down) @ half - down @ centre)

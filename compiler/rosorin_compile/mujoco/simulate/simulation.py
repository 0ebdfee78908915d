"""Run all scenarios of one robot in MuJoCo and compare their results with limits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, NamedTuple

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Joint
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import settled
from rosorin_compile.source.diagnostics import (
    NOTE,
    WARNING,
    Diagnostic,
    MissingPackages,
    RequestError,
    did_you_mean,
    error,
    first_of,
    has_errors,
    listed,
)
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import DECLARED, SIMULATION, Rule
from rosorin_compile.source.system import is_installed, pip_install
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.tree import exists

from ..rest_pose import leader_of
from .scenarios import Driven, End, PoseTrial, Swept, Swung, run_scenarios
from .world import FIXED, FREE, Refused, World, mjcf_text, quiet

RULES = (
    Rule(
        "simulation-refused",
        "The robot cannot be simulated: MuJoCo does not load it, or its MJCF cannot be written.",
        "Look at what `check` reports.",
        SIMULATION,
    ),
    Rule(
        "simulation-breaks",
        "The positions of the robot become infinite, or MuJoCo warns of values beyond what it can compute.",
        "Look for parts that start inside each other, for masses and inertias far too small, for gains far too large.",
        SIMULATION,
    ),
    Rule(
        "pose-not-held",
        "A warning: a joint comes to rest away from a named pose. A note where the robot touches itself there.",
        "Correct the pose, raise `kp` of the actuator or its effort, or lower the mass that it carries.",
        SIMULATION,
    ),
    Rule(
        "base-drifts",
        "A warning: on a floor, the robot falls over, does not stay in its place, or its height does not come to rest.",
        "Give its wheels actuators or damping; look for shapes that start inside each other.",
        SIMULATION,
    ),
    Rule(
        "drive-not-followed",
        "A warning: driven on a floor, the robot moves at another velocity than was commanded, or shakes.",
        "Check radius, places and axes of the wheels, `kv` against damping, and what else touches the floor.",
        SIMULATION,
    ),
    Rule(
        "drive-without-actuator",
        "A note: a joint of the drive has no actuator; a servo of `simulate` turned it.",
        "Give the joint an actuator: on speed where it rolls, on position where it steers.",
        SIMULATION,
    ),
    Rule(
        "limit-not-reached",
        "A warning: an actuator does not bring its joint to a limit. A note where the robot touches itself there.",
        "Narrow the limits, or check effort, `kp` and the mass that the joint carries.",
        SIMULATION,
    ),
    Rule(
        "energy-not-kept",
        "A warning: the energy of the robot changes without damping, friction, actuators and contacts.",
        "The time step is too long for its lightest parts: a shorter `timestep`, more mass, or `armature`.",
        SIMULATION,
    ),
)
DECLARED.update({rule.id: rule for rule in RULES})

SECONDS = (0.5, 600.0)  # the shortest and the longest time to hold a pose
TIPPED = 0.2  # rad
_SHOWN = 3  # names
_LEAST = 5e-3  # m/s or rad/s: less is not reported


class Limit(NamedTuple):
    """A limit: its number, its unit, and what it is of."""

    value: float
    unit: str
    about: str


LIMITS: dict[str, Limit] = {
    "hold": Limit(0.01, "rad or m", "error of a joint in a pose"),
    "reach": Limit(0.02, "rad or m", "error of a joint at the end of its range"),
    "drift": Limit(0.005, "m", "distance of the base over the floor in a pose"),
    "drive": Limit(0.06, "", "error of a velocity, as a share of the command"),
    "cross": Limit(0.02, "m/s or rad/s", "velocity that was not commanded"),
    "ripple": Limit(0.001, "m", "change of the height while it drives or stands"),
    "energy": Limit(0.01, "", "change of the energy, as a share of the largest kinetic one"),
}


@dataclass(frozen=True)
class Timing:
    """The speed of a simulation."""

    steps_per_cpu_second: float
    times_real_time: float


@dataclass(frozen=True)
class Simulated:
    """The behaviour of a robot in MuJoCo. Lengths are in m, angles in rad, velocities in m/s and rad/s.

    Without ``poses`` the robot could not be simulated, and ``diagnostics`` has the reason. ``inputs`` are the files
    that the robot was read from.
    """

    robot: Annotated[str, "the name of the robot"]
    mujoco: Annotated[str, "the version of MuJoCo"] = ""
    base: Annotated[str, "fixed to the world, or free on a floor"] = ""
    timestep: Annotated[float, "s"] = 0.0
    limits: Annotated[dict[str, Limit], "the limits that the results are compared with"] = field(default_factory=dict)
    units: Annotated[dict[str, str], "the unit of each joint: rad or m"] = field(default_factory=dict)
    poses: tuple[PoseTrial, ...] = ()
    drive: tuple[Driven, ...] = ()
    own_servos: Annotated[tuple[str, ...], "joints of the drive without an actuator, which got a servo"] = ()
    ranges: Annotated[tuple[Swept, ...], "joints that were moved over their ranges"] = ()
    energy: Swung | None = None
    timing: Annotated[Timing | None, "null with `--no-timing`"] = None
    diagnostics: tuple[Diagnostic, ...] = ()
    inputs: tuple[Path, ...] = field(default=(), repr=False)


def simulate_robot(
    request: Request,
    *,
    base: str | None = None,
    seconds: float = 2.0,
    limits: Mapping[str, float] | None = None,
    timing: bool = True,
) -> Simulated:
    """Run all scenarios of a robot and return their results, with a diagnostic for each that is beyond a limit.

    ``base`` is "fixed" or "free"; by default a robot with a drive is free on a floor. Each pose is held for ``seconds``
    (0.5 to 600). ``limits`` replace those of ``LIMITS`` by name. Raises RequestError for unusable values, and without
    MuJoCo.
    """
    used = dict(LIMITS)
    for name, value in (limits or {}).items():
        if name not in LIMITS:
            raise RequestError(f'unknown limit "{name}"; {did_you_mean(name, LIMITS)}')
        if not 0 <= value < math.inf:
            raise RequestError(f"a limit is a number that is not negative, such as {name}={LIMITS[name].value:g}")
        used[name] = LIMITS[name]._replace(value=value)
    if not SECONDS[0] <= seconds <= SECONDS[1]:
        raise RequestError(f"seconds is {SECONDS[0]:g} to {SECONDS[1]:g}, not {seconds:g}")
    if base not in (None, FIXED, FREE):
        raise RequestError(f'base is "{FIXED}" or "{FREE}", not "{base}"')
    if missing := [name for name in ("mujoco", "numpy") if not is_installed(name)]:
        raise MissingPackages(f"simulate needs what is not installed ({listed(missing)}): {pip_install('simulate')}")
    understood = request.understand()
    case = understood.case
    if case is None:
        errors = tuple(one for one in understood.diagnostics if one.severity == "error")
        return Simulated(request.description.name, diagnostics=errors)
    robot = case.robot
    with quiet() as mujoco:
        try:
            Progress.step("building the model")
            meshes = request.search_meshes(case.tree, robot.outputs)
            if has_errors(meshes.diagnostics):
                raise Refused("a mesh cannot be used", meshes.diagnostics)
            folder = request.description.outputs
            output = next((one for one in robot.outputs if one.backend == "mjcf"), None)
            base = base or (FREE if robot.drive else FIXED)
            with_meshes = meshes.add_to(robot)
            text = mjcf_text(with_meshes, output, Templates(request.description.path.parent), base)
            folder = (folder / output.file).parent if output else folder
            world = World(mujoco, with_meshes, text, base, folder, meshes.files)
        except Refused as problem:
            message = f"{robot.name} cannot be simulated: {problem}"
            refused = error("simulation-refused", message, None, "check names the place")
            return Simulated(robot.name, diagnostics=(*problem.diagnostics, refused))
        scenarios = run_scenarios(world, seconds)
    timestep = float(world.model.opt.timestep)
    speed = world.steps / world.cpu if world.cpu else 0.0
    result = Simulated(
        robot.name,
        mujoco.__version__,
        base,
        timestep,
        used,
        {joint.name: joint.unit for joint in robot.joints if joint.moves},
        own_servos=world.own,
        timing=Timing(speed, speed * timestep) if timing else None,
        inputs=understood.expanded.files,
        **scenarios,
    )
    found = settled(case, _Judge(case, result).judge(), "simulation")
    return replace(result, diagnostics=tuple(arrange(found)))


class _Judge:
    """Reports what is beyond the limits, at the lines of the description."""

    def __init__(self, case: Case, result: Simulated) -> None:
        self.case, self.robot, self.result = case, case.robot, result
        self.limits = {name: limit.value for name, limit in result.limits.items()}

    def judge(self) -> Iterator[Diagnostic]:
        """Yield diagnostics for the results of all scenarios."""
        results, own = self.result, self.result.own_servos
        for held in results.poses:
            yield from self._held(held)
        if own and results.drive:
            message = f"no actuator turns {first_of(own, _SHOWN)}: simulate drove with its own servos"
            yield replace(self._found("drive-without-actuator", message, ("drive",)), of=own)
        for driven in results.drive:
            yield from self._driven(driven, results.poses[0])
        for swept in results.ranges:
            joint = self.robot.joint[swept.joint]
            if swept.broken:
                yield self._broken(f'joint "{joint.name}" moved over its range', swept.broken, self.case.joint(joint))
                continue
            for end, side in zip(swept.ends, ("lower", "upper"), strict=True):
                if end.error > self.limits["reach"]:
                    yield self._not_reached(joint, end, side)
        swung = results.energy
        if swung is not None and swung.broken:
            yield self._broken("swinging without damping", swung.broken, ("robot",))
        elif swung is not None and swung.change > self.limits["energy"]:
            message = (
                f"without damping, friction and actuators the energy of the robot changes by {swung.change:.0%} within"
                f' half a second; joint "{swung.lightest}" moves the least inertia'
            )
            yield self._found("energy-not-kept", message, ("robot",))

    def _found(self, rule: str, message: str, path: TreePath, severity: str = "") -> Diagnostic:
        return self.case.problem(rule, message, path, severity=severity, key=True)

    def _broken(self, where: str, stop: str, path: TreePath) -> Diagnostic:
        return replace(self._found("simulation-breaks", f"{where}, {stop}", path), of=())

    def _held(self, held: PoseTrial) -> Iterator[Diagnostic]:
        named: TreePath = ("poses", held.pose)
        is_named = exists(self.case.tree, named)
        path: TreePath = named if is_named else ("robot",)
        where = f'in pose "{held.pose}"' if is_named else "at rest"
        if held.broken:
            yield self._broken(f"simulated {where}", held.broken, path)
            return
        for name, off in sorted(held.errors.items(), key=lambda item: -item[1]):
            if off > self.limits["hold"]:
                joint = self.robot.joint[name]
                yield self._not_held(held, joint, off, where, path if is_named else self.case.joint(joint))
        message = ""
        if held.leans > TIPPED:
            message = f"{where}, the robot falls over: after a while it leans by {held.leans:.2g} rad"
        elif held.drift > self.limits["drift"] or held.turned > 2 * self.limits["drift"]:
            message = (
                f"{where}, the robot moves {1000 * held.drift:.3g} mm over the floor and turns by {held.turned:.2g}"
                " rad, though nothing drives it"
            )
        elif held.ripple > self.limits["ripple"]:
            message = f"{where}, the height of the robot does not come to rest: {1000 * held.ripple:.3g} mm up and down"
        if message:
            yield self._found("base-drifts", message, path)

    def _not_held(self, held: PoseTrial, joint: Joint, off: float, where: str, path: TreePath) -> Diagnostic:
        message = f'{where}, joint "{joint.name}" ends {off:.3g} {joint.unit} from its target'
        root = leader_of(self.robot, joint)
        movers = [root, *(one for one in self.robot.joints if one.mimic and one.mimic.joint == root.name)]
        moved = set().union(*(self.robot.below(one.child) for one in movers))
        touch = next((one for one in held.touches if len(moved.intersection(one)) == 1), None)
        message += f": {_touching(*touch)}" if touch else ""
        severity = NOTE if touch else WARNING
        return replace(self._found("pose-not-held", message, path, severity), of=(joint.name, joint.child))

    def _driven(self, driven: Driven, home: PoseTrial) -> Iterator[Diagnostic]:
        if driven.broken:
            yield self._broken(f"driving {driven.command}", driven.broken, ("drive",))
            return
        wrong = []
        if driven.off > self.limits["drive"]:
            commanded, measured = _twist(driven.commanded), _twist(driven.measured)
            wrong.append(f"{measured} where {commanded} is commanded ({driven.off:.0%} off)")
        if driven.cross > self.limits["cross"]:
            wrong.append(f"{driven.cross:.2g} of a velocity that was not commanded")
        if driven.ripple > self.limits["ripple"]:
            wrong.append(f"{1000 * driven.ripple:.2g} mm up and down")
        drive, on_floor = self.robot.drive, set(home.stands_on)
        if not wrong or drive is None:
            return
        names = (*drive.wheels, *drive.steering, *drive.joints.get("rolling", ()))
        links = {name: set(self.robot.below(self.robot.joint[name].child)) for name in names}
        high = [name for name in drive.wheels if not links[name] & on_floor]
        wrong += [f"not on the floor: {first_of(high, _SHOWN)}"] if high else []
        others = [name for name in home.stands_on if name not in set().union(*links.values())]
        wrong += [f"on the floor besides its wheels: {first_of(others, _SHOWN)}"] if others else []
        message = f"driving {driven.command}: {'; '.join(wrong)}"
        yield self._found("drive-not-followed", message, ("drive",))

    def _not_reached(self, joint: Joint, end: End, side: str) -> Diagnostic:
        message = (
            f'moved to its {side} limit of {round(end.target, 4):.6g} {joint.unit}, joint "{joint.name}" ends'
            f" {end.error:.3g} {joint.unit} before it"
        )
        if end.touches:
            message += f": {_touching(*end.touches[0])}"
            message += f", from {round(end.touch_position, 2):.6g} {joint.unit} on" if end.first_touch else ""
        path, severity = self.case.joint(joint, "limit", side), NOTE if end.touches else WARNING
        return self.case.problem("limit-not-reached", message, path, severity=severity)


def _touching(first: str, second: str) -> str:
    return f'link "{first}" touches link "{second}"'


def _twist(twist: Sequence[float]) -> str:
    """Return the parts of a velocity that are not zero, such as "0.3 m/s forward"."""
    words = ("m/s forward", "m/s to the left", "rad/s")
    parts = [f"{value:.2g} {word}" for value, word in zip(twist, words, strict=True) if abs(value) > _LEAST]
    return ", ".join(parts) or "rest"

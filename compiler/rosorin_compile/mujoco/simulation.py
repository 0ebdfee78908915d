"""Run all scenarios for a robot in MuJoCo, compare the results with limits, and format them as tables."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import apply_acceptances
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, MissingPackages, RequestError, UnknownName, has_errors
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.system import is_installed, pip_install
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.tree import exists
from rosorin_compile.source.wording import count_of, first_of, phrase

from .mjcf.bodies import leader_of
from .mjcf.engine import quiet, reason
from .scenarios import FIXED, FREE, DriveTrial, EnergyTrial, PoseTrial, RangeTrial, Result, World, run_scenarios

_TIPPED = 0.2  # rad: a base that leans more has tipped over
_SHOWN = 3  # maximum number of names in a message
_LEAST = 5e-3  # m/s or rad/s: smaller velocity components are omitted


class Limit(NamedTuple):
    """A limit for a measurement: its value, its unit, and a description of the measurement."""

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
class Simulation:
    """The results of simulating a robot in MuJoCo. Lengths are in m, angles in rad, velocities in m/s and rad/s.

    If ``poses`` is empty, the robot could not be simulated, and ``diagnostics`` has the reason. ``inputs`` are the
    files that the robot was read from.
    """

    robot: Annotated[str, "the name of the robot"]
    mujoco: Annotated[str, "the version of MuJoCo"] = ""
    base: Annotated[str, "fixed to the world, or free on a floor"] = ""
    timestep: Annotated[float, "s"] = 0.0
    limits: Annotated[dict[str, Limit], "the limits that the results are compared with"] = field(default_factory=dict)
    units: Annotated[dict[str, str], "the unit of each joint: rad or m"] = field(default_factory=dict)
    poses: tuple[PoseTrial, ...] = ()
    drive: tuple[DriveTrial, ...] = ()
    own_servos: Annotated[tuple[str, ...], "joints of the drive without an actuator, which got a servo"] = ()
    undriven: Annotated[tuple[str, ...], "joints that no actuator drives"] = ()
    ranges: Annotated[tuple[RangeTrial, ...], "joints that were moved over their ranges"] = ()
    energy: EnergyTrial | None = None
    timing: Annotated[Timing | None, "null with `--no-timing`"] = None
    diagnostics: tuple[Diagnostic, ...] = ()
    inputs: tuple[Path, ...] = field(default=(), repr=False)


def simulate(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    *,
    base: str | None = None,
    seconds: float = 2.0,
    limits: Mapping[str, float] | None = None,
    timing: bool = True,
    trust: bool = False,
) -> Simulation:
    """Simulate a robot in MuJoCo: hold its poses, drive it, and move each joint over its range.

    Each measurement above its limit is a diagnostic. If ``poses`` is empty, the robot could not be simulated.

    Args:
        base: ``fixed`` to the world, or ``free`` on a floor; by default a robot with a drive is free.
        seconds: How long to hold each pose, 0.5 to 600 s.
        limits: Limits by name, as in ``simulate --limit``, in m, rad, m/s and rad/s.
        timing: Whether to measure the speed of the simulation, which differs between runs.
    """
    request, used = Request.from_arguments(robot, arguments, packages, trust=trust), dict(LIMITS)
    for name, value in (limits or {}).items():
        if name not in LIMITS:
            raise UnknownName("limit", name, LIMITS)
        if not 0 <= value < math.inf:
            raise RequestError(f"a limit is a number that is not negative, such as {name}={LIMITS[name].value:g}")
        used[name] = LIMITS[name]._replace(value=value)
    if not 0.5 <= seconds <= 600:
        raise RequestError(f"seconds is 0.5 to 600, not {seconds:g}")
    if base not in (None, FIXED, FREE):
        raise RequestError(f'base is "{FIXED}" or "{FREE}", not "{base}"')
    if missing := [name for name in ("mujoco", "numpy") if not is_installed(name)]:
        raise MissingPackages(f"simulate needs what is not installed ({phrase(missing)}): {pip_install('simulate')}")
    understood, description = request.understand(), request.description
    if (case := understood.case) is None:
        errors = tuple(one for one in understood.diagnostics if one.severity == "error")
        return Simulation(description.name, diagnostics=errors)

    def refuse(why: str, found: Sequence[Diagnostic] = ()) -> Simulation:
        message, help = f"{case.robot.name} cannot be simulated: {why}", "check names the place"
        refusal = Diagnostic("simulation-refused", "error", message, help=help)
        return Simulation(case.robot.name, diagnostics=(*found, refusal))

    with quiet() as mujoco:
        Progress.step("building the model")
        meshes = request.search_meshes(case.tree, case.robot.outputs)
        if has_errors(meshes.diagnostics):
            return refuse("a mesh cannot be used", meshes.diagnostics)
        output = next((one for one in case.robot.outputs if one.backend == "mjcf"), None)
        base, with_meshes = base or (FREE if case.robot.drive else FIXED), meshes.add_to(case.robot)
        simulated = Output("simulated", "mjcf", "simulated.xml", {**(output.options if output else {}), "base": base})
        text, problems = FORMATS["mjcf"].compile(with_meshes, simulated, Templates(description.path.parent))
        if has_errors(problems):
            return refuse("it cannot be written for MuJoCo", problems)
        folder = (description.outputs / output.file).parent if output else description.outputs
        try:
            world = World(mujoco, with_meshes, text, base, folder, meshes.files)
        except ValueError as problem:
            return refuse(reason(mujoco, problem)[0] or "MuJoCo gives no reason")
        scenarios = run_scenarios(world, seconds)
    timestep, speed = float(world.model.opt.timestep), world.steps / world.cpu if world.cpu else 0.0
    scenarios["timing"] = Timing(speed, speed * timestep) if timing else None
    scenarios |= {"units": {joint.name: joint.unit for joint in world.joints}, "inputs": understood.expanded.files}
    made = Simulation(case.robot.name, mujoco.__version__, base, timestep, limits=used, **scenarios)
    return replace(made, diagnostics=tuple(arrange(apply_acceptances(case, _judge(case, made), "simulation"))))


def _judge(case: Case, result: Simulation) -> Iterator[Diagnostic]:
    limits, robot = {name: limit.value for name, limit in result.limits.items()}, case.robot

    def broken(where: str, trial: Result, path: TreePath) -> Diagnostic:
        return replace(case.problem("simulation-breaks", f"{where}, {trial.broken}", path, key=True), of=())

    def touching(pair: tuple[str, str] | None) -> str:
        return f': link "{pair[0]}" touches link "{pair[1]}"' if pair else ""

    for held in result.poses:
        is_named = exists(case.tree, ("poses", held.pose))
        path: TreePath = ("poses", held.pose) if is_named else ("robot",)
        where = f'in pose "{held.pose}"' if is_named else "at rest"
        if held.broken:
            yield broken(f"simulated {where}", held, path)
        for name, off in sorted(held.errors.items(), key=lambda item: -item[1]):
            if off <= limits["hold"]:
                continue
            joint = robot.joint[name]
            root = leader_of(robot, joint)
            movers = [root, *(one for one in robot.joints if one.mimic and one.mimic.joint == root.name)]
            moved = set().union(*(robot.subtree(one.child) for one in movers))
            touch = next((one for one in held.touches if len(moved.intersection(one)) == 1), None)
            message = f'{where}, joint "{name}" ends {off:.3g} {joint.unit} from its target{touching(touch)}'
            severity, place = NOTE if touch else "", path if is_named else case.joint(joint)
            found = case.problem("pose-not-held", message, place, severity=severity, key=True)
            yield replace(found, of=(name, joint.child))
        moves = held.drift > limits["drift"] or held.turned > 2 * limits["drift"]
        if moves or held.leans > _TIPPED or held.ripple > limits["ripple"]:
            how = "falls over" if held.leans > _TIPPED else "does not come to rest"
            message = f"{where}, the robot {how}: it leans by {held.leans:.2g} rad, moves {1000 * held.drift:.3g} mm, "
            message += f"turns by {held.turned:.2g} rad, and goes {1000 * held.ripple:.3g} mm up and down"
            yield case.problem("base-drifts", message, path, key=True)
    if result.own_servos and result.drive:
        message = f"no actuator turns {first_of(result.own_servos, _SHOWN)}: simulate drove with its own servos"
        yield replace(case.problem("drive-without-actuator", message, ("drive",), key=True), of=result.own_servos)
    if idle := result.undriven:
        message = f"no actuator drives {first_of(idle, _SHOWN)}: nothing moves it here"
        path = case.joint(robot.joint[idle[0]])
        yield replace(case.problem("joint-without-actuator", message, path, severity=NOTE, key=True), of=idle)
    for driven in result.drive:
        if driven.broken:
            yield broken(f"driving {driven.command}", driven, ("drive",))
        drive, on_floor, measured = robot.drive, result.poses[0].stands_on, _twist(driven.measured)
        checks = {
            f"{measured} where {_twist(driven.commanded)} is commanded ({driven.off:.0%} off)": ("drive", driven.off),
            f"{driven.cross:.2g} of a velocity that was not commanded": ("cross", driven.cross),
            f"{1000 * driven.ripple:.2g} mm up and down": ("ripple", driven.ripple),
        }
        if (wrong := [text for text, (limit, value) in checks.items() if value > limits[limit]]) and drive is not None:
            names = (*drive.wheels, *drive.steering, *drive.joints.get("rolling", ()))
            links = {name: set(robot.subtree(robot.joint[name].child)) for name in names}
            high = [name for name in drive.wheels if links[name].isdisjoint(on_floor)]
            wrong += [f"not on the floor: {first_of(high, _SHOWN)}"] if high else []
            others = [name for name in on_floor if name not in set().union(*links.values())]
            wrong += [f"on the floor besides its wheels: {first_of(others, _SHOWN)}"] if others else []
            message = f"driving {driven.command}: {'; '.join(wrong)}"
            yield case.problem("drive-not-followed", message, ("drive",), key=True)
    for swept in result.ranges:
        joint = robot.joint[swept.joint]
        if swept.broken:
            yield broken(f'joint "{joint.name}" moved over its range', swept, case.joint(joint))
            continue
        for end, side in zip(swept.ends, ("lower", "upper"), strict=True):
            if end.error > limits["reach"]:
                limit = f"its {side} limit of " if joint.limit and joint.type != "continuous" else ""
                message = f'moved to {limit}{round(end.target, 4):.6g} {joint.unit}, joint "{joint.name}" ends '
                message += f"{end.error:.3g} {joint.unit} before it{touching(end.touches[0] if end.touches else None)}"
                if end.touches and end.first_touch:
                    message += f", from {round(end.touch_position, 2):.6g} {joint.unit} on"
                place, severity = case.joint(joint, *(("limit", side) if limit else ())), NOTE if end.touches else ""
                yield case.problem("limit-not-reached", message, place, severity=severity)
    if (swung := result.energy) and swung.broken:
        yield broken("swinging without damping", swung, ("robot",))
    elif swung and swung.change > limits["energy"]:
        message = f"without damping, friction and actuators the energy of the robot changes by {swung.change:.0%} "
        message += f'within half a second; joint "{swung.lightest}" moves the least inertia'
        yield case.problem("energy-not-kept", message, ("robot",), key=True)


def _twist(twist: Sequence[float]) -> str:
    words = ("m/s forward", "m/s to the left", "rad/s")
    parts = [f"{value:.2g} {word}" for value, word in zip(twist, words, strict=True) if abs(value) > _LEAST]
    return ", ".join(parts) or "rest"


def tables(result: Simulation) -> str:
    """Format the results of the scenarios as tables with aligned columns."""

    def row(name: str, trial: Result, *cells: str) -> Sequence[str]:
        return (name, f"broke {trial.broken.partition(':')[0]}") if trial.broken else (name, *cells)

    columns = 5 if result.base == FREE else 3
    poses: list[Sequence[str]] = [("pose", "largest error", "touches", "drift", "stands on")[:columns]]
    for held in result.poses:
        joint, error = max(held.errors.items(), key=lambda item: item[1], default=("", 0.0))
        touches = phrase([" - ".join(pair) for pair in held.touches], 2)
        worst = f"{error:.4f} {result.units[joint]} ({joint})" if joint else ""
        cells = (held.pose, held, worst, touches, f"{1000 * held.drift:.1f} mm", phrase(held.stands_on, 2))
        poses.append(row(*cells)[:columns])
    drive: list[Sequence[str]] = [("command", "commanded", "measured", "off", "cross", "ripple")]
    for driven in result.drive:
        errors = (f"{driven.off:.1%}", f"{driven.cross:.3f}", f"{1000 * driven.ripple:.2f} mm")
        drive.append(row(driven.command, driven, _twist(driven.commanded), _twist(driven.measured), *errors))
    ranges: list[Sequence[str]] = [("joint", "lower", "error", "upper", "error", "touches")]
    for swept in result.ranges:
        unit = result.units[swept.joint]
        ends = [text for end in swept.ends for text in (f"{end.target:.3f}", f"{end.error:.4f}")]
        touched = [(" - ".join(end.first_touch), end.touch_position) for end in swept.ends if end.first_touch]
        where = ", ".join(f"{pair} from {position:.2f} {unit}" for pair, position in touched)
        ranges.append(row(f"{swept.joint} ({unit})", swept, *ends, where))
    blocks = []
    for rows in (one for one in (poses, drive, ranges) if len(one) > 1):
        table = [[cell or "-" for cell in one] for one in rows]
        widths = [max(map(len, column)) for column in zip_longest(*table, fillvalue="")]
        blocks.append("\n".join("  ".join(map(str.ljust, one, widths)).rstrip() for one in table))
    if swung := result.energy:
        change = f"{swung.change:.1%}" if swung.change >= 0.0005 else "less than 0.1%"
        _, change = row("", swung, f"it changes by {change} in half a second")
        blocks.append(f"energy without damping, friction and actuators: {change}")
    return "\n\n".join(blocks)


def about(result: Simulation) -> str:
    """Return a line with the version of MuJoCo, the kind of base and the time step."""
    base = "on a floor" if result.base == FREE else "its base held"
    return f"simulated in MuJoCo {result.mujoco}, {base}, in steps of {1000 * result.timestep:g} ms"


def summary(result: Simulation) -> str:
    """Return a line with the number of scenarios of each kind."""
    counts = {"pose": len(result.poses), "drive command": len(result.drive), "range": len(result.ranges)}
    return ", ".join(count_of(count, word) for word, count in counts.items() if count)

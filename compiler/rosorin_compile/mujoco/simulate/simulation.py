"""Run all scenarios of one robot in MuJoCo and compare their results with limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import settled
from rosorin_compile.source.diagnostics import Diagnostic, MissingPackages, RequestError, error, has_errors, listed
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.system import is_installed, pip_install

from .judging import LIMITS, Judge, Limit, limits_with
from .scenarios import Driven, PoseTrial, Swept, Swung, run_scenarios
from .world import FIXED, FREE, Refused, World, mjcf_text, quiet

RULES = (
    Rule(
        "simulation-refused",
        "The robot cannot be simulated: MuJoCo does not load it, or its MJCF cannot be written.",
        "As the message says; `check` names the place.",
        Heading.SIMULATION,
    ),
)

SECONDS = (0.5, 600.0)  # the shortest and the longest time to hold a pose


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

    def page(self) -> str:
        """Return a page of HTML with tables and plots. It refers to no other file."""
        from .report import page

        return page(self)


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
    used = limits_with(limits or {})
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
            world = _world(mujoco, case, request, base or (FREE if robot.drive else FIXED))
        except Refused as problem:
            message = f"{robot.name} cannot be simulated: {problem}"
            refused = error("simulation-refused", message, None, "check names the place")
            return Simulated(robot.name, diagnostics=(*problem.diagnostics, refused))
        results = run_scenarios(world, seconds)
        found = arrange(settled(case, Judge(case, world, used).judge(results), "simulation"))
    timestep = float(world.model.opt.timestep)
    speed = world.steps / world.cpu if world.cpu else 0.0
    return Simulated(
        robot.name,
        mujoco.__version__,
        world.base,
        timestep,
        {name: limit._replace(value=used[name]) for name, limit in LIMITS.items()},
        {joint.name: joint.unit for joint in robot.joints if joint.moves},
        tuple(results.poses),
        tuple(results.drives),
        tuple(world.own),
        tuple(results.sweeps),
        results.swung,
        Timing(speed, speed * timestep) if timing else None,
        tuple(found),
        understood.expanded.files,
    )


def _world(mujoco: Any, case: Case, request: Request, base: str) -> World:
    """Return the robot in MuJoCo. Raises Refused."""
    Progress.step("building the model")
    description, meshes = request.description, request.search_meshes(case.tree, case.robot.outputs)
    if has_errors(meshes.diagnostics):
        raise Refused("a mesh cannot be used", meshes.diagnostics)
    output = next((one for one in case.robot.outputs if one.backend == "mjcf"), None)
    robot = meshes.add_to(case.robot)
    text = mjcf_text(robot, output, Templates(description.path.parent), base)
    folder = (description.outputs / output.file).parent if output else description.outputs
    return World(mujoco, robot, text, base, folder, meshes.files)

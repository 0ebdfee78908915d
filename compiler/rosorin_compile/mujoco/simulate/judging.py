"""Compare the results of the scenarios with limits, as diagnostics at the lines of the description."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.model import Joint
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    RequestError,
    counted,
    did_you_mean,
    first_of,
)
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Path, exists

from .scenarios import Driven, End, PoseTrial, Results, Stop
from .world import Touch, World, describe_joint

RULES = (
    Rule(
        "simulation-breaks",
        "In MuJoCo the positions of the robot become infinite, or MuJoCo warns of positions, speeds, accelerations or "
        "contacts beyond what it can compute.",
        "Look for parts that start inside each other, for masses and inertias far too small, for gains far too large; "
        "`check physics` names them.",
        Heading.SIMULATION,
    ),
    Rule(
        "pose-not-held",
        "A warning: simulated in a named pose, a joint comes to rest away from it. A note where the robot touches "
        "itself there: no actuator can hold it.",
        "Raise `kp` of the actuator or its effort, or lower the mass that it carries.",
        Heading.SIMULATION,
    ),
    Rule(
        "base-drifts",
        "A warning: on a floor, the robot falls over, does not stay where it stands, or its height does not "
        "come to rest.",
        "Give its wheels actuators or damping; look for shapes that start inside each other.",
        Heading.SIMULATION,
    ),
    Rule(
        "drive-not-followed",
        "A warning: driven on a floor, the robot moves at another velocity than was commanded, or shakes.",
        "Check radius, places and axes of the wheels, `kv` of their actuators against their damping, and what else "
        "touches the floor.",
        Heading.SIMULATION,
    ),
    Rule(
        "drive-without-actuator",
        "A note: a wheel has no actuator on its speed; a servo of `simulate` turned it.",
        "Give the joint of the wheel an actuator.",
        Heading.SIMULATION,
    ),
    Rule(
        "limit-not-reached",
        "A warning: an actuator does not bring its joint to a limit, and nothing is in the way. A note where the robot "
        "touches itself there.",
        "Check effort, `kp` and the mass that the joint carries; narrower limits.",
        Heading.SIMULATION,
    ),
    Rule(
        "energy-not-kept",
        "A warning: without damping, friction, actuators and contacts, the energy of the robot changes. The time step "
        "is too long for its lightest parts.",
        "A shorter `timestep`, more mass, or `armature`.",
        Heading.SIMULATION,
    ),
)

TIPPED = 0.2  # rad
RUN_AWAY = 2.0  # of the range: no joint that is held is as far from its target
_SHOWN = 3  # names
_LEAST = 5e-3  # m/s or rad/s: less is not reported
_TOO_LIGHT = "kp is too large for so little inertia at this time step: more kv, armature, or less kp"


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


def limits_with(overrides: Mapping[str, float]) -> dict[str, float]:
    """Return all limits, with some of them replaced. Raises RequestError."""
    for name, value in overrides.items():
        if name not in LIMITS:
            raise RequestError(f'unknown limit "{name}"; {did_you_mean(name, LIMITS)}')
        if not 0 <= value < math.inf:
            raise RequestError(f"a limit is a number that is not negative, such as {name}={LIMITS[name].value:g}")
    return {name: overrides.get(name, limit.value) for name, limit in LIMITS.items()}


class Judge:
    """Reports what is beyond the limits."""

    def __init__(self, case: Case, world: World, limits: dict[str, float]) -> None:
        self.case, self.world, self.limits = case, world, limits

    def judge(self, results: Results) -> Iterator[Diagnostic]:
        """Yield diagnostics for the results of all scenarios."""
        for held in results.poses:
            yield from self._held(held)
        if self.world.own and results.drives:
            message = f"no actuator turns {first_of(self.world.own, _SHOWN)}: simulate drove with its own servos"
            help = "give the joints actuators: on speed where they roll, on position where they steer"
            yield self._found("drive-without-actuator", message, ("drive",), help, NOTE, of=tuple(self.world.own))
        for driven in results.drives:
            if driven.broken is not None:
                yield self._broken(f"driving {driven.command}", driven.broken, ("drive",))
            else:
                yield from self._driven(driven, results.poses[0])
        for swept in results.sweeps:
            joint = self.case.robot.joint[swept.joint]
            for end, side in zip(swept.ends, ("lower", "upper"), strict=False):
                if swept.broken is None and end.error > self.limits["reach"]:
                    span = abs(swept.ends[-1].asked - swept.ends[0].asked)
                    yield self._not_reached(joint, end, side, end.error > RUN_AWAY * span)
            if swept.broken is not None:
                where = f'joint "{joint.name}" moved over its range'
                yield self._broken(where, swept.broken, self.case.joint(joint))
        swung = results.swung
        if swung is not None and swung.broken is not None:
            yield self._broken("swinging without damping", swung.broken, ("robot",))
        elif swung is not None and swung.change > self.limits["energy"]:
            message = (
                f"without damping, friction and actuators the energy of the robot changes by {swung.change:.0%} within"
                f" half a second{describe_joint(self.case.robot, swung.lightest)}, the least inertia"
            )
            help = "the time step is too long for its lightest parts: a shorter timestep, more mass, or armature"
            yield self._found("energy-not-kept", message, ("robot",), help)

    def _found(
        self, rule: str, message: str, path: Path, help: str, severity: str = WARNING, of: tuple[str, ...] | None = None
    ) -> Diagnostic:
        found = self.case.problem(rule, message, path, help, severity=severity, key=True)
        return found if of is None else replace(found, of=of)

    def _broken(self, where: str, stop: Stop, path: Path) -> Diagnostic:
        message = f"{where}, after {round(stop.time, 3):.6g} s: {stop.why}{describe_joint(self.case.robot, stop.joint)}"
        help = "look for parts that start inside each other, for masses and inertias far too small, for gains too large"
        return self._found("simulation-breaks", message, path, help, ERROR, of=())

    def _held(self, held: PoseTrial) -> Iterator[Diagnostic]:
        named: Path = ("poses", held.pose)
        is_named = exists(self.case.tree, named)
        path: Path = named if is_named else ("robot",)
        where = f'in pose "{held.pose}"' if is_named else "at rest"
        if held.broken is not None:
            yield self._broken(f"simulated {where}", held.broken, path)
            return
        for name, error in sorted(held.errors.items(), key=lambda item: -item[1]):
            if error > self.limits["hold"]:
                joint = self.case.robot.joint[name]
                yield self._not_held(held, joint, error, where, named if is_named else self.case.joint(joint))
        message, help = "", "look for shapes that start inside each other, and at the contacts with the floor"
        if held.leans > TIPPED:
            message = f"{where}, the robot falls over: after a while it leans by {held.leans:.2g} rad"
            help = "look where its centre of mass is, and what it stands on"
        elif held.drift > self.limits["drift"] or held.turned > 2 * self.limits["drift"]:
            message = (
                f"{where}, the robot moves {1000 * held.drift:.3g} mm over the floor and turns by {held.turned:.2g}"
                " rad, though nothing drives it"
            )
            help = "give its wheels actuators or damping; look for shapes that start inside each other"
        elif held.ripple > self.limits["ripple"]:
            message = f"{where}, the height of the robot does not come to rest: {1000 * held.ripple:.3g} mm up and down"
        if message:
            yield self._found("base-drifts", message, path, help)

    def _not_held(self, held: PoseTrial, joint: Joint, error: float, where: str, path: Path) -> Diagnostic:
        message = f'{where}, joint "{joint.name}" ends {error:.3g} {joint.unit} from its target'
        help, severity = "raise kp of its actuator, or its effort; look at the mass that it carries", WARNING
        touch = self._in_the_way(joint, held.touches)
        if touch is not None:
            message += f": {_touching(touch)}"
            help = "correct a shape or the pose; disabled_contacts names a pair that is meant to touch"
            severity = NOTE
        elif joint.unit == "rad" and error > RUN_AWAY * math.tau:
            message, help = f"{message}: it runs away{describe_joint(self.case.robot, joint.name)}", _TOO_LIGHT
        return self._found("pose-not-held", message, path, help, severity, of=(joint.name, joint.child))

    def _in_the_way(self, joint: Joint, touches: Sequence[Touch]) -> Touch | None:
        """Return two links that touch, of which a joint, or what follows the same joint, moves only one."""
        robot = self.case.robot
        while joint.mimic is not None:
            joint = robot.joint[joint.mimic.joint]
        movers = [joint, *(one for one in robot.joints if one.mimic and one.mimic.joint == joint.name)]
        moved = set().union(*(robot.below(one.child) for one in movers))
        return next((one for one in touches if (one.links[0] in moved) != (one.links[1] in moved)), None)

    def _driven(self, driven: Driven, home: PoseTrial) -> Iterator[Diagnostic]:
        wrong = []
        if driven.off > self.limits["drive"]:
            commanded, measured = _twist(driven.asked), _twist(driven.measured)
            wrong.append(f"{measured} where {commanded} is commanded ({driven.off:.0%} off)")
        if driven.cross > self.limits["cross"]:
            wrong.append(f"{driven.cross:.2g} of a velocity that was not commanded")
        if driven.ripple > self.limits["ripple"]:
            wrong.append(f"{1000 * driven.ripple:.2g} mm up and down")
        if wrong:
            cause, help = self._cause(driven, home)
            message = f"driving {driven.command}: {'; '.join([*wrong, cause] if cause else wrong)}"
            yield self._found("drive-not-followed", message, ("drive",), help)

    def _cause(self, driven: Driven, home: PoseTrial) -> tuple[str, str]:
        """Return why a robot does not follow its commands, as far as that was measured, and the fix."""
        robot, drive = self.case.robot, self.case.robot.drive
        names = (*drive.wheels, *drive.steering, *drive.joints.get("rolling", ())) if drive else ()
        wheels = set().union(*(robot.below(robot.joint[name].child) for name in names))
        others = [name for name in home.stands_on if name not in wheels]
        if home.above:
            count = len(home.above)
            cause = (
                f"{counted(count, 'wheel')} ({first_of(list(home.above), _SHOWN)}) {'is' if count == 1 else 'are'}"
                f" {1000 * min(home.above.values()):.3g} mm above the floor"
            )
            cause += f", and the robot stands on {first_of(others, _SHOWN)}" if others else ""
            return cause, "lower its wheels, or raise what it stands on: z of their joints, radius, the shapes"
        rolling = wheels.union(home.stands_on)
        rubs = next((one for one in driven.touches if rolling.intersection(one.links)), None)
        if rubs is not None:
            one, other = sorted(rubs.links, key=lambda name: name not in rolling)
            help = "move it out of that shape; disabled_contacts names a pair that is meant to touch"
            return f'"{one}" is {1000 * rubs.depth:.2g} mm inside "{other}", and rubs on it', help
        help = "check radius, places and axes of the wheels, kv against damping, and what else touches the floor"
        return f"besides its wheels, {first_of(others, _SHOWN)} is on the floor" if others else "", help

    def _not_reached(self, joint: Joint, end: End, side: str, runs_away: bool) -> Diagnostic:
        message = (
            f'moved to its {side} limit of {round(end.asked, 4):.6g} {joint.unit}, joint "{joint.name}" ends'
            f" {end.error:.3g} {joint.unit} before it"
        )
        help, severity = "check effort, kp and the mass that the joint carries; or narrow the limits", WARNING
        if end.touches:
            message += f": {_touching(end.touches[0])}"
            message += f", from {round(end.touch_position, 2):.6g} {joint.unit} on" if end.first_touch else ""
            help = "a planner has to know; narrower limits, or disabled_contacts for a pair that is meant to touch"
            severity = NOTE
        elif runs_away:
            message, help = f"{message}: it runs away{describe_joint(self.case.robot, joint.name)}", _TOO_LIGHT
        path = self.case.joint(joint, "limit", side)
        return self.case.problem("limit-not-reached", message, path, help, severity=severity)


def _touching(touch: Touch) -> str:
    return f'link "{touch.links[0]}" touches link "{touch.links[1]}"'


def _twist(twist: Sequence[float]) -> str:
    """Return the parts of a velocity that are not zero, such as "0.3 m/s forward"."""
    words = ("m/s forward", "m/s to the left", "rad/s")
    parts = [f"{value:.2g} {word}" for value, word in zip(twist, words, strict=True) if abs(value) > _LEAST]
    return ", ".join(parts) or "rest"

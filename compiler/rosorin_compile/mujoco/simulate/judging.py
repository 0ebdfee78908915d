"""Judging: the numbers of the trials held against limits, as diagnostics at the lines of the description."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.model import Drive, Joint
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    RequestError,
    and_more,
    counted,
    did_you_mean,
)
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Path

from .moved import first_to_go, moved
from .trials import Driven, PoseTrial, Stop, Swept, Swung, Trials
from .world import Touch, World

RULES = (
    Rule(
        "simulation-breaks",
        "In MuJoCo the robot leaves the numbers, or MuJoCo warns of positions, speeds, accelerations or contacts "
        "beyond what it can compute.",
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
        "A warning: driven on a floor, the robot moves at another velocity than its wheels are told, or shakes.",
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
RUN_AWAY = 2.0  # of the way between the limits: no joint that is held is as far from where it is led
_FEW = 3
_TOO_LIGHT = "kp is too large for so little inertia at this time step: more kv, armature, or less kp"
_SPOKEN = 5e-3  # m/s or rad/s: less is not spoken of


class Limit(NamedTuple):
    """A limit: its number, its unit, and what it is of."""

    value: float
    unit: str
    about: str


LIMITS: dict[str, Limit] = {
    "hold": Limit(0.01, "rad or m", "error of a joint in a pose"),
    "reach": Limit(0.02, "rad or m", "error of a joint at the end of its range"),
    "drift": Limit(0.005, "m", "way of the base over the floor in a pose"),
    "drive": Limit(0.06, "", "error of a velocity, as a share of the command"),
    "cross": Limit(0.02, "m/s or rad/s", "velocity that nobody asked for"),
    "ripple": Limit(0.001, "m", "change of the height while it drives or stands"),
    "energy": Limit(0.01, "", "change of the energy, as a share of the largest kinetic one"),
}


def limits_with(overrides: Mapping[str, float]) -> dict[str, float]:
    """Return all limits, with some of them replaced. Raises RequestError."""
    for name, value in overrides.items():
        if name not in LIMITS:
            raise RequestError(f'there is no limit "{name}"; {did_you_mean(name, LIMITS)}')
        if not 0 <= value < math.inf:
            raise RequestError(f"a limit is a number that is not negative, such as {name}={LIMITS[name].value:g}")
    return {name: overrides.get(name, one.value) for name, one in LIMITS.items()}


class Judge:
    """Says of each trial what is beyond the limits."""

    def __init__(self, case: Case, world: World, limits: dict[str, float]) -> None:
        self.case, self.world, self.limits = case, world, limits

    def all(self, trials: Trials) -> Iterator[Diagnostic]:
        """Yield what there is to say of all trials."""
        for held in trials.poses:
            yield from self._held(held)
        if self.world.own and trials.drives:
            yield self._own(self.world.own)
        for driven in trials.drives:
            yield from self._driven(driven, trials.poses[0])
        for swept in trials.sweeps:
            yield from self._swept(swept)
        if trials.swung is not None:
            yield from self._swung(trials.swung)

    def _pose(self, name: str) -> Path:
        path: Path = ("poses", name)
        return path if self.case.tree.has(path) else ("robot",)

    def _breaks(self, where: str, stop: Stop, path: Path) -> Diagnostic:
        help = "look for parts that start inside each other, for masses and inertias far too small, for gains too large"
        message = f"{where}, after {round(stop.time, 3):.6g} s: {stop.why}{first_to_go(self.case.robot, stop.joint)}"
        return replace(self.case.problem("simulation-breaks", message, path, help, severity=ERROR, key=True), of=())

    def _held(self, held: PoseTrial) -> Iterator[Diagnostic]:
        where = f'in pose "{held.pose}"' if self._pose(held.pose)[0] == "poses" else "at rest"
        path = self._pose(held.pose)
        if held.broken is not None:
            yield self._breaks(f"simulated {where}", held.broken, path)
            return
        off = {name: error for name, error in held.errors.items() if error > self.limits["hold"]}
        joint = self.case.robot.joint
        by_touch = {name: self._in_the_way(joint[name], held.touches) for name in off}
        for name, error in sorted(off.items(), key=lambda item: -item[1]):
            yield self._not_held(held, joint[name], error, by_touch[name], where)
        if held.leans > TIPPED:
            message = f"{where}, the robot falls over: after a while it leans by {held.leans:.2g} rad"
            help = "look where its centre of mass is, and what it stands on"
            yield self.case.problem("base-drifts", message, path, help, severity=WARNING, key=True)
        elif held.drift > self.limits["drift"] or held.turned > 2 * self.limits["drift"]:
            message = (
                f"{where}, the robot moves {1000 * held.drift:.3g} mm over the floor and turns by {held.turned:.2g}"
                " rad, though nothing drives it"
            )
            help = "give its wheels actuators or damping; look for shapes that start inside each other"
            yield self.case.problem("base-drifts", message, path, help, severity=WARNING, key=True)
        elif held.ripple > self.limits["ripple"]:
            message = f"{where}, the height of the robot does not come to rest: {1000 * held.ripple:.3g} mm up and down"
            help = "look for shapes that start inside each other, and at the contacts with the floor"
            yield self.case.problem("base-drifts", message, path, help, severity=WARNING, key=True)

    def _not_held(self, held: PoseTrial, joint: Joint, error: float, touch: Touch | None, where: str) -> Diagnostic:
        unit = "m" if joint.type == "prismatic" else "rad"
        message = f'{where}, joint "{joint.name}" ends {error:.3g} {unit} from where it is told to be'
        named = self._pose(held.pose)
        path = named if named[0] == "poses" else self.case.joint(joint)
        if touch is not None:
            message += f": {_touching(touch)}"
            help = "correct a shape or the pose; disabled_contacts names a pair that is meant to touch"
            found = self.case.problem("pose-not-held", message, path, help, severity=NOTE, key=True)
        else:
            help = "raise kp of its actuator, or its effort; look at the mass that it carries"
            if joint.type != "prismatic" and error > RUN_AWAY * math.tau:
                message += f": it runs away, {moved(self.case.robot, joint.name)}"
                help = _TOO_LIGHT
            found = self.case.problem("pose-not-held", message, path, help, severity=WARNING, key=True)
        return replace(found, of=(joint.name, joint.child))

    def _in_the_way(self, joint: Joint, touches: Sequence[Touch]) -> Touch | None:
        """Return two links that touch of which a joint moves one against the other, or what it follows does."""
        while joint.mimic is not None:
            joint = self.case.robot.joint[joint.mimic.joint]
        movers = [joint, *(one for one in self.case.robot.joints if one.mimic and one.mimic.joint == joint.name)]
        moved = set().union(*(self.case.robot.below(one.child) for one in movers))
        return next((one for one in touches if (one.links[0] in moved) != (one.links[1] in moved)), None)

    def _own(self, names: Sequence[str]) -> Diagnostic:
        message = f"no actuator turns {_some(names)}: simulate drove with servos of its own"
        help = "give the joints actuators: on speed where they roll, on position where they steer"
        return replace(
            self.case.problem("drive-without-actuator", message, ("drive",), help, severity=NOTE, key=True),
            of=tuple(names),
        )

    def _driven(self, driven: Driven, home: PoseTrial) -> Iterator[Diagnostic]:
        if driven.broken is not None:
            yield self._breaks(f"driving {driven.command}", driven.broken, ("drive",))
            return
        wrong = []
        if driven.off > self.limits["drive"]:
            wrong.append(f"{_twist(driven.measured)} where {_twist(driven.asked)} is asked for ({driven.off:.0%} off)")
        if driven.cross > self.limits["cross"]:
            wrong.append(f"{driven.cross:.2g} of a velocity that nobody asked for")
        if driven.ripple > self.limits["ripple"]:
            wrong.append(f"{1000 * driven.ripple:.2g} mm up and down")
        if wrong:
            cause, help = self._cause(driven, home)
            message = f"driving {driven.command}: {'; '.join([*wrong, *cause])}"
            yield self.case.problem("drive-not-followed", message, ("drive",), help, severity=WARNING, key=True)

    def _cause(self, driven: Driven, home: PoseTrial) -> tuple[list[str], str]:
        """Return what keeps a robot from driving as it is told, as far as that is seen, and the way out."""
        robot = self.case.robot
        drive: Drive | None = robot.drive
        names = (*drive.wheels, *drive.steering, *drive.joints.get("rolling", ())) if drive else ()
        wheels = set().union(*(robot.below(robot.joint[name].child) for name in names))
        others = [name for name in home.stands_on if name not in wheels]
        if home.above:
            high, many = 1000 * min(home.above.values()), len(home.above)
            on = f", and the robot stands on {_some(others)}" if others else ""
            said = f"{counted(many, 'wheel')} ({_some(list(home.above))}) {'is' if many == 1 else 'are'}"
            said += f" {high:.3g} mm above the floor{on}"
            return [said], "lower its wheels, or raise what it stands on: z of their joints, radius, the shapes"
        rolls = wheels.union(home.stands_on)
        rubs = next((one for one in driven.touches if rolls.intersection(one.links)), None)
        if rubs is not None:
            one, other = sorted(rubs.links, key=lambda name: name not in rolls)
            said = f'"{one}" is {1000 * rubs.depth:.2g} mm inside "{other}", and rubs on it'
            return [said], "move it out of that shape; disabled_contacts names a pair that is meant to touch"
        help = "check radius, places and axes of the wheels, kv against damping, and what else touches the floor"
        return ([f"beside its wheels, {_some(others)} is on the floor"] if others else []), help

    def _swept(self, swept: Swept) -> Iterator[Diagnostic]:
        joint = self.case.robot.joint[swept.joint]
        if swept.broken is not None:
            path = self.case.joint(joint)
            yield self._breaks(f'joint "{joint.name}" led through its range', swept.broken, path)
            return
        for end, side in zip(swept.ends, ("lower", "upper"), strict=True):
            if end.error <= self.limits["reach"]:
                continue
            unit = "m" if joint.type == "prismatic" else "rad"
            message = (
                f'led to its {side} limit of {round(end.asked, 4):.6g} {unit}, joint "{joint.name}" ends'
                f" {end.error:.3g} {unit} before it"
            )
            path = self.case.joint(joint, "limit", side)
            touch = end.touches[0] if end.touches else None
            if touch is not None:
                message += f": {_touching(touch)}"
                message += f", from {round(end.touch_position, 2):.6g} {unit} on" if end.first_touch else ""
                help = "a planner has to know; narrower limits, or disabled_contacts for a pair that is meant to touch"
                yield self.case.problem("limit-not-reached", message, path, help, severity=NOTE)
            else:
                help = "check effort, kp and the mass that the joint carries; or narrow the limits"
                if end.error > RUN_AWAY * abs(swept.ends[-1].asked - swept.ends[0].asked):
                    message += f": it runs away, {moved(self.case.robot, joint.name)}"
                    help = _TOO_LIGHT
                yield self.case.problem("limit-not-reached", message, path, help, severity=WARNING)

    def _swung(self, swung: Swung) -> Iterator[Diagnostic]:
        if swung.broken is not None:
            yield self._breaks("swinging without damping", swung.broken, ("robot",))
        elif swung.change > self.limits["energy"]:
            message = (
                f"without damping, friction and actuators the energy of the robot changes by {swung.change:.0%} within"
                f" half a second{first_to_go(self.case.robot, swung.lightest, 'the lightest is')}"
            )
            help = "the time step is too long for its lightest parts: a shorter timestep, more mass, or armature"
            yield self.case.problem("energy-not-kept", message, ("robot",), help, severity=WARNING, key=True)


def _some(names: Sequence[str]) -> str:
    return f"{', '.join(names[:_FEW])}{and_more(len(names) - _FEW)}"


def _touching(touch: Touch) -> str:
    return f'link "{touch.links[0]}" touches link "{touch.links[1]}"'


def _twist(twist: Sequence[float]) -> str:
    """Return the parts of a velocity that are not zero: 0.3 m/s forward."""
    words = ("m/s forward", "m/s to the left", "rad/s")
    said = [f"{value:.2g} {word}" for value, word in zip(twist, words, strict=True) if abs(value) > _SPOKEN]
    return ", ".join(said) or "rest"

"""Servos: what they are called in an MJCF of ours, in which order, and what they can be asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...diagnostics import Diagnostic, did_you_mean
from ...diagnostics.registry import FORMATS, Rule
from ...model import Joint, Output
from ...rules.case import Case
from .unsaid import position_range

RULES = (
    Rule(
        "mjcf-actuators",
        "Two actuators have one name, or an output of MJCF lists one that the robot does not have, or one twice.",
        "Name each one once.",
        FORMATS,
    ),
)


def servo_name(joint: Joint) -> str:
    """Return what the servo of a joint is called: by default as the joint."""
    return (joint.actuator.name if joint.actuator else "") or joint.name


def servos(joints: Sequence[Joint], output: Output) -> list[Joint]:
    """Return the joints that have a servo: those that the output lists, in its order, then the others in theirs."""
    driven = [joint for joint in joints if joint.actuator and joint.moves]
    rank = {name: place for place, name in enumerate(output.options.get("actuators", ()))}
    return sorted(driven, key=lambda joint: rank.get(servo_name(joint), len(rank)))


def aims(joint: Joint) -> tuple[float, float] | None:
    """Return the positions that a servo can be asked for (rad or m); None is any."""
    actuator = joint.actuator
    if actuator is None or actuator.unlimited:
        return None
    return position_range(joint) if actuator.range is None else actuator.range


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield what is wrong with the names of servos, and with the list that orders them."""
    names: dict[str, Joint] = {}
    for joint in case.robot.joints:
        if joint.actuator and joint.moves and names.setdefault(servo_name(joint), joint) is not joint:
            message = f'two actuators are called "{servo_name(joint)}"'
            other = names[servo_name(joint)]
            related = [case.related("the other one", case.joint(other, "actuator"))]
            path = case.joint(joint, "actuator")
            yield case.problem("mjcf-actuators", message, path, "give one of them another name", related=related)
    seen: set[str] = set()
    for index, name in enumerate(output.options.get("actuators", ())):
        path = ("outputs", output.name, "actuators", index)
        if name not in names:
            message = f'the robot has no actuator "{name}"'
            yield case.problem("mjcf-actuators", message, path, did_you_mean(name, names))
        elif name in seen:
            yield case.problem("mjcf-actuators", f'the actuator "{name}" is listed twice', path, "remove one")
        seen.add(name)

"""Actuators: a position servo on a joint is carried, all others are listed; all tell how strong their joint is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ...diagnostics.wording import counted, first_of
from ...frontend.tree import Map
from ...xml.markup import Element
from .reading import SLIDE, Reading, legal, numbers, put, put_number, tidy, tidy_position

# MuJoCo's numbers: mjTRN_JOINT and mjTRN_JOINTINPARENT, which differ for ball joints alone; mjGAIN_FIXED, and so on.
_ON_JOINT = (0, 1)
_FIXED_GAIN = 0
_NO_BIAS, _AFFINE_BIAS = 0, 1
_NO_DYNAMICS = 0


class Drive(NamedTuple):
    """What drives a joint: the largest torque (N*m) or force (N), if known, and the entry of a servo, if it is one."""

    effort: float | None = None
    servo: Map | None = None


def drives_of(reading: Reading) -> dict[int, Drive]:
    """Return what drives each hinge and slide, by the joint's index; list the actuators that are not carried."""
    elements = reading.markup.listed("actuator")
    actuators: Sequence[Mapping[str, Any]] = reading.facts["actuators"]
    if len(elements) != len(actuators):  # attached from another file
        elements = [_element(reading, actuator) for actuator in actuators]
    drives: dict[int, Drive] = {}
    lost: list[tuple[Mapping[str, Any], Element]] = []
    order: dict[int, str] = {}
    for actuator, element in zip(actuators, elements, strict=True):
        index = _joint(reading, actuator)
        if index is None:
            lost.append((actuator, element))
            continue
        before = drives.get(index)
        servo = _servo(reading, actuator, element) if before is None or before.servo is None else None
        if servo is None:
            lost.append((actuator, element))
        else:
            order[index] = actuator["name"] or reading.joint_of[index]
        known, effort = (before.effort if before else 0.0), _effort(reading, actuator, element)
        total = None if known is None or effort is None else known + effort
        drives[index] = Drive(total, servo or (before.servo if before else None))
    reading.servos = order
    _tell(reading, lost)
    return drives


def _element(reading: Reading, actuator: Mapping[str, Any]) -> Element:
    return reading.markup.named("actuator", actuator["name"]) or reading.markup.root


def _joint(reading: Reading, actuator: Mapping[str, Any]) -> int | None:
    """Return the hinge or slide that an actuator acts on, None if it acts on anything else."""
    if actuator["transmission"] not in _ON_JOINT:
        return None
    index: int = actuator["target"][0]
    return index if index in reading.joint_of else None


def _servo(reading: Reading, actuator: Mapping[str, Any], element: Element) -> Map | None:
    """Return the entry of a position servo that pushes the joint itself: force = kp * (aim - position) - kv * speed."""
    kp, bias = actuator["gainprm"][0], actuator["biasprm"]
    plain = (actuator["gain"], actuator["bias"], actuator["dynamics"]) == (_FIXED_GAIN, _AFFINE_BIAS, _NO_DYNAMICS)
    if not plain or actuator["gear"][0] != 1 or kp <= 0 or bias[0] or bias[1] != -kp or bias[2] > 0:
        return None
    entry = Map(element.span)
    put_number(entry, "kp", tidy(kp), element, "kp")
    if bias[2]:
        put_number(entry, "kv", tidy(-bias[2]), element, "kv")
    if legal(actuator["name"]) not in ("", reading.joint_of[actuator["target"][0]]):
        put(entry, "name", legal(actuator["name"]))
    _put_aims(reading, actuator, element, entry)
    return entry


def _put_aims(reading: Reading, actuator: Mapping[str, Any], element: Element, entry: Map) -> None:
    """Set what a servo can be asked for, where that is not the range of its joint."""
    joint = reading.facts["joints"][actuator["target"][0]]
    zero = reading.facts["zero"][joint["address"]]
    if not actuator["controlled"]:
        if joint["limited"]:
            put(entry, "unlimited", True)
    elif not joint["limited"] or joint["range"] != actuator["control"]:
        cut = tidy if joint["type"] == SLIDE else tidy_position
        put(entry, "range", numbers([cut(value - zero) for value in actuator["control"]], element, "ctrlrange"))


def _effort(reading: Reading, actuator: Mapping[str, Any], element: Element) -> float | None:
    """Return the largest torque or force that an actuator brings to its joint, None if that is not said."""
    gear, force, control = (
        float(max(map(abs, values))) for values in (actuator["gear"][:1], actuator["force"], actuator["control"])
    )
    if actuator["forced"]:
        low, high = actuator["force"]
        if low != -high:
            what = f"the force of {low:g} to {high:g}, which has one size both ways in a description,"
            reading.lost(what, element.span, "the larger of the two is carried")
        return gear * force
    direct = (actuator["gain"], actuator["bias"]) == (_FIXED_GAIN, _NO_BIAS)
    if direct and actuator["controlled"]:
        return gear * abs(float(actuator["gainprm"][0])) * control
    return None


def _tell(reading: Reading, lost: Sequence[tuple[Mapping[str, Any], Element]]) -> None:
    """List what is not carried, one message for each kind of actuator."""
    kinds: dict[str, list[tuple[str, Element]]] = {}
    for actuator, element in lost:
        kinds.setdefault(element.tag, []).append((actuator["name"], element))
    for tag, actuators in kinds.items():
        named = [name for name, _ in actuators if name]
        bare = len(actuators) - len(named)
        if bare:
            named.append("without a name" if bare == 1 else "without names" if not named else f"{bare} without names")
        count = counted(len(actuators), "actuator") if len(actuators) > 1 else "the actuator"
        what = f"{count} <{tag}> ({first_of(named, 5)})"
        others = [element.span for _, element in actuators[1:]]
        reading.lost(what, actuators[0][1].span, "only servos of joints are known", len(actuators) > 1, others)

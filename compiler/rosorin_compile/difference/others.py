"""Others: publishers, transforms of other nodes, named poses, servos, sensors, contacts and elements for URDF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from ..compare.words import contacts_change
from ..model import UNPUBLISHED, Edge, JointPose, Publisher, Robot, ServoGroup
from .fragments import fragments
from .joints import differ, unit_of
from .pairing import Pairing
from .values import OTHER, YAML, Item, Side
from .wording import changed

_MOST = 50


def compare_others(pairing: Pairing, sides: tuple[Side, Side], unsaid: frozenset[str]) -> Iterator[Item]:
    """Yield what differs beside links and joints; ``unsaid`` is what is not compared."""
    if "publisher" not in unsaid:
        yield from _publishers(pairing)
    if "edge" not in unsaid:
        yield from _edges(pairing)
    if "pose" not in unsaid:
        yield from _poses(pairing)
    if "servo" not in unsaid:
        yield from _servos(pairing, all(side.format is YAML for side in sides))
    if "sensor" not in unsaid:
        yield from _sensors(pairing.a.robot, pairing.b.robot)
    if "contact" not in unsaid:
        yield from _contacts(pairing.a.robot, pairing.b.robot)
    if "urdf_elements" not in unsaid:
        yield from _elements(pairing)


def _both(kind: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Item]:
    """Yield the names that are in one of two tables only."""
    for name in old:
        if name not in new:
            yield Item(OTHER, name, kind, f"removed: {kind} {name}", name, None)
    for name in new:
        if name not in old:
            yield Item(OTHER, name, kind, f"new: {kind} {name}", None, name)


def _text(publisher: Publisher) -> str:
    return "nobody" if publisher.kind == UNPUBLISHED else publisher.name


def _publishers(pairing: Pairing) -> Iterator[Item]:
    for name in pairing.shared:
        mine, theirs = pairing.a.robot.joint_to.get(name), pairing.b.robot.joint_to.get(name)
        if mine is None or theirs is None:
            continue
        old, new = mine.publisher, theirs.publisher
        if (old.kind, old.name) != (new.kind, new.name):
            said = _text(old), _text(new)
            yield Item(OTHER, name, "publisher", f"{name}: published by {said[0]} -> {said[1]}", *said)


def _edges(pairing: Pairing) -> Iterator[Item]:
    old, new = _by_name(pairing.a.robot.edges), _by_name(pairing.b.robot.edges)
    yield from _both("transform", old, new)
    for name in old:
        if name not in new:
            continue
        one, other = old[name], new[name]
        if one.publisher.name != other.publisher.name:
            said = _text(one.publisher), _text(other.publisher)
            yield Item(OTHER, name, "publisher", f"{name}: published by {said[0]} -> {said[1]}", *said)
        if (one.pose, one.moving) != (other.pose, other.moving):
            said = _place(one), _place(other)
            yield Item(OTHER, name, "origin", f"{name}: {said[0]} -> {said[1]}", *said)


def _by_name(edges: tuple[Edge, ...]) -> dict[str, Edge]:
    return {f"{e.parent} -> {e.child}{f' when {e.when}' if e.when else ''}": e for e in edges}


def _place(edge: Edge) -> str:
    motion = "moving" if edge.moving else "static"
    if edge.pose is None:
        return f"{motion}, numbers not known"
    x, y, z = edge.pose.xyz
    roll, pitch, yaw = edge.pose.rpy
    return f"{motion} xyz {x:.6g} {y:.6g} {z:.6g} rpy {roll:.6g} {pitch:.6g} {yaw:.6g}"


def _poses(pairing: Pairing) -> Iterator[Item]:
    a, b = pairing.a.robot, pairing.b.robot
    old: dict[str, JointPose] = {pose.name: pose for pose in a.poses}
    new: dict[str, JointPose] = {pose.name: pose for pose in b.poses}
    yield from _both("pose", old, new)
    for name in old:
        if name not in new:
            continue
        for joint in a.joints_down():
            # A follower is where its leader puts it.
            if not joint.moves or joint.mimic is not None or joint.name not in b.joint:
                continue
            values = old[name].positions.get(joint.name, 0.0), new[name].positions.get(joint.name, 0.0)
            if differ(pairing.a, pairing.b, joint.name, values, pairing.tolerance, 1.0):
                found = changed(OTHER, f"pose {name}:", joint.name, values, unit_of(joint, joint.name))
                yield replace(found, name=name, quantity=f"pose {joint.name}")


def _servos(pairing: Pairing, ranges: bool) -> Iterator[Item]:
    old, new = _by_joint(pairing.a.robot), _by_joint(pairing.b.robot)
    if ranges:
        yield from _both("servo of", old, new)
    seen = set()
    for joint in old:
        if joint not in new or (old[joint].name, new[joint].name) in seen:
            continue
        one, other = old[joint], new[joint]
        seen.add((one.name, other.name))
        name = f"servo of {joint}"
        values = _radians(one), _radians(other)
        if differ(pairing.a, pairing.b, "rad_per_pulse", values, pairing.tolerance):
            yield changed(OTHER, name, "rad_per_pulse", values, "rad")
        numbers = [("zero_pulse", one.zero_pulse, other.zero_pulse)]
        if ranges:
            numbers += [("lowest pulse", one.pulse_range[0], other.pulse_range[0])]
            numbers += [("highest pulse", one.pulse_range[1], other.pulse_range[1])]
        for quantity, before, after in numbers:
            if before != after:
                yield changed(OTHER, name, quantity, (before, after), "")


def _by_joint(robot: Robot) -> dict[str, ServoGroup]:
    return {joint: group for group in robot.servos for joint in group.joints}


def _radians(group: ServoGroup) -> float:
    """Return the angle of one pulse, negative where the angle falls as the pulse rises."""
    return -group.rad_per_pulse if group.flipped else group.rad_per_pulse


def _sensors(a: Robot, b: Robot) -> Iterator[Item]:
    old, new = {sensor.name: sensor for sensor in a.sensors}, {sensor.name: sensor for sensor in b.sensors}
    yield from _both("sensor", old, new)
    for name in old:
        for quantity in ("type", "frame", "optical_frame"):
            if name not in new:
                continue
            before, after = str(getattr(old[name], quantity)), str(getattr(new[name], quantity))
            if before != after:
                text = f"sensor {name} {quantity.replace('_', ' ')} {before or 'none'} -> {after or 'none'}"
                yield Item(OTHER, name, quantity, text, before, after)


def _contacts(a: Robot, b: Robot) -> Iterator[Item]:
    old, new = ({" - ".join(sorted(pair)) for pair in robot.disabled_contacts} for robot in (a, b))
    if old != new:
        text = contacts_change(sorted(new - old), sorted(old - new))
        yield Item(OTHER, "contacts", "contacts", text, ", ".join(sorted(old)), ", ".join(sorted(new)))


def _elements(pairing: Pairing) -> Iterator[Item]:
    a, b = pairing.a.robot, pairing.b.robot
    places = [("the robot", a.urdf_elements, b.urdf_elements)]
    places += [(n, a.link[n].urdf_elements, b.link[n].urdf_elements) for n in a.link if n in b.link]
    places += [(n, a.joint[n].urdf_elements, b.joint[n].urdf_elements) for n in a.joint if n in b.joint]
    for name, mine, theirs in places:
        if mine == theirs:
            continue
        old, new = fragments(mine), fragments(theirs)
        if old == new:
            continue
        gone, fresh = sorted((old - new).elements()), sorted((new - old).elements())
        said = [
            f"{len(texts)} {word} ({_short(texts[0])})" for texts, word in ((fresh, "new"), (gone, "removed")) if texts
        ]
        text = f"URDF elements of {name}: {', '.join(said)}"
        yield Item(OTHER, name, "urdf_elements", text, "; ".join(gone) or None, "; ".join(fresh) or None)


def _short(text: str) -> str:
    return f"{text[:_MOST]}..." if len(text) > _MOST else text

"""Joints: MuJoCo moves a body by any number of joints anywhere in it; here one joint moves one link.

- A body without joints is fixed. A hinge with a range is revolute, one without continuous; a slide is prismatic.
- A joint whose ``pos`` is not the origin of its body gets a link at that anchor, and the body is fixed to it: every
  body keeps its frame.
- Several joints in one body are a chain of links without mass, in MuJoCo's order.
- Zero is that of the file. If a body is at another position than zero (``ref``), the origin of its joint is turned or
  moved back by it, and ``mjcf`` of the joint keeps it.
- A ball stays one; its range (a cone) is among MuJoCo's own words.
- A free joint of the only top body is no joint of the robot: the simulation knows where the robot is (``base: free``).
  Of one among several top bodies it is a floating joint to the ground. Other planar and floating joints: ``reading``.

Limits: readers of URDF need more than MJCF has, and what stands in for it is declared as a stand-in.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.model import Transform, Vector
from rosorin_compile.model.geometry import rotation_about
from rosorin_compile.source.diagnostics import counted, first_of, listed
from rosorin_compile.source.tree import Map
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.xml.markup import Element

from .actuators import Drive
from .masses import LEAST
from .reading import BALL, FREE, HINGE, SLIDE, Motion, Reading, motion_of
from .values import (
    NO_POSE,
    listing,
    numbers,
    put,
    put_number,
    put_pose,
    put_source,
    put_words,
    shift,
    tidy,
    tidy_position,
    tidy_vector,
    transform,
    unit,
)

STAND_IN_EFFORT = 1000.0  # N*m or N
STAND_IN_VELOCITY = 10.0  # rad/s or m/s
STAND_IN_TRAVEL = 1000.0  # m
_UNFELT = 1e6  # times the inertia of a link without mass

# What is read of the compiled model or follows from the kind of the joint, what is for limits, and what for dynamics.
_READ = (
    *("name", "type", "pos", "axis", "range", "limited", "ref", "springref"),
    *("actuatorfrcrange", "actuatorfrclimited"),
)
_OF_LIMITS = ("solreflimit", "solimplimit", "margin")
_OF_DYNAMICS = {"damping": "damping", "frictionloss": "friction", "armature": "armature", "stiffness": "stiffness"}


class Step(NamedTuple):
    """One joint on the way to a body: its name, where it is anchored in the body, and its axis there."""

    name: str
    joint: int
    kind: int
    anchor: Vector
    axis: Vector
    element: Element


def name_joints(reading: Reading) -> None:
    """Give every joint its name: its own, or one made of the name of its body."""
    apart: set[int] = set()
    for body, held in reading.joints_in.items():
        motion = motion_of(reading, body)
        if motion is not None:
            reading.motion_of[body] = motion._replace(name=reading.joint_names.give(motion.name))
            apart |= set(held)
    joints = [(index, joint) for index, joint in enumerate(reading.facts["joints"]) if index not in apart]
    names = {BALL: reading.ball_of, SLIDE: reading.joint_of, HINGE: reading.joint_of}
    for index, joint in sorted(joints, key=lambda one: not one[1]["name"]):  # names of the file come first
        if joint["type"] in names:
            name = reading.joint_names.give(joint["name"] or f"{reading.link_of[joint['body']]}_joint")
            names[joint["type"]][index] = name
            reading.rename("joint", joint["name"], name)


def add_joints(reading: Reading, drives: dict[int, Drive]) -> None:
    """Add what joins every body to the one that it is in."""
    for index, body in enumerate(reading.facts["bodies"]):
        if index == 0 or body["parent"] not in reading.link_of:
            continue
        held = [(at, reading.facts["joints"][at]) for at in reading.joints_in.get(index, ())]
        place = transform(body["pos"], body["quat"])
        if index in reading.motion_of:
            _add_several(reading, index, place, reading.motion_of[index])
        elif not held or held[0][1]["type"] == FREE:
            _add_single(reading, index, place, held)
        else:
            _add_chain(reading, index, place, [_step(reading, at, joint) for at, joint in held], drives)


def add_root(reading: Reading) -> None:
    """Set where the only top body is in the world, and the name and dynamics of its free joint."""
    if reading.ground:
        world = Map(reading.places.body(0).span)
        put(world, "world", True)
        put(reading.tree, "root", world)
        return
    top = reading.tops[0]
    body, element = reading.facts["bodies"][top], reading.places.body(top)
    entry, place = Map(element.span), transform(body["pos"], body["quat"])
    if reading.free_base:  # without it, it would be on the floor
        put(entry, "xyz", numbers(tidy_vector(place.xyz), element, "pos"))
    put_pose(entry, place, element)
    if reading.free_base:
        index = reading.joints_in[top][0]
        joint, own = reading.facts["joints"][index], reading.places.of("joints", index)
        if joint["name"]:
            put(entry, "joint", reading.joint_names.give(joint["name"]))
        more = {key: text for key, text in joint["element"]["attributes"].items() if key not in (*_READ, *_OF_LIMITS)}
        reading.put_words(entry, more, "root", own, "the free joint", {"frictionloss": "friction"})
    if entry:
        put(reading.tree, "root", entry)


def _add_single(reading: Reading, index: int, place: Transform, held: Sequence[tuple[int, Any]]) -> None:
    """Add the one joint of a body that is fixed or free."""
    above, link = reading.link_of[reading.facts["bodies"][index]["parent"]], reading.link_of[index]
    element = reading.places.of("joints", held[0][0]) if held else reading.places.body(index)
    name = held[0][1]["name"] if held and held[0][1]["name"] else f"{link}_joint"
    kind = "floating" if held else "fixed"
    joint = reading.add_joint(reading.joint_names.give(name), kind, above, link, element)
    put_pose(joint, place, reading.places.body(index))
    if held:
        attributes = held[0][1]["element"]["attributes"]
        rest = _put_dynamics(joint, attributes, element) | _unread(attributes)
        reading.put_words(joint, rest, "joint", element, f'the joint "{name}"')


def _add_several(reading: Reading, index: int, place: Transform, motion: Motion) -> None:
    """Add the one joint of a body that is planar or floating."""
    above, link = reading.link_of[reading.facts["bodies"][index]["parent"]], reading.link_of[index]
    first, *_, last = (reading.places.of("joints", at) for at in reading.joints_in[index])
    joint = reading.add_joint(motion.name, motion.kind, above, link, first)
    put_pose(joint, place, reading.places.body(index))
    if motion.axis is not None:
        put(joint, "axis", numbers(motion.axis, last, "axis"))


def _step(reading: Reading, index: int, joint: dict[str, Any]) -> Step:
    """Return the joint that a joint of MuJoCo becomes."""
    element, (x, y, z) = reading.places.of("joints", index), joint["pos"]
    if joint["type"] == BALL:
        return Step(reading.ball_of[index], index, BALL, (x, y, z), (1.0, 0.0, 0.0), element)
    anchor = (x, y, z) if joint["type"] == HINGE else (0.0, 0.0, 0.0)
    return Step(reading.joint_of[index], index, joint["type"], anchor, unit(joint["axis"]), element)


def _add_chain(reading: Reading, index: int, place: Transform, steps: list[Step], drives: dict[int, Drive]) -> None:
    """Add the joints of a body, one behind the other, and the links between them."""
    body, element = reading.link_of[index], reading.places.body(index)
    above = reading.link_of[reading.facts["bodies"][index]["parent"]]
    at: Vector = (0.0, 0.0, 0.0)  # where in the body, not turned, the link is that the chain has reached
    for number, step in enumerate(steps, 1):
        anchor = tidy_vector(step.anchor) if step.kind != SLIDE else at
        child = body
        if number < len(steps) or anchor != (0, 0, 0):
            is_anchor = step.kind != SLIDE and any(tidy_vector(step.anchor))
            child = reading.link_names.give(f"{step.name}_{'anchor' if is_anchor else 'link'}")
            reading.add(reading.links, child, step.element)
        origin = place.then(shift([a - b for a, b in zip(anchor, at, strict=True)])).then(_to_zero(reading, step))
        joint = reading.add_joint(step.name, _type(reading, step), above, child, step.element)
        put_pose(joint, origin, element if number == 1 and anchor == (0, 0, 0) else step.element)
        if step.kind != BALL:
            put(joint, "axis", numbers(step.axis, step.element, "axis"))
        _put_details(reading, step, joint, drives)
        above, at, place = child, anchor, NO_POSE
    if above != body:
        joint = reading.add_joint(reading.joint_names.give(f"{body}_joint"), "fixed", above, body, element)
        put_pose(joint, shift([-value for value in at]), element)


def _to_zero(reading: Reading, step: Step) -> Transform:
    """Return how a link moves from where the file has it to where its joint is at zero."""
    ref = _reference(reading, step.joint) if step.kind != BALL else 0.0
    if not ref:
        return NO_POSE
    return (
        shift([-ref * part for part in step.axis]) if step.kind == SLIDE else Transform(rotation_about(step.axis, -ref))
    )


def _reference(reading: Reading, index: int) -> float:
    """Return the position (rad or m) at which the file has a hinge or slide."""
    joint = reading.facts["joints"][index]
    value: float = reading.facts["zero"][joint["address"]]
    return tidy(value) if joint["type"] == SLIDE else tidy_position(value)


def _type(reading: Reading, step: Step) -> str:
    if step.kind == HINGE:
        return "revolute" if reading.facts["joints"][step.joint]["limited"] else "continuous"
    return "prismatic" if step.kind == SLIDE else "ball"


def _put_details(reading: Reading, step: Step, entry: Map, drives: dict[int, Drive]) -> None:
    """Set limit, dynamics and actuator of a joint, and what it has for a simulation alone."""
    joint, element = reading.facts["joints"][step.joint], step.element
    attributes = joint["element"]["attributes"]
    drive = drives.get(step.joint, Drive()) if step.kind != BALL else Drive()
    if step.kind != BALL:
        _put_limit(reading, step.joint, entry, drive)
    rest = _put_dynamics(entry, attributes, element)
    if {"stiffness", "springdamper"} & attributes.keys() and step.kind != BALL:
        at_rest = (tidy if step.kind == SLIDE else tidy_position)(float(attributes.get("springref", 0)))
        if at_rest:
            dynamics = entry.get("dynamics") or Map(element.span)
            put(entry, "dynamics", dynamics)
            put_number(dynamics, "spring_reference", at_rest, element, "springref")
    if drive.entry is not None:
        put(entry, "actuator", drive.entry)
    rest |= _unread(attributes)
    if step.kind != BALL:
        low, high = joint["force"]
        # A force that is not the same both ways, or that its actuators have as well, is no effort.
        is_twice = drive.effort is not None and math.isclose(drive.effort, high, rel_tol=1e-9)
        if joint["forced"] and (low != -high or is_twice):
            rest["actuatorfrcrange"] = f"{low!r} {high!r}"
        ref = _reference(reading, step.joint)
        rest |= {"ref": repr(ref)} if ref else {}
    elif joint["limited"]:
        rest["range"] = f"0 {joint['range'][1]!r}"
    reading.put_words(entry, rest, "joint", element, f'the joint "{step.name}"')


def _put_dynamics(entry: Map, attributes: Mapping[str, str], element: Element) -> dict[str, str]:
    """Set the dynamics of a joint; return what they have no word for."""
    dynamics = Map(element.span)
    words = {key: text for key, text in attributes.items() if key in _OF_DYNAMICS and any(map(float, text.split()))}
    pair = [float(number) for number in attributes.get("springdamper", "").split()]
    if pair and min(pair) > 0:  # of which MuJoCo makes both, whatever the others are
        words = {key: text for key, text in words.items() if key not in ("damping", "stiffness")}
    rest = put_words(dynamics, words, "dynamics", element, _OF_DYNAMICS)
    if dynamics:
        put(entry, "dynamics", dynamics)
    return rest


def _unread(attributes: Mapping[str, str]) -> dict[str, str]:
    """Return the attributes that are not read elsewhere."""
    return {key: text for key, text in attributes.items() if key not in _READ and key not in _OF_DYNAMICS}


def _put_limit(reading: Reading, index: int, entry: Map, drive: Drive) -> None:
    """Set the limit of a hinge or slide; a continuous joint has one only if its force is known."""
    joint, element = reading.facts["joints"][index], reading.places.of("joints", index)
    limit, missing = Map(element.span), []
    if joint["limited"]:
        cut = tidy if joint["type"] == SLIDE else tidy_position
        for at, key in enumerate(("lower", "upper")):
            put_number(limit, key, cut(joint["range"][at]), element, "range", at)
    elif joint["type"] == SLIDE:
        missing += ["lower", "upper"]
        for key, sign in (("lower", "-"), ("upper", "")):
            put(limit, key, Quantity.parse(f"{sign}{STAND_IN_TRAVEL:g} m"))
    effort = tidy(max(map(abs, joint["force"]))) if joint["forced"] else drive.effort
    if effort is None and drive.speed is None and not limit:
        return
    for key, value, stand_in in (("effort", effort, STAND_IN_EFFORT), ("velocity", drive.speed, STAND_IN_VELOCITY)):
        attribute = "actuatorfrcrange" if key == "effort" else ""
        put_number(limit, key, stand_in if value is None else tidy(value), element, attribute, 1)
        missing += [key] if value is None else []
    if missing:
        for key in missing:
            reading.stand_ins.setdefault(key, []).append((reading.joint_of[index], limit[key], element.span))
        put(limit, "stand_ins", listing(missing, element))
        verb, them = ("is a stand-in", "it") if len(missing) == 1 else ("are stand-ins", "them")
        put_source(limit, "stand_in", f"{listed(missing)} {verb}: the MJCF does not limit {them}")
    put(entry, "limit", limit)


def report_stand_ins(reading: Reading) -> None:
    """Report the limits that the file does not have and that the URDF needs."""
    ends = [entry for key in ("lower", "upper") for entry in reading.stand_ins.get(key, ())]
    for word, entries in (("range", ends), *((key, reading.stand_ins.get(key, [])) for key in ("effort", "velocity"))):
        if not entries:
            continue
        names = list(dict.fromkeys(name for name, _, _ in entries))
        values = list(dict.fromkeys(f"{value:g}" for _, value, _ in entries))
        whose = f'joint "{names[0]}" has' if len(names) == 1 else f"{counted(len(names), 'joint')} have"
        which = f" ({first_of(names, 3)})" if len(names) > 1 else ""
        written = "is written as a stand-in" if len(values) == 1 else "are written as stand-ins"
        message = f"{whose} no {word} limit in the MJCF{which}: {listed(values)} {written}"
        reading.note("import-stand-in", message, entries[0][2], "put in what the robot really has")


def report_light_bodies(reading: Reading) -> None:
    """Report where the mass that MuJoCo needs between several joints of a body can be felt, so little it weighs."""
    felt = [
        index
        for index, body in enumerate(reading.facts["bodies"])
        if len(reading.joints_in.get(index, ())) > 1 and 0 < min(body["inertia"]) < LEAST * _UNFELT
    ]
    if felt:
        names = first_of([reading.link_of[index] for index in felt], 3)
        message = f"{names}: next to no inertia, and several joints; in ours links are between those"
        message += f", for which MuJoCo needs {LEAST:g} kg*m^2: such small parts move a little otherwise"
        reading.changed(message, reading.places.body(felt[0]).span)

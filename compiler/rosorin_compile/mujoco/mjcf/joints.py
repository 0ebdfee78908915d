"""Joints: MuJoCo moves a body by any number of joints anywhere in it; here one joint moves one link.

- A body without joints is fixed. A hinge with a range is revolute, one without continuous; a slide is prismatic.
- A joint whose ``pos`` is not the origin of its body gets a link at that anchor, and the body is fixed to it: every
  body keeps its frame.
- Several joints in one body are a chain of links without mass, in MuJoCo's order.
- Zero is that of the file. Where a body stands at another position than zero (``ref``), the origin of its joint is
  turned or moved back by it, and ``mjcf`` of the joint keeps it.
- A ball stays one; its range (a cone) stands among MuJoCo's own words.
- A free joint of the only top body is no joint of the robot: where the robot is, the simulation knows (``base: free``).
  Of one among several top bodies it is a floating joint to the ground. Other planar and floating joints: ``reading``.

Limits: readers of URDF ask for more than MJCF says, and nothing is made up in silence.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.model import Transform, Vector
from rosorin_compile.model.geometry import rotation_about
from rosorin_compile.source.diagnostics import counted, first_of, listed
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.xml.markup import Element

from .actuators import Drive
from .masses import LEAST
from .reading import (
    BALL,
    FREE,
    HINGE,
    NO_POSE,
    SLIDE,
    Motion,
    Reading,
    motion_of,
    numbers,
    put,
    put_number,
    put_pose,
    shift,
    source,
    tidy,
    tidy_position,
    tidy_vector,
    transform,
    unit,
)
from .worded import put_words


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
            if joint["name"] and name != joint["name"]:
                reading.renamed.setdefault("joint", {})[joint["name"]] = name


def add_joints(reading: Reading, drives: dict[int, Drive]) -> None:
    """Add what joins every body to the one that it sits in."""
    for index, body in enumerate(reading.facts["bodies"]):
        if index == 0 or body["parent"] not in reading.link_of:
            continue
        held = [(at, reading.facts["joints"][at]) for at in reading.joints_in.get(index, ())]
        place = transform(body["pos"], body["quat"])
        if index in reading.motion_of:
            _several(reading, index, place, reading.motion_of[index])
        elif not held or held[0][1]["type"] == FREE:
            _single(reading, index, place, held)
        else:
            _chain(reading, index, place, [step for at, joint in held for step in _steps(reading, at, joint)], drives)


_OF_LIMITS = ("solreflimit", "solimplimit", "margin")  # which a free joint has none of
_OF_ROOT = {"frictionloss": "friction"}


def add_root(reading: Reading) -> None:
    """Say how the only top body stands in the world, and what its free joint is called and does."""
    if reading.ground:
        world = Map(reading.places.body(0).span)
        put(world, "world", True)
        put(reading.tree, "root", world)
        return
    top = reading.tops[0]
    body, element = reading.facts["bodies"][top], reading.places.body(top)
    entry = Map(element.span)
    place = transform(body["pos"], body["quat"])
    if reading.free_base:  # which would stand on the floor, if nothing were said
        put(entry, "xyz", numbers(tidy_vector(place.xyz), element, "pos"))
    put_pose(entry, place, element)
    if reading.free_base:
        index = reading.joints_in[top][0]
        joint, own = reading.facts["joints"][index], reading.places.of("joints", index)
        if joint["name"]:
            put(entry, "joint", reading.joint_names.give(joint["name"]))
        said = {key: text for key, text in joint["element"]["attributes"].items() if key not in (*_READ, *_OF_LIMITS)}
        for name in put_words(entry, said, "root", own, _OF_ROOT):
            reading.lost(f'"{name}" of the free joint', own.span)
    if entry:
        put(reading.tree, "root", entry)


def _single(reading: Reading, index: int, place: Transform, held: Sequence[tuple[int, Any]]) -> None:
    """Add the one joint of a body that is fixed or free."""
    above, link = reading.link_of[reading.facts["bodies"][index]["parent"]], reading.link_of[index]
    element = reading.places.of("joints", held[0][0]) if held else reading.places.body(index)
    kind = "floating" if held else "fixed"
    name = held[0][1]["name"] if held and held[0][1]["name"] else f"{link}_joint"
    joint = reading.new_joint(reading.joint_names.give(name), kind, above, link, element)
    put_pose(joint, place, reading.places.body(index))
    if held:
        said = held[0][1]["element"]["attributes"]
        _put_more(reading, name, element, joint, _put_dynamics(joint, said, element) | _unread(said))


def _several(reading: Reading, index: int, place: Transform, motion: Motion) -> None:
    """Add the one joint of a body that is planar or floating."""
    above, link = reading.link_of[reading.facts["bodies"][index]["parent"]], reading.link_of[index]
    element = reading.places.of("joints", reading.joints_in[index][0])
    joint = reading.new_joint(motion.name, motion.kind, above, link, element)
    put_pose(joint, place, reading.places.body(index))
    if motion.axis is not None:
        put(joint, "axis", numbers(motion.axis, reading.places.of("joints", reading.joints_in[index][-1]), "axis"))


def _steps(reading: Reading, index: int, joint: dict[str, Any]) -> list[Step]:
    """Return the joint that a joint of MuJoCo is carried as."""
    element = reading.places.of("joints", index)
    x, y, z = joint["pos"]
    if joint["type"] == BALL:
        return [Step(reading.ball_of[index], index, BALL, (x, y, z), (1.0, 0.0, 0.0), element)]
    anchor = (x, y, z) if joint["type"] == HINGE else (0.0, 0.0, 0.0)
    return [Step(reading.joint_of[index], index, joint["type"], anchor, unit(joint["axis"]), element)]


def _chain(reading: Reading, index: int, place: Transform, steps: list[Step], drives: dict[int, Drive]) -> None:
    """Add the joints of a body, one behind the other, and the links between them."""
    body, element = reading.link_of[index], reading.places.body(index)
    above = reading.link_of[reading.facts["bodies"][index]["parent"]]
    place_of_link = place
    at: Vector = (0.0, 0.0, 0.0)  # where in the body, not turned, the link is that the chain has reached
    for number, step in enumerate(steps, 1):
        anchor = tidy_vector(step.anchor) if step.kind != SLIDE else at
        last = number == len(steps) and anchor == (0, 0, 0)
        child = body if last else _between(reading, step)
        origin = place_of_link.then(shift([a - b for a, b in zip(anchor, at, strict=True)]))
        origin = origin.then(_to_zero(reading, step))
        joint = reading.new_joint(step.name, _type(reading, step), above, child, step.element)
        put_pose(joint, origin, element if number == 1 and anchor == (0, 0, 0) else step.element)
        if step.kind != BALL:
            put(joint, "axis", numbers(step.axis, step.element, "axis"))
        _details(reading, step, joint, drives)
        above, at, place_of_link = child, anchor, NO_POSE
    if above != body:
        name = reading.joint_names.give(f"{body}_joint")
        joint = reading.new_joint(name, "fixed", above, body, element)
        put_pose(joint, shift([-value for value in at]), element)


def _to_zero(reading: Reading, step: Step) -> Transform:
    """Return how a link moves from where the file has it to where its joint is at zero."""
    ref = _reference(reading, step.joint) if step.kind != BALL else 0.0
    if not ref:
        return NO_POSE
    if step.kind == SLIDE:
        return shift([-ref * part for part in step.axis])
    return Transform(rotation_about(step.axis, -ref))


def _reference(reading: Reading, index: int) -> float:
    """Return the position (rad or m) at which the file has a hinge or slide."""
    joint = reading.facts["joints"][index]
    value: float = reading.facts["zero"][joint["address"]]
    return tidy(value) if joint["type"] == SLIDE else tidy_position(value)


def _between(reading: Reading, step: Step) -> str:
    """Add a link without mass that a joint moves, and return its name."""
    anchored = step.kind != SLIDE and any(tidy_vector(step.anchor))
    name = reading.link_names.give(f"{step.name}_{'anchor' if anchored else 'link'}")
    reading.new_link(name, step.element)
    return name


def _type(reading: Reading, step: Step) -> str:
    if step.kind in (SLIDE, BALL):
        return "prismatic" if step.kind == SLIDE else "ball"
    limited = step.kind == HINGE and reading.facts["joints"][step.joint]["limited"]
    return "revolute" if limited else "continuous"


# What is read of the compiled model, or is said by the kind of the joint.
_READ = (
    *("name", "type", "pos", "axis", "range", "limited", "ref", "springref"),
    *("actuatorfrcrange", "actuatorfrclimited"),
)
_OF_DYNAMICS = {"damping": "damping", "frictionloss": "friction", "armature": "armature", "stiffness": "stiffness"}


def _details(reading: Reading, step: Step, entry: Map, drives: dict[int, Drive]) -> None:
    """Set limit, dynamics and actuator of a joint, and what it has for a simulation alone."""
    said = reading.facts["joints"][step.joint]["element"]["attributes"]
    drive = drives.get(step.joint, Drive()) if step.kind != BALL else Drive()
    if step.kind != BALL:
        add_limit(reading, step.joint, entry, drive)
    rest = _put_dynamics(entry, said, step.element)
    if {"stiffness", "springdamper"} & said.keys() and step.kind != BALL:
        _put_rest(step, entry, said)
    if drive.entry is not None:
        put(entry, "actuator", drive.entry)
    rest |= _unread(said)
    joint = reading.facts["joints"][step.joint]
    if step.kind != BALL:
        rest |= _force(joint, drive)
        ref = _reference(reading, step.joint)
        rest |= {"ref": repr(ref)} if ref else {}
    elif joint["limited"]:
        rest["range"] = f"0 {joint['range'][1]!r}"
    _put_more(reading, step.name, step.element, entry, rest)


def _put_dynamics(entry: Map, said: Mapping[str, str], element: Element) -> dict[str, str]:
    """Set the dynamics of a joint; return what they have no word for."""
    dynamics = Map(element.span)
    words = {key: text for key, text in said.items() if key in _OF_DYNAMICS and any(map(float, text.split()))}
    pair = [float(number) for number in said.get("springdamper", "").split()]
    if pair and min(pair) > 0:  # of which MuJoCo makes both, whatever else is said
        words = {key: text for key, text in words.items() if key not in ("damping", "stiffness")}
    rest = put_words(dynamics, words, "dynamics", element, _OF_DYNAMICS)
    if dynamics:
        put(entry, "dynamics", dynamics)
    return rest


def _unread(said: Mapping[str, str]) -> dict[str, str]:
    """Return the attributes that are not read elsewhere."""
    return {key: text for key, text in said.items() if key not in _READ and key not in _OF_DYNAMICS}


def _force(joint: Mapping[str, Any], drive: Drive) -> dict[str, str]:
    """Return the force of a joint that is not the same both ways, or that its actuators have as well."""
    low, high = joint["force"]
    twice = drive.effort is not None and math.isclose(drive.effort, high, rel_tol=1e-9)
    return {"actuatorfrcrange": f"{low!r} {high!r}"} if joint["forced"] and (low != -high or twice) else {}


def _put_rest(step: Step, entry: Map, said: Mapping[str, str]) -> None:
    """Set where the spring of a joint is at rest."""
    cut = tidy if step.kind == SLIDE else tidy_position
    rest = cut(float(said.get("springref", 0)))
    if rest:
        dynamics = entry.get("dynamics") or Map(step.element.span)
        put(entry, "dynamics", dynamics)
        put_number(dynamics, "spring_reference", rest, step.element, "springref")


def _put_more(reading: Reading, name: str, element: Element, entry: Map, rest: Mapping[str, str]) -> None:
    """Set what the language has no word for, in MuJoCo's."""
    for word in put_words(entry, rest, "joint", element):
        reading.lost(f'"{word}" of the joint "{name}"', element.span)


STAND_IN_EFFORT = 1000.0  # N*m or N
STAND_IN_VELOCITY = 10.0  # rad/s or m/s
STAND_IN_TRAVEL = 1000.0  # m


def add_limit(reading: Reading, index: int, entry: Map, drive: Drive) -> None:
    """Set the limit of a hinge or slide; a continuous joint has one only if its force is known."""
    joint = reading.facts["joints"][index]
    element = reading.places.of("joints", index)
    limit = Map(element.span)
    missing = []
    if joint["limited"]:
        cut = tidy if joint["type"] == SLIDE else tidy_position
        for at, key in enumerate(("lower", "upper")):
            put_number(limit, key, cut(joint["range"][at]), element, "range", at)
    elif joint["type"] == SLIDE:
        missing += ["lower", "upper"]
        for key, sign in (("lower", "-"), ("upper", "")):
            put(limit, key, Quantity.parse(f"{sign}{STAND_IN_TRAVEL:g} m"))
    effort = _effort(reading, index, drive)
    if effort is None and drive.speed is None and not limit:
        return
    missing += ["effort"] if effort is None else []
    put_number(limit, "effort", STAND_IN_EFFORT if effort is None else effort, element, "actuatorfrcrange", 1)
    put_number(limit, "velocity", STAND_IN_VELOCITY if drive.speed is None else drive.speed, element)
    missing += ["velocity"] if drive.speed is None else []
    if not missing:
        put(entry, "limit", limit)
        return
    note = f"{listed(missing)} {'is a stand-in' if len(missing) == 1 else 'are stand-ins'}: the MJCF does not limit "
    stand_ins = Seq(element.span)
    for key in missing:
        stand_ins.put(key, element.span)
        reading.stand_ins.setdefault(key, []).append((reading.joint_of[index], limit[key], element.span))
    put(limit, "stand_ins", stand_ins)
    source(limit, "stand_in", note + ("it" if len(missing) == 1 else "them"))
    put(entry, "limit", limit)


def tell_of_stand_ins(reading: Reading) -> None:
    """Say which limits the file does not have and the URDF gets all the same."""
    ends = [entry for key in ("lower", "upper") for entry in reading.stand_ins.get(key, ())]
    for word, entries in (("range", ends), *((key, reading.stand_ins.get(key, [])) for key in ("effort", "velocity"))):
        if not entries:
            continue
        names = list(dict.fromkeys(name for name, _, _ in entries))
        numbers = list(dict.fromkeys(f"{value:g}" for _, value, _ in entries))
        whose = f'joint "{names[0]}" has' if len(names) == 1 else f"{counted(len(names), 'joint')} have"
        which = f" ({first_of(names, 3)})" if len(names) > 1 else ""
        stand = "stands" if len(numbers) == 1 else "stand"
        message = f"{whose} no {word} limit in the MJCF{which}: {listed(numbers)} {stand} in where readers ask for one"
        reading.stood_in(message, entries[0][2])


def _effort(reading: Reading, index: int, drive: Drive) -> float | None:
    """Return the largest torque (N*m) or force (N) of a joint: its own limit, else what its actuators can bring."""
    joint = reading.facts["joints"][index]
    if not joint["forced"]:
        return None if drive.effort is None else tidy(drive.effort)
    low, high = joint["force"]
    return tidy(max(abs(low), abs(high)))


def tell_of_light_bodies(reading: Reading) -> None:
    """Say where the mass that MuJoCo asks for between several joints of a body can be felt, so little it weighs."""
    felt = [
        index
        for index, body in enumerate(reading.facts["bodies"])
        if len(reading.joints_in.get(index, ())) > 1 and 0 < min(body["inertia"]) < LEAST * _UNFELT
    ]
    if felt:
        names = first_of([reading.link_of[index] for index in felt], 3)
        message = f"{names}: next to no inertia, and several joints; in ours links stand between those"
        message += f", for which MuJoCo asks for {LEAST:g} kg*m^2: such small parts move a little otherwise"
        reading.changed(message, reading.places.body(felt[0]).span)


_UNFELT = 1e6  # times the inertia of a link without mass

"""Agreement: do the compiled artifacts say what the model says, and so the same? Guards against faulty templates."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..diagnostic import Diagnostic, error
from ..emit import Artifact, Fact, Facts, Value, backend
from ..emit.mjcf_checks import has_volume, position_range
from ..emit.xml_facts import INERTIA, along_link
from ..model import (
    STATIC_TRANSFORM_PUBLISHER,
    Capsule,
    Cylinder,
    Edge,
    HeightMap,
    Joint,
    Link,
    Mesh,
    Pose,
    Robot,
    Shape,
)
from ..registry import WRITING, Rule
from ..schema import misfits
from .causes import COLLISION, gathered
from .shapes import Solid, remainder, same_set, solid_from
from .view import ANGLES, AXES, ORDER, View, agree, renamed, same_turn, view_of
from .words import number_pair, value_text

RULES = (
    Rule(
        "artifacts-disagree",
        "Artifacts that were just compiled do not say the same.",
        "That is a fault of the tool: please report it.",
        WRITING,
    ),
)

_RULE = "artifacts-disagree"
_HELP = "a template or a backend is at fault, not the description: please report it"
# What the way through frames, quaternions and half sizes costs (m, and rotation entries).
_ROOM = 1e-9


class _Reading(NamedTuple):
    """An artifact and what it says."""

    artifact: Artifact
    view: View


# The backends whose artifacts have a schema of their own.
_SCHEMAS = {"robot_model": "robot_model", "static_tf_json": "static_tf"}


def _misfits(artifact: Artifact) -> list[Diagnostic]:
    """Return an error for each place where a JSON artifact does not fit its published schema."""
    name = _SCHEMAS.get(artifact.backend)
    problems = misfits(name, json.loads(artifact.text)) if name else []
    return [
        error(_RULE, f"{artifact.file} does not fit schemas/{name}.schema.json: {p}", None, _HELP) for p in problems
    ]


def agreement(robot: Robot, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Return an error for each place where a compiled artifact does not say what the model says, as far as it prints.

    Held against the model: the frames that an artifact carries, where they sit, their joints with axis, limits and
    mimic, masses, centres of mass and inertias, and collision shapes.
    """
    readings: list[_Reading] = []
    found: list[Diagnostic] = []
    for artifact in artifacts:
        try:
            facts = backend(artifact.backend).read(artifact.text)
        except ValueError as problem:
            found.append(error(_RULE, f"{artifact.file} cannot be read back: {problem}", None, _HELP))
        else:
            found += _misfits(artifact)
            readings.append(_Reading(artifact, view_of(facts, renamed(robot, artifact.output))))
    readings.sort(key=lambda reading: (_rank(reading), reading.artifact.output))
    model = view_of(_facts(robot), {})
    for reading in readings:
        found += _frames(robot, reading)
        found += _picture(robot, reading)
        found += _values(robot, reading, model, readings)
        found += _turns(reading, model, readings)
        found += _shapes(robot, reading)
    return found


def _rank(reading: _Reading) -> int:
    name = reading.artifact.backend
    return ORDER.index(name) if name in ORDER else len(ORDER)


def _facts(robot: Robot) -> Facts:
    """Return what the model says about frames, joints and masses, in the terms of the artifacts."""
    facts: Facts = {}
    for joint in robot.joints:
        facts |= _pose_facts(joint.child, joint.parent, joint.origin)
        facts |= _joint_facts(joint)
    for edge in robot.edges:
        # Of several rows for one frame the first one bears its name alone.
        if edge.joint:
            facts |= _pose_facts(_row(edge), edge.parent, robot.joint[edge.joint].origin)
        elif edge.pose is not None and Fact("frame", edge.child, "parent") not in facts:
            facts |= _pose_facts(edge.child, edge.parent, edge.pose)
    for link in robot.links:
        facts |= _mass_facts(link)
    return facts


def _row(edge: Edge) -> str:
    """Return the name of a frame in the row of a publisher that takes turns, as ``view`` has it."""
    return f"{edge.child} when {' '.join(edge.when.split())}" if edge.when else edge.child


def _pose_facts(child: str, parent: str, pose: Pose) -> Facts:
    facts = {Fact("frame", child, "parent"): Value(parent)}
    facts |= {
        Fact("frame", child, f"origin {axis}"): Value(float(v), "m") for axis, v in zip(AXES, pose.xyz, strict=True)
    }
    return facts | {
        Fact("frame", child, angle): Value(float(v), "rad") for angle, v in zip(ANGLES, pose.rpy, strict=True)
    }


def _joint_facts(joint: Joint) -> Facts:
    said: dict[str, Value] = {"type": Value(joint.type), "child": Value(joint.child)}
    unit = "m" if joint.type == "prismatic" else "rad"
    if joint.moves or joint.type == "planar":
        said |= {f"axis {axis}": Value(float(value)) for axis, value in zip(AXES, joint.axis, strict=True)}
    if joint.moves and joint.limit:
        limits = {"lower": joint.limit.lower, "upper": joint.limit.upper, "velocity": joint.limit.velocity}
        limits["effort"] = joint.limit.effort
        said |= {quantity: Value(float(value), unit) for quantity, value in limits.items() if value is not None}
    if joint.mimic:
        said["mimic joint"] = Value(joint.mimic.joint)
        said["mimic multiplier"] = Value(float(joint.mimic.multiplier))
        said["mimic offset"] = Value(float(joint.mimic.offset), unit)
    return {Fact("joint", joint.name, quantity): value for quantity, value in said.items()}


def _mass_facts(link: Link) -> Facts:
    inertial = link.inertial
    if inertial is None:
        return {}
    said = {"mass": Value(float(inertial.mass), "kg")}
    said |= {f"centre of mass {axis}": Value(float(v), "m") for axis, v in zip(AXES, inertial.pose.xyz, strict=True)}
    six = (inertial.ixx, inertial.iyy, inertial.izz, inertial.ixy, inertial.ixz, inertial.iyz)
    along = along_link(six, inertial.pose.transform())
    said |= {f"inertia {name}": Value(float(value), "kg*m^2") for name, value in zip(INERTIA, along, strict=True)}
    return {Fact("link", link.name, quantity): value for quantity, value in said.items()}


def _frames(robot: Robot, reading: _Reading) -> Iterator[Diagnostic]:
    """Yield an error for each frame that an artifact should carry and does not."""
    joints: Sequence[Joint] = ()
    if reading.artifact.backend == "urdf":
        joints = robot.in_urdf()
    elif reading.artifact.backend in ("static_tf", "static_tf_json"):
        turns = [edge for edge in robot.edges if edge.joint and edge.publisher.kind == STATIC_TRANSFORM_PUBLISHER]
        joints = [*robot.published_by(STATIC_TRANSFORM_PUBLISHER), *(robot.joint[edge.joint] for edge in turns)]
    elif reading.artifact.backend in ("mjcf", "frames"):
        joints = robot.joints
    for joint in joints:
        rows = [_row(edge) for edge in robot.turns.get(joint.name, ())] if reading.artifact.backend == "frames" else []
        if not all(map(reading.view.parent, rows or [joint.child])):
            message = f"{reading.artifact.file} does not carry the frame {joint.child}, which it should"
            yield error(_RULE, message, None, _HELP)


def _picture(robot: Robot, reading: _Reading) -> Iterator[Diagnostic]:
    """Yield an error for each edge and frame that a picture of the frames shows wrongly."""
    if reading.artifact.backend == "frames_picture":
        from ..emit.frames_picture import disagreements

        output = next(output for output in robot.outputs if output.name == reading.artifact.output)
        for said in disagreements(robot, output, reading.artifact.text):
            yield error(_RULE, f"{reading.artifact.file}: {said}", None, _HELP)


def _values(robot: Robot, reading: _Reading, model: View, readings: Sequence[_Reading]) -> Iterator[Diagnostic]:
    for fact, value in reading.view.plain.items():
        meant = model.plain.get(fact)
        if meant is None or agree(value, meant) or _cannot_say(robot, reading, fact):
            continue
        others = (other for other in readings if agree(other.view.plain.get(fact), meant))
        mine, theirs = _both(value, meant)
        yield _error(f"{fact.name} {fact.quantity}", reading, mine, theirs, next(others, None))


def _cannot_say(robot: Robot, reading: _Reading, fact: Fact) -> bool:
    """Say whether a format has no word for a fact: MJCF tells a revolute joint from a continuous one by its range."""
    if reading.artifact.backend != "mjcf" or (fact.kind, fact.quantity) != ("joint", "type"):
        return False
    joint = robot.joint[fact.name]
    return joint.type == "revolute" and position_range(joint) is None


def _both(value: Value, meant: Value) -> tuple[str, str]:
    """Return two different values in print, with as many digits as show the difference."""
    if isinstance(value.value, str) or isinstance(meant.value, str):
        return value_text(value), value_text(meant)
    before, after = number_pair(value.value, meant.value)
    return f"{before} {value.unit}".rstrip(), f"{after} {value.unit}".rstrip()


def _turns(reading: _Reading, model: View, readings: Sequence[_Reading]) -> Iterator[Diagnostic]:
    for frame, turn in reading.view.turns.items():
        meant = model.turns.get(frame)
        if meant is None or same_turn(turn, meant):
            continue
        others = (other for other in readings if same_turn(other.view.turns.get(frame), meant))
        pairs = [number_pair(a, b) for a, b in zip(turn.rpy, meant.rpy, strict=True)]
        mine, theirs = (f"{' '.join(numbers)} rad" for numbers in zip(*pairs, strict=True))
        yield _error(f"{frame} roll pitch yaw", reading, mine, theirs, next(others, None))


def _error(what: str, reading: _Reading, mine: str, theirs: str, other: _Reading | None) -> Diagnostic:
    others = f"{other.artifact.file} and the model say" if other else "the model says"
    return error(_RULE, f"{what}: {reading.artifact.file} says {mine}, {others} {theirs}", None, _HELP)


def _shapes(robot: Robot, reading: _Reading) -> Iterator[Diagnostic]:
    """Yield an error for each link whose collision shapes in an artifact are not those of the model."""
    told = {link: solids for (link, purpose), solids in reading.view.shapes.items() if purpose == COLLISION}
    every = reading.artifact.backend in ("urdf", "mjcf") and bool(told)
    for link in sorted(reading.view.names) if every else sorted(told):
        # Names of shapes and the like are not in every artifact.
        solids = [solid._replace(words=()) for solid in told.get(link, ())]
        meant = _meant(robot, link, reading)
        if meant is None or same_set(solids, meant):
            continue
        wrong = len(remainder(solids, meant).removed)
        message = f"{link} collision: {wrong} of {len(solids)} shapes in {reading.artifact.file} are not in the model"
        if len(solids) != len(meant):
            message = f"{link} collision: {reading.artifact.file} has {len(solids)} shapes, the model {len(meant)}"
        yield error(_RULE, message, None, _HELP)


def _meant(robot: Robot, link: str, reading: _Reading) -> list[Solid] | None:
    """Return the solids that a link should have in an artifact; None if they cannot be compared."""
    if link not in robot.link:
        return None
    own: Sequence[Shape] = robot.link[link].collision
    if reading.artifact.backend == "urdf":
        own = list(gathered(robot, link, reading.view.names, COLLISION)[0])
        own = own if _has_capsules(robot, reading) else [_cylinder(shape) for shape in own]
    elif reading.artifact.backend == "mjcf":
        own = [solid for shape in own for solid in shape.solids() if has_volume(solid.geometry)]
    elif reading.artifact.backend == "robot_model":
        own = [shape for shape in own if not isinstance(shape.geometry, HeightMap)]
    if any(isinstance(shape.geometry, Mesh) for shape in own):
        return None
    return [solid_from(solid, _ROOM) for shape in own for solid in shape.solids()]


def _has_capsules(robot: Robot, reading: _Reading) -> bool:
    """Say whether a URDF is of a version that has a word for capsules."""
    options = next((output.options for output in robot.outputs if output.name == reading.artifact.output), {})
    return str(options.get("version", "1.0")) != "1.0"


def _cylinder(shape: Shape) -> Shape:
    """Return a capsule as the cylinder that stands for it in URDF, any other shape as it is."""
    geometry = shape.geometry
    if not isinstance(geometry, Capsule):
        return shape
    return Shape(Cylinder(geometry.radius, geometry.length + 2 * geometry.radius), shape.pose)

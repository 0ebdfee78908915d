"""robot_model: the geometry as plain numbers on one line, for a driver that needs no URDF to check its arm for contact.

``schemas/robot_model.schema.json`` says what each value is. Numbers are exact: they read back as the same doubles.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import Box, HeightMap, Joint, Limit, Link, Output, Pose, Robot, Shape, Vector
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.model.joint import SEVERAL_COORDINATES
from rosorin_compile.model.link import Source
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.rules.case import Case
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, did_you_mean, error
from rosorin_compile.source.rule_registry import FORMATS, Rule

from ..format import Format, Opened
from ..unsupported import PLACES

if TYPE_CHECKING:
    from ..imported import Imported
    from ..templating import Templates

RULES = (
    Rule(
        "robot-model-cannot-say",
        "A warning: the driver's model has no room for a shape, a mimic, a planar, a floating or a ball joint.",
        "The URDF carries it; or leave the joint out with `joints`.",
        FORMATS,
    ),
    Rule(
        "robot-model-unknown-name",
        "An option names a joint, link or servo group that does not exist.",
        "Correct the name.",
        FORMATS,
    ),
    Rule("robot-model-same-name", "`rename` gives two links one name.", "Rename one to another.", FORMATS),
    Rule(
        "robot-model-servos",
        "The driver's model has room for one servo group, and there are several.",
        "Say which with `servos`.",
        FORMATS,
    ),
)

_Map = tuple[HeightMap, str]


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the driver's model of a robot.

    Options: ``joints`` (names, in the order wanted; default all but those of simulations alone), ``rename`` (link
    name: its name in this artifact), ``servos`` (the group for pulse_to_rad, needed if there are several), ``source``
    (default: the robot's source note).
    """
    import json

    diagnostics: list[Diagnostic] = []
    return json.dumps(_model(robot, output, diagnostics), allow_nan=False) + "\n", diagnostics


def _model(robot: Robot, output: Output, diagnostics: list[Diagnostic]) -> dict[str, Any]:
    """Return the driver's model as a value of JSON; what is wrong is added to the diagnostics."""
    options = output.options
    diagnostics += _unknown_names(robot, options)
    joints = [robot.joint[name] for name in _asked(robot, output) if name in robot.joint]
    joints = [joint for joint in joints if _has_word(joint, diagnostics)]
    rename: Mapping[str, str] = options.get("rename", {})
    links = _links(joints) or [robot.root]
    diagnostics += _same_names(links, rename)
    servos = _servos(robot, options, diagnostics)
    model: dict[str, Any] = {"source": options.get("source", robot.source.note)}
    if servos:
        model["pulse_to_rad"] = _pulse_to_rad(servos)
    model["joints"] = {joint.name: _joint(joint, rename, diagnostics) for joint in joints}
    model["boxes"], height_maps = {}, []
    for link in links:
        box, maps = _collision(robot, link, diagnostics)
        height_maps += [(link, *height_map) for height_map in maps]
        if box is not None:
            corners = {"min": _listed(box.lower), "max": _listed(box.upper)}
            model["boxes"][rename.get(link, link)] = corners
    for link, height_map, stand_in in height_maps[:1]:
        model["chassis_heightmap"] = _height_map(rename.get(link, link), height_map, stand_in)
    for link, *_ in height_maps[1:]:
        diagnostics.append(_left_out(link, "a second height map: the format has room for one"))
    return model


def _asked(robot: Robot, output: Output) -> Iterable[str]:
    """Return the names of the joints to carry, as asked for: by default all but those of simulations alone."""
    real = (joint.name for joint in robot.joints if joint.child not in robot.simulated_frames)
    asked: Iterable[str] = output.options.get("joints", tuple(real))
    return asked


def _unknown_names(robot: Robot, options: Mapping[str, Any]) -> list[Diagnostic]:
    """Return an error for each name in the options that the robot does not have."""
    servos = {group.name for group in robot.servos}
    asked: list[tuple[str, Iterable[str], Iterable[str]]] = [
        ("joint", options.get("joints", ()), robot.joint),
        ("link", options.get("rename", {}), robot.link),
        ("servo group", [options["servos"]] if "servos" in options else [], servos),
    ]
    return [
        error("robot-model-unknown-name", f'there is no {kind} "{name}"', None, did_you_mean(name, known))
        for kind, names, known in asked
        for name in names
        if name not in known
    ]


def _has_word(joint: Joint, diagnostics: list[Diagnostic]) -> bool:
    """Say whether the format knows the type of a joint; if not, a warning is added."""
    if joint.type not in SEVERAL_COORDINATES:
        return True
    message = f"robot_model has no word for {joint.type}: joint {joint.name} is left out"
    way_out = "let its reader know how the two parts of the robot hang together"
    diagnostics.append(Diagnostic("robot-model-cannot-say", WARNING, message, help=way_out))
    return False


def _links(joints: list[Joint]) -> list[str]:
    """Return the links of the joints: the children in the order of the joints, then the parents that are no child."""
    return list(dict.fromkeys([*(joint.child for joint in joints), *(joint.parent for joint in joints)]))


def _same_names(links: list[str], rename: Mapping[str, str]) -> list[Diagnostic]:
    named: dict[str, str] = {}
    diagnostics = []
    for link in links:
        name = rename.get(link, link)
        if name in named:
            message = f'links {named[name]} and {link} would both be called "{name}" in this artifact'
            diagnostics.append(error("robot-model-same-name", message, None, "rename one of them to another name"))
        named[name] = link
    return diagnostics


def _servos(robot: Robot, options: Mapping[str, Any], diagnostics: list[Diagnostic]) -> ServoGroup | None:
    servos = robot.servos
    if "servos" in options:
        return next((group for group in servos if group.name == options["servos"]), None)
    if len(servos) > 1:
        names = ", ".join(group.name for group in servos)
        message = f"pulse_to_rad has room for one servo group, the robot has {names}"
        diagnostics.append(error("robot-model-servos", message, None, "say which one with servos: NAME"))
    return servos[0] if servos else None


def _pulse_to_rad(servos: ServoGroup) -> dict[str, Any]:
    return {
        "joints": list(servos.joints),
        "rad_per_pulse": _number(servos.rad_per_pulse),
        "zero": servos.zero_pulse,
        "flipped": servos.flipped,
    }


def _joint(joint: Joint, rename: Mapping[str, str], diagnostics: list[Diagnostic]) -> dict[str, Any]:
    if joint.mimic is not None:
        message = f"robot_model has no word for mimic: joint {joint.name} stands there as if it moved by itself"
        way_out = "leave the joint out with joints: [...], or let its reader know"
        diagnostics.append(Diagnostic("robot-model-cannot-say", WARNING, message, help=way_out))
    limit = joint.limit if joint.moves else None
    bounds = None if limit is None or limit.lower is None or limit.upper is None else (limit.lower, limit.upper)
    return {
        "type": joint.type,
        "parent": rename.get(joint.parent, joint.parent),
        "child": rename.get(joint.child, joint.child),
        "xyz": _listed(joint.origin.xyz),
        "rpy": _listed(joint.origin.rpy),
        "axis": _listed(joint.axis if joint.moves else (0.0, 0.0, 0.0)),
        "limit": bounds and _listed(bounds),
    }


def _collision(robot: Robot, link: str, diagnostics: list[Diagnostic]) -> tuple[Box | None, list[_Map]]:
    """Return what a link collides with: one box along its axes, or None, and height maps with their stand-in text."""
    maps, solids = [], []
    for shape in robot.link[link].collision:
        if not isinstance(shape.geometry, HeightMap):
            solids.append(shape.in_link)
        elif shape.pose == IDENTITY:
            maps.append((shape.geometry, shape.stand_in))
        else:
            diagnostics.append(_left_out(link, "a height map that is not in the frame of its link"))
    if not solids:
        return None, maps
    geometry = solids[0].geometry
    if len(solids) == 1 and isinstance(geometry, Box) and solids[0].pose == IDENTITY:
        return geometry, maps
    what = f"{len(solids)} shapes" if len(solids) > 1 else f"a {type(geometry).__name__.lower()}"
    turned = " that is turned" if len(solids) == 1 and isinstance(geometry, Box) else ""
    diagnostics.append(_left_out(link, f"{what}{turned}: the format has room for one box along the axes"))
    return None, maps


def _left_out(link: str, what: str) -> Diagnostic:
    message = f"the collision of link {link} is not in robot_model: {what}"
    return Diagnostic("robot-model-cannot-say", WARNING, message, help="the URDF carries it")


def _height_map(frame: str, height_map: HeightMap, stand_in: str) -> dict[str, Any]:
    described: dict[str, Any] = {"frame": frame, "origin_xy": _numbers(height_map.origin)}
    described |= {"cell": _number(height_map.cell), "method": height_map.method}
    if stand_in:
        described["stand_in"] = stand_in
    return described | {"z": [_numbers(row) for row in height_map.heights]}


def _number(value: float) -> float:
    """Return a number as a float, so that it is printed as one; minus zero as zero."""
    return float(value) + 0.0


def _numbers(values: Iterable[float]) -> list[float]:
    return [float(value) + 0.0 for value in values]


_listed = lru_cache(maxsize=20_000)(_numbers)  # many joints share them


def view(robot: Robot, output: Output) -> Robot:
    """Return the robot that the model of an output is meant to contain, under the names of this artifact."""
    return _robot_of(_model(robot, output, []))


def read(text: str) -> Robot:
    """Return the robot that a driver's model contains. Raises ValueError if the text is none."""
    return _robot_of(json_of(text, _no_number))


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a number of JSON")


def _robot_of(model: Mapping[str, Any]) -> Robot:
    shapes: dict[str, list[Shape]] = {}
    try:
        for link, box in model["boxes"].items():
            shapes.setdefault(link, []).append(Shape(Box(_vector(box["min"]), _vector(box["max"]))))
        if "chassis_heightmap" in model:
            grid = model["chassis_heightmap"]
            (x, y), heights = map(float, grid["origin_xy"]), tuple(tuple(map(float, row)) for row in grid["z"])
            height_map = HeightMap((x, y), float(grid["cell"]), heights, 0.0, str(grid["method"]))
            shapes.setdefault(_name(grid["frame"]), []).append(Shape(height_map, stand_in=grid.get("stand_in", "")))
        joints = tuple(_read_joint(name, joint) for name, joint in model["joints"].items())
        servos = model.get("pulse_to_rad")
        groups = () if servos is None else (_servo_group(servos),)
        source = Source(note=str(model["source"]))
    except (KeyError, TypeError, AttributeError, OverflowError) as problem:
        raise ValueError(f"not a driver's model: {problem!r}") from None
    names = dict.fromkeys([*(name for joint in joints for name in (joint.parent, joint.child)), *shapes])
    links = tuple(Link(name, collision=tuple(shapes.get(name, ()))) for name in names)
    return Robot("", links, joints, servos=groups, source=source)


def _name(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{value!r} is no name")
    return value


def _vector(numbers: Iterable[float]) -> Vector:
    x, y, z = map(float, numbers)
    if not math.isfinite(x + y + z):
        raise ValueError("a number is not finite")
    return (x, y, z)


def _read_joint(name: str, joint: Mapping[str, Any]) -> Joint:
    limit = None
    if joint["limit"] is not None:
        lower, upper = map(float, joint["limit"])
        limit = Limit(lower, upper)
    origin = Pose(_vector(joint["xyz"]), _vector(joint["rpy"]))
    parent, child = (_name(joint[end]) for end in ("parent", "child"))
    return Joint(name, _name(joint["type"]), parent, child, origin, _vector(joint["axis"]), limit)


def _servo_group(servos: Mapping[str, Any]) -> ServoGroup:
    names = tuple(map(_name, servos["joints"]))
    rad_per_pulse, zero = float(servos["rad_per_pulse"]), int(servos["zero"])
    return ServoGroup("pulse_to_rad", names, rad_per_pulse, zero, bool(servos["flipped"]), (0, 0))


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find a servo group that does not exist."""
    group, groups = output.options.get("servos"), {group.name for group in case.robot.servos}
    if group is not None and group not in groups:
        message = f'there is no servo group "{group}", asked for by output "{output.name}"'
        help = did_you_mean(group, groups, "name a group")
        yield case.problem("unknown-servo", message, ("outputs", output.name, "servos"), help)


def names(output: Output) -> dict[str, str]:
    """Return the names of links by what an artifact calls them."""
    return {str(new): str(old) for old, new in output.options.get("rename", {}).items()}


def _leaves_out(robot: Robot, link: str) -> bool:
    """Say whether no joint that was asked for has a link."""
    output = FORMAT.output(robot)
    joints = _asked(robot, output) if output else []
    ends = ((robot.joint[name].parent, robot.joint[name].child) for name in joints if name in robot.joint)
    return not any(link in pair for pair in ends)


def _read_robot(opened: Opened) -> Imported:
    from .reading import read_robot_model

    return read_robot_model(opened.path)


FORMAT = Format(
    name="robot_model",
    word="driver's model",
    article="a",
    files="the JSON of a driver",
    about="the model for drivers",
    rank=60,
    covers=(
        *PLACES,
        *("joints.type", "joints.limit.lower", "joints.limit.upper", "links.collision.box.size", "sensors.joint"),
        *("sensors.optical.joint", "servos.flipped", "servos.rad_per_pulse", "servos.zero_pulse"),
    ),
    options={
        "joints": {
            "type": "array",
            "description": "The joints to carry, in this order; default all but those of simulations alone.",
            "items": {"$ref": "#/$defs/name"},
        },
        "rename": {
            "type": "object",
            "description": "Link name: the name it has in this artifact.",
            "additionalProperties": {"$ref": "#/$defs/name"},
        },
        "servos": {
            "$ref": "#/$defs/name",
            "description": "The servo group for pulse_to_rad, where there are several.",
        },
        "source": {
            "type": "string",
            "description": "Text of its key source; default is the note of the robot's source.",
        },
    },
    check=check,
    file="robot_model.json",
    endings=(".json",),
    write=write,
    load=_read_robot,
    view=view,
    read=read,
    include=False,
    lacks=frozenset(
        {
            "mass",
            "visual",
            "effort",
            "velocity",
            "mimic",
            "dynamics",
            "armature",
            "stiffness",
            "simulation",
            "actuator",
            "calibration",
            "safety",
        }
        | {"pose", "sensor", "contact", "publisher", "edge", "urdf_elements", "several shapes", "drive"}
    ),
    leaves_out=_leaves_out,
    why="a driver's model has only the joints that it was asked for",
    names_robot=False,
    syntax=json_of,
    schema="robot_model",
    names=names,
    folder="config",
    deploys=True,
)

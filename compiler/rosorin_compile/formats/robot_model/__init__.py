"""robot_model: the geometry as plain numbers on one line, for a driver that needs no URDF to check its arm for contact.

``schemas/robot_model.schema.json`` says what each value is. Numbers are exact: they read back as the same doubles.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import Box, HeightMap, Joint, Output, Pose, Robot, Shape, Vector
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.model.joint import SEVERAL_COORDINATES
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.rules.case import Case
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, did_you_mean, error
from rosorin_compile.source.memo import remembered
from rosorin_compile.source.rule_registry import FORMATS, Rule

from ..format import Facts, Format, Importing, InRos, Opened, Proving, Value, Writing

if TYPE_CHECKING:
    from ..expectation import Expectation
    from ..facts import Block, Deviations, Sheet
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
_UNITS = {"revolute": "rad", "continuous": "rad", "prismatic": "m"}


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the driver's model of a robot.

    Options: ``joints`` (names, in the order wanted; default all but those of simulations alone), ``rename`` (link
    name: its name in this artifact), ``servos`` (the group for pulse_to_rad, needed if there are several), ``source``
    (default: the robot's source note).
    """
    import json

    options = output.options
    diagnostics = _unknown_names(robot, options)
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
    return json.dumps(model, allow_nan=False) + "\n", diagnostics


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


_listed = remembered(_numbers)  # many joints share them


def read(text: str) -> Facts:
    """Return what a driver's model says. Raises ValueError if the text is none.

    Frames and links have the names that they have in the artifact. Quantities: ``frame CHILD`` has parent, origin x, y,
    z and roll, pitch, yaw; ``joint NAME`` has type, child, axis, lower, upper; ``link NAME`` box min and box max;
    ``height map FRAME`` each cell, counted from 0; ``servo pulse_to_rad`` the calibration.
    """
    from ..facts import Sheet

    return _read(json_of(text, _no_number), Sheet()).facts


def against(text: str, known: Expectation) -> Deviations:
    """Return what a driver's model says that is not known. Raises ValueError if the text is none."""
    from ..facts import Sheet

    model = json_of(text, _no_number)
    return _read(model, Sheet(known)).deviations(model)


def _read(model: Any, sheet: Sheet) -> Sheet:
    try:
        return _model(model, sheet)
    except (KeyError, TypeError, AttributeError, OverflowError) as problem:
        raise ValueError(f"not a driver's model: {problem!r}") from None


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a number of JSON")


def _model(model: Mapping[str, Any], sheet: Sheet) -> Sheet:
    sheet.take("robot", "robot", "source", Value(str(model["source"])))
    for name, value in model.get("pulse_to_rad", {}).items():
        unit = "rad" if name == "rad_per_pulse" else ""
        text = ", ".join(value) if name == "joints" else str(value).lower()
        is_number = name in ("rad_per_pulse", "zero")
        sheet.take("servo", "pulse_to_rad", name, Value(float(value) if is_number else text, unit))
    for name, joint in model["joints"].items():
        _read_joint(sheet, name, joint)
    for link, box in model["boxes"].items():
        corners = tuple(box["min"]), tuple(box["max"])
        sheet.add_box(sheet.named(link), *sheet.once(("corners", *corners), partial(_corners, sheet, *corners)))
    if "chassis_heightmap" in model:
        _read_height_map(sheet, model["chassis_heightmap"])
    return sheet


def _floats(sheet: Sheet, numbers: Iterable[float]) -> list[float]:
    """Return numbers as floats; of what is known all have to be finite. Raises ValueError, TypeError."""
    made = list(map(float, numbers))
    if sheet.known is not None and not all(map(math.isfinite, made)):
        raise ValueError("a number is not finite")
    return made


def _corners(sheet: Sheet, lower: Iterable[float], upper: Iterable[float]) -> tuple[Vector, Vector]:
    (a, b, c), (d, e, f) = _floats(sheet, lower), _floats(sheet, upper)
    return (a, b, c), (d, e, f)


def _read_joint(sheet: Sheet, name: str, joint: Mapping[str, Any]) -> None:
    child, kind = sheet.named(joint["child"]), joint["type"]
    sheet.add_parent(child, sheet.named(joint["parent"]))
    place = tuple(joint["xyz"]), tuple(joint["rpy"])
    sheet.add_pose(child, sheet.once(place, lambda: _pose(sheet, *place)))
    limit = joint["limit"]
    key = (kind, tuple(joint["axis"]), None if limit is None else tuple(limit))
    sheet.add_joint(name, child, sheet.once(key, lambda: _motion(kind, joint)))


def _pose(sheet: Sheet, xyz: Iterable[float], rpy: Iterable[float]) -> Pose:
    (x, y, z), (roll, pitch, yaw) = (_floats(sheet, _numbers(numbers)) for numbers in (xyz, rpy))
    return Pose((x, y, z), (roll, pitch, yaw))


def _motion(kind: str, joint: Mapping[str, Any]) -> Block:
    """Return what is said of a joint but where it sits."""
    from ..facts import AXES

    said: dict[str, Value] = {"type": Value(kind)}
    if kind in _UNITS:
        said |= _vector([f"axis {axis}" for axis in AXES], joint["axis"], "")
    if joint["limit"] is not None:
        said |= _vector(("lower", "upper"), joint["limit"], _UNITS.get(kind, ""))
    return said


def _read_height_map(sheet: Sheet, described: Mapping[str, Any]) -> None:
    frame = sheet.named(described["frame"])
    said = _vector(("origin x", "origin y"), described["origin_xy"], "m")
    said |= _vector(("cell",), [described["cell"]], "m")
    said |= {key: Value(described[key]) for key in ("method", "stand_in") if key in described}
    for i, row in enumerate(described["z"]):
        row = _floats(sheet, row)
        if sheet.known is None:  # nothing is known of a cell
            said |= _vector([f"cell {i} {j}" for j in range(len(row))], row, "m")
    for quantity, value in said.items():
        sheet.take("height map", frame, quantity, value)


def _vector(quantities: Iterable[str], numbers: Iterable[float], unit: str) -> dict[str, Value]:
    pairs = zip(quantities, numbers, strict=True)
    return {quantity: Value(float(number), unit) for quantity, number in pairs}


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


def _solids(robot: Robot, link: str, output: Output, carried: frozenset[str]) -> list[Shape]:  # noqa: ARG001
    return [shape for shape in robot.link[link].collision if not isinstance(shape.geometry, HeightMap)]


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
    facts=read,
    reading=Importing(
        include=False,
    ),
    writing=Writing(
        says=("servos",),
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
    ),
    proving=Proving(
        against=against,
        syntax=json_of,
        schema="robot_model",
        solids=_solids,
        names=names,
    ),
    ros=InRos(
        folder="config",
        deploys=True,
    ),
)

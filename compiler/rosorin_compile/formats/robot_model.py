"""robot_model: JSON with joints and collision boxes, for a driver that checks its arm for collisions without a URDF.

``schemas/robot_model.schema.json`` defines each value. Numbers are exact: they read back as the same doubles. A file
can also be imported: it has joints, one box per link, a height map and the calibration of servos, but no masses.
"""

import json
import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from rosorin_compile.language.annotations import misfits_of, validator, words_of
from rosorin_compile.language.lower import LoweringError, record_of
from rosorin_compile.language.schema import subject
from rosorin_compile.language.sections.links import lower_shape
from rosorin_compile.model import Box, HeightMap, Joint, Link, Output, Robot, Shape
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.model.joint import SEVERAL_COORDINATES
from rosorin_compile.model.link import Source as Provenance
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, Suggestion, error
from rosorin_compile.source.load import json_of
from rosorin_compile.source.wording import mask_controls, phrase

from .format import PLACES, Format, ImportFile
from .imported_robot import ImportedRobot, as_tree
from .robot_files import accept
from .templating import Templates

_ANY_PULSE = (-(10**9), 10**9)
_RANGE_NOTE = "the driver's model does not say which pulses exist; these are those between the limits"


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the JSON of a robot, and diagnostics. Options: ``joints``, ``rename``, ``servos``, ``source``."""
    model, diagnostics = _model(robot, output)
    return json.dumps(model, allow_nan=False) + "\n", diagnostics


def _model(robot: Robot, output: Output) -> tuple[dict[str, Any], list[Diagnostic]]:
    options, diagnostics, groups = output.options, list[Diagnostic](), {group.name: group for group in robot.servos}

    def cannot_say(message: str, help: str) -> None:
        diagnostics.append(Diagnostic("robot-model-cannot-say", WARNING, message, help=help))

    rename: Mapping[str, str] = options.get("rename", {})
    named: list[tuple[str, str, Collection[str]]] = [("joint", one, robot.joint) for one in options.get("joints", ())]
    for kind, name, known in (*named, *(("link", name, robot.link) for name in rename)):
        if name not in known:
            message = f'there is no {kind} "{name}"'
            diagnostics.append(error("robot-model-unknown-name", message, None, Suggestion(name, known)))
    joints = []
    for joint in _requested(robot, output):
        if joint.type in SEVERAL_COORDINATES:
            message = f'robot_model cannot express the {joint.type} joint "{joint.name}", which is left out'
            cannot_say(message, "let its reader know how the two parts of the robot hang together")
            continue
        joints.append(joint)
        if joint.mimic is not None:
            message = f'robot_model cannot express "mimic": joint "{joint.name}" is written as an independent joint'
            cannot_say(message, 'leave the joint out with "joints: [...]", or compute its position in your program')
    links = dict.fromkeys([*(joint.child for joint in joints), *(joint.parent for joint in joints)]) or [robot.root]
    renamed: dict[str, str] = {}
    for link in links:
        name = rename.get(link, link)
        if name in renamed:
            message = f'links "{renamed[name]}" and "{link}" would both be called "{name}" in this artifact'
            diagnostics.append(error("robot-model-same-name", message, None, 'use another name in "rename"'))
        renamed[name] = link
    if len(groups) > 1 and "servos" not in options:
        message = f"pulse_to_rad can only contain one servo group, but the robot has {phrase(groups)}"
        diagnostics.append(error("robot-model-servos", message, None, 'choose one with "servos: NAME"'))
    servos = groups.get(options.get("servos", next(iter(groups), "")))
    model: dict[str, Any] = {"source": options.get("source", robot.source.note)}
    if servos is not None:
        calibration = {"joints": list(servos.joints), "rad_per_pulse": float(servos.rad_per_pulse) + 0.0}
        model["pulse_to_rad"] = {**calibration, "zero": servos.zero_pulse, "flipped": servos.flipped}
    model |= {"joints": {}, "boxes": {}}
    for joint in joints:
        limit, axis = (joint.limit, joint.axis) if joint.moves else (None, (0.0, 0.0, 0.0))
        ends = {"parent": rename.get(joint.parent, joint.parent), "child": rename.get(joint.child, joint.child)}
        place = {"xyz": _numbers(joint.origin.xyz), "rpy": _numbers(joint.origin.rpy), "axis": _numbers(axis)}
        bounds = (None,) if limit is None else (limit.lower, limit.upper)
        limits = {"limit": None if None in bounds else _numbers(bounds)}
        model["joints"][joint.name] = {"type": joint.type, **ends, **place, **limits}
    for name, link in renamed.items():
        problem, solids = "", list[Shape]()
        for shape in robot.link[link].collision:
            grid = shape.geometry
            if not isinstance(grid, HeightMap):
                solids.append(shape.in_link)
            elif shape.pose != IDENTITY:
                problem = "a height map that is not in the frame of its link"
            elif "chassis_heightmap" in model:
                problem = "a second height map: the format has room for one"
            else:
                described = {"frame": name, "origin_xy": _numbers(grid.origin), "cell": float(grid.cell) + 0.0}
                described |= {"method": grid.method, **({"stand_in": shape.stand_in} if shape.stand_in else {})}
                model["chassis_heightmap"] = {**described, "z": [_numbers(row) for row in grid.heights]}
        box = solids[0].geometry if len(solids) == 1 else None
        if isinstance(box, Box) and solids[0].pose == IDENTITY:
            model["boxes"][name] = {"min": _numbers(box.lower), "max": _numbers(box.upper)}
        elif solids:
            what = f"a {type(box).__name__.lower()}" if box else f"{len(solids)} shapes"
            what += " that is turned" if isinstance(box, Box) else ""
            problem = f"{what}: the format has room for one box along the axes"
        if problem:
            cannot_say(f"the collision of link {link} is not in robot_model: {problem}", "the URDF carries it")
    return model, diagnostics


def _requested(robot: Robot, output: Output) -> list[Joint]:
    real = [joint.name for joint in robot.joints if joint.child not in robot.simulated_frames]
    return [robot.joint[name] for name in output.options.get("joints", real) if name in robot.joint]


def _numbers(values: Iterable[Any]) -> list[float]:
    """Convert numbers to floats, so that JSON has decimal points, and replace minus zero with zero."""
    return [float(value) + 0.0 for value in values]


def view(robot: Robot, output: Output) -> Robot:
    """Return a robot with the values and names that the artifact must contain."""
    return _robot_of(_model(robot, output)[0])


def read(text: str) -> Robot:
    """Parse a generated robot_model. Raises ValueError if it is damaged."""
    model = _finite_json(text)
    try:
        return _robot_of(model)
    except (AttributeError, KeyError, LoweringError, TypeError, ValueError) as problem:
        wrong = (f"not a driver's model: {words_of(misfit)}" for misfit in misfits_of(validator("robot_model"), model))
        raise ValueError(next(wrong, str(problem))) from None  # report only the first violation


def _finite_json(text: str) -> Any:
    model = json_of(text)
    try:
        json.dumps(model, allow_nan=False)
    except ValueError:
        raise ValueError("a number is not finite") from None
    return model


def _robot_of(model: Mapping[str, Any]) -> Robot:
    entries, joints, links = _description(model, model["source"]), list[Joint](), list[Link]()
    for name, joint in entries["joints"].items():  # the JSON has an axis even for fixed joints
        joints.append(record_of(Joint, {**joint, "axis": model["joints"][name]["axis"]}, name=name))
    for name, link in sorted(entries["links"].items()):
        shapes, accepts = link.get("collision", ()), lambda _: True
        solids = (lower_shape(one, (), accepts, one.get("source", {}).get("note", "")) for one in shapes)
        links.append(Link(name, collision=tuple(solids)))
    groups = entries.get("servos", {}).items()  # the file does not contain the range of pulses
    servos = tuple(record_of(ServoGroup, group, name=name, pulse_range=_ANY_PULSE) for name, group in groups)
    return Robot("robot", tuple(links), tuple(joints), source=Provenance(note=model["source"]), servos=servos)


def _load(opened: ImportFile) -> ImportedRobot:
    source, path = opened.source, opened.path
    start, wrong, tree = Span(source, 1, 1), list[Diagnostic](), None
    try:
        model = _finite_json(source.text)
    except ValueError as problem:
        place = Span(source, problem.lineno, problem.colno) if isinstance(problem, json.JSONDecodeError) else start
        message = f"not JSON: {problem.msg if isinstance(problem, json.JSONDecodeError) else problem}"
        return ImportedRobot(None, [error("json-syntax", message, place, "correct it")], files=(path,))
    for misfit in misfits_of(validator("robot_model"), model):
        message = f"not a driver's model: {subject(misfit.path) if misfit.path else 'the file'}: {words_of(misfit)}"
        wrong.append(error("wrong-format", message, start, "the file is to fit schemas/robot_model.schema.json"))
    if not wrong:  # lenient, because the format lacks the required limits of effort and velocity
        note = f"from {mask_controls(path.name)}: {model['source']}".removesuffix(": ")
        tree, wrong = accept(as_tree(_description(model, note, path.stem), start), lenient=True)
    return ImportedRobot(tree, wrong, files=(path,))


def _description(model: Mapping[str, Any], note: str, robot: str = "robot") -> dict[str, Any]:
    links: dict[str, dict[str, Any]] = {}
    joints: dict[str, dict[str, Any]] = {}
    for name, entry in model["joints"].items():
        joints[name] = {key: entry[key] for key in ("type", "parent", "child", "xyz", "rpy")}
        if entry["type"] != "fixed":
            limit = entry["limit"] and {"limit": dict(zip(("lower", "upper"), entry["limit"], strict=True))}
            joints[name] |= {"axis": entry["axis"], **(limit or {})}
        links |= {entry[end]: {} for end in ("parent", "child")}
    shapes = [(name, {"box": {"min": box["min"], "max": box["max"]}}) for name, box in model["boxes"].items()]
    if "chassis_heightmap" in model:
        found = model["chassis_heightmap"]
        names = {"origin": "origin_xy", "cell": "cell", "heights": "z", "method": "method"}
        grid = {key: found[name] for key, name in names.items() if key != "method" or found[name]}
        source = {"source": {"status": "stand_in", "note": found["stand_in"]}} if "stand_in" in found else {}
        shapes.append((found["frame"], {"height_map": grid, **source}))
    for name, shape in shapes:
        links.setdefault(name, {}).setdefault("collision", []).append(shape)
    sections = {"robot": robot, "source": {"status": "imported", "note": note}, "links": links, "joints": joints}
    if "pulse_to_rad" in model:  # the range of pulses follows from the joint limits
        entry = model["pulse_to_rad"]
        bounds = [value for name in entry["joints"] for value in (joints.get(name, {}).get("limit") or {}).values()]
        rad, zero = float(entry["rad_per_pulse"]), int(entry["zero"])
        reach = [bound / rad for bound in bounds or (-math.pi, math.pi)] if rad else [1.0]
        pulses = sorted(zero + (-pulse if entry["flipped"] else pulse) for pulse in [0.0, *reach])
        group = {key: entry[key] for key in ("joints", "rad_per_pulse", "flipped")} | {"zero_pulse": entry["zero"]}
        group["pulse_range"] = [math.floor(pulses[0]), math.ceil(pulses[-1])]
        sections["servos"] = {"pulse_to_rad": {**group, "source": {"status": "stand_in", "note": _RANGE_NOTE}}}
    return sections


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield an error if the option ``servos`` is not a servo group of the robot."""
    group, groups = output.options.get("servos"), {group.name for group in case.robot.servos}
    if group is not None and group not in groups:
        message = f'there is no servo group "{group}", which output "{output.name}" uses'
        help = Suggestion(group, groups, "name a group")
        yield case.problem("unknown-servo", message, ("outputs", output.name, "servos"), help)


def _leaves_out(robot: Robot, link: str) -> bool:
    output = FORMAT.output(robot)
    return output is None or not any(link in (one.parent, one.child) for one in _requested(robot, output))


_NAME = {"$ref": "#/$defs/name"}
_JOINTS = "Joints to write, in this order; default: all except simulation-only joints."
_RENAME = "Link names, mapped to artifact names."
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
        "joints": {"type": "array", "items": _NAME, "description": _JOINTS},
        "rename": {"type": "object", "additionalProperties": _NAME, "description": _RENAME},
        "servos": {**_NAME, "description": "Servo group for pulse_to_rad; required if there are several."},
        "source": {"type": "string", "description": "Value of the key source; default: note of the robot's source."},
    },
    check=check,
    file="robot_model.json",
    endings=(".json",),
    write=write,
    load=_load,
    view=view,
    read=read,
    include=False,
    leaves_out=_leaves_out,
    why="a driver's model has only the joints that it was asked for",
    names_robot=False,
    syntax=json_of,
    schema="robot_model",
    names=lambda output: {str(new): str(old) for old, new in output.options.get("rename", {}).items()},
    folder="config",
    deploys=True,
)

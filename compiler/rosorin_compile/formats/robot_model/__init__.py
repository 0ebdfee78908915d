"""robot_model: the geometry as plain numbers on one line, for a driver that needs no URDF to check its arm for contact.

``schemas/robot_model.schema.json`` says what each value is. Numbers are exact: they read back as the same doubles.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import Box, HeightMap, Joint, Output, Robot, Shape
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.model.joint import SEVERAL_COORDINATES
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Suggestion, error
from rosorin_compile.source.load import json_of
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


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the driver's model of a robot.

    Options: ``joints`` (names, in their order; default all but those of simulations alone), ``rename`` (link name: its
    name in this artifact), ``servos`` (the group for pulse_to_rad, needed if there are several), ``source`` (default:
    the robot's source note).
    """
    import json

    model, diagnostics = _model(robot, output)
    return json.dumps(model, allow_nan=False) + "\n", diagnostics


def _model(robot: Robot, output: Output) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Return the driver's model as a value of JSON, and diagnostics."""
    options, diagnostics = output.options, list(_unknown_names(robot, output.options))
    rename: Mapping[str, str] = options.get("rename", {})
    joints = []
    for joint in _requested(robot, output):
        if joint.type in SEVERAL_COORDINATES:
            message = f"robot_model has no word for {joint.type}: joint {joint.name} is left out"
            diagnostics.append(_cannot_say(message, "let its reader know how the two parts of the robot hang together"))
            continue
        joints.append(joint)
        if joint.mimic is not None:
            message = f"robot_model has no word for mimic: joint {joint.name} is written as if it moved by itself"
            diagnostics.append(_cannot_say(message, "leave the joint out with joints: [...], or let its reader know"))
    links = dict.fromkeys([*(joint.child for joint in joints), *(joint.parent for joint in joints)]) or [robot.root]
    renamed: dict[str, str] = {}
    for link in links:
        name = rename.get(link, link)
        if name in renamed:
            message = f'links {renamed[name]} and {link} would both be called "{name}" in this artifact'
            diagnostics.append(error("robot-model-same-name", message, None, "rename one of them to another name"))
        renamed[name] = link
    servos = next((one for one in robot.servos if options.get("servos", one.name) == one.name), None)
    if len(robot.servos) > 1 and "servos" not in options:
        names = ", ".join(group.name for group in robot.servos)
        message = f"pulse_to_rad has room for one servo group, the robot has {names}"
        diagnostics.append(error("robot-model-servos", message, None, "say which one with servos: NAME"))
    model: dict[str, Any] = {"source": options.get("source", robot.source.note)}
    if servos is not None:
        calibration = {"joints": list(servos.joints), "rad_per_pulse": float(servos.rad_per_pulse) + 0.0}
        model["pulse_to_rad"] = {**calibration, "zero": servos.zero_pulse, "flipped": servos.flipped}
    model["joints"] = {joint.name: _joint(joint, rename) for joint in joints}
    model["boxes"] = {}
    for name, link in renamed.items():
        problem = _add_collision(model, name, robot.link[link].collision)
        if problem:
            message = f"the collision of link {link} is not in robot_model: {problem}"
            diagnostics.append(_cannot_say(message, "the URDF carries it"))
    return model, diagnostics


def _cannot_say(message: str, help: str) -> Diagnostic:
    return Diagnostic("robot-model-cannot-say", WARNING, message, help=help)


def _requested(robot: Robot, output: Output) -> list[Joint]:
    """Return the joints to carry, by default all but those of simulations alone."""
    real = [joint.name for joint in robot.joints if joint.child not in robot.simulated_frames]
    return [robot.joint[name] for name in output.options.get("joints", real) if name in robot.joint]


def _unknown_names(robot: Robot, options: Mapping[str, Any]) -> Iterator[Diagnostic]:
    servos = [options["servos"]] if "servos" in options else []
    kinds: dict[str, tuple[Iterable[str], Collection[str]]] = {
        "joint": (options.get("joints", ()), robot.joint),
        "link": (options.get("rename", {}), robot.link),
        "servo group": (servos, {group.name for group in robot.servos}),
    }
    for kind, (names, known) in kinds.items():
        for name in names:
            if name not in known:
                message = f'there is no {kind} "{name}"'
                yield error("robot-model-unknown-name", message, None, Suggestion(name, known))


def _joint(joint: Joint, rename: Mapping[str, str]) -> dict[str, Any]:
    limit = joint.limit if joint.moves else None
    bounds = None if limit is None or limit.lower is None or limit.upper is None else (limit.lower, limit.upper)
    return {
        "type": joint.type,
        "parent": rename.get(joint.parent, joint.parent),
        "child": rename.get(joint.child, joint.child),
        "xyz": _numbers(joint.origin.xyz),
        "rpy": _numbers(joint.origin.rpy),
        "axis": _numbers(joint.axis if joint.moves else (0.0, 0.0, 0.0)),
        "limit": _numbers(bounds) if bounds else None,
    }


def _add_collision(model: dict[str, Any], link: str, shapes: Sequence[Shape]) -> str:
    """Add the box along the axes and the height map of a link to a model. Return why a shape is left out, or ""."""
    problem, solids = "", []
    for shape in shapes:
        grid = shape.geometry
        if not isinstance(grid, HeightMap):
            solids.append(shape.in_link)
        elif shape.pose != IDENTITY:
            problem = "a height map that is not in the frame of its link"
        elif "chassis_heightmap" in model:
            problem = "a second height map: the format has room for one"
        else:
            described = {"frame": link, "origin_xy": _numbers(grid.origin), "cell": float(grid.cell) + 0.0}
            described |= {"method": grid.method, **({"stand_in": shape.stand_in} if shape.stand_in else {})}
            model["chassis_heightmap"] = {**described, "z": [_numbers(row) for row in grid.heights]}
    if solids:
        geometry, is_turned = solids[0].geometry, solids[0].pose != IDENTITY
        if len(solids) == 1 and isinstance(geometry, Box) and not is_turned:
            model["boxes"][link] = {"min": _numbers(geometry.lower), "max": _numbers(geometry.upper)}
            return problem
        what = f"{len(solids)} shapes" if len(solids) > 1 else f"a {type(geometry).__name__.lower()}"
        what += " that is turned" if len(solids) == 1 and isinstance(geometry, Box) else ""
        problem = f"{what}: the format has room for one box along the axes"
    return problem


def _numbers(values: Iterable[Any]) -> list[float]:
    """Return numbers as floats, so that they are printed as such; minus zero as zero."""
    return [float(value) + 0.0 for value in values]


def view(robot: Robot, output: Output) -> Robot:
    """Return the robot that the model of an output must contain, under the names of this artifact."""
    from .reading import robot_of

    return robot_of(_model(robot, output)[0])


def read(text: str) -> Robot:
    """Return the robot that a driver's model contains. Raises ValueError if the text is none."""
    from .reading import read

    return read(text)


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find a servo group that does not exist."""
    group, groups = output.options.get("servos"), {group.name for group in case.robot.servos}
    if group is not None and group not in groups:
        message = f'there is no servo group "{group}", asked for by output "{output.name}"'
        help = Suggestion(group, groups, "name a group")
        yield case.problem("unknown-servo", message, ("outputs", output.name, "servos"), help)


def _names(output: Output) -> dict[str, str]:
    """Return the names of links by their names in an artifact."""
    return {str(new): str(old) for old, new in output.options.get("rename", {}).items()}


def _leaves_out(robot: Robot, link: str) -> bool:
    """Return True if no requested joint has a link."""
    output = FORMAT.output(robot)
    return output is None or not any(link in (one.parent, one.child) for one in _requested(robot, output))


def _load(opened: Opened) -> Imported:
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
        "servos": {"$ref": "#/$defs/name", "description": "The servo group for pulse_to_rad, where there are several."},
        "source": {
            "type": "string",
            "description": "Text of its key source; default is the note of the robot's source.",
        },
    },
    check=check,
    file="robot_model.json",
    endings=(".json",),
    write=write,
    load=_load,
    view=view,
    read=read,
    include=False,
    lacks=frozenset(
        {"mass", "visual", "effort", "velocity", "mimic", "dynamics", "armature", "stiffness", "simulation", "actuator"}
        | {"calibration", "safety", "pose", "sensor", "contact", "publisher", "edge", "urdf_elements", "drive"}
        | {"several shapes"}
    ),
    leaves_out=_leaves_out,
    why="a driver's model has only the joints that it was asked for",
    names_robot=False,
    syntax=json_of,
    schema="robot_model",
    names=_names,
    folder="config",
    deploys=True,
)

"""MJCF, the format of MuJoCo.

Writing: ``write`` and ``write_elements`` format the file. ``servos`` collects the actuators, ``bodies`` assigns names
and groups, ``contacts`` computes contact pairs and excludes. ``read_back`` parses a generated file.

Importing: MuJoCo loads the file in a child process (``process``, ``engine``), which also compares the result with the
source (``compare_models``). ``robot``, ``links`` and ``shapes`` create the description (state: ``import_state``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats import format
from rosorin_compile.formats.format import Format, OutputEntry, Unsupported, xml_syntax

if TYPE_CHECKING:
    from rosorin_compile.model import Robot
    from rosorin_compile.source.tree import Map


def _lazy(module: str, name: str) -> Callable[..., Any]:
    return lambda *arguments: getattr(import_module(module, __package__), name)(*arguments)


def _adds(robot: Robot, name: str, described: Robot) -> bool:
    """Return True if link ``name`` of an imported MJCF is only the site or camera of a sensor in ``described``."""
    link, joint = robot.link[name], robot.joint_to.get(name)
    if link.inertial or link.visual or link.collision or joint is None or not joint.is_fixed:
        return False
    made = [element for sensor in described.sensors for element in sensor.simulated]
    return any(name in (one.name, one.site) or (one.replicas and name.startswith(f"{one.name}_")) for one in made)


FILE = r'<(?:mesh|texture|hfield)\b[^<>]*?\bfile="([^"]*)"'


def _asked(tree: Map, version: str, name: str) -> OutputEntry:  # noqa: ARG001
    options = (tree.get("outputs") or {}).get("mjcf") or {}  # options in the imported MJCF, such as a free base
    usual = {"integrator": "Euler"}  # the default of MuJoCo, also for a URDF
    option = {} if "drives" in options else {"option": options.get("option", usual)}
    return OutputEntry({"file": "", **options, **option} | {"file": f"{name}.xml"})


def _one_of(words: Sequence[str], description: str) -> dict[str, Any]:
    return {"enum": [*words], "description": description}


_SOLVERS = {"": "constraint solver", "ls_": "line search", "noslip_": "noslip solver", "ccd_": "collision solver"}
_NUMBER, _COUNT, _NUMBERS = {"type": "number"}, {"type": "integer"}, {"type": "array", "items": {"type": "number"}}
_VECTOR, _SOME = {**_NUMBERS, "minItems": 3, "maxItems": 3}, {**_NUMBERS, "minItems": 1}
_SWITCH = {"enum": ["enable", "disable"]}
_SETTINGS: Mapping[str, tuple[Mapping[str, Any], str]] = {
    "integrator": ({"enum": ["Euler", "RK4", "implicit", "implicitfast"]}, "Numerical integrator."),
    "cone": ({"enum": ["pyramidal", "elliptic"]}, "Type of friction cone."),
    "jacobian": ({"enum": ["dense", "sparse", "auto"]}, "Storage of the constraint Jacobian."),
    "solver": ({"enum": ["PGS", "CG", "Newton"]}, "Constraint solver."),
    "timestep": (_NUMBER, "Time step in s."),
    "impratio": (_NUMBER, "Ratio of frictional to normal constraint impedance."),
    **{f"{of}tolerance": (_NUMBER, f"Tolerance of the {what}.") for of, what in _SOLVERS.items()},
    "density": (_NUMBER, "Density of the surrounding medium in kg/m^3."),
    "viscosity": (_NUMBER, "Viscosity of the surrounding medium in Pa*s."),
    "o_margin": (_NUMBER, "Margin of all contacts in m, if the flag override is enabled."),
    **{f"{of}iterations": (_COUNT, f"Maximum iterations: {what}.") for of, what in {**_SOLVERS, "sdf_": "SDF"}.items()},
    "sdf_initpoints": (_COUNT, "Number of initial points for SDF collisions."),
    "gravity": (_VECTOR, "Gravitational acceleration in m/s^2."),
    "wind": (_VECTOR, "Velocity of the surrounding medium in m/s."),
    "magnetic": (_VECTOR, "Global magnetic field, for magnetometers."),
    "sleep_tolerance": (_NUMBER, "Velocity in m/s or rad/s below which bodies may sleep."),
    "o_solref": ({**_SOME, "maxItems": 2}, "Parameter solref of all contacts, if the flag override is enabled."),
    "o_solimp": ({**_SOME, "maxItems": 5}, "Parameter solimp of all contacts, if the flag override is enabled."),
    "o_friction": ({**_SOME, "maxItems": 5}, "Friction of all contacts, if the flag override is enabled."),
    "actuatorgroupdisable": ({"type": "array", "items": _COUNT}, "Actuator groups to disable."),
    "flag": ({"type": "object", "additionalProperties": _SWITCH}, "Features of the simulation to enable or disable."),
}
SETTINGS = {word: {**form, "description": what} for word, (form, what) in _SETTINGS.items()}
"""The attributes of MuJoCo's <option> (in SI units) that a description can set, as a JSON schema."""

_NAMES = {"type": "array", "items": {"type": "string"}}
_GROUP = {"type": "integer", "minimum": 0, "maximum": 5}
_VISUAL = {**_GROUP, "description": "Group of visual geoms; default: 2."}
_COLLISION = {**_GROUP, "description": "Group of collision geoms; default: 3, or 0 for a robot without visuals."}
_OPTIONS = {
    "number_format": format.NUMBER_FORMAT,
    "base": _one_of(("fixed", "free"), "Type of base; default: free if the robot has a drive, otherwise fixed."),
    "option": {
        "type": "object",
        "description": "Attributes of MuJoCo's <option>, in SI units; default: integrator implicitfast; with a floating"
        " base or a drive also cone elliptic, and with rollers or feet impratio 100.",
        "properties": SETTINGS,
        "additionalProperties": False,
    },
    "visuals": _one_of(
        ("own", "from_collision"),
        "Visuals of links that have none; own: no visuals; from_collision: the collision shapes, with a colour per"
        " link; default: from_collision if no link has a visual, otherwise own.",
    ),
    "mesh_inertia": _one_of(
        ("convex", "exact", "legacy", "shell"),
        "How MuJoCo computes mesh inertia, if a mesh does not set it; default: shell, also for thin or open meshes.",
    ),
    "height_maps": _one_of(
        (*format.FORMS_OF_BOXES, "hfield"),
        f"Geoms of a height map; {format.BOXES_OF_HEIGHT_MAPS}; hfield: a height field, which does not collide with"
        " planes; default: merged.",
    ),
    "contacts": _one_of(
        ("implied", "described"),
        "Link pairs without contacts; implied: links that share a joint, links that always touch, and"
        " disabled_contacts; described: only disabled_contacts; default: implied.",
    ),
    "groups": {
        "type": "object",
        "description": "Geom groups, which viewers can show and hide.",
        "properties": {"visual": _VISUAL, "collision": _COLLISION},
        "additionalProperties": False,
    },
    "actuators": {**_NAMES, "description": "Order of the actuators, by name; default: the order of their joints."},
    "sensors": {
        **_NAMES,
        "description": "Order of the sensors, by name; default: entries of `sensors`, then of `mjcf`.",
    },
    "drives": _one_of(
        ("position", "velocity", "none"),
        "Servos for joints without actuators, with gains estimated from the load; position: position servos for joints"
        " with limits and velocity servos for others; velocity: velocity servos for all; default: none.",
    ),
}
_NO_JOINT = Unsupported("bodies that are fixed to each other need no joint", quiet=True)
_UNSUPPORTED = {
    **format.OF_PUBLISHERS,
    "sensors.*.joint": _NO_JOINT,
    "sensors.*.optical.joint": _NO_JOINT,
    "joints.*.calibration": Unsupported("no calibration of joints"),
    "joints.*.safety_controller": Unsupported("no soft limits"),
    "joints.*.limit.velocity": Unsupported("it only affects drives", one_way=True),
    "root": Unsupported("worlds are not read", one_way=True),
}

FORMAT = Format(
    name="mjcf",
    word="MJCF",
    about="the model for MuJoCo",
    rank=30,
    covers=(*format.MODEL_KEYS, "poses", "mjcf"),
    unsupported=_UNSUPPORTED,
    options=_OPTIONS,
    file="{}.xml",
    endings=(".xml", ".mjcf"),
    roots=("mujoco",),
    check=_lazy(".contacts", "check"),
    write=_lazy(".write", "write"),
    load=lambda opened: _lazy(".robot", "read_mjcf")(opened.path, opened.options),
    view=_lazy(".read_back", "view"),
    partial=True,
    read=_lazy(".read_back", "read"),
    asked=_asked,
    optional=True,
    adds=_adds,
    why="a simulation has sites and cameras of its own for the sensors of a description",
    beside=lambda text: re.findall(FILE, text),
    opens=_lazy(".unsupported", "file_path"),
    copies=_lazy("..mesh_copies", "copy_meshes"),
    syntax=xml_syntax,
    refusal=_lazy(".process", "refusal"),
    prove=_lazy(".process", "prove"),
    engine_reads=True,
    folder="mjcf",
)

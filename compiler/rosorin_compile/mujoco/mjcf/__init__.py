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


FILE = re.compile(r'<(?:mesh|texture|hfield)\b[^<>]*?\bfile="([^"]*)"')


def _asked(tree: Map, version: str, name: str) -> OutputEntry:  # noqa: ARG001
    options = (tree.get("outputs") or {}).get("mjcf") or {}  # options in the imported MJCF, such as a free base
    usual = {"integrator": "Euler"}  # the default of MuJoCo, also for a URDF
    option = {} if "drives" in options else {"option": options.get("option", usual)}
    return OutputEntry({"file": "", **options, **option} | {"file": f"{name}.xml"})


def _one_of(words: Sequence[str], description: str) -> dict[str, Any]:
    return {"enum": [*words], "description": description}


_SOLVERS = {"": "the solver", "ls_": "a line search", "noslip_": "noslip", "ccd_": "ccd"}
_NUMBER, _COUNT, _NUMBERS = {"type": "number"}, {"type": "integer"}, {"type": "array", "items": {"type": "number"}}
_VECTOR, _SOME = {**_NUMBERS, "minItems": 3, "maxItems": 3}, {**_NUMBERS, "minItems": 1}
_SWITCH = {"enum": ["enable", "disable"]}
_SETTINGS: Mapping[str, tuple[Mapping[str, Any], str]] = {
    "integrator": ({"enum": ["Euler", "RK4", "implicit", "implicitfast"]}, "How time goes on."),
    "cone": ({"enum": ["pyramidal", "elliptic"]}, "The form of friction cones."),
    "jacobian": ({"enum": ["dense", "sparse", "auto"]}, "How the solver keeps its matrices."),
    "solver": ({"enum": ["PGS", "CG", "Newton"]}, "What solves for the forces of contacts and limits."),
    "timestep": (_NUMBER, "One step of time in s."),
    "impratio": (_NUMBER, "How hard friction is against normal forces."),
    **{f"{of}tolerance": (_NUMBER, f"When {what} is done.") for of, what in _SOLVERS.items()},
    "density": (_NUMBER, "Density of the air or water around, in kg/m^3."),
    "viscosity": (_NUMBER, "Viscosity of the air or water around, in Pa*s."),
    "o_margin": (_NUMBER, "Margin of all contacts in m, where contacts are overridden."),
    **{f"{of}iterations": (_COUNT, f"Most steps of {what}.") for of, what in {**_SOLVERS, "sdf_": "sdf"}.items()},
    "sdf_initpoints": (_COUNT, "Where sdf begins, how often."),
    "gravity": (_VECTOR, "Gravity in m/s^2."),
    "wind": (_VECTOR, "Speed of the air in m/s."),
    "magnetic": (_VECTOR, "The magnetic field of the earth."),
    "sleep_tolerance": (_NUMBER, "Below which speed in m/s or rad/s what is at rest may sleep."),
    "o_solref": ({**_SOME, "maxItems": 2}, "Stiffness of all contacts, where contacts are overridden."),
    "o_solimp": ({**_SOME, "maxItems": 5}, "Impedance of all contacts, where contacts are overridden."),
    "o_friction": ({**_SOME, "maxItems": 5}, "Friction of all contacts, where contacts are overridden."),
    "actuatorgroupdisable": ({"type": "array", "items": _COUNT}, "The groups of actuators that are switched off."),
    "flag": ({"type": "object", "additionalProperties": _SWITCH}, "What is computed, and what not."),
}
SETTINGS = {word: {**form, "description": what} for word, (form, what) in _SETTINGS.items()}
"""The attributes of MuJoCo's <option> (in SI units) that a description can set, as a JSON schema."""

_NAMES = {"type": "array", "items": {"type": "string"}}
_GROUP = {"type": "integer", "minimum": 0, "maximum": 5}
_VISUAL = {**_GROUP, "description": "That of visuals; default 2."}
_COLLISION = {**_GROUP, "description": "That of what collides; default 3, of a robot without looks 0."}
_OPTIONS = {
    "number_format": format.NUMBER_FORMAT,
    "base": _one_of(("fixed", "free"), "Whether the root link is held or free to move. Default: free with a drive."),
    "option": {
        "type": "object",
        "description": "Settings of the simulation, in MuJoCo's words and SI units; default: integrator implicitfast;"
        " for what is free or drives also cone elliptic, and on rollers or feet impratio 100.",
        "properties": SETTINGS,
        "additionalProperties": False,
    },
    "visuals": _one_of(
        ("own", "from_collision"),
        "What is seen of links without visuals: nothing (own), or their collision shapes, in one colour a link."
        " Default: from_collision, if no link has a visual.",
    ),
    "mesh_inertia": _one_of(
        ("convex", "exact", "legacy", "shell"),
        "How MuJoCo computes the volume of meshes that do not define it; default: shell, which may be thin or open.",
    ),
    "height_maps": _one_of(
        (*format.FORMS_OF_BOXES, "hfield"),
        f"What height maps are; default: merged. Boxes: {format.BOXES_OF_HEIGHT_MAPS}; hfield: a height field, which"
        " does not collide with planes.",
    ),
    "contacts": _one_of(
        ("implied", "described"),
        "Which links do not touch: neighbours at a joint, those that always touch and disabled_contacts (implied, the"
        " default), or disabled_contacts alone (described).",
    ),
    "groups": {
        "type": "object",
        "description": "The groups by which viewers show and hide geoms, of visuals and of what collides.",
        "properties": {"visual": _VISUAL, "collision": _COLLISION},
        "additionalProperties": False,
    },
    "actuators": {**_NAMES, "description": "The order of the actuators, by name; default: that of their joints."},
    "sensors": {
        **_NAMES,
        "description": "The order of the sensors, by name; default: those of `sensors`, then those of `mjcf`.",
    },
    "drives": _one_of(
        ("position", "velocity", "none"),
        "Servos for joints that no actuator moves, with gains from what they carry: for the position of joints with"
        " limits and the speed of others (position), or for all speeds (velocity). Default: none.",
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
    beside=lambda text: FILE.findall(text),
    opens=_lazy(".unsupported", "file_path"),
    copies=_lazy("..mesh_copies", "copy_meshes"),
    syntax=xml_syntax,
    refusal=_lazy(".process", "refusal"),
    prove=_lazy(".process", "prove"),
    engine_reads=True,
    folder="mjcf",
)

"""Words of SDF that its reader and its writer share: reserved names, elements that hold numbers, kept elements."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rosorin_compile.model import Output, Robot
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import Heading, Rule

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case

RULES = (
    Rule(
        "sdf-name",
        "A name that SDF keeps for itself: `world`, names between two underscores and two, and those with `::`, which"
        " leads into a model.",
        "Rename it.",
        Heading.FORMATS,
    ),
)

# What SDF 1.9 has in a model, a link and a joint for which a description has no word. Gazebo takes each unchanged out
# of a <gazebo> of a URDF (gazebosim/sdformat@sdf12:src/parser_urdf.cc).
OF_MODEL = ("plugin", "static", "self_collide", "allow_auto_disable", "enable_wind")
OF_LINK = (
    *("sensor", "gravity", "enable_wind", "self_collide", "kinematic", "must_be_base_link", "velocity_decay"),
    *("light", "particle_emitter", "projector", "audio_source", "audio_sink", "battery"),
)
OF_JOINT = ("sensor", "physics")
INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
PARTS_OF_LINK = ("pose", "inertial", "visual", "collision")
# The sizes of solids, with how many numbers each is.
SOLIDS = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "ellipsoid": {"radii": 3},
    "mesh": {"scale": 3},
}
# The numbers of an axis, with their units: of the position of the joint {q}, of its force or torque {f}.
MOTION = {
    "limit": {"lower": "{q}", "upper": "{q}", "effort": "{f}", "velocity": "{q}/s"},
    "dynamics": {
        "damping": "{f}*s/{q}",
        "friction": "{f}",
        "spring_stiffness": "{f}/{q}",
        "spring_reference": "{q}",
    },
}
WORLD = "world"
RESERVED = re.compile(r"__.*__\Z")


def world_of(robot: Robot) -> str:
    """Return the link that is the world itself; empty if none is."""
    if not robot.is_tree:  # reported by a rule
        return ""
    root = robot.link[robot.root]
    bare = not ((root.inertial and root.inertial.mass) or root.visual or root.collision)
    return root.name if bare and root.name == WORLD and len(robot.links) > 1 else ""


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find names that no model, link, frame or joint of an SDF can have."""
    robot = case.robot
    found = [("link", link.name, case.link(link.name)) for link in robot.links if link.name != world_of(robot)]
    found += [("joint", joint.name, case.joint(joint)) for joint in robot.joints]
    for kind, name, path in (*found, ("model", robot.name, ("robot",))):
        why = "that is the world itself" if name == WORLD else ":: leads into a model" if "::" in name else ""
        why = why or ("SDF keeps names between two underscores for itself" if RESERVED.match(name) else "")
        if why:
            may = name == WORLD and kind == "link"
            help = "rename it; a root that is nothing but the world may have this name" if may else "rename it"
            message = f'no {kind} of {output.file} can be called "{name}": {why}'
            yield case.problem("sdf-name", message, path, help, key=kind != "model")

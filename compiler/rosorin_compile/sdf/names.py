"""Names: what SDF keeps for itself, and nothing in a robot can be called."""

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


WORLD = "world"
RESERVED = re.compile(r"__.*__\Z")


def world_of(robot: Robot) -> str:
    """Return the link that is the world itself; empty if none is."""
    if not robot.is_tree:  # told as that
        return ""
    root = robot.link[robot.root]
    bare = not ((root.inertial and root.inertial.mass) or root.visual or root.collision)
    return root.name if bare and root.name == WORLD and len(robot.links) > 1 else ""


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find names that no model, link, frame or joint of an SDF can have."""
    robot = case.robot
    found = [("link", link.name, case.link(link.name)) for link in robot.links if link.name != world_of(robot)]
    found += [("joint", joint.name, case.joint(joint)) for joint in robot.joints]
    found.append(("model", robot.name, ("robot",)))
    for kind, name, path in found:
        why = _why(name)
        if why:
            message = f'no {kind} of {output.file} can be called "{name}": {why}'
            may = name == WORLD and kind == "link"
            help = "rename it; a root that is nothing but the world may have this name" if may else "rename it"
            yield case.problem("sdf-name", message, path, help, key=kind != "model")


def _why(name: str) -> str:
    """Return why SDF has no such name; empty if it may have it."""
    if name == WORLD:
        return "that is the world itself"
    if "::" in name:
        return ":: leads into a model"
    return "SDF keeps names between two underscores for itself" if RESERVED.match(name) else ""

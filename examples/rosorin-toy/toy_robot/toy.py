"""The format toy: a line for each link and each joint of a robot made of balls."""

from __future__ import annotations

import math
import re
from typing import Any

from rosorin_compile.extend import (
    Diagnostic,
    Format,
    ImportFile,
    Rule,
    Templates,
    Unsupported,
)
from rosorin_compile.model import Inertial, Joint, Link, Output, Pose, Robot, Sphere

CANNOT_SAY = Rule("toy-cannot-say", "A warning: the format toy cannot express a link that is not a ball.")


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the text of the artifact, and warnings for links that are not balls."""
    digits = output.options.get("digits", 6)
    angle = math.degrees if output.options.get("angles") == "deg" else float
    values = {
        "robot": robot,
        "unit": output.options.get("angles", "rad"),
        "balls": {link.name: [link.inertial.mass, ball(link).radius] for link in robot.links if ball(link)},
        "poses": {joint.name: [*joint.origin.xyz, *map(angle, joint.origin.rpy)] for joint in robot.joints},
        "numbers": lambda values: " ".join(f"{value:.{digits}f}" for value in values),
    }
    others = [link for link in robot.links if not ball(link) and (link.inertial or link.collision)]
    message = "link {} is not a ball: written without mass and shape"
    warnings = [Diagnostic("toy-cannot-say", "warning", message.format(link.name)) for link in others]
    return templates.package("toy_robot").render("robot.toy.jinja", values), warnings


def ball(link: Link) -> Sphere | None:
    """Return the sphere of a link that has a mass and a single sphere, otherwise None."""
    shapes = [shape.geometry for shape in link.collision]
    alone = len(shapes) == 1 and link.inertial is not None and isinstance(shapes[0], Sphere)
    return shapes[0] if alone else None


def view(robot: Robot, output: Output) -> Robot:
    """Return what the artifact is meant to contain, with the digits that it prints."""
    digits = output.options.get("digits", 6)
    unit = math.radians(1) if output.options.get("angles") == "deg" else 1.0
    links = []
    for link in robot.links:
        inertial = weight(round(link.inertial.mass, digits)) if ball(link) else None
        links.append(Link(link.name, inertial))
    joints = []
    for joint in robot.joints:
        xyz = tuple(round(length, digits) for length in joint.origin.xyz)
        rpy = tuple(round(angle / unit, digits) * unit for angle in joint.origin.rpy)
        joints.append(Joint(joint.name, joint.type, joint.parent, joint.child, Pose(xyz, rpy)))
    return Robot(robot.name, tuple(links), tuple(joints))


def weight(mass: float) -> Inertial:
    """Return an inertial that has nothing but a mass."""
    return Inertial(mass, Pose(), 0.0, 0.0, 0.0)


def read(text: str) -> Robot:
    """Return what an artifact contains. Raises ValueError if it is damaged."""
    name, links, joints = "", [], []
    to_radians = float
    for words in map(str.split, text.splitlines()):
        if words[:1] == ["robot"]:
            name = words[1]
        elif words[:1] == ["angles"]:
            to_radians = math.radians if words[1] == "deg" else float
        elif words[:1] == ["link"]:
            links.append(Link(words[1], weight(float(words[2])) if len(words) > 2 else None))
        elif words[:1] == ["joint"]:
            _, joint, kind, parent, child, *numbers = words
            x, y, z, roll, pitch, yaw = map(float, numbers)
            pose = Pose((x, y, z), (to_radians(roll), to_radians(pitch), to_radians(yaw)))
            joints.append(Joint(joint, kind, parent, child, pose))
    return Robot(name, tuple(links), tuple(joints))


def load(opened: ImportFile) -> dict[str, Any]:
    """Return the description that a file contains, as plain YAML values."""
    robot: dict[str, Any] = {"links": {}, "joints": {}}
    angle = "rad"
    for line, text in enumerate(opened.text.splitlines(), 1):
        found = list(re.finditer(r"\S+", text.partition("#")[0]))
        match [word[0] for word in found]:
            case []:
                pass
            case ["robot", name]:
                robot["robot"] = name
            case ["angles", "rad" | "deg" as unit]:
                angle = unit
            case ["link", name]:
                robot["links"][name] = opened.with_span({}, line)
            case ["link", name, _, _]:
                mass, radius = numbers(opened, line, found[2:], "kg", "m")
                ball = {"inertial": {"of": "collision", "mass": mass}, "collision": [{"sphere": {"radius": radius}}]}
                robot["links"][name] = opened.with_span(ball, line)
            case ["joint", name, kind, parent, child, _, _, _, _, _, _]:
                x, y, z, *rpy = numbers(opened, line, found[5:], "m", "m", "m", angle, angle, angle)
                joint = {"type": kind, "parent": parent, "child": child, "xyz": [x, y, z], "rpy": rpy}
                robot["joints"][name] = opened.with_span(joint, line)
            case [word, *_]:
                help = "a line begins with robot, angles, link or joint"
                message = f'unknown line "{word}"'
                raise opened.problem(message, line, found[0].start() + 1, len(text.strip()), help)
    return robot


def numbers(opened: ImportFile, line: int, words: list[re.Match[str]], *units: str) -> list[Any]:
    """Return numbers with their places, for messages, and with their digits, for comparisons."""
    pairs = zip(words, units, strict=True)
    return [opened.with_span(f"{word[0]} {unit}", line, word.start() + 1, len(word[0])) for word, unit in pairs]


NO_WORD = ("links.*.visual", "joints.*.actuator", "joints.*.publisher", "actuators", "disabled_contacts")
UNSUPPORTED = dict.fromkeys((*NO_WORD, "edges", "poses", "sensors", "servos"), Unsupported("balls and joints alone"))
FORMAT = Format(
    name="toy",
    word="toy",
    article="a",
    about="the robot as balls",
    options={
        "angles": {"enum": ["rad", "deg"], "description": "The unit of angles; default: rad."},
        "digits": {"type": "integer", "minimum": 1, "maximum": 15, "description": "Decimals; default: 6."},
    },
    rules=(CANNOT_SAY,),
    file="{}.toy",
    endings=(".toy",),
    write=write,
    view=view,
    read=read,
    load=load,
    unsupported=UNSUPPORTED,
    folder="toy",
    deploys=True,
)

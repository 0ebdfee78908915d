"""Sections as packages bring them: one entry, many by name, a list, an axis."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from rosorin_compile import Robot
from rosorin_compile.extend import Case, Diagnostic, Section, rule
from rosorin_compile.model import Inertial, Joint, Link, Pose, Vector

NAME = {"$ref": "#/$defs/name"}


def entry(*needed: str, **properties: object) -> dict[str, object]:
    return {"type": "object", "additionalProperties": False, "required": list(needed), "properties": properties}


@dataclass(frozen=True)
class Payload:
    link: str
    mass: float
    place: Pose
    fragile: bool


def carried(robot: Robot, payload: Payload) -> Robot:
    return robot.with_masses({payload.link: [Inertial(payload.mass, payload.place, 0.01, 0.01, 0.01)]})


@rule("payload-too-heavy", "A payload is heavier than 100 kg.", "Take a smaller one.", accept="link")
def light(case: Case) -> Iterator[Diagnostic]:
    payload = case.robot.sections[PAYLOAD]
    assert payload is not None, "a rule of a section that is not there is not asked"
    if payload.mass > 100:
        yield case.problem("payload-too-heavy", f"it weighs {payload.mass:g} kg", ("payload", "mass"))


PAYLOAD = Section.single(
    "payload",
    Payload,
    {
        **entry(
            "link",
            "mass",
            link={**NAME, "x-names": "link", "x-attached": ["xyz", "rpy"]},
            mass={"type": "number", "x-unit": "kg", "description": "What it weighs."},
            xyz={"$ref": "#/$defs/xyz"},
            rpy={"$ref": "#/$defs/rpy"},
            fragile={"type": "boolean", "default": True},
        ),
        "description": "What the robot carries.",
        "x-in-parts": True,
        "x-mirror": ["pose"],
        "x-also": "load cargo",
    },
    adds=carried,
    checks=(light,),
)


@dataclass(frozen=True)
class Magnet:
    name: str
    link: str
    direction: Vector
    strength: float = 1.0
    poles: tuple[str, ...] = ()


MAGNETS = Section.by_name(
    "magnets",
    Magnet,
    {
        "type": "object",
        "description": "Magnets, by name.",
        "propertyNames": {**NAME, "x-gives": "magnet"},
        "additionalProperties": {
            **entry(
                "link",
                "direction",
                link={**NAME, "x-names": "link", "x-attached": ["direction"]},
                direction={"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
                strength={
                    "type": "number",
                    "x-also": "power",
                    "exclusiveMinimum": 0,
                    "exclusiveMaximum": 9,
                    "multipleOf": 0.5,
                },
                poles={"type": "array", "items": {"type": "string"}, "uniqueItems": True},
            ),
            "x-mirror": ["direction"],
        },
        "x-in-parts": True,
        "x-called": "magnet",
    },
)


@dataclass(frozen=True)
class Marker:
    link: str
    frame: str
    height: float


def markers(robot: Robot, found: tuple[Marker, ...]) -> Robot:
    links = tuple(Link(one.frame) for one in found)
    joints = tuple(
        Joint(f"{one.frame}_joint", "fixed", one.link, one.frame, Pose((0.0, 0.0, one.height))) for one in found
    )
    return replace(robot, links=(*robot.links, *links), joints=(*robot.joints, *joints))


MARKERS = Section.list_of(
    "markers",
    Marker,
    {
        "type": "array",
        "description": "Frames that a camera looks for.",
        "items": entry(
            "link",
            "frame",
            link={**NAME, "x-names": "link"},
            frame={**NAME, "x-gives": "link"},
            height={"type": "number", "x-unit": "m", "default": 0.1},
        ),
        "x-in-parts": True,
    },
    adds=markers,
)

"""Kept: what a description has for Gazebo in ``urdf_elements``, as the SDF has it.

Gazebo takes a ``<gazebo>`` of a URDF apart in the same way: what stands in it goes into the model, or into the link or
joint that it refers to (``gazebosim/sdformat@sdf12:src/parser_urdf.cc``). Words that mean something to that reader
alone (mu1, kp, material, ...) have no place here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from ...diagnostics import Source
from ...model import Robot
from ...xml.elements import indented
from ...xml.markup import Element, MarkupError, parse

# What SDF 1.9 knows in a model, a link and a joint, beside what a description says in words.
OF_MODEL = ("plugin", "static", "self_collide", "allow_auto_disable", "enable_wind")
OF_LINK = (
    *("sensor", "gravity", "enable_wind", "self_collide", "kinematic", "must_be_base_link", "velocity_decay"),
    *("light", "particle_emitter", "projector", "audio_source", "audio_sink", "battery"),
)
OF_JOINT = ("sensor", "physics")
POSED = ("sensor", "light", "particle_emitter", "projector", "audio_source")
# What says how a URDF becomes an SDF, which this one does not come from.
_OF_URDF = ("preserveFixedJoint", "disableFixedJointLumping", "disableJointLumping")


class Kept(NamedTuple):
    """Elements as text: those of the model, of links and of joints by name; what has no place here, by its words."""

    model: Sequence[str]
    links: Mapping[str, Sequence[str]]
    joints: Mapping[str, Sequence[str]]
    left_out: Collection[str]


def kept(robot: Robot, carrier: Mapping[str, str], joints: Collection[str]) -> Kept:
    """Return what a robot has for Gazebo; ``carrier`` says who carries each link in the SDF, ``joints`` are its own."""
    model: list[str] = []
    links: dict[str, list[str]] = {}
    of_joints: dict[str, list[str]] = {}
    left: dict[str, None] = {}
    for reference, element in _blocks(robot):
        if element.tag in _OF_URDF:
            continue
        if not reference and element.tag in OF_MODEL:
            model.append(element.verbatim)
        elif reference in carrier and element.tag in OF_LINK:
            text = element.verbatim if carrier[reference] == reference else _placed(element, reference)
            links.setdefault(carrier[reference], []).append(text)
        elif reference in joints and element.tag in OF_JOINT:
            of_joints.setdefault(reference, []).append(element.verbatim)
        else:
            left[f"<{element.tag}>{f' of {reference}' if reference else ''}"] = None
    return Kept(model, links, of_joints, left)


def _blocks(robot: Robot) -> Iterator[tuple[str, Element]]:
    """Yield each element that stands in a <gazebo>, and what that refers to."""
    for text in robot.urdf_elements:
        if "<gazebo" not in text:
            continue
        try:
            document = parse(Source("", f"<all>{text}</all>"))
        except MarkupError:  # more than one text can hold: the rules found it well formed
            continue
        for block in document.root.children:
            if block.tag == "gazebo":
                yield from ((block.get("reference"), element) for element in block.children)


def _placed(element: Element, frame: str) -> str:
    """Return an element that sits in a frame of its link: its pose is seen from there."""
    if element.tag not in POSED:
        return element.verbatim
    own = next((child for child in element.children if child.tag == "pose"), None)
    text, start = element.verbatim, element.start
    word = f' relative_to="{frame}"'
    if own is not None and ("relative_to" in own.attributes or "frame" in own.attributes):
        return text
    if own is not None:
        at = own.start - start + len("<pose")
        return f"{text[:at]}{word}{text[at:]}"
    at = element.opened - start
    if element.end == element.opened:  # <sensor .../>
        return f"{text[: at - 2]}><pose{word}/></{element.tag}>"
    return f"{text[:at]}<pose{word}/>{text[at:]}"


def at(texts: Sequence[str], indent: str) -> list[str]:
    """Return elements where they stand in the file."""
    return [indented(text, indent) for text in texts]

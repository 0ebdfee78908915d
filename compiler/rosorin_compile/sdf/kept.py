"""Elements that a description keeps for Gazebo in ``urdf_elements``, as the SDF has them.

Gazebo takes a ``<gazebo>`` of a URDF apart in the same way: its contents go into the model, or into the link or joint
that it refers to (``gazebosim/sdformat@sdf12:src/parser_urdf.cc``). The contents of an ``<sdf>`` belong to what that is
an element of: the robot, a link, a joint, its axis, a shape, its material.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.formats.urdf.imu_noise import with_noise
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.xml.elements import indented

from .words import OF_JOINT, OF_LINK, OF_MODEL

if TYPE_CHECKING:
    from rosorin_compile.source.xml.markup import Element

POSED = ("sensor", "light", "particle_emitter", "projector", "audio_source", "visual", "collision")
# How a URDF becomes an SDF, which this SDF does not come from.
_OF_URDF = ("preserveFixedJoint", "disableFixedJointLumping", "disableJointLumping")
# What Gazebo classic says of all collisions of a link: the element of a <collision>, the part of its <surface> that it
# is in, and how many numbers it has.
OF_COLLISIONS: Mapping[str, tuple[str, str, int]] = {
    "laserRetro": ("laser_retro", "", 1),
    "maxContacts": ("max_contacts", "", 1),
    "mu1": ("mu", "friction", 1),
    "mu2": ("mu2", "friction", 1),
    "fdir1": ("fdir1", "friction", 3),
    "kp": ("kp", "contact", 1),
    "kd": ("kd", "contact", 1),
    "maxVel": ("max_vel", "contact", 1),
    "minDepth": ("min_depth", "contact", 1),
}


class Kept(NamedTuple):
    """Elements as text: of the model, of links and joints by name, and the tags of those that SDF has no place for.

    ``collisions`` are the numbers for all collisions of a link, by the words of Gazebo classic.
    """

    model: list[str]
    links: dict[str, list[str]]
    collisions: dict[str, dict[str, str]]
    joints: dict[str, list[str]]
    left_out: dict[str, None]


def kept(robot: Robot, carrier: Mapping[str, str], joints: Collection[str]) -> Kept:
    """Sort the elements for Gazebo; ``carrier`` is the link of the SDF for each link, ``joints`` its joints."""
    found = Kept([element.verbatim for element in own(robot.urdf_elements).elements], {}, {}, {}, {})

    def placed(element: Element, link: str) -> None:
        body = carrier[link]
        text = element.verbatim if body == link else _relative_to(element, link)
        found.links.setdefault(body, []).append(with_noise(text))

    for link in robot.links:
        for element in own(link.urdf_elements).elements:
            if link.name in carrier:
                placed(element, link.name)
            else:
                found.left_out[f"<{element.tag}> of {link.name}"] = None
    for block in _elements(robot.urdf_elements, "gazebo"):
        name = block.get("reference")
        for element in block.children:
            numbers = _numbers(element) if element.tag in OF_COLLISIONS else ""
            if element.tag in _OF_URDF:
                continue
            if not name and element.tag in OF_MODEL:
                found.model.append(element.verbatim)
            elif name in carrier and element.tag in OF_LINK:
                placed(element, name)
            elif numbers and name in carrier and robot.link[name].collision:
                found.collisions.setdefault(name, {})[element.tag] = numbers
            elif name in joints and element.tag in OF_JOINT:
                found.joints.setdefault(name, []).append(element.verbatim)
            else:
                found.left_out[f"<{element.tag}>{f' of {name}' if name else ''}"] = None
    return found


def _numbers(element: Element) -> str:
    """Return the numbers of an element for collisions, its text or its ``value``; empty if they are none."""
    words = (element.get("value") or element.text).split()
    try:
        finite = all(math.isfinite(float(word)) for word in words)
    except ValueError:
        return ""
    return " ".join(words) if finite and len(words) == OF_COLLISIONS[element.tag][2] else ""


def of_collision(said: Mapping[str, str], own: Collection[str]) -> list[str]:
    """Return the elements of a collision for the words of its link; ``own`` are the tags that it has itself."""
    made, parts = list[str](), dict[str, str]()
    for word, (name, part, _) in OF_COLLISIONS.items():
        text = f"<{name}>{said[word]}</{name}>" if word in said else ""
        if text and part:
            parts[part] = parts.get(part, "") + text
        elif text and name not in own:
            made.append(text)
    surface = "".join(f"<{part}><ode>{inner}</ode></{part}>" for part, inner in parts.items())
    return [*made, f"<surface>{surface}</surface>"] if surface and "surface" not in own else made


def _elements(texts: Sequence[str], tag: str) -> Iterator[Element]:
    """Yield the elements of a tag among those that an entry keeps."""
    for text in texts:
        if f"<{tag}" not in text:
            continue
        from rosorin_compile.source.xml.markup import MarkupError, parse

        try:
            document = parse(Source("", f"<all>{text}</all>"))
        except MarkupError:  # more than one text can hold: the rules found it well formed
            continue
        yield from (block for block in document.root.children if block.tag == tag)


class Own(NamedTuple):
    """What an entry has for SDF alone: elements, and as text those for elements within, by the tags that lead there."""

    elements: Sequence[Element]
    inner: Mapping[str, Sequence[str]]


def own(texts: Sequence[str], *within: str) -> Own:
    """Return the contents of the <sdf> of an entry; ``within`` are the elements that it has in any case, as tag/tag."""
    found, inner = list["Element"](), dict[str, list[str]]()
    waiting = [("", block) for block in _elements(texts, "sdf")]
    while waiting:
        way, block = waiting.pop(0)
        for element in block.children:
            path = f"{way}/{element.tag}".lstrip("/")
            if path in within:
                waiting.append((path, element))
            elif way:
                inner.setdefault(way, []).append(element.verbatim)
            else:
                found.append(element)
    return Own(found, inner)


def _relative_to(element: Element, frame: str) -> str:
    """Return an element of a frame of its link: its pose becomes relative to that frame."""
    pose = next((child for child in element.children if child.tag == "pose"), None)
    text, start, word = element.verbatim, element.start, f' relative_to="{frame}"'
    if element.tag not in POSED or (pose is not None and {"relative_to", "frame"} & pose.attributes.keys()):
        return text
    if pose is not None:
        at = pose.start - start + len("<pose")
        return f"{text[:at]}{word}{text[at:]}"
    at = element.opened - start
    if element.end == element.opened:  # <sensor .../>
        return f"{text[: at - 2]}><pose{word}/></{element.tag}>"
    return f"{text[:at]}<pose{word}/>{text[at:]}"


def at(texts: Sequence[str], indent: str) -> list[str]:
    """Return elements at their place in the file."""
    return [indented(text, indent) for text in texts]

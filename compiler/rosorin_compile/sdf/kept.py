"""Kept: what a description has for Gazebo in ``urdf_elements``, as the SDF has it.

Gazebo takes a ``<gazebo>`` of a URDF apart in the same way: what stands in it goes into the model, or into the link or
joint that it refers to (``gazebosim/sdformat@sdf12:src/parser_urdf.cc``); what it says of the collisions of a link
(mu1, kp, ...) goes there, by other names (``classic``). Words that mean something to that reader alone (material, ...)
have no place here. What stands in an ``<sdf>`` belongs to what that stands in: the robot, a link, a joint, its axis, a
shape, its material.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.model import Link, Robot
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.xml.elements import indented
from rosorin_compile.source.xml.imu import with_noise

from .classic import OF_COLLISIONS, numbers_of
from .words import OF_JOINT, OF_LINK, OF_MODEL

if TYPE_CHECKING:
    from rosorin_compile.source.xml.markup import Element

POSED = ("sensor", "light", "particle_emitter", "projector", "audio_source", "visual", "collision")
# What says how a URDF becomes an SDF, which this one does not come from.
_OF_URDF = ("preserveFixedJoint", "disableFixedJointLumping", "disableJointLumping")


class Kept(NamedTuple):
    """Elements as text: those of the model, of links and of joints by name; what has no place here, by its words.

    ``collisions`` is what is said of all collisions of a link, by the words of Gazebo classic.
    """

    model: Sequence[str]
    links: Mapping[str, Sequence[str]]
    collisions: Mapping[str, Mapping[str, str]]
    joints: Mapping[str, Sequence[str]]
    left_out: Collection[str]


def kept(robot: Robot, carrier: Mapping[str, str], joints: Collection[str]) -> Kept:
    """Return what a robot has for Gazebo; ``carrier`` says who carries each link in the SDF, ``joints`` are its own."""
    model = [element.verbatim for element in own(robot.urdf_elements).elements]
    links: dict[str, list[str]] = {}
    of_joints: dict[str, list[str]] = {}
    collisions: dict[str, dict[str, str]] = {}
    left: dict[str, None] = {}
    for link in robot.links:
        for element in own(link.urdf_elements).elements:
            if link.name not in carrier:
                left[f"<{element.tag}> of {link.name}"] = None
                continue
            body = carrier[link.name]
            links.setdefault(body, []).append(element.verbatim if body == link.name else _placed(element, link.name))
    for reference, element in _blocks(robot):
        if element.tag in _OF_URDF:
            continue
        if not reference and element.tag in OF_MODEL:
            model.append(element.verbatim)
        elif reference in carrier and element.tag in OF_LINK:
            text = element.verbatim if carrier[reference] == reference else _placed(element, reference)
            links.setdefault(carrier[reference], []).append(with_noise(text))
        elif element.tag in OF_COLLISIONS and reference in carrier and _says(robot.link[reference], element):
            collisions.setdefault(reference, {})[element.tag] = numbers_of(element)
        elif reference in joints and element.tag in OF_JOINT:
            of_joints.setdefault(reference, []).append(element.verbatim)
        else:
            left[f"<{element.tag}>{f' of {reference}' if reference else ''}"] = None
    return Kept(model, links, collisions, of_joints, left)


def _says(link: Link, element: Element) -> bool:
    """Say whether a word for collisions says something of a link: it has some, and the word has its numbers."""
    return bool(link.collision and numbers_of(element))


def _blocks(robot: Robot) -> Iterator[tuple[str, Element]]:
    """Yield each element that stands in a <gazebo>, and what that refers to."""
    for block in _elements(robot.urdf_elements, "gazebo"):
        yield from ((block.get("reference"), element) for element in block.children)


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


_NOTHING = Own((), {})


def own(texts: Sequence[str], *within: str) -> Own:
    """Return what stands in the <sdf> of an entry; ``within`` are the elements that it has in any case, as tag/tag."""
    if not texts:
        return _NOTHING
    found: list[Element] = []
    inner: dict[str, list[str]] = {}
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

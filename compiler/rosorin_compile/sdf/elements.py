"""Elements of SDF that the language has no key for: read into ``urdf_elements`` and written again.

What is the same in a URDF for Gazebo (plugins, sensors, ...) becomes a ``<gazebo>`` of the robot, whose contents Gazebo
puts into the model, or into the link or joint that it refers to (``gazebosim/sdformat@sdf12:src/parser_urdf.cc``). The
rest is in an ``<sdf>`` of its entry: of the robot, a link, a joint or a shape. It contains what the element in the SDF
contains.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.gazebo_elements import with_noise
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.tree import Text
from rosorin_compile.source.xml.elements import indented
from rosorin_compile.source.xml.markup import Element, MarkupError, parse

WORLD = "world"
RESERVED = re.compile(r"__.*__\Z")

# What SDF 1.9 has in a model, a link and a joint without a key in the language, and Gazebo takes out of a <gazebo>.
OF_MODEL = ("plugin", "static", "self_collide", "allow_auto_disable", "enable_wind")
OF_LINK = (
    *("sensor", "gravity", "enable_wind", "self_collide", "kinematic", "must_be_base_link", "velocity_decay"),
    *("light", "particle_emitter", "projector", "audio_source", "audio_sink", "battery"),
)
OF_JOINT = ("sensor", "physics")
# What Gazebo classic reads for all collisions of a link: the element of a <collision>, the part of its <surface> that
# contains it, and its count of numbers.
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
_FOR_CONVERSION = ("preserveFixedJoint", "disableFixedJointLumping", "disableJointLumping")  # of a URDF to an SDF
_POSED = ("sensor", "light", "particle_emitter", "projector", "audio_source", "visual", "collision")
_SHORT = 80


def wrapped(tag: str, texts: Sequence[str], **attributes: str) -> Text:
    """Return elements in an element around them."""
    names = "".join(f" {key}={quoteattr(value)}" for key, value in attributes.items())
    if len(texts) == 1 and "\n" not in texts[0] and len(texts[0]) < _SHORT:
        return Text(f"<{tag}{names}>{texts[0]}</{tag}>")
    return Text("\n".join([f"<{tag}{names}>", *(indented(text, "  ") for text in texts), f"</{tag}>"]))


def keep(entry: dict[str, Any], element: Element, text: str) -> int:
    """Add a text to the elements that an entry keeps and return its index; ``element`` is its place."""
    entry.setdefault("urdf_elements", []).append(Placed(text, element.span))
    return len(entry["urdf_elements"]) - 1


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
    found = Kept([element.verbatim for element in own_elements(robot.urdf_elements)[0]], {}, {}, {}, {})

    def add(element: Element, link: str) -> None:
        body = carrier[link]
        text = element.verbatim if body == link else _relative_to(element, link)
        found.links.setdefault(body, []).append(with_noise(text))

    for link in robot.links:
        for element in own_elements(link.urdf_elements)[0]:
            if link.name in carrier:
                add(element, link.name)
            else:
                found.left_out[f"<{element.tag}> of {link.name}"] = None
    for block in _elements(robot.urdf_elements, "gazebo"):
        name = block.get("reference")
        for element in block.children:
            if element.tag in _FOR_CONVERSION:
                continue
            numbers = _numbers(element) if element.tag in OF_COLLISIONS else ""
            if not name and element.tag in OF_MODEL:
                found.model.append(element.verbatim)
            elif name in carrier and element.tag in OF_LINK:
                add(element, name)
            elif numbers and name in carrier and robot.link[name].collision:
                found.collisions.setdefault(name, {})[element.tag] = numbers
            elif name in joints and element.tag in OF_JOINT:
                found.joints.setdefault(name, []).append(element.verbatim)
            else:
                found.left_out[f"<{element.tag}>{f' of {name}' if name else ''}"] = None
    return found


def _numbers(element: Element) -> str:
    """Return the numbers of an element for collisions, its text or its ``value``; empty if it is damaged."""
    words = (element.get("value") or element.text).split()
    try:
        finite = all(math.isfinite(float(word)) for word in words)
    except ValueError:
        return ""
    return " ".join(words) if finite and len(words) == OF_COLLISIONS[element.tag][2] else ""


def collision_elements(numbers: Mapping[str, str], present: Collection[str]) -> list[str]:
    """Return the elements of a collision for the words of its link, without those that are ``present``."""
    made, parts = list[str](), dict[str, str]()
    for word, (name, part, _) in OF_COLLISIONS.items():
        if word in numbers and (part or name not in present):
            text = f"<{name}>{numbers[word]}</{name}>"
            if part:
                parts[part] = parts.get(part, "") + text
            else:
                made.append(text)
    surface = "".join(f"<{part}><ode>{inner}</ode></{part}>" for part, inner in parts.items())
    return [*made, f"<surface>{surface}</surface>"] if surface and "surface" not in present else made


def own_elements(texts: Sequence[str], *within: str) -> tuple[list[Element], Mapping[str, list[str]]]:
    """Return the contents of the <sdf> of an entry: elements, and as text the contents of the elements ``within``.

    ``within`` are the elements (tag/tag) that the entry has in any case; the texts are by those.
    """
    found, inner = list[Element](), dict[str, list[str]]()
    waiting = [("", block) for block in _elements(texts, "sdf")]
    while waiting:
        above, block = waiting.pop(0)
        for element in block.children:
            path = f"{above}/{element.tag}".lstrip("/")
            if path in within:
                waiting.append((path, element))
            elif above:
                inner.setdefault(above, []).append(element.verbatim)
            else:
                found.append(element)
    return found, inner


def _elements(texts: Sequence[str], tag: str) -> Iterator[Element]:
    """Yield the elements of a tag among those that an entry keeps."""
    for text in texts:
        if f"<{tag}" in text:
            try:
                document = parse(Source("", f"<all>{text}</all>"))
            except MarkupError:  # too large: the rules found it well formed
                continue
            yield from (block for block in document.root.children if block.tag == tag)


def _relative_to(element: Element, frame: str) -> str:
    """Return an element of a frame of its link: its pose becomes relative to that frame."""
    pose = next((child for child in element.children if child.tag == "pose"), None)
    text, word = element.verbatim, f' relative_to="{frame}"'
    if element.tag not in _POSED or (pose is not None and {"relative_to", "frame"} & pose.attributes.keys()):
        return text
    at = element.opened - element.start
    if pose is not None:
        at = pose.start - element.start + len("<pose")
        return f"{text[:at]}{word}{text[at:]}"
    if element.end == element.opened:  # <sensor .../>
        return f"{text[: at - 2]}><pose{word}/></{element.tag}>"
    return f"{text[:at]}<pose{word}/>{text[at:]}"

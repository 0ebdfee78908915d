"""Determine which links and frames the SDF of a robot contains, and sort the XML elements kept in the description.

In SDF, a link without an inertial has a mass of 1 kg, so links without mass become frames; those that move stay links
and get a minimal mass. A root link called "world" without mass and shapes is the world.

Elements that a URDF for Gazebo can contain too (plugins, sensors, ...) are kept in a ``<gazebo>`` block. Gazebo inserts
its contents into the model, or into the link or joint that it refers to (``sdformat@sdf12:src/parser_urdf.cc``).
All other elements are kept in an ``<sdf>`` block of the robot, a link, a joint or a shape.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats.format import SourceValue
from rosorin_compile.formats.gazebo import SPRING, with_noise
from rosorin_compile.model import Inertial, Joint, Limit, Link, Mesh, Output, Robot, Shape
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.source.diagnostics import Diagnostic, Source
from rosorin_compile.source.tree import Text
from rosorin_compile.source.xml.elements import attribute_value, indented, numbers_of
from rosorin_compile.source.xml.markup import Element, MarkupError, parse

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case


FOLLOWERS = "1.11"  # first version with <mimic>
OLDEST, NEWEST = "1.9", "1.12"
UNLIMITED = 1e16  # readers of SDF ignore limits with a magnitude above this
FREE = ("floating", "planar")  # joint types that SDF lacks; their child link is free to move in the world
# Inertial (kg, kg*m^2) of moving massless links, too small to affect the motion of other links.
LEAST = Inertial(1e-6, IDENTITY, 1e-9, 1e-9, 1e-9)
WORLD = "world"
RESERVED = re.compile(r"__.*__\Z")

# Elements of SDF 1.9 that no key of a description can express, but that Gazebo accepts in a <gazebo> block.
OF_MODEL = ("plugin", "static", "self_collide", "allow_auto_disable", "enable_wind")
OF_LINK = (
    *("sensor", "gravity", "enable_wind", "self_collide", "kinematic", "must_be_base_link", "velocity_decay"),
    *("light", "particle_emitter", "projector", "audio_source", "audio_sink", "battery"),
)
OF_JOINT = ("sensor", "physics")
# Elements of Gazebo classic for all collisions of a link: the equivalent element in a <collision>, the child of
# <surface> that contains that element ("" if it is outside of <surface>), and its number of values.
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
_FOR_CONVERSION = ("preserveFixedJoint", "disableFixedJointLumping", "disableJointLumping")  # only for URDF to SDF
_POSED = ("sensor", "light", "particle_emitter", "projector", "audio_source", "visual", "collision")
# Size elements of each geometry, with the number of values in the element.
SOLIDS = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "ellipsoid": {"radii": 3},
    "mesh": {"scale": 3},
}


class Content(NamedTuple):
    """The links of an SDF with their inertials, and its frames with the link or frame that they are attached to."""

    inertials: Mapping[str, Inertial]
    attached: Mapping[str, str]
    carrier: Mapping[str, str]  # SDF link that each link of the robot moves with (itself, unless it becomes a frame)
    canonical: str  # the canonical link of the model
    weightless: tuple[str, ...]  # moving links without mass, which get ``LEAST``

    def in_order(self, links: Iterable[str]) -> Iterator[str]:
        """Yield links in order, but each frame after the link or frame it is attached to, as Drake 1.51 requires."""
        out: set[str] = set()
        for name in links:
            waiting = [name] if name in self.carrier else []
            while waiting and (above := self.attached.get(waiting[-1], "")) and above not in out:
                waiting.append(above)
            yield from (one for one in reversed(waiting) if one not in out)
            out.update(waiting)

    def has_joint(self, joint: Joint) -> bool:
        """Return True if the SDF has a <joint> for a joint, instead of an attached frame or a free link."""
        merged = joint.parent == self.attached.get(joint.child) or joint.child == self.attached.get(joint.parent)
        return not merged and joint.type not in FREE


def _has_mass(inertial: Inertial | None) -> bool:
    return inertial is not None and inertial.mass != 0


def world_of(robot: Robot) -> str:
    """Return the name of the root link if it represents the world, or "" if it does not."""
    if not robot.is_tree:  # other rules report kinematic loops and several roots
        return ""
    root = robot.link[robot.root]
    is_bare = not (_has_mass(root.inertial) or root.visual or root.collision)
    return root.name if is_bare and root.name == WORLD and len(robot.links) > 1 else ""


def content_of(robot: Robot) -> Content:
    """Determine which links of a robot become links in SDF and which become frames."""
    world = world_of(robot)
    links = [link.name for link in robot.walk() if link.name != world]
    own = {name: inertial for name in links if (inertial := robot.link[name].inertial) and _has_mass(inertial)}
    carrier = {name: name for name in own}
    attached: dict[str, str] = {}

    def attach_down() -> None:
        for name in links:
            above = robot.joint_to.get(name)
            if name not in carrier and above is not None and above.is_fixed and above.parent in carrier:
                attached[name], carrier[name] = above.parent, carrier[above.parent]

    attach_down()
    for name in reversed(links):
        below = (joint.child for joint in robot.joints_from.get(name, ()) if joint.is_fixed and joint.child in carrier)
        if name not in carrier and (heavy := next(below, "")):
            attached[name], carrier[name] = heavy, carrier[heavy]
    held = {joint.child for joint in robot.joints if joint.is_fixed and joint.parent != world}
    tops = tuple(name for name in links if name not in carrier and name not in held)
    carrier |= {name: name for name in tops}
    attach_down()
    inertials = {name: own.get(name, LEAST) for name in links if carrier[name] == name}
    return Content(inertials, attached, carrier, carrier[links[0]], tops)


def version_of(robot: Robot, output: Output) -> str:
    """Return the SDF version of an output as a string; YAML parses 1.10 as the number 1.1."""
    if (asked := output.options.get("version")) is not None:
        return "1.10" if asked == 1.1 else str(asked)
    return FOLLOWERS if any(joint.mimic for joint in robot.joints) else OLDEST


def joint_names(robot: Robot) -> Mapping[str, str]:
    """Return the name of each joint in the SDF, with a suffix if a link or frame has the same name."""
    taken, names = {*robot.link, *robot.joint}, {}
    for name in robot.joint:
        names[name] = name
        while names[name] in robot.link or (names[name] != name and names[name] in taken):
            names[name] += "_joint"
        taken.add(names[name])
    return names


def view(robot: Robot, output: Output) -> Robot:
    """Return the expected contents of the SDF of a robot: frames, joint limits, masses and collision shapes."""
    followers = version_of(robot, output) in (FOLLOWERS, NEWEST)
    names, world = joint_names(robot), world_of(robot)
    links, joints, form = list[Link](), list[Joint](), str(output.options.get("height_maps", "rows"))
    for link in robot.links:
        solids = [solid for shape in link.collision for solid in shape.solids(form)]
        is_mesh = any(isinstance(solid.geometry, Mesh) for solid in solids)
        bare = () if is_mesh else tuple(Shape(solid.geometry, solid.pose) for solid in solids)
        links.append(Link(link.name, link.inertial if _has_mass(link.inertial) else None, (), bare))
    # ``read`` adds a floating joint to the world for a link without a joint, and then also for the root.
    loose, around = [one for one in robot.joints if one.type in FREE and one.parent != world], world or WORLD
    while not world and around in robot.link:
        around += "_"
    if loose and not world:
        links.append(Link(around))
        joints.append(Joint("", "floating", around, robot.root))
    poses = robot.poses_in_root({}) if loose else {}
    for joint in robot.joints:
        if joint in loose:
            joints.append(Joint("", "floating", around, joint.child, pose_of(poses[joint.child])))
        elif joint.type not in FREE:
            mimic = replace(joint.mimic, joint=names[joint.mimic.joint]) if joint.mimic and followers else None
            limit = joint.limit if joint.moves else None
            if limit is not None:
                known = [limit.known_value(key) for key in ("lower", "upper", "effort")]
                # Readers of SDF ignore large limits. The margin allows for limits that were rounded when written.
                lower, upper, effort = (None if one is None or abs(one) >= 0.99 * UNLIMITED else one for one in known)
                limit = Limit(None, None, effort) if joint.type == "continuous" else Limit(lower, upper, effort)
            name, axis = (names[joint.name], joint.axis) if joint.moves else ("", (1.0, 0.0, 0.0))
            joints.append(Joint(name, joint.type, joint.parent, joint.child, joint.origin, axis, limit, mimic))
    return Robot(robot.name, tuple(links), tuple(joints))


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Report names that SDF does not allow for a model, link, frame or joint."""
    robot, world = case.robot, world_of(case.robot)
    found = [("link", link.name, case.link(link.name)) for link in robot.links if link.name != world]
    found += [("joint", joint.name, case.joint(joint)) for joint in robot.joints]
    for kind, name, path in (*found, ("model", robot.name, ("robot",))):
        if name == WORLD or "::" in name or RESERVED.match(name):
            message = f'no {kind} of {output.file} can be called "{name}": SDF reserves world, __NAME__ and A::B'
            help = "rename it; only a massless root can be world" if (kind, name) == ("link", WORLD) else "rename it"
            yield case.problem("sdf-name", message, path, help, key=kind != "model")


def wrap(tag: str, texts: Sequence[str], **attributes: str) -> Text:
    """Return an XML element with a tag, attributes and child elements."""
    names = "".join(f" {key}={attribute_value(value)}" for key, value in attributes.items())
    if len(texts) == 1 and "\n" not in texts[0] and len(texts[0]) < 80:
        return Text(f"<{tag}{names}>{texts[0]}</{tag}>")
    return Text("\n".join([f"<{tag}{names}>", *indented(texts, "  "), f"</{tag}>"]))


def keep(entry: dict[str, Any], element: Element, text: str) -> int:
    """Append ``text``, the XML of ``element``, to the list ``urdf_elements`` of an entry, and return the list index."""
    entry.setdefault("urdf_elements", []).append(SourceValue(text, element.span))
    return len(entry["urdf_elements"]) - 1


class KeptElements(NamedTuple):
    """Elements kept as XML for the model, its links and its joints, and values for collisions by link and tag."""

    model: list[str]
    links: dict[str, list[str]]
    collisions: dict[str, dict[str, str]]  # values of ``OF_COLLISIONS`` by link and tag
    joints: dict[str, list[str]]
    left_out: dict[str, None]  # elements that SDF does not allow where they are


def sort_elements(robot: Robot, carrier: Mapping[str, str], joints: Collection[str]) -> KeptElements:
    """Assign elements kept as XML to the model, links and joints of an SDF; ``carrier`` maps links to SDF links."""
    found = KeptElements([element.verbatim for element in own_elements(robot.urdf_elements)[0]], {}, {}, {}, {})
    waiting = [(link.name, element) for link in robot.links for element in own_elements(link.urdf_elements)[0]]
    blocks = list(_elements(robot.urdf_elements, "gazebo"))
    waiting += [(block.get("reference"), element) for block in blocks for element in block.children]
    for name, element in waiting:
        tag, is_own, numbers = element.tag, element.parent is not None and element.parent.tag == "sdf", ""
        dynamics = robot.joint[name].dynamics if tag in SPRING and name in robot.joint else None
        if tag in _FOR_CONVERSION or (dynamics is not None and dynamics.stiffness):
            continue
        if tag in OF_COLLISIONS and not is_own:
            with suppress(ValueError):  # elements with invalid values are reported as not written
                words = element.get("value") or element.text
                numbers_of(words, OF_COLLISIONS[tag][2])
                numbers = " ".join(words.split())
        if not name and tag in OF_MODEL:
            found.model.append(element.verbatim)
        elif name in carrier and (is_own or tag in OF_LINK):
            text = element.verbatim if carrier[name] == name else _relative_to(element, name)
            found.links.setdefault(carrier[name], []).append(with_noise(text))
        elif numbers and name in carrier and robot.link[name].collision:
            found.collisions.setdefault(name, {})[tag] = numbers
        elif name in joints and tag in OF_JOINT:
            found.joints.setdefault(name, []).append(element.verbatim)
        else:
            found.left_out[f"<{tag}>{f' of {name}' if name else ''}"] = None
    return found


def collision_elements(numbers: Mapping[str, str], present: Collection[str]) -> list[str]:
    """Convert Gazebo classic values of a link to elements of a <collision>, except for tags in ``present``."""
    made, parts = list[str](), dict[str, str]()
    for word, (name, part, _) in OF_COLLISIONS.items():
        text = f"<{name}>{numbers[word]}</{name}>" if word in numbers else ""
        if text and part:
            parts[part] = parts.get(part, "") + text
        elif text and name not in present:
            made.append(text)
    surface = "".join(f"<{part}><ode>{inner}</ode></{part}>" for part, inner in parts.items())
    return [*made, f"<surface>{surface}</surface>"] if surface and "surface" not in present else made


def own_elements(texts: Sequence[str], *within: str) -> tuple[list[Element], Mapping[str, list[str]]]:
    """Return the contents of all <sdf> blocks: (elements, XML of the child elements of each path in ``within``)."""
    found, inner = list[Element](), dict[str, list[str]]()
    waiting = [("", block) for block in _elements(texts, "sdf")]
    for above, block in waiting:  # the loop appends to ``waiting``
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
    for text in (text for text in texts if f"<{tag}" in text):
        try:
            document = parse(Source("", f"<all>{text}</all>"))
        except MarkupError:  # only if the text is too large; rules check the syntax
            continue
        yield from (block for block in document.root.children if block.tag == tag)


def _relative_to(element: Element, frame: str) -> str:
    """Return an element as XML, with its pose relative to ``frame`` instead of to its link."""
    pose = next((child for child in element.children if child.tag == "pose"), None)
    text, word, at = element.verbatim, f' relative_to="{frame}"', element.opened - element.start
    if element.tag not in _POSED or (pose is not None and {"relative_to", "frame"} & pose.values.keys()):
        return text
    if pose is not None:
        at = pose.start - element.start + len("<pose")
        return f"{text[:at]}{word}{text[at:]}"
    if element.end == element.opened:  # self-closing: <sensor .../>
        return f"{text[: at - 2]}><pose{word}/></{element.tag}>"
    return f"{text[:at]}<pose{word}/>{text[at:]}"

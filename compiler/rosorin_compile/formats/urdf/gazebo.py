"""Blocks for Gazebo in a URDF: ``<gazebo reference="LINK">`` with sensors, springs and friction.

Gazebo turns a URDF to SDF with libsdformat. That drops every link without mass, merges what fixed joints hold together
into one link (a sensor moves along, its reference stays good), and names collisions after the link that they end up in
(``gazebosim/sdformat@sdf14:src/parser_urdf.cc``; run with libsdformat 12).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from rosorin_compile.model import Sensor
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.simulation import CLASSIC, GazeboSensor
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.numbers import number_format, vector
from rosorin_compile.source.wording import plural, quote
from rosorin_compile.source.xml.elements import tree_of

from ..gazebo_elements import DISTRIBUTIONS, distribution, sensor_lines
from ..templating import attributes

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from .write import Content

_KEEPING = ("preserveFixedJoint", "disableFixedJointLumping")


def gazebo_blocks(content: Content) -> tuple[list[str], list[Diagnostic]]:
    """Return the <gazebo> blocks of an output, and what this Gazebo ignores."""
    writer = _SensorWriter(content)
    pairs = [(sensor, one) for sensor in content.robot.sensors for one in sensor.gazebo]
    blocks = [block for sensor, one in pairs if (block := writer.sensor(sensor, one))]
    lost = []
    for (why, way), names in writer.unseen.items():
        message = f"Gazebo does not see {plural('sensor', len(names))} {quote(names, 3)}: {why}"
        help = f"{way}; or leave the sensor out: gazebo: []"
        lost.append(Diagnostic("gazebo-cannot-see", WARNING, message, help=help))
    physics, lost_physics = _physics(content)
    return [*blocks, *physics], [*lost, *lost_physics]


def _blocks_in(elements: Iterable[str]) -> Iterator[Element]:
    for text in elements:
        if "<gazebo" in text:
            yield from tree_of(f"<all>{text}</all>").iter("gazebo")


def _physics(content: Content) -> tuple[list[str], list[Diagnostic]]:
    """Return the blocks for springs of joints and friction of links; Gazebo reads one coefficient a link."""
    robot, number = content.robot, number_format(content.output.options)
    own = {(block.get("reference", ""), inner.tag) for block in _blocks_in(robot.urdf_elements) for inner in block}
    values: dict[str, dict[str, float]] = {}
    lost, mixed, balls = list[tuple[str, str]](), list[str](), list[str]()
    for link in robot.links:
        shapes = content.collisions(link.name) if link.name in content.carried else ()
        coefficients = {shape.contact.sliding_friction if shape.contact else None for shape in shapes}
        known = [one for one in coefficients if one is not None]
        if known and not {(link.name, "mu1"), (link.name, "mu2")} & own:
            values[link.name] = {"mu1": min(known), "mu2": min(known)}
            mixed += [link.name] if len(coefficients) > 1 else []
    for joint in content.joints if "dynamics" in content.elements else ():
        spring = joint.dynamics
        if spring is not None and spring.stiffness and not joint.moves:
            balls.append(joint.name)
        elif spring is not None and spring.stiffness and (joint.name, "springStiffness") not in own:
            values[joint.name] = {"springReference": spring.spring_reference, "springStiffness": spring.stiffness}
    blocks = []
    for name, numbers in values.items():
        lines = [f"    <{tag}>{number(value)}</{tag}>" for tag, value in numbers.items()]
        blocks.append("\n".join([f"  <gazebo{attributes(reference=name)}>", *lines, "  </gazebo>"]))
    if balls:
        message = f"Gazebo reads no springs of joints that move in several directions: {quote(balls, 3)}"
        lost.append((message, "make each of them several joints, one for each axis"))
    if mixed:
        message = f"shapes of {quote(mixed, 3)} differ in friction, and Gazebo reads one a link from a URDF: the least"
        lost.append((message, "give each shape a link of its own, or use the SDF"))
    return blocks, [Diagnostic("urdf-cannot-say", WARNING, message, help=help) for message, help in lost]


class _Merged:
    """The links that Gazebo makes of those of a URDF: what fixed joints hold together is one, called like its top."""

    def __init__(self, content: Content, kept: set[str]) -> None:
        self.content, self.above = content, {joint.child: joint for joint in content.joints}
        self.merging = {joint.child for joint in content.joints if joint.is_fixed and joint.name not in kept}
        self.below: dict[str, list[str]] = {}
        for joint in sorted(content.joints, key=lambda joint: joint.name):  # urdfdom has them by name
            if joint.child in self.merging:
                self.below.setdefault(joint.parent, []).append(joint.child)

    def top(self, link: str) -> str:
        while link in self.merging:
            link = self.above[link].parent
        return link

    def pieces(self, top: str) -> Iterator[str]:
        """Yield the links that one of Gazebo is made of, in the order of their collisions in it."""
        yield top
        for child in self.below.get(top, ()):
            yield from self.pieces(child)

    def dropped_with(self, link: str) -> str:
        """Return the link without mass that Gazebo drops with all below it, this link among them; empty if none."""
        masses, link = self.content.masses, self.top(link)
        while any(piece in masses and masses[piece].mass > 0 for piece in self.pieces(link)):
            if link not in self.above:
                return ""
            link = self.above[link].parent  # also one that is merged: what moves on it is dropped if it has no mass
        return link

    def collisions(self, link: str) -> list[str]:
        """Return what Gazebo calls the collisions of a link, which are numbered in the link that it becomes."""
        top = self.top(link)
        shapes = [(piece, shape) for piece in self.pieces(top) for shape in self.content.collisions(piece)]
        found = []
        for index, (piece, base) in enumerate((piece, shape.name or piece) for piece, shape in shapes):
            # It takes every name that begins like the link for one of the link's own.
            name = base if base.startswith(top) else f"{top}_fixed_joint_lump__{base}"
            found += [f"{name}_collision{f'_{index}' if index else ''}"] if piece == link else []
        return found


class _SensorWriter:
    """Writes the sensors of a URDF; ``unseen`` has the names of those that Gazebo drops, by why and what to do."""

    def __init__(self, content: Content) -> None:
        self.content, self.robot = content, content.robot
        name = distribution(content.output.options["gazebo"])
        self.frame_id, self.classic = DISTRIBUTIONS[name], name == CLASSIC
        self.number = number_format(content.output.options)
        elements = self.robot.urdf_elements if "urdf_elements" in content.elements else ()
        blocks = _blocks_in(text for text in elements if any(word in text for word in _KEEPING))
        kept = [one for one in blocks if any(one.findtext(word, "").strip() in ("true", "1") for word in _KEEPING)]
        self.kept = {one.get("reference", "") for one in kept}
        # Fixed joints that sensors measure at are not merged, where both ends have mass: that comes before all else.
        joints = {joint.name for joint in content.joints}
        at_joints = {one.link for sensor in self.robot.sensors for one in sensor.gazebo if one.at_joint} & joints
        ends = {name: self.robot.joint[name].child for name in at_joints}
        self.measured = {
            name for name, end in ends.items() if not _Merged(content, {*self.kept, name}).dropped_with(end)
        }
        self.merged = _Merged(content, self.kept | self.measured)
        self.unseen: dict[tuple[str, str], list[str]] = {}

    def sensor(self, sensor: Sensor, one: GazeboSensor) -> str:
        link, pose, names, lost, reason = one.link, IDENTITY, list[str](), "", ("", "")
        if one.at_joint:
            lost = "" if one.link in self.measured else sensor.frame
        else:
            frame, pose = (one.feels, IDENTITY) if one.feels else (one.link, one.pose)
            link, transform = frame, pose.transform()
            while link not in self.content.carried:
                above = self.robot.joint_to.get(link)
                if above is None or not above.is_fixed:
                    link = ""
                    break
                transform = above.origin.transform().then(transform)
                link, pose = above.parent, pose_of(transform)
            lost = frame if not link or (one.feels and link != frame) else self.merged.dropped_with(link)
            names = self.merged.collisions(link) if one.feels and not lost else []
            if one.feels and not lost and not names:
                reason = f'link "{link}" has no shape in this URDF that could feel', "give it a collision"
        if lost and lost not in self.content.carried:
            reason = f'the URDF has no link "{lost}"', "let robot_state_publisher publish it"
        elif lost and "inertial" not in self.content.elements:
            reason = "it drops links without mass, and no link of this URDF has one", "add inertial to elements"
        elif lost:
            way = "give it an inertial, or what is fixed to it"
            reason = f'it drops link "{lost}", which has no mass in this URDF', way
        if reason[0]:
            unseen = self.unseen.setdefault(reason, [])
            unseen += [] if sensor.name in unseen else [sensor.name]
            return ""
        lines = [f"  <gazebo{attributes(reference=link)}>"]
        if one.at_joint and self.robot.joint[one.link].is_fixed and one.link not in self.kept:
            lines.append("    <preserveFixedJoint>true</preserveFixedJoint>")
        numbers = f"{vector(pose.xyz, self.number)} {vector(pose.rpy, self.number)}"
        place = "" if pose == IDENTITY else f"<pose>{numbers}</pose>"
        written = one.in_classic() if self.classic else one
        lines += sensor_lines(written, self.frame_id, self.number, "    ", place, names)
        return "\n".join([*lines, "  </gazebo>"])

"""Sensors of Gazebo in a URDF: ``<gazebo reference="LINK"><sensor>``, as Gazebo reads them out of it.

Gazebo turns a URDF to SDF with libsdformat. That drops every link without mass, merges what fixed joints hold together
into one link (a sensor moves along, its reference stays good), and names collisions after the link that they end up in
(``gazebosim/sdformat@sdf14:src/parser_urdf.cc``; run with libsdformat 12).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from typing import NamedTuple

from rosorin_compile.model import Inertial, Joint, Pose, Robot, Sensor
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.simulation import CLASSIC, GazeboSensor
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.numbers import NumberFormat, vector
from rosorin_compile.source.rule_registry import FORMATS, Rule
from rosorin_compile.source.wording import quoted
from rosorin_compile.source.xml.elements import tree_of

from ..gazebo_sensors import DISTRIBUTIONS, sensor_lines
from ..templating import attributes

RULES = (
    Rule(
        "gazebo-cannot-see",
        "A warning: a sensor is not written for Gazebo, or sits on a link that Gazebo drops, because it has no mass.",
        "Give the link an `inertial`, and keep it in `elements`; or leave the sensor out: `gazebo: []`.",
        FORMATS,
    ),
)


class Carried(NamedTuple):
    """What a URDF has: its links and joints, whether it has inertials, and the names of the collisions of a link.

    ``masses``: the inertials by link. ``kept``: the fixed joints that the description itself keeps from being merged.
    """

    links: Set[str]
    joints: Sequence[Joint]
    inertials: bool
    masses: Mapping[str, Inertial]
    collisions: Callable[[str], Sequence[str]]
    kept: Set[str]


def sensors(robot: Robot, carried: Carried, asked: str, number: NumberFormat) -> tuple[list[str], list[Diagnostic]]:
    """Return the blocks of all sensors for one Gazebo, and what it will not see."""
    writer = _Writer(robot, carried, asked, number)
    # The joints that are measured at are no joints of a merged link: that comes before all else.
    writer.merged.kept.update(one.link for sensor in robot.sensors for one in sensor.gazebo if writer.measures(one))
    blocks = [block for sensor in robot.sensors for one in sensor.gazebo for block in writer.block(sensor, one)]
    return blocks, [_not_seen(names, *why) for why, names in writer.unseen.items()]


def physics(
    robot: Robot, frictions: Mapping[str, Set[float | None]], joints: Sequence[Joint], number: NumberFormat
) -> tuple[list[str], list[Diagnostic]]:
    """Return the blocks for what a URDF has no word for and Gazebo reads: springs of joints and friction of links.

    ``frictions`` are the coefficients of the collision shapes of each link, None for a shape without. Gazebo reads one
    coefficient a link. What the description already has in a ``<gazebo>`` of its own is left as it is.
    """
    own = {
        (block.get("reference", ""), inner.tag)
        for text in robot.urdf_elements
        if "<gazebo" in text
        for block in tree_of(f"<all>{text}</all>").iter("gazebo")
        for inner in block
    }
    wanted: dict[str, dict[str, float]] = {}
    mixed = []
    for link, coefficients in frictions.items():
        given = [one for one in coefficients if one is not None]
        if given and not {(link, "mu1"), (link, "mu2")} & own:
            wanted[link] = {"mu1": min(given), "mu2": min(given)}
            mixed += [link] if len(coefficients) > 1 else []
    for joint in joints:
        spring = joint.dynamics if joint.moves else None
        if spring is not None and spring.stiffness and (joint.name, "springStiffness") not in own:
            wanted[joint.name] = {"springReference": spring.spring_reference, "springStiffness": spring.stiffness}
    blocks = [
        "\n".join(
            [
                f"  <gazebo{attributes(reference=name)}>",
                *(f"    <{tag}>{number(value)}</{tag}>" for tag, value in values.items()),
                "  </gazebo>",
            ]
        )
        for name, values in wanted.items()
    ]
    if not mixed:
        return blocks, []
    message = f"shapes of {quoted(mixed, 3)} differ in friction, and Gazebo reads one a link from a URDF: the least"
    help = "give each shape a link of its own, or use the SDF"
    return blocks, [Diagnostic("urdf-cannot-say", WARNING, message, help=help)]


def _not_seen(names: Sequence[str], why: str, way: str) -> Diagnostic:
    which = f"{'sensors' if len(names) > 1 else 'sensor'} {quoted(names, 3)} {'are' if len(names) > 1 else 'is'}"
    help = f"{way}; or leave the sensor out: gazebo: []"
    return Diagnostic("gazebo-cannot-see", WARNING, f"{which} not seen by Gazebo: {why}", help=help)


def kept_joints(elements: Iterable[str]) -> frozenset[str]:
    """Return the fixed joints that elements of a description keep from being merged."""
    words = ("preserveFixedJoint", "disableFixedJointLumping")
    kept = set()
    for text in elements:
        if any(word in text for word in words):
            for block in tree_of(f"<all>{text}</all>"):
                said = (block.findtext(word, "").strip() for word in words)
                kept |= {block.get("reference", "")} if any(one in ("true", "1") for one in said) else set()
    return frozenset(kept)


class _Merged:
    """The links that Gazebo makes of those of a URDF: what fixed joints hold together is one, called like its top."""

    def __init__(self, robot: Robot, carried: Carried) -> None:
        self.robot = robot
        self.carried = carried
        self.kept = set(carried.kept)
        self.above = {joint.child: joint for joint in carried.joints}
        self.below: dict[str, list[Joint]] = {}
        for joint in sorted(carried.joints, key=lambda joint: joint.name):  # urdfdom has them by name
            self.below.setdefault(joint.parent, []).append(joint)

    def _merges(self, joint: Joint | None) -> bool:
        return joint is not None and joint.is_fixed and joint.name not in self.kept

    def top(self, link: str) -> str:
        """Return the link of Gazebo that a link becomes a piece of."""
        while self._merges(above := self.above.get(link)):
            assert above is not None  # noqa: S101 - it merges
            link = above.parent
        return link

    def pieces(self, top: str) -> Iterator[str]:
        """Yield the links that one of Gazebo is made of, in the order of their collisions in it."""
        waiting = [top]
        while waiting:
            link = waiting.pop()
            yield link
            waiting += [joint.child for joint in reversed(self.below.get(link, ())) if self._merges(joint)]

    def dropped(self, link: str) -> str:
        """Return the link without mass that Gazebo drops with all below it, this link among them; empty if none."""
        link = self.top(link)
        while True:
            inertials = (self.carried.masses.get(piece) for piece in self.pieces(link))
            if not any(one is not None and one.mass > 0 for one in inertials):
                return link
            if link not in self.above:
                return ""
            link = self.above[link].parent  # also one that is merged: what moves on it is dropped if it has no mass

    def collisions(self, link: str) -> list[str]:
        """Return what Gazebo calls the collisions of a link."""
        top, found, index = self.top(link), [], 0
        for piece in self.pieces(top):
            for own in self.carried.collisions(piece):
                base = own or piece
                # It takes every name that begins like the link for one of the link's own.
                base = base if base.startswith(top) else f"{top}_fixed_joint_lump__{base}"
                found += [f"{base}_collision{f'_{index}' if index else ''}"] if piece == link else []
                index += 1
        return found


class _Writer:
    def __init__(self, robot: Robot, carried: Carried, asked: str, number: NumberFormat) -> None:
        self.robot = robot
        self.carried = carried
        self.frame_id, self.classic = DISTRIBUTIONS[asked], asked == CLASSIC
        self.number = number
        self.merged = _Merged(robot, carried)
        self.unseen: dict[tuple[str, str], list[str]] = {}

    def measures(self, one: GazeboSensor) -> bool:
        """Say whether a sensor measures at a joint of the URDF that has mass on both of its ends."""
        if not one.at_joint or one.link not in {joint.name for joint in self.carried.joints}:
            return False
        trial = _Merged(self.robot, self.carried)
        trial.kept.add(one.link)
        return not trial.dropped(self.robot.joint[one.link].child)

    def block(self, sensor: Sensor, one: GazeboSensor) -> Iterator[str]:
        """Yield the block of a sensor; nothing for one that Gazebo cannot have, after telling."""
        if one.at_joint:
            if one.link in self.merged.kept:
                yield from self._text(one, one.link, IDENTITY, keep=self._may_merge(one.link))
            else:
                self._tell(sensor, *self._why_not(sensor.frame))
            return
        link, pose = self._carrier(one.feels or one.link, IDENTITY if one.feels else one.pose)
        if not link or (one.feels and link != one.feels):
            self._tell(sensor, *self._why_not(one.feels or one.link))
            return
        names = self.merged.collisions(link) if one.feels else ()
        top = self.merged.dropped(link)
        if top:
            self._tell(sensor, *self._massless(top))
        elif one.feels and not names:
            self._tell(sensor, f'link "{link}" has no shape in this URDF that could feel', "give it a collision")
        else:
            yield from self._text(one, link, pose, collisions=names)

    def _may_merge(self, joint: str) -> bool:
        """Say whether Gazebo would merge the ends of a joint if nobody kept it from that."""
        return self.robot.joint[joint].is_fixed and joint not in self.carried.kept

    def _why_not(self, link: str) -> tuple[str, str]:
        if link in self.carried.links:
            return self._massless(link)
        return f'the URDF has no link "{link}"', "let robot_state_publisher publish it"

    def _massless(self, link: str) -> tuple[str, str]:
        if not self.carried.inertials:
            return "it drops links without mass, and no link of this URDF has one", "add inertial to elements"
        why = f'it drops link "{link}", which has no mass in this URDF'
        return why, "give it an inertial, or what is fixed to it"

    def _tell(self, sensor: Sensor, why: str, way: str) -> None:
        names = self.unseen.setdefault((why, way), [])
        if sensor.name not in names:
            names.append(sensor.name)

    def _carrier(self, link: str, pose: Pose) -> tuple[str, Pose]:
        """Return the link of the URDF that carries a frame, empty if no fixed joint leads there, and the pose in it."""
        transform = pose.transform()
        while link not in self.carried.links:
            above = self.robot.joint_to.get(link)
            if above is None or not above.is_fixed:
                return "", pose
            transform = above.origin.transform().then(transform)
            link, pose = above.parent, pose_of(transform)
        return link, pose

    def _text(
        self, one: GazeboSensor, reference: str, pose: Pose, keep: bool = False, collisions: Sequence[str] = ()
    ) -> Iterator[str]:
        lines = [f"  <gazebo{attributes(reference=reference)}>"]
        if keep:
            lines.append("    <preserveFixedJoint>true</preserveFixedJoint>")
        numbers = f"{vector(pose.xyz, self.number)} {vector(pose.rpy, self.number)}"
        place = "" if pose == IDENTITY else f"<pose>{numbers}</pose>"
        said = one.in_classic() if self.classic else one
        lines += sensor_lines(said, self.frame_id, self.number, "    ", place, collisions)
        yield "\n".join([*lines, "  </gazebo>"])

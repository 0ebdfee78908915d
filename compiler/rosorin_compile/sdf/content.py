"""What an SDF contains of a robot: which links are a <link>, and which a <frame> that is attached to one.

A link of SDF without an inertial weighs 1 kg, so that links without mass are frames. What has mass is a link, and what
moves without any: that has the least mass. A link called "world", the root of a robot that stands fast, is the world.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.model import Inertial, Joint, Limit, Link, Mesh, Output, Robot, Shape
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import Heading, Rule

from .elements import RESERVED, WORLD

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

FOLLOWERS = "1.11"  # the first version with a word for mimic
OLDEST, NEWEST = "1.9", "1.12"
UNLIMITED = 1e16  # a limit from here on is none
FREE = ("floating", "planar")  # joints that SDF has no word for: the child is free to move in the world
# What moves and has no mass: so little that it changes no motion, as much as engines take (kg, kg*m^2).
LEAST = Inertial(1e-6, IDENTITY, 1e-9, 1e-9, 1e-9)


class Content(NamedTuple):
    """The links of an SDF with their inertials, and its frames with what they are attached to.

    ``carrier`` is the link of SDF for each link, itself or the one that it is a frame of; the world has none.
    ``canonical`` is the link that stands for the whole model, ``weightless`` are links that have the least mass.
    """

    inertials: Mapping[str, Inertial]
    attached: Mapping[str, str]
    carrier: Mapping[str, str]
    canonical: str
    weightless: tuple[str, ...]

    def in_order(self, links: Iterable[str]) -> Iterator[str]:
        """Yield links in their order, but a frame after what it is attached to: Drake 1.51 places it wrongly before."""
        out: set[str] = set()
        for name in links:
            waiting = [name]
            while waiting[-1] in self.attached and self.attached[waiting[-1]] not in out:
                waiting.append(self.attached[waiting[-1]])
            for one in reversed(waiting):
                if one in self.carrier and one not in out:
                    out.add(one)
                    yield one

    def has_joint(self, joint: Joint) -> bool:
        """Return True if a joint is a <joint>: not where a frame is attached, nor where a link is free to move."""
        merged = joint.parent == self.attached.get(joint.child) or joint.child == self.attached.get(joint.parent)
        return not merged and joint.type not in FREE


def _has_mass(inertial: Inertial | None) -> bool:
    return inertial is not None and inertial.mass != 0


def world_of(robot: Robot) -> str:
    """Return the link that is the world itself, or an empty text."""
    if not robot.is_tree:  # reported by a rule
        return ""
    root = robot.link[robot.root]
    is_bare = not (_has_mass(root.inertial) or root.visual or root.collision)
    return root.name if is_bare and root.name == WORLD and len(robot.links) > 1 else ""


def content_of(robot: Robot) -> Content:
    """Return which links of a robot are links of its SDF, and which are frames."""
    world = world_of(robot)
    links = [link.name for link in robot.walk() if link.name != world]
    own = {name: inertial for name in links if (inertial := robot.link[name].inertial) and _has_mass(inertial)}
    carrier = {name: name for name in own}
    attached: dict[str, str] = {}

    def attach_down() -> None:
        """Attach what has no mass to what it is fixed to, from the root down."""
        for name in links:
            above = robot.joint_to.get(name)
            if name not in carrier and above is not None and above.is_fixed and above.parent in carrier:
                attached[name], carrier[name] = above.parent, carrier[above.parent]

    attach_down()
    for name in reversed(links):
        below = (joint.child for joint in robot.joints_from.get(name, ()) if joint.is_fixed and joint.child in carrier)
        if name not in carrier and (heavy := next(below, "")):
            attached[name], carrier[name] = heavy, carrier[heavy]
    tops = []
    for name in links:
        above = robot.joint_to.get(name)
        if name not in carrier and (above is None or not above.is_fixed or above.parent == world):
            tops.append(name)
    carrier |= {name: name for name in tops}
    attach_down()
    inertials = {name: own.get(name, LEAST) for name in links if carrier[name] == name}
    return Content(inertials, attached, carrier, carrier[links[0]], tuple(tops))


def version_of(robot: Robot, output: Output) -> str:
    """Return the version of an output as text: YAML reads 1.9 as a number."""
    asked = output.options.get("version")
    if asked is not None:
        return "1.10" if asked == 1.1 else str(asked)
    return FOLLOWERS if any(joint.mimic for joint in robot.joints) else OLDEST


def joint_names(robot: Robot) -> Mapping[str, str]:
    """Return the name of each joint in the SDF, whose links, frames and joints share their names."""
    links = {link.name for link in robot.links}
    taken = links | {joint.name for joint in robot.joints}
    names = {}
    for joint in robot.joints:
        name = joint.name
        while name in links or (name != joint.name and name in taken):
            name += "_joint"
        taken.add(name)
        names[joint.name] = name
    return names


def view(robot: Robot, output: Output) -> Robot:
    """Return what an SDF has to contain at least: frames, what joints may do, masses, and what collides."""
    followers = version_of(robot, output) in (FOLLOWERS, NEWEST)
    names, world = joint_names(robot), world_of(robot)
    form = str(output.options.get("height_maps", "rows"))
    links, joints = [], []
    for link in robot.links:
        solids = [solid for shape in link.collision for solid in shape.solids(form)]
        bare = tuple(Shape(solid.geometry, solid.pose) for solid in solids)
        if any(isinstance(solid.geometry, Mesh) for solid in solids):
            bare = ()
        links.append(Link(link.name, link.inertial if _has_mass(link.inertial) else None, (), bare))
    # A link that no joint of the SDF holds is read as one that floats in the world, and so is the root then.
    loose = [joint for joint in robot.joints if joint.type in FREE and joint.parent != world]
    around = world or WORLD
    while loose and not world and around in robot.link:
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
                known = [limit.known(key) for key in ("lower", "upper", "effort")]
                # SDF takes large limits as none; the margin is for those that printing rounds up.
                lower, upper, effort = (None if one is None or abs(one) >= 0.99 * UNLIMITED else one for one in known)
                limit = Limit(None, None, effort) if joint.type == "continuous" else Limit(lower, upper, effort)
            name, axis = (names[joint.name], joint.axis) if joint.moves else ("", (1.0, 0.0, 0.0))
            joints.append(Joint(name, joint.type, joint.parent, joint.child, joint.origin, axis, limit, mimic))
    return Robot(robot.name, tuple(links), tuple(joints))


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find names that no model, link, frame or joint of an SDF can have."""
    robot = case.robot
    found = [("link", link.name, case.link(link.name)) for link in robot.links if link.name != world_of(robot)]
    found += [("joint", joint.name, case.joint(joint)) for joint in robot.joints]
    for kind, name, path in (*found, ("model", robot.name, ("robot",))):
        why = "that is the world itself" if name == WORLD else ":: leads into a model" if "::" in name else ""
        why = why or ("SDF keeps names between two underscores for itself" if RESERVED.match(name) else "")
        if why:
            may = name == WORLD and kind == "link"
            help = "rename it; a root that is nothing but the world may have this name" if may else "rename it"
            message = f'no {kind} of {output.file} can be called "{name}": {why}'
            yield case.problem("sdf-name", message, path, help, key=kind != "model")

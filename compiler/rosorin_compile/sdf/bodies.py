"""Bodies: which links are a <link> of SDF, and which a <frame> that is attached to one.

A link of SDF without an inertial weighs 1 kg, so that links without mass are frames. What has mass is a link, and what
moves without any: that has the least mass. A link called "world", the root of a robot that stands fast, is the world.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from rosorin_compile.model import Inertial, Joint, Robot
from rosorin_compile.model.geometry import IDENTITY

from .words import world_of

# What moves and has no mass: so little that it changes no motion, as much as engines take (kg, kg*m^2).
LEAST = Inertial(1e-6, IDENTITY, 1e-9, 1e-9, 1e-9)


class Bodies(NamedTuple):
    """The links of an SDF with their inertials, and its frames with what they are attached to.

    ``carrier`` is the link of SDF that a link is, or is a frame of; the world has none. ``canonical`` is the link that
    stands for the whole model. ``weightless`` are links that have the least mass, for want of another.
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

    def says(self, joint: Joint) -> bool:
        """Say whether a joint is a <joint>: not where a frame is attached, nor where a link is free to move."""
        merged = joint.parent == self.attached.get(joint.child) or joint.child == self.attached.get(joint.parent)
        return not merged and joint.type not in ("floating", "planar")


def has_mass(inertial: Inertial | None) -> bool:
    """Say whether an inertial is that of a body."""
    return inertial is not None and inertial.mass != 0


def bodies_of(robot: Robot) -> Bodies:
    """Return which links of a robot are links of its SDF, and which are frames."""
    world = world_of(robot)
    links = [link.name for link in robot.walk() if link.name != world]
    own = {name: inertial for name in links if (inertial := robot.link[name].inertial) and has_mass(inertial)}
    carrier = {name: name for name in own}
    attached: dict[str, str] = {}
    _attach_down(robot, links, carrier, attached)
    for name in reversed(links):
        below = (joint.child for joint in robot.joints_from.get(name, ()) if joint.is_fixed)
        heavy = next((child for child in below if child in carrier), "") if name not in carrier else ""
        if heavy:
            attached[name], carrier[name] = heavy, carrier[heavy]
    tops = [name for name in links if name not in carrier and not _hangs(robot, name, world)]
    carrier |= {name: name for name in tops}
    _attach_down(robot, links, carrier, attached)
    inertials = {name: own.get(name, LEAST) for name in links if carrier[name] == name}
    return Bodies(inertials, attached, carrier, carrier[links[0]], tuple(tops))


def _hangs(robot: Robot, name: str, world: str) -> bool:
    """Say whether a link is fixed to another one."""
    above = robot.joint_to.get(name)
    return above is not None and above.is_fixed and above.parent != world


def _attach_down(robot: Robot, links: list[str], carrier: dict[str, str], attached: dict[str, str]) -> None:
    """Attach what has no mass to what it is fixed to, from the root down."""
    for name in links:
        above = robot.joint_to.get(name)
        if name not in carrier and above is not None and above.is_fixed and above.parent in carrier:
            attached[name], carrier[name] = above.parent, carrier[above.parent]

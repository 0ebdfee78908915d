"""Not compared: what one of two formats has no word for, or what one file leaves out as a whole."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from rosorin_compile.language.annotations import ENTRIES, ITEMS, sections
from rosorin_compile.model import Joint, Robot
from rosorin_compile.source.wording import plural

from .difference import YAML, Side
from .pairing import Pairing
from .rest import count_simulated
from .sentences import several

Count = Callable[[Robot], int]


def _joints(has: Callable[[Joint], object]) -> Count:
    return lambda robot: sum(bool(has(joint)) for joint in robot.joints if not joint.is_fixed)


def _elements(robot: Robot) -> list[tuple[str, ...]]:
    links, joints = ([one.urdf_elements for one in many] for many in (robot.links, robot.joints))
    return [robot.urdf_elements, *links, *joints]


def _said_in(topic: str) -> Count:
    """Return what counts what a robot says in the section of a topic."""

    def count(robot: Robot) -> int:
        said = (getattr(robot, name) for name, node in sections().items() if node.topic == topic)
        return sum(len(one) if isinstance(one, (tuple, Mapping)) else int(one is not None) for one in said)

    return count


# What is compared besides frames, axes and limits: how one of it is called, and how many of it a robot has.
TOPICS: Mapping[str, tuple[str, Count]] = {
    "mass": ("mass", lambda robot: sum(link.inertial is not None for link in robot.links)),
    "collision": ("collision shape", lambda robot: sum(len(link.collision) for link in robot.links)),
    "visual": ("visual shape", lambda robot: sum(len(link.visual) for link in robot.links)),
    "effort": ("effort limit", _joints(lambda joint: joint.limit and joint.limit.effort is not None)),
    "velocity": ("velocity limit", _joints(lambda joint: joint.limit and joint.limit.velocity is not None)),
    "mimic": ("mimic", _joints(lambda joint: joint.mimic)),
    "dynamics": (
        "damping or friction",
        _joints(lambda joint: joint.dynamics and (joint.dynamics.damping or joint.dynamics.friction)),
    ),
    "armature": ("armature", _joints(lambda joint: joint.dynamics and joint.dynamics.armature)),
    "stiffness": ("spring", _joints(lambda joint: joint.dynamics and joint.dynamics.stiffness)),
    "simulation": ("thing of a simulation", count_simulated),
    "actuator": ("actuator", _joints(lambda joint: joint.actuator)),
    "calibration": ("calibration", _joints(lambda joint: joint.calibration)),
    "safety": ("safety controller", _joints(lambda joint: joint.safety)),
    "pose": ("named pose", _said_in("pose")),
    "servo": ("servo group", _said_in("servo")),
    "sensor": ("sensor", _said_in("sensor")),
    "drive": ("drive", _said_in("drive")),
    "contact": ("disabled contact", _said_in("contact")),
    "publisher": (
        "publisher",
        lambda robot: len({(j.publisher.kind, j.publisher.name) for j in robot.joints}),
    ),
    "edge": ("transform of other nodes", _said_in("edge")),
    "fixed joint name": ("name of fixed joints", lambda robot: sum(joint.is_fixed for joint in robot.joints)),
    "urdf_elements": (
        "element for URDF alone",
        lambda robot: sum(len(texts) for texts in _elements(robot)),
    ),
}
# What a format may lack beside these topics: capsules (cylinders stand for them), and more than one box a link.
CAPSULE, ONE_BOX = "capsule", "several shapes"
# What a writer leaves out as a whole, by an option or by its nature, rather than here and there.
_WHOLE = ("mass", "collision", "visual", "effort", "velocity", "dynamics", "armature", "actuator", "pose", "servo")


class Unsaid(NamedTuple):
    """The topics that are not compared, and the sentences that say so."""

    topics: frozenset[str]
    lines: list[str]


def uncompared(a: Side, b: Side) -> Unsaid:
    """Return what is not compared between two robots of these formats."""
    topics: set[str] = set()
    lines: list[str] = []
    for side, other in ((a, b), (b, a)):
        lacks = [
            topic for topic in TOPICS if topic in side.format.writing.lacks and topic not in other.format.writing.lacks
        ]
        lines += _line(side, other, lacks, "a format without a word for it")
        empty = [
            topic
            for topic in _WHOLE
            if side.format != other.format
            and topic not in side.format.writing.lacks
            and not TOPICS[topic][1](side.robot)
        ]
        lines += _line(side, other, empty, "which leaves out all of it")
        topics |= {*lacks, *empty, *side.format.writing.lacks}
    lines += [*_outside(a, b), *_outside(b, a)]
    if a.format != b.format and "contact" not in topics:
        # What a simulation excludes beside what was asked for are the contacts of neighbours.
        topics.add("contact")
        counts = [TOPICS["contact"][1](side.robot) for side in (a, b)]
        if any(counts):
            lines += [f"{counts[0]} and {counts[1]} disabled contacts: a simulation adds those of neighbours"]
    return Unsaid(frozenset(topics), lines)


def _outside(side: Side, other: Side) -> list[str]:
    """Return the sentence on sections of a description that no format has a word for."""
    if side.format is YAML:
        return []
    own = ((sections()[name], section) for name, section in other.robot.sections.said.items())
    counts = [(node.compared, len(section) if node.merge in (ENTRIES, ITEMS) else 1) for node, section in own]
    return _sentence(side, counts, "a format without a word for it")


def _line(side: Side, other: Side, topics: list[str], why: str) -> list[str]:
    return _sentence(side, [(TOPICS[topic][0], TOPICS[topic][1](other.robot)) for topic in topics], why)


def _sentence(side: Side, counts: Iterable[tuple[str, int]], why: str) -> list[str]:
    said = ", ".join(f"{count} {_counted(name, count)}" for name, count in counts if count)
    return [f"{said}: {side.label} is {side.format.named}, {why}"] if said else []


def _counted(name: str, count: int) -> str:
    """Return a name of one thing for so many of them.

    >>> _counted("mass", 2), _counted("name of fixed joints", 2), _counted("mimic", 1)
    ('masses', 'names of fixed joints', 'mimic')
    """
    word, of, rest = name.partition(" of ")
    return f"{plural(word, count)}{of}{rest}"


def not_carried(pairing: Pairing, a: Side, b: Side) -> tuple[frozenset[str], list[str]]:
    """Return the links of one robot that the other one's file leaves out by its nature, and the sentences on it."""
    names: set[str] = set()
    lines: list[str] = []
    pairs = ((pairing.a.robot, pairing.b.robot, a, b), (pairing.b.robot, pairing.a.robot, b, a))
    for robot, other, side, its in pairs:
        absent = [link.name for link in robot.walk() if link.name not in other.link]
        left = [name for name in absent if _left_out(robot, name, side, its)]
        if not left:
            continue
        names.update(left)
        output = _output_without(robot, side, its)
        if output:
            lines.append(f"{several(left)} of {side.label}: its output {output} has no such links")
            continue
        why = (its if side.format is YAML or its.format is not YAML else side).format.writing.why
        lines.append(f"{several(left)} of {side.label}: {why}")
    return frozenset(names), lines


def _output_without(robot: Robot, side: Side, other: Side) -> str:
    """Return the output of a description that has the very links of the other file, and not all; empty if none."""
    links = other.format.writing.links
    if side.format is not YAML or links is None or len(other.robot.links) == len(robot.links):
        return ""
    outputs = [one for one in robot.outputs if one.backend == other.format.name and other.format.is_withheld(one)]
    return next((one.name for one in outputs if set(links(robot, one)) == set(other.robot.link)), "")


def _left_out(robot: Robot, link: str, side: Side, other: Side) -> bool:
    """Say whether it is no surprise that the other file lacks a link of this robot."""
    if other.format is YAML:
        return side.format.writing.adds is not None and side.format.writing.adds(robot, link, other.robot)
    if _output_without(robot, side, other):
        return True
    return other.format.writing.leaves_out is not None and other.format.writing.leaves_out(robot, link)

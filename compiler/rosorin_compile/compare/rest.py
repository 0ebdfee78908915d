"""Compare two robots beside frames, masses and shapes: values of joints, and every section, leaf by leaf."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from functools import cache, reduce
from typing import Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.schema import sections
from rosorin_compile.model import HeightMap, Joint, Link, Robot
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.model.robot import JointPose

from .change import Describer
from .difference import JOINT, LIMIT, OTHER, YAML, Item, Side
from .elements import Context, Key, context_of, meanings, spelt
from .joints import Coordinates
from .pairing import Pairing
from .sentences import Sentence, text_of
from .walk import Difference, Leaves, compare_leaves, leaves

_MOST = 50
_PURPOSES = ("collision", "visual")
# What is zero where it is not given.
_ZERO = ("damping", "friction", "armature", "stiffness", "spring reference", "kv")
# Parts of a joint that a format may have no word for.
_OF_DESCRIPTIONS = ("", None, "planning", "mode")  # topics that are compared between robots of one format alone
_PARTS = ("mimic", "dynamics", "actuator", "calibration", "safety")


def compare_rest(
    pairing: Pairing, sides: tuple[Side, Side], coordinates: Coordinates, unsaid: frozenset[str]
) -> Iterator[Item]:
    """Yield what differs; ``unsaid`` are the topics that are not compared."""
    robots = pairing.a.robot, pairing.b.robot
    alike = sides[0].format is sides[1].format
    old, new = (_leaves(robot, unsaid, alike, all(side.format is YAML for side in sides)) for robot in robots)
    _only_shared(old, new, robots, coordinates)
    _without_equals(old, new)
    precisions = pairing.a.printing.tolerance, pairing.b.printing.tolerance
    differences = compare_leaves(old, new, precisions, pairing.tolerance)
    describer = Describer(pairing.a.robot, (old, new), precisions, pairing.tolerance)
    told = set()
    for one, sentence in describer.describe(_once(differences, robots)):
        if str(sentence) not in told:
            told.add(str(sentence))
            yield _item(one, sentence)
    if "urdf_elements" not in unsaid:
        yield from _elements(pairing)


def count_simulated(robot: Robot) -> int:
    """Return how many things a robot has for a simulation alone."""
    found = sum(len(getattr(robot, name)) for name in _of_topic("simulation"))
    found += sum(len(link.marked) + len(link.mjcf_elements) + bool(link.mjcf) for link in robot.links)
    return found + sum(bool(joint.mjcf) for joint in robot.joints)


@cache
def _of_topic(topic: str) -> tuple[str, ...]:
    return tuple(name for name, node in sections().items() if node.topic == topic)


def _leaves(robot: Robot, unsaid: frozenset[str], alike: bool, described: bool) -> Leaves:
    """Return the leaves of a robot beside frames, masses and shapes, without topics that are not compared.

    ``alike``: both robots are of one format; ``described``: both are descriptions.
    """
    empty = Robot("", (), ())
    known = {field.name for field in fields(Robot)} & sections().keys() - {"robot", "links", "joints", "source"}
    topics = {name: sections()[name].topic for name in known}
    gone = [name for name, topic in topics.items() if topic in unsaid or (not alike and topic in _OF_DESCRIPTIONS)]
    reduced = {name: getattr(empty, name) for name in (*gone, "servos", "urdf_elements")}
    simulated = "simulation" not in unsaid
    links = tuple(_link(link, simulated) for link in robot.links)
    joints = tuple(_joint(joint, unsaid, simulated) for joint in robot.joints)
    said = robot.sections if alike else empty.sections
    made = replace(robot, name="", links=links, joints=joints, sections=said, source=empty.source, **reduced)
    if not alike:  # every MJCF has the key home
        made = replace(made, poses=tuple(pose for pose in made.poses if pose != JointPose("home", {})))
    if not simulated:
        poses = tuple(replace(pose, base=None, controls={}, mjcf={}) for pose in made.poses)
        made = replace(made, poses=poses, materials=tuple(replace(one, mjcf={}) for one in made.materials))
    if made.drive is not None and not made.drive.frame:
        made = replace(made, drive=replace(made.drive, frame=robot.root))
    if made.sensors and not alike:
        made = replace(made, sensors=tuple(replace(s, simulated=(), stamps=(), gazebo=()) for s in made.sensors))
    found = leaves(made)
    drive = found.get(("drive", "drive"), {})
    for quantity in [*drive]:
        drive[quantity.removeprefix("joints ")] = drive.pop(quantity)
    if alike:
        _looks(robot, found, simulated)
    if "servo" not in unsaid:
        _servos(robot, found, described)
    if simulated and robot.root_in_world is not None:
        found["root in simulation", "root in simulation"] = _words(robot.root_in_world)
    if "publisher" in unsaid:
        for (kind, _), entry in found.items():
            if kind == "frame":
                entry.pop("publisher", None)
    return found


def _words(value: Any) -> dict[str, Any]:
    return {field.name.replace("_", " "): getattr(value, field.name) for field in fields(value)}


def _link(link: Link, simulated: bool) -> Link:
    if simulated:
        return replace(link, inertial=None, visual=(), collision=(), urdf_elements=())
    return Link(link.name)


def _joint(joint: Joint, unsaid: frozenset[str], simulated: bool) -> Joint:
    """Return a joint with what is compared of it."""
    gone: dict[str, Any] = {part: None for part in _PARTS if part in unsaid}
    limit, dynamics, actuator = joint.limit, joint.dynamics, joint.actuator
    if limit is not None:
        limit = replace(limit, **{word: None for word in ("effort", "velocity") if word in unsaid})  # type: ignore[arg-type]
    if not simulated and "actuator" not in unsaid:  # an MJCF has one damping of joint and drive
        dynamics = replace(dynamics or Dynamics(), damping=joint.braking)
        actuator = actuator and type(actuator)(kp=actuator.kp, kv=actuator.kv)
    if dynamics is not None and "armature" in unsaid:
        dynamics = replace(dynamics, armature=0.0)
    if dynamics is not None and "stiffness" in unsaid:
        dynamics = replace(dynamics, stiffness=0.0, spring_reference=0.0)
    mjcf = joint.mjcf if simulated else {}
    made = replace(joint, limit=limit, dynamics=dynamics, actuator=actuator, urdf_elements=(), mjcf=mjcf)
    return replace(made, **gone)


def _looks(robot: Robot, found: Leaves, simulated: bool) -> None:
    """Add what is said of shapes beside their numbers and colours."""
    for link in robot.links:
        for purpose in _PURPOSES:
            for number, shape in enumerate(getattr(link, purpose), 1):
                entry = {"name": shape.name, "material": shape.material, "texture": robot.texture(shape)}
                if isinstance(shape.geometry, HeightMap):
                    entry["method"] = shape.geometry.method
                entry = {word: value for word, value in entry.items() if value}
                if simulated:
                    entry |= shape.mjcf
                    if shape.contact is not None:
                        entry |= {"layers": shape.contact.layers, "touches": shape.contact.touches}
                        entry |= shape.contact.values
                found[f"{purpose} shape {number} of", link.name] = entry


def _servos(robot: Robot, found: Leaves, described: bool) -> None:
    """Add the servos by the joint that they move; groups, their names and ranges between two descriptions alone."""
    for group in robot.servos:
        sign = -1.0 if group.flipped else 1.0
        entry: dict[str, Any] = {"rad per pulse": sign * group.rad_per_pulse, "zero pulse": float(group.zero_pulse)}
        if described:
            lowest, highest = map(float, group.pulse_range)
            entry |= {"group": group.name, "lowest pulse": lowest, "highest pulse": highest}
        for joint in group.joints:
            found["servo of", joint] = dict(entry)


def _only_shared(old: Leaves, new: Leaves, robots: tuple[Robot, Robot], coordinates: Coordinates) -> None:
    """Take out what is compared elsewhere, and of links and joints what only one robot has."""
    placed = {*robots[0].joint_to, *robots[1].joint_to}
    counts = [sum(" shape " in kind for kind, _ in side) for side in (old, new)]
    for thing in {**old, **new}:
        kind, name = thing
        first, second = old.get(thing), new.get(thing)
        own = kind in ("joint", "link") or (kind == "frame" and name in placed) or " shape " in kind
        if own and (first is None or second is None or (" shape " in kind and counts[0] != counts[1])):
            old.pop(thing, None)
            new.pop(thing, None)
        elif first is not None and second is not None:
            _reduce(thing, (first, second), robots, coordinates)


def _reduce(
    thing: tuple[str, str],
    entries: tuple[dict[str, Any], dict[str, Any]],
    robots: tuple[Robot, Robot],
    coordinates: Coordinates,
) -> None:
    """Take out of the entries of a thing what is compared elsewhere, and what is no difference."""
    kind, name = thing
    keys = {*entries[0], *entries[1]}
    gone: set[str] = set()
    if kind == "frame" and name in robots[0].joint_to:
        gone = {"parent", "origin"}
        publishers = [entry.get("publisher") for entry in entries]
        if name in robots[1].joint_to and publishers[0] is not None and publishers[0] == publishers[1]:
            for entry, robot in zip(entries, robots, strict=True):
                entry["kind of publisher"] = robot.joint_to[name].publisher.kind
    elif kind == "joint":
        types = [entry.get("type") for entry in entries]
        free = "continuous" in types or (name in coordinates and coordinates[name].same_limits)
        gone = {"child", "axis"} | ({"limit lower", "limit upper"} if free else set())
        gone |= keys - {"type"} if "fixed" in types else set()
        for entry in entries:
            entry.update({word: entry.get(word, 0.0) for word in keys.intersection(_ZERO)})
    elif kind == "sensor":
        gone = {"joint"}
    elif kind == "drive" and entries[0].get("kind") != entries[1].get("kind"):
        gone = keys - {"kind"}
    elif kind == "pose":  # a joint that no pose names is at zero, a follower where its leader puts it
        both = robots[0].joint.keys() & robots[1].joint.keys()
        own = robots[0].joint.keys() | robots[1].joint.keys()
        gone = keys & (own - both) | {word for word in keys & both if any(robot.joint[word].mimic for robot in robots)}
        for entry in entries:
            entry.update({joint: entry.get(joint, 0.0) for joint in keys & both})
    for entry in entries:
        for word in gone:
            entry.pop(word, None)


def _without_equals(old: Leaves, new: Leaves) -> None:
    """Take out the entries of lists without names that both robots have, and number the others anew."""
    unnamed = [[thing for thing in side if thing[1].isdecimal()] for side in (old, new)]
    for kind in {kind for things in unnamed for kind, _ in things}:
        sides = [
            [side.pop(thing) for thing in things if thing[0] == kind]
            for side, things in zip((old, new), unnamed, strict=True)
        ]
        for entry in [*sides[0]]:
            if entry in sides[1]:
                sides[0].remove(entry)
                sides[1].remove(entry)
        for side, left in zip((old, new), sides, strict=True):
            side |= {(kind, str(number)): entry for number, entry in enumerate(left, 1)}


def _once(differences: Sequence[Difference], robots: tuple[Robot, Robot]) -> list[Difference]:
    """Return differences without those of servos that were told of another joint of the same groups."""
    groups = [{joint: group.name for group in robot.servos for joint in group.joints} for robot in robots]
    seen: dict[tuple[Any, ...], str] = {}
    found = []
    for one in differences:
        kind, name, quantity = one.address
        key = (quantity, *(group.get(name) for group in groups))
        if kind != "servo of" or not quantity or seen.setdefault(key, name) == name:
            found.append(one)
    return found


def _item(one: Difference, sentence: Sentence) -> Item:
    kind, name, quantity = one.address
    text = str(sentence)
    if quantity == "mimic joint":
        return Item(JOINT, name, "mimic", text, sentence.row.before, sentence.row.after)
    what = (LIMIT if quantity.startswith("limit ") else JOINT) if kind == "joint" else OTHER
    if not quantity and not isinstance(one.old or one.new, frozenset):
        return Item(what, name, kind, text, None if one.old is None else name, None if one.new is None else name)
    called = f"{kind} {quantity}".strip() if kind == "pose" else quantity or kind
    return Item(what, name, called, text, _scalar(one.old), _scalar(one.new))


def _scalar(value: Any) -> float | str | None:
    if value is None:
        return None
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if is_number else value if isinstance(value, str) else text_of(value)


def _elements(pairing: Pairing) -> Iterator[Item]:
    """Yield the elements for URDF that are new or gone, by what they mean."""
    a, b = pairing.a.robot, pairing.b.robot
    context = context_of(a, a.asks_for_humble or b.asks_for_humble)
    places = [("the robot", a.urdf_elements, b.urdf_elements)]
    places += [(n, a.link[n].urdf_elements, b.link[n].urdf_elements) for n in a.link if n in b.link]
    places += [(n, a.joint[n].urdf_elements, b.joint[n].urdf_elements) for n in a.joint if n in b.joint]
    for name, mine, theirs in places:
        whole = name == "the robot"
        if mine == theirs and not whole:
            continue
        old, new = meanings(mine, context), meanings(theirs, context)
        lost, found = old - new, new - old
        if whole:
            lost, found = lost - _brought(b, context), found - _brought(a, context)
            lost, found = lost | (_always(a, b, context) - new), found | (_always(b, a, context) - old)
        gone, fresh = sorted(map(spelt, lost.elements())), sorted(map(spelt, found.elements()))
        parts = [
            f"{len(texts)} {word} ({_short(texts[0])})" for texts, word in ((fresh, "new"), (gone, "removed")) if texts
        ]
        if parts:
            text = f"URDF elements of {name}: {', '.join(parts)}"
            yield Item(OTHER, name, "urdf_elements", text, "; ".join(gone) or None, "; ".join(fresh) or None)


def _brought(robot: Robot, context: Context) -> Counter[Key]:
    """Return the elements that outputs of a robot make of what its description says in words."""
    return meanings([text for texts in _by_output(robot) for text in texts], context)


def _always(robot: Robot, other: Robot, context: Context) -> Counter[Key]:
    """Return the elements that every output of a description brings, where the other robot is a file and has none."""
    made = [] if other.outputs else [meanings(texts, context) for texts in _by_output(robot)]
    return reduce(lambda one, two: one & two, made) if made else Counter()


def _by_output(robot: Robot) -> list[Sequence[str]]:
    known = [(FORMATS[output.backend], output) for output in robot.outputs if output.backend in FORMATS]
    return [one.brings(robot, output) for one, output in known if one.brings]


def _short(text: str) -> str:
    return f"{text[:_MOST]}..." if len(text) > _MOST else text

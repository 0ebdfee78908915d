"""Compare what two robots have besides frames, masses and shapes, leaf by leaf: values of joints, and every section.

What one of two formats has no word for is a topic that is not compared; how much of it there is, is a line.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import cache, reduce
from typing import Any, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Joint, Robot
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.source.wording import plural

from .describe import Describer
from .difference import JOINT, LIMIT, OTHER, SHAPE, YAML, Item, Side
from .elements import Context, Key, context_of, meanings, spelt
from .frames import Coordinate
from .pairing import Pairing
from .sentences import is_number, size_of, text_of
from .walk import Difference, Leaves, Shapes, compare_leaves, leaves, section_words

# The topics that a format may lack, and what one of each is called.
_WORDS = {
    "mass": "mass",
    "collision": "collision shape",
    "visual": "visual shape",
    "effort": "effort limit",
    "velocity": "velocity limit",
    "mimic": "mimic",
    "dynamics": "damping or friction",
    "armature": "armature",
    "stiffness": "spring",
    "simulation": "thing of a simulation",
    "actuator": "actuator",
    "calibration": "calibration",
    "safety": "safety controller",
    "pose": "named pose",
    "servo": "servo group",
    "sensor": "sensor",
    "drive": "drive",
    "contact": "disabled contact",
    "publisher": "publisher",
    "edge": "transform of other nodes",
    "fixed joint name": "name of fixed joints",
    "urdf_elements": "element for URDF alone",
}
# The topic of a quantity by its first words.
_OF_JOINTS = {
    "limit effort": "effort",
    "limit velocity": "velocity",
    "mimic": "mimic",
    "damping": "dynamics",
    "friction": "dynamics",
    "armature": "armature",
    "stiffness": "stiffness",
    "spring": "stiffness",
    "actuator": "actuator",
    "kp": "actuator",
    "kv": "actuator",
    "calibration": "calibration",
    "safety": "safety",
    "element": "urdf_elements",
}
_OF_LINKS = {
    **dict.fromkeys(("mass", "centre of mass", "inertia"), "mass"),
    "collision": "collision",
    "visual": "visual",
    "element": "urdf_elements",
}
# What a writer leaves out as a whole, by an option or by its nature, rather than here and there.
_WHOLE = ("mass", "collision", "visual", "effort", "velocity", "dynamics", "armature", "actuator", "pose", "servo")
_OF_DESCRIPTIONS = ("", "planning", "mode")  # topics that are compared between robots of one format alone
_ALWAYS = "always"  # the topic of what every format has
# What is zero where it is not given.
_ZERO = ("damping", "friction", "armature", "stiffness", "spring reference", "kv")
_MOST = 50


class Sections(NamedTuple):
    """What differs, the topics that are not compared, and the lines that say so."""

    items: list[Item]
    topics: frozenset[str]
    not_compared: list[str]


def compare_sections(pairing: Pairing, sides: tuple[Side, Side], coordinates: Mapping[str, Coordinate]) -> Sections:
    """Compare two robots in everything but frames, masses and shapes."""
    robots = pairing.a.robot, pairing.b.robot
    lacking = sides[0].format.lacks | sides[1].format.lacks
    old, new = (_leaves(robot, lacking, sides) for robot in robots)
    topics, lines = _not_compared(sides, (old, new))
    for side, robot in zip((old, new), robots, strict=True):
        _without_topics(side, topics, robot)
    _only_shared(old, new, robots, coordinates)
    _without_equals(old, new)
    precisions = pairing.a.precision, pairing.b.precision
    differences = compare_leaves(old, new, precisions, pairing.tolerance)
    describer = Describer(robots[0], (old, new), precisions, pairing.tolerance)
    found = {text: _item(one, text) for one, text in reversed(list(describer.describe(_once(differences, robots))))}
    items = [*found.values()][::-1]
    if "urdf_elements" not in topics:
        items += _elements(pairing)
    return Sections(items, topics, lines)


def _leaves(robot: Robot, lacking: frozenset[str], sides: tuple[Side, Side]) -> Leaves:
    """Return the leaves of a robot, with what two formats say in different ways in one way."""
    if "simulation" in lacking and "actuator" not in lacking:  # an MJCF has one damping of joint and drive
        robot = replace(robot, joints=tuple(map(_with_braking, robot.joints)))
    if sides[0].format is not sides[1].format:
        sensors = (replace(one, simulated=(), stamps=(), gazebo=()) for one in robot.sensors)
        robot = replace(robot, sensors=tuple(sensors))
    if robot.drive is not None and not robot.drive.frame:
        robot = replace(robot, drive=replace(robot.drive, frame=robot.root))
    found = leaves(replace(robot, name="", source=Robot("", (), ()).source))
    drive = found.get(("drive", "drive"), {})
    for quantity in [*drive]:
        drive[quantity.removeprefix("joints ")] = drive.pop(quantity)
    if robot.root_in_world is not None:
        root = robot.root_in_world
        words = {field.name.replace("_", " "): getattr(root, field.name) for field in fields(root)}
        found["root in simulation", "root in simulation"] = words
    for group in robot.servos:
        found.pop(("servo", group.name))
        entry: dict[str, Any] = {"rad per pulse": group.rad_per_pulse * (-1.0 if group.flipped else 1.0)}
        entry["zero pulse"] = float(group.zero_pulse)
        if sides[0].format is YAML is sides[1].format:
            lowest, highest = map(float, group.pulse_range)
            entry |= {"group": group.name, "lowest pulse": lowest, "highest pulse": highest}
        found |= {("servo of", joint): dict(entry) for joint in group.joints}
    return found


def _with_braking(joint: Joint) -> Joint:
    actuator = joint.actuator and type(joint.actuator)(kp=joint.actuator.kp, kv=joint.actuator.kv)
    dynamics = replace(joint.dynamics or Dynamics(), damping=joint.braking)
    return replace(joint, dynamics=dynamics, actuator=actuator)


def _topic(kind: str, quantity: str, is_placed: bool) -> str:
    """Return the topic of a leaf; of a section of a package, its word."""
    if kind == "joint":
        found = next((topic for words, topic in _OF_JOINTS.items() if quantity.startswith(words)), "")
        own = ("", "type", "child", "axis", "limit lower", "limit upper")
        return found or (_ALWAYS if quantity in own else "simulation")
    if kind == "link":
        found = next((topic for words, topic in _OF_LINKS.items() if quantity.startswith(words)), "")
        return found or (_ALWAYS if not quantity else "simulation")
    if kind == "frame":
        return "edge" if not is_placed else "publisher" if quantity in ("publisher", "topic") else _ALWAYS
    if kind == "material":
        return "" if quantity in ("rgba", "texture") else "simulation"
    if kind == "robot":
        return {"modes": "mode"}.get(quantity) or ("simulation" if quantity.startswith("mjcf") else "urdf_elements")
    own = {"height map": "collision", "pose": "pose", "servo of": "servo", "contacts": "contact"}
    return own.get(kind) or _section_topics().get(kind, "simulation")


@cache
def _section_topics() -> Mapping[str, str]:
    """Return the topics of sections by the word for an entry; one of a package is a topic of its own."""
    words = {word: sections()[name].topic or "" for name, word in section_words().items() if name in sections()}
    return words | {word: word for word in _words_of_packages()}


@cache
def _words_of_packages() -> frozenset[str]:
    known = {field.name for field in fields(Robot)}
    return frozenset(word for name, word in section_words().items() if name not in known)


def _not_compared(sides: tuple[Side, Side], both: tuple[Leaves, Leaves]) -> tuple[frozenset[str], list[str]]:
    """Return the topics that are not compared between two robots of these formats, and the sentences that say so."""
    counts = [_counts(found, side.robot) for found, side in zip(both, sides, strict=True)]
    alike = sides[0].format is sides[1].format
    topics: set[str] = set() if alike else set(_OF_DESCRIPTIONS)
    lines: list[str] = []
    for at, (side, other) in enumerate((sides, sides[::-1])):
        lacks = [topic for topic in _WORDS if topic in side.format.lacks - other.format.lacks]
        if side.format is not YAML:
            lacks += [topic for topic in counts[1 - at] if topic in _words_of_packages()]
        empty = [t for t in _WHOLE if not alike and t not in side.format.lacks and not counts[at][t]]
        for missing, why in ((lacks, "a format without a word for it"), (empty, "which leaves out all of it")):
            said = [f"{count} {_counted(topic, count)}" for topic in missing if (count := counts[1 - at][topic])]
            lines += [f"{', '.join(said)}: {side.label} is {side.format.named}, {why}"] if said else []
        topics |= {*lacks, *empty, *side.format.lacks}
    if not alike and "contact" not in topics:
        # What a simulation excludes beside what was asked for are the contacts of neighbours.
        topics.add("contact")
        some = [one["contact"] for one in counts]
        if any(some):
            lines.append(f"{some[0]} and {some[1]} disabled contacts: a simulation adds those of neighbours")
    return frozenset(topics), lines


def _counts(found: Leaves, robot: Robot) -> Counter[str]:
    """Return how many things of each topic a robot has."""
    things: dict[str, set[Any]] = {}
    for (kind, name), entry in found.items():
        for quantity, value in (entry or {"": None}).items():
            key: Any = (kind, name)
            topic = _topic(kind, quantity, name in robot.joint_to)
            own = things.setdefault(topic, set())
            if kind == "root in simulation":  # every robot has it
                continue
            if topic == "publisher":
                own |= {value} if quantity == "publisher" else set()
            elif isinstance(value, Shapes):
                own |= {(*key, at) for at in range(len(value.shapes))}
            else:
                own |= value if isinstance(value, frozenset) else {key}
    counts = Counter({topic: len(some) for topic, some in things.items()})
    for topic, has in _OF_ROBOTS.items():
        counts[topic] = has(robot)
    return counts


_OF_ROBOTS: Mapping[str, Callable[[Robot], int]] = {
    "servo": lambda robot: len(robot.servos),
    "fixed joint name": lambda robot: sum(joint.is_fixed for joint in robot.joints),
    "urdf_elements": lambda robot: sum(len(one.urdf_elements) for one in (robot, *robot.links, *robot.joints)),
}


def _counted(topic: str, count: int) -> str:
    """Return what so many things of a topic are called: "names of fixed joints"."""
    word, of, rest = _WORDS.get(topic, topic).partition(" of ")
    return f"{plural(word, count)}{of}{rest}"


def _without_topics(found: Leaves, topics: frozenset[str], robot: Robot) -> None:
    """Take out what is not compared, and what is compared elsewhere: masses, shapes and elements for URDF."""
    for thing in [*found]:
        kind, name = thing
        entry = found[thing]
        gone = {quantity: _topic(kind, quantity, name in robot.joint_to) for quantity in entry or {"": None}}
        for quantity, topic in gone.items():
            if topic in topics or (topic in _OF_LINKS.values() and kind != "height map"):
                entry.pop(quantity, None)
        if not entry and (kind not in ("link", "joint", "frame") or all(topic in topics for topic in gone.values())):
            del found[thing]


def _only_shared(old: Leaves, new: Leaves, robots: tuple[Robot, Robot], coordinates: Mapping[str, Coordinate]) -> None:
    """Take out what is compared elsewhere, and of links and joints what only one robot has."""
    placed = {*robots[0].joint_to, *robots[1].joint_to}
    for thing in {**old, **new}:
        kind, name = thing
        first, second = old.get(thing), new.get(thing)
        own = kind in ("joint", "link", "height map") or (kind == "frame" and name in placed)
        if own and (first is None or second is None):
            old.pop(thing, None)
            new.pop(thing, None)
        elif first is not None and second is not None:
            _reduce(thing, (first, second), robots, coordinates)


def _reduce(
    thing: tuple[str, str],
    entries: tuple[dict[str, Any], dict[str, Any]],
    robots: tuple[Robot, Robot],
    coordinates: Mapping[str, Coordinate],
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
    """Take out the entries of lists without names that both robots have, and number the others again."""
    unnamed = [[thing for thing in side if thing[1].isdecimal()] for side in (old, new)]
    for kind in {kind for things in unnamed for kind, _ in things}:
        first, second = (
            [side.pop(thing) for thing in things if thing[0] == kind]
            for side, things in zip((old, new), unnamed, strict=True)
        )
        for entry in [*first]:
            if entry in second:
                first.remove(entry)
                second.remove(entry)
        for side, left in ((old, first), (new, second)):
            side |= {(kind, str(number)): entry for number, entry in enumerate(left, 1)}


def _once(differences: Sequence[Difference], robots: tuple[Robot, Robot]) -> list[Difference]:
    """Return differences without those of servos that another joint of the same groups has, too."""
    groups = [{joint: group.name for group in robot.servos for joint in group.joints} for robot in robots]
    first: dict[tuple[Any, ...], str] = {}
    found = []
    for one in differences:
        kind, name, quantity = one.address
        key = (quantity, *(group.get(name) for group in groups))
        if kind != "servo of" or not quantity or first.setdefault(key, name) == name:
            found.append(one)
    return found


def _item(one: Difference, text: str) -> Item:
    kind, name, quantity = one.address
    if quantity == "mimic joint":
        before, _, after = text.partition(" mimics ")[2].partition(" -> ")
        return Item(JOINT, name, "mimic", text, before, after)
    what = (LIMIT if quantity.startswith("limit ") else JOINT) if kind == "joint" else OTHER
    if kind == "height map":
        what, quantity = SHAPE, kind if quantity == "heights" else f"{kind} {quantity}"
    elif not quantity and not isinstance(one.old or one.new, frozenset):
        return Item(what, name, kind, text, None if one.old is None else name, None if one.new is None else name)
    called = f"{kind} {quantity}".strip() if kind == "pose" else quantity or kind
    return Item(what, name, called, text, _scalar(one.old), _scalar(one.new))


def _scalar(value: Any) -> float | str | None:
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):
        return size_of(value)
    return float(value) if is_number(value) else text_of(value)


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
    """Return the elements that outputs of a robot make of the words of its description."""
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

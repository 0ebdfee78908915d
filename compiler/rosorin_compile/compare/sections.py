"""Compare the values of two robots except frames, masses and shapes, as far as both formats can express them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import cache
from typing import Any

from rosorin_compile.formats import FORMATS, Format
from rosorin_compile.formats.format import lacks
from rosorin_compile.formats.gazebo import Key, followers_of, meanings, spelt
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Robot
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.source.wording import phrase

from .bodies import BodyPairs
from .describe import Describer
from .difference import JOINT, LIMIT, OTHER, SHAPE, YAML, Item, Report, Side
from .sentences import is_number, size_of, text_of
from .walk import Difference, Leaves, Thing, compare_leaves, leaves, section_words

ONE_BOX = "several shapes"  # a topic that a format with only one box per link does not support
# Topics that a format may not support: (YAML key, name in messages, regex for "KIND QUANTITY" of a value).
_TOPICS: Mapping[str, tuple[str, str, str]] = {
    "mass": ("links.inertial", "masses", "link (mass|centre of mass|inertia)"),
    "collision": ("links.collision.box.size", "collision shapes", "link collision|height map (heights|cell|origin)?$"),
    "visual": ("links.visual", "visual shapes", "link visual"),
    "effort": ("joints.limit.effort", "effort limits", "joint limit effort"),
    "velocity": ("joints.limit.velocity", "velocity limits", "joint limit velocity"),
    "mimic": ("joints.mimic", "mimic joints", "joint mimic"),
    "dynamics": ("joints.dynamics.damping", "damping or friction", "joint (damping|friction)"),
    "armature": ("joints.dynamics.armature", "armature", "joint armature"),
    "stiffness": ("joints.dynamics.stiffness", "springs", "joint (stiffness|spring)"),
    "simulation": ("root", "values for simulation", "robot (?!element)|material "),
    "actuator": ("joints.actuator", "actuators", "joint (actuator|kp|kv)"),
    "calibration": ("joints.calibration", "calibrations", "joint calibration"),
    "safety": ("joints.safety_controller", "safety controllers", "joint safety"),
    "pose": ("poses.positions", "named poses", "pose "),
    "servo": ("servos.rad_per_pulse", "servo groups", "servo of "),
    "sensor": ("sensors.type", "sensors", "sensor "),
    "drive": ("drive", "drive", "drive "),
    "contact": ("disabled_contacts", "disabled contacts", "contacts "),
    "publisher": ("joints.publisher", "publishers", "frame (publisher|topic)"),
    "edge": ("edges", "transforms of other nodes", "$"),
    "fixed joint name": ("sensors.joint", "names of fixed joints", "$"),
    "urdf_elements": ("urdf_elements", "elements for URDF alone", "(joint|link|robot) element"),
}
# _ALWAYS matches values in every format, _SAME_FORMAT maps values that are only compared within a format to topics.
_ALWAYS = re.compile(r"joint (type|child|axis|limit (lower|upper))?|frame (parent|origin)?|link |robot ")
_SAME_FORMAT = {"robot modes": "mode", "material rgba": "", "material texture": ""}
# Topics that are not compared if a file has none of their values: a writer may have omitted them.
_WHOLE = ("mass", "collision", "visual", "effort", "velocity", "dynamics", "armature", "actuator", "pose", "servo")
_OF_DESCRIPTIONS = ("", "planning", "mode")  # topics that are only compared between robots in the same format
_ELSEWHERE = ("mass", "collision", "visual", "urdf_elements")  # topics that are compared by other functions
# Quantities of joints that default to zero.
_ZERO = ("damping", "friction", "armature", "stiffness", "spring reference", "kv")


def compare_sections(
    pairing: BodyPairs, sides: tuple[Side, Side], flipped: Mapping[str, bool], report: Report
) -> frozenset[str]:
    """Report differences other than frames, masses and shapes; return the topics that are not compared."""
    robots = pairing.a.robot, pairing.b.robot
    lacking = _lacking(sides[0].format) | _lacking(sides[1].format)
    # Unlike the robots in ``pairing``, the sides still have their original names: rename their links and joints.
    old, new = (_leaves(side.robot, lacking, sides) for side in sides)
    old = pairing.rename_leaves(0, old, new)
    new = pairing.rename_leaves(1, new, old)
    topics = _not_compared(sides, robots, (old, new), report)
    for side, robot in zip((old, new), robots, strict=True):
        _without_topics(side, topics, robot)
    placed = {*robots[0].joint_to, *robots[1].joint_to}
    for thing in {**old, **new}:
        kind, name = thing
        first, second = old.get(thing), new.get(thing)
        if first is not None and second is not None:
            _reduce(thing, (first, second), robots, flipped)
        elif kind in ("joint", "link", "height map") or (kind == "frame" and name in placed):
            old.pop(thing, None)  # new and removed links are reported by ``compare_names``
            new.pop(thing, None)
    _without_equals(old, new)
    if "urdf_elements" not in topics:
        _add_elements(old, new, robots)
    precisions = pairing.a.precision, pairing.b.precision
    differences = compare_leaves(old, new, precisions, pairing.tolerance)
    describer = Describer(robots[0], (old, new), precisions, pairing.tolerance)
    found = {text: _item(one, text) for one, text in reversed(list(describer.describe(differences)))}
    report.items.extend([*found.values()][::-1])
    return topics


def _leaves(robot: Robot, lacking: frozenset[str], sides: tuple[Side, Side]) -> Leaves:
    """Return the values of a robot, normalized so that robots in different formats can be compared."""
    if "simulation" in lacking and "actuator" not in lacking:  # MJCF has one damping value for joint and actuator
        joints = []
        for joint in robot.joints:
            actuator = joint.actuator and type(joint.actuator)(kp=joint.actuator.kp, kv=joint.actuator.kv)
            dynamics = replace(joint.dynamics or Dynamics(), damping=joint.total_damping)
            joints.append(replace(joint, dynamics=dynamics, actuator=actuator))
        robot = replace(robot, joints=tuple(joints))
    if sides[0].format is not sides[1].format:
        sensors = (replace(one, simulated=(), stamps=(), gazebo=()) for one in robot.sensors)
        robot = replace(robot, sensors=tuple(sensors))
    if robot.drive is not None and not robot.drive.frame:
        robot = replace(robot, drive=replace(robot.drive, frame=robot.root))
    found = leaves(replace(robot, name="", source=Robot("", (), ()).source))
    if robot.drive is not None:
        drive = found["drive", "drive"]
        found["drive", "drive"] = {quantity.removeprefix("joints "): value for quantity, value in drive.items()}
    root = robot.root_in_world
    words = {field.name.replace("_", " "): getattr(root, field.name) for field in fields(root)}
    found["root in simulation", "root in simulation"] = words
    for group in robot.servos:
        found.pop(("servo", group.name))
        step, zero = group.rad_per_pulse * (-1.0 if group.flipped else 1.0), float(group.zero_pulse)
        entry: dict[str, Any] = {"rad per pulse": step, "zero pulse": zero}
        if sides[0].format is YAML is sides[1].format:
            lowest, highest = map(float, group.pulse_range)
            entry |= {"group": group.name, "lowest pulse": lowest, "highest pulse": highest}
            entry["joints"] = group.joints[1:]
        found["servo of", group.joints[0] if group.joints else group.name] = entry
    return found


def _topic(thing: Thing, quantity: str, robot: Robot) -> str | None:
    (kind, name), leaf = thing, f"{thing[0]} {quantity}"
    if kind == "frame" and name not in robot.joint_to:
        return "edge"
    if leaf in _SAME_FORMAT or _ALWAYS.fullmatch(leaf):
        return _SAME_FORMAT.get(leaf)
    if kind == "pose" and quantity and quantity not in robot.joint:
        return "simulation"
    if kind in _words_of_packages():
        return kind
    found = [topic for topic, (_, _, pattern) in _TOPICS.items() if re.match(pattern, leaf)]
    found += [sections()[name].topic or "" for name, word in section_words().items() if word == kind]
    return [*found, ONE_BOX if kind == "height map" else "simulation"][0]


def has_one_box(format: Format) -> bool:
    """Return True if a format supports only one box per link."""
    return format is not YAML and lacks(format, "links.collision.sphere")


@cache
def _words_of_packages() -> frozenset[str]:
    known = {field.name for field in fields(Robot)}
    return frozenset(word for name, word in section_words().items() if name not in known)


@cache
def _lacking(format: Format) -> frozenset[str]:
    keys = {} if format is YAML else _TOPICS
    found = {topic for topic, (key, *_) in keys.items() if lacks(format, key)}
    return frozenset(found | ({ONE_BOX} if has_one_box(format) else set()))


def _not_compared(
    sides: tuple[Side, Side], robots: Sequence[Robot], both: Sequence[Leaves], report: Report
) -> frozenset[str]:
    """Return the topics that are not compared between these formats, and report those that a robot has."""
    has: list[set[str]] = []
    for found, robot in zip(both, robots, strict=True):
        things = ((thing, quantity) for thing, entry in found.items() for quantity in entry or ("",))
        has.append({_topic(*leaf, robot) or "" for leaf in things if leaf[0][0] != "root in simulation"})
        has[-1] |= {"fixed joint name" for joint in robot.joints if joint.is_fixed}
        if robot.urdf_elements or any(one.urdf_elements for some in (robot.links, robot.joints) for one in some):
            has[-1].add("urdf_elements")
    equal_formats = sides[0].format is sides[1].format
    topics: set[str] = set() if equal_formats else set(_OF_DESCRIPTIONS)
    for at, (side, other) in enumerate((sides, sides[::-1])):
        lacking = _lacking(side.format)
        lost = [topic for topic in _TOPICS if topic in lacking - _lacking(other.format)]
        lost += [] if side.format is YAML else sorted(has[1 - at] & _words_of_packages())
        empty = [t for t in _WHOLE if not equal_formats and t not in lacking | has[at]]
        for missing, why in ((lost, "has no word for it"), (empty, "leaves out all of it")):
            words = [_TOPICS.get(topic, ("", topic))[1] for topic in missing if topic in has[1 - at]]
            if words:
                report.not_compared.append(f"{phrase(words)}: {side.label} is {side.format.article_name}, which {why}")
        topics |= {*lost, *empty, *lacking}
    if not equal_formats and "contact" not in topics:
        # Formats differ in the contacts between adjacent links that they disable by default.
        topics.add("contact")
        if "contact" in has[0] | has[1]:
            report.not_compared.append("disabled contacts: a simulation adds those of neighbours")
    return frozenset(topics)


def _without_topics(found: Leaves, topics: frozenset[str], robot: Robot) -> None:
    for thing in [*found]:
        kind, entry = thing[0], found[thing]
        is_name_only = not entry  # such as a contact layer, which has no values
        of = {quantity: _topic(thing, quantity, robot) for quantity in entry or ("",)}
        for quantity, topic in of.items():
            if topic in topics or (topic in _ELSEWHERE and kind != "height map"):
                entry.pop(quantity, None)
        if entry or (is_name_only and of[""] not in topics):
            continue
        is_required = kind in ("joint", "link", "frame", "robot")
        if not is_required or (kind == "frame" and all(one in topics for one in of.values())):
            del found[thing]


def _reduce(
    thing: Thing, entries: Sequence[dict[str, Any]], robots: Sequence[Robot], flipped: Mapping[str, bool]
) -> None:
    """Remove values that are compared elsewhere, or whose difference has no effect on the robot."""
    kind, name = thing
    keys = {*entries[0], *entries[1]}
    gone: set[str] = set()
    if kind == "frame" and name in robots[0].joint_to:
        gone = {"parent", "origin"}
    elif kind == "joint":
        types = [entry.get("type") for entry in entries]
        free = "continuous" in types or flipped.get(name)
        gone = {"child", "axis"} | ({"limit lower", "limit upper"} if free else set())
        gone |= keys - {"type"} if "fixed" in types else set()
        for entry in entries:
            entry.update({word: entry.get(word, 0.0) for word in keys.intersection(_ZERO)})
    elif kind == "sensor":
        gone = {"joint"}
    elif kind == "drive" and entries[0].get("kind") != entries[1].get("kind"):
        gone = keys - {"kind"}
    elif kind == "pose":  # joints that a pose omits are at zero; mimic joints depend on others
        both = robots[0].joint.keys() & robots[1].joint.keys()
        gone = keys & (robots[0].joint.keys() ^ robots[1].joint.keys())
        gone |= {word for word in keys & both if any(robot.joint[word].mimic for robot in robots)}
        for entry in entries:
            entry.update({joint: entry.get(joint, 0.0) for joint in keys & both})
    for entry in entries:
        for word in gone:
            entry.pop(word, None)


def _without_equals(old: Leaves, new: Leaves) -> None:
    """Remove equal entries from both lists of unnamed entries, and renumber the remaining entries."""
    for kind in dict.fromkeys(kind for kind, name in (*old, *new) if name.isdecimal()):
        lists = [[side.pop(one) for one in [*side] if one[0] == kind and one[1].isdecimal()] for side in (old, new)]
        for entry in [*lists[0]]:
            for left in lists if entry in lists[1] else ():
                left.remove(entry)
        for side, left in zip((old, new), lists, strict=True):
            side |= {(kind, str(number)): entry for number, entry in enumerate(left, 1)}


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
    if is_number(value):
        return float(value)
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):
        return size_of(value)
    return (value if isinstance(value, str) else value and text_of(value)) or None


def _add_elements(old: Leaves, new: Leaves, robots: tuple[Robot, Robot]) -> None:
    """Add raw URDF elements that only one robot has and that no output of the other robot generates."""
    a, b = robots
    followers = followers_of(a, a.asks_for_humble or b.asks_for_humble)
    made: list[list[frozenset[Key]]] = []
    for robot in robots:
        known = [(FORMATS[output.backend], output) for output in robot.outputs if output.backend in FORMATS]
        texts = (one.brings(robot, output) for one, output in known if one.brings)
        made.append([frozenset(meanings(text, followers)) for text in texts])
    places: list[tuple[str, Any, Any]] = [("the robot", a, b)]
    for mine, theirs in ((a.link, b.link), (a.joint, b.joint)):
        places += [(name, mine[name], theirs[name]) for name in mine if name in theirs]
    for name, *both in places:
        has = [frozenset(meanings(one.urdf_elements, followers)) for one in both]
        for at, side in enumerate((old, new)):
            alone = has[at] - has[1 - at]
            if name == "the robot":
                # Elements that every output of a description generates must also exist in the file to compare with.
                every = frozenset() if robots[1 - at].outputs or not made[at] else frozenset.intersection(*made[at])
                alone = alone.difference(*made[1 - at]) | (every - has[1 - at])
            side[f"URDF elements of {name}", name] = {"": frozenset(map(spelt, alone))}

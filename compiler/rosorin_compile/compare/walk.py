"""Convert robots and artifacts to dicts of single values ("leaves"), and find values that differ.

``leaves`` converts a ``Robot``, or a small dataclass of a format, to a dict {(kind, name): {quantity: value}}, such as
{("frame", "laser"): {"origin": pose}}. The same value has the same address in every format.

The module also finds links and joints that were renamed. A link that only the old robot has and a link that only the
new robot has are the same link if the joint above has the same name, if the same frame is attached to both, or if their
pose is equal. Two joints are the same joint if they have the same child link.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any, NamedTuple

from rosorin_compile.language.annotations import ENTRIES
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Edge, HeightMap, Inertial, Joint, Link, Pose, Robot, Shape, Vector
from rosorin_compile.model.geometry import IDENTITY, rotation_of_rpy
from rosorin_compile.model.joint import UNPUBLISHED, Publisher
from rosorin_compile.model.link import along_link, limited_fields
from rosorin_compile.model.robot import JointPose
from rosorin_compile.source.xml.elements import values_of

from .precision import NOISE, TURNS, Precision, Precisions, exact, join_errors
from .sentences import is_number
from .solids import Solid, match, same, solid_of


class Address(NamedTuple):
    """The address of a value: kind and name of the entry, and the quantity ("" for the entry itself)."""

    kind: str
    name: str
    quantity: str = ""


class Difference(NamedTuple):
    """A value that differs; ``old`` or ``new`` is None if that side does not have the value."""

    address: Address
    old: Any
    new: Any


Thing = tuple[str, str]
Leaves = dict[Thing, dict[str, Any]]
Names = Mapping[str, str]

# Fields that do not describe the robot: sources of values, outputs, and file contents.
_FILES = ("outputs", "missing_meshes", "mesh_files", "mesh_contents")
SKIPPED = frozenset({"source", "stand_in", "stand_ins", *_FILES, "root_in_world"})
# The kind of the entries of each section. Other sections are converted by separate functions.
_WORDS = {"control": "hardware", "controllers": "controller", "drive": "drive", "moveit": "moveit"}
_WORDS |= {"publishers": "publisher", "servos": "servo", "materials": "material", "sensors": "sensor"}
_WORDS |= {"actuators": "actuator", "constraints": "constraint"}
_EMPTY: frozenset[str] = frozenset()
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
# Last words of quantities in m or rad, for which the tolerance is absolute below 1 m or 1 rad.
_ABSOLUTE = frozenset(
    {"xyz", "rpy", "axis", "lower", "upper", "offset", "rising", "falling", "reference", "position", "limit"}
)
_LINKS = ("frame", "link", "height map")
_DIGITS = 9  # decimals (m, rad) of poses that identify a link
# The fraction of names that must begin with a prefix for it to be detected.
_MOST = 0.6


def compare_leaves(
    old: Leaves, new: Leaves, precisions: Precisions = (exact, exact), tolerance: float = NOISE
) -> list[Difference]:
    """Return all values that differ between two dicts of values (see ``leaves``).

    ``precisions`` return the errors of the old and of the new numbers. Differences up to ``tolerance`` are ignored as
    well. The tolerance is relative to the larger number, but absolute for lengths below 1 m and angles below 1 rad.
    """
    found: list[Difference] = []
    for thing in dict.fromkeys([*old, *new]):
        first, second = old.get(thing), new.get(thing)
        if first is None or second is None:
            sides = [_EMPTY if side is None else side.get("", side) for side in (first, second)]
            is_set = any(isinstance(side, frozenset) and side for side in sides)
            found.append(Difference(Address(*thing), *(sides if is_set else (first, second))))
            continue
        for quantity in dict.fromkeys([*first, *second]) if first != second else ():
            values = first.get(quantity), second.get(quantity)
            if not _same(thing[0], quantity, *values, precisions, tolerance):
                found.append(Difference(Address(*thing, quantity), *values))
    return found


def _same(kind: str, quantity: str, old: Any, new: Any, precisions: Precisions, tolerance: float) -> bool:
    if old is new or (type(old) is type(new) and old == new):
        return True
    if old is None or new is None:
        return False

    def near(key: str, old: Sequence[float], new: Sequence[float]) -> bool:
        largest = max(map(abs, (*old, *new)), default=0.0)
        floor = max(1.0, largest) if key in _ABSOLUTE else largest if len(old) > 1 else 0.0
        apart = [abs(a - b) - tolerance * max(floor, abs(a), abs(b)) for a, b in zip(old, new, strict=True)]
        off = max(apart, default=0.0)
        return off <= 0.0 or off <= join_errors(precisions[0](key, *old), precisions[1](key, *new))

    if isinstance(old, Pose) and isinstance(new, Pose):
        return near("xyz", old.xyz, new.xyz) and same_turn(old.rpy, new.rpy, precisions, tolerance)
    if isinstance(old, Shapes) and isinstance(new, Shapes):
        sides = old.shapes, new.shapes
        if len(old.shapes) == len(new.shapes):  # leave out equal shapes, so that few are matched
            pairs = [(a, b) for a, b in zip(*sides, strict=True) if a != b]
            pairs = [(a, b) for a, b in pairs if not same(solid_of(a), solid_of(b), tolerance)]
            sides = tuple(a for a, _ in pairs), tuple(b for _, b in pairs)
        first, second = (Shapes(shapes).solids(p) for shapes, p in zip(sides, precisions, strict=True))
        rest = match(first, second, tolerance)
        return not rest.old and not rest.new
    key = "position" if kind == "pose" else "xyz" if quantity == "centre of mass" else quantity.rpartition(" ")[2]
    if is_number(old) and is_number(new):
        return near(key, (old,), (new,))
    if isinstance(old, (tuple, list)) and isinstance(new, (tuple, list)):
        if quantity == "inertia":
            apart, least = [abs(a - b) for a, b in zip(old, new, strict=True)], tolerance * max(map(abs, old))
            least = least if all(one <= least for one in apart) else known_inertia(old, new, precisions, tolerance)
            return all(one <= least for one in apart)
        if len(old) != len(new) or all(map(is_number, (*old, *new))):
            return len(old) == len(new) and near(key, old, new)
        return all(_same(kind, key, *both, precisions, tolerance) for both in zip(old, new, strict=True))
    return bool(old == new)


def same_turn(old: Vector, new: Vector, precisions: Precisions, tolerance: float) -> bool:
    """Return True if two triples of Euler angles (roll, pitch, yaw; rad) are the same rotation."""
    if old == new:
        return True
    known = TURNS * join_errors(precisions[0]("rpy", *old), precisions[1]("rpy", *new)) + tolerance
    rows = zip(rotation_of_rpy(old), rotation_of_rpy(new), strict=True)
    return all(abs(a - b) <= known for pair in rows for a, b in zip(*pair, strict=True))


def known_inertia(old: Sequence[float], new: Sequence[float], precisions: Precisions, tolerance: float) -> float:
    """Return the largest difference (kg*m^2) that rounding can cause between entries of equal inertia tensors."""
    largest = max(map(abs, (*old, *new)), default=0.0)
    one, other = precisions
    numbers = join_errors(one("ixx", *old), other("ixx", *new))
    return TURNS * numbers + largest * (TURNS * join_errors(one("rpy", 1.0), other("rpy", 1.0)) + tolerance)


class Shapes(NamedTuple):
    """The visual or collision shapes of a link, compared as a single value because their order does not matter."""

    shapes: tuple[Shape, ...]

    def solids(self, precision: Precision = exact) -> list[Solid]:
        """Convert the shapes to solids; a height map becomes many boxes."""
        return [solid_of(piece, precision) for shape in self.shapes for piece in shape.solids()]


def leaves(value: Any) -> Leaves:
    """Convert a robot, or a dataclass of a format, to a dict of its values: {(kind, name): {quantity: value}}."""
    found: Leaves = {}
    names = [""] if isinstance(value, Robot) else [field.name for field in fields(value)]
    for name, content in ((name, getattr(value, name) if name else value) for name in names):
        kind = name.replace("_", " ")
        if isinstance(content, Robot):
            _robot(content, found)
        elif isinstance(content, Mapping):
            for key, entry in content.items():
                _flatten(entry, "", found.setdefault((kind, str(key)), {}))
        elif isinstance(content, tuple) and content and is_dataclass(content[0]):
            if isinstance(content[0], Edge):
                _edges(content, found)
            elif isinstance(content[0], JointPose):
                _poses(content, found)
            else:
                _entries(_WORDS.get(name, kind), content, found)
        elif content is not None and content not in ((), frozenset()):
            found.setdefault((kind, kind), {})[""] = content
    return found


def _robot(robot: Robot, found: Leaves) -> None:
    texts = (("name", robot.name), ("source", robot.source.note))
    own = found["robot", "robot"] = {key: text for key, text in texts if text}
    _elements(robot.urdf_elements, own)
    _elements(robot.mjcf, own, "mjcf element")
    for link in robot.links:
        _link(link, found)
    for joint in robot.joints:
        _joint(joint, found)
    _edges(robot.edges, found)
    _poses(robot.poses, found)
    if pairs := frozenset(" - ".join(sorted(pair)) for pair in robot.disabled_contacts):
        found["contacts", "disabled contacts"] = {"": pairs}
    if robot.modes:
        own["modes"] = robot.modes
    for name, word in section_words().items():
        section = getattr(robot, name, None) if name not in robot.sections.said else robot.sections.said[name]
        if isinstance(section, Mapping) and sections()[name].merge == ENTRIES:
            for key, entry in section.items():
                _flatten(entry, "", found.setdefault((word, str(key)), {}))
        elif isinstance(section, (tuple, list)):
            _entries(word, section, found)
        elif section is not None:
            _flatten(section, "", found.setdefault((word, word), {}))


@cache
def section_words() -> Mapping[str, str]:
    """Map the name of each section that is compared to the kind of its entries, such as "sensors" to "sensor"."""
    known = {field.name for field in fields(Robot)}
    return _WORDS | {name: one.compared for name, one in sections().items() if one.compared and name not in known}


def _poses(poses: Iterable[JointPose], found: Leaves) -> None:
    for pose in poses:
        entry: dict[str, Any] = dict(pose.positions)
        _flatten({"base": pose.base, "controls": pose.controls, "mjcf": pose.mjcf}, "", entry)
        if entry or pose.name != "home":  # every generated MJCF has a keyframe "home", even without such a pose
            found["pose", pose.name] = entry


def _link(link: Link, found: Leaves) -> None:
    entry = found.setdefault(("link", link.name), {})
    entry |= inertial_leaves(link.inertial)
    for purpose, shapes in (("collision", link.collision), ("visual", link.visual)):
        if solid := tuple(shape for shape in shapes if not isinstance(shape.geometry, HeightMap)):
            entry[purpose] = Shapes(solid)
        for shape in shapes:
            if isinstance(shape.geometry, HeightMap):
                grid = found.setdefault(("height map", link.name), {})
                _flatten(shape.geometry, "", grid)
                pose = shape.pose if shape.pose != IDENTITY else None
                _flatten({"pose": pose, "name": shape.name, "stand_in": shape.stand_in}, "", grid)
    _elements(link.urdf_elements, entry)
    for mark in link.marked:
        _flatten(mark, "", found.setdefault((mark.tag, mark.name), {"link": link.name}))
    limited = {name.replace("_", " "): value for name in limited_fields(Link) if (value := getattr(link, name))}
    _flatten({**limited, **link.mjcf}, "", entry)
    _elements(link.mjcf_elements, entry, "mjcf element")


def inertial_leaves(inertial: Inertial | None) -> dict[str, Any]:
    """Return mass (kg), centre of mass (m) and inertia (kg*m^2, axes of the link) by name, or {} if all are zero."""
    six = tuple(getattr(inertial, name) for name in _INERTIA) if inertial is not None else ()
    if inertial is None or not any((inertial.mass, *six)):
        return {}
    inertia = along_link(six, inertial.pose.transform())
    return {"mass": inertial.mass, "centre of mass": inertial.pose.xyz, "inertia": inertia}


def _joint(joint: Joint, found: Leaves) -> None:
    frame = found.setdefault(("frame", joint.child), {})
    frame |= {"parent": joint.parent, "origin": joint.origin} | _publisher(joint.publisher)
    if not joint.name:
        return
    entry = found.setdefault(("joint", joint.name), {})
    entry |= {"type": joint.type, "child": joint.child}
    if joint.moves or joint.type == "planar":
        entry["axis"] = joint.axis
    if joint.mimic is not None:
        entry |= {f"mimic {name}": getattr(joint.mimic, name) for name in ("joint", "multiplier", "offset")}
    for part in ("limit", "dynamics", "calibration", "safety", "actuator"):
        _flatten(getattr(joint, part), "" if part == "dynamics" else part, entry)
    for gain in ("kp", "kv"):
        if f"actuator {gain}" in entry:
            entry[gain] = entry.pop(f"actuator {gain}")
    _elements(joint.urdf_elements, entry)
    _flatten(joint.mjcf, "", entry)


def _publisher(publisher: Publisher) -> dict[str, Any]:
    nobody = f"nobody: {' '.join(publisher.about.split())}" if publisher.about else "nobody"
    name = publisher.name if publisher.kind != UNPUBLISHED else nobody
    return {"publisher": "simulations" if publisher.simulated else name}


def _edges(edges: Iterable[Edge], found: Leaves) -> None:
    """Add transforms to ``found``, keyed by child frame, such as "laser".

    If a frame has several parents, the keys of the others are like "laser below mast". A condition is appended, as in
    "laser when MODE".
    """
    parents: dict[str, str] = {}
    for edge in edges:
        first = parents.setdefault(edge.child, edge.parent)
        name = edge.child if first == edge.parent else f"{edge.child} below {edge.parent}"
        name = f"{name} when {' '.join(edge.when.split())}" if edge.when else name
        entry = found.setdefault(("frame", name), {})
        entry |= {"parent": edge.parent} | _publisher(edge.publisher)
        if edge.pose is not None:
            entry["origin"] = edge.pose
        if edge.publisher.publishes:
            entry["topic"] = edge.topic


def _entries(kind: str, entries: Iterable[Any], found: Leaves) -> None:
    for number, entry in enumerate(entries, 1):
        name = entry if isinstance(entry, str) else str(getattr(entry, "name", "") or number)
        name = f"{name} ({number})" if (kind, name) in found else name
        own = found.setdefault((kind, name), {})
        if not isinstance(entry, str):
            _flatten(entry, "", own)


def _elements(texts: Iterable[str], entry: dict[str, Any], word: str = "element") -> None:
    for place, value in values_of(f"<all>{''.join(texts)}</all>") if texts else ():
        entry[f"{word} {place}"] = value


def _flatten(value: Any, path: str, entry: dict[str, Any]) -> None:
    """Add the values of a nested object that are not defaults to ``entry``; the keys begin with ``path``."""
    if value is None or value == () or value == "" or value == {}:
        return
    if type(value) in (float, str):
        entry[path] = value
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            _flatten(inner, f"{path} {key}".strip(), entry)
    elif is_dataclass(value) and not isinstance(value, Pose):
        for name, default, is_always in _fields(type(value)):  # type: ignore[arg-type]
            if (inner := getattr(value, name)) != default or is_always:
                word = "" if name in ("values", "mjcf") else name.replace("_", " ")  # the keys of these need no prefix
                _flatten(inner, f"{path} {word}".strip(), entry)
    elif isinstance(value, (tuple, list)) and any(is_dataclass(one) or isinstance(one, Mapping) for one in value):
        for number, inner in enumerate(value, 1):
            count, place = len(entry), f"{path} {getattr(inner, 'name', '') or number}".strip()
            _flatten(inner, place, entry)
            if len(entry) == count:  # record the existence of an entry that only has a name
                entry[place] = True
    else:
        entry[path] = float(value) if is_number(value) else value


@cache
def _fields(kind: type) -> list[tuple[str, Any, bool]]:
    """Return (name, default, True if the default is listed as well, to show both numbers of a change) of fields."""
    found = [(field.name, field.default) for field in fields(kind) if field.name not in (*SKIPPED, "name")]
    shown = ((is_dataclass(one) and not isinstance(one, Pose)) or (is_number(one) and bool(one)) for _, one in found)
    return [(*field, is_shown) for field, is_shown in zip(found, shown, strict=True)]


def links_of(found: Leaves) -> set[str]:
    """Return the names of all links and frames in a dict of values."""
    names = {name for kind, name in found if kind in ("frame", "link")}
    return names | {str(of["parent"]) for (kind, _), of in found.items() if kind == "frame" and "parent" in of}


def new_link_names(old: Leaves, new: Leaves) -> dict[str, str]:
    """Map the old name of each renamed link to its new name."""
    before, after = links_of(old), links_of(new)
    gone, fresh = before - after, after - before
    found: dict[str, str] = {}
    signs = ["joint", "child", "place"] if gone and fresh else []
    waiting = list(signs)
    while waiting:  # each new match may identify further links
        sign = waiting.pop(0)
        was, now = _signs(old, gone, sign, found), _signs(new, fresh, sign, found)
        made = {link: now[key] for key, link in was.items() if key in now and link not in found}
        made = {link: name for link, name in made.items() if name not in found.values()}
        found |= made
        waiting = list(signs) if made else waiting
    return found


def _signs(side: Leaves, links: Collection[str], sign: str, renamed: Names) -> dict[tuple[Any, ...], str]:
    """Map values that identify a link to the link; ``sign`` selects its "joint", its "child" frames or its "place"."""
    found: dict[tuple[Any, ...], str] = {}
    shared = set()
    roots = [link for link in links if ("frame", link) not in side] if sign == "place" else []
    signs: list[tuple[str, tuple[Any, ...]]] = [(link, ("",)) for link in roots]
    for (kind, name), of in side.items():
        origin = of.get("origin")
        if sign == "joint" and kind == "joint" and of.get("child") in links:
            signs.append((of["child"], (name,)))
        elif sign == "child" and kind == "frame" and of.get("parent") in links:
            signs.append((of["parent"], (name,)))
        elif sign == "place" and kind == "frame" and name in links and isinstance(origin, Pose):
            signs.append((name, (of.get("parent", ""), *(round(x, _DIGITS) + 0.0 for x in (*origin.xyz, *origin.rpy)))))
    for link, value in signs:
        key = (renamed.get(value[0], value[0]), *value[1:])
        if found.setdefault(key, link) != link:
            shared.add(key)
    return {key: link for key, link in found.items() if key not in shared}


def new_joint_names(old: Leaves, new: Leaves) -> dict[str, str]:
    """Map the old name of each renamed joint to its new name. Joints are identified by their child link."""
    joints = [[(name, of) for (kind, name), of in side.items() if kind == "joint"] for side in (old, new)]
    before, after = ({of["child"]: name for name, of in some if "child" in of} for some in joints)
    found = {name: after[child] for child, name in before.items() if after.get(child, name) != name}
    # A joint whose child link was removed can get the child link of another joint, which is then not a renamed joint.
    kept = {before[child] for child in before.keys() - after} | {after[child] for child in after.keys() - before}
    fixed = [{name for name, of in some if of.get("type") == "fixed"} for some in joints]
    unlike = {name for name, other in found.items() if (name in fixed[0]) != (other in fixed[1])}
    return {name: other for name, other in found.items() if name not in unlike or kept.isdisjoint((name, other))}


def with_names(found: Leaves, names: Names, what: str, new: Leaves) -> Leaves:
    """Rename links or joints (``what``) in a dict of values; rename references only if ``new`` has the new name."""
    if not names:
        return found
    kinds = _LINKS if what == "link" else ("joint",)
    made: Leaves = {}
    for (kind, name), entry in found.items():
        plain, space, rest = name.partition(" ")  # such as "laser when docked"
        if kind in kinds or (kind, name) not in new:
            name = f"{names[plain]}{space}{rest}" if plain in names else names.get(name, name)
        now = new.get((kind, name), {})
        own = made[kind, name] = {}
        for quantity, value in entry.items():
            words = " ".join(names.get(word, word) for word in quantity.split(" "))
            place = quantity if kind in ("frame", "joint") or quantity in now or words not in now else words
            own[place] = _value(kind, place, value, names, kinds, now.get(place))
    return made


def _value(kind: str, quantity: str, value: Any, names: Names, kinds: Sequence[str], now: Any) -> Any:
    if isinstance(value, frozenset):
        return frozenset(" - ".join(sorted(names.get(word, word) for word in one.split(" - "))) for one in value)
    if isinstance(value, tuple) and value and all(isinstance(one, str) for one in value):
        other = tuple(names.get(one, one) for one in value)
        return other if other == now else value
    if not isinstance(value, str):
        return value
    if "link" in kinds and quantity in ("parent", "child") and kind in ("frame", "joint"):
        return names.get(value, value)
    return now if isinstance(now, str) and names.get(value) == now else value


def renamed_robot(robot: Robot, links: Names, joints: Names) -> Robot:
    """Return the robot with renamed links and joints. References in its sections are not renamed."""

    def renamed(joint: Joint) -> Joint:
        mimic = joint.mimic and replace(joint.mimic, joint=joints.get(joint.mimic.joint, joint.mimic.joint))
        parent, child = links.get(joint.parent, joint.parent), links.get(joint.child, joint.child)
        return replace(joint, name=joints.get(joint.name, joint.name), parent=parent, child=child, mimic=mimic)

    named = tuple(replace(link, name=links.get(link.name, link.name)) for link in robot.links)
    return replace(robot, links=named, joints=tuple(map(renamed, robot.joints)))


def prefix_of(a: Robot, b: Robot) -> str:
    """Return the prefix that ``b`` adds to most link names of ``a``, or "" if there is none."""
    mine, theirs = [link.name for link in a.links], [link.name for link in b.links]
    ends = [other[: -len(name)] for name in mine for other in theirs if other.endswith(name) and other != name]
    best = max(sorted(set(ends)), key=ends.count, default="")
    count = ends.count(best)
    is_most = count > max(1, len(set(mine) & set(theirs))) and count >= _MOST * min(len(mine), len(theirs))
    return best if is_most else ""


def without_prefix(names: Iterable[str], prefix: str) -> dict[str, str]:
    """Map names that start with a prefix to the names without it, except if such a name is already used."""
    every = set(names)
    cut = {name: name.removeprefix(prefix) for name in every if name.startswith(prefix) and name != prefix}
    return {name: short for name, short in cut.items() if short not in every}

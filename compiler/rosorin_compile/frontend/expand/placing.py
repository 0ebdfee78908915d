"""Placing: what a part holds gets its prefix, is mirrored, and is attached to its frame.

A part speaks of its own links and joints by their short names, and of the frame that it is attached to as ``mount``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from ...model import Pose, Transform
from ...model.drive import ROLES
from ...model.geometry import pose_of
from ...units import ANGLE, LENGTH, Dimension, Quantity
from ...xml.elements import found_in
from ...xml.mujoco import BODY, SITE, names_given, used, with_names
from ...xml.references import named_in, renamed
from ..schema import ONE_ENTRY
from ..tree import Instance, Kept, Map, Seq
from .forms import KEPT, OF_MJCF, XML, is_number

MOUNT = "mount"
AXES = {"x": 0, "y": 1, "z": 2}
# What the sides of a base become that is mirrored across x, y or z.
_MIRRORED: tuple[dict[str, str], ...] = ({"front": "rear", "rear": "front"}, {"left": "right", "right": "left"}, {})

# Sections for a simulation alone, and what a link has for it by name.
SIMULATED = ("actuators", "tendons", "constraints", "mjcf_sensors")
_MARKS = ("sites", "cameras", "lights")
_SHAPES = ("collision", "visual")
# The keys in them whose values are names: one, or several as a list or as the keys of a table.
_NAMING = frozenset(
    (
        *("joint", "joint_in_parent", "tendon", "actuator", "body", "camera", "target"),
        *("link", "link1", "link2", "subtree1", "subtree2", "inertial"),
        *("site", "side_site", "reference_site", "slider_site", "crank_site"),
        *("shape", "shape1", "shape2", "mesh", "material"),
        *("links", "joints", "sites", "tendons", "shapes"),
    )
)
# Names that the MJCF makes of that of a link, and ends of those that it makes of that of a joint.
_MADE = re.compile(r"(.+)_(?:collision|visual)_\d+")
_SEVERAL = {"planar": ("_TX", "_TY", "_RZ"), "floating": ("_TX", "_TY", "_TZ", "_R")}

Rename = Callable[[str], str]


def defined_names(fragment: Map) -> frozenset[str]:
    """Return the names that a fragment of a description defines."""
    names: set[str] = set()
    for section in ("links", "joints", "sensors", "servos", "poses", *SIMULATED):
        names.update(fragment.get(section) or ())
    for link in (fragment.get("links") or {}).values():
        for marks in _MARKS if isinstance(link, Map) else ():
            names.update(link.get(marks) or ())
    for sensor in (fragment.get("sensors") or {}).values():
        for owner in (sensor, sensor.get("optical")) if isinstance(sensor, Map) else ():
            if isinstance(owner, Map):
                names.update(name for key in ("frame", "joint") if isinstance(name := owner.get(key), str))
    return frozenset(names)


def simulated_names(fragment: Map) -> frozenset[str]:
    """Return the names that a fragment of a description defines for a simulation, its elements of MJCF too."""
    names = {*defined_names(fragment), *(fragment.get("materials") or ())}
    for name, joint in (fragment.get("joints") or {}).items():
        if not isinstance(joint, Map):
            continue
        names.update(name + end for end in _SEVERAL.get(str(joint.get("type")), ()))
        actuator = joint.get("actuator")
        if isinstance(actuator, Map) and isinstance(actuator.get("name"), str):
            names.add(actuator["name"])
    for text, top in _of_mjcf(fragment):
        names.update(names_given(text, top))
    return frozenset(names)


def _of_mjcf(fragment: Map) -> Iterator[tuple[str, bool]]:
    """Yield the elements of MJCF of a fragment, and whether each is a section of the file."""
    links = [link for link in (fragment.get("links") or {}).values() if isinstance(link, Map)]
    for owner in (fragment, *links):
        for text in owner.get(OF_MJCF) or ():
            if isinstance(text, str):
                yield text, owner is fragment


def names_of_control(fragment: Map) -> frozenset[str]:
    """Return the names of hardware blocks, of their sensors and gpio, and of controllers of a fragment."""
    blocks = fragment.get("control") or {}
    within = (block.get(key) for block in blocks.values() if isinstance(block, Map) for key in ("sensors", "gpio"))
    return frozenset((*blocks, *(fragment.get("controllers") or ()), *(name for one in within for name in one or ())))


def mentions_mount(fragment: Map) -> bool:
    """Say whether anything in a fragment is attached to the mount, or names it."""
    entries = [*(fragment.get("joints") or {}).values(), *(fragment.get("sensors") or {}).values()]
    if any(isinstance(entry, Map) and entry.get("parent") == MOUNT for entry in entries):
        return True
    listed = [*(fragment.get("edges") or ()), *(fragment.get("disabled_contacts") or ())]
    listed += [*(fragment.get("contact_pairs") or ()), *(fragment.get("constraints") or {}).values()]
    if any(isinstance(e, Map) and (e.get("parent") == MOUNT or MOUNT in (e.get("links") or ())) for e in listed):
        return True
    drive = fragment.get("drive")
    if isinstance(drive, Map) and drive.get("frame") == MOUNT:
        return True
    texts = [text for text in fragment.get(KEPT) or () if isinstance(text, str) and MOUNT in text]
    if any(found.name == MOUNT and found.sure for text in texts for found in named_in(text)):
        return True
    return any(
        one.name == MOUNT and one.kind in (BODY, SITE)
        for text, top in _of_mjcf(fragment)
        if MOUNT in text
        for found in found_in(text)
        for one in used(found, top)
    )


class Names(NamedTuple):
    """What a fragment calls its own: as a whole, for a simulation, for ros2_control; ``mounted`` if it is attached.

    ``in_links``: something in its links may have a name.
    """

    defined: frozenset[str]
    simulated: frozenset[str]
    of_control: frozenset[str]
    mounted: bool
    in_links: bool


def names_of(fragment: Map) -> Names:
    """Return the names of a fragment of a description."""
    return Names(
        defined_names(fragment),
        simulated_names(fragment),
        names_of_control(fragment),
        mentions_mount(fragment),
        any(map(_has_names, (fragment.get("links") or {}).values())),
    )


def _has_names(link: Any) -> bool:
    """Say whether something in a link may have a name: elements of XML, sites, cameras, lights."""
    if not isinstance(link, Map):
        return False
    shapes = [shape for key in _SHAPES if isinstance(link.get(key), Seq) for shape in link[key]]
    return any(key in link for key in (*XML, *_MARKS)) or any(isinstance(one, Map) and KEPT in one for one in shapes)


def placed(
    fragment: Map,
    prefix: str,
    parent: str | None,
    xyz: Any,
    rpy: Any,
    mirror: str | None,
    kept: bool = True,
    names: Names | None = None,
) -> Map:
    """Return a fragment with prefixed names, attached to ``parent`` at ``xyz`` and ``rpy`` (metres, radians).

    ``mirror`` reflects what the fragment holds at the plane across x, y or z of the mount. Unless ``kept`` is false,
    links and joints get their names in elements for the URDF, too. ``names`` are those of the fragment, where they are
    known already.
    """
    known = names or names_of(fragment)
    defined, ours = known.defined, known.simulated
    own_frame = MOUNT in defined and MOUNT not in (fragment.get("joints") or ())

    def rename(name: str) -> str:
        return prefix + name if name in defined else name

    def frame(name: str) -> str:
        if name != MOUNT or own_frame:  # a joint may be called mount: that is no frame
            return rename(name)
        return name if parent is None else parent

    def simulated(name: str) -> str:
        found = _MADE.fullmatch(name)
        return prefix + name if name in ours or (found and found[1] in defined) else frame(name)

    renames = (rename, frame, simulated)
    placer = _Placer(renames, prefix, (xyz, rpy), None if mirror is None else AXES[mirror], kept)
    placer.of_control, placer.via = known.of_control, fragment.via
    made = Map(fragment.span, fragment.via)
    for section, value in fragment.items():
        change = getattr(placer, section, None)
        changed = value
        if section == "links" and mirror is None and not known.in_links:
            change = _unchanged
        if section in ONE_ENTRY and change is not None:
            changed = _made_by(change(value), fragment.via, value)
        elif change is not None and value:
            changed = each(value, prefix, change, fragment.via)
        if section in XML and value and (kept or section == OF_MJCF):
            changed = each(value, "", placer.renamed if section == KEPT else placer.top)
            changed = each(changed, "", lambda text: _by(text, fragment.via))
        made.put(section, changed, fragment.key_spans[section], fragment.value_spans[section])
    return made


def each(section: Any, prefix: str, change: Callable[[Any], Any], via: Instance | None = None) -> Any:
    """Return a section with each entry changed, and each name prefixed; ``via`` is the part that made it."""
    if isinstance(section, Map):
        made = Map(section.span, section.via)
        for name, entry in section.items():
            value = _made_by(change(entry), via, entry)
            made.put(prefix + name, value, section.key_spans[name], section.value_spans[name])
        return made
    listed = Seq(section.span, section.via)
    for entry, span in zip(section, section.value_spans, strict=True):
        listed.put(_made_by(change(entry), via, entry), span)
    return listed


def _unchanged(entry: Any) -> Any:
    return entry


def _made_by(entry: Any, via: Instance | None, before: Any) -> Any:
    """Return an entry that knows the part that made it, even where the part took it over as it was written.

    It was ``before`` what it is now; if that is another one, it is new.
    """
    if via is None or not isinstance(entry, Map) or (entry.via is not None and entry.via.made):
        return entry
    if entry is before:
        return entry.by(via)
    entry.via = via
    return entry


def _by(text: Any, via: Instance | None) -> Any:
    """Return elements of XML that know the part that made them."""
    known = text.via if isinstance(text, Kept) else None
    return text if not isinstance(text, str) or (known is not None and known.made) else Kept(text, via)


def changed_text(text: Any, change: Rename) -> Any:
    """Return elements of XML after a change, which know still what made them."""
    made = change(text) if isinstance(text, str) else text
    if made == text:
        return text
    return Kept(made, text.via) if isinstance(text, Kept) else made


def _named_in(value: Any, key: str, texts: Mapping[str, Rename]) -> Any:
    """Return a value with the texts in it renamed, by the nearest key that says how."""
    if isinstance(value, str):
        return texts[key](value) if key in texts else value
    if isinstance(value, Seq):
        return each(value, "", lambda one: _named_in(one, key, texts))
    if isinstance(value, Map):
        return _with(
            value, {name: _named_in(one, name if name in texts else key, texts) for name, one in value.items()}
        )
    return value


def _with(entry: Map, changes: dict[str, Any]) -> Map:
    """Return an entry with some values changed; a new key has the place of the entry."""
    if changes.keys() <= entry.keys():
        return entry.like(changes)
    made = entry.copied()
    for key, value in changes.items():
        if key in entry:
            made[key] = value
        elif value is not None:
            span = getattr(value, "span", entry.span)
            made.put(key, value, span, span)
    return made


class _Placer:
    """One method a section: takes an entry, returns it renamed, mirrored and attached."""

    def __init__(
        self,
        names: tuple[Rename, Rename, Rename],
        prefix: str,
        mount: tuple[Any, Any],
        mirror: int | None,
        kept: bool,
    ) -> None:
        self.rename, self.frame, self.simulated = names
        self.prefix = prefix
        self.kept = kept
        self.mount = mount
        self.mirror = mirror
        self.of_control: frozenset[str] = frozenset()
        self.via: Instance | None = None

    def renamed(self, text: Any) -> Any:
        """Return elements of XML with the new names in them."""
        return changed_text(text, lambda given: renamed(given, self.frame)) if self.kept else text

    def top(self, text: Any) -> Any:
        """Return sections of an MJCF with the new names in them."""
        return changed_text(text, lambda given: with_names(given, True, self.simulated))

    def inner(self, text: Any) -> Any:
        """Return elements of a body of an MJCF with the new names in them."""
        return changed_text(text, lambda given: with_names(given, False, self.simulated))

    def _elements(self, entry: Map) -> dict[str, Any]:
        """Return the changes of the elements of XML that an entry has."""
        texts = entry.get(KEPT)
        return {KEPT: each(texts, "", self.renamed)} if isinstance(texts, Seq) and self.kept else {}

    def links(self, entry: Any) -> Any:
        if not isinstance(entry, Map):
            return entry
        changes = self._elements(entry) | self._marked(entry)
        if isinstance(entry.get(OF_MJCF), Seq):
            changes[OF_MJCF] = each(entry[OF_MJCF], "", self.inner)
        for purpose in _SHAPES:
            shapes = entry.get(purpose)
            if isinstance(shapes, Seq) and any(isinstance(shape, Map) and KEPT in shape for shape in shapes):
                elements = each(shapes, "", lambda one: _with(one, self._elements(one)) if KEPT in one else one)
                changes[purpose] = elements
        entry = _with(entry, changes) if changes else entry
        if self.mirror is None:
            return entry
        changes = {}
        if isinstance(entry.get("inertial"), Map):
            changes["inertial"] = self._mirrored_inertial(entry["inertial"])
        for purpose in _SHAPES:
            if isinstance(entry.get(purpose), Seq):
                changes[purpose] = each(entry[purpose], "", self._mirrored_shape)
        return _with(entry, changes)

    def _marked(self, entry: Map) -> dict[str, Any]:
        """Return the sites, cameras and lights of a link under their new names, where the part is mirrored mirrored."""
        changes = {}
        for key in _MARKS:
            marks = entry.get(key)
            if isinstance(marks, Map):
                changes[key] = each(marks, self.prefix, self._mark)
        return changes

    def _mark(self, mark: Any) -> Any:
        return _with(self._named(mark), self._mirrored_pose(mark)) if isinstance(mark, Map) else mark

    def _named(self, entry: Any) -> Any:
        """Return an entry of a section for simulation in which what it names has the new names."""
        if not isinstance(entry, Map):
            return entry
        changes: dict[str, Any] = {}
        for key, value in entry.items():
            if isinstance(value, str):
                if key in _NAMING:
                    changes[key] = self.simulated(value)
            elif isinstance(value, Seq):
                changes[key] = each(value, "", self._one_named if key in _NAMING else self._named)
            elif isinstance(value, Map):
                changes[key] = self._renamed_keys(value) if key in _NAMING else self._named(value)
        return _with(entry, changes)

    def _one_named(self, value: Any) -> Any:
        return self.simulated(value) if isinstance(value, str) else self._named(value)

    def contact_pairs(self, entry: Any) -> Any:
        entry = self._named(entry)
        name = entry.get("name") if isinstance(entry, Map) else None
        return _with(entry, {"name": self.prefix + name}) if isinstance(name, str) else entry

    def _renamed_keys(self, table: Map) -> Map:
        return self._keys(table, self.simulated)

    def _simulated(self, entry: Any) -> Any:
        entry = self._named(entry)
        return _with(entry, self._mirrored_pose(entry)) if isinstance(entry, Map) else entry

    actuators = tendons = constraints = mjcf_sensors = _simulated

    def joints(self, entry: Any) -> Any:
        if not isinstance(entry, Map):
            return entry
        changes = self._attached(entry)
        changes.update(self._elements(entry))
        if isinstance(entry.get("child"), str):
            changes["child"] = self.frame(entry["child"])
        mimic = entry.get("mimic")
        if isinstance(mimic, Map) and isinstance(mimic.get("joint"), str):
            named = {"name": self.prefix + mimic["name"]} if isinstance(mimic.get("name"), str) else {}
            changes["mimic"] = _with(mimic, {"joint": self.rename(mimic["joint"]), **named})
        actuator = entry.get("actuator")
        if isinstance(actuator, Map) and isinstance(actuator.get("name"), str):
            changes["actuator"] = _with(actuator, {"name": self.prefix + actuator["name"]})
        if self.mirror is not None and entry.get("type") in ("revolute", "continuous", "prismatic", "planar"):
            changes["axis"] = self._mirrored_axis(entry)
        return _with(entry, changes)

    def sensors(self, entry: Any) -> Any:
        if not isinstance(entry, Map):
            return entry
        changes = self._attached(entry)
        changes.update(self._elements(entry))
        for key in ("frame", "joint"):
            if isinstance(entry.get(key), str):
                changes[key] = self.rename(entry[key])
        optical = entry.get("optical")
        if isinstance(optical, Map):
            inner = {key: self.rename(optical[key]) for key in ("frame", "joint") if isinstance(optical.get(key), str)}
            changes["optical"] = _with(optical, inner | self._published(optical) | self._mirrored_pose(optical))
        return self._renamed_list(_with(entry, changes), "stamps")

    def edges(self, entry: Any) -> Any:
        if not isinstance(entry, Map):
            return entry
        changes = self._attached(entry)
        if isinstance(entry.get("child"), str):
            changes["child"] = self.frame(entry["child"])
        return _with(entry, changes)

    def drive(self, entry: Any) -> Any:
        """Return the drive; where it is mirrored, left wheels are right ones, or front wheels rear ones."""
        if not isinstance(entry, Map):
            return entry
        changes: dict[str, Any] = {}
        for kind in ROLES:
            roles = entry.get(kind)
            if isinstance(roles, Map):
                made = Map(roles.span, roles.via)
                for role, names in roles.items():
                    made.put(self._side(role), self._joints(names), roles.key_spans[role], roles.value_spans[role])
                changes[kind] = made
        if isinstance(entry.get("frame"), str):
            changes["frame"] = self.frame(entry["frame"])
        return _with(entry, changes)

    def moveit(self, entry: Any) -> Any:
        """Return what is said for MoveIt: groups and end effectors have names, which get the prefix."""
        if not isinstance(entry, Map):
            return entry
        own = frozenset(entry.get("groups") or ())

        def grouped(name: str) -> str:
            return self.prefix + name if name in own else name

        texts: dict[str, Rename] = {
            **dict.fromkeys(("base", "tip", "links", "parent", "unchecked_links", "checked_collisions"), self.frame),
            **dict.fromkeys(("joints", "passive_joints", "states"), self.rename),
            **dict.fromkeys(("groups", "group", "parent_group"), grouped),
        }
        changes: dict[str, Any] = {}
        for key in ("passive_joints", "unchecked_links", "checked_collisions", "disabled_collisions"):
            if key in entry:
                value = _named_in(entry[key], key, texts)
                changes[key] = each(value, "", self._made) if isinstance(value, Seq) else value
        for key, prefix in (("groups", self.prefix), ("end_effectors", self.prefix)):
            if isinstance(entry.get(key), Map):
                changes[key] = each(entry[key], prefix, lambda one: _named_in(one, "", texts), self.via)
        for key, rename in (("spheres", self.frame), ("joint_properties", self.rename)):
            table = entry.get(key)
            if isinstance(table, Map):
                made = Map(table.span, table.via)
                for name, value in table.items():
                    one = each(value, "", self._mark) if isinstance(value, Seq) else value
                    made.put(rename(name), self._made(one), table.key_spans[name], table.value_spans[name])
                changes[key] = made
        return _with(entry, changes)

    def _made(self, item: Any) -> Any:
        """Return an item of what others are joined to: it knows the part that made it."""
        if isinstance(item, str):
            return Kept(item, self.via)
        if isinstance(item, Seq):
            made = each(item, "", _unchanged)
            made.via = self.via
            return made
        return _made_by(item, self.via, item)

    def _joints(self, names: Any) -> Any:
        """Return the name of a joint, or a list of such, as they are called outside."""
        if isinstance(names, str):
            return self.rename(names)
        return each(names, "", self._joints) if isinstance(names, Seq) else names

    def _side(self, role: str) -> str:
        """Return what wheels are that stood there before they were mirrored."""
        swapped = _MIRRORED[self.mirror] if self.mirror is not None else {}
        return "_".join(swapped.get(word, word) for word in role.split("_"))

    def servos(self, entry: Any) -> Any:
        return self._renamed_list(entry, "joints")

    def disabled_contacts(self, entry: Any) -> Any:
        return self._renamed_list(entry, "links", self.frame)

    def poses(self, entry: Any) -> Any:
        if not isinstance(entry, Map):
            return entry
        changes = {}
        for key in ("positions", "pulses", "controls"):
            table = entry.get(key)
            if isinstance(table, Map):
                changes[key] = self._renamed_keys(table)
        return _with(entry, changes)

    def control(self, entry: Any) -> Any:
        if not isinstance(entry, Map):
            return entry
        renames = {"joints": self.rename, "sensors": self._controlled, "gpio": self._controlled}
        changes: dict[str, Any] = {
            key: self._keys(table, rename)
            for key, rename in renames.items()
            if isinstance(table := entry.get(key), Map)
        }
        if isinstance(entry.get("transmissions"), Map):
            changes["transmissions"] = each(entry["transmissions"], self.prefix, self._transmission)
        if isinstance(entry.get("pose"), str):
            changes["pose"] = self.rename(entry["pose"])
        return _with(entry, changes)

    def _transmission(self, entry: Any) -> Any:
        if not isinstance(entry, Map):
            return entry
        rename = {"joints": self.rename, "actuators": lambda name: self.prefix + name}
        tables = {key: table for key in rename if isinstance(table := entry.get(key), Map)}
        return _with(entry, {key: self._keys(table, rename[key]) for key, table in tables.items()})

    def controllers(self, entry: Any) -> Any:
        if not isinstance(entry, Map):
            return entry
        changes = {k: self._controlled(v) for k in ("hardware", "sensor") if isinstance(v := entry.get(k), str)}
        return _with(entry, changes | {key: self._params(entry[key]) for key in ("params",) if key in entry})

    def _params(self, value: Any) -> Any:
        """Return parameters of a controller in which joints, frames, sensors and controllers have the new names."""
        if isinstance(value, str):
            name, slash, rest = value.partition("/")  # an interface: joint1/position
            return self._controlled(name) + slash + rest if slash else self._controlled(value)
        if isinstance(value, Seq):
            return each(value, "", self._params)
        if not isinstance(value, Map):
            return value
        made = Map(value.span, value.via)
        for key, item in value.items():
            name = ".".join(self._controlled(word) for word in key.split("."))
            made.put(name, self._params(item), value.key_spans[key], value.value_spans[key])
        return made

    def _controlled(self, name: str) -> str:
        return self.prefix + name if name in self.of_control else self.frame(name)

    def _keys(self, table: Map, rename: Rename) -> Map:
        made = Map(table.span, table.via)
        for name, value in table.items():
            made.put(rename(name), value, table.key_spans[name], table.value_spans[name])
        return made

    def _renamed_list(self, entry: Any, key: str, rename: Rename | None = None) -> Any:
        if not isinstance(entry, Map) or not isinstance(entry.get(key), Seq):
            return entry
        change = rename or self.rename
        return _with(entry, {key: each(entry[key], "", lambda name: change(name) if isinstance(name, str) else name)})

    def _attached(self, entry: Map) -> dict[str, Any]:
        """Return the changes of an entry that sits on a frame: its parent, its pose, the node that publishes it."""
        changes = self._mirrored_pose(entry)
        parent = entry.get("parent")
        if isinstance(parent, str):
            changes["parent"] = self.frame(parent)
            if parent == MOUNT and self.mount != (None, None):
                changes.update(self._mounted(entry, changes))
        if "publisher" in entry:
            changes.update(self._published(entry))
        return changes

    def _published(self, entry: Map) -> dict[str, Any]:
        """Return the publishers of an entry, the static ones renamed: each part starts its own."""
        publisher = entry.get("publisher")
        if isinstance(publisher, Seq):
            return {"publisher": each(publisher, "", self._turn)}
        return self._static(entry, "publisher")

    def _turn(self, turn: Any) -> Any:
        return _with(turn, self._static(turn, "by")) if isinstance(turn, Map) else turn

    def _static(self, entry: Map, key: str) -> dict[str, Any]:
        publisher = entry.get(key)
        if not isinstance(publisher, Map) or not isinstance(publisher.get("static_transform_publisher"), str):
            return {}
        node = self.prefix + publisher["static_transform_publisher"]
        return {key: _with(publisher, {"static_transform_publisher": node})}

    def _mounted(self, entry: Map, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the pose of an entry on the mount, seen from the frame that the part is attached to."""
        xyz, rpy = self.mount
        own = [changes.get(key, entry.get(key)) for key in ("xyz", "rpy")]
        if own == [None, None]:
            return {"xyz": xyz, "rpy": rpy}
        dimensions = (LENGTH, ANGLE, LENGTH, ANGLE)
        if not all(_is_vector(v, d) for v, d in zip((xyz, rpy, *own), dimensions, strict=True)):
            return {}  # what is wrong is still there to be reported
        outer: Transform = Pose(_vector(xyz), _vector(rpy)).transform()
        pose = pose_of(outer.then(Pose(_vector(own[0]), _vector(own[1])).transform()))
        return {"xyz": _listed(pose.xyz, entry), "rpy": _listed(pose.rpy, entry)}

    def _mirrored_pose(self, entry: Map) -> dict[str, Any]:
        """Return the changes of a pose: R' = S R S and p' = S p for a reflection S."""
        if self.mirror is None:
            return {}
        changes: dict[str, Any] = {}
        for key in ("xyz", "rpy"):
            values = entry.get(key)
            if values is not None and _is_vector(values):
                flipped = [(index == self.mirror) == (key == "xyz") for index in range(3)]
                changes[key] = _listed(
                    [_negative(v) if flip else v for v, flip in zip(values, flipped, strict=True)], values
                )
        return changes

    def _mirrored_axis(self, entry: Map) -> Any:
        """Return the axis of the mirrored joint; a turning axis changes sign, for a reflection turns turns around."""
        axis = entry.get("axis")
        if axis is None:
            axis = _listed((1, 0, 0), entry)
        if not _is_vector(axis):
            return axis
        slides = entry.get("type") == "prismatic"
        values = [_negative(v) if (i == self.mirror) == slides else v for i, v in enumerate(axis)]
        return _listed(values, axis)

    def _mirrored_inertial(self, inertial: Map) -> Map:
        changes = self._mirrored_pose(inertial)
        moments = inertial.get("inertia")
        if isinstance(moments, Map):
            across = "xyz"[self.mirror or 0]
            flipped = [
                key for key in ("ixy", "ixz", "iyz") if across in key[1:] and isinstance(moments.get(key), (int, float))
            ]
            changes["inertia"] = _with(moments, {key: _negative(moments[key]) for key in flipped})
        if isinstance(inertial.get("of"), Seq):
            changes["of"] = each(inertial["of"], "", self._mirrored_shape)
        return _with(inertial, changes)

    def _mirrored_shape(self, shape: Any) -> Any:
        if not isinstance(shape, Map):
            return shape
        changes = self._mirrored_pose(shape)
        box, mesh = shape.get("box"), shape.get("mesh")
        if isinstance(box, Map) and all(box.get(key) and _is_vector(box[key]) for key in ("min", "max")):
            low, high = list(box["min"]), list(box["max"])
            axis = self.mirror or 0
            low[axis], high[axis] = _negative(high[axis]), _negative(low[axis])
            changes["box"] = _with(box, {"min": _listed(low, box["min"]), "max": _listed(high, box["max"])})
        if isinstance(mesh, Map) and _is_vector(mesh.get("scale")):
            scale = list(mesh.get("scale") or (1, 1, 1))
            scale[self.mirror or 0] = _negative(scale[self.mirror or 0])
            changes["mesh"] = _with(mesh, {"scale": _listed(scale, mesh.get("scale", mesh))})
        return _with(shape, changes)


def _is_vector(value: Any, dimension: Dimension | None = None) -> bool:
    """Say whether a value is three finite numbers, of a dimension if one is given, or nothing."""
    if value is None:
        return True
    if not isinstance(value, list) or len(value) != 3:
        return False
    return all(is_number(v, dimension) and math.isfinite(v) for v in value)


def _negative(value: float) -> float:
    """Return a number with the other sign; a quantity stays one, zero stays as it is."""
    if not value:
        return value
    return Quantity(-value, value.dimension, value.text) if isinstance(value, Quantity) else -value


def _vector(value: Any) -> tuple[float, float, float]:
    x, y, z = value if value is not None else (0.0, 0.0, 0.0)
    return (float(x), float(y), float(z))


def _listed(values: Any, like: Any) -> Seq:
    """Return numbers as a sequence that stands where ``like`` stands."""
    made = Seq(like.span, like.via)
    spans = getattr(like, "value_spans", None)
    for index, value in enumerate(values):
        made.put(value, spans[index] if isinstance(spans, list) and index < len(spans) else like.span)
    return made

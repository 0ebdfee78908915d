"""Placing: what a part contains gets its prefix, is mirrored, and is attached to its frame.

A part refers to its own links and joints by their short names, and to the frame that it is attached to as ``mount``.
The schema says which values are names, are mirrored or are attached (``annotations``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rosorin_compile.model import Pose
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.tree import Instance, Kept, Map, Seq
from rosorin_compile.source.units import ANGLE, LENGTH
from rosorin_compile.source.xml.mujoco import with_names
from rosorin_compile.source.xml.references import renamed

from ..annotations import GIVES, INSIDE, MIRROR, WORLD, Node
from ..schema import holds_many, is_one_entry, sections
from ..symbols import MOUNT, Names, SymbolTable
from .mirroring import AXES, MIRRORED, is_vector, listed, side

Rename = Callable[[str], str]


class Use(NamedTuple):
    """How a fragment becomes part of a robot: its prefix, the frame it is attached to, with a pose, and a mirror.

    ``xyz`` and ``rpy`` are in metres and radians; ``mirror`` reflects at the plane across x, y or z of the mount.
    """

    prefix: str
    parent: str | None = None
    xyz: Any = None
    rpy: Any = None
    mirror: str | None = None


def placed(fragment: Map, use: Use, names: Names | None = None, elements: Rename | None = None) -> Map:
    """Return a fragment with prefixed names, mirrored and attached.

    ``names`` are those of the fragment, if they are known. ``elements`` renames in elements for the URDF; by default
    links and joints get their names there.
    """
    placer = _Placer(names or SymbolTable(fragment).names(), use, elements)
    made = fragment.copied()
    for section, value in fragment.items():
        node = sections().get(section)
        if value and node is not None and node.in_parts:
            made[section] = placer.value(node, _tagged(section, value, fragment.via))
    return made


def _tagged(section: str, value: Any, via: Instance | None) -> Any:
    """Return a section whose entries know the part that made them, even those that the part has as written."""

    def tag(entry: Any) -> Any:
        own = getattr(entry, "via", None)
        if via is None or (own is not None and own.made):
            return entry
        if isinstance(entry, str):
            return Kept(entry, via)
        if isinstance(entry, Seq):
            entry = map_items(entry, lambda item: item)
            entry.via = via
            return entry
        return entry.by(via) if isinstance(entry, Map) else entry

    if holds_many(section) and isinstance(value, Map):
        # Its tables and lists of entries, not its settings.
        entries = {key: map_items(item, tag) for key, item in value.items() if _has_entries(section, key, item)}
        return tag(value.like(entries))
    return tag(value) if is_one_entry(section) else map_items(value, tag) if isinstance(value, (Map, Seq)) else value


def _has_entries(section: str, key: str, value: Any) -> bool:
    node = sections()[section].at(key)
    return isinstance(value, Seq) or (isinstance(value, Map) and node is not None and node.keys is not None)


def map_items(section: Any, change: Callable[[Any], Any]) -> Any:
    """Return a mapping or a list with each value changed."""
    if isinstance(section, Map):
        return _table(section, lambda name: name, change)
    made = Seq(section.span, section.via)
    made.extend(map(change, section))
    made.value_spans.extend(section.value_spans)
    return made


def _table(table: Map, rename: Rename, change: Callable[[Any], Any]) -> Map:
    """Return a mapping with each key renamed, and each value changed."""
    made = Map(table.span, table.via)
    for name, value in table.items():
        made.put(rename(name), change(value), table.key_spans[name], table.value_spans[name])
    return made


def _renamed_text(text: Any, change: Rename) -> Any:
    """Return elements of XML after a change, which still know the part that made them."""
    made = change(text) if isinstance(text, str) else text
    if made == text:
        return text
    return Kept(made, text.via) if isinstance(text, Kept) else made


def _with(entry: Map, changes: dict[str, Any]) -> Map:
    """Return an entry with some values changed; a new key has the place of the entry."""
    if changes.keys() <= entry.keys():
        return entry.like(changes) if changes else entry
    made = entry.copied()
    for key, value in changes.items():
        if key in entry:
            made[key] = value
        elif value is not None:
            made.setdefault_at(key, value, getattr(value, "span", entry.span))
    return made


class _Placer:
    """Renames, mirrors and attaches the values of one part, as the schema says."""

    def __init__(self, names: Names, use: Use, elements: Rename | None) -> None:
        self.names, self.use, self.elements = names, use, elements
        self.mirror = None if use.mirror is None else AXES[use.mirror]
        self.active = {kind for kind, some in names.of.items() if some} | {"link", GIVES}
        self.active |= {INSIDE} if names.inside else set()
        self.active |= {MIRROR} if self.mirror is not None else set()

    def value(self, node: Node, value: Any) -> Any:
        """Return the value at a place of the schema."""
        if self.active.isdisjoint(node.of):
            return value
        if node.inside:
            return self._inside(node.inside, value)
        if isinstance(value, str):
            return self._text(node, value)
        if isinstance(value, Map):
            return self._mapping(node, value)
        if isinstance(value, Seq) and node.items is not None:
            items = node.items
            return map_items(value, lambda item: self.value(items, item))
        return value

    def _text(self, node: Node, name: str) -> str:
        if node.scope == WORLD:
            return self.rename(node.gives, name)
        if node.gives and not node.scope:
            return self.use.prefix + name
        return self.rename(node.names, name) if node.names and not node.scope else name

    def _key(self, node: Node, name: str) -> str:
        if "sides" in node.mirror:
            return side(name, self.mirror)
        return self._text(node.keys, name) if node.keys is not None else name

    def _mapping(self, node: Node, entry: Map) -> Map:
        changes: dict[str, Any] = {}
        if self.mirror is not None:
            for how in node.mirror:
                changes |= MIRRORED[how](entry, self.mirror) if how in MIRRORED else {}
        for key, value in entry.items():
            below = node.at(key)
            if below is not None and not self.active.isdisjoint(below.of):
                changes[key] = self.value(below, value)
                if below.attached and value == MOUNT and (self.use.xyz, self.use.rpy) != (None, None):
                    changes |= self._mounted(entry, changes, below.attached)
        changed = _with(entry, changes)
        if node.keys is None and "sides" not in node.mirror:
            return changed
        return _table(changed, lambda name: self._key(node, name), lambda value: value)

    def rename(self, kind: str, name: str) -> str:
        """Return the name outside of the part of something of a kind."""
        if name == MOUNT and kind in ("link", "site") and MOUNT not in self.names.of.get("link", ()):
            return name if self.use.parent is None else self.use.parent
        return self.use.prefix + name if self.names.gives(kind, name) else name

    def _mounted(self, entry: Map, changes: dict[str, Any], keys: Sequence[str]) -> dict[str, Any]:
        """Return the pose of an entry on the mount, and directions in it, seen from the parent of the use."""
        own = {key: changes.get(key, entry.get(key)) for key in ("xyz", "rpy", *keys)}
        xyz, rpy = self.use.xyz, self.use.rpy
        directions = [key for key in keys if key not in ("xyz", "rpy") and own[key] is not None]
        if own["xyz"] is None and own["rpy"] is None and not directions:
            return {key: value for key, value in (("xyz", xyz), ("rpy", rpy)) if key in keys}
        good = all(is_vector(value, LENGTH) for value in (xyz, own["xyz"]))
        good &= all(is_vector(value, ANGLE) for value in (rpy, own["rpy"]))
        if not good or not all(is_vector(own[key]) for key in directions):
            return {}  # validation reports what is wrong
        outer = Pose(_vector(xyz), _vector(rpy)).transform()
        pose = pose_of(outer.then(Pose(_vector(own["xyz"]), _vector(own["rpy"])).transform()))
        made = {"xyz": listed(pose.xyz, entry), "rpy": listed(pose.rpy, entry)}
        made |= {key: listed(outer.rotate(_vector(own[key])), own[key]) for key in directions}
        return {key: value for key, value in made.items() if key in keys}

    def _inside(self, how: str, value: Any) -> Any:
        """Return a value of another language in which names are renamed."""
        if how == "parameters":
            return self._parameters(value)
        if how == "urdf":
            rename = self._among(self.names.in_urdf.__contains__)
            return _renamed_text(value, self.elements or (lambda text: renamed(text, rename)))
        if how in ("mjcf", "mjcf_body"):
            names = self.names.in_mjcf
            rename = self._among(lambda name: name in names or self.names.makes(name))
            return _renamed_text(value, lambda text: with_names(text, how == "mjcf", rename))
        return value

    def _among(self, is_own: Callable[[str], bool]) -> Rename:
        """Return a function that renames names of the part, and the mount."""
        return lambda name: self.use.prefix + name if is_own(name) else self.rename("link", name)

    def _parameters(self, value: Any) -> Any:
        """Return parameters of a controller in which joints, frames, sensors and controllers are renamed."""
        rename = self._among(self.names.in_parameters.__contains__)
        if isinstance(value, str):
            name, slash, rest = value.partition("/")  # an interface: joint1/position
            return rename(name) + slash + rest
        if isinstance(value, Seq):
            return map_items(value, self._parameters)
        if isinstance(value, Map):
            return _table(value, lambda key: ".".join(map(rename, key.split("."))), self._parameters)
        return value


def _vector(value: Any) -> tuple[float, float, float]:
    x, y, z = value if value is not None else (0.0, 0.0, 0.0)
    return (float(x), float(y), float(z))

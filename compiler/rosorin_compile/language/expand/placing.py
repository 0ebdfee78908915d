"""Placing: what a part holds gets its prefix, is mirrored, and is attached to its frame.

A part speaks of its own links and joints by their short names, and of the frame that it is attached to as ``mount``.
What of a value is a name, turns in a mirror or sits on the mount is said by the schema (``annotations``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rosorin_compile.model import Pose, Transform
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.tree import Instance, Kept, Map, Seq
from rosorin_compile.source.units import ANGLE, LENGTH

from ..annotations import GIVES, INSIDE, MIRROR, WORLD, Node
from ..element_names import renamed, with_names
from ..schema import holds_many, is_one_entry, keys_of_xml, sections
from ..symbols import MOUNT, Names, SymbolTable
from .forms import KEPT
from .mirroring import AXES, MIRRORED, is_vector, listed, side

Rename = Callable[[str], str]


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
    axis = None if mirror is None else AXES[mirror]
    placer = _Placer(names or SymbolTable(fragment).names(), prefix, parent, (xyz, rpy), axis, kept, fragment.via)
    made = Map(fragment.span, fragment.via)
    for section, value in fragment.items():
        node = sections().get(section)
        changed = placer.section(section, node, value) if value and node is not None and node.in_parts else value
        made.put(section, changed, fragment.key_spans[section], fragment.value_spans[section])
    return made


def each(section: Any, change: Callable[[Any], Any]) -> Any:
    """Return a mapping or a list with each entry changed."""
    if isinstance(section, Map):
        return _table(section, lambda name: name, change)
    made = Seq(section.span, section.via)
    for entry, span in zip(section, section.value_spans, strict=True):
        made.put(change(entry), span)
    return made


def _table(table: Map, rename: Rename, change: Callable[[Any], Any]) -> Map:
    """Return a mapping with each key renamed, and each value changed."""
    made = Map(table.span, table.via)
    for name, value in table.items():
        made.put(rename(name), change(value), table.key_spans[name], table.value_spans[name])
    return made


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


def _with(entry: Map, changes: dict[str, Any]) -> Map:
    """Return an entry with some values changed; a new key has the place of the entry."""
    if changes.keys() <= entry.keys():
        return entry.like(changes) if changes else entry
    made = entry.copied()
    for key, value in changes.items():
        if key in entry:
            made[key] = value
        elif value is not None:
            span = getattr(value, "span", entry.span)
            made.put(key, value, span, span)
    return made


class _Placer:
    """Takes what stands at a place of a part, and returns it renamed, mirrored and attached, as the schema says."""

    def __init__(
        self,
        names: Names,
        prefix: str,
        parent: str | None,
        mount: tuple[Any, Any],
        mirror: int | None,
        kept: bool,
        via: Instance | None,
    ) -> None:
        self.names = names
        self.prefix, self.parent, self.mount = prefix, parent, mount
        self.mirror, self.kept, self.via = mirror, kept, via
        self.active = {kind for kind, some in names.of.items() if some} | {"link", GIVES}
        self.active |= {INSIDE} if names.inside else set()
        self.active |= {MIRROR} if mirror is not None else set()

    def section(self, section: str, node: Node, value: Any) -> Any:
        """Return a section of the part; its entries know the part that made them."""
        if holds_many(section):
            return _made_by(self._with_many(node, value), self.via, value)
        if is_one_entry(section):
            return _made_by(self.placed(node, value), self.via, value)
        if section in keys_of_xml():
            if section == KEPT and not self.kept:
                return value
            return each(self.placed(node, value), lambda text: _by(text, self.via))
        return self._entries(node, value, self._entry_made)

    def _entries(self, node: Node, value: Any, made: Callable[[Any, Any], Any]) -> Any:
        """Return entries by name, or a list of them, each of which knows the part that made it."""

        def entry(below: Node | None, one: Any) -> Any:
            return made(one if below is None else self.placed(below, one), one)

        if isinstance(value, Map):
            return _table(value, lambda name: self._key(node, name), lambda one: entry(node.others, one))
        return each(value, lambda one: entry(node.items, one)) if isinstance(value, Seq) else value

    def _with_many(self, node: Node, entry: Any) -> Any:
        """Return an entry that several parts add to: what each adds knows it."""
        if not isinstance(entry, Map):
            return entry
        changes = {}
        for key, value in entry.items():
            below = node.at(key)
            many = isinstance(value, Seq) or (isinstance(value, Map) and below is not None and below.keys is not None)
            if below is not None and many:
                changes[key] = self._entries(below, value, self._made)
        return _with(entry, changes)

    def _entry_made(self, entry: Any, before: Any) -> Any:
        return _made_by(entry, self.via, before)

    def _made(self, item: Any, before: Any) -> Any:
        """Return an item of what others are joined to: it knows the part that made it."""
        if isinstance(item, str):
            return Kept(item, self.via)
        if isinstance(item, Seq):
            made = each(item, lambda one: one)
            made.via = self.via
            return made
        return _made_by(item, self.via, before)

    def placed(self, node: Node, value: Any) -> Any:
        """Return what stands at a place of the schema."""
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
            return each(value, lambda one: self.placed(items, one))
        return value

    def _text(self, node: Node, name: str) -> str:
        """Return a text, which the schema may call a name."""
        if node.scope == WORLD:
            return self.rename(node.gives, name)
        if node.gives and not node.scope:
            return self.prefix + name
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
                changes[key] = self.placed(below, value)
                if below.attached and value == MOUNT and self.mount != (None, None):
                    changes |= self._mounted(entry, changes, below.attached)
        changed = _with(entry, changes)
        if node.keys is None and "sides" not in node.mirror:
            return changed
        return _table(changed, lambda name: self._key(node, name), lambda one: one)

    def rename(self, kind: str, name: str) -> str:
        """Return what something of a kind is called outside of the part."""
        if name == MOUNT and kind in ("link", "site") and MOUNT not in self.names.of.get("link", ()):
            return name if self.parent is None else self.parent
        return self.prefix + name if self.names.gives(kind, name) else name

    def _mounted(self, entry: Map, changes: dict[str, Any], keys: Sequence[str]) -> dict[str, Any]:
        """Return the pose of an entry on the mount, and directions in it, seen from the frame of the part's use."""
        own = {key: changes.get(key, entry.get(key)) for key in ("xyz", "rpy", *keys)}
        xyz, rpy = self.mount
        directions = [key for key in keys if key not in ("xyz", "rpy") and own[key] is not None]
        if own["xyz"] is None and own["rpy"] is None and not directions:
            return {key: value for key, value in (("xyz", xyz), ("rpy", rpy)) if key in keys}
        lengths, angles = (xyz, own["xyz"]), (rpy, own["rpy"])
        vectors = [*((v, LENGTH) for v in lengths), *((v, ANGLE) for v in angles)]
        if not all(is_vector(v, d) for v, d in vectors) or not all(is_vector(own[key]) for key in directions):
            return {}  # what is wrong is still there to be reported
        outer: Transform = Pose(_vector(xyz), _vector(rpy)).transform()
        pose = pose_of(outer.then(Pose(_vector(own["xyz"]), _vector(own["rpy"])).transform()))
        made = {"xyz": listed(pose.xyz, entry), "rpy": listed(pose.rpy, entry)}
        made |= {key: listed(outer.rotate(_vector(own[key])), own[key]) for key in directions}
        return {key: value for key, value in made.items() if key in keys}

    def _inside(self, how: str, value: Any) -> Any:
        """Return a value that holds names in a form of its own, with the new ones."""
        if how == "parameters":
            return self._parameters(value)
        if how == "urdf":
            names = self.names.in_urdf
            return (
                changed_text(value, lambda text: renamed(text, self._among(names.__contains__))) if self.kept else value
            )
        if how in ("mjcf", "mjcf_body"):
            names = self.names.in_mjcf

            def is_known(name: str) -> bool:
                return name in names or self.names.makes(name)

            return changed_text(value, lambda text: with_names(text, how == "mjcf", self._among(is_known)))
        return value

    def _among(self, ours: Callable[[str], bool]) -> Rename:
        """Return what renames the names that are those of the part, and the mount."""

        def rename(name: str) -> str:
            return self.prefix + name if ours(name) else self.rename("link", name)

        return rename

    def _parameters(self, value: Any) -> Any:
        """Return parameters of a controller in which joints, frames, sensors and controllers have the new names."""
        rename = self._among(self.names.in_parameters.__contains__)
        if isinstance(value, str):
            name, slash, rest = value.partition("/")  # an interface: joint1/position
            return rename(name) + slash + rest
        if isinstance(value, Seq):
            return each(value, self._parameters)
        if isinstance(value, Map):
            return _table(value, lambda key: ".".join(map(rename, key.split("."))), self._parameters)
        return value


def _vector(value: Any) -> tuple[float, float, float]:
    x, y, z = value if value is not None else (0.0, 0.0, 0.0)
    return (float(x), float(y), float(z))

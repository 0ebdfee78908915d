"""Place the contents of a part in a robot, and join sections of files and parts.

Names get a prefix, poses are mirrored, and entries on the frame ``mount`` are attached to the parent; annotations of
the schema mark these values. Under a reflection S, a rotation R becomes S R S, and a position p becomes S p.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple

from rosorin_compile.model import Pose
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.diagnostics import Related
from rosorin_compile.source.tree import Include, Instance, Map, Place, Seq, XmlText
from rosorin_compile.source.units import ANGLE, LENGTH, Dimension, Quantity

from ..annotations import ENTRIES, GIVES, INSIDE, ITEMS, MIRROR, WITHIN, WORLD, Node
from ..element_names import kind_of_name, rename_references, with_names
from ..schema import holds_many, is_one_entry, keys_of, merged_sections, sections
from ..suggestions import word_meant
from ..symbols import IN_MJCF, IN_PARAMETERS, IN_URDF, MOUNT, SymbolTable
from ..validate import validate
from .provenance import argument_behind
from .scope import Scope

Rename = Callable[[str], str]


AXES = {"x": 0, "y": 1, "z": 2}
# Words to swap in wheel names such as front_left if a part is mirrored along x, y or z.
_SIDES: tuple[dict[str, str], ...] = ({"front": "rear", "rear": "front"}, {"left": "right", "right": "left"}, {})


class Use(NamedTuple):
    """How to place a part in a robot: name prefix, parent frame (replaces ``mount``), pose in this frame, mirror axis.

    ``xyz`` is in metres, ``rpy`` in radians. ``mirror`` ("x", "y" or "z") is the coordinate of ``mount`` to negate.
    """

    prefix: str
    parent: str | None = None
    xyz: Any = None
    rpy: Any = None
    mirror: str | None = None


def place_fragment(fragment: Map, use: Use, names: SymbolTable | None = None, elements: Rename | None = None) -> Map:
    """Return the sections of a part with names, poses and parent frames changed as ``use`` specifies.

    ``names`` is the symbol table of the fragment, computed by default. ``elements`` renames the links and joints in a
    string of URDF elements; by default, it renames only links and joints that the fragment defines.
    """
    placer = _Placer(names or SymbolTable(fragment), use, elements)
    made = fragment.copy()
    tables = [fragment.get(section) for section in ("joints", "sensors") if placer.mirror is not None]
    entries = [entry for table in tables if isinstance(table, Map) for entry in table.values()]
    placer.carrying = [str(entry.get("parent")) for entry in entries if isinstance(entry, Map)]
    for section, node in sections().items():
        if fragment.get(section) and node.in_parts:
            made[section] = placer.value(node, _tagged(section, fragment[section], fragment.via))
    return made


def _tagged(section: str, value: Any, via: Instance | None) -> Any:
    def tag(entry: Any) -> Any:
        own = getattr(entry, "via", None)
        if via is None or (own is not None and own.made):
            return entry
        if isinstance(entry, str):
            return XmlText(entry, via)
        if isinstance(entry, Seq):
            entry = map_items(entry, lambda item: item)
            entry.via = via
            return entry
        return entry.made_by(via) if isinstance(entry, Map) else entry

    if holds_many(section) and isinstance(value, Map):
        nodes = {key: sections()[section].value_of(key) for key, item in value.items() if isinstance(item, Map)}
        tables = [key for key, node in nodes.items() if node is not None and node.keys is not None]
        # Several parts may add to the tables and lists of the section: set ``via`` of their entries as well.
        entries = {key: map_items(item, tag) for key, item in value.items() if key in tables or isinstance(item, Seq)}
        return tag(value.with_changes(entries))
    return tag(value) if is_one_entry(section) else map_items(value, tag) if isinstance(value, (Map, Seq)) else value


def map_items(section: Any, change: Callable[[Any], Any]) -> Any:
    """Return a copy of a mapping or list with ``change`` applied to each value."""
    if isinstance(section, Map):
        return section.with_changes({name: change(value) for name, value in section.items()})
    made = Seq(section.span, section.via)
    made.extend(map(change, section))
    made.value_spans.extend(section.value_spans)
    return made


def map_table(table: Map, rename: Rename, change: Callable[[Any], Any] = lambda value: value) -> Map:
    """Return a copy of a mapping with each key renamed and ``change`` applied to each value."""
    made = Map(table.span, table.via)
    for name, value in table.items():
        made.put(rename(name), change(value), table.key_spans[name], table.value_spans[name])
    return made


def _renamed_text(text: Any, change: Rename) -> Any:
    made = change(text) if isinstance(text, str) else text
    if made == text:
        return text
    return XmlText(made, text.via) if isinstance(text, XmlText) else made


def _with(entry: Map, changes: dict[str, Any]) -> Map:
    if changes.keys() <= entry.keys():
        return entry.with_changes(changes) if changes else entry
    made = entry.copy()
    made.update({key: value for key, value in changes.items() if key in entry})
    for key in (key for key, value in changes.items() if value is not None):
        made.setdefault_at(key, changes[key], getattr(changes[key], "span", entry.span))
    return made


class _Placer:
    def __init__(self, names: SymbolTable, use: Use, elements: Rename | None) -> None:
        self.names, self.use, self.elements = names, use, elements
        self.mirror = None if use.mirror is None else AXES[use.mirror]
        self.carrying = list[str]()  # frames that carry others; a list, because an invalid frame may be unhashable
        self.active = {kind for kind, some in names.contents.names.items() if some} | {"link", GIVES}
        self.active |= {INSIDE} if names.contents.may_hide_names else set()
        self.active |= {MIRROR} if self.mirror is not None else set()

    def value(self, node: Node, value: Any) -> Any:
        if self.active.isdisjoint(node.of):
            return value
        if node.inside:
            return self._inside(node.inside, value)
        if isinstance(value, str):
            return self._text(node, value)
        if isinstance(value, Map):
            return self._mapping(node, value)
        if isinstance(value, Seq) and node.items is not None:
            return map_items(value, partial(self.value, node.items))
        return value

    def _text(self, node: Node, name: str) -> str:
        if node.scope == WORLD:
            return self.rename(node.gives, name)
        if node.gives and not node.scope:
            return self.use.prefix + name
        return self.rename(node.names, name) if node.names and not node.scope else name

    def _mapping(self, node: Node, entry: Map) -> Map:
        changes: dict[str, Any] = {}
        if self.mirror is not None:
            for how in node.mirror if entry.get("frame") not in self.carrying else ("pose",):
                changes |= MIRRORED[how](entry, self.mirror) if how in MIRRORED else {}
        for key, value in entry.items():
            below = node.value_of(key)
            if below is not None and not self.active.isdisjoint(below.of):
                changes[key] = self.value(below, value)
                if below.attached and value == MOUNT and (self.use.xyz, self.use.rpy) != (None, None):
                    changes |= self._mounted(entry, changes, below.attached)
        changed = _with(entry, changes)
        if "sides" in node.mirror:
            return map_table(changed, lambda name: side(name, self.mirror))
        keys = node.keys
        return changed if keys is None else map_table(changed, lambda name: self._text(keys, name))

    def rename(self, kind: str, name: str) -> str:
        if name == MOUNT and kind in ("link", "site") and MOUNT not in self.names.contents.names.get("link", ()):
            return name if self.use.parent is None else self.use.parent
        return self.use.prefix + name if self.names.defines(kind, name) else name

    def _mounted(self, entry: Map, changes: dict[str, Any], keys: Sequence[str]) -> dict[str, Any]:
        own = {key: changes.get(key, entry.get(key)) for key in ("xyz", "rpy", *keys)}
        xyz, rpy = self.use.xyz, self.use.rpy
        directions = [key for key in keys if key not in ("xyz", "rpy") and own[key] is not None]
        if own["xyz"] is None and own["rpy"] is None and not directions:
            return {key: value for key, value in (("xyz", xyz), ("rpy", rpy)) if key in keys}
        good = all(is_vector(value, LENGTH) for value in (xyz, own["xyz"]))
        good &= all(is_vector(value, ANGLE) for value in (rpy, own["rpy"]))
        if not good or not all(is_vector(own[key]) for key in directions):
            return {}  # validation reports the error
        outer = Pose(_vector(xyz), _vector(rpy)).transform()
        pose = pose_of(outer.then(Pose(_vector(own["xyz"]), _vector(own["rpy"])).transform()))
        made = {"xyz": sequence_like(pose.xyz, entry), "rpy": sequence_like(pose.rpy, entry)}
        made |= {key: sequence_like(outer.rotate(_vector(own[key])), own[key]) for key in directions}
        return {key: value for key, value in made.items() if key in keys}

    def _inside(self, how: str, value: Any) -> Any:
        if how == "parameters":
            return self._parameters(value)
        if how == "urdf":
            rename = self._among(self.names.names_of_kinds(IN_URDF).__contains__)
            return _renamed_text(value, self.elements or (lambda text: rename_references(text, rename)))
        if how in ("mjcf", "mjcf_body", "attributes"):
            names = self.names.names_of_kinds(IN_MJCF)
            rename = self._among(lambda name: name in names or self.names.makes(name))
            if how == "attributes" and isinstance(value, Map):
                named = [key for key, name in value.items() if isinstance(name, str) and kind_of_name(key, value)]
                return value.with_changes({key: rename(value[key]) for key in named})
            return _renamed_text(value, lambda text: with_names(text, how == "mjcf", rename))
        return value

    def _among(self, is_own: Callable[[str], bool]) -> Rename:
        return lambda name: self.use.prefix + name if is_own(name) else self.rename("link", name)

    def _parameters(self, value: Any) -> Any:
        rename = self._among(self.names.names_of_kinds(IN_PARAMETERS).__contains__)
        if isinstance(value, str):
            name, slash, rest = value.partition("/")  # a ros2_control interface, such as joint1/position
            return rename(name) + slash + rest
        if isinstance(value, Seq):
            return map_items(value, self._parameters)
        if isinstance(value, Map):
            return map_table(value, lambda key: ".".join(map(rename, key.split("."))), self._parameters)
        return value


def _vector(value: Any) -> tuple[float, float, float]:
    x, y, z = value if value is not None else (0.0, 0.0, 0.0)
    return (float(x), float(y), float(z))


# Each function mirrors a mapping along an axis (0, 1, 2 for x, y, z) and returns the keys and values that change.


def _vectors(polar: tuple[str, ...], axial: tuple[str, ...] = ()) -> Callable[[Map, int], dict[str, Any]]:
    def changes(entry: Map, axis: int) -> dict[str, Any]:
        found = {key: entry[key] for key in (*polar, *axial) if entry.get(key) is not None and is_vector(entry[key])}
        return {key: sequence_like(_reflected(values, axis, key in axial), values) for key, values in found.items()}

    return changes


def _axis(joint: Map, axis: int) -> dict[str, Any]:
    values = joint.get("axis")
    kind = joint.get("type", "revolute" if values is not None else "")  # an entry without type and axis is not a joint
    if kind not in ("revolute", "continuous", "prismatic", "planar") or not is_vector(values):
        return {}
    values = sequence_like((1, 0, 0), joint) if values is None else values
    return {"axis": sequence_like(_reflected(values, axis, kind != "prismatic"), values)}


def _grid(grid: Map, axis: int) -> dict[str, Any]:
    heights, origin, cell = grid.get("heights"), grid.get("origin"), grid.get("cell")
    if not isinstance(heights, Seq) or not heights or not all(isinstance(row, Seq) for row in heights):
        return {}
    if not isinstance(origin, Seq) or len(origin) != 2 or not all(map(is_number, (*origin, cell))):
        return {}
    if axis == AXES["z"]:
        negative = [sequence_like([_negative(v) if is_number(v) else v for v in row], row) for row in heights]
        return {"heights": sequence_like(negative, heights)}
    count = len(heights) if axis == AXES["x"] else len(heights[0])
    high = float(origin[axis]) + count * float(cell or 0)
    moved = [-high if i == axis else v for i, v in enumerate(origin)]
    changes: dict[str, Any] = {"origin": sequence_like(moved, origin)}
    for key in ("heights", "bottom"):
        rows = grid.get(key)
        if isinstance(rows, Seq) and all(isinstance(row, Seq) for row in rows):
            lines = rows[::-1] if axis == AXES["x"] else [sequence_like(row[::-1], row) for row in rows]
            changes[key] = sequence_like(lines, rows)
    return changes


def _inertia(moments: Map, axis: int) -> dict[str, Any]:
    keys = [key for key in ("ixy", "ixz", "iyz") if "xyz"[axis] in key[1:]]
    return {key: _negative(moments[key]) for key in keys if is_number(moments.get(key))}


def _bounds(box: Map, axis: int) -> dict[str, Any]:
    if not all(box.get(key) and is_vector(box[key]) for key in ("min", "max")):
        return {}
    low, high = list(box["min"]), list(box["max"])
    low[axis], high[axis] = _negative(high[axis]), _negative(low[axis])
    return {"min": sequence_like(low, box["min"]), "max": sequence_like(high, box["max"])}


def _scale(mesh: Map, axis: int) -> dict[str, Any]:
    return _vectors(("scale",))(_with(mesh, {"scale": mesh.get("scale") or sequence_like((1, 1, 1), mesh)}), axis)


def _twist(key: str, axial: int) -> Callable[[Map, int], dict[str, Any]]:
    def changes(entry: Map, axis: int) -> dict[str, Any]:
        values = entry.get(key)
        if not isinstance(values, list) or not all(map(is_number, values)) or (axial < 0 and len(values) not in (3, 6)):
            return {}
        mirrored = [*_reflected(values[:axial], axis, False), *_reflected(values[axial:], axis, True)]
        return {key: sequence_like(mirrored, values)}

    return changes


def _device(plane: int, within: int | None = None) -> Callable[[Map, int], dict[str, Any]]:
    """Mirror the pose of a device that is symmetric to the plane of its own axis ``plane``, such as a camera.

    The device itself cannot be mirrored: S R S is followed by S P, where P is the reflection across ``plane``.
    ``within`` is the plane of the device that the pose is relative to.
    """

    def changes(entry: Map, axis: int) -> dict[str, Any]:
        axis = axis if within is None else within
        made = _vectors(("xyz",), ("rpy",))(entry, axis)
        is_placed = "rpy" in made if within is not None else "frame" not in entry or "parent" in entry
        if axis != plane and is_placed and is_vector(entry.get("rpy"), ANGLE):
            turn = Pose((0, 0, 0), _vector([math.pi * (i not in (axis, plane)) for i in range(3)]))
            pose = pose_of(Pose((0, 0, 0), _vector(made.get("rpy"))).transform().then(turn.transform()))
            made["rpy"] = sequence_like(pose.rpy, entry.get("rpy", entry))
        return made

    return changes


# Mirror functions by value of the annotation ``x-mirror`` (see ``annotations.MIRRORED_KEYS``).
MIRRORED: dict[str, Callable[[Map, int], dict[str, Any]]] = {"pose": _vectors(("xyz",), ("rpy",)), "axis": _axis}
MIRRORED |= {"grid": _grid, "inertia": _inertia, "bounds": _bounds, "scale": _scale, "gear": _twist("gear", -3)}
MIRRORED |= {"surfacevel": _twist("surfacevel", 3)}
MIRRORED |= {key: _vectors((key,)) for key in ("direction", "dir", "at")}
# A camera of MJCF looks along -z, with x to the right; a sensor looks along x, with z up (REP 103).
MIRRORED |= {"camera": _device(0), "sensor": _device(1), "optical": _device(0, within=1)}


def side(role: str, axis: int | None) -> str:
    """Mirror a wheel name along an axis (0, 1, 2 for x, y, z): for y, ``front_left`` becomes ``front_right``."""
    swapped = _SIDES[axis] if axis is not None else {}
    return "_".join(swapped.get(word, word) for word in role.split("_"))


def is_number(value: Any, dimension: Dimension | None = None) -> bool:
    """Return True for a number that has no unit or a unit of ``dimension``; None allows any unit."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return dimension is None or not isinstance(value, Quantity) or value.dimension == dimension


def is_vector(value: Any, dimension: Dimension | None = None) -> bool:
    """Return True for a list of three finite numbers that pass ``is_number``, and for None."""
    if not isinstance(value, list) or len(value) != 3:
        return value is None
    return all(is_number(v, dimension) and math.isfinite(v) for v in value)


def sequence_like(values: Iterable[Any], like: Any) -> Seq:
    """Return a Seq of values with the source positions of the items of ``like`` (of ``like`` itself if a mapping)."""
    made, spans = Seq(like.span, like.via), getattr(like, "value_spans", None)
    for index, value in enumerate(values):
        made.put(value, spans[index] if isinstance(spans, list) and index < len(spans) else like.span)
    return made


def _reflected(values: Iterable[Any], axis: int, axial: bool) -> list[Any]:
    return [_negative(v) if (i == axis) != axial else v for i, v in enumerate(values)]


def _negative(value: float) -> float:
    if value and isinstance(value, Quantity):
        return Quantity(-value, value.dimension, value.text)
    return -value if value else value  # avoid -0.0


OF_PARTS = ("parts", "sensor_types", "use")  # sections that exist only before expansion


def join(tree: Map, more: Map, scope: Scope, parts: bool = False) -> bool:
    """Add the sections of ``more`` to ``tree``, and report conflicts; return True if there are none.

    ``parts`` is True if ``more`` is from a part; its entries record in ``via`` the ``use`` entry that created them.
    """
    good, joined = True, (*merged_sections(ENTRIES, ITEMS, WITHIN), *OF_PARTS)
    for section, value in more.items():
        have, is_list = tree.get(section), section in merged_sections(ITEMS)
        for key in value if parts and holds_many(section) and isinstance(value, Map) else ():
            if key not in keys_of(section):
                place, message = Place(value.key_spans[key], more.via or value.via), f'"{section}" has no key "{key}"'
                help, origin = partial(word_meant, key, keys_of(section)), argument_behind(scope.expansion.root, place)
                scope.report_origin("unknown-key", message, place, help, (), origin)
                good = False
        if have is None:
            if value is not None or not parts:
                tree.put(section, copy(value), more.key_spans[section], more.value_spans[section])
        elif value is not None and section not in joined:
            message = f'"{section}" is defined twice'
            good = _report("duplicate-key", message, "remove one definition", section, tree, more, scope)
            for fragment in (tree, more) if scope.expansion.parts else ():
                alone = Map(fragment.span, fragment.via)
                alone.put("robot", "robot", fragment.span, fragment.span)
                alone.put_from(fragment, section)
                scope.expansion.diagnostics += validate(alone, {})
            continue
        elif is_list and isinstance(have, Seq) and isinstance(value, Seq):
            _extend(have, value)
        elif isinstance(have, Map) and isinstance(value, Map):
            if holds_many(section):
                good &= _join_within(section, have, value, scope)
            else:  # accept equal materials, because each include of a xacro macro defines the materials of its file
                good &= _join_entries(section, have, value, scope, equal=section == "materials")
        elif value is not None and isinstance(have, Seq if is_list else Map):
            message = f'"{section}" must be {"a list" if is_list else "a mapping"} in every file'
            good = _report("wrong-type", message, "use the same type in both files", section, tree, more, scope)
            continue
        result = tree.get(section)
        # Several parts may add entries to a section, so the section itself must not record one of them as its origin.
        if parts and isinstance(result, (Map, Seq)) and (have is not None or not is_one_entry(section)):
            result.via = result.via if isinstance(result.via, Include) else tree.via
    return good


def _report(rule: str, message: str, help: str, name: str, first: Map, second: Map, scope: Scope) -> bool:
    place = Place(second.key_spans[name], getattr(second[name], "via", None) or second.via)
    by = getattr(first[name], "via", None)
    earlier = Place(first.key_spans[name], by if rule == "duplicate-key" else None)
    related = [Related("first defined here", earlier.span), *earlier.stack()]
    if earlier.span == place.span:
        what, where = ("file", "include") if isinstance(place.via, Include) else ("part", "use")
        message, related = f"{message}, because the {what} that defines it is used twice", related[1:]
        own = ', or give each its own "prefix"' if rule == "duplicate-name" and what == "part" else ""
        is_loop = own and by and place.via and by.span == place.via.span
        help = 'use the loop variable in "prefix"' if is_loop else f'remove one of the entries of "{where}"{own}'
    elif rule == "duplicate-name" and any(via and via.made for via in (by, place.via)):
        help += ', or give the part another "prefix"'
    scope.report_origin(rule, message, place, help, related, argument_behind(scope.expansion.root, place))
    return False


def _extend(have: Seq, more: Seq) -> None:
    have.extend(more)
    have.value_spans.extend(more.value_spans)


def _join_entries(section: str, have: Map, more: Map, scope: Scope, equal: bool = False) -> bool:
    good = True
    for name, entry in more.items():
        if name not in have:
            have.put(name, entry, more.key_spans[name], more.value_spans[name])
        elif not (equal and have[name] == entry and have.value_spans[name] == more.value_spans[name]):
            message = f'{section.rstrip("s")} "{name}" is defined twice'
            help = "rename or remove one of them"
            good = _report("duplicate-name", message, help, name, have, more, scope)
    return good


def _join_within(section: str, have: Map, more: Map, scope: Scope) -> bool:
    good, others = True, Map(more.span, more.via)
    for key, value in more.items():
        if (mine := have.get(key)) is None:
            have.put(key, copy(value), more.key_spans[key], more.value_spans[key])
        elif key not in keys_of(section):
            continue  # validation reports the unknown key
        elif isinstance(mine, Seq) and isinstance(value, Seq):
            have[key] = joined = copy(mine)
            _extend(joined, value)
        elif _is_table_of_entries(mine) and _is_table_of_entries(value):
            have[key] = joined = copy(mine)
            good &= _join_entries(key, joined, value, scope, equal=True)
        else:
            others.put(key, value, more.key_spans[key], more.value_spans[key])
    return _join_entries(section, have, others, scope, equal=True) and good


def _is_table_of_entries(value: Any) -> bool:
    return isinstance(value, Map) and all(isinstance(item, (Map, Seq)) for item in value.values())


def copy(value: Any) -> Any:
    """Return a shallow copy of a mapping or list; return any other value unchanged."""
    if isinstance(value, Map):
        return value.copy()
    return map_items(value, lambda item: item) if isinstance(value, Seq) else value


def with_source(tree: Map, owner: Map) -> Map:
    """Copy the key ``source`` of a ``use`` entry to all entries in ``tree`` that lack it."""
    maps = [(key, part) for key, part in tree.items() if isinstance(part, Map) and not holds_many(key)]
    sourced = {key: (_sourced if is_one_entry(key) else with_sources)(part, owner) for key, part in maps}
    return tree.with_changes(sourced)


def with_sources(section: Map, owner: Map) -> Map:
    """Copy the key ``source`` of a file or ``use`` entry to all entries of a section that lack it."""
    sourced = {name: _sourced(entry, owner) for name, entry in section.items() if isinstance(entry, Map)}
    return section.with_changes(sourced)


def _sourced(entry: Map, owner: Map) -> Map:
    made = entry.copy()
    if "source" not in entry:
        made.put("source", owner["source"], owner.key_spans["source"], owner.value_spans["source"])
    return made

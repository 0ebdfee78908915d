"""Nodes: links with the joints that carry them, as flat values that can be compared between instances.

The values of a node are a mapping from the path of each scalar to a tuple with its value in each instance: one for the
imported robot, several inside a part. A node precedes all nodes that hang on it, so that a subtree is a slice.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import Quantity

Values = dict[Path, tuple[Any, ...]]

# Values of a joint that name a joint or an actuator.
REFERENCES: tuple[Path, ...] = (("joint", "mimic", "joint"), ("joint", "mimic", "name"), ("joint", "actuator", "name"))
MARKS = ("sites", "cameras", "lights")  # entries of a link by name; the names differ between instances
_WITH_AXIS = ("revolute", "continuous", "prismatic", "planar")
_PRODUCTS = ("ixy", "ixz", "iyz")


@dataclass
class Node:
    """A link and the joint that carries it; the joint of a root has no name.

    ``entries`` has the values of the first instance below "link" and "joint". ``up`` is the index of the node that
    carries it, ``carrier`` that link's name. ``origins`` are the names of link and joint in each instance in the
    source, ``rank`` their positions there. ``terms`` are the expressions that replace values in a part.
    """

    link: str
    joint: str
    carrier: str
    up: int
    rank: tuple[int, int]
    entries: Map
    values: Values
    origins: list[tuple[str, str]]
    size: int = 1
    terms: dict[Path, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The type of the joint; empty for a root."""
        kind: str = self.values.get(("joint", "type"), ("",))[0]
        return kind

    @property
    def names(self) -> list[str]:
        """The names that the node defines."""
        marks = [name for key in MARKS for name in self.entries["link"].get(key) or ()]
        references = [self.values[path][0] for path in REFERENCES[1:] if path in self.values]
        return [self.link, self.joint, *marks, *references]

    @property
    def signature(self) -> Any:
        """What nodes have in common that can be instances of one part: paths, kinds of values, and types."""
        kinds = {bool: "boolean", str: "text"}
        return frozenset(
            (
                path,
                values[0]
                if path[-1] in ("type", "kind")
                else next((n for t, n in kinds.items() if isinstance(values[0], t)), ""),
            )
            for path, values in self.values.items()
        )

    @property
    def fits_in_part(self) -> bool:
        """Whether the language has words for this node in a part."""
        held = [self.entries["joint"], link := self.entries["link"]]
        held += [shape for key in ("visual", "collision") for shape in link.get(key) or ()]
        held += [mark for key in MARKS for mark in (link.get(key) or {}).values()]
        return not any(not _unfit_keys().isdisjoint(entry) for entry in held)


def nodes_of(tree: Map) -> list[Node]:
    """Return the nodes of a robot, each before all that hang on it; none if it is not a forest."""
    links, joints = tree.get("links") or {}, tree.get("joints") or {}
    below: dict[str, list[str]] = {}
    for name, joint in joints.items():
        below.setdefault(joint.get("parent"), []).append(name)
    carried = {joint.get("child") for joint in joints.values()}
    if len(carried) != len(joints) or not all(isinstance(link, Map) for link in links.values()):
        return []
    link_rank, joint_rank = ({name: rank for rank, name in enumerate(some)} for some in (links, joints))
    nodes: list[Node] = []
    waiting = [(root, "", -1) for root in reversed([name for name in links if name not in carried])]
    while waiting:
        link, joint, up = waiting.pop()
        entries = Map(tree.span)
        entries.put("link", _with_defaults(deep_copy(links[link])), tree.span, tree.span)
        moves = deep_copy(joints[joint]) if joint else Map(tree.span)
        for key in ("parent", "child"):
            moves.pop(key, None)
        if joint:
            _put_zeros(moves)
            if moves["type"] in _WITH_AXIS and "axis" not in moves:
                _put_numbers(moves, "axis", (1.0, 0.0, 0.0))
        entries.put("joint", moves, tree.span, tree.span)
        values = {path: (value,) for path, value in flattened(entries)}
        rank = link_rank[link], joint_rank.get(joint, -1)
        carrier = nodes[up].link if joint else ""
        nodes.append(Node(link, joint, carrier, up, rank, entries, values, [(link, joint)]))
        waiting += [(joints[name]["child"], name, len(nodes) - 1) for name in reversed(below.get(link, ()))]
    add_sizes(nodes)
    return nodes if len(nodes) == len(links) else []


def add_sizes(nodes: list[Node]) -> None:
    """Set the number of nodes in each subtree."""
    for node in reversed(nodes):
        if node.up >= 0:
            nodes[node.up].size += node.size


def deep_copy(value: Any) -> Any:
    """Return a copy of a tree, with the same spans."""
    if isinstance(value, Map):
        copy = Map(value.span, value.via)
        for key, item in value.items():
            copy.put(key, deep_copy(item), value.key_spans[key], value.value_spans[key])
        return copy
    if isinstance(value, Seq):
        items = Seq(value.span, value.via)
        for item, span in zip(value, value.value_spans, strict=True):
            items.put(deep_copy(item), span)
        return items
    return value


def _put_numbers(entry: Map, key: str, values: tuple[float, ...]) -> None:
    numbers = Seq(entry.span)
    for value in values:
        numbers.put(value, entry.span)
    entry.put(key, numbers, entry.span, entry.span)


def _put_zeros(entry: Map) -> None:
    for key in ("xyz", "rpy"):
        if entry.get(key) is None:
            _put_numbers(entry, key, (0.0, 0.0, 0.0))


def _with_defaults(link: Map) -> Map:
    """Write out defaults of a link that is compared: poses, scales, products of inertia."""
    for shape in (*(link.get("visual") or ()), *(link.get("collision") or ())):
        _put_zeros(shape)
        if isinstance(shape.get("mesh"), Map) and "scale" not in shape["mesh"]:
            _put_numbers(shape["mesh"], "scale", (1.0, 1.0, 1.0))
    inertial = link.get("inertial")
    if isinstance(inertial, Map):
        _put_zeros(inertial)
        for key in _PRODUCTS if isinstance(inertial.get("inertia"), Map) else ():
            if key not in inertial["inertia"]:
                inertial["inertia"].put(key, 0.0, inertial.span, inertial.span)
    return link


def flattened(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield the path and value of each scalar."""
    if isinstance(value, (Mapping, list)) and value:
        for step, _, item in steps(value, path):
            yield from flattened(item, (*path, step))
    else:
        yield path, value


def steps(value: Any, path: Path) -> Iterator[tuple[Any, Any, Any]]:
    """Yield the step in a path, the key and the value of each item; marks have a number instead of their name."""
    for number, (key, item) in enumerate(value.items() if isinstance(value, Mapping) else enumerate(value)):
        yield number if len(path) == 2 and path[-1] in MARKS else key, key, item


@cache
def _unfit_keys() -> frozenset[str]:
    """Return the keys of links, joints, shapes and marks that a part cannot have: XML, and names of the robot."""
    link: Path = ("links", "*")
    paths = [
        link,
        ("joints", "*"),
        (*link, "visual", 0),
        (*link, "collision", 0),
        *((*link, key, "*") for key in MARKS),
    ]
    keys = [item for path in paths for item in fragment_at(path)["properties"].items()]
    raw = {key for key, entry in keys if "x-names-in" in entry.get("items", {})}
    marked = [item for key in MARKS for item in fragment_at((*link, key, "*"))["properties"].items()]
    return frozenset({"publisher", *raw, *(key for key, entry in marked if entry.get("x-names") == "link")})


def is_number(value: Any) -> bool:
    """Return True for an int or float, and False for a boolean."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def negative(value: float) -> float:
    """Return the number with the other sign; a quantity keeps its unit, and zero its sign."""
    if isinstance(value, Quantity) and value.text and value:
        return Quantity.parse(value.text[1:] if value.text.startswith("-") else f"-{value.text}") or -value
    return -value if value else value


def mirrored(node: Node, mirror: str, is_root: bool) -> Values:
    """Return the values of a node as ``mirror`` of the language reflects them.

    The pose of a root is that of the use, which is not reflected.
    """
    axis = "xyz".index(mirror)
    values = dict(node.values)
    for path, numbers in node.values.items():
        key, index = (path[-2], path[-1]) if len(path) > 1 else ("", "")
        if is_root and path[:2] in (("joint", "xyz"), ("joint", "rpy")):
            continue
        if key in ("min", "max") and index == axis and path[-3] == "box":
            other = (*path[:-2], "max" if key == "min" else "min", axis)
            values[other] = tuple(map(negative, numbers))
        elif (
            (key == "xyz" and index == axis)
            or (key == "rpy" and index != axis)
            or (key == "scale" and index == axis)
            or (index in _PRODUCTS and mirror in str(index)[1:])
            or (
                path[:2] == ("joint", "axis")
                and (index == axis) == (node.kind == "prismatic")
                and node.kind in _WITH_AXIS
            )
        ):
            values[path] = tuple(map(negative, numbers))
    return values


def table(span: Span, entries: Mapping[str, Any]) -> Map:
    """Return a mapping of the tree."""
    made = Map(span)
    for key, value in entries.items():
        made.put(key, value, span, span)
    return made

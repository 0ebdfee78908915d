"""Links and the joints that carry them, as nodes with flat values that can be compared.

The values of a node map the path of each scalar below "link" and "joint" to the scalar. A node precedes all nodes that
hang on it, so that a subtree is a slice.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rosorin_compile.source.tree import Path
from rosorin_compile.source.units import Quantity

from ..layout import Expression

Values = dict[Path, Any]

MOUNT = "mount"  # in a part: the link that a use hangs on
# Values of a joint that name a joint or an actuator.
REFERENCES: tuple[Path, ...] = (("joint", "mimic", "joint"), ("joint", "mimic", "name"), ("joint", "actuator", "name"))
_MAX_NODES = 200  # links of one part
# XML, names of the robot, and entries by name whose names differ between instances
_UNFIT = frozenset(("publisher", "target", "urdf_elements", "mjcf_elements", "sites", "cameras", "lights"))
_WITH_AXIS = ("revolute", "continuous", "prismatic", "planar")
_PRODUCTS = ("ixy", "ixz", "iyz")


@dataclass
class Node:
    """A link and the joint that carries it; a root has no joint.

    ``up`` is the index of the node that carries it, or -1. ``rank`` are the positions of link and joint in the source.
    """

    link: str
    joint: str
    carrier: str
    up: int
    rank: tuple[int, int]
    entries: dict[str, Any]
    values: Values
    size: int = 1

    @property
    def kind(self) -> str:
        """The type of the joint; empty for a root."""
        kind: str = self.values.get(("joint", "type"), "")
        return kind

    @property
    def names(self) -> list[str]:
        """The names that the node defines."""
        return [self.link, self.joint, *(self.values[path] for path in REFERENCES[1:] if path in self.values)]


def nodes_of(body: Mapping[str, Any]) -> list[Node]:
    """Return the nodes of a robot or a part, each before its descendants, or an empty list if it is not a forest."""
    links, joints = body.get("links") or {}, body.get("joints") or {}
    below: dict[str, list[str]] = defaultdict(list)
    for name, joint in joints.items():
        below[joint.get("parent")].append(name)
    carried = {joint.get("child") for joint in joints.values()}
    if len(carried) != len(joints) or not all(isinstance(link, Mapping) for link in links.values()):
        return []
    link_rank, joint_rank = ({name: rank for rank, name in enumerate(some)} for some in (links, joints))
    nodes: list[Node] = []
    waiting = [(joints[name]["child"], name, -1) for name in below[MOUNT] if MOUNT not in links]
    waiting += [(root, "", -1) for root in reversed([name for name in links if name not in carried])]
    while waiting:
        link, joint, up = waiting.pop()
        moves = {key: one for key, one in joints.get(joint, {}).items() if key not in ("parent", "child")}
        entries = deep_copy({"link": links[link], "joint": moves})
        # What instances may leave out: the pose and the axis of a joint, and the scales of meshes.
        defaults = {"xyz": (0.0, 0.0, 0.0), "rpy": (0.0, 0.0, 0.0)} if moves else {}
        defaults |= {"axis": (1.0, 0.0, 0.0)} if moves.get("type") in _WITH_AXIS else {}
        for key, numbers in defaults.items():
            entries["joint"].setdefault(key, list(numbers))
        for shape in (one for section in ("visual", "collision") for one in entries["link"].get(section) or ()):
            if isinstance(shape.get("mesh"), Mapping):
                shape["mesh"].setdefault("scale", [1.0, 1.0, 1.0])
        rank = link_rank[link], joint_rank.get(joint, -1)
        carrier = nodes[up].link if up >= 0 else MOUNT
        nodes.append(Node(link, joint, carrier, up, rank, entries, dict(_scalars(entries))))
        waiting += [(joints[name]["child"], name, len(nodes) - 1) for name in reversed(below[link])]
    for node in reversed(nodes):
        if node.up >= 0:
            nodes[node.up].size += node.size
    return nodes if len(nodes) == len(links) else []


def equal_shapes(nodes: list[Node]) -> list[list[int]]:
    """Return the first nodes of subtrees that can be instances of one part, grouped; the largest subtrees first."""
    numbers: dict[Any, int] = {}
    below: list[list[int]] = [[] for _ in nodes]
    fits = [
        node.up >= 0 and not any(isinstance(one, Expression) or _UNFIT & {*path} for path, one in node.values.items())
        for node in nodes
    ]
    groups: dict[int, list[int]] = defaultdict(list)
    for index in range(len(nodes) - 1, -1, -1):
        node = nodes[index]
        signature = frozenset(  # paths, kinds of values, and types
            (path, value if path[-1] in ("type", "kind") else type(value) if isinstance(value, (bool, str)) else float)
            for path, value in node.values.items()
        )
        shape = numbers.setdefault((signature, tuple(below[index])), len(numbers))
        if node.up >= 0:
            below[node.up].append(shape)
            fits[node.up] = fits[node.up] and fits[index]
        is_bare = node.size == 1 and not node.entries["link"] and node.kind == "fixed"
        if fits[index] and node.size <= _MAX_NODES and not is_bare:
            groups[shape].insert(0, index)
    several = [group for group in groups.values() if len(group) > 1]
    return sorted(several, key=lambda group: (-nodes[group[0]].size, -len(group), group))


def deep_copy(value: Any) -> Any:
    """Return a copy of mappings and lists."""
    if isinstance(value, Mapping):
        return {key: deep_copy(item) for key, item in value.items()}
    return list(map(deep_copy, value)) if isinstance(value, list) else value


def _scalars(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield the path and value of each scalar."""
    if isinstance(value, (Mapping, list)) and value:
        for step, item in value.items() if isinstance(value, Mapping) else enumerate(value):
            yield from _scalars(item, (*path, step))
    else:
        yield path, value


def mirror_node(node: Node, mirror: str, is_root: bool) -> Values:
    """Return the values of a node as ``mirror`` of the language reflects them.

    The pose of a root is that of the use, which is not reflected.
    """
    values = dict(node.values)
    axis = "xyz".index(mirror) if mirror else -1
    for path, number in node.values.items() if mirror else ():
        key, index = (path[-2], path[-1]) if len(path) > 1 else ("", "")
        is_axis_of_joint = path[:2] == ("joint", "axis") and node.kind in _WITH_AXIS
        if is_root and is_pose(path):
            continue
        if key in ("min", "max") and index == axis and path[-3] == "box":
            opposite: Path = (*path[:-2], "max" if key == "min" else "min", axis)
            values[opposite] = _negative(number)
        elif (
            (key in ("xyz", "scale") and index == axis)
            or (key == "rpy" and index != axis)
            or (index in _PRODUCTS and mirror in str(index)[1:])
            or (is_axis_of_joint and (index == axis) == (node.kind == "prismatic"))
        ):
            values[path] = _negative(number)
    return values


def _negative(value: float) -> float:
    """Return the negated number; a quantity keeps its unit, and zero its sign."""
    if isinstance(value, Quantity) and value.text and value:
        return Quantity.parse(value.text[1:] if value.text.startswith("-") else f"-{value.text}") or -value
    return -value if value else value


def is_pose(path: Path) -> bool:
    """Return True for a value of the pose of a joint."""
    return path[:2] in (("joint", "xyz"), ("joint", "rpy"))


def is_number(value: Any) -> bool:
    """Return True for an int or float, and False for a boolean."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)

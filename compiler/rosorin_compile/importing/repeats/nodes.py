"""Flatten links and joints to compare subtrees, and replace differing values with parameters of a part.

A node is a link with its parent joint; the scalars of both are stored by path. The nodes of a subtree are a slice of
the list, because parents precede their descendants. Numbers that differ only in sign share a sign parameter. A string
that contains the name of the instance (entry of ``use``) becomes an expression with ``${name}``. A list in which
several numbers differ becomes one parameter, and values that are equal in every instance share a parameter.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from keyword import kwlist
from typing import Any

from rosorin_compile.language.expression.functions import CONSTANTS, OF_DESCRIPTIONS, functions
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Path
from rosorin_compile.source.units import UNITS, Quantity

from ..description import Expression, escape, free_name, is_number

Values = dict[Path, Any]

MOUNT = "mount"  # inside a part, the name of the link to which the part is attached
# Paths of values in a node that are names of joints, mimic constraints or actuators.
REFERENCES: tuple[Path, ...] = (("joint", "mimic", "joint"), ("joint", "mimic", "name"), ("joint", "actuator", "name"))
_MAX_NODES = 200  # maximum number of links in a part
# Links and joints with these keys cannot be in a part: the values are XML, or names that must be unique.
_UNFIT = frozenset(("publisher", "target", "urdf_elements", "mjcf_elements", "sites", "cameras", "lights"))
_WITH_AXIS = ("revolute", "continuous", "prismatic", "planar")
_PRODUCTS = ("ixy", "ixz", "iyz")
_WORDS = {"lower": "lower_limit", "upper": "upper_limit", "file": "mesh", "rgba": "colour", "material": "look"}
_AXES = {"xyz": ("x", "y", "z"), "rpy": ("roll", "pitch", "yaw")}


@dataclass
class Node:
    """A link with its parent joint; ``joint`` is "" for a root link."""

    link: str
    joint: str
    carrier: str  # name of the parent link, or MOUNT
    up: int  # index of the parent node, or -1
    rank: tuple[int, int]  # indices of the link and the joint in the source
    entries: dict[str, Any]  # the entries "link" and "joint" of the description
    values: Values  # the scalars in ``entries`` by path
    size: int = 1  # number of nodes in the subtree

    @property
    def kind(self) -> str:
        """The type of the joint, or "" for a root link."""
        kind: str = self.values.get(("joint", "type"), "")
        return kind

    @property
    def names(self) -> list[str]:
        """The names of the link, the joint, the mimic constraint and the actuator."""
        return [self.link, self.joint, *(self.values[path] for path in REFERENCES[1:] if path in self.values)]


def nodes_of(body: Mapping[str, Any]) -> list[Node]:
    """Return a ``Node`` for each link, parents first, or [] if links form a loop or have several parent joints."""
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
        # Fill in defaults, so that instances with and without these keys have the same paths.
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
    """Group links whose subtrees have the same structure; return lists of node indices, the largest subtrees first."""
    numbers: dict[Any, int] = {}
    below: list[list[int]] = [[] for _ in nodes]
    fits = [
        node.up >= 0 and not any(isinstance(one, Expression) or _UNFIT & {*path} for path, one in node.values.items())
        for node in nodes
    ]
    groups: dict[int, list[int]] = defaultdict(list)
    for index in range(len(nodes) - 1, -1, -1):
        node = nodes[index]
        signature = frozenset(  # ignores values except types of joints and shapes
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
    """Copy nested mappings and lists; scalars are shared."""
    if isinstance(value, Mapping):
        return {key: deep_copy(item) for key, item in value.items()}
    return list(map(deep_copy, value)) if isinstance(value, list) else value


def _scalars(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    if isinstance(value, (Mapping, list)) and value:
        for step, item in value.items() if isinstance(value, Mapping) else enumerate(value):
            yield from _scalars(item, (*path, step))
    else:
        yield path, value


def mirror_node(node: Node, mirror: str, is_root: bool) -> Values:
    """Return the values of a node, mirrored along the axis ``mirror`` ("" for none). If ``is_root``, keep the pose."""
    values = dict(node.values)
    axis = "xyz".index(mirror) if mirror else -1
    for path, number in node.values.items() if mirror else ():
        key, index = (path[-2], path[-1]) if len(path) > 1 else ("", "")
        is_axis_of_joint = path[:2] == ("joint", "axis") and node.kind in _WITH_AXIS
        if is_root and is_pose(path):  # the entry in "use" sets the pose of the root link
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
    """Negate a number; a quantity keeps its unit, and 0 does not become -0."""
    if isinstance(value, Quantity) and value.text and value:
        return Quantity.parse(value.text[1:] if value.text.startswith("-") else f"-{value.text}") or -value
    return -value if value else value


def is_pose(path: Path) -> bool:
    """Return True if a path such as ``("joint", "xyz", 0)`` belongs to the pose of a joint."""
    return path[:2] in (("joint", "xyz"), ("joint", "rpy"))


@dataclass
class Parameter:
    """A parameter of a part, with its value in each instance."""

    name: str
    kind: str
    values: Sequence[Any]
    is_derived: bool = False  # computed from the built-in variable ``mirrored``, not an argument

    @property
    def default(self) -> Any:
        """The value that at least half of the instances share, or None if there is no such value."""
        text, count = Counter(map(repr, self.values)).most_common(1)[0]
        has_default = self.kind != "sign" and count > 1 and 2 * count >= len(self.values)
        return next(value for value in self.values if repr(value) == text) if has_default else None

    @property
    def entry(self) -> dict[str, Any]:
        """The declaration of the parameter for the section ``params`` of the part."""
        if self.kind == "sign":
            return {"type": "integer", "one_of": [1, -1]}
        entry = {} if self.kind == "any" else {"type": self.kind}
        return entry if self.default is None else {**entry, "default": self.default}


class Parameters:
    """The parameters of a part; ``uses`` (names), ``prefixes`` and ``mirrored`` have a value for each instance."""

    def __init__(self, uses: Sequence[str], prefixes: Sequence[str], mirrored: Sequence[bool]) -> None:
        self.uses, self.prefixes, self.mirrored = uses, prefixes, mirrored
        self.count = 0  # number of values replaced with expressions
        self._index: dict[Any, Parameter] = {}

    @property
    def arguments(self) -> list[Parameter]:
        """The parameters that instances set, without derived parameters."""
        return [one for one in self._index.values() if not one.is_derived]

    @property
    def derived_values(self) -> dict[str, Expression]:
        """The expressions for the section ``let`` of the part, by name of the derived parameter."""
        names = [one.name for one in self._index.values() if one.is_derived]
        return dict.fromkeys(names, Expression("${-1 if mirrored else 1}"))

    def replace(self, values: Mapping[Path, Sequence[Any]], owner: str) -> dict[Path, Any]:
        """Return {path: expression} for the values that differ between instances; create parameters as needed.

        ``values`` has the value in each instance by path. ``owner`` (a link or joint) makes parameter names unique.
        """
        differing = [path for path, some in values.items() if any(value != some[0] for value in some[1:])]
        numbers = [path for path in differing if isinstance(path[-1], int) and all(map(is_number, values[path]))]
        points = Counter(path[:-1] for path in numbers if not _is_sign(values[path]))
        terms: dict[Path, Any] = {}
        for unit in dict.fromkeys(path[:-1] if points[path[:-1]] > 1 else path for path in differing):
            some = values.get(unit, ())
            if unit not in values:
                columns = [values[path] for path in values if path[:-1] == unit]
                text = f"${{{self._parameter('any', list(zip(*columns, strict=True)), unit, owner)}}}"
            elif all(map(is_number, some)) and _is_sign(some):
                text = f"${{{self._signed(some)}}}"
            elif all(isinstance(value, str) for value in some):
                text = self._text(some, unit, owner)
            else:
                kind = "boolean" if all(isinstance(one, bool) for one in some) else "any"
                text = f"${{{self._parameter(kind, some, unit, owner)}}}"
            terms[unit] = Expression(text)
        self.count += len(terms)
        return terms

    def _parameter(self, kind: str, values: Sequence[Any], path: Path, owner: str) -> str:
        key = (kind, repr(list(values)))
        if key not in self._index:
            words = [step for step in path if isinstance(step, str)]
            word = _WORDS.get(words[-1], words[-1])
            if isinstance(path[-1], int) and words[-1] in _AXES:
                word = _AXES[words[-1]][path[-1]]
            if owner and any(one.name == _identifier(word) for one in self._index.values()):
                word = f"{re.sub(r'[$][{][^}]*[}]', '', owner)}_{word}"
            self._index[key] = Parameter(self._free_name(_identifier(word)), kind, values)
        return self._index[key].name

    def _free_name(self, word: str) -> str:
        reserved = {*functions(), *OF_DESCRIPTIONS, *CONSTANTS, *UNITS, *kwlist}
        return free_name(word, reserved.union(one.name for one in self._index.values()))

    def _signed(self, values: Sequence[Any]) -> str:
        """Return an expression such as "0.1 * side": the first value times a parameter that is 1 or -1."""
        signs = tuple(1 if value == values[0] else -1 for value in values)
        if signs not in self._index:
            is_derived = any(self.mirrored) and signs == tuple(-1 if flag else 1 for flag in self.mirrored)
            name = self._free_name("side" if is_derived else "direction")
            self._index[signs] = Parameter(name, "sign", signs, is_derived)
        value = values[0]
        text = value.text if isinstance(value, Quantity) and value.text else exact(value)
        return f"{text[:-1] if text in ('1', '-1') else f'{text} * '}{self._index[signs].name}"

    def _text(self, texts: Sequence[str], path: Path, owner: str) -> str:
        """Return an expression for differing strings, with ``${name}``, ``${prefix}`` or else a new parameter."""
        if all(self.uses) and not any("${" in text or "$(" in text for text in texts):
            for word, names in (("name", self.uses), ("prefix", self.prefixes)):
                pattern = r"{}" if word == "prefix" else r"(?<![A-Za-z0-9]){}(?![A-Za-z0-9])"
                rows = {
                    tuple(re.split(pattern.format(re.escape(name)), text)) if name else ()
                    for text, name in zip(texts, names, strict=True)
                }
                if len(rows) == 1 and len(pieces := rows.pop()) > 1:
                    return f"${{{word}}}".join(map(escape, pieces))
        before = after = ""
        if path[-1] == "file":  # the parameter does not include a common folder or file extension
            folders, endings = ({text.rpartition(sign)[i] for text in texts} for sign, i in (("/", 0), (".", 2)))
            before = f"{min(folders)}/" if len(folders) == 1 and all("/" in text for text in texts) else ""
            after = f".{min(endings)}" if len(endings) == 1 and all("." in t[len(before) :] for t in texts) else ""
        middles = [text[len(before) : len(text) - len(after)] for text in texts]
        name = self._parameter("text", middles, path, owner)
        return f"{escape(before)}${{{name}}}{escape(after)}"


def _identifier(text: str) -> str:
    name = re.sub(r"[\W_]+", "_", text, flags=re.ASCII).strip("_").lower()
    return name if name and not name[0].isdigit() else f"n_{name}".strip("_")


def _is_sign(values: Sequence[Any]) -> bool:
    return len({abs(value) for value in values}) == 1

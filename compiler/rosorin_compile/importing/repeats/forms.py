"""Forms: a robot as a list of nodes, a link and the joint that carries it, whose values can be held side by side.

A form is what the tree has, with a ``Leaf`` for every scalar: the value in each of several instances. A node stands
before all that hangs on it, so a subtree is a slice of the list, and equal subtrees are compared item by item.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import Quantity

from ..order import default_of_key

MARKS = ("sites", "cameras", "lights")  # what a link has by name: the names are no keys, they differ
_KINDS = ("type", "kind")  # two things of different kinds are never instances of one
_ZERO = ("xyz", "rpy")
PRODUCTS = ("ixy", "ixz", "iyz")
_MIRRORED_AXIS = ("revolute", "continuous", "prismatic", "planar")


class Leaf:
    """A scalar: its value in each instance, and where each stands in the source."""

    __slots__ = ("spans", "values")

    def __init__(self, values: tuple[Any, ...], spans: tuple[Span | None, ...]) -> None:
        self.values = values
        self.spans = spans

    @property
    def is_number(self) -> bool:
        """Whether it is a number in all instances."""
        return isinstance(self.values[0], (int, float)) and not isinstance(self.values[0], bool)

    @property
    def is_same(self) -> bool:
        """Whether it is the same in all instances."""
        first = self.values[0]
        return all(value == first for value in self.values[1:])

    def negative(self) -> Leaf:
        """Return the leaf with the other sign; zero stays as it is."""
        return Leaf(tuple(_negative(value) for value in self.values), self.spans)

    def sliced(self, start: int, stop: int) -> Leaf:
        """Return the values of some instances."""
        return Leaf(self.values[start:stop], self.spans[start:stop])


def _negative(value: Any) -> Any:
    """Return a number with the other sign; a quantity keeps its unit, zero stays as it is."""
    if isinstance(value, Quantity) and value.text and value:
        return Quantity.parse(value.text[1:] if value.text.startswith("-") else f"-{value.text}")
    return -value if value else value


Form = Any  # dict[str, Form] | list[Form] | Leaf


class Node:
    """A link and the joint that carries it (none at a root).

    ``pose`` is that of the joint, ``carrier`` the link it hangs on, ``up`` its node as an index of the list. ``rank``
    is where link and joint stand in the source, ``origins`` how they are called there, in each instance.
    """

    __slots__ = ("body", "carrier", "joint", "link", "moves", "origins", "pose", "rank", "size", "up")

    def __init__(self, link: str, joint: str, rank: tuple[int, int], up: int, carrier: str) -> None:
        self.link, self.joint, self.rank, self.up, self.carrier = link, joint, rank, up, carrier
        self.body: Form = {}
        self.moves: Form = {}
        self.pose: Form = {}
        self.size = 1
        self.origins: list[tuple[str, str]] = [(link, joint)]


def nodes_of(tree: Map) -> list[Node]:
    """Return the nodes of a robot, each before all that hangs on it; nothing for what is no forest."""
    links, joints = tree.get("links") or {}, tree.get("joints") or {}
    below: dict[str, list[str]] = {}
    for name, joint in joints.items():
        below.setdefault(joint.get("parent"), []).append(name)
    carried = {joint.get("child") for joint in joints.values()}
    roots = [name for name in links if name not in carried]
    if len(carried) != len(joints) or not roots:
        return []
    ranks = {name: rank for rank, name in enumerate(links)}, {name: rank for rank, name in enumerate(joints)}
    made: list[Node] = []
    waiting = [(root, "", -1) for root in reversed(roots)]
    while waiting:
        link, joint, up = waiting.pop()
        if not isinstance(links.get(link), Map):
            return []
        node = Node(link, joint, (ranks[0][link], ranks[1].get(joint, -1)), up, made[up].link if joint else "")
        node.body = _body(form(links[link], None))
        if joint:
            node.moves, node.pose = _moves(form(joints[joint], None))
        made.append(node)
        waiting += [(joints[name]["child"], name, len(made) - 1) for name in reversed(below.get(link, ()))]
    for node in reversed(made):
        if node.up >= 0:
            made[node.up].size += node.size
    return made if len(made) == len(links) else []


def form(value: Any, span: Span | None) -> Form:
    """Return a value of the tree as a form of one instance."""
    if isinstance(value, Map):
        return {key: form(item, value.value_spans.get(key)) for key, item in value.items()}
    if isinstance(value, Seq):
        return [form(item, place) for item, place in zip(value, value.value_spans, strict=True)]
    return Leaf((value,), (span,))


def _zeros(entry: Form) -> None:
    for key in _ZERO:
        if entry.get(key) is None:
            entry[key] = [Leaf((0.0,), (None,)) for _ in range(3)]


def _body(entry: Form) -> Form:
    """Return the form of a link with its defaults (zeros) written out, so that two forms can be compared."""
    for shape in (*(entry.get("visual") or ()), *(entry.get("collision") or ())):
        _zeros(shape)
        if isinstance(shape.get("mesh"), dict) and "scale" not in shape["mesh"]:
            shape["mesh"]["scale"] = [Leaf((1.0,), (None,)) for _ in range(3)]
    inertial = entry.get("inertial")
    if isinstance(inertial, dict):
        _zeros(inertial)
        if isinstance(inertial.get("inertia"), dict):
            for key in PRODUCTS:
                inertial["inertia"].setdefault(key, Leaf((0.0,), (None,)))
    return entry


def _moves(entry: Form) -> tuple[Form, Form]:
    """Return the form of a joint without its place, and its place."""
    _zeros(entry)
    pose = {key: entry.pop(key) for key in _ZERO}
    moves = {key: value for key, value in entry.items() if key not in ("parent", "child")}
    if entry["type"].values[0] in _MIRRORED_AXIS and "axis" not in moves:
        moves["axis"] = [Leaf((float(not index),), (None,)) for index in range(3)]
    return moves, pose


def shape_of(entry: Form) -> Any:
    """Return what a form has in common with every other instance, whatever its numbers and texts."""
    if isinstance(entry, dict):
        return tuple((key, _shape_in(key, entry[key])) for key in sorted(entry))
    if isinstance(entry, list):
        return ("list", *map(shape_of, entry))
    value = entry.values[0]
    return "number" if entry.is_number else type(value).__name__ if not isinstance(value, str) else "text"


def _shape_in(key: str, entry: Form) -> Any:
    if key in _KINDS and isinstance(entry, Leaf):
        return ("of", str(entry.values[0]))
    if key in MARKS and isinstance(entry, dict):
        return ("named", *map(shape_of, entry.values()))
    return shape_of(entry)


def merged(entries: Sequence[Form], names: dict[str, str]) -> Form:
    """Return one form of several of the same shape; ``names`` are those that the first gets, of marks."""
    first = entries[0]
    if isinstance(first, Leaf):
        values = tuple(value for entry in entries for value in entry.values)
        return Leaf(values, tuple(span for entry in entries for span in entry.spans))
    if isinstance(first, list):
        return [merged(items, names) for items in zip(*entries, strict=True)]
    made = {}
    for key in first:
        if key in MARKS and isinstance(first[key], dict):
            rows = zip(*(entry[key].values() for entry in entries), strict=True)
            made[key] = {names[name]: merged(row, names) for name, row in zip(first[key], rows, strict=True)}
        else:
            made[key] = merged([entry[key] for entry in entries], names)
    return made


def leaves(entry: Form, path: Path = ()) -> Iterator[tuple[Path, Any, Any, Leaf]]:
    """Yield each leaf of a form: its path, what holds it, its key there, and itself."""
    items = entry.items() if isinstance(entry, dict) else enumerate(entry)
    for key, item in items:
        if isinstance(item, Leaf):
            yield (*path, key), entry, key, item
        elif isinstance(item, (dict, list)):
            yield from leaves(item, (*path, key))


def says_nothing(key: str, value: Any) -> bool:
    """Say whether a value is what the language takes when nothing is said."""
    default = default_of_key(key)
    return default is not None and bool(value == default)


def flat(entry: Form) -> list[Leaf]:
    """Return the leaves of a form."""
    return [entry] if isinstance(entry, Leaf) else [leaf for _, _, _, leaf in leaves(entry)]


def sliced(entry: Form, start: int, stop: int) -> Form:
    """Return a form with the values of some of its instances."""
    if isinstance(entry, Leaf):
        return entry.sliced(start, stop)
    if isinstance(entry, list):
        return [sliced(item, start, stop) for item in entry]
    return {key: sliced(item, start, stop) for key, item in entry.items()}


def mirrored(node: Node, mirror: str, root: bool) -> tuple[Form, Form, Form]:
    """Return body, moves and pose of a node as ``mirror`` of the language reflects them (see ``placing``).

    The place of a ``root`` is that of the use, which is not reflected.
    """
    axis = "xyz".index(mirror)
    pose = node.pose if root else _turned(node.pose, axis)
    moves = dict(node.moves)
    kind = moves["type"].values[0]
    if kind in _MIRRORED_AXIS and isinstance(moves.get("axis"), list):
        slides = kind == "prismatic"
        moves["axis"] = [v.negative() if (i == axis) == slides else v for i, v in enumerate(moves["axis"])]
    body = dict(node.body)
    for purpose in ("visual", "collision"):
        if isinstance(body.get(purpose), list):
            body[purpose] = [_shape(shape, axis) for shape in body[purpose]]
    for key in MARKS:
        if isinstance(body.get(key), dict):
            body[key] = {name: _turned(mark, axis) for name, mark in body[key].items()}
    if isinstance(body.get("inertial"), dict):
        inertial = body["inertial"] = _turned(body["inertial"], axis)
        if isinstance(inertial.get("inertia"), dict):
            moments, across = dict(inertial["inertia"]), "xyz"[axis]
            inertial["inertia"] = moments | {
                key: moments[key].negative() for key in PRODUCTS if across in key[1:] and key in moments
            }
    return body, moves, pose


def _turned(entry: Form, axis: int) -> Form:
    """Return an entry with its pose reflected."""
    made = dict(entry)
    for key in _ZERO:
        if isinstance(made.get(key), list) and len(made[key]) == 3:
            made[key] = [v.negative() if (i == axis) == (key == "xyz") else v for i, v in enumerate(made[key])]
    return made


def _shape(entry: Form, axis: int) -> Form:
    made = _turned(entry, axis)
    box, mesh = made.get("box"), made.get("mesh")
    if isinstance(box, dict) and "min" in box and "max" in box:
        low, high = list(box["min"]), list(box["max"])
        low[axis], high[axis] = box["max"][axis].negative(), box["min"][axis].negative()
        made["box"] = box | {"min": low, "max": high}
    if isinstance(mesh, dict) and isinstance(mesh.get("scale"), list):
        scale = list(mesh["scale"])
        scale[axis] = scale[axis].negative()
        made["mesh"] = mesh | {"scale": scale}
    return made

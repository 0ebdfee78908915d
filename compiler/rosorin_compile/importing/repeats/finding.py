"""Finding: subtrees of one shape, and whether they read better as a part and its uses.

The largest come first; what is within a part is searched in the part. Which thresholds hold is given in
``docs/import.md``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

from rosorin_compile.language.schema import fragment_at
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Path

from .forms import MARKS, Form, Leaf, Node, merged, mirrored, shape_of, sliced
from .names import MOUNT, Split, identity, is_left, split, whole
from .parameters import MAX_PARAMETERS, Owner, Parameters, differences, owners

MIN_SAVED = 8  # lines, all in all
MIN_TRUNK = 0.6  # of the links of each, where other things hang on what is equal
SAVED_BY_USE = 3  # lines that each use saves: less is no relief to a reader
MAX_SHARE = 0.8  # of the lines without the part
MAX_NODES = 200  # links of one part: nobody reads more
WORK = 60  # comparisons of nodes for each node of the robot; a bound, so that finding is linear
MIRRORS = ("", "y", "x")  # left and right, front and rear
_FAR = (MAX_PARAMETERS + 1, 0)
_SHAPES = ("visual", "collision")
_PER_PARAMETER = 4  # values with an expression that cost a reader as much as a parameter, or a mirror


class Use(NamedTuple):
    """A part put into a body: what it is called, where it sits, and what it is given, as forms of the body."""

    part: Part
    name: str
    prefix: str | None
    parent: str
    pose: Form
    mirror: str
    given: dict[str, Form]
    rank: int


class Part:
    """What equal subtrees have in common: nodes and uses of its own, and its parameters."""

    def __init__(self, name: str, nodes: list[Node], uses: list[Use], parameters: Parameters, cut: Split) -> None:
        self.name, self.nodes, self.uses, self.parameters, self.cut = name, nodes, uses, parameters, cut

    def all(self) -> Iterator[Part]:
        """Yield the parts that it uses, those first, and itself."""
        for use in self.uses:
            yield from use.part.all()
        yield self

    @property
    def counts(self) -> bool:
        """Whether its names go on counting from a number that a use gives."""
        return self.cut.first is not None


class Instance(NamedTuple):
    """One of several equal things: its nodes in its body, and by which mirror it is like the first."""

    nodes: tuple[int, ...]
    mirror: str = ""

    @property
    def start(self) -> int:
        """The node that carries the others."""
        return self.nodes[0]


class Body:
    """A robot, or what is within a part: its nodes, and for each of its instances what stands before its names.

    ``found`` are the instances that became parts, with their uses; ``refused`` those that may not.
    """

    def __init__(self, nodes: list[Node], prefixes: list[str]) -> None:
        self.nodes, self.prefixes = nodes, prefixes
        self.found: list[tuple[list[Instance], list[Use]]] = []
        self.refused: set[int] = set()

    @property
    def width(self) -> int:
        """In how many instances it is there."""
        return len(self.prefixes)

    @property
    def uses(self) -> list[Use]:
        """What takes the place of instances, in the order of the source."""
        return sorted((use for _, uses in self.found for use in uses), key=lambda use: use.rank)

    @property
    def left(self) -> list[Node]:
        """The nodes that no use makes."""
        covered = self.covered
        return [node for index, node in enumerate(self.nodes) if index not in covered]

    @property
    def covered(self) -> set[int]:
        """The nodes that uses make."""
        return {index for cluster, _ in self.found for one in cluster for index in one.nodes}


Worth = Callable[[Body, list[Instance], Part, list[Use]], bool]


class Finder:
    """Finds the parts of a robot of so many nodes. ``worth`` says whether a part and its uses read better."""

    def __init__(self, nodes: int, worth: Worth, keeps_order: bool = False) -> None:
        self.budget = WORK * nodes
        self.worth = worth
        self.keeps_order = keeps_order
        self.names: list[str] = []
        self.made: dict[str, Part] = {}

    def fold(self, body: Body) -> None:
        """Find the parts of a body, the largest first. Where the order has to stay, what would change it is no part."""
        before = list(self.names), dict(self.made)
        self._search(body)
        while self.keeps_order and (late := _out_of_order(body)):
            body.refused |= late
            body.found, self.names, self.made = [], list(before[0]), dict(before[1])
            self._search(body)

    def _search(self, body: Body) -> None:
        shapes, own = _shapes(body.nodes)
        by_shape: dict[int, list[int]] = defaultdict(list)
        for index, shape in enumerate(shapes):
            if body.nodes[index].up >= 0 and body.nodes[index].size <= MAX_NODES and index not in body.refused:
                by_shape[shape].append(index)
        size = {shape: body.nodes[members[0]].size for shape, members in by_shape.items()}
        several = [
            [tuple(range(start, start + size[shape])) for start in members]
            for shape, members in by_shape.items()
            if len(members) > 1
        ]
        covered: set[int] = set()
        several += _trunks(body, shapes, own)
        for number, those in enumerate(sorted(several, key=lambda some: (-len(some[0]), -len(some), some[0]))):
            Progress.step("finding what repeats", number, len(several))
            covered |= self._tried(body, [one for one in those if covered.isdisjoint(one)])

    def _tried(self, body: Body, members: list[tuple[int, ...]]) -> set[int]:
        """Make parts of those of some equal things that are alike; return the nodes that uses make now."""
        covered: set[int] = set()
        for cluster in self._clusters(body, members):
            if self._try(body, cluster):
                covered.update(index for one in cluster for index in one.nodes)
            elif len(cluster) > 2 and len(cluster[0].nodes) > 2:  # four legs may be two in front and two behind
                far = {one: self._apart(body, cluster[0], one)["value"] for one in cluster[1:]}
                near = [one.nodes for one, count in far.items() if count == min(far.values())]
                others = [one.nodes for one, count in far.items() if count > min(far.values())]
                if others:
                    covered |= self._tried(body, [cluster[0].nodes, *near]) | self._tried(body, others)
        return covered

    def _clusters(self, body: Body, members: list[tuple[int, ...]]) -> Iterator[list[Instance]]:
        """Yield instances that are alike, the one that all are held against first."""
        while len(members) > 1:
            self.budget -= len(members) * len(members[0])
            if self.budget < 0:
                return
            base = next((one for one in members if is_left(body.nodes[one[0]].link)), members[0])
            alike = {other: self._likeness(body, base, other) for other in members if other != base}
            near = {other: mirrors for other, mirrors in alike.items() if mirrors}
            if near:
                yield self._reflected(body, base, near)
            members = [other for other in alike if other not in near]

    def _likeness(self, body: Body, base: tuple[int, ...], other: tuple[int, ...]) -> dict[str, tuple[int, int]]:
        """Return the mirrors by which two things are alike, with how many values and signs tell them apart."""
        made: dict[str, tuple[int, int]] = {}
        for mirror in MIRRORS:
            count = self._apart(body, Instance(base), Instance(other, mirror))
            if count["value"] <= MAX_PARAMETERS:
                made[mirror] = (count["value"], count["sign"])
            if not any(count.values()):
                break  # no mirror makes that better
        return made

    def _apart(self, body: Body, one: Instance, other: Instance) -> dict[str, int]:
        """Return how many values and signs tell two instances apart; no more are counted than parameters may be."""
        count = {"value": 0, "sign": 0}
        for first, second in zip(_forms(body, one), _forms(body, other), strict=True):
            self.budget -= 1
            for mine, theirs in zip(first, second, strict=True):
                for kind, many in differences(mine, theirs):
                    count[kind] += many
            if count["value"] > MAX_PARAMETERS:
                break
        return count

    def _reflected(
        self, body: Body, base: tuple[int, ...], alike: dict[tuple[int, ...], dict[str, tuple[int, int]]]
    ) -> list[Instance]:
        """Return the instances with the mirrors that leave least to say: none, or one for those of the other side."""
        choices = [dict.fromkeys(alike, "")]
        for mirror in MIRRORS[1:]:
            near = {other: mirrors.get("", _FAR) <= mirrors.get(mirror, _FAR) for other, mirrors in alike.items()}
            choices.append({other: "" if stays else mirror for other, stays in near.items()})
            across = {
                other: body.nodes[other[0]].pose["xyz"]["xyz".index(mirror)].values[0] for other in (base, *alike)
            }
            choices.append({other: mirror if across[other] * across[base] < 0 else "" for other in alike})
        usable = [one for one in choices if all(mirror in alike[other] for other, mirror in one.items())]
        distinct = {tuple(one.values()): [Instance(base), *map(Instance, one, one.values())] for one in usable}
        if len(distinct) == 1:
            return next(iter(distinct.values()))
        return min(distinct.values(), key=lambda cluster: _Made(self, body, cluster).score())

    def _try(self, body: Body, cluster: list[Instance]) -> bool:
        """Make a part of instances, if that is to be had and worth it; say whether it was."""
        before = list(self.names), dict(self.made)
        if len(cluster[0].nodes) == 1 and _is_frame(body.nodes[cluster[0].start]):
            return False
        made = _Made(self, body, cluster).part()
        if made is None or not self.worth(body, cluster, *made):
            self.names, self.made = before
            return False
        body.found.append((cluster, made[1]))
        self.made[made[0].name] = made[0]
        return True

    def name(self, wanted: str, uses: Sequence[str]) -> str:
        """Return a name for a part that no other part has: where ``leg`` is taken, front_leg and rear_leg."""
        name, number, own = wanted, 1, identity(uses, wanted)
        if name in self.names and own:
            name = wanted = f"{own}_{wanted}"
            self._distinguish(wanted.removeprefix(f"{own}_"), own)
        while name in self.names:
            number += 1
            name = f"{wanted}_{number}"
        self.names.append(name)
        return name

    def _distinguish(self, name: str, own: str) -> None:
        """Rename the part that has a name already, to say what it is a part of, so that a second one may come."""
        other = self.made.get(name)
        theirs = identity(other.cut.uses, name) if other is not None else ""
        if other is not None and theirs not in ("", own) and f"{theirs}_{name}" not in self.names:
            other.name = f"{theirs}_{name}"
            self.names.append(other.name)


@cache
def _naming(mark: str) -> tuple[str, ...]:
    """Return the keys of a mark of a link that name a link."""
    said = fragment_at(("links", "*", mark, "*"))["properties"]
    return tuple(key for key, one in said.items() if one.get("x-names") == "link")


@cache
def _kept() -> frozenset[str]:
    """Return the keys of links, joints and shapes that are elements kept as they are, with names inside."""
    entries: tuple[Path, ...] = (("links", "*"), ("joints", "*"), *(("links", "*", one, 0) for one in _SHAPES))
    said = (item for path in entries for item in fragment_at(path)["properties"].items())
    return frozenset(key for key, one in said if "x-names-in" in one.get("items", {}))


def _shapes(nodes: Sequence[Node]) -> tuple[list[int], list[int]]:
    """Return a number for each node that all subtrees of its shape have, and one that all nodes of its shape have."""
    known: dict[Any, int] = {}
    below: list[list[int]] = [[] for _ in nodes]
    made, alone = [0] * len(nodes), [0] * len(nodes)
    for index in range(len(nodes) - 1, -1, -1):
        node = nodes[index]
        key = (shape_of(node.body), shape_of(node.moves))
        alone[index] = known.setdefault(key, len(known))
        made[index] = known.setdefault((alone[index], tuple(below[index])), len(known))
        if node.up >= 0:
            below[node.up].append(made[index])
    return made, alone


def _trunks(body: Body, shapes: list[int], own: list[int]) -> Iterator[list[tuple[int, ...]]]:
    """Yield equal things on which other things hang: two arms, one of them with a camera. The others stay outside."""
    nodes = body.nodes
    below: list[list[int]] = [[] for _ in nodes]
    members: dict[int, list[int]] = defaultdict(list)
    ends: dict[int, int] = {}
    for index, node in enumerate(nodes):
        if node.up < 0:
            continue
        below[node.up].append(index)
        fits = 1 < node.size <= MAX_NODES and index not in body.refused
        if fits and index >= ends.get(own[index], 0):  # none hangs on another one of the same kind
            members[own[index]].append(index)
            ends[own[index]] = index + node.size
    for those in members.values():
        base, others = those[0], those[1:]
        if len({shapes[one] for one in those}) < 2:
            continue
        pairs = {other: _paired(base, other, below, shapes, own) for other in others}
        pairs = {other: found for other, found in pairs.items() if len(found) >= MIN_TRUNK * nodes[other].size}
        common = sorted(set.intersection(*(set(found) for found in pairs.values()))) if pairs else []
        if len(common) > 1 and len(common) >= MIN_TRUNK * nodes[base].size:
            yield [tuple(common), *(tuple(found[index] for index in common) for found in pairs.values())]


def _paired(base: int, other: int, below: list[list[int]], shapes: list[int], own: list[int]) -> dict[int, int]:
    """Return the nodes of two subtrees that stand for each other, from the node that carries all."""
    made: dict[int, int] = {}
    waiting = [(base, other)]
    while waiting:
        one, two = waiting.pop()
        made[one] = two
        rest = list(below[two])
        for child in below[one]:
            same = [twin for twin in rest if shapes[twin] == shapes[child]]
            near = same or [twin for twin in rest if own[twin] == own[child]]
            if near:
                rest.remove(near[0])
                waiting.append((child, near[0]))
    return made


def _forms(body: Body, instance: Instance) -> Iterator[tuple[Form, Form, Form]]:
    """Yield body, moves and pose of each node of an instance, as the first instance has them.

    The place of the first node is that of the use: it is left out.
    """
    for index in instance.nodes:
        node, root = body.nodes[index], index == instance.start
        forms = mirrored(node, instance.mirror, root) if instance.mirror else (node.body, node.moves, node.pose)
        yield (*forms[:2], {}) if root else forms


def _out_of_order(body: Body) -> set[int]:
    """Return the instances that make something stand behind what it stood before, on the same link.

    What no use makes comes first, then what the uses make, in their order.
    """
    instances = sorted((one for cluster, _ in body.found for one in cluster), key=lambda one: one.start)
    owner = {index: one for one in instances for index in one.nodes}
    place = {one.nodes: number for number, one in enumerate(instances, 1)}
    latest: dict[int, tuple[int, int]] = {}
    late: set[int] = set()
    for index in range(len(body.nodes) - 1, -1, -1):
        up, key = body.nodes[index].up, (place[owner[index].nodes] if index in owner else 0, index)
        if key > latest.get(up, key):
            late.add(owner[index].start if index in owner else index)
        latest[up] = min(key, latest.get(up, key))
    groups = [{one.start for one in cluster} for cluster, _ in body.found]
    return {start for group in groups if group & late for start in group}


def _is_frame(node: Node) -> bool:
    """Say whether a node is a bare frame: a link without anything, and a fixed joint."""
    return not node.body and bool(node.moves["type"].values[0] == "fixed")


class _Unfit(Exception):
    """Something that a part cannot say."""


class _Made:
    """Makes one part of instances."""

    def __init__(self, finder: Finder, body: Body, cluster: list[Instance]) -> None:
        self.finder, self.body, self.cluster = finder, body, cluster
        self.size = len(cluster[0].nodes)

    def part(self) -> tuple[Part, list[Use]] | None:
        """Return the part and its uses, in the order of the source; None if the language has no words for it."""
        rows = list(zip(*(self._names(one) for one in self.cluster), strict=True))
        cut = split([list(row) for row in rows])
        if cut is None:
            return None
        called = self.finder.name(whole(cut.uses, cut.rests), cut.uses)
        cut = self._free(cut, called)
        if cut is None:
            return None
        count, width = len(self.cluster), self.body.width
        prefixes = [before + own for own in cut.prefixes for before in self.body.prefixes]
        try:
            inner = Body(self._template(cut, rows), prefixes)
        except _Unfit:
            return None
        if cut.is_prefix:
            self.finder.fold(inner)
        flags = [bool(one.mirror) for one in self.cluster for _ in range(width)]
        named = [name for name in cut.uses for _ in range(width)]
        parameters = Parameters(named, prefixes, flags, plain=cut.first is None)
        uses = [_Owned(use) for use in inner.uses]
        kept = inner.left
        parameters.settle([*owners(kept), *(use.owner for use in uses)])
        if len(parameters.given) > min(MAX_PARAMETERS, self.size + 2):
            return None
        part = Part(called, kept, [use.settled() for use in uses], parameters, cut)
        return part, [self._use(part, number) for number in sorted(range(count), key=lambda i: self.cluster[i].start)]

    def score(self) -> int:
        """Return how much the part would have to say beside what is the same in all instances."""
        self.finder.budget -= len(self.cluster) * self.size
        rows = list(zip(*(self._names(one) for one in self.cluster), strict=True))
        count, width = len(self.cluster), self.body.width
        plain = Split([""] * count, [""] * count, [row[0] for row in rows])
        try:
            nodes = self._template(plain, rows)
        except _Unfit:
            return 0
        flags = [bool(one.mirror) for one in self.cluster for _ in range(width)]
        parameters = Parameters([""] * len(flags), [""] * len(flags), flags, plain=False)
        parameters.settle(owners(nodes))
        return _PER_PARAMETER * (len(parameters.given) + any(flags)) + parameters.terms

    def _names(self, instance: Instance) -> list[str]:
        """Return all names that an instance defines. Instances of one body give theirs in the same order."""
        made = []
        for node in (self.body.nodes[index] for index in instance.nodes):
            made += [node.link, node.joint]
            made += [name for key in MARKS for name in node.body.get(key) or ()]
            for key in ("mimic", "actuator"):
                entry = node.moves.get(key)
                if isinstance(entry, dict) and isinstance(entry.get("name"), Leaf):
                    made.append(str(entry["name"].values[0]))
        return made

    def _free(self, cut: Split, called: str) -> Split | None:
        """Return the split with names of uses that no other use of the body has."""
        taken = {use.name for use in self.body.uses}
        if cut.first is not None:
            order = sorted(range(len(self.cluster)), key=lambda i: self.cluster[i].start)
            names = {own: f"{called}_{number}" for number, own in enumerate(order, 1)}
            cut = cut._replace(uses=[names[i] for i in range(len(order))])
        if not taken.intersection(cut.uses):
            return cut
        longer = [f"{name}_{called}" for name in cut.uses]
        return cut._replace(uses=longer) if cut.is_prefix and not taken.intersection(longer) else None

    def _template(self, cut: Split, rows: list[tuple[str, ...]]) -> list[Node]:
        """Return the nodes of the part: each value with those of all instances."""
        rests = {row[0]: rest for row, rest in zip(rows, cut.rests, strict=True)}
        of = [{row[i]: rest for row, rest in zip(rows, cut.rests, strict=True)} for i in range(len(self.cluster))]
        place = {index: offset for offset, index in enumerate(self.cluster[0].nodes)}
        made: list[Node] = []
        for offset, forms in enumerate(zip(*(_forms(self.body, one) for one in self.cluster), strict=True)):
            nodes = [self.body.nodes[one.nodes[offset]] for one in self.cluster]
            base = nodes[0]
            up, carrier = (place[base.up], rests[base.carrier]) if offset else (-1, MOUNT)
            node = Node(rests[base.link], rests[base.joint], base.rank, up, carrier)
            node.body, node.moves, node.pose = (merged(row, rests) for row in zip(*forms, strict=True))
            node.origins = [origin for one in nodes for origin in one.origins]
            self._refer(node, of)
            made.append(node)
        for node in reversed(made):
            if node.up >= 0:
                made[node.up].size += node.size
        return made

    def _refer(self, node: Node, of: list[dict[str, str]]) -> None:
        """Put the names of the part where an entry names what is in it. Raises _Unfit where that cannot be said."""
        for key in ("mimic", "actuator"):
            entry = node.moves.get(key)
            for word in ("name", "joint") if key == "mimic" else ("name",):
                if isinstance(entry, dict) and isinstance(entry.get(word), Leaf):
                    entry[word] = self._meant(entry[word], of, word == "name")
        for key in MARKS:
            for mark in (node.body.get(key) or {}).values():
                for word in _naming(key):
                    if isinstance(mark.get(word), Leaf):
                        mark[word] = self._meant(mark[word], of, False)
        for entry in (node.body, node.moves, *(one for key in _SHAPES for one in node.body.get(key) or ())):
            if not _kept().isdisjoint(entry):
                raise _Unfit
        if "publisher" in node.moves:
            raise _Unfit

    def _meant(self, leaf: Leaf, of: list[dict[str, str]], own: bool) -> Leaf:
        """Return a name as the part has it."""
        width = len(leaf.values) // len(of)
        rests = {of[index // width].get(str(value)) for index, value in enumerate(leaf.values)}
        rest = rests.pop() if len(rests) == 1 else ""
        if rest:
            return Leaf((rest,) * len(leaf.values), leaf.spans)
        outside = rest is None and leaf.is_same and not own and str(leaf.values[0]) not in of[0].values()
        if not outside:
            raise _Unfit
        return leaf

    def _use(self, part: Part, number: int) -> Use:
        """Return the use of an instance."""
        width, cut, instance = self.body.width, part.cut, self.cluster[number]
        node = self.body.nodes[instance.start]
        given: dict[str, Form] = {}
        if cut.first is not None:
            given["first"] = Leaf((cut.first[number],) * width, (None,) * width)
        for one in part.parameters.given:
            given[one.name] = sliced(one.values, number * width, (number + 1) * width)
        name, prefix = cut.uses[number], cut.prefixes[number]
        said = None if prefix == f"{name}_" else prefix
        return Use(part, name, said, node.carrier, node.pose, instance.mirror, given, node.rank[1])


class _Owned:
    """A use within a part, as something that has values."""

    def __init__(self, use: Use) -> None:
        self.use = use
        self.entry: Form = {**use.pose, "with": dict(use.given)}
        kinds = {one.name: one.kind for one in use.part.parameters.given}
        self.owner = Owner(use.name, self.entry, given=kinds)

    def settled(self) -> Use:
        """Return the use with terms where values differ."""
        pose = {key: value for key, value in self.entry.items() if key != "with"}
        return self.use._replace(pose=pose, given=self.entry["with"])

"""Find subtrees of equal shape, and decide whether a part and its uses read better than the subtrees themselves."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Map, Path

from ..description import free_name, lines_of
from .nodes import MARKS, REFERENCES, Node, Values, add_sizes, deep_copy, flattened, mirrored, table
from .parameters import GIVEN, MAX_PARAMETERS, Parameter, Parameters, differences
from .part_names import MOUNT, Split, is_left, part_name, split
from .write_parts import part_entry, sections, use_entry

MIN_SAVED = 8  # lines in total
SAVED_BY_USE = 3  # lines that each use has to save
MAX_SHARE = 0.8  # of the lines without the part
MAX_NODES = 200  # links of one part
WORK = 60  # comparisons of nodes for each node of the robot, so that the search is linear
_PARAMETER_COST = 4  # expressions that are as hard to read as a parameter, or a mirror


@dataclass
class Use:
    """A part in a body. ``values`` are its pose and the parameters that it gives, for each instance of the body.

    ``pose`` and ``given`` have those of the first instance; ``terms`` replace what differs.
    """

    part: Part
    name: str
    prefix: str | None
    parent: str
    mirror: str
    values: Values
    pose: Map
    given: dict[str, Any]
    rank: int
    terms: dict[Path, Any] = field(default_factory=dict)


@dataclass
class Part:
    """What equal subtrees have in common: nodes, uses of other parts, and parameters."""

    name: str
    nodes: list[Node]
    uses: list[Use]
    parameters: Parameters
    split: Split

    def all(self) -> Iterator[Part]:
        """Yield the parts that it uses, those first, and itself."""
        for use in self.uses:
            yield from use.part.all()
        yield self


@dataclass(frozen=True)
class Instance:
    """One of several equal subtrees: its first node, and the mirror that makes it like the first instance."""

    start: int
    mirror: str = ""


class Body:
    """A robot, or the inside of a part: its nodes, the prefix of its names in each instance, and the uses found."""

    def __init__(self, nodes: list[Node], prefixes: list[str]) -> None:
        self.nodes, self.prefixes = nodes, prefixes
        self.uses: list[Use] = []
        self.covered: set[int] = set()


class Finder:
    """Finds the parts of a robot; ``count`` is the number of its nodes."""

    def __init__(self, span: Span, count: int) -> None:
        self.span = span
        self.budget = WORK * count
        self.names: set[str] = set()

    def find(self, body: Body) -> None:
        """Find the parts of a body, the largest first."""
        groups = [group for group in _equal_shapes(body.nodes) if len(group) > 1]
        for number, group in enumerate(sorted(groups, key=lambda some: (-body.nodes[some[0]].size, -len(some), some))):
            Progress.step("finding repeated structures", number, len(groups))
            self._try_group(body, [start for start in group if start not in body.covered])
        body.uses.sort(key=lambda use: use.rank)

    def _try_group(self, body: Body, members: list[int]) -> None:
        """Make parts of the members of a group that are similar."""
        while len(members) > 1:
            size = body.nodes[members[0]].size
            self.budget -= len(members) * size
            if self.budget < 0:
                return
            base = next((start for start in members if is_left(body.nodes[start].link)), members[0])
            apart = {start: self._apart(body, base, start) for start in members if start != base}
            near = [start for start, found in apart.items() if found[""][0] <= MAX_PARAMETERS or len(found) > 1]
            if near and not self._try(body, self._with_mirrors(body, base, {start: apart[start] for start in near})):
                least = min(min(apart[start].values()) for start in near)
                closest = [start for start in near if min(apart[start].values()) == least]
                if len(closest) < len(near):  # four legs may be two in front and two behind
                    self._try_group(body, [base, *closest])
                    self._try_group(body, [start for start in near if start not in closest])
            members = [start for start in apart if start not in near]

    def _apart(self, body: Body, base: int, start: int) -> dict[str, tuple[int, int]]:
        """Return the numbers of differing values and signs by mirror: for no mirror, and those that help."""
        found: dict[str, tuple[int, int]] = {}
        for mirror in ("", "y", "x"):
            values = signs = 0
            for offset in range(body.nodes[base].size):
                self.budget -= 1
                one, other = body.nodes[base + offset], body.nodes[start + offset]
                theirs = mirrored(other, mirror, not offset) if mirror else other.values
                more = differences(_compared(one.values, not offset), _compared(theirs, not offset))
                values, signs = values + more[0], signs + more[1]
                if values > MAX_PARAMETERS:
                    break
            if values <= MAX_PARAMETERS or not mirror:
                found[mirror] = values, signs
            if not (values or signs):
                break
        return found

    def _with_mirrors(self, body: Body, base: int, apart: dict[int, dict[str, tuple[int, int]]]) -> list[Instance]:
        """Return the instances, all without a mirror or those of the other side with one, whichever reads best."""
        choices = [dict.fromkeys(apart, "")]
        for mirror in ("y", "x"):
            better = {start: mirror in found and found[mirror] < found[""] for start, found in apart.items()}
            place = ("joint", "xyz", "xyz".index(mirror))
            across = {
                start: body.nodes[start].values[place][0] * body.nodes[base].values[place][0] < 0 for start in apart
            }
            for flags in (better, across):
                if all(mirror in apart[start] for start, flag in flags.items() if flag):
                    choices.append({start: mirror if flag else "" for start, flag in flags.items()})
        unique = {tuple(choice.values()): choice for choice in choices}.values()
        clusters = [[Instance(base), *(Instance(start, one) for start, one in choice.items())] for choice in unique]
        return min(clusters, key=lambda cluster: self._cost(body, cluster)) if len(clusters) > 1 else clusters[0]

    def _cost(self, body: Body, cluster: list[Instance]) -> int:
        """Return how much a part of these instances would have to express."""
        size, width = body.nodes[cluster[0].start].size, len(body.prefixes)
        self.budget -= len(cluster) * size
        subtrees = [body.nodes[one.start : one.start + size] for one in cluster]
        names = [{name: name for node in nodes for name in node.names} for nodes in subtrees]
        parameters = Parameters(
            [""] * (len(cluster) * width), [], [bool(one.mirror) for one in cluster for _ in range(width)]
        )
        for node in _template(cluster, subtrees, names):
            parameters.replace(_compared(node.values, node.up < 0), {}, "", node.kind, {})
        has_mirror = any(one.mirror for one in cluster)
        return _PARAMETER_COST * (len(parameters.given) + has_mirror) + parameters.count

    def _try(self, body: Body, cluster: list[Instance]) -> bool:
        """Make a part of instances if it can be expressed and is worth it."""
        base = body.nodes[cluster[0].start]
        if base.size == 1 and not base.entries["link"] and base.kind == "fixed":
            return False  # a bare frame
        before = set(self.names)
        uses = self._make(body, cluster)
        if not uses or not self._is_worth(body, cluster, uses):
            self.names = before
            return False
        body.uses += uses
        for one in cluster:
            body.covered.update(range(one.start, one.start + base.size))
        return True

    def _make(self, body: Body, cluster: list[Instance]) -> list[Use]:
        """Return the uses of a part made of instances; none if the language cannot express it."""
        size, width = body.nodes[cluster[0].start].size, len(body.prefixes)
        subtrees = [body.nodes[one.start : one.start + size] for one in cluster]
        names = [[name for node in nodes for name in node.names] for nodes in subtrees]
        parted = split(list(zip(*names, strict=True)))
        if parted is None:
            return []
        name = free_name(part_name(parted.uses, parted.rests), self.names)
        self.names.add(name)
        if parted.first:
            order = sorted(range(len(cluster)), key=lambda index: cluster[index].start)
            parted = parted._replace(uses=[f"{name}_{order.index(index) + 1}" for index in range(len(order))])
        taken = {use.name for use in body.uses}
        if taken.intersection(parted.uses):
            parted = parted._replace(uses=[f"{use}_{name}" for use in parted.uses])
            if taken.intersection(parted.uses) or not all(parted.prefixes):
                return []
        prefixes = [outer + own for own in parted.prefixes for outer in body.prefixes]
        nodes = _template(cluster, subtrees, [dict(zip(own, parted.rests, strict=True)) for own in names])
        if not nodes:
            return []
        inner = Body(nodes, prefixes)
        if all(parted.prefixes):
            self.find(inner)
        flags = [bool(one.mirror) for one in cluster for _ in range(width)]
        parameters = Parameters([use for use in parted.uses for _ in range(width)], prefixes, flags)
        if parted.first:
            first = Parameter("integer", [number for number in parted.first for _ in range(width)], ["first"])
            first.name = "first"
            parameters.all.append(first)
            parameters.uses = [""] * len(flags)
        left = [node for index, node in enumerate(nodes) if index not in inner.covered]
        for node in left:
            by_owner: dict[str, Values] = {"link": {}, "joint": {}}
            for path, values in _compared(node.values, node.up < 0).items():
                by_owner[str(path[0])][path] = values
            parameters.replace(by_owner["link"], node.terms, node.link, node.kind, {})
            parameters.replace(by_owner["joint"], node.terms, node.joint, node.kind, {})
        for use in inner.uses:
            types = {one.name: "integer" if one.kind == "sign" else one.kind for one in use.part.parameters.given}
            parameters.replace(use.values, use.terms, use.name, "", types)
        if len(parameters.given) > min(MAX_PARAMETERS, size + 2):
            return []
        parameters.name_all()
        part = Part(name, left, inner.uses, parameters, parted)
        return sorted(
            (
                _use(part, number, one, nodes[0], width)
                for number, (one, nodes) in enumerate(zip(cluster, subtrees, strict=True))
            ),
            key=lambda use: use.rank,
        )

    def _is_worth(self, body: Body, cluster: list[Instance], uses: list[Use]) -> bool:
        """Return True if a part and its uses are shorter than the subtrees by enough, and the part is not trivial."""
        base = cluster[0].start
        links, joints = sections(body.nodes[base : base + body.nodes[base].size], self.span)
        once = lines_of(table(self.span, {"links": links, "joints": joints}))
        parts = {part.name: part_entry(part, self.span) for part in uses[0].part.all()}
        entries = {use.name: use_entry(use, self.span) for use in uses}
        new = lines_of(table(self.span, {"parts": table(self.span, parts)}))
        new += lines_of(table(self.span, {"use": table(self.span, entries)}))
        flat = len(cluster) * once
        is_short = flat - new >= max(MIN_SAVED, SAVED_BY_USE * len(uses)) and new <= MAX_SHARE * flat
        return is_short and len(uses[0].part.parameters.given) < once


def _equal_shapes(nodes: list[Node]) -> list[list[int]]:
    """Return the first nodes of subtrees that can be instances of one part, grouped."""
    numbers: dict[Any, int] = {}
    shapes = [0] * len(nodes)
    below: list[list[int]] = [[] for _ in nodes]
    fits = [node.fits_in_part for node in nodes]
    groups: dict[int, list[int]] = defaultdict(list)
    for index in range(len(nodes) - 1, -1, -1):
        node = nodes[index]
        shapes[index] = numbers.setdefault((node.signature, tuple(below[index])), len(numbers))
        if node.up >= 0:
            below[node.up].append(shapes[index])
            fits[node.up] = fits[node.up] and fits[index]
    for index, node in enumerate(nodes):
        if node.up >= 0 and fits[index] and node.size <= MAX_NODES:
            groups[shapes[index]].append(index)
    return list(groups.values())


def _compared(values: Values, is_root: bool) -> Values:
    """Return the values that belong to a part: the pose of its root belongs to the use."""
    if not is_root:
        return values
    return {path: some for path, some in values.items() if path[:2] not in (("joint", "xyz"), ("joint", "rpy"))}


def _template(cluster: list[Instance], subtrees: list[list[Node]], names: list[dict[str, str]]) -> list[Node]:
    """Return the nodes of a part, each value with those of all instances; none if it refers to names outside."""
    base = cluster[0].start
    template: list[Node] = []
    for offset, instances in enumerate(zip(*subtrees, strict=True)):
        first = instances[0]
        values: Values = {}
        for one, node in zip(cluster, instances, strict=True):
            for path, some in (mirrored(node, one.mirror, not offset) if one.mirror else node.values).items():
                values[path] = (*values.get(path, ()), *some)
        entries = deep_copy(first.entries)
        for path in REFERENCES:
            if path in values:
                width = len(values[path]) // len(names)
                rests = {names[index // width].get(str(name)) for index, name in enumerate(values[path])}
                rest = rests.pop() if len(rests) == 1 else ""
                if rest is None and len(set(values[path])) == 1:
                    continue  # all instances follow one joint of the robot
                if not rest:
                    return []
                values[path] = (rest,) * len(values[path])
                entries["joint"][path[1]][path[2]] = rest
        for key in MARKS:
            if key in entries["link"]:
                marks = table(entries.span, {names[0][name]: mark for name, mark in entries["link"][key].items()})
                entries["link"].put(key, marks, entries.span, entries.span)
        carrier = names[0][first.carrier] if offset else MOUNT
        up = first.up - base if offset else -1
        origins = [origin for node in instances for origin in node.origins]
        link, joint = names[0][first.link], names[0][first.joint]
        template.append(Node(link, joint, carrier, up, first.rank, entries, values, origins))
    add_sizes(template)
    return template


def _use(part: Part, number: int, instance: Instance, root: Node, width: int) -> Use:
    """Return the use that replaces an instance."""
    values = {path[1:]: some for path, some in root.values.items() if path[:2] in (("joint", "xyz"), ("joint", "rpy"))}
    given = {}
    for parameter in part.parameters.given:
        given[parameter.name] = parameter.values[number * width]
        for value in parameter.values[number * width : (number + 1) * width]:
            for path, item in flattened(value, (GIVEN, parameter.name)):
                values[path] = (*values.get(path, ()), item)
    name, prefix = part.split.uses[number], part.split.prefixes[number]
    shown = None if prefix == f"{name}_" else prefix
    return Use(part, name, shown, root.carrier, instance.mirror, values, root.entries["joint"], given, root.rank[1])

"""Find subtrees of equal shape, and move them into parts where a part and its uses read better."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import BEFORE, INSIDE, Comment
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import Quantity

from ..description import default_of_key, free_name, lines_of
from ..layout import ROTATING, Expression, Verbatim, in_degrees, joint_unit
from .nodes import MARKS, MOUNT, REFERENCES, Node, equal_shapes, is_pose, mirrored, nodes_of, steps, table
from .parameters import Parameter, Parameters, is_number
from .part_names import Split, is_left, part_name, split

MAX_PARAMETERS = 6
_MIN_SAVED = 8  # lines in total
_SAVED_BY_USE = 3  # lines that each use has to save
_MAX_SHARE = 0.8  # of the lines without the part
_WORK = 60  # comparisons for each node of the robot, so that the search is linear
_PARAMETER_COST = 4  # expressions that are as hard to read as a parameter, or a mirror

Cluster = Sequence[tuple[int, str]]  # instances: the index of the first node, and the mirror of the first instance


class Home(NamedTuple):
    """Where a link or joint is now: its section and name in a part, the use that makes it; ``is_top`` of the part."""

    path: Path
    use: Path
    is_first: bool
    is_top: bool


@dataclass
class Part:
    """A part with its uses by name, and how much it has to express."""

    name: str
    entry: Map
    uses: dict[str, Map]
    cost: int
    split: Split
    homes: dict[Path, Home] = field(default_factory=dict)


@dataclass
class Result:
    """The parts of a robot by name, its comments, and how many comparisons of nodes are left."""

    span: Span
    comments: list[Comment]
    budget: int
    parts: dict[str, Map] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)


def with_parts(tree: Map, comments: Iterable[Comment]) -> tuple[Map, list[Comment]]:
    """Return the tree of a robot whose repeated structures are parts and uses, with the comments in their places."""
    result = Result(tree.span, list(comments), _WORK * len(tree.get("links") or ()))
    made = _Body(tree, (), result).factored()
    if result.parts:
        use = made.pop("use")
        made.put("parts", table(tree.span, result.parts), tree.span, tree.span)
        made.put("use", use, tree.span, tree.span)
    return made, result.comments


class _Body:
    """A robot or a part at a path of the description, in which repeated subtrees are found."""

    def __init__(self, body: Map, path: Path, result: Result) -> None:
        self.body, self.path, self.result = body, path, result
        self.nodes = nodes_of(body)
        self.uses: list[tuple[int, str, Map]] = []
        self.covered: set[int] = set()
        self.homes: dict[Path, Home] = {}

    def factored(self) -> Map:
        """Return the body with uses instead of the links and joints that they make."""
        groups = equal_shapes(self.nodes)
        for number, group in enumerate(groups):
            Progress.step("finding repeated structures", number, len(groups))
            self._try_group([start for start in group if start not in self.covered])
        if not self.uses:
            return self.body
        made = self.body.copied()
        for section in ("links", "joints"):
            left = self.body[section].copied()
            for name in self.body[section]:
                if (section, name) in self.homes:
                    del left[name]
            made[section] = left
        uses = {name: entry for _, name, entry in sorted(self.uses, key=lambda use: use[0])}
        made.put("use", table(self.body.span, uses), self.body.span, self.body.span)
        self._move_comments()
        return made

    def _try_group(self, members: list[int]) -> None:
        """Make a part of all members of a group, or of those that have equal numbers but for their signs."""
        if len(members) < 2 or self._try(members):
            return
        equal: dict[Any, list[int]] = defaultdict(list)
        for start in members:
            numbers = [
                (path, abs(value))
                for offset, node in enumerate(self.nodes[start : start + self.nodes[start].size])
                for path, value in node.values.items()
                if is_number(value) and (offset or not is_pose(path))
            ]
            equal[tuple(numbers)].append(start)
        for some in equal.values():
            if 1 < len(some) < len(members):  # four legs may be two in front and two behind
                self._try(some)

    def _try(self, members: list[int]) -> bool:
        """Make a part of instances, all without a mirror or those of the other side with one, if it is worth it."""
        base = next((start for start in members if is_left(self.nodes[start].link)), members[0])
        members = [base, *(start for start in members if start != base)]
        choices = [[""] * len(members)]
        for mirror in ("y", "x"):
            place: Path = ("joint", "xyz", "xyz".index(mirror))
            sides = [self.nodes[start].values[place] * self.nodes[base].values[place] for start in members]
            choices += [[mirror if side < 0 else "" for side in sides]] if min(sides) < 0 else []
        made = [self._make(list(zip(members, choice, strict=True))) for choice in choices]
        part = min((one for one in made if one is not None), key=lambda one: one.cost, default=None)
        if part is None or not self._is_worth(base, part):
            return False
        self.result.names.add(part.name)
        if all(part.split.prefixes):
            part.entry = _Body(part.entry, ("parts", part.name), self.result).factored()
        self.result.parts[part.name] = part.entry
        self.homes |= part.homes
        for start, name in zip(members, part.uses, strict=True):
            self.uses.append((self.nodes[start].rank[1], name, part.uses[name]))
            self.covered.update(range(start, start + self.nodes[base].size))
        return True

    def _make(self, cluster: Cluster) -> Part | None:
        """Return a part made of instances, or None if the language cannot express it."""
        size = self.nodes[cluster[0][0]].size
        self.result.budget -= len(cluster) * size
        if self.result.budget < 0:
            return None
        rows = [self.nodes[start : start + size] for start, _ in cluster]
        names = [[name for node in row for name in node.names] for row in rows]
        parted = split(list(zip(*names, strict=True)))
        if parted is None:
            return None
        name = free_name(part_name(parted.uses, parted.rests), self.result.names)
        uses, taken = parted.uses, {use for _, use, _ in self.uses}
        if parted.first:
            order = sorted(start for start, _ in cluster)
            uses = [f"{name}_{order.index(start) + 1}" for start, _ in cluster]
        if taken.intersection(uses):
            uses = [f"{use}_{name}" for use in uses]
            if taken.intersection(uses) or not all(parted.prefixes):
                return None
        parameters = Parameters(parted.uses, parted.prefixes, [bool(mirror) for _, mirror in cluster])
        if parted.first:
            parameters.count_up(parted.first)
        renames = [dict(zip(some, parted.rests, strict=True)) for some in names]
        all_terms: list[dict[Path, Any]] = []
        for offset, nodes in enumerate(zip(*rows, strict=True)):
            values = [mirrored(node, mirror, not offset) for node, (_, mirror) in zip(nodes, cluster, strict=True)]
            terms: dict[Path, Any] = {}
            for path in (one for one in REFERENCES if one in values[0]):
                targets = {renamed.get(some[path]) for renamed, some in zip(renames, values, strict=True)}
                if len(targets) > 1 or None in targets:
                    return None
                terms[path] = targets.pop()
            for section, owner in (("link", nodes[0].link), ("joint", nodes[0].joint)):
                compared = {
                    path: [some[path] for some in values]
                    for path in values[0]
                    if path[0] == section and path not in terms and (offset or not is_pose(path))
                }
                parameters.replace(compared, terms, renames[0][owner], nodes[0].kind)
            all_terms.append(terms)
        if parameters.given > min(MAX_PARAMETERS, size + 2):
            return None
        named = parameters.named()
        cost = _PARAMETER_COST * (parameters.given + any(parameters.mirrored)) + parameters.count
        entry = self._entry(rows[0], all_terms, renames[0], named)
        entries = {}
        for index, (use, prefix) in enumerate(zip(uses, parted.prefixes, strict=True)):
            entries[use] = self._use(name, use, prefix, cluster[index], named, index)
        part = Part(name, entry, entries, cost, parted)
        self._add_homes(part, rows, renames[0])
        return part

    def _entry(
        self, nodes: list[Node], terms: list[dict[Path, Any]], names: Mapping[str, str], named: Mapping[str, Parameter]
    ) -> Map:
        """Return an entry of ``parts``."""
        span = self.result.span
        links, joints = _sections(nodes, terms, names, span)
        params = {name: _declaration(one, span) for name, one in named.items() if not one.is_derived}
        lets = {name: Expression("${-1 if mirrored else 1}") for name, one in named.items() if one.is_derived}
        sections = {"params": table(span, params), "let": table(span, lets), "links": links, "joints": joints}
        return table(span, {key: value for key, value in sections.items() if value})

    def _use(
        self, part: str, name: str, prefix: str, instance: tuple[int, str], named: Mapping[str, Parameter], index: int
    ) -> Map:
        """Return an entry of ``use``; ``index`` is that of the instance."""
        root, span = self.nodes[instance[0]], self.result.span
        entry: dict[str, Any] = {"part": part}
        if prefix != f"{name}_":
            entry["prefix"] = prefix
        entry["parent"] = root.carrier
        entry |= {key: root.entries["joint"][key] for key in ("xyz", "rpy") if any(root.entries["joint"][key])}
        if instance[1]:
            entry["mirror"] = Verbatim(instance[1])
        given = {
            key: _tree(one.values[index], span)
            for key, one in named.items()
            if not one.is_derived and (one.default is None or repr(one.values[index]) != repr(one.default))
        }
        return table(span, {**entry, **({"with": table(span, given)} if given else {})})

    def _is_worth(self, base: int, part: Part) -> bool:
        """Return True if a part and its uses are shorter than the subtrees by enough, and the part is not trivial."""
        span, size = self.result.span, self.nodes[base].size
        nodes = self.nodes[base : base + size]
        links, joints = _sections(nodes, [{}] * size, {name: name for node in nodes for name in node.names}, span)
        once = lines_of(table(span, {"links": links, "joints": joints}))
        new = lines_of(table(span, {"parts": table(span, {part.name: part.entry})}))
        new += lines_of(table(span, {"use": table(span, part.uses)}))
        flat = len(part.uses) * once
        is_short = flat - new >= max(_MIN_SAVED, _SAVED_BY_USE * len(part.uses)) and new <= _MAX_SHARE * flat
        return is_short and len(part.entry.get("params", ())) < once

    def _add_homes(self, part: Part, rows: Sequence[Sequence[Node]], names: Mapping[str, str]) -> None:
        first = min(range(len(rows)), key=lambda index: rows[index][0].rank[0])
        for index, (row, use) in enumerate(zip(rows, part.uses, strict=True)):
            for offset, node in enumerate(row):
                model = rows[0][offset]
                for section, name, own in (("links", node.link, model.link), ("joints", node.joint, model.joint)):
                    path: Path = ("parts", part.name, section, names[own])
                    part.homes[section, name] = Home(path, (*self.path, "use", use), index == first, not offset)

    def _move_comments(self) -> None:
        """Move comments about repeated links and joints.

        Those of all instances, and those inside the first one, move into the part; others move above the use.
        """
        depth, comments = len(self.path), self.result.comments
        homes = [
            self.homes.get(one.path[depth : depth + 2]) if one.path[:depth] == self.path else None for one in comments
        ]
        paths: list[Path] = [
            (*home.path, *one.path[depth + 2 :]) if home else tuple(one.path)
            for one, home in zip(comments, homes, strict=True)
        ]
        counts = Counter((one.text, path) for one, path, home in zip(comments, paths, homes, strict=True) if home)
        moved: list[Comment] = []
        for comment, path, home in zip(comments, paths, homes, strict=True):
            is_about_entry = len(comment.path) == depth + 2 and comment.where != INSIDE
            if home and counts[comment.text, path] > 1:
                if not any(one.text == comment.text and one.path == path for one in moved):
                    moved.append(replace(comment, path=path))
            elif home and not (home.is_first and not (home.is_top and is_about_entry)):
                moved.append(replace(comment, path=home.use, where=BEFORE))
            else:
                moved.append(replace(comment, path=path))
        self.result.comments = moved


def _sections(
    nodes: Sequence[Node], terms: Sequence[Mapping[Path, Any]], names: Mapping[str, str], span: Span
) -> tuple[Map, Map]:
    """Return the links and the joints of a subtree with new names, in the order of the source."""
    links, joints = Map(span), Map(span)
    numbered = list(enumerate(nodes))
    for index, node in sorted(numbered, key=lambda one: one[1].rank[0]):
        links.put(names[node.link], _filled(node.entries["link"], terms[index], ("link",), names=names), span, span)
    for index, node in sorted(numbered, key=lambda one: one[1].rank[1]):
        moves = _filled(node.entries["joint"], terms[index], ("joint",), node.kind in ROTATING)
        carrier = names[node.carrier] if index else MOUNT
        entry = table(span, {"type": node.kind, "parent": carrier, "child": names[node.link]})
        for key, value in moves.items():
            if key != "type" and (index or key not in ("xyz", "rpy")):
                entry.put(key, value, span, moves.value_spans[key])
        joints.put(names[node.joint], entry, span, span)
    return links, joints


def _filled(
    value: Any, terms: Mapping[Path, Any], path: Path, is_rotating: bool = False, names: Mapping[str, str] | None = None
) -> Any:
    """Return a copy of a value in which terms replace what differs; angles of joints are in degrees."""
    if path in terms:
        return terms[path]
    if isinstance(value, Map):
        copy = Map(value.span)
        for step, key, item in steps(value, path):
            filled = _filled(item, terms, (*path, step), is_rotating, names)
            own = names[key] if names and len(path) == 2 and path[-1] in MARKS else key
            copy.put(own, filled, value.key_spans[key], value.value_spans[key])
        return copy
    if isinstance(value, Seq):
        items = Seq(value.span)
        for index, item in enumerate(value):
            items.put(_filled(item, terms, (*path, index), is_rotating), value.value_spans[index])
        return items
    unit = joint_unit(*map(str, path[1:])) if is_rotating and is_number(value) and value else ""
    text = in_degrees(value, unit) if unit else ""
    return Quantity.parse(text) if text else value


def _declaration(parameter: Parameter, span: Span) -> Map:
    if parameter.kind == "sign":
        return table(span, {"type": "integer", "one_of": _tree([1, -1], span)})
    entry = {} if parameter.kind == "any" else {"type": parameter.kind}
    if parameter.default is not None:
        entry["default"] = _tree(parameter.default, span)
    return table(span, entry)


def _tree(value: Any, span: Span) -> Any:
    """Return a value of a parameter as a tree, without keys that have their default."""
    if isinstance(value, Mapping):
        items = {key: _tree(item, span) for key, item in value.items()}
        return table(span, {key: item for key, item in items.items() if not has_default(key, item)})
    if isinstance(value, (list, tuple)):
        items_of_list = Seq(span)
        for item in value:
            items_of_list.put(_tree(item, span), span)
        return items_of_list
    return value


def has_default(key: str, value: Any) -> bool:
    """Return True if a key of a link or joint has its default value."""
    default = default_of_key(key)
    return default is not None and bool(value == default)

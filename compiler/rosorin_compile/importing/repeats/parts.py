"""Find subtrees of equal shape, and move them into parts where a part and its uses read better."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from rosorin_compile.formats.imported_robot import BEFORE, INSIDE, Comment, as_tree
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Map, Path

from ..description import free_name, lines_of
from ..layout import Expression, Verbatim
from .nodes import MOUNT, REFERENCES, Node, deep_copy, equal_shapes, is_number, is_pose, mirror_node, nodes_of, table
from .parameters import Parameters
from .part_names import is_left, part_name, split

MAX_PARAMETERS = 6
_MIN_SAVED = 8  # lines in total
_SAVED_BY_USE = 3  # lines that each use has to save
_MAX_SHARE = 0.8  # of the lines without the part
_WORK = 60  # comparisons for each node of the robot, so that the search is linear
_PARAMETER_COST = 4  # expressions that are as hard to read as a parameter, or a mirror


@dataclass
class Part:
    """A part with its uses by name, the names in it by those of its first instance, and how hard it is to read."""

    name: str
    entry: Map
    uses: dict[str, Map]
    names: Mapping[str, str]
    has_prefix: bool
    cost: int


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
    made = _Body(tree, (), result).with_uses()
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
        # By section and name: the path in the part, that of the use, and if it is the top of the first instance.
        self.homes: dict[Path, tuple[Path, Path, bool, bool]] = {}

    def with_uses(self) -> Map:
        """Return the body with uses instead of the links and joints that they make."""
        groups = equal_shapes(self.nodes)
        for number, group in enumerate(groups):
            Progress.step("finding repeated structures", number, len(groups))
            members = [start for start in group if start not in self.covered]
            if len(members) < 2 or self._try(members):
                continue
            equal: dict[Any, list[int]] = defaultdict(list)
            for start in members:
                equal[self._sizes(start)].append(start)
            for some in equal.values():  # of four legs, those in front may be one part and those behind another
                if 1 < len(some) < len(members):
                    self._try(some)
        if not self.uses:
            return self.body
        made = self.body.copy()
        for section in ("links", "joints"):
            left = self.body[section].copy()
            for name in self.body[section]:
                if (section, name) in self.homes:
                    del left[name]
            made[section] = left
        uses = {name: entry for _, name, entry in sorted(self.uses, key=lambda use: use[0])}
        made.put("use", table(self.body.span, uses), self.body.span, self.body.span)
        self._move_comments()
        return made

    def _sizes(self, start: int) -> tuple[Any, ...]:
        """Return the numbers of a subtree without their signs."""
        row = self.nodes[start : start + self.nodes[start].size]
        values = [item for node in row[1:] for item in node.values.items()]
        values += [(path, value) for path, value in row[0].values.items() if not is_pose(path)]
        return tuple((path, abs(value)) for path, value in values if is_number(value))

    def _try(self, members: list[int]) -> bool:
        """Make a part of instances, all without a mirror or those of the other side with one, if it is worth it."""
        base = next((start for start in members if is_left(self.nodes[start].link)), members[0])
        members = [base, *(start for start in members if start != base)]
        rows = [self.nodes[start : start + self.nodes[base].size] for start in members]
        choices = [[""] * len(rows)]
        for mirror in ("y", "x"):
            place: Path = ("joint", "xyz", "xyz".index(mirror))
            sides = [row[0].values[place] * rows[0][0].values[place] for row in rows]
            choices += [[mirror if side < 0 else "" for side in sides]] if min(sides) < 0 else []
        made = [self._make(rows, choice) for choice in choices]
        part = min((one for one in made if one is not None), key=lambda one: one.cost, default=None)
        if part is None or not self._is_worth(rows[0], part):
            return False
        self.result.names.add(part.name)
        if part.has_prefix:
            part.entry = _Body(part.entry, ("parts", part.name), self.result).with_uses()
        self.result.parts[part.name] = part.entry
        first = min(rows, key=lambda row: row[0].rank[0])
        for start, row, use in zip(members, rows, part.uses, strict=True):
            self.uses.append((row[0].rank[1], use, part.uses[use]))
            self.covered.update(range(start, start + len(row)))
            for model, node in zip(rows[0], row, strict=True):
                for section, name, own in (("links", node.link, model.link), ("joints", node.joint, model.joint)):
                    path: Path = ("parts", part.name, section, part.names[own])
                    self.homes[section, name] = path, (*self.path, "use", use), row is first, node is row[0]
        return True

    def _make(self, rows: Sequence[list[Node]], mirrors: Sequence[str]) -> Part | None:
        """Return a part made of instances, or None if the language cannot express it."""
        size = len(rows[0])
        self.result.budget -= len(rows) * size
        names = [[name for node in row for name in node.names] for row in rows]
        parted = split(list(zip(*names, strict=True))) if self.result.budget >= 0 else None
        if parted is None:
            return None
        name = free_name(part_name(parted.uses, parted.rests), self.result.names)
        uses, taken = parted.uses, {use for _, use, _ in self.uses}
        if parted.first:
            uses = [f"{name}_{sorted(parted.first).index(number) + 1}" for number in parted.first]
        if taken.intersection(uses):
            uses = [f"{use}_{name}" for use in uses]
            if taken.intersection(uses) or not all(parted.prefixes):
                return None
        parameters = Parameters(parted.uses, parted.prefixes, list(map(bool, mirrors)), parted.first)
        renames = [dict(zip(some, parted.rests, strict=True)) for some in names]
        terms: list[dict[Path, Any]] = []
        for offset, nodes in enumerate(zip(*rows, strict=True)):
            values = [mirror_node(node, mirror, not offset) for node, mirror in zip(nodes, mirrors, strict=True)]
            terms.append({})
            for path in (one for one in REFERENCES if one in values[0]):
                targets = {renamed.get(some[path]) for renamed, some in zip(renames, values, strict=True)}
                if len(targets) > 1 or None in targets:
                    return None
                terms[-1][path] = targets.pop()
            for section, owner in (("link", nodes[0].link), ("joint", nodes[0].joint)):
                compared = {
                    path: [some[path] for some in values]
                    for path in values[0]
                    if path[0] == section and path not in terms[-1] and (offset or not is_pose(path))
                }
                terms[-1] |= parameters.replace(compared, renames[0][owner], nodes[0].kind)
        if len(parameters.given) > min(MAX_PARAMETERS, size + 2):
            return None
        entries = {}
        for index, (use, prefix) in enumerate(zip(uses, parted.prefixes, strict=True)):
            entry: dict[str, Any] = {"part": name, **({} if prefix == f"{use}_" else {"prefix": prefix})}
            entries[use] = self._use(entry, rows[index][0], mirrors[index], parameters, index)
        cost = _PARAMETER_COST * (len(parameters.given) + any(mirrors)) + parameters.count
        made = self._entry(rows[0], terms, renames[0], parameters)
        return Part(name, made, entries, renames[0], all(parted.prefixes), cost)

    def _entry(
        self, nodes: list[Node], terms: list[dict[Path, Any]], names: Mapping[str, str], parameters: Parameters
    ) -> Map:
        """Return an entry of ``parts``."""
        span = self.result.span
        links, joints = _sections(nodes, terms, names, span)
        params: dict[str, Any] = {}
        for one in parameters.given:
            params[one.name] = {} if one.kind == "any" else {"type": one.kind}
            params[one.name] |= {} if one.default is None else {"default": one.default}
            if one.kind == "sign":
                params[one.name] = {"type": "integer", "one_of": [1, -1]}
        lets = {one.name: Expression("${-1 if mirrored else 1}") for one in parameters.all if one.is_derived}
        sections = {"params": as_tree(params, span), "let": table(span, lets), "links": links, "joints": joints}
        return table(span, {key: value for key, value in sections.items() if value})

    def _use(self, entry: dict[str, Any], root: Node, mirror: str, parameters: Parameters, index: int) -> Map:
        """Return an entry of ``use``; ``index`` is that of the instance, ``root`` its first node."""
        span, joint = self.result.span, root.entries["joint"]
        entry["parent"] = root.carrier
        entry |= {key: joint[key] for key in ("xyz", "rpy") if any(joint[key])}
        if mirror:
            entry["mirror"] = Verbatim(mirror)
        pairs = [(one.name, one.values[index], one.default) for one in parameters.given]
        given = {name: value for name, value, default in pairs if default is None or repr(value) != repr(default)}
        if given:
            entry["with"] = as_tree(given, span)
        return table(span, entry)

    def _is_worth(self, nodes: list[Node], part: Part) -> bool:
        """Return True if a part and its uses are shorter than the subtrees by enough, and the part is not trivial."""
        span = self.result.span
        names = {name: name for node in nodes for name in node.names}
        links, joints = _sections(nodes, [{}] * len(nodes), names, span)
        once = lines_of(table(span, {"links": links, "joints": joints}))
        new = lines_of(table(span, {"parts": table(span, {part.name: part.entry})}))
        new += lines_of(table(span, {"use": table(span, part.uses)}))
        flat = len(part.uses) * once
        is_short = flat - new >= max(_MIN_SAVED, _SAVED_BY_USE * len(part.uses)) and new <= _MAX_SHARE * flat
        return is_short and len(part.entry.get("params", ())) < once

    def _move_comments(self) -> None:
        """Move comments about repeated links and joints.

        Those inside the first instance move into the part, with all that are equal; others move above the use.
        """
        depth, moved = len(self.path), list[Comment]()
        for comment in self.result.comments:
            home = self.homes.get(comment.path[depth : depth + 2]) if comment.path[:depth] == self.path else None
            if home is None:
                moved.append(comment)
                continue
            path, use, is_first, is_top = home
            inner = replace(comment, path=(*path, *comment.path[depth + 2 :]))
            is_about_top = is_top and len(comment.path) == depth + 2 and comment.where != INSIDE
            if is_first and not is_about_top:
                moved.append(inner)
            elif not any(one.text == inner.text and one.path == inner.path for one in moved):
                moved.append(replace(comment, path=use, where=BEFORE))
        self.result.comments = moved


def _sections(
    nodes: Sequence[Node], terms: Sequence[Mapping[Path, Any]], names: Mapping[str, str], span: Span
) -> tuple[Map, Map]:
    """Return the links and the joints of a subtree with new names, in the order of the source.

    ``terms`` are expressions that replace values of a node.
    """
    links, joints = Map(span), Map(span)
    filled = []
    for node, replacements in zip(nodes, terms, strict=True):
        filled.append((node, deep_copy(node.entries)))
        for path, term in replacements.items():
            holder = filled[-1][1]
            for step in path[:-1]:
                holder = holder[step]
            holder[path[-1]] = term
    for node, entries in sorted(filled, key=lambda one: one[0].rank[0]):
        links.put(names[node.link], entries["link"], span, span)
    for node, entries in sorted(filled, key=lambda one: one[0].rank[1]):
        is_top, moves = node is nodes[0], entries["joint"]
        carrier = MOUNT if is_top else names[node.carrier]
        joint = table(span, {"type": node.kind, "parent": carrier, "child": names[node.link]})
        for key, value in moves.items():
            if key != "type" and not (is_top and key in ("xyz", "rpy")):
                joint.put(key, value, span, moves.value_spans[key])
        joints.put(names[node.joint], joint, span, span)
    return links, joints

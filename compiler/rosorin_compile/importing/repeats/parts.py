"""Find repeated subtrees, and move them into parts if that makes the description shorter.

Links in a part have short names. Each instance (entry of ``use``) adds a prefix: ``left_`` and ``wheel`` make
``left_wheel``. If the differing word is not at the beginning (``hip_FL_joint``), names contain ``${name}`` instead.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rosorin_compile.formats.imported_robot import BEFORE, INSIDE, Comment, ImportedRobot
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Path

from ..description import Expression, Verbatim, free_name, is_number, lines_of
from .nodes import MOUNT, REFERENCES, Node, Parameters, deep_copy, equal_shapes, is_pose, mirror_node, nodes_of

MAX_PARAMETERS = 6
_MIN_SAVED = 8  # minimum number of lines that a part saves in total
_SAVED_BY_USE = 3  # minimum number of lines that a part saves per instance
_MAX_SHARE = 0.8  # maximum number of lines with the part, relative to the number of lines without the part
_WORK = 60  # maximum number of comparisons per link of the robot, so that the search takes linear time
_PARAMETER_COST = 4  # complexity of a parameter or of the key "mirror"; that of an expression is 1

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^A-Za-z\d]")
_SEPARATORS = "_-./: "
_SIDE = re.compile(r"left|right|l|r|[fmrhb]?[lr]|[lr][fmrhb]|front|rear|back|middle|mid|hind|upper|lower|\d+")
_LEFT = re.compile(r"left|l|[fmrhb]l|l[fmrhb]")
_GENERIC = ("link", "joint", "frame", "body", "base", "geom", "mesh", "fixed", "the", "robot", "jnt", "axis")
_WHOLES = {
    "finger": "finger knuckle phalanx proximal distal metacarpal mcp pip dip tip fingertip",
    "leg": "leg hip thigh calf knee foot ankle shank shin haa hfe kfe coxa femur tibia toe",
    "arm": "arm shoulder elbow forearm upperarm wrist",
    "wheel": "wheel tire tyre hub axle",
}
_PART_OF = {word: whole for whole, words in _WHOLES.items() for word in words.split()}


class Split(NamedTuple):
    """Names and prefixes of the instances of a part, and the names of links and joints inside the part (``rests``)."""

    uses: list[str]
    prefixes: list[str]
    rests: list[str]


@dataclass
class Part:
    """A part with its entries of the section ``use`` by name; a part with a lower ``cost`` is easier to read."""

    name: str
    entry: dict[str, Any]
    uses: dict[str, dict[str, Any]]
    names: Mapping[str, str]  # name in the first instance -> name in the part
    has_prefix: bool
    cost: int


class _Result:
    """The new parts by name, all comments with new paths, and the remaining number of comparisons (``budget``)."""

    def __init__(self, imported: ImportedRobot) -> None:
        self.comments = list(imported.comments)
        self.budget = _WORK * len(imported.whole.get("links") or ())
        self.parts: dict[str, Mapping[str, Any]] = {}


def with_parts(imported: ImportedRobot) -> ImportedRobot:
    """Replace repeated links and joints with parts and instances; return ``imported`` unchanged if nothing repeats."""
    result, made = _Result(imported), imported.whole.copy()
    made.update(_Body(imported.whole, (), result).with_uses())
    made["parts"] = result.parts
    return imported._replace(tree=made, comments=result.comments) if result.parts else imported


class _Body:
    """Moves repeated subtrees of a robot, or of the part at ``path``, into new parts."""

    def __init__(self, body: Mapping[str, Any], path: Path, result: _Result) -> None:
        self.body, self.path, self.result = body, path, result
        self.nodes = nodes_of(body)
        self.uses: list[tuple[int, str, dict[str, Any]]] = []  # ``use``: (joint index in the source, name, entry)
        self.covered: set[int] = set()
        # (section, name) -> (path in the part, path of the instance, is in the first instance, is in the root node)
        self.homes: dict[Path, tuple[Path, Path, bool, bool]] = {}

    def with_uses(self) -> Mapping[str, Any]:
        """Return the robot or part with repeated links and joints replaced by entries of the section ``use``."""
        groups = equal_shapes(self.nodes)
        for number, group in enumerate(groups):
            Progress.step("finding repeated structures", number, len(groups))
            members = [start for start in group if start not in self.covered]
            if len(members) < 2 or self._try(members):
                continue
            equal: dict[Any, list[int]] = defaultdict(list)  # equal instances, such as the front legs of a robot
            for start in members:
                row = self.nodes[start : start + self.nodes[start].size]
                numbers = [item for node in row for item in node.values.items() if is_number(item[1])]
                numbers = [(path, abs(value)) for path, value in numbers if not is_pose(path)]
                equal[tuple(numbers)].append(start)
            for some in equal.values():
                if 1 < len(some) < len(members):
                    self._try(some)
        if not self.uses:
            return self.body
        made = dict(self.body)
        for section in ("links", "joints"):
            made[section] = {
                name: entry for name, entry in self.body[section].items() if (section, name) not in self.homes
            }
        made["use"] = {name: entry for _, name, entry in sorted(self.uses, key=lambda use: use[0])}
        self._move_comments()
        return made

    def _try(self, members: list[int]) -> bool:
        """Try to make a part of equal subtrees, possibly mirrored; return False if that does not save enough lines."""
        base = next((start for start in members if any(map(_LEFT.fullmatch, _words(self.nodes[start].link)))), None)
        members = sorted(members, key=lambda start: start != base)
        rows = [self.nodes[start : start + self.nodes[start].size] for start in members]
        choices = [[""] * len(rows)]
        for mirror in ("y", "x"):
            place: Path = ("joint", "xyz", "xyz".index(mirror))
            sides = [row[0].values[place] * rows[0][0].values[place] for row in rows]
            choices += [[mirror if side < 0 else "" for side in sides]] if min(sides) < 0 else []
        made = [self._make(rows, choice) for choice in choices]
        part = min((one for one in made if one is not None), key=lambda one: one.cost, default=None)
        if part is None or not self._is_worth(rows[0], part):
            return False
        self.result.parts[part.name] = part.entry
        if part.has_prefix:
            self.result.parts[part.name] = _Body(part.entry, ("parts", part.name), self.result).with_uses()
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
        """Make a part of subtrees (``rows``), or return None if the description language cannot express it."""
        self.result.budget -= len(rows) * len(rows[0])
        names = [[name for node in row for name in node.names] for row in rows]
        parted = split(list(zip(*names, strict=True))) if self.result.budget >= 0 else None
        if parted is None:
            return None
        name = free_name(_part_name(parted.uses, parted.rests), self.result.parts)
        uses, taken = parted.uses, {use for _, use, _ in self.uses}
        if taken.intersection(uses):
            uses = [f"{use}_{name}" for use in uses]
            if taken.intersection(uses) or not all(parted.prefixes):
                return None
        parameters = Parameters(parted.uses, parted.prefixes, list(map(bool, mirrors)))
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
                terms[-1] |= parameters.replace(compared, renames[0][owner])
        if len(parameters.arguments) > min(MAX_PARAMETERS, len(rows[0]) + 2):
            return None
        entries = {}
        for index, (use, prefix, row) in enumerate(zip(uses, parted.prefixes, rows, strict=True)):
            joint = row[0].entries["joint"]
            entry: dict[str, Any] = {"part": name, **({} if prefix == f"{use}_" else {"prefix": prefix})}
            entry |= {"parent": row[0].carrier, **{key: joint[key] for key in ("xyz", "rpy") if any(joint[key])}}
            entry |= {"mirror": Verbatim(mirrors[index])} if mirrors[index] else {}
            values_of_use = {
                one.name: one.values[index]
                for one in parameters.arguments
                if one.default is None or repr(one.values[index]) != repr(one.default)
            }
            entry |= {"with": values_of_use} if values_of_use else {}
            entries[use] = entry
        params = {one.name: one.entry for one in parameters.arguments}
        made = {"params": params, "let": parameters.derived_values, **_sections(rows[0], terms, renames[0])}
        made = {key: value for key, value in made.items() if value}
        cost = _PARAMETER_COST * (len(parameters.arguments) + any(mirrors)) + parameters.count
        return Part(name, made, entries, renames[0], all(parted.prefixes), cost)

    def _is_worth(self, nodes: list[Node], part: Part) -> bool:
        names = {name: name for node in nodes for name in node.names}
        once = lines_of(_sections(nodes, [{}] * len(nodes), names))
        new = lines_of({"parts": {part.name: part.entry}}) + lines_of({"use": part.uses})
        flat = len(part.uses) * once
        is_short = flat - new >= max(_MIN_SAVED, _SAVED_BY_USE * len(part.uses)) and new <= _MAX_SHARE * flat
        return is_short and len(part.entry.get("params", ())) < once

    def _move_comments(self) -> None:
        """Move comments on the first instance into the part, and comments on others to their entries of ``use``."""
        depth, moved = len(self.path), list[Comment]()
        for comment in self.result.comments:
            home = self.homes.get(comment.path[depth : depth + 2]) if comment.path[:depth] == self.path else None
            if home is None:
                moved.append(comment)
                continue
            path, use, is_first, is_top = home
            inner = comment._replace(path=(*path, *comment.path[depth + 2 :]))
            is_about_top = is_top and len(comment.path) == depth + 2 and comment.where != INSIDE
            if is_first and not is_about_top:
                moved.append(inner)
            elif not any(one.text == inner.text and one.path == inner.path for one in moved):
                moved.append(comment._replace(path=use, where=BEFORE))
        self.result.comments = moved


def _sections(
    nodes: Sequence[Node], terms: Sequence[Mapping[Path, Any]], names: Mapping[str, str]
) -> dict[str, dict[str, Any]]:
    """Return the links and joints of a part: renamed, and with the expressions ``terms`` (by path) as values."""
    filled = [(node, deep_copy(node.entries)) for node in nodes]
    for (_, entries), replacements in zip(filled, terms, strict=True):
        for path, term in replacements.items():
            holder = entries
            for step in path[:-1]:
                holder = holder[step]
            holder[path[-1]] = term
    joints = {}
    for node, entries in sorted(filled, key=lambda one: one[0].rank[1]):
        is_top = node is nodes[0]
        carrier = MOUNT if is_top else names[node.carrier]
        joint = {"type": node.kind, "parent": carrier, "child": names[node.link], **entries["joint"]}
        joints[names[node.joint]] = {key: one for key, one in joint.items() if not (is_top and key in ("xyz", "rpy"))}
    in_order = sorted(filled, key=lambda one: one[0].rank[0])
    return {"links": {names[node.link]: entries["link"] for node, entries in in_order}, "joints": joints}


def split(names: Sequence[Sequence[str]]) -> Split | None:
    """Split names into instance names and names inside the part, or return None if that is impossible.

    ``names`` has a row for each link or joint of the part, with its name in each instance.

    >>> split([["left_wheel", "right_wheel"], ["left_axle", "right_axle"]])
    Split(uses=['left', 'right'], prefixes=['left_', 'right_'], rests=['wheel', 'axle'])
    >>> split([["hip_FL", "hip_FR"], ["thigh_FL", "thigh_FR"]]).rests
    ['hip_${name}', 'thigh_${name}']
    """
    ends: list[tuple[str, str]] = []  # text before and after the differing text, for each row
    uses: list[str] = []  # the differing text, for each instance
    for row in names:
        pieces = [_WORD.findall(name) for name in row]
        differing = [place for place, some in enumerate(zip(*pieces, strict=False)) if len(set(some)) > 1]
        if len(set(map(len, pieces))) > 1 or not differing or any("$" in name for name in row):
            return None
        first, last = differing[0], differing[-1] + 1
        between = ["".join(some[first:last]) for some in pieces]
        if len(set(between)) < len(row) or uses not in ([], between):
            return None
        uses = between
        ends.append(("".join(pieces[0][:first]), "".join(pieces[0][last:])))
    word = _WORD.findall(ends[0][0])[-1:]
    while word and all(head.endswith(word[0]) for head, _ in ends):  # leg1, leg2: "leg" is part of the instance name
        uses = [f"{word[0]}{use}" for use in uses]
        ends = [(head.removesuffix(word[0]), tail) for head, tail in ends]
        word = _WORD.findall(ends[0][0])[-1:]
    separators = uses[0][: len(uses[0]) - len(uses[0].lstrip(_SEPARATORS))]
    if not any(head for head, _ in ends) and not separators:
        marks = {tail[:1] for _, tail in ends}
        mark = min(marks) if len(marks) == 1 and marks <= set(_SEPARATORS) else ""
        rests = [tail.removeprefix(mark) for _, tail in ends]
        if all(rests) and MOUNT not in rests:
            return Split(uses, [use + mark for use in uses], rests)
    composed: list[str] = [Expression(f"{head}{separators}${{name}}{tail}") for head, tail in ends]
    return Split([use.removeprefix(separators) for use in uses], [""] * len(uses), composed)


def _words(name: str) -> list[str]:
    return [word.lower() for word in _WORD.findall(re.sub(r"\$\{[^}]*\}", "_", name)) if word.isalnum()]


def _part_name(uses: Sequence[str], rests: Sequence[str]) -> str:
    """Return a name for a part, such as "wheel" for links and joints "wheel_link" and "wheel_joint"."""

    def specific(name: str) -> list[str]:
        return [word for word in _words(name) if not _SIDE.fullmatch(word) and word not in _GENERIC]

    is_large = len(rests) > 2
    for group in (uses, rests):
        common = [word for word in specific(group[0]) if len(word) > 2 and all(word in _words(name) for name in group)]
        if common:
            return _PART_OF.get(common[-1], common[-1]) if is_large else common[-1]
    votes = Counter(_PART_OF[word] for name in rests for word in set(_words(name)) if word in _PART_OF)
    if votes and is_large:
        return votes.most_common(1)[0][0]
    words = [word for word in specific(rests[0]) if len(word) > 1]
    return words[-1] if words else "limb" if is_large else "piece"

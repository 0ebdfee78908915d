"""Writing: parts and their uses as the tree of a description; comments go with what they spoke of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import Comment
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Path, Seq

from ..layout import ROTATING, Expression, Verbatim, joint_unit
from .finding import Body, Part, Use
from .forms import Form, Leaf, Node, flat, says_nothing
from .names import MOUNT, SIDES, is_ahead
from .parameters import Parameter, Term, in_unit


class Folded(NamedTuple):
    """The tree of a description with parts, and the comments at their places in it."""

    tree: Map
    comments: Sequence[Comment]


def part_map(part: Part, span: Span) -> Map:
    """Return an entry of ``parts``."""
    made = Map(span)
    params = Map(span)
    if part.counts:
        _put(params, "first", _declared("integer", "the first of its numbers", span))
    for one in part.parameters.given:
        _put(params, one.name, _parameter(one, part, span))
    own = Map(span)
    for one in part.parameters.all:
        if one.own:
            _put(own, one.name, Expression("${-1 if mirrored else 1}"))
    links, joints = sections(part.nodes, span)
    uses = Map(span)
    for use in part.uses:
        _put(uses, use.name, use_map(use, span))
    for key, value in (("params", params), ("let", own), ("links", links), ("joints", joints), ("use", uses)):
        if value:
            _put(made, key, value)
    return made


def _parameter(one: Parameter, part: Part, span: Span) -> Map:
    """Return the declaration of a parameter."""
    if one.kind != "sign":
        made = _declared(one.kind, "", span)
        usual = one.default
        if usual is not None:
            _put(made, "default", _lean(_value(usual, span, 0)))
        return made
    made = _declared("integer", "", span)
    choice = Seq(span)
    for sign in (1, -1):
        choice.put(sign, span)
    _put(made, "one_of", choice)
    if one.hint[0] in SIDES:
        first, second = SIDES[one.hint[0]]
        ahead = is_ahead(one.hint[0], part.parameters.uses[0]) == (one.values.values[0] == 1)
        _put(made, "help", f"1 {first}, -1 {second}" if ahead else f"1 {second}, -1 {first}")
    return made


def _declared(kind: str, help: str, span: Span) -> Map:
    made = Map(span)
    if kind not in ("any", "sign"):
        _put(made, "type", kind)
    if help:
        _put(made, "help", help)
    return made


def use_map(use: Use, span: Span) -> Map:
    """Return an entry of ``use``."""
    made = Map(span)
    _put(made, "part", use.part.name)
    if use.prefix is not None:
        _put(made, "prefix", use.prefix)
    _put(made, "parent", use.parent)
    for key in ("xyz", "rpy"):
        value = use.pose[key]
        if not _is_zero(value):
            _put(made, key, _value(value, span, 0, "rpy" if key == "rpy" else ""))
    if use.mirror:
        _put(made, "mirror", Verbatim(use.mirror))
    usual = {one.name: one.default for one in use.part.parameters.given}
    given = Map(span)
    for name, form in use.given.items():
        if usual.get(name) is None or not _same(form, usual[name]):
            _put(given, name, _lean(_value(form, span, 0)))
    if given:
        _put(made, "with", given)
    return made


def _lean(value: Any) -> Any:
    """Return a table of inertia without what is zero when nothing is said."""
    if not isinstance(value, Map):
        return value
    made = Map(value.span)
    for key, item in value.items():
        if not says_nothing(key, item):
            made.put(key, _lean(item), value.key_spans[key], value.value_spans[key])
    return made


def _is_zero(entry: Form) -> bool:
    return isinstance(entry, list) and all(isinstance(one, Leaf) and not any(one.values) for one in entry)


def _same(one: Form, other: Form) -> bool:
    """Say whether a form of any width is a value in all its instances."""
    try:
        pairs = list(zip(flat(one), flat(other), strict=True))
    except (AttributeError, TypeError, ValueError):
        return False  # a term
    return all(value == usual.values[0] for leaf, usual in pairs for value in leaf.values)


def sections(nodes: Sequence[Node], span: Span) -> tuple[Map, Map]:
    """Return the links and the joints of nodes, in the order of the source."""
    links, joints = Map(span), Map(span)
    for node in sorted(nodes, key=lambda one: one.rank[0]):
        _put(links, node.link, _value(node.body, span, 0))
    by_joint = sorted((node for node in nodes if node.joint), key=lambda one: one.rank[1])
    for node in by_joint:
        _put(joints, node.joint, _joint(node, span))
    return links, joints


def _joint(node: Node, span: Span) -> Map:
    made = Map(span)
    kind = node.moves["type"].values[0]
    _put(made, "type", kind)
    _put(made, "parent", node.carrier)
    _put(made, "child", node.link)
    for key, value in node.pose.items():
        _put(made, key, _value(value, span, 0, key))
    for key, value in node.moves.items():
        if key != "type":
            _put(made, key, _value(value, span, 0, key, kind in ROTATING))
    return made


def _value(entry: Form, span: Span, index: int, under: str = "", turns: bool = False) -> Any:
    """Return a form as the tree has it, with the values of one instance; angles of joints in degrees."""
    if isinstance(entry, Term):
        return entry.expression()
    if isinstance(entry, Leaf):
        return entry.values[index]
    if isinstance(entry, list):
        made = Seq(span)
        for item in entry:
            made.put(_value(_in_degrees(item, "deg" if under == "rpy" else ""), span, index), _span(item, span))
        return made
    table = Map(span)
    for key, item in entry.items():
        unit = joint_unit(under, key) if turns else ""
        value = _value(_in_degrees(item, unit), span, index, key, turns)
        table.put(key, value, span, _span(item, span))
    return table


def _in_degrees(item: Form, unit: str) -> Form:
    return in_unit(item, unit) if unit and isinstance(item, Leaf) and item.is_number else item


def _span(item: Form, span: Span) -> Span:
    return (item.spans[0] or span) if isinstance(item, Leaf) else span


def table(span: Span, entries: Mapping[str, Any]) -> Map:
    """Return a mapping of the tree."""
    made = Map(span)
    for key, value in entries.items():
        _put(made, key, value)
    return made


def _put(into: Map, key: str, value: Any) -> None:
    span = getattr(value, "span", into.span)
    into.put(key, value, span, span)


def folded(tree: Map, body: Body, comments: Sequence[Comment]) -> Folded:
    """Return the tree of a robot in which the parts that were found take the place of what they make."""
    gone = {name for use in body.uses for node in _all_nodes(use.part) for name in node.origins}
    links = {link for link, _ in gone}
    joints = {joint for _, joint in gone}
    made = Map(tree.span, tree.via)
    parts, uses = Map(tree.span), Map(tree.span)
    for part in dict.fromkeys(part for use in body.uses for part in use.part.all()):
        _put(parts, part.name, part_map(part, tree.span))
    for use in body.uses:
        _put(uses, use.name, use_map(use, tree.span))
    for key, value in tree.items():
        left = value
        if key in ("links", "joints"):
            left = _without(value, links if key == "links" else joints)
        made.put(key, left, tree.key_spans[key], tree.value_spans[key])
    _put(made, "parts", parts)
    _put(made, "use", uses)
    return Folded(made, _moved(tree, body, comments))


def _all_nodes(part: Part) -> Iterator[Node]:
    for one in part.all():
        yield from one.nodes


def _without(section: Map, names: set[str]) -> Map:
    made = Map(section.span, section.via)
    for key, value in section.items():
        if key not in names:
            made.put(key, value, section.key_spans[key], section.value_spans[key])
    return made


class _Home(NamedTuple):
    """Where the comments of an entry go: the entry of a part, or the use that makes it.

    ``first`` says that it is that of the first instance in the source, ``top`` that it is what carries the part.
    """

    part: Path
    use: Path
    first: bool
    top: bool


def _moved(tree: Map, body: Body, comments: Sequence[Comment]) -> list[Comment]:
    """Return the comments at the places where what they spoke of is now.

    What is said in the first instance stands in the part; but above what carries the part, and in the others unless the
    first says the same, it stands above the use.
    """
    homes = _homes(tree, body)
    placed = []
    said: dict[tuple[str, Path, str], set[bool]] = {}
    for comment in comments:
        home = homes.get((str(comment.path[0]), str(comment.path[1]))) if len(comment.path) > 1 else None
        moved = replace(comment, path=(*home.part, *comment.path[2:])) if home else comment
        placed.append((moved, home))
        if home:
            said.setdefault((moved.text, moved.path, moved.where), set()).add(home.first)
    made = []
    for comment, home in placed:
        shared = home is not None and len(said[comment.text, comment.path, comment.where]) > 1
        above = (
            home is not None and home.top and len(comment.path) == len(home.part) and comment.where != Comment.INSIDE
        )
        if home is None or (home.first and (shared or not above)):
            made.append(comment)
        elif not shared:
            made.append(replace(comment, path=home.use, where=Comment.BEFORE))
    return made


def _homes(tree: Map, body: Body) -> dict[tuple[str, str], _Home]:
    """Return where the comments of each link and joint go that a use makes now."""
    order = {name: number for number, name in enumerate(tree["links"])}
    homes: dict[tuple[str, str], _Home] = {}
    for part in dict.fromkeys(use.part for use in body.uses):
        names = part.cut.uses
        for inner in part.all():
            for node in inner.nodes:
                first = min(range(len(node.origins)), key=lambda index: order[node.origins[index][0]])
                for index, (link, joint) in enumerate(node.origins):
                    use: Path = ("use", names[index % len(names)])
                    top = inner is part and node.carrier == MOUNT
                    homes["links", link] = _Home((*_part(inner), "links", node.link), use, index == first, top)
                    homes["joints", joint] = _Home((*_part(inner), "joints", node.joint), use, index == first, top)
    return homes


def _part(part: Part) -> Path:
    return "parts", part.name

"""Write parts and their uses into the tree of a description; comments move with what they describe."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.imported import BEFORE, INSIDE, Comment, Imported
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import Quantity

from ..key_order import default_of_key
from ..layout import ROTATING, Expression, Verbatim, in_degrees, joint_unit

if TYPE_CHECKING:
    from .find_parts import Part, Use
from .nodes import Node, is_number, steps, table
from .parameters import GIVEN, Parameter
from .part_names import MOUNT


def part_entry(part: Part, span: Span) -> Map:
    """Return an entry of ``parts``."""
    parameters = part.parameters
    links, joints = sections(part.nodes, span)
    entry = {
        "params": table(span, {one.name: _declaration(one, span) for one in parameters.given}),
        "let": table(
            span, {one.name: Expression("${-1 if mirrored else 1}") for one in parameters.all if one.is_derived}
        ),
        "links": links,
        "joints": joints,
        "use": table(span, {use.name: use_entry(use, span) for use in part.uses}),
    }
    return table(span, {key: value for key, value in entry.items() if value})


def _declaration(parameter: Parameter, span: Span) -> Map:
    if parameter.kind == "sign":
        return table(span, {"type": "integer", "one_of": _tree([1, -1], span)})
    entry = {} if parameter.kind == "any" else {"type": parameter.kind}
    if parameter.default is not None:
        entry["default"] = _tree(parameter.default, span)
    return table(span, entry)


def use_entry(use: Use, span: Span) -> Map:
    """Return an entry of ``use``."""
    entry: dict[str, Any] = {"part": use.part.name}
    if use.prefix is not None:
        entry["prefix"] = use.prefix
    entry["parent"] = use.parent
    for key in ("xyz", "rpy"):
        pose = _filled(use.pose[key], use.terms, (key,))
        if any(pose):
            entry[key] = pose
    if use.mirror:
        entry["mirror"] = Verbatim(use.mirror)
    given = {}
    for parameter in use.part.parameters.given:
        value, path = use.given[parameter.name], (GIVEN, parameter.name)
        is_default = parameter.default is not None and repr(value) == repr(parameter.default)
        if not is_default or any(term[:2] == path for term in use.terms):
            given[parameter.name] = _filled(_tree(value, span), use.terms, path)
    if given:
        entry["with"] = table(span, given)
    return table(span, entry)


def sections(nodes: Sequence[Node], span: Span) -> tuple[Map, Map]:
    """Return the links and the joints of nodes, in the order of the source."""
    links, joints = Map(span), Map(span)
    for node in sorted(nodes, key=lambda node: node.rank[0]):
        links.put(node.link, _filled(node.entries["link"], node.terms, ("link",)), span, span)
    for node in sorted((node for node in nodes if node.joint), key=lambda node: node.rank[1]):
        moves = _filled(node.entries["joint"], node.terms, ("joint",), node.kind in ROTATING)
        entry = Map(span)
        for key, value in {"type": node.kind, "parent": node.carrier, "child": node.link}.items():
            entry.put(key, value, span, span)
        for key, value in moves.items():
            if key != "type" and not (node.carrier == MOUNT and key in ("xyz", "rpy")):
                entry.put(key, value, span, moves.value_spans[key])
        joints.put(node.joint, entry, span, span)
    return links, joints


def _filled(value: Any, terms: Mapping[Path, Any], path: Path, is_rotating: bool = False) -> Any:
    """Return a copy of a value in which terms replace what differs; angles of joints are in degrees."""
    if path in terms:
        return terms[path]
    if isinstance(value, Map):
        copy = Map(value.span)
        for step, key, item in steps(value, path):
            filled = _filled(item, terms, (*path, step), is_rotating)
            copy.put(key, filled, value.key_spans[key], value.value_spans[key])
        return copy
    if isinstance(value, Seq):
        items = Seq(value.span)
        for index, item in enumerate(value):
            items.put(_filled(item, terms, (*path, index), is_rotating), value.value_spans[index])
        return items
    unit = joint_unit(*map(str, path[1:])) if is_rotating and is_number(value) and value else ""
    text = in_degrees(value, unit) if unit else ""
    return Quantity.parse(text) if text else value


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


def with_uses(imported: Imported, tree: Map, uses: Sequence[Use]) -> Imported:
    """Return the robot with uses instead of the links and joints that they make."""
    nodes = [
        node for use in {id(use.part): use for use in uses}.values() for part in use.part.all() for node in part.nodes
    ]
    gone = {"links": set[str](), "joints": set[str]()}
    for node in nodes:
        for link, joint in node.origins:
            gone["links"].add(link)
            gone["joints"].add(joint)
    new = Map(tree.span, tree.via)
    for key, value in tree.items():
        kept = value
        if key in gone:
            kept = Map(value.span, value.via)
            for name, entry in value.items():
                if name not in gone[key]:
                    kept.put(name, entry, value.key_spans[name], value.value_spans[name])
        new.put(key, kept, tree.key_spans[key], tree.value_spans[key])
    parts = {part.name: part_entry(part, tree.span) for use in uses for part in use.part.all()}
    entries = {use.name: use_entry(use, tree.span) for use in uses}
    new.put("parts", table(tree.span, parts), tree.span, tree.span)
    new.put("use", table(tree.span, entries), tree.span, tree.span)
    return imported._replace(tree=new, comments=_moved(imported.comments, tree, uses))


def _moved(comments: Sequence[Comment], tree: Map, uses: Sequence[Use]) -> list[Comment]:
    """Move comments about repeated links and joints.

    Those of all instances, and those inside the first one, move into the part; others move above the use.
    """
    order = {name: number for number, name in enumerate(tree["links"])}
    homes: dict[tuple[Any, ...], tuple[Path, Path, bool, bool]] = {}
    for part in {id(use.part): use.part for use in uses}.values():
        for inner, node in [(some, node) for some in part.all() for node in some.nodes]:
            first = min(range(len(node.origins)), key=lambda index: order[node.origins[index][0]])
            is_top = inner is part and node.carrier == MOUNT
            for index, names in enumerate(node.origins):
                use: Path = ("use", part.split.uses[index * len(part.split.uses) // len(node.origins)])
                for section, name, own in zip(("links", "joints"), names, (node.link, node.joint), strict=True):
                    homes[section, name] = ("parts", inner.name, section, own), use, index == first, is_top
    in_part = Counter(
        (comment.text, (*home[0], *comment.path[2:])) for comment in comments if (home := homes.get(comment.path[:2]))
    )
    moved: list[Comment] = []
    for comment in comments:
        home = homes.get(comment.path[:2])
        path: Path = (*home[0], *comment.path[2:]) if home else tuple(comment.path)
        is_about_entry = len(comment.path) == 2 and comment.where != INSIDE
        if home and in_part[comment.text, path] > 1:
            if not any(one.text == comment.text and one.path == path for one in moved):
                moved.append(replace(comment, path=path))
        elif home and not (home[2] and not (home[3] and is_about_entry)):
            moved.append(replace(comment, path=home[1], where=BEFORE))
        else:
            moved.append(replace(comment, path=path))
    return moved

"""Repeats: what a robot has several times becomes a part, written once and used; equal values get a name.

To be read in this order: ``forms`` (values held side by side), ``names`` (prefix and rest), ``parameters`` (what
differs), ``finding`` (which subtrees are alike, and whether that is worth a part), ``writing`` (the tree with parts),
``values`` (what has a name).
"""

from __future__ import annotations

from rosorin_compile.formats.imported import Imported

from ..description import lines_of, tree_of
from .finding import MAX_SHARE, MIN_SAVED, SAVED_BY_USE, Body, Finder, Instance, Part, Use
from .forms import nodes_of
from .values import copied, with_values
from .writing import Folded, folded, part_map, sections, table, use_map

_ORDERED = ("mjcf",)  # where the order of joints is that of the numbers a controller gives


def with_parts(imported: Imported) -> Imported:
    """Return a robot whose tree has parts and their uses where it had the same several times; else as it is."""
    tree = tree_of(imported)
    body = Body(nodes_of(tree), [""])

    def worth(body: Body, cluster: list[Instance], part: Part, uses: list[Use]) -> bool:
        links, joints = sections([body.nodes[index] for index in cluster[0].nodes], tree.span)
        flat = len(cluster) * lines_of(table(tree.span, {"links": links, "joints": joints}))
        parts = table(tree.span, {one.name: part_map(one, tree.span) for one in part.all()})
        used = table(tree.span, {use.name: use_map(use, tree.span) for use in uses})
        new = lines_of(table(tree.span, {"parts": parts})) + lines_of(table(tree.span, {"use": used}))
        return flat - new >= max(MIN_SAVED, SAVED_BY_USE * len(uses)) and new <= MAX_SHARE * flat

    Finder(len(body.nodes), worth, keeps_order=imported.format in _ORDERED).fold(body)
    made = folded(tree, body, imported.comments) if body.uses else Folded(tree, imported.comments)
    shown = with_values(copied(made.tree))
    if not body.uses and "let" not in shown:
        return imported
    return imported._replace(tree=shown, comments=made.comments)

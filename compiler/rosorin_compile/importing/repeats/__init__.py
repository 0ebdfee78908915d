"""Factor repeated structures of an imported robot into parts, and repeated values into named values.

``nodes`` makes the values of links and joints comparable, ``part_names`` splits their names, ``parameters`` turns
differences into parameters, ``find_parts`` decides what becomes a part, ``write_parts`` builds the tree, and
``named_values`` defines values under ``let``.
"""

from __future__ import annotations

from rosorin_compile.formats.imported import Imported

from ..description import tree_of
from .find_parts import Body, Finder
from .named_values import with_named_values
from .nodes import deep_copy, nodes_of
from .write_parts import with_uses


def with_parts(imported: Imported) -> Imported:
    """Return a robot whose repeated structures are parts and uses; the same object if it has none."""
    tree = tree_of(imported)
    body = Body(nodes_of(tree), [""])
    Finder(tree.span, len(body.nodes)).find(body)
    shown = imported
    if body.uses:
        shown = with_uses(imported, tree, body.uses)
    named = with_named_values(deep_copy(tree_of(shown)))
    return shown if "let" not in named else shown._replace(tree=named)

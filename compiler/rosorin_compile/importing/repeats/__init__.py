"""Factor repeated structures of an imported robot into parts, and repeated values into named values.

``nodes`` makes links and joints comparable, ``part_names`` splits their names, ``parameters`` turns differences into
parameters, ``parts`` decides what becomes a part and writes it, and ``named_values`` defines values under ``let``.
"""

from __future__ import annotations

from rosorin_compile.formats.imported_robot import Imported

from ..description import tree_of
from .named_values import with_named_values
from .nodes import deep_copy
from .parts import with_parts as _with_parts


def with_parts(imported: Imported) -> Imported:
    """Return a robot whose repeated structures are parts and uses; the same object if it has none."""
    tree, comments = _with_parts(tree_of(imported), imported.comments)
    named = with_named_values(deep_copy(tree))
    if "let" in named:
        tree = named
    return imported if tree is imported.tree else imported._replace(tree=tree, comments=comments)

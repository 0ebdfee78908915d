"""Fragments: elements of XML that are kept as they are, compared without white space, comments and order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ..elements_text import canonical, tree_of


def fragments(texts: Sequence[str]) -> Counter[str]:
    """Return each element of some texts in one spelling, and how often it is there; what is no XML as its words."""
    found: Counter[str] = Counter()
    for text in texts:
        try:
            root = tree_of(f"<all>{text}</all>")
        except ValueError:
            found[" ".join(text.split())] += 1
        else:
            found.update(map(canonical, root))
    return found

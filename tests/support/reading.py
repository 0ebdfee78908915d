"""What texts contain, leaf by leaf, as their formats read them."""

from typing import Any

from rosorin_compile.compare.sentences import text_of
from rosorin_compile.compare.walk import Address, Shapes, leaves
from rosorin_compile.formats import FORMATS


def leaves_of(format: str, text: str) -> dict[Address, Any]:
    """Return the leaves of a text by their addresses."""
    read = FORMATS[format].read
    assert read is not None
    found = leaves(read(text))
    return {Address(*thing, quantity): leaf for thing, entry in found.items() for quantity, leaf in entry.items()}


def line(address: Address, leaf: Any) -> str:
    """Return a leaf in a line."""
    if isinstance(leaf, Shapes):
        parts = [solid._replace(rows=()) for solid in leaf.solids()]  # type: ignore[arg-type]
        shapes = (
            " ".join([one.kind, text_of(one.sizes), "at", text_of(one.centre), text_of(one.rgba), *one.words])
            for one in parts
        )
        return f"{' '.join(address)}: {'; '.join(shapes)}"
    return f"{' '.join(address)}: {text_of(leaf)}"

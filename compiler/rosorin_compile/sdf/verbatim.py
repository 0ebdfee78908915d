"""Verbatim: elements of an SDF that stay as they stand, because the language has no word for them.

What means the same in a URDF for Gazebo (plugins, sensors, ...: ``words``) becomes a ``<gazebo>`` of the robot. The
rest stands in an ``<sdf>`` of the entry that it belongs to: of the robot, a link, a joint or a shape. Such an ``<sdf>``
holds what its element in the SDF holds, and no reader of a URDF knows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.urdf.reading import kept
from rosorin_compile.source.tree import Text
from rosorin_compile.source.xml.elements import indented
from rosorin_compile.source.xml.markup import Element

from .scopes import Models, Scope

_SHORT = 80
_NAMING = ("relative_to", "frame", "attached_to", "expressed_in")


def text_of(element: Element, scope: Scope, models: Models) -> str:
    """Return an element as it stands, with the names that a description gives the frames in it."""
    made, start = element.verbatim, element.start
    for inner in reversed(list(element.iter())):
        for name in reversed(_NAMING):
            attribute = inner.attributes.get(name)
            if attribute is None:
                continue
            node = models.find(scope, attribute.value)
            at = attribute.start - start
            if node is not None and node.called and node.called != attribute.value:
                made = f"{made[:at]}{node.called}{made[at + len(attribute.raw) :]}"
            if name == "frame" and inner.tag == "pose":
                where = attribute.name_start - start
                made = f"{made[:where]}relative_to{made[where + len(name) :]}"
    return kept(element, made)


def wrapped(tag: str, texts: Sequence[str], **attributes: str) -> Text:
    """Return elements in an element around them."""
    names = "".join(f" {key}={quoteattr(value)}" for key, value in attributes.items())
    if len(texts) == 1 and "\n" not in texts[0] and len(texts[0]) < _SHORT:
        return Text(f"<{tag}{names}>{texts[0]}</{tag}>")
    return Text("\n".join([f"<{tag}{names}>", *(indented(text, "  ") for text in texts), f"</{tag}>"]))


def keep(entry: dict[str, object], element: Element, text: str) -> None:
    """Add elements to those that an entry has; ``element`` is where they stood."""
    texts = entry.setdefault("urdf_elements", [])
    assert isinstance(texts, list)  # noqa: S101 - it is made here
    texts.append(Placed(text, element.span))

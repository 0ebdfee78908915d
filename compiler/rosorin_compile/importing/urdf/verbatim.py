"""Verbatim: elements that the language has no word for, kept as they stand."""

from __future__ import annotations

import re

from ...elements_text import indented
from ...tree import Text
from ..markup import Element

_LINE_END = re.compile("\r\n|\r")


def kept(element: Element) -> Text:
    """Return an element as text: as it stands, its further lines moved left, where space means nothing.

    A prefix that an element around it declares (``xmlns:sim``) is declared in the text, so that it can stand alone.
    """
    text = _LINE_END.sub("\n", element.verbatim)
    declared = _declared(element)
    if declared:
        at = 1 + len(element.tag)
        text = text[:at] + "".join(f' xmlns:{prefix}="{address}"' for prefix, address in declared) + text[at:]
    return Text(indented(text, ""))


def _declared(element: Element) -> list[tuple[str, str]]:
    """Return the prefixes used in an element that are declared around it, with their addresses."""
    used: dict[str, None] = {}
    own: set[str] = set()
    for inner in element.iter():
        for name in (inner.tag, *inner.attributes):
            prefix, colon, rest = name.partition(":")
            if prefix == "xmlns":
                own.add(rest)
            elif colon:
                used[prefix] = None
    found = []
    for prefix in used:
        above = element.parent
        while above is not None and f"xmlns:{prefix}" not in above.attributes:
            above = above.parent
        if above is not None and prefix not in own:
            found.append((prefix, above.attributes[f"xmlns:{prefix}"].raw.replace('"', "&quot;")))
    return found

"""Fragments: elements of XML that are kept as they are, compared without white space, comments and order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ..diagnostic import Source
from ..importing.markup import Element, MarkupError, parse


def canonical(texts: Sequence[str]) -> Counter[str]:
    """Return each element of some texts in one spelling, and how often it is there; what is no XML as its words."""
    found: Counter[str] = Counter()
    for text in texts:
        try:
            root = parse(Source("", f"<all>{text}</all>")).root
        except MarkupError:
            found[" ".join(text.split())] += 1
        else:
            found.update(_spelled(child) for child in root.children)
    return found


def _spelled(element: Element) -> str:
    """Return an element in one spelling: attributes sorted, one space between words, numbers without spare zeros."""
    attributes = [f' {name}="{_words(found.value)}"' for name, found in sorted(element.attributes.items())]
    inner = _words(element.text) + "".join(map(_spelled, element.children))
    start = f"<{element.tag}{''.join(attributes)}"
    return f"{start}>{inner}</{element.tag}>" if inner else f"{start}/>"


def _words(text: str) -> str:
    return " ".join(map(_word, text.split()))


def _word(word: str) -> str:
    try:
        return word if "_" in word else repr(float(word))
    except ValueError:
        return word

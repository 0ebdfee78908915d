"""Elements of a file in messages and as text that can be alone: their names, their words, what they are like."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator

from ..diagnostics import Span
from ..tree import Text
from .elements import indented
from .markup import TEXT, Element, Remark, Word

_LINE_END = re.compile("\r\n|\r")


def _ancestors(element: Element) -> Iterator[Element]:
    while element.parent is not None:
        element = element.parent
        yield element


def named(element: Element) -> str:
    """Return an element in words: its tag, with its name or that of the element that contains it."""
    name = element.get("name")
    if name:
        return f'<{element.tag} name="{name}">'
    above = next((one for one in _ancestors(element) if one.get("name")), None)
    inside = f' of <{above.tag} name="{above.get("name")}">' if above is not None and above.parent is not None else ""
    return f"<{element.tag}>{inside}"


def shortened(text: str, most: int = 40) -> str:
    """Return a text in quotes, shortened and on one line."""
    text = text if len(text) <= most else f"{text[: most - 3]}..."
    return f'"{text}"'


def words(element: Element) -> list[Word]:
    """Return the words of the text of an element, each with its place."""
    text, document = element.document.source.text, element.document
    found: list[Word] = []
    for item in element.content:
        if not isinstance(item, Remark) or item.kind != TEXT:
            continue
        raw = text[item.start : item.end]
        if "&" in raw or "<" in raw:  # references, CDATA
            found += [Word(word, element.span) for word in item.text.split()]
        else:
            matches = re.finditer(r"\S+", raw)
            found += [Word(m[0], document.span(item.start + m.start(), len(m[0]))) for m in matches]
    return found


def place(element: Element) -> Span:
    """Return the place of the text of an element: its only word, or the element itself."""
    found = words(element)
    return found[0].span if len(found) == 1 else element.span


def equal(first: Element, second: Element) -> bool:
    """Return True if two elements are equal without text, comments and the order of attributes."""
    if first.tag != second.tag or len(first.children) != len(second.children):
        return False
    texts = ({item.name: item.value for item in element.attributes.values()} for element in (first, second))
    return next(texts) == next(texts) and all(map(equal, first.children, second.children))


def correction(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that ``word`` is a misspelling of, or None if it is another word.

    A word with a prefix (``drake:mass``) belongs to another program.
    """
    if ":" in word or len(word) < 2:
        return None
    lower = {name.lower(): name for name in known if len(name) > 2}
    cutoff = 0.8 if len(word) > 4 else 0.66
    near = difflib.get_close_matches(word.lower(), lower, n=1, cutoff=cutoff)
    return lower[near[0]] if near else None


def kept(element: Element, text: str = "") -> Text:
    """Return an element as text, its further lines moved left, where space means nothing.

    ``text`` replaces it where something in it has been renamed. A prefix that an element around it declares
    (``xmlns:sim``) is declared in the text as well.
    """
    text = _LINE_END.sub("\n", text or element.verbatim)
    names = [name for inner in element.iter() for name in (inner.tag, *inner.attributes) if ":" in name]
    declarations = ""
    for key in dict.fromkeys(f"xmlns:{name.partition(':')[0]}" for name in names):
        above = next((one for one in _ancestors(element) if key in one.attributes), None)
        if above is not None and key not in names:
            address = above.attributes[key].raw.replace('"', "&quot;")
            declarations += f' {key}="{address}"'
    at = 1 + len(element.tag)
    return Text(indented(text[:at] + declarations + text[at:], ""))

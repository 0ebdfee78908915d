"""What is refused of an MJCF: by MuJoCo, in its words and with a place, and what MuJoCo would not tell clearly."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator

from ...diagnostic import Diagnostic, Span, error
from ...registry import READING, Rule
from ..markup import Attribute, Element
from .process import Answer
from .source import Markup

RULES = (
    Rule(
        "mjcf-refused",
        "MuJoCo does not load the file; the message is MuJoCo's.",
        "Correct it until MuJoCo loads it.",
        READING,
    ),
    Rule(
        "mjcf-too-large",
        "The replicas of an MJCF are more elements than any robot has.",
        "Repeat less often.",
        READING,
    ),
)

MAX_ELEMENTS = 500_000

_LINE = re.compile(r"\bline (\d+)")
_TAG = re.compile(r"Element '([^']+)'")
_QUOTED = re.compile(r"'([^']+)'")
_NOT_FINITE = re.compile(r"(?i)[-+]?(nan|inf|infinity)")
_FILE_HELP = "put the file where the MJCF looks for it: MuJoCo wants to see every mesh and texture"
_WORDS = ("name", "class", "childclass", "file", "model", "prefix", "material", "mesh", "texture", "group")


def before(markup: Markup) -> Iterator[Diagnostic]:
    """Yield what MuJoCo is not asked about: numbers that are none, and replicas without end."""
    for element in markup.everything():
        for attribute in element.attributes.values():
            if attribute.name in _WORDS:
                continue
            for word in attribute.words():
                if _NOT_FINITE.fullmatch(word.text):
                    message = f"{attribute.name} of <{element.tag}> is {word.text}, which is no number"
                    yield error("not-finite", message, word.span, "give a number")
    most, where = _replicas(markup, markup.root)
    if most > MAX_ELEMENTS:
        message = f"the replicas of this file are {most:,} elements, more than {MAX_ELEMENTS:,}"
        yield error("mjcf-too-large", message, (where or markup.root).span, "repeat less often")


def _replicas(markup: Markup, element: Element) -> tuple[int, Element | None]:
    """Return how many elements an element holds when all is repeated, and the replicate that makes the most of them."""
    total, most, where = 1, 0, None
    for child in markup.children(element):
        count, inner = _replicas(markup, child)
        total += count
        if inner is not None and count > most:
            most, where = count, inner
    said = element.get("count")
    if element.tag == "replicate" and said.isdecimal():
        return total * int(said), where or element
    return total, where


def refusal(markup: Markup, answer: Answer) -> Diagnostic:
    """Return the error about a file that MuJoCo does not load, in MuJoCo's words."""
    words = " ".join(answer.refusal.split())
    for prefix in ("XML Error: ", "Error: "):
        words = words.removeprefix(prefix)
    if answer.missing:
        return error("extra-missing", words, markup.root.span, answer.help)
    help = _FILE_HELP if words.startswith("Error opening file") else answer.help
    said = words if answer.own else f"MuJoCo refuses the file: {words}"
    return error("mjcf-refused", said, place(markup, words), help)


def place(markup: Markup, message: str) -> Span:
    """Return the place that a message of MuJoCo speaks of.

    MuJoCo gives the line in the main file, 0 in others, and quotes the names of elements and attributes and the values
    that it does not like: the element that has the most of them is meant.
    """
    line, tag = _LINE.search(message), _TAG.search(message)
    quoted = set(_QUOTED.findall(message)) - {tag[1] if tag else ""}
    best, found = 0, markup.root.span
    for element in markup.everything():
        attribute = _quoted(element, quoted)
        here = line is not None and element.document is markup.root.document and element.span.line == int(line[1])
        score = 4 * here + 2 * (tag is not None and element.tag == tag[1]) + 3 * (attribute is not None)
        if score > best:
            best, found = score, _span(element, attribute, quoted)
    return found


def _quoted(element: Element, quoted: set[str]) -> Attribute | None:
    return next((a for a in element.attributes.values() if a.name in quoted or _says(a, quoted)), None)


def _says(attribute: Attribute, quoted: Collection[str]) -> bool:
    """Say whether an attribute has a quoted value; MuJoCo quotes a file with the folder that it looked in."""
    value = attribute.value
    return value in quoted or (attribute.name == "file" and any(q.endswith(f"/{value}") for q in quoted if value))


def _span(element: Element, attribute: Attribute | None, quoted: set[str]) -> Span:
    if attribute is None:
        return element.span
    return attribute.name_span if attribute.name in quoted else attribute.span

"""Broken: what makes a file no robot for us, with its place.

Some is seen in the text (``before``), the rest is said by MuJoCo (``refusal``).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, Span, error
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import Attribute, Element

from .process import Answer
from .source import Markup

RULES = (
    Rule(
        "mjcf-refused",
        "MuJoCo does not load the file; the message is MuJoCo's.",
        "Correct it until MuJoCo loads it.",
        Heading.READING,
    ),
    Rule(
        "mjcf-too-large",
        "The replicas of an MJCF are more elements than any robot has.",
        "Repeat less often.",
        Heading.READING,
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
    """Yield what MuJoCo is not asked about: numbers that are none, replicas without end, files without an end."""
    yield from _no_files(markup)
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


def _no_files(markup: Markup) -> Iterator[Diagnostic]:
    """Yield an error for each mesh, texture or height field that is a pipe or a device: reading one may never end."""
    words = ("meshdir", "texturedir", "assetdir")
    inner = [
        "",
        *(e.get(word).replace("\\", "/") for e in markup.sections("compiler") for word in words if e.get(word)),
    ]
    folders = [folder / name for folder in dict.fromkeys(file.parent for file in markup.files) for name in inner]
    for element in markup.everything():
        for attribute in element.attributes.values():
            if not attribute.name.startswith("file") or not attribute.value or element.tag in ("include", "model"):
                continue
            for path in (folder / attribute.value.replace("\\", "/") for folder in folders):
                if _is_odd(path):
                    message = f"{attribute.value} is no regular file"
                    yield error("file-unreadable", message, attribute.span, "name a file")
                    break


def _is_odd(path: Path) -> bool:
    """Say whether there is something that is neither a file nor a folder."""
    return files.is_special(path)


def _replicas(markup: Markup, element: Element) -> tuple[int, Element | None]:
    """Return how many elements an element holds when all is repeated, and the replicate that makes the most of them."""
    total, most, where = 1, 0, None
    for child in markup.children(element):
        count, inner = _replicas(markup, child)
        total += count
        if inner is not None and count > most:
            most, where = count, inner
    written = element.get("count")
    if element.tag == "replicate" and written.isdecimal():
        return total * int(written), where or element
    return total, where


def refusal(markup: Markup, answer: Answer) -> Diagnostic:
    """Return the error about a file that MuJoCo does not load, in MuJoCo's words."""
    words = " ".join(answer.refusal.split())
    for prefix in ("XML Error: ", "Error: "):
        words = words.removeprefix(prefix)
    if answer.missing:
        return error("extra-missing", words, markup.root.span, answer.help)
    help = _FILE_HELP if words.startswith("Error opening file") else answer.help
    message = words if answer.own else f"MuJoCo refuses the file: {words}"
    return error("mjcf-refused", message, place(markup, words), help)


def place(markup: Markup, message: str) -> Span:
    """Return the place that a message of MuJoCo speaks of.

    MuJoCo gives the line in the main file, 0 in others, and quotes the names of elements and attributes and the values
    that it does not like: the element that has the most of them is meant.
    """
    line, tag = _LINE.search(message), _TAG.search(message)
    quoted = set(_QUOTED.findall(message)) - {tag[1] if tag else ""}
    best, likely = 0, markup.root.span
    for element in markup.everything():
        attribute = _quoted(element, quoted)
        here = line is not None and element.document is markup.root.document and element.span.line == int(line[1])
        score = 4 * here + 2 * (tag is not None and element.tag == tag[1]) + 3 * (attribute is not None)
        if score > best:
            best, likely = score, _span(element, attribute, quoted)
    return likely


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

"""Find the elements of a URDF that may become sections, and cut them out of the texts that contain them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats.imported_robot import Comment, as_tree
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.tree import Map, Path, Seq, Text
from rosorin_compile.source.xml.elements import indent_lines, tree_of
from rosorin_compile.source.xml.markup import COMMENT, Element, Remark, parse

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element as Tree

CONTROL, SENSORS = "control", "sensors"
_AROUND = "elements"


class Candidate(NamedTuple):
    """An element that may become an entry of a section: its name, the text that contains it, its number there.

    ``reference`` is that of the ``<gazebo>`` around it.
    """

    section: str
    name: str
    text: int
    number: int
    element: Tree
    reference: str = ""

    @property
    def path(self) -> Path:
        """The path of its entry."""
        return (self.section, self.name)

    @property
    def called(self) -> str:
        """Its name in messages."""
        return f'{"sensor" if self.section == SENSORS else "<ros2_control>"} "{self.name}"'

    @property
    def alone(self) -> str:
        """The element as a separate text, in its ``<gazebo>``."""
        from xml.etree import ElementTree

        if self.section == CONTROL:
            return ElementTree.tostring(self.element, "unicode")
        around = ElementTree.Element("gazebo", {"reference": self.reference} if self.reference else {})
        around.append(self.element)
        return ElementTree.tostring(around, "unicode")


def trees(texts: Seq) -> Iterator[tuple[int, Tree]]:
    """Yield the elements of each text that is XML, with its index."""
    for index, text in enumerate(texts):
        try:
            yield from ((index, element) for element in tree_of(f"<{_AROUND}>{text}</{_AROUND}>"))
        except ValueError:
            continue


def candidates(texts: Seq) -> list[Candidate]:
    """Return the hardware blocks and the sensors in elements."""
    found = []
    for index, element in trees(texts):
        if element.tag == "ros2_control":
            found.append(Candidate(CONTROL, element.get("name", "").strip(), index, 0, element))
        elif element.tag == "gazebo" and set(element.attrib) <= {"reference"}:
            inner = [child for child in element if child.tag == "sensor"]
            for number, child in enumerate(inner):
                name, reference = child.get("name", "").strip(), element.get("reference", "").strip()
                found.append(Candidate(SENSORS, name, index, number, child, reference))
    return found


class Rest(NamedTuple):
    """The texts without some elements, the new path of each text by its index, and the comments of what is cut out."""

    texts: Seq
    paths: Mapping[int, Path]
    comments: list[Comment]


def without(texts: Seq, taken: list[Candidate]) -> Rest:
    """Return elements without those that became entries; an empty ``<gazebo>`` is removed, too."""
    left, paths, comments = Seq(texts.span, texts.via), dict[int, Path](), list[Comment]()
    for index, (text, span) in enumerate(zip(texts, texts.value_spans, strict=True)):
        rest = str(text)
        if mine := [one for one in taken if one.text == index]:
            rest, remarks = _cut(rest, mine)
            comments += [Comment(words, span, path) for path, words in remarks]
        paths[index] = ("urdf_elements", len(left)) if rest else mine[0].path
        if rest:
            left.put(Text(rest), span)
    return Rest(left, paths, comments)


def _cut(text: str, taken: list[Candidate]) -> tuple[str, list[tuple[Path, str]]]:
    """Return a text without some elements, and their comments by the path of their entry."""
    root = parse(Source("", f"<{_AROUND}>{text}</{_AROUND}>")).root
    outer = root.children[0]
    sensors = [child for child in outer.children if child.tag == "sensor"]
    elements = [outer if one.section == CONTROL else sensors[one.number] for one in taken]
    remarks = [
        (one.path, remark) for one, element in zip(taken, elements, strict=True) for remark in _comments(element)
    ]
    if outer.tag != "gazebo" or len(outer.children) == len(taken):
        inner = {remark.start for _, remark in remarks}
        remarks = [*((taken[0].path, one) for one in _comments(outer) if one.start not in inner), *remarks]
        return "", [(path, remark.text) for path, remark in remarks]
    rest = root.document.source.text[outer.start : outer.end]
    for element in sorted(elements, key=lambda one: one.start, reverse=True):
        start, end = element.start - outer.start, element.end - outer.start
        rest = rest[:start].rstrip(" \t") + rest[end:].lstrip(" \t")
    lines = [line for line in rest.split("\n") if line.strip()]
    return indent_lines("\n".join(lines), ""), [(path, remark.text) for path, remark in remarks]


def _comments(element: Element) -> list[Remark]:
    items = (item for inner in element.iter() for item in inner.content)
    return [item for item in items if isinstance(item, Remark) and item.kind == COMMENT]


def move_comments(comments: Any, paths: Mapping[int, Path]) -> list[Comment]:
    """Return comments with the new paths of the elements that they belong to."""
    made = []
    for comment in comments:
        path = comment.path
        if path[:1] == ("urdf_elements",) and len(path) > 1 and path[1] in paths:
            comment = replace(comment, path=paths[path[1]])
        made.append(comment)
    return made


def put(tree: Map, sections: Mapping[str, Any]) -> Map:
    """Return a tree with more sections, whose values are plain; empty sections are removed."""
    made = tree.copy()
    for key, value in sections.items():
        if value:
            plain = value if isinstance(value, (Map, Seq)) else as_tree(value, tree.span, [key])
            made.put(key, plain, tree.span, tree.span)
        else:
            made.pop(key, None)
    return made

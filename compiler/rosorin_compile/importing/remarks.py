"""Remarks: which entry of the tree a comment of the source belongs to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..tree import Path
from .imported import BEFORE, BESIDE, END, INSIDE, Comment
from .markup import COMMENT, Document, Element, Remark


def comments_of(document: Document, paths: Mapping[int, Path]) -> list[Comment]:
    """Return the comments of a document, in their order.

    ``paths`` leads from an element (by ``id``) to what became of it. Comments within an element that was kept as it
    stands are part of it and do not appear here.
    """
    found = [_comment(document, remark, ("robot",), BEFORE) for remark in _comments(document.before)]
    waiting: list[tuple[Element, Path]] = [(document.root, paths.get(id(document.root), ()))]
    while waiting:
        element, path = waiting.pop()
        found += _within(document, element, path, paths)
        read = [(child, paths[id(child)]) for child in element.children if id(child) in paths]
        waiting += [(child, inner) for child, inner in read if "urdf_elements" not in inner]
    found += [_comment(document, remark, (), END) for remark in _comments(document.after)]
    return sorted(found, key=lambda comment: (comment.span.line, comment.span.column))


def _comments(remarks: list[Remark]) -> Iterator[Remark]:
    return (remark for remark in remarks if remark.kind == COMMENT)


def _within(document: Document, element: Element, path: Path, paths: Mapping[int, Path]) -> Iterator[Comment]:
    """Yield the comments directly in an element."""
    text = document.source.text
    content = element.content
    for index, item in enumerate(content):
        if isinstance(item, Element) or item.kind != COMMENT:
            continue
        before = content[index - 1] if index else None
        above = before
        while isinstance(above, Remark) and index:
            index -= 1
            above = content[index - 1] if index else None
        same_line = above is not None and "\n" not in text[above.end : item.start]
        after = next((other for other in content[content.index(item) :] if isinstance(other, Element)), None)
        if same_line and isinstance(above, Element):
            yield _comment(document, item, paths.get(id(above), path), BESIDE)
        elif (
            above is None
            and "\n" not in text[element.opened : item.start]
            and "\n" in text[item.end : _next(item, content, element)]
        ):
            yield _comment(document, item, path, BESIDE)
        elif after is not None:
            yield _comment(document, item, paths.get(id(after), path), BEFORE)
        else:
            yield _comment(document, item, path, INSIDE)


def _next(item: Remark, content: list[Element | Remark], element: Element) -> int:
    """Return where the first thing behind a remark begins, the end of the element at the latest."""
    later = [other.start for other in content if other.start >= item.end]
    return later[0] if later else element.end


def _comment(document: Document, remark: Remark, path: Path, where: str) -> Comment:
    return Comment(remark.text, document.span(remark.start, remark.end - remark.start), path, where)

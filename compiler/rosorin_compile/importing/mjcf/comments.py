"""Comments of an MJCF, each with the entry of the tree that it stands before or in."""

from __future__ import annotations

from ...tree import Path
from ..imported import BEFORE, BESIDE, END, INSIDE, Comment
from ..markup import COMMENT, Document, Element, Remark
from .reading import Reading


def comments_of(reading: Reading) -> list[Comment]:
    """Return all comments, in the order of the files and their text."""
    paths: dict[Element, Path] = {}
    for index, name in reading.link_of.items():
        if index:
            paths.setdefault(reading.places.body(index), ("links", name))
    for index, name in reading.joint_of.items():
        paths.setdefault(reading.places.of("joints", index), ("joints", name))
    found: list[Comment] = []
    for document in reading.markup.documents:
        found += [_made(document, remark, ("robot",), BEFORE) for remark in document.before if remark.kind == COMMENT]
        inner = [comment for element in document.root.iter() for comment in _inside(element, paths)]
        found += sorted(inner, key=lambda comment: (comment.span.line, comment.span.column))
        found += [_made(document, remark, (), END) for remark in document.after if remark.kind == COMMENT]
    return found


def _inside(element: Element, paths: dict[Element, Path]) -> list[Comment]:
    """Return the comments directly in an element: before or beside what stands there, or at its end."""
    made = []
    document = element.document
    for position, item in enumerate(element.content):
        if isinstance(item, Element) or item.kind != COMMENT:
            continue
        before = next((e for e in reversed(element.content[:position]) if isinstance(e, Element)), None)
        after = next((e for e in element.content[position:] if isinstance(e, Element)), None)
        own_line = "\n" in document.source.text[(before.end if before else element.opened) : item.start]
        if before is not None and not own_line:
            made.append(_made(document, item, _path(before, paths), BESIDE))
        elif after is not None:
            made.append(_made(document, item, _path(after, paths), BEFORE))
        else:
            made.append(_made(document, item, _path(element, paths), INSIDE if element.parent else END))
    return made


def _path(element: Element, paths: dict[Element, Path]) -> Path:
    """Return the entry of an element, or of what it stands in; the robot as a whole for all else."""
    here: Element | None = element
    while here is not None:
        if here in paths:
            return paths[here]
        here = here.parent
    return ("robot",)


def _made(document: Document, remark: Remark, path: Path, where: str) -> Comment:
    if where in (INSIDE, END) and path == ("robot",):
        path, where = (), END
    return Comment(remark.text, document.span(remark.start, remark.end - remark.start), path, where)

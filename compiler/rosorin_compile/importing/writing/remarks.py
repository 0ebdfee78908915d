"""Remarks: the comments of a source, put where they belong in the files that are written."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ...tree import Path
from ...wording import printable
from ..imported import BESIDE, END, INSIDE, Comment
from .layout import Remarks

_LINE_END = re.compile("\r\n|[\n\r\x85\u2028\u2029]")
_OF_ROBOT = ("robot", "source")


def placed(comments: Iterable[Comment], document: Mapping[str, Any], head: Sequence[str], root: bool) -> Remarks:
    """Return the comments of one file. ``head`` are lines that begin it.

    A comment belongs to the file that has its section. What belongs to no section, or to the name of the robot, is for
    the ``root`` file: at its beginning, or at its end if it stood there.
    """
    before: dict[Path, list[str]] = {(): list(head)}
    beside: dict[Path, list[str]] = {}
    inside: dict[Path, list[str]] = {}
    for comment in comments:
        if not comment.path or comment.path[0] in _OF_ROBOT:
            place = inside if comment.where == END else before
            if root:
                place.setdefault((), []).extend(cleaned(comment.text))
            continue
        path = _existing(document, comment.path)
        if not path:
            continue  # its section is in another file
        lines = cleaned(comment.text)
        if comment.where == INSIDE and _holds(document, path):
            inside.setdefault(path, []).extend(lines)
        elif comment.where == BESIDE and path == tuple(comment.path) and len(lines) == 1:
            beside.setdefault(path, []).extend(lines)
        elif not _is_repeated(before.get(path, []), lines):
            before.setdefault(path, []).extend(lines)
    return Remarks(before, beside, inside)


def _is_repeated(said: list[str], lines: list[str]) -> bool:
    """Say whether a comment of several lines stands there already: a file that is expanded twice says all twice."""
    return len(lines) > 1 and said[-len(lines) :] == lines


def cleaned(text: str) -> list[str]:
    """Return the lines of a comment, moved left together, without empty lines around them.

    >>> cleaned(" the arm ")
    ['the arm']
    """
    first, *others = (line.expandtabs(4).rstrip() for line in _LINE_END.split(text))
    # The first line stands behind the opening of the comment, so its indentation says nothing of the others.
    body = textwrap.dedent("\n".join(others)).split("\n") if others else []
    found = [printable(line) for line in [first.strip(), *body]]
    while found and not found[0]:
        found.pop(0)
    while found and not found[-1]:
        found.pop()
    return found


def _existing(document: Mapping[str, Any], path: Sequence[str | int]) -> Path:
    """Return the longest prefix of a path that leads to an entry of a document where a comment can stand."""
    node: Any = document
    found: list[str | int] = []
    for step in path:
        if isinstance(node, Mapping) and step in node:
            node = node[str(step)]
        elif isinstance(node, list) and isinstance(step, int) and step < len(node) and _is_block(node):
            node = node[step]
        else:
            break
        found.append(step)
    return tuple(found)


def _is_block(value: list[Any]) -> bool:
    return any(isinstance(item, (Mapping, list)) or (isinstance(item, str) and "\n" in item) for item in value)


def _holds(document: Mapping[str, Any], path: Path) -> bool:
    """Say whether a value stands in a block, so that a comment can stand after the last thing in it."""
    node: Any = document
    for step in path:
        node = node[step]
    return bool(node) and (isinstance(node, Mapping) or (isinstance(node, list) and _is_block(node)))

"""Tracing: where each element stood that xacro makes, kept on the nodes themselves, whatever xacro does with them.

In the child process. A place is the number of a file, the offset of the element in its text, and the number of the call
of a macro that made it, -1 for none; a call is the place of its element.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import FrameType, TracebackType
from typing import Any
from xml.dom import minidom

from rosorin_compile.source.xml.markup import Document

Place = tuple[int, int, int]

_MARK = "rosorin_place"
# What the functions of xacro call the element that they are at.
_NAMES = ("node", "elt")


class Traces:
    """The places of all elements that were read or made; ``files`` and ``calls`` are what places count."""

    def __init__(self) -> None:
        self.files: dict[str, int] = {}
        self.calls: list[Place] = []
        self._open: list[int] = []

    def mark(self, made: minidom.Document, name: str, parsed: Document) -> None:
        """Mark the elements of a file that xacro has read; ``parsed`` is the same file with its places."""
        file = self.files.setdefault(name, len(self.files))
        for node, element in zip(elements(made), parsed.root.iter(), strict=True):
            setattr(node, _MARK, (file, element.start, -1))

    def follow(self, xacro: Any) -> None:
        """Make copies of marked elements know the call that makes them."""
        module: Any = minidom
        own_clone, own_call = module._clone_node, xacro.handle_macro_call
        # Each call of a macro takes a frame more than without us.
        sys.setrecursionlimit(sys.getrecursionlimit() * 3 // 2)

        def clone(node: Any, deep: bool, owner: Any) -> Any:
            made = own_clone(node, deep, owner)
            place = getattr(node, _MARK, None)
            if place is not None and made is not None:
                setattr(made, _MARK, (*place[:2], self._open[-1] if self._open else place[2]))
            return made

        def call(node: Any, macros: Any, symbols: Any) -> Any:
            place = getattr(node, _MARK, None)
            if place is None or not node.tagName.startswith("xacro:"):
                return own_call(node, macros, symbols)
            if not self._open or self.calls[self._open[-1]] != place:
                self.calls.append(place)
            self._open.append(len(self.calls) - 1)
            try:
                return own_call(node, macros, symbols)
            finally:
                self._open.pop()

        module._clone_node, xacro.handle_macro_call = clone, call


def elements(document: minidom.Document) -> Iterator[Any]:
    """Yield the elements of a document in the order of its text."""
    waiting: list[Any] = [document.documentElement]
    while waiting:
        node = waiting.pop()
        yield node
        waiting += [child for child in reversed(node.childNodes) if child.nodeType == child.ELEMENT_NODE]


def places(document: minidom.Document) -> list[Place | None]:
    """Return the place of each element; that of one which xacro has made of nothing is the one around it."""
    found: list[Place | None] = []
    for node in elements(document):
        found.append(_place(node))
    return found


def where(problem: BaseException) -> Place | None:
    """Return the place of the element that xacro was at when it failed; of an endless recursion the outermost."""
    found: Place | None = None
    step: TracebackType | None = problem.__traceback__
    while step is not None:
        found = _at(step.tb_frame) or found
        if found is not None and isinstance(problem, RecursionError):
            break
        step = step.tb_next
    return found


def here() -> Place | None:
    """Return the place of the element that xacro is at."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        found = _at(frame)
        if found is not None:
            return found
        frame = frame.f_back
    return None


def _at(frame: FrameType) -> Place | None:
    if not frame.f_globals.get("__name__", "").startswith("xacro"):
        return None
    return next((_place(frame.f_locals[name]) for name in _NAMES if frame.f_locals.get(name) is not None), None)


def _place(node: Any) -> Place | None:
    """Return the place of a node, or of what it is in."""
    while node is not None:
        found: Place | None = getattr(node, _MARK, None)
        if found is not None:
            return found
        node = node.parentNode
    return None

"""Interpolation: text taken apart into plain pieces and ``${...}`` expressions. ``$${`` is a plain ``${``."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

_OPEN = "${"


class Piece(NamedTuple):
    """A piece of a text, and where it starts in it; an expression is given without its braces."""

    text: str
    offset: int
    is_expression: bool = False
    is_whole: bool = False
    unclosed: bool = False


@lru_cache(maxsize=20_000)
def pieces(text: str) -> tuple[Piece, ...]:
    """Return the pieces of a text in order."""
    found: list[Piece] = []
    position = 0
    while (start := text.find(_OPEN, position)) >= 0:
        if start > 0 and text[start - 1] == "$":
            found.append(Piece(text[position : start - 1] + _OPEN, position))
            position = start + 2
            continue
        if start > position:
            found.append(Piece(text[position:start], position))
        end = _closing(text, start + 2)
        if end < 0:
            return (*found, Piece(text[start + 2 :], start, True, unclosed=True))
        whole = start == 0 and end == len(text) - 1
        found.append(Piece(text[start + 2 : end], start, True, whole))
        position = end + 1
    if position < len(text):
        found.append(Piece(text[position:], position))
    return tuple(found)


def _closing(text: str, position: int) -> int:
    """Return where the brace that is open at ``position`` closes, or -1; quotes and inner pairs are passed."""
    depth, quote = 1, ""
    for index in range(position, len(text)):
        letter = text[index]
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter == "{":
            depth += 1
        elif letter == "}":
            depth -= 1
            if depth == 0:
                return index
    return -1

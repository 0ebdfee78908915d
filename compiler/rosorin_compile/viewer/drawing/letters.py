"""Letters: how wide texts are, in a terminal and in a picture, and the colours of publishers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

# Colours that people with any kind of colour vision tell apart, dark enough for lines on white; after the palettes of
# Okabe and Ito (https://jfly.uni-koeln.de/color) and of Paul Tol (https://personal.sron.nl/~pault).
PALETTE = (
    *("#0072b2", "#d55e00", "#009e73", "#aa4499", "#b8860b", "#56b4e9", "#882255", "#332288", "#44aa99"),
    *("#999933", "#cc6677", "#117733"),
)
GREY = "#8c959f"  # nobody


def colours(publishers: Sequence[str]) -> Mapping[str, str]:
    """Return a colour for each publisher; beyond the palette they come again, and the name alone tells."""
    return {name: PALETTE[at % len(PALETTE)] for at, name in enumerate(publishers)}


def escape(text: str) -> str:
    """Return a text as XML has it between elements (xml.sax.saxutils would load half of http for it)."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def quoted(text: str) -> str:
    """Return a text as the value of an attribute, with its quotes."""
    return '"' + escape(text).replace('"', "&quot;").replace("\n", "&#10;").replace("\t", "&#9;") + '"'


def cells(text: str) -> int:
    """Return the columns that a text takes in a terminal."""
    return len(text) if text.isascii() else sum(map(_cells, text))


@lru_cache(maxsize=4096)
def _cells(letter: str) -> int:
    import unicodedata  # most texts are of ASCII

    if unicodedata.category(letter) in ("Mn", "Me", "Cf"):
        return 0
    return 2 if unicodedata.east_asian_width(letter) in ("W", "F") else 1


def width(text: str, size: float) -> float:
    """Return the room that a text takes in a picture, in pixels at a size of monospace letters; rather too much.

    Letters of usual monospace fonts are 0.6 of their size wide; those that the font may lack come from another one.
    """
    ems = sum(0.61 if letter.isascii() else 1.1 for letter in text)
    return ems * size


def wrapped(text: str, limit: float, size: float) -> list[str]:
    """Return a text as lines that are no wider than a limit; a word that is wider is broken."""
    most = max(1, int(limit / (1.1 * size)))
    lines = [""]
    for word in (part for whole in text.split(" ") for part in _broken(whole, limit, size, most)):
        longer = f"{lines[-1]} {word}" if lines[-1] else word
        if lines[-1] and width(longer, size) > limit:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def _broken(word: str, limit: float, size: float, most: int) -> list[str]:
    if width(word, size) <= limit:
        return [word]
    return [word[at : at + most] for at in range(0, len(word), most)]

"""Elements of XML as text: whether they are whole, and how they look in a file.

Names are names here: a prefix that nothing declares, as in <controller:foo>, is legal text of a URDF.
"""

from __future__ import annotations

import re
from xml.parsers import expat

_TOP = b"<robot>"
_END = b"</robot>"


def damage(text: str) -> str:
    """Return what keeps a text from being elements of XML, in words; empty if nothing does."""
    reader = _Reader()
    try:
        reader.read(text)
    except expat.ExpatError as problem:
        line = f" (line {problem.lineno} of the text)" if "\n" in text.strip() else ""
        return f"{expat.errors.messages[problem.code]}{line}"
    except UnicodeEncodeError:
        return "a character that no file can hold"
    return reader.wrong or ("" if reader.elements else "there is no element")


def indented(text: str, indent: str) -> str:
    """Return elements with the first line after ``indent`` and the others as far right as they were from it.

    Where a line end or the space after it is part of what the elements say, the text stays as it is.
    """
    text = text.replace("\r\n", "\n").strip()
    reader = _Reader()
    reader.read(text)
    first, *rest = text.split("\n")  # and at no other character that ends lines elsewhere
    if not rest or not reader.loose:
        return indent + text
    margin = _margin([line for line in rest if line.strip(" \t")])
    return "\n".join([indent + first, *(indent + line[len(margin) :] if line.strip(" \t") else "" for line in rest)])


def _margin(lines: list[str]) -> str:
    """Return the blanks that all lines begin with."""
    margin = min((line[: len(line) - len(line.lstrip(" \t"))] for line in lines), key=len)
    while not all(line.startswith(margin) for line in lines):
        margin = margin[:-1]
    return margin


class _Reader:
    """Reads elements. ``wrong``: what stands beside them; ``loose``: space between them means nothing."""

    def __init__(self) -> None:
        self.depth = 0
        self.elements = 0
        self.wrong = ""
        self.loose = True
        self.parser = expat.ParserCreate("utf-8")
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._data
        self.parser.CommentHandler = self._comment
        self.parser.StartCdataSectionHandler = self._cdata

    def read(self, text: str) -> None:
        """Read a text. Raises expat.ExpatError if it is not well formed."""
        for piece in (_TOP, text.encode(), _END):
            self.parser.Parse(piece, False)
        self.parser.Parse(b"", True)
        # A tag that is written over several lines may have a line end in a value.
        values = re.findall(r"=\s*(\"[^\"]*\"|'[^']*')", text)
        self.loose = self.loose and not any("\n" in value for value in values)

    def _start(self, name: str, attributes: dict[str, str]) -> None:  # noqa: ARG002
        self.depth += 1
        self.elements += self.depth == 2

    def _end(self, name: str) -> None:  # noqa: ARG002
        self.depth -= 1

    def _data(self, text: str) -> None:
        if text.strip():
            if self.depth == 1:
                self.wrong = self.wrong or f'"{text.strip()[:20]}" stands outside of an element'
            self.loose = self.loose and "\n" not in text

    def _comment(self, text: str) -> None:
        self.loose = self.loose and "\n" not in text

    def _cdata(self) -> None:
        self.loose = False

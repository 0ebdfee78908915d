"""Text as YAML writes it, quoted only where it has to be, so that ``load`` reads back the same text.

What other readers of YAML would take for something else (``on``, ``12:30``, a date: YAML 1.1) is quoted too.
"""

from __future__ import annotations

import re
from typing import Any

from .load import plain_scalar
from .memo import remembered

_INDICATORS = frozenset("-?:,[]{}#&*!|>'\"%@`")
_FLOW = frozenset(",[]{}")
_YAML_1_1 = re.compile(
    r"[yYnN]|[yY]es|YES|[nN]o|NO|[oO]n|ON|[oO]ff|OFF|=|<<|"  # https://yaml.org/type/bool.html, value.html, merge.html
    r"[-+]?[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?|"  # sexagesimal: https://yaml.org/type/int.html
    r"[-+]?(0b[01_]+|0x[0-9a-fA-F_]+|[0-9][0-9_]*)|[-+]?(\.[0-9_]+|[0-9][0-9_]*\.[0-9_]*)([eE][-+]?[0-9]+)?|"
    r"[0-9]{4}-[0-9]{1,2}-[0-9]{1,2}([Tt \t].*)?"  # https://yaml.org/type/timestamp.html
)
# Letters that are written as they are; of the others many are invisible, or end a line.
_RAW = re.compile(
    "[ -~\u00a1-\u00ac\u00ae-\u167f\u1681-\u1fff\u2010-\u2027\u2030-\u205e\u2070-\u2fff\u3001-\ud7ff"
    "\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]*"
)
_SHORT = {"\0": "0", "\a": "a", "\b": "b", "\t": "t", "\n": "n", "\v": "v", "\f": "f", "\r": "r", "\x1b": "e"}
_SHORT |= {'"': '"', "\\": "\\", "\x85": "N", "\xa0": "_", "\u2028": "L", "\u2029": "P"}


class Scalar(str):
    """A text as a scalar of YAML."""

    __slots__ = ()

    def written(self, flow: bool) -> str:
        """Return it on one line, in quotes only where it has to be; ``flow`` is inside brackets."""
        return scalar(self, flow)

    def quoted(self) -> str:
        """Return it in double quotes, which every reader of YAML takes for just this text."""
        return quoted(self)

    @property
    def is_raw(self) -> bool:
        """Whether every letter can stand in a file as it is; a line end cannot."""
        return is_raw(self)

    @property
    def value(self) -> Any:
        """What it says without quotes: None, bool, int, float, Quantity or str."""
        return plain_scalar(self)


# The same keys and texts stand in a robot again and again.
@remembered
def scalar(text: str, flow: bool) -> str:
    """Return a text as a scalar on one line; ``flow`` is inside brackets.

    >>> scalar("base link", True), scalar("180 deg", True), scalar("a: b", False)
    ('base link', '"180 deg"', '"a: b"')
    """
    if is_plain(text, flow):
        return text
    if ('"' in text or "\\" in text) and "'" not in text and is_raw(text):
        return f"'{text}'"
    return quoted(text)


def quoted(text: str) -> str:
    """Return a text as a scalar in double quotes, which every reader of YAML takes for just this text."""
    return '"' + "".join(map(_letter, text)) + '"'


def is_raw(text: str) -> bool:
    """Say whether every letter of a text can stand in a file as it is; a line end cannot."""
    return _RAW.fullmatch(text) is not None


def is_plain(text: str, flow: bool) -> bool:
    """Say whether a text can stand without quotes, for this reader of YAML and for others."""
    if not text or text != text.strip(" ") or text[0] in _INDICATORS or not is_raw(text):
        return False
    if ": " in text or " #" in text or text.endswith(":") or text.startswith(("...", "=")):
        return False
    if flow and not _FLOW.isdisjoint(text):
        return False
    value = plain_scalar(text)
    return isinstance(value, str) and value == text and _YAML_1_1.fullmatch(text) is None


def _letter(letter: str) -> str:
    """Return a letter inside double quotes (https://yaml.org/spec/1.2.2/#57-escaped-characters)."""
    if letter in _SHORT:
        return f"\\{_SHORT[letter]}"
    if is_raw(letter):
        return letter
    code = ord(letter)
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"

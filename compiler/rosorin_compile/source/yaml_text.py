"""Write strings as YAML scalars, with quotes only if YAML 1.2 or 1.1 needs them (``on``, ``12:30``, dates)."""

import re
from functools import lru_cache
from typing import Any

from .load import plain_scalar

_YAML_1_1 = re.compile(
    r"[yYnN]|[yY]es|YES|[nN]o|NO|[oO]n|ON|[oO]ff|OFF|=|<<|"  # https://yaml.org/type/bool.html, value.html, merge.html
    r"[-+]?[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?|"  # sexagesimal: https://yaml.org/type/int.html
    r"[-+]?(0b[01_]+|0x[0-9a-fA-F_]+|[0-9][0-9_]*)|[-+]?(\.[0-9_]+|[0-9][0-9_]*\.[0-9_]*)([eE][-+]?[0-9]+)?|"
    r"[0-9]{4}-[0-9]{1,2}-[0-9]{1,2}([Tt \t].*)?"  # https://yaml.org/type/timestamp.html
)
# Characters that need no escape sequence; many other characters are invisible, or end a line.
_RAW = re.compile(
    "[ -~\u00a1-\u00ac\u00ae-\u167f\u1681-\u1fff\u2010-\u2027\u2030-\u205e\u2070-\u2fff\u3001-\ud7ff"
    "\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]*"
)
_SIGNS = "-?:,[]{}#&*!|>'\"%@`="  # an unquoted scalar cannot begin with these
_SHORT = {"\0": "0", "\a": "a", "\b": "b", "\t": "t", "\n": "n", "\v": "v", "\f": "f", "\r": "r", "\x1b": "e"}
_SHORT |= {'"': '"', "\\": "\\", "\x85": "N", "\xa0": "_", "\u2028": "L", "\u2029": "P"}


class Scalar(str):
    """A string, with methods that write it as a YAML scalar."""

    __slots__ = ()

    @lru_cache(maxsize=20_000)  # noqa: B019 - most strings occur many times in a file
    def as_text(self, flow: bool) -> str:
        """Write the string on one line, with quotes only if necessary; ``flow`` is True inside [] or {}."""
        has_sign = ": " in self or " #" in self or self.endswith(":") or (flow and any(c in ",[]{}" for c in self))
        is_plain = self != "" and self == self.strip(" ") and self[0] not in _SIGNS and self.is_raw and not has_sign
        if is_plain and not self.startswith("...") and not _YAML_1_1.fullmatch(self) and isinstance(self.value, str):
            return str(self)
        if ('"' in self or "\\" in self) and "'" not in self and self.is_raw:
            return f"'{self}'"
        return self.in_quotes()

    def in_quotes(self) -> str:
        """Write the string in double quotes (https://yaml.org/spec/1.2.2/#57-escaped-characters)."""
        escaped = (c.encode("unicode_escape", "surrogatepass").decode("ascii") for c in self)
        letters = (
            f"\\{_SHORT[c]}" if c in _SHORT else c if _RAW.fullmatch(c) else escape
            for c, escape in zip(self, escaped, strict=True)
        )
        return '"' + "".join(letters) + '"'

    @property
    def is_raw(self) -> bool:
        return _RAW.fullmatch(self) is not None

    @property
    def value(self) -> Any:
        """The value that YAML readers get if the string is not quoted: None, bool, int, float, Quantity or str."""
        return plain_scalar(str(self))

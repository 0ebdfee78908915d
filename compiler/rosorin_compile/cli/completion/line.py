"""The command line as bash has it in the making: taken apart into words, and what is put in place of the last one.

Bash breaks words at the letters of ``COMP_WORDBREAKS`` too, so ``base:=fr`` is three words to it, of which it replaces
the last one only (https://www.gnu.org/software/bash/manual/html_node/Bash-Variables.html). Here a word is a word.
"""

from __future__ import annotations

import re
from typing import NamedTuple

_BLANK = " \t\n"
# What bash would read as more than a letter, outside quotes and inside double ones.
_SPECIAL = re.compile(r"""([\s\\"'$`<>|&;()*?\[\]{}!#])""")
_SPECIAL_IN_DOUBLE = re.compile(r'([\\"$`])')


class Line(NamedTuple):
    """The words of a line up to the cursor, the last of them unfinished, as the program would get them.

    ``kept`` letters of the last word stay as they are; the rest is replaced. ``quote`` is the one that is open.
    ``target`` says that the last word is the file of a redirection.
    """

    words: list[str]
    kept: int = 0
    quote: str = ""
    target: bool = False

    def inserted(self, word: str) -> str:
        """Return what stands in place of the last word when it becomes another one."""
        rest = word[self.kept :]
        if self.quote == '"':
            return _SPECIAL_IN_DOUBLE.sub(r"\\\1", rest)
        if self.quote == "'":
            return rest.replace("'", r"'\''")
        quoted = _SPECIAL.sub(r"\\\1", rest)
        typed_home = self.kept == 0 and self.words[-1].startswith("~")
        return f"\\{quoted}" if quoted.startswith("~") and not typed_home else quoted


class _Splitter:
    """Takes a line apart, letter by letter."""

    def __init__(self, breaks: str) -> None:
        self.breaks = set(breaks) - set("\"'")
        self.words: list[str] = []
        self.kept = 0
        self.quote = ""
        self.within = False  # a word has begun
        self.redirected = False  # it is the file of a redirection

    def take(self, letter: str) -> None:
        """Take a letter that stands outside quotes, and is none."""
        if letter in _BLANK:
            self.end()
        elif letter in "<>|&;()":
            if self.within and self.words[-1].isdecimal():  # as in 2>
                self.words.pop()
                self.within = False
            self.end()
            self.redirected = self.redirected or letter in "<>"
        else:
            self.add(letter)
            if letter in self.breaks:
                self.kept = len(self.words[-1])

    def add(self, letter: str) -> None:
        """Add a letter to the word, or begin one."""
        if not self.within:
            self.words.append("")
            self.kept, self.within = 0, True
        self.words[-1] += letter

    def end(self) -> None:
        """End the word, if one has begun; the file of a redirection is none."""
        if self.within and self.redirected:
            self.words.pop()
            self.redirected = False
        self.within = False


def split(text: str, breaks: str) -> Line:
    """Return the words of a line that ends at the cursor; ``breaks`` are the letters of COMP_WORDBREAKS."""
    made = _Splitter(breaks)
    letters = iter(text)
    for letter in letters:
        if made.quote == "'" or (made.quote and letter == made.quote):
            if letter == made.quote:
                made.quote = ""
            else:
                made.add(letter)
        elif letter == "\\":
            following = next(letters, "")
            made.add(f"\\{following}" if made.quote and following not in '\\"$`' else following)
        elif made.quote:
            made.add(letter)
        elif letter in "\"'":
            made.add("")
            made.quote, made.kept = letter, len(made.words[-1])
        else:
            made.take(letter)
    if not made.within:
        made.add("")
    return Line(made.words, made.kept, made.quote, made.redirected)

"""Letters: which names only look alike, and which letters nobody sees.

A name of ASCII letters is the common case, and is passed without looking further. Letters that look like Latin ones are
those of Unicode's list of confusables (https://www.unicode.org/reports/tr39/) that a keyboard of another script types.
"""

from __future__ import annotations

import re

# Letters of Cyrillic, Greek and Armenian, each before the one of Latin that it looks like; and dashes.
_ALIKE = (
    "аaсcеeоoрpхxуyіiјjѕsԁdһhԛqԝwѵvӏlАAВBЕEІIЈJКKМMНHОOРPСCТTУYХXЅSԌGҮY"
    "οoνvρpιiκkυuχxΑAΒBΕEΖZΗHΙIΚKΜMΝNΟOΡPΤTΥYΧXϲcϳj"
    "օoսuհhոnցgզqՕOՏS"
    "ɑaɡg‐-‑-‒-–-—-−-"
)
LATIN = {ord(other): latin for other, latin in zip(_ALIKE[::2], _ALIKE[1::2], strict=True)}
# Unseen though Unicode does not class them as control or format: joiners, fillers and variation selectors.
_FILLERS = "\u034f\u115f\u1160\u17b4\u17b5\u180b\u180c\u180d\u180f\u2800\u3164\uffa0"
_SELECTORS = re.compile("[\ufe00-\ufe0f\U000e0100-\U000e01ef]")
_UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")
_WORD = re.compile(r"[^\W\d_]+")


def unseen(name: str) -> str:
    r"""Return the first letter of a name that nobody sees: a control character, a bidi mark, one without width.

    >>> unseen("laser"), unseen("größe"), unseen("la\u200bser") == "\u200b"
    ('', '', True)
    """
    if name.isascii():
        return "" if name.isprintable() else next(letter for letter in name if not letter.isprintable())
    from unicodedata import category

    for letter in name:
        if category(letter) in _UNSEEN or letter in _FILLERS or _SELECTORS.match(letter):
            return letter
    return ""


def foreign(name: str) -> str:
    r"""Return the first letter of another script that stands in a Latin word and looks as if it belonged there.

    >>> foreign("base_link"), foreign("joint_\u043e"), foreign("b\u0430se_link") == "\u0430"
    ('', '', True)
    """
    if name.isascii():
        return ""
    for word in _WORD.findall(name):
        if any(letter.isascii() for letter in word):
            found = next((letter for letter in word if ord(letter) in LATIN), "")
            if found:
                return str(found)
    return ""


def in_words(letter: str) -> str:
    r"""Return a letter by its number and its name in Unicode.

    >>> in_words("\u200b"), in_words("\x07")
    ('U+200B ZERO WIDTH SPACE', 'U+0007, a control character')
    """
    from unicodedata import name

    called = name(letter, "")
    return f"U+{ord(letter):04X} {called}" if called else f"U+{ord(letter):04X}, a control character"


def look(name: str, case: bool = True) -> str:
    """Return what is the same for names that look alike; ``case``: upper and lower case are one.

    >>> look("Base_Link") == look("b\u0430se_link"), look("R", case=False) == look("r", case=False)
    (True, False)
    """
    if not name.isascii():
        from unicodedata import normalize

        name = normalize("NFKC", name)
        name = name if name.isascii() else normalize("NFC", "".join(filter(lambda letter: not unseen(letter), name)))
        name = name.translate(LATIN)
    return name.casefold() if case else name


def difference(name: str, other: str) -> str:
    r"""Return in words in what a name differs from another one that looks like it.

    >>> difference("Arm", "arm"), difference("la\u200bser", "laser")
    ('upper and lower case', 'U+200B ZERO WIDTH SPACE, which nobody sees')
    """
    from unicodedata import normalize

    for one, another in ((name, other), (other, name)):
        if unseen(one) and unseen(one) not in another:
            return f"{in_words(unseen(one))}, which nobody sees"
    if normalize("NFC", name) == normalize("NFC", other):
        return "the Unicode form (NFC, NFD)"
    if name.casefold() == other.casefold():
        return "upper and lower case"
    for one, another in ((name, other), (other, name)):
        strange = [letter for letter in one if letter not in another and not letter.isascii()]
        if strange:
            return in_words(strange[0])
    return "letters that look alike"

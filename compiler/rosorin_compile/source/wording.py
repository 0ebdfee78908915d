"""Words of messages: lists of names, letters that look alike, and "did you mean".

Letters that look like Latin ones are those of Unicode's list of confusables (https://www.unicode.org/reports/tr39/)
that a keyboard of another script types.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches

MAX_COMPARED = 60
MAX_LISTED = 40
MAX_SUGGESTED = 3


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that is most similar to ``word``, or None if none is."""
    return next(iter(_similar(word, sorted(known))), None)


def _similar(word: str, names: list[str]) -> list[str]:
    """Return the most similar names; several only where they are equally likely."""
    if not word.isascii() and (same := [name for name in names if look(name) == look(word)]):
        return same[:1]
    if (known := set(names)) and (slips := [made for made in swaps(word) if made in known]):
        return slips[:1]
    if len(names) > MAX_COMPARED:  # comparing is slow, and there may be as many mistakes as names
        first = "".join(_parts(word))[:1] or word[:1]  # of /laser the l
        names = [name for name in names if name[:1].casefold() == first and abs(len(name) - len(word)) < 3]
        names = [name for name in names if name.casefold() == word.casefold()][:1] or names[:MAX_COMPARED]
    parts = {name: _parts(name) for name in names} if len(word) > 1 else {}  # everything is similar to one letter
    own = _parts(word)
    for name, of in parts.items():
        if "".join(of) == ("".join(own) or word):
            return [name]
    if turned := [name for name, of in parts.items() if of != own and sorted(of) == sorted(own)]:
        return turned[:1]
    lower = {name.casefold(): name for name in parts}
    if misspelt := get_close_matches(word.casefold(), lower, n=1, cutoff=0.85):
        return [lower[misspelt[0]]]
    if within := [name for name, of in parts.items() if _contains(of, own) or _contains(own, of)]:
        return sorted(within, key=lambda name: (abs(len(name) - len(word)), name))[:MAX_SUGGESTED]
    return [
        lower[one] for one in get_close_matches(word.casefold(), lower, n=1, cutoff=0.75 if len(word) > 3 else 0.66)
    ]


def swaps(word: str) -> Iterator[str]:
    """Yield each word with two neighbouring letters of ``word`` swapped."""
    for at in range(1, len(word)):
        if word[at - 1] != word[at]:
            yield f"{word[: at - 1]}{word[at]}{word[at - 1]}{word[at + 1 :]}"


def _parts(name: str) -> list[str]:
    """Return the words of a name in small letters: those of ``left_wheel`` are left and wheel."""
    return [part for part in re.split(r"[\W_]+", name.casefold()) if part]


def _contains(longer: list[str], shorter: list[str]) -> bool:
    """Return True if one name contains the words of another in a row, or begins or ends with them."""
    long, short = "".join(longer), "".join(shorter)
    if len(short) < 3 or len(long) <= len(short):
        return False
    if len(short) > 3 and (long.startswith(short) or long.endswith(short)):
        return True
    return any(longer[i : i + len(shorter)] == shorter for i in range(len(longer) - len(shorter) + 1))


def did_you_mean(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Return 'did you mean "x"?' for the nearest known words, or the list of known words if none is near.

    ``otherwise`` is what to do then: it comes before the list.
    """
    if otherwise:
        return or_else(did_you_mean(word, known), otherwise)
    names = sorted(known)
    if close := _similar(word, names):
        quoted = [f'"{name}"' for name in close]
        looks_same = not (word + close[0]).isascii() and look(word) == look(close[0])
        reason = f" the two differ in {difference(word, close[0])}" if looks_same else ""
        return f"did you mean {' or '.join(quoted)}?{reason}"
    return f"known: {first_of(names, MAX_LISTED)}" if names else ""


def or_else(guess: str, otherwise: str) -> str:
    """Return 'did you mean "x"?' as it is, or what to do before a list of legal words."""
    return guess if guess.startswith("did") else f"{otherwise} ({guess})" if guess else otherwise


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
    r"""Return the first invisible letter of a name: a control character, a bidi mark, one without width.

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
    r"""Return the first letter of another script that looks like a Latin one, in a word with Latin letters.

    >>> foreign("base_link"), foreign("joint_\u043e"), foreign("b\u0430se_link") == "\u0430"
    ('', '', True)
    """
    if name.isascii():
        return ""
    for word in _WORD.findall(name):
        foreign_letters = [letter for letter in word if ord(letter) in LATIN]
        if foreign_letters and any(letter.isascii() for letter in word):
            return str(foreign_letters[0])
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
    ('upper and lower case', 'U+200B ZERO WIDTH SPACE, which is invisible')
    """
    from unicodedata import normalize

    for one, another in ((name, other), (other, name)):
        if unseen(one) and unseen(one) not in another:
            return f"{in_words(unseen(one))}, which is invisible"
    if normalize("NFC", name) == normalize("NFC", other):
        return "the Unicode form (NFC, NFD)"
    if name.casefold() == other.casefold():
        return "upper and lower case"
    for one, another in ((name, other), (other, name)):
        strange = [letter for letter in one if letter not in another and not letter.isascii()]
        if strange:
            return in_words(strange[0])
    return "letters that look alike"


def printable(text: str, keep: str = "") -> str:
    r"""Return a text with control characters made visible, so that a file cannot steer the terminal.

    The letters of ``keep`` stay as they are, such as the tab in a line of a file.

    >>> printable("\x1b[31mred\n"), printable("1\t2", keep="\t") == "1\t2"
    ('\\x1b[31mred\\n', True)
    """
    plain = text
    for letter in keep:
        plain = plain.replace(letter, "")
    if plain.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode("ascii") for c in text)


def inert(line: str) -> str:
    """Return a line in which a job on GitHub finds no command, whatever a robot is called."""
    return line.replace("::", ": :").replace("##[", "## [")


def masked(text: str, keep: str = "") -> str:
    r"""Return a text with a question mark for each control character, for files that have no place for them.

    >>> masked("a\x07b\n", keep="\n")
    'a?b\n'
    """
    return "".join(c if c.isprintable() or c in keep else "?" for c in text)


def plural(noun: str, count: int) -> str:
    """Return a noun as it stands with a number."""
    if count == 1:
        return noun
    if noun.endswith("y") and noun[-2:-1] not in tuple("aeiou"):
        return f"{noun[:-1]}ies"
    return f"{noun}{'es' if noun.endswith(('s', 'x', 'sh', 'ch')) else 's'}"


def counted(count: int, noun: str) -> str:
    """Return a number of things in words."""
    return f"{count:,} {plural(noun, count)}"


def first_of(names: Sequence[str], most: int) -> str:
    """Return names in a row; of more than ``most`` the first ones and the number of the others."""
    return f"{', '.join(names[:most])}{and_more(len(names) - most)}"


def and_more(count: int, of: str = "") -> str:
    """Return the end of a sentence that names some things of many; nothing if none is left."""
    return f" and {count:,} more{f' {of}' if of else ''}" if count > 0 else ""


def listed(words: Iterable[str], most: int | None = None) -> str:
    """Return words as in a sentence; of more than ``most`` the first ones and the number of the others."""
    every = list(words) or [""]
    if most is not None and len(every) > most:
        return first_of(every, most)
    *first, last = every
    return f"{', '.join(first)} and {last}" if first else last


def quoted(names: Iterable[str], most: int | None = None) -> str:
    """Return names in quotes, as in a sentence."""
    return listed((f'"{name}"' for name in names), most)

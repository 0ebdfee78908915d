"""Helpers for messages: lists of names, look-alike letters, and "did you mean" suggestions."""

import re
from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from functools import lru_cache
from itertools import pairwise

MAX_COMPARED, MAX_LISTED, MAX_SUGGESTED = 60, 40, 3


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the name in ``known`` that is most similar to ``word``, or None if no name is similar."""
    return next(iter(_similar(word, sorted(known))), None)


def _similar(word: str, names: list[str]) -> list[str]:
    if not word.isascii() and (same := [name for name in names if look(name) == look(word)]):
        return same[:1]
    if (known := set(names)) and (slips := [made for made in swaps(word) if made in known]):
        return slips[:1]
    own = _parts(word)
    if len(names) > MAX_COMPARED:  # comparing is slow: keep names of similar length with the same first letter
        first = "".join(own)[:1] or word[:1]  # without punctuation: "l" for "/laser"
        names = [name for name in names if name[:1].casefold() == first and abs(len(name) - len(word)) < 3]
        names = [name for name in names if name.casefold() == word.casefold()][:1] or names[:MAX_COMPARED]
    parts = {name: _parts(name) for name in names} if len(word) > 1 else {}  # a single letter is similar to every name
    equal = [name for name, of in parts.items() if "".join(of) == ("".join(own) or word)]
    if equal or (equal := [name for name, of in parts.items() if sorted(of) == sorted(own)]):
        return equal[:1]
    lower = {name.casefold(): name for name in parts}
    for cutoff in (0.85, 0.75 if len(word) > 3 else 0.66):
        if misspelt := get_close_matches(word.casefold(), lower, n=1, cutoff=cutoff):
            return [lower[misspelt[0]]]
        if within := [name for name, of in parts.items() if _contains(of, own) or _contains(own, of)]:
            return sorted(within, key=lambda name: (abs(len(name) - len(word)), name))[:MAX_SUGGESTED]
    return []


def swaps(word: str) -> Iterator[str]:
    """Yield each word that results from swapping two adjacent letters of ``word``."""
    for at, (first, second) in enumerate(pairwise(word)):
        if first != second:
            yield f"{word[:at]}{second}{first}{word[at + 2 :]}"


def _parts(name: str) -> list[str]:
    return [part for part in re.split(r"[\W_]+", name.casefold()) if part]


def _contains(longer: list[str], shorter: list[str]) -> bool:
    long, short = "".join(longer), "".join(shorter)
    is_end = len(short) > 3 and (long.startswith(short) or long.endswith(short))
    is_within = any(longer[i : i + len(shorter)] == shorter for i in range(len(longer) - len(shorter) + 1))
    return 2 < len(short) < len(long) and (is_end or is_within)


def suggest(*candidates: str) -> str:
    """Return the help 'did you mean "x" or "y"?' for the candidates x and y."""
    return "did you mean " + " or ".join(f'"{name}"' for name in candidates) + "?"


def did_you_mean(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Return the help 'did you mean "x"?' or, if no name is similar, ``otherwise`` and the valid names."""
    names = sorted(known)
    if close := _similar(word, names):
        looks_same = not (word + close[0]).isascii() and look(word) == look(close[0])
        reason = f" the two differ in {difference(word, close[0])}" if looks_same else ""
        return f"{suggest(*close)}{reason}"
    known = f"known: {first_of(names, MAX_LISTED)}" if names else ""
    return f"{otherwise} ({known})" if known and otherwise else known or otherwise


# Alternating: a Cyrillic, Greek or Armenian letter or a dash, and the ASCII character that it looks like, according to
# Unicode's list of confusables (https://www.unicode.org/reports/tr39/).
_ALIKE = (
    "аaсcеeоoрpхxуyіiјjѕsԁdһhԛqԝwѵvӏlАAВBЕEІIЈJКKМMНHОOРPСCТTУYХXЅSԌGҮY"
    "οoνvρpιiκkυuχxΑAΒBΕEΖZΗHΙIΚKΜMΝNΟOΡPΤTΥYΧXϲcϳj"
    "օoսuհhոnցgզqՕOՏS"
    "ɑaɡg‐-‑-‒-–-—-−-"
)
LATIN = str.maketrans(_ALIKE[::2], _ALIKE[1::2])
# Invisible characters that are not in Unicode's categories for control and format characters.
_FILLERS = "\u034f\u115f\u1160\u17b4\u17b5\u180b\u180c\u180d\u180f\u2800\u3164\uffa0"
_SELECTORS = "[\ufe00-\ufe0f\U000e0100-\U000e01ef]"
_WORD = re.compile(r"[^\W\d_]+")


def hidden_letter(name: str) -> str:
    """Return the first invisible character of a name, such as a zero-width space, or an empty string."""
    if name.isascii() and name.isprintable():
        return ""
    from unicodedata import category

    kinds = ("Cc", "Cf", "Cs", "Zl", "Zp")
    return next((c for c in name if category(c) in kinds or c in _FILLERS or re.match(_SELECTORS, c)), "")


def foreign(name: str) -> str:
    """Return the first look-alike letter (such as a Cyrillic "a") in a word with ASCII letters, or an empty string."""
    mixed = (word for word in _WORD.findall(name) if not word.isascii() and any(map(str.isascii, word)))
    return next((letter for word in mixed for letter in word if ord(letter) in LATIN), "")


def in_words(letter: str) -> str:
    """Return the code point and Unicode name of a character, such as "U+200B ZERO WIDTH SPACE"."""
    from unicodedata import name

    return f"U+{ord(letter):04X} {name(letter, '')}".rstrip() + ("" if name(letter, "") else ", a control character")


def look(name: str, case: bool = True) -> str:
    """Return a key that is equal for names that look the same, ignoring upper and lower case if ``case`` is True."""
    if not name.isascii():
        from unicodedata import normalize

        name = normalize("NFKC", name)
        name = normalize("NFC", "".join(c for c in name if not hidden_letter(c))).translate(LATIN)
    return name.casefold() if case else name


def difference(name: str, other: str) -> str:
    """Describe how two names that look the same differ, such as "upper and lower case"."""
    from unicodedata import normalize

    letters = [letter for letter in name + other if (letter in name) != (letter in other)]
    if hidden := hidden_letter("".join(letters)):
        return f"{in_words(hidden)}, which is invisible"
    if normalize("NFC", name) == normalize("NFC", other):
        return "the Unicode form (NFC, NFD)"
    if name.casefold() == other.casefold():
        return "upper and lower case"
    return next((in_words(letter) for letter in letters if not letter.isascii()), "letters that look alike")


@lru_cache(maxsize=16)
def split_lines(text: str) -> list[str]:
    """Split text at the line ends that the YAML parser recognizes. The list is cached: do not modify it."""
    return re.split("\r\n|[\n\r\x85\u2028\u2029]", text)


def printable(text: str, keep: str = "") -> str:
    """Escape control characters except those in ``keep``, so that text cannot send commands to the terminal."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode("ascii") for c in text)


def mask_controls(text: str, keep: str = "") -> str:
    """Replace control characters except those in ``keep`` with question marks, for formats that cannot escape them."""
    return "".join(c if c.isprintable() or c in keep else "?" for c in text)


def plural(noun: str, count: int) -> str:
    """Return a noun in the plural, or unchanged if ``count`` is 1."""
    if count != 1 and noun.endswith("y") and noun[-2] not in "aeiou":
        return f"{noun[:-1]}ies"
    return noun if count == 1 else f"{noun}{'es' if noun.endswith(('s', 'x', 'sh', 'ch')) else 's'}"


def count_of(count: int, noun: str) -> str:
    """Format a number with a noun, such as "1 joint" or "2 joints"."""
    return f"{count:,} {plural(noun, count)}"


def first_of(names: Sequence[str], most: int) -> str:
    """Join names with commas; after ``most`` names, append a count such as " and 3 more"."""
    return f"{', '.join(names[:most])}{and_more(len(names) - most)}"


def and_more(count: int, of: str = "") -> str:
    """Return the end of a shortened list, such as " and 3 more", or an empty string if ``count`` is 0."""
    return f" and {count:,} more{f' {of}' if of else ''}" if count > 0 else ""


def phrase(words: Iterable[str], most: int | None = None) -> str:
    """Join words with commas and "and"; after ``most`` words, append a count such as " and 3 more"."""
    *others, last = list(words) or [""]
    if most is not None and len(others) >= most:
        return first_of([*others, last], most)
    return f"{', '.join(others)} and {last}" if others else last


def quote(names: Iterable[str], most: int | None = None) -> str:
    """Put names in quotes, and join them like ``phrase``."""
    return phrase((f'"{name}"' for name in names), most)

"""Words of messages: lists of names, letters that look alike, and "did you mean"."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from functools import lru_cache
from itertools import pairwise

MAX_COMPARED, MAX_LISTED, MAX_SUGGESTED = 60, 40, 3


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that is most similar to ``word``, or None if none is."""
    return next(iter(_similar(word, sorted(known))), None)


def _similar(word: str, names: list[str]) -> list[str]:
    """Return the most similar names; several only where they are equally likely."""
    if not word.isascii() and (same := [name for name in names if look(name) == look(word)]):
        return same[:1]
    if (known := set(names)) and (slips := [made for made in swaps(word) if made in known]):
        return slips[:1]
    own = _parts(word)
    if len(names) > MAX_COMPARED:  # comparing is slow, and there may be as many mistakes as names
        first = "".join(own)[:1] or word[:1]  # of /laser the l
        names = [name for name in names if name[:1].casefold() == first and abs(len(name) - len(word)) < 3]
        names = [name for name in names if name.casefold() == word.casefold()][:1] or names[:MAX_COMPARED]
    parts = {name: _parts(name) for name in names} if len(word) > 1 else {}  # everything is similar to one letter
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
    """Yield each word with two neighbouring letters of ``word`` swapped."""
    for at, (first, second) in enumerate(pairwise(word)):
        if first != second:
            yield f"{word[:at]}{second}{first}{word[at + 2 :]}"


def _parts(name: str) -> list[str]:
    return [part for part in re.split(r"[\W_]+", name.casefold()) if part]


def _contains(longer: list[str], shorter: list[str]) -> bool:
    """Return True if one name contains the words of another in a row, or begins or ends with them."""
    long, short = "".join(longer), "".join(shorter)
    is_end = len(short) > 3 and (long.startswith(short) or long.endswith(short))
    is_within = any(longer[i : i + len(shorter)] == shorter for i in range(len(longer) - len(shorter) + 1))
    return 2 < len(short) < len(long) and (is_end or is_within)


def suggest(*candidates: str) -> str:
    """Return the help for a word that is certainly one of the candidates: 'did you mean "x"?'."""
    return "did you mean " + " or ".join(f'"{name}"' for name in candidates) + "?"


def did_you_mean(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Return 'did you mean "x"?' for the nearest known words; else ``otherwise`` and the list of known words."""
    names = sorted(known)
    if close := _similar(word, names):
        looks_same = not (word + close[0]).isascii() and look(word) == look(close[0])
        reason = f" the two differ in {difference(word, close[0])}" if looks_same else ""
        return f"{suggest(*close)}{reason}"
    known = f"known: {first_of(names, MAX_LISTED)}" if names else ""
    return f"{otherwise} ({known})" if known and otherwise else known or otherwise


# Letters of Cyrillic, Greek and Armenian, each before the one of Latin that it looks like; and dashes. They are of
# Unicode's list of confusables (https://www.unicode.org/reports/tr39/) that a keyboard of another script types.
_ALIKE = (
    "аaсcеeоoрpхxуyіiјjѕsԁdһhԛqԝwѵvӏlАAВBЕEІIЈJКKМMНHОOРPСCТTУYХXЅSԌGҮY"
    "οoνvρpιiκkυuχxΑAΒBΕEΖZΗHΙIΚKΜMΝNΟOΡPΤTΥYΧXϲcϳj"
    "օoսuհhոnցgզqՕOՏS"
    "ɑaɡg‐-‑-‒-–-—-−-"
)
LATIN = str.maketrans(_ALIKE[::2], _ALIKE[1::2])
# Unseen though Unicode does not class them as control or format: joiners, fillers and variation selectors.
_FILLERS = "\u034f\u115f\u1160\u17b4\u17b5\u180b\u180c\u180d\u180f\u2800\u3164\uffa0"
_SELECTORS = re.compile("[\ufe00-\ufe0f\U000e0100-\U000e01ef]")
_WORD = re.compile(r"[^\W\d_]+")


def hidden_letter(name: str) -> str:
    """Return the first invisible letter of a name: a control character, a bidi mark, one without width."""
    if name.isascii() and name.isprintable():
        return ""
    from unicodedata import category

    kinds = ("Cc", "Cf", "Cs", "Zl", "Zp")
    return next((c for c in name if category(c) in kinds or c in _FILLERS or _SELECTORS.match(c)), "")


def foreign(name: str) -> str:
    """Return the first letter of another script that looks like a Latin one, in a word with Latin letters."""
    mixed = (word for word in _WORD.findall(name) if not word.isascii() and any(map(str.isascii, word)))
    return next((letter for word in mixed for letter in word if ord(letter) in LATIN), "")


def in_words(letter: str) -> str:
    """Return a letter by its number and its name in Unicode: U+200B ZERO WIDTH SPACE."""
    from unicodedata import name

    return f"U+{ord(letter):04X} {name(letter, '')}".rstrip() + ("" if name(letter, "") else ", a control character")


def look(name: str, case: bool = True) -> str:
    """Return a key that is equal for names that look alike; with ``case``, it ignores upper and lower case."""
    if not name.isascii():
        from unicodedata import normalize

        name = normalize("NFKC", name)
        name = normalize("NFC", "".join(c for c in name if not hidden_letter(c))).translate(LATIN)
    return name.casefold() if case else name


def difference(name: str, other: str) -> str:
    """Return a description of how a name differs from another one that looks like it."""
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
    """Return the lines of a text, as YAML counts them; the list is not to be changed."""
    return re.split("\r\n|[\n\r\x85\u2028\u2029]", text)


def printable(text: str, keep: str = "") -> str:
    """Return a text with control characters, except those in ``keep``, made visible: no file steers the terminal."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode("ascii") for c in text)


def mask_controls(text: str, keep: str = "") -> str:
    """Return a text with a question mark for each control character, for files that have no place for them."""
    return "".join(c if c.isprintable() or c in keep else "?" for c in text)


def plural(noun: str, count: int) -> str:
    """Return a noun as it is written after a number."""
    if count != 1 and noun.endswith("y") and noun[-2] not in "aeiou":
        return f"{noun[:-1]}ies"
    return noun if count == 1 else f"{noun}{'es' if noun.endswith(('s', 'x', 'sh', 'ch')) else 's'}"


def count_of(count: int, noun: str) -> str:
    """Return a number of things in words."""
    return f"{count:,} {plural(noun, count)}"


def first_of(names: Sequence[str], most: int) -> str:
    """Return names in a row; of more than ``most`` the first ones and the number of the others."""
    return f"{', '.join(names[:most])}{and_more(len(names) - most)}"


def and_more(count: int, of: str = "") -> str:
    """Return the end of a sentence that names some things of many; nothing if none is left."""
    return f" and {count:,} more{f' {of}' if of else ''}" if count > 0 else ""


def phrase(words: Iterable[str], most: int | None = None) -> str:
    """Return words as in a sentence; of more than ``most`` the first ones and the number of the others."""
    *others, last = list(words) or [""]
    if most is not None and len(others) >= most:
        return first_of([*others, last], most)
    return f"{', '.join(others)} and {last}" if others else last


def quote(names: Iterable[str], most: int | None = None) -> str:
    """Return names in quotes, as in a sentence."""
    return phrase((f'"{name}"' for name in names), most)

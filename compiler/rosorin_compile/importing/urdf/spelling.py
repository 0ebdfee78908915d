"""Spelling: which known word an unknown one was meant to be."""

from __future__ import annotations

from collections.abc import Iterable


def meant(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that ``word`` is a misspelling of, None if it is a word of its own.

    One letter too many, too few, wrong or swapped is a misspelling, of long words two; so is another case. A word with
    a prefix (``drake:mass``) belongs to somebody.
    """
    if ":" in word:
        return None
    best: tuple[int, str] | None = None
    for other in known:
        allowed = 0 if min(len(word), len(other)) < 3 else 1 if len(other) < 7 else 2
        if abs(len(word) - len(other)) > allowed:
            continue
        distance = 0 if word.lower() == other.lower() else _distance(word.lower(), other.lower())
        if distance <= allowed and (best is None or (distance, other) < best):
            best = (distance, other)
    return best[1] if best else None


def _distance(one: str, other: str) -> int:
    """Return how many letters are added, left out, changed or swapped (optimal string alignment)."""
    before: list[int] = []
    last = list(range(len(other) + 1))
    for i, a in enumerate(one, 1):
        row = [i]
        for j, b in enumerate(other, 1):
            cost = min(last[j] + 1, row[-1] + 1, last[j - 1] + (a != b))
            if i > 1 and j > 1 and a == other[j - 2] and one[i - 2] == b:
                cost = min(cost, before[j - 2] + 1)
            row.append(cost)
        before, last = last, row
    return last[-1]

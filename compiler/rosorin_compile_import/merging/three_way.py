"""Three-way: what a newer source changes in a tree, and what somebody has changed in it since, put together.

``base`` is what the importer wrote, ``ours`` what stands there now, ``theirs`` what the importer writes of the newer
source. A value that one side alone has changed is that of this side; one that both have changed to the same is that;
any other is a conflict. This is the three-way merge of version control, of values by their keys instead of lines:
where a value stands in its file, and how it is written, says nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from difflib import SequenceMatcher
from typing import Any, NamedTuple

from rosorin_compile.extending import Path, fragment_at

from ..layout import within_part

OURS, THEIRS = "ours", "theirs"
_WHOLE = ("inertia",)  # a tensor is one value: half of one and half of another is none


class Missing:
    """What stands for a value that is not there."""

    def __repr__(self) -> str:
        return "MISSING"


MISSING = Missing()


class Conflict(NamedTuple):
    """A value that both sides have changed: its path, how it was, how it is here and in the newer source."""

    path: Path
    base: Any
    ours: Any
    theirs: Any


class Change(NamedTuple):
    """What one side has changed at a path: ``old`` and ``new``, MISSING where there is none.

    ``items`` are those of a list that was put together: the side of each, and its number there.
    """

    path: Path
    old: Any
    new: Any
    items: Sequence[tuple[str, int]] | None = None


class Merge(NamedTuple):
    """A tree put together: its value, what it takes of the newer source, what was changed here, and the conflicts."""

    value: Any
    taken: list[Change]
    own: list[Change]
    conflicts: list[Conflict]


def merged(base: Any, ours: Any, theirs: Any, keep_ours: bool = False) -> Merge:
    """Return three trees put together; with ``keep_ours`` there are no conflicts: ours stays."""
    merging = _Merging(keep_ours)
    value = merging.value(base, ours, theirs, ())
    return Merge(value, merging.taken, merging.own, merging.conflicts)


def whole(base: Any, ours: Any, theirs: Any, keep_ours: bool = False) -> Merge:
    """Return which of three states of a file counts, of which nothing is put together; MISSING is no file."""
    merging = _Merging(keep_ours)
    value = ours if same(ours, theirs) else merging.one(base, ours, theirs, ())
    return Merge(value, merging.taken, merging.own, merging.conflicts)


def same(one: Any, other: Any) -> bool:
    """Say whether two values are the same: a number is, however it is written, and true is no number."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, bool) or isinstance(other, bool):
        return one is other
    if isinstance(one, float) and isinstance(other, float) and math.isnan(one):
        return math.isnan(other)
    return bool(one == other)


class _Merging:
    def __init__(self, keep_ours: bool) -> None:
        self.keep_ours = keep_ours
        self.taken: list[Change] = []
        self.own: list[Change] = []
        self.conflicts: list[Conflict] = []

    def value(self, base: Any, ours: Any, theirs: Any, path: Path) -> Any:
        """Return what a value is to be."""
        if same(ours, theirs):
            return ours
        old, own, new = sides = [_emptied(side, path, base, ours, theirs) for side in (base, ours, theirs)]
        if all(isinstance(side, dict) for side in sides) and not (path and path[-1] in _WHOLE):
            return self.mapping(old, own, new, path, theirs)
        if all(isinstance(side, list) for side in sides):
            return self.sequence(old, own, new, path, theirs)
        return self.one(base, ours, theirs, path)

    def one(self, base: Any, ours: Any, theirs: Any, path: Path) -> Any:
        """Return which of two different values counts."""
        if same(base, ours):
            self.taken.append(Change(path, ours, theirs))
            return theirs
        if same(base, theirs):
            self.own.append(Change(path, base, ours))
            return ours
        if self.keep_ours:
            self.own.append(Change(path, theirs, ours))
        else:
            self.conflicts.append(Conflict(path, base, ours, theirs))
        return ours

    def mapping(self, base: Any, ours: Any, theirs: Any, path: Path, wanted: Any) -> Any:
        """Return a mapping put together; ``wanted`` is what the newer source has there, perhaps nothing."""
        before = len(self.taken)
        made = {}
        for key in dict.fromkeys((*ours, *theirs, *base)):
            old, own, new = (side.get(key, MISSING) for side in (base, ours, theirs))
            value = self.value(old, own, new, (*path, key))
            if value is not MISSING:
                made[key] = value
        is_section = len(within_part(path)) < 2
        if not ours or not path or (made and is_section) or any(key in made for key in ours):
            return made
        del self.taken[before:]  # nothing of it stays: what holds it is gone, or holds something else altogether
        self.taken.append(Change(path, ours, wanted))
        return wanted

    def sequence(self, base: Any, ours: Any, theirs: Any, path: Path, wanted: Any) -> Any:
        """Return a list put together."""
        if _is_one_value(base, ours, theirs) or not (ours or base):
            return self.one(base, ours, wanted, path)
        if len(base) == len(ours) == len(theirs) and not (_is_moved(base, ours) or _is_moved(base, theirs)):
            rows = zip(base, ours, theirs, strict=True)
            return [self.value(old, own, new, (*path, number)) for number, (old, own, new) in enumerate(rows)]
        items = _woven(base, ours, theirs)
        if items is None:
            return self.one(base, ours, wanted, path)
        made = [{OURS: ours, THEIRS: theirs}[side][number] for side, number in items]
        whole = not made and bool(ours) and not theirs
        if not same(made, ours):
            self.taken.append(Change(path, ours, wanted if whole else made, None if whole else items))
        if not same(made, theirs):
            self.own.append(Change(path, base, ours))
        return wanted if whole else made


def _emptied(side: Any, path: Path, *sides: Any) -> Any:
    """Return a section that is missing on one side as an empty one: the entries of the others count for themselves.

    One whose keys are no names is one entry: what one side has removed and the other changed is a conflict.
    """
    if side is not MISSING or len(within_part(path)) != 1 or sides[1] is MISSING:
        return side
    others = [one for one in sides if one is not MISSING]
    if all(isinstance(one, list) for one in others):
        return []
    by_name = "properties" not in fragment_at(within_part(path))
    return {} if by_name and all(isinstance(one, dict) for one in others) else side


def _is_one_value(*lists: Sequence[Any]) -> bool:
    """Say whether lists are one value each, such as a position: of some of its numbers no other one is made."""
    items = [item for one in lists for item in one]
    return (
        bool(items)
        and not any(isinstance(item, dict | list | tuple) for item in items)
        and any(isinstance(item, int | float) and not isinstance(item, bool) for item in items)
    )


def _is_moved(base: Sequence[Any], side: Sequence[Any]) -> bool:
    """Say whether an item of a list has become another item's neighbour, with the same number of items."""
    known = set(map(_key, base))
    return any(not same(one, other) and _key(other) in known for one, other in zip(base, side, strict=True))


def _key(value: Any) -> str:
    """Return a text that is the same for values that are, and for no others."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key!r}: {_key(value[key])}' for key in sorted(value))}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_key, value))}]"
    if isinstance(value, int | float) and not isinstance(value, bool):
        return repr(float(value)) if abs(value) < 2**53 else repr(value)
    return repr(str(value)) if isinstance(value, str) else repr(value)


def _woven(base: Sequence[Any], ours: Sequence[Any], theirs: Sequence[Any]) -> list[tuple[str, int]] | None:
    """Return the items of a list put together, each by its side and number there; None for a conflict."""
    keys = [list(map(_key, side)) for side in (base, ours, theirs)]
    made: list[tuple[str, int]] = []
    for old, own, new in _chunks(*keys):
        before, here, there = keys[0][slice(*old)], keys[1][slice(*own)], keys[2][slice(*new)]
        if before == there or here == there:
            made += [(OURS, number) for number in range(*own)]
        elif before == here:
            made += [(THEIRS, number) for number in range(*new)]
        elif not before:  # both have added something
            made += [(OURS, number) for number in range(*own)]
            made += [(THEIRS, number) for number in range(*new) if keys[2][number] not in here]
        else:
            return None
    return made


_Range = tuple[int, int]


def _chunks(base: list[str], ours: list[str], theirs: list[str]) -> Iterator[tuple[_Range, _Range, _Range]]:
    """Yield three lists in pieces that belong together, as diff3 has them: what all have alike, and what lies between.

    S. Khanna, K. Kunal, B. C. Pierce, "A Formal Investigation of Diff3", 2007.
    """
    own, new = ({i + k: j + k for i, j, count in SequenceMatcher(None, base, side, False).get_matching_blocks()
                 for k in range(count)} for side in (ours, theirs))  # fmt: skip
    at = [0, 0, 0]
    for number in [*(one for one in sorted(own) if one in new), len(base)]:
        stable = (number, own.get(number, len(ours)), new.get(number, len(theirs)))
        yield tuple(zip(at, stable, strict=True))  # type: ignore[misc]
        if number < len(base):
            yield tuple((one, one + 1) for one in stable)  # type: ignore[misc]
        at = [one + 1 for one in stable]

"""How a change of shapes is said: all that became of a solid in one sentence, what it looks like in one of its own.

Of a few solids each is said; of more how many changed, and by how much.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from rosorin_compile.formats.facts import AXES, SIZES, Solid
from rosorin_compile.formats.format import About
from rosorin_compile.model import Pose, Transform
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.wording import counted

from .solids_old import Delta, largest_step, turned_by
from .tolerance import NOISE, joined
from .wording import (
    Row,
    Sentence,
    Step,
    colour_change,
    coordinates,
    far,
    number,
    number_pair,
    origin_text,
    row,
    row_pair,
    step,
    steps_row,
)

# So many solids of a link are said one by one.
FEW = 5
NO_WORD = "nothing"
_FILE = "file "
_LOOK = ("red", "green", "blue", "alpha")


class Told(NamedTuple):
    """What became of some solids, in sentences: their numbers, and what else is said of them."""

    numbers: list[Sentence]
    words: list[Sentence]


def shapes_change(link: str, purpose: str, counts: tuple[int, int], difference: Delta) -> Told:
    """Return what became of the solids of a link, of which there were and are so many."""
    before, after = counts
    removed, added = difference
    about = About(link, purpose)
    few = max(len(removed), len(added)) <= FEW
    pairs = likened(removed, added) if few else [(at, at) for at in range(len(added))] * (len(removed) == len(added))
    solids = [(removed[old], added[new]) for old, new in pairs]
    words = list(dict.fromkeys(sentence for both in solids for sentence in words_change(about, *both)))
    if few:
        numbers = [sentence for both in solids for sentence in numbers_change(about, *both)]
        if before != after:
            numbers.append(Sentence(f"{about}: {before} -> {after} shapes", "", _count_row(about, counts)))
        return Told(numbers, words)
    words = words if len(words) <= FEW else []
    if words and all(not numbers_change(about, *both) for both in solids):
        return Told([], words)
    changed = min(len(removed), len(added))
    largest = largest_step(difference) if changed else None
    far_text = f", up to {amount(largest, 'm')}" if largest else ""
    made = _count_row(about, counts)._replace(by=f"{changed} changed{far_text}" if changed else "")
    if before == after:
        return Told([Sentence(f"{about}: {changed} of {counted(before, 'shape')} changed{far_text}", "", made)], words)
    also = f", {changed} of them changed{far_text}" if changed else ""
    return Told([Sentence(f"{about}: {before} -> {after} shapes{also}", "", made)], words)


def _count_row(about: About, counts: tuple[int, int]) -> Row:
    return Row(about.name, f"{about.quantity} shapes", str(counts[0]), str(counts[1]))


def likened(old: Sequence[Solid], new: Sequence[Solid]) -> list[tuple[int, int]]:
    """Return which of a few solids became which, by their places: in their order, unless others are more alike."""
    rated = sorted((_unlike(one, other), i, j) for i, one in enumerate(old) for j, other in enumerate(new))
    found: dict[int, int] = {}
    for _, i, j in rated:
        if i not in found and j not in found.values():
            found[i] = j
    ordered = {index: index for index in range(len(old))} if len(old) == len(new) else found
    costs = [sum(_unlike(old[i], new[j])[0] for i, j in pairs.items()) for pairs in (ordered, found)]
    return sorted((ordered if costs[0] <= costs[1] else found).items())


def _unlike(one: Solid, other: Solid) -> tuple[int, float]:
    """Return how many things two solids differ in, and how far their middles are apart (m)."""
    kinds = len(SIZES) * (one.kind != other.kind)
    return kinds + sum(a != b for a, b in zip(one[1:5], other[1:5], strict=True)), math.dist(one.centre, other.centre)


class _Part(NamedTuple):
    """One thing that became of a solid: in words, how much it is, and the same for a row of a table."""

    text: str
    remark: str
    row: Row


def words_change(about: About, one: Solid, other: Solid) -> list[Sentence]:
    """Return what is said otherwise of a solid beside its numbers: its colour, name, material or file."""
    old, new = (_look(solid) for solid in (one, other))
    looks = row_pair(old, new) if len(old) == len(new) > 0 else (row(old), row(new))
    found = [colour_change(about, *looks)] if old != new else []
    before, after = (_words(solid, one.kind == other.kind) for solid in (one, other))
    if before == after:
        return found
    text, words = _words_change(before, after)
    made = Row(about.name, f"{about.quantity} {other.kind}", *words)
    return [*found, Sentence(f"{about}: {other.kind} {text}", "", made)]


def numbers_change(about: About, one: Solid, other: Solid) -> list[Sentence]:
    """Return what became of a solid in one sentence: another kind, size or place; none if words alone changed."""
    parts = _parts(about, one, other, tolerant=True)
    if not parts and one.words == other.words:
        parts = _parts(about, one, other, tolerant=False)
    if not parts:
        return []
    start = f"{about}: " if one.kind != other.kind else f"{about}: {one.kind} "
    if len(parts) == 1:
        return [Sentence(start + parts[0].text, parts[0].remark, parts[0].row)]
    text = ", ".join(str(Sentence(*part)) for part in parts)
    before, after = (", ".join(_told(about, part.row, side) for part in parts) for side in ("before", "after"))
    by = ", ".join(part.row.by for part in parts if part.row.by)
    return [Sentence(start + text, "", Row(about.name, f"{about.quantity} {other.kind}", before, after, by))]


def _told(about: About, part: Row, side: str) -> str:
    """Return a value of a part with what it is a value of, if that is not clear by itself."""
    name = part.quantity.removeprefix(about.quantity).strip().partition(" ")[2]
    return f"{name} {getattr(part, side)}".strip()


def _parts(about: About, one: Solid, other: Solid, tolerant: bool) -> list[_Part]:
    """Return what became of a solid, each thing once."""
    parts: list[_Part] = []
    made = Row(about.name, f"{about.quantity} {one.kind}")
    if one.kind != other.kind:
        kinds = _sized(one), _sized(other)
        parts.append(_Part(" -> ".join(kinds), "", Row(*about[:2], *kinds)))
    boxes = one.box is not None and other.box is not None
    if one.kind == other.kind == "mesh":
        if one.sizes != other.sizes:
            scales = row(one.sizes), row(other.sizes)
            scaled = Row(about.name, f"{about.quantity} mesh scale", *scales)
            parts.append(_Part(f"scale {' -> '.join(scales)}", "", scaled))
    elif one.kind == other.kind and (numbers := _numbers_change(one, other)):
        parts.append(_sizes_change(about, one.kind, numbers))
    if not boxes:  # the corners of a box along the axes say where it is
        parts += _place_change(about, made, (one, other), tolerant)
    return parts


def _sized(solid: Solid) -> str:
    """Return a solid with its file or its sizes."""
    if solid.kind == "mesh":
        return " ".join([solid.kind, *(word for word in solid.words if word.startswith(_FILE))])
    sizes = [f"{name} {number(size)} m" for name, size in zip(SIZES.get(solid.kind, ()), solid.sizes, strict=False)]
    return f"{solid.kind} ({', '.join(sizes)})" if sizes else solid.kind


def _place_change(about: About, made: Row, solids: tuple[Solid, Solid], tolerant: bool) -> list[_Part]:
    """Return where a solid went, if it did; as well as that is known, where that is asked for."""
    one, other = solids
    known = joined(one.tolerance, other.tolerance), joined(one.turn_tolerance, other.turn_tolerance)
    least = (NOISE + known[0], NOISE + known[1]) if tolerant else (0.0, 0.0)
    distance, angle = math.dist(one.centre, other.centre), turned_by(one, other)
    distance, angle = (distance if distance > least[0] else 0.0), (angle if angle > least[1] else 0.0)
    if not distance and not angle:
        return []
    poses = [pose_of(Transform(solid.rows, solid.centre)) for solid in solids]
    steps = coordinates(poses[0], _near(poses[0], poses[1]), distance, angle, least)
    moved = steps_row(about.name, steps, f"{made.quantity} origin")._replace(by=far(distance, angle))
    if len(steps) == 1 and distance == 0:
        moved = moved._replace(quantity=f"{made.quantity} {steps[0].name}")
    return [_Part(far(distance, angle, verbs=True), origin_text(steps), moved)]


def _near(old: Pose, new: Pose) -> Pose:
    """Return a pose with angles as near to those of another one as they can be written: none jumps by a full turn."""
    turns = (b - math.tau * round((b - a) / math.tau) for a, b in zip(old.rpy, new.rpy, strict=True))
    roll, pitch, yaw = turns
    return Pose(new.xyz, (roll, pitch, yaw))


def _sizes_change(about: About, kind: str, numbers: Sequence[tuple[str, float, float]]) -> _Part:
    """Return what became of the sizes of a solid: their names, and what they were and are (m)."""
    steps = [Step(name, *number_pair(old, new), "m") for name, old, new in numbers]
    _, old, new = numbers[0]
    by = step(new - old, old, "m") if len(numbers) == 1 else ""
    return _Part(
        ", ".join(map(str, steps)), by, steps_row(about.name, steps, f"{about.quantity} {kind}")._replace(by=by)
    )


def _numbers_change(one: Solid, other: Solid) -> list[tuple[str, float, float]]:
    """Return the sizes that changed, of boxes along the axes their corners, each with its name."""
    allowed = joined(one.tolerance, other.tolerance)
    boxes = one.box, other.box
    if boxes[0] is not None and boxes[1] is not None:
        names = [f"{end} {axis}" for end in ("min", "max") for axis in AXES]
        sizes = [(*box.lower, *box.upper) for box in boxes if box is not None]
        rows = zip(names, *sizes, strict=True)
    else:
        rows = zip(SIZES.get(one.kind, ()), one.sizes, other.sizes, strict=False)
    steps = [(name, a, b) for name, a, b in rows if abs(b - a) > NOISE]
    return [(name, a, b) for name, a, b in steps if abs(b - a) > allowed] or (steps if all(boxes) else [])


def _words_change(old: Sequence[str], new: Sequence[str]) -> tuple[str, tuple[str, str]]:
    """Return which words about a shape are others now, together and apart; what both begin with is said once."""
    before, after = ([word for word in some if word not in rest] for some, rest in ((old, new), (new, old)))
    if len(before) == len(after) == 1 and before[0].split(" ")[0] == after[0].split(" ")[0]:
        return f"{before[0]} -> {after[0].partition(' ')[2]}", (before[0], after[0])
    words = ", ".join(before) or NO_WORD, ", ".join(after) or NO_WORD
    return " -> ".join(words), words


def _look(solid: Solid) -> tuple[float, ...]:
    """Return the colour of a solid, as its words have it."""
    values = dict(word.split(" ", 1) for word in solid.words if word.split(" ", 1)[0] in _LOOK)
    return tuple(float(values[part]) for part in _LOOK if part in values)


def _words(solid: Solid, with_file: bool) -> list[str]:
    """Return what is said of a solid beside its colour."""
    words = [word for word in solid.words if word.split(" ")[0] not in _LOOK]
    return words if with_file else [word for word in words if not word.startswith(_FILE)]

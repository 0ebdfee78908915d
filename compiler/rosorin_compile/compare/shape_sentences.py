"""Put changes of shapes into sentences: all that became of a solid in one, what it looks like in one of its own.

Of a few solids each is told; of more how many changed, and by how much.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from rosorin_compile.model import Pose, Transform
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.wording import counted

from .precision import NOISE, joined
from .sentences import (
    AXES,
    About,
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
    step,
    steps_row,
)
from .solids import SIZES, Delta, Solid, largest_step, turned_by

# So many solids of a link are told one by one.
FEW = 5
NO_WORD = "nothing"
_FILE = "file "


class ShapeChange(NamedTuple):
    """What became of some solids, in sentences: their numbers, and how they look and are called."""

    numbers: list[Sentence]
    words: list[Sentence]


def shapes_change(link: str, purpose: str, counts: tuple[int, int], difference: Delta) -> ShapeChange:
    """Return what became of the solids of a link, of which there were and are so many."""
    before, after = counts
    removed, added = difference
    about = About(link, purpose)
    few = max(len(removed), len(added)) <= FEW
    pairs = likened(removed, added) if few else [(at, at) for at in range(len(added))] * (len(removed) == len(added))
    solids = [(removed[old], added[new]) for old, new in pairs]
    words = list(dict.fromkeys(sentence for both in solids for sentence in words_change(about, *both)))
    count = Row(link, f"{purpose} shapes", str(before), str(after))
    if few:
        numbers = [sentence for both in solids for sentence in numbers_change(about, *both)]
        if before != after:
            numbers.append(Sentence(f"{about}: {before} -> {after} shapes", "", count))
        return ShapeChange(numbers, words)
    words = words if len(words) <= FEW else []
    if words and not any(numbers_change(about, *both) for both in solids):
        return ShapeChange([], words)
    changed = min(len(removed), len(added))
    largest = largest_step(difference) if changed else None
    far_text = f", up to {amount(largest, 'm')}" if largest else ""
    count = count._replace(by=f"{changed} changed{far_text}" if changed else "")
    if before == after:
        return ShapeChange(
            [Sentence(f"{about}: {changed} of {counted(before, 'shape')} changed{far_text}", "", count)], words
        )
    also = f", {changed} of them changed{far_text}" if changed else ""
    return ShapeChange([Sentence(f"{about}: {before} -> {after} shapes{also}", "", count)], words)


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
    return kinds + sum(a != b for a, b in zip(one[1:6], other[1:6], strict=True)), math.dist(one.centre, other.centre)


def words_change(about: About, one: Solid, other: Solid) -> list[Sentence]:
    """Return what changed of a solid beside its numbers: its colour, name, material or file."""
    tint = NOISE + joined(one.colour_tolerance, other.colour_tolerance)
    same = one.rgba == other.rgba or (
        None not in (one.rgba, other.rgba)
        and all(abs(a - b) <= tint for a, b in zip(one.rgba or (), other.rgba or (), strict=True))
    )
    found = [] if same else [colour_change(about, one.rgba, other.rgba)]
    with_file = one.kind == other.kind
    before, after = ([w for w in s.words if with_file or not w.startswith(_FILE)] for s in (one, other))
    if before == after:
        return found
    old, new = ([word for word in some if word not in rest] for some, rest in ((before, after), (after, before)))
    if len(old) == len(new) == 1 and old[0].split(" ")[0] == new[0].split(" ")[0]:
        text, words = f"{old[0]} -> {new[0].partition(' ')[2]}", (old[0], new[0])
    else:
        words = ", ".join(old) or NO_WORD, ", ".join(new) or NO_WORD
        text = " -> ".join(words)
    row = Row(about.name, f"{about.quantity} {other.kind}", *words)
    return [*found, Sentence(f"{about}: {other.kind} {text}", "", row)]


def numbers_change(about: About, one: Solid, other: Solid) -> list[Sentence]:
    """Return what became of a solid in one sentence: another kind, size or place; none if words alone changed."""
    parts = _parts(about, one, other, tolerant=True)
    if not parts and (one.words, one.rgba) == (other.words, other.rgba):
        parts = _parts(about, one, other, tolerant=False)
    if not parts:
        return []
    start = f"{about}: " if one.kind != other.kind else f"{about}: {one.kind} "
    if len(parts) == 1:
        return [Sentence(start + parts[0].text, parts[0].remark, parts[0].row)]
    text = ", ".join(map(str, parts))
    before, after = (", ".join(_value(about, part.row, side) for part in parts) for side in ("before", "after"))
    by = ", ".join(part.row.by for part in parts if part.row.by)
    return [Sentence(start + text, "", Row(about.name, f"{about.quantity} {other.kind}", before, after, by))]


def _value(about: About, part: Row, side: str) -> str:
    """Return a value of a part with what it is a value of, if that is not clear by itself."""
    name = part.quantity.removeprefix(about.quantity).strip().partition(" ")[2]
    return f"{name} {getattr(part, side)}".strip()


def _parts(about: About, one: Solid, other: Solid, tolerant: bool) -> list[Sentence]:
    """Return what became of a solid, each thing once."""
    parts: list[Sentence] = []
    if one.kind != other.kind:
        kinds = _sized(one), _sized(other)
        parts.append(Sentence(" -> ".join(kinds), "", Row(*about[:2], *kinds)))
    elif one.kind == "mesh":
        if one.sizes != other.sizes:
            scales = row(one.sizes), row(other.sizes)
            scaled = Row(about.name, f"{about.quantity} mesh scale", *scales)
            parts.append(Sentence(f"scale {' -> '.join(scales)}", "", scaled))
    elif numbers := _sizes(one, other):
        steps = [Step(name, *number_pair(old, new), "m") for name, old, new in numbers]
        _, old, new = numbers[0]
        by = step(new - old, old, "m") if len(numbers) == 1 else ""
        sizes = steps_row(about.name, steps, f"{about.quantity} {one.kind}")._replace(by=by)
        parts.append(Sentence(", ".join(map(str, steps)), by, sizes))
    if one.box is None or other.box is None:  # the corners of a box along the axes say where it is
        parts += _place(about, one, other, tolerant)
    return parts


def _sized(solid: Solid) -> str:
    """Return a solid with its file or its sizes."""
    if solid.kind == "mesh":
        return " ".join([solid.kind, *(word for word in solid.words if word.startswith(_FILE))])
    sizes = [f"{name} {number(size)} m" for name, size in zip(SIZES[solid.kind], solid.sizes, strict=True)]
    return f"{solid.kind} ({', '.join(sizes)})"


def _place(about: About, one: Solid, other: Solid, tolerant: bool) -> list[Sentence]:
    """Return where a solid went, if it did; as well as that is known, where that is asked for."""
    known = joined(one.tolerance, other.tolerance), joined(one.turn_tolerance, other.turn_tolerance)
    least = (NOISE + known[0], NOISE + known[1]) if tolerant else (0.0, 0.0)
    distance, angle = math.dist(one.centre, other.centre), turned_by(one, other)
    distance, angle = (distance if distance > least[0] else 0.0), (angle if angle > least[1] else 0.0)
    if not distance and not angle:
        return []
    old, new = (pose_of(Transform(solid.rows, solid.centre)) for solid in (one, other))
    # No angle jumps by a full turn.
    roll, pitch, yaw = (b - math.tau * round((b - a) / math.tau) for a, b in zip(old.rpy, new.rpy, strict=True))
    steps = coordinates(old, Pose(new.xyz, (roll, pitch, yaw)), distance, angle, least)
    name = f"{about.quantity} {one.kind}"
    moved = steps_row(about.name, steps, f"{name} origin")._replace(by=far(distance, angle))
    if len(steps) == 1 and distance == 0:
        moved = moved._replace(quantity=f"{name} {steps[0].name}")
    return [Sentence(far(distance, angle, verbs=True), origin_text(steps), moved)]


def _sizes(one: Solid, other: Solid) -> list[tuple[str, float, float]]:
    """Return the sizes that changed, of boxes along the axes their corners, each with its name."""
    allowed = joined(one.tolerance, other.tolerance)
    first, second = one.box, other.box
    if first is not None and second is not None:
        names = [f"{end} {axis}" for end in ("min", "max") for axis in AXES]
        rows = zip(names, (*first.lower, *first.upper), (*second.lower, *second.upper), strict=True)
    else:
        rows = zip(SIZES[one.kind], one.sizes, other.sizes, strict=True)
    steps = [(name, a, b) for name, a, b in rows if abs(b - a) > NOISE]
    return [(name, a, b) for name, a, b in steps if abs(b - a) > allowed] or (steps if first and second else [])

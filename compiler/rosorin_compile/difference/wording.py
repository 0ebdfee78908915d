"""Wording: numbers, lengths and lists as the lines of a comparison say them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..compare.words import amount, number_pair, step
from ..formatting import exact
from ..wording import first_of
from .values import Item

_MOST = 3


def number(value: float, other: float | None = None) -> str:
    """Return a number in print, with the digits that tell it from another one."""
    if other is not None and other != value:
        return number_pair(value, other)[0]
    return exact(float(f"{value:.6g}"))


def row(values: Iterable[float]) -> str:
    """Return numbers in a row."""
    return " ".join(number(value) for value in values)


def far(distance: float, angle: float, verbs: bool = False) -> str:
    """Return a length (m) and an angle (rad), each only if it is not zero.

    >>> far(0.002, 0.0), far(0.0, 0.01), far(0.002, 0.01, verbs=True)
    ('2.0 mm', '0.57 deg', 'moved 2.0 mm and turned 0.57 deg')
    """
    values = (("moved ", distance, "m"), ("turned ", angle, "rad"))
    parts = [f"{verb if verbs else ''}{amount(value, unit)}" for verb, value, unit in values if value > 1e-12]
    return " and ".join(parts) or "0 mm"


def several(names: Sequence[str]) -> str:
    """Return the first names of a list and the number of the others."""
    return first_of(names, _MOST)


def changed(kind: str, name: str, quantity: str, values: tuple[float | None, float | None], unit: str) -> Item:
    """Return the line about a number that changed; None is a number that is not given."""
    old, new = values
    subject = f"{name} {quantity}"
    if old is None or new is None:
        said = number(old if new is None and old is not None else new or 0.0)
        text = f"{subject}: {'removed, was' if new is None else 'new,'} {said} {unit}".rstrip()
        return Item(kind, name, quantity, text, old, new, unit)
    before, after = number_pair(old, new)
    remark = step(new - old, old, unit)
    text = f"{subject} {before} -> {after} {unit}".rstrip() + (f" ({remark})" if remark else "")
    return Item(kind, name, quantity, text, old, new, unit)

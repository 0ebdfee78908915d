"""Describe differences in sentences, with enough digits to distinguish the old from the new value."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

from rosorin_compile.model import Pose, Vector
from rosorin_compile.model.geometry import angle_between, norm
from rosorin_compile.source.numbers import SMALL, amount, exact, few_digits
from rosorin_compile.source.wording import count_of, first_of, printable

from .precision import NOISE

AXES = ("x", "y", "z")
ANGLES = ("roll", "pitch", "yaw")
INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
NEW, REMOVED = "new", "removed"
_MAX_TEXT = 60
_MOST = 3
# Differences up to this length (m) or angle (rad) are rounding errors.
_LEAST = 1e-12
# The change of a coordinate is printed if it is more than this fraction of the distance between the poses.
_SHARE = 1e-9
# A distance (m) and an angle (rad), either between two poses or as the largest error of a pose.
Apart = tuple[float, float]


def number(value: float, other: float | None = None) -> str:
    """Format a number with six significant digits, or more if needed to distinguish it from ``other``."""
    return exact(float(f"{value:.6g}")) if other is None or other == value else number_pair(value, other)[0]


def number_pair(old: float, new: float) -> tuple[str, str]:
    """Format two different numbers with the fewest digits, at least six, that show their difference.

    >>> number_pair(0.0136322197327749, 0.015), number_pair(0.1, 0.1000000001)
    (('0.0136322', '0.015'), ('0.1', '0.1000000001'))
    """
    difference = abs(new - old)
    for digits in range(6, 17):
        before, after = float(f"{old:.{digits}g}"), float(f"{new:.{digits}g}")
        if before != after and abs(abs(after - before) - difference) <= 0.05 * difference:
            return exact(before), exact(after)
    return exact(old), exact(new)


def row(values: Iterable[float]) -> str:
    """Format numbers, separated by spaces."""
    return " ".join(number(value) for value in values)


def several(names: Sequence[str]) -> str:
    """Join the first three names, and append the number of the rest."""
    return first_of(names, _MOST)


def step(difference: float, old: float, unit: str) -> str:
    """Format a signed change in mm, deg or g, or for other units as a percentage of ``old``; "" without a unit."""
    sign = "-" if difference < 0 else "+"
    if unit in SMALL:
        return f"{sign}{amount(abs(difference), unit)}"
    return f"{sign}{few_digits(abs(difference / old) * 100)} %" if unit and old else ""


def far(distance: float, angle: float, verbs: bool = False) -> str:
    """Format a length (m) and an angle (rad), leaving out zeros.

    >>> far(0.002, 0.0), far(0.0, 0.01), far(0.002, 0.01, verbs=True)
    ('2.0 mm', '0.57 deg', 'moved 2.0 mm and turned 0.57 deg')
    """
    values = (("moved ", distance, "m"), ("turned ", angle, "rad"))
    parts = [f"{verb if verbs else ''}{amount(value, unit)}" for verb, value, unit in values if value > _LEAST]
    return " and ".join(parts) or "0 mm"


def with_remark(text: str, remark: str) -> str:
    """Append a remark in parentheses to a sentence, or add it to existing parentheses at the end."""
    if not remark:
        return text
    return f"{text[:-1]}; {remark})" if text.endswith(")") else f"{text} ({remark})"


def value_change(about: str, old: Any, new: Any, unit: str = "") -> str:
    """Describe how the value of ``about`` changed. None means that the value is not set."""
    if old is None or new is None:
        what, value = (NEW, text_of(new)) if old is None else (f"{REMOVED}, was", text_of(old))
        return f"{about}: {what}{',' if what == NEW else ''} {value} {unit}".rstrip()
    if not is_number(old) or not is_number(new):
        return f"{about} {' -> '.join(_text_pair(old, new))}"
    end = f" {unit}" if unit else ""
    return with_remark(f"{about} {' -> '.join(number_pair(old, new))}{end}", step(new - old, old, unit))


def is_number(value: Any) -> bool:
    """Return True for a number, but not for a boolean."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def text_of(value: Any, other: Any = None) -> str:
    """Format a value, with enough digits to distinguish it from ``other``; None becomes "nothing"."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _quoted(value, 0)
    if isinstance(value, Pose):
        twin = other if isinstance(other, Pose) else value
        return f"xyz {text_of(value.xyz, twin.xyz)} rpy {text_of(value.rpy, twin.rpy)}"
    if isinstance(value, frozenset):
        return first_of(sorted(map(str, value)), _MOST)
    if isinstance(value, (tuple, list)):
        twins = other if isinstance(other, (tuple, list)) and len(other) == len(value) else value
        return " ".join(text_of(one, twin) for one, twin in zip(value, twins, strict=True)) or "nothing"
    return number(float(value), float(other) if is_number(other) else None) if is_number(value) else str(value)


def _text_pair(old: Any, new: Any) -> tuple[str, str]:
    """Format two different values; of long texts, only the part around the first difference is shown."""
    if not isinstance(old, str) or not isinstance(new, str):
        before, after = text_of(old, new), text_of(new, old)
        if max(len(before), len(after)) <= _MAX_TEXT:
            return before, after
        old, new = before, after
    place = next((at for at, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), min(len(old), len(new)))
    first = max(0, place - _MAX_TEXT // 3) if max(len(old), len(new)) > _MAX_TEXT else 0
    return _quoted(old, first), _quoted(new, first)


def _quoted(text: str, first: int) -> str:
    shown = printable(text[first : first + _MAX_TEXT], keep="\t")
    shown = f"{'...' if first else ''}{shown}{'...' if first + _MAX_TEXT < len(text) else ''}"
    return f'"{shown}"' if not shown or " " in shown else shown


def coordinates(old: Pose, new: Pose, apart: Apart, least: Apart) -> str:
    """Describe the coordinates of a pose that changed by more than ``least`` (m, rad)."""
    places, turns = zip(AXES, old.xyz, new.xyz, strict=True), _near_angles(old.rpy, new.rpy)
    rows = (places, "m"), (zip(ANGLES, turns, new.rpy, strict=True), "rad")
    parts = []
    for (row, unit), whole, smallest in zip(rows, apart, least, strict=True):
        changed = [one for one in row if whole and abs(one[2] - one[1]) > max(smallest, _SHARE * whole)]
        steps = [f"{name} {' -> '.join(number_pair(a, b))} {unit}" for name, a, b in changed]
        parts += [f"origin {', '.join(steps)}"] if steps and unit == "m" else steps
    return ", ".join(parts)


def describe_move(
    frame: str, parents: tuple[str, str], poses: Sequence[Pose], apart: Apart, least: Apart, others: Sequence[str] = ()
) -> str:
    """Describe how the pose of a frame changed, ignoring changes up to ``least`` (m, rad).

    ``parents`` and ``poses`` are (old, new). ``apart`` is the distance (m) and the angle (rad) between the poses,
    ``others`` moved together with this frame. If the parent changed, only the coordinates are described.
    """
    with_it = f", and with it {several(others)}" if others else ""
    steps = coordinates(poses[0], poses[1], apart, least)
    if parents[0] != parents[1]:
        return f"{frame} {steps}{with_it}"
    return f"{frame} {far(*apart, verbs=True)} in {parents[1]}{with_it}: {steps}"


def _near_angles(old: Vector, new: Vector) -> Vector:
    """Return roll, pitch and yaw (rad) of the same rotation as ``old``, as close to ``new`` as possible."""
    roll, pitch, yaw = old
    half = math.pi + 2e-6  # slightly more than pi, so that rounding does not change the sign
    forms = [(roll, pitch, yaw), (roll + math.pi, math.pi - pitch, yaw + math.pi)]
    near = [[b + half - (half - a + b) % math.tau for a, b in zip(form, new, strict=True)] for form in forms]
    best = min(near, key=lambda form: sum(abs(a - b) for a, b in zip(form, new, strict=True)))
    roll, pitch, yaw = (0.0 if abs(angle) < _LEAST else angle for angle in best)
    return (roll, pitch, yaw)


def axis_change(joint: str, old: Vector, new: Vector, angle: float | None = None) -> str:
    """Describe how the axis of a joint changed; ``angle`` is the angle (rad) between the axes, by default computed."""
    if angle is None:
        angle = angle_between(old, new) if norm(old) and norm(new) else 0.0
    if angle > math.pi - _LEAST:
        return f"{joint} counts the other way round: axis {row(old)} -> {row(new)}"
    before, after = text_of(old, new), text_of(new, old)
    return with_remark(f"{joint} axis {before} -> {after}", f"turned {amount(angle, 'rad')}" if angle > NOISE else "")


def inertia_change(link: str, old: Sequence[float], new: Sequence[float], least: float = 0.0) -> str:
    """Describe how an inertia tensor (kg*m^2; xx yy zz xy xz yz) changed, ignoring changes up to ``least``."""
    entries = [(name, a, b) for name, a, b in zip(INERTIA, old, new, strict=True) if abs(b - a) > least]
    parts = [f"i{name} {' -> '.join(number_pair(a, b))}" for name, a, b in entries]
    share = max(abs(b - a) for a, b in zip(old, new, strict=True)) / max(map(abs, (*old, *new)))
    percent = f"{share * 100:.2g}" if share < 0.995 else f"{share * 100:.0f}"
    return f"{link} inertia {', '.join(parts)} kg*m^2 (by {percent} % of the largest moment)"


def existence(word: str, what: str, name: str, how: Iterable[str] = (), others: Sequence[str] = ()) -> str:
    """Describe an entry that is NEW or REMOVED (``word``); ``how`` is its attachment, ``others`` are links below."""
    sentence = with_remark(f"{word}: {what} {name}".rstrip(), ", ".join(filter(None, how)))
    return f"{sentence}, and with it {several(others)}" if others else sentence


def set_change(title: str, old: Iterable[str], new: Iterable[str]) -> str:
    """Describe which members were added to a set and removed from it."""
    before, after = frozenset(old), frozenset(new)
    sides = ((sorted(after - before), NEW), (sorted(before - after), REMOVED))
    parts = [f"{len(members)} {what} ({several(members)})" for members, what in sides if members]
    return f"{title}: {', '.join(parts)}"


def colour_change(about: str, old: Sequence[float] | None, new: Sequence[float] | None) -> str:
    """Describe how a colour (RGBA) changed. None means that no colour is set."""
    return f"{about} colour {text_of(old, new) if old else 'none'} -> {text_of(new, old) if new else 'none'}"


def size_of(grid: Sequence[Sequence[float]]) -> str:
    """Format the number of cells of a height map, such as "20 x 30"."""
    return f"{len(grid)} x {len(grid[0]) if grid else 0}"


def cells_change(link: str, old: Sequence[Sequence[float]], new: Sequence[Sequence[float]], least: float) -> str:
    """Describe how the heights (m) in the cells of a height map changed, ignoring changes up to ``least``."""
    cells = (pair for lines in zip(old, new, strict=False) for pair in zip(*lines, strict=False))
    steps = [abs(b - a) for a, b in cells if abs(b - a) > least]
    parts = [f"{size_of(old)} -> {size_of(new)} cells"] if size_of(old) != size_of(new) else []
    if steps:
        by = f"by {'up to ' if len(steps) > 1 else ''}{amount(max(steps), 'm')}"
        parts.append(f"{count_of(len(steps), 'cell')} changed, {by}")
    return f"{link} height map: {', '.join(parts)}"

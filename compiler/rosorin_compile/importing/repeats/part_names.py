"""Split the names of equal structures into the name of a use and names inside the part, and choose a part's name.

A part has short names, and a use puts its own before them: ``left`` and ``wheel`` make ``left_wheel``. Where the
differing word is elsewhere (``hip_FL_joint``), names in the part contain ``${name}``, and the use has no prefix. Names
that are numbered consecutively (``link_0``, ``link_4``) contain ``${first + 1}``.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from ..layout import Expression
from .nodes import MOUNT

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^A-Za-z\d]")
_SEPARATORS = "_-./: "
_SIDE = re.compile(r"left|right|l|r|[fmrhb]?[lr]|[lr][fmrhb]|front|rear|back|middle|mid|hind|upper|lower|\d+")
_LEFT = re.compile(r"left|l|[fmrhb]l|l[fmrhb]")
_GENERIC = ("link", "joint", "frame", "body", "base", "geom", "mesh", "fixed", "the", "robot", "jnt", "axis")
_WHOLES = {
    "finger": "finger knuckle phalanx proximal distal metacarpal mcp pip dip tip fingertip",
    "leg": "leg hip thigh calf knee foot ankle shank shin haa hfe kfe coxa femur tibia toe",
    "arm": "arm shoulder elbow forearm upperarm wrist",
    "wheel": "wheel tire tyre hub axle",
    "rotor": "rotor prop propeller",
    "head": "head neck eye",
}
_PART_OF = {word: whole for whole, words in _WHOLES.items() for word in words.split()}


class Split(NamedTuple):
    """The names and prefixes of the uses, by instance, and the names inside the part (``rests``).

    Where names are numbered consecutively, ``first`` has the first number of each instance.
    """

    uses: list[str]
    prefixes: list[str]
    rests: list[str]
    first: list[int] | None = None


def split(names: Sequence[Sequence[str]]) -> Split | None:
    """Return how the names of instances are composed, or None if the language cannot compose them.

    ``names`` has a row for each named thing, with its name in each instance.

    >>> split([["left_wheel", "right_wheel"], ["left_axle", "right_axle"]])
    Split(uses=['left', 'right'], prefixes=['left_', 'right_'], rests=['wheel', 'axle'], first=None)
    >>> split([["hip_FL", "hip_FR"], ["thigh_FL", "thigh_FR"]]).rests
    ['hip_${name}', 'thigh_${name}']
    >>> split([["link_0", "link_2"], ["link_1", "link_3"]]).rests
    ['link_${first}', 'link_${first + 1}']
    """
    ends: list[tuple[str, str]] = []  # what all instances of a name begin and end with
    rows: list[list[str]] = []  # what is between, by instance
    for row in names:
        pieces = [_WORD.findall(name) for name in row]
        differing = [place for place, some in enumerate(zip(*pieces, strict=False)) if len(set(some)) > 1]
        if len(set(map(len, pieces))) > 1 or not differing or any("$" in name for name in row):
            return None
        first, last = differing[0], differing[-1] + 1
        rows.append(["".join(some[first:last]) for some in pieces])
        ends.append(("".join(pieces[0][:first]), "".join(pieces[0][last:])))
        if len(set(rows[-1])) < len(row):
            return None
    if any(row != rows[0] for row in rows):
        return _by_count(rows, ends)
    uses, word = rows[0], _WORD.findall(ends[0][0])[-1:]
    while word and all(head.endswith(word[0]) for head, _ in ends):  # leg1, leg2: equal words belong to the use
        uses = [f"{word[0]}{use}" for use in uses]
        ends = [(head.removesuffix(word[0]), tail) for head, tail in ends]
        word = _WORD.findall(ends[0][0])[-1:]
    separators = uses[0][: len(uses[0]) - len(uses[0].lstrip(_SEPARATORS))]
    if not any(head for head, _ in ends) and not separators:
        marks = {tail[:1] for _, tail in ends}
        mark = min(marks) if len(marks) == 1 and marks <= set(_SEPARATORS) else ""
        rests = [tail.removeprefix(mark) for _, tail in ends]
        if all(rests) and MOUNT not in rests:
            return Split(uses, [use + mark for use in uses], rests)
    composed: list[str] = [Expression(f"{head}{separators}${{name}}{tail}") for head, tail in ends]
    return Split([use.removeprefix(separators) for use in uses], [""] * len(uses), composed)


def _by_count(rows: list[list[str]], ends: list[tuple[str, str]]) -> Split | None:
    """Split at numbers that are higher by the same amount in all instances."""
    if not all(number.isdigit() and str(int(number)) == number for row in rows for number in row):
        return None
    first = [min(map(int, column)) for column in zip(*rows, strict=True)]
    composed: list[str] = []
    for row, (head, tail) in zip(rows, ends, strict=True):
        step, *others = {int(number) - lowest for number, lowest in zip(row, first, strict=True)}
        if others:
            return None
        composed.append(Expression(f"{head}${{first{f' + {step}' if step else ''}}}{tail}"))
    return Split([""] * len(first), [""] * len(first), composed, first)


def _words(name: str) -> list[str]:
    """Return the words of a name in lower case, without expressions."""
    return [word.lower() for word in _WORD.findall(re.sub(r"\$\{[^}]*\}", "_", name)) if word.isalnum()]


def part_name(uses: Sequence[str], rests: Sequence[str]) -> str:
    """Return a name for a part with these uses and inner names.

    >>> part_name(["left", "right"], ["wheel_link", "wheel_joint"]), part_name(["FL"], ["hip_joint", "thigh", "calf"])
    ('wheel', 'leg')
    """
    is_large = len(rests) > 2
    for group in (uses, rests):
        common = [word for word in _specific(group[0]) if len(word) > 2 and all(word in _words(name) for name in group)]
        if common:
            return _PART_OF.get(common[-1], common[-1]) if is_large else common[-1]
    votes = Counter(_PART_OF[word] for name in rests for word in set(_words(name)) if word in _PART_OF)
    if votes and is_large:
        return votes.most_common(1)[0][0]
    specific = [word for word in _specific(rests[0]) if len(word) > 1]
    return specific[-1] if specific else "limb" if is_large else "piece"


def _specific(name: str) -> list[str]:
    return [word for word in _words(name) if not _SIDE.fullmatch(word) and word not in _GENERIC]


def is_left(name: str) -> bool:
    """Return True if a name is one of a left side."""
    return any(_LEFT.fullmatch(word) for word in _words(name))

"""Split the names of equal structures into the name of a use and names inside the part, and choose a part's name.

A part has short names, and a use puts its own before them: ``left`` and ``wheel`` make ``left_wheel``. Where the
differing word is elsewhere (``hip_FL_joint``), names in the part contain ``${name}``, and the use has no prefix. Names
that are numbered consecutively (``link_0``, ``link_4``) contain ``${first + 1}``.
Names that are numbered consecutively (``link_0``, ``link_4``) contain ``${first + 1}``.
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
# Which end of which axis a name tells, as the first and the second value of a sign.
_ENDS = {
    "side": (re.compile(r"left|l|[fmrhb]l|l[fmrhb]"), re.compile(r"right|r|[fmrhb]r|r[fmrhb]")),
    "end": (re.compile(r"front|fore|f|f[lr]|[lr]f"), re.compile(r"rear|back|hind|[rhb]|[rhb][lr]|[lr][rhb]")),
}
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
    if any("$" in name for row in names for name in row):
        return None
    return _by_prefix(names) or _by_word(names)


def _by_prefix(names: Sequence[Sequence[str]]) -> Split | None:
    """Split after the shortest prefix that leaves equal names in all instances."""
    for end in range(1, len(names[0][0])):
        rest = len(names[0][0]) - end
        prefixes = [name[: len(name) - rest] for name in names[0]]
        if len(set(prefixes)) < len(prefixes):
            continue
        if not all(
            _is_word_end(name, len(prefix)) for row in names for name, prefix in zip(row, prefixes, strict=True)
        ):
            continue
        rests = [row[0][end:] for row in names]
        composed = [[prefix + rest for prefix in prefixes] for rest in rests]
        if composed == [list(row) for row in names] and MOUNT not in rests:
            return Split([prefix.rstrip(_SEPARATORS) or prefix for prefix in prefixes], prefixes, rests)
    return None


def _is_word_end(name: str, end: int) -> bool:
    """Return True if a word ends there: after a separator or digit, before a capital, after the l of lhip."""
    before, after = name[end - 1 : end], name[end : end + 1]
    if not before or not after.isalnum():
        return False
    if before in _SEPARATORS or before.isdigit() != after.isdigit():
        return before in _SEPARATORS or before.isdigit()
    if before.islower() and after.islower():
        first, following = words(name[:end])[-1:], words(name[end:])[:1]
        return bool(first and _SIDE.fullmatch(first[0]) and following and following[0] in _PART_OF)
    return after.isupper() and (not before.isupper() or name[end + 1 : end + 2].islower())


def _by_word(names: Sequence[Sequence[str]]) -> Split | None:
    """Split at the one word that differs between instances, wherever it is; it grows over equal words before it."""
    rests: list[tuple[list[str], str]] = []
    rows: list[list[str]] = []
    for row in names:
        pieces = [_WORD.findall(name) for name in row]
        if len(set(map(len, pieces))) != 1:
            return None
        differing = [place for place, some in enumerate(zip(*pieces, strict=True)) if len(set(some)) > 1]
        if not differing:
            return None
        first, last = differing[0], differing[-1] + 1
        middles = ["".join(some[first:last]) for some in pieces]
        if len(set(middles)) < len(middles):
            return None
        rows.append(middles)
        rests.append((pieces[0][:first], "".join(pieces[0][last:])))
    uses, grown = rows[0], list[str]()
    if any(row != uses for row in rows):
        return _by_count(rows, rests)
    while all(head for head, _ in rests) and len({head[-1] for head, _ in rests}) == 1:
        grown = [rests[0][0][-1], *grown]
        rests = [(head[:-1], tail) for head, tail in rests]
    separators = ""
    while grown and grown[0] in _SEPARATORS:
        separators += grown.pop(0)
    composed: list[str] = [Expression(f"{''.join(head)}{separators}${{name}}{tail}") for head, tail in rests]
    return Split(["".join(grown) + use for use in uses], [""] * len(uses), composed)


def _by_count(rows: list[list[str]], rests: list[tuple[list[str], str]]) -> Split | None:
    """Split at numbers that are higher by the same amount in all instances."""
    if not all(number.isdigit() and str(int(number)) == number for row in rows for number in row):
        return None
    first = [min(map(int, column)) for column in zip(*rows, strict=True)]
    composed: list[str] = []
    for row, (head, tail) in zip(rows, rests, strict=True):
        steps = {int(number) - lowest for number, lowest in zip(row, first, strict=True)}
        if len(steps) > 1:
            return None
        step = steps.pop()
        composed.append(Expression(f"{''.join(head)}${{first{f' + {step}' if step else ''}}}{tail}"))
    return Split([""] * len(first), [""] * len(first), composed, first)


def words(name: str) -> list[str]:
    """Return the words of a name in lower case, without expressions."""
    return [word.lower() for word in _WORD.findall(re.sub(r"\$\{[^}]*\}", "_", name)) if word.isalnum()]


def part_name(uses: Sequence[str], rests: Sequence[str]) -> str:
    """Return a name for a part with these uses and inner names.

    >>> part_name(["left", "right"], ["wheel_link", "wheel_joint"]), part_name(["FL"], ["hip_joint", "thigh", "calf"])
    ('wheel', 'leg')
    """
    for group in (uses, rests):
        common = [word for word in words(group[0]) if all(word in words(name) for name in group)]
        telling = [word for word in common if not _SIDE.fullmatch(word) and word not in _GENERIC and len(word) > 2]
        if telling:
            return _PART_OF.get(telling[-1], telling[-1]) if len(rests) > 2 else telling[-1]
    votes = Counter(_PART_OF[word] for name in rests for word in set(words(name)) if word in _PART_OF)
    if votes and len(rests) > 2:
        return votes.most_common(1)[0][0]
    telling = [word for word in words(rests[0]) if not _SIDE.fullmatch(word) and word not in _GENERIC and len(word) > 1]
    return telling[-1] if telling else "limb" if len(rests) > 2 else "piece"


def is_left(name: str) -> bool:
    """Return True if a name is one of a left side."""
    return any(_ENDS["side"][0].fullmatch(word) for word in words(name))


def sign_name(uses: Sequence[str], signs: Sequence[int]) -> str:
    """Return "side" or "end" if the names of uses tell their signs, else ""."""
    for name, ends in _ENDS.items():
        for first, second in (ends, ends[::-1]):
            if all(
                any((first if sign == 1 else second).fullmatch(word) for word in words(use))
                for use, sign in zip(uses, signs, strict=True)
            ):
                return name
    return ""

"""Names: those of equal things, split into what stands before and the rest, as the language composes them.

A part has short names, and a use puts its own before them: ``left`` and ``wheel`` make ``left_wheel``. Where what
differs stands elsewhere (``wheel_left``, ``hip_FL_joint``), the names of the part hold ``${name}``, and the use has no
prefix. Where numbers go on from one to the next (``link_0``, ``link_4``), they hold ``${first + 1}``.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from ..layout import Expression

MOUNT = "mount"  # the link of the robot that a use sits on
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^A-Za-z\d]")
_SEPARATORS = "_-./: "
_EXPRESSION = re.compile(r"\$\{[^}]*\}")
_SIDES = re.compile(r"left|right|l|r|[fmrhb]?[lr]|[lr][fmrhb]|front|rear|back|middle|mid|hind|upper|lower|\d+")
_LEFT = re.compile(r"left|l|[fmrhb]l|l[fmrhb]")
_RIGHT = re.compile(r"right|r|[fmrhb]r|r[fmrhb]")
_FRONT = re.compile(r"front|fore|f|f[lr]|[lr]f")
_REAR = re.compile(r"rear|back|hind|[rhb]|[rhb][lr]|[lr][rhb]")
_PLAIN = ("link", "joint", "frame", "body", "base", "geom", "mesh", "site", "fixed", "the", "robot", "jnt", "axis")

# What a person calls the thing that has these.
_WHOLES = {
    "finger": "finger knuckle phalanx proximal distal middle metacarpal mcp pip dip tip fingertip",
    "leg": "leg hip thigh calf knee foot ankle shank shin haa hfe kfe coxa femur tibia toe hipx hipy uleg lleg",
    "arm": "arm shoulder elbow forearm upperarm wrist sho elb wri",
    "hand": "hand palm",
    "gripper": "gripper",
    "wheel": "wheel tire tyre hub axle",
    "rotor": "rotor prop propeller",
    "head": "head neck eye",
}
_PARTS = {word: whole for whole, words in _WHOLES.items() for word in words.split()}


class Split(NamedTuple):
    """How the names of several instances are made: by instance the name of its use and what stands before its names.

    ``rests`` are the names in the part, in the order in which they were given. ``first`` are numbers that the uses
    give, where names go on counting.
    """

    uses: list[str]
    prefixes: list[str]
    rests: list[str]
    first: list[int] | None = None

    @property
    def is_prefix(self) -> bool:
        """Whether the names of the part are plain."""
        return not any(isinstance(rest, Expression) for rest in self.rests)


def split(names: Sequence[Sequence[str]]) -> Split | None:
    """Return how the names of instances are made, None if no rule of the language makes them.

    ``names`` has a row for each thing with a name, and in it the name in each instance.

    >>> split([["left_wheel", "right_wheel"], ["left_axle", "right_axle"]])
    Split(uses=['left', 'right'], prefixes=['left_', 'right_'], rests=['wheel', 'axle'], first=None)
    >>> split([["hip_FL", "hip_FR"], ["thigh_FL", "thigh_FR"]]).rests
    ['hip_${name}', 'thigh_${name}']
    >>> split([["link_0", "link_2"], ["link_1", "link_3"]]).rests
    ['link_${first}', 'link_${first + 1}']
    """
    if any("$" in name for row in names for name in row):
        return None
    return _before(names) or _within(names)


def _before(names: Sequence[Sequence[str]]) -> Split | None:
    """Return the split at the shortest prefix after which all instances have the same names."""
    first = names[0]
    for end in _ends(first[0]):
        rest = len(first[0]) - end
        prefixes = [name[: len(name) - rest] for name in first]
        if len(set(prefixes)) < len(prefixes) or not all(map(_is_end, first, map(len, prefixes))):
            continue
        if all(_has_rest(row, prefixes) for row in names):
            rests = [row[0][end:] for row in names]
            if MOUNT not in rests:
                return Split(_called(prefixes), prefixes, rests)
    return None


def _has_rest(row: Sequence[str], prefixes: Sequence[str]) -> bool:
    """Say whether names begin with prefixes, and go on in the same way, with a word."""
    rest = row[0][len(prefixes[0]) :]
    fits = all(name == prefix + rest for name, prefix in zip(row, prefixes, strict=True))
    return fits and rest[:1].isalnum() and _is_end(row[0], len(prefixes[0]))


def _ends(name: str) -> list[int]:
    """Return where words of a name end, what separates them included."""
    return [end for end in range(1, len(name)) if _is_end(name, end)]


def _is_end(name: str, end: int) -> bool:
    """Say whether a word ends there and another begins: after a separator, at a capital, after the l of lhip."""
    before, after = name[end - 1 : end], name[end : end + 1]
    if not before or not after or after in _SEPARATORS:
        return False
    if before in _SEPARATORS or before.isdigit() != after.isdigit():
        return before in _SEPARATORS or before.isdigit()
    if after.islower() and before.islower():
        first, rest = words(name[:end])[-1:], words(name[end:])[:1]
        return bool(first and _SIDES.fullmatch(first[0]) and rest and rest[0] in _PARTS)
    return after.isupper() and (not before.isupper() or name[end + 1 : end + 2].islower())


def _called(prefixes: Sequence[str]) -> list[str]:
    """Return the names of uses that have these prefixes."""
    return [prefix.rstrip(_SEPARATORS) or prefix for prefix in prefixes]


def _within(names: Sequence[Sequence[str]]) -> Split | None:
    """Return the split where one word of each name differs, wherever it stands."""
    rows = [[_WORDS.findall(name) for name in row] for row in names]
    cuts = [_cut(row) for row in rows]
    if any(cut is None for cut in cuts):
        return None
    middles = [cut[1] for cut in cuts if cut is not None]
    if all(middle == middles[0] for middle in middles):
        return _by_word([cut for cut in cuts if cut is not None])
    return _by_count([cut for cut in cuts if cut is not None])


_Cut = tuple[list[str], list[str], list[str]]


def _cut(row: Sequence[Sequence[str]]) -> _Cut | None:
    """Return the words that all begin with, what differs then, and the words that all end with."""
    shortest = min(map(len, row))
    begin = 0
    while begin < shortest and len({words[begin] for words in row}) == 1:
        begin += 1
    end = 0
    while end < shortest - begin and len({words[len(words) - 1 - end] for words in row}) == 1:
        end += 1
    middles = ["".join(words[begin : len(words) - end]) for words in row]
    if not all(middles) or len(set(middles)) < len(middles):
        return None
    return list(row[0][:begin]), middles, list(row[0][len(row[0]) - end :])


def _by_word(cuts: list[_Cut]) -> Split:
    """Return the split by a word that stands in each name; it grows as long as all have the same before it."""
    words = list(cuts[0][1])
    heads = [list(cut[0]) for cut in cuts]
    grown: list[str] = []
    while all(heads) and len({head[-1] for head in heads}) == 1:
        grown.insert(0, heads[0][-1])
        heads = [head[:-1] for head in heads]
    while grown and grown[0] in _SEPARATORS:
        heads = [[*head, grown[0]] for head in heads]
        grown.pop(0)
    uses = ["".join(grown) + word for word in words]
    pairs = zip(heads, cuts, strict=True)
    rests: list[str] = [Expression(f"{''.join(head)}${{name}}{''.join(cut[2])}") for head, cut in pairs]
    return Split(uses, [""] * len(words), rests)


def _by_count(cuts: list[_Cut]) -> Split | None:
    """Return the split by a number that is higher by the same in all names of an instance."""
    numbers = [cut[1] for cut in cuts]
    if not all(number.isdigit() and str(int(number)) == number for row in numbers for number in row):
        return None
    rows = [list(map(int, row)) for row in numbers]
    first = [min(column) for column in zip(*rows, strict=True)]
    steps = [[number - least for number, least in zip(row, first, strict=True)] for row in rows]
    if any(len(set(row)) > 1 for row in steps):
        return None
    rests: list[str] = []
    for cut, row in zip(cuts, steps, strict=True):
        counted = "${first}" if not row[0] else f"${{first + {row[0]}}}"
        rests.append(Expression(f"{''.join(cut[0])}{counted}{''.join(cut[2])}"))
    return Split([""] * len(first), [""] * len(first), rests, first)


def words(name: str) -> list[str]:
    """Return the words of a name, in small letters, without what an expression puts in."""
    return [word.lower() for word in _WORDS.findall(_EXPRESSION.sub("_", name)) if word.isalnum()]


def whole(uses: Sequence[str], rests: Sequence[str]) -> str:
    """Return what a person would call a part whose uses and names are these.

    >>> whole(["left", "right"], ["wheel_link", "wheel_joint"]), whole(["FL", "FR"], ["hip_joint", "thigh", "calf"])
    ('wheel', 'leg')
    >>> whole(["left_arm", "right_arm"], ["link_1", "joint_1"])
    'arm'
    """
    for group in (uses, rests):
        common = [word for word in words(group[0]) if all(word in words(name) for name in group)]
        telling = [word for word in common if not _SIDES.fullmatch(word) and word not in _PLAIN and len(word) > 2]
        if telling:
            return _PARTS.get(telling[-1], telling[-1]) if len(rests) > 2 else telling[-1]
    root = [_PARTS[word] for word in words(rests[0]) if word in _PARTS]
    if root and len(rests) > 2:
        return root[-1]
    votes = Counter(_PARTS[word] for name in rests for word in set(words(name)) if word in _PARTS)
    if votes and len(rests) > 2:
        return votes.most_common(1)[0][0]
    telling = [word for word in words(rests[0]) if not _SIDES.fullmatch(word) and word not in _PLAIN]
    return telling[-1] if telling and len(telling[-1]) > 1 else "limb" if len(rests) > 2 else "piece"


SIDES = {"side": ("left", "right"), "end": ("front", "rear")}
_RULES = {"left": _LEFT, "right": _RIGHT, "front": _FRONT, "rear": _REAR}


def is_left(name: str) -> bool:
    """Say whether a name tells a left one."""
    return _is("left", name)


def is_ahead(word: str, name: str) -> bool:
    """Say whether a name tells what comes first of a word of ``SIDES``: left, front."""
    return _is(SIDES[word][0], name)


def _is(side: str, name: str) -> bool:
    return any(_RULES[side].fullmatch(word) for word in words(name))


def side_word(names: Sequence[str], signs: Sequence[int]) -> str:
    """Return what a sign says that these uses have: side, end; empty if their names do not tell."""
    for word, sides in SIDES.items():
        for one, other in (sides, sides[::-1]):
            if all(_is(one if own == 1 else other, name) for name, own in zip(names, signs, strict=True)):
                return word
    return ""


def identity(uses: Sequence[str], wanted: str) -> str:
    """Return the word that these uses have in common beside what they are: front, rear; empty without one.

    >>> identity(["front_left", "front_right"], "wheel")
    'front'
    """
    for side in ("left", "right", "front", "rear"):
        if all(_is(side, name) for name in uses):
            return side
    common = [word for word in words(uses[0]) if all(word in words(name) for name in uses)]
    return next((word for word in common if word != wanted and not word.isdigit() and len(word) > 1), "")

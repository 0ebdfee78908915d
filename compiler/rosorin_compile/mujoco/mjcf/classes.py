"""Default classes: what geoms, joints and actuators of an MJCF of ours have in common, said once.

All are in one class with the name of the robot, and begin with it: two robots that are included in one scene share one
space of names. Each element names its class itself, and no body has a ``childclass``: what is verbatim in a body, or is
attached to it, keeps MuJoCo's own defaults.

Joints that move alike share a class, and so do actuators that are alike, where that makes the file shorter. Such a
class is called after the words that the names of all its joints have: wrist of wrist_1_joint and wrist_2_joint.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from markupsafe import Markup

from rosorin_compile.formats.templating import attribute, attributes

from .bodies import (
    BESIDE_WHEELS,
    COLLISION,
    COLLISION_GROUP,
    FRAME,
    FRAME_GROUP,
    ROLLS,
    SHOWN,
    SHOWN_WHEEL,
    VISUAL,
    VISUAL_GROUP,
    WHEEL,
)

# What each joint has for itself, and what many have in common that move otherwise.
_OWN = ("name", "class", "type")
_SIDE = ("axis", "range", "ctrlrange", "forcerange")
# The kinds of actuators whose attributes all may stand in a class, and what an actuator acts on.
_KINDS = ("position", "velocity", "motor", "general")
_TARGETS = ("name", "class", "joint", "jointinparent", "tendon", "site", "refsite", "body", "slidersite", "cranksite")
_OF_ACTUATOR = (*_TARGETS, "lengthrange")  # MuJoCo takes it in no class

_WORD = re.compile(r"[^\W\d_]+")
_CLASS = re.compile(r'<default\b[^<>]*\bclass="([^"]*)"')

Texts = Mapping[str, str]


class Part(NamedTuple):
    """An element as printed; ``replicate`` are the attributes of the element around it, ``text`` is of a template."""

    tag: str
    attributes: Markup | str = ""
    replicate: Markup | str = ""
    text: str = ""


class Named(NamedTuple):
    """An element that may have a class: its tag, its name, its other attributes, the joint that names its class."""

    tag: str
    name: str
    values: Texts
    joint: str = ""


class Class(NamedTuple):
    """A default class: its name, the elements in it, and classes in it."""

    name: str
    parts: Sequence[Part] = ()
    classes: Sequence[Class] = ()


class _Shared(NamedTuple):
    """Attributes that several elements of a kind share; ``members`` are their places in the list of all.

    ``words`` are those that the names of their joints have in common.
    """

    tag: str
    values: Texts
    members: tuple[int, ...]
    words: str


class Classes:
    """The default classes of a robot; ``elements`` share them, ``kept`` are texts that have classes of their own."""

    def __init__(self, robot: str, elements: Sequence[Named], kept: Iterable[str]) -> None:
        self._taken = {name for text in kept for name in _CLASS.findall(text)} | {"main"}
        self.outer = self._free(robot)
        self._elements = elements
        self._names: dict[int, str] = {}
        self._taken |= {self.named(purpose) for purpose in (VISUAL, COLLISION, WHEEL, SHOWN, SHOWN_WHEEL, FRAME)}
        self.shared: dict[str, list[_Shared]] = {}
        for shared in self._groups():
            name = self._with_joints(shared) or self._called(shared)
            if self._saved(shared) > 0:
                if name not in self.shared:
                    self._free(name)
                self.shared.setdefault(name, []).append(shared)
                self._names |= dict.fromkeys(shared.members, name)

    def named(self, purpose: str) -> str:
        """Return the name of the class of geoms (``visual``, ``collision``, ``wheel_collision``) or of frames."""
        return f"{self.outer}_{purpose}"

    def printed(self, place: int) -> Markup:
        element, name = self._elements[place], self._names.get(place, "")
        common = next((one.values for one in self.shared.get(name, ()) if one.tag == element.tag), {})
        own = {word: text for word, text in element.values.items() if word not in common}
        return attribute("name", element.name) + attributes(**({"class": name} if name else {}), **own)

    def tree(self, used: Collection[str], rolls: bool, groups: Mapping[str, int]) -> Class:
        """Return the classes as the file has them: of geoms those that are ``used``; ``rolls``: some are of wheels.

        ``groups`` are those that visuals and collisions have if not ours, by purpose.
        """
        seen = {"group": str(groups.get(VISUAL, VISUAL_GROUP))}
        group = groups.get(COLLISION, COLLISION_GROUP if {VISUAL, SHOWN, SHOWN_WHEEL}.intersection(used) else 0)
        solid = {"group": str(group)} if group else {}
        solid |= {"density": "0", **(BESIDE_WHEELS.attributes() if rolls else {})}
        inner = {WHEEL: ROLLS.attributes(), SHOWN: seen, SHOWN_WHEEL: seen | ROLLS.attributes()}
        solids = [Class(self.named(name), [_part("geom", said)]) for name, said in inner.items() if name in used]
        made = []
        if VISUAL in used:
            seen |= {"contype": "0", "conaffinity": "0", "density": "0"}
            made.append(Class(self.named(VISUAL), [_part("geom", seen)]))
        if solids or COLLISION in used:
            made.append(Class(self.named(COLLISION), [_part("geom", solid)], solids))
        made.append(Class(self.named(FRAME), [_part("site", {"group": str(FRAME_GROUP)})]))
        made += [Class(name, [_part(one.tag, one.values) for one in shared]) for name, shared in self.shared.items()]
        return Class(self.outer, (), made)

    def _free(self, name: str) -> str:
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name

    def _groups(self) -> Iterator[_Shared]:
        """Yield what elements share that move alike; those of one axis and range alone, where their names say so.

        Hips and knees of many legs are two classes, though they may have the same damping.
        """
        for members in self._alike(range(len(self._elements)), _SIDE):
            whole, cut = self._shared(members), self._alike(members, ())
            parts = [self._shared(inner) for inner in cut] if len(cut) > 1 else [whole]
            saved = [self._saved(one) for one in parts]
            apart = len({one.words for one in parts} - {"", "joint"}) == len(parts) and min(saved) > 0
            shorter = sum(max(0, more) for more in saved) >= self._saved(whole)
            yield from parts if apart or shorter else [whole]

    def _alike(self, places: Iterable[int], without: Sequence[str]) -> list[list[int]]:
        groups: dict[object, list[int]] = {}
        for place in places:
            tag, values = self._elements[place].tag, self._elements[place].values
            others = (*(_OWN if tag == "joint" else _OF_ACTUATOR), *without)
            key = frozenset((word, text) for word, text in values.items() if word not in others)
            is_alone = tag != "joint" and tag not in _KINDS
            groups.setdefault((tag, place) if is_alone else (tag, key), []).append(place)
        return list(groups.values())

    def _shared(self, members: Sequence[int]) -> _Shared:
        """Return the attributes that all elements have, in the order of the first one."""
        elements = [self._elements[place] for place in members]
        own = _OWN if elements[0].tag == "joint" else _OF_ACTUATOR
        common = {
            word: text
            for word, text in elements[0].values.items()
            if word not in own and all(one.values.get(word) == text for one in elements)
        }
        return _Shared(elements[0].tag, common, tuple(members), _words_of([one.joint for one in elements]))

    def _with_joints(self, shared: _Shared) -> str:
        """Return the class that has all joints of these actuators, and can have them, too; empty if there is none."""
        joints = {self._elements[place].joint for place in shared.members}
        for name, (first, *more) in self.shared.items() if shared.tag != "joint" else ():
            known = {self._elements[place].joint for place in first.members}
            if first.tag == "joint" and not more and joints <= known:
                return name
        return ""

    def _called(self, shared: _Shared) -> str:
        first = self._elements[shared.members[0]].joint
        own, word = _words_of([first]), shared.words or shared.tag
        words = [word, own if "_" in own else first or shared.tag]
        words += [f"{word}_{n}" for n in range(2, len(self._taken) + 2)]
        return next(name for name in map(self.named, words) if name not in self._taken)

    def _saved(self, shared: _Shared) -> int:
        """Return by how many characters the file gets shorter by a class, or by more in one that is made already."""
        joined = self._with_joints(shared)
        name = joined or self._called(shared)
        said, named = len(attributes(**shared.values)), len(f' class="{name}"')
        around = len(f"        <{shared.tag}/>\n")
        around += 0 if joined else len(f'      <default class="{name}">\n      </default>\n')
        return len(shared.members) * (said - named) - said - around if said else 0


def _words_of(names: Sequence[str]) -> str:
    """Return the words that all names begin and end with; "joint" and numbers only if there is nothing else.

    >>> _words_of(["wrist_1_joint", "wrist_2_joint"]), _words_of(["FL_hip_joint", "FR_hip_joint"])
    ('wrist', 'hip')
    >>> _words_of(["joint1", "joint2"]), _words_of(["pan", "tilt"])
    ('joint', '')
    """
    split = list(map(_WORD.findall, names))
    shortest = min(map(len, split))
    begin = next((at for at in range(shortest) if len({tuple(words[at : at + 1]) for words in split}) > 1), shortest)
    rest = range(shortest - begin)
    end = next((at for at in rest if len({words[len(words) - 1 - at] for words in split}) > 1), len(rest))
    words = split[0][:begin] + split[0][len(split[0]) - end :]
    return "_".join([word for word in words if word != "joint"] or words[:1])


def _part(tag: str, values: Texts) -> Part:
    return Part(tag, attributes(**values))

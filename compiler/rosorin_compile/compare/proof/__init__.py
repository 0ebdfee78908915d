"""Proof: what was made of a robot is held against it by an engine, and what differs is told by feature.

``Proof.of(source, made, engine)`` is the one way to ask. What an engine compares is its own, and what it is given:

- ``model``: two models of a robot, value by value; or one section of them.
- ``elements``: what elements of XML mean that a URDF has beside links and joints.
- ``facts``: compiled artifacts, read back, and the model that they are to say.
- MuJoCo and Drake (``Proving.prove`` of their formats): what each makes of a source, and of what that becomes.

What all of them take for the same number and place, and how they draw states of joints, stands here, too.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar

if TYPE_CHECKING:
    from rosorin_compile.model import Joint, Robot

Source = TypeVar("Source")
Made = TypeVar("Made")
State: TypeAlias = dict[str, Any]  # a number by joint, or several


class Tolerance:
    """How far apart what means the same may be. What digits in print leave open comes to that (``tolerance``)."""

    NUMBER = 1e-12  # between numbers that arithmetic alone has moved: of the larger one, and of 1
    POSE = 1e-9  # m, or an entry of a rotation: a pose adds up the rounding of a chain
    SINGLE = 1e-6  # between numbers of single precision
    SIMULATED = 1e-6  # m, rad, or an entry of a rotation, that a simulation has come to

    @staticmethod
    def same(one: float, other: float, tolerance: float = NUMBER) -> bool:
        """Say whether two numbers differ by no more than a part of the larger one, or of 1."""
        return abs(one - other) <= tolerance * max(1.0, abs(one), abs(other))

    @staticmethod
    def apart(one: Any, other: Any) -> float:
        """Return the largest difference between the numbers of two nested sequences of the same form."""
        if one == other:
            return 0.0
        pairs = zip(_numbers(one), _numbers(other), strict=True)
        return max((abs(a - b) for a, b in pairs), default=0.0)


def _numbers(nested: Any) -> Iterator[float]:
    for item in nested:
        if isinstance(item, (list, tuple)):
            yield from _numbers(item)
        else:
            yield item


class Found(NamedTuple):
    """What an engine found: the differences, each with its feature, and what there is to say of them.

    ``listed`` says of a difference whether it was told before; ``said`` makes the sentence about what holds of the
    features in which some was. ``counts`` is how many objects the source has, by kind.
    """

    differences: Iterable[tuple[str, str]] = ()
    listed: Callable[[str, str], bool] = lambda feature, text: False  # noqa: ARG005
    said: Callable[[Sequence[str]], str] = lambda features: ""  # noqa: ARG005
    counts: Mapping[str, int] = {}


Engine: TypeAlias = Callable[[Source, Made], Found | str]
"""Holds what was made of a source against it; returns what it found, or why it cannot say."""


class Proof(NamedTuple):
    """How what a source becomes differs from it to the engine that reads both, in texts by feature.

    ``wrong`` is what nobody said, ``known`` what was listed as left out or changed; ``said`` is the sentence about what
    holds. ``unknown`` is why the engine did not answer; empty if it did. ``counts`` is how many objects the source has,
    by kind.
    """

    wrong: Mapping[str, Sequence[str]] = {}
    known: Mapping[str, Sequence[str]] = {}
    said: str = ""
    unknown: str = ""
    counts: Mapping[str, int] = {}

    @property
    def texts(self) -> list[str]:
        """All that differs though nobody said so, feature by feature."""
        return [text for texts in self.wrong.values() for text in texts]

    @staticmethod
    def of(source: Source, made: Made, engine: Engine[Source, Made]) -> Proof:
        """Return how an engine tells what was made of a source from it."""
        found = engine(source, made)
        if isinstance(found, str):
            return Proof(unknown=found)
        by_feature: dict[str, list[str]] = {}
        for feature, text in found.differences:
            by_feature.setdefault(feature, []).append(text)
        known: dict[str, list[str]] = {}
        wrong: dict[str, list[str]] = {}
        for feature, texts in by_feature.items():
            told = [text for text in texts if found.listed(feature, text)]
            rest = [text for text in texts if text not in told]
            known |= {feature: told} if told else {}
            wrong |= {feature: rest} if rest else {}
        return Proof(wrong, known, "" if wrong else found.said(list(known)), counts=found.counts)

    @staticmethod
    def model(tolerance: float, *, carried_by_urdf: bool) -> Engine[Robot, Robot]:
        """Return the engine that compares two robots by value: the sentences of ``diff``, then each field that differs.

        Numbers may differ by ``tolerance``, absolute or relative. With ``carried_by_urdf`` only what a URDF says is
        compared, and by what it means.
        """
        from .model import by_values

        return partial(by_values, tolerance=tolerance, carried_by_urdf=carried_by_urdf)

    @staticmethod
    def section(name: str, tolerance: float) -> Engine[Robot, Robot]:
        """Return the engine that compares one section of two robots, such as ``moveit``, value by value."""
        from .model import by_section

        return partial(by_section, section=name, tolerance=tolerance)

    @staticmethod
    def elements(robot: Robot | None = None, *, humble: bool = False) -> Engine[Iterable[str], Iterable[str]]:
        """Return the engine that compares what two lists of elements of a URDF say.

        The joints of ``robot`` that follow others are known, and whether ROS 2 ``humble`` reads it.
        """
        from .elements import Context, by_elements, context_of

        return partial(by_elements, context=Context(humble=humble) if robot is None else context_of(robot, humble))

    @staticmethod
    def states(joints: Iterable[tuple[Joint, float, float]], count: int, seed: int) -> list[State]:
        """Return states of joints, the same for a seed: each number (rad or m) between the two beside its joint.

        A joint has as many as it has ``coordinates``; those of an orientation are not normalised.
        """
        chance = random.Random(seed)  # noqa: S311 - the same states in every run
        drawn = list(joints)
        return [{joint.name: _somewhere(joint, low, high, chance) for joint, low, high in drawn} for _ in range(count)]


def _somewhere(joint: Joint, low: float, high: float, chance: random.Random) -> float | Sequence[float]:
    numbers = [chance.uniform(low, high) for _ in joint.coordinates]
    return numbers if len(numbers) > 1 else sum(numbers)

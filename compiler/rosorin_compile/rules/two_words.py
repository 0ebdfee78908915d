"""Two words: what a joint or a tendon says both in words of the language and in MuJoCo's own, and not the same."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from rosorin_compile.model import Joint
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import SIMULATED, rule
from rosorin_compile.source.tree import Path

from .case import Case, number

# What numbers lose that are read of a file which says both.
_ROUNDING = 1e-6
# Those that MuJoCo takes for polynomials, whose first number is the one that all formats know.
_POLYNOMIALS = ("stiffness", "damping")


class _Twice(NamedTuple):
    """A word of ``mjcf`` and what it says; what is said elsewhere, under which keys; the way out."""

    word: str
    mine: str
    theirs: str
    other: Path
    help: str


@rule(
    "joint-word",
    "A joint or a tendon says under `mjcf` otherwise what it says in words of the language, such as its `limit` or its "
    "`dynamics`: formats would differ in what they take.",
    "Leave one of them out.",
    SIMULATED,
)
def two_words(case: Case) -> Iterator[Diagnostic]:
    """Words of MuJoCo that go against those of the language."""
    for joint in case.robot.joints:
        if not joint.mjcf or joint.is_fixed:
            continue
        path = case.joint(joint)
        for one in (*_of_dynamics(joint), *_of_limit(joint)):
            yield _problem(case, path, f'joint "{joint.name}"', one)
        if joint.type == "continuous" and "range" in joint.mjcf:
            message = f'joint "{joint.name}" is continuous, and has a range in mjcf'
            help = "leave it out, or make the joint revolute and write its limit"
            yield case.problem("joint-word", message, (*path, "mjcf", "range"), help, key=True)
    for name, entry in (case.tree.get("tendons") or {}).items():
        for word in _POLYNOMIALS:
            mine: list[float] = (entry.get("mjcf") or {}).get(word) or []
            if word in entry and mine and not _same(mine[0], entry[word]):
                one = _Twice(word, f"a {word} of {number(mine[0])}", number(entry[word]), (word,), _POLYNOMIAL)
                yield _problem(case, ("tendons", name), f'tendon "{name}"', one)


_POLYNOMIAL = "leave one of them out, or begin the polynomial of mjcf with the other number"


def _problem(case: Case, path: Path, called: str, one: _Twice) -> Diagnostic:
    message = f"{called} has {one.mine} in mjcf, and {one.theirs} in {'.'.join(map(str, one.other))}"
    related = [case.related("the other one", (*path, *one.other))]
    return case.problem("joint-word", message, (*path, "mjcf", one.word), one.help, related=related, key=True)


def _of_dynamics(joint: Joint) -> Iterator[_Twice]:
    """Yield what is said of the damping and the spring of a joint; that of its actuator counts as damping, too."""
    dynamics, drive = joint.dynamics or Dynamics(), joint.actuator.damping if joint.actuator else 0.0
    pair = _numbers(joint, "springdamper")
    for word, value in (("stiffness", dynamics.stiffness), ("damping", joint.braking)):
        place = ("actuator", word) if word == "damping" and drive else ("dynamics", word)
        theirs, mine = number(drive if place[0] == "actuator" else value), _numbers(joint, word)
        if value and mine and not _same(mine[0], value):
            yield _Twice(word, f"a {word} of {number(mine[0])}", theirs, place, _POLYNOMIAL)
        if value and pair and min(pair) > 0:
            help = f"leave one of them out: MuJoCo makes another {word} of springdamper"
            yield _Twice("springdamper", "a springdamper", f"a {word} of {theirs}", place, help)


def _of_limit(joint: Joint) -> Iterator[_Twice]:
    limit = joint.limit
    if not joint.moves or limit is None:
        return
    ends, force = _numbers(joint, "range"), _numbers(joint, "actuatorfrcrange")
    known = (limit.lower, limit.upper) if joint.type != "continuous" else ()
    for mine, theirs, key in zip(ends, known, ("lower", "upper"), strict=False):
        if theirs is not None and not _same(mine, theirs):
            said = f"a range of {number(ends[0])} to {number(ends[1])}"
            yield _Twice("range", said, number(theirs), ("limit", key), "leave it out, and correct the limit")
            break
    if force and limit.effort is not None and not _same(max(map(abs, force)), limit.effort):
        said = f"a force of {number(force[0])} to {number(force[1])}"
        help = "leave it out, or write the larger of its ends as the effort"
        yield _Twice("actuatorfrcrange", said, number(limit.effort), ("limit", "effort"), help)


def _numbers(joint: Joint, word: str) -> tuple[float, ...]:
    said = joint.mjcf.get(word)
    return tuple(map(float, said)) if isinstance(said, tuple) else ()


def _same(one: float, other: float) -> bool:
    return math.isclose(one, other, rel_tol=_ROUNDING, abs_tol=_ROUNDING**2)

"""Single values, wherever they stand: numbers in the wrong unit, characters that XML cannot carry."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from rosorin_compile.language.schema import subject, unit_at
from rosorin_compile.model import Joint, Link, Vector
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Span
from rosorin_compile.source.rule_registry import NUMBERS, Check, rule
from rosorin_compile.source.tree import Path, at, written
from rosorin_compile.source.units import has_unit

from . import shared_values
from .case import Case, number
from .remarkable import FULL_TURN, NOT_XML

# Nothing on a robot is this far from anything else, but a drawing in millimetres has such numbers.
FAR = 20.0  # m
# What is turned farther is turned the other way, unless it is an angle of a circle (3/2 pi), which is no round number.
HALF_TURN = math.pi + 1e-2  # rad
_STRAIGHT = (0.0, 0.0, 0.0)
# Actuators whose control is a position, where their gear is 1; that of all others is a torque, a speed or anything.
_OF_POSITIONS = ("position", "intvelocity", "pid")


@rule(
    "angle-looks-like-degrees",
    "A bare angle is more than a full turn. A warning: one of `rpy` is a round number and more than half a turn.",
    "Write `180 deg`, or `180 rad` if that is meant.",
    NUMBERS,
    accept="link or joint",
    imported="always",
)
@rule(
    "length-looks-like-millimetres",
    "A warning: a bare length is more than 20 m.",
    "Write `46 mm`, or `46 m` if that is meant.",
    NUMBERS,
    accept="link or joint",
    imported="always",
)
def magnitudes(case: Case) -> Iterator[Diagnostic]:
    """Bare numbers that are no angle in radians and no length in metres, though they stand for one.

    A quantity with its unit is never suspect: that is the way to say 720 deg or 25 m and mean it. One message for the
    numbers of one list or one entry.
    """
    groups: dict[tuple[Path, str], list[tuple[Path, Any]]] = {}
    for path, value in case.remarkable.numbers:
        unit = _suspect(case, path, value)
        if unit:
            groups.setdefault((path[:-1], unit), []).append((path, value))
    for (_, unit), uses in groups.items():
        path, value = uses[0]
        related = [case.related(f"and {number(other)} {unit} here", more) for more, other in uses[1:]]
        text = f"{subject(list(path))} is {number(value)} {unit}"
        if unit == "rad":
            help = f'write "{number(value)} deg" if degrees are meant, "{number(value)} rad" if not'
            message = f"{text}, more than a full turn: this looks like degrees"
            found = case.problem("angle-looks-like-degrees", message, path, help, related=related, severity=ERROR)
        else:
            help = f'write "{number(value)} mm" if millimetres are meant, "{number(value)} m" if not'
            message = f"{text}: this looks like millimetres"
            found = case.problem(
                "length-looks-like-millimetres", message, path, help, related=related, severity=WARNING
            )
        yield _of_expression(found)


def _of_expression(problem: Diagnostic) -> Diagnostic:
    """Return a problem with its way out; where an expression gives the number, no unit can be written behind it."""
    span = problem.span
    if span is None:
        return problem
    if "${" not in span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length]:
        return problem
    return replace(problem, help="it is computed here: look at what the expression is made of")


@Check
def turns(case: Case) -> Iterator[Diagnostic]:
    """Look at the bare angles of ``rpy`` that are less than a full turn, and that nobody writes in radians."""
    for joint in case.robot.joints:
        if joint.origin.rpy != _STRAIGHT:
            yield from _turn(case, joint.origin.rpy, case.joint(joint))
    yield from shared_values.links(case.robot).problems(partial(_turns_of, case))


def _turns_of(case: Case, link: Link) -> Iterator[Diagnostic]:
    if link.inertial is not None:
        yield from _turn(case, link.inertial.pose.rpy, case.link(link.name, "inertial"))
    for purpose, shapes in (("visual", link.visual), ("collision", link.collision)):
        for index, shape in enumerate(shapes):
            yield from _turn(case, shape.pose.rpy, case.link(link.name, purpose, index))


def _turn(case: Case, rpy: Vector, path: Path) -> Iterator[Diagnostic]:
    for index, angle in enumerate(rpy):
        if not HALF_TURN < abs(angle) <= FULL_TURN or angle * 2 % 1 or has_unit(at(case.tree, (*path, "rpy", index))):
            continue
        place = (*path, "rpy", index)
        message = f"{subject(list(place))} is {number(angle)} rad, more than half a turn: this looks like degrees"
        help = f'write "{number(angle)} deg" if degrees are meant, "{number(angle)} rad" if not'
        yield _of_expression(case.problem("angle-looks-like-degrees", message, place, help, severity=WARNING))


def _suspect(case: Case, path: Path, value: float) -> str:
    """Return the unit, rad or m, that a number at a path is too large for; empty if it is not suspect."""
    unit = unit_at(list(path))
    if isinstance(unit, list):
        name = path[1] if path[0] == "joints" else path[-1]
        joint = case.robot.joint.get(str(name))
        # A wheel may be told to stand at any angle.
        if joint is None or joint.type not in ("revolute", "prismatic"):
            return ""
        if path[2] == "actuator" and not _asks_for_positions(joint):
            return ""
        unit = unit[1 if joint.type == "prismatic" else 0]
    if unit == "rad":
        return "rad"
    # Other nodes place the robot in the world, and the world is large.
    return "m" if unit == "m" and path[0] != "edges" and abs(value) > FAR else ""


def _asks_for_positions(joint: Joint) -> bool:
    """Say whether the control of a joint's actuator is where the joint is to stand, in its own unit."""
    actuator = joint.actuator
    return actuator is not None and actuator.type in _OF_POSITIONS and actuator.gear in ((), (1.0,))


@rule("control-character", "A text has a character that no XML file can carry.", "Remove it.", NUMBERS)
def characters(case: Case) -> Iterator[Diagnostic]:
    """Text with control characters and the like, which no XML file can carry."""
    seen: set[Span] = set()
    for path, text in case.remarkable.texts:
        # A source at the top of a file is that of all its entries: one place, one message.
        place = written(case.tree, path)[0].span
        if place not in seen:
            yield _character(case, path, _first(text))
        seen.add(place)
    for path, key in case.remarkable.keys:
        yield _character(case, path, _first(key), key=True)


def _first(text: str) -> str:
    match = NOT_XML.search(text)
    return match[0] if match else ""


def _character(case: Case, path: Path, character: str, key: bool = False) -> Diagnostic:
    where = "a name in " + subject(list(path[:-1])) if key else subject(list(path))
    message = f"{where} contains the character U+{ord(character):04X}, which no XML file can carry"
    return case.problem("control-character", message, path, "remove it", key=key)

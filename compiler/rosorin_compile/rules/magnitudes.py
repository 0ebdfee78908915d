"""Single values: numbers in the wrong unit, and characters that XML cannot carry."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple, cast

from rosorin_compile.language.expression.syntax import NUMERIC
from rosorin_compile.language.schema import subject, unit_at
from rosorin_compile.model import Joint, Link, Vector
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Span
from rosorin_compile.source.rule_registry import JOINTS, NUMBERS, Check, rule
from rosorin_compile.source.tree import Map, Path, Seq, at, written
from rosorin_compile.source.units import ANGLE, Quantity, has_unit

from .case import Case, links_by_value, number

# A little more than one turn, so that 6.2832 passes for 2*pi.
FULL_TURN = 2 * math.pi + 1e-3  # rad
# A larger rotation would be written the other way round, unless it is a fraction of a circle, not a round number.
HALF_TURN = math.pi + 1e-2  # rad
# No part of a robot is this far from another, but a drawing in millimetres has such numbers.
FAR = 20.0  # m
# rad/s. A servo turns at 10, a fast leg at 40. From here on a multiple of STEP comes from a data sheet in degrees;
# 100, 1000 and 50000 are no multiples: they mean "no limit".
FAST, STEP, FASTEST = 60.0, 15.0, 1080.0
# https://www.w3.org/TR/xml/#charsets
NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
# Actuators whose control is a position, where their gear is 1.
_OF_POSITIONS = ("position", "intvelocity", "pid")
_DEGREES = re.compile(r"([-+]?\d+\.(\d+))\s*deg\Z")


class Remarkable(NamedTuple):
    """Values that need a closer look, with their paths, parents before children, in the order of the tree.

    ``numbers``: bare numbers beyond a full turn, except efforts and velocities in limits of joints; ``degrees``:
    quantities in degrees with decimals; ``texts`` and ``keys``: those with characters that XML cannot carry;
    ``stand_ins``: mappings whose source marks them as stand-ins.
    """

    numbers: list[tuple[Path, float]]
    degrees: list[tuple[Path, Quantity]]
    texts: list[tuple[Path, str]]
    keys: list[tuple[Path, str]]
    stand_ins: list[tuple[Path, Map]]

    def count_all(self) -> int:
        """Return the number of all values."""
        lists = (self.numbers, self.degrees, self.texts, self.keys, self.stand_ins)
        return sum(len(values) for values in cast("tuple[list[object], ...]", lists))


def collect(tree: Map) -> Remarkable:
    """Return the remarkable values of a tree; a shared piece without any is visited once."""
    found = Remarkable([], [], [], [], [])
    plain: set[int] = set()
    plain_keys: set[str] = set()
    path: list[str | int] = []

    def visit(node: Map | Seq) -> None:
        before = found.count_all()
        if isinstance(node, Map):
            source = node.get("source")
            if isinstance(source, Map) and source.get("status") == "stand_in":
                found.stand_ins.append((tuple(path), node))
            for name in [name for name in node if name not in plain_keys]:
                if NOT_XML.search(name):
                    found.keys.append(((*path, name), name))
                else:
                    plain_keys.add(name)
        elif set(map(type, node)) == {float} and -FULL_TURN <= min(node) <= max(node) <= FULL_TURN:
            return
        for key, item in node.items() if isinstance(node, Map) else enumerate(node):
            if isinstance(item, (Map, Seq)):
                if id(item) not in plain:
                    path.append(key)
                    visit(item)
                    path.pop()
            elif type(item) in NUMERIC:
                is_strength = key in ("effort", "velocity") and path[:1] == ["joints"] and path[2:] == ["limit"]
                if isinstance(item, Quantity) and item.dimension == ANGLE and "." in item.text:
                    found.degrees.append(((*path, key), item))
                elif not (-FULL_TURN <= item <= FULL_TURN or is_strength or has_unit(item)):
                    found.numbers.append(((*path, key), item))
            elif isinstance(item, str) and not (item.isascii() and item.isprintable()) and NOT_XML.search(item):
                found.texts.append(((*path, key), item))
        if found.count_all() == before:
            plain.add(id(node))

    visit(tree)
    return found


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
    """Bare numbers that are too large for radians or metres: one message for the numbers of one list or entry."""
    groups: dict[tuple[Path, str], list[tuple[Path, float]]] = {}
    for path, value in case.remarkable.numbers:
        unit = _suspect(case, path, value)
        if unit:
            groups.setdefault((path[:-1], unit), []).append((path, value))
    for (_, unit), uses in groups.items():
        path, value = uses[0]
        related = [case.related(f"and {number(other)} {unit} here", more) for more, other in uses[1:]]
        message = f"{subject(list(path))} is {number(value)} {unit}"
        if unit == "rad":
            message, meant = f"{message}, more than a full turn: this looks like degrees", "degrees"
            rule, severity = "angle-looks-like-degrees", ERROR
        else:
            message, meant = f"{message}: this looks like millimetres", "millimetres"
            rule, severity = "length-looks-like-millimetres", WARNING
        help = _with_unit(value, {"degrees": "deg", "millimetres": "mm"}[meant], unit, meant)
        yield _computed(case.problem(rule, message, path, help, related=related, severity=severity))


def _with_unit(value: float, unit: str, bare: str, meant: str) -> str:
    return f'write "{number(value)} {unit}" if {meant} are meant, "{number(value)} {bare}" if not'


def _computed(problem: Diagnostic) -> Diagnostic:
    """Replace the help where an expression gives the number: no unit can be written behind that."""
    span = problem.span
    if span and "${" in span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length]:
        return replace(problem, help="the value is computed here: check the expression")
    return problem


def _suspect(case: Case, path: Path, value: float) -> str:
    """Return the unit, rad or m, that a bare number at a path is too large for, or an empty string."""
    unit = unit_at(list(path))
    if isinstance(unit, list):
        joint = case.robot.joint.get(str(path[1] if path[0] == "joints" else path[-1]))
        if joint is None or joint.type not in ("revolute", "prismatic"):  # a wheel may be at any angle
            return ""
        actuator = joint.actuator
        if path[2] == "actuator" and not (
            actuator and actuator.type in _OF_POSITIONS and actuator.gear in ((), (1.0,))
        ):
            return ""  # a torque, a speed or the like
        unit = unit[1 if joint.type == "prismatic" else 0]
    if unit == "rad":
        return "rad"
    # Edges place the robot in the world, which is large.
    return "m" if unit == "m" and path[0] != "edges" and abs(value) > FAR else ""


@Check
def turns(case: Case) -> Iterator[Diagnostic]:
    """Bare angles of ``rpy`` within a full turn that are round numbers: degrees (angle-looks-like-degrees)."""
    for joint in case.robot.joints:
        if any(joint.origin.rpy):
            yield from _turn(case, joint.origin.rpy, case.joint(joint))
    yield from links_by_value(case.robot).problems(partial(_turns_of, case))


def _turns_of(case: Case, link: Link) -> Iterator[Diagnostic]:
    if link.inertial is not None:
        yield from _turn(case, link.inertial.pose.rpy, case.link(link.name, "inertial"))
    for purpose, shapes in (("visual", link.visual), ("collision", link.collision)):
        for index, shape in enumerate(shapes):
            yield from _turn(case, shape.pose.rpy, case.link(link.name, purpose, index))


def _turn(case: Case, rpy: Vector, path: Path) -> Iterator[Diagnostic]:
    for index, angle in enumerate(rpy):
        place = (*path, "rpy", index)
        if HALF_TURN < abs(angle) <= FULL_TURN and not angle * 2 % 1 and not has_unit(at(case.tree, place)):
            message = f"{subject(list(place))} is {number(angle)} rad, more than half a turn: this looks like degrees"
            help = _with_unit(angle, "deg", "rad", "degrees")
            yield _computed(case.problem("angle-looks-like-degrees", message, place, help, severity=WARNING))


@rule(
    "angle-looks-like-radians",
    "A warning: an angle in degrees is a fraction of pi, such as `1.5708 deg`.",
    "Write `90 deg`, or `1.5708 rad`.",
    NUMBERS,
)
def radians_in_degrees(case: Case) -> Iterator[Diagnostic]:
    """Values in radians that got the unit deg; one message for the angles of one list or entry."""
    reported: set[Path] = set()
    for path, value in case.remarkable.degrees:
        match = _DEGREES.match(value.text)
        if match is None or path[:-1] in reported:
            continue
        angle, digits = abs(float(match[1])), len(match[2])
        # Two digits could be a measured angle, except those that everybody knows: 1.57, 3.14, 6.28.
        step = math.pi / 2 if digits == 2 else math.pi / 4
        count = round(angle / step)
        if digits < 2 or not 1 <= count <= 8 or abs(angle - count * step) > 10.0**-digits:
            continue
        reported.add(path[:-1])
        sign = "-" if value < 0 else ""
        message = f"{subject(list(path))} is {match[1]} deg: this looks like radians"
        help = f'write "{sign}{math.degrees(count * step):g} deg", or "{match[1]} rad"'
        yield case.problem("angle-looks-like-radians", message, path, help, severity=WARNING)


@rule(
    "velocity-looks-like-degrees",
    "A warning: the velocity limit of a revolute joint is many turns a second, and a round number of degrees.",
    "Write `300 deg/s`, or `300 rad/s` if that is meant.",
    JOINTS,
    accept="joint",
    imported="always",
)
def speeds(case: Case) -> Iterator[Diagnostic]:
    """Bare velocity limits that are those of a data sheet in degrees. A continuous joint may well be fast."""
    for joint in case.robot.joints:
        velocity = joint.limit.known("velocity") if joint.limit is not None else None
        if joint.type == "revolute" and velocity and FAST <= velocity <= FASTEST and not velocity % STEP:
            yield from _speed(case, joint, velocity)


def _speed(case: Case, joint: Joint, velocity: float) -> Iterator[Diagnostic]:
    place = case.joint(joint, "limit", "velocity")
    if not has_unit(at(case.tree, place)):
        message = (
            f'the velocity limit of joint "{joint.name}" is {number(velocity)} rad/s{case.stands_in(place)},'
            f" {number(round(velocity / (2 * math.pi), 1))} turns a second: this looks like degrees"
        )
        help = _with_unit(velocity, "deg/s", "rad/s", "degrees")
        yield case.problem("velocity-looks-like-degrees", message, place, help, severity=WARNING)


@rule("control-character", "A text has a character that no XML file can carry.", "Remove it.", NUMBERS)
def characters(case: Case) -> Iterator[Diagnostic]:
    """Texts and names with control characters and the like."""
    reported: set[Span] = set()
    entries: list[tuple[Path, Any, bool]] = [(path, text, False) for path, text in case.remarkable.texts]
    entries += [(path, name, True) for path, name in case.remarkable.keys]
    for path, text, key in entries:
        # A source at the top of a file belongs to all its entries: one place, one message.
        span = written(case.tree, path)[0].span
        match = NOT_XML.search(text)
        if match and (key or span not in reported):
            where = "a name in " + subject(list(path[:-1])) if key else subject(list(path))
            message = f"{where} contains the character U+{ord(match[0]):04X}, which no XML file can carry"
            yield case.problem("control-character", message, path, "remove it", key=key)
        if not key:
            reported.add(span)

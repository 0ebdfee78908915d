"""Rules about single values: numbers in the wrong unit, and characters that XML does not allow."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from rosorin_compile.language.expression.syntax import NUMERIC
from rosorin_compile.language.schema import subject, unit_at
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span
from rosorin_compile.source.rule_registry import JOINTS, NUMBERS, OUTPUTS, Check, rule
from rosorin_compile.source.tree import Map, Path, Seq, value_at, written_place
from rosorin_compile.source.units import ANGLE, Quantity, has_unit
from rosorin_compile.source.wording import first_of

from .case import Case, number

# A little more than one turn, so that 6.2832 counts as 2*pi.
FULL_TURN = 2 * math.pi + 1e-3  # rad
# Larger angles in radians are unusual, because the rotation in the opposite direction is shorter.
HALF_TURN = math.pi + 1e-2  # rad
# No distance within a robot is larger in metres, but many are in millimetres.
FAR = 20.0  # m
# rad/s. Servos turn at 10, fast legs at 40. Multiples of STEP from FAST to FASTEST are probably in degrees per second;
# 100, 1000 and 50000 are not multiples of STEP: they mean "no limit".
FAST, STEP, FASTEST = 60.0, 15.0, 1080.0
# https://www.w3.org/TR/xml/#charsets
NOT_XML = "[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]"
# Actuator types whose command is a joint position, if the gear is 1.
_OF_POSITIONS = ("position", "intvelocity", "pid")
_DEGREES = r"([-+]?\d+\.(\d+))\s*deg\Z"
STAND_INS_SHOWN = 8
_LIMITS = (("joints", "limit", "effort"), ("joints", "limit", "velocity"))  # paths without the name of the joint


# Suspicious values as (path, value) by reason (see ``collect``), in the order of the tree.
Remarkable = Mapping[str, list[tuple[Path, Any]]]


def collect(tree: Map) -> Remarkable:
    """Return the suspicious values of a YAML tree by reason.

    The reasons are "numbers" (no unit and larger than a full turn in radians, except efforts and velocities in joint
    limits), "degrees" (angles in degrees with decimals), "characters" (strings and keys with characters that XML does
    not allow), and "stand_ins" (mappings whose ``source`` marks them as stand-ins).
    """
    found: list[tuple[str, Path, Any]] = []
    plain: set[int] = set()

    def visit(node: Map | Seq, path: Path) -> bool:
        before = len(found)
        source = node.get("source") if isinstance(node, Map) else None
        if isinstance(node, Map) and isinstance(source, Map) and source.get("status") == "stand_in":
            found.append(("stand_ins", path, node))
        for key, item in node.items() if isinstance(node, Map) else enumerate(node):
            kind = type(item)
            if isinstance(key, str) and not key.isprintable() and re.search(NOT_XML, key):
                found.append(("characters", (*path, key), key))
            if kind in NUMERIC:
                if kind is Quantity and item.dimension == ANGLE and "." in item.text:
                    found.append(("degrees", (*path, key), item))
                elif not (-FULL_TURN <= item <= FULL_TURN or has_unit(item) or (*path[:1], *path[2:], key) in _LIMITS):
                    found.append(("numbers", (*path, key), item))
            elif isinstance(item, str):
                if not item.isprintable() and re.search(NOT_XML, item):
                    found.append(("characters", (*path, key), item))
            elif isinstance(item, (Map, Seq)) and id(item) not in plain and visit(item, (*path, key)):
                plain.add(id(item))
        return before == len(found)

    visit(tree, ())
    reasons = ("numbers", "degrees", "characters", "stand_ins")
    return {reason: [(path, value) for of, path, value in found if of == reason] for reason in reasons}


_BOTH = "link or joint"


@rule("angle-looks-like-degrees", "A bare angle is over a full turn.", "Write `180 deg`.", NUMBERS, _BOTH, "always")
@rule("length-looks-like-millimetres", "A warning: a length is over 20 m.", "Add a unit.", NUMBERS, _BOTH, "always")
def magnitudes(case: Case) -> Iterator[Diagnostic]:
    """Report numbers without a unit that are too large for radians or metres, once per list or mapping."""
    groups: dict[tuple[Path, str], list[tuple[Path, float]]] = {}
    for path, value in case.remarkable["numbers"]:
        unit = _suspect(case, path, value)
        if unit:
            groups.setdefault((path[:-1], unit), []).append((path, value))
    for (_, unit), ((path, value), *others) in groups.items():
        related = [case.related_place(f"and {number(other)} {unit} here", more) for more, other in others]
        what = f"{subject(list(path))} is {number(value)} {unit}"
        id, meant = ("angle-looks-like-degrees", "deg") if unit == "rad" else ("length-looks-like-millimetres", "mm")
        yield _looks_like(case, id, what, path, value, f"{meant} {unit}", related=related)


def _looks_like(case: Case, id: str, what: str, path: Path, value: float, units: str, **more: Any) -> Diagnostic:
    """Return a diagnostic for a number in a wrong unit; ``units`` is the probable and the actual unit ("mm m")."""
    probable, unit = units.split()
    meant = "millimetres" if probable == "mm" else "degrees"
    help = f'write "{number(value)} {probable}" if {meant} are meant, "{number(value)} {unit}" if not'
    problem = case.problem(id, f"{what}, which looks like {meant}", path, help, **more)
    span = problem.span
    if span and "${" in span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length]:
        return replace(problem, help="the value is calculated here: check the expression")  # expressions have no unit
    return problem


def _suspect(case: Case, path: Path, value: float) -> str:
    unit = unit_at(list(path))
    if isinstance(unit, list):
        joint = case.robot.joint.get(str(path[1] if path[0] == "joints" else path[-1]))
        if joint is None or joint.type not in ("revolute", "prismatic"):  # continuous joints may have any angle
            return ""
        drive = joint.actuator
        if path[2] == "actuator" and not (drive and drive.type in _OF_POSITIONS and drive.gear in ((), (1.0,))):
            return ""  # the command is neither a length nor an angle
        unit = unit[1 if joint.type == "prismatic" else 0]
    # A transform in ``edges`` may be the pose of the robot in a large world.
    is_far = unit == "m" and path[0] != "edges" and abs(value) > FAR
    return str(unit) if unit == "rad" or is_far else ""


@Check
def turns(case: Case) -> Iterator[Diagnostic]:
    """Warn about angles in ``rpy`` that look like degrees: no unit, a multiple of 0.5, over half a turn in radians."""
    poses = [(joint.origin, case.joint(joint)) for joint in case.robot.joints]
    poses += [(one.inertial.pose, case.link(one.name, "inertial")) for one in case.robot.links if one.inertial]
    poses += [(shape.pose, path) for _, path, shape in case.shapes()]
    for pose, path in poses:
        for index, angle in enumerate(pose.rpy):
            place = (*path, "rpy", index)
            if HALF_TURN < abs(angle) <= FULL_TURN and not angle * 2 % 1 and not has_unit(value_at(case.tree, place)):
                what = f"{subject(list(place))} is {number(angle)} rad, more than half a turn"
                yield _looks_like(case, "angle-looks-like-degrees", what, place, angle, "deg rad", severity=WARNING)


@rule("angle-looks-like-radians", help="Write `90 deg`, or `1.5708 rad`.", topic=NUMBERS)
def radians_in_degrees(case: Case) -> Iterator[Diagnostic]:
    """A warning: an angle in degrees is a fraction of pi, such as `1.5708 deg`."""
    reported: set[Path] = set()
    for path, value in case.remarkable["degrees"]:
        match = re.match(_DEGREES, value.text)
        if match is None or path[:-1] in reported:
            continue
        angle, digits = abs(float(match[1])), len(match[2])
        # An angle with two decimals may be a measurement, unless it is 1.57, 3.14 or 6.28.
        step = math.pi / 2 if digits == 2 else math.pi / 4
        count = round(angle / step)
        if digits > 1 and 1 <= count <= 8 and abs(angle - count * step) <= 10.0**-digits:
            reported.add(path[:-1])
            message = f"{subject(list(path))} is {match[1]} deg, which looks like radians"
            help = f'write "{"-" if value < 0 else ""}{math.degrees(count * step):g} deg", or "{match[1]} rad"'
            yield case.problem("angle-looks-like-radians", message, path, help)


@rule("velocity-looks-like-degrees", help="Write `300 deg/s`.", topic=JOINTS, accept="joint", imported="always")
def speeds(case: Case) -> Iterator[Diagnostic]:
    """A warning: the velocity limit of a revolute joint looks like deg/s (no unit, very high, a multiple of 15)."""
    for joint in case.robot.joints:
        velocity = joint.limit.known_value("velocity") if joint.limit is not None else None
        path = case.joint(joint, "limit", "velocity")
        is_fast = joint.type == "revolute" and velocity and FAST <= velocity <= FASTEST and not velocity % STEP
        if velocity and is_fast and not has_unit(value_at(case.tree, path)):
            message = f'the velocity limit of joint "{joint.name}" is {number(velocity)} rad/s{case.stand_in(path)},'
            message += f" {number(round(velocity / (2 * math.pi), 1))} turns a second"
            yield _looks_like(case, "velocity-looks-like-degrees", message, path, velocity, "deg/s rad/s")


@rule("control-character", help="Remove the character.", topic=NUMBERS)
def characters(case: Case) -> Iterator[Diagnostic]:
    """A string contains a character that XML files cannot contain."""
    reported: set[Span] = set()
    for path, text in case.remarkable["characters"]:
        # All entries inherit the ``source`` at the top of a file, so report the same position only once.
        key, span = path[-1] == text, written_place(case.tree, path)[0].span
        if (match := re.search(NOT_XML, text)) and (key or span not in reported):
            where = "a name in " + subject(list(path[:-1])) if key else subject(list(path))
            message = f"{where} contains the character U+{ord(match[0]):04X}, which XML files cannot contain"
            yield case.problem("control-character", message, path, key=key)
        reported.add(span)


@rule("stand-in", help="Measure it, and change its `source`.", topic=OUTPUTS)
def stand_ins(case: Case) -> Iterator[Diagnostic]:
    """A note: a value is a stand-in that has not been measured; entries with the same `note` are reported together."""
    by_note: dict[str, list[Path]] = {}
    for path, entry in case.remarkable["stand_ins"]:
        by_note.setdefault(entry["source"].get("note", ""), []).append(path)
    for note, paths in by_note.items():
        names = first_of([subject(list(path)) for path in paths], STAND_INS_SHOWN)
        values = "has a stand-in value" if len(paths) == 1 else "have stand-in values"
        message = f"{names} {values}: {note}" if note else f"{names} {values} without a note"
        place = (*paths[0], "source", "note" if note else "status")
        yield replace(case.problem("stand-in", message, place), related=(), help="")

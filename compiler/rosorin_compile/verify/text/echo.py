"""Text of tf2_echo: an answer in up to four forms, each as exact as it is printed."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from ...model import Transform
from ...model.geometry import Rows, Vector, rotation_of_rpy, transform_of_quaternion
from ..expected import EXACT, SIX_ANGLE
from ..recording.recording import Reading

_NUMBER = r"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|nan|inf)"
_LINE = re.compile(
    r"^\s*(?:- )?(Translation:|Rotation: in Quaternion|(?:Rotation: )?in RPY \((?:rad|deg)\w*\))"
    r"\s*(?:\(xyzw\)\s*)?\[([^\]]*)\]?"
)
HEAD = re.compile(r"^\s*(?:At time [\d.]+\s*$|- Translation: \[|- Rotation: in |\s+in RPY \(|- Matrix:)")
_TIME = re.compile(r"^\s*At time ")
_MATRIX = re.compile(r"^\s*- Matrix:")
_NUMBERS = re.compile(_NUMBER)


@dataclass
class Block:
    """One answer: the line where it begins (from 1), and its numbers as they were printed, by form."""

    line: int
    forms: dict[str, list[str]] = field(default_factory=dict)

    def readings(self) -> tuple[Reading, ...]:
        """Return the forms of the answer that are whole."""
        xyz, metres = None, math.inf
        if len(self.forms.get("xyz", ())) == 3:
            xyz, metres = _vector(self.forms["xyz"]), _half(self.forms["xyz"]) + EXACT
        made = []
        for form in ("matrix", "quaternion", "degree", "radian"):
            reading = self._turn(form, xyz, metres)
            if reading is not None:
                made.append(reading)
        if not made and xyz is not None:
            made.append(Reading(xyz, None, metres, math.inf))
        return tuple(made)

    def _turn(self, form: str, xyz: Vector | None, metres: float) -> Reading | None:
        """Return an answer with the rotation of one form.

        Half a digit of each of three angles, of four parts of a quaternion (each counts twice) or of a matrix adds up.
        Whatever solution was printed as RPY, its rotation is the same.
        """
        texts = self.forms.get(form, [])
        half = _half(texts)
        if form == "matrix" and len(texts) == 16:
            values = [float(text) for text in texts]
            rows: Rows = (_three(values[0:3]), _three(values[4:7]), _three(values[8:11]))
            if not all(math.isfinite(value) for value in values):
                return None
            at = _three([values[3], values[7], values[11]])
            return Reading(at, _orthonormal(rows), half + EXACT, 6 * half + SIX_ANGLE)
        if form == "quaternion" and len(texts) == 4:
            x, y, z, w = (float(text) for text in texts)
            try:
                turned = transform_of_quaternion((0.0, 0.0, 0.0), (w, x, y, z))
            except ValueError:
                return None
            return Reading(xyz, turned.rows, metres, 4.2 * half + SIX_ANGLE)
        if form in ("degree", "radian") and len(texts) == 3:
            factor = math.radians(1) if form == "degree" else 1.0
            roll, pitch, yaw = (float(text) * factor for text in texts)
            if not all(map(math.isfinite, (roll, pitch, yaw))):
                return None
            return Reading(xyz, rotation_of_rpy((roll, pitch, yaw)), metres, 3 * half * factor + SIX_ANGLE)
        return None


def block_at(lines: Sequence[str], at: int) -> tuple[Block, int]:
    """Return the answer that begins at a line, and the line behind it."""
    block = Block(at + 1)
    begin = at
    while at < len(lines):
        line = lines[at]
        match = _LINE.match(line)
        if _TIME.match(line) and at > begin:
            break
        if match:
            form = _form(match[1])
            if form in block.forms:
                break
            block.forms[form] = _NUMBERS.findall(match[2])
        elif _MATRIX.match(line):
            if "matrix" in block.forms:
                break
            block.forms["matrix"] = [text for row in lines[at + 1 : at + 5] for text in _NUMBERS.findall(row)]
            return block, min(at + 5, len(lines))
        elif not _TIME.match(line):
            break
        at += 1
    return block, max(at, begin + 1)


def _form(words: str) -> str:
    if words.startswith("Translation"):
        return "xyz"
    if "Quaternion" in words:
        return "quaternion"
    return "degree" if "deg" in words else "radian"


def _half(texts: Sequence[str]) -> float:
    """Return half of the last digit that is printed of some numbers."""
    digits = [len(text.partition(".")[2]) for text in texts if "e" not in text.lower() and "n" not in text.lower()]
    return 0.5 * 10.0 ** -max(digits, default=3)


def _vector(texts: Sequence[str]) -> Vector | None:
    values = [float(text) for text in texts]
    return _three(values) if all(map(math.isfinite, values)) else None


def _three(values: Sequence[float]) -> Vector:
    x, y, z = values
    return (x, y, z)


def _orthonormal(rows: Rows) -> Rows:
    """Return the rotation nearest to a printed matrix, through its quaternion."""
    w, x, y, z = Transform(rows).quaternion()
    return transform_of_quaternion((0.0, 0.0, 0.0), (w, x, y, z)).rows

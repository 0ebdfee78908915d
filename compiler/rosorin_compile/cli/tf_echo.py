"""Answers as text: number for number as tf2_echo prints (ROS 2 Humble, ``tf2_ros/src/tf2_echo.cpp``), tables, JSON."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Publisher
from rosorin_compile.model.joint import NODE
from rosorin_compile.model.kinematics.lookup import Answer
from rosorin_compile.model.kinematics.quaternions import Positions

DIGITS = 3  # std::cout.precision(3), std::ios::fixed
_WIDTH = 6  # std::setw(6)
# What tf2_echo calls the order of a quaternion: nothing in Humble, newer versions (Jazzy, Rolling) say it.
ORDERS = {"humble": "", "jazzy": " (xyzw)"}
_COLUMNS = ("x", "y", "z", "roll", "pitch", "yaw")


def text(answer: Answer, digits: int = DIGITS, distro: str = "humble") -> list[str]:
    """Return what tf2_echo prints, line by line; the time is that of static transforms: 0.0."""
    return [
        "At time 0.0",
        f"- Translation: {_vector(answer.translation, digits)}",
        f"- Rotation: in Quaternion{ORDERS[distro]} {_vector(answer.quaternion, digits)}",
        f"- Rotation: in RPY (radian) {_vector(answer.rpy, digits)}",
        f"- Rotation: in RPY (degree) {_vector(answer.degrees, digits)}",
        "- Matrix:",
        *(_row(row, digits) for row in _matrix(answer)),
    ]


def _vector(values: Iterable[float], digits: int) -> str:
    return f"[{', '.join(f'{value:.{digits}f}' for value in values)}]"


def _row(values: Iterable[float], digits: int) -> str:
    width = _WIDTH + digits - DIGITS
    return "".join(f" {value:{width}.{digits}f}" for value in values)


def _matrix(answer: Answer) -> list[tuple[float, ...]]:
    rows = [(*row, x) for row, x in zip(answer.rows, answer.translation, strict=True)]
    return [*rows, (0.0, 0.0, 0.0, 1.0)]


def table(joints: Mapping[str, str], states: Iterable[Positions], answers: Iterable[Answer], digits: int) -> str:
    """Return one line a state: the joints that are varied, with their units, then x y z (m), roll pitch yaw (deg)."""
    units = {**joints, **dict.fromkeys(_COLUMNS[:3], "m"), **dict.fromkeys(_COLUMNS[3:], "deg")}
    heads = [f"{name} ({unit})" for name, unit in units.items()]
    rows = [
        [f"{number:.{digits}f}" for number in (*(state[joint] for joint in joints), *a.translation, *a.degrees)]
        for state, a in zip(states, answers, strict=True)
    ]
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(cells, widths, strict=True)) for cells in (heads, *rows)
    )


def csv(joints: Sequence[str], states: Iterable[Positions], answers: Iterable[Answer]) -> str:
    """Return one line a state for a spreadsheet: numbers in full, x y z in metres, angles in radians."""
    heads = [*joints, *_COLUMNS, "qx", "qy", "qz", "qw"]
    made = [",".join(f'"{head}"' if "," in head or '"' in head else head for head in heads)]
    for state, a in zip(states, answers, strict=True):
        numbers: tuple[Any, ...] = (*(state[joint] for joint in joints), *a.translation, *a.rpy, *a.quaternion)
        made.append(",".join(repr(float(number)) for number in numbers))
    return "\n".join(made)


def as_json(answer: Answer, positions: Positions) -> dict[str, Any]:
    """Return an answer as plain data; angles in radians unless the key says degrees."""
    return {
        "source": answer.source,
        "target": answer.target,
        "positions": dict(positions),
        "translation": list(answer.translation),
        "quaternion": list(answer.quaternion),
        "rpy": list(answer.rpy),
        "rpy_degrees": list(answer.degrees),
        "matrix": [list(row) for row in _matrix(answer)],
        "chain": [
            {
                "parent": move.step.parent,
                "child": move.step.child,
                "direction": "up" if move.up else "down",
                "joint": None if move.step.joint is None else move.step.joint.name,
                "type": "node" if move.step.joint is None else move.step.joint.type,
                "publishers": [_publisher(one, when) for one, when in move.step.publishers],
            }
            for move in answer.way
        ],
    }


def _publisher(publisher: Publisher, when: str) -> dict[str, str]:
    return {"name": publisher.name, "kind": publisher.kind, "when": when or "always"}


def who(publisher: Publisher) -> str:
    """Return a publisher in words."""
    if publisher.kind == STATIC_TRANSFORM_PUBLISHER:
        return f"the static_transform_publisher {publisher.name}"
    return f"{publisher.name} ({publisher.about})" if publisher.kind == NODE and publisher.about else publisher.name

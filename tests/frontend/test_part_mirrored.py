"""A mirrored part is the reflection of the part, for every key that has a side and whatever its numbers are."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.language.expand.description import expand
from rosorin_compile.model import Pose
from rosorin_compile.source.diagnostics import has_errors
from support.paths import SCHEMAS

np = pytest.importorskip("numpy")

SCHEMA = json.loads((SCHEMAS / "description.schema.json").read_text("utf-8"))
VECTORS = ("xyz", "rpy", "axis", "dir", "at", "gear", "scale", "size", "origin")
LIMIT = {"lower": -1, "upper": 1, "effort": 1, "velocity": 1}
POSE: dict[str, Any] = {"xyz": [0, 0, 0], "rpy": [0, 0, 0]}
AXIS = [0, 0, 1]
HEIGHTS = {"origin": [0, 0], "cell": 0.1, "step": 0.01, "method": "by hand"}
HEIGHTS |= {"heights": [[0.1, 0.2, 0.3], [0.3, 0.4, 0.2]], "bottom": [[0.0, 0.1, 0.2], [0.1, 0.1, 0.0]]}
WHEELS = {"front_left": "spin", "rear_left": "spin", "front_right": "spin", "rear_right": "spin"}
PART: dict[str, Any] = {
    "links": {
        "arm": {
            "inertial": {"mass": 1, **POSE, "inertia": dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), 1)},
            "visual": [{"box": {"min": [1, 2, 3], "max": [4, 6, 8]}, **POSE}],
            "collision": [
                {"mesh": {"file": "a.stl", "scale": [1, 2, 3]}, **POSE},
                {"mesh": {"file": "a.stl"}},
                {"sphere": {"radius": 1}, "mjcf": {"surfacevel": [1, 2, 3, 4, 5, 6]}},
            ],
            "sites": {"spot": dict(POSE)},
            "cameras": {"eye": dict(POSE)},
            "lights": {"lamp": {**POSE, "dir": AXIS}},
        },
        "hand": {"inertial": {"mass": 1, "of": [{"sphere": {"radius": 0.1}, **POSE}]}},
        "slide": {"collision": [{"height_map": HEIGHTS}]},
        **{name: {} for name in ("roll", "globe", "plane")},
    },
    "joints": {
        "hold": {"type": "fixed", "parent": "mount", "child": "arm", **POSE},
        "turn": {"type": "revolute", "parent": "arm", "child": "hand", **POSE, "axis": AXIS, "limit": LIMIT},
        "push": {"type": "prismatic", "parent": "arm", "child": "slide", **POSE, "axis": AXIS, "limit": LIMIT},
        "spin": {"type": "continuous", "parent": "arm", "child": "roll", **POSE},
        "swing": {
            "type": "ball",
            "parent": "arm",
            "child": "globe",
            **POSE,
            "actuator": {"type": "motor", "gear": [1, 2, 3]},
        },
        "glide": {"type": "planar", "parent": "arm", "child": "plane", **POSE, "axis": AXIS},
    },
    "sensors": {
        "view": {"type": "camera", "frame": "lens", "parent": "arm", **POSE, "optical": {"frame": "image", **POSE}}
    },
    "edges": [{"parent": "arm", "child": "target", "publisher": "p", **POSE}],
    "constraints": {
        "glue": {"type": "weld", "links": ["hand", "slide"], **POSE},
        "pin": {"type": "connect", "links": ["hand", "roll"], "at": [0.1, 0.2, 0.3]},
    },
    "actuators": {"jet": {"site": "spot", "type": "motor", "gear": [1, 2, 3, 4, 5, 6]}},
    "drive": {"mecanum": WHEELS, "frame": "arm"},
    "moveit": {"spheres": {"arm": [{"radius": 0.1, "xyz": [0, 0, 0]}]}},
}
X, Y = np.diag([-1, 1, 1]), np.diag([1, -1, 1])
SIDES = ({"front": "rear", "rear": "front"}, {"left": "right", "right": "left"}, {})


def used(part: Any, mirror: str | None) -> Any:
    """Return the plain tree of a robot that uses a part."""
    use = {"part": "limb", "parent": "base", **({"mirror": mirror} if mirror else {})}
    robot = {"robot": "r", "links": {"base": {}}, "parts": {"limb": part}, "use": {"l": use}}
    robot["publishers"] = {"p": {"node": "n", "package": "n"}}
    with TemporaryDirectory() as folder:
        file = Path(folder) / "robot.yaml"
        file.write_text(yaml.safe_dump(robot, sort_keys=False), "utf-8")
        made = expand(file, {}, None)
    assert not has_errors(made.diagnostics), [str(one) for one in made.diagnostics]
    return made.tree


def content(node: Any, s: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Yield what a tree says, as numbers that do not depend on how it is written, after the reflection ``s``."""
    if isinstance(node, list):
        for number, item in enumerate(node):
            yield from content(item, s, (*at, number))
    elif not isinstance(node, dict):
        yield at, node
    elif "sensors" not in at or not {"mjcf", "gazebo"} & set(at):  # those of the library are in the frame of the sensor
        sense = np.diag(s)
        rest = dict(node)
        if "xyz" in node or "rpy" in node:
            placed = Pose(*(tuple(rest.pop(key, (0, 0, 0))) for key in ("xyz", "rpy"))).transform()
            # A camera is symmetric to its x axis, a sensor to its y axis: the device is turned, not mirrored.
            own = {"cameras": (s, X), "sensors": (s, Y)}.get(at[-2] if at[-1:] != ("optical",) else "", (s, s))
            outer, inner = ((Y, X) if at[-1:] == ("optical",) else own) if -1 in sense else (s, s)
            yield (*at, "place"), outer @ placed.xyz
            yield (*at, "rotation"), outer @ np.array(placed.rows) @ inner
        if node.get("type") in ("revolute", "continuous", "planar", "prismatic"):
            axis = np.array(rest.pop("axis", (1, 0, 0)), float)
            yield (*at, "axis"), sense * axis * (1 if node["type"] == "prismatic" else np.linalg.det(s))
        for key in {"dir", "at", "scale"} & rest.keys() | ({"scale"} if "file" in node else set()):
            yield (*at, key), sense * rest.pop(key, (1, 1, 1))
        if "surfacevel" in node:
            linear, turning = np.array(rest.pop("surfacevel")).reshape(2, 3)
            yield (*at, "surfacevel"), [*(sense * linear), *(sense * turning * np.linalg.det(s))]
        if "gear" in node:
            gear = np.array(rest.pop("gear"), float).reshape(-1, 3)
            yield (*at, "gear"), [*(sense * gear[:-1]).flat, *(sense * gear[-1] * np.linalg.det(s))]
        if "ixy" in node:
            xx, yy, zz, xy, xz, yz = (rest.pop(key) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
            yield (*at, "inertia"), s @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ s
        if "min" in node:
            ends = zip(rest.pop("min"), rest.pop("max"), strict=True)
            yield (*at, "corners"), sorted(tuple(sense * corner) for corner in product(*ends))
        if "heights" in node:
            (x, y), cell, rows = rest.pop("origin"), node["cell"], (rest.pop("heights"), rest.pop("bottom"))
            for i, j in product(range(len(rows[0])), range(len(rows[0][0]))):
                centre = sense[:2] * (x + (i + 0.5) * cell, y + (j + 0.5) * cell)
                yield (*at, *np.round(centre, 6) + 0.0), [row[i][j] for row in rows]
        swapped = SIDES[list(sense).index(-1)] if -1 in sense and at[-1:] == ("mecanum",) else {}
        for key, inner in rest.items():
            yield from content(inner, s, (*at, "_".join(swapped.get(word, word) for word in key.split("_"))))


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-3, 3).map(lambda value: round(value, 3)), min_size=30, max_size=30), st.sampled_from("xyz"))
def test_a_mirrored_part_is_the_reflection_of_the_part(numbers: list[float], axis: str) -> None:
    count = iter(range(10_000))

    def drawn(value: Any, key: str = "") -> Any:
        if isinstance(value, dict):
            return {name: drawn(inner, name) for name, inner in value.items()}
        if isinstance(value, list) and key in VECTORS:
            return [numbers[next(count) % 30] or 0.5 for _ in value]
        if key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
            return numbers[next(count) % 30]
        return [drawn(inner) for inner in value] if isinstance(value, list) else value

    part = drawn(PART)
    if axis == "z":  # a map counts its heights up from z = 0
        part["links"]["slide"] = {}
    s = np.diag([-1.0 if name == axis else 1.0 for name in "xyz"])
    expected, found = dict(content(used(part, None), s)), dict(content(used(part, axis), np.eye(3)))
    assert found.keys() == expected.keys()
    wrong = {at: (found[at], value) for at, value in expected.items() if not _is_equal(found[at], value)}
    assert wrong == {}


def _is_equal(one: Any, other: Any) -> bool:
    if isinstance(one, (str, bool)) or one is None:
        return bool(one == other)
    return np.shape(one) == np.shape(other) and bool(np.allclose(one, other, atol=1e-9))


def test_each_spatial_key_is_mirrored_or_says_why_not() -> None:
    """A mapping with a position, a rotation or a direction has ``x-mirror`` in the schema, or ``x-unmirrored``."""
    spatial = {"xyz", "rpy", "axis", "dir", "direction", "at", "ixy", "heights", "gear"}
    missing = []

    def visit(node: Any, at: str, reason: bool) -> None:
        if isinstance(node, dict):
            reason = reason or bool(node.get("x-mirror")) or bool(node.get("x-unmirrored"))
            found = spatial & set(node["properties"]) if isinstance(node.get("properties"), dict) else set()
            if found and not reason:
                missing.append((at, found))
            for key, inner in node.items():
                visit(inner, f"{at}/{key}", reason and key != "properties")
        elif isinstance(node, list):
            for inner in node:
                visit(inner, at, reason)

    visit(SCHEMA, "", False)
    assert missing == []

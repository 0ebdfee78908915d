"""What a mirrored part holds is reflected at the plane across y: places, turns, axes, products of inertia, boxes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.language.expand import expand
from rosorin_compile.source.diagnostics import has_errors
from support.paths import SCHEMAS

POSE = {"xyz": [0.1, 0.2, 0.3], "rpy": [0.4, 0.5, 0.6]}
MIRRORED = {"xyz": [0.1, -0.2, 0.3], "rpy": [-0.4, 0.5, -0.6]}
LIMIT = {"lower": -1, "upper": 1, "effort": 1, "velocity": 1}
AXIS = [0.48, 0.6, 0.64]
TURNED, SLID = [-0.48, 0.6, -0.64], [0.48, -0.6, 0.64]
INERTIA = {"ixx": 1, "iyy": 1, "izz": 1, "ixy": 0.1, "ixz": 0.2, "iyz": 0.3}
MAP = {"origin": [0, 0.1], "cell": 0.1, "step": 0.01, "heights": [[0.1, 0.2], [0.3, 0.4]], "method": "by hand"}
PART: dict[str, Any] = {
    "links": {
        "arm": {
            "inertial": {"mass": 1, **POSE, "inertia": INERTIA},
            "visual": [{"box": {"min": [1, 2, 3], "max": [4, 6, 8]}, **POSE}],
            "collision": [{"mesh": {"file": "a.stl", "scale": [1, 2, 3]}, **POSE}],
            "sites": {"spot": dict(POSE)},
            "cameras": {"eye": dict(POSE)},
            "lights": {"lamp": {**POSE, "dir": [0.6, 0.64, 0.48]}},
        },
        "hand": {"inertial": {"mass": 1, "of": [{"sphere": {"radius": 0.1}, **POSE}]}},
        "slide": {"collision": [{"height_map": MAP}]},
        "roll": {},
        "globe": {},
        "plane": {},
    },
    "joints": {
        "hold": {"type": "fixed", "parent": "mount", "child": "arm", **POSE},
        "turn": {"type": "revolute", "parent": "arm", "child": "hand", **POSE, "axis": AXIS, "limit": LIMIT},
        "push": {"type": "prismatic", "parent": "arm", "child": "slide", **POSE, "axis": AXIS, "limit": LIMIT},
        "spin": {"type": "continuous", "parent": "arm", "child": "roll", **POSE},
        "swing": {"type": "ball", "parent": "arm", "child": "globe", **POSE},
        "glide": {"type": "planar", "parent": "arm", "child": "plane", **POSE, "axis": AXIS},
    },
    "sensors": {
        "view": {"type": "camera", "frame": "lens", "parent": "arm", **POSE, "optical": {"frame": "image", **POSE}},
    },
    "constraints": {
        "glue": {"type": "weld", "links": ["hand", "slide"], **POSE},
        "pin": {"type": "connect", "links": ["hand", "roll"], "at": [0.1, 0.2, 0.3]},
    },
    "actuators": {
        "whirl": {"joint": "swing", "type": "motor", "gear": [1, 2, 3]},
        "jet": {"site": "spot", "type": "motor", "gear": [1, 2, 3, 4, 5, 6]},
    },
    "moveit": {"spheres": {"arm": [{"radius": 0.1, "xyz": POSE["xyz"]}]}},
}


def tree(folder: Path, **use: Any) -> Any:
    """Return the plain tree of a robot that uses the part."""
    file = folder / "robot.yaml"
    robot = {"robot": "r", "links": {"base": {}}, "parts": {"limb": PART}, "use": {"l": {"part": "limb", **use}}}
    file.write_text(yaml.safe_dump(robot, sort_keys=False), "utf-8")
    made = expand(file, {}, None)
    assert not has_errors(made.diagnostics), [str(one) for one in made.diagnostics]
    return made.tree


def leaves(value: Any, at: tuple[object, ...] = ()) -> Iterator[tuple[tuple[object, ...], Any]]:
    """Yield the values of a tree with the way to each; a list of numbers is one."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*at, str(key).removeprefix("l_")))
    elif isinstance(value, list) and not all(isinstance(item, (int, float)) for item in value):
        for number, inner in enumerate(value):
            yield from leaves(inner, (*at, number))
    else:
        yield at, list(map(float, value)) if isinstance(value, list) else value


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[Any, Any], dict[Any, Any]]:
    made = (tree(tmp_path_factory.mktemp("part"), parent="base", **more) for more in ({}, {"mirror": "y"}))
    one, other = (dict(leaves(one)) for one in made)
    return one, other


def test_each_pose_is_reflected(both: tuple[dict[Any, Any], dict[Any, Any]]) -> None:
    plain, mirrored = both
    # How a camera of a simulation looks along its frame is that of the library.
    poses = [at for at in plain if at[-1] in POSE and at[2] not in ("mjcf", "gazebo")]
    assert len(poses) == 2 * 16 + 1
    wrong = {at: mirrored.get(at) for at in poses if mirrored.get(at) != pytest.approx(MIRRORED[str(at[-1])])}
    assert wrong == {}


def test_what_else_has_a_side_is_reflected_and_nothing_more(both: tuple[dict[Any, Any], dict[Any, Any]]) -> None:
    plain, mirrored = both
    changed = {at: value for at, value in mirrored.items() if plain.get(at) != value and at[-1] not in POSE}
    assert changed == {
        ("joints", "turn", "axis"): TURNED,
        ("joints", "push", "axis"): SLID,
        ("joints", "spin", "axis"): [-1, 0, 0],
        ("joints", "glide", "axis"): TURNED,
        ("links", "arm", "inertial", "inertia", "ixy"): -0.1,
        ("links", "arm", "inertial", "inertia", "iyz"): -0.3,
        ("links", "arm", "visual", 0, "box", "min"): [1, -6, 3],
        ("links", "arm", "visual", 0, "box", "max"): [4, -2, 8],
        ("links", "arm", "collision", 0, "mesh", "scale"): [1, -2, 3],
        ("links", "arm", "lights", "lamp", "dir"): [0.6, -0.64, 0.48],
        ("links", "slide", "collision", 0, "height_map", "origin"): pytest.approx([0, -0.3]),
        ("links", "slide", "collision", 0, "height_map", "heights", 0): [0.2, 0.1],
        ("links", "slide", "collision", 0, "height_map", "heights", 1): [0.4, 0.3],
        ("constraints", "pin", "at"): [0.1, -0.2, 0.3],
        ("actuators", "whirl", "gear"): [-1, 2, -3],
        ("actuators", "jet", "gear"): [1, -2, 3, -4, 5, -6],
    }
    assert plain.keys() - mirrored.keys() == set()


@given(st.lists(st.floats(-3, 3).map(lambda value: round(value, 3)), min_size=100, max_size=100), st.sampled_from("xy"))
@settings(max_examples=25, deadline=None)
def test_a_part_that_is_mirrored_twice_is_the_part(numbers: list[float], axis: str) -> None:
    """Whatever numbers a part has: the reflection of its reflection is the part itself, for every key."""
    draw = iter(numbers)

    def drawn(value: Any, key: str = "") -> Any:
        if isinstance(value, dict):
            return {name: drawn(inner, name) for name, inner in value.items()}
        if isinstance(value, list) and key in ("xyz", "rpy", "dir", "at", "gear", "scale"):
            return [next(draw, 0.5) for _ in value]
        return [drawn(inner) for inner in value] if isinstance(value, list) else value

    limb = drawn(PART)
    with TemporaryDirectory() as folder:
        made = []
        for mirrors in ((), (axis,), (axis, axis)):
            parts: dict[str, Any] = {"limb": limb}
            inner = "limb"
            for number, mirror in enumerate(mirrors):
                use = {"part": inner, "parent": "mount", "prefix": "", "mirror": mirror}
                inner = f"outer{number}"
                parts[inner] = {"use": {"inner": use}}
            robot = {"robot": "r", "links": {"base": {}}, "parts": parts}
            robot["use"] = {"l": {"part": inner, "parent": "base"}}
            file = Path(folder) / "robot.yaml"
            file.write_text(yaml.safe_dump(robot, sort_keys=False), "utf-8")
            result = expand(file, {}, None)
            assert not has_errors(result.diagnostics), [str(one) for one in result.diagnostics]
            made.append(dict(leaves(result.tree)))
    plain, once, twice = made
    assert plain != once
    wrong = {at: twice.get(at) for at, value in plain.items() if at[0] != "parts" and not equal(twice.get(at), value)}
    assert wrong == {}


def equal(one: Any, other: Any) -> bool:
    return one == other or (isinstance(one, (int, float, list)) and one == pytest.approx(other))


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

    visit(json.loads((SCHEMAS / "description.schema.json").read_text("utf-8")), "", False)
    assert missing == []

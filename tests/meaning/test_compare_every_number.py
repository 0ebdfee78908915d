"""A change of any number of the description shows up in every artifact that carries it, only there, and by its name.

What carries what is said here, in a table of its own, and not asked of the compiler.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.golden_check import compare
from rosorin_compile.model import HeightMap
from support.paths import ROSORIN
from support.robots import MOVING, compiled, copy_of_rosorin

FINGERS = {"r_joint", "l_joint", "l_in_joint", "l_out_joint", "r_in_joint", "r_out_joint"}
SIMULATED = {"mjcf", "urdf_sim"}
SOLID = {"urdf", "robot_model"} | SIMULATED
MOUNTS = {
    "camera": ("camera_joint", SOLID | {"frames"}),
    "lidar": ("lidar_joint", SOLID | {"static_tf", "static_tf_json", "frames"}),
    "imu": ("imu_joint", {"mjcf", "static_tf", "static_tf_json", "frames"}),
}
# Where the names in the description are not those of the artifacts: joints that share a named value.
SHARED = {
    "arm_limit": ["joint1", "joint2", "joint3", "joint4", "joint5"],
    "finger_limit": sorted(FINGERS),
    "servo_dynamics": ["joint1", "joint2", "joint3", "joint4", "joint5", "r_joint"],
    "servo_actuator": ["joint1", "joint2", "joint3", "joint4", "joint5", "r_joint"],
    "finger_dynamics": sorted(FINGERS - {"r_joint"}),
}
ANGLES = {"x": "roll", "y": "pitch", "z": "yaw"}
LIMITS = {"lower": SOLID, "upper": SOLID, "effort": {"urdf"} | SIMULATED, "velocity": {"urdf", "urdf_sim"}}
DYNAMICS = {"damping": SIMULATED, "friction": SIMULATED}
# Numbers of the wheels: what carries them, and what is said of each of the four.
WHEELS = {
    "wheelbase": (SIMULATED, ["link moved .* in base_link: origin x "]),
    "track": (SIMULATED, ["link moved .* in base_link: origin y "]),
    "z": (SIMULATED, ["link moved .* in base_link: origin z "]),
    "radius": (
        SIMULATED,
        ["link inertia ", "link (collision|visual): cylinder radius ", r"roller_\d moved ", r"roller_\d "],
    ),
    "width": (SIMULATED, ["link inertia ", "link (collision|visual): cylinder length "]),
    "mass": (SIMULATED, ["link mass ", "link inertia ", r"roller_\d mass ", r"roller_\d inertia "]),
    "damping": (SIMULATED, ["joint damping "]),
    "armature": ({"mjcf"}, ["joint armature "]),
    "effort": (SIMULATED, ["joint limit effort "]),
    "velocity": (SIMULATED, ["joint limit velocity ", "joint velocity ctrlrange "]),
    "kv": ({"mjcf"}, ["joint velocity kv "]),
    "rgba": (SIMULATED, ["link visual colour ", r"roller_\d visual colour "]),
}
CORNERS = ("front_left", "rear_right", "front_right", "rear_left")
# Held at its root: a robot that stands free is lifted by whatever moves its wheels.
HELD = {"base": "fixed"}
# The camera of the scene looks from as far away as the robot is large.
OF_THE_WHOLE = "scene"
NUMBER = re.compile(r"^([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)( .+)?$")


class Leaf(NamedTuple):
    """A number of the description: its file and path, the place of its text, its value and its unit."""

    file: str
    path: tuple[str | int, ...]
    start: int
    end: int
    value: float
    unit: str


class Carried(NamedTuple):
    """The outputs that a number is in, and how each change of meaning begins that it makes (an expression).

    ``many`` of them begin like each line where a part makes several things of one number.
    """

    outputs: set[str]
    lines: list[str]
    many: bool = False


def leaves() -> Iterator[Leaf]:
    def walk(node: yaml.Node, path: tuple[str | int, ...]) -> Iterator[tuple[tuple[str | int, ...], yaml.ScalarNode]]:
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                yield from walk(value, (*path, key.value))
        elif isinstance(node, yaml.SequenceNode):
            for index, value in enumerate(node.value):
                yield from walk(value, (*path, index))
        elif isinstance(node, yaml.ScalarNode):
            yield path, node

    for file in (one for one in sorted(ROSORIN.parent.glob("*.yaml")) if one.name not in MOVING):
        for path, node in walk(yaml.compose(file.read_text("utf-8")), ()):
            found = NUMBER.match(node.value)
            if found and path != ("rosorin_compile",):
                unit = found[2] or ""
                yield Leaf(file.name, made(path), node.start_mark.index, node.end_mark.index, float(found[1]), unit)


def made(path: tuple[str | int, ...]) -> tuple[str | int, ...]:
    """Return the path of a number in what the finger part makes of it; any other path as it is."""
    if path[0] != "use":
        return path
    name, rest = path[1], path[3:] if path[2] == "with" else path[2:]
    if rest[0] == "inertial":
        return ("links", f"{name}_link", *rest)
    return ("joints", f"{name}_joint", *(("mimic", "multiplier") if rest[0] == "follows" else rest))


LEAVES: dict[str, list[Leaf]] = {}
for leaf in leaves():
    LEAVES.setdefault(".".join("*" if isinstance(step, int) else step for step in leaf.path), []).append(leaf)


def changed(leaf: Leaf, small: bool) -> float:
    """Return another value that is valid too."""
    last, value = [step for step in leaf.path if isinstance(step, str)][-1], leaf.value
    if "inertia" in leaf.path:
        return value * (1.01 if last in ("ixy", "ixz", "iyz") else 1.0001)
    if "inertial" in leaf.path or leaf.path[0] == "let" or last == "multiplier":
        return value + 1e-4 if last == "xyz" else value * 1.01
    if last in ("xyz", "origin"):
        return value + (1e-6 if small else 1e-3)
    if last == "rpy":
        return value + (1.0 if leaf.unit else 0.01)
    if last in ("min", "max"):
        return value + (-1e-3 if last == "min" else 1e-3)
    if last == "heights":
        return round(value + (1e-3 if small else 0.01), 6)
    return value + (1e-4 if last == "axis" else 1.0)


def carried(leaf: Leaf, value: float) -> Carried:
    """Return what carries a number, now that it is ``value``."""
    section, name, *rest = leaf.path
    axis = "xyz"[rest[-1]] if rest and rest[-1] in (0, 1, 2) else ""
    if leaf.file == "wheels.yaml":
        outputs, lines = WHEELS[[step for step in leaf.path if isinstance(step, str)][-1]]
        starts = [f"(actuator )?{corner}_wheel_{line}" for corner in CORNERS for line in lines]
        return Carried(outputs, starts, many=True)
    if section == "let":
        outputs = LIMITS.get(str(rest[0])) or DYNAMICS.get(str(rest[0]), {"mjcf"})
        outputs = outputs & SIMULATED if name == "finger_limit" else outputs
        outputs = {"mjcf"} if name == "servo_actuator" else outputs  # no URDF has what drives a joint
        return Carried(
            outputs,
            [f"{joint} {'limit ' if rest[0] in LIMITS else ''}{rest[0]} " for joint in SHARED[str(name)]]
            if outputs
            else [],
        )
    if section in ("joints", "sensors"):
        return carried_by_joint(leaf, axis)
    if section == "poses":
        return Carried({"mjcf", "frames"}, [f"pose tuck: {rest[-1]} "])
    if section == "servos":
        poses = [f"pose tuck: joint{n} " for n in range(1, 6)]
        zero = Carried({"mjcf", "robot_model", "frames"}, ["servo pulse_to_rad zero pulse 500 -> 501", *poses])
        return zero if rest == ["zero_pulse"] else Carried(set(), [])
    if "inertial" in leaf.path:
        names = {"mass": "mass ", "xyz": f"centre of mass moved .*: {axis} "}
        lines = [f"{name} {names.get(str(rest[1]), f'inertia {rest[-1]} ')}"]
        return Carried(SIMULATED, lines, many=rest[-1] == "ixz")  # 2.5e-12: the formats may round it differently
    if "height_map" in leaf.path:
        return carried_by_height_map(leaf, value)
    return Carried(SOLID, [f"{name} collision: box {rest[-2]} {axis} "])


def frame_of(leaf: Leaf) -> str:
    """Return the frame that a joint or a sensor of the description places."""
    described = yaml.safe_load((ROSORIN.parent / leaf.file).read_text("utf-8"))
    section, name = str(leaf.path[0]), str(leaf.path[1])
    if name.removesuffix("_joint") in described.get("use", {}):
        return f"{name.removesuffix('_joint')}_link"
    entry = described[section][name]
    return str(entry["child" if section == "joints" else "frame"])


def carried_by_joint(leaf: Leaf, axis: str) -> Carried:
    section, name, quantity, *_ = leaf.path
    joint, outputs = str(name), SOLID | {"frames"}  # the box of base_footprint moves with base_joint in the URDF
    if section == "sensors":
        joint, outputs = MOUNTS[joint]
    elif name in FINGERS:
        outputs = SIMULATED | {"frames"}
    elif name == "end_effector_joint":
        outputs = outputs - {"urdf_sim"}  # it has neither mass nor shape
    child = frame_of(leaf)
    if quantity == "xyz":
        return Carried(outputs, [f"{child} moved .* in .*: origin {axis} "])
    if quantity == "rpy":
        return Carried(outputs, [f"{child} turned .* in .*: {ANGLES[axis]} "])
    if quantity == "axis":
        return Carried(outputs - {"frames"}, [f"{joint} axis .* -> "])
    return Carried(SIMULATED, [f"{joint} mimic multiplier "])


@cache
def _height_map() -> HeightMap:
    robot = compiled().robot
    assert robot is not None
    (found,) = [s.geometry for link in robot.links for s in link.collision if isinstance(s.geometry, HeightMap)]
    return found


def carried_by_height_map(leaf: Leaf, value: float) -> Carried:
    quantity = leaf.path[5]
    if quantity == "step":
        # Boxes that reach down to the floor hang at another link than those that do not.
        return Carried({"urdf"} | SIMULATED, ["base_footprint collision: .* the shapes of base_link"])
    if quantity != "heights":
        also = ["base_footprint height map step "] if quantity == "cell" else []  # the default of the step is the cell
        return Carried(SOLID, [f"base_footprint height map {quantity} ", *also])
    # Boxes are rounded up to whole centimetres.
    before, after = (math.ceil(round(height * 100, 6)) for height in (leaf.value, value))
    row, column = leaf.path[-2:]
    bottom = round(_height_map().bottom_of(int(row), int(column)) * 100, 6)
    outputs = {"robot_model"} | ({"urdf"} if before != after else set())
    outputs |= SIMULATED if max(before, bottom) != max(after, bottom) else set()
    return Carried(outputs, ["base_footprint height map: 1 cell changed, by "])


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_of_rosorin(tmp_path_factory.mktemp("numbers"))


@pytest.fixture(scope="module")
def committed() -> dict[str, str]:
    return {artifact.output: artifact.text for artifact in compiled(arguments=HELD).artifacts}


def check(leaf: Leaf, small: bool, copy: Path, committed: dict[str, str]) -> None:
    file = copy.parent / leaf.file
    before, value = file.read_text("utf-8"), changed(leaf, small)
    spelled = repr(int(value) if leaf.value.is_integer() and value.is_integer() else value)
    file.write_text(f"{before[: leaf.start]}{spelled}{leaf.unit}{before[leaf.end :]}", "utf-8")
    try:
        made = compiled(copy, HELD)
    finally:
        file.write_text(before, "utf-8")
    expected = carried(leaf, value)
    other = {a.output for a in made.artifacts if a.text != committed[a.output]}
    assert other - {OF_THE_WHOLE} == expected.outputs
    old = {artifact.file: committed[artifact.output].encode() for artifact in made.artifacts}
    assert made.robot is not None
    comparison = compare(made.robot, made.artifacts, old)
    said = [change.line() for change in comparison.changes]
    assert expected.many or len(said) == len(expected.lines), said
    assert all(any(re.match(line, text) for line in expected.lines) for text in said), said
    for line in expected.lines:
        assert any(re.match(line, text) for text in said), (line, said)
    assert {output for change in comparison.changes for output in change.artifacts} == expected.outputs


ANY_LEAF = st.sampled_from(sorted(LEAVES)).flatmap(lambda path: st.sampled_from(LEAVES[path]))


@given(ANY_LEAF, st.booleans())
@settings(max_examples=20, deadline=None, derandomize=True)
def test_a_change_of_any_number_is_seen_where_it_is_carried_and_only_there(
    copy: Path, committed: dict[str, str], leaf: Leaf, small: bool
) -> None:
    check(leaf, small, copy, committed)


@pytest.mark.tier("fuzz")
@given(ANY_LEAF, st.booleans())
@settings(max_examples=150, deadline=None)
def test_a_change_of_many_numbers_is_seen_where_it_is_carried(
    copy: Path, committed: dict[str, str], leaf: Leaf, small: bool
) -> None:
    check(leaf, small, copy, committed)

"""Artifacts of any robot hold against the model, however its numbers are printed and however it is turned."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.formats.compilation import compile_robot

QUARTER = math.pi / 2


def angle(chance: random.Random) -> float:
    """Return an angle (rad): often a quarter turn, or just beside one, where six digits are the hardest."""
    near = QUARTER + chance.uniform(-1e-4, 1e-4)
    return chance.choice([0, QUARTER, -QUARTER, math.pi, near, chance.uniform(-3.2, 3.2), 1e-9])


def pose(chance: random.Random) -> str:
    sizes = [chance.choice([0, 1, 8, 1e-4, 1e-8]) for _ in range(3)]
    xyz = [size * chance.uniform(-1, 1) for size in sizes]
    return f"xyz: {xyz}, rpy: {[angle(chance) for _ in range(3)]}"


def shape(chance: random.Random) -> str:
    a, b, c = (10 ** chance.uniform(-3.5, 0.5) for _ in range(3))
    kind = chance.choice(["box", "cylinder", "capsule", "sphere", "ellipsoid"])
    sizes = {"box": f"size: [{a}, {b}, {c}]", "sphere": f"radius: {a}", "ellipsoid": f"radii: [{a}, {b}, {c}]"}.get(
        kind, f"radius: {a}, length: {b}"
    )
    return f"{{{kind}: {{{sizes}}}, {pose(chance)}}}"


def inertial(chance: random.Random) -> str:
    mass = 10 ** chance.uniform(-4, 3)
    if chance.random() < 0.5:
        return f"{{mass: {mass}, of: collision}}"
    a, b, c = (mass * 10 ** chance.uniform(-6, -1) for _ in range(3))
    moments = {"ixx": b + c, "iyy": a + c, "izz": a + b}
    products = {name: 1e-2 * min(a, b, c) * chance.uniform(-1, 1) for name in ("ixy", "ixz", "iyz")}
    entries = ", ".join(f"{name}: {value}" for name, value in (moments | products).items())
    return f"{{mass: {mass}, {pose(chance)}, inertia: {{{entries}}}}}"


def joint(chance: random.Random, index: int) -> str:
    kind = chance.choice(["fixed", "revolute", "continuous", "prismatic"])
    text = f"type: {kind}, parent: l{chance.randrange(index)}, child: l{index}, {pose(chance)}"
    if kind != "fixed":
        text += f", axis: {chance.choice(['[0, 0, 1]', '[0, -1, 0]', '[0.6, 0, 0.8]'])}"
    if kind in ("revolute", "prismatic"):
        lower, upper = -chance.uniform(0.1, 3), chance.uniform(0.1, 3)
        text += f", limit: {{lower: {lower}, upper: {upper}, effort: {chance.uniform(1, 9)}, velocity: 1}}"
    return f"{{{text}}}"


def description(chance: random.Random) -> str:
    """Return a description of a random robot with collision shapes, printed with six digits here and there."""
    count = chance.randrange(2, 8)
    rows = ["robot: any", "links:", "  l0: {inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}"]
    for index in range(1, count):
        rows += [f"  l{index}:", f"    inertial: {inertial(chance)}", "    collision:"]
        rows += [f"      - {shape(chance)}" for _ in range(chance.randrange(1, 4))]
    rows += ["joints:", *(f"  j{index}: {joint(chance, index)}" for index in range(1, count))]
    first, second = chance.choice(["six", "exact"]), chance.choice(["six", "exact"])
    rows += ["outputs:", f"  urdf: {{file: any.urdf, number_format: {first}}}"]
    rows += [f"  mjcf: {{file: any.xml, number_format: {second}, base: {chance.choice(['fixed', 'free'])}}}"]
    return "\n".join([*rows, "  static_tf: {file: tf.launch.py}", "  robot_model: {file: model.json}", ""])


def agrees(folder: Path, seed: int) -> None:
    file = folder / "any.yaml"
    file.write_text(description(random.Random(seed)))  # noqa: S311
    compiled = compile_robot(file)
    assert compiled.robot is not None, compiled.diagnostics
    assert [d.message for d in agreement(compiled.robot, compiled.artifacts)] == []


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_what_is_compiled_agrees(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    agrees(tmp_path_factory.mktemp("any"), seed)


@pytest.mark.parametrize("seed", range(6))
def test_what_is_compiled_of_a_few_robots_agrees(tmp_path: Path, seed: int) -> None:
    agrees(tmp_path, seed)


# What arithmetic leaves of a zero, beside numbers as large as a scene or a large machine has.
RESIDUES = st.floats(-1e-12, 1e-12)
LARGE = st.integers(1, 10**6)


@settings(max_examples=60, deadline=None)
@given(size=LARGE, residue=RESIDUES)
@example(size=1000, residue=9.9e-13)
def test_a_residue_of_a_zero_agrees_where_all_numbers_are_short(
    tmp_path_factory: pytest.TempPathFactory, size: int, residue: float
) -> None:
    """No number has more than six digits, as in a file of six digits, and ``short`` prints the residue as 0."""
    small = float(f"{size * residue:.1g}")
    place = f"xyz: [{size} m, 0, {small} m]"
    file = tmp_path_factory.mktemp("any") / "any.yaml"
    file.write_text(
        "robot: any\n"
        "links:\n"
        "  base: {}\n"
        "  a:\n"
        f"    inertial: {{mass: 2, {place}, inertia: {{ixx: {size}, iyy: {size}, izz: {size}, ixy: {small}}}}}\n"
        f"    collision: [{{box: {{size: [1, 1, 1]}}, {place}}}]\n"
        f"joints: {{far: {{type: fixed, parent: base, child: a, {place}}}}}\n"
        "outputs:\n"
        "  urdf: {file: any.urdf}\n"
        "  sdf: {file: any.sdf}\n"
        "  mjcf: {file: any.xml}\n"
        "  frames: {file: frames.md}\n"
    )
    compiled = compile_robot(file)
    assert compiled.robot is not None, compiled.diagnostics
    assert {artifact.backend for artifact in compiled.artifacts} == {"urdf", "sdf", "mjcf", "frames"}
    assert [d.message for d in agreement(compiled.robot, compiled.artifacts)] == []


def spoiled(folder: Path, old: str, new: str) -> list[str]:
    """Return what is said of a wheel in a URDF of six digits, a quarter turn from upright, with one text replaced."""
    file = folder / "wheel.yaml"
    file.write_text(
        "robot: wheel\n"
        "links:\n"
        "  base: {}\n"
        "  wheel:\n"
        "    inertial: {mass: 200 g, of: collision}\n"
        "    collision: [{cylinder: {radius: 40 mm, length: 25 mm}, rpy: [0, 90 deg, 0]}]\n"
        "joints:\n"
        "  spin: {type: continuous, parent: base, child: wheel, rpy: [30 deg, 90 deg, 0], axis: [0, 0, 1]}\n"
        "outputs: {urdf: {file: wheel.urdf, number_format: six}}\n"
    )
    compiled = compile_robot(file)
    assert compiled.robot is not None
    artifact = compiled.artifacts[0]
    assert old in artifact.text
    return [d.message for d in agreement(compiled.robot, [replace(artifact, text=artifact.text.replace(old, new, 1))])]


def test_the_inertia_of_a_turned_wheel_is_known_as_well_as_its_angles(tmp_path: Path) -> None:
    assert spoiled(tmp_path, "wheel", "wheel") == []
    [message] = spoiled(tmp_path, 'izz="0.00016"', 'izz="0.00017"')
    assert "wheel inertia ixx 0.00016 -> 0.00017 kg*m^2" in message


def test_a_pitch_of_90_degrees_hides_nothing(tmp_path: Path) -> None:
    [message] = spoiled(tmp_path, 'rpy="0.523599 1.570796 0"', 'rpy="0.523699 1.570796 0"')
    assert "wheel turned 0.0057 deg in base" in message

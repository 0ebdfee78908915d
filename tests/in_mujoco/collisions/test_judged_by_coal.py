"""What MuJoCo says of the links of a URDF, held against coal: who touches, and how far apart the others are."""

import os
import random
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.mujoco.collisions import FAR, TOUCH, Search
from rosorin_compile.mujoco.solids import read_meshes
from rosorin_compile.request import Request
from rosorin_compile.ros.srdf.planning import planning_model
from rosorin_compile.source.project import Description
from support.coal import Coal
from support.paths import data_text

pytest.importorskip("mujoco", minversion="3.12")
pytest.importorskip("pinocchio")
pytest.importorskip("coal")
trimesh = pytest.importorskip("trimesh")

pytestmark = pytest.mark.slow  # two engines, hundreds of states

STATES = 300
MOST_NEAR = 400  # distances that are compared of each robot
ROUNDING = 1e-4  # m: how near to touching the two may differ, by the end of their searches
SHAPES = {
    "box": "{box: {size: [0.08, 0.05, 0.12]}}",
    "sphere": "{sphere: {radius: 0.05}}",
    "cylinder": "{xyz: [0, 0.01, 0], rpy: [0.3, 0, 0.7], cylinder: {radius: 0.03, length: 0.14}}",
    "mesh": "{rpy: [0, 0.4, 0], mesh: {file: stone.stl, scale: [1, 1.5, 1]}}",
}


def described(folder: Path, seed: int) -> Path:
    """Write a robot whose links are often in each other: a tree of all shapes, with all joints that have a position."""
    chance = random.Random(seed)  # noqa: S311
    points = np.random.default_rng(seed).normal(size=(30, 3)) * 0.04
    trimesh.convex.convex_hull(points).export(folder / "stone.stl")
    links, joints = ["  base: {collision: [{box: {size: [0.1, 0.1, 0.1]}}]}"], []
    names = ["base"]
    for number in range(9):
        name, kind = f"part{number}", list(SHAPES)[number % len(SHAPES)]
        more = f", {SHAPES[chance.choice(list(SHAPES))]}" if number % 3 == 0 else ""
        links.append(f"  {name}: {{collision: [{SHAPES[kind]}{more}]}}")
        axis = ", ".join(f"{chance.choice((-1, 1)) * float(number % 3 == place):g}" for place in range(3))
        xyz = ", ".join(f"{chance.uniform(-0.12, 0.12):.4f}" for _ in range(3))
        joint = chance.choice(("revolute", "continuous", "prismatic", "revolute"))
        limit = ", limit: {lower: -0.1, upper: 0.2, effort: 1, velocity: 1}" if joint != "continuous" else ""
        parent = chance.choice(names)
        joints.append(
            f"  j{number}: {{type: {joint}, parent: {parent}, child: {name}, xyz: [{xyz}], axis: [{axis}]{limit}}}"
        )
        names.append(name)
    made = folder / "robot.yaml"
    parts = ["robot: stones", "links:", *links, "joints:", *joints, "outputs: {urdf: {file: stones.urdf}}"]
    made.write_text("\n".join([*parts, ""]), "utf-8")
    return made


def both(path: Path, outputs: Path) -> tuple[Search, Coal]:
    description = Description("judged", path, outputs)
    known = Request(description).understand().case
    assert known is not None
    planning = planning_model(known.robot)
    assert planning is not None
    files = Places(path, outputs, {}, os.environ).meshes(known.tree, known.robot.outputs)
    _, meshes, problems = read_meshes(known, files)
    assert not problems
    (text,) = (one.text for one in compile_robot(path).artifacts if one.output == planning.urdf.name)
    for name, file in files.items():
        text = text.replace(f'"{name}"', f'"{file.absolute()}"')
    return Search(planning, meshes, {}), Coal(text)


def judged(search: Search, coal: Coal) -> tuple[int, int]:
    """Hold the engines against each other; return how many contacts and how many short distances agreed."""
    chance, touching, near = random.Random(7), 0, 0  # noqa: S311
    for _ in range(STATES):
        state = {name: chance.uniform(*ends) for name, ends in search.bounds.items()}
        ours, theirs = next(search.overlaps([state], TOUCH)), coal.distances(state)
        assert set(ours) <= set(theirs)
        for pair, far in theirs.items():
            if abs(far) > ROUNDING:
                assert (pair in ours) == (far < 0), (pair, ours.get(pair), far, state)
                touching += far < 0
            if ROUNDING < far < FAR and near < MOST_NEAR:
                assert next(search.distances(pair, [state], 2 * FAR)) == pytest.approx(far, abs=ROUNDING), (pair, state)
                near += 1
    return touching, near


@pytest.mark.landing("engines", "0")
@pytest.mark.parametrize("seed", range(4))
def test_all_shapes(tmp_path: Path, seed: int) -> None:
    path = described(tmp_path, seed)
    touching, near = judged(*both(path, tmp_path))
    assert touching > 500
    assert near > 100


FOLDING = data_text("robots/judged_by_coal_folding.yaml")


@pytest.mark.tier("engines")
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_state_of_a_fine_grid_is_nearer_than_what_was_found(tmp_path: Path, seed: int) -> None:
    """The finger comes nearest to the base at a limit, between two valleys: 3.6 mm, and 8.4 mm in the next."""
    path = tmp_path / "robot.yaml"
    path.write_text(f"{FOLDING}moveit: {{collisions: {{trials: 1000, seed: {seed}}}}}\n", "utf-8")
    search, _ = both(path, tmp_path)
    pair = ("base", "finger")
    axes = [np.linspace(*search.bounds[name], 150) for name in ("shoulder", "elbow")]
    states = [{"shoulder": float(one), "elbow": float(other)} for one in axes[0] for other in axes[1]]
    least = min(search.distances(pair, states, 1.0))
    (found,) = (one for one in search.run() if one.links == pair)
    assert found.nearest == pytest.approx(0.0036, abs=1e-9)
    assert least == pytest.approx(found.nearest, abs=ROUNDING)

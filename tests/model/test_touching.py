"""Whether solids touch: MuJoCo's distance of the same two geoms is the judge."""

import random
from collections.abc import Sequence

import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Mesh, Shape, Sphere, Transform  # noqa: E402
from rosorin_compile.mujoco.mjcf import contacts  # noqa: E402

CASES = 1500
QUARTER_TURNS = ([1, 0, 0, 0], [1, 1, 0, 0], [1, 0, 1, 0], [1, 1, 1, 1])


def solid(chance: random.Random) -> tuple[Shape, str, list[float]]:
    """Return a solid, and its type and sizes as MuJoCo has them; thin ones and large ones among them."""
    size = 10 ** chance.uniform(-2.5, 0)
    a, b, c = (size * 10 ** chance.uniform(-1, 0) for _ in range(3))
    return chance.choice(
        [
            (Shape(Box((-a, -b, -c), (a, b, c))), "box", [a, b, c]),
            (Shape(Cylinder(a, 2 * b)), "cylinder", [a, b]),
            (Shape(Capsule(a, 2 * b)), "capsule", [a, b]),
            (Shape(Sphere(a)), "sphere", [a]),
        ]
    )


def touch(ones: Sequence[Shape], others: Sequence[Shape], way: Transform) -> bool:
    made = [[solid for solid in map(contacts.solid_of, shapes) if solid is not None] for shapes in (ones, others)]
    return contacts.touch(made[0], made[1], way)


def distance(one: str, other: str, pos: str, quat: str) -> float:
    body = f'<body pos="{pos}" quat="{quat}"><geom {other}/></body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody><geom {one}/>{body}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return mujoco.mj_geomDistance(model, data, 0, 1, 10, None)


@pytest.mark.slow
def test_two_solids_touch_where_mujoco_says_so() -> None:
    chance = random.Random(20261122)  # noqa: S311
    touching = 0
    for _ in range(CASES):
        (one, kind, sizes), (other, other_kind, other_sizes) = solid(chance), solid(chance)
        quat = chance.choice(QUARTER_TURNS) if chance.random() < 0.3 else [chance.gauss(0, 1) for _ in range(4)]
        reach = max(sizes) + max(other_sizes)
        xyz = tuple(chance.uniform(-reach, reach) for _ in range(3))
        ones, others = (
            f'type="{word}" size="{" ".join(map(repr, some))}"'
            for word, some in ((kind, sizes), (other_kind, other_sizes))
        )
        judged = distance(ones, others, " ".join(map(repr, xyz)), " ".join(map(repr, quat)))
        way = Transform.of_quaternion(xyz, quat)
        ours = touch([one], [other], way)
        assert ours == touch([other], [one], way.inverse())
        touching += ours
        if abs(judged) > 10 * contacts.NEAR:  # where the engine is as exact as the question
            assert ours == (judged < 0), (kind, sizes, other_kind, other_sizes, xyz, quat, judged)
    assert CASES / 4 < touching < 3 * CASES / 4


UNIT = Shape(Box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)))


@pytest.mark.parametrize("gap", [0.0, contacts.NEAR / 2, -0.3])
@pytest.mark.parametrize("other", [UNIT, Shape(Sphere(0.5)), Shape(Cylinder(0.5, 1.0)), Shape(Capsule(0.5, 0.2))])
def test_faces_that_lie_on_each_other_touch(other: Shape, gap: float) -> None:
    assert touch([UNIT], [other], Transform(xyz=(1.0 + gap, 0.0, 0.0)))
    assert not touch([UNIT], [other], Transform(xyz=(1.0 + 2 * contacts.NEAR, 0.0, 0.0)))


def test_solids_in_one_place_touch_and_a_mesh_does_not() -> None:
    for other in (UNIT, Shape(Sphere(0.1)), Shape(Cylinder(0.1, 0.1)), Shape(Capsule(0.1, 0.1))):
        assert touch([UNIT], [other], Transform())
        assert touch([other], [other], Transform())
    assert not touch([UNIT, Shape(Mesh("a.stl"))], [Shape(Mesh("a.stl"))], Transform())


def test_a_height_map_is_touched_in_its_cells() -> None:
    steps = Shape(HeightMap((0.0, 0.0), 1.0, ((1.0, 0.0), (0.0, 2.0)), 1.0, "", 0.5))
    ball = [Shape(Sphere(0.2))]
    for at, expected in (((0.5, 0.5, 1.1), True), ((0.5, 1.5, 0.6), False), ((1.5, 1.5, 0.2), False)):
        assert touch([steps], ball, Transform(xyz=at)) == expected

"""Where a line enters and leaves a solid, against MuJoCo, which is asked from both ends of the line."""

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

np = pytest.importorskip("numpy")
mujoco = pytest.importorskip("mujoco")

from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, Geometry, Pose, Shape, Sphere  # noqa: E402
from rosorin_compile.model.bounds import through  # noqa: E402
from rosorin_compile.model.geometry import Vector, unit  # noqa: E402

FAR = 50.0  # m: beyond every shape here
NEAR = 1e-6  # m: MuJoCo finds the same surface by the same equations, in another order

sizes = st.floats(0.05, 2.0)
numbers = st.floats(-2.0, 2.0)
vectors = st.tuples(numbers, numbers, numbers)
geometries = st.one_of(
    st.builds(lambda x, y, z: Box((-x, -y, -z), (x, y, z)), sizes, sizes, sizes),
    st.builds(lambda x, y, z, at: Box(at, tuple(a + b for a, b in zip(at, (x, y, z)))), sizes, sizes, sizes, vectors),  # type: ignore[arg-type]  # noqa: B905
    st.builds(Cylinder, sizes, sizes),
    st.builds(Capsule, sizes, sizes),
    st.builds(Sphere, sizes),
    st.builds(lambda x, y, z: Ellipsoid((x, y, z)), sizes, sizes, sizes),
)


def geom(geometry: Geometry) -> str:
    if isinstance(geometry, Box):
        return f'type="box" size="{" ".join(repr(side / 2) for side in geometry.size)}"'
    if isinstance(geometry, Cylinder | Capsule):
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        return f'type="{kind}" size="{geometry.radius!r} {geometry.length / 2!r}"'
    if isinstance(geometry, Sphere):
        return f'type="sphere" size="{geometry.radius!r}"'
    assert isinstance(geometry, Ellipsoid)
    return f'type="ellipsoid" size="{" ".join(map(repr, geometry.radii))}"'


def first_hit(shape: Shape, origin: tuple[float, ...], direction: tuple[float, ...]) -> float:
    """Return how far MuJoCo's ray goes from a point; -1 where it hits nothing."""
    origin_of = shape.origin()
    w, x, y, z = _quaternion(origin_of)
    place = f'pos="{" ".join(map(repr, origin_of.xyz))}" quat="{w!r} {x!r} {y!r} {z!r}"'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody><geom {geom(shape.geometry)} {place}/></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return float(
        mujoco.mj_ray(model, data, np.array(origin), np.array(direction), None, 1, -1, np.zeros(1, dtype=np.int32))
    )


def way_through(shape: Shape, origin: Vector, direction: Vector) -> tuple[float, float] | None:
    back = shape.origin().transform().inverse()
    return through(shape.geometry, back.apply(origin), back.rotate(direction))


def _quaternion(pose: Pose) -> tuple[float, ...]:
    return pose.transform().quaternion()


def lies_in_a_face(shape: Shape, start: tuple[float, ...], direction: tuple[float, ...]) -> bool:
    """Return True if a line lies in a face of a box: MuJoCo hits it or not, depending on rounding."""
    back = shape.origin().transform().inverse()
    sides = shape.geometry.size if isinstance(shape.geometry, Box) else ()
    local = zip(sides, back.apply(start), back.rotate(direction), strict=False)  # type: ignore[arg-type]
    return any(abs(step) < NEAR and abs(abs(at) - side / 2) < FAR * NEAR for side, at, step in local)


@settings(max_examples=150, deadline=None)
@given(geometries, vectors, vectors, vectors, vectors)
def test_a_line_through_a_solid(geometry, xyz, rpy, target, sideways) -> None:
    """From far away on both sides: both ends of the way; a line that only grazes it is left aside."""
    assume(math.hypot(*sideways) > 0.1)
    shape, direction = Shape(geometry, Pose(xyz, rpy)), unit(sideways)
    start = tuple(a - FAR * b for a, b in zip(target, direction, strict=True))
    assume(not lies_in_a_face(shape, start, direction))
    end = tuple(a + FAR * b for a, b in zip(target, direction, strict=True))
    way = way_through(shape, start, direction)  # type: ignore[arg-type]
    enters = first_hit(shape, start, direction)
    back = first_hit(shape, end, tuple(-part for part in direction))
    if way is None or way[1] - way[0] < 1e-3:
        assert enters == -1 or 2 * FAR - back - enters < 2e-3
        return
    assert way[0] == pytest.approx(enters, abs=NEAR)
    assert way[1] == pytest.approx(2 * FAR - back, abs=NEAR)
    middle = tuple(a + (way[0] + way[1]) / 2 * b for a, b in zip(start, direction, strict=True))
    inner = way_through(shape, middle, direction)  # type: ignore[arg-type]
    assert inner is not None
    assert inner[0] < 0 < inner[1]


def test_a_line_along_an_axis() -> None:
    """Where a direction is zero along an axis: within, beside, and on the face itself, which is outside."""
    box = Shape(Box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)))
    assert way_through(box, (-3.0, 0.0, 0.0), (1.0, 0.0, 0.0)) == (2.0, 4.0)
    assert way_through(box, (-3.0, 2.0, 0.0), (1.0, 0.0, 0.0)) is None
    assert way_through(box, (-3.0, 1.0, 0.0), (1.0, 0.0, 0.0)) is None
    rod = Shape(Cylinder(1.0, 2.0))
    assert way_through(rod, (0.5, 0.0, -3.0), (0.0, 0.0, 1.0)) == (2.0, 4.0)
    assert way_through(rod, (1.5, 0.0, -3.0), (0.0, 0.0, 1.0)) is None

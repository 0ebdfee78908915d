"""Shapes around meshes: each holds the mesh, is as small as it can be where that is known, and is measured rightly."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosorin_compile.importing.description import layout
from rosorin_compile.importing.extract.extract import shape_entry
from rosorin_compile.importing.extract.shapes import fit_shapes, smallest_circle
from rosorin_compile.language.sections.links import lower_shape
from rosorin_compile.model import Box, Capsule, Cylinder, Pose, Shape
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml
from support.meshes import box, random_points

BRICK = box((-0.1, -0.05, -0.03), (0.1, 0.05, 0.03))


def turned(triangles: np.ndarray, *rpy: float) -> np.ndarray:
    return triangles @ np.array(Pose((0, 0, 0), rpy).transform().rows).T


def holds(shape: Shape, points: np.ndarray, by: float) -> np.ndarray:
    """Say which points are inside a shape, by its definition and no code of the product but its transform."""
    back = shape.pose.transform().inverse()
    seen = np.array([back.apply(tuple(point)) for point in points.tolist()])
    geometry = shape.geometry
    if isinstance(geometry, Box):
        return ((seen >= np.array(geometry.lower) - by) & (seen <= np.array(geometry.upper) + by)).all(axis=1)
    assert isinstance(geometry, Cylinder | Capsule)
    far, along = np.hypot(seen[:, 0], seen[:, 1]), np.abs(seen[:, 2]) - geometry.length / 2
    if isinstance(geometry, Cylinder):
        return (far <= geometry.radius + by) & (along <= by)
    return np.hypot(far, np.maximum(along, 0)) <= geometry.radius + by


MESHES = st.lists(
    st.tuples(*[st.tuples(*[st.floats(-0.2, 0.2) | st.sampled_from([-0.1, 0.0, 0.1])] * 3)] * 3), min_size=1, max_size=8
).map(np.array)


@settings(max_examples=40, deadline=None)
@given(MESHES, st.integers(1, 6), st.sampled_from([3, 5]))
@example(np.array([[(0, -0.1, 0), (5e-324, 0, 0), (-5e-324, -0.1, -0.1)]]), 2, 3)  # crosses x = 0 by next to nothing
def test_every_shape_holds_the_mesh(triangles: np.ndarray, stack: int, digits: int) -> None:
    points = np.concatenate([triangles.reshape(-1, 3), random_points(triangles, 100, 3)])
    for kind, fit in fit_shapes(triangles, digits, stack).items():
        held = np.zeros(len(points), dtype=bool)
        for piece in fit.pieces:
            held |= holds(piece, points, 1.1e-7)
        assert held.all(), kind
        assert fit.volume > 0


@pytest.mark.parametrize("angles", [(0, 0, 0), (0, 0, 5), (90, 0, 0), (0, 45, 0), (10, 20, 30), (-35, 5, 140)])
def test_oriented_box_of_a_turned_brick_is_the_brick(angles: tuple[float, float, float]) -> None:
    fit = fit_shapes(turned(BRICK, *map(math.radians, angles)), 5, 2)["oriented_box"]
    assert fit.volume == pytest.approx(0.2 * 0.1 * 0.06, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_cylinder_and_capsule_of_round_bodies(axis: str) -> None:
    turn = {"x": (0, math.pi / 2, 0), "y": (math.pi / 2, 0, 0), "z": (0, 0, 0)}[axis]
    rod = turned(trimesh.creation.cylinder(0.05, 0.3, sections=64).triangles, *turn)
    pill = turned(trimesh.creation.capsule(height=0.2, radius=0.05, count=[32, 32]).triangles, *turn)
    (cylinder,) = fit_shapes(rod, 5, 2)["cylinder"].pieces
    assert cylinder == Shape(Cylinder(0.05, 0.3), Pose((0, 0, 0), turn) if axis != "z" else IDENTITY)
    (capsule,) = fit_shapes(pill, 5, 2)["capsule"].pieces
    assert capsule.geometry == Capsule(0.05, 0.2)
    assert fit_shapes(pill, 5, 2)["capsule"].volume < fit_shapes(pill, 5, 2)["cylinder"].volume


def test_stack_follows_steps() -> None:
    steps = np.concatenate([box((0, 0, 0), (0.2, 0.1, 0.1)), box((0, 0, 0.1), (0.1, 0.1, 0.2))])
    fit = fit_shapes(steps, 5, 2, "z")["stack"]
    assert [piece.geometry for piece in fit.pieces] == [
        Box((0, 0, 0), (0.2, 0.1, 0.1)),
        Box((0, 0, 0.1), (0.2, 0.1, 0.2)),  # the step itself is at the foot of the upper one
    ]
    assert [piece.geometry for piece in fit_shapes(steps, 5, 2, "x")["stack"].pieces] == [
        Box((0, 0, 0), (0.1, 0.1, 0.2)),
        Box((0.1, 0, 0), (0.2, 0.1, 0.2)),
    ]


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=1, max_size=12).map(np.array))
def test_smallest_circle(points: np.ndarray) -> None:
    centre, radius = smallest_circle(points)
    far = np.hypot(*(points - centre).T)
    assert far.max() <= radius + 1e-12
    # No direction to move the centre makes it smaller: those that hold it are not all on one side.
    for angle in np.linspace(0, 2 * np.pi, 60):
        moved = np.array(centre) + 1e-3 * np.array([math.cos(angle), math.sin(angle)])
        assert np.hypot(*(points - moved).T).max() >= radius - 1e-9


@pytest.mark.parametrize("tiny", [5e-324, 1e-310, 1e-160, 1e-100, 1e-20, 1e-12])
def test_edge_of_hardly_any_length_is_measured_all_the_same(tiny: float) -> None:
    needle = np.array([[(0, 0, 0), (0, 0, tiny), (0.1, 0, 0)], [(0, 0, 0), (0, tiny, 0), (0, 0, tiny)]])
    assert fit_shapes(needle, 3, 2)["box"].overlap == 1


def test_measures_of_a_brick() -> None:
    measured = fit_shapes(BRICK, 5, 2)
    for kind in ("box", "oriented_box", "stack"):
        found = measured[kind]
        assert found.volume == pytest.approx(0.0012)
        assert found.overhang == pytest.approx(0, abs=1e-12)
        assert found.overlap == 1
    assert measured["cylinder"].overhang == pytest.approx(math.pi * 0.05831**2 * 0.2 - 0.0012, rel=1e-6)


@pytest.mark.parametrize("kind", ["box", "oriented_box", "cylinder", "capsule", "stack"])
def test_what_is_written_reads_back_as_the_same_shape(kind: str) -> None:
    moved = turned(BRICK, 0.1, 0.2, 0.3) + np.array([0.01, -0.02, 0.03])
    for piece in fit_shapes(moved, 5, 3)[kind].pieces:
        entry = parse_yaml(Source("pasted.yaml", layout({"shape": shape_entry(piece)})))["shape"]
        assert lower_shape(entry) == piece

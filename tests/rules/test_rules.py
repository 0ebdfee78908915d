"""The rules: none is wrong about a robot that is right."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.model import Inertial
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.source.diagnostics import NOTE
from support.robots import compiled, rules


def test_reference_robot_is_right():
    made = compiled()
    assert [d for d in made.diagnostics if d.severity != NOTE] == []


def orthogonal(seed: int) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


def inertial(matrix: np.ndarray) -> Inertial:
    m = [[float(value) for value in row] for row in matrix]
    return Inertial(1.0, IDENTITY, m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
@pytest.mark.parametrize("moments", [(1, 2, 2.5), (1, 1, 1), (1, 1, 2), (1e-6, 1, 1), (-1, 1, 2), (0, 0, 1)])
def test_principal_moments_are_the_eigenvalues(moments, scale):
    for seed in range(50):
        axes = orthogonal(seed)
        matrix = axes @ np.diag(moments) @ axes.T * scale
        matrix = (matrix + matrix.T) / 2
        assert inertial(matrix).principal_moments == pytest.approx(np.linalg.eigvalsh(matrix), abs=4e-15 * scale)


@given(st.integers(0, 2**32), st.integers(4, 12), st.floats(-6, 3))
@settings(max_examples=200, deadline=None)
def test_a_cloud_of_masses_has_a_physical_inertia(seed, count, exponent):
    rng = np.random.default_rng(seed)
    points, masses = rng.normal(size=(count, 3)) * 10**exponent, rng.uniform(0.1, 1, count)
    points = points - (masses @ points) / masses.sum()
    matrix = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    keys = dict(
        zip(
            ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"),
            map(float, matrix[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
            strict=True,
        )
    )
    link = {"inertial": {"mass": float(masses.sum()), "inertia": keys}}
    # Points have no size: what they weigh may well be denser than any body.
    assert set(rules({"robot": "made", "links": {"base_link": link}})) <= {"inertia-implausible"}

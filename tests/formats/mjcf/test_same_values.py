"""When two values of compiled models are equal: but for rounding, and no farther apart."""

from __future__ import annotations

import pytest

np = pytest.importorskip("numpy")

from rosorin_compile.formats.mjcf.same_values import close, near  # noqa: E402


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ([1.0, 2.0], [1.0, 2.0 + 1e-9], True),
        ([1.0, 2.0], [1.0, 2.0 + 3e-9], False),
        ([0.0], [9e-13], True),
        ([0.0], [1.1e-12], False),
        ([np.nan], [np.nan], True),
        ([1.0], [1.0, 1.0], False),
    ],
)
def test_numbers_of_double_precision(one: list[float], other: list[float], same: bool) -> None:
    assert close(np.array(one), np.array(other)) == same


@pytest.mark.parametrize(("moved", "same"), [(1.5e-6, True), (2.5e-6, False)])
def test_numbers_of_single_precision(moved: float, same: bool) -> None:
    assert close(np.array([1.0], np.float32), np.array([1.0 + moved], np.float32)) == same


def test_whole_numbers_are_equal_or_not() -> None:
    assert close(np.array([1, 2]), np.array([1, 2]))
    assert not close(np.array([1, 2]), np.array([1, 3]))


@pytest.mark.parametrize(("moved", "same"), [(0.9e-9, True), (-0.9e-9, True), (1.1e-9, False), (-1.1e-9, False)])
def test_places_are_one_within_a_nanometre(moved: float, same: bool) -> None:
    assert near([0.1, 0.2, 0.3], [0.1, 0.2 + moved, 0.3]) == same

"""When two values of compiled models are equal: but for rounding, and no farther apart."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

np = pytest.importorskip("numpy")

from rosorin_compile.mujoco.mjcf.compared_values import both, close, near, slice_of  # noqa: E402


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


@pytest.mark.parametrize(
    ("one", "other", "said"),
    [
        (0.1, 0.2, "0.1 in the source, 0.2 in ours"),
        ([1, 2], [], "1 2 in the source, nothing in ours"),
        (0.1, 0.1 + 1e-9, "0.1 in the source, 0.100000001 in ours"),
        (range(21), range(21, 42), "differs in 21 of 21 numbers: 0 in the source, 21 in ours"),
        (range(21), [*range(20), 0], "differs in 1 of 21 numbers: 20 in the source, 0 in ours"),
        (range(21), range(3), "has 21 numbers in the source, 3 in ours"),
        (range(3), range(21), "has 3 numbers in the source, 21 in ours"),
        (range(20), range(3), f"{' '.join(map(str, range(20)))} in the source, 0 1 2 in ours"),
    ],
)
def test_two_values_in_words(one: object, other: object, said: str) -> None:
    assert both(np.array(one), np.array(other)) == said


@pytest.mark.parametrize(("start", "piece"), [(0, [0.0, 0.1]), (2, [0.2, 0.3]), (-1, [])])
def test_a_piece_of_a_long_array(start: int, piece: list[float]) -> None:
    model = SimpleNamespace(mesh_texcoordadr=[start], mesh_texcoordnum=[2])
    assert [0.0, 0.1, 0.2, 0.3][slice_of(model, "mesh_texcoord", 0)] == piece

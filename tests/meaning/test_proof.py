"""A proof sorts what an engine found; numbers are the same up to a tolerance; states of joints come of a seed."""

from __future__ import annotations

import pytest

from rosorin_compile.compare.proof import Found, Proof, Tolerance
from rosorin_compile.model import Joint

PAIRS = [("b", "told"), ("a", "x"), ("b", "y"), ("a", "told"), ("b", "y")]


def is_told(_: str, text: str) -> bool:
    return text == "told"


def test_what_differs_stands_by_feature_in_the_order_of_the_first() -> None:
    proof = Proof.of("source", "made", lambda *_: Found(PAIRS, is_told, "said: {}".format, {"links": 2}))
    assert proof == Proof({"b": ["y", "y"], "a": ["x"]}, {"b": ["told"], "a": ["told"]}, counts={"links": 2})
    assert list(proof.wrong) == list(proof.known) == ["b", "a"]
    assert proof.texts == ["y", "y", "x"]


def test_what_holds_is_said_where_nothing_is_wrong() -> None:
    told = [pair for pair in PAIRS if is_told(*pair)]
    assert Proof.of(1, 2, lambda *_: Found(told, is_told, "/".join)).said == "b/a"
    assert Proof.of(1, 2, lambda one, other: Found(said=lambda _: f"{one} is {other}")).said == "1 is 2"
    assert Proof.of(1, 2, lambda *_: Found(told, said="/".join)).said == ""
    assert Proof.of(1, 2, lambda *_: "no engine") == Proof(unknown="no engine")


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [(0.0, 0.9e-12, True), (0.0, 1.1e-12, False), (1000.0, 1000.0 + 0.9e-9, True), (-1000.0, -1000.0 - 1.1e-9, False)],
)
def test_numbers_are_the_same_but_for_a_part_of_the_larger_or_of_one(one: float, other: float, same: bool) -> None:
    assert Tolerance.same(one, other) == Tolerance.same(other, one) == same


def test_how_far_apart_nested_numbers_are() -> None:
    assert Tolerance.apart([[1.0, 2.0], (3.0,)], [[1.0, 2.5], (2.75,)]) == 0.5
    assert Tolerance.apart([], []) == Tolerance.apart([1.0], [1.0]) == 0.0
    with pytest.raises(ValueError, match="shorter"):
        Tolerance.apart([1.0, 2.0], [1.5])


def test_states_are_the_same_for_a_seed_and_stand_between_two_numbers() -> None:
    joints = [(Joint(f"j_{kind}", kind, "a", "b"), 0.5, 0.75) for kind in ("revolute", "planar", "fixed")]
    states = Proof.states(joints, 30, 7)
    assert states == Proof.states(joints, 30, 7) != Proof.states(joints, 30, 8)
    assert len(states) == 30
    for state in states:
        assert 0.5 <= state["j_revolute"] <= 0.75
        assert len(state["j_planar"]) == 3
        assert all(0.5 <= number <= 0.75 for number in state["j_planar"])
        assert state["j_fixed"] == 0
    assert len({state["j_revolute"] for state in states}) == 30

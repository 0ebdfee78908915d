"""A proof sorts differences by feature, and states of joints come of a seed."""

from __future__ import annotations

from rosorin_compile.formats.imported import Proof
from rosorin_compile.importing.round_trip import random_states
from rosorin_compile.model import Joint
from rosorin_compile.mujoco.mjcf.proof import sort_differences

PAIRS = [("b", "told"), ("a", "x"), ("b", "y"), ("a", "told"), ("b", "y")]


def test_what_differs_is_by_feature_in_the_order_of_the_first() -> None:
    wrong, known = sort_differences(PAIRS, lambda _, text: text == "told")
    assert wrong == {"a": ["x"], "b": ["y", "y"]}
    assert known == {"b": ["told"], "a": ["told"]}
    assert Proof(wrong, known).texts == ["x", "y", "y"]


def test_states_are_the_same_for_a_seed_and_stand_between_two_numbers() -> None:
    joints = [(Joint(f"j_{kind}", kind, "a", "b"), 0.5, 0.75) for kind in ("revolute", "planar", "fixed")]
    states = random_states(joints, 30, 7)
    assert states == random_states(joints, 30, 7) != random_states(joints, 30, 8)
    assert len(states) == 30
    for state in states:
        assert 0.5 <= state["j_revolute"] <= 0.75
        assert len(state["j_planar"]) == 3
        assert all(0.5 <= number <= 0.75 for number in state["j_planar"])
        assert state["j_fixed"] == 0
    assert len({state["j_revolute"] for state in states}) == 30

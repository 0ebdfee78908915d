"""Values in words, and what differs between two of them: things of a list are known by their names."""

from __future__ import annotations

from typing import Any

import pytest

from rosorin_compile.compare.values import differing, text_of
from rosorin_compile.model import Link, Pose


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, ""),
        (False, "false"),
        (True, "true"),
        ((), ""),
        ((1.5, 2), "1.5 2"),
        ((1.0, None), "1 -"),
        (frozenset({"b", "a"}), "a b"),
        ({"one": 1, "two": True}, "one 1, two true"),
        (Pose(), ""),
        (Pose((1.0, 0.0, 0.0)), "xyz 1 0 0 rpy 0 0 0"),
    ],
)
def test_a_value_in_words(value: Any, text: str) -> None:
    assert text_of(value) == text


def test_a_number_has_the_digits_that_tell_it_from_another() -> None:
    assert (text_of(0.1, 0.1000000001), text_of(0.1000000001, 0.1)) == ("0.1", "0.1000000001")


A, B, HEAVY = Link("a"), Link("b"), Link("a", mjcf={"mocap": True})


@pytest.mark.parametrize(
    ("one", "other", "found"),
    [
        ([A, B], [A, B], []),
        ([A], [A, B], [("", ("a",), ("a", "b"))]),
        ([A, A], [A, HEAVY], [("a 2 mjcf mocap", None, True)]),
        ([A, A, A], [A, A, HEAVY], [("a 3 mjcf mocap", None, True)]),
        ([{"x": 1}, {"x": 2}], [{"x": 3}, {"x": 2}], [("1 x", 1, 3)]),
        ([{"x": 1}, {"x": 2}], [{"x": 1}, {"x": 3}], [("2 x", 2, 3)]),
        ([{"x": 1}], [{"x": 1}, {"x": 2}], [("", ("1",), ("1", "2"))]),
        (
            [Link("a b"), Link("a b")],
            [Link("a b", mjcf={"mocap": True}), Link("a b")],
            [("a b mjcf mocap", None, True)],
        ),
        ([{"x": 1}], [{"x": 2}], [("1 x", 1, 2)]),
        ((1.0, 2.0), (1.0, 2.0 + 1e-12), []),
        ((1.0, 2.0), (1.0, 2.1), [("", (1.0, 2.0), (1.0, 2.1))]),
    ],
)
def test_things_of_a_list_are_known_by_their_names(one: Any, other: Any, found: list[Any]) -> None:
    assert list(differing(one, other)) == found

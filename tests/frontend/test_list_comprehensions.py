"""List comprehensions have the values that Python gives them."""

from __future__ import annotations

import re
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.language.expression import ExpressionError, evaluate

VALUES: dict[str, Any] = {"a": 3, "b": -2, "i": 50}


def sums(names: tuple[str, ...]) -> st.SearchStrategy[str]:
    """Expressions of numbers and names, lists of several loops within them."""
    leaves = st.sampled_from([*names, "a", "b", "0", "7"])
    return st.recursive(
        leaves,
        lambda inner: st.one_of(
            st.builds("({} {} {})".format, inner, st.sampled_from("+-*"), inner),
            st.builds("({} if {} < {} else {})".format, inner, inner, inner, inner),
            st.builds("sum([{} for j in range(3)])".format, inner.map(lambda text: re.sub(r"\ba\b", "j", text))),
            st.builds("sum([{} for a in [1, 2]])".format, inner),
        ),
        max_leaves=8,
    )


@given(
    st.one_of(
        st.builds("[{} for i in range(4)]".format, sums(("i",))),
        st.builds("[{} for i in range(4) if {} > {}]".format, sums(("i",)), sums(("i",)), sums(("i",))),
        st.builds("[{} for i in range(3) for j in range(i)]".format, sums(("i", "j"))),
        st.builds("[[{} for j in range(3)] for i in range(3)]".format, sums(("i", "j"))),
        st.builds("[[{} for i in [1, 2]] + [{}] for i in range(3)]".format, sums(("i",)), sums(("i",))),
    )
)
def test_lists_are_those_of_python(text: str) -> None:
    try:
        told = evaluate(text, VALUES.__getitem__)
    except ExpressionError as problem:  # nested too deeply, or too large
        assert "nested" in str(problem) or "large" in str(problem)  # noqa: PT017
        return
    assert told == eval(text, {"sum": sum, "range": range, **VALUES})  # noqa: S307 - of numbers


def test_a_value_is_that_of_its_scope_though_the_same_text_stands_in_another() -> None:
    text = "[a * 2 + b for i in range(3)]"
    inner = {"a": 100, "b": 1}

    def lookup(name: str) -> Any:
        if name == "b":  # as a named value does that nobody has needed so far
            assert evaluate(text, inner.__getitem__) == [201] * 3
        return VALUES[name]

    assert evaluate(text, lookup) == [4] * 3


def test_each_item_is_a_list_of_its_own() -> None:
    rows = evaluate("[[0] + [1] for i in range(3)]", VALUES.__getitem__)
    assert rows == [[0, 1]] * 3
    assert len(set(map(id, rows))) == 3


def test_what_has_no_value_is_told_where_it_stands() -> None:
    with pytest.raises(ExpressionError) as told:
        evaluate("[i + a / 0 for i in range(3)]", VALUES.__getitem__)
    assert str(told.value) == "division by zero"
    assert evaluate("[i + a / 0 for i in range(0)]", VALUES.__getitem__) == []

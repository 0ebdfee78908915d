"""List comprehensions have the values that Python gives them."""

from __future__ import annotations

import re
from typing import Any

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

"""check --every-argument: every combination is compiled, and each problem says by which arguments it comes."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.language.arguments import combinations

pytestmark = pytest.mark.slow


CHOICES = st.lists(st.integers(1, 3), min_size=1, max_size=4).map(
    lambda sizes: [(f"a{n}", tuple(f"v{value}" for value in range(size))) for n, size in enumerate(sizes)]
)


@given(CHOICES)
@settings(max_examples=200, deadline=None)
def test_every_combination_comes_once_the_nearest_first(varied):
    found = list(combinations(varied))
    assert sorted(found) == sorted(itertools.product(*(values for _, values in varied)))
    defaults = found[0]
    near = [sum(a != b for a, b in zip(one, defaults, strict=True)) <= 1 for one in found]
    assert near == sorted(near, reverse=True)

"""Cases of a test of which a landing tries some, and a tier of ``.ci/full`` the others."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import TypeVar

import pytest
from _pytest.mark import ParameterSet

Case = TypeVar("Case")


def some(
    cases: Iterable[Case], at_a_landing: Collection[Case], tier: str, name: Callable[[Case], str] = str
) -> list[ParameterSet]:
    """Return the cases of a test by their names; those that are not tried at a landing belong to the tier."""
    marks = pytest.mark.tier(tier)
    return [pytest.param(one, id=name(one), marks=[] if one in at_a_landing else marks) for one in cases]

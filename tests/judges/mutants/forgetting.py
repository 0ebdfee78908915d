"""A plug-in of pytest: before each test, the modules in which mutants are planted forget what they were asked.

What one test has asked, the next one would be answered from a cache, and its lines would have the first test of a
process alone.
"""

from __future__ import annotations

import sys

import pytest

from judges.mutants.drawing import modules
from support.paths import COMPILER

_PLANTED = [
    ".".join(path.relative_to(COMPILER).with_suffix("").parts).removesuffix(".__init__") for path in modules(COMPILER)
]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    """Forget all before the fixtures of a test."""
    forget()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_call() -> None:
    """Forget what the fixtures of a test have asked: the test itself asks it anew."""
    forget()


def forget() -> None:
    """Clear the caches (of ``functools``) of the functions of these modules."""
    for name in _PLANTED:
        for value in [*vars(sys.modules[name]).values()] if name in sys.modules else ():
            if getattr(value, "__module__", "") == name and hasattr(value, "cache_clear"):
                value.cache_clear()

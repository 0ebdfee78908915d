"""A world of values has no tool: what a test before has said of it would be asked of the values."""

from __future__ import annotations

import pytest

from rosorin_compile.world import asking


@pytest.fixture(autouse=True)
def _no_tool() -> None:
    asking._tools.clear()

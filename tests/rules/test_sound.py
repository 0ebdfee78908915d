"""Nothing is said of what is right, though it looks like a mistake: each file of tests/sound says why."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.formats.compiled import compile_robot
from support.paths import ROOT

CASES = sorted((ROOT / "tests" / "sound").glob("*.yaml"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.stem)
def test_nothing_is_said(case: Path) -> None:
    made = compile_robot(case)
    assert made.robot is not None
    assert [f"{one.rule}: {one.message}" for one in made.diagnostics] == []

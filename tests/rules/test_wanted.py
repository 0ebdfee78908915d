"""Of the outputs of a robot those are judged that somebody asks for, all if nobody asks for any."""

from __future__ import annotations

import pytest

from rosorin_compile.formats.compiled import compile_robot
from support.paths import BAD


@pytest.mark.parametrize(
    ("case", "output"),
    [
        ("robot-model-servos", "robot_model"),
        ("nav2-base", "nav2"),
        ("controllers-none", "controllers"),
        ("filter-unclear", "robot_localization"),
    ],
)
def test_an_output_that_is_wanted_is_judged_and_no_other(case: str, output: str) -> None:
    def told(*wanted: str) -> bool:
        return case in {one.rule for one in compile_robot(BAD / f"{case}.yaml", requested=wanted).diagnostics}

    assert told()
    assert told(output)
    assert not told("frames")

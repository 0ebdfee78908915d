"""Nothing is said of what is right, though it looks like a mistake: each file of tests/sound says why."""

from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import compile_robot
from support.paths import BAD, ROOT

CASES = sorted((ROOT / "tests" / "sound").glob("*.yaml"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.stem)
def test_nothing_is_said(case: Path) -> None:
    made = compile_robot(case)
    assert made.robot is not None
    assert [f"{one.rule}: {one.message}" for one in made.diagnostics] == []


# Of the outputs of a robot those are judged that somebody asks for, all if nobody asks for any.


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

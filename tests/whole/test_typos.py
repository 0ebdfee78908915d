"""Swap two letters of a word in the robots of the repository: the typo is reported once, at its place.

Typos are drawn with a fixed seed: a few of each robot here, more of them in the tier ``fuzz``.
"""

import random
from pathlib import Path

import pytest

from support.typos import ROBOTS, tried, typos

FEW, MANY = 6, 300  # of each robot
SILENT = 0.1  # the share of typos in names that nothing else refers to: file names, topics, names of outputs, ...
MISPLACED = 0.03  # the share that may be reported where the name is used, not where it is defined
REPEATED = 0.01  # the share that may cause more than one error


@pytest.mark.slow
@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.tier("fuzz"))], ids=["few", "many"])
@pytest.mark.parametrize("robot", ROBOTS)
def test_a_typo_is_reported_once_at_its_place(
    robot: str, count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    total = sum(1 for _ in typos(robot))
    results = tried(robot, tmp_path, random.Random(7).sample(range(total), count))  # noqa: S311 - no secret
    assert [result.exception for result in results if result.exception] == []
    reported = [result for result in results if result.said]
    assert count - len(reported) <= max(2, SILENT * count)
    assert len([result for result in reported if not result.is_right]) <= max(1, MISPLACED * count)
    assert len([result for result in reported if result.errors > 1]) <= REPEATED * count

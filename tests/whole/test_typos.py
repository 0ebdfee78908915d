"""Two letters are swapped in some words of the robots of the repository: each is one error at its place.

What compiles nevertheless matches a pattern in ``LEGAL``.
"""

from __future__ import annotations

import random
import re
from collections.abc import Sequence
from pathlib import Path

import pytest

from support.typos import ROBOTS, Told, tried, typos

SAMPLE = 6  # of each robot
# Which typos nobody can tell, by what a typo is called, and why.
LEGAL = {
    r"\.(urdf|sdf|srdf|xml|yaml|json|md|svg|py) -> ": "a file may have any name",
    r"/robot\.yaml:[45]: \w+ -> ": "a robot may have any name",
    r": (calculate_dynamics|true) -> ": "a plugin has parameters of its own",
    r": (nav2_amcl|turtlebot3_node|robot_localization|slam_toolbox) -> ": "nobody looks whether a package is there",
    r": (/?scan|imu|imu_sensor_broadcaster/imu|odom_raw|/joint_states) -> ": "a topic that other programs publish",
    r"/calibration\.yaml:11: ": "a digest in a published table, which nothing reads",
    r"/collisions\.yaml:\d+: \w{12,} -> ": "a digest of what was computed: it is computed anew",
    r"unitree_a1/robot\.yaml:1[567]: (default|boxes|cylinders) -> ": "a layer of contacts is there by its name",
    r": (fixed|free) -> ": "a value that an argument may have, and does not have here",
    r": (imu|camera|lidar|claw|arm|home|[lr]_out|foot_contact) -> ": "an entry that nothing else names",
    r": [\w-]+_(joint|link|base|fixed|frame|laser|imu) -> ": "a joint or a frame that nothing else names",
    r": (\w+_(controller|broadcaster|manipulator|sim|control)|frames_\w+) -> ": "a controller, a group or an output",
}


def legal(typo: str) -> str:
    """Return the pattern of ``LEGAL`` that a typo is of; "" if it is none."""
    return next((pattern for pattern in LEGAL if re.search(pattern, typo)), "")


def unheard(found: Sequence[Told]) -> list[str]:
    return [one.typo for one in found if not one.said and not one.exception and not legal(one.typo)]


@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS)
def test_some_typos(robot: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    count = sum(1 for _ in typos(robot))
    found = tried(robot, tmp_path, random.Random(7).sample(range(count), SAMPLE))  # noqa: S311 - no secret
    assert len(found) == SAMPLE
    assert [one.exception for one in found if one.exception] == []
    assert unheard(found) == []
    assert [one for one in found if one.errors > 1] == []
    assert len([one for one in found if one.said and not one.is_right]) < 2

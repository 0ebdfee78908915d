"""Two letters swapped at every word of the robots of the repository: each is told, once, where it stands.

All of them are the tier ``typos`` of .ci/full; a few that a seed chooses are tried with every landing. What compiles
without a word is of ``LEGAL``: another name that may be, and why.
"""

from __future__ import annotations

import multiprocessing
import os
import random
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

from support.typos import ROBOTS, Told, tried, typos

SAMPLE = 6  # of each robot
PIECE = 200  # what a process tries at once
RIGHT = 0.98  # the share of what is told that stands at its place
ONCE = 0.995  # the share of it that is one error, and not several
WORST = 20

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


@pytest.mark.landing("fuzz", "rosorin", "porter")
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


@pytest.mark.tier("fuzz")
def test_every_typo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    found = list(everything(tmp_path))
    said = [one for one in found if one.said]
    once = [one for one in said if one.errors < 2]
    right = [one for one in said if one.is_right]
    crashed = [one for one in found if one.exception]
    silent = [one for one in found if not one.said and not one.exception]
    worst = sorted((one for one in said if one.errors > 1 or not one.is_right), key=lambda one: -one.errors)
    with capfd.disabled():
        print(f"\n{len(found)} typos: {len(crashed)} crash, {len(silent)} compile; of {len(said)} that are told")
        print(f"{len(right)} are told at their place, {len(once)} once; the worst:")
        for one in worst[:WORST]:
            print(f"  {one.typo}: {one.errors} errors, the first: {one.said[0]}")
        for pattern, count in Counter(legal(one.typo) for one in silent).items():
            print(f"  {count} compile: {LEGAL.get(pattern, 'and nobody knows why')}")
    assert [one.exception for one in crashed] == []
    assert unheard(found) == []
    assert {legal(one.typo) for one in silent} == set(LEGAL), "a pattern is of no use any more"
    assert len(right) >= RIGHT * len(said)
    assert len(once) >= ONCE * len(said)


def everything(folder: Path) -> Iterator[Told]:
    """Yield what is told of every typo of every robot, tried in a process for each core."""
    processes = ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn"))
    with processes:
        pieces = []
        for robot in ROBOTS:
            count = sum(1 for _ in typos(robot))
            for start in range(0, count, PIECE):
                home = folder / f"{robot}-{start}"
                pieces.append(processes.submit(tried, robot, home, range(start, min(start + PIECE, count))))
        for piece in pieces:
            yield from piece.result()

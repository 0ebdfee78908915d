"""What is worked out of a robot stays with that robot, and is not pickled with it."""

from __future__ import annotations

import pickle
from dataclasses import replace

from rosorin_compile.model import Link, Robot
from rosorin_compile.model.cached import of_robot


def test_a_function_of_a_robot_is_worked_out_once_a_robot() -> None:
    asked: list[tuple[str, str]] = []

    @of_robot
    def length(robot: Robot, more: str = "") -> int:
        asked.append((robot.name, more))
        return len(robot.name + more)

    one = Robot("one", (Link("base"),), ())
    other = replace(one, name="other")
    assert [length(one), length(one), length(one, "x"), length(other), length(other)] == [3, 3, 4, 5, 5]
    assert asked == [("one", ""), ("one", "x"), ("other", "")]
    assert one == Robot("one", (Link("base"),), ())
    back = pickle.loads(pickle.dumps(one))  # noqa: S301
    assert back == one
    assert not back.worked_out
    assert one.worked_out

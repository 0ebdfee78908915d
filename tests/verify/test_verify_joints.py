"""verify compares the edges of joints with their joint states, for every kind of joint and at any position."""

import math
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.formats.compilation import CompileResult
from rosorin_compile.model import Pose
from rosorin_compile.recordings.expected_edges import Description, Options
from rosorin_compile.recordings.results import Verification
from rosorin_compile.recordings.verification import verify
from support import bags
from support.bags import Message, ns
from support.paths import DATA, ROOT, data_text
from support.robots import compiled

MANY = data_text("robots/verify_joints_many.yaml")
ROBOTS = [*sorted((ROOT / "examples").glob("*/robot.yaml")), DATA / "stock_nodes" / "corners.yaml"]
STATE = "sensor_msgs/msg/JointState"


def judged(made: CompileResult, folder: Path, said: list[Message]) -> Verification:
    assert made.robot is not None
    bag = bags.write(folder, sorted(said, key=lambda message: message.received))
    return verify(made.robot, made.artifacts, str(bag), Options())


@pytest.mark.parametrize("path", [*ROBOTS, Path("many/joints")], ids=lambda path: path.parent.name)
def test_a_recording_of_any_robot_is_as_described(path: Path, tmp_path: Path) -> None:
    """The description's own values at its own joint states have no finding; with the opposite positions they have."""
    if not path.exists():
        path = tmp_path / "robot.yaml"
        path.write_text(MANY, "utf-8")
    made = compiled(path)
    robot = made.robot
    assert robot is not None
    description = Description(robot, Options())
    names = sorted(description.joint_names)
    published = {(edge.parent, edge.child): edge for edge in description.edges}.values()  # one edge of each pair
    free = Pose((1.0, 2.0, 3.0), (0.1, 0.2, 0.3)).transform()

    def recorded(name: str, sign: float) -> Verification:
        said: list[Message] = []
        for step in range(30):
            at = {joint: 0.02 * step * (number % 5 - 2) + 0.1 for number, joint in enumerate(names)}
            stamp = ns(0.1 * step)
            state = bags.joint_state(stamp, tuple(names), list(at.values()))
            said += [Message(stamp, "/joint_states", STATE, state)] if names else []
            for edge in published:
                value = edge.transform or free
                if edge.joint is not None and edge.joint.moves:
                    value = edge.joint.transform(sign * robot.position(edge.joint, at))
                if edge.moving or step == 0:
                    said.append(bags.edge(stamp, edge.parent, edge.child, value, still=not edge.moving))
        return judged(made, tmp_path / name, said)

    right = recorded("right", 1.0)
    assert [finding for finding in right.findings if finding.rule != "joint-beyond-limit"] == []
    compared = [edge for edge in right.edges if edge.compared]
    assert len(compared) == len({edge.child for edge in description.edges if edge.transform is not None})
    moving = {edge.name for edge in description.edges if edge.joint is not None and edge.joint.moves}
    wrong = {finding.subject for finding in recorded("wrong", -1.0).findings if finding.rule == "edge-wrong-value"}
    assert wrong == moving


WHEELS = data_text("robots/verify_joints_wheels.yaml")


@pytest.mark.parametrize("off", [0.0, 0.3])
def test_a_reported_follower_is_compared_with_its_leader(tmp_path: Path, off: float) -> None:
    """Drivers report wheels between half a turn back and forth: a whole turn is no difference.

    robot_state_publisher uses what is reported of a follower, wherever its leader puts it.
    """
    path = tmp_path / "robot.yaml"
    path.write_text(WHEELS, "utf-8")
    made, said = compiled(path), []
    assert made.robot is not None
    for number, angle in enumerate(np.linspace(0.0, 40.0, 200)):
        angles = {"front": angle, "geared": 0.5 * angle, "rear": -2 * angle + off}
        at = {name: math.remainder(value, math.tau) for name, value in angles.items()}
        stamp = ns(0.02 * number)
        said.append(Message(stamp, "/joint_states", STATE, bags.joint_state(stamp, tuple(at), list(at.values()))))
        joints = [(joint, joint.transform(at[joint.name])) for joint in made.robot.joints]
        said += [bags.edge(stamp, joint.parent, joint.child, value) for joint, value in joints]
    verdict = judged(made, tmp_path / "bag", said)
    assert [(one.rule, one.message) for one in verdict.findings] == [
        (
            "joint-off-its-leader",
            "rear is not -2 times front in 200 of 200 (100 %) messages of /joint_states, by 17.2 deg at most",
        )
    ] * bool(off)
    assert all(edge.by_state == edge.compared == 200 for edge in verdict.edges)

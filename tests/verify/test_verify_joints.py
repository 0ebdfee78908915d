"""What verify expects of a moving edge is what the model gives, for every kind of joint and at any position."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.load_robot import understand
from rosorin_compile.model import Pose, Robot
from rosorin_compile.recordings.arrays import Samples, arrays_of, transform_from
from rosorin_compile.recordings.expected import Description, Options
from rosorin_compile.recordings.joints import TREMBLING, JointLog
from rosorin_compile.recordings.judge import Verdict
from rosorin_compile.recordings.series import Moving, reference
from rosorin_compile.recordings.sources import verify
from rosorin_compile.source.report import text
from support import bags
from support.bags import Message, ns
from support.paths import DATA, ROOT
from support.robots import compiled

ROBOT = """\
robot: many_joints
links: {base: {}, a: {}, b: {}, c: {}, d: {}, e: {}}
joints:
  turn: {type: revolute, parent: base, child: a, xyz: [1, 2, 3], rpy: [0.1, -0.7, 2], axis: [0.6, 0, 0.8],
         limit: {lower: -3, upper: 3, effort: 1, velocity: 1}}
  wheel: {type: continuous, parent: a, child: b, rpy: [1, 2, 3], axis: [0, -1, 0]}
  slide: {type: prismatic, parent: b, child: c, xyz: [0.1, 0, 0], rpy: [0.3, 0, 1], axis: [0, 0.6, -0.8],
          limit: {lower: -1, upper: 1, effort: 1, velocity: 1}}
  follow: {type: revolute, parent: c, child: d, axis: [0, 0, 1], mimic: {joint: turn, multiplier: -2, offset: 0.25},
           limit: {lower: -7, upper: 7, effort: 1, velocity: 1}}
  fixed: {type: fixed, parent: d, child: e, xyz: [0, 0, 1]}
outputs: {urdf: {file: many_joints.urdf}}
"""
CORNERS = DATA / "stock_nodes" / "corners.yaml"
STAMP = np.array([5], np.int64)


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("robot") / "robot.yaml"
    path.write_text(ROBOT, "utf-8")
    _, lowered, diagnostics, *_ = understand(path)
    assert lowered is not None
    assert lowered.robot is not None, text(diagnostics)
    return lowered.robot


ANGLE = st.floats(-3.0, 3.0)


@settings(max_examples=60, deadline=None)
@given(turn=ANGLE, wheel=st.floats(-50.0, 50.0), slide=st.floats(-1.0, 1.0), off=st.floats(1e-4, 0.5))
def test_the_expected_transform_is_that_of_the_model(
    robot: Robot, turn: float, wheel: float, slide: float, off: float
) -> None:
    description = Description(robot, Options())
    log = JointLog(description)
    positions = {"wheel": wheel, "turn": turn, "slide": slide}
    log.add(tuple(positions), STAMP, STAMP, np.array([list(positions.values())]))
    assert description.joint_names == {"turn", "wheel", "slide"}
    for edge in description.edges:
        made = reference(edge)
        if edge.joint is None or not edge.joint.moves:
            continue
        assert isinstance(made, Moving)
        right = edge.joint.transform(robot.position(edge.joint, positions))
        xyz, quaternion = arrays_of(right)
        sample = Samples(STAMP, STAMP, xyz[None], quaternion[None])
        deviation, found = made.deviation(sample, log)
        assert found.all()
        assert not deviation.wrong.any(), edge.name
        alone, _ = made.deviation(sample, JointLog(description))
        assert not alone.wrong.any(), f"{edge.name}: a position gives this transform, and none is found"
        moved = sample._replace(xyz=sample.xyz + np.array([0.0, 0.0, off]))
        assert made.deviation(moved, log)[0].wrong.all()
        back = transform_from(xyz, quaternion)
        assert np.allclose(back.rows, right.rows, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(turn=ANGLE, follow=ANGLE)
def test_a_follower_that_is_reported_is_where_it_is_reported(robot: Robot, turn: float, follow: float) -> None:
    description = Description(robot, Options())
    log = JointLog(description)
    log.add(("turn", "follow"), STAMP, STAMP, np.array([[turn, follow]]))
    (edge,) = (edge for edge in description.edges if edge.child == "d")
    assert edge.joint is not None
    made = reference(edge)
    assert isinstance(made, Moving)
    for position, is_right in ((follow, True), (-2 * turn + 0.25, False)):
        xyz, quaternion = arrays_of(edge.joint.transform(position))
        deviation, known = made.deviation(Samples(STAMP, STAMP, xyz[None], quaternion[None]), log)
        assert known.all()
        apart = abs(math.remainder(follow - position, math.tau))
        if is_right or apart > 1e-4:
            assert deviation.wrong.any() == (not is_right)
    off = abs(follow + 2 * turn - 0.25)
    assert (log.followers["follow"].off, log.followers["follow"].seen) == (int(off > TREMBLING), 1)
    assert log.followers["follow"].farthest == pytest.approx(off)


EXAMPLES = sorted((ROOT / "examples").glob("*/robot.yaml"))


@pytest.mark.parametrize("path", [*EXAMPLES, CORNERS], ids=lambda path: path.parent.name)
def test_a_recording_of_any_robot_is_as_described(path: Path, tmp_path: Path) -> None:
    """What a robot's own description says, at joint states of its own, has no finding; turned the other way it has."""
    made = compiled(path)
    assert made.robot is not None
    description = Description(made.robot, Options())
    names = sorted(description.joint_names)
    published = {(edge.parent, edge.child): edge for edge in description.edges}.values()  # of turns one
    free = {edge.name: Pose((1.0, 2.0, 3.0), (0.1, 0.2, 0.3)).transform() for edge in description.edges}

    def recorded(name: str, change: float) -> Verdict:
        said: list[Message] = []
        for step in range(30):
            at = {joint: 0.02 * step * (number % 5 - 2) + 0.1 for number, joint in enumerate(names)}
            stamp = ns(0.1 * step)
            state = bags.joint_state(stamp, tuple(names), list(at.values()))
            said += [Message(stamp, "/joint_states", "sensor_msgs/msg/JointState", state)] if names else []
            for edge in published:
                value = free[edge.name]
                if edge.joint is not None and edge.joint.moves:
                    value = edge.joint.transform(change * made.robot.position(edge.joint, at))
                elif edge.transform is not None:
                    value = edge.transform
                if edge.moving or step == 0:
                    said.append(bags.edge(stamp, edge.parent, edge.child, value, still=not edge.moving))
        bag = bags.write(tmp_path / name, sorted(said, key=lambda message: message.received))
        return verify(made.robot, made.artifacts, str(bag), Options())

    right = recorded("right", 1.0)
    assert [finding for finding in right.findings if finding.rule != "joint-beyond-limit"] == []
    compared = [series for series in right.recording.series.values() if series.values.compared]
    assert len(compared) == sum(edge.transform is not None for edge in description.edges)
    moving = {edge.name for edge in description.edges if edge.joint is not None and edge.joint.moves}
    wrong = {finding.of[0] for finding in recorded("wrong", -1.0).findings if finding.rule == "edge-wrong-value"}
    assert wrong == moving

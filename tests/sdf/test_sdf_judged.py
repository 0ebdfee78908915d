"""SDF, judged by who reads it: Drake, which refuses what it does not know, and libsdformat, the reader of Gazebo."""

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Ellipsoid, Joint, Link, Output, Pose, Robot, Shape
from rosorin_compile.model.link import along_link
from rosorin_compile.sdf.content import content_of
from support import in_drake, sdformat
from support.engines import pose
from support.machines import BODY, TESTER, chain, machine, robot_of
from support.paths import ROOT, ROSORIN
from support.robots import compiled

pytestmark = pytest.mark.slow

EXAMPLES = sorted((ROOT / "examples").glob("*/robot.yaml"))
ROBOTS = (ROSORIN, *EXAMPLES)
SEEDS = range(12)
STATES = 200
TOLERANCE = 1e-9
SHORT = 1.1e-12  # relative; what printing may cost a number


def written(robot: Robot, folder: Path, **options) -> Path:
    path = folder / "robot.sdf"
    path.write_text(FORMATS["sdf"].compile(robot, Output("sdf", "sdf", "robot.sdf", options), Templates())[0], "utf-8")
    return path


def without_meshes(robot: Robot) -> Robot:
    links = tuple(
        replace(link, visual=tuple(s for s in link.visual if hasattr(s.geometry, "radius"))) for link in robot.links
    )
    return replace(robot, links=links)


def random_robot(seed: int) -> Robot:
    return robot_of(random.Random(seed))  # noqa: S311 - a case, no secret


def states_of(robot: Robot, count: int, seed: int) -> list[dict[str, float]]:
    """Return joint states; those who follow are where their leader puts them."""
    chance = random.Random(seed)  # noqa: S311 - a case, no secret
    made = []
    for _ in range(count):
        lead = {joint.name: chance.uniform(-3, 3) for joint in robot.joints if joint.moves}
        made.append({name: robot.position(robot.joint[name], lead) for name in lead})
    return made


def judged(robot: Robot, folder: Path, count: int = STATES, seed: int = 7, **options) -> None:
    states = states_of(robot, count, seed)
    found = in_drake.ask(written(robot, folder, **options), robot.root, states)
    for state, frames in zip(states, found["frames"], strict=True):
        lead = {name: value for name, value in state.items() if robot.joint[name].mimic is None}
        for name, place in robot.poses_in_root(lead).items():
            ours = np.eye(4)
            ours[:3, :3], ours[:3, 3] = place.rows, place.xyz
            np.testing.assert_allclose(frames[name], ours, atol=TOLERANCE, err_msg=name)
    bodies = content_of(robot).inertials
    assert set(found["masses"]) == set(bodies)
    for name, inertial in bodies.items():
        assert found["masses"][name] == pytest.approx(inertial.mass, rel=SHORT, abs=0)
        about, centre = found["inertias"][name]
        i = inertial
        xx, yy, zz, xy, xz, yz = along_link((i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz), i.pose.transform())
        np.testing.assert_allclose(about, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], atol=1e-12)
        np.testing.assert_allclose(centre, i.pose.xyz, atol=1e-12)
    for joint in robot.joints:
        if joint.moves:
            kind, lower, upper = found["joints"][joint.name]
            assert kind == ("prismatic" if joint.type == "prismatic" else "revolute")
            if joint.limit and joint.type != "continuous":
                assert lower == pytest.approx([joint.limit.lower], rel=SHORT, abs=0)
                assert upper == pytest.approx([joint.limit.upper], rel=SHORT, abs=0)
            elif joint.type == "continuous":
                assert (lower, upper) == ([-np.inf], [np.inf])


@pytest.fixture(autouse=True)
def _judges():
    in_drake.need()


@pytest.mark.landing("engines", "machine", "massless root")
@pytest.mark.parametrize("robot", [machine(), without_meshes(TESTER), chain(child=None), chain(child=BODY, root=None)],
                         ids=["machine", "tester", "massless link between", "massless root"])  # fmt: skip
def test_drake_sees_the_same_robot(robot, tmp_path):
    judged(robot, tmp_path)


@pytest.mark.landing("engines", "6")
@pytest.mark.parametrize("seed", SEEDS)
def test_drake_sees_the_same_random_robot(seed, tmp_path):
    judged(random_robot(seed), tmp_path, seed=seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_libsdformat_reads_a_random_robot(seed, tmp_path):
    sdformat.need()
    robot = random_robot(seed)
    # It knows nothing after 1.9, and drops what says who follows whom without a word.
    assert sdformat.said_of(written(robot, tmp_path, version="1.9")) == ""


def test_a_robot_that_stands_in_the_world(tmp_path):
    """A root called world is the world: what is fixed to it cannot fall."""
    links = (Link("world"), Link("base", BODY), Link("arm", BODY))
    joints = (
        Joint("hold", "fixed", "world", "base", Pose((0.1, 0.2, 0.3), (0.1, 0.2, 0.3))),
        Joint("turn", "continuous", "base", "arm", Pose((0, 0, 1))),
    )
    robot = Robot("held", links, joints)
    path = written(robot, tmp_path)
    found = in_drake.ask(path, "world", [{"turn": 0.5}])
    arm = np.array(found["frames"][0]["arm"])
    ours = robot.pose_in_root("arm", {"turn": 0.5})
    np.testing.assert_allclose(arm[:3, 3], ours.xyz, atol=TOLERANCE)
    np.testing.assert_allclose(arm[:3, :3], ours.rows, atol=TOLERANCE)
    assert not any("floating" in kind for kind, _, _ in found["joints"].values())
    sdformat.need()
    assert sdformat.said_of(path) == ""


def test_balls_and_ellipsoids(tmp_path):
    links = (Link("base", BODY), Link("arm", BODY, collision=(Shape(Ellipsoid((0.1, 0.2, 0.3))),)))
    robot = Robot("ball", links, (Joint("ball", "ball", "base", "arm", Pose((0, 0, 1), (0.1, 0.2, 0.3))),))
    found = in_drake.ask(written(robot, tmp_path), "base")
    np.testing.assert_allclose(found["frames"][0]["arm"], pose((0, 0, 1), (0.1, 0.2, 0.3)), atol=TOLERANCE)
    assert found["joints"]["ball"][0] == "ball_rpy"


def test_what_drake_refuses_is_refused(tmp_path):
    """The judge can say no: an element that SDF does not have."""
    path = written(chain(child=BODY), tmp_path)
    path.write_text(path.read_text().replace("<mass>", "<colour/><mass>", 1))
    with pytest.raises(in_drake.Refused, match="colour"):
        in_drake.ask(path, "root")


@pytest.mark.landing("engines", EXAMPLES[0].parent.name)
@pytest.mark.parametrize("robot", ROBOTS, ids=lambda path: path.parent.name)
def test_the_reference_robot_and_the_examples(robot, tmp_path):
    """None of them asks for an SDF: what it would be is judged all the same."""
    compiled_robot = compiled(robot).robot
    assert compiled_robot is not None
    judged(compiled_robot, tmp_path, gazebo=False)
    judged(compiled_robot, tmp_path, 3)
    sdformat.need()
    assert sdformat.said_of(written(compiled_robot, tmp_path, version="1.9")) == ""

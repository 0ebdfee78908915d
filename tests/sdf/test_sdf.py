"""The text of an SDF: its version, the order of its frames, sensors, and what a description keeps for Gazebo."""

import re
from dataclasses import replace
from pathlib import Path

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Joint, Link, Output, Pose, Robot
from rosorin_compile.model.joint import Mimic
from rosorin_compile.model.simulation import Root
from support.machines import BODY, chain
from support.paths import data_text
from support.reading import leaves_of
from support.robots import compiled_text, sound

SENSING = data_text("robots/sdf_sensing.yaml")


def written(robot: Robot, **options) -> str:
    return FORMATS["sdf"].compile(robot, Output("sdf", "sdf", "robot.sdf", options), Templates())[0]


def test_the_version_is_the_first_that_says_all():
    robot = chain(child=BODY)
    assert '<sdf version="1.9">' in written(robot)
    follower = replace(robot.joint["bend"], mimic=Mimic("turn"))
    followed = replace(robot, joints=(*robot.joints[:2], follower))
    assert '<sdf version="1.11">' in written(followed)
    for said, meant in (("1.9", "1.9"), (1.1, "1.10"), (1.12, "1.12")):
        assert f'<sdf version="{meant}">' in written(followed, version=said)


def test_a_frame_stands_after_what_it_is_attached_to():
    """Drake 1.51 takes the pose of one that stands before for another."""
    links = (Link("tip"), Link("wrist"), Link("base", BODY))
    joints = (Joint("a", "fixed", "base", "wrist", Pose((0, 0, 1))), Joint("b", "fixed", "wrist", "tip"))
    assert re.findall(r'<(?:link|frame) name="(\w+)"', written(Robot("r", links, joints))) == ["base", "wrist", "tip"]


def test_the_model_stands_where_the_root_does():
    robot = chain(child=BODY)
    placed = Root(Pose((1.0, 2.0, 3.0)), placed=True)
    assert "<pose>1 2 3 0 0 0</pose>\n    <link" in written(replace(robot, root_in_world=placed))
    assert "<pose>1 2 3" not in written(robot)


def test_sensors_and_what_is_kept_for_gazebo(tmp_path: Path):
    robot, artifacts, compiled = sound(compiled_text(tmp_path, SENSING))
    text = artifacts["sdf"]
    assert '<sensor name="lidar" type="gpu_lidar">\n        <pose relative_to="laser"/>' in text
    assert '<sensor name="imu" type="imu">' in text
    assert "gz_frame_id" not in text
    assert '    <plugin name="drive" filename="drive.so"><x>1</x></plugin>' in text
    assert '<light name="lamp" type="point"><pose relative_to="mast">0 0 1 0 0 0</pose></light>' in text
    assert "<self_collide>1</self_collide>" in text
    assert "    <frame_of_others/>" in text
    assert "mu1" not in text
    (told,) = [one.message for one in compiled.diagnostics if one.rule == "not-in-format"]
    assert told == "SDF cannot express <mu1> of base_link: only readers of URDF know it"
    assert "<gz_frame_id>laser</gz_frame_id>" in written(robot, gazebo=True)
    assert "<ignition_frame_id>laser</ignition_frame_id>" in written(robot, gazebo="fortress")
    assert "<frame_id>laser</frame_id>" in written(robot, version="1.12")
    assert "<sensor" not in written(robot, gazebo=False)


def test_a_shape_of_its_own_kind_is_a_fact():
    """A plane that is kept is no shape of the robot, and a change of it is seen."""
    link = Link("base", BODY, urdf_elements=(f"<sdf>{PLANE}</sdf>",))
    texts = (link.urdf_elements[0], link.urdf_elements[0].replace("0 0 1", "0 1 0"))
    one, other = (leaves_of("sdf", written(Robot("r", (replace(link, urdf_elements=(t,)),), ()))) for t in texts)
    assert len([address for address in one if one[address] != other.get(address)]) == 1


PLANE = '<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>'


OF_CLASSIC = data_text("robots/sdf_of_classic.yaml")


def test_words_of_gazebo_classic_become_those_of_sdf(tmp_path: Path):
    """As libsdformat 12 makes them of a URDF: the last one holds, for each collision; the noise of an IMU by axis."""
    compiled = compiled_text(tmp_path, OF_CLASSIC)
    (text,) = [artifact.text for artifact in compiled.artifacts if artifact.backend == "sdf"]
    base, foot = (re.findall(rf'<collision name="{link}_.*?</collision>', text, re.DOTALL) for link in ("base", "foot"))
    friction = "<friction><ode><mu>0.5</mu><mu2>0.6</mu2><fdir1>1 0 0</fdir1></ode></friction>"
    contact = "<contact><ode><kp>1e6</kp><min_depth>0.001</min_depth></ode></contact>"
    for one in base:
        assert f"<surface>{friction}{contact}</surface>" in one
        assert "<max_contacts>4</max_contacts>" in one
    assert len(base) == 2
    assert "<laser_retro>2</laser_retro>" in foot[0]
    assert foot[0].count("<surface>") == 1
    assert "<mu>" not in foot[0]  # its own surface holds
    for name in ("words", "kept"):
        sensor = text.partition(f'<sensor name="{name}"')[2].partition("</sensor>")[0]
        assert "<rate>" not in sensor
        for what, stddev in (("angular_velocity", "0.1"), ("linear_acceleration", "0.2")):
            inner = sensor.partition(f"<{what}>")[2].partition(f"</{what}>")[0]
            assert len(re.findall(f'<noise type="gaussian">.*?<stddev>{stddev}</stddev></noise>', inner)) == 3
    (told,) = [one.message for one in compiled.diagnostics if one.rule == "not-in-format"]
    assert told == "SDF cannot express <kd> of base, <mu1> of mark: only readers of URDF know it"


LOSSES = """
robot: r
links: {base_link: {}, arm: {collision: [{sphere: {radius: 0.1}, contact: {contype: 0}}], inertial: {mass: 1, of: collision}}}
joints: {turn: {type: continuous, parent: base_link, child: arm, limit: {effort: 1, velocity: 1}, dynamics: {stiffness: 3}}}
outputs: {a: {backend: urdf, file: a.urdf}, b: {backend: urdf, file: b.urdf, gazebo: harmonic}}
"""  # noqa: E501


def test_a_loss_of_one_artifact_is_told_and_a_zero_is_no_missing_value(tmp_path: Path):
    compiled = compiled_text(tmp_path, LOSSES)
    told = [one.message for one in compiled.diagnostics if one.rule == "not-in-format"]
    assert [text.partition(" (")[0] for text in told] == [
        "URDF cannot express links.collision.contact.contype",
        "a.urdf cannot express joints.dynamics.stiffness",
    ]


LOOP = """
robot: r
links: {base: {}, a: {inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}, b: {inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}}
joints:
  j: {type: continuous, parent: base, child: a, limit: {effort: 1, velocity: 1}}
  k: {type: continuous, parent: base, child: b, xyz: [1, 0, 0], limit: {effort: 1, velocity: 1}}
constraints: {pin: {type: connect, links: [a, b], at: [0.5, 0, 0]}}
outputs: {sdf: {file: r.sdf, gazebo: classic}}
"""  # noqa: E501


def test_a_loop_that_gazebo_closes_is_a_second_joint(tmp_path: Path):
    _, artifacts, _ = sound(compiled_text(tmp_path, LOOP))
    assert '<joint name="pin" type="ball">' in artifacts["sdf"]


def test_a_contact_sensor_in_xml_that_names_a_missing_collision_is_reported(tmp_path: Path):
    sensor = '<sensor name="bumper" type="contact"><contact><collision>{}</collision></contact></sensor>'
    for collision, count in (("front", 0), ("base_fixed_joint_lump__front_collision", 1)):
        text = f"""robot: r
links:
  base:
    collision: [{{name: front, box: {{size: [1, 1, 1]}}}}]
    urdf_elements: ['<sdf>{sensor.format(collision)}</sdf>']
outputs: {{sdf: {{file: r.sdf}}}}"""
        found = [one.message for one in compiled_text(tmp_path, text).diagnostics if one.rule == "gazebo-cannot-see"]
        assert [("bumper" in message, collision in message) for message in found] == [(True, True)] * count

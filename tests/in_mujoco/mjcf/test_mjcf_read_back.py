"""An MJCF of ours is read back without MuJoCo, and nothing in it is lost."""

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.mujoco.mjcf.read_back import read
from support.machines import machine
from support.paths import data_text
from support.reading import leaves_of, line
from support.robots import CHAIN, compiled_text
from support.simulator import emit

EYE = "sensors: {eye: {type: camera, parent: s4, frame: eye}}\noutputs: {mjcf: {file: chain.xml}}\n"


@pytest.mark.parametrize(
    ("which", "old", "new", "told"),
    [
        (0, 'mass="2"', 'mass="3"', "s0 mass"),
        (2, 'diaginertia="0.1 0.1 0.1', 'diaginertia="0.1 0.1 0.2', "s2 inertia"),
        (3, 'size="0.05 0.05 0.1"', 'size="0.05 0.05 0.2"', "s3 collision"),
        (5, 'size="0.1"', 'size="0.2"', "s5 collision"),
        (2, 'pos="0 0 0.2"', 'pos="0 0 0.3"', "s2 moved"),
        (2, '<joint name="j', '<joint axis="1 0 0" name="j', "j2"),
        (3, '<body name="s', '<body name="t', "s3"),
    ],
)
def test_one_of_many_that_are_alike_is_found(tmp_path: Path, which: int, old: str, new: str, told: str) -> None:
    chain = compiled_text(tmp_path, CHAIN + EYE)
    assert chain.robot is not None
    text = chain.artifacts[0].text
    place = -1
    for _ in range(which + 1):
        place = text.find(old, place + 1)
        assert place >= 0
    text = text[:place] + new + text[place + len(old) :]
    found = agreement(chain.robot, [replace(chain.artifacts[0], text=text)])
    assert any(told in one.message for one in found), [one.message for one in found]


TEXTS = ["", "<mujoco>", "<robot/>", "<mujoco/>", '<!DOCTYPE mujoco [<!ENTITY a "b">]><mujoco><worldbody/></mujoco>']
TEXTS += ["<mujoco><worldbody><body/></worldbody></mujoco>"]
TEXTS += ['<mujoco><worldbody><body name="a" pos="0 0"/></worldbody></mujoco>']
TEXTS += ['<mujoco><worldbody><body name="a" pos="0 0 x"/></worldbody></mujoco>']
TEXTS += ['<mujoco><worldbody><body name="a"><inertial mass="nan"/></body></worldbody></mujoco>']
TEXTS += ['<mujoco><worldbody><body name="a"><inertial mass="1_0"/></body></worldbody></mujoco>']
TEXTS += ['<mujoco><worldbody><body name="a"><body name="b" quat="0 0 0 0"/></body></worldbody></mujoco>']
TEXTS += ['<mujoco><worldbody/><keyframe><key name="k" qpos="1"/></keyframe></mujoco>']
TEXTS += ['<mujoco><worldbody/><equality><joint joint1="a" joint2="b"/></equality></mujoco>']
TEXTS += ['<mujoco><worldbody/><actuator><position joint="a" kp="1"/></actuator></mujoco>']
TEXTS += ['<mujoco><worldbody><body name="a"><geom class="x_visual" type="mesh" mesh="m"/></body></worldbody></mujoco>']


@pytest.mark.parametrize("text", TEXTS)
def test_damaged_text_is_a_value_error(text):
    with pytest.raises(ValueError, match=r"."):
        read(text)


def test_cutting_an_artifact_anywhere_is_a_value_error():
    text = emit(machine())
    for end in range(0, len(text.rstrip()) - 1, 37):
        with pytest.raises(ValueError, match=r"."):
            read(text[:end])


OF_A_SIMULATION = data_text("robots/mjcf_read_back.mjcf.xml")


def test_what_a_simulation_has_is_read() -> None:
    found = [line(address, leaf) for address, leaf in leaves_of("mjcf", OF_A_SIMULATION).items()]
    assert sorted(one for one in found if not one.startswith(("frame", "joint turn axis"))) == [
        "actuator push motor gear: 2",
        "actuator push motor joint: turn",
        "constraint shut connect site1: base",
        "constraint shut connect site2: mark",
        "constraint shut connect solref: 0.01 1",
        "contact pair foot tip pair geom1: foot",
        "contact pair foot tip pair geom2: tip",
        "contact pair foot tip pair margin: 0.2",
        "contact pairs with friction contact pairs with friction : arm - base",
        "joint turn child: arm",
        'joint turn mimic joint: ""',
        "joint turn mimic multiplier: 0",
        "joint turn mimic offset: 0.5",
        "joint turn type: continuous",
        "link base base: free",
        "link base site mark size: 0.1",
        "link base site: base",
        "pose home turn: 0.5",
        "pose zero turn: 0",
        "tendon rope 1 joint coef: 2",
        "tendon rope 1 joint joint: turn",
        "tendon rope fixed: fixed",
    ]

"""Two compiled models are the same robot or not: every planted difference is told, and what differs by right is not.

``compared/everything.xml`` has an object of every kind. A difference is planted in its text, where a person would make
it, and in every compared array of its model.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

mujoco = pytest.importorskip("mujoco", minversion="4")

import numpy as np  # noqa: E402

from in_mujoco.mjcf.other_fields import CARED_FOR  # noqa: E402
from rosorin_compile.mujoco.mjcf import compared, compared_fields, moves  # noqa: E402
from rosorin_compile.mujoco.mjcf.matched import Model  # noqa: E402
from support.paths import DATA  # noqa: E402

EVERYTHING = DATA / "mjcf" / "compared" / "everything.xml"
TEXT = EVERYTHING.read_text("utf-8")


def compiled(text: str) -> tuple[Any, Any]:
    """Return the model of a text, and what its <statistic> says."""
    spec = mujoco.MjSpec.from_string(text)
    spec.compiler.fusestatic = spec.compiler.discardvisual = False
    return spec.compile(), spec.stat


def told(one: str, other: str, names: Any = None) -> list[str]:
    """Return what differs between two texts."""
    (source, said), (ours, _) = compiled(one), compiled(other)
    return [f"{feature}: {text}" for feature, text in compared.compare(mujoco, source, ours, names or {}, said)]


def edited(old: str, new: str, text: str = TEXT) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)


def test_a_model_is_itself() -> None:
    assert told(TEXT, TEXT) == []


PLANTED = [
    ('density="1.2"', 'density="1.3"', "options: density 1.2 in the source, 1.3 in ours"),
    ('nuserdata="2"', 'nuserdata="3"', "sizes: nuserdata 2 in the source, 3 in ours"),
    ('ambient="0.3 0.3 0.3"', "", "settings of the viewer: ambient 0.3 0.3 0.3 in the source, 0.1 0.1 0.1 in ours"),
    ('extent="3"', 'extent="4"', "settings of the viewer: extent 3 in the source, 4 in ours"),
    ('data="1 2 3"', 'data="1 2 4"', "numbers and texts: number number: data 1 2 3 in the source, 1 2 4 in ours"),
    ("some words", "more words", "numbers and texts: text words: data"),
    (
        'objname="base" prm',
        'objname="arm" prm',
        "numbers and texts: tuple tuple: objid body base in the source, body arm in ours",
    ),
    ('key="kp" value="4"', 'key="kp" value="5"', "plugins: actuator loop: plugin"),
    (
        'rgb1="0.1 0.2 0.3"',
        'rgb1="0.1 0.2 0.4"',
        "textures: texture checker: data differs in 32 of 192 numbers: 76 in the source, 102 in ours",
    ),
    ('reflectance="0.2"', "", "shine: material steel: reflectance 0.2 in the source, 0 in ours"),
    ('texture="checker" refl', 'texture="dots" refl', "textures: material steel: texid none, texture checker"),
    ('mass="2" user="4" material="steel"', 'mass="2" user="4"', "shine: geom hull: has not material steel in ours"),
    ("0.2 0 0  0 0.1 0  0 0 0.1", "0.2 0 0  0 0.1 0  0 0 0.2", "shapes: mesh wedge: vertices differ"),
    ("0 1 2 3 4 5", "0 1 2 3 4 6", "shapes: height field hills: data"),
    ('bindpos="0 0 0"', 'bindpos="0 0 0.1"', "skins: skin_bonebindpos 0 0 0 in the source, 0 0 0.1 in ours"),
    ('pos="0 0 3" dir="0 0 -1"', 'pos="0 0 3" dir="0 1 -1"', "lights: light sun: orientation differs by 0.71"),
    (
        'target="arm" pos',
        'target="base" pos',
        "lights: light lamp: targetbodyid body arm in the source, body base in ours",
    ),
    ('gravcomp="0.1"', "", "gravity compensation: body base: gravcomp 0.1 in the source, 0 in ours"),
    (
        'pos="0 0 1" gravcomp',
        'pos="0 0 2" gravcomp',
        "places of bodies: body base: position 0 0 1 in the source, 0 0 2 in ours",
    ),
    ('quat="0.9 0.1 0.2 0.3"', "", "places of bodies: body arm: orientation differs by"),
    ('user="2">', 'user="3">', "user data: body base: user 2 in the source, 3 in ours"),
    (
        'size="0.1 0.2 0.05"',
        'size="0.1 0.2 0.06"',
        "shapes: geom hull: size 0.1 0.2 0.05 in the source, 0.1 0.2 0.06 in ours",
    ),
    (
        'friction="0.8 0.01 0.001"',
        "",
        "contact: geom hull: friction 0.8 0.01 0.001 in the source, 1 0.005 0.0001 in ours",
    ),
    (
        '<geom name="ball" size="0.04"',
        '<geom name="ball" size="0.04" contype="2"',
        "masks: geom ball: contype 1 in the source, 2 in ours",
    ),
    (
        '<site name="imu" pos="0 0 0.05"',
        '<site name="imu"',
        "sites: site imu: position 0 0 0.05 in the source, 0 0 0 in ours",
    ),
    (
        '<site name="tip" pos="0.2 0 0" size="0.02"/>',
        '<site name="tip" pos="0.2 0 0"/>',
        "looks of sites: site tip: size",
    ),
    ('fovy="50"', "", "cameras: camera eye: fovy 50 in the source, 45 in ours"),
    ('damping="0.1" s', "s", "damping: joint shoulder: damping 0.1 in the source, 0 in ours"),
    ('stiffness="2"', "", "springs: joint shoulder: stiffness 2 in the source, 0 in ours"),
    ('springref="0.2"', "", "springs: joint shoulder: rest of the spring 0.2 in the source, 0 in ours"),
    ('armature="0.01"', "", "armature: joint shoulder: armature 0.01 in the source, 0 in ours"),
    ('frictionloss="0.02"', "", "friction loss: joint shoulder: frictionloss 0.02 in the source, 0 in ours"),
    ('actuatorfrcrange="-5 5"', "", "forces of joints: joint shoulder: actfrclimited 1 in the source, 0 in ours"),
    (
        'range="-1 1" damping',
        'range="-1 2" damping',
        "ranges of joints: joint shoulder: range -1 1 in the source, -1 2 in ours",
    ),
    (
        'axis="0 1 0" range',
        'axis="0 0 1" range',
        "types of joints: joint shoulder: axis 0 1 0 in the source, 0 0 1 in ours",
    ),
    ('pos="0.01 0.02 0"', "", "types of joints: joint spin: anchor 0.01 0.02 0 in the source, 0 0 0 in ours"),
    (
        'type="ball" range="0 1.5"',
        'type="ball" range="0 1.4"',
        "ranges of joints: joint wrist: range 0 1.5 in the source, 0 1.4 in ours",
    ),
    ('mass="1" fullinertia', 'mass="1.5" fullinertia', "masses: body arm: mass 1 in the source, 1.5 in ours"),
    ("0.01 0.02 0.015 0.001", "0.01 0.02 0.015 0.002", "masses: body arm: inertia"),
    (
        '<inertial pos="0.1 0 0"',
        '<inertial pos="0.2 0 0"',
        "masses: body arm: centre of mass 0.1 0 0 in the source, 0.2 0 0 in ours",
    ),
    ('radius="0.01" dim', 'radius="0.02" dim', "flexible bodies: flex_radius 0.01 in the source, 0.02 in ours"),
    ('geom2="cube" friction="0.9', 'geom2="cube" friction="0.7', "contact pairs: pair touch: friction"),
    ('geom1="ball" geom2="cube"', 'geom1="shell" geom2="cube"', "contact pairs: pair touch: geom1"),
    (
        '<exclude name="apart" body1="arm" body2="slider"/>',
        "",
        "touching: body arm and body slider may touch in ours alone",
    ),
    ('coef="2"', 'coef="3"', "tendons: tendon both: prm 2 0.5 in the source, 3 0.5 in ours"),
    ('sidesite="side"', "", "tendons: tendon string: prm"),
    ('springlength="0.1"', "", "tendons: tendon string: lengthspring"),
    ('<site site="hook"/>', '<site site="imu"/>', "tendons: tendon string: objid site hook"),
    ('polycoef="0 1 0 0 0"', 'polycoef="0 2 0 0 0"', "equalities: equality geared: data"),
    (
        'joint1="spin" joint2="rail"',
        'joint1="spin" joint2="shoulder"',
        "equalities: equality geared: obj2id joint rail in the source, joint shoulder in ours",
    ),
    ('solref="0.01 1"', "", "tuning of equalities: equality geared: solref 0.01 1 in the source, 0.02 1 in ours"),
    ('body1="slider" body2="arm" anchor', 'body1="slider" body2="wrist" anchor', "equalities: equality closed: obj2id"),
    ('<weld name="held"', '<weld name="held" torquescale="2"', "equalities: equality held: data"),
    ('kp="10" kv="1"', 'kp="10"', "actuators: actuator servo: biasprm 0 -10 -1"),
    ('forcerange="-3 3"', "", "actuators: actuator servo: forcelimited 1 in the source, 0 in ours"),
    ('gear="3"', 'gear="4"', "actuators: actuator motor: gear 3 0 0 0 0 0 in the source, 4 0 0 0 0 0 in ours"),
    (
        '<motor name="motor" joint="spin"',
        '<motor name="motor" joint="rail"',
        "actuators: actuator motor: trnid joint spin",
    ),
    (
        'refsite="hook"',
        'refsite="tip"',
        "actuators: actuator thrust: trnid site imu, site hook in the source, site imu, site tip in ours",
    ),
    ('actrange="0 1"', 'actrange="0 2"', "actuators: actuator thrust: actrange 0 1 in the source, 0 2 in ours"),
    ('noise="0.01"', "", "sensors: sensor gyro: noise 0.01 in the source, 0 in ours"),
    (
        'objname="tip" reftype',
        'objname="pull" reftype',
        "sensors: sensor seen: objid site tip in the source, site pull in ours",
    ),
    ('<jointpos name="angle" joint="shoulder"/>', "", "sensors: sensor angle: is not in ours"),
    ('mpos="0 0 2"', 'mpos="0 0 3"', "keys: key home: place of body hand_of_god 0 0 2 in the source, 0 0 3 in ours"),
    ('mquat="0 1 0 0"', 'mquat="0 0 1 0"', "keys: key home: orientation of body hand_of_god 0 1 0 0 in the source"),
    ('ctrl="0.2 0', 'ctrl="0.3 0', "keys: key home: control of actuator servo 0.2 in the source, 0.3 in ours"),
    ('act="0.3 0.2"', 'act="0.3 0.1"', "keys: key home: activation of actuator muscle 0.2 in the source, 0.1 in ours"),
    ('name="gyro"', 'name="turning"', "names: sensor gyro: is called turning in ours"),
]


@pytest.mark.parametrize(("old", "new", "message"), PLANTED, ids=lambda value: value[:40])
def test_a_planted_difference_is_told(old: str, new: str, message: str) -> None:
    found = told(TEXT, edited(old, new))
    assert any(text.startswith(message) for text in found), found


def test_motion_capture_is_told() -> None:
    one = '<mujoco><worldbody><body name="b" mocap="true"><geom size="1"/></body></worldbody></mujoco>'
    assert told(one, one.replace('mocap="true"', "")) == [
        "motion capture: body b: motion capture 1 in the source, 0 in ours"
    ]


def test_order_is_told() -> None:
    motor = '    <motor name="winch" tendon="string"/>\n'
    keyless = edited("<keyframe>", "<!--", edited("</keyframe>", "-->"))
    moved = edited('    <plugin name="loop"', f'{motor}    <plugin name="loop"', edited(motor, "", keyless))
    assert told(keyless, moved) == ["order: the actuators stand in another order in ours"]


def test_another_first_key_is_told() -> None:
    more = edited("<keyframe>", '<keyframe><key name="home"/>', edited('name="home"', 'name="own"', ARM))
    assert told(edited('name="home"', 'name="own"', ARM), more) == [
        "order: the keys of the source are not the first ones, in their order"
    ]


def test_what_is_added_is_told() -> None:
    found = told(TEXT, edited('<site name="pull"/>', '<site name="pull"/><geom name="more" size="0.01" mass="0"/>'))
    assert "shapes: geom more is in ours alone" in found
    heavy = '<site name="pull"/><body name="more"><inertial pos="0 0 0" mass="0.1" diaginertia="1 1 1"/></body>'
    assert told(TEXT, edited('<site name="pull"/>', heavy)) == ["bodies: body more is in ours alone"]


ARM = """<mujoco><compiler angle="radian"/><worldbody><body name="base">
<geom name="foot" type="box" size="0.1 0.1 0.1" mass="1"/>
<body name="arm" pos="0 0 0.1" quat="0.8 0 0.6 0">
  <joint name="turn" axis="0 0 1" range="-1 2" ref="0.5" stiffness="3" springref="0.7"/>
  <inertial pos="0.1 0 0" mass="1" diaginertia="0.02 0.02 0.03"/>
  <geom name="box" type="box" size="0.1 0.1 0.1" rgba="1 0 0 1"/><site name="tip" pos="0.1 0.2 0"/>
  <body name="hand" pos="0 0 0.2"><joint name="wrist" type="ball" pos="0 0 0.1"/><geom name="fist" size="0.1"/></body>
</body></body></worldbody>
<equality><weld name="held" body1="base" body2="arm" relpose="0 0 0.2 0.8 0 0.6 0" active="false"/></equality>
<tendon><fixed name="string" range="0 3" stiffness="2" springlength="1"><joint joint="turn" coef="2"/></fixed></tendon>
<actuator><position name="servo" joint="turn" kp="5" ctrlrange="-0.5 1.5"/><motor name="motor" joint="turn"/></actuator>
<keyframe><key name="home" qpos="0.6 1 0 0 0" ctrl="0.8 0.1"/></keyframe></mujoco>"""
FROM_ZERO = (
    ('range="-1 2" ref="0.5" stiffness="3" springref="0.7"', 'range="-1.5 1.5" stiffness="3" springref="0.2"'),
    ('range="0 3"', 'range="-1 2"'),
    ('springlength="1"', 'springlength="0"'),
    ('ctrlrange="-0.5 1.5"', 'ctrlrange="-1 1"'),
    ('qpos="0.6 1 0 0 0" ctrl="0.8 0.1"', 'qpos="0.1 1 0 0 0" ctrl="0.3 0.1"'),
)
BY_RIGHT = {
    "a site more": [('<site name="tip"', '<site name="arm"/><site name="tip"')],
    "a site that became a body": [
        ('<site name="tip" pos="0.1 0.2 0"/>', '<body name="tip" pos="0.1 0.2 0"><site name="tip"/></body>')
    ],
    "the other sign of a quaternion": [('quat="0.8 0 0.6 0"', 'quat="-0.8 0 -0.6 0"'), ("0.6 1 0 0 0", "0.6 -1 0 0 0")],
    "other principal axes": [('mass="1" dia', 'mass="1" quat="1 1 0 0" dia'), ("0.02 0.02 0.03", "0.02 0.03 0.02")],
    "a visual more, and the groups of both": [
        ('size="0.1 0.1 0.1" rgba="1 0 0 1"/>', 'size="0.1 0.1 0.1" group="3"/><geom type="box" size="0.1 0.1 0.1"'
         ' contype="0" conaffinity="0" group="1" rgba="1 0 0 1" mass="0"/>')
    ],
    "a material that is only a colour": [
        ("<worldbody>", '<asset><material name="red" rgba="1 0 0 1"/></asset><worldbody>'),
        ('rgba="1 0 0 1"/><site', 'material="red"/><site'),
    ],
    "an exclude of neighbours, which is implied": [
        ("<tendon>", '<contact><exclude body1="arm" body2="hand"/></contact><tendon>')
    ],
    "the other sign of the quaternion of a weld": [('0.2 0.8 0 0.6 0"', '0.2 -0.8 0 -0.6 0"')],
    "the look of a tendon of joints, which is not drawn": [
        ("<worldbody>", '<default><tendon rgba="1 0 0 1" width="0.2"/></default><worldbody>')
    ],
    "a body more of what MuJoCo calls no mass": [
        ('<site name="tip"', '<body><inertial pos="0 0 0" mass="1e-12" diaginertia="1 1 1"/></body><site name="tip"')
    ],
    "a body without mass between": [
        ('<body name="hand" pos="0 0 0.2">', '<body name="between" pos="0 0 0.1"><body name="hand" pos="0 0 0.1">'),
        ('name="fist" size="0.1"/></body>', 'name="fist" size="0.1"/></body></body>'),
    ],
}  # fmt: skip


SYMMETRIC = {"the other sign of a quaternion", "other principal axes", "a material that is only a colour"}


@pytest.mark.parametrize("what", BY_RIGHT)
def test_what_differs_by_right_is_not_told(what: str) -> None:
    text = ARM
    for old, new in BY_RIGHT[what]:
        text = edited(old, new, text)
    assert told(ARM, text) == []
    if what in SYMMETRIC:
        assert told(text, ARM) == []


@pytest.mark.parametrize("number", range(len(FROM_ZERO)))
def test_a_number_that_is_counted_from_another_zero_is_told(number: int) -> None:
    assert told(ARM, edited(*FROM_ZERO[number], ARM))


def test_a_chain_of_links_is_a_body_with_several_joints() -> None:
    """The anchor of a joint becomes a link; its joints move links without mass."""
    one = """<mujoco><worldbody><body name="base"><geom size="0.1" mass="1"/>
    <body name="arm" pos="0 0 1" euler="0 30 0"><joint name="a" axis="1 0 0"/>
    <joint name="b" axis="0 1 0" pos="0.1 0 0"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></body></worldbody></mujoco>"""
    least = '<inertial pos="0 0 0" mass="1e-15" diaginertia="1e-15 1e-15 1e-15"/>'
    other = f"""<mujoco><worldbody><body name="base"><geom size="0.1" mass="1"/>
    <body name="a_link" pos="0 0 1" euler="0 30 0"><joint name="a" axis="1 0 0"/>{least}
    <body name="b_anchor" pos="0.1 0 0"><joint name="b" axis="0 1 0"/>
    <body name="arm" pos="-0.1 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></body></body></body>
    </worldbody></mujoco>"""
    assert told(one, other) == []
    assert told(one, edited('pos="0.1 0 0"', 'pos="0.2 0 0"', other)) != []


def test_a_mesh_stands_where_its_file_has_it() -> None:
    """MuJoCo puts its origin where the mass of a body of it would be; that depends on what it is taken for."""
    solid = """<mujoco><asset><mesh name="m" inertia="legacy" vertex="0 0 0  1 0 0  0 1 0  0 0 1"
    face="0 2 1  0 1 3  0 3 2  1 2 3"/></asset><worldbody><body name="b"><geom name="g" type="mesh" mesh="m" mass="0"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>"""
    assert told(solid, solid.replace("legacy", "shell")) == []
    assert told(solid, solid.replace('mesh="m" mass="0"', 'mesh="m" mass="0" pos="0 0 0.1"')) == [
        "shapes: geom g: position 0 0 0 in the source, 0 0 0.1 in ours"
    ]


def test_a_mesh_may_be_there_several_times() -> None:
    mesh = '<mesh name="{}" vertex="0 0 0  1 0 0  0 1 0  0 0 1" face="0 2 1  0 1 3  0 3 2  1 2 3"/>'
    geoms = '<geom name="a" type="mesh" mesh="m"/><geom name="b" type="mesh" mesh="{}" pos="2 0 0"/>'
    body = f'<worldbody><body name="body">{geoms}</body></worldbody></mujoco>'
    one = f"<mujoco><asset>{mesh.format('m')}</asset>{body.format('m')}"
    twice = f"<mujoco><asset>{mesh.format('m')}{mesh.format('n')}</asset>{body.format('n')}"
    assert told(one, twice) == []


def test_what_has_no_mass_has_no_centre_of_mass() -> None:
    one = """<mujoco><worldbody><body name="base"><geom size="0.1"/><body name="frame">
    <inertial pos="0 0 0" mass="{}" diaginertia="1 1 1"/></body></body></worldbody></mujoco>"""
    assert told(one.format("1e-12"), one.format("1e-12").replace("0 0 0", "0.1 0 0")) == []
    assert told(one.format("2e-12"), one.format("2e-12").replace("0 0 0", "0.1 0 0")) == [
        "masses: body frame: centre of mass 0 0 0 in the source, 0.1 0 0 in ours"
    ]


def test_the_first_site_is_a_site_like_others() -> None:
    """A tendon goes along a shape at the side of a site, which is the first of the model and the last of the other."""
    side, ends = '<site name="side" pos="0 0.2 0"/>', '<site name="a" pos="1 0 0"/><site name="b" pos="-1 0 0"/>'
    text = f"""<mujoco><worldbody><body name="base"><geom name="ball" size="0.1"/>{side}{ends}</body></worldbody>
    <tendon><spatial><site site="a"/><geom geom="ball" sidesite="side"/><site site="b"/></spatial></tendon></mujoco>"""
    assert told(text, text) == told(text, edited(side + ends, ends + side, text)) == []
    assert told(text, edited(' sidesite="side"', "", text)) == [
        "tendons: tendon 0: prm 0 0 0 in the source, 0 -1 0 in ours"
    ]


def test_a_range_that_does_not_limit_is_not_compared() -> None:
    free = edited('ctrlrange="-0.5 1.5"', "", ARM)
    assert told(ARM, free) == ["actuators: actuator servo: ctrllimited 1 in the source, 0 in ours"]
    assert told(free, ARM) == ["actuators: actuator servo: ctrllimited 0 in the source, 1 in ours"]


def test_how_far_a_key_has_bent_a_spring_is_told() -> None:
    text = edited(
        'springref="0.7"', 'springref="0.7" springyield="0.1"', edited('ctrl="0.8 0.1"', 'plastic="0.05"', ARM)
    )
    assert told(text, text) == []
    assert told(text, edited('plastic="0.05"', 'plastic="0.06"', text)) == [
        "keys: key home: plastic 0.05 in the source, 0.06 in ours"
    ]


def test_a_site_that_is_not_there_is_no_other_one() -> None:
    text = """<mujoco><worldbody><body name="base"><geom name="ball" size="0.1"/>{}<site name="a" pos="1 0 0"/>
    <site name="b" pos="-1 0 0"/>{}</body></worldbody><tendon><spatial><site site="a"/>
    <geom geom="ball" sidesite="{}"/><site site="b"/></spatial></tendon></mujoco>"""
    one = text.format('<site name="side" pos="0 0.2 0"/>', "", "side")
    other = text.format("", '<site name="block" type="box" pos="0 0.2 0"/>', "block")
    assert told(one, other) == [
        "sites: site side: is not in ours",
        "tendons: tendon 0: prm 0 -2 0 in the source, 0 2 0 in ours",
    ]


def test_a_material_that_is_not_there_is_told_where_it_is_more_than_a_colour() -> None:
    text = edited("<worldbody>", '<asset><material name="glossy" shininess="0.9"/></asset><worldbody>', ARM)
    assert told(text, ARM) == ["shine: material glossy: is not in ours"]
    plain = edited(' shininess="0.9"', "", text)
    assert told(plain, ARM) == []
    found = told(plain, edited('<site name="tip" pos="0.1 0.2 0"/>', "", plain))
    assert found == ["sites: site tip: is not in ours"]  # the first one of its kind, as the material


def test_the_degrees_of_one_joint_are_not_those_of_the_next() -> None:
    assert told(TEXT, edited('ref="0.05"', 'ref="0.05" damping="0.3"')) == [
        "damping: joint rail: damping 0 in the source, 0.3 in ours"
    ]


def test_where_a_key_has_a_joint_is_told() -> None:
    assert told(ARM, edited('qpos="0.6', 'qpos="0.7', ARM)) == [
        "keys: key home: position of joint turn 0.6 in the source, 0.7 in ours"
    ]
    fast = edited('ctrl="0.8 0.1"', 'qvel="0.1 0 0 0.2" ctrl="0.8 0.1"', ARM)
    assert told(fast, edited('qvel="0.1 0 0 0.2"', 'qvel="0.1 0 0 0.3"', fast)) == [
        "keys: key home: speed of joint wrist 0 0 0.2 in the source, 0 0 0.3 in ours"
    ]


def test_a_hull_of_fewer_vertices_is_told() -> None:
    corners = " ".join(f"{x} {y} {z}" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    text = f"""<mujoco><asset><mesh name="m" vertex="{corners}" maxhullvert="8"/></asset><worldbody><body name="b">
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom name="g" type="mesh" mesh="m"/></body></worldbody>
    </mujoco>"""
    assert told(text, text) == []
    assert "shapes: mesh m: vertices of the hull 8 in the source, 5 in ours" in told(
        text, edited('vert="8"', 'vert="5"', text)
    )


def test_names_that_the_import_gave_are_no_difference() -> None:
    nameless = ARM.replace('name="hand" ', "").replace('name="wrist" ', "")
    renamed = ARM.replace('"hand"', '"arm_body"').replace('"wrist"', '"arm_body_joint"')
    assert told(nameless, renamed) == []
    assert told(ARM, renamed) == [
        "names: body hand: is called arm_body in ours",
        "names: joint wrist: is called arm_body_joint in ours",
    ]
    assert told(ARM, renamed, {"body": {3: "arm_body"}, "joint": {1: "arm_body_joint"}}) == []


DRAWN = {"tendon_rgba", "tendon_width"}  # of tendons through sites: one of joints is not drawn


def _arrays() -> list[tuple[str, bool]]:
    """Return the arrays that are compared as they are, and whether each row of them counts."""
    made = []
    for kind in compared_fields.KINDS.values():
        for fields in kind.fields.values():
            made += [
                (f"{kind.prefix}_{word}", f"{kind.prefix}_{word}" not in compared_fields.GATES)
                for word in fields.split()
            ]
    made = [(field, each and field not in DRAWN) for field, each in made]
    made += [(f"dof_{word}", True) for words in compared_fields.OF_DOFS.values() for word in words.split()]
    made += [(field, False) for field in compared_fields.REFERENCES]
    made += [(field, True) for words in compared_fields.WHOLE.values() for field in words.split()]
    words = " ".join(CARED_FOR).split()
    made += [(word, False) for word in words if not word.startswith("name") and not word.startswith("n")]
    return made


@pytest.fixture(autouse=True)
def _no_log() -> Any:
    """Keep MuJoCo from writing its warnings into a file."""
    mujoco.set_mju_user_warning(lambda _: None)
    yield
    mujoco.set_mju_user_warning(None)


@pytest.fixture(name="everything", scope="module")
def _everything() -> Any:
    return compiled(TEXT)[0]


# Arrays that cannot be changed alone: what tells them is the text, above.
NOT_ALONE = {
    "plugin_attradr": "an address",
    "body_parentid": "MuJoCo's own functions need a tree",
    "text_data": "MuJoCo gives it as bytes",
    "wrap_type": "says of what kind the next number is",
    "tendon_adr": "an address",
    "tendon_num": "a count",
    "mesh_graphadr": "an address",
    "actuator_ctrladr": "an address: test_order_is_told",
    "sensor_adr": "an address",
    "jnt_qposadr": "an address",
    "dof_jntid": "the joint says where its degrees begin",
    "actuator_ctrlnum": "a count",
    "actuator_outnum": "a count",
    "actuator_actnum": "a count",
}


@pytest.mark.slow
@pytest.mark.parametrize(("field", "each"), _arrays(), ids=lambda value: str(value))
def test_a_difference_in_any_array_is_told(everything: Any, field: str, each: bool) -> None:
    if field in NOT_ALONE:
        assert NOT_ALONE[field]
        return
    array = getattr(everything, field)
    data = np.asarray(array if not isinstance(array, bytes) else np.frombuffer(array, np.uint8))
    rows = range(len(data)) if not each else {0, len(data) - 1} if data.size else ()
    if field in ("tendon_width", "tendon_rgba"):  # a tendon of joints is not drawn
        rows = [row for row in rows if everything.wrap_type[everything.tendon_adr[row]] != compared.JOINED]
        assert rows
    seen = False
    for row in rows:
        for planted in _planted(everything, field, row):
            seen = compared.compare(mujoco, everything, planted, {}) != []
            assert seen or not each, (field, row)
        if seen:
            break
    assert seen or not data.size, field


def _planted(model: Any, field: str, row: int) -> Iterator[Any]:
    """Yield copies of a model with one number of an array changed: the first and the last of a row."""
    shape = getattr(model, field).shape if not isinstance(getattr(model, field), bytes) else ()
    for column in {0, shape[1] - 1} if len(shape) > 1 and shape[1] else {None}:
        made = copy.copy(model)
        array = getattr(made, field)
        if isinstance(array, bytes):
            return
        at = row if column is None else (row, column)
        kind = array.dtype.kind
        if kind == "b":
            array[at] = not array[at]
        elif field.endswith("id") and kind == "i" and array[at] > 0:
            array[at] -= 1
        elif kind in "iu":
            array[at] += 1
        else:
            array[at] = array[at] * 1.5 + 0.125
        yield made


def _moved(one: str, other: str) -> Any:
    (source, _), (ours, _) = compiled(one), compiled(other)
    comparison = compared.Comparison(Model(mujoco, source), Model(mujoco, ours), {})
    comparison.run()
    return moves.run(mujoco, comparison)


def test_a_model_moves_as_itself() -> None:
    found = _moved(TEXT, TEXT)
    assert (found.verdict, found.largest, found.steps) == ("same", 0.0, 250)
    assert found.contacts > 0


def test_another_motion_is_told() -> None:
    found = _moved(ARM, edited('kp="5"', 'kp="5.5"', ARM))
    assert found.verdict == "differs"
    assert found.largest > 1e3 * found.itself
    assert found.body in ("body arm", "body hand")


PILE = "".join(
    f'<body name="b{n}" pos="{0.01 * (n % 4)} {0.013 * (n % 3)} {0.2 + 0.11 * n}" euler="{10 * n} {20 * n} 0">'
    f'<freejoint/><geom type="box" size="0.05 0.02 0.05"/></body>'
    for n in range(12)
)
CHAOS = f'<mujoco><option gravity="0 0 -9.81"/><worldbody><geom type="plane" size="9 9 1"/>{PILE}</worldbody></mujoco>'


@pytest.mark.slow
def test_chaos_is_judged_by_what_the_source_does_to_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pile of bricks that fall for four seconds, with gravity moved by one unit in the last place."""
    monkeypatch.setattr(moves, "TOLERANCE", 1e-13)
    monkeypatch.setattr(moves, "SECONDS", 4)
    found = _moved(CHAOS, edited("-9.81", "-9.810000000000002", CHAOS))
    assert found.verdict == "chaotic"
    assert found.itself > 1e-13
    assert found.without_contact <= 1e-13
    assert found.contacts > 20


# Three meshes within each other, pushed by servos: where they touch hangs on the last bits, and not on all of them.
STONE = """0.011 -0.018 -0.037 -0.039 0.025 0.033 0.009 0.018 0.003 0.035 0.025 -0.040 0.029 -0.037 0.018 -0.026 0.029
0.003 -0.016 -0.006 -0.038 -0.030 0.014 0.012 0.009 -0.009 0.040 0.038 0.015 0.012 0.015 -0.009 -0.029 0.018
0.002 -0.015"""
STONES = f"""<mujoco><option integrator="implicitfast" cone="elliptic" impratio="100" gravity="0 0 0"/>
<asset><mesh name="stone" vertex="{STONE}"/></asset>
<default><geom type="mesh" mesh="stone" mass="0.1"/><joint damping="1" frictionloss="0.1"/>
<position kp="100" ctrlrange="0 0.5"/></default>
<worldbody><body name="palm"><geom mass="1"/>
<body name="one" pos="0.013 0.01 0"><joint name="one" axis="0 0 1"/><geom/>
<body name="tip" pos="0.02 0.003 0.001"><joint name="tip" axis="0 0 -1"/><geom/></body></body>
<body name="two" pos="0.012 -0.01 0"><joint name="two" axis="0 0 -1"/><geom/></body></body></worldbody>
<actuator><position joint="one"/><position joint="tip"/><position joint="two"/></actuator></mujoco>"""


def test_what_few_of_the_last_bits_decide_is_chaos() -> None:
    found = _moved(STONES, edited("0.012 -0.01 0", "0.01199999999999 -0.01 0", STONES))
    assert found.verdict == "chaotic"
    assert found.largest > moves.TOLERANCE
    assert found.without_contact <= moves.TOLERANCE


def test_a_difference_is_not_taken_for_chaos() -> None:
    found = _moved(CHAOS, edited("-9.81", "-9.8", CHAOS))
    assert found.verdict == "differs"


def test_a_source_that_falls_apart_says_so() -> None:
    wild = ARM.replace('kp="5"', 'kp="1e14"').replace("<worldbody>", '<option integrator="Euler"/><worldbody>', 1)
    found = _moved(wild, wild.replace('kp="1e14"', 'kp="1.1e14"'))
    assert found.verdict == "unstable"


def test_the_corners_are_themselves() -> None:
    for path in sorted(Path(DATA, "mjcf", "corners").glob("*.xml")):
        model = mujoco.MjModel.from_xml_path(str(path))
        assert compared.compare(mujoco, model, copy.copy(model), {}) == []


@pytest.mark.filterwarnings("ignore:compiler attribute")
@pytest.mark.parametrize("path", sorted(Path(DATA, "mjcf", "public").glob("*.xml")), ids=lambda path: path.stem)
def test_what_mujoco_saves_is_the_same(path: Path) -> None:
    """The same robot in other words: MuJoCo writes it anew, with its own defaults, frames and order of attributes."""
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compile()
    spec.compiler.savecompiled = False
    text = spec.to_xml()
    assert text != path.read_text("utf-8")
    assert told(path.read_text("utf-8"), text) == []
    assert _moved(path.read_text("utf-8"), text).verdict == "same"

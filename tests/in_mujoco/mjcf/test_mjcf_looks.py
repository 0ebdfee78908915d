"""What people expect of an MJCF: classes, groups, materials and a key home; to MuJoCo the robot is the same."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.model import Shape  # noqa: E402
from rosorin_compile.model.shape import Material  # noqa: E402
from rosorin_compile.mujoco.mjcf.compare_models import Comparison  # noqa: E402
from support.machines import machine, overlapping  # noqa: E402
from support.paths import data_text  # noqa: E402
from support.robots import compiled_text, sound  # noqa: E402
from support.simulator import emit, load  # noqa: E402

ARMS = data_text("robots/mjcf_looks_arms.yaml")
OUTPUT = "outputs: {mjcf: {file: pair.xml}}\n"


def pair(folder: Path, more: str = OUTPUT) -> str:
    folder.mkdir(exist_ok=True)
    _, artifacts, _ = sound(compiled_text(folder, ARMS + more))
    return artifacts["mjcf"]


def test_joints_that_move_alike_share_a_class_with_their_actuators(tmp_path: Path) -> None:
    text = pair(tmp_path)
    classes = re.findall(r'<default class="pair_(\w+)">\n        <joint', text)
    assert classes == ["hip", "knee"]
    assert '<joint name="left_knee_joint" class="pair_knee"/>' in text
    assert '<position name="right_hip_joint" class="pair_hip" joint="right_hip_joint"/>' in text
    model, _ = load(text)
    for name in ("left_hip_joint", "right_hip_joint", "left_knee_joint", "right_knee_joint"):
        joint, servo = model.joint(name), model.actuator(name)
        ends = [-1, 1] if "hip" in name else [0.5, 2.5]
        assert joint.range.tolist() == servo.ctrlrange.tolist() == ends
        assert (joint.damping[0], joint.armature[0]) == (0.25, 0.0125)
        assert model.jnt_actfrcrange[joint.id].tolist() == [-20, 20]
        assert servo.gainprm[0] == 125
        assert servo.biasprm[:3].tolist() == [0, -125, -1.5]


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_collision_shapes_that_are_seen_change_nothing_that_moves(base: str) -> None:
    (seen, _), (bare, _) = (load(emit(machine(), base, visuals=one)) for one in ("from_collision", "own"))
    assert Comparison(mujoco, bare, seen, {}).run() == []
    assert seen.ngeom == bare.ngeom
    assert set(seen.geom_group) == {2}
    assert set(bare.geom_group) == {0}


def test_each_link_that_is_only_solid_is_seen_in_a_colour_of_its_own() -> None:
    model, _ = load(emit(overlapping()))
    looks: dict[int, set[int]] = {}
    for geom in map(model.geom, range(model.ngeom)):
        if geom.group[0] == 2:
            looks.setdefault(geom.bodyid[0], set()).add(geom.matid[0])
    assert all(len(materials) == 1 for materials in looks.values())
    assert len(set.union(*looks.values())) == len(looks) == 5


def test_materials_are_assets_and_a_colour_of_a_visual_stays_its_own() -> None:
    robot = overlapping()
    solid = robot.links[0].collision[0].geometry
    shapes = (Shape(solid, material="steel"), Shape(solid, material="steel", rgba=(1, 0, 0, 1)), Shape(solid))
    materials = (Material("steel", (0.25, 0.5, 0.75, 1), mjcf={"specular": 0.9, "reflectance": 0.125}),)
    robot = replace(robot, materials=materials, links=(replace(robot.links[0], visual=shapes), *robot.links[1:]))
    model, _ = load(emit(robot))
    steel = model.material(f"{robot.name}_steel")
    assert (steel.rgba.tolist(), steel.reflectance[0]) == ([0.25, 0.5, 0.75, 1], 0.125)
    geoms = [model.geom(f"{robot.links[0].name}_visual_{number}") for number in (1, 2, 3)]
    assert [geom.matid[0] for geom in geoms] == [steel.id, steel.id, -1]
    assert geoms[1].rgba.tolist() == [1, 0, 0, 1]


def test_a_class_that_is_kept_verbatim_keeps_its_name() -> None:
    robot = machine()
    kept = '<default><default class="machine"><geom group="5"/></default></default>'
    text = emit(replace(robot, mjcf=(kept,)))
    assert '<default class="machine_">' in text
    load(text)


def test_home_is_the_first_key_and_within_limits(tmp_path: Path) -> None:
    model, _ = load(pair(tmp_path))
    assert model.key(0).name == "home"
    assert model.key(0).qpos.tolist() == model.key(0).ctrl.tolist() == [0, 0.5] * 4
    said = "poses: {up: {positions: {left_hip_joint: 1}}, home: {positions: {left_knee_joint: 2}}}\n"
    model, _ = load(pair(tmp_path, said + OUTPUT))
    assert [model.key(at).name for at in range(model.nkey)] == ["home", "up"]
    assert model.key("home").qpos.tolist() == [0, 2, 0, 0, 0, 0, 0, 0]


def test_a_root_that_the_description_places_stays_there(tmp_path: Path) -> None:
    outputs = "outputs: {mjcf: {file: pair.xml, base: free}}\n"
    for said, height in (("root: {xyz: [0, 0, 0]}\n", 0.0), ("root: {xyz: [1, 0, 2]}\n", 2.0)):
        model, _ = load(pair(tmp_path / f"at_{height}", said + outputs))
        assert model.body("trunk").pos[2] == model.key("home").qpos[2] == height

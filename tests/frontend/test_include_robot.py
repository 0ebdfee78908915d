"""Another one's robot, included as it is: pinocchio, MuJoCo and xacro themselves say where its frames have to be."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.language.expand.included_robots import with_prefix
from rosorin_compile.source.diagnostics import ERROR, Source
from rosorin_compile.source.load import parse_yaml
from rosorin_compile.source.system import pip_install
from rosorin_compile.source.tree import Instance
from support.commands import write_files
from support.engines import pose
from support.paths import DATA
from support.robots import compiled, texts
from support.unrounded import compile_unrounded

pytestmark = pytest.mark.slow

CASES = DATA / "include_robot"
CELL, PACKAGED, SIMULATED = (CASES / "descriptions" / name for name in ("cell", "packaged", "simulated"))
ARM = CELL / "vendor" / "arm.urdf"
STATES = 50
SIDES = {"left": 1, "right": -1}


def frames(urdf: str, positions: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Return the 4x4 pose of every link in the root of a URDF, by pinocchio; continuous joints have cos and sin."""
    import pinocchio as pin

    model = pin.buildModelFromXML(urdf, mimic=True)
    data, q = model.createData(), pin.neutral(model)
    for name, value in positions.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = (np.cos(value), np.sin(value)) if joint.nq == 2 else value
    pin.framesForwardKinematics(model, data, q)
    return {f.name: data.oMf[i].homogeneous for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}


@pytest.mark.parametrize("gap", [0.8, 1.3])
def test_two_arms_and_a_camera_stand_where_pinocchio_has_the_arm(gap):
    urdf = texts(compiled(CELL / "robot.yaml", {"gap": str(gap)}))["cell.urdf"]
    foreign = ARM.read_text("utf-8")
    random = np.random.default_rng(4)
    largest = 0.0
    for _ in range(STATES):
        states = {side: dict(zip(("shoulder", "elbow"), random.uniform(-2, 2, 2), strict=True)) for side in SIDES}
        found = frames(urdf, {f"{side}_{name}": at for side in SIDES for name, at in states[side].items()})
        for side, sign in SIDES.items():
            mount = pose([0.1, sign * gap / 2, 0.72], [0, 0, sign * np.radians(30)])
            arm = frames(foreign, states[side])
            assert len(arm) == 5
            for link, placed in arm.items():
                largest = max(largest, np.abs(found[f"{side}_{link}"] - mount @ placed).max())
            if side == "left":
                camera = mount @ arm["tool0"] @ pose([0, 0, 0.04], [0, 0, 0])
                largest = max(largest, np.abs(found["camera"] - camera).max())
    assert largest < 1e-9


def test_a_xacro_in_a_package_is_expanded_with_arguments(tmp_path):
    """As xacro itself expands it; its folder is found by its name, its values are SI numbers."""
    import xacro

    files = texts(compiled(PACKAGED / "robot.yaml"))
    argument = {"reach": "0.8"}
    macro = (CASES / "ros/arm_description/urdf/arm_macro.xacro").read_text("utf-8")
    (tmp_path / "arm_macro.xacro").write_text(macro, "utf-8")
    text = (CASES / "ros/arm_description/urdf/arm.urdf.xacro").read_text("utf-8")
    (tmp_path / "arm.xacro").write_text(text.replace("$(find arm_description)/urdf/", ""), "utf-8")
    expanded = xacro.process_file(str(tmp_path / "arm.xacro"), mappings=argument).toxml()
    for height in (0.0, 0.2, 0.45):
        alone = frames(expanded, {"lift": height})
        found = frames(files["packaged.urdf"], {"a_lift": height})
        assert np.abs(found["a_tool0"] - alone["tool0"]).max() < 1e-12
    assert "'--child-frame-id', [frame_prefix, 'a_base']" in files["static_tf.launch.py"]
    assert "${not_mine}" in files["packaged.urdf"]  # what stands in another one's file is no expression of ours


def test_the_package_is_found_by_the_environment_of_ros(tmp_path, monkeypatch):
    (tmp_path / "robot.yaml").write_text(
        "robot: r\ninclude: [{file: urdf/arm.urdf.xacro, package: arm_description}]\noutputs: {urdf: {file: r.urdf}}\n"
    )
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(CASES / "ros"))
    by_path = texts(compiled(tmp_path / "robot.yaml"))
    share = tmp_path / "prefix" / "share"
    share.mkdir(parents=True)
    shutil.copytree(CASES / "ros/arm_description", share / "arm_description")
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    assert texts(compiled(tmp_path / "robot.yaml")) == by_path


def test_legs_of_an_mjcf_move_as_mujoco_moves_the_leg():
    import mujoco

    whole = mujoco.MjModel.from_xml_string(texts(compiled(SIMULATED / "robot.yaml"))["robot.xml"])
    leg = mujoco.MjModel.from_xml_path(str(SIMULATED / "leg.xml"))
    random = np.random.default_rng(1)
    for _ in range(STATES):
        states = {side: random.uniform([-1, -2], [1, 0]) for side in SIDES}
        found = _moved(whole, {f"{s}_{n}": q for s in SIDES for n, q in zip(("swing", "knee"), states[s], strict=True)})
        for side, sign in SIDES.items():
            alone = _moved(leg, dict(zip(("swing", "knee"), states[side], strict=True)))
            mount = pose([0, 0.1 * sign, 0.5], [0, 0, 0]) @ np.linalg.inv(alone["hip"])
            for body, placed in alone.items():
                assert np.abs(found[f"{side}_{body}"] - mount @ placed).max() < 1e-9
    keys = {whole.key(index).name: whole.key(index).qpos.tolist() for index in range(whole.nkey)}
    assert keys == {"home": [0] * 4, "left_kneel": [0.5, -1.5, 0, 0], "right_kneel": [0, 0, 0.5, -1.5]}
    names = [whole.body(index).name for index in range(whole.nbody)]
    excluded = {(names[pair >> 16], names[pair & 0xFFFF]) for pair in whole.exclude_signature}
    assert {("left_hip", "left_shank"), ("right_hip", "right_shank")} <= excluded


def _moved(model, positions):
    import mujoco

    data = mujoco.MjData(model)
    for name, value in positions.items():
        data.joint(name).qpos[0] = value
    mujoco.mj_kinematics(model, data)
    found = {}
    for index in range(1, model.nbody):
        made = np.eye(4)
        made[:3, 3], made[:3, :3] = data.xpos[index], data.xmat[index].reshape(3, 3)
        found[model.body(index).name] = made
    return found


FOUR_LINES = """\
robot: my_arm
include: [arm.urdf]
sensors: {camera: {type: camera, parent: tool0, frame: camera, xyz: [0, 0, 4 cm]}}
outputs: {urdf: {file: my_arm.urdf}}
"""


def test_a_camera_on_a_bought_arm_needs_four_lines(tmp_path):
    (tmp_path / "robot.yaml").write_text(FOUR_LINES, "utf-8")
    shutil.copy(ARM, tmp_path)
    urdf = texts(compiled(tmp_path / "robot.yaml"))["my_arm.urdf"]
    positions = {"shoulder": 0.7, "elbow": -1.1}
    before, after = frames(ARM.read_text("utf-8"), positions), frames(urdf, positions)
    assert after.keys() - before.keys() == {"camera", "camera_optical"}
    assert max(np.abs(after[link] - before[link]).max() for link in before) < 1e-12
    assert np.abs(after["camera"] - before["tool0"] @ pose([0, 0, 0.04], [0, 0, 0])).max() < 1e-9


def test_without_the_extra_the_message_says_what_to_install(monkeypatch):
    answer = {"absent": "xacro"}
    monkeypatch.setattr("rosorin_compile.importing.xacro.expand._expand", lambda *_: answer)
    (found,) = [d for d in compile_robot(PACKAGED / "robot.yaml").diagnostics if d.severity == ERROR]
    assert found.rule == "extra-missing"
    assert found.help == pip_install("import")
    assert [r.message for r in found.related] == ["included here", "included here"]


def test_trust_comes_from_the_environment_and_from_a_list_of_files(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    text = '<robot name="post" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="post${1}"/></robot>'
    digest = hashlib.sha256(text.encode()).hexdigest()
    write_files(tmp_path, {"post.xacro": text, "robot.yaml": "robot: cell\ninclude: [post.xacro]\n"})

    def found():
        return [one.rule for one in compile_robot(tmp_path / "robot.yaml").diagnostics]

    assert found() == ["xacro-runs-code"]
    with monkeypatch.context() as trusting:
        trusting.setenv("ROSORIN_COMPILE_TRUST", "1")
        assert found() == []
    write_files(tmp_path, {"config/rosorin-compile/trusted": f"# my files\n{digest}  post.xacro\n"})
    assert found() == []
    write_files(tmp_path, {"post.xacro": text + "<!-- changed -->"})
    assert found() == ["xacro-runs-code"]


def test_an_included_mjcf_arm_keeps_its_meshes_in_mujoco(tmp_path):
    import mujoco

    folder = tmp_path / "descriptions" / "r"
    (folder / "assets").mkdir(parents=True)
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (folder / "assets" / "m.obj").write_text(corners, "utf-8")
    (folder / "arm.xml").write_text(
        '<mujoco><compiler meshdir="assets"/><asset><mesh name="m" file="m.obj"/></asset>'
        '<worldbody><body name="b"><geom type="mesh" mesh="m"/></body></worldbody></mujoco>',
        "utf-8",
    )
    include = "{file: arm.xml, parent: base, meshes: ../../descriptions/r}"
    text = f"robot: r\ninclude: [{include}]\nlinks: {{base: {{}}}}\noutputs: {{mjcf: {{file: r.xml}}}}\n"
    (folder / "robot.yaml").write_text(text, "utf-8")
    (artifact,) = compile_robot(folder / "robot.yaml").artifacts
    target = tmp_path / "outputs" / "r" / artifact.file
    target.parent.mkdir(parents=True)
    target.write_text(artifact.text, "utf-8")
    assert mujoco.MjModel.from_xml_path(str(target)).nmesh == 1


ELEMENT = st.sampled_from(["<a b='{0}'>{1}</a>", "<joint name='{0}'/>", "<t>\n {0} <!-- {1} --></t>", "<x>{0}<y/></x>"])
WORD = st.sampled_from(["tool0", "base", "tool", "xtool0", "lift", "&#116;ool0", "ö"])


@given(st.lists(st.tuples(ELEMENT, WORD, WORD), min_size=1, max_size=6))
def test_renaming_only_ever_puts_the_prefix_in(parts):
    """The elements stay what they are: without the prefix they are the same text, and only whole names have one."""
    text = "".join(form.format(one, other) for form, one, other in parts)
    names = {"tool0", "base", "lift"}
    tree = parse_yaml(
        Source("robot.yaml", json.dumps({"links": {name: {} for name in names}, "urdf_elements": [text]}))
    )
    (renamed,) = with_prefix(tree, "PRE_", Instance("included", tree.span))[0]["urdf_elements"]
    assert renamed.replace("PRE_", "") == text
    assert set(re.findall(r"PRE_(\w+)", renamed)) <= names
    before, after = (ET.fromstring(f"<r>{t}</r>") for t in (text, renamed))
    for old, new in zip(before.iter(), after.iter(), strict=True):
        for key, value in old.attrib.items():
            plain = value in names and f"'{value}'" in text
            assert new.get(key) in ((f"PRE_{value}", value) if plain else (value,))


NAMES = st.lists(st.from_regex(r"[a-z][a-z0-9_]{0,6}", fullmatch=True), min_size=2, max_size=6, unique=True)
PREFIXES = st.from_regex(r"[a-z][a-z0-9_]{0,5}_", fullmatch=True)


@settings(max_examples=60, deadline=None)
@given(names=NAMES, prefix=PREFIXES, other=PREFIXES, xyz=st.tuples(*[st.floats(-3, 3)] * 3))
def test_any_chain_under_any_prefix_is_the_same_chain(tmp_path_factory, names, prefix, other, xyz):
    """With every name prefixed and the joint of the attachment taken away, the foreign file is there again."""
    folder = tmp_path_factory.mktemp("any")
    links = "".join(f'<link name="{name}"/>' for name in names)
    joints = "".join(
        f'<joint name="{child}" type="fixed"><origin xyz="{x} 0 0"/><parent link="{above}"/><child link="{child}"/>'
        f'</joint><gazebo reference="{child}"/>'
        for x, (above, child) in enumerate(pairwise(names))
    )
    (folder / "v.urdf").write_text(f'<robot name="v">{links}{joints}</robot>', "utf-8")
    entry = f"file: v.urdf, parent: BASE, joint: MOUNT, xyz: {list(xyz)}"
    both = f"[{{{entry}, prefix: A{prefix}}}, {{{entry.replace('MOUNT', 'MOUNT2')}, prefix: B{other}}}]"
    outputs = "outputs: {urdf: {file: r.urdf}}"
    (folder / "robot.yaml").write_text(f"robot: r\ninclude: {both}\nlinks: {{BASE: {{}}}}\n{outputs}\n", "utf-8")
    found = ET.fromstring(texts(compiled(folder / "robot.yaml", by=compile_unrounded))["r.urdf"])
    for before, joint in ((f"A{prefix}", "MOUNT"), (f"B{other}", "MOUNT2")):
        mount = found.find(f"joint[@name='{joint}']")
        assert mount.find("child").get("link") == before + names[0]
        assert tuple(map(float, mount.find("origin").get("xyz").split())) == xyz
        for x, (above, child) in enumerate(pairwise(names)):
            made = found.find(f"joint[@name='{before + child}']")
            assert (made.find("parent").get("link"), made.find("child").get("link")) == (before + above, before + child)
            assert float(made.find("origin").get("xyz").split()[0]) == x
            assert found.find(f"gazebo[@reference='{before + child}']") is not None
    assert len(found.findall("link")) == 1 + 2 * len(names)

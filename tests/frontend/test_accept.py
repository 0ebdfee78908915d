"""What a rule refuses and a robot has all the same: a note, and artifacts that say what was written and load."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.formats.mesh_files import Places, search
from rosorin_compile.source.diagnostics import NOTE, has_errors
from support.robots import compiled_text

mujoco = pytest.importorskip("mujoco", minversion="4")

BODY = "inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}"
ROBOT = """
robot: a
links:
  base: {%(base)s}
  arm: {%(arm)s}
  hand: {%(hand)s}
joints:
  shoulder: {%(shoulder)s, parent: base, child: arm}
  wrist: {%(wrist)s, parent: arm, child: hand}
%(accept)s
outputs: {urdf: {file: a.urdf}, mjcf: {file: a.xml}, robot_model: {file: a.json}, frames: {file: a.md}}
"""
LIMIT = "limit: {lower: -1, upper: 1, effort: 1, velocity: 1}"
USUAL = {
    "base": BODY,
    "arm": BODY,
    "hand": BODY,
    "shoulder": f"type: revolute, axis: [0, 0, 1], {LIMIT}",
    "wrist": f"type: revolute, axis: [0, 1, 0], {LIMIT}",
    "accept": "",
}

# The rule, what of the robot is not usual, the link or joint, what the URDF says then (empty: nothing of it).
CASES = {
    "angle-looks-like-degrees": (
        {"shoulder": f"type: revolute, axis: [0, 0, 1], rpy: [0, 0, 90], {LIMIT}"},
        "shoulder",
        'rpy="0 0 90"',
    ),
    "axis-not-unit": ({"shoulder": f"type: revolute, axis: [0, 0, 2], {LIMIT}"}, "shoulder", '<axis xyz="0 0 2"/>'),
    "inertia-not-positive-definite": (
        {"hand": "inertial: {mass: 1, inertia: {ixx: 0, iyy: 0, izz: 0}}", "wrist": "type: fixed"},
        "hand",
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>',
    ),
    "inertia-triangle": ({"arm": "inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 9}}"}, "arm", 'izz="9"'),
    "invisible-letter": ({}, "ha\u200bnd", '<link name="ha\u200bnd">'),
    "leading-slash": ({}, "/hand", '<link name="/hand">'),
    "length-looks-like-millimetres": (
        {"shoulder": f"type: revolute, axis: [0, 0, 1], xyz: [0, 0, 90], {LIMIT}"},
        "shoulder",
        'xyz="0 0 90"',
    ),
    "limit-equal": (
        {"wrist": "type: revolute, limit: {lower: 1, upper: 1, effort: 1, velocity: 1}"},
        "wrist",
        'lower="1" upper="1"',
    ),
    "limit-incomplete": (
        {"wrist": "type: revolute, limit: {lower: -1, upper: 2}"},
        "wrist",
        '<limit lower="-1" upper="2"/>',
    ),
    "limit-missing": ({"wrist": "type: revolute"}, "wrist", ""),
    "limit-negative": (
        {"wrist": "type: revolute, limit: {lower: -1, upper: 2, effort: -1, velocity: -3}"},
        "wrist",
        'effort="-1" velocity="-3"',
    ),
    "limit-on-continuous": (
        {"wrist": "type: continuous, limit: {lower: -1, upper: 2, effort: 1, velocity: 1}"},
        "wrist",
        'lower="-1" upper="2"',
    ),
    "limit-swapped": (
        {"wrist": "type: revolute, limit: {lower: 1, upper: -1, effort: 1, velocity: 1}"},
        "wrist",
        'lower="1" upper="-1"',
    ),
    "limit-zero": (
        {"wrist": "type: revolute, limit: {lower: -1, upper: 1, effort: 0, velocity: 0}"},
        "wrist",
        'effort="0" velocity="0"',
    ),
    "mass-not-positive": (
        {"hand": "inertial: {mass: 0, inertia: {ixx: 0, iyy: 0, izz: 0}}", "wrist": "type: fixed"},
        "hand",
        '<mass value="0"/>',
    ),
    "mimic-chain": (
        {"wrist": "type: revolute, mimic: {joint: z}, " + LIMIT, "arm": BODY + "}\n  more: {" + BODY, "accept": ""},
        "wrist",
        '<mimic joint="z"',
    ),
    "mimic-fixed": (
        {"wrist": "type: revolute, mimic: {joint: shoulder, offset: 0.5}, " + LIMIT, "shoulder": "type: fixed"},
        "wrist",
        'offset="0.5"',
    ),
    "letters-swapped": ({}, "shuolder_tip", '<link name="shuolder_tip">'),
    "names-look-alike": ({}, "Arm", '<link name="Arm">'),
    "optical-frame": ({"hand": BODY, "wrist": "type: fixed"}, "hand_optical", "hand_optical"),
    "owns-world-frame": ({}, "odom", '<link name="odom"/>'),
    "sensor-sees-itself": (
        {"arm": BODY + ", collision: [{box: {size: [2, 2, 0.1]}}]"},
        "laser_frame",
        'size="2 2 0.1"',
    ),
    "shape-size": ({"hand": f"{BODY}, collision: [{{box: {{size: [1, 0, 1]}}}}]"}, "hand", 'size="1 0 1"'),
    "mesh-scale": ({"hand": f"{BODY}, visual: [{{mesh: {{file: a.stl, scale: [1, 1, 0]}}}}]"}, "hand", 'scale="1 1 0"'),
    "mass-implausible": (
        {"arm": "inertial: {mass: 850, of: collision}, collision: [{box: {size: [0.1, 0.1, 0.1]}}]"},
        "arm",
        '<mass value="850"/>',
    ),
    "inertia-implausible": (
        {"arm": "inertial: {mass: 5, inertia: {ixx: 1e-6, iyy: 1e-6, izz: 1e-6}}"},
        "arm",
        '<mass value="5"/>',
    ),
    "centre-outside": (
        {"arm": BODY.replace("mass: 1,", "mass: 1, xyz: [0, 0, 7],") + ", collision: [{box: {size: [2, 2, 0.1]}}]"},
        "arm",
        'xyz="0 0 7"',
    ),
    "density-looks-like-grams": (
        {"arm": "inertial: {density: 2.7, of: collision}, collision: [{box: {size: [1, 1, 1]}}]"},
        "arm",
        '<mass value="2.7"/>',
    ),
    "collision-elsewhere": (
        {
            "arm": BODY
            + ", collision: [{box: {size: [0.2, 0.2, 0.2]}}], visual: [{sphere: {radius: 0.1}, xyz: [0, 0, 3]}]"
        },
        "arm",
        'xyz="0 0 3"',
    ),
    "size-implausible": (
        {
            "shoulder": f"type: revolute, axis: [0, 0, 1], xyz: [0, 0, 12], {LIMIT}",
            "wrist": f"type: revolute, axis: [0, 1, 0], xyz: [0, 0, 1], {LIMIT}",
        },
        "arm",
        'xyz="0 0 12"',
    ),
    "two-in-one-place": (
        {
            "arm": BODY + ", collision: [{sphere: {radius: 0.5}}]",
            "hand": BODY + ", collision: [{sphere: {radius: 0.5}}]",
            "shoulder": "type: fixed",
            "wrist": "type: fixed",
        },
        "wrist",
        "",
    ),
    "mimic-beyond-limit": (
        {"wrist": f"type: revolute, axis: [0, 1, 0], mimic: {{joint: shoulder, multiplier: 2}}, {LIMIT}"},
        "wrist",
        'multiplier="2"',
    ),
    "velocity-looks-like-degrees": (
        {"wrist": f"type: revolute, axis: [0, 1, 0], {LIMIT}".replace("velocity: 1", "velocity: 300")},
        "wrist",
        'velocity="300"',
    ),
    "dynamics-negative": (
        {"wrist": f"type: revolute, axis: [0, 1, 0], dynamics: {{damping: -0.5}}, {LIMIT}"},
        "wrist",
        'damping="-0.5"',
    ),
    "axis-across": (
        {"wrist": "type: continuous", "hand": BODY + ", visual: [{cylinder: {radius: 0.5, length: 0.1}}]"},
        "wrist",
        'type="continuous"',
    ),
    "colour-range": (
        {"hand": BODY + ", visual: [{sphere: {radius: 0.5}, rgba: [255, 0, 0, 1]}]"},
        "hand",
        'rgba="255 0 0 1"',
    ),
}

# What MuJoCo does not load, by the rule that says so.
REFUSED_BY_MUJOCO = {"inertia-triangle": "mjcf-refused-inertia"}


WARNINGS = [
    "axis-across",
    "centre-outside",
    "collision-elsewhere",
    "colour-range",
    "density-looks-like-grams",
    "inertia-implausible",
    "length-looks-like-millimetres",
    "mass-implausible",
    "mesh-scale",
    "mimic-beyond-limit",
    "mimic-chain",
    "size-implausible",
    "two-in-one-place",
    "velocity-looks-like-degrees",
    "sensor-sees-itself",
    "leading-slash",
    "letters-swapped",
    "names-look-alike",
]


def written(rule: str, accept: bool) -> str:
    """Return a robot that breaks a rule."""
    changes, name, _ = CASES[rule]
    entry = f"accept: [{{rule: {rule}, of: [{name}], reason: it is so}}]" if accept else ""
    text = ROBOT % {**USUAL, **changes, "accept": entry}
    if rule == "mimic-chain":
        text = text.replace(
            "joints:\n",
            "joints:\n  z: {type: revolute, mimic: {joint: shoulder}, " + LIMIT + ", parent: hand, child: more}\n",
        )
    if rule in ("invisible-letter", "leading-slash", "letters-swapped", "names-look-alike"):
        text = text.replace("hand: {", f'"{name}": {{').replace("child: hand}", f'child: "{name}"}}')
    if rule == "sensor-sees-itself":
        text = text.replace("outputs:", "sensors: {laser: {type: lidar_2d, parent: arm, frame: laser_frame}}\noutputs:")
    if rule == "two-in-one-place":
        text = text.replace("parent: arm", "parent: base")
    if rule == "optical-frame":
        text = text.replace("hand: {", "hand_optical: {").replace("child: hand}", "child: hand_optical}")
    if rule == "owns-world-frame":
        text = text.replace("joints:\n", "  odom: {}\njoints:\n  root: {type: fixed, parent: odom, child: base}\n")
    return text


@pytest.mark.parametrize("rule", CASES)
def test_an_error_is_a_note_with(tmp_path, rule):
    made = compiled_text(tmp_path, written(rule, accept=True))
    told = [d for d in made.diagnostics if d.rule == rule]
    if rule in WARNINGS:
        assert told == []
    else:
        (note,) = told
        assert note.severity == NOTE
        assert note.message.startswith("accepted: ")
        assert note.message.endswith(" (it is so)")
        assert note.span is not None
    if rule in REFUSED_BY_MUJOCO:
        assert [d.rule for d in made.diagnostics if d.severity == "error"] == [REFUSED_BY_MUJOCO[rule]]
        made = compiled_text(tmp_path, written(rule, accept=True).replace("mjcf: {file: a.xml}, ", ""))
    assert not has_errors(made.diagnostics), made.diagnostics
    assert made.robot is not None
    assert agreement(made.robot, made.artifacts) == []
    artifacts = {artifact.backend: artifact.text for artifact in made.artifacts}
    assert CASES[rule][2] in artifacts["urdf"]
    assert "nan" not in artifacts["urdf"]
    if "mjcf" in artifacts:
        mujoco.MjModel.from_xml_string(artifacts["mjcf"])
    if rule == "limit-missing":
        assert artifacts["urdf"].count("<limit") == 1


LONELY = """
robot: lonely
links: {base: {}, arm: {inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}, laser: {}}
joints:
  shoulder: {type: revolute, parent: base, child: arm, axis: [0, 0, 1], %s}
  laser_joint: {type: fixed, parent: arm, child: laser, axis: [0, 0, 1]}
accept:
  - {rule: ignored-key, reason: it was in the drawing}
  - {rule: %s}
materials: {wood: {texture: wood.jpg}}
outputs: {urdf: {file: a.urdf}, mjcf: {file: a.xml, number_format: six}}
"""


@pytest.mark.parametrize("rule", ["mjcf-cannot-say, reason: colours will do", "mjcf-cannot-say, of: [x], reason: y"])
def test_warnings_and_notes_of_a_rule_are_ended(tmp_path, rule):
    told = compiled_text(tmp_path, LONELY % (LIMIT, rule)).diagnostics
    rules = [d.rule for d in told]
    assert "ignored-key" not in rules
    assert ("mjcf-cannot-say" in rules) == ("accept-unused" in rules) == ("of:" in rule)


def test_robots_that_pinocchio_reads(tmp_path):
    """It reads a URDF that lacks effort and velocity, or has an axis of length 2, as ours says it."""
    for rule in ("axis-not-unit", "limit-equal", "limit-zero", "mass-not-positive"):
        made = compiled_text(tmp_path, written(rule, accept=True))
        urdf = next(artifact.text for artifact in made.artifacts if artifact.backend == "urdf")
        model = pinocchio.buildModelFromXML(urdf)
        assert model.existFrame("hand")


def test_a_follower_of_a_fixed_joint_is_held_in_mujoco(tmp_path):
    made = compiled_text(tmp_path, written("mimic-fixed", accept=True))
    model = mujoco.MjModel.from_xml_string(next(a.text for a in made.artifacts if a.backend == "mjcf"))
    assert model.neq == 1
    assert model.eq_obj2id[0] == -1
    assert model.eq_data[0][:5] == pytest.approx([0.5, 0, 0, 0, 0])


def test_several_are_one_note(tmp_path):
    text = written("axis-not-unit", accept=True).replace("axis: [0, 1, 0]", "axis: [0, 3, 0]")
    text = text.replace("of: [shoulder]", "of: [shoulder, wrist]")
    made = compiled_text(tmp_path, text)
    assert [d.message for d in made.diagnostics if d.rule == "axis-not-unit"] == [
        'accepted: the axis of joint "shoulder" has length 2, not 1, and 1 more of this kind (it is so)'
    ]


def test_what_is_not_named_stays_an_error(tmp_path):
    text = written("axis-not-unit", accept=True).replace("axis: [0, 1, 0]", "axis: [0, 3, 0]")
    made = compiled_text(tmp_path, text)
    assert [(d.severity, d.span.line) for d in made.diagnostics if d.rule == "axis-not-unit"] == [
        ("note", 8),
        ("error", 9),
    ]
    assert made.artifacts == ()


def test_an_accepted_shape_is_a_note_beside_other_errors(tmp_path):
    """The sizes of shapes are looked at when the model is built, where other errors keep the rules from being asked."""
    text = written("shape-size", accept=True).replace("links:", "links:\n  broken: {visual: [{}]}")
    made = compiled_text(tmp_path, text)
    assert [(d.rule, d.severity) for d in made.diagnostics] == [("shape-kind", "error"), ("shape-size", "note")]


def test_an_odom_without_a_link_cannot_be_accepted(tmp_path):
    text = (
        written("owns-world-frame", accept=True)
        .replace("  odom: {}\n", "")
        .replace("of: [odom]", "of: [odom, root, base]")
    )
    made = compiled_text(tmp_path, text)
    assert "error" in [d.severity for d in made.diagnostics if d.rule == "owns-world-frame"]


@pytest.mark.parametrize("mass", [0.0, 1.0, -1.0])
@pytest.mark.parametrize(
    "moments", [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0), (1.0, 1.0, 3.0), (1.0, 1.0, -0.5)]
)
@pytest.mark.parametrize("product", [0.0, 1.0])
@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_the_backend_refuses_what_mujoco_refuses(tmp_path, mass, moments, product, kind):
    """The MJCF is emitted and loads, or there is an error that MuJoCo gives too."""
    xx, yy, zz = moments
    hand = f"inertial: {{mass: {mass}, inertia: {{ixx: {xx}, iyy: {yy}, izz: {zz}, ixy: {product}}}}}"
    rules = ("mass-not-positive", "inertia-triangle", "inertia-not-positive-definite")
    accept = "accept: [" + ", ".join(f"{{rule: {rule}, of: [hand], reason: it is so}}" for rule in rules) + "]"
    made = compiled_text(tmp_path, ROBOT % {**USUAL, "hand": hand, "wrist": f"type: {kind}", "accept": accept})
    errors = [d.rule for d in made.diagnostics if d.severity == "error"]
    assert set(errors) <= {"mjcf-needs-mass", "mjcf-refused-inertia"}
    if not errors:
        text = next(artifact.text for artifact in made.artifacts if artifact.backend == "mjcf")
        model = mujoco.MjModel.from_xml_string(text)
        assert model.body("hand").mass == pytest.approx(max(mass, 0.0))
        return
    full = " ".join(str(v) for v in (xx, yy, zz, product, 0, 0))
    inertia = f'fullinertia="{full}"' if product else f'diaginertia="{xx} {yy} {zz}"'
    body = '<body><joint/><geom size="1" density="0"/>INERTIAL</body>'.replace(
        "<joint/>", "<joint/>" if kind != "fixed" else ""
    )
    empty = mass == 0 and not any(moments) and not product
    mjcf = f"<mujoco><worldbody>{body}</worldbody></mujoco>".replace(
        "INERTIAL", "" if empty else f'<inertial pos="0 0 0" mass="{mass}" {inertia}/>'
    )
    with pytest.raises(ValueError, match=r"inertia|mass"):
        mujoco.MjModel.from_xml_string(mjcf)


def test_a_point_mass_that_is_fixed_keeps_its_mass(tmp_path):
    made = compiled_text(tmp_path, written("inertia-not-positive-definite", accept=True))
    model = mujoco.MjModel.from_xml_string(next(a.text for a in made.artifacts if a.backend == "mjcf"))
    assert model.body("hand").mass == pytest.approx(1.0)
    assert np.allclose(model.body("hand").inertia, 0)


MESHED = """
robot: a
links: {base: {visual: [{mesh: {file: a.stl}}]}}
accept:
- {rule: parts-overlap, reason: one housing}
- {rule: mesh-unreadable, reason: it is on another machine}
- {rule: mesh-not-found, reason: it is on another machine}
- {rule: mesh-not-read, of: [base], reason: it is huge}
outputs: {urdf: {file: a.urdf}}
"""


@pytest.mark.parametrize("there", [False, True])
def test_what_nobody_asked_for_is_not_accepted_in_vain(there: bool, tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(MESHED)
    if there:
        (tmp_path / "a.stl").write_bytes(b"solid")
    assert compile_robot(tmp_path / "robot.yaml").diagnostics == []
    searched = compile_robot(
        tmp_path / "robot.yaml",
        search=lambda tree, outputs: search(tree, outputs, Places(tmp_path / "robot.yaml", tmp_path / "out", {}, {})),
    )
    unused = [(one.rule, one.message.partition(" ")[0]) for one in searched.diagnostics]
    assert unused == [("accept-unused", rule) for rule in (["mesh-not-found"] if there else []) + ["mesh-not-read"]]

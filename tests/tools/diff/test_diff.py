"""Diff: changes planted in an arm are each told once, in these words; other ways to write it are no difference."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.model import Robot
from support.comparing import ARM, DIFF, changed, compared, diff, told
from support.schemas import schema

SCHEMA = schema("robot_diff")
SHOULDER = "axis: [0, 1, 0]\n    limit: {lower: -1.5, upper: 2,"
TOOL = "type: fixed, parent: finger, child: tool, xyz: [0.05, 0, 0]"
LIMIT = "limit: {lower: -2, upper: 2, effort: 5, velocity: 3}"

PLANTED: list[tuple[list[tuple[str, str]], str]] = [
    ([("xyz: [0, 0, 0.22]", "xyz: [0, 0, 0.25]")], "laser moved 30.0 mm in mast: origin z 0.22 -> 0.25 m"),
    ([("rpy: [0, 0, 3.141592653589793]", "rpy: [0, 0, 0]")], "laser turned 180.0 deg in mast: yaw 3.14159 -> 0 rad"),
    (
        [("xyz: [-0.1, 0, 0.1]}", "xyz: [-0.1, 0.002, 0.1]}")],
        "mast moved 2.0 mm in base_link, and with it laser: origin y 0 -> 0.002 m",
    ),
    ([("xyz: [0.1, 0, 0.16]", "xyz: [0.1, 0, 0.17]")], "upper_arm moved 10.0 mm in base_link: origin z 0.16 -> 0.17 m"),
    (
        [("xyz: [0.1, 0, 0.16]\n    rpy: [0, 0, 0.1]", "xyz: [0.1, 0, 0.17]\n    rpy: [0, 0, 0.2]")],
        "upper_arm moved 10.0 mm and turned 5.7 deg in base_link: origin z 0.16 -> 0.17 m, yaw 0.1 -> 0.2 rad",
    ),
    (
        [(SHOULDER, SHOULDER.replace("0, 1, 0", "0, 0.8, 0.6"))],
        "shoulder axis 0 1 0 -> 0 0.8 0.6 (turned 36.9 deg): tool off by up to 284.6 mm and 61.7 deg "
        "at shoulder = 1.5625, only when shoulder is away from 0",
    ),
    (
        [(SHOULDER, "axis: [0, -1, 0]\n    limit: {lower: -1.5, upper: 2,")],
        "shoulder counts the other way round: axis 0 1 0 -> 0 -1 0; its limits do not follow",
    ),
    (
        [(SHOULDER, "axis: [0, -1, 0]\n    limit: {lower: -2, upper: 1.5,")],
        "shoulder counts the other way round: axis 0 1 0 -> 0 -1 0; its limits follow",
    ),
    (
        [("type: revolute\n    parent: upper_arm", "type: prismatic\n    parent: upper_arm")],
        "elbow type revolute -> prismatic",
    ),
    ([(TOOL, TOOL.replace("fixed", "continuous"))], "tool_joint type fixed -> continuous"),
    (
        [("parent: fore_arm\n    child: slider", "parent: upper_arm\n    child: slider")],
        "slider parent fore_arm -> upper_arm",
    ),
    (
        [("parent: mast\n    child: laser", "parent: upper_arm\n    child: laser")],
        "laser: fixed to base_link -> moves with shoulder",
    ),
    ([("upper: 2, effort: 10", "upper: 1.9, effort: 10")], "shoulder limit upper 2 -> 1.9 rad (-5.7 deg)"),
    ([("effort: 10", "effort: 11")], "shoulder limit effort 10 -> 11 N*m (+10.0 %)"),
    ([("velocity: 0.2", "velocity: 0.25")], "slide limit velocity 0.2 -> 0.25 m/s (+25.0 %)"),
    ([("damping: 0.5", "damping: 0.6")], "shoulder damping 0.5 -> 0.6 N*m*s/rad (+20.0 %)"),
    ([("armature: 0.01", "armature: 0.02")], "shoulder armature 0.01 -> 0.02 kg*m^2 (+100.0 %)"),
    ([("multiplier: 5", "multiplier: -5")], "finger_joint mimic multiplier 5 -> -5"),
    ([("offset: 0.1}", "offset: 0.2}")], "finger_joint mimic offset 0.1 -> 0.2 rad (+5.7 deg)"),
    ([("joint: slide, mult", "joint: elbow, mult")], "finger_joint mimics slide * 5 + 0.1 -> elbow * 5 + 0.1"),
    (
        [("    mimic: {joint: slide, multiplier: 5, offset: 0.1}\n", "")],
        "finger_joint mimics slide * 5 + 0.1 -> nothing",
    ),
    ([(LIMIT, f"{LIMIT}\n    safety_controller: {{k_velocity: 10}}")], "elbow safety k velocity: new, 10 N*m*s/rad"),
    ([(LIMIT, f"{LIMIT}\n    actuator: {{kp: 3}}")], "elbow kp: new, 3 N*m/rad"),
    ([("mass: 2,", "mass: 2.1,")], "base_link mass 2 -> 2.1 kg (+100.0 g)"),
    (
        [("xyz: [0.1, 0, 0], rpy: [0, 0, 0.3]", "xyz: [0.1, 0, 0.01], rpy: [0, 0, 0.3]")],
        "upper_arm centre of mass moved 10.0 mm: z 0 -> 0.01 m",
    ),
    ([("izz: 0.04", "izz: 0.03")], "base_link inertia izz 0.04 -> 0.03 kg*m^2 (by 25 % of the largest moment)"),
    (
        [("radius: 0.04, length: 0.06", "radius: 0.04, length: 0.07")],
        "base_link collision: cylinder length 0.06 -> 0.07 m (+10.0 mm)",
    ),
    (
        [("capsule: {radius: 0.03", "cylinder: {radius: 0.03")],
        "upper_arm collision: capsule (radius 0.03 m, length 0.2 m) -> cylinder (radius 0.03 m, length 0.2 m)",
    ),
    (
        [("sphere: {radius: 0.02}", "sphere: {radius: 0.021}")],
        "slider collision: sphere radius 0.02 -> 0.021 m (+1.0 mm)",
    ),
    (
        [("      - {cylinder: {radius: 0.04, length: 0.06}, xyz: [0.1, 0, 0.13]}\n", "")],
        "base_link collision: 2 -> 1 shapes",
    ),
    ([("rgba: [0.8", "rgba: [0.9")], "base_link visual colour 0.8 0.1 0.1 1 -> 0.9 0.1 0.1 1"),
    ([("rgba: [0.8", "rgba: [0.80000123")], "base_link visual colour 0.8 0.1 0.1 1 -> 0.8000012 0.1 0.1 1"),
    (
        [
            ("  marker: {}\n", ""),
            ("  marker_joint: {type: fixed, parent: upper_arm, child: marker, xyz: [0.05, 0.03, 0]}\n", ""),
        ],
        "removed: frame marker (fixed on upper_arm, marker_joint)",
    ),
    (
        [
            ("  tool: {}\n", "  tool: {}\n  hand: {collision: [{sphere: {radius: 0.1}}]}\n  tip: {}\n"),
            (
                "0.05, 0, 0]}",
                "0.05, 0, 0]}\n  h: {type: fixed, parent: tool, child: hand}"
                "\n  t: {type: fixed, parent: hand, child: tip}",
            ),
        ],
        "new: link hand (fixed on tool, h), and with it tip",
    ),
    ([("  marker: {}\n", "  pen: {}\n"), ("child: marker", "child: pen")], "link marker renamed to pen"),
    (
        [
            ("  elbow:\n", "  bend:\n"),
            ("joints: [shoulder, elbow]", "joints: [shoulder, bend]"),
            ("elbow: -1", "bend: -1"),
        ],
        "joint elbow renamed to bend",
    ),
    ([("  mast_joint: {type: fixed", "  mast_fix: {type: fixed")], "joint mast_joint renamed to mast_fix"),
    ([("publisher: tf_laser}", "publisher: tf_scan}")], "laser: published by tf_laser -> tf_scan"),
    ([("publisher: ekf}]", "publisher: ekf, moving: false}]")], "base_link: topic /tf -> /tf_static"),
    ([("zero_pulse: 500", "zero_pulse: 510")], "servo of shoulder zero pulse 500 -> 510"),
    ([("flipped: true", "flipped: false")], "servo of shoulder rad per pulse -0.004 -> 0.004 rad (+0.46 deg)"),
    ([("elbow: -1", "elbow: -1.1")], "pose ready: elbow -1 -> -1.1 rad (-5.7 deg)"),
    (
        [("[upper_arm, slider]", "[upper_arm, finger]")],
        "contacts: 1 new (finger - upper_arm), 1 removed (slider - upper_arm)",
    ),
    (
        [("<static>1<", "<static>0<")],
        "URDF elements of the robot: 1 new (<static>0.0</static>), 1 removed (<static>1.0</static>)",
    ),
]


@pytest.mark.parametrize(("changes", "line"), PLANTED, ids=[line for _, line in PLANTED])
def test_a_planted_change_is_told_once_in_these_words(
    tmp_path: Path, changes: list[tuple[str, str]], line: str
) -> None:
    found = compared(DIFF / "arm.yaml", changed(tmp_path, *changes))
    assert [item["text"] for item in found["differences"]] == [line]
    assert not found["not_compared"]
    jsonschema.validate(found, SCHEMA)


# The same arm in other words.
SAME: list[tuple[str, list[tuple[str, str]]]] = [
    ("a number in degrees", [("rpy: [0, 0, 3.141592653589793]", "rpy: [0, 0, 180 deg]")]),
    ("half a turn the other way", [("rpy: [0, 0, 3.141592653589793]", "rpy: [0, 0, -180 deg]")]),
    ("another unit", [("xyz: [0.1, 0, 0.16]", "xyz: [100 mm, 0, 16 cm]")]),
    (
        "an angle the other way round",
        [
            ("rpy: [0, 0, 0.1]", 'rpy: [0, 0, "${0.1 - 2 * pi}"]'),
            (
                "robot: arm\n",
                "robot: arm\naccept: [{rule: angle-looks-like-degrees, of: [shoulder], reason: as it came}]\n",
            ),
        ],
    ),
    (
        "another parent for a fixed frame",
        [
            (
                "parent: mast\n    child: laser\n    xyz: [0, 0, 0.22]",
                "parent: base_link\n    child: laser\n    xyz: [-0.1, 0, 0.32]",
            )
        ],
    ),
    (
        "a shape on another link of the body",
        [
            ("  laser: {collision: [{cylinder: {radius: 0.03, length: 0.04}}]}\n", "  laser: {}\n"),
            (
                "xyz: [0, 0, 0.1]}]\n  laser",
                "xyz: [0, 0, 0.1]}, {cylinder: {radius: 0.03, length: 0.04}, xyz: [0, 0, 0.22]}]\n  laser",
            ),
        ],
    ),
    (
        "shapes in another order, a box between corners",
        [
            ("      - box: {size: [0.3, 0.2, 0.1]}\n        xyz: [0, 0, 0.05]\n", ""),
            ("0, 0.13]}\n", "0, 0.13]}\n      - {box: {min: [-0.15, -0.1, 0], max: [0.15, 0.1, 0.1]}}\n"),
        ],
    ),
    (
        "a box that lies on its side",
        [
            (
                "{size: [0.02, 0.02, 0.2]}, xyz: [0, 0, 0.1]",
                "{size: [0.2, 0.02, 0.02]}, xyz: [0, 0, 0.1], rpy: [0, 90 deg, 0]",
            )
        ],
    ),
    ("a capsule upside down", [("rpy: [0, 1.5707963267948966, 0]", "rpy: [0, -90 deg, 0]")]),
    (
        "an inertia along other axes",
        [("izz: 0.04}}", "izz: 0.03, iyy: 0.04}, rpy: [90 deg, 0, 0]}"), ("ixx: 0.02, iyy: 0.03, ", "ixx: 0.02, ")],
    ),
    (
        "an axis of another length",
        [
            ("axis: [1, 0, 0]", "axis: [2, 0, 0]"),
            ("robot: arm\n", "robot: arm\naccept: [{rule: axis-not-unit, of: [slide], reason: as it came}]\n"),
        ],
    ),
    ("dynamics of zero", [(LIMIT, f"{LIMIT}\n    dynamics: {{damping: 0}}")]),
    (
        "elements of XML in other words",
        [('<static>1</static><a b="2" c="x"/>', '<!-- why --><static> 1.0 </static> <a c="x"  b="2.0"></a>')],
    ),
    ("no expression", [("offset: 0.1}", 'offset: "${0.3 - 0.2}"}')]),
]


@pytest.mark.parametrize(("name", "changes"), SAME, ids=[name for name, _ in SAME])
def test_the_same_in_other_words_is_no_difference(tmp_path: Path, name: str, changes: list[tuple[str, str]]) -> None:
    text = ARM
    for old, new in changes:
        assert old in text, name
        text = text.replace(old, new, 1)
    path = tmp_path / "other.yaml"
    path.write_text(text, "utf-8")
    assert told(DIFF / "arm.yaml", path) == []
    assert told(path, DIFF / "arm.yaml") == []


def test_a_robot_that_is_split_into_files_is_the_same(tmp_path: Path) -> None:
    head, joints = ARM.split("joints:\n", 1)
    joints, tail = joints.split("servos:", 1)
    (tmp_path / "robot.yaml").write_text(f"{head}include: [more.yaml]\nservos:{tail}", "utf-8")
    (tmp_path / "more.yaml").write_text(f"joints:\n{joints}", "utf-8")
    code, out, _ = diff(DIFF / "arm.yaml", tmp_path)
    assert code == 0
    assert out.splitlines()[-1] == "the same robot, as far as it was compared"


def test_an_inserted_frame_is_new_and_moves_nothing(tmp_path: Path) -> None:
    path = changed(
        tmp_path,
        ("  marker: {}\n", "  marker: {}\n  plate: {}\n"),
        (
            "type: fixed, parent: base_link, child: mast, xyz: [-0.1, 0, 0.1]",
            "type: fixed, parent: plate, child: mast, xyz: [-0.1, 0, 0]",
        ),
        (
            "joints:\n  mast",
            "joints:\n  plate_joint: {type: fixed, parent: base_link, child: plate, xyz: [0, 0, 0.1]}\n  mast",
        ),
    )
    assert told(DIFF / "arm.yaml", path) == ["new: frame plate (fixed on base_link, plate_joint)"]


def test_several_changes_come_by_importance_then_by_the_tree(tmp_path: Path) -> None:
    path = changed(
        tmp_path,
        ("rgba: [0.8", "rgba: [0.9"),
        ("mass: 0.4", "mass: 0.5"),
        ("upper: 2, effort: 10", "upper: 1.9, effort: 10"),
        (
            "  elbow:\n    type: revolute\n    parent: upper_arm\n    child: fore_arm\n    xyz: [0.2",
            "  elbow:\n    type: revolute\n    parent: upper_arm\n    child: fore_arm\n    xyz: [0.21",
        ),
        ("xyz: [0, 0, 0.22]", "xyz: [0, 0, 0.25]"),
        ("mass: 0.1", "mass: 0.2"),
    )
    found = compared(DIFF / "arm.yaml", path)
    assert [(item["kind"], item["name"]) for item in found["differences"]] == [
        ("frame", "laser"),
        ("joint", "elbow"),
        ("limit", "shoulder"),
        ("mass", "mast"),
        ("mass", "finger"),
        ("visual", "base_link"),
    ]
    assert found["summary"] == "different: 1 frame, 1 joint, 1 limit, 2 masses, 1 visual"
    laser, elbow = found["differences"][:2]
    assert laser["distance"] == pytest.approx(0.03)
    assert (laser["angle"], laser["when"]) == (0, "always")
    assert elbow["distance"] == pytest.approx(0.01)


def test_an_axis_says_where_it_is_off_the_most(tmp_path: Path) -> None:
    path = changed(tmp_path, (SHOULDER, SHOULDER.replace("0, 1, 0", "0, 0.8, 0.6")))
    (item,) = compared(DIFF / "arm.yaml", path)["differences"]
    old, new = (_free(compile_robot(file).robot) for file in (DIFF / "arm.yaml", path))

    def off(position: float) -> float:
        return math.dist(*(robot.pose_in_root("tool", {"shoulder": position}).xyz for robot in (old, new)))

    assert item["when"] == "away from 0"
    assert item["distance"] == pytest.approx(off(item["at"]["shoulder"]), abs=1e-12)
    assert item["distance"] == pytest.approx(max(off(-1.5 + 0.01 * index) for index in range(351)), rel=0.01)


def _free(robot: Robot | None) -> Robot:
    """Return a robot whose followers are moved on their own, as diff moves them."""
    assert robot is not None
    return replace(robot, joints=tuple(replace(joint, mimic=None) for joint in robot.joints))

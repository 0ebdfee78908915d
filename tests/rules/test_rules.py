"""The rules: none is wrong about a robot that is right."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.expand.description import expand
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Inertial
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.rules.check import check
from rosorin_compile.source.diagnostics import NOTE
from support.paths import ROSORIN
from support.robots import compiled, found, robot, rules

LIMIT = {"lower": -1, "upper": 1, "effort": 1, "velocity": 1}


def test_reference_robot_is_right():
    made = compiled()
    assert [d for d in made.diagnostics if d.severity != NOTE] == []


def test_reference_robot_names_its_stand_ins_once():
    tree = expand(ROSORIN, {}, None).tree
    lowered = lower(tree)
    notes = [d.message for d in check(lowered.robot, tree, lowered.places, FORMATS)]
    assert len(notes) == len(set(notes)) >= 3
    assert any("chassis height map" in note and "base_footprint" in note for note in notes)
    assert any(all(f'"joint{number}" limit' in note for number in range(1, 6)) for note in notes)


def orthogonal(seed: int) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


def inertial(matrix: np.ndarray) -> Inertial:
    m = [[float(value) for value in row] for row in matrix]
    return Inertial(1.0, IDENTITY, m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2])


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
@pytest.mark.parametrize("moments", [(1, 2, 2.5), (1, 1, 1), (1, 1, 2), (1e-6, 1, 1), (-1, 1, 2), (0, 0, 1)])
def test_principal_moments_are_the_eigenvalues(moments, scale):
    for seed in range(50):
        axes = orthogonal(seed)
        matrix = axes @ np.diag(moments) @ axes.T * scale
        matrix = (matrix + matrix.T) / 2
        assert inertial(matrix).principal_moments == pytest.approx(np.linalg.eigvalsh(matrix), abs=4e-15 * scale)


def test_principal_moments_end_on_any_number():
    for values in ((1e300,) * 6, (1e-320,) * 6, (0, 0, 0, 1, 1, 1), (1e308, -1e308, 0, 1e308, 5, 1e-300), (0,) * 6):
        assert len(Inertial(1.0, IDENTITY, *map(float, values)).principal_moments) == 3


@given(st.integers(0, 2**32), st.integers(4, 12), st.floats(-6, 3))
@settings(max_examples=200, deadline=None)
def test_a_cloud_of_masses_has_a_physical_inertia(seed, count, exponent):
    rng = np.random.default_rng(seed)
    points, masses = rng.normal(size=(count, 3)) * 10**exponent, rng.uniform(0.1, 1, count)
    points = points - (masses @ points) / masses.sum()
    matrix = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    keys = dict(
        zip(
            ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"),
            map(float, matrix[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
            strict=True,
        )
    )
    link = {"inertial": {"mass": float(masses.sum()), "inertia": keys}}
    # Points have no size: what they weigh may well be denser than any body.
    assert set(rules({"robot": "made", "links": {"base_link": link}})) <= {"inertia-implausible"}


@pytest.mark.parametrize("flat", [(1e-6, 2e-6, 3e-6), (1e-4, 2e-4, 3e-4), (3e-7, 3e-7, 6e-7)])
def test_a_flat_plate_is_physical(flat):
    inertia = dict(zip(("ixx", "iyy", "izz"), flat, strict=True))
    assert rules({"robot": "made", "links": {"base_link": {"inertial": {"mass": 0.01, "inertia": inertia}}}}) == []


@pytest.mark.parametrize(
    "turn", [(-math.pi / 2, 0, -math.pi / 2), (-1.5707, 0, -1.5708), (math.pi / 2, math.pi, math.pi / 2)]
)
def test_optical_frame_may_be_said_in_any_way(turn):
    lens = {"type": "fixed", "parent": "camera", "child": "camera_optical_frame", "rpy": list(turn)}
    assert rules(robot({"lens": lens})) == []


def test_imagers_of_one_device_differ_by_their_calibration():
    lens = {"type": "fixed", "parent": "camera", "child": "depth_optical_frame", "rpy": [-math.pi / 2, 0, -math.pi / 2]}
    color = {
        "type": "fixed",
        "parent": "depth_optical_frame",
        "child": "color_optical_frame",
        "rpy": [0.004, -0.01, 0.002],
    }
    assert rules(robot({"lens": lens, "color": color})) == []


@pytest.mark.parametrize(
    "joint",
    [
        {"type": "revolute", "limit": {**LIMIT, "lower": -6.2832, "upper": 6.2832}},
        {"type": "continuous"},
        {"type": "continuous", "limit": {"effort": 1, "velocity": 30}},
        {"type": "prismatic", "limit": {**LIMIT, "lower": 0, "upper": 12}},
        {"type": "revolute", "limit": LIMIT, "axis": [0.99997, -0.0069812, 0.0026676]},
    ],
)
def test_unusual_joints_are_right(joint):
    joints = {"joint": {"parent": "base_link", "child": "arm", **joint}}
    assert rules(robot(joints, poses={"there": {"positions": {"joint": 0.5}}})) == []


def test_a_wheel_may_be_told_any_angle():
    joints = {"wheel": {"type": "continuous", "parent": "base_link", "child": "tyre"}}
    assert rules(robot(joints, poses={"far": {"positions": {"wheel": 100}}})) == []


@pytest.mark.parametrize(
    ("first", "second"), [("slam", "not slam"), ("slam and gps", "not (slam and gps)"), ("", None)]
)
def test_one_publisher_in_every_mode(first, second):
    edge = {"parent": "map", "child": "base_link", "publisher": "a"}
    edges = [{**edge, "when": when} if when else dict(edge) for when in (first, second) if when is not None]
    description = {"robot": "made", "links": {"base_link": {}}, "publishers": {"a": None}, "edges": edges}
    assert rules({**description, "modes": {"slam": None, "gps": None}}) == []


def test_frames_of_the_world_may_have_any_name():
    edges = [
        {"parent": "vicon/world".replace("/", "_"), "child": "base_link", "publisher": "mocap"},
        {"parent": "arm", "child": "tag", "publisher": "mocap"},
        {"parent": "tag", "child": "tag_corner", "publisher": "mocap"},
    ]
    joints = {"shoulder": {"type": "fixed", "parent": "base_link", "child": "arm"}}
    assert rules(robot(joints, edges=edges, publishers={"mocap": {}})) == []


def test_mimic_of_a_mimic_that_comes_earlier_is_right():
    hinge = {"type": "revolute", "parent": "base_link", "limit": LIMIT}
    joints = {
        "a_joint": {**hinge, "child": "a", "mimic": {"joint": "c_joint"}},
        "b_joint": {**hinge, "child": "b", "mimic": {"joint": "a_joint"}},
        "c_joint": {**hinge, "child": "c"},
    }
    assert rules(robot(joints)) == []


BALL = {"collision": [{"sphere": {"radius": 0.1}}]}
HEAVY = {**BALL, "inertial": {"mass": 1, "of": "collision"}}


@pytest.mark.parametrize(
    ("links", "told"),
    [
        ([HEAVY, HEAVY, BALL], 1),  # most have one
        ([HEAVY, BALL], 1),
        ([HEAVY, BALL, BALL], 0),  # most have none: it is told elsewhere, once
        ([BALL, BALL, BALL], 0),
    ],
)
def test_a_part_without_mass_is_told_where_most_have_one(links, told):
    joints = {
        f"j{n}": {"type": "continuous", "parent": f"l{n}", "child": f"l{n + 1}", "axis": [0, 1, 0]}
        for n in range(len(links))
    }
    made = robot(joints)
    made["links"] |= {f"l{n}": link for n, link in enumerate(links, 1)}
    assert rules(made).count("inertial-missing") == told


@pytest.mark.parametrize(("colliding", "told"), [(0, 0), (1, 0), (2, 1), (3, 1)])
def test_a_part_that_collides_with_nothing_is_told_beside_two_that_do(colliding, told):
    seen = {"visual": [{"sphere": {"radius": 0.1}}]}
    links = [{**seen, **BALL}] * colliding + [seen]
    joints = {
        f"j{n}": {"type": "continuous", "parent": f"l{n}", "child": f"l{n + 1}", "axis": [0, 1, 0]}
        for n in range(len(links))
    }
    made = robot(joints)
    made["links"] |= {f"l{n}": link for n, link in enumerate(links, 1)}
    assert [one.rule for one in found(made)].count("collision-missing") == told


@pytest.mark.parametrize(
    ("radius", "told"), [(0.1, []), (0.101, []), (0.2, ["drive-radius"]), (0.05, ["drive-radius"])]
)
def test_a_radius_is_told_that_the_wheels_have_not(radius, told):
    wheel = {"collision": [{"cylinder": {"radius": 0.1, "length": 0.02}, "rpy": [math.pi / 2, 0, 0]}]}
    joints = {
        side: {"type": "continuous", "parent": "base", "child": f"{side}_wheel", "xyz": [0, y, 0], "axis": [0, 1, 0]}
        for side, y in (("left", 0.2), ("right", -0.2))
    }
    made = robot(joints, drive={"differential": {side: [side] for side in joints}, "radius": radius})
    made["links"] |= {f"{side}_wheel": wheel for side in joints}
    assert rules(made) == told

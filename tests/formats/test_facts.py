"""What artifacts say, and how well it is known: no better than it was printed, and hardly worse."""

from __future__ import annotations

import math
import random

import pytest

from rosorin_compile.formats.facts import _turned, along_link, frame_block, is_six
from rosorin_compile.formats.urdf import facts as urdf_facts
from rosorin_compile.model import Pose, Transform
from rosorin_compile.model.geometry import rotation_about


@pytest.mark.parametrize(
    ("texts", "six"),
    [
        ([], True),
        (["0.5 1 2"], True),
        (["1.23457 -0.000123457"], True),
        (["1.2345678"], False),
        (["1 2 3 1.2345678"], False),
        (["0.5 much 1.23457"], True),
    ],
)
def test_six_digits_are_known(texts: list[str], six: bool) -> None:
    assert is_six(texts) == six


@pytest.mark.parametrize("seed", range(20))
def test_how_far_a_turn_moves_an_inertia_at_most(seed: int) -> None:
    """Turned about many axes, no entry moves farther, and one a third as far."""
    chance = random.Random(seed)  # noqa: S311
    moments = tuple(chance.choice([0.0, 1.0]) * chance.uniform(0.1, 1) for _ in range(3))
    products = tuple(chance.choice([0.0, 1.0]) * chance.uniform(-0.3, 0.3) for _ in range(3))
    inertia = (*moments, *products)
    angle, bound = 1e-5, _turned(inertia, 1e-5)
    moved = 0.0
    for _ in range(400):
        axis = [chance.gauss(0, 1) for _ in range(3)]
        length = math.hypot(*axis)
        rows = rotation_about((axis[0] / length, axis[1] / length, axis[2] / length), angle)
        turned = along_link(inertia, Transform(rows))
        moved = max(moved, *(abs(a - b) for a, b in zip(inertia, turned, strict=True)))
    assert moved <= bound * (1 + 1e-4) + 1e-12
    assert bound <= 2.8 * moved + 1e-12


def test_an_inertia_along_other_axes_is_known_as_well_as_its_turn() -> None:
    text = """<robot name="r"><link name="a"><inertial><origin rpy="0.1 0.2 0.3"/><mass value="1"/>
    <inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
    turned = urdf_facts.read(text)["link", "a", "inertia xx"].tolerance
    plain = urdf_facts.read(text.replace('<origin rpy="0.1 0.2 0.3"/>', ""))["link", "a", "inertia xx"].tolerance
    assert plain < turned
    longer = urdf_facts.read(text.replace("0.1 0.2", "0.1234567891 0.2"))["link", "a", "inertia xx"].tolerance
    assert 2.5e-12 <= longer <= 1e-9


@pytest.mark.parametrize(
    ("rpy", "said", "tolerance"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1e-6),
        ((0.1, 0.2, 0.3), (0.1, 0.2, 0.3), 1e-6),
        ((0.0, 2.0, 0.0), (math.pi, math.pi - 2, math.pi), 4e-6),
    ],
)
def test_angles_that_have_another_form_are_known_less_well(
    rpy: tuple[float, float, float], said: tuple[float, float, float], tolerance: float
) -> None:
    block = frame_block("base", Pose(rpy=rpy), (1e-7, 1e-7, 1e-7), (1e-6, 1e-6, 1e-6))
    angles = [block[angle] for angle in ("roll", "pitch", "yaw")]
    assert [one.value for one in angles] == pytest.approx(said, abs=1e-12)
    assert [one.tolerance for one in angles] == pytest.approx([tolerance] * 3, rel=1e-3)
    assert block["origin x"].tolerance == 1e-7


def test_what_a_link_has_not_is_not_said() -> None:
    text = (
        """<robot name="r"><link name="a"><visual><geometry><sphere radius="1"/></geometry></visual></link></robot>"""
    )
    facts = urdf_facts.read(text)
    assert facts["link", "a", "visual shapes"].value == 1.0
    assert ("link", "a", "collision shapes") not in facts


def test_what_else_a_urdf_has_is_said() -> None:
    text = """<robot name="r"><link name="a"><spheres n="1"/></link><link name="b"/><joint name="j" type="fixed">
    <parent link="a"/><child link="b"/><sensor x="2"/></joint><gazebo><static>1</static></gazebo>
    <transmission name="t"/></robot>"""
    found = {tuple(fact): value.value for fact, value in urdf_facts.read(text).items() if "element" in fact.quantity}
    assert found == {
        ("robot", "r", "element 1 gazebo"): "<gazebo><static>1</static></gazebo>",
        ("robot", "r", "element 2 transmission"): '<transmission name="t"></transmission>',
        ("link", "a", "element 1 spheres"): '<spheres n="1"></spheres>',
        ("joint", "j", "element 1 sensor"): '<sensor x="2"></sensor>',
    }

"""How diff says things: one shape that changed, what is not compared, and command lines that it cannot follow."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import rosorin_compile
from rosorin_compile.compare.difference import lines
from support.comparing import compared, diff, told

INERTIAL = '<inertial><mass value="1"/><inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{0}"/></inertial>'


def urdf(folder: Path, name: str, inside: str, more: str = "") -> Path:
    """Write a URDF with one link and what is in it; return its file."""
    path = folder / name
    path.write_text(f'<robot name="r"><link name="a">{inside}</link>{more}</robot>', "utf-8")
    return path


def visual(geometry: str, rpy: str = "0 0 0") -> str:
    return f'<visual><origin xyz="0 0 0" rpy="{rpy}"/><geometry>{geometry}</geometry></visual>'


@pytest.mark.parametrize(
    ("before", "after", "line"),
    [
        (visual('<mesh filename="m/a.stl"/>'), visual('<mesh filename="m/b.obj"/>'), "mesh file a.stl -> b.obj"),
        (
            visual('<mesh filename="a.stl"/>'),
            visual('<mesh filename="a.stl" scale="0.001 0.001 0.001"/>'),
            "mesh scale 1 1 1 -> 0.001 0.001 0.001",
        ),
        (visual('<mesh filename="a.stl"/>'), visual('<sphere radius="1"/>'), "mesh file a.stl -> sphere (radius 1 m)"),
        (
            visual('<mesh filename="a.stl"/>'),
            visual('<mesh filename="a.stl"/>', "0 0 0.1"),
            "mesh turned 5.7 deg (yaw 0 -> 0.1 rad)",
        ),
    ],
)
def test_a_single_shape_that_changed_says_how(tmp_path: Path, before: str, after: str, line: str) -> None:
    said = told(urdf(tmp_path, "a.urdf", before), urdf(tmp_path, "b.urdf", after))
    assert said == [f"a visual: {line}"]


@pytest.mark.parametrize(("before", "after", "percent"), [("0.0001", "0.1", "100"), ("0.1", "0.2", "50")])
def test_an_inertia_says_its_share_without_an_exponent(tmp_path: Path, before: str, after: str, percent: str) -> None:
    sides = [urdf(tmp_path, f"{value}.urdf", INERTIAL.format(value)) for value in (before, after)]
    (said,) = told(*sides)
    assert said.endswith(f"(by {percent} % of the largest moment)")


def test_many_things_that_are_not_compared_are_one_line_for_people(tmp_path: Path) -> None:
    inside = INERTIAL.format(1).replace("<mass ", '<mass p="1" q="2" r="3" s="4" t="5" ')
    path = urdf(tmp_path, "a.urdf", inside)
    _, out, _ = diff(path, path)
    lines = [line for line in out.splitlines() if line.startswith("not compared:")]
    assert len(lines) == 2
    assert all(line.endswith(" and 2 more") for line in lines)
    _, full, _ = diff(path, path, "--full")
    assert sum(line.startswith("not compared:") for line in full.splitlines()) == 10
    assert len(compared(path, path)["not_compared"]) == 10


@pytest.mark.parametrize(
    ("count", "more"),
    [
        (200, []),
        (201, ["... 1 more difference (--full shows them)"]),
        (202, ["... 2 more differences (--full shows them)"]),
    ],
)
def test_of_many_differences_people_see_the_first_ones(tmp_path: Path, count: int, more: list[str]) -> None:
    sides = [urdf(tmp_path, f"{value}.urdf", INERTIAL.format(value)) for value in (1, 2)]
    found = rosorin_compile.diff(*sides)
    many = replace(found, items=found.items[:1] * count)
    first = found.items[0].text
    assert [line for line in lines(many)[2:] if line.startswith(("...", first))] == [first] * 200 + more
    assert str(many).splitlines()[2 : 2 + count] == [first] * count


def test_nothing_is_said_of_contacts_that_nobody_disabled(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(
        f"robot: r\nlinks: {{a: {{}}}}\nurdf_elements: ['{INERTIAL.format(1)}']\n", "utf-8"
    )
    (tmp_path / "r.xml").write_text('<mujoco model="r"><worldbody><body name="a"/></worldbody></mujoco>', "utf-8")
    _, out, err = diff(tmp_path / "robot.yaml", tmp_path / "r.xml")
    assert "not compared" in out, err
    assert "contact" not in out


def test_arguments_for_a_file_without_any_are_refused(tmp_path: Path) -> None:
    path = urdf(tmp_path, "a.urdf", "")
    code, out, err = diff(path, path, "--b-arg", "height=3")
    assert (code, out) == (2, "")
    assert "a.urdf has no arguments: only a description and a xacro have them" in err
    code, _, err = diff(path, path, "-a", "height=3")
    assert code == 2
    assert "a.urdf has no arguments: only a description and a xacro have them" in err


@pytest.mark.parametrize("text", ["x", "-1", "nan", "inf", ""])
def test_a_tolerance_is_a_number(tmp_path: Path, text: str) -> None:
    path = urdf(tmp_path, "a.urdf", "")
    code, _, err = diff(path, path, f"--tolerance={text}")
    assert code == 2
    assert "--tolerance" in err


def test_contacts_that_somebody_disabled_are_counted(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(
        "robot: r\nlinks: {a: {}, b: {}, c: {}}\njoints:\n"
        "  j: {type: fixed, parent: a, child: b}\n  k: {type: fixed, parent: b, child: c}\n"
        "disabled_contacts: [{links: [a, b], reason: r}, {links: [a, c], reason: r}]\n",
        "utf-8",
    )
    bodies = '<body name="a"><body name="b"><body name="c"/></body></body>'
    exclude = '<contact><exclude body1="a" body2="b"/></contact>'
    (tmp_path / "r.xml").write_text(f'<mujoco model="r"><worldbody>{bodies}</worldbody>{exclude}</mujoco>', "utf-8")
    found = compared(tmp_path / "robot.yaml", tmp_path / "r.xml")
    assert "2 and 1 disabled contacts: a simulation adds those of neighbours" in found["not_compared"]
    assert found["differences"] == []


def test_robots_of_two_names_are_one_with_a_note(tmp_path: Path) -> None:
    one = urdf(tmp_path, "a.urdf", "")
    other = tmp_path / "b.urdf"
    other.write_text(one.read_text("utf-8").replace('name="r"', 'name="s"'), "utf-8")
    found = compared(one, other)
    assert (found["differences"], found["notes"]) == ([], ["the robot is called r in A, s in B"])
    assert compared(one, one)["notes"] == []


def heavy(mass: float, x: float, *moments: float) -> str:
    ixx, iyy, izz = moments
    inertia = f'<inertia ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/>'
    return f'<inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/>{inertia}</inertial>'


TWO = heavy(1, 0, 1, 1, 1), heavy(1, 0, 1, 1, 1)


@pytest.mark.parametrize(
    ("first", "second", "said"),
    [
        (*TWO, []),
        (heavy(2, 0.5, 2, 2.5, 2.5), "", []),
        (heavy(2, 0.5, 2, 2.5, 2.6), "", ["mass", "centre of mass", "inertia", "mass"]),
        (heavy(2, 0.5, 2, 2.6, 2.5), "", ["mass", "centre of mass", "inertia", "mass"]),
        (heavy(2, 0.5, 2.2, 2.5, 2.5), "", ["mass", "centre of mass", "inertia", "mass"]),
        (heavy(2, 0.5, 2, 2, 2), "", ["mass", "centre of mass", "inertia", "mass"]),
        (heavy(2, 0.6, 2, 2.5, 2.5), "", ["mass", "centre of mass", "inertia", "mass"]),
        (heavy(1.5, 0, 1, 1, 1), heavy(0.6, 0, 1, 1, 1), ["mass", "mass"]),
        ("", "", ["mass", "mass"]),
    ],
)
def test_a_body_is_as_heavy_as_its_links_are_together(tmp_path: Path, first: str, second: str, said: list[str]) -> None:
    """Two links that are fixed to each other, a metre apart; what one has the other may have, too."""
    fixed = '<joint name="j" type="fixed"><origin xyz="1 0 0"/><parent link="a"/><child link="b"/></joint>'
    one, other = (
        urdf(tmp_path, f"{name}.urdf", own, f'<link name="b">{theirs}</link>{fixed}')
        for name, (own, theirs) in {"one": TWO, "other": (first, second)}.items()
    )
    found = compared(one, other)
    assert [item["quantity"] for item in found["differences"]] == said
    shared = "the mass of the body of a is shared out otherwise (a, b); as a whole it is the same"
    assert found["notes"] == ([shared] if not said and first != TWO[0] else [])


@pytest.mark.parametrize(("iyy", "same"), [(0.0002005, True), (0.0002075, False)])
def test_a_small_body_is_known_as_well_as_it_is_small(tmp_path: Path, iyy: float, same: bool) -> None:
    """Two links a millimetre apart, in a file of six digits."""
    fixed = '<joint name="j" type="fixed"><origin xyz="0.001 0 0"/><parent link="a"/><child link="b"/></joint>'
    half = heavy(1, 0, 0.0001, 0.0001, 0.0001)
    one = urdf(tmp_path, "one.urdf", half, f'<link name="b">{half}</link>{fixed}')
    whole = heavy(2, 0.0005, 0.0002, iyy, iyy)
    other = urdf(tmp_path, "other.urdf", whole, f'<link name="b"/>{fixed}')
    found = [item["quantity"] for item in compared(one, other)["differences"]]
    assert found == ([] if same else ["mass", "centre of mass", "inertia", "mass"])

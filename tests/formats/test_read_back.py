"""What each format reads of an artifact that has everything in it, and which of its texts are damaged.

What is not read back is not compared, either: ``check`` and ``diff`` would not see it change.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import pytest

from rosorin_compile.compare.artifacts import agreement, output_of, under_names
from rosorin_compile.compare.precision import printed_precision
from rosorin_compile.compare.walk import Address, compare_leaves, leaves
from rosorin_compile.formats import FORMATS
from support.machines import TESTER
from support.paths import DATA
from support.reading import leaves_of, line
from support.robots import CHAIN, compiled, compiled_text
from support.urdf_robots import emit

HERE = DATA / "read_back"
READ = {"robot.urdf": "urdf", "robot.sdf": "sdf", "robot.xml": "mjcf", "robot.srdf": "srdf"}


@pytest.mark.parametrize("name", READ)
def test_all_that_an_artifact_contains_is_read(name: str) -> None:
    found = leaves_of(READ[name], (HERE / name).read_text("utf-8"))
    lines = sorted(line(address, leaf) for address, leaf in found.items())
    assert lines == (HERE / f"{name}.txt").read_text("utf-8").splitlines()


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("robot.sdf", "<model ", "<other "),
        ("robot.sdf", ' name="r"', ""),
        ("robot.sdf", "<mass>2</mass>", "<mass>2 3</mass>"),
        ("robot.sdf", "<ixx>1</ixx>", "<ixx>nan</ixx>"),
        ("robot.sdf", "0.1 0.2 0.3 0 0 0.5", "0.1 0.2 0.3"),
        ("robot.sdf", "<box>", "<sphere/><box>"),
        ("robot.urdf", "<mass value=", "<mass of="),
        ("robot.urdf", '<child link="hand"/>', ""),
        ("robot.urdf", '<child link="hand"/>', '<child link="nobody"/>'),
        ("robot.urdf", 'ixx="1"', 'ixx="inf"'),
        ("robot.urdf", '"0.01 0.02 0.03"', '"0.01 0.02"'),
        ("robot.urdf", "<box ", "<sphere/><box "),
        ("robot.urdf", "</robot>", ""),
        ("robot.srdf", ' type="planar"', ""),
        ("robot.srdf", ' link2="mast"', ""),
        ("robot.xml", '"box" size="0.1', '"box" size="1 0.1'),
        ("robot.xml", 'mesh="big"', 'mesh="small"'),
    ],
)
def test_what_is_damaged_is_a_value_error(name: str, old: str, new: str) -> None:
    text = (HERE / name).read_text("utf-8")
    assert old in text
    with pytest.raises(ValueError, match=r"."):
        leaves_of(READ[name], text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("format", "text"),
    [
        ("sdf", "<sdf/>"),
        ("sdf", "<robot/>"),
        ("urdf", "<sdf/>"),
        ("urdf", ""),
        ("urdf", '<!DOCTYPE r [<!ENTITY a "b">]>' + emit(TESTER)),
        ("srdf", "<sdf/>"),
        ("mjcf", "<mujoco/>"),
    ],
)
def test_what_is_another_file_is_a_value_error(format: str, text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        leaves_of(format, text)


def test_defaults_are_those_of_urdf() -> None:
    found = leaves_of(
        "urdf",
        """<robot name="r"><link name="a"/><link name="b"/>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/><mimic joint="j"/></joint></robot>""",
    )
    assert found[Address("frame", "b", "origin")].xyz == (0.0, 0.0, 0.0)
    assert found[Address("joint", "j", "axis")] == (1.0, 0.0, 0.0)
    assert found[Address("joint", "j", "mimic multiplier")] == 1.0


@pytest.mark.parametrize(
    ("which", "old", "new", "told"),
    [
        (0, '<mass value="2"/>', '<mass value="3"/>', "s0 mass"),
        (3, '<box size="0.1 0.1 0.2"/>', '<box size="0.1 0.1 0.3"/>', "s3 collision"),
        (4, '<sphere radius="0.1"/>', '<box size="1 1 1"/>', "s4 collision"),
        (3, '<origin xyz="0 0 0.2"', '<origin xyz="0 0 0.3"', "s3 moved"),
        (5, '<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>', "j5 axis"),
        (2, 'upper="1"', 'upper="2"', "j2 limit upper"),
        (2, '<parent link="s1"/>', '<parent link="s0"/>', "s2 parent"),
        (2, '<child link="s2"/>', '<child link="base"/>', "s2"),
    ],
)
def test_one_of_many_that_are_alike_is_found(tmp_path: Path, which: int, old: str, new: str, told: str) -> None:
    chain = compiled_text(tmp_path, f"{CHAIN}outputs: {{urdf: {{file: chain.urdf}}}}\n")
    assert chain.robot is not None
    pieces = chain.artifacts[0].text.split(old)
    assert len(pieces) in (2, 7)
    place = which + 1 if len(pieces) == 7 else 1
    text = old.join(pieces[:place]) + new + old.join(pieces[place:])
    found = agreement(chain.robot, [replace(chain.artifacts[0], text=text)])
    assert any(told in one.message for one in found), [one.message for one in found]


def test_all_artifacts_of_the_reference_robot_agree() -> None:
    """A leaf that two formats have is the same, but for what is in one of them by its nature."""
    made = compiled()
    assert made.robot is not None
    found = []
    for artifact in made.artifacts:
        format = FORMATS[artifact.backend]
        if format.read is not None:
            read = under_names(format, output_of(made.robot, artifact), leaves(format.read(artifact.text)))
            found.append((artifact.file, read, printed_precision(artifact.text)))
    compared = 0
    for (_, first, one), (_, second, other) in itertools.combinations(found, 2):
        for thing in first.keys() & second.keys():
            both = first[thing], second[thing]
            known = [{thing: _common(*pair)} for pair in (both, both[::-1])]
            assert compare_leaves(known[0], known[1], (one, other), 1e-6) == []  # a launch file has micrometres
            compared += len(known[0][thing])
    assert compared > 300


def _common(entry: dict[str, object], other: dict[str, object]) -> dict[str, object]:
    # Which link has the mass and the shapes of which frame, what is seen, and who publishes, is different by format.
    own = {"collision", "visual", "mass", "centre of mass", "inertia", "publisher", "topic", "damping", "name"}
    return {quantity: leaf for quantity, leaf in entry.items() if quantity in other and quantity not in own}

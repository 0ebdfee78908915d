"""What a robot has several times comes out of an import as a part and its uses, and as the same robot."""

import random
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.formats.imported_robot import ImportedRobot
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing import round_trip
from rosorin_compile.importing.repeats.nodes import mirror_node, nodes_of
from rosorin_compile.importing.repeats.parts import with_parts
from rosorin_compile.importing.round_trip import RoundTrip, _round_trip, check_round_trip
from rosorin_compile.language.expand.description import expand
from support.paths import ROOT, data_text
from support.robots import compiled
from support.unrounded import compile_unrounded

WHEEL = """
  <link name="{0}">
    <inertial><mass value="{mass}"/><inertia ixx="1e-3" ixy="0" ixz="0" iyy="2e-3" iyz="0" izz="1e-3"/></inertial>
    <visual><geometry><mesh filename="package://cart/wheel.dae"/></geometry></visual>
    <collision><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <joint name="{1}" type="continuous"><parent link="base"/><child link="{0}"/><origin xyz="0 {y} 0"/>
    <axis xyz="0 1 0"/><limit effort="3" velocity="4"/><dynamics damping="0.1" friction="0.2"/></joint>
"""


def robot(folder: Path, *inside: str) -> Path:
    path = folder / "cart.urdf"
    path.write_text(f'<robot name="cart"><link name="base"/>{"".join(inside)}</robot>', "utf-8")
    return path


def wheel(name: str, joint: str, y: float, mass: str = "1") -> str:
    return WHEEL.format(name, joint, y=y, mass=mass)


def trip_of(path: Path, parts: bool = True) -> RoundTrip:
    return check_round_trip(read_robot(path), path.parent / "made", parts=parts)


def parts_of(trip: RoundTrip) -> list[str]:
    return list((trip.shown.tree or {}).get("parts") or ())


def test_two_wheels_are_a_part(tmp_path: Path) -> None:
    path = robot(tmp_path, wheel("left_wheel", "left_axle", 1), wheel("right_wheel", "right_axle", -1))
    trip = trip_of(path)
    assert (trip.diagnostics, parts_of(trip)) == ([], ["wheel"])
    assert "  left: {part: wheel, parent: base, xyz: [0, 1, 0]}" in trip.files["robot.yaml"]
    assert parts_of(trip_of(path, parts=False)) == []


def test_numbers_that_differ_in_the_last_digit_stay_two(tmp_path: Path) -> None:
    first, second = "0.1", "0.10000000000000002"
    path = robot(tmp_path, wheel("left_wheel", "left_axle", 1, first), wheel("right_wheel", "right_axle", -1, second))
    text = trip_of(path).files["robot.yaml"]
    assert "mass: {}" in text
    assert f"with: {{mass: {first}}}" in text
    assert f"with: {{mass: {second}}}" in text


def test_what_is_not_the_same_robot_is_written_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A fault of ours: the part loses a joint's damping."""
    path = robot(tmp_path, wheel("left_wheel", "left_axle", 1), wheel("right_wheel", "right_axle", -1))
    found = round_trip.with_parts

    def wrong(imported: ImportedRobot) -> ImportedRobot:
        made = found(imported)
        assert made.tree is not None
        del made.tree["parts"]["wheel"]["joints"]["axle"]["dynamics"]
        return made

    monkeypatch.setattr(round_trip, "with_parts", wrong)
    trip = trip_of(path)
    assert (trip.diagnostics, parts_of(trip)) == ([], [])
    assert trip.files["robot.yaml"].count("damping: 0.1") == 2


BODY = """<body name="{0}" pos="0 {y} 0"><joint name="{0}_axle" axis="0 1 0" damping="{1}"/>
<geom name="{0}_tyre" size="0.1"/><geom name="{0}_hub" type="box" size=".1 .1 .1"/></body>"""


@pytest.mark.slow
@pytest.mark.parametrize(("order", "parts"), [("left right caster", 0), ("caster left right", 1)])
def test_the_order_of_an_mjcf_stays(order: str, parts: int, tmp_path: Path) -> None:
    """A controller counts by it."""
    pytest.importorskip("mujoco", minversion="3.12")
    bodies = {name: BODY.format(f"{name}_wheel", 1, y=y) for y, name in ((1, "left"), (-1, "right"))}
    bodies["caster"] = '<body name="caster"><joint name="swivel" axis="0 0 1"/><geom size="0.05"/></body>'
    inside = "".join(bodies[name] for name in order.split())
    path = tmp_path / "cart.xml"
    path.write_text(
        f'<mujoco><worldbody><body name="base"><geom size="1"/>{inside}</body></worldbody></mujoco>', "utf-8"
    )
    trip = trip_of(path)
    assert (trip.diagnostics, trip.untold, len(parts_of(trip))) == ([], (), parts)


EXAMPLES = {
    "turtlebot3_burger": {"wheel": ["wheel_left", "wheel_right"]},
    "unitree_a1": {"leg": ["FR", "FL", "RR", "RL"]},
}


@pytest.mark.slow
@pytest.mark.parametrize("by", [compile_robot, compile_unrounded])
@pytest.mark.parametrize("name", EXAMPLES)
def test_a_description_comes_back_with_its_parts(name: str, by: Callable[..., CompileResult], tmp_path: Path) -> None:
    """What a person wrote, compiled to a URDF and imported, has the parts and uses that the person chose."""
    trip = trip_of(urdf_of(name, by, tmp_path))
    assert trip.diagnostics == []
    assert uses_of(trip) == EXAMPLES[name]
    assert by is compile_robot or "90 deg" in "\n".join(trip.files.values())  # an import never rounds


def urdf_of(name: str, by: Callable[..., CompileResult], folder: Path) -> Path:
    made = compiled(ROOT / "examples" / name / "robot.yaml", by=by)
    (urdf,) = (one for one in made.artifacts if one.backend == "urdf")
    path = folder / "robot.urdf"
    path.write_text(urdf.text, "utf-8")
    return path


def uses_of(trip: RoundTrip) -> dict[str, list[str]]:
    tree = trip.shown.tree or {}
    return {part: [use for use, entry in tree["use"].items() if entry["part"] == part] for part in tree["parts"]}


MIRRORED = data_text("robots/import_repeats_mirrored.yaml")


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_mirrors_are_those_of_the_language(axis: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(MIRRORED.replace("AXIS", axis), "utf-8")
    tree = expand(path, {}, None).tree
    assert tree is not None
    nodes = nodes_of(tree)
    plain, turned = nodes[1:4], nodes[4:]
    assert [node.link for node in turned] == ["turned_one", "turned_two", "turned_three"]
    for index, (one, other) in enumerate(zip(plain, turned, strict=True)):
        assert mirror_node(one, axis, is_root=not index) == other.values


def test_the_search_ends(tmp_path: Path) -> None:
    """Two chains that are equal but for their names are compared at every link, and not for ever."""
    links, length = [], 150
    for chain in ("left", "q"):
        up = "base"
        for number in range(length):
            name = f"{chain}{chr(97 + number % 26)}{number}" if chain == "q" else f"left_{number}"
            links.append(f'<link name="{name}"/><joint name="{name}_j{chain}" type="fixed"><parent link="{up}"/>')
            links.append(f'<child link="{name}"/><origin xyz="0 0 {number + 1}"/></joint>')
            up = name
    imported = read_robot(robot(tmp_path, *links))
    started = time.process_time()
    assert with_parts(imported) is imported
    assert time.process_time() - started < 10


# Whatever a robot has several times: its import is the same robot to the last digit, and has all comments.


SETS = (["left", "right"], ["FL", "FR", "RL", "RR"], ["1", "2", "3"], ["leg1", "leg2", "leg3"])
STYLES = ("{use}_{base}", "{base}_{use}", "{use}{base}", "x_{use}_{base}", "{base}.{use}.z")
KINDS = ("fixed", "revolute", "continuous", "prismatic")
SHAPES = ('<box size="0.1 0.2 0.3"/>', '<sphere radius="0.1"/>', '<mesh filename="package://p/{name}.stl"/>')
LIMIT = '<limit lower="-1" upper="1" effort="3" velocity="2"/>'


@given(st.integers(min_value=0, max_value=1_000_000))
@settings(max_examples=25, deadline=None)
def test_any_robot_stays_itself(seed: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "robot.urdf")
        path.write_text(robot_any(random.Random(seed)), "utf-8")  # noqa: S311 - nothing secret
        imported = read_robot(path)
        assert imported.tree is not None, imported.diagnostics
        trip = _round_trip(imported, with_parts(imported), Path(folder), None, {})
    assert trip.diagnostics == []
    text = "\n".join(trip.files.values())
    assert all(comment.text.strip() in text for comment in imported.comments)


def robot_any(chance: random.Random) -> str:
    """Return a URDF with several equal things, each with its names, some mirrored, some not quite equal."""
    made = ['<robot name="any"><link name="base"/>']
    style = chance.randrange(len(STYLES))
    for _ in range(chance.randint(1, 3)):
        links = [kind_of_link(chance, number) for number in range(chance.randint(1, 4))]
        for number, use in enumerate(chance.choice(SETS)):
            mirrored = bool(number % 2) and chance.random() < 0.7
            made += instance(chance, links, use, STYLES[style], (number, mirrored))
        style = (style + 1) % len(STYLES)
    return "\n".join([*made, "</robot>"])


def kind_of_link(chance: random.Random, number: int) -> dict[str, Any]:
    numbers = [[chance.choice([0, 0.1, -0.2, 1 / 3]) for _ in range(3)] for _ in range(4)]
    return {
        "base": f"{chance.choice(['hip', 'wheel', 'finger', 'link'])}{number}",
        "kind": chance.choice(KINDS),
        "shape": chance.choice(SHAPES),
        "axis": chance.choice(["1 0 0", "0 1 0", "0 0.6 0.8"]),
        "numbers": numbers,
        "up": chance.randrange(number) if number else -1,
    }


def instance(
    chance: random.Random, links: list[dict[str, Any]], use: str, style: str, place: tuple[int, bool]
) -> list[str]:
    made, names = [], []
    number, mirrored = place
    for link in links:
        name, joint = (style.format(use=use, base=link["base"] + end) for end in ("", "j"))
        xyz, rpy, centre, products = link["numbers"]
        if mirrored:
            xyz, centre = ([-v if axis == 1 else v for axis, v in enumerate(some)] for some in (xyz, centre))
            rpy, products = ([v if axis == 1 else -v for axis, v in enumerate(some)] for some in (rpy, products))
        up = names[link["up"]] if names else "base"
        xyz, rpy = (xyz, rpy) if names else ([0, number, 0], [0, 0, 0])
        mass = chance.choice([1, 1, 1, 1 + 1e-12])
        made += [
            f"<!-- about {name} -->" if chance.random() < 0.1 else "",
            f'<link name="{name}"><inertial><origin xyz="{spelt(centre)}"/><mass value="{mass!r}"/>',
            f'<inertia ixx="1" iyy="1" izz="1" ixy="{products[0]}" ixz="{products[1]}" iyz="{products[2]}"/>',
            f"</inertial><visual><geometry>{link['shape'].format(name=name)}</geometry></visual></link>",
            f'<joint name="{joint}" type="{link["kind"]}"><parent link="{up}"/><child link="{name}"/>',
            f'<origin xyz="{spelt(xyz)}" rpy="{spelt(rpy)}"/>',
            f'<axis xyz="{link["axis"]}"/>' if link["kind"] != "fixed" else "",
            LIMIT if link["kind"] in ("revolute", "prismatic") else "",
            "</joint>",
        ]
        names.append(name)
    if chance.random() < 0.2:
        made.append(f'<link name="{names[-1]}_eye"/><joint name="{names[-1]}_eye_joint" type="fixed">')
        made.append(f'<parent link="{names[-1]}"/><child link="{names[-1]}_eye"/></joint>')
    return made


def spelt(numbers: list[float]) -> str:
    return " ".join(map(repr, numbers))

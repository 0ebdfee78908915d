"""Whatever a robot has several times: its import is the same robot to the last digit, and has all comments."""

from __future__ import annotations

import random
import tempfile
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.reading import read_robot
from rosorin_compile.importing.repeats import with_parts
from rosorin_compile.importing.round_trip import _round_trip

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
        path.write_text(robot(random.Random(seed)), "utf-8")  # noqa: S311 - nothing secret
        imported = read_robot(path)
        assert imported.tree is not None, imported.diagnostics
        trip = _round_trip(imported, with_parts(imported), Path(folder), None, {})
    assert (trip.diagnostics, trip.largest) == ([], 0)
    text = "\n".join(trip.files.values())
    assert all(comment.text.strip() in text for comment in imported.comments)


def test_most_of_them_have_parts(tmp_path: Path) -> None:
    found = 0
    for seed in range(20):
        path = tmp_path / f"{seed}.urdf"
        path.write_text(robot(random.Random(seed)), "utf-8")  # noqa: S311 - nothing secret
        found += "parts" in (with_parts(read_robot(path)).tree or {})
    assert found > 10


def robot(chance: random.Random) -> str:
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

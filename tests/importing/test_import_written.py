"""A robot that was read, written and compiled is the same robot: by value, and by the stock readers."""

import random
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import file_name as safe
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.description import ROTATING
from rosorin_compile.importing.round_trip import check_round_trip
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.tree import Map
from support.engines import Pinocchio, Yourdfpy
from support.importing import robot
from support.paths import IMPORTED
from support.unrounded import compile_unrounded


@settings(max_examples=25, deadline=None)
@given(robot())
def test_any_robot_comes_through(text: str) -> None:
    with tempfile.TemporaryDirectory() as name:
        source = Path(name, "robot.urdf")
        source.write_text(text, "utf-8")
        imported = read_robot(source)
        assert imported.tree is not None, report(imported.diagnostics)
        trip = check_round_trip(imported, Path("x"))
    assert trip.diagnostics == [], report(trip.diagnostics)


def states(tree: Map) -> list[dict[str, float]]:
    chance = random.Random(4)  # noqa: S311 - nothing secret
    free = [name for name, joint in tree["joints"].items() if joint["type"] in (*ROTATING, "prismatic")]
    return [{name: chance.uniform(-1.5, 1.5) for name in free} for _ in range(50)]


@pytest.mark.parametrize("name", sorted(path.name for path in IMPORTED.iterdir()))
@pytest.mark.parametrize("engine", ["pinocchio", "yourdfpy"])
def test_stock_readers_see_the_same_robot(name: str, engine: str, tmp_path: Path) -> None:
    pytest.importorskip(engine)
    source = IMPORTED / name / f"{name}.urdf"
    made = compile_unrounded(IMPORTED / name / "expected" / "robot.yaml")
    (urdf,) = (artifact for artifact in made.artifacts if artifact.backend == "urdf")
    compiled = tmp_path / "compiled.urdf"
    compiled.write_text(urdf.text, "utf-8")
    tree = read_robot(source).tree
    assert tree is not None
    if engine == "pinocchio":
        before, after = Pinocchio(source.read_text("utf-8")), Pinocchio(urdf.text)
        assert [i.toDynamicParameters().tolist() for i in before.model.inertias] == [
            i.toDynamicParameters().tolist() for i in after.model.inertias
        ]
        assert before.model.lowerPositionLimit.tolist() == after.model.lowerPositionLimit.tolist()
        assert before.model.effortLimit.tolist() == after.model.effortLimit.tolist()
    else:
        before, after = Yourdfpy(source), Yourdfpy(compiled)
    for state in states(tree):
        first, second = before.frames(state), after.frames(state)
        assert set(first) == set(second)
        assert max(abs(first[frame] - second[frame]).max() for frame in first) <= 1e-9


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("my_robot", "my_robot"),
        ("My Robot (v2)", "My_Robot_v2"),
        ("../../etc/passwd", "etc_passwd"),
        (".hidden", "hidden"),
        ("機械", "robot"),
        ("12", "robot_12"),
        ("true", "robot_true"),
        ("null", "robot_null"),
        ("x" * 200, "x" * 60),
        ("-rf", "rf"),
    ],
)
def test_file_names_are_safe(name: str, file: str) -> None:
    assert safe(name) == file


@pytest.mark.usefixtures("home")
def test_what_xacro_left_over_comes_through():
    names = ["$(arg folder)/base.stl", "$(find other)/$(cwd)/lid.stl", "$${arg}$(env HOME)${x}/d.stl"]
    names += [f"$(arg a_folder_with_a_long_name)/one/{name}.stl" for name in "abc"]
    shapes = "".join(f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in names)
    Path("left.urdf").write_text(f'<robot name="left"><link name="base">{shapes}</link></robot>', "utf-8")
    assert main(["import", "left.urdf", "-o", "left"]) == 0
    made = compile_robot(Path("left/robot.yaml"))
    text = next(one.text for one in made.artifacts if one.file.endswith(".urdf"))
    assert [text.count(f'"{name}"') for name in names] == [1] * len(names)

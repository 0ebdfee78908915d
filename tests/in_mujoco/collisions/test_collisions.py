"""rosorin-compile collisions: which pairs need no check, and what becomes of the matrix when the robot changes."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.mujoco.collisions import Search
from support.commands import Shown, ask, write_files
from support.paths import DATA

pytest.importorskip("mujoco", minversion="3.12")
trimesh = pytest.importorskip("trimesh")
pytest.importorskip("scipy")

pytestmark = pytest.mark.slow  # MuJoCo, and thousands of states

ROBOT = (DATA / "robots/collisions.yaml").read_text("utf-8")
PROJECT = {"descriptions/reach/robot.yaml": ROBOT}
MATRIX = Path("descriptions/reach/collisions.yaml")
SOURCE = Path("descriptions/reach/robot.yaml")


@pytest.fixture
def reach(home: Path) -> Path:
    write_files(home, PROJECT)
    return home


@pytest.fixture(scope="module")
def searched_once(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("searched")
    write_files(folder, PROJECT)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(["collisions", "reach"]) == 0
        return MATRIX.read_bytes()


@pytest.fixture
def with_matrix(reach: Path, searched_once: bytes) -> Path:
    MATRIX.write_bytes(searched_once)
    return reach


def pairs() -> dict[str, dict[str, object]]:
    found = yaml.safe_load(MATRIX.read_text("utf-8"))["moveit"]["collision_matrix"]["pairs"]
    return {" ".join(pair["links"]): pair for pair in found}


def included(text: str = ROBOT) -> None:
    SOURCE.write_text(text.replace("robot: reach\n", "robot: reach\ninclude: [collisions.yaml]\n"), "utf-8")


@pytest.mark.usefixtures("reach")
def test_each_reason_is_what_moveit_calls_it(capsys: Shown) -> None:
    said = ask(capsys, "collisions", "reach").splitlines()
    assert said[0].startswith("descriptions/reach/collisions.yaml: 36 pairs of links, need no check: ")
    assert said[1:] == [
        "tried: 10,400 random states, seed 1",
        "next: include: [collisions.yaml] in descriptions/reach/robot.yaml, then rosorin-compile all",
    ]
    found = {names: pair["reason"] for names, pair in pairs().items()}
    assert found["arm mast"] == "Adjacent"  # over a link without shapes
    assert found["base mast"] == found["arm tip"] == found["base wheel"] == "Adjacent"
    assert found["bolt mast"] == "Default"
    assert found["mast sleeve"] == "Always"  # not at zero, in nearly every other state
    assert found["needle shelf"] == found["arm wheel"] == "Never"
    assert not {"needle tip", "shelf tip"} & set(found)


@pytest.mark.landing("engines", "1")
@pytest.mark.parametrize("seed", [1, 2, 3, 4])
@pytest.mark.usefixtures("reach")
def test_never_is_not_said_of_what_samples_miss(seed: int, capsys: Shown) -> None:
    """The tip meets the needle in seven millionths of its states: a thousand states are not to find it."""
    how = f"moveit: {{collisions: {{trials: 1000, seed: {seed}}}}}\n"
    SOURCE.write_text(ROBOT + how, "utf-8")
    ask(capsys, "collisions", "reach")
    assert "needle tip" not in pairs()


@pytest.mark.tier("engines")
@pytest.mark.usefixtures("with_matrix")
def test_the_same_seed_gives_the_same_bytes(capsys: Shown) -> None:
    first = MATRIX.read_bytes()
    ask(capsys, "collisions", "reach", "--force")
    assert MATRIX.read_bytes() == first


@pytest.mark.usefixtures("with_matrix")
def test_a_matrix_is_of_one_robot(capsys: Shown) -> None:
    included()
    assert ask(capsys, "collisions", "reach") == (
        "reach: the collision matrix is that of reach.urdf; --force computes it\n"
    )
    ask(capsys, "all", "reach")
    srdf = Path("outputs/reach/reach.srdf").read_text("utf-8")
    assert '<disable_collisions link1="mast" link2="sleeve" reason="Always"/> <!--' in srdf
    assert "10,400 random states, seed 1" in srdf
    for old, new, stale in (
        ("radius: 5 mm", "radius: 6 mm", "6 pairs may collide now, though"),  # a shape
        ("xyz: [0.31234,", "xyz: [0.312,", "needle and shelf, needle and sleeve"),  # a joint
        ("lower: -1.5, upper: 1.5", "lower: -1.5, upper: 1.6", "arm and base, arm and bolt"),  # a limit
        ("outputs:", "moveit: {collisions: {trials: 2000}}\noutputs:", "may collide now"),  # how it is searched
    ):
        assert old in ROBOT
        included(ROBOT.replace(old, new))
        assert main(["all", "reach"]) == 0
        said = capsys.readouterr().err
        assert said.count("warning[collisions-stale]") == 1
        assert 'run "rosorin-compile collisions" to compute the matrix again' in said
        assert stale in said
        assert Path("outputs/reach/reach.srdf").read_text("utf-8").count("<disable_collisions") == len(pairs())
    joint = "base_lidar: {type: fixed, parent: base, child: lidar, xyz: [0.1, 0, 0.2]}"
    for text in (
        ROBOT.replace("robot: reach\n", "# a comment\nrobot: reach\n"),
        ROBOT.replace("joints:\n", f"  lidar: {{}}\njoints:\n  {joint}\n"),  # a frame that has no shape touches nothing
    ):
        included(text)
        assert main(["all", "reach"]) == 0
        assert "collisions-stale" not in capsys.readouterr().err
        assert "disable_collisions" in Path("outputs/reach/reach.srdf").read_text("utf-8")


STONES = """\
robot: reach
links:
  base: {collision: [{mesh: {file: stone.stl}}]}
  arm: {collision: [{mesh: {file: stone.stl}}]}
  lamp: {collision: [{sphere: {radius: 1 cm}}]}
joints:
  k: {type: fixed, parent: arm, child: lamp, xyz: [1, 0, 0]}
  j: {type: prismatic, parent: base, child: arm, xyz: [1, 0, 0], axis: [0, 1, 0],
      limit: {lower: -1, upper: 1, effort: 1, velocity: 1}}
outputs: {urdf: {file: reach.urdf}, srdf: {file: reach.srdf}}
"""


def test_another_mesh_makes_a_matrix_stale(reach: Path, capsys: Shown) -> None:
    mesh = trimesh.creation.box((0.1, 0.2, 0.3))
    mesh.export(reach / "descriptions" / "reach" / "stone.stl")
    SOURCE.write_text(STONES, "utf-8")
    ask(capsys, "collisions", "reach")
    reasons = {names: pair["reason"] for names, pair in pairs().items()}
    assert reasons == {"arm base": "Adjacent", "arm lamp": "Adjacent", "base lamp": "Never"}
    included(STONES)
    ask(capsys, "all", "reach")
    assert "disable_collisions" in Path("outputs/reach/reach.srdf").read_text("utf-8")
    mesh.apply_scale(1.1).export(reach / "descriptions" / "reach" / "stone.stl")
    assert main(["all", "reach"]) == 0
    said = capsys.readouterr().err
    assert "warning[collisions-stale]: stone.stl changed since the collision matrix was computed" in said
    assert "Never" in Path("outputs/reach/reach.srdf").read_text("utf-8")
    ask(capsys, "collisions", "reach")
    assert main(["all", "reach"]) == 0
    assert not capsys.readouterr().err


def test_without_a_mesh_there_is_no_matrix(reach: Path, capsys: Shown) -> None:
    SOURCE.write_text(STONES, "utf-8")
    assert not (reach / "descriptions" / "reach" / "stone.stl").exists()
    assert main(["collisions", "reach"]) == 1
    said = capsys.readouterr().err
    assert "error[collisions-refused]: pairs that never touch can only be found with all meshes" in said
    assert not MATRIX.exists()


@pytest.mark.usefixtures("reach")
def test_what_is_no_matrix_is_not_replaced(capsys: Shown) -> None:
    MATRIX.write_text("links: {}\n", "utf-8")
    said = ask(capsys, "collisions", "reach", code=1)
    assert "error[collisions-refused]" in said
    assert "was not written by rosorin-compile" in " ".join(said.split())
    assert MATRIX.read_text("utf-8") == "links: {}\n"


@pytest.mark.usefixtures("reach")
def test_a_never_of_others_that_is_wrong_is_told(capsys: Shown) -> None:
    never = (
        "moveit: {disabled_collisions: [{links: [tip, shelf], reason: Never}, {links: [arm, wheel], reason: Never}]}\n"
    )
    SOURCE.write_text(ROBOT + never, "utf-8")
    assert main(["collisions", "reach"]) == 0
    assert "disabled_collisions says Never of tip and shelf, which do collide\n" in capsys.readouterr().err


@pytest.mark.tier("engines")
@pytest.mark.usefixtures("with_matrix")
def test_pairs_stay_whose_shapes_and_joints_are_the_same(capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another tip: its pairs alone are searched anew. A joint between, or the search, changes what it is between."""
    before = pairs()
    asked = searched(monkeypatch)
    smaller = ROBOT.replace(
        "tip: {collision: [{sphere: {radius: 2 mm}}]}", "tip: {collision: [{sphere: {radius: 1 mm}}]}"
    )
    included(smaller)
    said = ask(capsys, "collisions", "reach")
    assert "28 pairs as before: the same shapes, and the same joints between" in said
    assert asked == {pair for pair in asked if "tip" in pair}
    assert {pair: one for pair, one in pairs().items() if "tip" not in pair} == {
        pair: one for pair, one in before.items() if "tip" not in pair
    }
    asked.clear()
    included(smaller.replace("lower: -1.5, upper: 1.5", "lower: -1, upper: 1"))
    ask(capsys, "collisions", "reach")
    moved = {"arm", "tip"}
    assert asked
    assert all(len(moved.intersection(pair)) == 1 for pair in asked), "the joint is between no others"
    assert "as before" not in ask(capsys, "collisions", "reach", "--force")


def searched(monkeypatch: pytest.MonkeyPatch) -> set[tuple[str, str]]:
    asked: set[tuple[str, str]] = set()
    approach = Search.approach

    def watched(search: Search, pair: tuple[str, str], *states: Any) -> float:
        asked.add(pair)
        return approach(search, pair, *states)

    monkeypatch.setattr(Search, "approach", watched)
    return asked

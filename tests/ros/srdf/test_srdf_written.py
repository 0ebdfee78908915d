"""The SRDF of a description: its text, what it makes of each kind of base, parts and files that add to it."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions
from rosorin_compile.formats.robot_files import join, read_robot
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Robot
from rosorin_compile.ros.sections.moveit import Moveit
from rosorin_compile.source.diagnostics import has_errors
from support.cases import as_xml_comment, check
from support.commands import Shown, ask
from support.paths import DATA, ROSORIN, data_text
from support.reading import leaves_of
from support.robots import compiled_text, sound

ARM = data_text("robots/srdf_written_arm.yaml")
MOVEIT = data_text("robots/srdf_written_moveit.yaml")
WRITTEN = data_text("robots/srdf_written_written.urdf")


def srdf(folder: Path, text: str) -> str:
    made = compiled_text(folder, text)
    return sound(made)[1]["srdf"]


def test_the_text(tmp_path: Path) -> None:
    assert srdf(tmp_path, ARM + MOVEIT) == WRITTEN


def test_it_is_read_back(tmp_path: Path) -> None:
    found = leaves_of("srdf", srdf(tmp_path, ARM + MOVEIT))
    assert found["state", "wide of hand", "grip"] == 0.04
    assert found["group", "arm", "chain"] == "base_link to tool"
    (pairs,) = (leaf for (kind, *_), leaf in found.items() if kind == "disabled collisions")
    assert "base_link - upper (a cable holds them apart)" in pairs
    with pytest.raises(ValueError, match="no group"):
        leaves_of("srdf", '<robot name="a"><group_state name="x"><joint name="a" value="1"/></group_state></robot>')


WHEELS = """\
robot: base
links: {base_link: {}, left: {}, right: {}}
joints:
  left_joint: {type: continuous, parent: base_link, child: left, xyz: [0, 0.1, 0], axis: [0, 1, 0]}
  right_joint: {type: continuous, parent: base_link, child: right, xyz: [0, -0.1, 0], axis: [0, 1, 0]}
"""
DIFFERENTIAL = "drive: {differential: {left: [left_joint], right: [right_joint]}, radius: 5 cm}\n"
EDGE = "publishers: {odometry: {}}\nedges: [{parent: odom_frame, child: base_link, publisher: odometry}]\n"
ENDS = "outputs: {urdf: {file: a.urdf}, srdf: {file: a.srdf}}\n"


@pytest.mark.parametrize(
    ("more", "joint"),
    [
        ("", 'type="fixed" parent_frame="world"'),
        (DIFFERENTIAL, 'type="planar" parent_frame="odom"'),
        (DIFFERENTIAL + EDGE, 'type="planar" parent_frame="odom_frame"'),
        (EDGE, 'type="floating" parent_frame="odom_frame"'),
        ("poses: {up: {base: {xyz: [0, 0, 1]}}}\n", 'type="floating" parent_frame="world"'),
        ("moveit: {virtual_joint: {type: planar}}\n", 'type="planar" parent_frame="world"'),
        ("moveit: {virtual_joint: {parent: map}}\n", 'type="fixed" parent_frame="map"'),
    ],
)
def test_the_virtual_joint_is_as_the_base(tmp_path: Path, more: str, joint: str) -> None:
    made = compile_robot(_written(tmp_path, WHEELS + more + ENDS))
    assert not has_errors(made.diagnostics), made.diagnostics
    (text,) = (one.text for one in made.artifacts if one.backend == "srdf")
    assert f'<virtual_joint name="virtual_joint" {joint} child_link="base_link"/>' in text
    assert ("diff_drive" in text) == (DIFFERENTIAL in more)  # MoveIt is not to plan sideways


def _written(folder: Path, text: str) -> Path:
    (folder / "robot.yaml").write_text(text, "utf-8")
    return folder / "robot.yaml"


def test_a_mecanum_base_goes_sideways() -> None:
    (out,) = (one.text for one in compile_robot(ROSORIN).artifacts if one.backend == "srdf")
    assert '<virtual_joint name="virtual_joint" type="planar" parent_frame="odom" child_link="base_link"/>' in out
    assert "diff_drive" not in out


PART = data_text("robots/srdf_written_part.yaml")


def test_a_part_says_it_for_each_of_its_uses(tmp_path: Path) -> None:
    text = srdf(tmp_path, PART)
    for side, y in (("left", "0.1"), ("right", "-0.1")):
        for line in (
            f'<group name="{side}_arm">\n    <chain base_link="base_link" tip_link="{side}_lower"/>',
            f'<group name="{side}_outer">\n    <link name="{side}_lower"/>',
            f'<group name="{side}_both">\n    <group name="{side}_arm"/>\n    <group name="{side}_outer"/>',
            f'<group_state name="ready" group="{side}_arm">\n    <joint name="{side}_shoulder" value="1"/>',
            f'<end_effector name="{side}_shell" parent_link="{side}_upper" group="{side}_outer"'
            f' parent_group="{side}_arm"/>',
            f'<passive_joint name="{side}_elbow"/>',
            f'<disable_default_collisions link="{side}_shell"/>',
            f'<enable_collisions link1="{side}_shell" link2="{side}_upper"/>',
            f'<disable_collisions link1="base_link" link2="{side}_upper" reason="Adjacent"/>',
            f'<link_sphere_approximation link="{side}_lower">\n    <sphere center="0 {y} 0" radius="0.05"/>',
            f'<joint_property joint_name="{side}_elbow" property_name="weight" value="2"/>',
        ):
            assert line in text


def test_diff_tells_what_is_planned_otherwise(home: Path, capsys: Shown) -> None:
    (home / "a.yaml").write_text(ARM + MOVEIT, "utf-8")
    other = MOVEIT.replace("base: base_link", "base: upper").replace(
        "passive_joints: [wrist]", "passive_joints: [grip]"
    )
    (home / "b.yaml").write_text(ARM + other.replace("states: {wide: open}", "states: [open]"), "utf-8")
    assert main(["diff", "a.yaml", "b.yaml"]) == 1
    said = capsys.readouterr().out
    assert "moveit groups arm chain" in said
    assert "moveit groups hand states open: new, open" in said
    assert "moveit passive joints wrist -> grip" in said
    assert "same robot" in ask(capsys, "diff", "a.yaml", "a.yaml")


def test_a_state_of_a_group_says_nothing_of_other_joints(tmp_path: Path) -> None:
    """The pose "up" leaves the gripper at zero, where it cannot be: that is told unless it is a state of the arm."""

    def told(text: str) -> list[Any]:
        return [one for one in compiled_text(tmp_path, text).diagnostics if one.rule == "pose-beyond-limit"]

    assert len(told(ARM + ENDS)) == 1
    assert not told(ARM + MOVEIT.replace("tip: tool}}", "tip: tool}, states: [up]}"))


def test_pinocchio_reads_what_was_written(home: Path, capsys: Shown) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    from support.paths import DATA

    ask(
        capsys, "import", str(DATA / "srdf" / "arm.urdf"), "--srdf", str(DATA / "srdf" / "everything.srdf"), "-o", "arm"
    )
    ask(capsys, "all", "arm")
    (made,) = home.rglob("arm.srdf")
    pairs, states = [], []
    for urdf, file in (
        (DATA / "srdf" / "arm.urdf", DATA / "srdf" / "everything.srdf"),
        (made.with_suffix(".urdf"), made),
    ):
        model = pinocchio.buildModelFromUrdf(str(urdf))
        shapes = pinocchio.buildGeomFromUrdf(model, str(urdf), pinocchio.GeometryType.COLLISION)
        shapes.addAllCollisionPairs()
        pinocchio.removeCollisionPairs(model, shapes, str(file))
        names = [shapes.geometryObjects[number].name for number in range(len(shapes.geometryObjects))]
        pairs.append({frozenset((names[pair.first], names[pair.second])) for pair in shapes.collisionPairs})
        pinocchio.loadReferenceConfigurations(model, str(file))
        known = model.referenceConfigurations
        assert len(known) == 3
        states.append({name: known[name].tolist() for name in ("home", "bent", "parked")})
    assert pairs[0] == pairs[1]
    assert len(pairs[0]) == 15 - 3  # of six shapes on one joint each; pinocchio leaves out what is fixed together
    assert states[0] == states[1]


# SRDFs that people have, read beside the URDF in tests/data/srdf: what is kept, what is told, what is refused.


FILES = DATA / "srdf"
TOLD = sorted(FILES.glob("told/*.srdf"))
BAD = sorted(FILES.glob("bad/*.srdf"))


def joined(file: Path, **options: Any) -> ImportedRobot:
    how = ReadOptions(**options)
    return join(read_robot(FILES / "arm.urdf", how), "srdf", file, how)


def robot_of(imported: ImportedRobot) -> tuple[Robot, Moveit]:
    assert imported.tree is not None
    robot = lower(imported.tree).robot
    assert robot is not None
    assert robot.moveit is not None
    return robot, robot.moveit


@pytest.mark.parametrize("file", [*TOLD, *BAD], ids=lambda file: file.stem)
def test_message(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(file.parent)
    made = joined(Path(file.name))
    assert (made.tree is None) == (file in BAD)
    check(file, as_xml_comment(made.diagnostics, file.name))
    carried_not = [one for one in made.diagnostics if one.rule == "import-cannot-carry"]
    assert len(made.left_out) == len(carried_not)


@pytest.mark.parametrize("file", [file for file in BAD if file.stem in ("misspelt", "numbers")], ids=lambda f: f.stem)
def test_a_misspelt_word_can_be_left_out(file: Path) -> None:
    made = joined(file, lenient=True)
    assert (made.tree is not None) == (file.stem == "misspelt")


def test_every_word_is_imported_and_compiles_to_the_same(home: Path, capsys: Shown) -> None:
    sources = [str(FILES / "arm.urdf"), "--srdf", str(FILES / "everything.srdf")]
    assert main(["import", *sources, "-o", "first"]) == 0
    tree = yaml.safe_load(next(home.rglob("robot.yaml")).read_text("utf-8"))
    wanted = yaml.safe_load((FILES / "everything.yaml").read_text("utf-8"))
    assert {section: tree[section] for section in wanted} == wanted
    assert list(tree["moveit"]["groups"]) == list(wanted["moveit"]["groups"])
    assert main(["all", "first", "-o", "out/first"]) == 0
    made = capsys.readouterr().out
    assert "arm.srdf" in made
    one = joined(FILES / "everything.srdf")
    how = ReadOptions()
    (urdf,) = home.rglob("arm.urdf")
    other = join(read_robot(urdf, how), "srdf", urdf.with_suffix(".srdf"), how)
    (robot, moveit), (again, said) = robot_of(one), robot_of(other)
    assert said == moveit
    assert [(pose.name, pose.positions, pose.base) for pose in again.poses] == [
        (pose.name, pose.positions, pose.base) for pose in robot.poses
    ]


@pytest.mark.usefixtures("home")
def test_a_srdf_alone_is_no_robot(capsys: Shown) -> None:
    assert main(["import", str(FILES / "everything.srdf")]) == 1
    said = capsys.readouterr().err
    assert "error[wrong-format]: this is an SRDF, which belongs to a robot and has none itself" in said
    assert f"import ROBOT --srdf {FILES / 'everything.srdf'} reads both" in " ".join(said.split())

"""A newer state of a source is imported again: what somebody changed since stays or is told, and is never mixed in."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile import compile as compile_description
from rosorin_compile.cli import main
from support.paths import IMPORTED

BODY = """\
  <link name="base_link">
    <inertial><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial>
    <visual><geometry><box size="0.4 0.3 0.1"/></geometry></visual>
  </link>
  <!-- where the laser sits -->
  <link name="laser"/>
  <joint name="laser_joint" type="fixed">
    <parent link="base_link"/><child link="laser"/><origin xyz="0.1 0 0.2"/>
  </joint>
"""
WHEEL = """\
  <link name="NAME_wheel">
    <inertial><mass value="0.4"/><inertia ixx="0.0007" ixy="0" ixz="0" iyy="0.0013" iyz="0" izz="0.0007"/></inertial>
    <visual><geometry><cylinder radius="0.08" length="0.03"/></geometry></visual>
    <collision><geometry><cylinder radius="0.08" length="0.03"/></geometry></collision>
  </link>
  <joint name="NAME_wheel_joint" type="continuous">
    <parent link="base_link"/><child link="NAME_wheel"/>
    <origin xyz="PLACE 0.08"/><axis xyz="0 1 0"/><limit effort="6" velocity="12"/>
  </joint>
"""
LEFT, RIGHT, REAR = (
    WHEEL.replace("NAME", name).replace("PLACE", place)
    for name, place in (("left", "0.2 0.25"), ("right", "0.2 -0.25"), ("rear", "-0.2 0"))
)
ROOT = Path("descriptions/cart/robot.yaml")
SENSOR = "sensors:\n  # bought by hand\n  imu: {type: imu, frame: base_link}\n\noutputs:"


def source(*pieces: str, name: str = "cart.urdf") -> None:
    """Write the source; its pieces are links and joints."""
    Path(name).write_text(f'<robot name="cart">\n{"".join(pieces)}</robot>\n')


def run(*words: str) -> int:
    """Import cart.urdf again; return the exit code."""
    try:
        return main(["import", "cart.urdf", *words])
    except SystemExit as stopped:
        return int(stopped.code or 0)


def mine(old: str, new: str, file: Path = ROOT) -> str:
    """Change what stands in a file, as a person does; return its text."""
    text = file.read_text()
    assert text.count(old) == 1, (old, text)
    file.write_text(text.replace(old, new))
    return file.read_text()


def there() -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in Path().rglob("*") if path.is_file() and "cache" not in path.parts}


def refused(capsys: pytest.CaptureFixture[str], *words: str, code: int = 1) -> str:
    """Import what is refused; return what is said. Nothing may change."""
    before = there()
    capsys.readouterr()
    assert run(*words) == code
    assert there() == before
    return capsys.readouterr().err


@pytest.fixture
def cart(home: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """The folder of a cart that was imported."""
    source(BODY, LEFT, RIGHT)
    assert run() == 0
    capsys.readouterr()
    return home


@pytest.mark.usefixtures("cart")
def test_a_second_time_nothing_changes(capsys: pytest.CaptureFixture[str]) -> None:
    before = there()
    assert run() == 0
    assert there() == before
    said = capsys.readouterr().out
    assert "descriptions/cart: unchanged\ncart.urdf says what it said when it was imported before\n" in said
    mine("mass: 8", "mass: 9")
    before = there()
    assert run() == 0
    assert there() == before
    assert "1 change made here since that stays:\n  robot.yaml: links.base_link.inertial.mass: 8 -> 9\n" in (
        capsys.readouterr().out
    )


@pytest.mark.usefixtures("cart")
def test_what_was_changed_on_both_sides_is_there_as_it_was_written(capsys: pytest.CaptureFixture[str]) -> None:
    mine("mass: 8, inertia: {ixx: 0.1, iyy: 0.2, izz: 0.3}", "mass: 9, inertia: { ixx: .1, iyy: .2, izz: .3 }")
    mine("outputs:", SENSOR)
    text = mine("  laser: {}\n", "  laser: {}   # above the lid\n")
    source(BODY.replace("0.1 0 0.2", "0.15 0 0.2").replace("0.4 0.3 0.1", "0.5 0.3 0.1"), LEFT, RIGHT, REAR)
    assert run() == 0
    said = capsys.readouterr().out
    assert "  robot.yaml: joints.laser_joint.xyz: [0.1, 0, 0.2] -> [0.15, 0, 0.2]\n" in said
    assert "  robot.yaml: sensors.imu: added, {type: imu, frame: base_link}\n" in said
    now = ROOT.read_text()
    wanted = text.replace("[0.1, 0, 0.2]", "[0.15, 0, 0.2]").replace("[0.4, 0.3, 0.1]", "[0.5, 0.3, 0.1]")
    added = [line for line in now.splitlines() if line not in wanted.splitlines()]
    assert added == ["  rear: {part: wheel, parent: base_link, xyz: [-0.2, 0, 0.08]}"]
    assert [line for line in wanted.splitlines() if line not in now.splitlines()] == []
    made = compile_description(ROOT)
    assert made.robot is not None
    assert made.robot.link["base_link"].inertial.mass == 9
    assert [made.robot.joint[f"{name}_joint"].origin.xyz[0] for name in ("laser", "rear_wheel")] == [0.15, -0.2]


@pytest.mark.usefixtures("cart")
def test_a_value_that_both_changed_is_told_with_both_and_nothing_is_written(
    capsys: pytest.CaptureFixture[str],
) -> None:
    mine("mass: 8", "mass: 9")
    source(BODY.replace('value="8"', 'value="8.5"'), LEFT, RIGHT, REAR)
    said = refused(capsys)
    assert "robot.yaml:24:22: error[import-conflict]: links.base_link.inertial.mass is 9 here, and 8.5 in the" in said
    assert "newer cart.urdf; it was 8 when that was imported before" in said
    assert "write 8.5 here, or keep what is here with --ours" in said
    assert "cart.urdf: 1 error, nothing written" in said
    assert run("--ours") == 0
    assert "mass: 9" in ROOT.read_text()
    assert "rear: {" in ROOT.read_text()
    assert run() == 0  # from now on it is a change of one's own
    assert "  robot.yaml: links.base_link.inertial.mass: 8.5 -> 9\n" in capsys.readouterr().out


@pytest.mark.usefixtures("cart")
def test_a_value_that_is_written_as_the_newer_source_has_it_is_no_conflict(capsys: pytest.CaptureFixture[str]) -> None:
    mine("mass: 8", "mass: 9")
    source(BODY.replace('value="8"', 'value="8.5"'), LEFT, RIGHT)
    refused(capsys)
    mine("mass: 9", "mass: 8.5")
    assert run() == 0
    assert "made here" not in capsys.readouterr().out


@pytest.mark.usefixtures("cart")
@pytest.mark.parametrize("changed", [False, True])
def test_what_the_source_has_no_more_goes_unless_it_was_changed(
    capsys: pytest.CaptureFixture[str], changed: bool
) -> None:
    text = mine("[0.1, 0, 0.2]", "[0.1, 0, 0.3]") if changed else mine("outputs:", SENSOR)
    source(BODY.replace("laser", "lidar"), LEFT, RIGHT)
    if changed:
        said = refused(capsys)
        assert "joints.laser_joint is not there any more in the newer cart.urdf, and was changed here: xyz: " in said
        assert "xyz: [0.1, 0, 0.2] -> [0.1, 0, 0.3]" in said
        assert "remove it here, too, or keep it with --ours" in said
    else:
        assert run() == 0
        assert ROOT.read_text() == text.replace("laser", "lidar").replace("the lidar sits", "the laser sits").replace(
            "# where the laser", "# where the lidar"
        )


@pytest.mark.usefixtures("cart")
def test_a_comment_is_never_lost(capsys: pytest.CaptureFixture[str]) -> None:
    mine("  laser_joint: {", "  # measured twice\n  laser_joint: {")
    mine("size: [0.4, 0.3, 0.1]}}", "size: [0.4, 0.3, 0.1]}}  # without the bumper")
    source(BODY.replace("0.4 0.3 0.1", "0.5 0.3 0.1").replace("laser_joint", "mount"), LEFT, RIGHT)
    assert run() == 0
    text = ROOT.read_text()
    assert "size: [0.5, 0.3, 0.1]}}  # without the bumper\n" in text
    assert "# measured twice\n" in text
    mine("mount: {type: fixed,", "mount: {type: fixed,  # hangs\n   ")
    source(BODY.replace("0.4 0.3 0.1", "0.5 0.3 0.1"), LEFT, RIGHT)
    said = refused(capsys)
    assert "error[import-cannot-merge]" in said
    assert 'the comment "# hangs" stands in what the newer source has otherwise' in said
    assert "joints.mount: removed" in said


@pytest.mark.usefixtures("cart")
def test_a_changed_part_that_gets_another_use_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    mine("mass: 0.4", "mass: 0.5")
    source(BODY, LEFT, RIGHT, REAR)
    said = refused(capsys)
    assert "error[import-apart]: links.rear_wheel.inertial.mass is 0.5 by what was changed here; by the newer" in said
    assert "cart.urdf it would be 0.4" in said
    assert run("--ours") == 0
    assert "warning[import-apart]" in capsys.readouterr().err
    assert "rear: {" in ROOT.read_text()


@pytest.mark.usefixtures("cart")
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("robot: [", "yaml-syntax"),
        ("robot: cart\nlinks: {base_link: {}, other: {}}\n", "import-conflict"),
    ],
)
def test_what_cannot_be_read_or_is_another_robot_stays(
    capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    ROOT.write_text(text)
    source(BODY.replace('value="8"', 'value="8.5"'), LEFT, RIGHT)
    assert message in refused(capsys)


@pytest.mark.usefixtures("cart")
def test_the_import_of_another_robot_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    source(BODY, name="two.urdf")
    assert main(["import", "two.urdf"]) == 2
    said = capsys.readouterr().err
    assert "descriptions/cart is of another import: rosorin-compile import cart.urdf; this one is: two.urdf" in said
    assert run("--name", "other") == 0


@pytest.mark.usefixtures("home")
def test_an_option_is_added_and_not_forgotten(capsys: pytest.CaptureFixture[str]) -> None:
    source(BODY.replace('<box size="0.4 0.3 0.1"/>', '<mesh filename="base.stl"/>'), LEFT, RIGHT)
    assert run() == 0
    mine("mass: 8", "mass: 9")
    assert run("--meshes", "package://cart") == 0
    assert "mesh.file: base.stl -> package://cart/base.stl" in capsys.readouterr().out
    assert "mass: 9" in ROOT.read_text()
    said = refused(capsys, code=2)
    assert "was imported with --meshes: rosorin-compile import cart.urdf --meshes package://cart; say so again" in said


@pytest.mark.usefixtures("cart")
def test_without_a_record_nothing_is_written(capsys: pytest.CaptureFixture[str]) -> None:
    for text in (None, "robot: x\n", "# rosorin-compile import\n", '# rosorin-compile import "\n'):
        record = ROOT.with_name("robot.yaml.imported")
        record.unlink() if text is None else record.write_text(text)
        said = refused(capsys, code=2)
        assert "descriptions/cart is not empty; name a new folder with -o, or write into this one with --force" in said
        assert "(no robot.yaml.imported there says what was imported, against which changes could be told)" in said
    text = mine("mass: 8", "mass: 9")
    assert run("--force") == 0  # and from then on there is one
    assert ROOT.with_name("robot.yaml.kept").read_text() == text
    assert run() == 0


@pytest.mark.slow
@pytest.mark.usefixtures("home")
def test_a_description_of_several_files(capsys: pytest.CaptureFixture[str]) -> None:
    text = (IMPORTED / "rover" / "rover.urdf").read_text()
    Path("cart.urdf").write_text(text)
    assert run("--no-parts") == 0
    folder = Path("descriptions/rover")
    (folder / "mine.yaml").write_text("sensors:\n  mine: {type: imu, frame: base_link}\n")
    root = folder / "robot.yaml"
    mine("include: [links.yaml", "include: [mine.yaml, links.yaml", root)
    links = (folder / "links.yaml").read_text()
    (folder / "links.yaml").write_text(links.replace("mass: ", "mass:   "))  # as somebody likes it
    before = there()
    assert run("--no-parts") == 0
    assert there() == before
    Path("cart.urdf").write_text(text.replace('<mass value="', '<mass value="1', 1))
    assert run("--no-parts") == 0
    now = there()
    assert [name for name in before if before[name] != now[name]] == [
        "cart.urdf",
        "descriptions/rover/links.yaml",
        "descriptions/rover/links.yaml.imported",
    ]
    assert "mass:   114.2" in (folder / "links.yaml").read_text()
    assert "mine.yaml, links.yaml" in root.read_text()
    capsys.readouterr()


@pytest.mark.slow
@pytest.mark.usefixtures("cart")
def test_a_robot_that_grows_beyond_a_file_stays_in_it() -> None:
    mine("mass: 8", "mass: 9")
    many = [BODY.replace("base_link", "base_link").replace("laser", f"laser_{number}") for number in range(60)]
    links = [piece[piece.index("  <!--") :] for piece in many]
    source(BODY, LEFT, RIGHT, *links)
    assert run() == 0
    assert [path.name for path in sorted(ROOT.parent.iterdir())] == ["robot.yaml", "robot.yaml.imported"]
    assert "mass: 9" in ROOT.read_text()
    assert "laser_59_joint" in ROOT.read_text()

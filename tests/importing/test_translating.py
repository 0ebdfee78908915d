"""A xacro becomes a description with its macros, arguments and files; a translation that is wrong is not used.

What a xacro becomes is in the folders of ``data/translated``, see ``test_translated.py``.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import Outputs, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.xacro import translate as translator
from rosorin_compile.importing.xacro.translate import Target, Translation, translate
from support.paths import DATA
from support.xacro_table import Case, cases, ready

pytest.importorskip("xacro")

TUG = DATA / "xacro_package" / "urdf" / "tug.urdf.xacro"
HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
URDF = Outputs({"urdf": {"file": "robot.urdf"}}, {}, {})


def of(here: Path, body: str) -> Translation:
    path, how = here / "robot.xacro", ReadOptions(trust=True)
    path.write_text(f"{HEAD}{body}</robot>", "utf-8")
    imported = read_robot(path, how)
    assert imported.tree is not None, imported.diagnostics
    return translate(path, how, imported, URDF, Target(Path("descriptions/robot")))


def test_a_package_keeps_its_structure(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(TUG), "-o", "tug", "--trust"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert "7 of 7 macros kept" in told
    assert "arguments kept: prefix, use_sim, hardware, with_arm, arm_config and lidar_xyz" in told
    assert "left out, because nothing calls it: unused_macro" in told
    assert main(["all", "tug"]) == 0
    folder = home / "tug"
    made = {path.relative_to(folder).as_posix(): path.read_text() for path in folder.rglob("*.yaml")}
    parts = ["parts/arm.yaml", "parts/common.yaml", "parts/control.yaml", "parts/wheel.yaml"]
    assert sorted(made) == ["config/arm.yaml", *parts, "robot.yaml"]
    robot = made["robot.yaml"]
    assert "  hardware: {type: text, default: real, one_of: [real, mock]}\n" in robot
    assert "  use_sim: {type: boolean, default: false}\n" in robot
    assert "  # from axle to axle\n  wheel_base: 0.30\n" in robot
    assert "    rpy: [-90 deg, 0, 0]\n" in robot
    assert "nobody" not in robot
    assert "M_PI" not in "".join(made.values())
    assert "  # A driven wheel; reflect is -1 on the right.\n  wheel:\n" in made["parts/wheel.yaml"]
    assert "  box_inertial(mass, size_x, size_y, size_z):\n" in made["parts/common.yaml"]
    assert "${load(config)['joint_limits']}" in made["parts/arm.yaml"]
    assert main(["import", str(TUG), "-o", "flat", "--trust", "--flat"]) == 0
    assert not any("\nparts:" in path.read_text("utf-8") for path in Path("flat").glob("*.yaml"))


CASES = [case for case in cases() if case.has("robot.xacro")]


def outcome(case: Case) -> str:
    """Return what becomes of a case of the table: kept, in part, flat; empty where xacro or the import refuse it."""
    with ready(case):
        packages = {one.name: one for one in Path("site").iterdir()} if Path("site").is_dir() else {}
        how = ReadOptions(arguments=case.arguments, packages=packages, environment=None, trust=True)
        imported = read_robot(Path("robot.xacro"), how)
        if imported.tree is None:
            return ""
        made = translate(Path("robot.xacro"), how, imported, URDF, Target(Path("descriptions/robot")))
    if not made.files:
        assert made.report
        return "flat"
    assert any(line.startswith("the same robot as xacro makes it") for line in made.report)
    return "in part" if any("written out" in line for line in made.report) else "kept"


@pytest.mark.slow
def test_some_rows_of_the_table_are_translated_or_flattened_with_a_reason() -> None:
    assert {outcome(case) for case in CASES[::6]} == {"kept", "in part", ""}


@pytest.mark.tier("fuzz")
def test_every_row_of_the_table_is_translated_or_flattened_with_a_reason() -> None:
    found = {case.name: outcome(case) for case in CASES}
    assert [name for name, end in found.items() if end == "flat"] == ["77-yaml-duplicate"], found


@pytest.mark.parametrize("name", ["46-macro", "97-choice-of-plugin"])
def test_a_row_of_the_table_is_kept(name: str) -> None:
    assert outcome(next(case for case in CASES if case.name == name)) == "kept"


WHEEL = (
    '<xacro:macro name="wheel" params="prefix parent *origin"><link name="${prefix}wheel"/>'
    '<joint name="${prefix}axle" type="continuous"><xacro:insert_block name="origin"/><parent link="${parent}"/>'
    '<child link="${prefix}wheel"/><axis xyz="0 1 0"/></joint></xacro:macro><link name="base"/>'
    '<xacro:wheel prefix="a_" parent="base"><origin xyz="0 0.25 0"/></xacro:wheel>'
)
HARDWARE = (
    '<xacro:macro name="control" params=""><ros2_control name="x"><hardware><plugin>slow/Slow</plugin>'
    + "".join(f'<param name="p{number}">{number}</param>' for number in range(99))
    + '</hardware></ros2_control></xacro:macro><link name="base"/><xacro:control/>'
)


# Faults that are planted in what the child process writes: the proof finds them.


@pytest.mark.parametrize(
    ("body", "right", "wrong", "reason"),
    [
        (WHEEL, '"#0.25"', '"#9"', "a_wheel moved"),
        (HARDWARE, "slow/Slow", "fast/Slow", "robot element ros2_control x plugin slow/Slow -> fast/Slow"),
    ],
)
def test_a_macro_that_is_translated_wrongly_is_written_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, body: str, right: str, wrong: str, reason: str
) -> None:
    expanded = translator._expand

    def planted(*words: Any) -> dict[str, Any]:
        answer = expanded(*words)
        made = json.dumps(answer["documents"]).replace(right, wrong if answer["macros"] else right)
        return {**answer, "documents": json.loads(made)}

    monkeypatch.setattr(translator, "_expand", planted)
    made = of(tmp_path, body)
    assert made.report[0].startswith("0 of 1 macro kept")
    assert f": not proven: {reason}" in made.report[1]
    assert wrong.strip('"') not in made.files["robot.yaml"]


def test_an_argument_that_is_not_followed_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    body = """<xacro:arg name="height" default="0.5"/><xacro:arg name="width" default="0.5"/>
      <link name="base"><visual><geometry><box size="$(arg width) 1 $(arg height)"/></geometry></visual></link>"""
    expanded = translator._expand

    def planted(*words: Any) -> dict[str, Any]:
        answer = expanded(*words)
        return {**answer, "documents": json.loads(json.dumps(answer["documents"]).replace("${height}", "${0.5}"))}

    monkeypatch.setattr(translator, "_expand", planted)
    made = of(tmp_path, body)
    assert {"arguments kept: width", "arguments replaced by their value: height (0.5)"} <= {*made.report}
    assert any(line.startswith("  height: not proven: ") for line in made.report)


@pytest.mark.usefixtures("home")
def test_a_use_with_an_argument_that_its_part_does_not_read_is_refused() -> None:
    text = (DATA / "translated" / "blocks_of_parts" / "expected" / "robot.yaml").read_text("utf-8")
    Path("robot.yaml").write_text(text.replace("xyz: [0, 0, 1]}}", "xyz: [0, 0, 1], yaw: 1}}", 1))
    assert any('"yaw"' in one.message for one in compile_robot(Path("robot.yaml")).diagnostics)


PLUGIN = "<gazebo><plugin filename='a.so' name='a'><parameters>$(find tool)/a.yaml</parameters></plugin></gazebo>"
MESH = (
    '<xacro:macro name="shown" params="file"><link name="${file}"><visual><geometry>'
    '<mesh filename="file://$(find tool)/meshes/${file}.stl"/></geometry></visual></link></xacro:macro>'
    '<xacro:shown file="a"/>'
)
JOINT = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'


@pytest.mark.parametrize("by_option", [False, True])
def test_a_folder_of_a_package_is_found_on_another_machine(
    home: Path, monkeypatch: pytest.MonkeyPatch, by_option: bool
) -> None:
    def words(place: str) -> list[str]:
        folder = home / place / "tool"
        folder.mkdir(parents=True)
        (folder / "package.xml").write_text("<package><name>tool</name></package>")
        if by_option:
            return ["--package", f"tool={folder}"]
        monkeypatch.setenv("ROS_PACKAGE_PATH", str(folder.parent))
        return []

    chosen = (
        MESH.replace("shown", "chosen").replace('params="', 'params="package ').replace("find tool", "find ${package}")
    )
    chosen = chosen.replace('file="a"', 'file="b" package="tool"')
    Path("robot.xacro").write_text(f"{HEAD}{PLUGIN}{MESH}{chosen}{JOINT}</robot>")
    assert main(["import", "robot.xacro", "-o", "made", "--trust", *words("here")]) == 0
    made = Path("made/robot.yaml").read_text()
    assert "<parameters>${find('tool')}/a.yaml</parameters>" in made
    assert "package://tool/meshes/${file}.stl" in made
    assert "package://${package}/meshes/${file}.stl" in made
    assert not any(str(home) in path.read_text("utf-8") for path in Path("made").iterdir())
    assert main(["all", "made", *words("there")]) == 0
    assert f"<parameters>{home}/there/tool/a.yaml</parameters>" in Path("outputs/made/r.urdf").read_text()


@pytest.mark.usefixtures("home")
def test_another_name_and_other_places_of_meshes() -> None:
    body = MESH.replace("file://$(find tool)/", "")
    Path("robot.xacro").write_text(f"{HEAD}{body}</robot>", "utf-8")
    assert main(["import", "robot.xacro", "-o", "made", "--trust", "--name", "van", "--meshes", "package://van"]) == 0
    made = Path("made/robot.yaml").read_text("utf-8")
    assert "robot: van\n" in made
    assert "package://van/meshes/${file}.stl" in made

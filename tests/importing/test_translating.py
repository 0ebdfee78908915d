"""A xacro becomes a description with its macros, arguments and files, proven for each combination of arguments."""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.imported import Outputs, ReadOptions
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.importing.xacro.expressions import Translator
from rosorin_compile.importing.xacro.translate import Translation, translate, translation_report
from rosorin_compile.importing.xacro.tree import Variable
from rosorin_compile.importing.xacro.verify import combinations
from rosorin_compile.importing.xacro.write_yaml import Target, Writer
from support.paths import DATA
from support.xacro_table import Case, cases, ready

pytest.importorskip("xacro")

TUG = DATA / "xacro_package" / "urdf" / "tug.urdf.xacro"
HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
URDF = Outputs({"urdf": {"file": "robot.urdf"}}, {}, {})


def translated(
    path: Path, arguments: dict[str, str] | None = None, packages: dict[str, Path] | None = None
) -> Translation:
    how = ReadOptions(arguments=arguments or {}, packages=packages or {}, trust=True)
    imported = read_robot(path, how)
    assert imported.tree is not None, imported.diagnostics
    return translate(path, how, imported, URDF, Target(Path("descriptions/robot")))


def of(here: Path, body: str) -> Translation:
    (here / "robot.xacro").write_text(f"{HEAD}{body}</robot>", "utf-8")
    return translated(here / "robot.xacro")


def test_a_package_keeps_its_structure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = translated(TUG)
    assert list(made.files) == [
        *("robot.yaml", "parts/common.yaml", "parts/wheel.yaml", "parts/arm.yaml", "parts/control.yaml"),
        "config/arm.yaml",
    ]
    assert made.kept == (
        *(
            "box_inertial",
            "cylinder_inertia",
            "wheel",
            "arm_joint",
            "arm",
            "wheel_interface",
            "tug_control",
        ),
    )
    assert made.written_out == ()
    assert made.arguments == ("prefix", "use_sim", "hardware", "with_arm", "arm_config", "lidar_xyz")
    assert (len(made.proven), made.possible, made.idle) == (16, 16, ("unused_macro",))
    robot = made.files["robot.yaml"]
    assert "  hardware: {type: text, default: real, one_of: [real, mock]}\n" in robot
    assert "  use_sim: {type: boolean, default: false}\n" in robot
    assert "  arm_config: {type: text, default: config/arm.yaml}\n" in robot
    assert "  # from axle to axle\n  wheel_base: 0.30\n" in robot
    assert "    rpy: [-90 deg, 0, 0]\n" in robot
    assert "nobody" not in robot
    assert "M_PI" not in "".join(made.files.values())
    assert "  # A driven wheel; reflect is -1 on the right.\n  wheel:\n" in made.files["parts/wheel.yaml"]
    assert "  box_inertial(mass, size_x, size_y, size_z):\n" in made.files["parts/common.yaml"]
    assert "${load(config)['joint_limits']}" in made.files["parts/arm.yaml"]


def test_what_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["import", str(TUG), "-o", "tug", "--trust"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-6:] == [
        "7 of 7 macros kept",
        "named values where they are called, because they only set properties: read_model",
        "left out, because nothing calls it: unused_macro",
        "arguments kept: prefix, use_sim, hardware, with_arm, arm_config and lidar_xyz",
        "the same robot as xacro makes it, with 16 combinations of its arguments",
        "next: rosorin-compile all tug",
    ]
    assert main(["all", "tug", "-o", "out/tug"]) == 0
    assert main(["import", str(TUG), "-o", "flat", "--trust", "--flat"]) == 0
    assert [
        one.name for one in Path("flat").glob("*.yaml") if "parts" in one.read_text("utf-8").split("\nlinks:")[0]
    ] == []


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
        assert made.reason
        return "flat"
    assert made.proven
    assert all(one.reason for one in made.written_out)
    return "in part" if made.written_out else "kept"


@pytest.mark.slow
def test_some_rows_of_the_table_are_translated_or_flattened_with_a_reason() -> None:
    assert {outcome(case) for case in CASES[::6]} == {"kept", "in part", ""}


@pytest.mark.tier("fuzz")
def test_every_row_of_the_table_is_translated_or_flattened_with_a_reason() -> None:
    found = {case.name: outcome(case) for case in CASES}
    assert Counter(found.values()) == {"kept": 63, "in part": 10, "": 14}, found


@pytest.mark.parametrize("name", ["46-macro", "55-macro-in-macro", "93-deep-prefixes", "97-choice-of-plugin"])
def test_a_row_of_the_table_is_kept(name: str) -> None:
    assert outcome(next(case for case in CASES if case.name == name)) == "kept"


WHEEL = (
    '<xacro:macro name="wheel" params="prefix parent *origin"><link name="${prefix}wheel"/>'
    '<joint name="${prefix}axle" type="continuous"><xacro:insert_block name="origin"/><parent link="${parent}"/>'
    '<child link="${prefix}wheel"/><axis xyz="0 1 0"/></joint></xacro:macro><link name="base"/>'
)


def test_a_prefix_a_parent_and_an_origin_are_those_of_the_use(tmp_path: Path) -> None:
    made = of(
        tmp_path,
        WHEEL + '<xacro:wheel prefix="left_" parent="base"><origin xyz="0 ${1/4} 0" rpy="0 ${pi/2} 0"/></xacro:wheel>',
    )
    robot = made.files["robot.yaml"]
    assert "      axle: {type: continuous, parent: mount, child: wheel, axis: [0, 1, 0]}\n" in robot
    assert '  left: {part: wheel, parent: base, xyz: [0, "${1 / 4}", 0], rpy: [0, 90 deg, 0]}\n' in robot


def test_what_has_no_word_is_flattened_alone(tmp_path: Path) -> None:
    call = '<xacro:wheel prefix="left_" parent="base"><origin xyz="0 0 0"/></xacro:wheel>'
    odd = """<link name="${list(map(lambda x: x + 'd', ['od']))[0]}"/><joint name="j" type="fixed">"""
    odd += '<parent link="base"/><child link="odd"/></joint>'
    made = of(tmp_path, WHEEL + call + odd)
    assert made.kept == ("wheel",)
    (lost,) = made.written_out
    assert lost.flat
    assert lost.reason == "lambda x: x + 'd' cannot be translated"
    assert lost.span is not None
    assert "  odd: {}\n" in made.files["robot.yaml"]


def test_a_difference_is_seen_and_writes_the_macro_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A translation that is wrong is not taken: the macro at fault is written out, and the robot is right."""
    right = Writer.use

    def wrong(self, use, section, file, path):  # type: ignore[no-untyped-def]
        right(self, use, section, file, path)
        for entry in section.values():
            if "xyz" in entry:
                entry["xyz"] = ["9", "9", "9"]

    monkeypatch.setattr(Writer, "use", wrong)
    made = of(tmp_path, WHEEL + '<xacro:wheel prefix="a_" parent="base"><origin xyz="0 0.25 0"/></xacro:wheel>')
    assert made.kept == ()
    assert [one.name for one in made.written_out] == ["wheel"]
    assert made.written_out[0].reason.startswith("not proven: ")
    assert "9" not in made.files["robot.yaml"].partition("links:")[2]


def test_an_argument_that_is_not_followed_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    body = """<xacro:arg name="height" default="0.5"/><xacro:arg name="width" default="0.5"/>
      <link name="base"><visual><geometry><box size="$(arg width) 1 $(arg height)"/></geometry></visual></link>"""
    assert of(tmp_path, body).arguments == ("height", "width")
    right = Translator.reference

    def wrong(self: Translator, variable: Variable) -> ast.expr:
        made = right(self, variable)
        return ast.Constant(0.5) if variable.name == "height" else made  # what it is by default

    monkeypatch.setattr(Translator, "reference", wrong)
    made = of(tmp_path, body)
    assert (made.arguments, made.fixed) == (("width",), (("height", "0.5"),))
    reason = "  height: with another value of it the robot is another than xacro makes (robot.xacro:1)"
    assert reason in translation_report(made)


def test_combinations_are_bounded() -> None:
    choices = {f"a{number}": ["true", "false"] for number in range(10)}
    rows, possible = combinations(choices)
    assert possible == 1024
    assert len(rows) == 12
    assert rows[0] == ()
    assert all(((f"a{number}", "false"),) in rows for number in range(10))


def test_a_file_that_its_package_has_is_included_from_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wheel = """<xacro:macro name="wheel" params="prefix parent y">
      <link name="${prefix}wheel"/>
      <joint name="${prefix}axle" type="continuous">
        <parent link="${parent}"/><child link="${prefix}wheel"/><origin xyz="0 ${y} 0"/><axis xyz="0 1 0"/>
      </joint></xacro:macro>"""
    robot = """<xacro:include filename="$(find acme_parts)/urdf/wheel.xacro"/><link name="base"/>
      <xacro:wheel prefix="left_" parent="base" y="0.2"/>"""
    for package, file, body in (("acme_parts", "wheel", wheel), ("acme_rover", "rover", robot)):
        (tmp_path / package / "urdf").mkdir(parents=True)
        (tmp_path / package / "urdf" / f"{file}.xacro").write_text(f"{HEAD}{body}</robot>", "utf-8")
        (tmp_path / package / "package.xml").write_text(f"<package><name>{package}</name></package>", "utf-8")
    path, folder = tmp_path / "acme_rover" / "urdf" / "rover.xacro", tmp_path / "acme_rover" / "descriptions" / "rover"
    monkeypatch.chdir(tmp_path)

    def made() -> Translation:
        how = ReadOptions(trust=True)
        return translate(path, how, read_robot(path, how), URDF, Target(folder))

    first = made()
    assert list(first.files) == ["robot.yaml", "wheel.yaml"]
    there = tmp_path / "acme_parts" / "descriptions" / "parts" / "wheel.yaml"
    there.parent.mkdir(parents=True)
    there.write_text(first.files["wheel.yaml"], "utf-8")
    again = made()
    assert (list(again.files), again.kept) == (["robot.yaml"], ("wheel",))
    assert "include: [package://acme_parts/descriptions/parts/wheel.yaml]" in again.files["robot.yaml"]
    there.write_text(f"{first.files['wheel.yaml']}# another\n", "utf-8")
    assert list(made().files) == ["robot.yaml", "wheel.yaml"]


def test_an_argument_that_chooses_a_file_has_the_files_that_there_are(tmp_path: Path) -> None:
    for name in ("pair", "triple"):
        (tmp_path / f"{name}_tool.xacro").write_text(f'{HEAD}<link name="{name}"/></robot>', "utf-8")
    made = of(tmp_path, '<xacro:arg name="tool" default="pair"/><xacro:include filename="$(arg tool)_tool.xacro"/>')
    assert "  tool: {type: text, default: pair, one_of: [pair, triple]}\n" in made.files["robot.yaml"]
    assert made.possible == 2
    assert made.files["triple_tool.yaml"] == "links:\n  triple:\n    if: ${tool == 'triple'}\n"


def test_the_lines_about_a_flat_robot_say_why() -> None:
    assert list(translation_report(Translation({}, reason="an include with ns"))) == [
        "flat, without macros and arguments: an include with ns"
    ]


def test_another_name_and_other_places_of_meshes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    body = '<xacro:macro name="body" params="file"><link name="hull"><visual><geometry>'
    body += (
        '<mesh filename="meshes/${file}.stl"/></geometry></visual></link></xacro:macro><xacro:body file="a"/></robot>'
    )
    Path("robot.xacro").write_text(HEAD + body, "utf-8")
    assert main(["import", "robot.xacro", "-o", "made", "--trust", "--name", "van", "--meshes", "package://van"]) == 0
    made = Path("made/robot.yaml").read_text("utf-8")
    assert "robot: van\n" in made
    assert "package://van/meshes/${file}.stl" in made

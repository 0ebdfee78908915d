"""What is said of a xacro stands where somebody can change it, all of it at once, and holds on any machine."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from rosorin_compile import read
from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.messages import arrange

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("home")]

HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">\n'


def _write(name: str, text: str) -> None:
    Path(name).parent.mkdir(parents=True, exist_ok=True)
    Path(name).write_text(text, "utf-8")


def _read(**said: object) -> Imported:
    return read_robot(Path("robot.xacro"), ReadOptions(**{"environment": {}, "trust": True, **said}))  # type: ignore[arg-type]


def _told(imported: Imported) -> list[str]:
    return [_line(one) for one in arrange(imported.diagnostics)]


def _line(one: Diagnostic) -> str:
    assert one.span is not None
    return f"{one.span.source.path}:{one.span.line}:{one.span.column}: {one.rule}: {one.message}"


def test_what_a_macro_makes_is_told_in_its_file_with_the_calls() -> None:
    _write(
        "parts/wheel.xacro",
        f"""{HEAD}<xacro:macro name="tyre" params="name radius">
  <link name="${{name}}"><visual><geometry><sphere radius="${{radius}}"/></geometry></visual></link>
</xacro:macro>
<xacro:macro name="wheel" params="name">
  <xacro:tyre name="${{name}}" radius="big"/>
</xacro:macro>
</robot>""",
    )
    _write("robot.xacro", f'{HEAD}<xacro:include filename="parts/wheel.xacro"/>\n<xacro:wheel name="left"/></robot>')
    imported = _read()
    assert _told(imported) == [
        'parts/wheel.xacro:3:58: not-a-number: radius of <sphere> of <link name="left">: "big" is not a number'
    ]
    calls = imported.diagnostics[-1].related
    assert [(one.message, one.span and (one.span.source.path, one.span.line)) for one in calls] == [
        ('when expanding the macro "tyre"', ("parts/wheel.xacro", 6)),
        ('when expanding the macro "wheel"', ("robot.xacro", 3)),
    ]


def test_a_name_made_twice_shows_both_calls() -> None:
    macro = '<xacro:macro name="part" params="n">\n<link name="${n}"/></xacro:macro>'
    _write("robot.xacro", f'{HEAD}{macro}\n<xacro:part n="a"/>\n<xacro:part n="a"/>\n</robot>')
    shown = report(_read().diagnostics)
    assert "robot.xacro:3:13: error[duplicate-name]" in shown
    assert "robot.xacro:5:2" in shown


@pytest.mark.parametrize(
    ("inner", "told"),
    [
        ('<xacro:nothing a="1"/>', "3:1: xacro-error: "),
        ('<link name="a"><visual name="${1 / 0}"/></link>', "3:30: xacro-error: "),
        (
            '<xacro:macro name="m" params="a b"><link name="${a}"/></xacro:macro>\n<xacro:m a="1"/>',
            "4:2: xacro-error: ",
        ),
        (
            '<xacro:macro name="m" params="n">\n<link name="${n + b}"/></xacro:macro><xacro:m n="1"/>',
            "4:13: xacro-error: ",
        ),
        ('<xacro:insert_block name="body"/>', "3:2: xacro-error: "),
        ('<xacro:if><link name="a"/></xacro:if>', "3:2: xacro-error: "),
        ('<xacro:include filename="nowhere.xacro"/>', "3:26: file-unreadable: "),
        ('<xacro:include filename="$(find absent)/one.xacro"/>', '3:27: package-missing: the package "absent"'),
        ('<link name="$(arg prefix)"/>', "3:13: xacro-error: xacro cannot expand the file: Undefined substitution"),
        ('<link name="$(env CELL)"/>', "3:13: xacro-error: xacro cannot expand the file: environment variable 'CELL'"),
    ],
)
def test_an_error_in_an_included_file_stands_there(inner: str, told: str) -> None:
    _write("parts/inner.xacro", f"{HEAD}<!-- of others -->\n{inner}\n</robot>")
    _write("robot.xacro", f'{HEAD}<link name="base"/>\n<xacro:include filename="parts/inner.xacro"/></robot>')
    imported = _read()
    (line,) = _told(imported)
    assert line.startswith(f"parts/inner.xacro:{told}"), line
    assert "robot.xacro:1:1" in report(imported.diagnostics)  # includes it


@pytest.mark.parametrize(
    ("written", "named"),
    [
        ("file://$(find arm)/meshes/a.stl", "package://arm/meshes/a.stl"),
        ("$(find arm)/meshes/a.stl", "package://arm/meshes/a.stl"),
        ("file://$(dirname)/meshes/a.stl", "meshes/a.stl"),
        ("$(dirname)/../a.stl", "../a.stl"),
        ("package://arm/a.stl", "package://arm/a.stl"),
        ("file:///opt/meshes/a.stl", "file:///opt/meshes/a.stl"),
        ("meshes/a.stl", "meshes/a.stl"),
    ],
)
def test_a_mesh_is_named_as_on_any_machine(written: str, named: str) -> None:
    _write("arm/package.xml", "<package><name>arm</name></package>")
    mesh = f'<link name="a"><visual><geometry><mesh filename="{written}"/></geometry></visual></link>'
    _write("robot.xacro", f"{HEAD}{mesh}</robot>")
    imported = _read(packages={"arm": Path("arm")})
    assert imported.tree is not None, report(imported.diagnostics)
    assert imported.tree["links"]["a"]["visual"][0]["mesh"]["file"] == named


def test_a_mesh_beside_a_xacro_of_a_package_belongs_to_the_package() -> None:
    _write("arm/package.xml", "<package><name>my_arm</name></package>")
    mesh = '<link name="a"><visual><geometry><mesh filename="file://$(dirname)/../a.stl"/></geometry></visual></link>'
    _write("arm/urdf/a.xacro", f"{HEAD}{mesh}</robot>")
    imported = read_robot(Path("arm/urdf/a.xacro"), ReadOptions(environment={}))
    assert imported.tree is not None
    assert imported.tree["links"]["a"]["visual"][0]["mesh"]["file"] == "package://my_arm/a.stl"


def test_a_file_that_is_trusted_runs_without_a_word() -> None:
    _write("robot.xacro", f'{HEAD}<link name="${{1}}"/></robot>')
    assert [one.rule for one in read("robot.xacro").diagnostics] == ["xacro-runs-code"]
    assert read("robot.xacro", trust=True).diagnostics == []


def test_a_path_of_this_machine_in_what_is_kept_is_told() -> None:
    plugin = "<gazebo>\n<plugin><parameters>$(find arm)/config/a.yaml</parameters></plugin></gazebo>"
    _write("arm/package.xml", "<package><name>arm</name></package>")
    _write("robot.xacro", f'{HEAD}<link name="a"/>\n{plugin}</robot>')
    (told,) = _read(packages={"arm": Path("arm")}).diagnostics
    assert (told.rule, told.span and told.span.line) == ("import-machine-path", 4)
    assert told.message == f"<parameters> names a file of this machine: {Path.cwd()}/arm/config/a.yaml"
    assert main(["import", "robot.xacro", "-o", "made", "--trust", "--flat", "--package", "arm=arm"]) == 0
    assert not any(str(Path.cwd()) in path.read_text("utf-8") for path in Path("made").iterdir())
    for folder in (f"{Path.cwd()}/arm", "package://arm"):
        artifacts = compile_robot(Path("made/robot.yaml")).artifacts
        assert any(f"<parameters>{folder}/config/a.yaml<" in artifact.text for artifact in artifacts)
        shutil.rmtree("arm", ignore_errors=True)


def test_what_xacro_says_names_the_file_as_people_do() -> None:
    _write("parts/a.xacro", f'{HEAD}<xacro:property name="pi" value="3"/></robot>')
    _write("robot.xacro", f'{HEAD}<xacro:include filename="parts/a.xacro"/><link name="a"/></robot>')
    assert [one.message for one in _read().diagnostics] == ["warning: redefining global symbol: pi"]

"""Reading xacro: what the library makes of a file without ROS, the warning before, and the places of errors."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.xacro import expand as reader
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.messages import arrange
from support.commands import write_files

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("home")]

HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">\n'
ARM = f"""<?xml version="1.0"?>
{HEAD}  <xacro:arg name="prefix" default="left_"/>
  <xacro:arg name="size" default="1"/>
  <xacro:include filename="parts/part.xacro"/>
  <!-- the base -->
  <link name="base"/>
  <xacro:part name="$(arg prefix)arm" size="${{$(arg size) / 4}}"/>
  <xacro:if value="${{$(arg size) > 2}}"><gazebo reference="base"/></xacro:if>
</robot>
"""
PART = f"""{HEAD}  <xacro:property name="table" lazy_eval="false" value="${{xacro.load_yaml('table.yaml')}}"/>
  <xacro:macro name="part" params="name size">
    <link name="${{name}}"><visual><geometry><sphere radius="${{size}}"/></geometry></visual></link>
    <joint name="${{name}}_joint" type="fixed"><parent link="base"/><child link="${{name}}"/>
      <origin xyz="0 0 ${{table.height}}"/></joint>
  </xacro:macro>
</robot>
"""


def expand(path: Path | str, **options: object) -> ImportedRobot:
    return read_robot(Path(path), ReadOptions(**{"environment": {}, "trust": True, **options}))  # type: ignore[arg-type]


def tree_of(imported: ImportedRobot) -> dict:
    assert imported.tree is not None, report(arrange(imported.diagnostics))
    return imported.tree


def expanded(body: str, **options: object) -> ImportedRobot:
    """Write the body of robot.xacro, and read it."""
    write_files(Path(), {"robot.xacro": f"{HEAD}{body}</robot>"})
    return expand("robot.xacro", **options)


def lines(imported: ImportedRobot) -> list[str]:
    return [line(one) for one in arrange(imported.diagnostics)]


def line(one: Diagnostic) -> str:
    assert one.span is not None
    return f"{one.span.source.path}:{one.span.line}:{one.span.column}: {one.rule}: {one.message}"


@pytest.fixture
def arm() -> Path:
    write_files(Path(), {"arm.xacro": ARM, "parts/part.xacro": PART, "parts/table.yaml": "height: 0.25\n"})
    return Path("arm.xacro")


def test_arguments_includes_macros_and_tables(arm):
    imported = expand(arm, arguments={"size": "3"})
    tree = tree_of(imported)
    assert tree["links"]["left_arm"]["visual"][0]["sphere"] == {"radius": 0.75}
    assert tree["joints"]["left_arm_joint"]["xyz"] == [0, 0, 0.25]
    assert tree["urdf_elements"] == ['<gazebo reference="base"/>']
    assert [str(file) for file in imported.files] == ["arm.xacro", "parts/part.xacro", "parts/table.yaml"]
    span = tree["joints"]["left_arm_joint"]["xyz"].value_spans[2]
    assert (span.source.path, span.line) == ("parts/part.xacro", 6)
    assert span.source.line(span.line)[span.column - 1 :][: span.length] == "0 0 ${table.height}"
    assert tree["links"].key_spans["base"].source.path == "arm.xacro"


def test_expanded_text_is_what_xacro_prints_every_time(arm, monkeypatch):
    code = "import sys, xacro; sys.argv[1:] = ['arm.xacro', 'size:=3']; xacro.main()"
    printed = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    texts = set()
    for seed in ("1", "2"):
        monkeypatch.setitem(os.environ, "PYTHONHASHSEED", seed)
        texts.add(reader._expand(arm, ReadOptions(arguments={"size": "3"}, environment={}))["text"])
    (text,) = texts
    banner = [line for line in printed.splitlines() if "====" in line or line.startswith("<!-- |")]
    assert len(banner) == 4
    assert text.splitlines() == [line for line in printed.splitlines() if line not in banner]


def test_a_warning_comes_once_and_before_anything_is_run(arm, monkeypatch):
    first = expand(arm, trust=False).diagnostics[0]
    assert (first.rule, first.severity) == ("xacro-runs-code", "warning")
    assert first.message == "arm.xacro is expanded by xacro, which runs any Python code that the file contains"
    assert expand(arm).diagnostics == []
    reported: list[Diagnostic] = []
    assert expand(arm, trust=False, tell=reported.append).diagnostics == []
    assert [one.rule for one in reported] == ["xacro-runs-code"]

    def stop(_: Diagnostic) -> None:
        raise InterruptedError

    monkeypatch.setattr(reader, "_expand", lambda *_: pytest.fail("it ran"))
    with pytest.raises(InterruptedError):
        expand(arm, trust=False, tell=stop)


def test_unknown_arguments(arm):
    (found,) = lines(expand(arm, arguments={"prefx": "x"}))
    assert found == 'arm.xacro:2:2: unknown-argument: arm.xacro has no argument "prefx"'
    body = '<xacro:if value="0"><xacro:arg name="rare" default="1"/></xacro:if><link name="a"/>'
    assert tree_of(expanded(body, arguments={"rare": "2"}))


def test_find_env_optenv_and_dirname_without_ros():
    write_files(Path(), {
        "src/one/urdf/arm.xacro": f"""{HEAD}
  <xacro:include filename="$(find two)/urdf/base.xacro"/>
  <xacro:include filename="package://two/urdf/more.xacro"/>
  <xacro:include filename="$(dirname)/own.xacro"/>
  <link name="$(env SIDE)_$(optenv NONE some)_${{'$(dirname)'.split('/')[-1]}}"/>
</robot>""",
        "src/one/package.xml": "<package><name>one</name></package>",
        "src/one/urdf/own.xacro": f'{HEAD}<xacro:property name="own" value="1"/></robot>',
        "src/folder/package.xml": "<package><name>two</name></package>",
        "src/folder/urdf/base.xacro": f"{HEAD}</robot>",
        "src/folder/urdf/more.xacro": f"{HEAD}</robot>",
    })  # fmt: skip
    imported = expand("src/one/urdf/arm.xacro", environment={"SIDE": "left"})
    assert list(tree_of(imported)["links"]) == ["left_some_urdf"]
    assert [file.name for file in imported.files] == ["arm.xacro", "base.xacro", "more.xacro", "own.xacro"]


def test_a_package_of_an_option_precedes_one_that_is_adjacent_and_one_of_a_prefix():
    name = f'{HEAD}<xacro:property name="n" value="NAME"/></robot>'
    write_files(Path(), {
        "two/package.xml": "<package><name>two</name></package>",
        "two/name.xacro": name.replace("NAME", "adjacent"),
        "elsewhere/name.xacro": name.replace("NAME", "option"),
        "prefix/share/three/name.xacro": name.replace("NAME", "prefix"),
    })  # fmt: skip
    body = '<xacro:include filename="$(find two)/name.xacro"/><link name="${n}"/>'
    assert list(tree_of(expanded(body))["links"]) == ["adjacent"]
    assert list(tree_of(expanded(body, packages={"two": Path("elsewhere")}))["links"]) == ["option"]
    prefix = {"AMENT_PREFIX_PATH": str(Path("prefix").absolute())}
    assert list(tree_of(expanded(body.replace("two", "three"), environment=prefix))["links"]) == ["prefix"]


def test_files_with_entities_or_defects_are_refused(arm, monkeypatch):
    bomb = '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    write_files(Path(), {"parts/part.xacro": bomb + PART.replace("<link", "&b;<link")})
    assert lines(expand(arm))[-1].startswith("parts/part.xacro:1:17: xml-doctype: ")
    write_files(Path(), {"parts/part.xacro": PART.replace("</link>", "</lnk>")})
    assert "xml-syntax: </lnk> does not close <link>" in lines(expand(arm))[-1]
    monkeypatch.setattr(reader, "_expand", lambda *_: pytest.fail("it ran"))
    arm.write_text(f'<!DOCTYPE robot [<!ENTITY a "b">]>{HEAD}<link name="${{1}}"/></robot>', "utf-8")
    assert [one.rule for one in expand(arm).diagnostics] == ["xml-doctype"]


@pytest.mark.parametrize(
    ("inner", "words"),
    [
        ("<xacro:macro name='m' params='n'><xacro:m n='${n+1}'/></xacro:macro><xacro:m n='1'/>", "without end"),
        ("<link name=\"${'a' * 10**11}\"/>", "more memory"),
        ("<link name=\"${[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == 'Quitter']}\"/>", ""),
        ("<xacro:message/>", "message"),
    ],
)
def test_files_that_break_the_child_break_nothing_else(inner, words):
    imported = expanded(inner)
    assert imported.tree is None
    assert words in imported.diagnostics[-1].message


@pytest.mark.parametrize(
    ("program", "words"),
    [
        ("import sys\nsys.modules['xacro'] = None\n" + reader._CHILD, "xacro, which expands .xacro files, is not inst"),
        ("import os; os._exit(7)", "xacro broke down: the process ended with 7"),
        ("import time; time.sleep(9)", "it takes more than 1 s"),
        (
            "from rosorin_compile.importing.xacro.child import _limit; import signal; _limit(1);"
            "signal.signal(signal.SIGPROF, signal.SIG_IGN)\nwhile True: pass",
            "it takes more than 1 s",
        ),
    ],
)
def test_a_child_that_is_broken_dies_or_hangs(arm, monkeypatch, program, words):
    monkeypatch.setattr(reader, "_CHILD", program)
    monkeypatch.setattr(reader, "MAX_SECONDS", 1)
    monkeypatch.setattr(reader, "_START", 1)
    assert words in lines(expand(arm))[-1]


MULTIPLY = "".join(f'<xacro:macro name="m{n}">{f"<xacro:m{n - 1}/>" * 10}</xacro:macro>' for n in range(1, 10))
BOMBS = {
    "number": '<link name="a${9**9**9}"/>',
    "list": '<link name="a${len([1 for x in range(10**12)])}"/>',
    "macros": f'<xacro:macro name="m0"/>{MULTIPLY}<xacro:m9/>',
}


@pytest.mark.landing("fuzz", "macros")
@pytest.mark.parametrize("bomb", BOMBS)
def test_a_file_that_calculates_without_end_is_ended_and_told(bomb, monkeypatch, capsys):
    write_files(Path(), {"arm.xacro": f"{HEAD}\n{BOMBS[bomb]}</robot>"})
    monkeypatch.setenv("ROSORIN_COMPILE_XACRO_SECONDS", "60")  # the option replaces it
    assert main(["import", "arm.xacro", "-o", "out", "--trust", "--xacro-seconds", "1"]) == 1
    printed = capsys.readouterr().err
    assert "arm.xacro:3:" in printed
    assert "error[xacro-error]: xacro cannot expand the file: it takes more than 1 s\n" in printed
    assert "--xacro-seconds S" in printed


def test_output_of_the_file_does_not_mix_with_the_answer():
    assert list(tree_of(expanded("<link name=\"a${xacro.message('{{')}\"/>"))["links"]) == ["a"]


def test_nothing_of_the_current_folder_is_run(arm):
    for name in ("json", "xacro", "yaml", "resource", "rosorin_compile"):
        Path(f"{name}.py").write_text("raise SystemExit('evil')\n", "utf-8")
    assert tree_of(expand(arm))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_the_process_that_expands_ends_with_the_one_that_asks():
    body = '<xacro:property name="huge" value="${9**9**9}"/><link name="l${huge}"/>'
    write_files(Path(), {"huge.xacro": f"{HEAD}{body}</robot>"})
    command = [sys.executable, "-m", "rosorin_compile", "import", "huge.xacro", "-o", "made"]
    parent = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children")
    ends = time.monotonic() + 30
    while not (pids := children.read_text().split()) and time.monotonic() < ends:
        time.sleep(0.05)
    assert pids
    time.sleep(3)  # until it has asked the system for that
    parent.kill()
    parent.wait()
    ends = time.monotonic() + 10
    while any(Path(f"/proc/{pid}").exists() for pid in pids) and time.monotonic() < ends:
        time.sleep(0.05)
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)


def test_what_a_macro_makes_is_told_in_its_file_with_the_calls() -> None:
    write_files(Path(), {
        "parts/wheel.xacro": f"""{HEAD}<xacro:macro name="tyre" params="name radius">
  <link name="${{name}}"><visual><geometry><sphere radius="${{radius}}"/></geometry></visual></link>
</xacro:macro>
<xacro:macro name="wheel" params="name">
  <xacro:tyre name="${{name}}" radius="big"/>
</xacro:macro>
</robot>""",
    })  # fmt: skip
    imported = expanded('<xacro:include filename="parts/wheel.xacro"/>\n<xacro:wheel name="left"/>')
    assert lines(imported) == [
        'parts/wheel.xacro:3:58: not-a-number: radius of <sphere> of <link name="left">: "big" is not a number'
    ]
    calls = imported.diagnostics[-1].related
    assert [(one.message, one.span and (one.span.source.path, one.span.line)) for one in calls] == [
        ('when expanding the macro "tyre"', ("parts/wheel.xacro", 6)),
        ('when expanding the macro "wheel"', ("robot.xacro", 3)),
    ]
    macro = '<xacro:macro name="part" params="n">\n<link name="${n}"/></xacro:macro>'
    shown = report(expanded(f'{macro}\n<xacro:part n="a"/>\n<xacro:part n="a"/>\n').diagnostics)
    assert "robot.xacro:3:13: error[duplicate-name]" in shown
    assert "robot.xacro:5:2" in shown


FAILED = "xacro-error: xacro cannot expand the file:"


@pytest.mark.parametrize(
    ("inner", "message"),
    [
        ('<xacro:nothing a="1"/>', f"3:1: {FAILED} unknown macro name"),
        ('<link name="a"><visual name="${1 / 0}"/></link>', f"3:30: {FAILED} division"),
        ('<xacro:macro name="m" params="a"><link name="${a}"/></xacro:macro>\n<xacro:m/>', f"4:2: {FAILED} Undefined"),
        ('<xacro:macro name="m" params="n">\n<link name="${n + b}"/></xacro:macro><xacro:m n="1"/>', f"4:13: {FAILED}"),
        ('<xacro:insert_block name="body"/>', f"3:2: {FAILED} Undefined block"),
        ('<xacro:if><link name="a"/></xacro:if>', f"3:2: {FAILED}"),
        ('<link name="$(arg prefix)"/>', f"3:13: {FAILED} Undefined substitution argument prefix"),
        ('<link name="$(env CELL)"/>', f"3:13: {FAILED} environment variable 'CELL' is not set"),
        ('<xacro:include filename="nowhere.xacro"/>', "3:26: file-unreadable: "),
        (
            '<xacro:include filename="$(find absent)/a.xacro"/>',
            '3:27: package-missing: the ROS package "absent" is not',
        ),
    ],
)
def test_an_error_in_an_included_file_is_shown_there(inner: str, message: str) -> None:
    write_files(Path(), {"parts/inner.xacro": f"{HEAD}<!-- of others -->\n{inner}\n</robot>"})
    imported = expanded('<link name="base"/>\n<xacro:include filename="parts/inner.xacro"/>')
    (found,) = lines(imported)
    assert found.startswith(f"parts/inner.xacro:{message}"), found
    assert "robot.xacro:1:1" in report(imported.diagnostics)  # includes it


@pytest.mark.parametrize(
    ("written", "named"),
    [
        ("file://$(find arm)/meshes/a.stl", "package://arm/meshes/a.stl"),
        ("$(find arm)/meshes/a.stl", "package://arm/meshes/a.stl"),
        ("file://$(dirname)/meshes/a.stl", "package://mine/urdf/meshes/a.stl"),
        ("$(dirname)/../a.stl", "package://mine/a.stl"),
        ("package://arm/a.stl", "package://arm/a.stl"),
        ("file:///opt/meshes/a.stl", "file:///opt/meshes/a.stl"),
        ("meshes/a.stl", "meshes/a.stl"),
    ],
)
def test_a_mesh_is_named_as_on_any_machine(written: str, named: str) -> None:
    mesh = f'<link name="a"><visual><geometry><mesh filename="{written}"/></geometry></visual></link>'
    write_files(Path(), {
        "arm/package.xml": "<package><name>arm</name></package>",
        "mine/package.xml": "<package><name>mine</name></package>",
        "mine/urdf/a.xacro": f"{HEAD}{mesh}</robot>",
    })  # fmt: skip
    tree = tree_of(expand("mine/urdf/a.xacro", packages={"arm": Path("arm")}))
    assert tree["links"]["a"]["visual"][0]["mesh"]["file"] == named
    relative = tree_of(
        expanded('<link name="a"><visual><geometry><mesh filename="$(dirname)/../a.stl"/></geometry></visual></link>')
    )
    assert relative["links"]["a"]["visual"][0]["mesh"]["file"] == "../a.stl"


def test_a_path_of_this_machine_in_what_is_kept_is_told() -> None:
    write_files(Path(), {"arm/package.xml": "<package><name>arm</name></package>"})
    plugin = "<gazebo>\n<plugin><parameters>$(find arm)/config/a.yaml</parameters></plugin></gazebo>"
    (found,) = lines(expanded(f'<link name="a"/>\n{plugin}', packages={"arm": Path("arm")}))
    message = f"<parameters> names a file of this machine: {Path.cwd()}/arm/config/a.yaml"
    assert found == f"robot.xacro:4:10: import-machine-path: {message}"
    assert main(["import", "robot.xacro", "-o", "made", "--trust", "--flat", "--package", "arm=arm"]) == 0
    assert not any(str(Path.cwd()) in path.read_text("utf-8") for path in Path("made").iterdir())
    for folder in (f"{Path.cwd()}/arm", "package://arm"):
        artifacts = compile_robot(Path("made/robot.yaml")).artifacts
        assert any(f"<parameters>{folder}/config/a.yaml<" in artifact.text for artifact in artifacts)
        shutil.rmtree("arm", ignore_errors=True)


def test_what_xacro_prints_is_a_note() -> None:
    body = '<xacro:include filename="none*.xacro"/><xacro:property name="pi" value="3"/><link name="a"/>'
    found = [one.message for one in expanded(body).diagnostics]
    assert "warning: redefining global symbol: pi" in found
    assert any("matched no files" in one for one in found)

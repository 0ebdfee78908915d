"""Reading xacro: what the library makes of a file, without ROS, told before it runs, and every fault in words."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.xacro import expand as reader
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.system import pip_install

pytestmark = pytest.mark.slow

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


def write(folder: Path, **files: str) -> Path:
    """Write files, a double underscore in a name for each slash; return the first one."""
    paths = []
    for name, text in files.items():
        stem, _, suffix = name.replace("__", "/").rpartition("_")
        path = folder / f"{stem}.{suffix}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
        paths.append(path)
    return paths[0]


def expand(path: Path, **said: object) -> Imported:
    return read_robot(path, ReadOptions(**{"environment": {}, **said}))  # type: ignore[arg-type]


def tree_of(imported: Imported) -> dict:
    assert imported.tree is not None, report(arrange(imported.diagnostics))
    return imported.tree


def told(imported: Imported) -> list[str]:
    return [
        f"{d.severity}[{d.rule}]: {d.message} ({d.help})" for d in imported.diagnostics if d.rule != "xacro-runs-code"
    ]


@pytest.fixture
def arm(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, arm_xacro=ARM, parts__part_xacro=PART, parts__table_yaml="height: 0.25\n")
    return Path("arm.xacro")


def test_arguments_includes_macros_and_tables(arm):
    imported = expand(arm, arguments={"size": "3"})
    tree = tree_of(imported)
    assert tree["links"]["left_arm"]["visual"][0]["sphere"] == {"radius": 0.75}
    assert tree["joints"]["left_arm_joint"]["xyz"] == [0, 0, 0.25]
    assert tree["urdf_elements"] == ['<gazebo reference="base"/>']
    assert [str(file) for file in imported.files] == ["arm.xacro", "parts/part.xacro", "parts/table.yaml"]


def test_places_are_those_of_the_files_that_people_have(arm):
    tree = tree_of(expand(arm))
    span = tree["joints"]["left_arm_joint"]["xyz"].value_spans[2]
    assert (span.source.path, span.line) == ("parts/part.xacro", 6)
    assert span.source.line(span.line)[span.column - 1 :][: span.length] == "0 0 ${table.height}"
    assert tree["links"].key_spans["base"].source.path == "arm.xacro"


def test_expanded_text_is_what_xacro_prints(arm):
    code = "import sys, xacro; sys.argv[1:] = ['arm.xacro', 'size:=3']; xacro.main()"
    printed = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    text = reader._expand(arm, ReadOptions(arguments={"size": "3"}, environment={}))["text"]
    banner = [line for line in printed.splitlines() if "====" in line or line.startswith("<!-- |")]
    assert len(banner) == 4
    assert text.splitlines() == [line for line in printed.splitlines() if line not in banner]


def test_warning_comes_before_anything_is_run(arm, tmp_path):
    write(tmp_path, table_yaml="x: 1\n")
    imported = expand(arm)
    first = imported.diagnostics[0]
    assert (first.rule, first.severity) == ("xacro-runs-code", "warning")
    assert first.message == "arm.xacro is expanded by xacro, which can run Python code of its author"


def test_warning_can_be_told_at_once_and_stop_the_run(arm, monkeypatch):
    class Stop(Exception):
        pass

    def stop(diagnostic: Diagnostic) -> None:
        raise Stop(diagnostic.rule)

    monkeypatch.setattr(reader, "_expand", lambda *_: pytest.fail("it ran"))
    with pytest.raises(Stop, match="xacro-runs-code"):
        expand(arm, tell=stop)


def test_what_was_told_is_not_told_again(arm):
    said: list[Diagnostic] = []
    assert tree_of(expand(arm, tell=said.append))
    assert [d.rule for d in said] == ["xacro-runs-code"]
    assert "xacro-runs-code" not in [d.rule for d in expand(arm, tell=said.append).diagnostics]


def test_unknown_argument_names_the_legal_ones(arm):
    found = told(expand(arm, arguments={"prefx": "x"}))
    assert found == ['error[unknown-argument]: arm.xacro has no argument "prefx" (did you mean "prefix"?)']


def test_argument_that_only_another_branch_declares_is_known(tmp_path):
    text = f'{HEAD}<xacro:if value="0"><xacro:arg name="rare" default="1"/></xacro:if><link name="a"/></robot>'
    assert tree_of(expand(write(tmp_path, a_xacro=text), arguments={"rare": "2"}))


def test_find_env_optenv_and_dirname_without_ros(tmp_path):
    path = write(
        tmp_path,
        src__one__urdf__arm_xacro=f"""{HEAD}
  <xacro:include filename="$(find two)/urdf/base.xacro"/>
  <xacro:include filename="package://two/urdf/more.xacro"/>
  <xacro:include filename="$(dirname)/own.xacro"/>
  <link name="$(env SIDE)_$(optenv NONE some)_${{'$(dirname)'.split('/')[-1]}}"/>
</robot>""",
        src__one__package_xml="<package><name>one</name></package>",
        src__one__urdf__own_xacro=f'{HEAD}<xacro:property name="own" value="1"/></robot>',
        src__folder__package_xml="<package><name>two</name></package>",
        src__folder__urdf__base_xacro=f"{HEAD}</robot>",
        src__folder__urdf__more_xacro=f"{HEAD}</robot>",
    )
    imported = expand(path, environment={"SIDE": "left"})
    assert list(tree_of(imported)["links"]) == ["left_some_urdf"]
    assert [file.name for file in imported.files] == ["arm.xacro", "base.xacro", "more.xacro", "own.xacro"]


def test_package_that_is_given_comes_first(tmp_path):
    path = write(
        tmp_path,
        two__package_xml="<package><name>two</name></package>",
        elsewhere__name_xacro=f'{HEAD}<xacro:property name="n" value="given"/></robot>',
        two__name_xacro=f'{HEAD}<xacro:property name="n" value="found"/></robot>',
        arm_xacro=f'{HEAD}<xacro:include filename="$(find two)/name.xacro"/><link name="${{n}}"/></robot>',
    ).parent.parent
    arm = path / "arm.xacro"
    assert list(tree_of(expand(arm))["links"]) == ["found"]
    assert list(tree_of(expand(arm, packages={"two": path / "elsewhere"}))["links"]) == ["given"]
    ament = path / "prefix" / "share" / "three"
    ament.mkdir(parents=True)
    (ament / "name.xacro").write_text(f'{HEAD}<xacro:property name="n" value="ament"/></robot>', "utf-8")
    arm.write_text(arm.read_text("utf-8").replace("find two", "find three"), "utf-8")
    assert list(tree_of(expand(arm, environment={"AMENT_PREFIX_PATH": str(path / "prefix")}))["links"]) == ["ament"]


def place(diagnostic: Diagnostic) -> tuple[str, int]:
    assert diagnostic.span is not None
    return diagnostic.span.source.path, diagnostic.span.line


def test_entities_in_an_included_file_are_refused_before_they_grow(arm, tmp_path):
    bomb = '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    part = tmp_path / "parts" / "part.xacro"
    part.write_text(bomb + PART.replace("<link", "&b;<link"), "utf-8")
    found = expand(arm).diagnostics[-1]
    assert (found.rule, place(found)) == ("xml-doctype", ("parts/part.xacro", 1))


def test_missing_library_says_what_to_install(arm, monkeypatch):
    monkeypatch.setattr(reader, "_CHILD", "import sys\nsys.modules['xacro'] = None\n" + reader._CHILD)
    assert told(expand(arm)) == [
        f"error[extra-missing]: xacro, which expands .xacro files, is not installed ({pip_install('import')})"
    ]


@pytest.mark.parametrize(
    ("inner", "words"),
    [
        ("<xacro:macro name='m' params='n'><xacro:m n='${n+1}'/></xacro:macro><xacro:m n='1'/>", "without end"),
        ("<link name=\"${'a' * 10**11}\"/>", "more memory"),
        ("<link name=\"${[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == 'Quitter']}\"/>", ""),
        ("<xacro:message/>", "message"),
    ],
)
def test_files_that_break_the_child_break_nothing_else(tmp_path, inner, words):
    imported = expand(write(tmp_path, a_xacro=f"{HEAD}{inner}</robot>"))
    assert imported.tree is None
    assert words in imported.diagnostics[-1].message


def test_child_that_dies_or_hangs(arm, monkeypatch):
    monkeypatch.setattr(reader, "_CHILD", "import os; os._exit(7)")
    assert "xacro broke down: the process ended with 7" in told(expand(arm))[-1]
    monkeypatch.setattr(reader, "_CHILD", "import time; time.sleep(9)")
    monkeypatch.setattr(reader, "MAX_SECONDS", 0.02)
    monkeypatch.setattr(reader, "_START", 0)
    assert "it takes more than 0.02 s" in told(expand(arm))[-1]


MULTIPLY = "".join(f'<xacro:macro name="m{n}">{f"<xacro:m{n - 1}/>" * 10}</xacro:macro>' for n in range(1, 10))
BOMBS = {
    "number": '<link name="a${9**9**9}"/>',
    "list": '<link name="a${len([1 for x in range(10**12)])}"/>',
    "macros": f'<xacro:macro name="m0"/>{MULTIPLY}<xacro:m9/>',
}


@pytest.mark.landing("fuzz", "macros")
@pytest.mark.slow
@pytest.mark.parametrize("bomb", BOMBS)
def test_a_file_that_calculates_without_end_is_ended_and_told(bomb, tmp_path, monkeypatch, capsys):
    (tmp_path / "arm.xacro").write_text(f"{HEAD}\n{BOMBS[bomb]}</robot>", "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_XACRO_SECONDS", "60")  # which the option says anew
    assert main(["import", "arm.xacro", "-o", "out", "--trust", "--xacro-seconds", "1"]) == 1
    said = capsys.readouterr().err
    assert "arm.xacro:3:" in said
    assert "error[xacro-error]: xacro cannot expand the file: it takes more than 1 s\n" in said
    assert "--xacro-seconds S" in said


@pytest.mark.slow
def test_a_file_that_leaves_python_for_too_long_is_ended_by_the_system(arm, monkeypatch):
    endless = "from rosorin_compile.importing.xacro.child import _limit; import signal; _limit(1);"
    monkeypatch.setattr(reader, "_CHILD", f"{endless} signal.signal(signal.SIGPROF, signal.SIG_IGN)\nwhile True: pass")
    monkeypatch.setattr(reader, "MAX_SECONDS", 1)
    assert "it takes more than 1 s" in told(expand(arm))[-1]


def test_output_of_the_file_does_not_mix_with_the_answer(tmp_path):
    text = f"{HEAD}<link name=\"a${{xacro.message('{{')}}\"/></robot>"
    assert list(tree_of(expand(write(tmp_path, a_xacro=text)))["links"]) == ["a"]


def test_nothing_of_the_current_folder_is_run(arm, tmp_path):
    for name in ("json", "xacro", "yaml", "resource", "rosorin_compile"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('evil')\n", "utf-8")
    assert tree_of(expand(arm))


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_the_process_that_expands_ends_with_the_one_that_asks(tmp_path):
    text = HEAD + '<xacro:property name="huge" value="${9**9**9}"/><link name="l${huge}"/></robot>'
    (tmp_path / "huge.xacro").write_text(text, "utf-8")
    command = [sys.executable, "-m", "rosorin_compile", "import", "huge.xacro", "-o", "made"]
    asking = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL)
    children = Path(f"/proc/{asking.pid}/task/{asking.pid}/children")
    ends = time.monotonic() + 30
    while not (pids := children.read_text().split()) and time.monotonic() < ends:
        time.sleep(0.05)
    assert pids
    time.sleep(3)  # until it has asked the system for that
    asking.kill()
    asking.wait()
    ends = time.monotonic() + 10
    while any(Path(f"/proc/{pid}").exists() for pid in pids) and time.monotonic() < ends:
        time.sleep(0.05)
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)


def test_fault_in_an_included_file_names_it(arm, tmp_path):
    part = tmp_path / "parts" / "part.xacro"
    part.write_text(PART.replace("</link>", "</lnk>"), "utf-8")
    broken = expand(arm).diagnostics[-1]
    assert place(broken) == ("parts/part.xacro", 4)
    assert (broken.rule, broken.message) == ("xml-syntax", "</lnk> does not close <link>")
    part.write_text(PART.replace("table.height", "table.width"), "utf-8")
    failed = expand(arm).diagnostics[-1]
    assert failed.rule == "xacro-error"
    assert "width" in failed.message
    assert place(failed) == ("parts/part.xacro", 6)
    assert 'when expanding the macro "part"' in [related.message for related in failed.related]


def test_entities_in_the_file_itself_run_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(reader, "_expand", lambda *_: pytest.fail("it ran"))
    text = f'<!DOCTYPE robot [<!ENTITY a "b">]>{HEAD}<link name="${{1}}"/></robot>'
    assert [d.rule for d in expand(write(tmp_path, a_xacro=text)).diagnostics] == ["xml-doctype"]


def test_expanding_gives_the_same_text_every_time(arm, monkeypatch):
    texts = set()
    for seed in ("1", "2"):
        monkeypatch.setitem(os.environ, "PYTHONHASHSEED", seed)
        texts.add(reader._expand(arm, ReadOptions(environment={}))["text"])
    assert len(texts) == 1

"""A robot on standard input, called ``-``: read once, seen from the current folder, named <stdin> in what is said."""

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

import rosorin_compile
from rosorin_compile.cli.main import main
from support.commands import HANDY

PROJECT = {**HANDY, "arm.yaml": "robot: arm\nlinks: {base: {}}\noutputs: {urdf: {file: arm.urdf}}\n"}
URDF = """<?xml version="1.0"?>
<robot name="arm"><link name="base"/><link name="tool"/>
<joint name="j" type="fixed"><parent link="base"/><child link="tool"/><origin xyz="1 0 0"/></joint></robot>
"""
Shown = pytest.CaptureFixture[str]


@pytest.fixture
def handy(project: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the description as the current one: what it includes is there."""
    monkeypatch.chdir(project / "descriptions" / "handy")
    return project


def run(monkeypatch: pytest.MonkeyPatch, capsys: Shown, given: str | bytes, *words: str) -> tuple[int, str, str]:
    data = given.encode() if isinstance(given, str) else given
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
    capsys.readouterr()
    code = main(list(words))
    shown = capsys.readouterr()
    return code, shown.out, shown.err


@pytest.mark.parametrize(
    "words",
    [
        ["tf", "{}", "base_link", "shelf"],
        ["tf", "{}", "base_link", "shelf", "--csv"],
        ["tf", "{}", "base_link", "--format", "json", "shelf"],
        ["explain", "{}", "shelf", "--format", "json"],
        ["explain", "{}", "shelf", "z"],
        ["frames", "{}", "--ascii"],
        ["args", "{}"],
        ["print", "{}", "urdf"],
        ["print", "{}", "static_tf", "scale:=2"],
        ["print", "--list", "{}"],
    ],
)
@pytest.mark.usefixtures("handy")
def test_it_is_the_same_robot_as_from_its_file(
    monkeypatch: pytest.MonkeyPatch, capsys: Shown, words: list[str]
) -> None:
    text = Path("robot.yaml").read_text("utf-8")
    code, out, err = run(monkeypatch, capsys, text, *(word.format("-") for word in words))
    assert code == 0, err
    wanted_code, wanted, wanted_err = run(monkeypatch, capsys, "", *(word.format("robot.yaml") for word in words))
    assert code == wanted_code
    assert out.replace("<stdin>", "robot.yaml") == wanted.replace("handy:", "robot.yaml:", "args" in words)
    assert err.replace("<stdin>", "robot.yaml") == wanted_err.replace("handy:", "robot.yaml:")


@pytest.mark.usefixtures("handy")
def test_two_passes_and_both_sides(monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    text = Path("robot.yaml").read_text("utf-8")
    code, out, _ = run(monkeypatch, capsys, text, "check", "-", "--every-argument")
    assert (code, out.startswith("<stdin>: ")) == (0, True)
    for words in (["-", "handy"], ["handy", "-"]):
        code, out, _ = run(monkeypatch, capsys, text, "diff", *words)
        assert code == 0, out
        assert "<stdin> (description of handy" in out
    code, _, err = run(monkeypatch, capsys, text, "diff", "-", "-")
    assert (code, err) == (2, "rosorin-compile: standard input can be read only once, and - is given twice\n")


@pytest.mark.usefixtures("project")
def test_check_has_nothing_to_compare_with(monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    code, out, _ = run(monkeypatch, capsys, Path("arm.yaml").read_text(), "check", "-")
    assert (code, out) == (0, "<stdin>: 1 artifact compiled; there are no committed ones\n")
    assert not Path("outputs").exists()


def test_a_mistake_has_its_place(home: Path, monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    text = "robot: a\nlinks: {base: {}, tip: {}}\njoints:\n  j: {type: fixd, parent: base, child: tip}\n"
    for words in (["print", "-", "urdf"], ["check", "-"], ["tf", "-", "a", "b"], ["args", "-"], ["explain", "-", "a"]):
        code, out, err = run(monkeypatch, capsys, text, *words)
        if words[0] != "args":
            assert (code, out) == (1, "")
            assert err.startswith('<stdin>:4:13: error[wrong-value]: joint "j" type cannot be "fixd"\n')
            assert "    4 |   j: {type: fixd, parent: base, child: tip}\n" in err
    assert [path.name for path in home.iterdir() if path.name != "cache"] == []


@pytest.mark.usefixtures("home")
@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            "",
            '<stdin>:1:1: error[not-a-mapping]: <stdin> is empty; a description is a mapping such as "robot: my_robot"',
        ),
        ("\n \n", "<stdin>:1:1: error[not-a-mapping]: <stdin> is empty"),
        ("- a", "<stdin>:1:1: error[not-a-mapping]: <stdin> is a list"),
        (b"robot: a\n# \xff", "<stdin>:2:3: error[not-utf8]: <stdin> is not UTF-8 text: byte 0xff at this place"),
        (b"\x7fELF\0\0\xd0", "error[not-utf8]: <stdin> is not UTF-8 text"),
        ("robot: [", "<stdin>:1:"),
        ("robot: a\ninclude: [nowhere.yaml]\n", "<stdin>:2:11: error[file-unreadable]: cannot read nowhere.yaml"),
        (
            "<mujoco model='a'/>",
            "<stdin>:1:2: error[wrong-format]: this is MJCF (<mujoco>), which is read with the files",
        ),
        (
            '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="b" default=""/></robot>',
            "name the file; or expand it before the pipe: xacro FILE | rosorin-compile ...",
        ),
        ("<html/>", "<stdin>:1:1: error[wrong-root]: <stdin> is a web page, not a robot"),
    ],
)
def test_what_is_no_robot(monkeypatch: pytest.MonkeyPatch, capsys: Shown, given: str | bytes, said: str) -> None:
    code, out, err = run(monkeypatch, capsys, given, "print", "-", "urdf")
    assert (code, out) == (1, ""), err
    assert said in err
    if given == "":
        assert "the program before the pipe printed nothing" in err


@pytest.mark.usefixtures("home")
def test_a_urdf_before_the_pipe(monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    Path("arm.urdf").write_text(URDF)
    wanted = run(monkeypatch, capsys, "", "tf", "arm.urdf", "base", "tool", "--csv")
    for given in (URDF, "\ufeff\n" + URDF.partition("\n")[2]):
        assert run(monkeypatch, capsys, given, "tf", "-", "base", "tool", "--csv") == wanted
    assert wanted[0] == 0
    code, out, _ = run(monkeypatch, capsys, URDF, "frames", "-", "--ascii")
    assert "-- tool" in out
    code, out, _ = run(monkeypatch, capsys, URDF, "diff", "arm.urdf", "-")
    assert code == 0, out
    code, out, _ = run(monkeypatch, capsys, URDF.replace("1 0 0", "1 0 2"), "diff", "-", "arm.urdf")
    assert code == 1
    assert "<stdin>" in out
    code, _, err = run(monkeypatch, capsys, URDF, "import", "-", "-o", "made")
    assert code == 0, err
    assert "from <stdin>" in Path("made", "robot.yaml").read_text()


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["all", "-"], "name a file, or print one artifact: rosorin-compile print - OUTPUT"),
        (["watch", "-"], "name a file to watch"),
        (["package", "-", "-o", "x"], "name a file"),
        (["extract", "boxes", "-"], "name a file"),
    ],
)
def test_where_it_needs_a_name_or_a_folder(
    monkeypatch: pytest.MonkeyPatch, capsys: Shown, words: list[str], said: str
) -> None:
    before = sorted(Path().rglob("*"))
    code, out, err = run(monkeypatch, capsys, "robot: a\n", *words)
    assert (code, out) == (2, "")
    assert err == f"rosorin-compile: a robot on standard input has no name and no folder; {said}\n"
    assert sorted(Path().rglob("*")) == before


@pytest.mark.usefixtures("project")
def test_what_was_read_does_not_name_it(monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    text = Path("arm.yaml").read_text()
    code, _, err = run(monkeypatch, capsys, text, "print", "-", "urdf", "-o", "made.urdf", "--depfile", "made.d", "-v")
    assert code == 0, err
    assert Path("made.urdf").read_text().startswith("<?xml")
    assert "stdin" not in Path("made.d").read_text()
    assert "read <stdin>" not in err


def test_a_program_does_not_read_it(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In Python, "-" is a name like any other: nobody's standard input is taken away."""
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"robot: a\n")))
    monkeypatch.setattr("rosorin_compile.source.project._on_stdin", [])
    assert rosorin_compile.compile("-").robot is None
    assert sys.stdin.read() == "robot: a\n"
    (home / "-").mkdir()
    (home / "-" / "robot.yaml").write_text("robot: dash\nlinks: {base: {}}\n")
    compiled = rosorin_compile.compile("-")
    assert compiled.robot is not None
    assert compiled.robot.name == "dash"


def test_a_terminal_is_told_what_is_waited_for(home: Path) -> None:
    terminal, other_end = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "rosorin_compile", "args", "-"],
        cwd=home, stdin=other_end, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    os.close(other_end)
    assert process.stderr is not None
    assert process.stderr.readline() == "reading a robot from this terminal; Ctrl-D ends it\n"
    os.write(terminal, b"robot: a\n\x04")
    out, err = process.communicate(timeout=60)
    os.close(terminal)
    assert (process.returncode, out, err) == (0, "<stdin> has no arguments\n", "")

"""Every defect gets its message: the comment of each case in tests/bad lists the diagnostics that it gets.

A case is a file, or a folder with robot.yaml where a defect needs several files. Its comment (see support/cases.py) may
begin with "# args: NAME=VALUE". Errors and warnings are compared; notes too where the case expects one.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.diagnostics import ERROR, NOTE
from rosorin_compile.pipeline import compile_robot
from support.cases import check, told
from support.paths import BAD

CASES = sorted([*BAD.glob("*.yaml"), *BAD.glob("*/robot.yaml")])


def name_of(case: Path) -> str:
    return case.parent.name if case.name == "robot.yaml" else case.stem


@pytest.mark.parametrize("case", CASES, ids=map(name_of, CASES))
def test_message(case, monkeypatch):
    monkeypatch.chdir(case.parent)
    comment = [line for line in case.read_text("utf-8").splitlines() if line.startswith("# ")]
    arguments = [word for line in comment if line.startswith("# args: ") for word in line.split()[2:]]
    made = compile_robot(Path(case.name), dict(word.split("=", 1) for word in arguments))
    with_notes = any(f" {NOTE}[" in line for line in comment)
    diagnostics = [one for one in made.diagnostics if with_notes or one.severity != NOTE]
    assert diagnostics
    check(case, told(diagnostics, case.name))
    assert not made.artifacts or all(one.severity != ERROR for one in made.diagnostics)


def messages(folder: Path, monkeypatch, **files: bytes) -> list[str]:
    for name, data in files.items():
        (folder / f"{name}.yaml").write_bytes(data)
    monkeypatch.chdir(folder)
    return told(compile_robot(Path("robot.yaml")).diagnostics, "robot.yaml")


def test_not_utf8(tmp_path, monkeypatch):
    assert messages(tmp_path, monkeypatch, robot="robot: bad\nlinks: {größe: {}}\n".encode("latin-1")) == [
        "# expect: 2:11: error[not-utf8]: robot.yaml is not UTF-8 text: byte 0xf6 at offset 21",
        "#   help: save the file as UTF-8",
    ]


def test_utf16(tmp_path, monkeypatch):
    found = messages(tmp_path, monkeypatch, robot="robot: bad\n".encode("utf-16"))
    assert found[0] == "# expect: 1:1: error[not-utf8]: robot.yaml is not UTF-8 text: byte 0xff at offset 0"


@pytest.mark.parametrize("letter", [b"\0", b"\x07", b"\x1b"])
def test_control_character(tmp_path, monkeypatch, letter):
    assert messages(tmp_path, monkeypatch, robot=b"robot: bad\nlinks: {a" + letter + b": {}}\n") == [
        "# expect: 2:10: error[yaml-syntax]: a control character may not stand in YAML",
        "#   help: remove it",
    ]


def test_random_bytes(tmp_path, monkeypatch):
    found = messages(tmp_path, monkeypatch, robot=bytes(range(256)))
    assert len([line for line in found if line.startswith("# expect: ")]) == 1


def test_byte_order_mark_and_windows_line_ends_are_fine(tmp_path, monkeypatch):
    text = "\ufeffrobot: good\r\nlinks:\r\n  base_link: {}\r\n"
    assert messages(tmp_path, monkeypatch, robot=text.encode("utf-8")) == []


def test_windows_line_ends_do_not_shift_a_place(tmp_path, monkeypatch):
    assert messages(tmp_path, monkeypatch, robot=b"\xef\xbb\xbfrobot: bad\r\nlinks:\r\n\tbase_link: {}\r\n") == [
        "# expect: 3:1: error[yaml-syntax]: a tab indents this line",
        "#   help: YAML allows no tab for indentation; use spaces",
    ]


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ('<?xml version="1.0"?>\n<robot name="bad"><link name="base_link"/></robot>\n', "a URDF"),
        ('\n<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="bad"/>\n', "xacro"),
        ('<mujoco model="bad"><worldbody/></mujoco>\n', "MJCF"),
        ('<sdf version="1.7"><model name="bad"/></sdf>\n', "SDF"),
        ("<launch/>\n", "XML"),
    ],
)
def test_a_robot_in_xml_is_called_what_it_is(tmp_path, monkeypatch, text, kind):
    first, help = messages(tmp_path, monkeypatch, robot=text.encode())
    assert first == f"# expect: 1:1: error[not-a-mapping]: robot.yaml is {kind}, not a description"
    assert "`rosorin-compile import` makes a description of it" in help


def test_a_line_for_yaml_itself(tmp_path, monkeypatch):
    for first in ("%YAML 1.1", "%TAG", "% the robot of the lab"):
        found = messages(tmp_path, monkeypatch, robot=f"{first}\nrobot: bad\n".encode())
        assert found[0] == '# expect: 1:1: error[yaml-syntax]: a line with "%" is for YAML itself'


def test_file_too_large(tmp_path, monkeypatch):
    found = messages(tmp_path, monkeypatch, robot=b"robot: bad\ninclude: [big.yaml]\n", big=b"#" * 20_000_001)
    assert found[0] == "# expect: 2:11: error[file-too-large]: big.yaml is larger than 20,000,000 bytes"


def test_too_many_includes(tmp_path, monkeypatch):
    names = ", ".join(["part.yaml"] * 600)
    found = messages(tmp_path, monkeypatch, robot=f"robot: bad\ninclude: [{names}]\n".encode(), part=b"links: {}\n")
    assert found[0].endswith("error[include-too-many]: more than 500 files are included")


def test_description_that_is_a_folder(tmp_path, monkeypatch):
    (tmp_path / "robot.yaml").mkdir()
    found = messages(tmp_path, monkeypatch)
    assert found[0] == "# expect: error[file-unreadable]: cannot read robot.yaml: Is a directory"


def test_description_that_is_missing(tmp_path, monkeypatch):
    found = messages(tmp_path, monkeypatch)
    assert found[0] == "# expect: error[file-unreadable]: cannot read robot.yaml: No such file or directory"


def test_link_that_leads_outside(tmp_path, monkeypatch):
    (tmp_path / "secret.yaml").write_text("links: {}\n", "utf-8")
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "arm.yaml").symlink_to(tmp_path / "secret.yaml")
    (folder / "arm.urdf").symlink_to(tmp_path / "secret.yaml")
    for name in ("arm.yaml", "arm.urdf"):
        found = messages(folder, monkeypatch, robot=f"robot: bad\ninclude: [{name}]\n".encode())
        expected = f"error[include-outside]: {name} is outside the folder of the description: a link leads there"
        assert found[0].endswith(expected)


def test_template_link_that_leads_outside(tmp_path, monkeypatch):
    (tmp_path / "secret.txt").write_text("secret", "utf-8")
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "a.txt.jinja").symlink_to(tmp_path / "secret.txt")
    text = b"robot: bad\nlinks: {base_link: {}}\noutputs: {a: {file: a.txt, template: a.txt.jinja}}\n"
    assert "error[template-missing]" in messages(folder, monkeypatch, robot=text)[0]

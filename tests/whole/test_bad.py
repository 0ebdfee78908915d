"""Every defect gets its message: the comment of each case in tests/bad lists the diagnostics that it gets.

A case is a file, or a folder with robot.yaml where a defect needs several files. Its comment (see support/cases.py) may
begin with "# args: NAME=VALUE". Errors and warnings are compared; notes too where the case expects one.
"""

from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic
from support.cases import as_comment, check
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
    found = [one for one in made.diagnostics if with_notes or one.severity != NOTE]
    assert found
    check(case, as_comment(found, case.name))
    assert not made.artifacts or all(one.severity != ERROR for one in made.diagnostics)


def diagnostics(folder: Path, monkeypatch: pytest.MonkeyPatch, **files: bytes) -> list[Diagnostic]:
    for name, data in files.items():
        (folder / f"{name}.yaml").write_bytes(data)
    monkeypatch.chdir(folder)
    return compile_robot(Path("robot.yaml")).diagnostics


def rules(folder: Path, monkeypatch: pytest.MonkeyPatch, **files: bytes) -> list[str]:
    """Return the diagnostics as LINE:COLUMN:RULE."""
    found = diagnostics(folder, monkeypatch, **files)
    return [f"{one.span.line}:{one.span.column}:{one.rule}" if one.span else one.rule for one in found]


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        ("robot: bad\nlinks: {größe: {}}\n".encode("latin-1"), "2:11:not-utf8"),
        ("robot: bad\n".encode("utf-16"), "1:1:not-utf8"),
        (bytes(range(256)), "3:115:not-utf8"),
        (b"robot: bad\nlinks: {a\0: {}}\n", "2:10:yaml-syntax"),
        (b"robot: bad\nlinks: {a\x07: {}}\n", "2:10:yaml-syntax"),
        (b"robot: bad\nlinks: {a\x1b: {}}\n", "2:10:yaml-syntax"),
        (b"\xef\xbb\xbfrobot: bad\r\nlinks:\r\n\tbase_link: {}\r\n", "3:1:yaml-syntax"),
        (b"%YAML 1.1\nrobot: bad\n", "1:1:yaml-syntax"),
        (b"%TAG\nrobot: bad\n", "1:1:yaml-syntax"),
        (b"% the robot of the lab\nrobot: bad\n", "1:1:yaml-syntax"),
    ],
)
def test_bytes_that_are_not_yaml(tmp_path, monkeypatch, data, expected):
    assert rules(tmp_path, monkeypatch, robot=data) == [expected]


def test_byte_order_mark_and_windows_line_ends_are_fine(tmp_path, monkeypatch):
    text = "\ufeffrobot: good\r\nlinks:\r\n  base_link: {}\r\n"
    assert rules(tmp_path, monkeypatch, robot=text.encode("utf-8")) == []


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ('<?xml version="1.0"?>\n<robot name="bad"><link name="base_link"/></robot>\n', "URDF"),
        ('\n<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="bad"/>\n', "xacro"),
        ('<mujoco model="bad"><worldbody/></mujoco>\n', "MJCF"),
        ('<sdf version="1.7"><model name="bad"/></sdf>\n', "SDF"),
        ("<launch/>\n", "XML"),
    ],
)
def test_a_robot_in_xml_leads_to_import(tmp_path, monkeypatch, text, kind):
    (found,) = diagnostics(tmp_path, monkeypatch, robot=text.encode())
    assert (found.rule, found.span and found.span.line) == ("not-a-mapping", 1)
    assert kind in found.message
    assert "rosorin-compile import" in found.help


def test_file_too_large(tmp_path, monkeypatch):
    found = rules(tmp_path, monkeypatch, robot=b"robot: bad\ninclude: [big.yaml]\n", big=b"#" * 20_000_001)
    assert found[0] == "2:11:file-too-large"


def test_files_that_include_each_other_twice_are_too_many(tmp_path, monkeypatch):
    files = {f"part{n}": f"include: [part{n + 1}.yaml, part{n + 1}.yaml]\n".encode() for n in range(14)}
    found = rules(tmp_path, monkeypatch, robot=b"robot: bad\ninclude: [part0.yaml]\n", part14=b"links: {}\n", **files)
    assert found[0].endswith(":include-too-many")


def test_a_thousand_small_files_are_not_too_many(tmp_path, monkeypatch):
    names = [f"part{n}" for n in range(1000)]
    files = {name: f"links: {{{name}: {{}}}}\n".encode() for name in names}
    text = f"robot: many\ninclude: [{', '.join(f'{name}.yaml' for name in names)}]\nroot: {{link: part0}}\n"
    assert "include-too-many" not in str(rules(tmp_path, monkeypatch, robot=text.encode(), **files))


@pytest.mark.parametrize("use", ["", "unused: {for: {i: '${range(3)}'}, part: plate, if: '${i < 0}'}"])
def test_limits_of_size_do_not_apply_to_what_is_not_used(tmp_path, monkeypatch, use):
    text = f"""\
robot: small
let: {{numbers: "${{[range(2000) for i in range(2000)]}}"}}
parts:
  plate:
    links: {{"a${{i}}": {{for: {{i: "${{range(9000)}}", j: "${{range(9000)}}"}}, help: "${{i}}"}}}}
links: {{base_link: {{}}}}
use: {{{use}}}
"""
    found = rules(tmp_path, monkeypatch, robot=text.encode())
    assert not any("too-large" in one for one in found), found


def test_description_that_is_a_folder(tmp_path, monkeypatch):
    (tmp_path / "robot.yaml").mkdir()
    assert rules(tmp_path, monkeypatch) == ["file-unreadable"]


def test_description_that_is_missing(tmp_path, monkeypatch):
    assert rules(tmp_path, monkeypatch) == ["file-unreadable"]


@pytest.mark.parametrize("name", ["arm.yaml", "arm.urdf"])
def test_link_that_leads_outside(tmp_path, monkeypatch, name):
    (tmp_path / "secret.yaml").write_text("links: {}\n", "utf-8")
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / name).symlink_to(tmp_path / "secret.yaml")
    found = rules(folder, monkeypatch, robot=f"robot: bad\ninclude: [{name}]\n".encode())
    assert found[0] == "2:11:include-outside"


def test_template_link_that_leads_outside(tmp_path, monkeypatch):
    (tmp_path / "secret.txt").write_text("secret", "utf-8")
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "a.txt.jinja").symlink_to(tmp_path / "secret.txt")
    text = b"robot: bad\nlinks: {base_link: {}}\noutputs: {a: {file: a.txt, template: a.txt.jinja}}\n"
    assert rules(folder, monkeypatch, robot=text)[0].endswith(":template-missing")

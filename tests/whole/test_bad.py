"""Every defect gets its message: each case in tests/bad says at its top what has to be said about it, word for word.

A case is a file, or a folder with robot.yaml where a defect needs several files. It begins with comments:

    # args: NAME=VALUE                                             (if it needs arguments)
    # expect: LINE:COLUMN: SEVERITY[RULE]: MESSAGE                 (FILE: before the line if it is another file)
    #   help: HELP
    #   related: LINE:COLUMN: MESSAGE

A line may end with "..." in place of a list of all that is known, which grows. All errors and warnings are compared,
in their order; notes too where the case expects one. Characters that cannot be printed stand as \\xNN. A failing case
prints the comments that would fit.
"""

from __future__ import annotations

import ast
import itertools
import os
import re
from collections.abc import Iterable
from pathlib import Path

import pytest

from rosorin_compile.diagnostics import ERROR, NOTE
from rosorin_compile.formats import FORMATS
from rosorin_compile.pipeline import compile_robot
from rosorin_compile.rules import acceptable
from support.cases import told
from support.paths import BAD, COMPILER, PACKAGE

CASES = sorted([*BAD.glob("*.yaml"), *BAD.glob("*/robot.yaml")])
FIELD_DEFECTS = [case for case in CASES if case.stem.startswith("field-defect-")]

# What the stages of a compilation can say, beside the rules for writing, which have tests of their own.
CORE = ("pipeline", "frontend/**/*", "rules/*", "sections/**/*")
WRITERS = ("__init__", "facts", "format", "static_tf*", "template", "templating", "robot_model/__init__", "frames")
OF_MUJOCO = ("mjcf/write*", "mjcf/omissions", "mjcf/masses", "mjcf/facts", "sections/**/*")
OF_ROS = (
    "controllers/*",
    "parameters/checking",
    "navigation",
    "nav2/write",
    "robot_localization/write",
    "sections/**/*",
)
STAGES = (
    *(f"{PACKAGE.name}/{stage}" for stage in (*CORE, *(f"formats/{writer}" for writer in WRITERS))),
    *(f"{PACKAGE.name}/formats/urdf/{writer}" for writer in ("write", "facts")),
    *(f"{PACKAGE.name}_mujoco/{stage}" for stage in OF_MUJOCO),
    *(f"{PACKAGE.name}_ros/{stage}" for stage in OF_ROS),
    *(f"{PACKAGE.name}_view/{stage}" for stage in ("frames_picture", "page/__init__")),
)
TELLERS = {"Diagnostic", "Finding", "ShapeProblem", "_error", "_make", "_problem", "error", "fail", "problem", "report"}

# Said by the functions below, whose input cannot stand in a file of its own.
MADE_HERE = {"file-too-large", "include-too-many", "not-utf8"}
# Said by the API alone, of a file that is no description; and of what other packages bring (test_extend.py, sections/).
OF_THE_API = {"wrong-format", "file-syntax"}
# Said of what a command asks for by name (test_print.py).
OF_COMMANDS = {
    "unknown-output",
    "variants-list",
    "variant-name",
    "mjcf-left-out",
}  # the last: only they look for meshes

# Guards of functions that can be called without the rules: in a compilation a rule refuses first.
GUARDS = {
    "robot-model-unknown-name": "unknown-joint, unknown-link and unknown-servo name the place",
    "static-tf-no-urdf": "unpublished-edge, where a description lists its outputs",
    "srdf-without-urdf": "moveit-urdf names the place",
    "wrong-shape": "for keywords that the schema does not use yet",
}


def name_of(case: Path) -> str:
    return case.parent.name if case.name == "robot.yaml" else case.stem


def header(case: Path) -> list[str]:
    """Return the comments at the top of a case."""
    lines = []
    for line in case.read_text("utf-8").splitlines():
        if not line.startswith(("# args: ", "# expect: ", "#   ")):
            break
        lines.append(line)
    return lines


def is_shown(line: str, shown: str) -> bool:
    """Say whether a case shows a line; it may leave off the end of a list that grows, by "..."."""
    return line == shown or (shown.endswith(" ...") and line.startswith(shown.removesuffix("...")))


def arguments(lines: list[str]) -> dict[str, str]:
    given = [line.removeprefix("# args: ").split() for line in lines if line.startswith("# args: ")]
    return dict(word.split("=", 1) for words in given for word in words)


def test_there_are_cases():
    assert len(CASES) > 200
    folders = {path.name for path in BAD.iterdir() if path.is_dir()}
    assert folders == {case.parent.name for case in CASES if case.name == "robot.yaml"}


@pytest.mark.parametrize("case", CASES, ids=map(name_of, CASES))
def test_message(case, monkeypatch):
    monkeypatch.chdir(case.parent)
    expected = header(case)
    made = compile_robot(Path(case.name), arguments(expected))
    with_notes = any(f" {NOTE}[" in line for line in expected)
    found = told([d for d in made.diagnostics if with_notes or d.severity != NOTE], case.name)
    expected = [line for line in expected if not line.startswith("# args: ")]
    assert expected, f"the case expects nothing; it gets\n{os.linesep.join(found)}"
    fits = len(found) == len(expected) and all(map(is_shown, found, expected))
    assert fits, "\n".join(["it gets", *found])
    refused = any(d.severity == ERROR for d in made.diagnostics)
    assert (made.artifacts == ()) or not refused


@pytest.mark.parametrize(
    ("case", "known"),
    [
        ("unknown-backend", [name for name, one in FORMATS.items() if one.write is not None]),
        ("unknown-backend-said", [name for name, one in FORMATS.items() if one.write is not None]),
        ("wrong-value-accept", acceptable()),
    ],
)
def test_a_list_of_what_is_known_has_all_of_it(case: str, known: Iterable[str]):
    told = compile_robot(BAD / f"{case}.yaml").diagnostics[0].help
    assert re.sub(r"^.*(known:|one of) |\)$", "", told) == ", ".join(sorted(known))


@pytest.mark.parametrize("case", CASES, ids=map(name_of, CASES))
def test_case_is_named_after_its_rule(case):
    name = name_of(case)
    first = next(iter(rules_expected(case)))
    assert name == first or name.startswith((f"{first}-", "several-problems-", "field-defect-"))


def test_several_problems_are_told_in_one_run():
    several = [case for case in CASES if name_of(case).startswith("several-problems-")]
    assert len(several) >= 4
    assert all(len([line for line in header(case) if line.startswith("# expect: ")]) >= 3 for case in several)


def test_defects_that_other_readers_let_pass():
    """Refuse the twelve defects of which the best reader of URDF catches five (survey of seven readers, 2026-11)."""
    assert [re.match(r"field-defect-(\d\d)-", case.stem)[1] for case in FIELD_DEFECTS] == [
        f"{n:02}" for n in range(1, 13)
    ]
    for case in FIELD_DEFECTS:
        first, *rest = header(case)
        assert re.match(r"# expect: \d+:\d+: error\[", first), case.name
        # A message that names the missing key is its own way out.
        assert "needs the key" in first or rest[0].startswith("#   help: "), case.name


def rules_expected(case: Path) -> list[str]:
    return [
        found[1]
        for line in header(case)
        if (found := re.match(r"# expect: .*?\b(?:error|warning|note)\[(.+?)\]", line))
    ]


def rules_in_code() -> set[str]:
    """Return every rule id that a stage of a compilation can use."""
    stages = [sorted(COMPILER.glob(f"{stage}.py")) for stage in STAGES]
    assert all(stages), "a stage has no module"
    found = set()
    for path in itertools.chain.from_iterable(stages):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
                name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
                if name in TELLERS and isinstance(node.args[0].value, str):
                    found.add(node.args[0].value)
    return found


def test_every_rule_has_a_case():
    found = rules_in_code()
    assert len(found) > 80
    covered = {rule for case in CASES for rule in rules_expected(case)}
    assert found - covered - MADE_HERE - OF_THE_API - OF_COMMANDS - GUARDS.keys() == set()
    assert covered & GUARDS.keys() == set(), "a guard that a case reaches is none"


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

"""Every defect gets its message: the comment of each case in tests/bad lists the diagnostics that it gets.

A case is a file, or a folder with robot.yaml where a defect needs several files. Its comment (see support/cases.py) may
begin with "# args: NAME=VALUE". Errors and warnings are compared; notes too where the case expects one.
"""

from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import ERROR, NOTE
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

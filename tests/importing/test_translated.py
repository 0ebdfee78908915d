"""Xacros and the descriptions that they become, committed and compared to the byte: a folder a case.

    python tests/renew.py translated

regenerates them; read the difference. The comment at the top of ``robot.xacro`` describes the case, and may give the
arguments of the import; ``expected`` has the files, and ``told.txt`` the report.
"""

import os
import re
import sys
from pathlib import Path

import pytest

from rosorin_compile.formats.imported_robot import Outputs, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.xacro.translate import Target, translate
from support.paths import DATA

pytest.importorskip("xacro")

FOLDER = DATA / "translated"
CASES = sorted(path.name for path in FOLDER.iterdir() if path.is_dir())
URDF = Outputs({"urdf": {"file": "robot.urdf"}}, {}, {})


def made(name: str) -> dict[str, str]:
    path = FOLDER / name / "robot.xacro"
    assert not any(variable.startswith("ROVER_") for variable in os.environ)
    first = re.match("<!-- arguments: (.*) -->", path.read_text("utf-8"))
    arguments = dict(word.split(":=") for word in first[1].split()) if first else {}
    how = ReadOptions(arguments=arguments, trust=True)
    imported = read_robot(path, how)
    assert imported.tree is not None, imported.diagnostics
    translation = translate(path, how, imported, URDF, Target(Path("descriptions/robot")))
    return {**translation.files, "told.txt": "".join(f"{line}\n" for line in translation.report)}


def expected(name: str) -> Path:
    return FOLDER / name / "expected"


@pytest.mark.parametrize("name", CASES)
def test_a_xacro_becomes_this_description(name: str) -> None:
    folder = expected(name)
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert made(name) == {path.relative_to(folder).as_posix(): path.read_text("utf-8") for path in files}


def test_every_comment_of_the_source_is_there() -> None:
    source = (FOLDER / "comments" / "robot.xacro").read_text("utf-8")
    lines = made("comments")["robot.yaml"].splitlines()
    comments = [comment.strip() for comment in re.findall(r"<!--(.*?)-->", source)]
    assert len(comments) == 13
    assert [comment for comment in comments if [line.strip() for line in lines].count(f"# {comment}") != 1] == []


if __name__ == "__main__":
    for case in sys.argv[1:] or CASES:
        for file, text in made(case).items():
            target = expected(case) / file
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, "utf-8")

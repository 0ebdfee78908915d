"""What a description cannot carry of an MJCF is reported, and broken files are refused, with their lines.

The comment of each file in tests/data/mjcf/told and tests/data/mjcf/bad lists its diagnostics (see support/cases.py).
"""

import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.mujoco.mjcf import process
from rosorin_compile.mujoco.mjcf.robot import read_mjcf
from rosorin_compile.source.system import pip_install
from support.cases import as_xml_comment, check
from support.paths import DATA

pytestmark = pytest.mark.slow

MJCF = DATA / "mjcf"
TOLD = sorted(MJCF.glob("told/*.xml"))
BAD = sorted(MJCF.glob("bad/*.xml"))


@pytest.mark.parametrize("path", [*TOLD, *BAD], ids=lambda path: path.stem)
def test_message(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(path.parent)
    made = read_mjcf(Path(path.name), ReadOptions())
    check(path, as_xml_comment(made.diagnostics, path.name))
    assert (made.tree is None) == (path in BAD)
    assert all(one.span and one.help for one in made.diagnostics if one.severity == "error")
    carried_not = [one for one in made.diagnostics if one.rule == "import-cannot-carry"]
    assert len([left for left in made.left_out if left.span]) == len(made.left_out) == len(carried_not)


def test_a_warning_of_mujoco_is_passed_on() -> None:
    made = read_mjcf(MJCF / "public" / "half_cheetah.xml", ReadOptions())
    (found,) = [d for d in made.diagnostics if d.rule == "mjcf-warning"]
    assert found.severity == "warning"
    assert found.message.startswith("MuJoCo warns: compiler attribute 'settotalmass' is deprecated")
    assert found.span is not None
    assert found.span.source.line(found.span.line)[found.span.column - 1 :].startswith("settotalmass")


def test_mujoco_has_an_end() -> None:
    began = time.monotonic()
    answer = process.ask(MJCF / "many.xml", seconds=2)
    assert answer.facts is None
    assert answer.own
    assert answer.refusal.startswith(("MuJoCo did not come to an end", "MuJoCo crashed", "MuJoCo gave up"))
    assert time.monotonic() - began < 30


def test_the_limits_of_a_shell_are_kept(tmp_path: Path) -> None:
    """ulimit -v, as batch systems and services set it: a process may lower it, and not raise it."""
    file = MJCF / "corners" / "defaults.xml"
    words = [sys.executable, "-m", "rosorin_compile", "import", str(file), "-o", str(tmp_path / "out")]
    limited = ["sh", "-c", 'ulimit -v 8000000; ulimit -t 50; exec "$@"', "sh", *words]
    done = subprocess.run(limited, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_crash_of_mujoco_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "_START", "import os; os.abort()")
    made = read_mjcf(MJCF / "corners" / "defaults.xml", ReadOptions())
    assert [(d.rule, d.message) for d in made.diagnostics] == [
        ("mjcf-refused", "MuJoCo crashed on the file (signal 6)")
    ]


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("mujoco", "MuJoCo, which reads MJCF,"),
        ("mujoco._specs", "MuJoCo, which reads MJCF,"),
        ("numpy", "the package numpy, which MuJoCo needs,"),
    ],
)
def test_no_mujoco_is_told(monkeypatch: pytest.MonkeyPatch, name: str, what: str) -> None:
    problem = f"ModuleNotFoundError(\"No module named '{name}'\")"
    monkeypatch.setattr(process, "_START", f"raise {problem}")
    made = read_mjcf(MJCF / "corners" / "defaults.xml", ReadOptions())
    (found,) = made.diagnostics
    assert found.rule == "extra-missing"
    assert found.message == f"{what} is not installed"
    assert found.help == pip_install("import")


def test_files_that_include_files_have_an_end(tmp_path: Path) -> None:
    for number in range(30):
        text = f'<include file="part{number + 1}.xml"/>' if number < 29 else ""
        root = "mujocoinclude" if number else "mujoco"
        (tmp_path / f"part{number}.xml").write_text(f"<{root}>{text}</{root}>", "utf-8")
    made = read_mjcf(tmp_path / "part0.xml", ReadOptions())
    assert [(d.rule, d.message) for d in made.diagnostics] == [
        ("include-too-many", "files include each other 20 levels deep")
    ]


def test_what_mujoco_4_no_longer_reads_names_its_version(tmp_path: Path) -> None:
    body = '<body name="b">\n<composite type="cable" count="5 1 1" size="1"/></body>'
    path = tmp_path / "cable.xml"
    path.write_text(f"<mujoco><worldbody>\n{body}\n</worldbody></mujoco>", "utf-8")
    (found,) = read_mjcf(path, ReadOptions()).diagnostics
    assert found.rule == "mjcf-refused"
    assert re.search(r"MuJoCo 4[.\d]* no longer reads <composite>", found.message)
    assert found.span is not None
    assert (found.span.line, found.span.column) == (3, 2)

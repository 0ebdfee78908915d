"""check --every-argument: every combination is compiled, and each problem says by which arguments it comes."""

import itertools
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.language.arguments import combinations
from support.paths import data_text

pytestmark = pytest.mark.slow

ROBOT = data_text("robots/every_argument.yaml")


def checked(folder: Path, capsys: Any, condition: str, *words: str) -> tuple[int, str, str]:
    path = folder / "armed" / "robot.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(ROBOT.replace("BROKEN", condition), "utf-8")
    code = main(["check", str(path), "--every-argument", *words])
    said = capsys.readouterr()
    return code, said.out, said.err


def test_all_fine(tmp_path, capsys):
    condition = "base == 'fixed' and mast < 0 m"
    assert checked(tmp_path, capsys, condition) == (0, "armed: 6 combinations of arm, base compiled, all fine\n", "")


@pytest.mark.parametrize(
    ("condition", "count", "words"),
    [
        ("true", 6, 'publish the transform into "base_link", below "odom" and "map"\n'),
        ("arm", 3, 'below "odom" and "map" (with arm=true)\n'),
        ("base != 'free'", 4, 'below "odom" and "map" (with base=fixed or tracks)\n'),
        ("arm and base == 'fixed'", 1, 'below "odom" and "map" (with arm=true, base=fixed)\n'),
        ("arm or base == 'fixed'", 4, '"map" (with arm=true, base=free, and in 3 other combinations)\n'),
        ("arm == (base == 'free')", 3, '"map" (with arm=true, base=free, and in 2 other combinations)\n'),
    ],
)
def test_problem_says_with_which_arguments(tmp_path, capsys, condition, count, words):
    code, out, err = checked(tmp_path, capsys, condition)
    assert code == 1
    assert out == f"armed: 6 combinations of arm, base compiled, {count} with errors\n"
    assert err.count("error[two-publishers]") == 1
    assert words in err
    assert "also published here, by ekf" in err


def test_what_the_run_sets_is_not_varied(tmp_path, capsys):
    assert checked(tmp_path, capsys, "arm", "-a", "arm=false")[:2] == (
        0,
        "armed: 3 combinations of base compiled, all fine\n",
    )
    code, out, _ = checked(tmp_path, capsys, "arm", "-a", "arm=true", "-a", "base=free")
    assert (code, out) == (1, "armed: no argument with a list of values is left open; compiled once, with errors\n")


def test_wrong_value_is_told_once(tmp_path, capsys):
    code, out, err = checked(tmp_path, capsys, "arm", "-a", "base=rails")
    assert (code, out) == (1, "")
    assert err.count("error[bad-argument]") == 1


def test_cap_is_said(tmp_path, capsys):
    path = tmp_path / "many.yaml"
    names = [f"a{n}" for n in range(9)]
    args = "".join(f"  {name}: {{type: boolean, default: false}}\n" for name in names)
    path.write_text(f"robot: many\nargs:\n{args}links: {{base_link: {{}}}}\n", "utf-8")
    assert main(["check", str(path), "--every-argument"]) == 0
    assert f"256 of 512 combinations of {', '.join(names)} compiled, all fine; set some" in capsys.readouterr().out


CHOICES = st.lists(st.integers(1, 3), min_size=1, max_size=4).map(
    lambda sizes: [(f"a{n}", tuple(f"v{value}" for value in range(size))) for n, size in enumerate(sizes)]
)


@given(CHOICES)
@settings(max_examples=200, deadline=None)
def test_every_combination_comes_once_the_nearest_first(varied):
    found = list(combinations(varied))
    assert sorted(found) == sorted(itertools.product(*(values for _, values in varied)))
    defaults = found[0]
    near = [sum(a != b for a, b in zip(one, defaults, strict=True)) <= 1 for one in found]
    assert near == sorted(near, reverse=True)


MESHED = """robot: m
args:
  arm: {default: short, one_of: [short, long]}
links:
  base: {collision: [{mesh: {file: "${arm}.stl"}}]}
outputs: {urdf: {file: m.urdf}, mjcf: {file: m.xml}}
"""


def test_a_mesh_that_one_value_lacks_is_found(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = home / "descriptions/m"
    folder.mkdir(parents=True)
    (folder / "robot.yaml").write_text(MESHED)
    (folder / "short.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    (folder / "robot.yaml").write_text(MESHED.replace(".stl", ".obj"))
    assert main(["check", "--every-argument"]) == 1
    shown = capsys.readouterr()
    message = "error[mesh-not-found]: mesh long.obj is not there, neither as seen from the artifacts nor beside the"
    assert f"{message} description (with arm=long)\n" in shown.err
    assert shown.out == "m: 2 combinations of arm compiled, 1 with errors\n"
    (folder / "long.obj").write_text((folder / "short.obj").read_text())
    assert main(["check", "--every-argument"]) == 0

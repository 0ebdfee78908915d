"""The public Python API: lazy, never raising for what is wrong with the input, and the same as the command line."""

import gc
import os
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rosorin_compile
from rosorin_compile import Compiled, Difference, Reading, Robot
from rosorin_compile.cli.main import main
from rosorin_compile.model import Edge, Link, Publisher
from rosorin_compile.source.diagnostics import has_errors
from support.paths import OUTPUTS, ROOT, ROSORIN, data_text
from support.robots import copy_of_rosorin

SMALL = data_text("robots/api_small.yaml")


@pytest.fixture
def small(tmp_path: Path) -> Path:
    path = tmp_path / "small" / "robot.yaml"
    path.parent.mkdir()
    path.write_text(SMALL, "utf-8")
    return path


def texts(compiled: Compiled) -> dict[str, str]:
    assert compiled.robot is not None, compiled.diagnostics
    return {artifact.file: artifact.text for artifact in compiled.artifacts}


def told(result: Compiled | Reading | Difference) -> list[str]:
    assert has_errors(result.diagnostics)
    if isinstance(result, Difference):
        assert (result.a, result.b, result.same, result.items) == (None, None, False, ())
    else:
        assert result.robot is None
        assert getattr(result, "artifacts", ()) == ()
    assert isinstance(str(result) + repr(result), str)
    return [str(diagnostic) for diagnostic in result.diagnostics]


# ---- The package ----


def test_importing_the_package_loads_nothing_but_typing() -> None:
    program = (
        "import sys, typing; before = set(sys.modules); import rosorin_compile; rosorin_compile.__version__; "
        "dir(rosorin_compile); print(*sorted(set(sys.modules) - before))"
    )
    ran = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert all(name.startswith("rosorin_compile") for name in ran.stdout.split())


# ---- compile ----


def test_file_folder_and_name_are_one_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    forms: list[Any] = ["rosorin", "descriptions/rosorin", ROSORIN.parent, str(ROSORIN), ROSORIN, Path("rosorin")]
    first, *others = [texts(rosorin_compile.compile(form)) for form in forms]
    assert all(other == first for other in others)
    assert first == {path.name: path.read_text("utf-8") for path in OUTPUTS.iterdir()}


def test_artifacts_are_those_of_the_command_line(small: Path, tmp_path: Path) -> None:
    outputs = tmp_path / "outputs"
    assert main(["all", str(small), "-a", "length=5 cm", "-a", "tall=true", "-o", str(outputs)]) == 0
    made = texts(rosorin_compile.compile(small, {"length": "5 cm", "tall": True}))
    assert made == {path.name: path.read_text("utf-8") for path in outputs.iterdir()}


ENDLESS: list[Any] = []
ENDLESS.append(ENDLESS)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary() | st.complex_numbers(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text() | st.integers(), inner, max_size=4),
    max_leaves=8,
)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(["length", "count", "tall", "title", "offset", "limit", "extra"]), VALUES)
def test_no_argument_raises(tmp_path_factory: pytest.TempPathFactory, name: str, value: object) -> None:
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    if not path.exists():
        path.write_text(SMALL, "utf-8")
    made = rosorin_compile.compile(path, {name: value})
    assert (made.robot is None) == has_errors(made.diagnostics)


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_a_file_that_may_not_be_read(small: Path) -> None:
    small.chmod(0)
    assert "Permission denied" in told(rosorin_compile.compile(small))[0]
    small.parent.chmod(0)
    try:
        assert told(rosorin_compile.compile(small))
    finally:
        small.parent.chmod(0o700)


# ---- read ----


# ---- diff ----


def test_lines_are_those_of_the_command_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    words = ["rosorin", "outputs/rosorin/rosorin.urdf"]
    assert main(["diff", *words, "--full"]) == 0
    assert capsys.readouterr().out == f"{rosorin_compile.diff(*words)}\n"


# ---- A robot in a notebook ----


@pytest.fixture(scope="module")
def robot() -> Robot:
    made = rosorin_compile.compile(ROSORIN).robot
    assert made is not None
    return made


def test_transform_at_a_named_pose_is_that_of_tf(robot: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tf", str(ROSORIN), "base_link", "camera_link", "--pose", "tuck", "--csv"]) == 0
    numbers = [float(number) for number in capsys.readouterr().out.splitlines()[-1].split(",")]
    transform = robot.transform("base_link", "camera_link", pose="tuck")
    assert [*transform.xyz, *transform.rpy()] == pytest.approx(numbers[:6], abs=1e-12)
    assert transform == robot.transform("base_link", "camera_link", robot.positions("tuck"))
    assert transform != robot.transform("base_link", "camera_link")
    assert robot.transform("base_link", "camera_link") == robot.transform("base_link", "camera_link", {})


def test_the_tree_of_frames_in_html(robot: Robot) -> None:
    from rosorin_compile.source.xml.elements import tree_of

    rows = tree_of(robot._repr_html_()).findall("./tbody/tr")
    cells = [tuple(cell.text or "" for cell in row) for row in rows]
    assert cells[:4] == [
        ("map", "", "", "", ""),
        ("odom", "slam_toolbox", "/tf", "", "slam"),
        ("\u2191 map", "amcl", "/tf", "", "not slam"),
        ("base_link", "ekf", "/tf", "", ""),
    ]
    assert ("laser", "tf_base_laser", "/tf_static", "lidar_joint (fixed)", "") in cells
    assert {row[0].removeprefix("\u2191 ") for row in cells} >= set(robot.frames)


def test_html_is_escaped_and_bounded() -> None:
    evil = "<script>alert('&')</script>"
    node = Publisher("node", evil)
    links = tuple(Link(f"{evil}{number}") for number in range(700))
    edges = tuple(Edge(links[0].name, link.name, node, moving=True, when=evil) for link in links[1:])
    text = Robot(evil, links, (), edges=edges)._repr_html_()
    assert "<script" not in text
    assert "&lt;script&gt;" in text
    assert "and 200 more" in text


# ---- Manners ----


def test_threads_get_the_same_robot(small: Path) -> None:
    def one(number: int) -> tuple[dict[str, str], dict[str, str]]:
        return texts(rosorin_compile.compile(ROSORIN)), texts(rosorin_compile.compile(small, {"length": number}))

    alone = [one(number) for number in range(1, 5)]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(one, range(1, 5))) == alone


@pytest.mark.parametrize("collecting", [True, False])
def test_nothing_is_printed_or_written_and_gc_is_left_alone(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, collecting: bool
) -> None:
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    path = copy_of_rosorin(tmp_path / "project")
    before = {file: file.stat().st_mtime_ns for file in (tmp_path / "project").rglob("*")}
    was = gc.isenabled()
    (gc.enable if collecting else gc.disable)()
    try:
        assert rosorin_compile.compile(path).robot is not None
        assert rosorin_compile.compile(path, {"nothing": 1}).robot is None
        assert rosorin_compile.diff(path, OUTPUTS / "rosorin.urdf").same
        assert gc.isenabled() == collecting
    finally:
        (gc.enable if was else gc.disable)()
    assert capfd.readouterr() == ("", "")
    assert {file: file.stat().st_mtime_ns for file in (tmp_path / "project").rglob("*")} == before


def test_the_folder_of_the_process_matters_for_relative_names_alone(
    small: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = texts(rosorin_compile.compile(small))
    monkeypatch.chdir(small.parent)
    assert texts(rosorin_compile.compile("robot.yaml")) == expected
    assert texts(rosorin_compile.compile(".")) == expected
    monkeypatch.chdir(small.parent.parent)
    assert texts(rosorin_compile.compile("small")) == expected
    assert told(rosorin_compile.compile("robot.yaml"))


@pytest.mark.parametrize("path", [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))], ids=lambda path: path.parent.name)
def test_what_is_compiled_can_be_sent_to_another_process(path: Path) -> None:
    compiled = rosorin_compile.compile(path)
    again = pickle.loads(pickle.dumps(compiled))  # noqa: S301 - our own
    assert again == compiled
    assert again.robot == compiled.robot
    assert [str(one) for one in again.diagnostics] == [str(one) for one in compiled.diagnostics]

"""The public Python API: lazy, never raising for what is wrong with the input, and the same as the command line."""

import gc
import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from fractions import Fraction
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
URDF = '<robot name="one"><link name="base"/></robot>'
RAW = {
    "empty.yaml": b"",
    "zeros.yaml": b"\0" * 100,
    "latin.yaml": "robot: m\u00e4h".encode("latin-1"),
    "list.yaml": b"- 1\n- 2\n",
    "syntax.yaml": b"robot: [",
    "deep.yaml": b"a: " + b"[" * 5000,
    "anchors.yaml": b"a: &a [1]\nb: [*c]\n",
    "cycle.yaml": b"robot: c\ninclude: [cycle.yaml]\nlinks: {a: }\n",
    "huge.yaml": b"robot: h\n" + b"# a comment\n" * 2_000_000,
    "noise.yaml": bytes(range(256)) * 4,
    "broken.urdf": b"<robot",
    "other.urdf": b"<sdf/>",
    "list.json": b"[1, 2",
    "none.xacro": b"\xff\xfe",
    "noise.xml": bytes(range(256)) * 4,
}


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


def test_what_there_is_to_say_has_rule_severity_message_and_place() -> None:
    made = rosorin_compile.compile(ROSORIN)
    first = made.diagnostics[0]
    assert (first.rule, first.severity) == ("stand-in", "note")
    assert first.message.startswith("effort and velocity of the arm servos")
    assert first.span is not None
    assert (Path(first.span.source.path).name, first.span.line, first.span.column) == ("arm.yaml", 13, 38)
    assert str(first).endswith(f"arm.yaml:13:38: note[stand-in]: {first.message}")
    assert len(repr(first)) < 500
    assert {path.name for path in made.inputs} == {path.name for path in ROSORIN.parent.glob("*.yaml")}
    robot = "<Robot rosorin: 60 links, 59 joints (51 that move), 3 sensors>"
    assert repr(made).startswith(f"<Compiled {robot}, 16 artifacts, ")
    assert len(repr(made.artifacts)) < 1000


@pytest.mark.parametrize(
    ("value", "length"),
    [("5 mm", 0.005), ("0.25", 0.25), (0.25, 0.25), (2, 2), (Decimal("0.5"), 0.5), (Fraction(1, 4), 0.25)],
)
def test_numbers_and_texts_as_arguments(small: Path, value: object, length: float) -> None:
    robot = rosorin_compile.compile(small, {"length": value}).robot
    assert robot is not None
    assert robot.joint["tip_joint"].origin.xyz == (length, 0, 0)


def test_other_values_as_arguments(small: Path) -> None:
    limit = {"lower": "-90 deg", "upper": 2, "effort": 1, "velocity": "1 rad/s"}
    arguments = {"tall": True, "title": "007", "count": 3, "offset": (1, 0.5, "2 mm"), "limit": limit, "extra": None}
    robot = rosorin_compile.compile(small, arguments).robot
    assert robot is not None
    assert "007_3" in robot.link
    shoulder = robot.joint["shoulder"]
    assert shoulder.origin.xyz == (1, 0.5, 0.002)
    assert shoulder.limit is not None
    assert (shoulder.limit.lower, shoulder.limit.upper) == (pytest.approx(-1.5707963267948966, abs=1e-15), 2)


def test_values_of_numpy_as_arguments(small: Path) -> None:
    np = pytest.importorskip("numpy")
    arguments = {"offset": np.array([1, 2, 3]), "length": np.float32(0.5), "count": np.int64(2), "tall": np.bool_(True)}
    robot = rosorin_compile.compile(small, {**arguments, "title": "x"}).robot
    assert robot is not None
    assert robot.joint["shoulder"].origin.xyz == (1, 2, 3)
    assert "x_2" in robot.link


ENDLESS: list[Any] = []
ENDLESS.append(ENDLESS)


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ({"lenght": 1}, "unknown-argument"),
        ({"count": 1.5}, "bad-argument"),
        ({"count": "many"}, "bad-argument"),
        ({"length": "5 kg"}, "bad-argument"),
        ({"tall": 1}, "bad-argument"),
        ({"tall": None}, "wrong-type"),
        ({"offset": {"x": 1}}, "bad-argument"),
        ({"offset": {1, 2}}, "bad-argument"),
        ({"offset": [1, 2, object()]}, "bad-argument"),
        ({"offset": b"1"}, "bad-argument"),
        ({"extra": 1j}, "bad-argument"),
        ({"extra": ENDLESS}, "bad-argument"),
        ({"extra": range(10**9)}, "bad-argument"),
        ({"extra": 10**400}, "bad-argument"),
        ({"extra": {1: 2}}, "bad-argument"),
        ({1: 2}, "bad-argument"),
        (["length=1"], "bad-argument"),
        ("length=1", "bad-argument"),
    ],
)
def test_wrong_arguments_are_told(small: Path, arguments: Any, rule: str) -> None:
    assert [one.rule for one in rosorin_compile.compile(small, arguments).diagnostics if one.severity == "error"] == [
        rule
    ]


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


NO_PATHS: list[Any] = [
    None,
    5,
    b"rosorin",
    1.5,
    [],
    object(),
    "",
    "a\0b",
    "\udcff",
    "x" * 300,
    "x/" * 5000,
    "/dev/null",
]
NO_PATHS += ["nothing.yaml", "nothing.urdf", "nothing.xacro", "nothing.json", "/", ".", "..", "~", "small/robot.yaml/x"]


@pytest.mark.parametrize("path", NO_PATHS, ids=lambda path: repr(path)[:20])
def test_what_names_no_robot_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, path: Any) -> None:
    monkeypatch.chdir(tmp_path)
    for result in (rosorin_compile.compile(path), rosorin_compile.read(path), rosorin_compile.diff(path, path)):
        (error,) = told(result)
        assert error.startswith(("error[file-unreadable]: ", "error[wrong-type]: ")), error


@pytest.mark.parametrize("name", RAW)
def test_what_is_no_robot_is_told(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(RAW[name])
    for result in (rosorin_compile.compile(path), rosorin_compile.read(path), rosorin_compile.diff(path, path)):
        assert any("error[" in line for line in told(result))


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_a_file_that_may_not_be_read(small: Path) -> None:
    small.chmod(0)
    assert "Permission denied" in told(rosorin_compile.compile(small))[0]
    small.parent.chmod(0)
    try:
        assert told(rosorin_compile.compile(small))
    finally:
        small.parent.chmod(0o700)


def test_packages_are_where_the_program_says(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "arm.urdf").write_text(URDF, "utf-8")
    path = tmp_path / "home" / "robot.yaml"
    path.parent.mkdir()
    path.write_text("robot: r\ninclude: [{package: arms, file: arm.urdf}]\n", "utf-8")
    assert "package-missing" in told(rosorin_compile.compile(path))[0]
    packages = {"arms": tmp_path / "elsewhere"}
    robot = rosorin_compile.compile(path, packages=packages).robot
    assert robot is not None
    assert list(robot.link) == ["base"]
    assert rosorin_compile.read(path, packages=packages).robot == robot
    assert rosorin_compile.diff(path, robot, packages=packages).same


@pytest.mark.parametrize("packages", [{"arms": "nowhere"}, {"arms": 5}, {5: "."}, ["arms"], {"arms": "a\0b"}])
def test_wrong_packages_are_told(small: Path, packages: Any) -> None:
    results: list[Compiled | Reading | Difference] = [rosorin_compile.compile(small, packages=packages)]
    results += [rosorin_compile.read(small, packages=packages), rosorin_compile.diff(small, small, packages=packages)]
    for result in results:
        (error,) = told(result)
        assert error.startswith("error[package-missing]: "), error


# ---- read ----


def test_a_description_is_read_as_it_is_compiled() -> None:
    made, read = rosorin_compile.compile(ROSORIN), rosorin_compile.read(ROSORIN)
    assert read.robot == made.robot
    assert set(read.inputs) <= set(made.inputs)
    assert repr(read) == "<Reading <Robot rosorin: 60 links, 59 joints (51 that move), 3 sensors>, 7 notes>"


@pytest.mark.parametrize("file", ["rosorin.urdf", "rosorin.xml", "robot_model.json"])
def test_artifacts_can_be_read(file: str) -> None:
    if file.endswith(".xml"):
        pytest.importorskip("mujoco")
    read = rosorin_compile.read(OUTPUTS / file)
    assert read.robot is not None, read.diagnostics
    assert read.inputs == (OUTPUTS / file,)
    assert "link1" in read.robot.link


def test_arguments_of_a_xacro(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    path = tmp_path / "one.xacro"
    joint = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="$(arg x) 0 0"/></joint>'
    links = '<link name="a"/><xacro:if value="$(arg tall)"><link name="b"/></xacro:if>'
    declared = '<xacro:arg name="x" default="1"/><xacro:arg name="tall" default="false"/>'
    head = '<robot name="one" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    path.write_text(f"{head}{declared}{links}{joint}</robot>", "utf-8")
    read = rosorin_compile.read(path, {"x": 0.25, "tall": True})
    assert read.robot is not None, read.diagnostics
    assert read.robot.joint["j"].origin.xyz == (0.25, 0, 0)
    assert any(diagnostic.rule == "xacro-runs-code" for diagnostic in read.diagnostics)
    error = told(rosorin_compile.read(path, {"x": [1]}))[-1]
    assert error == 'error[bad-argument]: the argument "x" of a xacro is text or a number, not a list'
    assert rosorin_compile.diff(path, path, arguments={"tall": "true"}, b_arguments={"x": 2}).items
    assert told(rosorin_compile.diff(path, path, arguments={"x": [1]}))[-1] == error


def test_only_what_has_arguments_takes_them(tmp_path: Path) -> None:
    path = tmp_path / "one.urdf"
    path.write_text(URDF, "utf-8")
    said = "error[unknown-argument]: one.urdf has no arguments: only a description and a xacro have them"
    assert told(rosorin_compile.read(path, {"x": 1})) == [said]
    assert told(rosorin_compile.diff(path, path, a_arguments={"x": 1})) == [said]


def test_lenient_takes_what_breaks_the_specification(tmp_path: Path) -> None:
    path = tmp_path / "one.urdf"
    path.write_text(URDF.replace("<link", "<!-- a -- b --><link"), "utf-8")
    assert told(rosorin_compile.read(path))
    assert rosorin_compile.read(path, lenient=True).robot is not None


# ---- diff ----


def test_a_difference_has_items_and_lines(small: Path) -> None:
    found = rosorin_compile.diff(small, small, b_arguments={"length": "1.1 m"})
    assert not found.same
    (item,) = found.items
    assert (item.kind, item.name, round(item.distance or 0, 9)) == ("frame", "tip", 0.1)
    assert str(found).splitlines()[-2:] == [item.text, "different: 1 frame"]
    assert repr(found) == "<Difference: different: 1 frame>"
    assert rosorin_compile.diff(small, small, tolerance=0.2, b_arguments={"length": 1.1}).same


def test_lines_are_those_of_the_command_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    words = ["rosorin", "outputs/rosorin/rosorin.urdf"]
    assert main(["diff", *words, "--full"]) == 0
    assert capsys.readouterr().out == f"{rosorin_compile.diff(*words)}\n"


def test_robots_and_files_are_compared(small: Path) -> None:
    robot, other = (rosorin_compile.compile(small, {"length": length}).robot for length in (1, 2))
    assert robot is not None
    assert other is not None
    assert rosorin_compile.diff(robot, small).same
    assert rosorin_compile.diff(robot, robot).same
    assert not rosorin_compile.diff(robot, other).same


@pytest.mark.parametrize("tolerance", [-1, float("nan"), float("inf"), "1", None, True])
def test_a_wrong_tolerance_is_told(small: Path, tolerance: Any) -> None:
    (error,) = told(rosorin_compile.diff(small, small, tolerance))
    assert error == f"error[bad-argument]: the tolerance is a number from zero upwards, not {tolerance}"


def test_one_side_that_cannot_be_read_is_told(small: Path, tmp_path: Path) -> None:
    found = rosorin_compile.diff(small, tmp_path / "nothing.urdf")
    (error,) = told(found)
    assert str(found).splitlines() == [error, "not compared"]
    with pytest.raises(ValueError, match="could not be read"):
        _ = found.sides


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


def test_positions_win_over_the_pose(robot: Robot) -> None:
    moved = robot.transform("base_link", "camera_link", {"joint1": 0.5}, pose="tuck")
    assert moved == robot.transform("base_link", "camera_link", {**robot.positions("tuck"), "joint1": 0.5})
    assert moved != robot.transform("base_link", "camera_link", pose="tuck")


@pytest.mark.parametrize(
    ("ask", "help"),
    [
        (lambda r: r.link["lasr"], '"laser"'),
        (lambda r: r.joint["joint11"], '"joint1"'),
        (lambda r: r.transform("base_link", "lasr"), '"laser"'),
        (lambda r: r.transform("bas_link", "laser"), '"base_link"'),
        (lambda r: r.transform("odom", "laser"), "slam_toolbox"),
        (lambda r: r.transform("base_link", "laser", pose="tuk"), '"tuck"'),
        (lambda r: r.positions("tuk"), '"tuck"'),
        (lambda r: r.transform("base_link", "laser", {"joint9": 1}), '"joint5"'),
    ],
)
def test_unknown_names_have_a_way_out(robot: Robot, ask: Callable[[Robot], object], help: str) -> None:
    with pytest.raises(KeyError) as raised:
        ask(robot)
    assert help in str(raised.value)


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

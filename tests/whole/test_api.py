"""The public Python API: never raising for what is wrong with the input, and the same as the command line."""

import gc
import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rosorin_compile
from rosorin_compile import CompileResult, Robot
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


def texts(compiled: CompileResult) -> dict[str, str]:
    assert compiled.robot is not None, compiled.diagnostics
    return {artifact.file: artifact.text for artifact in compiled.artifacts}


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


def test_html_is_escaped_and_bounded() -> None:
    evil = "<script>alert('&')</script>"
    node = Publisher("node", evil)
    links = tuple(Link(f"{evil}{number}") for number in range(700))
    edges = tuple(Edge(links[0].name, link.name, node, moving=True, when=evil) for link in links[1:])
    text = Robot(evil, links, (), edges=edges)._repr_html_()
    assert "<script" not in text
    assert "&lt;script&gt;" in text
    assert "and 200 more" in text


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


@pytest.mark.parametrize(
    "path", [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))], ids=lambda path: path.parent.name
)
def test_what_is_compiled_can_be_sent_to_another_process(path: Path) -> None:
    compiled = rosorin_compile.compile(path)
    again = pickle.loads(pickle.dumps(compiled))  # noqa: S301 - our own
    assert again == compiled
    assert again.robot == compiled.robot
    assert [str(one) for one in again.diagnostics] == [str(one) for one in compiled.diagnostics]

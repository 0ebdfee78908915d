"""Stamps: a run is left out only if it would do the same again, and an odd stamp is no stamp."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile import project
from rosorin_compile.output import stamp
from rosorin_compile.output.stamp import recall, remember
from rosorin_compile.startup import again, cache

KEY = {"description": "/robots/r.yaml", "arguments": {"a": "1"}, "form": ["text", False]}
SAID = ["warning: ä\n", {"n": [1, 2.5, None]}]


class Run:
    """A run that was remembered: its inputs, its artifacts and where its stamp is."""

    def __init__(self, base: Path) -> None:
        self.folder = base / "out"
        self.texts = {f"{'sub/' if at % 3 == 2 else ''}o{at}.xml": f"ä{at}\n" * 3000 for at in range(6)}
        for name, text in self.texts.items():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_bytes(text.encode())
        self.inputs = [base / f"i{at}.yaml" for at in range(12)]
        for path in self.inputs:
            path.write_text(f"{path.name}: 1\n" * 500)
        self.stamps = base / "cache" / "stamps"

    def remember(self, **more):
        remember(KEY, self.inputs, self.texts, SAID, **more)

    def recall(self, key=KEY):
        return recall(key, self.folder)

    def stamp(self):
        [path] = self.stamps.iterdir()
        return path


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    return Run(tmp_path)


@pytest.fixture
def remembered(run):
    assert run.recall() is None
    run.remember()
    assert run.recall() == SAID
    return run


def test_the_order_of_a_key_does_not_matter_but_the_rest_does(remembered):
    assert remembered.recall(dict(reversed(KEY.items()))) == SAID
    assert remembered.recall({**KEY, "arguments": {"a": "2"}}) is None
    assert remembered.recall({}) is None
    assert recall({"odd": object()}, remembered.folder) is None


def test_inputs_count_by_content(remembered):
    path, text = remembered.inputs[7], remembered.inputs[7].read_text()
    path.write_text(text + " ")
    assert remembered.recall() is None
    path.unlink()
    assert remembered.recall() is None
    path.mkdir()
    assert remembered.recall() is None
    path.rmdir()
    path.write_text(text)
    os.utime(path, (1, 1))
    assert remembered.recall() == SAID


def test_a_change_that_size_and_time_do_not_show(remembered):
    path = remembered.inputs[0]
    status = path.stat()
    path.write_text(path.read_text().replace("1", "2"))
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert remembered.recall() is None


@pytest.mark.parametrize("name", ["o0.xml", "sub/o2.xml"])
def test_artifacts_count_by_content(remembered, name):
    path = remembered.folder / name
    data = path.read_bytes()
    path.write_bytes(data[:-1] + b"x")
    assert remembered.recall() is None
    path.unlink()
    assert remembered.recall() is None
    (remembered.folder.parent / "same").write_bytes(data)
    path.symlink_to(remembered.folder.parent / "same")
    assert remembered.recall() is None
    path.unlink()
    path.write_bytes(data)
    assert remembered.recall() == SAID


@pytest.mark.parametrize("name", ["more.txt", "sub/more.txt", ".hidden", "new/more.txt"])
def test_another_file_among_the_artifacts(remembered, name):
    (remembered.folder / name).parent.mkdir(exist_ok=True)
    assert remembered.recall() == SAID
    (remembered.folder / name).write_text("")
    assert remembered.recall() is None


def test_no_output_folder(remembered):
    remembered.folder.rename(remembered.folder.with_name("away"))
    assert remembered.recall() is None
    assert recall(KEY, Path("a\0b")) is None


def test_another_tool(remembered, monkeypatch, tmp_path):
    with monkeypatch.context() as patch:
        patch.setattr(stamp, "__version__", "9")
        assert remembered.recall() is None
    with monkeypatch.context() as patch:
        patch.setattr(project, "data_folder", lambda _: tmp_path / "out")
        assert remembered.recall() is None
    with monkeypatch.context() as patch:
        patch.setattr(sys, "version", "4.0")
        assert remembered.recall() is None
    assert remembered.recall() == SAID


def test_each_file_of_the_tool_counts(run, monkeypatch, tmp_path):
    tool = tmp_path / "tool"
    for name in (
        "stamp.py",
        "emit/urdf.py",
        "emit/__pycache__/urdf.pyc",
        "templates/t.jinja",
        "schemas/s.json",
        "parts_library/p.yaml",
        "viewer/page.js",
    ):
        (tool / name).parent.mkdir(parents=True, exist_ok=True)
        (tool / name).write_text("one")
    monkeypatch.setattr(project, "__file__", str(tool / "project" / "__init__.py"))
    monkeypatch.setattr(project, "data_folder", lambda name: tool / name)
    run.remember()
    for name in ("stamp.py", "emit/urdf.py", "templates/t.jinja", "parts_library/p.yaml", "viewer/page.js"):
        status = (tool / name).stat()
        os.utime(tool / name, ns=(0, status.st_mtime_ns + 1))
        assert run.recall() is None
        (tool / name).write_text("three")
        os.utime(tool / name, ns=(0, status.st_mtime_ns))
        assert run.recall() is None
        (tool / name).write_text("one")
        os.utime(tool / name, ns=(0, status.st_mtime_ns))
        assert run.recall() == SAID
    (tool / "emit" / "__pycache__" / "more.pyc").write_text("compiled")
    assert run.recall() == SAID
    (tool / "emit" / "new.py").write_text("")
    assert run.recall() is None


@pytest.mark.slow
def test_a_stamp_that_was_cut_off(remembered):
    path, data = remembered.stamp(), remembered.stamp().read_bytes()
    for length in range(len(data)):
        path.write_bytes(data[:length])
        assert remembered.recall() is None
    path.unlink()
    path.mkdir()
    assert remembered.recall() is None
    remembered.remember()
    assert remembered.recall() is None


PLAIN = st.none() | st.booleans() | st.integers() | st.text(max_size=3)
PARTS = st.sampled_from(["tool", "inputs", "outputs", "messages", "o0.xml"])
JSON = st.recursive(PLAIN, lambda inner: st.lists(inner) | st.dictionaries(PARTS, inner))


@given(st.binary() | JSON.map(lambda value: json.dumps(value).encode()) | st.just(b"[" * 100_000))
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_stamp_that_is_not_ours(remembered, data):
    path, before = remembered.stamp(), remembered.stamp().read_bytes()
    try:
        path.write_bytes(data)
        assert remembered.recall() is None
        cache.keep(path, data)
        assert remembered.recall() is None
    finally:
        path.write_bytes(before)


@pytest.mark.parametrize("part", ["tool", "inputs", "outputs", "messages"])
@pytest.mark.parametrize("value", [None, 1, "x", ["x"], {"x": 1}, {}])
def test_a_stamp_with_one_wrong_part(remembered, part, value):
    path = remembered.stamp()
    content = json.loads(cache.recalled(path))
    cache.keep(path, json.dumps({**content, part: value}).encode())
    expected = {("inputs", "{}"): SAID, ("messages", "['x']"): ["x"]}
    assert remembered.recall() == expected.get((part, str(value)))


def test_inputs_that_were_changed_during_the_run(run):
    old = time.time_ns() - 10**9
    run.remember(begun=old)
    assert run.recall() is None
    time.sleep(0.03)  # the clock of file times moves in steps, of 10 ms on some systems
    begun = again.now()
    run.remember(begun=begun)
    assert run.recall() == SAID
    run.inputs[3].write_text("changed while it was read")
    os.utime(run.inputs[3], (1, 1))
    run.remember(begun=begun)
    assert run.recall() is None


def test_artifacts_that_are_not_what_was_written(run):
    (run.folder / "o0.xml").write_text("another run")
    run.remember()
    assert run.recall() is None


def test_inputs_that_cannot_be_read(run):
    run.inputs.append(run.folder / "missing")
    run.remember()
    assert not list(run.stamps.iterdir())


def test_relative_inputs(run, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    run.inputs = [path.relative_to(tmp_path) for path in run.inputs]
    run.remember()
    monkeypatch.chdir("/")
    assert run.recall() == SAID


def test_without_a_cache(run, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    for place in ("off", str(tmp_path / "file")):
        monkeypatch.setenv("ROSORIN_COMPILE_CACHE", place)
        run.remember()
        assert run.recall() is None


def test_a_write_that_fails_is_silent_and_leaves_nothing(remembered, monkeypatch):
    def broken(*_):
        raise OSError("broken")

    before = remembered.stamp().read_bytes()
    monkeypatch.setattr(Path, "replace", broken)
    remembered.remember()
    assert remembered.stamp().read_bytes() == before


def test_old_stamps_go(run, monkeypatch):
    monkeypatch.setattr(cache, "MAX_KEPT", 10)
    for number in range(30):
        remember({"number": number}, [], run.texts, [number])
        assert recall({"number": number}, run.folder) == [number]
    assert 5 <= len(list(run.stamps.iterdir())) <= 11


def test_imports_nothing_that_compiling_needs():
    code = "import sys, rosorin_compile.output.stamp; print(*sys.modules)"
    modules = set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.split())
    assert "rosorin_compile.output.stamp" in modules
    assert not modules & {"yaml", "jinja2", "jsonschema_rs", "ctypes", "shutil", "rosorin_compile.frontend.load"}


def test_recalling_is_fast(remembered):
    times = []
    for _ in range(20):
        start = time.perf_counter()
        assert remembered.recall() == SAID
        times.append(time.perf_counter() - start)
    assert min(times) < 0.01  # below 1 ms was measured; this is for slow machines

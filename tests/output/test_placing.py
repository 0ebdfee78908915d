"""Placing files into a folder that holds other things: all or nothing, never outside, never through a link."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from rosorin_compile.output.placing import READY, holding, place

from rosorin_compile.output import OutputError, placing
from support.kills import ended_at

NEW = {"urdf/a.urdf": b"new a", "config/b.json": b"new b", "launch/c.py": b"new c"}
STALE = ".rosorin-compile-0123456789abcdef"
OLD = {"urdf/a.urdf": b"old a", "config/b.json": b"old b", "config/other.yaml": b"other"}


def fill(folder: Path) -> Path:
    for name, data in OLD.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_writes_the_set_and_keeps_the_rest(tmp_path: Path) -> None:
    written = place(fill(tmp_path), {**NEW, "config/b.json": b"old b"})
    assert written == ("launch/c.py", "urdf/a.urdf")
    assert contents(tmp_path) == {**OLD, **NEW, "config/b.json": b"old b"}


def test_touches_nothing_that_is_equal(tmp_path: Path) -> None:
    place(tmp_path, NEW)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    assert place(tmp_path, NEW) == ()
    assert before == {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}


def test_keeps_permissions(tmp_path: Path) -> None:
    (fill(tmp_path) / "urdf/a.urdf").chmod(0o640)
    place(tmp_path, NEW)
    assert (tmp_path / "urdf/a.urdf").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("name", ["../a", "/etc/a", "a//b", "./a", "a/..", ".git/hooks/a", "a\nb", ""])
def test_never_outside(tmp_path: Path, name: str) -> None:
    folder = fill(tmp_path / "in")
    with pytest.raises(OutputError, match="does not stand in the folder") as raised:
        place(folder, {**NEW, name: b"x"})
    assert raised.value.diagnostic.rule == "deploy-outside"
    assert contents(tmp_path) == {f"in/{name}": data for name, data in OLD.items()}


@pytest.mark.parametrize("link", ["urdf", "urdf/a.urdf", "launch"])
def test_never_through_a_link(tmp_path: Path, link: str) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "file").write_bytes(b"safe")
    folder = fill(tmp_path / "in")
    place_of_link = folder / link
    if place_of_link.is_dir():
        (place_of_link / "a.urdf").unlink()
        place_of_link.rmdir()
    elif place_of_link.exists():
        place_of_link.unlink()
    place_of_link.symlink_to(outside / "file" if link.endswith("a.urdf") else outside)
    before = contents(folder)
    with pytest.raises(OutputError, match=r"is a symbolic link to .*; nothing is written through links") as raised:
        place(folder, NEW)
    assert raised.value.diagnostic.rule == "deploy-link"
    assert contents(outside) == {"file": b"safe"}
    assert contents(folder) == before


def test_a_folder_that_is_itself_a_link_is_what_was_named(tmp_path: Path) -> None:
    fill(tmp_path / "real")
    (tmp_path / "link").symlink_to("real")
    place(tmp_path / "link", NEW)
    assert contents(tmp_path / "real") == {**OLD, **NEW}


@pytest.mark.parametrize(("name", "what"), [("urdf", "a file"), ("config/other.yaml/x", "a folder")])
def test_what_stands_in_the_way(tmp_path: Path, name: str, what: str) -> None:
    with pytest.raises(OutputError, match=f"is not {what}") as raised:
        place(fill(tmp_path), {**NEW, name: b"x"})
    assert raised.value.diagnostic.rule == "deploy-in-the-way"
    assert contents(tmp_path) == OLD


def killing(monkeypatch: pytest.MonkeyPatch, at: int, problem: BaseException) -> None:
    """Let the step number ``at`` of all that changes the disk fail."""
    count = iter(range(1_000_000))

    def failing(real: Callable[..., Any]) -> Callable[..., Any]:
        def step(*arguments: Any, **more: Any) -> Any:
            if next(count) == at:
                raise problem
            return real(*arguments, **more)

        return step

    for owner, name in ((Path, "mkdir"), (Path, "rename"), (Path, "replace"), (os, "fsync"), (os, "link")):
        monkeypatch.setattr(owner, name, failing(getattr(owner, name)))


@pytest.mark.parametrize("at", range(1, 16))
def test_a_failure_at_any_step_leaves_the_old_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at: int) -> None:
    fill(tmp_path)
    with monkeypatch.context() as patch:
        killing(patch, at, OSError(errno.ENOSPC, "No space left on device"))
        rule = ""
        try:
            place(tmp_path, NEW)
        except OutputError as problem:
            rule = problem.diagnostic.rule
    assert (rule, contents(tmp_path)) in (("deploy-failed", OLD), ("", {**OLD, **NEW}))
    place(tmp_path, NEW)
    assert contents(tmp_path) == {**OLD, **NEW}


def test_a_list_that_somebody_planted_leads_nowhere(tmp_path: Path) -> None:
    folder = fill(tmp_path / "in")
    (folder / READY).mkdir()
    (folder / READY / "0").write_bytes(b"planted")
    (folder / READY / "list.json").write_text(json.dumps(["../escaped"]))
    place(folder, NEW)
    assert contents(tmp_path) == {f"in/{name}": data for name, data in {**OLD, **NEW}.items()}


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_no_right_to_write(tmp_path: Path) -> None:
    (fill(tmp_path) / "config").chmod(0o500)
    with pytest.raises(OutputError, match=r"cannot write into .*: Permission denied"):
        place(tmp_path, NEW)
    assert contents(tmp_path) == OLD


@pytest.mark.parametrize("name", [READY, STALE])
@pytest.mark.parametrize(
    "rest",
    [
        {},
        {"0": "x"},
        {"old-0": "x", "7": "y"},
        {"list.json": "", "0": "x"},
        {"list.json": "3"},
        {"list.json": "null"},
        {"list.json": '"urdf/a.urdf"', "0": "x"},
        {"list.json": '["urdf/a.urdf", 3]', "0": "x"},
        {"list.json": '["../a"]', "0": "x"},
        {"list.json": '["config"]', "0": "x"},
        {"list.json": '["urdf/a.urdf"', "0": "x"},
        {"list.json": "[" * 100_000, "0": "x"},
    ],
)
def test_what_a_killed_run_left_is_mended(tmp_path: Path, name: str, rest: dict[str, str]) -> None:
    fill(tmp_path)
    (tmp_path / name).mkdir()
    for file, text in rest.items():
        (tmp_path / name / file).write_text(text)
    assert place(tmp_path, NEW) == tuple(sorted(NEW))
    assert contents(tmp_path) == {**OLD, **NEW}
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_the_rest_of_a_run_goes_where_nothing_is_to_be_written(tmp_path: Path) -> None:
    """Killed while it cleared up: all files stand in their places, the folder of the run too."""
    place(fill(tmp_path), NEW)
    (tmp_path / STALE).mkdir()
    (tmp_path / STALE / "old-0").write_text("x")
    assert place(tmp_path, NEW) == ()
    assert contents(tmp_path) == {**OLD, **NEW}
    assert not (tmp_path / STALE).exists()


@pytest.mark.parametrize("what", ["file", "link to a folder", "link to nothing", "folder", "folder of a folder"])
def test_what_no_run_has_made_is_put_aside(tmp_path: Path, what: str) -> None:
    folder = fill(tmp_path / "in")
    path, kept = folder / READY, folder / f"{READY}.kept"
    if what == "file":
        path.write_text("mine")
    elif what.startswith("link"):
        (tmp_path / "out").mkdir()
        (tmp_path / "out" / "mine.txt").write_text("mine")
        path.symlink_to(tmp_path / ("out" if what == "link to a folder" else "nothing"))
    else:
        inner = path / "0" if what == "folder of a folder" else path
        inner.mkdir(parents=True)
        (inner / "mine.txt").write_text("mine")
    assert place(folder, NEW) == tuple(sorted(NEW))
    assert {n: d for n, d in contents(folder).items() if not n.startswith(".")} == {**OLD, **NEW}
    assert os.path.lexists(kept)
    assert not os.path.lexists(path)
    if what != "link to nothing":
        found = [kept.read_text()] if what == "file" else [one.read_text() for one in kept.rglob("mine.txt")]
        assert found in (["mine"], []) if what.startswith("link") else found == ["mine"]
        assert not what.startswith("link") or (tmp_path / "out" / "mine.txt").read_text() == "mine"


def killed_at(step: int, folder: Path) -> int:
    """Place the new files in a process that is ended at a step; return its exit code."""
    return ended_at(step, lambda: place(folder, NEW))


@pytest.mark.slow
@pytest.mark.parametrize("there", [True, False])
def test_a_kill_at_each_call_is_mended_by_the_next_run(tmp_path: Path, there: bool) -> None:
    step, code, mixed = 0, 1, 0
    while code:
        step += 1
        before, top = OLD if there else {}, tmp_path / str(step)
        top.mkdir()
        folder = fill(top / "in") if there else top / "in"
        code = killed_at(step, folder)
        shown = {name: data for name, data in contents(folder).items() if not name.startswith(".")}
        if shown not in (before, {**before, **NEW}):
            assert (folder / READY).is_dir(), "the folder itself says that it is between two sets"
            mixed += 1
        assert all(shown.get(name) in (before.get(name), NEW.get(name)) for name in {**before, **NEW})
        more = {"more": b"more"}
        with holding(folder) as held:
            assert held.finished.left == ()
            held.place(more)
        assert contents(folder) in ({**before, **more}, {**before, **NEW, **more}), step
        place(folder, NEW)
        assert contents(folder) == {**before, **NEW, **more}
        assert not [path for path in (*folder.iterdir(), *top.iterdir()) if path.name.startswith(".")]
    assert step > 25
    assert mixed == (len(NEW) - 1) * there


def between(tmp_path: Path) -> tuple[Path, set[str]]:
    """Return a folder in which a run was killed between two files, and the names of those that it did not reach."""
    for step in range(1, 200):
        folder = fill(tmp_path / str(step))
        assert killed_at(step, folder)
        if (folder / READY).is_dir() and len({*NEW} - {*contents(folder)}) == 0:
            return folder, {name for name, data in NEW.items() if contents(folder)[name] != data}
    raise AssertionError("no run was killed between two files")


@pytest.mark.parametrize("name", sorted(NEW))
def test_what_is_changed_after_a_kill_stays(tmp_path: Path, name: str) -> None:
    folder, waiting = between(tmp_path)
    assert 0 < len(waiting) < len(NEW)
    (folder / name).write_bytes(b"an hour of work")
    with holding(folder, dry=True) as held:
        would = held.finished
    before = contents(folder)
    with holding(folder) as held:
        assert held.finished == would
        assert set(would.left) == {name} & waiting
        assert set(would.put) == waiting - {name}
        assert {line.rule for line in would.diagnostics()} == {"deploy-finished"}
        assert all(any(file in line.message for line in would.diagnostics()) for file in waiting)
    assert (folder / name).read_bytes() == b"an hour of work"
    assert contents(folder) == {**OLD, **NEW, name: b"an hour of work"} != before


@pytest.mark.parametrize("how", ["gone", "folder", "link"])
def test_what_became_of_a_place_after_a_kill(tmp_path: Path, how: str) -> None:
    folder, waiting = between(tmp_path)
    (name,) = list(waiting)[:1]
    (folder / name).unlink()
    if how == "folder":
        (folder / name).mkdir()
    elif how == "link":
        (tmp_path / "mine").write_bytes(b"mine")
        (folder / name).symlink_to(tmp_path / "mine")
    with holding(folder) as held:
        assert held.finished.left == (() if how == "gone" else (name,))
    if how == "gone":
        assert contents(folder) == {**OLD, **NEW}
    assert how != "link" or (tmp_path / "mine").read_bytes() == b"mine"


def test_a_set_that_came_with_a_copy_counts_for_nothing(tmp_path: Path) -> None:
    """A repository or an archive brings along whatever it likes; where it was made, nobody can say of a copy."""
    folder, waiting = between(tmp_path)
    shutil.copytree(folder, tmp_path / "copy")
    before = {name: data for name, data in contents(tmp_path / "copy").items() if name in {**OLD, **NEW}}
    with holding(tmp_path / "copy") as held:
        assert held.finished.put == held.finished.left == ()
    assert contents(tmp_path / "copy") == before
    assert waiting


def test_a_file_that_is_saved_meanwhile_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fill(tmp_path)
    move = placing._move_all

    def saved(root: Path, entries: Sequence[placing.Entry]) -> None:
        (root / "urdf/a.urdf").write_bytes(b"an hour of work")
        move(root, entries)

    monkeypatch.setattr(placing, "_move_all", saved)
    with pytest.raises(OutputError, match=r"a\.urdf was changed just now: nothing is written"):
        place(tmp_path, NEW)
    assert contents(tmp_path) == {**OLD, "urdf/a.urdf": b"an hour of work"}

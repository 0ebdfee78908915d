"""Writing files into a package: one by one, the manifest last, never outside, never through a link."""

import errno
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.output.atomic_files import OutputError, digest
from rosorin_compile.output.package_folder import MANIFEST, open_package_folder, read_manifest
from rosorin_compile.ros.package.deploy import unfinished_runs
from rosorin_compile.ros.package.package_files import files_below
from support.kills import ended_at

NEW = {"urdf/a.urdf": b"new a", "config/b.json": b"new b", "launch/c.py": b"new c"}
OLD = {"urdf/a.urdf": b"old a", "config/b.json": b"old b", "config/other.yaml": b"other"}


def fill(folder: Path) -> Path:
    for name, data in OLD.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    found = {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    return {name: data for name, data in found.items() if not name.endswith(MANIFEST)}


def place(folder: Path, files: Mapping[str, bytes]) -> tuple[str, ...]:
    with open_package_folder(folder) as target:
        return target.write(files)


def is_mixed(folder: Path) -> bool:
    return bool(list(unfinished_runs(folder, files_below(folder, skip_built=False))))


def test_writes_the_set_and_keeps_the_rest(tmp_path: Path) -> None:
    written = place(fill(tmp_path), {**NEW, "config/b.json": b"old b"})
    assert written == ("launch/c.py", "urdf/a.urdf")
    assert contents(tmp_path) == {**OLD, **NEW, "config/b.json": b"old b"}


def test_keeps_permissions(tmp_path: Path) -> None:
    (fill(tmp_path) / "urdf/a.urdf").chmod(0o640)
    place(tmp_path, NEW)
    assert (tmp_path / "urdf/a.urdf").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("name", ["../a", "/etc/a", "a//b", "./a", "a/..", ".git/hooks/a", "a\nb", ""])
def test_never_outside(tmp_path: Path, name: str) -> None:
    folder = fill(tmp_path / "in")
    with pytest.raises(OutputError, match="is not below the folder") as raised:
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


@pytest.mark.parametrize(("name", "what"), [("urdf", "a file"), ("config/other.yaml/x", "a folder")])
def test_what_stands_in_the_way(tmp_path: Path, name: str, what: str) -> None:
    with pytest.raises(OutputError, match=f"is not {what}") as raised:
        place(fill(tmp_path), {**NEW, name: b"x"})
    assert raised.value.diagnostic.rule == "deploy-in-the-way"
    assert contents(tmp_path) == OLD


def killing(monkeypatch: pytest.MonkeyPatch, at: int, problem: BaseException) -> None:
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


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"mine")
    with pytest.raises(OutputError, match=r"cannot write into .*file: Not a directory"):
        place(tmp_path / "file", NEW)
    assert contents(tmp_path) == {"file": b"mine"}


def test_the_manifest_has_the_digests_of_what_was_written(tmp_path: Path) -> None:
    place(fill(tmp_path), NEW)
    assert read_manifest(tmp_path) == {name: digest(data) for name, data in NEW.items()}
    (tmp_path / "launch/c.py").unlink()
    place(tmp_path, {"more": b"more"})
    assert sorted(read_manifest(tmp_path)) == ["config/b.json", "more", "urdf/a.urdf"]
    assert not is_mixed(tmp_path)


@pytest.mark.parametrize("text", ["", "3", "null", "[]", "[" * 100_000, '{"a": 3}', '{"a": []}', '{"a": [3]}'])
def test_a_damaged_manifest_is_replaced(tmp_path: Path, text: str) -> None:
    (fill(tmp_path) / MANIFEST).write_text(text)
    assert not is_mixed(tmp_path)
    place(tmp_path, NEW)
    assert sorted(read_manifest(tmp_path)) == sorted(NEW)


@pytest.mark.slow
@pytest.mark.parametrize("before", ["written", "unknown", "missing"])
def test_a_kill_at_each_call_is_reported_and_mended(tmp_path: Path, before: str) -> None:
    step, code, mixed = 0, 1, 0
    while code:
        step += 1
        folder = tmp_path / str(step) / "in"
        folder.parent.mkdir()
        if before == "written":
            place(folder, OLD)
        elif before == "unknown":
            fill(folder)
        old = contents(folder)
        code = ended_at(step, lambda folder=folder: place(folder, NEW))
        left = contents(folder) if folder.exists() else {}
        shown = {name: data for name, data in left.items() if not name.startswith(".")}
        assert all(shown.get(name) in (old.get(name), NEW.get(name)) for name in {**old, **NEW})
        is_of_two = shown not in (old, {**old, **NEW})
        assert is_of_two == (folder.exists() and is_mixed(folder)), step
        mixed += is_of_two
        with open_package_folder(folder) as target:  # nothing that the killed run wrote is taken for an edit
            known = target.digests()
        assert all(digest(data) in known[name] for name, data in shown.items() if data == NEW.get(name)) or not mixed
        place(folder, {"more": b"more"})
        assert is_of_two == is_mixed(folder), "another run does not hide it"
        place(folder, NEW)
        assert contents(folder) == {**old, **NEW, "more": b"more"}
        assert not is_mixed(folder)
        hidden = [path.name for path in (*folder.iterdir(), *folder.parent.iterdir()) if path.name.startswith(".")]
        assert hidden == [MANIFEST]
    assert step > 20
    assert mixed >= 2 or before == "missing"


def test_a_file_that_is_saved_meanwhile_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fill(tmp_path)
    fsync = os.fsync

    def saved(handle: int) -> None:
        (tmp_path / "urdf/a.urdf").write_bytes(b"an hour of work")
        fsync(handle)

    monkeypatch.setattr(os, "fsync", saved)
    with pytest.raises(OutputError, match=r"a file in .* was changed just now: nothing is written"):
        place(tmp_path, NEW)
    assert contents(tmp_path) == {**OLD, "urdf/a.urdf": b"an hour of work"}

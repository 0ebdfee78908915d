"""Writing the set of artifacts while something goes wrong: kills, full and read-only disks, errors, other runs."""

import errno
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from rosorin_compile.output import atomic_files
from rosorin_compile.output.artifact_set import read_set, write_set
from support import output_child
from support.output_child import NEW, OLD, A, B, encoded, files_in, names, no_swap, refused, stages

pytestmark = pytest.mark.slow

STALE = ".rosorin-compile-0123456789abcdef"
CHILD = [sys.executable, output_child.__file__]


@pytest.fixture
def folder(tmp_path):
    write_set(tmp_path / "out", A)
    return tmp_path / "out"


def child(what, folder, *arguments, before=()):
    command = [*before, *CHILD, what, folder, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="session")
def mounting():
    words = ["unshare", "--mount", *(["--map-root-user"] if os.geteuid() else [])]
    try:
        done = subprocess.run(
            [*words, "mount", "-t", "tmpfs", "tmpfs", "/mnt"], capture_output=True, text=True, check=False
        )
    except FileNotFoundError as problem:
        pytest.skip(f"this system has no mount namespaces: {problem}")
    if done.returncode:
        pytest.skip(f"this system does not let us mount: {done.stderr.strip()}")
    return words


def states(steps):
    """Return a letter a step: was the folder (o)ld, (n)ew, (m)issing or mixed after a kill at that step."""
    assert len(steps) > 20
    assert [step["exit"] for step in steps] == [-9] * (len(steps) - 1) + [0]
    assert all(step["healed"] for step in steps)
    assert any(step["left"] for step in steps)
    return "".join(step["state"][0] for step in steps)


def test_killed_at_each_step(tmp_path):
    steps = child("each_step", tmp_path / "top" / "out", "exchange")
    assert re.fullmatch("o+n+", states(steps))
    assert all(step["notes"] for step in steps)
    assert re.fullmatch("m+n+", states(child("each_step", tmp_path / "top" / "out", "first")))


def test_killed_at_each_step_without_an_exchange_the_next_run_repairs(tmp_path):
    steps = child("each_step", tmp_path / "top" / "out", "one by one")
    assert re.fullmatch("o+m{1,9}n+", states(steps))
    assert all(step["notes"] for step in steps)


def snapshot(folder):
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        files = {}
        for where, _, found, at in os.fwalk(dir_fd=handle):
            for name in found:
                with os.fdopen(os.open(name, os.O_RDONLY, dir_fd=at), "rb") as file:
                    files[os.path.normpath(os.path.join(where, name))] = file.read()
        return files if os.path.samestat(os.fstat(handle), folder.stat()) else None
    except FileNotFoundError:
        return None
    finally:
        os.close(handle)


def test_two_runs_at_once_do_not_mix(tmp_path):
    folder = tmp_path / "out"
    write_set(folder, A)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    writers = [subprocess.Popen([*CHILD, "alternate", folder, "3"], **pipes) for _ in "12"]
    looked = read = 0
    while any(writer.poll() is None for writer in writers):
        found = snapshot(folder)
        looked += found is not None
        assert found in (None, encoded(A), encoded(B))
        assert read_set(folder) in (encoded(A), encoded(B))
        read += 1
        time.sleep(0.001)
    said = [writer.communicate()[0] for writer in writers]
    assert [writer.returncode for writer in writers] == [0, 0], said
    counts = [int(text) for text in said]
    assert min(counts) > 5
    assert min(looked, read) > 5
    assert names(tmp_path) == ["out"]


def test_a_full_disk(tmp_path, mounting):
    found = child("on_full_disk", tmp_path, before=mounting)
    assert found["big"]["rule"] == "output-full"
    assert "No space left on device" in found["big"]["message"]
    assert found["state"] == {"set": "old", "left": []}
    assert found["small"]["written"] == sorted(NEW)


def test_a_disk_that_is_mounted_read_only(tmp_path, mounting):
    found = child("on_read_only_disk", tmp_path, before=mounting)
    assert found["other"]["rule"] == "output-read-only"
    assert "Read-only file system" in found["other"]["message"]
    assert found["same"]["unchanged"] == sorted(OLD)
    assert found["set"] == OLD


def test_mount_points_are_not_replaced(tmp_path, mounting):
    found = child("on_mount_points", tmp_path, before=mounting)
    for kind in ("disk out", "bind out", "disk out/inside", "bind out/inside"):
        assert found[kind]["rule"] == "output-mounted", kind
        assert found[f"{kind} set"] == "old"
    assert found["elsewhere"] == {"precious.txt": "precious"}
    assert not found["left"]


@pytest.fixture
def open_place():
    """A folder that users without rights can reach; they own it if we are root."""
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        for top in ("parent", "own", "hidden", "blind", "free"):
            write_set(place / top / "out", OLD)
        for path in (place, *place.rglob("*")):
            if os.geteuid() == 0:
                os.chown(path, 65534, 65534)
        place.chmod(0o755)
        yield place
        for path in (*place.iterdir(), *place.glob("*/out"), *place.glob("*/out/sub")):
            path.chmod(0o755)


def test_folders_without_the_right_to_write(open_place):
    (open_place / "parent").chmod(0o555)  # nothing can be put beside the folder
    (open_place / "own" / "out").chmod(0o555)  # its owner wants it to stay as it is
    (open_place / "hidden").chmod(0o000)
    (open_place / "blind").chmod(0o311)
    places = ("parent/out", "own/out", "hidden/out", "blind/out")
    found = child("locked_out", open_place, *places)
    for name in places:
        assert found[name]["rule"] == "output-read-only", name
        assert found[name]["help"]
    assert "own/out" in found["own/out"]["message"]
    assert [found[f"read {name}"] for name in places] == [3, 3, "output-unreadable", 3]
    for top in ("parent", "own", "hidden", "blind"):
        (open_place / top).chmod(0o755)
        assert files_in(open_place / top) == {f"out/{name}": data for name, data in encoded(OLD).items()}


def test_files_of_others_and_folders_without_the_right_to_write_are_carried_over(open_place):
    out = open_place / "free" / "out"
    (out / "sub").mkdir()
    (out / "sub" / "mine.txt").write_text("mine")
    if os.geteuid() == 0:
        os.chown(out / "sub", 65534, 65534)  # but the file is root's: it may be read, and not be linked to
    (out / "sub" / "mine.txt").chmod(0o644)
    (out / "sub").chmod(0o555)
    found = child("locked_out", open_place, "free/out")["free/out"]
    assert found["written"] == sorted(NEW)
    assert files_in(out) == {**encoded(NEW), "sub/mine.txt": b"mine"}
    assert (out / "sub").stat().st_mode & 0o777 == 0o555
    assert names(out.parent) == ["out"]


def broken(*_, **__):
    raise OSError(errno.EIO, "Input/output error")


@pytest.mark.parametrize("name", ["fsync", "urandom"])
def test_an_error_leaves_the_old_set(folder, monkeypatch, name):
    monkeypatch.setattr(os, name, broken)
    assert "Input/output error" in refused(folder, B, "output-failed")


def test_files_are_replaced_one_by_one_where_nothing_can_be_exchanged(folder, monkeypatch):
    monkeypatch.setattr(atomic_files, "exchange", no_swap)
    (folder / "mine.txt").write_text("mine")
    (folder / "f5.txt").unlink()
    inode = folder.stat().st_ino
    write_set(folder, B)
    assert {name: files_in(folder)[name] for name in B} == encoded(B)
    assert files_in(folder)["mine.txt"] == b"mine"
    assert folder.stat().st_ino == inode
    assert names(folder.parent) == ["out"]


def test_an_error_between_two_files_leaves_the_old_set(folder, monkeypatch):
    monkeypatch.setattr(atomic_files, "exchange", no_swap)
    replace, replaced = Path.replace, []

    def failing(one, two):
        replaced.append(one)
        return broken() if len(replaced) == 3 else replace(one, two)

    monkeypatch.setattr(Path, "replace", failing)
    refused(folder, B, "output-failed", prune=True)
    assert len(replaced) > 3, "the others were put back"


def test_what_killed_runs_left_is_removed_and_nothing_else(folder, tmp_path):
    (tmp_path / STALE / "new" / "sub").mkdir(parents=True)
    (tmp_path / STALE / "new" / "sub" / "x").write_text("x")
    (tmp_path / STALE / "new" / "sub").chmod(0o500)
    (tmp_path / STALE / "link").symlink_to(folder)
    others = [STALE + "0", STALE[:-1], STALE[:-1] + "g", STALE[:-1] + "F", ".rosorin-compile-"]
    for name in others:
        (tmp_path / name).mkdir()
    (tmp_path / STALE.replace("0", "1")).write_text("a single file that was being prepared")
    (tmp_path / STALE.replace("0", "2")).symlink_to(folder)
    write_set(folder, A)
    assert set(names(tmp_path)) == {"out", *others, STALE.replace("0", "2")}
    assert files_in(folder) == encoded(A)


def test_without_locks_sets_are_written_but_nothing_is_tidied(folder, tmp_path, monkeypatch):
    import fcntl

    monkeypatch.setattr(fcntl, "flock", broken)
    (tmp_path / STALE).mkdir()
    write_set(folder, B, prune=True)
    assert files_in(folder) == encoded(B)
    assert stages(folder) == [STALE]

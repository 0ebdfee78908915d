"""Writing the set of artifacts: what happens to files that are equal, new, other people's, or in the way."""

import os
import stat
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.output import artifact_set, atomic_files
from rosorin_compile.output.artifact_set import WriteResult, read_set, write_set
from rosorin_compile.output.atomic_files import OutputError
from support.output_child import A, B, encoded, files_in, names, no_swap, refused, stages

STALE = ".rosorin-compile-0123456789abcdef"


@pytest.fixture
def folder(tmp_path):
    write_set(tmp_path / "out", A)
    return tmp_path / "out"


def marks(folder):
    """Return what tells whether anything was touched: number and times of each file and folder, parent included."""
    paths = [folder.parent, folder, *folder.rglob("*")]
    return {path: (path.lstat().st_ino, path.lstat().st_mtime_ns, path.lstat().st_ctime_ns) for path in paths}


def test_makes_the_folder_and_the_folders_above_it(tmp_path):
    written = write_set(tmp_path / "a" / "b", {"z.txt": "z", "sub/deep/a.txt": "ä\n", "empty": ""})
    assert written == WriteResult(("empty", "sub/deep/a.txt", "z.txt"), (), (), ())
    assert files_in(tmp_path / "a" / "b") == {"z.txt": b"z", "sub/deep/a.txt": "ä\n".encode(), "empty": b""}
    assert names(tmp_path / "a") == ["b"]


def test_an_equal_set_is_not_touched(folder):
    (folder / "mine.txt").write_text("mine")
    before = marks(folder)
    assert write_set(folder, A) == WriteResult((), tuple(sorted(A)), ("mine.txt",), ())
    assert marks(folder) == before


def test_modes(tmp_path):
    old = os.umask(0o027)
    try:
        write_set(tmp_path / "out", {"a": "1", "sub/b": "1"})
        assert {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.rglob("*")} == {0o750, 0o640}
        (tmp_path / "out").chmod(0o2775)
        (tmp_path / "out" / "sub").chmod(0o711)
        write_set(tmp_path / "out", {"a": "2", "sub/b": "2"})
    finally:
        os.umask(old)
    modes = {path.name: oct(stat.S_IMODE(path.stat().st_mode)) for path in tmp_path.rglob("*")}
    assert modes == {"out": "0o2775", "sub": "0o711", "a": "0o640", "b": "0o640"}


@pytest.mark.parametrize("way", ["exchange", "one by one", "copies"])
def test_what_others_keep_there_stays_theirs(folder, monkeypatch, way):
    (folder / "urdf" / "mine.txt").write_text("mine")
    (folder / "urdf" / "mine.txt").chmod(0o751)
    (folder / "some" / "deep" / "place").mkdir(parents=True, mode=0o700)
    (folder / "some").chmod(0o555)
    (folder / "dangling").symlink_to("/nowhere/at/all")
    (folder / "to_folder").symlink_to(folder.parent)
    (folder / "run.bag").write_bytes(bytes(range(256)))
    os.utime(folder / "run.bag", ns=(1_000_000_001, 2_000_000_002))
    if way == "one by one":
        monkeypatch.setattr(atomic_files, "exchange", no_swap)
    elif way == "copies":
        monkeypatch.setattr(os, "link", lambda *_, **__: no_swap(folder, folder))
    else:
        os.mkfifo(folder / "pipe")
    before = {p.relative_to(folder): p.lstat() for p in folder.rglob("*") if p.relative_to(folder).as_posix() not in A}
    written = write_set(folder, {name: text + "more" for name, text in A.items()})
    kept = {"urdf/mine.txt", "dangling", "to_folder", "run.bag", "pipe"} - ({"pipe"} if way != "exchange" else set())
    assert written.kept == tuple(sorted(kept))
    after = {p.relative_to(folder): p.lstat() for p in folder.rglob("*") if p.relative_to(folder).as_posix() not in A}
    assert {name: it.st_mode for name, it in after.items()} == {name: it.st_mode for name, it in before.items()}
    for name, status in before.items():
        if not stat.S_ISDIR(status.st_mode):
            assert after[name].st_mtime_ns == status.st_mtime_ns
            assert way == "copies" or after[name].st_ino == status.st_ino
    assert (folder / "dangling").readlink() == Path("/nowhere/at/all")
    assert (folder / "run.bag").read_bytes() == bytes(range(256))
    assert names(folder.parent) == ["out"]


def test_prune_leaves_the_set_alone(folder, tmp_path):
    (tmp_path / "precious.txt").write_text("precious")
    (folder / "some" / "deep").mkdir(parents=True)
    (folder / "some" / "deep" / "mine.txt").write_text("mine")
    (folder / "out_there").symlink_to(tmp_path)
    written = write_set(folder, B, prune=True)
    gone = sorted({*A} - {*B} | {"some/deep/mine.txt", "out_there"})
    assert written == WriteResult(tuple(sorted(B)), (), (), tuple(gone))
    assert files_in(folder) == encoded(B)
    assert names(folder) == sorted({name.split("/")[0] for name in B})
    assert (tmp_path / "precious.txt").read_text() == "precious"
    (folder / "empty").mkdir()
    assert write_set(folder, B, prune=True) == WriteResult((), tuple(sorted(B)), (), ())
    assert not (folder / "empty").exists()


BAD_NAMES = ["", ".", "..", "/", "/etc/x", "../x", "a/../../x", "a//b", "a/", "./a", "a\0b", "a\nb", "\ud800"]
BAD_NAMES += [".git/hooks", "fine.txt/x"]


@pytest.mark.parametrize("name", BAD_NAMES)
def test_names_that_lead_outside(folder, name):
    refused(folder, {"fine.txt": "fine", name: "bad"}, "output-name")


def test_text_that_utf8_cannot_write(folder):
    assert r"'\ud800'" in refused(folder, {"f0.txt": "a\ud800"}, "output-text")


@pytest.mark.parametrize("name", ["", ".", "..", "/", "sub/..", "a\0b", "\ud800", f"sub/{STALE}"])
def test_folders_that_are_none_of_their_own(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OutputError, match="cannot be the output folder"):
        write_set(Path(name), {"a": "1"})
    with pytest.raises(OutputError, match="cannot be the output folder"):
        read_set(Path(name))


def test_folders_that_are_something_else(tmp_path):
    (tmp_path / "file").write_text("file")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    assert "is not a folder" in refused(tmp_path / "file", A, "output-folder")
    assert "is not a folder" in refused(tmp_path / "dangling", A, "output-folder", prune=True)
    with pytest.raises(OutputError, match=r"file/out: .*file is not a folder") as caught:
        write_set(tmp_path / "file" / "out", A)
    assert caught.value.diagnostic.rule == "output-folder"


@pytest.mark.parametrize("prune", [False, True])
def test_a_symbolic_link_to_an_output_folder(folder, tmp_path, prune):
    (tmp_path / "elsewhere").mkdir()
    link = tmp_path / "elsewhere" / "link"
    link.symlink_to(folder)
    assert read_set(link) == encoded(A)
    assert set(write_set(link, B, prune).written) == set(B)
    assert read_set(link) == files_in(folder) == encoded(B if prune else {**A, **B})
    (folder / "f5.txt").unlink()
    assert write_set(link, B, prune).written == ("f5.txt",)
    assert link.readlink() == folder
    assert (names(tmp_path), names(tmp_path / "elsewhere")) == (["elsewhere", "out"], ["link"])


def test_the_folder_the_command_stands_in(folder, monkeypatch):
    monkeypatch.chdir(folder / "urdf")
    assert write_set(folder, A).written == ()
    assert "inside" in refused(folder, B, "output-folder")


@pytest.mark.parametrize("prune", [False, True])
def test_links_in_the_way(folder, tmp_path, prune):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "x.txt").write_text("precious")
    (folder / "x.txt").symlink_to(tmp_path / "elsewhere" / "x.txt")
    (folder / "sub").symlink_to(tmp_path / "elsewhere")
    assert "is a symbolic link" in refused(folder, {"x.txt": "1"}, "output-in-the-way", prune)
    assert "is a symbolic link" in refused(folder, {"sub/x.txt": "precious"}, "output-in-the-way", prune)


def test_other_things_in_the_way(folder):
    assert "urdf is a folder" in refused(folder, {"urdf": "1"}, "output-in-the-way")
    assert "f0.txt is a file" in refused(folder, {"f0.txt/x": "1"}, "output-in-the-way")
    swapped = {"urdf": "1", "f0.txt/x": "2"}
    assert write_set(folder, swapped, prune=True).written == ("f0.txt/x", "urdf")
    assert files_in(folder) == encoded(swapped)
    os.mkfifo(folder / "pipe")
    with pytest.raises(OutputError, match="pipe is a special file"):
        write_set(folder, {"pipe": "1"})


def test_folders_that_are_for_something_else(folder):
    (folder / ".git").mkdir()
    assert "a .git" in refused(folder, B, "output-foreign", prune=True)
    (folder / ".git").rmdir()
    many = folder / "many"
    many.mkdir()
    for number in range(artifact_set.MAX_FOREIGN - 1):
        (many / str(number)).write_text("")
    assert len(write_set(folder, {**A, "f0.txt": ""}).kept) == artifact_set.MAX_FOREIGN - 1
    (many / "last").write_text("")
    assert "more than 200" in refused(folder, B, "output-foreign", prune=True)


def test_reading(folder, tmp_path):
    (folder / "link").symlink_to(folder / "f0.txt")
    (folder / "empty").mkdir()
    found = read_set(folder)
    assert found == encoded(A)
    assert list(found) == sorted(A)
    assert read_set(tmp_path / "missing") == {}
    assert read_set(tmp_path / "missing" / "out") == {}
    with pytest.raises(OutputError) as caught:
        read_set(folder / "f0.txt")
    assert caught.value.diagnostic.rule == "output-folder"


NAMES = st.sampled_from(["a", "b", "sub/a", "sub/b", "sub/deep/a", "c/x", "sub"])
FILES = st.dictionaries(NAMES, st.sampled_from(["", "one\n", "two\n"]))


@given(st.lists(st.tuples(FILES, st.booleans()), max_size=5))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_sequence_of_sets(tmp_path_factory, sequence):
    folder = tmp_path_factory.mktemp("any") / "out"
    expected: dict[str, bytes] = {}
    refusals: set[str] = set()
    for files, prune in sequence:
        try:
            written = write_set(folder, files, prune)
        except OutputError as problem:
            refusals.add(problem.diagnostic.rule)
        else:
            kept = {} if prune else {name: data for name, data in expected.items() if name not in files}
            assert set(written.written) == {n for n, t in files.items() if expected.get(n) != t.encode()}
            assert set(written.kept) == set(kept)
            assert set(written.removed) == (set(expected) - set(files) if prune else set())
            expected = {**kept, **encoded(files)}
        assert read_set(folder) == expected
        assert not stages(folder)
    assert refusals <= {"output-name", "output-in-the-way"}


def test_a_set_that_need_not_be_durable_is_not_flushed(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda _: pytest.fail("it was flushed"))
    write_set(tmp_path / "out", A, durable=False)
    assert write_set(tmp_path / "out", B, prune=True, durable=False).written == tuple(sorted(B))
    assert files_in(tmp_path / "out") == encoded(B)

"""Reading files: what is recorded, and what a path that nobody may look at is."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from rosorin_compile.source import files


def test_what_is_read_or_missing_is_recorded(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("1\r\n2")
    with files.recording() as outer:
        with files.recording() as inner:
            assert files.read_text(tmp_path / "a") == "1\n2"
            assert not files.is_file(tmp_path / "b")
            assert files.is_folder(tmp_path)
        with pytest.raises(FileNotFoundError):
            files.read_bytes(tmp_path / "c")
    files.read_bytes(tmp_path / "a")
    assert inner == {tmp_path / "a": files.version(tmp_path / "a"), tmp_path / "b": ()}
    assert outer == {**inner, tmp_path / "c": ()}


@pytest.mark.parametrize("name", ["nothing", "a/inside", "n" * 300, "nul\0", "round"])
def test_what_no_file_is_called_is_absent(tmp_path: Path, name: str) -> None:
    (tmp_path / "a").write_text("")
    (tmp_path / "round").symlink_to("round")
    path = f"{tmp_path}/{name}"
    assert not files.exists(path)
    assert not files.is_file(path)
    with pytest.raises(OSError, match=r"\w"):
        files.read_bytes(path)


def test_what_nobody_may_look_at_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path, **_: object) -> os.stat_result:
        raise PermissionError(errno.EACCES, "Permission denied", str(self))

    monkeypatch.setattr(Path, "stat", refuse)
    for look in (files.exists, files.is_file, files.is_folder, files.is_special):
        with pytest.raises(PermissionError):
            look(tmp_path / "a")


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert files.is_special(tmp_path / "pipe")
    with pytest.raises(OSError, match="No regular file"):
        files.read_bytes(tmp_path / "pipe")

"""Recordings whose end is missing: the recorder was killed, or a copy broke off."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import pytest

from rosorin_compile_verify.metadata import Unreadable
from support import bags
from support.bags import Scene, judged, part, rules


@pytest.mark.parametrize(("storage", "mode"), [("mcap", "NONE"), ("mcap", "STORAGE"), ("sqlite3", "NONE")])
def test_what_is_left_of_a_recording_without_its_end(tmp_path: Path, storage: str, mode: str) -> None:
    """The recorder was killed: there is no index and no metadata.yaml, and the last message is half there."""
    said = bags.messages(Scene(seconds=6.0))
    folder = bags.write(tmp_path / "bag", said, storage, mode)
    file = part(folder)
    data = file.read_bytes()
    for share in (0.99, 0.9, 0.75):
        file.write_bytes(data[: int(len(data) * share)])
        for source in (folder, file):
            verdict = judged(source)
            many = verdict.recording.messages
            (found,) = verdict.findings
            until = (max(message.received for message in said[:many]) - said[0].received) / 1e9
            assert (found.rule, found.severity) == ("recording-cut-off", "warning")
            assert found.message == (
                f"{file.name} is cut off: it ends {until:.1f} s after its begin, with {many:,} messages"
            )
            assert 0.6 * len(said) < many <= len(said)
    (folder / "metadata.yaml").unlink()
    assert rules(judged(folder)) == ["recording-cut-off"]
    assert len(judged(folder, since=1.0, until=2.0).findings) == 1
    file.write_bytes(data[:200])
    if storage == "mcap":
        empty, found = judged(folder).findings
        assert (empty.rule, empty.severity) == ("recording-empty", "error")
        assert found.message == f"{file.name} is cut off: it ends before its first message"
    else:
        with pytest.raises(Unreadable, match="cannot be read"):
            judged(folder)


def test_a_length_that_is_damaged_takes_no_memory(tmp_path: Path) -> None:
    """A record of four gigabytes in a file of a few kilobytes."""
    file = part(bags.bag(tmp_path / "bag", "mcap", seconds=1.0))
    header = 8 + 9 + int.from_bytes(file.read_bytes()[9:17], "little")
    file.write_bytes(file.read_bytes()[:header] + b"\x06" + (2**32 - 1).to_bytes(8, "little") + bytes(100))
    tracemalloc.start()
    try:
        assert rules(judged(file)) == ["recording-empty", "recording-cut-off"]
        assert tracemalloc.get_traced_memory()[1] < 1 << 28
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("compression", ["lz4", "zstd"])
def test_of_a_chunk_that_is_cut_the_blocks_before_are_read(compression: str) -> None:
    """A chunk of many messages, packed in blocks: those that are whole are read, the last one is left."""
    if compression == "lz4":
        from lz4.frame import compress
    else:
        from backports.zstd import compress
    from rosorin_compile_verify.cut_bags import _unpacked

    data = bytes(range(256)) * 4096
    packed = compress(data)
    assert _unpacked(compression, packed) == data
    left = _unpacked(compression, packed[: len(packed) * 3 // 4])
    assert data.startswith(left)
    assert _unpacked(compression, b"nonsense") == b""
    assert _unpacked("brotli", packed) == b""


def test_what_is_left_of_one_of_several_files(tmp_path: Path) -> None:
    """The last of the files of a recording is cut; its folder still has a metadata.yaml of all."""
    said = bags.messages(Scene(seconds=6.0))
    half = len(said) // 2
    folder = bags.write(tmp_path / "bag", said[:half], "mcap")
    second = part(bags.write(tmp_path / "other", said[half:], "mcap"))
    (folder / "bag_1.mcap").write_bytes(second.read_bytes()[: second.stat().st_size * 3 // 4])
    verdict = judged(folder)
    assert rules(verdict) == ["recording-cut-off"]
    assert verdict.findings[0].message.startswith("bag_1.mcap is cut off: it ends ")
    assert half < verdict.recording.messages < len(said)

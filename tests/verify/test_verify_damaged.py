"""verify on files, folders and messages that are damaged or cut off: one clear error, never a traceback or a wait."""

import random
import shutil
import sqlite3
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.recordings.bags import Unreadable
from support import bags
from support.bags import STORE, Scene, judged, part, rules
from support.paths import ROOT

ROBOT = str(ROOT / "descriptions" / "rosorin")


def outcome(folder: Path) -> list[str]:
    """Return the rules of the findings; where the recording cannot be read, the folder that the error names."""
    try:
        return rules(judged(folder))
    except Unreadable as problem:
        return [str(folder)] if str(folder) in str(problem) and problem.help else ["a file that nobody knows"]


def with_data(folder: Path, copy: Path, data: bytes) -> Path:
    shutil.copytree(folder, copy)
    part(copy).write_bytes(data)
    return copy


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_recording_without_its_end_is_one_error(
    clean: dict[str, Path], tmp_path: Path, storage: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The recorder was killed, or a copy broke off: with and without metadata.yaml, folder and file."""
    data = part(clean[storage]).read_bytes()
    way_out = "mcap recover" if storage == "mcap" else "ros2 bag reindex"
    for number, share in enumerate((0.0, 0.5, 0.99)):
        folder = with_data(clean[storage], tmp_path / str(number), data[: int(len(data) * share)])
        for source in (folder, part(folder)):
            with pytest.raises(Unreadable, match="cannot be read: ") as problem:
                judged(source)
            assert str(problem.value).startswith((f"{part(folder)} cannot be read: ", f"{folder} cannot be read: "))
            assert way_out in problem.value.help
    (folder / "metadata.yaml").unlink()
    assert main(["verify", ROBOT, str(folder)]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"error[recording-unreadable]: {part(folder)} cannot be read: ")
    assert way_out in said
    assert "Traceback" not in said


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_bytes_that_are_turned_over_end_in_an_error(clean: dict[str, Path], tmp_path: Path, storage: str) -> None:
    """What comes out is an error or a comparison that fails, never a traceback."""
    chance = random.Random(7)  # noqa: S311
    data = part(clean[storage]).read_bytes()
    for number in range(8):
        flipped = bytearray(data)
        for _ in range(200):
            flipped[chance.randrange(len(flipped))] ^= 1 << chance.randrange(8)
        assert outcome(with_data(clean[storage], tmp_path / str(number), bytes(flipped))) != []


@pytest.mark.parametrize(
    "metadata",
    [
        "",
        "}{",
        "rosbag2_bagfile_information: 3\n",
        "rosbag2_bagfile_information: {version: 99}\n",
        "[]",
        "\0",
        "[" * 500,
    ],
)
def test_a_damaged_metadata_file(clean: dict[str, Path], tmp_path: Path, metadata: str) -> None:
    folder = shutil.copytree(clean["mcap"], tmp_path / "bag")
    (folder / "metadata.yaml").write_text(metadata, "utf-8")
    with pytest.raises(Unreadable, match="cannot be read"):
        judged(folder)
    assert judged(part(folder)).findings == ()


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE topics SET name = x'00ff' WHERE name = '/scan'",
        "UPDATE topics SET type = x'00ff' WHERE name = '/scan'",
        "UPDATE messages SET timestamp = 'soon' WHERE id = 5",
        "UPDATE messages SET timestamp = 1e300 WHERE id = 5",
        "UPDATE messages SET timestamp = 9223372036854775806 WHERE id = 5",
        "UPDATE messages SET data = 7 WHERE id = 5",
        "UPDATE messages SET data = x'' WHERE topic_id = 1 AND id > 9",
        "UPDATE topics SET offered_qos_profiles = '[[[['",
        "DELETE FROM topics",
    ],
)
def test_rows_of_a_database_that_are_of_another_kind(clean: dict[str, Path], tmp_path: Path, change: str) -> None:
    folder = shutil.copytree(clean["sqlite3"], tmp_path / "bag")
    database = sqlite3.connect(part(folder))
    database.execute(change)
    database.commit()
    database.close()
    assert outcome(folder) != []


def test_a_message_that_ends_too_early(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    serialize = STORE.serialize_cdr

    def cut(content: Any, kind: str) -> Any:
        raw = serialize(content, kind)
        return raw[:40] if hasattr(content, "transforms") and content.transforms[0].child_frame_id == "odom" else raw

    monkeypatch.setattr(STORE, "serialize_cdr", cut)
    bag = bags.bag(tmp_path / "cut", seconds=2.0)
    with pytest.raises(Unreadable, match=r"cannot be read: a message of /tf: "):
        judged(bag)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_metadata_that_contradicts_the_files(clean: dict[str, Path], tmp_path: Path, storage: str) -> None:
    """Numbers of the files are used; rosbags skips topics that metadata.yaml does not have, so that is an error."""
    compressed = bags.write(tmp_path / "compressed", bags.messages(Scene(seconds=2.0)), storage, "MESSAGE")
    for number, (was, now) in enumerate(
        {
            "  message_count: ": "  message_count: 1",
            "nanoseconds: ": "nanoseconds: 1",
            "name: /tf\n": "name: /fts\n",
            "msg/TFMessage": "msg/Other",
        }.items()
    ):
        for source in (clean[storage], compressed):
            folder = shutil.copytree(source, tmp_path / f"{source.name} {number}")
            text = (folder / "metadata.yaml").read_text("utf-8")
            assert was in text
            (folder / "metadata.yaml").write_text(text.replace(was, now), "utf-8")
            if number > 1:
                with pytest.raises(Unreadable, match=r"metadata\.yaml contradicts the files about /tf"):
                    judged(folder)
            else:
                assert judged(folder).findings == ()

"""verify on metadata.yaml, files and folders that are damaged: an error with its place, never a traceback or a wait."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli import main
from rosorin_compile_verify.metadata import Unreadable
from support import bags
from support.bags import Scene, judged, part, rules
from support.paths import ROOT

pytestmark = pytest.mark.slow

ROBOT = str(ROOT / "descriptions" / "rosorin")
KINDS = {"sqlite3": ("sqlite3", "NONE"), "mcap": ("mcap", "STORAGE"), "packed": ("sqlite3", "FILE")}


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return a short clean recording of each kind."""
    folder = tmp_path_factory.mktemp("clean")
    said = bags.messages(Scene(seconds=2.0))
    return {name: bags.write(folder / "bag" / name, said, *kind) for name, kind in KINDS.items()}


def outcome(folder: Path) -> list[str]:
    """Return the rules of the findings; where the recording cannot be read, the folder that the error names."""
    try:
        return rules(judged(folder))
    except Unreadable as problem:
        return [str(folder)] if str(folder) in str(problem) else ["a file that nobody knows"]


# What stands in a line of metadata.yaml, what is put there, and what is said of it.
DAMAGED = [
    ("  message_count: 397", "  message_count:", "line 14: message_count is empty, not a whole number"),
    ("  message_count: 397", "  message_count: lots", 'line 14: message_count is "lots", not a whole number'),
    ("  message_count: 397", "  message_count: [4]", "line 14: message_count is a list, not a whole number"),
    ("  message_count: 397", "  message_count: -4", "line 14: message_count cannot be -4"),
    ("  message_count: 397", "", "line 1: rosbag2_bagfile_information has no message_count"),
    ("  message_count: 397", f"  message_count: {'9' * 30}", f"line 14: message_count cannot be {'9' * 30}"),
    ("  message_count: 397", f"  message_count: {'9' * 5000}", "it is no YAML"),
    ("  - message_count: 160", "  - message_count: ~", "line 22: message_count is empty, not a whole number"),
    ("      name: /tf", "      name: 7", "line 24: name is 7, not a text"),
    ("      name: /tf", "", "line 23: topic_metadata has no name"),
    (
        "      offered_qos_profiles: []",
        "      offered_qos_profiles: 3",
        "line 25: offered_qos_profiles is 3, not a list",
    ),
    (
        "      offered_qos_profiles: []",
        f"      offered_qos_profiles: '{'[' * 2000}'",
        "line 25: offered_qos_profiles: nested deeper than 100 levels",
    ),
    ("  version: 9", "  version: new", 'line 86: version is "new", not a whole number'),
    ("    nanoseconds: 1980000000", "    nanoseconds: {}", "line 6: nanoseconds is a mapping, not a whole number"),
    ("  files:", "  files:\n  others:", "line 7: files is empty, not a list"),
    ("rosbag2_bagfile_information:", "rosbag2:", "it does not begin with rosbag2_bagfile_information"),
    ("  relative_file_paths:", "  relative_file_paths: 3\n  paths:", "line 15: relative_file_paths is 3, not a list"),
    ("  storage_identifier: sqlite3", "", "line 1: rosbag2_bagfile_information has no storage_identifier"),
]


@pytest.mark.parametrize(("was", "now", "message"), DAMAGED, ids=range(len(DAMAGED)))
def test_a_damaged_line_of_metadata(clean: dict[str, Path], tmp_path: Path, was: str, now: str, message: str) -> None:
    folder = shutil.copytree(clean["sqlite3"], tmp_path / "bag")
    file = folder / "metadata.yaml"
    text = file.read_text("utf-8")
    assert f"\n{was}\n" in f"\n{text}"
    file.write_text(f"\n{text}".replace(f"\n{was}\n", f"\n{now}\n", 1)[1:], "utf-8")
    with pytest.raises(Unreadable) as problem:
        judged(folder)
    assert str(problem.value) == f"{file} cannot be read: {message}"
    assert "ros2 bag reindex" in problem.value.help
    assert judged(part(folder)).findings == []


def test_metadata_that_names_what_is_no_file(clean: dict[str, Path], tmp_path: Path) -> None:
    folder = shutil.copytree(clean["sqlite3"], tmp_path / "bag")
    file = part(folder)
    said = (clean["sqlite3"] / "metadata.yaml").read_text("utf-8")
    for name in ("nowhere.db3", "..", "", f"{'x' * 300}.db3", "fifo.db3", "folder.db3", "loop.db3", "endless.db3"):
        (folder / "metadata.yaml").write_text(said.replace(f"  - {file.name}", f"  - '{name}'"), "utf-8")
        if name == "fifo.db3":
            os.mkfifo(folder / "fifo.db3")
            (folder / "folder.db3").mkdir()
            (folder / "loop.db3").symlink_to(folder / "loop.db3")
            (folder / "endless.db3").symlink_to("/dev/zero")
        with pytest.raises(Unreadable, match=r"metadata\.yaml cannot be read: line 16: there is no file "):
            judged(folder)
    (folder / "metadata.yaml").unlink()
    assert judged(folder).findings == []


def test_what_is_no_regular_file(clean: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "fifo.mcap")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "round").mkdir()
    (tmp_path / "round" / "again").symlink_to(tmp_path / "round")
    (tmp_path / "only_fifos").mkdir()
    for name in ("metadata.yaml", "a.mcap", "a.db3"):
        os.mkfifo(tmp_path / "only_fifos" / name)
    irregular = "is not a regular file"
    for source, code, message in (
        (tmp_path / "fifo.mcap", 1, irregular),
        ("/dev/zero", 1, irregular),
        ("/dev/null", 1, irregular),
        (tmp_path / "round", 1, "is no recording: it has no metadata.yaml, no .mcap and no .db3"),
        (tmp_path / "only_fifos", 1, "is no recording: it has no metadata.yaml, no .mcap and no .db3"),
        (tmp_path / "loop", 2, "there is no "),
        (tmp_path / ("x" * 300), 1, "cannot be read: File name too long"),
        ("a\0b", 2, "there is no "),
    ):
        assert main(["verify", ROBOT, str(source)]) == code, source
        said = capsys.readouterr().err
        assert message in said
        assert "Traceback" not in said
    for name in ("metadata.yaml", "a.mcap", "a.db3"):
        (tmp_path / "only_fifos" / name).unlink()
    shutil.copy(part(clean["mcap"]), tmp_path / "only_fifos")
    os.mkfifo(tmp_path / "only_fifos" / "a.mcap")
    assert judged(tmp_path / "only_fifos").findings == []


def test_metadata_that_is_not_of_these_files(clean: dict[str, Path], tmp_path: Path) -> None:
    """Counts, times and names of topics that are wrong, and no damage: the files have the last word."""
    for number, (was, now) in enumerate(
        {
            "message_count: 397": "message_count: 0",
            "nanoseconds_since_epoch: 1790000000002000000": "nanoseconds_since_epoch: 9223372036854775807",
            "nanoseconds: 1980000000": "nanoseconds: 0",
            "name: /tf\n": "name: /fts\n",
            "type: tf2_msgs/msg/TFMessage": "type: tf2_msgs/msg/Other",
        }.items()
    ):
        for kind in ("mcap", "packed"):
            folder = shutil.copytree(clean[kind], tmp_path / f"{kind}{number}")
            text = (folder / "metadata.yaml").read_text("utf-8")
            assert was in text
            (folder / "metadata.yaml").write_text(text.replace(was, now), "utf-8")
            if kind == "packed" and number > 2:
                with pytest.raises(Unreadable, match=r"metadata\.yaml says other things of /tf"):
                    judged(folder)
            else:
                verdict = judged(folder)
                assert verdict.findings == []
                assert verdict.recording.messages == 397


@pytest.mark.parametrize("kind", KINDS)
def test_any_line_of_metadata_may_be_anything(clean: dict[str, Path], tmp_path: Path, kind: str) -> None:
    """An error that names a file, or what the whole recording says: nothing is left out in silence."""
    chance = random.Random(kind)  # noqa: S311
    values = ["", "~", "yes", "word", "-1", "1.5", "9" * 30, "'9'", "[]", "{a: b}", "2026-11-20", ".inf", "&a [*a]"]
    values += ["\x07", "[["]
    folder = shutil.copytree(clean[kind], tmp_path / "bag")
    lines = (folder / "metadata.yaml").read_text("utf-8").splitlines()
    for _ in range(60):
        changed = list(lines)
        at = chance.randrange(len(lines))
        changed[at : at + 1] = [f"{lines[at].partition(':')[0]}: {chance.choice(values)}"] * chance.randrange(2)
        (folder / "metadata.yaml").write_text("\n".join(changed), "utf-8")
        assert outcome(folder) in ([], [str(folder)])


def test_files_of_a_killed_recorder_follow_each_other_in_time(tmp_path: Path) -> None:
    """No metadata.yaml, twelve files (the tenth sorts before the second by name), and one that was just begun."""
    said = bags.messages(Scene(seconds=6.0))
    folder = tmp_path / "bag"
    folder.mkdir()
    for number in range(12):
        inside = [m for m in said if (m.received - said[0].received) * 12 // (6 * bags.SECOND + 1) == number]
        shutil.copy(part(bags.write(tmp_path / str(number), inside, "mcap")), folder / f"bag_{number}.mcap")
    assert judged(folder).findings == []
    assert judged(folder, since=3.0).recording.messages == sum(
        m.received >= said[0].received + 3 * bags.SECOND or m.topic in ("/tf_static", "/robot_description")
        for m in said
    )
    (folder / "bag_12.mcap").write_bytes(b"")
    assert judged(folder).findings == []
    for number in range(12):
        (folder / f"bag_{number}.mcap").unlink()
    with pytest.raises(Unreadable, match=r"bag_12\.mcap is empty"):
        judged(folder)


def test_rows_of_a_database_that_are_of_another_kind(clean: dict[str, Path], tmp_path: Path) -> None:
    import sqlite3

    for number, change in enumerate(
        (
            "UPDATE topics SET name = x'00ff' WHERE name = '/scan'",
            "UPDATE topics SET type = x'00ff' WHERE name = '/scan'",
            "UPDATE messages SET timestamp = 'soon' WHERE id = 5",
            "UPDATE messages SET timestamp = 1e300 WHERE id = 5",
            "UPDATE messages SET data = 7 WHERE id = 5",
            "UPDATE messages SET data = x'' WHERE topic_id = 1 AND id > 9",
            "UPDATE topics SET offered_qos_profiles = '[[[['",
            "DELETE FROM topics",
        )
    ):
        folder = shutil.copytree(clean["sqlite3"], tmp_path / str(number))
        database = sqlite3.connect(part(folder))
        database.execute(change)
        database.commit()
        database.close()
        assert outcome(folder), change

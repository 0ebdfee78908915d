"""Watch as a person uses it: a process that runs beside an editor, and has to survive all that happens there."""

import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.importing.new_robot import init
from rosorin_compile.output.watched_files import WatchedFiles
from rosorin_compile.source.files import exists, read_bytes
from support.robots import copy_of_rosorin
from support.viewing import Running

pytestmark = pytest.mark.slow


@pytest.fixture
def project(home: Path) -> Path:
    init("bot", project=home)
    return home


@pytest.fixture
def watch(project: Path) -> Iterator[Running]:
    with Running(project, "watch") as watch:
        watch.until("watching bot")
        yield watch


def edit(project: Path, old: str, new: str, file: str = "descriptions/bot/robot.yaml") -> None:
    """Save a file as careful editors do: another file takes its place."""
    path = project / file
    text = path.read_text("utf-8")
    assert text.count(old) == 1
    new_file = path.with_name("edited~")
    new_file.write_text(text.replace(old, new), "utf-8")
    new_file.replace(path)


def artifacts(project: Path) -> dict[str, tuple[int, int]]:
    folder = project / "outputs" / "bot"
    return {path.name: (path.stat().st_ino, path.stat().st_mtime_ns) for path in folder.iterdir()}


def test_it_says_what_moved_and_writes_only_that(project: Path, watch: Running) -> None:
    before = artifacts(project)
    edit(project, "xyz: [40 mm, 0,", "xyz: [50 mm, 0,")
    told = watch.until("laser moved")
    assert told == [
        "bot: 6 artifacts in outputs/bot, written: bot.xml, frames.md, static_tf.launch.py",
        "  laser moved 10.0 mm in base_link: origin x 0.04 -> 0.05 m: mjcf, static_tf, frames",
    ]
    after = artifacts(project)
    assert {name for name in after if after[name] != before[name]} == {"bot.xml", "frames.md", "static_tf.launch.py"}
    assert watch.silent()


def test_a_change_that_changes_nothing(project: Path, watch: Running) -> None:
    before = artifacts(project)
    edit(project, "wheel_radius: 40 mm", "wheel_radius: 4 cm")
    assert watch.until("unchanged") == ["bot: 6 artifacts in outputs/bot, unchanged"]
    assert artifacts(project) == before


def test_broken_states_keep_the_artifacts(project: Path, watch: Running) -> None:
    before = artifacts(project)
    edit(project, "xyz: [40 mm, 0,", "xzy: [40 mm, 0,")
    told = watch.until("the artifacts stay as they are")
    assert told[-1] == "bot: 1 error; the artifacts stay as they are"
    assert 'error[unknown-key]: sensor "lidar" has no key "xzy"' in told[0]
    path = project / "descriptions" / "bot" / "robot.yaml"
    whole = path.read_text("utf-8")
    for text in ("robot: [", "", "\0", "robot: bot\nlinks: {a: {}, b: {}}\n"):
        path.write_text(text, "utf-8")
        watch.until("the artifacts stay as they are")
    path.unlink()
    assert "cannot read descriptions/bot/robot.yaml" in watch.until("the artifacts stay as they are")[0]
    path.write_bytes(b"\xff\xfe")
    watch.until("the artifacts stay as they are")
    assert artifacts(project) == before
    path.write_text(whole.replace("xzy: [40 mm, 0,", "xyz: [50 mm, 0,"), "utf-8")
    watch.until("laser moved 10.0 mm in base_link: origin x 0.04 -> 0.05 m")


def test_what_is_wrong_is_said_when_it_is_new(project: Path, watch: Running) -> None:
    edit(project, "xyz: [40 mm, 0,", "xzy: [40 mm, 0,")
    assert "error[unknown-key]" in watch.until("the artifacts stay as they are")[0]
    edit(project, "wheel_radius: 40 mm", "\n\n  wheel_radius: 41 mm")
    told = watch.until("the artifacts stay as they are")
    assert told == ["bot: 1 error; the artifacts stay as they are"], "its line has only moved"
    edit(project, "wheel_radius: 41 mm", "wheel_radius: 41 mn")
    told = watch.until("the artifacts stay as they are")
    assert "error[expression]" in told[0], "what cannot be asked any more is not said to be gone"
    edit(project, "wheel_radius: 41 mn", "wheel_radius: 40 mm")
    watch.until("the artifacts stay as they are")
    edit(project, "xzy: [40 mm, 0,", "xyz: [40 mm, 0,")
    assert watch.until("artifacts in outputs")[-1] == "bot: 6 artifacts in outputs/bot, unchanged"
    edit(project, "xyz: [40 mm, 0,", "xzy: [40 mm, 0,")
    assert "error[unknown-key]" in watch.until("the artifacts stay as they are")[0], "it is new again"


def test_new_includes_are_watched(project: Path, watch: Running) -> None:
    edit(project, "links:\n  base_footprint", "include: [more.yaml]\nlinks:\n  base_footprint")
    assert "cannot read descriptions/bot/more.yaml" in watch.until("the artifacts stay as they are")[0]
    more = project / "descriptions" / "bot" / "more.yaml"
    more.write_text(
        "links: {shelf: {}}\njoints: {shelf_joint: {type: fixed, parent: base_link, child: shelf, xyz: [0, 0, 0.2]}}\n",
        "utf-8",
    )
    watch.until("new: frame shelf")
    edit(project, "0.2]", "0.25]", "descriptions/bot/more.yaml")
    watch.until("origin z 0.2 -> 0.25 m")
    edit(project, "include: [more.yaml]\n", "")
    watch.until("removed: frame shelf")
    more.write_text("links: 3\n", "utf-8")
    assert watch.silent(), "a file that is included no more is watched no more"


def test_only_the_robot_that_changed_is_compiled(project: Path, watch: Running) -> None:
    copy_of_rosorin(project)
    watch.until("rosorin: 10 artifacts in outputs/rosorin, written: ")
    edit(project, "xyz: [40 mm, 0,", "xyz: [50 mm, 0,")
    told = watch.until("laser moved")
    assert not any(line.startswith("rosorin:") for line in told)
    edit(project, "0.08513]", "0.08613]", "descriptions/rosorin/arm.yaml")
    told = watch.until("link3 moved 1.0 mm in link2: origin z 0.08513 -> 0.08613 m")
    assert not any("bot:" in line or "note[" in line for line in told), "notes are told when they are new"


def test_arguments_and_their_file(project: Path) -> None:
    (project / "mine.yaml").write_text("lidar_height: 100 mm\n", "utf-8")
    with Running(project, "watch", "bot", "--args", "mine.yaml", "base:=fixed") as watch:
        watch.until("watching bot")
        (project / "mine.yaml").write_text("lidar_height: 120 mm\n", "utf-8")
        watch.until("origin z 0.1 -> 0.12 m")
        (project / "mine.yaml").write_text("lidar_hight: 120 mm\n", "utf-8")
        assert 'did you mean "lidar_height"?' in "\n".join(watch.until("the artifacts stay as they are"))
        init("second", project=project)
        assert watch.silent(), "robots that were not asked for are not compiled"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_cleanly(watch: Running, number: int) -> None:
    assert watch.end(number) == 0
    assert watch.until("watch ended") == ["watch ended"]
    assert not list(watch.folder.rglob(".rosorin-compile-*"))


def test_a_file_that_changes_while_it_is_read_is_read_again(tmp_path: Path) -> None:
    path, other = tmp_path / "a.yaml", tmp_path / "b.yaml"
    path.write_text("1", "utf-8")
    inputs = WatchedFiles()
    time.sleep(0.05)  # nobody knows whether a file of this very moment is written to the end
    inputs.read(lambda: [read_bytes(path), exists(other)])
    assert not inputs.has_changed()

    def read() -> None:
        read_bytes(path)
        path.write_text("22", "utf-8")

    inputs.read(read)
    assert inputs.has_changed()
    time.sleep(0.05)
    inputs.read(lambda: [read_bytes(path), exists(other)])
    other.write_text("", "utf-8")
    assert inputs.has_changed(), "a file that was missing is there now"

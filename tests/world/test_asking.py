"""The door: each question is noted with its answer, and asked again it is answered in the same words."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile import world
from rosorin_compile.startup.remembering import forget
from rosorin_compile.world.asking import answer
from rosorin_compile.world.notes import Notes

Ask = Callable[[], Any]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with something of each kind, which is where the process is."""
    tmp_path = tmp_path / "place"
    tmp_path.mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SOME", "value")
    monkeypatch.delenv("NONE", raising=False)
    (tmp_path / "folder" / "inner").mkdir(parents=True)
    (tmp_path / "file.txt").write_bytes(b"one\r\ntwo\n")
    (tmp_path / "folder" / "robot.yaml").write_text("robot: r\n")
    (tmp_path / "folder" / "inner" / "robot.yaml").write_text("robot: s\n")
    (tmp_path / "link").symlink_to("folder")
    (tmp_path / "nowhere").symlink_to("absent")
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe")
    return tmp_path


def noted(ask: Ask) -> tuple[Any, Notes]:
    with world.noting() as notes:
        try:
            found = ask()
        except (OSError, UnicodeDecodeError) as problem:
            found = type(problem)
    return found, notes


ASKED: list[tuple[Ask, Any]] = [
    (lambda: world.read("file.txt"), b"one\r\ntwo\n"),
    (lambda: world.read(Path("link/robot.yaml")), b"robot: r\n"),
    (lambda: world.read("absent"), FileNotFoundError),
    (lambda: world.read("file.txt/below"), NotADirectoryError),
    (lambda: world.read("folder"), IsADirectoryError),
    (lambda: world.read("a\0b"), FileNotFoundError),
    (lambda: world.read("a" * 300), OSError),
    (lambda: world.text("file.txt"), "one\ntwo\n"),
    (lambda: world.head("file.txt", 2), b"on"),
    (lambda: world.kind("file.txt"), world.FILE),
    (lambda: world.kind("link"), world.FOLDER),
    (lambda: world.kind("pipe"), world.OTHER),
    (lambda: world.kind("nowhere"), world.ABSENT),
    (lambda: world.kind("a\0b"), world.ABSENT),
    (lambda: world.kind("a" * 300), world.ABSENT),
    (lambda: world.stands("nowhere"), True),
    (lambda: world.stands("absent"), False),
    (lambda: world.link("link"), "folder"),
    (lambda: world.link("folder"), ""),
    (lambda: world.link("absent"), ""),
    (lambda: world.size("file.txt"), 9),
    (lambda: world.size("absent"), FileNotFoundError),
    (lambda: world.mode("file.txt") & 0o400, 0o400),
    (lambda: world.names("folder"), {"inner": world.FOLDER, "robot.yaml": world.FILE}),
    (lambda: world.names("file.txt"), NotADirectoryError),
    (
        lambda: world.names(""),
        {**dict.fromkeys(("folder", "link"), "folder"), "file.txt": "file", "nowhere": "", "pipe": "other"},
    ),
    (lambda: world.matching("", "*/robot.yaml"), [Path("folder/robot.yaml"), Path("link/robot.yaml")]),
    (lambda: world.matching("folder", "**/*.yaml"), [Path("folder/inner/robot.yaml"), Path("folder/robot.yaml")]),
    (lambda: world.matching("absent", "*"), []),
    (lambda: world.real("link/robot.yaml").name, "robot.yaml"),
    (lambda: world.is_same("link", "folder"), True),
    (lambda: world.is_same("absent", "folder"), False),
    (lambda: world.variable("SOME"), "value"),
    (lambda: world.variable("NONE", "else"), "else"),
    (lambda: world.is_set("NONE"), False),
    (lambda: world.environment().get("SOME"), "value"),
    (lambda: dict(world.environment())["SOME"], "value"),
    (lambda: world.here().is_absolute(), True),
    (lambda: world.package("no_such_package"), ()),
    (lambda: len(world.package("json")), 1),
]


@pytest.mark.parametrize("number", range(len(ASKED)))
def test_what_is_answered_is_noted_and_answered_again(
    place: Path, number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    ask, expected = ASKED[number]
    found, notes = noted(ask)
    assert found == expected or (isinstance(expected, type) and issubclass(found, expected))
    assert notes.answers
    assert not notes.spoiled
    if ("here", "") not in notes.answers:
        monkeypatch.chdir(place.parent)  # what is noted is true from anywhere
    assert all(answer(*question) == said for question, said in notes.answers.items())


CHANGED: list[tuple[Ask, Callable[[Path], Any]]] = [
    (lambda: world.read("file.txt"), lambda place: (place / "file.txt").write_bytes(b"one\r\ntwx\n")),
    (
        lambda: world.read("link/robot.yaml"),
        lambda place: [(place / "link").unlink(), (place / "link").symlink_to("folder/inner")],
    ),
    (lambda: world.read("absent"), lambda place: (place / "absent").write_text("")),
    (lambda: world.kind("absent"), lambda place: (place / "absent").mkdir()),
    (lambda: world.kind("nowhere"), lambda place: (place / "absent").mkdir()),
    (lambda: world.link("link"), lambda place: [(place / "link").unlink(), (place / "link").symlink_to("./folder")]),
    (lambda: world.names("folder"), lambda place: (place / "folder" / "more").mkdir()),
    (lambda: world.names(""), lambda place: (place / "absent").mkdir()),
    (
        lambda: world.real("link"),
        lambda place: [(place / "link").unlink(), (place / "link").symlink_to("folder/inner")],
    ),
    (lambda: world.is_same("link", "folder"), lambda place: [(place / "link").unlink(), (place / "link").mkdir()]),
    (lambda: world.variable("SOME"), lambda _: os.environ.pop("SOME")),
    (lambda: world.variable("NONE"), lambda _: os.environ.update(NONE="")),
    (lambda: list(world.environment()), lambda _: os.environ.update(NONE="")),
    (lambda: world.size("file.txt"), lambda place: (place / "file.txt").write_bytes(b"")),
]


@pytest.mark.parametrize("number", range(len(CHANGED)))
def test_what_has_changed_is_answered_otherwise(place: Path, number: int) -> None:
    ask, change = CHANGED[number]
    _, notes = noted(ask)
    change(place)
    assert any(answer(*question) != said for question, said in notes.answers.items())
    os.environ.pop("NONE", None)


@pytest.mark.usefixtures("place")
def test_a_pipe_is_not_waited_for_and_spoils_the_notes() -> None:
    found, notes = noted(lambda: world.read("pipe"))
    assert issubclass(found, OSError)
    assert "pipe" in notes.spoiled


def test_what_is_answered_twice_in_two_ways_spoils_the_notes(place: Path) -> None:
    def ask() -> None:
        world.read("file.txt")
        (place / "file.txt").write_text("other")
        world.read("file.txt")

    assert "file.txt has changed" in noted(ask)[1].spoiled


@pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="no /proc here")
def test_a_file_without_a_size_spoils_the_notes() -> None:
    assert "has changed" in noted(lambda: world.read("/proc/self/status"))[1].spoiled


@pytest.mark.usefixtures("place")
def test_notes_within_notes_are_those_of_both() -> None:
    with world.noting() as outer:
        world.kind("absent")
        with world.noting() as inner:
            world.read("file.txt")
            world.spoil("for a reason")
    assert len(inner.answers) == 1
    assert len(outer.answers) == 2
    assert outer.spoiled == "for a reason"


@pytest.mark.usefixtures("place")
def test_what_a_process_remembers_is_noted_each_time() -> None:
    calls = []

    @world.asked_again
    def first_line(path: str) -> str:
        calls.append(path)
        return world.text(path).partition("\n")[0]

    assert first_line("file.txt") == "one"
    found, notes = noted(lambda: first_line("file.txt"))
    assert found == "one"
    assert calls == ["file.txt"]
    assert [question for question, _ in notes.answers] == ["bytes"]
    forget()
    first_line("file.txt")
    assert len(calls) == 2


@pytest.mark.usefixtures("place")
def test_nothing_is_noted_where_nobody_does() -> None:
    world.read("file.txt")
    with world.noting() as notes:
        pass
    world.kind("absent")
    assert not notes.answers


@pytest.mark.parametrize(
    ("change", "is_good"),
    [
        (lambda _: None, True),
        (lambda folder: (folder / "made").write_text("edited"), False),
        (lambda folder: (folder / "made").unlink(), False),
        (lambda folder: (folder / "more").write_text(""), False),
        (lambda folder: (folder / "kept").write_text("edited"), True),  # it is noted as it stands
    ],
)
def test_artifacts_are_what_was_written(place: Path, change: Callable[[Path], object], is_good: bool) -> None:
    folder = place / "folder" / "inner"
    (folder / "robot.yaml").unlink()
    for name in ("made", "kept"):
        (folder / name).write_text("text")
    with world.noting() as notes:
        world.note_written(folder, {"made": b"text"}, ["kept"])
        change(folder)
        world.note_contents(folder)
    assert (notes.spoiled == "") is is_good


def test_what_a_process_remembers_of_a_relative_path_is_of_that_folder(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    @world.asked_again
    def read(name: str) -> str:
        return world.text(name)

    (place / "folder" / "file.txt").write_text("another")
    assert read("file.txt") == "one\ntwo\n"
    monkeypatch.chdir(place / "folder")
    assert read("file.txt") == "another"

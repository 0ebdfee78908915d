"""Nothing that a file, a name or another program says steers the terminal of whoever runs a command."""

import io
import os
import sys
import unicodedata
from contextlib import suppress
from pathlib import Path

import pytest

from rosorin_compile.cli import console
from rosorin_compile.cli.main import main
from rosorin_compile.source.progress import Progress

# Escape sequences of 7 and 8 bits, what turns the order of letters round, what nobody sees, and a line that is wiped.
EVIL = "\x1b[2J\x1b]0;owned\x07\x9b31m\u202e\u2066\u200b\rgone\x08"
ROBOT = "robot: plain\nlinks: {base_link: {}}\noutputs: {urdf: {file: plain.urdf}}\n"


def said(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with suppress(SystemExit):
        main(words)
    out = "".join(capsys.readouterr())
    steering = {letter for letter in out if unicodedata.category(letter) in ("Cc", "Cf", "Zl", "Zp")} - set("\n\t")
    assert not steering, out
    assert out
    return out


def write(folder: Path, text: str = ROBOT) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.yaml").write_text(text)
    return folder


@pytest.mark.parametrize("command", ["all", "check", "frames", "args", "explain", "package", "deploy", "diff", "tf"])
def test_names_of_folders(home: Path, capsys: pytest.CaptureFixture[str], command: str) -> None:
    folder = write(home / "descriptions" / EVIL)
    to = home / f"to{EVIL}"
    to.mkdir()
    words = {
        "explain": ["base_link"],
        "package": ["-o", str(to)],
        "deploy": ["-o", str(to)],
        "diff": [str(folder)],
        "tf": ["base_link", "odom"],
    }
    said([command, str(folder), *words.get(command, [])], capsys)
    said([command, str(folder) + "nowhere", *words.get(command, [])], capsys)


def test_the_path_is_shown_with_its_letters_made_visible(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(home / "descriptions" / "r\x1b[31m\u202e", ROBOT.replace("links", "lniks"))
    out = said(["all"], capsys)
    assert out.startswith(r"descriptions/r\x1b[31m\u202e/robot.yaml:2:1: error[unknown-key]")
    assert r"r\x1b[31m\u202e: " in out


HELP = r"robot: plain" "\n" r'args: {a: {default: 1, help: "\e[2J\x9b31m\u202e\rgone"}}' "\n" "links: {base_link: {}}\n"


def test_help_texts(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(home / "descriptions" / "plain", HELP)
    assert r"\x1b[2J\x9b31m\u202e" in said(["args"], capsys)
    said(["args", "--format", "json"], capsys)


@pytest.mark.parametrize("words", [["all", EVIL], [EVIL], ["all", f"--{EVIL}"], ["rule", EVIL], ["schema", EVIL]])
def test_the_words_of_a_command_line(home: Path, capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    write(home / "descriptions" / "plain")
    said(words, capsys)
    said(["all", "-a", f"{EVIL}=1"], capsys)
    said(["frames", "--frame", EVIL], capsys)
    said(["init", EVIL], capsys)
    said(["verify", EVIL], capsys)
    said(["import", EVIL], capsys)


@pytest.mark.parametrize("suffix", [".urdf", ".xml", ".xacro", ".yaml", ".json"])
def test_files_of_others(home: Path, capsys: pytest.CaptureFixture[str], suffix: str) -> None:
    path = home / f"a{EVIL}{suffix}"
    path.write_text(f"<robot name='a'><!-- {EVIL} --><link name='a{EVIL}'/></robot>")
    for words in (["import", str(path)], ["diff", str(path), str(path)], ["verify", str(path)], ["frames", str(path)]):
        said(words, capsys)


def test_what_a_recording_says(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(home / "descriptions" / "plain")
    (home / "pasted.txt").write_text(
        f"At time 0.0\n- Translation: [0, 0, 0]\nframe_id: {EVIL}\nchild_frame_id: {EVIL}\n"
    )
    said(["verify", "pasted.txt"], capsys)


@pytest.mark.slow
def test_what_another_program_says(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("xacro")
    message = r"${xacro.warning('\x1b[2J\x9b31m')}${xacro.error('\x1b]0;owned\x07')}${nothing}"
    head = '<robot name="a" xmlns:xacro="http://wiki.ros.org/xacro">'
    (home / "a.xacro").write_text(f'{head}<link name="{message}"/></robot>')
    assert "nothing" in said(["import", "a.xacro"], capsys)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_our_own_colours_and_the_bar_come_through(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.delenv(console.PROGRESS)
    monkeypatch.setenv("TERM", "xterm")
    with console.guard():
        console.paint("\x1b[31merror\x1b[0m \x1b[2J\n", sys.stderr)
        console.show_progress()
        monkeypatch.setattr(Progress, "_due", 0.0)
        Progress.step("measuring", 1, 2)
        print("\x1b[31m", file=sys.stderr)
    shown = sys.stderr.getvalue()  # type: ignore[attr-defined]
    assert shown.startswith("\x1b[31merror\x1b[0m \\x1b[2J\n\rmeasuring 1 of 2 [")
    Progress.hide()
    assert shown.endswith("\r\x1b[K\\x1b[31m\n")


def test_an_artifact_goes_into_a_file_to_the_letter_and_to_a_terminal_visibly(monkeypatch: pytest.MonkeyPatch) -> None:
    for stream, shown in ((io.StringIO(), "a\u200b"), (Terminal(), r"a\u200b")):
        monkeypatch.setattr(sys, "stdout", stream)
        with console.guard():
            console.give("a\u200b")
        assert stream.getvalue() == shown


@pytest.mark.usefixtures("home")
def test_a_name_that_is_no_text_and_a_plug_in_that_prints(capsys: pytest.CaptureFixture[str]) -> None:
    os.mkdir(b"\xff\x1b")  # noqa: PTH102 - no text can say this name
    assert r"\udcff\x1b" in said(["all", os.fsdecode(b"\xff\x1b")], capsys)
    with console.guard():
        sys.stdout.writelines(["\x1b\n", "b\n"])
    assert capsys.readouterr().out == "\\x1b\nb\n"

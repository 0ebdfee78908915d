"""Older spellings of the command line: they work for a release, and the new one is said once, on standard error."""

from __future__ import annotations

import io
import shutil
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli import main
from rosorin_compile.commands.usage import UNTIL
from support.commands import Shown

LAMP = """\
robot: {name}
links: {{base_link: {{}}, {tip}: {{}}}}
joints:
  lift: {{type: revolute, parent: base_link, child: {tip}, axis: [0, 0, 1], limit: {{lower: 0, upper: 1, effort: 1,
    velocity: 1}}}}
outputs:
  {output}: {{backend: urdf, file: a.urdf}}
"""
SESSION = "At time 0.0\n- Translation: [0, 0, 0]\n"


def robot(name: str, tip: str = "tip", output: str = "plain") -> None:
    folder = Path("descriptions", name)
    folder.mkdir(parents=True)
    (folder / "robot.yaml").write_text(LAMP.format(name=name, tip=tip, output=output))


def note(new: str, old: str = "the old order") -> str:
    return f'rosorin-compile: say "rosorin-compile {new}"; {old} ends with {UNTIL}\n'


def both(capsys: Shown, old: list[str], new: list[str], said: str) -> str:
    """Return what the new spelling prints, after seeing that the old one does the same and says the new one."""
    code = main(new)
    wanted = capsys.readouterr()
    assert "ends with" not in wanted.err
    assert main(old) == code
    shown = capsys.readouterr()
    assert shown.out == wanted.out
    assert shown.err == said + wanted.err
    return wanted.out + wanted.err


@pytest.mark.parametrize("word", ["lamp", "descriptions/lamp", "descriptions/lamp/robot.yaml"])
def test_the_robot_was_the_last_word(home: Path, capsys: Shown, word: str) -> None:
    robot("lamp")
    robot("other")
    assert "<robot" in both(capsys, ["print", "urdf", word], ["print", word, "urdf"], note(f"print {word} urdf"))
    new = ["tf", word, "base_link", "tip"]
    assert "Translation" in both(capsys, ["tf", "base_link", "tip", word], new, note(f"tf {word} base_link tip"))
    (home / "my session.txt").write_text(SESSION)
    old, new = ["verify", "my session.txt", word], ["verify", word, "my session.txt"]
    both(capsys, old, new, note(f"verify {word} 'my session.txt'"))


def test_standard_input_was_the_last_word(home: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    text = LAMP.format(name="lamp", tip="tip", output="plain").encode()
    (home / "session.txt").write_text(SESSION)
    for old, new in (
        ("print urdf -", "print - urdf"),
        ("tf base_link tip -", "tf - base_link tip"),
        ("verify session.txt -", "verify - session.txt"),
    ):
        said = []
        for line in (old, new):
            monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text)))
            main(line.split())
            said.append(capsys.readouterr())
        assert said[0].out == said[1].out
        assert said[0].err == note(new) + said[1].err
    robot("lamp")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(SESSION.encode())))
    main(["verify", "-", "lamp"])
    assert capsys.readouterr().err.startswith(note("verify lamp -"))


@pytest.mark.usefixtures("home")
def test_the_robot_was_an_option(capsys: Shown) -> None:
    robot("lamp")
    robot("other")
    for old, new in (
        ("tf base_link tip -r lamp", "tf lamp base_link tip"),
        ("tf --robot=lamp base_link tip", "tf lamp base_link tip"),
        ("explain -rlamp tip", "explain lamp tip"),
    ):
        option = "--robot" if "--robot" in old else "-r"
        both(capsys, old.split(), new.split(), note(f"{new.split()[0]} lamp ...", option))


@pytest.mark.usefixtures("rosorin")
def test_the_robot_stood_behind_its_servos(capsys: Shown) -> None:
    old, new = "pulses joint1=500 rosorin -q", "pulses rosorin joint1=500 -q"
    both(capsys, old.split(), new.split(), note("pulses rosorin joint1=500"))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("all lamp --outputs a", "all lamp -o a/lamp", "all -o a/lamp"),
        ("compile lamp --outputs=a", "all lamp -o a/lamp", "all -o a/lamp"),
        ("all --outputs a", "all -o a", "all -o a"),
        ("all -n --outputs a", "all -n -o a", "all -o a"),
        ("check lamp --outputs a", "check lamp -o a/lamp", "check -o a/lamp"),
        ("check --outputs a -q", "check -o a -q", "check -o a"),
    ],
)
def test_a_folder_was_that_of_all_robots(home: Path, capsys: Shown, old: str, new: str, said: str) -> None:
    robot("lamp")
    robot("other")
    main(new.split())
    made = sorted(home.rglob("a*/**"))
    shutil.rmtree("a", ignore_errors=True)
    main(old.split())
    assert sorted(home.rglob("a*/**")) == made
    capsys.readouterr()
    both(capsys, old.split(), new.split(), note(said, "--outputs"))


@pytest.mark.usefixtures("home")
def test_a_folder_had_other_names(capsys: Shown) -> None:
    robot("lamp")
    Path("new").mkdir()
    Path("old").mkdir()
    assert main(["deploy", "lamp", "-o", "new"]) == 0
    wanted = capsys.readouterr()
    assert main(["deploy", "lamp", "--to", "old"]) == 0
    assert capsys.readouterr() == (
        wanted.out.replace("in new", "in old"),
        note("deploy -o old", "--to") + wanted.err.replace("new is", "old is"),
    )
    assert main(["init", "bot", "-o", "one"]) == 0
    wanted = capsys.readouterr()
    assert main(["init", "bot", "--folder", "two"]) == 0
    assert capsys.readouterr() == (wanted.out.replace("one", "two"), note("init NAME -o two", "--folder") + wanted.err)
    assert main(["deploy", "lamp"]) == 2
    assert "deploy into which folder? rosorin-compile deploy ROBOT -o FOLDER" in capsys.readouterr().err


@pytest.mark.parametrize("words", ["all", "check", "deploy", "init", "tf", "explain", "pulses"])
def test_the_help_has_none(capsys: Shown, words: str) -> None:
    with pytest.raises(SystemExit):
        main([words, "--help"])
    assert not {"--outputs", "--to", "--folder", "--robot"} & set(capsys.readouterr().out.replace(",", " ").split())


# What may be read in both orders is read in the new one, unless only the old one fits.


def test_an_output_that_is_called_as_a_robot(home: Path, capsys: Shown) -> None:
    robot("lamp", output="urdf")
    robot("urdf", output="special")
    assert main(["print", "lamp", "urdf"]) == 0  # both are robots, and urdf is an output of the first
    assert capsys.readouterr().err == ""
    assert main(["print", "urdf", "special"]) == 0
    assert '<robot name="urdf">' in capsys.readouterr().out
    assert main(["print", "urdf", "lamp"]) == 0  # there is no output "lamp"
    assert capsys.readouterr().err == note("print lamp urdf")
    robot("special", output="lamp")
    assert main(["print", "special", "lamp"]) == 0  # all three are robots, and both are outputs: the new order
    shown = capsys.readouterr()
    assert '<robot name="special">' in shown.out
    assert shown.err == ""
    (home / "frames").write_text("a file that is called as a format")
    assert main(["print", "lamp", "frames"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.usefixtures("home")
def test_frames_that_are_called_as_robots(capsys: Shown) -> None:
    robot("lamp", tip="mast")
    robot("mast", tip="lamp")
    assert main(["tf", "lamp", "mast", "base_link"]) == 0  # lamp is a frame of mast, not base_link's robot
    assert capsys.readouterr().err == ""
    assert main(["tf", "mast", "base_link", "lamp"]) == 0  # mast has both frames
    assert capsys.readouterr().err == ""
    assert main(["tf", "base_link", "lamp", "mast"]) == 0  # base_link is no robot
    assert capsys.readouterr().err == note("tf mast base_link lamp")
    robot("base_link", tip="top")
    assert main(["tf", "base_link", "lamp", "mast"]) == 0  # three robots: the first has no frame lamp
    assert capsys.readouterr().err == note("tf mast base_link lamp")


def test_a_recording_that_is_called_as_a_robot(home: Path, capsys: Shown) -> None:
    pytest.importorskip("numpy")
    robot("lamp")
    shutil.copy(home / "descriptions/lamp/robot.yaml", "lamp.yaml")
    Path("pasted.yaml").write_text(SESSION)
    both(capsys, ["verify", "pasted.yaml", "lamp"], ["verify", "lamp", "pasted.yaml"], note("verify lamp pasted.yaml"))
    main(["verify", "lamp.yaml", "pasted.yaml"])  # either may be pasted messages: the new order
    assert "ends with" not in capsys.readouterr().err
    Path("lamp").mkdir()
    Path("lamp/metadata.yaml").write_text("")  # a recording in a folder that is called as the robot
    main(["verify", "lamp", "lamp"])
    assert "ends with" not in capsys.readouterr().err


@pytest.mark.usefixtures("home")
def test_a_launch_file_hears_nothing(capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes any word on standard error for a failure, and those of older packages have the old order."""
    robot("lamp")
    monkeypatch.setenv("AMENT_PREFIX_PATH", "/opt/ros/jazzy")
    assert main(["print", "urdf", "lamp"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.usefixtures("home")
def test_it_is_said_again_with_what_is_remembered(capfd: Shown) -> None:
    from rosorin_compile.world import memory

    robot("lamp")
    words = ["print", "urdf", "lamp"]
    assert memory.once(memory.line(words), lambda: main(words))[1] is False
    first = capfd.readouterr()
    done = memory.say_again(words)
    assert done is not None
    assert done.code == 0
    again = capfd.readouterr()
    assert (again.out, again.err) == (first.out, first.err)
    assert first.err == note("print lamp urdf")
    assert memory.say_again(["print", "lamp", "urdf"]) is None

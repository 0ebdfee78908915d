"""What may stand at the cursor: all of it comes from the parser and the project, in silence."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.cli.completion import robot_names
from rosorin_compile.cli.completion.candidates import CommandLine, candidates
from rosorin_compile.cli.completion.line import split
from rosorin_compile.cli.main import main, parser
from rosorin_compile.cli.parser import Parser
from rosorin_compile.cli.registry import commands
from rosorin_compile.language.arguments import declared
from rosorin_compile.source.memo import forget
from support.commands import HANDY, edit
from support.paths import ROOT

PROJECT = {
    **HANDY,
    "my robots/a b.yaml": "robot: a\n",
    "my robots/notes.txt": "",
    ".hidden/x.yaml": "robot: x\n",
    "arm.urdf": '<robot name="arm"><link name="base"/><link name="tool"/><joint name="j" type="fixed">'
    '<parent link="base"/><child link="tool"/></joint></robot>',
    "arm.xacro": '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="side" default="l"/>'
    "<link name=\"${open('ran', 'w').write('') or 1}\"/></robot>",
}
COMMANDS = {name: one.help for name, one in commands().items()}
OURS = CommandLine(COMMANDS, parser)
BREAKS = " \t\n\"'@><=;|&(:"
# What is no name, number or file that could be looked up: places whose values are free text.
FREE = {
    "NAME",
    "TEXT",
    "NUMBER",
    "LENGTH",
    "N",
    "S",
    "NS",
    "Z",
    "X,Y",
    "X,Y,Z",
    "R,P,Y",
    "NXxNY",
    "FROM:TO:COUNT",
    "NODE:FROM:=TO",
}
FREE |= {"PULSE", "VALUE", "PLACE", "TOPIC", "SPDX", "URL", "ADDRESS", "VIEW", "WxH", "X.Y.Z", "NOTE", "'NAME <MAIL>'"}


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the completion take its time, and forget what it took in other tests: a machine may be busy."""
    monkeypatch.setattr(robot_names, "PATIENCE", 60)
    monkeypatch.setattr(robot_names, "_spent", [])


def words(line: str, *more: str) -> list[str]:
    """Return what may stand at the end of a line."""
    forget()  # a process answers once
    *before, current = [*line.split(" "), *more]
    return [one.word for one in candidates(before, current, OURS)]


def parsers() -> Iterator[tuple[list[str], Parser]]:
    """Yield the parser of each command, of extract those of its ways."""
    for name in COMMANDS:
        command = parser([name]).within[name]
        ways = command.within.items()
        yield from (([name, way], inner) for way, inner in ways) if ways else [([name], command)]


@pytest.mark.usefixtures("project")
def test_every_command_and_every_option_is_completed() -> None:
    assert words("") == list(COMMANDS)
    assert words("--") == ["--help", "--version"]
    for called, command in parsers():
        options = [one for action in command.shown() for one in action.option_strings]
        long = {one for one in options if one.startswith("--")}
        assert set(words(" ".join(called), "--")) == long, called
        for option in set(options) - long:
            assert option in words(" ".join(called), option), called


@pytest.mark.usefixtures("project")
def test_every_choice_of_every_option_is_completed() -> None:
    found = 0
    for called, command in parsers():
        for action in command.options:
            for option in action.option_strings if action.choices else ():
                choices = [str(choice) for choice in action.choices or ()]
                assert words(" ".join(called), option, "") == choices
                assert words(" ".join(called), f"{option}={choices[-1][:1]}") == [
                    f"{option}={one}" for one in choices if one.startswith(choices[-1][:1])
                ] or not option.startswith("--")
                found += 1
    assert found > 15


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("tf map od", ["odom"]),
        ("tf h", ["handy"]),
        ("tf handy map od", ["odom"]),
        ("tf handy map odom x", []),
        ("tf --ro", []),
        ("tf --pose o", ["open"]),
        ("tf --joint=left_f0_j", ["--joint=left_f0_joint="]),
        ("tf map --sweep shelf_j", ["shelf_joint="]),
        ("explain handy left_f0_j", ["left_f0_joint"]),
        ("explain handy map ey", ["eye_link", "eye_link_optical", "eye_link_joint", "eye_link_optical_joint", "eye"]),
        ("frames --frame chi", ["chip"]),
        ("frames --fra chi", ["chip"]),
        ("frames --publisher a", ["amcl"]),
        ("frames --mode ", ["mapping", "mapping=off"]),
        ("frames --mode=mapping=o", ["--mode=mapping=off"]),
        ("frames -- h", ["handy"]),
        ("all sc", ["scale:="]),
        ("all scale:=", ["scale:=1"]),
        ("all handy scale:=2 h", []),
        ("all -a sc", ["scale="]),
        ("all -a scale=", ["scale=1"]),
        ("all --arg=scale=", ["--arg=scale=1"]),
        ("all my", ["my robots/"]),
        ("all ./my", ["./my robots/"]),
        ("all .h", [".hidden/"]),
        ("check -o my", ["my robots/"]),
        ("check --package a", []),
        ("check --package a=my", ["a=my robots/"]),
        ("verify --frames base_link eye_link_", ["eye_link_optical"]),
        ("verify --frames base_link eye_link m", ["my robots/"]),
        ("verify h", ["handy"]),
        ("verify handy my", ["my robots/"]),
        ("print u", ["urdf"]),
        ("print mj", ["mjcf"]),
        ("print h", ["handy"]),
        ("print handy u", ["urdf"]),
        ("print handy urdf sc", ["scale:="]),
        ("print --list h", ["handy"]),
        ("all --only u", ["urdf"]),
        ("all --depfile my", ["my robots/"]),
        ("deploy --map u", ["urdf="]),
        ("package --topic e", ["eye="]),
        ("diff handy ar", ["arm.urdf", "arm.xacro"]),
        ("import arm.x", ["arm.xacro"]),
        ("import arm.xacro s", ["side:="]),
        ("extract boxes arm.urdf --link t", ["tool"]),
        ("tf arm.urdf base t", ["tool"]),
        ("rule axis-z", ["axis-zero"]),
        ("schema rec", ["recording"]),
        ("extract h", ["heightmap"]),
        ("completion ", ["bash", "zsh", "fish"]),
        ("chek ", []),
        ("init ", []),
        ("init bot ", ["base", "arm", "mobile_manipulator", "sensor_rig"]),
        ("init bot m", ["mobile_manipulator"]),
        ("init bot arm ", []),
        ("all --no-such=", []),
        ("all --no-such h", ["handy"]),
    ],
)
def test_what_may_stand_there(line: str, wanted: list[str]) -> None:
    assert words(line) == wanted


def test_words_with_blanks_home_and_hidden_files(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(project / "my robots"))
    assert words("all", "my robots/") == ["my robots/a b.yaml"]  # notes.txt is no robot
    assert words("all --args", "my robots/") == ["my robots/a b.yaml", "my robots/notes.txt"]
    assert words("all", "~") == ["~/"]
    assert words("all", "~/a") == ["~/a b.yaml"]
    assert ".hidden/" not in words("all", "")
    assert words("all", "nowhere/") == []
    assert words("all", "x\0") == []
    (project / "a\nb.yaml").write_text("")
    os.mkdir(b"\xff")  # noqa: PTH102 - no text can say this name
    (project / "-x.yaml").write_text("")
    assert not [word for word in words("all", "") if not word.isprintable()]
    assert words("all", "./-") == ["./-x.yaml"]


def test_a_robot_that_is_named_and_several_that_are_not(project: Path) -> None:
    (project / "descriptions" / "other").mkdir()
    (project / "descriptions" / "other" / "robot.yaml").write_text("robot: other\nlinks: {other_base: {}}\n")
    assert words("tf other") == ["other", "other_base"]
    assert candidates(["tf"], "other_", OURS)[0].help == "other"
    assert words("tf handy other") == []
    assert words("explain other o") == ["other_base"]
    assert words("all o") == ["other"]
    assert words("all handy ") == [one for one in words("all ") if one != "handy"]


def test_arguments_decide_what_there_is(project: Path) -> None:
    robot = project / "descriptions" / "handy" / "robot.yaml"
    edit(robot, "eye: {type", 'eye: {if: "${scale == 2}", type')
    assert words("tf eye_link_o") == []
    assert words("tf scale:=2 eye_link_o") == words("tf -a scale=2 eye_link_o") == ["eye_link_optical"]


@pytest.mark.parametrize("broken", ["links: [", "links: {base_link: {}}\n", "robot: 1\n  x", "\t"])
def test_a_broken_description_has_the_names_of_its_text(project: Path, broken: str) -> None:
    robot = project / "descriptions" / "handy" / "robot.yaml"
    plain = "robot: h\nargs:\n  scale: {default: 1}\nlinks:\n  base_link: {}\n  shelf:\n    visual:\n      - box: 1\n"
    robot.write_text(f"{plain}sensors:\n  eye: {{type: camera, frame: eye_link}}\nposes:\n  open: 1\n{broken}")
    assert words("tf shel") == ["shelf"]
    assert words("tf eye") == ["eye_link"]
    assert words("tf --pose o") == ["open"]
    assert words("explain ey") == ["eye_link", "eye"]
    assert words("frames h") == ["handy"]


def test_the_entries_of_every_section_can_be_asked_for(project: Path) -> None:
    robot = project / "descriptions" / "handy" / "robot.yaml"
    whole = robot.read_text("utf-8")
    section = "mjcf_sensors: {ticks: {kind: clock}}\n"  # no line begins with the name: the tree has it
    for text in (f"{whole}\n{section}", f"{whole}\nmjcf_sensors:\n  ticks: {{kind: clock}}\nlinks: ["):
        robot.write_text(text)
        forget()
        assert list(robot_names.names(robot_names.Subject(("handy",), {}, {}), "mjcf_sensors")) == ["ticks"]
    robot.write_text(f"{whole}\n{section}")
    assert words("explain handy ti") == ["ticks"]


@pytest.mark.usefixtures("project")
def test_what_each_entry_is_goes_with_its_name() -> None:
    handy = robot_names.Subject(("handy",), {}, {})
    found = {of: robot_names.names(handy, of) for of in ("sensors", "outputs", "poses")}
    assert found == {"sensors": {"eye": "camera"}, "outputs": {"urdf": "handy.urdf"}, "poses": {"open": ""}}
    assert robot_names.names(handy, "links")["shelf"] == "on base_link"
    assert robot_names.names(handy, "joints")["shelf_joint"] == "fixed, base_link -> shelf"


def test_a_broken_description_has_names_that_stand_in_its_entries(project: Path) -> None:
    robot = project / "descriptions" / "handy" / "robot.yaml"
    robot.write_text("sensors:\n  eye: {type: camera, frame: eye_link, joint: stalk}\nlinks: [")
    assert words("tf eye") == ["eye_link"]
    assert words("explain st") == ["stalk"]


def test_what_takes_long_has_the_names_of_its_text(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_names, "PATIENCE", 0.0)
    monkeypatch.setattr(robot_names, "_LEAST", 1e-5)
    assert words("tf sh") == []
    robot = project / "descriptions" / "handy" / "robot.yaml"
    edit(robot, "links: {base_link: {}, shelf: {", "links:\n  base_link: {}\n  shelf: {")
    edit(robot, 'scale}", 1]}}]}}', 'scale}", 1]}}]}')
    assert words("tf sh") == ["shelf"]


@pytest.mark.parametrize("line", ["tf arm.xacro b", "tf map o", "all s", "explain x", "import arm.xacro s"])
def test_nothing_is_run_written_or_said(project: Path, line: str, capfd: pytest.CaptureFixture[str]) -> None:
    include = "include: [{file: ../../arm.xacro}, parts.yaml]"
    edit(project / "descriptions" / "handy" / "robot.yaml", "include: [parts.yaml]", include)
    before = sorted(project.rglob("*"))
    assert main(["complete", "--", *line.split(" ")]) == 0
    cache = project / "cache"  # of the user: a second key is answered sooner
    assert sorted(path for path in project.rglob("*") if path != cache and cache not in path.parents) == before
    assert capfd.readouterr().err == ""


def test_included_robots_that_run_nothing_are_read(project: Path) -> None:
    include = "include: [{file: ../../arm.urdf, prefix: my_}, parts.yaml]"
    edit(project / "descriptions" / "handy" / "robot.yaml", "include: [parts.yaml]", include)
    assert words("explain my_t") == ["my_tool"]


@pytest.mark.parametrize(
    "asked",
    [
        [],
        ["--"],
        ["tf"],
        ["--bash"],
        ["--bash", "x"],
        ["--", "\udcff"],
        ["--", "all", "-"],
        ["--zsh", "a", "b"],
        ["--x"],
    ],
)
@pytest.mark.usefixtures("project")
def test_whatever_is_asked_it_ends_in_silence(asked: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["complete", *asked]) == 0
    assert capfd.readouterr().err == ""


def test_what_others_print_is_no_candidate(
    project: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert project.is_dir()
    monkeypatch.setattr(robot_names, "names", lambda *_: print("hello") or print("oh", file=sys.stderr) or {"odom": ""})
    assert main(["complete", "--", "tf", "o"]) == 0
    assert capfd.readouterr() == ("odom\nodom:=\n", "")
    monkeypatch.setattr(robot_names, "names", lambda *_: parser(["nosuch"]))
    assert main(["complete", "--", "tf", "o"]) == 0
    assert capfd.readouterr() == ("", "")


def test_in_a_folder_that_is_gone(home: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (home / "gone").mkdir()
    os.chdir(home / "gone")
    (home / "gone").rmdir()
    assert main(["complete", "--", "tf", ""]) == 0
    os.chdir(home)
    assert capfd.readouterr() == ("", "")


def test_names_that_are_no_line_are_left_out(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(project / "descriptions" / "handy" / "robot.yaml", "odom, child", '"od\\nom\\tx", child')
    assert "od\nom\tx" in words("tf od")
    main(["complete", "--", "tf", "od"])
    assert capsys.readouterr().out in ("", "odom\n"), "the name is two lines"
    (project / "descriptions" / "$(touch ran)").mkdir()
    (project / "descriptions" / "$(touch ran)" / "robot.yaml").write_text("robot: a\n")
    main(["complete", "--bash", "rosorin-compile all $", BREAKS])
    main(["complete", "--bash", "rosorin-compile all \\$", BREAKS])
    assert capsys.readouterr().out == "\\$\\(touch\\ ran\\)\n" * 2


def test_several_slow_robots_take_the_patience_of_one(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert project.is_dir()
    limits: list[float] = []
    monkeypatch.setattr(robot_names.signal, "setitimer", lambda _, limit: limits.append(limit))
    for spent in (0, robot_names.PATIENCE - 0.5, robot_names.PATIENCE):
        robot_names._spent[:] = [spent]
        forget()
        assert "odom" in robot_names.names(robot_names.Subject((), {}, {}), "frames")
    assert [limit > 0 for limit in limits] == [True, False] * 3
    assert limits[0] == robot_names.PATIENCE
    assert limits[2] == pytest.approx(0.5)
    assert limits[4] == robot_names._LEAST


def test_the_help_goes_with_the_word(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert project.is_dir()
    assert main(["complete", "--", "chec"]) == 0
    assert capsys.readouterr().out == f"check\t{COMMANDS['check']}\n"
    main(["complete", "--", "tf", "--pos"])
    assert re.fullmatch(r"--pose\t\w.+\n", capsys.readouterr().out)


@pytest.mark.parametrize(
    ("typed", "wanted"),
    [
        ("p tf las", ["p", "tf", "las"]),
        ("p tf ", ["p", "tf", ""]),
        ("p base:=fr", ["p", "base:=fr"]),
        ("p --mode=", ["p", "--mode="]),
        ("p 'a b", ["p", "a b"]),
        ('p "a\\"b\\x', ["p", 'a"b\\x']),
        ("p a\\ b", ["p", "a b"]),
        ("p a'b c'd", ["p", "ab cd"]),
        ("p a ''", ["p", "a", ""]),
        ("p a\\", ["p", "a"]),
        ("p tf a > fi", ["p", "tf", "a", "fi"]),
        ("p tf a 2>fi", ["p", "tf", "a", "fi"]),
        ("p tf < in a", ["p", "tf", "a"]),
        ("p tf <in ", ["p", "tf", ""]),
    ],
)
def test_the_line_of_bash(typed: str, wanted: list[str]) -> None:
    line = split(typed, BREAKS)
    assert line.words == wanted
    assert line.target == (wanted[-1] == "fi")


@pytest.mark.parametrize(
    ("typed", "word", "wanted"),
    [
        ("p base:=fr", "base:=free", "free"),
        ("p base:", "base:=", "="),
        ("p --mode=", "--mode=slam", "slam"),
        ("p --mode=slam=", "--mode=slam=off", "off"),
        ("p my", "my robots/", "my\\ robots/"),
        ("p 'my", "my robots/it's", "my robots/it'\\''s"),
        ('p "my', 'my $"`\\robots', 'my \\$\\"\\`\\\\robots'),
        ('p "base:=', "base:=free", "base:=free"),
        ("p ~/x", "~/x y", "~/x\\ y"),
        ("p ", "~x", "\\~x"),
        ("p ", "a!b", "a\\!b"),
    ],
)
def test_what_bash_inserts(typed: str, word: str, wanted: str) -> None:
    assert split(typed, BREAKS).inserted(word) == wanted
    assert split("p a:=", "").inserted("a:=b") == "a:=b"


def test_the_arguments_of_the_reference_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    arguments = declared(ROOT / "descriptions" / "rosorin" / "robot.yaml", {})[0]
    assert set(words("all")) == {"all"}
    assert {f"{one.name}:=" for one in arguments} <= set(words("all rosorin "))
    for one in arguments:
        if one.allowed:
            assert words(f"all {one.name}:=") == [f"{one.name}:={value}" for value in one.allowed]


def test_other_commands_do_not_pay_for_it() -> None:
    import subprocess

    code = "import sys; from rosorin_compile.cli.main import main; main(['all', '--help'])"
    code = f"import atexit, sys\natexit.register(lambda: print(*sys.modules, sep='\\n'))\n{code}"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "rosorin_compile.cli.all" in shown
    assert "completion" not in shown

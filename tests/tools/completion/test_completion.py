"""Shell completion: names of commands, options, robots, frames, joints, poses, arguments and formats are offered."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from rosorin_compile.cli.main import COMPLETE, commands, main
from support.commands import HANDY, Shown, complete
from support.shells import environment, shell

PROJECT = {
    **HANDY,
    "arm.xacro": '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="side" default="l"/>'
    "<link name=\"${open('ran', 'w').write('') or 1}\"/></robot>",
}
LINES = [
    ("chec", "check "),
    ("tf handy od", "tf handy odom "),
    ("tf ha", "tf handy "),
    ("rule axis-ac", "rule axis-across "),
]


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("che", {"check"}),
        ("tf handy od", {"odom"}),
        ("tf h", {"handy"}),
        ("tf handy --pose o", {"open"}),
        ("tf handy --joint left_f0_j", {"left_f0_joint="}),
        ("frames handy --frame chi", {"chip"}),
        ("frames handy --mode map", {"mapping", "mapping=off"}),
        ("explain handy ey", {"eye", "eye_link", "eye_link_optical", "eye_link_joint", "eye_link_optical_joint"}),
        ("all sc", {"scale:="}),
        ("all -a sc", {"scale="}),
        ("print handy urd", {"urdf"}),
        ("check --format gi", {"github"}),
        ("check phy", {"physics"}),
        ("check physics --fail", {"--fail-on"}),
        ("rule axis-ac", {"axis-across"}),
        ("completion z", {"zsh"}),
        ("help fra", {"frames"}),
    ],
)
def test_names_are_offered(line: str, offered: set[str], capsys: Shown) -> None:
    assert offered == complete(capsys, line)


@pytest.mark.usefixtures("project")
def test_every_option_is_offered_and_nothing_runs(home: Path, capsys: Shown) -> None:
    for name in commands():
        assert name == "extract" or {"--format", "--quiet", "--verbose"} <= complete(capsys, f"{name} --"), name
    complete(capsys, "tf arm.xacro ba")
    assert not (home / "ran").exists()


@pytest.mark.usefixtures("home")
def test_an_error_is_silent(capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    for line in ("nosuch ", "tf nosuch x", "check nosuch x"):
        assert complete(capsys, line) == set()
    monkeypatch.setenv(COMPLETE, "nonsense")
    assert main([]) == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["bash", "zsh", "fish"])
def test_the_script_is_valid(home: Path, name: str, capsys: Shown) -> None:
    if shutil.which(name) is None:
        pytest.skip(f"{name} is not installed")
    assert main(["completion", name]) == 0
    (home / "script").write_text(capsys.readouterr().out)
    checked = subprocess.run([name, "-n", "script"], capture_output=True, text=True, check=False)
    assert (checked.returncode, checked.stderr) == (0, "")


@pytest.mark.tier("outside")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["bash", "zsh"])
def test_a_line_is_completed_on_a_terminal(project: Path, name: str) -> None:
    if shutil.which(name) is None:
        pytest.skip(f"{name} is not installed")
    with shell(name, project) as made:
        for typed, wanted in LINES:
            assert made.typed(f"rosorin-compile {typed}") == f"rosorin-compile {wanted}", name


@pytest.mark.slow
def test_the_installed_program_answers_bash(project: Path) -> None:
    env = {**os.environ, **environment(project), "COMP_WORDS": "rosorin-compile tf handy od", "COMP_CWORD": "3"}
    ran = subprocess.run(
        ["rosorin-compile"],
        cwd=project,
        env={**env, COMPLETE: "bash_complete"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert (ran.stdout, ran.stderr) == ("plain,odom\n", "")

"""The scripts in the shells themselves: a line is typed, the tabulator is pressed, and the line is what was meant."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

import pytest

from rosorin_compile.cli.completion.command import SCRIPTS
from rosorin_compile.cli.main import main
from rosorin_compile.cli.registry import commands
from support.commands import HANDY
from support.shells import environment, shell

PROJECT = {**HANDY, "my robots/a b.yaml": "robot: a\n", "my robots/it's.urdf": "<robot/>", "$x/y.yaml": "robot: y\n"}

# What is typed, and what it becomes in bash and zsh.
LINES = [
    ("chec", "check "),
    ("tf map od", "tf map odom "),
    ("tf ha", "tf handy "),
    ("tf handy map od", "tf handy map odom "),
    ("frames --mode=map", "frames --mode=mapping"),
    ("all sc", "all scale:="),
    ("all scale:", "all scale:="),
    ("all scale:=", "all scale:=1 "),
    ("all -a scale=", "all -a scale=1 "),
    ("check --format=gi", "check --format=github "),
    ("check --format gi", "check --format github "),
    ("all -- ha", "all -- handy "),
    ("all --output ~/my", "all --output ~/my\\ robots/"),
    ("all my\\ robots/a", "all my\\ robots/a\\ b.yaml "),
    ("all my\\ robots/it", "all my\\ robots/it\\'s.urdf "),
    ('all "my robots/a', 'all "my robots/a b.yaml" '),
    ("all 'my robots/it", "all 'my robots/it'\\''s.urdf' "),
    ("all ./\\$x/", "all ./\\$x/y.yaml "),
    ("tf map odom > my\\ robots/a", "tf map odom > my\\ robots/a\\ b.yaml "),
    ("all $HOME/my", "all $HOME/my\\ robots/"),
    ("rule axis-ac", "rule axis-across "),
    ("tf map nosuchframe", "tf map nosuchframe"),
    ("nosuchcommand ", "nosuchcommand "),
]


def needs(name: str) -> None:
    if shutil.which(name) is None:
        pytest.skip(f"{name} is not installed")


@pytest.mark.tier("outside")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["bash", "zsh"])
def test_a_line_is_completed_on_a_terminal(project: Path, name: str) -> None:
    needs(name)
    with shell(name, project) as made:
        for typed, wanted in LINES:
            if typed == "nosuchcommand " and name == "bash":  # bash shows the files here
                continue
            assert made.typed(f"rosorin-compile {typed}") == f"rosorin-compile {wanted}", name
        assert made.typed("X=1 rosorin-compile chec") == "X=1 rosorin-compile check "
        assert made.typed("echo a | rosorin-compile chec") == "echo a | rosorin-compile check "


@pytest.mark.slow
def test_bash_gets_all_that_may_stand_there(project: Path) -> None:
    """As bash calls the function: the line, the cursor within it, and the words broken at = and :."""
    needs("bash")
    code = """
        eval "$(rosorin-compile completion bash)"
        ask() {
            COMP_LINE=$1 COMP_POINT=${2:-${#1}} COMP_CWORD=1 COMP_WORDS=(rosorin-compile x)
            _rosorin_compile rosorin-compile x rosorin-compile
            IFS='|'; echo "${COMPREPLY[*]}"
        }
        ask 'rosorin-compile frames --mode '
        ask 'rosorin-compile frames --mode=mapping='
        ask 'rosorin-compile check xyz' 20
        ask 'rosorin-compile verify --frames base_link eye_'
        COMP_WORDBREAKS=' '; ask 'rosorin-compile all scale:='
    """
    shown = subprocess.run(
        ["bash", "-c", code], cwd=project, env=environment(project), capture_output=True, text=True, check=True
    )
    assert shown.stderr == ""
    assert shown.stdout.splitlines() == ["mapping|mapping=off", "off", "check", "eye_link|eye_link_optical", "scale:=1"]


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_zsh_shows_what_each_is_and_loads_it_from_a_file(project: Path) -> None:
    needs("zsh")
    with shell("zsh", project, ["LISTMAX=0"]) as made:
        made.send("rosorin-compile c\t\t")
        seen = made.until("print the completion script")
        assert f"-- {commands()['check'].help}" in seen
    assert SCRIPTS["zsh"].startswith("#compdef rosorin-compile\n")
    folder = project / "functions"
    folder.mkdir()
    (folder / "_rosorin-compile").write_text(SCRIPTS["zsh"])
    with shell(
        "zsh", project, ["compdef -d rosorin-compile", "fpath=($PWD/functions $fpath)", "compinit -u -D"]
    ) as made:
        assert made.typed("rosorin-compile chec") == "rosorin-compile check "


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_fish_is_told_words_and_what_they_are(project: Path) -> None:
    needs("fish")
    wanted = {
        "chec": f"check\t{commands()['check'].help}",
        "tf map od": "odom",
        "all sc": "scale:=\tdefault: 1",
        "all scale:=": "scale:=1",
        "check --format=gi": "--format=github",
        "all ~/my": "~/my robots/",
        "all my\\ robots/a": "my robots/a b.yaml",
        'all "my robots/a': "my robots/a b.yaml",
        "all -- ha": "handy\trobot of this project",
        "frames --mode mapping=": "mapping=off\tis off",
        "tf map nosuchframe": "",
    }
    asked = "\n".join(f"echo (complete -C '{line}' | string collect)" for line in _of_fish(wanted))
    code = f"rosorin-compile completion fish | source\n{asked}\n"
    shown = subprocess.run(
        ["fish", "-c", code], cwd=project, env=environment(project), capture_output=True, text=True, check=True
    )
    assert dict(zip(wanted, shown.stdout.splitlines(), strict=True)) == wanted
    assert shown.stderr == ""


def _of_fish(lines: Iterable[str]) -> list[str]:
    """Return lines as they stand between the single quotes of fish."""
    return [f"rosorin-compile {line}".replace("\\", "\\\\") for line in lines]


@pytest.mark.parametrize("name", SCRIPTS)
def test_the_script_is_printed_whole_and_is_right_by_its_shell(
    home: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["completion", name]) == 0
    assert capsys.readouterr().out == SCRIPTS[name]
    needs(name)
    (home / "script").write_text(SCRIPTS[name])
    checked = subprocess.run([name, "-n", "script"], capture_output=True, text=True, check=False)
    assert (checked.returncode, checked.stderr) == (0, "")


def test_a_shell_that_is_not_known(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["completion", "tcsh"])
    assert stopped.value.code == 2
    assert "'tcsh'" in capsys.readouterr().err

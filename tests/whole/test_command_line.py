"""The command line is one house: all commands are listed, an option means one thing, a slip is met with a way out."""

import errno
import json
import re
from unittest.mock import Mock

import pytest

from rosorin_compile.cli.main import commands, main
from rosorin_compile.formats import schema_names as names
from rosorin_compile.language.schema import own_schema
from support.paths import SCHEMAS

Shown = pytest.CaptureFixture[str]
COMMANDS = commands()


def help_of(capsys: Shown, *words: str) -> str:
    assert main([*words, "--help"]) == 0
    return capsys.readouterr().out


WAYS = [["extract", way] for way in ("boxes", "heightmap", "factory")]


@pytest.mark.parametrize("words", [[name] for name in COMMANDS] + WAYS, ids=" ".join)
def test_help_of_each_command(words: list[str], capsys: Shown) -> None:
    shown = help_of(capsys, *words)
    assert shown.startswith(f"Usage: rosorin-compile {' '.join(words)} [OPTIONS]")
    if words != ["extract"]:
        assert {"--format", "--quiet", "--verbose"} <= set(re.findall("--[a-z]+", shown))
        assert re.fullmatch(r"Exit codes: 0 [^.]+, 2 wrong usage\.", " ".join(shown.rpartition("\n\n")[2].split()))
    if len(words) == 1:
        assert COMMANDS[words[0]].help[1:] in " ".join(shown.split())
    assert main(["help", *words]) == 0
    assert capsys.readouterr().out == shown


def test_every_schema_is_printed(capsys: Shown) -> None:
    assert {f"{name}.schema.json" for name in names()} == {path.name for path in (SCHEMAS).glob("*.schema.json")}
    for name in names():
        assert main(["schema", name]) == 0
        shown = capsys.readouterr().out
        if name == "description":  # of which pieces stand in the folders of sections
            assert json.loads(shown) == own_schema()
        else:
            assert shown == (SCHEMAS / f"{name}.schema.json").read_text("utf-8")
        assert "json-schema.org" in json.loads(shown)["$schema"]
    assert main(["schema"]) == 0
    assert capsys.readouterr().out == (SCHEMAS / "authoring.schema.json").read_text("utf-8")


STOPPED = {
    "recursion": (RecursionError("maximum recursion depth exceeded"), 1, "the input is nested too deeply"),
    "memory": (MemoryError(), 1, "not enough memory"),
    "overflow": (OverflowError("int too large to convert to float"), 1, "a number is too large: int too large"),
    "os": (PermissionError(errno.EACCES, "Permission denied", "a.yaml"), 1, "a.yaml: Permission denied"),
    "disk": (OSError(errno.ENOSPC, "No space left on device", "out"), 1, "out: No space left on device"),
}


@pytest.mark.parametrize("name", STOPPED)
@pytest.mark.parametrize("form", ["text", "json"])
def test_an_error_that_ends_a_run_is_one_sentence(
    name: str, form: str, monkeypatch: pytest.MonkeyPatch, capsys: Shown
) -> None:
    problem, code, said = STOPPED[name]
    monkeypatch.setattr("rosorin_compile.cli.main.program", Mock(side_effect=problem))
    assert main(["frames", "--format", form]) == code
    shown = capsys.readouterr()
    assert shown.err.startswith(f"rosorin-compile: {said}")
    assert shown.err.count("\n") == 1
    assert form == "text" or said in json.loads(shown.out)["diagnostics"][0]["message"]


@pytest.mark.parametrize(("problem", "code"), [(KeyboardInterrupt(), 130), (BrokenPipeError(), 1)])
def test_an_interrupt_and_a_closed_pipe_are_silent(
    problem: BaseException, code: int, monkeypatch: pytest.MonkeyPatch, capfd: Shown
) -> None:
    monkeypatch.setattr("rosorin_compile.cli.main.program", Mock(side_effect=problem))
    with monkeypatch.context() as patched:
        patched.setattr("os.dup2", Mock())
        assert main(["frames"]) == code
    assert capfd.readouterr() == ("", "")

"""What commands answer as JSON: one envelope, as its schema says, also of errors and of wrong usage."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import jsonschema
import pytest

from rosorin_compile import __version__
from rosorin_compile.cli import main
from rosorin_compile.commands.schema import names
from support.answers import hold, validator
from support.commands import HANDY, Shown
from support.paths import SCHEMAS

BROKEN = "robot: broken\nlinks: {base_link: {}}\njoints: {lift: {type: fixed, parent: base_link, child: nope}}\n"
pytestmark = pytest.mark.usefixtures("project")
PROJECT = {**HANDY, "broken.yaml": BROKEN}
HAND = "descriptions/handy"

# A command line whose answer has a result, one with an error in the description, and one that cannot be followed.
CASES: dict[str, tuple[str, str, str]] = {
    "args": (f"args {HAND}", f"args {HAND} scale:=x", "args nobody"),
    "diff": (f"diff {HAND} {HAND} --b-arg scale=2", f"diff {HAND} broken.yaml", f"diff {HAND}"),
    "explain": (f"explain {HAND} eye_link left_f0_finger", "explain broken.yaml base_link", f"explain {HAND} nope"),
    "frames": (f"frames {HAND}", "frames broken.yaml", "frames a b"),
    "print": (f"print --list {HAND}", "print --list broken.yaml", f"print urdf {HAND}"),
    "rule": ("rule axis-zero", "", "rule nope"),
    "schema": ("schema --list", "", "schema nope"),
    "tf": (f"tf base_link eye_link {HAND}", "tf base_link nope broken.yaml", "tf base_link"),
}
# What commands answer alone, with --format json-list: their result, or the messages.
RESULTS = [name for name in CASES if name not in ("check",)]


def asked(capsys: Shown, words: str, form: str = "json") -> tuple[int, Any]:
    """Return the exit code of a command line, and what it prints as JSON."""
    capsys.readouterr()
    try:
        code = main([*words.split(), "--format", form])
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    printed = capsys.readouterr().out
    return code, json.loads(printed) if printed else None


@pytest.mark.parametrize("name", CASES)
def test_an_answer_is_as_its_schema_says(name: str, capsys: Shown) -> None:
    fine, _, _ = CASES[name]
    code, answer = asked(capsys, fine)
    assert code in (0, 1)
    assert list(answer) == ["rosorin_compile", "schema", "diagnostics", "result"]
    assert answer["rosorin_compile"] == __version__
    assert answer["schema"] == f"answer_{name.replace(' ', '_')}"
    assert answer["result"]
    hold(answer)


@pytest.mark.parametrize("name", [name for name, (_, broken, _) in CASES.items() if broken])
def test_an_error_is_in_the_answer(name: str, capsys: Shown) -> None:
    code, answer = asked(capsys, CASES[name][1])
    assert code == 1
    assert [one["rule"] for one in answer["diagnostics"] if one["severity"] == "error"]
    hold(answer)


@pytest.mark.parametrize("name", CASES)
def test_wrong_usage_is_in_the_answer(name: str, capsys: Shown) -> None:
    for words in (CASES[name][2], f"{name} --no-such-option"):
        code, answer = asked(capsys, words)
        assert code == 2
        assert answer["schema"] == f"answer_{name.replace(' ', '_')}"
        assert [one["rule"] for one in answer["diagnostics"]] == ["wrong-usage"]
        assert answer["result"] is None
        hold(answer)


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_alone_is_that_of_the_answer(name: str, capsys: Shown) -> None:
    fine, _, _ = CASES[name]
    _, answer = asked(capsys, fine)
    assert asked(capsys, fine, "json-list")[1] == answer["result"]


def test_the_old_spelling_gives_what_it_gave_and_says_the_new_one_once(capsys: Shown) -> None:
    assert main(["tf", "base_link", "eye_link", "--json"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out) == asked(capsys, "tf base_link eye_link", "json-list")[1]
    assert shown.err.count("--format json ") == 1


@pytest.mark.parametrize("words", ["nope", "--nope", "rule --format json --format xml"])
def test_a_command_line_that_calls_nothing_is_answered_too(words: str, capsys: Shown) -> None:
    code, answer = asked(capsys, words)
    assert code == 2
    assert [one["rule"] for one in answer["diagnostics"]] == ["wrong-usage"]
    hold(answer)


def test_each_schema_of_an_answer_is_one_and_can_be_printed_by_its_id(capsys: Shown) -> None:
    files = sorted(SCHEMAS.glob("answer*.schema.json"))
    assert {f"answer_{name.replace(' ', '_')}" for name in CASES} <= {file.name.partition(".")[0] for file in files}
    for file in files:
        schema = json.loads(file.read_text("utf-8"))
        jsonschema.Draft7Validator.check_schema(schema)
        assert main(["schema", schema["$id"]]) == 0
        assert capsys.readouterr().out == file.read_text("utf-8")
        assert schema["$id"] in names()


def test_a_schema_refuses_what_is_no_answer() -> None:
    answer = {"rosorin_compile": "1", "schema": "answer_rule", "diagnostics": [], "result": [{"id": "axis-zero"}]}
    assert len(list(validator("answer_rule").iter_errors(answer))) == 1
    assert len(list(validator("answer_tf").iter_errors({**answer, "result": None}))) == 1


@pytest.mark.slow
def test_an_answer_from_memory_is_the_same_bytes() -> None:
    words = [sys.executable, "-m", "rosorin_compile", "print", "--list", HAND, "--format", "json"]
    first, second = (subprocess.run(words, capture_output=True, check=True).stdout for _ in range(2))
    assert first == second
    hold(json.loads(first))

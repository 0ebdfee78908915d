"""What commands answer as JSON: one envelope, as its schema says, also of errors and of wrong usage."""

import json
from typing import Any

import jsonschema
import pytest

from rosorin_compile import __version__
from rosorin_compile.cli.main import main
from support.answers import hold, validator
from support.commands import HANDY, Shown

BROKEN = "robot: broken\nlinks: {base_link: {}}\njoints: {lift: {type: fixed, parent: base_link, child: nope}}\n"
pytestmark = pytest.mark.usefixtures("project")
PROJECT = {
    **HANDY,
    "broken.yaml": BROKEN,
    "broken.urdf": "<robot",
    "arm.urdf": '<robot name="arm"><link name="base"/></robot>',
    "package/package.xml": "<package/>",
    "node.yaml": "node: {ros__parameters: {frame_id: eye_link}}\n",
    "list.csv": "name,scale\nsmall,1\nlarge,2\n",
    "wrong.csv": "name,skale\nsmall,1\n",
}
HAND = "descriptions/handy"

# A command line whose answer has a result, one with an error in the description, and one that cannot be followed.
CASES: dict[str, tuple[str, str, str]] = {
    "all": (f"all {HAND}", "all broken.yaml", "all nobody"),
    "check": (f"check {HAND}", "check broken.yaml", "check nobody"),
    "check deployed": (f"check deployed {HAND} package", "check deployed broken.yaml package", "check deployed"),
    "check parameters": (
        f"check parameters {HAND} node.yaml",
        "check parameters broken.yaml node.yaml",
        "check parameters nobody node.yaml",
    ),
    "check physics": (f"check physics {HAND}", "check physics broken.yaml", "check physics nobody"),
    "deploy": (f"deploy {HAND} -o package", "deploy broken.yaml -o package", f"deploy {HAND} -o nowhere"),
    "import": ("import arm.urdf -o made", "import broken.urdf -o made", "import nothing.urdf"),
    "init": ("init rover", "", "init handy"),
    "package": (f"package {HAND} -o made", "package broken.yaml -o made", f"package {HAND} other -o made"),
    "sweep": (
        f"sweep {HAND} --over list.csv -o made",
        f"sweep {HAND} --over wrong.csv -o made",
        f"sweep {HAND} -o made",
    ),
    "view": (f"view {HAND} --html page.html", "view broken.yaml --html page.html", f"view {HAND}"),
    "args": (f"args {HAND}", f"args {HAND} scale:=x", "args nobody"),
    "diff": (f"diff {HAND} {HAND} --b-arg scale=2", f"diff {HAND} broken.yaml", f"diff {HAND}"),
    "explain": (f"explain {HAND} eye_link left_f0_finger", "explain broken.yaml base_link", f"explain {HAND} nope"),
    "frames": (f"frames {HAND}", "frames broken.yaml", "frames a b"),
    "print": (f"print --list {HAND}", "print --list broken.yaml", f"print {HAND} urdf"),
    "rule": ("rule axis-zero", "", "rule nope"),
    "schema": ("schema --list", "", "schema nope"),
    "tf": (f"tf {HAND} base_link eye_link", "tf broken.yaml base_link nope", "tf base_link"),
}


def asked(capsys: Shown, words: str, form: str = "json") -> tuple[int, Any]:
    capsys.readouterr()
    code = main([*words.split(), "--format", form])
    printed = capsys.readouterr().out
    return code, json.loads(printed) if printed else None


@pytest.fixture(autouse=True)
def _engine(request: pytest.FixtureRequest) -> None:
    if "check physics" in request.node.name:
        pytest.importorskip("mujoco", minversion="4")
        pytest.importorskip("trimesh")


@pytest.mark.parametrize("name", CASES)
def test_an_answer_is_as_its_schema_says(name: str, capsys: Shown) -> None:
    fine, _, _ = CASES[name]
    code, answer = asked(capsys, fine)
    assert code in (0, 1)
    assert list(answer) == ["version", "command", "diagnostics", "result"]
    assert answer["version"] == __version__
    assert answer["command"] == name
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
        assert answer["command"] == name
        assert [one["rule"] for one in answer["diagnostics"]] == ["wrong-usage"]
        assert answer["result"] is None
        hold(answer)


def test_an_answer_of_many_robots_has_each_with_what_differs(capsys: Shown) -> None:
    assert main(["all", HAND]) == 0
    assert asked(capsys, f"all {HAND}")[1]["result"]["robots"][0]["unchanged"] == ["handy.urdf"]
    code, answer = asked(capsys, f"check {HAND} broken.yaml --arg scale=2")
    first, second = answer["result"]["robots"]
    assert (code, first["fine"], second["fine"]) == (1, False, False)
    assert [one["file"] for one in (first, second)] == [f"{HAND}/robot.yaml", "broken.yaml"]
    assert first["differences"][0] == "shelf moved 1.0 m in base_link: origin z 1 -> 2 m: urdf"


@pytest.mark.parametrize("words", ["nope", "--nope"])
def test_a_command_line_that_calls_nothing_is_answered_too(words: str, capsys: Shown) -> None:
    code, answer = asked(capsys, words)
    assert code == 2
    assert [one["rule"] for one in answer["diagnostics"]] == ["wrong-usage"]
    hold(answer)


def test_the_schema_can_be_printed_and_refuses_other_documents(capsys: Shown) -> None:
    assert main(["schema", "envelope"]) == 0
    schema = json.loads(capsys.readouterr().out)
    jsonschema.Draft7Validator.check_schema(schema)
    answer = {"version": "1", "command": "rule", "diagnostics": [], "result": [{"id": "axis-zero"}]}
    assert list(validator().iter_errors(answer)) == []
    assert len(list(validator().iter_errors({**answer, "schema": "x"}))) == 1
    assert len(list(validator().iter_errors({**answer, "diagnostics": [{"rule": "x"}]}))) == 4


@pytest.mark.parametrize("form", ["github", "sarif", "markdown"])
@pytest.mark.parametrize("name", [name for name, (_, broken, _) in CASES.items() if broken])
def test_every_command_has_every_format(name: str, form: str, capsys: Shown) -> None:
    assert main([*CASES[name][1].split(), "--format", form]) == 1
    shown = capsys.readouterr().out
    if form == "sarif":
        assert json.loads(shown)["runs"][0]["results"]
    else:
        assert shown.startswith("::" if form == "github" else "## ")

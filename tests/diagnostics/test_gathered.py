"""What is said many times, but for names and numbers, is said once; nobody loses a place, an error or a stand-in."""

import json
import time
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.request import Request
from rosorin_compile.ros.parameters.files import nodes_of
from rosorin_compile.source.load import json_of, python_of, yaml_of

SPECK = "{inertial: {mass: 1 kg, inertia: {ixx: 1e-9, iyy: 1e-9, izz: 1e-9}}}"


def _robot(count: int) -> None:
    links = "".join(f"  l{index}: {SPECK}\n" for index in range(count))
    joints = "".join(f"  j{index}: {{type: fixed, parent: base, child: l{index}}}\n" for index in range(count))
    text = f"robot: made\nlinks:\n  base: {{}}\n{links}joints:\n{joints}outputs: {{urdf: {{file: made.urdf}}}}\n"
    Path("made.yaml").write_text(text, "utf-8")


@pytest.mark.usefixtures("home")
@pytest.mark.parametrize("count", [1, 2, 6])
def test_all_says_it_once(capsys: pytest.CaptureFixture[str], count: int):
    _robot(count)
    assert main(["all", "made.yaml"]) == 0
    said = capsys.readouterr().err
    assert said.count("warning[inertia-implausible]") == 1
    assert (f", and {count - 1} more of this kind" in said) == (count > 1)
    assert said.count(": and here\n") == count - 1


@pytest.mark.usefixtures("home")
def test_all_says_of_an_imported_robot_what_the_import_said_as_often(capsys: pytest.CaptureFixture[str]):
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="1e-9" ixy="0" ixz="0" iyy="1e-9" iyz="0" izz="1e-9"/></inertial>'
    )
    links = "".join(f'<link name="l{number}">{number * " "}{inertial}</link>' for number in range(4))
    joint = '<joint name="j{0}" type="fixed"><parent link="base"/><child link="l{0}"/></joint>'
    joints = "".join(joint.format(number) for number in range(4))
    Path("made.urdf").write_text(f'<robot name="made"><link name="base"/>{links}{joints}</robot>', "utf-8")
    counts = []
    for words in (["import", "made.urdf", "--no-parts"], ["all"]):
        assert main(words) == 0
        counts.append(capsys.readouterr().err.count("warning[inertia-implausible]"))
    assert counts == [1, 1]


@pytest.mark.usefixtures("home")
def test_a_program_gets_all(capsys: pytest.CaptureFixture[str]):
    _robot(9)
    assert main(["all", "made.yaml", "--format", "json"]) == 0
    assert [one["rule"] for one in json.loads(capsys.readouterr().out)["diagnostics"]] == ["inertia-implausible"] * 9


def test_a_description_with_20_000_unknown_keys_is_reported_within_5_s(tmp_path: Path):
    keys = "".join(f"k{number}: 1\n" for number in range(20_000))
    (tmp_path / "robot.yaml").write_text(f"robot: r\nlinks: {{base: {{}}}}\n{keys}", "utf-8")
    begin = time.process_time()
    found = Request.of(tmp_path / "robot.yaml").compile().diagnostics
    assert time.process_time() - begin < 5
    assert len(found) == 20_000
    assert [bool(one.help) for one in found] == [True] * 200 + [False] * 19_800


# Texts that are nested too deep: each parser says so, with the place, before anything can run out of stack.


DEEP = 100_000

leaves = st.none() | st.booleans() | st.integers() | st.text('ab[]{}\\"-?: \n', max_size=8)
values = st.recursive(leaves, lambda inner: st.lists(inner) | st.dictionaries(st.text('ab[{\\"', max_size=3), inner))


@given(values)
def test_what_is_not_deep_is_read_as_ever(value: object) -> None:
    assert json_of(json.dumps(value)) == value
    assert json_of(json.dumps(value, indent=1).encode()) == value
    for flow in (True, False):
        text = yaml.safe_dump(value, default_flow_style=flow)
        assert yaml_of(text) == value


def test_nothing_ends_the_program() -> None:
    for text in ("[" * DEEP + "]" * DEEP, "{a: " * DEEP, "- " * 5_000):
        with pytest.raises(ValueError, match="nested deeper"):
            yaml_of(text)
    with pytest.raises(json.JSONDecodeError, match="line 2 column 101"):
        json_of("\n" + "[" * DEEP)
    for text in ("-" * DEEP + "1", "x" + ".x" * DEEP, "1" + "+1" * 2_000, "[" * 5_000 + "]" * 5_000):
        with pytest.raises((ValueError, SyntaxError)):
            python_of(text)


@pytest.mark.parametrize(
    ("file", "text", "expected"),
    [
        ("robot.yaml", "robot: " + "[" * DEEP, "robot.yaml:1:1007: error[yaml-too-deep]"),
        (
            "robot.urdf",
            '<robot name="r">\n' + "<a>" * DEEP + "</a>" * DEEP + "</robot>",
            "robot.urdf:2:599: error[xml-too-deep]",
        ),
        ("robot.json", '{"links": ' + "[" * DEEP + "]" * DEEP + "}", "robot.json:1:110: error[json-syntax]"),
    ],
)
def test_a_file_that_is_nested_too_deep_has_its_place(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    file: str,
    text: str,
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(file).write_text(text)
    command = ["all", file] if file.endswith(".yaml") else ["import", file, "-o", "made"]
    assert main(command) == 1
    assert expected in capsys.readouterr().err


@pytest.mark.slow
def test_a_parameter_file_that_is_nested_too_deep_is_refused() -> None:
    for text in ("[" * DEEP, "{a: " * DEEP):
        with pytest.raises(ValueError, match="nested deeper"):
            nodes_of(text)

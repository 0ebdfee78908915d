"""What is said many times, but for names and numbers, is said once; nobody loses a place, an error or a stand-in."""

import json
import time
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.request import Request
from rosorin_compile.ros.parameters.files import nodes_of
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Source, Span, Use
from rosorin_compile.source.load import MAX_NESTING, json_of, python_of, yaml_of
from rosorin_compile.source.messages import arrange, gathered

FILE = Source("robot.yaml", "robot: made\n")
SPECK = "{inertial: {mass: 1 kg, inertia: {ixx: 1e-9, iyy: 1e-9, izz: 1e-9}}}"


def _one(line: int, message: str, severity: str = WARNING, rule: str = "some-rule") -> Diagnostic:
    return Diagnostic(rule, severity, message, Span(FILE, line, 3))


def test_near_equal_ones_are_the_first_with_the_places_of_the_others():
    said = [_one(line, f'link "l{line}" has {line}.5 kg in 1e-0{line} m') for line in range(1, 10)]
    other = _one(20, "this is another thing")
    (one, last) = gathered([*said, other], [WARNING, NOTE])
    assert one.message == 'link "l1" has 1.5 kg in 1e-01 m, and 8 more of this kind'
    places = [(related.message, related.span and related.span.line) for related in one.related]
    assert places == [*(("and here", line) for line in range(2, 8)), ("and in 2 more places", None)]
    assert last == other


def test_what_was_related_stays_first():
    related = Related("the shape", Span(FILE, 1, 1))
    said = [replace(_one(line, f"{line} kg"), related=(related,)) for line in (1, 2)]
    (one,) = gathered(said, [WARNING])
    assert [item.message for item in one.related] == ["the shape", "and here"]


def test_one_mistake_of_a_part_is_told_once_with_its_uses():
    uses = [Use(f'part "arm" used here as "{name}"', Span(FILE, 5, 3)) for name in "abcdefghij"]
    said = [
        replace(_one(1, f'joint "{use.message[-2]}_j" [{i}] is wrong'), related=(use,)) for i, use in enumerate(uses)
    ]
    (one,) = arrange(said)
    assert one.message == 'joint "a_j" [0] is wrong'
    assert one.related == (*uses[:7], Related("and 3 more", None))


def test_keys_that_an_entry_lacks_are_told_one_by_one():
    said = [
        _one(1, f'servo group "{group}" needs the key "{key}"', rule="missing-key") for group in "sl" for key in "xyz"
    ]
    assert [one.message[-3:] for one in arrange(said)] == ['"x"', '"y"', '"z"']
    assert all(one.related == (Related("and 1 more entry that uses this value", None),) for one in arrange(said))


def test_a_value_that_several_kinds_of_entries_use_is_told_once():
    owners = ("source", 'link "a" source', 'joint "b" source', "moveit groups x source")
    (one,) = arrange(_one(1, f'{owner} has no key "b"', rule="unknown-key") for owner in owners)
    assert one.related == (Related("and 3 more entries that use this value", None),)
    others = ('link "a" xyz[0] is a length (m), but 5 kg is a mass', 'link "a" rpy[1] is an angle, but 5 kg is a mass')
    assert len(arrange(_one(1, message, rule="wrong-unit") for message in others)) == 2


@pytest.mark.parametrize(
    "said",
    [
        [_one(line, f"{line} kg", ERROR) for line in range(9)],
        [_one(line, f"{line} kg", NOTE, "stand-in") for line in range(9)],
        [_one(line, "the same words", WARNING, f"rule-{line}") for line in range(9)],
        [_one(line, f"{'x' * line} differs") for line in range(1, 9)],
        [Diagnostic("some-rule", WARNING, f"{line} s") for line in range(9)],  # of a recording: no place to go to
    ],
    ids=["errors", "stand-ins", "rules", "words", "no place"],
)
def test_told_one_by_one(said: list[Diagnostic]):
    assert gathered(said, [WARNING, NOTE]) == said


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


@pytest.mark.parametrize("depth", [MAX_NESTING, MAX_NESTING + 1])
@pytest.mark.parametrize(
    "text",
    [
        lambda depth: "[" * depth + "]" * depth,
        lambda depth: '{"a": ' * depth + "1" + "}" * depth,
        lambda depth: '{"]": [' * (depth // 2) + "[1]" * (depth % 2) + "]}" * (depth // 2),
    ],
)
def test_json_has_a_limit(text, depth: int) -> None:
    if depth <= MAX_NESTING:
        assert json_of(text(depth))
    else:
        with pytest.raises(ValueError, match="nested deeper"):
            json_of(text(depth))


def test_nothing_ends_the_program() -> None:
    for text in ("[" * DEEP + "]" * DEEP, "{a: " * DEEP, "- " * 5_000):
        with pytest.raises(ValueError, match="nested deeper"):
            yaml_of(text)
    with pytest.raises(json.JSONDecodeError, match="line 2 column 101"):
        json_of("\n" + "[" * DEEP)
    for text in ("-" * DEEP + "1", "x" + ".x" * DEEP, "1" + "+1" * 2_000, "[" * 5_000 + "]" * 5_000):
        with pytest.raises((ValueError, SyntaxError)):
            python_of(text)


@pytest.mark.parametrize("text", ["a: !!bool maybe", "a: !!int ''", "a: !!python/object:os.x {}", "a: ["])
def test_what_is_no_yaml_is_an_error(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        yaml_of(text)


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

"""Texts that are nested too deep: each parser says so, with the place, before anything can run out of stack."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.ros.parameters.files import value_of
from rosorin_compile.source.bounded import MAX_DEPTH, json_of, python_of, yaml_of

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


@pytest.mark.parametrize("depth", [MAX_DEPTH, MAX_DEPTH + 1])
@pytest.mark.parametrize(
    "text",
    [
        lambda depth: "[" * depth + "]" * depth,
        lambda depth: '{"a": ' * depth + "1" + "}" * depth,
        lambda depth: '{"]": [' * (depth // 2) + "[1]" * (depth % 2) + "]}" * (depth // 2),
    ],
)
def test_json_and_yaml_have_one_limit(text, depth: int) -> None:
    for read in (json_of, yaml_of):
        if depth <= MAX_DEPTH:
            assert read(text(depth))
        else:
            with pytest.raises(ValueError, match="nested deeper"):
                read(text(depth))


@pytest.mark.parametrize("depth", [MAX_DEPTH, MAX_DEPTH + 1])
@pytest.mark.parametrize(
    "text",
    [
        lambda depth: "- " * depth + "x",
        lambda depth: "".join(f"{' ' * level}a:\n" for level in range(depth)) + " " * depth + "b",
        lambda depth: (
            "".join(f"{' ' * level}a:\n{' ' * level}-\n" for level in range(depth // 2))
            + (" " * (depth // 2) + "c: [d]"[: 3 + 3 * (depth % 2)])
        ),
    ],
)
def test_blocks_of_yaml_have_the_limit_too(text, depth: int) -> None:
    try:
        found = yaml_of(text(depth))
    except ValueError:
        found = None
    assert (found is not None) == (_depth(text(depth)) <= MAX_DEPTH)


def _depth(text: str) -> int:
    depth = most = 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        most = max(most, depth)
    return most


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
    "text", ["a: !!bool maybe", "a: !!int ''", "a: 2021-99-99", "a: !!python/object:os.x {}", "a: ["]
)
def test_what_is_no_yaml_is_an_error(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        yaml_of(text)


@pytest.mark.parametrize(
    ("file", "text", "expected"),
    [
        ("robot.yaml", "robot: " + "[" * DEEP, "robot.yaml:1:68: error[yaml-too-deep]"),
        (
            "robot.urdf",
            '<robot name="r">\n' + "<a>" * DEEP + "</a>" * DEEP + "</robot>",
            "robot.urdf:2:599: error[xml-too-deep]",
        ),
        (
            "robot.json",
            '{"links": ' + "[" * DEEP + "]" * DEEP + "}",
            "robot.json:1:110: error[json-syntax]",
        ),
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
        with pytest.raises(ValueError, match="nested too deeply"):
            value_of(text)

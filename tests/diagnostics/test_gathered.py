"""What is said many times, but for names and numbers, is said once; nobody loses a place, an error or a stand-in."""

import json
import time
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.request import Request
from rosorin_compile.ros.parameter_files import nodes_of
from rosorin_compile.source.load import json_of, python_of, yaml_of


def test_a_description_with_20_000_unknown_keys_is_reported(tmp_path: Path):
    """The time grows linearly: ten times as many keys take about ten times as long, not a hundred times."""
    file, seconds = tmp_path / "robot.yaml", {}
    for number in (2_000, 20_000):
        keys = "".join(f"k{key}: 1\n" for key in range(number))
        file.write_text(f"robot: r\nlinks: {{base: {{}}}}\n{keys}", "utf-8")
        begin = time.process_time()
        found = Request.from_arguments(file).compile().diagnostics
        seconds[number] = time.process_time() - begin
        assert [bool(one.help) for one in found] == [True] * 200 + [False] * (number - 200)
    assert seconds[20_000] < 40 * seconds[2_000]


# Texts that are nested too deep: each parser says so, with the place, before anything can run out of stack.


DEEP = 100_000

leaves = st.none() | st.booleans() | st.integers(1 - 10**18, 10**18 - 1) | st.text('ab[]{}\\"-?: \n', max_size=8)
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


@pytest.mark.slow
def test_a_parameter_file_that_is_nested_too_deep_is_refused() -> None:
    for text in ("[" * DEEP, "{a: " * DEEP):
        with pytest.raises(ValueError, match="nested deeper"):
            nodes_of(text)

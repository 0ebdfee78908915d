"""Parameter files of ROS 2 nodes: names, namespaces, wildcards, values of YAML 1.1, places, and what is no such."""

from __future__ import annotations

import math

import pytest

from rosorin_compile.diagnostics import Source
from rosorin_compile.frontend.load import LoadError
from rosorin_compile.tools.parameter_files import ParameterFile, matches, of_node, read_source

FILE = """\
/**:
  ros__parameters: {use_sim_time: yes, rate: 1}
base:
  controller_manager:
    ros__parameters:
      rate: 2
      wheels.radius: 0.05
      wheels: {names: [a, b], mixed: [0, 0.5]}
/other/node:
  ros__parameters:
    text: "yes"
    size: 12.5 mm
    path: $(find-pkg-share robot)/map.yaml
    bad: nan
"""


def parsed(text: str) -> ParameterFile:
    return read_source(Source("params.yaml", text))


def test_nodes_have_full_names_and_keys_with_dots() -> None:
    file = parsed(FILE)
    assert [node.name for node in file.nodes] == ["/**", "/base/controller_manager", "/other/node"]
    values = file.nodes[1].values
    assert {key: value.value for key, value in values.items()} == {
        "rate": 2,
        "wheels.radius": 0.05,
        "wheels.names": ["a", "b"],
        "wheels.mixed": [0, 0.5],
    }
    assert [value.mixed for value in values.values()] == [False, False, False, True]
    radius = values["wheels.radius"]
    assert (radius.span.line, radius.span.column, radius.key.column) == (7, 22, 7)


def test_what_comes_later_wins_and_says_where_it_stands() -> None:
    later = parsed("/base/*: {ros__parameters: {rate: 3}}\n")
    values = of_node([parsed(FILE), later], "/base/controller_manager")
    assert (values["rate"].value, values["rate"].by) == (3, "/base/*")
    assert (values["use_sim_time"].value, values["use_sim_time"].by) == (True, "/**")


def test_values_are_those_of_rcl() -> None:
    values = parsed(FILE).nodes[2].values
    assert (values["text"].value, values["size"].value) == ("yes", "12.5 mm")
    assert math.isnan(values["bad"].value)
    assert [values[key].substituted for key in ("path", "size")] == [True, False]


@pytest.mark.parametrize(
    ("pattern", "name", "fits"),
    [
        ("/**", "/a/b/c", True),
        ("/*", "/a/b", False),
        ("/*", "/a", True),
        ("/a/**", "/a/b/c", True),
        ("/**/b", "/b", True),
        ("/a.b", "/aXb", False),
    ],
)
def test_patterns(pattern: str, name: str, fits: bool) -> None:
    assert matches(pattern, name) is fits


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("ros__parameters: {a: 1}\n", (1, 1), "ros__parameters stands without the name of a node"),
        ("node: {ros__parameters: {}, a: 1}\n", (1, 29), '"a" stands outside ros__parameters: no node has it'),
        ("a: {b: 1}\n", (1, 1), "params.yaml has no parameters of a ROS 2 node: nothing stands under ros__parameters"),
        ("node: {ros__parameters: 3}\n", (1, 8), "ros__parameters is a mapping of keys to values"),
        (
            "node: {ros__parameters: {a: [[1]]}}\n",
            (1, 29),
            '"a" is a list of lists or mappings: no parameter can be that',
        ),
        (
            "- 1\n",
            (1, 1),
            "params.yaml has no parameters of a ROS 2 node: nothing stands under ros__parameters",
        ),
    ],
)
def test_what_is_no_parameter_file(text: str, place: tuple[int, int], message: str) -> None:
    (told,) = parsed(text).diagnostics
    assert told.span is not None
    assert ((told.span.line, told.span.column), told.rule, told.message) == (place, "parameter-file", message)


def test_what_is_no_yaml_has_a_place() -> None:
    with pytest.raises(LoadError) as raised:
        parsed("a: [1\n")
    assert raised.value.diagnostic.span is not None

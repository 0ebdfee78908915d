"""Parameter files of ROS 2 nodes as rcl reads them: names, namespaces, wildcards, values, places, what is refused."""

import math
from typing import Any

import pytest
import yaml

from rosorin_compile.ros.parameter_files import NoParameters, Section, nodes_of, read_sections
from rosorin_compile.source.diagnostics import Source
from support.paths import data_text

CASES = yaml.safe_load(data_text("cases/files_of_parameters.yaml"))
FILE = data_text("robots/files_of_parameters.yaml")


def parsed(text: str) -> list[Section]:
    return read_sections(Source("params.yaml", text))[0]


def value(text: str) -> Any:
    return parsed(f"node: {{ros__parameters: {{a: {text}}}}}\n")[0].parameters["a"].value


def test_nodes_have_full_names_and_keys_with_dots() -> None:
    sections = parsed(FILE)
    assert [section.name for section in sections] == ["/**", "/base/controller_manager", "/other/node"]
    values = sections[1].parameters
    assert {key: one.value for key, one in values.items()} == {
        "rate": 2,
        "wheels.radius": 0.05,
        "wheels.names": ["a", "b"],
    }
    radius = values["wheels.radius"]
    assert (radius.span.line, radius.span.column, radius.key.column) == (7, 22, 7)


def test_what_a_launch_file_puts_in_has_no_type() -> None:
    values = parsed(FILE)[2].parameters
    assert [key for key, one in values.items() if one.has_substitution] == ["path", "mixed"]


@pytest.mark.parametrize(("text", "wanted"), CASES["values_are_those_of_rcl"])
def test_values_are_those_of_rcl(text: str, wanted: Any) -> None:
    found = value(text)
    assert (found, type(found)) == (wanted, type(wanted))


def test_not_a_number() -> None:
    assert math.isnan(value(".nan"))
    assert math.isnan(value("nan"))


@pytest.mark.parametrize(("pattern", "name", "fits"), CASES["patterns"])
def test_patterns(pattern: str, name: str, fits: bool) -> None:
    section = parsed(f"{pattern}: {{ros__parameters: {{a: 1}}}}\n")[0]
    assert section.matches(name) is fits


@pytest.mark.parametrize(("text", "place"), CASES["what_rcl_refuses"])
def test_what_rcl_refuses(text: str, place: list[int]) -> None:
    with pytest.raises(NoParameters) as raised:
        parsed(text)
    found = raised.value.diagnostic
    assert found.span is not None
    assert ([found.span.line, found.span.column], found.rule) == (place, "parameters-syntax")


@pytest.mark.parametrize(
    ("text", "told"), [("a: [1\n", "is not closed"), ("a: {" * 200 + "}" * 200, "nested deeper than 40 levels")]
)
def test_what_is_no_yaml_or_too_deep_has_a_place(text: str, told: str) -> None:
    with pytest.raises(NoParameters) as raised:
        parsed(text)
    assert raised.value.diagnostic.span is not None
    assert told in raised.value.diagnostic.message


def test_a_node_may_be_in_forty_mappings() -> None:
    assert nodes_of(f"{'{a: ' * 40}{{ros__parameters: {{rate: 1}}}}{'}' * 40}") == {"/".join("a" * 40): {"rate": 1}}


@pytest.mark.parametrize(("text", "told", "wanted"), CASES["mappings_in_lists_and_empty_lists"])
def test_mappings_in_lists_and_empty_lists(text: str, told: str, wanted: dict[str, Any]) -> None:
    sections, found = read_sections(Source("params.yaml", f"n: {{ros__parameters: {{{text}, z: 1}}}}\n"))
    assert {key: one.value for key, one in sections[0].parameters.items()} == wanted
    assert [(one.rule, one.severity) for one in found] == ([("parameters-syntax", "warning")] if told else [])
    assert all(told in one.message for one in found)


@pytest.mark.parametrize("text", ["a: {b: {}}\n", "{}\n"])
def test_a_file_of_nothing_but_empty_nodes_is_told_and_no_mistake(text: str) -> None:
    """As rcl takes it; with parameters elsewhere nobody is missed."""
    sections, (told,) = read_sections(Source("params.yaml", text))
    assert (sections, told.severity) == ([], "warning")
    assert told.message == "no node has parameters here: there is no ros__parameters"
    assert read_sections(Source("params.yaml", "# nothing yet\n")) == ([], [])


@pytest.mark.parametrize("name", ["$(var ns)/node", "<robot_namespace>/node", "/**/node", "/a/*", "a/b"])
def test_names_that_are_put_in_or_match_are_no_mistakes(name: str) -> None:
    assert len(parsed(f'"{name}": {{ros__parameters: {{a: 1}}}}\n')) == 1
    assert len(parsed("n: {m: {ros__parameters: {a: 1}}, ros__parameters: {a: 1}}\n")) == 2

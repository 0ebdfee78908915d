"""The parameters of a node by their full names: what is nested too deeply for any of them is one value."""

from __future__ import annotations

from typing import Any

import pytest

from rosorin_compile.ros.parameters.files import _flat, nodes_of


def nested(depth: int) -> dict[str, Any]:
    return {"a": nested(depth - 1)} if depth else {"end": 1}


def test_parameters_have_the_names_of_all_that_they_stand_in() -> None:
    assert dict(_flat({"a": {"b": 1, "c": {"d": [2]}}, "e": None}, "", 0)) == {"a.b": 1, "a.c.d": [2], "e": None}
    assert dict(_flat(nested(40), "", 0)) == {"a." * 40 + "end": 1}


def test_what_is_nested_too_deeply_is_one_value() -> None:
    assert dict(_flat(nested(41), "", 0)) == {"a." * 40 + "a": {"end": 1}}
    assert dict(_flat(nested(50), "", 0)) == {"a." * 40 + "a": nested(9)}


def in_namespaces(depth: int) -> str:
    """Return a parameter file whose node stands in so many mappings."""
    return f"{'{a: ' * depth}{{ros__parameters: {{rate: 1}}}}{'}' * depth}"


def test_a_node_may_stand_in_forty_mappings_and_no_more() -> None:
    assert nodes_of(in_namespaces(40)) == {"/".join("a" * 40): {"rate": 1}}
    with pytest.raises(ValueError, match="it is nested too deeply"):
        nodes_of(in_namespaces(41))

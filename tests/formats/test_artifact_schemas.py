"""The schemas of the JSON artifacts: every property is described, every number has its unit."""

from __future__ import annotations

import jsonschema
import pytest

from support.schemas import properties, schema


@pytest.mark.parametrize("name", ["static_tf", "robot_model", "page"])
def test_every_property_is_described_with_its_unit(name: str) -> None:
    described = schema(name)
    jsonschema.Draft7Validator.check_schema(described)
    found = properties(described)
    assert len(found) > 5
    for path, inner in found:
        if inner == {"type": "null"} or "$ref" in inner:
            continue
        assert inner.get("description"), path
        if inner.get("type") == "number":
            words = ("metres", "radians", "without a unit", "kilograms", "kg m^2")
            assert any(word in inner["description"] for word in words), path
        if inner.get("type") == "object":
            assert inner.get("additionalProperties") is not None, path

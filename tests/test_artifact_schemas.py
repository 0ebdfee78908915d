"""The schemas of the JSON artifacts: every property is described, every number has its unit."""

from __future__ import annotations

import json
from typing import Any

import jsonschema
import pytest

from robots import ROOT


def properties(schema: Any, path: str = "") -> list[tuple[str, Any]]:
    """Return each property and each list item of a schema with its path."""
    found = []
    if isinstance(schema, dict):
        for name, inner in schema.get("properties", {}).items():
            found += [(f"{path}/{name}", inner), *properties(inner, f"{path}/{name}")]
        inner_schemas = [schema.get("items"), schema.get("additionalProperties"), *schema.get("oneOf", [])]
        for inner in [*inner_schemas, *schema.get("prefixItems", [])]:
            found += ([(f"{path}[]", inner)] if isinstance(inner, dict) else []) + properties(inner, f"{path}[]")
    return found


@pytest.mark.parametrize("name", ["static_tf", "robot_model"])
def test_every_property_is_described_with_its_unit(name: str) -> None:
    schema = json.loads((ROOT / "schemas" / f"{name}.schema.json").read_text("utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    found = properties(schema)
    assert len(found) > 5
    for path, inner in found:
        if inner == {"type": "null"}:
            continue
        assert inner.get("description"), path
        if inner.get("type") == "number":
            words = ("metres", "radians", "without a unit")
            assert any(word in inner["description"] for word in words), path
        if inner.get("type") == "object":
            assert inner.get("additionalProperties") is not None, path

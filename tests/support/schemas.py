"""The JSON schemas of the artifacts and of what commands print, and how they are walked through."""

from __future__ import annotations

import json
from typing import Any

from rosorin_compile.language.schema import own_schema
from support.paths import SCHEMAS


def schema(name: str) -> Any:
    """Return a schema of the folder schemas."""
    if name == "description":  # of which pieces stand in the folders of sections
        return own_schema()
    return json.loads((SCHEMAS / f"{name}.schema.json").read_text("utf-8"))


def properties(described: Any, path: str = "") -> list[tuple[str, Any]]:
    """Return each property and each list item of a schema with its path, and what it names in $defs once."""
    found = []
    if isinstance(described, dict):
        found += [one for name, inner in described.get("$defs", {}).items() for one in properties(inner, f"#{name}")]
        for name, inner in described.get("properties", {}).items():
            found += [(f"{path}/{name}", inner), *properties(inner, f"{path}/{name}")]
        items = described.get("items")
        inner_schemas = [*(items if isinstance(items, list) else [items]), described.get("additionalProperties")]
        for inner in [*inner_schemas, *described.get("oneOf", [])]:
            found += ([(f"{path}[]", inner)] if isinstance(inner, dict) else []) + properties(inner, f"{path}[]")
    return found

"""The JSON Schemas of descriptions and artifacts."""

from __future__ import annotations

import json

from rosorin_compile.language.schema import authoring_schema, schema
from rosorin_compile.source.project import data_folder

from . import FORMATS

# The schemas that are not of a format, and their subjects.
_NAMES = {
    "authoring": "a description as written, with expressions, parts and loops (default)",
    "description": "a description after includes, arguments and expressions are evaluated",
    "robot_diff": "the result of diff --format json",
    "recording": "the result of verify --format json",
    "envelope": "the output of any command with --format json",
}


def schema_names() -> dict[str, str]:
    """Return the names of the schemas, each with its subject."""
    formats = {one.schema: f"the artifact {one.name}" for one in FORMATS.values() if one.schema}
    return {**_NAMES, **formats}


def schema_text(name: str) -> str:
    """Return a schema as text; those of descriptions contain the sections of plug-ins."""
    if name == "description":
        return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"
    if name == "authoring":
        return authoring_schema()
    return (data_folder("schemas") / f"{name}.schema.json").read_text("utf-8")

"""JSON output of commands, validated against the schema of the envelope."""

import json
from functools import cache
from typing import Any

import jsonschema

from rosorin_compile.cli import console
from support.paths import SCHEMAS

_envelope = console.envelope


@cache
def validator(name: str = "envelope") -> jsonschema.Draft7Validator:
    """Return the validator of a schema of this project."""
    return jsonschema.Draft7Validator(json.loads((SCHEMAS / f"{name}.schema.json").read_text("utf-8")))


def hold(answer: dict[str, Any]) -> None:
    """Raise AssertionError for an answer that does not match the schema."""
    wrong = [f"{list(one.path)}: {one.message[:200]}" for one in validator().iter_errors(answer)]
    assert wrong == []


def held_envelope(answer: console.Console) -> dict[str, object]:
    """Return an answer as it is printed, which is as its schema says."""
    made = _envelope(answer)
    hold(json.loads(json.dumps(made)))
    return made
